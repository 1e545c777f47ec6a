//! Penalty springs: what holds a single grain to the nodes that it shares with a continuum or a membrane.
//!
//! A node makes one velocity of the mean velocities of grains and continuum around it, and what keeps single grains from going
//! their own way is then no more than a dashpot. At the free edges of both within an overlap, forces drive grains and
//! continuum apart by `a dt` in every step, some 0.1 m/s, of which functions that smooth lambda leave a part for ever: the layer as
//! a whole slips, and its outermost grains are pushed out of it one by one. So each grain of the overlap is tied as well, by a
//! spring and a dashpot on the way that it slips against the velocities V of its nodes, with the continuum's share of
//! their mass as its strength:
//!
//! ```text
//! u = sum N S (v - V),  S = (m_c - sum m N t t)/(m_c + m_d)                                  after a step
//! q <- q - kappa k_n dt^2/m u,   v <- v + q - 2 zeta sqrt(kappa k_n/m) dt u                  in the next
//! J = sum w m N (what v has changed by)                                                      what the nodes' continuum pays for it
//! ```
//!
//! k_n is the stiffness of a contact between two mean grains, and zeta the share of critical damping of the spring and its grain,
//! so that neither depends on the step. A grain slips by `a m/(kappa k_n s)` where s is the share, and stays there; where it comes among
//! grains alone, its spring slackens. A membrane, whose mass m is part of m_c, holds grains across itself alone: along it (t) they slide on, or some layers of
//! them would be glued to it by springs that wind up without end. Spring and dashpot are impulses between grains and continuum
//! at a node, so that momentum is kept, and a node's velocity does not feel them.
//!
//! Stable where `s (k + 2 b) < 4` for `k = kappa k_n dt^2/m` and `b = 2 zeta sqrt(k)`, whatever the share s <= 1.

use crate::base::keys::{Form, NOT_NEGATIVE, RATIO, number};
use crate::base::space::Space;
use crate::dem::grains::PenaltySpring;
use crate::mpm::share::Share;

/// Share of the continuum below which springs slacken: half of what it has where overlaps weigh the same on both sides, and
/// what it has at the edge of such an overlap.
const HOLDS: f64 = 0.25;

/// Springs and dashpots between grains and the nodes that they share, in terms of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// kappa: stiffness over that of a contact, k_n.
    pub stiffness: f64,
    /// zeta: damping over the critical one.
    pub damping: f64,
}

impl Coupling {
    /// Of `[coupling]` where a job says nothing else: springs as stiff as contacts, damped a little less than critically.
    pub const DEFAULT: Self = Self { stiffness: 1.0, damping: 0.8 };

    /// The keys of `[coupling]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let about = "stiffness of the penalty springs that hold grains to nodes they share with points or membranes, over a contact's k_n";
        form.number(&mut self.stiffness, number("stiffness", about, RATIO, NOT_NEGATIVE, "1.0").or("1.0"));
        let about = "their damping, over the critical one";
        form.number(&mut self.damping, number("damping", about, RATIO, NOT_NEGATIVE, "0.8").or("0.8"));
    }

    /// The largest stiffness that is stable with this damping, for a grain of that mass, kg.
    pub fn stiffness_max(&self, contact: f64, dt: f64, mass: f64) -> f64 {
        // k + 4 zeta sqrt(k) = 4
        let root = 2.0 * ((self.damping * self.damping + 1.0).sqrt() - self.damping);
        root * root * mass / (contact * dt * dt)
    }

    /// Of a run with contacts of that stiffness, N/m, in steps of grains of `dt`, s.
    pub fn in_steps(&self, contact: f64, dt: f64) -> Penalty {
        Penalty { per_mass: self.stiffness * contact * dt * dt, damping: 2.0 * self.damping }
    }
}

/// The same in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty {
    /// kappa k_n dt^2, kg.
    per_mass: f64,
    /// 2 zeta.
    damping: f64,
}

impl Penalty {
    /// Nothing holds grains.
    pub const NONE: Self = Self { per_mass: 0.0, damping: 0.0 };

    /// A spring after a step in which its grain, of `mass` kg, has come to slip at `slip`, u, m/s, among nodes of which the continuum has
    /// `share`.
    #[inline(always)]
    pub fn after<S: Space>(
        &self,
        spring: &PenaltySpring<S>,
        mass: f64,
        slip: &S::Vector,
        share: &Share<S>,
    ) -> PenaltySpring<S> {
        let stiffness = self.per_mass / mass;
        let spring = share.left_of(&(spring.spring - *slip * stiffness), HOLDS);
        PenaltySpring { spring, given: spring - *slip * (self.damping * stiffness.sqrt()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Linear, Plane};

    type Vector = <Plane as Space>::Vector;

    const STIFFNESS: f64 = 1e6;
    const MASS: f64 = 2e-5;
    const PULL: f64 = 300.0;

    /// Place of a grain after some time that hangs on still nodes under a constant acceleration, in steps of `dt`.
    fn hanging(dt: f64, time: f64) -> f64 {
        let penalty = Coupling { stiffness: 0.5, damping: 0.3 }.in_steps(STIFFNESS, dt);
        let share = Share::<Plane>::new(0.5, [0.0; 3]);
        let (mut spring, mut velocity, mut way) = (PenaltySpring::<Plane>::loose(), Vector::zero(), 0.0);
        for _ in 0..(time / dt).round() as usize {
            velocity += spring.given + Vector::new(0.0, PULL * dt);
            way += velocity[1] * dt;
            spring = penalty.after(&spring, MASS, &share.of(&velocity), &share);
        }
        way
    }

    #[test]
    fn a_grain_slips_by_what_its_load_over_the_springs_stiffness_is_whatever_the_step() {
        let ends = [2e-7, 1e-7, 0.5e-7].map(|dt| hanging(dt, 4e-4));
        // By the part of the spring that the share leaves.
        let wanted = PULL * MASS / (0.5 * STIFFNESS * 0.5);
        assert!(ends.iter().all(|end| (end / wanted - 1.0).abs() < 1e-3), "{ends:?}, {wanted}");
        // On the way there, too, where it still swings.
        let [coarse, fine, finest] = [2e-7, 1e-7, 0.5e-7].map(|dt| hanging(dt, 8e-6));
        assert!((fine - finest).abs() < 0.6 * (coarse - fine).abs() && (coarse / finest - 1.0).abs() < 0.1);
    }

    #[test]
    fn a_spring_without_stiffness_holds_nothing() {
        let penalty = Coupling { stiffness: 0.0, damping: 1.0 }.in_steps(1e6, 1e-7);
        let slip = Vector::new(1.0, 2.0);
        let after = penalty.after(&PenaltySpring::loose(), 1e-5, &slip, &Share::<Plane>::new(0.5, [0.0; 3]));
        assert_eq!(after, PenaltySpring::loose());
    }

    #[test]
    fn springs_are_stable_up_to_their_bound_and_not_beyond() {
        let grows = |coupling: Coupling| {
            let penalty = coupling.in_steps(STIFFNESS, 1e-7);
            let share = Share::<Plane>::new(1.0, [0.0; 3]);
            let (mut spring, mut velocity) = (PenaltySpring::<Plane>::loose(), Vector::new(1.0, 0.0));
            for _ in 0..2000 {
                velocity += spring.given;
                spring = penalty.after(&spring, MASS, &share.of(&velocity), &share);
            }
            velocity.norm() > 1e3 || velocity.norm().is_nan()
        };
        for damping in [0.0, 0.2, 0.8] {
            let of = |stiffness: f64| Coupling { stiffness, damping };
            let most = of(0.0).stiffness_max(STIFFNESS, 1e-7, MASS);
            assert!(!grows(of(0.98 * most)), "{damping}");
            assert!(grows(of(1.05 * most)), "{damping}");
        }
    }
}
