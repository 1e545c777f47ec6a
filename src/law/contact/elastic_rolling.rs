//! Elastic contact with stiffness from Young's modulus, Coulomb friction and rolling resistance: Liang & Zhao (2019),
//! eq. 20 to 28. There is no dashpot; the assembly is damped by [`crate::dem::motion`].
//!
//! ```text
//! k_n = 2 (E r_i)(E r_j)/(E r_i + E r_j) = E r*,   k_t = nu k_n,   k_r = beta k_t r_i r_j     (22, 23, 25)
//! F_n = k_n d >= 0                                                                            (20)
//! s  += v_t dt;  F_t = -k_t s,  |F_t| <= mu F_n, s cut with it                                (21)
//! theta += (w_i - w_j) dt;  M = -k_r theta,  |M| <= eta min(r_i, r_j) F_n, theta cut with it   (24)
//! ```
//!
//! What slides is the surfaces with full radii; with [`Sliding::Scaled`] the translational part of v_t is scaled by
//! (r_i + r_j)/(r_i + r_j - d), so that a contact that rolls without slip around another builds up no spring. That is how
//! YADE (2023.02a) reckons, and with it goes how it turns the spring with the contact: to first order, s -= s x (n x n'),
//! which lengthens it by half the square of the angle. In a step the share is some 1e-11, but it is what its records differ
//! by from a spring that keeps its length. Twist about the normal is not resisted. Against a flat body r_j is without
//! bounds: k_n = 2 E r_i, and rolling is resisted as by a grain of the same size.

use super::rolling::cut;
use super::{Answer, ContactLaw, Described, Force, RollingResistance, Springs, Stiffening, Touch, constants};
use crate::base::keys::{Form, POSITIVE, RATIO, Range, STRESS, choose, number, text};
use crate::base::lane::Real;
use crate::base::space::{Lanewise, Space};

/// Stiffness from Young's modulus by harmonic means, rolling resistance (Liang & Zhao 2019, eq. 20 to 28); no dashpot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticRolling {
    /// E, Pa.
    pub young_modulus: f64,
    /// Stiffness ratio k_t/k_n, which the paper calls nu.
    pub stiffness_ratio: f64,
    /// mu, the Coulomb coefficient.
    pub friction: f64,
    /// beta: k_r = beta k_t r_i r_j; zero: grains roll freely.
    pub rolling_stiffness: f64,
    /// eta: |M| <= eta min(r_i, r_j) F_n.
    pub rolling_limit: f64,
    /// What slides: the surfaces as they are, or with the translational part scaled by (r_i + r_j)/(r_i + r_j - d).
    pub sliding: Sliding,
}

/// What stretches the tangential spring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sliding {
    /// "surface": the velocity of surfaces with full radii.
    #[default]
    Surface,
    /// "scaled": the same with its translational part times (r_i + r_j)/(r_i + r_j - d), and the spring turned to first order, as in YADE.
    Scaled,
}

/// k_n, k_t and k_r of a contact.
struct Stiffness<R> {
    normal: R,
    tangential: R,
    rolling: R,
}

impl ElasticRolling {
    pub(super) const ASLEEP: Self = Self {
        young_modulus: 600e6,
        stiffness_ratio: 0.8,
        friction: 0.5,
        rolling_stiffness: 0.0,
        rolling_limit: 0.0,
        sliding: Sliding::Surface,
    };

    /// Elastic, tangential and rolling stiffness.
    #[inline(always)]
    fn springs_of<R: Real>(&self, radius_a: R, radius_b: R) -> Stiffness<R> {
        let modulus = R::splat(self.young_modulus);
        let (a, b) = (modulus * radius_a, modulus * radius_b);
        let normal = R::splat(2.0) * a * b / (a + b);
        let tangential = normal * R::splat(self.stiffness_ratio);
        let rolling = self.resistance().at(tangential, radius_a, radius_b);
        Stiffness { normal, tangential, rolling }
    }

    #[inline(always)]
    fn resistance(&self) -> RollingResistance {
        RollingResistance { stiffness: self.rolling_stiffness, limit: self.rolling_limit }
    }
}

impl Described for ElasticRolling {
    fn keys(&mut self, form: &mut dyn Form, _: f64) {
        form.number(
            &mut self.young_modulus,
            number("young_modulus", "E of k_n = E r*", STRESS, POSITIVE, "\"600 MPa\""),
        );
        form.number(
            &mut self.stiffness_ratio,
            number("stiffness_ratio", "k_t/k_n", RATIO, Range::closed(0.0, 10.0), "0.8"),
        );
        constants::friction(form, &mut self.friction);
        form.number(&mut self.rolling_stiffness, RollingResistance::STIFFNESS.or("0.0"));
        form.number(&mut self.rolling_limit, RollingResistance::LIMIT.or("0.0"));
        let key = text("sliding", "what slides: surface or scaled", "\"surface\"").or("surface");
        let names = [("surface", Sliding::Surface), ("scaled", Sliding::Scaled)];
        choose(form, &mut self.sliding, "form of sliding", key, &names);
    }

    fn friction(&mut self) -> &mut f64 {
        &mut self.friction
    }

    fn without_loss(&mut self) {
        (self.rolling_stiffness, self.rolling_limit) = (0.0, 0.0);
    }

    fn rolling(&self) -> Option<RollingResistance> {
        Some(self.resistance())
    }

    fn stiffening(&self) -> Stiffening {
        Stiffening::WithSize
    }

    fn keys_of_stiffness(&self) -> [&'static str; 2] {
        ["young_modulus", "stiffness_ratio"]
    }
}

impl From<ElasticRolling> for Force {
    fn from(law: ElasticRolling) -> Self {
        Self::ElasticRolling(law)
    }
}

/// What turning to first order adds to a spring: half the square of the angle that the normal turned through, along the way
/// it turned, and of the angle about it.
#[inline(always)]
fn lengthening<S: Space, R: Real>(touch: &Touch<S, R>, distance: R, spring: &S::TangentOf<R>) -> S::TangentOf<R> {
    let turn = touch.velocity_centres * (touch.advance / distance);
    (turn * turn.dot(spring) + *spring * (touch.twist * touch.twist)) * R::splat(0.5)
}

impl<S: Space> ContactLaw<S> for ElasticRolling {
    /// The tangential spring s, m, and the angle rolled theta, rad.
    type Memory<R: Real> = (S::TangentOf<R>, S::SpinOf<R>);

    #[inline(always)]
    fn force<R: Real>(&self, touch: &Touch<S, R>, memory: &mut Self::Memory<R>) -> Answer<S, R> {
        let stiffness = self.springs_of(touch.radius_a, touch.radius_b);
        let normal = touch.overlap * stiffness.normal;
        let sliding = <Self as ContactLaw<S>>::sliding(self, touch);
        let (spring, rolled) = memory;
        *spring = S::carry(&touch.normal, touch.twist, spring);
        if self.sliding == Sliding::Scaled {
            let distance = touch.radius_a + touch.radius_b - touch.overlap;
            *spring = *spring + lengthening(touch, distance, spring);
        }
        *spring = *spring + sliding * touch.advance;
        let tangential = cut(spring, stiffness.tangential, normal * R::splat(self.friction));
        let moment = self.resistance().moment(touch, stiffness.rolling, normal, rolled);
        Answer { normal, tangential, moment }
    }

    #[inline(always)]
    fn sliding<R: Real>(&self, touch: &Touch<S, R>) -> S::TangentOf<R> {
        match self.sliding {
            Sliding::Surface => touch.velocity_tangential,
            Sliding::Scaled => {
                let reach = touch.radius_a + touch.radius_b;
                let excess = touch.overlap / (reach - touch.overlap);
                touch.velocity_tangential + touch.velocity_centres * excess
            }
        }
    }

    fn springs(&self, touch: &Touch<S, f64>, (spring, rolled): &Self::Memory<f64>) -> Answer<S, f64> {
        let stiffness = self.springs_of(touch.radius_a, touch.radius_b);
        let (tangential, moment) = (*spring * -stiffness.tangential, *rolled * -stiffness.rolling);
        Answer { normal: touch.overlap * stiffness.normal, tangential, moment }
    }

    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, touch: &Touch<S, R>) -> R {
        self.springs_of(touch.radius_a, touch.radius_b).tangential
    }

    fn stiffness(&self, [radius_a, radius_b]: [f64; 2], _: [f64; 2], _: f64) -> Springs {
        let Stiffness { normal, tangential, rolling } = self.springs_of(radius_a, radius_b);
        Springs { normal, tangential, rolling, damping_normal: 0.0, damping_tangential: 0.0 }
    }

    fn friction_limit(&self, _: &Touch<S, f64>, normal: f64) -> f64 {
        normal * self.friction
    }

    fn elastic_energy(&self, touch: &Touch<S, f64>, (spring, rolled): &Self::Memory<f64>) -> f64 {
        let stiffness = self.springs_of(touch.radius_a, touch.radius_b);
        0.5 * stiffness.normal * touch.overlap * touch.overlap
            + 0.5 * stiffness.tangential * spring.dot(spring)
            + 0.5 * stiffness.rolling * rolled.dot(rolled)
    }
}
