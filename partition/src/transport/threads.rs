//! Ranks as threads of one process: the whole program on several ranks inside one test, or on a
//! machine without MPI.
//!
//! Each rank has an inbox with a queue per sender. Sending never waits, receiving waits for the
//! next message of one sender; everything else is built from these two. A message carries the name
//! of its operation, so that ranks which fall out of step are told where instead of waiting for
//! ever.

use super::{Transport, check_peers};
use std::collections::VecDeque;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ScopedJoinHandle};

/// One rank of a run in threads. Made by [`run`].
pub struct Threads {
    rank: usize,
    hub: std::sync::Arc<Hub>,
}

struct Hub {
    inboxes: Vec<Inbox>,
    /// Ranks whose body has returned: nothing more will come from them.
    left: Vec<AtomicBool>,
    failed: AtomicBool,
}

#[derive(Default)]
struct Inbox {
    /// By sender.
    queues: Mutex<Vec<VecDeque<Message>>>,
    arrived: Condvar,
}

struct Message {
    operation: &'static str,
    bytes: Vec<u8>,
}

/// What a rank panics with because another one did; `run` passes on the first cause instead.
struct Stopped;

/// Runs `body` on `size` ranks at once, each a thread, and returns their results by rank.
///
/// # Panics
/// When a rank panics: all others end at their next wait, and the panic of the lowest rank that had
/// a cause of its own goes on here. Also when the ranks fall out of step, or leave messages unread.
pub fn run<R: Send>(size: usize, body: impl Fn(Threads) -> R + Sync) -> Vec<R> {
    assert!(size > 0, "a run needs a rank");
    let hub = std::sync::Arc::new(Hub::new(size));
    let body = &body;
    let outcomes: Vec<_> = thread::scope(|scope| {
        let start = |rank| {
            let hub = hub.clone();
            thread::Builder::new().name(format!("rank {rank}")).spawn_scoped(scope, move || {
                let _watch = Watch { hub: &hub, rank };
                body(Threads { rank, hub: hub.clone() })
            })
        };
        let handles: Vec<_> = (0..size).map(|rank| start(rank).expect("the system starts a thread per rank")).collect();
        handles.into_iter().map(ScopedJoinHandle::join).collect()
    });

    let mut results = Vec::with_capacity(size);
    let mut stopped = None;
    for outcome in outcomes {
        match outcome {
            Ok(result) => results.push(result),
            Err(cause) if cause.is::<Stopped>() => stopped = Some(cause),
            Err(cause) => resume_unwind(cause),
        }
    }
    if let Some(cause) = stopped {
        resume_unwind(cause);
    }
    hub.check_empty();
    results
}

/// Tells the others how a rank's body ended.
struct Watch<'a> {
    hub: &'a Hub,
    rank: usize,
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.hub.failed.store(true, Ordering::SeqCst);
        } else {
            self.hub.left[self.rank].store(true, Ordering::SeqCst);
        }
        for inbox in &self.hub.inboxes {
            // The lock makes sure that nobody is between looking at the flags and going to sleep.
            let _queues = inbox.lock();
            inbox.arrived.notify_all();
        }
    }
}

impl Hub {
    fn new(size: usize) -> Self {
        let inbox = || Inbox { queues: Mutex::new((0..size).map(|_| VecDeque::new()).collect()), ..Inbox::default() };
        Self {
            inboxes: (0..size).map(|_| inbox()).collect(),
            left: (0..size).map(|_| AtomicBool::new(false)).collect(),
            failed: AtomicBool::new(false),
        }
    }

    fn check_empty(&self) {
        for (receiver, inbox) in self.inboxes.iter().enumerate() {
            for (sender, queue) in inbox.lock().iter().enumerate() {
                if let Some(message) = queue.front() {
                    panic!("rank {receiver} never read a message of rank {sender} ({})", message.operation);
                }
            }
        }
    }
}

impl Inbox {
    /// A panic while the lock is held leaves the queues whole, and is told to everyone by `Watch`.
    fn lock(&self) -> MutexGuard<'_, Vec<VecDeque<Message>>> {
        self.queues.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Threads {
    fn send(&self, operation: &'static str, receiver: usize, bytes: Vec<u8>) {
        let inbox = &self.hub.inboxes[receiver];
        inbox.lock()[self.rank].push_back(Message { operation, bytes });
        inbox.arrived.notify_one();
    }

    fn receive(&self, operation: &'static str, sender: usize) -> Vec<u8> {
        let inbox = &self.hub.inboxes[self.rank];
        let mut queues = inbox.lock();
        let message = loop {
            if self.hub.failed.load(Ordering::SeqCst) {
                drop(queues);
                // Not a panic of its own: the hook has already reported the cause.
                resume_unwind(Box::new(Stopped));
            }
            if let Some(message) = queues[sender].pop_front() {
                break message;
            }
            assert!(
                !self.hub.left[sender].load(Ordering::SeqCst),
                "rank {} waits in {operation} for rank {sender}, which has ended",
                self.rank
            );
            queues = inbox.arrived.wait(queues).unwrap_or_else(PoisonError::into_inner);
        };
        drop(queues);
        assert_eq!(message.operation, operation, "ranks {sender} and {} are out of step", self.rank);
        message.bytes
    }

    fn others(&self) -> impl Iterator<Item = usize> + use<> {
        let rank = self.rank;
        (0..self.size()).filter(move |&other| other != rank)
    }

    fn collect(&self, operation: &'static str, mine: Vec<u8>) -> Vec<Vec<u8>> {
        let mut mine = Some(mine);
        let mut from = |sender| {
            if sender == self.rank { mine.take() } else { None }
        };
        (0..self.size()).map(|sender| from(sender).unwrap_or_else(|| self.receive(operation, sender))).collect()
    }

    fn everyones(&self, operation: &'static str, mine: &[u8]) -> Vec<Vec<u8>> {
        for other in self.others() {
            self.send(operation, other, mine.to_vec());
        }
        self.collect(operation, mine.to_vec())
    }

    fn fold(&self, operation: &'static str, values: &mut [i64], combine: impl Fn(i64, i64) -> i64) {
        let mine: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let mut others = self.everyones(operation, &mine);
        others.swap_remove(self.rank);
        for other in others {
            let (other, _) = other.as_chunks();
            assert_eq!(values.len(), other.len(), "ranks are out of step in {operation}");
            for (value, other) in values.iter_mut().zip(other) {
                *value = combine(*value, i64::from_le_bytes(*other));
            }
        }
    }
}

impl Transport for Threads {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.hub.inboxes.len()
    }

    fn exchange(&self, sends: &[(usize, &[u8])], receives: &mut [(usize, &mut [u8])], meanwhile: &mut dyn FnMut()) {
        check_peers(self, sends, receives);
        for (receiver, bytes) in sends {
            self.send("exchange", *receiver, bytes.to_vec());
        }
        meanwhile();
        for (sender, into) in receives {
            let bytes = self.receive("exchange", *sender);
            assert_eq!(bytes.len(), into.len(), "bytes from rank {sender} to rank {}", self.rank);
            into.copy_from_slice(&bytes);
        }
    }

    fn all_to_all(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        assert_eq!(outgoing.len(), self.size(), "one entry per rank");
        let mut mine = Vec::new();
        for (receiver, bytes) in outgoing.into_iter().enumerate() {
            if receiver == self.rank {
                mine = bytes;
            } else {
                self.send("all_to_all", receiver, bytes);
            }
        }
        self.collect("all_to_all", mine)
    }

    fn all_gather(&self, mine: &[u8]) -> Vec<Vec<u8>> {
        self.everyones("all_gather", mine)
    }

    fn gather(&self, mine: &[u8]) -> Option<Vec<Vec<u8>>> {
        if self.rank == 0 {
            return Some(self.collect("gather", mine.to_vec()));
        }
        self.send("gather", 0, mine.to_vec());
        None
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        if self.rank != 0 {
            return self.receive("broadcast", 0);
        }
        for other in self.others() {
            self.send("broadcast", other, bytes.clone());
        }
        bytes
    }

    fn sum(&self, values: &mut [i64]) {
        self.fold("sum", values, |a, b| a.checked_add(b).expect("a sum over ranks fits i64"));
    }

    fn max_integer(&self, values: &mut [i64]) {
        self.fold("max", values, i64::max);
    }

    fn barrier(&self) {
        self.everyones("barrier", &[]);
    }

    /// Panics on every rank, and so out of [`run`]: threads cannot end a process that also holds
    /// the tests.
    fn abort(&self, code: i32) -> ! {
        panic!("rank {} ended the run with exit code {code}", self.rank)
    }
}
