//! Packings of grains in a cell: inserted loosely, compressed or poured, and kept in a file named by everything that shaped
//! them.

use std::time::Duration;

use scree_io::column::State;
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::record::{Cargo, to_table};
use crate::base::space::{Linear, Space};
use crate::bodies::body;
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::law::memory_words;
use crate::dem::tile::tile;
use crate::dem::walls;
use crate::domain::transfer;
use crate::job::assembly::{Assembly, Packed, Preparation};
use crate::job::figures;
use crate::job::raw::Typed;
use crate::law::contact::Contact;
use crate::prepare::cache::{Found, Place};
use crate::prepare::grain_world::{self, GrainWorld};
use crate::prepare::insert::{places, radii};
use crate::prepare::recipe;
use crate::prepare::sheared::settle;
use crate::store::tables;

mod compress;
mod pour;
#[cfg(test)]
mod tests;

/// Grains of a finished packing, at rest, and the cell that holds them.
pub struct Packing<S: Space> {
    /// On rank 0 only, in the order of their ids; contacts with their memories.
    pub grains: Vec<GrainRow<S>>,
    /// On every rank; its lower corner is that of the job.
    pub cell: Cell<S>,
}

impl<S: Space> Packing<S> {
    /// The copies that a job has side by side, and the cell that holds them.
    pub fn repeated(self, job: &Assembly) -> (Vec<GrainRow<S>>, Cell<S>) {
        let Self { grains, mut cell } = self;
        let Some(copies) = job.cell.copies else { return (grains, cell) };
        let one = cell.edges;
        let mut edges = one;
        for axis in 0..S::DIMENSION {
            let room = figures::room(job, axis);
            (0..S::DIMENSION).for_each(|row| edges[axis * S::DIMENSION + row] *= copies[axis] as f64);
            edges[axis * S::DIMENSION + axis] += 2.0 * room;
            cell.corner[axis] -= room;
        }
        cell.periodic = job.cell.periodic;
        cell.arrive(edges);
        (tile(grains, &one, copies.map(|count| count as usize), cell.periodic), cell)
    }

    /// Grains of copies side by side, so many along each axis from `lower` on, m: id, place, and the grain that each is a copy of.
    pub fn side_by_side(
        &self,
        lower: [f64; 3],
        copies: [u64; 3],
    ) -> impl Iterator<Item = (GrainId, S::Vector, &GrainRow<S>)> {
        (0..copies.iter().product::<u64>()).flat_map(move |copy| {
            let number = [copy % copies[0], copy / copies[0] % copies[1], copy / (copies[0] * copies[1])];
            let mut corner = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                let edge = self.cell.edges[axis * S::DIMENSION + axis];
                corner[axis] = lower[axis] + number[axis] as f64 * edge - self.cell.corner[axis];
            }
            let first = copy * self.grains.len() as u64;
            let place = move |(row, grain): (usize, _)| -> (GrainId, S::Vector, &GrainRow<S>) {
                let grain: &GrainRow<S> = grain;
                (GrainId(first + row as u64), grain.hot.position + corner, grain)
            };
            self.grains.iter().enumerate().map(place)
        })
    }
}

/// The packing that a job wants: from the cache, or made now and cached, with its state saved every so often. Collective.
pub fn make<S: Space>(
    job: &Assembly,
    packed: &Packed,
    save_every: Duration,
    transport: &dyn Transport,
) -> Result<Packing<S>, Error> {
    let place = Place::new(&packed.cache, "assembly", &recipe::packed(job, packed));
    match place.find(transport, save_every, |state| of_state::<S>(job, state))? {
        Found::There(found) => {
            let (grains, cell) = found.map_or((Vec::new(), Vec::new()), |found| (found.grains, vec![found.cell]));
            Ok(Packing { grains, cell: same_cell(job, cell, transport)? })
        }
        Found::ToMake(mut making) => {
            tracing::info!(grains = packed.count, "making a packing");
            let mut packing = match packed.preparation {
                Preparation::Compress { stress, fraction, unloaded } => {
                    compress::make(job, packed, (stress, fraction, unloaded), &mut making)?
                }
                Preparation::Pour => pour::make(job, packed, &mut making)?,
            };
            making.finish(|| state_of(&mut packing, &job.contact))?;
            Ok(packing)
        }
    }
}

/// Refuses what no packing can be made of, before anything is started.
pub(crate) fn refuse_bad<S: Space>(job: &Assembly, packed: &Packed, typed: &Typed) -> Result<(), Error> {
    match packed.preparation {
        Preparation::Compress { .. } => compress::refuse_bad::<S>(job, packed, typed),
        Preparation::Pour => Ok(()),
    }
}

/// A packing under a contact law as a state: grains, and the cell that they fill.
pub fn state_of<S: Space>(packing: &mut Packing<S>, contact: &Contact) -> State {
    let mut tables = Vec::from(tables::of_grains(&mut packing.grains, memory_words::<S>(contact)));
    tables.push(to_table("cell", &mut [packing.cell], &mut Cell::blank()));
    State { attributes: Default::default(), tables }
}

fn of_state<S: Space>(job: &Assembly, mut state: State) -> Result<Packing<S>, Error> {
    let mut cell = grain_world::cell_of(job);
    let moved: Vec<Cell<S>> = tables::rows(&state, "cell", &cell)?;
    moved.iter().for_each(|moved| cell.take_motion_of(moved));
    Ok(Packing { grains: tables::to_grains(&mut state, memory_words::<S>(&job.contact))?, cell })
}

/// The cell that rank 0 holds, at rest, on every rank.
pub(super) fn same_cell<S: Space>(
    job: &Assembly,
    cell: Vec<Cell<S>>,
    transport: &dyn Transport,
) -> Result<Cell<S>, Error> {
    let shared = transfer::broadcast(transport, cell)?;
    let mut cell = grain_world::cell_of(job);
    shared.iter().for_each(|shared| cell.take_motion_of(shared));
    Ok(cell)
}

/// Grains at rest at random places of a box, on rank 0 only.
fn inserted<S: Space>(
    job: &Assembly,
    packed: &Packed,
    cell: &Cell<S>,
    bodies: &[body::Body<S>],
) -> Result<Vec<GrainRow<S>>, Error> {
    let radii = radii(&packed.sizes, job.seed, packed.count);
    let outside = |place: &S::Vector, radius: f64| {
        bodies.iter().filter_map(|body| walls::nearest(body, cell, place)).all(|nearest| nearest.distance >= radius)
    };
    let places = places(cell, &packed.sizes, job.seed, &radii, outside).map_err(|full| {
        Error::User(format!(
            "packing.fraction_start = {} is too dense to insert {} grains without overlap: there was no room for grain {}. Discs need 0.45 or less, spheres 0.25, and less where bodies take up room; or take a larger cell.",
            packed.fraction_start, packed.count, full.grain
        ))
    })?;
    let grain = |(id, (place, radius)): (usize, (&S::Vector, &f64))| {
        let mass = job.matter.density * S::grain_volume(*radius, job.cell.depth);
        GrainRow::resting(GrainId(id as u64), *place, *radius, mass, Mover::Free)
    };
    Ok(places.iter().zip(&radii).enumerate().map(grain).collect())
}

/// All grains of a world at rest, on rank 0 in the order of their ids.
fn gathered<S: Space>(world: &mut GrainWorld<S>) -> Result<Vec<GrainRow<S>>, Error> {
    world.rebuild()?;
    let (rows, _) = world.rows();
    let mut rows = transfer::gather(world.transport, rows)?.unwrap_or_default();
    rows.sort_unstable_by_key(|row| row.cold.id);
    rows.iter_mut().for_each(settle);
    Ok(rows)
}
