//! No continuum: the material of worlds that consist of grains alone.

use super::{MaterialLaw, MaterialMemory};
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::numbers;

/// No stress, whatever the deformation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Absent;

/// Nothing to remember.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Nothing;

numbers!(impl[] Nothing[] {});

impl Record for Nothing {
    fn visit(&mut self, _: &mut dyn Visitor) {}
}

impl MaterialMemory for Nothing {
    fn plastic_strain(&self) -> f64 {
        0.0
    }
    fn fraction(&self) -> f64 {
        0.0
    }
}

impl<S: Space> MaterialLaw<S> for Absent {
    type Memory = Nothing;

    fn start(&self, _: &S::Tensor, _: f64) -> Nothing {
        Nothing
    }
    fn update_counted(&self, _: &S::Tensor, _: f64, _: &mut Nothing, _: &mut f64) -> S::Tensor {
        S::Tensor::zero()
    }
    fn stress(&self, _: &Nothing) -> S::Tensor {
        S::Tensor::zero()
    }
    fn out_of_plane(&self, _: &Nothing) -> f64 {
        0.0
    }
    fn elastic_energy(&self, _: &Nothing) -> f64 {
        0.0
    }
    fn p_wave_modulus(&self) -> f64 {
        0.0
    }
    fn shear_modulus(&self) -> f64 {
        0.0
    }
}
