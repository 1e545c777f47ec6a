//! Dimension lives here (invariant 7): [`Plane`] and a solid space differ only in what this trait says.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use nalgebra::{SMatrix, SVector};

/// What the physics does with vectors, tensors and spins: linear arithmetic, component by component.
pub trait Linear:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
    + Index<usize, Output = f64>
    + IndexMut<usize>
{
    /// Number of components; [`Index`] runs over them (tensors column by column).
    const COMPONENTS: usize;
    fn zero() -> Self;
    /// The components as numbers, to be stored and sent.
    fn as_mut_slice(&mut self) -> &mut [f64];

    /// Sum of the products of components: `a.b` of vectors, `a:b` of tensors.
    fn dot(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for component in 0..Self::COMPONENTS {
            sum += self[component] * other[component];
        }
        sum
    }

    fn norm(&self) -> f64 {
        self.dot(self).sqrt()
    }

    fn is_finite(&self) -> bool {
        (0..Self::COMPONENTS).all(|component| self[component].is_finite())
    }
}

impl<const R: usize, const C: usize> Linear for SMatrix<f64, R, C> {
    const COMPONENTS: usize = R * C;
    fn zero() -> Self {
        Self::zeros()
    }
    fn as_mut_slice(&mut self) -> &mut [f64] {
        self.data.as_mut_slice()
    }
}

/// A space of two or three dimensions.
pub trait Space: Copy + Clone + Debug + Default + Send + Sync + 'static {
    const DIMENSION: usize;
    type Vector: Linear;
    type Tensor: Linear + Mul<Self::Tensor, Output = Self::Tensor> + Mul<Self::Vector, Output = Self::Vector>;
    /// Angular velocity and torque.
    type Spin: Linear;
    /// A vector in the tangent plane of a contact, in a frame that turns with the contact.
    type Tangent: Linear;

    fn identity() -> Self::Tensor;
    fn transpose(tensor: &Self::Tensor) -> Self::Tensor;
    fn trace(tensor: &Self::Tensor) -> f64;
    fn determinant(tensor: &Self::Tensor) -> f64;
    /// `a b^T`.
    fn outer(a: &Self::Vector, b: &Self::Vector) -> Self::Tensor;

    /// The part of `velocity` in the tangent plane of the unit `normal`.
    fn tangential(normal: &Self::Vector, velocity: &Self::Vector) -> Self::Tangent;
    /// `spin x normal`: velocity that a spin gives to the surface, per unit of lever arm along the normal.
    fn surface(normal: &Self::Vector, spin: &Self::Spin) -> Self::Tangent;
    /// The tangent vector as a vector of space.
    fn embed(normal: &Self::Vector, tangent: &Self::Tangent) -> Self::Vector;
    /// `normal x tangent`: torque of a tangential force per unit of lever arm along the normal.
    fn torque(normal: &Self::Vector, tangent: &Self::Tangent) -> Self::Spin;

    /// Volume of a grain, m3 (of a disc: with its out-of-plane depth).
    fn grain_volume(radius: f64, depth: f64) -> f64;
    /// Moment of inertia of a uniform grain, kg m2.
    fn grain_inertia(mass: f64, radius: f64) -> f64;
}

/// Two dimensions with an out-of-plane depth; grains are discs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane;

impl Space for Plane {
    const DIMENSION: usize = 2;
    type Vector = SVector<f64, 2>;
    type Tensor = SMatrix<f64, 2, 2>;
    type Spin = SVector<f64, 1>;
    type Tangent = SVector<f64, 1>;

    fn identity() -> Self::Tensor {
        Self::Tensor::identity()
    }
    fn transpose(tensor: &Self::Tensor) -> Self::Tensor {
        tensor.transpose()
    }
    fn trace(tensor: &Self::Tensor) -> f64 {
        tensor[0] + tensor[3]
    }
    fn determinant(tensor: &Self::Tensor) -> f64 {
        tensor[0] * tensor[3] - tensor[1] * tensor[2]
    }
    fn outer(a: &Self::Vector, b: &Self::Vector) -> Self::Tensor {
        Self::Tensor::new(a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    }

    // The tangent is t = (-n_y, n_x): the contact's own frame, so a tangent needs one number and turns by itself.
    fn tangential(normal: &Self::Vector, velocity: &Self::Vector) -> Self::Tangent {
        Self::Tangent::new(velocity[1] * normal[0] - velocity[0] * normal[1])
    }
    fn surface(_normal: &Self::Vector, spin: &Self::Spin) -> Self::Tangent {
        *spin
    }
    fn embed(normal: &Self::Vector, tangent: &Self::Tangent) -> Self::Vector {
        Self::Vector::new(-normal[1] * tangent[0], normal[0] * tangent[0])
    }
    fn torque(_normal: &Self::Vector, tangent: &Self::Tangent) -> Self::Spin {
        *tangent
    }

    fn grain_volume(radius: f64, depth: f64) -> f64 {
        crate::math::PI * radius * radius * depth
    }
    fn grain_inertia(mass: f64, radius: f64) -> f64 {
        0.5 * mass * radius * radius
    }
}
