//! Stress from deformation inside a continuum.

use std::fmt::Debug;

use crate::base::lane::Real;
use crate::base::numbers::Numbers;
use crate::base::record::Record;
use crate::base::space::{Linear, Space, Words};
use crate::base::symmetric::Symmetric;

mod absent;
pub mod chosen;
pub mod cone;
mod critical_drucker_prager;
mod elastic;
mod grains;
mod hencky;
mod linear_elastic;
mod measures;
mod mobilised_friction;
pub use absent::{Absent, Nothing};
pub use chosen::{ConstitutiveLaw, Described, ForAnyMaterial, Objection};
pub use critical_drucker_prager::{CriticalConstants, CriticalDruckerPrager, CriticalMemory};
pub use elastic::Elastic;
pub use grains::{Followed, GrainAssembly, GrainMemory, GrainModuli, increment_of};
pub use hencky::Hencky;
pub use linear_elastic::LinearElastic;
pub use mobilised_friction::{MobilisedConstants, MobilisedFriction, MobilisedMemory, RELOADING_SHARE};

/// A material law with a memory per material point, so that an assembly of grains can be one as well.
///
/// In the plane a law's bulk modulus is the plane's, `p = tr(tau)/2 = K tr(eps)`: that of a body in plane strain,
/// `K = K_body + G/3`, with the same shear modulus and the same `K - G = lambda`.
pub trait MaterialLaw<S: Space>: Debug + Send + Sync + 'static {
    /// State of a point.
    type Memory: MaterialMemory;

    /// Memory of a point whose Kirchhoff stress is the symmetric tensor `stress` (Pa, tension positive) at packing
    /// fraction `fraction`; of a stress that the law does not bear, the one that it returns it to.
    fn start(&self, stress: &S::Tensor, fraction: f64) -> Self::Memory;

    /// A point that was loaded to this share of its peak strength ([`Self::mobilised`]) before has at least the hardening of that loading.
    fn harden(&self, _memory: &mut Self::Memory, _mobilised: f64) {}

    /// Carries the memory over one step with velocity gradient `gradient` (1/s) and returns the Kirchhoff stress, Pa,
    /// tension positive.
    fn update(&self, gradient: &S::Tensor, dt: f64, memory: &mut Self::Memory) -> S::Tensor {
        self.update_counted(gradient, dt, memory, &mut 0.0)
    }

    /// The same, and adds to `work` what the step dissipated: stress at its end times plastic strain increment, J per
    /// initial volume (m3).
    fn update_counted(&self, gradient: &S::Tensor, dt: f64, memory: &mut Self::Memory, work: &mut f64) -> S::Tensor;

    /// The same of several points in step, `memory` being their memories word by word; the same bits as one by one, which
    /// is how it is done where a law knows no better.
    #[inline(always)]
    fn update_lanes<R: Real>(
        &self,
        gradient: &S::TensorOf<R>,
        dt: f64,
        memory: &mut [R],
        work: &mut R,
    ) -> S::SymmetricOf<R> {
        let mut stresses = S::SymmetricOf::<R>::zero();
        for lane in 0..R::COUNT {
            let of = |word: R| word.numbers().as_ref()[lane];
            let with = |word: R, number: f64| {
                let mut numbers = word.numbers();
                numbers.as_mut()[lane] = number;
                R::of_numbers(&numbers)
            };
            let (mut single, mut rate, mut spent) = (Self::Memory::default(), S::Tensor::zero(), of(*work));
            for (number, word) in single.numbers_mut().iter_mut().zip(&*memory) {
                *number = of(*word);
            }
            for component in 0..S::Tensor::COMPONENTS {
                rate[component] = of(gradient.word(component));
            }
            let stress = S::Symmetric::of(&self.update_counted(&rate, dt, &mut single, &mut spent));
            for (word, number) in memory.iter_mut().zip(single.numbers()) {
                *word = with(*word, *number);
            }
            for word in 0..S::Symmetric::COUNT {
                stresses.set_word(word, with(stresses.word(word), stress.word(word)));
            }
            *work = with(*work, spent);
        }
        stresses
    }

    /// Of points with these memories under these stresses; nothing of a law that does not flow.
    #[inline(always)]
    fn flow<R: Real>(&self, _memory: &[R], _stress: &S::SymmetricOf<R>) -> Option<Flow<R>> {
        None
    }

    /// Kirchhoff stress of a memory as it is, Pa.
    fn stress(&self, memory: &Self::Memory) -> S::Tensor;

    /// In the plane the Kirchhoff stress normal to it, Pa; 0 in space, and where a law has none.
    fn out_of_plane(&self, memory: &Self::Memory) -> f64;

    /// Elastic energy per initial volume, J/m3.
    fn elastic_energy(&self, memory: &Self::Memory) -> f64;

    /// Stiffness against uniaxial strain, Pa: `K + G` in the plane, `K + 4 G/3` in space. Over the density it is the
    /// square of the speed of the fastest wave.
    fn p_wave_modulus(&self) -> f64;

    /// G, Pa; over the density the square of the speed of shear waves.
    fn shear_modulus(&self) -> f64;

    /// Shear stress sqrt(J2) over the most that is ever borne at this mean stress and fraction, of a Kirchhoff stress (Pa, tension positive); infinite where only separation is left,
    /// 0 of a law that bears any.
    fn mobilised(&self, _stress: &S::Symmetric, _fraction: f64) -> f64 {
        0.0
    }
}

/// Of sqrt(J2) what share of `most` it is, both Pa.
fn share_of_strength<T: Symmetric<f64>>(stress: &T, most: f64) -> f64 {
    if most > 0.0 { (0.5 * stress.deviator().square()).sqrt() / most } else { f64::INFINITY }
}

/// A law that is written in lanes, of one point: the memory of the law is its words.
#[inline(always)]
fn alone<S: Space, L: MaterialLaw<S>>(
    law: &L,
    gradient: &S::Tensor,
    dt: f64,
    memory: &mut L::Memory,
    work: &mut f64,
) -> S::Tensor {
    let mut rate = S::TensorOf::<f64>::zero();
    for component in 0..S::Tensor::COMPONENTS {
        rate.set_word(component, gradient[component]);
    }
    let stress = law.update_lanes::<f64>(&rate, dt, memory.numbers_mut(), work);
    let mut symmetric = S::Symmetric::zero();
    for word in 0..S::Symmetric::COUNT {
        symmetric.set_word(word, stress.word(word));
    }
    symmetric.tensor()
}

/// What a law that flows says of a point.
#[derive(Clone, Copy, Debug)]
pub struct Flow<R> {
    /// Volume strain that the point remembers: that of its mean stress, and what has opened and not closed again.
    pub volume: R,
    /// Integral of |deps_p/dt|.
    pub plastic_strain: R,
}

/// What every material memory can say of itself; as a [`Record`] it travels and is stored.
pub trait MaterialMemory: Record + Numbers + Copy + Default + Send + Sync + Debug + PartialEq + 'static {
    /// Accumulated plastic strain, the integral of |deps_p/dt|.
    fn plastic_strain(&self) -> f64;
    /// Solid volume fraction that the law works with.
    fn fraction(&self) -> f64;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Plane, Solid};

    /// Under 100 kPa, sheared by so many Pa.
    fn sheared<S: Space>(shear: f64) -> S::Tensor {
        let mut stress = S::identity() * -100e3;
        (stress[1], stress[S::DIMENSION]) = (shear, shear);
        stress
    }

    fn what_is_returned_has_mobilised_all<S: Space>(law: &impl MaterialLaw<S>) {
        let share = |stress: &S::Tensor, fraction: f64| law.mobilised(&S::Symmetric::of(stress), fraction);
        // Far beyond what either bears; the law keeps what is on its cone.
        let kept = law.stress(&law.start(&sheared::<S>(90e3), 0.84));
        assert!((share(&kept, 0.84) - 1.0).abs() < 1e-8, "{kept:?} is {}", share(&kept, 0.84));
        let [half, whole] = [0.5, 1.0].map(|part| share(&sheared::<S>(part * 40e3), 0.84));
        assert!((2.0 * half - whole).abs() < 1e-12 && (0.3..2.0).contains(&whole), "{half} and {whole}");
        // Looser is weaker, and what is pulled bears nothing.
        assert!(share(&sheared::<S>(40e3), 0.82) > whole);
        assert_eq!(share(&(S::identity() * 1e3), 0.84), f64::INFINITY);
    }

    #[test]
    fn strength_is_that_of_the_cone_which_stresses_return_to() {
        let sand = CriticalDruckerPrager::of(&CriticalConstants::CHEN);
        what_is_returned_has_mobilised_all::<Plane>(&sand);
        what_is_returned_has_mobilised_all::<Solid>(&sand);
        let sand = MobilisedFriction::of(&MobilisedConstants::DISCS);
        what_is_returned_has_mobilised_all::<Plane>(&sand);
        what_is_returned_has_mobilised_all::<Solid>(&sand);
        let elastic = Hencky { bulk_modulus: 1e6, shear_modulus: 1e6 };
        assert_eq!(MaterialLaw::<Plane>::mobilised(&elastic, &Symmetric::of(&sheared::<Plane>(1e9)), 0.8), 0.0);
    }
}
