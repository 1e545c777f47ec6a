//! How many steps of grains an increment of deformation takes.
//!
//! A quasi-static increment may take any time of the grains' own, as long as inertia has no say in it: the inertial number
//!
//! ```text
//! I = |d eps| d sqrt(rho/p)/(n dt)                    |d eps| = sqrt(2 e:e + (tr d eps)^2/D)
//! ```
//!
//! with e the deviator of the increment, d the mean diameter, rho the density of grains and D the number of axes, stays below a bound,
//! which says n. A bound on strain alone would depend on the pressure (da Cruz et al. 2005; neither Liang & Zhao 2019 nor Liu et al. 2016
//! give one). In a synchronous drive grains have the time of the continuum.

use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;

/// What time grains have for an increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// As much as keeps the inertial number below this.
    QuasiStatic {
        /// Bound on I.
        inertial_number: f64,
    },
    /// That of the continuum.
    Synchronous,
}

/// What of an increment the cell of a point is driven by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// All of it.
    #[default]
    Full,
    /// The rate of deformation alone, in a frame that turns with R of F = R U; the stress is turned back (Liu et al. 2016, box B1). What U turns beside R does
    /// not reach the grains: in simple shear their axes are off by 1.5 degrees at a strain of 1, and by 6.1 at 1.8.
    Corotational,
}

impl Frame {
    /// As jobs name them.
    pub const NAMES: [(&'static str, Self); 2] = [("full", Self::Full), ("corotational", Self::Corotational)];

    /// Where a cell at `cell` goes to in an increment `more`, F(n+1) F(n)^-1 - 1 of its point or a mean of it, of which the point's own leads from one F to another.
    pub fn target<S: Space>(self, more: &S::Tensor, [from, to]: [&S::Tensor; 2], cell: &S::Tensor) -> S::Tensor {
        match self {
            Self::Full => (S::identity() + *more) * *cell,
            Self::Corotational => {
                let middle = S::inverse(&(S::identity() + *more * 0.5)).unwrap_or_else(S::identity);
                let rate = *more * middle;
                let turn = S::rotation(&((*from + *to) * 0.5));
                let stretch = S::transpose(&turn) * ((rate + S::transpose(&rate)) * 0.25) * turn;
                let back = S::inverse(&(S::identity() - stretch)).unwrap_or_else(S::identity);
                back * (S::identity() + stretch) * *cell
            }
        }
    }

    /// The stress of a point at `deformation` from that of its cell.
    pub fn stress<S: Space>(self, of_cell: S::Symmetric, deformation: &S::Tensor) -> S::Symmetric {
        match self {
            Self::Full => of_cell,
            Self::Corotational => {
                let turn = S::rotation(deformation);
                S::Symmetric::of(&(turn * of_cell.tensor() * S::transpose(&turn)))
            }
        }
    }
}

/// How cells are driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// What time grains have for an increment.
    pub pace: Pace,
    /// Steps of an increment at least.
    pub steps_min: u64,
    /// Steps at rest after it, while forces are out of balance by more than a share.
    pub relaxation: Option<Relaxation>,
}

/// Steps without deformation until forces are balanced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation {
    /// I_uf (Liu et al. 2016, eq. 57).
    pub unbalanced_max: f64,
    /// Steps at rest after which no more are begun, balanced or not.
    pub steps_max: u64,
}

/// What of its grains an increment's number of steps depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Mean diameter, m.
    pub diameter: f64,
    /// kg/m3.
    pub density: f64,
    /// Stable time step, s.
    pub dt: f64,
}

impl Drive {
    /// Steps of an increment of this size under this pressure (Pa) which lasts `duration` of the continuum's time (s), and what each
    /// lasts, s.
    pub fn steps(&self, strain: f64, pressure: f64, duration: f64, grain: &Grain) -> (u64, f64) {
        match self.pace {
            Pace::QuasiStatic { inertial_number } => {
                let time = grain.diameter * (grain.density / pressure).sqrt();
                let count = (strain * time / (inertial_number * grain.dt)).ceil();
                ((count as u64).max(self.steps_min).max(1), grain.dt)
            }
            Pace::Synchronous => {
                // Rounding makes no step more.
                let count = ((duration / grain.dt * (1.0 - 1e-9)).ceil() as u64).max(self.steps_min).max(1);
                (count, duration / count as f64)
            }
        }
    }
}

/// |d eps| of a stretch U.
pub fn size_of<S: Space>(stretch: &S::Tensor) -> f64 {
    let strain = <S::Symmetric as Symmetric>::of(&(*stretch - S::identity())).tensor();
    let mean = S::trace(&strain) / S::DIMENSION as f64;
    let deviator = strain - S::identity() * mean;
    (2.0 * deviator.dot(&deviator) + S::DIMENSION as f64 * mean * mean).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;
    use crate::base::space::Plane;
    use crate::base::symmetric::PlaneSymmetric;

    const GRAIN: Grain = Grain { diameter: 1e-2, density: 2500.0, dt: 1e-5 };

    /// By how much the principal axes of what a cell has gone through, turned back, are off those of its point in simple shear, degrees.
    fn axes_off(frame: Frame, shear: f64) -> f64 {
        const INCREMENTS: u32 = 3000;
        type Tensor = <Plane as Space>::Tensor;
        let at = |step: u32| Tensor::new(1.0, shear * f64::from(step) / f64::from(INCREMENTS), 0.0, 1.0);
        let mut cell = Plane::identity();
        for step in 0..INCREMENTS {
            let (from, to) = (at(step), at(step + 1));
            let more = to * Plane::inverse(&from).unwrap() - Plane::identity();
            cell = frame.target::<Plane>(&more, [&from, &to], &cell);
        }
        let angle = |stretch: Tensor| {
            let along =
                Tensor::new(stretch[0] - stretch[3], -2.0 * stretch[1], 2.0 * stretch[1], stretch[0] - stretch[3]);
            0.5 * Plane::angle(&(along * (1.0 / along.determinant().sqrt()))).to_degrees()
        };
        let of_cell = PlaneSymmetric::of(&(cell * cell.transpose()));
        let turned = frame.stress::<Plane>(of_cell, &at(INCREMENTS)).tensor();
        angle(turned) - angle(at(INCREMENTS) * at(INCREMENTS).transpose())
    }

    #[test]
    fn axes_of_a_corotational_cell_lag_behind_in_simple_shear() {
        for (shear, wanted) in [(1.0, 1.47), (1.8, 6.13), (3.0, 15.67)] {
            let (full, corotational) = (axes_off(Frame::Full, shear), axes_off(Frame::Corotational, shear));
            assert!(full.abs() < 1e-6 && (corotational - wanted).abs() < 0.01, "{shear}: {full} {corotational}");
        }
    }

    #[test]
    fn a_rigid_turn_does_not_reach_a_corotational_cell() {
        let turn = |angle: f64| {
            let (sine, cosine) = (math::sin(angle), math::cos(angle));
            <Plane as Space>::Tensor::new(cosine, -sine, sine, cosine)
        };
        let (from, to) = (turn(0.3), turn(0.5));
        let more = to * from.transpose() - Plane::identity();
        let cell = Frame::Corotational.target::<Plane>(&more, [&from, &to], &Plane::identity());
        assert!((cell - Plane::identity()).norm() < 1e-15, "{cell}");
    }

    #[test]
    fn steps_keep_the_inertial_number() {
        let drive = Drive { pace: Pace::QuasiStatic { inertial_number: 5e-4 }, steps_min: 2, relaxation: None };
        for (strain, pressure) in [(1e-4, 1e5), (1e-3, 4e5), (3e-5, 2e3)] {
            let (count, dt) = drive.steps(strain, pressure, f64::NAN, &GRAIN);
            let inertial = strain * GRAIN.diameter * (GRAIN.density / pressure).sqrt() / (count as f64 * dt);
            assert!(inertial <= 5e-4 && (count == 2 || inertial > 4e-4), "{strain} {pressure}: {count}");
        }
        assert_eq!(drive.steps(0.0, 1e5, f64::NAN, &GRAIN).0, 2);
    }

    #[test]
    fn synchronous_steps_fill_the_increment() {
        let drive = Drive { pace: Pace::Synchronous, steps_min: 1, relaxation: None };
        assert_eq!(drive.steps(1.0, 1.0, 4e-5, &GRAIN), (4, 1e-5));
        let (count, dt) = drive.steps(1.0, 1.0, 3.5e-5, &GRAIN);
        assert!(count == 4 && dt < GRAIN.dt && (dt * 4.0 - 3.5e-5).abs() < 1e-20);
    }

    /// Simple shear by gamma is an increment of gamma; isotropic compression one of its volume strain over the root of the axes.
    #[test]
    fn sizes_of_increments() {
        type Tensor = <Plane as Space>::Tensor;
        let shear = Tensor::new(1.0, 5e-4, 5e-4, 1.0);
        assert!((size_of::<Plane>(&shear) - 1e-3).abs() < 1e-15);
        let isotropic = Tensor::new(1.001, 0.0, 0.0, 1.001);
        assert!((size_of::<Plane>(&isotropic) - 2e-3 / 2f64.sqrt()).abs() < 1e-12);
    }
}
