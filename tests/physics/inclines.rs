//! A disc and a sphere on a plane under gravity: rolling, sliding, and rolling to a stop, to closed forms of every law.

use scree::base::math;
use scree::base::space::{Components, Linear, Plane, Solid, Space, Words};
use scree::bodies::body::{Body, Shape};
use scree::dem::grains::{body_partner, lanes};
use scree::law::contact::{Contact, Memory};

use crate::few::{Few, GrainWorld, MASS, RADIUS, cohesive, elastic, hertz, hot_of, linear, steps, vector};

const GRAVITY: f64 = 9.81;

/// Overlap under a normal force, m.
type Pressed = Box<dyn Fn(f64) -> f64>;
/// Memory of a contact that holds a tangential force.
type Holding<S> = Box<dyn Fn(<S as Space>::TangentOf<f64>) -> Memory>;

/// What is known beforehand of a law's contact with a plane.
struct Known<S: Space> {
    law: Contact,
    friction: f64,
    /// N, beside friction.
    shear_strength: f64,
    overlap: Pressed,
    memory: Holding<S>,
}

/// A slope that rises along `uphill`.
struct Slope<S: Space> {
    normal: S::Vector,
    uphill: S::Vector,
    sine: f64,
    cosine: f64,
}

impl<S: Space> Slope<S> {
    fn new(tangent: f64) -> Self {
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        let sine = tangent * cosine;
        let (up, mut level) = (vector::<S>([0.0, 1.0, 0.0]), vector::<S>([0.6, 0.0, 0.8]));
        level = level * (1.0 / level.norm());
        Self { normal: up * cosine - level * sine, uphill: level * cosine + up * sine, sine, cosine }
    }

    /// A grain at rest on the slope, its contact bearing the weight and `hold` N uphill.
    fn grain(&self, known: &Known<S>, dt: f64, hold: f64) -> Few<S> {
        let mut few = Few::<S>::new(known.law, dt, 24.0 * RADIUS);
        few.settings.grains.field.gravity = vector::<S>([0.0, -GRAVITY, 0.0]);
        let shape = Shape::Plane { point: vector::<S>([0.0; 3]), normal: self.normal };
        few.bodies.push(Body::new("slope", shape));
        let overlap = (known.overlap)(MASS * GRAVITY * self.cosine);
        let normal = lanes(&self.normal);
        let held = S::tangential::<f64>(&normal, &lanes(&(self.uphill * hold)));
        let memory = (known.memory)(held);
        let row = few.add([0.0; 3], RADIUS, MASS);
        row.hot.position = self.normal * (RADIUS - overlap);
        (row.cold.home, row.cold.origin) = (row.hot.position, row.hot.position);
        row.contacts.push((body_partner(0), memory));
        few
    }
}

/// Spin that rolls with a velocity on a surface of this normal without slip: `n x v/r`.
fn rolling_spin<S: Space>(normal: &S::Vector, velocity: &S::Vector) -> S::Spin {
    S::moment(normal, velocity) * (1.0 / RADIUS)
}

/// Mean acceleration and spin-up over steps 200 to 1200.
fn rates<S: Space>(world: &mut GrainWorld<S>) -> (S::Vector, S::Spin) {
    steps(world, 200);
    let early = hot_of(world, 0);
    steps(world, 1000);
    let late = hot_of(world, 0);
    let per_second = 1.0 / (1000.0 * world.settings.grains.dt);
    ((late.velocity - early.velocity) * per_second, (late.spin - early.spin) * per_second)
}

/// `I/(m r^2)`.
fn inertia_share<S: Space>() -> f64 {
    S::grain_inertia(MASS, RADIUS) / (MASS * RADIUS * RADIUS)
}

/// `a = g sin/(1 + I/(m r (r - d/2)))`: friction acts at the middle of the overlap, surfaces slide with full radii.
fn rolls<S: Space>(known: &Known<S>, tangent: f64) {
    let slope = Slope::<S>::new(tangent);
    let overlap = (known.overlap)(MASS * GRAVITY * slope.cosine);
    let share = inertia_share::<S>() * RADIUS / (RADIUS - 0.5 * overlap);
    let wanted = GRAVITY * slope.sine / (1.0 + share);
    let friction = MASS * share * wanted;
    let mut world = slope.grain(known, 2e-7, friction).world();
    let (acceleration, spin_up) = rates(&mut world);
    let off = (acceleration + slope.uphill * wanted).norm() / wanted;
    let rolling = rolling_spin::<S>(&slope.normal, &acceleration);
    let slip = (spin_up - rolling).norm() / rolling.norm();
    println!("rolls at {tangent} in {}: acceleration off by {off:.1e}, slip {slip:.1e} under {:?}", S::NAME, known.law);
    println!("rolls on a slope in the {}: acceleration off by {off:.1e}, slip {slip:.1e}", S::NAME);
    assert!(off < 1e-8, "slope {tangent}: acceleration off by {off:e} under {:?} in {}", known.law, S::NAME);
    assert!(slip < 1e-8, "slope {tangent}: slip {slip:e} under {:?} in {}", known.law, S::NAME);
}

/// `a = g sin - (mu g cos + e_t/m)`, `dw/dt = (mu m g cos + e_t) (r - d/2)/I`.
fn slides<S: Space>(known: &Known<S>, tangent: f64) {
    let slope = Slope::<S>::new(tangent);
    let normal = MASS * GRAVITY * slope.cosine;
    let overlap = (known.overlap)(normal);
    let friction = known.friction * normal + known.shear_strength;
    let mut world = slope.grain(known, 2e-7, friction).world();
    let (acceleration, spin_up) = rates(&mut world);
    let wanted = GRAVITY * slope.sine - friction / MASS;
    let off = (acceleration + slope.uphill * wanted).norm() / wanted;
    let turn = S::moment(&slope.normal, &slope.uphill) * (-friction * (RADIUS - 0.5 * overlap));
    let turn = turn * (1.0 / S::grain_inertia(MASS, RADIUS));
    let turn_off = (spin_up - turn).norm() / turn.norm();
    println!("slides at {tangent} in {}: off by {off:.1e}, {turn_off:.1e} under {:?}", S::NAME, known.law);
    println!("slides on a slope in the {}: acceleration off by {off:.1e}, spin-up by {turn_off:.1e}", S::NAME);
    assert!(off < 1e-8, "slope {tangent}: acceleration off by {off:e} under {:?} in {}", known.law, S::NAME);
    assert!(turn_off < 1e-8, "slope {tangent}: spin-up off by {turn_off:e} under {:?} in {}", known.law, S::NAME);
}

/// Below `tan = mu (1 + m r^2/I)` a grain rolls, above it slides.
fn rolls_and_slides<S: Space>(known: &Known<S>) {
    let limit = known.friction * (1.0 + 1.0 / inertia_share::<S>());
    rolls(known, 0.3);
    rolls(known, 0.97 * limit);
    // Shear strength holds it on steeper slopes.
    slides(known, if known.shear_strength > 0.0 { 4.0 } else { 1.03 * limit });
}

/// A tangential spring beside a rolling one that is as long as it was.
fn rolled_freely<S: Space>(spring: S::TangentOf<f64>) -> Memory {
    let rolled: S::SpinOf<f64> = Words::zero();
    Memory::of(&(spring, rolled))
}

fn every_law<S: Space>() {
    rolls_and_slides::<S>(&Known {
        law: linear().into(),
        friction: 0.5,
        shear_strength: 0.0,
        overlap: Box::new(|force| force / linear().stiffness_normal),
        memory: Box::new(|force| Memory::of(&(force * (-1.0 / linear().stiffness_tangential)))),
    });
    let mut sticky = cohesive();
    (sticky.cohesion_normal, sticky.cohesion_tangential) = (1e-4, 2e-5);
    rolls_and_slides::<S>(&Known {
        law: sticky.into(),
        friction: 0.5,
        shear_strength: 2e-5,
        overlap: Box::new(move |force| force / sticky.linear.stiffness_normal),
        memory: Box::new(move |force| {
            Memory::of(&(force * (-1.0 / sticky.linear.stiffness_tangential), Components([1.0])))
        }),
    });
    let mut free = elastic();
    free.rolling_limit = 0.0;
    rolls_and_slides::<S>(&Known {
        law: free.into(),
        friction: 0.5,
        shear_strength: 0.0,
        overlap: Box::new(move |force| force / (2.0 * free.young_modulus * RADIUS)),
        memory: Box::new(move |force| {
            let stiffness = free.stiffness_ratio * 2.0 * free.young_modulus * RADIUS;
            rolled_freely::<S>(force * (-1.0 / stiffness))
        }),
    });
    rolls_and_slides::<S>(&Known {
        law: hertz().into(),
        friction: 0.5,
        shear_strength: 0.0,
        overlap: Box::new(|force| {
            let law = hertz();
            let stiffness = std::f64::consts::SQRT_2 * law.shear_modulus * (2.0 * RADIUS).sqrt();
            let softness = force / (2.0 / 3.0 * stiffness / (1.0 - law.poisson_ratio));
            math::cbrt(softness * softness)
        }),
        memory: Box::new(|force| Memory::of(&force)),
    });
}

#[test]
fn a_disc_rolls_below_its_friction_limit_and_slides_above_it() {
    every_law::<Plane>();
}

#[test]
fn a_sphere_rolls_below_its_friction_limit_and_slides_above_it() {
    every_law::<Solid>();
}

/// On the level the resistance `eta r m g` takes `dv/dt = -eta g/(1 + I/(m r^2))` from a rolling grain, which equilibrates
/// after `v^2 (1 + I/(m r^2))/(2 eta g)` and stays there.
fn comes_to_rest<S: Space>() {
    let mut law = elastic();
    (law.young_modulus, law.rolling_limit) = (3.5e8, 0.3);
    let known = Known::<S> {
        law: law.into(),
        friction: 0.5,
        shear_strength: 0.0,
        overlap: Box::new(move |force| force / (2.0 * law.young_modulus * RADIUS)),
        memory: Box::new(|_| rolled_freely::<S>(Words::zero())),
    };
    let level = Slope::<S>::new(0.0);
    let speed = 0.02;
    let mut few = level.grain(&known, 1e-6, 0.0);
    let velocity = level.uphill * speed;
    few.grains[0].hot.velocity = velocity;
    few.grains[0].hot.spin = rolling_spin::<S>(&level.normal, &velocity);
    let start = few.grains[0].hot.position;
    let mut world = few.world();
    let slowing = law.rolling_limit * GRAVITY / (1.0 + inertia_share::<S>());
    let duration = speed / slowing;
    let total = (duration / 1e-6).round() as usize;
    steps(&mut world, total / 2);
    let half = hot_of(&world, 0).velocity.dot(&level.uphill) / speed;
    steps(&mut world, total / 2 + 200);
    let stopped = (hot_of(&world, 0).position - start).dot(&level.uphill);
    steps(&mut world, 2000);
    let later = hot_of(&world, 0);
    let wanted = speed * speed / (2.0 * slowing);
    println!("rolling to rest in {}: {stopped:e} m of {wanted:e} m, half-way at {half}", S::NAME);
    assert!((half - 0.5).abs() < 1e-3, "half-way it has {half} of its speed");
    println!("rolls to rest in the {}: distance off by {:.1e}", S::NAME, stopped / wanted - 1.0);
    assert!((stopped / wanted - 1.0).abs() < 1e-4, "it stopped after {stopped} m, not {wanted} m");
    let crept = ((later.position - start).dot(&level.uphill) - stopped).abs();
    assert!(crept < 1e-4 * wanted && later.velocity.norm() < 5e-3 * speed, "it crept on by {crept} m");
}

#[test]
fn rolling_resistance_brings_grains_to_rest() {
    comes_to_rest::<Plane>();
    comes_to_rest::<Solid>();
}
