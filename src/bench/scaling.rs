//! What runs of one job on several numbers of ranks say about scaling: medians, speed-ups, efficiencies.
//!
//! With t(N) the wall time of a step on N ranks and n the fewest ranks that were measured, 1 as a rule:
//!
//! * strong scaling, the same job on more ranks: speed-up = n t(n)/t(N), efficiency = speed-up/N;
//! * weak scaling, a job that grows with the ranks: efficiency = t(1)/t(N).

use serde_json::{Value, json};

use crate::domain::phases::NAMES;

/// One measured run, from its `summary.json`.
#[derive(Clone, Debug)]
pub struct Sample {
    /// MPI ranks that it ran on.
    pub ranks: usize,
    /// Of the loop of steps: without start-up, packing, and what is done before the first step. s.
    pub wall: f64,
    /// Of these, rank 0's rows, frames and checkpoints, s.
    pub output: f64,
    /// Of that loop alone; a summary counts those of the whole run.
    pub steps: f64,
    /// Grains and points at the end.
    pub rows: f64,
    /// In the order of a step; empty where the summary has none.
    pub phases: Vec<Phase>,
    /// Of all ranks together. What a summary does not tell is nothing.
    pub messages_per_step: Option<f64>,
    /// Bytes of those messages, of all ranks together; none where the summary has no such number.
    pub bytes_per_step: Option<f64>,
    /// Longest busy time of a rank over the mean.
    pub imbalance: Option<f64>,
    /// How often blocks were dealt to ranks anew; none where the summary does not tell.
    pub rebalances: Option<f64>,
    /// Grains and points that one rank has sent to another, of all ranks; none where the summary does not tell.
    pub rows_moved: Option<f64>,
    /// Of the state at the end.
    pub digest: String,
}

/// Time in a phase over the run: mean over ranks, and of the slowest one, s.
#[derive(Clone, Debug)]
pub struct Phase {
    /// One of [`NAMES`].
    pub name: String,
    /// s.
    pub mean: f64,
    /// s.
    pub most: f64,
}

impl Sample {
    /// Reads a summary; tells what is missing.
    pub fn of_summary(summary: &Value, ranks: usize, digest: String) -> Result<Self, String> {
        let number = |key: &str| summary.get(key).and_then(Value::as_f64);
        let wanted = |key: &str| number(key).ok_or_else(|| format!("summary.json has no number `{key}`"));
        let (wall, step) = (wanted("wall_seconds")?, wanted("microseconds_per_step")?);
        let phase = |(name, seconds): (&String, &Value)| {
            let number = |key: &str| seconds.get(key).and_then(Value::as_f64).unwrap_or(0.0);
            Phase { name: name.clone(), mean: number("mean"), most: number("most") }
        };
        let phases = summary.get("phases").and_then(Value::as_object);
        let mut phases: Vec<Phase> = phases.map_or(Vec::new(), |phases| phases.iter().map(phase).collect());
        // In the order of a step, which an object does not keep.
        phases.sort_by_key(|phase| NAMES.iter().position(|name| *name == phase.name));
        Ok(Self {
            ranks,
            wall,
            output: phases.iter().find(|phase| phase.name == "output").map_or(0.0, |phase| phase.mean),
            // The summary counts steps of the whole run, its loop may be a part of them.
            steps: (1e6 * wall / step).round().max(1.0),
            rows: wanted("grains")? + wanted("points")?,
            phases,
            messages_per_step: number("messages_per_step"),
            bytes_per_step: number("bytes_per_step"),
            imbalance: number("imbalance"),
            rebalances: number("rebalances"),
            rows_moved: number("rows_moved"),
            digest,
        })
    }

    /// Wall time of a step, s.
    pub fn step(&self) -> f64 {
        self.wall / self.steps
    }

    /// The same without output, s.
    pub fn step_without_output(&self) -> f64 {
        (self.wall - self.output) / self.steps
    }

    /// Wall time of a step over grains and points, ns.
    pub fn nanoseconds_per_row(&self) -> f64 {
        1e9 * self.step() / self.rows
    }
}

/// A number of ranks: its runs and how they compare.
#[derive(Clone, Debug)]
pub struct Point {
    /// The same for all its runs.
    pub ranks: usize,
    /// The run of median wall time, with its phases and messages.
    pub median: Sample,
    /// Wall times of all runs, s, in the order they were made.
    pub walls: Vec<f64>,
    /// n t(n)/t(N) of medians; in weak scaling the efficiency times the ranks.
    pub speed_up: f64,
    /// Speed-up over ranks; in weak scaling t(1)/t(N).
    pub efficiency: f64,
    /// Speed-up, or in weak scaling efficiency, of steps without output.
    pub without_output: f64,
}

/// All that was measured.
#[derive(Clone, Debug)]
pub struct Scaling {
    /// Name and file of the job.
    pub name: String,
    /// As it was given on the command line.
    pub job: String,
    /// Of each rank.
    pub threads: usize,
    /// Cores that the ranks had.
    pub cores: usize,
    /// Simulated time that measured runs begin at, s; 0 is the start.
    pub from: f64,
    /// By ranks, fewest first.
    pub strong: Vec<Point>,
    /// Empty where it was not wanted.
    pub weak: Vec<Point>,
}

/// Points of strong scaling by ranks, from all samples.
pub fn strong(samples: &[Sample]) -> Vec<Point> {
    let medians = medians(samples);
    let Some((base, _)) = medians.first().cloned() else { return Vec::new() };
    let fewest = base.ranks as f64;
    let point = |(median, walls): (Sample, Vec<f64>)| {
        let speed_up = fewest * base.step() / median.step();
        Point {
            ranks: median.ranks,
            speed_up,
            efficiency: speed_up / median.ranks as f64,
            without_output: fewest * base.step_without_output() / median.step_without_output(),
            median,
            walls,
        }
    };
    medians.into_iter().map(point).collect()
}

/// Points of weak scaling by ranks; `base` is one rank's.
pub fn weak(base: &Sample, samples: &[Sample]) -> Vec<Point> {
    let point = |(median, walls): (Sample, Vec<f64>)| {
        let efficiency = base.step() / median.step();
        Point {
            ranks: median.ranks,
            speed_up: efficiency * median.ranks as f64,
            efficiency,
            without_output: base.step_without_output() / median.step_without_output(),
            median,
            walls,
        }
    };
    medians(samples).into_iter().map(point).collect()
}

/// The run of median wall time of each number of ranks, fewest first, with all wall times.
fn medians(samples: &[Sample]) -> Vec<(Sample, Vec<f64>)> {
    let mut ranks: Vec<usize> = samples.iter().map(|sample| sample.ranks).collect();
    ranks.sort_unstable();
    ranks.dedup();
    ranks
        .into_iter()
        .map(|ranks| {
            let mut of: Vec<&Sample> = samples.iter().filter(|sample| sample.ranks == ranks).collect();
            let walls = of.iter().map(|sample| sample.wall).collect();
            of.sort_by(|a, b| a.wall.total_cmp(&b.wall));
            (of[of.len() / 2].clone(), walls)
        })
        .collect()
}

impl Point {
    /// Shortest and longest wall time of a step, s.
    pub fn range(&self) -> [f64; 2] {
        let of = |pick: fn(f64, f64) -> f64, start: f64| self.walls.iter().copied().fold(start, pick);
        [of(f64::min, f64::INFINITY), of(f64::max, 0.0)].map(|wall| wall / self.median.steps)
    }

    fn to_json(&self) -> Value {
        let sample = &self.median;
        let phases: serde_json::Map<String, Value> = sample
            .phases
            .iter()
            .map(|phase| (phase.name.clone(), json!({ "mean": phase.mean, "most": phase.most })))
            .collect();
        json!({
            "ranks": self.ranks,
            "wall_s": sample.wall,
            "walls_s": self.walls,
            "output_s": sample.output,
            "steps": sample.steps,
            "rows": sample.rows,
            "ns_per_step": 1e9 * sample.step(),
            "ns_per_row_step": sample.nanoseconds_per_row(),
            "speed_up": self.speed_up,
            "efficiency": self.efficiency,
            "without_output": self.without_output,
            "imbalance": sample.imbalance,
            "messages_per_step": sample.messages_per_step,
            "bytes_per_step": sample.bytes_per_step,
            "rebalances": sample.rebalances,
            "rows_moved": sample.rows_moved,
            "phases": phases,
            "digest": sample.digest,
        })
    }
}

impl Scaling {
    /// `runs` are those of strong scaling, `weak` those of weak scaling.
    pub fn to_json(&self) -> Value {
        json!({
            "name": self.name,
            "job": self.job,
            "threads": self.threads,
            "cores": self.cores,
            "from": self.from,
            "runs": self.strong.iter().map(Point::to_json).collect::<Vec<Value>>(),
            "weak": self.weak.iter().map(Point::to_json).collect::<Vec<Value>>(),
        })
    }
}

/// Samples of one job whose digests differ: results must not depend on ranks. Names the ranks of both.
pub fn first_difference(samples: &[Sample]) -> Option<(&Sample, &Sample)> {
    let first = samples.first()?;
    samples.iter().find(|sample| sample.digest != first.digest).map(|other| (first, other))
}

/// Samples that the tests of tables and pages share.
#[cfg(test)]
pub mod examples {
    use super::*;

    /// Two phases and all counters, as a summary has them.
    pub fn sample(ranks: usize, wall: f64, digest: &str) -> Sample {
        let summary = json!({
            "wall_seconds": wall, "microseconds_per_step": 1e6 * wall / 1000.0, "steps": 5000, "grains": 300, "points": 700,
            "messages_per_step": 12.5, "bytes_per_step": 40_960.0, "imbalance": 1.04,
            "rebalances": 3, "rows_moved": 77,
            "phases": {"contacts": {"mean": 0.5 * wall, "most": 0.6 * wall}, "halo": {"mean": 0.1 * wall, "most": 0.2 * wall},
                "output": {"mean": 0.1 * wall, "most": 0.1 * wall}},
        });
        Sample::of_summary(&summary, ranks, digest.to_string()).unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::examples::sample;
    use super::*;

    #[test]
    fn a_summary_becomes_times_of_a_step() {
        let sample = sample(2, 4.0, "d");
        assert_eq!((sample.steps, sample.rows), (1000.0, 1000.0));
        assert_eq!((sample.step(), sample.nanoseconds_per_row()), (4e-3, 4000.0));
        assert!((sample.step_without_output() - 3.6e-3).abs() < 1e-15);
        let missing = Sample::of_summary(&json!({"wall_seconds": 1.0}), 1, String::new()).unwrap_err();
        assert!(missing.contains("`microseconds_per_step`"), "{missing}");
        let old = json!({"wall_seconds": 1.0, "microseconds_per_step": 10.0, "grains": 5, "points": 0});
        let old = Sample::of_summary(&old, 1, String::new()).unwrap();
        assert!(old.phases.is_empty() && old.messages_per_step.is_none() && old.imbalance.is_none());
    }

    /// Medians, so that one slow run of a noisy machine changes nothing.
    #[test]
    fn efficiencies_are_those_of_medians() {
        let walls = [(2, 6.0), (1, 10.0), (1, 30.0), (2, 5.0), (1, 9.0), (2, 50.0)];
        let samples: Vec<Sample> = walls.iter().map(|(ranks, wall)| sample(*ranks, *wall, "d")).collect();
        let points = strong(&samples);
        assert_eq!(points.iter().map(|point| point.ranks).collect::<Vec<_>>(), [1, 2]);
        assert_eq!((points[0].median.wall, points[1].median.wall), (10.0, 6.0));
        assert!((points[1].speed_up - 10.0 / 6.0).abs() < 1e-12 && (points[1].efficiency - 5.0 / 6.0).abs() < 1e-12);
        assert_eq!(points[1].walls, [6.0, 5.0, 50.0]);
        assert_eq!(points[1].range(), [5e-3, 50e-3]);
        let weak = weak(&points[0].median, &samples[..1]);
        assert!((weak[0].efficiency - 10.0 / 6.0).abs() < 1e-12);
        let json = Scaling {
            name: "n".into(),
            job: "n.toml".into(),
            threads: 1,
            cores: 2,
            from: 0.0,
            strong: points,
            weak: Vec::new(),
        }
        .to_json();
        let run = &json["runs"][1];
        assert_eq!((&run["ranks"], &run["wall_s"], &run["digest"]), (&json!(2), &json!(6.0), &json!("d")));
        assert_eq!(run["ns_per_step"], json!(6e6));
    }

    /// Two ranks are the fewest: what they take is two ranks' work.
    #[test]
    fn speed_ups_count_from_the_fewest_ranks() {
        let points = strong(&[sample(4, 5.0, "d"), sample(2, 8.0, "d")]);
        assert_eq!((points[0].speed_up, points[0].efficiency), (2.0, 1.0));
        assert!((points[1].speed_up - 3.2).abs() < 1e-12 && (points[1].efficiency - 0.8).abs() < 1e-12);
    }

    #[test]
    fn another_digest_is_seen() {
        let mut samples = vec![sample(1, 1.0, "a"), sample(2, 1.0, "a")];
        assert!(first_difference(&samples).is_none());
        samples.push(sample(4, 1.0, "b"));
        let (first, other) = first_difference(&samples).unwrap();
        assert_eq!((first.ranks, other.ranks), (1, 4));
    }
}
