//! The continuum's part of a step: points to the grid, the grid's own step, and back to points. Tiles at the border of this
//! rank go first, so that what others need of them travels while the inner ones are worked on.

use std::mem;

use rayon::prelude::*;

use crate::base::error::Error;
use crate::base::lane::Instructions;
use crate::base::parallel::{Held, over_blocks};
use crate::base::space::{Linear, Space};
use crate::dem::grains::Grains;
use crate::domain::grid::{BoundaryConditions, Grid, Moment, Reactions};
use crate::domain::phases::Phase;
use crate::domain::subdomain::Subdomain;
use crate::domain::world::{GRAIN_WORDS_PLANE, GRAIN_WORDS_SOLID, World};
use crate::law::material::Absent;
use crate::mpm::continuum::Continuum;
use crate::mpm::gather::{Block, Taken, Taking, correct_grains};
use crate::mpm::load::loads_in;
use crate::mpm::nodes::{self, Stepped};
use crate::mpm::points::Points;
use crate::mpm::scatter::{Scattered, scatter_grains, scatter_loads, scatter_points};
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};
use crate::mpm::shape::DRIFT_MAX;
use crate::mpm::stress::StressModel;
use crate::mpm::tile::{Advanced, Gathered, GrainChange, GrainNode, NODE_WORDS, OwnedNode, Tier, Tiles};
use crate::mpm::volumetric::VolumetricNode;

/// Numbers of a node in a message, in the plane and in space: mass, momentum and force of points, where grains share it with
/// what membranes have along themselves, and what grains bring; velocity and its change for points, and the changes for grains. Where
/// volume strain is averaged, its sums stand behind what points bring, and its mean behind what they take.
const GATHERED: [usize; 2] = [5, 7];
const GATHERED_SHARED: [usize; 2] = [8, 7];
pub(crate) const GRAINS: [usize; 2] = [5, 7];
const ADVANCED: [usize; 2] = [4, 6];
const SUMS_OF_VOLUME: usize = 2;
const MEAN_OF_VOLUME: usize = 1;
pub(crate) const CHANGES: [usize; 2] = [8, 7];

impl<S: Space> World<'_, S> {
    /// Whether grains share nodes with a continuum or with membranes.
    pub(crate) fn is_coupled(&self) -> bool {
        self.has_grid() && self.has_grains()
    }

    /// Numbers per row of the messages of a step: copies of grains, tiles to nodes, nodes to tiles.
    pub(crate) fn words(&self) -> [usize; 3] {
        let space = S::DIMENSION - 2;
        let grains = [GRAIN_WORDS_PLANE, GRAIN_WORDS_SOLID][space];
        let [sums, mean] = if self.averages_volume() { [SUMS_OF_VOLUME, MEAN_OF_VOLUME] } else { [0, 0] };
        match self.is_coupled() {
            true => [grains, GATHERED_SHARED[space] + sums + GRAINS[space], ADVANCED[space] + mean + CHANGES[space]],
            false => [grains, GATHERED[space] + sums, ADVANCED[space] + mean],
        }
    }

    /// Whether volume strain is averaged over nodes where material flows.
    pub(crate) fn averages_volume(&self) -> bool {
        // Where strain is nonlocal, a mean of stress comes back as one, and volume strain of points themselves would drift.
        let is_local = self.settings.nonlocal.is_none();
        is_local
            && self.has_points()
            && !self.has_elements()
            && self.settings.grid.averages_volume
            && self.settings.material.flows()
    }

    /// Times that points go to the grid and back in a step.
    pub(crate) fn passes(&self) -> usize {
        if self.settings.grid.update == StressUpdate::Last { 1 } else { 2 }
    }

    /// Before the forces of the step: stresses, where they are updated first.
    pub(crate) fn strain_first(&mut self) -> Result<(), Error> {
        if self.has_points() && self.settings.grid.update == StressUpdate::First {
            self.strain_by_points(Taken::Strain);
            self.follow_by_grains()?;
        }
        Ok(())
    }

    /// The first half of the grid's step: everything that nodes are made of, summed.
    pub(crate) fn fill_grid(&mut self) {
        if !self.has_grid() {
            return;
        }
        self.scatter_grains();
        self.fill_by_points();
        self.begin_cycle();
    }

    /// The second half: nodes advance, and grains and points take from them what they need.
    pub(crate) fn step_grid(&mut self) -> Result<(), Error> {
        if !self.has_grid() {
            return Ok(());
        }
        let taken = match self.settings.grid.update {
            StressUpdate::First => Taken::Motion,
            StressUpdate::Last => Taken::All,
            StressUpdate::ModifiedLast => Taken::Velocity,
        };
        match self.has_nonlocal_law() {
            true => self.strain_by_means(|world| world.advance_and_take(taken))?,
            false => self.advance_and_take(taken),
        }
        self.take_to_membranes();
        match self.settings.grid.update {
            StressUpdate::First => Ok(()),
            StressUpdate::Last => self.follow_by_grains(),
            StressUpdate::ModifiedLast => {
                self.strain_by_points(Taken::StrainThenPlace);
                self.follow_by_grains()
            }
        }
    }

    /// Nodes advance, and points take from them.
    fn advance_and_take(&mut self, taken: Taken) {
        // What is booked of points is what they are before they take.
        match self.books_points() {
            true => {
                self.advance_grid(Moment::Step, |_, _| ());
                self.book_points();
                self.take_from_grid(Tier::Border, taken);
                self.take_from_grid(Tier::Inner, taken);
            }
            false => self.advance_grid(Moment::Step, |world, tier| world.take_from_grid(tier, taken)),
        }
    }

    fn take_from_grid(&mut self, tier: Tier, taken: Taken) {
        self.correct_grains(tier);
        self.gather_points(tier, taken);
    }

    /// Strain of the grid with the velocities of points as they are.
    fn strain_by_points(&mut self, taken: Taken) {
        self.fill_by_points();
        self.advance_grid(Moment::Look, |world, tier| world.gather_points(tier, taken));
    }

    fn fill_by_points(&mut self) {
        self.push_loaded();
        self.push_membranes();
        self.scatter_points(Tier::Border);
        self.sum_tiles(|world| world.scatter_points(Tier::Inner));
        self.fill_loads();
        self.fill_faces();
    }

    /// What loads that act at points are on them now. One that grains share its place with bears all of it: they bear none.
    fn push_loaded(&mut self) {
        let time = self.time() + 0.5 * self.dt_of_continuum();
        let (points, loads) = (&mut self.continuum.points, &self.settings.loads);
        for (row, push) in &mut points.loaded {
            let (deformation, word) = (&points.hot[*row as usize].deformation, points.cold[*row as usize].loads);
            if loads_in(word).next().is_none() {
                // What someone else put on it.
                continue;
            }
            let borne = loads_in(word).map(|load| &loads[load]).filter(|load| !load.on_surface);
            *push = borne.fold(S::Vector::zero(), |sum, load| sum + load.on(deformation, time));
        }
    }

    /// What points, loads and membranes bring to their tiles; what points bring lies there already if nothing has moved them since they
    /// last took from the grid.
    fn scatter_points(&mut self, tier: Tier) {
        let timer = self.phases.start();
        if !mem::take(&mut self.continuum.points.scattered[tier as usize]) {
            self.scatter_points_anew(tier);
        }
        self.scatter_loads(tier);
        self.scatter_membranes(tier);
        self.phases.stop(Phase::Scatter, timer);
    }

    fn scatter_points_anew(&mut self, tier: Tier) {
        let how = self.scattering();
        let (frames, tiers) = (&self.continuum.frames, &self.subdomain.nodes.mosaic.tiers);
        let (tile_len, rows) = (self.subdomain.nodes.mosaic.nodes_per_tile, self.subdomain.nodes.mosaic.rows());
        let averages = self.averages_volume();
        let (Points { hot, beside, volumetric, .. }, tiles) = (&mut self.continuum.points, &mut self.continuum.tiles);
        let volumetric = if averages { &mut volumetric[..] } else { &mut [] };
        let nodes = (&mut tiles.gathered[..rows], if averages { &mut tiles.volumetric[..rows] } else { &mut [] });
        let held = Held { rows: (&mut hot[..], &mut beside[..], volumetric), tiles: nodes, tile_len };
        over_blocks(&self.subdomain.point_ranges, held, &|block, Held { rows, tiles, .. }| {
            if tiers[block] == tier {
                let (points, beside, volumetric) = (&*rows.0, &*rows.1, &*rows.2);
                clear(&mut *tiles.0, &mut *tiles.1);
                scatter_points(&frames[block], how, Scattered { points, beside, volumetric }, tiles);
            }
            0.0
        });
    }

    fn scatter_loads(&mut self, tier: Tier) {
        let Points { hot, loaded, .. } = &mut self.continuum.points;
        if loaded.is_empty() {
            return;
        }
        let shape = self.settings.grid.shape;
        let (frames, tiers, ranges) =
            (&self.continuum.frames, &self.subdomain.nodes.mosaic.tiers, &self.subdomain.point_ranges);
        let (tile_len, rows) = (self.subdomain.nodes.mosaic.nodes_per_tile, self.subdomain.nodes.mosaic.rows());
        let held = Held { rows: &mut hot[..], tiles: &mut self.continuum.tiles.gathered[..rows], tile_len };
        over_blocks(ranges, held, &|block, Held { rows, tiles, .. }| {
            if tiers[block] == tier {
                let of = |end: usize| loaded.partition_point(|(row, _)| (*row as usize) < end);
                let loaded = &loaded[of(ranges[block].start)..of(ranges[block].end)];
                scatter_loads(&frames[block], shape, (rows, ranges[block].start), loaded, tiles);
            }
            0.0
        });
    }

    /// How points are spread over nodes.
    fn scattering(&self) -> (ShapeFunction, bool, Instructions) {
        let Grid { shape, transfer, .. } = self.settings.grid;
        (shape, transfer == Transfer::Affine, self.assembly.contacts.instructions())
    }

    pub(crate) fn scatter_grains(&mut self) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let (tile_len, rows) = (self.subdomain.nodes.mosaic.nodes_per_tile, self.subdomain.nodes.mosaic.rows());
        let instructions = self.assembly.contacts.instructions();
        let Subdomain { participants, grain_ranges, .. } = &self.subdomain;
        let (frames, exchanges) = (&self.continuum.frames, self.exchanges());
        let Grains { hot, springs, owned, .. } = &mut self.assembly.grains;
        let held = Held {
            rows: (&mut hot[..*owned], &mut springs[..]),
            tiles: &mut self.continuum.tiles.grains[..rows],
            tile_len,
        };
        over_blocks(grain_ranges, held, &|block, Held { rows: (hot, springs), tiles, .. }| {
            let rows = participants.in_block(block);
            if !rows.is_empty() {
                tiles.fill(GrainNode::zero());
                let springs = exchanges.then_some(&*springs);
                scatter_grains((&frames[block], instructions), rows, (hot, springs), tiles);
            }
            0.0
        });
        self.phases.stop(Phase::Couple, timer);
    }

    /// Sums of all tiles at every node that a tile of this rank owns; `meanwhile` runs while rows of border tiles travel, and
    /// must leave those of inner ones ready.
    fn sum_tiles(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let work = |world: &mut Self| {
            meanwhile(world);
            world.sum_tier(Tier::Inner);
        };
        const V: usize = SUMS_OF_VOLUME;
        match (S::DIMENSION, self.is_coupled(), self.averages_volume()) {
            (2, false, false) => self.gather_rows::<{ GATHERED[0] }>(work),
            (2, true, false) => self.gather_rows::<{ GATHERED_SHARED[0] + GRAINS[0] }>(work),
            (_, false, false) => self.gather_rows::<{ GATHERED[1] }>(work),
            (_, true, false) => self.gather_rows::<{ GATHERED_SHARED[1] + GRAINS[1] }>(work),
            (2, false, true) => self.gather_rows::<{ GATHERED[0] + V }>(work),
            (2, true, true) => self.gather_rows::<{ GATHERED_SHARED[0] + V + GRAINS[0] }>(work),
            (_, false, true) => self.gather_rows::<{ GATHERED[1] + V }>(work),
            (_, true, true) => self.gather_rows::<{ GATHERED_SHARED[1] + V + GRAINS[1] }>(work),
        }
        self.sum_tier(Tier::Border);
    }

    /// Rows of tiles to the owners of their nodes: what points bring, and behind it what grains do.
    fn gather_rows<const W: usize>(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let grains = W - if self.is_coupled() { GRAINS[S::DIMENSION - 2] } else { 0 };
        let points = grains - if self.averages_volume() { SUMS_OF_VOLUME } else { 0 };
        self.travel(
            |world| &mut world.subdomain.nodes.gathered,
            |world, row| {
                let mut words = first_words::<W>(&world.continuum.tiles.gathered[row].0);
                if let Some(volume) = world.continuum.tiles.volumetric.get(row) {
                    words[points..grains].copy_from_slice(&volume.0);
                }
                if let Some(of_grains) = world.continuum.tiles.grains.get(row) {
                    of_grains.write(&mut words[grains..]);
                }
                words
            },
            meanwhile,
            |world, row, words: [f64; W]| {
                world.continuum.tiles.gathered[row] = Gathered::of(padded(&words[..points]));
                if let Some(volume) = world.continuum.tiles.volumetric.get_mut(row) {
                    volume.0.copy_from_slice(&words[points..grains]);
                }
                if let Some(of_grains) = world.continuum.tiles.grains.get_mut(row) {
                    *of_grains = GrainNode::read(&words[grains..]);
                }
            },
        );
    }

    fn sum_tier(&mut self, tier: Tier) {
        let timer = self.phases.start();
        self.continuum.tiles.sum(&self.subdomain.nodes.mosaic, tier);
        self.phases.stop(Phase::Nodes, timer);
    }

    /// The equation of motion of nodes; `gather` runs for the tiles of either tier as soon as all their nodes have advanced.
    fn advance_grid(&mut self, moment: Moment, mut gather: impl FnMut(&mut Self, Tier)) {
        self.meet_faces(moment);
        self.advance_nodes(Tier::Border, moment);
        let work = |world: &mut Self| {
            world.advance_nodes(Tier::Inner, moment);
            world.fill_margins(Tier::Inner);
            gather(world, Tier::Inner);
        };
        const V: usize = MEAN_OF_VOLUME;
        match (S::DIMENSION, self.is_coupled(), self.averages_volume()) {
            (2, false, false) => self.spread_rows::<{ ADVANCED[0] }>(work),
            (2, true, false) => self.spread_rows::<{ ADVANCED[0] + CHANGES[0] }>(work),
            (_, false, false) => self.spread_rows::<{ ADVANCED[1] }>(work),
            (_, true, false) => self.spread_rows::<{ ADVANCED[1] + CHANGES[1] }>(work),
            (2, false, true) => self.spread_rows::<{ ADVANCED[0] + V }>(work),
            (2, true, true) => self.spread_rows::<{ ADVANCED[0] + V + CHANGES[0] }>(work),
            (_, false, true) => self.spread_rows::<{ ADVANCED[1] + V }>(work),
            (_, true, true) => self.spread_rows::<{ ADVANCED[1] + V + CHANGES[1] }>(work),
        }
        self.fill_margins(Tier::Border);
        gather(self, Tier::Border);
    }

    /// Rows of nodes to the margins of others' tiles: what points take, and behind it what grains do.
    fn spread_rows<const W: usize>(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let changes = ADVANCED[S::DIMENSION - 2] + if self.averages_volume() { MEAN_OF_VOLUME } else { 0 };
        self.travel(
            |world| &mut world.subdomain.nodes.advanced,
            |world, row| {
                let mut words = first_words::<W>(&world.continuum.tiles.advanced[row].0);
                if let Some(change) = world.continuum.tiles.grain_changes.get(row) {
                    change.write(&mut words[changes..]);
                }
                words
            },
            meanwhile,
            |world, row, words: [f64; W]| {
                world.continuum.tiles.advanced[row] = Advanced::of(padded(&words[..changes]));
                if let Some(change) = world.continuum.tiles.grain_changes.get_mut(row) {
                    *change = GrainChange::read(&words[changes..]);
                }
            },
        );
    }

    fn fill_margins(&mut self, tier: Tier) {
        let timer = self.phases.start();
        self.continuum.tiles.copy_margins(&self.subdomain.nodes.mosaic, tier);
        self.phases.stop(Phase::Nodes, timer);
    }

    fn advance_nodes(&mut self, tier: Tier, moment: Moment) {
        let timer = self.phases.start();
        let (coupled, dt_grains, dt) = (self.is_coupled(), self.settings.grains.dt, self.dt_of_continuum());
        let (gravity, looks) = (self.gravity_now(), moment == Moment::Look);
        let Self { subdomain, assembly, continuum: Continuum { tiles, .. }, bodies, settings, reactions, .. } = self;
        let (Subdomain { nodes, layout, .. }, periods) = (&*subdomain, &assembly.cell);
        let Tiles { sums, volumetric_sums, grain_sums, advanced, grain_changes, strides, shared, faces, .. } = tiles;
        let mosaic = &nodes.mosaic;
        let (per_tile, len, rows) = (mosaic.owned_per_tile(), mosaic.nodes_per_tile, mosaic.rows());
        let conditions = BoundaryConditions { grid: &settings.grid, layout, bodies, periods, gravity, moment };
        let grains_at = |number: usize| if coupled { grain_sums[number] } else { GrainNode::zero() };
        let advance = |node: &OwnedNode, number: usize, reactions: &mut Reactions| {
            let (sum, grains) = (&sums[number], grains_at(number));
            if sum.mass() <= 0.0 {
                return (Advanced::zero(), nodes::without_points(&grains));
            }
            let met = faces.met_at(mosaic, number);
            let (mut dt, mut brought) = (dt, sum.momentum() * (1.0 / sum.mass()));
            if let Some(stride) = strides.get(number).filter(|stride| stride.taken > 0) {
                (dt, brought) = (dt - stride.taken as f64 * dt_grains, stride.brought);
            }
            let hold = |free: S::Vector| conditions.on(free, (node, met), (sum, &grains), dt, reactions);
            let Stepped { velocity, grains } = nodes::step(sum, &grains, &gravity, if looks { 0.0 } else { dt }, hold);
            let volume = volumetric_sums.get(number).map_or(0.0, VolumetricNode::mean);
            (Advanced::new(&velocity, &(velocity - brought), volume), grains)
        };
        // Tiles whose nodes together are worth a task; the nodes of a block have their rows in its own tile.
        let together = mosaic.tiles_per_task();
        let wanted = |first: usize| {
            let of_task = &mosaic.tiers[first..(first + together).min(mosaic.tiles)];
            (first..).zip(of_task).filter(move |(_, of)| **of == tier).map(|(tile, _)| tile)
        };
        let of_task = |task: usize, advanced: &mut [Advanced<S>], changes: &mut [GrainChange<S>]| {
            let (mut booked, first) = (Reactions::default(), task * together);
            for tile in wanted(first) {
                for number in tile * per_tile..(tile + 1) * per_tile {
                    let node = &mosaic.owned[number];
                    let row = node.row as usize - first * len;
                    let (of_points, of_grains) = advance(node, number, &mut booked);
                    advanced[row] = of_points;
                    if coupled && shared[tile] {
                        changes[row] = of_grains;
                    }
                }
            }
            booked
        };
        let tasks = advanced[..rows].par_chunks_mut(len * together);
        let booked = match coupled {
            true => {
                let tasks = tasks.zip(grain_changes[..rows].par_chunks_mut(len * together)).enumerate();
                let booked = tasks.map(|(task, (advanced, changes))| of_task(task, advanced, changes));
                booked.reduce(Reactions::default, Reactions::merged)
            }
            false => {
                let booked = tasks.enumerate().map(|(task, advanced)| of_task(task, advanced, &mut []));
                booked.reduce(Reactions::default, Reactions::merged)
            }
        };
        reactions.merge(&booked);
        self.phases.stop(Phase::Nodes, timer);
    }

    /// Gravity over this step, m/s2.
    pub(crate) fn gravity_now(&self) -> S::Vector {
        let (gravity, ramp) = (self.settings.grains.field.gravity, self.settings.grid.gravity_ramp);
        let time = self.time() + 0.5 * self.dt_of_continuum();
        if time < ramp { gravity * (time / ramp) } else { gravity }
    }

    pub(crate) fn correct_grains(&mut self, tier: Tier) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let (len, instructions) = (self.subdomain.nodes.mosaic.nodes_per_tile, self.assembly.contacts.instructions());
        let Subdomain { participants, grain_ranges, nodes, .. } = &self.subdomain;
        let (frames, tiers) = (&self.continuum.frames, &nodes.mosaic.tiers);
        let (tiles, penalty) = (&self.continuum.tiles.grain_changes, &self.settings.grid.penalty);
        let dt = self.settings.grains.dt;
        let Grains { hot, springs, predicted, owned, .. } = &mut self.assembly.grains;
        let held = Held { rows: (&mut hot[..*owned], &mut springs[..], &mut predicted[..]), tiles: (), tile_len: 0 };
        over_blocks(grain_ranges, held, &|block, Held { rows: (hot, springs, predicted), .. }| {
            let rows = participants.in_block(block);
            if !rows.is_empty() && tiers[block] == tier {
                let tile = &tiles[block * len..(block + 1) * len];
                correct_grains((&frames[block], instructions), (tile, penalty, dt), rows, (hot, springs, predicted));
            }
            0.0
        });
        self.phases.stop(Phase::Couple, timer);
    }

    /// Points take from their tiles, and bring to them at once what the next pass over the grid will ask for: they are at
    /// hand now, and would have to be fetched again. What they bring is that of where they are, whenever it is asked for.
    fn gather_points(&mut self, tier: Tier, taken: Taken) {
        let timer = self.phases.start();
        let (settings, dt, how) = (&self.settings, self.dt_of_continuum(), self.scattering());
        let (tile_len, rows) = (self.subdomain.nodes.mosaic.nodes_per_tile, self.subdomain.nodes.mosaic.rows());
        let Grid { shape, transfer, .. } = settings.grid;
        let taking = Taking { shape, transfer, taken, dt, instructions: self.assembly.contacts.instructions() };
        let (averages, waits_for_mean) = (self.averages_volume(), self.has_nonlocal_law());
        let (frames, tiers) = (&self.continuum.frames, &self.subdomain.nodes.mosaic.tiers);
        let Tiles { advanced, gathered, volumetric: of_volume, faces, .. } = &mut self.continuum.tiles;
        let moves = matches!(taken, Taken::All | Taken::Motion | Taken::StrainThenPlace);
        let (faces, bodies) = (moves.then_some(&*faces), &self.bodies);
        // Affine fields, and ways where places wait for the strain.
        let waits = matches!(taken, Taken::Velocity | Taken::StrainThenPlace);
        // Farther out a point's nodes are not all in the tile; there is a rebuild before it goes to them.
        let reach = DRIFT_MAX * self.subdomain.layout.cell;
        let Points { hot, beside, volumetric, scattered, .. } = &mut self.continuum.points;
        let beside = if waits || transfer == Transfer::Affine { &mut beside[..] } else { &mut [] };
        let volumetric = if averages { &mut volumetric[..] } else { &mut [] };
        let nodes = (&mut gathered[..rows], if averages { &mut of_volume[..rows] } else { &mut [] });
        let held = Held { rows: (&mut hot[..], beside, volumetric), tiles: nodes, tile_len };
        // Where strain is nonlocal the law has its turn once all points have gone on, and they bring nothing to nodes before.
        let material: &dyn StressModel<S> = if waits_for_mean { &Absent } else { &*settings.material };
        let outside = over_blocks(&self.subdomain.point_ranges, held, &|block, Held { rows, tiles, .. }| {
            if tiers[block] != tier {
                return 0.0;
            }
            let (frame, tile) = (&frames[block], &advanced[block * tile_len..(block + 1) * tile_len]);
            let (points, beside, volumetric) = rows;
            let taker = Block { frame, tile, points: &mut *points, beside: &mut *beside, volumetric: &mut *volumetric };
            let outside = material.gather(taking, taker);
            if let Some(set) = faces.filter(|faces| faces.is_near(block)).and_then(|faces| faces.set.as_ref()) {
                points.iter_mut().for_each(|point| set.guard(bodies, dt, &mut point.position));
            }
            if outside < reach && !waits_for_mean {
                clear(&mut *tiles.0, &mut *tiles.1);
                scatter_points(frame, how, Scattered { points, beside, volumetric }, tiles);
            }
            outside
        });
        scattered[tier as usize] = outside < reach && !waits_for_mean;
        if taken != Taken::Velocity && taken != Taken::Strain {
            self.continuum.points_outside[tier as usize] = outside;
        }
        self.phases.stop(Phase::Gather, timer);
    }
}

/// Nothing has been brought to a tile.
fn clear<S: Space>(tile: &mut [Gathered<S>], volumetric: &mut [VolumetricNode]) {
    tile.fill(Gathered::zero());
    volumetric.fill(VolumetricNode::ZERO);
}

/// The first words of a node's row, or all of them; zero behind.
fn first_words<const W: usize>(node: &[f64; NODE_WORDS]) -> [f64; W] {
    std::array::from_fn(|word| if word < NODE_WORDS { node[word] } else { 0.0 })
}

/// A node's row from its first words.
fn padded(words: &[f64]) -> [f64; NODE_WORDS] {
    let mut node = [0.0; NODE_WORDS];
    node[..words.len()].copy_from_slice(words);
    node
}
