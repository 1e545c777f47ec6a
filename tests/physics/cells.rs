//! Cells that are periodic and deform: mean stress, mean field, images across sheared faces, control of stress.

use scree::base::ids::GrainId;
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::dem::cell::Cell;
use scree::dem::drive::{Response, StressServo};
use scree::dem::motion::{Damping, DampingForm};
use scree::domain::layout::{Ground, Layout};
use scree::domain::parts::Parts;
use scree::domain::world::World;
use scree::law::contact::{Contact, LinearSpringDashpot};
use scree_partition::Solo;

use crate::few::{
    Claim, Few, GrainWorld, MASS, RADIUS, cohesive, for_every_law, linear, load_on, row_of, spin, steps, vector,
};
use crate::worlds::Random;

/// A length for the axes that a space has, one m along others.
fn lengths<S: Space>(length: f64) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < S::DIMENSION { length } else { 1.0 })
}

/// The smooth linear law: forces that positions alone fix.
fn smooth() -> LinearSpringDashpot {
    let mut law = linear();
    (law.friction, law.damping_normal, law.damping_tangential) = (0.0, 0.0, 0.0);
    law
}

struct LoadedPair;

/// One pair across the cell's edge, so heavy that it stays: the sum is minus force times branch.
impl Claim for LoadedPair {
    fn hold<S: Space>(law: Contact) {
        let edge = 20.0 * RADIUS;
        let mut few = Few::<S>::periodic(law, 1e-7, [0.0; 3], lengths::<S>(edge));
        few.settings.grains.skin = RADIUS;
        let branch = vector::<S>([1.1, 1.2, 0.9]);
        let branch = branch * ((2.0 * RADIUS - 2e-6) / branch.norm());
        let at = vector::<S>([0.2 * RADIUS; 3]);
        // The second lies beyond the corner, and is there in the image inside.
        let mut other = at - branch;
        for axis in 0..S::DIMENSION {
            other[axis] += edge;
        }
        for (place, velocity) in [(at, [0.01, -0.02, 0.03]), (other, [-0.03, 0.01, 0.02])] {
            let row = few.add([0.0; 3], RADIUS, 1e20);
            row.hot.position = place;
            (row.cold.home, row.cold.origin) = (place, place);
            row.hot.velocity = vector::<S>(velocity);
            row.hot.spin = spin::<S>([1.0, 2.0, -3.0]);
        }
        let mut world = few.world();
        // Some steps, so that there is a tangential force; then none moves, and places are those of the forces.
        steps(&mut world, 20);
        world.assembly.grains.hot.iter_mut().for_each(|hot| hot.velocity = S::Vector::zero());
        let [a, b] = [0, 1].map(|id| world.assembly.grains.hot[row_of(&world, id)].position);
        let mut branch = a - b;
        for axis in 0..S::DIMENSION {
            branch[axis] += edge;
        }
        // Seen ahead: that of the forces which the next step begins with.
        let found = world.contact_moment().unwrap();
        steps(&mut world, 1);
        let force = load_on(&world, 0).0;
        let normal = branch * (1.0 / branch.norm());
        assert!((force - normal * force.dot(&normal)).norm() > 1e-3 * force.norm(), "no tangential force");
        let wanted = -S::outer(&force, &branch);
        let off = (found - wanted).norm() / wanted.norm();
        println!("Love-Weber stress of a loaded pair in the {}: off by {off:.1e}", S::NAME);
        assert!(off < 1e-12, "{found:?} for {wanted:?}, off by {off:e} under {law:?} in {}", S::NAME);
    }
}

#[test]
fn the_moment_of_a_loaded_pair_is_force_times_branch() {
    for_every_law::<LoadedPair>();
}

/// Overlapping by d on a square or cubic lattice of spacing a, every face of a lattice cell bears k d: the stress is
/// -k d/a (times one over the depth) along every axis, nothing across.
fn lattice_stress<S: Space>() {
    const PER_AXIS: usize = 4;
    let (overlap, depth) = (1.5e-6, if S::DIMENSION == 2 { 0.01 } else { 1.0 });
    let spacing = 2.0 * RADIUS - overlap;
    let mut few = Few::<S>::periodic(smooth(), 1e-7, [0.0; 3], lengths::<S>(spacing * PER_AXIS as f64));
    few.settings.grains.skin = 0.1 * RADIUS;
    let layers = if S::DIMENSION == 2 { 1 } else { PER_AXIS };
    for place in 0..PER_AXIS * PER_AXIS * layers {
        let at = [place % PER_AXIS, place / PER_AXIS % PER_AXIS, place / PER_AXIS / PER_AXIS];
        few.add(at.map(|at| (at as f64 + 0.5) * spacing), RADIUS, MASS);
    }
    let mut world = few.world();
    steps(&mut world, 1);
    let stress = world.contact_moment().unwrap() * (1.0 / (world.assembly.cell.volume() * depth));
    let face = if S::DIMENSION == 2 { spacing * depth } else { spacing * spacing };
    let wanted = S::identity() * (-smooth().stiffness_normal * overlap / face);
    let off = (stress - wanted).norm() / wanted.norm();
    println!("stress of a lattice in the {}: off by {off:.1e}", S::NAME);
    assert!(off < 1e-9, "{stress:?} for {wanted:?}, off by {off:e}");
}

#[test]
fn the_stress_of_a_lattice_is_that_of_its_faces() {
    lattice_stress::<Plane>();
    lattice_stress::<Solid>();
}

/// Velocity gradients as they are written, by rows.
fn gradient<S: Space>(rows: [[f64; 3]; 3]) -> S::Tensor {
    let mut tensor = S::Tensor::zero();
    for i in 0..S::DIMENSION {
        for j in 0..S::DIMENSION {
            tensor[j * S::DIMENSION + i] = rows[i][j];
        }
    }
    tensor
}

/// Grains so small that they never meet, with velocities of their own of up to `speed` m/s.
fn gas<S: Space>(gradient: S::Tensor, speed: f64) -> Few<S> {
    let edge = 40.0 * RADIUS;
    let corner = [-0.3 * edge, 0.1 * edge, -edge];
    let mut few = Few::<S>::periodic(linear(), 1e-5, corner, lengths::<S>(edge));
    few.settings.grains.skin = 2.0 * RADIUS;
    few.settings.grains.drive.gradient = gradient;
    let mut random = Random(3);
    for column in 0..25 {
        let at = [column % 5, column / 5, column * 7 % 5];
        let velocity = [0; 3].map(|_| speed * random.signed());
        let row = few.add([0.0; 3], 1e-3 * RADIUS, MASS);
        for axis in 0..S::DIMENSION {
            row.hot.position[axis] += corner[axis] + 8.0 * RADIUS * (f64::from(at[axis]) + 0.5);
        }
        (row.cold.home, row.cold.origin) = (row.hot.position, row.hot.position);
        row.hot.velocity = vector::<S>(velocity);
    }
    few
}

/// Velocities against the mean field where the last step set out from, by id: that is what velocities half a step behind
/// are taken against.
fn fluctuations<S: Space>(world: &GrainWorld<S>) -> Vec<S::Vector> {
    let mut found: Vec<(GrainId, S::Vector)> = world
        .assembly
        .grains
        .cold
        .iter()
        .zip(&world.assembly.grains.hot)
        .map(|(cold, hot)| {
            let before = hot.position - hot.velocity * world.settings.grains.dt;
            (cold.id, hot.velocity - world.assembly.cell.gradient * (before - world.assembly.cell.corner))
        })
        .collect();
    found.sort_unstable_by_key(|(id, _)| *id);
    found.into_iter().map(|(_, velocity)| velocity).collect()
}

/// In simple shear what a grain of a gas has beside the mean field stays as it is, also as it leaves through a sheared face
/// and comes in at the other: there its velocity changes by the cell's rate and nothing else.
fn keeps_its_fluctuations<S: Space>() {
    let rate = 3.0;
    let shear = gradient::<S>([[0.0, rate, 0.0], [0.0; 3], [0.0; 3]]);
    let few = gas::<S>(shear, 0.02);
    let own: Vec<S::Vector> = few.grains.iter().map(|grain| grain.hot.velocity).collect();
    let mass: f64 = few.grains.iter().map(|grain| grain.hot.mass).sum();
    let mut world = few.world();
    let mut worst = 0.0f64;
    for _ in 0..40 {
        steps(&mut world, 2500);
        world.rebuild().unwrap();
        for (now, own) in fluctuations(&world).iter().zip(&own) {
            worst = worst.max((*now - *own).norm());
        }
        for hot in &world.assembly.grains.hot {
            let fraction = world.assembly.cell.fraction(&hot.position);
            assert!((0..S::DIMENSION).all(|axis| (0.0..=1.0).contains(&fraction[axis])), "{fraction:?}");
        }
        let ledger = world.holdings().unwrap();
        assert!((ledger.mass / mass - 1.0).abs() < 1e-14 && world.grains_total == 25, "{} kg", ledger.mass);
    }
    let crossed = world.assembly.grains.cold.iter().filter(|cold| cold.image[1] != 0).count();
    assert!(crossed > 4, "{crossed} grains crossed the sheared face");
    assert!(worst < 1e-11, "fluctuations changed by {worst:e} m/s in {}", S::NAME);
}

#[test]
fn a_gas_in_simple_shear_keeps_its_fluctuations_across_the_faces() {
    keeps_its_fluctuations::<Plane>();
    keeps_its_fluctuations::<Solid>();
}

/// Without velocities of their own grains stay at their places in the cell under any gradient, and move as L x.
fn moves_with_the_mean_field<S: Space>() {
    let any = gradient::<S>([[-2.0, 3.0, 1.0], [0.5, 1.0, -1.5], [2.0, -0.5, 1.5]]);
    let mut world = gas::<S>(any, 0.0).world();
    let places = |world: &GrainWorld<S>| -> Vec<S::Vector> {
        (0..25).map(|id| world.assembly.cell.fraction(&world.assembly.grains.hot[row_of(world, id)].position)).collect()
    };
    let (before, edges_before) = (places(&world), world.assembly.cell.edges);
    steps(&mut world, 20_000);
    for (now, before) in places(&world).iter().zip(&before) {
        assert!((*now - *before).norm() < 1e-11, "{before:?} became {now:?}");
    }
    for velocity in fluctuations(&world) {
        assert!(velocity.norm() < 1e-11, "{velocity:?} m/s beside the mean field");
    }
    let edges = world.assembly.cell.edges;
    assert!((edges - edges_before).norm() > 0.1 * edges.norm(), "the cell hardly deformed");
}

#[test]
fn grains_at_rest_in_a_cell_move_as_it_deforms() {
    moves_with_the_mean_field::<Plane>();
    moves_with_the_mean_field::<Solid>();
}

/// Every pair in touch is found once, however far the cell is sheared: counted against all images.
fn finds_its_pairs<S: Space>() {
    let edge = 16.0 * RADIUS;
    let mut random = Random(17);
    for shear in [0.0, 0.4, 1.0, 1.7] {
        let mut few = Few::<S>::periodic(smooth(), 1e-7, [0.0; 3], lengths::<S>(edge));
        few.settings.grains.skin = 0.1 * RADIUS;
        let mut cell: Cell<S> = few.cell;
        let mut rows = [[0.0; 3]; 3];
        (rows[0][1], rows[1][2], rows[0][2]) = (shear, -0.3 * shear, 0.5 * shear);
        cell.deform(gradient::<S>(rows), 1.0);
        few.cell = cell;
        let count = if S::DIMENSION == 2 { 60 } else { 300 };
        for _ in 0..count {
            let mut place = cell.corner;
            for axis in 0..S::DIMENSION {
                let share = 0.5 * (random.signed() + 1.0);
                for component in 0..S::DIMENSION {
                    place[component] += share * cell.edges[axis * S::DIMENSION + component];
                }
            }
            let row = few.add([0.0; 3], RADIUS * (1.0 + 0.3 * random.signed()), MASS);
            row.hot.position = place;
            (row.cold.home, row.cold.origin) = (place, place);
        }
        let mut wanted = 0;
        for (index, a) in few.grains.iter().enumerate() {
            for b in &few.grains[..index] {
                let images = (-2..=2).flat_map(|x| (-2..=2).flat_map(move |y| (-2..=2).map(move |z| [x, y, z])));
                let touches = |image: [i32; 3]| {
                    let apart = a.hot.position - b.hot.position + cell.shift(image);
                    apart.norm() < a.hot.radius + b.hot.radius
                };
                let images = images.filter(|image| S::DIMENSION == 3 || image[2] == 0);
                wanted += images.filter(|image| touches(*image)).count();
            }
        }
        let mut world = few.world();
        world.refresh_ghosts();
        let found = world.assembly.contacts.count(&smooth(), &world.assembly.grains);
        assert!(found == wanted && wanted > 20, "shear {shear}: {found} contacts for {wanted} in {}", S::NAME);
    }
}

#[test]
fn a_sheared_cell_finds_every_pair_across_its_faces() {
    finds_its_pairs::<Plane>();
    finds_its_pairs::<Solid>();
}

/// Copies come from neighbouring blocks alone, so a contact that reaches across a whole one would be lost on several ranks:
/// periodic or not, such blocks are refused. Cohesion holds on over 3 mm here.
fn refuses_thin_blocks<S: Space>(periodic: bool) {
    let mut law = cohesive();
    (law.linear.stiffness_normal, law.cohesion_normal) = (1000.0, 3.0);
    let edge = 48.0 * RADIUS;
    let mut few = Few::<S>::new(law, 1e-6, edge);
    few.cell.periodic = [periodic; 3];
    few.settings.grains.skin = 0.1 * RADIUS;
    few.add([0.0; 3], RADIUS, MASS);
    let laid = |blocks: usize| {
        let Few { grains, bodies, cell, settings } = few.clone();
        let corner = std::array::from_fn(|axis| if axis < S::DIMENSION { cell.corner[axis] } else { 0.0 });
        let ground = Ground::open([4 * blocks; 3], 4, edge / (4 * blocks) as f64, corner, cell.periodic);
        let layout = Layout::new::<S>(ground).unwrap();
        World::new(settings, layout, &Solo, 0, Parts::fresh(grains, Vec::new(), bodies, cell)).map(|_| ())
    };
    assert!(laid(5).is_ok(), "blocks of 4.8 mm reach far enough");
    let refusal = laid(8).expect_err("blocks of 3 mm do not").to_string();
    assert!(refusal.contains("contacts reach 4.050e-3 m, which needs thicker ones"), "{refusal}");
}

#[test]
fn blocks_thinner_than_contacts_reach_are_refused_in_open_cells_too() {
    for periodic in [false, true] {
        refuses_thin_blocks::<Plane>(periodic);
        refuses_thin_blocks::<Solid>(periodic);
    }
}

/// Sixty-four damped discs without friction on a perturbed triangular lattice that just do not touch are brought to a target stress, in compression
/// different along the axes.
#[test]
fn a_stress_servo_brings_a_packing_to_its_target() {
    let (depth, spacing) = (0.01, 2.004 * RADIUS);
    let mut law = linear();
    law.friction = 0.0;
    let row = spacing * 0.75f64.sqrt();
    let mut few = Few::<Plane>::periodic(law, 4e-7, [0.0; 3], [8.0 * spacing, 8.0 * row, 1.0]);
    few.settings.grains.skin = 0.05 * RADIUS;
    few.settings.grains.field.damping = Damping { local: 0.3, form: DampingForm::Vector, mass: 0.0 };
    let target = [Some(-100e3), Some(-130e3), None];
    few.settings.grains.drive.servo = Some(StressServo {
        stress: target,
        response: Response::Contacts { gain: 0.5 },
        interval: 5,
        rate_max: 5.0,
        depth,
    });
    let mut random = Random(41);
    for place in 0..64 {
        let mut jitter = || 1e-3 * RADIUS * random.signed();
        let shift = 0.5 * f64::from(place / 8 % 2);
        let at =
            [(f64::from(place % 8) + shift) * spacing + jitter(), (f64::from(place / 8) + 0.5) * row + jitter(), 0.0];
        few.add(at, RADIUS + jitter(), MASS);
    }
    let mut world = few.world();
    steps(&mut world, 60_000);
    let stress = world.contact_moment().unwrap() * (1.0 / (world.assembly.cell.volume() * depth));
    println!("servo: {stress:?} Pa, gradient {:?}", world.assembly.cell.gradient);
    for (axis, wanted) in [(0, -100e3), (1, -130e3)] {
        let found = stress[(axis, axis)];
        assert!((found / wanted - 1.0).abs() < 1e-3, "axis {axis}: {found} Pa for {wanted} Pa");
    }
    assert!(stress[(0, 1)].abs() < 5e3, "{stress:?}");
}
