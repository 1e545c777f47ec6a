//! Elastic membranes in the plane: chains of masses and springs under pressure, with nothing but nodes between them and what
//! they hold (Chen et al. 2021, appendix B; the way to the nodes and back is that of Jiang et al. 2015).
//!
//! A segment between two vertices `a` and `b`, of length l and rest length l_0, with e from a to b:
//!
//! ```text
//! T = max(k (l - l_0), 0) + gamma (v_b - v_a).e        f_a = T e,  f_b = -T e
//! f_a = f_b = p d/2 n                                  n = l times e turned to the left
//! ```
//!
//! k and gamma are those of a segment, whatever its length, as in the paper. A membrane that is shorter than at rest
//! wrinkles and bears nothing. The pressure p pushes to the left of the way along the chain, on its length as it is, d being the
//! depth out of the plane.
//!
//! All vertices are on all ranks, which reckon their forces alike. A vertex goes to nodes in the tile of the block that it
//! lies in.

use crate::base::math;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Space};

/// A chain and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Membrane {
    /// As the job names it.
    pub name: String,
    /// Its vertices among those of all membranes.
    pub first: usize,
    /// Vertices, both ends of an open chain among them.
    pub count: usize,
    /// The last vertex is joined to the first.
    pub closed: bool,
    /// Of a segment, kg; a vertex has half of those on either side.
    pub mass: f64,
    /// Of a segment at rest, m.
    pub rest: f64,
    /// k of a segment, N/m, and gamma, N s/m.
    pub stiffness: f64,
    /// gamma of a segment, N s/m.
    pub damping: f64,
    /// Pa, and the time over which it rises from zero, s.
    pub pressure: f64,
    /// s; with 0 the pressure is there from the start.
    pub ramp: f64,
    /// m.
    pub depth: f64,
}

/// A vertex of a membrane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex<S: Space> {
    /// Number of its membrane.
    pub membrane: u64,
    /// m; never wrapped into the period, so that neighbours are neighbours.
    pub position: S::Vector,
    /// m/s.
    pub velocity: S::Vector,
    /// Place at the start of the run, m.
    pub origin: S::Vector,
    /// Position at the last rebuild: blocks whose grains may share nodes with it follow from there, m.
    pub home: S::Vector,
}

/// What a vertex brings to nodes, where it goes, and what it has taken; of the step, not of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brought<S: Space> {
    /// kg.
    pub mass: f64,
    /// N.
    pub force: S::Vector,
    /// Along the chain, a unit vector.
    pub along: S::Vector,
    /// The block that it lies in, its place there with periods taken off, m.
    pub block: usize,
    /// m, wrapped into the period.
    pub place: S::Vector,
    /// Way of the step, m.
    pub way: S::Vector,
}

/// The membranes of a world, the same on every rank.
#[derive(Clone, Debug)]
pub struct Membranes<S: Space> {
    /// By number, as [`Vertex::membrane`] has it.
    pub made_of: Vec<Membrane>,
    /// Membrane by membrane, along each chain.
    pub vertices: Vec<Vertex<S>>,
    /// By vertex.
    pub brought: Vec<Brought<S>>,
    /// Bits of what vertices have taken, one rank's beside zeros of the others'.
    pub(crate) words: Vec<i64>,
}

impl<S: Space> Default for Membranes<S> {
    fn default() -> Self {
        Self { made_of: Vec::new(), vertices: Vec::new(), brought: Vec::new(), words: Vec::new() }
    }
}

impl<S: Space> Record for Vertex<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("membrane", &mut self.membrane);
        visitor.f64s("position", self.position.as_mut_slice());
        visitor.f64s("velocity", self.velocity.as_mut_slice());
        visitor.f64s("origin", self.origin.as_mut_slice());
        visitor.f64s("home", self.home.as_mut_slice());
    }
}

impl<S: Space> Cargo for Vertex<S> {
    fn blank() -> Self {
        let zero = S::Vector::zero();
        Self { membrane: 0, position: zero, velocity: zero, origin: zero, home: zero }
    }
}

/// Between two vertices, those with the numbers `from` and `to`.
#[derive(Clone, Copy, Debug)]
struct Segment<S: Space> {
    from: usize,
    to: usize,
    way: S::Vector,
    length: f64,
}

impl Membrane {
    /// As many as vertices where it is closed, else one fewer.
    pub fn segments(&self) -> usize {
        if self.closed { self.count } else { self.count - 1 }
    }

    /// Mass of the vertex with that number within it, kg.
    pub fn mass_of(&self, number: usize) -> f64 {
        let at_an_end = !self.closed && (number == 0 || number + 1 == self.count);
        if at_an_end { 0.5 * self.mass } else { self.mass }
    }

    /// What a segment of that length bears of its own, N.
    pub fn tension(&self, length: f64) -> f64 {
        (self.stiffness * (length - self.rest)).max(0.0)
    }

    /// Pa.
    pub fn pressure_at(&self, time: f64) -> f64 {
        if time < self.ramp { self.pressure * (time / self.ramp) } else { self.pressure }
    }

    fn segments_of<'a, S: Space>(&'a self, vertices: &'a [Vertex<S>]) -> impl Iterator<Item = Segment<S>> + 'a {
        (0..self.segments()).map(move |number| {
            let (from, to) = (self.first + number, self.first + (number + 1) % self.count);
            let way = vertices[to].position - vertices[from].position;
            Segment { from, to, way, length: way.norm() }
        })
    }
}

impl<S: Space> Membranes<S> {
    /// Of vertices as they are; where they lie is told by whoever has the blocks.
    pub fn new(made_of: Vec<Membrane>, vertices: Vec<Vertex<S>>) -> Self {
        let zero = S::Vector::zero();
        let masses = made_of.iter().flat_map(|membrane| (0..membrane.count).map(|number| membrane.mass_of(number)));
        let blank = |mass| Brought { mass, force: zero, along: zero, block: 0, place: zero, way: zero };
        let brought: Vec<Brought<S>> = masses.map(blank).collect();
        assert_eq!(brought.len(), vertices.len(), "every vertex belongs to a membrane");
        Self { made_of, vertices, brought, words: Vec::new() }
    }

    /// Whether the world has no membranes.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// How far a vertex has come since the last rebuild, at most, m.
    pub fn away_from_home(&self) -> f64 {
        self.vertices.iter().map(|vertex| (vertex.position - vertex.home).norm()).fold(0.0, f64::max)
    }

    /// Forces of springs and pressure at a time, segment by segment, and directions.
    pub fn push(&mut self, time: f64) {
        let Self { made_of, vertices, brought, .. } = self;
        brought.iter_mut().for_each(|brought| (brought.force, brought.along) = (S::Vector::zero(), S::Vector::zero()));
        for membrane in made_of {
            let pressure = 0.5 * membrane.depth * membrane.pressure_at(time);
            for Segment { from, to, way, length } in membrane.segments_of(vertices) {
                // Two vertices in one place pull nowhere.
                let along = if length > 0.0 { way * (1.0 / length) } else { S::Vector::zero() };
                let opening = (vertices[to].velocity - vertices[from].velocity).dot(&along);
                let pull = along * (membrane.tension(length) + membrane.damping * opening);
                let push = left_of::<S>(&way) * pressure;
                brought[from].force += push + pull;
                brought[to].force += push - pull;
                brought[from].along += way;
                brought[to].along += way;
            }
        }
        for brought in brought {
            let length = brought.along.norm();
            // A chain that turns back on itself has no direction there.
            brought.along = if length > 0.0 { brought.along * (1.0 / length) } else { S::Vector::zero() };
        }
    }

    /// Velocities (m/s) with the masses that have them (kg).
    pub fn masses(&self) -> impl Iterator<Item = (f64, &S::Vector)> {
        self.brought.iter().zip(&self.vertices).map(|(brought, vertex)| (brought.mass, &vertex.velocity))
    }

    /// Kinetic energy and that of springs, J.
    pub fn energy(&self) -> f64 {
        let kinetic: f64 = self.masses().map(|(mass, velocity)| 0.5 * mass * velocity.dot(velocity)).sum();
        let stretched = |membrane: &Membrane, length: f64| {
            let longer = (length - membrane.rest).max(0.0);
            0.5 * membrane.stiffness * longer * longer
        };
        let elastic = |membrane: &Membrane| -> f64 {
            membrane.segments_of(&self.vertices).map(|segment| stretched(membrane, segment.length)).sum()
        };
        kinetic + self.made_of.iter().map(elastic).sum::<f64>()
    }

    /// Length, m, and the least and the largest of what segments bear, N.
    pub fn stretch(&self, membrane: &Membrane) -> [f64; 3] {
        let (mut length, mut least, mut most) = (0.0, f64::INFINITY, 0.0_f64);
        for segment in membrane.segments_of(&self.vertices) {
            let tension = membrane.tension(segment.length);
            length += segment.length;
            (least, most) = (least.min(tension), most.max(tension));
        }
        [length, least, most]
    }

    /// Area to the left of all membranes joined end to end in their order, m2.
    pub fn enclosed(&self) -> f64 {
        let count = self.vertices.len();
        let cross = |at: usize| {
            let (a, b) = (&self.vertices[at].position, &self.vertices[(at + 1) % count].position);
            0.5 * (a[0] * b[1] - b[0] * a[1])
        };
        (0..count).map(cross).sum()
    }

    /// What a vertex belongs to.
    pub fn of(&self, vertex: &Vertex<S>) -> &Membrane {
        &self.made_of[vertex.membrane as usize]
    }
}

/// A vector of the plane, turned by a quarter to the left.
fn left_of<S: Space>(way: &S::Vector) -> S::Vector {
    let mut left = S::Vector::zero();
    (left[0], left[1]) = (-way[1], way[0]);
    left
}

/// Vertices at rest along a line, both ends among them, m.
pub fn along_line<S: Space>(from: &S::Vector, to: &S::Vector, segments: usize) -> Vec<Vertex<S>> {
    let at = |number: usize| *from + (*to - *from) * (number as f64 / segments as f64);
    (0..=segments).map(|number| resting(at(number))).collect()
}

/// Vertices at rest on a circle, counter-clockwise from its right, m.
pub fn on_circle<S: Space>(centre: &S::Vector, radius: f64, segments: usize) -> Vec<Vertex<S>> {
    let at = |number: usize| {
        let angle = 2.0 * math::PI * number as f64 / segments as f64;
        let mut place = *centre;
        place[0] += radius * math::cos(angle);
        place[1] += radius * math::sin(angle);
        place
    };
    (0..segments).map(|number| resting(at(number))).collect()
}

fn resting<S: Space>(position: S::Vector) -> Vertex<S> {
    Vertex { membrane: 0, position, velocity: S::Vector::zero(), origin: position, home: position }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;

    type Vector = <Plane as Space>::Vector;

    fn of(count: usize, closed: bool) -> Membrane {
        Membrane {
            name: "skin".into(),
            first: 0,
            count,
            closed,
            mass: 0.1,
            rest: 0.5,
            stiffness: 8.0,
            damping: 0.5,
            pressure: 3.0,
            ramp: 2.0,
            depth: 0.25,
        }
    }

    #[test]
    fn springs_pull_and_pressure_pushes_to_the_left_of_the_way() {
        let line = along_line::<Plane>(&Vector::new(0.0, 0.0), &Vector::new(2.0, 0.0), 2);
        let mut membranes = Membranes::new(vec![of(3, false)], line);
        // Opening at 2 m/s in the second segment.
        membranes.vertices[2].velocity = Vector::new(2.0, 5.0);
        membranes.push(1.0);
        let forces: Vec<Vector> = membranes.brought.iter().map(|brought| brought.force).collect();
        // k (1 - 1/2) = 4 N, gamma 2 m/s = 1 N, and half of the pressure on 1 m times 0.25 m, halved: 0.1875 N.
        let expected = [Vector::new(4.0, 0.1875), Vector::new(1.0, 0.375), Vector::new(-5.0, 0.1875)];
        for (force, expected) in forces.iter().zip(expected) {
            assert!((force - expected).norm() < 1e-14, "{force} for {expected}");
        }
        assert_eq!(membranes.brought.iter().map(|brought| brought.mass).collect::<Vec<_>>(), [0.05, 0.1, 0.05]);
    }

    #[test]
    fn what_is_shorter_than_at_rest_bears_nothing() {
        let line = along_line::<Plane>(&Vector::new(0.0, 0.0), &Vector::new(0.0, 0.8), 2);
        let mut membranes = Membranes::new(vec![of(3, false)], line);
        membranes.push(0.0);
        assert!(membranes.brought.iter().all(|brought| brought.force == Vector::zeros()));
        assert_eq!(membranes.energy(), 0.0);
        let [length, least, most] = membranes.stretch(&membranes.made_of[0].clone());
        assert!((length - 0.8).abs() < 1e-15 && least == 0.0 && most == 0.0);
    }

    /// A closed chain under pressure gets no momentum from itself, and hoop tension balances pressure: a polygon of n sides
    /// has 2 T sin(pi/n) = p d l cos(pi/n).
    #[test]
    fn forces_of_a_ring_cancel_and_balance_at_the_tension_of_a_polygon() {
        let count = 24;
        let ring = on_circle::<Plane>(&Vector::new(1.0, 2.0), 2.0, count);
        let mut membrane = of(count, true);
        let length = 2.0 * 2.0 * math::sin(math::PI / count as f64);
        // Pushing outwards, so that the ring is stretched.
        let half = math::PI / count as f64;
        let tension = 0.25 * 3.0 * length * math::cos(half) / (2.0 * math::sin(half));
        (membrane.pressure, membrane.rest) = (-3.0, length - tension / 8.0);
        let mut membranes = Membranes::new(vec![membrane], ring);
        membranes.push(9.0);
        let sum = membranes.brought.iter().fold(Vector::zeros(), |sum, brought| sum + brought.force);
        assert!(sum.norm() < 1e-13, "{sum}");
        for brought in &membranes.brought {
            assert!(brought.force.norm() < 1e-13 * tension.max(1.0), "{}", brought.force);
        }
    }
}
