//! Moduli of an elastic solid, which several laws have.

use super::chosen::Described;
use crate::base::keys::{Form, POSITIVE, RATIO, Range, STRESS, number};

/// Moduli of a solid. In the plane strain out of it is zero, so K of `tau = K tr(eps) 1 + 2 G dev(eps)` with the plane's
/// deviator is [`Described::bulk_modulus_in`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// K of the solid in space, Pa.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
}

impl Described for Elastic {
    /// E and nu, or K and G.
    fn keys(&mut self, form: &mut dyn Form) {
        let of_bulk = ["bulk_modulus", "shear_modulus"].into_iter().find(|key| form.has(key));
        let of_young = ["young_modulus", "poisson_ratio"].into_iter().find(|key| form.has(key));
        if let (Some(key), Some(other)) = (of_bulk, of_young) {
            let problem = format!(
                "stands beside material.{other}, and two moduli are enough. Keep young_modulus and poisson_ratio, or bulk_modulus and shear_modulus."
            );
            return form.note(key, &problem);
        }
        if form.describes() || form.is_needed() && of_bulk.is_none() {
            let (mut young, mut poisson) = (0.0, 0.0);
            form.number(&mut young, number("young_modulus", "E", STRESS, POSITIVE, "\"10 MPa\""));
            form.number(&mut poisson, number("poisson_ratio", "Poisson's ratio", RATIO, Range::open(-1.0, 0.5), "0.3"));
            self.bulk_modulus = young / (3.0 * (1.0 - 2.0 * poisson));
            self.shear_modulus = young / (2.0 * (1.0 + poisson));
        }
        if !form.is_needed() || of_bulk.is_some() {
            form.number(&mut self.bulk_modulus, number("bulk_modulus", "K", STRESS, POSITIVE, "\"630 MPa\""));
            form.number(&mut self.shear_modulus, number("shear_modulus", "G", STRESS, POSITIVE, "\"460 MPa\""));
        }
    }

    fn bulk_modulus_in(&self, axes: usize) -> f64 {
        match axes {
            2 => self.bulk_modulus + self.shear_modulus / 3.0,
            _ => self.bulk_modulus,
        }
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }
}
