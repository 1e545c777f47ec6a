//! What is told of a point beside its motion, in the series and in frames.

use crate::law::invariants::{Deformation, StressInvariants};
use crate::law::material::{MaterialLaw, MaterialMemory};
use crate::mpm::points::Hot;
use crate::space::Space;

/// Names of what [`observed`] returns.
pub const OBSERVED: [&str; 7] =
    ["p", "q", "volumetric_strain", "deviatoric_strain", "rotation", "fraction", "plastic_strain"];

/// Mean and deviatoric Cauchy stress (Pa, of all three axes), strains and rotation (rad) since the start
/// ([`crate::law::invariants`]), packing fraction and accumulated plastic strain.
pub fn observed<S: Space, L: MaterialLaw<S>>(law: &L, hot: &Hot<S, L::Memory>) -> [f64; OBSERVED.len()] {
    let ratio = 1.0 / hot.volume_ratio();
    let stress = StressInvariants::of_body::<S>(&(hot.kirchhoff() * ratio), law.out_of_plane(&hot.memory) * ratio);
    let strain = Deformation::of::<S>(&hot.deformation);
    [
        stress.mean,
        stress.deviatoric,
        strain.volumetric,
        strain.deviatoric,
        strain.rotation_angle,
        hot.memory.fraction(),
        hot.memory.plastic_strain(),
    ]
}
