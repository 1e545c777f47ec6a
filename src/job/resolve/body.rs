//! `[[body]]`: rigid bodies among grains or in a continuum.

use super::is_plain;
use crate::base::error::Error;
use crate::job::assembly::{Body, BodyServo, Motion, PathPoint, Shape};
use crate::job::raw::Reader;

/// Bodies that a job may have.
const BODIES_MAX: usize = 8;
/// How far a typed direction may be from length 1 to be taken as it is, so that resolving twice changes no bit.
const UNIT_TOLERANCE: f64 = 1e-12;
/// Sine of the angle within which two directions count as the same.
const PARALLEL_TOLERANCE: f64 = 1e-9;

type Owners = &'static [(&'static str, &'static [&'static str])];

const PLANE: (&str, &[&str]) = ("plane", &["point", "normal"]);
const BOX: (&str, &[&str]) = ("box", &["lower", "upper"]);
const CYLINDER: (&str, &[&str]) = ("cylinder", &["centre", "radius", "axis"]);
const LAYER: (&str, &[&str]) = ("layer", &["lower", "upper"]);
/// The keys of each shape; a layer is made of grains.
const OF_SHAPE_AMONG_GRAINS: Owners = &[PLANE, BOX, CYLINDER, LAYER];
const OF_SHAPE: Owners = &[PLANE, BOX, CYLINDER];

/// Where bodies may be.
pub struct Domain {
    /// `cell` or `grid`.
    pub name: &'static str,
    pub dimension: usize,
    pub lower: [f64; 3],
    pub upper: [f64; 3],
    pub periodic: [bool; 3],
}

impl Domain {
    fn shapes(&self) -> Owners {
        if self.name == "cell" { OF_SHAPE_AMONG_GRAINS } else { OF_SHAPE }
    }
}

/// The bodies of a job with the tables that they were typed in.
pub fn bodies<'a>(top: &Reader<'a>, cell: &Domain) -> Vec<(Body, Reader<'a>)> {
    let tables = top.tables("body");
    if let Some(table) = tables.get(BODIES_MAX) {
        table.note(table.refusal_of_table(&format!(
            "is one too many: a job may have {BODIES_MAX} bodies, and this one has {}. Remove some.",
            tables.len()
        )));
    }
    let mut bodies: Vec<(Body, Reader<'a>)> = Vec::new();
    for table in tables {
        let Some(body) = table.one_of_many(body(&table, cell)) else { continue };
        if bodies.iter().any(|(other, _)| other.name == body.name) {
            table.note(table.refusal("name", "names another body already. Give each a name of its own."));
        }
        bodies.push((body, table));
    }
    bodies
}

fn body(table: &Reader<'_>, cell: &Domain) -> Result<Body, Error> {
    let name = name_of_columns(table)?;
    let shape = shape(table, cell)?;
    let motion = Motion { path: path(table)?, servo: servo(table)? };
    refuse_spin(table, cell, &shape, &motion)?;
    refuse_path_along_servo(table, &motion)?;
    Ok(Body { name, shape, motion })
}

fn shape(table: &Reader<'_>, cell: &Domain) -> Result<Shape, Error> {
    let names: Vec<(&str, &str)> = cell.shapes().iter().map(|(name, _)| (*name, *name)).collect();
    let name = table.choose("shape", "shape", &names);
    table.note_keys_of_others("shape", name, cell.shapes());
    Ok(match name {
        "plane" => {
            let point = inside(table, "point", cell)?;
            let normal = direction(table, "normal")?;
            if let Some(axis) = (0..cell.dimension).find(|axis| cell.periodic[*axis] && normal[*axis] != 0.0) {
                return Err(table.refusal(
                    "normal",
                    &format!(
                        "leans along {}, and the {} is periodic there, so the half space would meet its own images. Turn it, or set {1}.periodic to false along {0}.",
                        AXES[axis], cell.name
                    ),
                ));
            }
            Shape::Plane { point, normal }
        }
        "box" => {
            let (lower, upper) = corners_cut_by_walls(table, cell)?;
            Shape::Box { lower, upper }
        }
        "layer" => {
            let (lower, upper) = corners(table, cell)?;
            Shape::Layer { lower, upper }
        }
        _ => cylinder(table, cell)?,
    })
}

fn cylinder(table: &Reader<'_>, cell: &Domain) -> Result<Shape, Error> {
    let axis = match cell.dimension {
        2 if table.has("axis") => {
            return Err(table
                .refusal("axis", "belongs to space = \"solid\"; in the plane a cylinder is a disc. Remove the line."));
        }
        2 => [0.0, 0.0, 1.0],
        _ => direction(table, "axis")?,
    };
    let (centre, radius) = (inside(table, "centre", cell)?, table.number("radius"));
    for along in (0..cell.dimension).filter(|along| cell.periodic[*along]) {
        let reach = radius * (1.0 - axis[along] * axis[along]).max(0.0).sqrt();
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
    Ok(Shape::Cylinder { centre, radius, axis })
}

/// As axes are called in messages.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A point of the domain, its faces included.
pub fn inside(table: &Reader<'_>, key: &str, cell: &Domain) -> Result<[f64; 3], Error> {
    let point = table.vector(key);
    match (0..cell.dimension).find(|axis| !(cell.lower[*axis]..=cell.upper[*axis]).contains(&point[*axis])) {
        None => Ok(point),
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
pub fn name_of_columns(table: &Reader<'_>) -> Result<String, Error> {
    let name = table.text("name");
    match is_plain(&name) {
        true => Ok(name),
        false => Err(table.refusal(
            "name",
            "is refused: it names columns of series.csv, so write letters, digits, \"_\", \"-\" and \".\" only, a letter or digit first.",
        )),
    }
}

/// Two corners of a box in the domain.
pub fn corners(table: &Reader<'_>, cell: &Domain) -> Result<([f64; 3], [f64; 3]), Error> {
    let (lower, upper) = (inside(table, "lower", cell)?, inside(table, "upper", cell)?);
    match (0..cell.dimension).all(|axis| lower[axis] < upper[axis]) {
        true => Ok((lower, upper)),
        false => Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis.")),
    }
}

/// Two corners of a box that the walls of a grid may cut: a side of it on a wall would let the nodes there go along the wall.
fn corners_cut_by_walls(table: &Reader<'_>, domain: &Domain) -> Result<([f64; 3], [f64; 3]), Error> {
    let (lower, upper) = (table.vector("lower"), table.vector("upper"));
    let met = |axis: usize| lower[axis] < domain.upper[axis] && upper[axis] > domain.lower[axis];
    let within = |axis: usize| lower[axis] >= domain.lower[axis] && upper[axis] <= domain.upper[axis];
    let walled = |axis: usize| domain.name == "grid" && !domain.periodic[axis];
    let fits = |axis: usize| lower[axis] < upper[axis] && if walled(axis) { met(axis) } else { within(axis) };
    match (0..domain.dimension).all(fits) {
        true => Ok((lower, upper)),
        false => corners(table, domain),
    }
}

/// A direction, brought to length 1.
pub fn direction(table: &Reader<'_>, key: &str) -> Result<[f64; 3], Error> {
    let typed = table.vector(key);
    let length = norm(typed);
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        return Ok(typed);
    }
    match length > 0.0 && length.is_finite() {
        true => Ok(typed.map(|component| component / length)),
        false => Err(table.refusal(key, "points nowhere. Write a direction of any length but zero.")),
    }
}

pub fn norm(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Either a path, or one velocity and spin with their ramp.
fn path(table: &Reader<'_>) -> Result<Vec<PathPoint>, Error> {
    let points = table.tables("path");
    if points.is_empty() {
        return path_of_one_velocity(table);
    }
    if let Some(key) = ["velocity", "spin", "ramp"].into_iter().find(|key| table.has(key)) {
        return Err(table.refusal(key, "stands beside body.path, and each says how the body moves. Keep one of them."));
    }
    let mut path: Vec<PathPoint> = Vec::new();
    for point in points {
        let time = point.number("time");
        match path.last() {
            None if time != 0.0 => {
                return Err(
                    point.refusal("time", "leaves open how the body starts: the first time of a path must be 0.")
                );
            }
            Some(last) if time <= last.time => {
                return Err(point.refusal("time", "does not come after the time before it. Put the path in order."));
            }
            _ => path.push(PathPoint {
                time,
                velocity: point.vector_if_given("velocity").unwrap_or_default(),
                spin: point.spin_if_given("spin").unwrap_or_default(),
            }),
        }
    }
    Ok(path)
}

fn path_of_one_velocity(table: &Reader<'_>) -> Result<Vec<PathPoint>, Error> {
    let (velocity, spin) = (table.vector_if_given("velocity"), table.spin_if_given("spin"));
    let ramp = table.number_or("ramp", 0.0);
    if velocity.is_none() && spin.is_none() {
        return match table.has("ramp") {
            true => Err(table.refusal("ramp", "has nothing to raise: add velocity or spin, or remove the line.")),
            false => Ok(Vec::new()),
        };
    }
    let (velocity, spin) = (velocity.unwrap_or_default(), spin.unwrap_or_default());
    let full = PathPoint { time: ramp, velocity, spin };
    match ramp > 0.0 {
        true => Ok(vec![PathPoint { time: 0.0, velocity: [0.0; 3], spin: [0.0; 3] }, full]),
        false => Ok(vec![full]),
    }
}

fn servo(table: &Reader<'_>) -> Result<Option<BodyServo>, Error> {
    let Some(servo) = table.inner("servo") else {
        return Ok(None);
    };
    let force = match (servo.number_if_given("force"), servo.has("stress") || servo.has("area")) {
        (Some(_), true) => {
            return Err(servo.refusal(
                "force",
                "stands beside a stress or an area, and each says what the body is held at. Keep force, or stress and area.",
            ));
        }
        (Some(force), false) => force,
        (None, true) => servo.number("stress") * servo.number("area"),
        (None, false) => servo.number("force"),
    };
    Ok(Some(BodyServo {
        direction: direction(&servo, "direction")?,
        force,
        mass: servo.number("mass"),
        damping: servo.number_or("damping", 0.0),
        speed_max: servo.number("speed_max"),
    }))
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
