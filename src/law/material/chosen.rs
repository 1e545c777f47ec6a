//! The material law of a job: the list of them.

use super::elastic::Elastic;
use super::{
    CriticalConstants, CriticalDruckerPrager, GrainAssembly, GrainModuli, Hencky, LinearElastic, MaterialLaw,
    MobilisedConstants, MobilisedFriction,
};
use crate::base::keys::{Form, Key, RATIO, Range, number, text, variant};
use crate::base::space::Space;

/// What a law says of itself, whatever the space.
pub trait Described {
    /// Its keys under `[material]`.
    fn keys(&mut self, form: &mut dyn Form);
    /// K, Pa, where the mean stress is the mean over that many axes: lambda + 2 G/axes.
    fn bulk_modulus_in(&self, axes: usize) -> f64;
    /// G, Pa.
    fn shear_modulus(&self) -> f64;
    /// Solid volume fraction that points start with, of a law that knows one and has been told.
    fn fraction(&self) -> Option<f64> {
        None
    }
    /// Tells it [`Self::fraction`], or with none forgets it; of no effect on a law that knows none.
    fn set_fraction(&mut self, _fraction: Option<f64>) {}
    /// The same where the job does not say and nothing looks at it.
    fn fraction_by_default(&self) -> Option<f64> {
        None
    }
    /// Whether it flows plastically.
    fn yields(&self) -> bool {
        false
    }
    /// Why it cannot start from a solid volume fraction, if it cannot.
    fn objection(&self, _axes: usize, _fraction: f64) -> Option<Objection> {
        None
    }
    /// The least and the largest `k0` of a stress `-overburden` (Pa) along one axis and k0 times it along the others that it
    /// bears at a solid volume fraction, of a law that does not bear all.
    fn k0(&self, _axes: usize, _fraction: f64, _overburden: f64) -> Option<[f64; 2]> {
        None
    }
}

/// The key of [`Described::fraction`], of every law that has it.
pub(super) const FRACTION: Key =
    number("fraction", "the solid volume fraction that points start with", RATIO, Range::open(0.0, 1.0), "0.83")
        .required("unless a packing tells it");

/// What is wrong with constants of a law, and the key of `[material]` that is told of it; of `fraction` a region may have its
/// own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Objection {
    /// A key of `[material]`.
    pub key: &'static str,
    /// After the key and its value: what is wrong, and the remedy.
    pub problem: String,
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
    /// With friction that plastic shear mobilises.
    MobilisedFriction(MobilisedConstants),
    /// A grain assembly at every point (Liang & Zhao 2019).
    Grains(GrainModuli),
}

/// Work that does not care which law it is done with.
pub trait ForAnyMaterial<S: Space> {
    /// What comes of it.
    type Outcome;
    /// Does it with this law.
    fn with<L: MaterialLaw<S>>(self, law: L) -> Self::Outcome;
}

impl ConstitutiveLaw {
    /// The laws as jobs name them, with constants before any is read.
    pub const LAWS: [(&'static str, Self); 5] = {
        let elastic = Elastic { bulk_modulus: 0.0, shear_modulus: 0.0 };
        [
            ("linear_elastic", Self::LinearElastic(elastic)),
            ("hencky", Self::Hencky(elastic)),
            ("critical_drucker_prager", Self::CriticalDruckerPrager(CriticalConstants::CHEN)),
            ("mobilised_friction", Self::MobilisedFriction(MobilisedConstants::DISCS)),
            ("grains", Self::Grains(GrainModuli { bulk_modulus: 0.0, shear_modulus: 0.0 })),
        ]
    };

    /// Does the work with the law: the one place where these are told apart.
    pub fn apply<S: Space, W: ForAnyMaterial<S>>(&self, work: W) -> W::Outcome {
        let (bulk_modulus, shear_modulus) = (self.described().bulk_modulus_in(S::DIMENSION), self.shear_modulus());
        match self {
            Self::LinearElastic(_) => work.with(LinearElastic { bulk_modulus, shear_modulus }),
            Self::Hencky(_) => work.with(Hencky { bulk_modulus, shear_modulus }),
            Self::CriticalDruckerPrager(law) => work.with(CriticalDruckerPrager::of(law)),
            Self::MobilisedFriction(law) => work.with(MobilisedFriction::of(law)),
            Self::Grains(moduli) => work.with(GrainAssembly(*moduli)),
        }
    }

    fn described(&self) -> &dyn Described {
        match self {
            Self::LinearElastic(law) | Self::Hencky(law) => law,
            Self::CriticalDruckerPrager(law) => law,
            Self::MobilisedFriction(law) => law,
            Self::Grains(moduli) => moduli,
        }
    }

    fn described_mut(&mut self) -> &mut dyn Described {
        match self {
            Self::LinearElastic(law) | Self::Hencky(law) => law,
            Self::CriticalDruckerPrager(law) => law,
            Self::MobilisedFriction(law) => law,
            Self::Grains(moduli) => moduli,
        }
    }

    /// Its keys under `[material]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let about = "the material law: linear_elastic, hencky, critical_drucker_prager, mobilised_friction or grains (with method = \"mpm_dem\" or \"fem_dem\")";
        let key = text("law", about, "\"hencky\"");
        variant(form, self, "material law", key, &Self::LAWS, |law, form| law.described_mut().keys(form));
    }

    /// The constants of the critical-state law, where it is that: calibration begins from them.
    pub fn critical(&self) -> Option<&CriticalConstants> {
        match self {
            Self::CriticalDruckerPrager(law) => Some(law),
            _ => None,
        }
    }

    /// The names of the laws that flow plastically, for a sentence; they are those that know a solid volume fraction.
    pub fn yielding() -> String {
        let names = Self::LAWS.iter().filter(|(_, law)| law.yields()).map(|(name, _)| format!("\"{name}\""));
        names.collect::<Vec<_>>().join(" or ")
    }

    /// Why the law cannot start from a solid volume fraction, if it cannot.
    pub fn objection(&self, axes: usize, fraction: f64) -> Option<Objection> {
        self.described().objection(axes, fraction)
    }

    /// See [`Described::k0`].
    pub fn k0(&self, axes: usize, fraction: f64, overburden: f64) -> Option<[f64; 2]> {
        self.described().k0(axes, fraction, overburden)
    }

    /// K, Pa, where the mean stress is the mean over that many axes.
    pub fn bulk_modulus(&self, axes: usize) -> f64 {
        self.described().bulk_modulus_in(axes)
    }

    /// Whether it flows plastically.
    pub fn yields(&self) -> bool {
        self.described().yields()
    }

    /// Solid volume fraction that points start with, of a law that knows one and has been told.
    pub fn fraction(&self) -> Option<f64> {
        self.described().fraction()
    }

    /// The same where the job does not say and nothing looks at it.
    pub fn fraction_by_default(&self) -> Option<f64> {
        self.described().fraction_by_default()
    }

    /// Of a law that knows a solid volume fraction, with this one at the start, or with one that it has not been told.
    pub fn with_fraction(mut self, fraction: impl Into<Option<f64>>) -> Self {
        self.described_mut().set_fraction(fraction.into());
        self
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
