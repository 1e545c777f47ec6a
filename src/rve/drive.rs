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
    QuasiStatic { inertial_number: f64 },
    /// That of the continuum.
    Synchronous,
}

/// How cells are driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
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
    use crate::base::space::Plane;

    const GRAIN: Grain = Grain { diameter: 1e-2, density: 2500.0, dt: 1e-5 };

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
