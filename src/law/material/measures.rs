//! Elastic logarithmic strains by their invariants, as laws with a cone of friction return them.

use crate::base::lane::Real;
use crate::base::symmetric::Symmetric;

/// Invariants of an elastic logarithmic strain: all that a return needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measures<R> {
    /// tr(eps).
    pub volume: R,
    /// sqrt(dev(eps):dev(eps)/2) >= 0; in the plane half of the difference of the principal strains.
    pub shear: R,
}

/// A logarithmic strain, taken apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<R, T> {
    pub measures: Measures<R>,
    pub deviator: T,
}

impl<R: Real, T: Symmetric<R>> Parts<R, T> {
    #[inline(always)]
    pub fn of(strain: &T) -> Self {
        let deviator = strain.deviator();
        let measures = Measures { volume: strain.trace(), shear: (R::splat(0.5) * deviator.square()).sqrt() };
        Self { measures, deviator }
    }

    /// The strain with other invariants.
    #[inline(always)]
    pub fn with(&self, measures: Measures<R>) -> T {
        let Measures { volume, shear } = measures;
        let zero = R::splat(0.0);
        let scale = R::choose(shear.above(zero), shear / self.measures.shear, zero);
        self.deviator * scale + T::isotropic(volume / R::splat(T::DIMENSION as f64))
    }
}
