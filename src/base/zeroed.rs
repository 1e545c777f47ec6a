//! Rows that are zero until they are written, which the system gives memory for page by page as they are.

use std::ops::{Deref, DerefMut};

use crate::base::numbers::Numbers;

/// As many rows as were asked for, each at its own alignment. Those of a page that nobody has written take none.
///
/// A `Vec` of rows that begin on lines of the cache is written through as it is made: the system promises zeros at the
/// alignment of a number alone.
#[derive(Debug)]
pub struct Zeroed<T: Numbers> {
    /// Rows, and in front of them what it takes to the first line.
    numbers: Vec<f64>,
    rows: usize,
    of: std::marker::PhantomData<T>,
}

impl<T: Numbers> Zeroed<T> {
    /// That many rows of zeros, none of them written yet.
    pub fn new(rows: usize) -> Self {
        let spare = align_of::<T>() / size_of::<f64>();
        Self { numbers: vec![0.0; rows * T::WIDTH + spare], rows, of: std::marker::PhantomData }
    }

    /// Where the first row begins.
    fn first(&self) -> usize {
        self.numbers.as_ptr().align_offset(align_of::<T>())
    }
}

impl<T: Numbers> Deref for Zeroed<T> {
    type Target = [T];

    #[allow(unsafe_code, reason = "numbers are records")]
    fn deref(&self) -> &[T] {
        let numbers = &self.numbers[self.first()..][..self.rows * T::WIDTH];
        // SAFETY: `rows` records of `WIDTH` numbers each, of which any make one, and the first is aligned.
        unsafe { std::slice::from_raw_parts(numbers.as_ptr().cast(), self.rows) }
    }
}

impl<T: Numbers> DerefMut for Zeroed<T> {
    #[allow(unsafe_code, reason = "numbers are records")]
    fn deref_mut(&mut self) -> &mut [T] {
        let (first, count) = (self.first(), self.rows * T::WIDTH);
        let numbers = &mut self.numbers[first..][..count];
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(numbers.as_mut_ptr().cast(), self.rows) }
    }
}

/// Another place in memory may begin elsewhere within a line.
impl<T: Numbers> Clone for Zeroed<T> {
    fn clone(&self) -> Self {
        let mut clone = Self::new(self.rows);
        clone.copy_from_slice(self);
        clone
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;
    use crate::mpm::tile::GrainNode;

    type Node = GrainNode<Plane>;

    #[test]
    fn rows_are_zero_and_begin_on_lines() {
        for count in [0, 1, 7, 1000] {
            let mut rows = Zeroed::<Node>::new(count);
            assert!(rows.len() == count && rows.iter().all(|row| *row == Node::zero()));
            assert_eq!(rows.as_ptr().align_offset(align_of::<Node>()), 0);
            for (number, row) in rows.iter_mut().enumerate() {
                row.0[3] = number as f64;
            }
            let clones: Vec<_> = (0..5).map(|_| rows.clone()).collect();
            assert!(clones.iter().all(|clone| **clone == *rows));
            assert!(rows.iter().enumerate().all(|(number, row)| row.0[3] == number as f64));
        }
    }
}
