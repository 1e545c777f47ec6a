//! The moments of a run that are drawn, with the strain of every body.

use super::load::{Body, Kind, Run, Snapshot};
use super::span::Span;
use crate::analysis::band::{self, Band, CANDIDATE_SHARE, Candidates, Strained};
use crate::base::error::Error;
use crate::base::math;
use crate::observe::strain::best_fit_strains;

/// Neighbours farther apart than this many mean diameters do not share a strain of grains.
pub const EDGE_MAX_DIAMETERS: f64 = 2.5;
/// The same for points, in edges of the square of a point's area.
const EDGE_MAX_POINTS: f64 = 3.0;

/// A body with the number that colours it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valued {
    pub body: Body,
    /// Of a scene |e_d|, counted as the scene says; not a number where nothing is known.
    pub value: f64,
}

/// What the strain of a scene counts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Since {
    /// Each body's origin: the start of the run for points, the packing for grains.
    Origin,
    /// A frame at this horizontal strain.
    Frame(f64),
}

/// One drawn moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub title: &'static str,
    /// Horizontal strain of the specimen.
    pub strain: f64,
    pub since: Since,
    pub bodies: Vec<Valued>,
}

impl Scene {
    pub fn heights(&self) -> [f64; 2] {
        heights(&self.bodies)
    }
}

/// The bodies that a band is made of: all but the plates.
pub fn free(bodies: &[Valued]) -> impl Iterator<Item = &Valued> {
    bodies.iter().filter(|row| row.body.kind != Kind::Glued)
}

/// Lowest and highest edge of the bodies, m.
pub fn heights(bodies: &[Valued]) -> [f64; 2] {
    bodies.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lower, upper], Valued { body, .. }| {
        [lower.min(body.position[1] - body.radius), upper.max(body.position[1] + body.radius)]
    })
}

/// The drawn moments of a run and the band measured in the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenes {
    pub scenes: Vec<Scene>,
    pub band: Option<Band>,
    /// Share of the band's members between the lowest and the highest free grain of a hybrid run.
    pub inside: Option<f64>,
    /// Lowest and highest edge of any body over all scenes, m.
    pub heights: [f64; 2],
}

impl Scenes {
    pub fn of(run: &Run, timing: &Timing, enriched: Option<usize>) -> Result<Self, Error> {
        let mut scenes = Vec::new();
        for Moment { frame, title, since } in moments(run, timing, enriched) {
            let snapshot = run.snapshot(frame)?;
            let earlier = since.map(|frame| run.snapshot(frame)).transpose()?;
            scenes.push(Scene {
                title,
                strain: run.series.strain_at(snapshot.time),
                since: earlier
                    .as_ref()
                    .map_or(Since::Origin, |earlier| Since::Frame(run.series.strain_at(earlier.time))),
                bodies: strained(&snapshot, earlier.as_ref(), &run.span()),
            });
        }
        let heights = scenes.iter().map(Scene::heights);
        let heights = heights.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0.0, 1.0]);
        let last = scenes.last().filter(|scene| scene.since != Since::Origin);
        let band = last.and_then(|scene| measured(&scene.bodies, run.width, Candidates::Share(CANDIDATE_SHARE)));
        let inside =
            last.zip(band.as_ref()).filter(|_| run.method == "hybrid").and_then(|(scene, band)| inside(scene, band));
        Ok(Self { scenes, band, inside, heights })
    }
}

/// Which scenes of several runs belong together: those at equal horizontal strains.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// Of the first scene, for runs without an enrichment of their own.
    first: f64,
    /// Of the second, for the same runs.
    second: f64,
    /// That the strain of the last scene counts from: after every enrichment.
    reference: f64,
    /// Of the last scene: reached by all runs.
    end: f64,
    /// There is an enrichment to compare with.
    compared: bool,
}

impl Timing {
    /// For runs with their first enriched frames.
    pub fn of(runs: &[(&Run, Option<usize>)]) -> Self {
        let end = runs.iter().map(|(run, _)| run.strain_of(run.frame_times.len() - 1)).fold(f64::INFINITY, f64::min);
        let around = |run: &Run, frame: usize| (run.strain_of(frame - 1), run.strain_of(frame));
        let enriched = runs.iter().filter_map(|&(run, frame)| frame.map(|frame| around(run, frame)));
        let compared = enriched.clone().next();
        let (first, second) = compared.unwrap_or((0.0, 0.5 * end));
        let reference = enriched.map(|(_, after)| after).fold(second, f64::max);
        Self { first, second, reference, end, compared: compared.is_some() }
    }
}

/// A frame to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Moment {
    frame: usize,
    title: &'static str,
    /// The frame that strain counts from; none: each body's origin.
    since: Option<usize>,
}

/// The frames to draw: before and after enrichment and the last; without enrichment start, middle and end, or the
/// strains that a run to compare with has its scenes at.
fn moments(run: &Run, timing: &Timing, enriched: Option<usize>) -> Vec<Moment> {
    let (first, second, titles) = match enriched {
        Some(after) => (after - 1, after, ["before enrichment", "just after enrichment"]),
        None if timing.compared => (run.frame_at(timing.first), run.frame_at(timing.second), ["before", "after"]),
        None => (run.frame_at(timing.first), run.frame_at(timing.second), ["start", "middle"]),
    };
    let last = run.frame_at(timing.end);
    let since = run.frame_at(timing.reference).max(second);
    let mut moments = vec![Moment { frame: first, title: titles[0], since: None }];
    if second > first && (second < last || enriched.is_some()) {
        moments.push(Moment { frame: second, title: titles[1], since: None });
    }
    if last > since {
        moments.push(Moment { frame: last, title: "end", since: Some(since) });
    } else if last > moments[moments.len() - 1].frame {
        moments.push(Moment { frame: last, title: "end", since: Some(first) });
    }
    moments
}

/// The first frame with free grains of a hybrid run, if there is one before it; once there, they stay.
pub fn enriched_frame(run: &Run) -> Result<Option<usize>, Error> {
    if run.method != "hybrid" {
        return Ok(None);
    }
    first_with_grains(run.frame_times.len(), |frame| run.snapshot(frame))
}

/// The first of so many frames with free grains, if there is one before it without.
pub fn first_with_grains(
    frames: usize,
    snapshot: impl Fn(usize) -> Result<Snapshot, Error>,
) -> Result<Option<usize>, Error> {
    let (mut from, mut to) = (0, frames);
    while from < to {
        let middle = from + (to - from) / 2;
        if snapshot(middle)?.bodies.iter().any(|body| body.kind == Kind::Grain) {
            to = middle;
        } else {
            from = middle + 1;
        }
    }
    Ok((from > 0 && from < frames).then_some(from))
}

/// Strain of every body since its origin, or since it was in `earlier`; bodies that are not there have none.
///
/// Points and grains are fitted apart: in the rim, where both live, they share their motion only on the average.
pub fn strained(snapshot: &Snapshot, earlier: Option<&Snapshot>, span: &Span) -> Vec<Valued> {
    let mut result: Vec<Valued> = snapshot.bodies.iter().map(|&body| Valued { body, value: f64::NAN }).collect();
    for grains in [false, true] {
        let mut rows = Vec::new();
        let mut positions = Vec::new();
        let mut displacements = Vec::new();
        for (row, body) in snapshot.bodies.iter().enumerate().filter(|(_, body)| body.kind.is_grain() == grains) {
            let origin = match earlier {
                None => [0.0; 2],
                Some(earlier) => match find(earlier, body) {
                    Some(before) => before.displacement,
                    None => continue,
                },
            };
            rows.push(row);
            positions.push(body.position);
            displacements.push([body.displacement[0] - origin[0], body.displacement[1] - origin[1]]);
        }
        let edge_max = if grains {
            EDGE_MAX_DIAMETERS * span.diameter
        } else {
            let radius_max = rows.iter().map(|&row| snapshot.bodies[row].radius).fold(0.0, f64::max);
            EDGE_MAX_POINTS * square_edge(radius_max)
        };
        let values = best_fit_strains(&positions, &displacements, span.period(), edge_max);
        for (row, value) in rows.into_iter().zip(values) {
            result[row].value = value;
        }
    }
    result
}

/// Edge of the square that has the area of a disc.
pub fn square_edge(radius: f64) -> f64 {
    radius * math::PI.sqrt()
}

fn find<'a>(snapshot: &'a Snapshot, body: &Body) -> Option<&'a Body> {
    let key = (body.kind.is_grain(), body.id);
    let found = snapshot.bodies.binary_search_by_key(&key, |body| (body.kind.is_grain(), body.id));
    found.ok().map(|row| &snapshot.bodies[row])
}

/// The band of strained bodies, plates left out.
pub fn measured(bodies: &[Valued], period: f64, wanted: Candidates) -> Option<Band> {
    let positions: Vec<[f64; 2]> = free(bodies).map(|row| row.body.position).collect();
    let strains: Vec<f64> = free(bodies).map(|row| row.value).collect();
    let areas: Vec<f64> = free(bodies).map(|row| row.body.area()).collect();
    band::measure_by(&Strained { positions: &positions, strains: &strains, areas: &areas, period }, wanted)
}

/// Share of the band's members between the lowest and the highest free grain.
fn inside(scene: &Scene, band: &Band) -> Option<f64> {
    let grains = scene.bodies.iter().filter(|row| row.body.kind == Kind::Grain).map(|row| row.body.position[1]);
    let (lower, upper) =
        grains.fold((f64::INFINITY, f64::NEG_INFINITY), |(lower, upper), y| (lower.min(y), upper.max(y)));
    let heights: Vec<f64> = free(&scene.bodies).map(|row| row.body.position[1]).collect();
    let within = band.members.iter().filter(|&&row| (lower..=upper).contains(&heights[row])).count();
    (lower <= upper).then(|| within as f64 / band.members.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::super::findings::tests::hybrid;
    use super::*;

    /// A run with a frame at every percent of strain up to ten.
    fn run() -> Run {
        let mut run = hybrid(50.0);
        run.frame_times = (0..=10).map(|frame| f64::from(frame) * 0.1).collect();
        run
    }

    fn frames(moments: &[Moment]) -> Vec<(usize, Option<usize>)> {
        moments.iter().map(|moment| (moment.frame, moment.since)).collect()
    }

    #[test]
    fn an_enriched_run_shows_before_after_and_end() {
        let run = run();
        let timing = Timing::of(&[(&run, Some(5))]);
        assert_eq!(frames(&moments(&run, &timing, Some(5))), [(4, None), (5, None), (10, Some(5))]);
    }

    #[test]
    fn a_run_without_enrichment_shows_start_middle_and_end() {
        let run = run();
        let timing = Timing::of(&[(&run, None)]);
        assert_eq!(frames(&moments(&run, &timing, None)), [(0, None), (5, None), (10, Some(5))]);
    }

    #[test]
    fn compared_runs_are_shown_at_equal_strains() {
        let (run, mut short) = (run(), run());
        short.frame_times.truncate(9);
        let timing = Timing::of(&[(&run, Some(3)), (&run, Some(6)), (&short, None)]);
        assert_eq!(frames(&moments(&run, &timing, Some(3))), [(2, None), (3, None), (8, Some(6))]);
        assert_eq!(frames(&moments(&run, &timing, Some(6))), [(5, None), (6, None), (8, Some(6))]);
        assert_eq!(frames(&moments(&short, &timing, None)), [(2, None), (3, None), (8, Some(6))]);
    }

    #[test]
    fn few_frames_still_make_scenes() {
        let mut run = run();
        run.frame_times.truncate(1);
        let timing = Timing::of(&[(&run, None)]);
        assert_eq!(frames(&moments(&run, &timing, None)), [(0, None)]);
        run.frame_times.push(0.1);
        let timing = Timing::of(&[(&run, None)]);
        assert_eq!(frames(&moments(&run, &timing, None)), [(0, None), (1, Some(0))]);
        let timing = Timing::of(&[(&run, Some(1))]);
        assert_eq!(frames(&moments(&run, &timing, Some(1))), [(0, None), (1, None)]);
    }
}
