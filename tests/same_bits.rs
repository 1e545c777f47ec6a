//! Every contact law, in the plane and in space, ends in the same bits on any number of ranks and threads, with any
//! instructions, and from a checkpoint (invariants 2 and 3). A packing of its own in a cell that shears and is held at a
//! stress, with a plane, a cylinder and a glued layer in the open cells.

use std::fmt::Write;
use std::path::Path;

use scree::checkpoint;
use scree::run::{Options, Outcome};
use scree::scenario::Job;
use scree::start;
use scree_partition::Solo;
use scree_partition::transport::threads;

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

/// A cell that is periodic everywhere, sheared fast, its normal stress held along y.
fn sheared(dimension: usize, law: (&str, &str), file: &Path) -> Job {
    let list = |values: [&str; 3]| format!("[{}]", values[..dimension].join(", "));
    let rows = [list(["0", "200.0", "0"]), list(["0", "0", "0"]), list(["0", "0", "0"])];
    let upper = if dimension == 2 { "[0.016, 0.020]" } else { "[0.009, 0.008, 0.007]" };
    let text = format!(
        r#"
        name = "same_bits"
        [cell]
        space = "{space}"
        upper = {upper}
        velocity_gradient = [{gradient}]
        stress = {stress}
        rate_max = 50.0
        [grains]
        density = 2600
        file = "{file}"
        diameter_mean = "1 mm"
        [contact]
        law = "{name}"
        {constants}
        [damping]
        local = 0.1
        form = "component"
        mass = 1.0
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
        step = STEP[dimension - 2],
        end = END[dimension - 2],
        third = END[dimension - 2] / 3.0,
        gradient = rows[..dimension].join(", "),
        stress = list(["\"free\"", "-5e4", "\"free\""]),
        file = file.display(),
        name = law.0,
        constants = constants(dimension, law),
    );
    Job::parse(&text, "same_bits", &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// An open cell with a floor, a spinning cylinder and a moving glued layer, under gravity.
fn among_bodies(dimension: usize, law: (&str, &str), file: &Path) -> Job {
    let list = |values: [&str; 3]| format!("[{}]", values[..dimension].join(", "));
    let axis = if dimension == 2 { String::new() } else { "axis = [0, 0, 1]".to_string() };
    let text = format!(
        r#"
        name = "same_bits"
        [cell]
        space = "{space}"
        lower = {lower}
        upper = {upper}
        periodic = {periodic}
        gravity = {gravity}
        [grains]
        density = 2600
        file = "{file}"
        diameter_mean = "1 mm"
        [contact]
        law = "{name}"
        {constants}
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
        step = STEP[dimension - 2],
        end = END[dimension - 2],
        third = END[dimension - 2] / 3.0,
        lower = list(["0", "-0.006", "0"]),
        upper = if dimension == 2 { "[0.016, 0.026]" } else { "[0.009, 0.014, 0.007]" },
        periodic = list(["true", "false", "true"]),
        gravity = list(["0", "-9.81", "0"]),
        zero = list(["0", "0", "0"]),
        up = list(["0", "1", "0"]),
        centre = list(["0.004", "-0.0015", "0"]),
        spin = if dimension == 2 { "50.0" } else { "[0, 0, 50.0]" },
        lid = if dimension == 2 { "[0, 0.018]" } else { "[0, 0.006, 0]" },
        slide = list(["0.1", "0", "0"]),
        file = file.display(),
        name = law.0,
        constants = constants(dimension, law),
    );
    Job::parse(&text, "same_bits", &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn options(out: &Path) -> Options {
    Options { out: out.to_path_buf(), threads: 1 }
}

fn result(out: &Path) -> (String, String) {
    (checkpoint::digest_of(out).unwrap(), std::fs::read_to_string(out.join("series.csv")).unwrap())
}

fn done(outcome: Result<Outcome, scree::error::Error>) {
    match outcome {
        Ok(Outcome::Done(_)) => {}
        other => panic!("{other:?}"),
    }
}

/// One thread against two, three ranks and four, and a resumed run.
fn same(job: &Job, folder: &Path) {
    let alone = folder.join("alone");
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool(1).install(|| done(start::start(job, &options(&alone), &Solo)));
    let wanted = result(&alone);
    let rows = wanted.1.lines().count();
    assert!(rows > 100, "{rows} rows");
    pool(2).install(|| done(start::start(job, &options(&folder.join("threads")), &Solo)));
    assert!(result(&folder.join("threads")) == wanted, "{}: two threads end elsewhere", job.name());
    for ranks in [2, 3, 4] {
        let out = folder.join(ranks.to_string());
        threads::run(ranks, |rank| done(start::start(job, &options(&out), &rank)));
        assert!(result(&out) == wanted, "{ranks} ranks end elsewhere");
    }
    // The run of three ranks without its last checkpoints, gone on with by two.
    let out = folder.join("3");
    let mut kept: Vec<_> =
        std::fs::read_dir(checkpoint::folder(&out)).unwrap().map(|entry| entry.unwrap().path()).collect();
    kept.sort();
    assert_eq!(kept.len(), 3, "{kept:?}");
    kept[1..].iter().for_each(|later| std::fs::remove_file(later).unwrap());
    threads::run(2, |rank| done(start::resume(&out, &options(&out), &rank)));
    assert!(result(&out) == wanted, "a resumed run ends elsewhere");
}

fn every_law(dimension: usize, sides: [usize; 3], job: fn(usize, (&str, &str), &Path) -> Job) {
    for law in LAWS {
        let folder = tempfile::tempdir().unwrap();
        let file = grains(dimension, sides, folder.path());
        same(&job(dimension, law, &file), folder.path());
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
