//! Work over blocks on the threads of a rank, without allocation: halves of halves, so that each task holds its own rows
//! and tiles. Nothing depends on which thread runs what.

use std::ops::Range;

use crate::dem::segments::larger;

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
    if ranges.len() == 1 {
        return work(first, ranges[0].clone(), rows, tiles);
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
    if ranges.len() == 1 {
        return work(first, rows, beside);
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
