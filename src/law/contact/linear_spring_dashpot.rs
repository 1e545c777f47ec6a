//! Linear spring and dashpot with a tangential spring and a Coulomb limit: Cundall & Strack (1979) in the form of
//! Chen et al. (2021), section 2.1.
//!
//! With the overlap d, the opening velocity v_n and the sliding velocity v_t:
//!
//! ```text
//! F_n = k_n d - gamma_n v_n                      repulsive positive; it may pull while a contact opens
//! s  += v_t dt
//! F_t = -k_t s - gamma_t v_t
//! |F_t| > mu |F_n|:  F_t is cut to the cone, s = -(F_t + gamma_t v_t)/k_t
//! ```
//!
//! Damping is absolute (N s/m) and enters in full, as in Table 1 of the paper. The spring is forgotten at the first step
//! without overlap. Stable only for time steps below [`crate::scenario::derived`]'s bounds, which include the damping.

use super::{Answer, ContactLaw, Touch};
use crate::scenario;
use crate::space::{Linear, Space};

/// The law with its constants; units as in [`scenario::Linear`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSpringDashpot {
    pub constants: scenario::Linear,
}

impl<S: Space> ContactLaw<S> for LinearSpringDashpot {
    /// The tangential spring s, m.
    type Memory = S::Tangent;

    #[inline(always)]
    fn force(&self, touch: &Touch<S>, spring: &mut S::Tangent) -> Answer<S> {
        let law = &self.constants;
        let normal = law.stiffness_normal * touch.overlap - law.damping_normal * touch.velocity_normal;
        *spring += touch.velocity_tangential * touch.advance;
        let damping = touch.velocity_tangential * law.damping_tangential;
        let mut tangential = -(*spring * law.stiffness_tangential) - damping;

        let limit = law.friction * normal.abs();
        let magnitude = tangential.norm();
        if magnitude > limit {
            // A contact without a spring yet has no direction to slide in; it starts free of tangential force.
            if *spring == S::Tangent::zero() {
                tangential = S::Tangent::zero();
            } else {
                tangential = tangential * (limit / magnitude);
                *spring = (tangential + damping) * (-1.0 / law.stiffness_tangential);
            }
        }
        Answer { normal, tangential }
    }

    fn elastic_energy(&self, overlap: f64, spring: &S::Tangent) -> f64 {
        let law = &self.constants;
        0.5 * law.stiffness_normal * overlap * overlap + 0.5 * law.stiffness_tangential * spring.dot(spring)
    }
}
