//! Contacts of grains.

use super::Slots;
use super::page::{Page, figures, megapascals};
use crate::dem::motion::DampingForm;
use crate::job::assembly::Assembly;
use crate::job::figures as of;
use crate::job::stable::HERTZ_OVERLAP;
use crate::law::contact::Stiffening;

pub fn section(page: &mut Page, slots: &Slots) {
    let Some(grains) = slots.grains.as_deref().filter(|_| slots.job.moves_grains()) else { return };
    contacts(page, grains);
    if let Some(moduli) = slots.moduli_of_contacts() {
        page.row("K and G of a packing", &megapascals(moduli.bulk, moduli.shear), "affine estimate, an upper bound");
    }
}

/// The law of contacts.
fn contacts(page: &mut Page, assembly: &Assembly) {
    page.section("Contact");
    page.keys(assembly.cell.dimension, |form| assembly.contact.clone().keys(form, 0.0));
    if assembly.contact.stiffening() != Stiffening::Constant {
        let springs = of::springs_mean(assembly);
        let note = match assembly.contact.stiffening() {
            Stiffening::WithOverlap => format!("of two mean grains at an overlap of {} %", 100.0 * HERTZ_OVERLAP),
            _ => "of two mean grains".to_string(),
        };
        page.row("k_n and k_t", &pair(springs.normal, springs.tangential, "N/m"), &note);
    }
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

fn pair(first: f64, second: f64, unit: &str) -> String {
    format!("{} and {} {unit}", figures(first), figures(second))
}
