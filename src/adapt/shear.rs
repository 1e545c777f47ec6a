//! What share of all shear goes on inside zones: what a hybrid tells about itself. Grains that stand still while the continuum shears
//! around them bear nothing of the band, whatever their stress is.

use std::collections::BTreeMap;

use super::cells::{around, everywhere};
use super::enrichment::cell_grid;
use crate::base::error::Error;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::patch::Patch;
use crate::dem::grains::Mover;
use crate::domain::world::World;
use crate::numbers;

type Vector = <Plane as Space>::Vector;

/// What moves in a cell, grains and points alike, by their weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
struct Flow {
    patch: Patch,
    /// Mass of its grains and of points that share their place with some, kg.
    inside: f64,
}

numbers!(impl[] Flow[] { patch: Patch, inside: f64 });

/// Rate of shear (the difference of the principal rates of strain) at the instant, summed by mass: the share of it that is inside zones. In each cell it is that of the
/// linear velocity which fits best what moves in the cell and around it. Of the plane alone; 0 where nothing shears. Collective.
pub fn share_inside_zones<S: Space>(world: &World<S>) -> Result<f64, Error> {
    let (grid, flows) = (cell_grid(world), gathered(world)?);
    let patches: BTreeMap<u64, Patch> = flows.iter().map(|(cell, flow)| (*cell, flow.patch)).collect();
    let [mut inside, mut all] = [0.0; 2];
    for (cell, flow) in &flows {
        let rate = around(&grid, &patches, *cell).velocity(grid.cell).gradient;
        let (stretch, shear) = (rate[(0, 0)] - rate[(1, 1)], rate[(0, 1)] + rate[(1, 0)]);
        let shear = (stretch * stretch + shear * shear).sqrt();
        inside += shear * flow.inside;
        all += shear * flow.patch.mass;
    }
    Ok(if all > 0.0 { inside / all } else { 0.0 })
}

/// Those of all cells, each about its own centre, on every rank; added up in the order of rows. Collective.
fn gathered<S: Space>(world: &World<S>) -> Result<BTreeMap<u64, Flow>, Error> {
    let grid = cell_grid(world);
    let mut mine: BTreeMap<u64, Flow> = BTreeMap::new();
    let mut add = |cell: Option<usize>, (mass, is_inside): (f64, bool), place: &S::Vector, velocity: &S::Vector| {
        let Some(cell) = cell else { return };
        let [place, velocity] = [place, velocity].map(|vector| Vector::new(vector[0], vector[1]));
        let flow = mine.entry(cell as u64).or_default();
        flow.patch.add_grain((mass, 0.0), &(place - grid.centre(cell)), &velocity, &Vector::zero());
        flow.inside += if is_inside { mass } else { 0.0 };
    };
    let grains = &world.assembly.grains;
    for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold).filter(|(_, cold)| cold.mover == Mover::Free)
    {
        add(world.cell_of_grain(cold), (hot.weight * hot.mass, true), &hot.position, &hot.velocity);
    }
    for (hot, cold) in world.continuum.points.hot.iter().zip(&world.continuum.points.cold) {
        let mass = (hot.weight * hot.mass, hot.weight < 1.0);
        add(world.cell_of_point(cold), mass, &hot.position, &hot.velocity);
    }
    everywhere(world.transport, &mine)
}
