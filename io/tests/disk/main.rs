//! What this crate promises, one claim per test.

mod digest;
mod folder;
mod frames;
mod full_disk;
mod hostile;
mod paraview;
mod sample;
mod series;
mod store;
