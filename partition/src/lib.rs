//! Who holds which block, and how rows travel between those who do.
//!
//! The global grid is a [`Lattice`] of blocks. A [`Curve`] strings the blocks along a Hilbert
//! curve, [`cut()`] deals contiguous stretches of it to ranks by weight, and a [`Transport`]
//! carries bytes between the ranks, which may be one process ([`Solo`]), threads of one process
//! ([`Threads`]), or processes under `mpirun` (`Mpi`, feature `mpi`). On top of the transport stand
//! the [`Halo`] (copies of rows another rank owns, renewed every step), migration
//! ([`exchange_rows`], sealed parcels at rebuilds), pieces for rank 0 ([`in_turn`]) and sums that are exact in any order
//! ([`ExactSum`]).
//!
//! Nothing here knows what a row means. Whatever this crate decides changes who computes, never
//! what is computed.

#![deny(missing_docs, unsafe_code)]

pub mod checksum;
pub mod curve;
pub mod cut;
pub mod halo;
pub mod hilbert;
pub mod lattice;
pub mod migrate;
pub mod parcel;
pub mod reduce;
pub mod transport;
pub mod turns;

pub use curve::Curve;
pub use cut::cut;
pub use halo::{Halo, HaloBuffers, HaloCounts};
pub use lattice::{Lattice, LatticeError, offsets};
pub use migrate::exchange_rows;
pub use parcel::{ParcelError, Reader, Route, Writer};
pub use reduce::{ExactSum, ExactSums, SumError};
#[cfg(feature = "mpi")]
pub use transport::Mpi;
pub use transport::{Solo, Threads, Transport};
pub use turns::in_turn;
