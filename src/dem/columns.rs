//! Vectors of rows that lie side by side as columns of lanes, what is the same for all of them, and the largest of a number over all rows.

use crate::base::lane::{LANES, Pack, Real};
use crate::base::parallel::larger;
use crate::base::space::{Linear, Space, Words};

/// The largest of numbers that come eight at a time, none of them below zero. What is not a number stays so: a maximum of lanes drops it, a
/// sum of it times zero keeps it.
#[derive(Clone, Copy)]
pub struct Largest<P> {
    most: P,
    odd: P,
}

impl<P: Pack> Largest<P> {
    /// Zero: of no numbers yet.
    #[inline(always)]
    pub fn none() -> Self {
        Self { most: P::splat(0.0), odd: P::splat(0.0) }
    }

    /// Eight more, one to a lane.
    #[inline(always)]
    pub fn take(&mut self, numbers: P) {
        self.most = P::max(numbers, self.most);
        self.odd = self.odd + numbers * P::splat(0.0);
    }

    /// With those that came one by one.
    #[inline(always)]
    pub fn or(self, other: f64) -> f64 {
        (self.most + self.odd).numbers().into_iter().fold(other, larger)
    }
}

/// The same in every lane.
#[inline(always)]
pub fn splat<V: Linear, C: Words<R>, R: Real>(vector: &V) -> C {
    let mut components = C::zero();
    for axis in 0..C::COUNT {
        components.set_word(axis, R::splat(vector[axis]));
    }
    components
}

/// One to a lane, the last in those that lack.
#[inline(always)]
pub fn columns<V: Linear, C: Words<P>, P: Pack>(vectors: &[V]) -> C {
    // Eight that lie side by side are found without a look at how many there are.
    match vectors.first_chunk::<LANES>() {
        Some(whole) => gathered(|lane, axis| whole[lane][axis]),
        None => gathered(|lane, axis| vectors[lane.min(vectors.len() - 1)][axis]),
    }
}

#[inline(always)]
fn gathered<C: Words<P>, P: Pack>(entry: impl Fn(usize, usize) -> f64) -> C {
    let mut components = C::zero();
    for axis in 0..C::COUNT {
        components.set_word(axis, P::load(&std::array::from_fn(|lane| entry(lane, axis))));
    }
    components
}

/// A tensor times a vector, column by column.
#[inline(always)]
pub fn times<S: Space, R: Real>(tensor: &S::Tensor, vector: &S::VectorOf<R>) -> S::VectorOf<R> {
    let mut sum = scaled_column::<S, R>(tensor, 0, vector.word(0));
    for column in 1..S::DIMENSION {
        sum = sum + scaled_column::<S, R>(tensor, column, vector.word(column));
    }
    sum
}

/// A function, not a closure, which would be compiled apart for a processor without lanes.
#[inline(always)]
fn scaled_column<S: Space, R: Real>(tensor: &S::Tensor, column: usize, by: R) -> S::VectorOf<R> {
    let mut entries = S::VectorOf::<R>::zero();
    for row in 0..S::DIMENSION {
        entries.set_word(row, R::splat(tensor[column * S::DIMENSION + row]) * by);
    }
    entries
}
