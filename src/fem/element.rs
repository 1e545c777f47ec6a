//! An element: its mean gradients, and the forces that a stress in it puts on its corners.
//!
//! ```text
//! B_a = (1/V) int grad N_a dV                    mean gradients at the start (Flanagan & Belytschko 1981)
//! F = 1 + sum_a u_a (x) B_a                      u: displacement of a corner since the start
//! f_a = -V tau F^-T B_a                          tau: Kirchhoff stress, V: volume at the start
//! ```
//!
//! With the gradient at the middle in place of the mean one, a uniform stress would not be in balance in a distorted mesh.

use crate::base::lane::Real;
use crate::base::space::{Linear, Space, Words};

/// Corners of an element in space.
pub const CORNERS_MAX: usize = 8;
/// Axes of space.
pub const AXES_MAX: usize = 3;

/// Natural coordinates of the corners, in the order that VTK has them; the first four are those of the plane.
pub const NATURAL: [[f64; AXES_MAX]; CORNERS_MAX] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Where two points of quadrature lie on an axis, 1/sqrt(3).
pub const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Corners of an element of this space.
pub const fn corners<S: Space>() -> usize {
    1 << S::DIMENSION
}

/// A vector at each corner, of one element or of several in step; third components are zero in the plane.
pub type AtCorners<R> = [[R; AXES_MAX]; CORNERS_MAX];
/// A tensor of them, row by row.
pub type Matrix<R> = [[R; AXES_MAX]; AXES_MAX];

/// What an element is at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// m3; of the plane with its depth.
    pub volume: f64,
    /// B of each corner, 1/m.
    pub gradients: AtCorners<f64>,
}

/// The same of one element, or of several in step. Each number is read where it is used: arrays of all of them would go to memory and back.
pub trait Gradients<R> {
    /// m3; of the plane with its depth.
    fn volume(&self) -> R;
    /// B of a corner along an axis, 1/m.
    fn gradient(&self, corner: usize, axis: usize) -> R;
}

impl Gradients<f64> for Element {
    fn volume(&self) -> f64 {
        self.volume
    }
    fn gradient(&self, corner: usize, axis: usize) -> f64 {
        self.gradients[corner][axis]
    }
}

/// `a b`.
#[inline(always)]
pub fn product<S: Space, R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    let mut found = [[R::splat(0.0); AXES_MAX]; AXES_MAX];
    for i in 0..S::DIMENSION {
        for j in 0..S::DIMENSION {
            let mut sum = a[i][0] * b[0][j];
            for k in 1..S::DIMENSION {
                sum = sum + a[i][k] * b[k][j];
            }
            found[i][j] = sum;
        }
    }
    found
}

/// `a v`.
#[inline(always)]
pub(super) fn applied<S: Space, R: Real>(a: &Matrix<R>, v: &[R; AXES_MAX]) -> [R; AXES_MAX] {
    let mut found = [R::splat(0.0); AXES_MAX];
    for i in 0..S::DIMENSION {
        let mut sum = a[i][0] * v[0];
        for k in 1..S::DIMENSION {
            sum = sum + a[i][k] * v[k];
        }
        found[i] = sum;
    }
    found
}

#[inline(always)]
pub(super) fn transposed<S: Space, R: Real>(a: &Matrix<R>) -> Matrix<R> {
    let mut found = *a;
    for (i, row) in found.iter_mut().enumerate().take(S::DIMENSION) {
        for (entry, other) in row.iter_mut().zip(a).take(S::DIMENSION) {
            *entry = other[i];
        }
    }
    found
}

/// A tensor in lanes, row by row, and back.
#[inline(always)]
pub fn matrix_of<S: Space, R: Real>(tensor: &S::TensorOf<R>) -> Matrix<R> {
    let mut found = [[R::splat(0.0); AXES_MAX]; AXES_MAX];
    for (i, row) in found.iter_mut().enumerate().take(S::DIMENSION) {
        for (j, entry) in row.iter_mut().enumerate().take(S::DIMENSION) {
            *entry = tensor.word(j * S::DIMENSION + i);
        }
    }
    found
}

/// The reverse of [`matrix_of`].
#[inline(always)]
pub fn tensor_of<S: Space, R: Real>(matrix: &Matrix<R>) -> S::TensorOf<R> {
    let mut found = S::TensorOf::<R>::zero();
    for (i, row) in matrix.iter().enumerate().take(S::DIMENSION) {
        for (j, entry) in row.iter().enumerate().take(S::DIMENSION) {
            found.set_word(j * S::DIMENSION + i, *entry);
        }
    }
    found
}

/// A vector with three components.
pub fn widened<V: Linear>(vector: &V) -> [f64; AXES_MAX] {
    std::array::from_fn(|axis| if axis < V::COMPONENTS { vector[axis] } else { 0.0 })
}

impl Element {
    /// Of corners at these places, m; none where it is turned inside out somewhere. Two points of quadrature along each axis are exact.
    pub fn of<S: Space>(places: &[S::Vector; CORNERS_MAX], depth: f64) -> Option<Self> {
        let count = corners::<S>();
        let (mut volume, mut gradients) = (0.0, [S::Vector::zero(); CORNERS_MAX]);
        for point in &NATURAL[..count] {
            let slopes = slopes::<S>(&point.map(|side| side * GAUSS));
            let mut jacobian = S::Tensor::zero();
            for (place, slope) in places.iter().zip(&slopes).take(count) {
                jacobian += S::outer(place, slope);
            }
            let measure = S::determinant(&jacobian);
            let inverse = S::inverse(&jacobian).filter(|_| measure > 0.0)?;
            volume += measure;
            for (gradient, slope) in gradients.iter_mut().zip(&slopes) {
                *gradient += S::transpose(&inverse) * *slope * measure;
            }
        }
        let gradients = gradients.map(|gradient| widened(&(gradient * (1.0 / volume))));
        Some(Self { volume: if S::DIMENSION == 2 { volume * depth } else { volume }, gradients })
    }
}

/// F.
#[inline(always)]
pub fn deformation<S: Space, R: Real>(shape: &impl Gradients<R>, displacements: &AtCorners<R>) -> Matrix<R> {
    let mut deformation = [[R::splat(0.0); AXES_MAX]; AXES_MAX];
    for (axis, row) in deformation.iter_mut().enumerate().take(S::DIMENSION) {
        row[axis] = R::splat(1.0);
        for (corner, displacement) in displacements.iter().enumerate().take(corners::<S>()) {
            for (along, entry) in row.iter_mut().enumerate().take(S::DIMENSION) {
                *entry = *entry + displacement[axis] * shape.gradient(corner, along);
            }
        }
    }
    deformation
}

/// `-V tau F^-T`, which times B of a corner is the force on it, N m; of a Kirchhoff stress and the inverse of F.
#[inline(always)]
pub fn pushed<S: Space, R: Real>(shape: &impl Gradients<R>, stress: &Matrix<R>, inverse: &Matrix<R>) -> Matrix<R> {
    let mut pushed = product::<S, R>(stress, &transposed::<S, R>(inverse));
    let minus = -shape.volume();
    pushed.iter_mut().flatten().for_each(|entry| *entry = *entry * minus);
    pushed
}

/// The force on a corner of that, N.
#[inline(always)]
pub fn force<S: Space, R: Real>(shape: &impl Gradients<R>, pushed: &Matrix<R>, corner: usize) -> [R; AXES_MAX] {
    let slopes = [shape.gradient(corner, 0), shape.gradient(corner, 1), shape.gradient(corner, 2)];
    applied::<S, R>(pushed, &slopes)
}

/// Slopes of the shape functions over natural coordinates.
fn slopes<S: Space>(at: &[f64; 3]) -> [S::Vector; CORNERS_MAX] {
    std::array::from_fn(|corner| {
        let mut slope = S::Vector::zero();
        if corner >= corners::<S>() {
            return slope;
        }
        for axis in 0..S::DIMENSION {
            let along = |other: usize| match other == axis {
                true => 0.5 * NATURAL[corner][other],
                false => 0.5 * (1.0 + NATURAL[corner][other] * at[other]),
            };
            slope[axis] = (0..S::DIMENSION).map(along).product();
        }
        slope
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::base::space::{Plane, Solid};
    use crate::fem::side::Side;

    /// A box of edges 2, 3 and 4 with its corners moved about.
    pub(crate) fn distorted<S: Space>() -> [S::Vector; CORNERS_MAX] {
        std::array::from_fn(|corner| {
            let mut place = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                let moved = 0.08 * ((7 * corner + 3 * axis + corner * axis) % 5) as f64;
                place[axis] = (2 + axis) as f64 * 0.5 * NATURAL[corner][axis] + moved;
            }
            place
        })
    }

    fn linear_fields_and_uniform_stress<S: Space>() {
        let places = distorted::<S>();
        let element = Element::of::<S>(&places, 0.5).unwrap();
        // F of displacements that are linear in place is theirs.
        let mut wanted = S::identity();
        (0..S::Tensor::COMPONENTS).for_each(|at| wanted[at] += 0.1 * ((5 * at) % 7) as f64);
        let moved = places.map(|place| widened(&(wanted * place - place)));
        let found: S::TensorOf<f64> = tensor_of::<S, f64>(&deformation::<S, f64>(&element, &moved));
        assert!((0..S::Tensor::COMPONENTS).all(|at| (found.word(at) - wanted[at]).abs() < 1e-13));
        // A uniform stress is in balance with what presses on the sides.
        let mut stress = S::identity() * -3.0;
        (stress[1], stress[S::DIMENSION]) = (0.7, 0.7);
        let matrix = |tensor: &S::Tensor| -> Matrix<f64> {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    if i < S::DIMENSION && j < S::DIMENSION { tensor[j * S::DIMENSION + i] } else { 0.0 }
                })
            })
        };
        let pushed = pushed::<S, f64>(&element, &matrix(&stress), &matrix(&S::identity()));
        let mut sums: [S::Vector; CORNERS_MAX] = std::array::from_fn(|corner| {
            let force = force::<S, f64>(&element, &pushed, corner);
            let mut sum = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| sum[axis] = force[axis]);
            sum
        });
        for side in Side::all(S::DIMENSION) {
            for (corner, area) in side.corners::<S>().iter().zip(side.areas::<S>(&places, 0.5)) {
                sums[*corner] += stress * area;
            }
        }
        assert!(sums.iter().all(|sum| sum.norm() < 1e-13), "{sums:?}");
    }

    #[test]
    fn linear_fields_are_exact_and_uniform_stress_is_in_balance_in_distorted_elements() {
        linear_fields_and_uniform_stress::<Plane>();
        linear_fields_and_uniform_stress::<Solid>();
    }

    #[test]
    fn an_element_turned_inside_out_is_none() {
        let mut places = distorted::<Plane>();
        places.swap(0, 1);
        assert_eq!(Element::of::<Plane>(&places, 1.0), None);
    }
}
