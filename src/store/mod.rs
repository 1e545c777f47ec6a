//! A world as tables, and whether tables are a world.

pub mod checkpoint;
pub mod soundness;
pub mod tables;
