//! What the grains of each cell are together, as sums that ranks share.

use std::collections::BTreeMap;

use super::cell_grid;
use super::motion::displacement;
use crate::adapt::cells::{around, everywhere};
use crate::base::error::Error;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::patch::Patch;
use crate::dem::grains::Mover;
use crate::mpm::stress::SharedMaterial;
use crate::prepare::sheared::PlanarWorld;

type Tensor = <Plane as Space>::Tensor;

/// Of what they would grains must fill this share of a cell for it to be full and have all of its points.
const FILLED_CELL: f64 = 0.85;

/// What there is in a full cell: its room, m3, and the solid volume fraction at the start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Full {
    pub room: f64,
    pub fraction: f64,
}

/// Of full cells outside the rim, which bears what its points bear already: the share of the strength of the law at their mean stress and solid volume fraction that they bear. Kirchhoff's stress is
/// of the room that grains had at the start. None of a patch without.
pub(super) fn mobilised(patch: &Patch, law: &SharedMaterial<Plane>, fraction: f64) -> Option<f64> {
    let is_told = patch.solid_core > 0.0 && patch.room_full > 0.0;
    is_told.then(|| law.mobilised(&(patch.moment * (fraction / patch.solid_core)), patch.solid_full / patch.room_full))
}

/// What grains bear of the strength of the law, each cell with those around it; cells without full ones of grains alone are left out. Collective.
pub fn strength_mobilised(world: &mut PlanarWorld, depth: f64, fraction: f64) -> Result<BTreeMap<u64, f64>, Error> {
    let grid = cell_grid(world);
    let full = Full { room: grid.cell * grid.cell * depth, fraction };
    let mut patches = with_full(patches(world, depth, true)?, full);
    patches.retain(|_, patch| patch.room_full > 0.0 && patch.is_core());
    let law = &world.settings.material;
    let of = |cell: &u64| Some((*cell, mobilised(&around(&grid, &patches, *cell), law, fraction)?));
    Ok(patches.keys().filter_map(of).collect())
}

/// Patches with the room of those whose cells are full, and the grains in it.
pub(super) fn with_full(mut patches: BTreeMap<u64, Patch>, full: Full) -> BTreeMap<u64, Patch> {
    for patch in patches.values_mut().filter(|patch| patch.solid >= FILLED_CELL * full.fraction * full.room) {
        (patch.room_full, patch.solid_full) = (full.room, patch.solid);
    }
    patches
}

/// Sums of all cells that hold grains, each about its own centre, on every rank; with the stress of their contacts if that is wanted. A
/// cell belongs to one rank, which adds its grains up in the order of its rows. Collective.
pub(super) fn patches(world: &mut PlanarWorld, depth: f64, with_contacts: bool) -> Result<BTreeMap<u64, Patch>, Error> {
    let grid = cell_grid(world);
    let moments = if with_contacts { moments(world) } else { Vec::new() };
    let mut mine: BTreeMap<u64, Patch> = BTreeMap::new();
    let rows =
        world.assembly.grains.hot[..world.assembly.grains.owned].iter().zip(&world.assembly.grains.cold).enumerate();
    for (row, (hot, cold)) in rows.filter(|(_, (_, cold))| cold.mover == Mover::Free) {
        let Some(cell) = world.cell_of_grain(cold) else { continue };
        let patch = mine.entry(cell as u64).or_default();
        let displacement = displacement(&hot.position, (&cold.origin, cold.image), &world.assembly.cell);
        let solid = Plane::grain_volume(hot.radius, depth);
        patch.add_grain((hot.mass, solid), &(hot.position - grid.centre(cell)), &hot.velocity, &displacement);
        if hot.weight == 1.0 {
            patch.core += hot.mass;
            patch.solid_core += solid;
            patch.moment += moments.get(row).copied().unwrap_or_else(Tensor::zero);
        }
    }
    everywhere(world.transport, &mine)
}

/// Love-Weber sums of all owned grains, J. Collective.
fn moments(world: &mut PlanarWorld) -> Vec<Tensor> {
    world.refresh_ghosts();
    let (law, grains) = (world.law(), &world.assembly.grains);
    let mut moments = vec![Tensor::zero(); grains.owned];
    let on_bodies = world.assembly.walls.bearings(law, grains, (&world.bodies, &world.assembly.cell), [0.0; 2]);
    let on_grains = (0..grains.owned).flat_map(|row| world.assembly.contacts.bearings(law, grains, row, [0.0; 2]));
    for bearing in on_bodies.chain(on_grains) {
        moments[bearing.row as usize] += bearing.moment();
    }
    moments
}
