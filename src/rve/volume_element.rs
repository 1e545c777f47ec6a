//! An RVE: grains in a periodic cell that goes along with a deformation gradient F.
//!
//! It is kept in a frame Q that turns with the rotation of each increment,
//!
//! ```text
//! dF = F F_before^-1 = dR dU,   Q = dR Q_before,   cell edges h = Q^T F h_0,   Kirchhoff stress = Q (sum of moments/V_0) Q^T
//! ```
//!
//! so that the cell is driven by the whole velocity gradient (the frame has its spin), sees none but stretches, and is left alone by a
//! rigid turn: stress turns with it
//! to round-off, and no memory of a contact has to be turned. A frame that turns with R of F = R U itself, as of Liu et al. (2016, box B1),
//! would lose the spin between R and
//! the vorticity.
//!
//! A cell that expands until nothing in it touches is **loose**: its grains are carried along without steps and without stress until the
//! volume is back at which the last
//! contact was lost; otherwise they would fly on for ever. Then they start from rest.

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::dem::cell::Cell;
use crate::dem::sample::Sample;
use crate::rve::drive::{Drive, Grain, Pace, size_of};
use crate::rve::measure::{Fabric, Measured, affine_stiffness};
use crate::rve::renew;
use crate::rve::step::{Scratch, along};

/// The share of the pressure of the start below which increments take no more steps.
const PRESSURE_SHARE_MIN: f64 = 0.01;
/// Grains that come back from a loose state are stopped every so many steps, so many times at most, until none overlaps another by more
/// than this share of its radius.
const STEPS_BETWEEN_STOPS: u64 = 10;
const STOPS_MAX: u64 = 500;
const OVERLAP_AT_REST: f64 = 0.01;

/// Something that a run is told of, though it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Its last contact was lost.
    Loosened,
    /// It is as dense again as when that happened.
    Returned,
    /// It had become too thin along an axis and was replicated.
    Renewed { axis: usize },
}

/// A grain assembly that stands for a point.
#[derive(Clone)]
pub struct Rve<S: Space> {
    sample: Sample<S>,
    /// What the space's measure is multiplied with to give m3.
    depth: f64,
    state: State<S>,
}

/// Its deformation, and what it has come through.
#[derive(Clone, Debug, PartialEq)]
pub struct State<S: Space> {
    /// Edges at F = I, m.
    edges: S::Tensor,
    /// Volume at F = I and that of its grains, m3.
    volume: f64,
    solid: f64,
    grain: Grain,
    /// F and Q.
    deformation: S::Tensor,
    frame: S::Tensor,
    /// Mean stress of now, positive in compression, Pa: for the number of steps.
    pressure: f64,
    /// Of a loose one det F at which the last contact was lost, and its cell as it was then.
    loose: Option<(f64, Cell<S>)>,
    /// Steps of its grains so far, and of pairs in them: what it costs.
    pub steps: u64,
    pub pair_steps: u64,
}

/// What an increment came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<S: Space> {
    /// Kirchhoff stress J sigma, Pa, tension positive.
    pub kirchhoff: S::Symmetric,
    /// What of it was not symmetric: moments on grains that were out of balance, Pa.
    pub skew: f64,
    /// I_uf; none without contacts.
    pub unbalanced: Option<f64>,
    pub steps: u64,
    pub events: [Option<Event>; 2],
}

/// What an observer asks for beside, in the frame of F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looked<S: Space> {
    pub fabric: Fabric<S>,
    /// Pa ([`affine_stiffness`]).
    pub stiffness: S::Tensor,
}

impl<S: Space> Looked<S> {
    /// A bound on the P-wave modulus along any direction, Pa: the largest sum of a row bounds the largest eigenvalue.
    pub fn modulus_most(&self) -> f64 {
        let row = |row: usize| (0..S::DIMENSION).map(|column| self.stiffness[column * S::DIMENSION + row].abs()).sum();
        (0..S::DIMENSION).map(row).fold(0.0, f64::max)
    }
}

impl<S: Space> Answer<S> {
    /// Norm of the deviator over that of the mean stress: q/p in the plane, q = sqrt(s:s/2).
    pub fn deviator_over_pressure(&self) -> f64 {
        let stress = self.kirchhoff.tensor();
        let mean = S::trace(&stress) / S::DIMENSION as f64;
        let deviator = stress - S::identity() * mean;
        (0.5 * deviator.dot(&deviator)).sqrt() / mean.abs()
    }
}

impl<S: Space> Rve<S> {
    /// Of grains at rest, in the cell as it is at F = I. `depth` is that of the plane, m, one in space; all grains are free, of one
    /// density, with ids from none on
    /// in the order of rows.
    pub fn new(sample: Sample<S>, depth: f64) -> Result<Self, Error> {
        let grains = &sample.assembly.grains;
        renew::refuse_many(grains.owned)?;
        let hot = &grains.hot[..grains.owned];
        let solid: f64 = hot.iter().map(|hot| S::grain_volume(hot.radius, depth)).sum();
        let mass: f64 = hot.iter().map(|hot| hot.mass).sum();
        let diameter = 2.0 * hot.iter().map(|hot| hot.radius).sum::<f64>() / hot.len() as f64;
        let grain = Grain { diameter, density: mass / solid, dt: sample.constants.dt, pressure_min: 0.0 };
        let state = State {
            edges: sample.assembly.cell.edges,
            volume: sample.assembly.cell.volume() * depth,
            solid,
            grain,
            deformation: S::identity(),
            frame: S::identity(),
            pressure: f64::INFINITY,
            loose: None,
            steps: 0,
            pair_steps: 0,
        };
        let mut rve = Self::of(sample, state, depth);
        rve.sample.assembly.grains.restore_cold();
        let moment = rve.sample.contact_moment();
        rve.sample.assembly.grains.drop_cold();
        rve.state.pressure = rve.pressure_of(&moment);
        // What is not a number is not positive.
        if rve.state.pressure <= 0.0 || rve.state.pressure.is_nan() {
            return Err(Error::User(format!(
                "a grain assembly that stands for a material must be under pressure at the start, and this one bears {:.3e} Pa: prepare it by packing.preparation = \"compress\"",
                rve.state.pressure
            )));
        }
        rve.state.grain.pressure_min = PRESSURE_SHARE_MIN * rve.state.pressure;
        Ok(rve)
    }

    /// As it has been; the rooms of its own go.
    pub(super) fn of(mut sample: Sample<S>, state: State<S>, depth: f64) -> Self {
        Scratch::default().take_back(&mut sample);
        Self { sample, depth, state }
    }

    /// What it is now is where F begins.
    pub(super) fn begin_here(&mut self) {
        // In its own frame, which is that of F from now on: what begins is isotropic, or along the axes that it was compressed along.
        self.state.edges = self.sample.assembly.cell.edges;
        self.state.volume = self.volume();
        (self.state.deformation, self.state.frame) = (S::identity(), S::identity());
        self.state.grain.pressure_min = PRESSURE_SHARE_MIN * self.state.pressure;
        (self.state.steps, self.state.pair_steps) = (0, 0);
    }

    /// Volume of now, m3.
    pub fn volume(&self) -> f64 {
        self.state.volume * S::determinant(&self.state.deformation)
    }

    /// Volume of voids over that of grains.
    pub fn void_ratio(&self) -> f64 {
        self.volume() / self.state.solid - 1.0
    }

    /// Mean pressure, Pa.
    pub fn pressure(&self) -> f64 {
        self.state.pressure
    }

    pub fn grains(&self) -> usize {
        self.sample.assembly.grains.owned
    }

    pub fn depth(&self) -> f64 {
        self.depth
    }

    pub fn state(&self) -> &State<S> {
        &self.state
    }

    pub fn is_loose(&self) -> bool {
        self.state.loose.is_some()
    }

    /// Its grains and cell, in its own frame.
    pub fn sample(&self) -> &Sample<S> {
        &self.sample
    }

    /// F of now.
    pub fn deformation(&self) -> &S::Tensor {
        &self.state.deformation
    }

    /// Q: from its own frame to that of F.
    pub fn frame(&self) -> &S::Tensor {
        &self.state.frame
    }

    fn pressure_of(&self, moment: &S::Tensor) -> f64 {
        -S::trace(moment) / (S::DIMENSION as f64 * self.volume())
    }

    /// From its own frame to that of F.
    fn turned(&self, tensor: &S::Tensor) -> S::Tensor {
        self.state.frame * *tensor * S::transpose(&self.state.frame)
    }

    /// Q^T F: takes edges at F = I to those of the cell.
    fn carried(&self) -> S::Tensor {
        S::transpose(&self.state.frame) * self.state.deformation
    }

    /// Edges h = Q^T F h_0 of the basis in which the cell's edges are `near`: they differ by whole multiples of each other.
    fn edges_near(&self, near: &S::Tensor) -> S::Tensor {
        in_basis_near::<S>(&(self.carried() * self.state.edges), near)
    }

    /// Goes along to the deformation gradient `deformation`, an increment that lasts `duration` (s). After an error it is of no use: what
    /// it was is what
    /// [`Self::rest`] told before.
    pub fn follow(
        &mut self,
        deformation: &S::Tensor,
        duration: f64,
        drive: &Drive,
        scratch: &mut Scratch<S>,
    ) -> Result<Answer<S>, Error> {
        scratch.lend(&mut self.sample);
        let answer = self.go_along(deformation, duration, drive);
        scratch.take_back(&mut self.sample);
        answer
    }

    /// The same with what an observer asks for at its end.
    pub fn follow_and_look(
        &mut self,
        deformation: &S::Tensor,
        duration: f64,
        drive: &Drive,
        scratch: &mut Scratch<S>,
    ) -> Result<(Answer<S>, Looked<S>), Error> {
        scratch.lend(&mut self.sample);
        let answer = self.go_along(deformation, duration, drive);
        // A loose one has been left alone: the forces at hand are those of another.
        let is_stepped = answer.as_ref().is_ok_and(|answer| answer.steps > 0);
        let looked = is_stepped.then(|| (Fabric::of(&self.sample), affine_stiffness(&self.sample)));
        let (fabric, stiffness) = looked.unwrap_or_else(|| (Fabric::none(), S::Tensor::zero()));
        scratch.take_back(&mut self.sample);
        let fabric = Fabric { tensor: self.turned(&fabric.tensor), ..fabric };
        Ok((answer?, Looked { fabric, stiffness: self.turned(&stiffness) * (1.0 / self.volume()) }))
    }

    fn go_along(&mut self, deformation: &S::Tensor, duration: f64, drive: &Drive) -> Result<Answer<S>, Error> {
        let ratio = S::determinant(deformation);
        if !deformation.is_finite() || ratio <= 0.0 {
            return Err(Error::Run(format!(
                "a grain assembly cannot follow a deformation gradient whose determinant is {ratio:.3e}: the material is turned inside out there, and the step of the continuum too long"
            )));
        }
        if drive.pace == Pace::Synchronous && !(duration > 0.0 && duration.is_finite()) {
            return Err(Error::Run(format!(
                "a grain assembly that has the time of the continuum cannot follow an increment of {duration:.3e} s"
            )));
        }
        let mut events = [None; 2];
        if self.state.loose.is_none() {
            events[0] = self.renew_where_thin()?;
        }
        let before = S::inverse(&self.state.deformation).expect("what has been followed can be gone back");
        let increment = *deformation * before;
        let turn = S::rotation(&increment);
        let stretch = S::transpose(&turn) * increment;
        self.state.deformation = *deformation;
        self.state.frame = S::rotation(&(turn * self.state.frame));
        if let Some((lost, cell)) = self.state.loose {
            if ratio > lost {
                return Ok(self.idle(events));
            }
            self.return_from(&cell)?;
            events[0] = Some(Event::Returned);
        }
        let (count, dt) = drive.steps(size_of::<S>(&stretch), self.state.pressure, duration, &self.state.grain);
        self.sample.constants.dt = dt;
        let now = self.sample.assembly.cell.edges;
        let way = self.edges_near(&now) - now;
        self.step(way, count)?;
        let mut measured = Measured::of(&self.sample);
        let mut unbalanced = measured.unbalanced(&self.sample);
        let mut steps = count;
        if let Some(relaxation) = drive.relaxation {
            while unbalanced.is_some_and(|share| share > relaxation.unbalanced_max)
                && steps - count < relaxation.steps_max
            {
                let more = drive.steps_min.max(1);
                self.step(S::Tensor::zero(), more)?;
                measured = Measured::of(&self.sample);
                unbalanced = measured.unbalanced(&self.sample);
                steps += more;
            }
        }
        self.state.pressure = self.pressure_of(&measured.moment);
        if measured.contacts == 0 && S::determinant(&increment) > 1.0 {
            let cell = self.sample.assembly.cell;
            // The basis of now is that of the return, however far the cell goes meanwhile.
            let back = S::inverse(&self.carried()).expect("F and Q can be gone back");
            self.state.edges = back * cell.edges;
            self.state.loose = Some((ratio, cell));
            events[1] = Some(Event::Loosened);
        }
        let moment = self.turned(&measured.moment) * (1.0 / self.state.volume);
        let skew = (moment - S::transpose(&moment)).norm() * 0.5;
        Ok(Answer { kirchhoff: S::Symmetric::of(&moment), skew, unbalanced, steps, events })
    }

    /// A cell that is too thin for its contacts is replicated.
    fn renew_where_thin(&mut self) -> Result<Option<Event>, Error> {
        let Some(axis) = renew::thin_axis(&self.sample) else { return Ok(None) };
        renew::double(&mut self.sample, axis)?;
        (self.state.volume, self.state.solid) = (2.0 * self.state.volume, 2.0 * self.state.solid);
        let back = S::inverse(&self.carried()).expect("F and Q can be gone back");
        self.state.edges = back * self.sample.assembly.cell.edges;
        Ok(Some(Event::Renewed { axis }))
    }

    fn step(&mut self, way: S::Tensor, count: u64) -> Result<(), Error> {
        let edges = self.carried() * self.state.edges;
        along(&mut self.sample, way, count, |near| in_basis_near::<S>(&edges, near))?;
        self.state.steps += count;
        self.state.pair_steps += count * self.sample.assembly.contacts.neighbours.pairs.len() as u64;
        Ok(())
    }

    /// Of a loose one.
    fn idle(&self, events: [Option<Event>; 2]) -> Answer<S> {
        Answer { kirchhoff: S::Symmetric::of(&S::Tensor::zero()), skew: 0.0, unbalanced: None, steps: 0, events }
    }

    /// Lays the grains of a loose cell, which has stayed `cell`, where the present one would have carried them, and lets them come to rest:
    /// what was carried through a
    /// shear may overlap.
    fn return_from(&mut self, cell: &Cell<S>) -> Result<(), Error> {
        self.state.loose = None;
        let edges = self.carried() * self.state.edges;
        let assembly = &mut self.sample.assembly;
        assembly.cell.set_rate(S::Tensor::zero());
        assembly.cell.arrive(edges);
        let (carried, corner) = (cell.deformation_to(&assembly.cell), assembly.cell.corner);
        for hot in &mut assembly.grains.hot {
            hot.position = corner + carried * (hot.position - corner);
        }
        self.stop_grains();
        if self.renew_where_thin()?.is_none() {
            self.sample.assembly.grains.restore_cold();
            self.sample.rebuild(1.0)?;
        }
        for _ in 0..STOPS_MAX {
            let grains = &self.sample.assembly.grains;
            self.sample.assembly.contacts.settle_images(&self.sample.assembly.cell);
            let deepest = self.sample.assembly.contacts.deepest(grains).map_or(0.0, |(share, _)| share);
            if deepest < OVERLAP_AT_REST {
                break;
            }
            self.step(S::Tensor::zero(), STEPS_BETWEEN_STOPS)?;
            self.sample.assembly.grains.restore_cold();
            self.stop_grains();
        }
        Ok(())
    }

    fn stop_grains(&mut self) {
        for hot in &mut self.sample.assembly.grains.hot {
            (hot.velocity, hot.spin) = (S::Vector::zero(), S::Spin::zero());
        }
    }
}

/// These edges in the basis in which they are nearest to others: a whole multiple of each for each.
fn in_basis_near<S: Space>(edges: &S::Tensor, near: &S::Tensor) -> S::Tensor {
    let mut basis = S::inverse(edges).expect("a cell has a volume") * *near;
    (0..S::Tensor::COMPONENTS).for_each(|component| basis[component] = basis[component].round());
    debug_assert!(S::determinant(&basis).abs() == 1.0, "another basis of one lattice has its volume");
    *edges * basis
}
