//! The cone of critical-state Drucker-Prager as its constants state it, for what is told before a run. Equations and signs are those
//! of [`super::CriticalDruckerPrager`].

use super::critical_drucker_prager::CriticalConstants;
use crate::base::math::tan;

/// Points of the way of the solid volume fraction to its critical value that are looked at.
const LOOKS: u32 = 1000;

/// Friction and dilation at a solid volume fraction: `q + eta p = zeta c` on the cone.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub eta: f64,
    pub eta_bar: f64,
    pub zeta: f64,
}

impl CriticalConstants {
    /// Friction and dilation at a solid volume fraction: tan(phi) and tan(psi).
    pub fn tangents(&self, fraction: f64) -> (f64, f64) {
        let surplus = self.dilation_factor * (fraction - self.fraction_critical);
        (tan(self.friction_angle_critical) + surplus, self.dilation_angle.map_or(surplus, tan))
    }

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
}

impl Cone {
    /// The least and the largest `k0` of a stress `-overburden` along one axis and k0 times it along the others that the
    /// cone bears; an overburden of zero is borne with any.
    pub fn k0(&self, axes: usize, overburden: f64, cohesion: f64) -> [f64; 2] {
        // q = root |1 - k0| overburden, p = -(1 + (axes - 1) k0) overburden/axes.
        let root = if axes == 2 { 0.5 } else { 1.0 / 3.0f64.sqrt() };
        let along = self.eta / axes as f64;
        let across = along * (axes - 1) as f64;
        let borne = self.zeta * cohesion / overburden;
        let most = if root > across { (root + along + borne) / (root - across) } else { f64::INFINITY };
        [(root - along - borne) / (root + across), most]
    }
}
