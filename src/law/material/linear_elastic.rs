//! Linear elasticity at finite strain, incrementally objective: Hughes and Winget, Int. J. Numer. Methods Eng. 15 (1980),
//! 1862.
//!
//! Tension positive; sigma is the Cauchy stress, J = det F, tau = J sigma the Kirchhoff stress that is returned. With the
//! increment of displacement's gradient h = L dt against the start of the step, and G against its middle:
//!
//! ```text
//! G = h (I + h/2)^-1,  d = (G + G^T)/2,  w = (G - G^T)/2,  Q = (I - w/2)^-1 (I + w/2)
//! sigma <- Q sigma Q^T + K tr(d) I + 2 G dev(d),  J <- J det(I + h)
//! ```
//!
//! A rotation, `I + h = R`, has d = 0 and Q = R: it turns the stress and does nothing else, by any angle but half a turn a
//! step. The law is a rate law: at large strain a closed path may do work (use [`super::Hencky`] where it must not), and
//! the elastic energy `J sigma:C^-1:sigma/2` is that of the stress. In the plane K is the plane's, and the stress across it
//! that of plane strain: it grows by `(K - G) tr(d)` and is not turned.

use super::hencky::{isotropic_strain, isotropic_stress, p_wave_modulus};
use super::{MaterialLaw, MaterialMemory};
use crate::base::record::{Record, Visitor};
use crate::base::space::Space;
use crate::base::symmetric::Symmetric;
use crate::numbers;

/// Isotropic and linear in an objective rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearElastic {
    /// K, Pa.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
}

/// State of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct LinearMemory<S: Space> {
    /// Cauchy stress, Pa.
    pub stress: S::Symmetric,
    /// In the plane the Cauchy stress across it, Pa; 0 in space.
    pub out_of_plane: f64,
    /// J since the start.
    pub volume_ratio: f64,
    /// Solid volume fraction at the start.
    pub fraction_start: f64,
}

impl<S: Space> Default for LinearMemory<S> {
    fn default() -> Self {
        Self { stress: S::Symmetric::default(), out_of_plane: 0.0, volume_ratio: 1.0, fraction_start: 0.0 }
    }
}

numbers!(impl[S: Space] LinearMemory[S] {
    stress: S::Symmetric,
    out_of_plane: f64,
    volume_ratio: f64,
    fraction_start: f64,
});

impl<S: Space> Record for LinearMemory<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("cauchy", self.stress.as_mut_slice());
        visitor.f64s("cauchy_out_of_plane", std::slice::from_mut(&mut self.out_of_plane));
        visitor.f64s("cauchy_volume_ratio", std::slice::from_mut(&mut self.volume_ratio));
        visitor.f64s("fraction_start", std::slice::from_mut(&mut self.fraction_start));
    }
}

impl<S: Space> MaterialMemory for LinearMemory<S> {
    fn plastic_strain(&self) -> f64 {
        0.0
    }
    fn fraction(&self) -> f64 {
        self.fraction_start / self.volume_ratio
    }
}

/// `(I - a/2)^-1`; a step that makes this singular turns the material inside out, and its J tells the guards.
fn half_step_inverse<S: Space>(a: &S::Tensor) -> S::Tensor {
    S::inverse(&(S::identity() - *a * 0.5)).unwrap_or_else(S::identity)
}

impl<S: Space> MaterialLaw<S> for LinearElastic {
    type Memory = LinearMemory<S>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> LinearMemory<S> {
        let stress = S::Symmetric::of(stress);
        let normal = (self.bulk_modulus - self.shear_modulus) * (0.5 * stress.trace() / self.bulk_modulus);
        let out_of_plane = if S::DIMENSION == 2 { normal } else { 0.0 };
        LinearMemory { stress, out_of_plane, volume_ratio: 1.0, fraction_start: fraction }
    }

    fn update_counted(&self, gradient: &S::Tensor, dt: f64, memory: &mut LinearMemory<S>, _: &mut f64) -> S::Tensor {
        let step = *gradient * dt;
        let middle = step * half_step_inverse::<S>(&-step);
        let spin = (middle - S::transpose(&middle)) * 0.5;
        let turn = half_step_inverse::<S>(&spin) * (S::identity() + spin * 0.5);
        let increment = S::Symmetric::of(&middle);
        let turned = turn * memory.stress.tensor() * S::transpose(&turn);
        memory.stress = S::Symmetric::of(&turned) + isotropic_stress(self.bulk_modulus, self.shear_modulus, &increment);
        if S::DIMENSION == 2 {
            memory.out_of_plane += (self.bulk_modulus - self.shear_modulus) * increment.trace();
        }
        memory.volume_ratio *= S::determinant(&(S::identity() + step));
        MaterialLaw::<S>::stress(self, memory)
    }

    fn stress(&self, memory: &LinearMemory<S>) -> S::Tensor {
        (memory.stress * memory.volume_ratio).tensor()
    }

    fn out_of_plane(&self, memory: &LinearMemory<S>) -> f64 {
        memory.out_of_plane * memory.volume_ratio
    }

    fn elastic_energy(&self, memory: &LinearMemory<S>) -> f64 {
        let strain = isotropic_strain(self.bulk_modulus, self.shear_modulus, &memory.stress);
        0.5 * memory.volume_ratio * memory.stress.contract(&strain)
    }

    fn p_wave_modulus(&self) -> f64 {
        p_wave_modulus::<S>(self.bulk_modulus, self.shear_modulus)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }
}
