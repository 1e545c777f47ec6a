//! The cell that grains live in: a parallelepiped, periodic along some of its edges, that may deform.

use crate::record::{Record, Visitor};
use crate::space::{Linear, Space};

/// How many periods something lies away along each edge.
pub type Image = [i32; 3];

/// The cell at the end of a step; the same on every rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<S: Space> {
    /// Where the edges start, m. It does not move.
    pub corner: S::Vector,
    /// Edge vectors h as columns, m.
    pub edges: S::Tensor,
    pub periodic: [bool; 3],
    /// Velocity gradient L over the last step, 1/s.
    pub gradient: S::Tensor,
    /// dh/dt over the last step, m/s: velocity of an image against its original.
    pub rate: S::Tensor,
    inverse: S::Tensor,
}

impl<S: Space> Cell<S> {
    /// A box with edges along the axes.
    pub fn cuboid(corner: S::Vector, lengths: S::Vector, periodic: [bool; 3]) -> Self {
        let zero = S::Tensor::zero();
        let mut cell = Self { corner, edges: zero, periodic, gradient: zero, rate: zero, inverse: zero };
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

    /// Deforms the cell over `dt` by the velocity gradient `gradient`: h += L h dt. Returns what the gradient changed by.
    pub fn deform(&mut self, gradient: S::Tensor, dt: f64) -> S::Tensor {
        let change = gradient - self.gradient;
        self.gradient = gradient;
        self.rate = gradient * self.edges;
        self.edges += self.rate * dt;
        self.settle();
        change
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
    }
}

impl<S: Space> crate::transfer::Cargo for Cell<S> {
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
    pub const NONE: Self = Self(0);
    pub const COUNT: usize = 27;

    pub fn of(image: Image) -> Self {
        let digit = |step: i32| step.rem_euclid(3) as u8;
        Self(digit(image[0]) + 3 * digit(image[1]) + 9 * digit(image[2]))
    }

    pub fn image(self) -> Image {
        [self.0 % 3, self.0 / 3 % 3, self.0 / 9].map(|digit| if digit == 2 { -1 } else { i32::from(digit) })
    }
}

/// Shift and its rate for every code, as the kernel adds them to separation and relative velocity.
#[derive(Clone, Debug)]
pub struct Shifts<S: Space>(pub [(S::Vector, S::Vector); ImageCode::COUNT]);

impl<S: Space> Shifts<S> {
    pub fn of(cell: &Cell<S>) -> Self {
        Self(std::array::from_fn(|code| {
            let image = ImageCode(code as u8).image();
            (cell.shift(image), cell.rate * whole::<S>(image))
        }))
    }
}
