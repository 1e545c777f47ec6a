//! What a run writes into its folder, on rank 0, and what a person reads.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use scree_io::frames::{self, Frame, FrameFile};
use scree_io::series::{self, Series};
use serde_json::{Value, json};

use crate::base::error::Error;
use crate::base::program;
use crate::base::space::Space;
use crate::domain::meter::Meter;
use crate::domain::plan::LoadMap;
use crate::observe::fields::MEANINGS;
use crate::run::experiment::Experiment;
use crate::run::folder::{Folder, LOAD, SUMMARY, series_file};
use crate::run::log::Log;
use crate::run::{Beginning, Options, digest_of_text};
use crate::store::checkpoint::{self, Progress, Snapshot, Target};

/// Open files of a run, on rank 0, and its folder, which is held as long.
pub struct Outputs {
    folder: Folder,
    /// Digest of the job, as the log has it.
    job: String,
    series: Series,
    /// Of the columns that the run has, those that its series has: one of a former program may lack some.
    columns: Vec<usize>,
    /// As many frames in each.
    frame_series: Vec<FrameSeries>,
    log: Log,
    /// Figures for `summary.json`.
    summary: BTreeMap<String, Value>,
    meter: Meter,
    /// Step at which this process began, when, and the last one of the run.
    began: (u64, Instant, u64),
}

/// What lay where at the end, for `scree plan`.
pub fn load_file(dir: &Path) -> PathBuf {
    dir.join(LOAD)
}
/// A file of frames, which the first one makes.
pub struct FrameSeries {
    name: String,
    /// Of what is drawn in the series before it.
    is_of_contacts: bool,
    file: Option<FrameFile>,
    /// The most rows that frames are known to have had.
    rows: usize,
}

impl FrameSeries {
    /// The file `name.vtkhdf` in the folder of a run.
    pub fn of(name: String, is_of_contacts: bool) -> Self {
        Self { name, is_of_contacts, file: None, rows: 0 }
    }

    fn path(&self, dir: &Path) -> PathBuf {
        dir.join(format!("{}.vtkhdf", self.name))
    }

    /// Adds a frame of a run of `job`, by its digest.
    fn add(&mut self, (folder, job): (&Folder, &str), frame: &Frame) -> Result<(), Error> {
        let run = Some(folder.id().as_str()).filter(|id| !id.is_empty()).map(|id| (checkpoint::RUN, id));
        let attributes: Vec<(&str, &str)> =
            run.into_iter().chain([("job", job), (checkpoint::PROGRAM, program::identity())]).collect();
        let path = self.path(folder.dir());
        let added = match &mut self.file {
            Some(file) => file.append(&fitted(frame, file)),
            None => {
                let made = FrameFile::create(&path, &folder.scratch()?, frame, self.rows, &attributes, MEANINGS);
                made.map(|made| self.file = Some(made))
            }
        };
        added.map_err(|error| failed(&path, &error))
    }
}

fn failed(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::Run(format!("{}: {error}; the run has stopped", path.display()))
}

/// The figures of `summary.json`; none where there is none that can be read.
fn summary_of(dir: &Path) -> BTreeMap<String, Value> {
    let text = fs::read_to_string(dir.join(SUMMARY)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Whether the run in a folder has told that it came to its end.
pub fn is_done(dir: &Path) -> bool {
    summary_of(dir).get("outcome") == Some(&json!("done"))
}

/// Of the columns that a run has now, those that its series has, where these are some of them in their order; else all, which the
/// series will be refused for.
fn columns_there(path: &Path, header: &[String]) -> Result<Vec<usize>, Error> {
    let there = series::header(path).map_err(|error| Error::User(error.to_string()))?;
    let mut next = 0;
    let mut find = |name: &String| {
        let found = next + header[next..].iter().position(|column| column == name)?;
        next = found + 1;
        Some(found)
    };
    let all = || (0..header.len()).collect();
    Ok(there.iter().map(&mut find).collect::<Option<Vec<usize>>>().unwrap_or_else(all))
}

/// Whether a run has told that it was done after `step`: who is killed between the last checkpoint and the last words has not.
fn tells_of_the_end(summary: &BTreeMap<String, Value>, step: u64) -> bool {
    let tells = |key: &str, what: Value| summary.get(key) == Some(&what);
    tells("outcome", json!("done")) && tells("steps", json!(step))
}

/// Without what the frames of a file lack: one that an earlier version began has not all fields of today.
fn fitted<'a>(frame: &'a Frame, file: &FrameFile) -> Cow<'a, Frame> {
    if frame.fields.iter().all(|field| file.has(&field.name)) {
        return Cow::Borrowed(frame);
    }
    let mut frame = frame.clone();
    frame.fields.retain(|field| file.has(&field.name));
    Cow::Owned(frame)
}

/// A log that somebody has put in the place of the run's own is not cut.
fn refuse_other_log(log: &Log, folder: &Folder) -> Result<(), Error> {
    match log.run() {
        Some(run) if folder.id().is_known() && run != folder.id().as_str() => Err(Error::User(format!(
            "{}: this log is of run {run}, and the folder of run {}. Put the log of this run back, or move this one away.",
            folder.dir().join("log.jsonl").display(),
            folder.id().as_str()
        ))),
        _ => Ok(()),
    }
}

impl Outputs {
    /// The outputs of a run that begins after `step`, in a folder that has none yet.
    pub fn create<S: Space>(folder: Folder, experiment: &Experiment<S>, step: u64) -> Result<Self, Error> {
        let (log, path) = (Log::open(folder.dir())?, series_file(folder.dir()));
        let header = experiment.header();
        let names: Vec<&str> = header.iter().map(String::as_str).collect();
        let series = Series::create(&path, &names).map_err(|error| failed(&path, &error))?;
        let columns = (0..header.len()).collect();
        Ok(Self::new(folder, log, (series, columns), step, experiment))
    }

    /// Cuts log, series and frames back to what `progress` had written, once all of them are seen to hold that. Those of a branch
    /// begin here. None where the run has come to its end and told of it: its series is looked at, and everything left as it is.
    pub fn resume<S: Space>(
        options: &Options,
        folder: Folder,
        progress: &Progress,
        experiment: &Experiment<S>,
    ) -> Result<Option<Self>, Error> {
        if options.beginning == Beginning::Branched {
            return Self::create(folder, experiment, progress.step).map(Some);
        }
        let (dir, path) = (folder.dir(), series_file(folder.dir()));
        let header = experiment.header();
        let columns = columns_there(&path, &header)?;
        let names: Vec<&str> = columns.iter().map(|column| header[*column].as_str()).collect();
        let (rows, digest) = (progress.series_rows as usize, progress.series_digest);
        let other = |error: scree_io::Error| Error::User(error.to_string());
        Series::check(&path, &names, rows, digest).map_err(other)?;
        let summary = summary_of(dir);
        if progress.step >= experiment.steps && tells_of_the_end(&summary, progress.step) {
            return Ok(None);
        }
        let frames_wanted = progress.frames as usize;
        let mut frame_series = experiment.frame_series();
        for path in frame_series.iter().map(|one| one.path(dir)) {
            frames::refuse_fewer(&path, frames_wanted).map_err(|error| failed(&path, &error))?;
        }
        let mut log = Log::open(dir)?;
        refuse_other_log(&log, &folder)?;

        log.cut_after(progress.step)?;
        let series = Series::resume(&path, &names, rows, digest).map_err(other)?;
        let scratch = folder.scratch()?;
        for one in &mut frame_series {
            let path = one.path(dir);
            let cut = FrameFile::open_and_cut(&path, &scratch, frames_wanted, MEANINGS);
            one.file = Some(cut.map_err(|error| failed(&path, &error))?);
        }
        let outputs = Self::new(folder, log, (series, columns), progress.step, experiment);
        Ok(Some(Self { summary, frame_series, ..outputs }))
    }

    fn new<S: Space>(
        folder: Folder,
        log: Log,
        (series, columns): (Series, Vec<usize>),
        step: u64,
        experiment: &Experiment<S>,
    ) -> Self {
        let (summary, meter) = (BTreeMap::new(), Meter::known());
        let (job, frame_series) = (digest_of_text(&experiment.job), experiment.frame_series());
        let began = (step, Instant::now(), experiment.steps);
        Self { folder, job, series, columns, frame_series, log, summary, meter, began }
    }

    /// Held until these outputs are dropped.
    pub fn folder(&self) -> &Folder {
        &self.folder
    }

    /// Where a checkpoint goes, which tells what run it is of.
    pub fn target<S: Space>(&self, path: &Path, head: Snapshot<S>) -> Result<Target, Error> {
        let folder = path.parent().unwrap_or(self.folder.dir());
        fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
        let mut head = head.to_state();
        if self.folder.id().is_known() {
            head.attributes.insert(checkpoint::RUN.to_string(), self.folder.id().as_str().to_string());
        }
        Ok(Target { scratch: self.folder.scratch()?, path: path.to_path_buf(), head })
    }

    /// Adds a row to the series: a number for each column of the run, of which those are written that the series has.
    pub fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        let there: Vec<f64> = self.columns.iter().map(|column| values[*column]).collect();
        self.series.push(&there).map_err(|error| failed(self.series.path(), &error))
    }

    /// Rows written so far are on disk afterwards; what stands for them.
    pub fn sync(&self) -> Result<u64, Error> {
        self.series.sync().map_err(|error| failed(self.series.path(), &error))?;
        Ok(self.series.digest())
    }

    /// A frame for every series of frames, in the order of [`Experiment::frame_series`].
    pub fn frames(&mut self, frames: &[Frame]) -> Result<(), Error> {
        let mut drawn = 0;
        for (one, frame) in self.frame_series.iter_mut().zip(frames) {
            // At first grains may not touch; once they do, each has about four or six neighbours, which a contact is of two.
            let likely = if one.is_of_contacts { 3 * drawn } else { frame.rows() };
            one.rows = one.rows.max(likely);
            drawn = one.rows;
            one.add((&self.folder, &self.job), frame)?;
        }
        Ok(())
    }

    /// One line in `log.jsonl`.
    pub fn log(&mut self, event: &str, step: u64, mut fields: Value) -> Result<(), Error> {
        if self.folder.id().is_known() {
            fields["run"] = json!(self.folder.id().as_str());
        }
        self.log.tell(event, step, fields)
    }

    /// Figures that `summary.json` shows.
    pub fn note(&mut self, figures: Value) {
        if let Value::Object(figures) = figures {
            self.summary.extend(figures);
        }
    }

    /// Replaces `summary.json` by all figures that have been noted.
    pub fn write_summary(&mut self) -> Result<(), Error> {
        if self.folder.id().is_known() {
            self.summary.insert("run".to_string(), json!(self.folder.id().as_str()));
        }
        let text = serde_json::to_string_pretty(&self.summary).map_err(|error| failed(Path::new(SUMMARY), &error))?;
        self.folder.replace(SUMMARY, &(text + "\n"))
    }

    /// Where the load lies, and what it costs.
    pub fn write_load(&self, map: &LoadMap) -> Result<(), Error> {
        let text = serde_json::to_string(map).map_err(|error| failed(Path::new(LOAD), &error))?;
        self.folder.replace(LOAD, &(text + "\n"))
    }

    /// Shows how far the run is.
    pub fn show(&mut self, step: u64, words: impl FnOnce() -> String) {
        let (first, since, steps) = self.began;
        let pace = 1e6 * since.elapsed().as_secs_f64() / (step - first).max(1) as f64;
        let head = || format!("step {step} of {steps}, {pace:.1} us a step");
        self.meter.show(step as f64 / steps as f64, head, words);
    }

    /// Takes the progress bar away.
    pub fn finish(&mut self) {
        self.meter.finish();
    }
}
