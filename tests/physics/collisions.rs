//! Two grains, or one and a wall, in collisions and pulled apart: closed forms of every law.

use scree::base::math;
use scree::base::numbers::Numbers;
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::bodies::body::{Body, Shape};
use scree::job;
use scree::law::contact::{
    Contact, ElasticRolling, Force, HertzMindlin, LinearCohesive, LinearSpringDashpot as LinearContact,
    LinearSpringDashpot, NormalForce, RollingResistance, Sliding,
};

use crate::few::{
    Few, GrainWorld, MASS, RADIUS, adhesive, cohesive, cohesive_repulsive, elastic, hertz, hot_of, linear,
    linear_repulsive, load_on, row_of, spin, steps, vector,
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
fn head_on<S: Space>(law: impl Into<Contact>, sizes: [[f64; 2]; 2], duration: f64, steps_wanted: u32) -> Seen {
    head_on_at::<S>(law, sizes, SPEED, duration, steps_wanted)
}

/// The same at a speed, m/s.
fn head_on_at<S: Space>(
    law: impl Into<Contact>,
    [radii, masses]: [[f64; 2]; 2],
    speed: f64,
    duration: f64,
    steps_wanted: u32,
) -> Seen {
    let dt = duration / f64::from(steps_wanted);
    let mut few = Few::<S>::new(law, dt, 24.0 * RADIUS);
    let along = vector::<S>([2.0, -1.0, 2.0]);
    let along = along * (1.0 / along.norm());
    let gap = 2.7 * speed * dt;
    for (radius, mass) in radii.into_iter().zip(masses) {
        few.add([0.0; 3], radius, mass);
    }
    let share = masses[1] / (masses[0] + masses[1]);
    few.grains[0].hot.position = along * (0.5 * (radii[0] + radii[1] + gap));
    few.grains[1].hot.position = -few.grains[0].hot.position;
    few.grains[0].hot.velocity = along * (-speed * share);
    few.grains[1].hot.velocity = along * (speed * (1.0 - share));
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
        seen.restitution = (a.velocity - b.velocity).dot(&along) / speed;
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
        law.damping_normal = damping;
        let decay = damping / (2.0 * reduced);
        let duration = math::PI / (law.stiffness_normal / reduced - decay * decay).sqrt();
        let seen = head_on::<S>(law, [[RADIUS; 2], [MASS; 2]], duration, 4000);
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

/// A collision by its equation `m d'' = -F(d, d')`, with d the overlap and F what a law gives (none: the contact has ended):
/// the speed after over that before, and the time of contact, s. Runge and Kutta's fourth order in steps of `dt`; where it
/// ends within a step, by the overlap's line.
fn by_the_equation(force: impl Fn(f64, f64) -> Option<f64>, reduced: f64, speed: f64, dt: f64) -> [f64; 2] {
    let acceleration = |overlap: f64, closing: f64| force(overlap, closing).map(|force| -force / reduced);
    let (mut overlap, mut closing, mut time) = (0.0, speed, 0.0);
    let step = |overlap: f64, closing: f64| -> Option<[f64; 2]> {
        let [half, sixth] = [0.5 * dt, dt / 6.0];
        let a = [closing, acceleration(overlap, closing)?];
        let b = [closing + half * a[1], acceleration(overlap + half * a[0], closing + half * a[1])?];
        let c = [closing + half * b[1], acceleration(overlap + half * b[0], closing + half * b[1])?];
        let d = [closing + dt * c[1], acceleration(overlap + dt * c[0], closing + dt * c[1])?];
        Some([0, 1].map(|at| sixth * (a[at] + 2.0 * (b[at] + c[at]) + d[at])))
    };
    while let Some([moved, braked]) = step(overlap, closing) {
        (overlap, closing, time) = (overlap + moved, closing + braked, time + dt);
        assert!(time < 1e6 * dt, "it never ends");
    }
    [-closing / speed, time]
}

/// Held to the equation of its own motion, and told from the law whose dashpot may pull: the rebounds of both.
fn rebounds<S: Space>(
    [tensile, repulsive]: [Contact; 2],
    [radii, masses]: [[f64; 2]; 2],
    speed: f64,
    force: impl Fn(f64, f64, NormalForce) -> Option<f64>,
) -> [f64; 2] {
    let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
    let one = |law: Contact, limit: NormalForce| {
        let [wanted, duration] = by_the_equation(|d, v| force(d, v, limit), reduced, speed, 1e-9);
        let seen = head_on_at::<S>(law, [radii, masses], speed, duration, 4000);
        assert!((seen.restitution - wanted).abs() < 5e-4, "{} for {wanted}: {law:?}", seen.restitution);
        println!("rebound by the equation {wanted:.4}, off by {:.1e}: {law:?}", seen.restitution - wanted);
        seen.restitution
    };
    let both = [one(tensile, NormalForce::TENSILE), one(repulsive, NormalForce::REPULSIVE)];
    let share = both[1] / both[0] - 1.0;
    assert!(share > 0.02, "a dashpot that only repels leaves more speed: {both:?}");
    both
}

fn dashpots_only_repel<S: Space>() {
    let sizes = [[RADIUS; 2], [MASS; 2]];
    // What spring (N) and dashpot give at a closing speed, limited or not.
    let limited = |spring: f64, dashpot: f64, limit: NormalForce| (spring + dashpot).max(limit.least());
    let (law, only) = (linear(), linear_repulsive());
    let LinearContact { stiffness_normal, damping_normal, .. } = law;
    for speed in [0.01, 0.1] {
        rebounds::<S>([law.into(), only.into()], sizes, speed, |overlap, closing, limit| {
            (overlap >= 0.0).then(|| limited(stiffness_normal * overlap, damping_normal * closing, limit))
        });
    }
    // Fast enough to come apart again; in tension the spring alone pulls.
    let (law, only) = (cohesive(), cohesive_repulsive());
    rebounds::<S>([law.into(), only.into()], sizes, 0.8, |overlap, closing, limit| {
        let (spring, dashpot) = (stiffness_normal * overlap, damping_normal * closing);
        let pull = spring.min(0.0);
        (spring >= -law.cohesion_normal).then(|| (spring + dashpot).max(pull + limit.least()))
    });
    // Of a constant dashpot, whose rebound depends on speed, and of one by the damping ratio as well.
    for (radii, masses) in [([RADIUS; 2], [MASS; 2]), ([RADIUS, 0.6 * RADIUS], [MASS, 0.216 * MASS])] {
        let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
        for ratio in [0.0, 0.3] {
            let of = |normal_force| HertzMindlin {
                // So little that the slowest and lightest come apart again.
                damping_normal: 0.7,
                damping_ratio: ratio,
                normal_force,
                ..hertz()
            };
            let pair = NormalForce::NAMES.map(|(_, of_name)| of(of_name));
            let stiffness = hertz_stiffness(&pair[0], 2.0 * radii[0] * radii[1] / (radii[0] + radii[1]));
            let seen = [0.1, 0.8].map(|speed| {
                rebounds::<S>(pair.map(Contact::from), [radii, masses], speed, |overlap, closing, limit| {
                    let root = overlap.max(0.0).sqrt();
                    // alpha = sqrt(5) zeta of Tsuji et al., whose dashpot is alpha sqrt(m K) d^(1/4) with F = K d^(3/2).
                    let viscous = (5.0 * reduced * stiffness * root).sqrt() * ratio;
                    let dashpot = (pair[0].damping_normal + viscous) * closing;
                    (overlap >= 0.0).then(|| limited(stiffness * overlap * root, dashpot, limit))
                })
            });
            assert!(seen[0][0] < 0.9 * seen[1][0], "a constant dashpot brakes slow grains more: {seen:?}");
        }
    }
}

/// A dashpot that may pull takes more from a rebound than one that only repels: each as the equation of the motion has it.
#[test]
fn a_dashpot_that_only_repels_leaves_what_the_equation_leaves() {
    dashpots_only_repel::<Plane>();
    dashpots_only_repel::<Solid>();
}

/// The contact that a job of planar shear gets with these lines, and its law.
fn of_job(lines: &str) -> Contact {
    let text = format!(
        "name = \"small\"\nmethod = \"dem\"\n[specimen]\nwidth = 0.024\nheight = 0.03\n[grains]\ndiameter_mean = 1e-3\ndiameter_deviation = 0\ndensity = 2530\n[loading]\nstress_normal = 4e5\nspeed = 0.02\nspeed_ramp = 0\nstrain_end = 0.1\n[time]\nstep = 1e-9\n[contact]\nfriction = 0.5\n{lines}"
    );
    let scenario = job::Scenario::parse(&text, "small.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    scenario.contact
}

/// `contact.restitution` is what comes back, with both ranges of the normal force: of linear contacts between mean grains, of
/// Hertz contacts between any two and at every speed.
#[test]
fn grains_rebound_with_the_restitution_of_the_job() {
    let mean = 2530.0 * math::PI * RADIUS * RADIUS * 0.01;
    for (name, _) in NormalForce::NAMES {
        for restitution in [0.1, 0.5, 0.9] {
            let damped = format!("restitution = {restitution}\nnormal_force = \"{name}\"");
            let spring = "stiffness_normal = 1772093.8\nstiffness_tangential = 886046.9";
            let Force::Linear(law) = of_job(&format!("{spring}\n{damped}")).force else { panic!("by default") };
            // Long enough for the slowest of them.
            let duration = 3.0 * math::PI * (0.5 * mean / law.stiffness_normal).sqrt();
            let seen = head_on::<Plane>(law, [[RADIUS; 2], [mean; 2]], duration, 12000).restitution;
            assert!((seen - restitution).abs() < 1e-3, "linear, {name}: {seen} for {restitution}");
            println!("linear, {name}, restitution {restitution}: off by {:.1e}", seen - restitution);

            let solid = "law = \"hertz_mindlin\"\nshear_modulus = 3e8\npoisson_ratio = 0.2";
            let Force::HertzMindlin(law) = of_job(&format!("{solid}\n{damped}")).force else { panic!("as it says") };
            for (radii, masses) in [([RADIUS; 2], [MASS; 2]), ([RADIUS, 0.6 * RADIUS], [MASS, 0.216 * MASS])] {
                for speed in [0.01, 0.1, 1.0] {
                    let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
                    let stiffness = hertz_stiffness(&law, 2.0 * radii[0] * radii[1] / (radii[0] + radii[1]));
                    let overlap = two_fifths(1.25 * reduced * speed * speed / stiffness);
                    let duration = 3.0 * HERTZ_TIME * overlap / speed;
                    let seen = head_on_at::<Solid>(law, [radii, masses], speed, duration, 12000).restitution;
                    assert!((seen - restitution).abs() < 1e-3, "Hertz, {name}, {speed} m/s: {seen} for {restitution}");
                    println!(
                        "Hertz, {name}, {speed} m/s, restitution {restitution}: off by {:.1e}",
                        seen - restitution
                    );
                }
            }
        }
    }
}

/// `x^(2/5)`.
fn two_fifths(x: f64) -> f64 {
    math::exp(0.4 * math::ln(x))
}

/// `2 integral of dx/sqrt(1 - x^(5/2))` from 0 to 1, `= 2 sqrt(pi) Gamma(7/5)/Gamma(9/10)`.
const HERTZ_TIME: f64 = 2.943_275_1;

/// Stiffness of `F = k d^(3/2)` by eq. 53 and 55: `k = 2/3 sqrt(2) G sqrt(R_e)/(1 - nu)`.
fn hertz_stiffness(law: &HertzMindlin, radius_effective: f64) -> f64 {
    let law = &law;
    2.0 / 3.0 * std::f64::consts::SQRT_2 * law.shear_modulus * radius_effective.sqrt() / (1.0 - law.poisson_ratio)
}

/// From `m v^2/2 = 2/5 k d^(5/2)` the deepest overlap is `d = (5/4 m v^2/k)^(2/5)`, and the contact lasts 2.9433 d/v.
#[test]
fn hertz_contacts_last_and_press_as_they_should() {
    let law = HertzMindlin { damping_normal: 0.0, ..hertz() };
    for [radii, masses] in [[[RADIUS; 2], [MASS; 2]], [[RADIUS, 0.6 * RADIUS], [MASS, 0.216 * MASS]]] {
        let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
        let stiffness = hertz_stiffness(&law, 2.0 * radii[0] * radii[1] / (radii[0] + radii[1]));
        let overlap = two_fifths(1.25 * reduced * SPEED * SPEED / stiffness);
        let duration = HERTZ_TIME * overlap / SPEED;
        let seen = head_on::<Solid>(law, [radii, masses], duration, 4000);
        let off = [seen.overlap / overlap - 1.0, seen.touching / 4000.0 - 1.0, seen.restitution - 1.0];
        println!("Hertz: overlap, duration, restitution off by {off:?}");
        assert!(off.iter().all(|off| off.abs() < 1e-6), "overlap, duration, restitution off by {off:?}");
    }
}

/// Against a flat wall R_e is twice the sphere's radius, and the mass is the sphere's own.
#[test]
fn a_hertz_contact_with_a_wall_lasts_and_presses_as_it_should() {
    let law = HertzMindlin { damping_normal: 0.0, ..hertz() };
    let stiffness = hertz_stiffness(&law, 2.0 * RADIUS);
    let wanted = two_fifths(1.25 * MASS * SPEED * SPEED / stiffness);
    let dt = HERTZ_TIME * wanted / SPEED / 4000.0;
    let mut few = Few::<Solid>::new(law, dt, 24.0 * RADIUS);
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
fn heavy_pair<S: Space>(law: LinearCohesive, dt: f64, overlap: f64) -> GrainWorld<'static, S> {
    let mut few = Few::<S>::new(law, dt, 24.0 * RADIUS);
    few.add([2.0 * RADIUS - overlap, 0.0, 0.0], RADIUS, 1e20);
    few.add([0.0; 3], RADIUS, 1e20);
    few.world()
}

fn set_velocity<S: Space>(world: &mut GrainWorld<S>, velocity: [f64; 3]) {
    let row = row_of(world, 0);
    world.assembly.grains.hot[row].velocity = vector::<S>(velocity);
}

/// Made by touching, the contact holds down to `k_n d = -e_n`; once broken it is made again only by touching.
fn a_pair_holds_until_pulled_off<S: Space>() {
    let law = cohesive();
    let (stiffness, pull) = (law.linear.stiffness_normal, law.cohesion_normal);
    let (dt, speed) = (2e-7, 0.01);
    let damping = law.linear.damping_normal;
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
    (law.linear.damping_normal, law.linear.damping_tangential) = (0.0, 0.0);
    let linear = law.linear;
    for normal in [-0.25, 0.7] {
        // Touching first, then drawn to the wanted force, then slid along y by far more than the spring's reach.
        let mut world = heavy_pair::<S>(law, 1e-7, 1e-9);
        steps(&mut world, 1);
        let row = row_of(&world, 0);
        world.assembly.grains.hot[row].position[0] = 2.0 * RADIUS - normal / linear.stiffness_normal;
        set_velocity(&mut world, [0.0, 0.01, 0.0]);
        steps(&mut world, 999);
        // The force is that of the positions before the step's drift.
        let [a, b] = [0, 1].map(|id| hot_of(&world, id).position);
        steps(&mut world, 1);
        let force = load_on(&world, 0).0;
        let along = (a - b) * (1.0 / (a - b).norm());
        let pressing = force.dot(&along);
        let sliding = (force - along * pressing).norm();
        let wanted = linear.friction * pressing.abs() + law.cohesion_tangential;
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

/// Adhesion by Derjaguin, Muller & Toporov (1975): 4 pi gamma R parts two grains, at no overlap at all, and what they rest at is where
/// Hertz's force is that. Nothing acts once they are apart.
fn adhesion_parts_at_its_force<S: Space>() {
    let law = adhesive();
    let Force::HertzMindlin(hertz) = law.force else { panic!("as it was made") };
    let pull = 4.0 * math::PI * law.adhesion.unwrap().surface_energy * 0.5 * RADIUS;
    let (dt, speed) = (1e-8, 1e-3);
    let mut few = Few::<S>::new(law, dt, 24.0 * RADIUS);
    few.add([2.0 * RADIUS - 3e-9, 0.0, 0.0], RADIUS, 1e20).hot.velocity = vector::<S>([speed, 0.0, 0.0]);
    few.add([0.0; 3], RADIUS, 1e20);
    let mut world = few.world();
    let mut weakest = 0.0f64;
    for _ in 0..400 {
        let gap = hot_of(&world, 0).position[0] - hot_of(&world, 1).position[0] - 2.0 * RADIUS;
        steps(&mut world, 1);
        let force = load_on(&world, 0).0[0];
        assert_eq!(force != 0.0, gap < 0.0, "gap {gap} m, force {force} N");
        weakest = weakest.min(force + hertz.damping_normal * speed);
    }
    println!("adhesion in the {}: off by {:.1e}", S::NAME, weakest / -pull - 1.0);
    assert!((weakest / -pull - 1.0).abs() < 1e-3, "{weakest} N for {pull} N");

    // At rest once its dashpot has taken what it came with.
    let mut few = Few::<S>::new(law, 2e-8, 24.0 * RADIUS);
    few.add([2.0 * RADIUS - 1e-8, 0.0, 0.0], RADIUS, MASS);
    few.add([0.0; 3], RADIUS, MASS);
    let mut world = few.world();
    steps(&mut world, 40_000);
    let overlap = 2.0 * RADIUS - (hot_of(&world, 0).position - hot_of(&world, 1).position).norm();
    let wanted = math::cbrt(pull / hertz_stiffness(&hertz, RADIUS));
    assert!((overlap / (wanted * wanted) - 1.0).abs() < 1e-3, "{overlap} m for {} m", wanted * wanted);
}

#[test]
fn grains_that_adhere_part_at_the_force_of_their_surface_energy() {
    adhesion_parts_at_its_force::<Plane>();
    adhesion_parts_at_its_force::<Solid>();
}

/// Rolling beside the linear law is that of the law which has it by itself: between equal grains, without dashpots, the two are one.
fn rolling_is_one_part<S: Space>() {
    let own = ElasticRolling { sliding: Sliding::Surface, ..elastic() };
    let springs = LinearSpringDashpot {
        stiffness_normal: own.young_modulus * RADIUS,
        stiffness_tangential: own.stiffness_ratio * own.young_modulus * RADIUS,
        damping_normal: 0.0,
        damping_tangential: 0.0,
        ..linear()
    };
    let beside = RollingResistance { stiffness: own.rolling_stiffness, limit: own.rolling_limit };
    let met = |law: Contact| {
        let mut few = Few::<S>::new(law, 5e-8, 24.0 * RADIUS);
        let hot = &mut few.add([1.999 * RADIUS, 0.0, 0.0], RADIUS, MASS).hot;
        (hot.velocity, hot.spin) = (vector::<S>([-0.31, -0.12, 0.2]), spin::<S>([40.0, -60.0, 170.0]));
        few.add([0.0; 3], RADIUS, MASS).hot.spin = spin::<S>([10.0, 30.0, -90.0]);
        let mut world = few.world();
        steps(&mut world, 1500);
        [0, 1].map(|id| hot_of(&world, id).spin)
    };
    let [alone, together, none] =
        [own.into(), Contact { rolling: Some(beside), ..springs.into() }, Contact::from(springs)].map(met);
    for (alone, together) in alone.iter().zip(&together) {
        assert!((*alone - *together).norm() < 1e-8 * alone.norm(), "{alone:?} {together:?}");
    }
    assert!((alone[0] - none[0]).norm() > 1e-3 * alone[0].norm(), "rolling should tell");
}

#[test]
fn rolling_beside_a_law_is_that_of_the_law_that_has_it() {
    rolling_is_one_part::<Plane>();
    rolling_is_one_part::<Solid>();
}

/// An oblique collision with spins: steps in touch, and positions, velocities and spins as bits after every step.
fn oblique<S: Space>(law: impl Into<Contact>) -> (usize, Vec<u64>) {
    let mut few = Few::<S>::new(law, 5e-8, 24.0 * RADIUS);
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
        touched += usize::from(world.assembly.grains.force.iter().any(|force| force.norm() > 0.0));
        bits.extend((0..2).flat_map(|id| hot_of(&world, id).numbers().to_vec()).map(f64::to_bits));
    }
    (touched, bits)
}

fn without_cohesion_it_is_the_linear_law<S: Space>() {
    for law in [linear(), linear_repulsive()] {
        let bare = scree::law::contact::LinearCohesive { linear: law, cohesion_normal: 0.0, cohesion_tangential: 0.0 };
        let (with, without) = (oblique::<S>(bare), oblique::<S>(law));
        assert!((50..1400).contains(&without.0), "they touched for {} steps", without.0);
        assert!(with == without, "other bits in {}", S::NAME);
    }
    // At this speed the two do not come apart again.
    assert!(oblique::<S>(cohesive()).0 > 1400, "cohesion should tell");
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
        (law.friction, law.damping_normal, law.damping_tangential) = (0.0, 0.0, 0.0);
        law
    };
    let rolling: ElasticRolling = {
        let mut law = elastic();
        (law.friction, law.rolling_limit) = (0.0, 0.0);
        law
    };
    let duration = |stiffness: f64| math::PI * (0.5 * MASS / stiffness).sqrt();
    let sizes = [[RADIUS; 2], [MASS; 2]];
    let stiffness = smooth.stiffness_normal;
    assert!((head_on::<S>(smooth, sizes, duration(stiffness), 2000).restitution - 1.0).abs() < 1e-6);
    let stiffness = rolling.young_modulus * RADIUS;
    let seen = head_on::<S>(rolling, sizes, duration(stiffness), 2000);
    assert!((seen.restitution - 1.0).abs() < 1e-6 && (seen.touching / 2000.0 - 1.0).abs() < 1e-3);
}

#[test]
fn elastic_collisions_keep_their_energy_and_last_half_a_period() {
    smooth_collisions_keep_energy::<Plane>();
    smooth_collisions_keep_energy::<Solid>();
}
