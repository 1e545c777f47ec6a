//! What deforms the cell: a given velocity gradient, and axes whose stretch keeps a normal stress.
//!
//! A periodic cell strains all its grains at once: nothing has to travel, so that its stress answers within the step by the
//! affine stiffness K of the contacts of now ([`crate::dem::strained`]), and less once grains rearrange. Every `interval`
//! steps, T apart, the rate of stretch of an axis with a target follows the missing stress e = target - stress in proportion
//! and by its integral, within a limit:
//!
//! ```text
//! L = e/eta + learnt,       eta = K T/gain + 2 C
//! d learnt = gain e/(20 eta)
//! ```
//!
//! The share `gain` of e is made up until the next look where grains move with the cell. The first term is a dashpot between
//! load and cell: it can only take energy from the grains, whatever their vibrations. Looked at only every T it is stable for
//! gains below 2; C, what contact dashpots answer to L at once, would turn L round at every look if it were more than eta. The
//! second term keeps the stress at the target while the material flows, 20 response times T/gain behind: with grains that
//! rearrange, and answer with less than K, it is damped critically down to a fifth of K and at 0.7 of that down to a tenth. At the limit nothing is learnt, and without contacts
//! what was learnt is forgotten.
//!
//! Packings in the making hardly touch or are gases, whose contacts of now tell little: they are given eta.

use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;
use crate::dem::strained::Strained;

/// Response times over which the rate of a flow is learnt.
const MEMORY: f64 = 20.0;

/// The velocity gradient of the cell, and the axes of it that follow a stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellDrive<S: Space> {
    /// L, 1/s.
    pub gradient: S::Tensor,
    /// None where no axis follows a stress.
    pub servo: Option<StressServo>,
}

/// Axes whose rate of stretch follows a stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressServo {
    /// Normal stress per axis, Pa, tension positive.
    pub stress: [Option<f64>; 3],
    /// How fast they answer, the same for all axes.
    pub response: Response,
    /// Steps between two looks at the stress.
    pub interval: u64,
    /// 1/s.
    pub rate_max: f64,
    /// Volume that the space's measure of the cell is multiplied with: the depth in the plane, one in space.
    pub depth: f64,
}

/// How fast the cell answers to a missing stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    /// By the stiffness of the contacts: the share of the missing stress that is made up until the next look.
    Contacts {
        /// Stable below 2.
        gain: f64,
    },
    /// L = e/viscosity, Pa s; nothing is learnt.
    Viscosity(f64),
}

impl Response {
    /// The rate of stretch for a missing stress (Pa), and what is learnt of it, 1/s. `of` has the modulus (Pa) and viscosity
    /// (Pa s) of the contacts; none bear where both are zero.
    fn to(self, missing: f64, [modulus, dashpots]: [f64; 2], between: f64) -> [f64; 2] {
        let beyond = if missing == 0.0 { 0.0 } else { f64::INFINITY.copysign(missing) };
        match self {
            Self::Viscosity(viscosity) => [missing / viscosity, 0.0],
            Self::Contacts { .. } if modulus == 0.0 && dashpots == 0.0 => [beyond, 0.0],
            Self::Contacts { gain } => {
                let rate = missing / (modulus * between / gain + 2.0 * dashpots);
                [rate, rate * gain / MEMORY]
            }
        }
    }
}

/// What was missing of the stress of axes held at one, over the looks since the last row of the series; the same on every
/// rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Missed {
    /// Sums of squares per axis, Pa2.
    squares: [f64; 3],
    looks: u64,
}

impl Missed {
    /// Root of the mean square of an axis, Pa; none without a look.
    pub fn root_mean_square(&self, axis: usize) -> Option<f64> {
        (self.looks > 0).then(|| (self.squares[axis] / self.looks as f64).sqrt())
    }

    /// As it is stored: no row without a look.
    pub fn rows(self) -> Vec<Self> {
        if self.looks > 0 { vec![self] } else { Vec::new() }
    }
}

impl Record for Missed {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("squares", &mut self.squares);
        visitor.u64("looks", &mut self.looks);
    }
}

impl<S: Space> Default for CellDrive<S> {
    fn default() -> Self {
        Self { gradient: S::Tensor::zero(), servo: None }
    }
}

impl<S: Space> CellDrive<S> {
    /// Whether nothing deforms the cell: no gradient is given and no axis follows a stress.
    pub fn is_at_rest(&self) -> bool {
        self.gradient == S::Tensor::zero() && self.servo.is_none()
    }

    /// Whether the stress is looked at in this step.
    pub fn looks_at(&self, step: u64) -> bool {
        self.servo.is_some_and(|servo| step.is_multiple_of(servo.interval))
    }

    /// The velocity gradient of a cell over the coming drift of `dt`, with the sums over its contacts where the step looks at them.
    pub fn gradient_of(
        &self,
        cell: &mut Cell<S>,
        sums: Option<&Strained<S>>,
        dt: f64,
        missed: &mut Missed,
    ) -> S::Tensor {
        match (&self.servo, sums) {
            (None, _) => self.gradient,
            (Some(_), None) => cell.gradient,
            (Some(servo), Some(sums)) => servo.follow(self.gradient, cell, sums, dt, missed),
        }
    }
}

impl StressServo {
    fn follow<S: Space>(
        &self,
        mut gradient: S::Tensor,
        cell: &mut Cell<S>,
        sums: &Strained<S>,
        dt: f64,
        missed: &mut Missed,
    ) -> S::Tensor {
        let volume = cell.volume() * self.depth;
        let between = self.interval as f64 * dt;
        let bears = (0..S::DIMENSION).any(|axis| sums.springs[axis] > 0.0 || sums.dashpots[axis] > 0.0);
        for axis in 0..S::DIMENSION {
            let Some(target) = self.stress[axis] else { continue };
            let diagonal = axis * S::DIMENSION + axis;
            let missing = target - sums.moment[diagonal] / volume;
            let resistance = [sums.springs[axis] / volume, sums.dashpots[axis] / volume];
            let [rate, learns] = self.response.to(missing, resistance, between);
            if !bears {
                cell.learnt[axis] = 0.0;
            }
            let wanted = rate + cell.learnt[axis];
            gradient[diagonal] = wanted.clamp(-self.rate_max, self.rate_max);
            if gradient[diagonal] == wanted {
                cell.learnt[axis] += learns;
            }
            missed.squares[axis] += missing * missing;
        }
        missed.looks += 1;
        gradient
    }
}
