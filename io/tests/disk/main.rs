//! What this crate promises, one claim per test.

mod appending;
mod digest;
mod folder;
mod frames;
mod full_disk;
mod hostile;
mod killed;
mod paraview;
mod pieces;
mod sample;
mod series;
mod store;
