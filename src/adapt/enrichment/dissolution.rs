//! Grains that have come to rest far from any band turn back into points (beyond Chen et al. 2021, whose zones are for good).
//!
//! Cells of the zone farther than phi_0, its rim and one cell more from every busy cell give their grains up where what takes their place can bear what they do
//! ([`super::leaving`]); those beside them become the rim of what is left. Points that are made stand as they did at the start of a run, so many along a cell; each takes displacement, velocity, stress
//! and solid volume fraction from the fields that the grains of the cells around tell ([`crate::couple::patch`]). In each set of cells that
//! hang together one factor to the masses of all points that take something over, and one rigid correction of their velocities, make
//! mass and momentum exactly what grains gave up.

use std::collections::BTreeMap;

use scree_partition::ExactSum;

use super::account::{Account, BeforeAndAfter};
use super::keep::keep;
use super::leaving::Cells;
use super::motion::begin_track;
use super::patches::{Full, patches, with_full};
use super::points::{Maker, first_free_id, part_at, places};
use super::zones::reach;
use super::{PlanarPoint, Vector, cell_grid};
use crate::adapt::cells::around;
use crate::base::error::Error;
use crate::base::space::{Plane, Space};
use crate::couple::kept::KeptGrains;
use crate::couple::patch::Patch;
use crate::couple::rest::RestWatch;
use crate::couple::zone::{CellGrid, Enrichment};
use crate::dem::grains::{Hot, Mover};
use crate::mpm::track::Instants;
use crate::prepare::sheared::{Grain, PlanarWorld};

/// What a dissolution did, for the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dissolved {
    /// Grains that went, and those that share their place with points from now on.
    pub grains: u64,
    /// Those of the new rim, in number.
    pub grains_rim: u64,
    /// Points that came, and those that stand for all of their place from now on.
    pub points: u64,
    /// Those of the old rim, in number, whose weight is 1 again.
    pub points_whole: u64,
    /// What masses of points had to be multiplied by for all mass to be kept, one for each set of cells; and of sets that stay for that.
    pub mass_factors: Vec<f64>,
    /// Factors of the sets that stay, all outside of 0.8 to 1.25.
    pub refused: Vec<f64>,
    /// Shares of the continuum's strength that sets bear which stay for that, all above `zone.rest_strength`.
    pub mobilised: Vec<f64>,
    /// Of the whole world; zero where all sets stay.
    pub kept: BeforeAndAfter,
}

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

/// Turns grains far from all `busy` cells back into points, which have hardened by what `watch` knows to have been borne in their places; nothing where there are none.
/// Of a zone that brings grains back, `kept` takes them in, and `instants` is when. `depth` is that of the plane, m, `fraction` the packing's at the start. Collective.
pub fn dissolve(
    world: &mut PlanarWorld,
    (settings, depth, fraction): (&Enrichment, f64, f64),
    (instants, kept): (&mut Instants, &mut KeptGrains),
    (watch, busy): (&RestWatch, &[u64]),
) -> Result<Option<Dissolved>, Error> {
    let grid = cell_grid(world);
    let near = grid.near(busy, reach(settings, grid.cell));
    if patches(world, depth, false)?.keys().all(|cell| near[*cell as usize]) {
        return Ok(None);
    }
    let parts = world.subdomain.layout.points_per_cell() as u64;
    let volume = (grid.cell / parts as f64).powi(2) * depth;
    let room = volume * (parts * parts) as f64;
    let full = Full { room, fraction };
    // By the cells of the last rebuild: another one would change the bits of a run whose grains stay.
    let before = with_full(patches(world, depth, true)?, full);
    let points = points_of_cells(world, near.len());
    let cells = Cells { grid: &grid, patches: &before, points: &points, parts, room, fraction };
    let (leaves, mobilised) = cells.leaving(&near, (&world.settings.material, settings.life.rest_strength));
    if !before.keys().any(|cell| leaves[*cell as usize]) {
        return Ok((!mobilised.is_empty()).then(|| Dissolved { mobilised, ..Dissolved::default() }));
    }
    let stays: Vec<bool> = leaves.into_iter().map(|leaves| !leaves).collect();
    world.rebuild()?;
    let patches = with_full(patches(world, depth, true)?, full);
    let (fates, sets) = fates(&grid, &patches, &stays);
    let ground = Ground { grid: &grid, patches: &patches, fates: &fates, parts, volume, fraction };
    let mut draft = Draft::of(world, &ground, settings, (sets, depth));
    draft.make_points(world, &ground, settings, (instants, watch));
    let (mut done, changes) = draft.agree(world)?;
    done.mobilised = mobilised;
    if done.mass_factors.is_empty() {
        let is_told = !done.refused.is_empty() || !done.mobilised.is_empty();
        return Ok(is_told.then_some(done));
    }
    if settings.life.returns() {
        keep(world, &draft.grains, kept, instants)?;
    } else {
        // Those of a stretch that brought grains back would not be all of them any more.
        *kept = KeptGrains::default();
    }
    let (grains, points) = draft.carried_out(world, &fates, &changes);
    let account = Account::open(world)?;
    world.be_home();
    world.replace(grains, points)?;
    if settings.life.returns() {
        begin_track(world, instants);
    }
    done.kept = account.close(world, "turning grains at rest back into points")?;
    Ok(Some(done))
}

/// How many points each of so many cells holds, on every rank. Collective.
fn points_of_cells(world: &PlanarWorld, cells: usize) -> Vec<f64> {
    let mut points = vec![0.0; cells];
    let of_points = world.continuum.points.cold.iter().filter_map(|cold| world.cell_of_point(cold));
    of_points.for_each(|cell| points[cell] += 1.0);
    // A cell belongs to one rank.
    world.transport.max(&mut points);
    points
}

/// Where a dissolution takes place.
struct Ground<'a> {
    grid: &'a CellGrid,
    patches: &'a BTreeMap<u64, Patch>,
    fates: &'a [Fate],
    /// Points along a cell, the room of each, m3, and the solid volume fraction at the start.
    parts: u64,
    volume: f64,
    fraction: f64,
}

/// What grains and points of this rank are to become, and what that moves from these to those, set by set.
struct Draft {
    grains: Vec<Grain>,
    /// What remains of their weights.
    left: Vec<f64>,
    /// Volume of grains outside the rim that give up their place, by cell and part of it, m3.
    filled: BTreeMap<(u64, u64), f64>,
    points: Vec<PlanarPoint>,
    /// The set in which a point of the old rim comes to stand for all of its place.
    freed: Vec<Option<usize>>,
    /// Points that are made, with their sets.
    made: Vec<(usize, PlanarPoint)>,
    sums: Vec<ExactSum<SUMS>>,
}

impl Draft {
    fn of(world: &PlanarWorld, ground: &Ground<'_>, settings: &Enrichment, (sets, depth): (usize, f64)) -> Self {
        let (grains, points) = world.rows();
        let left = grains.iter().map(|grain| weight_left(world, ground.fates, settings, grain)).collect();
        let freed = points.iter().map(|point| freed(world, ground.fates, point)).collect();
        let sums = (0..sets).map(|_| ExactSum::new()).collect();
        let mut draft = Self { grains, left, filled: BTreeMap::new(), points, freed, made: Vec::new(), sums };
        for (grain, left) in draft.grains.iter().zip(&draft.left).filter(|(grain, left)| **left < grain.hot.weight) {
            let Some(cell) = world.cell_of_grain(&grain.cold) else { continue };
            let Some(set) = ground.fates[cell].set() else { continue };
            let Hot { position, velocity, mass, weight, .. } = grain.hot;
            let sums = &mut draft.sums[set];
            sums.add(COUNT + usize::from(*left > 0.0), 1.0);
            sums.add(GIVEN, (weight - left) * mass);
            (0..2).for_each(|axis| sums.add(GIVEN + 1 + axis, (weight - left) * mass * velocity[axis]));
            if weight == 1.0 {
                let at = (cell as u64, part_at(ground.grid, ground.parts, cell, &position));
                *draft.filled.entry(at).or_default() += Plane::grain_volume(grain.hot.radius, depth);
            }
        }
        for (point, set) in draft.points.iter().zip(&draft.freed) {
            let Some(set) = *set else { continue };
            draft.sums[set].add(COUNT + 2, 1.0);
            draft.sums[set].add(HAD, point.hot.weight * point.hot.mass);
            take_over(&mut draft.sums[set], point, 1.0 - point.hot.weight);
        }
        draft
    }

    fn make_points(
        &mut self,
        world: &PlanarWorld,
        ground: &Ground<'_>,
        settings: &Enrichment,
        (instants, watch): (&Instants, &RestWatch),
    ) {
        let Ground { grid, patches, fates, parts, volume, fraction } = *ground;
        let taken = self.points.iter().filter_map(|point| {
            let cell = world.cell_of_point(&point.cold)?;
            Some((cell as u64, part_at(grid, parts, cell, &point.hot.position)))
        });
        let places = places((grid, patches), (parts, volume * fraction), &self.filled, taken.collect(), world);
        let (first, now) = (first_free_id(world), world.time());
        let maker = Maker { grid, parts, volume, fraction, first, instants, now };
        for (cell, part) in places {
            let fate = fates[cell as usize];
            let Some(set) = fate.set() else { continue };
            let mut point = maker.point(world, (cell, part), &around(grid, patches, cell));
            world.settings.material.harden(&mut point.hot.memory, watch.mobilised(cell));
            point.hot.weight = if matches!(fate, Fate::Rim(_)) { 1.0 - settings.weight } else { 1.0 };
            take_over(&mut self.sums[set], &point, point.hot.weight);
            self.sums[set].add(COUNT + 3, 1.0);
            self.made.push((set, point));
        }
    }

    /// What comes of each set, none where it stays. Collective.
    fn agree(&mut self, world: &PlanarWorld) -> Result<(Dissolved, Vec<Option<Change>>), Error> {
        let (mut done, mut changes) = (Dissolved::default(), Vec::new());
        for sums in std::mem::take(&mut self.sums) {
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
        Ok((done, changes))
    }

    fn carried_out(
        self,
        world: &PlanarWorld,
        fates: &[Fate],
        changes: &[Option<Change>],
    ) -> (Vec<Grain>, Vec<PlanarPoint>) {
        let Self { mut grains, left, mut points, freed, made, .. } = self;
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
        (grains, points)
    }
}

/// The set in which a point of the old rim comes to stand for all of its place, if it does.
fn freed(world: &PlanarWorld, fates: &[Fate], point: &PlanarPoint) -> Option<usize> {
    match world.cell_of_point(&point.cold).map(|cell| fates[cell]) {
        Some(Fate::Leaves(set)) if point.hot.weight < 1.0 => Some(set),
        _ => None,
    }
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
fn weight_left(world: &PlanarWorld, fates: &[Fate], settings: &Enrichment, grain: &Grain) -> f64 {
    let weight = grain.hot.weight;
    let fate = world.cell_of_grain(&grain.cold).map_or(Fate::Stays, |cell| fates[cell]);
    match fate {
        _ if grain.cold.mover != Mover::Free => weight,
        Fate::Rim(_) if weight == 1.0 => settings.weight,
        Fate::Leaves(_) => 0.0,
        _ => weight,
    }
}

/// Of all cells of the grid; and how many sets of them leave or become the rim of what stays.
fn fates(grid: &CellGrid, patches: &BTreeMap<u64, Patch>, stays: &[bool]) -> (Vec<Fate>, usize) {
    let has_grains = |cell: usize| patches.contains_key(&(cell as u64));
    // Whole grains that have come into an old rim would fly off with nothing beside them any more, for nodes do not hold them.
    let has_whole = |cell: usize| patches.get(&(cell as u64)).is_some_and(|patch| patch.core > 0.0);
    let leaves = |cell: usize| !stays[cell] && has_grains(cell);
    let is_rim = |cell: usize| stays[cell] && has_whole(cell) && grid.around(cell).any(|(beside, _)| leaves(beside));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole grains that had come into a rim stayed whole as the cell beside it left, and flew off at 1.4 m/s: neither grains nor nodes held them.
    #[test]
    fn whole_grains_of_a_rim_share_their_place_once_there_is_continuum_beside() {
        let grid = CellGrid { counts: [5, 1], cell: 1e-2, lower: [0.0; 2], periodic: false };
        let of = |core: f64| {
            let mut patch = Patch::default();
            (patch.mass, patch.core) = (1.0, core);
            patch
        };
        // Core, a rim with some whole grains, a pure rim, what leaves, and continuum.
        let patches = BTreeMap::from([(0, of(1.0)), (1, of(0.3)), (2, of(0.0)), (3, of(0.0))]);
        let fate = |stays: [bool; 5]| fates(&grid, &patches, &stays);
        assert_eq!(
            fate([true, true, false, false, false]),
            (vec![Fate::Stays, Fate::Rim(0), Fate::Leaves(0), Fate::Leaves(0), Fate::Leaves(0)], 1)
        );
        // Where none is whole nothing changes.
        let (fates, _) = fate([true, true, true, false, false]);
        assert_eq!(fates[..3], [Fate::Stays; 3]);
    }
}
