//! Which pairs of grains may touch before the next rebuild, and which pairs each grain sums over.

use crate::base::ids::Row;
use crate::base::lane::LANES;
use crate::base::space::{Linear, Space};
use crate::dem::cell::{Cell, ImageCode};
use crate::dem::grains::{Cold, Grains, Mover};

/// A pair that may touch: `a` has the lower id. Separation is `x_a - x_b + shift(image)`, the image a small integer that
/// is the same on every rank, so that the bits are the same too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Pair {
    /// Row of the grain with the lower id.
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
    /// Row of the grain with the higher id.
    #[inline(always)]
    pub fn b(self) -> Row {
        self.b_and_image & (ROWS_MAX as u32 - 1)
    }
    /// Periods by which the separation of the two is shifted.
    #[inline(always)]
    pub fn image(self) -> ImageCode {
        ImageCode((self.b_and_image >> (32 - IMAGE_BITS)) as u8)
    }
    /// The image's code, found from all 64 bits, as lanes are of.
    #[inline(always)]
    pub fn code(self) -> u64 {
        (u64::from(self.a) | u64::from(self.b_and_image) << 32) >> (64 - IMAGE_BITS)
    }
}

/// One term of a grain's sum: a pair, and whether the grain is its `b`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// Index into [`Neighbours::pairs`].
    pub pair: usize,
    /// Whether the grain is the pair's `b`.
    pub is_b: bool,
}

/// Where a term of a grain's sum lies: in which part of the list, and which side of a pair there; or that there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place(u32);

/// Sides of pairs that a part can hold, as bits.
const SIDE_BITS: u32 = 30;
/// Pairs that a rank can hold.
pub const PAIRS_MAX: usize = 1 << (SIDE_BITS - 1);

impl Place {
    /// A pair of the row's segment, counted from the first of these.
    pub const WITHIN: usize = 0;
    /// One that no segment holds alone, counted from the first of these.
    pub const APART: usize = 1;
    /// Parts that [`Self::part`] names; the rest hold nothing.
    pub const PARTS: usize = 4;
    const NOTHING: Self = Self(2 << SIDE_BITS);

    fn new(part: usize, pair: usize, is_b: bool) -> Self {
        Self(((part as u32) << SIDE_BITS) | (2 * pair as u32) | u32::from(is_b))
    }
    /// [`Self::WITHIN`], [`Self::APART`], or anything else for nothing.
    #[inline(always)]
    pub fn part(self) -> usize {
        (self.0 >> SIDE_BITS) as usize
    }
    /// Twice the pair's number in its part, and one more for `b`.
    #[inline(always)]
    pub fn side(self) -> usize {
        (self.0 & ((1 << SIDE_BITS) - 1)) as usize
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
    /// Places of the terms of rows 8i to 8i + 7 are `places[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    /// The first terms of eight rows side by side, then their second ones, and so on until the last of them has no more; those of a row in the order of the
    /// partners' ids. Eight sums grow side by side so that none waits for its last addition. Empty after [`Self::drop_terms`].
    places: Vec<[Place; LANES]>,
    /// Whether all pairs are one part, in the order of the ids of both of their grains; rows stand in that order too and are all owned.
    /// Who adds the forces of pairs up in this order adds for each grain in that of its terms, and needs none of these.
    pub in_order: bool,
    /// Of such a list the pairs without the copies that fill it up, and those that segments of the same rows would list with theirs: by
    /// these a step is costed, as in states of before.
    pub listed: usize,
    /// Pairs as segments would list them, with the copies that fill these up.
    pub counted: usize,
}

/// Rows of a segment: what its pairs, forces and grains take fits a second-level cache. A constant, so that nothing
/// depends on the number of threads.
pub const SEGMENT: usize = 1024;

/// Bins over the cell by counting sort: `rows[starts[bin]..starts[bin + 1]]`. Only patches of bins in which there are rows have any, for a
/// zone may be a thin band in a wide domain.
struct Bins {
    counts: [usize; 3],
    periodic: [bool; 3],
    /// Up to this distance no other image is nearer than the one at hand, m.
    far: f64,
    /// Of every patch, the number of its first bin.
    firsts: Vec<u32>,
    starts: Vec<u32>,
    rows: Vec<Row>,
}

/// Bins of a patch along each axis, if there are so many.
const PATCH: usize = 8;
/// A patch without rows.
const NO_BINS: u32 = u32::MAX;

/// Bins of a patch along each axis, and patches.
fn patches(counts: [usize; 3]) -> [[usize; 3]; 2] {
    [counts.map(|count| count.min(PATCH)), counts.map(|count| count.div_ceil(PATCH))]
}

impl Bins {
    fn new<S: Space>(grains: &Grains<S>, cell: &Cell<S>, reach: f64) -> Self {
        let mut counts = [1; 3];
        for (axis, count) in counts.iter_mut().enumerate().take(S::DIMENSION) {
            *count = ((cell.height(axis) / reach) as usize).max(1);
        }
        let heights = (0..S::DIMENSION).filter(|axis| cell.periodic[*axis]).map(|axis| cell.height(axis));
        let far = 0.5 * heights.fold(f64::INFINITY, f64::min);
        let firsts = vec![NO_BINS; patches(counts)[1].iter().product()];
        let mut bins = Self { counts, periodic: cell.periodic, far, firsts, starts: Vec::new(), rows: Vec::new() };
        for cold in &grains.cold {
            let (patch, _) = bins.patch(bins.place(cell, &cold.home));
            bins.firsts[patch] = 0;
        }
        let mut total = 0;
        for first in bins.firsts.iter_mut().filter(|first| **first != NO_BINS) {
            *first = total;
            total += patches(counts)[0].iter().product::<usize>() as u32;
        }
        bins.starts = vec![0; total as usize + 1];
        let place_of =
            |cold: &Cold<S>| bins.bin(bins.place(cell, &cold.home)).expect("a patch with a row has bins") as u32;
        let places: Vec<u32> = grains.cold.iter().map(place_of).collect();
        for &place in &places {
            bins.starts[place as usize + 1] += 1;
        }
        for bin in 0..total as usize {
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

    /// The patch of a place, and which of its bins is there.
    fn patch(&self, place: [usize; 3]) -> (usize, usize) {
        let [bins, patches] = patches(self.counts);
        let index = |[x, y, z]: [usize; 3], [nx, ny, _]: [usize; 3]| (z * ny + y) * nx + x;
        (index(place.map(|at| at / PATCH), patches), index(place.map(|at| at % PATCH), bins))
    }

    /// The bin of a place, none where its patch has no rows.
    fn bin(&self, place: [usize; 3]) -> Option<usize> {
        let (patch, within) = self.patch(place);
        let first = self.firsts[patch];
        (first != NO_BINS).then_some(first as usize + within)
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
                    let Some(bin) = self.bin([x, y, z]) else { continue };
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
            if self.in_order {
                self.list_in_order(|row, listed| list_row(grains, cell, &bins, margin, row, listed), grains.owned);
                self.list_terms(grains);
                return;
            }
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

    /// Lists pairs in the order of ids; `list` lists those of a row with higher ones.
    fn list_in_order(&mut self, list: impl Fn(usize, &mut Listed), rows: usize) {
        let mut listed = Listed::default();
        self.pairs.clear();
        (self.listed, self.counted) = (0, 0);
        let mut apart = 0;
        for segment in 0..rows.div_ceil(SEGMENT) {
            let mut together = 0;
            for row in segment * SEGMENT..((segment + 1) * SEGMENT).min(rows) {
                let start = self.pairs.len();
                list(row, &mut listed);
                together += listed.within.len();
                apart += listed.across.len();
                self.pairs.append(&mut listed.within);
                self.pairs.append(&mut listed.across);
                self.pairs[start..].sort_unstable_by_key(|pair| pair.b());
            }
            self.counted += usize::next_multiple_of(together, LANES);
        }
        debug_assert!(listed.border.is_empty() && self.pairs.is_sorted_by_key(|pair| [pair.a, pair.b()]));
        self.counted += usize::next_multiple_of(apart, LANES);
        self.listed = self.pairs.len();
        fill(&mut self.pairs);
        self.border = self.pairs.len();
        self.pairs.shrink_to_fit();
    }

    /// Gives up what a list in order needs at rebuilds alone; [`Self::restore_terms`] tells it again.
    pub fn drop_terms(&mut self) {
        debug_assert!(self.in_order);
        (self.starts, self.places, self.on_border) = (Vec::new(), Vec::new(), Vec::new());
    }

    /// The reverse.
    pub fn restore_terms<S: Space>(&mut self, grains: &Grains<S>) {
        if self.starts.is_empty() {
            self.list_terms(grains);
        }
    }

    /// The pairs of a list in order, each once.
    #[inline(always)]
    pub fn pairs_in_order(&self) -> &[Pair] {
        debug_assert!(self.in_order);
        &self.pairs[..self.listed]
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
        assert!(self.pairs.len() <= PAIRS_MAX, "a rank holds at most {PAIRS_MAX} pairs of grains; use more ranks");
        let mut counts = vec![0; grains.owned];
        for (row, _) in terms(&self.pairs, grains.owned) {
            counts[row] += 1;
        }
        self.starts.clear();
        self.starts.push(0);
        let mut end = 0;
        for eight in counts.chunks(LANES) {
            end += eight.iter().max().copied().unwrap_or(0);
            self.starts.push(end);
        }
        self.places.clear();
        self.places.shrink_to(end as usize);
        self.places.reserve_exact(end as usize);
        self.places.resize(end as usize, [Place::NOTHING; LANES]);
        counts.fill(0);
        for (row, term) in terms(&self.pairs, grains.owned) {
            let at = self.starts[row / LANES] + counts[row];
            self.places[at as usize][row % LANES] = self.place(row, term);
            counts[row] += 1;
        }
        let mut sorted = Vec::new();
        for row in 0..grains.owned {
            let id = |term: Term| grains.cold[self.partner(term) as usize].id;
            sorted.extend(self.terms_of(row).map(|term| (id(term), self.place(row, term))));
            sorted.sort_unstable_by_key(|(id, _)| *id);
            let first = self.starts[row / LANES] as usize;
            for (places, (_, place)) in self.places[first..].iter_mut().zip(sorted.drain(..)) {
                places[row % LANES] = place;
            }
        }
    }

    /// Pairs before the segment of a row.
    fn before(&self, row: usize) -> usize {
        (row / SEGMENT).checked_sub(1).and_then(|segment| self.segment_ends.get(segment)).map_or(0, |end| *end as usize)
    }

    fn place(&self, row: usize, term: Term) -> Place {
        match term.pair.checked_sub(self.within()) {
            Some(apart) => Place::new(Place::APART, apart, term.is_b),
            None => Place::new(Place::WITHIN, term.pair - self.before(row), term.is_b),
        }
    }

    /// Terms of an owned row, in the order of the partners' ids; a row behind the last owned one, but in its eight, has none.
    pub fn terms_of(&self, row: usize) -> impl Iterator<Item = Term> {
        let places = self.places_of_eight(row / LANES).iter().map(move |places| places[row % LANES]);
        let (within, before) = (self.within(), self.before(row));
        places.take_while(|place| *place != Place::NOTHING).map(move |place| Term {
            pair: place.side() / 2 + if place.part() == Place::APART { within } else { before },
            is_b: place.side() % 2 == 1,
        })
    }

    /// Places of the terms of eight rows side by side.
    #[inline(always)]
    pub fn places_of_eight(&self, eight: usize) -> &[[Place; LANES]] {
        &self.places[self.starts[eight] as usize..self.starts[eight + 1] as usize]
    }

    /// The row on the other side of a term.
    pub fn partner(&self, term: Term) -> Row {
        partner(&self.pairs, term)
    }

    /// Pairs with their index, copies left out.
    pub fn real_pairs(&self) -> impl Iterator<Item = (usize, &Pair)> {
        real(&self.pairs)
    }

    /// Bytes that pairs and terms hold.
    pub fn bytes(&self) -> usize {
        self.pairs.capacity() * size_of::<Pair>()
            + self.starts.capacity() * size_of::<u32>()
            + self.places.capacity() * size_of::<[Place; LANES]>()
    }
}

fn partner(pairs: &[Pair], term: Term) -> Row {
    let pair = pairs[term.pair];
    if term.is_b { pair.a } else { pair.b() }
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

/// Terms of owned rows in the order of the pairs.
fn terms(pairs: &[Pair], owned: usize) -> impl Iterator<Item = (usize, Term)> {
    let of = |(index, pair): (usize, &Pair)| {
        [(pair.a, false), (pair.b(), true)].map(|(row, is_b)| (row as usize, Term { pair: index, is_b }))
    };
    real(pairs).flat_map(of).filter(move |(row, _)| *row < owned)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::ids::GrainId;
    use crate::base::space::Plane;
    use crate::dem::grains::GrainRow;

    /// Grains of half a metre, of which only a few patches of a wide cell hold some.
    #[test]
    fn pairs_across_patches_and_periods_are_those_of_all_pairs() {
        let vector = |[x, y]: [f64; 2]| <Plane as Space>::Vector::new(x, y);
        let [width, height] = [70.0, 50.0];
        let cell = Cell::<Plane>::cuboid(vector([0.0; 2]), vector([width, height]), [true, false, false]);
        let mut dice = 1u64;
        let mut random = || {
            dice = dice.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (dice >> 11) as f64 / (1u64 << 53) as f64
        };
        // About the seam, about a corner of patches, along the upper edge, and alone.
        let crowds = [[68.0, 20.0], [7.0, 7.0], [40.0, 46.0]];
        let mut places: Vec<[f64; 2]> = crowds
            .iter()
            .flat_map(|at| {
                (0..60).map(|_| [(at[0] + 4.0 * random()) % width, at[1] + 4.0 * random()]).collect::<Vec<_>>()
            })
            .collect();
        places.push([20.0, 30.0]);
        let mut grains = Grains::<Plane>::default();
        for (id, place) in (0..).zip(&places) {
            let row = GrainRow::<Plane>::resting(GrainId(id), vector(*place), 0.25, 1.0, Mover::Free);
            grains.hot.push(row.hot);
            grains.cold.push(row.cold);
        }
        grains.owned = places.len();
        let mut neighbours = Neighbours::default();
        neighbours.build(&grains, &cell, 0.1);
        let mut found: Vec<[Row; 2]> = neighbours.real_pairs().map(|(_, pair)| [pair.a, pair.b()]).collect();
        found.sort_unstable();
        let near = |a: &[f64; 2], b: &[f64; 2]| {
            let across = (a[0] - b[0]).abs();
            across.min(width - across).powi(2) + (a[1] - b[1]).powi(2) < 0.36
        };
        let all = (0..places.len()).flat_map(|a| (a + 1..places.len()).map(move |b| [a, b]));
        let wanted: Vec<[Row; 2]> =
            all.filter(|[a, b]| near(&places[*a], &places[*b])).map(|pair| pair.map(|row| row as Row)).collect();
        assert!(wanted.len() > 100, "{} pairs", wanted.len());
        assert_eq!(found, wanted);

        // In order each grain meets its pairs in the order of its terms, and those of lower ids come as terms do, row after row.
        let mut in_order = Neighbours { in_order: true, ..Neighbours::default() };
        in_order.build(&grains, &cell, 0.1);
        let pairs = in_order.pairs_in_order();
        assert_eq!(pairs.iter().map(|pair| [pair.a, pair.b()]).collect::<Vec<_>>(), wanted);
        assert!(pairs.iter().any(|pair| pair.image() != ImageCode::NONE));
        assert!(pairs.iter().all(|pair| pair.code() == u64::from(pair.image().0)));
        assert_eq!(in_order.counted, neighbours.pairs.len());
        let mut met = vec![Vec::new(); grains.owned];
        for (index, pair) in pairs.iter().enumerate() {
            met[pair.a as usize].push(Term { pair: index, is_b: false });
            met[pair.b() as usize].push(Term { pair: index, is_b: true });
        }
        assert!((0..grains.owned).all(|row| in_order.terms_of(row).eq(met[row].iter().copied())));
        let terms = (0..grains.owned).flat_map(|row| in_order.terms_of(row));
        let lower = terms.filter(|term| !term.is_b).map(|term| term.pair);
        assert!(lower.eq(0..pairs.len()));
        let partners = |lists: &Neighbours, row: usize| -> Vec<Row> {
            lists.terms_of(row).map(|term| lists.partner(term)).collect()
        };
        assert!((0..grains.owned).all(|row| partners(&in_order, row) == partners(&neighbours, row)));
        in_order.drop_terms();
        in_order.restore_terms(&grains);
        assert!((0..grains.owned).all(|row| in_order.terms_of(row).eq(met[row].iter().copied())));
    }

    /// In lists of several segments, whose rows count pairs from the first of their own, every pair is a term of both of its grains.
    #[test]
    fn terms_in_every_segment_are_those_of_its_pairs() {
        let side = 60;
        let mut grains = Grains::<Plane>::default();
        for id in 0..side * side {
            // Pairs along a column where one of the two is large, and across columns of large ones.
            let place = <Plane as Space>::Vector::new((id / side) as f64, (id % side) as f64);
            let radius = if id % 3 == 0 { 0.5 } else { 0.45 };
            let row = GrainRow::<Plane>::resting(GrainId(id as u64), place, radius, 1.0, Mover::Free);
            grains.hot.push(row.hot);
            grains.cold.push(row.cold);
        }
        // A last eight with three rows, and copies behind.
        grains.owned = side * side - 5;
        let edges = <Plane as Space>::Vector::new(side as f64, side as f64);
        let cell = Cell::<Plane>::cuboid(<Plane as Space>::Vector::new(0.0, 0.0), edges, [true, false, false]);
        let mut neighbours = Neighbours::default();
        neighbours.build(&grains, &cell, 0.07);
        assert!(neighbours.segment_ends.len() > 3 && neighbours.within() < neighbours.pairs.len());
        let mut met = vec![Vec::new(); grains.owned];
        for (index, pair) in neighbours.real_pairs() {
            let both = [(pair.a, pair.b(), false), (pair.b(), pair.a, true)];
            for (row, partner, is_b) in both.into_iter().filter(|(row, _, _)| (*row as usize) < grains.owned) {
                met[row as usize].push((partner, Term { pair: index, is_b }));
            }
        }
        for (row, mut met) in met.into_iter().enumerate() {
            met.sort_unstable_by_key(|(partner, _)| *partner);
            assert!(neighbours.terms_of(row).eq(met.into_iter().map(|(_, term)| term)), "of row {row}");
        }
    }
}
