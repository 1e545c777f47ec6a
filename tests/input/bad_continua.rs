//! Wrong continua and what the operator is told.

use scree::job::{Job, Scenario};

use crate::refusals::{Good, refused_text};

/// A job that is right; every test below breaks it in one place.
pub const GOOD: Good = Good(
    r#"name = "good"

[grid]
space = "plane"
lower = [0, 0]
upper = ["4 m", "2 m"]
cell = "0.1 m"
depth = "1 m"
periodic = [false, false]

[scheme]
shape = "quadratic"
update = "last"
transfer = "blend"
flip = 0.95
points_per_cell = 2

[material]
law = "critical_drucker_prager"
density = "2000 kg/m3"
bulk_modulus = "20 MPa"
shear_modulus = "10 MPa"
friction_angle_critical = "30 deg"
fraction_critical = 0.8
fraction = 0.82
dilation_factor = 7
softening_rate = 5
cohesion = "1 kPa"

[stress]
kind = "geostatic"
surface = "1 m"
k0 = 0.5

[gravity]
acceleration = [0, "-9.81 m/s2"]

[time]
step = "0.1 ms"
end = "1 s"

[[region]]
shape = "box"
lower = [0, 0]
upper = ["2 m", "1 m"]
velocity = ["1 cm/s", 0]
wave = [{direction = [1, 0], length = "1 m", amplitude = ["1 mm/s", 0]}]

[[region]]
shape = "polygon"
vertices = [["2 m", 0], ["3 m", 0], ["2 m", "1 m"]]

[[region]]
shape = "ball"
centre = ["3 m", "1 m"]
radius = "0.2 m"
spin = "1 rad/s"

[[boundary]]
face = "y_lower"
kind = "friction"
coefficient = 0.4

[[boundary]]
face = "x_upper"
kind = "absorbing"

[[load]]
face = "y_upper"
lower = [0, "0.5 m"]
upper = ["1 m", "2 m"]
kind = "pressure"
pressure = "10 kPa"

[[body]]
name = "footing"
shape = "box"
lower = ["1 m", "1 m"]
upper = ["2 m", "1.2 m"]
velocity = [0, "-1 cm/s"]
contact = "coulomb"
friction = 0.3

[[follow]]
name = "tip"
place = ["3 m", "1 m"]
"#,
);

/// Its law, with all that belongs to it.
fn law() -> &'static str {
    let (from, to) = (GOOD.0.find("law =").expect("a law"), GOOD.0.find("\n[stress]").expect("a table behind it"));
    &GOOD.0[from..to]
}

#[test]
fn the_good_job_is_good() {
    GOOD.is_good();
}

/// What wants planar shear says that it got a continuum.
#[test]
fn a_continuum_where_planar_shear_is_wanted() {
    let error = Scenario::parse(GOOD.0, "job.toml", &[]).expect_err("it has a grid");
    assert_eq!(
        error.to_string(),
        "job.toml: this job is a continuum, because it has a table [grid] or [mesh], and a job of planar shear is wanted here."
    );
}

#[test]
fn tables_and_keys_of_other_jobs() {
    GOOD.refused_among(
        "[gravity]\n",
        "[specimen]\nwidth = 1\n\n[gravity]\n",
        "job.toml:35: there is no table [specimen]. It belongs to jobs of planar shear, and this job is a continuum because it has a table [grid] or [mesh]. Remove one of the two.",
    );
    GOOD.refused_among(
        "[gravity]\n",
        "[cell]\nspace = \"plane\"\n\n[gravity]\n",
        "job.toml:3: there is no table [grid]. It belongs to continua, and this job is an assembly of grains because it has a table [cell]. Remove one of the two.",
    );
    GOOD.refused_among(
        "name = \"good\"",
        "name = \"good\"\nmethod = \"mpm\"",
        "job.toml:2: method = \"mpm\" is for jobs with grains, and this one has none. Add [grains], or remove the line.",
    );
    GOOD.refused_set(
        "contact.friction=0.5",
        "--set: [contact] is for jobs with grains, and this one has none. Add [grains], or remove it.",
    );
}

#[test]
fn misspelt_keys() {
    GOOD.refused(
        "bulk_modulus =",
        "bulk_modlus =",
        "job.toml:21: [material] has no key bulk_modlus. Did you mean bulk_modulus?",
    );
    GOOD.refused("radius = ", "radios = ", "job.toml:56: [[region]] has no key radios. Did you mean radius?");
    GOOD.refused(
        "amplitude =",
        "amplitud =",
        "job.toml:47: [[region.wave]] has no key amplitud. Did you mean amplitude?",
    );
    GOOD.refused_set("scheme.flipp=1", "--set scheme.flipp=1: a job has no scheme.flipp. Did you mean scheme.flip?");
}

#[test]
fn a_misspelt_table() {
    GOOD.refused("[material]", "[materials]", "job.toml:18: there is no table [materials]. Did you mean [material]?");
}

#[test]
fn quantities_of_another_kind() {
    GOOD.refused(
        "density = \"2000 kg/m3\"",
        "density = \"2000 kPa\"",
        "job.toml:20: material.density = \"2000 kPa\" is a stress, but a density (kg/m3) is wanted. Write for example density = \"2000 kg/m3\".",
    );
    GOOD.refused(
        "acceleration = [0, \"-9.81 m/s2\"]",
        "acceleration = [0, \"-9.81 m/s\"]",
        "job.toml:36: gravity.acceleration = \"-9.81 m/s\" is a speed, but an acceleration (m/s2) is wanted. Write for example acceleration = [0, \"-9.81 m/s2\"].",
    );
    GOOD.refused(
        "radius = \"0.2 m\"",
        "radius = \"0.2\"",
        "job.toml:56: region.radius = \"0.2\" has no unit: without quotes a number is taken in m, in quotes it must say its unit. Write for example radius = \"10 cm\".",
    );
}

#[test]
fn a_grid_that_encloses_nothing() {
    GOOD.refused(
        "upper = [\"4 m\", \"2 m\"]\ncell",
        "upper = [\"4 m\", 0]\ncell",
        "job.toml:6: grid.upper = [\"4 m\", 0] encloses nothing: it must be more than lower along every axis.",
    );
}

#[test]
fn cells_that_do_not_fill_the_grid() {
    GOOD.refused(
        "cell = \"0.1 m\"",
        "cell = \"0.3 m\"",
        "job.toml:7: grid.cell = \"0.3 m\" does not fit: whole cells must fill the 4 m of the grid along x. Write \"0.3076923077 m\" to have 13 there, or \"0.2857142857 m\" to have 14.",
    );
    GOOD.refused_set(
        "grid.cell=7 m",
        "--set: grid.cell = \"7 m\" does not fit: whole cells must fill the 4 m of the grid along x. Write \"4 m\" to have 1 there, or \"2 m\" to have 2.",
    );
}

#[test]
fn more_cells_than_any_machine_holds() {
    GOOD.refused_set(
        "grid.cell=1 um",
        "--set: grid.cell = \"1 um\" makes 8.0e12 cells, and at most 1e9 are allowed. Take larger cells.",
    );
}

#[test]
fn more_points_than_any_machine_holds() {
    refused_text(
        &GOOD.0.replace("step = \"0.1 ms\"\n", ""),
        &["grid.cell=0.2 mm", "scheme.points_per_cell=16"],
        "--set: grid.cell = \"0.2 mm\" makes up to 2.0e10 points with scheme.points_per_cell = 16, and at most 100000000 are allowed. Take larger cells, or fewer points in each.",
    );
}

#[test]
fn a_depth_in_space() {
    GOOD.refused_among(
        "space = \"plane\"",
        "space = \"solid\"",
        "job.toml:8: grid.depth = \"1 m\" belongs to space = \"plane\"; a solid has no depth. Remove the line.",
    );
}

#[test]
fn flip_without_a_blend() {
    GOOD.refused(
        "transfer = \"blend\"",
        "transfer = \"affine\"",
        "job.toml:15: scheme.flip = 0.95 belongs to transfer = \"blend\", and here transfer is \"affine\". Remove the line, or change transfer.",
    );
    GOOD.refused_set(
        "scheme.flip=1.5",
        "--set: scheme.flip = 1.5 is out of range: it must be between 0 and 1. Write for example flip = 0.99.",
    );
}

#[test]
fn words_that_are_no_choice() {
    GOOD.refused(
        "shape = \"quadratic\"",
        "shape = \"quartic\"",
        "job.toml:12: scheme.shape = \"quartic\" is no shape function: write \"linear\", \"generalised\", \"quadratic\" or \"cubic\".",
    );
    GOOD.refused(
        "update = \"last\"",
        "update = \"usl\"",
        "job.toml:13: scheme.update = \"usl\" is no time to update stress: write \"first\", \"last\" or \"modified_last\".",
    );
    GOOD.refused(
        "transfer = \"blend\"",
        "transfer = \"apic\"",
        "job.toml:14: scheme.transfer = \"apic\" is no transfer: write \"blend\" or \"affine\".",
    );
    GOOD.refused(
        "law = \"critical_drucker_prager\"",
        "law = \"mohr_coulomb\"",
        "job.toml:19: material.law = \"mohr_coulomb\" is no material law: write \"linear_elastic\", \"hencky\", \"critical_drucker_prager\", \"mobilised_friction\" or \"grains\".",
    );
}

#[test]
fn keys_of_another_law() {
    GOOD.refused_among(
        "cohesion = \"1 kPa\"",
        "poisson_ratio = 0.3",
        "job.toml:28: material.poisson_ratio = 0.3 belongs to law = \"linear_elastic\" or \"hencky\", and here law is \"critical_drucker_prager\". Remove the line, or change law.",
    );
    GOOD.refused_among(
        "law = \"critical_drucker_prager\"",
        "law = \"hencky\"",
        "job.toml:23: material.friction_angle_critical = \"30 deg\" belongs to law = \"critical_drucker_prager\" or \"mobilised_friction\", and here law is \"hencky\". Remove the line, or change law.",
    );
}

#[test]
fn moduli_of_an_elastic_material() {
    GOOD.refused(
        law(),
        "law = \"hencky\"\ndensity = \"2000 kg/m3\"\n",
        "job.toml: 2 mistakes.\n\njob.toml:18: [material] has no young_modulus, E. Add for example young_modulus = \"10 MPa\".\n\njob.toml:18: [material] has no poisson_ratio, Poisson's ratio. Add for example poisson_ratio = 0.3.",
    );
    GOOD.refused(
        law(),
        "law = \"hencky\"\ndensity = \"2000 kg/m3\"\nyoung_modulus = \"1 MPa\"\n",
        "job.toml:18: [material] has no poisson_ratio, Poisson's ratio. Add for example poisson_ratio = 0.3.",
    );
    GOOD.refused(
        law(),
        "law = \"hencky\"\ndensity = \"2000 kg/m3\"\nyoung_modulus = \"1 MPa\"\npoisson_ratio = 0.5\n",
        "job.toml:22: material.poisson_ratio = 0.5 is out of range: it must be between -1 and 0.5, both excluded. Write for example poisson_ratio = 0.3.",
    );
    GOOD.refused(
        law(),
        "law = \"hencky\"\ndensity = \"2000 kg/m3\"\nyoung_modulus = \"1 MPa\"\npoisson_ratio = 0.3\nbulk_modulus = \"1 MPa\"\n",
        "job.toml:23: material.bulk_modulus = \"1 MPa\" stands beside material.young_modulus, and two moduli are enough. Keep young_modulus and poisson_ratio, or bulk_modulus and shear_modulus.",
    );
}

#[test]
fn a_packing_fraction_of_an_elastic_region() {
    GOOD.refused(
        law(),
        "law = \"hencky\"\ndensity = \"2000 kg/m3\"\nyoung_modulus = \"1 MPa\"\npoisson_ratio = 0.3\n\n[[region]]\nshape = \"box\"\nlower = [3, 1.5]\nupper = [4, 2]\nfraction = 0.8\n",
        "job.toml:28: region.fraction = 0.8 belongs to law = \"critical_drucker_prager\" or \"mobilised_friction\"; an elastic material has no solid volume fraction. Remove the line.",
    );
}

#[test]
fn no_material() {
    GOOD.refused(
        &format!("[material]\n{}\n", law()),
        "",
        "job.toml: a continuum needs the table [material] (what the points are made of), and the job has none. Add it with the keys law, young_modulus, poisson_ratio, bulk_modulus, shear_modulus, dilation_angle, friction_angle_critical, fraction_critical, dilation_factor, softening_rate, cohesion, fraction, shear_modulus_degradation, shear_degradation_strain, hardening_strain, hardening_fraction_width, hardening_start, phase_transformation_factor, density, heterogeneity, file; jobs/continuum/column_collapse.toml shows one.",
    );
}

#[test]
fn a_material_that_bears_no_shear() {
    GOOD.refused(
        "friction_angle_critical = \"30 deg\"\nfraction_critical = 0.8\nfraction = 0.82\ndilation_factor = 7\nsoftening_rate = 5\ncohesion = \"1 kPa\"",
        "friction_angle_critical = 0\ndilation_angle = 0",
        "job.toml:23: material.friction_angle_critical = 0 bears no shear at all, since cohesion is 0 too. Give the material friction or cohesion.",
    );
}

#[test]
fn friction_out_of_range() {
    GOOD.refused_set(
        "material.friction_angle_critical=80 deg",
        "--set: material.friction_angle_critical = \"80 deg\" is out of range: it must be 0 rad or more and less than 1.3734 rad. Write for example friction_angle_critical = \"30 deg\".",
    );
    GOOD.refused_set(
        "material.fraction=0.7",
        "--set: material.fraction = 0.7 makes the friction angle negative: tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs) is -0.12. Write a fraction of at least 0.7176.",
    );
    GOOD.refused(
        "spin = \"1 rad/s\"",
        "fraction = 0.7",
        "job.toml:57: region.fraction = 0.7 makes the friction angle negative: tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs) is -0.12. Write a fraction of at least 0.7176.",
    );
    GOOD.refused(
        "dilation_factor = 7",
        "dilation_angle = \"40 deg\"",
        "job.toml:26: material.dilation_angle = \"40 deg\" is more than the friction angle, 29.9 deg, so that flow would give more work than it takes. Write at most that.",
    );
}

/// The factor was dropped in silence.
#[test]
fn dilation_by_a_factor_and_by_an_angle() {
    GOOD.refused(
        "cohesion = \"1 kPa\"",
        "dilation_angle = \"5 deg\"",
        "job.toml:28: material.dilation_angle = \"5 deg\" stands beside material.dilation_factor, and each says how flow dilates. Drop dilation_factor for a constant angle of dilation and of friction, or dilation_angle for angles that follow the solid volume fraction.",
    );
}

/// Hats have a slope where they vanish: a node that a point barely reaches is thrown about.
#[test]
fn linear_functions_that_feel_their_nodes() {
    let words = "goes with transfer = \"blend\" and update = \"modified_last\" or \"first\" alone: where stress is updated last (which it is unless the job says so) or velocities are affine, a node that a point barely reaches is thrown about at any time step. Take one of those updates, or another shape.";
    GOOD.refused(
        "shape = \"quadratic\"",
        "shape = \"linear\"",
        &format!("job.toml:12: scheme.shape = \"linear\" {words}"),
    );
    let linear = GOOD.0.replace("shape = \"quadratic\"", "shape = \"linear\"");
    let updated = linear.replace("update = \"last\"", "update = \"modified_last\"");
    Job::parse(&updated, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    let affine = updated.replace("transfer = \"blend\"\nflip = 0.95", "transfer = \"affine\"");
    refused_text(&affine, &[], &format!("job.toml:12: scheme.shape = \"linear\" {words}"));
}

#[test]
fn material_nowhere() {
    GOOD.refused(
        "lower = [0, 0]\nupper = [\"2 m\", \"1 m\"]",
        "lower = [0.03, 0.03]\nupper = [0.06, 0.06]",
        "job.toml:43: region.shape = \"box\" has no point: points stand 0.05 m apart, in the middle of their share of a cell, and none is in this region that is not in one before it. Make it larger, or the cells smaller.",
    );
}

#[test]
fn regions_outside_of_the_grid() {
    GOOD.refused(
        "upper = [\"2 m\", \"1 m\"]\nvelocity",
        "upper = [\"5 m\", \"1 m\"]\nvelocity",
        "job.toml:45: region.upper = [\"5 m\", \"1 m\"] lies outside of the grid, which reaches from 0 to 4 m along x. Move it inside.",
    );
    GOOD.refused(
        "radius = \"0.2 m\"",
        "radius = \"1.2 m\"",
        "job.toml:56: region.radius = \"1.2 m\" reaches beyond the grid along x. Make it smaller, or move its centre inwards.",
    );
    GOOD.refused(
        "[\"3 m\", 0]",
        "[\"5 m\", 0]",
        "job.toml:51: region.vertices = [[\"2 m\", 0], [\"5 m\", 0], [\"2 m\", \"1 m\"]] has a corner outside of the grid, at 5 and 0 m. Move it inside.",
    );
}

#[test]
fn polygons_that_are_none() {
    GOOD.refused(
        "[[\"2 m\", 0], [\"3 m\", 0], [\"2 m\", \"1 m\"]]",
        "[[2, 0], [3, 0]]",
        "job.toml:51: region.vertices = [[2, 0], [3, 0]] is refused: a list of three or more points is wanted, each two lengths (m). Write for example vertices = [[0, 0], [\"2 m\", 0], [0, \"1 m\"]].",
    );
    GOOD.refused(
        "[[\"2 m\", 0], [\"3 m\", 0], [\"2 m\", \"1 m\"]]",
        "[[2, 0], [3, 1], [3, 0], [2, 1]]",
        "job.toml:51: region.vertices = [[2, 0], [3, 1], [3, 0], [2, 1]] is no simple polygon: its border crosses or touches itself, or encloses nothing. List the corners in order around it.",
    );
}

#[test]
fn a_key_of_another_shape() {
    GOOD.refused(
        "spin = \"1 rad/s\"",
        "lower = [0, 0]",
        "job.toml:57: region.lower = [0, 0] belongs to shape = \"box\", and here shape is \"ball\". Remove the line, or change shape.",
    );
}

#[test]
fn a_wave_without_direction() {
    GOOD.refused(
        "direction = [1, 0], length",
        "direction = [0, 0], length",
        "job.toml:47: region.wave.direction = [0, 0] points nowhere. Write a direction of any length but zero.",
    );
    GOOD.refused(
        "length = \"1 m\", ",
        "",
        "job.toml:47: [[region.wave]] has no length, the wave length. Add for example length = \"2 m\".",
    );
}

#[test]
fn faces_that_do_not_exist() {
    GOOD.refused(
        "face = \"y_lower\"",
        "face = \"bottom\"",
        "job.toml:60: boundary.face = \"bottom\" is no face: write \"x_lower\", \"x_upper\", \"y_lower\" or \"y_upper\".",
    );
}

#[test]
fn faces_with_two_kinds() {
    GOOD.refused(
        "face = \"x_upper\"",
        "face = \"y_lower\"",
        "job.toml:65: boundary.face = \"y_lower\" has a boundary already. Keep one of them.",
    );
    GOOD.refused(
        "coefficient = 0.4\n",
        "",
        "job.toml:59: [[boundary]] has no coefficient, the Coulomb coefficient. Add for example coefficient = 0.5.",
    );
    GOOD.refused(
        "kind = \"absorbing\"",
        "kind = \"absorbing\"\ncoefficient = 1",
        "job.toml:67: boundary.coefficient = 1 belongs to kind = \"friction\", and here kind is \"absorbing\". Remove the line, or change kind.",
    );
}

#[test]
fn a_boundary_of_a_periodic_axis() {
    GOOD.refused(
        "periodic = [false, false]",
        "periodic = [true, false]",
        "job.toml:65: boundary.face = \"x_upper\" is no boundary: the grid is periodic along x. Remove this [[boundary]], or set grid.periodic to false there.",
    );
}

#[test]
fn blocks_that_do_not_fill_a_period() {
    let periodic = GOOD
        .0
        .replace("periodic = [false, false]", "periodic = [true, false]")
        .replace("face = \"x_upper\"\nkind = \"absorbing\"", "face = \"y_upper\"\nkind = \"free\"");
    refused_text(
        &periodic.replace("[gravity]\n", "[decomposition]\ncells_per_block = 7\n\n[gravity]\n"),
        &[],
        "job.toml:36: decomposition.cells_per_block = 7 does not fit: blocks must fill the grid along its periodic axes. Write 8.",
    );
    refused_text(
        &periodic,
        &["grid.upper=[\"4.1 m\", \"2 m\"]"],
        "job.toml: [decomposition] cannot be chosen: no number of cells from 2 (the least for scheme.shape = \"quadratic\") to 8 divides those along the periodic axes, 41 along x. Change grid.upper or grid.cell.",
    );
}

#[test]
fn geostatic_stress_without_gravity() {
    GOOD.refused_among(
        "acceleration = [0, \"-9.81 m/s2\"]",
        "acceleration = [0, 0]",
        "job.toml:31: stress.kind = \"geostatic\" is the stress under gravity along one axis, and gravity.acceleration is not. Write for example gravity.acceleration = [0, \"-9.81 m/s2\"].",
    );
    GOOD.refused_among(
        "acceleration = [0, \"-9.81 m/s2\"]",
        "acceleration = [1, \"-9.81 m/s2\"]",
        "job.toml:31: stress.kind = \"geostatic\" is the stress under gravity along one axis, and gravity.acceleration is not. Write for example gravity.acceleration = [0, \"-9.81 m/s2\"].",
    );
    GOOD.refused_among(
        "acceleration = [0, \"-9.81 m/s2\"]",
        "acceleration = [0, \"-9.81 m/s2\"]\nramp = \"1 s\"",
        "job.toml:31: stress.kind = \"geostatic\" balances gravity from the start, and gravity.ramp raises it from zero. Remove gravity.ramp, or the stress.",
    );
    GOOD.refused_set(
        "stress.surface=3 m",
        "--set: stress.surface = \"3 m\" lies outside of the grid, which reaches from 0 to 2 m along y. Move it inside.",
    );
    GOOD.refused_among(
        "k0 = 0.5",
        "pressure = \"1 kPa\"",
        "job.toml:33: stress.pressure = \"1 kPa\" belongs to kind = \"isotropic\", and here kind is \"geostatic\". Remove the line, or change kind.",
    );
}

#[test]
fn a_load_that_meets_no_surface() {
    GOOD.refused_among(
        "lower = [0, \"0.5 m\"]",
        "lower = [0, \"1.5 m\"]",
        "job.toml:69: load.face = \"y_upper\" meets no surface: no point within the window of the load is bare on that side. Move lower and upper, or take another face.",
    );
    GOOD.refused_among(
        "lower = [0, \"0.5 m\"]",
        "lower = [\"1 m\", \"0.5 m\"]",
        "job.toml:71: load.upper = [\"1 m\", \"2 m\"] leaves no window: its upper corner must be more than its lower one along every axis.",
    );
    GOOD.refused_among(
        "pressure = \"10 kPa\"",
        "traction = [0, \"-10 kPa\"]",
        "job.toml:73: load.traction = [0, \"-10 kPa\"] belongs to kind = \"traction\", and here kind is \"pressure\". Remove the line, or change kind.",
    );
}

#[test]
fn bodies_that_cannot_be() {
    GOOD.refused(
        "lower = [\"1 m\", \"1 m\"]\nupper = [\"2 m\", \"1.2 m\"]",
        "lower = [\"1 m\", \"2 m\"]\nupper = [\"2 m\", \"2.2 m\"]",
        "job.toml:79: body.upper = [\"2 m\", \"2.2 m\"] lies outside of the grid, which reaches from 0 to 2 m along y. Move it inside.",
    );
    GOOD.refused(
        "lower = [\"1 m\", \"1 m\"]\nupper",
        "lower = [\"1 m\", \"0.9 m\"]\nupper",
        "job.toml:77: body.shape = \"box\" stands in the material: 42 of its points are inside of the body at the start. Move the body or the region.",
    );
    GOOD.refused(
        "contact = \"coulomb\"\n",
        "",
        "job.toml:75: [[body]] has no contact, how the material touches it: rough, smooth or coulomb. Add for example contact = \"rough\".",
    );
    GOOD.refused(
        "contact = \"coulomb\"",
        "contact = \"rough\"",
        "job.toml:82: body.friction = 0.3 belongs to contact = \"coulomb\", and here contact is \"rough\". Remove the line, or change contact.",
    );
    GOOD.refused(
        "name = \"footing\"\nshape = \"box\"",
        "name = \"footing\"\nshape = \"layer\"",
        "job.toml:77: body.shape = \"layer\" is no shape: write \"plane\", \"box\" or \"cylinder\".",
    );
    GOOD.refused(
        "friction = 0.3",
        "",
        "job.toml:75: [[body]] has no friction, the Coulomb coefficient. Add for example friction = 0.5.",
    );
}

#[test]
fn points_followed_that_are_not_there() {
    GOOD.refused(
        "place = [\"3 m\", \"1 m\"]",
        "place = [\"3.9 m\", \"1.9 m\"]",
        "job.toml:86: follow.place = [\"3.9 m\", \"1.9 m\"] has no point within two cells of it at the start. Move it into a region.",
    );
    GOOD.refused(
        "name = \"tip\"",
        "name = \"footing\"",
        "job.toml:85: follow.name = \"footing\" names another point or body already. Give each a name of its own.",
    );
    GOOD.refused(
        "place = [\"3 m\", \"1 m\"]",
        "place = [\"5 m\", \"1 m\"]",
        "job.toml:86: follow.place = [\"5 m\", \"1 m\"] lies outside of the grid, which reaches from 0 to 4 m along x. Move it inside.",
    );
}

/// The bound of what governs: nodes with next to no mass where strain feels them; a face that absorbs, under any scheme; else
/// waves.
#[test]
fn an_unstable_step() {
    let averaged = GOOD.0.replace("update = \"last\"", "update = \"modified_last\"");
    let held = |text: &str| text.replace("kind = \"absorbing\"", "kind = \"roller\"");
    for text in [&averaged, &GOOD.0.replace("shape = \"quadratic\"", "shape = \"cubic\"")] {
        refused_text(
            text,
            &["time.step=1 ms"],
            "--set: time.step = \"1 ms\" is unstable: at most 4.08e-4 s is allowed (absorbing faces: cell/(2 c), c^2 = M/density). Beyond it nodes at the face have less than its dashpots would take, and waves come back; shorten the step, or take larger cells or a softer material.",
        );
    }
    refused_text(
        &held(&averaged),
        &["time.step=1 ms"],
        "--set: time.step = \"1 ms\" is unstable: at most 8.14e-4 s is allowed (waves and motion through a cell: cell/(c + v), c^2 = M/density, v of regions and bodies). Beyond it the grid blows up; shorten the step, or take larger cells or a softer material.",
    );
    refused_text(
        &held(GOOD.0),
        &["time.step=1 ms"],
        "--set: time.step = \"1 ms\" is unstable: at most 4.08e-4 s is allowed (nodes with next to no mass: cell sqrt(2/s)/c, c^2 = (M + lambda of every other axis)/density, s = 6 (quadratic), 3.1 (cubic), 9.3 (uGIMP with two points)). Beyond it points at the edge of material are thrown about; shorten the step, or take update = \"modified_last\" with transfer = \"blend\".",
    );
}

#[test]
fn a_step_with_two_masters() {
    GOOD.refused(
        "end = \"1 s\"",
        "end = \"1 s\"\nsafety = 0.5",
        "job.toml:41: time.safety = 0.5 stands beside time.step, and each says how long a step is. Keep one of them.",
    );
}

#[test]
fn an_end_before_the_first_step() {
    GOOD.refused(
        "end = \"1 s\"",
        "end = \"1 us\"",
        "job.toml:40: time.end = \"1 us\" is shorter than one time step. Write at least time.step = 1e-4 s.",
    );
}

/// What fell on the outermost nodes of such a tile was lost.
#[test]
fn blocks_too_small_for_their_functions() {
    let cubic = GOOD.0.replace("shape = \"quadratic\"", "shape = \"cubic\"");
    refused_text(
        &cubic.replace("[gravity]\n", "[decomposition]\ncells_per_block = 2\n\n[gravity]\n"),
        &[],
        "job.toml:36: decomposition.cells_per_block = 2 is too few for the 3 nodes that scheme.shape = \"cubic\" reaches beyond a block: a block and its neighbours must hold them, so at least 3 are needed. Write 8.",
    );
    refused_text(
        &cubic
            .replace("periodic = [false, false]", "periodic = [true, false]")
            .replace("face = \"x_upper\"\nkind = \"absorbing\"", "face = \"y_upper\"\nkind = \"free\""),
        &["grid.upper=[\"4.6 m\", \"2 m\"]"],
        "job.toml: [decomposition] cannot be chosen: no number of cells from 3 (the least for scheme.shape = \"cubic\") to 8 divides those along the periodic axes, 46 along x. Change grid.upper or grid.cell.",
    );
}

/// A point knows its loads by the bits of a word: the one after the last was borne by who bore the first.
#[test]
fn more_loads_than_a_point_can_tell_apart() {
    let with = |more: usize| {
        let load = "\n[[load]]\nface = \"y_upper\"\nkind = \"pressure\"\npressure = \"1 kPa\"\n";
        GOOD.0.to_string() + &load.repeat(more)
    };
    Job::parse(&with(56), "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    refused_text(
        &with(57),
        &[],
        "job.toml:368: [[load]] is one of 58, and at most 57 are allowed. Join loads that are alike in one window, or remove some.",
    );
}
