//! Material that is a grain assembly at every point ([`crate::rve`]). Its stress is that of the grains, which follow the deformation of
//! their point after the step of the continuum has given it; until then, and in between, it is what it was.

use super::chosen::Described;
use super::hencky::p_wave_modulus;
use super::{MaterialLaw, MaterialMemory};
use crate::base::keys::Form;
use crate::base::record::{Record, Visitor};
use crate::base::space::Space;
use crate::base::symmetric::Symmetric;
use crate::numbers;

/// Moduli of the assembly if every grain moved with the mean field, which bound its own from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainModuli {
    /// lambda + G in the plane, lambda + 2 G/3 in space, Pa.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
}

impl Described for GrainModuli {
    /// Grains have tables of their own.
    fn keys(&mut self, _: &mut dyn Form) {}

    fn bulk_modulus_in(&self, _: usize) -> f64 {
        self.bulk_modulus
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }
}

/// The law of points that carry grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainAssembly(pub GrainModuli);

/// What a point remembers of its grains.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct GrainMemory<S: Space> {
    /// Kirchhoff stress, Pa.
    pub stress: S::Symmetric,
    /// Integral of sqrt(2 e:e) over the deviators e of strain increments (Liang & Zhao 2019, eq. 35).
    pub strain: f64,
    /// Solid volume fraction.
    pub fraction: f64,
}

impl<S: Space> Default for GrainMemory<S> {
    fn default() -> Self {
        Self { stress: S::Symmetric::default(), strain: 0.0, fraction: 0.0 }
    }
}

numbers!(impl[S: Space] GrainMemory[S] {
    stress: S::Symmetric,
    strain: f64,
    fraction: f64,
});

impl<S: Space> Record for GrainMemory<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("stress_of_grains", self.stress.as_mut_slice());
        visitor.f64s("strain_of_grains", std::slice::from_mut(&mut self.strain));
        visitor.f64s("fraction_of_grains", std::slice::from_mut(&mut self.fraction));
    }
}

impl<S: Space> MaterialMemory for GrainMemory<S> {
    /// All deviatoric strain: grains do not tell what of it is plastic.
    fn plastic_strain(&self) -> f64 {
        self.strain
    }
    fn fraction(&self) -> f64 {
        self.fraction
    }
}

impl<S: Space> GrainMemory<S> {
    /// Carries it over an increment from one deformation gradient to another, at whose end grains bear `stress` (Pa). Returns the work of
    /// stress in the middle of it, J per initial volume (m3).
    pub fn follow(&mut self, [from, to]: [&S::Tensor; 2], stress: S::Symmetric) -> f64 {
        let half = S::inverse(&((*from + *to) * 0.5)).expect("grains have followed this increment");
        let strain = S::Symmetric::of(&((*to - *from) * half));
        let work = 0.5 * (self.stress + stress).contract(&strain);
        let mean = strain.trace() / S::DIMENSION as f64;
        let square = strain.contract(&strain) - S::DIMENSION as f64 * mean * mean;
        self.strain += (2.0 * square.max(0.0)).sqrt();
        self.fraction *= S::determinant(from) / S::determinant(to);
        self.stress = stress;
        work
    }
}

impl<S: Space> MaterialLaw<S> for GrainAssembly {
    type Memory = GrainMemory<S>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> GrainMemory<S> {
        GrainMemory { stress: S::Symmetric::of(stress), strain: 0.0, fraction }
    }

    /// Grains follow later.
    fn update_counted(&self, _: &S::Tensor, _: f64, memory: &mut GrainMemory<S>, _: &mut f64) -> S::Tensor {
        memory.stress.tensor()
    }

    fn stress(&self, memory: &GrainMemory<S>) -> S::Tensor {
        memory.stress.tensor()
    }

    /// Grains of the plane bear nothing across it.
    fn out_of_plane(&self, _: &GrainMemory<S>) -> f64 {
        0.0
    }

    /// It is not known what of their work grains have stored: all of it counts as taken up.
    fn elastic_energy(&self, _: &GrainMemory<S>) -> f64 {
        0.0
    }

    fn p_wave_modulus(&self) -> f64 {
        p_wave_modulus::<S>(self.0.bulk_modulus, self.0.shear_modulus)
    }

    fn shear_modulus(&self) -> f64 {
        self.0.shear_modulus
    }
}
