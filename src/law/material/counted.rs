//! Any law with the energy that it dissipates: a memory of its own, so that runs that do not ask do not carry it.

use super::{MaterialLaw, MaterialMemory};
use crate::base::lane::Real;
use crate::base::numbers::Numbers;
use crate::base::record::{Record, Visitor};
use crate::base::space::Space;
use crate::numbers;

/// A law whose memory sums up what [`MaterialLaw::update_counted`] says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counted<L>(pub L);

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct CountedMemory<M> {
    pub memory: M,
    /// J per initial volume, m3.
    pub plastic_work: f64,
}

numbers!(impl[M: Numbers] CountedMemory[M] { memory: M, plastic_work: f64 });

impl<M: Record> Record for CountedMemory<M> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        self.memory.visit(visitor);
        visitor.f64s("plastic_work", std::slice::from_mut(&mut self.plastic_work));
    }
}

impl<M: MaterialMemory> MaterialMemory for CountedMemory<M> {
    fn plastic_strain(&self) -> f64 {
        self.memory.plastic_strain()
    }
    fn fraction(&self) -> f64 {
        self.memory.fraction()
    }
    fn plastic_work(&self) -> f64 {
        self.plastic_work
    }
}

impl<S: Space, L: MaterialLaw<S>> MaterialLaw<S> for Counted<L> {
    type Memory = CountedMemory<L::Memory>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> Self::Memory {
        CountedMemory { memory: self.0.start(stress, fraction), plastic_work: 0.0 }
    }
    fn update(&self, gradient: &S::Tensor, dt: f64, memory: &mut Self::Memory) -> S::Tensor {
        self.0.update_counted(gradient, dt, &mut memory.memory, &mut memory.plastic_work)
    }
    fn update_counted(&self, gradient: &S::Tensor, dt: f64, memory: &mut Self::Memory, work: &mut f64) -> S::Tensor {
        let before = memory.plastic_work;
        let stress = self.update(gradient, dt, memory);
        *work += memory.plastic_work - before;
        stress
    }
    #[inline(always)]
    fn update_lanes<R: Real>(
        &self,
        gradient: &S::TensorOf<R>,
        dt: f64,
        memory: &mut [R],
        work: &mut R,
    ) -> S::SymmetricOf<R> {
        let Some((total, inner)) = memory.split_last_mut() else { unreachable!("a counted memory has a word") };
        let before = *total;
        let stress = self.0.update_lanes(gradient, dt, inner, total);
        *work = *work + (*total - before);
        stress
    }
    fn stress(&self, memory: &Self::Memory) -> S::Tensor {
        self.0.stress(&memory.memory)
    }
    fn out_of_plane(&self, memory: &Self::Memory) -> f64 {
        self.0.out_of_plane(&memory.memory)
    }
    fn elastic_energy(&self, memory: &Self::Memory) -> f64 {
        self.0.elastic_energy(&memory.memory)
    }
    fn p_wave_modulus(&self) -> f64 {
        self.0.p_wave_modulus()
    }
    fn shear_modulus(&self) -> f64 {
        self.0.shear_modulus()
    }
}
