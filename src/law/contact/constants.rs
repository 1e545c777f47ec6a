//! Keys that several laws have: friction, and dampings in place of which a restitution may be given.

use super::NormalForce;
use crate::base::keys::{ANGLE, Form, RATIO, Range, choose, number, text};
use crate::base::math::{PI, atan2, exp, ln, tan};

/// The Coulomb coefficient, or the tangent of its angle.
pub(super) fn friction(form: &mut dyn Form, value: &mut f64) {
    let mut angle = None;
    let range = Range::closed(0.0, 1.3734);
    form.number_if_given(
        &mut angle,
        number("friction_angle", "the angle whose tangent is mu, in place of friction", ANGLE, range, "\"28.6 deg\"")
            .optional(),
    );
    let Some(angle) = angle else {
        return form.number(
            value,
            number("friction", "mu, the Coulomb coefficient", RATIO, Range::closed(0.0, 5.0), "0.5")
                .required("unless friction_angle is given"),
        );
    };
    if form.has("friction") {
        form.note(
            "friction_angle",
            "stands beside contact.friction, and each says how rough grains are. Keep one of them.",
        );
    }
    *value = tan(angle);
}

pub(super) fn normal_force(form: &mut dyn Form, value: &mut NormalForce) {
    let about =
        "what spring and dashpot may come to: tensile (the dashpot may pull while a contact opens) or repulsive";
    let key = text("normal_force", about, "\"repulsive\"").or("tensile");
    choose(form, value, "range of the normal force", key, &NormalForce::NAMES);
}

/// The restitution, beside which no key of `dampings` may stand.
pub(super) fn restitution(form: &mut dyn Form, dampings: &[&str]) -> Option<f64> {
    let mut restitution = None;
    let about = "the coefficient of restitution of two mean grains, in place of dampings";
    form.number_if_given(
        &mut restitution,
        number("restitution", about, RATIO, Range::open(0.0, 1.0), "0.1").optional(),
    );
    if let (Some(_), Some(key)) = (restitution, dampings.iter().find(|key| form.has(key))) {
        let [others @ .., last] = dampings else { unreachable!("there are dampings") };
        let problem = format!(
            "stands beside contact.{key}, and each says how contacts are damped. Keep restitution, or {} and {last}.",
            others.join(", ")
        );
        form.note("restitution", &problem);
    }
    restitution
}

/// Damping with which two grains rebound with that restitution, in the unit of `critical`, the critical damping of their
/// contact: 2 sqrt(k m) of linear springs, where the effective mass m is half that of each of two equal grains.
///
/// Their overlap is an oscillator with the damping ratio zeta that starts from rest length. Where the dashpot may pull, the
/// contact ends with the overlap; where it only repels, with the force (Schwager & Poeschel 2007, eq. 8 and 21):
///
/// ```text
/// tensile:    e = exp(-pi zeta/w)                                     w = sqrt(|1 - zeta^2|)
/// repulsive:  e = exp(-(zeta/w) atan2(2 zeta w, 2 zeta^2 - 1))        zeta < 1
///             e = exp(-2 (zeta/w) ln(zeta + w))                       zeta > 1
/// ```
///
/// Hertz contacts with a dashpot 2 sqrt(5/6) zeta sqrt(m k_n), k_n = dF_n/dd, are the same oscillator in d^(5/4) and a time
/// of their own, so that e does not depend on speed (Antypov & Elliott 2011; Tsuji et al. 1992 have the dashpot). Their force
/// is nought where that oscillator's acceleration is: both lines hold for them too.
pub(super) fn damping_of(restitution: f64, normal_force: NormalForce, critical: f64) -> f64 {
    if normal_force == NormalForce::TENSILE {
        let logarithm = ln(restitution);
        return -logarithm * critical / (PI * PI + logarithm * logarithm).sqrt();
    }
    // The rebound falls with the damping ratio; at the upper end, above 1, it is below 1/zeta^2.
    let (mut lower, mut upper) = (0.0, 1.0 + 1.0 / restitution.sqrt());
    loop {
        let middle = 0.5 * (lower + upper);
        if middle <= lower || middle >= upper {
            return middle * critical;
        }
        if rebound_repulsive(middle) > restitution { lower = middle } else { upper = middle }
    }
}

/// Restitution of a contact that ends when its force is nought, by its damping ratio.
fn rebound_repulsive(ratio: f64) -> f64 {
    let root = (1.0 - ratio * ratio).abs().sqrt();
    if root == 0.0 {
        return exp(-2.0);
    }
    let angle = match ratio < 1.0 {
        true => atan2(2.0 * ratio * root, 2.0 * ratio * ratio - 1.0),
        false => 2.0 * ln(ratio + root),
    };
    exp(-ratio / root * angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A damping ratio that gives a rebound is found from it again, below and above critical damping, and a dashpot that only
    /// repels needs more of it: the end of a contact, where it would have pulled, slows nothing.
    #[test]
    fn a_restitution_becomes_the_damping_ratio_that_gives_it() {
        for ratio in [1e-6, 0.01, 0.3, 0.7, 0.99, 1.0, 1.01, 3.0, 1e4] {
            let restitution = rebound_repulsive(ratio);
            let found = damping_of(restitution, NormalForce::REPULSIVE, 1.0);
            assert!((found / ratio - 1.0).abs() < 1e-8, "{ratio}: {found} by {restitution}");
            assert!(found > damping_of(restitution, NormalForce::TENSILE, 1.0));
        }
    }
}
