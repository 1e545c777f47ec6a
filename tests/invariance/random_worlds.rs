//! Small worlds made at random, with blocks dealt anew by random weights between random steps: their state never differs
//! from that of one rank by a bit (invariants 1 and 2). A world that differs names its seed, and `SCREE_WORLD=seed` makes
//! that one alone.

use std::panic::{AssertUnwindSafe, catch_unwind};

use scree::base::error::Error;
use scree::base::ids::{GrainId, PointId};
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::base::symmetric::Symmetric;
use scree::dem::assembly::Constants;
use scree::dem::cell::Cell;
use scree::dem::grains::GrainRow;
use scree::dem::grains::Mover;
use scree::dem::law::law_of;
use scree::domain::grid::Grid;
use scree::domain::layout::{Ground, Layout, RIM_CELLS};
use scree::domain::parts::Parts;
use scree::domain::transfer;
use scree::domain::world::{Settings, World};
use scree::law::contact::{LinearSpringDashpot as LinearContact, NormalForce};
use scree::law::material::CriticalDruckerPrager;
use scree::mpm::penalty::Coupling;
use scree::mpm::points::Point;
use scree::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};
use scree_partition::transport::threads;
use scree_partition::{Solo, Transport};

use crate::worlds::{Random, material};

const WORLDS: u64 = 240;
const STEPS: u64 = 40;
const STEP: f64 = 1e-3;
const RANKS_MAX: usize = 8;
/// Cells between two grains of the start, and the radius of the largest.
const SPACING: f64 = 0.8;
const RADIUS: f64 = 0.42;

type Made<'t, S> = World<'t, S>;

/// What a world is, all of it from one number; cells have an edge of a metre.
struct Plan {
    random: Random,
    cells_per_block: usize,
    blocks: [usize; 3],
    periodic: [bool; 3],
    grains: bool,
    points: bool,
    shape: ShapeFunction,
    update: StressUpdate,
    transfer: Transfer,
    /// Steps of grains in one of the continuum, and from one exchange with nodes to the next.
    cycle: [u64; 2],
    /// Shear of a cell of grains that is periodic everywhere, 1/s.
    shear: f64,
}

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        ((0.5 + 0.5 * self.signed()) * limit as f64) as usize
    }
    fn one_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }
}

impl Plan {
    fn new<S: Space>(seed: u64) -> Self {
        let mut random = Random(seed);
        let (grains, points) = [(true, false), (false, true), (true, true)][random.below(3)];
        // Grains share nodes of quadratic functions alone.
        let shapes = [ShapeFunction::Quadratic, ShapeFunction::Cubic, ShapeFunction::Generalised];
        let shape = shapes[if grains { 0 } else { random.below(3) }];
        let least = if shape == ShapeFunction::Cubic { 3 } else { 2 };
        let axes = |from: usize, random: &mut Random| -> [usize; 3] {
            std::array::from_fn(|axis| if axis < S::DIMENSION { from + random.below(4) } else { 1 })
        };
        let blocks = axes(if S::DIMENSION == 2 { 4 } else { 3 }, &mut random);
        let periodic: [bool; 3] = std::array::from_fn(|axis| axis < S::DIMENSION && random.one_in(2));
        let whole = (0..S::DIMENSION).all(|axis| periodic[axis]);
        let updates = [StressUpdate::Last, StressUpdate::First, StressUpdate::ModifiedLast];
        Self {
            cells_per_block: least + random.below(2),
            blocks,
            periodic,
            grains,
            points,
            shape,
            update: updates[if grains { 0 } else { random.below(3) }],
            transfer: if !grains && random.one_in(3) { Transfer::Affine } else { Transfer::Blend { flip: 0.9 } },
            cycle: if grains && points && seed.is_multiple_of(2) { [4, 2] } else { [1, 1] },
            shear: if whole && !points { 4.0 * random.signed() } else { 0.0 },
            random,
        }
    }

    fn cells(&self) -> [usize; 3] {
        self.blocks.map(|blocks| blocks * self.cells_per_block)
    }

    /// Lower and upper corner of what is filled along an axis, m: all of a period, and within the rim of an open axis.
    fn filled(&mut self, axis: usize) -> [f64; 2] {
        let length = self.cells()[axis] as f64;
        if self.periodic[axis] {
            return [0.0, length];
        }
        let (rim, room) = (RIM_CELLS as f64 + 1.0, length - 2.0 * RIM_CELLS as f64 - 2.0);
        let lower = rim + 0.3 * room * (0.5 + 0.5 * self.random.signed());
        [lower, (lower + (0.4 + 0.3 * self.random.signed()) * room).min(length - rim).max(lower + 1.0)]
    }

    fn layout<S: Space>(&self) -> Layout {
        let ground = Ground {
            rim: self.periodic.map(|periodic| [if periodic { 0 } else { RIM_CELLS }; 2]),
            shape: self.shape,
            ..Ground::open(self.cells(), self.cells_per_block, 1.0, [0.0; 3], self.periodic)
        };
        Layout::new::<S>(ground).unwrap()
    }

    fn settings<S: Space>(&self) -> Settings<S> {
        // Grains are as fast as their lists allow in a step, and lists are not made anew within a cycle.
        let step = STEP / self.cycle[0] as f64;
        let contact = LinearContact {
            stiffness_normal: 2e4,
            stiffness_tangential: 1e4,
            damping_normal: 10.0,
            damping_tangential: 10.0,
            friction: 0.5,
            normal_force: NormalForce::TENSILE,
        };
        Settings {
            grid: Grid {
                shape: self.shape,
                update: self.update,
                transfer: self.transfer,
                penalty: Coupling { interval: self.cycle[1], ..Coupling::DEFAULT }
                    .in_steps(contact.stiffness_normal, step),
                ..Grid::blend(0.9)
            },
            material: std::sync::Arc::new(CriticalDruckerPrager {
                bulk_modulus: 1e4,
                shear_modulus: 5e3,
                cohesion: 50.0,
                ..material()
            }),
            grain_steps: self.cycle[0],
            ..Settings::of_grains(Constants::new(step, 0.15, law_of(&contact.into())))
        }
    }

    /// Places about `spacing` apart in the filled part of the domain.
    fn places<S: Space>(&mut self, spacing: f64, jitter: f64) -> Vec<S::Vector> {
        let filled: [[f64; 2]; 3] = std::array::from_fn(|axis| self.filled(axis));
        let count = |axis: usize| match axis < S::DIMENSION {
            true => ((filled[axis][1] - filled[axis][0]) / spacing).floor().max(1.0) as usize,
            false => 1,
        };
        let mut places = Vec::new();
        for z in 0..count(2) {
            for y in 0..count(1) {
                for x in 0..count(0) {
                    let mut place = S::Vector::zero();
                    for axis in 0..S::DIMENSION {
                        let at = [x, y, z][axis] as f64 + 0.5 + jitter * self.random.signed();
                        place[axis] = filled[axis][0] + spacing * at;
                    }
                    places.push(place);
                }
            }
        }
        places
    }

    fn velocity<S: Space>(&mut self, most: f64) -> S::Vector {
        let mut velocity = S::Vector::zero();
        (0..S::DIMENSION).for_each(|axis| velocity[axis] = most * self.random.signed());
        velocity
    }

    fn made_grains<S: Space>(&mut self) -> Vec<GrainRow<S>> {
        let places = self.places::<S>(SPACING, 0.1);
        let row = |(id, place): (usize, S::Vector)| {
            let radius = RADIUS * (0.95 + 0.05 * self.random.signed());
            let mut grain = GrainRow::<S>::resting(GrainId(id as u64), place, radius, 1.0, Mover::Free);
            grain.hot.velocity = self.velocity::<S>(12.0);
            (0..S::Spin::COMPONENTS).for_each(|axis| grain.hot.spin[axis] = 5.0 * self.random.signed());
            grain.hot.weight = if self.points { 0.5 } else { 1.0 };
            grain
        };
        places.into_iter().enumerate().map(row).collect()
    }

    fn made_points<S: Space>(&mut self) -> Vec<Point<S>> {
        let spacing = 0.5;
        let volume = (0..S::DIMENSION).map(|_| spacing).product::<f64>();
        let law = self.settings::<S>().material;
        let mut drift = self.velocity::<S>(15.0);
        // There is little room beside what is filled in an open axis.
        (0..S::DIMENSION).filter(|axis| !self.periodic[*axis]).for_each(|axis| drift[axis] = 0.0);
        let mut points = Vec::new();
        for (id, place) in self.places::<S>(spacing, 0.2).into_iter().enumerate() {
            let mut point = Point::resting(PointId(id as u64), place, volume, volume);
            point.hot.velocity = drift + self.velocity::<S>(2.0);
            point.hot.weight = if self.grains { 0.5 } else { 1.0 };
            point.hot.memory = law.start(&(S::identity() * -40.0), 0.85);
            point.hot.stress = Symmetric::of(&law.stress(&point.hot.memory));
            points.push(point);
        }
        points
    }

    fn world<'t, S: Space>(&mut self, transport: &'t dyn Transport) -> Result<Made<'t, S>, Error> {
        let layout = self.layout::<S>();
        let mut lengths = S::Vector::zero();
        (0..S::DIMENSION).for_each(|axis| lengths[axis] = layout.cells[axis] as f64);
        let mut cell = Cell::cuboid(S::Vector::zero(), lengths, layout.periodic);
        let mut settings = self.settings::<S>();
        if self.shear != 0.0 {
            let mut gradient = S::Tensor::zero();
            // Column by column: velocity along x that grows with y.
            gradient[S::DIMENSION] = self.shear;
            settings.grains.drive.gradient = gradient;
            cell.gradient = gradient;
        }
        let grains = if self.grains { self.made_grains::<S>() } else { Vec::new() };
        let points = if self.points { self.made_points::<S>() } else { Vec::new() };
        let here = transport.rank() == 0;
        let parts = Parts::fresh(
            if here { grains } else { Vec::new() },
            if here { points } else { Vec::new() },
            Vec::new(),
            cell,
        );
        World::new(settings, layout, transport, 0, parts)
    }
}

/// Every bit of the rows of a world, in the order of the curve, on rank 0; and how many rows there are.
fn state<S: Space>(world: &Made<S>) -> Option<(Vec<u8>, [usize; 2])> {
    let (grains, points) = world.rows();
    let grains = transfer::gather(world.transport, grains).unwrap();
    let points = transfer::gather(world.transport, points).unwrap();
    let (mut grains, mut points) = (grains?, points?);
    let counts = [grains.len(), points.len()];
    let mut bytes = transfer::pack(&mut grains);
    bytes.extend(transfer::pack(&mut points));
    Some((bytes, counts))
}

/// What came of a world, and how many of its rows changed their rank.
struct Ran {
    state: Option<(Vec<u8>, [usize; 2])>,
    sent: u64,
    rebuilds: u64,
}

/// Steps a world; at some steps everything goes home, and if `deals` seeds it, blocks are dealt anew at steps and by weights
/// of this run alone.
fn ran<S: Space>(seed: u64, transport: &dyn Transport, deals: Option<u64>) -> Result<Ran, Error> {
    let mut plan = Plan::new::<S>(seed);
    let mut world = plan.world::<S>(transport)?;
    let mut deals = deals.map(Random);
    for _ in 0..STEPS {
        world.advance()?;
        if plan.random.one_in(20) {
            world.rebuild()?;
        }
        if let Some(deals) = &mut deals
            && deals.one_in(5)
        {
            let weights: Vec<u64> =
                (0..world.subdomain.layout.block_count()).map(|_| deals.below(1000) as u64).collect();
            world.deal_by(&weights)?;
        }
    }
    Ok(Ran { state: state(&world), sent: world.load_balance.rows_sent, rebuilds: world.rebuilds })
}

/// One world on one rank and on several; counts of what happened, to see that something did.
fn compare<S: Space>(seed: u64) -> [u64; 4] {
    let ranks = 2 + Random(!seed).below(RANKS_MAX - 1);
    let alone = ran::<S>(seed, &Solo, None);
    let mut together = threads::run(ranks, |rank| ran::<S>(seed, &rank, Some(seed ^ 0x5EED)));
    let sent = together.iter().flatten().map(|ran| ran.sent).sum::<u64>();
    let (alone, first) = match (alone, together.swap_remove(0)) {
        (Ok(alone), Ok(first)) => (alone, first),
        (Err(error), _) => panic!("on one rank: {error}"),
        (_, Err(error)) => panic!("on {ranks} ranks: {error}"),
    };
    assert_eq!(alone.rebuilds, first.rebuilds, "{ranks} ranks rebuild at other steps");
    let (one, several) = (alone.state.expect("one rank has all"), first.state.expect("rank 0 has all"));
    assert_eq!(one.1, several.1, "{ranks} ranks end with other numbers of grains and points");
    assert!(one.0 == several.0, "{ranks} ranks end in another state");
    [sent, alone.rebuilds, one.1[0] as u64, one.1[1] as u64]
}

fn check(seed: u64) -> [u64; 4] {
    let compared =
        AssertUnwindSafe(|| if seed.is_multiple_of(3) { compare::<Solid>(seed) } else { compare::<Plane>(seed) });
    catch_unwind(compared).unwrap_or_else(|cause| {
        let words = cause.downcast_ref::<String>().map_or("it panicked, see above", String::as_str);
        panic!("world {seed}: {words}; SCREE_WORLD={seed} makes it again")
    })
}

#[test]
fn random_worlds_do_not_depend_on_ranks_or_deals() {
    if let Ok(seed) = std::env::var("SCREE_WORLD") {
        check(seed.parse().expect("a seed is a whole number"));
        return;
    }
    let started = std::time::Instant::now();
    let mut sums = [0; 4];
    for seed in 0..WORLDS {
        sums.iter_mut().zip(check(seed)).for_each(|(sum, count)| *sum += count);
    }
    let [sent, rebuilds, grains, points] = sums;
    println!(
        "{WORLDS} worlds in {:.0} s: {sent} rows sent, {rebuilds} rebuilds, {grains} grains, {points} points",
        started.elapsed().as_secs_f64()
    );
    assert!(
        sent > 100 * WORLDS && rebuilds > 2 * WORLDS,
        "the worlds stood still: {sent} rows sent, {rebuilds} rebuilds"
    );
}
