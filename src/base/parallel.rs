//! Work over blocks on the threads of a rank, without allocation: halves of halves, so that each task holds its own rows
//! and tiles. Nothing depends on which thread runs what.

use std::ops::Range;

/// Fewer rows are not worth a task of their own.
const ROWS_PER_TASK: usize = 512;

/// Rows that blocks hold in common and that are dealt to tasks: a slice with one for every row, or with none at all, or several of them.
pub trait Dealt: Sized + Send {
    /// The first `rows` and the rest.
    fn deal(self, rows: usize) -> (Self, Self);
}

impl<T: Send> Dealt for &mut [T] {
    fn deal(self, rows: usize) -> (Self, Self) {
        let none = self.is_empty();
        self.split_at_mut(if none { 0 } else { rows })
    }
}

impl Dealt for () {
    fn deal(self, _: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<A: Dealt, B: Dealt> Dealt for (A, B) {
    fn deal(self, rows: usize) -> (Self, Self) {
        let ((a, a_rest), (b, b_rest)) = (self.0.deal(rows), self.1.deal(rows));
        ((a, b), (a_rest, b_rest))
    }
}

impl<A: Dealt, B: Dealt, C: Dealt> Dealt for (A, B, C) {
    fn deal(self, rows: usize) -> (Self, Self) {
        let (a, b, c) = self;
        let ((a, (b, c)), (a_rest, (b_rest, c_rest))) = (a, (b, c)).deal(rows);
        ((a, b, c), (a_rest, b_rest, c_rest))
    }
}

/// What some blocks that follow on one another hold.
pub struct Held<R, T> {
    /// One block's after another's, or none at all.
    pub rows: R,
    /// As many for every block.
    pub tiles: T,
    /// Entries of `tiles` for each block.
    pub tile_len: usize,
}

impl<R: Dealt, T: Dealt> Held<R, T> {
    /// What the first `blocks` hold, with their `rows`, and the rest.
    fn split(self, blocks: usize, rows: usize) -> (Self, Self) {
        let Self { tile_len, .. } = self;
        let (rows, rows_rest) = self.rows.deal(rows);
        let (tiles, tiles_rest) = self.tiles.deal(blocks * tile_len);
        (Self { rows, tiles, tile_len }, Self { rows: rows_rest, tiles: tiles_rest, tile_len })
    }
}

/// Calls `work` for every block with what it holds; `ranges` are the rows of each, one after the other from the first of
/// `held` on. Returns the largest number that came back, or zero.
pub fn over_blocks<R: Dealt, T: Dealt>(
    ranges: &[Range<usize>],
    held: Held<R, T>,
    work: &(impl Fn(usize, Held<R, T>) -> f64 + Sync),
) -> f64 {
    if ranges.is_empty() { 0.0 } else { halve(0, ranges, held, work) }
}

fn halve<R: Dealt, T: Dealt>(
    first: usize,
    ranges: &[Range<usize>],
    held: Held<R, T>,
    work: &(impl Fn(usize, Held<R, T>) -> f64 + Sync),
) -> f64 {
    let rows = ranges[ranges.len() - 1].end - ranges[0].start;
    if ranges.len() == 1 || rows <= ROWS_PER_TASK {
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
