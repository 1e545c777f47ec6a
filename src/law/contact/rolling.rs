//! Resistance to rolling, a part of any law: Liang & Zhao (2019), eq. 24 and 25.
//!
//! ```text
//! k_r = beta k_t r_i r_j                        k_t of the law at that contact
//! theta += (w_i - w_j) dt;  M = -k_r theta,     |M| <= eta min(r_i, r_j) max(F_n, 0), theta cut with it
//! ```
//!
//! F_n is the law's normal force with its dashpot and without [`super::adhesion`]. Twist about the normal is not resisted. Against
//! a flat body rolling is resisted as by a grain of the same size.

use super::{Answer, ContactLaw, FLAT, Springs, Touch};
use crate::base::keys::{Form, Key, RATIO, Range, number};
use crate::base::lane::Real;
use crate::base::space::{Lanewise, Space};

/// How much contacts resist rolling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingResistance {
    /// beta.
    pub stiffness: f64,
    /// eta.
    pub limit: f64,
}

impl RollingResistance {
    pub(super) const STIFFNESS: Key = {
        let about = "beta of k_r = beta k_t r_i r_j, which resists rolling; together with rolling_limit";
        number("rolling_stiffness", about, RATIO, Range::closed(0.0, 100.0), "1.0")
    };
    pub(super) const LIMIT: Key = {
        let about =
            "eta of |M| <= eta min(r_i, r_j) F_n, the most that resists rolling; together with rolling_stiffness";
        number("rolling_limit", about, RATIO, Range::closed(0.0, 10.0), "0.05")
    };

    /// Keys of the part; nothing of it is there where neither is typed.
    pub(super) fn keys(part: &mut Option<Self>, form: &mut dyn Form) {
        let (mut beta, mut eta) = (part.map(|part| part.stiffness), part.map(|part| part.limit));
        form.number_if_given(&mut beta, Self::STIFFNESS.optional());
        form.number_if_given(&mut eta, Self::LIMIT.optional());
        let lone = match (beta, eta) {
            (Some(_), None) => Some(("rolling_stiffness", "rolling_limit = 0.05, the most that it bears")),
            (None, Some(_)) => {
                Some(("rolling_limit", "rolling_stiffness = 1.0, without which there is nothing to limit"))
            }
            _ => None,
        };
        if let (Some((key, other)), false) = (lone, form.describes()) {
            form.note(key, &format!("stands alone. Add contact.{other}, or remove it."));
        }
        *part = beta.zip(eta).map(|(stiffness, limit)| Self { stiffness, limit });
    }

    /// k_r, N m, of a contact with that tangential stiffness.
    #[inline(always)]
    pub(super) fn at<R: Real>(&self, tangential: R, radius_a: R, radius_b: R) -> R {
        let partner = R::choose(radius_b.above(R::splat(0.5 * FLAT)), radius_a, radius_b);
        tangential * radius_a * partner * R::splat(self.stiffness)
    }

    /// Carries the angle rolled along, and returns the moment that resists it.
    #[inline(always)]
    pub(super) fn moment<S: Space, R: Real>(
        &self,
        touch: &Touch<S, R>,
        stiffness: R,
        normal: R,
        rolled: &mut S::SpinOf<R>,
    ) -> S::SpinOf<R> {
        let rolling = S::rolling(&touch.normal, &touch.spin_relative);
        *rolled = S::carry_spin(&touch.normal, touch.twist, rolled) + rolling * touch.advance;
        let radius_min = R::min(touch.radius_a, touch.radius_b);
        cut(rolled, stiffness, normal * radius_min * R::splat(self.limit))
    }
}

/// What an elastic spring gives when it may carry at most `limit`; beyond it the spring is cut.
#[inline(always)]
pub(super) fn cut<R: Real, V: Lanewise<R>>(spring: &mut V, stiffness: R, limit: R) -> V {
    let trial = -(*spring * stiffness);
    let magnitude = trial.norm();
    let share = R::choose(magnitude.above(limit), limit / magnitude, R::splat(1.0));
    *spring = *spring * share;
    trial * share
}

/// A law whose contacts resist rolling too.
#[derive(Clone, Copy, Debug)]
pub struct Rolling<C> {
    /// The law without the resistance.
    pub law: C,
    /// How much every contact resists.
    pub resistance: RollingResistance,
}

impl<S: Space, C: ContactLaw<S>> ContactLaw<S> for Rolling<C> {
    /// What the law remembers, and the angle rolled theta, rad.
    type Memory<R: Real> = (C::Memory<R>, S::SpinOf<R>);

    fn reach(&self) -> f64 {
        self.law.reach()
    }

    #[inline(always)]
    fn holds<R: Real>(&self, touch: &Touch<S, R>, memory: &Self::Memory<R>) -> R::Mask {
        self.law.holds(touch, &memory.0)
    }

    #[inline(always)]
    fn force<R: Real>(&self, touch: &Touch<S, R>, (memory, rolled): &mut Self::Memory<R>) -> Answer<S, R> {
        let answer = self.law.force(touch, memory);
        let stiffness = self.resistance.at(self.law.stiffness_tangential(touch), touch.radius_a, touch.radius_b);
        let pressed = R::max(answer.normal, R::splat(0.0));
        let moment = self.resistance.moment(touch, stiffness, pressed, rolled);
        Answer { moment, ..answer }
    }

    #[inline(always)]
    fn sliding<R: Real>(&self, touch: &Touch<S, R>) -> S::TangentOf<R> {
        self.law.sliding(touch)
    }

    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, touch: &Touch<S, R>) -> R {
        self.law.stiffness_tangential(touch)
    }

    fn springs(&self, touch: &Touch<S, f64>, (memory, rolled): &Self::Memory<f64>) -> Answer<S, f64> {
        let stiffness = self.resistance.at(self.law.stiffness_tangential(touch), touch.radius_a, touch.radius_b);
        Answer { moment: *rolled * -stiffness, ..self.law.springs(touch, memory) }
    }

    fn stiffness(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
        let springs = self.law.stiffness(radii, masses, overlap);
        Springs { rolling: self.resistance.at(springs.tangential, radii[0], radii[1]), ..springs }
    }

    fn friction_limit(&self, touch: &Touch<S, f64>, normal: f64) -> f64 {
        self.law.friction_limit(touch, normal)
    }

    fn elastic_energy(&self, touch: &Touch<S, f64>, (memory, rolled): &Self::Memory<f64>) -> f64 {
        let stiffness = self.resistance.at(self.law.stiffness_tangential(touch), touch.radius_a, touch.radius_b);
        self.law.elastic_energy(touch, memory) + 0.5 * stiffness * rolled.dot(rolled)
    }
}
