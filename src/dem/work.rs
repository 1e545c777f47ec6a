//! What becomes of the work of a contact: springs store it, dashpots and slip lose it, and what slides by the law's
//! reckoning is not quite what its forces act on.

use crate::base::space::{Lanewise, Space, Words};
use crate::dem::kernel::Given;
use crate::dem::law::Law;
use crate::law::contact::{Answer, Memory, Touch};

/// Forces of a contact at the last evaluation, weighted: those of springs, and the rest, which is dashpots.
#[derive(Clone, Copy, Debug)]
pub struct Parted<S: Space> {
    springs: Answer<S, f64>,
    dashpots: Answer<S, f64>,
    overlap: f64,
    slides: bool,
}

/// Powers that a motion loses, W.
#[derive(Clone, Copy, Debug)]
pub struct Losses {
    /// To dashpots, but for the tangential one of a contact that slides.
    pub viscous: f64,
    /// To the dashpot of a contact that slides: friction limits it together with the spring, whose share
    /// [`Settled::slipped`] tells, and neither means anything alone.
    pub sliding: f64,
    /// To the levers of the tangential force: it works at another rate than its spring stretches at ([`Parted::losses`]).
    pub levers: f64,
}

/// Sliding contacts carry their limit to rounding.
const LIMIT_REACHED: f64 = 1.0 - 1e-9;

impl<S: Space> Parted<S> {
    /// `memory` is that after the evaluation, `arm` the lever that the torque on `a` has, m. None where the contact does
    /// not hold.
    pub fn of(
        law: &dyn Law<S>,
        touch: &Touch<S, f64>,
        memory: &Memory,
        given: &Given<S, f64>,
        [weight, arm]: [f64; 2],
    ) -> Option<Self> {
        if !law.holds(touch, memory) {
            return None;
        }
        let Answer { normal, tangential, moment } = law.springs(touch, memory);
        let springs = Answer { normal: normal * weight, tangential: tangential * weight, moment: moment * weight };
        let tangential = S::tangential(&touch.normal, &given.force);
        let moment = given.torque_a + S::torque(&touch.normal, &tangential) * arm;
        let normal = given.force.dot(&touch.normal);
        let limit = weight * law.friction_limit(touch, normal / weight);
        let dashpots = Answer {
            normal: normal - springs.normal,
            tangential: tangential - springs.tangential,
            moment: moment - springs.moment,
        };
        let slides = tangential.norm() > LIMIT_REACHED * limit;
        Some(Self { springs, dashpots, overlap: touch.overlap, slides })
    }

    /// What the motion in `touch` loses. Linear in the motion, so that it may be that of one side alone. `turning` is the
    /// sum of the spins of these sides: forces act in the middle of the overlap, half of it off the points whose
    /// velocities the law takes.
    ///
    /// ```text
    /// u = v_t + (w_a + w_b) x n d/2        what the tangential force works on
    /// lost by levers = -F_spring.(u - s'),  s' the rate at which the spring stretches
    /// ```
    pub fn losses(&self, law: &dyn Law<S>, touch: &Touch<S, f64>, turning: &S::SpinOf<f64>) -> Losses {
        let moved = touch.velocity_tangential + S::surface(&touch.normal, turning) * (0.5 * self.overlap);
        let along = -self.dashpots.tangential.dot(&moved);
        let others = -self.dashpots.normal * touch.velocity_normal - self.dashpots.moment.dot(&touch.spin_relative);
        let (viscous, sliding) = if self.slides { (others, along) } else { (others + along, 0.0) };
        Losses { viscous, sliding, levers: -self.springs.tangential.dot(&(moved - law.sliding(touch))) }
    }
}

/// What a contact holds, and what its springs did over the last drift, unweighted, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settled {
    /// Elastic energy.
    pub elastic: f64,
    /// Taken up by the tangential and rolling springs and not stored: slip, springs forgotten where a contact ends, and
    /// the energy that stays behind when a contact breaks in tension.
    pub slipped: f64,
    /// Given by the springs beyond what they had stored: the error of the time step, which no physics accounts for. The
    /// normal spring works by the trapezoidal rule, which is off where a contact begins or ends within a drift and by
    /// third order elsewhere; the tangential one stretches by the sliding in the tangent plane at the drift's end, which
    /// has turned by then.
    pub made: f64,
}

/// One end of a drift as a spring sees it.
struct End<S: Space> {
    holds: bool,
    /// Energies of the normal spring and of all, J.
    stored_normal: f64,
    stored: f64,
    answer: Answer<S, f64>,
}

impl<S: Space> End<S> {
    fn of(law: &dyn Law<S>, touch: &Touch<S, f64>, memory: &Memory) -> Self {
        if !law.holds(touch, memory) {
            let answer = Answer { normal: 0.0, tangential: Words::zero(), moment: Words::zero() };
            return Self { holds: false, stored_normal: 0.0, stored: 0.0, answer };
        }
        let stored_normal = law.elastic_energy(touch, &Memory::blank(law.memory_words()));
        let stored = law.elastic_energy(touch, memory);
        Self { holds: true, stored_normal, stored, answer: law.springs(touch, memory) }
    }
}

/// A contact from one evaluation to the next, each with its touch and the memory after it. Both touches carry the
/// velocities of the drift in between; `now` has the time that it took.
///
/// ```text
/// slipped = -(f(n) + f(n-1)).s/2 - (M(n) + M(n-1)).theta/2 - (E_t(n) - E_t(n-1))     s, theta as the law advances them,
///                                                                                   f(n-1), M(n-1) carried along
/// made    = work on the motion by half steps - what slip and energies account for
/// ```
pub fn settle<S: Space>(
    law: &dyn Law<S>,
    [before, now]: [&Touch<S, f64>; 2],
    [memory_before, memory]: [&Memory; 2],
) -> Settled {
    let (first, last) = (End::of(law, before, memory_before), End::of(law, now, memory));
    let dt = now.advance;
    let sliding = law.sliding(now);
    let rolling = S::rolling(&now.normal, &now.spin_relative);
    let tangential = S::carry(&now.normal, now.twist, &first.answer.tangential);
    let moment = S::carry_spin(&now.normal, now.twist, &first.answer.moment);
    // What the springs gave to the motion over the half step behind `now`, and before that, by the law and by the forces.
    let given = 0.5 * dt * (last.answer.tangential.dot(&sliding) + last.answer.moment.dot(&rolling));
    let given_by_law = 0.5 * dt * (tangential.dot(&sliding) + moment.dot(&rolling));
    let turned = first.answer.tangential.dot(&law.sliding(before))
        + first.answer.moment.dot(&S::rolling(&before.normal, &before.spin_relative));
    let given_by_forces = 0.5 * dt * turned;
    let given_normal =
        0.5 * dt * (last.answer.normal * now.velocity_normal + first.answer.normal * before.velocity_normal);

    let kept = (last.stored - last.stored_normal) - (first.stored - first.stored_normal);
    let slipped = -given - given_by_law - kept;
    let made_normal = given_normal + (last.stored_normal - first.stored_normal);
    let made = given_by_forces - given_by_law;
    // A contact that ends while it pulls breaks, half way through the drift as far as the step can tell.
    match first.answer.normal < 0.0 && !last.holds && now.overlap < 0.0 {
        true => Settled { elastic: last.stored, slipped: slipped - made_normal, made },
        false => Settled { elastic: last.stored, slipped, made: made + made_normal },
    }
}
