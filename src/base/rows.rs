//! Rows that a rebuild has put in order.

use std::ops::Range;

use rayon::prelude::*;

/// Fewer rows are not worth a task of their own.
const ROWS_PER_TASK: usize = 4096;

/// Rows in their new order.
pub(crate) struct Moved<T> {
    /// Where each comes from, one of those that were here by its number, beyond these one of the arrived.
    pub(crate) sources: Vec<u32>,
    /// Rows that were here.
    pub(crate) held: usize,
    pub(crate) arrived: Vec<T>,
    /// Rows of each block.
    pub(crate) ranges: Vec<Range<usize>>,
}

impl<T: Sync> Moved<T> {
    /// Whether one of those that have arrived is such.
    pub(crate) fn brings(&self, such: impl Fn(&T) -> bool) -> bool {
        self.arrived.iter().any(such)
    }

    /// A part of every row: of those that were here from `here`, of arrived ones by `of`.
    pub(crate) fn ordered<U: Copy + Send + Sync>(&self, here: &[U], of: impl Fn(&T) -> U + Sync) -> Vec<U> {
        let part = |source: &u32| match (*source as usize).checked_sub(self.held) {
            None => here[*source as usize],
            Some(number) => of(&self.arrived[number]),
        };
        self.sources.par_iter().with_min_len(ROWS_PER_TASK).map(part).collect()
    }
}
