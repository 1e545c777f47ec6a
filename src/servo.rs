//! What deforms the cell: a given velocity gradient, and axes whose stretch keeps a normal stress.

use scree_partition::ExactSum;

use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::space::{Linear, Space};
use crate::world::World;

/// Steps between two looks of a servo at the stress.
const LOOK_EVERY: u64 = 10;

/// The velocity gradient of the cell, and the axes of it that follow a stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellDrive<S: Space> {
    /// L, 1/s.
    pub gradient: S::Tensor,
    pub servo: Option<StressServo>,
}

/// Along an axis with a target the rate of stretch follows the missing stress e = target - stress in proportion and by its
/// integral, within a limit:
///
/// ```text
/// L = e/viscosity + learnt,  d learnt/dt = e/(viscosity memory)
/// ```
///
/// The first brings the stress to the target as a Kelvin body would, the second keeps it there while the material flows.
/// At the limit nothing is learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressServo {
    /// Normal stress per axis, Pa, tension positive.
    pub stress: [Option<f64>; 3],
    /// Pa s.
    pub viscosity: f64,
    /// s.
    pub memory: f64,
    /// 1/s.
    pub rate_max: f64,
    /// Volume that the space's measure of the cell is multiplied with: the depth in the plane, one in space.
    pub depth: f64,
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

impl<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> World<'_, S, C, L> {
    pub(crate) fn gradient_wanted(&mut self) -> Result<S::Tensor, Error> {
        let drive = self.settings.drive;
        let Some(servo) = drive.servo else { return Ok(drive.gradient) };
        if !self.step.is_multiple_of(LOOK_EVERY) {
            return Ok(self.cell.gradient);
        }
        let stress = self.contact_moment()? * (1.0 / (self.cell.volume() * servo.depth));
        let mut gradient = drive.gradient;
        for axis in 0..S::DIMENSION {
            if let Some(target) = servo.stress[axis] {
                let diagonal = axis * S::DIMENSION + axis;
                let rate = (target - stress[diagonal]) / servo.viscosity;
                let wanted = rate + self.cell.learnt[axis];
                gradient[diagonal] = wanted.clamp(-servo.rate_max, servo.rate_max);
                if gradient[diagonal] == wanted {
                    self.cell.learnt[axis] += rate * LOOK_EVERY as f64 * self.settings.dt / servo.memory;
                }
            }
        }
        Ok(gradient)
    }

    /// Love-Weber sum over all contacts of the world, J: minus force times branch, with the forces of the last evaluation
    /// and the positions of now. Over the volume it is the mean stress, tension positive. Within a block rows are summed
    /// in their order, blocks exactly. Before the last step it must have been said that [`World::forces_wanted`].
    pub fn contact_moment(&self) -> Result<S::Tensor, Error> {
        if let Some(kept) = self.moment_kept {
            return Ok(kept);
        }
        assert!(self.step == 0 || self.contacts.keeps_forces(), "the forces of the last step were not wanted");
        let walls = self.walls.list.iter().map(|wall| {
            let branch = self.grains.hot[wall.row as usize].position - wall.shift - wall.point;
            -S::outer(&wall.force, &branch)
        });
        self.sum_moments(|row| -self.contacts.branch_sum(&self.grains, row), walls)
    }

    /// The same with the forces of the positions and velocities of now: what an observer sees between steps.
    pub fn contact_moment_now(&mut self) -> Result<S::Tensor, Error> {
        self.refresh_ghosts();
        let law = &self.settings.contact;
        let walls = self.walls.bearings(law, &self.grains, (&self.bodies, &self.cell));
        let walls = walls.map(|bearing| bearing.moment() * bearing.weight);
        self.sum_moments(|row| self.contacts.moment(law, &self.grains, row), walls)
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
        for range in &self.grain_ranges {
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
