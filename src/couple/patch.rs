//! What the grains of a few cells tell of the continuum that they could be: linear fields that fit them best, by mass.
//!
//! ```text
//! b(x) = <b> + G (x - <x>),   G = <(b - <b>) (x - <x>)^T> <(x - <x>) (x - <x>)^T>^-1
//! ```
//!
//! as Cundall's best fit of the strain among neighbours (Chen et al. 2021, appendix A, eq. 50), over cells in their place.

use nalgebra::{SMatrix, SVector};

use crate::numbers;

type Vector = SVector<f64, 2>;
type Tensor = SMatrix<f64, 2, 2>;

/// Sums over the grains of a cell, or of several; places are relative to a centre, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Patch {
    /// kg; of grains without their weights.
    pub mass: f64,
    /// The part of it that is outside the rim, kg.
    pub core: f64,
    /// Volume of the grains, m3, and of those outside the rim.
    pub solid: f64,
    /// Volume of the grains outside the rim, m3.
    pub solid_core: f64,
    /// Love-Weber sum of the contacts of the latter, J, tension positive. Nodes bear a part of what others bear.
    pub moment: Tensor,
    /// Room of the cells that are full of grains, m3, and volume of the grains in them.
    pub room_full: f64,
    /// Volume of the grains in full cells, m3.
    pub solid_full: f64,
    place: Vector,
    square: Tensor,
    velocity: Sums,
    displacement: Sums,
}

/// Of a field b: sums of m b and of m b x^T.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
struct Sums {
    value: Vector,
    by_place: Tensor,
}

numbers!(impl[] Sums[] { value: Vector, by_place: Tensor });
numbers!(impl[] Patch[] {
    mass: f64,
    core: f64,
    solid: f64,
    solid_core: f64,
    moment: Tensor,
    room_full: f64,
    solid_full: f64,
    place: Vector,
    square: Tensor,
    velocity: Sums,
    displacement: Sums,
});

/// A field that is linear about `centre`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearField {
    centre: Vector,
    mean: Vector,
    /// G: component of the field by row, direction by column; 1/s of a velocity. Zero where grains lie in a line, or there is one.
    pub gradient: Tensor,
}

impl LinearField {
    /// At a place relative to the patch's centre, m.
    pub fn at(&self, place: &Vector) -> Vector {
        self.mean + self.gradient * (place - self.centre)
    }
}

/// Second moments per mass, in squares of a cell, whose determinant is below this tell no gradient: grains in a line, or one.
const DETERMINANT_LEAST: f64 = 1e-4;

impl Patch {
    /// A grain at `place`, m, of so much `mass`, kg, and `solid` volume, m3.
    pub fn add_grain(&mut self, (mass, solid): (f64, f64), place: &Vector, velocity: &Vector, displacement: &Vector) {
        self.mass += mass;
        self.solid += solid;
        self.place += place * mass;
        self.square += place * place.transpose() * mass;
        self.velocity.add(mass, place, velocity);
        self.displacement.add(mass, place, displacement);
    }

    /// Another patch, whose centre lies so far from this one's, m.
    pub fn add(&mut self, other: &Self, way: &Vector) {
        self.mass += other.mass;
        self.core += other.core;
        self.solid += other.solid;
        self.solid_core += other.solid_core;
        self.moment += other.moment;
        self.room_full += other.room_full;
        self.solid_full += other.solid_full;
        self.place += other.place + way * other.mass;
        let mixed = other.place * way.transpose();
        self.square += other.square + mixed + mixed.transpose() + way * way.transpose() * other.mass;
        self.velocity.add_moved(&other.velocity, way);
        self.displacement.add_moved(&other.displacement, way);
    }

    /// Velocity, m/s; `cell` is a length to measure by, m.
    pub fn velocity(&self, cell: f64) -> LinearField {
        self.field(&self.velocity, cell)
    }

    /// Displacement since the start, m.
    pub fn displacement(&self, cell: f64) -> LinearField {
        self.field(&self.displacement, cell)
    }

    /// Whether most of it is grains outside the rim.
    pub fn is_core(&self) -> bool {
        self.core > 0.5 * self.mass
    }

    /// Whether what it is of lies in more than a line, by which it tells gradients; `cell` as above.
    pub fn is_spread(&self, cell: f64) -> bool {
        self.spread().determinant() >= DETERMINANT_LEAST * cell.powi(4)
    }

    /// Second moments of places per mass, about their mean, m2.
    fn spread(&self) -> Tensor {
        let centre = self.place / self.mass;
        self.square / self.mass - centre * centre.transpose()
    }

    fn field(&self, sums: &Sums, cell: f64) -> LinearField {
        let (centre, mean) = (self.place / self.mass, sums.value / self.mass);
        let inverse = if self.is_spread(cell) { self.spread().try_inverse() } else { None };
        let covariance = sums.by_place / self.mass - mean * centre.transpose();
        let gradient = inverse.map_or_else(Tensor::zeros, |inverse| covariance * inverse);
        LinearField { centre, mean, gradient }
    }
}

impl Sums {
    fn add(&mut self, mass: f64, place: &Vector, value: &Vector) {
        self.value += value * mass;
        self.by_place += value * place.transpose() * mass;
    }

    fn add_moved(&mut self, other: &Self, way: &Vector) {
        self.value += other.value;
        self.by_place += other.by_place + other.value * way.transpose();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_fields_are_found_as_they_are_whatever_cells_their_grains_lie_in() {
        let velocity = |x: &Vector| Vector::new(0.3 + 2.0 * x[0] - 5.0 * x[1], -0.1 + 0.25 * x[1]);
        let displacement = |x: &Vector| Vector::new(0.02 * x[1], 0.01 - 0.03 * x[0]);
        let mut cells = [Patch::default(); 2];
        for number in 0..40 {
            let spread = |stride: i32| f64::from(stride * number % 40) / 20.0 - 0.975;
            let place = Vector::new(spread(7), 0.5 * spread(23));
            let at = usize::from(place[0] > 0.0);
            let local = place - Vector::new([-0.5, 0.5][at], 0.0);
            let mass = 1.0 + 0.1 * f64::from(number % 7);
            cells[at].add_grain((mass, 1.0), &local, &velocity(&place), &displacement(&place));
        }
        // About a centre of its own.
        let mut patch = Patch::default();
        patch.add(&cells[0], &Vector::new(-0.25, -2.0));
        patch.add(&cells[1], &Vector::new(0.75, -2.0));
        let moved = |place: &Vector| place + Vector::new(-0.25, 2.0);
        for place in [Vector::new(0.1, 0.2), Vector::new(-1.0, 0.7)] {
            assert!((patch.velocity(1.0).at(&place) - velocity(&moved(&place))).norm() < 1e-12);
            assert!((patch.displacement(1.0).at(&place) - displacement(&moved(&place))).norm() < 1e-13);
        }
    }

    #[test]
    fn grains_in_a_line_tell_no_gradient() {
        let mut patch = Patch::default();
        for x in [0.0, 0.5, 1.0] {
            patch.add_grain((1.0, 1.0), &Vector::new(x, x), &Vector::new(x, 0.0), &Vector::zeros());
        }
        let field = patch.velocity(1.0);
        assert_eq!((field.gradient, field.at(&Vector::new(3.0, 0.0))), (Tensor::zeros(), Vector::new(0.5, 0.0)));
    }
}
