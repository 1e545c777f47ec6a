//! Grains that stand in a zone before it grows.

use scree_partition::{ParcelError, Reader, Writer};

use super::Vector;
use super::motion::displacement;
use crate::base::error::Error;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Plane};
use crate::dem::grains::{Cold, Hot, Mover};
use crate::domain::transfer;
use crate::prepare::sheared::PlanarWorld;

/// Where a grain of the packing has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resident {
    id: u64,
    /// Place in the packing, m.
    pub origin: Vector,
    /// Way from there, across periods, m.
    pub displacement: Vector,
}

impl Record for Resident {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("id", &mut self.id);
        visitor.f64s("origin", self.origin.as_mut_slice());
        visitor.f64s("displacement", self.displacement.as_mut_slice());
    }
}

impl Cargo for Resident {
    fn blank() -> Self {
        Self { id: 0, origin: Vector::zero(), displacement: Vector::zero() }
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
        let free = rows.filter(|(_, cold)| cold.mover == Mover::Free);
        let resident = |(hot, cold): (&Hot<Plane>, &Cold<Plane>)| Resident {
            id: cold.id.0,
            origin: cold.origin,
            displacement: displacement(&hot.position, (&cold.origin, cold.image), &world.assembly.cell),
        };
        let mut all = transfer::gather_everywhere(world.transport, free.map(resident).collect())?;
        all.sort_unstable_by_key(|resident: &Resident| resident.id);
        Ok(Self(all))
    }

    pub fn get(&self, id: u64) -> Option<&Resident> {
        self.0.binary_search_by_key(&id, |resident| resident.id).ok().map(|at| &self.0[at])
    }

    pub fn iter(&self) -> impl Iterator<Item = &Resident> {
        self.0.iter()
    }
}
