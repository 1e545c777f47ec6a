//! What a run is asked to do, and how it ended.

use std::path::PathBuf;
use std::time::Duration;

/// How a run is to be carried out; none of it is physics.
#[derive(Clone, Debug)]
pub struct Options {
    /// The run directory.
    pub out: PathBuf,
    /// Threads per rank, for the record: the pool is made by the caller.
    pub threads: usize,
    /// Wall time of the steps after which the run stops, however far it is.
    pub steps_for: Option<Duration>,
    /// [`start::resume`](super::start::resume) finds it, whatever is given.
    pub beginning: Beginning,
}

/// What a run takes up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beginning {
    /// Nothing, or a checkpoint as it is.
    Plain,
    /// A checkpoint with a job that differs from its own in what is no physics; one with the new job is written at once.
    Changed,
    /// A checkpoint of another run: with a folder of its own, its outputs begin here.
    Branched,
}

impl Beginning {
    /// The variant of that number, as rank 0 sends it. Panics where there is none.
    pub fn of_code(code: u8) -> Self {
        [Self::Plain, Self::Changed, Self::Branched][usize::from(code)]
    }
}

impl Options {
    /// Of a run in the folder `out` that begins, or goes on as it is, without a limit of time.
    pub fn new(out: PathBuf, threads: usize) -> Self {
        Self { out, threads, steps_for: None, beginning: Beginning::Plain }
    }
}

/// How a run ended, with closing lines for the operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It has come to its end, now or before.
    Done(String),
    /// Stopped on request, with a checkpoint written unless its packing was still being made.
    Stopped(String),
}
