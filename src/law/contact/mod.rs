//! Forces between two touching grains. A law is one file here and one line in [`Contact`]'s dispatch; it
//! is written once over [`Real`], chosen once per pass, and never branches within one.

use std::fmt::Debug;

use crate::base::keys::{Form, text, variant};
use crate::base::lane::Real;
use crate::base::space::{Space, Words};

mod absent;
mod constants;
mod elastic_rolling;
mod hertz_mindlin;
mod linear_cohesive;
mod linear_spring_dashpot;
mod memory;
mod normal_force;

pub use absent::Absent;
pub use elastic_rolling::{ElasticRolling, Sliding};
pub use hertz_mindlin::{HertzMindlin, TangentialForce};
pub use linear_cohesive::LinearCohesive;
pub use linear_spring_dashpot::LinearSpringDashpot;
pub use memory::Memory;
pub use normal_force::NormalForce;

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
    pub radius_b: R,
    /// kg; of what a body moves beyond all bounds ([`FLAT`]).
    pub mass_a: R,
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
    pub tangential: S::TangentOf<R>,
    /// Resistance to rolling, N m, beside the torque of the tangential force.
    pub moment: S::SpinOf<R>,
}

/// What resists the strain of a contact that bears force, along its stiffer direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resistance {
    /// Stiffness of the springs, N/m.
    pub spring: f64,
    /// Constant of the dashpots, N s/m.
    pub dashpot: f64,
}

/// The contact law with its constants; each law's file beside this one has its equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// `law = "linear"`.
    Linear(LinearSpringDashpot),
    /// `law = "linear_cohesive"`.
    LinearCohesive(LinearCohesive),
    /// `law = "elastic_rolling"`.
    ElasticRolling(ElasticRolling),
    /// `law = "hertz_mindlin"`.
    HertzMindlin(HertzMindlin),
}

impl Contact {
    /// The laws as jobs name them, with constants for jobs that say nothing of contacts because nothing of them touches.
    pub const LAWS: [(&'static str, Self); 4] = {
        let linear = LinearSpringDashpot::CHEN;
        [
            ("linear", Self::Linear(linear)),
            (
                "linear_cohesive",
                Self::LinearCohesive(LinearCohesive { linear, cohesion_normal: 0.0, cohesion_tangential: 0.0 }),
            ),
            ("elastic_rolling", Self::ElasticRolling(ElasticRolling::ASLEEP)),
            ("hertz_mindlin", Self::HertzMindlin(HertzMindlin::ASLEEP)),
        ]
    };

    /// The keys of `[contact]`. `mass_mean`: mass of the mean grain, kg, which turns a restitution into a damping.
    pub fn keys(&mut self, form: &mut dyn Form, mass_mean: f64) {
        let about = "the contact law: linear, linear_cohesive, elastic_rolling or hertz_mindlin";
        let key = text("law", about, "\"linear\"").or("linear");
        variant(form, self, "contact law", key, &Self::LAWS, |law, form| match law {
            Self::Linear(law) => law.keys(form, mass_mean),
            Self::LinearCohesive(law) => law.keys(form, mass_mean),
            Self::ElasticRolling(law) => law.keys(form),
            Self::HertzMindlin(law) => law.keys(form),
        });
    }

    /// The law as jobs name it.
    pub fn law(&self) -> &'static str {
        let is_this = |of: &Self| std::mem::discriminant(of) == std::mem::discriminant(self);
        Self::LAWS.iter().find(|(_, of)| is_this(of)).map(|(name, _)| *name).expect("every law has a name")
    }

    /// Does the work with the law: the one place where laws are told apart.
    pub fn apply<S: Space, W: ForAnyLaw<S>>(&self, work: W) -> W::Outcome {
        match self {
            Self::Linear(law) => work.with(law),
            Self::LinearCohesive(law) => work.with(law),
            Self::ElasticRolling(law) => work.with(law),
            Self::HertzMindlin(law) => work.with(law),
        }
    }

    /// How far apart surfaces may be and still hold on to each other, m.
    pub fn reach(&self) -> f64 {
        match self {
            Self::LinearCohesive(law) => law.pull_off_distance(),
            Self::Linear(_) | Self::ElasticRolling(_) | Self::HertzMindlin(_) => 0.0,
        }
    }

    /// Which normal forces its dashpot leaves; a law without one never pulls.
    pub fn normal_force(&self) -> NormalForce {
        match self {
            Self::Linear(law) => law.normal_force,
            Self::LinearCohesive(law) => law.linear.normal_force,
            Self::ElasticRolling(_) => NormalForce::REPULSIVE,
            Self::HertzMindlin(law) => law.normal_force,
        }
    }

    /// mu.
    pub fn friction(&self) -> f64 {
        match self {
            Self::Linear(law) => law.friction,
            Self::LinearCohesive(law) => law.linear.friction,
            Self::ElasticRolling(law) => law.friction,
            Self::HertzMindlin(law) => law.friction,
        }
    }

    /// The same law with another friction coefficient.
    pub fn with_friction(mut self, friction: f64) -> Self {
        match &mut self {
            Self::Linear(law) => law.friction = friction,
            Self::LinearCohesive(law) => law.linear.friction = friction,
            Self::ElasticRolling(law) => law.friction = friction,
            Self::HertzMindlin(law) => law.friction = friction,
        }
        self
    }

    /// The same law between grains that do not cohere.
    pub fn without_cohesion(mut self) -> Self {
        if let Self::LinearCohesive(law) = &mut self {
            (law.cohesion_normal, law.cohesion_tangential) = (0.0, 0.0);
        }
        self
    }

    /// The law while grains are compressed to a packing: with that packing's friction, and without cohesion, which would hold
    /// them where they were thrown. Whatever touches at the end coheres from the first step of the run on.
    pub fn while_compressed(self, friction: f64) -> Self {
        self.with_friction(friction).without_cohesion()
    }
}

/// Work that does not care which law it is done with.
pub trait ForAnyLaw<S: Space> {
    type Outcome;
    fn with<C: ContactLaw<S>>(self, law: &C) -> Self::Outcome;
}

/// A contact law with memory.
pub trait ContactLaw<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// What a contact remembers, zero where grains do not touch.
    type Memory<R: Real>: Words<R>;
    /// Whether rolling is resisted: [`Answer::moment`] is not always zero.
    const ROLLS: bool = false;

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

    /// Stiffness of now: that of the normal or of the tangential direction, whichever is more. Radii in m, masses in kg as a
    /// touch has them. The dashpot is that of a contact that closes, which nothing limits.
    fn resistance(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Resistance;

    /// The most that spring and dashpot may carry along the surface together, N, at a normal force (N).
    fn friction_limit(&self, touch: &Touch<S, f64>, normal: f64) -> f64;

    /// Elastic energy stored in a contact that holds, J; with a blank memory, that of the normal spring alone.
    fn elastic_energy(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> f64;
}
