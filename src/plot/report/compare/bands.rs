//! Incremental strain and the thickness of the band (Chen et al. 2021, figures 11 and 12, appendix A), with how much the
//! thickness hangs on choices: the interval of strain, the percentile, the packing.

use serde_json::{Value, json};

use super::among::{Among, Group, Member};
use super::pictures::{Colours, Picture, draw};
use super::profile::{extent, width_at_half};
use super::{Drawn, Part, Sheet, range};
use crate::analysis::band::{Band, CANDIDATE_SHARE, Candidates};
use crate::base::error::Error;
use crate::plot::report::chart::percent;
use crate::plot::report::findings::mean;
use crate::plot::report::panels::{nearly_largest, round_up};
use crate::plot::report::scenes::{Valued, free, measured, strained};
use crate::plot::report::words::{D50, plain};

/// The paper's interval of horizontal strain; of shorter runs the same share of what they have in common.
pub const PAPER: [f64; 2] = [0.37, 0.57];
/// Runs that end by this much less still reach the paper's end.
const END_SLACK: f64 = 0.005;
/// Shares of the material that are candidates beside [`CANDIDATE_SHARE`], the 98th percentile: the 97th and the 99th.
const OTHER_SHARES: [f64; 2] = [0.03, 0.01];
/// Pieces of the interval that are measured by themselves.
const PIECES: usize = 3;

/// The band of a run, measured in several ways; thicknesses in m.
struct Measured {
    /// Strains of the two frames.
    between: [f64; 2],
    bodies: Vec<Valued>,
    band: Option<Band>,
    /// By the [`OTHER_SHARES`].
    by_share: [Option<f64>; 2],
    /// Strains of the two frames of every piece, and the thickness between them.
    by_piece: Vec<([f64; 2], Option<f64>)>,
    /// With the threshold of the same packing's grains alone, which is what the paper's words say.
    by_partner: Option<f64>,
    /// Width at half of the largest mean strain.
    at_half: Option<f64>,
    /// Height of one body in the band, m: what the box around centres leaves out.
    body: Option<f64>,
}

impl Measured {
    fn of(member: &Member, between: [f64; 2]) -> Result<Option<Self>, Error> {
        let run = member.run;
        let [from, to] = between.map(|strain| run.frame_at(strain));
        let from = from.max(member.enriched.unwrap_or(0));
        if from >= to || last(member) < between[1] - END_SLACK {
            return Ok(None);
        }
        let increment = |from: usize, to: usize| -> Result<Vec<Valued>, Error> {
            Ok(strained(&run.snapshot(to)?, Some(&run.snapshot(from)?), &run.span()))
        };
        let bodies = increment(from, to)?;
        let thickness = |bodies: &[Valued], share: f64| {
            measured(bodies, run.width, Candidates::Share(share)).map(|band| band.thickness)
        };
        let mut by_piece = Vec::new();
        for piece in pieces([from, to], |frame| run.strain_of(frame), |strain| run.frame_at(strain)) {
            let strains = piece.map(|frame| run.strain_of(frame));
            by_piece.push((strains, thickness(&increment(piece[0], piece[1])?, CANDIDATE_SHARE)));
        }
        let band = measured(&bodies, run.width, Candidates::Share(CANDIDATE_SHARE));
        let body = band.as_ref().and_then(|band| {
            let rows: Vec<&Valued> = free(&bodies).collect();
            band.members.iter().map(|&row| extent(&rows[row].body)).reduce(f64::max)
        });
        Ok(Some(Self {
            between: [from, to].map(|frame| run.strain_of(frame)),
            by_share: OTHER_SHARES.map(|share| thickness(&bodies, share)),
            by_piece,
            by_partner: None,
            at_half: width_at_half(&bodies, run.diameter),
            band,
            body,
            bodies,
        }))
    }

    fn thickness(&self) -> Option<f64> {
        self.band.as_ref().map(|band| band.thickness)
    }

    /// Least and most of all ways, m.
    fn range(&self) -> Option<[f64; 2]> {
        let pieces = self.by_piece.iter().filter_map(|(_, thickness)| *thickness);
        range(self.thickness().into_iter().chain(self.by_share.into_iter().flatten()).chain(pieces))
    }
}

/// First and last frame of every piece of an interval of frames, equal in strain as nearly as there are frames; none of an interval
/// that has no more than one piece.
pub fn pieces(
    [from, to]: [usize; 2],
    strain_of: impl Fn(usize) -> f64,
    frame_at: impl Fn(f64) -> usize,
) -> Vec<[usize; 2]> {
    let [first, last] = [from, to].map(&strain_of);
    let mut edges: Vec<usize> =
        (0..=PIECES).map(|piece| frame_at(first + piece as f64 / PIECES as f64 * (last - first))).collect();
    edges.dedup();
    if edges.len() > 2 { edges.windows(2).map(|pair| [pair[0], pair[1]]).collect() } else { Vec::new() }
}

/// Strain of the last frame.
fn last(member: &Member) -> f64 {
    member.run.strain_of(member.run.frame_times.len() - 1)
}

/// The strains to measure between, or why there are none.
pub fn interval(among: &Among, wanted: Option<[f64; 2]>) -> Result<[f64; 2], String> {
    let [end, longest] = range(among.members.iter().map(last)).unwrap_or_default();
    let [from, to] = wanted.unwrap_or_else(|| match end / PAPER[1] {
        share if end < PAPER[1] - END_SLACK => PAPER.map(|strain| share * strain),
        _ => PAPER,
    });
    if to > longest + END_SLACK {
        return Err(format!("the longest run ends at {}, and {} was asked for", percent(longest), percent(to)));
    }
    let enriched = among.members.iter().filter_map(|member| member.enriched.map(|frame| member.run.strain_of(frame)));
    let from = enriched.fold(from, f64::max);
    if from < to {
        Ok([from, to])
    } else {
        Err(format!("the last enrichment is at {}, the interval ends at {}", percent(from), percent(to)))
    }
}

pub fn part(among: &Among, wanted: Option<[f64; 2]>) -> Result<Part, Error> {
    let between = match interval(among, wanted) {
        Ok(between) => between,
        Err(why) => return Ok(Part::without(format!("Incremental strain and bands are left out: {why}."))),
    };
    let mut all = among.members.iter().map(|member| Measured::of(member, between)).collect::<Result<Vec<_>, _>>()?;
    for member in among.members.iter().filter(|member| !member.is("dem")) {
        let partner = among.partner(member).and_then(|partner| all[partner.index].as_ref());
        let threshold = partner.and_then(|partner| partner.band.as_ref()).map(|band| band.threshold);
        if let (Some(threshold), Some(own)) = (threshold, &mut all[member.index]) {
            let band = measured(&own.bodies, member.run.width, Candidates::Beyond(threshold));
            own.by_partner = band.map(|band| band.thickness);
        }
    }
    let without = |member: &&Member| {
        format!("No band of {}: it has no two frames between these strains, or ends before.", member.label)
    };
    let missing = among.members.iter().zip(&all).filter(|(_, measured)| measured.is_none());
    Ok(Part {
        sentences: sentences(among, &all, between),
        figures: drawing(among, &all).into_iter().collect(),
        sheets: vec![sheet(among, &all)],
        left_out: missing.map(|(member, _)| without(&member)).collect(),
        json: json(among, &all, between),
    })
}

fn in_diameters(member: &Member, thickness: Option<f64>) -> Option<String> {
    thickness.map(|thickness| rounded(thickness / member.run.diameter))
}

/// A thickness in D50 or cells: one decimal is more than it deserves.
fn rounded(value: f64) -> String {
    plain((10.0 * value).round() / 10.0, 3)
}

fn sheet(among: &Among, all: &[Option<Measured>]) -> Sheet {
    let mut sheet = Sheet::new(
        "Thickness of the band, in D\u{2085}\u{2080} unless said otherwise",
        &[
            "between strains",
            "98th percentile",
            "97th",
            "99th",
            "pieces of the interval",
            "dem's threshold",
            "at half of the peak",
            "in cells: box, with the bodies, at half",
        ],
    );
    for (member, measured) in among.members.iter().zip(all) {
        let Some(measured) = measured else { continue };
        let told = |thickness| in_diameters(member, thickness);
        let pieces: Vec<String> = measured
            .by_piece
            .iter()
            .map(|(_, thickness)| told(*thickness).unwrap_or_else(|| "\u{2013}".to_owned()))
            .collect();
        let cells = member.cell().zip(measured.thickness()).zip(measured.body).map(|((cell, thickness), body)| {
            let half = measured.at_half.map_or_else(String::new, |half| format!(", {}", rounded(half / cell)));
            format!("{}, {}{half}", rounded(thickness / cell), rounded((thickness + body) / cell))
        });
        sheet.row(
            &member.label,
            vec![
                Some(format!("{} to {}", percent(measured.between[0]), percent(measured.between[1]))),
                told(measured.thickness()),
                told(measured.by_share[0]),
                told(measured.by_share[1]),
                (!pieces.is_empty()).then(|| pieces.join(", ")),
                told(measured.by_partner),
                told(measured.at_half),
                cells,
            ],
        );
    }
    sheet
}

/// Thicknesses of a group's packings in D50.
fn of_group(among: &Among, group: &Group, all: &[Option<Measured>]) -> Vec<f64> {
    let of = |&index: &usize| Some(all[index].as_ref()?.thickness()? / among.members[index].run.diameter);
    group.members.iter().filter_map(of).collect()
}

fn sentences(among: &Among, all: &[Option<Measured>], between: [f64; 2]) -> Vec<String> {
    let mut told = Vec::new();
    for group in &among.groups {
        let thicknesses = of_group(among, group, all);
        let Some([least, most]) = range(thicknesses.iter().copied()) else { continue };
        let mut words = format!("{} {} {D50}", group.name, rounded(mean(&thicknesses)));
        if thicknesses.len() > 1 {
            words += &format!(" ({} to {}, {} packings)", rounded(least), rounded(most), thicknesses.len());
        } else if let Some([least, most]) = all[group.members[0]].as_ref().and_then(Measured::range) {
            let diameter = among.members[group.members[0]].run.diameter;
            words += &format!(
                " ({} to {} by other percentiles and intervals)",
                rounded(least / diameter),
                rounded(most / diameter)
            );
        }
        let member = &among.members[group.members[0]];
        let body = all[group.members[0]].as_ref().and_then(|measured| measured.body);
        if let (true, Some(cell), Some(body)) = (member.is("mpm"), member.cell(), body) {
            let cells = (mean(&thicknesses) * member.run.diameter + body) / cell;
            words += &format!(", with the points themselves {} cells", rounded(cells));
            if let Some(half) = all[group.members[0]].as_ref().and_then(|measured| measured.at_half) {
                words += &format!(", at half of the peak {} cells", rounded(half / cell));
            }
        }
        told.push(words);
    }
    if told.is_empty() {
        return told;
    }
    vec![format!(
        "Thickness of the band from {} to {} of strain: {}.",
        percent(between[0]),
        percent(between[1]),
        told.join("; ")
    )]
}

fn drawing(among: &Among, all: &[Option<Measured>]) -> Option<Drawn> {
    let picture = |group: &Group| {
        let index = *group.members.iter().find(|&&index| all[index].is_some())?;
        let measured = all[index].as_ref()?;
        let member = &among.members[index];
        let seed = member.seed.map_or_else(String::new, |seed| format!("seed {seed}, "));
        let [from, to] = measured.between.map(percent);
        let titles = [group.name.clone(), format!("{seed}{from} to {to}")];
        Some(Picture { span: member.run.span(), titles, bodies: measured.bodies.clone(), band: measured.band.clone() })
    };
    let pictures: Vec<Picture> = among.groups.iter().filter_map(picture).collect();
    if pictures.is_empty() {
        return None;
    }
    let upper = round_up(pictures.iter().map(|picture| nearly_largest(&picture.bodies)).fold(0.0, f64::max));
    let colours = Colours { upper, unit: 1.0, words: "incremental deviatoric strain |e\u{2032}|" };
    Some(Drawn {
        name: "compare_bands",
        drawing: draw("compare-bands", &pictures, &colours, "Incremental deviatoric strain of all methods"),
        caption: "Incremental deviatoric strain between two strains of the specimen (Chen et al. 2021, figures 11 and 12), the \
                  first packing of each, and the band by their appendix A with its thickness beside it: the box around the \
                  centres of its members, which has none where they are one row of points. The table has it by other percentiles \
                  of strain, in pieces of the interval, with the threshold of the grains alone, and the width in which the \
                  mean strain of a height is at least half of its largest."
            .to_owned(),
    })
}

fn json(among: &Among, all: &[Option<Measured>], between: [f64; 2]) -> Value {
    let of_run = |(member, measured): (&Member, &Option<Measured>)| {
        let measured = measured.as_ref()?;
        let diameters = |thickness: Option<f64>| thickness.map(|thickness| thickness / member.run.diameter);
        let pieces: Vec<Value> = measured
            .by_piece
            .iter()
            .map(|(strains, thickness)| json!({ "between_strains": strains, "thickness_d50": diameters(*thickness) }))
            .collect();
        Some(json!({
            "run": member.label, "group": among.groups[member.group].name, "seed": member.seed,
            "between_strains": measured.between,
            "thickness_d50": diameters(measured.thickness()),
            "thickness_d50_97th": diameters(measured.by_share[0]),
            "thickness_d50_99th": diameters(measured.by_share[1]),
            "pieces": pieces,
            "thickness_d50_dem_threshold": diameters(measured.by_partner),
            "width_at_half_d50": diameters(measured.at_half),
            "width_at_half_cells": member.cell().zip(measured.at_half).map(|(cell, width)| width / cell),
            "thickness_cells": member.cell().zip(measured.thickness()).map(|(cell, thickness)| thickness / cell),
            "thickness_cells_with_bodies": member.cell().zip(measured.thickness()).zip(measured.body)
                .map(|((cell, thickness), body)| (thickness + body) / cell),
            "centre_m": measured.band.as_ref().map(|band| band.centre[1]),
        }))
    };
    let runs: Vec<Value> = among.members.iter().zip(all).filter_map(of_run).collect();
    let groups: Vec<Value> = among
        .groups
        .iter()
        .filter_map(|group| {
            let thicknesses = of_group(among, group, all);
            let [least, most] = range(thicknesses.iter().copied())?;
            Some(json!({
                "group": group.name, "packings": thicknesses.len(),
                "mean_d50": mean(&thicknesses), "least_d50": least, "most_d50": most,
            }))
        })
        .collect();
    json!({ "between_strains": between, "runs": runs, "groups": groups })
}
