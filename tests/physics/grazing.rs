//! A grain that strikes a fixed wall at many angles and with many spins leaves with no more energy than it came with, under every
//! law: codes are known to gain some at grazing angles, where the contact unloads while its tangential spring is stretched.

use scree::base::math;
use scree::base::space::{Plane, Solid, Space};
use scree::bodies::body::{Body, Shape};
use scree::law::contact::{Contact, TangentialForce};

use crate::few::{Few, GrainWorld, MASS, RADIUS, cohesive, elastic, hertz, linear, spin, steps, vector};

/// m/s.
const SPEED: f64 = 0.3;
/// About what a contact lasts under every law here, s.
const DURATION: f64 = 1.2e-5;
/// Between the path and the wall, degrees.
const ANGLES: [f64; 8] = [1.0, 2.0, 5.0, 15.0, 30.0, 60.0, 75.0, 90.0];
/// Speed of the surface by the spin, over that of the grain: about the axis it would roll about, its path and the normal.
const SPINS: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [0.3, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [-4.0, 0.0, 0.0],
    [0.5, 1.0, -0.5],
    [-0.5, 0.0, 2.0],
];
/// A contact begins and ends within a step: the share of the energy that this makes or takes is at most this over the square of
/// the steps of a contact.
const OF_STEPS: f64 = 5.0;
/// Spheres under Hertz' law that hardly slide gain this at most whatever the step where the tangential force is the sum of its
/// increments: it is kept while its stiffness falls with the overlap, and what is stored in it grows (Elata & Berryman 1996).
/// Friction of 0.5 leaves 5e-8.
const OF_INCREMENTS: f64 = 3e-4;

/// Kinetic and elastic energy after over that before, less one.
fn gain<S: Space>(law: Contact, degrees: f64, turns: [f64; 3], dt: f64) -> f64 {
    let angle = degrees * math::PI / 180.0;
    let (along, normal) = (vector::<S>([1.0, 0.0, 0.0]), vector::<S>([0.0, 1.0, 0.0]));
    let mut few = Few::<S>::new(law, dt, 64.0 * RADIUS);
    few.bodies.push(Body::new("wall", Shape::Plane { point: vector::<S>([0.0; 3]), normal }));
    let gap = 1e-9;
    let hot = &mut few.add([0.0, RADIUS + gap, 0.0], RADIUS, MASS).hot;
    hot.velocity = (along * math::cos(angle) - normal * math::sin(angle)) * SPEED;
    hot.spin = spin::<S>([turns[1], turns[2], turns[0]]) * (SPEED / RADIUS);
    let energy = |world: &mut GrainWorld<S>| {
        let found = world.energies().unwrap();
        found.kinetic_grains + found.elastic_grains
    };
    let mut world = few.world();
    let before = energy(&mut world);
    let coming = gap / (SPEED * math::sin(angle));
    steps(&mut world, ((coming + 4.0 * DURATION) / dt) as usize);
    energy(&mut world) / before - 1.0
}

/// The most that is gained over all angles and spins is at most what the steps of a contact make, and `more`.
fn gains_nothing<S: Space>(law: impl Into<Contact>, steps_of_contact: f64, more: f64) {
    let law = law.into();
    let cases = ANGLES.into_iter().flat_map(|degrees| SPINS.map(|turns| (degrees, turns)));
    let gains =
        cases.map(|(degrees, turns)| (gain::<S>(law, degrees, turns, DURATION / steps_of_contact), degrees, turns));
    let (most, degrees, turns) = gains.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    let what = format!("{most:+.1e} at {degrees} degrees with {turns:?} in the {}: {law:?}", S::NAME);
    println!("{steps_of_contact} steps a contact: {what}");
    assert!(most < OF_STEPS / (steps_of_contact * steps_of_contact) + more, "{what}");
}

/// Without dashpots, with friction from little to more than a contact can use, and with dashpots.
fn under_every_law<S: Space>() {
    for (damping, friction, steps_of_contact) in
        [(0.0, 0.1, 200.0), (0.0, 0.5, 200.0), (0.0, 0.5, 400.0), (0.0, 5.0, 400.0), (2.0, 0.5, 200.0)]
    {
        let mut law = linear();
        law.friction = friction;
        (law.damping_normal, law.damping_tangential) = (damping, damping);
        gains_nothing::<S>(law, steps_of_contact, 0.0);
        let mut sticky = cohesive();
        sticky.linear = law;
        gains_nothing::<S>(sticky, steps_of_contact, 0.0);
        let mut law = hertz();
        law.friction = friction;
        (law.damping_normal, law.damping_tangential) = (damping, damping);
        gains_nothing::<S>(law, steps_of_contact, if friction > 1.0 { OF_INCREMENTS } else { 0.0 });
        law.tangential_force = TangentialForce::Rescaled;
        gains_nothing::<S>(law, steps_of_contact, 0.0);
        let mut law = elastic();
        law.friction = friction;
        gains_nothing::<S>(law, steps_of_contact, 0.0);
        law.rolling_limit = 0.0;
        gains_nothing::<S>(law, steps_of_contact, 0.0);
    }
}

#[test]
fn discs_gain_no_energy_at_a_wall() {
    under_every_law::<Plane>();
}

#[test]
fn spheres_gain_no_energy_at_a_wall() {
    under_every_law::<Solid>();
}
