//! `scree bench scaling`: one job on several numbers of ranks, in turn, and what came out.
//!
//! Every number of ranks is started by mpirun, one included, so that binding and messages are alike. A run that does not
//! count comes before: it makes the packing that all others read, and with `--from` the checkpoint that they go on from.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use clap::Args;

use crate::base::error::Error;
use crate::base::units::{Dimension, quantity};
use crate::bench::scaling::{Point, Sample, Scaling, first_difference, strong, weak};
use crate::cli::cores::counted;
use crate::cli::launch::{Launcher, cores, is_launched};
use crate::job::Job;
use crate::job::widen;
use crate::plot::report;
use crate::run::Outcome;
use crate::store::checkpoint;

#[derive(Args)]
pub(in crate::cli) struct Wanted {
    /// The job, a TOML file.
    job: PathBuf,
    /// Numbers of ranks to compare.
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_parser = clap::value_parser!(u16).range(1..))]
    ranks: Vec<u16>,
    /// Measure weak scaling as well: the job grows along x with the ranks.
    #[arg(long)]
    weak: bool,
    /// Runs of each number of ranks; the median counts.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    repeat: u16,
    /// Measure from the first checkpoint at or after this time on, for example 0.02 or "20 ms".
    #[arg(long, value_name = "TIME")]
    from: Option<String>,
    /// Override one key, for example --set time.end="1 ms". May be repeated.
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// End with one line of JSON.
    #[arg(long)]
    json: bool,
    /// Folder for scaling.html, its drawings and scaling.json. Default: runs/scaling_<job name>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Checkpoints that a run keeps from which a later one is chosen.
const KEEP_ALL: &str = "output.checkpoints_kept=1000000";
/// Words of a run that failed which are repeated.
const LAST_LINES: usize = 12;

pub(super) fn command(wanted: &Wanted) -> Result<Outcome, Error> {
    if is_launched() {
        return Err(Error::User(
            "scree bench scaling starts mpirun itself, once for every run. Start it without mpirun.".to_string(),
        ));
    }
    let mut ranks: Vec<usize> = wanted.ranks.iter().map(|ranks| usize::from(*ranks)).collect();
    ranks.sort_unstable();
    ranks.dedup();
    if wanted.weak && ranks[0] != 1 {
        return Err(Error::User(
            "--weak compares with one rank. Add 1 to --ranks, for example --ranks 1,2.".to_string(),
        ));
    }
    let from = wanted.from.as_deref().map(time).transpose()?;
    let job = Job::load(&wanted.job, &wanted.set)?;
    let widened = match wanted.weak {
        true => ranks.iter().filter(|ranks| **ranks > 1).map(|ranks| widen::overrides(&job, *ranks)).collect(),
        false => Ok(Vec::new()),
    };
    // Wider jobs must be good ones before hours are spent on the others.
    let widened: Vec<Vec<String>> = widened?;
    let out = wanted.out.clone().unwrap_or_else(|| Path::new("runs").join(format!("scaling_{}", job.name())));
    let bench = Bench::new(wanted, from, &out)?;
    let most = ranks[ranks.len() - 1];
    let mut cases = vec![bench.case(Kind::Strong, &ranks, &wanted.set, most)?];
    for (ranks, more) in ranks.iter().copied().filter(|ranks| *ranks > 1).zip(&widened) {
        // Half of the ranks prepare what all of them repeat, so that a wider job too is done on two numbers of ranks.
        cases.push(bench.case(Kind::Weak, &[ranks], &[&wanted.set[..], more].concat(), (ranks / 2).max(1))?);
    }
    bench.measure(&mut cases)?;
    let scaling = scaling_of(wanted, &job, &cases);
    let page = report::write_scaling(&scaling, &out)?;
    let (json, file) = (scaling.to_json(), out.join("scaling.json"));
    let mut told = told(&scaling);
    writeln!(told, "The plots are in {}, all figures in {}.", page.display(), file.display()).expect(STRING);
    if wanted.json {
        writeln!(told, "{json}").expect(STRING);
    }
    Ok(Outcome::Done(told))
}

const STRING: &str = "a string takes every line";

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Strong,
    Weak,
}

/// One job with its overrides, prepared, and what was measured of it.
struct Case {
    kind: Kind,
    ranks: Vec<usize>,
    sets: Vec<String>,
    /// A run with the one checkpoint to go on from, or none where runs begin at the start.
    template: Option<PathBuf>,
    /// Time of that checkpoint, s.
    from: f64,
    /// The preparation first.
    samples: Vec<Sample>,
}

impl Case {
    /// What counts.
    fn measured(&self) -> &[Sample] {
        &self.samples[1..]
    }

    /// The same bits on all ranks, or it is no comparison.
    fn refuse_differences(&self, job: &Path) -> Result<(), Error> {
        let Some((first, other)) = first_difference(&self.samples) else { return Ok(()) };
        Err(Error::Run(format!(
            "{} ends in another state on {} ranks than on {}: digest {} against {}. Results must not depend on ranks: this is a defect of the program. Please report it with the job.",
            job.display(),
            other.ranks,
            first.ranks,
            other.digest,
            first.digest
        )))
    }
}

/// How and where runs are made.
struct Bench<'a> {
    wanted: &'a Wanted,
    from: Option<f64>,
    program: PathBuf,
    launcher: Option<Launcher>,
    scratch: Scratch,
}

/// A folder that goes when this goes.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is left for the operator to see.
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl<'a> Bench<'a> {
    fn new(wanted: &'a Wanted, from: Option<f64>, out: &Path) -> Result<Self, Error> {
        let program = std::env::current_exe().map_err(|error| Error::Run(format!("where is this program? {error}")))?;
        let most = usize::from(wanted.ranks.iter().copied().max().unwrap_or(1));
        let launcher = if most > 1 { Some(Launcher::find()?) } else { None };
        let needed = most * usize::from(wanted.threads);
        if needed > cores() {
            tracing::warn!(
                "warning: {most} ranks of {} threads share {} cores, so times are not those of {needed} cores",
                wanted.threads,
                cores()
            );
        }
        let scratch = out.join(format!("scratch-{}", std::process::id()));
        fs::create_dir_all(&scratch).map_err(|error| unwritable(&scratch, &error))?;
        Ok(Self { wanted, from, program, launcher, scratch: Scratch(scratch) })
    }

    /// Runs the whole job once, so that its packing is there, and keeps the checkpoint to go on from.
    fn case(&self, kind: Kind, ranks: &[usize], sets: &[String], preparing: usize) -> Result<Case, Error> {
        let mut sets = sets.to_vec();
        if self.from.is_some() {
            sets.push(KEEP_ALL.to_string());
        }
        let name = format!("prepared-{}-{}", if kind == Kind::Strong { "strong" } else { "weak" }, ranks[0]);
        let folder = self.scratch.0.join(name);
        tracing::info!("a run that does not count, on {}", counted(preparing, "rank"));
        let sample = self.run(preparing, &folder, Some(&sets))?;
        let (template, from) = match self.from {
            Some(from) => {
                let from = keep_one_checkpoint(&folder, from)?;
                (Some(folder), from)
            }
            None => {
                remove(&folder)?;
                (None, 0.0)
            }
        };
        Ok(Case { kind, ranks: ranks.to_vec(), sets, template, from, samples: vec![sample] })
    }

    /// All runs, to and fro through the numbers of ranks, so that drifts of the machine meet all of them alike.
    fn measure(&self, cases: &mut [Case]) -> Result<(), Error> {
        let mut order: Vec<(usize, usize)> = Vec::new();
        for (index, case) in cases.iter().enumerate() {
            order.extend(case.ranks.iter().map(|ranks| (index, *ranks)));
        }
        for repeat in 1..=self.wanted.repeat {
            for (index, ranks) in &order {
                let case = &mut cases[*index];
                let folder = self.scratch.0.join("run");
                let sample = match &case.template {
                    Some(template) => {
                        copy_run(template, &folder)?;
                        self.run(*ranks, &folder, None)?
                    }
                    None => self.run(*ranks, &folder, Some(&case.sets))?,
                };
                remove(&folder)?;
                tracing::info!(
                    "run {repeat} of {}, {}{}: {:.3} s, {:.2} us a step",
                    self.wanted.repeat,
                    counted(*ranks, "rank"),
                    if case.kind == Kind::Weak { " of the wider job" } else { "" },
                    sample.wall,
                    1e6 * sample.step()
                );
                case.samples.push(sample);
                case.refuse_differences(&self.wanted.job)?;
            }
            order.reverse();
        }
        Ok(())
    }

    /// One run from the start with overrides, or on from its checkpoint without.
    fn run(&self, ranks: usize, folder: &Path, sets: Option<&[String]>) -> Result<Sample, Error> {
        let threads = usize::from(self.wanted.threads);
        let mut command = match &self.launcher {
            Some(launcher) => launcher.command(ranks, threads, &self.program),
            None => Command::new(&self.program),
        };
        match sets {
            Some(sets) => {
                command.arg("run").arg(&self.wanted.job).arg("--out").arg(folder);
                sets.iter().for_each(|set| {
                    command.args(["--set", set]);
                });
            }
            None => {
                command.arg("resume").arg(folder);
            }
        }
        let ended = command.args(["--threads", &threads.to_string()]).output();
        let ended = ended.map_err(|error| Error::Run(format!("{command:?} cannot be started: {error}")))?;
        if !ended.status.success() {
            return Err(failed(ranks, &ended));
        }
        let file = folder.join("summary.json");
        let unreadable =
            |why: String| Error::Run(format!("{}: {why}; nothing can be measured without it", file.display()));
        let text = fs::read_to_string(&file).map_err(|error| unreadable(error.to_string()))?;
        let summary = serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
        Sample::of_summary(&summary, ranks, checkpoint::digest_of(folder)?).map_err(unreadable)
    }
}

/// A job that is wrong is the operator's mistake here as well.
fn failed(ranks: usize, ended: &Output) -> Error {
    let words = String::from_utf8_lossy(&ended.stderr);
    let lines: Vec<&str> = words.lines().collect();
    let last = lines[lines.len().saturating_sub(LAST_LINES)..].join("\n");
    let text = format!("the run on {ranks} ranks ended with {}:\n{last}", ended.status);
    if ended.status.code() == Some(2) { Error::User(text) } else { Error::Run(text) }
}

/// Seconds, or a time with its unit.
fn time(text: &str) -> Result<f64, Error> {
    let plain = text.parse().ok();
    let time = plain.or_else(|| quantity(text, Dimension::TIME).ok());
    time.filter(|time: &f64| time.is_finite() && *time >= 0.0).ok_or_else(|| {
        Error::User(format!(
            "--from {text} is not a time. Write seconds or a unit, for example --from 0.02 or --from \"20 ms\"."
        ))
    })
}

/// Leaves the first checkpoint at or after a time, s, alone in a run's folder; returns its time.
fn keep_one_checkpoint(folder: &Path, from: f64) -> Result<f64, Error> {
    let mut kept =
        scree_io::store::newest(&checkpoint::folder(folder)).map_err(|error| Error::Run(error.to_string()))?;
    kept.reverse();
    let scenario = folder.join("scenario.toml");
    let text = fs::read_to_string(&scenario).map_err(|error| unwritable(&scenario, &error))?;
    let step = Job::parse(&text, &scenario.display().to_string(), &[])?.step();
    let last = kept.last().map_or(0, |(step, _)| *step);
    let chosen = kept.iter().position(|(at, _)| (*at as f64 + 0.5) * step >= from && *at < last);
    let Some(chosen) = chosen else {
        return Err(Error::User(format!(
            "--from {from} s: the job has no checkpoint at or after that time and before its end, {:.6} s. Take an earlier time, or a shorter output.checkpoint_interval.",
            last as f64 * step
        )));
    };
    for (_, path) in kept.iter().enumerate().filter(|(index, _)| *index != chosen).map(|(_, kept)| kept) {
        fs::remove_file(path).map_err(|error| unwritable(path, &error))?;
    }
    let time = kept[chosen].0 as f64 * step;
    tracing::info!("measured runs go on from {time:.6} s");
    Ok(time)
}

/// The files of a run, and those in its folder of checkpoints.
fn copy_run(from: &Path, to: &Path) -> Result<(), Error> {
    fs::create_dir_all(to).map_err(|error| unwritable(to, &error))?;
    for entry in fs::read_dir(from).map_err(|error| unwritable(from, &error))? {
        let path = entry.map_err(|error| unwritable(from, &error))?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy_run(&path, &target)?;
        } else {
            fs::copy(&path, &target).map_err(|error| unwritable(&target, &error))?;
        }
    }
    Ok(())
}

fn remove(folder: &Path) -> Result<(), Error> {
    fs::remove_dir_all(folder).map_err(|error| unwritable(folder, &error))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Error {
    Error::User(format!("{}: {error}. Give another folder with --out DIR.", path.display()))
}

fn scaling_of(wanted: &Wanted, job: &Job, cases: &[Case]) -> Scaling {
    let of = |kind: Kind| -> Vec<Sample> {
        cases.iter().filter(|case| case.kind == kind).flat_map(Case::measured).cloned().collect()
    };
    let strong = strong(&of(Kind::Strong));
    let mut weak = weak(&strong[0].median, &of(Kind::Weak));
    if !weak.is_empty() {
        weak.insert(0, strong[0].clone());
    }
    Scaling {
        name: job.name().to_string(),
        job: wanted.job.display().to_string(),
        threads: usize::from(wanted.threads),
        cores: cores(),
        from: cases[0].from,
        strong,
        weak,
    }
}

/// The page for a terminal.
fn told(scaling: &Scaling) -> String {
    let mut page = String::new();
    let mut line = |text: String| writeln!(page, "{text}").expect(STRING);
    let ranks: Vec<String> = scaling.strong.iter().map(|point| point.ranks.to_string()).collect();
    let sample = &scaling.strong[0].median;
    line(format!(
        "{}: {} rows, {} steps{}; ranks {} of {}, {} here; every number of ranks is started by mpirun",
        scaling.name,
        sample.rows,
        sample.steps,
        if scaling.from > 0.0 { format!(" from {:.6} s on", scaling.from) } else { String::new() },
        ranks.join(", "),
        counted(scaling.threads, "thread"),
        counted(scaling.cores, "core")
    ));
    line("All runs ended in the same state to the bit. t(N) is the wall time of a step on N ranks, output included, median of the runs.".into());
    let base = match scaling.strong[0].ranks {
        1 => "t(1)".to_string(),
        fewest => format!("{fewest} t({fewest})"),
    };
    line(format!("\nStrong scaling, the same job: speed-up {base}/t(N), efficiency speed-up/N"));
    table(&mut line, &scaling.strong, "times");
    if !scaling.weak.is_empty() {
        line("\nWeak scaling, a job N times as wide on N ranks: efficiency t(1)/t(N)".into());
        table(&mut line, &scaling.weak, "eff.");
    }
    for (title, points) in [("", &scaling.strong), (" of the wider jobs", &scaling.weak)] {
        phases(&mut line, title, points);
    }
    page
}

/// `unit`: speed-up or efficiency of steps without output.
fn table(line: &mut impl FnMut(String), points: &[Point], unit: &str) {
    line(format!(
        "{:>5} {:>11} {:>19} {:>12} {:>8} {:>10} {:>16} {:>9} {:>8} {:>7} {:>10} {:>10}",
        "ranks",
        "us a step",
        "range of runs",
        "ns a row",
        "speed-up",
        "efficiency",
        "without output",
        "imbalance",
        "messages",
        "kB",
        "rebalances",
        "rows moved"
    ));
    for point in points {
        let sample = &point.median;
        let [least, most] = point.range().map(|step| 1e6 * step);
        line(format!(
            "{:>5} {:>11.2} {:>19} {:>12.2} {:>8.3} {:>10.3} {:>16} {:>9} {:>8} {:>7} {:>10} {:>10}",
            point.ranks,
            1e6 * sample.step(),
            format!("{least:.2} to {most:.2}"),
            sample.nanoseconds_per_row(),
            point.speed_up,
            point.efficiency,
            format!("{:.3} {unit}", point.without_output),
            or_dash(sample.imbalance, 3),
            or_dash(sample.messages_per_step, 1),
            or_dash(sample.bytes_per_step.map(|bytes| 1e-3 * bytes), 1),
            or_dash(sample.rebalances, 0),
            or_dash(sample.rows_moved, 0),
        ));
    }
    line("ns a row: wall time of a step over grains and points. Messages and kB: of all ranks, per step. Imbalance: longest busy time of a rank over the mean.".into());
}

fn phases(line: &mut impl FnMut(String), title: &str, points: &[Point]) {
    let Some(first) = points.first().filter(|point| !point.median.phases.is_empty()) else { return };
    line(format!("\nTime per phase{title}, us a step: mean over ranks, in brackets the slowest rank over it"));
    let ranks: Vec<String> = points.iter().map(|point| format!("{:>18}", counted(point.ranks, "rank"))).collect();
    line(format!("  {:<10}{}", "", ranks.join("")));
    for phase in &first.median.phases {
        let cell = |point: &Point| {
            let found = point.median.phases.iter().find(|other| other.name == phase.name);
            let words = found.map_or("-".to_string(), |found| {
                let slowest = if found.mean > 0.0 { found.most / found.mean } else { 1.0 };
                format!("{:.2} ({slowest:.2})", 1e6 * found.mean / point.median.steps)
            });
            format!("{words:>18}")
        };
        if points
            .iter()
            .any(|point| point.median.phases.iter().any(|other| other.name == phase.name && other.mean > 0.0))
        {
            line(format!("  {:<10}{}", phase.name, points.iter().map(cell).collect::<String>()));
        }
    }
}

/// A figure, or a dash where the summary does not tell it.
fn or_dash(figure: Option<f64>, decimals: usize) -> String {
    figure.map_or("-".to_string(), |figure| format!("{figure:.decimals$}"))
}
