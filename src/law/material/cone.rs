//! The cone of critical-state Drucker-Prager as its constants state it, for what is told before a run. Equations and signs are those
//! of [`super::CriticalDruckerPrager`].

use super::chosen::Objection;
use super::critical_drucker_prager::CriticalConstants;
use crate::base::digits::{digits, digits_below, significant};
use crate::base::math::{PI, atan, tan};

/// Points of the way of the solid volume fraction to its critical value that are looked at.
const LOOKS: u32 = 1000;

/// Friction and dilation at a solid volume fraction: `q + eta p = zeta c` on the cone.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Friction: sin(phi) in the plane, 6 sin(phi)/(sqrt(3) (3 - sin(phi))) in space.
    pub eta: f64,
    /// Dilation, the same of psi: etabar.
    pub eta_bar: f64,
    /// What cohesion counts with: cos(phi) in the plane, 6 cos(phi)/(sqrt(3) (3 - sin(phi))) in space.
    pub zeta: f64,
}

/// What to do about a fraction from which the return cannot bear softening, at the end of the sentence of
/// [`CriticalConstants::unbearable`].
const FRACTION_NEARER: &str = "bring the fraction nearer to fraction_critical, or lower dilation_factor";

impl CriticalConstants {
    /// Friction and dilation at a solid volume fraction: tan(phi) and tan(psi).
    pub fn tangents(&self, fraction: f64) -> (f64, f64) {
        let surplus = self.dilation_factor * (fraction - self.fraction_critical);
        (tan(self.friction_angle_critical) + surplus, self.dilation_angle.map_or(surplus, tan))
    }

    /// The cone at a solid volume fraction, of the plane or of space by `axes`; a friction angle below zero counts as zero.
    pub fn cone(&self, axes: usize, fraction: f64) -> Cone {
        let (friction, dilation) = self.tangents(fraction);
        let [sine, sine_bar] = [friction.max(0.0), dilation].map(|tangent| tangent / (1.0 + tangent * tangent).sqrt());
        let cosine = (1.0 - sine * sine).sqrt();
        if axes == 2 {
            return Cone { eta: sine, eta_bar: sine_bar, zeta: cosine };
        }
        let of = |sine: f64| 6.0 / (3.0f64.sqrt() * (3.0 - sine));
        Cone { eta: sine * of(sine), eta_bar: sine_bar * of(sine_bar), zeta: cosine * of(sine) }
    }

    /// The least of `G + K eta etabar`, which plastic flow is divided by, and the solid volume fraction that has it, from a
    /// fraction on. Flow takes a loose material to its critical fraction, and neither end of the way need be the worst: at
    /// the one there may be no friction, at the other there is no dilation.
    pub fn stiffness_least(&self, axes: usize, fraction: f64) -> (f64, f64) {
        let of = |fraction: f64| {
            let Cone { eta, eta_bar, .. } = self.cone(axes, fraction);
            (self.shear_modulus + self.bulk_modulus * eta * eta_bar, fraction)
        };
        let moves = self.softening_rate > 0.0 && fraction < self.fraction_critical;
        let way = if moves { self.fraction_critical - fraction } else { 0.0 };
        let looks = if moves { LOOKS } else { 0 };
        (1..=looks)
            .map(|look| of(fraction + way * f64::from(look) / f64::from(LOOKS)))
            .fold(of(fraction), |least, other| if other.0 < least.0 { other } else { least })
    }
    /// Why plastic flow from a solid volume fraction on has no end, as the beginning of a sentence, if it has none.
    pub fn unbearable(&self, axes: usize, fraction: f64) -> Option<String> {
        let (stiffness, at) = self.stiffness_least(axes, fraction);
        (stiffness <= 0.0).then(|| {
            format!(
                "softens more than the shear modulus can bear: flow is divided by G + K eta etabar, which must be positive and is {} Pa at a solid volume fraction of {}. Write a shear_modulus of more than {} Pa",
                significant(stiffness, 3),
                digits((1e4 * at).round() / 1e4),
                digits((self.shear_modulus - stiffness).ceil()),
            )
        })
    }

    /// The cone must exist at the start, flow on it must not give back more work than friction takes, and a return to it
    /// must be possible.
    pub(super) fn objection_to(&self, axes: usize, fraction: f64) -> Option<Objection> {
        let because = |key: &'static str, problem: String| Some(Objection { key, problem });
        if self.friction_angle_critical == 0.0 && self.cohesion == 0.0 {
            let problem = "bears no shear at all, since cohesion is 0 too. Give the material friction or cohesion.";
            return because("friction_angle_critical", problem.to_string());
        }
        let (friction, dilation) = self.tangents(fraction);
        if friction < 0.0 {
            let problem = format!(
                "makes the friction angle negative: tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs) is {}. Write a fraction of at least {}.",
                digits_below(friction),
                digits((1e4 * (fraction - friction / self.dilation_factor)).ceil() / 1e4)
            );
            return because("fraction", problem);
        }
        let is_constant = self.dilation_angle.is_some();
        if let Some(problem) = self.unbearable(axes, fraction) {
            return match is_constant {
                true => because("dilation_angle", format!("{problem}, or write a dilation angle nearer to zero.")),
                false => because("fraction", format!("{problem}, or {FRACTION_NEARER}.")),
            };
        }
        if dilation <= friction {
            return None;
        }
        match is_constant {
            true => because(
                "dilation_angle",
                format!(
                    "is more than the friction angle, {} deg, so that flow would give more work than it takes. Write at most that.",
                    digits_below(atan(friction) * 180.0 / PI)
                ),
            ),
            false => because(
                "fraction",
                "makes the dilation angle more than the friction angle. Take a lower fraction.".to_string(),
            ),
        }
    }
}

/// The least and the largest `k0` of a stress `-overburden` along one axis and k0 times it along the others that the cone
/// `q + eta p = borne overburden` bears.
pub(super) fn k0_of(axes: usize, eta: f64, borne: f64) -> [f64; 2] {
    // q = root |1 - k0| overburden, p = -(1 + (axes - 1) k0) overburden/axes.
    let root = if axes == 2 { 0.5 } else { 1.0 / 3.0f64.sqrt() };
    let along = eta / axes as f64;
    let across = along * (axes - 1) as f64;
    let most = if root > across { (root + along + borne) / (root - across) } else { f64::INFINITY };
    [(root - along - borne) / (root + across), most]
}

impl Cone {
    /// The least and the largest `k0` of a stress `-overburden` along one axis and k0 times it along the others that the
    /// cone bears; an overburden of zero is borne with any.
    pub fn k0(&self, axes: usize, overburden: f64, cohesion: f64) -> [f64; 2] {
        k0_of(axes, self.eta, self.zeta * cohesion / overburden)
    }
}
