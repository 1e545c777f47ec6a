//! `scree bench scaling` from end to end on small jobs: figures, digests, the page, and what is refused.

use std::process::{Command, Output};

use serde_json::Value;

use crate::mpirun::{SCREE, turn, words};

/// A periodic block of points under shear; a checkpoint in the middle.
pub const JOB: &str = r#"name = "small"
[grid]
space = "plane"
upper = ["0.32 m", "0.32 m"]
cell = "1 cm"
periodic = [true, true]
[material]
law = "linear_elastic"
density = 2000
young_modulus = "20 MPa"
poisson_ratio = 0.3
[[region]]
shape = "box"
lower = [0, 0]
upper = ["0.32 m", "0.32 m"]
wave = [{direction = [0, 1], length = "0.32 m", amplitude = [1, 0]}]
[time]
end = "20 ms"
[output]
checkpoint_interval = "5 ms"
[decomposition]
cells_per_block = 8
"#;

fn bench(folder: &tempfile::TempDir, arguments: &[&str]) -> Output {
    Command::new(SCREE)
        .args(["bench", "scaling", "job.toml"])
        .args(arguments)
        .current_dir(folder.path())
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_btl", "self,vader")
        .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .output()
        .unwrap()
}

fn folder(job: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.toml"), job).unwrap();
    folder
}

#[test]
fn one_job_is_measured_on_one_and_two_ranks() {
    let _turn = turn();
    let folder = folder(JOB);
    let ended =
        bench(&folder, &["--ranks", "2,1", "--weak", "--repeat", "2", "--from", "9 ms", "--json", "--out", "here"]);
    assert!(ended.status.success(), "{}", words(&ended));
    let page = String::from_utf8(ended.stdout).unwrap();
    let json: Value =
        serde_json::from_str(page.lines().last().unwrap()).unwrap_or_else(|error| panic!("{error}: {page}"));
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.iter().map(|run| run["ranks"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2]);
    for run in runs {
        assert!(run["wall_s"].as_f64().unwrap() > 0.0 && run["ns_per_step"].as_f64().unwrap() > 0.0, "{run}");
        assert_eq!((run["digest"].as_str().unwrap().len(), &run["digest"]), (64, &runs[0]["digest"]));
        assert_eq!(run["walls_s"].as_array().unwrap().len(), 2);
        // From the checkpoint at 10 ms, the first one at or after 9 ms, to the end: half of the steps.
        assert_eq!(run["steps"], runs[0]["steps"]);
        assert_eq!(run["rows"], 4096.0);
    }
    let from = json["from"].as_f64().unwrap();
    assert!((9e-3..11e-3).contains(&from), "{from}");
    let weak = json["weak"].as_array().unwrap();
    assert_eq!((weak.len(), &weak[1]["ranks"], &weak[1]["rows"]), (2, &Value::from(2), &Value::from(8192.0)));
    assert_eq!(weak[1]["steps"], runs[0]["steps"]);
    for wanted in ["speed-up t(1)/t(N)", "efficiency t(1)/t(N)", "started by mpirun", "here/scaling.html"] {
        assert!(page.contains(wanted), "{wanted}: {page}");
    }
    let mut left: Vec<String> = std::fs::read_dir(folder.path().join("here"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["figures", "scaling.html", "scaling.json"], "nothing else is left");
    let mut kept: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("here/scaling.json")).unwrap()).unwrap();
    let program = kept.as_object_mut().unwrap().remove("program").unwrap();
    assert_eq!(program, scree::base::program::identity());
    assert_eq!(kept, json);
    let html = std::fs::read_to_string(folder.path().join("here/scaling.html")).unwrap();
    assert!(html.contains("Scaling of small") && html.contains("<svg"), "{html}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let _turn = turn();
    let folder = folder(JOB);
    let refused = |arguments: &[&str], words_wanted: &str| {
        let ended = bench(&folder, arguments);
        assert_eq!(ended.status.code(), Some(2), "{}", words(&ended));
        assert!(words(&ended).contains(words_wanted), "{words_wanted}: {}", words(&ended));
        let left = std::fs::read_dir(folder.path().join("runs/scaling_small")).map_or(0, Iterator::count);
        assert_eq!(left, 0, "scratch was left");
    };
    refused(&["--ranks", "2", "--weak"], "Add 1 to --ranks");
    refused(&["--from", "soon"], "--from soon is not a time");
    refused(&["--from", "21 ms", "--ranks", "1"], "no checkpoint at or after that time and before its end");
    refused(&["--weak", "--set", "region.0.upper=[0.16, 0.32]"], "does not span the grid along x");
    refused(&["--set", "material.densty=1"], "densty");
}
