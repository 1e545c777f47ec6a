//! The account closes: pairs, heaps, drums and dense shear, under each of the four laws.

use scree_partition::{Solo, Transport};

use super::*;
use crate::base::ids::GrainId;
use crate::base::space::{Plane, Solid};
use crate::bodies::body::{Body, Instant, Servo, Shape};
use crate::dem::assembly::Constants;
use crate::dem::cell::Cell;
use crate::dem::drive::CellDrive;
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::law::law_of;
use crate::dem::motion::{Damping, DampingForm};
use crate::domain::layout::{Ground, Layout};
use crate::domain::parts::Parts;
use crate::domain::world::Settings;
use crate::law::contact::{
    Adhesion, Contact, ElasticRolling, HertzMindlin, LinearCohesive, LinearSpringDashpot, NormalForce,
    RollingResistance, Sliding, TangentialForce,
};

const DENSITY: f64 = 2650.0;
const DEPTH: f64 = 0.01;
const MEAN_RADIUS: f64 = 5e-4;

struct Random(u64);

impl Random {
    /// Uniform in [-1, 1) (SplitMix64).
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((word ^ (word >> 31)) >> 11) as f64 * 0.5f64.powi(52) - 1.0
    }
}

fn vector<S: Space>(components: [f64; 3]) -> S::Vector {
    let mut vector = S::Vector::zero();
    (0..S::DIMENSION).for_each(|axis| vector[axis] = components[axis]);
    vector
}

fn grain<S: Space>(id: u64, place: [f64; 3], radius: f64) -> GrainRow<S> {
    let mass = DENSITY * S::grain_volume(radius, DEPTH);
    GrainRow::resting(GrainId(id), vector::<S>(place), radius, mass, Mover::Free)
}

/// A box from the origin with edges along the axes, in blocks of about 3 mm.
fn world<S: Space>(
    transport: &dyn Transport,
    (law, dt): (impl Into<Contact>, f64),
    (lengths, periodic): ([f64; 3], [bool; 3]),
    grains: Vec<GrainRow<S>>,
    bodies: Vec<Body<S>>,
) -> World<'_, S> {
    let settings = Settings::of_grains(Constants::new(dt, 2e-4, law_of(&law.into())));
    let mut cells = [1; 3];
    (0..S::DIMENSION).for_each(|axis| cells[axis] = 2 * ((lengths[axis] / 3e-3) as usize).max(1));
    let ground = Ground::open(cells, 2, 1.5e-3, [0.0; 3], periodic);
    let layout = Layout::new::<S>(ground).unwrap();
    let cell = Cell::cuboid(S::Vector::zero(), vector::<S>(lengths), periodic);
    World::new(settings, layout, transport, 0, Parts::fresh(grains, Vec::new(), bodies, cell)).unwrap()
}

fn run<S: Space>(world: &mut World<'_, S>, steps: usize) {
    (0..steps).for_each(|_| world.advance().unwrap());
}

fn linear(stiffness: f64, damping: f64, friction: f64) -> crate::law::contact::LinearSpringDashpot {
    crate::law::contact::LinearSpringDashpot {
        stiffness_normal: stiffness,
        stiffness_tangential: 0.5 * stiffness,
        damping_normal: damping,
        damping_tangential: damping,
        friction,
        normal_force: NormalForce::TENSILE,
    }
}

/// A dense periodic packing at rest.
fn packed<S: Space>(
    transport: &dyn Transport,
    [smooth, law]: [impl Into<Contact>; 2],
    (count, spacing): (usize, f64),
) -> World<'_, S> {
    let mut random = Random(7);
    let mut grains = Vec::new();
    let layers = if S::DIMENSION == 3 { count } else { 1 };
    for z in 0..layers {
        for y in 0..count {
            for x in 0..count {
                let place = [x, y, z].map(|at| (at as f64 + 0.5 + 0.05 * random.signed()) * spacing);
                grains.push(grain::<S>(grains.len() as u64, place, MEAN_RADIUS * (1.0 + 0.15 * random.signed())));
            }
        }
    }
    let length = count as f64 * spacing;
    let mut world = world(transport, (smooth, 4e-7), ([length; 3], [true; 3]), grains, Vec::new());
    world.settings.grains.field.damping = Damping { local: 0.5, form: DampingForm::Component, mass: 1e3 };
    run(&mut world, 6000);
    world.settings.grains.field.damping = Damping::default();
    world.settings.grains.law = law_of(&law.into());
    world
}

/// Nothing may be missing but what the time step is known to make, to the rounding of `turnover` J; and that may be at
/// most `share` of the work.
#[track_caller]
fn close(name: &str, balance: &Balance, turnover: f64, share: f64) {
    let lost = balance.imbalance() / turnover;
    let unexplained = (balance.imbalance() + balance.made) / turnover;
    println!("{name}: residual {lost:.2e}, unexplained {unexplained:.2e} of {turnover:.2e} J; {balance:?}");
    assert!(unexplained.abs() < UNEXPLAINED_MAX, "{name}: {unexplained:e} of the work is residual: {balance:?}");
    assert!(lost.abs() < share, "{name}: {lost:e} of the work does not close: {balance:?}");
}

/// Rounding of sums over thousands of steps.
const UNEXPLAINED_MAX: f64 = 3e-11;

fn shear<S: Space>(rate: f64) -> CellDrive<S> {
    let mut gradient = S::Tensor::zero();
    gradient[S::DIMENSION] = rate;
    CellDrive { gradient, servo: None }
}

const RATE: f64 = 20.0;
const DISCS: (usize, f64) = (8, 0.945e-3);
const SPHERES: (usize, f64) = (4, 0.91e-3);

/// Dense shear to a strain of 0.032, in 4000 steps or twice as many of half the length.
fn sheared<S: Space, C: Into<Contact>>(law: impl Fn(f64) -> C, packing: (usize, f64), refinement: usize) -> Balance {
    let mut world = packed::<S>(&Solo, [law(0.0), law(0.5)], packing);
    world.settings.grains.dt = 4e-7 / refinement as f64;
    world.settings.grains.drive = shear(RATE);
    world.open_accounts(Accounts::GRAINS);
    run(&mut world, 4000 * refinement);
    world.balance().unwrap()
}

/// `share`: what of the work may not close. It is what laws make by stretching their springs in the plane of the drift's
/// end, and goes down with the time step.
fn closes_in_shear<S: Space, C: Into<Contact>>(name: &str, law: impl Fn(f64) -> C, packing: (usize, f64), share: f64) {
    let balance = sheared::<S, _>(&law, packing, 1);
    close(name, &balance, balance.work(), share);
    assert!(balance.friction > 0.0 && balance.work_cell > 0.0);
}

fn springs(stiffness: f64, damping: f64, friction: f64) -> LinearSpringDashpot {
    linear(stiffness, damping, friction)
}

fn hertz(shear_modulus: f64, damping: f64, friction: f64) -> HertzMindlin {
    HertzMindlin {
        shear_modulus,
        poisson_ratio: 0.2,
        friction,
        damping_normal: damping,
        damping_tangential: damping,
        damping_ratio: 0.0,
        normal_force: NormalForce::TENSILE,
        tangential_force: TangentialForce::Incremental,
    }
}

fn rolling(young_modulus: f64, sliding: Sliding, friction: f64) -> ElasticRolling {
    ElasticRolling {
        young_modulus,
        stiffness_ratio: 0.8,
        friction,
        rolling_stiffness: 0.5,
        rolling_limit: 0.1,
        sliding,
    }
}

fn cohesive(stiffness: f64, damping: f64, [pull, friction]: [f64; 2]) -> LinearCohesive {
    LinearCohesive { linear: linear(stiffness, damping, friction), cohesion_normal: pull, cohesion_tangential: pull }
}

#[test]
fn dense_shear_of_discs() {
    closes_in_shear::<Plane, _>("linear", |mu| springs(2e5, 1.0, mu), DISCS, 5e-8);
    closes_in_shear::<Plane, _>("cohesive", |mu| cohesive(2e5, 1.0, [0.2 * mu, mu]), DISCS, 1e-7);
    closes_in_shear::<Plane, _>("Hertz", |mu| hertz(1e9, 1.0, mu), DISCS, 1e-7);
    closes_in_shear::<Plane, _>("rolling", |mu| rolling(4e8, Sliding::Surface, mu), DISCS, 2e-7);
    closes_in_shear::<Plane, _>("rolling, scaled", |mu| rolling(4e8, Sliding::Scaled, mu), DISCS, 4e-7);
}

#[test]
fn dense_shear_of_spheres() {
    closes_in_shear::<Solid, _>("linear", |mu| springs(5e4, 0.1, mu), SPHERES, 5e-8);
    closes_in_shear::<Solid, _>("cohesive", |mu| cohesive(5e4, 0.1, [0.1 * mu, mu]), SPHERES, 3e-7);
    closes_in_shear::<Solid, _>("Hertz", |mu| hertz(3e8, 0.1, mu), SPHERES, 5e-8);
    let rescaled = |mu| HertzMindlin { tangential_force: TangentialForce::Rescaled, ..hertz(3e8, 0.1, mu) };
    closes_in_shear::<Solid, _>("Hertz, rescaled", rescaled, SPHERES, 5e-8);
    closes_in_shear::<Solid, _>("rolling", |mu| rolling(1e8, Sliding::Surface, mu), SPHERES, 1e-7);
    closes_in_shear::<Solid, _>("rolling, scaled", |mu| rolling(1e8, Sliding::Scaled, mu), SPHERES, 2e-7);
}

/// The spring's energy that a limited dashpot keeps from pulling at the end of a contact goes to its account. Damped so much
/// that opening contacts would pull; forces that are cut have a kink, which the time step does not see exactly.
#[test]
fn dashpots_that_only_repel_close_the_account() {
    let repulsive = NormalForce::REPULSIVE;
    let linear = |mu| {
        let law = springs(2e5, 4.0, mu);
        LinearSpringDashpot { normal_force: repulsive, ..law }
    };
    closes_in_shear::<Plane, _>("linear, repulsive", linear, DISCS, 1e-7);
    let cohesive = |mu| {
        let mut law = cohesive(2e5, 4.0, [0.2 * mu, mu]);
        law.linear.normal_force = repulsive;
        law
    };
    closes_in_shear::<Plane, _>("cohesive, repulsive", cohesive, DISCS, 2e-7);
    let hertz = |mu| {
        let law = hertz(3e8, 0.0, mu);
        HertzMindlin { damping_ratio: 0.3, normal_force: repulsive, ..law }
    };
    closes_in_shear::<Solid, _>("Hertz, repulsive, by damping ratio", hertz, SPHERES, 1e-7);
}

/// Parts that go with any law store and lose what the law beside them does not.
#[test]
fn rolling_and_adhesion_beside_other_laws_close_the_account() {
    let resists = Some(RollingResistance { stiffness: 0.5, limit: 0.1 });
    let rolls = |mu| Contact { rolling: resists, ..springs(2e5, 1.0, mu).into() };
    closes_in_shear::<Plane, _>("linear, rolling", rolls, DISCS, 2e-7);
    let rolls = |mu| Contact { rolling: resists, ..hertz(3e8, 0.1, mu).into() };
    closes_in_shear::<Solid, _>("Hertz, rolling", rolls, SPHERES, 2e-7);
    // A pull of a hundredth of what presses.
    let adheres = |mu| Contact { adhesion: Some(Adhesion { surface_energy: 5.0 }), ..rolls(mu) };
    closes_in_shear::<Solid, _>("Hertz, rolling, adhesive", adheres, SPHERES, 3e-6);
}

/// What does not close is the time step's: half of it at half the step.
#[test]
fn the_residual_goes_with_the_time_step() {
    let residual = |refinement| {
        let balance = sheared::<Plane, _>(|mu| rolling(4e8, Sliding::Scaled, mu), DISCS, refinement);
        balance.imbalance() / balance.work()
    };
    let ratio = residual(1) / residual(2);
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

/// Fast and far: rebuilds, wrapped grains, a cell that takes other edges, both kinds of damping, and a cell that also
/// changes its volume.
#[test]
fn shear_that_goes_far() {
    for form in [DampingForm::Component, DampingForm::Vector] {
        let mut world = packed::<Plane>(&Solo, [springs(2e5, 1.0, 0.0), springs(2e5, 1.0, 0.5)], DISCS);
        world.settings.grains.field.damping = Damping { local: 0.1, form, mass: 50.0 };
        world.settings.grains.drive = shear(500.0);
        world.settings.grains.drive.gradient[0] = 20.0;
        world.open_accounts(Accounts::GRAINS);
        let (mut work, rebuilds, edge) = (0.0, world.rebuilds, world.assembly.cell.edges);
        for step in 0..5000 {
            let share = if step == 0 { 0.5 } else { 1.0 };
            work +=
                share * world.settings.grains.dt * world.contact_moment().unwrap().dot(&world.assembly.cell.gradient);
            world.advance().unwrap();
        }
        let balance = world.balance().unwrap();
        assert!(world.rebuilds > rebuilds + 10);
        assert!(world.assembly.cell.edges[2] < 0.5 * edge[3], "the cell has not turned: {}", world.assembly.cell.edges);
        close("far", &balance, balance.work_cell, 1e-4);
        assert!(balance.damping > 0.05 * balance.work_cell);
        // Stress times rate times volume, by what observers see between steps.
        assert!((work / balance.work_cell - 1.0).abs() < 2e-3, "{work:e} {balance:?}");
    }
}

fn velocity<S: Space>(mut row: GrainRow<S>, velocity: [f64; 3], spin: f64) -> GrainRow<S> {
    row.hot.velocity = vector::<S>(velocity);
    row.hot.spin[S::Spin::COMPONENTS - 1] = spin;
    row
}

/// Two discs that meet off centre, spinning: no work, and what is lost is what the motion had.
#[test]
fn two_discs_collide() {
    let collide = |law: LinearSpringDashpot, dt: f64| {
        let grains = vec![
            velocity::<Plane>(grain::<Plane>(0, [4e-3, 4e-3, 0.0], 5e-4), [0.3, 0.0, 0.0], 200.0),
            velocity::<Plane>(grain::<Plane>(1, [5.02e-3, 4.3e-3, 0.0], 4e-4), [-0.4, 0.1, 0.0], 50.0),
        ];
        let mut world = world(&Solo, (law, dt), ([8e-3, 8e-3, 0.0], [true, true, false]), grains, Vec::new());
        world.open_accounts(Accounts::GRAINS);
        let before = world.energies().unwrap();
        run(&mut world, (4e-4 / dt) as usize);
        let (balance, after) = (world.balance().unwrap(), world.energies().unwrap());
        close("collision", &balance, balance.kinetic_start, 1e-3);
        assert_eq!((balance.work(), balance.elastic), (0.0, 0.0));
        // Apart again nothing accelerates, so that kinetic energies of all instants are one.
        assert!((balance.kinetic / after.kinetic_grains - 1.0).abs() < 1e-13);
        assert!((balance.kinetic_start / before.kinetic_grains - 1.0).abs() < 1e-13);
        balance
    };
    let law = springs(2e5, 0.1, 0.2);
    let [coarse, fine] = [collide(law, 4e-7), collide(law, 5e-8)];
    assert!(coarse.viscous > 0.1 * coarse.kinetic_start && coarse.friction > 1e-3 * coarse.kinetic_start);
    // Contacts that begin and end at full speed are the worst there is, and of second order: 64 times less in an eighth.
    assert!(fine.imbalance().abs() < 0.03 * coarse.imbalance().abs(), "{coarse:?} {fine:?}");
    assert!(fine.residual().abs() < 4e-6);
    // Without losses only the time step's error is left.
    let elastic = collide(springs(2e5, 0.0, 0.0), 5e-8);
    assert!(elastic.dissipated().abs() < 1e-15 * elastic.kinetic_start);
}

/// A disc that slides on a plane until it rolls: by then friction has taken a third of its energy, whatever mu is.
#[test]
fn a_disc_slides_until_it_rolls() {
    let floor =
        Body::new("floor", Shape::Plane { point: vector::<Plane>([0.0; 3]), normal: vector::<Plane>([0.0, 1.0, 0.0]) });
    let law = springs(2e5, 0.5, 0.4);
    let mut disc = grain::<Plane>(0, [1e-3, 0.0, 0.0], 5e-4);
    disc.hot.position[1] = 5e-4 - disc.hot.mass * 9.81 / 2e5;
    disc.cold.home = disc.hot.position;
    let disc = velocity::<Plane>(disc, [0.02, 0.0, 0.0], 0.0);
    let mut world = world(&Solo, (law, 2e-6), ([9e-3, 9e-3, 0.0], [true, false, false]), vec![disc], vec![floor]);
    world.settings.grains.field.gravity = vector::<Plane>([0.0, -9.81, 0.0]);
    world.open_accounts(Accounts::GRAINS);
    run(&mut world, 2500);
    let balance = world.balance().unwrap();
    close("slide", &balance, balance.kinetic_start, 1e-6);
    let lost = balance.friction / balance.kinetic_start;
    assert!((lost - 1.0 / 3.0).abs() < 1e-3, "{lost} {balance:?}");
}

/// Grains fall into a trough: gravity has done what the heights say, bodies at rest nothing. Impacts of some ten steps
/// each make the residual, of second order.
#[test]
fn grains_fall_on_a_plane() {
    let wall = |name: &str, point: [f64; 3], normal: [f64; 3]| {
        Body::new(name, Shape::Plane { point: vector::<Solid>(point), normal: vector::<Solid>(normal) })
    };
    let fall = |refinement: usize| {
        let slope = wall("slope", [2e-3, 0.0, 0.0], [0.8, 0.0, 0.6]);
        let bodies =
            vec![wall("floor", [0.0; 3], [0.0, 0.0, 1.0]), slope, wall("side", [6e-3, 0.0, 0.0], [-1.0, 0.0, 0.0])];
        let mut random = Random(3);
        let mut grains = Vec::new();
        for number in 0..24u64 {
            let [x, y, z] = [number % 2, number / 2 % 4, number / 8].map(|at| at as f64 + 0.02 * random.signed());
            let place = [(x + 2.5) * 1.1e-3, (y + 0.5) * 1.1e-3, (z + 0.5) * 1.4e-3];
            grains.push(grain::<Solid>(number, place, MEAN_RADIUS * (1.0 + 0.05 * random.signed())));
        }
        let box_of = ([9e-3, 4.4e-3, 9e-3], [false, true, false]);
        let law = hertz(1e7, 0.003, 0.5);
        let mut world = world(&Solo, (law, 4e-6 / refinement as f64), box_of, grains, bodies);
        world.settings.grains.field.gravity = vector::<Solid>([0.0, 0.0, -9.81]);
        world.settings.grains.field.damping = Damping { local: 0.1, form: DampingForm::Vector, mass: 0.0 };
        // Positions of the last evaluation, to which the account goes.
        let height = |world: &World<'_, Solid>| -> f64 {
            world
                .assembly
                .grains
                .hot
                .iter()
                .map(|hot| hot.mass * (hot.position[2] - hot.velocity[2] * world.settings.grains.dt))
                .sum()
        };
        let before = height(&world);
        world.open_accounts(Accounts::GRAINS);
        run(&mut world, 8000 * refinement);
        let balance = world.balance().unwrap();
        close("fall", &balance, balance.work_gravity, 3e-3 / (refinement * refinement) as f64);
        let fallen = 9.81 * (before - height(&world));
        assert!((balance.work_gravity / fallen - 1.0).abs() < 1e-9, "{fallen:e} {balance:?}");
        assert_eq!((balance.work_bodies, balance.work_cell), (0.0, 0.0));
        assert!(balance.damping > 0.0 && balance.viscous > 0.0);
    };
    fall(1);
    fall(2);
}

/// A cylinder that turns in dense discs, faster and faster.
#[test]
fn a_cylinder_drags_grains() {
    let law = |friction: f64| rolling(4e8, Sliding::Surface, friction);
    let rest = packed::<Plane>(&Solo, [law(0.0), law(0.0)], DISCS);
    let (middle, radius) = (0.5 * DISCS.0 as f64 * DISCS.1, 1.2e-3);
    let centre = vector::<Plane>([middle, middle, 0.0]);
    let (rows, _) = rest.rows();
    let rows = rows.into_iter().filter(|row| (row.hot.position - centre).norm() > radius + 0.6 * row.hot.radius);
    let rows: Vec<_> = rows
        .map(|mut row| {
            row.contacts.clear();
            row
        })
        .collect();
    let shape = Shape::Cylinder { centre, axis: vector::<Plane>([0.0; 3]), radius };
    let mut drum = Body::new("drum", shape);
    let turn = |time: f64, spin: f64| {
        let velocity = vector::<Plane>([1e-3 * spin, 0.0, 0.0]);
        Instant { time, velocity, spin: <Plane as Space>::Spin::new(spin) }
    };
    drum.path = vec![turn(2e-3, 0.0), turn(4e-3, 20.0)];
    let length = 2.0 * middle;
    let mut world = world(&Solo, (law(0.0), 4e-7), ([length, length, 0.0], [true, true, false]), rows, vec![drum]);
    // The others make room first.
    world.settings.grains.field.damping = Damping { local: 0.5, form: DampingForm::Component, mass: 1e3 };
    run(&mut world, 5000);
    world.settings.grains.field.damping = Damping::default();
    world.settings.grains.law = law_of(&law(0.5).into());
    world.open_accounts(Accounts::GRAINS);
    run(&mut world, 5000);
    let balance = world.balance().unwrap();
    close("drum", &balance, balance.work_bodies, 1e-6);
    assert!((world.bodies[0].work / balance.work_bodies - 1.0).abs() < 5e-4, "{:e}", world.bodies[0].work);
    assert!(balance.work_bodies > 0.0);
}

/// Discs between two layers of glued ones, the upper under stress control.
#[test]
fn layers_shear_what_lies_between() {
    let law = cohesive(2e5, 1.0, [0.1, 0.5]);
    let (mut rows, _) = packed::<Plane>(&Solo, [cohesive(2e5, 1.0, [0.0, 0.0]), law], DISCS).rows();
    let length = DISCS.0 as f64 * DISCS.1;
    for row in &mut rows {
        row.contacts.clear();
        // Room above and below, so that no layer meets the other's image.
        row.hot.position[1] += 2e-3;
        row.cold.home = row.hot.position;
        match row.hot.position[1] - 2e-3 {
            y if y < 1e-3 => row.hand_to(Mover::Body(0)),
            y if y > length - 1e-3 => row.hand_to(Mover::Body(1)),
            _ => {}
        }
    }
    let mut upper = Body::new("upper", Shape::Layer);
    let motion = Instant { time: 0.0, velocity: vector::<Plane>([0.1, 0.0, 0.0]), spin: Linear::zero() };
    upper.path = vec![motion];
    let direction = vector::<Plane>([0.0, 1.0, 0.0]);
    upper.servo = Some(Servo { direction, force: 20.0, mass: 2e-3, damping: 10.0, speed_max: 0.1 });
    let bodies = vec![Body::new("lower", Shape::Layer), upper];
    let lengths = [length, length + 4e-3, 0.0];
    let mut world = world(&Solo, (law, 4e-7), (lengths, [true, false, false]), rows, bodies);
    world.open_accounts(Accounts::GRAINS);
    run(&mut world, 5000);
    let balance = world.balance().unwrap();
    close("layers", &balance, balance.work_bodies.abs() + balance.elastic_start, 1e-6);
    let bodies: f64 = world.bodies.iter().map(|body| body.work).sum();
    assert!((bodies / balance.work_bodies - 1.0).abs() < 1e-3, "{bodies:e} {balance:?}");
}

/// The same bits on any number of ranks, and through a checkpoint; and no other motion than without an account.
#[test]
fn ranks_and_interruptions_do_not_show() {
    let start = || {
        let rest = packed::<Plane>(&Solo, [hertz(1e9, 1.0, 0.0), hertz(1e9, 1.0, 0.5)], DISCS);
        (rest.rows().0, rest.assembly.cell)
    };
    let (rows, cell) = start();
    let length = DISCS.0 as f64 * DISCS.1;
    let on = |transport: &dyn Transport, interrupted: bool, kept: bool| {
        let ours = |rows: &[GrainRow<Plane>]| if transport.rank() == 0 { rows.to_vec() } else { Vec::new() };
        let box_of = ([length, length, 0.0], [true, true, false]);
        let mut world = world(transport, (hertz(1e9, 1.0, 0.5), 4e-7), box_of, ours(&rows), Vec::new());
        world.assembly.cell = cell;
        world.settings.grains.drive = shear(300.0);
        if kept {
            world.open_accounts(Accounts::GRAINS);
        }
        run(&mut world, 400);
        if interrupted {
            let entries = world.ledger_entries().unwrap();
            let saved = crate::domain::transfer::gather(transport, world.rows().0).unwrap().unwrap_or_default();
            let (settings, layout) = (world.settings.clone(), world.subdomain.layout.clone());
            let parts = Parts::fresh(saved, Vec::new(), Vec::new(), world.assembly.cell);
            world = World::new(settings, layout, transport, 400, parts).unwrap();
            // As a branch that keeps none.
            world.resume_accounts(Accounts::default(), &entries).unwrap();
            assert!(world.ledger_entries().unwrap().is_empty());
            world.resume_accounts(Accounts::GRAINS, &entries).unwrap();
        }
        run(&mut world, 400);
        let moved = world.energies().unwrap().kinetic_grains.to_bits();
        (moved, kept.then(|| world.balance().unwrap()))
    };
    let (moved, balance) = on(&Solo, false, true);
    assert_eq!(on(&Solo, false, false).0, moved);
    assert!(balance.unwrap().friction > 0.0);
    for (ranks, interrupted) in [(1, true), (2, false), (3, true), (4, true)] {
        let outcomes = scree_partition::transport::threads::run(ranks, |transport| on(&transport, interrupted, true));
        assert!(outcomes.iter().all(|outcome| *outcome == (moved, balance)), "{ranks} ranks: {outcomes:?}");
    }
}

/// Grains alone, with nothing else to do, step in one pass where no account is kept: the same bits all the same.
#[test]
fn an_account_changes_nothing() {
    let positions = |kept: bool| {
        let mut random = Random(5);
        let grains = (0..64u64).map(|number| {
            let [x, y, z] = [number % 4, number / 4 % 4, number / 16].map(|at| (at as f64 + 0.5) * 0.95e-3);
            let speed = [0; 3].map(|_| 0.1 * random.signed());
            velocity::<Solid>(grain::<Solid>(number, [x, y, z], MEAN_RADIUS), speed, 30.0)
        });
        let box_of = ([3.8e-3; 3], [true; 3]);
        let mut world = world(&Solo, (hertz(3e8, 0.1, 0.5), 2e-7), box_of, grains.collect(), Vec::new());
        if kept {
            world.open_accounts(Accounts::GRAINS);
        }
        run(&mut world, 1000);
        world.assembly.grains.hot
    };
    assert_eq!(positions(true), positions(false));
}

/// Whether all grains are kicked before any drifts, as an account wants it, or each as soon as its forces are known: one that a force of
/// its own pushes must wait for it.
#[test]
fn grains_with_a_force_of_their_own_wait_for_it() {
    let end = |is_booked: bool| {
        let mut world = packed::<Plane>(&Solo, [springs(2e5, 1.0, 0.0), springs(2e5, 1.0, 0.5)], DISCS);
        world.assembly.grains.cold[20].script = vector::<Plane>([1.0, -2.0, 0.0]);
        world.assembly.grains.push_as_told();
        if is_booked {
            world.open_accounts(Accounts::GRAINS);
        }
        let before = world.assembly.grains.hot[20].velocity;
        run(&mut world, 100);
        assert!((world.assembly.grains.hot[20].velocity - before).norm() > 1e-3, "it is not pushed");
        world.assembly.grains.hot.clone()
    };
    assert!(end(false) == end(true));
}
