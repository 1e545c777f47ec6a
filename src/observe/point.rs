//! What is told of a point beside its motion, in the series and in frames.

use crate::base::space::Space;
use crate::law::invariants::{Deformation, StressInvariants};
use crate::mpm::points::Hot;
use crate::mpm::stress::StressModel;
use crate::rve::{Rve, Scratch};

/// Names of what [`observed`] returns.
pub const OBSERVED: [&str; 8] = [
    "p",
    "q",
    "out_of_plane_stress",
    "volumetric_strain",
    "deviatoric_strain",
    "rotation",
    "fraction",
    "plastic_strain",
];

/// Mean and deviatoric Cauchy stress, in the plane those of the plane, as the laws have them, and the stress across it (Pa; 0 in
/// space), strains and rotation (rad) since the start
/// ([`crate::law::invariants`]), solid volume fraction and accumulated plastic strain.
pub fn observed<S: Space>(law: &dyn StressModel<S>, hot: &Hot<S>) -> [f64; OBSERVED.len()] {
    let ratio = 1.0 / hot.volume_ratio();
    let stress = StressInvariants::of::<S>(&(hot.kirchhoff() * ratio));
    let strain = Deformation::of::<S>(&hot.deformation);
    [
        stress.mean,
        stress.deviatoric,
        law.out_of_plane(&hot.memory) * ratio,
        strain.volumetric,
        strain.deviatoric,
        strain.rotation_angle,
        law.fraction(&hot.memory),
        law.plastic_strain(&hot.memory),
    ]
}

/// Names of what [`observed_of_rve`] returns.
pub const OBSERVED_OF_RVES: [&str; 9] = [
    "void_ratio",
    "coordination",
    "mechanical_coordination",
    "fabric_anisotropy",
    "fabric_direction",
    "grain_rotation",
    "unbalanced",
    "grains",
    "grain_steps",
];

/// Void ratio, contacts of a grain with and without such grains as have none or one, fabric anisotropy and in the plane the angle
/// of most contacts from x (rad), by how much grains have turned in the mean (rad; `rotation` is that of the point), I_uf, grains and
/// their steps.
pub fn observed_of_rve<S: Space>(rve: &Rve<S>, scratch: &mut Scratch<S>) -> [f64; OBSERVED_OF_RVES.len()] {
    let seen = rve.observe(scratch);
    [
        rve.void_ratio(),
        seen.fabric.coordination,
        seen.fabric.mechanical,
        seen.fabric.anisotropy(),
        seen.fabric.direction(),
        rve.grain_rotation(),
        seen.unbalanced.unwrap_or_default(),
        rve.grains() as f64,
        rve.state().steps as f64,
    ]
}
