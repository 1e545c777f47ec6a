//! Rigid bodies and the grains that touch them: balances to round-off, held forces, given paths, driving spins.

use scree::base::math;
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::bodies::body::{Body, Instant, Servo, Shape};
use scree::law::contact::Contact;

use crate::few::{
    Claim, Few, GrainWorld, MASS, RADIUS, elastic, for_every_law, hertz, hot_of, linear, load_on, spin, steps, vector,
};

/// A body, the place of a grain that just does not touch it and the way from the one to the other, m and a unit vector.
struct Meeting<S: Space> {
    shape: Shape<S>,
    place: S::Vector,
    normal: S::Vector,
}

/// A plane, a box met at a face and at a corner, a cylinder.
fn meetings<S: Space>(gap: f64) -> Vec<Meeting<S>> {
    let unit = |components: [f64; 3]| {
        let vector = vector::<S>(components);
        vector * (1.0 / vector.norm())
    };
    let zero = vector::<S>([0.0; 3]);
    let reach = RADIUS + gap;
    let meet =
        |shape: Shape<S>, point: S::Vector, normal: S::Vector| Meeting { shape, place: point + normal * reach, normal };
    let (slant, beside) = (unit([1.0, 2.0, -0.5]), vector::<S>([2e-4, -1e-4, 4e-4]));
    let corner = vector::<S>([1e-3, 5e-4, 8e-4]);
    let block = Shape::Box { lower: vector::<S>([-2e-3; 3]), upper: corner };
    let axis = if S::DIMENSION == 2 { zero } else { unit([0.0, 0.6, 0.8]) };
    let around = if S::DIMENSION == 2 { unit([1.0, 3.0, 0.0]) } else { unit([1.0, 0.8, -0.6]) };
    let radius = 1.3e-3;
    vec![
        meet(Shape::Plane { point: beside, normal: slant }, beside, slant),
        meet(block, vector::<S>([1e-3, 1e-4, -3e-4]), unit([1.0, 0.0, 0.0])),
        meet(block, corner, unit([1.0, 1.5, 0.7])),
        meet(Shape::Cylinder { centre: zero, axis, radius }, around * radius + axis * 2e-4, around),
    ]
}

fn place_of<S: Space>(place: &S::Vector) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < S::DIMENSION { place[axis] } else { 0.0 })
}

struct Balances;

impl Claim for Balances {
    fn hold<S: Space>(law: Contact) {
        for meeting in meetings::<S>(1e-7) {
            let mut few = Few::<S>::new(law, 5e-8, 24.0 * RADIUS);
            let mut body = Body::new("body", meeting.shape);
            // Turning in place, so that its surface rubs.
            let turn = spin::<S>([30.0, -20.0, 60.0]);
            body.path = vec![Instant { time: 0.0, velocity: vector::<S>([0.0; 3]), spin: turn }];
            let origin = body.origin();
            few.bodies.push(body);
            let hot = &mut few.add(place_of::<S>(&meeting.place), RADIUS, MASS).hot;
            hot.velocity = meeting.normal * -0.2 + vector::<S>([0.1, -0.05, 0.07]);
            hot.spin = spin::<S>([-100.0, 50.0, 150.0]);
            let mut world = few.world();
            // What grain and body have between them, and its parts' magnitudes.
            let sums = |world: &GrainWorld<S>| {
                let (hot, body) = (hot_of(world, 0), &world.bodies[0]);
                let momentum = hot.velocity * hot.mass;
                let orbital = S::moment(&(hot.position - origin), &momentum);
                let own = hot.spin * S::grain_inertia(hot.mass, hot.radius);
                (momentum + body.impulse, orbital + own + body.impulse_angular)
            };
            let before = sums(&world);
            let scale = [MASS * 0.25, S::grain_inertia(MASS, RADIUS) * 180.0 + MASS * 0.25 * 1e-3];
            let (mut touched, mut worst) = (0, [0.0f64; 2]);
            for _ in 0..1000 {
                steps(&mut world, 1);
                touched += usize::from(world.assembly.grains.force.iter().any(|force| force.norm() > 0.0));
                let now = sums(&world);
                worst[0] = worst[0].max((now.0 - before.0).norm() / scale[0]);
                worst[1] = worst[1].max((now.1 - before.1).norm() / scale[1]);
            }
            let what = format!("{:?} under {law:?} in {}", meeting.shape, S::NAME);
            assert!(touched > 50, "they touched for {touched} steps: {what}");
            assert!(worst[0] < 1e-13, "momentum off by {:e}: {what}", worst[0]);
            assert!(worst[1] < 1e-13, "angular momentum off by {:e}: {what}", worst[1]);
            let impulse = world.bodies[0].impulse;
            let pressed = impulse.dot(&meeting.normal);
            assert!(pressed < -0.3 * MASS * 0.2, "the grain hardly pressed: {pressed:e} N s: {what}");
            assert!((impulse - meeting.normal * pressed).norm() > 1e-8, "it did not rub: {what}");
        }
    }
}

/// What a grain loses in a collision its body gains: momentum, and angular momentum about the body's origin.
#[test]
fn a_collision_with_a_body_keeps_momentum_and_angular_momentum() {
    for_every_law::<Balances>();
}

/// Without friction and damping a grain leaves as fast as it came, mirrored, its spin as it was.
fn bounces<S: Space>(law: Contact) {
    for meeting in meetings::<S>(1e-7) {
        let mut few = Few::<S>::new(law, 2e-8, 24.0 * RADIUS);
        few.bodies.push(Body::new("body", meeting.shape));
        let hot = &mut few.add(place_of::<S>(&meeting.place), RADIUS, MASS).hot;
        hot.velocity = meeting.normal * -0.2;
        hot.spin = spin::<S>([-100.0, 50.0, 150.0]);
        let start = *hot;
        let mut world = few.world();
        steps(&mut world, 3000);
        let end = hot_of(&world, 0);
        assert_eq!(load_on(&world, 0).0.norm(), 0.0, "they still touch");
        let off = (end.velocity + start.velocity).norm() / 0.2;
        assert!(off < 1e-5, "velocity off by {off:e} at {:?} under {law:?} in {}", meeting.shape, S::NAME);
        assert_eq!(end.spin, start.spin, "{:?} under {law:?} in {}", meeting.shape, S::NAME);
    }
}

fn bounces_under_smooth_laws<S: Space>() {
    let mut smooth = linear();
    (smooth.friction, smooth.damping_normal, smooth.damping_tangential) = (0.0, 0.0, 0.0);
    bounces::<S>(smooth.into());
    let mut rolling = elastic();
    (rolling.friction, rolling.rolling_limit) = (0.0, 0.0);
    bounces::<S>(rolling.into());
    let mut ball = hertz();
    (ball.friction, ball.damping_normal, ball.damping_tangential) = (0.0, 0.0, 0.0);
    bounces::<S>(ball.into());
}

#[test]
fn smooth_grains_bounce_off_bodies_as_fast_as_they_came() {
    bounces_under_smooth_laws::<Plane>();
    bounces_under_smooth_laws::<Solid>();
}

/// A grain between a fixed plane and one that presses with a held force: the force comes out, and both contacts are as deep
/// as it makes them.
fn holds_its_force<S: Space>(law: Contact, overlap: f64) {
    const FORCE: f64 = 0.5;
    let mut few = Few::<S>::new(law, 2e-7, 24.0 * RADIUS);
    let (up, zero) = (vector::<S>([0.0, 1.0, 0.0]), vector::<S>([0.0; 3]));
    few.bodies.push(Body::new("table", Shape::Plane { point: zero, normal: up }));
    let mut press = Body::new("press", Shape::Plane { point: up * (2.0 * RADIUS + 1e-6), normal: -up });
    press.servo = Some(Servo { direction: up, force: FORCE, mass: 1e-3, damping: 60.0, speed_max: 2e-3 });
    few.bodies.push(press);
    few.add([0.0, RADIUS, 0.0], RADIUS, MASS);
    let mut world = few.world();
    // Until it touches, the limit on the speed is what counts.
    steps(&mut world, 1000);
    let fallen = -world.bodies[1].displacement.dot(&up);
    let limit = 2e-3 * 1000.0 * 2e-7;
    assert!(fallen <= limit * (1.0 + 1e-12) && fallen > 0.98 * limit, "{fallen} m, the limit allows {limit} m");
    steps(&mut world, 30_000);
    world.bodies.iter_mut().for_each(|body| body.impulse = S::Vector::zero());
    steps(&mut world, 1000);
    for (body, wanted) in world.bodies.iter().zip([-FORCE, FORCE]) {
        let force = body.impulse.dot(&up) / (1000.0 * 2e-7);
        assert!((force / wanted - 1.0).abs() < 1e-9, "{force} N on {}, not {wanted} N under {law:?}", body.name);
    }
    // Both contacts are half an overlap inside the grain's surface: minus force times branch, twice.
    let wanted = -2.0 * FORCE * (RADIUS - 0.5 * overlap);
    let found = (world.contact_moment().unwrap() * up).dot(&up);
    assert!((found / wanted - 1.0).abs() < 1e-9, "a moment of {found} J, not {wanted} J under {law:?}");
    let way = -world.bodies[1].displacement.dot(&up);
    let wanted = 1e-6 + 2.0 * overlap;
    assert!((way / wanted - 1.0).abs() < 1e-9, "the press came {way} m, not {wanted} m under {law:?}");
}

fn holds_its_force_under_damped_laws<S: Space>() {
    holds_its_force::<S>(linear().into(), 0.5 / linear().stiffness_normal);
    let law = hertz();
    let stiffness = 2.0 / 3.0 * std::f64::consts::SQRT_2 * law.shear_modulus * (2.0 * RADIUS).sqrt();
    let softness = 0.5 * (1.0 - law.poisson_ratio) / stiffness;
    holds_its_force::<S>(hertz().into(), math::cbrt(softness * softness));
}

#[test]
fn a_servo_comes_to_the_force_it_holds() {
    holds_its_force_under_damped_laws::<Plane>();
    holds_its_force_under_damped_laws::<Solid>();
}

/// Ramps up, holds, ramps down to another speed: the way is the integral of the path, to round-off.
fn follows_its_path<S: Space>() {
    let dt = 1e-5;
    let mut few = Few::<S>::new(linear(), dt, 24.0 * RADIUS);
    let mut body =
        Body::new("body", Shape::Plane { point: vector::<S>([0.0; 3]), normal: vector::<S>([1.0, 0.0, 0.0]) });
    let (fast, slow) = (vector::<S>([0.3, -0.2, 0.1]), vector::<S>([-0.1, 0.0, 0.2]));
    let turn = spin::<S>([1.0, -2.0, 5.0]);
    let zero = vector::<S>([0.0; 3]);
    let at = |time: f64, velocity, turning| Instant { time, velocity, spin: turn * turning };
    body.path = vec![at(0.0, zero, 0.0), at(10.0 * dt, fast, 1.0), at(30.0 * dt, fast, 1.0), at(50.0 * dt, slow, -1.0)];
    few.bodies.push(body);
    few.add([RADIUS * 3.0, 0.0, 0.0], RADIUS, MASS);
    let mut world = few.world();
    let ways = [(10, fast * 5.0), (30, fast * 25.0), (50, fast * 25.0 + (fast + slow) * 10.0)];
    let rest = ways[2].1 + slow * 50.0;
    for (step, way) in ways.into_iter().chain([(100, rest)]) {
        let more = step - world.step as usize;
        steps(&mut world, more);
        let off = (world.bodies[0].displacement - way * dt).norm() / fast.norm() / dt;
        assert!(off < 1e-12, "after {step} steps {:?} is {off:e} steps off", world.bodies[0].displacement);
    }
    let body = &world.bodies[0];
    assert!(body.velocity == slow && body.spin == -turn, "{:?}, {:?}", body.velocity, body.spin);
}

#[test]
fn a_body_follows_its_path_exactly() {
    follows_its_path::<Plane>();
    follows_its_path::<Solid>();
}

/// A grain pressed by its weight onto a cylinder that spins in place: the surface rubs past and drives the grain with
/// mu m g; what drives the grain brakes the cylinder.
fn drives_a_grain<S: Space>(law: Contact, overlap: f64) {
    const CYLINDER: f64 = 2e-3;
    let (gravity, friction, dt) = (9.81, 0.5, 2e-7);
    let mut few = Few::<S>::new(law, dt, 48.0 * RADIUS);
    let axis = if S::DIMENSION == 2 { vector::<S>([0.0; 3]) } else { vector::<S>([0.0, 0.0, 1.0]) };
    let mut body = Body::new("roll", Shape::Cylinder { centre: vector::<S>([0.0; 3]), axis, radius: CYLINDER });
    // Counterclockwise, so that the top runs to the left.
    let turn = spin::<S>([0.0, 0.0, 50.0]);
    body.path = vec![Instant { time: 0.0, velocity: vector::<S>([0.0; 3]), spin: turn }];
    few.bodies.push(body);
    few.settings.grains.field.gravity = vector::<S>([0.0, -gravity, 0.0]);
    few.add([0.0, CYLINDER + RADIUS - overlap, 0.0], RADIUS, MASS);
    let mut world = few.world();
    steps(&mut world, 100);
    world.bodies[0].impulse_angular = S::Spin::zero();
    let early = hot_of(&world, 0);
    steps(&mut world, 200);
    let (late, body) = (hot_of(&world, 0), &world.bodies[0]);
    let duration = 200.0 * dt;
    let force = friction * MASS * gravity;
    let close = |found: f64, wanted: f64, what: &str| {
        let off = found / wanted - 1.0;
        assert!(off.abs() < 1e-5, "{what}: {found} for {wanted}, off by {off:e}, under {law:?} in {}", S::NAME);
    };
    let z = S::Spin::COMPONENTS - 1;
    close((late.velocity[0] - early.velocity[0]) / duration, -force / MASS, "acceleration");
    // Gears: the grain turns against the cylinder.
    let spin_up = -force * RADIUS / S::grain_inertia(MASS, RADIUS);
    close((late.spin[z] - early.spin[z]) / duration, spin_up, "spin-up");
    close(body.impulse_angular[z] / duration, -force * CYLINDER, "torque on the cylinder");
}

fn drives_a_grain_under_every_law<S: Space>() {
    let weight = MASS * 9.81;
    drives_a_grain::<S>(linear().into(), weight / linear().stiffness_normal);
    let constants = elastic();
    let mean = 2.0 * RADIUS * 2e-3 / (RADIUS + 2e-3);
    let mut free = elastic();
    free.rolling_limit = 0.0;
    drives_a_grain::<S>(free.into(), weight / (constants.young_modulus * mean));
    let law = hertz();
    let stiffness = 2.0 / 3.0 * std::f64::consts::SQRT_2 * law.shear_modulus * mean.sqrt() / (1.0 - law.poisson_ratio);
    let softness = weight / stiffness;
    drives_a_grain::<S>(hertz().into(), math::cbrt(softness * softness));
}

#[test]
fn a_spinning_cylinder_drives_a_grain_by_friction() {
    drives_a_grain_under_every_law::<Plane>();
    drives_a_grain_under_every_law::<Solid>();
}

/// A grain that falls on a body from across a periodic face, through the face or beside the next image of the body, bounces
/// off as it would from the body itself, and the moment of the contact is that of the branch between the two.
fn is_felt_across_faces<S: Space>(shape: Shape<S>, offset: f64) {
    let law = elastic();
    let edge = 24.0 * RADIUS;
    let run = |periods: f64| {
        let mut few = Few::<S>::periodic(law, 2e-8, [-0.5 * edge; 3], [edge; 3]);
        few.settings.grains.skin = 0.2 * RADIUS;
        let mut body = Body::new("body", shape);
        // Into the face, and for another run two periods on.
        body.displacement[0] = 0.5 * edge - offset;
        few.bodies.push(body);
        let mut place = [0.0; 3];
        (place[0], place[1]) = (0.5 * edge - offset + periods, 2.0 * RADIUS + 1e-7);
        let mut world = {
            let hot = &mut few.add(place, RADIUS, MASS).hot;
            hot.velocity = vector::<S>([0.05, -0.2, 0.0]);
            few.world()
        };
        let (mut moment, mut torque) = (S::Tensor::zero(), S::Spin::zero());
        for _ in 0..1500 {
            steps(&mut world, 1);
            moment += world.contact_moment().unwrap();
        }
        torque += world.bodies[0].impulse_angular;
        (hot_of(&world, 0).velocity, world.bodies[0].impulse, torque, moment)
    };
    let (velocity, impulse, torque, moment) = run(0.0);
    assert!(velocity[1] > 0.1 && impulse.norm() > 0.3 * MASS * 0.2, "it went through: {velocity:?} in {}", S::NAME);
    let across = run(-edge);
    let near = |off: f64, scale: f64| assert!(off < 1e-9 * scale, "off by {off:e} of {scale:e} in {}", S::NAME);
    near((across.0 - velocity).norm(), velocity.norm());
    near((across.1 - impulse).norm(), impulse.norm());
    near((across.2 - torque).norm(), torque.norm());
    near((across.3 - moment).norm(), moment.norm());
}

#[test]
fn bodies_feel_grains_across_periodic_faces() {
    let corner = |sign: f64, axis: usize| if axis == 1 { sign * RADIUS } else { sign * 3.0 * RADIUS };
    fn in_space<S: Space>(corner: impl Fn(f64, usize) -> f64) {
        let ends = [-1.0, 1.0].map(|sign| vector::<S>(std::array::from_fn(|axis| corner(sign, axis))));
        let block = Shape::Box { lower: ends[0], upper: ends[1] };
        let axis = if S::DIMENSION == 2 { vector::<S>([0.0; 3]) } else { vector::<S>([0.0, 0.0, 1.0]) };
        let round = Shape::Cylinder { centre: vector::<S>([0.0; 3]), axis, radius: RADIUS };
        for shape in [block, round] {
            for offset in [-0.3 * RADIUS, 0.2 * RADIUS] {
                is_felt_across_faces::<S>(shape, offset);
            }
        }
    }
    in_space::<Plane>(corner);
    in_space::<Solid>(corner);
}
