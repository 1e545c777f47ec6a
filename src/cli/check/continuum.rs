//! The continuum: scheme, material, and where the material is at the start.

use super::Slots;
use super::page::{Page, figures, megapascals, whole};
use crate::base::math::PI;
use crate::job::mpm::{InitialStress, MaterialLaw, RegionShape, figures as of};
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};

pub fn scheme(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.material() else { return };
    page.section("Scheme");
    let shape = match job.scheme.shape {
        ShapeFunction::Linear => "linear",
        ShapeFunction::Generalised => "generalised (uGIMP)",
        ShapeFunction::Quadratic => "quadratic B-splines",
        ShapeFunction::Cubic => "cubic B-splines",
    };
    page.row("shape functions", shape, "");
    let update = match job.scheme.update {
        StressUpdate::First => "first (USF)",
        StressUpdate::Last => "last (USL)",
        StressUpdate::ModifiedLast => "modified last (MUSL)",
    };
    page.row("stress update", update, "");
    match job.scheme.transfer {
        Transfer::Blend { flip } => page.row("velocities", &format!("{flip} FLIP"), "the rest PIC"),
        Transfer::Affine => page.row("velocities", "affine (APIC)", ""),
    }
}

pub fn material(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.material() else { return };
    page.section("Material");
    let axes = job.grid.dimension;
    let (name, bulk) = match &job.material.law {
        MaterialLaw::LinearElastic(law) => ("linear_elastic", law.bulk_modulus_in(axes)),
        MaterialLaw::Hencky(law) => ("hencky", law.bulk_modulus_in(axes)),
        MaterialLaw::CriticalDruckerPrager(law) => ("critical_drucker_prager", law.bulk_modulus),
    };
    page.row("law", name, "");
    let note = if axes == 2 { "K of the mean of two axes" } else { "" };
    page.row("K and G", &megapascals(bulk, job.material.law.shear_modulus()), note);
    if let MaterialLaw::CriticalDruckerPrager(law) = &job.material.law {
        let degrees = |angle: f64| format!("{} deg", figures(angle * 180.0 / PI));
        page.row("phi_cs", &degrees(law.friction_angle_critical), "friction angle of the critical state");
        let fractions = format!("{} and {}", figures(law.fraction), figures(law.fraction_critical));
        page.row("Phi and Phi_cs", &fractions, "solid volume fraction at the start and of the critical state");
        let rates = format!("{} and {}", figures(law.dilation_factor), figures(law.softening_rate));
        page.row("chi and xi", &rates, "dilation and softening");
        page.row("cohesion", &format!("{} kPa", figures(1e-3 * law.cohesion)), "");
        if let Some(angle) = law.dilation_angle {
            page.row("psi", &degrees(angle), "dilation angle, constant");
        }
    }
    page.row("density", &format!("{} kg/m3", figures(job.material.density)), "with pores");
    let (along, across) = of::wave_speeds(job);
    page.row("wave speeds", &format!("{} and {} m/s", figures(along), figures(across)), "along and across");
}

pub fn start(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.continuum.as_deref() else { return };
    page.section("Material at the start");
    let counts = of::points_of_regions(job);
    let points: u64 = counts.iter().sum();
    let regions = if slots.job.as_mpm().is_some() { &job.regions[..] } else { &[] };
    for (region, count) in regions.iter().zip(&counts) {
        let shape = match region.shape {
            RegionShape::Box { .. } => "box",
            RegionShape::Ball { .. } if job.grid.dimension == 2 => "disc",
            RegionShape::Ball { .. } => "ball",
            RegionShape::Polygon { .. } => "polygon",
        };
        let waves = if region.waves.is_empty() { "" } else { "waves" };
        page.row(shape, &format!("{} points", whole(*count as f64)), waves);
    }
    if slots.material().is_some() {
        let per_cell = job.scheme.points_per_cell.pow(job.grid.dimension as u32);
        let note = format!("{} mm apart, {per_cell} in a cell", figures(1e3 * job.spacing()));
        page.row("material points", &whole(points as f64), &note);
    }
    page.row("mass", &format!("{} kg", figures(of::mass(job, points))), "");
    match &job.stress {
        InitialStress::None => page.row("stress", "none", ""),
        InitialStress::Isotropic { pressure } => {
            page.row("stress", &format!("{} kPa", figures(1e-3 * pressure)), "isotropic pressure");
        }
        InitialStress::Geostatic { surface, k0, surcharge, .. } => {
            let [surface, k0, surcharge] = [*surface, *k0, 1e-3 * surcharge].map(figures);
            let note = format!("below {surface} m, k0 = {k0}, {surcharge} kPa on the surface");
            page.row("stress", "geostatic", &note);
        }
    }
}
