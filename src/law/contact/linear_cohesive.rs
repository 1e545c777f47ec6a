//! Linear spring and dashpot with cohesion: Chen et al. (2021), section 2.1.
//!
//! ```text
//! F_n = k_n d - gamma_n v_n                      also in tension, once the grains have touched
//! F_n = max(k_n d - gamma_n v_n, min(k_n d, 0))  normal_force = "repulsive": what pulls is the spring alone, by cohesion
//! the contact ends when k_n d < -e_n             e_n, N: pull-off force
//! |F_t| <= mu |F_n| + e_t                        e_t, N; spring and cut as in the law without cohesion
//! ```
//!
//! A contact that has ended must be made again by touching before it holds in tension. With e_n = e_t = 0 this is
//! [`super::LinearSpringDashpot`] to the bit.

use super::linear_spring_dashpot::slide;
use super::{Answer, ContactLaw, Described, Force, LinearSpringDashpot, Springs, Stiffening, Touch};
use crate::base::keys::{FORCE, Form, NOT_NEGATIVE, number};
use crate::base::lane::Real;
use crate::base::space::{Components, Lanewise, Space, Words};

/// The same with cohesion (Chen et al. 2021, 2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearCohesive {
    /// Springs, dashpots and friction, as without cohesion.
    pub linear: LinearSpringDashpot,
    /// e_n, N: a contact made once holds until k_n d < -e_n.
    pub cohesion_normal: f64,
    /// e_t, N: |F_t| <= mu |F_n| + e_t.
    pub cohesion_tangential: f64,
}

impl Described for LinearCohesive {
    fn keys(&mut self, form: &mut dyn Form, mass_mean: f64) {
        self.linear.keys(form, mass_mean);
        form.number(
            &mut self.cohesion_normal,
            number("cohesion_normal", "e_n, the pull that a contact bears", FORCE, NOT_NEGATIVE, "\"0.2 N\""),
        );
        form.number(
            &mut self.cohesion_tangential,
            number(
                "cohesion_tangential",
                "e_t, shear that a contact bears beyond friction",
                FORCE,
                NOT_NEGATIVE,
                "\"0.2 N\"",
            ),
        );
    }

    fn friction(&mut self) -> &mut f64 {
        &mut self.linear.friction
    }

    fn without_cohesion(&mut self) {
        (self.cohesion_normal, self.cohesion_tangential) = (0.0, 0.0);
    }

    fn without_loss(&mut self) {
        self.linear.without_loss();
    }

    fn stiffening(&self) -> Stiffening {
        self.linear.stiffening()
    }

    fn keys_of_stiffness(&self) -> [&'static str; 2] {
        self.linear.keys_of_stiffness()
    }
}

impl LinearCohesive {
    /// How far apart surfaces that have touched still hold on to each other, m: e_n/k_n.
    pub fn pull_off_distance(&self) -> f64 {
        self.cohesion_normal / self.linear.stiffness_normal
    }
}

impl From<LinearCohesive> for Force {
    fn from(law: LinearCohesive) -> Self {
        Self::LinearCohesive(law)
    }
}

impl<S: Space> ContactLaw<S> for LinearCohesive {
    /// The tangential spring s, m, and 1 where the contact has been made.
    type Memory<R: Real> = (S::TangentOf<R>, Components<R, 1>);

    fn reach(&self) -> f64 {
        self.pull_off_distance()
    }

    #[inline(always)]
    fn holds<R: Real>(&self, touch: &Touch<S, R>, memory: &Self::Memory<R>) -> R::Mask {
        let zero = R::splat(0.0);
        let pull = touch.overlap * R::splat(self.linear.stiffness_normal);
        let made = memory.1.word(0).above(zero);
        let kept = pull.above(R::splat(-self.cohesion_normal));
        R::either(touch.overlap.above(zero), R::both(made, kept))
    }

    #[inline(always)]
    fn force<R: Real>(&self, touch: &Touch<S, R>, memory: &mut Self::Memory<R>) -> Answer<S, R> {
        let law = &self.linear;
        let spring = touch.overlap * R::splat(law.stiffness_normal);
        let damped = spring - touch.velocity_normal * R::splat(law.damping_normal);
        let pull = R::min(spring, R::splat(0.0));
        let normal = R::max(pull + R::splat(law.normal_force.least()), damped);
        let limit = normal.abs() * R::splat(law.friction) + R::splat(self.cohesion_tangential);
        let tangential = slide(law, touch, limit, &mut memory.0);
        memory.1.set_word(0, R::splat(1.0));
        Answer { normal, tangential, moment: Words::zero() }
    }

    fn springs(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> Answer<S, f64> {
        let law = &self.linear;
        let tangential = memory.0 * -law.stiffness_tangential;
        Answer { normal: touch.overlap * law.stiffness_normal, tangential, moment: Words::zero() }
    }

    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, _: &Touch<S, R>) -> R {
        R::splat(self.linear.stiffness_tangential)
    }

    fn stiffness(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
        ContactLaw::<S>::stiffness(&self.linear, radii, masses, overlap)
    }

    fn friction_limit(&self, _: &Touch<S, f64>, normal: f64) -> f64 {
        normal.abs() * self.linear.friction + self.cohesion_tangential
    }

    fn elastic_energy(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> f64 {
        let law = &self.linear;
        0.5 * law.stiffness_normal * touch.overlap * touch.overlap
            + 0.5 * law.stiffness_tangential * memory.0.dot(&memory.0)
    }
}
