//! Where a shear band is, told from how plastic strain grows on the nodes of the continuum's grid. Two criteria.
//!
//! **Concentration** (the default), in relative terms: in a box of some D50 about a node, r is the plastic strain that its nodes have gained within the window,
//!
//! ```text
//! P = (sum r)^2/(n sum r^2)                               participation of the box's n nodes: 1 if even, w/L of a band w wide in a box L long
//! lowest P of all boxes < s (lowest P a window ago)                                    shear sharpens, at this look or at one before
//! P < P_max,  c < c_max mean of the box,  r > xi c,  r > window                        the node is of a band of that box,
//! largest s of these - mean s of the calmer half > excess                              which has softened, and they are flagged
//! ```
//!
//! with c the mean of r over the calmer half of the box, and s all plastic strain of a node. Until what is beside it unloads the place of a band is not settled. Until it has softened by more
//! than one packing of the same grains differs from another, grains of its place may be stronger than the continuum that they leave beside them, and a zone of theirs would drive the band
//! out.
//!
//! It takes a law that hardens before it softens: of one that is elastic up to its cone plastic strain is in the band from the first on, and nothing sharpens. Bands sharpen where material
//! softens; what is weaker at the start and hardens with shear gathers its strain slowly, if it does. Boxes are cut where material ends, and those that shear at less than a quarter of the
//! fastest rate of any box until then do not count. The strain clock is the integral of the largest mean of a box.
//!
//! **Laplacian**: Chen et al. (2021), section 3 and Algorithm 1. A node is flagged where the plastic strain rate e bends sharply and has lately been at work:
//!
//! ```text
//! |lap e| / max_neighbours e > min(c_0/D50^2, c_0/dX^2)   and   recent plastic strain > c_1
//! ```
//!
//! and the flagged set is a band once it has not changed for a while, or by no more than a share from look to look. Its strain clock is the integral of the largest plastic strain rate
//! of any point, so that its windows are tau_l = c_l/rate_max and tau_g = c_g/rate_max.
//!
//! Both are rate independent: windows are measured on the strain clock. Strain is what was gained between two looks, since the instantaneous rate of an explicit step
//! mostly shows its waves.

use crate::base::keys::{Form, NOT_NEGATIVE, POSITIVE, RATIO, Range, count, number, text, variant};
use crate::mpm::track::LOOKS;

/// The strain clock over that at which a band was refused when it may be found again.
const REFUSED_FOR: f64 = 1.25;
/// Of the fastest rate of any box so far; slower boxes do not count.
const PACE_LEAST: f64 = 0.25;

/// Shear band detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oracle {
    /// With its constants: the key `criterion` and those beside it.
    pub criterion: Criterion,
    /// Steps between two looks.
    pub every: u64,
}

/// What a band is told by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// "concentration": shear gathers in a part of its box, and has sharpened.
    Concentration(Concentration),
    /// "laplacian": the rate of plastic strain bends sharply.
    Laplacian(Laplacian),
}

/// By how shear concentrates in boxes of some grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Concentration {
    /// Mean strain of the box that shears most over which growth is taken.
    pub window: f64,
    /// From the middle of a box to its sides, D50.
    pub reach: f64,
    /// P_max: participation below which a box has a band.
    pub participation: f64,
    /// xi: growth over that of the calmer half of the box.
    pub contrast: f64,
    /// s: what participation falls to within a window where a band sharpens.
    pub sharpening: f64,
    /// c_max: growth of the calmer half of the box, over that of all of it, below which it stands still.
    pub calm: f64,
    /// By how much more plastic strain a band has than the calmer half of its box.
    pub excess: f64,
}

/// Chen et al. (2021), section 3, Algorithm 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laplacian {
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
}

impl Concentration {
    /// Of `[oracle]` where a job says nothing else.
    pub const DEFAULT: Self = Self {
        window: 2e-3,
        reach: 20.0,
        participation: 0.6,
        contrast: 2.0,
        sharpening: 0.8,
        calm: 0.05,
        excess: 6e-2,
    };

    fn keys(&mut self, form: &mut dyn Form) {
        let window = number("window", "mean strain of a box over which growth is taken", RATIO, POSITIVE, "2e-3");
        form.number(&mut self.window, window.or("2e-3"));
        let about = "from the middle of a box to its sides, in D50";
        form.number(&mut self.reach, number("reach", about, RATIO, Range::closed(1.0, 1000.0), "20.0").or("20.0"));
        let about = "P_max, the participation below which a box has a band";
        let within = Range::open(0.0, 1.0);
        form.number(&mut self.participation, number("participation", about, RATIO, within, "0.6").or("0.6"));
        let about = "xi, growth over that of the calmer half of a box";
        form.number(&mut self.contrast, number("contrast", about, RATIO, Range::closed(1.0, 1e6), "2.0").or("2.0"));
        let about = "s, what participation falls to within a window as a band sharpens";
        form.number(&mut self.sharpening, number("sharpening", about, RATIO, within, "0.8").or("0.8"));
        let about = "c_max, growth of the calmer half of a box over that of all of it, below which it stands still";
        form.number(&mut self.calm, number("calm", about, RATIO, Range::closed(0.0, 1.0), "0.05").or("0.05"));
        let about = "plastic strain that a band has beyond the calmer half of its box";
        form.number(&mut self.excess, number("excess", about, RATIO, NOT_NEGATIVE, "6e-2").or("6e-2"));
    }
}

impl Laplacian {
    /// Keys that no other criterion has.
    const KEYS: [&str; 4] = ["laplacian", "recent_strain", "persistence", "tolerance"];
    /// Table 4 of Chen et al. (2021): planar shear.
    pub const OF_SHEAR: Self =
        Self { laplacian: 1e-6, recent_strain: 1e-4, window: 8e-4, persistence: 1.2e-3, tolerance: 0.0 };
    /// Tables 6 and 9 of Chen et al. (2021): the triaxial test and indentation.
    pub const OF_GRID: Self =
        Self { laplacian: 1e-6, recent_strain: 8e-3, window: 2e-2, persistence: 9.6e-3, tolerance: 0.0 };

    fn keys(&mut self, form: &mut dyn Form) {
        let chen = "that of Chen et al. (2021), Tables 4, 6 and 9";
        form.number(&mut self.laplacian, number("laplacian", "c_0", RATIO, POSITIVE, "1e-6").follows(chen));
        form.number(&mut self.recent_strain, number("recent_strain", "c_1", RATIO, NOT_NEGATIVE, "8e-3").follows(chen));
        form.number(&mut self.window, number("window", "c_l", RATIO, POSITIVE, "2e-2").follows(chen));
        form.number(&mut self.persistence, number("persistence", "c_g", RATIO, POSITIVE, "9.6e-3").follows(chen));
        let about = "the share of flagged nodes that may change between two evaluations";
        form.number(&mut self.tolerance, number("tolerance", about, RATIO, Range::closed(0.0, 0.5), "0.1").or("0.0"));
    }
}

impl Oracle {
    /// By the default criterion, a look after every step.
    pub const DEFAULT: Self = Self { criterion: Criterion::Concentration(Concentration::DEFAULT), every: 1 };

    /// Length of the criterion's window on its strain clock.
    pub fn window(&self) -> f64 {
        match &self.criterion {
            Criterion::Concentration(by) => by.window,
            Criterion::Laplacian(by) => by.window,
        }
    }

    /// The keys of `[oracle]`: constants of Chen et al. (2021) are by default those of `chen`. What `every` follows from, a job knows.
    pub fn keys(&mut self, form: &mut dyn Form, chen: Laplacian) {
        let kinds = [
            ("concentration", Criterion::Concentration(Concentration::DEFAULT)),
            ("laplacian", Criterion::Laplacian(chen)),
        ];
        // Jobs of old have the Laplacian's keys and do not name it.
        if !form.has("criterion") && Laplacian::KEYS.iter().any(|key| form.has(key)) {
            self.criterion = Criterion::Laplacian(chen);
        }
        let key = text("criterion", "what a band is told by", "\"concentration\"");
        let key = key.follows("concentration, and laplacian where one of the keys of that one alone is there");
        variant(form, &mut self.criterion, "criterion", key, &kinds, |criterion, form| match criterion {
            Criterion::Concentration(by) => by.keys(form),
            Criterion::Laplacian(by) => by.keys(form),
        });
        let key = count("every", "steps between two evaluations", (1, 1_000_000_000), "50");
        form.count(&mut self.every, key.follows("twenty steps of the continuum, or sixteen evaluations in a window"));
    }
}

/// What a look has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Lowest participation of all boxes; 0 where none counts.
    pub participation: f64,
    /// Strain of the fastest point since the look before over the strain clock's.
    pub fastest: f64,
    /// Fastest rate of any box until then, 1/s, and the time, s.
    pub pace: f64,
    /// s, of the look itself.
    pub time: f64,
}

/// What the oracle remembers; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// The strain clock now.
    pub clock: f64,
    /// Looks taken; by slot, the strain clock at the last of them and what they have seen, the latter of the criterion of concentration alone.
    pub looks: u64,
    /// By slot, the strain clock at the look taken there.
    pub clocks: [f64; LOOKS],
    /// By slot, what that look has seen; blank where the criterion is the Laplacian.
    pub seen: [Look; LOOKS],
    /// Flagged nodes of the last look, by their index in the domain, rising, and the strain clock since when, or until when a band that was
    /// found is not asked for again; of concentration since when it has sharpened, 0 before that, or the latter.
    pub flagged: Vec<u64>,
    /// On the strain clock; ahead of it while a band that was found is not asked for again.
    pub unchanged_since: f64,
}

impl Memory {
    /// Slot of the last look taken, none before the first.
    pub fn slot_last(&self) -> Option<usize> {
        (self.looks > 0).then(|| ((self.looks - 1) % LOOKS as u64) as usize)
    }

    /// The last look, as the criterion of concentration has it.
    fn last(&self) -> Look {
        self.slot_last().map_or(Look::default(), |slot| self.seen[slot])
    }

    /// Whether the fastest point's plastic strain since the last look makes it time for another: some looks within a window.
    pub fn due(&self, fastest: f64, settings: &Oracle) -> bool {
        match &settings.criterion {
            Criterion::Laplacian(by) => fastest >= by.window / 8.0,
            Criterion::Concentration(by) => fastest >= by.window / 4.0 * self.last().fastest.max(1.0),
        }
    }

    /// Turns the clock for a look; returns the slot the look goes into and the slot where its window begins, which is
    /// none while the run is younger than the window.
    pub fn look(&mut self, increment: f64, settings: &Oracle) -> (usize, Option<usize>) {
        self.clock += increment;
        let begin = (0..self.looks.min(LOOKS as u64))
            .map(|back| ((self.looks - 1 - back) % LOOKS as u64) as usize)
            .find(|slot| self.clocks[*slot] <= self.clock - settings.window());
        let slot = (self.looks % LOOKS as u64) as usize;
        self.clocks[slot] = self.clock;
        self.looks += 1;
        (slot, begin)
    }

    /// A band that has been found can have no zone. It is not one again until the strain clock is a quarter further: tried
    /// again soon after an early mistake, and not at every look for ever.
    pub fn refuse(&mut self) {
        self.flagged.clear();
        self.unchanged_since = REFUSED_FOR * self.clock;
    }

    /// Takes in the flagged set of a look by the Laplacian, rising; true once it is not empty and has stayed as it is for c_g, but for the share
    /// of it that may have come and gone since the look before: the more nodes a band has, the likelier one of them is at the
    /// threshold. A set that wanders by less than that from look to look stands, as far as this can tell.
    pub fn persists(&mut self, flagged: Vec<u64>, by: &Laplacian) -> bool {
        let common = flagged.iter().filter(|node| self.flagged.binary_search(node).is_ok()).count();
        let changed = flagged.len() + self.flagged.len() - 2 * common;
        if self.flagged.is_empty() && !flagged.is_empty() || changed as f64 > by.tolerance * flagged.len() as f64 {
            self.unchanged_since = self.unchanged_since.max(self.clock);
        }
        self.flagged = flagged;
        !self.flagged.is_empty() && self.clock - self.unchanged_since >= by.persistence
    }

    /// A look at a time, s: what the strain clock and the fastest point have gained since the one in slot `last`.
    pub fn see(&mut self, slot: usize, last: Option<usize>, [increment, fastest, time]: [f64; 3]) {
        let before = last.map_or(Look::default(), |last| self.seen[last]);
        let rate = if time > before.time { increment / (time - before.time) } else { 0.0 };
        let fastest = if increment > 0.0 { fastest / increment } else { 1.0 };
        self.seen[slot] = Look { participation: 0.0, fastest, pace: before.pace.max(rate), time };
    }

    /// Mean growth of a box from the look in slot `begin` to that in `slot` from which on it counts.
    pub fn growth_least(&self, slot: usize, begin: usize) -> f64 {
        PACE_LEAST * self.seen[slot].pace * (self.seen[slot].time - self.seen[begin].time)
    }

    /// Takes in the flagged set of a look by concentration, rising, whose window began with that of slot `begin`; true where it is a band, shear having sharpened by now. A
    /// band is one again, where it is not all grains by then, a window later.
    pub fn sharpens(&mut self, flagged: Vec<u64>, begin: usize, by: &Concentration) -> bool {
        let (now, then) = (self.last().participation, self.seen[begin].participation);
        self.flagged = flagged;
        if self.unchanged_since == 0.0 && now > 0.0 && now <= by.sharpening * then {
            self.unchanged_since = self.clock;
        }
        let has_sharpened = self.unchanged_since > 0.0;
        if self.flagged.is_empty() || !has_sharpened || self.clock < self.unchanged_since {
            return false;
        }
        self.unchanged_since = self.clock + by.window;
        true
    }
}

/// Plastic strain on the nodes of the whole domain: periodic in x, row by row in y.
#[derive(Clone, Debug)]
pub struct NodeFields {
    /// Nodes per axis.
    pub counts: [usize; 2],
    /// Whether a node carries mass.
    pub present: Vec<bool>,
    /// Whether the first is beside the last along x.
    pub is_periodic: bool,
    /// Plastic strain since the last look (rate times a constant), or for concentration all of it, and within the window.
    pub rate: Vec<f64>,
    /// Plastic strain gained within the window, by node.
    pub recent: Vec<f64>,
}

impl NodeFields {
    /// Periodic along x, no node with material; nodes along x and y are given.
    pub fn empty(counts: [usize; 2]) -> Self {
        let nodes = counts[0] * counts[1];
        let (rate, recent) = (vec![0.0; nodes], vec![0.0; nodes]);
        Self { counts, present: vec![false; nodes], is_periodic: true, rate, recent }
    }

    /// Index of the node beside `(i, j)`, across the period in x; none outside in y or where there is no material.
    fn beside(&self, i: usize, j: usize, step: [i64; 2]) -> Option<usize> {
        let [columns, rows] = self.counts;
        let column = (i as i64 + step[0]).rem_euclid(columns as i64) as usize;
        let row = j as i64 + step[1];
        // Elsewhere there is no material in the last column and beyond.
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

    /// Nodes with material in the box that reaches so many nodes from `(i, j)`, each once.
    fn in_box(&self, [i, j]: [usize; 2], reach: usize) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.counts.map(|count| count as i64);
        let (i, j, reach) = (i as i64, j as i64, reach as i64);
        let across = match self.is_periodic && 2 * reach + 1 >= columns {
            true => 0..columns,
            false => i - reach..i + reach + 1,
        };
        let is_periodic = self.is_periodic;
        let column = move |at: i64| match is_periodic {
            true => Some(at.rem_euclid(columns)),
            false => (0..columns).contains(&at).then_some(at),
        };
        ((j - reach).max(0)..(j + reach + 1).min(rows))
            .flat_map(move |row| across.clone().filter_map(column).map(move |column| (row * columns + column) as usize))
            .filter(|node| self.present[*node])
    }

    /// Largest mean of a box of `values` over the nodes with material.
    pub fn fastest_box(&self, values: &[f64], reach: usize) -> f64 {
        let mean = |at: [usize; 2]| {
            let (sum, count) = self.in_box(at, reach).fold((0.0, 0), |(sum, n), node| (sum + values[node], n + 1));
            sum / count as f64
        };
        self.places().map(mean).fold(0.0, f64::max)
    }

    /// Places of the nodes with material.
    fn places(&self) -> impl Iterator<Item = [usize; 2]> {
        let columns = self.counts[0];
        (0..self.present.len()).filter(|node| self.present[*node]).map(move |node| [node % columns, node / columns])
    }

    /// The flagged nodes, rising, and the lowest participation of boxes that reach so many nodes and whose mean growth is at least `least`; 0 where there is none.
    pub fn concentrated(&self, by: &Concentration, reach: usize, least: f64) -> (Vec<u64>, f64) {
        let mut is_flagged = vec![false; self.present.len()];
        let (mut lowest, mut nodes) = (0.0, Vec::new());
        for at in self.places() {
            nodes.clear();
            nodes.extend(self.in_box(at, reach));
            let count = nodes.len() as f64;
            let growths = nodes.iter().map(|node| self.recent[*node]);
            let (sum, squares) = growths.fold((0.0, 0.0), |(sum, squares), r| (sum + r, squares + r * r));
            if sum <= 0.0 || sum < least * count {
                continue;
            }
            let participation = sum * sum / (count * squares);
            lowest = if lowest > 0.0 { participation.min(lowest) } else { participation };
            if participation >= by.participation {
                continue;
            }
            nodes.sort_by(|a, b| self.recent[*a].total_cmp(&self.recent[*b]).then(a.cmp(b)));
            let (calm, rest) = nodes.split_at((nodes.len() / 2).max(1));
            let mean = |of: &[f64]| calm.iter().map(|node| of[*node]).sum::<f64>() / calm.len() as f64;
            let bound = (by.contrast * mean(&self.recent)).max(by.window);
            let band = &rest[rest.partition_point(|node| self.recent[*node] <= bound)..];
            let most = band.iter().map(|node| self.rate[*node]).fold(0.0, f64::max);
            if mean(&self.recent) <= by.calm * sum / count && most - mean(&self.rate) > by.excess {
                band.iter().for_each(|node| is_flagged[*node] = true);
            }
        }
        let flagged = (0..is_flagged.len() as u64).filter(|node| is_flagged[*node as usize]).collect();
        (flagged, lowest)
    }

    /// Flagged nodes of the Laplacian, rising. `cell` and `diameter` (D50) in m.
    pub fn flagged(&self, settings: &Laplacian, cell: f64, diameter: f64) -> Vec<u64> {
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
        let settings = Laplacian { persistence: 0.01, ..Laplacian::OF_SHEAR };
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
