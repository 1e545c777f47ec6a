//! The moments of runs that are drawn: before and after an enrichment and the end, or start, middle and end, of several runs at equal
//! strains; coloured by strain since the start and by mean stress.

use super::Drawn;
use super::numbers::{exponent, percent, plain, power_of_ten, round_up, time};
use super::pictures::{Colours, Picture, draw, nearly_all, strain_end};
use crate::analysis::drive::Measure;
use crate::analysis::run::Run;
use crate::analysis::snapshot::{Body, Snapshot};
use crate::analysis::strained::{Valued, strained};
use crate::base::error::Error;
use crate::base::math;
use crate::base::space::AXES;
use crate::job::Job;

/// Below this share of the compression, tension is left to the lower end of the colours.
const TENSION_SHARE_MIN: f64 = 0.05;

/// Places of the scenes of runs that have no enrichment of their own, and of the last scene of all.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Timing {
    first: f64,
    second: f64,
    end: f64,
    /// There is an enrichment to compare with.
    is_compared: bool,
}

impl Timing {
    fn of(runs: &[&Run]) -> Self {
        let end = runs.iter().map(|run| run.last_frame()).fold(f64::INFINITY, f64::min);
        let enriched = runs.iter().find_map(|run| Some((run, run.enriched?)));
        let around = |(run, frame): (&&Run, usize)| (run.at_frame(frame - 1), run.at_frame(frame));
        let (first, second) = enriched.map_or((0.0, 0.5 * end), around);
        Self { first, second, end, is_compared: enriched.is_some() }
    }
}

/// Frames to draw, with titles.
fn moments(run: &Run, timing: Timing) -> Vec<(usize, &'static str)> {
    let (first, second, titles) = match run.enriched {
        Some(after) => (after - 1, after, ["before enrichment", "just after enrichment"]),
        None => {
            let titles = if timing.is_compared { ["before", "after"] } else { ["start", "middle"] };
            (run.frame_at(timing.first), run.frame_at(timing.second), titles)
        }
    };
    let last = run.frame_at(timing.end);
    let mut moments = vec![(first, titles[0])];
    if second > first && (second < last || run.enriched.is_some()) {
        moments.push((second, titles[1]));
    }
    if last > moments[moments.len() - 1].0 {
        moments.push((last, "end"));
    }
    moments
}

/// How far a run is at a frame, in words.
pub fn place(run: &Run, frame: usize) -> String {
    let at = run.at_frame(frame);
    match run.drive.measure {
        _ if run.drive.turns_back => time(at),
        Measure::Strain => format!("strain {}", percent(at)),
        Measure::Length => format!("{}\u{2009}mm", plain(1e3 * at, 3)),
        Measure::Time => time(at),
    }
}

/// What bodies of a run have of strain since they began.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Strain {
    /// Fitted to the motion of neighbours.
    Fitted,
    Plastic,
    Deviatoric,
}

impl Strain {
    fn of(run: &Run) -> Self {
        match (run.span, run.has_grains()) {
            (_, false) if run.has_rves() => Self::Deviatoric,
            (_, false) => Self::Plastic,
            (Some(_), true) => Self::Fitted,
            (None, true) => Self::Deviatoric,
        }
    }

    fn coloured(self, run: &Run, snapshot: &Snapshot) -> Vec<Valued> {
        let by = |value: fn(&Body) -> f64| {
            snapshot.bodies.iter().map(|&body| Valued { body, value: value(&body) }).collect()
        };
        match (self, run.span) {
            (Self::Fitted, Some(span)) => strained(snapshot, None, &span),
            (Self::Plastic, _) => by(|body| body.plastic),
            _ => by(|body| body.deviatoric),
        }
    }

    /// Name of the drawing, words of the colours, and of the caption.
    fn words(self) -> [&'static str; 3] {
        match self {
            Self::Plastic => ["plastic_strain", "plastic strain", "plastic strain"],
            Self::Fitted => [
                "specimen",
                "strain since the start, |e\u{2032}|",
                "the magnitude |e\u{2032}| = \u{221a}(e\u{2032}:e\u{2032}) of the deviatoric part of the best-fit strain since each \
                 body began, over Delaunay neighbours (simple shear by \u{3b3} has \u{3b3}/\u{221a}2), points and grains fitted apart",
            ],
            Self::Deviatoric => [
                "deviatoric_strain",
                "deviatoric strain",
                "deviatoric strain since the start, of a grain that of its neighbours",
            ],
        }
    }
}

/// What else is drawn of points that carry grains (Liang & Zhao 2019, figures 9, 14, 15 and 22).
struct Shade {
    name: &'static str,
    words: &'static str,
    /// In the caption.
    told: &'static str,
    unit: f64,
    value: fn(&Body) -> f64,
    /// Colours go from zero, to as far on either side of it where values do, or as values do.
    ends: fn([f64; 2]) -> [f64; 2],
}

const OF_RVES: [Shade; 3] = [
    Shade {
        name: "displacement",
        words: "displacement (m)",
        told: "displacement since the start",
        unit: 1.0,
        value: |body| body.moved,
        ends: |[_, most]| [0.0, round_end(most)],
    },
    Shade {
        name: "void_ratio",
        words: "void ratio",
        told: "void ratio of the RVE",
        unit: 1.0,
        value: |body| body.void_ratio,
        ends: |[least, most]| [least, most.max(least + 1e-3)],
    },
    Shade {
        name: "rotation",
        words: "rotation (degrees)",
        told: "rotation of F = R U since the start, in the plane positive counterclockwise",
        unit: math::PI / 180.0,
        value: |body| body.rotation,
        ends: |[least, most]| {
            let most = math::PI / 180.0 * round_end(most.max(-least) * 180.0 / math::PI);
            [if least < 0.0 { -most } else { 0.0 }, most]
        },
    },
];

/// The pictures of runs that stand against the same.
pub fn figures(runs: &[&Run], number: &str) -> Result<Vec<Drawn>, Error> {
    let timing = Timing::of(runs);
    let (mut by_strain, mut by_stress) = (Vec::new(), Vec::new());
    let shades = OF_RVES.iter().filter(|_| runs.iter().all(|run| run.has_rves()));
    let mut shaded: Vec<(&Shade, Vec<Picture>)> = shades.map(|shade| (shade, Vec::new())).collect();
    let strain = Strain::of(runs[0]);
    let mut columns = 2;
    for run in runs {
        let moments = moments(run, timing);
        columns = columns.max(moments.len());
        for (column, (frame, title)) in moments.into_iter().enumerate() {
            let snapshot = run.snapshot(frame)?;
            let titles = [format!("({}) {title}", ["a", "b", "c"][column.min(2)]), place(run, frame)];
            let head = if runs.len() > 1 && column == 0 { run.label() } else { String::new() };
            let stressed = snapshot.bodies.iter().map(|&body| Valued { body, value: body.pressure }).collect();
            let shades = shaded.iter_mut().map(|(shade, pictures)| {
                let valued = |&body: &Body| Valued { body, value: (shade.value)(&body) };
                (pictures, snapshot.bodies.iter().map(valued).collect())
            });
            let both = [(&mut by_strain, strain.coloured(run, &snapshot)), (&mut by_stress, stressed)];
            for (pictures, bodies) in both.into_iter().chain(shades) {
                let picture = Picture::of(run, &snapshot, bodies, titles.clone());
                pictures.push(Picture { head: head.clone(), ..picture });
            }
        }
    }
    let mut figures = Vec::new();
    let mut add = |name: &str, pictures: &[Picture], colours: &Colours, caption: String| {
        let name = format!("{name}{number}");
        let description = format!("The specimen, coloured by {}", colours.words);
        let drawing = draw(&name, pictures, Some(columns), colours, &description);
        figures.push(Drawn { name, drawing, caption });
    };
    let largest = nearly_all(by_strain.iter().flat_map(|picture| &picture.bodies).filter(|row| row.value > 0.0))[1];
    if largest > 0.0 {
        let [name, words, told] = strain.words();
        let colours = Colours { ends: [0.0, strain_end(&by_strain).max(round_up(largest))], unit: 1.0, words };
        add(name, &by_strain, &colours, format!("{} Colour: {told}.", shown(runs)));
    }
    let [least, most] = nearly_all(by_stress.iter().flat_map(|picture| &picture.bodies));
    if most > 0.0 || least < 0.0 {
        let is_tensile = least < -TENSION_SHARE_MIN * most.abs();
        let end = round_end(most.max(if is_tensile { -least } else { 0.0 }));
        let ends = [if is_tensile { -end } else { 0.0 }, end];
        let colours = Colours { ends, unit: 1e3, words: "mean stress, compression positive (kPa)" };
        add("mean_stress", &by_stress, &colours, stress_caption(runs));
    }
    for (Shade { name, words, told, unit, ends, .. }, pictures) in &shaded {
        // At the start nothing has moved, and voids are as they were made.
        let bodies = || pictures.iter().flat_map(|picture| &picture.bodies);
        if bodies().any(|row| row.value != 0.0) {
            let colours = Colours { ends: ends(nearly_all(bodies())), unit: *unit, words };
            add(name, pictures, &colours, format!("{} Colour: {told}.", shown(runs)));
        }
    }
    Ok(figures)
}

/// A round value at or above a positive one; of none, one.
fn round_end(value: f64) -> f64 {
    if value <= 0.0 {
        return 1.0;
    }
    let decade = power_of_ten(exponent(value));
    decade * round_up(value / decade)
}

fn shown(runs: &[&Run]) -> String {
    let mut words =
        "The material at the moments given, grains in their true size, points as squares of their size".to_owned();
    if let Some(run) = runs.iter().find(|run| run.dimension() == 3) {
        words += &format!(", seen along {}", AXES[3 - run.up()]);
    }
    if runs.iter().any(|run| run.period() > 0.0) {
        words += ", periodic in the horizontal direction";
    }
    if runs.iter().any(|run| run.enriched.is_some()) {
        words += "; in the outlined rim grains and points share the mass";
    }
    if runs.iter().any(|run| run.period() == 0.0) {
        words += ". Dashed: the grid or the cell; grey: bodies, what is glued to them, and vertices of membranes";
    }
    words + "."
}

fn stress_caption(runs: &[&Run]) -> String {
    let mut words = format!(
        "{} Colour: mean stress, of plane strain the mean in the plane, of a grain that of its contacts over its share of space.",
        shown(runs)
    );
    // As the job says; one of a former program may not be read any more.
    let is_noisy = |run: &&Run| {
        let job = Job::parse(&run.scenario_text, "scenario.toml", &[]).ok();
        job.and_then(|job| Some(job.continuum()?.has_noisy_stresses())).unwrap_or(false)
    };
    if runs.iter().any(is_noisy) {
        words += " With several points in a cell the stresses of single points under gravity, those that are followed too, are noise \
                  about the mean of their cell: leave scheme.volume_averaging at true, which ends it.";
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run with a frame at every percent of strain up to ten, or fewer.
    fn run(frames: usize, enriched: Option<usize>) -> Run {
        let mut run = Run::made("method = \"hybrid\"");
        run.columns = vec![crate::analysis::columns::Column { name: "time".into(), values: vec![0.0, 1.0] }];
        run.drive.values = vec![0.0, 0.1];
        run.frame_times = (0..frames).map(|frame| frame as f64 * 0.1).collect();
        Run { enriched, ..run }
    }

    fn frames(run: &Run, timing: Timing) -> Vec<usize> {
        moments(run, timing).into_iter().map(|(frame, _)| frame).collect()
    }

    #[test]
    fn runs_show_before_after_and_end_or_start_middle_and_end() {
        let of = |run: Run| frames(&run, Timing::of(&[&run]));
        assert_eq!(of(run(11, Some(5))), [4, 5, 10]);
        assert_eq!(of(run(11, None)), [0, 5, 10]);
        assert_eq!((of(run(1, None)), of(run(2, None)), of(run(2, Some(1)))), (vec![0], vec![0, 1], vec![0, 1]));
    }

    #[test]
    fn several_runs_are_shown_at_equal_strains() {
        let (early, late, short) = (run(11, Some(3)), run(11, Some(6)), run(9, None));
        let timing = Timing::of(&[&early, &late, &short]);
        assert_eq!(frames(&early, timing), [2, 3, 8]);
        assert_eq!(frames(&late, timing), [5, 6, 8]);
        assert_eq!(frames(&short, timing), [2, 3, 8]);
    }
}
