//! Runs from the text of a job, and what they leave: its series and the points of its last checkpoint; and the same job on
//! other ranks and threads.

use std::path::{Path, PathBuf};

use std::sync::Arc;

use scree::base::math::ln;
use scree::base::space::Space;
use scree::domain::world::World;
use scree::job::Job;
use scree::law::material::MaterialLaw;
use scree::mpm::stress::SharedMaterial;
use scree::prepare::point_world;
use scree::run::{Options, Outcome, start};
use scree::store::checkpoint;
use scree_io::column::{State, Table};
use scree_partition::transport::threads;
use scree_partition::{Solo, Transport};

pub const SHAPES: [&str; 4] = ["linear", "generalised", "quadratic", "cubic"];
pub const UPDATES: [&str; 3] = ["first", "last", "modified_last"];
pub const TRANSFERS: [&str; 2] = ["transfer = \"blend\"\nflip = 1.0", "transfer = \"affine\""];

/// The rest of `[scheme]` for every shape, update and transfer that go together.
pub fn schemes() -> impl Iterator<Item = String> {
    every_scheme().filter(|scheme| !refused(scheme))
}

/// Hats throw nodes with next to no mass about unless points average velocities before they become strain.
pub fn refused(scheme: &str) -> bool {
    scheme.contains("\"linear\"") && (scheme.contains("\"last\"") || scheme.contains("affine"))
}

/// The same for all of them.
pub fn every_scheme() -> impl Iterator<Item = String> {
    SHAPES.into_iter().flat_map(|shape| {
        UPDATES.into_iter().flat_map(move |update| {
            TRANSFERS.into_iter().map(move |transfer| format!("shape = \"{shape}\"\nupdate = \"{update}\"\n{transfer}"))
        })
    })
}

/// A job of a material of 1,000 kg/m3 by Hencky's law with these moduli (Young's in Pa, and Poisson's ratio), two points per
/// cell and axis: `grid` and `scheme` are what these tables hold, `rest` is all that follows on the material.
pub fn elastic(name: &str, grid: &str, scheme: &str, [young, poisson]: [f64; 2], rest: &str) -> String {
    format!(
        r#"
        name = "{name}"
        [grid]
        {grid}
        [scheme]
        {scheme}
        points_per_cell = 2
        [material]
        law = "hencky"
        density = 1000
        young_modulus = {young:e}
        poisson_ratio = {poisson}
        {rest}
        "#
    )
}

/// As many of the values as there are dimensions, for a job.
pub fn list(dimension: usize, values: [f64; 3]) -> String {
    let words: Vec<String> = values[..dimension].iter().map(f64::to_string).collect();
    format!("[{}]", words.join(", "))
}

/// The world at the start of a job in which nothing but points moves, of a law that need not be the job's.
pub fn point_world<'t, S: Space>(text: &str, law: impl MaterialLaw<S>, transport: &'t dyn Transport) -> World<'t, S> {
    let Job::Mpm(job) = parse(text) else { panic!("it has no grid") };
    point_world::world(&job, &(Arc::new(law) as SharedMaterial<S>), transport).unwrap()
}

/// A job with other words in places that are there exactly once.
pub fn replaced(text: String, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text, |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    })
}

pub fn parse(text: &str) -> Job {
    Job::parse(text, "job", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

pub fn done(outcome: Result<Outcome, scree::base::error::Error>) {
    match outcome {
        Ok(Outcome::Done(_)) => {}
        other => panic!("{other:?}"),
    }
}

pub fn options(out: &Path) -> Options {
    Options::new(out.to_path_buf(), 1)
}

/// Digest of a run's last checkpoint, and its series.
pub fn result(out: &Path) -> (String, String) {
    (checkpoint::digest_of(out).unwrap(), std::fs::read_to_string(out.join("series.csv")).unwrap())
}

/// One thread against two, two to four ranks, and a resumed run, of a job that keeps three checkpoints. Returns what all
/// of them end with; `what` names the job.
pub fn same(job: &Job, folder: &Path, what: &str) -> (String, String) {
    let alone = folder.join("alone");
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool(1).install(|| done(start::start(job, &options(&alone), &Solo)));
    let wanted = result(&alone);
    pool(2).install(|| done(start::start(job, &options(&folder.join("threads")), &Solo)));
    assert!(result(&folder.join("threads")) == wanted, "two threads end elsewhere: {what}");
    for ranks in [2, 3, 4] {
        let out = folder.join(ranks.to_string());
        threads::run(ranks, |rank| done(start::start(job, &options(&out), &rank)));
        assert!(result(&out) == wanted, "{ranks} ranks end elsewhere: {what}");
    }
    // The run of three ranks without its last checkpoints, gone on with by two.
    let out = folder.join("3");
    let listed = std::fs::read_dir(checkpoint::folder(&out)).unwrap().map(|entry| entry.unwrap().path());
    let mut kept: Vec<_> = listed.filter(|path| path.is_file()).collect();
    kept.sort();
    assert_eq!(kept.len(), 3, "{kept:?}");
    kept[1..].iter().for_each(|later| std::fs::remove_file(later).unwrap());
    threads::run(2, |rank| done(start::resume(&out, Default::default(), &options(&out), &rank)));
    assert!(result(&out) == wanted, "a resumed run ends elsewhere: {what}");
    wanted
}

/// A run that is over.
pub struct Ran {
    _folder: tempfile::TempDir,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    state: State,
    pub summary: serde_json::Value,
    /// Its events.
    pub log: Vec<serde_json::Value>,
}

impl Ran {
    pub fn of(text: &str) -> Self {
        Self::of_job(&parse(text))
    }

    pub fn of_job(job: &Job) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out: PathBuf = folder.path().join("run");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| done(start::start(job, &options(&out), &Solo)));
        let series = std::fs::read_to_string(out.join("series.csv")).unwrap();
        let mut lines = series.lines().filter(|line| !line.starts_with('#'));
        let names = lines.next().unwrap().split(',').map(String::from).collect();
        let rows = lines.map(|line| line.split(',').map(|word| word.parse().unwrap()).collect()).collect();
        let state = checkpoint::latest_state(&out).unwrap().1;
        let summary = serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
        let log = std::fs::read_to_string(out.join("log.jsonl")).unwrap();
        let log = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        Self { _folder: folder, names, rows, state, summary, log }
    }

    /// The events of that name.
    pub fn events(&self, name: &str) -> Vec<&serde_json::Value> {
        self.log.iter().filter(|event| event["event"] == name).collect()
    }

    /// A column of the series.
    #[track_caller]
    pub fn series(&self, name: &str) -> Vec<f64> {
        let at = self.names.iter().position(|other| other == name);
        let at = at.unwrap_or_else(|| panic!("no {name} in {:?}", self.names));
        self.rows.iter().map(|row| row[at]).collect()
    }

    /// Kinetic and elastic energy together, row by row.
    pub fn energy(&self) -> Vec<f64> {
        self.series("kinetic").iter().zip(self.series("elastic")).map(|(kinetic, elastic)| kinetic + elastic).collect()
    }

    fn table(&self, name: &str) -> &Table {
        self.state.tables.iter().find(|table| table.name == name).unwrap()
    }

    /// A column of the points, component by component, row by row.
    #[track_caller]
    pub fn points(&self, name: &str) -> Vec<Vec<f64>> {
        self.rows_of("points", name)
    }

    /// A column of a table of the last checkpoint, component by component, row by row.
    #[track_caller]
    pub fn rows_of(&self, table: &str, name: &str) -> Vec<Vec<f64>> {
        let table = self.table(table);
        let width = table.column(name).unwrap().width;
        table.f64s(name, width).unwrap().chunks(width).map(<[f64]>::to_vec).collect()
    }

    /// One of whole numbers.
    #[track_caller]
    pub fn wholes_of(&self, table: &str, name: &str) -> Vec<u64> {
        self.table(table).u64s(name, 1).unwrap().to_vec()
    }
}

/// Observed order of errors at cells that are halved each time.
pub fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| ln((pair[0] / pair[1]).abs()) / ln(2.0)).collect()
}

/// Errors for a person.
pub fn words(errors: &[f64]) -> String {
    errors.iter().map(|error| format!("{error:+.2e}")).collect::<Vec<String>>().join(" ")
}

/// A folder with all that is in it, under another name.
pub fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy_folder(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}
