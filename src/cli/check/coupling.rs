//! Where grains take the place of a continuum.

use super::Slots;
use super::page::{Page, figures, whole};
use crate::job::mpm::{Origin, figures as of};

pub fn section(page: &mut Page, slots: &Slots) {
    let Some(granular) = slots.coupled() else { return };
    page.section("Coupling");
    let zone = &granular.enrichment;
    page.row(
        "zone",
        &format!("{} mm", figures(1e3 * zone.distance)),
        "on either side of flagged nodes, grains alone but for an overlap of one cell",
    );
    if let (Some(on), true) = (&slots.continuum, slots.job.plates().is_some()) {
        let height = figures(1e3 * of::zone_height(on, granular));
        page.row("height of the zone", &format!("{height} mm"), "around a flat band one cell thick");
    }
    page.row(
        "penalty springs",
        &figures(granular.coupling.stiffness),
        &format!("times a contact's stiffness, {} of critical damping", figures(granular.coupling.damping)),
    );
    page.row("training", &figures(zone.training), "share of the continuum's motion");
    let whence = match granular.reference {
        Origin::Specimen => "grains of a zone are those of a specimen that is equilibrated before the run",
        Origin::Piece => "grains of a zone are pieces of packing side by side",
    };
    page.row("reference", granular.reference.name(), whence);
    if let Some(known) = &granular.known {
        let parts = format!("{} parts", whole(known.parts.len() as f64));
        page.row("known bands", &parts, &format!("grains take their place after {} s", figures(known.at)));
    }
}
