//! What a run leaves tells which program wrote it, and a run of another program is gone on with, which is told.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use scree::base::program;
use scree_io::column::State;
use scree_io::schema::SCHEMA_VERSION;
use scree_io::store;

use crate::folders::Desk;
use crate::mpirun::{SCREE, words};
use crate::runs::copy_folder;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

#[test]
fn every_file_of_a_run_tells_its_program() {
    let desk = Desk::new();
    let version = Command::new(SCREE).arg("--version").output().unwrap();
    let version = words(&version);
    for word in [program::COMMIT, program::SOURCE, &format!("schema {SCHEMA_VERSION}"), "rustc"] {
        assert!(version.contains(word), "{word}: {version}");
    }
    let identity = program::identity();
    for word in ["scree 0", program::COMMIT, program::SOURCE, &format!("schema {SCHEMA_VERSION}"), "rustc"] {
        assert!(identity.contains(word), "{word}: {identity}");
    }
    let text = |name: &str| fs::read_to_string(desk.path("reference").join(name)).unwrap();
    for name in ["log.jsonl", "summary.json", "run.lock"] {
        assert!(text(name).contains(identity), "{name} does not tell its program");
    }
    let run = &text("scenario.toml").strip_prefix("# Run ").unwrap()[..16].to_string();
    for name in ["log.jsonl", "summary.json", "run.lock"] {
        assert!(text(name).contains(run.as_str()), "{name} does not tell its run");
    }
    let (_, checkpoint) = store::newest(&desk.path("reference/checkpoints")).unwrap().remove(0);
    let state = store::read(&checkpoint).unwrap();
    assert_eq!((state.attributes["program"].as_str(), &state.attributes["run"]), (identity, run));
    let frames = scree_io::frames::attributes(&desk.path("reference/frames.vtkhdf")).unwrap();
    assert_eq!((frames["program"].as_str(), &frames["run"]), (identity, run));
}

/// Runs as former programs left them.
fn former_runs() -> Vec<PathBuf> {
    let folders = |path: PathBuf| {
        let entries = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.is_dir()).collect::<Vec<PathBuf>>()
    };
    let mut runs: Vec<PathBuf> = folders(Path::new(DATA).join("runs")).into_iter().flat_map(folders).collect();
    runs.sort();
    runs
}

#[test]
fn runs_of_former_programs_are_gone_on_with() {
    let runs = former_runs();
    assert!(runs.len() >= 3, "{runs:?}");
    for run in runs {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path().join("run");
        copy_folder(&run, &here);
        let output = Command::new(SCREE).args(["resume", "run", "--threads", "1"]).current_dir(folder.path()).output();
        let output = output.unwrap();
        let told = words(&output);
        assert!(output.status.success(), "{}: {told}", run.display());
        assert!(told.contains("was written by scree 0.1.0") && told.contains("may have other bits"), "{told}");
        let summary = fs::read_to_string(here.join("summary.json")).unwrap();
        assert!(summary.contains("\"outcome\": \"done\"") && summary.contains(program::SOURCE), "{summary}");
        let log = fs::read_to_string(here.join("log.jsonl")).unwrap();
        let resumed = log.lines().rfind(|line| line.contains("\"event\":\"resumed\"")).unwrap();
        assert!(resumed.contains(program::SOURCE), "{resumed}");
        // And once more, by the program that has written it.
        let output = Command::new(SCREE).args(["resume", "run"]).current_dir(folder.path()).output().unwrap();
        assert!(
            words(&output).contains("done already") && !words(&output).contains("other bits"),
            "{}",
            words(&output)
        );
    }
}

/// Names, widths and kinds of all columns of a state's tables.
fn columns(state: &State) -> BTreeSet<String> {
    let of = |table: &scree_io::Table| {
        let name = table.name.clone();
        table
            .columns
            .iter()
            .map(move |column| format!("{name}.{} {} x {}", column.name, column.width, column.values.kind()))
            .collect::<Vec<_>>()
    };
    state.tables.iter().flat_map(of).collect()
}

/// Whoever changes a column raises the schema, keeps the runs of the program before, and writes this list anew.
#[test]
fn the_schema_is_that_of_the_columns() {
    let mut found = BTreeSet::new();
    for run in former_runs() {
        let folder = tempfile::tempdir().unwrap();
        copy_folder(&run, &folder.path().join("run"));
        let output = Command::new(SCREE).args(["resume", "run", "--threads", "1"]).current_dir(folder.path()).output();
        assert!(output.unwrap().status.success());
        let (_, newest) = store::newest(&folder.path().join("run/checkpoints")).unwrap().remove(0);
        found.extend(columns(&store::read(&newest).unwrap()));
    }
    let found: Vec<String> = found.into_iter().collect();
    let found = format!("schema {SCHEMA_VERSION}\n{}\n", found.join("\n"));
    let listed = fs::read_to_string(Path::new(DATA).join("runs/schema.txt")).unwrap_or_default();
    assert!(
        found == listed,
        "the columns of checkpoints are not those of tests/data/runs/schema.txt: raise SCHEMA_VERSION, add the runs of the program before, and write there:\n{found}"
    );
}
