//! Points that are no continuum any more stop the run with their id, place and what is wrong, the same on any number of
//! ranks; so do points that leave the grid and points too fast for the step.

use scree::base::error::Error;
use scree::base::numbers::Numbers;
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::job::Job;
use scree::law::material::{CriticalDruckerPrager, Hencky, MaterialLaw};
use scree::run::start;
use scree_partition::transport::threads;
use scree_partition::{Solo, Transport};

use crate::runs::{elastic, options, parse, point_world};

/// A block of 0.4 m in a grid of 1.6 m, free at every face.
fn block(dimension: usize, velocity: [f64; 3], more: &str) -> String {
    let list = |values: [f64; 3]| format!("{:?}", &values[..dimension]);
    let faces: String = ["x", "y", "z"][..dimension]
        .iter()
        .flat_map(|axis| {
            ["lower", "upper"].map(|end| format!("[[boundary]]\nface = \"{axis}_{end}\"\nkind = \"free\"\n"))
        })
        .collect();
    let space = if dimension == 2 { "plane" } else { "solid" };
    let grid = format!("space = \"{space}\"\nupper = {}\ncell = 0.1", list([1.6; 3]));
    let rest = format!(
        r#"
        [[region]]
        shape = "box"
        lower = {}
        upper = {}
        velocity = {}
        [decomposition]
        cells_per_block = 2
        [time]
        step = 1e-3
        end = 1
        [output]
        series_interval = 0.01
        {more}
        {faces}
        "#,
        list([0.6; 3]),
        list([1.0; 3]),
        list(velocity),
    );
    elastic("block", &grid, "update = \"modified_last\"", [1e5, 0.3], &rest)
}

/// What a run on 1, 2, 3 ranks stops with, the same on all.
#[track_caller]
fn stops(text: &str) -> String {
    stops_of(&parse(text))
}

#[track_caller]
fn stops_of(job: &Job) -> String {
    let folder = tempfile::tempdir().unwrap();
    let found: Vec<String> = [1, 2, 3]
        .into_iter()
        .flat_map(|ranks| {
            let out = folder.path().join(ranks.to_string());
            threads::run(ranks, |rank| {
                let error = start::start(job, &options(&out), &rank).expect_err("the run went on to its end");
                assert_eq!(error.exit_code(), 3, "{error}");
                error.to_string().split(". ").next().unwrap().to_string()
            })
        })
        .collect();
    assert!(found.iter().all(|words| *words == found[0]), "{found:#?}");
    found[0].clone()
}

/// Two corners of the block are as far out; the one of lower id is named, with small blocks as with those that a job has by
/// itself, whose tiles reach far beyond the face.
#[test]
fn points_that_leave_the_grid_are_named_and_never_dropped() {
    let small = "[decomposition]\n        cells_per_block = 2\n";
    for (dimension, id, blocks) in [(2, 396, small), (3, 12_684, small), (2, 396, ""), (3, 12_684, "")] {
        let found = stops(&block(dimension, [0.0, -3.0, 0.0], "").replace(small, blocks));
        println!("{found}");
        assert!(found.contains(&format!("point {id} at (6.25")), "{found}");
        let from = "is outside of the grid, which reaches from 0.000000e0 to 1.600000e0 and from 0.000000e0 to 1.6";
        assert!(found.contains(from), "{found}");
    }
}

/// Falling, it would be through a cell within a step.
#[test]
fn a_body_that_outruns_the_step_is_stopped_with_the_step_it_needs() {
    for dimension in [2, 3] {
        let text = block(dimension, [0.0; 3], "").replace("step = 1e-3", "step = 4e-3").replace("0.01", "0.004");
        let mut job = parse(&text);
        // More than a job may ask for, so that the first step is too long already.
        if let Job::Mpm(job) = &mut job {
            job.gravity.acceleration = [4000.0, 0.0, 0.0];
        }
        let found = stops_of(&job);
        println!("{found}");
        assert!(found.contains("step 1, time 4.000000e-3 s: point"), "{found}");
        assert!(found.contains("moves at 1.600e1 m/s among waves of 1.160e1 m/s"), "{found}");
        assert!(found.contains("a `time.step` of at most 3.623e-3 s is needed now"), "{found}");
    }
}

/// What the guard says of a world in which every point with an id of at least `first` is spoilt, on 1 to 3 ranks.
#[track_caller]
fn said<S: Space>(
    law: impl MaterialLaw<S> + Copy,
    first: u64,
    spoil: impl Fn(&mut scree::mpm::points::Point<S>) + Sync,
) -> String {
    let of = |transport: &dyn Transport| -> Result<(), Error> {
        let mut world = point_world::<S>(&block(S::DIMENSION, [0.0; 3], ""), law, transport);
        world.refuse_spoilt_points().expect("nothing is wrong yet");
        for row in 0..world.continuum.points.len() {
            if world.continuum.points.cold[row].id.0 >= first {
                let mut point = world.continuum.points.row(row);
                spoil(&mut point);
                world.continuum.points.hot[row] = point.hot;
            }
        }
        world.refuse_spoilt_points()
    };
    let alone = of(&Solo).expect_err("it is spoilt").to_string();
    for ranks in [2, 3] {
        for said in threads::run(ranks, |rank| of(&rank).expect_err("it is spoilt").to_string()) {
            assert_eq!(said, alone, "{ranks} ranks");
        }
    }
    alone
}

const SOFT: Hencky = Hencky { bulk_modulus: 1e5, shear_modulus: 4e4 };

fn stretched<S: Space>(by: f64) -> S::Tensor {
    let mut tensor = S::identity();
    tensor[0] = by;
    tensor
}

#[test]
fn inverted_and_crushed_points_are_named() {
    for by in [-1.0, 0.0, 0.09] {
        let found = said::<Plane>(SOFT, 500, |point| point.hot.deformation = stretched::<Plane>(by));
        assert!(
            found.starts_with(
                "step 0, time 0.000000e0 s: point 524 at (6.250000e-1, 8.250000e-1) m is inverted or crushed: det F = "
            ),
            "{found}"
        );
    }
    let found = said::<Solid>(SOFT, 0, |point| point.hot.deformation = stretched::<Solid>(-0.5));
    assert!(
        found.contains(
            "point 12684 at (6.250000e-1, 6.250000e-1, 6.250000e-1) m is inverted or crushed: det F = -5.000e-1"
        ),
        "{found}"
    );
}

/// Two points to a cell and quadratic functions: neighbours share a node within three cells, six edges.
#[test]
fn points_torn_from_their_neighbours_are_named() {
    let found = said::<Plane>(SOFT, 500, |point| point.hot.deformation = stretched::<Plane>(6.6));
    assert!(
        found.contains(
            "point 524 at (6.250000e-1, 8.250000e-1) m is torn: det F = 6.600e0, and it is stretched to 1.100 times"
        ),
        "{found}"
    );
    assert!(said::<Solid>(SOFT, 0, |point| point.hot.deformation = stretched::<Solid>(6.1)).contains("is torn"));
}

#[test]
fn points_that_are_no_numbers_are_named() {
    let found = said::<Plane>(SOFT, 500, |point| point.hot.stress.0[1] = f64::NAN);
    assert!(
        found.contains(
            "point 524 at (6.250000e-1, 8.250000e-1) m has a velocity, stress or deformation that is no finite number"
        ),
        "{found}"
    );
}

/// What has flowed has other neighbours than at the start: sheared by any amount it is not torn, only swollen.
#[test]
fn what_has_flowed_is_torn_by_its_volume_alone() {
    let sand = CriticalDruckerPrager {
        bulk_modulus: 1e5,
        shear_modulus: 4e4,
        friction_critical: 0.5,
        fraction_critical: 0.6,
        dilation_factor: 0.0,
        dilation: 0.0,
        softening_rate: 0.0,
        cohesion: 10.0,
    };
    let mut world = point_world::<Plane>(&block(2, [0.0; 3], ""), sand, &Solo);
    let mut shear = <Plane as Space>::Tensor::zero();
    shear[2] = 1.0;
    for hot in &mut world.continuum.points.hot {
        hot.deformation = (Plane::identity() + shear * 40.0) * hot.deformation;
        let mut flowed = MaterialLaw::<Plane>::start(&sand, &Plane::identity(), 0.6);
        MaterialLaw::<Plane>::update(&sand, &shear, 1.0, &mut flowed);
        let words = flowed.numbers();
        hot.memory[..words.len()].copy_from_slice(words);
    }
    world.refuse_spoilt_points().expect("it flows");
    for hot in &mut world.continuum.points.hot {
        hot.deformation *= 6.1;
    }
    assert!(world.refuse_spoilt_points().expect_err("it fills more than it reaches").to_string().contains("is torn"));
}
