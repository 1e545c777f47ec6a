//! Linear spring and dashpot with a tangential spring and a Coulomb limit: Cundall & Strack (1979) in the form of
//! Chen et al. (2021), section 2.1.
//!
//! With the overlap d, the opening velocity v_n and the sliding velocity v_t:
//!
//! ```text
//! F_n = k_n d - gamma_n v_n                      repulsive positive; normal_force = "tensile": it may pull while a contact opens
//! F_n = max(k_n d - gamma_n v_n, 0)              normal_force = "repulsive": the dashpot only repels
//! s  += v_t dt
//! F_t = -k_t s - gamma_t v_t
//! |F_t| > mu |F_n|:  F_t is cut to the cone, s = -(F_t + gamma_t v_t)/k_t
//! ```
//!
//! Damping is absolute (N s/m) and enters in full, as in Table 1 of the paper. The spring is forgotten at the first step
//! without overlap. Stable only for time steps below the bounds of `job/stable.rs`, which include the damping.

use super::{Answer, ContactLaw, Described, Force, NormalForce, Springs, Stiffening, Touch, constants};
use crate::base::keys::{DAMPING, Form, NOT_NEGATIVE, POSITIVE, STIFFNESS, number};
use crate::base::lane::Real;
use crate::base::space::{Lanewise, Space, Words};

/// Linear spring-dashpot with tangential memory and Coulomb limit (Cundall & Strack 1979; Chen et al. 2021, 2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSpringDashpot {
    /// k_n, N/m.
    pub stiffness_normal: f64,
    /// k_t, N/m.
    pub stiffness_tangential: f64,
    /// gamma_n, N s/m; in a job either this or `restitution` of two mean grains.
    pub damping_normal: f64,
    /// gamma_t, N s/m.
    pub damping_tangential: f64,
    /// mu, the Coulomb coefficient.
    pub friction: f64,
    /// Whether the normal dashpot may pull.
    pub normal_force: NormalForce,
}

impl LinearSpringDashpot {
    /// Table 1 of Chen et al. (2021) with the damping that is stable.
    pub const CHEN: Self = Self {
        stiffness_normal: 1_772_093.8,
        stiffness_tangential: 886_046.9,
        damping_normal: 3.5,
        damping_tangential: 3.5,
        friction: 0.5,
        normal_force: NormalForce::TENSILE,
    };
}

impl Described for LinearSpringDashpot {
    fn keys(&mut self, form: &mut dyn Form, mass_mean: f64) {
        form.number(
            &mut self.stiffness_normal,
            number("stiffness_normal", "k_n", STIFFNESS, POSITIVE, "\"1772 kN/m\""),
        );
        form.number(
            &mut self.stiffness_tangential,
            number("stiffness_tangential", "k_t", STIFFNESS, NOT_NEGATIVE, "\"886 kN/m\""),
        );
        constants::normal_force(form, &mut self.normal_force);
        let dampings = ["damping_normal", "damping_tangential"];
        match constants::restitution(form, &dampings) {
            Some(restitution) => {
                let critical = 2.0 * (self.stiffness_normal * 0.5 * mass_mean).sqrt();
                self.damping_normal = constants::damping_of(restitution, self.normal_force, critical);
                self.damping_tangential = self.damping_normal;
            }
            None if form.is_needed() && !dampings.iter().any(|key| form.has(key)) => form.note_table(
                "does not say how contacts are damped. Add restitution, for example restitution = 0.5, or both damping_normal and damping_tangential, for example \"3.5 N s/m\".",
            ),
            None => {
                let unless = "unless restitution is given; with hertz_mindlin 0 by default";
                let key = |name, about| number(name, about, DAMPING, NOT_NEGATIVE, "\"3.5 N s/m\"").required(unless);
                form.number(&mut self.damping_normal, key("damping_normal", "gamma_n"));
                form.number(&mut self.damping_tangential, key("damping_tangential", "gamma_t"));
            }
        }
        constants::friction(form, &mut self.friction);
    }

    fn friction(&mut self) -> &mut f64 {
        &mut self.friction
    }

    fn without_loss(&mut self) {
        (self.damping_normal, self.damping_tangential) = (0.0, 0.0);
    }

    fn stiffening(&self) -> Stiffening {
        Stiffening::Constant
    }

    fn keys_of_stiffness(&self) -> [&'static str; 2] {
        ["stiffness_normal", "stiffness_tangential"]
    }
}

impl From<LinearSpringDashpot> for Force {
    fn from(law: LinearSpringDashpot) -> Self {
        Self::Linear(law)
    }
}

impl<S: Space> ContactLaw<S> for LinearSpringDashpot {
    /// The tangential spring s, m.
    type Memory<R: Real> = S::TangentOf<R>;

    #[inline(always)]
    fn force<R: Real>(&self, touch: &Touch<S, R>, spring: &mut S::TangentOf<R>) -> Answer<S, R> {
        let damped =
            touch.overlap * R::splat(self.stiffness_normal) - touch.velocity_normal * R::splat(self.damping_normal);
        let normal = R::max(R::splat(self.normal_force.least()), damped);
        let limit = normal.abs() * R::splat(self.friction);
        let tangential = slide(self, touch, limit, spring);
        Answer { normal, tangential, moment: Words::zero() }
    }

    fn springs(&self, touch: &Touch<S, f64>, spring: &S::TangentOf<f64>) -> Answer<S, f64> {
        let tangential = *spring * -self.stiffness_tangential;
        Answer { normal: touch.overlap * self.stiffness_normal, tangential, moment: Words::zero() }
    }

    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, _: &Touch<S, R>) -> R {
        R::splat(self.stiffness_tangential)
    }

    fn stiffness(&self, _: [f64; 2], _: [f64; 2], _: f64) -> Springs {
        Springs {
            normal: self.stiffness_normal,
            tangential: self.stiffness_tangential,
            rolling: 0.0,
            damping_normal: self.damping_normal,
            damping_tangential: self.damping_tangential,
        }
    }

    fn friction_limit(&self, _: &Touch<S, f64>, normal: f64) -> f64 {
        normal.abs() * self.friction
    }

    fn elastic_energy(&self, touch: &Touch<S, f64>, spring: &S::TangentOf<f64>) -> f64 {
        0.5 * self.stiffness_normal * touch.overlap * touch.overlap
            + 0.5 * self.stiffness_tangential * spring.dot(spring)
    }
}

/// Advances the tangential spring and returns its force with the dashpot's, cut to `limit` (N).
#[inline(always)]
pub(super) fn slide<S: Space, R: Real>(
    law: &LinearSpringDashpot,
    touch: &Touch<S, R>,
    limit: R,
    spring: &mut S::TangentOf<R>,
) -> S::TangentOf<R> {
    let zero = R::splat(0.0);
    // Without stiffness the spring carries nothing and may stay as it is.
    let compliance = if law.stiffness_tangential > 0.0 { 1.0 / law.stiffness_tangential } else { 0.0 };
    let stretched = S::carry(&touch.normal, touch.twist, spring) + touch.velocity_tangential * touch.advance;
    let damping = touch.velocity_tangential * R::splat(law.damping_tangential);
    let trial = -(stretched * R::splat(law.stiffness_tangential)) - damping;

    let magnitude = trial.norm();
    let slides = magnitude.above(limit);
    // A contact without a spring yet has no direction to slide in; it starts free of tangential force.
    let stretches = stretched.dot(&stretched).above(zero);
    let share = R::choose(stretches, limit / magnitude, zero);
    let cut = trial * R::choose(slides, share, R::splat(1.0));
    let relaxed = (cut + damping) * R::splat(-compliance);
    *spring = Words::choose(R::both(slides, stretches), &relaxed, &stretched);
    cut
}
