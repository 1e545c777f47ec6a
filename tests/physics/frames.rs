//! Frame indifference: a loaded contact carried along by a rigid motion keeps its force in the frame that moves with it.
//!
//! Surfaces slide with full radii, so that a rigid turn of a pair that overlaps by d counts as sliding by d per radian, as in
//! LAMMPS: the spring is known to lose `d e x n` per radian about the axis e. That share is part of what is expected here.

use scree::base::ids::GrainId;
use scree::base::math;
use scree::base::space::{Components, Linear, Plane, Solid, Space, Words};
use scree::dem::grains::lanes;
use scree::law::contact::{Contact, Memory, Sliding};

use crate::few::{Few, RADIUS, cohesive, elastic, hertz, linear, row_of, spin, steps, vector};

const OVERLAP: f64 = 1e-6;
/// The tangential force that the contact starts with, N, and the resistance to rolling, N m.
const FORCE: f64 = 0.5;
const MOMENT: f64 = 1e-4;

/// Memory of a contact that holds a tangential force and a moment.
type Holding<S> = Box<dyn Fn(<S as Space>::TangentOf<f64>, <S as Space>::SpinOf<f64>) -> Memory>;

/// A law and what is known of its contact at [`OVERLAP`].
struct Known<S: Space> {
    law: Contact,
    stiffness_tangential: f64,
    memory: Holding<S>,
    /// Whether it resists rolling.
    rolling: bool,
    /// Whether turning counts as no sliding, but lengthens the spring.
    lengthens: bool,
}

/// Turns by an angle about a unit axis: Rodrigues' formula, written with what a space has.
fn turned<S: Space>(vector: &S::Vector, axis: &S::Spin, angle: f64) -> S::Vector {
    let once = S::cross(axis, vector);
    let twice = S::cross(axis, &once);
    *vector + once * math::sin(angle) + twice * (1.0 - math::cos(angle))
}

/// The same for a moment: in the plane it stays what it is.
fn turned_spin<S: Space>(spin: &S::Spin, axis: &S::Spin, angle: f64) -> S::Spin {
    if S::DIMENSION == 2 {
        return *spin;
    }
    // In space a spin is a vector with the same components.
    let mut as_vector = S::Vector::zero();
    for component in 0..S::DIMENSION {
        as_vector[component] = spin[component];
    }
    let vector = turned::<S>(&as_vector, axis, angle);
    let mut spin = S::Spin::zero();
    for component in 0..S::DIMENSION {
        spin[component] = vector[component];
    }
    spin
}

/// Largest error of force and torque, as shares of [`FORCE`] and of its torque, over one radian about `axis` in `count`
/// steps.
fn errors<S: Space>(known: &Known<S>, axis: [f64; 3], count: u32) -> [f64; 2] {
    let dt = 1e-6;
    let angle_step = 1.0 / f64::from(count);
    let axis = spin::<S>(axis);
    let axis = axis * (1.0 / axis.norm());
    let distance = 2.0 * RADIUS - OVERLAP;
    let normal = vector::<S>([0.6, 0.64, 0.48]);
    let normal = normal * (1.0 / normal.norm());
    let across = vector::<S>([-0.7, 0.2, 0.9]);
    let across = across - normal * across.dot(&normal);
    let tangential = across * (FORCE / across.norm());
    let moment = match known.rolling {
        true => S::moment(&normal, &tangential) * (MOMENT / FORCE),
        false => S::Spin::zero(),
    };

    // So heavy that no force moves them.
    let mut few = Few::<S>::new(known.law, dt, 40.0 * RADIUS);
    let start = normal * (0.5 * distance);
    for (side, partner) in [(1.0, 1), (-1.0, 0)] {
        let row = few.add([0.0; 3], RADIUS, 1e20);
        row.hot.position = start * side;
        row.cold.home = row.hot.position;
        let held = S::tangential::<f64>(&lanes(&normal), &lanes(&tangential));
        row.contacts.push((GrainId(partner), (known.memory)(held, lanes(&moment))));
    }
    let mut world = few.world();
    let drift = vector::<S>([0.4, -0.3, 0.2]);
    let rate = axis * (angle_step / dt);
    let mut worst = [0.0f64; 2];
    let mut pressing = 0.0;
    for step in 0..=count {
        let angle = f64::from(step) * angle_step;
        let arm = turned::<S>(&start, &axis, angle);
        for (id, side) in [(0, 1.0), (1, -1.0)] {
            let row = row_of(&world, id);
            let hot = &mut world.assembly.grains.hot[row];
            hot.position = arm * side + drift * (f64::from(step) * dt);
            hot.velocity = S::cross(&rate, &(arm * side)) + drift;
            hot.spin = rate;
        }
        let row = row_of(&world, 0);
        let rebuilds = world.rebuilds;
        steps(&mut world, 1);
        if world.rebuilds != rebuilds {
            continue;
        }
        let (force, torque) = (world.assembly.grains.force[row], world.assembly.grains.torque[row]);
        if step == 0 {
            pressing = force.dot(&normal);
        }
        let slid = if known.lengthens { 0.0 } else { known.stiffness_tangential * OVERLAP * angle };
        let mut held = tangential + S::cross(&axis, &normal) * slid;
        if known.lengthens {
            held = held * power(1.0 + 0.5 * angle_step * angle_step, step);
        }
        let wanted = turned::<S>(&(held + normal * pressing), &axis, angle);
        let lever = RADIUS - 0.5 * OVERLAP;
        let wanted_torque = moment - S::moment(&normal, &held) * lever;
        let wanted_torque = turned_spin::<S>(&wanted_torque, &axis, angle);
        worst[0] = worst[0].max((force - wanted).norm() / FORCE);
        worst[1] = worst[1].max((torque - wanted_torque).norm() / (FORCE * RADIUS));
    }
    worst
}

fn power(base: f64, exponent: u32) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * base)
}

fn every_law<S: Space>(check: impl Check<S>) {
    let mut plain = linear();
    (plain.friction, plain.damping_normal, plain.damping_tangential) = (1e3, 0.0, 0.0);
    check.of(&Known {
        law: plain.into(),
        stiffness_tangential: plain.stiffness_tangential,
        memory: Box::new(move |force, _| Memory::of(&(force * (-1.0 / plain.stiffness_tangential)))),
        rolling: false,
        lengthens: false,
    });
    let mut sticky = cohesive();
    sticky.linear = plain;
    check.of(&Known {
        law: sticky.into(),
        stiffness_tangential: plain.stiffness_tangential,
        memory: Box::new(move |force, _| Memory::of(&(force * (-1.0 / plain.stiffness_tangential), Components([1.0])))),
        rolling: false,
        lengthens: false,
    });
    let mut rolling = elastic();
    (rolling.friction, rolling.rolling_limit, rolling.sliding) = (1e3, 1e3, Sliding::Surface);
    check.of(&Known {
        law: rolling.into(),
        stiffness_tangential: 0.8 * rolling.young_modulus * RADIUS,
        memory: Box::new(move |force, moment| {
            let stiffness = rolling.stiffness_ratio * rolling.young_modulus * RADIUS;
            Memory::of(&(force * (-1.0 / stiffness), moment * (-1.0 / (stiffness * RADIUS * RADIUS))))
        }),
        rolling: true,
        lengthens: false,
    });
    let mut ball = hertz();
    (ball.friction, ball.damping_normal, ball.damping_tangential) = (1e3, 0.0, 0.0);
    let root = (RADIUS * OVERLAP).sqrt();
    check.of(&Known {
        law: ball.into(),
        stiffness_tangential: 2.0 * std::f64::consts::SQRT_2 * ball.shear_modulus * root / (2.0 - ball.poisson_ratio),
        memory: Box::new(|force, _| Memory::of(&force)),
        rolling: false,
        lengthens: false,
    });
}

/// What is asked of every law.
trait Check<S: Space> {
    fn of(&self, known: &Known<S>);
}

struct Exact;

impl Check<Plane> for Exact {
    fn of(&self, known: &Known<Plane>) {
        for axis in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            let errors = errors(known, axis, 500);
            println!("a contact carried by a rotation: force and torque off by {errors:?}");
            assert!(
                errors.iter().all(|error| *error < 1e-9),
                "force and torque off by {errors:?} under {:?}",
                known.law
            );
        }
    }
}

#[test]
fn a_loaded_contact_of_discs_turns_with_its_grains() {
    every_law::<Plane>(Exact);
}

/// A law that scales what slides feels no sliding in a rigid turn; its springs, turned to first order, get longer by half the
/// square of each step's angle, and by nothing else.
#[test]
fn a_scaled_spring_of_discs_lengthens_by_half_the_square_of_each_angle() {
    let mut law = elastic();
    (law.friction, law.rolling_limit, law.sliding) = (1e3, 1e3, Sliding::Scaled);
    let known = Known::<Plane> {
        law: law.into(),
        stiffness_tangential: 0.0,
        memory: Box::new(move |force, _| {
            let stiffness = law.stiffness_ratio * law.young_modulus * RADIUS;
            let rolled = <<Plane as Space>::SpinOf<f64> as Words<f64>>::zero();
            Memory::of(&(force * (-1.0 / stiffness), rolled))
        }),
        rolling: false,
        lengthens: true,
    };
    for count in [100, 1000] {
        let errors = errors(&known, [0.0, 0.0, 1.0], count);
        assert!(errors.iter().all(|error| *error < 1e-9), "force and torque off by {errors:?}");
    }
}

/// About the normal, about a tangent, and about an axis of no kind.
const AXES: [[f64; 3]; 3] = [[0.6, 0.64, 0.48], [-0.64, 0.6, 0.0], [0.3, -0.5, 0.9]];

struct Converges;

impl Check<Solid> for Converges {
    fn of(&self, known: &Known<Solid>) {
        for axis in AXES {
            let [coarse, middle, fine] = [100, 200, 400].map(|count| errors(known, axis, count));
            for which in 0..2 {
                let ways = [coarse[which], middle[which], fine[which]];
                println!("{axis:?}: {:?}", ways.map(|off| format!("{off:.1e}")));
                assert!(ways[0] < 0.05, "axis {axis:?}: off by {ways:?} under {:?}", known.law);
                let shrinks = ways.windows(2).all(|pair| pair[1] < 0.6 * pair[0] || pair[1] < 1e-9);
                assert!(shrinks, "axis {axis:?}: off by {ways:?} under {:?}", known.law);
            }
        }
    }
}

/// In space the spring is laid into the tangent plane anew at each step: what is wrong goes with the step's angle.
#[test]
fn a_loaded_contact_of_spheres_turns_with_its_grains_the_better_the_smaller_the_steps() {
    every_law::<Solid>(Converges);
}
