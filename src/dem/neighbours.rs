//! Which pairs of grains may touch before the next rebuild, and which pairs each grain sums over.

use crate::dem::grains::{Grains, Mover};
use crate::ids::Row;
use crate::space::{Linear, Space};

/// A pair that may touch: `a` has the lower id. Separation is `x_a - x_b + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<S: Space> {
    pub a: Row,
    pub b: Row,
    /// Whole periods between the two as listed, m: the same integer image on every rank, so the same bits.
    pub shift: S::Vector,
}

/// One term of a grain's sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    pub pair: u32,
    /// The grain is the pair's `a` (force as computed) or `b` (force negated).
    pub is_a: bool,
}

/// Pairs of this rank, and for every owned row its terms in the order of the partners' ids (invariant 2).
#[derive(Clone, Debug)]
pub struct Neighbours<S: Space> {
    pub pairs: Vec<Pair<S>>,
    /// Terms of row i are `terms[starts[i]..starts[i + 1]]`.
    pub starts: Vec<u32>,
    pub terms: Vec<Term>,
}

impl<S: Space> Default for Neighbours<S> {
    fn default() -> Self {
        Self { pairs: Vec::new(), starts: vec![0], terms: Vec::new() }
    }
}

/// Bins over home positions, by counting sort: `rows[starts[bin]..starts[bin + 1]]`.
struct Bins {
    counts: [usize; 2],
    lower: f64,
    edge: [f64; 2],
    starts: Vec<u32>,
    rows: Vec<Row>,
}

impl Bins {
    fn new<S: Space>(grains: &Grains<S>, period: f64, reach: f64) -> Self {
        let (mut lower, mut upper) = (f64::INFINITY, f64::NEG_INFINITY);
        for cold in &grains.cold {
            lower = lower.min(cold.home[1]);
            upper = upper.max(cold.home[1]);
        }
        let count = |length: f64| ((length / reach) as usize).max(1);
        let counts = [count(period), count(upper - lower)];
        let edge = [period / counts[0] as f64, ((upper - lower) / counts[1] as f64).max(reach)];
        let mut bins = Self { counts, lower, edge, starts: vec![0; counts[0] * counts[1] + 1], rows: Vec::new() };
        let places: Vec<usize> = grains.cold.iter().map(|cold| bins.place(cold.home[0], cold.home[1])).collect();
        for &place in &places {
            bins.starts[place + 1] += 1;
        }
        for bin in 0..bins.starts.len() - 1 {
            bins.starts[bin + 1] += bins.starts[bin];
        }
        let mut next = bins.starts.clone();
        bins.rows = vec![0; places.len()];
        for (row, &place) in places.iter().enumerate() {
            bins.rows[next[place] as usize] = row as Row;
            next[place] += 1;
        }
        bins
    }

    fn column(&self, x: f64) -> usize {
        ((x / self.edge[0]) as usize).min(self.counts[0] - 1)
    }

    fn layer(&self, y: f64) -> usize {
        (((y - self.lower) / self.edge[1]) as usize).min(self.counts[1] - 1)
    }

    fn place(&self, x: f64, y: f64) -> usize {
        self.layer(y) * self.counts[0] + self.column(x)
    }

    /// Columns beside and at `column` across the period, each once.
    fn columns(&self, column: usize) -> impl Iterator<Item = usize> + use<> {
        let count = self.counts[0];
        let (first, number) = if count >= 3 { (column + count - 1, 3) } else { (0, count) };
        (first..first + number).map(move |wanted| wanted % count)
    }
}

impl<S: Space> Neighbours<S> {
    /// Lists every pair closer than contact plus `skin` at the home positions, of which at least one is owned.
    /// `period` is the length of the periodic x axis, m.
    pub fn build(grains: &Grains<S>, period: f64, skin: f64) -> Self {
        let radius_max = grains.hot.iter().map(|hot| hot.radius).fold(0.0, f64::max);
        let reach = 2.0 * radius_max + skin;
        let mut pairs = Vec::with_capacity(4 * grains.owned);
        if !grains.cold.is_empty() {
            let bins = Bins::new(grains, period, reach);
            for row in 0..grains.owned {
                list_row(grains, &bins, period, skin, row, &mut pairs);
            }
        }
        let (starts, terms) = terms_by_partner(grains, &pairs);
        Self { pairs, starts, terms }
    }
}

/// Pairs of an owned row: with owned rows once (from the lower id), with copies always.
fn list_row<S: Space>(grains: &Grains<S>, bins: &Bins, period: f64, skin: f64, row: usize, pairs: &mut Vec<Pair<S>>) {
    let (hot, cold) = (&grains.hot[row], &grains.cold[row]);
    let layer = bins.layer(cold.home[1]);
    for layer in layer.saturating_sub(1)..=(layer + 1).min(bins.counts[1] - 1) {
        for column in bins.columns(bins.column(cold.home[0])) {
            let bin = layer * bins.counts[0] + column;
            for &other in &bins.rows[bins.starts[bin] as usize..bins.starts[bin + 1] as usize] {
                let (other_hot, other_cold) = (&grains.hot[other as usize], &grains.cold[other as usize]);
                let lower = cold.id < other_cold.id;
                if cold.id == other_cold.id || (!lower && (other as usize) < grains.owned) {
                    continue;
                }
                if cold.mover != Mover::Free && other_cold.mover != Mover::Free {
                    continue;
                }
                let (a, b) = if lower { (cold, other_cold) } else { (other_cold, cold) };
                let mut separation = a.home - b.home;
                let mut shift = S::Vector::zero();
                if separation[0] > 0.5 * period {
                    shift[0] = -period;
                } else if separation[0] < -0.5 * period {
                    shift[0] = period;
                }
                separation += shift;
                let limit = hot.radius + other_hot.radius + skin;
                if separation.dot(&separation) < limit * limit {
                    let (a, b) = if lower { (row as Row, other) } else { (other, row as Row) };
                    pairs.push(Pair { a, b, shift });
                }
            }
        }
    }
}

fn terms_by_partner<S: Space>(grains: &Grains<S>, pairs: &[Pair<S>]) -> (Vec<u32>, Vec<Term>) {
    let mut starts = vec![0u32; grains.owned + 1];
    for pair in pairs {
        for row in [pair.a, pair.b] {
            if (row as usize) < grains.owned {
                starts[row as usize + 1] += 1;
            }
        }
    }
    for row in 0..grains.owned {
        starts[row + 1] += starts[row];
    }
    let mut next = starts.clone();
    let mut terms = vec![Term { pair: 0, is_a: true }; starts[grains.owned] as usize];
    for (index, pair) in pairs.iter().enumerate() {
        for (row, is_a) in [(pair.a, true), (pair.b, false)] {
            if (row as usize) < grains.owned {
                terms[next[row as usize] as usize] = Term { pair: index as u32, is_a };
                next[row as usize] += 1;
            }
        }
    }
    for row in 0..grains.owned {
        terms[starts[row] as usize..starts[row + 1] as usize].sort_unstable_by_key(|term| {
            let pair = &pairs[term.pair as usize];
            grains.cold[if term.is_a { pair.b } else { pair.a } as usize].id
        });
    }
    (starts, terms)
}
