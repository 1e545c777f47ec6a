//! Patch tests of the continuum: uniform stress and uniform velocity gradients.

use scree::base::space::{Linear, Plane, Solid, Space};
use scree::job::Job;
use scree::law::material::{Hencky, MaterialLaw};
use scree::prepare::point_world;
use scree_partition::Solo;

use crate::runs::{Ran, SHAPES, TRANSFERS, UPDATES, list, parse, point_world, refused, schemes};

/// A cube of edge 0.4 m in cells of 0.1 m, full of material under 1 kPa.
fn full(dimension: usize, scheme: &str, periodic: bool, velocity: [f64; 3]) -> String {
    format!(
        r#"
        name = "full"
        [grid]
        space = "{}"
        upper = {}
        cell = 0.1
        periodic = [{}]
        [scheme]
        {scheme}
        [material]
        law = "hencky"
        density = 1000
        young_modulus = 1e5
        poisson_ratio = 0.3
        [stress]
        kind = "isotropic"
        pressure = 1000
        [[region]]
        shape = "box"
        lower = {}
        upper = {}
        velocity = {}
        [time]
        step = 1e-3
        end = 0.05
        "#,
        if dimension == 2 { "plane" } else { "solid" },
        list(dimension, [0.4; 3]),
        vec![periodic.to_string(); dimension].join(", "),
        list(dimension, [0.0; 3]),
        list(dimension, [0.4; 3]),
        list(dimension, velocity),
    )
}

/// The largest departure of any point's stress from -1 kPa, over 1 kPa, and of its velocity, m/s.
pub fn departure(ran: &Ran, dimension: usize, velocity: [f64; 3]) -> [f64; 2] {
    let mut most = [0.0f64; 2];
    for stress in ran.points("stress") {
        for (at, component) in stress.iter().enumerate() {
            let wanted = if at < dimension { -1000.0 } else { 0.0 };
            most[0] = most[0].max((component - wanted).abs() / 1000.0);
        }
    }
    for point in ran.points("velocity") {
        point.iter().zip(velocity).for_each(|(component, wanted)| most[1] = most[1].max((component - wanted).abs()));
    }
    most
}

/// Uniform stress between walls and across periods stays uniform under every scheme.
#[test]
fn uniform_stress_stays_uniform() {
    for dimension in [2, 3] {
        for scheme in schemes() {
            let still = departure(&Ran::of(&full(dimension, &scheme, false, [0.0; 3])), dimension, [0.0; 3]);
            // No point comes to lie on a node: linear functions have no slope there.
            let velocity = [3.1, -2.3, 1.7];
            let carried = departure(&Ran::of(&full(dimension, &scheme, true, velocity)), dimension, velocity);
            println!(
                "{dimension}D {:60} at rest {:.1e} {:.1e} carried {:.1e} {:.1e}",
                scheme.replace('\n', " "),
                still[0],
                still[1],
                carried[0],
                carried[1]
            );
            assert!(still[0] < 1e-13 && still[1] < 1e-14, "at rest {still:?}: {scheme}");
            assert!(carried[0] < 2e-13 && carried[1] < 2e-13, "carried {carried:?}: {scheme}");
        }
    }
}

/// Functions of an open knot vector are bent at a wall, and points integrate what is bent there poorly: quadratic ones with
/// three points to a cell, cubic ones with any number. Those that are straight at the wall are integrated exactly.
#[test]
fn functions_that_are_bent_at_walls_upset_a_uniform_stress() {
    for shape in SHAPES {
        for points in [1, 2, 3, 4, 6] {
            // A point in the middle of a cell, or on a node, has half of a slope's jump there for linear functions.
            let update = "update = \"modified_last\"";
            let scheme = format!("shape = \"{shape}\"\n{update}\nflip = 1.0\npoints_per_cell = {points}");
            let still = departure(&Ran::of(&full(2, &scheme, false, [0.0; 3])), 2, [0.0; 3]);
            println!("{shape}, {points} points per cell and axis: {:.1e} {:.1e}", still[0], still[1]);
            assert!(still[0] < 1e-13 && still[1] < 1e-14, "at rest {still:?}: {scheme}");
        }
    }
}

/// uGIMP had a quarter of a cell for half of a point's edge whatever the number of points.
#[test]
fn points_are_as_large_as_their_number_makes_them() {
    let Job::Mpm(job) = parse(&full(2, "shape = \"generalised\"\npoints_per_cell = 4", false, [0.0; 3])) else {
        panic!("it has a grid")
    };
    let layout = point_world::layout::<Plane>(&job).unwrap();
    let frame = layout.frame::<Plane>(0);
    assert_eq!([0, 1].map(|axis: usize| frame.axes[axis].half), [0.125; 2]);
}

/// A cube of hardly any stiffness that moves with v = L (x - centre).
fn moving(dimension: usize, scheme: &str, [lower, upper]: [f64; 2]) -> String {
    let faces: Vec<String> = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"][..2 * dimension]
        .iter()
        .map(|face| format!("[[boundary]]\nface = \"{face}\"\nkind = \"free\"\n"))
        .collect();
    full(dimension, scheme, false, [0.0; 3])
        .replace("kind = \"isotropic\"\n        pressure = 1000", "kind = \"none\"")
        .replace("1e5", "1e-12")
        .replace(&format!("lower = {}", list(dimension, [0.0; 3])), &format!("lower = {}", list(dimension, [lower; 3])))
        .replace(
            &format!("upper = {}\n        velocity", list(dimension, [0.4; 3])),
            &format!("upper = {}\n        velocity", list(dimension, [upper; 3])),
        )
        .replace(
            &format!("upper = {}\n        cell", list(dimension, [0.4; 3])),
            &format!("upper = {}\n        cell", list(dimension, [0.8; 3])),
        )
        .replace("        [time]", &format!("{}\n[time]", faces.concat()))
}

/// L of any kind, and of a steady shear, L L = 0, along no axis.
const ANY: [[f64; 3]; 3] = [[0.7, -0.4, 0.3], [0.5, -0.6, 0.2], [-0.1, 0.35, 0.4]];
const SHEAR: [[f64; 3]; 3] = [[0.48, -0.36, 0.0], [0.64, -0.48, 0.0], [0.0; 3]];

/// The largest departure from F = 1 + L t of any point at least `reach` within the material at the start, over |L| t, after
/// so many steps.
fn stretched<S: Space>(scheme: &str, (ends, reach): ([f64; 2], f64), rows: [[f64; 3]; 3], steps: usize) -> f64
where
    Hencky: MaterialLaw<S>,
{
    let law = Hencky { bulk_modulus: 1e-12, shear_modulus: 1e-12 };
    let mut world = point_world::<S>(&moving(S::DIMENSION, scheme, ends), law, &Solo);
    let (mut gradient, mut middle) = (S::Tensor::zero(), S::Vector::zero());
    for column in 0..S::DIMENSION {
        (0..S::DIMENSION).for_each(|row| gradient[column * S::DIMENSION + row] = rows[row][column]);
        middle[column] = 0.4;
    }
    for (hot, beside) in world.continuum.points.hot.iter_mut().zip(&mut world.continuum.points.beside) {
        hot.velocity = gradient * (hot.position - middle);
        if scheme.contains("affine") {
            beside.affine = gradient;
        }
    }
    (0..steps).for_each(|_| world.advance().unwrap());
    let time = world.time();
    let inside =
        |origin: &S::Vector| (0..S::DIMENSION).all(|axis| (origin[axis] - ends[0]).min(ends[1] - origin[axis]) > reach);
    let rows =
        world.continuum.points.hot.iter().zip(&world.continuum.points.cold).filter(|(_, cold)| inside(&cold.origin));
    let mut wanted = S::identity() + gradient * time;
    if scheme.contains("\"first\"") {
        // Strain is that of the step behind, so that there is one before the start in place of the last.
        let step = world.settings.grains.dt;
        let before = S::inverse(&(S::identity() - gradient * step)).unwrap();
        wanted = (S::identity() + gradient * (time - step)) * before;
    }
    let off = rows.map(|(hot, _)| (hot.deformation - wanted).norm());
    off.fold(0.0, f64::max) / (gradient.norm() * time)
}

/// v = L (x - centre) gives L at every point. Affine fields meet it anywhere, beside walls and edges as well, and go on doing
/// so where L is steady; in a stretch, where it is not, theirs is a step old. Without them a node has the mean of the
/// velocities about it, which is its own as long as points lie on both sides of it alike: inside, for a step.
#[test]
fn a_linear_velocity_has_one_gradient() {
    let both = |scheme: &str, lies: ([f64; 2], f64), rows: [[f64; 3]; 3], steps: usize| {
        let plane = stretched::<Plane>(scheme, lies, rows, steps);
        plane.max(stretched::<Solid>(scheme, lies, rows, steps))
    };
    for shape in SHAPES {
        for update in UPDATES {
            let [blend, affine] =
                TRANSFERS.map(|transfer| format!("shape = \"{shape}\"\nupdate = \"{update}\"\n{transfer}"));
            if refused(&affine) {
                continue;
            }
            let inside = ([0.0, 0.8], 0.3 - 1e-9);
            let once = both(&blend, inside, ANY, 1);
            println!("{shape} {update} FLIP: {once:.1e}, after 40 steps {:.1e}", both(&blend, inside, ANY, 40));
            assert!(once < 1e-12, "{once:e}: {blend}");
            for (what, ends) in [("free", [0.2, 0.6]), ("between walls", [0.0, 0.8])] {
                let once = both(&affine, (ends, 0.0), ANY, 1);
                let long = both(&affine, (ends, 0.0), SHEAR, 40);
                let stretch = both(&affine, (ends, 0.0), ANY, 40);
                println!(
                    "{shape} {update} APIC {what}: {once:.1e}, 40 steps of shear {long:.1e}, of stretch {stretch:.1e}"
                );
                assert!(once < 1e-12 && long < 1e-12, "{what} {once:e} {long:e}: {affine}");
            }
        }
    }
}
