//! A run that has left physics stops and names the two that show it: overlaps that no law means, with grains and with bodies,
//! and energy that nobody has put in.

use std::path::Path;

use scree::base::space::{Linear, Plane, Space};
use scree::bodies::body::{Body, Shape};
use scree::domain::guards::grains::EnergyGuard;
use scree::job::Job;
use scree::run::{Options, Outcome, start};
use scree_partition::Solo;

use crate::few::{Few, MASS, RADIUS, linear, steps, vector};

/// Discs of 1 mm as rows of a file, bodies as tables of a job, over some steps of 0.4 us in an open cell.
fn run(grains: &str, bodies: &str, steps: u64, sets: &[&str]) -> Result<Outcome, String> {
    run_in(tempfile::tempdir().unwrap().path(), grains, bodies, steps, sets)
}

/// The same with its outputs in `out` below a folder.
fn run_in(folder: &Path, grains: &str, bodies: &str, steps: u64, sets: &[&str]) -> Result<Outcome, String> {
    let file = folder.join("grains.csv");
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
    let options = Options::new(folder.join("out"), 1);
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
fn energy_that_grows_before_the_second_look_is_found() {
    let lid =
        FLOOR.replace("floor", "lid").replace("point = [0, 0]", "point = [0, 0.0008]").replace("[0, 1]", "[0, -1]");
    let sets = ["time.step=4.745e-5", "time.end=1.5e-3", "time.allow_unstable=true"];
    let folder = tempfile::tempdir().unwrap();
    let outcome = run_in(folder.path(), "0,0,0.0004,0.0005,0,0.01,0\n", &format!("{FLOOR}{lid}"), 1, &sets);
    assert!(outcome.is_ok(), "{outcome:?}");
    let log = std::fs::read_to_string(folder.path().join("out/log.jsonl")).unwrap();
    let told = "J since step 1 while 0.000e0 J of work were done; the deepest contact is that of grain 0 and body";
    assert!(log.contains(told), "{log}");
}

/// What energy has grown since the last look is found at a look, and the contact with a body is named where no grains touch.
#[test]
fn energy_from_nowhere_names_the_contact_with_a_body() {
    let mut few = Few::<Plane>::new(linear(), 2e-7, 24.0 * RADIUS);
    let up = vector::<Plane>([0.0, 1.0, 0.0]);
    few.bodies.push(Body::new("table", Shape::Plane { point: <Plane as Space>::Vector::zero(), normal: up }));
    few.add([0.0, 0.99 * RADIUS, 0.0], RADIUS, MASS);
    let mut world = few.world();
    let mut guard = EnergyGuard::default();
    steps(&mut world, 1);
    guard.look(&mut world).unwrap();
    steps(&mut world, 1);
    guard.look(&mut world).unwrap();
    world.assembly.grains.hot[0].velocity = up * 10.0;
    let found = guard.look(&mut world).unwrap().expect("the energy is a hundred times what it was");
    assert!(found.contains("the deepest contact is that of grain 0 and body `table`"), "{found}");
}

/// Sixteen discs of a gas whose step is just beyond the stable one: energy comes and goes, and once doubles between two looks.
const UNSTABLE: &str = r#"name = "gas"
[cell]
space = "plane"
upper = ["6 mm", "6 mm"]
[grains]
density = 2500
file = "gas.csv"
diameter_mean = "1 mm"
[contact]
stiffness_normal = "100 kN/m"
stiffness_tangential = "50 kN/m"
damping_normal = 0
damping_tangential = 0
friction = 0
[time]
step = "16 us"
end = "0.056 s"
allow_unstable = true
[output]
series_interval = "1 ms"
checkpoint_interval = "15 ms"
"#;

/// The guard of energy once overruled `time.allow_unstable`, and forgot at every restart what it had seen: one whole run stopped
/// itself where the same run, resumed, went on to its end.
#[test]
fn energy_that_grows_is_told_alike_of_a_whole_run_and_of_a_resumed_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut grains = "id,x,y,radius,vx,vy,spin\n".to_string();
    for id in 0..16_u32 {
        let speed = |bits: u32| (f64::from(id.wrapping_mul(bits) % 97) / 48.5 - 1.0) * 0.1;
        let [x, y] = [id % 4, id / 4].map(|at| (f64::from(at) + 0.5) * 1.5e-3);
        grains += &format!("{id},{x},{y},5e-4,{},{},0\n", speed(41), speed(59));
    }
    std::fs::write(folder.path().join("gas.csv"), grains).unwrap();
    std::fs::write(folder.path().join("job.toml"), UNSTABLE).unwrap();
    let scree = |arguments: &[&str]| {
        let mut command = std::process::Command::new(crate::mpirun::SCREE);
        let output = command.args(arguments).args(["--threads", "1"]).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", crate::mpirun::words(&output));
        crate::mpirun::words(&output)
    };
    let read = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();
    let grown = |run: &str| -> Vec<String> {
        let log = read(&format!("{run}/log.jsonl"));
        let lines = log.lines().filter(|line| line.contains("energy_grows")).map(|line| {
            let line: serde_json::Value = serde_json::from_str(line).unwrap();
            format!("{} {}", line["step"], line["why"])
        });
        lines.collect()
    };
    let told = scree(&["run", "job.toml", "--out", "whole"]);
    let wanted = grown("whole");
    assert!(!wanted.is_empty() && wanted[0].contains("energy has grown from"), "{wanted:?}");
    assert_eq!(told.matches("energy has grown from").count(), 1, "{told}");
    assert!(told.contains("warning: time.allow_unstable is on"), "{told}");
    assert!(read("whole/summary.json").contains("\"allow_unstable\": true"));
    assert!(read("whole/log.jsonl").lines().next().unwrap().contains("\"allow_unstable\":true"));

    // Taken up between the look before that one and that one.
    scree(&["run", "job.toml", "--out", "halves"]);
    let step: u64 = wanted[0].split(' ').next().unwrap().parse().unwrap();
    let kept = scree_io::store::newest(&folder.path().join("halves/checkpoints")).unwrap();
    let later = kept.iter().filter(|(at, _)| *at >= step);
    later.for_each(|(_, path)| std::fs::remove_file(path).unwrap());
    assert!(kept.iter().any(|(at, _)| (step - 1000..step).contains(at)), "{kept:?} {wanted:?}");
    std::fs::remove_file(folder.path().join("halves/summary.json")).unwrap();
    scree(&["resume", "halves"]);
    assert_eq!(grown("halves"), wanted);
    assert_eq!(
        scree::store::checkpoint::digest_of(&folder.path().join("halves")).unwrap(),
        scree::store::checkpoint::digest_of(&folder.path().join("whole")).unwrap()
    );
}
