//! Records of other programs, repeated: LAMMPS and YADE. What each file holds and how exactly it must be met is told in
//! tests/data/README.md.

use scree::base::math;
use scree::base::space::{Plane, Space};
use scree::dem::motion::{Damping, DampingForm};
use scree::law::contact::{ElasticRolling, Sliding};

use crate::few::{Few, GrainWorld, hot_of, load_on, steps};
use crate::worlds::{Tensor, Vector, contact};

/// Rows of numbers below a header.
fn rows_of(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit() || first == '-'));
    rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// How far the world's grains, by id, are from displacements recorded in `unit` m, in two columns from `first`.
fn way_off(world: &GrainWorld<Plane>, later: &[Vec<f64>], first: usize, unit: f64) -> f64 {
    let mut worst = 0.0f64;
    for (hot, cold) in world.assembly.grains.hot.iter().zip(&world.assembly.grains.cold) {
        let row = &later[cold.id.0 as usize];
        let wanted = Vector::new(row[first] * unit, row[first + 1] * unit);
        let moved = hot.position - cold.origin + world.assembly.cell.shift(cold.image);
        worst = worst.max((moved - wanted).amax());
    }
    worst
}

/// Five hundred discs at rest against each other, relaxing in a periodic box: LAMMPS, pair granular.
#[test]
fn five_hundred_discs_relax_as_in_lammps() {
    const EDGE: f64 = 0.021_245_825_767_663_297;
    let start = rows_of(include_str!("../data/relax500/start.csv"));
    let later = rows_of(include_str!("../data/relax500/later.csv"));
    assert!(start.len() == 500 && later.len() == 500);
    let law = contact(3.5);
    let mut few = Few::<Plane>::periodic(law, 5e-7, [0.0; 3], [EDGE; 3]);
    // Thin, so that lists are made anew and memories move along on the way.
    few.settings.grains.skin = 3e-5;
    for disc in &start {
        let [radius, x, y, vx, vy, omega] = disc[..] else { panic!("six columns") };
        let mass = 25.3 * math::PI * radius * radius;
        let hot = &mut few.add([x, y, 0.0], radius, mass).hot;
        (hot.velocity, hot.spin[0]) = (Vector::new(vx, vy), omega);
    }
    let mut world = few.world();
    steps(&mut world, 1);
    let first = way_off(&world, &later, 0, 1e-18);
    steps(&mut world, 99);
    let hundredth = way_off(&world, &later, 2, 1e-17);
    steps(&mut world, 1900);
    let last = way_off(&world, &later, 4, 1e-13);
    let rebuilds = world.rebuilds;
    // The record's forces are those at its last positions: the first that the next step evaluates.
    steps(&mut world, 1);
    let (mut force_off, mut torque_off) = (0.0f64, 0.0f64);
    for (disc, row) in later.iter().enumerate() {
        let (force, torque) = load_on(&world, disc as u64);
        force_off = force_off.max((force - Vector::new(row[6], row[7]) * 1e-9).amax());
        torque_off = torque_off.max((torque[0] - row[8] * 1e-12).abs());
    }
    println!("relax500: {first:.1e}, {hundredth:.1e}, {last:.1e} m; {force_off:.1e} N, {torque_off:.1e} N m");
    assert!(rebuilds > 3 && world.rebuilds == rebuilds, "{rebuilds} rebuilds");
    assert!(first < 1e-16 && hundredth < 1e-15 && last < 1e-11, "{first:e}, {hundredth:e}, {last:e} m");
    assert!(force_off < 1e-6 && torque_off < 1e-9, "{force_off:e} N, {torque_off:e} N m");
}

/// YADE's constants of these records; `rolling`: its law with resistance to rolling.
fn elastic(friction_angle: f64, rolling: bool) -> ElasticRolling {
    ElasticRolling {
        young_modulus: 6e8,
        stiffness_ratio: 0.8,
        friction: math::tan(friction_angle),
        rolling_stiffness: if rolling { 1.0 } else { 0.0 },
        rolling_limit: if rolling { 0.05 } else { 0.0 },
        sliding: Sliding::Scaled,
    }
}

const FRICTION_ANGLE: f64 = 28.6 * math::PI / 180.0;
const THICKNESS: f64 = 0.1;
const DENSITY: f64 = 2650.0;

fn mass_of(radius: f64) -> f64 {
    DENSITY * Plane::grain_volume(radius, THICKNESS)
}

/// Largest error of a column as a share of the column's largest number.
fn two_discs(text: &str, rolling: bool) -> f64 {
    let record = rows_of(text);
    let mut few = Few::<Plane>::new(elastic(FRICTION_ANGLE, rolling), 1e-6, 0.04);
    // YADE's velocities are half a step behind from the start.
    few.settings.grains.first_kick = 1.0;
    for (disc, radius) in [0.006, 0.004].into_iter().enumerate() {
        let [x, y, vx, vy, omega] = record[0][1 + 5 * disc..][..5] else { panic!("five columns") };
        let hot = &mut few.add([x, y, 0.0], radius, mass_of(radius)).hot;
        (hot.velocity, hot.spin[0]) = (Vector::new(vx, vy), omega);
    }
    let mut world = few.world();
    let mut worst = 0.0f64;
    let scale = |column: usize| record.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
    for row in &record[1..] {
        while (world.step as f64) < row[0] {
            steps(&mut world, 1);
        }
        let mut found = Vec::new();
        for id in 0..2 {
            let hot = hot_of(&world, id);
            found.extend([hot.position[0], hot.position[1], hot.velocity[0], hot.velocity[1], hot.spin[0]]);
        }
        let [(force, torque), (_, torque_other)] = [0, 1].map(|id| load_on(&world, id));
        found.extend([force[0], force[1], torque[0], torque_other[0]]);
        for (column, found) in found.into_iter().enumerate() {
            let error = (found - row[column + 1]).abs() / scale(column + 1);
            worst = worst.max(error);
        }
    }
    assert_eq!(world.rebuilds, 0, "forces are gone at a rebuild");
    worst
}

#[test]
fn two_discs_collide_as_in_yade() {
    let friction = two_discs(include_str!("../data/two_discs_yade/friction.csv"), false);
    let rolling = two_discs(include_str!("../data/two_discs_yade/rolling.csv"), true);
    println!("two discs: friction {friction:.1e}, rolling {rolling:.1e}");
    assert!(friction < 1e-13 && rolling < 1e-13, "friction {friction:e}, rolling {rolling:e}");
}

/// Four hundred discs in a periodic cell that is sheared at 1 /s, damped by component: YADE.
#[test]
fn a_cell_is_sheared_as_in_yade() {
    const EDGES: [f64; 3] = [0.195_509_936_514_439_93, 0.199_597_894_608_101_43, 1.0];
    /// Pa, after 500 steps: xx, xy, yx, yy.
    const STRESS: [f64; 4] =
        [-129_790.209_831_670_76, 62_086.588_161_690_74, 62_070.142_443_940_21, -130_944.094_929_315_56];
    let start = rows_of(include_str!("../data/rve_shear/start.csv"));
    let later = rows_of(include_str!("../data/rve_shear/later.csv"));
    assert!(start.len() == 400 && later.len() == 400);
    let mut few = Few::<Plane>::periodic(elastic(FRICTION_ANGLE, false), 3.160_231_572_372_892_6e-5, [0.0; 3], EDGES);
    few.settings.grains.skin = 4e-4;
    few.settings.grains.first_kick = 1.0;
    few.settings.grains.drive.gradient = Tensor::new(0.0, 1.0, 0.0, 0.0);
    few.settings.grains.field.damping = Damping { local: 0.1, form: DampingForm::Component, mass: 0.0 };
    for disc in &start {
        few.add([disc[1], disc[2], 0.0], disc[0], mass_of(disc[0]));
    }
    let mut world = few.world();
    let mut errors = [0.0; 3];
    for (mark, [step, first]) in [[1, 0], [10, 2], [100, 4]].into_iter().enumerate() {
        let more = step - world.step as usize;
        steps(&mut world, more);
        errors[mark] = way_off(&world, &later, first, 1e-16);
    }
    // YADE tells the forces of the last evaluation, which are those of the instant a step before.
    steps(&mut world, 399);
    let stress = world.instant().unwrap().moment * (1.0 / (world.assembly.cell.volume() * THICKNESS));
    let mut stress_off = 0.0f64;
    for (place, wanted) in [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().zip(STRESS) {
        stress_off = stress_off.max((stress[place] - wanted).abs() / STRESS[3].abs());
    }
    println!("sheared cell: {errors:?} m, stress {stress_off:.1e}, {} rebuilds", world.rebuilds);
    assert!(world.rebuilds > 2 && errors.iter().all(|error| *error < 1e-13), "{errors:?} m");
    assert!(stress_off < 1e-6, "stress off by {stress_off:e}: {stress}");
}
