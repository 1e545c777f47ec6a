//! What an operator may wish of a run while it goes on:
//!
//! | wish | by |
//! |---|---|
//! | a checkpoint, with which it ends | SIGTERM, SIGINT, SIGUSR2; a file `stop` in the run directory; `--time-limit` |
//! | a checkpoint, after which it goes on | SIGUSR1 |
//! | its end at once | a second SIGINT |
//!
//! Of SIGTERM mpirun makes an end within a second; SIGUSR1 and SIGUSR2 it hands on to all ranks, on every machine, and lets
//! them finish. One rank that hears is enough: ranks agree on the strongest wish of any after every step.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1, SIGUSR2};

use crate::base::error::Error;

/// Wishes, the weaker first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wish {
    /// To go on.
    #[default]
    None,
    /// A checkpoint, and on.
    Save,
    /// A checkpoint, and the end.
    Stop,
}

impl Wish {
    /// Its number in a maximum over ranks.
    pub fn number(self) -> f64 {
        f64::from(self as u8)
    }

    /// Back from [`Self::number`]; of any other number [`Wish::None`].
    pub fn of_number(number: f64) -> Self {
        [Wish::None, Wish::Save, Wish::Stop].into_iter().find(|wish| wish.number() == number).unwrap_or_default()
    }
}

/// One of each for the process, as signals are.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
static SAVE: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
static INTERRUPTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// What a shell reports of a program that SIGINT has ended.
const CODE_INTERRUPTED: i32 = 130;

/// To be called first of all in the program: mpirun hands SIGUSR1 and SIGUSR2 on to every process that it has started, and one
/// that they end before its run has begun leaves it hanging. What they ask for is kept until then.
pub fn keep_wishes() -> Result<(), Error> {
    static KEEPS: OnceLock<()> = OnceLock::new();
    if KEEPS.set(()).is_err() {
        return Ok(());
    }
    signal_hook::flag::register(SIGUSR1, Arc::clone(&SAVE)).map_err(refused)?;
    signal_hook::flag::register(SIGUSR2, Arc::clone(&STOP)).map(|_| ()).map_err(refused)
}

fn refused(error: std::io::Error) -> Error {
    Error::Run(format!("cannot listen for signals: {error}"))
}

/// From now on SIGTERM and SIGINT end nothing by themselves either; who takes steps asks [`wish`].
pub fn listen() -> Result<(), Error> {
    static LISTENS: OnceLock<()> = OnceLock::new();
    if LISTENS.set(()).is_err() {
        return Ok(());
    }
    keep_wishes()?;
    // In this order: the first SIGINT finds the flag down, and raises it for the second.
    signal_hook::flag::register_conditional_shutdown(SIGINT, CODE_INTERRUPTED, Arc::clone(&INTERRUPTED))
        .map_err(refused)?;
    signal_hook::flag::register(SIGINT, Arc::clone(&INTERRUPTED)).map_err(refused)?;
    for signal in [SIGTERM, SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&STOP)).map_err(refused)?;
    }
    Ok(())
}

/// When the program must have ended.
static DEADLINE: OnceLock<Instant> = OnceLock::new();
/// What the end takes from the wish on, ms.
static RESERVE: AtomicU64 = AtomicU64::new(0);

/// From now on the program ends of itself in time to be gone by then; the first call counts.
pub fn end_by(deadline: Instant) {
    DEADLINE.get_or_init(|| deadline);
}

/// Time kept for the end of what must not go on for longer, at least; and what a row takes to be saved, several times what was
/// measured.
pub const RESERVE_LEAST: Duration = Duration::from_secs(1);
/// Of a grain or a point.
pub const ROW_SAVED: Duration = Duration::from_micros(10);

/// The last checkpoint takes so long, as far as is known.
pub fn reserve(time: Duration) {
    RESERVE.store(time.as_millis() as u64, Ordering::Relaxed);
}

fn is_late() -> bool {
    let reserve = Duration::from_millis(RESERVE.load(Ordering::Relaxed));
    DEADLINE.get().is_some_and(|deadline| Instant::now() + reserve >= *deadline)
}

/// What this rank has been asked for, and has not been told that it is done.
pub fn wish() -> Wish {
    #[cfg(test)]
    if lives::is_over() {
        return Wish::Stop;
    }
    if STOP.load(Ordering::Relaxed) || is_late() {
        Wish::Stop
    } else if SAVE.load(Ordering::Relaxed) {
        Wish::Save
    } else {
        Wish::None
    }
}

/// The checkpoint that was wished for is written.
pub fn saved() {
    SAVE.store(false, Ordering::Relaxed);
}

/// Whether this rank has been asked to stop.
pub fn wanted() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// A hundred years, s.
const LIMIT_MAX: f64 = 3.2e9;

/// `--time-limit` as batch systems write it: `[days-]hours:minutes:seconds`, or `minutes:seconds`.
pub fn time_limit(text: &str) -> Result<Duration, String> {
    let refused = || {
        format!(
            "\"{text}\" is no time. Write hours:minutes:seconds, for example 23:50:00, or days before them, 6-23:50:00"
        )
    };
    let (days, clock) = match text.split_once('-') {
        Some((days, clock)) => (days.parse::<u64>().map_err(|_| refused())?, clock),
        None => (0, text),
    };
    let parts: Result<Vec<u64>, _> = clock.split(':').map(str::parse).collect();
    let (hours, minutes, seconds) = match parts.map_err(|_| refused())?[..] {
        [hours, minutes, seconds] => (hours, minutes, seconds),
        [minutes, seconds] if days == 0 => (0, minutes, seconds),
        _ => return Err(refused()),
    };
    // As fractions no number is too large to be told that it is.
    let total = ((days as f64 * 24.0 + hours as f64) * 60.0 + minutes as f64) * 60.0 + seconds as f64;
    if total > 0.0 && total < LIMIT_MAX { Ok(Duration::from_secs(total as u64)) } else { Err(refused()) }
}

/// Short lives for tests, one for each thread.
#[cfg(test)]
pub(crate) mod lives {
    use std::cell::Cell;

    use crate::base::error::Error;

    thread_local! {
        static ASKS_LEFT: Cell<u64> = const { Cell::new(u64::MAX) };
    }

    /// What `make` makes in lives of so many steps, which ask once each, and how many lives that takes. Each goes on from what the
    /// one before has saved.
    pub(crate) fn of<T>(steps: u64, mut make: impl FnMut() -> Result<T, Error>) -> (T, u64) {
        let mut lives = 1;
        let made = loop {
            ASKS_LEFT.set(steps);
            match make() {
                Ok(made) => break made,
                Err(Error::Stopped(_)) => lives += 1,
                Err(error) => panic!("{error}"),
            }
        };
        ASKS_LEFT.set(u64::MAX);
        (made, lives)
    }

    pub(super) fn is_over() -> bool {
        let left = ASKS_LEFT.get();
        ASKS_LEFT.set(left.saturating_sub(1));
        left == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_batch_systems_write_them() {
        let seconds = |text| time_limit(text).map(|limit| limit.as_secs());
        assert_eq!(seconds("23:50:00"), Ok(85_800));
        assert_eq!(seconds("6-23:50:00"), Ok(604_200));
        assert_eq!(seconds("90:00"), Ok(5400));
        assert_eq!(seconds("0:07"), Ok(7));
        for bad in ["", "7", "0:00", "1-2", "1-2:3", "-1:00:00", "1:2:3:4", "a:b", "99999999999999:00:00", "1.5:00"] {
            assert!(seconds(bad).is_err_and(|words| words.contains("23:50:00")), "{bad}");
        }
    }

    #[test]
    fn the_strongest_wish_is_the_largest() {
        let wishes = [Wish::None, Wish::Save, Wish::Stop];
        assert!(wishes.windows(2).all(|pair| pair[0].number() < pair[1].number()));
        assert!(wishes.iter().all(|wish| Wish::of_number(wish.number()) == *wish));
    }
}
