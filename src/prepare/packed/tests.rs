//! Small packings from start to end.

use std::collections::BTreeMap;
use std::path::Path;

use scree_partition::Solo;
use scree_partition::transport::threads;

use super::*;
use crate::base::math;
use crate::base::space::{Linear, Plane, Solid};
use crate::dem::drive::CellDrive;
use crate::dem::grains::is_body;
use crate::dem::tile::tile;
use crate::domain::parts::Parts;
use crate::domain::stop::lives;
use crate::domain::world::World;
use crate::job::assembly::Source;
use crate::job::{Job, figures};
use crate::prepare::grain_world::{self, GrainWorld};

const DISCS: &str = r#"
name = "discs"
seed = 5
[cell]
space = "plane"
lower = ["-2 mm", "3 mm"]
upper = ["14 mm", "15 mm"]
depth = "1 cm"
[grains]
density = "2500 kg/m3"
count = 200
diameter_mean = "1 mm"
diameter_deviation = "0.1 mm"
[packing]
preparation = "compress"
stress = "1 MPa"
friction = 0.1
energy_ratio_max = 1e-4
[contact]
law = "linear"
stiffness_normal = "1000 kN/m"
stiffness_tangential = "500 kN/m"
restitution = 0.3
friction = 0.5
[time]
step = "0.4 us"
end = "1 ms"
"#;

const SPHERES: &str = r#"
name = "spheres"
seed = 5
[cell]
space = "solid"
lower = ["-2 mm", "3 mm", "0 mm"]
upper = ["4 mm", "9 mm", "6 mm"]
[grains]
density = "2500 kg/m3"
count = 150
distribution = "uniform"
diameter_min = "0.9 mm"
diameter_max = "1.1 mm"
[packing]
preparation = "compress"
stress = "1 MPa"
energy_ratio_max = 1e-3
[contact]
law = "linear"
stiffness_normal = "100 kN/m"
stiffness_tangential = "50 kN/m"
restitution = 0.3
friction = 0.5
[time]
step = "0.3 us"
end = "1 ms"
"#;

const POUR: &str = r#"
name = "pour"
seed = 2
[cell]
space = "plane"
upper = ["12 mm", "30 mm"]
periodic = [true, false]
depth = "1 cm"
gravity = [0, "-9.81 m/s2"]
[grains]
density = "2500 kg/m3"
count = 100
diameter_mean = "1 mm"
diameter_deviation = "0.1 mm"
[packing]
preparation = "pour"
friction = 0.3
[contact]
law = "linear"
stiffness_normal = "10 kN/m"
stiffness_tangential = "5 kN/m"
restitution = 0.3
friction = 0.5
[time]
step = "4 us"
end = "1 ms"
[[body]]
name = "floor"
shape = "plane"
point = [0, "1 mm"]
normal = [0, 1]
[[body]]
name = "rod"
shape = "cylinder"
centre = ["6 mm", "8 mm"]
radius = "1 mm"
"#;

/// Few grains, not quite at rest: packing them takes little time.
const SMALL: [&str; 2] = ["grains.count=60", "packing.energy_ratio_max=1e-3"];

fn job(text: &str, sets: &[&str], folder: &Path) -> Assembly {
    let cache = format!("packing.cache={}", folder.display());
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).chain([cache]).collect();
    match Job::parse(text, "job.toml", &sets) {
        Ok(Job::Assembly(job)) => job,
        other => panic!("{other:?}"),
    }
}

fn made<S: Space>(job: &Assembly, transport: &dyn Transport) -> Result<Packing<S>, Error> {
    let Source::Packed(packed) = &job.source else { panic!("the job makes its grains") };
    make(job, packed, job.output.save_every(), transport)
}

/// The normal stresses of a packing over the wanted stress, from a world of its own.
fn stresses<S: Space>(job: &Assembly, stress: f64) -> Vec<f64> {
    let mut world = grain_world::world::<S>(job, &Solo).unwrap();
    let moment = world.contact_moment().unwrap();
    let volume = grain_world::volume(&world.assembly.cell, job);
    (0..S::DIMENSION).map(|axis| -moment[axis * S::DIMENSION + axis] / volume / stress).collect()
}

/// Compressed to the stress, at rest in a box of its own, the same from the cache and on several ranks.
fn compresses<S: Space>(text: &str, fractions: std::ops::Range<f64>) {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let alone = job(text, &[], folders[0].path());
    let packing = made::<S>(&alone, &Solo).unwrap();
    assert!(packing.grains.iter().enumerate().all(|(at, row)| row.cold.id == GrainId(at as u64)));
    assert!(packing.grains.iter().all(|row| row.hot.velocity == Linear::zero() && row.cold.origin == row.hot.position));
    assert!(packing.grains.iter().map(|row| row.contacts.len()).sum::<usize>() > 3 * packing.grains.len());
    let found = stresses::<S>(&alone, 1e6);
    assert!(found.iter().all(|stress| (stress - 1.0).abs() < 0.01), "{found:?}");
    let world = grain_world::world::<S>(&alone, &Solo).unwrap();
    let fraction = grain_world::fraction(&world, &alone).unwrap();
    assert!(fractions.contains(&fraction), "{fraction}");
    assert_eq!(world.assembly.cell.corner, packing.cell.corner);

    let text_of = |rows: &[GrainRow<S>]| format!("{rows:?}");
    let wanted = (text_of(&packing.grains), packing.cell.edges);
    let cached = made::<S>(&alone, &Solo).unwrap();
    assert!((text_of(&cached.grains), cached.cell.edges) == wanted, "from the cache");
    let shared = job(text, &[], folders[1].path());
    let mut ranks =
        threads::run(3, |rank| made::<S>(&shared, &rank).map(|made| (text_of(&made.grains), made.cell.edges)).unwrap());
    assert!(ranks.iter().all(|(_, edges)| *edges == wanted.1));
    assert!(ranks.swap_remove(0) == wanted, "made on three ranks");
}

/// A packing that is stopped every so many steps and gone on with is to the bit the one that nobody stopped: whatever its looks
/// have set is saved with it.
fn is_the_same_in_short_lives<S: Space>(text: &str, sets: &[&str], steps: u64) {
    let text_of = |packing: Packing<S>| format!("{:?} {:?}", packing.grains, packing.cell.edges);
    let whole = tempfile::tempdir().unwrap();
    let wanted = text_of(made::<S>(&job(text, sets, whole.path()), &Solo).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let job = job(text, sets, folder.path());
    let (found, lives) = lives::of(steps, || made::<S>(&job, &Solo));
    assert!(lives > 10, "{lives} lives");
    assert!(text_of(found) == wanted, "another packing after {lives} lives of {steps} steps");
}

#[test]
fn a_compression_in_short_lives_is_that_of_one_life() {
    is_the_same_in_short_lives::<Plane>(DISCS, &SMALL, 137);
    is_the_same_in_short_lives::<Solid>(SPHERES, &["packing.energy_ratio_max=1e-2"], 499);
}

#[test]
fn an_unloading_in_short_lives_is_that_of_one_life() {
    is_the_same_in_short_lives::<Plane>(DISCS, &[&SMALL[..], &["packing.unloaded=100 kPa"]].concat(), 137);
}

#[test]
fn a_gas_in_short_lives_is_that_of_one_life() {
    let wanted = ["packing.friction=0.01", "packing.fraction=0.8737"];
    is_the_same_in_short_lives::<Plane>(DISCS, &[&SMALL[..], &wanted].concat(), 1013);
}

#[test]
fn a_pouring_in_short_lives_is_that_of_one_life() {
    is_the_same_in_short_lives::<Plane>(POUR, &["packing.energy_ratio_max=1e-3"], 137);
}

#[test]
fn discs_are_compressed_to_a_stress() {
    compresses::<Plane>(DISCS, 0.83..0.86);
}

#[test]
fn spheres_are_compressed_to_a_stress() {
    compresses::<Solid>(SPHERES, 0.63..0.67);
}

/// Compressed by a hundred times what is wanted, and let come to that: as dense as it was but for what is elastic.
/// Grains that bounce shake the servo, and the cell that follows shakes them: 400 discs under 25 kPa kept their gas for as long as
/// anybody waited.
#[test]
fn grains_that_the_servo_shakes_come_to_rest() {
    let text = r#"
name = "shaken"
seed = 1
[cell]
space = "plane"
upper = ["19.3 mm", "19.3 mm"]
periodic = [true, true]
[grains]
density = "2530 kg/m3"
count = 400
diameter_mean = "1 mm"
diameter_deviation = "0.08 mm"
[packing]
preparation = "compress"
stress = "25 kPa"
friction = 0.01
energy_ratio_max = 1e-5
[contact]
stiffness_normal = 1772093.8
stiffness_tangential = 886046.9
damping_normal = "3.5 N s/m"
damping_tangential = "3.5 N s/m"
friction = 0.5
[time]
step = "0.4 us"
end = "1 ms"
"#;
    let folder = tempfile::tempdir().unwrap();
    made::<Plane>(&job(text, &[], folder.path()), &Solo).expect("it rests");
}

/// The cell of loose grains answers as ever for a million steps, then half as fast, down to a bound, and no packing that rests before changes a bit.
#[test]
fn a_cell_that_does_not_settle_answers_more_slowly() {
    let shares = [0, 999_999, 1_000_000, 1_199_999, 1_200_000, 3_000_000, u64::MAX].map(compress::share_of_loose);
    assert_eq!(shares, [1.0, 1.0, 0.5, 0.5, 0.25, 2f64.powi(-10), 2f64.powi(-10)]);
}

#[test]
fn a_packing_is_unloaded_to_a_lower_stress() {
    let folder = tempfile::tempdir().unwrap();
    let fraction = |sets: &[&str], stress: f64| {
        let job = job(DISCS, sets, folder.path());
        made::<Plane>(&job, &Solo).unwrap();
        let found = stresses::<Plane>(&job, stress);
        assert!(found.iter().all(|stress| (stress - 1.0).abs() < 0.02), "{found:?}");
        grain_world::fraction(&grain_world::world::<Plane>(&job, &Solo).unwrap(), &job).unwrap()
    };
    let loaded = fraction(&["grains.count=150"], 1e6);
    let unloaded = fraction(&["grains.count=150", "packing.unloaded=10 kPa"], 1e4);
    // Mean overlaps of 1 MPa: a hundredth of a diameter.
    assert!((1e-3..0.03).contains(&(1.0 - unloaded / loaded)), "{loaded} {unloaded}");
}

#[test]
fn a_gas_packs_denser_than_grains_at_rest() {
    let folder = tempfile::tempdir().unwrap();
    let small = ["grains.count=150", "packing.friction=0.01", "packing.energy_ratio_max=1e-3"];
    let fraction = |job: &Assembly| {
        made::<Plane>(job, &Solo).unwrap();
        grain_world::fraction(&grain_world::world::<Plane>(job, &Solo).unwrap(), job).unwrap()
    };
    let plain = fraction(&job(DISCS, &small, folder.path()));
    let wanted = plain + 0.006;
    let dense = fraction(&job(DISCS, &[&small[..], &[&format!("packing.fraction={wanted}")]].concat(), folder.path()));
    assert!((dense - wanted).abs() <= 0.002, "{plain} {dense}");
}

/// Hertz contacts are as stiff as the stress that loads them makes them, which grows with its cubic root.
#[test]
fn the_modulus_of_hertz_contacts_goes_by_their_load() {
    let hertz = SPHERES.replace(
        "law = \"linear\"\nstiffness_normal = \"100 kN/m\"\nstiffness_tangential = \"50 kN/m\"\nrestitution = 0.3",
        "law = \"hertz_mindlin\"\nshear_modulus = \"2 GPa\"\npoisson_ratio = 0.2",
    );
    let modulus = figures::modulus_under(&job(&hertz, &[], Path::new("cache")), 1e5);
    // F = 4/3 E* sqrt(R*) d^(3/2), and the normal stiffness is dF/dd.
    let (reduced, radius) = (2e9 / (1.0 - 0.2), 0.25e-3);
    let load = 1e5 * 1e-6 / (4.0 / 3.0 * reduced);
    let overlap = math::cbrt(load * load / radius);
    let stiffness = 2.0 * reduced * (radius * overlap).sqrt();
    assert!((modulus * 1e-3 / stiffness - 1.0).abs() < 1e-9, "{} {stiffness}", modulus * 1e-3);
}

/// Copies bear what one does, on the way too; each contact has its memory.
fn copies_are_alike<S: Space>(text: &str, copies: &str, count: usize) {
    let folder = tempfile::tempdir().unwrap();
    let driven = match S::DIMENSION {
        2 => "cell.velocity_gradient=[[0, \"20 1/s\"], [0, 0]]",
        _ => "cell.velocity_gradient=[[0, \"20 1/s\", 0], [0, 0, 0], [0, 0, 0]]",
    };
    // By the step that a job has by itself, as one copy is packed.
    let text = text.lines().filter(|line| !line.starts_with("step = ")).collect::<Vec<_>>().join("\n");
    let one = job(&text, &[driven], folder.path());
    let all = job(&text, &[driven, &format!("cell.copies={copies}")], folder.path());
    assert_eq!(figures::grains(&all), Some(count as u64 * figures::grains(&one).unwrap()));
    let [mut one_world, mut world] = [&one, &all].map(|job| grain_world::world::<S>(job, &Solo).unwrap());
    let stress = |world: &mut GrainWorld<S>, job: &Assembly| {
        let moment = world.contact_moment().unwrap();
        let volume = grain_world::volume(&world.assembly.cell, job);
        (0..S::Tensor::COMPONENTS).map(|at| moment[at] / volume).collect::<Vec<f64>>()
    };
    for (steps, tolerance) in [(0, 1e-12), (200, 1e-9)] {
        for _ in 0..steps {
            one_world.advance().unwrap();
            world.advance().unwrap();
        }
        let (of_one, of_all) = (stress(&mut one_world, &one), stress(&mut world, &all));
        let scale = of_one.iter().fold(0.0, |most, value| f64::max(most, value.abs()));
        let off = of_one.iter().zip(&of_all).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < tolerance * scale, "{steps} steps: {of_one:?}, {of_all:?}");
    }
    let packing = made::<S>(&one, &Solo).unwrap();
    let contacts = |rows: &[GrainRow<S>]| rows.iter().map(|row| row.contacts.len()).sum::<usize>();
    let (single, edges) = (contacts(&packing.grains), packing.cell.edges);
    let (rows, cell) = packing.repeated(&all);
    assert_eq!((rows.len(), contacts(&rows)), (count * figures::grains(&one).unwrap() as usize, count * single));
    assert!(rows.iter().enumerate().all(|(at, row)| row.cold.id == GrainId(at as u64)));
    assert_eq!(cell.edges[0], edges[0] * all.cell.counts()[0] as f64);
    // Across an open end nothing touches: less by the contacts that one packing has through that face.
    let [packing, again] = [(); 2].map(|()| made::<S>(&one, &Solo).unwrap());
    let crossing = |row: &GrainRow<S>| {
        let image = |partner: GrainId| {
            let place = again.grains[partner.0 as usize].hot.position;
            again.cell.image_towards(&row.hot.position, &place)[1]
        };
        row.contacts.iter().filter(|(partner, _)| image(*partner) != 0).count()
    };
    let across: usize = again.grains.iter().map(crossing).sum();
    let faces = count / all.cell.counts()[1] as usize;
    let mut open = all.clone();
    open.cell.periodic[1] = false;
    let (rows, with_room) = packing.repeated(&open);
    let room = figures::room(&open, 1);
    let beyond = 2.0 * room + cell.edges[S::DIMENSION + 1] - with_room.edges[S::DIMENSION + 1];
    assert!(room > 0.0 && beyond.abs() < 1e-12, "{beyond}");
    assert!(across > 8);
    assert_eq!(contacts(&rows), count * single - faces * across);
}

#[test]
fn copies_of_discs_side_by_side_are_alike() {
    copies_are_alike::<Plane>(DISCS, "[3, 2]", 6);
}

#[test]
fn copies_of_spheres_side_by_side_are_alike() {
    copies_are_alike::<Solid>(SPHERES, "[2, 2, 1]", 4);
}

/// The open ends of copies are held by layers of their grains.
#[test]
fn layers_hold_copies_with_open_ends() {
    let folder = tempfile::tempdir().unwrap();
    let layers = r#"
[[body]]
name = "lower"
shape = "layer"
lower = ["-2 mm", "3 mm"]
upper = ["14 mm", "5 mm"]
[[body]]
name = "upper"
shape = "layer"
lower = ["-2 mm", "24.7 mm"]
upper = ["14 mm", "27 mm"]
servo = { direction = [0, 1], stress = "1 MPa", area = "1.58 cm2", mass = "20 g", damping = "100 N s/m", speed_max = "10 cm/s" }
"#;
    let sets = ["cell.copies=[1, 2]", "cell.periodic=[true, false]"];
    let job = job(&format!("{DISCS}{layers}"), &sets, folder.path());
    let mut world = grain_world::world::<Plane>(&job, &Solo).unwrap();
    let edge = world.assembly.cell.edges[0];
    let mut before = Vec::new();
    for steps in [3000, 1000] {
        before = world.bodies.iter().map(|body| body.impulse_whole[1]).collect();
        for _ in 0..steps {
            world.advance().unwrap();
        }
    }
    let wanted = 1e6 * edge * 0.01 * 1000.0 * job.step;
    let borne = world.bodies.iter().zip(&before).map(|(body, before)| (body.impulse_whole[1] - before) / wanted);
    let borne: Vec<f64> = borne.collect();
    // There is room to dilate into.
    let top = world.assembly.cell.corner[1] + world.assembly.cell.edges[3];
    assert!(world.bodies[1].displacement[1].abs() > 0.0 && top > 28e-3, "{top}");
    assert!(borne.iter().all(|share: &f64| (share.abs() - 1.0).abs() < 0.1), "{borne:?}");
    let one = grain_world::world::<Plane>(&Assembly { bodies: Vec::new(), ..job.of_one_copy().into_owned() }, &Solo);
    assert!((one.unwrap().assembly.cell.edges[0] / edge - 1.0).abs() < 1e-15);
}

/// What the direct simulation of simple shear begins with are the grains that every element has.
#[test]
fn a_direct_simulation_has_the_packing_of_the_elements() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/fem_dem/");
    let load = |name: &str| Job::load(format!("{folder}{name}.toml").as_ref(), &[]).unwrap();
    let recipe = |job: &Assembly| {
        let Source::Packed(packed) = &job.source else { panic!("it makes its grains") };
        recipe::packed(&job.of_one_copy(), packed)
    };
    let jobs = (load("simple_shear"), load("dns_simple_shear"));
    let (Job::Mpm(meshed), Job::Assembly(alone)) = jobs else { panic!("one has elements, the other a cell") };
    assert_eq!(recipe(&alone), recipe(&meshed.grains.unwrap().piece));
}

#[test]
fn packings_that_cannot_be_made_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let refusal = |text: &str, sets: &[&str]| match made::<Plane>(&job(text, sets, folder.path()), &Solo) {
        Ok(_) => panic!("{sets:?} was made"),
        Err(error) => error.to_string(),
    };
    let found = refusal(DISCS, &["packing.fraction=0.7", "grains.count=60"]);
    assert!(found.starts_with("packing.fraction = 0.7 is less than compression to 1000000 Pa reaches"), "{found}");
    let found = refusal(DISCS, &["grains.count=12"]);
    assert!(found.starts_with("grains.count makes 12 grains, which fill a cell that is only"), "{found}");
    let found = refusal(POUR, &["packing.fraction_start=0.5", "cell.upper=[\"12 mm\", \"13.3 mm\"]"]);
    assert!(found.starts_with("packing.fraction_start = 0.5 is too dense to insert 100 grains"), "{found}");
    let body = "\n[[body]]\nname = \"post\"\nshape = \"cylinder\"\ncentre = [0, \"8 mm\"]\nradius = \"1 mm\"\n";
    let found = refusal(&format!("{DISCS}{body}"), &[]);
    assert!(found.contains("body `post` stands in it"), "{found}");
}

/// The bodies carry the weight after the run has gone on for a while, and contacts with them come from the cache.
#[test]
fn poured_grains_rest_on_the_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(POUR, &[], folder.path());
    let packing = made::<Plane>(&job, &Solo).unwrap();
    let with_body = |row: &&GrainRow<Plane>| row.contacts.iter().any(|(partner, _)| is_body(*partner));
    assert!(packing.grains.iter().filter(with_body).count() > 8);
    assert!(packing.grains.iter().all(|row| row.hot.position[1] > 1.4e-3 && row.hot.position[1] < 20e-3));
    let mut world = grain_world::world::<Plane>(&job, &Solo).unwrap();
    assert_eq!(world.assembly.cell, grain_world::cell_of(&job));
    let weight = 9.81 * packing.grains.iter().map(|row| row.hot.mass).sum::<f64>();
    for steps in [1, 4000] {
        for _ in 0..steps {
            world.advance().unwrap();
        }
        let carried: f64 = world.assembly.walls.list.iter().map(|wall| wall.force[1]).sum();
        assert!((carried / weight - 1.0).abs() < 0.01, "{steps} steps: {}", carried / weight);
    }
    // Falling by a grain's size would have taken 3,600 steps.
    let kinetic = world.energies().unwrap().kinetic_grains;
    assert!(kinetic < 1e-4 * weight * 1e-3, "{kinetic}");
}

/// What time the velocities of a run belong to is no part of a packing's key, so it must not shape the packing either.
#[test]
fn a_packing_starts_from_velocities_of_its_own() {
    let text_of = |velocities: &str| {
        let folder = tempfile::tempdir().unwrap();
        let sets = [&SMALL[..], &[velocities]].concat();
        format!("{:?}", made::<Plane>(&job(DISCS, &sets, folder.path()), &Solo).unwrap().grains)
    };
    assert!(text_of("time.velocities=now") == text_of("time.velocities=half_step_before"));
}

/// A compressed cell shrinks away from a region at its upper edge.
#[test]
fn a_layer_that_catches_no_grain_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let layer = |lower: &str, upper: &str| {
        let body = format!("\n[[body]]\nname = \"rough\"\nshape = \"layer\"\nlower = {lower}\nupper = {upper}\n");
        grain_world::world::<Plane>(&job(&format!("{DISCS}{body}"), &SMALL, folder.path()), &Solo)
            .map(|world| world.assembly.grains.cold.iter().filter(|cold| cold.mover != Mover::Free).count())
    };
    assert!(layer("[\"-2 mm\", \"3 mm\"]", "[\"14 mm\", \"4 mm\"]").unwrap() > 3);
    let refusal = layer("[\"-2 mm\", \"14 mm\"]", "[\"14 mm\", \"15 mm\"]").expect_err("nothing lies there");
    assert_eq!(refusal.exit_code(), 2);
    let found = refusal.to_string();
    assert!(found.starts_with("body `rough` holds no grain"), "{found}");
    assert!(found.contains("the cell reaching from -2.0000e-3 to "), "{found}");
}

/// A world of some rows in a cell of their own.
fn world_of<S: Space>(job: &Assembly, grains: Vec<GrainRow<S>>, cell: Cell<S>) -> GrainWorld<'static, S> {
    let settings = grain_world::settings_in(job, CellDrive::default());
    let layout = grain_world::layout_of(job, &cell).unwrap();
    World::new(settings, layout, &Solo, 0, Parts::fresh(grains, Vec::new(), Vec::new(), cell)).unwrap()
}

/// Force and torque of every grain in the first step.
fn forces<S: Space>(world: &mut GrainWorld<S>) -> BTreeMap<u64, (S::Vector, S::Spin)> {
    world.advance().unwrap();
    let grains = &world.assembly.grains;
    (0..grains.owned).map(|row| (grains.cold[row].id.0, (grains.force[row], grains.torque[row]))).collect()
}

/// The cell of a tiled packing.
fn tiled_cell<S: Space>(cell: &Cell<S>, counts: [usize; 3]) -> Cell<S> {
    let mut longer = *cell;
    for (axis, count) in counts.iter().enumerate().take(S::DIMENSION) {
        for row in 0..S::DIMENSION {
            longer.edges[axis * S::DIMENSION + row] *= *count as f64;
            longer.rate[axis * S::DIMENSION + row] *= *count as f64;
        }
    }
    let mut tiled = *cell;
    tiled.take_motion_of(&longer);
    tiled
}

/// Every copy feels what its original does, contacts overlap as they did, and none is new or missing. The base is tiled by
/// edges of which the last leans over the first `lean` times: as many copies span the same lattice.
fn tiles<S: Space>(text: &str, counts: [usize; 3], lean: f64) {
    let folder = tempfile::tempdir().unwrap();
    let job = job(text, &[], folder.path());
    let packing = made::<S>(&job, &Solo).unwrap();
    let mut edges = packing.cell.edges;
    edges[(S::DIMENSION - 1) * S::DIMENSION] += lean * edges[0];
    let copies = counts.iter().product::<usize>() as u64;
    let cell = tiled_cell(&packing.cell, counts);
    let mut tiled = tile(packing.grains.clone(), &edges, counts, [true; 3]);
    for row in &mut tiled {
        cell.wrap(&mut row.hot.position, &mut row.hot.velocity);
        row.cold.home = row.hot.position;
    }
    let mut base = world_of(&job, packing.grains, packing.cell);
    let mut large = world_of(&job, tiled, cell);
    assert_eq!(large.contact_count(), copies * base.contact_count());
    let [shallow, deep] =
        [&mut base, &mut large].map(|world| world.assembly.contacts.deepest(&world.assembly.grains).unwrap().0);
    assert!((deep / shallow - 1.0).abs() < 1e-11, "{shallow} {deep}");
    let energies = [&mut base, &mut large].map(|world| world.energies().unwrap().elastic_grains);
    assert!((energies[1] / (copies as f64 * energies[0]) - 1.0).abs() < 1e-11, "{energies:?}");
    let wanted = forces(&mut base);
    // A grain's four to six contacts bear some stress times d^2 each, or d and the depth in the plane; where copies stand
    // is rounded, which is a little more the farther they are.
    let bearing = 4.0 * 1e6 * 1e-3 * if S::DIMENSION == 2 { 1e-2 } else { 1e-3 };
    let mut worst = 0.0f64;
    for (id, (force, torque)) in forces(&mut large) {
        let (one, turn) = wanted[&(id / copies)];
        worst = worst.max((force - one).norm() / bearing).max((torque - turn).norm() / (1e-3 * bearing));
    }
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn tiled_discs_feel_what_their_originals_do() {
    tiles::<Plane>(DISCS, [3, 2, 1], 0.0);
    tiles::<Plane>(DISCS, [2, 2, 1], 1.0);
}

#[test]
fn tiled_spheres_feel_what_their_originals_do() {
    tiles::<Solid>(SPHERES, [2, 1, 2], 0.0);
}
