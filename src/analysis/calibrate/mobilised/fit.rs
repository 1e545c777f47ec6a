//! The law with mobilised friction as a [`Model`]: what element tests tell of it.
//!
//! K and G_0 are given. Shear that begins tells a, kappa_0 and, from two solid volume fractions, w; the shear stress and the volume on
//! phi_cs, Phi_cs, chi and k_d; unloading on the way and from the peak r and a_G. Of grains that cohere phi_cs is given, as the same grains have it without
//! cohesion, and c is found.

use crate::analysis::calibrate::element::Row;
use crate::analysis::calibrate::least_squares::Parameter;
use crate::analysis::calibrate::model::{Curve, Model, follow};
use crate::base::math;
use crate::law::material::{MobilisedConstants, MobilisedFriction};

/// Parameters that are found.
pub const COUNT: usize = 9;
/// Where the fit starts: figures of discs, hardening as their tests from two solid volume fractions have it.
const START: MobilisedConstants = MobilisedConstants {
    hardening_strain: 5e-3,
    hardening_fraction_width: Some(WIDTH_START),
    hardening_start: 0.1,
    ..MobilisedConstants::DISCS
};
const WIDTH_START: f64 = 0.01;
/// r that the fit starts from: the first of these that makes a law.
const SHARES_START: [f64; 4] = [0.5, 0.3, 0.1, 0.0];
/// At a w of 1 hardening does not depend on Phi any more.
const WIDTHS: [f64; 2] = [1e-3, 1.0];

/// What is given, and where the fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given {
    /// 2 of discs, 3 of spheres.
    pub axes: usize,
    /// K and G_0, Pa.
    pub moduli: [f64; 2],
    /// tan(phi_cs) of the same grains without cohesion.
    pub friction_critical: Option<f64>,
    /// tan(phi_cs) and Phi_cs as the end of the tests has them.
    pub critical: [f64; 2],
    /// Normal stress of the tests, Pa: of cohesion there is not more.
    pub stress: f64,
    /// The loosest start, from which on a return to the cone must be unique.
    pub fraction_loosest: f64,
}

/// A law that follows tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// K, G_0 and, of grains that cohere, phi_cs as given; the rest as found.
    pub constants: MobilisedConstants,
    /// The keys of its parameters that stopped at a bound: the tests do not tell them.
    pub at_bound: Vec<&'static str>,
    /// As the fit knows them, for another that starts from here.
    pub at: [f64; COUNT],
}

impl Given {
    /// Strains of softening and hardening as their logarithms: they are positive, and known by their order.
    fn constants(&self, at: &[f64; COUNT]) -> MobilisedConstants {
        let [share, degradation, last, fraction, dilation, hardening, transformation, width, start] = *at;
        MobilisedConstants {
            bulk_modulus: self.moduli[0],
            shear_modulus: self.moduli[1],
            shear_degradation: share,
            shear_degradation_strain: math::exp(degradation),
            friction_angle_critical: math::atan(self.friction_critical.unwrap_or(last)),
            fraction_critical: fraction,
            fraction: Some(fraction.max(self.fraction_loosest)),
            dilation_factor: dilation,
            hardening_strain: math::exp(hardening),
            hardening_fraction_width: Some(math::exp(width)),
            hardening_start: start,
            phase_transformation_factor: transformation,
            cohesion: self.friction_critical.map_or(0.0, |_| last * self.stress),
        }
    }
}

impl Model<COUNT> for Given {
    type Law = MobilisedFriction;

    fn parameters(&self) -> [(&'static str, Parameter); COUNT] {
        let of = |start, lower, upper, scale| Parameter { start, lower, upper, scale };
        let strain = |start| of(math::ln(start), math::ln(1e-6), math::ln(0.1), 0.3);
        let [friction, fraction] = self.critical;
        let last = match self.friction_critical {
            Some(_) => ("cohesion", of(0.05, 0.0, 3.0, 0.02)),
            None => ("friction_angle_critical", of(friction, 0.01, 5.0, 0.03)),
        };
        let parameters = |share| {
            [
                ("shear_modulus_degradation", of(share, 0.0, 0.99, 0.1)),
                ("shear_degradation_strain", strain(START.shear_degradation_strain)),
                last,
                // As far as grains of any size can be packed.
                ("fraction_critical", of(fraction, fraction - 0.1, fraction + 0.1, 0.005)),
                ("dilation_factor", of(START.dilation_factor, 0.0, 100.0, 1.0)),
                ("hardening_strain", strain(START.hardening_strain)),
                ("phase_transformation_factor", of(START.phase_transformation_factor, 0.0, 100.0, 1.0)),
                ("hardening_fraction_width", of(math::ln(WIDTH_START), math::ln(WIDTHS[0]), math::ln(WIDTHS[1]), 0.2)),
                ("hardening_start", of(START.hardening_start, 0.0, 0.9, 0.05)),
            ]
        };
        // Loose material that contracts much needs a stiffness that is not lost.
        let is_law = |share: &&f64| self.law(&parameters(**share).map(|(_, parameter)| parameter.start)).is_some();
        parameters(*SHARES_START.iter().find(is_law).unwrap_or(&SHARES_START[0]))
    }

    fn law(&self, at: &[f64; COUNT]) -> Option<MobilisedFriction> {
        let constants = self.constants(at);
        (constants.stiffness_least(self.axes, self.fraction_loosest).0 > 0.0).then(|| MobilisedFriction::of(&constants))
    }

    /// Mass is kept, elastic volume with it.
    fn fraction(_: &Row, volume: f64, start: f64) -> f64 {
        start / volume
    }
}

/// The law that follows the curves with the least squares, from another fit's end if there is one; none where the usual start is no
/// law that bears the tests.
pub fn fit(given: &Given, curves: &[Curve], start: Option<&[f64; COUNT]>) -> Option<Fit> {
    // Where that end is no law of these tests, from the usual start.
    let found = start.and_then(|start| follow(given, curves, Some(start)));
    let (at, at_bound) = found.or_else(|| follow(given, curves, None))?;
    Some(Fit { constants: given.constants(&at), at_bound, at })
}
