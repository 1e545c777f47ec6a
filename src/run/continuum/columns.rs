//! Columns of `series.csv` that jobs on a grid have in common, with grains or without.

use crate::base::space::{AXES, Linear, Space};
use crate::domain::grid::{self, REACTIONS};
use crate::domain::world::World;
use crate::job::mpm::Mpm;
use crate::law::material::MaterialLaw;

pub(super) const FACES: [&str; 2] = ["lower", "upper"];

/// Of the oracle: nodes that are flagged now, and whether there has been a band that persists.
pub const OF_ORACLE: [&str; 2] = ["flagged_nodes", "band"];

/// Of a membrane: length, m, and what its segments bear, N.
const OF_MEMBRANE: [&str; 3] = ["length", "tension_least", "tension_most"];

/// Components of a vector.
pub fn of_vector<S: Space>(name: &str) -> Vec<String> {
    AXES[..S::DIMENSION].iter().map(|axis| format!("{name}_{axis}")).collect()
}

/// Lowest and highest coordinate along each axis.
pub fn of_extents<S: Space>() -> Vec<String> {
    AXES[..S::DIMENSION].iter().flat_map(|axis| FACES.map(|end| format!("{end}_{axis}"))).collect()
}

/// Of points and free grains, m. Collective.
pub fn row_of_extents<S: Space, L: MaterialLaw<S>>(world: &World<S, L>) -> Vec<f64> {
    let mut extents = [f64::NEG_INFINITY; 6];
    let points = world.continuum.points.hot.iter().map(|hot| (&hot.position, 0.0));
    let grains = world.assembly.grains.hot[..world.assembly.grains.owned].iter().map(|hot| (&hot.position, hot.radius));
    for (position, radius) in points.chain(grains) {
        for axis in 0..S::DIMENSION {
            extents[2 * axis] = extents[2 * axis].max(radius - position[axis]);
            extents[2 * axis + 1] = extents[2 * axis + 1].max(position[axis] + radius);
        }
    }
    world.transport.max(&mut extents);
    (0..S::DIMENSION).flat_map(|axis| [-extents[2 * axis], extents[2 * axis + 1]]).collect()
}

/// Forces and torques on bodies, and how far they have come.
pub fn of_bodies<S: Space>(job: &Mpm) -> Vec<String> {
    let spins: &[&str] = if S::DIMENSION == 2 { &AXES[2..] } else { &AXES };
    let of = |name: &str| -> Vec<String> {
        let torques = spins.iter().map(|axis| format!("{name}_torque_{axis}"));
        let forces = of_vector::<S>(&format!("{name}_force"));
        forces.into_iter().chain(torques).chain(of_vector::<S>(&format!("{name}_displacement"))).collect()
    };
    job.bodies.iter().flat_map(|body| of(&body.body.name)).collect()
}

/// N, N m and m; means over `duration`, s, of what was taken off nodes and grains.
pub fn row_of_bodies<S: Space, L: MaterialLaw<S>>(
    world: &World<S, L>,
    reactions: &[f64; REACTIONS],
    duration: f64,
) -> Vec<f64> {
    let mut row = Vec::new();
    for (number, body) in world.bodies.iter().enumerate() {
        let (impulse, turn) = grid::body_impulse(reactions, number);
        row.extend((0..S::DIMENSION).map(|axis| impulse[axis] / duration));
        row.extend((0..S::Spin::COMPONENTS).map(|axis| turn[axis] / duration));
        row.extend((0..S::DIMENSION).map(|axis| body.displacement[axis]));
    }
    row
}

pub fn of_membranes(job: &Mpm) -> Vec<String> {
    job.membranes.iter().flat_map(|membrane| OF_MEMBRANE.map(|what| format!("{}_{what}", membrane.name))).collect()
}

/// m and N.
pub fn row_of_membranes<S: Space, L: MaterialLaw<S>>(world: &World<S, L>) -> Vec<f64> {
    let membranes = &world.continuum.membranes;
    membranes.made_of.iter().flat_map(|membrane| membranes.stretch(membrane)).collect()
}
