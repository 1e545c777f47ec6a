//! The material law of a job: the list of them.

use super::elastic::Elastic;
use super::{CriticalConstants, CriticalDruckerPrager, Hencky, LinearElastic, MaterialLaw};
use crate::base::keys::{Form, text, variant};
use crate::base::space::Space;

/// What a law says of itself, whatever the space.
pub trait Described {
    fn keys(&mut self, form: &mut dyn Form);
    /// K, Pa, where the mean stress is the mean over that many axes: lambda + 2 G/axes.
    fn bulk_modulus_in(&self, axes: usize) -> f64;
    /// G, Pa.
    fn shear_modulus(&self) -> f64;
    /// Solid volume fraction that points start with, of a law that knows one.
    fn fraction(&self) -> Option<f64> {
        None
    }
    /// Whether it flows plastically.
    fn yields(&self) -> bool {
        false
    }
}

/// A law with its constants; each law's file beside this one has its equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConstitutiveLaw {
    /// Isotropic and linear in an objective rate.
    LinearElastic(Elastic),
    /// Isotropic and linear between Kirchhoff stress and logarithmic strain.
    Hencky(Elastic),
    /// Chen et al. (2021), 2.2.
    CriticalDruckerPrager(CriticalConstants),
}

/// Work that does not care which law it is done with.
pub trait ForAnyMaterial<S: Space> {
    type Outcome;
    fn with<L: MaterialLaw<S>>(self, law: L) -> Self::Outcome;
}

impl ConstitutiveLaw {
    /// The laws as jobs name them, with constants before any is read.
    pub const LAWS: [(&'static str, Self); 3] = {
        let elastic = Elastic { bulk_modulus: 0.0, shear_modulus: 0.0 };
        [
            ("linear_elastic", Self::LinearElastic(elastic)),
            ("hencky", Self::Hencky(elastic)),
            ("critical_drucker_prager", Self::CriticalDruckerPrager(CriticalConstants::CHEN)),
        ]
    };

    /// Does the work with the law: the one place where these are told apart.
    pub fn apply<S: Space, W: ForAnyMaterial<S>>(&self, work: W) -> W::Outcome {
        let (bulk_modulus, shear_modulus) = (self.described().bulk_modulus_in(S::DIMENSION), self.shear_modulus());
        match self {
            Self::LinearElastic(_) => work.with(LinearElastic { bulk_modulus, shear_modulus }),
            Self::Hencky(_) => work.with(Hencky { bulk_modulus, shear_modulus }),
            Self::CriticalDruckerPrager(law) => work.with(CriticalDruckerPrager::of(law)),
        }
    }

    fn described(&self) -> &dyn Described {
        match self {
            Self::LinearElastic(law) | Self::Hencky(law) => law,
            Self::CriticalDruckerPrager(law) => law,
        }
    }

    fn described_mut(&mut self) -> &mut dyn Described {
        match self {
            Self::LinearElastic(law) | Self::Hencky(law) => law,
            Self::CriticalDruckerPrager(law) => law,
        }
    }

    /// Its keys under `[material]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let about = "the material law: linear_elastic, hencky or critical_drucker_prager";
        let key = text("law", about, "\"hencky\"");
        variant(form, self, "material law", key, &Self::LAWS, |law, form| law.described_mut().keys(form));
    }

    /// The constants of the critical-state law, where it is that.
    pub fn critical(&self) -> Option<&CriticalConstants> {
        match self {
            Self::CriticalDruckerPrager(law) => Some(law),
            Self::LinearElastic(_) | Self::Hencky(_) => None,
        }
    }

    /// Whether it flows plastically.
    pub fn yields(&self) -> bool {
        self.described().yields()
    }

    /// Solid volume fraction that points start with, of a law that knows one.
    pub fn fraction(&self) -> Option<f64> {
        self.described().fraction()
    }

    /// G, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.described().shear_modulus()
    }

    /// Modulus of one-dimensional strain, Pa, which carries the fastest wave: lambda + 2 G.
    pub fn modulus_longitudinal(&self, axes: usize) -> f64 {
        self.described().bulk_modulus_in(axes) + 2.0 * (1.0 - 1.0 / axes as f64) * self.shear_modulus()
    }

    /// The stiffest answer of a point that nothing around it holds, Pa: `lambda + 2 G` with lambda once more for every other
    /// axis, or 2 G.
    pub fn modulus_free(&self, axes: usize) -> f64 {
        let (along, shear) = (self.modulus_longitudinal(axes), self.shear_modulus());
        (along + (axes - 1) as f64 * (along - 2.0 * shear)).max(2.0 * shear)
    }
}
