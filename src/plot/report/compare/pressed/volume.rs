//! Volume strain of the whole, where membranes enclose it, and of the band (Chen et al. 2021, figures 17 and 20): of what lies in the
//! strongest strip of each run, and of the grains of a hybrid's zone, which can be found again where they are alone. Of two strips
//! the stronger one dilates sooner; the same grains are the same material.

use serde_json::{Value, json};

use super::Runs;
use super::bands::{Bands, END_SLACK};
use super::load_curve::{axis, legend, stroke};
use super::run::Run;
use super::space::Spaces;
use crate::base::error::Error;
use crate::plot::report::WIDTH;
use crate::plot::report::chart::{Axis, Chart, Curve, percent, side_by_side};
use crate::plot::report::compare::zone::{SAME, is_inner};
use crate::plot::report::compare::{Drawn, Part, Sheet, share};
use crate::plot::report::figures::{HEIGHT, places, start};
use crate::plot::report::load::{Body, linear};

/// Volume strain of some bodies of a run, at frames from one strain on.
struct Swelling {
    strain: Vec<f64>,
    volume: Vec<f64>,
}

impl Swelling {
    fn of(run: &Run, members: &[Body], first: usize) -> Result<Option<Self>, Error> {
        if members.is_empty() {
            return Ok(None);
        }
        let start = run.snapshot(first)?;
        let start = Spaces::of(&start, &run.span);
        let mut curve = Self { strain: vec![run.strain_of(first)], volume: vec![0.0] };
        for frame in first + 1..run.frames() {
            if let Some(swelling) = Spaces::of(&run.snapshot(frame)?, &run.span).swelling(&start, members) {
                curve.strain.push(run.strain_of(frame));
                curve.volume.push(swelling);
            }
        }
        Ok((curve.strain.len() > 1).then_some(curve))
    }

    /// Of the bodies in a run's band, since the last enrichment.
    fn of_band(run: &Run, bands: &Bands, index: usize, from: f64) -> Result<Option<Self>, Error> {
        let Some(measured) = &bands.of[index] else { return Ok(None) };
        Self::of(run, &measured.members(), run.frame_at(from).max(run.enriched.unwrap_or(0)))
    }

    /// Held a little beyond the frames that it has: they come at other times than rows.
    fn at(&self, strain: f64) -> Option<f64> {
        let [first, last] = [self.strain[0], self.strain[self.strain.len() - 1]];
        let is_near = (first - END_SLACK * last..=last + END_SLACK * last).contains(&strain);
        is_near.then(|| linear(&self.strain, &self.volume, strain.clamp(first, last))).flatten()
    }
}

/// Volume strain of the grains that first replaced points in a hybrid, since then, and of the very same grains where they are alone.
struct OfZone {
    hybrid: Swelling,
    alone: Swelling,
    /// Which run of grains alone that is.
    partner: usize,
}

impl OfZone {
    /// Of one hybrid, or why not.
    fn of(runs: &Runs, hybrid: &Run) -> Result<Result<Self, String>, Error> {
        let fail =
            |why: &str| Ok(Err(format!("Volume strain of the zone\u{2019}s grains of {}: {why}.", hybrid.label)));
        let Some(first) = hybrid.enriched else { return fail("it was not enriched, or has no frame before or after") };
        let Some(partner) = runs.partner(hybrid).filter(|&partner| runs.all[partner].seed == hybrid.seed) else {
            return fail("there is no run of grains alone with its packing");
        };
        let members = lasting(hybrid, first)?;
        let alone = &runs.all[partner];
        let start = alone.frame_at(hybrid.strain_of(first));
        if !are_same(&members, &alone.snapshot(start)?.bodies, hybrid.span.diameter) {
            return fail("its grains are not those of the grains alone");
        }
        let [of_hybrid, of_alone] =
            [(hybrid, first), (alone, start)].map(|(run, first)| Swelling::of(run, &members, first));
        match of_hybrid?.zip(of_alone?) {
            Some((hybrid, alone)) => Ok(Ok(Self { hybrid, alone, partner })),
            None => fail("no grain outside of the rim stays to the end, or a run has no frame after the enrichment"),
        }
    }
}

/// Grains outside of the rim that a frame has and that are grains still at the end.
fn lasting(hybrid: &Run, first: usize) -> Result<Vec<Body>, Error> {
    let key = |body: &Body| (body.kind.is_grain(), body.id);
    let end = hybrid.snapshot(hybrid.frames() - 1)?.bodies;
    let mut members = hybrid.snapshot(first)?.bodies;
    members.retain(|body| is_inner(body) && end.binary_search_by_key(&key(body), key).is_ok());
    Ok(members)
}

/// Whether `grains` are among `others` by id, and began where those did: a piece of packing has other grains than a specimen.
fn are_same(grains: &[Body], others: &[Body], diameter: f64) -> bool {
    let key = |body: &Body| (body.kind.is_grain(), body.id);
    let is_there = |grain: &Body| {
        others.binary_search_by_key(&key(grain), key).is_ok_and(|row| {
            let (own, other) = (grain.origin(), others[row].origin());
            let apart = [0, 1].map(|axis| own[axis] - other[axis]);
            apart[0] * apart[0] + apart[1] * apart[1] < SAME * SAME * diameter * diameter
        })
    };
    grains.iter().all(is_there)
}

pub fn part(runs: &Runs, bands: &Bands) -> Result<Part, Error> {
    let from = runs.all.iter().filter_map(Run::enriched_strain).fold(0.0, f64::max);
    let of_band = |(index, run): (usize, &Run)| Swelling::of_band(run, bands, index, from);
    let of_bands = runs.all.iter().enumerate().map(of_band).collect::<Result<Vec<_>, _>>()?;
    let is_enclosed = runs.all.iter().all(|run| run.volume.is_some());
    let mut left_out = Vec::new();
    let mut of_zones = Vec::new();
    for run in &runs.all {
        let of_zone = if run.is("hybrid") { Some(OfZone::of(runs, run)?) } else { None };
        let of_zone = of_zone.and_then(|of_zone| of_zone.map_err(|why| left_out.push(why)).ok());
        of_zones.push(of_zone);
    }
    if !is_enclosed {
        left_out.push("Volume strain of the whole is left out: no membranes enclose it.".to_owned());
    }
    if of_bands.iter().all(Option::is_none) {
        left_out.push("Volume strain of bands is left out: none was measured.".to_owned());
        if !is_enclosed && of_zones.iter().all(Option::is_none) {
            return Ok(Part { left_out, ..Part::default() });
        }
    }
    let end = runs.all.iter().map(Run::strain_end).fold(f64::INFINITY, f64::min);
    let [first, last] = bands.between.clone().unwrap_or([0.5 * end, end]);
    let strains = [first, last, end];
    let json = |((run, of_band), of_zone): ((&Run, &Option<Swelling>), &Option<OfZone>)| {
        json!({
            "run": run.label, "seed": run.seed, "strains": strains,
            "volume_strain": strains.map(|strain| whole_at(run, strain)),
            "band_since_strain": of_band.as_ref().map(|curve| curve.strain[0]),
            "volume_strain_band": of_band.as_ref().map(|curve| strains.map(|strain| curve.at(strain))),
            "zone_since_strain": of_zone.as_ref().map(|zone| zone.hybrid.strain[0]),
            "zone_alone_in": of_zone.as_ref().map(|zone| &runs.all[zone.partner].label),
            "volume_strain_zone": of_zone.as_ref().map(|zone| strains.map(|strain| zone.hybrid.at(strain))),
            "volume_strain_zone_alone": of_zone.as_ref().map(|zone| strains.map(|strain| zone.alone.at(strain))),
        })
    };
    Ok(Part {
        sentences: Vec::new(),
        figures: vec![drawing(runs, (&of_bands, &of_zones), is_enclosed, from)],
        sheets: vec![sheet(runs, (&of_bands, &of_zones), strains)],
        left_out,
        json: Value::Array(runs.all.iter().zip(&of_bands).zip(&of_zones).map(json).collect()),
    })
}

fn whole_at(run: &Run, strain: f64) -> Option<f64> {
    linear(&run.strain, run.volume.as_ref()?, strain)
}

/// Of every run, the curves of its band and of its zone.
type Curves<'a> = (&'a [Option<Swelling>], &'a [Option<OfZone>]);

fn sheet(runs: &Runs, (of_bands, of_zones): Curves, strains: [f64; 3]) -> Sheet {
    let mut sheet = Sheet::new(
        "Volume strain, of the whole, of the band since the last enrichment, and of the grains that first replaced points since then, \
         at three strains",
        &["strains", "of the whole", "of the band", "of the zone's grains", "the same grains alone"],
    );
    for ((run, of_band), of_zone) in runs.all.iter().zip(of_bands).zip(of_zones) {
        let told = |of: &dyn Fn(f64) -> Option<f64>| {
            let told: Option<Vec<String>> = strains.iter().map(|&strain| of(strain).map(share)).collect();
            told.map(|told| told.join(", "))
        };
        let curves = [
            told(&|strain| whole_at(run, strain)),
            told(&|strain| of_band.as_ref()?.at(strain)),
            told(&|strain| of_zone.as_ref()?.hybrid.at(strain)),
            told(&|strain| of_zone.as_ref()?.alone.at(strain)),
        ];
        let at = curves.iter().any(Option::is_some).then(|| strains.map(percent).join(", "));
        sheet.row(&run.label, [at].into_iter().chain(curves).collect());
    }
    sheet
}

fn drawing(runs: &Runs, (of_bands, of_zones): Curves, is_enclosed: bool, from: f64) -> Drawn {
    let (mut svg, top) = start("compare-volume", WIDTH, &legend(runs));
    let curve = |index: usize, strain: &[f64], volume: &[f64]| Curve {
        places: places(strain, volume, 0.01, None),
        stroke: stroke(&runs.groups, runs.all[index].group, index),
    };
    let drawn = |index: usize, swelling: &Swelling| curve(index, &swelling.strain, &swelling.volume);
    let all = || runs.all.iter().enumerate();
    let whole = all().filter_map(|(index, run)| Some(curve(index, &run.strain, run.volume.as_ref()?)));
    let of_band = all().filter_map(|(index, _)| Some(drawn(index, of_bands[index].as_ref()?)));
    let zones = || all().filter_map(|(index, _)| Some((index, of_zones[index].as_ref()?)));
    let of_zone = zones().flat_map(|(index, zone)| [drawn(index, &zone.hybrid), drawn(zone.partner, &zone.alone)]);
    let charts = [
        ("of the whole", whole.collect::<Vec<_>>(), is_enclosed),
        ("of the band", of_band.collect(), of_bands.iter().any(Option::is_some)),
        ("of the zone\u{2019}s grains", of_zone.collect(), of_zones.iter().any(Option::is_some)),
    ];
    let charts: Vec<_> = charts.into_iter().filter(|(.., is_there)| *is_there).collect();
    let frames = side_by_side(charts.len(), WIDTH, top, HEIGHT);
    let several = charts.len() > 1;
    for (((title, curves, _), frame), letter) in charts.into_iter().zip(frames).zip('a'..) {
        let values = curves.iter().flat_map(|curve| &curve.places).map(|place| place[1]).collect::<Vec<f64>>();
        let chart = Chart {
            title: if several { format!("({letter}) {title}") } else { title.to_owned() },
            x: axis(runs),
            y: Axis::around("volume strain (%)", values.into_iter().chain([0.0])),
            curves,
            moments: Vec::new(),
            levels: Vec::new(),
        };
        chart.draw(&mut svg, frame);
    }
    Drawn {
        name: "compare_volume",
        drawing: svg
            .finish("Volume strain of the whole, of the band and of the zone against the way of the body that presses"),
        caption: format!(
            "Volume strain, positive in dilation (Chen et al. 2021, figure 17): of what membranes enclose, since the first row; \
             of the bodies that lie in the band of the figure before, since {} of strain; and of the grains that first replaced \
             points, without the rim, since then, beside that of the very same grains in the run of grains alone. By the space that they \
             fill: of grains a third of every triangle between neighbours, of points their volume.",
            percent(from)
        ),
    }
}
