//! The world: everything that is simulated, cut into blocks, some of which this rank holds. The only caller of the
//! partition; the physics below is called block by block and row by row.

use std::ops::Range;

use scree_partition::{ExactSum, Halo, HaloBuffers, Transport};

use crate::body::{Burden, Plate};
use crate::dem::contacts::Contacts;
use crate::dem::grains::Grains;
use crate::dem::motion;
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::layout::{Deal, Layout, NodeRows};
use crate::mpm::gather::{correct_grains, gather_points};
use crate::mpm::nodes;
use crate::mpm::points::Point;
use crate::mpm::scatter::{TileFrame, scatter_grains, scatter_points};
use crate::mpm::shape::DRIFT_MAX;
use crate::mpm::tile::{Advanced, Gathered, Tiles};
use crate::observe::phases::{Phase, Phases};
use crate::parallel::over_blocks;
use crate::space::{Linear, Space};

/// Constants of a world that no step changes.
#[derive(Clone, Debug)]
pub struct Settings<C, L> {
    /// Time step of grains and continuum, s.
    pub dt: f64,
    /// Reach of the neighbour list beyond contact, m.
    pub skin: f64,
    /// Share of FLIP.
    pub flip: f64,
    pub contact: C,
    pub material: L,
}

/// The world as this rank holds it.
pub struct World<'t, S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> {
    pub transport: &'t dyn Transport,
    pub settings: Settings<C, L>,
    pub layout: Layout,
    pub deal: Deal,
    /// Steps done.
    pub step: u64,
    pub plates: Vec<Plate<S>>,
    pub grains: Grains<S>,
    pub contacts: Contacts<S, C>,
    /// Copies of other ranks' grains.
    pub ghosts: Halo,
    pub points: Vec<Point<S, L::Memory>>,
    /// Rows of the blocks held here.
    pub grain_ranges: Vec<Range<usize>>,
    pub point_ranges: Vec<Range<usize>>,
    /// Blocks held here whose grains may share nodes with points of the reconciliation zone.
    pub coupled: Vec<bool>,
    pub nodes: NodeRows,
    pub tiles: Tiles<S>,
    pub frames: Vec<TileFrame<S>>,
    /// Largest radius of any grain of the world, m.
    pub radius_max: f64,
    /// Grains and points in the whole world; whatever changes them on purpose says so here, everything else is a loss.
    pub grains_total: u64,
    pub points_total: u64,
    /// Whether this rank has been asked to stop, and whether any has: all ranks learn it after the same step.
    pub stop_wanted: bool,
    pub stop_agreed: bool,
    pub rebuilds: u64,
    pub phases: Phases,
    pub(crate) buffers: HaloBuffers,
}

/// Numbers per row in the messages of a step; wide enough for three dimensions.
const GRAIN_WORDS: usize = 9;
const GATHERED_WORDS: usize = 11;
const ADVANCED_WORDS: usize = 9;
/// Slots of the sums over plates: two plates with force, momentum (three components each) and mass.
const PLATE_SLOTS: usize = 14;

impl<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> World<'_, S, C, L> {
    /// Simulated time at the end of the steps done, s.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.settings.dt
    }

    /// One step of DESIGN.md's list.
    pub fn advance(&mut self) -> Result<(), Error> {
        self.refresh_ghosts();
        self.scatter_points();
        self.evaluate_contacts();
        self.kick_grains();
        self.scatter_grains();
        self.sum_tiles();
        self.accelerate_plates()?;
        self.advance_nodes();
        self.spread_tiles();
        self.correct_grains();
        self.gather_points();
        self.drift();
        self.step += 1;
        self.rebuild_if_due()
    }

    fn has_points(&self) -> bool {
        self.points_total > 0
    }

    fn has_grains(&self) -> bool {
        self.grains_total > 0
    }

    /// Whether grains and continuum share nodes.
    fn is_coupled(&self) -> bool {
        self.has_points() && self.has_grains()
    }

    /// Gives copies of other ranks' grains the state of now. Whatever looks at contacts between steps must call this
    /// first: since the last step's drift the copies lag behind.
    pub fn refresh_ghosts(&mut self) {
        if !self.has_grains() {
            return;
        }
        let timer = self.phases.start();
        let grains = &mut self.grains;
        self.ghosts.pack::<GRAIN_WORDS>(&mut self.buffers, |row| {
            let hot = &grains.hot[row as usize];
            let mut words = [0.0; GRAIN_WORDS];
            for axis in 0..S::DIMENSION {
                words[axis] = hot.position[axis];
                words[3 + axis] = hot.velocity[axis];
            }
            for axis in 0..S::Spin::COMPONENTS {
                words[6 + axis] = hot.spin[axis];
            }
            words
        });
        self.ghosts.exchange::<GRAIN_WORDS>(self.transport, &mut self.buffers, &mut || {});
        self.ghosts.unpack::<GRAIN_WORDS>(&self.buffers, |row, words| {
            let hot = &mut grains.hot[row as usize];
            for axis in 0..S::DIMENSION {
                hot.position[axis] = words[axis];
                hot.velocity[axis] = words[3 + axis];
            }
            for axis in 0..S::Spin::COMPONENTS {
                hot.spin[axis] = words[6 + axis];
            }
        });
        self.phases.stop(Phase::Halo, timer);
    }

    fn scatter_points(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, tiles) = (&self.frames, &mut self.tiles.gathered[..rows]);
        over_blocks(&self.point_ranges, &mut self.points, len, tiles, &|block, _, points, tile| {
            tile.fill(Gathered::zero());
            scatter_points(&frames[block], points, tile);
        });
        self.phases.stop(Phase::Scatter, timer);
    }

    fn evaluate_contacts(&mut self) {
        if !self.has_grains() {
            return;
        }
        let timer = self.phases.start();
        // At the very first evaluation nothing has slid yet.
        let advance = if self.step == 0 { 0.0 } else { self.settings.dt };
        self.contacts.evaluate(&self.settings.contact, &mut self.grains, advance);
        self.phases.stop(Phase::Contacts, timer);
    }

    fn kick_grains(&mut self) {
        let timer = self.phases.start();
        let share = if self.step == 0 { 0.5 } else { 1.0 };
        motion::kick(&mut self.grains, share * self.settings.dt);
        self.phases.stop(Phase::Motion, timer);
    }

    fn scatter_grains(&mut self) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, coupled, cold) = (&self.frames, &self.coupled, &self.grains.cold);
        let (hot, tiles) = (&mut self.grains.hot[..self.grains.owned], &mut self.tiles.gathered[..rows]);
        over_blocks(&self.grain_ranges, hot, len, tiles, &|block, range, hot, tile| {
            if coupled[block] {
                scatter_grains(&frames[block], hot, &cold[range], tile);
            }
        });
        self.phases.stop(Phase::Scatter, timer);
    }

    fn sum_tiles(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let gathered = &mut self.tiles.gathered;
        let halo = &self.nodes.gathered;
        halo.pack::<GATHERED_WORDS>(&mut self.buffers, |row| {
            let mut words = [0.0; GATHERED_WORDS];
            gathered[row as usize].pack(&mut words);
            words
        });
        halo.exchange::<GATHERED_WORDS>(self.transport, &mut self.buffers, &mut || {});
        halo.unpack::<GATHERED_WORDS>(&self.buffers, |row, words| gathered[row as usize] = Gathered::unpack(&words));
        self.tiles.sum(&self.nodes.mosaic);
        self.phases.stop(Phase::Halo, timer);
    }

    /// Height of a node, m.
    pub(crate) fn node_height(&self, place: [i32; 3]) -> f64 {
        self.layout.corner[1] + f64::from(place[1]) * self.layout.cell
    }

    /// The plate that holds a node at height `y`.
    fn holder(plates: &[Plate<S>], y: f64, cell: f64) -> Option<usize> {
        plates.iter().position(|plate| plate.holds(y, cell))
    }

    fn accelerate_plates(&mut self) -> Result<(), Error> {
        if self.plates.is_empty() {
            return Ok(());
        }
        let timer = self.phases.start();
        let mut sums = ExactSum::<PLATE_SLOTS>::new();
        for (row, cold) in self.grains.cold[..self.grains.owned].iter().enumerate() {
            if let crate::dem::grains::Mover::Body(plate) = cold.mover {
                for axis in 0..S::DIMENSION {
                    sums.add(7 * plate as usize + axis, self.grains.force[row][axis]);
                }
            }
        }
        if self.has_points() {
            for (node, sum) in self.nodes.mosaic.owned.iter().zip(&self.tiles.sums) {
                let holder = Self::holder(&self.plates, self.node_height(node.place), self.layout.cell);
                if let (Some(plate), true) = (holder, sum.mass > 0.0) {
                    let momentum = nodes::momentum_of_held(sum, self.settings.dt);
                    for axis in 0..S::DIMENSION {
                        sums.add(7 * plate + 3 + axis, momentum[axis]);
                    }
                    sums.add(7 * plate + 6, sum.mass);
                }
            }
        }
        let sums = sums.reduce(self.transport).map_err(|error| {
            Error::Run(format!("step {}: the forces on the plates are not finite or beyond reason ({error}); the run is unstable: check the time step and the last frames", self.step))
        })?;
        let time = self.time();
        for (index, plate) in self.plates.iter_mut().enumerate() {
            let slots = &sums[7 * index..7 * index + 7];
            let mut burden: Burden<S> =
                Burden { grain_force: S::Vector::zero(), node_mass: slots[6], node_momentum: S::Vector::zero() };
            for axis in 0..S::DIMENSION {
                burden.grain_force[axis] = slots[axis];
                burden.node_momentum[axis] = slots[3 + axis];
            }
            plate.accelerate(&burden, time, self.settings.dt);
        }
        self.phases.stop(Phase::Plates, timer);
        Ok(())
    }

    fn advance_nodes(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let cell = self.layout.cell;
        for (node, sum) in self.nodes.mosaic.owned.iter().zip(&self.tiles.sums) {
            let y = self.layout.corner[1] + f64::from(node.place[1]) * cell;
            let held = Self::holder(&self.plates, y, cell).map(|plate| &self.plates[plate].velocity);
            self.tiles.advanced[node.row as usize] = nodes::advance(sum, held, self.settings.dt);
        }
        self.phases.stop(Phase::Nodes, timer);
    }

    fn spread_tiles(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let advanced = &mut self.tiles.advanced;
        let halo = &self.nodes.advanced;
        halo.pack::<ADVANCED_WORDS>(&mut self.buffers, |row| {
            let mut words = [0.0; ADVANCED_WORDS];
            advanced[row as usize].pack(&mut words);
            words
        });
        halo.exchange::<ADVANCED_WORDS>(self.transport, &mut self.buffers, &mut || {});
        halo.unpack::<ADVANCED_WORDS>(&self.buffers, |row, words| advanced[row as usize] = Advanced::unpack(&words));
        self.tiles.copy_margins(&self.nodes.mosaic);
        self.phases.stop(Phase::Halo, timer);
    }

    fn correct_grains(&mut self) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, coupled, cold) = (&self.frames, &self.coupled, &self.grains.cold);
        let (hot, tiles) = (&mut self.grains.hot[..self.grains.owned], &mut self.tiles.advanced[..rows]);
        over_blocks(&self.grain_ranges, hot, len, tiles, &|block, range, hot, tile| {
            if coupled[block] {
                correct_grains(&frames[block], tile, hot, &cold[range]);
            }
        });
        self.phases.stop(Phase::Gather, timer);
    }

    fn gather_points(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, tiles, settings) = (&self.frames, &mut self.tiles.advanced[..rows], &self.settings);
        over_blocks(&self.point_ranges, &mut self.points, len, tiles, &|block, _, points, tile| {
            gather_points(&frames[block], &settings.material, settings.flip, settings.dt, tile, points);
        });
        self.phases.stop(Phase::Gather, timer);
    }

    fn drift(&mut self) {
        let timer = self.phases.start();
        let still = S::Vector::zero();
        let mut velocities = [still; 8];
        for (velocity, plate) in velocities.iter_mut().zip(&self.plates) {
            *velocity = plate.velocity;
        }
        motion::drift(&mut self.grains, &velocities, self.settings.dt);
        for plate in &mut self.plates {
            plate.drift(self.settings.dt);
        }
        self.phases.stop(Phase::Motion, timer);
    }

    /// How far grains and points of this rank have come since the last rebuild, as a share of what their lists allow.
    fn drift_share(&self) -> f64 {
        let mut square = 0.0f64;
        for (hot, cold) in self.grains.hot[..self.grains.owned].iter().zip(&self.grains.cold) {
            let moved = hot.position - cold.home;
            square = larger(square, moved.dot(&moved));
        }
        // Two grains may close half the skin each.
        let grains = square.sqrt() / (0.5 * self.settings.skin);
        let mut points = 0.0f64;
        for point in &self.points {
            let moved = point.position - point.home;
            for axis in 0..S::DIMENSION {
                points = larger(points, moved[axis].abs());
            }
        }
        let points = points / (DRIFT_MAX * self.layout.cell);
        larger(grains, points)
    }

    fn rebuild_if_due(&mut self) -> Result<(), Error> {
        let timer = self.phases.start();
        let mut most = [self.drift_share(), f64::from(u8::from(self.stop_wanted))];
        self.transport.max(&mut most);
        let [share, stop] = most;
        self.stop_agreed = stop > 0.0;
        self.phases.stop(Phase::Agree, timer);
        if share < 1.0 { Ok(()) } else { self.rebuild() }
    }
}

/// The larger of two numbers; what is not a number stays so, since it must not look like standing still.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}
