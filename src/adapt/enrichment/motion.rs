//! The continuum's motion, as training repeats it: since the start for grains of a packing, since they turned into points for those that come back.

use super::{PlanarPoint, Vector, cell_grid};
use crate::base::space::{Linear, Plane};
use crate::couple::motion::{MotionField, Moved};
use crate::dem::cell::{Cell, Image};
use crate::mpm::points::Points;
use crate::mpm::track::Instants;
use crate::prepare::sheared::PlanarWorld;

/// Way from where something began, across the periods that it has crossed, m.
pub(super) fn displacement(position: &Vector, (origin, image): (&Vector, Image), cell: &Cell<Plane>) -> Vector {
    *position - *origin + cell.shift(image)
}

/// Takes the tracks of all points at their instants; `instants` says which steps these are.
pub fn track(world: &mut PlanarWorld, instants: &mut Instants) {
    if instants.every == 0 || !world.is_due(instants.every) {
        return;
    }
    if instants.full() {
        instants.thin();
        world.continuum.points.keep_pasts().iter_mut().for_each(|past| past.track.thin());
        if !world.is_due(instants.every) {
            return;
        }
    }
    remember(world, instants.times.len());
    instants.times.push(world.time());
}

/// Points take their displacements now into a slot of their tracks.
fn remember(world: &mut PlanarWorld, slot: usize) {
    let cell = world.assembly.cell;
    world.continuum.points.keep_pasts();
    let Points { hot, cold, pasts, .. } = &mut world.continuum.points;
    for ((hot, cold), past) in hot.iter().zip(cold).zip(pasts) {
        past.track.displacements[slot] = displacement(&hot.position, (&cold.origin, cold.image), &cell);
    }
}

/// Points remember where they are now, and nothing from before: what grains that are kept stand by.
pub(super) fn begin_track(world: &mut PlanarWorld, instants: &mut Instants) {
    remember(world, 0);
    *instants = Instants { times: vec![world.time()], every: 0 };
}

/// Where a point was when grains were kept, m.
pub(super) fn place_kept(point: &PlanarPoint) -> Vector {
    point.cold.origin + point.past.track.displacements[0]
}

/// The continuum's motion since the start, or since grains were kept, as training repeats it: displacements at rising times, and velocity now.
pub struct Motion {
    field: MotionField,
    /// Seconds, rising, the first being that which displacements are counted from.
    pub(super) times: Vec<f64>,
}

impl Motion {
    /// Since grains were kept, at the only one of the instants, and straight ahead. `points` in the order of their ids.
    pub(super) fn since_kept(world: &PlanarWorld, points: &[PlanarPoint], instants: &Instants) -> Self {
        let moved = |point: &PlanarPoint| {
            let now = displacement(&point.hot.position, (&point.cold.origin, point.cold.image), &world.assembly.cell);
            let path = [Vector::zero(), now - point.past.track.displacements[0], point.hot.velocity];
            let displacements = path.iter().map(|moved| [moved[0], moved[1]]).collect();
            let origin = place_kept(point);
            Moved { origin: [origin[0], origin[1]], mass: point.hot.mass, displacements }
        };
        let moved: Vec<Moved> = points.iter().map(moved).collect();
        let times = vec![instants.times.first().copied().unwrap_or_default(), world.time()];
        Self { field: MotionField::new(cell_grid(world), &moved), times }
    }

    /// Since the start. `points` in the order of their ids; `share` of the motion is kept.
    pub(super) fn of(world: &PlanarWorld, points: &[PlanarPoint], instants: &Instants, share: f64) -> Self {
        let moved = |point: &PlanarPoint| {
            let mut path = vec![Vector::zero()];
            path.extend(&point.past.track.displacements[..instants.times.len()]);
            path.push(displacement(&point.hot.position, (&point.cold.origin, point.cold.image), &world.assembly.cell));
            let mut path: Vec<[f64; 2]> = path.iter().map(|moved| [share * moved[0], share * moved[1]]).collect();
            path.push([point.hot.velocity[0], point.hot.velocity[1]]);
            Moved { origin: [point.cold.origin[0], point.cold.origin[1]], mass: point.hot.mass, displacements: path }
        };
        let moved: Vec<Moved> = points.iter().map(moved).collect();
        let mut times = vec![0.0];
        times.extend(&instants.times);
        times.push(world.time());
        Self { field: MotionField::new(cell_grid(world), &moved), times }
    }

    /// Displacement at the i-th time; none where there was no material.
    pub(super) fn at(&self, time: usize, origin: &Vector) -> Option<Vector> {
        self.field.at(time, [origin[0], origin[1]]).map(|[x, y]| Vector::new(x, y))
    }

    /// The same; zero where there was no material.
    pub(super) fn displacement(&self, time: usize, origin: &Vector) -> Vector {
        self.at(time, origin).unwrap_or_else(Vector::zero)
    }

    pub(super) fn velocity(&self, origin: &Vector) -> Vector {
        self.displacement(self.times.len(), origin)
    }
}
