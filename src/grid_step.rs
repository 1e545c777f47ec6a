//! The continuum's part of a step: points to the grid, the grid's own step, and back to points. Tiles at the border of this
//! rank go first, so that what others need of them travels while the inner ones are worked on.

use rayon::prelude::*;

use crate::grid::{Grid, Reactions, held_by_bodies, held_by_faces};
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
use crate::world::World;

/// What a phase does with the velocities of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    /// Forces act.
    Step,
    /// The velocities that points brought, held where they are held once forces act: were parting told by these velocities
    /// alone, a node under load that swings by a little would part and be held in turn, and take energy from nowhere.
    Look,
}

/// Numbers of a grain's node in a message, and of a node's row with it.
const GRAIN_WORDS: usize = 4;
const COUPLED_WORDS: usize = NODE_WORDS + GRAIN_WORDS;

impl<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> World<'_, S, C, L> {
    /// Whether grains and continuum share nodes.
    pub(crate) fn is_coupled(&self) -> bool {
        self.has_points() && self.has_grains()
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
                self.gather_points(Tier::Border, taken);
                self.gather_points(Tier::Inner, taken);
            }
            false => self.advance_grid(Moment::Step, |world, tier| world.gather_points(tier, taken)),
        }
        self.correct_grains();
        if self.settings.grid.update == StressUpdate::ModifiedLast {
            self.strain_by_points(Taken::StrainThenPlace);
        }
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
        let (frames, coupled, cold) = (&self.frames, &self.coupled, &self.grains.cold);
        let (hot, tiles) = (&mut self.grains.hot[..self.grains.owned], &mut self.tiles.grains[..rows]);
        over_blocks(&self.grain_ranges, hot, len, tiles, &|block, range, hot, tile| {
            tile.fill(GrainNode::zero());
            if coupled[block] {
                scatter_grains(&frames[block], hot, &cold[range], tile);
            }
        });
        self.phases.stop(Phase::Couple, timer);
    }

    /// Sums of all tiles at every node that a tile of this rank owns; `meanwhile` runs while rows of border tiles travel, and
    /// must leave those of inner ones ready.
    fn sum_tiles(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let work = |world: &mut Self| {
            meanwhile(world);
            world.sum_side(Tier::Inner);
        };
        match self.is_coupled() {
            false => self.travel(
                |world| &mut world.nodes.gathered,
                |world, row| world.tiles.gathered[row].0,
                work,
                |world, row, words: [f64; NODE_WORDS]| world.tiles.gathered[row] = Gathered::of(words),
            ),
            true => self.travel(
                |world| &mut world.nodes.gathered,
                |world, row| {
                    let grains = &world.tiles.grains[row];
                    packed::<S>(&world.tiles.gathered[row].0, grains.mass, &grains.momentum)
                },
                work,
                |world, row, words| {
                    let (node, mass, momentum) = unpacked::<S>(&words);
                    world.tiles.gathered[row] = Gathered::of(node);
                    world.tiles.grains[row] = GrainNode { mass, momentum };
                },
            ),
        }
        self.sum_side(Tier::Border);
    }

    fn sum_side(&mut self, tier: Tier) {
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
        match self.is_coupled() {
            false => self.travel(
                |world| &mut world.nodes.advanced,
                |world, row| world.tiles.advanced[row].0,
                work,
                |world, row, words: [f64; NODE_WORDS]| world.tiles.advanced[row] = Advanced::of(words),
            ),
            true => self.travel(
                |world| &mut world.nodes.advanced,
                |world, row| packed::<S>(&world.tiles.advanced[row].0, 0.0, &world.tiles.grain_changes[row]),
                work,
                |world, row, words| {
                    let (node, _, change) = unpacked::<S>(&words);
                    world.tiles.advanced[row] = Advanced::of(node);
                    world.tiles.grain_changes[row] = change;
                },
            ),
        }
        self.fill_margins(Tier::Border);
        gather(self, Tier::Border);
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
                    let held =
                        held_by_bodies([free, free + forces], (bodies, periods), &place, mass, booked.as_deref_mut());
                    held_by_faces::<S>(held, &settings.grid, layout, node, (mass, dt), booked.as_deref_mut())
                }
            };
            nodes::advance(sum, &grains, &gravity, dt, hold)
        };
        // Tiles whose nodes together are worth a task; the nodes of a block have their rows in its own tile.
        let together = mosaic.tiles_per_task();
        let wanted = |first: usize| (first..).zip(&mosaic.tiers[first..]).filter(move |(_, of)| **of == tier);
        let tasks = advanced[..rows].par_chunks_mut(len * together).enumerate().map(|(task, advanced)| {
            let (mut booked, first) = (Reactions::default(), task * together);
            for (tile, _) in wanted(first).take_while(|(tile, _)| *tile < first + together) {
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
                for (tile, _) in wanted(first).take_while(|(tile, _)| *tile < first + together) {
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

    fn correct_grains(&mut self) {
        if !self.is_coupled() {
            return;
        }
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let (frames, coupled, cold) = (&self.frames, &self.coupled, &self.grains.cold);
        let (hot, tiles) = (&mut self.grains.hot[..self.grains.owned], &mut self.tiles.grain_changes[..rows]);
        over_blocks(&self.grain_ranges, hot, len, tiles, &|block, range, hot, tile| {
            if coupled[block] {
                correct_grains(&frames[block], tile, hot, &cold[range]);
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

fn packed<S: Space>(node: &[f64; NODE_WORDS], number: f64, vector: &S::Vector) -> [f64; COUPLED_WORDS] {
    let mut words = [0.0; COUPLED_WORDS];
    words[..NODE_WORDS].copy_from_slice(node);
    words[NODE_WORDS] = number;
    for axis in 0..S::DIMENSION {
        words[NODE_WORDS + 1 + axis] = vector[axis];
    }
    words
}

fn unpacked<S: Space>(words: &[f64; COUPLED_WORDS]) -> ([f64; NODE_WORDS], f64, S::Vector) {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = words[NODE_WORDS + 1 + axis];
    }
    (*words.first_chunk().expect("a node's row comes first"), words[NODE_WORDS], vector)
}
