//! The account of what is kept, at the end of runs of every kind.

use serde_json::Value;

use crate::energies::pressed;
use crate::queues;
use crate::runs::Ran;

/// Three discs, of which one presses on the floor from the start and two fall on it, and against a box that comes in from the side, which hurls them about.
fn falling(damping: &str) -> String {
    format!(
        r#"
        name = "falling"
        [cell]
        space = "plane"
        lower = ["-2 cm", "-2 cm"]
        upper = ["6 cm", "6 cm"]
        periodic = [false, false]
        gravity = [0, -10]
        [grains]
        density = 2500
        file = "FILE"
        diameter_mean = "2 mm"
        [contact]
        stiffness_normal = "100 kN/m"
        stiffness_tangential = "50 kN/m"
        restitution = 0.5
        friction = 0.5
        {damping}
        [[body]]
        name = "floor"
        shape = "plane"
        point = [0, 0]
        normal = [0, 1]
        [[body]]
        name = "ram"
        shape = "box"
        lower = ["-1 cm", "-1 mm"]
        upper = ["0 cm", "2 cm"]
        path = [{{time = 0, velocity = [0, 0]}}, {{time = "20 ms", velocity = [0.5, 0]}}]
        [time]
        step = "1 us"
        end = "80 ms"
        "#
    )
}

fn ran_with_discs(job: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("discs.csv");
    let discs = "id,x,y,radius,vx,vy,spin\n0,4e-3,0.999e-3,1e-3,-0.1,0,20\n1,4.5e-3,8e-3,1e-3,0,-0.2,0\n2,9e-3,3e-3,1e-3,-0.2,0.1,0\n";
    std::fs::write(&file, discs).unwrap();
    Ran::of(&job.replace("FILE", file.to_str().unwrap()))
}

/// Largest parts of an account of momentum by what has given them.
fn given(kept: &Value, by: &str) -> f64 {
    kept["momentum"][by].as_array().unwrap().iter().map(|part| part.as_f64().unwrap().abs()).fold(0.0, f64::max)
}

fn error(kept: &Value, of: &str) -> f64 {
    kept[of]["error"].as_f64().unwrap_or_else(|| panic!("{kept}")).abs()
}

#[test]
fn grains_have_what_bodies_and_gravity_gave() {
    let ran = ran_with_discs(&falling(""));
    let kept = &ran.summary["conservation"];
    println!("{kept:#}");
    assert!(error(kept, "mass") == 0.0 && error(kept, "momentum") < 1e-12, "{kept:#}");
    // Each of them is large beside what would be wrong.
    assert!(given(kept, "by_bodies") > 1e-4 && given(kept, "by_gravity") > 1e-4, "{kept:#}");
    assert!(given(kept, "end") > 1e-6, "{kept:#}");
}

#[test]
fn damping_has_what_is_left_of_momentum() {
    let ran = ran_with_discs(&falling("[damping]\nlocal = 0.1"));
    let kept = &ran.summary["conservation"];
    assert!(kept["momentum"]["error"].is_null() && given(kept, "left") > 1e-5, "{kept:#}");
}

#[test]
fn a_sheared_cell_keeps_the_momentum_of_its_fluctuations() {
    let job = queues::JOB.replace("end = \"40 ms\"", "end = \"8 ms\"");
    let folder = tempfile::tempdir().unwrap();
    let cache = format!("cache = {:?}", folder.path().to_str().unwrap());
    let ran = Ran::of(&job.replace("cache = \"cache\"", &cache));
    let kept = &ran.summary["conservation"];
    println!("{kept:#}");
    assert!(error(kept, "mass") == 0.0 && error(kept, "momentum") < 1e-10, "{kept:#}");
}

/// Faces with friction, a body with friction, a load and gravity, both of which rise at first.
#[test]
fn points_have_what_faces_bodies_loads_and_gravity_gave() {
    for scheme in [
        "shape = \"quadratic\"\nupdate = \"last\"\ntransfer = \"blend\"\nflip = 0.95",
        "shape = \"cubic\"\nupdate = \"modified_last\"\ntransfer = \"affine\"",
    ] {
        let ran = Ran::of(&pressed(scheme, 1e-3));
        let kept = &ran.summary["conservation"];
        println!("{kept:#}");
        assert!(error(kept, "mass") < 1e-14 && error(kept, "momentum") < 1e-12, "{kept:#}");
        assert!(given(kept, "by_nodes") > 1.0 && given(kept, "by_gravity") > 1.0, "{kept:#}");
        let energy = &kept["energy"]["points"];
        assert!(energy["work"].as_f64().unwrap() > 0.0, "{energy}");
    }
}
