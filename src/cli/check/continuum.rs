//! The continuum: scheme, material, and where the material is at the start.

use super::Slots;
use super::page::{Page, figures, whole};
use crate::job::mpm::{RegionShape, figures as of};
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};

pub fn scheme(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.material() else { return };
    if let Some(mut mesh) = job.mesh {
        page.section("Elements");
        let kind = if job.grid.dimension == 2 { "quadrilaterals of 4 nodes" } else { "hexahedra of 8 nodes" };
        page.row("elements", kind, "one point of quadrature, mean gradients of the start (Flanagan & Belytschko 1981)");
        page.keys(job.grid.dimension, |form| mesh.keys_of_elements(form));
        return;
    }
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
    let law = job.material.law;
    let mut law = if slots.job.is_told_by_packing() { law.with_fraction(None) } else { law };
    page.keys(job.grid.dimension, |form| law.keys(form));
    page.row("density", &format!("{} kg/m3", figures(job.material.density)), "with pores");
    let (along, across) = of::wave_speeds(job);
    page.row("wave speeds", &format!("{} and {} m/s", figures(along), figures(across)), "along and across");
}

pub fn start(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.continuum.as_deref() else { return };
    page.section("Material at the start");
    let counts = of::points_of_regions(job);
    let points: u64 = counts.iter().sum();
    for (region, count) in slots.job.regions().iter().zip(&counts) {
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
        let (what, note) = match job.mesh {
            Some(_) => ("elements", "with a material point each".to_string()),
            None => ("material points", format!("{} mm apart, {per_cell} in a cell", figures(1e3 * job.spacing()))),
        };
        page.row(what, &whole(points as f64), &note);
    }
    page.row("mass", &format!("{} kg", figures(of::mass(job, points))), "");
    page.keys(job.grid.dimension, |form| job.stress.clone().keys(form));
}
