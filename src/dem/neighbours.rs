//! Which pairs of grains may touch before the next rebuild, and which pairs each grain sums over.

use crate::dem::cell::{Cell, ImageCode};
use crate::dem::grains::{Grains, Mover};
use crate::ids::Row;
use crate::lane::LANES;
use crate::space::{Linear, Space};

/// A pair that may touch: `a` has the lower id. Separation is `x_a - x_b + shift(image)`, the image a small integer that
/// is the same on every rank, so that the bits are the same too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    pub a: Row,
    /// Row of `b` below, the image's code in the upper five bits.
    b_and_image: u32,
}

const IMAGE_BITS: u32 = 5;
/// Rows that a rank can hold.
pub const ROWS_MAX: usize = 1 << (32 - IMAGE_BITS);

impl Pair {
    fn new(a: Row, b: Row, image: ImageCode) -> Self {
        Self { a, b_and_image: b | u32::from(image.0) << (32 - IMAGE_BITS) }
    }
    #[inline(always)]
    pub fn b(self) -> Row {
        self.b_and_image & (ROWS_MAX as u32 - 1)
    }
    #[inline(always)]
    pub fn image(self) -> ImageCode {
        ImageCode((self.b_and_image >> (32 - IMAGE_BITS)) as u8)
    }
}

/// One term of a grain's sum: a pair, and whether the grain is its `b`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term(u32);

impl Term {
    #[inline(always)]
    pub fn pair(self) -> usize {
        (self.0 >> 1) as usize
    }
    #[inline(always)]
    pub fn is_b(self) -> bool {
        self.0 & 1 == 1
    }
}

/// Pairs of this rank, and for every owned row its terms in the order of the partners' ids (invariant 2).
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    /// Pairs within the segments, segment by segment, then pairs across owned rows, then those with copies. Every segment
    /// and part is a whole number of packs, filled up with copies of its last pair that nobody sums.
    pub pairs: Vec<Pair>,
    /// Pairs before the end of each segment.
    pub segment_ends: Vec<u32>,
    /// Whether a row of the segment has a pair with a copy.
    pub on_border: Vec<bool>,
    /// Pairs before the first that needs a copy.
    pub border: usize,
    /// Terms of row i are `terms[starts[i]..starts[i + 1]]`.
    pub starts: Vec<u32>,
    pub terms: Vec<Term>,
}

/// Rows of a segment: what its pairs, forces and grains take fits a second-level cache. A constant, so that nothing
/// depends on the number of threads.
pub const SEGMENT: usize = 1024;

/// Bins over the cell by counting sort: `rows[starts[bin]..starts[bin + 1]]`.
struct Bins {
    counts: [usize; 3],
    periodic: [bool; 3],
    /// Up to this distance no other image is nearer than the one at hand, m.
    far: f64,
    starts: Vec<u32>,
    rows: Vec<Row>,
}

impl Bins {
    fn new<S: Space>(grains: &Grains<S>, cell: &Cell<S>, reach: f64) -> Self {
        let mut counts = [1; 3];
        for (axis, count) in counts.iter_mut().enumerate().take(S::DIMENSION) {
            *count = ((cell.height(axis) / reach) as usize).max(1);
        }
        let total = counts.iter().product::<usize>();
        let heights = (0..S::DIMENSION).filter(|axis| cell.periodic[*axis]).map(|axis| cell.height(axis));
        let far = 0.5 * heights.fold(f64::INFINITY, f64::min);
        let mut bins = Self { counts, periodic: cell.periodic, far, starts: vec![0; total + 1], rows: Vec::new() };
        let places: Vec<u32> = grains.cold.iter().map(|cold| bins.index(bins.place(cell, &cold.home)) as u32).collect();
        for &place in &places {
            bins.starts[place as usize + 1] += 1;
        }
        for bin in 0..total {
            bins.starts[bin + 1] += bins.starts[bin];
        }
        let mut next = bins.starts.clone();
        bins.rows = vec![0; places.len()];
        for (row, &place) in places.iter().enumerate() {
            bins.rows[next[place as usize] as usize] = row as Row;
            next[place as usize] += 1;
        }
        bins
    }

    fn place<S: Space>(&self, cell: &Cell<S>, home: &S::Vector) -> [usize; 3] {
        let fraction = cell.fraction(home);
        let mut place = [0; 3];
        for axis in 0..S::DIMENSION {
            let at = (fraction[axis] * self.counts[axis] as f64).max(0.0) as usize;
            place[axis] = at.min(self.counts[axis] - 1);
        }
        place
    }

    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.counts[1] + place[1]) * self.counts[0] + place[0]
    }

    /// Places beside and at `at` along an axis, each once.
    fn beside(&self, axis: usize, at: usize) -> ([usize; 3], usize) {
        let count = self.counts[axis];
        if self.periodic[axis] && count >= 3 {
            return ([(at + count - 1) % count, at, (at + 1) % count], 3);
        }
        let (first, last) = (at.saturating_sub(1), (at + 1).min(count - 1));
        ([first, first + 1, last], last - first + 1)
    }

    /// Calls `visit` with every row of the bins around a place.
    fn around(&self, place: [usize; 3], mut visit: impl FnMut(Row)) {
        let [(xs, nx), (ys, ny), (zs, nz)] = [0, 1, 2].map(|axis| self.beside(axis, place[axis]));
        for &z in &zs[..nz] {
            for &y in &ys[..ny] {
                for &x in &xs[..nx] {
                    let bin = self.index([x, y, z]);
                    let rows = self.starts[bin] as usize..self.starts[bin + 1] as usize;
                    self.rows[rows].iter().for_each(|row| visit(*row));
                }
            }
        }
    }
}

impl Neighbours {
    /// Lists every pair closer than contact plus `margin` at the home positions, of which at least one is owned.
    pub fn build<S: Space>(&mut self, grains: &Grains<S>, cell: &Cell<S>, margin: f64) {
        assert!(grains.hot.len() < ROWS_MAX, "a rank holds at most {ROWS_MAX} grains and copies; use more ranks");
        let segments = grains.owned.div_ceil(SEGMENT);
        self.segment_ends.clear();
        self.on_border = vec![false; segments];
        let mut listed = Listed::default();
        if !grains.cold.is_empty() {
            let radius_max = grains.hot.iter().map(|hot| hot.radius).fold(0.0, f64::max);
            let bins = Bins::new(grains, cell, 2.0 * radius_max + margin);
            for segment in 0..segments {
                for row in segment * SEGMENT..((segment + 1) * SEGMENT).min(grains.owned) {
                    list_row(grains, cell, &bins, margin, row, &mut listed);
                }
                fill(&mut listed.within);
                self.segment_ends.push(listed.within.len() as u32);
            }
        }
        let owned = |row: Row| (row as usize) < grains.owned;
        for row in listed.border.iter().flat_map(|pair| [pair.a, pair.b()]).filter(|row| owned(*row)) {
            self.on_border[row as usize / SEGMENT] = true;
        }
        fill(&mut listed.across);
        fill(&mut listed.border);
        self.pairs = listed.within;
        self.pairs.reserve_exact(listed.across.len() + listed.border.len());
        self.pairs.extend(listed.across);
        self.border = self.pairs.len();
        self.pairs.extend(listed.border);
        self.pairs.shrink_to_fit();
        self.list_terms(grains);
    }

    /// Pairs within segments.
    pub fn within(&self) -> usize {
        self.segment_ends.last().map_or(0, |end| *end as usize)
    }

    /// Most pairs of a segment.
    pub fn segment_most(&self) -> usize {
        let starts = std::iter::once(&0).chain(&self.segment_ends);
        self.segment_ends.iter().zip(starts).map(|(end, start)| (end - start) as usize).max().unwrap_or(0)
    }

    fn list_terms<S: Space>(&mut self, grains: &Grains<S>) {
        let pairs = &self.pairs;
        self.starts.clear();
        self.starts.resize(grains.owned + 1, 0);
        for pair in real(pairs) {
            for row in [pair.1.a, pair.1.b()] {
                if (row as usize) < grains.owned {
                    self.starts[row as usize + 1] += 1;
                }
            }
        }
        for row in 0..grains.owned {
            self.starts[row + 1] += self.starts[row];
        }
        let mut next = self.starts.clone();
        self.terms.clear();
        self.terms.resize(self.starts[grains.owned] as usize, Term(0));
        for (index, pair) in real(pairs) {
            for (row, side) in [(pair.a, 0), (pair.b(), 1)] {
                if (row as usize) < grains.owned {
                    self.terms[next[row as usize] as usize] = Term((index as u32) << 1 | side);
                    next[row as usize] += 1;
                }
            }
        }
        for row in 0..grains.owned {
            let terms = &mut self.terms[self.starts[row] as usize..self.starts[row + 1] as usize];
            terms.sort_unstable_by_key(|term| grains.cold[partner(pairs, *term) as usize].id);
        }
    }

    /// Terms of an owned row.
    #[inline(always)]
    pub fn terms_of(&self, row: usize) -> &[Term] {
        &self.terms[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    /// The row on the other side of a term.
    pub fn partner(&self, term: Term) -> Row {
        partner(&self.pairs, term)
    }

    /// Pairs with their index, copies left out.
    pub fn real_pairs(&self) -> impl Iterator<Item = (usize, &Pair)> {
        real(&self.pairs)
    }

    pub fn bytes(&self) -> usize {
        self.pairs.capacity() * size_of::<Pair>()
            + self.starts.capacity() * size_of::<u32>()
            + self.terms.capacity() * size_of::<Term>()
    }
}

fn partner(pairs: &[Pair], term: Term) -> Row {
    let pair = pairs[term.pair()];
    if term.is_b() { pair.a } else { pair.b() }
}

/// Pairs by the parts of the list.
#[derive(Default)]
struct Listed {
    within: Vec<Pair>,
    across: Vec<Pair>,
    border: Vec<Pair>,
}

/// Fills up to whole packs.
fn fill(pairs: &mut Vec<Pair>) {
    if let Some(last) = pairs.last().copied() {
        pairs.resize(pairs.len().next_multiple_of(LANES), last);
    }
}

/// Every pair once: a copy that fills a pack repeats the pair before it, and no pair is in two parts.
fn real(pairs: &[Pair]) -> impl Iterator<Item = (usize, &Pair)> {
    let first = |index: usize| index == 0 || pairs[index - 1] != pairs[index];
    pairs.iter().enumerate().filter(move |(index, _)| first(*index))
}

/// Pairs of an owned row: with owned rows once (from the lower id), with copies always.
fn list_row<S: Space>(grains: &Grains<S>, cell: &Cell<S>, bins: &Bins, margin: f64, row: usize, listed: &mut Listed) {
    let (hot, cold) = (&grains.hot[row], &grains.cold[row]);
    let far = bins.far;
    bins.around(bins.place(cell, &cold.home), |other| {
        let (other_hot, other_cold) = (&grains.hot[other as usize], &grains.cold[other as usize]);
        let lower = cold.id < other_cold.id;
        let owned = (other as usize) < grains.owned;
        if cold.id == other_cold.id || (!lower && owned) {
            return;
        }
        if cold.mover != Mover::Free && other_cold.mover != Mover::Free {
            return;
        }
        let (a, b) = if lower { (cold, other_cold) } else { (other_cold, cold) };
        let mut separation = a.home - b.home;
        let mut code = ImageCode::NONE;
        // Only across the cell can another image be nearer.
        if separation.dot(&separation) > far * far {
            let apart = cell.fraction(&a.home) - cell.fraction(&b.home);
            let mut image = [0; 3];
            for axis in (0..S::DIMENSION).filter(|axis| cell.periodic[*axis]) {
                image[axis] = if apart[axis] > 0.5 { -1 } else { i32::from(apart[axis] < -0.5) };
            }
            separation += cell.shift(image);
            code = ImageCode::of(image);
        }
        let limit = hot.radius + other_hot.radius + margin;
        if separation.dot(&separation) < limit * limit {
            let (a, b) = if lower { (row as Row, other) } else { (other, row as Row) };
            let together = code == ImageCode::NONE && row / SEGMENT == other as usize / SEGMENT;
            let pairs = match (owned, together) {
                (true, true) => &mut listed.within,
                (true, false) => &mut listed.across,
                (false, _) => &mut listed.border,
            };
            pairs.push(Pair::new(a, b, code));
        }
    });
}
