//! `scree sweep` from end to end on small jobs: rows, table, report, refusals, failures, and kills.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, finished, launching, signal, turn, words};
use crate::scaling;

/// Biaxial compression of few discs, a fifth of a second.
const GRAINS: &str = r#"name = "few"
[cell]
space = "plane"
upper = ["1.3 cm", "1.3 cm"]
velocity_gradient = [[0, 0], [0, "-1 1/s"]]
stress_normal = ["100 kPa", "free"]
rate_max = "2 1/s"
[grains]
density = 2650
count = 100
diameter_mean = "1 mm"
diameter_deviation = "0.1 mm"
[packing]
preparation = "compress"
stress = "100 kPa"
cache = "cache"
[contact]
law = "linear"
stiffness_normal = "500 kN/m"
stiffness_tangential = "250 kN/m"
restitution = 0.3
friction = 0.5
[time]
end = "20 ms"
[output]
series_interval = "0.2 ms"
"#;

/// The block of points of `scaling`, coarser and longer.
fn points() -> String {
    let mut job = scaling::JOB.to_owned();
    for (from, to) in [("\"1 cm\"", "\"2 cm\""), ("\"20 ms\"", "\"0.2 s\""), ("\"5 ms\"", "\"20 ms\"")] {
        assert_eq!(job.matches(from).count(), 1, "{from}");
        job = job.replace(from, to);
    }
    job
}

fn folder(job: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.toml"), job).unwrap();
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(SCREE);
    command.args(arguments).current_dir(folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    launching(&mut command);
    command
}

fn scree(folder: &Path, arguments: &[&str]) -> Output {
    finished(command(folder, arguments).spawn().unwrap())
}

fn sweep(folder: &Path, arguments: &[&str]) -> Output {
    scree(folder, &[&["sweep", "job.toml", "--out", "s"], arguments].concat())
}

fn good(ended: &Output) {
    assert!(ended.status.success(), "{}", words(ended));
}

fn digest(folder: &Path, run: &str) -> String {
    let ended = scree(folder, &["digest", run]);
    good(&ended);
    String::from_utf8(ended.stdout).unwrap()
}

/// Rows of the table by the names of their columns.
fn table(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.join("s/sweep.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_string).collect::<Vec<_>>());
    let header = lines.next().unwrap();
    lines.map(|line| header.iter().cloned().zip(line).collect()).collect()
}

/// Every row is the run that its line would make, the table has what came out, and the report its means.
#[test]
fn rows_are_the_runs_that_single_lines_make() {
    let folder = folder(GRAINS);
    let at = folder.path();
    let varied = ["--vary", "seed=1..2", "--vary", "contact.friction=0.3,0.5"];
    good(&sweep(at, &varied));
    good(&scree(at, &["run", "job.toml", "--out", "alone", "--set", "seed=2", "--set", "contact.friction=0.5"]));
    assert_eq!(digest(at, "s/seed-2_friction-0.5"), digest(at, "alone"));
    let rows = table(at);
    assert_eq!(rows.len(), 4);
    for row in &rows {
        assert_eq!((row["state"].as_str(), row["cause"].as_str()), ("done", ""), "{row:?}");
    }
    let row = &rows[3];
    assert_eq!((row["seed"].as_str(), row["contact.friction"].as_str()), ("2", "0.5"));
    let [peak, strain, time] = ["peak_pa", "peak_strain", "time_end"].map(|name| row[name].parse::<f64>().unwrap());
    assert!(peak > 1e5 && (0.0..0.021).contains(&strain) && (0.0199..0.0201).contains(&time), "{row:?}");
    assert!(rows[0]["peak_pa"] != rows[1]["peak_pa"] && rows[0]["peak_pa"] != rows[2]["peak_pa"]);

    // Done already: nothing is run, and the table is the same. A value more is a run more.
    let before = std::fs::read(at.join("s/sweep.csv")).unwrap();
    let again = sweep(at, &varied);
    good(&again);
    assert!(words(&again).contains("0 runs to do, 4 done before"), "{}", words(&again));
    assert_eq!(std::fs::read(at.join("s/sweep.csv")).unwrap(), before);
    let more = sweep(at, &["--vary", "seed=1..3", "--vary", "contact.friction=0.3,0.5", "--table", "copy.csv"]);
    good(&more);
    assert!(words(&more).contains("2 runs to do, 4 done before"), "{}", words(&more));
    assert_eq!(std::fs::read(at.join("copy.csv")).unwrap(), std::fs::read(at.join("s/sweep.csv")).unwrap());

    good(&scree(at, &["report", "s"]));
    let page = std::fs::read_to_string(at.join("s/report.html")).unwrap();
    assert!(page.contains("Means of packings"), "{page}");
    let numbers: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("s/comparison.json")).unwrap()).unwrap();
    let ensembles = numbers["ensembles"].as_array().unwrap();
    // To the strain that all have in common, as far as they are compared.
    let single = numbers["softening"].as_array().unwrap();
    let of_group = single.iter().filter(|run| run["group"] == "few, friction 0.3");
    let peaks: Vec<f64> = of_group.map(|run| run["peak_pa"].as_f64().unwrap()).collect();
    let told = ensembles.iter().find(|of| of["figure"] == "peak_pa").unwrap();
    assert_eq!((told["packings"].as_u64(), ensembles.len()), (Some(3), 6), "{ensembles:?}");
    let mean = peaks.iter().sum::<f64>() / 3.0;
    assert!((told["mean"].as_f64().unwrap() / mean - 1.0).abs() < 1e-12, "{told} {peaks:?}");
    // Of three values t is 4.303.
    let deviation = (peaks.iter().map(|peak| (peak - mean).powi(2)).sum::<f64>() / 2.0).sqrt();
    let half = told["half_width_95"].as_f64().unwrap();
    assert!((half / (4.303 * deviation / 3f64.sqrt()) - 1.0).abs() < 1e-12, "{told}");
    assert!(told["packings_for_5_percent"].as_u64().unwrap() > 1);
}

/// All rows are read before one is begun; another job in the folder is left alone; a file that is no table as well.
#[test]
fn what_cannot_be_run_is_refused_before_any_row_begins() {
    let folder = folder(&points());
    let at = folder.path();
    let refused = |arguments: &[&str], wanted: &[&str]| {
        let ended = sweep(at, arguments);
        let told = words(&ended);
        assert_eq!(ended.status.code(), Some(2), "{told}");
        wanted.iter().for_each(|part| assert!(told.contains(part), "{part}: {told}"));
    };
    let moduli = "material.young_modulus=20 MPa,-3 MPa,10 MPa";
    refused(
        &["--vary", moduli],
        &["1 of 3 rows", "none was started", "row 2 (material.young_modulus=-3 MPa)", "-3 MPa"],
    );
    refused(&["--vary", "material.young=1,2"], &["2 of 2 rows", "Did you mean"]);
    refused(&[], &["--vary seed=1..10"]);
    assert!(!at.join("s").exists());
    std::fs::write(at.join("mine.csv"), "a,b\n").unwrap();
    refused(&["--vary", "material.density=1", "--table", "mine.csv"], &["mine.csv", "is no table of a sweep"]);

    let varied = ["--vary", "material.density=2000,2500", "--set", "time.end=0.02"];
    let listed = sweep(at, &[&varied[..], &["--list"]].concat());
    good(&listed);
    assert!(words(&listed).contains("waiting  material.density=2500") && !at.join("s").exists(), "{}", words(&listed));
    good(&sweep(at, &varied));
    let other = ["--vary", "material.density=2000,2500", "--set", "time.end=0.03"];
    refused(&other, &["holds a run of another job", "0.02"]);
    assert!(words(&sweep(at, &[&varied[..], &["--list"]].concat())).contains("done     material.density=2500"));
}

/// A run that fails is marked with its cause, and ends no other; once that is mended, the same line does it alone.
#[test]
fn a_row_that_fails_is_told_with_its_cause_and_the_others_go_on() {
    let folder = folder(&points());
    let at = folder.path();
    let varied = ["--vary", "material.density=2000,2500,3000", "--set", "time.end=0.02"];
    std::fs::create_dir_all(at.join("s")).unwrap();
    // A folder that holds an empty job is of another run.
    std::fs::create_dir(at.join("s/density-2500")).unwrap();
    std::fs::write(at.join("s/density-2500/run.lock"), "").unwrap();
    std::fs::write(at.join("s/density-2500/scenario.toml"), "").unwrap();
    let ended = sweep(at, &varied);
    assert_eq!(ended.status.code(), Some(2), "an empty scenario is another job: {}", words(&ended));
    std::fs::remove_dir_all(at.join("s/density-2500")).unwrap();
    std::fs::write(at.join("s/density-2500.log"), "of before\n").unwrap();
    std::fs::write(at.join("points.toml"), points()).unwrap();
    std::fs::write(at.join("job.toml"), GRAINS).unwrap();
    let ended = sweep(at, &["--vary", "time.step=0.5 us,20 us", "--set", "time.allow_unstable=true"]);
    let told = words(&ended);
    assert_eq!(ended.status.code(), Some(3), "{told}");
    assert!(told.contains("1 of 2 runs are done, 1 failed") && told.contains("step-20us: "), "{told}");
    let rows = table(at);
    assert_eq!((rows[0]["state"].as_str(), rows[1]["state"].as_str()), ("done", "failed"));
    let text = std::fs::read_to_string(at.join("s/sweep.csv")).unwrap();
    let log = std::fs::read_to_string(at.join("s/step-20us.log")).unwrap();
    let last = log.lines().rfind(|line| !line.is_empty()).unwrap();
    assert!(text.contains(&last.chars().take(100).collect::<String>().replace('"', "\"\"")), "{text}\n{log}");
    good(&scree(at, &[&["sweep", "points.toml", "--out", "s"], &varied[..]].concat()));
    assert!(std::fs::read_to_string(at.join("s/density-2500.log")).unwrap().starts_with("of before\n"));
}

const TWENTY: [&str; 8] =
    ["--vary", "material.density=2001..2020", "--jobs", "3", "--set", "time.step=20 us", "--set", "time.end=0.05"];

fn twenty(at: &Path) -> Child {
    command(at, &[&["sweep", "job.toml", "--out", "s"], &TWENTY[..]].concat()).spawn().unwrap()
}

fn done(at: &Path) -> usize {
    let text = std::fs::read_to_string(at.join("s/sweep.csv")).unwrap_or_default();
    text.lines().filter(|line| line.contains(",done,")).count()
}

/// Waits until some rows are done, which must not be all.
fn some_done(at: &Path, least: usize) -> usize {
    let begun = Instant::now();
    while done(at) < least {
        assert!(begun.elapsed() < Duration::from_secs(120), "no row is done");
        std::thread::sleep(Duration::from_millis(5));
    }
    done(at)
}

/// Twenty runs: killed, stopped, and gone on with by two sweeps at once, they end as if nobody had disturbed them.
#[test]
fn a_sweep_of_twenty_is_killed_and_goes_on() {
    let _turn = turn();
    let folder = folder(&points());
    let at = folder.path();
    let killed = twenty(at);
    let before = some_done(at, 2);
    signal(killed.id(), "KILL");
    finished(killed);
    assert!(before < 18, "{before} were done at once");
    // Its runs go on without it, and are waited for.
    let stopped = twenty(at);
    some_done(at, before + 3);
    signal(stopped.id(), "TERM");
    let ended = finished(stopped);
    assert_eq!(ended.status.code(), Some(4), "{}", words(&ended));
    assert!(words(&ended).contains("are still to be done"), "{}", words(&ended));
    let both = [twenty(at), twenty(at)].map(finished);
    both.iter().for_each(good);
    assert_eq!(done(at), 20, "{}", words(&both[0]));
    let rows = table(at);
    for density in [2001, 2007, 2020] {
        let run = format!("alone-{density}");
        let set = format!("material.density={density}");
        good(&scree(
            at,
            &["run", "job.toml", "--out", &run, "--set", &set, "--set", "time.step=20 us", "--set", "time.end=0.05"],
        ));
        let row = rows.iter().find(|row| row["material.density"] == density.to_string()).unwrap();
        assert_eq!(digest(at, &format!("s/{}", row["run"])), digest(at, &run));
        assert_eq!(
            std::fs::read(at.join("s").join(&row["run"]).join("series.csv")).unwrap(),
            std::fs::read(at.join(&run).join("series.csv")).unwrap()
        );
    }
}

/// Under mpirun, with a wish to stop that reaches all ranks of all runs.
#[test]
fn runs_of_several_ranks_are_stopped_and_go_on() {
    let _turn = turn();
    let folder = folder(&points());
    let at = folder.path();
    let line = [
        "sweep",
        "job.toml",
        "--out",
        "s",
        "--vary",
        "material.density=2000,2500",
        "--ranks",
        "2",
        "--jobs",
        "1",
        "--set",
        "time.step=20 us",
    ];
    let sweep = command(at, &line).spawn().unwrap();
    some_done(at, 1);
    std::thread::sleep(Duration::from_millis(300));
    signal(sweep.id(), "TERM");
    let ended = finished(sweep);
    assert_eq!(ended.status.code(), Some(4), "{}", words(&ended));
    good(&finished(command(at, &line).spawn().unwrap()));
    assert_eq!(done(at), 2);
    let summary = std::fs::read_to_string(at.join("s/density-2500/summary.json")).unwrap();
    assert!(summary.contains("\"ranks\": 2"), "{summary}");
}
