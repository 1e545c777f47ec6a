//! The part of the domain that a rank owns, and what it tells its neighbours.

use std::ops::Range;

use scree_partition::{Halo, HaloBuffers, HaloCounts};

use crate::dem::grains::Mover;
use crate::domain::layout::{Deal, Layout, NodeRows};

/// Blocks, rows and copies of a rank.
pub struct Subdomain {
    /// Of the whole domain; the same on every rank.
    pub layout: Layout,
    /// Which rank holds which blocks.
    pub deal: Deal,
    /// Rows of the blocks held here.
    pub grain_ranges: Vec<Range<usize>>,
    /// The same of points.
    pub point_ranges: Vec<Range<usize>>,
    /// Grains that share nodes with points or membranes, by the blocks held here.
    pub participants: Participants,
    /// Empty where there is no grid.
    pub nodes: NodeRows,
    /// Copies of other ranks' grains.
    pub ghosts: Halo,
    /// Forces on corners of elements whose nodes other ranks have as well.
    pub corners: Halo,
    pub(crate) buffers: HaloBuffers,
    /// Messages of steps that this rank has sent.
    pub sent: HaloCounts,
    /// Times that rows have settled: parcels are numbered by it.
    pub(crate) settlings: u64,
}

/// Grains that take part in the coupling: those of overlaps, which share their places with points, and those in blocks near membranes.
///
/// Yue et al. (2018) have all grains take part whose nodes all carry continuum. Those of the core next to an overlap are such too, but
/// there is no continuum in their place to go with; docs/validation/hybrid.md compares the two.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Participants {
    /// Rows counted from the first of their block, rising, block by block.
    rows: Vec<u32>,
    /// Where those of a block begin, and where the last end.
    begins: Vec<usize>,
}

impl Participants {
    /// Whether a grain is one of them.
    pub fn takes_in(mover: Mover, weight: f64, near_membrane: bool) -> bool {
        mover == Mover::Free && (weight < 1.0 || near_membrane)
    }

    /// Those of every block in turn.
    pub fn of<R: Iterator<Item = u32>>(blocks: impl Iterator<Item = R>) -> Self {
        let (mut rows, mut begins) = (Vec::new(), vec![0]);
        for block in blocks {
            rows.extend(block);
            begins.push(rows.len());
        }
        Self { rows, begins }
    }

    /// Rows of a block, counted from its first grain.
    pub fn in_block(&self, block: usize) -> &[u32] {
        &self.rows[self.begins[block]..self.begins[block + 1]]
    }

    /// How many there are, with those that have no such grains.
    pub fn blocks(&self) -> usize {
        self.begins.len().saturating_sub(1)
    }

    /// All of them.
    pub fn count(&self) -> usize {
        self.rows.len()
    }
}

impl Subdomain {
    /// Blocks without rows.
    pub fn empty(layout: Layout, deal: Deal) -> Self {
        Self {
            layout,
            deal,
            grain_ranges: Vec::new(),
            point_ranges: Vec::new(),
            participants: Participants::default(),
            nodes: NodeRows::default(),
            ghosts: Halo::default(),
            corners: Halo::default(),
            buffers: HaloBuffers::default(),
            sent: HaloCounts::default(),
            settlings: 0,
        }
    }
}
