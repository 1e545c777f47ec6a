//! Work over blocks on the threads of a rank, without allocation: halves of halves, so that each task holds its own rows
//! and tiles. Nothing depends on which thread runs what.

use std::ops::Range;

/// Fewer rows are not worth a task of their own.
const ROWS_PER_TASK: usize = 512;

/// What some blocks that follow on one another hold.
pub struct Held<'a, A, B, T> {
    pub rows: &'a mut [A],
    /// One for every row, or none at all.
    pub beside: &'a mut [B],
    /// As many for every block, or none at all.
    pub tiles: &'a mut [T],
    pub tile_len: usize,
}

impl<'a, A, B, T> Held<'a, A, B, T> {
    /// What the first `blocks` hold, with their `rows`, and the rest.
    fn split(self, blocks: usize, rows: usize) -> (Self, Self) {
        let Self { tile_len, .. } = self;
        let (rows_left, rows_right) = self.rows.split_at_mut(rows);
        let (beside_left, beside_right) = self.beside.split_at_mut(if self.beside.is_empty() { 0 } else { rows });
        let (tiles_left, tiles_right) =
            self.tiles.split_at_mut(if self.tiles.is_empty() { 0 } else { blocks * tile_len });
        (
            Self { rows: rows_left, beside: beside_left, tiles: tiles_left, tile_len },
            Self { rows: rows_right, beside: beside_right, tiles: tiles_right, tile_len },
        )
    }
}

/// Calls `work` for every block with what it holds; `ranges` are the rows of each, one after the other from the first of
/// `held` on. Returns the largest number that came back, or zero.
pub fn over_blocks<A: Send, B: Send, T: Send>(
    ranges: &[Range<usize>],
    held: Held<A, B, T>,
    work: &(impl Fn(usize, Held<A, B, T>) -> f64 + Sync),
) -> f64 {
    if ranges.is_empty() { 0.0 } else { halve(0, ranges, held, work) }
}

fn halve<A: Send, B: Send, T: Send>(
    first: usize,
    ranges: &[Range<usize>],
    held: Held<A, B, T>,
    work: &(impl Fn(usize, Held<A, B, T>) -> f64 + Sync),
) -> f64 {
    if ranges.len() == 1 || held.rows.len() <= ROWS_PER_TASK {
        let (mut held, mut most) = (held, 0.0);
        for (block, range) in (first..).zip(ranges) {
            let (of_block, rest) = held.split(1, range.len());
            most = larger(most, work(block, of_block));
            held = rest;
        }
        return most;
    }
    let middle = ranges.len() / 2;
    let (ranges_left, ranges_right) = ranges.split_at(middle);
    let (left, right) = held.split(middle, ranges_right[0].start - ranges[0].start);
    let (a, b) =
        rayon::join(|| halve(first, ranges_left, left, work), || halve(first + middle, ranges_right, right, work));
    larger(a, b)
}

/// The larger of two numbers; what is not a number stays so, since it must not look like standing still.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}
