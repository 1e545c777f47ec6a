//! Who holds which block as the work moves. What a row costs is measured as the run goes, blocks are weighed by what lies in
//! them, and the curve is cut anew at a rebuild where that saves more time than it takes. Time may decide here because
//! nothing of it shows in the result (invariant 2).

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

use scree_partition::{Writer, cut};

use crate::base::error::Error;
use crate::base::space::Space;
use crate::dem::grains::Cold;
use crate::domain::layout::Deal;
use crate::domain::phases::{Phase, Phases};
use crate::domain::plan::{LoadMap, neighbours};
use crate::domain::subdomain::Participants;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::mpm::points::Cold as PointCold;
use crate::mpm::tile::Tiles;

/// What costs time in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
enum Kind {
    /// A grain: its contacts, and its motion.
    Grain,
    /// A grain that shares nodes with points or membranes: its way to the nodes and back.
    Coupled,
    /// A point: its way to the nodes and back, with its law.
    Point,
    /// A tile: the step of its nodes.
    Tile,
    /// A step of a pair of grains in an RVE; there are many in a step of its point.
    RvePair,
}

const KINDS: usize = 5;
/// The phases that each kind's cost shows in.
const PHASES_OF: [&[Phase]; KINDS] = [
    &[Phase::Contacts, Phase::Motion],
    &[Phase::Couple],
    &[Phase::Scatter, Phase::Gather],
    &[Phase::Nodes],
    &[Phase::Rves],
];
/// Costs that stand in until they have been measured, in the plane and in space, s.
const COSTS: [[f64; KINDS]; 2] = [[20e-9, 40e-9, 45e-9, 500e-9, 10e-9], [85e-9, 120e-9, 125e-9, 5e-6, 14e-9]];
/// Share of a new measurement in what is held of all of them.
const FRESH: f64 = 0.3;
/// Load of the busiest rank over the mean above which a better deal is looked for.
const IMBALANCE: f64 = 1.02;
/// Weights are whole numbers, so that all ranks cut alike: of a picosecond.
const UNIT: f64 = 1e12;

/// Costs as they have been measured, and whether another deal would pay. The same on every rank but for what is being timed.
#[derive(Clone, Debug, Default)]
pub struct LoadBalance {
    /// Time of a step per row of each kind, s; zero before it has been measured.
    costs: [f64; KINDS],
    /// Time of each kind on this rank at the last look, s, and the step then.
    seen: [f64; KINDS],
    step: u64,
    /// What this rank took for its last deal, s.
    price: f64,
    /// What the best deal would have saved since the last one, s.
    lost: f64,
    /// Deals since the start, the first excluded.
    pub deals: u64,
    /// Rows that this rank has sent to others, at deals and because they went there.
    pub rows_sent: u64,
}

impl LoadBalance {
    /// Of a world that begins at a step.
    pub(crate) fn from(step: u64) -> Self {
        Self { step, ..Self::default() }
    }

    /// Time of a step per row of each kind, s.
    fn costs(&self, dimension: usize) -> [f64; KINDS] {
        std::array::from_fn(|kind| match self.costs[kind] > 0.0 {
            true => self.costs[kind],
            false => COSTS[dimension - 2][kind],
        })
    }

    /// Takes over costs that another world has measured and this one has not.
    pub fn learn(&mut self, other: &Self) {
        for (cost, known) in self.costs.iter_mut().zip(other.costs) {
            if *cost == 0.0 {
                *cost = known;
            }
        }
    }

    /// Nanoseconds of each kind on this rank since the last look, for rows that have been the same since then.
    fn timed(&mut self, phases: &Phases, step: u64, rows: [u64; KINDS]) -> [i64; 2 * KINDS] {
        let steps = step - self.step;
        let mut timed = [0; 2 * KINDS];
        for kind in 0..KINDS {
            let seconds = PHASES_OF[kind].iter().map(|phase| phases.of(*phase)).sum::<f64>();
            timed[kind] = (1e9 * (seconds - self.seen[kind])).max(0.0) as i64;
            timed[KINDS + kind] = (steps * rows[kind]) as i64;
            self.seen[kind] = seconds;
        }
        self.step = step;
        timed
    }

    /// Takes times and row-steps of all ranks.
    fn take(&mut self, sums: &[i64; 2 * KINDS]) {
        for kind in 0..KINDS {
            let (nanoseconds, rows) = (sums[kind], sums[KINDS + kind]);
            if nanoseconds > 0 && rows > 0 {
                let fresh = 1e-9 * nanoseconds as f64 / rows as f64;
                let cost = &mut self.costs[kind];
                *cost = if *cost > 0.0 { *cost + FRESH * (fresh - *cost) } else { fresh };
            }
        }
    }
}

/// A point, and steps of pairs in its RVE.
pub(crate) type Weighed<'a, S> = (&'a PointCold<S>, u64);

/// Load of the busiest of some stretches of the curve.
fn heaviest(weights: &[u64], ranges: &[Range<usize>]) -> u64 {
    ranges.iter().map(|range| weights[range.clone()].iter().sum()).max().unwrap_or(0)
}

impl<S: Space> World<'_, S> {
    /// Deals blocks anew if that is due, and says whether it did; homes are those of the coming deal.
    ///
    /// What the best deal would have saved a step adds up until it comes to what the last one took: so the time that is lost
    /// is of the order of what dealing takes, and work that moves to and fro moves no blocks.
    pub(crate) fn deal_if_due(&mut self) -> Result<bool, Error> {
        let (ranks, steps) = (self.transport.size(), self.step - self.load_balance.step);
        let (costs, rows) = self.measure_costs();
        if ranks == 1 {
            return Ok(false);
        }
        let load = costs.iter().zip(rows).map(|(cost, rows)| cost * rows as f64).sum::<f64>();
        let (mut total, mut most) =
            ([(UNIT * load) as i64], [(UNIT * load) as i64, (UNIT * self.load_balance.price) as i64]);
        self.transport.sum(&mut total);
        self.transport.max_integer(&mut most);
        let [heaviest_now, price] = most;
        if heaviest_now as f64 * ranks as f64 <= IMBALANCE * total[0] as f64 {
            return Ok(false);
        }
        let weights = self.weigh(self.weighed_grains(), self.weighed_points())?;
        let best = cut(&weights, ranks);
        let gain = heaviest(&weights, &self.subdomain.deal.ranges).saturating_sub(heaviest(&weights, &best));
        self.load_balance.lost += steps as f64 * gain as f64;
        if self.load_balance.lost <= price as f64 {
            return Ok(false);
        }
        self.deal_out(best);
        Ok(true)
    }

    /// Costs of rows with what has been timed since the last look, and rows here, by kind. Collective.
    fn measure_costs(&mut self) -> ([f64; KINDS], [u64; KINDS]) {
        let rows = self.rows_of_kinds();
        let mut sums = self.load_balance.timed(&self.phases, self.step, rows);
        self.transport.sum(&mut sums);
        self.load_balance.take(&sums);
        (self.load_balance.costs(S::DIMENSION), rows)
    }

    /// What lies where and what it costs, on every rank; `steps` have been timed, and output takes so long of each (s).
    /// Collective.
    pub fn load_map(&mut self, steps: u64, threads: usize, output: f64) -> LoadMap {
        let (costs, _) = self.measure_costs();
        let (blocks, offsets) = (self.subdomain.layout.block_count(), neighbours(S::DIMENSION));
        let [mut grains, mut points, mut coupled, mut pairs] = [0i64; 4].map(|zero| vec![zero; blocks]);
        // Of each block: pairs of neighbours, one bit for each, and grains within reach of all of them.
        let mut near = Vec::new();
        let heights: [f64; 3] = std::array::from_fn(|axis| match axis < S::DIMENSION {
            true => self.assembly.cell_home.height(axis),
            false => 0.0,
        });
        let reach = self.reach();
        for (number, block) in self.subdomain.deal.held().enumerate() {
            let at = self.subdomain.layout.listed(block);
            points[at] = self.subdomain.point_ranges[number].len() as i64;
            grains[at] = self.subdomain.grain_ranges[number].len() as i64;
            let rves = self.rves.get(self.subdomain.point_ranges[number].clone()).unwrap_or_default();
            pairs[at] = rves.iter().map(|carried| carried.cost as i64).sum();
            coupled[at] = self.subdomain.participants.in_block(number).len() as i64;
            let mut masks = BTreeMap::new();
            let others = self.others(block, &offsets);
            for row in self.subdomain.grain_ranges[number].clone() {
                let fraction = self.assembly.cell_home.fraction(&self.assembly.grains.cold[row].home);
                let bit = |(bit, other): (usize, &Option<usize>)| {
                    let other = (*other)?;
                    (self.subdomain.layout.distance::<S>(&fraction, other, &heights) <= reach).then_some(1 << bit)
                };
                let mask: u32 = others.iter().enumerate().filter_map(bit).sum();
                if mask != 0 {
                    *masks.entry(mask).or_insert(0u32) += 1;
                }
            }
            near.push((at as u32, masks));
        }
        let mut whole = |mut counts: Vec<i64>| -> Vec<u32> {
            self.transport.sum(&mut counts);
            counts.into_iter().map(|count| count as u32).collect()
        };
        let [grains, coupled, points] = [grains, coupled, points].map(&mut whole);
        self.transport.sum(&mut pairs);
        let pairs = if self.settings.rves.is_some() {
            pairs.into_iter().map(|count| count as u64).collect()
        } else {
            Vec::new()
        };
        let near = self.everyones_near(near);
        let ranks = self.transport.size();
        let mut rebuild = [(1e9 * self.phases.of(Phase::Rebuild)) as i64];
        self.transport.sum(&mut rebuild);
        let rebuild = 1e-9 * rebuild[0] as f64;
        let rows = (self.grains_total + self.points_total) as f64;
        let has_grid = self.has_grid();
        LoadMap {
            dimension: S::DIMENSION,
            blocks: self.subdomain.layout.blocks(),
            periodic: self.subdomain.layout.periodic,
            grains,
            coupled,
            points,
            near,
            shared: match has_grid {
                true => offsets.iter().map(|offset| self.subdomain.layout.shared_nodes(*offset) as u32).collect(),
                false => Vec::new(),
            },
            nodes: self.subdomain.layout.tile_edge().pow(S::DIMENSION as u32),
            costs: std::array::from_fn(|kind| costs[kind]),
            pairs,
            pair_cost: costs[Kind::RvePair as usize],
            words: self.words(),
            passes: usize::from(has_grid) * self.passes(),
            beside: self.exchanges_beside(),
            // Whether to rebuild, what bodies bear, and which faces are met.
            reductions: 1 + usize::from(!self.bodies.is_empty()) + usize::from(self.meets_faces()) * self.passes(),
            rebuilds: self.rebuilds as f64 / steps.max(1) as f64,
            rebuild_cost: rebuild / (self.rebuilds.max(1) as f64 * rows.max(1.0)),
            output,
            ranks,
            threads,
            steps,
        }
    }

    /// Neighbours of a block, each once: in a narrow period several are one, or the block itself.
    fn others(&self, block: usize, offsets: &[[i32; 3]]) -> Vec<Option<usize>> {
        let mut others: Vec<Option<usize>> = Vec::with_capacity(offsets.len());
        for offset in offsets {
            let other = self.subdomain.layout.neighbour(block, *offset);
            others.push(other.filter(|other| *other != block && !others.contains(&Some(*other))));
        }
        others
    }

    /// What every rank has counted for its blocks, block by block.
    fn everyones_near(&self, mine: Vec<(u32, BTreeMap<u32, u32>)>) -> Vec<Vec<(u32, u32)>> {
        let mut numbers = Writer::new();
        for (block, masks) in &mine {
            masks.iter().for_each(|(mask, rows)| numbers.u32_array([*block, *mask, *rows]));
        }
        let mut near = vec![Vec::new(); self.subdomain.layout.block_count()];
        for bytes in self.transport.all_gather(numbers.as_bytes()) {
            for [block, mask, rows] in bytes.as_chunks::<12>().0.iter().map(|entry| {
                let number = |at: usize| u32::from_le_bytes([entry[at], entry[at + 1], entry[at + 2], entry[at + 3]]);
                [number(0), number(4), number(8)]
            }) {
                near[block as usize].push((mask, rows));
            }
        }
        near
    }

    /// Rows here that cost time, by their kind.
    fn rows_of_kinds(&self) -> [u64; KINDS] {
        let mut rows = [0; KINDS];
        rows[Kind::Grain as usize] = self.assembly.grains.owned as u64;
        rows[Kind::Coupled as usize] = self.subdomain.participants.count() as u64;
        rows[Kind::Point as usize] = self.continuum.points.len() as u64;
        rows[Kind::Tile as usize] = self.subdomain.nodes.mosaic.tiles as u64;
        rows[Kind::RvePair as usize] = self.rves.iter().map(|carried| carried.cost).sum();
        rows
    }

    /// Grains of this rank with their weights.
    fn weighed_grains(&self) -> impl Iterator<Item = (&Cold<S>, f64)> {
        let grains = &self.assembly.grains;
        grains.cold[..grains.owned].iter().zip(&grains.hot).map(|(cold, hot)| (cold, hot.weight))
    }

    /// Points of this rank with what weighs of them.
    pub(crate) fn weighed_points(&self) -> impl Iterator<Item = Weighed<'_, S>> {
        let points = &self.continuum.points;
        let cost = |row: usize| self.rves.get(row).map_or(0, |carried| carried.cost);
        points.cold.iter().enumerate().map(move |(row, cold)| (cold, cost(row)))
    }

    /// Cost of a step in every block of the domain by what lies there, in whole picoseconds; rows may lie in blocks of other
    /// ranks.
    pub(crate) fn weigh<'a>(
        &self,
        grains: impl Iterator<Item = (&'a Cold<S>, f64)>,
        points: impl Iterator<Item = Weighed<'a, S>>,
    ) -> Result<Vec<u64>, Error> {
        let blocks = self.subdomain.layout.block_count();
        // Grains, those that take part in the coupling, points, and steps of pairs in RVEs, block by block.
        let mut counts = vec![0i64; 4 * blocks];
        let near = self.near_membranes();
        let count = || -> Result<(), Error> {
            for (cold, weight) in grains {
                let block = self.block_of_grain(cold)?.0;
                counts[block] += 1;
                counts[blocks + block] += i64::from(Participants::takes_in(cold.mover, weight, near[block]));
            }
            for (cold, pairs) in points {
                let block = self.block_of_point(cold)?.0;
                counts[2 * blocks + block] += 1;
                counts[3 * blocks + block] += pairs as i64;
            }
            Ok(())
        };
        let counted = count();
        transfer::agree(self.transport, counted)?;
        self.transport.sum(&mut counts);
        let (grains, rest) = counts.split_at(blocks);
        let (coupled, rest) = rest.split_at(blocks);
        let (points, pairs) = rest.split_at(blocks);
        let costs = self.load_balance.costs(S::DIMENSION);
        let cost = |kind: Kind, rows: i64| costs[kind as usize] * rows as f64;
        let weight = |block: usize| {
            cost(Kind::Grain, grains[block])
                + cost(Kind::Coupled, coupled[block])
                + cost(Kind::Point, points[block])
                + cost(Kind::Tile, i64::from(self.has_grid()))
                + cost(Kind::RvePair, pairs[block])
        };
        Ok((0..blocks).map(|block| (UNIT * weight(block)) as u64).collect())
    }

    /// Gives every rank its stretch of the curve, and lays the tiles of this one's. Rows must settle afterwards.
    pub(crate) fn deal_out(&mut self, ranges: Vec<Range<usize>>) {
        self.subdomain.deal = Deal { ranges, rank: self.transport.rank() };
        self.subdomain.nodes =
            if self.has_grid() { self.subdomain.layout.node_rows(&self.subdomain.deal) } else { Default::default() };
        self.continuum.tiles = Tiles::lay(&self.subdomain.nodes.mosaic, self.is_coupled(), self.averages_volume());
        self.continuum.frames = self.subdomain.deal.held().map(|block| self.subdomain.layout.frame(block)).collect();
    }

    /// Deals blocks by any weights, with everything in them, and nothing else: no home changes. For who wants to see that
    /// no deal shows.
    pub fn deal_by(&mut self, weights: &[u64]) -> Result<(), Error> {
        self.look_at_costs();
        self.refresh_ghosts();
        self.deal_out(cut(weights, self.transport.size()));
        self.settle(Default::default())
    }

    /// Counts rows that leave this rank.
    pub(crate) fn count_leaving<T>(&mut self, to_ranks: &[Vec<T>]) {
        let rank = self.transport.rank();
        let leaving = to_ranks.iter().enumerate().filter(|(to, _)| *to != rank);
        self.load_balance.rows_sent += leaving.map(|(_, rows)| rows.len() as u64).sum::<u64>();
    }

    /// What a deal with its migration took since `timer`, as the next decision reckons with it: with the lists that a rebuild
    /// makes anyway, so that it is rather dealt too seldom.
    pub(crate) fn price_deal(&mut self, timer: Instant) {
        self.load_balance.price = timer.elapsed().as_secs_f64();
        self.load_balance.lost = 0.0;
        self.load_balance.deals += 1;
    }

    /// Takes what has been timed so far, before the rows become others. Collective.
    pub(crate) fn look_at_costs(&mut self) {
        self.measure_costs();
    }
}
