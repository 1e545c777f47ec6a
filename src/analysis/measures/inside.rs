//! Shear stress over the shear strain inside the zone (Chen et al. 2021, figure 15 right): it takes away that the continuum
//! localises earlier than grains do.
//!
//! The zone's shear strain is the difference of horizontal displacement between its upper and its lower edge over the height
//! between them; of an edge, the mean over the area of all bodies that began within a cell's edge of it.
//!
//! The band of the grains alone may form elsewhere than that of the continuum, whose place is set by its weak points: beside the
//! same material, that part of them is looked at which has the zone's height and shears most by the end.

use serde::Serialize;

use super::Found;
use super::among::{Among, Member, Who};
use crate::analysis::curve::{Averaged, Difference, linear, range};
use crate::analysis::run::Run;
use crate::analysis::snapshot::{Kind, Snapshot};
use crate::analysis::zone::Zone;
use crate::base::error::Error;

/// Edge of a layer where no cell is known, mean diameters.
const LAYER_DIAMETERS: f64 = 3.0;

/// A hybrid over the strain in its zone, and the grains alone of its packing.
#[derive(Clone, Debug, Serialize)]
pub struct Inside {
    /// The hybrid.
    #[serde(flatten)]
    pub who: Who,
    /// Label of the run of grains alone.
    pub against: String,
    /// Of the zone's edges.
    pub heights_m: [f64; 2],
    /// From the same material where grains are alone.
    pub difference: Option<Difference>,
    /// Where the grains alone shear most.
    pub heights_sheared_most_m: [f64; 2],
    /// From the grains alone, over the strain between those heights.
    pub difference_sheared_most: Option<Difference>,
    /// The place of the grains alone among the runs.
    #[serde(skip)]
    pub partner: usize,
    /// Of the hybrid, of the same material, and of where the grains alone shear most.
    #[serde(skip)]
    pub curves: [Averaged; 3],
}

/// Mean horizontal displacement of what began within `reach` of a height, m.
fn displacement(snapshot: &Snapshot, height: f64, reach: f64) -> Option<f64> {
    let layer = snapshot.bodies.iter().filter(|body| body.kind != Kind::Glued);
    let (sum, area) = layer
        .filter(|body| (body.origin()[1] - height).abs() <= reach)
        .fold((0.0, 0.0), |(sum, area), body| (sum + body.area() * body.displacement[0], area + body.area()));
    (area > 0.0).then(|| sum / area)
}

/// A run's moving average of shear stress over the shear strain between two heights of the unsheared specimen.
fn over_strain_inside(run: &Run, averaged: &Averaged, [lower, upper]: [f64; 2], reach: f64) -> Result<Averaged, Error> {
    let (mut outside, mut inside) = (Vec::new(), Vec::new());
    for frame in 0..run.frame_times.len() {
        let snapshot = run.snapshot(frame)?;
        let edges = displacement(&snapshot, lower, reach).zip(displacement(&snapshot, upper, reach));
        if let Some((below, above)) = edges {
            outside.push(run.at_frame(frame));
            inside.push((above - below) / (upper - lower));
        }
    }
    let mut curve = Averaged::default();
    for (row, (&strain, &stress)) in averaged.strain.iter().zip(&averaged.stress).enumerate() {
        let Some(shear) = linear(&outside, &inside, strain) else { continue };
        // Strain that goes back for a while, as it may where grains take over, counts once.
        if curve.strain.last().is_none_or(|&last| shear > last) {
            if curve.cut.is_none() && averaged.cut.is_some_and(|first| row >= first) {
                curve.cut = Some(curve.strain.len());
            }
            curve.strain.push(shear);
            curve.stress.push(stress);
        }
    }
    Ok(curve)
}

/// The part of a specimen, as high as another one, that has sheared most by the last frame: heights of its edges, m.
fn sheared_most(run: &Run, heights: [f64; 2], reach: f64) -> Result<[f64; 2], Error> {
    let snapshot = run.snapshot(run.frame_times.len() - 1)?;
    let origins = snapshot.bodies.iter().filter(|body| body.kind != Kind::Glued).map(|body| body.origin()[1]);
    let Some([bottom, top]) = range(origins) else { return Ok(heights) };
    let height = heights[1] - heights[0];
    let steps = ((top - bottom - height) / (0.5 * reach)).floor().max(0.0) as usize;
    let mut most = (f64::NEG_INFINITY, heights);
    for step in 0..=steps {
        let lower = bottom + 0.5 * reach * step as f64;
        let edges = [lower, lower + height];
        let [below, above] = edges.map(|edge| displacement(&snapshot, edge, reach));
        if let Some(sheared) = above.zip(below).map(|(above, below)| above - below).filter(|way| *way > most.0) {
            most = (sheared, edges);
        }
    }
    Ok(most.1)
}

fn compare(hybrid: &Member, partner: &Member, averages: &[Averaged], heights: [f64; 2]) -> Result<Inside, Error> {
    let reach = hybrid.run.cell_edge().unwrap_or(LAYER_DIAMETERS * hybrid.run.unit_length());
    let over = |of: &Member, heights| over_strain_inside(of.run, &averages[of.index()], heights, reach);
    let curve = over(hybrid, heights)?;
    let most = sheared_most(partner.run, heights, reach)?;
    let others = [over(partner, heights)?, over(partner, most)?];
    let from = curve.cut.and_then(|cut| curve.strain.get(cut)).copied();
    let [difference, difference_sheared_most] =
        [0, 1].map(|which| Difference::of(&curve, &others[which], [from?, f64::INFINITY]));
    let [same, sheared] = others;
    Ok(Inside {
        who: hybrid.who.clone(),
        against: partner.who.run.clone(),
        heights_m: heights,
        difference,
        heights_sheared_most_m: most,
        difference_sheared_most,
        partner: partner.index(),
        curves: [curve, same, sheared],
    })
}

/// `averages` are those of all members, in their order; an error where a frame cannot be read.
pub fn measured(among: &Among, averages: &[Averaged]) -> Result<Found<Vec<Inside>>, Error> {
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for hybrid in among.to_be_enriched() {
        let heights = Zone::of(hybrid.run)?.map(|zone| zone.heights()).filter(|[lower, upper]| upper > lower);
        match among.partner(hybrid).zip(heights) {
            Some((partner, heights)) => all.push(compare(hybrid, partner, averages, heights)?),
            None => left_out.push(format!(
                "Strain inside the zone of {}: it needs its enrichment and the grains alone of its packing.",
                hybrid.who.run
            )),
        }
    }
    Ok(Found::of(all, left_out))
}
