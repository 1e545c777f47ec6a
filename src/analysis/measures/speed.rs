//! How much faster a hybrid is than grains alone: measured, and by the formula of Chen et al. (2021), 6.4.1, with costs of our
//! own:
//!
//! ```text
//! 1 / (T_D/T + (1 - T_D/T) C_C/(C_D N_D))
//! ```
//!
//! C_D: seconds of a core for a grain in a step of the run of grains alone. C_C: seconds of a core for an element over the time
//! of that step, of a run of the continuum alone with the same cells, or else of the hybrid's own phases of points and nodes; the
//! continuum is advanced once in `time.grain_steps` steps of the hybrid. N_D: grains in an element. T_D/T: the hybrid's grains
//! over those of the grains alone, rim and all. Times are those of steps, without output and without training.

use serde::Serialize;
use serde_json::Value;

use super::Found;
use super::among::{Among, Member, Who};
use crate::analysis::curve::range;
use crate::analysis::run::Run;
use crate::analysis::snapshot::Kind;
use crate::base::error::Error;
use crate::job::derived::speed_up_by;

/// Phases of the continuum's own work.
const CONTINUUM: [&str; 3] = ["scatter", "nodes", "gather"];
/// A summary whose wall time is that of so much less than the whole run is one of a resumed run.
const WHOLE: f64 = 0.999;

/// What a summary says of time.
struct Times {
    /// Wall time of the loop since the run's start or resumption, s, and the steps in it.
    wall: f64,
    steps: f64,
    /// Steps of the whole run.
    steps_all: f64,
    /// Simulated time of a step, s.
    step: f64,
    /// Steps in one of the continuum.
    together: f64,
    /// Of the wall time what was spent on output, s.
    output: f64,
    /// Ranks, and threads of each.
    cores: [f64; 2],
    turn: Option<Pause>,
}

/// Where within a stretch grains and points come to be both there: an enrichment, or the first points of what began as grains.
struct Pause {
    /// Simulated time, s.
    at: f64,
    /// Seconds of the steps of the stretch before it, and of the training where there is one.
    before: f64,
    training: f64,
}

impl Times {
    fn of(run: &Run) -> Option<Self> {
        let number = |key: &str| run.told(key);
        let wall = number("wall_seconds")?;
        let steps = (1e6 * wall / number("microseconds_per_step")?).round();
        let (steps_all, step) = (number("steps")?, run.number("time.step")?);
        // The summary of a run that was resumed still has the figures of what came before.
        let begin = (steps_all - steps) * step;
        let at = run.has_both_from().filter(|at| *at > begin);
        let pause = |at: f64| match run.begins_as_grains() {
            true => Some(Pause { at, before: number("seconds_of_steps_before_points")?, training: 0.0 }),
            false => {
                let (before, training) = (number("seconds_of_steps_before_enrichment")?, number("training_seconds")?);
                Some(Pause { at, before, training })
            }
        };
        Some(Self {
            wall,
            steps,
            steps_all,
            step,
            together: run.number("time.grain_steps").unwrap_or(1.0),
            output: phase(run, "output"),
            cores: [number("ranks")?, number("threads").unwrap_or(1.0)],
            turn: at.and_then(pause),
        })
        .filter(|times| times.wall > 0.0 && times.steps > 0.0)
    }

    fn is_whole(&self) -> bool {
        self.steps >= WHOLE * self.steps_all
    }

    /// Seconds of steps, without output and training.
    fn seconds(&self) -> f64 {
        self.wall - self.output - self.turn.as_ref().map_or(0.0, |pause| pause.training)
    }

    /// The same for a simulated second.
    fn pace(&self) -> f64 {
        self.seconds() / (self.steps * self.step)
    }

    /// Ranks and threads as one number.
    fn all_cores(&self) -> f64 {
        self.cores[0] * self.cores[1]
    }

    /// Steps of the continuum.
    fn advances(&self) -> f64 {
        self.steps / self.together
    }

    fn told(&self) -> String {
        let [ranks, threads] = self.cores;
        format!("{ranks} \u{d7} {threads}")
    }
}

/// Mean over ranks of the time in a phase, s.
fn phase(run: &Run, name: &str) -> f64 {
    let phases = run.summary.get("phases").and_then(|phases| phases.get(name));
    phases.and_then(|phase| phase.get("mean")).and_then(Value::as_f64).unwrap_or(0.0)
}

/// Speed-ups of a hybrid over grains alone.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// The hybrid.
    #[serde(flatten)]
    pub who: Who,
    /// Label of the run of grains alone.
    pub against: String,
    /// Ranks and threads of both.
    pub ranks_x_threads: [String; 2],
    /// Wall time for wall time, with output and training; none where one of the two was resumed.
    pub whole_run: Option<f64>,
    /// Steps with grains and points, after enrichment or once the first points of what began as grains are there; none where they are not told apart.
    pub after_enrichment: Option<f64>,
    /// Share of coupling in the hybrid's time of steps.
    pub coupling_share: f64,
    /// None where the runs do not tell all of its arguments.
    pub formula: Option<Formula>,
}

/// The formula's arguments and its result: C_D, C_C and what tells it, N_D, T_D/T.
#[derive(Clone, Debug, Serialize)]
pub struct Formula {
    /// C_D, s.
    pub c_d_s: f64,
    /// C_C, s.
    pub c_c_s: f64,
    /// Label of the run of the continuum alone, or that they are the hybrid's own phases.
    pub c_c_from: String,
    /// N_D.
    pub n_d: f64,
    /// T_D/T.
    pub zone_share: f64,
    /// What the formula gives.
    pub speed_up: f64,
}

/// Seconds of steps with grains and points for a simulated second.
fn pace_after(hybrid: &Run, times: &Times) -> Option<f64> {
    let Some(pause) = &times.turn else {
        // All of the stretch lies after it, unless the summary does not say how long it took.
        let is_earlier = hybrid.has_both_from()? <= (times.steps_all - times.steps) * times.step;
        return is_earlier.then(|| times.pace());
    };
    let simulated = times.steps_all * times.step - pause.at;
    let seconds = times.seconds() - pause.before;
    (simulated > 0.0 && seconds > 0.0).then(|| seconds / simulated)
}

/// The run of the continuum alone that tells what a hybrid's elements cost.
fn continuum_alone<'a, 'm>(among: &'m Among<'a>, hybrid: &Member) -> Option<&'m Member<'a>> {
    let is_alike =
        |member: &&Member| member.run.cell_edge() == hybrid.run.cell_edge() && Times::of(member.run).is_some();
    let alone: Vec<&Member> = among.of_method(hybrid.case, "mpm").filter(is_alike).collect();
    alone.iter().find(|member| member.who.seed == hybrid.who.seed).or(alone.first()).copied()
}

/// Seconds of a core for an element to be advanced once, and what tells it.
fn element_cost(among: &Among, hybrid: &Member) -> Option<(f64, String)> {
    let own = hybrid.run;
    let per_side = own.number("scheme.points_per_cell")?;
    let (seconds, point_steps, from) = match continuum_alone(among, hybrid) {
        Some(alone) => {
            let times = Times::of(alone.run)?;
            let points = alone.run.told("points")?;
            (times.seconds() * times.all_cores(), points * times.advances(), alone.who.run.clone())
        }
        None => {
            let times = Times::of(own)?;
            let seconds: f64 = CONTINUUM.iter().map(|name| phase(own, name)).sum();
            let point_steps = own.told("point_steps_per_second")? * times.wall;
            (seconds * times.all_cores(), point_steps, "its own phases of points and nodes".to_owned())
        }
    };
    let seconds = seconds * per_side * per_side / point_steps;
    (seconds.is_finite() && seconds > 0.0).then_some((seconds, from))
}

/// Free grains of a frame, and the area of the space that they fill, m2.
fn grains(run: &Run, frame: usize) -> Result<Option<(f64, f64)>, Error> {
    let snapshot = run.snapshot(frame)?;
    let free = || snapshot.bodies.iter().filter(|body| body.kind == Kind::Grain);
    let extent = |axis: usize| {
        let edges = free().flat_map(|body| [-1.0, 1.0].map(|side| body.position[axis] + side * body.radius));
        range(edges).map(|[lower, upper]| upper - lower)
    };
    let width = if run.period() > 0.0 { Some(run.period()) } else { extent(0) };
    Ok(width.zip(extent(1)).map(|(width, height)| (free().count() as f64, width * height)))
}

fn formula(among: &Among, hybrid: &Member, partner: &Member) -> Result<Option<Formula>, Error> {
    let (Some(frame), Some(own), Some(times)) = (hybrid.run.enriched, Times::of(hybrid.run), Times::of(partner.run))
    else {
        return Ok(None);
    };
    let (Some((inserted, _)), Some((all, area))) = (grains(hybrid.run, frame)?, grains(partner.run, 0)?) else {
        return Ok(None);
    };
    let grain_steps = partner.run.told("grain_steps_per_second").map(|rate| rate * times.wall);
    let grain = grain_steps.filter(|steps| *steps > 0.0).map(|steps| times.seconds() * times.all_cores() / steps);
    let (Some(c_d_s), Some((once, c_c_from)), Some(cell)) =
        (grain, element_cost(among, hybrid), hybrid.run.cell_edge())
    else {
        return Ok(None);
    };
    let c_c_s = once * times.step / (own.together * own.step);
    let (n_d, zone_share) = (all * cell * cell / area, inserted / all);
    let speed_up = speed_up_by(zone_share, c_c_s, c_d_s * n_d);
    Ok(speed_up.is_finite().then_some(Formula { c_d_s, c_c_s, c_c_from, n_d, zone_share, speed_up }))
}

fn compare(among: &Among, hybrid: &Member, partner: &Member) -> Result<Option<Speed>, Error> {
    let Some((own, other)) = Times::of(hybrid.run).zip(Times::of(partner.run)) else { return Ok(None) };
    let wall = |times: &Times| times.wall / (times.steps * times.step);
    Ok(Some(Speed {
        who: hybrid.who.clone(),
        against: partner.who.run.clone(),
        ranks_x_threads: [own.told(), other.told()],
        whole_run: (own.is_whole() && other.is_whole()).then(|| wall(&other) / wall(&own)),
        after_enrichment: pace_after(hybrid.run, &own).map(|pace| other.pace() / pace),
        coupling_share: phase(hybrid.run, "couple") / own.seconds(),
        formula: formula(among, hybrid, partner)?,
    }))
}

/// Of hybrids with grains and points, each against grains alone of its packing; others are passed over.
pub fn measured(among: &Among) -> Result<Found<Vec<Speed>>, Error> {
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for hybrid in among.hybrids().filter(|member| member.run.has_both_from().is_some()) {
        let Some(partner) = among.partner(hybrid) else { continue };
        match compare(among, hybrid, partner)? {
            Some(compared) => all.push(compared),
            None => left_out.push(format!(
                "Speed-up of {}: its summary or that of {} has no wall time, steps or ranks.",
                hybrid.who.run, partner.who.run
            )),
        }
        for member in [hybrid, partner].into_iter().chain(continuum_alone(among, hybrid)) {
            if Times::of(member.run).is_some_and(|times| !times.is_whole()) {
                left_out.push(format!(
                    "{} was resumed: its times are those of its last stretch, and of whole runs they say nothing.",
                    member.who.run
                ));
            }
        }
    }
    left_out.sort();
    left_out.dedup();
    if all.iter().any(|compared| compared.ranks_x_threads[0] != compared.ranks_x_threads[1]) {
        left_out.push("Speed-ups of runs on different numbers of ranks and threads say little.".to_owned());
    }
    if all.iter().any(|compared| compared.after_enrichment.is_none()) {
        let why = "Where steps with grains and points have no speed-up, the summary does not tell their time apart.";
        left_out.push(why.to_owned());
    }
    Ok(Found::of(all, left_out))
}
