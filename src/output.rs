//! A run directory: what rank 0 writes and what a person reads.

use std::collections::BTreeMap;
use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use scree_io::frames::{Frame, FrameFile};
use scree_io::series::Series;
use serde_json::{Value, json};

use crate::checkpoint::Progress;
use crate::error::Error;
use crate::log::Log;
use crate::plan::LoadMap;
use crate::run::{Experiment, Options};

/// Open files of a run, on rank 0.
pub struct Outputs {
    dir: PathBuf,
    series: Series,
    frames: Option<FrameFile>,
    /// As many as there are frames, where contacts are written.
    contacts: Option<FrameFile>,
    log: Log,
    /// Figures for `summary.json`.
    summary: BTreeMap<String, Value>,
    meter: Meter,
}

/// Names in a run directory.
pub fn packing_file(dir: &Path) -> PathBuf {
    dir.join("packing.h5")
}
fn summary_file(dir: &Path) -> PathBuf {
    dir.join("summary.json")
}
/// What lay where at the end, for `scree plan`.
pub fn load_file(dir: &Path) -> PathBuf {
    dir.join("load.json")
}
fn frames_file(dir: &Path) -> PathBuf {
    dir.join("frames.vtkhdf")
}
pub fn scenario_file(dir: &Path) -> PathBuf {
    dir.join("scenario.toml")
}
fn contacts_file(dir: &Path) -> PathBuf {
    dir.join("contacts.vtkhdf")
}
fn series_file(dir: &Path) -> PathBuf {
    dir.join("series.csv")
}

/// A run that finds it stops, with a checkpoint.
pub fn stop_file(dir: &Path) -> PathBuf {
    dir.join("stop")
}

/// Files of a run directory beside its checkpoints; the one by which it is known as one comes last.
pub const FILES: [&str; 8] = [
    "packing.h5",
    "series.csv",
    "frames.vtkhdf",
    "contacts.vtkhdf",
    "log.jsonl",
    "summary.json",
    "load.json",
    "scenario.toml",
];

fn failed(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::Run(format!("{}: {error}; the run has stopped", path.display()))
}

/// Where a small file is written before it takes the place of the old one; who is killed in between leaves it there.
pub fn aside(path: &Path) -> PathBuf {
    let mut aside = path.as_os_str().to_owned();
    aside.push(".tmp");
    aside.into()
}

/// Writes a small file as a whole: whoever reads it meanwhile has the old one, and whoever ends meanwhile leaves it.
fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let aside = aside(path);
    fs::write(&aside, text)?;
    fs::rename(&aside, path)
}

/// Makes a fresh run directory; one that holds a run is never overwritten.
pub fn claim(dir: &Path, scenario: &str) -> Result<(), Error> {
    if scenario_file(dir).exists() {
        return Err(Error::User(format!(
            "{0}: this directory holds a run already. Continue it with `scree resume {0}`, or give another with --out.",
            dir.display()
        )));
    }
    let refused = |error: std::io::Error| {
        Error::User(format!("{}: cannot make the run directory: {error}; give another with --out", dir.display()))
    };
    // Aside, so that a folder of a run is never without its job, whenever this ends.
    let mut aside = dir.as_os_str().to_owned();
    aside.push(".new");
    let aside = PathBuf::from(aside);
    if aside.exists() {
        fs::remove_dir_all(&aside).map_err(refused)?;
    }
    fs::create_dir_all(crate::checkpoint::folder(&aside)).map_err(refused)?;
    fs::write(scenario_file(&aside), scenario).map_err(refused)?;
    fs::rename(&aside, dir).map_err(refused)
}

/// The figures of `summary.json`; none where there is none that can be read.
fn summary_of(dir: &Path) -> BTreeMap<String, Value> {
    let text = fs::read_to_string(summary_file(dir)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Whether a run has told that it was done after `step`: who is killed between the last checkpoint and the last words has not.
fn tells_of_the_end(summary: &BTreeMap<String, Value>, step: u64) -> bool {
    let tells = |key: &str, what: Value| summary.get(key) == Some(&what);
    tells("outcome", json!("done")) && tells("steps", json!(step))
}

/// Adds a frame to its file, which the first one makes.
fn add(file: &mut Option<FrameFile>, path: &Path, frame: &Frame) -> Result<(), Error> {
    let added = match file {
        Some(file) => file.append(frame),
        None => FrameFile::create(path, frame).map(|made| *file = Some(made)),
    };
    added.map_err(|error| failed(path, &error))
}

impl Outputs {
    /// The outputs of a run that begins after `step`.
    pub fn create(dir: &Path, experiment: &impl Experiment, step: u64) -> Result<Self, Error> {
        let (log, path) = (Log::open(dir)?, series_file(dir));
        let header = experiment.header();
        let names: Vec<&str> = header.iter().map(String::as_str).collect();
        let series = Series::create(&path, &names).map_err(|error| failed(&path, &error))?;
        Ok(Self::new(dir, log, (series, [None, None]), Meter::new(step, experiment.steps())))
    }

    /// Cuts log, series and frames back to what `progress` had written. Those of a branch, which has no log yet, begin here.
    /// None where the run has come to its end and told of it: its series is looked at, and everything left as it is.
    pub fn resume(
        options: &Options,
        log: Option<Log>,
        progress: &Progress,
        experiment: &impl Experiment,
    ) -> Result<Option<Self>, Error> {
        let (dir, path) = (&options.out, series_file(&options.out));
        let Some(mut log) = log else { return Self::create(dir, experiment, progress.step).map(Some) };
        let header = experiment.header();
        let names: Vec<&str> = header.iter().map(String::as_str).collect();
        let (rows, digest) = (progress.series_rows as usize, progress.series_digest);
        let other = |error: scree_io::Error| Error::User(error.to_string());
        let summary = summary_of(dir);
        if progress.step >= experiment.steps() && tells_of_the_end(&summary, progress.step) {
            Series::check(&path, &names, rows, digest).map_err(other)?;
            return Ok(None);
        }
        log.cut_after(progress.step)?;
        let series = Series::resume(&path, &names, rows, digest).map_err(other)?;
        let cut = |path: PathBuf| {
            FrameFile::open_and_cut(&path, progress.frames as usize).map_err(|error| failed(&path, &error))
        };
        let frames = Some(cut(frames_file(dir))?);
        let contacts = if experiment.output().contact_frames { Some(cut(contacts_file(dir))?) } else { None };
        let meter = Meter::new(progress.step, experiment.steps());
        let mut outputs = Self::new(dir, log, (series, [frames, contacts]), meter);
        outputs.summary = summary;
        Ok(Some(outputs))
    }

    fn new(dir: &Path, log: Log, (series, [frames, contacts]): (Series, [Option<FrameFile>; 2]), meter: Meter) -> Self {
        Self { dir: dir.to_path_buf(), series, frames, contacts, log, summary: BTreeMap::new(), meter }
    }

    /// The job that the run goes on with.
    pub fn replace_job(&self, job: &str) -> Result<(), Error> {
        let path = scenario_file(&self.dir);
        replace(&path, job).map_err(|error| failed(&path, &error))
    }

    pub fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        self.series.push(values).map_err(|error| failed(self.series.path(), &error))
    }

    /// Rows written so far are on disk afterwards; what stands for them.
    pub fn sync(&self) -> Result<u64, Error> {
        self.series.sync().map_err(|error| failed(self.series.path(), &error))?;
        Ok(self.series.digest())
    }

    pub fn frame(&mut self, frame: &Frame) -> Result<(), Error> {
        add(&mut self.frames, &frames_file(&self.dir), frame)
    }

    pub fn contacts(&mut self, contacts: &Frame) -> Result<(), Error> {
        add(&mut self.contacts, &contacts_file(&self.dir), contacts)
    }

    /// One line in `log.jsonl`.
    pub fn log(&mut self, event: &str, step: u64, fields: Value) -> Result<(), Error> {
        self.log.tell(event, step, fields)
    }

    /// Figures that `summary.json` shows.
    pub fn note(&mut self, figures: Value) {
        if let Value::Object(figures) = figures {
            self.summary.extend(figures);
        }
    }

    pub fn write_summary(&mut self) -> Result<(), Error> {
        let path = summary_file(&self.dir);
        let text = serde_json::to_string_pretty(&self.summary).map_err(|error| failed(&path, &error))?;
        replace(&path, &(text + "\n")).map_err(|error| failed(&path, &error))
    }

    /// Where the load lies, and what it costs.
    pub fn write_load(&self, map: &LoadMap) -> Result<(), Error> {
        let path = load_file(&self.dir);
        let text = serde_json::to_string(map).map_err(|error| failed(&path, &error))?;
        replace(&path, &(text + "\n")).map_err(|error| failed(&path, &error))
    }

    /// Shows how far the run is.
    pub fn show(&mut self, step: u64, words: impl FnOnce() -> String) {
        self.meter.show(step, words);
    }

    pub fn finish(&mut self) {
        self.meter.finish();
    }
}

/// `3:07:05`, or with days before it.
fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (days, hours, minutes) = (seconds / 86_400, seconds / 3600 % 24, seconds / 60 % 60);
    let clock = format!("{hours}:{minutes:02}:{:02}", seconds % 60);
    if days > 0 { format!("{days} d {clock}") } else { clock }
}

/// A progress bar on a terminal, plain lines in a batch log.
enum Meter {
    Bar(ProgressBar),
    Lines { started: Instant, last: Instant, first_step: u64, steps: u64 },
}

/// Time between two lines of a batch log.
const LINE_EVERY: Duration = Duration::from_secs(20);

impl Meter {
    fn new(step: u64, steps: u64) -> Self {
        if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(steps);
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} % {eta} left  {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            bar.set_style(style);
            bar.set_position(step);
            bar.reset_eta();
            Self::Bar(bar)
        } else {
            let now = Instant::now();
            Self::Lines { started: now, last: now, first_step: step, steps }
        }
    }

    fn show(&mut self, step: u64, words: impl FnOnce() -> String) {
        match self {
            Self::Bar(bar) => {
                bar.set_position(step);
                bar.set_message(words());
            }
            Self::Lines { started, last, first_step, steps } => {
                if last.elapsed() < LINE_EVERY {
                    return;
                }
                *last = Instant::now();
                let done = (step - *first_step).max(1) as f64;
                let each = started.elapsed().as_secs_f64() / done;
                let left = clock(each * (*steps - step) as f64);
                eprintln!("step {step} of {steps}, {:.1} us a step, {left} left: {}", 1e6 * each, words());
            }
        }
    }

    fn finish(&mut self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
