//! Grains that have come to rest far from any band turn back into points (beyond the seed, whose zones are for good).
//!
//! Cells of the zone farther than phi_0 and its rim from every busy cell give their grains up; those beside them become the rim of what
//! is left. Points that are made stand as they did at the start of a run, so many along a cell; each takes displacement, velocity, stress
//! and packing fraction from the fields that the grains of the cells around tell ([`crate::hybrid::patch`]). One factor to the masses
//! of all points that take something over, and one rigid correction of their velocities, make mass and momentum exactly what grains
//! gave up.

use std::collections::{BTreeMap, BTreeSet};

use scree_partition::{ExactSum, ParcelError, Reader, Writer};

use crate::dem::grains::{Hot, Mover};
use crate::error::Error;
use crate::hybrid::patch::Patch;
use crate::hybrid::rest::{CellStrain, Watch};
use crate::hybrid::track::{Instants, Track};
use crate::hybrid::zone::CellGrid;
use crate::ids::PointId;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::mpm::points::Point;
use crate::numbers::Numbers;
use crate::packing::PlanarWorld;
use crate::scenario::Enrichment;
use crate::scenario::mpm::Transfer;
use crate::space::{Linear, Plane, Space};
use crate::symmetric::Symmetric;

use super::account::{Account, Kept};
use super::{PlanarPoint, Vector, cell_grid};

type Tensor = <Plane as Space>::Tensor;

/// What a dissolution did, for the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Dissolved {
    /// Grains that went, and those that share their place with points from now on.
    pub grains: u64,
    pub grains_rim: u64,
    /// Points that came, and those that stand for all of their place from now on.
    pub points: u64,
    pub points_whole: u64,
    /// What masses of points had to be multiplied by for all mass to be kept.
    pub mass_factor: f64,
    pub kept: Kept,
}

/// Takes in how the grains have moved for `time`, s, until now. Collective.
pub fn look_for_rest<C: ContactLaw<Plane>>(
    world: &mut PlanarWorld<C>,
    watch: &mut Watch,
    (depth, time): (f64, f64),
) -> Result<(), Error> {
    let (grid, patches) = (cell_grid(world), patches(world, depth, false)?);
    let rate = |cell: &u64| {
        let rate = around(&grid, &patches, *cell).velocity(grid.cell).gradient;
        CellStrain { cell: *cell, strain: [rate[(0, 0)], rate[(1, 1)], 0.5 * (rate[(0, 1)] + rate[(1, 0)])] }
    };
    let rates: Vec<CellStrain> = patches.keys().map(rate).collect();
    watch.take(&rates, time);
    Ok(())
}

/// Cells beyond phi_0 and its rim in which grains stay all the same, so that a zone does not come and go.
const CELLS_BEYOND: f64 = 1.0;
/// Of what they would grains must fill this share of a cell for all of its points to be made, or else of a point's own place: few have
/// their centres there.
const FILLED_CELL: f64 = 0.75;
const FILLED_PLACE: f64 = 0.5;
/// Volume ratios that are believed: where a band was, fields of whole cells are not linear.
const VOLUME_RATIOS: [f64; 2] = [0.95, 1.25];
/// Points that would have to be that much heavier or lighter are not made.
const FACTORS: [f64; 2] = [0.8, 1.25];

/// What becomes of a cell with grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Stays,
    /// Its grains share it with points from now on.
    Rim,
    Leaves,
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
    let patches = patches(world, depth, true)?;
    let fates = fates(&grid, &patches, &stays);
    let fate = |place: &Vector| grid.at(place[0], place[1]).map_or(Fate::Stays, |cell| fates[cell]);

    let mut sums = ExactSum::<SUMS>::new();
    let mut places: BTreeMap<(u64, u64), f64> = BTreeMap::new();
    let mut grains = Vec::new();
    let parts = points_along_cell(world);
    for mut grain in world.rows().0 {
        let Hot { position, velocity, mass, weight, .. } = grain.hot;
        let left = match fate(&position) {
            _ if grain.cold.mover != Mover::Free => weight,
            Fate::Rim if weight == 1.0 => settings.weight,
            Fate::Leaves => 0.0,
            _ => weight,
        };
        if left < weight {
            sums.add(COUNT + usize::from(left > 0.0), 1.0);
            sums.add(GIVEN, (weight - left) * mass);
            (0..2).for_each(|axis| sums.add(GIVEN + 1 + axis, (weight - left) * mass * velocity[axis]));
            if let (1.0, Some(at)) = (weight, part_at(&grid, parts, &position)) {
                *places.entry(at).or_default() += Plane::grain_volume(grain.hot.radius, depth);
            }
        }
        if left > 0.0 {
            grain.hot.weight = left;
            grains.push(grain);
        }
    }

    let volume = (grid.cell / parts as f64).powi(2) * depth;
    let whole = fraction * volume * (parts * parts) as f64;
    let cells: BTreeSet<u64> = places.keys().map(|(cell, _)| *cell).collect();
    for cell in cells.into_iter().filter(|cell| patches[cell].solid >= FILLED_CELL * whole) {
        places.extend((0..parts * parts).map(|part| ((cell, part), fraction * volume)));
    }
    places.retain(|_, solid| *solid >= FILLED_PLACE * fraction * volume);
    // In a cell of the old rim points stand already.
    places.retain(|(cell, _), _| is_core(&patches[cell]));
    let maker =
        Maker { grid: &grid, parts, volume, fraction, first: first_free_id(world), instants, now: world.time() };
    let mut made: Vec<PlanarPoint> = Vec::with_capacity(places.len());
    for (cell, part) in places.keys() {
        let mut point = maker.point(world, (*cell, *part), &around(&grid, &patches, *cell));
        point.hot.weight = if fates[*cell as usize] == Fate::Rim { 1.0 - settings.weight } else { 1.0 };
        take_over(&mut sums, &point, point.hot.weight);
        made.push(point);
    }
    let mut points: Vec<PlanarPoint> = world.points.rows().collect();
    let is_freed = |point: &PlanarPoint| point.hot.weight < 1.0 && fate(&point.hot.position) == Fate::Leaves;
    for point in points.iter().filter(|point| is_freed(point)) {
        sums.add(COUNT + 2, 1.0);
        sums.add(HAD, point.hot.weight * point.hot.mass);
        take_over(&mut sums, point, 1.0 - point.hot.weight);
    }

    sums.add(COUNT + 3, made.len() as f64);
    let of = world.reduce(sums)?;
    let factor = of[GIVEN] / of[TAKEN];
    if !(FACTORS[0]..=FACTORS[1]).contains(&factor) {
        tracing::warn!(
            step = world.step,
            factor,
            "grains at rest stay: points in their places would not weigh what they do"
        );
        return Ok(None);
    }
    let correction = |axis: usize| (of[GIVEN + axis] - factor * of[TAKEN + axis]) / (factor * of[TAKEN] + of[HAD]);
    let correction = Vector::new(correction(1), correction(2));
    for point in &mut made {
        point.hot.mass *= factor;
        point.hot.velocity += correction;
    }
    for point in points.iter_mut().filter(|point| is_freed(point)) {
        point.hot.mass *= point.hot.weight + factor * (1.0 - point.hot.weight);
        point.hot.weight = 1.0;
        point.hot.velocity += correction;
    }
    points.append(&mut made);
    let account = Account::open(world)?;
    world.be_home();
    world.replace(grains, points)?;
    let kept = account.close(world, "turning grains at rest back into points")?;
    let [grains, grains_rim, points_whole, points] = std::array::from_fn(|count| of[COUNT + count] as u64);
    Ok(Some(Dissolved { grains, grains_rim, points, points_whole, mass_factor: factor, kept }))
}

/// Sums of a dissolution: mass and momentum that grains give up, and that points take over as they are made; mass that old points among
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

fn is_core(patch: &Patch) -> bool {
    patch.core > 0.5 * patch.mass
}

/// Of all cells of the grid.
fn fates(grid: &CellGrid, patches: &BTreeMap<u64, Patch>, stays: &[bool]) -> Vec<Fate> {
    let leaves = |cell: usize| !stays[cell] && patches.contains_key(&(cell as u64));
    let fate = |cell: usize| match patches.get(&(cell as u64)) {
        // Points of the old rim that no grain shares a cell with any more.
        None if !stays[cell] => Fate::Leaves,
        None => Fate::Stays,
        Some(_) if !stays[cell] => Fate::Leaves,
        Some(patch) if is_core(patch) && grid.around(cell).any(|(beside, _)| leaves(beside)) => Fate::Rim,
        Some(_) => Fate::Stays,
    };
    (0..stays.len()).map(fate).collect()
}

/// Points of the start along an edge of a cell.
fn points_along_cell<C: ContactLaw<Plane>>(world: &PlanarWorld<C>) -> u64 {
    (0.5 / world.layout.point_half()).round() as u64
}

/// The cell of a place, and which of its parts it lies in, row by row.
fn part_at(grid: &CellGrid, parts: u64, place: &Vector) -> Option<(u64, u64)> {
    let cell = grid.at(place[0], place[1])?;
    let way = *place - grid.centre(cell);
    let part = |axis: usize| {
        let at = ((way[axis] / grid.cell + 0.5) * parts as f64).floor();
        (at as u64).min(parts - 1)
    };
    Some((cell as u64, part(1) * parts + part(0)))
}

/// An id that no point has, and none above it.
fn first_free_id<C: ContactLaw<Plane>>(world: &PlanarWorld<C>) -> u64 {
    let mut most = [world.points.cold.iter().map(|cold| cold.id.0).max().unwrap_or(0) as f64];
    world.transport.max(&mut most);
    most[0] as u64 + 1
}

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
    fn point<C: ContactLaw<Plane>>(
        &self,
        world: &PlanarWorld<C>,
        (cell, part): (u64, u64),
        patch: &Patch,
    ) -> PlanarPoint {
        let edge = self.grid.cell / self.parts as f64;
        let way = |index: u64| (index as f64 + 0.5) * edge - 0.5 * self.grid.cell;
        let way = Vector::new(way(part % self.parts), way(part / self.parts));
        let place = self.grid.centre(cell as usize) + way;
        let (velocity, displacement) = (patch.velocity(self.grid.cell), patch.displacement(self.grid.cell));
        // x = X + u(x), so that F = (1 - du/dx)^-1.
        let deformation = Plane::inverse(&(Tensor::identity() - displacement.gradient));
        let is_sound = |of: &Tensor| (VOLUME_RATIOS[0]..=VOLUME_RATIOS[1]).contains(&Plane::determinant(of));
        let deformation = deformation.filter(is_sound).unwrap_or_else(Tensor::identity);
        let ratio = Plane::determinant(&deformation);
        let fraction = self.fraction / ratio;
        let mass = patch.mass / patch.solid * fraction * self.volume;
        let id = PointId(self.first + cell * self.parts * self.parts + part);
        let mut point: PlanarPoint = Point::resting(id, place, mass, self.volume / ratio);
        let law = &world.settings.material;
        let stress: Tensor = patch.moment * (fraction / patch.solid);
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
        let Some(cell) = grid.at(cold.home[0], cold.home[1]) else { continue };
        let patch = mine.entry(cell as u64).or_default();
        let displacement = super::motion::displacement(&hot.position, (&cold.origin, cold.image), &world.cell);
        let solid = Plane::grain_volume(hot.radius, depth);
        patch.add_grain((hot.mass, solid), &(hot.position - grid.centre(cell)), &hot.velocity, &displacement);
        if hot.weight == 1.0 {
            patch.core += hot.mass;
        }
        if let Some(moment) = moments.get(row) {
            patch.moment += moment;
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
        into.insert(cell, patch);
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
