//! Every transport keeps the same promises.

mod operations;

mod solo;
mod threads;

#[cfg(feature = "mpi")]
mod mpi;
