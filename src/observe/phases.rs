//! Where the time goes, phase by phase.

use std::time::Instant;

use crate::dem::segments::Passed;

/// Parts of a step and what happens between steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Phase {
    Halo,
    Scatter,
    Contacts,
    Motion,
    Bodies,
    Nodes,
    Gather,
    Agree,
    Rebuild,
    Oracle,
    Output,
}

/// Names for tables, in the order of [`Phase`].
pub const NAMES: [&str; 11] =
    ["halo", "scatter", "contacts", "motion", "bodies", "nodes", "gather", "agree", "rebuild", "oracle", "output"];

/// Seconds spent in each phase by this rank. Not state: it never enters a checkpoint or a decision.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    pub seconds: [f64; NAMES.len()],
}

impl Phases {
    pub fn start(&self) -> Instant {
        Instant::now()
    }

    /// Books `seconds` of passes over pairs and segments: the grains' part of them is motion.
    pub fn split(&mut self, seconds: f64, passed: &Passed) {
        self.seconds[Phase::Contacts as usize] += seconds - passed.grains;
        self.seconds[Phase::Motion as usize] += passed.grains;
    }

    pub fn stop(&mut self, phase: Phase, since: Instant) {
        self.seconds[phase as usize] += since.elapsed().as_secs_f64();
    }
}
