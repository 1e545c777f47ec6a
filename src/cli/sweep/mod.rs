//! `scree sweep`: one job with many values, a run a row, so many of them at a time, and a table of what came out.
//!
//! The folder of the sweep says how far each row is; nothing else is kept. So the same line goes on with a sweep whatever ended it,
//! several such lines share the rows of one sweep, and values that are added become rows.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use self::rows::{Row, Rows};
use self::work::{Team, Work};
use super::check::{doubts, refuse_bad_grains};
use super::launch::{cores, is_launched};
use super::run::{Opening, opening};
use crate::analysis::sweep::{self, Line, State, TABLE};
use crate::base::error::Error;
use crate::domain::stop;
use crate::job::Job;
use crate::run::Outcome;
use crate::run::folder::{is_held, settled};
use crate::run::output::is_done;
use crate::run::results::{replace, unwritable};

mod rows;
mod work;

#[derive(Args)]
pub(super) struct Sweep {
    /// The job, a TOML file.
    job: PathBuf,
    /// A key and its values, for example seed=1..10 or contact.friction=0.3,0.5. May be repeated: every combination is a run.
    #[arg(long, value_name = "KEY.PATH=VALUES")]
    vary: Vec<String>,
    /// A CSV file with keys in its first line and the values of a run in every other; combined with --vary.
    #[arg(long, value_name = "FILE")]
    rows: Option<PathBuf>,
    /// Override one key in all runs, for example --set loading.strain_end=0.1. May be repeated.
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// Folder of the sweep: a folder for each run, and the table sweep.csv. Default: runs/<job name>_sweep.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the table to this file as well.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Ranks of each run, started by mpirun where they are more than one.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    ranks: u16,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Runs at a time. Default: the cores of this machine over the ranks times the threads of a run.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    /// End by then, runs with a checkpoint and the sweep with code 4, counted from its start: [days-]hours:minutes:seconds.
    #[arg(long, value_name = "TIME", value_parser = stop::time_limit)]
    pub(super) time_limit: Option<Duration>,
    /// Print the rows and how far they are; start nothing.
    #[arg(long)]
    list: bool,
}

/// What the job of a row begins with.
const HEAD: &str = "# Row of a sweep: ";
/// Refusals that are told at once.
const TOLD_MOST: usize = 10;

/// `begun`: when the program was started.
pub(super) fn command(wanted: &Sweep, begun: Instant) -> Result<Outcome, Error> {
    if is_launched() {
        return Err(Error::User(
            "scree sweep starts its runs itself, under mpirun with --ranks. Start it without mpirun or srun."
                .to_string(),
        ));
    }
    let rows = Rows::of(&wanted.vary, wanted.rows.as_deref())?;
    let (out, jobs) = resolved(wanted, &rows)?;
    let table: Vec<PathBuf> = [Some(out.join(TABLE)), wanted.table.clone()].into_iter().flatten().collect();
    table.iter().try_for_each(|table| sweep::refuse_other(table))?;
    let lines = rows.all.iter().map(|row| line(&out, row)).collect();
    if wanted.list {
        return Ok(Outcome::Done(listed(&out, &rows, lines)));
    }
    begin(&out, &rows, &jobs)?;
    let team = Team {
        ranks: wanted.ranks.into(),
        threads: wanted.threads.into(),
        runs: wanted
            .jobs
            .map_or_else(|| (cores() / (usize::from(wanted.ranks) * usize::from(wanted.threads))).max(1), usize::from),
        deadline: wanted.time_limit.map(|limit| begun + limit),
    };
    let write = |lines: &[Line]| table.iter().try_for_each(|path| sweep::write(path, &rows.keys, lines));
    let mut work = Work::new(team, &out, lines)?;
    write(work.lines())?;
    work.all(&write)?;
    ended(&out, work.lines())
}

/// The folder of the sweep, and every row's job, written out. All of it is refused before anything is begun.
fn resolved(wanted: &Sweep, rows: &Rows) -> Result<(PathBuf, Vec<String>), Error> {
    let load = |row: &Row| {
        let (job, typed) = Job::load_typed(&wanted.job, &[&wanted.set[..], &rows.sets(row)].concat())?;
        refuse_bad_grains(&job, &typed)?;
        Ok::<Job, Error>(job)
    };
    let (mut jobs, mut refused) = (Vec::new(), Vec::new());
    for (index, row) in rows.all.iter().enumerate() {
        match load(row) {
            Ok(job) => jobs.push(job),
            Err(error) => refused.push(format!("row {} ({}): {error}", index + 1, rows.sets(row).join(", "))),
        }
    }
    if let [first, ..] = refused.as_slice() {
        let alike = refused.len() == rows.all.len();
        let told = if alike { std::slice::from_ref(first) } else { &refused[..refused.len().min(TOLD_MOST)] };
        let rest = refused.len() - told.len();
        let rest = if rest > 0 { format!("\nand {rest} more.") } else { String::new() };
        return Err(Error::User(format!(
            "{} of {} rows of the sweep cannot be run; none was started.\n{}{rest}",
            refused.len(),
            rows.all.len(),
            told.join("\n")
        )));
    }
    let own = || Path::new("runs").join(format!("{}_sweep", jobs[0].name()));
    let out = settled(&wanted.out.clone().unwrap_or_else(own))?;
    let mut told = Vec::new();
    for (job, row) in jobs.iter().zip(&rows.all) {
        let text = job.to_toml();
        if opening(&out.join(&row.name), &text)? != Opening::GoOn {
            // What is to be said of every row is said once.
            let new: Vec<String> = doubts(job).into_iter().filter(|doubt| !told.contains(doubt)).collect();
            new.iter().filter(|_| !wanted.list).for_each(|doubt| tracing::warn!("warning: {doubt}"));
            told.extend(new);
        }
    }
    Ok((out, jobs.iter().map(Job::to_toml).collect()))
}

/// Makes the folder, with the job of every row.
fn begin(out: &Path, rows: &Rows, jobs: &[String]) -> Result<(), Error> {
    fs::create_dir_all(out).map_err(|error| unwritable(out, &error))?;
    for (row, job) in rows.all.iter().zip(jobs) {
        let path = out.join(format!("{}.toml", row.name));
        let text = format!("{HEAD}{}\n{job}", rows.sets(row).join(", "));
        match fs::read_to_string(&path) {
            Ok(there) if there == text => continue,
            Ok(there) if !there.starts_with(HEAD) => {
                return Err(Error::User(format!(
                    "{} is there already and is no job of a sweep, so it is not replaced. Give another folder with --out, or move it away.",
                    path.display()
                )));
            }
            _ => replace(&path, text.as_bytes())?,
        }
    }
    Ok(())
}

/// What the folder tells of a row.
fn line(out: &Path, row: &Row) -> Line {
    let (run, values) = (row.name.clone(), row.values.clone());
    standing(Line { run, values, state: State::Waiting, cause: String::new(), figures: Vec::new() }, out)
}

/// The line as its folder has it now.
fn standing(line: Line, out: &Path) -> Line {
    let run = out.join(&line.run);
    let state = match (is_done(&run), run.join("scenario.toml").exists()) {
        (true, _) => State::Done,
        _ if is_held(&run) => State::Running,
        (false, true) => State::Stopped,
        (false, false) => State::Waiting,
    };
    let line = Line { state, ..line };
    if state == State::Done { with_figures(line, out) } else { line }
}

/// With what came out of its run.
fn with_figures(line: Line, out: &Path) -> Line {
    match sweep::figures(&out.join(&line.run)) {
        Ok(figures) => Line { figures, ..line },
        Err(error) => Line { cause: format!("no figures: {error}"), ..line },
    }
}

fn listed(out: &Path, rows: &Rows, lines: Vec<Line>) -> String {
    let mut text = format!("{} rows in {}:\n", lines.len(), out.display());
    for (index, (line, row)) in lines.iter().zip(&rows.all).enumerate() {
        writeln!(text, "{:>6}  {:<8} {}", index + 1, line.state.word(), rows.sets(row).join(", ")).expect(STRING);
    }
    text
}

const STRING: &str = "a string takes every line";

/// Last words, and how the sweep ended: a failure is one that comes again, what was stopped goes on.
fn ended(out: &Path, lines: &[Line]) -> Result<Outcome, Error> {
    let count = |state: State| lines.iter().filter(|line| line.state == state).count();
    let (done, failed) = (count(State::Done), count(State::Failed));
    let open = lines.len() - done - failed;
    let mut text = format!("{done} of {} runs are done", lines.len());
    if failed > 0 {
        write!(text, ", {failed} failed").expect(STRING);
    }
    if open > 0 {
        write!(text, ", {open} are still to be done").expect(STRING);
    }
    let shown = out.display();
    writeln!(text, ". The table is {shown}/{TABLE}; `scree report {shown}` draws them.").expect(STRING);
    for line in lines.iter().filter(|line| line.state == State::Failed).take(TOLD_MOST) {
        writeln!(text, "{}: {}", line.run, line.cause).expect(STRING);
    }
    if open > 0 {
        text.push_str("Type the same line again to go on.\n");
        return Ok(Outcome::Stopped(text));
    }
    match failed {
        0 => Ok(Outcome::Done(text)),
        _ => Err(Error::Run(format!(
            "{text}What the runs said is in {shown}/NAME.log. Mend the cause and type the same line again: it tries them again, and leaves those alone that are done."
        ))),
    }
}
