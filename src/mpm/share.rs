//! What part of a node's mass holds the grains there, direction by direction.

use crate::base::space::Space;

/// What is along membranes, a symmetric tensor of the plane: xx, xy, yy.
pub type Along = [f64; 3];

/// `S = s 1 - A`: s is the share that continuum and membranes have of all mass, and `A = sum m t t / sum m` that of membranes along
/// themselves (t), where grains slide on them. There are membranes in the plane alone; in space A is zero and not looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share<S: Space> {
    /// s, 0 to 1.
    pub all: f64,
    /// A; zero where no membrane is near.
    pub along: Along,
    space: std::marker::PhantomData<S>,
}

/// `m t t` of a mass along a unit vector of the plane.
pub fn dyad<S: Space>(mass: f64, along: &S::Vector) -> Along {
    [mass * along[0] * along[0], mass * along[0] * along[1], mass * along[1] * along[1]]
}

impl<S: Space> Share<S> {
    /// Of s and A.
    pub const fn new(all: f64, along: Along) -> Self {
        Self { all, along, space: std::marker::PhantomData }
    }

    /// Whether no direction is held less than another: where no membrane is near.
    pub fn is_even(&self) -> bool {
        S::DIMENSION > 2 || self.along == [0.0; 3]
    }

    /// `S v`.
    pub fn of(&self, v: &S::Vector) -> S::Vector {
        let mut held = *v * self.all;
        if !self.is_even() {
            let [xx, xy, yy] = self.along;
            held[0] -= xx * v[0] + xy * v[1];
            held[1] -= xy * v[0] + yy * v[1];
        }
        held
    }

    /// `min(S/enough, 1) v`, the least taken direction by direction: what is left of v where less than `enough` holds.
    pub fn left_of(&self, v: &S::Vector, enough: f64) -> S::Vector {
        let left = |share: f64| (share * (1.0 / enough)).min(1.0);
        if self.is_even() {
            return *v * left(self.all);
        }
        // Principal shares m + r and m - r; a function of S is (f+ + f-)/2 1 + (f+ - f-)/(2 r) (S - m 1).
        let [xx, xy, yy] = self.along;
        let (mean, half) = (self.all - 0.5 * (xx + yy), 0.5 * (yy - xx));
        let radius = (half * half + xy * xy).sqrt();
        let (most, least) = (left(mean + radius), left(mean - radius));
        let (even, odd) = (0.5 * (most + least), if radius > 0.0 { 0.5 * (most - least) / radius } else { 0.0 });
        let mut rest = *v * even;
        rest[0] += odd * (half * v[0] - xy * v[1]);
        rest[1] += odd * (-half * v[1] - xy * v[0]);
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;
    use crate::base::space::{Plane, Solid};

    type Vector = <Plane as Space>::Vector;

    fn beside_membrane(all: f64, membrane: f64, angle: f64) -> (Share<Plane>, Vector, Vector) {
        let along = Vector::new(math::cos(angle), math::sin(angle));
        (Share::new(all, dyad::<Plane>(membrane, &along)), along, Vector::new(-math::sin(angle), math::cos(angle)))
    }

    #[test]
    fn a_membrane_holds_by_its_normal_alone() {
        let (share, along, normal) = beside_membrane(0.3, 0.3, 0.7);
        let v = along * 2.0 + normal * 5.0;
        assert!((share.of(&v) - normal * 1.5).norm() < 1e-15);
        // 0.3 is enough where 0.25 is, and along the membrane nothing is left.
        assert!((share.left_of(&v, 0.25) - normal * 5.0).norm() < 1e-14);
        assert!((share.left_of(&v, 0.6) - normal * 2.5).norm() < 1e-14);
    }

    #[test]
    fn points_beside_a_membrane_hold_every_way() {
        let (share, along, normal) = beside_membrane(0.5, 0.4, -1.2);
        let v = along * 2.0 - normal * 3.0;
        assert!((share.of(&v) - (along * 0.2 - normal * 1.5)).norm() < 1e-15);
        assert!((share.left_of(&v, 0.2) - (along - normal * 3.0)).norm() < 1e-14);
    }

    #[test]
    fn without_membranes_a_share_is_a_number() {
        let share = Share::<Plane>::new(0.125, [0.0; 3]);
        let v = Vector::new(3.0, -4.0);
        assert_eq!(share.of(&v), v * 0.125);
        assert_eq!(share.left_of(&v, 0.25), v * 0.5);
        let w = <Solid as Space>::Vector::new(1.0, 2.0, 3.0);
        assert_eq!(Share::<Solid>::new(0.5, [0.0; 3]).left_of(&w, 0.25), w);
    }
}
