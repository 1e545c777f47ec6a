//! Grains that have turned into points, as they stood then, so that they can come back where the continuum shears.

use crate::base::space::{Plane, Space};
use crate::dem::grains::GrainRow;

/// All grains of a run as they stood when some of them last turned into points, and those that had done so before, which have gone the continuum's way since. On rank 0 alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeptGrains {
    /// In the order of their ids, with origins and images as in the run.
    pub grains: Vec<GrainRow<Plane>>,
    /// Displacements of the bodies then, m.
    pub seats: Vec<<Plane as Space>::Vector>,
}

impl KeptGrains {
    /// Whether no grains have been kept.
    pub fn is_empty(&self) -> bool {
        self.grains.is_empty()
    }
}
