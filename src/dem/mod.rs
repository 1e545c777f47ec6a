//! The grain engine: grains, the pairs that may touch, forces with memory, motion. It does not know ranks: rows beyond
//! [`grains::Grains::owned`] are copies whose positions and velocities somebody else keeps fresh.

pub mod assembly;
pub mod bearing;
pub mod cell;
pub mod columns;
pub mod contacts;
pub mod drive;
pub mod grains;
pub mod kernel;
pub mod law;
pub mod memories;
pub mod motion;
pub mod neighbours;
pub mod sample;
pub mod segments;
pub mod strained;
pub mod tile;
pub mod walls;
pub mod work;
