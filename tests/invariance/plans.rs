//! Plans hold what runs do: messages, bytes and loads of a run on more ranks than have been measured.

use scree::domain::plan::{LoadMap, Loss, Network, forecast};
use scree::job::Job;
use scree::run::output::load_file;
use scree::run::start;
use scree_partition::transport::threads;
use serde_json::Value;

use crate::runs::{done, options};
use crate::worlds::packed_job;

const NETWORK: Network = Network { latency: 1e-6, bandwidth: 5e9 };

fn ran(job: &Job, ranks: usize, out: &std::path::Path) -> (LoadMap, Value) {
    threads::run(ranks, |rank| done(start::start(job, &options(out), &rank)));
    let read = |path: std::path::PathBuf| std::fs::read_to_string(path).unwrap();
    let map = serde_json::from_str(&read(load_file(out))).unwrap();
    (map, serde_json::from_str(&read(out.join("summary.json"))).unwrap())
}

/// Grains alone, points alone, and both after enrichment, planned for four ranks from a run on one.
#[test]
fn a_run_on_one_rank_foresees_what_four_send() {
    let folder = tempfile::tempdir().unwrap();
    let jobs: [(&str, &[&str]); 3] = [
        ("dem", &["method=dem", "loading.strain_end=0.004"]),
        ("mpm", &["method=mpm", "loading.strain_end=0.01"]),
        (
            "hybrid",
            &[
                "loading.speed=20 cm/s",
                "loading.speed_ramp=0.5 ms",
                "loading.strain_end=0.15",
                "enrichment.training_speed=4",
            ],
        ),
    ];
    for (name, sets) in jobs {
        let job = Job::Shear(packed_job(sets));
        let (map, _) = ran(&job, 1, &folder.path().join(format!("{name}1")));
        let (_, summary) = ran(&job, 4, &folder.path().join(format!("{name}4")));
        let foreseen = forecast(&map, 1, &NETWORK, 4).unwrap();
        let found = |key: &str| summary[key].as_f64().unwrap();
        let off = |foreseen: f64, found: f64| foreseen / found - 1.0;
        let messages = off(foreseen.messages as f64, found("messages_per_step"));
        let bytes = off(foreseen.bytes as f64, found("bytes_per_step"));
        println!("{name}: messages {messages:+.3}, bytes {bytes:+.3}, most over mean {:.3}", foreseen.imbalance);
        // Deals differ by what was measured: of two dozen blocks, half of them with points, four ranks have 6 pairs of neighbours
        // by one measurement and 10 by another; a hybrid's
        // figures are means over a run that was a continuum before, and four ranks on two busy cores go on for a while
        // with a deal that was made for that: fewer messages than are foreseen, by up to a half.
        let [of_messages, of_bytes] = match name {
            "dem" => [0.01, 0.01],
            "mpm" => [1.0, 0.1],
            _ => [1.2, 0.6],
        };
        assert!(messages.abs() < of_messages && bytes.abs() < of_bytes, "{name}: {messages} {bytes}");
        assert!(foreseen.imbalance < 1.5 && foreseen.step > foreseen.work, "{name}: {foreseen:?}");
    }
}

/// A world of uniform blocks whose figures can be reckoned by hand.
fn uniform() -> LoadMap {
    let blocks = 64;
    LoadMap {
        dimension: 2,
        blocks: [8, 8, 1],
        periodic: [true, true, false],
        grains: vec![100; blocks],
        coupled: vec![0; blocks],
        points: vec![0; blocks],
        near: vec![(0..8).map(|neighbour| (1 << neighbour, 10)).collect(); blocks],
        shared: Vec::new(),
        nodes: 0,
        costs: [20e-9, 0.0, 0.0, 0.0],
        pairs: Vec::new(),
        pair_cost: 0.0,
        words: [5, 0, 0],
        passes: 0,
        beside: [0; 2],
        reductions: 1,
        rebuilds: 0.0,
        rebuild_cost: 0.0,
        output: 0.0,
        ranks: 1,
        threads: 1,
        steps: 1,
    }
}

#[test]
fn uniform_blocks_are_reckoned_as_by_hand() {
    let map = uniform();
    let one = forecast(&map, 1, &NETWORK, 1).unwrap();
    assert!((one.step - 64.0 * 100.0 * 20e-9).abs() < 1e-12 && one.messages == 0 && one.bytes == 0, "{one:?}");
    // Four quadrants of 16 blocks: each has 12 blocks at its border, with 3 neighbours of others at a side and 5 at a corner.
    let four = forecast(&map, 1, &NETWORK, 4).unwrap();
    assert_eq!(four.messages, 4 * 3);
    assert_eq!(four.bytes, 4 * (8 * 3 + 4 * 5) * 10 * 5 * 8);
    assert_eq!(four.imbalance, 1.0);
    let hand = 16.0 * 100.0 * 20e-9 + 3.0 * 1e-6 + f64::from((8 * 3 + 4 * 5) * 10 * 5 * 8) / 5e9 + 2.0 * 1e-6;
    assert!((four.step - hand).abs() < 1e-12, "{four:?}, by hand {hand}");
    // Sixteen of them side by side on 16 times the ranks have the same share each.
    let many = forecast(&map, 16, &NETWORK, 64).unwrap();
    // Beside them are others on either side now: two more corners.
    assert_eq!((many.bytes, many.messages), (16 * four.bytes, 64 * 5));
    assert!((many.imbalance - 1.0).abs() < 1e-12);
    // More ranks than blocks: blocks are what there is too little of.
    let idle = forecast(&map, 1, &Network { latency: 1e-9, ..NETWORK }, 128).unwrap();
    assert!((idle.imbalance - 2.0).abs() < 1e-12 && idle.bottleneck().0 == Loss::Imbalance, "{idle:?}");
}
