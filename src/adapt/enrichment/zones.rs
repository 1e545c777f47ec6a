//! Where grains are to come: around a band that the oracle has found, or around cells that shear.

use std::collections::BTreeMap;

use super::cell_grid;
use super::leaving::CELLS_WIDE;
use crate::adapt::flow::Flow;
use crate::base::space::Plane;
use crate::bodies::body::{Body, Shape, Side};
use crate::couple::zone::{CellGrid, Enrichment, Label, Zone};
use crate::prepare::sheared::PlanarWorld;

/// Cells beyond phi_0 and its rim in which grains stay all the same.
const CELLS_BEYOND: f64 = 1.0;

/// How far from cells that shear grains stay, m.
pub(super) fn reach(settings: &Enrichment, cell: f64) -> f64 {
    settings.distance + (0.5 + CELLS_BEYOND) * cell
}

/// Where grains are to come, and the plates that this meets, by their numbers.
pub struct Wanted {
    pub(super) zone: Zone,
    pub(super) plates: Vec<usize>,
}

/// A zone around the flagged nodes. One that comes to a plate meets it along all of it.
pub fn around_band(world: &PlanarWorld, flagged: &[u64], settings: &Enrichment) -> Wanted {
    let mut zone = Zone::around(&along_plates(world, flagged, settings), cell_grid(world), settings);
    let mut meets = |body: &Body<Plane>| match body.shape {
        Shape::Plate { side, .. } => zone.close_at(body.face(), side == Side::Above),
        _ => false,
    };
    let plates = (0..world.bodies.len()).filter(|number| meets(&world.bodies[*number])).collect();
    Wanted { zone, plates }
}

/// The flagged nodes, and all beside those whose zone comes to a plate.
fn along_plates(world: &PlanarWorld, flagged: &[u64], settings: &Enrichment) -> Vec<u64> {
    let grid = cell_grid(world);
    let reach = settings.distance + 1.5 * grid.cell;
    let is_plate = |body: &&Body<Plane>| matches!(body.shape, Shape::Plate { .. });
    let faces: Vec<f64> = world.bodies.iter().filter(is_plate).map(Body::face).collect();
    grid.with_rows(flagged, |height| faces.iter().any(|face| (height - face).abs() <= reach))
}

/// Where grains are to come back: to cells within phi_0 and half a cell of those that shear, `busy`, that are not of grains alone, and from there as far as grains would stay; and to continuum that
/// this would leave narrower than a dissolution does. One for each set of cells that hang together; none where all is of grains.
pub fn around_shear(grid: CellGrid, flows: &BTreeMap<u64, Flow>, busy: &[u64], settings: &Enrichment) -> Vec<Wanted> {
    let mut wanted = grid.near(busy, reach(settings, grid.cell));
    let mut filled = vec![false; wanted.len()];
    let mut core = filled.clone();
    for (cell, flow) in flows {
        let cell = *cell as usize;
        (filled[cell], core[cell]) = (true, flow.is_core());
        wanted[cell] |= flow.is_inside();
    }
    let left: Vec<bool> = wanted.iter().zip(&filled).map(|(wanted, filled)| *filled && !wanted).collect();
    let wide = grid.wide(&left, CELLS_WIDE);
    // All of it stays where none is wide: without a rim nothing would carry what grains and points differ by.
    if wide.contains(&true) {
        (0..left.len()).filter(|cell| left[*cell] && !wide[*cell]).for_each(|cell| wanted[cell] = true);
    }
    let zone = Zone::of_cells(grid, &wanted, &filled, &core);
    let near = grid.near(busy, settings.distance + 0.5 * grid.cell);
    let comes = |cell: &usize| filled[*cell] && !core[*cell] && zone.labels[*cell] == Label::Grains;
    let sets = grid.sets(&(0..filled.len()).filter(comes).collect::<Vec<usize>>());
    let asked = sets.into_iter().filter(|set| set.iter().any(|cell| near[*cell]));
    asked.map(|set| Wanted { zone: zone.near_cells(&set), plates: Vec::new() }).collect()
}
