//! The specimen of a job at time zero: plates, and grains or points between them.

use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::{Linear, Plane, Space};
use crate::base::symmetric::Symmetric;
use crate::bodies::body::{Body, Instant, Shape, Side};
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::job::{Method, Scenario, derived};
use crate::mpm::points::Point;
use crate::mpm::stress::material_of;
use crate::prepare::grain_world::servo_of;
use crate::prepare::heterogeneity::Packed;
use crate::prepare::sheared::{self, Packing, PlanarWorld, cell_of, layout_for, settings_of_run};

type Vector = <Plane as Space>::Vector;

/// Lower plate fixed, upper plate sheared under constant normal stress.
pub fn bodies(scenario: &Scenario, height: f64) -> Vec<Body<Plane>> {
    let loading = &scenario.loading;
    let mut lower = Body::new("lower", Shape::Plate { side: Side::Below, face: 0.0 });
    let mut upper = Body::new("upper", Shape::Plate { side: Side::Above, face: height });
    (lower.meets_points, upper.meets_points) = (scenario.continuum.at_face, scenario.continuum.at_face);
    let instant = |time: f64, speed: f64| Instant { time, velocity: Vector::new(speed, 0.0), spin: Linear::zero() };
    upper.path = match loading.speed_ramp > 0.0 {
        true => vec![instant(0.0, 0.0), instant(loading.speed_ramp, loading.speed)],
        false => vec![instant(0.0, loading.speed)],
    };
    upper.servo = Some(servo_of(&derived::servo_of_plate(scenario)));
    vec![lower, upper]
}

/// What the material of a job starts from.
pub struct Start {
    /// Without grains where points alone begin with a stated solid volume fraction.
    pub packing: Packing,
    /// Of the specimen, m: the packing's, where that is not a lower one.
    pub height: f64,
    /// Of the specimen without plates, kg.
    pub mass: f64,
    /// Solid volume fraction that the continuum's law starts with.
    pub fraction: f64,
}

/// The packing, or for a continuum alone with a stated solid volume fraction the specimen as it is drawn.
pub fn prepare(scenario: &Scenario, transport: &dyn Transport) -> Result<Start, Error> {
    let stated = scenario.material.law.fraction();
    let specimen = &scenario.specimen;
    let mass_at =
        |fraction: f64| scenario.grains.density * fraction * specimen.width * specimen.height * specimen.depth;
    let packing = match (scenario.method, stated) {
        (Method::Mpm, Some(fraction)) => {
            Packing { grains: Vec::new(), height: specimen.height, mass: mass_at(fraction), fraction }
        }
        _ => match scenario.packing.height {
            Some(height) => sheared::prepare(&as_high_as(scenario, height), transport)?,
            None => sheared::prepare(scenario, transport)?,
        },
    };
    let fraction = stated.unwrap_or(packing.fraction);
    let (height, mass) = match scenario.packing.height {
        Some(_) => (specimen.height, mass_at(packing.fraction)),
        None => (packing.height, packing.mass),
    };
    Ok(Start { packing, height, mass, fraction })
}

/// The job of a lower specimen, with a plate for one of that height.
fn as_high_as(scenario: &Scenario, height: f64) -> Scenario {
    let mut lower = scenario.clone();
    lower.specimen.height = height;
    [lower.loading.plate_mass, lower.loading.plate_damping] = derived::plate_default(&lower);
    lower
}

/// The world at time zero.
pub fn world<'t>(scenario: &Scenario, transport: &'t dyn Transport, start: Start) -> Result<PlanarWorld<'t>, Error> {
    let height = start.height;
    let begins_as_grains = scenario.begins_as_grains();
    let points = if begins_as_grains { Vec::new() } else { points(scenario, transport, &start)? };
    let grains = if begins_as_grains { start.packing.grains } else { Vec::new() };
    let settings = settings_of_run(scenario);
    let layout = layout_for(scenario, height)?;
    let (cell, bodies) = (cell_of(&layout), bodies(scenario, height));
    let parts = Parts::fresh(grains, points, bodies, cell);
    let mut world = PlanarWorld::new(settings, layout, transport, 0, parts)?;
    keep_step(scenario, &mut world);
    Ok(world)
}

/// Steps of grains belong together where they are in one of the continuum. Without points grains take them one by one, so that a zone that begins everywhere is grains
/// alone to the bit until some of them rest.
pub fn keep_step(scenario: &Scenario, world: &mut PlanarWorld) {
    world.settings.grain_steps = if world.points_total == 0 { 1 } else { derived::grain_steps(scenario) };
}

/// Material points on a regular grid between the faces, under the isotropic stress that the packing was made with. Each
/// rank makes some of the rows.
fn points(scenario: &Scenario, transport: &dyn Transport, start: &Start) -> Result<Vec<Point<Plane>>, Error> {
    let (width, height) = (scenario.specimen.width, start.height);
    let spacing = scenario.continuum.cell / scenario.scheme.points_per_cell as f64;
    let columns = (width / spacing).round() as usize;
    let rows = (height / spacing).round() as usize;
    let step = [width / columns as f64, height / rows as f64];
    let volume = step[0] * step[1] * scenario.specimen.depth;
    let mean_mass = start.mass / (columns * rows) as f64;
    let law = material_of::<Plane>(&scenario.material.law);
    let fractions = fractions(scenario, transport, start, [columns, rows])?;
    let mut points = Vec::new();
    for row in (0..rows).filter(|row| row % transport.size() == transport.rank()) {
        for column in 0..columns {
            let place = [(column as f64 + 0.5) * step[0], (row as f64 + 0.5) * step[1]];
            let id = PointId((row * columns + column) as u64);
            let fraction = fractions[row * columns + column];
            let mass = mean_mass * (fraction / start.fraction);
            let mut point = Point::<Plane>::resting(id, Vector::new(place[0], place[1]), mass, volume);
            let stress = Plane::identity() * -scenario.packing.stress;
            point.hot.memory = law.start(&stress, fraction - deficit_at(scenario, place));
            point.hot.stress = Symmetric::of(&law.stress(&point.hot.memory));
            debug_assert!(point.hot.kirchhoff().is_finite());
            points.push(point);
        }
    }
    Ok(points)
}

/// Solid volume fractions of the places of points, row by row: the specimen's, or those of the packing from place to place, shifted to
/// the same mean. On every rank. Collective.
fn fractions(
    scenario: &Scenario,
    transport: &dyn Transport,
    start: &Start,
    counts: [usize; 2],
) -> Result<Vec<f64>, Error> {
    if !scenario.continuum.is_heterogeneous {
        return Ok(vec![start.fraction; counts[0] * counts[1]]);
    }
    let found = sheared::on_root(transport, || {
        let width = scenario.specimen.width;
        let packed = Packed { grains: &start.packing.grains, width, fills: 0.0..start.height };
        let mut fractions = packed.fractions(counts, start.height, scenario.continuum.cell);
        let off = start.fraction - fractions.iter().sum::<f64>() / fractions.len() as f64;
        fractions.iter_mut().for_each(|fraction| *fraction += off);
        Ok(fractions)
    });
    Ok(transfer::broadcast_numbers(transport, &transfer::agree(transport, found)?.unwrap_or_default()))
}

/// What the weak regions take from the solid volume fraction at a place.
fn deficit_at(scenario: &Scenario, place: [f64; 2]) -> f64 {
    let inside = |axis: usize, region: &crate::job::WeakRegion| {
        region.lower[axis] <= place[axis] && place[axis] <= region.upper[axis]
    };
    scenario
        .continuum
        .weak
        .iter()
        .filter(|region| inside(0, region) && inside(1, region))
        .map(|region| region.fraction_deficit)
        .sum()
}
