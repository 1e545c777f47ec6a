//! `jobs/quickstart.toml` past its peak, to 12 % of strain, as grains alone and as the hybrid of the same packing, compared by
//! `scree report` as the long runs of `jobs/planar_shear.toml` in `docs/validation/hybrid.md` are. Runs are the same bits everywhere, so that bounds
//! can lie close to what was found and nothing is left to chance.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::mpirun::{SCREE, scree, turn, words};

const JOB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/quickstart.toml");

/// On two ranks; the packing is made by the first and found by the second.
fn run(folder: &Path, method: &str) {
    let cache = format!("packing.cache={}", folder.join("cache").display());
    let method_set = format!("method={method}");
    let mut arguments = vec!["run", JOB, "--out", method, "--threads", "1"];
    [&method_set, &cache].iter().for_each(|set| arguments.extend(["--set", set]));
    let ended = scree(2, &arguments).current_dir(folder).output().unwrap();
    assert!(ended.status.success(), "{}", words(&ended));
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap_or_else(|| panic!("{of} is no number"))
}

/// A column of the series of a run.
fn column(folder: &Path, run: &str, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join(run).join("series.csv")).unwrap();
    let at = text.lines().next().unwrap().split(',').position(|other| other == name).unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_hybrid_shears_as_the_grains_alone_do() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    ["dem", "hybrid"].iter().for_each(|method| run(folder.path(), method));
    let report = ["report", "dem", "hybrid", "--between", "0.06,0.12", "--out", "page.html"];
    let output = Command::new(SCREE).args(report).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", words(&output));
    let found = read(&folder.path().join("comparison.json"));

    // Figure 10: before its peak the hybrid bears more, for its continuum is elastic and grains are not.
    let stress = &found["shear_stress"]["differences"][0];
    println!("{stress:#}");
    // 0.041; 0.051 with plates that hold nodes. The continuum of this job is set by hand above its grains.
    assert!(number(&stress["mean_difference"]).abs() < 0.05, "{stress:#}");
    assert!(number(&stress["rms_difference"]) < 0.2, "{stress:#}");
    let [peak, wanted] = ["hybrid", "dem"].map(|group| {
        let mut of = found["softening"].as_array().unwrap().iter();
        number(&of.find(|of| of["group"] == group).unwrap()["peak_pa"])
    });
    println!("peaks of {peak} and {wanted} Pa");
    assert!((peak / wanted - 1.0).abs() < 0.1, "peaks of {peak} and {wanted} Pa");
    // The same stress at the same strain inside the zone.
    let inside = &found["inside_the_zone"][0]["difference"];
    println!("{inside:#}");
    assert!(number(&inside["rms_difference"]) < 0.1, "{inside:#}");
    // Figure 13: the trained packing against the same region of the grains alone.
    let trained = &found["training"][0];
    // Of one packing: 0.060, and within 0.05 with plates that hold nodes.
    assert!(number(&trained["off"]).abs() < 0.07, "{trained:#}");
    // Figure 14: back within 1 % of strain.
    let disturbance = &found["disturbance"][0];
    assert!(number(&disturbance["strain_until_recovered"]) < 0.01, "{disturbance:#}");
    // A continuum that is stronger than its grains leaves all shear to the zone, as the report has it by what frames show.
    let inside_zones = column(folder.path(), "hybrid", "shear_in_zones");
    let (before, after): (Vec<f64>, Vec<f64>) = inside_zones.iter().partition(|share| **share == 0.0);
    let mean = after.iter().sum::<f64>() / after.len() as f64;
    let runs = found["bands"]["runs"].as_array().unwrap();
    let shown = number(&runs.iter().find(|run| run["run"] == "hybrid").unwrap()["shear_inside_zone"]);
    println!("{} rows before, then {mean:.3} of the shear is inside, by the frames {shown:.3}", before.len());
    assert!(!before.is_empty() && inside_zones[..before.len()] == before[..]);
    assert!(mean > 0.8 && (mean - shown).abs() < 0.15, "{mean} {shown}");
    // What grains gain in volume, the hybrid gains.
    let volume = ["dem", "hybrid"].map(|run| *column(folder.path(), run, "volume_strain").last().unwrap());
    println!("volume strains {volume:?}");
    assert!((volume[0] - volume[1]).abs() < 8e-4, "{volume:?}");
    // Through the enrichment.
    let kept = &read(&folder.path().join("hybrid/summary.json"))["conservation"];
    assert!(number(&kept["mass"]["error"]).abs() < 1e-13, "{kept:#}");
    assert!(number(&kept["momentum"]["error"]) < 1e-11, "{kept:#}");
}
