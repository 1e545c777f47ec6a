//! The continuum's part of a step: points to the grid, the grid's own step with what holds it, and back to points.

use rayon::prelude::*;
use scree_partition::ExactSum;

use crate::body::{BODIES_MAX, Body};
use crate::dem::cell::Cell;
use crate::dem::walls::place_beside;
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::layout::Layout;
use crate::mpm::boundary::{Grip, Hold, absorb};
use crate::mpm::gather::{Taken, Taking, correct_grains, gather_points};
use crate::mpm::nodes;
use crate::mpm::points::Points;
use crate::mpm::scatter::{scatter_grains, scatter_loads, scatter_points};
use crate::mpm::tile::{Advanced, Gathered, GrainNode, NODE_WORDS, OwnedNode, Tiles};
use crate::observe::ledger::Entry;
use crate::observe::phases::Phase;
use crate::parallel::{over_blocks, over_rows};
use crate::scenario::mpm::{Boundary, ShapeFunction, StressUpdate, Transfer};
use crate::space::{Linear, Space};
use crate::world::World;

/// How the grid of a world works; chosen per job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub shape: ShapeFunction,
    pub update: StressUpdate,
    pub transfer: Transfer,
    /// Lower and upper face of each axis.
    pub faces: [[Boundary; 2]; 3],
    /// Impedance of the material along a wave's way and across it, Pa s/m.
    pub impedance: [f64; 2],
    /// Out-of-plane depth, m; one in space.
    pub depth: f64,
    /// Gravity rises from zero over this time, s.
    pub gravity_ramp: f64,
}

impl Grid {
    /// The scheme of Chen et al. (2021, section 5), nothing held at the faces of the domain.
    pub fn blend(flip: f64) -> Self {
        Self {
            shape: ShapeFunction::Quadratic,
            update: StressUpdate::Last,
            transfer: Transfer::Blend { flip },
            faces: [[Boundary::Free; 2]; 3],
            impedance: [0.0; 2],
            depth: 1.0,
            gravity_ramp: 0.0,
        }
    }
}

/// Impulses (N s) and angular impulses about the bodies' origins (N m s) that the material gave to faces and bodies through
/// nodes since they were last taken; this rank's share. Exact, so that no order and no rank shows.
#[derive(Clone, Debug, Default)]
pub struct Reactions {
    sums: ExactSum<REACTIONS>,
}

const FACES: usize = 6;
const PER_BODY: usize = 6;
/// Slots of [`Reactions`].
pub const REACTIONS: usize = 3 * FACES + PER_BODY * BODIES_MAX;

impl Reactions {
    fn merged(mut self, other: Self) -> Self {
        self.sums.merge(&other.sums);
        self
    }

    fn on_face<S: Space>(&mut self, axis: usize, upper: bool, impulse: &S::Vector) {
        for component in 0..S::DIMENSION {
            self.sums.add(3 * (2 * axis + usize::from(upper)) + component, impulse[component]);
        }
    }

    fn on_body<S: Space>(&mut self, body: usize, impulse: &S::Vector, turn: &S::Spin) {
        let first = 3 * FACES + PER_BODY * body;
        for component in 0..S::DIMENSION {
            self.sums.add(first + component, impulse[component]);
        }
        for component in 0..S::Spin::COMPONENTS {
            self.sums.add(first + 3 + component, turn[component]);
        }
    }
}

/// Impulse on a face among those of [`World::take_reactions`], N s.
pub fn face_impulse(reactions: &[f64; REACTIONS], axis: usize, upper: bool) -> [f64; 3] {
    std::array::from_fn(|component| reactions[3 * (2 * axis + usize::from(upper)) + component])
}

/// Impulse (N s) and angular impulse (N m s) on a body among them.
pub fn body_impulse(reactions: &[f64; REACTIONS], body: usize) -> ([f64; 3], [f64; 3]) {
    let first = 3 * FACES + PER_BODY * body;
    let three = |first: usize| std::array::from_fn(|component| reactions[first + component]);
    (three(first), three(first + 3))
}

/// What a phase does with the velocities of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    /// Forces act.
    Step,
    /// The velocities that points brought, held where they are held once forces act: were parting told by these velocities
    /// alone, a node under load that swings by a little would part and be held in turn, and take energy from nowhere.
    Look,
}

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

    /// After the grid's step: motion of points, and their strain where it has not been taken yet.
    pub(crate) fn take_from_grid(&mut self) {
        if !self.has_points() {
            return;
        }
        match self.settings.grid.update {
            StressUpdate::First => self.gather_points(Taken::Motion),
            StressUpdate::Last => self.gather_points(Taken::All),
            StressUpdate::ModifiedLast => {
                self.gather_points(Taken::Velocity);
                self.strain_by_points(Taken::StrainThenPlace);
            }
        }
    }

    /// Strain of the grid with the velocities of points as they are.
    fn strain_by_points(&mut self, taken: Taken) {
        self.push_loaded();
        self.scatter_points();
        self.sum_tiles();
        self.advance_nodes(Moment::Look);
        self.spread_tiles();
        self.gather_points(taken);
    }

    pub(crate) fn scatter_all(&mut self) {
        if self.has_points() {
            self.push_loaded();
            self.scatter_points();
        }
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

    fn scatter_points(&mut self) {
        let timer = self.phases.start();
        let len = self.nodes.mosaic.nodes_per_tile;
        let rows = self.nodes.mosaic.rows();
        let grid = &self.settings.grid;
        let how = (grid.shape, grid.transfer == Transfer::Affine, self.contacts.instructions());
        let (frames, tiles) = (&self.frames, &mut self.tiles.gathered[..rows]);
        let Points { hot, beside, loaded, .. } = &mut self.points;
        over_blocks(&self.point_ranges, hot, len, tiles, &|block, range, points, tile| {
            tile.fill(Gathered::zero());
            scatter_points(&frames[block], how, (points, &beside[range.clone()]), tile);
            let of = |end: usize| loaded.partition_point(|(row, _)| (*row as usize) < end);
            let loaded = &loaded[of(range.start)..of(range.end)];
            scatter_loads(&frames[block], how.0, (points, range.start), loaded, tile);
        });
        self.phases.stop(Phase::Scatter, timer);
    }

    pub(crate) fn scatter_grains(&mut self) {
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
        self.phases.stop(Phase::Scatter, timer);
    }

    pub(crate) fn sum_tiles(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let halo = &self.nodes.gathered;
        let gathered = &mut self.tiles.gathered;
        halo.pack::<NODE_WORDS>(&mut self.buffers, |row| gathered[row as usize].0);
        halo.exchange::<NODE_WORDS>(self.transport, &mut self.buffers, &mut || {});
        halo.unpack::<NODE_WORDS>(&self.buffers, |row, words| gathered[row as usize] = Gathered::of(words));
        if self.is_coupled() {
            let grains = &mut self.tiles.grains;
            halo.pack::<GRAIN_WORDS>(&mut self.buffers, |row| {
                packed::<S>(grains[row as usize].mass, &grains[row as usize].momentum)
            });
            halo.exchange::<GRAIN_WORDS>(self.transport, &mut self.buffers, &mut || {});
            halo.unpack::<GRAIN_WORDS>(&self.buffers, |row, words| {
                let (mass, momentum) = unpacked::<S>(&words);
                grains[row as usize] = GrainNode { mass, momentum };
            });
        }
        self.tiles.sum(&self.nodes.mosaic);
        self.phases.stop(Phase::Halo, timer);
    }

    /// The equation of motion of nodes.
    pub(crate) fn step_nodes(&mut self) {
        if self.has_points() {
            self.advance_nodes(Moment::Step);
        }
    }

    fn advance_nodes(&mut self, moment: Moment) {
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
        // The nodes of a block have their rows in its own tile.
        let tiles = mosaic.owned.par_chunks(per_tile).zip(advanced[..rows].par_chunks_mut(len)).enumerate();
        let booked = tiles.fold(Reactions::default, |mut booked, (tile, (owned, advanced))| {
            for (node, number) in owned.iter().zip(tile * per_tile..) {
                advanced[node.row as usize - tile * len] = advance(node, number, &mut booked);
            }
            booked
        });
        reactions.sums.merge(&booked.reduce(Reactions::default, Reactions::merged).sums);
        if coupled {
            let tiles = mosaic.owned.par_chunks(per_tile).zip(grain_changes[..rows].par_chunks_mut(len)).enumerate();
            tiles.for_each(|(tile, (owned, changes))| {
                for (node, number) in owned.iter().zip(tile * per_tile..) {
                    let row = node.row as usize;
                    changes[row - tile * len] = nodes::correction(&sums[number], &grain_sums[number], &advanced[row]);
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

    pub(crate) fn spread_tiles(&mut self) {
        if !self.has_points() {
            return;
        }
        let timer = self.phases.start();
        let halo = &self.nodes.advanced;
        let advanced = &mut self.tiles.advanced;
        halo.pack::<NODE_WORDS>(&mut self.buffers, |row| advanced[row as usize].0);
        halo.exchange::<NODE_WORDS>(self.transport, &mut self.buffers, &mut || {});
        halo.unpack::<NODE_WORDS>(&self.buffers, |row, words| advanced[row as usize] = Advanced::of(words));
        if self.is_coupled() {
            let changes = &mut self.tiles.grain_changes;
            halo.pack::<GRAIN_WORDS>(&mut self.buffers, |row| packed::<S>(0.0, &changes[row as usize]));
            halo.exchange::<GRAIN_WORDS>(self.transport, &mut self.buffers, &mut || {});
            halo.unpack::<GRAIN_WORDS>(&self.buffers, |row, words| changes[row as usize] = unpacked::<S>(&words).1);
        }
        self.tiles.copy_margins(&self.nodes.mosaic);
        self.phases.stop(Phase::Halo, timer);
    }

    pub(crate) fn correct_grains(&mut self) {
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
        self.phases.stop(Phase::Gather, timer);
    }

    fn gather_points(&mut self, taken: Taken) {
        let timer = self.phases.start();
        let (len, settings) = (self.nodes.mosaic.nodes_per_tile, &self.settings);
        let Grid { shape, transfer, .. } = settings.grid;
        let taking = Taking { shape, transfer, taken, dt: settings.dt, instructions: self.contacts.instructions() };
        let (frames, tiles) = (&self.frames, &self.tiles.advanced);
        // Affine fields, and ways where places wait for the strain.
        let waits = matches!(taken, Taken::Velocity | Taken::StrainThenPlace);
        let Points { hot, beside, .. } = &mut self.points;
        let beside = if waits || transfer == Transfer::Affine { &mut beside[..] } else { &mut [] };
        let outside = over_rows(&self.point_ranges, hot, beside, &|block, points, beside| {
            gather_points(
                &frames[block],
                &settings.material,
                taking,
                &tiles[block * len..(block + 1) * len],
                points,
                beside,
            )
        });
        if taken != Taken::Velocity && taken != Taken::Strain {
            self.points_outside = outside;
        }
        self.phases.stop(Phase::Gather, timer);
    }

    /// The same as they are stored, and left where they are; the same on every rank. Collective.
    pub fn reaction_entries(&self) -> Result<Vec<Entry>, Error> {
        if !self.has_points() {
            return Ok(Vec::new());
        }
        Ok(Entry::all_of(&self.total(self.reactions.sums.clone())?).collect())
    }

    /// Goes on with impulses that were stored: one rank keeps what all have so far.
    pub fn resume_reactions(&mut self, entries: &[Entry]) -> Result<(), Error> {
        if entries.is_empty() {
            return Ok(());
        }
        Entry::expect(entries, REACTIONS, "reactions")?;
        if self.transport.rank() == 0 {
            self.reactions.sums = Entry::take_all(&mut entries.iter().copied());
        }
        Ok(())
    }

    /// Impulses on faces and bodies through nodes since they were last taken, of all ranks: per face (lower and upper of
    /// each axis) three components, then per body three of impulse and three of angular impulse. Collective.
    pub fn take_reactions(&mut self) -> Result<[f64; REACTIONS], Error> {
        let sums = std::mem::take(&mut self.reactions).sums;
        self.reduce(sums)
    }
}

/// Numbers of a grain's node in a message.
const GRAIN_WORDS: usize = 4;

fn packed<S: Space>(number: f64, vector: &S::Vector) -> [f64; GRAIN_WORDS] {
    std::array::from_fn(|word| match word {
        0 => number,
        word if word <= S::DIMENSION => vector[word - 1],
        _ => 0.0,
    })
}

fn unpacked<S: Space>(words: &[f64; GRAIN_WORDS]) -> (f64, S::Vector) {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = words[1 + axis];
    }
    (words[0], vector)
}

/// Velocity of a node, and that which forces would give it ([`Hold::on`]), after every body that it or an image of it lies in
/// has held it, in their order; `mass` is the node's.
pub(crate) fn held_by_bodies<S: Space>(
    [mut velocity, mut pushed]: [S::Vector; 2],
    (bodies, periods): (&[Body<S>], &Cell<S>),
    place: &S::Vector,
    mass: f64,
    mut reactions: Option<&mut Reactions>,
) -> [S::Vector; 2] {
    for (number, body) in bodies.iter().enumerate() {
        let Some((grip, separates)) = body.grip else { continue };
        let place = place_beside(body, periods, place);
        let Some(nearest) = body.nearest(&place).filter(|nearest| nearest.distance <= 0.0) else { continue };
        let hold: Hold<S> = Hold { grip, separates, normal: nearest.normal, velocity: body.velocity_at(&place) };
        let after = hold.on(&velocity, &pushed);
        if let Some(reactions) = &mut reactions {
            let impulse = (velocity - after) * mass;
            let arm = place - body.origin();
            reactions.on_body::<S>(number, &impulse, &S::moment(&arm, &impulse));
        }
        pushed = hold.on(&pushed, &pushed);
        velocity = after;
    }
    [velocity, pushed]
}

/// Velocity of a node after every face of the domain at or behind which it lies has held it, axis by axis.
pub(crate) fn held_by_faces<S: Space>(
    [mut velocity, mut pushed]: [S::Vector; 2],
    grid: &Grid,
    layout: &Layout,
    node: &OwnedNode,
    (mass, dt): (f64, f64),
    mut reactions: Option<&mut Reactions>,
) -> S::Vector {
    for axis in 0..S::DIMENSION {
        for upper in [false, true] {
            let boundary = grid.faces[axis][usize::from(upper)];
            if matches!(boundary, Boundary::Periodic | Boundary::Free) || !layout.is_behind(node.place, axis, upper) {
                continue;
            }
            let mut normal = S::Vector::zero();
            normal[axis] = if upper { -1.0 } else { 1.0 };
            let hold = |grip: Grip, separates: bool| -> Hold<S> {
                Hold { grip, separates, normal, velocity: S::Vector::zero() }
            };
            let after = match boundary {
                Boundary::Periodic | Boundary::Free => velocity,
                Boundary::Fixed => S::Vector::zero(),
                Boundary::Roller => hold(Grip::Smooth, false).on(&velocity, &pushed),
                Boundary::Friction { coefficient } => {
                    let hold = hold(Grip::Coulomb(coefficient), true);
                    let after = hold.on(&velocity, &pushed);
                    pushed = hold.on(&pushed, &pushed);
                    after
                }
                Boundary::Absorbing => {
                    let area = layout.node_area(node.place, axis) * grid.depth;
                    absorb::<S>(&velocity, axis, grid.impedance.map(|impedance| impedance * area), mass, dt)
                }
            };
            if let Some(reactions) = &mut reactions {
                reactions.on_face::<S>(axis, upper, &((velocity - after) * mass));
            }
            velocity = after;
        }
    }
    velocity
}
