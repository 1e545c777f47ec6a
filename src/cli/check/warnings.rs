//! What is allowed, but probably not meant.

use super::Slots;
use super::page::{figures, megapascals};
use crate::analysis::strength::StrengthComparison;
use crate::couple::oracle::Criterion;
use crate::job::assembly::Shape;
use crate::job::figures::{rate_max, stresses_of_packing};
use crate::job::mpm::{InitialStress, Load, Mpm, Region, RegionShape, figures as of};
use crate::law::material::ConstitutiveLaw;
use crate::mpm::faces::BEYOND;
use crate::mpm::scheme::ShapeFunction;

/// Above this number grains feel inertia and stress depends on speed (da Cruz et al. 2005).
const INERTIAL_NUMBER_QUASI_STATIC: f64 = 1e-3;
/// Below this number overlaps are no longer small against a grain.
const STIFFNESS_NUMBER_MIN: f64 = 100.0;
/// A step this small a share of the stable one wastes time.
const STEP_SHARE_MIN: f64 = 0.1;
/// Share of the cell that it may deform by in one step before contacts are followed too coarsely.
const STRAIN_OF_STEP_MAX: f64 = 1e-4;
/// Moduli this many times the affine estimate cannot come from the contact law, which the estimate bounds from above.
const MODULUS_EXCESS_MAX: f64 = 1.5;
/// Below this factor a hybrid is not worth its trouble.
const SPEED_UP_MIN: f64 = 1.5;
/// Recent strain and distance that the paper calls the most one should take (Chen et al. 2021, 3.2 and 4).
const RECENT_STRAIN_MAX: f64 = 0.05;
const DISTANCE_IN_DIAMETERS_MAX: f64 = 30.0;
/// Mass conservation would want xi near chi; with much less the material does not soften as it dilates.
const SOFTENING_SHARE_MIN: f64 = 0.05;
/// How far a continuum may be from its grains: in strength as a share, if that is as many standard errors, and in stiffness as a factor.
const STRENGTH_OFF_MAX: f64 = 0.1;
const ERRORS_MAX: f64 = 3.0;
const STIFFNESS_OFF_MAX: f64 = 1.5;
/// How far stresses of points and packing may be apart.
const STRESS_OFF: f64 = 0.05;
/// Above this share of the wave speed motion is no longer slow against waves.
const MACH_MAX: f64 = 0.3;
/// How far the points' volume may be from the region's before it is worth a word.
const VOLUME_TOLERANCE: f64 = 0.01;

/// One sentence each, with what to write instead.
pub fn warnings(slots: &Slots) -> Vec<String> {
    let mut warnings = Vec::new();
    warnings.extend(step(slots));
    warnings.extend(strain_of_step(slots));
    warnings.extend(inertia(slots));
    warnings.extend(soft_contacts(slots));
    warnings.extend(endless_fall(slots));
    warnings.extend(softening(slots));
    warnings.extend(sudden_start(slots));
    warnings.extend(hybrid(slots));
    if let Some(Ok(compared)) = &slots.strength {
        warnings.extend(unlike_its_grains(compared));
    }
    if let Some(job) = slots.material() {
        warnings.extend(other_stress(job));
        warnings.extend(super::rves::too_large(job));
        warnings.extend(super::rves::without_adjoint(job));
        warnings.extend(super::rves::alone_in_its_mean(job));
        warnings.extend(fast_motion(job));
        warnings.extend(filled_regions(job, slots.job.regions()));
        if job.mesh.is_none() {
            warnings.extend(thin_bodies(job));
            warnings.extend(thin_material(job));
            warnings.extend(thin_under_load(job));
            warnings.extend(linear_shape(job));
        }
    }
    warnings
}

fn step(slots: &Slots) -> Option<String> {
    let cycle = slots.continuum.as_deref().map_or(1.0, |job| job.grain_steps as f64);
    let step = slots.job.step();
    let of_grains = slots.bounds_of_grains.iter().map(|bound| (bound.step, bound.cause));
    let of_continuum = slots.bounds_of_continuum.iter().map(|bound| (bound.step / cycle, bound.cause));
    let (stable, cause) = of_grains.chain(of_continuum).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let [share, longest] = [step / stable, stable].map(figures);
    if step > stable {
        return Some(format!(
            "the time step is {share} times the stable one, {longest} s ({cause}), and time.allow_unstable lets it pass."
        ));
    }
    (step < STEP_SHARE_MIN * stable).then(|| {
        format!("the time step is {share} of the stable one, {longest} s. A longer time.step would save time.")
    })
}

fn strain_of_step(slots: &Slots) -> Option<String> {
    let assembly = slots.grains.as_deref()?;
    let strain = rate_max(assembly) * slots.job.step();
    (strain > STRAIN_OF_STEP_MAX).then(|| {
        format!(
            "the cell deforms by {} in one step; above {STRAIN_OF_STEP_MAX} grains cannot follow. Lower cell.velocity_gradient or time.step.",
            figures(strain)
        )
    })
}

fn inertia(slots: &Slots) -> Option<String> {
    let (number, whose) = slots.inertial_numbers().pop()?;
    let (key, rate, unit) = slots.job.speed()?;
    (number > INERTIAL_NUMBER_QUASI_STATIC).then(|| {
        format!(
            "the inertial number is {} ({whose}); above {INERTIAL_NUMBER_QUASI_STATIC} stress depends on the rate. Lower {key} to at most {} {unit} for quasi-static deformation.",
            figures(number),
            figures(rate * INERTIAL_NUMBER_QUASI_STATIC / number)
        )
    })
}

fn soft_contacts(slots: &Slots) -> Option<String> {
    let number = slots.stiffness_number().filter(|number| *number < STIFFNESS_NUMBER_MIN)?;
    let [key, _] = slots.grains.as_deref()?.contact.keys_of_stiffness();
    Some(format!(
        "contacts are soft for their load: the stiffness number is {}, so mean overlaps exceed a hundredth of a diameter. Raise contact.{key} or lower {}.",
        figures(number),
        slots.job.key_of_pressure()
    ))
}

fn endless_fall(slots: &Slots) -> Option<String> {
    let assembly = slots.grains.as_deref()?;
    (assembly.bodies.is_empty() && assembly.gravity != [0.0; 3])
        .then(|| "there is gravity and no body to rest on, so grains gather speed until the run ends.".to_string())
}

fn softening(slots: &Slots) -> Option<String> {
    slots.job.plates()?;
    let law = slots.material()?.material.law.critical()?;
    (law.softening_rate < SOFTENING_SHARE_MIN * law.dilation_factor).then(|| {
        format!(
            "material.softening_rate = {} hardly softens the material: keeping mass while it dilates would take a rate near material.dilation_factor = {}. The continuum will localise through its weak regions alone.",
            law.softening_rate, law.dilation_factor
        )
    })
}

fn sudden_start(slots: &Slots) -> Option<String> {
    let (loading, job) = (slots.job.plates()?, slots.material()?);
    let crossing = job.grid.extent(1) / of::wave_speeds(job).1;
    (loading.speed_ramp < 2.0 * crossing).then(|| {
        format!(
            "a shear wave needs {} s through the specimen, and loading.speed_ramp = {} s is shorter than there and back: the start is a blow. A ramp of {} s would be gentle.",
            figures(crossing),
            figures(loading.speed_ramp),
            figures(10.0 * crossing)
        )
    })
}

fn hybrid(slots: &Slots) -> Vec<String> {
    let (Some(granular), Some(job), Some(affine)) =
        (slots.coupled(), slots.continuum.as_deref(), slots.moduli_of_contacts())
    else {
        return Vec::new();
    };
    let mut warnings = Vec::new();
    if slots.job.begins_as_grains() && slots.job.has_weak_regions() {
        warnings.push("zone.begins = \"everywhere\" has no points at the start, with which a weak region would begin: [[continuum.weak]] does nothing. Remove it, or write begins = \"band\".".into());
    }
    let law = &job.material.law;
    if law.yields() {
        let [bulk, shear] = [law.bulk_modulus(job.grid.dimension) / affine.bulk, law.shear_modulus() / affine.shear];
        if bulk.max(shear) > MODULUS_EXCESS_MAX {
            warnings.push(format!(
                "the continuum is stiffer than these contacts can make it: K is {} and G {} times the affine estimate, which is an upper bound. Stress will jump where grains replace points. Take moduli near {}, or stiffer contacts.",
                figures(bulk),
                figures(shear),
                megapascals(affine.bulk, affine.shear)
            ));
        }
    }
    if let Some(forecast) = slots.forecast.filter(|forecast| forecast.speed_up < SPEED_UP_MIN) {
        let verdict = if forecast.speed_up < 1.0 { "is slower than grains alone" } else { "hardly pays" };
        warnings.push(format!(
            "with zones of {} of the material a hybrid {verdict}: its speed-up is about {}. More grains in a cell, a smaller enrichment.distance or a larger specimen would help; method = \"dem\" is the alternative.",
            figures(forecast.zone),
            figures(forecast.speed_up)
        ));
    }
    let concentrates = job.oracle.is_some_and(|watch| matches!(watch.oracle.criterion, Criterion::Concentration(_)));
    if concentrates && matches!(job.material.law, ConstitutiveLaw::CriticalDruckerPrager(_)) {
        warnings.push(
            "material.law = \"critical_drucker_prager\" is elastic up to its cone: a band is there from the first plastic strain on and does not sharpen, so that oracle.criterion = \"concentration\" may find none. Take \"mobilised_friction\", or criterion = \"laplacian\".".into(),
        );
    }
    if matches!(job.material.law, ConstitutiveLaw::MobilisedFriction(_)) && job.nonlocal.is_none() {
        warnings.push(
            "material.law = \"mobilised_friction\" softens, and without a length of its own such a continuum puts its band into one row of cells before grains come to their peak. Add [nonlocal] with a radius of some ten mean diameters.".into(),
        );
    }
    let recent_strain = job.oracle.and_then(|watch| match watch.oracle.criterion {
        Criterion::Laplacian(by) => Some(by.recent_strain),
        Criterion::Concentration(_) => None,
    });
    if let Some(recent_strain) = recent_strain.filter(|strain| *strain > RECENT_STRAIN_MAX) {
        warnings.push(format!(
            "oracle.recent_strain = {recent_strain} is more than the {RECENT_STRAIN_MAX} that the method's authors call the most; bands may never be found."
        ));
    }
    let distance = granular.enrichment.distance / granular.piece.matter.diameter_mean;
    if distance > DISTANCE_IN_DIAMETERS_MAX {
        warnings.push(format!(
            "enrichment.distance is {} mean diameters; bands are 10 to 30 thick, and more than {DISTANCE_IN_DIAMETERS_MAX} only costs time.",
            figures(distance)
        ));
    }
    warnings
}

/// A continuum that is another material than the grains which take its place.
fn unlike_its_grains(compared: &StrengthComparison) -> Vec<String> {
    let StrengthComparison { continuum, grains, error } = compared;
    let mut warnings = Vec::new();
    let remedy = "`scree calibrate JOB --law mobilised_friction` makes the material of these grains.";
    let is_beyond = |strength: f64, of: f64, error: f64| {
        (strength / of - 1.0).abs() > STRENGTH_OFF_MAX && (strength - of).abs() > ERRORS_MAX * error
    };
    if is_beyond(continuum.strength, grains.strength, error.strength) {
        let consequence = if continuum.strength > grains.strength {
            "nothing can shear but the zone, so that the place of a band is put in by hand"
        } else {
            "it shears around grains that stand still, and what the run shows is no stress of these"
        };
        warnings.push(format!(
            "the continuum is {} times as strong as its grains: {consequence}. {remedy}",
            figures(continuum.strength / grains.strength)
        ));
    }
    let ratio = continuum.stiffness / grains.stiffness;
    if !(1.0 / STIFFNESS_OFF_MAX..=STIFFNESS_OFF_MAX).contains(&ratio) {
        warnings.push(format!(
            "the continuum is {} times as stiff as its grains in shear: stress will jump where grains replace points. {remedy}",
            figures(ratio)
        ));
    }
    warnings
}

/// Stresses of the start that are not alike.
fn other_stress(job: &Mpm) -> Option<String> {
    // RVEs are compressed from their packing on.
    if job.rves().is_some() {
        return None;
    }
    let stress = stresses_of_packing(&job.grains.as_ref()?.piece).pop()?;
    let InitialStress::Isotropic { pressure } = job.stress else { return None };
    ((pressure / stress - 1.0).abs() > STRESS_OFF).then(|| {
        format!(
            "points begin under {} kPa (stress.pressure) and the packing under {} kPa ([packing]): grains that replace points would bear something else. Write the same.",
            figures(1e-3 * pressure),
            figures(1e-3 * stress)
        )
    })
}

fn fast_motion(job: &Mpm) -> Option<String> {
    let share = of::speed_max(job) / of::wave_speeds(job).0;
    (share > MACH_MAX).then(|| {
        format!(
            "the job moves material at {} of the speed of its waves; above {MACH_MAX} it is a blow, not a load.",
            figures(share)
        )
    })
}

fn filled_regions(job: &Mpm, regions: &[Region]) -> Vec<String> {
    let mut warnings = Vec::new();
    for (number, region) in regions.iter().enumerate() {
        let RegionShape::Box { lower, upper } = &region.shape else { continue };
        // Elements of a file have any edges.
        if job.drawn().is_some() {
            continue;
        }
        let inside = |index: &[usize; 3]| region.shape.contains(&job.place(*index));
        let count = of::indices(of::places_of(job, region)).filter(inside).count();
        let depth = if job.grid.dimension == 2 { job.grid.depth } else { 1.0 };
        let volume: f64 = (0..job.grid.dimension).map(|axis| upper[axis] - lower[axis]).product::<f64>() * depth;
        let filled = count as f64 * job.point_volume() / volume;
        if (filled - 1.0).abs() > VOLUME_TOLERANCE {
            warnings.push(format!(
                "the points of region {} fill {} of its box: its edges do not lie midway between places of points, which are {} mm apart.",
                number + 1,
                figures(filled),
                match &job.mesh {
                    Some(_) => super::page::times(job.grid.dimension, |axis| figures(1e3 * job.spacing_along(axis))),
                    None => figures(1e3 * job.spacing()),
                }
            ));
        }
    }
    warnings
}

/// How far a node's function reaches, in cells.
fn reach(shape: ShapeFunction) -> f64 {
    match shape {
        ShapeFunction::Linear => 1.0,
        ShapeFunction::Generalised | ShapeFunction::Quadratic => 1.5,
        ShapeFunction::Cubic => 2.0,
    }
}

fn thin_bodies(job: &Mpm) -> Vec<String> {
    let mut warnings = Vec::new();
    for body in &job.bodies {
        let thickness = match &body.body.shape {
            Shape::Box { lower, upper } => {
                (0..job.grid.dimension).map(|axis| upper[axis] - lower[axis]).fold(f64::INFINITY, f64::min)
            }
            Shape::Cylinder { radius, .. } => 2.0 * radius,
            Shape::Plane { .. } | Shape::Layer { .. } => continue,
        };
        let wanted = 2.0 * reach(job.scheme.shape) * job.grid.cell;
        // Rounding makes no body thinner.
        if thickness < wanted * (1.0 - 1e-9) {
            warnings.push(format!(
                "body `{}` is {} mm thick. Material reaches nodes beyond its middle, which hold it from the other side: make it {} mm at least, or the cells smaller.",
                body.body.name,
                figures(1e3 * thickness),
                figures(1e3 * wanted)
            ));
        }
    }
    warnings
}

/// A face weighs its nodes by the material in front of it, whose far side must not count among them.
fn thin_material(job: &Mpm) -> Vec<String> {
    let felt = (reach(job.scheme.shape) + BEYOND) * job.grid.cell;
    let mut warnings = Vec::new();
    for body in job.bodies.iter().filter(|body| body.at_face) {
        let Shape::Box { lower, upper } = &body.body.shape else { continue };
        for region in &job.regions {
            let (from, to) = of::bounding_box(&region.shape);
            let touches = |axis: &usize| to[*axis] <= lower[*axis] || from[*axis] >= upper[*axis];
            let thin = |axis: &usize| to[*axis] - from[*axis] < felt;
            if (0..job.grid.dimension).filter(touches).any(|axis| thin(&axis)) {
                warnings.push(format!(
                    "the material before body `{}` is thinner than {} mm, within which its face is felt, and bears nothing of it: make it thicker, take smaller cells, or write contact_at = \"nodes\".",
                    body.body.name,
                    figures(1e3 * felt)
                ));
                break;
            }
        }
    }
    warnings
}

/// A pressure weighs its nodes by the material behind it, whose far side must not count among them.
fn thin_under_load(job: &Mpm) -> Vec<String> {
    let cells = match job.scheme.shape {
        ShapeFunction::Linear | ShapeFunction::Generalised => 1.0,
        ShapeFunction::Quadratic | ShapeFunction::Cubic => 3.0,
    };
    let rows = (cells * job.grid.cell / job.spacing()).round() as usize;
    let on_surface = job.loads.iter().filter(|load| load.on_surface);
    let thin = on_surface.filter(|load| of::rows_behind(job, load, rows) < rows);
    let words = |load: &Load| {
        format!(
            "the material under the pressure on {} is thinner than {} mm, so that its far side shares nodes with it, and not all of the pressure is there: make it thicker, take smaller cells, or write acts_at = \"points\".",
            load.face.name(),
            figures(1e3 * rows as f64 * job.spacing())
        )
    };
    thin.map(words).collect()
}

fn linear_shape(job: &Mpm) -> Option<String> {
    (job.scheme.shape == ShapeFunction::Linear).then(|| {
        "with linear shape functions points that cross from cell to cell make their stresses jump, and nothing but a flip below 1 takes away the energy of that. Quadratic ones do not."
            .to_string()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::strength::Sheared;

    #[test]
    fn a_continuum_that_is_not_its_grains_is_told_and_noise_is_not() {
        let told = |strength: f64, stiffness: f64| {
            let grains = Sheared { strength: 0.42, stiffness: 50e6 };
            let error = Sheared { strength: 0.02, stiffness: 3e6 };
            unlike_its_grains(&StrengthComparison { continuum: Sheared { strength, stiffness }, grains, error })
        };
        assert!(told(0.47, 60e6).is_empty() && told(0.37, 40e6).is_empty());
        let [strong, weak] = [told(0.55, 50e6), told(0.3, 50e6)];
        assert!(strong[0].contains("1.31 times as strong as its grains: nothing can shear but the zone"), "{strong:?}");
        assert!(weak[0].contains("it shears around grains that stand still"), "{weak:?}");
        let [stiff, soft] = [told(0.42, 100e6), told(0.42, 20e6)];
        assert!(stiff[0].contains("2 times as stiff") && soft[0].contains("0.4 times as stiff"), "{stiff:?} {soft:?}");
    }
}
