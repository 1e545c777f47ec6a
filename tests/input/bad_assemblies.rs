//! Wrong assemblies of grains and what the operator is told.

use scree::job::{Job, Scenario};

use crate::refusals::{Good, refused_text};

const GOOD: Good = Good(
    r#"name = "good"

[cell]
space = "plane"
upper = ["20 mm", "20 mm"]
periodic = [true, false]
velocity_gradient = [[0.1, 0], [0, 0]]
gravity = [0, "-9.81 m/s2"]

[grains]
density = "2530 kg/m3"
count = 100
distribution = "uniform"
diameter_min = "0.8 mm"
diameter_max = "1.2 mm"

[packing]
preparation = "pour"

[contact]
law = "elastic_rolling"
young_modulus = "600 MPa"
stiffness_ratio = 0.8
friction_angle = "28.6 deg"

[damping]
local = 0.1

[time]
step = "1 us"
end = "10 ms"

[[body]]
name = "floor"
shape = "plane"
point = [0, 0]
normal = [0, 1]

[[body]]
name = "lid"
shape = "box"
lower = [0, "18 mm"]
upper = ["20 mm", "20 mm"]
velocity = ["1 cm/s", 0]
servo = {direction = [0, 1], force = "5 N", mass = "10 g", speed_max = "1 cm/s"}
"#,
);

#[test]
fn the_good_job_is_good() {
    GOOD.is_good();
}

/// What wants planar shear says that it got grains in a cell.
#[test]
fn an_assembly_where_planar_shear_is_wanted() {
    let error = Scenario::parse(GOOD.0, "job.toml", &[]).expect_err("it has a cell");
    assert_eq!(
        error.to_string(),
        "job.toml: this job is an assembly of grains, because it has a table [cell], and a job of planar shear is wanted here."
    );
}

#[test]
fn tables_of_planar_shear() {
    GOOD.refused(
        "[damping]",
        "[loading]\nspeed = 1\n\n[damping]",
        "job.toml:26: there is no table [loading]. It belongs to jobs of planar shear, and this job is an assembly of grains because it has a table [cell]. Remove one of the two.",
    );
}

#[test]
fn keys_of_planar_shear() {
    GOOD.refused(
        "name = \"good\"",
        "name = \"good\"\nmethod = \"dem\"",
        "job.toml:2: the job's top level has no key method. It belongs to continua, and this job is an assembly of grains because it has a table [cell]. Remove one of the two.",
    );
    GOOD.refused_set(
        "decomposition.cells_per_block=2",
        "--set decomposition.cells_per_block=2: a job has no decomposition.cells_per_block. It belongs to continua, and this job is an assembly of grains because it has a table [cell]. Remove one of the two.",
    );
}

#[test]
fn a_misspelt_key_of_a_body() {
    GOOD.refused("velocity = [", "velocty = [", "job.toml:44: [[body]] has no key velocty. Did you mean velocity?");
}

#[test]
fn a_body_that_is_no_list() {
    let head = GOOD.0.find("[[body]]").expect("it has bodies");
    refused_text(
        &format!("{}[body]\nname = \"lid\"\n", &GOOD.0[..head]),
        &[],
        "job.toml:33: body is a table, but a list of tables is wanted. Write [[body]] on a line of its own, and name, shape, point, normal, lower, upper, centre, radius, axis, velocity, spin, ramp, path, oscillation, servo below.",
    );
}

#[test]
fn a_space_that_does_not_exist() {
    GOOD.refused(
        "\"plane\"\nupper",
        "\"2D\"\nupper",
        "job.toml:4: cell.space = \"2D\" is no space: write \"plane\" or \"solid\".",
    );
}

#[test]
fn a_vector_of_another_space() {
    GOOD.refused(
        "gravity = [0, \"-9.81 m/s2\"]",
        "gravity = [0, 0, \"-9.81 m/s2\"]",
        "job.toml:8: cell.gravity = [0, 0, \"-9.81 m/s2\"] is refused: a list of two is wanted, each an acceleration (m/s2). Write for example gravity = [0, \"-9.81 m/s2\"].",
    );
    GOOD.refused(
        "upper = [\"20 mm\", \"20 mm\"]\nperiodic",
        "upper = \"20 mm\"\nperiodic",
        "job.toml:5: cell.upper = \"20 mm\" is refused: a list of two is wanted, each a length (m). Write for example upper = [\"9 cm\", \"9 cm\"].",
    );
}

#[test]
fn a_truth_value_in_quotes() {
    GOOD.refused(
        "[true, false]",
        "[\"yes\", false]",
        "job.toml:6: cell.periodic = \"yes\" is text, but true or false is wanted. Write for example periodic = [true, true].",
    );
}

#[test]
fn a_cell_that_deforms_where_it_is_not_periodic() {
    GOOD.refused(
        "[[0.1, 0], [0, 0]]",
        "[[0, 0.1], [0, 0]]",
        "job.toml:7: cell.velocity_gradient = [[0, 0.1], [0, 0]] deforms the cell along y, which is not periodic. Set cell.periodic to true along y, or move bodies instead.",
    );
    GOOD.refused(
        "velocity_gradient = [[0.1, 0], [0, 0]]",
        "stress_normal = [\"free\", \"1 kPa\"]\nrate_max = 1",
        "job.toml:7: cell.stress_normal = [\"free\", \"1 kPa\"] deforms the cell along y, which is not periodic. Set cell.periodic to true along y, or move bodies instead.",
    );
}

#[test]
fn an_axis_with_two_masters() {
    GOOD.refused(
        "gravity =",
        "stress_normal = [\"1 kPa\", \"free\"]\nrate_max = 1\ngravity =",
        "job.toml:8: cell.stress_normal = [\"1 kPa\", \"free\"] holds x at a stress, and cell.velocity_gradient stretches x at a rate. Write \"free\" here, or 0 there.",
    );
}

#[test]
fn control_of_a_stress_that_nothing_holds() {
    for (key, line) in [("stress_gain", "stress_gain = 0.5"), ("stress_interval", "stress_interval = 2")] {
        GOOD.refused(
            "gravity =",
            &format!("{line}\ngravity ="),
            &format!(
                "job.toml:8: cell.{line} is of axes held at a stress, and there is no cell.stress_normal. Add it, or remove the line."
            ),
        );
        assert!(line.starts_with(key));
    }
}

#[test]
fn control_of_a_stress_out_of_range() {
    let held = "stress_normal = [\"1 kPa\", \"free\"]\nrate_max = 1\n";
    GOOD.refused(
        "gravity =",
        &format!("{held}stress_gain = 1.5\ngravity ="),
        "job.toml:10: cell.stress_gain = 1.5 is out of range: it must be between 0.001 and 1. Write for example stress_gain = 1.0.",
    );
    GOOD.refused(
        "gravity =",
        &format!("{held}stress_interval = 0\ngravity ="),
        "job.toml:10: cell.stress_interval = 0 is refused: it must be a whole number between 1 and 1000. Write for example stress_interval = 2.",
    );
}

/// The key had another name, under which tension was positive; nothing may take the one for the other in silence.
#[test]
fn a_stress_under_its_old_name() {
    GOOD.refused(
        "gravity =",
        "stress = [\"-1 kPa\", \"free\"]\ngravity =",
        "job.toml:8: [cell] has no key stress. It is called stress_normal now, and compression is positive in all that jobs call stress or pressure. Write stress_normal = [\"1 kPa\", \"free\"].",
    );
}

#[test]
fn a_stress_that_is_a_word() {
    GOOD.refused(
        "gravity =",
        "stress_normal = [\"1 kPa\", \"fre\"]\nrate_max = 1\ngravity =",
        "job.toml:8: cell.stress_normal = \"fre\" is neither a stress nor \"free\". Write for example stress_normal = [\"100 kPa\", \"100 kPa\"].",
    );
}

#[test]
fn a_cell_too_short_for_its_grains() {
    GOOD.refused_among(
        "diameter_max = \"1.2 mm\"",
        "diameter_max = \"6 mm\"",
        "job.toml:5: cell.upper = [\"20 mm\", \"20 mm\"] makes the cell 20 mm long along x, where it is periodic, but four of the largest grains and the skin need 24.34 mm. Take a larger cell or smaller grains.",
    );
}

/// Grains that have touched hold on to each other 3 mm apart, which lists, blocks and periods must reach.
#[test]
fn a_cohesion_that_reaches_across_blocks() {
    let (from, to) = (GOOD.0.find("law =").expect("a law"), GOOD.0.find("\n[damping]").expect("a table behind it"));
    let cohesive = format!(
        "{}law = \"linear_cohesive\"\nstiffness_normal = 1000\nstiffness_tangential = 500\ndamping_normal = 0\ndamping_tangential = 0\nfriction = 0.5\ncohesion_normal = 3\ncohesion_tangential = 0\n{}",
        &GOOD.0[..from],
        &GOOD.0[to..]
    );
    refused_text(
        &cohesive,
        &["decomposition.block=2.6 mm"],
        "--set: decomposition.block = \"2.6 mm\" is shorter than two of the largest grains and the skin with the reach of cohesion, which need 5.5 mm. Take larger blocks.",
    );
    refused_text(
        &cohesive,
        &["contact.cohesion_normal=16", "decomposition.block=20 mm"],
        "job.toml:5: cell.upper = [\"20 mm\", \"20 mm\"] makes the cell 20 mm long along x, where it is periodic, but four of the largest grains and the skin with the reach of cohesion need 20.9 mm. Take a larger cell or smaller grains.",
    );
}

#[test]
fn grains_that_are_neither_read_nor_made() {
    GOOD.refused_among(
        "count = 100\n",
        "",
        "job.toml:10: [grains] says neither where grains are read from nor how many are made. Add file = \"grains.csv\", or count = 400.",
    );
    GOOD.refused_among(
        "count = 100",
        "file = \"g.csv\"",
        "job.toml:13: grains.distribution = \"uniform\" is for grains to be made, and grains.file says that they are read. Remove one of the two.",
    );
}

#[test]
fn sizes_of_another_distribution() {
    GOOD.refused_among(
        "diameter_min = \"0.8 mm\"",
        "diameter_mean = \"0.8 mm\"",
        "job.toml:14: grains.diameter_mean = \"0.8 mm\" belongs to distribution = \"normal\", and here distribution is \"uniform\". Remove the line, or change distribution.",
    );
    GOOD.refused(
        "distribution = \"uniform\"\ndiameter_min = \"0.8 mm\"\ndiameter_max = \"1.2 mm\"",
        "distribution = \"list\"\ndiameters = [[\"1 mm\", 0.4], [\"2 mm\", 0.5]]",
        "job.toml:14: grains.diameters = [[\"1 mm\", 0.4], [\"2 mm\", 0.5]] does not add up: the shares of all diameters make 0.9, and 1 is wanted.",
    );
}

#[test]
fn a_packing_that_cannot_be_made() {
    GOOD.refused(
        "preparation = \"pour\"",
        "preparation = \"compress\"\nstress = \"10 kPa\"",
        "job.toml:18: packing.preparation = \"compress\" compresses a cell that is periodic along every axis, and y is not. Set cell.periodic to true there, write \"pour\", or lay copies of it side by side (cell.copies), whose ends may be open.",
    );
    GOOD.refused(
        "gravity = [0, \"-9.81 m/s2\"]\n",
        "",
        "job.toml:17: packing.preparation = \"pour\" lets grains fall, and there is no gravity. Add for example cell.gravity = [0, \"-9.81 m/s2\"].",
    );
    GOOD.refused_set(
        "grains.count=400",
        "--set: grains.count = 400 fills 0.795 of the cell, and packing.fraction_start lets loose grains fill 0.45 of it. Take fewer grains or a larger cell.",
    );
    GOOD.refused(
        "preparation = \"pour\"",
        "preparation = \"pour\"\nstress = \"10 kPa\"",
        "job.toml:19: packing.stress = \"10 kPa\" belongs to preparation = \"compress\", and here preparation is \"pour\". Remove the line, or change preparation.",
    );
}

#[test]
fn a_body_outside_of_the_cell() {
    GOOD.refused(
        "lower = [0, \"18 mm\"]",
        "lower = [0, \"-1 mm\"]",
        "job.toml:42: body.lower = [0, \"-1 mm\"] lies outside of the cell, which reaches from 0 to 0.02 m along y. Move it inside.",
    );
    GOOD.refused(
        "normal = [0, 1]",
        "normal = [1, 1]",
        "job.toml:37: body.normal = [1, 1] leans along x, and the cell is periodic there, so the half space would meet its own images. Turn it, or set cell.periodic to false along x.",
    );
    GOOD.refused(
        "normal = [0, 1]",
        "normal = [0, 0]",
        "job.toml:37: body.normal = [0, 0] points nowhere. Write a direction of any length but zero.",
    );
    // A floor that would leave its grains.
    GOOD.refused(
        "normal = [0, 1]",
        "normal = [0, 1]\nservo = {direction = [0, 1], force = \"5 N\", mass = \"10 g\", speed_max = \"1 cm/s\"}",
        "job.toml:38: body.servo = {direction = [0, 1], force = \"5 N\", mass = \"10 g\", speed_... has a direction along the normal of its plane, so that the plane would leave the grains for ever: direction is the one in which grains push the body, against that normal. Turn it around.",
    );
}

#[test]
fn a_key_of_another_shape() {
    GOOD.refused(
        "normal = [0, 1]\n",
        "normal = [0, 1]\nradius = \"1 mm\"\n",
        "job.toml:38: body.radius = \"1 mm\" belongs to shape = \"cylinder\", and here shape is \"plane\". Remove the line, or change shape.",
    );
}

#[test]
fn a_motion_that_contradicts_itself() {
    GOOD.refused_among(
        "velocity = [\"1 cm/s\", 0]",
        "velocity = [0, \"1 cm/s\"]",
        "job.toml:44: body.velocity = [0, \"1 cm/s\"] moves the body along the direction of its servo, which moves it there by itself. Remove that component.",
    );
    GOOD.refused_among(
        "velocity = [\"1 cm/s\", 0]",
        "velocity = [\"1 cm/s\", 0]\nspin = \"3 rad/s\"",
        "job.toml:45: body.spin = \"3 rad/s\" turns a body that cannot turn: only a cylinder spins, and in space a plane about its normal. Remove the spin.",
    );
    GOOD.refused_among(
        "velocity = [\"1 cm/s\", 0]",
        "path = [{time = 0}, {time = \"1 s\"}, {time = 0.5}]",
        "job.toml:44: body.path.time = 0.5 does not come after the time before it. Put the path in order.",
    );
    GOOD.refused_among(
        "force = \"5 N\"",
        "force = \"5 N\", stress = \"1 kPa\"",
        "job.toml:45: body.servo.force = \"5 N\" stands beside a stress or an area, and each says what the body is held at. Keep force, or stress and area.",
    );
}

#[test]
fn bodies_of_one_name() {
    GOOD.refused(
        "name = \"lid\"",
        "name = \"floor\"",
        "job.toml:40: body.name = \"floor\" names another body already. Give each a name of its own.",
    );
}

#[test]
fn too_many_bodies() {
    let stones: String = (0..7)
        .map(|stone| {
            format!(
                "\n[[body]]\nname = \"stone{stone}\"\nshape = \"cylinder\"\ncentre = [0.01, 0.01]\nradius = 0.001\n"
            )
        })
        .collect();
    refused_text(
        &format!("{}{stones}", GOOD.0),
        &[],
        "job.toml:83: [[body]] is one too many: a job may have 8 bodies, and this one has 9. Remove some.",
    );
}

/// The bound of the law that the job has.
#[test]
fn an_unstable_step() {
    GOOD.refused(
        "step = \"1 us\"",
        "step = \"20 us\"",
        "job.toml:30: time.step = \"20 us\" is unstable: at most 3.51e-6 s is allowed (tangential and rolling springs, lightest grain spinning: 2/w, w^2 = 2 z (k_t + k_r/r^2)/m of it and of a mean grain together). Beyond it contacts feed energy into the grains; shorten the step, or take softer contacts or heavier grains. Only to repeat an unstable run on purpose, write time.allow_unstable = true.",
    );
    GOOD.refused_set(
        "damping.mass=4e6",
        "job.toml:30: time.step = \"1 us\" is unstable: at most 4.99e-7 s is allowed (damping in proportion to mass: 2/c). Beyond it the damping turns velocities round at every step; shorten the step, or lower damping.mass. Only to repeat an unstable run on purpose, write time.allow_unstable = true.",
    );
}

/// A servo's own dashpot is implicit and bounds nothing, however strong; the contacts under a light body do.
#[test]
fn an_unstable_step_of_a_light_body() {
    let damped = GOOD.0.replace("mass = \"10 g\"", "mass = \"10 g\", damping = 1e6");
    assert!(Job::parse(&damped, "job.toml", &[]).is_ok(), "damping does not shorten the step");
    GOOD.refused(
        "mass = \"10 g\"",
        "mass = \"1 mg\"",
        "job.toml:30: time.step = \"1 us\" is unstable: at most 5.73e-7 s is allowed (grains on a body that its servo moves: 2/(sqrt(w^2 + b^2) + b), w^2 = N k_n/M + that of a grain, 2 b = N gamma_n/M + that of a grain). Beyond it the body bounces off its grains at every step; shorten the step, or raise the servo's mass. Only to repeat an unstable run on purpose, write time.allow_unstable = true.",
    );
}

#[test]
fn an_end_before_the_first_step() {
    GOOD.refused(
        "end = \"10 ms\"",
        "end = \"10 ns\"",
        "job.toml:31: time.end = \"10 ns\" is shorter than one time step. Write at least time.step = 1e-6 s.",
    );
}

/// A step of seventeen digits: what the message proposes is taken when it is copied.
#[test]
fn an_interval_as_long_as_the_message_says_is_taken() {
    let step = String::from("time.step=3.1602315723728926e-7");
    let parse =
        |interval: &str| Job::parse(GOOD.0, "job.toml", &[step.clone(), format!("output.series_interval={interval}")]);
    let message = parse("1e-9").expect_err("it is shorter than the step").to_string();
    let proposed = message.split_once("time.step = ").unwrap().1.split(' ').next().unwrap();
    assert_eq!(proposed, "3.160231573e-7");
    parse(proposed).unwrap_or_else(|error| panic!("{error}"));
}
