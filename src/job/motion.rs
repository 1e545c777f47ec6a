//! How bodies move: along a path, with a sine, or under a servo.

use super::schema::list;
use crate::base::keys::{
    DAMPING, FORCE, Form, LENGTH, MASS, NOT_NEGATIVE, POSITIVE, RATIO, SPEED, STRESS, TIME, Wants, key, number, vector,
};
use crate::base::math::PI;
use crate::base::units::Dimension;

/// How a body moves: along a path, and under stress control in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Velocity (m/s) and spin (rad/s) at given times (s), linear in between, the last kept on; empty: at rest.
    pub path: Vec<PathPoint>,
    /// Added to it.
    pub oscillation: Option<Oscillation>,
    /// Sets the speed along its direction, which the path leaves to it; none: no stress control.
    pub servo: Option<BodyServo>,
}

impl Motion {
    /// Either a path, or one velocity and spin with their ramp; and the servo.
    pub(super) fn keys(&mut self, form: &mut dyn Form) {
        let (mut velocity, mut spin, mut ramp) = (None, None, None);
        form.vector_if_given(&mut velocity, vector("velocity", "the velocity", SPEED, "\"1 cm/s\"").optional());
        form.spin_if_given(&mut spin, key("spin", "the angular velocity", Wants::Spin, "\"3 rad/s\"").optional());
        let about = "the time over which velocity and spin rise from zero";
        form.number_if_given(&mut ramp, number("ramp", about, TIME, NOT_NEGATIVE, "\"10 ms\"").optional());
        if form.has("path") {
            if let Some(key) = ["velocity", "spin", "ramp"].into_iter().find(|key| form.has(key)) {
                form.note(key, "stands beside body.path, and each says how the body moves. Keep one of them.");
            }
        } else if velocity.is_some() || spin.is_some() {
            self.path =
                PathPoint::rising_to(velocity.unwrap_or_default(), spin.unwrap_or_default(), ramp.unwrap_or(0.0));
        } else if ramp.is_some() {
            form.note("ramp", "has nothing to raise: add velocity or spin, or remove the line.");
        }
        let about = "velocity and spin at given times, linear in between, the last kept on; in place of velocity, spin and ramp";
        let path = key("path", about, Wants::Text, "[{time = 0, velocity = [0, 0]}]").optional();
        list(form, &mut self.path, path, "velocity and spin at a time", &PathPoint::BLANK, PathPoint::keys);
        let oscillation = key(
            "oscillation",
            "a sine that is added to its way",
            Wants::Text,
            "{amplitude = [\"0.1 mm\", 0], frequency = \"10e3 1/s\"}",
        );
        let mut sine = self.oscillation.unwrap_or(Oscillation::BLANK);
        let about = "amplitude sin(2 pi frequency t), added to the displacement of a body";
        let swings = form.table(self.oscillation.is_some(), oscillation.optional(), about, &mut |form| sine.keys(form));
        self.oscillation = swings.then_some(sine);
        let example = "{direction = [0, 1], force = \"5 N\", mass = \"10 g\", speed_max = \"1 cm/s\"}";
        let servo = key("servo", "the force or stress that the body is held at", Wants::Text, example).optional();
        let mut held = self.servo.unwrap_or(BodyServo::BLANK);
        let about = "the force or stress that a body is held at";
        let is_held = form.table(self.servo.is_some(), servo, about, &mut |form| held.keys(form));
        self.servo = is_held.then_some(held);
    }
}

/// `amplitude sin(2 pi frequency t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// m.
    pub amplitude: [f64; 3],
    /// 1/s.
    pub frequency: f64,
}

impl Oscillation {
    const BLANK: Self = Self { amplitude: [0.0; 3], frequency: 0.0 };

    fn keys(&mut self, form: &mut dyn Form) {
        form.vector(&mut self.amplitude, vector("amplitude", "the farthest that it goes", LENGTH, "\"0.1 mm\""));
        let about = "how often it goes there and back";
        form.number(&mut self.frequency, number("frequency", about, Dimension::RATE, POSITIVE, "\"10e3 1/s\""));
    }

    /// The fastest that it is, m/s.
    pub fn speed(&self) -> f64 {
        let square: f64 = self.amplitude.iter().map(|component| component * component).sum();
        2.0 * PI * self.frequency * square.sqrt()
    }
}

/// Velocity and spin of a body at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Simulated time, s.
    pub time: f64,
    /// m/s.
    pub velocity: [f64; 3],
    /// rad/s; in the plane about z alone.
    pub spin: [f64; 3],
}

impl PathPoint {
    const BLANK: Self = Self { time: 0.0, velocity: [0.0; 3], spin: [0.0; 3] };

    fn keys(&mut self, form: &mut dyn Form) {
        form.number(&mut self.time, number("time", "the time", TIME, NOT_NEGATIVE, "\"10 ms\""));
        form.vector(&mut self.velocity, vector("velocity", "the velocity", SPEED, "\"1 cm/s\"").follows("none"));
        form.spin(&mut self.spin, key("spin", "the angular velocity", Wants::Spin, "\"3 rad/s\"").follows("none"));
    }

    /// One velocity and spin, which rise from zero over `ramp`, s.
    pub(super) fn rising_to(velocity: [f64; 3], spin: [f64; 3], ramp: f64) -> Vec<Self> {
        let full = Self { time: ramp, velocity, spin };
        match ramp > 0.0 {
            true => vec![Self::BLANK, full],
            false => vec![full],
        }
    }
}

/// M dv/dt = f.n - F - damping v, with v the speed along the unit `direction` and F the force that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyServo {
    /// Direction in which the grains push the body.
    pub direction: [f64; 3],
    /// Force of the grains along `direction` that is to be kept, N.
    pub force: f64,
    /// kg.
    pub mass: f64,
    /// N s/m.
    pub damping: f64,
    /// Of the speed along `direction`, either way, m/s.
    pub speed_max: f64,
}

impl BodyServo {
    const BLANK: Self = Self { direction: [0.0; 3], force: 0.0, mass: 0.0, damping: 0.0, speed_max: 0.0 };

    fn keys(&mut self, form: &mut dyn Form) {
        form.vector(&mut self.direction, vector("direction", "the direction in which the grains push the body, from them into it; the servo pushes the other way. [0, 1] for a lid that presses down", RATIO, "[0, 1]"));
        let about = "the force of the grains on the body along that direction, which is kept";
        let force = number("force", about, FORCE, NOT_NEGATIVE, "\"5 N\"").required("unless stress and area are given");
        let stress =
            number("stress", "the force over the area, in place of force", STRESS, NOT_NEGATIVE, "\"100 kPa\"")
                .required("unless force is given");
        let area = number("area", "the area of stress", Dimension::AREA, POSITIVE, "\"4 cm2\"").required("with stress");
        let by_stress = form.has("stress") || form.has("area");
        if by_stress && form.has("force") {
            let problem = "stands beside a stress or an area, and each says what the body is held at. Keep force, or stress and area.";
            form.note("force", problem);
        }
        if by_stress || form.describes() {
            let (mut pressure, mut over) = (0.0, 0.0);
            form.number(&mut pressure, stress);
            form.number(&mut over, area);
            self.force = pressure * over;
        }
        if !by_stress {
            form.number(&mut self.force, force);
        }
        form.number(&mut self.mass, number("mass", "the mass that the servo moves", MASS, POSITIVE, "\"10 g\""));
        let damping = number("damping", "damping of that motion", DAMPING, NOT_NEGATIVE, "\"10 N s/m\"");
        form.number(&mut self.damping, damping.or("0.0"));
        let speed = "the largest speed along that direction";
        form.number(&mut self.speed_max, number("speed_max", speed, SPEED, POSITIVE, "\"1 cm/s\""));
    }
}
