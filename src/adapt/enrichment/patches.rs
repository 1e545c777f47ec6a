//! What the grains of each cell are together, as sums that ranks share.

use std::collections::BTreeMap;

use super::cell_grid;
use super::motion::displacement;
use crate::adapt::cells::everywhere;
use crate::base::error::Error;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::patch::Patch;
use crate::couple::rest::{Look, RestWatch};
use crate::dem::grains::Mover;
use crate::prepare::sheared::PlanarWorld;

type Tensor = <Plane as Space>::Tensor;

/// Of what they would grains must fill this share of a cell to tell how it shears. A few that have strayed from the rim of a zone into the continuum move as they like:
/// by them all others would seem to rest.
const FILLED_TELLING: f64 = 0.5;

/// Takes in how the grains have moved for `time`, s, until now; `fraction` is their solid volume fraction at the start. Collective.
pub fn look_for_rest(
    world: &mut PlanarWorld,
    watch: &mut RestWatch,
    (depth, fraction, time): (f64, f64, f64),
) -> Result<(), Error> {
    let (grid, mut patches) = (cell_grid(world), patches(world, depth, false)?);
    let cells: Vec<u64> = patches.keys().copied().collect();
    let least = FILLED_TELLING * fraction * grid.cell * grid.cell * depth;
    patches.retain(|_, patch| patch.solid >= least);
    // Of the cell alone: with those around it every band would be wider by two cells.
    let rate = |patch: &Patch| {
        let rate = patch.velocity(grid.cell).gradient;
        [rate[(0, 0)], rate[(1, 1)], 0.5 * (rate[(0, 1)] + rate[(1, 0)])]
    };
    let look = |cell: u64| Look { cell, rate: patches.get(&cell).map(rate) };
    let looks: Vec<Look> = cells.into_iter().map(look).collect();
    watch.take(&looks, time);
    Ok(())
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
