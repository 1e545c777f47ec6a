//! The grains of a job on a grid.

use super::assembly::contacts;
use super::page::{Page, figures, whole};
use crate::job::Method;
use crate::job::assembly::{Packed, Preparation, Source};
use crate::job::mpm::forecast::grains_if_discrete;
use crate::job::mpm::{Granular, InitialStress, Mpm, Origin, figures as of};

/// How far stresses of points and packing may be apart.
const STRESS_OFF: f64 = 0.05;

/// The section on grains.
pub fn grains(page: &mut Page, job: &Mpm) {
    let Some(granular) = &job.grains else { return };
    let piece = &granular.piece;
    page.section("Grains");
    page.row(
        "method",
        granular.method.name(),
        match granular.method {
            Method::Hybrid => "points first, grains where a band persists",
            Method::Dem => "grains alone",
            Method::Mpm => "points alone, of the packing's density",
        },
    );
    page.row("grains", &whole(grains_if_discrete(job, granular)), "if all of the material were discrete, about");
    page.row(
        "D50",
        &format!("{} mm", figures(1e3 * piece.matter.diameter_mean)),
        &format!(
            "{} grains in a piece of packing",
            match &piece.source {
                Source::Packed(packed) => whole(packed.count as f64),
                Source::File(_) => unreachable!("a checked job has its piece made"),
            }
        ),
    );
    let per_cell = grains_if_discrete(job, granular) * (job.scheme.points_per_cell as f64).powi(2)
        / of::points_of_regions(job).iter().sum::<u64>() as f64;
    page.row("grains in a cell", &figures(per_cell), "the more, the more a hybrid saves");
    if granular.method == Method::Hybrid {
        let zone = &granular.enrichment;
        page.row(
            "zone",
            &format!("{} mm", figures(1e3 * zone.distance)),
            "on either side of flagged nodes, grains alone but for a rim of one cell",
        );
        page.row("training", &figures(zone.training), "share of the continuum's motion");
        page.row(
            "reference",
            granular.reference.name(),
            match granular.reference {
                Origin::Specimen => "grains of a zone are those of a specimen that comes to rest before the run",
                Origin::Piece => "grains of a zone are pieces of packing side by side",
            },
        );
        if let Some(known) = &granular.known {
            let parts = format!("{} parts", whole(known.parts.len() as f64));
            page.row("known bands", &parts, &format!("grains take their place after {} s", figures(known.at)));
        }
    }
    contacts(page, piece);
}

/// Stresses of the start that are not alike.
pub fn warnings(job: &Mpm) -> Vec<String> {
    let Some(granular) = &job.grains else { return Vec::new() };
    match (job.stress, stress_of_piece(granular)) {
        (InitialStress::Isotropic { pressure }, Some(stress)) if (pressure / stress - 1.0).abs() > STRESS_OFF => {
            vec![format!(
                "points begin under {} kPa (stress.pressure) and the packing under {} kPa ([packing]): grains that replace points would bear something else. Write the same.",
                figures(1e-3 * pressure),
                figures(1e-3 * stress)
            )]
        }
        _ => Vec::new(),
    }
}

/// Mean stress that the piece of packing has, Pa.
fn stress_of_piece(granular: &Granular) -> Option<f64> {
    match &granular.piece.source {
        Source::Packed(Packed { preparation: Preparation::Compress { stress, unloaded, .. }, .. }) => {
            Some(unloaded.unwrap_or(*stress))
        }
        _ => None,
    }
}
