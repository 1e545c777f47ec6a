//! How the domain is cut into blocks and which rank holds which: the lattice of blocks along its curve, and the rows of
//! nodes that ranks exchange. World layer; the physics below sees rows only.

use std::ops::Range;

use scree_partition::{Curve, Halo, Lattice};

use crate::mpm::scatter::TileFrame;
use crate::mpm::shape::MARGIN_LOWER;
use crate::mpm::tile::{Mosaic, OwnedNode};
use crate::space::{Linear, Space};

/// The domain: cells, blocks and the curve; the same on every rank. The first axis is periodic.
#[derive(Clone, Debug)]
pub struct Layout {
    dimension: usize,
    /// Cells per axis (one in axes that do not exist).
    pub cells: [usize; 3],
    pub cells_per_block: usize,
    /// Edge of a cell, m.
    pub cell: f64,
    /// Lower corner of the domain, m.
    pub corner: [f64; 3],
    /// Blocks per axis.
    blocks: [i32; 3],
    /// Lattice coordinates of the blocks along the curve, and back.
    coordinates: Vec<[i32; 3]>,
    positions: Vec<u32>,
    /// Offsets to the neighbours of a block, itself included, in the order of every sum over tiles.
    offsets: Vec<[i32; 3]>,
}

/// Which stretch of the curve each rank holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deal {
    pub ranges: Vec<Range<usize>>,
    pub rank: usize,
}

impl Deal {
    pub fn held(&self) -> Range<usize> {
        self.ranges[self.rank].clone()
    }

    pub fn owner(&self, block: usize) -> usize {
        self.ranges.partition_point(|range| range.end <= block)
    }
}

/// Node rows and the halos that renew them.
pub struct NodeRows {
    pub mosaic: Mosaic,
    /// Tile rows to the owners of their nodes, before summing.
    pub gathered: Halo,
    /// Owners' rows to the margins of others' tiles, after the nodes have advanced.
    pub advanced: Halo,
}

impl Layout {
    /// A domain in the plane of `cells` square cells from `corner`, periodic in x. `cells` must be whole blocks.
    pub fn plane(cells: [usize; 2], cells_per_block: usize, cell: f64, corner: [f64; 2]) -> Result<Self, String> {
        let lattice = Lattice::<2>::new(cells, cells_per_block, [true, false]).map_err(|error| error.to_string())?;
        let curve = Curve::new(&lattice);
        let blocks = lattice.blocks();
        let coordinates: Vec<[i32; 3]> = (0..curve.len())
            .map(|k| {
                let [x, y] = curve.coordinates(k);
                [x as i32, y as i32, 0]
            })
            .collect();
        let mut positions = vec![0; coordinates.len()];
        for (k, [x, y, _]) in coordinates.iter().enumerate() {
            positions[*y as usize * blocks[0] + *x as usize] = k as u32;
        }
        Ok(Self {
            dimension: 2,
            cells: [cells[0], cells[1], 1],
            cells_per_block,
            cell,
            corner: [corner[0], corner[1], 0.0],
            blocks: [blocks[0] as i32, blocks[1] as i32, 1],
            coordinates,
            positions,
            offsets: scree_partition::offsets::<2>().into_iter().map(|[x, y]| [x, y, 0]).collect(),
        })
    }

    pub fn block_count(&self) -> usize {
        self.coordinates.len()
    }

    /// Length of the periodic axis, m.
    pub fn period(&self) -> f64 {
        self.cells[0] as f64 * self.cell
    }

    /// Edge of a block, m.
    pub fn block_edge(&self) -> f64 {
        self.cells_per_block as f64 * self.cell
    }

    /// Lowest and highest y that anything may have, m. Two cells from the border of the domain it ends: beyond them splines
    /// would reach nodes that nobody sums.
    pub fn heights(&self) -> [f64; 2] {
        let rim = 2.0 * self.cell;
        [self.corner[1] + rim, self.corner[1] + self.cells[1] as f64 * self.cell - rim]
    }

    pub fn offsets(&self) -> &[[i32; 3]] {
        &self.offsets
    }

    /// The block beside `block`, across the period on the first axis; none outside.
    pub fn neighbour(&self, block: usize, offset: [i32; 3]) -> Option<usize> {
        let at = self.coordinates[block];
        let x = (at[0] + offset[0]).rem_euclid(self.blocks[0]);
        let (y, z) = (at[1] + offset[1], at[2] + offset[2]);
        let inside = y >= 0 && y < self.blocks[1] && z >= 0 && z < self.blocks[2];
        inside.then(|| self.positions[((z * self.blocks[1] + y) * self.blocks[0] + x) as usize] as usize)
    }

    /// Block and cell within it of a place wrapped into the period; none outside the domain.
    pub fn place<S: Space>(&self, position: &S::Vector) -> Option<(usize, u32)> {
        let mut block = [0i32; 3];
        let mut cell_in_block = 0;
        for axis in (0..self.dimension).rev() {
            let cell = ((position[axis] - self.corner[axis]) / self.cell).floor();
            let top = (self.cells[axis] - 1) as f64;
            // A place wrapped to just below the period may round to it.
            let cell = if axis == 0 { cell.clamp(0.0, top) } else { cell };
            if !(0.0..=top).contains(&cell) {
                return None;
            }
            let cell = cell as usize;
            block[axis] = (cell / self.cells_per_block) as i32;
            cell_in_block = cell_in_block * self.cells_per_block + cell % self.cells_per_block;
        }
        let index = ((block[2] * self.blocks[1] + block[1]) * self.blocks[0] + block[0]) as usize;
        Some((self.positions[index] as usize, cell_in_block as u32))
    }

    /// Frame of a block's tile.
    pub fn frame<S: Space>(&self, block: usize) -> TileFrame<S> {
        let mut corner = S::Vector::zero();
        for axis in 0..self.dimension {
            let first = self.coordinates[block][axis] * self.cells_per_block as i32 - MARGIN_LOWER as i32;
            corner[axis] = self.corner[axis] + f64::from(first) * self.cell;
        }
        TileFrame { corner, cell_inverse: 1.0 / self.cell, edge: Mosaic::edge_of(self.cells_per_block) }
    }

    /// Distance of a place from a block, across the period, m.
    pub fn distance<S: Space>(&self, position: &S::Vector, block: usize) -> f64 {
        let mut square = 0.0;
        for axis in 0..self.dimension {
            let lower = self.corner[axis] + f64::from(self.coordinates[block][axis]) * self.block_edge();
            let outside = |x: f64| (lower - x).max(x - lower - self.block_edge()).max(0.0);
            let mut gap = outside(position[axis]);
            if axis == 0 {
                gap = gap.min(outside(position[axis] + self.period())).min(outside(position[axis] - self.period()));
            }
            square += gap * gap;
        }
        square.sqrt()
    }

    /// Blocks around `block`, itself excluded, each once.
    pub fn around(&self, block: usize) -> Vec<usize> {
        let mut around: Vec<usize> = self
            .offsets
            .iter()
            .filter_map(|offset| self.neighbour(block, *offset))
            .filter(|neighbour| *neighbour != block)
            .collect();
        around.sort_unstable();
        around.dedup();
        around
    }

    /// Rows of nodes under a deal. Both sides of a message list its rows by walking the same blocks, offsets and nodes in
    /// the same order.
    pub fn node_rows(&self, deal: &Deal) -> NodeRows {
        let edge = Mosaic::edge_of(self.cells_per_block);
        let nodes_per_tile = edge.pow(self.dimension as u32);
        let held = deal.held();
        let mut mosaic = Mosaic { edge, nodes_per_tile, tiles: held.len(), ..Mosaic::default() };
        let row_here = |block: usize, node: [i32; 3]| ((block - held.start) * nodes_per_tile + self.node(node)) as u32;

        let mut gathered = Exchange::new(deal);
        let mut sources = Vec::new();
        mosaic.source_starts.push(0);
        for block in 0..self.block_count() {
            let receiver = deal.owner(block);
            for node in self.nodes(0, self.cells_per_block as i32) {
                for offset in &self.offsets {
                    let Some((source, place)) = self.tile_node(block, *offset, node) else { continue };
                    let sender = deal.owner(source);
                    if sender != receiver && sender == deal.rank {
                        gathered.send(receiver, row_here(source, place));
                    }
                    if receiver == deal.rank {
                        let here = sender == deal.rank;
                        let row = if here { Source::Here(row_here(source, place)) } else { gathered.receive(sender) };
                        sources.push(row);
                    }
                }
                if receiver == deal.rank {
                    mosaic.source_starts.push(sources.len() as u32);
                    mosaic.owned.push(OwnedNode {
                        row: row_here(block, shifted(node, self.dimension)),
                        place: self.node_place(block, node),
                    });
                }
            }
        }

        let mut advanced = Exchange::new(deal);
        let (mut margins, mut owners) = (Vec::new(), Vec::new());
        let beyond = (edge - MARGIN_LOWER) as i32;
        for block in 0..self.block_count() {
            let receiver = deal.owner(block);
            for node in self.nodes(-(MARGIN_LOWER as i32), beyond) {
                let Some((source, place)) = self.owner_node(block, node) else { continue };
                let sender = deal.owner(source);
                if sender != receiver && sender == deal.rank {
                    advanced.send(receiver, row_here(source, place));
                }
                if receiver == deal.rank {
                    let here = sender == deal.rank;
                    owners.push(if here { Source::Here(row_here(source, place)) } else { advanced.receive(sender) });
                    margins.push(row_here(block, shifted(node, self.dimension)));
                }
            }
        }
        let first = mosaic.rows();
        let (gathered, received, sources) = gathered.finish(first, &sources);
        let (advanced, spread, owners) = advanced.finish(first, &owners);
        mosaic.sources = sources;
        mosaic.rows_received = received;
        mosaic.copies = margins.into_iter().zip(owners).collect();
        mosaic.rows_spread = spread;
        NodeRows { mosaic, gathered, advanced }
    }

    /// Nodes with coordinates `first..last` relative to a block's own first node, in lexical order.
    fn nodes(&self, first: i32, last: i32) -> Vec<[i32; 3]> {
        let axis = |exists: bool| if exists { first..last } else { 0..1 };
        let mut nodes = Vec::new();
        for z in axis(self.dimension == 3) {
            for y in axis(true) {
                for x in axis(true) {
                    nodes.push([x, y, z]);
                }
            }
        }
        nodes
    }

    /// Index in a tile of a node given by its tile coordinates.
    fn node(&self, place: [i32; 3]) -> usize {
        let edge = Mosaic::edge_of(self.cells_per_block) as i32;
        ((place[2] * edge + place[1]) * edge + place[0]) as usize
    }

    /// Lattice coordinates of a node of `block`.
    fn node_place(&self, block: usize, node: [i32; 3]) -> [i32; 3] {
        let at = self.coordinates[block];
        std::array::from_fn(|axis| at[axis] * self.cells_per_block as i32 + node[axis])
    }

    /// The tile beside `block` at `offset`, if it exists and contains the block's own `node`, and the node's place in it.
    fn tile_node(&self, block: usize, offset: [i32; 3], node: [i32; 3]) -> Option<(usize, [i32; 3])> {
        let edge = Mosaic::edge_of(self.cells_per_block) as i32;
        let mut place = [0; 3];
        for axis in 0..self.dimension {
            place[axis] = node[axis] - offset[axis] * self.cells_per_block as i32 + MARGIN_LOWER as i32;
            if !(0..edge).contains(&place[axis]) {
                return None;
            }
        }
        Some((self.neighbour(block, offset)?, place))
    }

    /// The block that owns a margin node of `block`'s tile and the node's place in the owner's tile; none for own nodes.
    fn owner_node(&self, block: usize, node: [i32; 3]) -> Option<(usize, [i32; 3])> {
        let cells = self.cells_per_block as i32;
        let mut offset = [0; 3];
        let mut place = [0; 3];
        for axis in 0..self.dimension {
            offset[axis] = node[axis].div_euclid(cells);
            place[axis] = node[axis].rem_euclid(cells) + MARGIN_LOWER as i32;
        }
        if offset == [0; 3] { None } else { Some((self.neighbour(block, offset)?, place)) }
    }
}

/// Tile coordinates of a node given relative to the block's own first node.
fn shifted(node: [i32; 3], dimension: usize) -> [i32; 3] {
    std::array::from_fn(|axis| if axis < dimension { node[axis] + MARGIN_LOWER as i32 } else { 0 })
}

/// Where a node's row comes from: a row of this rank, or the n-th row that a rank sends.
#[derive(Clone, Copy)]
enum Source {
    Here(u32),
    There { sender: usize, number: u32 },
}

/// Collects the two sides of a halo.
struct Exchange {
    sends: Vec<Vec<u32>>,
    counts: Vec<u32>,
}

impl Exchange {
    fn new(deal: &Deal) -> Self {
        let ranks = deal.ranges.len();
        Self { sends: vec![Vec::new(); ranks], counts: vec![0; ranks] }
    }

    fn send(&mut self, receiver: usize, row: u32) {
        self.sends[receiver].push(row);
    }

    fn receive(&mut self, sender: usize) -> Source {
        let number = self.counts[sender];
        self.counts[sender] += 1;
        Source::There { sender, number }
    }

    /// The halo, how many rows it receives, and the rows of `sources` when received rows stand from `first` on.
    fn finish(self, first: usize, sources: &[Source]) -> (Halo, usize, Vec<u32>) {
        let mut starts = Vec::with_capacity(self.counts.len());
        let mut next = first as u32;
        for count in &self.counts {
            starts.push(next);
            next += count;
        }
        let row = |source: &Source| match *source {
            Source::Here(row) => row,
            Source::There { sender, number } => starts[sender] + number,
        };
        let rows = sources.iter().map(row).collect();
        let sends = self.sends.into_iter().enumerate().filter(|(_, rows)| !rows.is_empty()).collect();
        let receives = starts
            .iter()
            .zip(&self.counts)
            .enumerate()
            .filter(|(_, (_, count))| **count > 0)
            .map(|(sender, (start, count))| (sender, *start..start + count))
            .collect();
        (Halo { sends, receives }, next as usize - first, rows)
    }
}
