//! The continuum engine: explicit material point method with quadratic B-splines and a FLIP/PIC blend.
//!
//! One step is scatter (points to tiles), sum of tiles, [`nodes::advance`], spread of tiles, gather (tiles to points, stress
//! update last). Which nodes another rank sums is not known here: [`tile::Tiles`] has rows for them.

pub mod gather;
pub mod nodes;
pub mod points;
pub mod scatter;
pub mod shape;
pub mod tile;
