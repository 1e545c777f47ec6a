//! How fast and how hard grains are loaded, and the time step that this allows.

use super::Slots;
use super::page::{Page, figures};
use crate::job::stable::governing;

pub fn loading(page: &mut Page, slots: &Slots) {
    let Some(pressure) = slots.job.pressure() else { return };
    page.section("Rate and stiffness");
    page.row("stress on the grains", &format!("{} kPa", figures(1e-3 * pressure)), slots.job.key_of_pressure());
    for (number, rate) in slots.inertial_numbers() {
        page.row("inertial number", &figures(number), &format!("rate d sqrt(rho/p), {rate}"));
    }
    if let Some(number) = slots.stiffness_number() {
        let thickness = if slots.job.dimension() == 2 { "depth" } else { "d" };
        let note = format!("k_n/(p {thickness}): the mean overlap is one diameter over this");
        page.row("stiffness number", &figures(number), &note);
    }
}

pub fn steps(page: &mut Page, slots: &Slots) {
    page.section("Time step");
    page.row("step of the job", &format!("{} s", figures(slots.job.step())), "");
    if !slots.bounds_of_grains.is_empty() {
        page.bounds("stable step of grains", &slots.bounds_of_grains);
    }
    if slots.bounds_of_continuum.is_empty() {
        return;
    }
    if let Some(job) = slots.continuum.as_deref().filter(|job| job.grains.is_some() && job.rves().is_none()) {
        let most = (governing(&slots.bounds_of_continuum).step / job.step).floor().max(1.0);
        let note = format!("time.grain_steps = {}; {most} at most are stable", job.grain_steps);
        page.row("step of the continuum", &format!("{} s", figures(job.step_of_continuum())), &note);
    }
    page.bounds("stable step of the continuum", &slots.bounds_of_continuum);
}
