//! What a run left behind, whatever its job is: the folder read and checked once, its series as named columns. Nothing is trusted
//! that was not looked at; a run that goes on or was killed is read like one that has ended.

use std::path::{Path, PathBuf};

use scree_io::{frames, series};
use serde_json::{Map, Value, json};
use toml::Table;

use super::columns::{self, Column};
use super::curve::from_zero;
use super::drive::Drive;
use super::snapshot::{Kind, Snapshot};
use super::strained::Span;
use crate::base::error::Error;
use crate::job::Job;
use crate::run::log;

/// The outcome of a run that has not told of one.
pub const UNDER_WAY: &str = "not told yet: still running, or killed";
const COPY: &str = "Copy it back from the run's job";
const RESUME: &str = "Resume the run; it takes the file up where the checkpoint left it";

/// A run, whether it has ended or not.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its folder.
    pub directory: PathBuf,
    /// The job's, or else that of the folder.
    pub name: String,
    /// Nothing where the job has no choice.
    pub method: String,
    /// `scenario.toml`, under the keys of today where it is a whole job.
    pub scenario: Table,
    /// `scenario.toml` as it stands.
    pub scenario_text: String,
    /// `summary.json`, and what the log tells beyond it.
    pub summary: Map<String, Value>,
    /// Of the series, and what follows from them.
    pub columns: Vec<Column>,
    /// What its curves stand against.
    pub drive: Drive,
    /// Times of the frames, s.
    pub frame_times: Vec<f64>,
    /// Across what strain is measured; none in a cell and in space.
    pub span: Option<Span>,
    /// The first frame with free grains, where there is one before it without.
    pub enriched: Option<usize>,
    /// Grains and points in the last frame.
    pub bodies: usize,
}

impl Run {
    /// Of its folder; refuses one that lacks a file, rows of the series or frames, and says what to do.
    pub fn read(directory: &Path) -> Result<Self, Error> {
        if !directory.is_dir() {
            return Err(Error::User(format!(
                "{} is not a directory; give the directory of a run, such as runs/NAME",
                directory.display()
            )));
        }
        let [scenario_path, series_path, frames_path] =
            ["scenario.toml", "series.csv", "frames.vtkhdf"].map(|name| directory.join(name));
        let scenario_text = text(&scenario_path)?;
        // Under the names of today, where it is a whole job.
        let job = Job::parse(&scenario_text, &scenario_path.display().to_string(), &[]);
        let scenario: Table = toml::from_str(&job.map_or_else(|_| scenario_text.clone(), |job| job.to_toml()))
            .map_err(|error| broken(&scenario_path, &format!("is not TOML: {}", error.message()), COPY))?;
        if !["specimen", "grid", "mesh", "cell"].iter().any(|table| scenario.contains_key(*table)) {
            return Err(broken(&scenario_path, "has no table `specimen`, `grid`, `mesh` or `cell`", COPY));
        }
        present(&series_path)?;
        let (header, rows) = series::read(&series_path).map_err(unreadable)?;
        if rows.is_empty() {
            return Err(broken(
                &series_path,
                "has no rows yet",
                "Let the run go on until it has written some: `scree resume`",
            ));
        }
        let column = |(index, name): (usize, &String)| Column {
            name: name.clone(),
            values: rows.iter().map(|row| row.get(index).copied().unwrap_or(f64::NAN)).collect(),
        };
        present(&frames_path)?;
        let frame_times = frames::times(&frames_path).map_err(unreadable)?;
        if frame_times.is_empty() {
            return Err(torn_frames(&frames_path, "it holds no frame"));
        }
        let step = rows.last().and_then(|row| row.first()).copied().unwrap_or(0.0);
        let fallback = directory.file_name().map_or("run".into(), |name| name.to_string_lossy());
        let word = |key: &str| scenario.get(key).and_then(toml::Value::as_str);
        let mut run = Self {
            directory: directory.to_owned(),
            name: word("name").unwrap_or(&fallback).to_owned(),
            method: word("method").unwrap_or_default().to_owned(),
            summary: summary(directory, step)?,
            columns: columns::with_derived(header.iter().enumerate().map(column).collect()),
            drive: Drive::default(),
            frame_times,
            span: None,
            enriched: None,
            bodies: 0,
            scenario_text,
            scenario,
        };
        run.drive = Drive::of(&run)?;
        let last = run.snapshot(run.frame_times.len() - 1)?.bodies;
        run.bodies = last.len();
        run.span = match (run.dimension(), run.scenario.contains_key("cell")) {
            (2, false) if run.period() > 0.0 => Some(Span::around_the_period(run.period(), run.grain()?)),
            (2, false) => Some(Span::around(&last, run.unit_length())),
            _ => None,
        };
        run.enriched = run.first_frame_with_grains()?;
        Ok(run)
    }

    /// A value of the scenario by its dotted path. The domain of elements, which fill it, goes by the name of a grid's too.
    pub fn value(&self, path: &str) -> Option<&toml::Value> {
        let of_elements = || lookup(&self.scenario, &format!("mesh.{}", path.strip_prefix("grid.")?));
        lookup(&self.scenario, path).or_else(of_elements)
    }

    /// A number of the scenario.
    pub fn number(&self, path: &str) -> Option<f64> {
        as_number(self.value(path)?)
    }

    /// A number of the scenario that there is no run without.
    pub fn needed(&self, path: &str) -> Result<f64, Error> {
        let told = || broken(&self.directory.join("scenario.toml"), &format!("has no positive number `{path}`"), COPY);
        self.number(path).filter(|value| *value > 0.0).ok_or_else(told)
    }

    /// The numbers of a list of the scenario, or none.
    pub fn numbers(&self, path: &str) -> Vec<f64> {
        numbers(self.value(path))
    }

    /// The tables of a list of the scenario.
    pub fn tables(&self, name: &str) -> impl Iterator<Item = &Table> {
        self.scenario.get(name).and_then(toml::Value::as_array).into_iter().flatten().filter_map(toml::Value::as_table)
    }

    /// A number of the summary.
    pub fn told(&self, key: &str) -> Option<f64> {
        self.summary.get(key).and_then(Value::as_f64)
    }

    /// A column of the series; nothing where there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        self.columns.iter().find(|column| column.name == name).map_or(&[], |column| &column.values)
    }

    /// A column that there is no run of this kind without, and all of it numbers.
    pub fn whole(&self, name: &str) -> Result<&[f64], Error> {
        let values = self.column(name);
        let path = self.directory.join("series.csv");
        if values.is_empty() {
            return Err(broken(&path, &format!("has no column `{name}`"), RESUME));
        }
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(row) => Err(broken(&path, &format!("has no number in line {}, `{name}`", row + 2), RESUME)),
        }
    }

    /// The last value of a column.
    pub fn last(&self, name: &str) -> Option<f64> {
        self.column(name).last().copied()
    }

    /// Whether it is of this method, as a job calls it.
    pub fn is(&self, method: &str) -> bool {
        self.method == method
    }

    /// Whether the series counts grains.
    pub fn has_grains(&self) -> bool {
        !self.column("grains").is_empty()
    }

    /// Whether its material is grains at every point.
    pub fn has_rves(&self) -> bool {
        self.is("mpm_dem") || self.is("fem_dem")
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        let is_solid =
            |table: &str| self.value(&format!("{table}.space")).and_then(toml::Value::as_str) == Some("solid");
        if is_solid("grid") || is_solid("cell") { 3 } else { 2 }
    }

    /// The axis that pictures have upright, beside x: the last one, but for elements, and for domains without gravity, that are thinnest along it.
    pub fn up(&self) -> usize {
        let last = self.dimension() - 1;
        let table = ["mesh", "grid", "cell"].into_iter().find(|table| self.scenario.contains_key(*table));
        let weighs =
            ["gravity.acceleration", "cell.gravity"].iter().any(|path| self.numbers(path).iter().any(|g| *g != 0.0));
        let Some(table) = table.filter(|table| last == 2 && (*table == "mesh" || !weighs)) else { return last };
        let [lower, upper, copies] = ["lower", "upper", "copies"].map(|key| self.numbers(&format!("{table}.{key}")));
        let extent = |axis: usize| Some((upper.get(axis)? - lower.get(axis)?) * copies.get(axis).unwrap_or(&1.0));
        let is_thin = matches!([0, 1, 2].map(extent), [Some(x), Some(y), Some(z)] if z < x && z < y);
        if is_thin { 1 } else { last }
    }

    /// In x of a specimen whose sides are joined, m; zero elsewhere.
    pub fn period(&self) -> f64 {
        self.number("specimen.width").unwrap_or(0.0)
    }

    /// Mean diameter of the grains D50, m.
    pub fn grain(&self) -> Result<f64, Error> {
        self.needed("grains.diameter_mean")
    }

    /// Edge of a cell of the grid, m, where points are.
    pub fn cell_edge(&self) -> Option<f64> {
        let edge = self.number("continuum.cell").or_else(|| self.number("grid.cell")).or_else(|| self.element_edge());
        edge.filter(|_| !self.is("dem"))
    }

    /// The shortest edge of an element, m.
    fn element_edge(&self) -> Option<f64> {
        let [lower, upper, elements] = ["mesh.lower", "mesh.upper", "mesh.elements"].map(|path| self.numbers(path));
        let edges = lower.iter().zip(&upper).zip(&elements).map(|((lower, upper), count)| (upper - lower) / count);
        edges.reduce(f64::min)
    }

    /// What lengths are told in, m: mean diameters, or cells where there are no grains.
    pub fn unit_length(&self) -> f64 {
        self.grain().ok().or(self.cell_edge()).unwrap_or(1.0)
    }

    /// Share of the continuum's motion that the grains of a hybrid were trained with.
    pub fn training(&self) -> Option<f64> {
        self.is("hybrid").then(|| self.number("enrichment.training").unwrap_or(1.0))
    }

    /// Of the packing; none where the job has none.
    pub fn seed(&self) -> Option<i64> {
        self.scenario.get("seed").and_then(toml::Value::as_integer)
    }

    /// Name and method; a name that says the method already is enough.
    pub fn label(&self) -> String {
        let said = self.name.split(|letter: char| !letter.is_alphanumeric()).any(|word| word == self.method);
        if said || self.method.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.method) }
    }

    /// The first row with more grains than at the start; only a hybrid has one.
    pub fn cut(&self) -> Option<usize> {
        let grains = self.column("grains");
        (1..grains.len()).find(|&row| self.is("hybrid") && grains[row] > grains[0])
    }

    /// Whether it is a hybrid that began as grains alone.
    pub fn begins_as_grains(&self) -> bool {
        self.is("hybrid") && self.value("zone.begins").and_then(toml::Value::as_str) == Some("everywhere")
    }

    /// The first row with points of a run that had none at the start.
    pub fn rested(&self) -> Option<usize> {
        self.column("points").iter().position(|points| *points > 0.0)
    }

    /// Time and strain at which grains took the place of points.
    pub fn enrichment(&self) -> Option<(f64, f64)> {
        let row = self.cut()?;
        let time = self.told("enriched_at_time").unwrap_or(self.column("time")[row]);
        Some((time, self.told("enriched_at_strain").unwrap_or_else(|| self.at(time))))
    }

    /// Time (s) from which a hybrid has both: its enrichment, or where all began as grains the first points.
    pub fn has_both_from(&self) -> Option<f64> {
        let first_points = || self.rested().map(|row| self.column("time")[row]);
        match self.begins_as_grains() {
            true => self.told("first_points_at_time").or_else(first_points),
            false => self.enrichment().map(|(time, _)| time),
        }
    }

    /// How far it had come then.
    pub fn has_both_at(&self) -> Option<f64> {
        match self.begins_as_grains() {
            true => self.has_both_from().map(|time| self.at(time)),
            false => self.enrichment().map(|(_, strain)| strain),
        }
    }

    /// How far the run has come at a time, s: strain or way of what drives it.
    pub fn at(&self, time: f64) -> f64 {
        from_zero(self.column("time"), &self.drive.values, time)
    }

    /// The same at a frame; of what turns back the time, s.
    pub fn at_frame(&self, frame: usize) -> f64 {
        let time = self.frame_times[frame];
        if self.drive.turns_back { time } else { self.at(time) }
    }

    /// The frame nearest to that; of several the last.
    pub fn frame_at(&self, place: f64) -> usize {
        let away = |frame: usize| (self.at_frame(frame) - place).abs();
        let frames = 0..self.frame_times.len();
        frames.reduce(|best, frame| if away(frame) <= away(best) { frame } else { best }).unwrap_or(0)
    }

    /// How far the last frame is.
    pub fn last_frame(&self) -> f64 {
        self.at_frame(self.frame_times.len() - 1)
    }

    /// The row of the series nearest to a time, s.
    pub fn row_at(&self, time: f64) -> usize {
        let times = self.column("time");
        let away = |row: &usize| (times[*row] - time).abs();
        (0..times.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
    }

    /// Reads that frame; refuses one that cannot be read or drawn.
    pub fn snapshot(&self, frame: usize) -> Result<Snapshot, Error> {
        Snapshot::read(&self.directory.join("frames.vtkhdf"), frame, (self.dimension(), self.up()), self.period())
    }

    /// Once there, they stay.
    fn first_frame_with_grains(&self) -> Result<Option<usize>, Error> {
        let frames = if self.is("hybrid") { self.frame_times.len() } else { 0 };
        let (mut from, mut to) = (0, frames);
        while from < to {
            let middle = from + (to - from) / 2;
            match self.snapshot(middle)?.bodies.iter().any(|body| body.kind == Kind::Grain) {
                true => to = middle,
                false => from = middle + 1,
            }
        }
        Ok((from > 0 && from < frames).then_some(from))
    }
}

#[cfg(test)]
impl Run {
    /// Of a scenario alone.
    pub fn made(scenario: &str) -> Self {
        let scenario: Table = toml::from_str(scenario).unwrap();
        let word = |key: &str| scenario.get(key).and_then(toml::Value::as_str).unwrap_or_default().to_owned();
        Self {
            directory: "runs/t".into(),
            name: word("name"),
            method: word("method"),
            scenario_text: String::new(),
            summary: Map::new(),
            columns: Vec::new(),
            drive: Drive::default(),
            frame_times: vec![0.0],
            span: None,
            enriched: None,
            bodies: 0,
            scenario,
        }
    }
}

/// What a run whose last row is of `step` tells of itself: its summary, and as long as it has none of its present stretch the
/// events of its log.
fn summary(directory: &Path, step: f64) -> Result<Map<String, Value>, Error> {
    let path = directory.join("summary.json");
    let mut figures: Map<String, Value> = match path.exists() {
        true => serde_json::from_str(&text(&path)?).map_err(|error| {
            broken(&path, &format!("is not a JSON object: {error}"), "Resume the run; its end writes the file anew")
        })?,
        false => Map::new(),
    };
    figures.extend(of_refusals(directory));
    figures.extend(of_first_points(directory));
    let is_of_now = figures.get("steps").and_then(Value::as_f64).is_some_and(|told| told >= step);
    if !is_of_now {
        // Times are those of a stretch before.
        ["wall_seconds", "microseconds_per_step", "phases"].into_iter().for_each(|name| drop(figures.remove(name)));
        figures.extend(of_enrichment(directory));
        figures.insert("outcome".to_owned(), json!(UNDER_WAY));
        figures.insert("steps".to_owned(), json!(step));
    }
    Ok(figures)
}

/// How often the log has told that a zone around a band was refused, and why at last.
fn of_refusals(directory: &Path) -> Map<String, Value> {
    let refused = log::told(directory, "zone_refused");
    let mut figures = Map::new();
    if let Some(last) = refused.last() {
        figures.insert("zones_refused".to_owned(), json!(refused.len()));
        figures.insert("zone_refused_why".to_owned(), last["why"].clone());
    }
    figures
}

/// What the log has told of an enrichment: these figures the summary has as well.
fn of_enrichment(directory: &Path) -> Map<String, Value> {
    let Some(Value::Object(mut figures)) = log::told(directory, "enriched").pop() else { return Map::new() };
    ["event", "step", "run"].into_iter().for_each(|key| drop(figures.remove(key)));
    figures
}

/// When the log first tells that grains have turned into points, and how long steps had taken till then; the summary says neither.
fn of_first_points(directory: &Path) -> Map<String, Value> {
    let shrank = log::told(directory, "zone_shrank");
    let told = |(name, key): (&str, &str)| Some((name.to_owned(), shrank.first()?.get(key)?.clone()));
    [("first_points_at_time", "time"), ("seconds_of_steps_before_points", "seconds_of_steps")]
        .into_iter()
        .filter_map(told)
        .collect()
}

/// A value by its dotted path.
pub fn lookup<'a>(table: &'a Table, path: &str) -> Option<&'a toml::Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((head, rest)) => lookup(table.get(head)?.as_table()?, rest),
    }
}

/// None of what is neither a float nor an integer.
pub fn as_number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// The numbers of a list.
pub fn numbers(list: Option<&toml::Value>) -> Vec<f64> {
    list.and_then(toml::Value::as_array).into_iter().flatten().filter_map(as_number).collect()
}

fn text(path: &Path) -> Result<String, Error> {
    present(path)?;
    std::fs::read_to_string(path).map_err(|error| broken(path, &format!("cannot be read: {error}"), "Check the file"))
}

fn present(path: &Path) -> Result<(), Error> {
    let directory = path.parent().unwrap_or(path).display();
    let remedy = format!("A run writes it by its end: `scree resume {directory}` goes on with one that stopped early");
    if path.is_file() { Ok(()) } else { Err(broken(path, "is missing", &remedy)) }
}

/// The library of files names the file and says what to do by itself.
pub fn unreadable(error: scree_io::Error) -> Error {
    Error::User(error.to_string())
}

/// For a file of frames that can be read but not drawn; `what` tells why.
pub fn torn_frames(path: &Path, what: &str) -> Error {
    broken(
        path,
        &format!("cannot be drawn: {what}"),
        "Resume the run from its last checkpoint to write the frames anew",
    )
}

/// For a file that is not as it should be: `what` follows its name, `remedy` is a sentence without its full stop.
pub fn broken(path: &Path, what: &str, remedy: &str) -> Error {
    Error::User(format!("{} {what}. {remedy}.", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_their_path() {
        let table = toml::from_str("a = 2\n[b]\nc = 0.5\nd = \"x\"").unwrap();
        let found = ["a", "b.c", "b.d", "b.c.e"].map(|path| lookup(&table, path).and_then(as_number));
        assert_eq!(found, [Some(2.0), Some(0.5), None, None]);
    }

    #[test]
    fn a_missing_file_is_named_with_what_to_do() {
        let missing = Run::read(Path::new("/nowhere/at/all")).unwrap_err();
        assert!(missing.to_string().contains("/nowhere/at/all is not a directory"));
        let folder = tempfile::tempdir().unwrap();
        let message = Run::read(folder.path()).unwrap_err().to_string();
        assert!(message.contains("scenario.toml is missing") && message.contains("scree resume"), "{message}");
    }

    /// A thin solid is seen across its thickness, whatever its domain is called; one that weighs stands as it falls.
    #[test]
    fn what_is_thin_is_seen_across() {
        let up = |rest: &str| Run::made(rest).up();
        assert_eq!(up("[mesh]\nspace = \"solid\"\nlower = [0.0, 0.0, 0.0]\nupper = [2.0, 3.0, 1.0]"), 1);
        let cell = "[cell]\nspace = \"solid\"\nlower = [0.0, 0.0, 0.0]\nupper = [1.0, 1.0, 1.0]\n";
        assert_eq!(up(cell), 2);
        assert_eq!(up(&format!("{cell}copies = [4.0, 10.0, 1.0]")), 1);
        assert_eq!(up(&format!("{cell}copies = [4.0, 10.0, 1.0]\ngravity = [0.0, 0.0, -9.81]")), 2);
        assert_eq!(up("[cell]\nspace = \"plane\"\nlower = [0.0, 0.0]\nupper = [2.0, 1.0]"), 1);
    }

    #[test]
    fn a_run_without_a_summary_of_now_is_told_by_its_log() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write(
            "log.jsonl",
            "{\"event\":\"started\",\"step\":0}\n{\"event\":\"enriched\",\"step\":40,\"enriched_grains\":12}\n{\"eve",
        );
        let told = summary(folder.path(), 50.0).unwrap();
        assert_eq!((&told["enriched_grains"], &told["outcome"]), (&json!(12), &json!(UNDER_WAY)));
        // Of a stretch before this one.
        write("summary.json", "{\"outcome\":\"stopped\",\"steps\":30,\"ranks\":2,\"wall_seconds\":9}");
        let told = summary(folder.path(), 50.0).unwrap();
        assert_eq!((&told["ranks"], &told["outcome"], &told["steps"]), (&json!(2), &json!(UNDER_WAY), &json!(50.0)));
        // Its times are not those of now.
        assert!(!told.contains_key("wall_seconds"));
        let told = summary(folder.path(), 30.0).unwrap();
        assert_eq!((&told["outcome"], &told["wall_seconds"]), (&json!("stopped"), &json!(9)));
    }
}
