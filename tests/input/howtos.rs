//! The commands of the page of how-tos, typed as they are printed, from the first to the last: each leaves what the next ones ask for.

use std::collections::BTreeSet;

use crate::mpirun::turn;
use crate::shell::Shell;

const PAGE: &str = include_str!("../../docs/howto.md");

/// Commands that are not typed here, and why.
const LEFT_OUT: [(&str, &str); 5] = [
    ("scree bench scaling a.toml --ranks 1,2", "measures for some time, and has tests of its own"),
    ("scree calibrate a.toml --out runs/calibrate", "takes minutes, and has tests of its own"),
    ("scree calibrate a.toml --law mobilised_friction", "takes minutes, and has tests of its own"),
    ("scree report runs/dem runs/hybrid", "is of runs that take minutes, and has tests of its own"),
    ("scree export runs/a --rve NAME --rve-frame a.vtkhdf", "is of a run with RVEs, and has tests of its own"),
];

/// What stands for something else.
const PLACEHOLDERS: [&str; 3] = ["COMMAND", "TABLE", "KEY"];

/// Commands in the order of the page. A mere name, as `scree check`, is none.
fn commands() -> Vec<&'static str> {
    let spans = PAGE.split('`').skip(1).step_by(2).filter(|span| span.starts_with("scree "));
    let is_command = |span: &&str| {
        let words: Vec<&str> = span.split(' ').collect();
        (words.len() > 2 || words[1].starts_with("--")) && !words.iter().any(|word| PLACEHOLDERS.contains(word))
    };
    spans.filter(is_command).collect()
}

#[test]
fn how_tos_run_as_printed() {
    let _turn = turn();
    let shell = Shell::new();
    let file = |name: &str| shell.folder.path().join(name);
    let (mut typed, mut left_out) = (BTreeSet::new(), BTreeSet::new());
    for command in commands() {
        if LEFT_OUT.iter().any(|(other, _)| *other == command) {
            left_out.insert(command);
            continue;
        }
        if typed.contains(command) {
            continue;
        }
        shell.types("bash", command);
        if typed.is_empty() {
            // The template is made as it is printed, and what follows is done to a run of a tenth of the grains in a tenth of the time.
            let text = std::fs::read_to_string(file("a.toml")).unwrap();
            let small = [
                ("upper = [\"3 cm\", \"3 cm\"]", "upper = [\"1 cm\", \"1 cm\"]"),
                ("count = 600", "count = 60"),
                ("\"500 kN/m\"", "\"50 kN/m\""),
                ("\"250 kN/m\"", "\"25 kN/m\""),
                ("end = \"0.1 s\"", "end = \"0.01 s\""),
            ];
            let text = small.iter().fold(text, |text, (from, to)| {
                assert_eq!(text.matches(from).count(), 1, "{from}");
                text.replace(from, to)
            });
            std::fs::write(file("a.toml"), text).unwrap();
            std::fs::write(file("samples.csv"), "contact.friction\n0.3\n0.6\n").unwrap();
            std::fs::remove_dir_all(file("runs/a")).unwrap();
            shell.types("bash", "scree run a.toml --out runs/a");
        }
        typed.insert(command);
    }
    assert!(typed.len() >= 20, "{} commands: {typed:?}", typed.len());
    assert_eq!(left_out.len(), LEFT_OUT.len(), "a command that is left out is not on the page any more: {left_out:?}");
    let made = [
        "job.schema.json",
        "runs/a2/series.csv",
        "runs/b/series.csv",
        "runs/back/series.csv",
        "runs/a_sweep/sweep.csv",
        "runs/a_sweep/report.html",
        "runs/element_sweep/sweep.csv",
        "runs/a/report.html",
        "DIR/frames.pvd",
        "a.dump",
        "a.data",
        "a.csv",
        "contacts.csv",
    ];
    for name in made {
        assert!(file(name).is_file(), "{name} has not been made");
    }
    let rows = std::fs::read_to_string(file("runs/a_sweep/sweep.csv")).unwrap();
    assert_eq!(rows.lines().filter(|line| line.contains("done")).count(), 20, "{rows}");
}
