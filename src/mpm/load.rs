//! Loads on the surface of the material, borne by the points behind it.

use crate::base::space::{Linear, Space};

/// What each of its points bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<S: Space> {
    /// Area of a point's side at the start, along the normal out of the material, m2.
    pub area: S::Vector,
    pub kind: Kind<S>,
    /// It rises linearly from zero over this time, s.
    pub ramp: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind<S: Space> {
    /// Force per area of the start, Pa.
    Traction(S::Vector),
    /// Pa, against the normal of the surface as it is.
    Pressure(f64),
}

impl<S: Space> Load<S> {
    /// Force on a point with deformation gradient `deformation` at `time`, N. The area turns and grows with the surface:
    /// `n a = J F^-T N A` (Nanson).
    pub fn on(&self, deformation: &S::Tensor, time: f64) -> S::Vector {
        let share = if time < self.ramp { time / self.ramp } else { 1.0 };
        match self.kind {
            Kind::Traction(traction) => traction * (share * self.area.norm()),
            Kind::Pressure(pressure) => {
                let inverse = S::inverse(deformation).unwrap_or_else(S::identity);
                let area = S::transpose(&inverse) * self.area * S::determinant(deformation);
                area * (-share * pressure)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;

    type Vector = <Plane as Space>::Vector;
    type Tensor = <Plane as Space>::Tensor;

    #[test]
    fn pressure_follows_the_surface_and_traction_does_not() {
        let load = |kind| Load::<Plane> { area: Vector::new(0.0, 2.0), kind, ramp: 4.0 };
        // A quarter turn with the surface stretched to three times its length.
        let turned = Tensor::new(0.0, -1.0, 3.0, 0.0);
        let pressed = load(Kind::Pressure(5.0)).on(&turned, 9.0);
        assert!((pressed - Vector::new(30.0, 0.0)).norm() < 1e-14, "{pressed}");
        let dead = load(Kind::Traction(Vector::new(1.0, 0.0))).on(&turned, 1.0);
        assert!((dead - Vector::new(0.5, 0.0)).norm() < 1e-15, "{dead}");
    }
}
