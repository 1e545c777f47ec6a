//! Every material law, in the plane and in space: logarithms and exponentials against eigenvalues, rotation, stretch,
//! the return to the cone from random states, energies, and starts from a stress.

use scree::base::math;
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::base::symmetric::{PlaneSymmetric, SolidSymmetric, Symmetric};
use scree::law::invariants::{Deformation, StressInvariants};
use scree::law::material::{CriticalDruckerPrager, Hencky, LinearElastic, MaterialLaw, MaterialMemory};

use crate::worlds::Random;

type PlaneTensor = <Plane as Space>::Tensor;
type SolidTensor = <Solid as Space>::Tensor;

const BULK: f64 = 100e6;
const SHEAR: f64 = 60e6;
const HENCKY: Hencky = Hencky { bulk_modulus: BULK, shear_modulus: SHEAR };
const LINEAR: LinearElastic = LinearElastic { bulk_modulus: BULK, shear_modulus: SHEAR };
const DT: f64 = 1e-4;

fn critical(phi: f64, cohesion: f64) -> CriticalDruckerPrager {
    CriticalDruckerPrager {
        bulk_modulus: BULK,
        shear_modulus: SHEAR,
        friction_critical: math::tan(phi),
        fraction_critical: 0.6,
        dilation_factor: 4.0,
        dilation: 0.0,
        softening_rate: 3.0,
        cohesion,
    }
}

impl Random {
    /// A power of ten between two exponents.
    fn magnitude(&mut self, lower: f64, upper: f64) -> f64 {
        math::exp(math::ln(10.0) * (lower + (upper - lower) * 0.5 * (1.0 + self.signed())))
    }

    fn tensor<S: Space>(&mut self, size: f64) -> S::Tensor {
        let mut tensor = S::Tensor::zero();
        for value in tensor.as_mut_slice() {
            *value = size * self.signed();
        }
        tensor
    }

    fn rotation<S: Space>(&mut self) -> S::Tensor {
        let tensor = loop {
            let tensor = self.tensor::<S>(1.0);
            if S::determinant(&tensor) > 0.05 {
                break tensor;
            }
        };
        S::rotation(&tensor)
    }
}

fn component<S: Space>(tensor: &S::Tensor, row: usize, column: usize) -> f64 {
    tensor[row + S::DIMENSION * column]
}

fn diagonal<S: Space>(values: &[f64]) -> S::Tensor {
    let mut tensor = S::Tensor::zero();
    for axis in 0..S::DIMENSION {
        tensor[axis * (S::DIMENSION + 1)] = values[axis];
    }
    tensor
}

fn turned<S: Space>(tensor: &S::Tensor, turn: &S::Tensor) -> S::Tensor {
    *turn * *tensor * S::transpose(turn)
}

/// Carries a memory over one increment of deformation `F = I + increment`.
fn carry<S: Space, L: MaterialLaw<S>>(law: &L, memory: &mut L::Memory, increment: &S::Tensor) -> S::Tensor {
    law.update(&(*increment * (1.0 / DT)), DT, memory)
}

fn close(found: f64, wanted: f64, scale: f64, share: f64) {
    assert!((found - wanted).abs() <= share * scale, "{found:e} is not {wanted:e} ({:.1e})", (found - wanted) / scale);
}

fn same<S: Space>(found: &S::Tensor, wanted: &S::Tensor, scale: f64, share: f64) {
    let error = (*found - *wanted).norm() / scale;
    assert!(error <= share, "{found:?} is not {wanted:?} ({error:.1e})");
}

/// A function of a symmetric tensor through eigenvalues, unlike the laws.
fn by_eigenvalues(tensor: &SolidTensor, f: impl Fn(f64) -> f64) -> SolidTensor {
    let eigen = tensor.symmetric_eigen();
    let mut sum = SolidTensor::zeros();
    for axis in 0..3 {
        let vector = eigen.eigenvectors.column(axis);
        sum += vector * vector.transpose() * f(eigen.eigenvalues[axis]);
    }
    sum
}

/// From 1e-9 to 3000 % of strain, with a root and without: to a few units in the last place where the series runs alone.
#[test]
fn logarithms_and_exponentials_agree_with_eigenvalues() {
    let mut random = Random(1);
    for _ in 0..40_000 {
        let size = random.magnitude(-9.0, 0.5);
        let strain = SolidSymmetric::of(&random.tensor::<Solid>(size));
        let stretch = (strain * 2.0).exponential();
        let wanted = by_eigenvalues(&strain.tensor(), |value| math::exp_minus_one(2.0 * value));
        same::<Solid>(&stretch.tensor(), &wanted, wanted.norm() * (1.0 + strain.tensor().norm()), 5e-15);
        let least = 1.0 + wanted.symmetric_eigenvalues().min();
        let found = stretch.half_logarithm().tensor();
        // What the last place of the stretch is worth in its logarithm.
        let scale = strain.tensor().norm() * 2e-15 + 5e-15 * stretch.tensor().norm() / least.min(1.0);
        same::<Solid>(&found, &strain.tensor(), scale, 1.0);
    }
}

/// Diagonal tensors have the function of each component: no decomposition stands between. Sizes are dense, so that every
/// number of terms is met, and the last size before the next term.
#[test]
fn series_are_cut_below_the_last_place() {
    let (mut size, mut worst) = (1e-7f64, [0.0f64; 3]);
    while size < 0.7 {
        for shape in [[1.0, 1.0, 1.0], [1.0, -0.5, 0.3], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-0.8, -0.9, 1.0]] {
            let values = shape.map(|share| share * size);
            let [x, y, z] = values;
            let check = |found: [f64; 3], f: &dyn Fn(f64) -> f64| {
                let wanted = values.map(f);
                let norm = wanted.iter().map(|value| value * value).sum::<f64>().sqrt();
                (0..3).map(|axis| (found[axis] - wanted[axis]).abs() / norm).fold(0.0, f64::max)
            };
            let solid = SolidSymmetric([x, y, z, 0.0, 0.0, 0.0]);
            let plane = PlaneSymmetric([x, y, 0.0]);
            let half = |value: f64| 0.5 * math::ln_one_plus(value);
            let [a, b, c, ..] = solid.half_logarithm().0;
            let [d, e, _] = plane.half_logarithm().0;
            let far = usize::from(size > 0.25);
            worst[far] = worst[far].max(check([a, b, c], &half)).max(check([d, e, half(z)], &half));
            let [a, b, c, ..] = solid.exponential().0;
            let [d, e, _] = plane.exponential().0;
            let grown = math::exp_minus_one;
            let error = check([a, b, c], &grown).max(check([d, e, grown(z)], &grown));
            worst[2] = worst[2].max(error);
        }
        size *= 1.003;
    }
    assert!(worst[0] < 1e-15 && worst[1] < 4e-15 && worst[2] < 1e-15, "{worst:?}");
}

/// Turned by `I + h = R` through many turns: the stress turns along, and back at the start it is what it was.
fn turns<S: Space, L: MaterialLaw<S>>(law: &L, stress: &S::Tensor, turn: &S::Tensor, steps: usize) {
    let mut memory = law.start(stress, 0.6);
    let (begin, energy, normal) = (law.stress(&memory), law.elastic_energy(&memory), law.out_of_plane(&memory));
    let increment = *turn - S::identity();
    let mut found = begin;
    for _ in 0..steps {
        found = carry::<S, L>(law, &mut memory, &increment);
    }
    // The turn itself is right to its last place, and the law sees that as strain in every step.
    let share = steps as f64 * 6e-16;
    same::<S>(&found, &begin, BULK, share);
    close(law.elastic_energy(&memory), energy, BULK, share);
    close(law.out_of_plane(&memory), normal, BULK, share);
    assert_eq!(memory.plastic_strain(), 0.0);
}

#[test]
fn many_turns_leave_the_stress_as_it_was() {
    // 100 turns of 72 steps and of 5.
    for steps in [72.0, 5.0] {
        let (sine, cosine) = (math::sin(2.0 * math::PI / steps), math::cos(2.0 * math::PI / steps));
        let count = 100 * steps as usize;
        let turn = PlaneTensor::new(cosine, -sine, sine, cosine);
        let stress = PlaneTensor::new(-3e5, 4e4, 4e4, -2e5);
        turns::<Plane, _>(&LINEAR, &stress, &turn, count);
        turns::<Plane, _>(&HENCKY, &stress, &turn, count);
        let law = critical(0.5, 1e4);
        turns::<Plane, _>(&law, &stress, &turn, count);

        let tilt = Random(7).rotation::<Solid>();
        let about_z = SolidTensor::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
        let turn = turned::<Solid>(&about_z, &tilt);
        let stress = SolidTensor::new(-3e5, 4e4, 1e4, 4e4, -2e5, -2e4, 1e4, -2e4, -2.5e5);
        turns::<Solid, _>(&LINEAR, &stress, &turn, count);
        turns::<Solid, _>(&HENCKY, &stress, &turn, count);
        turns::<Solid, _>(&law, &stress, &turn, count);
    }
}

/// A rotation laid over the motion turns the stress and changes nothing else, elastic, yielding and separated.
#[test]
fn a_superposed_rotation_only_turns_the_stress_in_space() {
    let (law, mut random) = (critical(0.5, 2e3), Random(3));
    let start = SolidTensor::identity() * -1e5;
    let mut fixed = MaterialLaw::<Solid>::start(&law, &start, 0.65);
    let (mut spun, mut before, mut gaps) = (fixed, SolidTensor::identity(), 0);
    for step in 0..600 {
        let sign = if step < 300 { 1.0 } else { -1.0 };
        let increment = SolidTensor::new(2e-5, 3e-5, -1e-5, 0.0, -1e-5, 2e-5, 1e-5, 0.0, 1e-5) * sign;
        let after = random.rotation::<Solid>();
        let wanted = turned::<Solid>(&carry::<Solid, _>(&law, &mut fixed, &increment), &after);
        let moved = after * (SolidTensor::identity() + increment) * before.transpose() - SolidTensor::identity();
        let found = carry::<Solid, _>(&law, &mut spun, &moved);
        same::<Solid>(&found, &wanted, BULK, 1e-13 * f64::from(step + 1));
        close(spun.plastic_strain, fixed.plastic_strain, 1.0, 1e-12);
        before = after;
        gaps += usize::from(fixed.gap > 0.0);
    }
    assert!(gaps > 50 && fixed.plastic_strain > 1e-3, "the path should yield and separate: {fixed:?}");
}

/// Uniaxial stretch l: `tau_11 = (K + 2 (1 - 1/d) G) ln l`, `tau_22 = (K - 2 G/d) ln l`; from 1/20 to 20, in one step and in
/// thirty. Linear elasticity comes to the same with the square of the step: over J, which here is l.
fn stretches<S: Space>() {
    let share = 2.0 / S::DIMENSION as f64;
    let wanted = |strain: f64| {
        let (along, across) = ((BULK + (2.0 - share) * SHEAR) * strain, (BULK - share * SHEAR) * strain);
        diagonal::<S>(&[along, across, across])
    };
    close(MaterialLaw::<S>::p_wave_modulus(&HENCKY), BULK + (2.0 - share) * SHEAR, BULK, 1e-15);
    for stretch in [0.05, 0.4, 0.99, 1.0 + 1e-7, 1.5, 4.0, 20.0] {
        for steps in [1, 30] {
            let ratio = math::exp_minus_one(math::ln(stretch) / f64::from(steps));
            let strain = f64::from(steps) * math::ln_one_plus(ratio);
            let mut memory = MaterialLaw::<S>::start(&HENCKY, &S::Tensor::zero(), 0.6);
            let mut stress = S::Tensor::zero();
            for _ in 0..steps {
                stress = carry::<S, _>(&HENCKY, &mut memory, &diagonal::<S>(&[ratio, 0.0, 0.0]));
            }
            // What the last place of b is worth in its logarithm, where it is small against one.
            let least = math::exp(2.0 * strain).min(1.0);
            same::<S>(&stress, &wanted(strain), BULK * strain.abs(), 2e-14 / least);
            close(memory.fraction() * math::exp(strain), 0.6, 0.6, 2e-14 / least);
        }
    }
    let error = |steps: i32| {
        let ratio = math::exp(math::ln(3.0) / f64::from(steps)) - 1.0;
        let mut memory = MaterialLaw::<S>::start(&LINEAR, &S::Tensor::zero(), 0.6);
        let mut stress = S::Tensor::zero();
        for _ in 0..steps {
            stress = carry::<S, _>(&LINEAR, &mut memory, &diagonal::<S>(&[ratio, 0.0, 0.0]));
        }
        (stress * (1.0 / 3.0) - wanted(math::ln(3.0))).norm() / BULK
    };
    let order = math::ln(error(20) / error(40)) / math::ln(2.0);
    assert!((order - 2.0).abs() < 0.02, "order {order}, error {}", error(40));
}

#[test]
fn large_stretch_follows_the_closed_form() {
    stretches::<Plane>();
    stretches::<Solid>();
}

/// eta, etabar and zeta at a solid volume fraction: from the angles.
fn cone<S: Space>(law: &CriticalDruckerPrager, fraction: f64) -> [f64; 3] {
    let change = law.dilation_factor * (fraction - law.fraction_critical);
    let (psi, phi) = (math::atan(law.dilation + change), math::atan(law.friction_critical + change));
    let scale = |angle: f64| {
        if S::DIMENSION == 2 { 1.0 } else { 6.0 / (3f64.sqrt() * (3.0 - math::sin(angle))) }
    };
    [math::sin(phi) * scale(phi), math::sin(psi) * scale(psi), math::cos(phi) * scale(phi)]
}

/// From random states, random steps: the stress is on the cone or inside, to 1e-12; where it yields it came there along the
/// flow, and each branch is met often.
fn returns<S: Space>(seed: u64) {
    let mut random = Random(seed);
    let mut branches = [0; 4];
    let share = 2.0 / S::DIMENSION as f64;
    for sample in 0..60_000 {
        let cohesion = if sample % 3 == 0 { 0.0 } else { random.magnitude(1.0, 5.0) };
        let law = CriticalDruckerPrager {
            dilation: 0.2 * random.signed(),
            ..critical(if sample % 7 == 0 { 0.0 } else { 0.4 + 0.3 * random.signed() }, cohesion)
        };
        let free = CriticalDruckerPrager { cohesion: 1e15, ..law };
        let fraction = 0.6 + 0.05 * random.signed();
        let size = random.magnitude(2.0, 7.0);
        let stress = random.tensor::<S>(size) + S::identity() * (size * random.signed());
        let mut memory = law.start(&stress, fraction);
        let begun = StressInvariants::of::<S>(&law.stress(&memory));
        let [eta, eta_bar, zeta] = cone::<S>(&law, fraction);
        let (eta, zeta) =
            if eta < 0.0 { (0.0, if S::DIMENSION == 2 { 1.0 } else { 2.0 / 3f64.sqrt() }) } else { (eta, zeta) };
        let size_of = |stress: &StressInvariants| stress.deviatoric + eta * stress.mean.abs() + zeta * law.cohesion;
        // In the plane b_e is kept, to 2e-16 of one.
        let excess = begun.deviatoric + eta * begun.mean - zeta * law.cohesion;
        assert!(excess <= 1e-12 * size_of(&begun) + 1e-15 * BULK, "start outside by {excess}");

        let increment = random.tensor::<S>(size / BULK);
        let mut elastic = memory;
        let trial_stress = carry::<S, _>(&free, &mut elastic, &increment);
        let (trial, plastic) = (StressInvariants::of::<S>(&trial_stress), memory.plastic_strain());
        let stress = carry::<S, _>(&law, &mut memory, &increment);
        let found = StressInvariants::of::<S>(&stress);
        let scale = size_of(&found) + size_of(&trial);
        let excess = found.deviatoric + eta * found.mean - zeta * law.cohesion;
        let plastic = memory.plastic_strain() - plastic;
        let trial_excess = trial.deviatoric + eta * trial.mean - zeta * law.cohesion;
        assert!(excess <= 1e-12 * scale, "outside by {:e}", excess / scale);

        let reach = trial.deviatoric + trial.mean.abs();
        if plastic == 0.0 {
            branches[0] += 1;
            assert!(trial_excess <= 1e-12 * reach.max(scale));
            same::<S>(&stress, &trial_stress, reach, 1e-14);
            continue;
        }
        close(excess, 0.0, scale, 1e-12);
        let multiplier = trial_excess / (SHEAR + BULK * eta * eta_bar);
        let q = trial.deviatoric - SHEAR * multiplier;
        if q > 1e-9 * reach || eta == 0.0 {
            branches[if eta == 0.0 { 3 } else { 1 }] += 1;
            close(found.deviatoric, q, reach, 1e-12);
            close(found.mean, trial.mean - BULK * eta_bar * multiplier, reach, 1e-12);
            close(plastic, multiplier * (0.5 * (1.0 + share * eta_bar * eta_bar)).sqrt(), reach / BULK, 1e-11);
            // Coaxial: the deviator keeps its direction.
            if found.deviatoric < 1e-3 * reach {
                continue;
            }
            let kept = S::Symmetric::of(&stress).deviator() * (trial.deviatoric / found.deviatoric);
            let change = (kept - S::Symmetric::of(&trial_stress).deviator()).square().sqrt();
            close(change, 0.0, reach * reach / found.deviatoric, 1e-12);
        } else if q < -1e-9 * reach {
            branches[2] += 1;
            close(found.deviatoric, 0.0, reach, 1e-14);
            close(found.mean, zeta * law.cohesion / eta, scale, 1e-12);
            let opened = (trial.mean - found.mean) / BULK;
            let shear = trial.deviatoric / SHEAR;
            close(plastic, (0.5 * (shear * shear + share * opened * opened)).sqrt(), reach / BULK, 1e-11);
        }
    }
    assert!(branches.iter().all(|count| *count > 2000), "{branches:?}");
}

#[test]
fn no_state_is_left_outside_the_cone() {
    returns::<Plane>(11);
    returns::<Solid>(12);
}

/// Expanded beyond the apex the material bears nothing until the gap has closed, `p = K min(V, 0)` on the way back.
#[test]
fn spheres_that_separated_bear_nothing_until_they_touch_again() {
    for cohesion in [0.0, 20e3] {
        let law = critical(0.5, cohesion);
        let [eta, _, zeta] = cone::<Solid>(&law, 0.65);
        let apex = zeta * cohesion / (eta * BULK);
        let mut memory = MaterialLaw::<Solid>::start(&law, &(SolidTensor::identity() * -4e5), 0.65);
        let mut volume = -4e5 / BULK;
        let mut opened = false;
        for step in 1..=800 {
            let rate = if step <= 400 { 1e-5 } else { -1e-5 };
            let was_open = memory.gap > 0.0;
            let stress = carry::<Solid, _>(&law, &mut memory, &(SolidTensor::identity() * rate));
            volume += 3.0 * math::ln_one_plus(rate);
            let found = StressInvariants::of::<Solid>(&stress);
            let top = if was_open { 0.0 } else { apex };
            close(found.mean, BULK * volume.min(top), 4e5, 1e-11);
            close(found.deviatoric, 0.0, 4e5, 1e-11);
            if step <= 400 || was_open {
                close(memory.gap, (volume - top).max(0.0), 1e-2, 1e-11);
            }
            opened |= was_open;
        }
        assert!(opened && memory.gap == 0.0 && volume < -0.9 * 4e5 / BULK);
        // Sheared while open, it holds on to nothing.
        let mut memory = MaterialLaw::<Solid>::start(&law, &SolidTensor::zeros(), 0.65);
        carry::<Solid, _>(&law, &mut memory, &(SolidTensor::identity() * 1e-2));
        let (gap, plastic) = (memory.gap, memory.plastic_strain);
        let sheared =
            carry::<Solid, _>(&law, &mut memory, &SolidTensor::new(0.0, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
        assert!(sheared == SolidTensor::zeros() && gap > 0.02 && memory.plastic_strain == plastic);
        close(memory.gap - apex, gap, 1.0, 1e-12);
    }
}

/// Without friction a cohesive material yields at q = c (2 c/sqrt(3) in space) at any pressure, tension as well; without
/// cohesion either it is a fluid, which keeps its pressure.
#[test]
fn without_friction_there_is_no_apex() {
    for (cohesion, pressure) in [(2e4, 1e5), (2e4, -5e5), (0.0, 1e5)] {
        let law = CriticalDruckerPrager { dilation_factor: 0.0, ..critical(0.0, cohesion) };
        let mut plane = MaterialLaw::<Plane>::start(&law, &(PlaneTensor::identity() * -pressure), 0.6);
        let mut solid = MaterialLaw::<Solid>::start(&law, &(SolidTensor::identity() * -pressure), 0.6);
        for _ in 0..500 {
            let found = carry::<Plane, _>(&law, &mut plane, &PlaneTensor::new(1e-4, 2e-4, 0.0, -1e-4 / (1.0 + 1e-4)));
            let found = StressInvariants::of::<Plane>(&found);
            close(found.mean, -pressure, BULK, 1e-12);
            assert!(found.deviatoric <= cohesion * (1.0 + 1e-12));
            let shear = SolidTensor::new(0.0, 2e-4, 1e-4, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0);
            let found = StressInvariants::of::<Solid>(&carry::<Solid, _>(&law, &mut solid, &shear));
            close(found.mean, -pressure, BULK, 1e-12);
            assert!(found.deviatoric <= 2.0 / 3f64.sqrt() * cohesion * (1.0 + 1e-12));
        }
        assert!(plane.plastic_strain > 0.05 && solid.plastic_strain > 0.05);
        assert!(plane.gap == 0.0 && solid.gap == 0.0);
    }
}

/// Plane strain in space is the plane's law with `K = K_body + G/3`, its stress across the plane included.
#[test]
fn space_in_plane_strain_is_the_plane() {
    let mut random = Random(5);
    let body = BULK - SHEAR / 3.0;
    let strong = critical(0.5, 1e13);
    let hencky = Hencky { bulk_modulus: body, ..HENCKY };
    let linear = LinearElastic { bulk_modulus: body, ..LINEAR };
    let critical_body = CriticalDruckerPrager { bulk_modulus: body, ..strong };
    let path: Vec<PlaneTensor> = (0..60).map(|_| random.tensor::<Plane>(0.05)).collect();
    fn compare<A: MaterialLaw<Plane>, B: MaterialLaw<Solid>>(plane: &A, solid: &B, path: &[PlaneTensor]) {
        let mut inside = plane.start(&PlaneTensor::zeros(), 0.6);
        let mut whole = solid.start(&SolidTensor::zeros(), 0.6);
        for h in path {
            let lifted = SolidTensor::new(h[0], h[2], 0.0, h[1], h[3], 0.0, 0.0, 0.0, 0.0);
            let flat = carry::<Plane, A>(plane, &mut inside, h);
            let stress = carry::<Solid, B>(solid, &mut whole, &lifted);
            for row in 0..2 {
                for column in 0..2 {
                    close(
                        component::<Plane>(&flat, row, column),
                        component::<Solid>(&stress, row, column),
                        BULK,
                        2e-13,
                    );
                }
            }
            close(plane.out_of_plane(&inside), stress[(2, 2)], BULK, 2e-13);
            close(plane.elastic_energy(&inside), solid.elastic_energy(&whole), BULK, 2e-13);
        }
        close(plane.p_wave_modulus(), solid.p_wave_modulus(), BULK, 1e-15);
        close(plane.shear_modulus(), solid.shear_modulus(), BULK, 0.0);
    }
    compare(&HENCKY, &hencky, &path);
    compare(&LINEAR, &linear, &path);
    compare(&strong, &critical_body, &path);
    compare(&HENCKY, &critical_body, &path);
}

/// Sheared far without dilation, space's law in plane strain comes to bear what the plane's does of `sin(phi) = eta`.
#[test]
fn far_sheared_cones_agree_in_plane_strain() {
    let law = CriticalDruckerPrager { dilation_factor: 0.0, ..critical(0.4, 1e4) };
    let [eta, _, zeta] = cone::<Solid>(&law, 0.6);
    let flat = eta / (1.0 - eta * eta).sqrt();
    let plane = CriticalDruckerPrager {
        bulk_modulus: BULK + SHEAR / 3.0,
        friction_critical: flat,
        cohesion: 1e4 * zeta / (1.0 - eta * eta).sqrt(),
        ..law
    };
    let mut inside = MaterialLaw::<Plane>::start(&plane, &(PlaneTensor::identity() * -1e5), 0.6);
    let mut whole = MaterialLaw::<Solid>::start(&law, &(SolidTensor::identity() * -1e5), 0.6);
    for _ in 0..4000 {
        carry::<Plane, _>(&plane, &mut inside, &PlaneTensor::new(0.0, 2e-5, 0.0, 0.0));
        carry::<Solid, _>(&law, &mut whole, &SolidTensor::new(0.0, 2e-5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
    }
    let flat = StressInvariants::of::<Plane>(&MaterialLaw::<Plane>::stress(&plane, &inside));
    let stress = MaterialLaw::<Solid>::stress(&law, &whole);
    let deep = StressInvariants::of::<Solid>(&stress);
    close(flat.deviatoric, deep.deviatoric, deep.deviatoric, 1e-3);
    close(stress[(2, 2)], deep.mean, 1e5, 1e-3);
}

/// Work of the stress over a closed path, and its error against the law's own energies, by the trapezoidal rule.
fn cycle<S: Space, L: MaterialLaw<S>>(law: &L, start: &S::Tensor, steps: u32) -> [f64; 3] {
    let mut memory = law.start(start, 0.6);
    let (mut stress, begin) = (law.stress(&memory), law.elastic_energy(&memory));
    let mut gradient = S::identity();
    let (mut work, mut error, mut dissipated) = (0.0, 0.0f64, 0.0);
    for step in 1..=steps {
        let angle = 2.0 * math::PI * f64::from(step) / f64::from(steps);
        // A closed curve through F = I, with stretch, shear and rotation.
        let (a, b) = (0.15 * math::sin(angle), 0.2 * (1.0 - math::cos(angle)));
        let mut next = S::identity();
        next[0] += a;
        next[1] -= 0.5 * b;
        next[S::DIMENSION] += b;
        next[S::DIMENSION + 1] += 0.3 * a + 0.1 * b;
        let increment = next * S::inverse(&gradient).unwrap() - S::identity();
        let before = stress;
        stress = law.update_counted(&(increment * (1.0 / DT)), DT, &mut memory, &mut dissipated);
        let middle = increment * S::inverse(&(S::identity() + increment * 0.5)).unwrap();
        work += (before + stress).dot(&middle) * 0.5;
        error = error.max((law.elastic_energy(&memory) - begin - work).abs());
        gradient = next;
    }
    [work, error, dissipated]
}

#[test]
fn energy_is_the_integral_of_stress_power() {
    fn order<S: Space, L: MaterialLaw<S>>(law: &L, start: &S::Tensor) {
        let [coarse, fine] = [200, 400].map(|steps| cycle::<S, L>(law, start, steps));
        let found = math::ln(coarse[1] / fine[1]) / math::ln(2.0);
        assert!((found - 2.0).abs() < 0.1 && fine[1] < 1e-5 * SHEAR && fine[2] == 0.0, "order {found}, {fine:?}");
        let closed = cycle::<S, L>(law, start, 3200)[0].abs();
        assert!(closed < 1e-8 * SHEAR, "a closed path did {closed} J/m3");
    }
    let strong = critical(0.5, 1e13);
    order::<Plane, _>(&HENCKY, &(PlaneTensor::identity() * -1e6));
    order::<Solid, _>(&HENCKY, &(SolidTensor::identity() * -1e6));
    order::<Plane, _>(&strong, &(PlaneTensor::identity() * -1e6));
    order::<Solid, _>(&strong, &(SolidTensor::identity() * -1e6));
}

/// Over a yielding path, work done = energy stored + dissipated, to first order in the step (the return is implicit).
#[test]
fn what_is_not_stored_is_dissipated() {
    fn lost<S: Space>(steps: u32) -> [f64; 2] {
        let law = critical(0.5, 5e3);
        let mut spent = 0.0;
        let mut memory = law.start(&(S::identity() * -3e5), 0.65);
        let (mut stress, begin) = (law.stress(&memory), law.elastic_energy(&memory));
        let mut work = 0.0;
        for step in 0..steps {
            let mut increment = S::Tensor::zero();
            let sign = if 3 * step < 2 * steps { 1.0 } else { -1.0 };
            increment[S::DIMENSION] = sign * 0.06 / f64::from(steps);
            increment[0] = 0.01 / f64::from(steps);
            increment[S::DIMENSION + 1] = -0.015 / f64::from(steps);
            let before = stress;
            stress = MaterialLaw::<S>::update_counted(&law, &(increment * (1.0 / DT)), DT, &mut memory, &mut spent);
            work += (before + stress).dot(&increment) * 0.5;
        }
        let stored = law.elastic_energy(&memory) - begin;
        assert!(spent > 0.3 * work.abs() && memory.plastic_strain() > 0.015, "{memory:?}, {work}");
        [(work - stored - spent).abs(), work]
    }
    for [coarse, fine] in [[200, 400].map(lost::<Plane>), [200, 400].map(lost::<Solid>)] {
        let order = math::ln(coarse[0] / fine[0]) / math::ln(2.0);
        assert!((order - 1.0).abs() < 0.25 && fine[0] < 0.02 * fine[1], "order {order}: {fine:?}");
    }
}

/// Isotropic and geostatic stress are taken up as given; a stress beyond the cone is brought back to it.
#[test]
fn a_start_has_the_stress_it_was_given() {
    fn given<S: Space, L: MaterialLaw<S>>(law: &L, share: f64) {
        let mut turn = Random(9);
        for pressure in [0.0, 1.0, 1e3, 4e5, 5e6] {
            for ratio in [1.0, 0.45] {
                let stress = diagonal::<S>(&[-pressure * ratio, -pressure, -pressure * ratio]);
                let stress = turned::<S>(&stress, &turn.rotation::<S>());
                let memory = law.start(&stress, 0.6);
                same::<S>(&law.stress(&memory), &stress, pressure + 1e-300, share + 1e-15 * BULK / (pressure + 1e-9));
                close(memory.fraction(), 0.6, 0.6, 1e-15);
                assert_eq!(memory.plastic_strain(), 0.0);
            }
        }
    }
    let law = critical(0.6, 0.0);
    given::<Plane, _>(&LINEAR, 1e-15);
    given::<Solid, _>(&LINEAR, 1e-15);
    given::<Plane, _>(&HENCKY, 1e-14);
    given::<Solid, _>(&HENCKY, 1e-14);
    given::<Plane, _>(&law, 1e-14);
    given::<Solid, _>(&law, 1e-14);
    // Memories of b - I keep small stresses as well.
    let faint = SolidTensor::new(-1e-3, 2e-4, 0.0, 2e-4, -1e-3, 0.0, 0.0, 0.0, -9e-4);
    let memory = MaterialLaw::<Solid>::start(&law, &faint, 0.6);
    same::<Solid>(&MaterialLaw::<Solid>::stress(&law, &memory), &faint, faint.norm(), 1e-14);
    let beyond = PlaneTensor::new(-1e5, 0.0, 0.0, -9e5);
    let memory = MaterialLaw::<Plane>::start(&law, &beyond, 0.6);
    let found = StressInvariants::of::<Plane>(&MaterialLaw::<Plane>::stress(&law, &memory));
    close(found.deviatoric, -found.mean * math::sin(0.6), found.deviatoric, 1e-12);
    close(found.mean, -5e5, 5e5, 1e-12);
    // Earth pressure at rest of an elastic body, out of the plane as in it.
    let at_rest = (BULK - SHEAR) / (BULK + SHEAR);
    let memory = MaterialLaw::<Plane>::start(&LINEAR, &PlaneTensor::new(-1e5 * at_rest, 0.0, 0.0, -1e5), 0.6);
    close(MaterialLaw::<Plane>::out_of_plane(&LINEAR, &memory), -1e5 * at_rest, 1e5, 1e-15);
}

/// F = R U taken apart again, for turns up to half a circle; and simple shear.
#[test]
fn deformations_are_taken_apart() {
    let mut random = Random(13);
    for _ in 0..2000 {
        let strain = SolidSymmetric::of(&random.tensor::<Solid>(0.4));
        let stretch = SolidTensor::identity() + strain.exponential().tensor();
        let rotation = random.rotation::<Solid>();
        same::<Solid>(&(rotation * rotation.transpose()), &SolidTensor::identity(), 1.0, 1e-14);
        same::<Solid>(&Solid::rotation(&(rotation * stretch)), &rotation, 1.0, 1e-13);
        let found = Deformation::of::<Solid>(&(rotation * stretch));
        close(found.volumetric, strain.trace(), 1.0, 1e-13);
        close(found.deviatoric, (2.0 * strain.deviator().square()).sqrt(), 1.0, 1e-13);
        close(math::cos(found.rotation_angle), 0.5 * (rotation.trace() - 1.0), 1.0, 1e-13);
    }
    for degrees in [-179.0f64, -30.0, 0.0, 1e-6, 90.0, 180.0] {
        let angle = degrees * math::PI / 180.0;
        let (sine, cosine) = (math::sin(angle), math::cos(angle));
        let gradient = PlaneTensor::new(cosine, -sine, sine, cosine) * PlaneTensor::new(1.3, 0.2, 0.2, 0.9);
        close(Deformation::of::<Plane>(&gradient).rotation_angle, angle, 1.0, 1e-14);
    }
    let shear = Deformation::of::<Plane>(&PlaneTensor::new(1.0, 1e-3, 0.0, 1.0));
    close(shear.volumetric, 0.0, 1.0, 1e-15);
    close(shear.deviatoric, 1e-3, 1e-3, 1e-6);
    close(shear.rotation_angle, -0.5e-3, 1e-3, 1e-6);
    let stress = SolidTensor::new(-1.0, 3.0, 0.0, 3.0, -1.0, 0.0, 0.0, 0.0, -1.0);
    assert_eq!(StressInvariants::of::<Solid>(&stress), StressInvariants { mean: -1.0, deviatoric: 3.0 });
}
