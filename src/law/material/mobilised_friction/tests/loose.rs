//! Hardening that follows the solid volume fraction.

use super::*;

/// Discs whose loose packings mobilise friction over a longer strain.
const SLOWER: MobilisedConstants =
    MobilisedConstants { hardening_strain: 8e-3, hardening_fraction_width: Some(0.0085), ..MobilisedConstants::DISCS };

/// Half of the friction is mobilised where g is a: in dense and in loose material under an isotropic stress that stays, what is
/// sheared beyond the elastic strain. A packing that starts loose needs ten times the strain of a dense one.
#[test]
fn loose_material_hardens_over_a_longer_strain() {
    let law = MobilisedFriction::of(&SLOWER);
    let half = |fraction: f64| {
        let rows = simple_shear(&law, 200e3, fraction, 2e-5, 0.05);
        let mobilised = |row: &element::Row<Plane>| {
            let [peak, _] = SLOWER.ratios(2, row.memory.fraction);
            ratio(&law, &row.memory) / peak
        };
        let row = rows.into_iter().find(|row| mobilised(row) >= 0.5).expect("it comes to half of its friction");
        // With a of the fraction that it has come to, one step behind.
        close(row.memory.hardening, hardening(&SLOWER, row.memory.fraction), row.memory.hardening, 0.02);
        row.strain
    };
    let (dense, loose) = (half(0.843), half(0.797));
    assert!(dense < 2e-3 && loose > 10.0 * dense, "{dense} and {loose}");
    // In the end both have all of it.
    for fraction in [0.797, 0.843] {
        let rows = simple_shear(&law, 200e3, fraction, 1e-3, 2.5);
        let end = &rows.last().unwrap().memory;
        let kappa = end.hardening / (SLOWER.hardening_strain + end.hardening);
        close(ratio(&law, end), kappa * law.sine_critical, 1.0, 1e-3);
        close(end.fraction, law.fraction_critical, 1.0, 3e-4);
    }
}

/// Of no w and of an endless one a is a_cs to the bit, and so is all that follows.
fn endless<S: Space>(seed: u64) {
    let mut random = Random(seed);
    for _ in 0..100 {
        let constants = MobilisedConstants { hardening_fraction_width: None, ..random.constants(S::DIMENSION) };
        let law = MobilisedFriction::of(&constants);
        let wide = MobilisedFriction::of(&MobilisedConstants { hardening_fraction_width: Some(1e18), ..constants });
        assert_eq!(law.hardening_strain_at(random.between(0.3, 1.0)), constants.hardening_strain);
        let scale = random.magnitude(3.0, 6.0);
        let mut memories = [&law, &wide].map(|law| isotropic::<S>(law, scale, constants.fraction.unwrap()));
        for _ in 0..100 {
            let increment = random.tensor::<S>(0.3 * scale / law.bulk_modulus);
            let [narrow, other] = &mut memories;
            let stresses = (carry::<S>(&law, narrow, &increment), carry::<S>(&wide, other, &increment));
            assert!(narrow.numbers() == other.numbers() && stresses.0 == stresses.1, "{narrow:?} and {other:?}");
        }
    }
}

#[test]
fn an_endless_width_is_the_law_without_one() {
    endless::<Plane>(13);
    endless::<Solid>(14);
}

/// a of the start of a step is a step behind; steps are as long as those that the law without w converges with.
#[test]
fn hardening_that_follows_the_fraction_does_not_hang_on_the_step() {
    let law = MobilisedFriction::of(&SLOWER);
    for (stress, fraction, longest) in [(400e3, 0.843, 2.5e-4), (200e3, 0.843, 1e-4), (200e3, 0.797, 1e-4)] {
        let fine = simple_shear(&law, stress, fraction, 1e-5, 0.06);
        for step in [0.2 * longest, longest] {
            let each = (step / 1e-5f64).round() as usize;
            for (row, other) in simple_shear(&law, stress, fraction, step, 0.06).iter().zip(fine.chunks(each)) {
                let other = other.last().unwrap();
                close(row.ratio, other.ratio, 1.0, if step == longest { 0.002 } else { 4e-4 });
                close(row.volume, other.volume, 1.0, 2e-4);
            }
        }
    }
}

/// Within the share of its friction that is there from the start material is elastic, however often it is sheared; beyond it friction is what
/// the equation says of g.
fn starts_with_a_share<S: Space>(seed: u64) {
    let (mut random, mut flowed) = (Random(seed), 0);
    for _ in 0..300 {
        let share = random.between(0.05, 0.6);
        // Without what the modulus loses in a step, and without a bound of contraction, the stress is on the cone to rounding.
        let constants = MobilisedConstants {
            hardening_start: share,
            shear_degradation: 0.0,
            cohesion: 0.0,
            ..random.constants(S::DIMENSION)
        };
        let law = MobilisedFriction::of(&constants);
        let fraction = constants.fraction.unwrap();
        let [peak, _] = constants.ratios(S::DIMENSION, fraction);
        let pressure = random.magnitude(3.0, 6.0);
        let borne = peak * (law.attraction + pressure);
        let begun = isotropic::<S>(&law, pressure, fraction);
        let mut memory = begun;
        let mut shear = random.tensor::<S>(1.0);
        shear = (shear + S::transpose(&shear)) * 0.5;
        shear -= S::identity() * (S::trace(&shear) / S::DIMENSION as f64);
        // q is 2 G h of a deviatoric strain.
        let unit = shear * (1.0 / (0.5 * shear.dot(&shear)).sqrt());
        let to = |part: f64| unit * (part * borne / (2.0 * law.shear_modulus));
        for turn in 0..20 {
            let sign = if turn % 2 == 0 { 1.0 } else { -1.0 };
            for part in [0.95 * share * sign, -0.95 * share * sign] {
                carry::<S>(&law, &mut memory, &to(part));
                assert_eq!((memory.plastic_strain, memory.hardening, memory.fraction), (0.0, 0.0, fraction));
            }
        }
        let mut memory = begun;
        for _ in 0..50 {
            let [peak, _] = constants.ratios(S::DIMENSION, memory.fraction);
            let a = hardening(&constants, memory.fraction);
            carry::<S>(&law, &mut memory, &to(0.02));
            if memory.plastic_strain > 0.0 && memory.gap == 0.0 {
                let kappa = share + (1.0 - share) * memory.hardening / (a + memory.hardening);
                close(ratio(&law, &memory), kappa * peak, 1.0, 1e-8);
                flowed += 1;
            }
        }
    }
    assert!(flowed > 3_000, "{flowed}");
}

#[test]
fn material_is_elastic_within_the_share_it_starts_with() {
    starts_with_a_share::<Plane>(15);
    starts_with_a_share::<Solid>(16);
}
