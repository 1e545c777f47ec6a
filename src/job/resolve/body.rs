//! `[[body]]`: rigid bodies among grains or in a continuum.

use super::is_plain;
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::job::assembly::{Body, Motion, PathPoint, Shape};
use crate::job::raw::Reader;

/// Bodies that a job may have.
pub(super) const BODIES_MAX: usize = 8;
/// How far a typed direction may be from length 1 to be taken as it is, so that resolving twice changes no bit.
const UNIT_TOLERANCE: f64 = 1e-12;
/// Sine of the angle within which two directions count as the same.
const PARALLEL_TOLERANCE: f64 = 1e-9;

/// Where bodies may be.
pub struct Domain {
    /// `cell` or `grid`.
    pub name: &'static str,
    pub dimension: usize,
    pub lower: [f64; 3],
    pub upper: [f64; 3],
    pub periodic: [bool; 3],
    /// Whether material may pull at a body.
    pub coheres: bool,
}

/// Brings directions to length 1, and refuses bodies that do not fit where they are; `top` has them as they were typed.
pub fn check_bodies<'a>(bodies: impl Iterator<Item = &'a mut Body>, top: &Reader<'_>, cell: &Domain) {
    let tables = top.list("body");
    if let Some(table) = tables.get(BODIES_MAX) {
        table.add(table.refusal_of_table(&format!(
            "is one too many: a job may have {BODIES_MAX} bodies, and this one has {}. Remove some.",
            tables.len()
        )));
    }
    let mut names: Vec<&str> = Vec::new();
    for (body, table) in bodies.zip(&tables) {
        table.one_of_many(check_body(body, table, cell));
        if names.contains(&body.name.as_str()) {
            table.add(table.refusal("name", "names another body already. Give each a name of its own."));
        }
        names.push(&body.name);
    }
}

fn check_body(body: &mut Body, table: &Reader<'_>, cell: &Domain) -> Result<(), Error> {
    check_name_of_columns(table, &body.name)?;
    check_shape(&mut body.shape, table, cell)?;
    check_path(&body.motion.path, table)?;
    if let Some(servo) = &mut body.motion.servo {
        unit(&mut servo.direction, "servo", table)?;
    }
    refuse_servo_from_behind(table, body, cell)?;
    refuse_spin(table, cell, &body.shape, &body.motion)?;
    refuse_path_along_servo(table, &body.motion)
}

fn check_shape(shape: &mut Shape, table: &Reader<'_>, cell: &Domain) -> Result<(), Error> {
    match shape {
        Shape::Plane { point, normal } => {
            check_inside(table, "point", point, cell)?;
            unit(normal, "normal", table)?;
            match (0..cell.dimension).find(|axis| cell.periodic[*axis] && normal[*axis] != 0.0) {
                Some(axis) => Err(table.refusal(
                    "normal",
                    &format!(
                        "leans along {}, and the {} is periodic there, so the half space would meet its own images. Turn it, or set {1}.periodic to false along {0}.",
                        AXES[axis], cell.name
                    ),
                )),
                None => Ok(()),
            }
        }
        Shape::Box { lower, upper } => check_corners_cut_by_walls(table, lower, upper, cell),
        Shape::Layer { lower, upper } => check_corners(table, lower, upper, cell),
        Shape::Cylinder { centre, radius, axis } => {
            if cell.dimension == 3 {
                unit(axis, "axis", table)?;
            }
            check_inside(table, "centre", centre, cell)?;
            for along in (0..cell.dimension).filter(|along| cell.periodic[*along]) {
                let reach = *radius * (1.0 - axis[along] * axis[along]).max(0.0).sqrt();
                if centre[along] - reach < cell.lower[along] || centre[along] + reach > cell.upper[along] {
                    return Err(table.refusal(
                        "radius",
                        &format!(
                            "reaches beyond the {} along {}, where it is periodic. Make it smaller, or move its centre inwards.",
                            cell.name, AXES[along]
                        ),
                    ));
                }
            }
            Ok(())
        }
    }
}

/// As axes are called in messages.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A point must be one of the domain, its faces included.
pub fn check_inside(table: &Reader<'_>, key: &str, point: &[f64; 3], cell: &Domain) -> Result<(), Error> {
    match (0..cell.dimension).find(|axis| !(cell.lower[*axis]..=cell.upper[*axis]).contains(&point[*axis])) {
        None => Ok(()),
        Some(axis) => Err(table.refusal(
            key,
            &format!(
                "lies outside of the {}, which reaches from {} to {} m along {}. Move it inside.",
                cell.name,
                super::digits(cell.lower[axis]),
                super::digits(cell.upper[axis]),
                AXES[axis]
            ),
        )),
    }
}

/// The name of what has columns of its own in the series.
pub fn check_name_of_columns(table: &Reader<'_>, name: &str) -> Result<(), Error> {
    match is_plain(name) {
        true => Ok(()),
        false => Err(table.refusal(
            "name",
            "is refused: it names columns of series.csv, so write letters, digits, \"_\", \"-\" and \".\" only, a letter or digit first.",
        )),
    }
}

/// Two corners must be those of a box in the domain.
pub fn check_corners(table: &Reader<'_>, lower: &[f64; 3], upper: &[f64; 3], cell: &Domain) -> Result<(), Error> {
    check_inside(table, "lower", lower, cell)?;
    check_inside(table, "upper", upper, cell)?;
    match (0..cell.dimension).all(|axis| lower[axis] < upper[axis]) {
        true => Ok(()),
        false => Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis.")),
    }
}

/// The walls of a grid may cut a body: a side of it on a wall would let the nodes there go along the wall.
fn check_corners_cut_by_walls(
    table: &Reader<'_>,
    lower: &[f64; 3],
    upper: &[f64; 3],
    domain: &Domain,
) -> Result<(), Error> {
    let met = |axis: usize| lower[axis] < domain.upper[axis] && upper[axis] > domain.lower[axis];
    let within = |axis: usize| lower[axis] >= domain.lower[axis] && upper[axis] <= domain.upper[axis];
    let walled = |axis: usize| domain.name == "grid" && !domain.periodic[axis];
    let fits = |axis: usize| lower[axis] < upper[axis] && if walled(axis) { met(axis) } else { within(axis) };
    match (0..domain.dimension).all(fits) {
        true => Ok(()),
        false => check_corners(table, lower, upper, domain),
    }
}

/// Brings a direction to length 1.
pub fn unit(direction: &mut [f64; 3], key: &str, table: &Reader<'_>) -> Result<(), Error> {
    let length = norm(*direction);
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        return Ok(());
    }
    if length > 0.0 && length.is_finite() {
        *direction = direction.map(|component| component / length);
        return Ok(());
    }
    Err(table.refusal(key, "points nowhere. Write a direction of any length but zero."))
}

pub fn norm(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A path begins at the start and goes forward.
fn check_path(path: &[PathPoint], table: &Reader<'_>) -> Result<(), Error> {
    for (number, point) in table.list("path").iter().enumerate() {
        let time = path[number].time;
        if number == 0 && time != 0.0 {
            return Err(point.refusal("time", "leaves open how the body starts: the first time of a path must be 0."));
        }
        if number > 0 && time <= path[number - 1].time {
            return Err(point.refusal("time", "does not come after the time before it. Put the path in order."));
        }
    }
    Ok(())
}

/// A spin must leave the shape where it is, or nothing says about which point it turns.
fn refuse_spin(table: &Reader<'_>, cell: &Domain, shape: &Shape, motion: &Motion) -> Result<(), Error> {
    let key = if table.has("path") { "path" } else { "spin" };
    let about = match shape {
        Shape::Cylinder { axis, .. } => Some(*axis),
        Shape::Plane { normal, .. } if cell.dimension == 3 => Some(*normal),
        _ => None,
    };
    for spin in motion.path.iter().map(|point| point.spin).filter(|spin| *spin != [0.0; 3]) {
        let Some(about) = about else {
            return Err(table.refusal(
                key,
                "turns a body that cannot turn: only a cylinder spins, and in space a plane about its normal. Remove the spin.",
            ));
        };
        let across = norm(cross(spin, about));
        if across > PARALLEL_TOLERANCE * norm(spin) {
            return Err(table.refusal(
                key,
                "would turn the shape out of its place: a cylinder spins about its axis, a plane about its normal. Turn the spin.",
            ));
        }
    }
    Ok(())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Grains push a plane against its normal and no other way: a servo that waits for a push along it carries the plane away.
fn refuse_servo_from_behind(table: &Reader<'_>, body: &Body, cell: &Domain) -> Result<(), Error> {
    match (&body.shape, &body.motion.servo) {
        (Shape::Plane { normal, .. }, Some(servo))
            if servo.force > 0.0 && !cell.coheres && dot(*normal, servo.direction) > 0.0 =>
        {
            Err(table.refusal(
                "servo",
                "has a direction along the normal of its plane, so that the plane would leave the grains for ever: direction is the one in which grains push the body, against that normal. Turn it around.",
            ))
        }
        _ => Ok(()),
    }
}

/// Along its direction the servo alone moves the body.
fn refuse_path_along_servo(table: &Reader<'_>, motion: &Motion) -> Result<(), Error> {
    let Some(servo) = &motion.servo else {
        return Ok(());
    };
    let along =
        |point: &PathPoint| dot(point.velocity, servo.direction).abs() > PARALLEL_TOLERANCE * norm(point.velocity);
    match motion.path.iter().any(along) {
        true => Err(table.refusal(
            if table.has("path") { "path" } else { "velocity" },
            "moves the body along the direction of its servo, which moves it there by itself. Remove that component.",
        )),
        false => Ok(()),
    }
}
