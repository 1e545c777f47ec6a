//! What no single key of a continuum can tell.

use super::body::norm;
use super::limits::refuse_memory_of_grid;
use super::refuse_unstable;
use crate::base::digits::{digits, significant};
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::job::Method;
use crate::job::assembly::Shape;
use crate::job::mpm::{InitialStress, LoadKind, Mpm, RigidBody, figures};
use crate::job::raw::{Reader, Typed};
use crate::job::stable::governing;
use crate::law::material::Objection;

/// Points that a job may have.
const POINTS_MAX: u64 = 100_000_000;
/// Looks whether a point is in a region: seconds of them.
const LOOKS_MAX: f64 = 1e10;

pub fn check(job: &Mpm, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    let checked = check_law(job, typed, top);
    let works = checked.is_ok();
    typed.check(checked);
    typed.check(check_time(job, typed));
    // What comes after it goes through all points.
    check_points(job, typed, top)?;
    if let InitialStress::Geostatic { axis, k0, .. } = job.stress
        && works
    {
        typed.check(check_geostatic(job, (axis, k0), typed));
    }
    typed.check(check_stresses(job, typed, top));
    typed.check(check_loads(job, top));
    typed.check(check_bodies(job, top));
    typed.check(check_followed(job, top));
    Ok(())
}

/// The law must be able to start from the solid volume fraction of every region.
fn check_law(job: &Mpm, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    for (region, table) in job.regions.iter().zip(&top.list("region")) {
        if let Some(Objection { key, problem }) =
            job.material.law.objection(job.grid.dimension, job.fraction_in(region))
        {
            return Err(match key == "fraction" && table.has(key) {
                true => table.refusal(key, &problem),
                false => typed.refusal("material", key, &problem),
            });
        }
    }
    Ok(())
}

/// The share of a k0 that rounding may take a stress on the cone beyond it.
const K0_SLACK: f64 = 1e-9;

/// Stress that the law does not bear at the start would be changed in silence.
fn check_geostatic(job: &Mpm, (axis, k0): (usize, f64), typed: &Typed) -> Result<(), Error> {
    let (law, axes) = (&job.material.law, job.grid.dimension);
    let (mut least, mut most) = ((0.0, 0.0), (f64::INFINITY, 0.0));
    for (number, region) in job.regions.iter().enumerate() {
        // Cohesion bears the more the less there is above: the deepest point tells of all.
        let span = figures::span(job, number, axis).expect("every region has points");
        let overburden = span.map(|at| job.overburden(at)).into_iter().fold(0.0, f64::max);
        if overburden > 0.0
            && let Some([lower, upper]) = law.k0(axes, job.fraction_in(region), overburden)
        {
            least = if lower > least.0 { (lower, overburden) } else { least };
            most = if upper < most.0 { (upper, overburden) } else { most };
        }
    }
    let (overburden, advice) = if k0 < least.0 * (1.0 - K0_SLACK) {
        (least.1, format!("at least {}", digits((1e4 * least.0).ceil() / 1e4)))
    } else if k0 > most.0 * (1.0 + K0_SLACK) {
        (most.1, format!("at most {}", digits((1e4 * most.0).floor() / 1e4)))
    } else {
        return Ok(());
    };
    Err(typed.refusal(
        "stress",
        "k0",
        &format!(
            "makes a stress that friction and cohesion do not bear where {} kPa lie above, and it would not be the stress of the start. Write {advice}, or give the material more friction or cohesion.",
            significant(overburden / 1e3, 3)
        ),
    ))
}

pub(super) fn check_time(job: &Mpm, typed: &Typed) -> Result<(), Error> {
    refuse_unstable(typed, job.step, &figures::bounds(job), "")?;
    // Of RVEs it is refused as such.
    if job.grain_steps > 1 && job.rves().is_none() && job.step_of_continuum() > governing(&figures::bounds(job)).step {
        let most = (governing(&figures::bounds(job)).step / job.step).floor();
        let message = format!(
            "makes steps of the continuum that are not stable. Write at most {most}, or take larger cells or a softer material."
        );
        return Err(typed.refusal("time", "grain_steps", &message));
    }
    match job.end < job.step {
        true => {
            let message = format!("is shorter than one time step. Write at least time.step = {} s.", digits(job.step));
            Err(typed.refusal("time", "end", &message))
        }
        false => Ok(()),
    }
}

/// Every region has points, and all together no more than a machine can hold.
fn check_points(job: &Mpm, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    let too_many = |count: String| {
        let (table, key, message) = match job.mesh {
            Some(_) => (
                "mesh",
                "elements",
                format!("makes {count} of them, and at most {POINTS_MAX} are allowed. Take fewer."),
            ),
            None => (
                "grid",
                "cell",
                format!(
                    "makes {count} points with scheme.points_per_cell = {}, and at most {POINTS_MAX} are allowed. Take larger cells, or fewer points in each.",
                    job.scheme.points_per_cell
                ),
            ),
        };
        Err(typed.refusal(table, key, &message))
    };
    // The outline of a ball in space holds twice the ball.
    let most = figures::points_max(job);
    if most > 8.0 * POINTS_MAX as f64 {
        return too_many(format!("up to {most:.1e}"));
    }
    if most * job.regions.len() as f64 > LOOKS_MAX {
        let message = format!(
            "makes up to {most:.1e} points, and each is looked for in {} regions, which takes too long. Take larger cells, fewer points in each, or fewer regions.",
            job.regions.len()
        );
        let (table, key) = if job.mesh.is_some() { ("mesh", "elements") } else { ("grid", "cell") };
        return Err(typed.refusal(table, key, &message));
    }
    let counts = figures::points_of_regions(job);
    for (count, table) in counts.iter().zip(&top.list("region")) {
        if *count == 0 {
            return Err(table.refusal(
                "shape",
                &format!(
                    "has no point: points stand {} m apart, in the middle of their share of a cell, and none is in this region that is not in one before it. Make it larger, or the cells smaller.",
                    (0..job.grid.dimension).map(|axis| digits(job.spacing_along(axis))).reduce(|a, b| if a == b { a } else { format!("{a} and {b}") }).unwrap_or_default()
                ),
            ));
        }
    }
    match counts.iter().sum::<u64>() {
        total if total > POINTS_MAX => too_many(format!("{total}")),
        total => refuse_memory_of_grid(typed, figures::memory(job, total)),
    }
}

/// Stresses of more than the modulus M crush the material within a step, and gravity may not throw it across half a cell.
fn check_stresses(job: &Mpm, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    let modulus = job.material.law.modulus_longitudinal(job.grid.dimension);
    let words = || {
        format!(
            "is more than the material's modulus, M = {} Pa, and would crush it in a step. Lower it.",
            significant(modulus, 3)
        )
    };
    if let InitialStress::Isotropic { pressure } = job.stress
        && pressure > modulus
    {
        return Err(typed.refusal("stress", "pressure", &words()));
    }
    for (load, table) in job.loads.iter().zip(&top.list("load")) {
        let (key, size) = match load.kind {
            LoadKind::Traction(traction) => ("traction", norm(traction)),
            LoadKind::Pressure(pressure) => ("pressure", pressure),
        };
        if size > modulus {
            return Err(table.refusal(key, &words()));
        }
    }
    for (membrane, table) in job.membranes.iter().zip(&top.list("membrane")) {
        if membrane.pressure.abs() > modulus {
            return Err(table.refusal("pressure", &words()));
        }
    }
    let fall = norm(job.gravity.acceleration) / job.mass_scaling() * job.step_of_continuum() * job.step_of_continuum();
    if fall > 0.5 * job.grid.cell {
        let message = format!(
            "moves material by {} m in its first step, further than half a cell. Lower it, or take a shorter time.step.",
            significant(fall, 3)
        );
        return Err(typed.refusal("gravity", "acceleration", &message));
    }
    Ok(())
}

fn check_loads(job: &Mpm, top: &Reader<'_>) -> Result<(), Error> {
    if job.loads.is_empty() {
        return Ok(());
    }
    for ((load, table), (bearing, _)) in job.loads.iter().zip(&top.list("load")).zip(figures::bearing(job)) {
        if bearing == 0 {
            let what = if job.mesh.is_some() { "side of an element" } else { "point" };
            let (key, problem) = match load.group {
                Some(_) => ("group", "is of sides between elements, and a load acts on those that are bare, whose element has its middle in the window of the load. Take another group.".to_string()),
                None => ("face", format!("meets no surface: no {what} within the window of the load is bare on that side. Move lower and upper, or take another face.")),
            };
            return Err(table.refusal(key, &problem));
        }
    }
    Ok(())
}

/// Bodies touch the material at the start, at most.
fn check_bodies(job: &Mpm, top: &Reader<'_>) -> Result<(), Error> {
    for (body, table) in job.bodies.iter().zip(&top.list("body")) {
        let inside = |index: &[usize; 3]| job.region_of(*index).is_some() && body_contains(body, &job.place(*index));
        let count: usize = job
            .regions
            .iter()
            .map(|region| figures::indices(figures::places_of(job, region)))
            .map(|indices| indices.filter(inside).count())
            .sum();
        if count > 0 {
            return Err(table.refusal(
                "shape",
                &format!(
                    "stands in the material: {count} of its points are inside of the body at the start. Move the body or the region."
                ),
            ));
        }
    }
    Ok(())
}

/// Bodies meet points at their own face where that is known how; by itself those that are round or askew to the grid hold nodes.
pub(super) fn check_faces(job: &mut Mpm, top: &Reader<'_>) -> Result<(), Error> {
    let (periodic, in_space) = (job.grid.periodic, job.grid.dimension == 3);
    for (body, table) in job.bodies.iter_mut().zip(&top.list("body")) {
        if !body.at_face || body.is_in_line(periodic) {
            continue;
        }
        if !table.has("contact_at") {
            body.at_face = false;
            continue;
        }
        let why = if in_space {
            "is not possible in space for cylinders and for planes that are not across an axis of the grid. Write contact_at = \"nodes\"."
        } else if body.body.motion.servo.is_some() {
            "is not possible for cylinders and for planes that are not across an axis of the grid with a servo. Write contact_at = \"nodes\", or a path or velocity in place of the servo."
        } else {
            continue;
        };
        return Err(table.refusal("contact_at", why));
    }
    Ok(())
}

/// Pressures act on the surface; in a hybrid, whose points stop where grains are, they act at points. So do tractions: they belong to the area
/// that each point had at the start, which is no measure of the surface where a band comes out of it.
pub(super) fn check_places_of_loads(job: &mut Mpm, top: &Reader<'_>) -> Result<(), Error> {
    if job.mesh.is_some() {
        return Ok(());
    }
    let is_hybrid = job.grains.as_ref().is_some_and(|grains| grains.method == Method::Hybrid);
    for (load, table) in job.loads.iter_mut().zip(&top.list("load")).filter(|(load, _)| load.on_surface) {
        let why = match (load.kind, is_hybrid) {
            (LoadKind::Traction(_), _) => {
                "is for a pressure: a traction is dead and belongs to its points. Write kind = \"pressure\", or acts_at = \"points\"."
            }
            (LoadKind::Pressure(_), true) => {
                "is not possible in a hybrid, whose points stop where grains are. Write acts_at = \"points\"."
            }
            (LoadKind::Pressure(_), false) => continue,
        };
        if table.has("acts_at") {
            return Err(table.refusal("acts_at", why));
        }
        load.on_surface = false;
    }
    Ok(())
}

fn body_contains(body: &RigidBody, place: &[f64; 3]) -> bool {
    let arm = |from: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|axis| place[axis] - from[axis]) };
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    match &body.body.shape {
        Shape::Plane { point, normal } => dot(&arm(point), normal) < 0.0,
        Shape::Box { lower, upper } => {
            (0..3).all(|axis| lower[axis] == upper[axis] || (lower[axis] < place[axis] && place[axis] < upper[axis]))
        }
        Shape::Cylinder { centre, radius, axis } => {
            let arm = arm(centre);
            let along = dot(&arm, axis);
            dot(&arm, &arm) - along * along < radius * radius
        }
        Shape::Layer { .. } => unreachable!("a continuum has no layers"),
    }
}

fn check_followed(job: &Mpm, top: &Reader<'_>) -> Result<(), Error> {
    for (followed, table) in job.follow.iter().zip(&top.list("follow")) {
        if figures::nearest_point(job, &followed.place).is_none() {
            return Err(
                table.refusal("place", "has no point within two cells of it at the start. Move it into a region.")
            );
        }
    }
    Ok(())
}

/// Whether the border of a polygon neither crosses nor touches itself.
pub fn simple(vertices: &[[f64; 2]]) -> bool {
    let count = vertices.len();
    let edge = |at: usize| (vertices[at], vertices[(at + 1) % count]);
    (0..count).all(|first| {
        let (from, to) = edge(first);
        from != to
            && (first + 1..count).all(|second| {
                let adjacent = second == first + 1 || (first == 0 && second == count - 1);
                adjacent || !meet(edge(first), edge(second))
            })
    })
}

/// Whether two segments have a point in common.
fn meet((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let apart = |values: [f64; 2], others: [f64; 2]| {
        values[0].max(values[1]) < others[0].min(others[1]) || others[0].max(others[1]) < values[0].min(values[1])
    };
    let (of_c, of_d) = (side(a, b, c), side(a, b, d));
    let (of_a, of_b) = (side(c, d, a), side(c, d, b));
    let boxes_apart = (0..2).any(|axis| apart([a[axis], b[axis]], [c[axis], d[axis]]));
    !boxes_apart && of_c * of_d <= 0.0 && of_a * of_b <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_that_cross_themselves() {
        assert!(simple(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
        assert!(!simple(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]));
        assert!(!simple(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
        // An edge through a corner.
        assert!(!simple(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.0], [0.0, 1.0]]));
    }
}
