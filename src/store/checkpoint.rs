//! A run as tables and back (invariant 3): everything the next step reads, and nothing about who computed it.

use std::mem;
use std::ops::Range;
use std::path::{Path, PathBuf};

use scree_io::column::{State, Table};
use scree_io::digest;
use scree_io::store::{self, Writer};
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::program;
use crate::base::record::{Cargo, Record, Visitor, from_table, to_table};
use crate::base::space::{Plane, Space};
use crate::base::units::in_short;
use crate::bodies::body::Body;
use crate::couple::kept::KeptGrains;
use crate::couple::oracle::{Look, Memory};
use crate::couple::rest::{CellStrain, RestWatch};
use crate::dem::cell::Cell;
use crate::dem::drive::Missed;
use crate::dem::grains::{GrainRow, PenaltySpring};
use crate::domain::accounts::conservation::Kept;
use crate::domain::accounts::ledger::Entry;
use crate::domain::guards::grains::EnergyGuard;
use crate::domain::parts::{Home, Parts};
use crate::domain::transfer::{self, PIECE_ROWS};
use crate::domain::world::World;
use crate::fem::node::Node;
use crate::job::Job;
use crate::mpm::membrane::{Membranes, Vertex};
use crate::mpm::points::Point;
use crate::mpm::stress::MemoryColumns;
use crate::mpm::track::{Instants, LOOKS};
use crate::rve::{GrainMaterial, Packings, RveRow};
use crate::store::{soundness, tables};

/// What a run remembers beside grains, points, bodies and cell; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Distance of the plates' faces at the start, m, and solid volume fraction there.
    pub height_start: f64,
    /// Of the packing, or what the law of a sheared continuum states; 0 of a job that has neither.
    pub fraction_start: f64,
    /// Rows of the series and frames written so far, and the step of the last row.
    pub series_rows: u64,
    /// Times at which frames were written, whatever was drawn in them.
    pub frames: u64,
    /// Means over time of the next row begin here.
    pub series_step: u64,
    /// Stands for the rows of the series; known on rank 0.
    pub series_digest: u64,
    /// Step after which grains replaced points, or in a continuum that is only watched would have, 1 where there are grains from the start; zero before.
    pub enriched_step: u64,
    /// Of the search for shear bands; as at the start where there is none.
    pub oracle: Memory,
    /// When the tracks of points were taken; `every` is 0 where none are any more: of points beside grains that are kept there is one, of when these were.
    pub instants: Instants,
    /// How all cells have strained since the last judgement of rest, and what they have borne; empty where no zone dissolves.
    pub rest: RestWatch,
    /// What a zone that follows the shear takes its grains from; known on rank 0, empty before any have turned into points.
    pub kept_grains: KeptGrains,
    /// What there was at the start, for the account of what is kept.
    pub kept: Kept,
    /// Of the energy of grains, at its last look.
    pub guard: EnergyGuard,
    /// The account of energy; empty where none is kept.
    pub ledger: Vec<Entry>,
    /// Impulses on what holds nodes since the last row; empty where nothing does.
    pub reactions: Vec<Entry>,
    /// How a control of stress has followed since the last row; empty where none has looked.
    pub missed: Vec<Missed>,
}

impl Record for Progress {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("step", &mut self.step);
        visitor.f64s("height_start", std::slice::from_mut(&mut self.height_start));
        visitor.f64s("fraction_start", std::slice::from_mut(&mut self.fraction_start));
        visitor.u64("series_rows", &mut self.series_rows);
        visitor.u64("frames", &mut self.frames);
        visitor.u64("series_step", &mut self.series_step);
        visitor.u64("series_digest", &mut self.series_digest);
        visitor.u64("enriched_step", &mut self.enriched_step);
        visitor.f64s("oracle_clock", std::slice::from_mut(&mut self.oracle.clock));
        visitor.u64("oracle_looks", &mut self.oracle.looks);
        visitor.f64s("oracle_clocks", &mut self.oracle.clocks[..LOOKS]);
        visitor.f64s("oracle_unchanged_since", std::slice::from_mut(&mut self.oracle.unchanged_since));
        visitor.u64("track_every", &mut self.instants.every);
        self.kept.visit(visitor);
        self.guard.visit(visitor);
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

impl Record for Look {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("participation", std::slice::from_mut(&mut self.participation));
        visitor.f64s("fastest", std::slice::from_mut(&mut self.fastest));
        visitor.f64s("pace", std::slice::from_mut(&mut self.pace));
        visitor.f64s("time", std::slice::from_mut(&mut self.time));
    }
}

impl Record for CellStrain {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("cell", &mut self.cell);
        visitor.f64s("strain", &mut self.strain);
        visitor.u64("looks", &mut self.looks);
        visitor.later_f64s("plastic", &mut self.plastic);
        visitor.later_f64s("mobilised", std::slice::from_mut(&mut self.mobilised));
    }
}

/// Everything of a run on one rank.
#[derive(Clone, Debug)]
pub struct Snapshot<S: Space> {
    /// The resolved job.
    pub scenario: String,
    /// How far the run is; the same on every rank.
    pub progress: Progress,
    /// As it is now.
    pub cell: Cell<S>,
    /// As they are now, all of the world.
    pub bodies: Vec<Body<S>>,
    /// As both were at the last rebuild.
    pub home: Home<S>,
    /// In canonical order; none in a [`head`].
    pub grains: Vec<GrainRow<S>>,
    /// Words of what their contacts remember.
    pub memory_words: usize,
    /// In canonical order; none in a [`head`].
    pub points: Vec<Point<S>>,
    /// Their RVEs, where the material is grains.
    pub rves: Vec<RveRow<S>>,
    /// Of a mesh, where there is one.
    pub nodes: Option<Vec<Node<S>>>,
    /// What their law remembers.
    pub memory_columns: MemoryColumns,
    /// Of membranes, all of them.
    pub vertices: Vec<Vertex<S>>,
    /// Where the material is grains, those of its packings.
    pub packings: Packings,
}

impl<S: Space> Snapshot<S> {
    /// As it is written. Of what a run may lack (account, oracle, membranes, packings, mesh) there is a table only where it has it.
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
        tables.extend(tables::of_grains(&mut self.grains, self.memory_words));
        tables.push(tables::of_penalty_springs(&self.grains));
        // A run without an account has no table of it.
        if !progress.ledger.is_empty() {
            tables.push(to_table("ledger", &mut progress.ledger, &mut Entry::default()));
        }
        // Nor has one that is not watched, or by the Laplacian, one of what looks have seen.
        if progress.oracle.seen != Memory::default().seen {
            tables.push(to_table("oracle_looks", &mut progress.oracle.seen, &mut Look::default()));
        }
        if !progress.rest.cells.is_empty() {
            tables.push(to_table("rest", &mut progress.rest.cells, &mut CellStrain::default()));
        }
        let KeptGrains { grains, seats } = &mut progress.kept_grains;
        if !grains.is_empty() {
            tables.extend(tables::of_grains_named(tables::KEPT_GRAINS, grains, self.memory_words));
            let at = |displacement: &<Plane as Space>::Vector| Body { displacement: *displacement, ..Body::blank() };
            let mut bodies: Vec<Body<Plane>> = seats.iter().map(at).collect();
            tables.push(to_table(KEPT_BODIES, &mut bodies, &mut Body::blank()));
        }
        if !progress.reactions.is_empty() {
            tables.push(to_table("reactions", &mut progress.reactions, &mut Entry::default()));
        }
        if !progress.missed.is_empty() {
            tables.push(to_table("stress_missed", &mut progress.missed, &mut Missed::default()));
        }
        if !self.vertices.is_empty() {
            tables.push(to_table("membranes", &mut self.vertices, &mut Vertex::blank()));
        }
        tables.push(tables::of_points(&mut self.points, &self.memory_columns));
        if !self.packings.is_empty() {
            tables.push(tables::of_packings(&self.packings));
            tables.extend(tables::of_rves(&mut self.rves, self.memory_words));
        }
        let attributes =
            [("scenario".to_string(), self.scenario), (PROGRAM.to_string(), program::identity().to_string())];
        if let Some(nodes) = &mut self.nodes {
            tables.push(to_table(tables::NODES, nodes, &mut Node::blank()));
        }
        State { attributes: attributes.into(), tables }
    }

    /// The state of a run under a contact law with so many words of memory. Tables are used up one after the other, so that rows by
    /// the million are there twice one kind at a time.
    pub fn from_state(mut state: State, memory_words: usize) -> Result<Self, Error> {
        let (points, memory_columns) = tables::to_points(&mut state)?;
        let has_rves = state.tables.iter().any(|table| table.name == "rves");
        let (packings, rves) = match has_rves {
            true => (tables::to_packings(&mut state)?, tables::to_rves(&mut state, memory_words)?),
            false => Default::default(),
        };
        let has_nodes = state.tables.iter().any(|table| table.name == tables::NODES);
        let nodes = has_nodes.then(|| tables::take(&mut state, tables::NODES, &Node::blank())).transpose()?;
        let grains = tables::to_grains(&mut state, memory_words)?;
        let kept_grains = kept_grains(&mut state, memory_words)?;
        let state = &state;
        let flags: Vec<Flag> = tables::rows(state, "flagged", &Flag::default())?;
        let times: Vec<Instant> = tables::rows(state, "instants", &Instant::default())?;
        let mut progress = Progress { kept_grains, ..progress_of(state)? };
        let at_home: Vec<Body<S>> = tables::rows(state, "bodies_home", &Body::blank())?;
        progress.oracle.flagged = flags.into_iter().map(|flag| flag.0).collect();
        if state.tables.iter().any(|table| table.name == "ledger") {
            progress.ledger = tables::rows(state, "ledger", &Entry::default())?;
        }
        if state.tables.iter().any(|table| table.name == "reactions") {
            progress.reactions = tables::rows(state, "reactions", &Entry::default())?;
        }
        if state.tables.iter().any(|table| table.name == "stress_missed") {
            progress.missed = tables::rows(state, "stress_missed", &Missed::default())?;
        }
        if state.tables.iter().any(|table| table.name == "oracle_looks") {
            let looks = tables::rows(state, "oracle_looks", &Look::default())?;
            progress.oracle.seen = looks.try_into().map_err(|looks: Vec<Look>| {
                Error::User(format!("{} looks of the oracle in the checkpoint, and {LOOKS} belong there", looks.len()))
            })?;
        }
        if state.tables.iter().any(|table| table.name == "rest") {
            progress.rest.cells = tables::rows(state, "rest", &CellStrain::default())?;
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
            grains,
            memory_words,
            points,
            rves,
            nodes,
            packings,
            memory_columns,
            vertices: match state.tables.iter().any(|table| table.name == "membranes") {
                true => tables::rows(state, "membranes", &Vertex::blank())?,
                false => Vec::new(),
            },
        };
        soundness::refuse_unsound(&mut snapshot)?;
        Ok(snapshot)
    }
}

/// Bodies as they stood with the grains that are kept.
const KEPT_BODIES: &str = "kept_bodies";

/// Grains that have turned into points, where any are kept.
fn kept_grains(state: &mut State, memory_words: usize) -> Result<KeptGrains, Error> {
    if state.tables.iter().all(|table| table.name != tables::KEPT_GRAINS[0]) {
        return Ok(KeptGrains::default());
    }
    let grains = tables::to_grains_named(tables::KEPT_GRAINS, state, memory_words)?;
    let bodies: Vec<Body<Plane>> = tables::take(state, KEPT_BODIES, &Body::blank())?;
    Ok(KeptGrains { grains, seats: bodies.iter().map(|body| body.displacement).collect() })
}

/// RVEs that are on their way to rank 0 at a time: some megabytes.
const RVES_PER_PIECE: usize = 64;

/// Where a state goes, on rank 0.
pub struct Target {
    /// A folder for the file while it is in the making.
    pub scratch: PathBuf,
    /// The file once it is whole, on the same file system as `scratch`.
    pub path: PathBuf,
    /// All of the state but grains and points.
    pub head: State,
}

/// All of a world's state but its grains and points; `progress` is that of its run, `scenario` its job.
pub fn head<S: Space>(world: &World<S>, progress: Progress, scenario: String) -> Snapshot<S> {
    Snapshot {
        scenario,
        progress,
        cell: world.assembly.cell,
        bodies: world.bodies.clone(),
        home: world.home(),
        grains: Vec::new(),
        memory_words: world.law().memory_words(),
        points: Vec::new(),
        rves: Vec::new(),
        nodes: world.settings.meshed.as_ref().map(|_| Vec::new()),
        packings: world.settings.rves.as_ref().map_or(Vec::new(), GrainMaterial::packings),
        memory_columns: world.settings.material.memory_columns(),
        vertices: world.continuum.membranes.vertices.clone(),
    }
}

/// Writes a world's state. Grains and points the ranks hand to rank 0 piece by piece, along the curve, so that none ever needs
/// them all. Collective; where rank 0 cannot write, all return its error, and an older file of that name is as it was.
pub fn write<S: Space>(target: Option<Target>, world: &World<S>) -> Result<(), Error> {
    let transport = world.transport;
    let totals = row_totals(world);
    let begun = target.map(|target| begin(&target, totals)).transpose();
    let mut writer = transfer::agree(transport, begun)?;
    let mut append = |pieces: &[Table]| {
        let Some(writer) = &mut writer else { return Ok(()) };
        pieces.iter().try_for_each(|piece| writer.append(piece)).map_err(not_written)
    };
    let (grains, memory_words) = (|rows| world.grain_rows(rows), world.law().memory_words());
    transfer::stream(transport, PIECE_ROWS, world.assembly.grains.owned, grains, |mut rows| {
        append(&tables::of_grains(&mut rows, memory_words))?;
        append(&[tables::of_penalty_springs(&rows)])
    })?;
    let memory_columns = world.settings.material.memory_columns();
    let points = |rows: Range<usize>| rows.map(|row| world.continuum.points.row(row)).collect();
    transfer::stream(transport, PIECE_ROWS, world.continuum.points.len(), points, |mut rows| {
        append(&[tables::of_points(&mut rows, &memory_columns)])
    })?;
    if world.settings.rves.is_some() {
        transfer::stream(
            transport,
            RVES_PER_PIECE,
            world.rves.len(),
            |rows| world.rve_rows(rows),
            |mut rows| append(&tables::of_rves(&mut rows, memory_words)),
        )?;
    }
    if world.settings.meshed.is_some() {
        let nodes = world.owned_nodes();
        transfer::stream(
            transport,
            PIECE_ROWS,
            nodes.len(),
            |rows| nodes[rows].to_vec(),
            |mut rows| append(&[to_table(tables::NODES, &mut rows, &mut Node::blank())]),
        )?;
    }
    let finished = writer.map_or(Ok(()), |writer| writer.finish().map_err(not_written));
    transfer::agree(transport, finished)
}

/// A world as its job draws it at time zero, without grains and points.
pub struct Drawn<S: Space> {
    /// As the job has it at time zero; [`restore`] gives it the edges and the motion that were saved.
    pub cell: Cell<S>,
    /// In the order they are saved in; [`restore`] moves them to where they were and gives them their motion.
    pub bodies: Vec<Body<S>>,
    /// With the vertices that were saved.
    pub membranes: Membranes<S>,
}

/// The parts of a world, and how far its run is, from a snapshot that rank 0 holds; `draw` draws it with the vertices that its
/// membranes have. Collective.
pub fn restore<S: Space>(
    snapshot: Option<Snapshot<S>>,
    draw: impl FnOnce(&Progress, Vec<Vertex<S>>) -> Result<Drawn<S>, Error>,
    transport: &dyn Transport,
) -> Result<(Parts<S>, Progress), Error> {
    let (packings, mut progress, cell, bodies, home, vertices, (grains, points, rves, nodes)) = match snapshot {
        Some(of) => {
            let rows = (of.grains, of.points, of.rves, of.nodes.unwrap_or_default());
            (of.packings, vec![of.progress], vec![of.cell], of.bodies, vec![of.home], of.vertices, rows)
        }
        None => Default::default(),
    };
    let packings = tables::everywhere(packings, transport)?;
    // What rank 0 alone knows does not travel.
    let kept_grains = progress.first_mut().map_or_else(KeptGrains::default, |of| mem::take(&mut of.kept_grains));
    let progress = Progress { kept_grains, ..transfer::broadcast(transport, progress)?.remove(0) };
    let moved = transfer::broadcast(transport, cell)?.remove(0);
    let saved = transfer::broadcast(transport, bodies)?;
    let saved_home = transfer::broadcast(transport, home)?.remove(0);
    let vertices = transfer::broadcast(transport, vertices)?;
    let Drawn { mut cell, mut bodies, membranes } = draw(&progress, vertices)?;
    let mut home = Home { cell, bodies: saved_home.bodies };
    cell.take_motion_of(&moved);
    home.cell.take_motion_of(&saved_home.cell);
    bodies.iter_mut().zip(&saved).for_each(|(body, saved)| body.take_motion_of(saved));
    Ok((Parts { grains, points, rves, packings, nodes, bodies, membranes, cell, home }, progress))
}

/// Rows over all ranks of the tables that come in pieces.
fn row_totals<S: Space>(world: &World<S>) -> [(&'static str, usize); 8] {
    let contacts = |row: usize| {
        let id = world.assembly.grains.cold[row].id;
        world.assembly.carried_by(row).filter(|(partner, _)| tables::stands_with(id, *partner)).count()
    };
    let grains = world.assembly.grains.owned;
    let contacts = (0..grains).map(contacts).sum::<usize>();
    let springs = world.assembly.grains.springs.iter().filter(|spring| **spring != PenaltySpring::loose()).count();
    let points = world.continuum.points.len();
    let of_rves = world.rves.iter().map(|carried| [carried.rve.grains(), carried.rve.remembered()]);
    let [rve_grains, rve_contacts] = of_rves.fold([0; 2], |[a, b], [grains, contacts]| [a + grains, b + contacts]);
    let nodes = world.elements.owned.iter().filter(|owned| **owned).count();
    let counts = [grains, contacts, springs, points, world.rves.len(), rve_grains, rve_contacts, nodes];
    let mut totals = counts.map(|count| count as i64);
    world.transport.sum(&mut totals);
    let of_rves = [tables::RVES, tables::RVE_GRAINS, tables::RVE_CONTACTS];
    let [rves, rve_grains, rve_contacts] = of_rves;
    let names = ["grains", "contacts", "ties", "points", rves, rve_grains, rve_contacts, tables::NODES];
    std::array::from_fn(|table| (names[table], totals[table] as usize))
}

/// A file with all tables, where those of `totals` have their rows to come.
fn begin(Target { scratch, path, head }: &Target, totals: [(&str, usize); 8]) -> Result<Writer, Error> {
    let mut writer = Writer::create_in(scratch, path, &head.attributes).map_err(not_written)?;
    for table in &head.tables {
        let total = totals.iter().find(|(name, _)| *name == table.name);
        writer.begin(table, total.map_or(table.rows, |(_, rows)| *rows)).map_err(not_written)?;
    }
    Ok(writer)
}

fn not_written(error: scree_io::Error) -> Error {
    Error::Run(error.to_string())
}

/// The row of a table that has one.
fn only<R>(mut rows: Vec<R>, table: &str) -> Result<R, Error> {
    let count = rows.len();
    match rows.pop() {
        Some(row) if count == 1 => Ok(row),
        _ => Err(Error::User(format!("table `{table}` has {count} rows, one is wanted"))),
    }
}

/// Attributes that tell which run and which program a checkpoint is of.
pub const RUN: &str = "run";
/// Its text is [`program::identity`].
pub const PROGRAM: &str = "program";

/// The resolved job that a checkpoint carries.
pub fn scenario_of(state: &State) -> Result<String, Error> {
    let text = state.attributes.get("scenario").cloned();
    text.ok_or_else(|| Error::User("the checkpoint carries no scenario".into()))
}

/// Whether a state is of a program whose guard of energy remembered nothing.
pub fn is_of_schema_2(state: &State) -> bool {
    state.table("run").is_ok_and(|table| table.column("guard_step").is_err())
}

/// How far the run of a checkpoint is.
pub fn progress_of(state: &State) -> Result<Progress, Error> {
    let table = state.table("run").map_err(|error| Error::User(error.to_string()))?;
    // Up to schema 2 the guard of energy remembered nothing.
    match is_of_schema_2(state) {
        false => only(tables::rows(state, "run", &Progress::default())?, "run"),
        true => {
            let mut blank = [Progress::default()];
            let now = to_table("run", &mut blank, &mut Progress::default());
            let mut table = table.clone();
            table.columns.extend(now.columns.into_iter().filter(|column| column.name.starts_with("guard_")));
            only(from_table(&table, &Progress::default()).map_err(Error::User)?, "run")
        }
    }
}

/// Folder of a run's checkpoints.
pub fn folder(dir: &Path) -> PathBuf {
    dir.join("checkpoints")
}

/// What a run that stopped itself left to go on from.
pub fn newest_in_words(dir: &Path) -> String {
    let newest = store::all(&folder(dir)).ok().and_then(|found| found.into_iter().next());
    match newest {
        Some((_, path)) => {
            format!("The newest checkpoint is {}; `scree resume {}` goes on from it.", path.display(), dir.display())
        }
        None => "There is no checkpoint yet.".to_string(),
    }
}

/// The newest good checkpoint of a run directory; damaged newer ones are reported.
pub fn latest<S: Space>(dir: &Path, memory_words: usize) -> Result<(PathBuf, Snapshot<S>), Error> {
    let (path, state) = latest_state(dir)?;
    Ok((path, Snapshot::from_state(state, memory_words)?))
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

/// A state and its time, s: of the newest good checkpoint, or of the one that was written `at` that time.
pub fn state_at(dir: &Path, at: Option<f64>) -> Result<(State, f64), Error> {
    match at {
        None => {
            let (path, state) = latest_state(dir)?;
            let time = time_of(&state, &path)?;
            Ok((state, time))
        }
        Some(at) => of_time(dir, at),
    }
}

/// The time of a checkpoint, s.
fn time_of(state: &State, path: &Path) -> Result<f64, Error> {
    Ok(progress_of(state)?.step as f64 * step_of(state, path)?)
}

/// The time step of the job of a checkpoint, s.
fn step_of(state: &State, path: &Path) -> Result<f64, Error> {
    Ok(Job::parse(&scenario_of(state)?, &path.display().to_string(), &[])?.step())
}

/// The checkpoint of a time, to half a step.
fn of_time(dir: &Path, at: f64) -> Result<(State, f64), Error> {
    let folder = folder(dir);
    let mut kept = store::all(&folder).map_err(|error| Error::User(error.to_string()))?;
    kept.reverse();
    let read = |path: &Path| store::read(path).map_err(|error| Error::User(error.to_string()));
    let Some((_, newest)) = kept.last() else {
        return Err(Error::User(format!("{}: there is no checkpoint", folder.display())));
    };
    let dt = step_of(&read(newest)?, newest)?;
    let times: Vec<f64> = kept.iter().map(|(step, _)| *step as f64 * dt).collect();
    match times.iter().position(|time| (time - at).abs() <= 0.5 * dt) {
        Some(found) => Ok((read(&kept[found].1)?, times[found])),
        None => Err(Error::User(format!(
            "--at {at} s: {} has no checkpoint of that time. {} `output.checkpoint_interval`, `checkpoints_kept` and `checkpoints_for_good` of the job say which are written and kept.",
            dir.display(),
            which(&times, at)
        ))),
    }
}

/// The times that there are, those nearest to `at` where they are many.
pub fn which(times: &[f64], at: f64) -> String {
    const SHOWN: usize = 6;
    let mut near = times.to_vec();
    near.sort_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()));
    near.truncate(SHOWN);
    near.sort_by(f64::total_cmp);
    let told: Vec<String> = near.iter().map(|time| in_short(*time).to_string()).collect();
    let told = told.join(", ");
    match times.len() > SHOWN {
        true => format!("There are {} times; the nearest are {told} s.", times.len()),
        false => format!("There {} {told} s.", if times.len() == 1 { "is" } else { "are" }),
    }
}
