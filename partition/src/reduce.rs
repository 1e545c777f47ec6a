//! Sums of floating-point numbers that come out the same in any order and on any number of ranks.

use crate::transport::Transport;
use std::array;
use thiserror::Error;

/// Binary digits after the point: one quantum is 2^-80, about 8e-25.
const QUANTUM_BITS: i32 = 80;
/// Largest exponent of an addend: below 2^40, about 1e12.
const ADDEND_BITS: i32 = 40;
/// Bound on a sum of magnitudes. Below it the i128 has a bit to spare, so a sum in range was never
/// wrapped.
const LOAD_MAX: u64 = 1 << 46;
const LIMB_BITS: u32 = 44;
const LIMBS: usize = 3;
/// With more ranks the sum of their capped loads could leave i64.
const RANKS_MAX: usize = 1 << 16;

/// `N` sums in fixed point.
///
/// An addend is cut to a whole number of quanta (2^-80, towards zero), which its own bits decide;
/// whole numbers add exactly, so neither order nor partition can show. Use it for totals, not in
/// inner loops.
///
/// Range: an addend below 2^40 in magnitude, and magnitudes that together (each rounded up to the
/// next integer) stay below 2^46. What leaves it, or is not finite, spoils its slot for good. The
/// test looks at magnitudes, not at running sums, so that it too has the same outcome in any order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExactSum<const N: usize> {
    quanta: [i128; N],
    load: [u64; N],
}

/// A sum left the range in which it is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "sum {slot} left its exact range: an addend is not finite or reaches 2^40, or the magnitudes together reach 2^46; \
     look for a value that blew up, or sum in larger units"
)]
pub struct SumError {
    /// The first slot that is spoiled.
    pub slot: usize,
}

impl<const N: usize> Default for ExactSum<N> {
    fn default() -> Self {
        Self { quanta: [0; N], load: [0; N] }
    }
}

impl<const N: usize> ExactSum<N> {
    /// Sums of nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds `value` to the sum in `slot`.
    #[inline]
    pub fn add(&mut self, slot: usize, value: f64) {
        add_to(&mut self.quanta[slot], &mut self.load[slot], value);
    }

    /// Adds every sum of `other` to its slot here.
    pub fn merge(&mut self, other: &Self) {
        for slot in 0..N {
            self.quanta[slot] = self.quanta[slot].wrapping_add(other.quanta[slot]);
            bear(&mut self.load[slot], other.load[slot]);
        }
    }

    /// The sum in `slot`, rounded once to the nearest double; NaN when the slot is spoiled.
    pub fn value(&self, slot: usize) -> f64 {
        value_of(self.quanta[slot], self.load[slot])
    }

    /// The sums over all ranks, the same bits on each. Collective, one message.
    ///
    /// # Errors
    /// When a slot is spoiled on any rank or by the total; all ranks then fail alike.
    pub fn reduce(self, transport: &dyn Transport) -> Result<[f64; N], SumError> {
        Ok(self.totals(transport)?.map(|(quanta, _)| to_f64(quanta)))
    }

    fn totals(self, transport: &dyn Transport) -> Result<[(i128, u64); N], SumError> {
        assert!(transport.size() <= RANKS_MAX, "exact sums hold for at most {RANKS_MAX} ranks");
        let mut parts: [_; N] = array::from_fn(|slot| split(self.quanta[slot], self.load[slot]));
        transport.sum(parts.as_flattened_mut());
        let totals = parts.map(join);
        match totals.iter().position(|(_, load)| *load >= LOAD_MAX) {
            Some(slot) => Err(SumError { slot }),
            None => Ok(totals),
        }
    }

    /// The same sums over all ranks, exact still. Collective, one message.
    ///
    /// # Errors
    /// As of [`Self::reduce`].
    pub fn total(self, transport: &dyn Transport) -> Result<Self, SumError> {
        let totals = self.totals(transport)?;
        Ok(Self { quanta: totals.map(|(quanta, _)| quanta), load: totals.map(|(_, load)| load) })
    }

    /// A sum as whole numbers, to be stored: its quanta, and the bound on its magnitudes.
    pub fn parts(&self, slot: usize) -> (i128, u64) {
        (self.quanta[slot], self.load[slot])
    }

    /// Goes on from what [`Self::parts`] gave.
    pub fn set_parts(&mut self, slot: usize, (quanta, load): (i128, u64)) {
        (self.quanta[slot], self.load[slot]) = (quanta, load.min(LOAD_MAX));
    }
}

/// As many sums as there is need for at a time, of the same kind as [`ExactSum`]. Memory is kept from one use to the next.
#[derive(Clone, Debug, Default)]
pub struct ExactSums {
    quanta: Vec<i128>,
    load: Vec<u64>,
    parts: Vec<[i64; LIMBS + 1]>,
}

impl ExactSums {
    /// That many sums of nothing.
    pub fn clear(&mut self, count: usize) {
        self.quanta.clear();
        self.quanta.resize(count, 0);
        self.load.clear();
        self.load.resize(count, 0);
    }

    /// Adds `value` to the sum in `slot`.
    #[inline]
    pub fn add(&mut self, slot: usize, value: f64) {
        add_to(&mut self.quanta[slot], &mut self.load[slot], value);
    }

    /// The sum in `slot`, rounded once to the nearest double; NaN when the slot is spoiled.
    pub fn value(&self, slot: usize) -> f64 {
        value_of(self.quanta[slot], self.load[slot])
    }

    /// Makes them sums over all ranks, the same bits on each. Every rank has as many. Collective, one message.
    pub fn total(&mut self, transport: &dyn Transport) {
        assert!(transport.size() <= RANKS_MAX, "exact sums hold for at most {RANKS_MAX} ranks");
        if transport.size() == 1 {
            return;
        }
        self.parts.clear();
        self.parts.extend(self.quanta.iter().zip(&self.load).map(|(quanta, load)| split(*quanta, *load)));
        transport.sum(self.parts.as_flattened_mut());
        for ((quanta, load), parts) in self.quanta.iter_mut().zip(&mut self.load).zip(&self.parts) {
            (*quanta, *load) = join(*parts);
        }
    }
}

#[inline]
fn add_to(sum: &mut i128, load: &mut u64, value: f64) {
    match magnitude_of(value) {
        Some(magnitude) => {
            let sign = -i128::from(value.is_sign_negative());
            *sum = sum.wrapping_add((magnitude as i128 ^ sign) - sign);
            bear(load, (magnitude >> QUANTUM_BITS) as u64 + 1);
        }
        None => bear(load, LOAD_MAX),
    }
}

/// Capped, so that it can only stay spoiled, and fits the total over ranks.
fn bear(load: &mut u64, magnitude: u64) {
    *load = (*load + magnitude).min(LOAD_MAX);
}

fn value_of(quanta: i128, load: u64) -> f64 {
    if load < LOAD_MAX { to_f64(quanta) } else { f64::NAN }
}

/// Whole quanta in the magnitude of `value`, cut towards zero; `None` outside the range.
#[inline]
fn magnitude_of(value: f64) -> Option<u128> {
    // |value| = mantissa * 2^(exponent - 1075), subnormals with exponent 1 and no implied bit.
    let bits = value.to_bits();
    let field = (bits >> 52 & 0x7ff) as i32;
    let mantissa = bits & ((1 << 52) - 1) | u64::from(field != 0) << 52;
    let exponent = field.max(1);
    if exponent >= 1023 + ADDEND_BITS {
        return None;
    }
    // One way for large and small, which come in any order: from the place of the largest down to its own, and out of sight.
    const LARGEST: i32 = 1022 + ADDEND_BITS - 1075 + QUANTUM_BITS;
    let down = (LARGEST - (exponent - 1075 + QUANTUM_BITS)).min(127);
    Some((u128::from(mantissa) << LARGEST) >> down)
}

/// Rounds once: the power of two scales without rounding, as no sum is small enough to be
/// subnormal.
fn to_f64(quanta: i128) -> f64 {
    const QUANTUM: f64 = f64::from_bits(((1023 - QUANTUM_BITS) as u64) << 52);
    quanta as f64 * QUANTUM
}

/// Limbs of 44 bits, lowest first, the top one signed, and the load: with up to 2^16 ranks none of
/// their sums leaves i64.
fn split(quanta: i128, load: u64) -> [i64; LIMBS + 1] {
    let low = |value: i128| (value & ((1 << LIMB_BITS) - 1)) as i64;
    [low(quanta), low(quanta >> LIMB_BITS), (quanta >> (2 * LIMB_BITS)) as i64, load as i64]
}

/// Undoes [`split`] for a sum of split values. Wraps only where the load says that the sum is
/// spoiled.
fn join([low, middle, high, load]: [i64; LIMBS + 1]) -> (i128, u64) {
    let middle = i128::from(middle) << LIMB_BITS;
    let high = i128::from(high).wrapping_shl(2 * LIMB_BITS);
    (i128::from(low).wrapping_add(middle).wrapping_add(high), load.unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Solo, threads};
    use proptest::prelude::*;

    fn local(values: &[f64]) -> f64 {
        let mut sum = ExactSum::<1>::new();
        values.iter().for_each(|&value| sum.add(0, value));
        sum.value(0)
    }

    #[test]
    fn quanta_of_every_size_are_cut_towards_zero() {
        // A product with a power of two rounds nothing, and a conversion cuts.
        let expected = |value: f64| (value.abs() * 2f64.powi(QUANTUM_BITS)) as u128;
        for exponent in 0..1023 + ADDEND_BITS as u64 {
            for fraction in [0, 1, (1 << 52) - 1, 0x5_5555_5555_5555, 0xa_1234_0000_ffff] {
                let value = f64::from_bits(exponent << 52 | fraction);
                assert_eq!(magnitude_of(value), Some(expected(value)), "{value:e}");
                assert_eq!(magnitude_of(-value), Some(expected(value)), "-{value:e}");
            }
        }
        assert_eq!(magnitude_of(2f64.powi(ADDEND_BITS)), None);
        assert_eq!(magnitude_of(f64::NAN), None);
    }

    #[test]
    fn representable_values_come_back_whole() {
        let quantum = 2.0_f64.powi(-80);
        let large = 2.0_f64.powi(40);
        for value in [0.0, 1.0, -1.0, 0.1, -1e-5, quantum, -quantum, large - 1.0, 1.0 - large, 1e11 / 3.0] {
            assert_eq!(local(&[value]), value);
        }
        assert_eq!(local(&[quantum * 1.75]), quantum);
        assert_eq!(local(&[quantum * -1.75]), -quantum);
        assert_eq!(local(&[quantum / 2.0, f64::MIN_POSITIVE, 5e-324, -0.0]), 0.0);
        assert_eq!(local(&[1e11, 1e-9, -1e11]), local(&[1e-9]));
    }

    #[test]
    fn what_leaves_the_range_spoils_its_slot_only() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0_f64.powi(40), -1e300] {
            let mut sum = ExactSum::<2>::new();
            sum.add(0, 1.5);
            sum.add(1, bad);
            sum.add(1, 1.0);
            assert_eq!(sum.value(0), 1.5);
            assert!(sum.value(1).is_nan());
            assert_eq!(sum.reduce(&Solo), Err(SumError { slot: 1 }));
        }
    }

    #[test]
    fn too_much_in_all_is_noticed_even_if_it_cancels_and_lies_on_many_ranks() {
        let outcomes = threads::run(4, |ranks| {
            let mut sum = ExactSum::<1>::new();
            let sign = if ranks.rank() % 2 == 0 { 1.0 } else { -1.0 };
            (0..20).for_each(|_| sum.add(0, sign * 1e12));
            assert!(sum.value(0).is_finite());
            sum.reduce(&ranks)
        });
        assert_eq!(outcomes, [Err(SumError { slot: 0 }); 4]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_same_bits_for_any_order_and_any_partition(
            // The position in the shuffled list stands for the order, the number beside it for the
            // owner.
            (values, shuffled) in prop::collection::vec((finite(), 0_usize..4), 0..60)
                .prop_flat_map(|values| (Just(values.clone()), Just(values).prop_shuffle())),
            size in 1_usize..5,
        ) {
            let expected = local(&values.iter().map(|pair| pair.0).collect::<Vec<_>>());
            let totals = threads::run(size, |ranks| {
                let (mut sum, mut other) = (ExactSum::<2>::new(), ExactSum::<2>::new());
                for (k, (value, owner)) in shuffled.iter().enumerate() {
                    if owner % size == ranks.rank() {
                        if k % 2 == 0 { sum.add(1, *value) } else { other.add(1, *value) }
                    }
                }
                sum.merge(&other);
                sum.reduce(&ranks).unwrap()
            });
            for total in totals {
                prop_assert_eq!(total.map(f64::to_bits), [0.0, expected].map(f64::to_bits));
            }
        }

        #[test]
        fn agrees_with_integers(values in prop::collection::vec(-(1_i64 << 39)..1 << 39, 0..60)) {
            let floats: Vec<f64> = values.iter().map(|&value| value as f64).collect();
            prop_assert_eq!(local(&floats), values.iter().sum::<i64>() as f64);
        }
    }

    /// As many sums as one likes have the bits of those of a fixed number, on any ranks; spoiled ones are NaN on all of them.
    #[test]
    fn sums_of_any_number_are_those_of_a_fixed_one() {
        let values = |rank: usize| [0.1 * (1 + rank) as f64, -1e11 / 3.0, if rank == 1 { f64::NAN } else { 1.0 }];
        let mut whole = ExactSum::<3>::new();
        (0..3).for_each(|rank| values(rank).iter().enumerate().for_each(|(slot, value)| whole.add(slot, *value)));
        let totals = threads::run(3, |ranks| {
            let mut sums = ExactSums::default();
            sums.clear(7);
            sums.add(5, f64::INFINITY);
            sums.clear(3);
            values(ranks.rank()).iter().enumerate().for_each(|(slot, value)| sums.add(slot, *value));
            sums.total(&ranks);
            [0, 1, 2].map(|slot| sums.value(slot).to_bits())
        });
        assert!(whole.value(2).is_nan() && whole.value(0) > 0.0);
        assert_eq!(totals, [[0, 1, 2].map(|slot| whole.value(slot).to_bits()); 3]);
    }

    /// A sum that is stored and gone on with has the bits of one that was never interrupted.
    #[test]
    fn totals_are_gone_on_with_from_their_parts() {
        let outcomes = threads::run(3, |ranks| {
            let mut sum = ExactSum::<2>::new();
            sum.add(1, 0.1 * (1 + ranks.rank()) as f64);
            let total = sum.total(&ranks).unwrap();
            let mut stored = ExactSum::<2>::new();
            stored.set_parts(1, total.parts(1));
            (total == stored, stored.value(1))
        });
        let mut whole = ExactSum::<1>::new();
        [0.1 * 1.0, 0.1 * 2.0, 0.1 * 3.0].into_iter().for_each(|value| whole.add(0, value));
        assert_eq!(outcomes, [(true, whole.value(0)); 3]);
    }

    fn finite() -> impl Strategy<Value = f64> {
        prop_oneof![-1e11..1e11, -1.0..1.0, -1e-15..1e-15, -1e-23..1e-23]
    }
}
