//! Material that is a grain assembly at every point ([`crate::rve`]). Its stress is that of the grains, which follow the deformation of
//! their point after the step of the continuum has given it; until then, and in between, it is what it was.

use super::chosen::Described;
use super::hencky::p_wave_modulus;
use super::{Flow, MaterialLaw, MaterialMemory};
use crate::base::keys::Form;
use crate::base::lane::Real;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Space, Words};
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
    /// Logarithmic volume strain since the last contact was lost; zero of grains that touch.
    pub opened: f64,
}

impl<S: Space> Default for GrainMemory<S> {
    fn default() -> Self {
        Self { stress: S::Symmetric::default(), strain: 0.0, fraction: 0.0, opened: 0.0 }
    }
}

numbers!(impl[S: Space] GrainMemory[S] {
    stress: S::Symmetric,
    strain: f64,
    fraction: f64,
    opened: f64,
});

impl<S: Space> Record for GrainMemory<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("stress_of_grains", self.stress.as_mut_slice());
        visitor.f64s("strain_of_grains", std::slice::from_mut(&mut self.strain));
        visitor.f64s("fraction_of_grains", std::slice::from_mut(&mut self.fraction));
        visitor.f64s("opened_of_grains", std::slice::from_mut(&mut self.opened));
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

/// Strain of an increment, against its middle.
pub fn increment_of<S: Space>([from, to]: [&S::Tensor; 2]) -> S::Symmetric {
    let middle = S::inverse(&((*from + *to) * 0.5)).expect("grains have followed this increment");
    S::Symmetric::of(&((*to - *from) * middle))
}

/// sqrt(2 e:e) of the deviator e.
fn deviator_size<S: Space>(tensor: &S::Symmetric) -> f64 {
    let trace = tensor.trace();
    (2.0 * (tensor.contract(tensor) - trace * trace / S::DIMENSION as f64).max(0.0)).sqrt()
}

/// What an increment of a point came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    /// Work of stress in the middle of it, J per initial volume (m3).
    pub work: f64,
    /// Deviatoric strain beyond what the change of stress would take of elastic grains that all move with the mean field: what is not elastic
    /// of it, at most.
    pub plastic_strain: f64,
}

impl<S: Space> GrainMemory<S> {
    /// Carries it over an increment from one deformation gradient to another, of the grains and of the point, which are two where strain is
    /// nonlocal. At its end grains bear `stress` (Pa), and have `opened` so far; `shear_modulus` (Pa) is that of the mean field.
    pub fn follow(
        &mut self,
        [of_grains, of_point @ [from, to]]: [[&S::Tensor; 2]; 2],
        (stress, opened): (S::Symmetric, f64),
        shear_modulus: f64,
    ) -> Followed {
        let strain = increment_of::<S>(of_grains);
        let work = 0.5 * (self.stress + stress).contract(&strain);
        let elastic = deviator_size::<S>(&(stress - self.stress)) / (2.0 * shear_modulus);
        self.strain += deviator_size::<S>(&increment_of::<S>(of_point));
        self.fraction *= S::determinant(from) / S::determinant(to);
        (self.stress, self.opened) = (stress, opened);
        Followed { work, plastic_strain: (deviator_size::<S>(&strain) - elastic).max(0.0) }
    }
}

impl<S: Space> MaterialLaw<S> for GrainAssembly {
    type Memory = GrainMemory<S>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> GrainMemory<S> {
        GrainMemory { stress: S::Symmetric::of(stress), fraction, ..GrainMemory::default() }
    }

    /// Grains follow later.
    fn update_counted(&self, _: &S::Tensor, _: f64, memory: &mut GrainMemory<S>, _: &mut f64) -> S::Tensor {
        memory.stress.tensor()
    }

    /// Volume strain is remembered by the mean stress, as that of a law is: grains that all move with the mean field are the stiffest, so that
    /// averaging never goes too far. Points flow when their grains have followed.
    #[inline(always)]
    fn flow<R: Real>(&self, memory: &[R], stress: &S::SymmetricOf<R>) -> Option<Flow<R>> {
        let (strain, opened) = (S::Symmetric::COUNT, S::Symmetric::COUNT + 2);
        let elastic = stress.trace() * R::splat(1.0 / (S::DIMENSION as f64 * self.0.bulk_modulus));
        Some(Flow { volume: elastic + memory[opened], plastic_strain: memory[strain] })
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
