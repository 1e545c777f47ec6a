//! Hourglass control by assumed strains (Belytschko & Bindeman 1993; in the plane Belytschko & Bindeman 1991): what displacements of the
//! corners have beyond a linear field is given the stiffness that bending and torsion of the element would have.
//!
//! ```text
//! gamma_a = (h_a - sum_i (h.X_i) B_ai)/n              h: eta zeta, zeta xi, xi eta, xi eta zeta; in the plane xi eta
//! q_m = R0^T F^-1 sum_a gamma_am u_a                  nothing of a linear field or a turn of the element
//! Q_ii = mu ((H_jj + H_kk) q_ii + H_ij q_jj + H_ik q_kk)                              torsion
//! Q_ij = E/(1 - nu^2) (H_ii q_ij + nu H_ij q_ji)      Q_i4 = E H_ii q_i4/3            bending
//! f_a = -F^-T R0 sum_m Q_m (gamma_am - B_a.R0 q_m)
//! ```
//!
//! with H_ii = 4 a_j a_k/(3 a_i) and H_ij = 4 a_k/3 of a box with edges a, R0 the frame of the element at the start, and i, j, k three different axes.
//! What is in brackets is gamma of the shape as it is: forces are the gradient of `sum Q q/2`, and neither push nor turn the element as a whole.
//! A box of an elastic material bends as a beam does, with one element over its height. There is no memory: what a step begins with is in the displacements.
//!
//! A material that yields has the stiffness of now, that of a hyperbola through what the element itself bears at its strain (Kondner 1963; Duncan & Chang 1970),
//!
//! ```text
//! r = (|s|/(2 mu |e|))^2        s: deviatoric Kirchhoff stress, e: deviatoric part of (1 - b^-1)/2, |x|^2 = x:x
//! ```
//!
//! no more than all of it and no less than a hundredth; it counts from a start without deviatoric stress, and an element whose stress has come back through
//! zero is left with the hundredth. With that of the start an element that flows would go on to resist bending as if it were elastic, and
//! a coarse specimen of grain assemblies bore 20 % too much. Nor does it hold more than its strength: where hourglass stresses are more than the stress in the
//! element itself, and more than those of a strain of 1e-5, they are cut down to that. What is cut counts as lost.

use crate::base::lane::Real;
use crate::base::space::{Linear, Space};
use crate::fem::element::{
    AXES_MAX, AtCorners, CORNERS_MAX, Element, Gradients, Matrix, NATURAL, applied, corners, product, transposed,
};

/// Strain of hourglass modes up to which they are elastic whatever the stress in an element is: without any they would be free.
const STRAIN_FREE: f64 = 1e-5;

/// Share of its stiffness that a material keeps however far it yields.
const STIFFNESS_LEAST: f64 = 0.01;

/// Hourglass modes of an element in space.
pub const MODES_MAX: usize = 4;

/// Hourglass modes of an element of this space.
pub const fn modes<S: Space>() -> usize {
    if S::DIMENSION == 2 { 1 } else { MODES_MAX }
}

/// How it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hourglass {
    /// G and M of the material, Pa.
    pub shear_modulus: f64,
    /// M, Pa.
    pub p_wave_modulus: f64,
    /// Share of that stiffness.
    pub coefficient: f64,
    /// Whether the stress in the element bounds it.
    pub yields: bool,
}

/// Of an element at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    /// gamma of each mode and corner.
    pub gammas: [[f64; CORNERS_MAX]; MODES_MAX],
    /// R0.
    pub frame: Matrix<f64>,
    /// Edges along its axes, m; in the plane the third is the depth.
    pub edges: [f64; AXES_MAX],
}

/// The same of one, or of several in step.
pub trait Shape<R>: Gradients<R> {
    /// [`Modes::gammas`], mode and corner.
    fn gamma(&self, mode: usize, corner: usize) -> R;
    /// R0, row and column.
    fn frame(&self, row: usize, column: usize) -> R;
    /// m.
    fn edge(&self, axis: usize) -> R;
}

impl Gradients<f64> for (Element, Modes) {
    fn volume(&self) -> f64 {
        self.0.volume
    }
    fn gradient(&self, corner: usize, axis: usize) -> f64 {
        self.0.gradient(corner, axis)
    }
}

impl Shape<f64> for (Element, Modes) {
    fn gamma(&self, mode: usize, corner: usize) -> f64 {
        self.1.gammas[mode][corner]
    }
    fn frame(&self, row: usize, column: usize) -> f64 {
        self.1.frame[row][column]
    }
    fn edge(&self, axis: usize) -> f64 {
        self.1.edges[axis]
    }
}

/// What it does to an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance<R> {
    /// `F^-T R0 Q` and `R0 q` of each mode, N and m.
    pushes: [[R; AXES_MAX]; MODES_MAX],
    turns: [[R; AXES_MAX]; MODES_MAX],
    /// `sum Q q/2`, J.
    pub energy: R,
}

/// h of a mode at a corner.
fn mode_at<S: Space>(mode: usize, corner: usize) -> f64 {
    let [xi, eta, zeta] = NATURAL[corner];
    match (S::DIMENSION, mode) {
        (2, _) | (_, 2) => xi * eta,
        (_, 0) => eta * zeta,
        (_, 1) => zeta * xi,
        _ => xi * eta * zeta,
    }
}

impl Hourglass {
    /// r, of an element with this inverse of F and this Kirchhoff stress.
    #[inline(always)]
    fn stiffness_left<S: Space, R: Real>(&self, inverse: &Matrix<R>, stress: &Matrix<R>) -> R {
        let twice = R::splat(2.0 * self.shear_modulus);
        let finger = product::<S, R>(&transposed::<S, R>(inverse), inverse);
        // |dev b^-1| is twice |e|.
        let elastic = deviator_square::<S, R>(&finger).sqrt() * R::splat(self.shear_modulus);
        let borne = deviator_square::<S, R>(stress).sqrt();
        let least = twice * R::splat(STRAIN_FREE);
        let secant = (borne + least) / (elastic + least);
        let share = secant * secant;
        let share = R::choose(share.above(R::splat(1.0)), R::splat(1.0), share);
        let least = R::splat(STIFFNESS_LEAST);
        R::choose(least.above(share), least, share)
    }
}

/// x:x of the deviatoric part of a symmetric tensor, along the axes of the space.
#[inline(always)]
fn deviator_square<S: Space, R: Real>(tensor: &Matrix<R>) -> R {
    let mut trace = tensor[0][0];
    for (axis, row) in tensor.iter().enumerate().take(S::DIMENSION).skip(1) {
        trace = trace + row[axis];
    }
    let mean = trace * R::splat(1.0 / S::DIMENSION as f64);
    let mut square = R::splat(0.0);
    for (axis, row) in tensor.iter().enumerate().take(S::DIMENSION) {
        for (other, entry) in row.iter().enumerate().take(S::DIMENSION) {
            let part = if axis == other { *entry - mean } else { *entry };
            square = square + part * part;
        }
    }
    square
}

impl Modes {
    /// From an element and the places of its corners at the start, m; `depth` (m) is the edge across the plane.
    pub fn of<S: Space>(element: &Element, places: &[S::Vector; CORNERS_MAX], depth: f64) -> Self {
        let count = corners::<S>();
        let mut gammas = [[0.0; CORNERS_MAX]; MODES_MAX];
        for (mode, gammas) in gammas.iter_mut().enumerate().take(modes::<S>()) {
            let mut linear = S::Vector::zero();
            (0..count).for_each(|corner| linear += places[corner] * mode_at::<S>(mode, corner));
            for (corner, gamma) in gammas.iter_mut().enumerate().take(count) {
                let along = |axis: usize| linear[axis] * element.gradients[corner][axis];
                let beside: f64 = (0..S::DIMENSION).map(along).sum();
                *gamma = (mode_at::<S>(mode, corner) - beside) / count as f64;
            }
        }
        let mut jacobian = S::Tensor::zero();
        for (place, natural) in places.iter().zip(NATURAL).take(count) {
            let mut along = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| along[axis] = natural[axis]);
            jacobian += S::outer(place, &along);
        }
        let frame = S::rotation(&jacobian);
        let inside = S::transpose(&frame) * jacobian;
        let edge = |axis: usize| match axis < S::DIMENSION {
            true => inside[axis * (S::DIMENSION + 1)] * (2.0 / count as f64),
            false => depth,
        };
        let mut rows = [[0.0; AXES_MAX]; AXES_MAX];
        for (i, row) in rows.iter_mut().enumerate().take(S::DIMENSION) {
            (0..S::DIMENSION).for_each(|j| row[j] = frame[j * S::DIMENSION + i]);
        }
        Self { gammas, frame: rows, edges: [edge(0), edge(1), edge(2)] }
    }

    /// What the frequencies of an element are bounded by: w^2 <= c^2 times this, 1/m2, for the mass of an n-th at each of its n corners. Of its linear
    /// modes `n sum B.B` (Flanagan & Belytschko 1981), of a box `4 sum 1/h^2`; of its hourglass modes, each with what it shares with another, less but in a
    /// shape that is far from a box, at the whole stiffness of their control.
    pub fn stiffest<S: Space>(&self, element: &Element) -> f64 {
        let count = corners::<S>();
        let linear: f64 = element.gradients.iter().flatten().map(|slope| slope * slope).sum();
        let square = |gammas: &[f64; CORNERS_MAX]| gammas.iter().map(|gamma| gamma * gamma).sum::<f64>();
        let gamma = self.gammas.iter().map(square).fold(0.0, f64::max);
        let [a, b, c] = self.edges;
        let own = (b * c / a).max(c * a / b).max(if S::DIMENSION == 2 { 0.0 } else { a * b / c });
        count as f64 * linear.max(2.0 * 4.0 / 3.0 * own * gamma / element.volume)
    }
}

impl<R: Real> Resistance<R> {
    /// Of an element whose corners have moved, with the inverse of its F and its Kirchhoff stress.
    #[inline(always)]
    pub fn of<S: Space>(
        shape: &impl Shape<R>,
        how: &Hourglass,
        displacements: &AtCorners<R>,
        (inverse, stress): (&Matrix<R>, &Matrix<R>),
    ) -> Self {
        let zero = R::splat(0.0);
        let mut frame = [[zero; AXES_MAX]; AXES_MAX];
        for (row, entries) in frame.iter_mut().enumerate().take(S::DIMENSION) {
            for (column, entry) in entries.iter_mut().enumerate().take(S::DIMENSION) {
                *entry = shape.frame(row, column);
            }
        }
        let into = product::<S, R>(&transposed::<S, R>(&frame), inverse);
        let mut amplitudes = [[zero; AXES_MAX]; MODES_MAX];
        for (mode, amplitude) in amplitudes.iter_mut().enumerate().take(modes::<S>()) {
            let mut sum = [zero; AXES_MAX];
            for (corner, displacement) in displacements.iter().enumerate().take(corners::<S>()) {
                let gamma = shape.gamma(mode, corner);
                for axis in 0..S::DIMENSION {
                    sum[axis] = sum[axis] + displacement[axis] * gamma;
                }
            }
            *amplitude = applied::<S, R>(&into, &sum);
        }
        let mut generalised = how.generalised::<S, R>(shape, &amplitudes);
        let mut energy = zero;
        for (force, amplitude) in generalised.iter().zip(&amplitudes).take(modes::<S>()) {
            for axis in 0..S::DIMENSION {
                energy = energy + force[axis] * amplitude[axis];
            }
        }
        energy = energy * R::splat(0.5);
        if how.yields {
            let mut share = how.stiffness_left::<S, R>(inverse, stress);
            energy = energy * share;
            // Of a stress s the energy is s:s/(4 mu), of a strain e mu e^2.
            let mut square = zero;
            for row in stress.iter().take(S::DIMENSION) {
                for entry in row.iter().take(S::DIMENSION) {
                    square = square + *entry * *entry;
                }
            }
            let least = how.shear_modulus * STRAIN_FREE * STRAIN_FREE;
            let bound = (square * R::splat(0.25 / how.shear_modulus) + R::splat(least)) * shape.volume();
            let above = energy.above(bound);
            let cut = R::choose(above, (bound / R::choose(above, energy, R::splat(1.0))).sqrt(), R::splat(1.0));
            share = share * cut;
            generalised.iter_mut().flatten().for_each(|force| *force = *force * share);
            energy = energy * cut;
        }
        let back = transposed::<S, R>(&into);
        let mut resistance =
            Self { pushes: [[zero; AXES_MAX]; MODES_MAX], turns: [[zero; AXES_MAX]; MODES_MAX], energy };
        for mode in 0..modes::<S>() {
            resistance.pushes[mode] = applied::<S, R>(&back, &generalised[mode]);
            resistance.turns[mode] = applied::<S, R>(&frame, &amplitudes[mode]);
        }
        resistance
    }

    /// The force on a corner beside one that is there, N.
    #[inline(always)]
    pub fn beside<S: Space>(&self, shape: &impl Shape<R>, corner: usize, force: [R; AXES_MAX]) -> [R; AXES_MAX] {
        let mut force = force;
        for mode in 0..modes::<S>() {
            let mut gamma = shape.gamma(mode, corner);
            for (axis, along) in self.turns[mode].iter().enumerate().take(S::DIMENSION) {
                gamma = gamma - shape.gradient(corner, axis) * *along;
            }
            for (force, push) in force.iter_mut().zip(&self.pushes[mode]).take(S::DIMENSION) {
                *force = *force - *push * gamma;
            }
        }
        force
    }
}

impl Hourglass {
    /// Q of q.
    #[inline(always)]
    fn generalised<S: Space, R: Real>(
        &self,
        shape: &impl Shape<R>,
        q: &[[R; AXES_MAX]; MODES_MAX],
    ) -> [[R; AXES_MAX]; MODES_MAX] {
        let shear = self.shear_modulus * self.coefficient;
        let lambda = (self.p_wave_modulus - 2.0 * self.shear_modulus) * self.coefficient;
        let number = R::splat;
        let plate = number(4.0 * shear * (lambda + shear) / (lambda + 2.0 * shear));
        let across = number(2.0 * shear * lambda / (lambda + 2.0 * shear));
        let third = number(shear * (3.0 * lambda + 2.0 * shear) / (lambda + shear) / 3.0);
        let shear = number(shear);
        let (edges, part) = ([shape.edge(0), shape.edge(1), shape.edge(2)], number(4.0 / 3.0));
        let own = |i: usize| edges[(i + 1) % 3] * edges[(i + 2) % 3] / edges[i] * part;
        let own = [own(0), own(1), own(2)];
        let mut forces = [[number(0.0); AXES_MAX]; MODES_MAX];
        if S::DIMENSION == 2 {
            for axis in 0..S::DIMENSION {
                forces[0][axis] = plate * own[axis] * q[0][axis];
            }
            return forces;
        }
        for i in 0..3 {
            let others = [(i + 1) % 3, (i + 2) % 3];
            let beside = |j: usize| edges[3 - i - j] * part;
            let [j, k] = others;
            forces[i][i] = shear * ((own[j] + own[k]) * q[i][i] + beside(j) * q[j][j] + beside(k) * q[k][k]);
            for j in others {
                forces[j][i] = plate * own[i] * q[j][i] + across * beside(j) * q[i][j];
            }
            forces[3][i] = third * own[i] * q[3][i];
        }
        forces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Plane, Solid};
    use crate::fem::element::tests::distorted;
    use crate::fem::element::{deformation, matrix_of, tensor_of, widened};

    const HOW: Hourglass = Hourglass { shear_modulus: 3.0, p_wave_modulus: 10.0, coefficient: 1.0, yields: false };

    struct Found {
        forces: AtCorners<f64>,
        energy: f64,
    }

    fn resist<S: Space>(places: &[S::Vector; CORNERS_MAX], moved: &[S::Vector; CORNERS_MAX]) -> Found {
        let element = Element::of::<S>(places, 0.5).unwrap();
        let moved = moved.map(|moved| widened(&moved));
        let deformation = tensor_of::<S, f64>(&deformation::<S, f64>(&element, &moved));
        let inverse = matrix_of::<S, f64>(&S::inverse_of::<f64>(&deformation));
        let shape = (element, Modes::of::<S>(&element, places, 0.5));
        let found = Resistance::of::<S>(&shape, &HOW, &moved, (&inverse, &[[0.0; 3]; 3]));
        let forces = std::array::from_fn(|corner| match corner < corners::<S>() {
            true => found.beside::<S>(&shape, corner, [0.0; 3]),
            false => [0.0; 3],
        });
        Found { forces, energy: found.energy }
    }

    fn linear_fields<S: Space>() {
        let places = distorted::<S>();
        let mut gradient = S::Tensor::zero();
        (0..S::Tensor::COMPONENTS).for_each(|at| gradient[at] = 0.1 * ((5 * at) % 7) as f64);
        let found = resist::<S>(&places, &places.map(|place| gradient * place));
        assert!(found.forces.iter().all(|force| force.iter().all(|part| part.abs() < 1e-12)), "{:?}", found.forces);
    }

    #[test]
    fn a_linear_field_meets_no_resistance() {
        linear_fields::<Plane>();
        linear_fields::<Solid>();
    }

    /// Every motion of the corners but rigid and linear ones is resisted: twelve in space, two in the plane.
    fn modes_are_stiff<S: Space>(count: usize) {
        let places = distorted::<S>();
        let mut energies = 0;
        for mode in 0..modes::<S>() {
            for axis in 0..S::DIMENSION {
                let moved = std::array::from_fn(|corner| {
                    let mut moved = S::Vector::zero();
                    moved[axis] = 1e-4 * mode_at::<S>(mode, corner);
                    moved
                });
                energies += usize::from(resist::<S>(&places, &moved).energy > 1e-9);
            }
        }
        assert_eq!(energies, count);
    }

    #[test]
    fn no_hourglass_mode_is_free() {
        modes_are_stiff::<Plane>(2);
        modes_are_stiff::<Solid>(12);
    }

    /// Pure bending of a box, u_x = k x y: the energy is that of a plate, E/(1 - nu^2) k^2 I/2 per length.
    #[test]
    fn a_box_bends_as_a_plate_does() {
        let (edges, curvature) = ([2.0, 3.0, 4.0], 1e-5);
        let places: [<Solid as Space>::Vector; CORNERS_MAX] =
            std::array::from_fn(|corner| std::array::from_fn(|axis| 0.5 * edges[axis] * NATURAL[corner][axis]).into());
        let moved = places.map(|place| [curvature * place[0] * place[1], 0.0, 0.0].into());
        let found = resist::<Solid>(&places, &moved);
        let lambda = HOW.p_wave_modulus - 2.0 * HOW.shear_modulus;
        let plate = 4.0 * HOW.shear_modulus * (lambda + HOW.shear_modulus) / (lambda + 2.0 * HOW.shear_modulus);
        let inertia = edges[2] * edges[1] * edges[1] * edges[1] / 12.0;
        let wanted = 0.5 * plate * curvature * curvature * inertia * edges[0];
        assert!((found.energy / wanted - 1.0).abs() < 1e-9, "{} {wanted}", found.energy);
    }

    /// Forces are the gradient of the energy, and have no resultant and no moment about any place.
    #[test]
    fn forces_are_the_gradient_of_their_energy() {
        let places = distorted::<Solid>();
        let moved: [<Solid as Space>::Vector; CORNERS_MAX] = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| 0.2 * (((5 * corner + 3 * axis) % 7) as f64 - 3.0) / 3.0).into()
        });
        let found = resist::<Solid>(&places, &moved);
        for corner in 0..CORNERS_MAX {
            for axis in 0..3 {
                let energy = |way: f64| {
                    let mut moved = moved;
                    moved[corner][axis] += way;
                    resist::<Solid>(&places, &moved).energy
                };
                let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
                assert!((slope + found.forces[corner][axis]).abs() < 1e-7, "{corner} {axis}: {slope}");
            }
        }
        let (mut sum, mut turn) = (<Solid as Space>::Vector::zero(), <Solid as Space>::Vector::zero());
        for (corner, force) in found.forces.iter().enumerate() {
            let force: <Solid as Space>::Vector = (*force).into();
            sum += force;
            turn += (places[corner] + moved[corner]).cross(&force);
        }
        assert!(sum.norm() < 1e-12 && turn.norm() < 1e-12, "{sum} {turn}");
    }

    /// An element that has yielded resists by the square of its secant stiffness, an elastic one by all of it, and no one by less than a hundredth.
    #[test]
    fn what_yields_resists_less() {
        let how = Hourglass { yields: true, ..HOW };
        let identity: Matrix<f64> = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        assert_eq!(how.stiffness_left::<Solid, f64>(&identity, &[[0.0; 3]; 3]), 1.0);
        let strain = 0.01;
        let mut inverse = identity;
        inverse[0][1] = -2.0 * strain;
        let stressed = |share: f64| {
            let mut stress = identity.map(|row| row.map(|entry| -7.0 * entry));
            (stress[0][1], stress[1][0]) = (2.0 * 3.0 * strain * share, 2.0 * 3.0 * strain * share);
            how.stiffness_left::<Solid, f64>(&inverse, &stress)
        };
        for (share, wanted) in [(1.0, 1.0), (2.0, 1.0), (0.5, 0.25), (0.3, 0.09), (0.01, 0.01)] {
            assert!((stressed(share) / wanted - 1.0).abs() < 0.01, "{share}: {}", stressed(share));
        }
    }

    /// A turn of the whole element changes no energy, and forces turn with it.
    #[test]
    fn a_turned_element_resists_as_before() {
        let places = distorted::<Solid>();
        let bent = std::array::from_fn(|corner| {
            [0.01 * mode_at::<Solid>(1, corner), 0.02 * mode_at::<Solid>(2, corner), 0.0].into()
        });
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let turned = std::array::from_fn(|corner| turn * (places[corner] + bent[corner]) - places[corner]);
        let (before, after) = (resist::<Solid>(&places, &bent), resist::<Solid>(&places, &turned));
        assert!((after.energy / before.energy - 1.0).abs() < 1e-10);
        for (force, found) in before.forces.iter().zip(&after.forces) {
            let (force, found): (<Solid as Space>::Vector, <Solid as Space>::Vector) =
                ((*force).into(), (*found).into());
            assert!((turn * force - found).norm() < 1e-10 * force.norm().max(1e-3));
        }
    }
}
