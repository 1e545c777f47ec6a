//! Figures that follow from an assembly of grains; [`super::derived`] has those of planar shear.

use std::path::Path;

use super::assembly::{Assembly, Packed, Preparation, Shape, Sizes, Source};
use super::derived::Moduli;
use super::stable::{self, Bound, GrainScale, HERTZ_OVERLAP, springs_at};
use crate::base::math::PI;
use crate::law::contact::{FLAT, Springs, Stiffening};
use crate::law::material::GrainModuli;

/// Share of sigma^2 that is left of a normal distribution cut at three deviations.
const VARIANCE_CUT: f64 = 0.973_3;
/// Standard deviations at which the normal distribution of diameters is cut.
const DIAMETER_CUT: f64 = 3.0;

impl Sizes {
    /// Mean diameter, m.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Normal { mean, .. } => *mean,
            Self::Uniform { min, max } => 0.5 * (min + max),
            Self::List(list) => list.iter().map(|(diameter, share)| diameter * share).sum(),
        }
    }

    /// Smallest diameter that can be drawn, m.
    pub fn min(&self) -> f64 {
        match self {
            Self::Normal { mean, deviation } => mean - DIAMETER_CUT * deviation,
            Self::Uniform { min, .. } => *min,
            Self::List(list) => list.iter().map(|(diameter, _)| *diameter).fold(f64::INFINITY, f64::min),
        }
    }

    /// Largest diameter that can be drawn, m.
    pub fn max(&self) -> f64 {
        match self {
            Self::Normal { mean, deviation } => mean + DIAMETER_CUT * deviation,
            Self::Uniform { max, .. } => *max,
            Self::List(list) => list.iter().map(|(diameter, _)| *diameter).fold(0.0, f64::max),
        }
    }

    /// Mean of d^2 (m2) or d^3 (m3).
    pub fn power_mean(&self, power: usize) -> f64 {
        let square = power == 2;
        match self {
            Self::Normal { mean, deviation } => {
                let variance = VARIANCE_CUT * deviation * deviation;
                if square { mean * mean + variance } else { mean * (mean * mean + 3.0 * variance) }
            }
            Self::Uniform { min, max } if square => (min * min + min * max + max * max) / 3.0,
            Self::Uniform { min, max } => (min + max) * (min * min + max * max) / 4.0,
            Self::List(list) => {
                let raised = |diameter: f64| if square { diameter * diameter } else { diameter * diameter * diameter };
                list.iter().map(|(diameter, share)| raised(*diameter) * share).sum()
            }
        }
    }
}

// Sizes

/// Sizes of grains to be made; those of a file are known to the file alone.
pub fn sizes(assembly: &Assembly) -> Option<&Sizes> {
    match &assembly.source {
        Source::Packed(packed) => Some(&packed.sizes),
        Source::File(_) => None,
    }
}

/// The largest diameter, or what the job calls the mean of those in its file, m.
pub fn diameter_max(assembly: &Assembly) -> f64 {
    sizes(assembly).map_or(assembly.matter.diameter_mean, Sizes::max)
}

/// What lists reach beyond grains in touch, m: the skin, and as far as grains that have touched hold on to each other.
pub fn margin(assembly: &Assembly) -> f64 {
    assembly.skin + assembly.contact.reach()
}

/// A grain of this assembly with that diameter.
pub fn grain(assembly: &Assembly, diameter: f64) -> GrainScale {
    GrainScale::of(0.5 * diameter, assembly.matter.density, assembly.cell.depth, assembly.cell.dimension)
}

/// Solid volume fractions that discs and spheres do not exceed.
const FRACTION_MAX: [f64; 2] = [0.92, 0.76];
/// Room beyond copies, as a share of what they are long at least.
const ROOM: f64 = 0.25;

/// Share by which the lengths of the job's cell change until grains compressed in it fill it to a solid volume fraction; one
/// where they are not compressed.
pub fn shrinkage(assembly: &Assembly, fraction: f64) -> f64 {
    match (&assembly.source, fraction_in_cell(assembly)) {
        (Source::Packed(Packed { preparation: Preparation::Compress { .. }, .. }), Some(filled)) => {
            let share = filled / fraction;
            if assembly.cell.dimension == 2 { share.sqrt() } else { crate::base::math::cbrt(share) }
        }
        _ => 1.0,
    }
}

/// The same to the smallest cell that grains which are compressed in it could fill.
pub fn shrinkage_most(assembly: &Assembly) -> f64 {
    shrinkage(assembly, FRACTION_MAX[assembly.cell.dimension - 2])
}

/// What is left free beyond copies of a packing at either end of an axis without a period, m: they may dilate there, and what holds them may move. By the
/// job alone, as the corner of its cell is.
pub fn room(assembly: &Assembly, axis: usize) -> f64 {
    let cell = &assembly.cell;
    let is_open = cell.copies.is_some() && axis < cell.dimension && !cell.periodic[axis];
    if is_open { ROOM * shrinkage_most(assembly) * (cell.end()[axis] - cell.lower[axis]) } else { 0.0 }
}

/// Area (m2) or volume (m3) of the cell as the job gives it.
pub fn cell_measure(assembly: &Assembly) -> f64 {
    let (cell, end) = (&assembly.cell, assembly.cell.end());
    (0..cell.dimension).map(|axis| end[axis] - cell.lower[axis]).product()
}

/// Share of the cell as the job gives it that the grains to be made fill.
pub fn fraction_in_cell(assembly: &Assembly) -> Option<f64> {
    let Source::Packed(packed) = &assembly.source else {
        return None;
    };
    let count = grains(assembly)? as f64;
    Some(count * grain_measure(&packed.sizes, assembly.cell.dimension) / cell_measure(assembly))
}

/// The same of grains of a CSV file, as far as it can be read; the box of a LAMMPS data file is held against the cell anyway.
pub fn fraction_of_file(assembly: &Assembly) -> Option<f64> {
    let file = assembly.source.file().filter(|file| file.extension().is_some_and(|extension| extension == "csv"))?;
    let text = std::fs::read_to_string(file).ok()?;
    let mut lines = text.lines();
    let column = lines.next()?.split(',').position(|name| name.trim() == "radius")?;
    let radius = |line: &str| line.split(',').nth(column).and_then(|radius| radius.trim().parse::<f64>().ok());
    let flat = assembly.cell.dimension == 2;
    let solid = |radius: f64| if flat { PI * radius * radius } else { 4.0 / 3.0 * PI * radius * radius * radius };
    let all: Option<f64> = lines.filter(|line| !line.trim().is_empty()).map(|line| radius(line).map(solid)).sum();
    all.map(|solid| solid / cell_measure(assembly))
}

/// Mean area (m2) of discs, mean volume (m3) of spheres.
pub fn grain_measure(sizes: &Sizes, dimension: usize) -> f64 {
    PI / if dimension == 2 { 4.0 } else { 6.0 } * sizes.power_mean(dimension)
}

/// Number of grains, as far as it is known: from the job, or from a look at the file.
pub fn grains(assembly: &Assembly) -> Option<u64> {
    match &assembly.source {
        Source::Packed(packed) => Some(packed.count.saturating_mul(assembly.cell.counts().iter().product())),
        Source::File(read) => grains_in_file(&read.grains),
    }
}

/// Rows of a CSV file below its header, or what the head of a LAMMPS data file says.
fn grains_in_file(file: &Path) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    if file.extension().is_some_and(|extension| extension == "csv") {
        return Some(text.lines().skip(1).filter(|line| !line.trim().is_empty()).count() as u64);
    }
    let line = text.lines().find(|line| line.split_whitespace().nth(1) == Some("atoms"))?;
    line.split_whitespace().next()?.parse().ok()
}

// The run

/// Steps of a run to `end`, s. An end that is a whole number of steps but for rounding takes no step more.
pub fn steps(end: f64, step: f64) -> u64 {
    ((end / step) * (1.0 - 1e-12)).ceil() as u64
}

/// Mean stress that the cell or its packing is held at, Pa, compression positive.
pub fn pressure(assembly: &Assembly) -> Option<f64> {
    let held: Vec<f64> =
        assembly.cell.servo.iter().flat_map(|servo| servo.stress).flatten().map(|stress| -stress).collect();
    let mean = held.iter().sum::<f64>() / held.len() as f64;
    if mean > 0.0 { Some(mean) } else { stresses_of_packing(assembly).first().copied() }
}

/// Mean stresses that a packing is compressed to and then unloaded to, Pa.
pub fn stresses_of_packing(assembly: &Assembly) -> Vec<f64> {
    match &assembly.source {
        Source::Packed(Packed { preparation: Preparation::Compress { stress, unloaded, .. }, .. }) => {
            std::iter::once(*stress).chain(*unloaded).collect()
        }
        _ => Vec::new(),
    }
}

/// Stiffness of mean contacts against the load across a grain, k_n/(p depth) or k_n/(p d): the reciprocal of the mean overlap
/// in diameters. None of Hertz contacts, which stiffen as they are loaded.
pub fn stiffness_number(assembly: &Assembly, pressure: f64) -> Option<f64> {
    let stiffens = assembly.contact.stiffening() == Stiffening::WithOverlap;
    (!stiffens).then(|| stiffness_over_load(assembly, pressure))
}

/// The same of any law, of Hertz contacts at an overlap that grains should not reach.
pub fn stiffness_over_load(assembly: &Assembly, pressure: f64) -> f64 {
    springs_mean(assembly).normal / (pressure * thickness(assembly))
}

/// Stiffness of mean contacts as a modulus, Pa, under a mean stress (Pa): Hertz contacts stiffen as they are loaded.
pub fn modulus_under(assembly: &Assembly, stress: f64) -> f64 {
    let radius = 0.5 * assembly.matter.diameter_mean;
    let springs = |overlap: f64| springs_at(&assembly.contact, [radius; 2], [FLAT; 2], overlap).normal;
    let thickness = thickness(assembly);
    let force = stress * 2.0 * radius * thickness;
    // F is 2/3 k d with k as the root of d.
    let share = force / (2.0 / 3.0 * springs(HERTZ_OVERLAP) * HERTZ_OVERLAP * radius);
    let root = crate::base::math::cbrt(share);
    springs(HERTZ_OVERLAP * root * root) / thickness
}

/// Contacts of a sphere in a dense frictional packing.
const COORDINATION_OF_SPHERES: f64 = 6.0;

/// Moduli of the packing under a stress (Pa) of at least its own if every grain moved with the mean field, Pa: in the plane [`super::derived::moduli_affine`], in
/// space `K = z Phi k_n/(6 pi r)` and `G = z Phi (k_n + 3 k_t/2)/(10 pi r)` (Walton 1987).
pub fn moduli_affine(assembly: &Assembly, fraction: f64, stress: f64) -> GrainModuli {
    let stress = stresses_of_packing(assembly).into_iter().fold(stress, f64::max);
    let springs = springs_mean(assembly);
    // Both springs of a Hertz contact stiffen alike.
    let share = match assembly.contact.stiffening() {
        Stiffening::WithOverlap => modulus_under(assembly, stress) * thickness(assembly) / springs.normal,
        _ => 1.0,
    };
    let [normal, tangential] = [springs.normal * share, springs.tangential * share];
    if assembly.cell.dimension == 2 {
        let springs = Springs { normal, tangential, ..springs };
        let Moduli { bulk, shear } = super::derived::moduli_affine(&springs, fraction, assembly.cell.depth);
        return GrainModuli { bulk_modulus: bulk, shear_modulus: shear };
    }
    let contacts = COORDINATION_OF_SPHERES * fraction / (PI * 0.5 * assembly.matter.diameter_mean);
    GrainModuli { bulk_modulus: contacts * normal / 6.0, shear_modulus: contacts * (normal + 1.5 * tangential) / 10.0 }
}

/// What a grain is thick across the plane of a section, m: the depth of discs, the mean diameter of spheres.
fn thickness(assembly: &Assembly) -> f64 {
    if assembly.cell.dimension == 2 { assembly.cell.depth } else { assembly.matter.diameter_mean }
}

/// Largest entry of the velocity gradient, 1/s.
pub fn rate_max(assembly: &Assembly) -> f64 {
    assembly.cell.gradient.iter().flatten().fold(0.0, |rate, entry| rate.max(entry.abs()))
}

/// I = rate d sqrt(rho/p): inertia against confinement; below about 1e-3 flow is quasi-static (GDR MiDi 2004).
pub fn inertial_number(assembly: &Assembly, rate: f64, pressure: f64) -> f64 {
    rate * assembly.matter.diameter_mean * (assembly.matter.density / pressure).sqrt()
}

// Stable time steps

/// Springs between two mean grains.
pub fn springs_mean(assembly: &Assembly) -> Springs {
    super::derived::springs_mean(&assembly.contact, assembly.matter.diameter_mean)
}

/// The same with their masses, from which a law with a coefficient of restitution has its dashpots.
pub fn springs_of_mean_grains(assembly: &Assembly) -> Springs {
    let diameter = assembly.matter.diameter_mean;
    let mass = grain(assembly, diameter).mass;
    springs_at(&assembly.contact, [0.5 * diameter; 2], [mass; 2], HERTZ_OVERLAP)
}

/// Diameters as the bounds of the step need them, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Diameters {
    /// Of the lightest grain that lies among mean ones.
    pub smallest: f64,
    /// Of all grains.
    pub mean: f64,
    /// Those of so many grains that they can gather: each is asked for among its like.
    pub classes: Vec<f64>,
}

/// Diameters of the job's grains; those of a file are its mean's.
pub fn diameters(assembly: &Assembly) -> Diameters {
    Diameters::of_job(assembly)
}

impl Diameters {
    /// Of grains to be made; those of a file are known to the file alone, and the job states their mean.
    fn of_job(assembly: &Assembly) -> Self {
        let mean = assembly.matter.diameter_mean;
        let (smallest, classes) = match sizes(assembly) {
            None => (mean, Vec::new()),
            Some(Sizes::List(list)) => (mean, list.iter().map(|(diameter, _)| *diameter).collect()),
            Some(sizes) => (sizes.min(), Vec::new()),
        };
        Self { smallest, mean, classes }
    }
}

/// What bounds the step by what the job alone says. Grains in a file have [`bounds_with`] once it is read.
pub fn bounds(assembly: &Assembly) -> Vec<Bound> {
    bounds_with(assembly, &Diameters::of_job(assembly))
}

/// What bounds the step: the contacts of grains, damping in proportion to mass, and bodies that servos move.
pub fn bounds_with(assembly: &Assembly, diameters: &Diameters) -> Vec<Bound> {
    let [lightest, mean] = [diameters.smallest, diameters.mean].map(|diameter| grain(assembly, diameter));
    let classes: Vec<GrainScale> = diameters.classes.iter().map(|diameter| grain(assembly, *diameter)).collect();
    let mut bounds = stable::bounds_of_sizes(&assembly.contact, &lightest, &mean, &classes);
    if assembly.damping.mass > 0.0 {
        bounds.push(Bound {
            cause: "damping in proportion to mass",
            formula: "2/c",
            remedy: "Beyond it the damping turns velocities round at every step; shorten the step, or lower damping.mass.",
            step: 2.0 / assembly.damping.mass,
        });
    }
    let held = assembly.bodies.iter().filter_map(|body| Some((&body.shape, body.motion.servo.as_ref()?)));
    let held = held.map(|(shape, servo)| {
        let count = contacts_along(assembly, shape, &servo.direction);
        stable::bound_of_servo(&assembly.contact, &mean, count, servo.mass)
    });
    bounds.extend(held.min_by(|a, b| a.step.total_cmp(&b.step)));
    bounds
}

/// Contacts that can press on a body along a direction: of as many mean grains as find room side by side in its shadow, two
/// of each where the body is itself a layer of grains.
fn contacts_along(assembly: &Assembly, shape: &Shape, direction: &[f64; 3]) -> f64 {
    let cell = &assembly.cell;
    let length = |axis: usize| cell.end()[axis] - cell.lower[axis];
    let extent = |axis: usize| match shape {
        Shape::Plane { .. } => length(axis),
        Shape::Box { lower, upper } | Shape::Layer { lower, upper } => upper[axis] - lower[axis],
        Shape::Cylinder { radius, axis: along, .. } => (2.0 * radius).max(along[axis].abs() * length(axis)),
    };
    let side_by_side = |axis: usize| extent(axis) / assembly.matter.diameter_mean;
    let shadow = |axis: usize| -> f64 {
        let across: f64 = (0..cell.dimension).filter(|other| *other != axis).map(side_by_side).product();
        direction[axis].abs() * across
    };
    let grains = (0..cell.dimension).map(shadow).sum::<f64>().max(1.0);
    if matches!(shape, Shape::Layer { .. }) { 2.0 * grains } else { grains }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of a uniform distribution by the sum over many of its diameters, and a list that is one.
    #[test]
    fn moments_of_sizes() {
        let uniform = Sizes::Uniform { min: 6e-3, max: 14e-3 };
        let classes = 10_000;
        let list = (0..classes)
            .map(|class| (6e-3 + 8e-3 * (f64::from(class) + 0.5) / f64::from(classes), 1.0 / f64::from(classes)))
            .collect();
        let list = Sizes::List(list);
        assert!((list.mean() / uniform.mean() - 1.0).abs() < 1e-9);
        for power in [2, 3] {
            assert!((list.power_mean(power) / uniform.power_mean(power) - 1.0).abs() < 1e-6);
        }
        let narrow = Sizes::Normal { mean: 1e-3, deviation: 0.0 };
        assert!((narrow.power_mean(3) / 1e-9 - 1.0).abs() < 1e-12);
        assert_eq!((narrow.min(), narrow.max()), (1e-3, 1e-3));
    }
}
