//! A step of grains in a cell whose edges change at a constant rate. A place that moves with such a cell goes straight on, so that grains
//! which do are pushed by nothing, and a kick and the drift after it touch a record once. An increment of deformation is
//!
//! ```text
//! the mean field takes up its rate, first drift;   evaluate, kick, drift (n - 1 times);   evaluate with forces kept, kick
//! ```
//!
//! so that the forces of its end are those at its end.

use std::sync::{Mutex, PoisonError};

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::dem::contacts::Rooms;
use crate::dem::sample::Sample;
use crate::rve::kick_drift::{KickDrift, Push};

/// What a thread lends to the assembly that it steps: forces, which nothing remembers.
#[derive(Clone, Debug)]
pub struct Scratch<S: Space> {
    force: Vec<S::Vector>,
    torque: Vec<S::Spin>,
    rooms: Rooms<S>,
}

impl<S: Space> Default for Scratch<S> {
    fn default() -> Self {
        Self { force: Vec::new(), torque: Vec::new(), rooms: Rooms::default() }
    }
}

impl<S: Space> Scratch<S> {
    /// For an assembly that has none of its own.
    pub(super) fn lend(&mut self, sample: &mut Sample<S>) {
        self.swap(sample);
        let Sample { assembly, .. } = sample;
        let grains = &mut assembly.grains;
        grains.force.resize(grains.owned, S::Vector::zero());
        grains.torque.resize(grains.owned, S::Spin::zero());
        assembly.contacts.fit_rooms();
    }

    /// And what only a rebuild reads is given up.
    pub(super) fn take_back(&mut self, sample: &mut Sample<S>) {
        self.swap(sample);
        sample.assembly.drop_cold();
    }

    fn swap(&mut self, sample: &mut Sample<S>) {
        let Sample { assembly, .. } = sample;
        std::mem::swap(&mut self.force, &mut assembly.grains.force);
        std::mem::swap(&mut self.torque, &mut assembly.grains.torque);
        assembly.contacts.swap_rooms(&mut self.rooms);
    }
}

/// Scratches that threads take turns with, kept from step to step.
#[derive(Debug)]
pub struct Scratches<S: Space>(Mutex<Vec<Scratch<S>>>);

impl<S: Space> Default for Scratches<S> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

impl<S: Space> Scratches<S> {
    /// Lends one to some work.
    pub fn with<R>(&self, work: impl FnOnce(&mut Scratch<S>) -> R) -> R {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = free().pop().unwrap_or_default();
        let outcome = work(&mut scratch);
        free().push(scratch);
        outcome
    }
}

/// Takes the edges of a cell straight to `edges`, m, in `count` steps of the sample's time step: whichever basis of that lattice is the
/// one of the cell. Forces of all pairs are kept at the end. Returns by how much grains have turned in the mean, rad.
pub fn along<S: Space>(sample: &mut Sample<S>, edges: &S::Tensor, count: u64) -> Result<S::Spin, Error> {
    let now = sample.assembly.cell.edges;
    let way = in_basis_near::<S>(edges, &now)? - now;
    let change = sample.assembly.cell.set_rate(way * (1.0 / (count as f64 * sample.constants.dt)));
    let mut spins = set_out(sample, &change);
    for number in 1..=count {
        sample.step += 1;
        if number == count {
            // Without what steps have rounded; lists may have been made in another basis.
            let arrived = in_basis_near::<S>(edges, &sample.assembly.cell.edges)?;
            sample.assembly.cell.arrive(arrived);
        }
        // What is not a number is not below one.
        let closed = closed(sample);
        if closed >= 1.0 || closed.is_nan() {
            sample.assembly.restore_cold();
            sample.rebuild(closed)?;
        }
        match number == count {
            false => spins += evaluate::<S, true>(sample),
            true => _ = evaluate::<S, false>(sample),
        }
    }
    Ok(spins * (sample.constants.dt / sample.assembly.grains.owned as f64))
}

/// These edges in the basis in which they are nearest to others: whole multiples of one another, of the same volume.
fn in_basis_near<S: Space>(edges: &S::Tensor, near: &S::Tensor) -> Result<S::Tensor, Error> {
    let mut basis = S::inverse(edges).unwrap_or_else(S::Tensor::zero) * *near;
    (0..S::Tensor::COMPONENTS).for_each(|component| basis[component] = basis[component].round());
    match S::determinant(&basis).abs() == 1.0 {
        true => Ok(*edges * basis),
        false => Err(Error::Run(
            "the cell of a grain assembly is strained by a half and more in one increment: the step of the continuum is too long"
                .into(),
        )),
    }
}

/// The mean field follows a change of its gradient, and grains drift for the first time. The sum of their spins, rad/s.
fn set_out<S: Space>(sample: &mut Sample<S>, change: &S::Tensor) -> S::Spin {
    let dt = sample.constants.dt;
    let assembly = &mut sample.assembly;
    let before = assembly.cell;
    assembly.cell.go_on(dt);
    let strain = assembly.cell_home.deformation_to(&assembly.cell);
    let kick_drift = KickDrift { push: Push::MeanField(change), cell: &before, dt, strain };
    let moved = kick_drift.run::<true>(&mut assembly.grains, assembly.contacts.instructions());
    assembly.moved = moved.way;
    moved.spins
}

/// Forces of all pairs where grains are, kept, over the time step of the sample.
pub fn forces<S: Space>(sample: &mut Sample<S>) {
    evaluate::<S, false>(sample);
}

/// Forces, kicks, and where steps go on the next drift. The sum of spins after the kick, rad/s.
fn evaluate<S: Space, const DRIFTS: bool>(sample: &mut Sample<S>) -> S::Spin {
    let Sample { assembly, constants, step, .. } = sample;
    let (before, dt) = (assembly.cell, constants.dt);
    assembly.contacts.settle_images(&before);
    let times = constants.contact_times(*step);
    assembly.contacts.pass_in_order(constants.law(), &mut assembly.grains, times, !DRIFTS);
    if DRIFTS {
        assembly.cell.go_on(dt);
    }
    let strain = assembly.cell_home.deformation_to(&assembly.cell);
    let damping = Some(&constants.field.damping).filter(|_| !constants.field.is_plain());
    let kick_drift = KickDrift { push: Push::Forces(damping), cell: &before, dt, strain };
    let moved = kick_drift.run::<DRIFTS>(&mut assembly.grains, assembly.contacts.instructions());
    if DRIFTS {
        assembly.moved = moved.way;
    }
    moved.spins
}

/// How much nearer two that may touch have come since lists were made, as a share of what these reach.
fn closed<S: Space>(sample: &Sample<S>) -> f64 {
    let (assembly, skin) = (&sample.assembly, sample.constants.skin);
    let strain = assembly.cell_home.deformation_to(&assembly.cell);
    let stretch = (strain - S::identity()).norm();
    (2.0 * assembly.moved + stretch * (2.0 * assembly.radius_max + skin)) / skin
}
