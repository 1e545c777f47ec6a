//! A sweep: one job with many values, a run a row, and the table of all of them.
//!
//! ```text
//! SWEEP/sweep.csv     the table, written again whenever a run has ended
//! SWEEP/NAME/         the run of a row
//! SWEEP/NAME.toml     its job, written out
//! SWEEP/NAME.log      what it said
//! ```

use std::path::{Path, PathBuf};

use super::columns::Column;
use super::measures::Measures;
use super::run::Run;
use crate::base::error::Error;
use crate::run::output::is_done;
use crate::run::results::replace;

/// The table in the folder of a sweep.
pub const TABLE: &str = "sweep.csv";
/// Columns ahead of the keys that vary, and behind them.
const FIRST: [&str; 2] = ["row", "run"];
const STANDING: [&str; 2] = ["state", "cause"];

/// How far the run of a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Not begun.
    Waiting,
    /// "running": a process writes it, of this sweep or of another one.
    Running,
    /// With a checkpoint to go on from.
    Stopped,
    /// "done": it came to its end.
    Done,
    /// "failed": it ended with an error, or was refused.
    Failed,
}

impl State {
    /// As the table has it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Running => "running",
            Self::Stopped => "stopped",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}

/// A line of the table.
#[derive(Clone, Debug)]
pub struct Line {
    /// Folder of the run, below that of the sweep.
    pub run: String,
    /// Of the keys that vary, as they were typed.
    pub values: Vec<String>,
    /// As it was last known.
    pub state: State,
    /// Why it failed, or why it has no figures.
    pub cause: String,
    /// What came out, by name.
    pub figures: Vec<(String, f64)>,
}

/// The table as CSV: number and folder of a row, its values, how it stands, then every figure that any row has.
pub fn to_csv(keys: &[String], lines: &[Line]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in lines.iter().flat_map(|line| &line.figures) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let mut csv = csv::Writer::from_writer(Vec::new());
    let mut add =
        |row: Vec<&str>| csv.write_record(row).expect("rows of a table have one length, and memory takes them");
    add(FIRST
        .into_iter()
        .chain(keys.iter().map(String::as_str))
        .chain(STANDING)
        .chain(names.iter().copied())
        .collect());
    for (index, line) in lines.iter().enumerate() {
        let number = (index + 1).to_string();
        let figure = |name: &&str| line.figures.iter().find(|(own, _)| own == name);
        let figures: Vec<String> =
            names.iter().map(|name| figure(name).map_or_else(String::new, |(_, value)| value.to_string())).collect();
        let told = [line.state.word(), &line.cause];
        let values = line.values.iter().map(String::as_str);
        add([&number, &line.run]
            .map(String::as_str)
            .into_iter()
            .chain(values)
            .chain(told)
            .chain(figures.iter().map(String::as_str))
            .collect());
    }
    let bytes = csv.into_inner().expect("memory takes all of it");
    String::from_utf8(bytes).expect("text was written")
}

/// Writes the table as a whole.
pub fn write(path: &Path, keys: &[String], lines: &[Line]) -> Result<(), Error> {
    replace(path, to_csv(keys, lines).as_bytes())
}

/// The runs of a sweep that are done, in the order of its table, or as long as there are none all that have rows of a series; none where the folder is no sweep.
pub fn runs_of(folder: &Path) -> Result<Option<Vec<PathBuf>>, Error> {
    let path = folder.join(TABLE);
    if !path.is_file() {
        return Ok(None);
    }
    let broken = |why: String| {
        Error::User(format!(
            "{} is no table of a sweep: {why}. `scree sweep` writes it anew: type its line again.",
            path.display()
        ))
    };
    let mut csv = csv::Reader::from_path(&path).map_err(|error| broken(error.to_string()))?;
    let header = csv.headers().map_err(|error| broken(error.to_string()))?;
    let column =
        header.iter().position(|name| name == FIRST[1]).ok_or_else(|| broken("it has no column `run`".into()))?;
    let (mut runs, mut done) = (Vec::new(), Vec::new());
    for line in csv.records() {
        let line = line.map_err(|error| broken(error.to_string()))?;
        let run = folder.join(line.get(column).unwrap_or_default());
        // The header of a series alone is no row.
        let rows = std::fs::read_to_string(run.join("series.csv")).map_or(0, |text| text.lines().skip(1).count());
        if rows > 0 {
            done.extend(is_done(&run).then(|| run.clone()));
            runs.push(run);
        }
    }
    // A run that failed, or is going on, is no packing among others that have come to their end.
    if !done.is_empty() && done.len() < runs.len() {
        tracing::warn!(
            "warning: {} of {} runs of {} have not come to their end and are left out; `scree report` of their folders shows them",
            runs.len() - done.len(),
            runs.len(),
            folder.display()
        );
        runs = done;
    }
    match runs.is_empty() {
        false => Ok(Some(runs)),
        true => Err(Error::User(format!(
            "No run of the sweep {} has rows yet. Type its line `scree sweep` again to go on with it.",
            folder.display()
        ))),
    }
}

/// Folders of runs, those of sweeps in the place of the sweep.
pub fn with_rows(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut all = Vec::new();
    for folder in folders {
        match runs_of(folder)? {
            Some(runs) => all.extend(runs),
            None => all.push(folder.clone()),
        }
    }
    Ok(all)
}

/// What came out of a run: where it is driven against something that resists peak, strain there, and level of the last part, by the
/// names that `comparison.json` has for them; and the last value of every column of its series.
pub fn figures(directory: &Path) -> Result<Vec<(String, f64)>, Error> {
    let runs = [Run::read(directory)?];
    let mut figures = Vec::new();
    // Why there may be none is told by `scree report`.
    if let Ok(measures) = Measures::of_curves(&runs)
        && let Some(level) = measures.of.first()
    {
        for (name, value) in [
            ("peak_pa", level.peak_pa),
            ("peak_strain", level.peak_strain),
            ("residual_pa", level.residual_pa),
            ("softening", level.softening),
        ] {
            figures.push((name.to_owned(), value));
        }
    }
    let last = |column: &Column| Some((format!("{}_end", column.name), *column.values.last()?));
    figures.extend(runs[0].columns.iter().filter_map(last));
    Ok(figures)
}

/// Refuses a place for a table where there is something else.
pub fn refuse_other(path: &Path) -> Result<(), Error> {
    let is_ours = |text: String| text.starts_with(&FIRST.join(","));
    if path.symlink_metadata().is_err() || std::fs::read_to_string(path).is_ok_and(is_ours) {
        return Ok(());
    }
    Err(Error::User(format!(
        "{} is there already and is no table of a sweep, so it is not replaced. Give another place with --table, or move it away.",
        path.display()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(run: &str, value: &str, figures: &[(&str, f64)]) -> Line {
        let figures = figures.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        Line { run: run.into(), values: vec![value.into()], state: State::Done, cause: String::new(), figures }
    }

    /// Rows of other columns stand in one table, with nothing where a row has none; what has a comma or a quote is one field.
    #[test]
    fn a_table_has_every_figure_of_any_row() {
        let mut lines =
            [line("a", "1", &[("peak_pa", 2.5), ("x_end", 0.1)]), line("b", "100 kPa, dry", &[("y_end", 3.0)])];
        lines[1].cause = "it said \"no\"".into();
        lines[1].state = State::Failed;
        let text = to_csv(&["seed".into()], &lines);
        assert_eq!(
            text,
            "row,run,seed,state,cause,peak_pa,x_end,y_end\n1,a,1,done,,2.5,0.1,\n2,b,\"100 kPa, dry\",failed,\"it said \"\"no\"\"\",,,3\n"
        );
    }

    #[test]
    fn a_folder_without_a_table_is_no_sweep_and_a_table_without_runs_is_told() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(runs_of(folder.path()).unwrap(), None);
        write(&folder.path().join(TABLE), &["seed".into()], &[line("a", "1", &[])]).unwrap();
        assert!(runs_of(folder.path()).unwrap_err().to_string().contains("has rows yet"));
        std::fs::create_dir(folder.path().join("a")).unwrap();
        std::fs::write(folder.path().join("a/series.csv"), "step\n1\n").unwrap();
        assert_eq!(runs_of(folder.path()).unwrap().unwrap(), [folder.path().join("a")]);
        write(&folder.path().join(TABLE), &["seed".into()], &[line("a", "1", &[]), line("c", "2", &[])]).unwrap();
        std::fs::create_dir(folder.path().join("c")).unwrap();
        std::fs::write(folder.path().join("c/series.csv"), "step\n1\n").unwrap();
        assert_eq!(runs_of(folder.path()).unwrap().unwrap().len(), 2);
        std::fs::write(folder.path().join("a/summary.json"), "{\"outcome\":\"done\"}").unwrap();
        assert_eq!(with_rows(&[folder.path().into(), "b".into()]).unwrap(), [folder.path().join("a"), "b".into()]);
    }
}
