//! The continuum engine: explicit material point method.
//!
//! One step is scatter (points to tiles), sum of tiles, [`nodes::step`], spread of tiles, gather (tiles to points), in the
//! order that the job's [`scheme::Scheme`] says. Where bodies meet points at their own face, [`faces`] come between sum and nodes; loads on
//! the [`surface`] are there before them. Which nodes another rank sums is not known here: [`tile::Tiles`] has rows for
//! them.

pub mod continuum;
pub mod track;

pub mod askew;
pub mod face_rows;
pub mod faces;
pub mod gather;
pub mod load;
pub mod look;
pub mod membrane;
pub mod nodes;
pub mod nonlocal;
pub mod penalty;
pub mod points;
pub mod scatter;
pub mod scheme;
pub mod shape;
pub mod share;
pub mod strain;
pub mod stress;
pub mod surface;
pub mod tile;
pub mod volumetric;
