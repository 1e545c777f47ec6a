//! Two grains, or one and a wall, in collisions and pulled apart: closed forms of every law.

use scree::body::{Body, Shape};
use scree::law::contact::{ContactLaw, ElasticRolling, HertzMindlin, LinearCohesive, LinearSpringDashpot};
use scree::math;
use scree::numbers::Numbers;
use scree::scenario;
use scree::space::{Linear, Plane, Solid, Space};

use crate::few::{
    Few, GrainWorld, MASS, RADIUS, cohesive, elastic, hertz, hot_of, linear, load_on, row_of, spin, steps, vector,
};

/// Speed at which grains close, m/s.
const SPEED: f64 = 0.1;

/// What was seen of a head-on collision.
struct Seen {
    /// Speed after over speed before.
    restitution: f64,
    /// Steps in touch, and the largest overlap, m.
    touching: f64,
    overlap: f64,
}

/// Two grains closing along a diagonal of the space, `duration` being what the contact is expected to last, s.
fn head_on<S: Space, C: ContactLaw<S>>(
    law: C,
    [radii, masses]: [[f64; 2]; 2],
    duration: f64,
    steps_wanted: u32,
) -> Seen {
    let dt = duration / f64::from(steps_wanted);
    let mut few = Few::<S, C>::new(law, dt, 24.0 * RADIUS);
    let along = vector::<S>([2.0, -1.0, 2.0]);
    let along = along * (1.0 / along.norm());
    let gap = 2.7 * SPEED * dt;
    for (radius, mass) in radii.into_iter().zip(masses) {
        few.add([0.0; 3], radius, mass);
    }
    let share = masses[1] / (masses[0] + masses[1]);
    few.grains[0].hot.position = along * (0.5 * (radii[0] + radii[1] + gap));
    few.grains[1].hot.position = -few.grains[0].hot.position;
    few.grains[0].hot.velocity = along * (-SPEED * share);
    few.grains[1].hot.velocity = along * (SPEED * (1.0 - share));
    for row in &mut few.grains {
        (row.cold.home, row.cold.origin) = (row.hot.position, row.hot.position);
    }
    let mut world = few.world();
    let mut seen = Seen { restitution: 0.0, touching: 0.0, overlap: 0.0 };
    let mut last = -gap;
    for _ in 0..steps_wanted + steps_wanted / 8 {
        steps(&mut world, 1);
        let [a, b] = [0, 1].map(|id| hot_of(&world, id));
        let overlap = radii[0] + radii[1] - (a.position - b.position).norm();
        // Shares of the steps in which the grains met and parted count by the overlap's own line.
        seen.touching += match (last > 0.0, overlap > 0.0) {
            (false, false) => 0.0,
            (true, true) => 1.0,
            (was, _) => {
                if was {
                    last / (last - overlap)
                } else {
                    overlap / (overlap - last)
                }
            }
        };
        seen.overlap = seen.overlap.max(overlap);
        seen.restitution = (a.velocity - b.velocity).dot(&along) / SPEED;
        last = overlap;
    }
    assert!(last < 0.0, "they still touch");
    seen
}

/// `e = exp(-b t)`, `t = pi/w`, `b = gamma/(2 m)`, `w^2 = k/m - b^2` with the reduced mass m: discs and spheres alike.
fn restitution_follows_the_damping<S: Space>() {
    let reduced = 0.5 * MASS;
    for damping in [0.0, 0.5, 2.0, 3.5, 4.96, 7.0] {
        let mut law = linear();
        law.constants.damping_normal = damping;
        let decay = damping / (2.0 * reduced);
        let duration = math::PI / (law.constants.stiffness_normal / reduced - decay * decay).sqrt();
        let seen = head_on::<S, _>(law, [[RADIUS; 2], [MASS; 2]], duration, 4000);
        let wanted = math::exp(-decay * duration);
        println!("restitution {wanted:.3} in the {}: off by {:.1e}", S::NAME, seen.restitution - wanted);
        assert!((seen.restitution - wanted).abs() < 5e-4, "damping {damping}: {} for {wanted}", seen.restitution);
        assert!((seen.touching / 4000.0 - 1.0).abs() < 2e-3, "damping {damping}: {} steps", seen.touching);
    }
}

#[test]
fn restitution_of_discs_and_spheres_follows_the_damping() {
    restitution_follows_the_damping::<Plane>();
    restitution_follows_the_damping::<Solid>();
}

/// `x^(2/5)`.
fn two_fifths(x: f64) -> f64 {
    math::exp(0.4 * math::ln(x))
}

/// `2 integral of dx/sqrt(1 - x^(5/2))` from 0 to 1, `= 2 sqrt(pi) Gamma(7/5)/Gamma(9/10)`.
const HERTZ_TIME: f64 = 2.943_275_1;

/// Stiffness of `F = k d^(3/2)` by eq. 53 and 55: `k = 2/3 sqrt(2) G sqrt(R_e)/(1 - nu)`.
fn hertz_stiffness(law: &HertzMindlin, radius_effective: f64) -> f64 {
    let law = &law.constants;
    2.0 / 3.0 * std::f64::consts::SQRT_2 * law.shear_modulus * radius_effective.sqrt() / (1.0 - law.poisson_ratio)
}

/// From `m v^2/2 = 2/5 k d^(5/2)` the deepest overlap is `d = (5/4 m v^2/k)^(2/5)`, and the contact lasts 2.9433 d/v.
#[test]
fn hertz_contacts_last_and_press_as_they_should() {
    let law = HertzMindlin { constants: scenario::HertzMindlin { damping_normal: 0.0, ..hertz().constants } };
    for [radii, masses] in [[[RADIUS; 2], [MASS; 2]], [[RADIUS, 0.6 * RADIUS], [MASS, 0.216 * MASS]]] {
        let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
        let stiffness = hertz_stiffness(&law, 2.0 * radii[0] * radii[1] / (radii[0] + radii[1]));
        let overlap = two_fifths(1.25 * reduced * SPEED * SPEED / stiffness);
        let duration = HERTZ_TIME * overlap / SPEED;
        let seen = head_on::<Solid, _>(law, [radii, masses], duration, 4000);
        let off = [seen.overlap / overlap - 1.0, seen.touching / 4000.0 - 1.0, seen.restitution - 1.0];
        println!("Hertz: overlap, duration, restitution off by {off:?}");
        assert!(off.iter().all(|off| off.abs() < 1e-6), "overlap, duration, restitution off by {off:?}");
    }
}

/// Against a flat wall R_e is twice the sphere's radius, and the mass is the sphere's own.
#[test]
fn a_hertz_contact_with_a_wall_lasts_and_presses_as_it_should() {
    let law = HertzMindlin { constants: scenario::HertzMindlin { damping_normal: 0.0, ..hertz().constants } };
    let stiffness = hertz_stiffness(&law, 2.0 * RADIUS);
    let wanted = two_fifths(1.25 * MASS * SPEED * SPEED / stiffness);
    let dt = HERTZ_TIME * wanted / SPEED / 4000.0;
    let mut few = Few::<Solid, _>::new(law, dt, 24.0 * RADIUS);
    let (point, normal) = (vector::<Solid>([0.0; 3]), vector::<Solid>([0.6, 0.0, 0.8]));
    few.bodies.push(Body::new("wall", Shape::Plane { point, normal }));
    let place = normal * (RADIUS + 2.7 * SPEED * dt);
    few.add([place[0], place[1], place[2]], RADIUS, MASS).hot.velocity = normal * -SPEED;
    let mut world = few.world();
    let (mut deepest, mut touching) = (0.0f64, 0);
    for _ in 0..4500 {
        steps(&mut world, 1);
        let overlap = RADIUS - hot_of(&world, 0).position.dot(&normal);
        deepest = deepest.max(overlap);
        touching += u32::from(overlap > 0.0);
    }
    let off = [deepest / wanted - 1.0, f64::from(touching) / 4000.0 - 1.0];
    println!("Hertz contact with a wall: overlap and duration off by {off:?}");
    assert!(off.iter().all(|off| off.abs() < 1e-3), "overlap and duration off by {off:?}");
}

/// Two grains so heavy that forces do not move them, apart by a negative `overlap` along x; the second is at rest.
fn heavy_pair<S: Space>(law: LinearCohesive, dt: f64, overlap: f64) -> GrainWorld<'static, S, LinearCohesive> {
    let mut few = Few::<S, _>::new(law, dt, 24.0 * RADIUS);
    few.add([2.0 * RADIUS - overlap, 0.0, 0.0], RADIUS, 1e20);
    few.add([0.0; 3], RADIUS, 1e20);
    few.world()
}

fn set_velocity<S: Space>(world: &mut GrainWorld<S, LinearCohesive>, velocity: [f64; 3]) {
    let row = row_of(world, 0);
    world.grains.hot[row].velocity = vector::<S>(velocity);
}

/// Made by touching, the contact holds down to `k_n d = -e_n`; once broken it is made again only by touching.
fn a_pair_holds_until_pulled_off<S: Space>() {
    let law = cohesive();
    let (stiffness, pull) = (law.constants.linear.stiffness_normal, law.constants.cohesion_normal);
    let (dt, speed) = (2e-7, 0.01);
    let damping = law.constants.linear.damping_normal;
    let per_step = stiffness * speed * dt;
    let mut world = heavy_pair::<S>(law, dt, 0.3e-7);
    for round in 0..2 {
        // Out until nothing pulls any more.
        set_velocity(&mut world, [speed, 0.0, 0.0]);
        let mut weakest = f64::INFINITY;
        let mut count = 0;
        loop {
            steps(&mut world, 1);
            let force = load_on(&world, 0).0[0];
            count += 1;
            if force == 0.0 {
                break;
            }
            weakest = weakest.min(force + damping * speed);
            assert!(count < 1000, "it never lets go");
        }
        println!(
            "pull-off force in the {}: off by {:.1e}, a step changes it by {:.1e}",
            S::NAME,
            weakest / -pull - 1.0,
            per_step / pull
        );
        assert!(weakest > -pull && weakest < -pull + per_step, "round {round}: it let go at {weakest} N, of {pull} N");
        // Back: nothing until they touch, then all of the spring at once.
        set_velocity(&mut world, [-speed, 0.0, 0.0]);
        let mut force = 0.0;
        while force == 0.0 {
            let gap = hot_of(&world, 0).position[0] - hot_of(&world, 1).position[0] - 2.0 * RADIUS;
            steps(&mut world, 1);
            force = load_on(&world, 0).0[0];
            assert_eq!(force != 0.0, gap < 0.0, "round {round}: gap {gap} m, force {force} N");
        }
        assert!(force - damping * speed < per_step, "round {round}: {force} N at first touch");
    }
}

#[test]
fn a_cohesive_contact_holds_to_its_pull_off_force_and_is_made_by_touching() {
    a_pair_holds_until_pulled_off::<Plane>();
    a_pair_holds_until_pulled_off::<Solid>();
}

/// `|F_t| <= mu |F_n| + e_t`, in tension as well.
fn a_pair_slides_at_its_shear_strength<S: Space>() {
    let mut law = cohesive();
    (law.constants.linear.damping_normal, law.constants.linear.damping_tangential) = (0.0, 0.0);
    let linear = law.constants.linear;
    for normal in [-0.25, 0.7] {
        // Touching first, then drawn to the wanted force, then slid along y by far more than the spring's reach.
        let mut world = heavy_pair::<S>(law, 1e-7, 1e-9);
        steps(&mut world, 1);
        let row = row_of(&world, 0);
        world.grains.hot[row].position[0] = 2.0 * RADIUS - normal / linear.stiffness_normal;
        set_velocity(&mut world, [0.0, 0.01, 0.0]);
        steps(&mut world, 999);
        // The force is that of the positions before the step's drift.
        let [a, b] = [0, 1].map(|id| hot_of(&world, id).position);
        steps(&mut world, 1);
        let force = load_on(&world, 0).0;
        let along = (a - b) * (1.0 / (a - b).norm());
        let pressing = force.dot(&along);
        let sliding = (force - along * pressing).norm();
        let wanted = linear.friction * pressing.abs() + law.constants.cohesion_tangential;
        assert!((pressing - normal).abs() < 1e-3, "{pressing} N for {normal} N");
        println!("shear strength with cohesion in the {}: off by {:.1e}", S::NAME, sliding / wanted - 1.0);
        assert!((sliding / wanted - 1.0).abs() < 1e-6, "{sliding} N for {wanted} N at {pressing} N");
    }
}

#[test]
fn a_cohesive_contact_slides_at_friction_and_shear_strength() {
    a_pair_slides_at_its_shear_strength::<Plane>();
    a_pair_slides_at_its_shear_strength::<Solid>();
}

/// An oblique collision with spins: steps in touch, and positions, velocities and spins as bits after every step.
fn oblique<S: Space, C: ContactLaw<S>>(law: C) -> (usize, Vec<u64>) {
    let mut few = Few::<S, C>::new(law, 5e-8, 24.0 * RADIUS);
    let along = vector::<S>([3.0, 8.0, 4.0]);
    let apart = along * (1.801 * RADIUS / along.norm());
    let place: [f64; 3] = std::array::from_fn(|axis| if axis < S::DIMENSION { apart[axis] } else { 0.0 });
    let hot = &mut few.add(place, RADIUS, MASS).hot;
    (hot.velocity, hot.spin) = (vector::<S>([-0.31, -0.12, 0.2]), spin::<S>([40.0, -60.0, 170.0]));
    let hot = &mut few.add([0.0; 3], 0.8 * RADIUS, 0.64 * MASS).hot;
    (hot.velocity, hot.spin) = (vector::<S>([0.07, 0.23, 0.0]), spin::<S>([10.0, 30.0, -90.0]));
    let mut world = few.world();
    let mut bits = Vec::new();
    let mut touched = 0;
    for _ in 0..1500 {
        steps(&mut world, 1);
        touched += usize::from(world.grains.force.iter().any(|force| force.norm() > 0.0));
        bits.extend((0..2).flat_map(|id| hot_of(&world, id).numbers().to_vec()).map(f64::to_bits));
    }
    (touched, bits)
}

fn without_cohesion_it_is_the_linear_law<S: Space>() {
    let bare = scenario::LinearCohesive { linear: linear().constants, cohesion_normal: 0.0, cohesion_tangential: 0.0 };
    let (with, without) = (oblique::<S, _>(LinearCohesive { constants: bare }), oblique::<S, _>(linear()));
    assert!((50..1400).contains(&without.0), "they touched for {} steps", without.0);
    assert!(with == without, "other bits in {}", S::NAME);
    // At this speed the two do not come apart again.
    assert!(oblique::<S, _>(cohesive()).0 > 1400, "cohesion should tell");
}

#[test]
fn without_cohesion_the_cohesive_law_is_the_linear_one_to_the_bit() {
    without_cohesion_it_is_the_linear_law::<Plane>();
    without_cohesion_it_is_the_linear_law::<Solid>();
}

/// No law without dashpots and friction takes energy from a collision, or turns a grain.
fn smooth_collisions_keep_energy<S: Space>() {
    let smooth: LinearSpringDashpot = {
        let mut law = linear();
        (law.constants.friction, law.constants.damping_normal, law.constants.damping_tangential) = (0.0, 0.0, 0.0);
        law
    };
    let rolling: ElasticRolling = {
        let mut law = elastic();
        (law.constants.friction, law.constants.rolling_limit) = (0.0, 0.0);
        law
    };
    let duration = |stiffness: f64| math::PI * (0.5 * MASS / stiffness).sqrt();
    let sizes = [[RADIUS; 2], [MASS; 2]];
    let stiffness = smooth.constants.stiffness_normal;
    assert!((head_on::<S, _>(smooth, sizes, duration(stiffness), 2000).restitution - 1.0).abs() < 1e-6);
    let stiffness = rolling.constants.young_modulus * RADIUS;
    let seen = head_on::<S, _>(rolling, sizes, duration(stiffness), 2000);
    assert!((seen.restitution - 1.0).abs() < 1e-6 && (seen.touching / 2000.0 - 1.0).abs() < 1e-3);
}

#[test]
fn elastic_collisions_keep_their_energy_and_last_half_a_period() {
    smooth_collisions_keep_energy::<Plane>();
    smooth_collisions_keep_energy::<Solid>();
}
