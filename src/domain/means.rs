//! Means over the points around a node, and of those over the nodes around a point; for what looks at a world, and every so many
//! steps for loads on its surface.
//!
//! ```text
//! f_i = sum_p w_p m_p N_i(x_p) f_p / sum_p w_p m_p N_i(x_p),   f(x_p) = sum_i N_i(x_p) f_i
//! ```

use crate::base::parallel::{Held, over_blocks};
use crate::base::space::Space;
use crate::domain::world::World;
use crate::mpm::look::for_each_node;
use crate::mpm::points::Hot;

/// `sum w m N f` at the nodes that this rank owns, of fields of points by their row, in one order on any number of ranks. Collective.
pub fn nodal_sums<S: Space, const W: usize>(
    world: &mut World<S>,
    fields: impl Fn(usize, &Hot<S>) -> [f64; W] + Sync,
) -> Vec<[f64; W]> {
    let (mosaic, shape) = (&world.subdomain.nodes.mosaic, world.settings.grid.shape);
    let (ranges, frames, tile_len) = (&world.subdomain.point_ranges, &world.continuum.frames, mosaic.nodes_per_tile);
    let mut rows = vec![[0.0; W]; mosaic.rows() + mosaic.rows_received];
    let held = Held { rows: &mut world.continuum.points.hot[..], tiles: &mut rows[..mosaic.rows()], tile_len };
    over_blocks(ranges, held, &|block, Held { rows, tiles, .. }| {
        for (row, point) in ranges[block].clone().zip(rows.iter()) {
            let (fields, mass) = (fields(row, point), point.weight * point.mass);
            for_each_node(&frames[block], shape, &point.position, |node, value| {
                let share = mass * value;
                tiles[node].iter_mut().zip(&fields).for_each(|(sum, field)| *sum += share * field);
            });
        }
        0.0
    });
    let halo = &world.subdomain.nodes.gathered;
    halo.pack::<W>(&mut world.subdomain.buffers, |row| rows[row as usize]);
    halo.exchange::<W>(world.transport, &mut world.subdomain.buffers, &mut || {});
    halo.unpack::<W>(&world.subdomain.buffers, |row, words| rows[row as usize] = words);
    mosaic.sum(&rows, [0.0; W], |sum, row| sum.iter_mut().zip(row).for_each(|(sum, row)| *sum += row))
}

/// Fields of points as those around them have them on the mean; the first of `fields` must be one. In the order of the rows. Collective.
pub fn averaged<S: Space, const W: usize>(
    world: &mut World<S>,
    fields: impl Fn(usize, &Hot<S>) -> [f64; W] + Sync,
) -> Vec<[f64; W]> {
    let mut means = nodal_sums(world, fields);
    means.iter_mut().filter(|sum| sum[0] > 0.0).for_each(|sum| *sum = sum.map(|word| word / sum[0]));
    at_points(world, &means)
}

/// `sum_i N_i(x_p) f_i` of values at the nodes that this rank owns. In the order of the rows. Collective.
pub fn at_points<S: Space, const W: usize>(world: &mut World<S>, values: &[[f64; W]]) -> Vec<[f64; W]> {
    let (nodes, shape) = (&world.subdomain.nodes, world.settings.grid.shape);
    let mosaic = &nodes.mosaic;
    let mut rows = vec![[0.0; W]; mosaic.rows() + mosaic.rows_spread];
    mosaic.owned.iter().zip(values).for_each(|(node, value)| rows[node.row as usize] = *value);
    nodes.advanced.pack::<W>(&mut world.subdomain.buffers, |row| rows[row as usize]);
    nodes.advanced.exchange::<W>(world.transport, &mut world.subdomain.buffers, &mut || {});
    nodes.advanced.unpack::<W>(&world.subdomain.buffers, |row, words| rows[row as usize] = words);
    for &(to, from) in &mosaic.copies {
        rows[to as usize] = rows[from as usize];
    }
    let mut means = vec![[0.0; W]; world.continuum.points.len()];
    for (block, range) in world.subdomain.point_ranges.iter().enumerate() {
        let tile = &rows[block * mosaic.nodes_per_tile..];
        for row in range.clone() {
            let (place, mean) = (&world.continuum.points.hot[row].position, &mut means[row]);
            for_each_node(&world.continuum.frames[block], shape, place, |node, value| {
                mean.iter_mut().zip(&tile[node]).for_each(|(mean, word)| *mean += value * word);
            });
        }
    }
    means
}
