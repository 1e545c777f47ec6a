//! No contact: the law of worlds that consist of points alone.

use super::{Answer, ContactLaw, Springs, Touch};
use crate::base::lane::Real;
use crate::base::space::{Components, Space, Words};

/// No force, whatever touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Absent;

impl<S: Space> ContactLaw<S> for Absent {
    /// Always zero; tables want a width.
    type Memory<R: Real> = Components<R, 1>;

    #[inline(always)]
    fn force<R: Real>(&self, _: &Touch<S, R>, _: &mut Self::Memory<R>) -> Answer<S, R> {
        Answer { normal: R::splat(0.0), tangential: Words::zero(), moment: Words::zero() }
    }
    fn springs(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> Answer<S, f64> {
        self.force(touch, &mut memory.clone())
    }
    fn stiffness(&self, _: [f64; 2], _: [f64; 2], _: f64) -> Springs {
        Springs::default()
    }
    fn friction_limit(&self, _: &Touch<S, f64>, _: f64) -> f64 {
        0.0
    }
    fn elastic_energy(&self, _: &Touch<S, f64>, _: &Self::Memory<f64>) -> f64 {
        0.0
    }
}
