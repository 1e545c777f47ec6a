//! Shear stress of the trained packing against the same region of grains alone at the same strain (Chen et al. 2021, figure
//! 13).

use serde::Serialize;

use super::Found;
use super::among::{Among, Member, Who};
use crate::analysis::curve::between;
use crate::analysis::snapshot::{Body, Snapshot};
use crate::analysis::zone::Zone;
use crate::base::error::Error;

/// A frame this near to the wanted strain is taken as it is.
const STRAIN_SAME: f64 = 1e-5;
/// With fewer grains in common two runs are not of the same packing.
const SHARED_LEAST: f64 = 0.99;

/// A hybrid's packing and the same region of the grains alone.
#[derive(Clone, Debug, Serialize)]
pub struct Trained {
    /// The hybrid.
    #[serde(flatten)]
    pub who: Who,
    /// Label of the run of grains alone.
    pub against: String,
    /// The place of the grains alone among the runs.
    #[serde(skip)]
    pub partner: usize,
    /// Where the hybrid's inner grains began.
    #[serde(skip)]
    pub zone: Zone,
    /// Horizontal strain of the enrichment.
    pub strain: f64,
    /// Mean of the hybrid's inner grains in the first frame.
    pub shear_stress_grains_pa: f64,
    /// The same at the end of training and of the points before, from the summary.
    pub shear_stress_end_of_training_pa: Option<f64>,
    /// Of the points before they were replaced, Pa; none where the summary does not tell it.
    pub shear_stress_points_pa: Option<f64>,
    /// Of the region in the grains alone at the same strain.
    pub shear_stress_region_pa: f64,
    /// The hybrid's mean over that of the region, less 1.
    pub off: f64,
    /// Share of the hybrid's grains that are the grains alone, too: all in the same packing.
    pub grains_in_common: f64,
    /// Strains of the two frames that this lies between, where none is at that strain.
    pub interpolated_between_strains: Option<[f64; 2]>,
}

/// Mean of the shear stress over the area of bodies, Pa.
fn mean_stress<'b>(bodies: impl Iterator<Item = &'b Body>) -> Option<f64> {
    let (sum, area) =
        bodies.fold((0.0, 0.0), |(sum, area), body| (sum + body.area() * body.shear_stress, area + body.area()));
    (area > 0.0).then(|| sum / area)
}

fn region_stress(snapshot: &Snapshot, zone: &Zone) -> Option<f64> {
    mean_stress(snapshot.bodies.iter().filter(|body| body.is_inner() && zone.holds(body)))
}

/// Compares one hybrid, or tells why not.
fn compare(among: &Among, hybrid: &Member) -> Result<Result<Trained, String>, Error> {
    let fail = |why: &str| Ok(Err(format!("Stress of the trained packing of {}: {why}.", hybrid.who.run)));
    let (Some((_, strain)), Some(frame)) = (hybrid.run.enrichment(), hybrid.run.enriched) else {
        return fail("it was not enriched, or has no frame before or after");
    };
    let Some(partner) = among.partner(hybrid) else {
        return fail("there is no run of grains alone with its packing");
    };
    let alone = partner.run;
    let Some(zone) = Zone::of(hybrid.run)? else { return fail("the first frame has no grains outside of the rim") };
    let grains = mean_stress(hybrid.run.snapshot(frame)?.bodies.iter().filter(|body| body.is_inner()));
    let strains: Vec<f64> = (0..alone.frame_times.len()).map(|frame| alone.at_frame(frame)).collect();
    let there = strains.iter().copied().find(|other| (other - strain).abs() <= STRAIN_SAME).unwrap_or(strain);
    let Some((after, share)) = between(&strains, there) else {
        return fail("the run of grains alone has no frame as late");
    };
    let before = after.checked_sub(1).filter(|_| share < 1.0);
    if let Some(before) = before.filter(|&before| strains[after] - strains[before] > strain) {
        // Between them the stress rises and turns; a straight line through it says nothing.
        let [from, to, at] =
            [strains[before], strains[after], strain].map(|strain| format!("{:.3}\u{2009}%", 100.0 * strain));
        return fail(&format!(
            "the run of grains alone has frames at strains of {from} and {to} only, too far from {at}; a short run of it \
             with a smaller output.frame_interval will do"
        ));
    }
    let later = region_stress(&alone.snapshot(after)?, &zone);
    let region = match before {
        None => later,
        Some(before) => {
            let earlier = region_stress(&alone.snapshot(before)?, &zone);
            earlier.zip(later).map(|(a, b)| a + share * (b - a))
        }
    };
    let (Some(grains), Some(region)) = (grains, region.filter(|stress| *stress != 0.0)) else {
        return fail("there are no stresses of grains to compare");
    };
    Ok(Ok(Trained {
        who: hybrid.who.clone(),
        against: partner.who.run.clone(),
        partner: partner.index(),
        strain,
        shear_stress_grains_pa: grains,
        shear_stress_end_of_training_pa: hybrid.run.told("training_shear_stress_grains"),
        shear_stress_points_pa: hybrid.run.told("training_shear_stress_points"),
        shear_stress_region_pa: region,
        off: grains / region - 1.0,
        grains_in_common: zone.shared_with(&alone.snapshot(0)?.bodies),
        interpolated_between_strains: before.map(|before| [strains[before], strains[after]]),
        zone,
    }))
}

/// Of hybrids that were to be enriched; those that cannot be compared are named among what is left out, and why.
pub fn measured(among: &Among) -> Result<Found<Vec<Trained>>, Error> {
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for hybrid in among.to_be_enriched() {
        match compare(among, hybrid)? {
            Ok(trained) => {
                if trained.grains_in_common < SHARED_LEAST {
                    left_out.push(format!(
                        "{} and {} have the same seed, but only {:.3}\u{2009}% of the inserted grains are the other's: \
                         the packings differ, as they do where `loading.plate_damping` does.",
                        trained.who.run,
                        trained.against,
                        100.0 * trained.grains_in_common
                    ));
                }
                all.push(trained);
            }
            Err(why) => left_out.push(why),
        }
    }
    Ok(Found::of(all, left_out))
}
