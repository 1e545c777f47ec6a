//! The same bits on any number of ranks, the ranks being threads of this process (invariants 2 and 3).

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use scree::base::space::Plane;
use scree::couple::oracle::{Criterion, Memory};
use scree::dem::grains::Mover;
use scree::job::{Job, Scenario};
use scree::run::start;
use scree::store::checkpoint::{self, Snapshot};
use scree_partition::transport::threads;

use crate::runs::{copy_folder, done, options, result};
use crate::worlds::{mobilised, packed_job};

/// Runs one at a time: ranks that wait for each other should not wait for another test's as well.
fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a job on `ranks` ranks; digest of its last checkpoint, and its curve.
fn ran(scenario: &Scenario, ranks: usize, out: &Path) -> (String, String) {
    let job = Job::Shear(scenario.clone());
    threads::run(ranks, |rank| done(start::start(&job, &options(out), &rank)));
    result(out)
}

/// Rows of a curve: grains and points of each.
fn populations(series: &str) -> Vec<[u64; 2]> {
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        [cells[6] as u64, cells[7] as u64]
    };
    series.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit())).map(row).collect()
}

/// Runs a job on one to four ranks and returns the curve that all of them must draw.
fn same_on_any_ranks(scenario: &Scenario, folder: &Path) -> String {
    let (digest, series) = ran(scenario, 1, &folder.join("1"));
    for ranks in 2..=4 {
        let (found, curve) = ran(scenario, ranks, &folder.join(ranks.to_string()));
        assert_eq!(curve, series, "{ranks} ranks: another curve");
        assert_eq!(found, digest, "{ranks} ranks: another state");
    }
    series
}

#[test]
fn grains_end_in_the_same_bits_on_any_ranks() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    // A thin skin, so that grains change house often.
    let scenario = packed_job(&["method=dem", "decomposition.skin=0.02 mm", "loading.strain_end=0.01"]);
    let series = same_on_any_ranks(&scenario, folder.path());
    assert!(populations(&series).iter().all(|[grains, points]| *grains > 500 && *points == 0));
    let summary = std::fs::read_to_string(folder.path().join("4/summary.json")).unwrap();
    let rebuilds = summary.split("\"rebuilds\":").nth(1).and_then(|rest| rest.split(',').next());
    let rebuilds: u64 = rebuilds.unwrap().trim().parse().unwrap();
    assert!(rebuilds > 8, "{rebuilds} rebuilds");
}

#[test]
fn a_continuum_ends_in_the_same_bits_on_any_ranks() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    let scenario = packed_job(&["method=mpm", "loading.strain_end=0.02"]);
    let series = same_on_any_ranks(&scenario, folder.path());
    assert!(populations(&series).iter().all(|[grains, points]| *grains == 0 && *points > 150));
}

/// Planar shear takes any law of the list, and any scheme where points are alone.
#[test]
fn planar_shear_of_another_law_ends_in_the_same_bits() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, sets: &[&str]| {
        let scenario = mobilised(sets);
        let [one, three] = ["1", "3"].map(|ranks| folder.path().join(format!("{name}-{ranks}")));
        let wanted = ran(&scenario, 1, &one);
        assert!(ran(&scenario, 3, &three) == wanted, "{name}: other bits on three ranks");
        populations(&wanted.1)
    };
    let scheme = ["scheme.shape=generalised", "scheme.update=modified_last"];
    let points = run("mpm", &[&["method=mpm", "loading.strain_end=0.01"], &scheme[..]].concat());
    assert!(points.iter().all(|[grains, points]| *grains == 0 && *points > 150), "{points:?}");
    let fast = ["loading.speed=20 cm/s", "loading.speed_ramp=0.5 ms", "loading.strain_end=0.035"];
    let sets = [&fast[..], &["enrichment.training_speed=4"]].concat();
    let hybrid = run("hybrid", &sets);
    let (first, last) = (hybrid[0], hybrid[hybrid.len() - 1]);
    assert!(first[0] == 0 && last[0] > 100 && last[1] < first[1], "no enrichment: {first:?} to {last:?}");
}

/// With a step of the continuum for each of grains, and with one for seven, which no interval of an output is a multiple of, and
/// with an account of the grains' energy.
#[test]
fn a_hybrid_ends_in_the_same_bits_on_any_ranks_and_from_any_checkpoint() {
    through_enrichment(&["time.grain_steps=1"]);
    let series = through_enrichment(&["time.grain_steps=7", "output.energy_balance=true"]);
    let last = |name: &str| -> f64 {
        let mut lines = series.lines().filter(|line| !line.starts_with('#'));
        let at = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
        lines.next_back().unwrap().split(',').nth(at).unwrap().parse().unwrap()
    };
    assert!(last("work_nodes") != 0.0 && last("ledger_residual").abs() < 1e-3, "{series}");
}

/// A continuum as uneven as its packing, whose strain is nonlocal and whose shear is watched for how it concentrates; the zone holds grains of the upper plate, which
/// push it in every step of theirs.
#[test]
fn a_zone_at_a_plate_in_a_nonlocal_continuum_ends_in_the_same_bits() {
    [(1, 1), (4, 1), (4, 2)].into_iter().for_each(zone_at_a_plate);
}

fn zone_at_a_plate((grain_steps, interval): (u64, u64)) {
    let [exchanges, cycles] = [format!("coupling.interval={interval}"), format!("time.grain_steps={grain_steps}")];
    let at_plate = [
        exchanges.as_str(),
        cycles.as_str(),
        "continuum.weak.0.lower=[0.0, 0.027]",
        "continuum.weak.0.upper=[0.012, 0.033]",
        "continuum.heterogeneity=packing",
        "nonlocal.radius=4 mm",
    ];
    let text = mobilised(&[&at_plate[..], &QUICK[..]].concat()).to_toml();
    let (head, rest) = text.split_once("\n[oracle]\n").unwrap();
    let (_, tail) = rest.split_once("\n[").unwrap();
    let oracle = "criterion = \"concentration\"\nparticipation = 0.9\ncontrast = 1.2\nsharpening = 0.95\ncalm = 1.0\nexcess = 0.0\nreach = 6\nevery = 20\n";
    let text = format!("{head}\n[oracle]\n{oracle}\n[{tail}");
    let scenario = Scenario::parse(&text, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(scenario.oracle.criterion, Criterion::Concentration(_)));
    let folder = tempfile::tempdir().unwrap();
    scenario_through_enrichment(&scenario, folder.path());
    let (_, snapshot): (_, Snapshot<Plane>) = checkpoint::latest(&folder.path().join("1"), 1).unwrap();
    let of = |body: u8| snapshot.grains.iter().filter(|grain| grain.cold.mover == Mover::Body(body)).count();
    assert!(of(0) == 0 && of(1) > 30, "{} and {} grains of plates", of(0), of(1));
    let way = snapshot.bodies[1].displacement;
    for grain in snapshot.grains.iter().filter(|grain| grain.cold.mover == Mover::Body(1)) {
        let off = grain.hot.position[1] - grain.cold.origin[1] - way[1];
        assert!(off.abs() < 1e-12, "a grain of the plate is off it by {off} m");
    }
    assert_ne!(snapshot.progress.oracle.seen, Memory::default().seen);
    // The plate takes what grains and points put on it, and nothing else.
    let summary = std::fs::read_to_string(folder.path().join("1/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let off = summary["conservation"]["momentum"]["error"].as_f64().unwrap();
    assert!(off < 1e-13, "momentum off by {off}");
}

/// A short run through enrichment.
const QUICK: [&str; 6] = [
    "loading.speed=20 cm/s",
    "loading.speed_ramp=0.5 ms",
    "loading.strain_end=0.035",
    "enrichment.training_speed=4",
    "output.checkpoint_interval=0.5 ms",
    "output.checkpoints_kept=9",
];

/// Through detection, training and enrichment, and from checkpoints on either side of it.
fn through_enrichment(changes: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    scenario_through_enrichment(&packed_job(&[changes, &QUICK].concat()), folder.path())
}

fn scenario_through_enrichment(scenario: &Scenario, folder: &Path) -> String {
    let _turn = turn();
    let series = same_on_any_ranks(scenario, folder);
    let populations = populations(&series);
    let (first, last) = (populations[0], populations[populations.len() - 1]);
    assert!(first[0] == 0 && last[0] > 100 && last[1] < first[1], "no enrichment: {first:?} to {last:?}");

    let whole = folder.join("1");
    let wanted = result(&whole);
    let mut kept: Vec<_> = std::fs::read_dir(checkpoint::folder(&whole))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    kept.sort();
    // Before enrichment, and after it.
    for (from, ranks) in [(1, 2), (kept.len() - 2, 3)] {
        let out = folder.join(format!("from-{from}"));
        copy_folder(&whole, &out);
        for later in &kept[from + 1..] {
            std::fs::remove_file(checkpoint::folder(&out).join(later)).unwrap();
        }
        let (_, snapshot): (_, Snapshot<Plane>) = checkpoint::latest(&out, 1).unwrap();
        assert_eq!(snapshot.progress.enriched_step > 0, from != 1, "{} of {kept:?}", kept[from]);
        threads::run(ranks, |rank| start::resume(&out, Default::default(), &options(&out), &rank).unwrap());
        assert!(result(&out) == wanted, "resumed from {} on {ranks} ranks: another end", kept[from]);
    }
    series
}
