//! Where the time goes, phase by phase.

use std::time::Instant;

use scree_partition::Transport;

use crate::dem::segments::Passed;

/// Parts of a step and what happens between steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Phase {
    /// Messages of a step, packed and unpacked, without what is done while they travel.
    Halo,
    /// Points to nodes, where [`Phase::Gather`] has not done it: after rebuilds; loads and membranes.
    Scatter,
    /// Grains to nodes, and back.
    Couple,
    /// Forces of contacts with grains and bodies.
    Contacts,
    /// Kicks and drifts of grains, drifts of bodies, and the drive of the cell.
    Motion,
    /// Of bodies and membranes.
    Bodies,
    /// Sums over tiles, the step of the nodes, margins.
    Nodes,
    /// Nodes to points, with their law, and what points will bring to nodes next.
    Gather,
    /// Grains of RVEs.
    Rves,
    /// Whether a rebuild is due, which all ranks must know.
    Agree,
    /// Rows sent to the blocks of their places, and lists made anew.
    Rebuild,
    /// Weights of blocks, and dealing them anew.
    Balance,
    /// Looks for shear bands, and for grains of a zone that rest.
    Oracle,
    /// Rows, frames, checkpoints and accounts of energy.
    Output,
}

/// Names for tables, in the order of [`Phase`].
pub const NAMES: [&str; 14] = [
    "halo", "scatter", "couple", "contacts", "motion", "bodies", "nodes", "gather", "rves", "agree", "rebuild",
    "balance", "oracle", "output",
];

/// Phases in which a rank works by itself: none of them waits for another.
pub const WORK: [Phase; 7] =
    [Phase::Scatter, Phase::Couple, Phase::Contacts, Phase::Motion, Phase::Nodes, Phase::Gather, Phase::Rves];

/// Seconds spent in each phase by this rank. Not state: it never enters a checkpoint or a result.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    /// In the order of [`Phase`].
    pub seconds: [f64; NAMES.len()],
}

impl Phases {
    /// The time of now, from which [`Self::stop`] books.
    pub fn start(&self) -> Instant {
        Instant::now()
    }

    /// s.
    pub fn of(&self, phase: Phase) -> f64 {
        self.seconds[phase as usize]
    }

    /// Seconds of all phases.
    pub fn total(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Seconds of [`WORK`].
    pub fn busy(&self) -> f64 {
        WORK.iter().map(|phase| self.of(*phase)).sum()
    }

    /// Books the time since `since`, less what was booked in between: `booked` is [`Self::total`] as it was then.
    pub fn stop_around(&mut self, phase: Phase, since: Instant, booked: f64) {
        self.seconds[phase as usize] += since.elapsed().as_secs_f64() - (self.total() - booked);
    }

    /// Every phase that took time: its name, and the least, the mean and the most over the ranks, s. Collective.
    pub fn over_ranks(&self, transport: &dyn Transport) -> Vec<(&'static str, [f64; 3])> {
        let all = everyones(&self.seconds, transport);
        let named = NAMES.iter().enumerate().map(|(phase, name)| (*name, spread(all.iter().map(|rank| rank[phase]))));
        named.filter(|(_, [_, mean, _])| *mean > 0.0).collect()
    }

    /// Busy time of the busiest rank over the mean; of no work, one. Collective.
    pub fn imbalance(&self, transport: &dyn Transport) -> f64 {
        let all = everyones(&[self.busy()], transport);
        let [_, mean, most] = spread(all.iter().map(|rank| rank[0]));
        if mean > 0.0 { most / mean } else { 1.0 }
    }

    /// Books `seconds` of passes over pairs and segments: the grains' part of them is motion.
    pub fn split(&mut self, seconds: f64, passed: &Passed) {
        self.seconds[Phase::Contacts as usize] += seconds - passed.grains;
        self.seconds[Phase::Motion as usize] += passed.grains;
    }

    /// Books the time since `since`.
    pub fn stop(&mut self, phase: Phase, since: Instant) {
        self.seconds[phase as usize] += since.elapsed().as_secs_f64();
    }
}

/// The numbers of all ranks, by rank. Collective.
pub fn everyones(mine: &[f64], transport: &dyn Transport) -> Vec<Vec<f64>> {
    let mine: Vec<u8> = mine.iter().flat_map(|number| number.to_le_bytes()).collect();
    let numbers = |bytes: &Vec<u8>| bytes.as_chunks().0.iter().map(|chunk| f64::from_le_bytes(*chunk)).collect();
    transport.all_gather(&mine).iter().map(numbers).collect()
}

/// The least, the mean and the most.
fn spread(of: impl Iterator<Item = f64> + Clone) -> [f64; 3] {
    let ranks = of.clone().count() as f64;
    [of.clone().fold(f64::INFINITY, f64::min), of.clone().sum::<f64>() / ranks, of.fold(0.0, f64::max)]
}
