//! Loads on the surface ([`crate::mpm::surface`]), over all ranks: what points bring to nodes goes to the owners of these, axis by axis.

use crate::base::parallel::{Held, over_blocks};
use crate::base::space::{Linear, Space};
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::mpm::load::{Load, area_now, loads_in, of_side};
use crate::mpm::shape::DRIFT_MAX;
use crate::mpm::surface::{Side, SurfaceNode, SurfaceRows, scatter};

/// Numbers of a node in a message, in the plane and in space: a, and A and q of both sides.
const SURFACE: [usize; 2] = [10, 15];

impl<S: Space> World<'_, S> {
    /// Axes across which loads act on the surface.
    fn axes_of_loads(&self) -> impl Iterator<Item = usize> + use<'_, S> {
        let loads = &self.settings.loads;
        (0..S::DIMENSION).filter(|axis| loads.iter().any(|load| load.on_surface && load.axis() == *axis))
    }

    /// Exchanges of nodes with faces and loads in a step, and the numbers per row of all of them.
    pub(crate) fn exchanges_beside(&self) -> [usize; 2] {
        let exchanges = if self.has_points() { self.passes() * self.axes_of_loads().count() } else { 0 };
        let [of_faces, numbers] = self.exchanges_of_faces();
        [of_faces + exchanges, numbers + exchanges * SURFACE[S::DIMENSION - 2]]
    }

    /// Points that loads act at, and tiles near the surface: their points, or those of blocks around, reach a node that a point of the surface
    /// reaches. Collective.
    pub(crate) fn mark_loads(&mut self) {
        let has_surface = self.has_points() && self.axes_of_loads().next().is_some();
        let (points, loads) = (&mut self.continuum.points, &self.settings.loads);
        let cold = &points.cold;
        points.loaded.retain(|(row, _)| loads_in(cold[*row as usize].loads).any(|load| !loads[load].on_surface));
        if !has_surface {
            self.continuum.tiles.surface = SurfaceRows::default();
            return;
        }
        let mut counts = vec![0i64; self.subdomain.layout.block_count()];
        let reach = 2.0 * (self.subdomain.layout.lattice().reach() + DRIFT_MAX);
        for (block, range) in self.subdomain.deal.held().zip(&self.subdomain.point_ranges) {
            counts[block] = i64::from(cold[range.clone()].iter().any(|cold| cold.loads >= of_side(0, false)));
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
        self.continuum.tiles.surface.forces.fill(S::Vector::zero());
        for axis in 0..S::DIMENSION {
            if self.axes_of_loads().any(|other| other == axis) {
                self.scatter_surface(axis);
                match S::DIMENSION {
                    2 => self.gather_surface::<{ SURFACE[0] }>(),
                    _ => self.gather_surface::<{ SURFACE[1] }>(),
                }
                self.sum_surface();
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
                    (word & of_side(axis, upper) != 0).then(|| {
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

    fn sum_surface(&mut self) {
        let timer = self.phases.start();
        let (mosaic, tiles) = (&self.subdomain.nodes.mosaic, &mut self.continuum.tiles);
        let owned: Vec<usize> = tiles.surface.owned(mosaic).collect();
        for number in owned {
            let force = tiles.surface.sum_at(mosaic, number).force();
            tiles.surface.forces[number] += force;
            tiles.sums[number].add_force(&force);
        }
        self.phases.stop(Phase::Nodes, timer);
    }
}
