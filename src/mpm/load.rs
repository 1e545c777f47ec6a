//! Loads on the material: what they are for each point that bears one. They act there, or on the surface ([`crate::mpm::surface`]).

use crate::base::space::{Linear, Space};

/// Loads that a job may have: a point knows its own by the bits of a word, and by those behind them whether it has come off the material,
/// and the sides on which that ends with it.
pub const LOADS_MAX: usize = 57;

/// The bit of a point that has come off: loads on the surface are none of its.
pub const DETACHED: u64 = 1 << LOADS_MAX;

/// The bit of a point of the surface on a side.
pub fn of_side(axis: usize, upper: bool) -> u64 {
    1 << (LOADS_MAX + 1 + 2 * axis + usize::from(upper))
}

/// The loads that a word tells of.
pub fn loads_in(word: u64) -> impl Iterator<Item = usize> {
    let mut left = word & ((1 << LOADS_MAX) - 1);
    std::iter::from_fn(move || {
        let next = (left != 0).then(|| left.trailing_zeros() as usize)?;
        left &= left - 1;
        Some(next)
    })
}

/// What each of its points bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<S: Space> {
    /// Area of a point's side at the start, along the normal out of the material, m2.
    pub area: S::Vector,
    /// What it comes to once the ramp is over.
    pub kind: Kind<S>,
    /// It rises linearly from zero over this time, s.
    pub ramp: f64,
    /// Whether it acts on the surface, or at the points.
    pub on_surface: bool,
}

/// What a load is per area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind<S: Space> {
    /// Force per area of the start, Pa.
    Traction(S::Vector),
    /// Pa, against the normal of the surface as it is.
    Pressure(f64),
}

impl<S: Space> Load<S> {
    /// The axis across which it acts.
    pub fn axis(&self) -> usize {
        (0..S::DIMENSION).find(|axis| self.area[*axis] != 0.0).expect("a load has an area")
    }

    /// Force on a point with deformation gradient `deformation` at `time`, N. The area turns and grows with the surface:
    /// `n a = J F^-T N A` (Nanson).
    pub fn on(&self, deformation: &S::Tensor, time: f64) -> S::Vector {
        let share = if time < self.ramp { time / self.ramp } else { 1.0 };
        match self.kind {
            Kind::Traction(traction) => traction * (share * self.area.norm()),
            Kind::Pressure(pressure) => area_now::<S>(deformation, &self.area) * (-share * pressure),
        }
    }
}

/// `n a = J F^-T N A` (Nanson), m2.
pub fn area_now<S: Space>(deformation: &S::Tensor, area: &S::Vector) -> S::Vector {
    let inverse = S::inverse(deformation).unwrap_or_else(S::identity);
    S::transpose(&inverse) * *area * S::determinant(deformation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;

    type Vector = <Plane as Space>::Vector;
    type Tensor = <Plane as Space>::Tensor;

    #[test]
    fn bits_of_a_word_are_apart() {
        let sides = (0..3).flat_map(|axis| [false, true].map(|upper| of_side(axis, upper)));
        let bits: Vec<u64> = (0..LOADS_MAX).map(|load| 1 << load).chain([DETACHED]).chain(sides).collect();
        assert_eq!(bits.iter().fold(0, |all, bit| all | bit), u64::MAX);
        assert_eq!((bits.len(), loads_in(u64::MAX).count()), (64, LOADS_MAX));
    }

    #[test]
    fn pressure_follows_the_surface_and_traction_does_not() {
        let load = |kind| Load::<Plane> { area: Vector::new(0.0, 2.0), kind, ramp: 4.0, on_surface: false };
        // A quarter turn with the surface stretched to three times its length.
        let turned = Tensor::new(0.0, -1.0, 3.0, 0.0);
        let pressed = load(Kind::Pressure(5.0)).on(&turned, 9.0);
        assert!((pressed - Vector::new(30.0, 0.0)).norm() < 1e-14, "{pressed}");
        let dead = load(Kind::Traction(Vector::new(1.0, 0.0))).on(&turned, 1.0);
        assert!((dead - Vector::new(0.5, 0.0)).norm() < 1e-15, "{dead}");
    }
}
