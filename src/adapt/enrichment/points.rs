//! Points that are made of grains: where, and in which state.

use std::collections::{BTreeMap, BTreeSet};

use super::{PlanarPoint, Vector};
use crate::base::ids::PointId;
use crate::base::space::{Linear, Plane, Space};
use crate::base::symmetric::Symmetric;
use crate::couple::patch::Patch;
use crate::couple::zone::CellGrid;
use crate::mpm::points::Point;
use crate::mpm::scheme::Transfer;
use crate::mpm::track::{Instants, Track};
use crate::prepare::sheared::PlanarWorld;

type Tensor = <Plane as Space>::Tensor;

/// Of what they would grains must fill this share of a point's own place for it to be made, where a cell is not full: few have their centres
/// there.
const FILLED_PLACE: f64 = 0.5;

/// Cells of this rank and parts of them that points are to be made in, in their order: all of a full cell's outside the old rim that are free, and elsewhere
/// those that grains fill. `filled` is the volume of the grains outside the rim that give up their place, m3, `taken` where points are,
/// `solid` what grains fill of a part in the mean, m3.
pub(super) fn places(
    (grid, patches): (&CellGrid, &BTreeMap<u64, Patch>),
    (parts, solid): (u64, f64),
    filled: &BTreeMap<(u64, u64), f64>,
    taken: BTreeSet<(u64, u64)>,
    world: &PlanarWorld,
) -> BTreeSet<(u64, u64)> {
    let is_free = |cell: u64, part: u64| {
        let place = middle_of(grid, parts, (cell, part));
        let reach = 0.5 * grid.cell / parts as f64;
        world.bodies.iter().filter_map(|body| body.nearest(&place)).all(|near| near.distance >= reach)
    };
    let mut places = BTreeSet::new();
    for ((cell, part), volume) in filled {
        // In a cell of the old rim points stand already, if not everywhere.
        if patches[cell].room_full > 0.0 && patches[cell].is_core() {
            places.extend((0..parts * parts).map(|part| (*cell, part)));
        } else if *volume >= FILLED_PLACE * solid {
            places.insert((*cell, *part));
        }
    }
    places.difference(&taken).filter(|(cell, part)| is_free(*cell, *part)).copied().collect()
}

/// Which of its parts a place in a cell lies in, row by row.
pub(super) fn part_at(grid: &CellGrid, parts: u64, cell: usize, place: &Vector) -> u64 {
    let way = *place - grid.centre(cell);
    let part = |axis: usize| {
        let at = ((way[axis] / grid.cell + 0.5) * parts as f64).floor();
        (at as u64).min(parts - 1)
    };
    part(1) * parts + part(0)
}

/// Middle of a part of a cell, m.
fn middle_of(grid: &CellGrid, parts: u64, (cell, part): (u64, u64)) -> Vector {
    let edge = grid.cell / parts as f64;
    let way = |index: u64| (index as f64 + 0.5) * edge - 0.5 * grid.cell;
    grid.centre(cell as usize) + Vector::new(way(part % parts), way(part / parts))
}

/// An id that no point has, and none above it.
pub(super) fn first_free_id(world: &PlanarWorld) -> u64 {
    let mut most = [world.continuum.points.cold.iter().map(|cold| cold.id.0).max().unwrap_or(0) as f64];
    world.transport.max(&mut most);
    most[0] as u64 + 1
}

/// Displacement gradients up to which fields over some cells are linear enough to tell volumes.
const GRADIENT_LINEAR: f64 = 0.1;
/// Volume ratios that are believed.
const VOLUME_RATIOS: [f64; 2] = [0.9, 1.25];

/// Makes points of patches.
pub(super) struct Maker<'a> {
    pub grid: &'a CellGrid,
    /// Points along a cell, and the volume of each, m3.
    pub parts: u64,
    pub volume: f64,
    /// Solid volume fraction at the start.
    pub fraction: f64,
    /// Ids count places from here.
    pub first: u64,
    pub instants: &'a Instants,
    /// s.
    pub now: f64,
}

impl Maker<'_> {
    /// In the middle of a part of a cell, as the grains of the patch around the cell's centre are in the mean.
    pub fn point(&self, world: &PlanarWorld, at: (u64, u64), patch: &Patch) -> PlanarPoint {
        let place = middle_of(self.grid, self.parts, at);
        let way = place - self.grid.centre(at.0 as usize);
        let (velocity, displacement) = (patch.velocity(self.grid.cell), patch.displacement(self.grid.cell));
        let deformation = self.deformation(&displacement.gradient, patch);
        let ratio = Plane::determinant(&deformation);
        let fraction = self.fraction / ratio;
        let mass = patch.mass / patch.solid * fraction * self.volume;
        let id = PointId(self.first + at.0 * self.parts * self.parts + at.1);
        let mut point: PlanarPoint = Point::resting(id, place, mass, self.volume / ratio);
        let law = &world.settings.material;
        // Of the space that grains of the core have; elsewhere nodes bear a part.
        let stress: Tensor =
            if patch.solid_core > 0.0 { patch.moment * (fraction / patch.solid_core) } else { Tensor::zero() };
        point.hot.velocity = velocity.at(&way);
        point.hot.deformation = deformation;
        point.hot.memory = law.start(&(stress * ratio), fraction);
        point.hot.stress = Symmetric::of(&law.stress(&point.hot.memory));
        if world.settings.grid.transfer == Transfer::Affine {
            point.affine = velocity.gradient;
        }
        let moved = displacement.at(&way);
        point.cold.origin = place - moved;
        point.past.track = self.track(&moved);
        point
    }

    /// x = X + u(x), so that F = (1 - du/dx)^-1. Where grains went far, u is not linear over some cells: there the volume is the one that
    /// they fill, if they do.
    fn deformation(&self, gradient: &Tensor, patch: &Patch) -> Tensor {
        let found = Plane::inverse(&(Tensor::identity() - gradient));
        let found = found.filter(|found| Plane::determinant(found) > 0.0).unwrap_or_else(Tensor::identity);
        let ratio = Plane::determinant(&found);
        let counted = self.fraction * patch.room_full / patch.solid_full;
        let wanted = match gradient.norm() > GRADIENT_LINEAR && patch.room_full > 0.0 {
            true => counted,
            false => ratio,
        };
        found * (wanted.clamp(VOLUME_RATIOS[0], VOLUME_RATIOS[1]) / ratio).sqrt()
    }

    /// Of grains no path is known: straight ahead.
    fn track(&self, moved: &Vector) -> Track<Plane> {
        let mut track = Track::default();
        for (displacement, time) in track.displacements.iter_mut().zip(&self.instants.times) {
            *displacement = moved * (time / self.now);
        }
        track
    }
}
