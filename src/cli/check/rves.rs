//! Grain assemblies at every point: how large they are, how they are driven, what they take.

use super::Slots;
use super::page::{Page, figures, whole};
use crate::job::mpm::figures::{edge_of_rve, points, pressures_at_start, rve_bytes};
use crate::job::stable::governing;
use crate::job::{figures as of_grains, mpm::Mpm};
use crate::rve::Pace;

pub fn section(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.continuum.as_deref() else { return };
    let Some((granular, rves)) = job.rves() else { return };
    page.section("RVEs");
    let (count, grains) = (points(job) as f64, of_grains::grains(&granular.piece).unwrap_or_default() as f64);
    page.row(
        "grain assemblies",
        &whole(count),
        &format!("of {} grains, {} in all", whole(grains), whole(count * grains)),
    );
    let edge = edge_of_rve(job).unwrap_or_default();
    page.row("edge of an RVE", &format!("{} mm", figures(1e3 * edge)), "about; its packing will tell");
    let note = "above 1 an RVE holds more grains than the material that it stands for";
    page.row("edge over that of a cell", &figures(edge / job.grid.cell), note);
    page.keys(job.grid.dimension, |form| rves.clone().keys(form));
    let bounds = of_grains::bounds(&granular.piece);
    page.row("step of their grains", &format!("{} s", figures(granular.step_of_rves())), governing(&bounds).cause);
    if let Some([least, most]) = rates_of_least_steps(job) {
        let note = "strain faster than this, at the least and the largest pressure of the start, takes more steps an increment, and the run longer";
        page.row("rate of steps_min", &format!("{} to {} 1/s", figures(least), figures(most)), note);
    }
    let [memory, checkpoint] = rve_bytes(job).map(|bytes| format!("{} MB", figures(1e-6 * bytes)));
    page.row("memory", &memory, "of all ranks together, about");
    page.row("checkpoint", &checkpoint, "about");
}

/// How strain is averaged, if it is.
pub fn nonlocal_section(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.continuum.as_deref() else { return };
    let Some(mut nonlocal) = job.nonlocal else { return };
    page.section("Nonlocal strain");
    page.keys(job.grid.dimension, |form| nonlocal.keys(form));
    let share = nonlocal.radius / distance_of_points(job);
    page.row("radius over the distance of points", &figures(share), "up to 1 a point has its own strain alone");
}

/// The shortest distance of two points at the start, m: along an axis with a single element there is none.
fn distance_of_points(job: &Mpm) -> f64 {
    let others = (0..job.grid.dimension).filter(|axis| job.places()[*axis] > 1);
    others.map(|axis| job.spacing_along(axis)).reduce(f64::min).unwrap_or_else(|| job.spacing())
}

/// A mean over a point alone.
pub fn alone_in_its_mean(job: &Mpm) -> Option<String> {
    let (nonlocal, distance) = (job.nonlocal?, distance_of_points(job));
    (nonlocal.radius <= distance).then(|| {
        format!(
            "nonlocal.radius is {} mm, and points are {} mm apart: each has its own strain alone, as without [nonlocal]. Write a larger radius, or take smaller cells or elements.",
            figures(1e3 * nonlocal.radius),
            figures(1e3 * distance)
        )
    })
}

/// Rates of strain, 1/s, up to which increments of a quasi-static drive have their least number of steps, under the least and the largest
/// pressure of the start.
fn rates_of_least_steps(job: &Mpm) -> Option<[f64; 2]> {
    let (granular, rves) = job.rves()?;
    let Pace::QuasiStatic { inertial_number } = rves.drive.pace else { return None };
    let pressures = pressures_at_start(job);
    let matter = &granular.piece.matter;
    let rate = |pressure: &f64| {
        let time = matter.diameter_mean * (matter.density / pressure).sqrt();
        rves.drive.steps_min as f64 * inertial_number * granular.step_of_rves() / (time * job.step)
    };
    Some([rate(pressures.first()?), rate(pressures.last()?)])
}

/// Where no scale lies between the grains and the cells.
pub fn too_large(job: &Mpm) -> Option<String> {
    let edge = edge_of_rve(job)?;
    (edge > job.grid.cell).then(|| {
        format!(
            "an RVE is {} mm wide and a cell {} mm: grains alone would be fewer, and a band of the continuum is thinner than the RVEs in it. Take smaller grains, fewer in an RVE (grains.count), or larger cells.",
            figures(1e3 * edge),
            figures(1e3 * job.grid.cell)
        )
    })
}

/// Stress of a mean strain that is not averaged back.
pub fn without_adjoint(job: &Mpm) -> Option<String> {
    job.nonlocal.filter(|nonlocal| !nonlocal.adjoint).map(|_| {
        "nonlocal.adjoint = false leaves deformation finer than nonlocal.radius without resistance, and points drift apart. Write true."
            .to_string()
    })
}
