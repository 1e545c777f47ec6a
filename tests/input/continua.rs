//! What jobs of continua mean.

use proptest::prelude::*;
use scree::base::math::{PI, sin};
use scree::job::Job;
use scree::job::mpm::{BodyContact, Boundary, Face, InitialStress, LoadKind, Mpm, RegionShape, figures};
use scree::law::material::{ConstitutiveLaw, Described};
use scree::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};

use crate::runs::Ran;

/// As little as a job can say.
const LITTLE: &str = r#"
name = "little"
[grid]
space = "plane"
upper = ["2 m", "1 m"]
cell = "0.1 m"
[material]
law = "linear_elastic"
density = 1000
young_modulus = "10 MPa"
poisson_ratio = 0.25
[[region]]
shape = "box"
lower = [0, 0]
upper = ["1 m", "0.5 m"]
[time]
end = 1
"#;

/// As much as it can.
const MUCH: &str = r#"
name = "much"
[grid]
space = "solid"
lower = [-1, -1, 0]
upper = [1, 1, 2]
cell = 0.125
periodic = [true, false, false]
[scheme]
shape = "cubic"
update = "modified_last"
transfer = "affine"
points_per_cell = 3
[material]
law = "critical_drucker_prager"
density = 2000
bulk_modulus = 2e7
shear_modulus = 1e7
friction_angle_critical = "30 deg"
fraction_critical = 0.6
fraction = 0.62
dilation_factor = 3
softening_rate = 4
cohesion = 100
[stress]
kind = "geostatic"
surface = 1
k0 = 0.5
surcharge = "1 kPa"
[gravity]
acceleration = [0, 0, -10]
[time]
safety = 0.25
end = 1
[decomposition]
cells_per_block = 4
[output]
series_interval = 0.01
[[region]]
shape = "box"
lower = [-1, -1, 0]
upper = [1, 0.5, 1]
fraction = 0.61
velocity = [0, 0.1, 0]
spin = [0, 0, 2]
wave = [{direction = [0, 3, 4], length = 2, origin = [0, 0, 1], amplitude = [0.1, 0, 0]}, {direction = [1, 0, 0], length = 1, amplitude = [0, 0, 0.2]}]
[[region]]
shape = "ball"
centre = [0, 0.75, 0.25]
radius = 0.2
[[boundary]]
face = "y_lower"
kind = "absorbing"
[[boundary]]
face = "z_lower"
kind = "friction"
coefficient = 0.3
[[boundary]]
face = "z_upper"
kind = "free"
[[load]]
face = "z_upper"
kind = "traction"
traction = [100, 0, -200]
ramp = 0.1
[[load]]
face = "y_upper"
lower = [-1, 0, 0.5]
upper = [1, 1, 1]
kind = "pressure"
pressure = 50
[[body]]
name = "plate"
shape = "box"
lower = [-1, -1, 1]
upper = [1, 1, 1.5]
contact = "smooth"
separates = false
servo = {direction = [0, 0, 1], stress = "1 kPa", area = 4, mass = 100, speed_max = 1}
[[body]]
name = "pipe"
shape = "cylinder"
axis = [1, 0, 0]
centre = [0, 0.8, 1.7]
radius = 0.1
path = [{time = 0}, {time = 0.5, velocity = [0, 0, -1], spin = [1, 0, 0]}]
contact = "coulomb"
friction = 0.4
[[body]]
name = "wall"
shape = "plane"
point = [0, -1, 0]
normal = [0, 1, 0]
contact = "rough"
[[follow]]
name = "middle"
place = [0, 0, 0.5]
"#;

/// The job, which is the same after it has been written and read.
#[track_caller]
fn read(text: &str) -> Mpm {
    let job = Job::parse(text, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let resolved = job.to_toml();
    let back = Job::parse(&resolved, "back.toml", &[]).unwrap_or_else(|error| panic!("{error}\n{resolved}"));
    assert_eq!(back, job);
    assert_eq!(back.to_toml(), resolved);
    match job {
        Job::Mpm(job) => job,
        _ => panic!("it has a grid"),
    }
}

#[test]
fn what_is_left_out_has_its_default() {
    let job = read(LITTLE);
    assert_eq!((job.grid.dimension, job.grid.cells, job.grid.depth), (2, [20, 10, 1], 0.01));
    assert_eq!((job.scheme.shape, job.scheme.update), (ShapeFunction::Quadratic, StressUpdate::Last));
    assert_eq!((job.scheme.transfer, job.scheme.points_per_cell), (Transfer::Blend { flip: 0.99 }, 2));
    assert_eq!(job.boundaries, [[Boundary::Roller; 2], [Boundary::Roller; 2], [Boundary::Free; 2]]);
    assert_eq!((job.stress, job.gravity.acceleration, job.cells_per_block), (InitialStress::None, [0.0; 3], 8));
    // lambda = 4 MPa, G = 4 MPa, so c^2 = 12 MPa/1000 kg/m3.
    let ConstitutiveLaw::LinearElastic(elastic) = job.material.law else { panic!("as it was asked for") };
    assert!((elastic.shear_modulus / 4e6 - 1.0).abs() < 1e-14);
    assert!((elastic.bulk_modulus_in(2) / 8e6 - 1.0).abs() < 1e-14);
    for axes in [2, 3] {
        assert!((job.material.law.modulus_longitudinal(axes) / 12e6 - 1.0).abs() < 1e-14);
    }
    // Of a node with next to no mass: lambda + 2 G with lambda once more, and splines of second order.
    let stable = 0.1 * (2.0 / (6.0 * 16e3f64)).sqrt();
    assert!((job.step / (0.5 * stable) - 1.0).abs() < 1e-14);
    assert_eq!(figures::points_of_regions(&job).iter().sum::<u64>(), 200);
    assert!((figures::mass(&job, 200) / 5.0 - 1.0).abs() < 1e-12);
}

#[test]
fn every_key_is_read() {
    let job = read(MUCH);
    assert_eq!((job.grid.dimension, job.grid.cells, job.grid.periodic), (3, [16; 3], [true, false, false]));
    assert_eq!((job.scheme.shape, job.scheme.update), (ShapeFunction::Cubic, StressUpdate::ModifiedLast));
    assert_eq!((job.scheme.transfer, job.scheme.points_per_cell), (Transfer::Affine, 3));
    assert_eq!(job.stress, InitialStress::Geostatic { axis: 2, up: 1.0, surface: 1.0, k0: 0.5, surcharge: 1000.0 });
    assert_eq!(job.boundaries[0], [Boundary::Periodic; 2]);
    assert_eq!(job.boundaries[1], [Boundary::Absorbing, Boundary::Roller]);
    assert_eq!(job.boundaries[2], [Boundary::Friction { coefficient: 0.3 }, Boundary::Free]);
    assert_eq!((job.regions[0].fraction, job.regions[1].fraction), (0.61, 0.62));
    assert_eq!(job.loads[0].face, Face { axis: 2, upper: true });
    assert_eq!(job.loads[0].kind, LoadKind::Traction([100.0, 0.0, -200.0]));
    assert_eq!((job.loads[0].lower, job.loads[1].kind), (job.grid.lower, LoadKind::Pressure(50.0)));
    assert_eq!((job.bodies[0].contact, job.bodies[0].separates), (BodyContact::Smooth, false));
    assert_eq!((job.bodies[1].contact, job.bodies[1].separates), (BodyContact::Coulomb { friction: 0.4 }, true));
    assert_eq!(job.bodies[0].body.motion.servo.as_ref().expect("it has one").force, 4000.0);
    assert_eq!(job.cells_per_block, 4);
}

/// 8 by 8 by 2 places a face of 0.125 m cells with three points to an edge: the whole top of the box but no side of it.
#[test]
fn loads_lie_on_bare_sides() {
    let job = read(MUCH);
    let spacing = 0.125 / 3.0;
    assert!((job.spacing() - spacing).abs() < 1e-15);
    // The box's top, 2 m by 1.5 m, and what of the ball no point stands above.
    let bearing = |job: &scree::job::mpm::Mpm| -> Vec<u64> {
        figures::bearing(job).into_iter().map(|(count, _)| count as u64).collect()
    };
    let on_top = bearing(&job)[0];
    let of_box = 48 * 36;
    let of_ball = (PI * 0.2 * 0.2 / (spacing * spacing)) as u64;
    assert!((of_box..=of_box + 2 * of_ball).contains(&on_top) && on_top > of_box, "{on_top}");
    // The upper half of the box's side towards y, but for what the ball hides; the ball itself ends below the window.
    assert_eq!(bearing(&job)[1], 48 * 12);
    // Nothing is bare across a period.
    let mut across = job.clone();
    across.loads[0].face = Face { axis: 0, upper: true };
    let ball_alone = bearing(&across)[0];
    assert!(ball_alone < 2 * of_ball, "{ball_alone}");
}

#[test]
fn velocities_of_the_start() {
    let job = read(MUCH);
    // Centre of the box: (0, -0.25, 0.5). Wave along (0, 0.6, 0.8) from (0, 0, 1), and along x from the lower corner.
    let at = job.regions[0].velocity_at(&[0.25, 0.0, 0.5]);
    let first = 0.1 * sin(2.0 * PI * (0.8 * -0.5) / 2.0);
    let second = 0.2 * sin(2.0 * PI * 1.25);
    let wanted = [-2.0 * 0.25 + first, 0.1 + 2.0 * 0.25, second];
    for axis in 0..3 {
        assert!((at[axis] - wanted[axis]).abs() < 1e-14, "{at:?} {wanted:?}");
    }
}

#[test]
fn regions_have_their_points() {
    let text = LITTLE.replace(
        "[time]",
        "[[region]]\nshape = \"polygon\"\nvertices = [[1, 0], [2, 0], [1, 1]]\n[[region]]\nshape = \"ball\"\ncentre = [0.5, 0.75]\nradius = 0.2\n[time]",
    );
    let job = read(&text);
    let counts = figures::points_of_regions(&job);
    // Half a square of 20 by 20 places, its diagonal left out, and a disc of 50 places' area.
    assert_eq!(counts[..2], [200, 190]);
    assert!((45..=55).contains(&counts[2]), "{counts:?}");
    let [x, y, z] = job.regions[1].shape.centre();
    assert!((x - 4.0 / 3.0).abs() < 1e-14 && (y - 1.0 / 3.0).abs() < 1e-14 && z == 0.0);
    assert!(matches!(job.regions[2].shape, RegionShape::Ball { .. }));
    assert_eq!(job.region_at(&[1.2, 0.2, 0.0]), Some(1));
    assert_eq!(job.region_at(&[1.9, 0.9, 0.0]), None);
}

/// An end between two steps is reached, by the run as by what `check` says of it.
#[test]
fn a_run_takes_the_steps_that_check_counts() {
    let text = LITTLE.replace("end = 1\n", "end = 6.8e-4\nstep = 2e-4\n[output]\nseries_interval = 2e-4\n");
    let job = read(&text);
    let steps = scree::job::figures::steps(job.end, job.step);
    assert_eq!((steps, *Ran::of(&text).series("step").last().unwrap()), (4, 4.0));
}

/// Blocks as large as wanted that still fill the periods.
#[test]
fn blocks_fill_periods() {
    let of =
        |periodic: &str| read(&LITTLE.replace("cell =", &format!("periodic = {periodic}\ncell ="))).cells_per_block;
    assert_eq!((of("[true, false]"), of("[true, true]"), of("[false, false]")), (5, 5, 8));
}

/// Two cells divide ten, but cubic functions reach three nodes beyond a block.
#[test]
fn blocks_hold_what_functions_reach() {
    let of = |shape: &str| {
        let text = MUCH.replace("cell = 0.125", "cell = 0.2").replace("\"cubic\"", &format!("\"{shape}\""));
        read(&text.replace("[decomposition]\ncells_per_block = 4\n", "")).cells_per_block
    };
    assert_eq!((of("quadratic"), of("cubic")), (2, 5));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// No bit of any number is lost on the way into a file and back.
    #[test]
    fn numbers_survive(
        corner in -1e3..1e3f64,
        cell in 1e-3..1e3f64,
        counts in (1usize..40, 1usize..40),
        density in 1e-3..1e6f64,
        poisson in -0.9..0.49f64,
        angle in 1e-3..1.3f64,
        flip in 0.0..1.0f64,
        elastic: bool,
    ) {
        let upper = [corner + cell * counts.0 as f64, corner + cell * counts.1 as f64];
        let law = match elastic {
            true => format!("law = \"hencky\"\nyoung_modulus = 1e7\npoisson_ratio = {poisson:?}"),
            false => format!("law = \"critical_drucker_prager\"\nbulk_modulus = 1e7\nshear_modulus = 3e6\nfriction_angle_critical = {angle:?}\ndilation_angle = 0"),
        };
        let job = read(&format!(
            "name = \"any\"\n[grid]\nspace = \"plane\"\nlower = [{corner:?}, {corner:?}]\nupper = {upper:?}\ncell = {cell:?}\n[scheme]\nflip = {flip:?}\n[material]\ndensity = {density:?}\n{law}\n[time]\nend = 1e6\n[[region]]\nshape = \"box\"\nlower = [{corner:?}, {corner:?}]\nupper = {upper:?}\nwave = [{{direction = [1, {angle:?}], length = {cell:?}, amplitude = [0, 1e-9]}}]\n"
        ));
        prop_assert_eq!(job.grid.cells, [counts.0, counts.1, 1]);
        prop_assert_eq!(figures::points_of_regions(&job).iter().sum::<u64>(), 4 * (counts.0 * counts.1) as u64);
    }
}
