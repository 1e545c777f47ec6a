//! What a run would take on a machine that is not here: a model of a step's time and of memory, fed with what a run has
//! measured and with a network that the operator states.
//!
//! ```text
//! t(P) = max_r sum_b w_b + max_r sum_e (m_e alpha + s_e / beta) + R alpha log2 P + rebuilds + output
//! ```
//!
//! w_b is the measured cost of block b, dealt along the same curve by the same cut as a run does; m_e and s_e are the
//! messages and bytes that rank r sends in exchange e of a step, R the number of reductions over all ranks (Hockney's alpha
//! and beta: latency and bandwidth). That messages hide behind work is left out, so that what comes true is not slower.

use scree_partition::{cut, offsets};
use serde::{Deserialize, Serialize};

use crate::base::error::Error;
use crate::base::space::{Plane, Solid};
use crate::domain::layout::{Ground, Layout};

/// What lies where at the end of a run, and what it costs: all that a forecast is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadMap {
    /// 2 in the plane, 3 in space.
    pub dimension: usize,
    /// Blocks per axis.
    pub blocks: [usize; 3],
    /// Per axis.
    pub periodic: [bool; 3],
    /// Rows of every block, x fastest.
    pub grains: Vec<u32>,
    /// Grains that share nodes with points or membranes.
    pub coupled: Vec<u32>,
    /// Points of every block, x fastest.
    pub points: Vec<u32>,
    /// Grains of every block by the neighbours within whose reach they are: one bit for each, in their order.
    pub near: Vec<Vec<(u32, u32)>>,
    /// Nodes that a tile shares with each of its neighbours; empty without points.
    pub shared: Vec<u32>,
    /// Nodes of a tile.
    pub nodes: usize,
    /// Time of a step per grain, per grain that shares nodes, per point and per tile, on one rank, s.
    pub costs: [f64; 4],
    /// Steps of pairs in the RVEs of every block in a step, and the time of one, s; maps of older programs have none.
    #[serde(default)]
    pub pairs: Vec<u64>,
    /// s; 0 in maps of older programs.
    #[serde(default)]
    pub pair_cost: f64,
    /// Numbers per row of a message: copies of grains, tiles to nodes, nodes to tiles.
    pub words: [usize; 3],
    /// Times that points go to the grid and back in a step.
    pub passes: usize,
    /// Exchanges of nodes with faces of bodies and with loads on the surface in a step, beside these, and the numbers per row of all of them.
    #[serde(default, alias = "faces")]
    pub beside: [usize; 2],
    /// Reductions over all ranks in a step.
    pub reductions: usize,
    /// Rebuilds in a step, and their time per row, s.
    pub rebuilds: f64,
    /// s; of all ranks together, per grain or point of the world.
    pub rebuild_cost: f64,
    /// Time of output in a step, which rank 0 does alone, s.
    pub output: f64,
    /// Where it was measured.
    pub ranks: usize,
    /// Per rank.
    pub threads: usize,
    /// Steps done in the stretch that was measured.
    pub steps: u64,
}

/// Latency of a message (s) and bandwidth of a rank (bytes/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Network {
    /// s.
    pub latency: f64,
    /// bytes/s.
    pub bandwidth: f64,
}

/// Parts of a step's time, beside the mean work of a rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Loss {
    /// Work of the busiest rank beyond the mean.
    Imbalance,
    /// Of messages between neighbours, at the rank whose messages take longest.
    Latency,
    /// Of the bytes in these messages.
    Bandwidth,
    /// Latency of sums and maxima over all ranks.
    Reductions,
    /// Rows settled anew, with what all ranks tell each other for it.
    Rebuilds,
    /// Rows, frames and checkpoints, by rank 0 alone.
    Output,
}

/// Every [`Loss`] in its order, and for a person what it is and what helps.
pub const LOSSES: [(Loss, &str); 6] = [
    (
        Loss::Imbalance,
        "imbalance: blocks are too few or too unequal for so many ranks; take smaller blocks, or fewer ranks",
    ),
    (Loss::Latency, "latency of messages between neighbours; take fewer ranks of more threads each"),
    (Loss::Bandwidth, "bytes between neighbours; take larger blocks, or fewer ranks of more threads each"),
    (Loss::Reductions, "latency of sums over all ranks; take fewer ranks of more threads each"),
    (Loss::Rebuilds, "rebuilds, which every rank tells every other of; take a thicker skin, or fewer ranks"),
    (Loss::Output, "output by rank 0 alone; write rows, frames and checkpoints less often"),
];

/// What is foreseen for a number of ranks.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// That number.
    pub ranks: usize,
    /// Time of a step, s.
    pub step: f64,
    /// Mean work of a rank in it, s.
    pub work: f64,
    /// What comes on top, by [`Loss`], s.
    pub losses: [f64; LOSSES.len()],
    /// Work of the busiest rank over the mean.
    pub imbalance: f64,
    /// Messages and bytes of all ranks together in a step.
    pub messages: u64,
    /// Without what a network adds to messages.
    pub bytes: u64,
    /// Memory of the largest rank, bytes.
    pub memory: f64,
}

impl Forecast {
    /// The largest loss.
    pub fn bottleneck(&self) -> (Loss, &'static str) {
        let largest = |a: &&(Loss, _), b: &&(Loss, _)| self.losses[a.0 as usize].total_cmp(&self.losses[b.0 as usize]);
        *LOSSES.iter().max_by(largest).expect("there are losses")
    }
}

/// Bytes of a grain, a point and a node with all that is sorted beside them, in the plane and in space (BENCHMARKS.md).
const BYTES: [[f64; 3]; 2] = [[250.0, 600.0, 250.0], [500.0, 860.0, 350.0]];
/// What every rank holds whatever its share: the program, and per block and per rank of the whole run.
const BYTES_PROGRAM: f64 = 40e6;
const BYTES_PER_BLOCK: f64 = 60.0;
const BYTES_PER_RANK: f64 = 200.0;
/// Collective operations of a rebuild, and exchanges in it in which each rank tells every other how much it sends.
const COLLECTIVES: f64 = 14.0;
const ALL_TO_ALL: f64 = 3.0;
/// Time of one entry of such an exchange at either end, s.
const ENTRY: f64 = 20e-9;

/// The blocks of a map, once or several times side by side along x, in the order of the curve.
struct Domain<'m> {
    map: &'m LoadMap,
    layout: Layout,
    offsets: Vec<[i32; 3]>,
}

impl<'m> Domain<'m> {
    fn new(map: &'m LoadMap, times: usize) -> Result<Self, Error> {
        // The cells of a block do not matter here.
        const CELLS: usize = 4;
        let cells = [map.blocks[0] * times, map.blocks[1], map.blocks[2]].map(|blocks| blocks * CELLS);
        let ground = Ground::open(cells, CELLS, 1.0, [0.0; 3], map.periodic);
        let layout = if map.dimension == 2 { Layout::new::<Plane>(ground) } else { Layout::new::<Solid>(ground) };
        Ok(Self { map, layout: layout.map_err(Error::User)?, offsets: neighbours(map.dimension) })
    }

    /// Index of a block in the lists of the map.
    fn listed(&self, block: usize) -> usize {
        let [x, y, z] = self.layout.coordinates(block).map(|at| at as usize);
        let [columns, rows, _] = self.map.blocks;
        (z * rows + y) * columns + x % columns
    }

    /// Time of a step in a block, in picoseconds.
    fn weight(&self, block: usize) -> u64 {
        let (map, at) = (self.map, self.listed(block));
        let tiles = u32::from(!map.shared.is_empty());
        let counts = [map.grains[at], map.coupled[at], map.points[at], tiles];
        let seconds: f64 = counts.iter().zip(map.costs).map(|(count, cost)| f64::from(*count) * cost).sum();
        let pairs = map.pairs.get(at).map_or(0.0, |pairs| *pairs as f64 * map.pair_cost);
        (1e12 * (seconds + pairs)) as u64
    }
}

/// Offsets to the neighbours of a block, itself excluded, in one order.
pub fn neighbours(dimension: usize) -> Vec<[i32; 3]> {
    let all: Vec<[i32; 3]> = match dimension {
        2 => offsets::<2>().into_iter().map(|[x, y]| [x, y, 0]).collect(),
        _ => offsets::<3>(),
    };
    all.into_iter().filter(|offset| *offset != [0; 3]).collect()
}

/// What a rank sends in a step, and to how many others.
#[derive(Clone, Copy, Debug, Default)]
struct Traffic {
    messages: u64,
    bytes: u64,
}

/// Foresees a step of the map's world, `times` of it side by side along x, on some ranks.
pub fn forecast(map: &LoadMap, times: usize, network: &Network, ranks: usize) -> Result<Forecast, Error> {
    let domain = Domain::new(map, times)?;
    let blocks = domain.layout.block_count();
    let weights: Vec<u64> = (0..blocks).map(|block| domain.weight(block)).collect();
    let ranges = cut(&weights, ranks);
    let seconds = |range: &std::ops::Range<usize>| 1e-12 * weights[range.clone()].iter().sum::<u64>() as f64;
    let heaviest = ranges.iter().map(seconds).fold(0.0, f64::max);
    let work = ranges.iter().map(seconds).sum::<f64>() / ranks as f64;

    let mut owners = vec![0u32; blocks];
    for (rank, range) in ranges.iter().enumerate() {
        owners[range.clone()].fill(rank as u32);
    }
    let traffic: Vec<Traffic> =
        ranges.iter().enumerate().map(|(rank, range)| sent(&domain, &owners, rank, range)).collect();
    let time_of =
        |traffic: &Traffic| [traffic.messages as f64 * network.latency, traffic.bytes as f64 / network.bandwidth];
    let slowest = traffic
        .iter()
        .map(time_of)
        .fold([0.0; 2], |most, time| if time[0] + time[1] > most[0] + most[1] { time } else { most });

    let (rows, memory) = ranges
        .iter()
        .map(|range| held(&domain, range))
        .fold((0.0, 0.0), |(rows, memory): (f64, f64), (more, bytes)| (rows.max(more), memory.max(bytes)));
    // Of a tree over all ranks.
    let depth = f64::from(usize::BITS - (ranks - 1).leading_zeros());
    let tell = ALL_TO_ALL * ranks as f64 * (ENTRY + 8.0 / network.bandwidth);
    let collectives = if ranks > 1 { COLLECTIVES * depth * network.latency + tell } else { 0.0 };
    let mut losses = [0.0; LOSSES.len()];
    losses[Loss::Imbalance as usize] = heaviest - work;
    losses[Loss::Latency as usize] = slowest[0];
    losses[Loss::Bandwidth as usize] = slowest[1];
    losses[Loss::Reductions as usize] = map.reductions as f64 * depth * network.latency;
    // Where grains and points share nodes all ranks learn which blocks do.
    let told = if map.coupled.iter().any(|rows| *rows > 0) && ranks > 1 {
        blocks as f64 * (ENTRY + 8.0 * depth / network.bandwidth)
    } else {
        0.0
    };
    losses[Loss::Rebuilds as usize] = map.rebuilds * (rows * map.rebuild_cost + collectives + told);
    losses[Loss::Output as usize] = map.output;
    Ok(Forecast {
        ranks,
        step: work + losses.iter().sum::<f64>(),
        work,
        losses,
        imbalance: if work > 0.0 { heaviest / work } else { 1.0 },
        messages: traffic.iter().map(|traffic| traffic.messages).sum(),
        bytes: traffic.iter().map(|traffic| traffic.bytes).sum(),
        memory: memory + BYTES_PROGRAM + BYTES_PER_BLOCK * blocks as f64 + BYTES_PER_RANK * ranks as f64,
    })
}

/// Messages and bytes of a rank in a step.
fn sent(domain: &Domain, owners: &[u32], rank: usize, range: &std::ops::Range<usize>) -> Traffic {
    let map = domain.map;
    let (mut grain_rows, mut node_rows) = (0u64, 0u64);
    let (mut grain_peers, mut node_peers) = (Vec::new(), Vec::new());
    let others = |block: usize| -> Vec<Option<u32>> {
        let owner = |offset: &[i32; 3]| domain.layout.neighbour(block, *offset).map(|other| owners[other]);
        domain.offsets.iter().map(|offset| owner(offset).filter(|owner| *owner as usize != rank)).collect()
    };
    let mut peers_of_row = Vec::new();
    for block in range.clone() {
        let others = others(block);
        if others.iter().all(Option::is_none) {
            continue;
        }
        for (mask, rows) in &map.near[domain.listed(block)] {
            // A rank gets a copy once, however many of its blocks it is for.
            let near = others.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1);
            peers_of_row.extend(near.filter_map(|(_, other)| *other));
            grain_rows += u64::from(*rows) * count(&mut peers_of_row);
            grain_peers.append(&mut peers_of_row);
        }
        for (other, shared) in others.iter().zip(&map.shared) {
            if let Some(other) = other {
                node_rows += u64::from(*shared);
                node_peers.push(*other);
            }
        }
    }
    let [grains, gathered, advanced] = map.words.map(|words| 8 * words as u64);
    let (passes, [exchanges, beside]) = (map.passes as u64, map.beside.map(|number| number as u64));
    // What a tile brings to a neighbour's nodes comes back as those nodes, row for row.
    Traffic {
        messages: count(&mut grain_peers) + (2 * passes + exchanges) * count(&mut node_peers),
        bytes: grain_rows * grains + node_rows * (passes * (gathered + advanced) + 8 * beside),
    }
}

/// How many different ones there are; they stand once each afterwards.
fn count(peers: &mut Vec<u32>) -> u64 {
    peers.sort_unstable();
    peers.dedup();
    peers.len() as u64
}

/// Rows of a rank, and the memory that they take with their tiles, bytes.
fn held(domain: &Domain, range: &std::ops::Range<usize>) -> (f64, f64) {
    let map = domain.map;
    let sum = |counts: &[u32]| range.clone().map(|block| f64::from(counts[domain.listed(block)])).sum::<f64>();
    let (grains, points) = (sum(&map.grains), sum(&map.points));
    let nodes = if map.shared.is_empty() { 0.0 } else { (range.len() * map.nodes) as f64 };
    let [of_grain, of_point, of_node] = BYTES[map.dimension - 2];
    (grains + points, grains * of_grain + points * of_point + nodes * of_node)
}
