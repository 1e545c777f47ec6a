//! Grains in a cell: what they are, what they touch, and how far they have come since their lists were made. Its methods are the
//! parts of a step; what lies between them is up to whoever holds it: copies of other ranks' grains that are renewed, nodes that
//! are shared with a continuum, or nothing ([`crate::dem::sample`]).

use std::ops::Range;

use crate::base::exact::ExactSum;
use crate::base::parallel::larger;
use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::dem::cell::{Cell, Image};
use crate::dem::contacts::Contacts;
use crate::dem::drive::{CellDrive, Missed};
use crate::dem::grains::{GrainRow, Grains, Mover};
use crate::dem::law::{Law, SharedLaw};
use crate::dem::memories::Carried;
use crate::dem::motion::{self, Field};
use crate::dem::segments::{Finish, Passed, Segments, finish_waiting};
use crate::dem::strained::{STRAINED, Strained};
use crate::dem::walls::Walls;

/// Share of its velocity that a grain which is pushed beside its contacts loses in a step: one that is thrown stops within a part of its
/// size.
pub(crate) const PUSHED_DRAG: f64 = 0.1;

/// Constants of grains that no step changes.
#[derive(Clone, Debug)]
pub struct Constants<S: Space> {
    /// Time step, s.
    pub dt: f64,
    /// Reach of the neighbour list beyond contact, m.
    pub skin: f64,
    /// The law of contacts of grains with each other.
    pub law: SharedLaw<S>,
    /// Forces on grains beside those of contacts.
    pub field: Field<S>,
    /// What deforms the cell.
    pub drive: CellDrive<S>,
    /// Share of the step by which the very first kick of a run moves velocities: a half where those of the start are of
    /// time zero, all of it where they are half a step behind already.
    pub first_kick: f64,
    /// Time over which contacts advance until the very first evaluation of a run, s: none where they remember nothing yet.
    pub first_advance: f64,
}

impl<S: Space> Constants<S> {
    /// Of grains that nothing but contacts moves, in a cell that rests, from velocities of time zero.
    pub fn new(dt: f64, skin: f64, law: SharedLaw<S>) -> Self {
        let (field, drive) = (Field::default(), CellDrive::default());
        Self { dt, skin, law, field, drive, first_kick: 0.5, first_advance: 0.0 }
    }

    /// The law of contacts of grains with each other.
    pub fn law(&self) -> &dyn Law<S> {
        &*self.law
    }

    /// How far apart surfaces may be and still be listed, m.
    pub fn margin(&self) -> f64 {
        self.skin + self.law().reach()
    }

    /// Time over which contacts advance until the evaluation of a step, and that over which they turn.
    pub fn contact_times(&self, step: u64) -> [f64; 2] {
        [if step == 0 { self.first_advance } else { self.dt }; 2]
    }

    /// Share of the step by which its kick moves velocities.
    pub fn kick_share(&self, step: u64) -> f64 {
        if step == 0 { self.first_kick } else { 1.0 }
    }
}

/// An assembly of grains with the contacts between them.
#[derive(Clone, Debug)]
pub struct Assembly<S: Space> {
    /// As it is now, the same on every rank.
    pub cell: Cell<S>,
    /// The cell at the last rebuild of the lists.
    pub(crate) cell_home: Cell<S>,
    /// Rows of this rank, copies of other ranks' grains behind its own.
    pub grains: Grains<S>,
    /// Contacts of grains with each other.
    pub contacts: Contacts<S>,
    /// Contacts of grains with bodies.
    pub walls: Walls<S>,
    /// Largest radius of any grain, m; in a world that of all ranks.
    pub radius_max: f64,
    /// The longest way that a grain has come from home, m.
    pub(crate) moved: f64,
    /// Whether forces of contacts will be asked for after the coming step.
    pub forces_wanted: bool,
    /// How a control of stress has followed since the last row of a series.
    pub missed: Missed,
}

impl<S: Space> Assembly<S> {
    /// A cell without grains.
    pub fn empty(cell: Cell<S>) -> Self {
        Self {
            cell,
            cell_home: cell,
            grains: Grains::default(),
            contacts: Contacts::new(&cell),
            walls: Walls::default(),
            radius_max: 0.0,
            moved: 0.0,
            forces_wanted: false,
            missed: Missed::default(),
        }
    }

    /// Gives up what only a rebuild reads, where all grains are free and stand in the order of their ids, from none on, as their pairs
    /// do; [`Self::restore_cold`] tells it again.
    pub fn drop_cold(&mut self) {
        self.grains.drop_cold();
        self.contacts.neighbours.drop_terms();
    }

    /// The reverse.
    pub fn restore_cold(&mut self) {
        self.grains.restore_cold();
        self.contacts.neighbours.restore_terms(&self.grains);
    }

    /// An owned row with the memories of its contacts.
    pub fn whole_row(&self, row: usize) -> GrainRow<S> {
        let Grains { hot, cold, springs, .. } = &self.grains;
        GrainRow { hot: hot[row], cold: cold[row], spring: springs[row], contacts: self.carried_by(row).collect() }
    }

    /// Memories of a row's contacts with grains, then with bodies.
    pub(crate) fn carried_by(&self, row: usize) -> impl Iterator<Item = Carried> {
        self.contacts.carried_by(&self.grains, row).chain(self.walls.carried_by(row))
    }

    /// Whether the forces of single contacts are looked at after the coming step.
    pub(crate) fn keeps_forces(&self, of: &Constants<S>) -> bool {
        self.forces_wanted || of.drive.servo.is_some()
    }

    /// Pairs, and what follows for the grains of segments that need no copies of other ranks' grains, or of the others; `finish` is
    /// done for every grain that other grains alone push.
    pub(crate) fn evaluate_pairs(
        &mut self,
        of: &Constants<S>,
        step: u64,
        which: Segments,
        finish: &impl Finish<S>,
    ) -> Passed {
        debug_assert!(!self.contacts.neighbours.in_order, "a list in order has a pass of its own");
        let (law, times) = (of.law(), of.contact_times(step));
        self.contacts.pair_pass(law, &self.grains, which, times);
        self.contacts.segment_pass(law, &mut self.grains, which, times, finish)
    }

    /// Contacts with bodies and what pushes single grains, and `finish` for those that had to wait for it. Returns the largest that it
    /// returned.
    pub(crate) fn evaluate_rest(
        &mut self,
        of: &Constants<S>,
        step: u64,
        bodies: &[Body<S>],
        finish: &impl Finish<S>,
    ) -> f64 {
        self.walls.evaluate(of.law(), &mut self.grains, (bodies, &self.cell), of.contact_times(step));
        let Grains { pushed, force, hot, .. } = &mut self.grains;
        // What nothing leans on any more would be pushed away for good; it stops instead.
        for (row, push) in pushed.iter().map(|(row, push)| (*row as usize, *push)) {
            if force[row] != S::Vector::zero() {
                force[row] += push;
            }
            force[row] -= hot[row].velocity * (PUSHED_DRAG * hot[row].weight * hot[row].mass / of.dt);
        }
        finish_waiting(&mut self.grains, finish)
    }

    /// The cell's velocity gradient over the coming drift, with the sums over its contacts where the step looks at them; grains follow
    /// a change of it.
    pub(crate) fn drive(&mut self, of: &Constants<S>, sums: Option<&Strained<S>>) {
        let gradient = of.drive.gradient_of(&mut self.cell, sums, of.dt, &mut self.missed);
        let change = gradient - self.cell.gradient;
        if change != S::Tensor::zero() {
            motion::follow_gradient(&mut self.grains, &self.cell, &change);
        }
        self.cell.gradient = gradient;
    }

    /// The drift of all grains, and of the cell.
    pub(crate) fn drift(&mut self, of: &Constants<S>, bodies: &[Body<S>]) {
        self.moved = motion::drift(&mut self.grains, bodies, of.dt).sqrt();
        if !of.drive.is_at_rest() {
            self.cell.deform(self.cell.gradient, of.dt);
        }
    }

    /// The drift of grains that have not drifted with their kicks, of which `farthest` is the square of the longest way, m2.
    pub(crate) fn drift_glued(&mut self, farthest: f64, bodies: &[Body<S>], dt: f64) {
        self.moved = larger(farthest, motion::follow_and_drift(&mut self.grains, bodies, dt)).sqrt();
    }

    /// Calls `push(body, force, torque)` (N, N m about the body's origin) with what each grain of this rank does to the body that it is glued to
    /// or touches.
    pub(crate) fn pushes_on(&self, bodies: &[Body<S>], mut push: impl FnMut(usize, S::Vector, S::Spin)) {
        for row in self.grains.glued.iter().map(|row| *row as usize) {
            let (force, torque) = (self.grains.force[row], self.grains.torque[row]);
            // Most of a plate's grains lie behind those that others touch.
            if force == S::Vector::zero() && torque == S::Spin::zero() {
                continue;
            }
            if let Mover::Body(body) = self.grains.movers[row] {
                let arm = self.grains.hot[row].position - bodies[body as usize].origin();
                push(body as usize, force, torque + S::moment(&arm, &force));
            }
        }
        self.walls.reactions_of(bodies, push);
    }

    /// How much nearer two that may touch have come since lists were made, as a share of what these reach; `bodies` is the longest
    /// way of a body, m, where there are bodies to touch.
    pub(crate) fn closed(&self, of: &Constants<S>, bodies: Option<f64>) -> f64 {
        let (mut moved, mut stretch) = (self.moved, 0.0);
        if !of.drive.is_at_rest() && bodies.is_none() {
            // Against the mean field, which itself brings a pair nearer by its stretch.
            let field = self.cell_home.deformation_to(&self.cell);
            stretch = (field - S::identity()).norm();
            let corner = self.cell.corner;
            let mut square = 0.0;
            for (hot, cold) in self.grains.hot[..self.grains.owned].iter().zip(&self.grains.cold) {
                let moved = hot.position - corner - field * (cold.home - corner);
                square = larger(square, moved.dot(&moved));
            }
            moved = square.sqrt();
        }
        moved = larger(moved, bodies.unwrap_or(0.0));
        // Two grains may close half the skin each.
        (2.0 * moved + stretch * (2.0 * self.radius_max + of.skin)) / of.skin
    }

    /// Sends grains home: their position of now, wrapped into the cell.
    pub(crate) fn go_home(&mut self) {
        for (i, j, times) in self.cell.shorten() {
            for cold in &mut self.grains.cold[..self.grains.owned] {
                cold.image[i] += times * cold.image[j];
            }
        }
        for (hot, cold) in self.grains.hot[..self.grains.owned].iter_mut().zip(&mut self.grains.cold) {
            add_image(&mut cold.image, self.cell.wrap(&mut hot.position, &mut hot.velocity));
            cold.home = hot.position;
        }
    }

    /// Makes the lists of grains that stand where they are to stand; `carried` has what the contacts of each owned row remember.
    pub(crate) fn list<I: Iterator<Item = Carried>>(
        &mut self,
        of: &Constants<S>,
        bodies: &[Body<S>],
        carried: impl Fn(usize) -> I,
    ) {
        let (law, margin) = (of.law(), of.margin());
        let Self { grains, contacts, walls, cell_home, .. } = self;
        contacts.rebuild(law, grains, cell_home, &carried, margin);
        walls.rebuild(law, grains, (bodies, cell_home), &carried, margin);
        grains.come_near_bodies(walls.list.iter().map(|wall| wall.row));
    }

    /// What a control of stress needs of the contacts of owned rows, at the evaluation just done. Rows that stand together are summed
    /// in their order, and these sums exactly.
    pub(crate) fn strained(&self, of: &Constants<S>, together: &[Range<usize>]) -> ExactSum<STRAINED> {
        let (law, grains, cell) = (of.law(), &self.grains, &self.cell);
        let mut sums = ExactSum::new();
        for range in together {
            let mut block = Strained::<S>::zero();
            for row in range.clone() {
                let part = self.contacts.strained(law, grains, cell, row);
                block.moment += part.moment;
                block.springs += part.springs;
                block.dashpots += part.dashpots;
            }
            block.add_to(&mut sums);
        }
        self.walls.strained(law, grains, cell).for_each(|part| part.add_to(&mut sums));
        sums
    }

    /// Love-Weber sum over the contacts of owned rows, J: minus force times branch at the positions and velocities of now, with the
    /// forces of the evaluation of that step. Summed as [`Self::strained`].
    pub(crate) fn moments(
        &self,
        of: &Constants<S>,
        step: u64,
        bodies: &[Body<S>],
        together: &[Range<usize>],
    ) -> ExactSum<9> {
        let (law, grains, times) = (of.law(), &self.grains, of.contact_times(step));
        let mut sums = ExactSum::new();
        let mut add = |moment: S::Tensor| {
            (0..S::Tensor::COMPONENTS).for_each(|component| sums.add(component, moment[component]));
        };
        for range in together {
            let of_row = |row: usize| self.contacts.moment(law, grains, row, times);
            add(range.clone().fold(S::Tensor::zero(), |sum, row| sum + of_row(row)));
        }
        let walls = self.walls.bearings(law, grains, (bodies, &self.cell), times);
        walls.for_each(|bearing| add(bearing.moment() * bearing.weight));
        sums
    }
}

pub(crate) fn add_image(image: &mut Image, more: Image) {
    for (image, more) in image.iter_mut().zip(more) {
        *image += more;
    }
}
