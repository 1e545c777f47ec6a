//! How mpirun is called: by whom, with which options, on how many cores.

use std::ffi::OsStr;
use std::process::Command;

use super::LAUNCHER_VARIABLES;
use crate::base::error::Error;

/// Open MPI starts ranks for root only where both of these are 1.
const ROOT_VARIABLES: [&str; 2] = ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"];

/// The mpirun of this machine, which may be started.
pub(super) struct Launcher {
    is_open_mpi: bool,
    pub cores: usize,
}

impl Launcher {
    /// Refuses where no ranks could be started.
    pub fn find() -> Result<Self, Error> {
        let version = Command::new("mpirun").arg("--version").output().map_err(|error| {
            Error::User(format!("mpirun cannot be started ({error}); install Open MPI, or ask for --ranks 1"))
        })?;
        let is_open_mpi = String::from_utf8_lossy(&version.stdout).contains("Open MPI");
        let allowed =
            ROOT_VARIABLES.iter().all(|variable| std::env::var_os(variable).is_some_and(|value| value == "1"));
        if is_open_mpi && is_root() && !allowed {
            return Err(Error::User(format!(
                "mpirun does not start ranks for root. Be another user, or set {}=1 {}=1 where nobody else's files are at stake.",
                ROOT_VARIABLES[0], ROOT_VARIABLES[1]
            )));
        }
        Ok(Self { is_open_mpi, cores: cores() })
    }

    /// `program` on so many ranks; arguments of its own are still to come.
    pub fn command(&self, ranks: usize, threads: usize, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new("mpirun");
        command.args(arguments_of_mpirun(ranks, threads, self.cores, self.is_open_mpi)).arg(program);
        command
    }

    /// The same beside others of its kind: every mpirun would bind to the first cores, and a batch system that gave one task its cores
    /// counts one slot.
    pub fn command_among_others(&self, ranks: usize, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new("mpirun");
        command.args(["-n", &ranks.to_string()]);
        if self.is_open_mpi {
            command.args(["--oversubscribe", "--bind-to", "none"]);
        }
        command.arg(program);
        command
    }
}

/// Cores that this process may use.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

pub(super) fn is_launched() -> bool {
    LAUNCHER_VARIABLES.iter().any(|variable| std::env::var_os(variable).is_some())
}

/// Open MPI counts a slot a core, and starts more ranks only where it is told to. It binds each of two ranks to one core
/// unless it is told otherwise, so a rank of several threads is given as many cores; ranks that do not fit are not bound.
fn arguments_of_mpirun(ranks: usize, threads: usize, cores: usize, is_open_mpi: bool) -> Vec<String> {
    let mut arguments = vec!["-n".to_string(), ranks.to_string()];
    if !is_open_mpi {
        return arguments;
    }
    if ranks > cores {
        arguments.push("--oversubscribe".to_string());
    }
    if ranks * threads > cores {
        arguments.extend(["--bind-to", "none"].map(String::from));
    } else if threads > 1 {
        arguments.extend(["--map-by".to_string(), format!("slot:PE={threads}")]);
    } else {
        arguments.extend(["--bind-to", "core"].map(String::from));
    }
    arguments
}

/// Whether this process acts as root, where the system tells.
fn is_root() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let effective = status.lines().find_map(|line| line.strip_prefix("Uid:")?.split_whitespace().nth(1));
    effective == Some("0")
}

#[cfg(test)]
mod tests {
    use super::arguments_of_mpirun;

    /// Open MPI ends with "not enough slots" else; other launchers do not know the word.
    #[test]
    fn more_ranks_than_cores_are_asked_for_by_name() {
        assert_eq!(arguments_of_mpirun(2, 1, 2, true), ["-n", "2", "--bind-to", "core"]);
        assert_eq!(arguments_of_mpirun(4, 1, 2, true), ["-n", "4", "--oversubscribe", "--bind-to", "none"]);
        assert_eq!(arguments_of_mpirun(4, 1, 2, false), ["-n", "4"]);
    }

    /// Two threads of a rank that is bound to one core would take turns.
    #[test]
    fn a_rank_of_several_threads_has_as_many_cores() {
        assert_eq!(arguments_of_mpirun(1, 2, 2, true), ["-n", "1", "--map-by", "slot:PE=2"]);
        assert_eq!(arguments_of_mpirun(2, 2, 2, true), ["-n", "2", "--bind-to", "none"]);
    }
}
