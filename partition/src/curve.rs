//! The blocks of a lattice in the order in which they are dealt to ranks.

use crate::hilbert;
use crate::lattice::Lattice;

/// The blocks of a lattice in Hilbert order.
///
/// The order depends on the lattice alone. Blocks next to each other on the curve touch when the
/// lattice is a square (cube) whose side is a power of two; any other lattice skips the parts of
/// the bounding cube it lacks, and may jump.
#[derive(Clone, Debug)]
pub struct Curve<const D: usize> {
    lattice: Lattice<D>,
    /// Block index (`Lattice::index`) at each place of the curve.
    order: Vec<usize>,
    /// Place on the curve of each block index: the inverse of `order`.
    places: Vec<usize>,
}

impl<const D: usize> Curve<D> {
    /// The curve through all blocks of `lattice`.
    pub fn new(lattice: &Lattice<D>) -> Self {
        let side = lattice.blocks().into_iter().max().unwrap_or(1);
        let bits = side.next_power_of_two().trailing_zeros();
        let mut order: Vec<usize> = (0..lattice.block_count()).collect();
        // Keys of distinct blocks are distinct, so the order is the only one possible.
        order.sort_by_cached_key(|&index| hilbert::key(lattice.block(index), bits));
        let mut places = vec![0; order.len()];
        for (place, &index) in order.iter().enumerate() {
            places[index] = place;
        }
        Self { lattice: lattice.clone(), order, places }
    }

    /// Blocks on the curve: all of the lattice.
    #[allow(clippy::len_without_is_empty, reason = "a lattice has at least one block")]
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// The block at place `k`.
    ///
    /// # Panics
    /// When `k` is not below [`len`](Self::len).
    pub fn coordinates(&self, k: usize) -> [usize; D] {
        self.lattice.block(self.order[k])
    }

    /// The place of a block on the curve; the inverse of [`coordinates`](Self::coordinates).
    ///
    /// # Panics
    /// When the block lies outside the lattice.
    pub fn position(&self, block: [usize; D]) -> usize {
        self.places[self.lattice.index(block)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve<const D: usize>(blocks: [usize; D]) -> Curve<D> {
        Curve::new(&Lattice::new(blocks, 1, [false; D]).unwrap())
    }

    fn visits_each_block_once<const D: usize>(curve: &Curve<D>) {
        for k in 0..curve.len() {
            assert_eq!(curve.position(curve.coordinates(k)), k);
        }
        let mut seen: Vec<_> = (0..curve.len()).map(|k| curve.coordinates(k)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), curve.lattice.block_count());
    }

    fn steps_to_a_touching_block<const D: usize>(curve: &Curve<D>) {
        for k in 1..curve.len() {
            let (from, to) = (curve.coordinates(k - 1), curve.coordinates(k));
            let distance: usize = (0..D).map(|axis| from[axis].abs_diff(to[axis])).sum();
            assert_eq!(distance, 1, "step {k} goes from {from:?} to {to:?}");
        }
    }

    #[test]
    fn squares_and_cubes_of_a_power_of_two_are_walked_without_a_jump() {
        for bits in 0..6 {
            let square = curve([1 << bits; 2]);
            visits_each_block_once(&square);
            steps_to_a_touching_block(&square);
        }
        for bits in 0..5 {
            let cube = curve([1 << bits; 3]);
            visits_each_block_once(&cube);
            steps_to_a_touching_block(&cube);
        }
    }

    #[test]
    fn any_lattice_is_visited_whole() {
        for (x, y) in [(1, 1), (1, 7), (5, 3), (16, 9), (33, 2)] {
            visits_each_block_once(&curve([x, y]));
            visits_each_block_once(&curve([y, x, 3]));
        }
    }

    #[test]
    fn every_aligned_quarter_is_one_stretch() {
        let curve = curve([8, 8]);
        for quarter in 0..4 {
            let corner = curve.coordinates(16 * quarter).map(|x| x / 4);
            assert!((0..16).all(|k| curve.coordinates(16 * quarter + k).map(|x| x / 4) == corner));
        }
    }
}
