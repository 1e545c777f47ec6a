//! Forces between two touching grains. A law is one file here and its lines in the list of [`chosen`]; [`rolling`] and [`adhesion`] are
//! parts that go with any of them. A law is written once over [`Real`], chosen once per pass, and never branches within one.

use std::fmt::Debug;

use crate::base::lane::Real;
use crate::base::space::{Space, Words};

mod absent;
pub mod adhesion;
pub mod chosen;
mod constants;
mod elastic_rolling;
mod hertz_mindlin;
mod linear_cohesive;
mod linear_spring_dashpot;
mod memory;
mod normal_force;
pub mod rolling;
mod springs;

pub use absent::Absent;
pub use adhesion::Adhesion;
pub use chosen::{Contact, Described, Force};
pub use elastic_rolling::{ElasticRolling, Sliding};
pub use hertz_mindlin::{HertzMindlin, TangentialForce};
pub use linear_cohesive::LinearCohesive;
pub use linear_spring_dashpot::LinearSpringDashpot;
pub use memory::Memory;
pub use normal_force::NormalForce;
pub use rolling::RollingResistance;
pub use springs::{Springs, Stiffening};

/// Two grains near each other as a law sees them: `a` has the lower id, the normal points from `b` to `a`. Against a body
/// `b` is the body.
#[derive(Clone, Copy, Debug)]
pub struct Touch<S: Space, R: Real> {
    /// Unit normal from `b` to `a`.
    pub normal: S::VectorOf<R>,
    /// Overlap d, m; negative where the two are apart.
    pub overlap: R,
    /// m; of a flat body beyond all bounds ([`FLAT`]).
    pub radius_a: R,
    /// m; of a flat body [`FLAT`].
    pub radius_b: R,
    /// kg; of what a body moves beyond all bounds ([`FLAT`]).
    pub mass_a: R,
    /// kg; of what a body moves [`FLAT`].
    pub mass_b: R,
    /// (v_a - v_b).n, m/s: positive while the contact opens.
    pub velocity_normal: R,
    /// Velocity of a's centre against b's in the tangent plane, m/s.
    pub velocity_centres: S::TangentOf<R>,
    /// Velocity of a's surface against b's in the tangent plane, with full radii, m/s.
    pub velocity_tangential: S::TangentOf<R>,
    /// Spin of `a` against `b`, rad/s.
    pub spin_relative: S::SpinOf<R>,
    /// Angle about the normal that both turned through together since the last step, rad.
    pub twist: R,
    /// Time over which memory advances: the step, or zero at the very first evaluation of a run, s.
    pub advance: R,
}

/// Radius that stands for a flat body, m: so large that a harmonic mean with it rounds to twice the other radius. And the mass,
/// kg, of what contacts do not move.
pub const FLAT: f64 = 1e30;

/// What a law answers for `a`; `b` gets the opposite.
#[derive(Clone, Copy, Debug)]
pub struct Answer<S: Space, R: Real> {
    /// N; repulsive positive.
    pub normal: R,
    /// In the tangent plane, N.
    pub tangential: S::TangentOf<R>,
    /// Resistance to rolling, N m, beside the torque of the tangential force.
    pub moment: S::SpinOf<R>,
}

/// Work that does not care which law it is done with.
pub trait ForAnyLaw<S: Space> {
    /// What comes of it.
    type Outcome;
    /// Does it with this law.
    fn with<C: ContactLaw<S>>(self, law: &C) -> Self::Outcome;
}

/// A contact law with memory.
pub trait ContactLaw<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// What a contact remembers, zero where grains do not touch.
    type Memory<R: Real>: Words<R>;

    /// How far apart surfaces may be and still hold on to each other, m.
    fn reach(&self) -> f64 {
        0.0
    }

    /// Whether the contact exists; where it does not, there is no force and nothing is remembered.
    #[inline(always)]
    fn holds<R: Real>(&self, touch: &Touch<S, R>, _memory: &Self::Memory<R>) -> R::Mask {
        touch.overlap.above(R::splat(0.0))
    }

    /// Force of `b` on `a`, and the memory after it. Numbers where the contact does not hold are thrown away.
    fn force<R: Real>(&self, touch: &Touch<S, R>, memory: &mut Self::Memory<R>) -> Answer<S, R>;

    /// Velocity at which the tangential spring stretches, m/s; linear in the velocities of the touch.
    #[inline(always)]
    fn sliding<R: Real>(&self, touch: &Touch<S, R>) -> S::TangentOf<R> {
        touch.velocity_tangential
    }

    /// What the springs alone answer in a contact that holds, by its memory after the evaluation: the rest is dashpots.
    fn springs(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> Answer<S, f64>;

    /// Tangential stiffness of a contact that holds, N/m; nothing of a law without tangential springs.
    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, _touch: &Touch<S, R>) -> R {
        R::splat(0.0)
    }

    /// Springs and dashpots of a contact as it is. Radii in m, masses in kg as a touch has them.
    fn stiffness(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs;

    /// The most that spring and dashpot may carry along the surface together, N, at a normal force (N).
    fn friction_limit(&self, touch: &Touch<S, f64>, normal: f64) -> f64;

    /// Elastic energy stored in a contact that holds, J; with a blank memory, that of the normal spring alone.
    fn elastic_energy(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> f64;
}
