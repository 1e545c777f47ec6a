//! Hertz's normal force with an incremental tangential force after Mindlin and Coulomb friction: Liu et al. (2016),
//! eq. 53 to 56.
//!
//! ```text
//! dF_n = k_n dd,  k_n = sqrt(2) G sqrt(R_e)/(1 - nu) sqrt(d)            (53)   so F_n = 2/3 k_n d
//! dF_t = k_t ds,  k_t = 2 sqrt(2) G sqrt(R_e)/(2 - nu) sqrt(d)          (54)   |F_t| <= mu F_n
//! R_e  = 2 R_1 R_2/(R_1 + R_2)                                          (55)
//! dashpots  -C_n v_n and -C_t v_t beside the springs                    (56)
//! C    = gamma + 2 sqrt(5/6) zeta sqrt(m k_n),  m = m_1 m_2/(m_1 + m_2)
//! F_n  = max(2/3 k_n d - C_n v_n, 0)             normal_force = "repulsive"
//! F_t <- F_t sqrt(d/d_before)  where d < d_before  tangential_force = "rescaled"
//! ```
//!
//! gamma is the constant damping of the paper, with which the rebound depends on speed. With zeta it does not (Tsuji et al.
//! 1992; Antypov & Elliott 2011), both ways having the same dashpot; a grain that a body moves has a mass without bounds.
//!
//! The normal increments integrate to Hertz's closed form, which is what is computed. The tangential force remembers its
//! elastic part and is cut with its dashpot to the cone of the elastic normal force. The normal dashpot may pull while a
//! contact opens, unless it is limited to repel. Against a flat body R_2 is without bounds.
//!
//! By (54) alone the tangential force is kept while a contact opens and its stiffness falls, so that what is stored in it,
//! F_t^2/(2 k_t), grows from nothing (Elata & Berryman 1996): up to 2e-4 of the energy of an impact that hardly slides. Rescaled it
//! falls with the radius of the contact, which cannot bear what it bore (Walton 1987), and no impact gains.

use super::{Answer, ContactLaw, Described, Force, NormalForce, Springs, Stiffening, Touch, constants};
use crate::base::keys::{DAMPING, Form, NOT_NEGATIVE, POSITIVE, RATIO, Range, STRESS, choose, number, text};
use crate::base::lane::Real;
use crate::base::space::{Lanewise, Space, Words};

/// Hertz normal force, incremental Mindlin tangential force (Liu et al. 2016, eq. 53 to 56).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzMindlin {
    /// G_g, Pa.
    pub shear_modulus: f64,
    /// nu.
    pub poisson_ratio: f64,
    /// mu, the Coulomb coefficient.
    pub friction: f64,
    /// Viscosity of contacts, N s/m.
    pub damping_normal: f64,
    /// gamma_t, N s/m.
    pub damping_tangential: f64,
    /// zeta: dashpots of 2 sqrt(5/6) zeta sqrt(m k_n) beside those, both ways, with the effective mass m. In a job either this or
    /// the `restitution` that it gives at every speed.
    pub damping_ratio: f64,
    /// Whether the normal dashpot may pull.
    pub normal_force: NormalForce,
    /// What becomes of its elastic part while a contact opens.
    pub tangential_force: TangentialForce,
}

/// What becomes of the elastic tangential force while a contact opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TangentialForce {
    /// It is the sum of its increments, as in the paper.
    #[default]
    Incremental,
    /// It falls with the radius of the contact.
    Rescaled,
}

impl TangentialForce {
    /// As jobs name them.
    pub const NAMES: [(&'static str, Self); 2] = [("incremental", Self::Incremental), ("rescaled", Self::Rescaled)];

    /// As jobs name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Incremental => "incremental",
            Self::Rescaled => "rescaled",
        }
    }
}

impl HertzMindlin {
    pub(super) const ASLEEP: Self = Self {
        shear_modulus: 29e9,
        poisson_ratio: 0.15,
        friction: 0.5,
        damping_normal: 0.0,
        damping_tangential: 0.0,
        damping_ratio: 0.0,
        normal_force: NormalForce::TENSILE,
        tangential_force: TangentialForce::Incremental,
    };

    /// k_n and k_t at an overlap.
    #[inline(always)]
    fn springs_of<R: Real>(&self, radius_a: R, radius_b: R, overlap: R) -> [R; 2] {
        let root_two = std::f64::consts::SQRT_2;
        let radius = R::splat(2.0) * radius_a * radius_b / (radius_a + radius_b);
        let root = (radius * R::max(overlap, R::splat(0.0))).sqrt();
        let normal = root_two * self.shear_modulus / (1.0 - self.poisson_ratio);
        let tangential = 2.0 * root_two * self.shear_modulus / (2.0 - self.poisson_ratio);
        [root * R::splat(normal), root * R::splat(tangential)]
    }

    /// What is left of the elastic part of the tangential force that a contact came with.
    #[inline(always)]
    fn carried<S: Space, R: Real>(&self, touch: &Touch<S, R>, elastic: &S::TangentOf<R>) -> S::TangentOf<R> {
        let carried = S::carry(&touch.normal, touch.twist, elastic);
        // One answer for the whole run, as below.
        match self.tangential_force {
            TangentialForce::Incremental => carried,
            TangentialForce::Rescaled => {
                let closed = R::max(touch.velocity_normal, R::splat(0.0)) * touch.advance;
                let overlap = R::max(touch.overlap, R::splat(0.0));
                carried * (overlap / R::max(overlap + closed, R::splat(f64::MIN_POSITIVE))).sqrt()
            }
        }
    }

    /// What the dashpots have beside their constants, N s/m, at that normal stiffness.
    #[inline(always)]
    fn viscosity<R: Real>(&self, [mass_a, mass_b]: [R; 2], stiffness: R) -> R {
        let ratio = self.damping_ratio;
        // One answer for the whole run: who asks for no rebound does not pay for the root.
        if ratio == 0.0 {
            return R::splat(0.0);
        }
        let mass = mass_a * mass_b / (mass_a + mass_b);
        (mass * stiffness).sqrt() * R::splat(2.0 * (5.0f64 / 6.0).sqrt() * ratio)
    }
}

impl Described for HertzMindlin {
    fn keys(&mut self, form: &mut dyn Form, _: f64) {
        form.number(
            &mut self.shear_modulus,
            number("shear_modulus", "G of the grains' solid", STRESS, POSITIVE, "\"29 GPa\""),
        );
        let poisson = "Poisson's ratio of the grains' solid";
        form.number(&mut self.poisson_ratio, number("poisson_ratio", poisson, RATIO, Range::closed(0.0, 0.5), "0.15"));
        constants::friction(form, &mut self.friction);
        constants::normal_force(form, &mut self.normal_force);
        match constants::restitution(form, &["damping_normal", "damping_tangential", "damping_ratio"]) {
            Some(restitution) => self.damping_ratio = constants::damping_of(restitution, self.normal_force, 1.0),
            None => {
                let key = |name, about| number(name, about, DAMPING, NOT_NEGATIVE, "\"3.5 N s/m\"").or("0.0");
                form.number(&mut self.damping_normal, key("damping_normal", "gamma_n"));
                form.number(&mut self.damping_tangential, key("damping_tangential", "gamma_t"));
                let about = "zeta of dashpots 2 sqrt(5/6) zeta sqrt(m k_n), m the effective mass";
                form.number(
                    &mut self.damping_ratio,
                    number("damping_ratio", about, RATIO, NOT_NEGATIVE, "0.2").or("0.0"),
                );
            }
        }
        let about =
            "its elastic part while a contact opens: incremental (kept) or rescaled with the radius of the contact";
        let key = text("tangential_force", about, "\"rescaled\"").or("incremental");
        choose(form, &mut self.tangential_force, "form of the tangential force", key, &TangentialForce::NAMES);
    }

    fn friction(&mut self) -> &mut f64 {
        &mut self.friction
    }

    fn without_loss(&mut self) {
        (self.damping_normal, self.damping_tangential, self.damping_ratio) = (0.0, 0.0, 0.0);
    }

    fn stiffening(&self) -> Stiffening {
        Stiffening::WithOverlap
    }

    fn keys_of_stiffness(&self) -> [&'static str; 2] {
        ["shear_modulus", "shear_modulus"]
    }
}

impl From<HertzMindlin> for Force {
    fn from(law: HertzMindlin) -> Self {
        Self::HertzMindlin(law)
    }
}

impl<S: Space> ContactLaw<S> for HertzMindlin {
    /// The elastic part of the tangential force, N.
    type Memory<R: Real> = S::TangentOf<R>;

    #[inline(always)]
    fn force<R: Real>(&self, touch: &Touch<S, R>, elastic: &mut S::TangentOf<R>) -> Answer<S, R> {
        let zero = R::splat(0.0);
        let [stiffness_normal, stiffness_tangential] = self.springs_of(touch.radius_a, touch.radius_b, touch.overlap);
        let spring = stiffness_normal * touch.overlap * R::splat(2.0 / 3.0);
        let viscosity = self.viscosity([touch.mass_a, touch.mass_b], stiffness_normal);
        let damped = spring - touch.velocity_normal * (viscosity + R::splat(self.damping_normal));
        let normal = R::max(R::splat(self.normal_force.least()), damped);

        let slid = touch.velocity_tangential * touch.advance;
        let trial_elastic = self.carried(touch, elastic) - slid * stiffness_tangential;
        let dashpot = -(touch.velocity_tangential * (viscosity + R::splat(self.damping_tangential)));
        let trial = trial_elastic + dashpot;
        let limit = spring * R::splat(self.friction);
        let magnitude = trial.norm();
        let slides = magnitude.above(limit);
        // As for the linear law: without an elastic part yet there is no direction to slide in.
        let stretches = trial_elastic.dot(&trial_elastic).above(zero);
        let share = R::choose(stretches, limit / magnitude, zero);
        let tangential = trial * R::choose(slides, share, R::splat(1.0));
        *elastic = Words::choose(R::both(slides, stretches), &(tangential - dashpot), &trial_elastic);
        Answer { normal, tangential, moment: Words::zero() }
    }

    fn springs(&self, touch: &Touch<S, f64>, elastic: &S::TangentOf<f64>) -> Answer<S, f64> {
        let [stiffness, _] = self.springs_of(touch.radius_a, touch.radius_b, touch.overlap);
        Answer { normal: stiffness * touch.overlap * (2.0 / 3.0), tangential: *elastic, moment: Words::zero() }
    }

    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, touch: &Touch<S, R>) -> R {
        self.springs_of(touch.radius_a, touch.radius_b, touch.overlap)[1]
    }

    fn stiffness(&self, [radius_a, radius_b]: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
        let [normal, tangential] = self.springs_of(radius_a, radius_b, overlap);
        let viscosity = self.viscosity(masses, normal);
        let [damping_normal, damping_tangential] =
            [self.damping_normal, self.damping_tangential].map(|damping| damping + viscosity);
        Springs { normal, tangential, rolling: 0.0, damping_normal, damping_tangential }
    }

    fn friction_limit(&self, touch: &Touch<S, f64>, _: f64) -> f64 {
        let [stiffness, _] = self.springs_of(touch.radius_a, touch.radius_b, touch.overlap);
        stiffness * touch.overlap * (2.0 / 3.0) * self.friction
    }

    /// Hertz's energy, and that of the tangential spring at the stiffness of now.
    fn elastic_energy(&self, touch: &Touch<S, f64>, elastic: &S::TangentOf<f64>) -> f64 {
        let [normal, tangential] = self.springs_of(touch.radius_a, touch.radius_b, touch.overlap);
        let stored = if tangential > 0.0 { 0.5 * elastic.dot(elastic) / tangential } else { 0.0 };
        4.0 / 15.0 * normal * touch.overlap * touch.overlap + stored
    }
}
