//! What is to be simulated, checked once and trusted afterwards (invariant 5).
//!
//! Two stages: [`raw`] is what the operator typed, positions and units included; [`Job`] is what it means, in SI units,
//! with every default filled in: a [`Scenario`] of planar shear, an [`Assembly`] of grains in a cell, or a continuum on a grid ([`Mpm`]). Nothing after this
//! module sees a string, an option or a sentinel.

pub(crate) mod document;

use crate::base::keys::{Form, choose, text};
use crate::couple::zone::ZoneLife;

pub mod assembly;
pub mod derived;
pub mod figures;
mod motion;
pub mod mpm;
mod output;
pub mod raw;
pub mod reference;
mod renamed;
mod resolve;
pub mod schema;
mod shear;
mod slots;
pub mod stable;
pub mod templates;
mod tree;
pub mod widen;
mod write;

pub use crate::job::document::Job;
pub use assembly::Assembly;
pub use mpm::Mpm;
pub use output::Output;
pub(crate) use resolve::{BLOCK_OF_DISCS, BYPASS, digits_below, margin_in_words, significant};
pub use shear::{Continuum, Decomposition, Grains, Loading, Packing, Scenario, Specimen, Time, WeakRegion};
pub(crate) use write::listed;

/// What a specimen is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Continuum first; grains where the oracle finds a persistent shear band (Chen et al. 2021).
    Hybrid,
    /// Grains alone: the ground truth.
    Dem,
    /// Continuum alone: the mesh-dependent baseline.
    Mpm,
    /// Continuum whose material is a grain assembly at every point (Liang & Zhao 2019).
    MpmDem,
    /// Continuum of elements alone.
    Fem,
    /// Elements with a grain assembly each (Liu et al. 2016).
    FemDem,
}

impl Method {
    pub(crate) const NAMES: [(&'static str, Self); 6] = [
        ("hybrid", Self::Hybrid),
        ("dem", Self::Dem),
        ("mpm", Self::Mpm),
        ("mpm_dem", Self::MpmDem),
        ("fem", Self::Fem),
        ("fem_dem", Self::FemDem),
    ];

    fn keys(&mut self, form: &mut dyn Form, about: &'static str) {
        choose(form, self, "method", text("method", about, "\"hybrid\""), &Self::NAMES);
    }

    /// As it is written in a job.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Dem => "dem",
            Self::Mpm => "mpm",
            Self::MpmDem => "mpm_dem",
            Self::Fem => "fem",
            Self::FemDem => "fem_dem",
        }
    }

    /// Whether grains are simulated among bodies, at some time at least; those of RVEs do not count.
    pub fn has_grains(self) -> bool {
        matches!(self, Self::Hybrid | Self::Dem)
    }

    /// Whether there is a continuum, of points or of elements.
    pub fn has_points(self) -> bool {
        !matches!(self, Self::Dem)
    }

    /// Whether all of the material is grains at the start of a run whose zone has that life.
    pub fn begins_as_grains(self, life: &ZoneLife) -> bool {
        self == Self::Dem || self == Self::Hybrid && life.is_everywhere
    }

    /// Whether the material is a grain assembly at every point.
    pub fn has_rves(self) -> bool {
        matches!(self, Self::MpmDem | Self::FemDem)
    }
}
