//! Volume strain that is averaged as material flows: stresses of points at rest after a slump, energy, and what is left alone.

use std::path::Path;

use crate::runs::{Ran, replaced};

const HEIGHT: f64 = 5.5;
const WEIGHT: f64 = 1800.0 * 9.81;
const CELL: f64 = 0.5;

fn job(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/continuum").join(name)).unwrap()
}

/// The slumped dam at rest.
struct Slumped {
    /// Largest p over that of its height at the start.
    largest: f64,
    /// Share of points that bear less than a pascal.
    idle: f64,
    /// Standard deviation of p over the weight above, of points from 1 to 3 m deep.
    scatter: f64,
    /// Within which 99 % of the mass lie, m.
    run_out: f64,
}

fn slumped(points_per_cell: usize, averaging: bool) -> Slumped {
    let ran = Ran::of(&replaced(
        job("dam.toml"),
        &[
            ("points_per_cell = 2", &format!("points_per_cell = {points_per_cell}")),
            ("volume_averaging = true", &format!("volume_averaging = {averaging}")),
            ("frame_interval = \"0.5 s\"", "frame_interval = \"15 s\""),
        ],
    ));
    let (places, masses) = (ran.points("position"), ran.points("mass"));
    let pressure = |(stress, f): (&Vec<f64>, Vec<f64>)| -0.5 * (stress[0] + stress[1]) / (f[0] * f[3] - f[1] * f[2]);
    let pressures: Vec<f64> = ran.points("stress").iter().zip(ran.points("deformation")).map(pressure).collect();
    let column = |place: &Vec<f64>| (place[0] / CELL) as usize;
    let mut surface = [0.0; 100];
    let half = 0.5 * CELL / points_per_cell as f64;
    places.iter().for_each(|place| surface[column(place)] = f64::max(surface[column(place)], place[1] + half));
    let depth = |place: &Vec<f64>| surface[column(place)] - place[1];
    let deep = places.iter().zip(&pressures).filter(|(place, _)| (1.0..3.0).contains(&depth(place)));
    let shares: Vec<f64> = deep.map(|(place, pressure)| pressure / (WEIGHT * depth(place))).collect();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let square = shares.iter().map(|share| (share - mean) * (share - mean)).sum::<f64>() / shares.len() as f64;
    let mut along: Vec<(f64, f64)> =
        places.iter().map(|place| place[0]).zip(masses.iter().map(|mass| mass[0])).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = along.iter().map(|(_, mass)| mass).sum();
    let mut so_far = 0.0;
    let within = |(_, mass): &&(f64, f64)| {
        so_far += mass;
        so_far >= 0.99 * whole
    };
    Slumped {
        largest: pressures.iter().fold(0.0, |most: f64, p| most.max(*p)) / (WEIGHT * HEIGHT),
        idle: pressures.iter().filter(|p| **p < 1.0).count() as f64 / pressures.len() as f64,
        scatter: square.sqrt(),
        run_out: along.iter().find(within).unwrap().0,
    }
}

#[test]
fn points_of_a_slumped_dam_bear_what_lies_above_them() {
    let (with, without, single) = (slumped(2, true), slumped(2, false), slumped(1, false));
    for (name, dam) in [("averaged", &with), ("not averaged", &without), ("a point a cell", &single)] {
        println!(
            "{name}: largest {:.2}, idle {:.1} %, scatter {:.2}, run-out {:.2} m",
            dam.largest,
            100.0 * dam.idle,
            dam.scatter,
            dam.run_out
        );
    }
    assert!(with.largest < 1.1 && with.idle < 0.02 && with.scatter < 0.25);
    assert!((with.run_out / single.run_out - 1.0).abs() < 0.03, "{} for {}", with.run_out, single.run_out);
    assert!(without.largest > 1.5 && without.scatter > 0.4, "there is no noise to be ended");
}

/// Without cohesion nothing is gained at any row of the series, and the account still closes.
#[test]
fn energy_of_averaging_is_booked_and_only_lost() {
    let text = replaced(
        job("column_collapse.toml"),
        &[
            ("cell = \"62.5 mm\"", "cell = 0.125"),
            ("end = \"2.5 s\"", "end = \"0.8 s\""),
            ("[output]", "[output]\nenergy_balance = true"),
        ],
    );
    let ran = Ran::of(&text);
    let (averaging, lost) = (ran.series("energy_lost_averaging"), ran.series("energy_lost"));
    assert!(averaging.windows(2).all(|pair| pair[1] >= pair[0]), "{averaging:?}");
    let (averaging, lost, dissipated) =
        (*averaging.last().unwrap(), *lost.last().unwrap(), *ran.series("dissipated").last().unwrap());
    println!("averaging {averaging:.3e} J of {lost:.3e} J lost, dissipated {dissipated:.3e} J");
    assert!(averaging > 1e-6 * dissipated && averaging < 0.05 * dissipated);
}

/// A job that does not flow ends with the same bits, whether it would average or not.
#[test]
fn material_that_does_not_flow_is_left_alone_to_the_bit() {
    let text = replaced(job("prandtl_cohesive.toml"), &[("cohesion = \"10 kPa\"", "cohesion = \"10 GPa\"")]);
    let cell = text.lines().find(|line| line.starts_with("cell = ")).unwrap();
    let text = text.replace(cell, "cell = 0.25");
    let without = text.replace("points_per_cell = 1", "points_per_cell = 1\nvolume_averaging = false");
    let [with, without] = [text, without].map(|text| Ran::of(&text));
    assert!(with.series("footing_force_y").last().unwrap().abs() > 1.0);
    for column in ["position", "stress", "deformation", "strain"] {
        assert_eq!(with.points(column), without.points(column), "{column}");
    }
}
