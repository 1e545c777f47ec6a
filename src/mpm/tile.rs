//! Tiles: the nodes of each block with their margin, as rows. Behind the rows of this rank's tiles stand rows received from
//! other ranks, so that summing and spreading are the same for a neighbour here and a neighbour elsewhere.

use rayon::prelude::*;

use crate::ids::Row;
use crate::mpm::shape::{MARGIN_LOWER, MARGIN_UPPER};
use crate::space::{Linear, Space};

/// What points and grains bring to a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathered<S: Space> {
    /// Weighted mass of points, kg, their momentum, N s, and the internal and external force on it, N.
    pub mass: f64,
    pub momentum: S::Vector,
    pub force: S::Vector,
    /// Weighted mass of grains, kg, and their momentum after their own kick, N s.
    pub grain_mass: f64,
    pub grain_momentum: S::Vector,
}

/// What a node gives back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advanced<S: Space> {
    /// Velocity after the step, m/s: FLIP takes its change, PIC itself.
    pub velocity: S::Vector,
    pub velocity_change: S::Vector,
    /// Correction of grain velocities, m/s.
    pub grain_change: S::Vector,
}

impl<S: Space> Gathered<S> {
    /// Numbers in a message.
    pub const WIDTH: usize = 2 + 3 * S::DIMENSION;

    pub fn zero() -> Self {
        let zero = S::Vector::zero();
        Self { mass: 0.0, momentum: zero, force: zero, grain_mass: 0.0, grain_momentum: zero }
    }

    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.momentum += other.momentum;
        self.force += other.force;
        self.grain_mass += other.grain_mass;
        self.grain_momentum += other.grain_momentum;
    }

    pub fn pack(&self, out: &mut [f64]) {
        out[0] = self.mass;
        out[1] = self.grain_mass;
        pack_vectors::<S>([&self.momentum, &self.force, &self.grain_momentum], &mut out[2..]);
    }

    pub fn unpack(words: &[f64]) -> Self {
        let [momentum, force, grain_momentum] = unpack_vectors::<S>(&words[2..]);
        Self { mass: words[0], momentum, force, grain_mass: words[1], grain_momentum }
    }
}

impl<S: Space> Advanced<S> {
    pub const WIDTH: usize = 3 * S::DIMENSION;

    pub fn zero() -> Self {
        let zero = S::Vector::zero();
        Self { velocity: zero, velocity_change: zero, grain_change: zero }
    }

    pub fn pack(&self, out: &mut [f64]) {
        pack_vectors::<S>([&self.velocity, &self.velocity_change, &self.grain_change], out);
    }

    pub fn unpack(words: &[f64]) -> Self {
        let [velocity, velocity_change, grain_change] = unpack_vectors::<S>(words);
        Self { velocity, velocity_change, grain_change }
    }
}

fn pack_vectors<S: Space>(vectors: [&S::Vector; 3], out: &mut [f64]) {
    for (vector, out) in vectors.into_iter().zip(out.chunks_exact_mut(S::DIMENSION)) {
        for (axis, word) in out.iter_mut().enumerate() {
            *word = vector[axis];
        }
    }
}

fn unpack_vectors<S: Space>(words: &[f64]) -> [S::Vector; 3] {
    let mut vectors = [S::Vector::zero(); 3];
    for (vector, words) in vectors.iter_mut().zip(words.chunks_exact(S::DIMENSION)) {
        for (axis, word) in words.iter().enumerate() {
            vector[axis] = *word;
        }
    }
    vectors
}

/// Where the tiles of this rank lie and which rows make up which node. Laid once per deal of blocks to ranks.
#[derive(Clone, Debug, Default)]
pub struct Mosaic {
    /// Nodes per axis and per tile.
    pub edge: usize,
    pub nodes_per_tile: usize,
    /// Tiles of this rank.
    pub tiles: usize,
    /// Rows received before summing, and before gathering.
    pub rows_received: usize,
    pub rows_spread: usize,
    /// Rows of the nodes that this rank's blocks own, with their global node, in block order.
    pub owned: Vec<OwnedNode>,
    /// Sources of owned node i: `sources[source_starts[i]..source_starts[i + 1]]`, in neighbour order (invariant 2).
    pub source_starts: Vec<u32>,
    pub sources: Vec<Row>,
    /// Margin rows of tiles and the row they copy after the nodes have advanced.
    pub copies: Vec<(Row, Row)>,
}

/// A node and the row where its owner keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnedNode {
    pub row: Row,
    /// Lattice coordinates; the third is zero in the plane.
    pub place: [i32; 3],
}

impl Mosaic {
    pub fn edge_of(cells_per_block: usize) -> usize {
        cells_per_block + MARGIN_LOWER + MARGIN_UPPER
    }

    /// Rows of tiles and of what other ranks send before summing.
    pub fn rows(&self) -> usize {
        self.tiles * self.nodes_per_tile
    }

    /// Sum of `rows` (tiles first, received ones behind) at every owned node, in the one order of neighbours.
    pub fn sum<T: Copy + Send + Sync>(&self, rows: &[T], zero: T, add: impl Fn(&mut T, &T) + Sync) -> Vec<T> {
        let mut sums = vec![zero; self.owned.len()];
        self.sum_into(rows, zero, add, &mut sums);
        sums
    }

    /// [`Self::sum`] without allocation.
    pub fn sum_into<T: Copy + Send + Sync>(
        &self,
        rows: &[T],
        zero: T,
        add: impl Fn(&mut T, &T) + Sync,
        sums: &mut [T],
    ) {
        sums.par_iter_mut().with_min_len(256).enumerate().for_each(|(node, sum)| {
            *sum = zero;
            for &source in &self.sources[self.source_starts[node] as usize..self.source_starts[node + 1] as usize] {
                add(sum, &rows[source as usize]);
            }
        });
    }
}

/// Node rows of this rank.
#[derive(Clone, Debug)]
pub struct Tiles<S: Space> {
    pub gathered: Vec<Gathered<S>>,
    pub sums: Vec<Gathered<S>>,
    pub advanced: Vec<Advanced<S>>,
}

impl<S: Space> Default for Tiles<S> {
    fn default() -> Self {
        Self { gathered: Vec::new(), sums: Vec::new(), advanced: Vec::new() }
    }
}

impl<S: Space> Tiles<S> {
    pub fn lay(mosaic: &Mosaic) -> Self {
        Self {
            gathered: vec![Gathered::zero(); mosaic.rows() + mosaic.rows_received],
            sums: vec![Gathered::zero(); mosaic.owned.len()],
            advanced: vec![Advanced::zero(); mosaic.rows() + mosaic.rows_spread],
        }
    }

    pub fn sum(&mut self, mosaic: &Mosaic) {
        mosaic.sum_into(&self.gathered, Gathered::zero(), Gathered::add, &mut self.sums);
    }

    /// Fills the margins from the owners' rows.
    pub fn copy_margins(&mut self, mosaic: &Mosaic) {
        for &(to, from) in &mosaic.copies {
            self.advanced[to as usize] = self.advanced[from as usize];
        }
    }
}
