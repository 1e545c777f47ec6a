//! The operator's wish that the program stop: SIGTERM, SIGINT or SIGUSR1. Of SIGTERM mpirun makes an end within a second;
//! SIGUSR1 it hands on to all ranks, on every machine, and lets them finish.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Instant;

use crate::error::Error;

/// One for the process, as signals are.
static WANTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// From now on these signals end nothing by themselves; who takes steps asks [`wanted`].
pub fn listen() -> Result<(), Error> {
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT, signal_hook::consts::SIGUSR1] {
        signal_hook::flag::register(signal, Arc::clone(&WANTED))
            .map_err(|error| Error::Run(format!("cannot listen for signals: {error}")))?;
    }
    Ok(())
}

/// Seconds that the steps of a run may take; zero for no limit.
static SECONDS: AtomicU64 = AtomicU64::new(0);

/// From now on a run stops when its steps have taken so long.
pub fn limit(seconds: u64) {
    SECONDS.store(seconds, Ordering::Relaxed);
}

/// Whether steps that began then have taken as long as they may.
pub fn is_over(started: Instant) -> bool {
    match SECONDS.load(Ordering::Relaxed) {
        0 => false,
        seconds => started.elapsed().as_secs() >= seconds,
    }
}

/// Whether this rank has been asked to stop.
pub fn wanted() -> bool {
    WANTED.load(Ordering::Relaxed)
}
