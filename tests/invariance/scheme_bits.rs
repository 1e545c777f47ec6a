//! Every scheme of the continuum, in the plane and in space, ends in the same bits on any number of ranks and threads, with
//! any instructions, and from a checkpoint (invariants 2 and 3): plastic points under a load among a servoed plate, a
//! spinning pipe, a face with friction and one that absorbs, with gravity that still rises.

use std::process::Command;

use crate::runs::{parse, result, same, schemes};

fn job(dimension: usize, scheme: &str) -> String {
    let list = |values: [&str; 3]| format!("[{}]", values[..dimension].join(", "));
    let solid = dimension == 3;
    format!(
        r#"
        name = "scheme_bits"
        [grid]
        space = "{space}"
        lower = {zero}
        upper = {upper}
        cell = 0.1
        periodic = {periodic}
        [scheme]
        points_per_cell = 2
        {scheme}
        [material]
        law = "critical_drucker_prager"
        density = 2000
        bulk_modulus = 2e6
        shear_modulus = 1e6
        friction_angle_critical = "25 deg"
        fraction_critical = 0.6
        fraction = 0.62
        dilation_factor = 3
        softening_rate = 4
        cohesion = 200
        [gravity]
        acceleration = {gravity}
        ramp = 0.05
        [[region]]
        shape = "box"
        lower = {zero}
        upper = {filled}
        wave = [{{direction = {along}, length = 0.9, amplitude = {amplitude}}}]
        [[boundary]]
        face = "y_lower"
        kind = "friction"
        coefficient = 0.3
        [[boundary]]
        face = "x_lower"
        kind = "absorbing"
        [[boundary]]
        face = "y_upper"
        kind = "free"
        [[load]]
        face = "y_upper"
        lower = {zero}
        upper = {loaded}
        kind = "pressure"
        pressure = 500
        ramp = 0.01
        [[load]]
        face = "x_upper"
        kind = "traction"
        traction = {traction}
        [[body]]
        name = "plate"
        shape = "box"
        lower = {plate}
        upper = {plate_upper}
        contact = "rough"
        servo = {{ direction = {up}, force = 100, mass = 20, damping = 50, speed_max = 0.5 }}
        [[body]]
        name = "pipe"
        shape = "cylinder"
        centre = {pipe}
        radius = 0.15
        {axis}
        spin = {spin}
        contact = "coulomb"
        friction = 0.4
        [[follow]]
        name = "middle"
        place = {plate}
        [time]
        step = 0.6e-3
        end = {end}
        [decomposition]
        cells_per_block = 4
        [output]
        energy_balance = true
        series_interval = 0.6e-3
        frame_interval = 1.0
        checkpoint_interval = {third}
        checkpoints_kept = 9
        "#,
        space = if solid { "solid" } else { "plane" },
        zero = list(["0", "0", "0"]),
        upper = list(["1.4", "1.3", "0.4"]),
        filled = list(["1.1", "0.8", "0.4"]),
        periodic = list(["false", "false", "true"]),
        gravity = list(["1", "-9.81", "0.5"]),
        along = list(["1", "1", "0"]),
        amplitude = list(["0.4", "-0.3", "0.2"]),
        loaded = list(["0.5", "1.3", "0.4"]),
        traction = list(["-300", "50", "0"]),
        plate = list(["0.6", "0.8", "0"]),
        plate_upper = list(["1.0", "1.0", "0.4"]),
        up = list(["0", "1", "0"]),
        pipe = list(["0.3", "0.96", "0"]),
        axis = if solid { "axis = [0, 0, 1]" } else { "" },
        spin = if solid { "[0, 0, 5.0]" } else { "5.0" },
        end = 0.0006 * steps(dimension) as f64,
        third = 0.0002 * steps(dimension) as f64,
    )
}

/// Multiples of three; a step in space costs many times as much.
fn steps(dimension: usize) -> usize {
    if dimension == 2 { 60 } else { 12 }
}

/// With other ranks and threads, resumed, and with narrower registers.
fn same_bits(dimension: usize, scheme: &str) {
    let text = &job(dimension, scheme);
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let wanted = same(&parse(text), folder, scheme);
    assert!(wanted.1.lines().count() > steps(dimension));
    let file = folder.join("job.toml");
    std::fs::write(&file, text).unwrap();
    for instructions in ["portable", "avx2"] {
        let out = folder.join(instructions);
        let run = Command::new(env!("CARGO_BIN_EXE_scree"))
            .args(["run", file.to_str().unwrap(), "--out", out.to_str().unwrap(), "--threads", "1"])
            .env("SCREE_INSTRUCTIONS", instructions)
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        assert!(result(&out) == wanted, "{instructions} ends elsewhere: {scheme}");
    }
}

#[test]
fn every_scheme_in_the_plane() {
    for scheme in schemes() {
        same_bits(2, &scheme);
    }
}

#[test]
fn every_scheme_in_space() {
    for scheme in schemes() {
        same_bits(3, &scheme);
    }
}
