//! The first hour of the handbook, typed as it is printed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::mpirun::{SCREE, launching, turn};

const PAGE: &str = include_str!("../../docs/first_hour.md");

/// Fenced blocks of the page with the language behind the fence, but for what builds and installs.
fn blocks() -> Vec<(&'static str, &'static str)> {
    let fenced = PAGE.split("```").skip(1).step_by(2);
    let blocks = fenced.filter_map(|block| block.split_once('\n'));
    blocks.filter(|(_, text)| !text.contains("quickstart.sh") && !text.contains("pip install")).collect()
}

#[test]
fn the_first_hour_runs_as_printed() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    let beside = Path::new(SCREE).parent().unwrap();
    let old = std::env::var_os("PATH").unwrap_or_default();
    let paths: Vec<PathBuf> = [beside.to_path_buf()].into_iter().chain(std::env::split_paths(&old)).collect();
    let path = std::env::join_paths(paths).unwrap();
    let python = std::env::var("SCREE_PYTHON").ok();
    let mut said = String::new();
    for (language, text) in blocks() {
        let mut command = match (language, &python) {
            ("python", Some(python)) => Command::new(python),
            ("python", None) => continue,
            _ => Command::new("bash"),
        };
        // Any line that fails ends a block of a shell.
        let text = if language == "python" { text.to_owned() } else { format!("set -e\n{text}") };
        launching(&mut command);
        let ended = command
            .args(["-c", &text])
            .current_dir(folder.path())
            .env("PATH", &path)
            .env("PYTHONPATH", Path::new(env!("CARGO_MANIFEST_DIR")).join("io/python"))
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&ended.stdout).into_owned() + &String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.success(), "{text}\n{words}");
        said.push_str(&words);
    }
    // What the page promises of its last lines and of its report.
    let digests: Vec<&str> =
        said.lines().filter(|line| line.len() == 64 && line.bytes().all(|b| b.is_ascii_hexdigit())).collect();
    assert!(digests.len() == 2 && digests[0] == digests[1], "{digests:?}");
    assert!(said.contains("The job is good.") && said.contains("this run is done already"), "{said}");
    for file in ["runs/a/report.html", "runs/a/report.txt", "runs/compared.html", "runs/a/frames.vtkhdf"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}
