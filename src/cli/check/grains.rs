//! Grains: how many, of which sizes, where they come from.

use super::Slots;
use super::page::{Page, figures, whole};
use crate::job::assembly::{Packed, Sizes, Source};
use crate::job::figures as of;
use crate::job::mpm::forecast::{fraction_of_packing, grains_if_discrete};
use crate::job::mpm::{Mpm, figures as of_points};

pub fn section(page: &mut Page, slots: &Slots) {
    let Some(grains) = slots.grains.as_deref().filter(|_| slots.job.moves_grains()) else { return };
    page.section("Grains");
    match &slots.continuum {
        Some(on) => in_material(page, slots, on),
        None => {
            let count = of::grains(grains).map_or("as many as the file has".to_string(), |count| whole(count as f64));
            page.row("grains", &count, "");
        }
    }
    let fraction = |assembly| of::fraction_in_cell(assembly).or_else(|| of::fraction_of_file(assembly));
    let alone = Some(grains).filter(|_| slots.continuum.is_none());
    if let Some(fraction) = alone.and_then(fraction) {
        page.row("solid volume fraction", &figures(fraction), "of these grains in the cell as the job gives it");
    }
    let mean = grains.matter.diameter_mean;
    page.row("mean diameter", &format!("{} mm", figures(1e3 * mean)), "D50");
    page.row(
        "mass of the mean grain",
        &format!("{} kg", figures(of::grain(grains, mean).mass)),
        if grains.cell.dimension == 2 { "rho pi r^2 depth" } else { "rho 4/3 pi r^3" },
    );
    match &grains.source {
        Source::File(read) => {
            page.row("read from", &read.grains.display().to_string(), "");
            if let Some(contacts) = &read.contacts {
                page.row("contacts read from", &contacts.display().to_string(), "");
            }
        }
        Source::Packed(packed) => made(page, slots, packed),
    }
}

/// Grains that all of a continuum's material would be made of.
fn in_material(page: &mut Page, slots: &Slots, on: &Mpm) {
    let all = grains_if_discrete(on);
    let fraction = figures(fraction_of_packing(on));
    let fraction =
        if slots.job.is_told_by_packing() { format!("about {fraction}; the packing will tell") } else { fraction };
    let note = format!("if all of the material were discrete, at a solid volume fraction of {fraction}");
    page.row("grains", &whole(all), &note);
    let per_cell =
        all * (on.scheme.points_per_cell as f64).powi(on.grid.dimension as i32) / of_points::points(on) as f64;
    page.row("grains in a cell", &figures(per_cell), "the more, the more a hybrid saves");
}

fn made(page: &mut Page, slots: &Slots, packed: &Packed) {
    let axes = slots.job.dimension();
    page.keys(axes, |form| packed.sizes.clone().keys(form));
    let [min, max] = [packed.sizes.min(), packed.sizes.max()].map(|diameter| figures(1e3 * diameter));
    let cut = if matches!(packed.sizes, Sizes::Normal { .. }) { "cut at three deviations" } else { "" };
    page.row("diameters", &format!("{min} to {max} mm"), cut);
    page.section("Packing");
    if slots.continuum.is_some() && slots.job.plates().is_none() {
        page.row("grains of a piece", &whole(packed.count as f64), "laid side by side");
    }
    page.keys(axes, |form| slots.job.keys_of_packing(form));
}
