//! The packing that a zone takes its grains from (Chen et al. 2021, 4.1: the reference packing), as the run's folder keeps it, and how it lies
//! in the specimen.

use std::collections::BTreeMap;
use std::path::Path;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Plane, Space};
use crate::bodies::body::Body;
use crate::couple::kept::KeptGrains;
use crate::dem::cell::{Cell, Image};
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::walls::place_beside;
use crate::domain::transfer;
use crate::prepare::join::{Join, Laid, wrapped};
use crate::prepare::packed::Packing;
use crate::prepare::sheared::{self, Grain, PlanarWorld, on_root, read_state};
use crate::store::tables;

type Vector = <Plane as Space>::Vector;

/// How a packing lies in the specimen.
#[derive(Clone, Copy)]
pub enum Lies<'a> {
    /// It is the specimen.
    Whole,
    /// As wide as the specimen and not as high: about the middle of the zone.
    Around,
    /// Periodic pieces of it side by side, from the lower corner of the domain.
    Tiled(&'a dyn StartState),
    /// It is grains of the run, as they stood when they turned into points.
    Kept(&'a KeptGrains),
}

/// What a job says of where its material begins.
pub trait StartState {
    /// Whether there is material at a place.
    fn is_material(&self, place: &Vector) -> bool;
    /// Mean stress there as a share of the piece's.
    fn stress_share(&self, place: &Vector) -> f64;
}

/// Grains of the packing near a zone, in the order of their ids, on every rank.
pub struct Reference {
    /// Where they lie in the specimen, those of tiles without contacts.
    pub grains: Vec<Grain>,
    /// Where the packing's bodies stood, as displacements, m; none where bodies stand where the job has them.
    pub seats: Vec<Vector>,
    /// Of grains that have been in the run before: where they began, m, and the periods that they had crossed.
    pub began: BTreeMap<GrainId, (Vector, Image)>,
}

impl Reference {
    /// The packing in `file` as it lies. Of tiles only those grains that `is_wanted` asks for by number and place, since all of them may
    /// be too many; `middle` is that of the zone, m. Collective.
    pub fn read(
        world: &PlanarWorld,
        file: &Path,
        (lies, middle): (Lies<'_>, f64),
        is_wanted: impl Fn(GrainId, &Vector) -> bool,
    ) -> Result<Self, Error> {
        let transport = world.transport;
        let memory_words = world.law().memory_words();
        match lies {
            Lies::Whole | Lies::Around => {
                let read = on_root(transport, || {
                    let state = read_state(file)?;
                    let bodies = sheared::bodies_of(&state)?;
                    Ok((sheared::of_state(state, memory_words)?, bodies))
                });
                let ((mut grains, height), bodies) = transfer::agree(transport, read)?.unwrap_or_default();
                if matches!(lies, Lies::Around) {
                    let up = Vector::new(0.0, middle - 0.5 * height);
                    grains.iter_mut().for_each(|grain| lift(grain, up));
                }
                let bodies: Vec<Body<Plane>> = transfer::broadcast(transport, bodies)?;
                let seats = bodies.iter().map(|body| body.displacement).collect();
                Ok(Self { grains: transfer::broadcast(transport, grains)?, seats, began: BTreeMap::new() })
            }
            Lies::Tiled(start) => {
                let read = on_root(transport, || read_piece(file, memory_words));
                let (grains, cells) = transfer::agree(transport, read)?.unwrap_or_default();
                let grains = transfer::broadcast(transport, grains)?;
                let cell = transfer::broadcast(transport, cells)?.remove(0);
                let grains = tiled(world, &Packing { grains, cell }, start, is_wanted);
                Ok(Self { grains, seats: Vec::new(), began: BTreeMap::new() })
            }
            Lies::Kept(kept) => {
                let mut grains = transfer::broadcast(transport, kept.grains.clone())?;
                let began = grains.iter().map(|grain| (grain.cold.id, (grain.cold.origin, grain.cold.image))).collect();
                for grain in &mut grains {
                    sheared::settle(grain);
                    if grain.cold.mover == Mover::Free {
                        grain.hot.weight = 1.0;
                    }
                }
                let seats: Vec<f64> = kept.seats.iter().flat_map(|seat| [seat[0], seat[1]]).collect();
                let seats = transfer::broadcast_numbers(transport, &seats);
                let seats = seats.chunks(Plane::DIMENSION).map(|seat| Vector::new(seat[0], seat[1])).collect();
                Ok(Self { grains, seats, began })
            }
        }
    }
}

fn lift(grain: &mut Grain, up: Vector) {
    for place in [&mut grain.hot.position, &mut grain.cold.origin, &mut grain.cold.home] {
        *place += up;
    }
}

type Piece = (Vec<Grain>, Vec<Cell<Plane>>);

/// What [`crate::prepare::packed::state_of`] wrote: grains, and the cell that they fill from its lower corner.
fn read_piece(file: &Path, memory_words: usize) -> Result<Piece, Error> {
    let mut state = read_state(file)?;
    let cells = tables::rows(&state, "cell", &crate::base::record::Cargo::blank())?;
    match cells.is_empty() {
        true => {
            Err(Error::User(format!("{}: the cell of the packing is missing; the file is damaged", file.display())))
        }
        false => Ok((tables::to_grains(&mut state, memory_words)?, cells)),
    }
}

/// Grains of all pieces that a domain holds which are wanted and touch no body, joined across its periods. Contacts of a piece are with
/// grains of the same piece that may lie across its border, so none is kept; a compression without friction leaves next to nothing along
/// them.
fn tiled(
    world: &PlanarWorld,
    piece: &Packing<Plane>,
    start: &dyn StartState,
    is_wanted: impl Fn(GrainId, &Vector) -> bool,
) -> Vec<Grain> {
    let layout = &world.subdomain.layout;
    let cell = &world.assembly.cell;
    let edges = [piece.cell.edges[0], piece.cell.edges[3]];
    let bodies: Vec<_> =
        world.bodies.iter().map(|body| Body { displacement: Vector::zero(), ..body.clone() }).collect();
    let is_free = |place: &Vector, radius: f64| {
        let mut near = bodies.iter().filter_map(|body| body.nearest(&place_beside(body, cell, place)));
        near.all(|near| near.distance >= radius)
    };
    let is_material = |place: &Vector| start.is_material(place);
    let join = cell.periodic.contains(&true).then(|| Join::of((cell, &bodies), &is_material, piece));
    let (mut first, mut copies) = (layout.corner, [1; 3]);
    for axis in 0..2 {
        copies[axis] = (layout.cells[axis] as f64 * layout.cell / edges[axis]).ceil() as u64;
        if let Some(join) = join.as_ref().filter(|_| cell.periodic[axis]) {
            (first[axis], copies[axis]) = join.pieces(axis, edges[axis]);
        }
    }
    let all = piece.side_by_side(first, copies);
    let all = all.map(|(id, place, grain)| Laid { id, place, radius: grain.hot.radius, mass: grain.hot.mass });
    let is_inside = |laid: &Laid<Plane>| is_material(&wrapped(cell, &laid.place));
    let is_free = |laid: &Laid<Plane>| is_free(&wrapped(cell, &laid.place), laid.radius);
    let is_wanted = |laid: &Laid<Plane>| is_wanted(laid.id, &laid.place);
    let taken: Vec<Laid<Plane>> = match &join {
        Some(join) => {
            // Those at a boundary are joined, whoever is wanted, so that they stand at the same places for every zone.
            let is_looked_at = |laid: &Laid<Plane>| join.is_at_boundary(&laid.place) || is_wanted(laid);
            let near = all.filter(|laid| join.is_near(&laid.place) && is_inside(laid));
            let joined = join.joined(near.filter(|laid| is_looked_at(laid) && is_free(laid)).collect());
            joined.into_iter().filter(is_wanted).collect()
        }
        None => all.filter(|laid| is_inside(laid) && is_wanted(laid) && is_free(laid)).collect(),
    };
    let resting = |laid: &Laid<Plane>| GrainRow::resting(laid.id, laid.place, laid.radius, laid.mass, Mover::Free);
    taken.iter().map(resting).collect()
}
