//! How the domain is cut into blocks and which rank holds which: the lattice of blocks along its curve, and the rows of
//! nodes that ranks exchange. World layer; the physics below sees rows only.

use std::ops::Range;

use scree_partition::{Curve, Halo, Lattice as BlockLattice};

use crate::base::space::{Linear, Plane, Space};
use crate::mpm::faces::Lattice;
use crate::mpm::scatter::TileFrame;
use crate::mpm::scheme::ShapeFunction;
use crate::mpm::shape::{Axis, DRIFT_MAX, margins};
use crate::mpm::tile::{Mosaic, OwnedNode, Tier};

/// Cells along a closed border that nothing may enter where there are splines.
pub const RIM_CELLS: usize = 2;

/// Share of a cell by which a point may lie behind a wall: velocities vanish there, and what integration carries a little
/// too far comes back by itself.
const WALL_SLACK: f64 = 0.05;

/// Width of a part of a cell, in skins, which are a tenth of a grain where the job says nothing, and parts along an axis at most.
const SKINS_OF_PART: f64 = 20.0;
const PARTS_MAX: f64 = 64.0;

/// The domain: cells, blocks and the curve; the same on every rank. Places in it are shares of its edges, so that it may
/// deform.
#[derive(Clone, Debug)]
pub struct Layout {
    dimension: usize,
    /// Cells per axis (one in axes that do not exist).
    pub cells: [usize; 3],
    /// Along each axis that exists.
    pub cells_per_block: usize,
    /// Edge of a grid cell of the continuum, m.
    pub cell: f64,
    /// Lower corner of the domain, m.
    pub corner: [f64; 3],
    /// Per axis; false of axes that do not exist.
    pub periodic: [bool; 3],
    /// Cells along the lower and the upper border of an axis that is not periodic which nothing may enter: functions there
    /// would reach nodes that nobody sums.
    pub rim: [[usize; 2]; 3],
    /// Functions of the grid; they end at the rim where it is a wall.
    shape: ShapeFunction,
    /// Half of a point's edge in cells.
    point_half: f64,
    walled: bool,
    /// Blocks per axis.
    blocks: [i32; 3],
    /// Lattice coordinates of the blocks along the curve, and back.
    coordinates: Vec<[i32; 3]>,
    positions: Vec<u32>,
    /// Offsets to the neighbours of a block, itself included, in the order of every sum over tiles.
    offsets: Vec<[i32; 3]>,
}

/// What a [`Layout`] is laid from.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// Whole blocks of cells per axis.
    pub cells: [usize; 3],
    /// No fewer than the margins of a tile: nodes are summed over the tiles of neighbouring blocks, and no others.
    pub cells_per_block: usize,
    /// Edge of a grid cell of the continuum, m.
    pub cell: f64,
    /// Lower corner of the domain, m.
    pub corner: [f64; 3],
    /// Per axis; axes that do not exist are not asked.
    pub periodic: [bool; 3],
    /// Cells along the lower and the upper border of axes that are not periodic which nothing may enter.
    pub rim: [[usize; 2]; 3],
    /// Functions of the grid, which reach as far as the margins of a tile.
    pub shape: ShapeFunction,
    /// Half of a point's edge in cells, for functions that ask.
    pub point_half: f64,
    /// Whether the rim is a wall, at which functions end.
    pub walled: bool,
}

impl Ground {
    /// Without points: no rim.
    pub fn open(cells: [usize; 3], cells_per_block: usize, cell: f64, corner: [f64; 3], periodic: [bool; 3]) -> Self {
        Self {
            cells,
            cells_per_block,
            cell,
            corner,
            periodic,
            rim: [[0; 2]; 3],
            shape: ShapeFunction::Quadratic,
            point_half: 0.25,
            walled: false,
        }
    }
}

/// Which stretch of the curve each rank holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deal {
    /// Of each rank, by places along the curve; empty for a rank that has none.
    pub ranges: Vec<Range<usize>>,
    /// This one.
    pub rank: usize,
}

impl Deal {
    /// Blocks of this rank.
    pub fn held(&self) -> Range<usize> {
        self.ranges[self.rank].clone()
    }

    /// Rank that holds a block, which is given by its place along the curve.
    pub fn owner(&self, block: usize) -> usize {
        self.ranges.partition_point(|range| range.end <= block)
    }
}

/// Node rows and the halos that renew them.
#[derive(Default)]
pub struct NodeRows {
    /// Rows of this rank's tiles, and which of them make up which node.
    pub mosaic: Mosaic,
    /// Tile rows to the owners of their nodes, before summing.
    pub gathered: Halo,
    /// Owners' rows to the margins of others' tiles, after the nodes have advanced.
    pub advanced: Halo,
}

impl Layout {
    /// A domain in the plane of `cells` square cells from `corner`, periodic in x. `cells` must be whole blocks.
    pub fn plane(cells: [usize; 2], cells_per_block: usize, cell: f64, corner: [f64; 2]) -> Result<Self, String> {
        let (cells, corner) = ([cells[0], cells[1], 1], [corner[0], corner[1], 0.0]);
        let periodic = [true, false, false];
        let ground = Ground::open(cells, cells_per_block, cell, corner, periodic);
        Self::new::<Plane>(Ground { rim: [[RIM_CELLS; 2]; 3], ..ground })
    }

    /// Refused in words where a block has no cells, an axis is not made of whole blocks, or these are too many to count.
    pub fn new<S: Space>(ground: Ground) -> Result<Self, String> {
        match S::DIMENSION {
            2 => Self::laid::<2>(ground),
            _ => Self::laid::<3>(ground),
        }
    }

    fn laid<const D: usize>(ground: Ground) -> Result<Self, String> {
        let Ground { mut cells, cells_per_block, cell, corner, mut periodic, rim, shape, point_half, walled } = ground;
        cells[D..].fill(1);
        periodic[D..].fill(false);
        let axes = |values: [usize; 3]| -> [usize; D] { std::array::from_fn(|axis| values[axis]) };
        let wraps: [bool; D] = std::array::from_fn(|axis| periodic[axis]);
        let lattice = BlockLattice::<D>::new(axes(cells), cells_per_block, wraps).map_err(|error| error.to_string())?;
        let curve = Curve::new(&lattice);
        let padded = |axes: [usize; D], rest: i32| -> [i32; 3] {
            std::array::from_fn(|axis| if axis < D { axes[axis] as i32 } else { rest })
        };
        let blocks = padded(lattice.blocks(), 1);
        let coordinates: Vec<[i32; 3]> = (0..curve.len()).map(|k| padded(curve.coordinates(k), 0)).collect();
        let mut positions = vec![0; coordinates.len()];
        for (k, [x, y, z]) in coordinates.iter().enumerate() {
            positions[((z * blocks[1] + y) * blocks[0] + x) as usize] = k as u32;
        }
        let offsets = scree_partition::offsets::<D>()
            .into_iter()
            .map(|offset| std::array::from_fn(|axis| if axis < D { offset[axis] } else { 0 }));
        let offsets = offsets.collect();
        Ok(Self {
            dimension: D,
            cells,
            cells_per_block,
            cell,
            corner,
            periodic,
            rim,
            shape,
            point_half,
            walled,
            blocks,
            coordinates,
            positions,
            offsets,
        })
    }

    /// Lattice coordinates of a block.
    pub fn coordinates(&self, block: usize) -> [i32; 3] {
        self.coordinates[block]
    }

    /// Index of a block in lists of all with x fastest.
    pub fn listed(&self, block: usize) -> usize {
        let [x, y, z] = self.coordinates[block];
        ((z * self.blocks[1] + y) * self.blocks[0] + x) as usize
    }

    /// Of the whole domain.
    pub fn block_count(&self) -> usize {
        self.coordinates.len()
    }

    /// Lowest and highest y that anything may have where y is not periodic, m.
    pub fn heights(&self) -> [f64; 2] {
        let rim = self.rim[1].map(|cells| cells as f64 * self.cell);
        [self.corner[1] + rim[0], self.corner[1] + self.cells[1] as f64 * self.cell - rim[1]]
    }

    /// Lowest and highest coordinate along an axis between the rims, m.
    pub fn extent(&self, axis: usize) -> [f64; 2] {
        let [lower, upper] = self.rim[axis].map(|cells| cells as f64 * self.cell);
        let length = self.cells[axis] as f64 * self.cell;
        [self.corner[axis] + lower, self.corner[axis] + length - upper]
    }

    /// Shares of an axis that anything may be at.
    fn bounds(&self, axis: usize) -> [f64; 2] {
        if self.periodic[axis] {
            return [0.0, 1.0];
        }
        let slack = if self.walled { WALL_SLACK } else { 0.0 };
        let [lower, upper] = self.rim[axis].map(|cells| (cells as f64 - slack) / self.cells[axis] as f64);
        [lower, 1.0 - upper]
    }

    /// The block beside `block`, across the periods; none outside.
    pub fn neighbour(&self, block: usize, offset: [i32; 3]) -> Option<usize> {
        let mut at = self.coordinates[block];
        for axis in 0..3 {
            at[axis] += offset[axis];
            if self.periodic[axis] {
                at[axis] = at[axis].rem_euclid(self.blocks[axis]);
            } else if at[axis] < 0 || at[axis] >= self.blocks[axis] {
                return None;
            }
        }
        Some(self.positions[((at[2] * self.blocks[1] + at[1]) * self.blocks[0] + at[0]) as usize] as usize)
    }

    /// Parts of a cell along each axis, some two grains wide: grains of one part stand together, so that those that touch are near each
    /// other in memory, however many of them a cell of the grid holds.
    pub fn parts_of_cell(&self, skin: f64) -> usize {
        (self.cell / (SKINS_OF_PART * skin)).floor().clamp(1.0, PARTS_MAX) as usize
    }

    /// Block of a place given by its shares of the edges, wrapped into the periods, and which part of the block it lies in, whose
    /// cells have so many `parts` along each axis; none outside the domain or within its rim.
    pub fn place<S: Space>(&self, fraction: &S::Vector, parts: usize) -> Option<(usize, u32)> {
        let mut block = [0i32; 3];
        let mut cell_in_block = 0;
        for axis in (0..self.dimension).rev() {
            let cell = self.part_at(axis, fraction[axis], parts)?;
            let per_block = parts * self.cells_per_block;
            block[axis] = (cell / per_block) as i32;
            cell_in_block = cell_in_block * per_block + cell % per_block;
        }
        let index = ((block[2] * self.blocks[1] + block[1]) * self.blocks[0] + block[0]) as usize;
        Some((self.positions[index] as usize, cell_in_block as u32))
    }

    /// Number of the cell of a place, along the first axis first, by the same reckoning as its block.
    pub fn cell_of<S: Space>(&self, fraction: &S::Vector, parts: usize) -> Option<usize> {
        let along = |axis: usize| self.part_at(axis, fraction[axis], parts).map(|part| part / parts);
        (0..self.dimension).rev().try_fold(0, |number, axis| Some(number * self.cells[axis] + along(axis)?))
    }

    /// Which of the parts of an axis' cells a place lies in, by its share of the edge; none outside the domain or within its rim.
    fn part_at(&self, axis: usize, fraction: f64, parts: usize) -> Option<usize> {
        let [lower, upper] = self.bounds(axis);
        // A place wrapped to just below the period may round to it.
        if !self.periodic[axis] && !(lower..=upper).contains(&fraction) || !fraction.is_finite() {
            return None;
        }
        let count = parts * self.cells[axis];
        Some((fraction * count as f64).floor().clamp(0.0, (count - 1) as f64) as usize)
    }

    /// Frame of a block's tile.
    pub fn frame<S: Space>(&self, block: usize) -> TileFrame<S> {
        let mut corner = S::Vector::zero();
        let mut axes = [Axis { half: self.point_half, ..Axis::default() }; 3];
        let below = self.margin() as f64;
        let mut inside = [[below, below + self.cells_per_block as f64]; 3];
        for axis in 0..self.dimension {
            let first = self.coordinates[block][axis] * self.cells_per_block as i32 - self.margin() as i32;
            corner[axis] = self.corner[axis] + f64::from(first) * self.cell;
            if self.walled && !self.periodic[axis] {
                let [lower, upper] = self.rim[axis];
                axes[axis].walls = [lower as i32 - first, (self.cells[axis] - upper) as i32 - first].map(f64::from);
                // What has left through a wall is as far out as one may come: a rebuild is due, which finds it.
                let ([wall, other], slack) = (axes[axis].walls, DRIFT_MAX - WALL_SLACK);
                inside[axis] = [inside[axis][0].max(wall + slack), inside[axis][1].min(other - slack)];
            }
        }
        TileFrame { corner, cell: self.cell, cell_inverse: 1.0 / self.cell, edge: self.tile_edge(), inside, axes }
    }

    /// Points along an edge of a cell at the start.
    pub fn points_per_cell(&self) -> usize {
        (0.5 / self.point_half).round() as usize
    }

    /// Where a node is, m.
    pub fn node_at<V: Linear>(&self, place: [i32; 3]) -> V {
        let mut at = V::zero();
        for axis in 0..V::COMPONENTS {
            at[axis] = self.corner[axis] + f64::from(place[axis]) * self.cell;
        }
        at
    }

    /// Whether a node lies on a face of the room between the rims, or behind it.
    pub fn is_behind(&self, place: [i32; 3], axis: usize, upper: bool) -> bool {
        let [lower_rim, upper_rim] = self.rim[axis];
        match upper {
            false => place[axis] <= lower_rim as i32,
            true => place[axis] >= (self.cells[axis] - upper_rim) as i32,
        }
    }

    /// Share of a face across `axis` that belongs to a node on it: half of one at its edges. In the plane a length, m.
    pub fn node_area(&self, place: [i32; 3], axis: usize) -> f64 {
        let mut area = 1.0;
        for other in (0..self.dimension).filter(|other| *other != axis) {
            let at_edge = [false, true].into_iter().any(|upper| self.is_behind(place, other, upper));
            area *= if at_edge && !self.periodic[other] { 0.5 * self.cell } else { self.cell };
        }
        area
    }

    /// The lattice of nodes for faces of bodies.
    pub fn lattice(&self) -> Lattice {
        let extent = |axis: usize| {
            let [lower, upper] = self.rim[axis].map(|cells| cells as f64);
            if self.walled { [lower, self.cells[axis] as f64 - upper] } else { [f64::NEG_INFINITY, f64::INFINITY] }
        };
        Lattice {
            corner: self.corner,
            cell: self.cell,
            dimension: self.dimension,
            cells: self.cells.map(|cells| cells as i32),
            periodic: self.periodic,
            extent: std::array::from_fn(extent),
            shape: self.shape,
            point_half: self.point_half,
        }
    }

    /// Nodes of a tile below its block's own first node.
    fn margin(&self) -> usize {
        margins(self.shape)[0]
    }

    /// Nodes of a tile that belong to the block at an offset: as many as that one's tile has of this block's own.
    pub fn shared_nodes(&self, offset: [i32; 3]) -> usize {
        let [below, above] = margins(self.shape);
        let along = |axis: usize| match offset[axis] {
            0 => self.cells_per_block,
            1 => above,
            _ => below,
        };
        (0..self.dimension).map(along).product()
    }

    /// Nodes of a tile per axis.
    pub fn tile_edge(&self) -> usize {
        self.cells_per_block + margins(self.shape).iter().sum::<usize>()
    }

    /// A lower bound of the distance of a place from a block across the periods, m; exact beside a face. `heights` are the
    /// distances of the domain's faces.
    pub fn distance<S: Space>(&self, fraction: &S::Vector, block: usize, heights: &[f64; 3]) -> f64 {
        let mut most = 0.0f64;
        for axis in 0..self.dimension {
            let count = f64::from(self.blocks[axis]);
            let lower = f64::from(self.coordinates[block][axis]) / count;
            let outside = |share: f64| (lower - share).max(share - lower - 1.0 / count).max(0.0);
            let mut gap = outside(fraction[axis]);
            if self.periodic[axis] {
                gap = gap.min(outside(fraction[axis] + 1.0)).min(outside(fraction[axis] - 1.0));
            }
            most = most.max(gap * heights[axis]);
        }
        most
    }

    /// Blocks per axis.
    pub fn blocks(&self) -> [usize; 3] {
        self.blocks.map(|count| count as usize)
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

    /// The blocks of a stretch of the curve and those around them, in the order of the curve.
    fn near(&self, held: &Range<usize>) -> Vec<usize> {
        let mut near: Vec<usize> = held.clone().chain(held.clone().flat_map(|block| self.around(block))).collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    fn tier(&self, deal: &Deal, block: usize) -> Tier {
        match self.around(block).into_iter().all(|other| deal.owner(other) == deal.rank) {
            true => Tier::Inner,
            false => Tier::Border,
        }
    }

    /// Rows of nodes under a deal. Both sides of a message list its rows by walking the same blocks, offsets and nodes in
    /// the same order.
    pub fn node_rows(&self, deal: &Deal) -> NodeRows {
        let edge = self.tile_edge();
        let nodes_per_tile = edge.pow(self.dimension as u32);
        let held = deal.held();
        let mut mosaic = Mosaic { nodes_per_tile, tiles: held.len(), ..Mosaic::default() };
        mosaic.tiers = held.clone().map(|block| self.tier(deal, block)).collect();
        let row_here = |block: usize, node: [i32; 3]| ((block - held.start) * nodes_per_tile + self.node(node)) as u32;

        let mut gathered = Exchange::new(deal);
        let mut sources = Vec::new();
        mosaic.source_starts.push(0);
        let (near, own) = (self.near(&held), self.nodes(0, self.cells_per_block as i32));
        for block in near.iter().copied() {
            let receiver = deal.owner(block);
            for node in own.iter().copied() {
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
                        row: row_here(block, self.shifted(node)),
                        place: self.node_place(block, node),
                    });
                }
            }
        }

        let mut advanced = Exchange::new(deal);
        let (mut margins, mut owners) = (Vec::new(), Vec::new());
        let margin = self.margin() as i32;
        let all = self.nodes(-margin, edge as i32 - margin);
        for block in near {
            let receiver = deal.owner(block);
            if receiver == deal.rank {
                mosaic.copy_starts.push(margins.len() as u32);
            }
            for node in all.iter().copied() {
                let Some((source, place)) = self.owner_node(block, node) else { continue };
                let sender = deal.owner(source);
                if sender != receiver && sender == deal.rank {
                    advanced.send(receiver, row_here(source, place));
                }
                if receiver == deal.rank {
                    let here = sender == deal.rank;
                    owners.push(if here { Source::Here(row_here(source, place)) } else { advanced.receive(sender) });
                    margins.push(row_here(block, self.shifted(node)));
                }
            }
        }
        let first = mosaic.rows();
        mosaic.copy_starts.push(margins.len() as u32);
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

    /// Tile coordinates of a node given relative to the block's own first node.
    fn shifted(&self, node: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|axis| if axis < self.dimension { node[axis] + self.margin() as i32 } else { 0 })
    }

    /// Index in a tile of a node given by its tile coordinates.
    fn node(&self, place: [i32; 3]) -> usize {
        let edge = self.tile_edge() as i32;
        ((place[2] * edge + place[1]) * edge + place[0]) as usize
    }

    /// Lattice coordinates of a node of `block`.
    fn node_place(&self, block: usize, node: [i32; 3]) -> [i32; 3] {
        let at = self.coordinates[block];
        std::array::from_fn(|axis| at[axis] * self.cells_per_block as i32 + node[axis])
    }

    /// The tile beside `block` at `offset`, if it exists and contains the block's own `node`, and the node's place in it.
    fn tile_node(&self, block: usize, offset: [i32; 3], node: [i32; 3]) -> Option<(usize, [i32; 3])> {
        let edge = self.tile_edge() as i32;
        let mut place = [0; 3];
        for axis in 0..self.dimension {
            place[axis] = node[axis] - offset[axis] * self.cells_per_block as i32 + self.margin() as i32;
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
            place[axis] = node[axis].rem_euclid(cells) + self.margin() as i32;
        }
        if offset == [0; 3] { None } else { Some((self.neighbour(block, offset)?, place)) }
    }
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
