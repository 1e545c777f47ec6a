//! Contacts of grains.

use super::Slots;
use super::page::{Page, figures, megapascals};
use crate::dem::motion::DampingForm;
use crate::job::assembly::Assembly;
use crate::job::figures as of;
use crate::job::stable::HERTZ_OVERLAP;
use crate::law::contact::{Contact, LinearSpringDashpot, NormalForce, Sliding, TangentialForce};

pub fn section(page: &mut Page, slots: &Slots) {
    let Some(grains) = &slots.grains else { return };
    contacts(page, grains);
    if let Some(moduli) = slots.moduli_of_contacts() {
        page.row("K and G of a packing", &megapascals(moduli.bulk, moduli.shear), "affine estimate, an upper bound");
    }
}

/// The law of contacts.
pub(super) fn contacts(page: &mut Page, assembly: &Assembly) {
    page.section("Contact");
    match &assembly.contact {
        Contact::Linear(law) => {
            page.row("law", "linear", "springs and dashpots, Coulomb limit");
            linear(page, law);
        }
        Contact::LinearCohesive(law) => {
            page.row("law", "linear_cohesive", "the same, with cohesion");
            linear(page, &law.linear);
            page.row("e_n and e_t", &pair(law.cohesion_normal, law.cohesion_tangential, "N"), "normal, tangential");
        }
        Contact::ElasticRolling(law) => {
            page.row("law", "elastic_rolling", "springs that grow with size, no dashpots");
            page.row("E", &format!("{} MPa", figures(1e-6 * law.young_modulus)), "k_n = E r*, r* the harmonic mean");
            let sliding = match law.sliding {
                Sliding::Surface => "the surfaces slide as they are",
                Sliding::Scaled => "sliding scaled by (r_i + r_j)/(r_i + r_j - d)",
            };
            page.row("k_t/k_n", &figures(law.stiffness_ratio), sliding);
            page.row(
                "rolling",
                &format!("beta {}, eta {}", figures(law.rolling_stiffness), figures(law.rolling_limit)),
                if law.rolling_stiffness > 0.0 { "k_r = beta k_t r_i r_j" } else { "grains roll freely" },
            );
        }
        Contact::HertzMindlin(law) => {
            page.row("law", "hertz_mindlin", "springs that grow with overlap");
            page.row("G of the solid", &format!("{} MPa", figures(1e-6 * law.shear_modulus)), "");
            page.row("Poisson's ratio of the solid", &figures(law.poisson_ratio), "");
            page.row("gamma_n and gamma_t", &pair(law.damping_normal, law.damping_tangential, "N s/m"), "");
            if law.damping_ratio > 0.0 {
                page.row("damping ratio", &figures(law.damping_ratio), "zeta of dashpots 2 sqrt(5/6) zeta sqrt(m k_n)");
            }
            let note = match law.tangential_force {
                TangentialForce::Incremental => {
                    "kept while contacts open, which may gain energy where they hardly slide"
                }
                TangentialForce::Rescaled => "falls with the radius of contacts that open",
            };
            page.row("tangential force", law.tangential_force.name(), note);
        }
    }
    if !matches!(assembly.contact, Contact::ElasticRolling(_)) {
        let normal_force = assembly.contact.normal_force();
        let note = match normal_force == NormalForce::TENSILE {
            true => "dashpots may pull while contacts open",
            false => "dashpots only repel",
        };
        page.row("normal force", normal_force.name(), note);
    }
    let springs = of::springs_mean(assembly);
    let note = match &assembly.contact {
        Contact::HertzMindlin(_) => format!("of two mean grains at an overlap of {} %", 100.0 * HERTZ_OVERLAP),
        _ => "of two mean grains".to_string(),
    };
    page.row("k_n and k_t", &pair(springs.normal, springs.tangential, "N/m"), &note);
    page.row("friction", &figures(assembly.contact.friction()), "mu");
    let damping = &assembly.damping;
    if damping.local > 0.0 {
        let form = match damping.form {
            DampingForm::Vector => "against the velocity vector",
            DampingForm::Component => "component by component",
        };
        page.row("local damping", &figures(damping.local), form);
    }
    if damping.mass > 0.0 {
        page.row("damping by mass", &format!("{} 1/s", figures(damping.mass)), "-c m v");
    }
}

fn linear(page: &mut Page, law: &LinearSpringDashpot) {
    page.row("gamma_n and gamma_t", &pair(law.damping_normal, law.damping_tangential, "N s/m"), "absolute");
}

fn pair(first: f64, second: f64, unit: &str) -> String {
    format!("{} and {} {unit}", figures(first), figures(second))
}
