//! What a change of a zone may not change: mass and momentum of the whole world.

use crate::base::error::Error;
use crate::domain::accounts::conservation::Holdings;
use crate::prepare::sheared::PlanarWorld;

/// Of which mass, and of which of all motion, whichever way it goes, a change may not exceed this share.
const ROUND_OFF: f64 = 1e-10;

/// Before a change.
pub(super) struct Account {
    mass: f64,
    momentum: [f64; 2],
    /// Sum of the momenta's magnitudes, N s.
    motion: f64,
}

/// Before and after it: kg, and N s in x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeforeAndAfter {
    /// kg, before and after.
    pub mass: [f64; 2],
    /// N s, before and after; along x and y each.
    pub momentum: [[f64; 2]; 2],
}

impl Account {
    /// Collective.
    pub fn open(world: &mut PlanarWorld) -> Result<Self, Error> {
        let Holdings { mass, momentum: [x, y, _], motion, .. } = world.holdings()?;
        Ok(Self { mass, momentum: [x, y], motion })
    }

    /// What was kept of it; an error where not all was, to round-off. Collective.
    pub fn close(self, world: &mut PlanarWorld, what: &str) -> Result<BeforeAndAfter, Error> {
        let after = Self::open(world)?;
        let kept = BeforeAndAfter { mass: [self.mass, after.mass], momentum: [self.momentum, after.momentum] };
        let off = |axis: usize| (after.momentum[axis] - self.momentum[axis]).abs();
        let motion = self.motion.max(after.motion);
        if (after.mass - self.mass).abs() <= ROUND_OFF * self.mass && off(0).max(off(1)) <= ROUND_OFF * motion {
            return Ok(kept);
        }
        Err(Error::Run(format!(
            "step {}: {what} changed the mass from {:e} to {:e} kg or the momentum from {:?} to {:?} N s, which must not happen: please report this",
            world.step, self.mass, after.mass, self.momentum, after.momentum
        )))
    }
}
