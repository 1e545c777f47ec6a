//! Many contacts at once, under every law in both spaces: what a free cluster keeps, and what no width of registers may
//! change.

use scree::base::ids::GrainId;
use scree::base::lane::Instructions;
use scree::base::numbers::Numbers;
use scree::base::space::{Linear, Plane, Space};
use scree::dem::grains::Hot;
use scree::dem::neighbours::SEGMENT;
use scree::law::contact::Contact;
use scree_partition::Transport;
use scree_partition::transport::threads;

use crate::few::{Claim, Few, GrainWorld, MASS, RADIUS, for_every_law, hot_of, linear, spin, steps, vector};
use crate::worlds::Random;

/// Jittered places on a square or cubic lattice that make neighbours overlap a little here and there.
fn lattice<S: Space>(per_axis: usize, random: &mut Random) -> Vec<[f64; 3]> {
    let spacing = 1.99 * RADIUS;
    let layers = if S::DIMENSION == 2 { 1 } else { per_axis };
    let mut places = Vec::new();
    for z in 0..layers {
        for y in 0..per_axis {
            for x in 0..per_axis {
                let place = [x, y, z].map(|at| (at as f64 + 0.5) * spacing);
                places.push(place.map(|at| at + 0.02 * RADIUS * random.signed()));
            }
        }
    }
    places
}

/// A cluster with sizes, velocities and spins of its own, about the middle of the world.
pub fn cluster<S: Space>(few: &mut Few<S>, per_axis: usize, corner: f64, seed: u64) {
    let mut random = Random(seed);
    for place in lattice::<S>(per_axis, &mut random) {
        let share = 1.0 + 0.02 * random.signed();
        let mut three = |scale: f64| [0; 3].map(|_| scale * random.signed());
        let (velocity, turn) = (three(0.5), three(300.0));
        let hot = &mut few.add(place.map(|at| at + corner), share * RADIUS, share * share * MASS).hot;
        (hot.velocity, hot.spin) = (vector::<S>(velocity), spin::<S>(turn));
    }
}

/// Momentum, and angular momentum about `centre`, each with the sum of the magnitudes that went into it.
fn momenta<S: Space>(world: &GrainWorld<S>, centre: &S::Vector) -> ([S::Vector; 2], [S::Spin; 2]) {
    let (zero, still) = (S::Vector::zero(), S::Spin::zero());
    let (mut linear, mut angular) = ([zero; 2], [still; 2]);
    for hot in &world.assembly.grains.hot {
        let momentum = hot.velocity * hot.mass;
        let orbital = S::moment(&(hot.position - *centre), &momentum);
        let own = hot.spin * S::grain_inertia(hot.mass, hot.radius);
        linear[0] += momentum;
        angular[0] += orbital + own;
        linear[1][0] += momentum.norm();
        angular[1][0] += orbital.norm() + own.norm();
    }
    (linear, angular)
}

struct Keeps;

impl Claim for Keeps {
    fn hold<S: Space>(law: Contact) {
        let mut few = Few::<S>::new(law, 2e-7, 24.0 * RADIUS);
        // Thirty-six discs, twenty-seven spheres.
        let per_axis = if S::DIMENSION == 2 { 6 } else { 3 };
        cluster(&mut few, per_axis, -3.0 * RADIUS, 11);
        let centres = [vector::<S>([0.0; 3]), vector::<S>([-0.02, 0.013, 0.03])];
        let mut world = few.world();
        let before = centres.map(|centre| momenta(&world, &centre));
        let spins: Vec<S::Spin> = (0..20).map(|id| hot_of(&world, id).spin).collect();
        let touching = world.assembly.contacts.count(world.law(), &world.assembly.grains);
        assert!(touching > 15, "{touching} contacts");
        for step in 0..300 {
            steps(&mut world, 1);
            for (centre, (linear_before, angular_before)) in centres.iter().zip(&before) {
                let (linear, angular) = momenta(&world, centre);
                let change = (linear[0] - linear_before[0]).norm() / linear_before[1][0];
                let turned = (angular[0] - angular_before[0]).norm() / angular_before[1][0];
                assert!(change < 1e-13, "step {step}: {change:e} of all momenta under {law:?} in {}", S::NAME);
                assert!(turned < 1e-13, "step {step}: {turned:e} of all turns under {law:?} in {}", S::NAME);
            }
        }
        let turned = spins.iter().enumerate().map(|(id, spin)| (hot_of(&world, id as u64).spin - *spin).norm());
        let turned: f64 = turned.sum::<f64>() / spins.len() as f64;
        assert!(turned > 10.0, "friction did nothing: {turned} rad/s under {law:?} in {}", S::NAME);
    }
}

/// Forces are equal and opposite, and the arms of their torques add up to the distance of the centres: nothing is made or
/// lost, about whatever point.
#[test]
fn a_free_cluster_keeps_momentum_and_angular_momentum() {
    for_every_law::<Keeps>();
}

/// Positions, velocities and spins as bits, by id.
fn bits<S: Space>(world: &GrainWorld<S>) -> Vec<u64> {
    let mut rows: Vec<(u64, Hot<S>)> = world
        .assembly
        .grains
        .cold
        .iter()
        .zip(&world.assembly.grains.hot)
        .map(|(cold, hot)| (cold.id.0, *hot))
        .collect();
    rows.sort_unstable_by_key(|(id, _)| *id);
    rows.iter().flat_map(|(_, hot)| hot.numbers().iter().map(|word| word.to_bits())).collect()
}

struct SameBits;

impl Claim for SameBits {
    fn hold<S: Space>(law: Contact) {
        // The last eight is not full.
        let per_axis = if S::DIMENSION == 2 { 9 } else { 5 };
        let edge = 1.99 * RADIUS * per_axis as f64;
        // Periodic and sheared, so that pairs in one image and across images have a part in it.
        let mut few = Few::<S>::periodic(law, 2e-7, [0.0; 3], [edge; 3]);
        few.settings.grains.skin = 0.05 * RADIUS;
        few.settings.grains.drive.gradient[S::DIMENSION] = 50.0;
        cluster(&mut few, per_axis, 0.0, 23);
        let run = |instructions: Instructions| {
            let mut world = few.clone().world();
            world.assembly.contacts.use_instructions(instructions);
            steps(&mut world, 200);
            assert!(world.rebuilds > 2 && world.assembly.contacts.count(world.law(), &world.assembly.grains) > 30);
            bits(&world)
        };
        let found: Vec<_> = Instructions::here().map(|instructions| (instructions, run(instructions))).collect();
        for (wider, bits) in &found[1..] {
            assert!(*bits == found[0].1, "{wider:?} gives other bits under {law:?} in {}", S::NAME);
        }
    }
}

/// Invariant 2: one semantics of lanes for every width.
#[test]
fn every_width_of_registers_gives_the_same_bits() {
    println!("instructions: {:?}", Instructions::here().collect::<Vec<_>>());
    for_every_law::<SameBits>();
}

struct SameSegments;

impl Claim for SameSegments {
    fn hold<S: Space>(law: Contact) {
        // Several segments, the last of them not full; a rigid box that does not deform, so that grains move on at once.
        let per_axis = if S::DIMENSION == 2 { 52 } else { 14 };
        let edge = 1.99 * RADIUS * per_axis as f64;
        let mut few = Few::<S>::periodic(law, 2e-7, [0.0; 3], [edge; 3]);
        few.settings.grains.skin = 0.05 * RADIUS;
        cluster(&mut few, per_axis, 0.0, 29);
        let grains = few.grains.len();
        assert!(grains > 2 * SEGMENT && !grains.is_multiple_of(SEGMENT));
        let run = |ranks: usize, threads: usize, kept: bool| {
            let ended = threads::run(ranks, |transport| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut few = few.clone();
                few.grains.retain(|row| row.cold.id.0 as usize % ranks == transport.rank());
                pool.install(|| {
                    let mut world = few.world_on(&transport);
                    for _ in 0..60 {
                        world.assembly.forces_wanted = kept;
                        world.advance().unwrap();
                    }
                    assert!(world.rebuilds > 0);
                    let owned = world.assembly.grains.owned;
                    let rows = world.assembly.grains.cold[..owned].iter().zip(&world.assembly.grains.hot);
                    let bits = |hot: &Hot<S>| hot.numbers().iter().map(|word| word.to_bits()).collect();
                    rows.map(|(cold, hot)| (cold.id, bits(hot))).collect::<Vec<(GrainId, Vec<u64>)>>()
                })
            });
            let mut rows: Vec<(GrainId, Vec<u64>)> = ended.into_iter().flatten().collect();
            rows.sort_unstable();
            assert_eq!(rows.len(), grains);
            rows
        };
        let one = run(1, 1, false);
        for (ranks, threads, kept) in [(1, 1, true), (1, 3, false), (1, 2, true), (2, 1, false), (3, 2, true)] {
            let other = run(ranks, threads, kept);
            assert!(one == other, "{ranks} ranks of {threads} threads, forces kept {kept}: other bits under {law:?}");
        }
    }
}

/// What a thread takes at a time, which rank holds it and whether forces are looked at afterwards shows nowhere.
#[test]
fn segments_ranks_and_threads_give_the_same_bits() {
    for_every_law::<SameSegments>();
}

/// A row of the series looks at the forces of one step in many: arrays laid for that stay, in place of being laid anew for
/// every row and put away after it.
#[test]
fn looking_at_forces_now_and_then_lays_no_arrays() {
    let per_axis = 40;
    let mut few = Few::<Plane>::periodic(linear(), 2e-7, [0.0; 3], [1.99 * RADIUS * per_axis as f64; 3]);
    cluster(&mut few, per_axis, 0.0, 31);
    // On one thread there is one such room.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut world = few.world();
        let mut bytes_after = |look: bool| {
            world.assembly.forces_wanted = look;
            world.advance().unwrap();
            assert_eq!(world.rebuilds, 0);
            world.assembly.contacts.bytes()
        };
        let (before, looked) = (bytes_after(false), bytes_after(true));
        assert!(looked > before, "room for one segment after the other: {before} bytes, for all: {looked}");
        assert_eq!([false, true, false].map(bytes_after), [looked; 3]);
    });
}
