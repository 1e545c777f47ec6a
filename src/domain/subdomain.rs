//! The part of the domain that a rank owns, and what it tells its neighbours.

use std::ops::Range;

use scree_partition::{Halo, HaloBuffers, HaloCounts};

use crate::domain::layout::{Deal, Layout, NodeRows};

/// Blocks, rows and copies of a rank.
pub struct Subdomain {
    pub layout: Layout,
    pub deal: Deal,
    /// Rows of the blocks held here.
    pub grain_ranges: Vec<Range<usize>>,
    pub point_ranges: Vec<Range<usize>>,
    /// Blocks held here whose grains may share nodes with points of the overlap.
    pub coupled: Vec<bool>,
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

impl Subdomain {
    /// Blocks without rows.
    pub fn empty(layout: Layout, deal: Deal) -> Self {
        Self {
            layout,
            deal,
            grain_ranges: Vec::new(),
            point_ranges: Vec::new(),
            coupled: Vec::new(),
            nodes: NodeRows::default(),
            ghosts: Halo::default(),
            corners: Halo::default(),
            buffers: HaloBuffers::default(),
            sent: HaloCounts::default(),
            settlings: 0,
        }
    }
}
