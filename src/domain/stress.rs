//! Sums over all contacts of the world: what a control of stress needs, and the mean stress.

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::dem::strained::Strained;
use crate::domain::world::World;

impl<S: Space> World<'_, S> {
    /// At the evaluation just done.
    pub(crate) fn strained(&self) -> Result<Strained<S>, Error> {
        let sums = self.assembly.strained(&self.settings.grains, &self.subdomain.grain_ranges);
        Ok(Strained::of_sums(&self.reduce(sums)?))
    }

    /// Love-Weber sum, J: minus force times branch at the positions and velocities of now, with the forces of the coming evaluation.
    /// Over the volume it is the mean stress, tension positive.
    pub fn contact_moment(&mut self) -> Result<S::Tensor, Error> {
        self.refresh_ghosts();
        let (of, together) = (&self.settings.grains, &self.subdomain.grain_ranges);
        let total = self.reduce(self.assembly.moments(of, self.step, &self.bodies, together))?;
        let mut moment = S::Tensor::zero();
        (0..S::Tensor::COMPONENTS).for_each(|component| moment[component] = total[component]);
        Ok(moment)
    }
}
