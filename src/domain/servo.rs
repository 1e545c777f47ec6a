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

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::strained::Strained;
use crate::domain::world::World;
use crate::law::material::MaterialLaw;

/// Response times over which the rate of a flow is learnt.
const MEMORY: f64 = 20.0;

/// The velocity gradient of the cell, and the axes of it that follow a stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellDrive<S: Space> {
    /// L, 1/s.
    pub gradient: S::Tensor,
    pub servo: Option<StressServo>,
}

/// Axes whose rate of stretch follows a stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressServo {
    /// Normal stress per axis, Pa, tension positive.
    pub stress: [Option<f64>; 3],
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
    Contacts { gain: f64 },
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
    pub fn is_at_rest(&self) -> bool {
        self.gradient == S::Tensor::zero() && self.servo.is_none()
    }
}

impl<S: Space, L: MaterialLaw<S>> World<'_, S, L> {
    /// The velocity gradient over the coming drift, after an evaluation.
    pub(crate) fn gradient_wanted(&mut self) -> Result<S::Tensor, Error> {
        let drive = self.settings.drive;
        let Some(servo) = drive.servo else { return Ok(drive.gradient) };
        if !self.step.is_multiple_of(servo.interval) {
            return Ok(self.assembly.cell.gradient);
        }
        let sums = self.strained()?;
        let volume = self.assembly.cell.volume() * servo.depth;
        let between = servo.interval as f64 * self.settings.dt;
        let bears = (0..S::DIMENSION).any(|axis| sums.springs[axis] > 0.0 || sums.dashpots[axis] > 0.0);
        let mut gradient = drive.gradient;
        for axis in 0..S::DIMENSION {
            let Some(target) = servo.stress[axis] else { continue };
            let diagonal = axis * S::DIMENSION + axis;
            let missing = target - sums.moment[diagonal] / volume;
            let resistance = [sums.springs[axis] / volume, sums.dashpots[axis] / volume];
            let [rate, learns] = servo.response.to(missing, resistance, between);
            if !bears {
                self.assembly.cell.learnt[axis] = 0.0;
            }
            let wanted = rate + self.assembly.cell.learnt[axis];
            gradient[diagonal] = wanted.clamp(-servo.rate_max, servo.rate_max);
            if gradient[diagonal] == wanted {
                self.assembly.cell.learnt[axis] += learns;
            }
            self.missed.squares[axis] += missing * missing;
        }
        self.missed.looks += 1;
        Ok(gradient)
    }

    /// Sums over all contacts of the world at the evaluation just done. Within a block rows are summed in their order, blocks
    /// exactly.
    fn strained(&self) -> Result<Strained<S>, Error> {
        let (law, grains, cell) = (self.law(), &self.assembly.grains, &self.assembly.cell);
        let mut sums = ExactSum::<15>::new();
        let [of_springs, of_dashpots] = [S::Tensor::COMPONENTS, S::Tensor::COMPONENTS + S::DIMENSION];
        let mut add = |part: &Strained<S>| {
            (0..S::Tensor::COMPONENTS).for_each(|component| sums.add(component, part.moment[component]));
            for axis in 0..S::DIMENSION {
                sums.add(of_springs + axis, part.springs[axis]);
                sums.add(of_dashpots + axis, part.dashpots[axis]);
            }
        };
        for range in &self.subdomain.grain_ranges {
            let mut block = Strained::zero();
            for row in range.clone() {
                let part = self.assembly.contacts.strained(law, grains, cell, row);
                block.moment += part.moment;
                block.springs += part.springs;
                block.dashpots += part.dashpots;
            }
            add(&block);
        }
        self.assembly.walls.strained(law, grains, cell).for_each(|part| add(&part));
        let total = self.reduce(sums)?;
        let mut strained = Strained::<S>::zero();
        for (component, sum) in total.iter().take(S::Tensor::COMPONENTS).enumerate() {
            strained.moment[component] = *sum;
        }
        for axis in 0..S::DIMENSION {
            strained.springs[axis] = total[of_springs + axis];
            strained.dashpots[axis] = total[of_dashpots + axis];
        }
        Ok(strained)
    }

    /// Love-Weber sum over all contacts of the world, J: minus force times branch at the positions and velocities of now, with
    /// the forces of the coming evaluation. Over the volume it is the mean stress, tension positive. Within a block rows are
    /// summed in their order, blocks exactly.
    pub fn contact_moment(&mut self) -> Result<S::Tensor, Error> {
        self.refresh_ghosts();
        let law = self.law();
        let times = self.contact_times();
        let walls =
            self.assembly.walls.bearings(law, &self.assembly.grains, (&self.bodies, &self.assembly.cell), times);
        let walls = walls.map(|bearing| bearing.moment() * bearing.weight);
        self.sum_moments(|row| self.assembly.contacts.moment(law, &self.assembly.grains, row, times), walls)
    }

    fn sum_moments(
        &self,
        of_row: impl Fn(usize) -> S::Tensor,
        of_walls: impl Iterator<Item = S::Tensor>,
    ) -> Result<S::Tensor, Error> {
        let mut sums = ExactSum::<9>::new();
        let mut add = |moment: &S::Tensor| {
            for component in 0..S::Tensor::COMPONENTS {
                sums.add(component, moment[component]);
            }
        };
        for range in &self.subdomain.grain_ranges {
            let mut block = S::Tensor::zero();
            for row in range.clone() {
                block += of_row(row);
            }
            add(&block);
        }
        of_walls.for_each(|moment| add(&moment));
        let total = self.reduce(sums)?;
        let mut moment = S::Tensor::zero();
        for component in 0..S::Tensor::COMPONENTS {
            moment[component] = total[component];
        }
        Ok(moment)
    }
}
