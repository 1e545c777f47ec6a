//! Runs of a sweep as processes, so many at a time. A run that fails, or is killed, ends no other.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::{standing, with_figures};
use crate::analysis::sweep::{Line, State};
use crate::base::error::Error;
use crate::cli::launch::Launcher;
use crate::cli::{CODE_REFUSED, CODE_STOPPED};
use crate::domain::stop::{self, Wish};
use crate::run::folder::is_held;
use crate::run::output::is_done;
use crate::run::results::unwritable;

/// Between two looks at the runs.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// The same at runs of another sweep.
const LOOK_AT_OTHERS: Duration = Duration::from_secs(1);
/// A run that is begun so shortly before the end would only be stopped.
const TOO_LATE: Duration = Duration::from_secs(5);
/// Letters of a cause in the table.
const CAUSE_MAX: usize = 400;
/// Bytes at the end of a log that are looked through for it.
const TAIL: u64 = 16_384;
/// mpirun's own words on a rank that ended stand behind a rule of these.
const RULE: &str = "--------------------";
/// What does not begin because somebody else had its folder for a moment is tried once more.
const TRIES: u8 = 2;

/// What each run is started with.
pub(super) struct Team {
    pub ranks: usize,
    pub threads: usize,
    /// At a time.
    pub runs: usize,
    /// By then the sweep has ended.
    pub deadline: Option<Instant>,
}

/// A row whose run is going on.
struct Going {
    row: usize,
    child: Child,
    log: PathBuf,
    /// Bytes of its log before it began.
    said: u64,
    begun: Instant,
    /// It has been told to stop.
    told: bool,
}

/// All rows, and those that are going on.
pub(super) struct Work<'a> {
    team: Team,
    out: &'a Path,
    program: PathBuf,
    launcher: Option<Launcher>,
    lines: Vec<Line>,
    tries: Vec<u8>,
    /// Rows to begin, in order.
    open: VecDeque<usize>,
    /// Rows whose folder another process holds.
    others: VecDeque<usize>,
    going: Vec<Going>,
}

impl<'a> Work<'a> {
    pub fn new(team: Team, out: &'a Path, lines: Vec<Line>) -> Result<Self, Error> {
        stop::listen()?;
        let program = std::env::current_exe().map_err(|error| Error::Run(format!("where is this program? {error}")))?;
        let launcher = if team.ranks > 1 { Some(Launcher::find()?) } else { None };
        let open = (0..lines.len()).filter(|row| lines[*row].state != State::Done).collect();
        let (tries, others, going) = (vec![0; lines.len()], VecDeque::new(), Vec::new());
        Ok(Self { team, out, program, launcher, lines, tries, open, others, going })
    }

    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Runs every row that is not done, or until the sweep is told to stop; `write` is given the lines whenever one has ended.
    pub fn all(&mut self, write: &dyn Fn(&[Line]) -> Result<(), Error>) -> Result<(), Error> {
        tracing::info!(
            "{} runs to do, {} done before, {} at a time in {}",
            self.open.len(),
            self.lines.len() - self.open.len(),
            self.team.runs,
            self.out.display()
        );
        let mut written = Ok(());
        loop {
            let stops = self.is_to_stop() || written.is_err();
            self.pass_on(stops);
            // Whoever cannot begin a run or write the table any more lets its runs stop first.
            match self.turn(stops) {
                Ok(true) => written = written.and(write(&self.lines)),
                Ok(false) => {}
                Err(error) => written = written.and(Err(error)),
            }
            if self.going.is_empty() && (stops || self.open.is_empty()) {
                if stops || self.others.is_empty() {
                    self.read_again();
                    return written.and(write(&self.lines));
                }
                self.look_at_others();
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Begins runs where there is room, and takes note of those that have ended; whether any line has changed.
    fn turn(&mut self, stops: bool) -> Result<bool, Error> {
        let mut changed = self.reap()?;
        while !stops && self.going.len() < self.team.runs && self.begin_next()? {
            changed = true;
        }
        Ok(changed)
    }

    /// What other sweeps have done meanwhile.
    fn read_again(&mut self) {
        for row in 0..self.lines.len() {
            if matches!(self.lines[row].state, State::Waiting | State::Running) {
                self.lines[row] = standing(self.lines[row].clone(), self.out);
            }
        }
    }

    fn is_to_stop(&self) -> bool {
        stop::wanted() || self.team.deadline.is_some_and(|deadline| Instant::now() + TOO_LATE >= deadline)
    }

    /// A wish of the operator goes to every run. Of SIGTERM mpirun would make an end within a second; SIGUSR2 it hands on.
    fn pass_on(&mut self, stops: bool) {
        let saves = stop::wish() == Wish::Save;
        for going in &mut self.going {
            if saves {
                signal(&going.child, "USR1");
            }
            if stops && !std::mem::replace(&mut going.told, true) {
                signal(&going.child, "USR2");
            }
        }
        if saves {
            stop::saved();
        }
    }

    /// Begins the next open row; whether there was one.
    fn begin_next(&mut self) -> Result<bool, Error> {
        let Some(row) = self.open.pop_front() else { return Ok(false) };
        let run = self.out.join(&self.lines[row].run);
        if is_held(&run) {
            self.lines[row].state = State::Running;
            self.others.push_back(row);
            return Ok(true);
        }
        // Another sweep may have done it meanwhile.
        if is_done(&run) {
            self.end(row, State::Done, String::new());
            return Ok(true);
        }
        let going = self.start(row, &run)?;
        self.tries[row] += 1;
        self.lines[row].state = State::Running;
        tracing::info!("row {} of {}, {}: begins", row + 1, self.lines.len(), self.lines[row].run);
        self.going.push(going);
        Ok(true)
    }

    fn start(&self, row: usize, run: &Path) -> Result<Going, Error> {
        let beside = |ending: &str| self.out.join(format!("{}.{ending}", self.lines[row].run));
        let (job, log) = (beside("toml"), beside("log"));
        let open = || OpenOptions::new().create(true).append(true).open(&log);
        let file = open().map_err(|error| unwritable(&log, &error))?;
        let said = file.metadata().map_or(0, |about| about.len());
        let err = file.try_clone().map_err(|error| unwritable(&log, &error))?;
        let mut command = match &self.launcher {
            Some(launcher) => launcher.command_among_others(self.team.ranks, &self.program),
            None => Command::new(&self.program),
        };
        command.arg("run").arg(job).arg("--out").arg(run).arg("--continue");
        command.args(["--threads", &self.team.threads.to_string()]);
        if let Some(deadline) = self.team.deadline {
            let left = deadline.saturating_duration_since(Instant::now()).as_secs();
            command.args(["--time-limit", &format!("{}:{:02}:{:02}", left / 3600, left / 60 % 60, left % 60)]);
        }
        // A group of its own: Ctrl-C is for the sweep, which asks its runs to stop.
        command.stdin(Stdio::null()).stdout(file).stderr(err).process_group(0);
        let child = command.spawn().map_err(|error| Error::Run(format!("{command:?} cannot be started: {error}")))?;
        Ok(Going { row, child, log, said, begun: Instant::now(), told: false })
    }

    /// Takes note of the runs that have ended; whether any has.
    fn reap(&mut self) -> Result<bool, Error> {
        let mut ended = Vec::new();
        for (index, going) in self.going.iter_mut().enumerate() {
            let asked = going.child.try_wait();
            let asked = asked.map_err(|error| Error::Run(format!("a run cannot be waited for: {error}")))?;
            ended.extend(asked.map(|status| (index, status)));
        }
        for (index, status) in ended.iter().rev() {
            let going = self.going.remove(*index);
            self.note(&going, *status);
        }
        Ok(!ended.is_empty())
    }

    fn note(&mut self, going: &Going, status: ExitStatus) {
        let run = self.out.join(&self.lines[going.row].run);
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        let (state, cause) = match code {
            Some(0) => (State::Done, String::new()),
            Some(CODE_STOPPED) => (State::Stopped, String::new()),
            // It was told to stop and was ended before it could, by mpirun or the batch system: the same line goes on with it.
            _ if going.told => (State::Stopped, String::new()),
            Some(CODE_REFUSED) if is_held(&run) => {
                self.lines[going.row].state = State::Running;
                self.others.push_back(going.row);
                return;
            }
            Some(CODE_REFUSED) if self.tries[going.row] < TRIES => {
                self.lines[going.row].state = State::Waiting;
                self.open.push_back(going.row);
                return;
            }
            _ => (State::Failed, cause(&going.log, going.said, status)),
        };
        tracing::info!(
            "row {} of {}, {}: {} after {:.1} s{}",
            going.row + 1,
            self.lines.len(),
            self.lines[going.row].run,
            state.word(),
            going.begun.elapsed().as_secs_f64(),
            if cause.is_empty() { String::new() } else { format!(": {cause}") }
        );
        self.end(going.row, state, cause);
    }

    fn end(&mut self, row: usize, state: State, cause: String) {
        let line = Line { state, cause, ..self.lines[row].clone() };
        self.lines[row] = if state == State::Done { with_figures(line, self.out) } else { line };
    }

    /// Rows of others that are free again are done, or are ours.
    fn look_at_others(&mut self) {
        std::thread::sleep(LOOK_AT_OTHERS);
        for _ in 0..self.others.len() {
            let Some(row) = self.others.pop_front() else { return };
            let held = is_held(&self.out.join(&self.lines[row].run));
            if held { self.others.push_back(row) } else { self.open.push_back(row) }
        }
    }
}

/// What a process that has ended already does not hear is no loss.
fn signal(child: &Child, name: &str) {
    let _ = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).stderr(Stdio::null()).status();
}

/// The last thing that a run said since `said` bytes of its log, before mpirun's own words.
fn cause(log: &Path, said: u64, status: ExitStatus) -> String {
    let read = || {
        let mut file = File::open(log)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(said.max(length.saturating_sub(TAIL))))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map(|_| String::from_utf8_lossy(&bytes).into_owned())
    };
    let text = read().unwrap_or_default();
    let own = text.lines().take_while(|line| !line.starts_with(RULE));
    let last = own.filter(|line| !line.trim().is_empty()).last().unwrap_or_default();
    match last.is_empty() {
        true => format!("it ended with {status} and said nothing"),
        false => last.chars().take(CAUSE_MAX).collect(),
    }
}
