//! Stress of points whose strain is known, whoever knows it.

use crate::base::lane::{Instructions, LANES, Pack, Packed};
use crate::base::numbers::{Lanes, Numbers};
use crate::base::space::{Linear, Space, Words};
use crate::law::material::MaterialLaw;
use crate::mpm::points::Hot;
use crate::mpm::scatter::eight_of;

/// Velocity gradients of eight points, entry by entry, 1/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates([[f64; LANES]; 9]);

impl Rates {
    /// Of increments F' F^-1 - 1 of at most eight points, over their time; where there are fewer, of the last several times.
    pub fn of<S: Space>(increments: &[S::Tensor], per_step: f64) -> Self {
        let mut rates = Self::default();
        for (entry, lanes) in rates.0.iter_mut().enumerate().take(S::Tensor::COMPONENTS) {
            *lanes = eight_of(increments).map(|increment| increment[entry] * per_step);
        }
        rates
    }

    /// Takes over the gradients of eight points, 1/s.
    #[inline(always)]
    pub fn keep<S: Space, P: Pack>(&mut self, gradient: &S::TensorOf<P>) {
        for (entry, lanes) in self.0.iter_mut().enumerate().take(S::Tensor::COMPONENTS) {
            gradient.word(entry).store(lanes);
        }
    }

    #[inline(always)]
    fn gradient<S: Space, P: Pack>(&self) -> S::TensorOf<P> {
        let mut gradient = S::TensorOf::<P>::zero();
        for (entry, lanes) in self.0.iter().enumerate().take(S::Tensor::COMPONENTS) {
            gradient.set_word(entry, P::load(lanes));
        }
        gradient
    }
}

/// Stress and memory of points after a step with these velocity gradients, 1/s; their F is that of the end of it already.
pub(super) fn strain_rows<S: Space, L: MaterialLaw<S>>(
    law: &L,
    (rates, dt, instructions): (&[Rates], f64, Instructions),
    points: &mut [Hot<S>],
) {
    instructions.run(Strain { law, rates, dt, points });
}

struct Strain<'a, S: Space, L> {
    law: &'a L,
    rates: &'a [Rates],
    dt: f64,
    points: &'a mut [Hot<S>],
}

impl<S: Space, L: MaterialLaw<S>> Packed for Strain<'_, S, L> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        let Self { law, rates, dt, points } = self;
        let (memory, mut lanes) = (Hot::<S>::MEMORY, Lanes::<P>::zero());
        for (points, rates) in points.chunks_mut(LANES).zip(rates) {
            lanes.load(&eight_of(points), Hot::<S>::WIDTH);
            let gradient = rates.gradient::<S, P>();
            let (words, work) = lanes.0[memory..].split_at_mut(S::PointMemory::WIDTH);
            let stress = law.update_lanes(&gradient, dt, &mut words[..L::Memory::WIDTH], &mut work[0]);
            lanes.set_words(Hot::<S>::STRESS, &stress);
            lanes.store(points);
        }
    }
}
