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
//! u = sum N S (v - V),  S = (m_c - sum m N t t)/(m_c + m_d)                                  after an exchange
//! q <- q - kappa k_n T^2/m (u + S (x - x*)/T),   x* <- x + v T
//! g = q - 2 zeta sqrt(kappa k_n/m) T u,   v <- v + g/k                                       in each of the next k steps
//! J = sum w m N g                                                                            what the nodes' continuum pays for it
//! ```
//!
//! k_n is the stiffness of a contact between two mean grains, and zeta the share of critical damping of the spring and its grain,
//! so that neither depends on the step. A grain slips by `a m/(kappa k_n s)` where s is the share, and stays there; where it comes among
//! grains alone, its spring slackens. A membrane, whose mass m is part of m_c, holds grains across itself alone: along it (t) they slide on, or some layers of
//! them would be glued to it by springs that wind up without end. Spring and dashpot are impulses between grains and continuum
//! at a node, so that momentum is kept, and a node's velocity does not feel them.
//!
//! T = k dt is the time from one exchange to the next, with the coupling interval k ([`Coupling::interval`]). Contacts push in every step: an
//! impulse given all at once would let a grain that they push outwards drift on by `a T/2`, for ever, and so would one that only nodes give.
//! So each step gives its part, and a spring counts what its grain has slipped by and not what was predicted (x*). With k = 1 that is the same.
//!
//! Without contacts stable where `s ((2 - 1/k) K + 2 B) < 4` for `K = kappa k_n T^2/m` and `B = 2 zeta sqrt(K)`, whatever the share s <= 1. Between contacts a longer
//! interval has a bound of its own ([`Coupling::is_stable`]). Multiple time steps: Tuckerman, Berne & Martyna (1992).

use nalgebra::SMatrix;

use crate::base::keys::{Form, NOT_NEGATIVE, RATIO, count, number};
use crate::base::space::{Plane, Space};
use crate::dem::grains::PenaltySpring;
use crate::law::contact::Springs;
use crate::mpm::share::Share;

/// Share of the continuum below which springs slacken: half of what it has where overlaps weigh the same on both sides, and
/// what it has at the edge of such an overlap.
const HOLDS: f64 = 0.25;

/// Contacts of a grain among its like.
const CONTACTS: f64 = 6.0;

/// Parts of these, and of the share, that [`Coupling::is_stable`] looks at.
const SAMPLES: u32 = 20;

/// What a spectral radius of one may be more by, as eigenvalues are known.
const GROWTH_SLACK: f64 = 1e-6;

/// Springs and dashpots between grains and the nodes that they share, in terms of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// kappa: stiffness over that of a contact, k_n.
    pub stiffness: f64,
    /// zeta: damping over the critical one.
    pub damping: f64,
    /// Steps of grains from one exchange with nodes to the next.
    pub interval: u64,
}

impl Coupling {
    /// Of `[coupling]` where a job says nothing else: springs as stiff as contacts, damped a little less than critically.
    pub const DEFAULT: Self = Self { stiffness: 1.0, damping: 0.8, interval: 1 };

    /// The keys of `[coupling]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let about = "stiffness of the penalty springs that hold grains to nodes they share with points or membranes, over a contact's k_n";
        form.number(&mut self.stiffness, number("stiffness", about, RATIO, NOT_NEGATIVE, "1.0").or("1.0"));
        let about = "their damping, over the critical one";
        form.number(&mut self.damping, number("damping", about, RATIO, NOT_NEGATIVE, "0.8").or("0.8"));
        let about = "steps of grains from one exchange with the nodes they share to the next; time.grain_steps is a multiple of it";
        form.count(&mut self.interval, count("interval", about, (1, 1000), "4").or("1"));
    }

    /// The largest stiffness that is stable with this damping in steps of grains of `dt`, s, for a grain of that mass, kg.
    pub fn stiffness_max(&self, contact: f64, dt: f64, mass: f64) -> f64 {
        let (time, factor) = (self.interval as f64 * dt, 2.0 - 1.0 / self.interval as f64);
        // factor K + 4 zeta sqrt(K) = 4
        let root = 2.0 * ((self.damping * self.damping + factor).sqrt() - self.damping) / factor;
        root * root * mass / (contact * time * time)
    }

    /// Whether a grain of that mass, kg, does not swing farther from one exchange to the next, in steps of grains of `dt`, s: by the scheme itself, with up to six
    /// such contacts with grains at rest, among still nodes. At the edge of an overlap, where grains have the weight `weight`, contacts weigh more than these. Shares and contacts are
    /// sampled.
    pub fn is_stable(&self, contact: &Springs, dt: f64, (mass, weight): (f64, f64)) -> bool {
        if self.stiffness == 0.0 {
            return true;
        }
        let penalty = self.in_steps(contact.normal, dt);
        let most = CONTACTS * 0.5 * (1.0 + weight) / weight;
        let sample = |number: u32| f64::from(number) / f64::from(SAMPLES);
        (1..=SAMPLES).all(|share| {
            (0..=SAMPLES).all(|contacts| {
                let beside = [contact.normal, contact.damping_normal].map(|one| most * sample(contacts) * one);
                penalty.growth(beside, sample(share), (dt, mass)) < 1.0 + GROWTH_SLACK
            })
        })
    }

    /// Of a run with contacts of that stiffness, N/m, in steps of grains of `dt`, s.
    pub fn in_steps(&self, contact: f64, dt: f64) -> Penalty {
        let between = self.interval as f64 * dt;
        Penalty {
            per_mass: self.stiffness * contact * between * between,
            damping: 2.0 * self.damping,
            interval: self.interval,
        }
    }
}

/// The same from one exchange to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty {
    /// kappa k_n dt^2, kg.
    per_mass: f64,
    /// 2 zeta.
    damping: f64,
    /// Steps of grains from one exchange to the next.
    pub interval: u64,
}

impl Penalty {
    /// Nothing holds grains.
    pub const NONE: Self = Self { per_mass: 0.0, damping: 0.0, interval: 1 };

    /// Share of what springs give from one exchange to the next that each step of grains in between has.
    pub fn part(&self) -> f64 {
        1.0 / self.interval as f64
    }

    /// Factor by which a grain of `mass`, kg, swings farther from one exchange to the next, that hangs on a spring (N/m) and a dashpot (N s/m) beside its penalty spring among still
    /// nodes of that share: the spectral radius of the scheme.
    fn growth(&self, [stiffness, damping]: [f64; 2], share: f64, (dt, mass): (f64, f64)) -> f64 {
        type Vector = <Plane as Space>::Vector;
        let share = Share::<Plane>::new(share, [0.0; 3]);
        let time = self.interval as f64 * dt;
        // Place, velocity, what the penalty spring and what it gives, and where the last exchange expected the grain, all as lengths.
        let mut of_state = SMatrix::<f64, 5, 5>::identity();
        for mut column in of_state.column_iter_mut() {
            let [mut place, mut velocity] = [column[0], column[1] / time].map(|along| Vector::new(along, 0.0));
            let [spring, given] = [column[2], column[3]].map(|along| Vector::new(along / time, 0.0));
            let mut spring = PenaltySpring::<Plane> { spring, given };
            let mut predicted = Vector::new(column[4], 0.0);
            for step in 1..=self.interval {
                velocity -= (place * stiffness + velocity * damping) * (dt / mass);
                velocity += spring.given * self.part();
                if step == self.interval {
                    let prediction_error = (place - predicted) * (1.0 / time);
                    predicted = Self::predicted::<Plane>(&place, &velocity, self.interval, dt);
                    spring = self.after(&spring, mass, (&share.of(&velocity), &share.of(&prediction_error)), &share);
                }
                place += velocity * dt;
            }
            let after = [place[0], velocity[0] * time, spring.spring[0] * time, spring.given[0] * time, predicted[0]];
            column.copy_from_slice(&after);
        }
        if of_state.iter().any(|entry| !entry.is_finite()) {
            return f64::INFINITY;
        }
        of_state.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    /// Where a grain is, m, after so many drifts of `dt`, s, as far as an exchange that leaves it at `position` with `velocity` foresees.
    #[inline(always)]
    pub fn predicted<S: Space>(position: &S::Vector, velocity: &S::Vector, drifts: u64, dt: f64) -> S::Vector {
        *position + *velocity * (drifts as f64 * dt)
    }

    /// A spring after an exchange at which its grain, of `mass` kg, has come to slip at `slip`, u, m/s, among nodes of which the continuum has
    /// `share`; `prediction_error`, m/s, is by how much faster it has slipped since the last one than was predicted then.
    #[inline(always)]
    pub fn after<S: Space>(
        &self,
        spring: &PenaltySpring<S>,
        mass: f64,
        (slip, prediction_error): (&S::Vector, &S::Vector),
        share: &Share<S>,
    ) -> PenaltySpring<S> {
        let stiffness = self.per_mass / mass;
        let spring = share.left_of(&(spring.spring - (*slip + *prediction_error) * stiffness), HOLDS);
        PenaltySpring { spring, given: spring - *slip * (self.damping * stiffness.sqrt()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Linear;

    type Vector = <Plane as Space>::Vector;

    const STIFFNESS: f64 = 1e6;
    const MASS: f64 = 2e-5;
    const PULL: f64 = 300.0;

    /// Place and velocity of a grain after so many steps of `dt` that hangs on still nodes of that share under a constant acceleration and begins with a velocity of `start`.
    fn swung(penalty: &Penalty, (dt, steps): (f64, u64), share: f64, start: f64) -> (Vector, Vector) {
        let share = Share::<Plane>::new(share, [0.0; 3]);
        let (mut spring, mut velocity) = (PenaltySpring::<Plane>::loose(), Vector::new(start, 0.0));
        let (mut place, time) = (Vector::zero(), penalty.interval as f64 * dt);
        let mut predicted = Penalty::predicted::<Plane>(&place, &velocity, penalty.interval - 1, dt);
        for step in 1..=steps {
            velocity += Vector::new(0.0, PULL * dt) + spring.given * penalty.part();
            if step.is_multiple_of(penalty.interval) {
                let prediction_error = (place - predicted) * (1.0 / time);
                predicted = Penalty::predicted::<Plane>(&place, &velocity, penalty.interval, dt);
                spring = penalty.after(&spring, MASS, (&share.of(&velocity), &share.of(&prediction_error)), &share);
            }
            place += velocity * dt;
        }
        (place, velocity)
    }

    /// Way of a grain that is pulled for some time.
    fn hanging(dt: f64, interval: u64, time: f64) -> f64 {
        let penalty = Coupling { stiffness: 0.5, damping: 0.3, interval }.in_steps(STIFFNESS, dt);
        swung(&penalty, (dt, (time / dt).round() as u64), 0.5, 0.0).0[1]
    }

    #[test]
    fn a_grain_slips_by_what_its_load_over_the_springs_stiffness_is_whatever_the_step() {
        let ends = [2e-7, 1e-7, 0.5e-7].map(|dt| hanging(dt, 1, 4e-4));
        // By the part of the spring that the share leaves.
        let wanted = PULL * MASS / (0.5 * STIFFNESS * 0.5);
        assert!(ends.iter().all(|end| (end / wanted - 1.0).abs() < 1e-3), "{ends:?}, {wanted}");
        // On the way there, too, where it still swings.
        let [coarse, fine, finest] = [2e-7, 1e-7, 0.5e-7].map(|dt| hanging(dt, 1, 8e-6));
        assert!((fine - finest).abs() < 0.6 * (coarse - fine).abs() && (coarse / finest - 1.0).abs() < 0.1);
    }

    /// It would by a dt/2, 0.1 mm/s here, if what holds it came at once.
    #[test]
    fn a_grain_that_is_pulled_between_exchanges_does_not_creep() {
        let [soon, late] = [4e-4, 4e-2].map(|time| hanging(2e-7, 4, time));
        assert!((late - soon).abs() < 1e-3 * soon, "{soon}, {late}");
        let every_step = hanging(2e-7, 1, 4e-4);
        assert!((soon / every_step - 1.0).abs() < 0.1, "{soon}, {every_step}");
    }

    /// With dashpots and without, of a mean and of a light grain.
    #[test]
    fn exchanges_after_several_steps_are_stable_between_contacts_where_it_is_said() {
        let most = |mass: f64, damping: f64, weight: f64| {
            let contact = Springs { normal: 1.77e6, damping_normal: damping, ..Springs::default() };
            let of = |interval: u64| Coupling { interval, ..Coupling::DEFAULT };
            (1..20).take_while(|interval| of(*interval).is_stable(&contact, 4e-7, (mass, weight))).last()
        };
        let found = [most(2e-5, 3.5, 0.5), most(2e-5, 0.0, 0.5), most(1.16e-5, 3.5, 0.5), most(1.16e-5, 0.0, 0.5)];
        assert_eq!(found, [Some(6), Some(5), Some(4), Some(3)]);
        assert!(most(1.16e-5, 0.0, 0.1) < Some(3));
        let none = Coupling { stiffness: 0.0, interval: 1000, ..Coupling::DEFAULT };
        assert!(none.is_stable(&Springs { normal: 1.77e6, ..Springs::default() }, 4e-7, (1e-5, 0.5)));
    }

    #[test]
    fn a_spring_without_stiffness_holds_nothing() {
        let penalty = Coupling { stiffness: 0.0, damping: 1.0, interval: 1 }.in_steps(1e6, 1e-7);
        let slip = Vector::new(1.0, 2.0);
        let after =
            penalty.after(&PenaltySpring::loose(), 1e-5, (&slip, &Vector::zero()), &Share::<Plane>::new(0.5, [0.0; 3]));
        assert_eq!(after, PenaltySpring::loose());
    }

    #[test]
    fn springs_are_stable_up_to_their_bound_and_not_beyond() {
        let grows = |coupling: Coupling| {
            let (place, _) = swung(&coupling.in_steps(STIFFNESS, 1e-7), (1e-7, 2000 * coupling.interval), 1.0, 1.0);
            place.norm() > 1e-3 || place.norm().is_nan()
        };
        for damping in [0.0, 0.2, 0.8] {
            for interval in [1, 4] {
                let of = |stiffness: f64| Coupling { stiffness, damping, interval };
                let most = of(0.0).stiffness_max(STIFFNESS, 1e-7, MASS);
                assert!(!grows(of(0.98 * most)), "{damping}, {interval}");
                assert!(grows(of(1.05 * most)), "{damping}, {interval}");
            }
        }
    }
}
