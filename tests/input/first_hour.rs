//! The first hour of the handbook, typed as it is printed.

use crate::mpirun::turn;
use crate::shell::Shell;

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
    let shell = Shell::new();
    let said: String = blocks().iter().map(|(language, text)| shell.types(language, text)).collect();
    // What the page promises of its last lines and of its report.
    let digests: Vec<&str> =
        said.lines().filter(|line| line.len() == 64 && line.bytes().all(|b| b.is_ascii_hexdigit())).collect();
    assert!(digests.len() == 2 && digests[0] == digests[1], "{digests:?}");
    assert!(said.contains("The job is good.") && said.contains("this run is done already"), "{said}");
    for file in ["runs/a/report.html", "runs/a/report.txt", "runs/compared.html", "runs/a/frames.vtkhdf"] {
        assert!(shell.folder.path().join(file).is_file(), "{file}");
    }
}
