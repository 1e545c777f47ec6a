//! Dimension lives here (invariant 7): [`Plane`] and [`Solid`] differ only in what this trait says.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use nalgebra::{ArrayStorage, SMatrix, SVector};

use crate::base::lane::Real;
use crate::base::math::{self, PI};
use crate::base::numbers::Numbers;
use crate::base::symmetric::{PlaneSymmetric, SolidSymmetric, Symmetric};

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

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
    /// Every component 0.
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

    /// Root of the sum of squares: of tensors that of Frobenius.
    fn norm(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Whether no component is infinite or NaN.
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

/// `N` components in lanes: the vectors of the kernels of contacts.
#[derive(Clone, Copy, Debug)]
pub struct Components<R, const N: usize>(pub [R; N]);

/// Linear arithmetic over lanes, component by component.
pub trait Lanewise<R: Real>:
    Words<R> + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self> + Mul<R, Output = Self>
{
    /// Sum of the products of components, from the first on.
    #[inline(always)]
    fn dot(&self, other: &Self) -> R {
        let mut sum = self.word(0) * other.word(0);
        for component in 1..Self::COUNT {
            sum = sum + self.word(component) * other.word(component);
        }
        sum
    }
    /// Root of the sum of squares; of a single component its absolute value, the same to the bit.
    fn norm(&self) -> R;
}

/// Numbers that can be told off one by one: memories of contacts, vectors.
pub trait Words<R: Real>: Copy + Debug + Send + Sync + 'static {
    /// Words of one value, lanes not counted.
    const COUNT: usize;
    /// Every word 0.
    fn zero() -> Self;
    /// `index` below [`Words::COUNT`]; of general tensors column by column.
    fn word(&self, index: usize) -> R;
    /// Changes the word that [`Words::word`] gives at that `index`.
    fn set_word(&mut self, index: usize, value: R);

    /// The first of `words`.
    #[inline(always)]
    fn of_words(words: &[R]) -> Self {
        let mut all = Self::zero();
        for (index, word) in words.iter().enumerate().take(Self::COUNT) {
            all.set_word(index, *word);
        }
        all
    }

    /// Sets the first of `words`.
    #[inline(always)]
    fn to_words(&self, words: &mut [R]) {
        for (index, word) in words.iter_mut().enumerate().take(Self::COUNT) {
            *word = self.word(index);
        }
    }

    /// Every word times `factor`.
    #[inline(always)]
    fn scaled(&self, factor: R) -> Self {
        let mut scaled = *self;
        for index in 0..Self::COUNT {
            scaled.set_word(index, self.word(index) * factor);
        }
        scaled
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    fn choose(mask: R::Mask, yes: &Self, no: &Self) -> Self {
        let mut chosen = *no;
        for index in 0..Self::COUNT {
            chosen.set_word(index, R::choose(mask, yes.word(index), no.word(index)));
        }
        chosen
    }
}

impl<R: Real, const N: usize> Words<R> for Components<R, N> {
    const COUNT: usize = N;
    #[inline(always)]
    fn zero() -> Self {
        Self([R::splat(0.0); N])
    }
    #[inline(always)]
    fn word(&self, index: usize) -> R {
        self.0[index]
    }
    #[inline(always)]
    fn set_word(&mut self, index: usize, value: R) {
        self.0[index] = value;
    }
}

/// Column by column.
impl<R: Real, const N: usize> Words<R> for SMatrix<R, N, N> {
    const COUNT: usize = N * N;
    #[inline(always)]
    fn zero() -> Self {
        Self::from_array_storage(ArrayStorage([[R::splat(0.0); N]; N]))
    }
    #[inline(always)]
    fn word(&self, index: usize) -> R {
        self.data.0[index / N][index % N]
    }
    #[inline(always)]
    fn set_word(&mut self, index: usize, value: R) {
        self.data.0[index / N][index % N] = value;
    }
}

/// Two groups of words, one after the other.
impl<R: Real, A: Words<R>, B: Words<R>> Words<R> for (A, B) {
    const COUNT: usize = A::COUNT + B::COUNT;
    #[inline(always)]
    fn zero() -> Self {
        (A::zero(), B::zero())
    }
    #[inline(always)]
    fn word(&self, index: usize) -> R {
        if index < A::COUNT { self.0.word(index) } else { self.1.word(index - A::COUNT) }
    }
    #[inline(always)]
    fn set_word(&mut self, index: usize, value: R) {
        if index < A::COUNT { self.0.set_word(index, value) } else { self.1.set_word(index - A::COUNT, value) }
    }
}

impl<R: Real, const N: usize> Add for Components<R, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}
impl<R: Real, const N: usize> Sub for Components<R, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}
impl<R: Real, const N: usize> Neg for Components<R, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(std::array::from_fn(|i| -self.0[i]))
    }
}
impl<R: Real, const N: usize> Mul<R> for Components<R, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * factor))
    }
}
impl<R: Real, const N: usize> Lanewise<R> for Components<R, N> {
    #[inline(always)]
    fn norm(&self) -> R {
        // The root of a square is the number itself, to the bit.
        if N == 1 { self.0[0].abs() } else { self.dot(self).sqrt() }
    }
}

/// A space of two or three dimensions.
pub trait Space: Copy + Clone + Debug + Default + PartialEq + Send + Sync + 'static {
    /// 2 or 3.
    const DIMENSION: usize;
    /// As it is written in a job.
    const NAME: &'static str;
    /// Components along x, y and, in space, z.
    type Vector: Linear + Numbers;
    /// Square, column by column.
    type Tensor: Linear + Numbers + Mul<Self::Tensor, Output = Self::Tensor> + Mul<Self::Vector, Output = Self::Vector>;
    /// A symmetric tensor: stress, strain.
    type Symmetric: Symmetric<Tensor = Self::Tensor> + Numbers + PartialEq + Default;
    /// What a material law remembers of a point, at most, in words; a symmetric tensor and four numbers are enough for all.
    type PointMemory: Numbers + Debug + Default + PartialEq + Send + Sync;
    /// Angular velocity and torque.
    type Spin: Linear + Numbers;
    /// What a grain's record needs to fill whole vector registers.
    type Spare: Numbers + Debug + Default + PartialEq + Send + Sync;

    /// The same in lanes.
    type VectorOf<R: Real>: Lanewise<R>;
    /// One component in the plane, about the axis out of it; three in space.
    type SpinOf<R: Real>: Lanewise<R>;
    /// Column by column.
    type TensorOf<R: Real>: Words<R>;
    /// The diagonal, then xy, xz, yz.
    type SymmetricOf<R: Real>: Symmetric<R, Tensor = Self::TensorOf<R>>;
    /// A vector in the tangent plane of a contact. In the plane it is one number along t = (-n_y, n_x) and turns with the
    /// contact by itself; in space it is a vector of space that [`Space::carry`] turns.
    type TangentOf<R: Real>: Lanewise<R>;

    /// Ones on the diagonal.
    fn identity() -> Self::Tensor;
    /// Rows for columns.
    fn transpose(tensor: &Self::Tensor) -> Self::Tensor;
    /// Sum of the diagonal; in the plane without what is out of it.
    fn trace(tensor: &Self::Tensor) -> f64;
    /// Of a deformation gradient the ratio of volumes, in the plane of areas.
    fn determinant(tensor: &Self::Tensor) -> f64;
    /// None where the determinant is zero.
    fn inverse(tensor: &Self::Tensor) -> Option<Self::Tensor>;
    /// The same in lanes; infinite where the determinant is zero.
    fn inverse_of<R: Real>(tensor: &Self::TensorOf<R>) -> Self::TensorOf<R>;
    /// R of the polar decomposition `F = R U` of a tensor with a positive determinant.
    fn rotation(tensor: &Self::Tensor) -> Self::Tensor;
    /// Angle of a rotation, rad: in the plane counterclockwise, in (-pi, pi]; in space about its axis, in [0, pi].
    fn angle(rotation: &Self::Tensor) -> f64;
    /// `a b^T`.
    fn outer(a: &Self::Vector, b: &Self::Vector) -> Self::Tensor;
    /// Half of the rotation of a velocity gradient: the spin of its rigid part.
    fn vorticity(gradient: &Self::Tensor) -> Self::Spin;
    /// Axis times angle of a rotation, rad.
    fn rotation_vector(rotation: &Self::Tensor) -> Self::Spin {
        let along = Self::vorticity(rotation);
        match along.norm() {
            0.0 => Self::Spin::zero(),
            sine => along * (Self::angle(rotation).abs() / sine),
        }
    }
    /// A spin in another frame, which `rotation` leads to.
    fn turned_spin(rotation: &Self::Tensor, spin: &Self::Spin) -> Self::Spin {
        let mut skew = Self::Tensor::zero();
        for column in 0..Self::DIMENSION {
            let mut axis = Self::Vector::zero();
            axis[column] = 1.0;
            let moved = Self::cross(spin, &axis);
            (0..Self::DIMENSION).for_each(|row| skew[column * Self::DIMENSION + row] = moved[row]);
        }
        Self::vorticity(&(*rotation * skew * Self::transpose(rotation)))
    }
    /// `spin x arm`.
    fn cross(spin: &Self::Spin, arm: &Self::Vector) -> Self::Vector;
    /// `arm x force`.
    fn moment(arm: &Self::Vector, force: &Self::Vector) -> Self::Spin;

    /// The part of `velocity` in the tangent plane of the unit `normal`.
    fn tangential<R: Real>(normal: &Self::VectorOf<R>, velocity: &Self::VectorOf<R>) -> Self::TangentOf<R>;
    /// `spin x normal`: velocity that a spin gives to the surface, per unit of lever arm along the normal.
    fn surface<R: Real>(normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> Self::TangentOf<R>;
    /// The tangent vector as a vector of space.
    fn embed<R: Real>(normal: &Self::VectorOf<R>, tangent: &Self::TangentOf<R>) -> Self::VectorOf<R>;
    /// `normal x tangent`: torque of a tangential force per unit of lever arm along the normal.
    fn torque<R: Real>(normal: &Self::VectorOf<R>, tangent: &Self::TangentOf<R>) -> Self::SpinOf<R>;
    /// The part of a spin that turns `normal`; the rest spins about it.
    fn rolling<R: Real>(normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> Self::SpinOf<R>;
    /// The part of a spin about `normal`, rad/s.
    fn twist<R: Real>(normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> R;
    /// A tangent vector of the last step in the tangent plane of now: turned by `angle` about the normal, laid into the
    /// plane, its length kept.
    fn carry<R: Real>(normal: &Self::VectorOf<R>, angle: R, tangent: &Self::TangentOf<R>) -> Self::TangentOf<R>;
    /// The same for the moment arm of rolling.
    fn carry_spin<R: Real>(normal: &Self::VectorOf<R>, angle: R, spin: &Self::SpinOf<R>) -> Self::SpinOf<R>;

    /// Volume of a grain, m3 (of a disc: with its out-of-plane depth).
    fn grain_volume(radius: f64, depth: f64) -> f64;
    /// Moment of inertia of a uniform grain, kg m2.
    fn grain_inertia<R: Real>(mass: R, radius: R) -> R;
}

/// Two dimensions with an out-of-plane depth; grains are discs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane;

impl Space for Plane {
    const DIMENSION: usize = 2;
    const NAME: &'static str = "plane";
    type Vector = SVector<f64, 2>;
    type Tensor = SMatrix<f64, 2, 2>;
    type Symmetric = PlaneSymmetric;
    type PointMemory = [f64; 7];
    type Spin = SVector<f64, 1>;
    type Spare = [f64; 0];
    type VectorOf<R: Real> = Components<R, 2>;
    type TensorOf<R: Real> = SMatrix<R, 2, 2>;
    type SymmetricOf<R: Real> = PlaneSymmetric<R>;
    type SpinOf<R: Real> = Components<R, 1>;
    type TangentOf<R: Real> = Components<R, 1>;

    #[inline]
    fn identity() -> Self::Tensor {
        Self::Tensor::identity()
    }
    #[inline]
    fn transpose(tensor: &Self::Tensor) -> Self::Tensor {
        tensor.transpose()
    }
    #[inline]
    fn trace(tensor: &Self::Tensor) -> f64 {
        tensor[0] + tensor[3]
    }
    #[inline]
    fn determinant(tensor: &Self::Tensor) -> f64 {
        tensor[0] * tensor[3] - tensor[1] * tensor[2]
    }
    #[inline]
    fn inverse(tensor: &Self::Tensor) -> Option<Self::Tensor> {
        (Self::determinant(tensor) != 0.0).then(|| Self::inverse_of::<f64>(tensor))
    }
    #[inline(always)]
    fn inverse_of<R: Real>(tensor: &Self::TensorOf<R>) -> Self::TensorOf<R> {
        let [[a, b], [c, d]] = tensor.data.0;
        let scale = R::splat(1.0) / (a * d - b * c);
        SMatrix::from_array_storage(ArrayStorage([[d * scale, -b * scale], [-c * scale, a * scale]]))
    }
    fn rotation(tensor: &Self::Tensor) -> Self::Tensor {
        let (cosine, sine) = (tensor[0] + tensor[3], tensor[1] - tensor[2]);
        let scale = 1.0 / (cosine * cosine + sine * sine).sqrt();
        let (cosine, sine) = (cosine * scale, sine * scale);
        Self::Tensor::new(cosine, -sine, sine, cosine)
    }
    fn angle(rotation: &Self::Tensor) -> f64 {
        math::atan2(rotation[1] - rotation[2], rotation[0] + rotation[3])
    }
    fn outer(a: &Self::Vector, b: &Self::Vector) -> Self::Tensor {
        Self::Tensor::new(a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    }
    fn vorticity(gradient: &Self::Tensor) -> Self::Spin {
        Self::Spin::new(0.5 * (gradient[(1, 0)] - gradient[(0, 1)]))
    }
    fn cross(spin: &Self::Spin, arm: &Self::Vector) -> Self::Vector {
        Self::Vector::new(-spin[0] * arm[1], spin[0] * arm[0])
    }
    fn moment(arm: &Self::Vector, force: &Self::Vector) -> Self::Spin {
        Self::Spin::new(arm[0] * force[1] - arm[1] * force[0])
    }

    #[inline(always)]
    fn tangential<R: Real>(normal: &Self::VectorOf<R>, velocity: &Self::VectorOf<R>) -> Self::TangentOf<R> {
        Components([velocity.0[1] * normal.0[0] - velocity.0[0] * normal.0[1]])
    }
    #[inline(always)]
    fn surface<R: Real>(_normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> Self::TangentOf<R> {
        *spin
    }
    #[inline(always)]
    fn embed<R: Real>(normal: &Self::VectorOf<R>, tangent: &Self::TangentOf<R>) -> Self::VectorOf<R> {
        Components([-normal.0[1] * tangent.0[0], normal.0[0] * tangent.0[0]])
    }
    #[inline(always)]
    fn torque<R: Real>(_normal: &Self::VectorOf<R>, tangent: &Self::TangentOf<R>) -> Self::SpinOf<R> {
        *tangent
    }
    #[inline(always)]
    fn rolling<R: Real>(_normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> Self::SpinOf<R> {
        *spin
    }
    #[inline(always)]
    fn twist<R: Real>(_normal: &Self::VectorOf<R>, _spin: &Self::SpinOf<R>) -> R {
        R::splat(0.0)
    }
    #[inline(always)]
    fn carry<R: Real>(_normal: &Self::VectorOf<R>, _angle: R, tangent: &Self::TangentOf<R>) -> Self::TangentOf<R> {
        *tangent
    }
    #[inline(always)]
    fn carry_spin<R: Real>(_normal: &Self::VectorOf<R>, _angle: R, spin: &Self::SpinOf<R>) -> Self::SpinOf<R> {
        *spin
    }

    fn grain_volume(radius: f64, depth: f64) -> f64 {
        PI * radius * radius * depth
    }
    #[inline(always)]
    fn grain_inertia<R: Real>(mass: R, radius: R) -> R {
        R::splat(0.5) * mass * radius * radius
    }
}

/// Three dimensions; grains are spheres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solid;

#[inline(always)]
fn cross<R: Real>(a: &Components<R, 3>, b: &Components<R, 3>) -> Components<R, 3> {
    let ([ax, ay, az], [bx, by, bz]) = (a.0, b.0);
    Components([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
}

impl Space for Solid {
    const DIMENSION: usize = 3;
    const NAME: &'static str = "solid";
    type Vector = SVector<f64, 3>;
    type Tensor = SMatrix<f64, 3, 3>;
    type Symmetric = SolidSymmetric;
    type PointMemory = [f64; 10];
    type Spin = SVector<f64, 3>;
    type Spare = [f64; 4];
    type VectorOf<R: Real> = Components<R, 3>;
    type TensorOf<R: Real> = SMatrix<R, 3, 3>;
    type SymmetricOf<R: Real> = SolidSymmetric<R>;
    type SpinOf<R: Real> = Components<R, 3>;
    type TangentOf<R: Real> = Components<R, 3>;

    #[inline]
    fn identity() -> Self::Tensor {
        Self::Tensor::identity()
    }
    #[inline]
    fn transpose(tensor: &Self::Tensor) -> Self::Tensor {
        tensor.transpose()
    }
    #[inline]
    fn trace(tensor: &Self::Tensor) -> f64 {
        tensor[0] + tensor[4] + tensor[8]
    }
    #[inline]
    fn determinant(tensor: &Self::Tensor) -> f64 {
        let t = tensor;
        t[0] * (t[4] * t[8] - t[7] * t[5]) - t[3] * (t[1] * t[8] - t[7] * t[2]) + t[6] * (t[1] * t[5] - t[4] * t[2])
    }
    #[inline]
    fn inverse(tensor: &Self::Tensor) -> Option<Self::Tensor> {
        (Self::determinant(tensor) != 0.0).then(|| Self::inverse_of::<f64>(tensor))
    }
    #[inline(always)]
    fn inverse_of<R: Real>(tensor: &Self::TensorOf<R>) -> Self::TensorOf<R> {
        let [a, b, c] = tensor.data.0.map(Components);
        let rows = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        let scale = R::splat(1.0) / a.dot(&rows[0]);
        let mut inverse = *tensor;
        for (row, Components(entries)) in rows.into_iter().enumerate() {
            for (column, entry) in entries.into_iter().enumerate() {
                inverse.data.0[column][row] = entry * scale;
            }
        }
        inverse
    }
    /// `R <- (s R + R^-T/s)/2` from F, by Higham (1986); s makes the norms of the two equal.
    fn rotation(tensor: &Self::Tensor) -> Self::Tensor {
        let mut rotation = *tensor;
        for _ in 0..64 {
            let Some(inverse) = Self::inverse(&rotation) else { break };
            let scale = (inverse.norm() / rotation.norm()).sqrt();
            let next = (rotation * scale + inverse.transpose() * (1.0 / scale)) * 0.5;
            let change = (next - rotation).norm();
            rotation = next;
            // The error squares with each iteration.
            if change <= 1e-9 {
                break;
            }
        }
        rotation
    }
    fn angle(rotation: &Self::Tensor) -> f64 {
        math::atan2(2.0 * Self::vorticity(rotation).norm(), Self::trace(rotation) - 1.0)
    }
    fn outer(a: &Self::Vector, b: &Self::Vector) -> Self::Tensor {
        Self::Tensor::from_fn(|row, column| a[row] * b[column])
    }
    fn vorticity(gradient: &Self::Tensor) -> Self::Spin {
        let l = gradient;
        Self::Spin::new(l[(2, 1)] - l[(1, 2)], l[(0, 2)] - l[(2, 0)], l[(1, 0)] - l[(0, 1)]) * 0.5
    }
    fn cross(spin: &Self::Spin, arm: &Self::Vector) -> Self::Vector {
        spin.cross(arm)
    }
    fn moment(arm: &Self::Vector, force: &Self::Vector) -> Self::Spin {
        arm.cross(force)
    }

    #[inline(always)]
    fn tangential<R: Real>(normal: &Self::VectorOf<R>, velocity: &Self::VectorOf<R>) -> Self::TangentOf<R> {
        *velocity - *normal * velocity.dot(normal)
    }
    #[inline(always)]
    fn surface<R: Real>(normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> Self::TangentOf<R> {
        cross(spin, normal)
    }
    #[inline(always)]
    fn embed<R: Real>(_normal: &Self::VectorOf<R>, tangent: &Self::TangentOf<R>) -> Self::VectorOf<R> {
        *tangent
    }
    #[inline(always)]
    fn torque<R: Real>(normal: &Self::VectorOf<R>, tangent: &Self::TangentOf<R>) -> Self::SpinOf<R> {
        cross(normal, tangent)
    }
    #[inline(always)]
    fn rolling<R: Real>(normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> Self::SpinOf<R> {
        *spin - *normal * spin.dot(normal)
    }
    #[inline(always)]
    fn twist<R: Real>(normal: &Self::VectorOf<R>, spin: &Self::SpinOf<R>) -> R {
        spin.dot(normal)
    }
    #[inline(always)]
    fn carry<R: Real>(normal: &Self::VectorOf<R>, angle: R, tangent: &Self::TangentOf<R>) -> Self::TangentOf<R> {
        let turned = *tangent + cross(normal, tangent) * angle;
        let laid = turned - *normal * turned.dot(normal);
        let (before, after) = (tangent.dot(tangent), laid.dot(&laid));
        let zero = R::splat(0.0);
        let scale = R::choose(after.above(zero), (before / after).sqrt(), zero);
        laid * scale
    }
    #[inline(always)]
    fn carry_spin<R: Real>(normal: &Self::VectorOf<R>, angle: R, spin: &Self::SpinOf<R>) -> Self::SpinOf<R> {
        Self::carry(normal, angle, spin)
    }

    /// A sphere needs no depth.
    fn grain_volume(radius: f64, _depth: f64) -> f64 {
        4.0 / 3.0 * PI * radius * radius * radius
    }
    #[inline(always)]
    fn grain_inertia<R: Real>(mass: R, radius: R) -> R {
        R::splat(0.4) * mass * radius * radius
    }
}
