//! How a rank waits for the others.
//!
//! It looks again and again without letting go of its core, as MPI libraries do, for as long as a message takes that is under way.
//! Who has not come by then works or, where processes share cores, does not run: ranks that would wait for it on and on take the
//! core from it, or from the other work of the machine, in turn with which every rank of a step runs for some milliseconds and waits
//! for some more. So from then on a rank sleeps between looks.
//!
//! How long it looks before it sleeps, it learns: half as long after a wait that sleep has ended, for who waits on the core that it
//! waits for only keeps it; twice as long after one that it has seen the end of.
//!
//! Ranks that have a core each and may change it do not sleep: the system gives the core of one that sleeps away, and puts two ranks
//! on another. So whoever can, binds ranks to cores, as mpirun does by itself.
//!
//! Steps of 0.13 ms on two ranks, 0.25 on one, two cores, in ms, by a model of a step (three exchanges); in brackets by `MPI_Waitall`:
//!
//! | beside | 2 ranks, bound to cores | 2, not bound | 3, not bound |
//! |---|---|---|---|
//! | nothing | 0.13 (0.13) | 0.13 (0.13) | 0.19 (0.18) |
//! | one process that computes without end | 0.27 (0.26) | if they slept 0.63 to 0.71, or more (0.37) | 0.28 to 0.32 (12) |
//! | two | 0.26 to 0.27 (0.54) | if they slept 0.27 (0.48 to 24) | 2 to 4 (4 to 8) |

use std::fs;
use std::hint;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Looks before the clock is asked.
const LOOKS: u32 = 32;
/// As long as a rank only looks: at least and at most.
const ATTENTIVE: [Duration; 2] = [Duration::from_micros(5), Duration::from_micros(500)];
/// Sleep between two looks; the system adds some 50 us.
const NAP: Duration = Duration::from_micros(20);

/// What a rank has learnt of waiting; nothing that results depend on.
#[derive(Debug)]
pub(super) struct Patience {
    sleeps: bool,
    /// As long as it looks before it sleeps, ns.
    attentive: AtomicU64,
}

/// Ranks of one machine and the cores that they may run on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seats {
    pub ranks: usize,
    /// Cores that this one may run on.
    pub allowed: usize,
    /// Whether no two of them begin their lists of cores with the same one: a launcher has bound them to cores of their own. Those that
    /// share a set of cores, of the machine or of a container, begin alike.
    pub are_apart: bool,
}

impl Seats {
    /// By the first core that each rank of this machine may run on.
    pub fn of(firsts: &[u64]) -> Self {
        let allowed = thread::available_parallelism().map_or(1, usize::from);
        let mut apart = firsts.to_vec();
        apart.sort_unstable();
        apart.dedup();
        Self { ranks: firsts.len(), allowed, are_apart: apart.len() == firsts.len() }
    }

    /// Whether ranks are bound to cores of their own, or are more than there are cores.
    fn sleep(self) -> bool {
        self.ranks > 1 && (self.are_apart || self.ranks > self.allowed)
    }
}

/// The first core that this process may run on.
pub(super) fn first_core() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let list = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).map(str::trim);
    list.and_then(|list| list.split(['-', ',']).next()?.parse().ok()).unwrap_or(0)
}

impl Patience {
    pub fn new(seats: Seats) -> Self {
        Self { sleeps: seats.sleep(), attentive: AtomicU64::new(nanoseconds(ATTENTIVE[1])) }
    }

    /// Returns once `is_there` has said so.
    pub fn until(&self, mut is_there: impl FnMut() -> bool) {
        for _ in 0..LOOKS {
            if is_there() {
                return;
            }
            hint::spin_loop();
        }
        let [least, most] = ATTENTIVE.map(nanoseconds);
        let attentive = self.attentive.load(Ordering::Relaxed);
        let (begun, end) = (Instant::now(), Duration::from_nanos(attentive));
        while !self.sleeps || begun.elapsed() < end {
            if is_there() {
                return self.attentive.store((2 * attentive).min(most), Ordering::Relaxed);
            }
            hint::spin_loop();
        }
        self.attentive.store((attentive / 2).max(least), Ordering::Relaxed);
        while !is_there() {
            thread::sleep(NAP);
        }
    }
}

fn nanoseconds(time: Duration) -> u64 {
    time.as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wait of 30 ms takes next to no time of the processor, and the next one sleeps sooner.
    #[test]
    fn who_waits_long_leaves_the_core_to_others() {
        let cpu = || {
            let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
            Duration::from_nanos(text.split(' ').next().unwrap().parse().unwrap())
        };
        let patience = Patience::new(Seats { ranks: 2, allowed: 1, are_apart: true });
        let attentive = || patience.attentive.load(Ordering::Relaxed);
        let (begun, before, at_first) = (Instant::now(), cpu(), attentive());
        patience.until(|| begun.elapsed() >= Duration::from_millis(30));
        assert!(begun.elapsed() >= Duration::from_millis(30));
        let used = cpu() - before;
        assert!(used < Duration::from_millis(15), "{used:?} of 30 ms");
        assert_eq!(attentive(), at_first / 2);
        for _ in 0..20 {
            let begun = Instant::now();
            patience.until(|| begun.elapsed() >= Duration::from_millis(1));
        }
        assert_eq!(attentive(), nanoseconds(ATTENTIVE[0]));
        let mut looks = 0;
        patience.until(|| {
            looks += 1;
            looks == LOOKS + 2
        });
        assert_eq!((looks, attentive()), (LOOKS + 2, 2 * nanoseconds(ATTENTIVE[0])));
    }
    #[test]
    fn who_may_change_cores_and_has_one_does_not_sleep() {
        let sleeps = |firsts: &[u64], allowed| Seats { allowed, ..Seats::of(firsts) }.sleep();
        // Bound by mpirun: a core each, four threads each.
        assert!(sleeps(&[0, 1], 1) && sleeps(&[0, 4, 8], 4));
        // More ranks than cores.
        assert!(sleeps(&[0, 0, 0], 2));
        // A core each that is not told, of a machine or of a set of cores; of one socket; alone.
        assert!(!sleeps(&[0, 0], 2) && !sleeps(&[12, 12, 12, 12], 4) && !sleeps(&[0; 24], 32) && !sleeps(&[3], 1));
    }
}
