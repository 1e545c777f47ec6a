//! What somebody meets who has never used the program: a job to begin with, the example of the README, keys and mistakes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn scree(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scree"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program can be started")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn a_hybrid_runs_at_the_first_try() {
    let folder = tempfile::tempdir().unwrap();
    let made = scree(folder.path(), &["new", "hybrid"]);
    fs::write(folder.path().join("a.toml"), &made.stdout).unwrap();
    let ran = scree(folder.path(), &["run", "a.toml"]);
    assert!(ran.status.success(), "{}", told(&ran));
    let series = fs::read_to_string(folder.path().join("runs/hybrid/series.csv")).unwrap();
    let grains = series.lines().next().unwrap().split(',').position(|name| name == "grains").unwrap();
    let last = series.lines().last().unwrap().split(',').nth(grains).unwrap().parse::<f64>().unwrap();
    assert!(last > 100.0, "a band was found, and grains took its place: {last}");
}

#[test]
fn the_example_of_the_readme_runs_as_printed() {
    let readme = include_str!("../README.md");
    let example = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.toml"), example).unwrap();
    let ran = scree(folder.path(), &["run", "mine.toml"]);
    assert!(ran.status.success(), "{}", told(&ran));
}

/// Of keys that are wrong by themselves each is told, with the line and marks below it; so are all checks of several keys.
#[test]
fn all_mistakes_are_told_at_once() {
    let readme = include_str!("../README.md");
    let example = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let said = |text: &str| {
        fs::write(folder.path().join("mine.toml"), text).unwrap();
        let checked = scree(folder.path(), &["check", "mine.toml"]);
        assert_eq!(checked.status.code(), Some(2));
        String::from_utf8_lossy(&checked.stderr).into_owned()
    };
    let wrong = example
        .replace("\"24 mm\"", "\"2 cm/s\"")
        .replace("stiffness_normal = ", "stifness_normal = ")
        .replace("density = \"2530 kg/m3\"\n", "");
    let keys = said(&wrong);
    for part in [
        "mine.toml: 3 mistakes.",
        "mine.toml:5: specimen.width = \"2 cm/s\" is a speed, but a length (m) is wanted. Write for example width = \"6 cm\".\n  5 | width = \"2 cm/s\"\n    |         ^^^^^^^^\n",
        "[contact] has no key stifness_normal. Did you mean stiffness_normal?",
        "[grains] has no density, the density of the solid.",
    ] {
        assert!(keys.contains(part), "{part}\n{keys}");
    }
    let together = said(&(example.replace("\"400 kPa\"", "1e9") + "step = \"1 ms\"\n"));
    assert!(together.contains("loading.stress_normal = 1e9 squeezes"), "{together}");
    assert!(together.contains("time.step = \"1 ms\" is unstable"), "{together}");
}

#[test]
fn keys_schema_completions_and_manual() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, part) in [
        (vec!["keys"], "[contact]"),
        (vec!["keys", "contact"], "stiffness_normal = \"1772 kN/m\""),
        (vec!["keys", "body.servo"], "speed_max"),
        (vec!["schema"], "\"$schema\""),
        (vec!["completions", "bash"], "complete"),
        (vec!["man"], ".TH scree"),
        (vec!["new", "continuum"], "[grid]"),
    ] {
        let output = scree(folder.path(), &arguments);
        assert!(output.status.success() && told(&output).contains(part), "{arguments:?}: {}", told(&output));
    }
    let expanded = scree(folder.path(), &["new", "pour"]);
    fs::write(folder.path().join("pour.toml"), expanded.stdout).unwrap();
    let expanded = told(&scree(folder.path(), &["check", "--expand", "pour.toml"]));
    assert!(expanded.contains("checkpoints_kept = 3"), "{expanded}");
}
