//! Loads on the surface ([`crate::mpm::surface`]), over all ranks: what points bring to nodes goes to the owners of these, axis by axis.

use crate::base::ids::Row;
use crate::base::parallel::{Held, over_blocks};
use crate::base::space::{Linear, Space};
use crate::domain::means::{at_points, nodal_sums};
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::mpm::load::{DETACHED, Load, area_now, loads_in, of_side};
use crate::mpm::look::for_each_node;
use crate::mpm::points::{Cold, Hot};
use crate::mpm::shape::DRIFT_MAX;
use crate::mpm::surface::{Side, SurfaceNode, SurfaceRows, scatter};
use crate::mpm::tile::Tiles;

/// Steps between two looks at which points have come off: by their number, so that a run that was taken up looks at the same ones.
const LOOK_EVERY: u64 = 64;
/// A single point has come off once the material of others is less, where its own is, than the first share of that, and is back from the
/// second on. What comes off in a clump has others beside it, and is not seen.
const DETACHED_BELOW: f64 = 0.25;
const BACK_FROM: f64 = 0.5;

/// Numbers of a node in a message, in the plane and in space: a, and A and q of both sides.
const SURFACE: [usize; 2] = [10, 15];

impl<S: Space> World<'_, S> {
    /// Whether loads act on the surface across each axis.
    fn acts_across(&self) -> [bool; 3] {
        let loads = &self.settings.loads;
        std::array::from_fn(|axis| loads.iter().any(|load| load.on_surface && load.axis() == axis))
    }

    /// Exchanges of nodes with faces and loads in a step, and the numbers per row of all of them.
    pub(crate) fn exchanges_beside(&self) -> [usize; 2] {
        let axes = self.acts_across().into_iter().filter(|acts| *acts).count();
        let exchanges = if self.has_grid() { self.passes() * axes } else { 0 };
        let [of_faces, numbers] = self.exchanges_of_faces();
        [of_faces + exchanges, numbers + exchanges * SURFACE[S::DIMENSION - 2]]
    }

    /// Points that loads act at, and tiles near the surface: their points, or those of blocks around, reach a node that a point of the surface
    /// reaches. Collective.
    pub(crate) fn mark_loads(&mut self) {
        let has_surface = self.has_grid() && self.acts_across().contains(&true);
        let (points, loads) = (&mut self.continuum.points, &self.settings.loads);
        let acts = |cold: &Cold<S>| loads_in(cold.loads).any(|load| !loads[load].on_surface);
        let rows = points.cold.iter().enumerate().filter(|(_, cold)| acts(cold));
        points.loaded = rows.map(|(row, _)| (row as Row, S::Vector::zero())).collect();
        if !has_surface {
            self.continuum.tiles.surface = SurfaceRows::default();
            return;
        }
        let mut counts = vec![0i64; self.subdomain.layout.block_count()];
        let reach = 2.0 * (self.subdomain.layout.lattice().reach() + DRIFT_MAX);
        for (block, range) in self.subdomain.deal.held().zip(&self.subdomain.point_ranges) {
            let cold = &self.continuum.points.cold[range.clone()];
            counts[block] = i64::from(cold.iter().any(|cold| cold.loads >= of_side(0, false)));
        }
        self.transport.sum(&mut counts);
        let near = self.within(reach.ceil() as usize, &counts)[self.subdomain.deal.held()].to_vec();
        let surface = &mut self.continuum.tiles.surface;
        if surface.near != near || surface.forces.len() != self.subdomain.nodes.mosaic.owned.len() {
            *surface = SurfaceRows::lay(&self.subdomain.nodes.mosaic, near);
        }
    }

    /// Nodes take what loads on the surface give them.
    pub(crate) fn fill_loads(&mut self) {
        if self.continuum.tiles.surface.near.is_empty() {
            return;
        }
        // What is a single point from the start is whole.
        if self.step.is_multiple_of(LOOK_EVERY) && self.points_total > 1 {
            self.mark_detached();
        }
        self.continuum.tiles.surface.clear();
        let acts = self.acts_across();
        for axis in (0..S::DIMENSION).filter(|axis| acts[*axis]) {
            self.scatter_surface(axis);
            match S::DIMENSION {
                2 => self.gather_surface::<{ SURFACE[0] }>(),
                _ => self.gather_surface::<{ SURFACE[1] }>(),
            }
            let timer = self.phases.start();
            let Tiles { surface, sums, .. } = &mut self.continuum.tiles;
            surface.push(&self.subdomain.nodes.mosaic, sums);
            self.phases.stop(Phase::Nodes, timer);
        }
    }

    /// Finds single points of the surface that have come off the material. Nothing is left of the surface that they were of, and what presses
    /// across one axis would crush them, for nothing holds them across the others. Collective.
    fn mark_detached(&mut self) {
        let volume = |hot: &Hot<S>| hot.volume * hot.volume_ratio();
        let filled = nodal_sums(self, |_, hot| [volume(hot) / (hot.weight * hot.mass)]);
        let filled = at_points(self, &filled);
        let shape = self.settings.grid.shape;
        let points = &mut self.continuum.points;
        for (block, range) in self.subdomain.point_ranges.iter().enumerate() {
            for row in range.clone() {
                let (hot, cold) = (&points.hot[row], &mut points.cold[row]);
                if cold.loads < of_side(0, false) {
                    continue;
                }
                let mut square = 0.0;
                for_each_node(&self.continuum.frames[block], shape, &hot.position, |_, value| square += value * value);
                let own = square * volume(hot);
                let share = if cold.loads & DETACHED == 0 { DETACHED_BELOW } else { BACK_FROM };
                let is_detached = filled[row][0] - own < share * own;
                cold.loads = if is_detached { cold.loads | DETACHED } else { cold.loads & !DETACHED };
            }
        }
    }

    fn scatter_surface(&mut self, axis: usize) {
        let timer = self.phases.start();
        let time = self.time() + 0.5 * self.dt_of_continuum();
        let mosaic = &self.subdomain.nodes.mosaic;
        let shape = self.settings.grid.shape;
        let loads = &self.settings.loads;
        let across = |load: &Load<S>| load.on_surface && load.axis() == axis;
        let edge = loads.iter().find(|load| across(load)).map_or(0.0, |load| load.area.norm());
        let SurfaceRows { near, brought, .. } = &mut self.continuum.tiles.surface;
        let (near, frames, ranges) = (&*near, &self.continuum.frames, &self.subdomain.point_ranges);
        let (hot, cold) = (&mut self.continuum.points.hot, &self.continuum.points.cold);
        let held = Held { rows: &mut hot[..], tiles: &mut brought[..mosaic.rows()], tile_len: mosaic.nodes_per_tile };
        over_blocks(ranges, held, &|block, Held { rows, tiles, .. }| {
            if near[block] {
                let (points, cold) = (&*rows, &cold[ranges[block].clone()]);
                let side = |row: usize, upper: bool| {
                    let (deformation, word) = (&points[row].deformation, cold[row].loads);
                    (word & of_side(axis, upper) != 0 && word & DETACHED == 0).then(|| {
                        let mut area = S::Vector::zero();
                        area[axis] = if upper { edge } else { -edge };
                        let here = |load: &&Load<S>| across(load) && (load.area[axis] > 0.0) == upper;
                        let borne = loads_in(word).map(|load| &loads[load]).filter(here);
                        let load = borne.fold(S::Vector::zero(), |sum, load| sum + load.on(deformation, time));
                        Side { area: area_now::<S>(deformation, &area), load }
                    })
                };
                scatter(&frames[block], shape, points, |row| [side(row, false), side(row, true)], tiles);
            }
            0.0
        });
        self.phases.stop(Phase::Scatter, timer);
    }

    fn gather_surface<const W: usize>(&mut self) {
        self.travel(
            |world| &mut world.subdomain.nodes.gathered,
            |world, row| world.continuum.tiles.surface.brought[row].words::<W>(),
            |_| (),
            |world, row, words: [f64; W]| {
                world.continuum.tiles.surface.brought[row] = SurfaceNode::of(&words);
            },
        );
    }
}
