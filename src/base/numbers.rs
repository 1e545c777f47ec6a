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
    #[inline(always)]
    pub fn zero() -> Self {
        Self([P::splat(0.0); NUMBERS_MAX])
    }

    /// Takes the first `count` numbers of eight records, and what of their others comes along.
    #[inline(always)]
    pub fn load<T: Numbers>(&mut self, rows: &[&T; LANES], count: usize) {
        const { assert!(T::WIDTH >= LANES && T::WIDTH <= NUMBERS_MAX) };
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
        for group in 0..T::WIDTH.div_ceil(LANES) {
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

    #[inline(always)]
    pub fn set_words<V: Words<P>>(&mut self, first: usize, words: &V) {
        for word in 0..V::COUNT {
            self.0[first + word] = words.word(word);
        }
    }
}
