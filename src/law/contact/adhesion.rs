//! Adhesion, a part of any law: Derjaguin, Muller & Toporov (1975).
//!
//! ```text
//! F_n = F_law - 4 pi gamma R    while surfaces overlap      R = r_1 r_2/(r_1 + r_2)
//! ```
//!
//! gamma is the surface energy of the solid, J/m2, half of the work that parts a unit of two surfaces. What a contact bears in tension at
//! most, 4 pi gamma R, does not depend on how far it overlaps, and nothing acts between surfaces that are apart. Friction is limited by
//! the force of the law, as if the pull were a load. Against a flat body R is the grain's radius. Discs pull as spheres of their radius.

use super::{Answer, ContactLaw, Springs, Touch};
use crate::base::keys::{Form, POSITIVE, STIFFNESS, number};
use crate::base::lane::Real;
use crate::base::math::PI;
use crate::base::space::Space;

/// How much surfaces attract each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adhesion {
    /// gamma, J/m2.
    pub surface_energy: f64,
}

impl Adhesion {
    /// Keys of the part, which is not there where none is typed.
    pub(super) fn keys(part: &mut Option<Self>, form: &mut dyn Form) {
        let mut energy = part.map(|part| part.surface_energy);
        let about = "gamma in J/m2, with which grains adhere: 4 pi gamma R parts two of them";
        let key = number("surface_energy", about, STIFFNESS, POSITIVE, "\"50 mJ/m2\"").optional();
        form.number_if_given(&mut energy, key);
        *part = energy.map(|surface_energy| Self { surface_energy });
    }

    /// What parts two grains, N.
    #[inline(always)]
    fn pull<R: Real>(&self, radius_a: R, radius_b: R) -> R {
        radius_a * (radius_b / (radius_a + radius_b)) * R::splat(4.0 * PI * self.surface_energy)
    }
}

/// A law whose grains adhere to each other.
#[derive(Clone, Copy, Debug)]
pub struct Adhesive<C> {
    /// The law without the pull.
    pub law: C,
    /// The pull, which every contact has.
    pub adhesion: Adhesion,
}

impl<S: Space, C: ContactLaw<S>> ContactLaw<S> for Adhesive<C> {
    type Memory<R: Real> = C::Memory<R>;

    fn reach(&self) -> f64 {
        self.law.reach()
    }

    #[inline(always)]
    fn holds<R: Real>(&self, touch: &Touch<S, R>, memory: &Self::Memory<R>) -> R::Mask {
        self.law.holds(touch, memory)
    }

    #[inline(always)]
    fn force<R: Real>(&self, touch: &Touch<S, R>, memory: &mut Self::Memory<R>) -> Answer<S, R> {
        let answer = self.law.force(touch, memory);
        Answer { normal: answer.normal - self.adhesion.pull(touch.radius_a, touch.radius_b), ..answer }
    }

    #[inline(always)]
    fn sliding<R: Real>(&self, touch: &Touch<S, R>) -> S::TangentOf<R> {
        self.law.sliding(touch)
    }

    #[inline(always)]
    fn stiffness_tangential<R: Real>(&self, touch: &Touch<S, R>) -> R {
        self.law.stiffness_tangential(touch)
    }

    fn springs(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> Answer<S, f64> {
        let answer = self.law.springs(touch, memory);
        Answer { normal: answer.normal - self.adhesion.pull(touch.radius_a, touch.radius_b), ..answer }
    }

    fn stiffness(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
        self.law.stiffness(radii, masses, overlap)
    }

    fn friction_limit(&self, touch: &Touch<S, f64>, normal: f64) -> f64 {
        self.law.friction_limit(touch, normal + self.adhesion.pull(touch.radius_a, touch.radius_b))
    }

    /// With that of the pull, which is nought where surfaces part.
    fn elastic_energy(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> f64 {
        self.law.elastic_energy(touch, memory) - self.adhesion.pull(touch.radius_a, touch.radius_b) * touch.overlap
    }
}
