//! Forces between two touching grains.

use crate::space::{Linear, Space};

mod linear_spring_dashpot;
pub use linear_spring_dashpot::LinearSpringDashpot;

/// Two overlapping grains as a law sees them: `a` has the lower id, the normal points from `b` to `a`.
#[derive(Clone, Copy, Debug)]
pub struct Touch<S: Space> {
    /// Unit normal from `b` to `a`.
    pub normal: S::Vector,
    /// Overlap d > 0, m.
    pub overlap: f64,
    /// (v_a - v_b).n, m/s: positive while the contact opens.
    pub velocity_normal: f64,
    /// Velocity of a's surface against b's in the tangent plane, m/s.
    pub velocity_tangential: S::Tangent,
    /// Time over which memory advances: the step, or zero at the very first evaluation of a run, s.
    pub advance: f64,
}

/// What a law answers: the force on `a`, as a normal number and a tangential vector, N.
#[derive(Clone, Copy, Debug)]
pub struct Answer<S: Space> {
    pub normal: f64,
    pub tangential: S::Tangent,
}

/// A contact law with memory.
pub trait ContactLaw<S: Space>: Copy + Send + Sync + 'static {
    /// What a contact remembers, blank where grains do not touch; a vector so that it can travel and be stored as numbers.
    type Memory: Linear;

    /// Force of `b` on `a`, and the memory after it.
    fn force(&self, touch: &Touch<S>, memory: &mut Self::Memory) -> Answer<S>;

    /// Elastic energy stored in the contact, J.
    fn elastic_energy(&self, overlap: f64, memory: &Self::Memory) -> f64;
}
