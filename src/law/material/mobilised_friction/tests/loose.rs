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
