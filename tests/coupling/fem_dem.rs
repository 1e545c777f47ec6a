//! Elements that carry grain assemblies: the RVE of an element is the one that stands alone, and nothing of ranks, threads or restarts shows.

use scree::base::space::{Solid, Space};
use scree::domain::world::World;
use scree::job::{Job, Mpm};
use scree::run::experiment::Setup;
use scree::run::grid::Points;
use scree::rve::{Rve, Scratch};
use scree_partition::Solo;

use crate::alone::{Beside, Off};
use crate::runs::{Ran, parse, same};

fn text_of(name: &str, sets: &[(&str, &str)]) -> String {
    let cache = std::env::temp_dir().join("scree-test-fem-dem").display().to_string();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/fem_dem/");
    let text = std::fs::read_to_string(format!("{folder}{name}.toml")).unwrap();
    sets.iter().fold(text.replace("\"../cache\"", &format!("{cache:?}")), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{name}: {from}");
        text.replace(from, to)
    })
}

fn job(text: &str) -> Mpm {
    let Job::Mpm(job) = parse(text) else { panic!("it has no mesh") };
    job
}

fn begun(job: &Mpm) -> World<'static, Solid> {
    Points::<Solid>::new(job).begin(&mut None, &Solo).unwrap().0
}

/// The RVE of an element, driven by the deformation gradients that the element had, comes to the same bits by itself.
#[test]
fn an_rve_alone_follows_its_element() {
    let job = job(&text_of("wave", &[("count = 400", "count = 300")]));
    let mut world = begun(&job);
    let mut alone: Rve<Solid> = world.rves[7].rve.clone();
    let (drive, scratch) = (job.grains.as_ref().unwrap().rves.drive, &mut Scratch::default());
    for step in 0..60 {
        world.advance().unwrap();
        let hot = &world.continuum.points.hot[7];
        let answer = alone.follow(&hot.deformation, job.step, &drive, scratch).unwrap();
        assert_eq!(answer.kirchhoff, hot.stress, "step {step}");
        assert!(world.rves[7].rve.rest() == alone.rest(), "step {step}");
    }
    assert!((*alone.deformation() - Solid::identity()).norm() > 1e-5);
}

/// What an element under a constant pressure on one side is off its RVE by that is compressed by itself (Liu et al. 2016, 3.2), to the peak.
fn element_off_its_rve(seed: u64) -> Off {
    const PRESSURE: f64 = 416e3;
    let seeded = format!("seed = {seed}\nmethod = ");
    let sets = [("\"50 ms\"", "\"10 ms\""), ("-1.27 mm/s", "-0.5 mm/s"), ("method = ", seeded.as_str())];
    let job = job(&text_of("element_biaxial", &sets));
    let mut world = begun(&job);
    let mut beside = Beside::new(&world.rves[0].rve, PRESSURE, job.grains.as_ref().unwrap().rves.drive);
    // The peak is at 0.3 %.
    while beside.along() > 0.9965 {
        world.advance().unwrap();
        let hot = &world.continuum.points.hot[0];
        let cauchy = |axis: usize| -hot.kirchhoff()[4 * axis] / hot.volume_ratio();
        beside.compare([cauchy(0), cauchy(1)], &hot.deformation, job.step);
    }
    beside.off()
}

#[test]
fn an_element_is_its_rve() {
    let off = element_off_its_rve(1);
    println!("an element: {off}");
    assert!(off.to_peak < 5e-3 && off.across < 1e-3 && off.left < 1e-4, "{off}");
}

#[test]
#[ignore = "a minute"]
fn elements_of_six_packings_are_their_rves() {
    for seed in 1..=6 {
        let off = element_off_its_rve(seed);
        println!("an element of the packing of seed {seed}: {off}");
        assert!(off.to_peak < 1e-2 && off.across < 1e-3 && off.left < 1e-4, "{off}");
    }
}

/// The same bits on ranks and threads, through restarts, with a weak row and a nonlocal strain.
#[test]
fn elements_of_grains_end_in_the_same_bits() {
    let sets = [
        ("count = 4096", "count = 300"),
        ("elements = [5, 12, 1]", "elements = [2, 12, 1]"),
        ("end = \"0.241 s\"", "end = \"0.25 ms\""),
        ("series_interval = \"0.5 ms\"", "series_interval = \"0.05 ms\"\ncheckpoint_interval = \"0.1 ms\""),
        (
            "frame_interval = \"12 ms\"",
            "frame_interval = \"0.1 ms\"\nenergy_balance = true\n[nonlocal]\nradius = \"25 mm\"",
        ),
        ("ramp = \"10 ms\"", "ramp = \"0.1 ms\""),
    ];
    let folder = tempfile::tempdir().unwrap();
    same(&parse(&text_of("simple_shear", &sets)), folder.path(), "simple shear");
}

/// The direct simulation of simple shear, of few copies: open ends, layers and the room beyond them, on ranks and threads and through a restart.
#[test]
fn copies_between_layers_end_in_the_same_bits() {
    let edge = "0.012998174296788059";
    let cell = format!("upper = [{edge}, {edge}, {edge}]");
    let sets = [
        ("count = 4096", "count = 300"),
        (cell.as_str(), "upper = [\"5.44 mm\", \"5.44 mm\", \"5.44 mm\"]"),
        ("copies = [4, 10, 1]", "copies = [2, 3, 1]"),
        ("upper = [\"51.9 mm\", \"4.75 mm\", \"12.9 mm\"]", "upper = [\"10.8 mm\", \"1.5 mm\", \"5.4 mm\"]"),
        ("lower = [0, \"122.75 mm\", 0]", "lower = [0, \"14.5 mm\", 0]"),
        ("upper = [\"51.9 mm\", \"129.9 mm\", \"12.9 mm\"]", "upper = [\"10.8 mm\", \"16.3 mm\", \"5.4 mm\"]"),
        ("ramp = \"5 ms\"", "ramp = \"10 us\""),
        ("end = \"62 ms\"", "end = \"36 us\""),
        ("series_interval = \"0.1 ms\"", "series_interval = \"6 us\"\ncheckpoint_interval = \"12 us\""),
        ("frame_interval = \"5 ms\"", "frame_interval = \"12 us\"\nenergy_balance = true"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let (_, series) = same(&parse(&text_of("dns_simple_shear", &sets)), folder.path(), "copies between layers");
    assert!(series.lines().count() > 5, "{series}");
}

/// Where grains have been taken out of the unit cell it bears the same pressure, with fewer contacts.
#[test]
fn a_weak_row_bears_the_same_pressure_with_fewer_contacts() {
    let sets = [("count = 4096", "count = 300"), ("elements = [5, 12, 1]", "elements = [2, 12, 1]")];
    let world = begun(&job(&text_of("simple_shear", &sets)));
    let grains: Vec<usize> = world.rves.iter().map(|carried| carried.rve.grains()).collect();
    let weak = grains.iter().filter(|grains| **grains == 275).count();
    assert_eq!((weak, grains.iter().filter(|grains| **grains == 300).count()), (2, 22), "{grains:?}");
    let ratio = |carried: &scree::rve::PointRve<Solid>| carried.rve.void_ratio();
    let of = |count: usize| world.rves.iter().find(|carried| carried.rve.grains() == count).unwrap();
    assert!(ratio(of(275)) > ratio(of(300)));
    // All together: voids over solid, of which weak elements have less.
    let masses = world.continuum.points.hot.iter().map(|hot| hot.mass);
    let solid: f64 = masses.clone().sum();
    let voids: f64 = masses.zip(&world.rves).map(|(mass, carried)| mass * ratio(carried)).sum();
    let found = world.rve_totals().unwrap().void_ratio;
    assert!((found / (voids / solid) - 1.0).abs() < 1e-12, "{found} {}", voids / solid);
    assert!(ratio(of(300)) < found && found < ratio(of(275)));
    for hot in &world.continuum.points.hot {
        let stress = hot.kirchhoff();
        (0..9).for_each(|at| {
            let wanted = if at % 4 == 0 { -416e3 } else { 0.0 };
            assert!((stress[at] - wanted).abs() < 0.02 * 416e3, "{at}: {}", stress[at]);
        });
    }
}

/// What the heads of the jobs say takes seconds does, and shows what it is about.
#[test]
fn the_jobs_run_in_seconds() {
    let shear =
        Ran::of(&text_of("element_shear", &[("count = 400", "count = 300"), ("end = \"1 s\"", "end = \"0.3 s\"")]));
    let peak = shear.series("stress_xy").iter().map(|stress| -stress).fold(f64::NEG_INFINITY, f64::max).abs();
    let top = *shear.series("top_force_y").last().unwrap();
    assert!(
        (0.3..0.9).contains(&(peak.max(shear.series("stress_xy").into_iter().fold(0.0, f64::max)) / 416e3)),
        "{peak}"
    );
    assert!((top / 67.1 - 1.0).abs() < 0.02, "{top}");
    let wave = Ran::of(&text_of("wave", &[("count = 400", "count = 300"), ("end = \"1 ms\"", "end = \"0.2 ms\"")]));
    let swing = wave.series("element_9_displacement_y").into_iter().fold(0.0, f64::max);
    assert!((1e-6..1e-4).contains(&swing), "{swing}");
    let biaxial = [
        ("count = 1000", "count = 300"),
        ("elements = [5, 10, 1]", "elements = [3, 6, 1]"),
        ("end = \"0.133 s\"", "end = \"2 ms\""),
    ];
    let biaxial = Ran::of(&text_of("biaxial", &biaxial));
    let lateral = biaxial.series("stress_xx").last().unwrap() / -416e3;
    assert!((0.97..1.03).contains(&lateral), "{lateral}");
}
