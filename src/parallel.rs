//! Work over blocks on the threads of a rank, without allocation: halves of halves, so that each task holds its own rows
//! and tiles. Nothing depends on which thread runs what.

use std::ops::Range;

use crate::dem::segments::larger;

/// Fewer rows are not worth a task of their own.
const ROWS_PER_TASK: usize = 512;

/// Calls `work(block, rows, tile)` for every block; `ranges` are its rows, and each block has `tile_len` entries of `tiles`.
/// `ranges` must be contiguous and start where `rows` starts.
pub fn over_blocks<A: Send, B: Send>(
    ranges: &[Range<usize>],
    rows: &mut [A],
    tile_len: usize,
    tiles: &mut [B],
    work: &(impl Fn(usize, Range<usize>, &mut [A], &mut [B]) + Sync),
) {
    if !ranges.is_empty() {
        halve(0, ranges, rows, tile_len, tiles, work);
    }
}

fn halve<A: Send, B: Send>(
    first: usize,
    ranges: &[Range<usize>],
    rows: &mut [A],
    tile_len: usize,
    tiles: &mut [B],
    work: &(impl Fn(usize, Range<usize>, &mut [A], &mut [B]) + Sync),
) {
    if ranges.len() == 1 || rows.len() <= ROWS_PER_TASK {
        let (mut rows, tiles) = (rows, tiles.chunks_exact_mut(tile_len));
        for ((block, range), tile) in (first..).zip(ranges).zip(tiles) {
            let (of_block, rest) = rows.split_at_mut(range.len());
            work(block, range.clone(), of_block, tile);
            rows = rest;
        }
        return;
    }
    let middle = ranges.len() / 2;
    let (ranges_left, ranges_right) = ranges.split_at(middle);
    let (rows_left, rows_right) = rows.split_at_mut(ranges_right[0].start - ranges[0].start);
    let (tiles_left, tiles_right) = tiles.split_at_mut(middle * tile_len);
    rayon::join(
        || halve(first, ranges_left, rows_left, tile_len, tiles_left, work),
        || halve(first + middle, ranges_right, rows_right, tile_len, tiles_right, work),
    );
}

/// Calls `work(block, rows, beside)` for every block, where `beside` has an entry for every row, or none at all; returns
/// the largest number that came back, or zero.
pub fn over_rows<A: Send, B: Send>(
    ranges: &[Range<usize>],
    rows: &mut [A],
    beside: &mut [B],
    work: &(impl Fn(usize, &mut [A], &mut [B]) -> f64 + Sync),
) -> f64 {
    if ranges.is_empty() { 0.0 } else { halve_rows(0, ranges, rows, beside, work) }
}

fn halve_rows<A: Send, B: Send>(
    first: usize,
    ranges: &[Range<usize>],
    rows: &mut [A],
    beside: &mut [B],
    work: &(impl Fn(usize, &mut [A], &mut [B]) -> f64 + Sync),
) -> f64 {
    if ranges.len() == 1 || rows.len() <= ROWS_PER_TASK {
        let (mut rows, mut beside, mut most) = (rows, beside, 0.0);
        for (block, range) in (first..).zip(ranges) {
            let (of_block, rest) = rows.split_at_mut(range.len());
            let (beside_block, beside_rest) = beside.split_at_mut(if beside.is_empty() { 0 } else { range.len() });
            most = larger(most, work(block, of_block, beside_block));
            (rows, beside) = (rest, beside_rest);
        }
        return most;
    }
    let middle = ranges.len() / 2;
    let (ranges_left, ranges_right) = ranges.split_at(middle);
    let split = ranges_right[0].start - ranges[0].start;
    let (rows_left, rows_right) = rows.split_at_mut(split);
    let (beside_left, beside_right) = beside.split_at_mut(if beside.is_empty() { 0 } else { split });
    let (a, b) = rayon::join(
        || halve_rows(first, ranges_left, rows_left, beside_left, work),
        || halve_rows(first + middle, ranges_right, rows_right, beside_right, work),
    );
    larger(a, b)
}
