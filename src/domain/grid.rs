//! The grid of a continuum: what it is like, what holds its nodes, and what they give to that in return.

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::bodies::body::{BODIES_MAX, Body};
use crate::bodies::boundary::{Grip, Hold, absorbed};
use crate::dem::cell::Cell;
use crate::dem::walls::place_beside;
use crate::domain::accounts::ledger::Entry;
use crate::domain::layout::Layout;
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::job::mpm::Boundary;
use crate::mpm::face_rows::{Met, is_met_by};
use crate::mpm::penalty::Penalty;
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};
use crate::mpm::tile::{Gathered, GrainNode, OwnedNode};

/// How the grid of a world works; chosen per job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Functions of the nodes.
    pub shape: ShapeFunction,
    /// When in a step stresses follow the strain.
    pub update: StressUpdate,
    /// From nodes to points.
    pub transfer: Transfer,
    /// Volume strain is averaged where material flows, see [`crate::mpm::volumetric`].
    pub averages_volume: bool,
    /// Lower and upper face of each axis.
    pub faces: [[Boundary; 2]; 3],
    /// Impedance of the material along a wave's way and across it, Pa s/m.
    pub impedance: [f64; 2],
    /// Out-of-plane depth, m; one in space.
    pub depth: f64,
    /// Gravity rises from zero over this time, s.
    pub gravity_ramp: f64,
    /// What holds single grains to nodes.
    pub penalty: Penalty,
}

impl Grid {
    /// The scheme of Chen et al. (2021, section 5), nothing held at the faces of the domain.
    pub fn blend(flip: f64) -> Self {
        Self {
            shape: ShapeFunction::Quadratic,
            update: StressUpdate::Last,
            transfer: Transfer::Blend { flip },
            averages_volume: true,
            faces: [[Boundary::Free; 2]; 3],
            impedance: [0.0; 2],
            depth: 1.0,
            gravity_ramp: 0.0,
            penalty: Penalty::NONE,
        }
    }
}

/// Impulses (N s) and angular impulses about the bodies' origins (N m s) that the material gave to faces and bodies through nodes, and grains to
/// bodies that hold nodes, since they were last taken, impulses of loads and membranes on the material, and the work of plates on it (J); of
/// bodies with servos what they have taken along these in the cycle under way or the last, less what they moved by, N s. This rank's share.
/// Exact, so that no order and no rank shows.
#[derive(Clone, Debug, Default)]
pub struct Reactions {
    sums: ExactSum<REACTIONS>,
}

const FACES: usize = 6;
const PER_BODY: usize = 6;
/// Slots of [`Reactions`].
pub const REACTIONS: usize = UNFORESEEN + BODIES_MAX;
/// The first of those of loads, of work, and of what servos did not foresee.
const LOADS: usize = 3 * FACES + PER_BODY * BODIES_MAX;
const WORK: usize = LOADS + 3;
const UNFORESEEN: usize = WORK + BODIES_MAX;

impl Reactions {
    pub(crate) fn merge(&mut self, other: &Self) {
        self.sums.merge(&other.sums);
    }

    pub(crate) fn merged(mut self, other: Self) -> Self {
        self.merge(&other);
        self
    }

    pub(crate) fn on_face<S: Space>(&mut self, axis: usize, upper: bool, impulse: &S::Vector) {
        for component in 0..S::DIMENSION {
            self.sums.add(3 * (2 * axis + usize::from(upper)) + component, impulse[component]);
        }
    }

    /// What a load gives to the material, N s.
    pub(crate) fn of_load<S: Space>(&mut self, impulse: &S::Vector) {
        for axis in 0..S::DIMENSION {
            self.sums.add(LOADS + axis, impulse[axis]);
        }
    }

    /// What a body takes, N s and N m s.
    pub(crate) fn on_body<S: Space>(&mut self, (number, body): (usize, &Body<S>), impulse: &S::Vector, turn: &S::Spin) {
        let first = 3 * FACES + PER_BODY * number;
        for component in 0..S::DIMENSION {
            self.sums.add(first + component, impulse[component]);
        }
        for component in 0..S::Spin::COMPONENTS {
            self.sums.add(first + 3 + component, turn[component]);
        }
        // Of other bodies the account of their step has it.
        if body.is_plate() {
            self.sums.add(WORK + number, -(impulse.dot(&body.velocity_mean) + turn.dot(&body.spin_mean)));
        }
        if let Some(servo) = &body.servo {
            self.sums.add(UNFORESEEN + number, impulse.dot(&servo.direction));
        }
    }

    /// What the servo of a body foresees for the cycle that begins, N s.
    pub(crate) fn foresee(&mut self, number: usize, impulse: f64) {
        self.sums.add(UNFORESEEN + number, -impulse);
    }

    /// Moves what the last cycle has left there of what servos did not foresee to a slot of other sums for each body, `together` apart.
    pub(crate) fn take_unforeseen<const N: usize>(
        &mut self,
        sums: &mut ExactSum<N>,
        (first, together): (usize, usize),
    ) {
        for number in 0..(N / together).min(BODIES_MAX) {
            sums.set_parts(first + together * number, self.sums.parts(UNFORESEEN + number));
            self.sums.set_parts(UNFORESEEN + number, (0, 0));
        }
    }
}

/// Impulse of faces, bodies, loads and membranes on the material, by those of [`World::take_reactions`], N s.
pub fn impulse_on_material(reactions: &[f64; REACTIONS]) -> [f64; 3] {
    let faces = reactions[..3 * FACES].chunks_exact(3);
    let bodies = reactions[3 * FACES..LOADS].chunks_exact(PER_BODY);
    let taken = |axis: usize| faces.clone().chain(bodies.clone()).map(|impulse| impulse[axis]).sum::<f64>();
    std::array::from_fn(|axis| reactions[LOADS + axis] - taken(axis))
}

/// Sizes of the same together, face by face, body by body and of all loads, N s.
pub fn impulse_sizes(reactions: &[f64; REACTIONS]) -> f64 {
    let size = |impulse: &[f64]| impulse[..3].iter().map(|part| part * part).sum::<f64>().sqrt();
    let (faces, rest) = reactions.split_at(3 * FACES);
    let (bodies, rest) = rest.split_at(PER_BODY * BODIES_MAX);
    faces.chunks_exact(3).chain(bodies.chunks_exact(PER_BODY)).map(size).sum::<f64>() + size(rest)
}

/// Work on the material of a body that is a plate among them, J.
pub fn plate_work(reactions: &[f64; REACTIONS], body: usize) -> f64 {
    reactions[WORK + body]
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

impl<S: Space> World<'_, S> {
    /// The same as they are stored, and left where they are; the same on every rank. Collective.
    pub fn reaction_entries(&self) -> Result<Vec<Entry>, Error> {
        if !self.has_grid() && !self.has_elements() && self.bodies.iter().all(|body| body.grip.is_none()) {
            return Ok(Vec::new());
        }
        Ok(Entry::all_of(&self.total(self.reactions.sums.clone())?).collect())
    }

    /// Goes on with impulses that were stored: one rank keeps what all have so far.
    pub fn resume_reactions(&mut self, entries: &[Entry]) -> Result<(), Error> {
        if entries.is_empty() {
            return Ok(());
        }
        // Runs of old had no account of work here, nor of what servos did not foresee.
        if entries.len() != WORK {
            Entry::expect(entries, REACTIONS, "reactions")?;
        }
        if self.transport.rank() == 0 {
            self.reactions.sums = Entry::take_all(&mut entries.iter().copied());
        }
        Ok(())
    }

    /// Books the impulse of loads and membranes over the step under way.
    pub(crate) fn book_loads(&mut self) {
        let dt = self.dt_of_continuum();
        // All ranks have all membranes.
        let of_membranes = if self.transport.rank() == 0 { &self.continuum.membranes.brought[..] } else { &[] };
        let of_membranes = of_membranes.iter().map(|brought| &brought.force);
        let on_surface = self.continuum.tiles.surface.forces.iter().filter(|force| **force != S::Vector::zero());
        for push in self.continuum.points.loaded.iter().map(|(_, push)| push).chain(of_membranes).chain(on_surface) {
            self.reactions.of_load::<S>(&(*push * dt));
        }
    }

    /// Whether all that a plate takes is booked where it is held, as of a body with a grip: nodes that it moves may do so in the middle of a
    /// cycle, and grains glued to it push in every step of theirs.
    pub(crate) fn books_plates(&self) -> bool {
        self.has_grid() && self.bodies.iter().any(Body::is_plate)
    }

    /// Books what grains give to bodies that hold nodes as well, so that one account has all that such a body takes.
    pub(crate) fn book_grains(&mut self) {
        let plates = self.books_plates();
        if !plates && (self.assembly.walls.list.is_empty() || self.bodies.iter().all(|body| body.grip.is_none())) {
            return;
        }
        let (timer, dt) = (self.phases.start(), self.kick_share() * self.settings.grains.dt);
        let Self { assembly, bodies, reactions, .. } = self;
        assembly.pushes_on(bodies, |number, force, torque| {
            let (body, impulse, turn) = (&bodies[number], force * dt, torque * dt);
            if body.grip.is_some() || (plates && body.is_plate()) {
                reactions.on_body((number, body), &impulse, &turn);
            }
        });
        self.phases.stop(Phase::Bodies, timer);
    }

    /// Impulses that have not been taken yet, and that stay so; as those of [`World::take_reactions`]. Collective.
    pub fn reactions_so_far(&self) -> Result<[f64; REACTIONS], Error> {
        self.reduce(self.reactions.sums.clone())
    }

    /// Impulses on faces and bodies through nodes since they were last taken, of all ranks: per face (lower and upper of
    /// each axis) three components, then per body three of impulse and three of angular impulse; three of loads on the material, and the work
    /// of plates per body, which goes to their own account. Collective.
    pub fn take_reactions(&mut self) -> Result<[f64; REACTIONS], Error> {
        let mut sums = std::mem::take(&mut self.reactions).sums;
        // A cycle to come asks for it, not the row that takes the rest.
        for slot in UNFORESEEN..REACTIONS {
            self.reactions.sums.set_parts(slot, sums.parts(slot));
            sums.set_parts(slot, (0, 0));
        }
        let reactions = self.reduce(sums)?;
        self.bodies.iter_mut().zip(&reactions[WORK..UNFORESEEN]).for_each(|(body, work)| body.work += work);
        Ok(reactions)
    }
}

/// What a phase does with the velocities of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moment {
    /// Forces act.
    Step,
    /// The velocities that points brought, held where they are held once forces act: were parting told by these velocities
    /// alone, a node under load that swings by a little would part and be held in turn, and take energy from nowhere.
    Look,
}

/// Everything that pushes and holds nodes beside their own forces.
pub(crate) struct BoundaryConditions<'a, S: Space> {
    pub grid: &'a Grid,
    pub layout: &'a Layout,
    pub bodies: &'a [Body<S>],
    pub periods: &'a Cell<S>,
    pub gravity: S::Vector,
    pub moment: Moment,
}

impl<S: Space> BoundaryConditions<'_, S> {
    /// What becomes of the velocity `free` of a node that points and grains have made, over a time `dt`; bodies that meet points at their
    /// own face have acted on it already.
    pub fn on(
        &self,
        free: S::Vector,
        (node, met): (&OwnedNode, Option<&Met<S>>),
        (points, grains): (&Gathered<S>, &GrainNode<S>),
        dt: f64,
        reactions: &mut Reactions,
    ) -> S::Vector {
        let place: S::Vector = self.layout.node_at(node.place);
        let mut booked = if self.moment == Moment::Look { None } else { Some(reactions) };
        let mass = points.mass() + grains.mass();
        if let Some(number) = self.bodies.iter().position(|body| body.holds(place[1], self.layout.cell)) {
            let plate = &self.bodies[number];
            if let Some(reactions) = booked {
                let impulse = (free - plate.velocity) * mass;
                reactions.on_body((number, plate), &impulse, &S::moment(&(place - plate.origin()), &impulse));
            }
            return plate.velocity;
        }
        let unheld = self.unheld(free, node, (points, grains), dt, booked.as_deref_mut());
        let unheld = met.map_or(unheld, |met| met.velocities);
        let of = (self.bodies, self.periods, met.map_or([false; 2], |met| met.by));
        let held = held_by_bodies(unheld, of, &place, mass, booked.as_deref_mut());
        held_by_faces::<S>(held, self.grid, self.layout, node, mass, booked)
    }

    /// Its velocity before anything holds it, and that which forces would give it ([`Hold::on`]): dashpots have acted.
    pub fn unheld(
        &self,
        free: S::Vector,
        node: &OwnedNode,
        (points, grains): (&Gathered<S>, &GrainNode<S>),
        dt: f64,
        booked: Option<&mut Reactions>,
    ) -> [S::Vector; 2] {
        let looks = self.moment == Moment::Look;
        let mass = points.mass() + grains.mass();
        let forces = if looks { points.force() * (dt / mass) + self.gravity * dt } else { S::Vector::zero() };
        let (brought, at) = (points.momentum() + grains.momentum(), (self.grid, self.layout));
        let pushed = absorbed_by_faces::<S>(free + forces, &brought, at, node, (mass, dt), booked);
        [if looks { free } else { pushed }, pushed]
    }
}

/// Velocity of a node, and that which forces would give it ([`Hold::on`]), after every body that it or an image of it lies in
/// has held it, in their order, but for those that have met its material at their own face; `mass` is the node's.
pub(crate) fn held_by_bodies<S: Space>(
    [mut velocity, mut pushed]: [S::Vector; 2],
    (bodies, periods, met_by): (&[Body<S>], &Cell<S>, [bool; 2]),
    place: &S::Vector,
    mass: f64,
    mut reactions: Option<&mut Reactions>,
) -> [S::Vector; 2] {
    for (number, body) in bodies.iter().enumerate() {
        let Some((grip, separates)) = body.grip.filter(|_| !is_met_by(met_by, body)) else { continue };
        let place = place_beside(body, periods, place);
        let Some(nearest) = body.nearest(&place).filter(|nearest| nearest.distance <= 0.0) else { continue };
        let hold: Hold<S> = Hold { grip, separates, normal: nearest.normal, velocity: body.velocity_at(&place) };
        let after = hold.on(&velocity, &pushed);
        if let Some(reactions) = &mut reactions {
            let impulse = (velocity - after) * mass;
            let arm = place - body.origin();
            reactions.on_body((number, body), &impulse, &S::moment(&arm, &impulse));
        }
        pushed = hold.on(&pushed, &pushed);
        velocity = after;
    }
    [velocity, pushed]
}

/// Velocity of a node after the dashpots of every face that absorbs and at or behind which it lies: forces like others, before
/// anything holds it. `momentum` is its own before forces.
pub(crate) fn absorbed_by_faces<S: Space>(
    mut velocity: S::Vector,
    momentum: &S::Vector,
    (grid, layout): (&Grid, &Layout),
    node: &OwnedNode,
    (mass, dt): (f64, f64),
    mut reactions: Option<&mut Reactions>,
) -> S::Vector {
    let absorbs = |axis: usize, upper: bool| {
        grid.faces[axis][usize::from(upper)] == Boundary::Absorbing && layout.is_behind(node.place, axis, upper)
    };
    let faces =
        || (0..S::DIMENSION).flat_map(|axis| [(axis, false), (axis, true)]).filter(|face| absorbs(face.0, face.1));
    if faces().next().is_none() {
        return velocity;
    }
    let dashpot = |axis: usize, component: usize| {
        grid.impedance[usize::from(component != axis)] * layout.node_area(node.place, axis) * grid.depth
    };
    // Of all faces together, for at an edge none comes first.
    let dashpots: [f64; 3] = std::array::from_fn(|component| faces().map(|(axis, _)| dashpot(axis, component)).sum());
    let before = *momentum * (1.0 / mass);
    for (axis, upper) in faces() {
        let mut impulse = before;
        for component in 0..S::DIMENSION {
            impulse[component] *= absorbed([dashpot(axis, component), dashpots[component]], mass, dt);
        }
        if let Some(reactions) = &mut reactions {
            reactions.on_face::<S>(axis, upper, &impulse);
        }
        velocity -= impulse * (1.0 / mass);
    }
    velocity
}

/// Velocity of a node after every face of the domain at or behind which it lies has held it, axis by axis; dashpots have acted
/// already.
pub(crate) fn held_by_faces<S: Space>(
    [mut velocity, mut pushed]: [S::Vector; 2],
    grid: &Grid,
    layout: &Layout,
    node: &OwnedNode,
    mass: f64,
    mut reactions: Option<&mut Reactions>,
) -> S::Vector {
    for axis in 0..S::DIMENSION {
        for upper in [false, true] {
            let boundary = grid.faces[axis][usize::from(upper)];
            if matches!(boundary, Boundary::Periodic | Boundary::Free | Boundary::Absorbing)
                || !layout.is_behind(node.place, axis, upper)
            {
                continue;
            }
            let mut normal = S::Vector::zero();
            normal[axis] = if upper { -1.0 } else { 1.0 };
            let hold = |grip: Grip, separates: bool| -> Hold<S> {
                Hold { grip, separates, normal, velocity: S::Vector::zero() }
            };
            let after = match boundary {
                Boundary::Periodic | Boundary::Free | Boundary::Absorbing => velocity,
                Boundary::Fixed => S::Vector::zero(),
                Boundary::Roller => hold(Grip::Smooth, false).on(&velocity, &pushed),
                Boundary::Friction { coefficient } => {
                    let hold = hold(Grip::Coulomb(coefficient), true);
                    let after = hold.on(&velocity, &pushed);
                    pushed = hold.on(&pushed, &pushed);
                    after
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
