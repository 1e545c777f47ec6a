//! Incremental strain and bands (Chen et al. 2021, figures 18, 19, 21 and 24): thickness, slope and swelling of the strongest
//! straight band ([`crate::analysis::strip`]), and beside them the box of appendix A, which is the band's where there is one.

use serde_json::{Value, json};

use super::Runs;
use super::run::Run;
use super::space::Spaces;
use crate::analysis::band::{Band, CANDIDATE_SHARE, Candidates};
use crate::analysis::strip::{self, Field, Strip};
use crate::base::error::Error;
use crate::base::math::PI;
use crate::plot::report::chart::percent;
use crate::plot::report::compare::among::Group;
use crate::plot::report::compare::bands::pieces;
use crate::plot::report::compare::pictures::{Colours, Picture, draw};
use crate::plot::report::compare::{Drawn, Part, Sheet, by_group, range, share};
use crate::plot::report::findings::mean;
use crate::plot::report::load::Body;
use crate::plot::report::panels::{nearly_largest, round_up};
use crate::plot::report::scenes::{Valued, free, measured as boxed};
use crate::plot::report::words::{D50, plain};

/// The paper's interval of axial strain, and the end of its test; of other runs the same share of what they have in common.
const PAPER: [f64; 2] = [0.055, 0.085];
const PAPER_END: f64 = 0.1061;
/// Runs that end by this share less than an interval still reach its end.
pub const END_SLACK: f64 = 0.02;
/// Shares of the material that are candidates for a box: the 98th percentile, the 97th and the 99th.
const SHARES: [f64; 3] = [CANDIDATE_SHARE, 0.03, 0.01];
/// Pictures and bodies in them, up to which all runs are drawn and not the first of each group.
const PICTURES_MAX: usize = 6;
const BODIES_MAX: usize = 60_000;

/// The bands of a run; lengths in m.
pub struct Measured {
    /// Strains of the two frames.
    pub between: [f64; 2],
    bodies: Vec<Valued>,
    strip: Option<Strip>,
    /// Strains of the two frames of every piece, and the strip between them.
    pieces: Vec<([f64; 2], Option<Strip>)>,
    /// By the [`SHARES`].
    boxes: [Option<Band>; 3],
    /// The box by the threshold of the partner's.
    by_partner: Option<Band>,
    /// Swelling of the band over the interval, and the packing fraction of its grains at the end.
    pub swelling: Option<f64>,
    fraction: Option<f64>,
}

impl Measured {
    fn of(run: &Run, between: [f64; 2]) -> Result<Option<Self>, Error> {
        let [from, to] = between.map(|strain| run.frame_at(strain));
        let from = from.max(run.enriched.unwrap_or(0));
        if from >= to || run.strain_of(run.frames() - 1) < between[1] * (1.0 - END_SLACK) {
            return Ok(None);
        }
        let [first, last] = [run.snapshot(from)?, run.snapshot(to)?];
        let bodies = run.strained(Some(&first), &last);
        let mut of_pieces = Vec::new();
        for piece in pieces([from, to], |frame| run.strain_of(frame), |strain| run.frame_at(strain)) {
            let bodies = run.strained(Some(&run.snapshot(piece[0])?), &run.snapshot(piece[1])?);
            of_pieces.push((piece.map(|frame| run.strain_of(frame)), stripped(&bodies, run)));
        }
        let mut measured = Self {
            between: [from, to].map(|frame| run.strain_of(frame)),
            strip: stripped(&bodies, run),
            pieces: of_pieces,
            boxes: SHARES.map(|share| boxed(&bodies, 0.0, Candidates::Share(share))),
            by_partner: None,
            swelling: None,
            fraction: None,
            bodies,
        };
        let members = measured.members();
        let [before, after] = [&first, &last].map(|snapshot| Spaces::of(snapshot, &run.span));
        measured.swelling = after.swelling(&before, &members).filter(|_| !members.is_empty());
        measured.fraction = after.fraction(&members);
        Ok(Some(measured))
    }

    /// Bodies in the box of the strip.
    pub fn members(&self) -> Vec<Body> {
        let rows: Vec<&Valued> = free(&self.bodies).collect();
        self.strip.iter().flat_map(|strip| strip.band.members.iter().map(|&row| rows[row].body)).collect()
    }

    /// Thickness of the band, m.
    fn thickness(&self) -> Option<f64> {
        self.strip.as_ref().map(|strip| strip.band.thickness)
    }
}

fn stripped(bodies: &[Valued], run: &Run) -> Option<Strip> {
    let of = |get: fn(&Valued) -> f64| free(bodies).map(get).collect::<Vec<f64>>();
    let positions: Vec<[f64; 2]> = free(bodies).map(|row| row.body.position).collect();
    let (strains, areas, radii) = (of(|row| row.value), of(|row| row.body.area()), of(|row| row.body.radius));
    let field =
        Field { positions: &positions, strains: &strains, areas: &areas, radii: &radii, diameter: run.span.diameter };
    strip::strongest(&field)
}

/// Bands of all runs, and what they are measured between; or why there are none.
pub struct Bands {
    pub between: Result<[f64; 2], String>,
    /// One for every run.
    pub of: Vec<Option<Measured>>,
}

/// The strains to measure between, or why there are none.
fn interval(runs: &Runs, wanted: Option<[f64; 2]>) -> Result<[f64; 2], String> {
    let last = |run: &Run| run.strain_of(run.frames() - 1);
    let [end, longest] = range(runs.all.iter().map(last)).unwrap_or_default();
    let [from, to] = wanted.unwrap_or(PAPER.map(|strain| strain / PAPER_END * end));
    if to > longest * (1.0 + END_SLACK) {
        return Err(format!("the longest run ends at {}, and {} was asked for", percent(longest), percent(to)));
    }
    let enriched = runs.all.iter().filter_map(|run| run.enriched.map(|frame| run.strain_of(frame)));
    let from = enriched.fold(from, f64::max);
    if from < to {
        Ok([from, to])
    } else if to <= 0.0 {
        Err("a run has no two frames at different strains".to_owned())
    } else {
        Err(format!("the last enrichment is at {}, the interval ends at {}", percent(from), percent(to)))
    }
}

pub fn measured(runs: &Runs, wanted: Option<[f64; 2]>) -> Result<Bands, Error> {
    let between = interval(runs, wanted);
    let of = |run: &Run| match &between {
        Ok(between) => Measured::of(run, *between),
        Err(_) => Ok(None),
    };
    let mut all = runs.all.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    for (index, run) in runs.all.iter().enumerate().filter(|(_, run)| !run.is("dem")) {
        let partner = runs.partner(run).and_then(|partner| all[partner].as_ref());
        let threshold = partner.and_then(|partner| partner.boxes[0].as_ref()).map(|band| band.threshold);
        if let (Some(threshold), Some(own)) = (threshold, &mut all[index]) {
            own.by_partner = boxed(&own.bodies, 0.0, Candidates::Beyond(threshold));
        }
    }
    Ok(Bands { between, of: all })
}

pub fn part(runs: &Runs, bands: &Bands) -> Result<Part, Error> {
    let between = match &bands.between {
        Ok(between) => *between,
        Err(why) => return Ok(Part::without(format!("Incremental strain and bands are left out: {why}."))),
    };
    let missing = runs.all.iter().zip(&bands.of).filter(|(_, measured)| measured.is_none());
    let line = |(run, _): (&Run, _)| {
        format!("No band of {}: it has no two frames between these strains, or ends before.", run.label)
    };
    Ok(Part {
        sentences: sentences(runs, bands, between),
        figures: drawing(runs, bands).into_iter().collect(),
        sheets: vec![strips(runs, bands), boxes(runs, bands)],
        left_out: missing.map(line).collect(),
        json: json(runs, bands, between),
    })
}

/// Runs with what was measured of them.
fn told<'a>(runs: &'a Runs, bands: &'a Bands) -> impl Iterator<Item = (&'a Run<'a>, &'a Measured)> {
    runs.all.iter().zip(&bands.of).filter_map(|(run, measured)| Some((run, measured.as_ref()?)))
}

/// In D50: one decimal is more than a thickness deserves.
fn in_diameters(run: &Run, length: f64) -> String {
    plain((10.0 * length / run.span.diameter).round() / 10.0, 3)
}

/// To a tenth, which is more than is known.
fn degrees(band: &Band) -> f64 {
    (10.0 * band.angle * 180.0 / PI).round() / 10.0
}

/// Whole degrees with a true minus sign.
fn slope(degrees: f64) -> String {
    format!("{degrees:.0}\u{b0}").replace('-', "\u{2212}")
}

fn strips(runs: &Runs, bands: &Bands) -> Sheet {
    let mut sheet = Sheet::new(
        "The strongest straight band; lengths in D\u{2085}\u{2080} unless said otherwise",
        &[
            "between strains",
            "thickness",
            "in pieces of the interval",
            "slope",
            "length",
            "share of all strain",
            "volume strain of it",
            "packing fraction at the end",
            "thickness in cells",
        ],
    );
    for (run, measured) in told(runs, bands) {
        let strip = measured.strip.as_ref();
        let of_band = |tell: &dyn Fn(&Band) -> String| strip.map(|strip| tell(&strip.band));
        let piece = |(_, strip): &([f64; 2], Option<Strip>)| {
            strip.as_ref().map_or_else(|| "\u{2013}".to_owned(), |strip| in_diameters(run, strip.band.thickness))
        };
        let pieces: Vec<String> = measured.pieces.iter().map(piece).collect();
        sheet.row(
            &run.label,
            vec![
                Some(measured.between.map(percent).join(" to ")),
                of_band(&|band| in_diameters(run, band.thickness)),
                (!pieces.is_empty()).then(|| pieces.join(", ")),
                of_band(&|band| slope(degrees(band))),
                of_band(&|band| in_diameters(run, band.length)),
                strip.map(|strip| percent(strip.share)),
                measured.swelling.map(share),
                measured.fraction.map(|fraction| format!("{fraction:.3}")),
                run.cell().and_then(|cell| of_band(&|band| plain(band.thickness / cell, 2))),
            ],
        );
    }
    sheet
}

fn boxes(runs: &Runs, bands: &Bands) -> Sheet {
    let mut sheet = Sheet::new(
        "The box around the most strained 2\u{2009}% (appendix A): thickness, in brackets length, D\u{2085}\u{2080}",
        &["98th percentile", "97th", "99th", "dem's threshold", "slope by the 98th"],
    );
    for (run, measured) in told(runs, bands) {
        let size = |band: &Option<Band>| {
            let size = |band: &Band| [band.thickness, band.length].map(|length| in_diameters(run, length));
            band.as_ref().map(size).map(|[thickness, length]| format!("{thickness} ({length})"))
        };
        let [usual, wide, narrow] = &measured.boxes;
        let slope = usual.as_ref().map(|band| slope(degrees(band)));
        sheet.row(&run.label, vec![size(usual), size(wide), size(narrow), size(&measured.by_partner), slope]);
    }
    sheet
}

fn sentences(runs: &Runs, bands: &Bands, between: [f64; 2]) -> Vec<String> {
    let of = |pick: fn(&Run, &Measured) -> Option<f64>| -> Vec<(usize, f64)> {
        told(runs, bands).filter_map(|(run, measured)| Some((run.group, pick(run, measured)?))).collect()
    };
    let thickness = of(|run, measured| Some(measured.thickness()? / run.span.diameter));
    if thickness.is_empty() {
        return Vec::new();
    }
    let slopes = of(|_, measured| Some(degrees(&measured.strip.as_ref()?.band).abs()));
    let shares = of(|_, measured| Some(measured.strip.as_ref()?.share));
    let swellings = of(|_, measured| measured.swelling);
    let rounded = |value: f64| plain((10.0 * value).round() / 10.0, 3);
    vec![format!(
        "Thickness of the strongest straight band from {} to {} of {}: {}. Its slope: {}; its share of all shear strain: {}; its \
         volume strain: {}.",
        percent(between[0]),
        percent(between[1]),
        runs.press.strain_words(),
        by_group(&runs.groups, &thickness, |thickness| format!("{} {D50}", rounded(thickness))),
        by_group(&runs.groups, &slopes, slope),
        by_group(&runs.groups, &shares, percent),
        by_group(&runs.groups, &swellings, share),
    )]
}

/// Pictures of all runs, or of the first that can be drawn of every group where they or their bodies are many.
pub fn chosen<T>(runs: &Runs, drawn: impl Fn(usize) -> Option<T>) -> Vec<T> {
    let bodies: usize = runs.all.iter().map(|run| run.bodies).sum();
    if runs.all.len() <= PICTURES_MAX && bodies <= BODIES_MAX {
        return (0..runs.all.len()).filter_map(drawn).collect();
    }
    let first = |group: &Group| group.members.iter().find_map(|&index| drawn(index));
    runs.groups.iter().filter_map(first).collect()
}

fn drawing(runs: &Runs, bands: &Bands) -> Option<Drawn> {
    let picture = |index: usize| {
        let (run, measured) = (&runs.all[index], bands.of[index].as_ref()?);
        Some(Picture {
            span: run.span,
            titles: [run.label.clone(), measured.between.map(percent).join(" to ")],
            bodies: measured.bodies.clone(),
            band: measured.strip.as_ref().map(|strip| strip.band.clone()),
        })
    };
    let pictures: Vec<Picture> = chosen(runs, picture);
    if pictures.is_empty() {
        return None;
    }
    let upper = round_up(pictures.iter().map(|picture| nearly_largest(&picture.bodies)).fold(0.0, f64::max));
    let colours = Colours { upper, unit: 1.0, words: "incremental deviatoric strain |e\u{2032}|" };
    Some(Drawn {
        name: "compare_bands",
        drawing: draw("compare-bands", &pictures, &colours, "Incremental deviatoric strain of all runs"),
        caption: "Incremental deviatoric strain between two strains (Chen et al. 2021, figures 18 and 24), and the strongest \
                  straight band with its thickness beside it: of strips 10\u{2009}D\u{2085}\u{2080} across in all directions the \
                  one with the largest excess of mean strain over the specimen's times the root of its area, and the unbroken \
                  stretch across it in which the mean along it is at least half of its largest. Where it has little of all \
                  strain there is no one band, and its thickness is that of a part of a pattern. Its volume strain is that of \
                  the grains in it, by their shares of the space between them, since strain fitted to the motions of grains \
                  that mix has no volume to be trusted. The box of appendix A holds the most strained 2\u{2009}% without \
                  outliers: all bands at once, where there are several."
            .to_owned(),
    })
}

fn json(runs: &Runs, bands: &Bands, between: [f64; 2]) -> Value {
    let of_run = |(run, measured): (&Run, &Measured)| {
        let diameters = |length: f64| length / run.span.diameter;
        let strip = measured.strip.as_ref();
        let band = strip.map(|strip| &strip.band);
        let pieces: Vec<Value> = measured
            .pieces
            .iter()
            .map(|(strains, strip)| {
                let band = strip.as_ref().map(|strip| &strip.band);
                json!({
                    "between_strains": strains, "thickness_d50": band.map(|band| diameters(band.thickness)),
                    "slope_deg": band.map(degrees),
                })
            })
            .collect();
        let box_of = |band: &Option<Band>| {
            band.as_ref().map(|band| {
                json!({
                    "thickness_d50": diameters(band.thickness), "length_d50": diameters(band.length),
                    "slope_deg": degrees(band),
                })
            })
        };
        json!({
            "run": run.label, "group": runs.groups[run.group].name, "seed": run.seed,
            "between_strains": measured.between,
            "thickness_d50": band.map(|band| diameters(band.thickness)),
            "thickness_cells": run.cell().zip(band).map(|(cell, band)| band.thickness / cell),
            "slope_deg": band.map(degrees),
            "length_d50": band.map(|band| diameters(band.length)),
            "centre_m": band.map(|band| band.centre),
            "share_of_strain": strip.map(|strip| strip.share),
            "pieces": pieces,
            "volume_strain": measured.swelling, "packing_fraction_end": measured.fraction,
            "box_98th": box_of(&measured.boxes[0]), "box_97th": box_of(&measured.boxes[1]),
            "box_99th": box_of(&measured.boxes[2]), "box_dem_threshold": box_of(&measured.by_partner),
        })
    };
    let of_group = |(index, group): (usize, &Group)| {
        let own = told(runs, bands).filter(|(run, _)| run.group == index);
        let own: Vec<f64> = own.filter_map(|(run, of)| Some(of.thickness()? / run.span.diameter)).collect();
        let [least, most] = range(own.iter().copied())?;
        Some(json!({
            "group": group.name, "packings": own.len(), "mean_d50": mean(&own), "least_d50": least, "most_d50": most,
        }))
    };
    let groups: Vec<Value> = runs.groups.iter().enumerate().filter_map(of_group).collect();
    json!({
        "between_strains": between, "groups": groups, "runs": told(runs, bands).map(of_run).collect::<Vec<_>>(),
    })
}
