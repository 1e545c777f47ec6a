//! The domain: its size, periods and decomposition, how it deforms, what acts on all of it and at its faces.

use super::Slots;
use super::page::{Page, components, figures, times, whole};
use crate::base::space::AXES;
use crate::job::Assembly;
use crate::job::mpm::{Boundary, Face, LoadKind, figures as of};

pub fn section(page: &mut Page, slots: &Slots) {
    page.section("Domain");
    let axes = slots.job.dimension();
    let (lower, upper, periodic, depth) = match (&slots.continuum, &slots.grains) {
        (Some(on), _) => (on.grid.lower, on.grid.upper, on.grid.periodic, on.grid.depth),
        (None, Some(grains)) => (grains.cell.lower, grains.cell.end(), grains.cell.periodic, grains.cell.depth),
        (None, None) => unreachable!("a job has grains or a continuum"),
    };
    let periods: Vec<&str> = (0..axes).filter(|axis| periodic[*axis]).map(|axis| AXES[axis]).collect();
    let note = match periods.is_empty() {
        true => "not periodic".to_string(),
        false => format!("periodic in {}", periods.join(", ")),
    };
    page.row("extent", &format!("{} mm", times(axes, |axis| figures(1e3 * (upper[axis] - lower[axis])))), &note);
    if axes == 2 {
        page.row("depth", &format!("{} mm", figures(1e3 * depth)), "out of the plane");
    }
    if let Some(on) = &slots.continuum {
        let (cells, blocks) = (on.grid.cells, of::blocks(on));
        let (what, size) = match (&on.mesh, on.drawn()) {
            (Some(_), Some(_)) => ("cells of blocks", "about as large as an element".to_string()),
            (Some(_), None) => ("elements", format!("{} mm each", times(axes, |axis| figures(1e3 * on.edge(axis))))),
            (None, _) => ("cells", format!("{} mm each", figures(1e3 * on.grid.cell))),
        };
        page.row(what, &times(axes, |axis| whole(cells[axis] as f64)), &size);
        let size = format!("{} cells along each edge; no more ranks than blocks", on.cells_per_block);
        page.row("blocks", &times(axes, |axis| whole(blocks[axis] as f64)), &size);
    }
    if let Some(assembly) = &slots.grains {
        motion(page, assembly);
    }
    let (gravity, ramp) = slots.gravity();
    if gravity != [0.0; 3] {
        let note = if ramp > 0.0 { format!("rises over {} s", figures(ramp)) } else { String::new() };
        page.row("gravity", &format!("{} m/s2", components(&gravity[..axes])), &note);
    }
}

/// How a cell deforms.
fn motion(page: &mut Page, assembly: &Assembly) {
    let cell = &assembly.cell;
    for row in (0..cell.dimension).filter(|row| cell.gradient[*row] != [0.0; 3]) {
        let rates = components(&cell.gradient[row][..cell.dimension]);
        let label = format!("velocity gradient, row {}", AXES[row]);
        page.row(&label, &format!("{rates} 1/s"), "dh/dt = L h of the edges");
    }
    for (axis, name) in AXES.iter().enumerate() {
        if let Some((servo, stress)) = cell.servo.as_ref().and_then(|servo| Some((servo, servo.stress[axis]?))) {
            page.row(
                &format!("stress held along {name}"),
                &format!("{} kPa", figures(-1e-3 * stress)),
                &format!(
                    "compression positive; {} of what is missing made up every {} steps, at most {} 1/s",
                    figures(servo.gain),
                    servo.interval,
                    figures(servo.rate_max)
                ),
            );
        }
    }
}

/// What holds nodes at the faces of the grid, and loads on the material there.
pub fn faces(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.continuum.as_deref().filter(|_| slots.job.plates().is_none()) else { return };
    page.section("Boundary conditions at faces (roller where the job says nothing)");
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
    if job.loads.is_empty() {
        return;
    }
    page.section("Loads");
    for (load, (count, area)) in job.loads.iter().zip(of::bearing(job)) {
        let (value, kind) = match &load.kind {
            LoadKind::Traction(traction) => (components(&traction[..job.grid.dimension]), "dead traction"),
            LoadKind::Pressure(pressure) => (figures(*pressure), "pressure that follows the surface"),
        };
        let what = match (&job.mesh, load.on_surface) {
            (Some(_), _) => "on sides of elements:",
            (None, true) => "on the surface of points:",
            (None, false) => "at points:",
        };
        let note = format!("{kind}, {what} {}, {} m2", whole(count as f64), figures(area));
        let place = load.group.clone().unwrap_or_else(|| load.face.name());
        page.row(&place, &format!("{value} Pa"), &note);
    }
}
