//! A run that has left physics stops and names the two that show it: overlaps that no law means, with grains and with bodies,
//! and energy that nobody has put in.

use scree::body::{Body, Shape};
use scree::observe::guard::EnergyGuard;
use scree::run::{Options, Outcome};
use scree::scenario::Job;
use scree::space::{Linear, Plane, Space};
use scree::start;
use scree_partition::Solo;

use crate::few::{Few, MASS, RADIUS, linear, steps, vector};

/// Discs of 1 mm as rows of a file, bodies as tables of a job, over some steps of 0.4 us in an open cell.
fn run(grains: &str, bodies: &str, steps: u64, sets: &[&str]) -> Result<Outcome, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.csv");
    std::fs::write(&file, format!("id,x,y,radius,vx,vy,spin\n{grains}")).unwrap();
    let text = format!(
        r#"
        name = "guard"
        [cell]
        space = "plane"
        lower = ["-20 mm", "-20 mm"]
        upper = ["20 mm", "20 mm"]
        periodic = [false, false]
        [grains]
        density = 2530
        file = "{}"
        diameter_mean = "1 mm"
        [contact]
        law = "linear"
        stiffness_normal = 17720
        stiffness_tangential = 8860
        damping_normal = 0
        damping_tangential = 0
        friction = 0.5
        [time]
        step = "0.4 us"
        end = {:e}
        {bodies}
        "#,
        file.display(),
        0.4e-6 * steps as f64
    );
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    let job = Job::parse(&text, "job.toml", &sets).unwrap_or_else(|error| panic!("{error}"));
    let options = Options::new(folder.path().join("run"), 1);
    start::start(&job, &options, &Solo).map_err(|error| error.to_string())
}

#[track_caller]
fn stops(outcome: Result<Outcome, String>, wanted: &str) {
    let found = outcome.expect_err("the run went on to its end");
    assert!(found.contains(wanted), "{found}");
}

const FLOOR: &str = "[[body]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0]\nnormal = [0, 1]\n";
const SLAB: &str =
    "[[body]]\nname = \"slab\"\nshape = \"box\"\nlower = [\"-5 mm\", \"-0.4 mm\"]\nupper = [\"5 mm\", 0]\n";

/// They were through one another within a hundred steps, between two looks.
#[test]
fn fast_grains_do_not_pass_through_one_another_between_two_looks() {
    stops(run("0,-0.002,0,0.0005,40,0,0\n1,0.002,0,0.0005,-40,0,0\n", "", 500, &[]), "grains 0 and 1 overlap by");
}

#[test]
fn a_grain_does_not_sink_into_a_body_or_fly_through_it() {
    let grain = "7,0,0.001,0.0005,0,-30,0\n";
    stops(run(grain, FLOOR, 500, &[]), "grain 7 and body `floor` overlap by");
    stops(run(grain, SLAB, 500, &[]), "grain 7 and body `slab` overlap by");
    assert!(run("7,0,0.001,0.0005,0,-3,0\n", FLOOR, 2000, &[]).is_ok(), "a tenth of that speed is a collision");
}

/// A disc between two plates, at a step at which it swings ever farther: it is a look at the first step that tells.
#[test]
fn energy_that_grows_before_the_second_look_stops_the_run() {
    let lid =
        FLOOR.replace("floor", "lid").replace("point = [0, 0]", "point = [0, 0.0008]").replace("[0, 1]", "[0, -1]");
    let sets = ["time.step=4.745e-5", "time.end=1.5e-3", "time.allow_unstable=true"];
    let outcome = run("0,0,0.0004,0.0005,0,0.01,0\n", &format!("{FLOOR}{lid}"), 1, &sets);
    stops(outcome, "J since step 1 while 0.000e0 J of work were done; the deepest contact is that of grain 0 and body");
}

/// What energy has grown since the last look is found at a look, and the contact with a body is named where no grains touch.
#[test]
fn energy_from_nowhere_names_the_contact_with_a_body() {
    let mut few = Few::<Plane, _>::new(linear(), 2e-7, 24.0 * RADIUS);
    let up = vector::<Plane>([0.0, 1.0, 0.0]);
    few.bodies.push(Body::new("table", Shape::Plane { point: <Plane as Space>::Vector::zero(), normal: up }));
    few.add([0.0, 0.99 * RADIUS, 0.0], RADIUS, MASS);
    let mut world = few.world();
    let mut guard = EnergyGuard::default();
    steps(&mut world, 1);
    guard.look(&mut world).unwrap();
    steps(&mut world, 1);
    guard.look(&mut world).unwrap();
    world.grains.hot[0].velocity = up * 10.0;
    let found = guard.look(&mut world).expect_err("the energy is a hundred times what it was").to_string();
    assert!(found.contains("the deepest contact is that of grain 0 and body `table`"), "{found}");
}
