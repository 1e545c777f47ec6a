//! A material law as those hold it who need not know which it is. What a law reckons is compiled for each; what calls it is compiled
//! once, and asks once for all points of a block, or for one where a single one is looked at.

use std::fmt::Debug;
use std::sync::Arc;

use crate::base::compiled::of_space;
use crate::base::lane::Instructions;
use crate::base::numbers::Numbers;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Plane, Solid, Space, Words};
use crate::base::symmetric::Symmetric;
use crate::law::material::{Absent, ConstitutiveLaw, ForAnyMaterial, MaterialLaw, MaterialMemory};
use crate::mpm::gather::{Block, Taking, gather_points};
use crate::mpm::points::Hot;
use crate::mpm::strain::{Rates, strain_rows};

/// [`MaterialLaw`] with memories in words; every material law is one of these.
pub trait StressModel<S: Space>: Debug + Send + Sync {
    /// Velocity, place and stress of the points of a block, on this thread; see [`gather_points`].
    fn gather(&self, taking: Taking, block: Block<S>) -> f64;
    /// Stress and memory of points after a step of so many seconds with these velocity gradients, eight by eight, 1/s; where they are and what their F is is known.
    fn strain(&self, step: (&[Rates], f64, Instructions), points: &mut [Hot<S>]);
    /// Memory of a point under a Kirchhoff stress, Pa, at a solid volume fraction.
    fn start(&self, stress: &S::Tensor, fraction: f64) -> S::PointMemory;
    /// Kirchhoff stress of a memory as it is, Pa.
    fn stress(&self, memory: &S::PointMemory) -> S::Tensor;
    /// In the plane the Kirchhoff stress normal to it, Pa; 0 in space, and where a law has none.
    fn out_of_plane(&self, memory: &S::PointMemory) -> f64;
    /// A point that was loaded to this share of its peak strength before has at least the hardening of that loading: [`MaterialLaw::harden`].
    fn harden(&self, memory: &mut S::PointMemory, mobilised: f64);
    /// Per initial volume, J/m3.
    fn elastic_energy(&self, memory: &S::PointMemory) -> f64;
    /// Accumulated plastic strain.
    fn plastic_strain(&self, memory: &S::PointMemory) -> f64;
    /// Solid volume fraction that the law works with.
    fn fraction(&self, memory: &S::PointMemory) -> f64;
    /// Stiffness against uniaxial strain, Pa; over the density the square of the speed of the fastest wave.
    fn p_wave_modulus(&self) -> f64;
    /// G, Pa; over the density the square of the speed of shear waves.
    fn shear_modulus(&self) -> f64;
    /// Whether it says how points flow, so that their volume strain can be averaged.
    fn flows(&self) -> bool;
    /// Shear stress over the most that the law bears at this mean stress and fraction, of a Kirchhoff stress, Pa: [`MaterialLaw::mobilised`].
    fn mobilised(&self, stress: &S::Tensor, fraction: f64) -> f64;
    /// Names and widths of what a memory is, in the order of its words.
    fn memory_columns(&self) -> MemoryColumns;
}

/// Names and widths of the columns that a memory is kept in.
pub type MemoryColumns = Vec<(String, usize)>;

/// A law with its constants, as worlds share it.
pub type SharedMaterial<S> = Arc<dyn StressModel<S>>;

impl<S: Space, L: MaterialLaw<S>> StressModel<S> for L {
    fn gather(&self, taking: Taking, block: Block<S>) -> f64 {
        gather_points(self, taking, block)
    }
    fn strain(&self, step: (&[Rates], f64, Instructions), points: &mut [Hot<S>]) {
        strain_rows(self, step, points);
    }
    fn start(&self, stress: &S::Tensor, fraction: f64) -> S::PointMemory {
        const { assert!(L::Memory::WIDTH <= S::PointMemory::WIDTH, "the law remembers more than a point has room for") };
        let mut words = S::PointMemory::default();
        let memory = MaterialLaw::start(self, stress, fraction);
        words.numbers_mut()[..L::Memory::WIDTH].copy_from_slice(memory.numbers());
        words
    }
    fn harden(&self, memory: &mut S::PointMemory, mobilised: f64) {
        let mut known = of_words::<S, L>(memory);
        MaterialLaw::harden(self, &mut known, mobilised);
        memory.numbers_mut()[..L::Memory::WIDTH].copy_from_slice(known.numbers());
    }
    fn stress(&self, memory: &S::PointMemory) -> S::Tensor {
        MaterialLaw::stress(self, &of_words::<S, L>(memory))
    }
    fn out_of_plane(&self, memory: &S::PointMemory) -> f64 {
        MaterialLaw::out_of_plane(self, &of_words::<S, L>(memory))
    }
    fn elastic_energy(&self, memory: &S::PointMemory) -> f64 {
        MaterialLaw::elastic_energy(self, &of_words::<S, L>(memory))
    }
    fn plastic_strain(&self, memory: &S::PointMemory) -> f64 {
        of_words::<S, L>(memory).plastic_strain()
    }
    fn fraction(&self, memory: &S::PointMemory) -> f64 {
        of_words::<S, L>(memory).fraction()
    }
    fn p_wave_modulus(&self) -> f64 {
        MaterialLaw::p_wave_modulus(self)
    }
    fn shear_modulus(&self) -> f64 {
        MaterialLaw::shear_modulus(self)
    }
    fn flows(&self) -> bool {
        let words = S::PointMemory::default();
        self.flow(&words.numbers()[..L::Memory::WIDTH], &S::SymmetricOf::<f64>::zero()).is_some()
    }
    fn mobilised(&self, stress: &S::Tensor, fraction: f64) -> f64 {
        MaterialLaw::mobilised(self, &S::Symmetric::of(stress), fraction)
    }
    fn memory_columns(&self) -> MemoryColumns {
        let mut columns = Columns(Vec::new());
        L::Memory::default().visit(&mut columns);
        columns.0
    }
}

/// The law that a job names.
pub fn material_of<S: Space>(law: &ConstitutiveLaw) -> SharedMaterial<S> {
    of_space::<Named<S>>([&NAMED.0, &NAMED.1])(law)
}

type Named<S> = fn(&ConstitutiveLaw) -> SharedMaterial<S>;
static NAMED: (Named<Plane>, Named<Solid>) = (|law| law.apply(Unnamed), |law| law.apply(Unnamed));

struct Unnamed;

impl<S: Space> ForAnyMaterial<S> for Unnamed {
    type Outcome = SharedMaterial<S>;

    fn with<L: MaterialLaw<S>>(self, law: L) -> SharedMaterial<S> {
        Arc::new(law)
    }
}

/// That of worlds without points.
pub fn no_material<S: Space>() -> SharedMaterial<S> {
    Arc::new(Absent)
}

/// The memory of a law, as it is in words.
fn of_words<S: Space, L: MaterialLaw<S>>(words: &S::PointMemory) -> L::Memory {
    let mut memory = L::Memory::default();
    memory.numbers_mut().copy_from_slice(&words.numbers()[..L::Memory::WIDTH]);
    memory
}

/// Notes what a memory shows.
struct Columns(MemoryColumns);

impl Visitor for Columns {
    fn f64s(&mut self, name: &'static str, values: &mut [f64]) {
        self.0.push((name.to_string(), values.len()));
    }
    fn u64(&mut self, name: &'static str, _: &mut u64) {
        unreachable!("{name}: memories are numbers");
    }
    fn i64(&mut self, name: &'static str, _: &mut i64) {
        unreachable!("{name}: memories are numbers");
    }
    fn u8(&mut self, name: &'static str, _: &mut u8) {
        unreachable!("{name}: memories are numbers");
    }
}
