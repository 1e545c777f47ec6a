//! The same under a real `mpirun`: a test runs its own executable again, as the ranks of one run.

use crate::operations;
use scree_partition::{Mpi, Transport};
use std::env;
use std::process::{Command, Output};

/// Tells the ranks from the test that starts them.
const CHILD: &str = "SCREE_TEST_RANK";

fn is_rank() -> bool {
    env::var_os(CHILD).is_some()
}

/// Runs the test `name` of this executable on `size` ranks.
fn mpirun(size: usize, name: &str) -> Output {
    let mut command = Command::new("mpirun");
    // What an enclosing mpirun left behind would confuse this one.
    for (variable, _) in env::vars_os() {
        if ["OMPI_", "PMIX_"].iter().any(|prefix| variable.to_string_lossy().starts_with(prefix)) {
            command.env_remove(variable);
        }
    }
    command
        .env(CHILD, "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_btl", "self,vader")
        .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
        .args(["--oversubscribe", "--bind-to", "none", "--timeout", "60", "-n", &size.to_string()])
        .arg(env::current_exe().expect("a test knows its executable"))
        .args([name, "--exact", "--nocapture", "--test-threads=1"])
        .output()
        .expect("mpirun is installed")
}

/// A run in which every rank came to its end, or the test passes where nothing ran.
fn mpirun_whole(size: usize, name: &str) {
    let output = mpirun(size, name);
    let stdout = String::from_utf8_lossy(&output.stdout);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{stdout}\n{stderr}", output.status);
    for rank in 0..size {
        assert!(stdout.contains(&marker(rank, size)), "rank {rank} of {size} left no mark\n{stdout}\n{stderr}");
    }
}

fn marker(rank: usize, size: usize) -> String {
    format!("<rank {rank} of {size} done>")
}

#[test]
fn two_three_and_six_processes() {
    if is_rank() {
        let ranks = Mpi::start();
        operations::check_all(&ranks);
        println!("{}", marker(ranks.rank(), ranks.size()));
        return;
    }
    // Six: two beyond the largest power of two, which has two stages.
    for size in [1, 2, 3, 6] {
        mpirun_whole(size, "mpi::two_three_and_six_processes");
    }
}

#[test]
fn abort_ends_all_ranks_with_its_code() {
    if is_rank() {
        let ranks = Mpi::start();
        if ranks.rank() == 1 {
            ranks.abort(43);
        }
        ranks.barrier();
        return;
    }
    assert_eq!(mpirun(2, "mpi::abort_ends_all_ranks_with_its_code").status.code(), Some(43));
}

#[test]
fn a_panic_on_any_thread_of_one_rank_ends_all() {
    if is_rank() {
        let ranks = Mpi::start();
        if ranks.rank() == 1 {
            let outcome = std::thread::spawn(|| panic!("grain 17 is lost")).join();
            assert!(outcome.is_ok());
        }
        ranks.barrier();
        return;
    }
    let output = mpirun(2, "mpi::a_panic_on_any_thread_of_one_rank_ends_all");
    assert_eq!(output.status.code(), Some(101));
    assert!(String::from_utf8_lossy(&output.stderr).contains("grain 17 is lost"));
}

#[test]
fn a_message_that_is_too_short_ends_the_run() {
    if is_rank() {
        let ranks = Mpi::start();
        let other = 1 - ranks.rank();
        ranks.exchange(&[(other, &[0; 4])], &mut [(other, &mut [0; 5])], &mut || {});
        return;
    }
    let output = mpirun(2, "mpi::a_message_that_is_too_short_ends_the_run");
    assert_eq!(output.status.code(), Some(101));
    assert!(String::from_utf8_lossy(&output.stderr).contains("bytes that arrived"));
}
