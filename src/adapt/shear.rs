//! Where it shears: by it cells rest or not, and a hybrid tells how much of its shear goes on inside zones. Grains that stand still while the continuum shears
//! around them bear nothing of the band, whatever their stress is.

use std::collections::BTreeMap;

use super::cells::around;
use super::enrichment::cell_grid;
use super::flow::{Flow, flows};
use crate::base::error::Error;
use crate::base::space::Space;
use crate::couple::patch::Patch;
use crate::couple::rest::{Look, RestWatch};
use crate::domain::world::World;

/// Rate of shear (the difference of the principal rates of strain) at the instant, summed by mass: the share of it that is inside zones. In each cell it is that of the
/// linear velocity which fits best what moves in the cell and around it. Of the plane alone; 0 where nothing shears. Collective.
pub fn share_inside_zones<S: Space>(world: &World<S>) -> Result<f64, Error> {
    let (grid, flows) = (cell_grid(world), flows(world)?);
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

/// A cell must hold this share of what others hold to tell how it shears. A few grains that have strayed from the rim of a zone into the continuum, or from a heap, move as they
/// like: by them all others would seem to rest.
const FILLED_TELLING: f64 = 0.5;

/// Takes in how all cells have sheared for `time`, s, until now, and tells what moves in them: grains by their velocities, points by how they flow, for velocities of points are of
/// an instant in which continuum rings. Collective.
pub fn look_for_rest<S: Space>(
    world: &World<S>,
    watch: &mut RestWatch,
    time: f64,
) -> Result<BTreeMap<u64, Flow>, Error> {
    let (grid, flows) = (cell_grid(world), flows(world)?);
    // What a cell holds that the mean grain or point is in.
    let masses = || flows.values().map(|flow| flow.patch.mass);
    let least = FILLED_TELLING * masses().map(|mass| mass * mass).sum::<f64>() / masses().sum::<f64>();
    // Of the cell alone: with those around it every band would be wider by two cells.
    let rate = |patch: &Patch| {
        let rate = patch.velocity(grid.cell).gradient;
        [rate[(0, 0)], rate[(1, 1)], 0.5 * (rate[(0, 1)] + rate[(1, 0)])]
    };
    let look = |(cell, flow): (&u64, &Flow)| {
        let tells = flow.grains.mass >= least && flow.grains.is_spread(grid.cell);
        Look { cell: *cell, rate: tells.then(|| rate(&flow.grains)), plastic: flow.plastic(least) }
    };
    watch.take(&flows.iter().map(look).collect::<Vec<Look>>(), time);
    Ok(flows)
}

/// Of all shear since a watch began, the share that was where zones are now.
pub fn watched_inside_zones(watch: &RestWatch, flows: &BTreeMap<u64, Flow>) -> f64 {
    let [mut inside, mut all] = [0.0; 2];
    for cell in &watch.cells {
        let Some(flow) = flows.get(&cell.cell) else { continue };
        inside += cell.shear() * flow.inside;
        all += cell.shear() * flow.patch.mass;
    }
    if all > 0.0 { inside / all } else { 0.0 }
}
