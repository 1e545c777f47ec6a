//! An RVE: grains in a periodic cell that goes along with a deformation gradient F.
//!
//! It is kept in a frame Q that turns with the rotation of each increment,
//!
//! ```text
//! dF = F F_before^-1 = dR dU,   Q = dR Q_before,   cell edges h = Q^T F h_0,   Kirchhoff stress = Q (sum of moments/V_0) Q^T
//! ```
//!
//! so that the cell is driven by the whole velocity gradient (the frame has its spin), sees none but stretches, and is left alone by a rigid turn: stress turns with it
//! to round-off, and no memory of a contact has to be turned. A frame that turns with R of F = R U itself, as of Liu et al. (2016, box B1), would lose the spin between R and
//! the vorticity.
//!
//! A cell that expands until nothing in it touches is **loose**: its grains are carried along without steps and without stress until the volume is back at which the last
//! contact was lost; otherwise they would fly on for ever. Then they start from rest.

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::dem::cell::Cell;
use crate::dem::sample::Sample;
use crate::rve::drive::{Drive, Grain, size_of};
use crate::rve::measure::{Fabric, Measured};
use crate::rve::renew;
use crate::rve::step::{Scratch, along};

/// The share of the pressure of the start below which increments take no more steps.
const PRESSURE_SHARE_MIN: f64 = 0.01;

/// Something that a run is told of, though it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Its last contact was lost.
    Loosened,
    /// It is as dense again as when that happened.
    Returned,
    /// It had become too thin along an axis and was laid beside itself.
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
    /// Of grains at rest, in the cell as it is at F = I. `depth` is that of the plane, m, one in space; all grains are free, of one density.
    pub fn new(sample: Sample<S>, depth: f64) -> Self {
        let grains = &sample.assembly.grains;
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
        rve.sample.assembly.grains.flesh_out();
        let moment = rve.sample.contact_moment();
        rve.sample.assembly.grains.slim();
        rve.state.pressure = rve.pressure_of(&moment);
        rve.state.grain.pressure_min = PRESSURE_SHARE_MIN * rve.state.pressure;
        rve
    }

    /// As it has been; the rooms of its own go.
    pub(super) fn of(mut sample: Sample<S>, state: State<S>, depth: f64) -> Self {
        Scratch::default().take_back(&mut sample);
        Self { sample, depth, state }
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

    /// Edges h = Q^T F h_0 of the basis in which the cell's edges are `near`: they differ by whole multiples of each other.
    fn edges_near(&self, near: &S::Tensor) -> S::Tensor {
        let edges = S::transpose(&self.state.frame) * self.state.deformation * self.state.edges;
        let Some(inverse) = S::inverse(&edges) else { return edges };
        let mut basis = inverse * *near;
        (0..S::Tensor::COMPONENTS).for_each(|component| basis[component] = basis[component].round());
        edges * basis
    }

    /// Goes along to the deformation gradient `deformation`, an increment that lasts `duration` (s).
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

    /// The same with the fabric of the contacts at its end, in the frame of F.
    pub fn follow_and_look(
        &mut self,
        deformation: &S::Tensor,
        duration: f64,
        drive: &Drive,
        scratch: &mut Scratch<S>,
    ) -> Result<(Answer<S>, Fabric<S>), Error> {
        scratch.lend(&mut self.sample);
        let answer = self.go_along(deformation, duration, drive);
        let fabric = Fabric::of(&self.sample);
        scratch.take_back(&mut self.sample);
        Ok((answer?, Fabric { tensor: self.turned(&fabric.tensor), ..fabric }))
    }

    fn go_along(&mut self, deformation: &S::Tensor, duration: f64, drive: &Drive) -> Result<Answer<S>, Error> {
        let before = S::inverse(&self.state.deformation).unwrap_or_else(S::identity);
        let increment = *deformation * before;
        let turn = S::rotation(&increment);
        let stretch = S::transpose(&turn) * increment;
        self.state.deformation = *deformation;
        self.state.frame = S::rotation(&(turn * self.state.frame));
        let mut events = [None; 2];
        if let Some((ratio, cell)) = self.state.loose {
            if S::determinant(deformation) > ratio {
                return Ok(self.idle(events));
            }
            self.return_to(&cell);
            events[0] = Some(Event::Returned);
        } else if let Some(axis) = renew::thin_axis(&self.sample, &self.edges_near(&self.sample.assembly.cell.edges)) {
            renew::double(&mut self.sample, axis)?;
            (self.state.volume, self.state.solid) = (2.0 * self.state.volume, 2.0 * self.state.solid);
            self.state.edges = self.doubled_edges();
            events[0] = Some(Event::Renewed { axis });
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
            self.state.loose = Some((S::determinant(deformation), self.sample.assembly.cell));
            events[1] = Some(Event::Loosened);
        }
        let moment = self.turned(&measured.moment) * (1.0 / self.state.volume);
        let skew = (moment - S::transpose(&moment)).norm() * 0.5;
        Ok(Answer { kirchhoff: S::Symmetric::of(&moment), skew, unbalanced, steps, events })
    }

    fn step(&mut self, way: S::Tensor, count: u64) -> Result<(), Error> {
        let edges = S::transpose(&self.state.frame) * self.state.deformation * self.state.edges;
        let inverse = S::inverse(&edges).unwrap_or_else(S::identity);
        along(&mut self.sample, way, count, |near| {
            let mut basis = inverse * *near;
            (0..S::Tensor::COMPONENTS).for_each(|component| basis[component] = basis[component].round());
            edges * basis
        })?;
        self.state.steps += count;
        self.state.pair_steps += count * self.sample.assembly.contacts.neighbours.pairs.len() as u64;
        Ok(())
    }

    /// Of a loose one.
    fn idle(&self, events: [Option<Event>; 2]) -> Answer<S> {
        Answer { kirchhoff: S::Symmetric::of(&S::Tensor::zero()), skew: 0.0, unbalanced: None, steps: 0, events }
    }

    /// Lays the grains of a loose cell, which has stayed `cell`, where the present one would have carried them, at rest.
    fn return_to(&mut self, cell: &Cell<S>) {
        self.state.loose = None;
        let edges = self.edges_near(&cell.edges);
        let assembly = &mut self.sample.assembly;
        assembly.cell.set_rate(S::Tensor::zero());
        assembly.cell.arrive(edges);
        let carried = cell.deformation_to(&assembly.cell);
        let corner = assembly.cell.corner;
        for hot in &mut assembly.grains.hot {
            hot.position = corner + carried * (hot.position - corner);
            hot.velocity = S::Vector::zero();
            hot.spin = S::Spin::zero();
        }
    }

    /// Edges at F = I of a cell that has been laid beside itself: those of its basis of now.
    fn doubled_edges(&self) -> S::Tensor {
        let back = S::inverse(&(S::transpose(&self.state.frame) * self.state.deformation)).unwrap_or_else(S::identity);
        back * self.sample.assembly.cell.edges
    }
}
