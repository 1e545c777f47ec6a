//! The continuum: scheme, material, and where the material is at the start.

use super::Slots;
use super::page::{Page, figures, whole};
use crate::job::mpm::{MeshFile, RegionShape, figures as of};
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};

pub fn scheme(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.material() else { return };
    if let Some(mut mesh) = job.mesh.clone() {
        page.section("Elements");
        if let Some(file) = &mesh.file {
            file_of_mesh(page, file, job.grid.dimension);
        }
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

/// A mesh that was read, with the groups that a job may name.
fn file_of_mesh(page: &mut Page, file: &MeshFile, axes: usize) {
    let drawn = &file.drawn;
    let counts = format!("{} of {} nodes", whole(drawn.elements.len() as f64), whole(drawn.vertices.len() as f64));
    page.row("file", &file.path.display().to_string(), &format!("{counts}, SHA-256 {}", &file.digest[..16]));
    let extreme = |pick: fn(f64, f64) -> f64| drawn.volumes.iter().copied().reduce(pick).unwrap_or_default();
    let note = if axes == 2 { "with the depth" } else { "" };
    page.row("volumes", &format!("{} to {} m3", figures(extreme(f64::min)), figures(extreme(f64::max))), note);
    for (what, of_sides) in [("groups of elements", false), ("groups of sides", true)] {
        let names = drawn.names_of(of_sides);
        page.row(what, &if names.is_empty() { "none".to_string() } else { names.join(", ") }, "");
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
            RegionShape::Group { .. } => "group",
        };
        let waves = if region.waves.is_empty() { "" } else { "waves" };
        page.row(shape, &format!("{} points", whole(*count as f64)), waves);
    }
    if slots.material().is_some() {
        let per_cell = job.scheme.points_per_cell.pow(job.grid.dimension as u32);
        let (what, note) = match &job.mesh {
            Some(_) => ("elements", "with a material point each".to_string()),
            None => ("material points", format!("{} mm apart, {per_cell} in a cell", figures(1e3 * job.spacing()))),
        };
        page.row(what, &whole(points as f64), &note);
    }
    page.row("mass", &format!("{} kg", figures(of::mass(job, points))), "");
    page.keys(job.grid.dimension, |form| job.stress.clone().keys(form));
}
