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

use serde_json::{Value, json};

use super::among::{Among, Member};
use super::{Part, Sheet, by_group};
use crate::base::error::Error;
use crate::job::derived::speed_up_by;
use crate::plot::report::chart::{percent, significant};
use crate::plot::report::load::{Kind, figure};
use crate::plot::report::words::{THIN, plain};

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
    enrichment: Option<Pause>,
}

/// An enrichment within a stretch.
struct Pause {
    /// Simulated time, s.
    at: f64,
    /// Seconds of the steps of the stretch before it, and of the training.
    before: f64,
    training: f64,
}

impl Times {
    fn of(member: &Member) -> Option<Self> {
        let number = |key: &str| member.run.summary_figure(key);
        let wall = number("wall_seconds")?;
        let steps = (1e6 * wall / number("microseconds_per_step")?).round();
        let (steps_all, step) = (number("steps")?, figure(&member.run.scenario, "time.step")?);
        // The summary of a run that was resumed still has the figures of an enrichment before.
        let begin = (steps_all - steps) * step;
        let at = number("enriched_at_time").filter(|at| *at >= begin);
        let pause = |at: f64| {
            let (before, training) = (number("seconds_of_steps_before_enrichment")?, number("training_seconds")?);
            Some(Pause { at, before, training })
        };
        Some(Self {
            wall,
            steps,
            steps_all,
            step,
            together: figure(&member.run.scenario, "time.grain_steps").unwrap_or(1.0),
            output: phase(member, "output"),
            cores: [number("ranks")?, number("threads").unwrap_or(1.0)],
            enrichment: at.and_then(pause),
        })
        .filter(|times| times.wall > 0.0 && times.steps > 0.0)
    }

    fn is_whole(&self) -> bool {
        self.steps >= WHOLE * self.steps_all
    }

    /// Seconds of steps, without output and training.
    fn seconds(&self) -> f64 {
        self.wall - self.output - self.enrichment.as_ref().map_or(0.0, |pause| pause.training)
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
fn phase(member: &Member, name: &str) -> f64 {
    let phases = member.run.summary.get("phases").and_then(|phases| phases.get(name));
    phases.and_then(|phase| phase.get("mean")).and_then(Value::as_f64).unwrap_or(0.0)
}

/// Speed-ups of a hybrid over grains alone.
struct Compared<'a> {
    hybrid: &'a Member<'a>,
    partner: &'a Member<'a>,
    /// Ranks and threads of both.
    cores: [String; 2],
    /// Wall time for wall time, with output and training; none where one of the two was resumed.
    whole: Option<f64>,
    /// Steps after enrichment; none where the summary does not tell them apart.
    after: Option<f64>,
    /// Share of coupling in the hybrid's time of steps.
    coupling: f64,
    formula: Option<Formula>,
}

/// The formula's arguments and its result.
struct Formula {
    /// C_D, s.
    grain: f64,
    /// C_C.
    element: Element,
    /// N_D.
    grains_per_element: f64,
    /// T_D/T.
    zone: f64,
    result: f64,
}

/// Seconds of steps after enrichment for a simulated second.
fn pace_after(hybrid: &Member, times: &Times) -> Option<f64> {
    let Some(pause) = &times.enrichment else {
        // All of the stretch lies after it, unless the summary does not say how long it took.
        let is_earlier = hybrid.run.summary_figure("enriched_at_time")? < (times.steps_all - times.steps) * times.step;
        return is_earlier.then(|| times.pace());
    };
    let simulated = times.steps_all * times.step - pause.at;
    let seconds = times.seconds() - pause.before;
    (simulated > 0.0 && seconds > 0.0).then(|| seconds / simulated)
}

/// Cost of an element of the continuum.
struct Element {
    /// Seconds of a core for it to be advanced once, or over a step of the grains alone.
    seconds: f64,
    from: String,
}

/// The run of the continuum alone that tells what a hybrid's elements cost.
fn continuum_alone<'a, 'm>(among: &'m Among<'a>, hybrid: &Member) -> Option<&'m Member<'a>> {
    let mut alone = among.of_method(hybrid.case, "mpm");
    alone.retain(|member| member.cell() == hybrid.cell() && Times::of(member).is_some());
    alone.iter().find(|member| member.seed == hybrid.seed).or(alone.first()).copied()
}

/// Of an element that is advanced once.
fn element_cost(among: &Among, hybrid: &Member) -> Option<Element> {
    let per_side = figure(&hybrid.run.scenario, "continuum.points_per_cell")?;
    let (seconds, point_steps, from) = match continuum_alone(among, hybrid) {
        Some(alone) => {
            let times = Times::of(alone)?;
            let points = alone.run.summary_figure("points")?;
            (times.seconds() * times.all_cores(), points * times.advances(), alone.label.clone())
        }
        None => {
            let times = Times::of(hybrid)?;
            let seconds: f64 = CONTINUUM.iter().map(|name| phase(hybrid, name)).sum();
            let point_steps = hybrid.run.summary_figure("point_steps_per_second")? * times.wall;
            (seconds * times.all_cores(), point_steps, "its own phases of points and nodes".to_owned())
        }
    };
    let seconds = seconds * per_side * per_side / point_steps;
    (seconds.is_finite() && seconds > 0.0).then_some(Element { seconds, from })
}

/// Free grains of a frame, and the height of the space that they fill, m.
fn grains(member: &Member, frame: usize) -> Result<(f64, f64), Error> {
    let snapshot = member.run.snapshot(frame)?;
    let free = || snapshot.bodies.iter().filter(|body| body.kind == Kind::Grain);
    let lower = free().map(|body| body.position[1] - body.radius).fold(f64::INFINITY, f64::min);
    let upper = free().map(|body| body.position[1] + body.radius).fold(f64::NEG_INFINITY, f64::max);
    Ok((free().count() as f64, upper - lower))
}

fn formula(among: &Among, hybrid: &Member, partner: &Member) -> Result<Option<Formula>, Error> {
    let (Some(frame), Some(own), Some(times)) = (hybrid.enriched, Times::of(hybrid), Times::of(partner)) else {
        return Ok(None);
    };
    let (inserted, _) = grains(hybrid, frame)?;
    let (all, height) = grains(partner, 0)?;
    let grain_steps = partner.run.summary_figure("grain_steps_per_second").map(|rate| rate * times.wall);
    let grain = grain_steps.filter(|steps| *steps > 0.0).map(|steps| times.seconds() * times.all_cores() / steps);
    let (Some(grain), Some(once), Some(cell)) = (grain, element_cost(among, hybrid), hybrid.cell()) else {
        return Ok(None);
    };
    let element = Element { seconds: once.seconds * times.step / (own.together * own.step), ..once };
    let grains_per_element = all * cell * cell / (height * partner.run.width);
    let zone = inserted / all;
    let result = speed_up_by(zone, element.seconds, grain * grains_per_element);
    Ok(result.is_finite().then_some(Formula { grain, element, grains_per_element, zone, result }))
}

fn compare<'a>(
    among: &'a Among,
    hybrid: &'a Member<'a>,
    partner: &'a Member<'a>,
) -> Result<Option<Compared<'a>>, Error> {
    let Some((own, other)) = Times::of(hybrid).zip(Times::of(partner)) else { return Ok(None) };
    let wall = |times: &Times| times.wall / (times.steps * times.step);
    Ok(Some(Compared {
        hybrid,
        partner,
        cores: [own.told(), other.told()],
        whole: (own.is_whole() && other.is_whole()).then(|| wall(&other) / wall(&own)),
        after: pace_after(hybrid, &own).map(|pace| other.pace() / pace),
        coupling: phase(hybrid, "couple") / own.seconds(),
        formula: formula(among, hybrid, partner)?,
    }))
}

pub fn part(among: &Among) -> Result<Part, Error> {
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for hybrid in among.members.iter().filter(|member| member.is("hybrid") && member.enrichment().is_some()) {
        let Some(partner) = among.partner(hybrid) else { continue };
        match compare(among, hybrid, partner)? {
            Some(compared) => all.push(compared),
            None => left_out.push(format!(
                "Speed-up of {}: its summary or that of {} has no wall time, steps or ranks.",
                hybrid.label, partner.label
            )),
        }
        for member in [hybrid, partner].into_iter().chain(continuum_alone(among, hybrid)) {
            if Times::of(member).is_some_and(|times| !times.is_whole()) {
                left_out.push(format!(
                    "{} was resumed: its times are those of its last stretch, and of whole runs they say nothing.",
                    member.label
                ));
            }
        }
    }
    left_out.sort();
    left_out.dedup();
    if all.is_empty() {
        return Ok(Part { left_out, ..Part::default() });
    }
    if all.iter().any(|compared| compared.cores[0] != compared.cores[1]) {
        left_out.push("Speed-ups of runs on different numbers of ranks and threads say little.".to_owned());
    }
    if all.iter().any(|compared| compared.after.is_none()) {
        left_out.push(
            "Where steps after enrichment have no speed-up, the summary does not tell their time apart.".to_owned(),
        );
    }
    Ok(Part {
        sentences: sentence(among, &all).into_iter().collect(),
        sheets: vec![sheet(&all)],
        left_out,
        json: Value::Array(all.iter().map(json).collect()),
        ..Part::default()
    })
}

fn times(factor: f64) -> String {
    significant(factor, 3)
}

fn sentence(among: &Among, all: &[Compared]) -> Option<String> {
    let of = |pick: &dyn Fn(&Compared) -> Option<f64>| {
        let values: Vec<(usize, f64)> =
            all.iter().filter_map(|compared| Some((compared.hybrid.group, pick(compared)?))).collect();
        by_group(&among.groups, &values, times)
    };
    let told = [
        ("Over the whole run", of(&|one| one.whole)),
        ("In steps after enrichment", of(&|one| one.after)),
        ("By the formula of 6.4.1", of(&|one| one.formula.as_ref().map(|formula| formula.result))),
    ];
    let told: Vec<String> =
        told.into_iter().filter(|(_, told)| !told.is_empty()).map(|(name, told)| format!("{name}: {told}.")).collect();
    (!told.is_empty()).then(|| format!("Times as fast as the grains alone. {}", told.join(" ")))
}

fn sheet(all: &[Compared]) -> Sheet {
    let mut sheet = Sheet::new(
        "Speed-up over grains alone",
        &[
            "ranks \u{d7} threads",
            "whole run",
            "steps after enrichment",
            "coupling, share of steps",
            "by 6.4.1",
            "C_D",
            "C_C",
            "N_D",
            "T_D/T",
        ],
    );
    for compared in all {
        let formula = compared.formula.as_ref();
        let told = |tell: &dyn Fn(&Formula) -> String| formula.map(tell);
        let cores = match &compared.cores {
            [own, other] if own == other => own.clone(),
            [own, other] => format!("{own} against {other}"),
        };
        sheet.row(
            &format!("{} \u{2013} {}", compared.hybrid.label, compared.partner.label),
            vec![
                Some(cores),
                compared.whole.map(times),
                compared.after.map(times),
                Some(percent(compared.coupling)),
                told(&|formula| times(formula.result)),
                told(&|formula| format!("{}{THIN}ns", plain(1e9 * formula.grain, 3))),
                told(&|formula| {
                    format!("{}{THIN}ns ({})", plain(1e9 * formula.element.seconds, 3), formula.element.from)
                }),
                told(&|formula| plain(formula.grains_per_element, 3)),
                told(&|formula| plain(formula.zone, 3)),
            ],
        );
    }
    sheet
}

fn json(compared: &Compared) -> Value {
    let formula = compared.formula.as_ref().map(|formula| {
        json!({
            "c_d_s": formula.grain, "c_c_s": formula.element.seconds, "c_c_from": formula.element.from,
            "n_d": formula.grains_per_element, "zone_share": formula.zone, "speed_up": formula.result,
        })
    });
    json!({
        "run": compared.hybrid.label, "against": compared.partner.label, "seed": compared.hybrid.seed,
        "ranks_x_threads": compared.cores, "whole_run": compared.whole, "after_enrichment": compared.after,
        "coupling_share": compared.coupling, "formula": formula,
    })
}
