//! The cell that grains live in: a parallelepiped, periodic along some of its edges, that may deform.

use std::marker::PhantomData;

use crate::base::lane::{LANES, Part, TABLE, Table};
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space, Words};

/// How far an edge may lean along another, as a share of it, before a shorter one takes its place. Beyond a half there is
/// one; a little more, so that a cell sheared back and forth does not turn at every rebuild.
const LEAN_MAX: f64 = 0.6;

/// How many periods something lies away along each edge.
pub type Image = [i32; 3];

/// The cell at the end of a step; the same on every rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<S: Space> {
    /// Where the edges start, m. It does not move.
    pub corner: S::Vector,
    /// Edge vectors h as columns, m.
    pub edges: S::Tensor,
    /// Whether the cell repeats along each edge; in the plane the third says nothing.
    pub periodic: [bool; 3],
    /// Velocity gradient L over the last step, 1/s.
    pub gradient: S::Tensor,
    /// dh/dt over the last step, m/s: velocity of an image against its original.
    pub rate: S::Tensor,
    /// Rate of stretch per axis that a stress control has learnt to need, 1/s.
    pub learnt: S::Vector,
    inverse: S::Tensor,
}

impl<S: Space> Cell<S> {
    /// A box with edges along the axes.
    pub fn cuboid(corner: S::Vector, lengths: S::Vector, periodic: [bool; 3]) -> Self {
        let zero = S::Tensor::zero();
        let mut cell = Self {
            corner,
            edges: zero,
            periodic,
            gradient: zero,
            rate: zero,
            learnt: S::Vector::zero(),
            inverse: zero,
        };
        for axis in 0..S::DIMENSION {
            cell.edges[axis * S::DIMENSION + axis] = lengths[axis];
        }
        // As a resumed run reckons it, to the bit.
        cell.settle();
        cell
    }

    /// Share of each edge at which a place lies, 0 to 1 inside.
    pub fn fraction(&self, position: &S::Vector) -> S::Vector {
        self.inverse * (*position - self.corner)
    }

    /// Volume in the space's own measure: m3, or m2 in the plane.
    pub fn volume(&self) -> f64 {
        S::determinant(&self.edges)
    }

    /// Distance of the two faces that cut an edge, m.
    pub fn height(&self, axis: usize) -> f64 {
        let mut square = 0.0;
        for column in 0..S::DIMENSION {
            let entry = self.inverse[column * S::DIMENSION + axis];
            square += entry * entry;
        }
        1.0 / square.sqrt()
    }

    /// Where an image lies against its original, m.
    pub fn shift(&self, image: Image) -> S::Vector {
        self.edges * whole::<S>(image)
    }

    /// The image of a place that lies inside the cell along every periodic edge; velocity changes as the cell's field
    /// does across it. Returns the periods the place had gone.
    pub fn wrap(&self, position: &mut S::Vector, velocity: &mut S::Vector) -> Image {
        let fraction = self.fraction(position);
        let mut image = [0; 3];
        for axis in (0..S::DIMENSION).filter(|axis| self.periodic[*axis]) {
            image[axis] = fraction[axis].floor() as i32;
        }
        if image != [0; 3] {
            *position -= self.shift(image);
            *velocity -= self.rate * whole::<S>(image);
        }
        image
    }

    /// The image of `place` that lies nearest to another: how many periods it lies away. Exact where the two come nearer than
    /// half of every period, and in an upright cell always.
    pub fn image_towards(&self, other: &S::Vector, place: &S::Vector) -> Image {
        let apart = self.inverse * (*place - *other);
        std::array::from_fn(
            |axis| if axis < S::DIMENSION && self.periodic[axis] { apart[axis].round() as i32 } else { 0 },
        )
    }

    /// Velocity of an image against its original, m/s.
    pub fn shift_rate(&self, image: Image) -> S::Vector {
        self.rate * whole::<S>(image)
    }

    /// Deforms the cell over `dt` by the velocity gradient `gradient`: h += L h dt. Returns what the gradient changed by.
    pub fn deform(&mut self, gradient: S::Tensor, dt: f64) -> S::Tensor {
        let change = gradient - self.gradient;
        self.gradient = gradient;
        self.rate = gradient * self.edges;
        self.edges += self.rate * dt;
        self.settle();
        change
    }

    /// Its edges change at the rate `rate`, m/s, from here on. Returns what the gradient changed by.
    pub fn set_rate(&mut self, rate: S::Tensor) -> S::Tensor {
        let before = self.rate * self.inverse;
        self.rate = rate;
        self.gradient = rate * self.inverse;
        self.gradient - before
    }

    /// Goes on at its rate over `dt`: edges straight, so that a place that moves with them does not accelerate.
    pub fn go_on(&mut self, dt: f64) {
        self.edges += self.rate * dt;
        self.settle();
        self.gradient = self.rate * self.inverse;
    }

    /// Edges that it was to have come to, without what steps have rounded.
    pub fn arrive(&mut self, edges: S::Tensor) {
        self.edges = edges;
        self.settle();
    }

    /// Replaces edges that lean far over another by shorter ones that span the same lattice: h_j - m h_i for h_j. Returns
    /// every (i, j, m): an image that lay k_j edges away along j lies m k_j more along i.
    pub fn shorten(&mut self) -> Vec<(usize, usize, i32)> {
        let mut turns = Vec::new();
        let edge = |tensor: &S::Tensor, column: usize, row: usize| tensor[column * S::DIMENSION + row];
        // The longest first: it has the most to gain.
        let length = |column: usize| -> f64 {
            (0..S::DIMENSION).map(|row| edge(&self.edges, column, row) * edge(&self.edges, column, row)).sum()
        };
        let mut columns: Vec<usize> = (0..S::DIMENSION).filter(|j| self.periodic[*j]).collect();
        columns.sort_by(|a, b| length(*b).total_cmp(&length(*a)));
        for j in columns {
            for i in (0..S::DIMENSION).filter(|i| *i != j && self.periodic[*i]) {
                let rows = 0..S::DIMENSION;
                let along: f64 = rows.clone().map(|row| edge(&self.edges, i, row) * edge(&self.edges, j, row)).sum();
                let square: f64 = rows.clone().map(|row| edge(&self.edges, i, row) * edge(&self.edges, i, row)).sum();
                if (along / square).abs() <= LEAN_MAX {
                    continue;
                }
                let times = (along / square).round();
                for tensor in [&mut self.edges, &mut self.rate] {
                    for row in rows.clone() {
                        tensor[j * S::DIMENSION + row] -= times * tensor[i * S::DIMENSION + row];
                    }
                }
                turns.push((i, j, times as i32));
            }
        }
        if !turns.is_empty() {
            self.settle();
        }
        turns
    }

    /// The uniform deformation F that takes this cell's edges to those of `later`.
    pub fn deformation_to(&self, later: &Self) -> S::Tensor {
        later.edges * self.inverse
    }

    /// Reckons what follows from the edges.
    fn settle(&mut self) {
        self.inverse = S::inverse(&self.edges).unwrap_or_else(S::Tensor::zero);
    }

    /// Takes the state of motion of another cell, as a checkpoint kept it.
    pub fn take_motion_of(&mut self, other: &Self) {
        (self.edges, self.gradient, self.rate) = (other.edges, other.gradient, other.rate);
        self.learnt = other.learnt;
        self.settle();
    }
}

fn whole<S: Space>(image: Image) -> S::Vector {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = f64::from(image[axis]);
    }
    vector
}

/// The moving state; corner and periods belong to the scenario.
impl<S: Space> Record for Cell<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("edges", self.edges.as_mut_slice());
        visitor.f64s("gradient", self.gradient.as_mut_slice());
        visitor.f64s("rate", self.rate.as_mut_slice());
        visitor.f64s("learnt", self.learnt.as_mut_slice());
    }
}

impl<S: Space> crate::base::record::Cargo for Cell<S> {
    fn blank() -> Self {
        Self::cuboid(S::Vector::zero(), S::Vector::zero(), [false; 3])
    }
}

/// Shows the periods along the axes that exist.
pub fn visit_image<S: Space>(image: &mut Image, visitor: &mut dyn Visitor) {
    for (axis, name) in ["image_x", "image_y", "image_z"].into_iter().enumerate().take(S::DIMENSION) {
        let mut periods = i64::from(image[axis]);
        visitor.i64(name, &mut periods);
        image[axis] = periods as i32;
    }
}

/// Images of a pair as a small number: 0 is none, at most one period along each edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageCode(pub u8);

impl ImageCode {
    /// No period away along any edge.
    pub const NONE: Self = Self(0);
    /// How many codes there are: -1, 0 or 1 periods along each of three edges.
    pub const COUNT: usize = 27;

    /// From periods of -1, 0 or 1 along each edge; others are taken modulo three.
    pub fn of(image: Image) -> Self {
        let digit = |step: i32| step.rem_euclid(3) as u8;
        Self(digit(image[0]) + 3 * digit(image[1]) + 9 * digit(image[2]))
    }

    /// Periods along each edge, -1 to 1.
    pub fn image(self) -> Image {
        [self.0 % 3, self.0 / 3 % 3, self.0 / 9].map(|digit| if digit == 2 { -1 } else { i32::from(digit) })
    }
}

/// Shift and its rate for every code, as the kernel adds them to separation and relative velocity: component by component a table over
/// codes, those of the shift first.
#[derive(Clone, Debug, Default)]
pub struct Shifts<S: Space> {
    tables: Vec<Table>,
    space: PhantomData<S>,
}

impl<S: Space> Shifts<S> {
    /// Of a cell as it is now.
    pub fn of(cell: &Cell<S>) -> Self {
        let mut shifts = Self::default();
        shifts.settle(cell);
        shifts
    }

    /// Those of a cell as it is now.
    pub fn settle(&mut self, cell: &Cell<S>) {
        self.tables.resize(2 * S::DIMENSION, [0.0; TABLE]);
        let (shifts, rates) = self.tables.split_at_mut(S::DIMENSION);
        for code in 0..3usize.pow(S::DIMENSION as u32) {
            let image = whole::<S>(ImageCode(code as u8).image());
            let (shift, rate) = (cell.edges * image, cell.rate * image);
            for axis in 0..S::DIMENSION {
                (shifts[axis][code], rates[axis][code]) = (shift[axis], rate[axis]);
            }
        }
    }

    /// Of one code.
    #[inline]
    pub fn at(&self, code: ImageCode) -> (S::Vector, S::Vector) {
        let (mut shift, mut rate) = (S::Vector::zero(), S::Vector::zero());
        for axis in 0..S::DIMENSION {
            shift[axis] = self.tables[axis][usize::from(code.0) % TABLE];
            rate[axis] = self.tables[S::DIMENSION + axis][usize::from(code.0) % TABLE];
        }
        (shift, rate)
    }

    /// Of a part of eight codes.
    #[inline(always)]
    pub fn picked<R: Part>(&self, codes: &[u64; LANES], part: usize) -> (S::VectorOf<R>, S::VectorOf<R>) {
        let tables = &self.tables[..2 * S::DIMENSION];
        let (mut shift, mut rate) = (S::VectorOf::<R>::zero(), S::VectorOf::<R>::zero());
        for axis in 0..S::DIMENSION {
            shift.set_word(axis, R::picked(&tables[axis], codes, part));
            rate.set_word(axis, R::picked(&tables[S::DIMENSION + axis], codes, part));
        }
        (shift, rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;

    type Vector = <Plane as Space>::Vector;
    type Tensor = <Plane as Space>::Tensor;

    fn sheared(gamma: f64) -> Cell<Plane> {
        let mut cell = Cell::cuboid(Vector::new(1.0, -2.0), Vector::new(3.0, 2.0), [true, true, false]);
        cell.deform(Tensor::new(0.0, gamma, 0.0, 0.0), 1.0);
        cell
    }

    /// Where an image lies and how fast it moves must not depend on which edges span the lattice.
    #[test]
    fn shorter_edges_span_the_same_lattice() {
        for gamma in [0.5, 1.2, -1.4, 7.3, -20.1] {
            let before = sheared(gamma);
            let mut after = before;
            let turns = after.shorten();
            assert_eq!(turns.is_empty(), (2.0 * gamma / 3.0).abs() <= LEAN_MAX);
            for image in [[1, 0, 0], [0, 1, 0], [-2, 3, 0]] {
                let mut turned = image;
                for (i, j, times) in &turns {
                    turned[*i] += times * turned[*j];
                }
                assert!((before.shift(image) - after.shift(turned)).norm() < 1e-12, "{gamma}");
                let rate = before.rate * whole::<Plane>(image) - after.rate * whole::<Plane>(turned);
                assert!(rate.norm() < 1e-12, "{gamma}");
            }
            assert!((before.volume() - after.volume()).abs() < 1e-12);
            assert!(after.height(0) > 2.4, "{gamma}: {}", after.height(0));
        }
    }

    /// A place and its image are one place with the velocities of the mean field at either.
    #[test]
    fn wrapping_changes_velocity_by_the_field() {
        let cell = sheared(0.4);
        let mean = |place: &Vector| cell.gradient * (*place - cell.corner);
        let (mut place, mut velocity) = (Vector::new(0.3, 1.1), Vector::zero());
        velocity += mean(&place);
        let image = cell.wrap(&mut place, &mut velocity);
        assert_eq!(image, [-1, 1, 0]);
        // The rate is that over the last step, whose edges were those before it; here they have no slope in y.
        assert!((velocity - mean(&place)).norm() < 1e-12);
    }

    #[test]
    fn codes_name_their_images() {
        for code in 0..ImageCode::COUNT as u8 {
            assert_eq!(ImageCode::of(ImageCode(code).image()), ImageCode(code));
        }
        assert_eq!(ImageCode::of([0; 3]), ImageCode::NONE);
    }
}
