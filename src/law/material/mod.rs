//! Stress from deformation inside a continuum.

use crate::record::Record;
use crate::space::Space;

mod absent;
mod critical_drucker_prager;
pub use absent::{Absent, Nothing};
pub use critical_drucker_prager::{CriticalDruckerPrager, CriticalMemory};

/// A material law with a memory per material point, so that an assembly of grains can be one as well.
pub trait MaterialLaw<S: Space>: Clone + Send + Sync + 'static {
    type Memory: MaterialMemory;

    /// Memory of a point at isotropic pressure `pressure` (Pa, positive in compression) and packing fraction `fraction`.
    fn start(&self, pressure: f64, fraction: f64) -> Self::Memory;

    /// Carries the memory over one step with velocity gradient `gradient` (1/s) and returns the Kirchhoff stress, Pa,
    /// tension positive.
    fn update(&self, gradient: &S::Tensor, dt: f64, memory: &mut Self::Memory) -> S::Tensor;

    /// Kirchhoff stress of a memory as it is, Pa.
    fn stress(&self, memory: &Self::Memory) -> S::Tensor;

    /// Elastic energy per initial volume, J/m3.
    fn elastic_energy(&self, memory: &Self::Memory) -> f64;
}

/// What every material memory can say of itself; as a [`Record`] it travels and is stored.
pub trait MaterialMemory: Record + Copy + Default + Send + Sync + std::fmt::Debug + PartialEq + 'static {
    /// Accumulated plastic strain, the integral of |deps_p/dt|.
    fn plastic_strain(&self) -> f64;
    /// Packing fraction that the law works with.
    fn fraction(&self) -> f64;
}
