//! Plates: rigid bodies that hold grains glued to them and the nodes beyond their face.

use crate::record::{Record, Visitor};
use crate::space::{Linear, Space};

/// What moves a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    Fixed,
    /// Horizontal speed by a ramp, vertical motion by a servo that keeps the normal stress: the plate is a mass with a
    /// dashpot, `M dv/dt = F_y - stress*area - damping*v`, with a limit on its speed.
    Servo {
        /// Pa, compression positive.
        stress: f64,
        /// m2.
        area: f64,
        /// m/s, reached after `ramp` seconds.
        speed: f64,
        ramp: f64,
        /// kg and N s/m.
        mass: f64,
        damping: f64,
        /// m/s, vertical.
        speed_max: f64,
    },
}

/// Which side of its face a plate is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Below,
    Above,
}

/// A plate and its motion; the same on every rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate<S: Space> {
    pub drive: Drive,
    pub side: Side,
    /// y of the face that bounds the material, m.
    pub face: f64,
    pub displacement: S::Vector,
    pub velocity: S::Vector,
    /// Impulse of the material on the plate since the last row of the series, N s.
    pub impulse: S::Vector,
}

/// What the material does to a plate within a step: forces of glued grains, and the nodes that the plate holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burden<S: Space> {
    /// N.
    pub grain_force: S::Vector,
    /// kg.
    pub node_mass: f64,
    /// N s, with the forces of this step.
    pub node_momentum: S::Vector,
}

impl<S: Space> Plate<S> {
    pub fn new(drive: Drive, side: Side, face: f64) -> Self {
        let zero = S::Vector::zero();
        Self { drive, side, face, displacement: zero, velocity: zero, impulse: zero }
    }

    /// Goes on from another plate's state of motion.
    pub fn take_motion_of(&mut self, other: &Self) {
        (self.face, self.displacement) = (other.face, other.displacement);
        (self.velocity, self.impulse) = (other.velocity, other.impulse);
    }

    /// Whether a node at height `y` moves with the plate: nodes beyond the face, and the one nearest to it.
    pub fn holds(&self, y: f64, cell: f64) -> bool {
        match self.side {
            Side::Below => y <= self.face + 0.5 * cell,
            Side::Above => y >= self.face - 0.5 * cell,
        }
    }

    /// New velocity under `burden`, and the impulse that the material gave. The held nodes are part of the moving mass,
    /// so that a light plate on a heavy continuum is stable.
    pub fn accelerate(&mut self, burden: &Burden<S>, time: f64, dt: f64) {
        if let Drive::Servo { stress, area, speed, ramp, mass, damping, speed_max } = self.drive {
            let share = if ramp > 0.0 { (time / ramp).min(1.0) } else { 1.0 };
            self.velocity[0] = speed * share;
            let load = burden.grain_force[1] - stress * area;
            // The dashpot is implicit in the new velocity: stable for any damping.
            let vertical = (mass * self.velocity[1] + burden.node_momentum[1] + load * dt)
                / (mass + burden.node_mass + damping * dt);
            self.velocity[1] = vertical.clamp(-speed_max, speed_max);
        }
        self.impulse += burden.grain_force * dt + burden.node_momentum - self.velocity * burden.node_mass;
    }

    pub fn drift(&mut self, dt: f64) {
        self.displacement += self.velocity * dt;
        self.face += self.velocity[1] * dt;
    }
}

/// The moving state; drive and side belong to the scenario.
impl<S: Space> Record for Plate<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("face", std::slice::from_mut(&mut self.face));
        visitor.f64s("displacement", self.displacement.as_mut_slice());
        visitor.f64s("velocity", self.velocity.as_mut_slice());
        visitor.f64s("impulse", self.impulse.as_mut_slice());
    }
}

impl<S: Space> crate::transfer::Cargo for Plate<S> {
    fn blank() -> Self {
        Self::new(Drive::Fixed, Side::Below, 0.0)
    }
}
