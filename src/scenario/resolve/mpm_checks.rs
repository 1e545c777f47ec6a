//! What no single key of a continuum can tell.

use super::{digits, digits_below, refuse_unstable};
use crate::error::Error;
use crate::math::{PI, atan, tan};
use crate::scenario::assembly::Shape;
use crate::scenario::mpm::{CriticalDruckerPrager, MaterialLaw, Mpm, RigidBody, figures};
use crate::scenario::raw::{Reader, Typed};

/// Points that a job may have.
const POINTS_MAX: u64 = 100_000_000;

pub fn check(job: &Mpm, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    if let MaterialLaw::CriticalDruckerPrager(law) = &job.material.law {
        check_critical(job, law, typed, top)?;
    }
    check_time(job, typed)?;
    check_points(job, typed, top)?;
    check_loads(job, top)?;
    check_bodies(job, top)?;
    check_followed(job, top)
}

/// Friction and dilation at a packing fraction: their tangents.
fn angles(law: &CriticalDruckerPrager, fraction: f64) -> (f64, f64) {
    let surplus = law.dilation_factor * (fraction - law.fraction_critical);
    (tan(law.friction_angle_critical) + surplus, law.dilation_angle.map_or(surplus, tan))
}

/// The cone must exist at the start, and flow on it must not give back more work than friction takes.
fn check_critical(job: &Mpm, law: &CriticalDruckerPrager, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    let degrees = |tangent: f64| digits_below(atan(tangent) * 180.0 / PI);
    if law.friction_angle_critical == 0.0 && law.cohesion == 0.0 {
        return Err(typed.refusal(
            "material",
            "friction_angle_critical",
            "bears no shear at all, since cohesion is 0 too. Give the material friction or cohesion.",
        ));
    }
    let tables = top.tables("region")?;
    for (region, table) in job.regions.iter().zip(&tables) {
        let refused = |problem: &str| match table.has("fraction") {
            true => table.refusal("fraction", problem),
            false => typed.refusal("material", "fraction", problem),
        };
        let (friction, dilation) = angles(law, region.fraction);
        if friction < 0.0 {
            return Err(refused(&format!(
                "makes the friction angle negative: tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs) is {}. Write a fraction of at least {}.",
                digits_below(friction),
                digits((1e4 * (region.fraction - friction / law.dilation_factor)).ceil() / 1e4)
            )));
        }
        if dilation <= friction {
            continue;
        }
        return Err(match law.dilation_angle {
            Some(_) => typed.refusal(
                "material",
                "dilation_angle",
                &format!(
                    "is more than the friction angle, {} deg, so that flow would give more work than it takes. Write at most that.",
                    degrees(friction)
                ),
            ),
            None => refused("makes the dilation angle more than the friction angle. Take a lower fraction."),
        });
    }
    Ok(())
}

fn check_time(job: &Mpm, typed: &Typed) -> Result<(), Error> {
    refuse_unstable(typed, job.step, &figures::bounds(job), "")?;
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
        let message = format!(
            "makes {count} points with scheme.points_per_cell = {}, and at most {POINTS_MAX} are allowed. Take larger cells, or fewer points in each.",
            job.scheme.points_per_cell
        );
        Err(typed.refusal("grid", "cell", &message))
    };
    // The outline of a ball in space holds twice the ball.
    let most = figures::points_max(job);
    if most > 8.0 * POINTS_MAX as f64 {
        return too_many(format!("up to {most:.1e}"));
    }
    let counts = figures::points_of_regions(job);
    for (count, table) in counts.iter().zip(&top.tables("region")?) {
        if *count == 0 {
            return Err(table.refusal(
                "shape",
                &format!(
                    "has no point: points stand {} m apart, in the middle of their share of a cell, and none is in this region that is not in one before it. Make it larger, or the cells smaller.",
                    digits(job.spacing())
                ),
            ));
        }
    }
    match counts.iter().sum::<u64>() {
        total if total > POINTS_MAX => too_many(format!("{total}")),
        _ => Ok(()),
    }
}

fn check_loads(job: &Mpm, top: &Reader<'_>) -> Result<(), Error> {
    for (load, table) in job.loads.iter().zip(&top.tables("load")?) {
        if figures::points_loaded(job, load) == 0 {
            return Err(table.refusal(
                "face",
                "meets no surface: no point within the window of the load is bare on that side. Move lower and upper, or take another face.",
            ));
        }
    }
    Ok(())
}

/// Bodies touch the material at the start, at most.
fn check_bodies(job: &Mpm, top: &Reader<'_>) -> Result<(), Error> {
    for (body, table) in job.bodies.iter().zip(&top.tables("body")?) {
        let inside = |place: &[f64; 3]| job.region_at(place).is_some() && body_contains(body, place);
        let count: usize = job
            .regions
            .iter()
            .map(|region| figures::indices(figures::places_of(job, region)))
            .map(|indices| indices.filter(|index| inside(&job.place(*index))).count())
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
    for (followed, table) in job.follow.iter().zip(&top.tables("follow")?) {
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
