//! Rigid bodies among the material: what they are, what moves them, and what the material does to them. The same on every
//! rank.

use crate::base::math::{PI, cos, sin};
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::bodies::boundary::Grip;

/// Bodies that a world can have.
pub const BODIES_MAX: usize = 8;

/// Which side of its face a plate is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// It is below its face, the material above.
    Below,
    /// It is above its face, the material below.
    Above,
}

/// Where a body is at time zero; it moves on by its displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<S: Space> {
    /// A rough plate across the domain: grains glued to it, and the nodes beyond its face. `face` is y of the face, m.
    Plate {
        /// Whether it is below or above its face.
        side: Side,
        /// y at time zero, m.
        face: f64,
    },
    /// Grains glued together; nothing else.
    Layer,
    /// The half space behind a plane through `point`; the unit `normal` points to the grains.
    Plane {
        /// On it, m; the body turns about it.
        point: S::Vector,
        /// Unit, to the grains.
        normal: S::Vector,
    },
    /// A solid box with edges along the axes.
    Box {
        /// Corner, m.
        lower: S::Vector,
        /// Corner, m.
        upper: S::Vector,
    },
    /// A solid cylinder without end about the unit `axis` (in the plane a disc, its axis zero).
    Cylinder {
        /// On the axis, m.
        centre: S::Vector,
        /// Unit; zero in the plane.
        axis: S::Vector,
        /// m.
        radius: f64,
    },
}

/// Velocity (m/s) and spin (rad/s) at a time, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<S: Space> {
    /// s.
    pub time: f64,
    /// Of the body's origin, m/s.
    pub velocity: S::Vector,
    /// About the origin, rad/s; in the plane counterclockwise.
    pub spin: S::Spin,
}

/// `M dv/dt = f.n - force - damping v` for the speed v along `direction`, with a limit on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo<S: Space> {
    /// Unit vector in which the material pushes the body.
    pub direction: S::Vector,
    /// Force of the material along it that is to be kept, N.
    pub force: f64,
    /// kg, N s/m, m/s.
    pub mass: f64,
    /// Of the dashpot on v, N s/m.
    pub damping: f64,
    /// The most that |v| may be, m/s.
    pub speed_max: f64,
}

/// A body and its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<S: Space> {
    /// As the job or a preparation gives it; columns of the series begin with it.
    pub name: String,
    /// With its place at time zero.
    pub shape: Shape<S>,
    /// In the order of time, linear in between, the last kept on; empty: at rest.
    pub path: Vec<Instant<S>>,
    /// Amplitude (m) and frequency (1/s) of a sine that is added to the way along the path.
    pub oscillation: Option<(S::Vector, f64)>,
    /// What moves it along one direction by the force on it; none where the path alone does.
    pub servo: Option<Servo<S>>,
    /// How it holds the nodes or points of a continuum that it meets, and whether what moves away is let go; none where it touches
    /// grains alone.
    pub grip: Option<(Grip, bool)>,
    /// Whether it meets material points at its own face ([`crate::mpm::faces`]); else it holds the nodes that lie in it.
    pub meets_points: bool,
    /// The part of a mesh's surface that is fastened to it, whatever its place; in the sense of its grip.
    pub side: Option<MeshSide>,
    /// From its place at time zero, m.
    pub displacement: S::Vector,
    /// Of its origin, m/s.
    pub velocity: S::Vector,
    /// About its origin, rad/s; in the plane counterclockwise.
    pub spin: S::Spin,
    /// Means of velocity and spin on either side of the forces of a step, by which these do work, m/s and rad/s; made within it.
    pub velocity_mean: S::Vector,
    /// rad/s.
    pub spin_mean: S::Spin,
    /// Impulse (N s) and angular impulse about the body's own origin (N m s) of the material on the body since the last row
    /// of the series.
    pub impulse: S::Vector,
    /// N m s, about the body's own origin.
    pub impulse_angular: S::Spin,
    /// Impulse of the material on the body since the start, N s.
    pub impulse_whole: S::Vector,
    /// Work that the body has done on the material since the start, J.
    pub work: f64,
}

/// A part of the surface of a mesh at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshSide {
    /// A face of the box around it.
    Face {
        /// That it is across, 0 to 2.
        axis: usize,
        /// Whether it is the one at the larger coordinate.
        upper: bool,
    },
    /// Sides of elements in physical groups of its file, a bit for each.
    Groups(u32),
}

impl MeshSide {
    /// Bits by which nodes know what they are on: six of faces, behind them those of groups, and then six of faces that they have given up.
    pub fn bits(self) -> u64 {
        match self {
            Self::Face { axis, upper } => 1 << (2 * axis + usize::from(upper)),
            Self::Groups(groups) => u64::from(groups) << 6,
        }
    }

    /// The bit of a face that a node has given up, since a body that it is fastened to holds it there.
    pub fn given_up(axis: usize, upper: bool) -> u64 {
        Self::Face { axis, upper }.bits() << 38
    }

    /// Whether a node is on it that knows its sides by these bits.
    pub fn has(self, sides: u64) -> bool {
        sides & self.bits() != 0
    }
}

/// What the material does to a body within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction<S: Space> {
    /// Of grains, glued or touching, N and N m about the body's origin.
    pub force: S::Vector,
    /// N m, about the body's origin.
    pub torque: S::Spin,
    /// Share of the step by which the force moves grains: a half in the first of a run, whose velocities are of time zero.
    pub kick: f64,
    /// Of the nodes that the body holds, kg and, with the forces of this step, N s.
    pub node_mass: f64,
    /// Of the same nodes, with the forces of this step, N s.
    pub node_momentum: S::Vector,
    /// What a servo did not foresee of the impulse along it in the steps before, N s.
    pub unforeseen: f64,
}

impl<S: Space> Reaction<S> {
    /// Impulse within a step `dt`, s, of a body of that velocity after it, N s.
    pub fn impulse(&self, velocity: &S::Vector, dt: f64) -> S::Vector {
        self.force * dt + self.node_momentum - *velocity * self.node_mass
    }
}

/// The point of a body's surface nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest<S: Space> {
    /// On the surface, m.
    pub point: S::Vector,
    /// Unit, from the body to the place.
    pub normal: S::Vector,
    /// Distance, m; negative inside.
    pub distance: f64,
    /// Radius of the surface there, m; [`crate::law::contact::FLAT`] where it has none.
    pub radius: f64,
}

impl<S: Space> Body<S> {
    /// At rest.
    pub fn new(name: &str, shape: Shape<S>) -> Self {
        let zero = S::Vector::zero();
        Self {
            name: name.to_string(),
            shape,
            path: Vec::new(),
            oscillation: None,
            servo: None,
            grip: None,
            meets_points: false,
            side: None,
            displacement: zero,
            velocity: zero,
            spin: S::Spin::zero(),
            velocity_mean: zero,
            spin_mean: S::Spin::zero(),
            impulse: zero,
            impulse_angular: S::Spin::zero(),
            impulse_whole: zero,
            work: 0.0,
        }
    }

    /// Goes on from another body's state of motion.
    pub fn take_motion_of(&mut self, other: &Self) {
        self.displacement = other.displacement;
        (self.velocity, self.spin) = (other.velocity, other.spin);
        (self.impulse, self.impulse_angular) = (other.impulse, other.impulse_angular);
        (self.impulse_whole, self.work) = (other.impulse_whole, other.work);
    }

    /// y of a plate's face now, m; of other shapes zero.
    pub fn face(&self) -> f64 {
        match self.shape {
            Shape::Plate { face, .. } => face + self.displacement[1],
            _ => 0.0,
        }
    }

    /// How it acts on points at its face, where it meets them there: a plate is rough and lets nothing go.
    pub fn acts_on_points(&self) -> Option<(Grip, bool)> {
        match self.shape {
            _ if !self.meets_points => None,
            Shape::Plate { .. } => Some((Grip::Rough, false)),
            _ => self.grip,
        }
    }

    /// Whether its faces are round or askew to the grid.
    pub fn is_askew(&self) -> bool {
        match self.shape {
            Shape::Cylinder { .. } => true,
            Shape::Plane { normal, .. } => (0..S::DIMENSION).all(|axis| normal[axis].abs() != 1.0),
            Shape::Box { .. } | Shape::Plate { .. } | Shape::Layer => false,
        }
    }

    /// Whether a node at height `y` moves with the body.
    pub fn holds(&self, y: f64, cell: f64) -> bool {
        !self.meets_points && self.is_behind(y, cell)
    }

    /// Whether a node at height `y` is beyond a plate's face, or the one nearest to it.
    pub fn is_behind(&self, y: f64, cell: f64) -> bool {
        match self.shape {
            Shape::Plate { side: Side::Below, .. } => y <= self.face() + 0.5 * cell,
            Shape::Plate { side: Side::Above, .. } => y >= self.face() - 0.5 * cell,
            _ => false,
        }
    }

    /// Whether its motion asks for nodes: a servo moves what it holds. What nodes do to bodies is counted where they are held.
    pub fn feels_nodes(&self) -> bool {
        self.carries() || (self.is_plate() && self.servo.is_some())
    }

    /// Whether a servo moves nodes with it that lie in it.
    pub fn carries(&self) -> bool {
        self.grip.is_some() && self.servo.is_some()
    }

    /// Whether grains touch it by contacts, beside those glued to it.
    pub fn is_touched(&self) -> bool {
        matches!(self.shape, Shape::Plane { .. } | Shape::Box { .. } | Shape::Cylinder { .. })
    }

    /// Whether it has images across periodic faces; a plane and plates run through them.
    pub fn is_bounded(&self) -> bool {
        matches!(self.shape, Shape::Box { .. } | Shape::Cylinder { .. })
    }

    /// The point that the body turns about and torques refer to, m.
    pub fn origin(&self) -> S::Vector {
        let start = match self.shape {
            Shape::Plate { .. } | Shape::Layer => S::Vector::zero(),
            Shape::Plane { point, .. } => point,
            Shape::Box { lower, upper } => (lower + upper) * 0.5,
            Shape::Cylinder { centre, .. } => centre,
        };
        start + self.displacement
    }

    /// Velocity of the body's matter at a place, m/s.
    pub fn velocity_at(&self, place: &S::Vector) -> S::Vector {
        self.velocity_in(&(self.velocity, self.spin), place)
    }

    /// The same with another velocity and spin of the body.
    pub fn velocity_in(&self, (velocity, spin): &(S::Vector, S::Spin), place: &S::Vector) -> S::Vector {
        *velocity + S::cross(spin, &(*place - self.origin()))
    }

    /// The nearest point of the surface; none for shapes that are not touched.
    pub fn nearest(&self, place: &S::Vector) -> Option<Nearest<S>> {
        let flat = crate::law::contact::FLAT;
        match self.shape {
            Shape::Plate { .. } | Shape::Layer => None,
            Shape::Plane { point, normal } => {
                let distance = (*place - point - self.displacement).dot(&normal);
                Some(Nearest { point: *place - normal * distance, normal, distance, radius: flat })
            }
            Shape::Cylinder { centre, axis, radius } => {
                let apart = *place - centre - self.displacement;
                let across = apart - axis * apart.dot(&axis);
                let length = across.norm();
                let normal = if length > 0.0 { across * (1.0 / length) } else { any_normal::<S>(&axis) };
                let distance = length - radius;
                Some(Nearest { point: *place - normal * distance, normal, distance, radius })
            }
            Shape::Box { lower, upper } => {
                Some(nearest_of_box(place, &(lower + self.displacement), &(upper + self.displacement)))
            }
        }
    }

    /// Whether it is a rough plate across the domain.
    pub fn is_plate(&self) -> bool {
        matches!(self.shape, Shape::Plate { .. })
    }

    /// New velocity under `reaction`. Held nodes are part of the moving mass, so that a light plate on a heavy continuum is stable.
    pub fn accelerate(&mut self, reaction: &Reaction<S>, time: f64, dt: f64) {
        let (before, spin_before) = (self.velocity, self.spin);
        let instant = self.led_at(time);
        self.velocity = instant.velocity;
        self.spin = instant.spin;
        if let Some(servo) = &self.servo {
            let n = servo.direction;
            let load = reaction.force.dot(&n) - servo.force;
            // The dashpot is implicit in the new velocity: stable for any damping.
            let speed =
                (servo.mass * before.dot(&n) + reaction.node_momentum.dot(&n) + load * dt + reaction.unforeseen)
                    / (servo.mass + reaction.node_mass + servo.damping * dt);
            let speed = speed.clamp(-servo.speed_max, servo.speed_max);
            self.velocity += n * (speed - self.velocity.dot(&n));
        }
        self.velocity_mean = (before + self.velocity) * 0.5;
        self.spin_mean = (spin_before + self.spin) * 0.5;
    }

    /// Takes in what the material gave within the step that has just moved it.
    pub fn account(&mut self, reaction: &Reaction<S>, dt: f64) {
        let impulse = reaction.impulse(&self.velocity, dt);
        let turn = reaction.torque * dt;
        self.impulse += impulse;
        self.impulse_whole += impulse - reaction.force * ((1.0 - reaction.kick) * dt);
        self.impulse_angular += turn;
        // By the mean of the velocities on either side of the force: the work that changes kinetic energies by as much.
        self.work -= impulse.dot(&self.velocity_mean) + turn.dot(&self.spin_mean);
    }

    /// Momentum (N s) and mass (kg) of a node that a servo moves with the body: all of a node that it holds rough; else
    /// what its normal has along the servo's direction, without friction. None where it does not hold the node.
    pub fn carried(&self, place: &S::Vector, momentum: &S::Vector, mass: f64) -> Option<(S::Vector, f64)> {
        let ((grip, separates), servo) = (self.grip?, self.servo.as_ref()?);
        let nearest = self.nearest(place).filter(|nearest| nearest.distance <= 0.0)?;
        let opening = (*momentum * (1.0 / mass) - self.velocity_at(place)).dot(&nearest.normal);
        if separates && opening > 0.0 {
            return None;
        }
        Some(match grip {
            Grip::Rough => (*momentum, mass),
            Grip::Smooth | Grip::Coulomb(_) => {
                let along = nearest.normal.dot(&servo.direction);
                (servo.direction * (momentum.dot(&nearest.normal) * along), mass * along * along)
            }
        })
    }

    /// Goes on by the velocity over `dt` (s); the means are velocity and spin themselves until the next forces.
    pub fn drift(&mut self, dt: f64) {
        self.displacement += self.velocity * dt;
        (self.velocity_mean, self.spin_mean) = (self.velocity, self.spin);
    }

    /// How far its path leads from one time to a later one, m; a servo is not asked.
    pub fn way_between(&self, from: f64, to: f64) -> S::Vector {
        let mut ends: Vec<f64> = self.path.iter().map(|at| at.time).filter(|at| from < *at && *at < to).collect();
        ends.insert(0, from);
        ends.push(to);
        // Linear in between: the mean of the ends is exact.
        let leg = |ends: &[f64]| {
            (self.path_at(ends[0]).velocity + self.path_at(ends[1]).velocity) * (0.5 * (ends[1] - ends[0]))
        };
        let swung = self.oscillation.map_or(S::Vector::zero(), |(amplitude, frequency)| {
            amplitude * (sin(2.0 * PI * frequency * to) - sin(2.0 * PI * frequency * from))
        });
        ends.windows(2).fold(swung, |sum, ends| sum + leg(ends))
    }

    /// What moves it at a time, but for a servo.
    fn led_at(&self, time: f64) -> Instant<S> {
        let mut instant = self.path_at(time);
        if let Some((amplitude, frequency)) = self.oscillation {
            let rate = 2.0 * PI * frequency;
            instant.velocity += amplitude * (rate * cos(rate * time));
        }
        instant
    }

    fn path_at(&self, time: f64) -> Instant<S> {
        let still = Instant { time, velocity: S::Vector::zero(), spin: S::Spin::zero() };
        let after = self.path.partition_point(|instant| instant.time <= time);
        match (after.checked_sub(1).map(|before| self.path[before]), self.path.get(after)) {
            (None, None) => still,
            (Some(last), None) => last,
            (None, Some(first)) => *first,
            (Some(a), Some(b)) => {
                let share = (time - a.time) / (b.time - a.time);
                let velocity = a.velocity + (b.velocity - a.velocity) * share;
                Instant { time, velocity, spin: a.spin + (b.spin - a.spin) * share }
            }
        }
    }
}

/// A direction across `axis`, for places on the axis itself.
fn any_normal<S: Space>(axis: &S::Vector) -> S::Vector {
    let mut normal = S::Vector::zero();
    let least = (0..S::DIMENSION).min_by(|a, b| axis[*a].abs().total_cmp(&axis[*b].abs())).unwrap_or(0);
    normal[least] = 1.0;
    normal -= *axis * normal.dot(axis);
    normal * (1.0 / normal.norm())
}

fn nearest_of_box<S: Space>(place: &S::Vector, lower: &S::Vector, upper: &S::Vector) -> Nearest<S> {
    let mut point = *place;
    for axis in 0..S::DIMENSION {
        point[axis] = place[axis].clamp(lower[axis], upper[axis]);
    }
    let apart = *place - point;
    let distance = apart.norm();
    let radius = crate::law::contact::FLAT;
    if distance > 0.0 {
        return Nearest { point, normal: apart * (1.0 / distance), distance, radius };
    }
    // Inside: the nearest face.
    let depth = |axis: usize| (place[axis] - lower[axis]).min(upper[axis] - place[axis]);
    let axis = (0..S::DIMENSION).min_by(|a, b| depth(*a).total_cmp(&depth(*b))).unwrap_or(0);
    let above = upper[axis] - place[axis] <= place[axis] - lower[axis];
    let mut normal = S::Vector::zero();
    normal[axis] = if above { 1.0 } else { -1.0 };
    point[axis] = if above { upper[axis] } else { lower[axis] };
    Nearest { point, normal, distance: -depth(axis), radius }
}

/// The moving state; the rest belongs to the scenario.
impl<S: Space> Record for Body<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("displacement", self.displacement.as_mut_slice());
        visitor.f64s("velocity", self.velocity.as_mut_slice());
        visitor.f64s("spin", self.spin.as_mut_slice());
        visitor.f64s("impulse", self.impulse.as_mut_slice());
        visitor.f64s("impulse_angular", self.impulse_angular.as_mut_slice());
        visitor.f64s("impulse_whole", self.impulse_whole.as_mut_slice());
        visitor.f64s("work", std::slice::from_mut(&mut self.work));
    }
}

impl<S: Space> crate::base::record::Cargo for Body<S> {
    fn blank() -> Self {
        Self::new("", Shape::Layer)
    }
}
