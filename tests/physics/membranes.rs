//! Membranes on the grid: hoop tension, confining pressure, what is kept, and the same bits.

use scree::base::math::{PI, cos, sin};

use crate::runs::{Ran, parse, same, schemes};

/// A ring that holds nothing under pressure from inside, with some material far away from it.
fn ring(cell: f64) -> String {
    format!(
        r#"
        name = "ring"
        [grid]
        space = "plane"
        upper = [1.0, 1.0]
        cell = {cell}
        depth = 2.0
        [material]
        law = "hencky"
        density = 1000
        young_modulus = 1e5
        poisson_ratio = 0.3
        [[region]]
        shape = "box"
        lower = [0.0, 0.0]
        upper = [0.1, 0.1]
        [[membrane]]
        name = "pipe"
        shape = "circle"
        centre = [0.5, 0.5]
        radius = 0.25
        mass_per_area = 10
        spacing = 0.0125
        stiffness = 5e5
        damping = 100
        pressure = -800
        ramp = 0.4
        [time]
        step = 1e-4
        end = 0.8
        [output]
        series_interval = 2e-3
        frame_interval = 1.0
        checkpoint_interval = 1.0
        "#
    )
}

/// A polygon of n sides of length l balances where 2 T sin(pi/n) = p d l cos(pi/n): T = p d r in the limit.
#[test]
fn a_pipe_under_pressure_has_its_hoop_tension() {
    for cell in [0.05, 0.025] {
        let ran = Ran::of(&ring(cell));
        let count = (2.0 * PI * 0.25 / 0.0125).round();
        let half = PI / count;
        let (rest, stiffness, push) = (2.0 * 0.25 * sin(half), 5e5, 800.0 * 2.0);
        // T = k (l - l_0) = p d l cos/(2 sin).
        let per_length = push * cos(half) / (2.0 * sin(half));
        let length = stiffness * rest / (stiffness - per_length);
        let wanted = stiffness * (length - rest);
        let late = |name: &str| {
            let column = ran.series(name);
            let tail = &column[column.len() * 3 / 4..];
            tail.iter().sum::<f64>() / tail.len() as f64
        };
        let (least, most) = (late("pipe_tension_least"), late("pipe_tension_most"));
        let longer = late("pipe_length") / (count * length) - 1.0;
        println!("cells of {cell} m: {least:.2} to {most:.2} N, {wanted:.2} wanted; {longer:+.1e} of its length off");
        assert!((least / wanted - 1.0).abs() < 0.03, "{least} for {wanted}");
        assert!((most / wanted - 1.0).abs() < 0.03, "{most} for {wanted}");
        assert!(longer.abs() < 1e-3, "{longer}");
    }
}

/// A disc with a skin around it.
fn confined(scheme: &str, pressure: f64, steps: usize) -> String {
    format!(
        r#"
        name = "confined"
        [grid]
        space = "plane"
        upper = [1.2, 1.2]
        cell = 0.05
        depth = 0.5
        periodic = [true, true]
        [scheme]
        {scheme}
        [material]
        law = "hencky"
        density = 1000
        young_modulus = 1e6
        poisson_ratio = 0.2
        [[region]]
        shape = "ball"
        centre = [0.6, 0.6]
        radius = 0.3
        velocity = [0.5, -0.3]
        [[membrane]]
        name = "skin"
        shape = "circle"
        centre = [0.6, 0.6]
        radius = 0.3
        mass_per_area = 5
        stiffness = 2e4
        damping = 0.5
        tension = 20
        pressure = {pressure}
        ramp = 0.1
        [[membrane]]
        name = "thread"
        shape = "line"
        from = [0.1, 0.2]
        to = [1.1, 0.3]
        mass_per_area = 5
        stiffness = 1e4
        pressure = 10
        [time]
        step = 2e-4
        end = {end}
        [decomposition]
        cells_per_block = 4
        [output]
        series_interval = {row}
        frame_interval = 10
        checkpoint_interval = {third}
        checkpoints_kept = 9
        "#,
        end = 2e-4 * steps as f64,
        row = 2e-4 * (steps as f64 / 30.0).max(1.0).round(),
        third = 2e-4 * (steps / 3) as f64,
    )
}

/// The mean stress of what a membrane presses on is its pressure with that of its tension, and neither membrane gives itself
/// momentum; one on which its pressure does not cancel gets what the pressure gives.
#[test]
fn a_disc_in_a_skin_bears_its_pressure() {
    let ran = Ran::of(&confined("flip = 0.9", 2e4, 3000));
    let mean = |name: &str| {
        let column = ran.series(name);
        let tail = &column[column.len() * 3 / 4..];
        tail.iter().sum::<f64>() / tail.len() as f64
    };
    let [xx, yy, tension] = ["stress_xx", "stress_yy", "skin_tension_most"].map(mean);
    let radius = mean("skin_length") / (2.0 * PI);
    let wanted = -(2e4 + tension / (0.5 * radius));
    println!("{xx:.1} and {yy:.1} Pa, {wanted:.1} wanted, with {tension:.2} N in the skin");
    assert!((xx / wanted - 1.0).abs() < 0.03 && (yy / wanted - 1.0).abs() < 0.03, "{xx}, {yy} for {wanted}");
    let kept = &ran.summary["conservation"];
    assert!(kept["momentum"]["error"].as_f64().unwrap() < 1e-12, "{kept}");
    assert_eq!(kept["mass"]["error"].as_f64().unwrap(), 0.0, "{kept}");
    assert!(kept["momentum"]["impulses"].as_f64().unwrap() > 1.0, "{kept}");
}

#[test]
fn membranes_have_the_same_bits_on_any_ranks_and_after_a_restart() {
    for scheme in schemes() {
        let folder = tempfile::tempdir().unwrap();
        same(&parse(&confined(&scheme, 2e4, 60)), folder.path(), &scheme);
    }
}

#[test]
fn a_vertex_that_leaves_the_grid_is_named() {
    let ring = ring(0.05);
    let (from, to) = (ring.find("shape = \"circle\"").unwrap(), ring.find("mass_per_area").unwrap());
    let line = "shape = \"line\"\nfrom = [0.3, 0.9]\nto = [0.9, 0.9]\n";
    let open = "[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n";
    let text = format!("{}{line}{}{open}", &ring[..from], &ring[to..]).replace("pressure = -800", "pressure = 800");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let outcome = scree::run::start::start(&parse(&text), &crate::runs::options(&out), &scree_partition::Solo);
    let said = outcome.expect_err("it leaves").to_string();
    assert!(said.contains("of the membrane pipe has left the grid"), "{said}");
}
