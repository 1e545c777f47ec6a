//! A run as tables and back (invariant 3): everything the next step reads, and nothing about who computed it.

use std::path::{Path, PathBuf};

use scree_io::column::{State, Table};
use scree_io::{digest, store};

use crate::body::Body;
use crate::dem::cell::Cell;
use crate::dem::grains::GrainRow;
use crate::error::Error;
use crate::hybrid::oracle::{LOOKS, Memory};
use crate::hybrid::track::Instants;
use crate::law::material::{CriticalMemory, MaterialMemory};
use crate::mpm::points::Point;
use crate::observe::ledger::Entry;
use crate::rebuild::Home;
use crate::record::{Record, Visitor, to_table};
use crate::scenario::Job;
use crate::soundness;
use crate::space::{Plane, Space, Words};
use crate::tables;
use crate::transfer::Cargo;

/// Material points of the jobs of this program.
pub type PlanarPoint = Point<Plane, CriticalMemory<Plane>>;

/// What a run remembers beside grains, points, bodies and cell; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Distance of the plates' faces at the start, m, and packing fraction there.
    pub height_start: f64,
    pub fraction_start: f64,
    /// Rows of the series and frames written so far, and the step of the last row.
    pub series_rows: u64,
    pub frames: u64,
    pub series_step: u64,
    /// Step after which grains replaced points; zero before.
    pub enriched_step: u64,
    pub oracle: Memory,
    pub instants: Instants,
    /// The account of energy; empty where none is kept.
    pub ledger: Vec<Entry>,
    /// Impulses on what holds nodes since the last row; empty where nothing does.
    pub reactions: Vec<Entry>,
}

impl Record for Progress {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("step", &mut self.step);
        visitor.f64s("height_start", std::slice::from_mut(&mut self.height_start));
        visitor.f64s("fraction_start", std::slice::from_mut(&mut self.fraction_start));
        visitor.u64("series_rows", &mut self.series_rows);
        visitor.u64("frames", &mut self.frames);
        visitor.u64("series_step", &mut self.series_step);
        visitor.u64("enriched_step", &mut self.enriched_step);
        visitor.f64s("oracle_clock", std::slice::from_mut(&mut self.oracle.clock));
        visitor.u64("oracle_looks", &mut self.oracle.looks);
        visitor.f64s("oracle_clocks", &mut self.oracle.clocks[..LOOKS]);
        visitor.f64s("oracle_unchanged_since", std::slice::from_mut(&mut self.oracle.unchanged_since));
        visitor.u64("track_every", &mut self.instants.every);
    }
}

/// A list of whole numbers or of times as rows.
#[derive(Clone, Debug, Default)]
struct Flag(u64);
#[derive(Clone, Debug, Default)]
struct Instant(f64);

impl Record for Flag {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("node", &mut self.0);
    }
}

impl Record for Instant {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("time", std::slice::from_mut(&mut self.0));
    }
}

/// Everything of a run on one rank.
#[derive(Clone, Debug)]
pub struct Snapshot<S: Space, M, P> {
    /// The resolved job.
    pub scenario: String,
    pub progress: Progress,
    pub cell: Cell<S>,
    pub bodies: Vec<Body<S>>,
    pub home: Home<S>,
    pub grains: Vec<GrainRow<S, M>>,
    pub points: Vec<Point<S, P>>,
}

impl<S: Space, M: Words<f64>, P: MaterialMemory> Snapshot<S, M, P> {
    pub fn to_state(mut self) -> State {
        let progress = &mut self.progress;
        let mut flags: Vec<Flag> = progress.oracle.flagged.iter().copied().map(Flag).collect();
        let mut times: Vec<Instant> = progress.instants.times.iter().copied().map(Instant).collect();
        let mut run = [progress.clone()];
        let at_home = |displacement: &S::Vector| Body { displacement: *displacement, ..Body::blank() };
        let mut at_home: Vec<Body<S>> = self.home.bodies.iter().map(at_home).collect();
        let mut tables: Vec<Table> = vec![
            to_table("run", &mut run, &mut Progress::default()),
            to_table("flagged", &mut flags, &mut Flag::default()),
            to_table("instants", &mut times, &mut Instant::default()),
            to_table("cell", &mut [self.cell], &mut Cell::blank()),
            to_table("cell_home", &mut [self.home.cell], &mut Cell::blank()),
            to_table("bodies", &mut self.bodies, &mut Body::blank()),
            to_table("bodies_home", &mut at_home, &mut Body::blank()),
        ];
        tables.extend(tables::of_grains(&mut self.grains));
        // A run without an account has no table of it.
        if !progress.ledger.is_empty() {
            tables.push(to_table("ledger", &mut progress.ledger, &mut Entry::default()));
        }
        if !progress.reactions.is_empty() {
            tables.push(to_table("reactions", &mut progress.reactions, &mut Entry::default()));
        }
        tables.push(to_table("points", &mut self.points, &mut Point::<S, P>::blank()));
        let attributes = [
            ("scenario".to_string(), self.scenario),
            ("program".to_string(), concat!("scree ", env!("CARGO_PKG_VERSION")).to_string()),
        ];
        State { attributes: attributes.into(), tables }
    }

    pub fn from_state(state: &State) -> Result<Self, Error> {
        let flags: Vec<Flag> = tables::rows(state, "flagged", &Flag::default())?;
        let times: Vec<Instant> = tables::rows(state, "instants", &Instant::default())?;
        let mut progress = only(tables::rows(state, "run", &Progress::default())?, "run")?;
        let at_home: Vec<Body<S>> = tables::rows(state, "bodies_home", &Body::blank())?;
        progress.oracle.flagged = flags.into_iter().map(|flag| flag.0).collect();
        if state.tables.iter().any(|table| table.name == "ledger") {
            progress.ledger = tables::rows(state, "ledger", &Entry::default())?;
        }
        if state.tables.iter().any(|table| table.name == "reactions") {
            progress.reactions = tables::rows(state, "reactions", &Entry::default())?;
        }
        progress.instants.times = times.into_iter().map(|time| time.0).collect();
        let mut snapshot = Self {
            scenario: scenario_of(state)?,
            progress,
            cell: only(tables::rows(state, "cell", &Cell::blank())?, "cell")?,
            bodies: tables::rows(state, "bodies", &Body::blank())?,
            home: Home {
                cell: only(tables::rows(state, "cell_home", &Cell::blank())?, "cell_home")?,
                bodies: at_home.into_iter().map(|body| body.displacement).collect(),
            },
            grains: tables::to_grains(state)?,
            points: tables::rows(state, "points", &Point::<S, P>::blank())?,
        };
        soundness::refuse_unsound(&mut snapshot)?;
        Ok(snapshot)
    }
}

/// The row of a table that has one.
fn only<R>(mut rows: Vec<R>, table: &str) -> Result<R, Error> {
    match (rows.pop(), rows.len()) {
        (Some(row), 0) => Ok(row),
        (_, rest) => Err(Error::User(format!("table `{table}` has {} rows, one is wanted", rest + 1))),
    }
}

/// The resolved job that a checkpoint carries.
pub fn scenario_of(state: &State) -> Result<String, Error> {
    let text = state.attributes.get("scenario").cloned();
    text.ok_or_else(|| Error::User("the checkpoint carries no scenario".into()))
}

/// Folder of a run's checkpoints.
pub fn folder(dir: &Path) -> PathBuf {
    dir.join("checkpoints")
}

/// What a run that stopped itself left to go on from.
pub fn newest_in_words(dir: &Path) -> String {
    let newest = store::newest(&folder(dir)).ok().and_then(|found| found.into_iter().next());
    match newest {
        Some((_, path)) => {
            format!("The newest checkpoint is {}; `scree resume {}` goes on from it.", path.display(), dir.display())
        }
        None => "There is no checkpoint yet.".to_string(),
    }
}

/// The newest good checkpoint of a run directory; damaged newer ones are reported.
pub fn latest<S: Space, M: Words<f64>, P: MaterialMemory>(dir: &Path) -> Result<(PathBuf, Snapshot<S, M, P>), Error> {
    let (path, state) = latest_state(dir)?;
    Ok((path, Snapshot::from_state(&state)?))
}

/// The same before it is read as a state of one kind of job.
pub fn latest_state(dir: &Path) -> Result<(PathBuf, State), Error> {
    if !dir.is_dir() {
        return Err(Error::User(format!("{}: there is no such run directory", dir.display())));
    }
    let (path, state, damaged) = store::latest_good(&folder(dir)).map_err(|error| Error::User(error.to_string()))?;
    for damage in damaged {
        tracing::warn!("{damage}; going back to {}", path.display());
    }
    Ok((path, state))
}

/// Digest of a checkpoint, or of the newest good one of a run directory.
pub fn digest_of(path: &Path) -> Result<String, Error> {
    let state = if path.is_dir() {
        latest_state(path)?.1
    } else {
        store::read(path).map_err(|error| Error::User(error.to_string()))?
    };
    Ok(digest::digest(&state))
}

/// The state of the newest good checkpoint, or of the kept one nearest to `at` seconds.
pub fn state_at(dir: &Path, at: Option<f64>) -> Result<State, Error> {
    match at {
        None => Ok(latest_state(dir)?.1),
        Some(at) => nearest(dir, at),
    }
}

/// The kept checkpoint nearest in time.
fn nearest(dir: &Path, at: f64) -> Result<State, Error> {
    let folder = folder(dir);
    let kept = store::newest(&folder).map_err(|error| Error::User(error.to_string()))?;
    let mut best: Option<(f64, State)> = None;
    for (_, path) in kept {
        let state = store::read(&path).map_err(|error| Error::User(error.to_string()))?;
        let progress = only(tables::rows(&state, "run", &Progress::default())?, "run")?;
        let job = Job::parse(&scenario_of(&state)?, &path.display().to_string(), &[])?;
        let distance = (progress.step as f64 * job.step() - at).abs();
        if best.as_ref().is_none_or(|(least, _)| distance < *least) {
            best = Some((distance, state));
        }
    }
    best.map(|(_, state)| state).ok_or_else(|| Error::User(format!("{}: there is no checkpoint", folder.display())))
}
