//! Hencky hyperelasticity: Hencky (1933); de Souza Neto, Peric and Owen, Computational Methods for Plasticity (2008), 13.3.
//!
//! Tension positive; tau is the Kirchhoff stress, b the left Cauchy-Green tensor, d the dimension.
//!
//! ```text
//! eps = ln(b)/2,  tau = K tr(eps) I + 2 G dev(eps),  W = K tr(eps)^2/2 + G dev(eps):dev(eps),  dev = . - tr(.)/d I
//! ```
//!
//! Elastic at any stretch: a closed path does no work. In the plane K is the plane's (see [`MaterialLaw`]) and the stress
//! across it that of plane strain, `(K - G) tr(eps)`.

use super::{MaterialLaw, MaterialMemory, alone};
use crate::base::lane::Real;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Space, Words};
use crate::base::symmetric::Symmetric;
use crate::numbers;

/// Isotropic and linear between Kirchhoff stress and logarithmic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hencky {
    /// K, Pa.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
}

/// State of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct HenckyMemory<S: Space> {
    /// `b - I`.
    pub strain: S::Symmetric,
    /// Solid volume fraction without stress.
    pub fraction_free: f64,
}

numbers!(impl[S: Space] HenckyMemory[S] { strain: S::Symmetric, fraction_free: f64 });

impl<S: Space> Record for HenckyMemory<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("strain", self.strain.as_mut_slice());
        visitor.f64s("fraction_free", std::slice::from_mut(&mut self.fraction_free));
    }
}

impl<S: Space> MaterialMemory for HenckyMemory<S> {
    fn plastic_strain(&self) -> f64 {
        0.0
    }
    fn fraction(&self) -> f64 {
        self.fraction_free / self.strain.volume_squared().sqrt()
    }
}

/// `K tr(eps) I + 2 G dev(eps)`.
#[inline(always)]
pub(super) fn isotropic_stress<R: Real, T: Symmetric<R>>(bulk: f64, shear: f64, strain: &T) -> T {
    let volume = strain.trace();
    *strain * R::splat(2.0 * shear) + T::isotropic(R::splat(bulk - 2.0 / T::DIMENSION as f64 * shear) * volume)
}

/// The strain of which [`isotropic_stress`] makes `stress`.
pub(super) fn isotropic_strain<T: Symmetric>(bulk: f64, shear: f64, stress: &T) -> T {
    let mean = stress.trace() / T::DIMENSION as f64;
    stress.deviator() * (0.5 / shear) + T::isotropic(mean / (bulk * T::DIMENSION as f64))
}

/// `K + 2 (1 - 1/d) G`: against uniaxial strain.
pub(super) fn p_wave_modulus<S: Space>(bulk: f64, shear: f64) -> f64 {
    bulk + (2.0 - 2.0 / S::DIMENSION as f64) * shear
}

impl<S: Space> MaterialLaw<S> for Hencky {
    type Memory = HenckyMemory<S>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> HenckyMemory<S> {
        let strain = isotropic_strain(self.bulk_modulus, self.shear_modulus, &S::Symmetric::of(stress));
        let strain = (strain * 2.0).exponential();
        HenckyMemory { strain, fraction_free: fraction * strain.volume_squared().sqrt() }
    }

    fn update_counted(&self, gradient: &S::Tensor, dt: f64, memory: &mut HenckyMemory<S>, work: &mut f64) -> S::Tensor {
        alone::<S, _>(self, gradient, dt, memory, work)
    }

    #[inline(always)]
    fn update_lanes<R: Real>(
        &self,
        gradient: &S::TensorOf<R>,
        dt: f64,
        memory: &mut [R],
        _: &mut R,
    ) -> S::SymmetricOf<R> {
        let strain = S::SymmetricOf::<R>::of_words(memory).pushed(&gradient.scaled(R::splat(dt)));
        strain.to_words(memory);
        isotropic_stress(self.bulk_modulus, self.shear_modulus, &strain.half_logarithm())
    }

    fn stress(&self, memory: &HenckyMemory<S>) -> S::Tensor {
        isotropic_stress(self.bulk_modulus, self.shear_modulus, &memory.strain.half_logarithm()).tensor()
    }

    fn out_of_plane(&self, memory: &HenckyMemory<S>) -> f64 {
        if S::DIMENSION == 3 {
            return 0.0;
        }
        (self.bulk_modulus - self.shear_modulus) * memory.strain.half_logarithm().trace()
    }

    fn elastic_energy(&self, memory: &HenckyMemory<S>) -> f64 {
        let strain = memory.strain.half_logarithm();
        let volume = strain.trace();
        0.5 * self.bulk_modulus * volume * volume + self.shear_modulus * strain.deviator().square()
    }

    fn p_wave_modulus(&self) -> f64 {
        p_wave_modulus::<S>(self.bulk_modulus, self.shear_modulus)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }
}
