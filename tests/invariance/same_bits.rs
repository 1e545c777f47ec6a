//! Every contact law, in the plane and in space, ends in the same bits on any number of ranks and threads, with any
//! instructions, and from a checkpoint (invariants 2 and 3). A packing of its own in a cell that shears and is held at a
//! stress, with a plane, a cylinder and a glued layer in the open cells.

use std::fmt::Write;
use std::path::Path;

use scree::run::start;
use scree::store::checkpoint;
use scree_partition::Solo;

use crate::runs::{done, options, parse, replaced, same};
use crate::worlds::Random;

const LAWS: [(&str, &str); 4] = [
    (
        "linear",
        "stiffness_normal = 4e5\nstiffness_tangential = 2e5\ndamping_normal = 1.0\ndamping_tangential = 1.0\nfriction = 0.5",
    ),
    (
        "linear_cohesive",
        "stiffness_normal = 4e5\nstiffness_tangential = 2e5\ndamping_normal = 1.0\ndamping_tangential = 1.0\nfriction = 0.5\ncohesion_normal = 2.0\ncohesion_tangential = 1.0",
    ),
    (
        "elastic_rolling",
        "young_modulus = 4e8\nstiffness_ratio = 0.8\nfriction = 0.5\nrolling_stiffness = 1.0\nrolling_limit = 0.05\nsliding = \"scaled\"",
    ),
    (
        "hertz_mindlin",
        "shear_modulus = 2e9\npoisson_ratio = 0.15\nfriction = 0.5\ndamping_normal = 0.5\ndamping_tangential = 0.5",
    ),
];

/// In the plane and in space.
const STEP: [&str; 2] = ["1 us", "0.5 us"];
const END: [f64; 2] = [1.2e-3, 0.6e-3];

/// Grains near the places of a square lattice, overlapping a little, with random velocities.
fn grains(dimension: usize, sides: [usize; 3], folder: &Path) -> std::path::PathBuf {
    let mut random = Random(7);
    let mut text = String::from(match dimension {
        2 => "id,x,y,radius,vx,vy,spin\n",
        _ => "id,x,y,z,radius,vx,vy,vz,wx,wy,wz\n",
    });
    let layers = if dimension == 2 { 1 } else { sides[2] };
    let mut id = 0;
    for z in 0..layers {
        for y in 0..sides[1] {
            for x in 0..sides[0] {
                let place = [x, y, z].map(|at| 1e-3 * (at as f64 + 0.5 + 0.05 * random.signed()));
                write!(text, "{id}").unwrap();
                id += 1;
                place[..dimension].iter().for_each(|x| write!(text, ",{x:e}").unwrap());
                write!(text, ",{:e}", 5.1e-4 + 1e-5 * random.signed()).unwrap();
                (0..dimension).for_each(|_| write!(text, ",{:e}", 0.05 * random.signed()).unwrap());
                let spins = if dimension == 2 { 1 } else { 3 };
                (0..spins).for_each(|_| write!(text, ",{:e}", 20.0 * random.signed()).unwrap());
                text.push('\n');
            }
        }
    }
    let file = folder.join(format!("grains{dimension}.csv"));
    std::fs::write(&file, text).unwrap();
    file
}

/// A sphere weighs a tenth of a disc of this depth: its contacts are softer and less damped.
fn constants(dimension: usize, law: (&str, &str)) -> String {
    let softer = [
        ("4e5", "4e4"),
        ("2e5", "2e4"),
        ("= 1.0\ndamping", "= 0.02\ndamping"),
        ("damping_tangential = 1.0", "damping_tangential = 0.02"),
        ("= 0.5\ndamping", "= 0.02\ndamping"),
        ("damping_tangential = 0.5", "damping_tangential = 0.02"),
        ("4e8", "4e7"),
        ("2e9", "2e8"),
    ];
    let text = law.1.to_string();
    match dimension {
        2 => text,
        _ => softer.iter().fold(text, |text, (hard, soft)| text.replace(hard, soft)),
    }
}

/// The parts of a vector that a space has.
fn list(dimension: usize, values: [&str; 3]) -> String {
    format!("[{}]", values[..dimension].join(", "))
}

/// A job of the grains under a law, with the rest of its `[cell]` and tables of its own.
fn job(dimension: usize, law: (&str, &str), file: &Path, cell: &str, more: &str) -> String {
    format!(
        r#"
        name = "same_bits"
        [cell]
        space = "{space}"
        {cell}
        [grains]
        density = 2600
        file = "{file}"
        diameter_mean = "1 mm"
        [contact]
        law = "{name}"
        {constants}
        {more}
        [time]
        step = "{step}"
        end = {end}
        [decomposition]
        skin = "0.1 mm"
        block = "3 mm"
        [output]
        checkpoint_interval = {third}
        checkpoints_kept = 9
        "#,
        space = if dimension == 2 { "plane" } else { "solid" },
        file = file.display(),
        name = law.0,
        constants = constants(dimension, law),
        step = STEP[dimension - 2],
        end = END[dimension - 2],
        third = END[dimension - 2] / 3.0,
    )
}

/// A cell that is periodic everywhere, sheared fast, its normal stress held along y.
fn sheared(dimension: usize, law: (&str, &str), file: &Path) -> String {
    let zero = list(dimension, ["0", "0", "0"]);
    let rows = [list(dimension, ["0", "200.0", "0"]), zero.clone(), zero];
    let cell = format!(
        "upper = {}\nvelocity_gradient = [{}]\nstress_normal = {}\nrate_max = 50.0",
        if dimension == 2 { "[0.016, 0.020]" } else { "[0.009, 0.008, 0.007]" },
        rows[..dimension].join(", "),
        list(dimension, ["\"free\"", "5e4", "\"free\""]),
    );
    job(dimension, law, file, &cell, "[damping]\nlocal = 0.1\nform = \"component\"\nmass = 1.0")
}

/// An open cell with a floor, a spinning cylinder and a moving glued layer, under gravity.
fn among_bodies(dimension: usize, law: (&str, &str), file: &Path) -> String {
    let list = |values| list(dimension, values);
    let upper = if dimension == 2 { "[0.016, 0.026]" } else { "[0.009, 0.014, 0.007]" };
    let cell = format!(
        "lower = {}\nupper = {upper}\nperiodic = {}\ngravity = {}",
        list(["0", "-0.006", "0"]),
        list(["true", "false", "true"]),
        list(["0", "-9.81", "0"]),
    );
    let bodies = format!(
        r#"
        [[body]]
        name = "floor"
        shape = "plane"
        point = {zero}
        normal = {up}
        [[body]]
        name = "roller"
        shape = "cylinder"
        centre = {centre}
        radius = "2 mm"
        {axis}
        spin = {spin}
        [[body]]
        name = "lid"
        shape = "layer"
        lower = {lid}
        upper = {upper}
        velocity = {slide}
        servo = {{ direction = {up}, force = 2.0, mass = 0.01, damping = 10.0, speed_max = 0.5 }}
        "#,
        zero = list(["0", "0", "0"]),
        up = list(["0", "1", "0"]),
        centre = list(["0.004", "-0.0019", "0"]),
        axis = if dimension == 2 { "" } else { "axis = [0, 0, 1]" },
        spin = if dimension == 2 { "50.0" } else { "[0, 0, 50.0]" },
        lid = if dimension == 2 { "[0, 0.018]" } else { "[0, 0.006, 0]" },
        slide = list(["0.1", "0", "0"]),
    );
    job(dimension, law, file, &cell, &bodies)
}

fn every_law(dimension: usize, sides: [usize; 3], job: fn(usize, (&str, &str), &Path) -> String) {
    for law in LAWS {
        let folder = tempfile::tempdir().unwrap();
        let file = grains(dimension, sides, folder.path());
        let (_, series) = same(&parse(&job(dimension, law, &file)), folder.path(), law.0);
        let rows = series.lines().count();
        assert!(rows > 100, "{rows} rows");
    }
}

#[test]
fn discs_in_a_sheared_cell() {
    every_law(2, [16, 20, 1], sheared);
}

#[test]
fn spheres_in_a_sheared_cell() {
    every_law(3, [9, 8, 7], sheared);
}

#[test]
fn discs_among_bodies() {
    every_law(2, [16, 20, 1], among_bodies);
}

#[test]
fn spheres_among_bodies() {
    every_law(3, [9, 8, 7], among_bodies);
}

/// A grain drifts with its kick as soon as its forces are known, but for those that bodies push, which wait. With an account of energy
/// all grains are kicked before any drifts: where they go is the same to the bit, with damping and without.
#[test]
fn grains_that_wait_for_bodies_go_as_all_of_them_together() {
    for (dimension, sides) in [(2, [16, 20, 1]), (3, [9, 8, 7])] {
        let folder = tempfile::tempdir().unwrap();
        let file = grains(dimension, sides, folder.path());
        for damping in ["", "[damping]\nlocal = 0.1\nform = \"component\"\nmass = 100.0\n[time]"] {
            let text = among_bodies(dimension, LAWS[0], &file);
            let text = if damping.is_empty() { text } else { replaced(text, &[("[time]", damping)]) };
            let together = replaced(text.clone(), &[("checkpoints_kept = 9", "energy_balance = true")]);
            let ends = [text, together].map(|text| {
                let out = tempfile::tempdir_in(folder.path()).unwrap();
                let out = out.path().join("run");
                done(start::start(&parse(&text), &options(&out), &Solo));
                let tables = checkpoint::latest_state(&out).unwrap().1.tables;
                ["grains", "contacts", "bodies"]
                    .map(|name| tables.iter().find(|table| table.name == name).cloned().unwrap())
            });
            assert!(ends[0] == ends[1], "{dimension} {damping}");
            assert!(ends[0][1].rows > 300, "{} contacts", ends[0][1].rows);
        }
    }
}
