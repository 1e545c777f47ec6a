//! Incremental strain and bands (Chen et al. 2021, figures 11, 12, 18, 19, 21, 24, appendix A), with how much a thickness hangs on
//! choices: the interval of strain, the percentile, the packing. Where sides are joined the band is the box of appendix A; where they
//! are apart it is the strongest straight one ([`crate::analysis::strip`]), beside which the box holds all bands at once.

use serde::Serialize;

use super::Found;
use super::among::{Among, Group, Member, Who};
use crate::analysis::band::{Band, CANDIDATE_SHARE, Candidates};
use crate::analysis::curve::{mean, range};
use crate::analysis::run::Run;
use crate::analysis::snapshot::Body;
use crate::analysis::space::Spaces;
use crate::analysis::strained::{Span, Valued, boxed, free, increment, stripped, width_at_half};
use crate::base::error::Error;
use crate::base::math::PI;

/// Runs that end by this share less than an interval still reach its end.
pub const END_SLACK: f64 = 0.02;
/// Shares of the material that are candidates for a box: the 98th percentile, the 97th and the 99th.
const SHARES: [f64; 3] = [CANDIDATE_SHARE, 0.03, 0.01];
/// A hybrid's band with less of itself in the zone has no thickness.
const INSIDE_LEAST: f64 = 0.5;
/// Pieces of the interval that are measured by themselves.
const PIECES: usize = 3;

/// The box of appendix A; lengths in mean diameters.
#[derive(Clone, Debug, Serialize)]
pub struct Box {
    /// Its side across the band.
    pub thickness_d50: f64,
    /// Its side along the band.
    pub length_d50: f64,
    /// Degrees from the x axis to the band, in (-90, 90], to a tenth.
    pub slope_deg: f64,
}

/// A piece of the interval.
#[derive(Clone, Debug, Serialize)]
pub struct Piece {
    /// Of its two frames.
    pub between_strains: [f64; 2],
    /// None where there is no band, or where it is of the continuum.
    pub thickness_d50: Option<f64>,
    /// Degrees from the x axis to the band; none where there is no band.
    pub slope_deg: Option<f64>,
}

/// The band of a run, measured in several ways; lengths in mean diameters, or in cells where there are no grains.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The run.
    #[serde(flatten)]
    pub who: Who,
    /// Of the two frames.
    pub between_strains: [f64; 2],
    /// Of the box where sides are joined, else of the strongest strip; none without a band, or where it is of the continuum.
    pub thickness_d50: Option<f64>,
    /// The same in edges of cells of the grid; none of grains alone.
    pub thickness_cells: Option<f64>,
    /// With one body in the band: what the box around centres leaves out.
    pub thickness_cells_with_bodies: Option<f64>,
    /// Degrees from the x axis to the band, in (-90, 90], to a tenth.
    pub slope_deg: Option<f64>,
    /// Side along the band.
    pub length_d50: Option<f64>,
    /// Of the box or of the strip, m.
    pub centre_m: Option<[f64; 2]>,
    /// Height of the middle of the band above the specimen's lower edge, m.
    pub height_m: Option<f64>,
    /// Share of all strain that lies in it.
    pub share_of_strain: Option<f64>,
    /// Up to three, equal in strain as nearly as frames allow; empty where no frame lies between.
    pub pieces: Vec<Piece>,
    /// Width at half of the largest mean strain.
    pub width_at_half_d50: Option<f64>,
    /// The same in edges of cells; neither is told where sides are apart.
    pub width_at_half_cells: Option<f64>,
    /// Swelling of the band over the interval, and the solid volume fraction of its grains at the end.
    pub volume_strain: Option<f64>,
    /// Solid volume fraction of the band's grains at the end; none where sides are joined, as is the swelling.
    pub packing_fraction_end: Option<f64>,
    /// Around the most strained 2 % of the material, by area; none where the band is of the continuum.
    pub box_98th: Option<Box>,
    /// The same of the most strained 3 %.
    pub box_97th: Option<Box>,
    /// The same of the most strained 1 %.
    pub box_99th: Option<Box>,
    /// By the threshold of the same packing's grains alone, which is what the paper's words say.
    pub box_dem_threshold: Option<Box>,
    /// Share of it, by area, that is in a hybrid's zone.
    pub inside_zone: Option<f64>,
    /// Share of all shear over the interval, by area, that is in a hybrid's zone.
    pub shear_inside_zone: Option<f64>,
    /// Across which strain was measured.
    #[serde(skip)]
    pub span: Option<Span>,
    /// Of the later frame, with their strain since the earlier one.
    #[serde(skip)]
    pub bodies: Vec<Valued>,
    /// The box where sides are joined, else the strip; lengths in m.
    #[serde(skip)]
    pub band: Option<Band>,
    #[serde(skip)]
    threshold: Option<f64>,
    /// From the lowest to the highest edge of the bodies, m.
    #[serde(skip)]
    pub height: f64,
}

impl Measured {
    /// Whether a hybrid's band is for the most part where it has no grains: how thick it is there the cells say, and what stands still in
    /// the zone is no band.
    fn is_of_continuum(&self) -> bool {
        self.inside_zone.is_some_and(|share| share < INSIDE_LEAST)
    }

    fn forget_thickness(&mut self) {
        (self.thickness_d50, self.thickness_cells, self.thickness_cells_with_bodies) = (None, None, None);
        (self.width_at_half_d50, self.width_at_half_cells) = (None, None);
        (self.box_98th, self.box_97th, self.box_99th) = (None, None, None);
        self.pieces.iter_mut().for_each(|piece| piece.thickness_d50 = None);
    }

    /// Bodies in the box of the band.
    pub fn members(&self) -> Vec<Body> {
        let rows: Vec<&Valued> = free(&self.bodies).collect();
        self.band.iter().flat_map(|band| band.members.iter().map(|&row| rows[row].body)).collect()
    }

    fn of(member: &Member, span: &Span, between: [f64; 2]) -> Result<Option<Self>, Error> {
        let run = member.run;
        let [from, to] = between.map(|strain| run.frame_at(strain));
        let from = from.max(run.enriched.unwrap_or(0));
        if from >= to || run.last_frame() < between[1] * (1.0 - END_SLACK) {
            return Ok(None);
        }
        let bodies = increment(run, span, [from, to])?;
        let diameters = |length: f64| length / span.diameter;
        let cells = |length: f64| Some(length / run.cell_edge()?);
        let box_by = |wanted: Candidates| boxed(&bodies, span, wanted);
        let boxes = SHARES.map(|share| box_by(Candidates::Share(share)));
        let told = |band: &Option<Band>| band.as_ref().map(|band| Box::of(band, span));
        let strip = stripped(&bodies, span);
        let band = if span.is_periodic { boxes[0].clone() } else { strip.as_ref().map(|strip| strip.band.clone()) };
        let half = width_at_half(&bodies, span.diameter).filter(|_| span.is_periodic);
        let [bottom, top] =
            range(bodies.iter().flat_map(|row| [-1.0, 1.0].map(|side| row.body.position[1] + side * row.body.radius)))
                .unwrap_or_default();
        let mut measured = Self {
            who: member.who.clone(),
            between_strains: [from, to].map(|frame| run.at_frame(frame)),
            thickness_d50: band.as_ref().map(|band| diameters(band.thickness)),
            thickness_cells: band.as_ref().and_then(|band| cells(band.thickness)),
            thickness_cells_with_bodies: None,
            slope_deg: band.as_ref().map(slope),
            length_d50: band.as_ref().map(|band| diameters(band.length)),
            centre_m: band.as_ref().map(|band| band.centre),
            height_m: band.as_ref().map(|band| band.centre[1] - bottom),
            share_of_strain: strip.as_ref().map(|strip| strip.share),
            pieces: pieces(run, span, [from, to])?,
            width_at_half_d50: half.map(diameters),
            width_at_half_cells: half.and_then(cells),
            volume_strain: None,
            packing_fraction_end: None,
            box_98th: told(&boxes[0]),
            box_97th: told(&boxes[1]),
            box_99th: told(&boxes[2]),
            box_dem_threshold: None,
            inside_zone: None,
            shear_inside_zone: None,
            span: Some(*span),
            threshold: boxes[0].as_ref().map(|band| band.threshold),
            height: top - bottom,
            bodies,
            band,
        };
        let members = measured.members();
        let thickest = members.iter().map(Body::extent).reduce(f64::max);
        let with_bodies = |(band, body): (&Band, f64)| cells(band.thickness + body);
        measured.thickness_cells_with_bodies =
            measured.band.as_ref().zip(thickest).filter(|_| span.is_periodic).and_then(with_bodies);
        if run.is("hybrid") {
            measured.inside_zone = share_in_zone(members.iter().map(|body| (body, 1.0)));
            measured.shear_inside_zone = share_in_zone(free(&measured.bodies).map(|row| (&row.body, row.value)));
        }
        if measured.is_of_continuum() {
            measured.forget_thickness();
        }
        if !span.is_periodic && !members.is_empty() {
            let [first, last] = [run.snapshot(from)?, run.snapshot(to)?];
            let [before, after] = [&first, &last].map(|snapshot| Spaces::of(snapshot, span));
            measured.volume_strain = after.swelling(&before, &members);
            measured.packing_fraction_end = after.fraction(&members);
        }
        Ok(Some(measured))
    }
}

impl Box {
    fn of(band: &Band, span: &Span) -> Self {
        let [thickness_d50, length_d50] = [band.thickness, band.length].map(|length| length / span.diameter);
        Self { thickness_d50, length_d50, slope_deg: slope(band) }
    }
}

/// Degrees, to a tenth, which is more than is known.
fn slope(band: &Band) -> f64 {
    (10.0 * band.angle * 180.0 / PI).round() / 10.0
}

/// Share of numbers of bodies, by their area and weight, that is of a zone's: its grains, and the points that share their place with some.
fn share_in_zone<'a>(rows: impl Iterator<Item = (&'a Body, f64)>) -> Option<f64> {
    let [mut inside, mut all] = [0.0; 2];
    for (body, number) in rows.filter(|(_, number)| number.is_finite()) {
        let part = number * body.weight * body.radius * body.radius;
        all += part;
        if body.kind.is_grain() || body.weight < 1.0 {
            inside += part;
        }
    }
    (all > 0.0).then(|| inside / all)
}

/// Pieces of an interval of frames, equal in strain as nearly as there are frames; none of one that has no more than one piece.
fn pieces(run: &Run, span: &Span, [from, to]: [usize; 2]) -> Result<Vec<Piece>, Error> {
    let [first, last] = [from, to].map(|frame| run.at_frame(frame));
    let edge = |piece: usize| run.frame_at(first + piece as f64 / PIECES as f64 * (last - first));
    let mut edges: Vec<usize> = (0..=PIECES).map(edge).collect();
    edges.dedup();
    let piece = |pair: &[usize]| {
        let bodies = increment(run, span, [pair[0], pair[1]])?;
        let band = match span.is_periodic {
            true => boxed(&bodies, span, Candidates::Share(CANDIDATE_SHARE)),
            false => stripped(&bodies, span).map(|strip| strip.band),
        };
        Ok(Piece {
            between_strains: [pair[0], pair[1]].map(|frame| run.at_frame(frame)),
            thickness_d50: band.as_ref().map(|band| band.thickness / span.diameter),
            slope_deg: band.as_ref().map(slope),
        })
    };
    if edges.len() > 2 { edges.windows(2).map(piece).collect() } else { Ok(Vec::new()) }
}

/// Thicknesses of the packings of a group.
#[derive(Clone, Debug, Serialize)]
pub struct OfGroup {
    /// Its name.
    pub group: String,
    /// Those whose band has a thickness.
    pub packings: usize,
    /// Over the packings.
    pub mean_d50: f64,
    /// Of the thinnest band.
    pub least_d50: f64,
    /// Of the thickest band.
    pub most_d50: f64,
}

/// The bands of all runs, each measured between the same strains.
#[derive(Clone, Debug, Serialize)]
pub struct Bands {
    /// As asked for, or the paper's shares of the strain that all runs reach; not before the last enrichment.
    pub between_strains: [f64; 2],
    /// Groups with a band that has a thickness.
    pub groups: Vec<OfGroup>,
    /// Those that have two frames between these strains, in the order in which the runs were given.
    pub runs: Vec<Measured>,
}

impl Bands {
    /// By its place among the runs; none where it was not measured.
    pub fn of_run(&self, index: usize) -> Option<&Measured> {
        self.runs.iter().find(|measured| measured.who.index == index)
    }
}

/// The strains to measure between, or why there are none.
fn interval(among: &Among, wanted: Option<[f64; 2]>) -> Result<[f64; 2], String> {
    let drive = &among.members[0].run.drive;
    let [end, longest] = range(among.members.iter().map(|member| member.run.last_frame())).unwrap_or_default();
    let [from, to] = wanted.unwrap_or(drive.interval.map(|share| share * end.min(drive.interval_of_most)));
    let percent = |strain: f64| format!("{:.3}\u{2009}%", 100.0 * strain);
    if to > longest * (1.0 + END_SLACK) {
        return Err(format!("the longest run ends at {}, and {} was asked for", percent(longest), percent(to)));
    }
    let from = among.enriched().fold(from, f64::max);
    if from < to {
        Ok([from, to])
    } else if to <= 0.0 {
        Err("a run has no two frames at different strains".to_owned())
    } else {
        Err(format!("the last enrichment is at {}, the interval ends at {}", percent(from), percent(to)))
    }
}

/// Between strains that are wanted, or those of the drive; an error where a frame cannot be read.
pub fn measured(among: &Among, wanted: Option<[f64; 2]>) -> Result<Found<Option<Bands>>, Error> {
    if among.members.iter().any(|member| member.run.span.is_none()) {
        return Ok(Found::nothing("Bands are measured in the plane, and not in a cell of grains.".to_owned()));
    }
    let between = match interval(among, wanted) {
        Ok(between) => between,
        Err(why) => return Ok(Found::nothing(format!("Incremental strain and bands are left out: {why}."))),
    };
    let mut runs: Vec<Measured> = Vec::new();
    let mut left_out = Vec::new();
    for member in &among.members {
        let measured = member.run.span.map(|span| Measured::of(member, &span, between)).transpose()?.flatten();
        match measured {
            Some(measured) => {
                if let Some(share) = measured.inside_zone.filter(|_| measured.is_of_continuum()) {
                    left_out.push(format!(
                        "No thickness of the band of {}: {:.0}\u{2009}% of it is outside of the zone, in a continuum that has no length of its own.",
                        member.who.run,
                        100.0 * (1.0 - share)
                    ));
                }
                runs.push(measured);
            }
            None => left_out.push(format!(
                "No band of {}: it has no two frames between these strains, or ends before.",
                member.who.run
            )),
        }
    }
    for row in 0..runs.len() {
        let member = &among.members[runs[row].who.index];
        let partner = among.stand_in(member).filter(|_| !member.is("dem"));
        let alone = partner.filter(|_| !runs[row].is_of_continuum());
        let alone = alone.and_then(|partner| runs.iter().find(|other| other.who.index == partner.index()));
        if let Some((threshold, span)) = alone.and_then(|alone| alone.threshold).zip(runs[row].span) {
            let band = boxed(&runs[row].bodies, &span, Candidates::Beyond(threshold));
            runs[row].box_dem_threshold = band.map(|band| Box::of(&band, &span));
        }
    }
    let of_group = |group: &Group| {
        let own = runs.iter().filter(|measured| group.members.contains(&measured.who.index));
        let own: Vec<f64> = own.filter_map(|measured| measured.thickness_d50).collect();
        let [least_d50, most_d50] = range(own.iter().copied())?;
        Some(OfGroup { group: group.name.clone(), packings: own.len(), mean_d50: mean(&own), least_d50, most_d50 })
    };
    let groups = among.groups.iter().filter_map(of_group).collect();
    Ok(Found::of(Some(Bands { between_strains: between, groups, runs }), left_out))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::snapshot::Kind;

    /// A zone that stands still while the continuum shears around it is no band of 9.7 D50.
    #[test]
    fn what_shears_outside_of_the_zone_is_told_from_what_shears_in_it() {
        let body = |kind: Kind, weight: f64, radius: f64| Body { kind, weight, radius, ..Body::default() };
        let [grain, rim, shared, point] = [
            body(Kind::Grain, 1.0, 1.0),
            body(Kind::Grain, 0.5, 1.0),
            body(Kind::Point, 0.5, 3.0),
            body(Kind::Point, 1.0, 3.0),
        ];
        let share = |rows: &[(&Body, f64)]| share_in_zone(rows.iter().copied());
        // (0.1 + 0.5 0.1 + 4.5 0.1)/(the same + 9 0.3)
        let found = share(&[(&grain, 0.1), (&rim, 0.1), (&shared, 0.1), (&point, 0.3), (&point, f64::NAN)]).unwrap();
        assert!((found - 0.6 / 3.3).abs() < 1e-12, "{found}");
        assert_eq!(share(&[(&grain, 0.0), (&point, 0.3)]), Some(0.0));
        assert_eq!(share(&[]), None);
    }
}
