//! Cells held at a stress, as jobs run: how closely the stress is followed, and that a row of their series is of one instant.

use scree::base::space::{Plane, Space, Words};
use scree::domain::step::full_step::full_step;
use scree::job::Job;
use scree::prepare::grain_world::GrainWorld;
use scree::run::assembly::InSpace;
use scree::run::start::{self, world_of};
use scree::store::checkpoint;
use scree_partition::Solo;

use crate::runs::{Ran, done, options, parse, replaced};
use crate::worlds::{Random, Tensor, Vector};

/// Discs of Table 1 of Liang & Zhao (2019), compressed to 100 kPa and then along y at I = 5e-4, sigma_xx held.
const DENSE: &str = r#"
    name = "held"
    [cell]
    space = "plane"
    upper = ["10 cm", "10 cm"]
    depth = "10 cm"
    velocity_gradient = [[0, 0], [0, "-0.3 1/s"]]
    stress_normal = ["100 kPa", "free"]
    rate_max = "30 1/s"
    [grains]
    density = 2650
    count = 100
    distribution = "uniform"
    diameter_min = "6 mm"
    diameter_max = "14 mm"
    [packing]
    preparation = "compress"
    stress = "100 kPa"
    friction = 0.0
    [contact]
    law = "elastic_rolling"
    young_modulus = "600 MPa"
    stiffness_ratio = 0.8
    friction_angle = "28.6 deg"
    [damping]
    local = 0.1
    form = "component"
    [time]
    step = "25 us"
    end = "0.2 s"
    [output]
    series_interval = "0.5 ms"
"#;

/// Spheres under Hertz' law with dashpots, both lateral stresses held.
const SPHERES: &str = r#"
    name = "held"
    [cell]
    space = "solid"
    upper = ["7 mm", "7 mm", "7 mm"]
    velocity_gradient = [[0, 0, 0], [0, 0, 0], [0, 0, "-5 1/s"]]
    stress_normal = ["100 kPa", "150 kPa", "free"]
    rate_max = "500 1/s"
    [grains]
    density = 2650
    count = 200
    distribution = "uniform"
    diameter_min = "0.8 mm"
    diameter_max = "1.2 mm"
    [packing]
    preparation = "compress"
    stress = "100 kPa"
    [contact]
    law = "hertz_mindlin"
    shear_modulus = "2 GPa"
    poisson_ratio = 0.2
    damping_normal = 0.05
    damping_tangential = 0.05
    friction = 0.5
    [time]
    step = "0.15 us"
    end = "2 ms"
    [output]
    series_interval = "3 us"
"#;

/// The job with its packing in a folder of its own.
fn ran(text: &str, changes: &[(&str, &str)]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let cache = format!("preparation = \"compress\"\n    cache = \"{}\"", folder.path().display());
    let text = replaced(text.to_string(), changes);
    Ran::of(&replaced(text, &[("preparation = \"compress\"", &cache)]))
}

/// Root of the mean square and the worst of a column of root mean squares, as shares of a stress, from the fourth part of the
/// run on: there the jump of the rate at the start is past.
fn shares(ran: &Ran, column: &str, stress: f64) -> [f64; 2] {
    let errors = ran.series(column);
    let errors = &errors[errors.len() / 4..];
    let square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    [square.sqrt() / stress, errors.iter().fold(0.0, |most, error| f64::max(most, *error)) / stress]
}

#[test]
fn stress_is_followed_in_a_dense_cell() {
    let [mean, worst] = shares(&ran(DENSE, &[]), "stress_error_xx", 1e5);
    println!("dense: {:.4} % and {:.3} %", 100.0 * mean, 100.0 * worst);
    assert!(mean < 2e-3 && worst < 0.02, "{mean:e}, worst {worst:e}");
}

/// Seven times softer against its stress, with resistance to rolling.
#[test]
fn stress_is_followed_in_a_soft_cell() {
    let soft = ran(
        DENSE,
        &[
            (
                "young_modulus = \"600 MPa\"",
                "young_modulus = \"80 MPa\"\n    rolling_stiffness = 1.0\n    rolling_limit = 0.02",
            ),
            ("friction = 0.0", "friction = 0.3"),
        ],
    );
    let [mean, worst] = shares(&soft, "stress_error_xx", 1e5);
    println!("soft: {:.4} % and {:.3} %", 100.0 * mean, 100.0 * worst);
    assert!(mean < 2e-3 && worst < 0.02, "{mean:e}, worst {worst:e}");
}

/// Dashpots answer to a rate at once: a control that took them for springs would turn its rate round at every look.
#[test]
fn stresses_are_followed_in_a_cell_of_damped_spheres() {
    let spheres = ran(SPHERES, &[]);
    for (column, stress) in [("stress_error_xx", 1e5), ("stress_error_yy", 1.5e5)] {
        let [mean, worst] = shares(&spheres, column, stress);
        println!("spheres, {column}: {:.4} % and {:.3} %", 100.0 * mean, 100.0 * worst);
        assert!(mean < 2e-3 && worst < 0.02, "{column}: {mean:e}, worst {worst:e}");
    }
}

/// Discs that do not touch have no stiffness to go by: the cell closes at its limit until they bear.
#[test]
fn a_cell_without_contacts_closes_and_holds_its_stress() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(5);
    let mut text = String::from("id,x,y,radius,vx,vy,spin\n");
    for place in 0..64 {
        let [x, y] = [place % 8, place / 8].map(|at| 1.1e-2 * (f64::from(at) + 0.5) + 4e-4 * random.signed());
        text += &format!("{place},{x:e},{y:e},{:e},0,0,0\n", 4.5e-3 * (1.0 + 0.1 * random.signed()));
    }
    let file = folder.path().join("grains.csv");
    std::fs::write(&file, text).unwrap();
    let read = format!("file = \"{}\"\n    diameter_mean = \"9 mm\"", file.display());
    let (made, packing) = (DENSE.find("count").unwrap(), DENSE.find("[packing]").unwrap());
    let text = format!("{}{read}\n    {}", &DENSE[..made], &DENSE[DENSE.find("[contact]").unwrap()..]);
    assert!(made < packing);
    let loose = Ran::of(&replaced(
        text,
        &[
            ("upper = [\"10 cm\", \"10 cm\"]", "upper = [\"8.8 cm\", \"8.8 cm\"]"),
            ("[0, \"-0.3 1/s\"]]", "[0, 0]]"),
            ("[\"100 kPa\", \"free\"]", "[\"100 kPa\", \"50 kPa\"]"),
            ("rate_max = \"30 1/s\"", "rate_max = \"3 1/s\""),
            ("local = 0.1", "local = 0.3"),
            ("end = \"0.2 s\"", "end = \"0.4 s\""),
        ],
    ));
    assert_eq!(loose.series("contacts")[0], 0.0);
    for (stress, target) in [("stress_xx", -1e5), ("stress_yy", -5e4)] {
        let found = *loose.series(stress).last().unwrap();
        assert!((found / target - 1.0).abs() < 1e-3, "{stress}: {found} Pa for {target} Pa");
    }
}

/// Kinetic energy of velocities at the full step, stress of the forces that the next step begins with over branches of the
/// state, and edges of the cell: all as an exported state of the row's step has them.
#[test]
fn a_row_is_of_the_instant_of_its_state() {
    let folder = tempfile::tempdir().unwrap();
    let cache = format!("preparation = \"compress\"\n    cache = \"{}\"", folder.path().display());
    let changes = [
        ("preparation = \"compress\"", cache.as_str()),
        ("end = \"0.2 s\"", "end = \"25.025 ms\""),
        ("series_interval = \"0.5 ms\"", "series_interval = \"25 us\""),
        ("[[0, 0], [0, \"-0.3 1/s\"]]", "[[0, \"3 1/s\"], [0, \"-0.3 1/s\"]]"),
    ];
    let text = replaced(DENSE.to_string(), &changes);
    let out = folder.path().join("run");
    done(start::start(&parse(&text), &options(&out), &Solo));
    let series = std::fs::read_to_string(out.join("series.csv")).unwrap();
    let names: Vec<&str> = series.lines().next().unwrap().split(',').collect();
    let last: Vec<f64> = series.lines().last().unwrap().split(',').map(|word| word.parse().unwrap()).collect();
    let of = |name: &str| last[names.iter().position(|other| *other == name).unwrap()];
    assert_eq!(of("step"), 1001.0);

    let Job::Assembly(job) = parse(&text) else { panic!("it has a cell") };
    let state = || -> GrainWorld<Plane> {
        let (_, state) = checkpoint::latest_state(&out).unwrap();
        world_of(&InSpace::<Plane>::new(&job), Some(state), &Solo).unwrap().0
    };
    let now = state();
    let mut ids: Vec<(u64, usize)> =
        now.assembly.grains.cold.iter().enumerate().map(|(row, cold)| (cold.id.0, row)).collect();
    ids.sort_unstable();
    let full = full_step(state()).unwrap();
    let mut kinetic = [0.0; 2];
    for ((_, row), grain) in ids.iter().zip(&full.grains) {
        let hot = &now.assembly.grains.hot[*row];
        kinetic[0] += 0.5 * hot.mass * grain.velocity.dot(&grain.velocity);
        kinetic[1] += 0.5 * Plane::grain_inertia(hot.mass, hot.radius) * grain.spin.dot(&grain.spin);
    }
    let mut next = state();
    next.assembly.forces_wanted = true;
    next.advance().unwrap();
    assert_eq!(next.rebuilds, 0, "forces are gone at a rebuild");
    let mut moment = Tensor::new(0.0, 0.0, 0.0, 0.0);
    for (at, pair) in next.assembly.contacts.neighbours.real_pairs() {
        let given = next.assembly.contacts.given(at).force;
        let force = Vector::new(given.word(0), given.word(1));
        let [a, b] = [pair.a, pair.b()].map(|row| now.assembly.grains.hot[row as usize].position);
        moment -= Plane::outer(&force, &(a - b + now.assembly.cell.shift(pair.image().image())));
    }
    let stress = moment * (1.0 / (now.assembly.cell.volume() * 0.1));
    let wanted = [
        ("kinetic_translation", kinetic[0], kinetic[0]),
        ("kinetic_rotation", kinetic[1], kinetic[1]),
        ("stress_xx", stress[(0, 0)], 1e5),
        ("stress_xy", stress[(0, 1)], 1e5),
        ("stress_yx", stress[(1, 0)], 1e5),
        ("stress_yy", stress[(1, 1)], 1e5),
        ("edge_xy", now.assembly.cell.edges[(0, 1)], 0.1),
    ];
    for (name, wanted, scale) in wanted {
        let off = (of(name) - wanted).abs() / scale;
        println!("{name}: {} for {wanted}, off by {off:.1e}", of(name));
        assert!(off < 1e-12, "{name}: {} for {wanted}", of(name));
    }
    assert!((stress[(0, 1)] - stress[(1, 0)]).abs() > 1e-6 * 1e5, "it could be either");
}

/// Tension at grains that hold on to nothing once grew the cell tenfold, and the run ended as if all were well.
#[test]
fn a_cell_that_grows_with_nothing_bearing_its_load_stops_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let cache = format!("preparation = \"compress\"\n    cache = \"{}\"", folder.path().display());
    let pulled = [
        ("preparation = \"compress\"", cache.as_str()),
        ("velocity_gradient = [[0, 0], [0, \"-0.3 1/s\"]]\n", ""),
        ("\"100 kPa\", \"free\"", "\"-1 MPa\", \"free\""),
        ("end = \"0.2 s\"", "end = \"0.3 s\""),
    ];
    let text = replaced(DENSE.to_string(), &pulled);
    let run = |text: &str, out: &str| start::start(&parse(text), &options(&folder.path().join(out)), &Solo);
    let error = run(&text, "pulled").expect_err("it went on to its end");
    let told = error.to_string();
    assert_eq!(error.exit_code(), 3, "{told}");
    for wanted in [
        "the cell has grown until its grains fill 0.",
        "of the -1000000 Pa that cell.stress_normal holds x at",
        "Compression is positive in cell.stress_normal: write it positive",
    ] {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    // The same load the other way round, or at grains that bear it, is an ordinary run.
    let pressed = replaced(text.clone(), &[("\"-1 MPa\", \"free\"", "\"100 kPa\", \"free\""), ("0.3 s", "0.05 s")]);
    assert!(run(&pressed, "pressed").is_ok());
}
