//! What is reported of stress and deformation: Liang and Zhao (2019), section 2.2.2.
//!
//! Tension positive, d the dimension; F is the deformation gradient since the start.
//!
//! ```text
//! p = tr(sigma)/d,  s = sigma - p I,  q = sqrt(s:s/2)                                           (31 to 33)
//! eps = ln(F F^T)/2,  eps_v = tr(eps) = ln(det F),  e = dev(eps),  eps_q = sqrt(2 e:e)          (34, 35)
//! F = R U,  theta: angle of R                                                                   (36 to 40)
//! ```
//!
//! In simple shear q is the shear stress and eps_q, to first order, the engineering shear strain, in the plane as in
//! space. The paper does not say which strain; the logarithmic one is that of the laws.

use crate::base::space::Space;
use crate::base::symmetric::Symmetric;

/// Mean and deviatoric stress, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressInvariants {
    /// p, negative in compression.
    pub mean: f64,
    /// q >= 0.
    pub deviatoric: f64,
}

impl StressInvariants {
    /// Of the stress in the plane, or in space.
    pub fn of<S: Space>(stress: &S::Tensor) -> Self {
        let stress = S::Symmetric::of(stress);
        let mean = stress.trace() / S::DIMENSION as f64;
        Self { mean, deviatoric: (0.5 * stress.deviator().square()).sqrt() }
    }
}

/// eps = ln(F F^T)/2 of a gradient with a positive determinant; others have no logarithm.
pub fn logarithmic_strain<S: Space>(gradient: &S::Tensor) -> S::Symmetric {
    S::Symmetric::isotropic(0.0).pushed(&(*gradient - S::identity())).half_logarithm()
}

/// What a deformation gradient amounts to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deformation {
    /// eps_v.
    pub volumetric: f64,
    /// eps_q >= 0.
    pub deviatoric: f64,
    /// theta, rad: see [`Space::angle`].
    pub rotation_angle: f64,
}

impl Deformation {
    /// Of a gradient with a positive determinant; others have no logarithm.
    pub fn of<S: Space>(gradient: &S::Tensor) -> Self {
        let strain = logarithmic_strain::<S>(gradient);
        Self {
            volumetric: strain.trace(),
            deviatoric: (2.0 * strain.deviator().square()).sqrt(),
            rotation_angle: S::angle(&S::rotation(gradient)),
        }
    }
}
