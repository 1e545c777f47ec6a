//! How bytes get from rank to rank: one trait, and the same program in one thread, in many, or
//! under `mpirun`.

#[cfg(feature = "mpi")]
#[allow(unsafe_code, reason = "the C interface of MPI")]
mod mpi;
mod order;
#[cfg(feature = "mpi")]
mod patience;
mod solo;
pub mod threads;

#[cfg(feature = "mpi")]
pub use self::mpi::Mpi;
pub use self::solo::Solo;
pub use self::threads::Threads;

/// The ranks of one run, seen from one of them.
///
/// Every method but [`rank`](Self::rank), [`size`](Self::size), [`exchange`](Self::exchange) and
/// [`abort`](Self::abort) is collective: all ranks call it, in the same order. Transports carry
/// bytes and add integers; floating-point sums go through [`ExactSum`](crate::ExactSum), since
/// adding in an order that depends on ranks would show in the result.
///
/// A transport does not return errors: a rank that cannot reach another ends the run.
pub trait Transport: Send + Sync {
    /// My number, from 0.
    fn rank(&self) -> usize;

    /// Ranks in the run, at least 1.
    fn size(&self) -> usize;

    /// Sends and receives messages whose lengths both sides know, one per listed peer and
    /// direction; `meanwhile` runs exactly once while they travel. Peers in a list are distinct and
    /// are never this rank.
    ///
    /// # Panics
    /// When a message is not as long as its receiver expects.
    fn exchange(&self, sends: &[(usize, &[u8])], receives: &mut [(usize, &mut [u8])], meanwhile: &mut dyn FnMut());

    /// Hands `outgoing[r]` to rank `r`, of any length, and returns what came from each rank. The
    /// own entry is handed back.
    fn all_to_all(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Everyone's bytes, by rank, on every rank.
    fn all_gather(&self, mine: &[u8]) -> Vec<Vec<u8>>;

    /// Everyone's bytes, by rank, on rank 0; `None` elsewhere.
    fn gather(&self, mine: &[u8]) -> Option<Vec<Vec<u8>>>;

    /// Rank 0's `bytes` on every rank; what others pass is not read.
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Replaces each value by its sum over the ranks. Sums must fit: callers choose their units so
    /// that they do.
    fn sum(&self, values: &mut [i64]);

    /// Replaces each value by its largest over the ranks.
    fn max_integer(&self, values: &mut [i64]);

    /// Replaces each value by its largest over the ranks, in the order -inf, ..., -0, +0, ...,
    /// +inf, NaN.
    ///
    /// So a NaN anywhere wins everywhere, and comes out as [`f64::NAN`] whatever its sign and
    /// payload were: the result has the same bits on any number of ranks, one included. For a
    /// minimum, negate before and after.
    fn max(&self, values: &mut [f64]) {
        order::max(values, |keys| self.max_integer(keys));
    }

    /// Waits until every rank has come here.
    fn barrier(&self);

    /// Ends every rank of the run with this exit code. Not collective: one rank that calls it ends
    /// all.
    fn abort(&self, code: i32) -> !;
}

/// The part of `exchange`'s contract that one rank can see.
fn check_peers(transport: &dyn Transport, sends: &[(usize, &[u8])], receives: &[(usize, &mut [u8])]) {
    debug_assert!(
        are_peers(transport, sends.iter().map(|send| send.0))
            && are_peers(transport, receives.iter().map(|receive| receive.0)),
        "rank {} exchanges with itself, or twice with one peer",
        transport.rank()
    );
}

fn are_peers(transport: &dyn Transport, mut ranks: impl Iterator<Item = usize>) -> bool {
    let mut seen = vec![false; transport.size()];
    seen[transport.rank()] = true;
    ranks.all(|rank| !std::mem::replace(&mut seen[rank], true))
}
