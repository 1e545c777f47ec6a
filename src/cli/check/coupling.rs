//! Where grains take the place of a continuum.

use super::Slots;
use super::page::{Page, figures, whole};
use crate::analysis::strength::{GRAINS, PACKINGS, STIFFNESS, STRENGTH, StrengthComparison};
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
    page.row(
        "exchange with nodes",
        &format!("every {}", whole(granular.coupling.interval as f64)),
        "steps of grains, coupling.interval",
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
    strength(page, slots);
}

/// The continuum beside its grains.
fn strength(page: &mut Page, slots: &Slots) {
    match &slots.strength {
        None => (),
        Some(Err(why)) => page.row("strength of its grains", "not tested", why),
        Some(Ok(StrengthComparison { continuum, grains, error })) => {
            let between = STRENGTH.map(|strain| figures(100.0 * strain));
            page.row(
                "tau/sigma_n, continuum, grains",
                &format!("{}, {}", figures(continuum.strength), figures(grains.strength)),
                &format!(
                    "from {} to {} % of shear; grains +- {}, standard error of {PACKINGS} packings of {GRAINS}",
                    between[0],
                    between[1],
                    figures(error.strength)
                ),
            );
            let megapascals = |pressure: f64| figures(1e-6 * pressure);
            page.row(
                "tau/gamma, continuum, grains",
                &format!("{}, {} MPa", megapascals(continuum.stiffness), megapascals(grains.stiffness)),
                &format!("at {} % of shear; grains +- {}", figures(100.0 * STIFFNESS), megapascals(error.stiffness)),
            );
        }
    }
}
