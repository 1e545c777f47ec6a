//! The continuum's part of a step: points to the grid, the grid's own step, and back to points. Tiles at the border of this
//! rank go first, so that what others need of them travels while the inner ones are worked on.

use rayon::prelude::*;

use crate::grid::{Grid, Reactions, absorbed_by_faces, held_by_bodies, held_by_faces};
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::mpm::gather::{Taken, Taking, correct_grains, gather_points};
use crate::mpm::nodes;
use crate::mpm::points::Points;
use crate::mpm::scatter::{scatter_grains, scatter_loads, scatter_points};
use crate::mpm::tile::{Advanced, Gathered, GrainNode, NODE_WORDS, OwnedNode, Tier, Tiles};
use crate::observe::phases::Phase;
use crate::parallel::{over_blocks, over_rows};
use crate::scenario::mpm::{StressUpdate, Transfer};
use crate::space::{Linear, Space};
use crate::world::{GRAIN_WORDS_PLANE, GRAIN_WORDS_SOLID, World};

/// What a phase does with the velocities of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    /// Forces act.
    Step,
    /// The velocities that points brought, held where they are held once forces act: were parting told by these velocities
    /// alone, a node under load that swings by a little would part and be held in turn, and take energy from nowhere.
    Look,
}

/// Numbers of a node in a message, in the plane and in space: mass, momentum and force of points, mass and momentum of
/// grains; velocity and its change for points, and the change for grains.
const GATHERED: [usize; 2] = [5, 7];
const GRAINS: [usize; 2] = [3, 4];
const ADVANCED: [usize; 2] = [4, 6];
const CHANGES: [usize; 2] = [2, 3];

impl<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> World<'_, S, C, L> {
    /// Whether grains and continuum share nodes.
    pub(crate) fn is_coupled(&self) -> bool {
        self.has_points() && self.has_grains()
    }

    /// Numbers per row of the messages of a step: copies of grains, tiles to nodes, nodes to tiles.
    pub(crate) fn words(&self) -> [usize; 3] {
        let (space, coupled) = (S::DIMENSION - 2, usize::from(self.is_coupled()));
        let grains = [GRAIN_WORDS_PLANE, GRAIN_WORDS_SOLID][space];
        [grains, GATHERED[space] + coupled * GRAINS[space], ADVANCED[space] + coupled * CHANGES[space]]
    }

    /// Times that points go to the grid and back in a step.
    pub(crate) fn passes(&self) -> usize {
        if self.settings.grid.update == StressUpdate::Last { 1 } else { 2 }
    }

    /// Before the forces of the step: stresses, where they are updated first.
    pub(crate) fn strain_first(&mut self) {
        if self.has_points() && self.settings.grid.update == StressUpdate::First {
            self.strain_by_points(Taken::Strain);
        }
    }

    /// The first half of the grid's step: everything that nodes are made of, summed.
    pub(crate) fn fill_grid(&mut self) {
        if !self.has_points() {
            return;
        }
        self.scatter_grains();
        self.fill_by_points();
    }

    /// The second half: nodes advance, and grains and points take from them what they need.
    pub(crate) fn step_grid(&mut self) {
        if !self.has_points() {
            return;
        }
        let taken = match self.settings.grid.update {
            StressUpdate::First => Taken::Motion,
            StressUpdate::Last => Taken::All,
            StressUpdate::ModifiedLast => Taken::Velocity,
        };
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
        if self.settings.grid.update == StressUpdate::ModifiedLast {
            self.strain_by_points(Taken::StrainThenPlace);
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
        self.scatter_points(Tier::Border);
        self.sum_tiles(|world| world.scatter_points(Tier::Inner));
    }

    /// What loads are on their points now.
    fn push_loaded(&mut self) {
        let time = self.time() + 0.5 * self.settings.dt;
        let (points, loads) = (&mut self.points, &self.settings.loads);
        for (row, push) in &mut points.loaded {
            let (hot, mut borne) = (&points.hot[*row as usize], points.cold[*row as usize].loads);
            if borne == 0 {
                // What someone else put on it.
                continue;
            }
            *push = S::Vector::zero();
            while borne != 0 {
                *push += loads[borne.trailing_zeros() as usize].on(&hot.deformation, time);
                borne &= borne - 1;
            }
            *push = *push * hot.weight;
        }
    }

    fn scatter_points(&mut self, tier: Tier) {
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let grid = &self.settings.grid;
        let how = (grid.shape, grid.transfer == Transfer::Affine, self.contacts.instructions());
        let (frames, tiers, tiles) = (&self.frames, &self.nodes.mosaic.tiers, &mut self.tiles.gathered[..rows]);
        let Points { hot, beside, loaded, .. } = &mut self.points;
        over_blocks(&self.point_ranges, hot, len, tiles, &|block, range, points, tile| {
            if tiers[block] != tier {
                return;
            }
            tile.fill(Gathered::zero());
            scatter_points(&frames[block], how, (points, &beside[range.clone()]), tile);
            let of = |end: usize| loaded.partition_point(|(row, _)| (*row as usize) < end);
            let loaded = &loaded[of(range.start)..of(range.end)];
            scatter_loads(&frames[block], how.0, (points, range.start), loaded, tile);
        });
        self.phases.stop(Phase::Scatter, timer);
    }

    fn scatter_grains(&mut self) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, coupled, movers) = (&self.frames, &self.coupled, &self.grains.movers);
        let (hot, tiles) = (&mut self.grains.hot[..self.grains.owned], &mut self.tiles.grains[..rows]);
        over_blocks(&self.grain_ranges, hot, len, tiles, &|block, range, hot, tile| {
            tile.fill(GrainNode::zero());
            if coupled[block] {
                scatter_grains(&frames[block], hot, &movers[range], tile);
            }
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
        match (S::DIMENSION, self.is_coupled()) {
            (2, false) => self.gather_rows::<{ GATHERED[0] }>(work),
            (2, true) => self.gather_rows::<{ GATHERED[0] + GRAINS[0] }>(work),
            (_, false) => self.gather_rows::<{ GATHERED[1] }>(work),
            (_, true) => self.gather_rows::<{ GATHERED[1] + GRAINS[1] }>(work),
        }
        self.sum_tier(Tier::Border);
    }

    /// Rows of tiles to the owners of their nodes: what points bring, and behind it what grains do.
    fn gather_rows<const W: usize>(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let grains = GATHERED[S::DIMENSION - 2];
        self.travel(
            |world| &mut world.nodes.gathered,
            |world, row| {
                let mut words = first_words::<W>(&world.tiles.gathered[row].0);
                if let Some(of_grains) = world.tiles.grains.get(row) {
                    words[grains] = of_grains.mass;
                    (0..S::DIMENSION).for_each(|axis| words[grains + 1 + axis] = of_grains.momentum[axis]);
                }
                words
            },
            meanwhile,
            |world, row, words: [f64; W]| {
                world.tiles.gathered[row] = Gathered::of(padded(&words[..grains]));
                if let Some(of_grains) = world.tiles.grains.get_mut(row) {
                    of_grains.mass = words[grains];
                    of_grains.momentum.as_mut_slice().copy_from_slice(&words[grains + 1..]);
                }
            },
        );
    }

    fn sum_tier(&mut self, tier: Tier) {
        let timer = self.phases.start();
        self.tiles.sum(&self.nodes.mosaic, tier);
        self.phases.stop(Phase::Nodes, timer);
    }

    /// The equation of motion of nodes; `gather` runs for the tiles of either tier as soon as all their nodes have advanced.
    fn advance_grid(&mut self, moment: Moment, mut gather: impl FnMut(&mut Self, Tier)) {
        self.advance_nodes(Tier::Border, moment);
        let work = |world: &mut Self| {
            world.advance_nodes(Tier::Inner, moment);
            world.fill_margins(Tier::Inner);
            gather(world, Tier::Inner);
        };
        match (S::DIMENSION, self.is_coupled()) {
            (2, false) => self.spread_rows::<{ ADVANCED[0] }>(work),
            (2, true) => self.spread_rows::<{ ADVANCED[0] + CHANGES[0] }>(work),
            (_, false) => self.spread_rows::<{ ADVANCED[1] }>(work),
            (_, true) => self.spread_rows::<{ ADVANCED[1] + CHANGES[1] }>(work),
        }
        self.fill_margins(Tier::Border);
        gather(self, Tier::Border);
    }

    /// Rows of nodes to the margins of others' tiles: what points take, and behind it what grains do.
    fn spread_rows<const W: usize>(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let changes = ADVANCED[S::DIMENSION - 2];
        self.travel(
            |world| &mut world.nodes.advanced,
            |world, row| {
                let mut words = first_words::<W>(&world.tiles.advanced[row].0);
                if let Some(change) = world.tiles.grain_changes.get(row) {
                    (0..S::DIMENSION).for_each(|axis| words[changes + axis] = change[axis]);
                }
                words
            },
            meanwhile,
            |world, row, words: [f64; W]| {
                world.tiles.advanced[row] = Advanced::of(padded(&words[..changes]));
                if let Some(change) = world.tiles.grain_changes.get_mut(row) {
                    change.as_mut_slice().copy_from_slice(&words[changes..]);
                }
            },
        );
    }

    fn fill_margins(&mut self, tier: Tier) {
        let timer = self.phases.start();
        self.tiles.copy_margins(&self.nodes.mosaic, tier);
        self.phases.stop(Phase::Nodes, timer);
    }

    fn advance_nodes(&mut self, tier: Tier, moment: Moment) {
        let timer = self.phases.start();
        let (coupled, cell) = (self.is_coupled(), self.layout.cell);
        let (step, looks) = (self.settings.dt, moment == Moment::Look);
        let dt = if looks { 0.0 } else { step };
        let gravity = self.gravity_now();
        let Self { nodes, tiles, bodies, layout, settings, reactions, cell: periods, .. } = self;
        let (mosaic, Tiles { sums, grain_sums, advanced, grain_changes, .. }) = (&nodes.mosaic, tiles);
        let (per_tile, len, rows) = (mosaic.owned_per_tile(), mosaic.nodes_per_tile, mosaic.rows());
        let grains_at = |number: usize| if coupled { grain_sums[number] } else { GrainNode::zero() };
        let advance = |node: &OwnedNode, number: usize, reactions: &mut Reactions| {
            let (sum, grains) = (&sums[number], grains_at(number));
            let mass = sum.mass() + grains.mass;
            let place: S::Vector = layout.node_at(node.place);
            let holder = bodies.iter().position(|body| body.holds(place[1], cell));
            let mut booked = if looks { None } else { Some(reactions) };
            let hold = |free: S::Vector| match holder {
                Some(body) => bodies[body].velocity,
                None => {
                    let forces = if looks { sum.force() * (step / mass) + gravity * step } else { S::Vector::zero() };
                    let booked = &mut booked;
                    let before = (sum.momentum() + grains.momentum) * (1.0 / mass);
                    let (grid, at) = (&settings.grid, (&settings.grid, &*layout));
                    let pushed =
                        absorbed_by_faces::<S>(free + forces, &before, at, node, (mass, step), booked.as_deref_mut());
                    let velocity = if looks { free } else { pushed };
                    let held =
                        held_by_bodies([velocity, pushed], (bodies, periods), &place, mass, booked.as_deref_mut());
                    held_by_faces::<S>(held, grid, layout, node, mass, booked.as_deref_mut())
                }
            };
            nodes::advance(sum, &grains, &gravity, dt, hold)
        };
        // Tiles whose nodes together are worth a task; the nodes of a block have their rows in its own tile.
        let together = mosaic.tiles_per_task();
        let wanted = |first: usize| {
            let of_task = &mosaic.tiers[first..(first + together).min(mosaic.tiles)];
            (first..).zip(of_task).filter(move |(_, of)| **of == tier).map(|(tile, _)| tile)
        };
        let tasks = advanced[..rows].par_chunks_mut(len * together).enumerate().map(|(task, advanced)| {
            let (mut booked, first) = (Reactions::default(), task * together);
            for tile in wanted(first) {
                for number in tile * per_tile..(tile + 1) * per_tile {
                    let node = &mosaic.owned[number];
                    advanced[node.row as usize - first * len] = advance(node, number, &mut booked);
                }
            }
            booked
        });
        reactions.merge(&tasks.reduce(Reactions::default, Reactions::merged));
        if coupled {
            grain_changes[..rows].par_chunks_mut(len * together).enumerate().for_each(|(task, changes)| {
                let first = task * together;
                for tile in wanted(first) {
                    for number in tile * per_tile..(tile + 1) * per_tile {
                        let row = mosaic.owned[number].row as usize;
                        changes[row - first * len] =
                            nodes::correction(&sums[number], &grain_sums[number], &advanced[row]);
                    }
                }
            });
        }
        self.phases.stop(Phase::Nodes, timer);
    }

    /// Gravity over this step, m/s2.
    pub(crate) fn gravity_now(&self) -> S::Vector {
        let (gravity, ramp) = (self.settings.field.gravity, self.settings.grid.gravity_ramp);
        let time = self.time() + 0.5 * self.settings.dt;
        if time < ramp { gravity * (time / ramp) } else { gravity }
    }

    fn correct_grains(&mut self, tier: Tier) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, coupled, movers) = (&self.frames, &self.coupled, &self.grains.movers);
        let (hot, tiles) = (&mut self.grains.hot[..self.grains.owned], &mut self.tiles.grain_changes[..rows]);
        let tiers = &self.nodes.mosaic.tiers;
        over_blocks(&self.grain_ranges, hot, len, tiles, &|block, range, hot, tile| {
            if coupled[block] && tiers[block] == tier {
                correct_grains(&frames[block], tile, hot, &movers[range]);
            }
        });
        self.phases.stop(Phase::Couple, timer);
    }

    fn gather_points(&mut self, tier: Tier, taken: Taken) {
        let timer = self.phases.start();
        let (len, settings) = (self.nodes.mosaic.nodes_per_tile, &self.settings);
        let Grid { shape, transfer, .. } = settings.grid;
        let taking = Taking { shape, transfer, taken, dt: settings.dt, instructions: self.contacts.instructions() };
        let (frames, tiers, tiles) = (&self.frames, &self.nodes.mosaic.tiers, &self.tiles.advanced);
        // Affine fields, and ways where places wait for the strain.
        let waits = matches!(taken, Taken::Velocity | Taken::StrainThenPlace);
        let Points { hot, beside, .. } = &mut self.points;
        let beside = if waits || transfer == Transfer::Affine { &mut beside[..] } else { &mut [] };
        let outside = over_rows(&self.point_ranges, hot, beside, &|block, points, beside| {
            if tiers[block] != tier {
                return 0.0;
            }
            let tile = &tiles[block * len..(block + 1) * len];
            gather_points(&frames[block], &settings.material, taking, tile, points, beside)
        });
        if taken != Taken::Velocity && taken != Taken::Strain {
            self.points_outside[tier as usize] = outside;
        }
        self.phases.stop(Phase::Gather, timer);
    }
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
