//! Grains that stand before a zone begins or grows: those of the zone, and those that are glued to plates, whose place follows from these.

use scree_partition::{ParcelError, Reader, Writer};

use super::Vector;
use super::choose::Chosen;
use super::motion::{Motion, displacement};
use crate::base::error::Error;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Plane};
use crate::bodies::body::Body;
use crate::dem::cell::Cell;
use crate::dem::grains::{Cold, Hot, Mover};
use crate::domain::transfer;
use crate::prepare::reference::Reference;
use crate::prepare::sheared::{Grain, PlanarWorld};

/// Where a grain of the packing has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resident {
    id: u64,
    /// Place in the packing, m.
    pub origin: Vector,
    /// Way from there, across periods, m.
    pub displacement: Vector,
    /// Of the packing's places that whose way it went, m: its own, or that of a plate's face below or above it.
    pub led_from: Vector,
}

impl Resident {
    /// A grain that goes the way of the continuum from its `origin` and comes to stand nowhere.
    pub fn led(id: u64, origin: Vector, displacement: Vector) -> Self {
        Self { id, origin, displacement, led_from: origin }
    }

    /// A grain that has gone all of the way of the plate that it is glued to.
    pub fn glued(id: u64, origin: Vector, plate: &Body<Plane>) -> Self {
        let mut led_from = origin;
        led_from[1] = plate.face() - plate.displacement[1];
        Self { id, origin, displacement: plate.displacement, led_from }
    }
}

impl Record for Resident {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("id", &mut self.id);
        visitor.f64s("origin", self.origin.as_mut_slice());
        visitor.f64s("displacement", self.displacement.as_mut_slice());
        visitor.f64s("led_from", self.led_from.as_mut_slice());
    }
}

impl Cargo for Resident {
    fn blank() -> Self {
        let [origin, displacement, led_from] = [Vector::zero(); 3];
        Self { id: 0, origin, displacement, led_from }
    }
    fn pack_rest(&mut self, _: &mut Writer) {}
    fn unpack_rest(&mut self, _: &mut Reader) -> Result<(), ParcelError> {
        Ok(())
    }
}

/// All grains of the run, in the order of their ids; the same on every rank.
pub(super) struct Residents(Vec<Resident>);

impl Residents {
    /// Collective.
    pub fn of(world: &PlanarWorld) -> Result<Self, Error> {
        let rows = world.assembly.grains.hot[..world.assembly.grains.owned].iter().zip(&world.assembly.grains.cold);
        let resident = |(hot, cold): (&Hot<Plane>, &Cold<Plane>)| match cold.mover {
            Mover::Body(plate) => Resident::glued(cold.id.0, cold.origin, &world.bodies[usize::from(plate)]),
            Mover::Free | Mover::Script => Resident {
                id: cold.id.0,
                origin: cold.origin,
                displacement: displacement(&hot.position, (&cold.origin, cold.image), &world.assembly.cell),
                led_from: cold.origin,
            },
        };
        let all = transfer::gather_everywhere(world.transport, rows.map(resident).collect())?;
        let mut residents = Self(Vec::new());
        residents.extend(all);
        Ok(residents)
    }

    /// With those whose places are known before training: the `chosen` ones of plates, and around grains that come back those that stay points and go their way. Who is led by the continuum
    /// beside those that stand, by ids, rising: the rim, or around grains that come back, which are free, those that stay points.
    pub fn with_those_of(
        &mut self,
        chosen: &Chosen,
        world: &PlanarWorld,
        (motion, is_kept): (&Motion, bool),
    ) -> Vec<u64> {
        let stand = |grain: &Grain| match grain.cold.mover {
            Mover::Body(plate) => {
                Some(Resident::glued(grain.cold.id.0, grain.cold.origin, &world.bodies[usize::from(plate)]))
            }
            Mover::Free | Mover::Script => None,
        };
        self.extend(chosen.glued.iter().filter_map(stand));
        let last = motion.times.len() - 1;
        let lead = |grain: &Grain| {
            let origin = grain.cold.origin;
            Resident::led(grain.cold.id.0, origin, motion.displacement(last, &origin))
        };
        self.extend(chosen.around.iter().map(lead));
        if !is_kept {
            return chosen.rim.clone();
        }
        let mut around: Vec<u64> = chosen.around.iter().map(|grain| grain.cold.id.0).collect();
        around.sort_unstable();
        around
    }

    pub fn extend(&mut self, more: impl IntoIterator<Item = Resident>) {
        self.0.extend(more);
        self.0.sort_unstable_by_key(|resident| resident.id);
    }

    /// From here on their ways are counted from where they were kept, as those of the grains that come.
    pub fn since_kept(&mut self, reference: &Reference, cell: &Cell<Plane>) {
        for resident in &mut self.0 {
            let at = reference.grains.binary_search_by_key(&resident.id, |grain| grain.cold.id.0);
            let Some(kept) = at.ok().map(|at| &reference.grains[at]) else { continue };
            let moved = match kept.cold.mover {
                Mover::Body(body) => reference.seats[usize::from(body)],
                Mover::Free | Mover::Script => {
                    let (origin, image) = reference.began[&kept.cold.id];
                    displacement(&kept.hot.position, (&origin, image), cell)
                }
            };
            resident.origin = kept.hot.position;
            resident.displacement -= moved;
            resident.led_from += moved;
        }
    }

    pub fn get(&self, id: u64) -> Option<&Resident> {
        self.0.binary_search_by_key(&id, |resident| resident.id).ok().map(|at| &self.0[at])
    }

    pub fn iter(&self) -> impl Iterator<Item = &Resident> {
        self.0.iter()
    }
}
