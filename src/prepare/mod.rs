//! What is made ahead of a run: packings and specimens. They are kept in a cache that runs share, made once, and while they
//! are made they are saved, told of and stopped like runs.

pub mod grain_file;
pub mod grain_world;
pub mod heterogeneity;
pub mod insert;
pub mod join;
pub mod loose;
pub mod packed;
pub mod plates;
pub mod point_world;
pub mod recipe;
pub mod reference;
pub mod rves;
pub mod sheared;
pub mod specimen;

pub mod cache;
pub mod making;
pub mod mesh_world;
