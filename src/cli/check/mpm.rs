//! A continuum of material points on a grid.

use super::STEP_SHARE_MIN;
use super::assembly::motion;
use super::granular::{self, grains};
use super::page::{Page, figures, whole};
use crate::job::Method;
use crate::job::assembly::Shape;
use crate::job::figures::bounds as bounds_of_grains;
use crate::job::mpm::forecast::Forecast;
use crate::job::mpm::{BodyContact, Boundary, Face, InitialStress, LoadKind, Mpm, RegionShape, figures as of};
use crate::job::stable::governing;
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};

/// Above this share of the wave speed motion is no longer slow against waves.
const MACH_MAX: f64 = 0.3;
/// How far the points' volume may be from the region's before it is worth a word.
const VOLUME_TOLERANCE: f64 = 0.01;

/// The whole printout.
pub fn page(job: &Mpm) -> String {
    let mut page = Page(String::new());
    let space = if job.grid.dimension == 2 { "plane strain" } else { "in space" };
    let with = if job.grains.is_some() { ", with grains" } else { "" };
    page.line(&format!("{}: a continuum on a grid, {space}{with}", job.name));
    let counts = of::points_of_regions(job);
    grid(&mut page, job);
    scheme(&mut page, job);
    material(&mut page, job);
    regions(&mut page, job, &counts);
    boundaries(&mut page, job);
    loads(&mut page, job);
    membranes(&mut page, job);
    bodies(&mut page, job);
    grains(&mut page, job);
    steps(&mut page, job);
    cost(&mut page, job);
    for warning in warnings(job) {
        page.line(&format!("\nwarning: {warning}"));
    }
    page.0
}

/// `1 x 2 x 3`, of the grid's axes.
fn times(job: &Mpm, of: impl Fn(usize) -> String) -> String {
    (0..job.grid.dimension).map(of).collect::<Vec<_>>().join(" x ")
}

/// `1, 2, 3`, of the grid's axes.
fn components(job: &Mpm, vector: &[f64; 3]) -> String {
    vector[..job.grid.dimension].iter().map(|component| figures(*component)).collect::<Vec<_>>().join(", ")
}

fn grid(page: &mut Page, job: &Mpm) {
    let grid = &job.grid;
    page.section("Grid");
    page.row("extent", &format!("{} m", times(job, |axis| figures(grid.extent(axis)))), "between the walls");
    page.row(
        "cells",
        &times(job, |axis| whole(grid.cells[axis] as f64)),
        &format!("{} mm each", figures(1e3 * grid.cell)),
    );
    if grid.dimension == 2 {
        page.row("depth", &format!("{} mm", figures(1e3 * grid.depth)), "out of the plane");
    }
    let blocks = of::blocks(job);
    page.row(
        "blocks",
        &times(job, |axis| whole(blocks[axis] as f64)),
        &format!("{} cells along each edge, at least", job.cells_per_block),
    );
}

fn scheme(page: &mut Page, job: &Mpm) {
    page.section("Scheme");
    page.row(
        "shape functions",
        match job.scheme.shape {
            ShapeFunction::Linear => "linear",
            ShapeFunction::Generalised => "generalised (uGIMP)",
            ShapeFunction::Quadratic => "quadratic B-splines",
            ShapeFunction::Cubic => "cubic B-splines",
        },
        "",
    );
    page.row(
        "stress follows strain",
        match job.scheme.update {
            StressUpdate::First => "first (USF)",
            StressUpdate::Last => "last (USL)",
            StressUpdate::ModifiedLast => "modified last (MUSL)",
        },
        "",
    );
    match job.scheme.transfer {
        Transfer::Blend { flip } => page.row("velocities", &format!("{flip} FLIP"), "the rest PIC"),
        Transfer::Affine => page.row("velocities", "affine (APIC)", ""),
    }
}

fn material(page: &mut Page, job: &Mpm) {
    page.section("Material");
    let axes = job.grid.dimension;
    page.keys(axes, |form| job.material.law.clone().keys(form));
    page.row("density", &format!("{} kg/m3", figures(job.material.density)), "");
    let (along, across) = of::wave_speeds(job);
    page.row("wave speeds", &format!("{} and {} m/s", figures(along), figures(across)), "along and across");
}

fn regions(page: &mut Page, job: &Mpm, counts: &[u64]) {
    page.section("Material at the start");
    for (region, count) in job.regions.iter().zip(counts) {
        let shape = match region.shape {
            RegionShape::Box { .. } => "box",
            RegionShape::Ball { .. } if job.grid.dimension == 2 => "disc",
            RegionShape::Ball { .. } => "ball",
            RegionShape::Polygon { .. } => "polygon",
        };
        page.row(
            shape,
            &format!("{} points", whole(*count as f64)),
            if region.waves.is_empty() { "" } else { "waves" },
        );
    }
    let points: u64 = counts.iter().sum();
    page.row(
        "points",
        &whole(points as f64),
        &format!("{} mm apart, {} per cell", figures(1e3 * job.spacing()), {
            job.scheme.points_per_cell.pow(job.grid.dimension as u32)
        }),
    );
    page.row("mass", &format!("{} kg", figures(of::mass(job, points))), "");
    match &job.stress {
        InitialStress::None => page.row("stress", "none", ""),
        InitialStress::Isotropic { pressure } => {
            page.row("stress", &format!("{} kPa", figures(1e-3 * pressure)), "isotropic pressure");
        }
        InitialStress::Geostatic { surface, k0, surcharge, .. } => page.row(
            "stress",
            "geostatic",
            &format!(
                "below {} m, k0 = {}, {} kPa on the surface",
                figures(*surface),
                figures(*k0),
                figures(1e-3 * surcharge)
            ),
        ),
    }
    if job.gravity.acceleration != [0.0; 3] {
        let note =
            if job.gravity.ramp > 0.0 { format!("after {} s", figures(job.gravity.ramp)) } else { String::new() };
        page.row("gravity", &format!("{} m/s2", components(job, &job.gravity.acceleration)), &note);
    }
}

fn boundaries(page: &mut Page, job: &Mpm) {
    page.section("Faces of the grid (roller where the job says nothing)");
    for face in Face::all(job.grid.dimension) {
        let kind = match job.boundaries[face.axis][usize::from(face.upper)] {
            Boundary::Periodic => "periodic".to_string(),
            Boundary::Fixed => "fixed".to_string(),
            Boundary::Roller => "roller".to_string(),
            Boundary::Friction { coefficient } => format!("friction {}", figures(coefficient)),
            Boundary::Absorbing => "absorbing".to_string(),
            Boundary::Free => "free".to_string(),
        };
        page.row(&face.name(), &kind, "");
    }
}

fn loads(page: &mut Page, job: &Mpm) {
    if job.loads.is_empty() {
        return;
    }
    page.section("Loads");
    for load in &job.loads {
        let points = of::points_loaded(job, load);
        let value = match &load.kind {
            LoadKind::Traction(traction) => {
                format!("{} Pa", components(job, traction))
            }
            LoadKind::Pressure(pressure) => format!("{} Pa", figures(*pressure)),
        };
        let kind = match load.kind {
            LoadKind::Traction(_) => "dead traction",
            LoadKind::Pressure(_) => "pressure that follows the surface",
        };
        page.row(
            &load.face.name(),
            &value,
            &format!("{kind} on {} points, {} m2", whole(points as f64), figures(points as f64 * job.point_area())),
        );
    }
}

fn membranes(page: &mut Page, job: &Mpm) {
    if job.membranes.is_empty() {
        return;
    }
    page.section("Membranes");
    for membrane in &job.membranes {
        let segments = format!("{} segments of {} mm", membrane.segments(), figures(1e3 * membrane.segment()));
        let kind = if membrane.is_closed() { "a ring" } else { "a line" };
        page.row(
            &membrane.name,
            &format!("{} kPa", figures(1e-3 * membrane.pressure)),
            &format!(
                "to the left of its way; {kind} of {segments}, {} g in all, {} N at the start",
                figures(1e3 * membrane.segments() as f64 * membrane.mass_of_segment(job.grid.depth)),
                figures(membrane.tension)
            ),
        );
    }
}

fn bodies(page: &mut Page, job: &Mpm) {
    if job.bodies.is_empty() {
        return;
    }
    page.section("Bodies");
    for body in &job.bodies {
        let shape = match &body.body.shape {
            Shape::Plane { .. } => "plane",
            Shape::Box { .. } => "box",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Layer { .. } => "layer",
        };
        let contact = match body.contact {
            BodyContact::Rough => "rough".to_string(),
            BodyContact::Smooth => "smooth".to_string(),
            BodyContact::Coulomb { friction } => format!("friction {}", figures(friction)),
        };
        let held = if body.separates { "" } else { ", never parts" };
        page.row(&body.body.name, &format!("{shape}, {contact}{held}"), &motion(&body.body));
    }
}

fn steps(page: &mut Page, job: &Mpm) {
    page.section("Time step");
    page.row(
        "step of the job",
        &format!("{} s", figures(job.step)),
        if job.grains.is_some() { "of grains" } else { "" },
    );
    if let Some(grains) = &job.grains {
        page.bounds("stable step of grains", &bounds_of_grains(&grains.piece));
        let together = format!("{} steps of grains", job.grain_steps);
        page.row("step of the continuum", &format!("{} s", figures(job.step_of_continuum())), &together);
    }
    page.bounds("stable step", &of::bounds(job));
}

fn cost(page: &mut Page, job: &Mpm) {
    let of_job = Forecast::of(job);
    let hours = |seconds: f64| format!("{} h ({} s)", figures(seconds / 3600.0), figures(seconds));
    page.section("Cost");
    page.row("simulated time", &format!("{} s", figures(job.end)), "");
    page.row("steps", &whole(of::steps(job) as f64), "");
    let method = job.grains.as_deref().map(|granular| granular.method);
    if method == Some(Method::Hybrid) {
        let rows = format!("{} points, {} grains", whole(of_job.points), whole(of_job.grains));
        let share = figures(100.0 * of_job.zone);
        page.row("after enrichment", &rows, &format!("about, in zones of {share} % of the material"));
    }
    page.row("memory", &format!("{} MB", figures(1e-6 * of_job.memory)), "of all ranks together, about");
    if of_job.piece > 0.0 {
        page.row("making the packing", &hours(of_job.piece), "about; none where packing.cache has it");
    }
    if of_job.specimen > 0.0 {
        page.row("bringing it to rest", &hours(of_job.specimen), "about; none where packing.cache has it");
    }
    let note = match method {
        Some(Method::Hybrid) => "of the steps on one core, with grains from the start".to_string(),
        Some(Method::Dem) => "of the steps on one core".to_string(),
        _ => format!("on one core, at {} ns a point and step", whole(1e9 * of::cost_of_point(job))),
    };
    page.row("time to run", &hours(of_job.steps), &note);
    let rows = of_job.points + of_job.grains;
    page.pictures(&job.output, job.end, [rows, of_job.grains], job.grid.dimension);
}

/// How far a node's function reaches, in cells.
fn reach(shape: ShapeFunction) -> f64 {
    match shape {
        ShapeFunction::Linear => 1.0,
        ShapeFunction::Generalised | ShapeFunction::Quadratic => 1.5,
        ShapeFunction::Cubic => 2.0,
    }
}

/// What is allowed, but probably not meant.
fn warnings(job: &Mpm) -> Vec<String> {
    let mut warnings = granular::warnings(job);
    let stable = governing(&of::bounds(job)).step;
    if job.step_of_continuum() < STEP_SHARE_MIN * stable {
        warnings.push(format!(
            "the time step is {} of the stable one, {} s. A longer time.step would save time.",
            figures(job.step_of_continuum() / stable),
            figures(stable)
        ));
    }
    let share = of::speed_max(job) / of::wave_speeds(job).0;
    if share > MACH_MAX {
        warnings.push(format!(
            "the job moves material at {} of the speed of its waves; above {MACH_MAX} it is a blow, not a load.",
            figures(share)
        ));
    }
    for (number, region) in job.regions.iter().enumerate() {
        let RegionShape::Box { lower, upper } = &region.shape else { continue };
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
                figures(1e3 * job.spacing())
            ));
        }
    }
    for body in &job.bodies {
        let thickness = match &body.body.shape {
            Shape::Box { lower, upper } => {
                (0..job.grid.dimension).map(|axis| upper[axis] - lower[axis]).fold(f64::INFINITY, f64::min)
            }
            Shape::Cylinder { radius, .. } => 2.0 * radius,
            Shape::Plane { .. } | Shape::Layer { .. } => continue,
        };
        let wanted = 2.0 * reach(job.scheme.shape) * job.grid.cell;
        if thickness < wanted {
            warnings.push(format!(
                "body `{}` is {} mm thick. Material reaches nodes beyond its middle, which hold it from the other side: make it {} mm at least, or the cells smaller.",
                body.body.name,
                figures(1e3 * thickness),
                figures(1e3 * wanted)
            ));
        }
    }
    if job.scheme.shape == ShapeFunction::Linear {
        warnings.push(
            "with linear shape functions points that cross from cell to cell make their stresses jump, and nothing but a flip below 1 takes away the energy of that. Quadratic ones do not."
                .to_string(),
        );
    }
    warnings
}
