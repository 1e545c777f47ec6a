//! An RVE: grains in a periodic cell that goes along with a deformation gradient F.
//!
//! It is kept in a frame Q that turns with the rotation of each increment,
//!
//! ```text
//! dF = F F_before^-1 = dR dU,   Q = dR Q_before,   cell edges h = Q^T F h_0,   Kirchhoff stress = Q (sum of moments/V_0) Q^T
//! ```
//!
//! so that the cell is driven by the whole velocity gradient (the frame has its spin), sees none but stretches, and is left alone by a
//! rigid turn: stress turns with it to round-off, and no memory of a contact has to be turned. A frame that turns with R of F = R U
//! itself, as of Liu et al. (2016, box B1), would lose the spin between R and the vorticity.
//!
//! A cell that expands until nothing in it touches is **loose**: its grains are carried along without steps and without stress until the
//! volume is back at which the last contact was lost; otherwise they would fly on for ever. Then they start from rest.

use crate::base::compiled::of_space;
use crate::base::error::Error;
use crate::base::math;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::base::symmetric::Symmetric;
use crate::dem::grains::Hot;
use crate::dem::sample::Sample;
use crate::rve::drive::{Drive, Pace, size_of};
use crate::rve::measure::{self, Fabric, Measured, Touching, affine_stiffness};
use crate::rve::renew;
use crate::rve::rest::Template;
use crate::rve::step::{Scratch, along, forces};

/// The share of the pressure of the start below which increments take no more steps.
const PRESSURE_SHARE_MIN: f64 = 0.01;
/// Grains that come back from a loose state are stopped every so many steps, so many times at most, until none overlaps another by more
/// than this share of its radius.
const STEPS_BETWEEN_STOPS: u64 = 10;
const STOPS_MAX: u64 = 500;
const OVERLAP_AT_REST: f64 = 0.01;

/// What a run is told of, though it goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// Its last contact was lost.
    pub loosened: bool,
    /// It is as dense again as when that happened.
    pub returned: bool,
    /// Times that it had become too thin along an axis, and was replicated.
    pub replicated: u32,
    /// It was drawn out too far, and its packing has taken its place.
    pub renewed: bool,
}

/// A grain assembly that stands for a point.
#[derive(Clone)]
pub struct Rve<S: Space> {
    sample: Sample<S>,
    template: Template<S>,
    state: State<S>,
}

/// Its deformation, and what it has come through.
#[derive(Clone, Debug, PartialEq)]
pub struct State<S: Space> {
    /// Edges at F = I, m.
    edges: S::Tensor,
    /// F and Q.
    deformation: S::Tensor,
    frame: S::Tensor,
    /// Mean stress of now, positive in compression, and that which is not thought smaller where steps are counted, Pa.
    pressure: f64,
    pressure_min: f64,
    /// Of a loose one det F at which the last contact was lost. Its cell stays as it was then.
    loose: Option<f64>,
    /// By how much its grains have turned in the mean, rad: the sum of the increments, which about a fixed axis is an angle.
    rotation: S::Spin,
    /// Steps so far, and those of pairs: what it costs.
    pub steps: u64,
    /// Steps times the pairs that each evaluates.
    pub pair_steps: u64,
}

impl<S: Space> State<S> {
    /// Before it is read.
    pub fn blank() -> Self {
        Self {
            edges: S::identity(),
            deformation: S::identity(),
            frame: S::identity(),
            pressure: 0.0,
            pressure_min: 0.0,
            loose: None,
            rotation: S::Spin::zero(),
            steps: 0,
            pair_steps: 0,
        }
    }
}

impl<S: Space> Record for State<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("edges_at_start", self.edges.as_mut_slice());
        visitor.f64s("deformation", self.deformation.as_mut_slice());
        visitor.f64s("frame", self.frame.as_mut_slice());
        visitor.f64s("pressure", std::slice::from_mut(&mut self.pressure));
        visitor.f64s("pressure_min", std::slice::from_mut(&mut self.pressure_min));
        // No volume ratio is zero.
        let mut loose = self.loose.unwrap_or_default();
        visitor.f64s("loose_at", std::slice::from_mut(&mut loose));
        self.loose = Some(loose).filter(|ratio| *ratio > 0.0);
        visitor.later_f64s("grain_rotation", self.rotation.as_mut_slice());
        visitor.u64("steps", &mut self.steps);
        visitor.u64("pair_steps", &mut self.pair_steps);
    }
}

/// What an increment came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response<S: Space> {
    /// Kirchhoff stress J sigma, Pa, tension positive.
    pub kirchhoff: S::Symmetric,
    /// What of it was not symmetric: moments on grains that were out of balance, Pa.
    pub skew: f64,
    /// I_uf; none without contacts.
    pub unbalanced: Option<f64>,
    /// Steps of grains, those at rest with them.
    pub steps: u64,
    /// What befell the assembly on the way.
    pub events: Events,
}

/// What an observer sees of an assembly as it is, in the frame of F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed<S: Space> {
    /// Kirchhoff stress J sigma, Pa, tension positive.
    pub kirchhoff: S::Symmetric,
    /// In the frame of F; zeros of a loose one.
    pub fabric: Fabric<S>,
    /// Pa ([`affine_stiffness`]).
    pub stiffness: S::Tensor,
    /// I_uf; none without contacts.
    pub unbalanced: Option<f64>,
}

/// A contact that bears force, in the frame of F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing<S: Space> {
    /// Ids, the lower first.
    pub grains: [u32; 2],
    /// Centre of the first, and of the other or its image, m.
    pub begin: S::Vector,
    /// Centre of the other or of its image, m.
    pub end: S::Vector,
    /// On the first, N.
    pub force: S::Vector,
}

impl<S: Space> Observed<S> {
    /// A bound on the P-wave modulus along any direction, Pa: the largest sum of a row bounds the largest eigenvalue.
    pub fn modulus_most(&self) -> f64 {
        let row = |row: usize| (0..S::DIMENSION).map(|column| self.stiffness[column * S::DIMENSION + row].abs()).sum();
        (0..S::DIMENSION).map(row).fold(0.0, f64::max)
    }
}

impl<S: Space> Response<S> {
    /// Of one that is loose.
    fn none() -> Self {
        let kirchhoff = S::Symmetric::of(&S::Tensor::zero());
        Self { kirchhoff, skew: 0.0, unbalanced: None, steps: 0, events: Events::default() }
    }

    /// Norm of the deviator over that of the mean stress: q/p in the plane, q = sqrt(s:s/2).
    pub fn deviator_over_pressure(&self) -> f64 {
        let stress = self.kirchhoff.tensor();
        let mean = S::trace(&stress) / S::DIMENSION as f64;
        let deviator = stress - S::identity() * mean;
        (0.5 * deviator.dot(&deviator)).sqrt() / mean.abs()
    }
}

type Follow<S> = fn(&mut Rve<S>, (&<S as Space>::Tensor, f64, &Drive), &mut Scratch<S>) -> Result<Response<S>, Error>;
static FOLLOW: (Follow<Plane>, Follow<Solid>) =
    (|rve, along, scratch| rve.follow_by(along, scratch), |rve, along, scratch| rve.follow_by(along, scratch));

impl<S: Space> Rve<S> {
    /// Of grains at rest, in the cell as it is at F = I. `depth` is that of the plane, m, one in space; all grains are free, of one
    /// density, with ids from none on in the order of rows.
    pub fn new(mut sample: Sample<S>, depth: f64) -> Result<Self, Error> {
        renew::refuse_many(sample.assembly.grains.owned)?;
        let moment = sample.contact_moment();
        let state = State { edges: sample.assembly.cell.edges, ..State::blank() };
        let template = Template::of(&sample, depth);
        let mut rve = Self::of(sample, template, state);
        let pressure = rve.pressure_of(&moment);
        // What is not a number is not positive.
        if pressure <= 0.0 || pressure.is_nan() {
            return Err(Error::User(format!(
                "a grain assembly that stands for a material must be under pressure at the start, and this one bears {pressure:.3e} Pa: prepare it by packing.preparation = \"compress\""
            )));
        }
        (rve.state.pressure, rve.state.pressure_min) = (pressure, PRESSURE_SHARE_MIN * pressure);
        Ok(rve)
    }

    /// As it has been; the rooms of its own go.
    pub(super) fn of(mut sample: Sample<S>, template: Template<S>, state: State<S>) -> Self {
        Scratch::default().take_back(&mut sample);
        Self { sample, template, state }
    }

    /// Of grains that are laid anew, without a memory of contacts and before any of its forces is known.
    pub(super) fn laid(sample: Sample<S>, template: Template<S>) -> Self {
        let state = State { edges: sample.assembly.cell.edges, ..State::blank() };
        Self::of(sample, template, state)
    }

    /// With another time step of its grains, s.
    pub fn with_step(mut self, dt: f64) -> Self {
        for constants in [&mut self.template.constants, &mut self.sample.constants] {
            constants.dt = dt;
        }
        self.template.grain.dt = dt;
        self
    }

    /// What it is now is where the F of another is, whose place it takes.
    pub(super) fn stand_in_for(&mut self, other: &Self) {
        self.state.deformation = other.state.deformation;
        self.state.edges = self.edges_of_cell();
        self.state.rotation = other.state.rotation;
        self.state.pressure_min = other.state.pressure_min;
        self.state.steps += other.state.steps;
        self.state.pair_steps += other.state.pair_steps;
    }

    /// What it is now is where F begins.
    pub(super) fn begin_here(&mut self) {
        // In its own frame, which is that of F from now on: what begins is isotropic, or along the axes that it was compressed along.
        self.state.edges = self.sample.assembly.cell.edges;
        (self.state.deformation, self.state.frame) = (S::identity(), S::identity());
        self.state.pressure_min = PRESSURE_SHARE_MIN * self.state.pressure;
        self.state.rotation = S::Spin::zero();
        (self.state.steps, self.state.pair_steps) = (0, 0);
    }

    /// Volume at F = I, m3, for which the Kirchhoff stress is.
    fn volume_start(&self) -> f64 {
        S::determinant(&self.state.edges) * self.template.depth
    }

    /// Volume of now, m3.
    pub fn volume(&self) -> f64 {
        self.volume_start() * S::determinant(&self.state.deformation)
    }

    /// Volume of voids over that of grains.
    pub fn void_ratio(&self) -> f64 {
        let volume_of = |hot: &Hot<S>| S::grain_volume(hot.radius, self.template.depth);
        self.volume() / self.sample.assembly.grains.hot.iter().map(volume_of).sum::<f64>() - 1.0
    }

    /// Mean pressure, Pa.
    pub fn pressure(&self) -> f64 {
        self.state.pressure
    }

    /// Number of grains, those of replicas with them.
    pub fn grains(&self) -> usize {
        self.sample.assembly.grains.owned
    }

    /// What it shares with all RVEs of its packing.
    pub fn template(&self) -> &Template<S> {
        &self.template
    }

    /// Its deformation, and what it has come through.
    pub fn state(&self) -> &State<S> {
        &self.state
    }

    /// Whether nothing in it touches, so that it is carried along without steps and without stress.
    pub fn is_loose(&self) -> bool {
        self.state.loose.is_some()
    }

    /// By how much its grains have turned in the mean since the start, rad: in the plane counterclockwise, in space about axes that add up.
    pub fn grain_rotation(&self) -> f64 {
        match S::DIMENSION {
            2 => self.state.rotation[0],
            _ => self.state.rotation.norm(),
        }
    }

    /// Logarithmic volume strain since its last contact was lost, of a loose one.
    pub fn opened(&self) -> f64 {
        self.state.loose.map_or(0.0, |lost| math::ln(S::determinant(&self.state.deformation) / lost))
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

    /// Edges at F = I in the basis of the cell as it is, which is where F says.
    fn edges_of_cell(&self) -> S::Tensor {
        S::inverse(&self.carried()).expect("F and Q can be gone back") * self.sample.assembly.cell.edges
    }

    /// Goes along to the deformation gradient `deformation`, an increment that lasts `duration` (s). After an error it is of no use: what
    /// it was is what [`Self::rest`] told before.
    pub fn follow(
        &mut self,
        deformation: &S::Tensor,
        duration: f64,
        drive: &Drive,
        scratch: &mut Scratch<S>,
    ) -> Result<Response<S>, Error> {
        of_space::<Follow<S>>([&FOLLOW.0, &FOLLOW.1])(self, (deformation, duration, drive), scratch)
    }

    fn follow_by(
        &mut self,
        (deformation, duration, drive): (&S::Tensor, f64, &Drive),
        scratch: &mut Scratch<S>,
    ) -> Result<Response<S>, Error> {
        scratch.lend(&mut self.sample);
        let answer = self.go_along(deformation, duration, drive);
        scratch.take_back(&mut self.sample);
        answer
    }

    /// What it is now. A copy of it is looked at, for whose contacts no time passes, and nothing of it changes.
    pub fn observe(&self, scratch: &mut Scratch<S>) -> Observed<S> {
        let zero = S::Tensor::zero();
        if self.is_loose() {
            let kirchhoff = S::Symmetric::of(&zero);
            return Observed { kirchhoff, fabric: Fabric::none(), stiffness: zero, unbalanced: None };
        }
        let mut sample = self.sample.clone();
        sample.constants.dt = 0.0;
        scratch.lend(&mut sample);
        forces(&mut sample);
        let measured = Measured::of(&sample);
        let (unbalanced, fabric) = (measured.unbalanced(&sample), Fabric::of(&sample));
        let stiffness = self.turned(&affine_stiffness(&sample)) * (1.0 / self.volume());
        scratch.take_back(&mut sample);
        Observed {
            kirchhoff: S::Symmetric::of(&self.kirchhoff_of(&measured)),
            fabric: Fabric { tensor: self.turned(&fabric.tensor), ..fabric },
            stiffness,
            unbalanced,
        }
    }

    /// Contacts that bear force as it is now. A copy of it is looked at, as in [`Self::observe`].
    pub fn bearings(&self, scratch: &mut Scratch<S>) -> Vec<Bearing<S>> {
        if self.is_loose() {
            return Vec::new();
        }
        let mut sample = self.sample.clone();
        sample.constants.dt = 0.0;
        scratch.lend(&mut sample);
        forces(&mut sample);
        let seen = |touching: Touching<S>| {
            let begin = self.place_of(&touching.grains[0].position);
            Bearing {
                grains: touching.rows.map(|row| row as u32),
                begin,
                end: begin - self.state.frame * touching.branch,
                force: self.state.frame * touching.force,
            }
        };
        let bearings = measure::bearing(&sample).map(seen).collect();
        scratch.take_back(&mut sample);
        bearings
    }

    /// From the corner of the cell in the frame of F, m.
    fn place_of(&self, position: &S::Vector) -> S::Vector {
        self.state.frame * (*position - self.sample.assembly.cell.corner)
    }

    /// Where grains are, from the corner of the cell in the frame of F, inside of it, and their radii, m; by id.
    pub fn places(&self) -> (Vec<S::Vector>, Vec<f64>) {
        let cell = &self.sample.assembly.cell;
        let place = |hot: &Hot<S>| {
            let mut position = hot.position;
            cell.wrap(&mut position, &mut S::Vector::zero());
            (self.place_of(&position), hot.radius)
        };
        self.sample.assembly.grains.hot.iter().map(place).unzip()
    }

    /// Edges of its cell in the frame of F, m.
    pub fn edges(&self) -> S::Tensor {
        self.state.frame * self.sample.assembly.cell.edges
    }

    /// Kirchhoff stress in the frame of F, Pa, as far as it is not symmetric too.
    fn kirchhoff_of(&self, measured: &Measured<S>) -> S::Tensor {
        self.turned(&measured.moment) * (1.0 / self.volume_start())
    }

    fn go_along(&mut self, deformation: &S::Tensor, duration: f64, drive: &Drive) -> Result<Response<S>, Error> {
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
        let mut events = Events::default();
        if self.state.loose.is_none() {
            events.replicated += self.replicate_where_thin()?;
        }
        let before = S::inverse(&self.state.deformation).expect("what has been followed can be gone back");
        let increment = *deformation * before;
        let turn = S::rotation(&increment);
        let stretch = S::transpose(&turn) * increment;
        self.state.deformation = *deformation;
        self.state.frame = S::rotation(&(turn * self.state.frame));
        // Grains turn with the frame, of a loose cell with nothing else.
        self.state.rotation += S::rotation_vector(&turn);
        if let Some(lost) = self.state.loose {
            if ratio > lost {
                return Ok(Response { events, ..Response::none() });
            }
            self.state.loose = None;
            events.returned = true;
            // Whatever the increments were in which it was left alone.
            self.sample.constants.dt = self.template.grain.dt;
            events.replicated += self.come_back()?;
        }
        let grain = &self.template.grain;
        let pressure = self.state.pressure.max(self.state.pressure_min);
        let (count, dt) = drive.steps(size_of::<S>(&stretch), pressure, duration, grain);
        self.sample.constants.dt = dt;
        self.step(count)?;
        let mut measured = Measured::of(&self.sample);
        let mut unbalanced = measured.unbalanced(&self.sample);
        let mut steps = count;
        if let Some(relaxation) = drive.relaxation {
            while unbalanced.is_some_and(|share| share > relaxation.unbalanced_max)
                && steps - count < relaxation.steps_max
            {
                let more = drive.steps_min.max(1);
                self.step(more)?;
                measured = Measured::of(&self.sample);
                unbalanced = measured.unbalanced(&self.sample);
                steps += more;
            }
        }
        self.state.pressure = self.pressure_of(&measured.moment);
        if measured.contacts == 0 && S::determinant(&increment) > 1.0 {
            // The basis of now is that of the return, however far the cell goes meanwhile.
            self.state.edges = self.edges_of_cell();
            self.state.loose = Some(ratio);
            events.loosened = true;
        }
        let moment = self.kirchhoff_of(&measured);
        let skew = (moment - S::transpose(&moment)).norm() * 0.5;
        Ok(Response { kirchhoff: S::Symmetric::of(&moment), skew, unbalanced, steps, events })
    }

    /// A cell that is too thin for its contacts is replicated until it is not; how often.
    fn replicate_where_thin(&mut self) -> Result<u32, Error> {
        let mut times = 0;
        while let Some(axis) = renew::thin_axis(&self.sample) {
            renew::double(&mut self.sample, axis)?;
            self.state.edges = self.edges_of_cell();
            times += 1;
        }
        Ok(times)
    }

    /// So many steps to where F says that the cell is.
    fn step(&mut self, count: u64) -> Result<(), Error> {
        let edges = self.carried() * self.state.edges;
        let turned = along(&mut self.sample, &edges, count)?;
        self.state.rotation += S::turned_spin(&self.state.frame, &turned);
        self.state.steps += count;
        self.state.pair_steps += count * self.sample.assembly.contacts.neighbours.counted as u64;
        Ok(())
    }

    /// Lays the grains of a loose cell, which has stayed as it was, where the present one would have carried them, and lets them come to
    /// rest: what was carried through a shear may overlap. Returns how often the cell was replicated.
    fn come_back(&mut self) -> Result<u32, Error> {
        let edges = self.carried() * self.state.edges;
        let assembly = &mut self.sample.assembly;
        let left = assembly.cell;
        assembly.cell.set_rate(S::Tensor::zero());
        assembly.cell.arrive(edges);
        let (carried, corner) = (left.deformation_to(&assembly.cell), assembly.cell.corner);
        for hot in &mut assembly.grains.hot {
            hot.position = corner + carried * (hot.position - corner);
        }
        self.stop_grains();
        let times = self.replicate_where_thin()?;
        self.sample.assembly.restore_cold();
        self.sample.rebuild(1.0)?;
        for _ in 0..STOPS_MAX {
            let assembly = &mut self.sample.assembly;
            assembly.contacts.settle_images(&assembly.cell);
            let deepest = assembly.contacts.deepest(&assembly.grains).map_or(0.0, |(share, _)| share);
            if deepest < OVERLAP_AT_REST {
                break;
            }
            self.step(STEPS_BETWEEN_STOPS)?;
            self.stop_grains();
        }
        Ok(times)
    }

    fn stop_grains(&mut self) {
        for hot in &mut self.sample.assembly.grains.hot {
            (hot.velocity, hot.spin) = (S::Vector::zero(), S::Spin::zero());
        }
    }
}
