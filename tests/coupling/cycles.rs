//! Several steps of grains in one of the continuum.

use scree::base::math::{exp, ln};
use scree::domain::step::cycle::is_due;
use scree::job::Job;
use scree::mpm::scheme::Transfer;
use scree::run::start;
use scree_partition::Solo;

use crate::coupling::{DT, shaken};
use crate::runs::{done, options, result};
use crate::worlds::{exchanging, packed_job};

/// A blend acts once a cycle; with this one it takes the same out of the motion in the same time.
fn blend(grain_steps: u64) -> f64 {
    exp(ln(0.95) * grain_steps as f64 / 8.0)
}

#[test]
fn a_cycle_keeps_the_momentum_of_grains_and_points() {
    [1, 2, 4, 8].into_iter().for_each(keeps_momentum);
}

/// With an exchange between grains and nodes after every so many steps.
fn keeps_momentum(exchange: u64) {
    let mut world = shaken(&Solo);
    world.settings.grain_steps = 8;
    world.settings.grid.penalty = exchanging(exchange, DT);
    let before = world.holdings().unwrap();
    for cycle in 0..50 {
        world.advance().unwrap();
        if cycle == 25 {
            world.rebuild().unwrap();
        }
        let now = world.holdings().unwrap();
        assert_eq!(now.mass, before.mass, "cycle {cycle}");
        for axis in 0..2 {
            let speed = (now.momentum[axis] - before.momentum[axis]).abs() / now.mass;
            assert!(speed < 1e-14, "exchange after {exchange}, cycle {cycle}, axis {axis}: {speed:e} m/s");
        }
    }
    assert_eq!(world.step, 400);
}

/// The layers start half a metre per second apart: what they give each other in a while is the same in steps and in cycles, and where they
/// exchange it at the end of these alone.
#[test]
fn cycles_give_what_steps_give() {
    let given = |grain_steps: u64, exchange: u64, flip: f64| {
        let mut world = shaken(&Solo);
        world.settings.grain_steps = grain_steps;
        world.settings.grid.penalty = exchanging(exchange, DT);
        world.settings.grid.transfer = Transfer::Blend { flip };
        while world.step < 400 {
            world.advance().unwrap();
        }
        world.assembly.grains.hot.iter().map(|hot| hot.weight * hot.mass * hot.velocity[0]).sum::<f64>()
    };
    let steps = given(1, 1, blend(1));
    let far = |grain_steps: u64, exchange: u64| {
        let apart = given(grain_steps, exchange, blend(grain_steps)) - steps;
        apart.abs() / steps
    };
    let exchanged = [1, 2, 4, 8].map(|exchange| far(8, exchange));
    println!("the same in cycles of 8 with an exchange after 1, 2, 4 and 8 steps: {exchanged:?}");
    // The layers begin apart, and the first exchange is at the end of an interval.
    assert!(exchanged.is_sorted() && exchanged[0] < 2.5e-3 && exchanged[3] < 4e-2, "{exchanged:?}");
    let errors = [2, 4, 8].map(|grain_steps| far(grain_steps, 1));
    println!("momentum of grains after 400 steps, in cycles against steps: {errors:?}");
    // With volume strain averaged, which knows plastic strain by the step, half as much again as without.
    assert!(errors[0] < 6e-4 && errors[1] < 1.5e-3 && errors[2] < 2.5e-3, "{errors:?}");
    // The more the longer the cycles are, so that it is theirs.
    assert!(errors.is_sorted(), "{errors:?}");
}

/// The same curve in steps and in cycles, to detection and through enrichment.
#[test]
fn a_hybrid_in_cycles_draws_the_same_curve() {
    let folder = tempfile::tempdir().unwrap();
    let curve = |grain_steps: u64| {
        let scenario = packed_job(&[
            &format!("time.grain_steps={grain_steps}"),
            &format!("scheme.flip={}", blend(grain_steps)),
            "loading.speed=20 cm/s",
            "loading.speed_ramp=0.5 ms",
            "loading.strain_end=0.03",
            "enrichment.training_speed=4",
        ]);
        let out = folder.path().join(grain_steps.to_string());
        done(start::start(&Job::Shear(scenario), &options(&out), &Solo));
        let (_, series) = result(&out);
        let rows = series.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
        let rows = rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
        rows.collect::<Vec<Vec<f64>>>()
    };
    let [steps, cycles] = [1, 8].map(curve);
    assert_eq!(steps.len(), cycles.len());
    let peak = steps.iter().map(|row| row[3]).fold(0.0, f64::max);
    let (mut before, mut after) = (0.0f64, 0.0f64);
    for (one, other) in steps.iter().zip(&cycles) {
        let apart = (one[3] - other[3]).abs() / peak;
        match one[6] + other[6] > 0.0 {
            false => before = before.max(apart),
            true => after = after.max(apart),
        }
    }
    println!("shear stress, cycles of 8 against steps, over the peak: {before:.1e} before grains, {after:.1e} after");
    assert!(steps[steps.len() - 1][6] > 0.0, "no enrichment");
    assert!(before < 0.015 && after < 0.15, "{before} and {after}");
}

#[test]
fn everything_is_due_once_in_cycles_too() {
    for (every, together) in [(1, 1), (5, 1), (1000, 7), (50, 8), (3, 5)] {
        let due = (1..=2000).filter(|cycle| is_due(cycle * together, every, together)).count() as u64;
        let wanted = 2000 * together / every;
        assert_eq!(due, wanted.min(2000), "every {every} in cycles of {together}");
    }
}
