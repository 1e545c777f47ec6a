//! Shear stress over the shear strain inside the zone (Chen et al. 2021, figure 15 right): it takes away that the continuum
//! localises earlier than grains do.
//!
//! The zone's shear strain is the difference of horizontal displacement between its upper and its lower edge over the height
//! between them; of an edge, the mean over the area of all bodies that began within a cell's edge of it.
//!
//! The band of the grains alone may form elsewhere than that of the continuum, whose place is set by its weak points: beside the
//! same material, that part of them is looked at which has the zone's height and shears most by the end.

use serde_json::{Value, json};

use super::among::{Among, Member};
use super::curves::{Averaged, Averages};
use super::difference::Difference;
use super::zone::Zone;
use super::{Drawn, Part, Sheet, by_group, range, share};
use crate::base::error::Error;
use crate::plot::report::WIDTH;
use crate::plot::report::chart::{Axis, Chart, Curve, Entry, percent, side_by_side};
use crate::plot::report::figures::{HEIGHT, SHEAR_LABEL, start};
use crate::plot::report::load::{Kind, Snapshot, linear};
use crate::plot::report::svg::Stroke;
use crate::plot::report::words::THIN;

/// The two parts of the grains alone, in words.
const OTHERS: [&str; 2] = ["same material", "where they shear most"];
/// Edge of a layer where no cell is known, mean diameters.
const LAYER_DIAMETERS: f64 = 3.0;

/// A hybrid over the strain in its zone, and the grains alone of its packing.
struct Compared<'a> {
    hybrid: &'a Member<'a>,
    partner: &'a Member<'a>,
    curve: Averaged,
    /// Heights of the zone's edges, m.
    heights: [f64; 2],
    /// The same material, and where the grains alone shear most.
    others: [Other; 2],
}

/// A part of the grains alone, and how far the hybrid is from it.
struct Other {
    /// m.
    heights: [f64; 2],
    curve: Averaged,
    difference: Option<Difference>,
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
fn over_strain_inside(
    member: &Member,
    averages: &Averages,
    [lower, upper]: [f64; 2],
    reach: f64,
) -> Result<Averaged, Error> {
    let (mut outside, mut inside) = (Vec::new(), Vec::new());
    for frame in 0..member.run.frame_times.len() {
        let snapshot = member.run.snapshot(frame)?;
        let edges = displacement(&snapshot, lower, reach).zip(displacement(&snapshot, upper, reach));
        if let Some((below, above)) = edges {
            outside.push(member.run.strain_of(frame));
            inside.push((above - below) / (upper - lower));
        }
    }
    let averaged = &averages.of[member.index];
    let mut curve = Averaged { strain: Vec::new(), stress: Vec::new(), cut: None };
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
fn sheared_most(member: &Member, heights: [f64; 2], reach: f64) -> Result<[f64; 2], Error> {
    let snapshot = member.run.snapshot(member.run.frame_times.len() - 1)?;
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

fn compare<'a>(
    hybrid: &'a Member<'a>,
    partner: &'a Member<'a>,
    averages: &Averages,
    zone: &Zone,
) -> Result<Compared<'a>, Error> {
    let heights = zone.heights();
    let reach = hybrid.cell().unwrap_or(LAYER_DIAMETERS * hybrid.run.diameter);
    let curve = over_strain_inside(hybrid, averages, heights, reach)?;
    let from = curve.cut.and_then(|cut| curve.strain.get(cut)).copied();
    let other = |heights: [f64; 2]| -> Result<Other, Error> {
        let other = over_strain_inside(partner, averages, heights, reach)?;
        let difference = from.and_then(|from| Difference::of(&curve, &other, [from, f64::INFINITY]));
        Ok(Other { heights, curve: other, difference })
    };
    let others = [other(heights)?, other(sheared_most(partner, heights, reach)?)?];
    Ok(Compared { hybrid, partner, curve, heights, others })
}

pub fn part(among: &Among, averages: &Averages) -> Result<Part, Error> {
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for hybrid in among.members.iter().filter(|member| member.is("hybrid")) {
        let zone = Zone::of(hybrid)?.filter(|zone| zone.heights()[1] > zone.heights()[0]);
        match among.partner(hybrid).zip(zone) {
            Some((partner, zone)) => all.push(compare(hybrid, partner, averages, &zone)?),
            None => left_out.push(format!(
                "Strain inside the zone of {}: it needs its enrichment and the grains alone of its packing.",
                hybrid.label
            )),
        }
    }
    if all.is_empty() {
        return Ok(Part { left_out, ..Part::default() });
    }
    let mut sheet = Sheet::new(
        "Shear stress over the shear strain inside the zone",
        &["grains alone at a height of", "strain inside", "mean difference", "root-mean-square"],
    );
    for compared in &all {
        for (other, what) in compared.others.iter().zip(OTHERS) {
            let told = |tell: &dyn Fn(&Difference) -> String| other.difference.as_ref().map(tell);
            let heights = other.heights.map(|height| format!("{:.1}", 1e3 * height)).join(" to ");
            sheet.row(
                &format!("{} \u{2013} {}, {what}", compared.hybrid.label, compared.partner.label),
                vec![
                    Some(format!("{heights}{THIN}mm")),
                    told(&|found| format!("{} to {}", percent(found.from), percent(found.to))),
                    told(&|found| share(found.mean)),
                    told(&|found| percent(found.rms)),
                ],
            );
        }
    }
    Ok(Part {
        sentences: sentence(among, &all).into_iter().collect(),
        figures: vec![drawing(among, &all)],
        sheets: vec![sheet],
        left_out,
        json: Value::Array(all.iter().map(json).collect()),
    })
}

fn sentence(among: &Among, all: &[Compared]) -> Option<String> {
    let of = |which: usize, pick: fn(&Difference) -> f64| -> Vec<(usize, f64)> {
        let found =
            |compared: &Compared| Some((compared.hybrid.group, pick(compared.others[which].difference.as_ref()?)));
        all.iter().filter_map(found).collect()
    };
    let told = |which: usize, what: &str| {
        let (means, squares) = (of(which, |found| found.mean), of(which, |found| found.rms));
        (!means.is_empty()).then(|| {
            format!(
                "Over the strain inside the zone the stress is off that of the grains alone, {what}, in the mean by: {}. \
                 Root-mean-square by: {}.",
                by_group(&among.groups, &means, share),
                by_group(&among.groups, &squares, percent)
            )
        })
    };
    let told: Vec<String> = OTHERS.iter().enumerate().filter_map(|(which, what)| told(which, what)).collect();
    (!told.is_empty()).then(|| told.join(" "))
}

fn json(compared: &Compared) -> Value {
    let [same, most] = &compared.others;
    json!({
        "run": compared.hybrid.label, "against": compared.partner.label, "seed": compared.hybrid.seed,
        "training": compared.hybrid.training(), "heights_m": compared.heights,
        "difference": same.difference.as_ref().map(Difference::json),
        "heights_sheared_most_m": most.heights,
        "difference_sheared_most": most.difference.as_ref().map(Difference::json),
    })
}

/// Of every case the first of the best trained hybrids, and the grains alone of its packing.
fn drawing(among: &Among, all: &[Compared]) -> Drawn {
    let best = |case: usize| {
        let of_case = all.iter().filter(|compared| compared.hybrid.case == case);
        of_case.reduce(|best, other| if other.hybrid.training() > best.hybrid.training() { other } else { best })
    };
    let (mut curves, mut entries) = (Vec::new(), Vec::new());
    for compared in (0..among.cases()).filter_map(best) {
        let (hybrid, partner) = (compared.hybrid, compared.partner);
        let [same, most] = &compared.others;
        let named = |what: &str| format!("{}, {what}", partner.label);
        for (member, curve, words, dash) in [
            (hybrid, &compared.curve, hybrid.label.clone(), ""),
            (partner, &same.curve, named(OTHERS[0]), ""),
            (partner, &most.curve, named(OTHERS[1]), "6 4"),
        ] {
            let stroke = Stroke::new(among.groups[member.group].colour, 1.8).dash(dash);
            curves.push(Curve { places: curve.places(), stroke });
            entries.push(Entry { words, stroke });
        }
    }
    let (mut svg, top) = start("compare-inside", WIDTH, &entries);
    let places = || curves.iter().flat_map(|curve| &curve.places).filter(|place| place[0].is_finite());
    let chart = Chart {
        title: String::new(),
        x: Axis::exact("shear strain inside the zone (%)", 0.0, places().map(|place| place[0]).fold(0.0, f64::max)),
        y: Axis::around(SHEAR_LABEL, places().map(|place| place[1]).chain([0.0])),
        moments: Vec::new(),
        levels: Vec::new(),
        curves: curves.clone(),
    };
    chart.draw(&mut svg, side_by_side(1, WIDTH, top, HEIGHT)[0]);
    Drawn {
        name: "compare_inside",
        drawing: svg.finish("Shear stress against the shear strain inside the zone"),
        caption: "Shear stress against the shear strain inside the zone that the grains took over, of the hybrid and of the \
                  grains alone (Chen et al. 2021, figure 15 right), of these the same material, and the part of the zone's \
                  height that shears most: displacement between the edges over the height, from the frames, linear between \
                  them."
            .to_owned(),
    }
}
