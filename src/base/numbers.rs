//! Records that lie in memory as numbers side by side: eight of them become lanes by transposing, and lanes records.

use crate::base::lane::{LANES, Pack, eight_mut};
use crate::base::space::Words;
use crate::base::symmetric::{PlaneSymmetric, SolidSymmetric};

/// A record of `f64` alone.
///
/// # Safety
///
/// Every byte of the type belongs to an `f64`: its layout is C's, its fields are `f64`, arrays of them or themselves
/// `Numbers`, and there is no padding.
#[allow(unsafe_code, reason = "the layout of a type is a promise of whoever writes it")]
pub unsafe trait Numbers: Copy {
    /// How many.
    const WIDTH: usize = size_of::<Self>() / size_of::<f64>();

    /// The record as numbers, in the order of its fields.
    #[inline(always)]
    #[allow(unsafe_code, reason = "what the trait demands")]
    fn numbers(&self) -> &[f64] {
        // SAFETY: the record is WIDTH initialised numbers, as the trait demands.
        unsafe { std::slice::from_raw_parts(std::ptr::from_ref(self).cast(), Self::WIDTH) }
    }

    /// The same, to be changed.
    #[inline(always)]
    #[allow(unsafe_code, reason = "what the trait demands")]
    fn numbers_mut(&mut self) -> &mut [f64] {
        // SAFETY: as above; any numbers make a record.
        unsafe { std::slice::from_raw_parts_mut(std::ptr::from_mut(self).cast(), Self::WIDTH) }
    }
}

#[allow(unsafe_code, reason = "one number")]
// SAFETY: it is one.
unsafe impl Numbers for f64 {}
#[allow(unsafe_code, reason = "none at all")]
// SAFETY: it has no bytes.
unsafe impl<T> Numbers for std::marker::PhantomData<T> {}
#[allow(unsafe_code, reason = "numbers side by side")]
// SAFETY: arrays have no padding.
unsafe impl<T: Numbers, const N: usize> Numbers for [T; N] {}
#[allow(unsafe_code, reason = "an array of numbers")]
// SAFETY: a static matrix of nalgebra is an array of columns, which are arrays.
unsafe impl<const R: usize, const C: usize> Numbers for nalgebra::SMatrix<f64, R, C> {}

#[allow(unsafe_code, reason = "an array of numbers")]
// SAFETY: its one field is an array.
unsafe impl Numbers for PlaneSymmetric {}
#[allow(unsafe_code, reason = "an array of numbers")]
// SAFETY: its one field is an array.
unsafe impl Numbers for SolidSymmetric {}

/// Makes a record [`Numbers`]: `numbers!(impl[S: Space] Record[S] { field: Type, ... })` with all its fields in order. That
/// each of them is, that they lie in that order and that there is nothing else is checked as it is compiled.
#[macro_export]
macro_rules! numbers {
    (impl[$($bounds:tt)*] $name:ident[$($parameters:tt)*] { $($field:tt: $type:ty),* $(,)? }) => {
        #[allow(unsafe_code, reason = "checked field by field")]
        // SAFETY: `whole` holds every field to be numbers, and their sizes to be all that there is.
        unsafe impl<$($bounds)*> $crate::base::numbers::Numbers for $name<$($parameters)*> {
            const WIDTH: usize = {
                let count = 0;
                $(
                    let offset = std::mem::offset_of!(Self, $field);
                    assert!(offset == count * size_of::<f64>(), "a record of numbers is not laid out as it is written");
                    let count = count + <$type as $crate::base::numbers::Numbers>::WIDTH;
                )*
                assert!(count * size_of::<f64>() == size_of::<Self>(), "a record of numbers has a gap");
                let _whole = |record: Self| {
                    let Self { $($field: _),* } = record;
                    $(let _: $type = record.$field;)*
                };
                count
            };
        }
    };
}

/// Most numbers of a record that is brought into lanes.
pub const NUMBERS_MAX: usize = 64;

/// Eight records in lanes, number by number.
#[derive(Clone, Copy)]
pub struct Lanes<P>(pub [P; NUMBERS_MAX]);

impl<P: Pack> Lanes<P> {
    /// Zero in every number of all eight.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([P::splat(0.0); NUMBERS_MAX])
    }

    /// Takes the first `count` numbers of eight records, and what of their others comes along.
    #[inline(always)]
    pub fn load<T: Numbers>(&mut self, rows: &[&T; LANES], count: usize) {
        let mut records: [&[f64]; LANES] = [&[]; LANES];
        for (record, row) in records.iter_mut().zip(rows) {
            *record = row.numbers();
        }
        for group in 0..count.div_ceil(LANES) {
            let first = Self::first::<T>(group);
            let loaded = P::records(&records, first);
            self.0[first..first + LANES].copy_from_slice(&loaded);
        }
    }

    /// All numbers to as many records as there are, at most eight.
    #[inline(always)]
    pub fn store<T: Numbers>(&self, rows: &mut [T]) {
        self.store_first(rows, T::WIDTH);
    }

    /// The first `count` of them, and others that are in the same groups of eight, which have to be what they are in the records.
    #[inline(always)]
    pub fn store_first<T: Numbers>(&self, rows: &mut [T], count: usize) {
        for group in 0..count.div_ceil(LANES) {
            let first = Self::first::<T>(group);
            let mut words = [P::splat(0.0); LANES];
            words.copy_from_slice(&self.0[first..first + LANES]);
            for (row, numbers) in rows.iter_mut().zip(P::transposed(words)) {
                numbers.store(eight_mut(row.numbers_mut(), first));
            }
        }
    }

    /// Groups of eight; the last one overlaps the one before where the record does not end with it.
    #[inline(always)]
    const fn first<T: Numbers>(group: usize) -> usize {
        const { assert!(T::WIDTH >= LANES && T::WIDTH <= NUMBERS_MAX) };
        let (first, last) = (group * LANES, T::WIDTH - LANES);
        if first < last { first } else { last }
    }

    /// A vector or tensor that starts at number `first`.
    #[inline(always)]
    pub fn words<V: Words<P>>(&self, first: usize) -> V {
        let mut words = V::zero();
        for word in 0..V::COUNT {
            words.set_word(word, self.0[first + word]);
        }
        words
    }

    /// Puts a vector or tensor where [`Lanes::words`] takes it from.
    #[inline(always)]
    pub fn set_words<V: Words<P>>(&mut self, first: usize, words: &V) {
        for word in 0..V::COUNT {
            self.0[first + word] = words.word(word);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lane::{Instructions, Packed};

    /// Eleven numbers: its last group of eight overlaps the first.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[repr(C)]
    struct Record {
        one: f64,
        nine: [f64; 9],
        last: f64,
    }
    numbers!(impl[] Record[] { one: f64, nine: [f64; 9], last: f64 });

    fn records() -> [Record; LANES] {
        let of = |record: usize, number: usize| (100 * record + number) as f64 - 350.25;
        std::array::from_fn(|record| Record {
            one: of(record, 0),
            nine: std::array::from_fn(|number| of(record, 1 + number)),
            last: of(record, 10),
        })
    }

    /// Records through lanes into other records, and what comes of a number on the way.
    struct Through(fn(&Record) -> f64);

    impl Packed for Through {
        type Outcome = [Record; LANES];
        fn run<P: Pack>(self) -> Self::Outcome {
            let from = records();
            let mut lanes = Lanes::<P>::zero();
            lanes.load(&from.each_ref(), Record::WIDTH);
            let (zero, last) = (P::splat(0.0), lanes.0[10]);
            let root = last.abs().sqrt() / P::splat(3.0);
            let below = P::choose(P::both(zero.above(last), root.above(P::splat(1.0))), -root, root.floor());
            lanes.0[10] = P::max(P::min(below * last + last - root, P::splat(5e3)), P::splat(-5e3));
            let wanted = from.each_ref().map(self.0);
            for (lane, (found, wanted)) in lanes.0[10].numbers().into_iter().zip(wanted).enumerate() {
                assert!(found.to_bits() == wanted.to_bits(), "lane {lane}: {found} for {wanted}");
            }
            let mut to = [Record { one: 0.0, nine: [0.0; 9], last: 0.0 }; LANES];
            lanes.store(&mut to);
            to
        }
    }

    /// In whatever registers, as one by one.
    #[test]
    fn records_go_into_lanes_and_come_back() {
        let last = |record: &Record| {
            let root = record.last.abs().sqrt() / 3.0;
            let below = if 0.0 > record.last && root > 1.0 { -root } else { root.floor() };
            (below * record.last + record.last - root).clamp(-5e3, 5e3)
        };
        for instructions in Instructions::here() {
            let found = instructions.run(Through(last));
            for (found, from) in found.into_iter().zip(records()) {
                assert_eq!(found, Record { last: last(&from), ..from }, "{instructions:?}");
            }
        }
    }

    #[test]
    fn a_record_is_its_numbers() {
        let mut record = records()[1];
        assert_eq!(record.numbers(), [&[record.one][..], &record.nine, &[record.last]].concat());
        record.numbers_mut()[10] = 7.0;
        assert_eq!(record.last, 7.0);
    }
}
