//! A [`State`](crate::State) in one HDF5 file: written aside and renamed, so that a name never stands for half a state;
//! checked in whole when read, so that a run never goes on from a damaged one. [`schema`](crate::schema) draws the
//! inside.

mod folder;
mod parts;
mod read;
mod writer;

pub use folder::{FOR_GOOD, all, file_name, keep_for_good, latest_good, newest, prune};
pub use read::read;
pub use writer::{Writer, write, write_in};
