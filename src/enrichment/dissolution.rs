//! Grains that have come to rest far from any band turn back into points (beyond the seed, whose zones are for good).
//!
//! Cells of the zone farther than phi_0 and its rim from every busy cell give their grains up; those beside them become the rim of what
//! is left. Points that are made stand as they did at the start of a run, so many along a cell; each takes displacement, velocity, stress
//! and packing fraction from the fields that the grains of the cells around tell ([`crate::hybrid::patch`]). In each set of cells that
//! hang together one factor to the masses of all points that take something over, and one rigid correction of their velocities, make
//! mass and momentum exactly what grains gave up.

use std::collections::{BTreeMap, BTreeSet};

use scree_partition::{ExactSum, ParcelError, Reader, Writer};

use crate::dem::grains::{Hot, Mover};
use crate::error::Error;
use crate::hybrid::patch::Patch;
use crate::hybrid::rest::{CellStrain, RestWatch};
use crate::hybrid::track::{Instants, Track};
use crate::hybrid::zone::CellGrid;
use crate::ids::PointId;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::mpm::points::Point;
use crate::numbers::Numbers;
use crate::packing::{Grain, PlanarWorld};
use crate::scenario::Enrichment;
use crate::scenario::mpm::Transfer;
use crate::space::{Linear, Plane, Space};
use crate::symmetric::Symmetric;

use super::account::{Account, BeforeAndAfter};
use super::{PlanarPoint, Vector, cell_grid};

type Tensor = <Plane as Space>::Tensor;

/// What a dissolution did, for the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dissolved {
    /// Grains that went, and those that share their place with points from now on.
    pub grains: u64,
    pub grains_rim: u64,
    /// Points that came, and those that stand for all of their place from now on.
    pub points: u64,
    pub points_whole: u64,
    /// What masses of points had to be multiplied by for all mass to be kept, one for each set of cells; and of sets that stay for that.
    pub mass_factors: Vec<f64>,
    pub refused: Vec<f64>,
    pub kept: BeforeAndAfter,
}

/// Takes in how the grains have moved for `time`, s, until now. Collective.
pub fn look_for_rest<C: ContactLaw<Plane>>(
    world: &mut PlanarWorld<C>,
    watch: &mut RestWatch,
    (depth, time): (f64, f64),
) -> Result<(), Error> {
    let (grid, patches) = (cell_grid(world), patches(world, depth, false)?);
    let rate = |cell: &u64| {
        let rate = around(&grid, &patches, *cell).velocity(grid.cell).gradient;
        let strain = [rate[(0, 0)], rate[(1, 1)], 0.5 * (rate[(0, 1)] + rate[(1, 0)])];
        CellStrain { cell: *cell, strain, looks: 0 }
    };
    let rates: Vec<CellStrain> = patches.keys().map(rate).collect();
    watch.take(&rates, time);
    Ok(())
}

/// Cells beyond phi_0 and its rim in which grains stay all the same, so that a zone does not come and go.
const CELLS_BEYOND: f64 = 1.0;
/// Of what they would grains must fill this share of a cell for it to be full and have all of its points, or else of a point's own place:
/// few have their centres there.
const FILLED_CELL: f64 = 0.85;
const FILLED_PLACE: f64 = 0.5;
/// Points that would have to be that much heavier or lighter are not made.
const FACTORS: [f64; 2] = [0.8, 1.25];

/// What becomes of a cell with grains, and the set of cells that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Stays,
    /// Its grains share it with points from now on.
    Rim(usize),
    Leaves(usize),
}

impl Fate {
    fn set(self) -> Option<usize> {
        match self {
            Self::Stays => None,
            Self::Rim(set) | Self::Leaves(set) => Some(set),
        }
    }
}

/// Turns grains far from all `busy` cells back into points; nothing where there are none. `depth` is that of the plane, m, `fraction`
/// the packing's at the start. Collective.
pub fn dissolve<C: ContactLaw<Plane>>(
    world: &mut PlanarWorld<C>,
    (settings, depth, fraction): (&Enrichment, f64, f64),
    instants: &Instants,
    busy: &[u64],
) -> Result<Option<Dissolved>, Error> {
    let grid = cell_grid(world);
    let stays = grid.near(busy, settings.distance + (0.5 + CELLS_BEYOND) * grid.cell);
    if patches(world, depth, false)?.keys().all(|cell| stays[*cell as usize]) {
        return Ok(None);
    }
    world.rebuild()?;
    let mut patches = patches(world, depth, true)?;
    let parts = world.layout.points_per_cell() as u64;
    let volume = (grid.cell / parts as f64).powi(2) * depth;
    let full = FILLED_CELL * fraction * volume * (parts * parts) as f64;
    for patch in patches.values_mut().filter(|patch| patch.solid >= full) {
        (patch.room_full, patch.solid_full) = (volume * (parts * parts) as f64, patch.solid);
    }
    let (fates, sets) = fates(&grid, &patches, &stays);

    // What grains and points would be, and what that would move from these to those.
    let mut sums: Vec<ExactSum<SUMS>> = (0..sets).map(|_| ExactSum::new()).collect();
    let (mut grains, _) = world.rows();
    let left: Vec<f64> = grains.iter().map(|grain| weight_left(world, &fates, settings, grain)).collect();
    let mut filled: BTreeMap<(u64, u64), f64> = BTreeMap::new();
    for (grain, left) in grains.iter().zip(&left).filter(|(grain, left)| **left < grain.hot.weight) {
        let Some(cell) = world.cell_of_grain(&grain.cold) else { continue };
        let Some(set) = fates[cell].set() else { continue };
        let Hot { position, velocity, mass, weight, .. } = grain.hot;
        let sums = &mut sums[set];
        sums.add(COUNT + usize::from(*left > 0.0), 1.0);
        sums.add(GIVEN, (weight - left) * mass);
        (0..2).for_each(|axis| sums.add(GIVEN + 1 + axis, (weight - left) * mass * velocity[axis]));
        if weight == 1.0 {
            let at = (cell as u64, part_at(&grid, parts, cell, &position));
            *filled.entry(at).or_default() += Plane::grain_volume(grain.hot.radius, depth);
        }
    }
    let mut points: Vec<PlanarPoint> = world.points.rows().collect();
    let fate_of = |world: &PlanarWorld<C>, point: &PlanarPoint| {
        world.cell_of_point(&point.cold).map_or(Fate::Stays, |cell| fates[cell])
    };
    let freed: Vec<Option<usize>> = points
        .iter()
        .map(|point| match fate_of(world, point) {
            Fate::Leaves(set) if point.hot.weight < 1.0 => Some(set),
            _ => None,
        })
        .collect();
    for (point, set) in points.iter().zip(&freed) {
        let Some(set) = *set else { continue };
        sums[set].add(COUNT + 2, 1.0);
        sums[set].add(HAD, point.hot.weight * point.hot.mass);
        take_over(&mut sums[set], point, 1.0 - point.hot.weight);
    }
    let taken = points.iter().filter_map(|point| {
        let cell = world.cell_of_point(&point.cold)?;
        Some((cell as u64, part_at(&grid, parts, cell, &point.hot.position)))
    });
    let places = places((&grid, &patches), (parts, volume * fraction), &filled, taken.collect(), world);
    let first = first_free_id(world);
    let maker = Maker { grid: &grid, parts, volume, fraction, first, instants, now: world.time() };
    let mut made: Vec<(usize, PlanarPoint)> = Vec::with_capacity(places.len());
    for (cell, part) in places {
        let Some(set) = fates[cell as usize].set() else { continue };
        let mut point = maker.point(world, (cell, part), &around(&grid, &patches, cell));
        point.hot.weight = if matches!(fates[cell as usize], Fate::Rim(_)) { 1.0 - settings.weight } else { 1.0 };
        take_over(&mut sums[set], &point, point.hot.weight);
        sums[set].add(COUNT + 3, 1.0);
        made.push((set, point));
    }

    let mut done = Dissolved::default();
    let mut changes: Vec<Option<Change>> = Vec::with_capacity(sets);
    for sums in sums {
        let of = world.reduce(sums)?;
        let change = Change::of(&of);
        if of[TAKEN] == 0.0 {
            // Single grains among points that are whole already.
            changes.push(None);
            continue;
        }
        if change.is_sound() {
            done.mass_factors.push(change.factor);
            let counts = [&mut done.grains, &mut done.grains_rim, &mut done.points_whole, &mut done.points];
            counts.into_iter().zip(&of[COUNT..]).for_each(|(count, more)| *count += *more as u64);
        } else {
            done.refused.push(change.factor);
        }
        changes.push(change.is_sound().then_some(change));
    }
    if done.mass_factors.is_empty() {
        return Ok((!done.refused.is_empty()).then_some(done));
    }
    for (grain, left) in grains.iter_mut().zip(left) {
        let set = world.cell_of_grain(&grain.cold).and_then(|cell| fates[cell].set());
        if set.is_some_and(|set| changes[set].is_some()) {
            grain.hot.weight = left;
        }
    }
    grains.retain(|grain| grain.hot.weight > 0.0 || grain.cold.mover != Mover::Free);
    for (point, set) in points.iter_mut().zip(freed) {
        if let Some(change) = set.and_then(|set| changes[set].as_ref()) {
            point.hot.mass *= point.hot.weight + change.factor * (1.0 - point.hot.weight);
            point.hot.weight = 1.0;
            point.hot.velocity += change.velocity;
        }
    }
    for (set, mut point) in made {
        if let Some(change) = &changes[set] {
            point.hot.mass *= change.factor;
            point.hot.velocity += change.velocity;
            points.push(point);
        }
    }
    let account = Account::open(world)?;
    world.be_home();
    world.replace(grains, points)?;
    done.kept = account.close(world, "turning grains at rest back into points")?;
    Ok(Some(done))
}

/// Sums of a set of cells: mass and momentum that grains give up, and that points take over as they are made; mass that old points among
/// these had; grains that go, grains and points whose weights change, points that are made.
const SUMS: usize = 11;
const GIVEN: usize = 0;
const TAKEN: usize = 3;
const HAD: usize = 6;
const COUNT: usize = 7;

fn take_over(sums: &mut ExactSum<SUMS>, point: &PlanarPoint, share: f64) {
    let mass = share * point.hot.mass;
    sums.add(TAKEN, mass);
    (0..2).for_each(|axis| sums.add(TAKEN + 1 + axis, mass * point.hot.velocity[axis]));
}

/// What makes mass and momentum of a set's points what its grains gave up.
struct Change {
    /// Of the mass that is taken over.
    factor: f64,
    /// Of all points that take some over, m/s.
    velocity: Vector,
}

impl Change {
    fn of(sums: &[f64; SUMS]) -> Self {
        let factor = sums[GIVEN] / sums[TAKEN];
        let mass = factor * sums[TAKEN] + sums[HAD];
        let velocity = |axis: usize| (sums[GIVEN + axis] - factor * sums[TAKEN + axis]) / mass;
        Self { factor, velocity: Vector::new(velocity(1), velocity(2)) }
    }

    fn is_sound(&self) -> bool {
        (FACTORS[0]..=FACTORS[1]).contains(&self.factor)
    }
}

/// What remains of a grain's weight.
fn weight_left<C: ContactLaw<Plane>>(
    world: &PlanarWorld<C>,
    fates: &[Fate],
    settings: &Enrichment,
    grain: &Grain<C>,
) -> f64 {
    let weight = grain.hot.weight;
    let fate = world.cell_of_grain(&grain.cold).map_or(Fate::Stays, |cell| fates[cell]);
    match fate {
        _ if grain.cold.mover != Mover::Free => weight,
        Fate::Rim(_) if weight == 1.0 => settings.weight,
        Fate::Leaves(_) => 0.0,
        _ => weight,
    }
}

/// Cells of this rank and parts of them that points are to be made in, in their order: all of a full cell's that are free, and elsewhere
/// those that grains fill. `filled` is the volume of the grains outside the rim that give up their place, m3, `taken` where points are,
/// `solid` what grains fill of a part in the mean, m3.
fn places<C: ContactLaw<Plane>>(
    (grid, patches): (&CellGrid, &BTreeMap<u64, Patch>),
    (parts, solid): (u64, f64),
    filled: &BTreeMap<(u64, u64), f64>,
    taken: BTreeSet<(u64, u64)>,
    world: &PlanarWorld<C>,
) -> BTreeSet<(u64, u64)> {
    let is_free = |cell: u64, part: u64| {
        let place = middle_of(grid, parts, (cell, part));
        let reach = 0.5 * grid.cell / parts as f64;
        world.bodies.iter().filter_map(|body| body.nearest(&place)).all(|near| near.distance >= reach)
    };
    let mut places = BTreeSet::new();
    for ((cell, part), volume) in filled {
        // In a cell of the old rim points stand already.
        if patches[cell].core <= 0.5 * patches[cell].mass {
            continue;
        }
        match patches[cell].room_full > 0.0 {
            true => places.extend((0..parts * parts).filter(|part| is_free(*cell, *part)).map(|part| (*cell, part))),
            false if *volume >= FILLED_PLACE * solid => drop(places.insert((*cell, *part))),
            false => (),
        }
    }
    places.difference(&taken).copied().collect()
}

/// Of all cells of the grid; and how many sets of them leave or become the rim of what stays.
fn fates(grid: &CellGrid, patches: &BTreeMap<u64, Patch>, stays: &[bool]) -> (Vec<Fate>, usize) {
    let has_grains = |cell: usize| patches.contains_key(&(cell as u64));
    let is_core = |cell: usize| patches.get(&(cell as u64)).is_some_and(|patch| patch.core > 0.5 * patch.mass);
    let leaves = |cell: usize| !stays[cell] && has_grains(cell);
    let is_rim = |cell: usize| stays[cell] && is_core(cell) && grid.around(cell).any(|(beside, _)| leaves(beside));
    // Points of the old rim may lie in a cell without grains, beside those that leave.
    let is_bare = |cell: usize| !stays[cell] && grid.around(cell).any(|(beside, _)| leaves(beside));
    let changes = |cell: &usize| leaves(*cell) || is_rim(*cell) || is_bare(*cell);
    let cells: Vec<usize> = (0..stays.len()).filter(changes).collect();
    let mut fates = vec![Fate::Stays; stays.len()];
    let sets = grid.sets(&cells);
    for (number, set) in sets.iter().enumerate() {
        for cell in set {
            fates[*cell] = if is_rim(*cell) { Fate::Rim(number) } else { Fate::Leaves(number) };
        }
    }
    (fates, sets.len())
}

/// Which of its parts a place in a cell lies in, row by row.
fn part_at(grid: &CellGrid, parts: u64, cell: usize, place: &Vector) -> u64 {
    let way = *place - grid.centre(cell);
    let part = |axis: usize| {
        let at = ((way[axis] / grid.cell + 0.5) * parts as f64).floor();
        (at as u64).min(parts - 1)
    };
    part(1) * parts + part(0)
}

/// Middle of a part of a cell, m.
fn middle_of(grid: &CellGrid, parts: u64, (cell, part): (u64, u64)) -> Vector {
    let edge = grid.cell / parts as f64;
    let way = |index: u64| (index as f64 + 0.5) * edge - 0.5 * grid.cell;
    grid.centre(cell as usize) + Vector::new(way(part % parts), way(part / parts))
}

/// An id that no point has, and none above it.
fn first_free_id<C: ContactLaw<Plane>>(world: &PlanarWorld<C>) -> u64 {
    let mut most = [world.points.cold.iter().map(|cold| cold.id.0).max().unwrap_or(0) as f64];
    world.transport.max(&mut most);
    most[0] as u64 + 1
}

/// Displacement gradients up to which fields over some cells are linear enough to tell volumes.
const GRADIENT_LINEAR: f64 = 0.1;
/// Volume ratios that are believed.
const VOLUME_RATIOS: [f64; 2] = [0.9, 1.25];

/// Makes points of patches.
struct Maker<'a> {
    grid: &'a CellGrid,
    /// Points along a cell, and the volume of each, m3.
    parts: u64,
    volume: f64,
    /// Packing fraction at the start.
    fraction: f64,
    /// Ids count places from here.
    first: u64,
    instants: &'a Instants,
    /// s.
    now: f64,
}

impl Maker<'_> {
    /// In the middle of a part of a cell, as the grains of the patch around the cell's centre are in the mean.
    fn point<C: ContactLaw<Plane>>(&self, world: &PlanarWorld<C>, at: (u64, u64), patch: &Patch) -> PlanarPoint {
        let place = middle_of(self.grid, self.parts, at);
        let way = place - self.grid.centre(at.0 as usize);
        let (velocity, displacement) = (patch.velocity(self.grid.cell), patch.displacement(self.grid.cell));
        let deformation = self.deformation(&displacement.gradient, patch);
        let ratio = Plane::determinant(&deformation);
        let fraction = self.fraction / ratio;
        let mass = patch.mass / patch.solid * fraction * self.volume;
        let id = PointId(self.first + at.0 * self.parts * self.parts + at.1);
        let mut point: PlanarPoint = Point::resting(id, place, mass, self.volume / ratio);
        let law = &world.settings.material;
        // Of the space that grains of the core have; elsewhere nodes bear a part.
        let stress: Tensor =
            if patch.solid_core > 0.0 { patch.moment * (fraction / patch.solid_core) } else { Tensor::zero() };
        point.hot.velocity = velocity.at(&way);
        point.hot.deformation = deformation;
        point.hot.memory = law.start(&(stress * ratio), fraction);
        point.hot.stress = Symmetric::of(&law.stress(&point.hot.memory));
        if world.settings.grid.transfer == Transfer::Affine {
            point.affine = velocity.gradient;
        }
        let moved = displacement.at(&way);
        point.cold.origin = place - moved;
        point.cold.track = self.track(&moved);
        point
    }

    /// x = X + u(x), so that F = (1 - du/dx)^-1. Where grains went far, u is not linear over some cells: there the volume is the one that
    /// they fill, if they do.
    fn deformation(&self, gradient: &Tensor, patch: &Patch) -> Tensor {
        let found = Plane::inverse(&(Tensor::identity() - gradient));
        let found = found.filter(|found| Plane::determinant(found) > 0.0).unwrap_or_else(Tensor::identity);
        let ratio = Plane::determinant(&found);
        let counted = self.fraction * patch.room_full / patch.solid_full;
        let wanted = match gradient.norm() > GRADIENT_LINEAR && patch.room_full > 0.0 {
            true => counted,
            false => ratio,
        };
        found * (wanted.clamp(VOLUME_RATIOS[0], VOLUME_RATIOS[1]) / ratio).sqrt()
    }

    /// Of grains no path is known: straight ahead.
    fn track(&self, moved: &Vector) -> Track<Plane> {
        let mut track = Track::default();
        for (displacement, time) in track.displacements.iter_mut().zip(&self.instants.times) {
            *displacement = moved * (time / self.now);
        }
        track
    }
}

/// Sums of the cells around one, and of itself, about its centre.
fn around(grid: &CellGrid, patches: &BTreeMap<u64, Patch>, cell: u64) -> Patch {
    let mut sum = Patch::default();
    for (beside, step) in grid.around(cell as usize) {
        if let Some(patch) = patches.get(&(beside as u64)) {
            sum.add(patch, &Vector::new(step[0] as f64 * grid.cell, step[1] as f64 * grid.cell));
        }
    }
    sum
}

/// Sums of all cells that hold grains, each about its own centre, on every rank; with the stress of their contacts if that is wanted. A
/// cell belongs to one rank, which adds its grains up in the order of its rows. Collective.
fn patches<C: ContactLaw<Plane>>(
    world: &mut PlanarWorld<C>,
    depth: f64,
    with_contacts: bool,
) -> Result<BTreeMap<u64, Patch>, Error> {
    let grid = cell_grid(world);
    let moments = if with_contacts { moments(world) } else { Vec::new() };
    let mut mine: BTreeMap<u64, Patch> = BTreeMap::new();
    let rows = world.grains.hot[..world.grains.owned].iter().zip(&world.grains.cold).enumerate();
    for (row, (hot, cold)) in rows.filter(|(_, (_, cold))| cold.mover == Mover::Free) {
        let Some(cell) = world.cell_of_grain(cold) else { continue };
        let patch = mine.entry(cell as u64).or_default();
        let displacement = super::motion::displacement(&hot.position, (&cold.origin, cold.image), &world.cell);
        let solid = Plane::grain_volume(hot.radius, depth);
        patch.add_grain((hot.mass, solid), &(hot.position - grid.centre(cell)), &hot.velocity, &displacement);
        if hot.weight == 1.0 {
            patch.core += hot.mass;
            patch.solid_core += solid;
            patch.moment += moments.get(row).copied().unwrap_or_else(Tensor::zero);
        }
    }
    let mut parcel = Writer::new();
    for (cell, patch) in &mine {
        parcel.u64(*cell);
        patch.numbers().iter().for_each(|number| parcel.f64(*number));
    }
    let mut all = BTreeMap::new();
    for bytes in world.transport.all_gather(parcel.as_bytes()) {
        read(&bytes, &mut all).map_err(|error| Error::Run(error.to_string()))?;
    }
    Ok(all)
}

fn read(bytes: &[u8], into: &mut BTreeMap<u64, Patch>) -> Result<(), ParcelError> {
    let mut reader = Reader::plain(bytes);
    while reader.left() > 0 {
        let (cell, mut patch) = (reader.u64()?, Patch::default());
        for number in patch.numbers_mut() {
            *number = reader.f64()?;
        }
        let before = into.insert(cell, patch);
        assert!(before.is_none(), "a cell belongs to one rank");
    }
    Ok(())
}

/// Love-Weber sums of all owned grains, J. Collective.
fn moments<C: ContactLaw<Plane>>(world: &mut PlanarWorld<C>) -> Vec<Tensor> {
    world.refresh_ghosts();
    let (law, grains) = (&world.settings.contact, &world.grains);
    let mut moments = vec![Tensor::zero(); grains.owned];
    let on_bodies = world.walls.bearings(law, grains, (&world.bodies, &world.cell));
    let on_grains = (0..grains.owned).flat_map(|row| world.contacts.bearings(law, grains, row));
    for bearing in on_bodies.chain(on_grains) {
        moments[bearing.row as usize] += bearing.moment();
    }
    moments
}
