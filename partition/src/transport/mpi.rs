//! Ranks as processes under `mpirun`.
//!
//! # Why the `unsafe` here is sound
//!
//! * Every call hands MPI a pointer and a count taken from one live slice, of the datatype passed
//!   beside it; counts are converted with a check, never cut.
//! * Nonblocking calls keep pointers. [`InFlight`] borrows the buffers for as long as it lives, and
//!   it ends either in `wait`, after which MPI has let go of them, or in a drop without `wait`,
//!   which ends the process. Collective ones end in [`Mpi::complete`], which returns when MPI has
//!   let go of theirs and calls nothing that panics in between.
//! * MPI is asked for [`Threading::Funneled`]: one thread may call it. [`Mpi::world`] is the only
//!   way to the communicator and asserts that it is that thread, so that sharing `&Mpi` between
//!   threads (the trait demands `Sync`) is harmless. The exception is `MPI_Abort`, which may come
//!   from any thread that panics; the process does not outlive it.
//! * The communicator keeps its default error handler, which ends all ranks. So a call that returns
//!   has succeeded, and return codes are not looked at.

use super::patience::{Patience, Seats};
use super::{Transport, check_peers, patience};
use mpi::Threading;
use mpi::environment::Universe;
use mpi::ffi::{self, MPI_Comm, MPI_Request, MPI_Status};
use std::env;
use std::ffi::{c_int, c_void};
use std::marker::PhantomData;
use std::mem;
use std::panic;
use std::process;
use std::ptr;
use std::slice;
use std::thread::{self, ThreadId};

/// Longest piece of a message: MPI counts bytes in an i32, so longer messages travel in pieces.
const PIECE_BYTES_MAX: usize = 1 << 30;
/// Messages between two ranks do not overtake each other, and ranks call the same operations in the
/// same order.
const TAG: c_int = 0;
/// Up to this length Open MPI hands a message over within a node at once; longer ones wait for a handshake that goes on only
/// while both sides are inside MPI, not while they work. A step's messages to a neighbour are mostly shorter. Its own
/// default, 4 kB, takes 4.2 us for 7 kB, this one 0.8. Its buffers are of that size each: with 512 kB it does not start.
const EAGER_BYTES: &str = "65536";
/// Where Open MPI reads it: release 4, and 5 on.
const EAGER_SETTINGS: [&str; 2] = ["OMPI_MCA_btl_vader_eager_limit", "OMPI_MCA_btl_sm_eager_limit"];
/// The exit code of a rank that panicked, as Rust's own.
const PANIC_CODE: c_int = 101;

/// One process of an MPI run. Dropping it finalises MPI, which waits for all ranks; a rank that
/// gives up before the others must call [`abort`](Transport::abort) instead.
///
/// All calls come from the thread that called [`start`](Self::start), and that thread drops it.
pub struct Mpi {
    rank: usize,
    size: usize,
    thread: ThreadId,
    patience: Patience,
    /// Finalises MPI when dropped.
    _universe: Universe,
}

impl Mpi {
    /// Starts MPI. From here on a panic on any thread of any rank ends all ranks: a rank that
    /// merely unwound would leave the others waiting. Works without `mpirun` too, as a run of one
    /// rank.
    ///
    /// Call it before starting threads: settings of the MPI library that its user has left open are
    /// set in the environment.
    ///
    /// # Panics
    /// When MPI was started before in this process, or when the library cannot serve a process with
    /// several threads.
    pub fn start() -> Self {
        for setting in EAGER_SETTINGS.into_iter().filter(|setting| env::var_os(setting).is_none()) {
            // SAFETY: MPI starts before any other thread does, so that nobody reads the environment meanwhile.
            unsafe { env::set_var(setting, EAGER_BYTES) };
        }
        let (universe, provided) =
            mpi::initialize_with_threading(Threading::Funneled).expect("MPI is started once per process");
        assert!(
            provided >= Threading::Funneled,
            "the MPI library provides thread support {provided:?}, the program needs Funneled; \
             use a library built with thread support"
        );
        end_all_ranks_on_panic();
        let (mut rank, mut size, mut here) = (0, 0, 0);
        let mut firsts;
        // SAFETY: MPI is initialised and all pointers are to live integers, `firsts` has one for each rank of
        // this machine, and their communicator is freed here.
        unsafe {
            let world = ffi::RSMPI_COMM_WORLD;
            ffi::MPI_Comm_rank(world, &mut rank);
            ffi::MPI_Comm_size(world, &mut size);
            let mut machine = world;
            ffi::MPI_Comm_split_type(world, ffi::RSMPI_COMM_TYPE_SHARED, 0, ffi::RSMPI_INFO_NULL, &mut machine);
            ffi::MPI_Comm_size(machine, &mut here);
            firsts = vec![0_u64; usize::try_from(here).expect("this rank is there")];
            let (mine, u64_type) = ([patience::first_core()], ffi::RSMPI_UINT64_T);
            ffi::MPI_Allgather(pointer(&mine), 1, u64_type, pointer_mut(&mut firsts), 1, u64_type, machine);
            ffi::MPI_Comm_free(&mut machine);
        }
        let natural = |number: c_int| usize::try_from(number).expect("MPI numbers ranks from 0");
        Self {
            rank: natural(rank),
            size: natural(size),
            thread: thread::current().id(),
            patience: Patience::new(Seats::of(&firsts)),
            _universe: universe,
        }
    }

    fn world(&self) -> MPI_Comm {
        assert_eq!(thread::current().id(), self.thread, "only the thread that started MPI may call it");
        // SAFETY: a constant of the library.
        unsafe { ffi::RSMPI_COMM_WORLD }
    }

    /// Each value joined over the ranks, by messages between pairs of them (recursive doubling): whole numbers come out the same in
    /// any order, and Open MPI's own reduction takes twice as long on two ranks and holds the core while it waits.
    fn all_reduce(&self, values: &mut [i64], join: fn(i64, i64) -> i64) {
        let mut theirs = vec![0; values.len()];
        // Ranks beyond the largest power of two hand their values in, and are told what came out.
        let paired = 1 << self.size.ilog2();
        let merge = |values: &mut [i64], theirs: &[i64]| {
            values.iter_mut().zip(theirs).for_each(|(mine, theirs)| *mine = join(*mine, *theirs));
        };
        if self.rank >= paired {
            self.swap(Some((self.rank - paired, values)), None);
            self.swap(None, Some((self.rank - paired, values)));
            return;
        }
        let outsider = Some(self.rank + paired).filter(|outsider| *outsider < self.size);
        if let Some(outsider) = outsider {
            self.swap(None, Some((outsider, &mut theirs)));
            merge(values, &theirs);
        }
        for distance in (0..paired.ilog2()).map(|power| 1 << power) {
            let partner = self.rank ^ distance;
            self.swap(Some((partner, values)), Some((partner, &mut theirs)));
            merge(values, &theirs);
        }
        if let Some(outsider) = outsider {
            self.swap(Some((outsider, values)), None);
        }
    }

    /// Numbers to one rank and from one, as many as they know of.
    fn swap(&self, send: Option<(usize, &[i64])>, receive: Option<(usize, &mut [i64])>) {
        let mut flight = InFlight::new(self, 2);
        if let Some((sender, into)) = receive {
            flight.receive(sender, bytes_mut(into));
        }
        if let Some((receiver, values)) = send {
            flight.send(receiver, bytes(values));
        }
        flight.wait();
    }

    /// Ends a collective operation that `begin` starts on buffers which live until then.
    fn complete(&self, begin: impl FnOnce(MPI_Comm, &mut MPI_Request)) {
        // SAFETY: a constant of the library.
        let mut request = unsafe { ffi::RSMPI_REQUEST_NULL };
        begin(self.world(), &mut request);
        self.patience.until(|| {
            let mut is_there = 0;
            // SAFETY: one live request and one integer; MPI may be told that nobody reads the status.
            unsafe { ffi::MPI_Test(&mut request, &mut is_there, ffi::RSMPI_STATUS_IGNORE) };
            is_there != 0
        });
    }

    /// How many bytes each rank has for me, given how many I have for each.
    fn transposed(&self, lengths: &[u64]) -> Vec<u64> {
        assert_eq!(lengths.len(), self.size, "one entry per rank");
        let mut theirs = vec![0; self.size];
        // SAFETY: one u64 per rank in either buffer.
        self.complete(|world, request| unsafe {
            let u64_type = ffi::RSMPI_UINT64_T;
            ffi::MPI_Ialltoall(pointer(lengths), 1, u64_type, pointer_mut(&mut theirs), 1, u64_type, world, request);
        });
        theirs
    }

    /// Everyone's number, by rank.
    fn all_numbers(&self, mine: u64) -> Vec<u64> {
        let (mine, mut all) = ([mine], vec![0; self.size]);
        // SAFETY: one u64 from here, one u64 per rank in `all`.
        self.complete(|world, request| unsafe {
            let u64_type = ffi::RSMPI_UINT64_T;
            ffi::MPI_Iallgather(pointer(&mine), 1, u64_type, pointer_mut(&mut all), 1, u64_type, world, request);
        });
        all
    }

    /// At most as many bytes as one call can move.
    fn broadcast_piece(&self, bytes: &mut [u8]) {
        // SAFETY: one buffer of `bytes.len()` bytes.
        self.complete(|world, request| unsafe {
            let length = count(bytes.len());
            ffi::MPI_Ibcast(pointer_mut(bytes), length, ffi::RSMPI_UINT8_T, 0, world, request);
        });
    }
}

impl Drop for Mpi {
    fn drop(&mut self) {
        // Finalising is a call like any other, and the field's own drop cannot check.
        self.world();
    }
}

impl Transport for Mpi {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(&self, sends: &[(usize, &[u8])], receives: &mut [(usize, &mut [u8])], meanwhile: &mut dyn FnMut()) {
        check_peers(self, sends, receives);
        let mut flight = InFlight::new(self, sends.len() + receives.len());
        for (sender, into) in receives {
            flight.receive(*sender, into);
        }
        for (receiver, bytes) in sends {
            flight.send(*receiver, bytes);
        }
        meanwhile();
        flight.wait();
    }

    fn all_to_all(&self, mut outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        // Most ranks have nothing for most others: lengths go to all, content only where there is
        // any.
        let lengths: Vec<u64> = outgoing.iter().map(|bytes| bytes.len() as u64).collect();
        let mut incoming: Vec<Vec<u8>> = self.transposed(&lengths).into_iter().map(zeros).collect();
        incoming[self.rank] = mem::take(&mut outgoing[self.rank]);
        let mut flight = InFlight::new(self, 0);
        for (sender, into) in incoming.iter_mut().enumerate().filter(|(sender, _)| *sender != self.rank) {
            flight.receive(sender, into);
        }
        // Mine was taken, and no bytes are no message.
        for (receiver, bytes) in outgoing.iter().enumerate() {
            flight.send(receiver, bytes);
        }
        flight.wait();
        incoming
    }

    /// # Panics
    /// When all bytes together exceed 2 GiB, which this operation is not for.
    fn all_gather(&self, mine: &[u8]) -> Vec<Vec<u8>> {
        let lengths = self.all_numbers(mine.len() as u64);
        let total: u64 = lengths.iter().sum();
        assert!(total <= c_int::MAX as u64, "{total} bytes are too many to be gathered on all ranks");
        let counts: Vec<c_int> = lengths.iter().map(|&length| length as c_int).collect();
        let starts: Vec<c_int> =
            counts.iter().scan(0, |next, length| Some(mem::replace(next, *next + length))).collect();
        let mut all = zeros(total);
        // SAFETY: `all` holds the sum of `counts`, whose pieces start at their running sums.
        self.complete(|world, request| unsafe {
            ffi::MPI_Iallgatherv(
                pointer(mine),
                count(mine.len()),
                ffi::RSMPI_UINT8_T,
                pointer_mut(&mut all),
                counts.as_ptr(),
                starts.as_ptr(),
                ffi::RSMPI_UINT8_T,
                world,
                request,
            );
        });
        let piece = |(start, length): (&c_int, &c_int)| all[*start as usize..][..*length as usize].to_vec();
        starts.iter().zip(&counts).map(piece).collect()
    }

    fn gather(&self, mine: &[u8]) -> Option<Vec<Vec<u8>>> {
        // Everyone learns every length, a few bytes more than needed; content goes to the root
        // alone, at any length.
        let lengths = self.all_numbers(mine.len() as u64);
        if self.rank != 0 {
            let mut flight = InFlight::new(self, 1);
            flight.send(0, mine);
            flight.wait();
            return None;
        }
        let mut all: Vec<Vec<u8>> = lengths.into_iter().map(zeros).collect();
        all[0].copy_from_slice(mine);
        let mut flight = InFlight::new(self, self.size);
        for (sender, into) in all.iter_mut().enumerate().skip(1) {
            flight.receive(sender, into);
        }
        flight.wait();
        Some(all)
    }

    fn broadcast(&self, mut bytes: Vec<u8>) -> Vec<u8> {
        let mut length = (bytes.len() as u64).to_le_bytes();
        self.broadcast_piece(&mut length);
        if self.rank != 0 {
            bytes = zeros(u64::from_le_bytes(length));
        }
        for piece in bytes.chunks_mut(PIECE_BYTES_MAX) {
            self.broadcast_piece(piece);
        }
        bytes
    }

    fn sum(&self, values: &mut [i64]) {
        self.all_reduce(values, i64::wrapping_add);
    }

    fn max_integer(&self, values: &mut [i64]) {
        self.all_reduce(values, i64::max);
    }

    fn barrier(&self) {
        // SAFETY: the communicator is live.
        self.complete(|world, request| unsafe {
            ffi::MPI_Ibarrier(world, request);
        });
    }

    fn abort(&self, code: i32) -> ! {
        end_all_ranks(code)
    }
}

/// Messages under way, and the borrow of their buffers. An empty message is none: both sides know
/// its length.
struct InFlight<'a> {
    world: MPI_Comm,
    patience: &'a Patience,
    /// Receives first, in step with `expected`.
    requests: Vec<MPI_Request>,
    /// Sender and length of each receive.
    expected: Vec<(usize, c_int)>,
    buffers: PhantomData<&'a mut [u8]>,
}

impl<'a> InFlight<'a> {
    fn new(mpi: &'a Mpi, messages: usize) -> Self {
        Self {
            world: mpi.world(),
            patience: &mpi.patience,
            requests: Vec::with_capacity(messages),
            expected: Vec::with_capacity(messages),
            buffers: PhantomData,
        }
    }

    fn receive(&mut self, sender: usize, into: &'a mut [u8]) {
        assert_eq!(self.requests.len(), self.expected.len(), "receives are posted before sends");
        for piece in into.chunks_mut(PIECE_BYTES_MAX) {
            let length = count(piece.len());
            // SAFETY: `piece` is borrowed for 'a, which outlives the request.
            let request = unsafe {
                let mut request = ffi::RSMPI_REQUEST_NULL;
                let (bytes, u8_type) = (pointer_mut(piece), ffi::RSMPI_UINT8_T);
                ffi::MPI_Irecv(bytes, length, u8_type, count(sender), TAG, self.world, &mut request);
                request
            };
            self.requests.push(request);
            self.expected.push((sender, length));
        }
    }

    fn send(&mut self, receiver: usize, bytes: &'a [u8]) {
        for piece in bytes.chunks(PIECE_BYTES_MAX) {
            // SAFETY: `piece` is borrowed for 'a, which outlives the request; MPI only reads it.
            let request = unsafe {
                let mut request = ffi::RSMPI_REQUEST_NULL;
                let (bytes, u8_type) = (pointer(piece), ffi::RSMPI_UINT8_T);
                let length = count(piece.len());
                ffi::MPI_Isend(bytes, length, u8_type, count(receiver), TAG, self.world, &mut request);
                request
            };
            self.requests.push(request);
        }
    }

    fn wait(mut self) {
        // SAFETY: a status is plain integers, for which zero is a value.
        let mut statuses: Vec<MPI_Status> = vec![unsafe { mem::zeroed() }; self.requests.len()];
        let patience = self.patience;
        patience.until(|| {
            let mut are_there = 0;
            let (messages, requests) = (count(self.requests.len()), self.requests.as_mut_ptr());
            // SAFETY: one request and one status per message; once all are there MPI has let go of the buffers.
            unsafe { ffi::MPI_Testall(messages, requests, &mut are_there, statuses.as_mut_ptr()) };
            are_there != 0
        });
        self.requests.clear();
        // Too long a message is an error to MPI, too short a one is not.
        for (status, (sender, length)) in statuses.iter().zip(&self.expected) {
            let mut arrived = 0;
            // SAFETY: a status that `MPI_Testall` filled in.
            unsafe {
                ffi::MPI_Get_count(status, ffi::RSMPI_UINT8_T, &mut arrived);
            }
            assert_eq!(arrived, *length, "bytes that arrived from rank {sender}, and bytes expected");
        }
    }
}

impl Drop for InFlight<'_> {
    fn drop(&mut self) {
        if !self.requests.is_empty() {
            // Unwinding while MPI may still write to the buffers: there is no way on.
            end_all_ranks(PANIC_CODE);
        }
    }
}

fn end_all_ranks_on_panic() {
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |cause| {
        report(cause);
        let mut finalized = 0;
        // SAFETY: allowed at any time; the pointer is to a live integer.
        unsafe {
            ffi::MPI_Finalized(&mut finalized);
        }
        if finalized == 0 {
            end_all_ranks(PANIC_CODE);
        }
    }));
}

fn end_all_ranks(code: c_int) -> ! {
    // SAFETY: MPI is initialised, and nothing runs in this process afterwards.
    unsafe {
        ffi::MPI_Abort(ffi::RSMPI_COMM_WORLD, code);
    }
    process::exit(code)
}

fn count(items: usize) -> c_int {
    c_int::try_from(items).unwrap_or_else(|_| panic!("{items} items are more than one MPI call can move"))
}

/// Numbers as the bytes that they are; ranks of a run are one program on machines of one kind.
fn bytes(values: &[i64]) -> &[u8] {
    // SAFETY: the same memory for the same time, and any bytes are bytes.
    unsafe { slice::from_raw_parts(values.as_ptr().cast(), mem::size_of_val(values)) }
}

/// As [`bytes`]; any bytes are numbers.
fn bytes_mut(values: &mut [i64]) -> &mut [u8] {
    // SAFETY: the same memory for the same time, borrowed as it was; any eight bytes are an i64.
    unsafe { slice::from_raw_parts_mut(values.as_mut_ptr().cast(), mem::size_of_val(values)) }
}

fn zeros(length: u64) -> Vec<u8> {
    vec![0; usize::try_from(length).expect("a message fits the address space")]
}

/// An empty slice points nowhere in particular, in Rust at address 1 for bytes, which is the
/// in-place marker of some libraries: they are shown null instead, which every library takes where
/// the count is 0.
fn pointer<T>(values: &[T]) -> *const c_void {
    if values.is_empty() { ptr::null() } else { values.as_ptr().cast() }
}

/// As [`pointer`].
fn pointer_mut<T>(values: &mut [T]) -> *mut c_void {
    if values.is_empty() { ptr::null_mut() } else { values.as_mut_ptr().cast() }
}
