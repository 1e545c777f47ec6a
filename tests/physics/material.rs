//! The continuum's law against closed forms: Hencky elasticity, the return to the cone and to its apex, separation, the
//! solid volume fraction's own equation, and objectivity.

use scree::base::math;
use scree::base::space::Plane;
use scree::base::symmetric::Symmetric;
use scree::law::material::{CriticalDruckerPrager, CriticalMemory, MaterialLaw};

use crate::worlds::{Tensor, material};

const PRESSURE: f64 = 400e3;
const DT: f64 = 1e-6;

/// The law with a cohesion that it never overcomes here.
fn elastic() -> CriticalDruckerPrager {
    CriticalDruckerPrager { cohesion: 1e12, ..material() }
}

fn start(law: &CriticalDruckerPrager, pressure: f64, fraction: f64) -> CriticalMemory<Plane> {
    MaterialLaw::<Plane>::start(law, &(Tensor::identity() * -pressure), fraction)
}

/// Carries a memory over one increment of deformation `F = I + increment`.
fn carry(law: &CriticalDruckerPrager, memory: &mut CriticalMemory<Plane>, increment: Tensor) -> Tensor {
    MaterialLaw::<Plane>::update(law, &(increment * (1.0 / DT)), DT, memory)
}

/// Equal to within `share` of a magnitude.
fn close(found: f64, wanted: f64, scale: f64, share: f64) {
    assert!((found - wanted).abs() <= share * scale, "{found:e} is not {wanted:e} ({:.1e})", (found - wanted) / scale);
}

fn same(found: &Tensor, wanted: &Tensor, share: f64) {
    assert!((found - wanted).norm() <= share * wanted.norm(), "{found} is not {wanted}");
}

/// Pressure tr(tau)/2 and q = sqrt(J2).
fn invariants(stress: &Tensor) -> [f64; 2] {
    let half = 0.5 * (stress[(0, 0)] - stress[(1, 1)]);
    [0.5 * (stress[(0, 0)] + stress[(1, 1)]), (half * half + stress[(0, 1)] * stress[(0, 1)]).sqrt()]
}

/// eta, etabar and zeta at a solid volume fraction: sines and cosines of the angles of equation (7).
fn cone(law: &CriticalDruckerPrager, fraction: f64) -> [f64; 3] {
    let tan_psi = law.dilation_factor * (fraction - law.fraction_critical);
    let (psi, phi) = (math::atan(tan_psi), math::atan(law.friction_critical + tan_psi));
    [math::sin(phi), math::sin(psi), math::cos(phi)]
}

/// Invariants of the stress that a memory would have, were the increment elastic; through eigenvalues, unlike the law.
fn trial(law: &CriticalDruckerPrager, memory: &CriticalMemory<Plane>, increment: &Tensor) -> [f64; 2] {
    let elastic = memory.strain.tensor() + Tensor::identity();
    let step = Tensor::identity() + increment;
    let stretches = (step * elastic * step.transpose()).symmetric_eigenvalues();
    let [a, b] = [0.5 * math::ln(stretches[0]), 0.5 * math::ln(stretches[1])];
    [law.bulk_modulus * (a + b), law.shear_modulus * (a - b).abs()]
}

/// Stretched along x only: `eps_xx = ln(F_xx)`, `tau_xx = -p + (K + G) eps_xx`, `tau_yy = -p + (K - G) eps_xx`.
#[test]
fn uniaxial_strain_is_linear_in_the_logarithmic_strain() {
    let law = elastic();
    let (bulk, shear) = (law.bulk_modulus, law.shear_modulus);
    for rate in [2e-4, -3e-4] {
        let mut memory = start(&law, PRESSURE, 0.85);
        for step in 1..=1000 {
            let stress = carry(&law, &mut memory, Tensor::new(rate, 0.0, 0.0, 0.0));
            let strain = f64::from(step) * math::ln_one_plus(rate);
            let wanted =
                Tensor::new(-PRESSURE + (bulk + shear) * strain, 0.0, 0.0, -PRESSURE + (bulk - shear) * strain);
            close((stress - wanted).norm(), 0.0, bulk, 1e-12);
            let volume = strain - PRESSURE / bulk;
            let energy = 0.5 * bulk * volume * volume + 0.5 * shear * strain * strain;
            close(MaterialLaw::<Plane>::elastic_energy(&law, &memory), energy, energy, 1e-9);
            assert_eq!((memory.plastic_strain, memory.gap), (0.0, 0.0));
        }
    }
}

/// Sheared by g: the principal logarithmic strains are +-asinh(g/2) and turn with the shear,
/// `tau_xy = 2 G asinh(g/2)/sqrt(1 + g^2/4)`, `tau_xx - tau_yy = g tau_xy`.
#[test]
fn simple_shear_follows_the_closed_form_to_large_strain() {
    let law = elastic();
    let mut memory = start(&law, PRESSURE, 0.85);
    let rate = 1e-3;
    for step in 1..=1500 {
        let stress = carry(&law, &mut memory, Tensor::new(0.0, rate, 0.0, 0.0));
        let half = 0.5 * rate * f64::from(step);
        let root = (1.0 + half * half).sqrt();
        let shear = 2.0 * law.shear_modulus * math::ln(half + root) / root;
        let wanted = Tensor::new(-PRESSURE + half * shear, shear, shear, -PRESSURE - half * shear);
        close((stress - wanted).norm(), 0.0, law.shear_modulus, 1e-12);
    }
}

/// Past yield the stress lies on the cone of the fraction that the step began with, and p and q got there along
/// `q -= G dlambda`, `p -= K etabar dlambda` with `dlambda = f_trial/(G + K eta etabar)`.
#[test]
fn a_yielding_step_returns_to_the_cone_by_the_closed_form() {
    let with_cohesion = CriticalDruckerPrager { cohesion: 20e3, ..material() };
    let paths = [
        Tensor::new(0.0, 2e-5, 0.0, 0.0),
        Tensor::new(2e-5, 0.0, 0.0, -3e-5),
        Tensor::new(1e-5, -4e-5, 0.0, -1.2e-5),
        Tensor::new(0.0, 1e-3, 0.0, 0.0),
    ];
    for law in [material(), with_cohesion] {
        for fraction in [0.86, 0.815, 0.80] {
            for increment in paths {
                let mut memory = start(&law, PRESSURE, fraction);
                let mut yielded = 0;
                for _ in 0..600 {
                    let [eta, eta_bar, zeta] = cone(&law, memory.fraction);
                    let [pressure, q] = trial(&law, &memory, &increment);
                    let excess = q + eta * pressure - zeta * law.cohesion;
                    let multiplier = excess / (law.shear_modulus + law.bulk_modulus * eta * eta_bar);
                    // A loose material contracts until nothing presses on it, and what would return beyond the apex
                    // is another test's.
                    if law.shear_modulus * multiplier >= q {
                        break;
                    }
                    let plastic = memory.plastic_strain;
                    let found = invariants(&carry(&law, &mut memory, increment));
                    if excess <= 1e-9 * q {
                        continue;
                    }
                    yielded += 1;
                    let scale = found[1] + found[0].abs();
                    close(found[1] + eta * found[0], zeta * law.cohesion, scale, 1e-10);
                    close(found[1], q - law.shear_modulus * multiplier, scale, 1e-10);
                    close(found[0], pressure - law.bulk_modulus * eta_bar * multiplier, scale, 1e-10);
                    let norm = multiplier * (0.5 * (1.0 + eta_bar * eta_bar)).sqrt();
                    close(memory.plastic_strain - plastic, norm, scale / law.shear_modulus, 1e-10);
                    close(memory.gap, 0.0, 1.0, 0.0);
                }
                assert!(yielded > 20, "fraction {fraction}: {yielded} steps yielded");
            }
        }
    }
}

/// Without softening the stress ratio stays at sin(phi) while the pressure rises with dilation, or falls with contraction.
#[test]
fn a_dense_material_dilates_and_a_loose_one_contracts() {
    let law = CriticalDruckerPrager { softening_rate: 0.0, ..material() };
    for (fraction, sign) in [(0.85, 1.0), (0.80, -1.0)] {
        let mut memory = start(&law, PRESSURE, fraction);
        let mut last = PRESSURE;
        for step in 0..2000 {
            let [pressure, q] = invariants(&carry(&law, &mut memory, Tensor::new(0.0, 1e-5, 0.0, 0.0)));
            if step > 1000 {
                close(q, -pressure * cone(&law, fraction)[0], q, 1e-10);
                assert!(sign * (-pressure - last) > 0.0, "fraction {fraction}: from {last} to {} Pa", -pressure);
            }
            last = -pressure;
        }
    }
}

/// Expanded beyond the cone the stress returns to its apex: none without cohesion, `p = zeta c/eta` with it. What is
/// expanded further opens a gap that must close before there is pressure again: `p = K min(V, 0)` on the way back, V being
/// the logarithm of the volume against the stress-free one.
#[test]
fn separated_material_bears_nothing_until_it_touches_again() {
    for cohesion in [0.0, 20e3] {
        let law = CriticalDruckerPrager { cohesion, ..material() };
        let bulk = law.bulk_modulus;
        let [eta, _, zeta] = cone(&law, 0.85);
        let apex = zeta * cohesion / (eta * bulk);
        let mut memory = start(&law, PRESSURE, 0.85);
        let (rate, mut volume) = (1e-5, -PRESSURE / bulk);
        let mut peak = 0.0f64;
        for step in 1..=1200 {
            // Out for the first half, back for the second; a twist that must find nothing to hold on to.
            let sign = if step <= 600 { 1.0 } else { -1.0 };
            let was_open = memory.gap > 0.0;
            let stress = carry(&law, &mut memory, Tensor::new(sign * rate, 0.0, 0.0, sign * rate));
            volume += 2.0 * math::ln_one_plus(sign * rate);
            let [pressure, q] = invariants(&stress);
            peak = peak.max(pressure);
            close(q, 0.0, PRESSURE, 1e-9);
            if was_open {
                close(pressure, bulk * volume.min(0.0), PRESSURE, 1e-9);
                close(memory.gap, volume.max(0.0), 1e-3, 1e-9);
            } else if step <= 600 {
                close(pressure, bulk * volume.min(apex), PRESSURE, 1e-9);
                close(memory.gap, (volume - apex).max(0.0), 1e-3, 1e-9);
            }
        }
        close(peak, bulk * apex, PRESSURE, 1e-9);
        assert!(memory.gap == 0.0 && volume < -0.9 * PRESSURE / bulk, "it should touch again by now");
    }
}

/// While separated, shear finds nothing to hold on to; after touching it builds up from zero.
#[test]
fn a_gap_forgets_shear() {
    let law = material();
    let mut memory = start(&law, PRESSURE, 0.85);
    carry(&law, &mut memory, Tensor::new(0.0, 1e-4, 0.0, 0.0));
    let shear = invariants(&carry(&law, &mut memory, Tensor::new(0.0, 1e-4, 0.0, 0.0)))[1];
    assert!(shear > 1e3, "{shear} Pa before the gap");
    carry(&law, &mut memory, Tensor::new(4e-3, 0.0, 0.0, 4e-3));
    assert!(memory.gap > 3e-3);
    let plastic = memory.plastic_strain;
    assert_eq!(invariants(&carry(&law, &mut memory, Tensor::new(0.0, 1e-2, 0.0, 0.0))), [0.0, 0.0]);
    assert_eq!(memory.plastic_strain, plastic);
    let [pressure, q] = invariants(&carry(&law, &mut memory, Tensor::new(-4e-3, 0.0, 0.0, -4e-3)));
    assert!(pressure < -1e5 && q == 0.0, "{pressure} Pa and {q} Pa after it");
}

/// `dPhi/ds = -xi (Phi - Phi_cs) Phi` over the plastic strain s is a logistic equation,
/// `1/Phi = 1/Phi_cs + (1/Phi_0 - 1/Phi_cs) exp(-xi Phi_cs s)`. The law takes Euler steps: first order in the step.
#[test]
fn the_packing_fraction_follows_the_logistic_equation_to_first_order() {
    let law = material();
    for (begin, squeeze) in [(0.86, 0.0), (0.795, 0.3)] {
        let error = |steps: u32| {
            let mut memory = start(&law, PRESSURE, begin);
            let increment = 0.4 / f64::from(steps);
            let mut worst = 0.0f64;
            for _ in 0..steps {
                carry(&law, &mut memory, Tensor::new(0.0, increment, 0.0, -squeeze * increment));
                let fade = math::exp(-law.softening_rate * law.fraction_critical * memory.plastic_strain);
                let critical = 1.0 / law.fraction_critical;
                worst = worst.max((memory.fraction - 1.0 / (critical + (1.0 / begin - critical) * fade)).abs());
            }
            assert!((memory.fraction - begin).abs() > 5e-3, "it hardly changed: {}", memory.fraction);
            worst
        };
        let errors = [400, 800, 1600, 3200].map(error);
        for pair in errors.windows(2) {
            let order = math::ln(pair[0] / pair[1]) / math::ln(2.0);
            assert!((order - 1.0).abs() < 0.1, "start {begin}: order {order}, errors {errors:?}");
        }
    }
}

/// A rotation laid over the motion turns the stress and changes nothing else: elastic, yielding and separated alike.
#[test]
fn a_superposed_rotation_only_turns_the_stress() {
    let law = material();
    let turn = |angle: f64| {
        let (sine, cosine) = (math::sin(angle), math::cos(angle));
        Tensor::new(cosine, -sine, sine, cosine)
    };
    let (mut fixed, mut turned) = (start(&law, PRESSURE, 0.85), start(&law, PRESSURE, 0.85));
    let mut gap_seen = false;
    for step in 0..900 {
        let increment = match step {
            0..400 => Tensor::new(1e-5, 4e-5, -1e-5, -2e-5),
            400..700 => Tensor::new(4e-5, 3e-5, 0.0, 5e-5),
            _ => Tensor::new(-7e-5, -1e-5, 0.0, -8e-5),
        };
        let wanted = carry(&law, &mut fixed, increment);
        let (before, after) = (turn(0.013 * f64::from(step)), turn(0.013 * f64::from(step + 1)));
        let moved = after * (Tensor::identity() + increment) * before.transpose() - Tensor::identity();
        let found = carry(&law, &mut turned, moved);
        let wanted = after * wanted * after.transpose();
        assert!((found - wanted).norm() < 1e-9 * PRESSURE, "step {step}: {found} is not {wanted}");
        close(turned.plastic_strain, fixed.plastic_strain, 1e-2, 1e-10);
        close(turned.fraction, fixed.fraction, 1.0, 1e-12);
        close(turned.gap, fixed.gap, 1e-3, 1e-9);
        gap_seen |= fixed.gap > 0.0;
    }
    assert!(gap_seen && fixed.plastic_strain > 1e-3, "the path should yield and separate: {fixed:?}");
    let stress = MaterialLaw::<Plane>::stress(&law, &fixed);
    let mut spun = fixed;
    let whole = carry(&law, &mut spun, turn(0.7) - Tensor::identity());
    same(&whole, &(turn(0.7) * stress * turn(0.7).transpose()), 1e-9);
    assert_eq!(spun.plastic_strain, fixed.plastic_strain);
}

/// Cohesive material that separates lost what its apex held, and nobody had it.
#[test]
fn what_the_apex_held_is_dissipated_when_material_separates() {
    let law = CriticalDruckerPrager { cohesion: 1e5, ..material() };
    let [eta, _, zeta] = cone(&law, 0.85);
    let apex = zeta * law.cohesion / eta;
    let held = 0.5 * apex * apex / law.bulk_modulus;
    let steps = 20_000;
    let increment = Tensor::identity() * (2.0 * apex / law.bulk_modulus / f64::from(steps));
    let mut memory = start(&law, 0.0, 0.85);
    let (mut given, mut spent) = (0.0, 0.0);
    for _ in 0..steps {
        let stress = MaterialLaw::<Plane>::update_counted(&law, &(increment * (1.0 / DT)), DT, &mut memory, &mut spent);
        given += stress.dot(&increment);
    }
    assert!(memory.gap > 0.0 && MaterialLaw::<Plane>::stress(&law, &memory).norm() == 0.0, "it has separated");
    let stored = MaterialLaw::<Plane>::elastic_energy(&law, &memory);
    close(given, stored + spent, held, 0.01);
    assert!(spent > 0.9 * held, "{spent} J/m3 of {held}");
}
