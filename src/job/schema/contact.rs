//! `[contact]`: the laws and the keys of each.

use super::{DAMPING, Dimension, Key, NOT_NEGATIVE, POSITIVE, RATIO, Range, STIFFNESS, STRESS, number, text};

/// Of all laws together; [`OF_LAW`] says which is whose.
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    text("law", "the contact law: linear, linear_cohesive, elastic_rolling or hertz_mindlin", "\"linear\""),
    number("stiffness_normal", "k_n", STIFFNESS, POSITIVE, "\"1772 kN/m\""),
    number("stiffness_tangential", "k_t", STIFFNESS, NOT_NEGATIVE, "\"886 kN/m\""),
    number("damping_normal", "gamma_n", DAMPING, NOT_NEGATIVE, "\"3.5 N s/m\""),
    number("damping_tangential", "gamma_t", DAMPING, NOT_NEGATIVE, "\"3.5 N s/m\""),
    number("restitution", "the rebound of two mean grains, in place of dampings", RATIO, Range::open(0.0, 1.0), "0.1"),
    number("damping_ratio", "zeta of dashpots 2 sqrt(5/6) zeta sqrt(m k_n), m the effective mass", RATIO, NOT_NEGATIVE, "0.2"),
    text("normal_force", "what spring and dashpot may come to: tensile (the dashpot may pull while a contact opens) or repulsive", "\"repulsive\""),
    text("tangential_force", "its elastic part while a contact opens: incremental (kept) or rescaled with the radius of the contact", "\"rescaled\""),
    number("friction", "mu, the Coulomb coefficient", RATIO, Range::closed(0.0, 5.0), "0.5"),
    number("friction_angle", "the angle whose tangent is mu, in place of friction", Dimension::ANGLE, Range::closed(0.0, 1.3734), "\"28.6 deg\""),
    number("cohesion_normal", "e_n, the pull that a contact bears", Dimension::FORCE, NOT_NEGATIVE, "\"0.2 N\""),
    number("cohesion_tangential", "e_t, shear that a contact bears beyond friction", Dimension::FORCE, NOT_NEGATIVE, "\"0.2 N\""),
    number("young_modulus", "E of k_n = E r*", STRESS, POSITIVE, "\"600 MPa\""),
    number("stiffness_ratio", "k_t/k_n", RATIO, Range::closed(0.0, 10.0), "0.8"),
    number("rolling_stiffness", "beta of k_r = beta k_t r_i r_j", RATIO, Range::closed(0.0, 100.0), "1.0"),
    number("rolling_limit", "eta of |M| <= eta min(r_i, r_j) F_n", RATIO, Range::closed(0.0, 10.0), "0.05"),
    text("sliding", "what slides: surface or scaled", "\"surface\""),
    number("shear_modulus", "G of the grains' solid", STRESS, POSITIVE, "\"29 GPa\""),
    number("poisson_ratio", "Poisson's ratio of the grains' solid", RATIO, Range::closed(0.0, 0.5), "0.15"),
];

/// The laws by name, and the keys that belong to each; friction belongs to all.
pub const OF_LAW: [(&str, &[&str]); 4] = [
    (
        "linear",
        &[
            "stiffness_normal",
            "stiffness_tangential",
            "damping_normal",
            "damping_tangential",
            "restitution",
            "normal_force",
        ],
    ),
    (
        "linear_cohesive",
        &[
            "stiffness_normal",
            "stiffness_tangential",
            "damping_normal",
            "damping_tangential",
            "restitution",
            "normal_force",
            "cohesion_normal",
            "cohesion_tangential",
        ],
    ),
    ("elastic_rolling", &["young_modulus", "stiffness_ratio", "rolling_stiffness", "rolling_limit", "sliding"]),
    (
        "hertz_mindlin",
        &[
            "shear_modulus",
            "poisson_ratio",
            "damping_normal",
            "damping_tangential",
            "damping_ratio",
            "restitution",
            "normal_force",
            "tangential_force",
        ],
    ),
];
