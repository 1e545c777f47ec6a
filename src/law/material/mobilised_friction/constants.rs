//! Constants of the law with mobilised friction: their keys, and what they rule out before a run.

use super::MobilisedFriction;
use crate::base::digits::{digits, significant};
use crate::base::keys::{ANGLE, Form, NOT_NEGATIVE, POSITIVE, RATIO, Range, STRESS, number};
use crate::base::space::{Plane, Solid};
use crate::law::material::chosen::{Described, FRACTION, Objection};
use crate::law::material::cone::k0_of;
use crate::law::material::critical_drucker_prager::DILATION_FACTOR;

/// Constants of [`MobilisedFriction`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MobilisedConstants {
    /// K, Pa: in the plane that of p = tr(tau)/2, in space that of p = tr(tau)/3.
    pub bulk_modulus: f64,
    /// G_0, Pa: before any plastic shear.
    pub shear_modulus: f64,
    /// r, the share of G_0 that plastic shear takes in the end.
    pub shear_degradation: f64,
    /// a_G, the plastic shear strain that takes half of that.
    pub shear_degradation_strain: f64,
    /// phi_cs, rad.
    pub friction_angle_critical: f64,
    /// Phi_cs.
    pub fraction_critical: f64,
    /// Phi that points start with, unless their region has its own; none where a packing tells it.
    pub fraction: Option<f64>,
    /// chi of tan(phi_b) = tan(phi_cs) + chi (Phi - Phi_cs).
    pub dilation_factor: f64,
    /// a_cs, the plastic shear strain that mobilises half of the friction that is left of kappa_0, at Phi_cs if there is a w.
    pub hardening_strain: f64,
    /// w of a = a_cs (1 - x/sqrt(1 + x^2)), x = (Phi - Phi_cs)/w; none: a is a_cs at any Phi.
    pub hardening_fraction_width: Option<f64>,
    /// kappa_0, the share of the peak friction that is borne before any plastic shear.
    pub hardening_start: f64,
    /// k_d of sin(phi_d) = sin(phi_cs) - k_d (Phi - Phi_cs).
    pub phase_transformation_factor: f64,
    /// c, Pa.
    pub cohesion: f64,
}

/// Solid volume fractions above the critical one that are looked at.
const LOOKS: u32 = 400;

impl MobilisedConstants {
    /// Of the grains of Table 1 of Chen et al. (2021): the mean of simulated simple shear of packings of 2,000 of them
    /// under 400 kPa, from a solid volume fraction of 0.843, and one reversal at the peak.
    pub const DISCS: Self = Self {
        bulk_modulus: 86.4e6,
        shear_modulus: 55.7e6,
        shear_degradation: 0.7,
        shear_degradation_strain: 1e-3,
        // tan(phi_cs) = 0.282
        friction_angle_critical: 0.274_862_337_799_172_9,
        fraction_critical: 0.8165,
        fraction: Some(0.843),
        dilation_factor: 7.68,
        hardening_strain: 2.75e-4,
        hardening_fraction_width: None,
        hardening_start: 0.0,
        phase_transformation_factor: 4.86,
        cohesion: 0.0,
    };

    /// m_b and m_d at a solid volume fraction.
    pub fn ratios(&self, axes: usize, fraction: f64) -> [f64; 2] {
        MobilisedFriction::of(self).ratios(axes, fraction)
    }

    /// The least of `G_0 (1 - r) - K m_b m_d`, which the return is unique with, and the solid volume fraction that has
    /// it, from a fraction on. A loose material contracts to its critical fraction, where m_d is smaller; beyond it
    /// contraction under cyclic shear has no other bound than m_d = 0.
    pub fn stiffness_least(&self, axes: usize, fraction: f64) -> (f64, f64) {
        let law = MobilisedFriction::of(self);
        let left = self.shear_modulus * (1.0 - self.shear_degradation);
        let of = |fraction: f64| {
            let [peak, transformation] = law.ratios(axes, fraction);
            (left - self.bulk_modulus * peak * transformation, fraction)
        };
        let critical = self.fraction_critical;
        let looks = (0..=LOOKS).map(|look| of(critical + (1.0 - critical) * f64::from(look) / f64::from(LOOKS)));
        looks.fold(of(fraction.min(critical)), |least, other| if other.0 < least.0 { other } else { least })
    }
}

impl MobilisedFriction {
    fn ratios(&self, axes: usize, fraction: f64) -> [f64; 2] {
        match axes {
            2 => [self.peak::<Plane, f64>(fraction), self.transformation::<Plane, f64>(fraction)],
            _ => [self.peak::<Solid, f64>(fraction), self.transformation::<Solid, f64>(fraction)],
        }
    }
}

impl Described for MobilisedConstants {
    fn keys(&mut self, form: &mut dyn Form) {
        form.number(&mut self.bulk_modulus, number("bulk_modulus", "K", STRESS, POSITIVE, "\"86.4 MPa\""));
        let about = "G, before any plastic shear";
        form.number(&mut self.shear_modulus, number("shear_modulus", about, STRESS, POSITIVE, "\"55.7 MPa\""));
        let about = "the share of the shear modulus that is lost as plastic shear goes on";
        form.number(
            &mut self.shear_degradation,
            number("shear_modulus_degradation", about, RATIO, Range::below(0.0, 1.0), "0.7"),
        );
        let about = "the plastic shear strain at which half of that is lost";
        form.number(
            &mut self.shear_degradation_strain,
            number("shear_degradation_strain", about, RATIO, POSITIVE, "1e-3"),
        );
        form.number(
            &mut self.friction_angle_critical,
            number("friction_angle_critical", "phi_cs", ANGLE, Range::open(0.0, 1.3734), "\"30 deg\""),
        );
        form.number(
            &mut self.fraction_critical,
            number("fraction_critical", "Phi_cs", RATIO, Range::open(0.0, 1.0), "0.815"),
        );
        form.number_if_given(&mut self.fraction, FRACTION);
        form.number(
            &mut self.dilation_factor,
            number("dilation_factor", DILATION_FACTOR, RATIO, Range::closed(0.0, 100.0), "7"),
        );
        let about = "the plastic shear strain that mobilises half of the friction, with hardening_fraction_width at the critical solid volume fraction";
        form.number(&mut self.hardening_strain, number("hardening_strain", about, RATIO, POSITIVE, "3e-4"));
        let about = "w of a = a_cs (1 - x/sqrt(1 + x^2)), x = (Phi - Phi_cs)/w, a_cs being hardening_strain: looser material hardens over a longer strain, denser over a shorter one";
        let width = number("hardening_fraction_width", about, RATIO, Range::closed(1e-4, 100.0), "0.0085");
        form.number_if_given(&mut self.hardening_fraction_width, width.optional());
        let about = "kappa_0, the share of the peak friction that material bears before any plastic shear: hardening_strain mobilises half of the rest";
        let share = number("hardening_start", about, RATIO, Range::below(0.0, 1.0), "0.15");
        form.number(&mut self.hardening_start, share.or("0.0"));
        let about = "k_d of sin(phi_d) = sin(phi_cs) - k_d (Phi - Phi_cs), the friction at which contraction turns into dilation";
        form.number(
            &mut self.phase_transformation_factor,
            number("phase_transformation_factor", about, RATIO, Range::closed(0.0, 100.0), "5"),
        );
        form.number(&mut self.cohesion, number("cohesion", "c", STRESS, NOT_NEGATIVE, "\"10 kPa\"").or("0.0"));
    }

    /// As it is given: that of the space it is for.
    fn bulk_modulus_in(&self, _: usize) -> f64 {
        self.bulk_modulus
    }

    /// G_0.
    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    fn fraction(&self) -> Option<f64> {
        self.fraction
    }

    fn set_fraction(&mut self, fraction: Option<f64>) {
        self.fraction = fraction;
    }

    fn yields(&self) -> bool {
        true
    }

    /// A return to the cone must be unique.
    fn objection(&self, axes: usize, fraction: f64) -> Option<Objection> {
        let (stiffness, at) = self.stiffness_least(axes, fraction);
        if stiffness > 0.0 {
            return None;
        }
        let left = self.shear_modulus * (1.0 - self.shear_degradation);
        let problem = format!(
            "is too low for contraction in shear: what shear_modulus_degradation leaves of it, {} Pa, must be more than K m_b m_d, and that is {} Pa at a solid volume fraction of {}. Write more than {} Pa, or a lower shear_modulus_degradation, bulk_modulus or friction_angle_critical; a fraction nearer to fraction_critical helps loose material.",
            significant(left, 3),
            significant(left - stiffness, 3),
            digits((1e4 * at).round() / 1e4),
            digits(((left - stiffness) / (1.0 - self.shear_degradation)).ceil()),
        );
        Some(Objection { key: "shear_modulus", problem })
    }

    fn k0(&self, axes: usize, fraction: f64, overburden: f64) -> Option<[f64; 2]> {
        let [peak, _] = self.ratios(axes, fraction);
        let borne = peak * MobilisedFriction::of(self).attraction;
        Some(k0_of(axes, peak, borne / overburden))
    }
}
