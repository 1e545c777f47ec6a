//! Watching for a shear band: the world's side of Chen et al. (2021), section 3.

use std::mem;

use scree_io::column::{Column, Values};
use scree_partition::{Reader, Writer};

use crate::adapt::enrichment::cell_grid;
use crate::base::error::Error;
use crate::base::space::Space;
use crate::couple::oracle::{Concentration, Criterion, Laplacian, Memory, NodeFields, Oracle};
use crate::dem::grains::Mover;
use crate::dem::walls::place_beside;
use crate::domain::means::nodal_sums;
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::job::mpm::Boundary;
use crate::mpm::points::{Hot, Past};

/// One look of the oracle: true when a band has been found.
///
/// Of the plane alone.
pub fn watch<S: Space>(
    world: &mut World<S>,
    memory: &mut Memory,
    settings: &Oracle,
    diameter: f64,
) -> Result<bool, Error> {
    let timer = world.phases.start();
    let last = memory.slot_last();
    let law = world.settings.material.clone();
    let since = |hot: &Hot<S>, past: &Past<S>, slot: Option<usize>| {
        law.plastic_strain(&hot.memory) - slot.map_or(0.0, |slot| past.window.samples[slot])
    };
    world.continuum.points.keep_pasts();
    let rows = world.continuum.points.hot.iter().zip(&world.continuum.points.pasts);
    let mut most = [rows.map(|(hot, past)| since(hot, past, last)).fold(0.0, f64::max)];
    world.transport.max(&mut most);
    let [fastest] = most;
    if !memory.due(fastest, settings) {
        return Ok(false);
    }
    let found = match &settings.criterion {
        Criterion::Laplacian(by) => {
            look_for_bends(world, memory, &Sight { settings, by, since: &since, fastest, diameter })?
        }
        Criterion::Concentration(by) => {
            look_for_concentration(world, memory, &Sight { settings, by, since: &since, fastest, diameter })?
        }
    };
    let slot = memory.slot_last().expect("a look has just been taken");
    for (hot, past) in world.continuum.points.hot.iter().zip(&mut world.continuum.points.pasts) {
        past.window.samples[slot] = law.plastic_strain(&hot.memory);
    }
    world.phases.stop(Phase::Oracle, timer);
    Ok(found)
}

/// Plastic strain of a point since the look of a slot, or since the start.
type Since<'a, S> = &'a (dyn Fn(&Hot<S>, &Past<S>, Option<usize>) -> f64 + Sync);

/// What a look by a criterion goes by.
struct Sight<'a, S: Space, C> {
    settings: &'a Oracle,
    by: &'a C,
    since: Since<'a, S>,
    /// The largest since the last look.
    fastest: f64,
    /// D50, m.
    diameter: f64,
}

/// Algorithm 1 of Chen et al. (2021).
fn look_for_bends<S: Space>(
    world: &mut World<S>,
    memory: &mut Memory,
    &Sight { settings, by, since, fastest, diameter }: &Sight<'_, S, Laplacian>,
) -> Result<bool, Error> {
    let last = memory.slot_last();
    let (_, Some(begin)) = memory.look(fastest, settings) else { return Ok(false) };
    let gains = |hot: &Hot<S>, past: &Past<S>| [since(hot, past, last), since(hot, past, Some(begin))];
    let fields = node_fields(world, is_free, gains)?;
    let flagged = fields.flagged(by, world.subdomain.layout.cell, diameter);
    Ok(memory.persists(beyond_grains(world, flagged)?, by))
}

/// How shear concentrates in boxes. Nodes beside what holds material count as well: no bend of the rate there is taken for a band.
fn look_for_concentration<S: Space>(
    world: &mut World<S>,
    memory: &mut Memory,
    &Sight { settings, by, since, fastest, diameter }: &Sight<'_, S, Concentration>,
) -> Result<bool, Error> {
    // Nodes from the middle of a box to its sides.
    let reach = (by.reach * diameter / world.subdomain.layout.cell).round().max(2.0) as usize;
    let (last, everywhere) = (memory.slot_last(), |_: &World<S>, _: [i32; 3]| true);
    let gained = node_fields(world, everywhere, |hot, past| [since(hot, past, last), 0.0])?;
    let increment = gained.fastest_box(&gained.rate, reach);
    let (slot, begin) = memory.look(increment, settings);
    memory.see(slot, last, [increment, fastest, world.time()]);
    let Some(begin) = begin else { return Ok(false) };
    let fields = node_fields(world, everywhere, |hot, past| [since(hot, past, None), since(hot, past, Some(begin))])?;
    let (flagged, participation) = fields.concentrated(by, reach, memory.growth_least(slot, begin));
    memory.seen[slot].participation = participation;
    Ok(memory.sharpens(beyond_grains(world, flagged)?, begin, by))
}

/// Those of the nodes that no cell with grains is beside: what a zone holds already is not looked for.
pub fn beyond_grains<S: Space>(world: &World<S>, mut nodes: Vec<u64>) -> Result<Vec<u64>, Error> {
    if !world.has_grains() {
        return Ok(nodes);
    }
    let (grid, taken) = (cell_grid(world), cells_of_grains(world)?);
    nodes.retain(|node| !grid.touches(*node, &taken));
    Ok(nodes)
}

/// Which cells of the plane hold grains, on every rank.
fn cells_of_grains<S: Space>(world: &World<S>) -> Result<Vec<bool>, Error> {
    let grid = cell_grid(world);
    let mut taken = vec![false; grid.counts[0] * grid.counts[1]];
    let mut parcel = Writer::new();
    let free =
        world.assembly.grains.cold[..world.assembly.grains.owned].iter().filter(|cold| cold.mover == Mover::Free);
    for cell in free.filter_map(|cold| world.cell_of_grain(cold)) {
        if !std::mem::replace(&mut taken[cell], true) {
            parcel.u64(cell as u64);
        }
    }
    for bytes in world.transport.all_gather(parcel.as_bytes()) {
        let mut reader = Reader::plain(&bytes);
        while reader.left() > 0 {
            taken[reader.u64().map_err(|error| Error::Run(error.to_string()))? as usize] = true;
        }
    }
    Ok(taken)
}

/// Two fields of points as mass-weighted means on the nodes of the whole domain, on every rank.
fn node_fields<S: Space>(
    world: &mut World<S>,
    is_looked_at: impl Fn(&World<S>, [i32; 3]) -> bool,
    fields: impl Fn(&Hot<S>, &Past<S>) -> [f64; 2] + Sync,
) -> Result<NodeFields, Error> {
    let pasts = mem::take(&mut world.continuum.points.pasts);
    let sums = nodal_sums(world, |row, point| {
        let fields = fields(point, &pasts[row]);
        [1.0, fields[0], fields[1]]
    });
    world.continuum.points.pasts = pasts;

    let counts = [world.subdomain.layout.cells[0], world.subdomain.layout.cells[1] + 1];
    let mut mine = Writer::new();
    let looked_at = world
        .subdomain
        .nodes
        .mosaic
        .owned
        .iter()
        .zip(&sums)
        .filter(|(node, sum)| sum[0] > 0.0 && is_looked_at(world, node.place));
    for (node, sum) in looked_at {
        mine.u64(node.place[1] as u64 * counts[0] as u64 + node.place[0] as u64);
        mine.f64(sum[1] / sum[0]);
        mine.f64(sum[2] / sum[0]);
    }
    let mut whole = NodeFields { is_periodic: world.subdomain.layout.periodic[0], ..NodeFields::empty(counts) };
    for bytes in world.transport.all_gather(mine.as_bytes()) {
        let mut reader = Reader::plain(&bytes);
        while reader.left() > 0 {
            let torn = |error: scree_partition::ParcelError| Error::Run(error.to_string());
            let node = reader.u64().map_err(torn)? as usize;
            whole.present[node] = true;
            whole.rate[node] = reader.f64().map_err(torn)?;
            whole.recent[node] = reader.f64().map_err(torn)?;
        }
    }
    Ok(whole)
}

/// Whether a node is looked at. What holds material slows the strain of the cells beside it, in a flow without a band as well: nodes
/// within a cell of plates, of bodies among the material, however they touch it, and of faces that hold along them are not.
fn is_free<S: Space>(world: &World<S>, place: [i32; 3]) -> bool {
    let (cell, y, at) =
        (world.subdomain.layout.cell, world.node_height(place), world.subdomain.layout.node_at::<S::Vector>(place));
    let near_plate = |away: f64| world.bodies.iter().any(|plate| plate.is_behind(y + away * cell, cell));
    let near_body = || {
        world.bodies.iter().filter(|body| body.grip.is_some()).any(|body| {
            let place = place_beside(body, &world.assembly.cell, &at);
            body.nearest(&place).is_some_and(|nearest| nearest.distance <= cell)
        })
    };
    let near_face = || {
        (0..S::DIMENSION).any(|axis| {
            [false, true].into_iter().any(|upper| {
                let mut beside = place;
                beside[axis] += if upper { 1 } else { -1 };
                let holds = matches!(
                    world.settings.grid.faces[axis][usize::from(upper)],
                    Boundary::Fixed | Boundary::Friction { .. }
                );
                holds && world.subdomain.layout.is_behind(beside, axis, upper)
            })
        })
    };
    ![-1.0, 0.0, 1.0].into_iter().any(near_plate) && !near_body() && !near_face()
}

/// Where a node of [`NodeFields`] is, m.
pub fn place_of_node<S: Space>(world: &World<S>, node: u64) -> [f64; 2] {
    let columns = world.subdomain.layout.cells[0] as u64;
    let at: S::Vector = world.subdomain.layout.node_at([(node % columns) as i32, (node / columns) as i32, 0]);
    [at[0], at[1]]
}

/// Of rows of a frame at these places (m), whether the node nearest to each is flagged: 1 or 0.
pub fn flagged_rows<S: Space>(world: &World<S>, memory: &Memory, places: &[[f64; 3]]) -> Column {
    let layout = &world.subdomain.layout;
    let nearest = |place: &[f64; 3]| -> u64 {
        let node = |axis: usize| ((place[axis] - layout.corner[axis]) / layout.cell).round().max(0.0) as u64;
        let columns = layout.cells[0] as u64;
        // Across a period the last node is the first.
        let column = if layout.periodic[0] { node(0) % columns } else { node(0) };
        node(1) * columns + column
    };
    let flagged = places.iter().map(|place| i64::from(memory.flagged.binary_search(&nearest(place)).is_ok()));
    Column { name: "flagged".to_string(), width: 1, values: Values::I64(flagged.collect()) }
}
