//! Where a persistent shear band is: Chen et al. (2021), section 3 and Algorithm 1.
//!
//! A node is flagged where the plastic strain rate e bends sharply and has lately been at work:
//!
//! ```text
//! |lap e| / max_neighbours e > min(c_0/D50^2, c_0/dX^2)   and   recent plastic strain > c_1
//! ```
//!
//! and the flagged set is a band once it has not changed for a while, or by no more than a share from look to look. Both windows, tau_l = c_l/rate_max and
//! tau_g = c_g/rate_max, are measured here on the *strain clock*, the integral of rate_max dt, where rate_max is the
//! largest plastic strain rate in the domain: rate independent by construction. The rate itself is the mean over the
//! interval between two looks, since the instantaneous rate of an explicit step mostly shows its waves.

use crate::base::keys::{Form, NOT_NEGATIVE, POSITIVE, RATIO, Range, count, number};
use crate::mpm::track::LOOKS;

/// Looks within the window c_l.
const LOOKS_PER_WINDOW: f64 = 8.0;

/// The strain clock over that at which a band was refused when it may be found again.
const REFUSED_FOR: f64 = 1.25;

/// Shear band detection (Chen et al. 2021, section 3, Algorithm 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oracle {
    /// c_0: threshold of the Laplacian.
    pub laplacian: f64,
    /// c_1: plastic strain within the recent window.
    pub recent_strain: f64,
    /// c_l: length of the recent window in strain of the fastest point.
    pub window: f64,
    /// c_g: strain of the fastest point over which the flagged set must stay as it is.
    pub persistence: f64,
    /// Share of the flagged set that may have come and gone from one look to the next without its having changed; 0 in Chen et al. (2021).
    pub tolerance: f64,
    /// Steps between two looks.
    pub every: u64,
}

impl Oracle {
    /// Table 4 of Chen et al. (2021): planar shear.
    pub const OF_SHEAR: Self =
        Self { laplacian: 1e-6, recent_strain: 1e-4, window: 8e-4, persistence: 1.2e-3, tolerance: 0.0, every: 1 };
    /// Tables 6 and 9 of Chen et al. (2021): the triaxial test and indentation.
    pub const OF_GRID: Self =
        Self { laplacian: 1e-6, recent_strain: 8e-3, window: 2e-2, persistence: 9.6e-3, tolerance: 0.0, every: 1 };

    /// The keys of `[oracle]`; `every` steps between two looks follow from the window and from steps by default.
    pub fn keys(&mut self, form: &mut dyn Form, every: impl Fn(f64) -> u64) {
        let chen = "that of Chen et al. (2021), Tables 4, 6 and 9";
        form.number(&mut self.laplacian, number("laplacian", "c_0", RATIO, POSITIVE, "1e-6").follows(chen));
        form.number(&mut self.recent_strain, number("recent_strain", "c_1", RATIO, NOT_NEGATIVE, "8e-3").follows(chen));
        form.number(&mut self.window, number("window", "c_l", RATIO, POSITIVE, "2e-2").follows(chen));
        form.number(&mut self.persistence, number("persistence", "c_g", RATIO, POSITIVE, "9.6e-3").follows(chen));
        let about = "the share of flagged nodes that may come and go from look to look";
        form.number(&mut self.tolerance, number("tolerance", about, RATIO, Range::closed(0.0, 0.5), "0.1").or("0.0"));
        if form.is_needed() && !form.has("every") {
            self.every = every(self.window);
        }
        let key = count("every", "steps between two looks", (1, 1_000_000_000), "50");
        form.count(&mut self.every, key.follows("twenty steps of the continuum, or sixteen looks in a window"));
    }
}

/// What the oracle remembers; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// The strain clock now.
    pub clock: f64,
    /// Looks taken; the strain clock at the last of them by slot.
    pub looks: u64,
    pub clocks: [f64; LOOKS],
    /// Flagged nodes of the last look, by their index in the domain, rising, and the strain clock since when, or until when a band that was
    /// refused is not asked for.
    pub flagged: Vec<u64>,
    pub unchanged_since: f64,
}

impl Memory {
    /// Slot of the last look taken, none before the first.
    pub fn slot_last(&self) -> Option<usize> {
        (self.looks > 0).then(|| ((self.looks - 1) % LOOKS as u64) as usize)
    }

    /// Whether the fastest point's plastic strain since the last look makes it time for another.
    pub fn due(&self, increment_max: f64, settings: &Oracle) -> bool {
        increment_max >= settings.window / LOOKS_PER_WINDOW
    }

    /// Turns the clock for a look; returns the slot the look goes into and the slot where its window begins, which is
    /// none while the run is younger than the window.
    pub fn look(&mut self, increment_max: f64, settings: &Oracle) -> (usize, Option<usize>) {
        self.clock += increment_max;
        let begin = (0..self.looks.min(LOOKS as u64))
            .map(|back| ((self.looks - 1 - back) % LOOKS as u64) as usize)
            .find(|slot| self.clocks[*slot] <= self.clock - settings.window);
        let slot = (self.looks % LOOKS as u64) as usize;
        self.clocks[slot] = self.clock;
        self.looks += 1;
        (slot, begin)
    }

    /// A band that has been found can have no zone. It is not one again until the fastest point has sheared by a quarter more in all: tried
    /// again soon after an early mistake, and not at every look for ever.
    pub fn refuse(&mut self) {
        self.flagged.clear();
        self.unchanged_since = REFUSED_FOR * self.clock;
    }

    /// Takes in the flagged set of a look, rising; true once it is not empty and has stayed as it is for c_g, but for the share
    /// of it that may have come and gone since the look before: the more nodes a band has, the likelier one of them is at the
    /// threshold. A set that wanders by less than that from look to look stands, as far as this can tell.
    pub fn persists(&mut self, flagged: Vec<u64>, settings: &Oracle) -> bool {
        let common = flagged.iter().filter(|node| self.flagged.binary_search(node).is_ok()).count();
        let changed = flagged.len() + self.flagged.len() - 2 * common;
        if self.flagged.is_empty() && !flagged.is_empty() || changed as f64 > settings.tolerance * flagged.len() as f64
        {
            self.unchanged_since = self.unchanged_since.max(self.clock);
        }
        self.flagged = flagged;
        !self.flagged.is_empty() && self.clock - self.unchanged_since >= settings.persistence
    }
}

/// Plastic strain on the nodes of the whole domain: periodic in x, row by row in y.
#[derive(Clone, Debug)]
pub struct NodeFields {
    /// Nodes per axis.
    pub counts: [usize; 2],
    /// Whether a node carries mass.
    pub present: Vec<bool>,
    /// Plastic strain since the last look (rate times a constant) and within the window.
    pub rate: Vec<f64>,
    pub recent: Vec<f64>,
}

impl NodeFields {
    pub fn empty(counts: [usize; 2]) -> Self {
        let nodes = counts[0] * counts[1];
        Self { counts, present: vec![false; nodes], rate: vec![0.0; nodes], recent: vec![0.0; nodes] }
    }

    /// Index of the node beside `(i, j)`, across the period in x; none outside in y or where there is no material.
    fn beside(&self, i: usize, j: usize, step: [i64; 2]) -> Option<usize> {
        let [columns, rows] = self.counts;
        let column = (i as i64 + step[0]).rem_euclid(columns as i64) as usize;
        let row = j as i64 + step[1];
        if row < 0 || row >= rows as i64 {
            return None;
        }
        let node = row as usize * columns + column;
        self.present[node].then_some(node)
    }

    /// dX^2 times the Laplacian of the rate; beyond the material the rate goes on level.
    fn laplacian(&self, i: usize, j: usize) -> f64 {
        let here = self.rate[j * self.counts[0] + i];
        let mut sum = 0.0;
        for step in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
            sum += self.beside(i, j, step).map_or(0.0, |node| self.rate[node] - here);
        }
        sum
    }

    fn rate_max_around(&self, i: usize, j: usize) -> f64 {
        let mut max = 0.0f64;
        for y in -1..=1 {
            for x in -1..=1 {
                max = max.max(self.beside(i, j, [x, y]).map_or(0.0, |node| self.rate[node]));
            }
        }
        max
    }

    /// Flagged nodes, rising. `cell` and `diameter` (D50) in m.
    pub fn flagged(&self, settings: &Oracle, cell: f64, diameter: f64) -> Vec<u64> {
        // Both thresholds times dX^2.
        let threshold = settings.laplacian * (cell * cell / (diameter * diameter)).min(1.0);
        let mut flagged = Vec::new();
        for j in 0..self.counts[1] {
            for i in 0..self.counts[0] {
                let node = j * self.counts[0] + i;
                let max = self.rate_max_around(i, j);
                let works = self.present[node] && max > 0.0 && self.recent[node] > settings.recent_strain;
                if works && self.laplacian(i, j).abs() > threshold * max {
                    flagged.push(node as u64);
                }
            }
        }
        flagged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_that_was_refused_is_found_again_once_a_quarter_more_has_been_sheared() {
        let settings = Oracle { persistence: 0.01, ..Oracle::OF_SHEAR };
        let mut memory = Memory::default();
        let mut found = Vec::new();
        for look in 0..1000 {
            memory.clock = 0.001 * f64::from(look);
            if memory.persists(vec![3, 4, 5], &settings) {
                found.push(memory.clock);
                memory.refuse();
            }
        }
        assert!((found[0] - 0.01).abs() < 1e-12, "{found:?}");
        for pair in found.windows(2) {
            let wanted = REFUSED_FOR * pair[0] + settings.persistence;
            assert!((pair[1] - wanted).abs() < 1.5e-3, "{found:?}");
        }
        assert!(found.len() > 8 && found.len() < 15, "{found:?}");
    }
}
