//! The account of a continuum's energy.

use scree::body::Shape;
use scree::continuum::setup;
use scree::law::material::Hencky;
use scree::mpm::boundary::Grip;
use scree::scenario::Job;
use scree::space::Plane;
use scree_partition::Solo;

use crate::runs::{Ran, SHAPES, TRANSFERS, UPDATES, parse, schemes};

/// A heavy elastic block between rollers, pulled at its side, under a plate that comes down; gravity rises at first.
pub fn pressed(scheme: &str, step: f64) -> String {
    format!(
        r#"
        name = "pressed"
        [grid]
        space = "plane"
        upper = [0.8, 0.8]
        cell = 0.1
        depth = 1
        [scheme]
        {scheme}
        points_per_cell = 2
        [material]
        law = "hencky"
        density = 1000
        young_modulus = 2e5
        poisson_ratio = 0.3
        [gravity]
        acceleration = [0, -10]
        ramp = 0.05
        [[region]]
        shape = "box"
        lower = [0, 0]
        upper = [0.4, 0.4]
        [[boundary]]
        face = "y_lower"
        kind = "friction"
        coefficient = 0.2
        [[load]]
        face = "x_upper"
        kind = "traction"
        traction = [2000, 0]
        ramp = 0.1
        [[body]]
        name = "plate"
        shape = "box"
        lower = [0, 0.4]
        upper = [0.7, 0.6]
        contact = "coulomb"
        friction = 0.3
        path = [{{time = 0, velocity = [0, 0]}}, {{time = 0.1, velocity = [0.1, -0.2]}}]
        [time]
        step = {step}
        end = 0.3
        [output]
        series_interval = {step}
        ledger = true
        "#
    )
}

/// What an account says at its end, J.
struct Account {
    work: f64,
    stored: f64,
    holds: f64,
    lost: f64,
    transfer: f64,
}

fn account(text: &str) -> Account {
    let ran = Ran::of(text);
    let last = |names: &[&str]| names.iter().map(|name| *ran.series(name).last().unwrap()).sum::<f64>();
    let change = |name: &str| ran.series(name).last().unwrap() - ran.series(name)[0];
    Account {
        work: last(&["work_loads", "work_bodies", "work_ramp"]),
        stored: ["kinetic", "elastic", "potential", "dissipated"].into_iter().map(change).sum(),
        holds: last(&["dissipated_holds"]),
        lost: last(&["energy_lost"]),
        transfer: last(&["energy_lost_transfer"]),
    }
}

/// What each scheme loses, and that without damping it is the less the shorter the step is.
#[test]
fn work_goes_where_the_account_says() {
    let blends = ["flip = 1.0", "flip = 0.99", "flip = 0.0"].map(|flip| format!("transfer = \"blend\"\n{flip}"));
    for shape in &SHAPES[1..] {
        for update in UPDATES {
            for transfer in blends.iter().map(String::as_str).chain([TRANSFERS[1]]) {
                let scheme = format!("shape = \"{shape}\"\nupdate = \"{update}\"\n{transfer}");
                let [coarse, fine] = [1e-3, 2.5e-4].map(|step| account(&pressed(&scheme, step)));
                let shares =
                    [&coarse, &fine].map(|of| [of.holds, of.lost, of.transfer].map(|part| 100.0 * part / of.work));
                println!(
                    "{:60} work {:.1} J, stored {:.1} J; holds, lost, of which in transfers, %: {:.2?}, at a quarter of the step {:.2?}",
                    scheme.replace('\n', " "),
                    coarse.work,
                    coarse.stored,
                    shares[0],
                    shares[1],
                );
                if transfer == blends[0] {
                    assert!(shares[1][1].abs() < 0.7 * shares[0][1].abs().max(1.0), "{scheme}");
                }
            }
        }
    }
}

/// Work, and of it shares lost by holds, by the scheme and in transfers, of a block that does not deform: it falls, or it is
/// carried about by a body around it.
fn rigid(scheme: &str, is_carried: bool) -> [f64; 4] {
    let text = pressed(scheme, 1e-3);
    let (load, body) = (text.find("[[load]]").unwrap(), text.find("[[body]]").unwrap());
    let text = format!("{}{}", &text[..load], &text[body..])
        .replace(
            "lower = [0, 0]\n        upper = [0.4, 0.4]\n",
            "lower = [0.2, 0.3]\n        upper = [0.6, 0.5]\n        velocity = [0.1, 0.3]\n",
        )
        .replace("lower = [0, 0.4]\n        upper = [0.7, 0.6]", "lower = [0, 0.7]\n        upper = [0.7, 0.8]")
        .replace("velocity = [0, 0]}", "velocity = [0.1, 0.3]}");
    let Job::Mpm(job) = parse(&text) else { panic!("it has a grid") };
    let law = Hencky { bulk_modulus: 1e5, shear_modulus: 1e5 };
    let mut world = setup::world::<Plane, Hencky>(&job, &law, &Solo).unwrap();
    world.bodies[0].grip = is_carried.then_some((Grip::Rough, false));
    world.bodies[0].shape = Shape::Box { lower: [-0.1, -0.1].into(), upper: [0.9, 0.9].into() };
    world.point_ledger.open();
    world.forces_wanted = true;
    (0..100).for_each(|_| world.advance().unwrap());
    let balance = world.point_balance().unwrap().unwrap();
    let work = balance.work_loads + balance.work_bodies + balance.work_ramp;
    [work, balance.holds / work, balance.lost / work, balance.transfer / work]
}

/// What does not deform has no strain to err in: under every scheme it closes to round-off.
#[test]
fn the_account_of_what_is_rigid_closes() {
    for scheme in schemes() {
        for is_carried in [false, true] {
            let [work, holds, lost, transfer] = rigid(&scheme, is_carried);
            println!(
                "{:60} carried {is_carried}: {work:.2} J, off by {holds:.1e}, {lost:.1e}, {transfer:.1e}",
                scheme.replace('\n', " ")
            );
            assert!(work.abs() > 1.0, "{work} J: {scheme}");
            assert!([holds, lost, transfer].iter().all(|share| share.abs() < 1e-11), "{scheme}");
        }
    }
}
