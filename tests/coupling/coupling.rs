//! Grains and points on the same nodes: momentum is kept, velocities are shared, and a rigid motion stays one.

use scree::base::ids::PointId;
use scree::base::space::{Plane, Space};
use scree::base::symmetric::Symmetric;
use scree::dem::grains::PenaltySpring;
use scree::domain::accounts::energy::Energies;
use scree::domain::accounts::ledger::Accounts;
use scree::mpm::nodes;
use scree::mpm::penalty::Coupling;
use scree::mpm::share::dyad;
use scree::mpm::stress::StressModel;
use scree::mpm::tile::{Gathered, GrainNode};
use scree_partition::transport::threads;
use scree_partition::{Solo, Transport};

use crate::worlds::{
    Grain, PlanarPoint, PlanarWorld, Random, Vector, contact, exchanging, grain, material, open_world, settings,
};

const CELL: f64 = 3e-3;
const WIDTH: f64 = 16.0 * CELL;
const DEPTH: f64 = 0.01;
const DENSITY: f64 = 2530.0;
pub const DT: f64 = 4e-7;

/// Columns of grains a millimetre apart; radii beyond half of that make them touch.
fn grain_rows(rows: std::ops::Range<i32>, radius: f64, weight: impl Fn(f64) -> f64) -> Vec<Grain> {
    let mass = DENSITY * scree::base::math::PI * radius * radius * DEPTH;
    let mut grains = Vec::new();
    for row in rows {
        for column in 0..48 {
            let place = [(f64::from(column) + 0.5) * 1e-3, (f64::from(row) + 0.5) * 1e-3];
            let mut grain = grain(grains.len() as u64, place, radius, mass);
            grain.hot.weight = weight(place[1]);
            grains.push(grain);
        }
    }
    grains
}

/// Points on a grid of half cells under an isotropic pressure.
fn point_rows(rows: std::ops::Range<i32>, pressure: f64, weight: impl Fn(f64) -> f64) -> Vec<PlanarPoint> {
    let law = material();
    let volume = 0.25 * CELL * CELL * DEPTH;
    let mut points = Vec::new();
    for row in rows {
        for column in 0..32 {
            let place = Vector::new((f64::from(column) + 0.5) * 0.5 * CELL, (f64::from(row) + 0.5) * 0.5 * CELL);
            let weight = weight(place[1]);
            if weight > 0.0 {
                let id = PointId(points.len() as u64);
                let mut point = PlanarPoint::resting(id, place, 0.85 * DENSITY * volume, volume);
                point.hot.weight = weight;
                point.hot.memory = StressModel::<Plane>::start(&law, &(Plane::identity() * -pressure), 0.85);
                point.hot.stress = Symmetric::of(&StressModel::<Plane>::stress(&law, &point.hot.memory));
                points.push(point);
            }
        }
    }
    points
}

fn coupled_world(transport: &dyn Transport, grains: Vec<Grain>, points: Vec<PlanarPoint>) -> PlanarWorld<'_> {
    open_world(transport, CELL, settings(DT, contact(3.5)), grains, points)
}

/// Sum of the magnitudes of all momenta, N s: what round-off is measured against.
fn momentum_scale(world: &PlanarWorld) -> f64 {
    let grains: f64 = world.assembly.grains.hot.iter().map(|hot| hot.weight * hot.mass * hot.velocity.norm()).sum();
    let points: f64 =
        world.continuum.points.rows().map(|point| point.hot.weight * point.hot.mass * point.hot.velocity.norm()).sum();
    grains + points
}

/// Momentum of the grains alone along x, N s.
fn grain_momentum(world: &PlanarWorld) -> f64 {
    world.assembly.grains.hot.iter().map(|hot| hot.weight * hot.mass * hot.velocity[0]).sum()
}

/// A slab of continuum over a layer of touching grains, both with weight 1/2 where they overlap, everything moving at
/// random and nothing pulling from outside.
pub fn shaken(transport: &dyn Transport) -> PlanarWorld<'_> {
    let mut random = Random(1);
    let half = |y: f64| if y < 0.0 { 0.5 } else { 1.0 };
    let mut points = point_rows(-5..4, 300e3, half);
    let mut grains = grain_rows(-12..0, 0.501e-3, |y| if y > -7.5e-3 { 0.5 } else { 1.0 });
    for point in &mut points {
        point.hot.velocity = Vector::new(0.2 * random.signed(), 0.2 * random.signed());
    }
    for grain in &mut grains {
        grain.hot.velocity = Vector::new(0.5 + 0.3 * random.signed(), 0.3 * random.signed());
        grain.hot.spin[0] = 200.0 * random.signed();
    }
    match transport.rank() {
        0 => coupled_world(transport, grains, points),
        _ => coupled_world(transport, Vec::new(), Vec::new()),
    }
}

#[test]
fn a_step_keeps_the_momentum_of_grains_and_points() {
    let mut world = shaken(&Solo);
    let before = world.holdings().unwrap();
    let grains_before = grain_momentum(&world);
    let mut worst = 0.0f64;
    for step in 0..200 {
        let scale = momentum_scale(&world);
        let one = world.holdings().unwrap();
        world.advance().unwrap();
        if step == 100 {
            world.rebuild().unwrap();
        }
        let now = world.holdings().unwrap();
        assert_eq!(now.mass, before.mass, "step {step}");
        for axis in 0..2 {
            let change = (now.momentum[axis] - one.momentum[axis]).abs() / scale;
            worst = worst.max(change);
            assert!(change < 1e-14, "step {step}, axis {axis}: {change:.1e} of all momenta");
            let change = (now.momentum[axis] - before.momentum[axis]).abs() / scale;
            assert!(change < 1e-13, "after {step} steps, axis {axis}: {change:.1e} of all momenta");
        }
    }
    println!("momentum per step: {worst:.1e}");
    // The layers started half a metre per second apart, so a good part must have gone over.
    let given = 1.0 - grain_momentum(&world) / grains_before;
    assert!(given > 0.05, "the grains gave only {given} of their momentum to the points");
}

/// Of grains that share nodes with a continuum everything is told apart: what nodes and penalty springs give them, what they store, and what
/// their contacts lose. Also with several of their steps in one of the continuum, with steps of their own in between, and across rebuilds.
#[test]
fn the_account_of_grains_closes_with_the_work_of_nodes() {
    for (grain_steps, exchange) in [(1, 1), (4, 1), (4, 2), (4, 4)] {
        let mut world = shaken(&Solo);
        world.settings.grain_steps = grain_steps;
        world.settings.grid.penalty = exchanging(exchange, DT);
        world.open_accounts(Accounts::GRAINS);
        for step in 0..600 / grain_steps {
            world.advance().unwrap();
            if step == 100 {
                world.rebuild().unwrap();
            }
        }
        let balance = world.balance().unwrap();
        let turnover = balance.kinetic_start + balance.elastic_start;
        let unexplained = (balance.imbalance() + balance.made) / turnover;
        println!(
            "m = {grain_steps}, exchange after {exchange}: nodes have done {:.3} of {turnover:.2e} J, residual {:.1e}, unexplained {unexplained:.1e}",
            balance.work_nodes / turnover,
            balance.residual()
        );
        assert!(unexplained.abs() < 1e-11, "{balance:?}");
        assert!(balance.residual().abs() < 1e-2, "{balance:?}");
        assert!(balance.work_nodes.abs() > 0.05 * turnover && balance.dissipated() > 0.05 * turnover, "{balance:?}");
    }
}

/// What grains take from the nodes that they share with points, points give: all but what is lost where two velocities become one. With what
/// points store and dissipate the rest of it is the scheme's own loss, which the same slab alone has as well.
#[test]
fn the_account_of_points_has_the_work_of_grains() {
    let mut world = shaken(&Solo);
    let all = |of: Energies| of.kinetic_grains + of.elastic_grains + of.kinetic_points + of.elastic_points;
    // Velocities that differ from place to place become one within a few steps, in which half a step is much.
    for _ in 0..100 {
        world.advance().unwrap();
    }
    let before = all(world.energies().unwrap());
    world.open_accounts(Accounts { grains: true, points: true });
    for step in 0..500 {
        world.assembly.forces_wanted = step == 499;
        world.advance().unwrap();
    }
    let (grains, points) = (world.balance().unwrap(), world.point_balance().unwrap().unwrap());
    let shared = grains.work_nodes + points.work_grains;
    println!(
        "grains {:.3e} J, points {:.3e} J, lost where they meet {shared:.3e} J",
        grains.work_nodes, points.work_grains
    );
    println!("points: stored {:.3e}, dissipated {:.3e}, lost {:.3e} J", points.stored, points.dissipated, points.lost);
    assert!(shared < 0.0, "sharing has made {shared} J");
    // Nothing else works on anything: what there is less is what both accounts and the meeting have lost, but for the half step
    // between the account and the state.
    let after = all(world.energies().unwrap());
    let lost = grains.dissipated() + points.dissipated + points.lost - shared;
    println!("{before:.4e} J before, {after:.4e} after, {lost:.4e} lost");
    assert!((before - after - lost).abs() < 1e-2 * before, "{before} J before, {after} after, {lost} lost");
    assert!(lost > 0.05 * before, "{lost} J of {before}");
    assert!(points.lost > 0.0, "the scheme makes {} J", points.lost);
}

/// At every node of a real step that both sides reach: one velocity, and the momentum of both before. What penalty springs have given
/// grains, the continuum has paid.
#[test]
fn both_sides_leave_a_node_with_one_velocity() {
    let mut world = shaken(&Solo);
    for _ in 0..5 {
        world.advance().unwrap();
    }
    let (mut shared, mut tied, mut apart) = (0, 0, 0.0f64);
    let sums = world.continuum.tiles.sums.iter().zip(world.continuum.tiles.grain_sums.iter());
    for (node, (sum, of_grains)) in world.subdomain.nodes.mosaic.owned.iter().zip(sums) {
        let velocity = world.continuum.tiles.advanced[node.row as usize].velocity();
        let change = world.continuum.tiles.grain_changes[node.row as usize];
        if sum.mass() == 0.0 || of_grains.mass() == 0.0 {
            let returned = change.velocity() * of_grains.mass() + of_grains.given();
            assert!(returned.norm() <= 1e-15 * of_grains.given().norm() && change.share().all == 0.0, "{of_grains:?}");
            continue;
        }
        shared += 1;
        tied += usize::from(of_grains.given() != Vector::zeros());
        let grains = of_grains.momentum() * (1.0 / of_grains.mass());
        let points = (sum.momentum() + sum.force() * DT) * (1.0 / sum.mass());
        apart = apart.max((grains - points).norm());
        let scale = grains.norm() + points.norm();
        assert!((grains + change.velocity() - velocity).norm() < 1e-14 * scale, "{sum:?}");
        let wanted = of_grains.momentum() - of_grains.given() + sum.momentum() + sum.force() * DT;
        let mass = sum.mass() + of_grains.mass();
        assert!((velocity * mass - wanted).norm() < 1e-14 * scale * mass, "{sum:?}");
    }
    assert!(shared > 40 && tied > 40, "{shared} nodes are shared, {tied} tied");
    assert!(apart > 0.1, "velocities at most {apart} m/s apart");
}

/// Over many orders of magnitude of the two masses, the lighter side taking the heavier one's velocity; where a body holds
/// the node, both take the body's. What penalty springs give changes none of it.
#[test]
fn sharing_is_exact_for_any_masses() {
    let mut random = Random(2);
    for round in 0..2000 {
        let magnitude = |random: &mut Random| scree::base::math::exp(20.0 * random.signed());
        let (mass, grain_mass) = (1e-5 * magnitude(&mut random), 1e-5 * magnitude(&mut random));
        let mut velocity = || Vector::new(random.signed(), random.signed());
        let (points, grains, push, body, spring) = (velocity(), velocity(), velocity(), velocity(), velocity());
        let force = push * (mass / DT);
        let momentum = points * mass;
        let node: Gathered<Plane> = Gathered::of([mass, momentum[0], momentum[1], force[0], force[1], 0.0, 0.0, 0.0]);
        let given = spring * grain_mass;
        let of_grains: GrainNode<Plane> = GrainNode::new(grain_mass, &(grains * grain_mass), &given);
        let shared = nodes::step(&node, &of_grains, &Vector::zeros(), DT, |free| free);
        let wanted = (momentum + force * DT + of_grains.momentum() - given) * (1.0 / (mass + grain_mass));
        assert!((shared.velocity - wanted).norm() < 1e-14, "round {round}: {node:?}");
        assert!((grains + shared.grains.velocity() - wanted).norm() < 1e-14, "round {round}: {node:?}");
        let share = mass / (mass + grain_mass);
        assert_eq!((shared.grains.share().all, shared.grains.shared()), (share, shared.velocity * share));
        let held = nodes::step(&node, &of_grains, &Vector::zeros(), DT, |_| body);
        assert_eq!(held.velocity, body);
        assert!((grains + held.grains.velocity() - body).norm() < 1e-15, "round {round}: {node:?}");
    }
}

/// A grain that is pulled across a membrane and along it at once: a penalty spring holds it across, and winds up by nothing along it.
/// Beside points it is held both ways.
#[test]
fn a_tie_to_a_membrane_does_not_wind_up_along_it() {
    let (along, across) = (Vector::new(0.6, 0.8), Vector::new(-0.8, 0.6));
    let pull = (along * 1e3 + across * 1e4) * DT;
    // k = 0.1 for a grain of a kilogram.
    let penalty = Coupling::DEFAULT.in_steps(0.1 / (DT * DT), DT);
    let after = |of_membrane: f64| {
        let mut node: Gathered<Plane> = Gathered::zero();
        node.bring(3.0, &Vector::zeros(), &Vector::zeros());
        node.bring_along(&dyad::<Plane>(of_membrane, &along), 1.0);
        let (mut spring, mut velocity, mut way) = (PenaltySpring::<Plane>::loose(), Vector::zeros(), Vector::zeros());
        for _ in 0..2000 {
            velocity += pull + spring.given;
            let still = GrainNode::new(1.0, &Vector::zeros(), &Vector::zeros());
            let change = nodes::step(&node, &still, &Vector::zeros(), DT, |_| Vector::zeros()).grains;
            let slip = change.share().of(&velocity) - change.shared();
            spring = penalty.after(&spring, 1.0, (&slip, &Vector::zeros()), &change.share());
            way += velocity * DT;
        }
        (spring, velocity, way)
    };
    let free = pull * 2000.0;
    let (spring, velocity, way) = after(3.0);
    assert!(spring.spring.dot(&along).abs() < 1e-12 * pull.norm(), "{spring:?}");
    assert!((velocity.dot(&along) / free.dot(&along) - 1.0).abs() < 1e-12, "{velocity}");
    assert!(velocity.dot(&across).abs() < 1e-9 * free.norm() && way.dot(&across).abs() < 20.0 * pull.norm() * DT);
    let (_, velocity, way) = after(0.0);
    assert!(velocity.norm() < 1e-9 * free.norm() && way.norm() < 20.0 * pull.norm() * DT, "{velocity}");
}

/// Grains that hang on a continuum which is pushed up as hard as both are pulled down, in a rim of one cell, every second
/// of them twice as heavy as it looks: what pulls them and the continuum apart is the same in every step, and none of them
/// may slip by a little in each.
#[test]
fn what_pulls_grains_off_the_continuum_does_not_make_them_slip() {
    const PULL: f64 = 1e4;
    let half = |_: f64| 0.5;
    // A cell high, no two grains in touch.
    let (points, mut grains) = (point_rows(0..2, 0.0, half), grain_rows(0..3, 0.49e-3, half));
    grains.iter_mut().step_by(2).for_each(|grain| grain.hot.mass *= 2.0);
    let of_grains: f64 = grains.iter().map(|grain| grain.hot.weight * grain.hot.mass).sum();
    let of_points: f64 = points.iter().map(|point| point.hot.weight * point.hot.mass).sum();
    let mut world = coupled_world(&Solo, grains, points);
    world.settings.grains.field.gravity = Vector::new(0.0, -PULL);
    let each = Vector::new(0.0, PULL * (of_grains + of_points) / world.continuum.points.len() as f64);
    world.continuum.points.loaded = (0..world.continuum.points.len() as u32).map(|row| (row, each)).collect();
    let height = |world: &PlanarWorld| world.continuum.points.rows().map(|point| point.hot.position[1]).sum::<f64>();
    let (count, before) = (world.continuum.points.len() as f64, height(&world));
    let steps = 2000;
    for _ in 0..steps {
        world.advance().unwrap();
    }
    let points_rose = (height(&world) - before) / count;
    let slips = world.assembly.grains.hot.iter().zip(&world.assembly.grains.cold).map(|(hot, cold)| {
        let rose = hot.position[1] - cold.origin[1];
        (rose - points_rose).abs()
    });
    let slip = slips.fold(0.0, f64::max);
    println!("slip: {slip:.1e} m");
    // By sharing alone, some of `PULL dt` in every step.
    let free = PULL * DT * DT * f64::from(steps);
    assert!(slip < 0.02 * free, "{slip:e} m, where sharing alone slips by some {free:e}");
}

/// A grain of the overlap that comes among grains alone, with a spring that still holds it, is let go, and momentum is kept all the same.
#[test]
fn a_tie_slackens_among_grains_alone() {
    let mut grains = grain_rows(-9..9, 0.49e-3, |_| 0.5);
    for (number, grain) in grains.iter_mut().enumerate() {
        let push = Vector::new(1e-3 * (number % 7) as f64, 2e-3);
        grain.spring = PenaltySpring { spring: push, given: push };
    }
    let points = point_rows(-7..-5, 0.0, |_| 0.5);
    let mut world = coupled_world(&Solo, grains, points);
    let before = world.holdings().unwrap().momentum;
    for _ in 0..20 {
        world.advance().unwrap();
    }
    let (now, scale) = (world.holdings().unwrap().momentum, momentum_scale(&world));
    assert!((0..2).all(|axis| (now[axis] - before[axis]).abs() < 1e-13 * scale), "{now:?} from {before:?} of {scale}");
    let far =
        world.assembly.grains.hot.iter().zip(&world.assembly.grains.springs).filter(|(hot, _)| hot.position[1] > 0.0);
    assert!(far.clone().count() > 400 && far.clone().all(|(_, spring)| *spring == PenaltySpring::loose()));
    let near = world
        .assembly
        .grains
        .hot
        .iter()
        .zip(&world.assembly.grains.springs)
        .filter(|(hot, _)| hot.position[1] < -7.6e-3);
    assert!(near.clone().count() > 40 && near.clone().all(|(_, spring)| *spring != PenaltySpring::loose()));
}

/// Grains of the core have no continuum in their place: nodes that they reach neither brake them nor hold them, and no spring is left of
/// what they may have had. Those near a membrane take part whatever they weigh, see `coupled`.
#[test]
fn grains_of_the_core_do_not_take_part() {
    let weight = |y: f64| if y < -4e-3 { 0.5 } else { 1.0 };
    let mut grains = grain_rows(-9..9, 0.49e-3, weight);
    for grain in &mut grains {
        grain.hot.velocity = Vector::new(0.0, 0.3);
        grain.spring = PenaltySpring { spring: Vector::new(0.1, 0.1), given: Vector::zeros() };
    }
    let points = point_rows(-7..-3, 0.0, |_| 0.5);
    let mut world = coupled_world(&Solo, grains, points);
    assert_eq!(world.subdomain.participants.count(), 48 * 5);
    world.advance().unwrap();
    for row in world.rows().0 {
        let is_core = row.hot.weight == 1.0;
        assert_eq!(row.hot.velocity == Vector::new(0.0, 0.3), is_core, "{:?}", row.hot);
        assert_eq!(row.spring == PenaltySpring::loose(), is_core, "{:?}", row.spring);
    }
}

/// Continuum above and below a layer of grains with rims of one weight half on either side, all of one velocity: nothing
/// may bend, also across the period and through rebuilds.
#[test]
fn a_rigid_translation_stays_rigid() {
    let rim = |y: f64| y.abs() > 6e-3;
    // No points within, both in the rims, and where the grains end the continuum is whole again.
    let share = |y: f64| if y.abs() > 9e-3 { 1.0 } else { 0.5 };
    let mut points = point_rows(-7..7, 0.0, |y| if rim(y) { share(y) } else { 0.0 });
    let mut grains = grain_rows(-9..9, 0.49e-3, |y| if rim(y) { 0.5 } else { 1.0 });
    let velocity = Vector::new(7.0, 0.8);
    grains.iter_mut().for_each(|grain| grain.hot.velocity = velocity);
    points.iter_mut().for_each(|point| point.hot.velocity = velocity);
    let mut world = coupled_world(&Solo, grains, points);
    let steps = 5000;
    for _ in 0..steps {
        world.advance().unwrap();
    }
    assert!(
        world.rebuilds > 10 && world.continuum.points.rows().any(|point| point.cold.image == [1, 0, 0]),
        "it should cross the period"
    );
    let way = velocity * (f64::from(steps) * DT);
    let period = Vector::new(WIDTH, 0.0);
    let mut worst = [0.0f64; 3];
    for (hot, cold) in world.assembly.grains.hot.iter().zip(&world.assembly.grains.cold) {
        let moved = hot.position - cold.origin + period * f64::from(cold.image[0]);
        worst[0] = worst[0].max((hot.velocity - velocity).norm() / velocity.norm());
        worst[1] = worst[1].max((moved - way).norm() / way.norm());
        assert_eq!(hot.spin[0], 0.0);
    }
    for point in world.continuum.points.rows() {
        let moved = point.hot.position - point.cold.origin + period * f64::from(point.cold.image[0]);
        worst[0] = worst[0].max((point.hot.velocity - velocity).norm() / velocity.norm());
        worst[1] = worst[1].max((moved - way).norm() / way.norm());
        worst[2] = worst[2].max(point.hot.kirchhoff().norm() / material().bulk_modulus);
    }
    println!("rigid translation: velocity {:.1e}, way {:.1e}, strain {:.1e}", worst[0], worst[1], worst[2]);
    assert!(worst[0] < 1e-11 && worst[1] < 1e-11 && worst[2] < 1e-11, "velocity, way, strain: {worst:?}");
}

/// Grains, points and momenta of the whole world, and the grains of each rank.
fn tally(world: &mut PlanarWorld) -> ([i64; 2], [f64; 2], Vec<i64>) {
    let ranks = world.transport.size();
    let mut counts = vec![0; 2 + ranks];
    counts[0] = world.assembly.grains.owned as i64;
    counts[1] = world.continuum.points.len() as i64;
    counts[2 + world.transport.rank()] = world.assembly.grains.owned as i64;
    world.transport.sum(&mut counts);
    let momentum = world.holdings().unwrap().momentum;
    ([counts[0], counts[1]], [momentum[0], momentum[1]], counts[2..].to_vec())
}

/// A zone that lies across the border of two ranks, then all on the one, then all on the other: nothing is lost on the way,
/// the momentum is the same number, and what follows is what one rank makes of it.
#[test]
fn a_zone_moves_from_rank_to_rank_with_all_that_is_in_it() {
    const LEG: u64 = 20;
    let alone = {
        let mut world = shaken(&Solo);
        (0..3 * LEG).for_each(|_| world.advance().unwrap());
        tally(&mut world)
    };
    let moved = threads::run(2, |rank| {
        let mut world = shaken(&rank);
        let blocks = world.subdomain.layout.block_count();
        // A rank whose first or last block outweighs all others has that block alone.
        let heavy =
            |heavy: usize| (0..blocks).map(|block| if block == heavy { 1 << 40 } else { 1 }).collect::<Vec<u64>>();
        let mut seen = Vec::new();
        for weights in [vec![1; blocks], heavy(0), heavy(blocks - 1)] {
            let before = tally(&mut world);
            world.deal_by(&weights).unwrap();
            let after = tally(&mut world);
            assert_eq!((before.0, before.1), (after.0, after.1), "a deal changed counts or momentum");
            seen.push(after.2);
            (0..LEG).for_each(|_| world.advance().unwrap());
        }
        (seen, tally(&mut world))
    });
    let (seen, end) = &moved[0];
    let all = alone.0[0];
    assert!(seen[0].iter().all(|grains| *grains > all / 4), "the zone does not cross the border: {seen:?}");
    assert_eq!(seen[1..], [vec![0, all], vec![all, 0]], "the zone did not move whole");
    assert_eq!((end.0, end.1), (alone.0, alone.1), "two ranks end otherwise than one");
}
