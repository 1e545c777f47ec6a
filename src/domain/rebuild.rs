//! Rebuilds: everything goes to the block it lies in, lists are made anew, contact memories move along, and nothing may
//! be missing afterwards (invariant 4).

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

use scree_partition::{ExactSums, Halo, Transport, cut};

use crate::base::compiled::of_space;
use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::rows::Moved;
use crate::base::space::{Plane, Solid, Space};
use crate::bodies::body::Body;
use crate::dem::assembly::{Assembly, add_image};
use crate::dem::grains::{Cold, GrainRow, Grains, Mover, PenaltySpring};
use crate::dem::memories::Memories;
use crate::domain::accounts::ledger::points::PointLedger;
use crate::domain::grid::Reactions;
use crate::domain::layout::{Deal, Layout};
use crate::domain::load_balance::LoadBalance;
use crate::domain::nonlocal::Neighbourhood;
use crate::domain::parts::{Home, Parts};
use crate::domain::phases::{Phase, Phases};
use crate::domain::stop::Wish;
use crate::domain::subdomain::{Participants, Subdomain};
use crate::domain::transfer;
use crate::domain::world::{Settings, World};
use crate::fem::elements::Elements;
use crate::mpm::continuum::Continuum;
use crate::mpm::points::{Cold as PointCold, Hot as PointHot, Point, Points};
use crate::mpm::shape::DRIFT_MAX;
use crate::rve::{RveRow, Scratches};

/// Grains and points of a rank.
pub type Rows<S> = (Vec<GrainRow<S>>, Vec<Point<S>>);
/// Grains, points and RVEs of these that are new to a world.
type Fresh<S> = (Vec<GrainRow<S>>, Vec<Point<S>>, Vec<RveRow<S>>);
/// A block, and a part of it.
type Place = (usize, u32);
/// Where a row stands in the order of rows, by place and id, and where it comes from: a row here, or behind those an
/// arrived one.
type Standing = (Place, u64, u32);

/// What travels between ranks when rows settle.
#[derive(Clone, Copy, Debug)]
enum Travel {
    Points,
    Rves,
    Nodes,
    Grains,
    Ghosts,
}

const TRAVELS: u64 = 5;

/// Cells between a vertex and a grain that may still share a node: 1.5 cells of spline and half a cell of drift on
/// either side.
const COUPLED_CELLS: usize = 4;

type Settle<S> = fn(&mut World<S>, Fresh<S>) -> Result<(), Error>;
static SETTLE: (Settle<Plane>, Settle<Solid>) =
    (|world, fresh| world.settle_all(fresh), |world, fresh| world.settle_all(fresh));

impl<'t, S: Space> World<'t, S> {
    /// A world at `step` from parts that the ranks hold in any split (every row on one rank). Homes are taken as they
    /// are: fresh rows have their position there, rows of a checkpoint the place of their last rebuild.
    pub fn new(
        settings: Settings<S>,
        layout: Layout,
        transport: &'t dyn Transport,
        step: u64,
        parts: Parts<S>,
    ) -> Result<Self, Error> {
        let ranks = transport.size();
        let deal = Deal { ranges: cut(&vec![1; layout.block_count()], ranks), rank: transport.rank() };
        let mut assembly = Assembly::empty(parts.cell);
        assembly.cell_home = parts.home.cell;
        let mut world = Self {
            transport,
            settings,
            step,
            step_of_cycle: 0,
            assembly,
            continuum: Continuum::empty(parts.membranes),
            // To whom they belong is found when rows settle.
            elements: Elements { owned: vec![true; parts.nodes.len()], nodes: parts.nodes, ..Elements::default() },
            rves: Vec::new(),
            scratches: Scratches::default(),
            rve_events: None,
            neighbourhood: Neighbourhood::default(),
            bodies: parts.bodies,
            bodies_home: parts.home.bodies,
            subdomain: Subdomain::empty(layout, deal),
            grains_total: 0,
            points_total: 0,
            wish: Wish::None,
            wish_agreed: Wish::None,
            rebuilds: 0,
            load_balance: LoadBalance::from(step),
            phases: Phases::default(),
            ledger: None,
            point_ledger: PointLedger::default(),
            reactions: Reactions::default(),
            column_sums: ExactSums::default(),
        };
        world.locate_vertices()?;
        world.replace_all(parts.grains, parts.points, parts.rves)?;
        // In blocks of another size than those of its state a point may be far from the block of its home.
        if world.has_grid() && world.has_strayed_points() {
            world.rebuild()?;
        }
        // Rows of the start all come from rank 0, which is no migration, nor is it a part of the run.
        world.load_balance.rows_sent = 0;
        world.load_balance.deals = 0;
        world.phases = Phases::default();
        Ok(world)
    }

    /// Whether a point is farther out of its block than steps let it come. Collective.
    fn has_strayed_points(&self) -> bool {
        let outside = |(block, range): (usize, &Range<usize>)| {
            let frame = &self.continuum.frames[block];
            let of = |hot: &PointHot<S>| {
                let away = |axis: usize| {
                    let ([lower, upper], at) =
                        (frame.inside[axis], (hot.position[axis] - frame.corner[axis]) / frame.cell);
                    (lower - at).max(at - upper)
                };
                (0..S::DIMENSION).map(away).fold(f64::NEG_INFINITY, f64::max)
            };
            self.continuum.points.hot[range.clone()].iter().map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        let here = self.subdomain.point_ranges.iter().enumerate().map(outside).fold(f64::NEG_INFINITY, f64::max);
        let mut most = [here];
        self.transport.max(&mut most);
        most[0] > DRIFT_MAX
    }

    /// Takes other rows in place of all that there are (every row on one rank), and deals the blocks anew.
    pub fn replace(&mut self, grains: Vec<GrainRow<S>>, points: Vec<Point<S>>) -> Result<(), Error> {
        self.replace_all(grains, points, Vec::new())
    }

    /// The same of a material that is grains.
    fn replace_all(
        &mut self,
        grains: Vec<GrainRow<S>>,
        points: Vec<Point<S>>,
        rves: Vec<RveRow<S>>,
    ) -> Result<(), Error> {
        // What has been timed belongs to the rows that have been here.
        self.look_at_costs();
        (self.continuum.points, self.rves) = (Points::default(), Vec::new());
        self.replace_rows(grains, points, rves)
    }

    /// The same, but that points which are here stay. Costs have been looked at.
    pub fn replace_grains(&mut self, grains: Vec<GrainRow<S>>) -> Result<(), Error> {
        self.replace_rows(grains, Vec::new(), Vec::new())
    }

    fn replace_rows(
        &mut self,
        grains: Vec<GrainRow<S>>,
        fresh_points: Vec<Point<S>>,
        fresh_rves: Vec<RveRow<S>>,
    ) -> Result<(), Error> {
        let (started, booked) = (self.phases.start(), self.phases.total());
        let mut counts = [grains.len() as i64, (self.continuum.points.len() + fresh_points.len()) as i64];
        self.transport.sum(&mut counts);
        (self.grains_total, self.points_total) = (counts[0] as u64, counts[1] as u64);
        let mut radius_max = [grains.iter().map(|grain| grain.hot.radius).fold(0.0, f64::max)];
        self.transport.max(&mut radius_max);
        self.assembly.radius_max = radius_max[0];
        let costs: BTreeMap<PointId, u64> = fresh_rves.iter().map(|row| (row.point, row.cost)).collect();
        let cost = |point: &Point<S>| costs.get(&point.cold.id).copied().unwrap_or_default();
        let fresh = fresh_points.iter().map(|point| (&point.cold, cost(point)));
        let weights =
            self.weigh(grains.iter().map(|grain| (&grain.cold, grain.hot.weight)), self.weighed_points().chain(fresh))?;
        let timer = Instant::now();
        self.deal_out(cut(&weights, self.transport.size()));
        self.assembly.grains = Grains::default();
        self.assembly.contacts.clear();
        self.assembly.walls.list.clear();
        self.settle((grains, fresh_points, fresh_rves))?;
        self.price_deal(timer);
        self.phases.stop_around(Phase::Balance, started, booked);
        Ok(())
    }

    /// All rows of this rank with their contacts, in block order: along the ranks they are in the order of the curve.
    pub fn rows(&self) -> Rows<S> {
        (self.grain_rows(0..self.assembly.grains.owned), self.continuum.points.rows().collect())
    }

    /// Some of the grains of this rank with their contacts, in block order.
    pub fn grain_rows(&self, rows: Range<usize>) -> Vec<GrainRow<S>> {
        rows.map(|row| self.assembly.whole_row(row)).collect()
    }

    /// Cell and bodies at the last rebuild.
    pub fn home(&self) -> Home<S> {
        Home { cell: self.assembly.cell_home, bodies: self.bodies_home.clone() }
    }

    /// Sends everything home: position of now becomes home, wrapped into the cell.
    pub fn rebuild(&mut self) -> Result<(), Error> {
        let (timer, booked) = (self.phases.start(), self.phases.total());
        self.assembly.go_home();
        for (hot, cold) in self.continuum.points.hot.iter_mut().zip(&mut self.continuum.points.cold) {
            add_image(&mut cold.image, self.assembly.cell.wrap(&mut hot.position, &mut hot.velocity));
            cold.home = hot.position;
        }
        self.rebuilds += 1;
        self.be_home();
        self.phases.stop_around(Phase::Rebuild, timer, booked);
        self.settle_anew()
    }

    /// Cell, bodies and vertices are at home where they are: lists that are made next are as old as that.
    pub(crate) fn be_home(&mut self) {
        self.assembly.cell_home = self.assembly.cell;
        self.bodies_home.clear();
        self.bodies_home.extend(self.bodies.iter().map(|body| body.displacement));
        self.continuum.membranes.vertices.iter_mut().for_each(|vertex| vertex.home = vertex.position);
    }

    /// Sends rows where they belong now, dealing blocks anew if that is due.
    pub(crate) fn settle_anew(&mut self) -> Result<(), Error> {
        let timer = self.phases.start();
        let dealt = self.deal_if_due()?;
        self.phases.stop(Phase::Balance, timer);
        let settling = self.phases.start();
        self.settle(Fresh::default())?;
        self.phases.stop(if dealt { Phase::Balance } else { Phase::Rebuild }, settling);
        if dealt {
            self.price_deal(timer);
        }
        Ok(())
    }

    /// Brings the rows that are here and `fresh` ones to the ranks that own their blocks, in the one order that fixes every
    /// sum, and makes the lists.
    pub(crate) fn settle(&mut self, fresh: Fresh<S>) -> Result<(), Error> {
        of_space::<Settle<S>>([&SETTLE.0, &SETTLE.1])(self, fresh)
    }

    fn settle_all(&mut self, (fresh, fresh_points, fresh_rves): Fresh<S>) -> Result<(), Error> {
        self.subdomain.settlings += 1;
        self.settle_points(fresh_points, fresh_rves)?;
        self.settle_elements(self.number_of(Travel::Nodes))?;
        self.find_neighbourhood()?;
        self.settle_grains(fresh)?;
        self.check_counts()?;
        self.mark_participants();
        self.mark_loads();
        Ok(())
    }

    fn settle_points(&mut self, fresh: Vec<Point<S>>, fresh_rves: Vec<RveRow<S>>) -> Result<(), Error> {
        let places = || -> Result<Vec<Place>, Error> {
            let here = self.continuum.points.cold.iter();
            here.chain(fresh.iter().map(|point| &point.cold)).map(|cold| self.block_of_point(cold)).collect()
        };
        let places = transfer::agree(self.transport, places())?;
        let held = self.continuum.points.len();
        let (order, to_ranks) = self.part(
            &places,
            held,
            |row| self.continuum.points.cold[row].id.0,
            |row| self.continuum.points.row(row),
            fresh,
        );
        self.count_leaving(&to_ranks);
        let leaving = self.rves_leaving(&to_ranks, fresh_rves);
        let leaving = transfer::agree(self.transport, leaving)?;
        let moved = self.join(Travel::Points, (order, held), to_ranks, |point| {
            Ok((self.block_of_point(&point.cold)?, point.cold.id.0))
        })?;
        self.settle_rves(self.number_of(Travel::Rves), leaving, &moved)?;
        self.continuum.points.take_order(&moved);
        self.subdomain.point_ranges = moved.ranges;
        Ok(())
    }

    /// Rows that stay are moved once, into their new order; only those that leave become parcels.
    fn settle_grains(&mut self, fresh: Vec<GrainRow<S>>) -> Result<(), Error> {
        let places = || -> Result<Vec<Place>, Error> {
            let here = self.assembly.grains.cold[..self.assembly.grains.owned].iter();
            here.chain(fresh.iter().map(|row| &row.cold)).map(|cold| self.block_of_grain(cold)).collect()
        };
        let places = transfer::agree(self.transport, places())?;
        self.refuse_thin_blocks()?;
        let owned = self.assembly.grains.owned;
        let mut memories = Memories::new(self.law().memory_words());
        for (row, place) in places[..owned].iter().enumerate() {
            match self.subdomain.deal.owner(place.0) == self.subdomain.deal.rank {
                true => memories.push(self.assembly.carried_by(row)),
                false => memories.push(std::iter::empty()),
            }
        }
        let (order, to_ranks) = self.part(
            &places,
            owned,
            |row| self.assembly.grains.cold[row].id.0,
            |row| self.assembly.whole_row(row),
            fresh,
        );
        drop(places);
        self.count_leaving(&to_ranks);
        self.assembly.contacts.clear();
        let moved = self.join(Travel::Grains, (order, owned), to_ranks, |row| {
            Ok((self.block_of_grain(&row.cold)?, row.cold.id.0))
        })?;
        self.assembly.grains.hot = moved.ordered(&self.assembly.grains.hot, |row| row.hot);
        self.assembly.grains.cold = moved.ordered(&self.assembly.grains.cold, |row| row.cold);
        self.assembly.grains.springs = moved.ordered(&self.assembly.grains.springs, |row| row.spring);
        let Moved { sources, arrived, ranges, .. } = moved;
        self.subdomain.grain_ranges = ranges;
        // A source of a row is one that was here, or behind those one that arrived.
        arrived.iter().for_each(|row| memories.push(row.contacts.iter().copied()));
        self.assembly.grains.owned = sources.len();
        self.assembly.grains.settle();
        self.assembly.moved = 0.0;
        self.continuum.points_outside = [0.0; 2];
        self.fetch_ghosts()?;

        let carried = |row: usize| memories.of(sources[row] as usize);
        // Of where bodies stood when everything was sent home, as grains are: a state in between has the lists of its run.
        let at_home = |(body, home): (&Body<S>, &S::Vector)| Body { displacement: *home, ..body.clone() };
        let bodies: Vec<Body<S>> = self.bodies.iter().zip(&self.bodies_home).map(at_home).collect();
        self.assembly.list(&self.settings.grains, &bodies, carried);
        Ok(())
    }

    /// How far apart the centres of two grains may be and still be listed as a pair, m.
    pub(crate) fn reach(&self) -> f64 {
        2.0 * self.assembly.radius_max + self.settings.grains.margin()
    }

    /// A block's copies come from its neighbours alone, so a contact must not reach across one.
    fn refuse_thin_blocks(&self) -> Result<(), Error> {
        let reach = self.reach();
        let blocks = self.subdomain.layout.blocks();
        for (axis, count) in blocks.into_iter().enumerate().take(S::DIMENSION) {
            let height = self.assembly.cell_home.height(axis);
            // One or two blocks are neighbours of everything; a pair's nearest image must then be the only one in reach.
            let thinnest = match (count > 2, self.assembly.cell.periodic[axis]) {
                (true, _) => height / count as f64,
                (false, true) => 0.5 * height,
                (false, false) => f64::INFINITY,
            };
            if self.grains_total > 0 && thinnest < reach {
                return Err(Error::Run(format!(
                    "step {}: along axis {axis} the cell is {height:.3e} m thick with {} blocks; contacts reach {reach:.3e} m, which needs thicker ones: take larger `decomposition.block`, or a larger cell for so much deformation",
                    self.step, count
                )));
            }
        }
        Ok(())
    }

    /// The number of an exchange, which all ranks count alike.
    fn number_of(&self, travel: Travel) -> u64 {
        self.subdomain.settlings * TRAVELS + travel as u64
    }

    /// Rows that stay are not packed; the others travel in parcels.
    fn migrate<T: crate::base::record::Cargo>(
        &self,
        travel: Travel,
        mut to_ranks: Vec<Vec<T>>,
    ) -> Result<Vec<T>, Error> {
        let mut rows = std::mem::take(&mut to_ranks[self.transport.rank()]);
        for arrived in transfer::exchange(self.transport, self.number_of(travel), to_ranks)? {
            rows.extend(arrived);
        }
        Ok(rows)
    }

    /// Parts the `held` rows that are here, whose places come first, and `fresh` ones into those that stay and parcels.
    fn part<T>(
        &self,
        places: &[Place],
        held: usize,
        id: impl Fn(usize) -> u64,
        whole: impl Fn(usize) -> T,
        fresh: Vec<T>,
    ) -> (Vec<Standing>, Vec<Vec<T>>) {
        let mut to_ranks: Vec<Vec<T>> = (0..self.transport.size()).map(|_| Vec::new()).collect();
        let mut order = Vec::with_capacity(places.len());
        for (row, place) in places[..held].iter().enumerate() {
            match self.subdomain.deal.owner(place.0) {
                owner if owner == self.subdomain.deal.rank => order.push((*place, id(row), row as u32)),
                owner => to_ranks[owner].push(whole(row)),
            }
        }
        let rank = self.subdomain.deal.rank;
        match places[held..].iter().all(|place| self.subdomain.deal.owner(place.0) == rank) {
            // On one rank nothing is moved: at the start and at an enrichment these are most rows that there are.
            true => to_ranks[rank] = fresh,
            false => {
                for (row, place) in fresh.into_iter().zip(&places[held..]) {
                    to_ranks[self.subdomain.deal.owner(place.0)].push(row);
                }
            }
        }
        (order, to_ranks)
    }

    /// Sends the parcels, and puts those that arrive among those that stay; `stands` says where one does.
    fn join<T: crate::base::record::Cargo>(
        &self,
        travel: Travel,
        (mut order, held): (Vec<Standing>, usize),
        to_ranks: Vec<Vec<T>>,
        stands: impl Fn(&T) -> Result<(Place, u64), Error>,
    ) -> Result<Moved<T>, Error> {
        let arrived = self.migrate(travel, to_ranks)?;
        for (number, row) in arrived.iter().enumerate() {
            let (place, id) = stands(row)?;
            order.push((place, id, (held + number) as u32));
        }
        order.sort_unstable();
        let ranges = self.ranges(order.len(), |row| order[row].0.0);
        Ok(Moved { sources: order.into_iter().map(|(_, _, source)| source).collect(), held, arrived, ranges })
    }

    fn check_counts(&self) -> Result<(), Error> {
        let mut counts = [self.assembly.grains.owned as i64, self.continuum.points.len() as i64];
        self.transport.sum(&mut counts);
        for (found, expected, what) in
            [(counts[0], self.grains_total, "grains"), (counts[1], self.points_total, "points")]
        {
            if found as u64 != expected {
                return Err(Error::Run(format!(
                    "step {}: {expected} {what} before the rebuild, {found} after it; some were lost, which must not happen: please report this",
                    self.step
                )));
            }
        }
        Ok(())
    }

    /// Rows of each block held here, from the block of every row.
    fn ranges(&self, rows: usize, block_of: impl Fn(usize) -> usize) -> Vec<Range<usize>> {
        let mut next = 0;
        let mut range_of = |block: usize| {
            let start = next;
            while next < rows && block_of(next) == block {
                next += 1;
            }
            start..next
        };
        self.subdomain.deal.held().map(&mut range_of).collect()
    }

    fn parts_of_cell(&self) -> usize {
        self.subdomain.layout.parts_of_cell(self.settings.grains.skin)
    }

    pub(crate) fn block_of_grain(&self, cold: &Cold<S>) -> Result<Place, Error> {
        self.block_of(&cold.home, self.parts_of_cell(), "grain", cold.id.0)
    }

    /// Number of the cell that a grain of this rank lay in at the last rebuild, by the same reckoning as its block.
    pub(crate) fn cell_of_grain(&self, cold: &Cold<S>) -> Option<usize> {
        self.subdomain.layout.cell_of::<S>(&self.assembly.cell_home.fraction(&cold.home), self.parts_of_cell())
    }

    /// The same of a point.
    pub(crate) fn cell_of_point(&self, cold: &PointCold<S>) -> Option<usize> {
        self.subdomain.layout.cell_of::<S>(&self.assembly.cell_home.fraction(&cold.home), 1)
    }

    pub(crate) fn block_of_point(&self, cold: &PointCold<S>) -> Result<Place, Error> {
        self.block_of(&cold.home, 1, "point", cold.id.0)
    }

    /// Block of a place, and which of the parts of its cells it lies in.
    fn block_of(&self, home: &S::Vector, parts: usize, what: &str, id: u64) -> Result<Place, Error> {
        self.subdomain.layout.place::<S>(&self.assembly.cell_home.fraction(home), parts).ok_or_else(|| {
            let place: Vec<String> = (0..S::DIMENSION).map(|axis| format!("{:.6e}", home[axis])).collect();
            Error::Run(format!(
                "step {}: {what} {id} on rank {} is at ({}) m, outside the domain; the run is unstable, or the domain too small: check time.step and the last frames, or move the edges of the domain outwards (cell.lower and cell.upper, of a continuum grid.lower and grid.upper; beyond the open ends of cell.copies a quarter of their length is free)",
                self.step,
                self.transport.rank(),
                place.join(", "),
            ))
        })
    }

    /// Copies of other ranks' grains within reach of blocks held here, behind the owned rows.
    fn fetch_ghosts(&mut self) -> Result<(), Error> {
        let reach = self.reach();
        let mut heights = [0.0; 3];
        for (axis, height) in heights.iter_mut().enumerate().take(S::DIMENSION) {
            *height = self.assembly.cell_home.height(axis);
        }
        let mut rows_to: Vec<Vec<u32>> = vec![Vec::new(); self.transport.size()];
        for (block, range) in self.subdomain.deal.held().zip(&self.subdomain.grain_ranges) {
            let around: Vec<(usize, usize)> = self
                .subdomain
                .layout
                .around(block)
                .into_iter()
                .map(|neighbour| (self.subdomain.deal.owner(neighbour), neighbour))
                .filter(|(owner, _)| *owner != self.subdomain.deal.rank)
                .collect();
            if around.is_empty() {
                continue;
            }
            for row in range.clone() {
                let fraction = self.assembly.cell_home.fraction(&self.assembly.grains.cold[row].home);
                for (owner, neighbour) in &around {
                    let near = self.subdomain.layout.distance::<S>(&fraction, *neighbour, &heights) <= reach;
                    if near && rows_to[*owner].last() != Some(&(row as u32)) {
                        rows_to[*owner].push(row as u32);
                    }
                }
            }
        }
        let copy = |row: &u32| GrainRow {
            hot: self.assembly.grains.hot[*row as usize],
            cold: self.assembly.grains.cold[*row as usize],
            spring: PenaltySpring::loose(),
            contacts: Vec::new(),
        };
        // `around` is sorted by block, so an owner may come up again after another: rows must be unique per receiver.
        for rows in &mut rows_to {
            rows.sort_unstable();
            rows.dedup();
        }
        let outgoing = rows_to.iter().map(|rows| rows.iter().map(copy).collect()).collect();
        let incoming = transfer::exchange::<GrainRow<S>>(self.transport, self.number_of(Travel::Ghosts), outgoing)?;
        // Exactly, since growing would double the arrays of owned rows as well.
        let copies = incoming.iter().map(Vec::len).sum();
        self.assembly.grains.hot.reserve_exact(copies);
        self.assembly.grains.cold.reserve_exact(copies);
        self.subdomain.ghosts = Halo::default();
        self.subdomain.ghosts.sends =
            rows_to.into_iter().enumerate().filter(|(_, rows)| !rows.is_empty()).collect::<Vec<_>>();
        for (peer, rows) in incoming.into_iter().enumerate().filter(|(_, rows)| !rows.is_empty()) {
            let first = self.assembly.grains.hot.len() as u32;
            for row in &rows {
                self.assembly.grains.hot.push(row.hot);
                self.assembly.grains.cold.push(row.cold);
            }
            self.subdomain.ghosts.receives.push((peer, first..first + rows.len() as u32));
        }
        Ok(())
    }

    /// Grains that take part in the coupling from now on.
    fn mark_participants(&mut self) {
        let (held, blocks) = (self.subdomain.deal.held(), self.subdomain.layout.block_count());
        let near = self.near_membranes();
        let is_coupled = self.is_coupled();
        let grains = &self.assembly.grains;
        let near = &near;
        let of_block = |(block, range): (usize, &Range<usize>)| {
            let takes_in = move |row: usize| {
                is_coupled && Participants::takes_in(grains.movers[row], grains.hot[row].weight, near[block])
            };
            range.clone().zip(0..).filter(move |(row, _)| takes_in(*row)).map(|(_, row)| row)
        };
        let participants = Participants::of(held.clone().zip(&self.subdomain.grain_ranges).map(of_block));
        self.untie(&participants);
        let before = std::mem::replace(&mut self.subdomain.participants, participants);
        if !is_coupled {
            return;
        }
        let mut counts = vec![0i64; blocks];
        let has_any = |participants: &Participants, number: usize| !participants.in_block(number).is_empty();
        for (number, block) in held.clone().enumerate() {
            counts[block] = i64::from(has_any(&self.subdomain.participants, number));
        }
        self.transport.sum(&mut counts);
        let coupled: Vec<bool> = counts.iter().map(|count| *count > 0).collect();
        // Grains of a block bring to nodes of the blocks around it.
        let shared = self.with_blocks_around(&coupled)[held.clone()].to_vec();
        let same = before.blocks() == held.len()
            && (0..held.len()).all(|number| has_any(&before, number) == has_any(&self.subdomain.participants, number));
        if !same || self.continuum.tiles.shared != shared {
            self.continuum.tiles.share(&self.subdomain.nodes.mosaic, shared);
        }
    }

    /// Blocks of the whole domain within reach of membranes.
    pub(crate) fn near_membranes(&self) -> Vec<bool> {
        let mut vertices = vec![0; self.subdomain.layout.block_count()];
        if self.is_coupled() {
            self.count_vertices(&mut vertices);
        }
        self.within(COUPLED_CELLS, &vertices)
    }

    /// Grains that do not take part have nothing to be tied to.
    fn untie(&mut self, participants: &Participants) {
        for (number, range) in self.subdomain.grain_ranges.iter().enumerate() {
            let mut tied = participants.in_block(number).iter().peekable();
            for (spring, row) in self.assembly.grains.springs[range.clone()].iter_mut().zip(0..) {
                if tied.next_if_eq(&&row).is_none() {
                    *spring = PenaltySpring::loose();
                }
            }
        }
    }

    /// Blocks of the whole domain within so many cells of those in which something is counted.
    pub(crate) fn within(&self, cells: usize, counts: &[i64]) -> Vec<bool> {
        let mut near: Vec<bool> = counts.iter().map(|count| *count > 0).collect();
        if !near.contains(&true) {
            return near;
        }
        for _ in 0..cells.div_ceil(self.subdomain.layout.cells_per_block) {
            near = self.with_blocks_around(&near);
        }
        near
    }

    /// Blocks of the whole domain that are among those or beside one of them.
    fn with_blocks_around(&self, blocks: &[bool]) -> Vec<bool> {
        let beside = |block: usize| self.subdomain.layout.around(block).into_iter().any(|neighbour| blocks[neighbour]);
        (0..blocks.len()).map(|block| blocks[block] || beside(block)).collect()
    }
}

/// Whether a grain is glued to a plate.
pub fn is_glued<S: Space>(grain: &GrainRow<S>) -> bool {
    matches!(grain.cold.mover, Mover::Body(_))
}
