//! The command line: one file per subcommand, and what they share: ranks, threads, one voice, one exit code.
//!
//! Exit codes: 0 done; 2 the operator's mistake; 3 the run stopped itself; 4 stopped on request.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Once, Weak};
use std::time::{Duration, Instant};

use clap::{CommandFactory, Parser, Subcommand};
use scree_partition::transport::{Solo, Transport};

use self::cores::Placement;
use crate::base::error::Error;
use crate::base::program;
use crate::domain::stop;
use crate::export::grain_export::Wanted;
use crate::job::{Job, reference, templates};
use crate::plot::report;
use crate::run::Outcome;
use crate::run::start::Continuation;

mod bench;
mod calibrate;
mod check;
mod cores;
mod digest;
mod export;
mod launch;
mod plan;
mod resume;
mod run;
mod sweep;

/// The operator's mistake.
const CODE_REFUSED: u8 = 2;
/// The run stopped itself, or the program has a defect.
const CODE_FAILED: u8 = 3;
/// Stopped on request.
const CODE_STOPPED: u8 = 4;
/// A rank that fails lets the ranks below it speak first, in case that they fail alike: the first above rank 0 waits so
/// long, the last so long.
const PATIENCE_LEAST: Duration = Duration::from_secs(1);
const PATIENCE_MOST: Duration = Duration::from_secs(4);
/// Who speaks ends the others: mpirun sends them SIGTERM within some tenths of a second, and SIGKILL a second later. A rank
/// that hears the first waits so long for the second, and speaks only if that does not come.
const PATIENCE_WHEN_ASKED: Duration = Duration::from_secs(4);
/// One of these is set when a launcher started this process as one of several ranks.
const LAUNCHER_VARIABLES: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"];
/// The number of this rank, by the same launchers.
const RANK_VARIABLES: [&str; 3] = ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"];

/// What velocities an export may have, as `[time] velocities` of a job calls them.
const VELOCITIES: [&str; 2] = ["half_step_before", "now"];

/// Granular matter under mpirun: grains, continuum, and the two coupled where shear localises.
#[derive(Parser)]
#[command(version = program::short_version(), long_version = program::version(), arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Read a job, refuse what is wrong with it and print what follows from it; start nothing.
    Check {
        /// The job, a TOML file.
        job: PathBuf,
        /// Override one key, for example --set loading.speed="5 cm/s". May be repeated.
        #[arg(long, value_name = "KEY.PATH=VALUE")]
        set: Vec<String>,
        /// Threads that each rank is going to have, to be told what that means here and how long it takes.
        #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
        /// Leave out what takes seconds: of a hybrid, element tests of its grains, which its continuum is held against; their packings are kept in packing.cache.
        #[arg(long)]
        quick: bool,
        /// Print the job written out instead: SI numbers, every default, and what planar shear means as a job on a grid.
        #[arg(long)]
        expand: bool,
    },
    /// Print a job to begin with: small, explained key by key, and ready to run.
    New {
        /// What it shows. dem, mpm, hybrid: planar shear of grains, of a continuum, of both; element: biaxial compression of a
        /// periodic cell of grains; pour: spheres under gravity; continuum: collapse of a column of sand.
        method: String,
    },
    /// Tell the tables of jobs and their keys: what they mean, units, ranges and defaults.
    Keys {
        /// A table or a key, for example contact, body.servo, friction or contact.friction; none: a list of all tables.
        table: Option<String>,
    },
    /// Print a JSON Schema of jobs, for editors.
    Schema,
    /// Print the completions of a shell: bash, zsh, fish, elvish or powershell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    Man,
    /// Run a job.
    Run {
        /// The job, a TOML file.
        job: PathBuf,
        /// Folder of the run; it must not hold a run yet. Default: runs/<job name>.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Go on where DIR holds a run of this job already, start it where it does not: one line for a batch job that is
        /// put into the queue again.
        #[arg(long = "continue")]
        go_on: bool,
        /// Threads of each rank. Default: the cores of this machine over the ranks on it.
        #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
        /// Override one key, for example --set method=dem. May be repeated.
        #[arg(long, value_name = "KEY.PATH=VALUE")]
        set: Vec<String>,
        /// End by then with a checkpoint and code 4, counted from the start of the program and in time to have written it:
        /// [days-]hours:minutes:seconds.
        #[arg(long, value_name = "TIME", value_parser = stop::time_limit)]
        time_limit: Option<Duration>,
    },
    /// Restart: go on from the newest good checkpoint of a run, on any number of ranks and threads.
    Resume {
        /// Folder of the run.
        dir: PathBuf,
        /// Threads of each rank. Default: the cores of this machine over the ranks on it.
        #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
        /// Go on with another end or other outputs, for example --set time.end="2 s" (of planar shear --set
        /// loading.strain_end=0.2) or --set output.frame_interval="1 ms". May be repeated.
        #[arg(long, value_name = "KEY.PATH=VALUE")]
        set: Vec<String>,
        /// Start a new run in this folder from the state of the old one, whatever --set changes; the old one is left as it is.
        #[arg(long, value_name = "NEW_DIR")]
        force_branch: Option<PathBuf>,
        /// End by then with a checkpoint and code 4, counted from the start of the program and in time to have written it:
        /// [days-]hours:minutes:seconds.
        #[arg(long, value_name = "TIME", value_parser = stop::time_limit)]
        time_limit: Option<Duration>,
    },
    /// Run a job with many values, several runs at a time, and write a table of what came out. The same line goes on with it.
    Sweep(sweep::Sweep),
    /// Measure how fast this machine is.
    Bench {
        #[command(subcommand)]
        what: bench::Bench,
    },
    /// Find the material parameters of a job's continuum by simulated element tests of its own grains.
    Calibrate(calibrate::Calibrate),
    /// Foresee time, efficiency and memory on other numbers of ranks, from what a run has measured and a network.
    Plan(plan::Plan),
    /// Print a hash of the complete state, equal for equal states however many ranks wrote them.
    Digest {
        /// Folder of a run (its newest checkpoint), or one checkpoint.
        path: PathBuf,
    },
    /// Write one HTML page with the curves and pictures of a run, or of several to compare them.
    Report {
        /// Folders of runs.
        #[arg(required = true, value_name = "DIR")]
        dirs: Vec<PathBuf>,
        /// The page. Default: report.html in the first folder.
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// The strains that incremental strain and the band are measured between; horizontal ones of planar shear, and where a body
        /// presses its way over the height of the material or its own breadth, which stresses are compared between, too. Default:
        /// 0.37,0.57 or 0.055,0.085, of shorter runs the same share of what they have in common.
        #[arg(long, value_name = "FROM,TO", value_parser = report::strains)]
        between: Option<[f64; 2]>,
    },
    /// Write the grains of a checkpoint as CSV or as a LAMMPS data file, its contacts, or the grains of frames as a LAMMPS dump, with
    /// 17 significant digits. One of --grains, --contacts and --lammps-dump is needed.
    Export {
        /// Folder of the run.
        dir: PathBuf,
        /// The file of grains to write: comma-separated values (.csv) or a LAMMPS data file (.data, .lmp).
        #[arg(long, value_name = "FILE")]
        grains: Option<PathBuf>,
        /// The CSV file of contacts to write: lower and higher id (or a body's name), normal and tangential force, the law's memory.
        #[arg(long, value_name = "FILE")]
        contacts: Option<PathBuf>,
        /// The LAMMPS text dump to write, for OVITO and others: the grains of the run's last frame.
        #[arg(long, value_name = "FILE")]
        lammps_dump: Option<PathBuf>,
        /// The folder to write all frames into as .vtu files with a .pvd, for ParaView before 5.12; with --at one of them.
        #[arg(long, value_name = "DIR")]
        vtu: Option<PathBuf>,
        /// The file of frames to write (.vtkhdf) with the grains of the RVE of the point --rve; its force chains go beside it.
        #[arg(long, value_name = "FILE", requires = "rve")]
        rve_frame: Option<PathBuf>,
        /// A point of method = "mpm_dem": its name in [[follow]], or its id.
        #[arg(long, value_name = "POINT", requires = "rve_frame")]
        rve: Option<String>,
        /// Write all frames into the dump.
        #[arg(long, requires = "lammps_dump", conflicts_with = "at")]
        all: bool,
        /// The checkpoint, and of a dump or of --vtu the frame, of this time, for example 0, 0.02 or "20 ms". Default: the newest.
        #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
        at: Option<String>,
        /// The time of the velocities: that of the positions, or half a step before as the run keeps them.
        #[arg(long, value_parser = VELOCITIES, default_value = VELOCITIES[0], requires = "grains")]
        velocities: String,
        /// Write the forces and torques of the grains' contacts as well (.csv).
        #[arg(long, requires = "grains")]
        forces: bool,
        /// Write over files that are there already.
        #[arg(long)]
        overwrite: bool,
    },
}

impl Command {
    /// Whether it ends in its own time when it is asked to, with what it has done so far kept.
    fn takes_steps(&self) -> bool {
        matches!(self, Self::Run { .. } | Self::Resume { .. } | Self::Calibrate(_))
    }
}

/// The whole program.
pub fn main() -> ExitCode {
    let begun = Instant::now();
    // Before MPI, which takes half a second to start.
    let listens = stop::keep_wishes();
    let arguments = Arguments::parse();
    let listens = if arguments.command.takes_steps() { listens.and_then(|()| stop::listen()) } else { listens };
    if let Err(error) = listens {
        complain(&error);
        return ExitCode::from(error.exit_code());
    }
    let transport = match start_transport() {
        Ok(transport) => transport,
        Err(error) => {
            if number_in_environment(&RANK_VARIABLES).unwrap_or(0) == 0 {
                complain(&error);
            }
            return ExitCode::from(error.exit_code());
        }
    };
    end_all_ranks_on_panic(&transport);
    if transport.rank() == 0 {
        show_events();
    }
    ExitCode::from(dispatch(arguments.command, begun, &*transport))
}

/// Sets the time by which the program, begun then, must have ended.
fn end_by(begun: Instant, limit: Option<Duration>) {
    if let Some(limit) = limit {
        stop::end_by(begun + limit);
    }
}

fn dispatch(command: Command, begun: Instant, transport: &dyn Transport) -> u8 {
    match command {
        Command::Run { job, out, go_on, threads, set, time_limit } => {
            end_by(begun, time_limit);
            let wanted = run::Wanted { job: &job, out, go_on, sets: &set };
            finish(run::command(&wanted, &Placement::of(transport, threads), transport), transport)
        }
        Command::Resume { dir, threads, set, force_branch, time_limit } => {
            end_by(begun, time_limit);
            let continuation = Continuation { sets: &set, branch: force_branch.as_deref() };
            finish(resume::command(&dir, continuation, &Placement::of(transport, threads), transport), transport)
        }
        Command::Sweep(wanted) => {
            end_by(begun, wanted.time_limit);
            finish(Ending::Agreed(sweep::command(&wanted, begun)), transport)
        }
        Command::Bench { what } => finish(bench::command(&what, transport), transport),
        Command::Check { job, set, expand: true, .. } => {
            on_rank_zero(transport, || Ok(Job::load(&job, &set)?.expanded()))
        }
        Command::Check { job, set, threads, quick, expand: false } => {
            let placement = Placement::of(transport, threads);
            on_rank_zero(transport, || {
                start_threads(placement.threads)?;
                Ok(check::command((&job, &set), !quick)? + &check::placed(&placement))
            })
        }
        Command::Calibrate(typed) => {
            let placement = Placement::of(transport, typed.threads);
            on_rank_zero(transport, || calibrate::command(&typed, &placement, transport))
        }
        alone => on_rank_zero(transport, || match alone {
            Command::New { method } => templates::job(&method),
            Command::Keys { table } => reference::page(table.as_deref()),
            Command::Schema => Ok(format!("{:#}\n", reference::json_schema())),
            Command::Completions { shell } => {
                let mut written = Vec::new();
                clap_complete::generate(shell, &mut Arguments::command(), "scree", &mut written);
                Ok(String::from_utf8_lossy(&written).into_owned())
            }
            Command::Man => {
                let mut written = Vec::new();
                let made = clap_mangen::Man::new(Arguments::command()).render(&mut written);
                made.map_err(|error| Error::Run(format!("The manual page cannot be made: {error}.")))?;
                Ok(String::from_utf8_lossy(&written).into_owned())
            }
            Command::Digest { path } => digest::command(&path),
            Command::Plan(plan) => plan::command(&plan),
            Command::Report { dirs, out, between } => {
                let page = report::write(&dirs, out.as_deref(), between)?;
                Ok(format!("The report is {}\n", page.display()))
            }
            Command::Export {
                dir,
                grains,
                contacts,
                lammps_dump,
                vtu,
                rve_frame,
                rve,
                all,
                at,
                velocities,
                forces,
                overwrite,
            } => {
                let wanted = Wanted { velocities_now: velocities == VELOCITIES[1], forces };
                let files = export::Files {
                    grains: grains.as_deref(),
                    contacts: contacts.as_deref(),
                    dump: lammps_dump.as_deref(),
                    vtu: vtu.as_deref(),
                    rve: rve.as_deref().zip(rve_frame.as_deref()),
                    overwrite,
                };
                export::command(&dir, &files, (at.as_deref(), all), wanted)
            }
            Command::Run { .. }
            | Command::Resume { .. }
            | Command::Sweep(_)
            | Command::Bench { .. }
            | Command::Check { .. }
            | Command::Calibrate(_) => unreachable!("they are dispatched above"),
        }),
    }
}

/// How a run ended on this rank.
enum Ending {
    /// Every rank knows that this is how it ended.
    Agreed(Result<Outcome, Error>),
    /// This rank failed and cannot know about the others.
    Failed(Error),
}

fn finish(ending: Ending, transport: &dyn Transport) -> u8 {
    let first = transport.rank() == 0;
    match ending {
        Ending::Agreed(Ok(Outcome::Done(closing))) => {
            if first {
                say(&with_newline(closing));
            }
            0
        }
        Ending::Agreed(Ok(Outcome::Stopped(closing))) => {
            if first {
                say(&with_newline(closing));
            }
            CODE_STOPPED
        }
        Ending::Agreed(Err(error)) => {
            if first {
                complain(&error);
            }
            error.exit_code()
        }
        Ending::Failed(error) => {
            wait_for_others(patience(transport.rank(), transport.size()));
            complain(&error);
            transport.abort(i32::from(error.exit_code()))
        }
    }
}

/// What needs no company: rank 0 does it, and all ranks leave with its exit code.
fn on_rank_zero(transport: &dyn Transport, work: impl FnOnce() -> Result<String, Error>) -> u8 {
    let code = match transport.rank() {
        0 => match work() {
            Ok(text) => {
                say(&text);
                0
            }
            Err(error) => {
                complain(&error);
                error.exit_code()
            }
        },
        _ => 0,
    };
    transport.broadcast(vec![code])[0]
}

/// Rank 0 does it, and every rank gets its text or its error.
fn agreed(transport: &dyn Transport, work: impl FnOnce() -> Result<String, Error>) -> Result<String, Error> {
    let mine = match transport.rank() {
        0 => match work() {
            Ok(text) => tagged(0, &text),
            Err(error) => tagged(error.exit_code(), &error.to_string()),
        },
        _ => Vec::new(),
    };
    let theirs = transport.broadcast(mine);
    let (code, text) = theirs.split_first().expect("a broadcast keeps its tag");
    let text = String::from_utf8_lossy(text).into_owned();
    match *code {
        0 => Ok(text),
        CODE_FAILED => Err(Error::Run(text)),
        _ => Err(Error::User(text)),
    }
}

fn tagged(code: u8, text: &str) -> Vec<u8> {
    let mut bytes = vec![code];
    bytes.extend_from_slice(text.as_bytes());
    bytes
}

/// Ranks under a launcher, one rank otherwise.
fn start_transport() -> Result<Arc<dyn Transport>, Error> {
    let launched = LAUNCHER_VARIABLES.iter().any(|variable| std::env::var_os(variable).is_some());
    if !launched {
        return Ok(Arc::new(Solo));
    }
    start_mpi()
}

#[cfg(feature = "mpi")]
fn start_mpi() -> Result<Arc<dyn Transport>, Error> {
    Ok(Arc::new(scree_partition::transport::Mpi::start()))
}

/// Several processes that know nothing of each other would each do the whole run into the same folder.
#[cfg(not(feature = "mpi"))]
fn start_mpi() -> Result<Arc<dyn Transport>, Error> {
    match number_in_environment(&LAUNCHER_VARIABLES[..1]) {
        Some(1) => Ok(Arc::new(Solo)),
        _ => Err(Error::User(
            "This scree was built without MPI and cannot be one rank of several. Build it with default features, or start it without mpirun and use --threads.".to_string(),
        )),
    }
}

/// What happens on the way, as plain lines on stderr.
fn show_events() {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        // It would tell so by a macro that panics.
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal())
        .with_max_level(tracing::Level::INFO)
        .with_target(false)
        .with_level(false)
        .without_time()
        .init();
}

/// A panic is a defect of the program: say so once, and end every rank, since the others would wait for ever.
fn end_all_ranks_on_panic(transport: &Arc<dyn Transport>) {
    let (rank, patience) = (transport.rank(), patience(transport.rank(), transport.size()));
    let transport: Weak<dyn Transport> = Arc::downgrade(transport);
    let speaker = Once::new();
    std::panic::set_hook(Box::new(move |panic| {
        speaker.call_once(|| {
            wait_for_others(patience);
            let backtrace = Backtrace::capture();
            let trace = match backtrace.status() {
                BacktraceStatus::Captured => format!("\n{backtrace}"),
                _ => String::new(),
            };
            // Nothing is left to tell it to if stderr is gone.
            let _ = writeln!(
                std::io::stderr().lock(),
                "scree stopped because of a defect in the program, on rank {rank}: {panic}\nCheckpoints already written are not touched: `scree resume DIR` goes on from the last. Please report these lines.{trace}"
            );
            match transport.upgrade() {
                Some(transport) => transport.abort(i32::from(CODE_FAILED)),
                None => std::process::exit(i32::from(CODE_FAILED)),
            }
        });
    }));
}

/// How long a rank that fails waits for those below it to say so first. They need not have failed, and ranks cannot ask
/// each other, for those that have not failed wait for a message of the run.
fn patience(rank: usize, size: usize) -> Duration {
    match rank {
        0 => Duration::ZERO,
        _ => PATIENCE_LEAST + (PATIENCE_MOST - PATIENCE_LEAST) * (rank as u32 - 1) / (size as u32 - 1).max(1),
    }
}

/// Waits so long, and longer once the rank is asked to end meanwhile: then most likely another has spoken.
fn wait_for_others(patience: Duration) {
    let asked_before = stop::wanted();
    let mut end = Instant::now() + patience;
    let mut asked = false;
    while Instant::now() < end {
        std::thread::sleep(Duration::from_millis(10));
        if !asked && !asked_before && stop::wanted() {
            asked = true;
            end = Instant::now() + PATIENCE_WHEN_ASKED;
        }
    }
}

/// The first of some variables that holds a number.
fn number_in_environment(variables: &[&str]) -> Option<usize> {
    variables.iter().find_map(|variable| std::env::var(variable).ok()?.parse().ok())
}

/// The same with the words of who runs where, which rank 0 says.
fn start_threads_of(placement: &Placement) -> Result<(), Error> {
    // Only rank 0 has somebody to listen.
    tracing::info!("{}", placement.words);
    placement.warnings.iter().for_each(|warning| tracing::warn!("warning: {warning}"));
    start_threads(placement.threads)
}

/// The pool that every parallel loop of this rank uses. The main thread, which alone speaks to MPI, is one of them, so
/// that a rank of one thread starts no other.
fn start_threads(threads: usize) -> Result<(), Error> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .use_current_thread()
        .thread_name(|index| format!("scree-{index}"))
        .build_global()
        .map_err(|error| {
            Error::Run(format!("{threads} threads could not be started: {error}. Ask for fewer with --threads."))
        })
}

/// A text that ends its line; nothing stays nothing, since what ranks of its own have said last must stay last.
fn with_newline(mut text: String) -> String {
    if !text.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    text
}

/// To stdout. A reader that has gone away, as in `scree check job.toml | head`, is no error.
fn say(text: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = stdout.write_all(text.as_bytes());
    let _ = stdout.flush();
}

fn complain(error: &Error) {
    let mut stderr = std::io::stderr().lock();
    let _ = writeln!(stderr, "{error}");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lowest speaks first, and an end comes within seconds however many ranks there are.
    #[test]
    fn failing_ranks_speak_in_their_order() {
        assert_eq!(patience(0, 1), Duration::ZERO);
        for size in [2, 4, 1000] {
            let waits: Vec<Duration> = (0..size).map(|rank| patience(rank, size)).collect();
            assert!(waits.windows(2).all(|pair| pair[0] < pair[1]), "{waits:?}");
            assert!(waits[1] == PATIENCE_LEAST && waits.iter().all(|wait| *wait <= PATIENCE_MOST));
        }
    }
}
