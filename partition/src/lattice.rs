//! The global grid of cells, seen as a lattice of blocks.

use thiserror::Error;

/// A box of cells cut into equal square (cubic) blocks, each axis open or periodic.
///
/// Blocks are named by their coordinates, cell `c` of an axis lying in block `c / cells_per_block`.
/// Where one number is needed, [`index`](Self::index) counts blocks with axis 0 fastest and the
/// last axis slowest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lattice<const D: usize> {
    cells: [usize; D],
    cells_per_block: usize,
    periodic: [bool; D],
}

/// Why a box of cells cannot be cut into blocks.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LatticeError {
    /// A block must have cells.
    #[error("a block has 0 cells per axis; give it at least 1")]
    EmptyBlock,
    /// Blocks must tile the box without a remainder.
    #[error(
        "axis {axis} has {cells} cells, which is not a positive multiple of the {cells_per_block} cells of a block; \
         make it {suggestion}"
    )]
    NotMultiple {
        /// The offending axis, 0 for x.
        axis: usize,
        /// Cells along it.
        cells: usize,
        /// Cells along one side of a block.
        cells_per_block: usize,
        /// The next number of cells that would do.
        suggestion: usize,
    },
    /// The blocks must be countable with room to spare.
    #[error("the lattice has more than 2^62 blocks; use larger blocks or fewer cells")]
    TooMany,
}

impl<const D: usize> Lattice<D> {
    /// A lattice of `cells` per axis in blocks of `cells_per_block` cells per axis.
    ///
    /// # Errors
    /// When the block is empty, when an axis is not a positive multiple of it, or when there are
    /// too many blocks.
    pub fn new(cells: [usize; D], cells_per_block: usize, periodic: [bool; D]) -> Result<Self, LatticeError> {
        if cells_per_block == 0 {
            return Err(LatticeError::EmptyBlock);
        }
        for (axis, &count) in cells.iter().enumerate() {
            if count == 0 || count % cells_per_block != 0 {
                let suggestion = count.div_ceil(cells_per_block).max(1).saturating_mul(cells_per_block);
                return Err(LatticeError::NotMultiple { axis, cells: count, cells_per_block, suggestion });
            }
        }
        let lattice = Self { cells, cells_per_block, periodic };
        let blocks = lattice.blocks().iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
        match blocks {
            Some(count) if count <= 1 << 62 => Ok(lattice),
            _ => Err(LatticeError::TooMany),
        }
    }

    /// Cells per axis.
    pub fn cells(&self) -> [usize; D] {
        self.cells
    }

    /// Cells along one side of a block.
    pub fn cells_per_block(&self) -> usize {
        self.cells_per_block
    }

    /// Which axes wrap round.
    pub fn periodic(&self) -> [bool; D] {
        self.periodic
    }

    /// Blocks per axis.
    pub fn blocks(&self) -> [usize; D] {
        self.cells.map(|cells| cells / self.cells_per_block)
    }

    /// Blocks in all.
    pub fn block_count(&self) -> usize {
        self.blocks().iter().product()
    }

    /// The number of a block, axis 0 fastest.
    ///
    /// # Panics
    /// When the block lies outside the lattice.
    pub fn index(&self, block: [usize; D]) -> usize {
        let blocks = self.blocks();
        (0..D).rev().fold(0, |index, axis| {
            assert!(block[axis] < blocks[axis], "block {block:?} lies outside a lattice of {blocks:?} blocks");
            index * blocks[axis] + block[axis]
        })
    }

    /// The block with this number; the inverse of [`index`](Self::index).
    ///
    /// # Panics
    /// When there is no such block.
    pub fn block(&self, index: usize) -> [usize; D] {
        assert!(index < self.block_count(), "block {index} of {}", self.block_count());
        let mut rest = index;
        self.blocks().map(|count| {
            let coordinate = rest % count;
            rest /= count;
            coordinate
        })
    }

    /// The block `offset` blocks away: wrapped on periodic axes, `None` beyond the end of an open
    /// one.
    ///
    /// On a periodic axis of one or two blocks several offsets reach the same block, the block
    /// itself included.
    pub fn neighbour(&self, block: [usize; D], offset: [i32; D]) -> Option<[usize; D]> {
        let blocks = self.blocks();
        let mut neighbour = block;
        for axis in 0..D {
            // At most 2^62 blocks, so neither the coordinate nor the sum can leave i64.
            let count = blocks[axis] as i64;
            let moved = block[axis] as i64 + i64::from(offset[axis]);
            let wrapped = if self.periodic[axis] { moved.rem_euclid(count) } else { moved };
            if !(0..count).contains(&wrapped) {
                return None;
            }
            neighbour[axis] = wrapped as usize;
        }
        Some(neighbour)
    }
}

/// All 3^D offsets in {-1, 0, 1}^D, the zero one in the middle, with axis 0 fastest and the last
/// axis slowest (the order of [`Lattice::index`]). Reversing the list negates every offset.
pub fn offsets<const D: usize>() -> Vec<[i32; D]> {
    (0..3_usize.pow(D as u32))
        .map(|k| {
            let mut rest = k;
            [(); D].map(|()| {
                let digit = rest % 3;
                rest /= 3;
                digit as i32 - 1
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_boxes_that_blocks_do_not_tile() {
        assert_eq!(Lattice::new([8, 8], 0, [false; 2]), Err(LatticeError::EmptyBlock));
        assert_eq!(
            Lattice::new([8, 10], 4, [false; 2]),
            Err(LatticeError::NotMultiple { axis: 1, cells: 10, cells_per_block: 4, suggestion: 12 })
        );
        assert!(matches!(Lattice::new([0, 4], 4, [false; 2]), Err(LatticeError::NotMultiple { suggestion: 4, .. })));
        let side = usize::MAX / 2;
        assert_eq!(Lattice::new([side, side], 1, [false; 2]), Err(LatticeError::TooMany));
    }

    #[test]
    fn numbers_blocks_with_axis_0_fastest() {
        let lattice = Lattice::new([12, 8, 4], 4, [false; 3]).unwrap();
        assert_eq!(lattice.blocks(), [3, 2, 1]);
        assert_eq!(lattice.block_count(), 6);
        assert_eq!(lattice.block(1), [1, 0, 0]);
        for k in 0..lattice.block_count() {
            assert_eq!(lattice.index(lattice.block(k)), k);
        }
    }

    #[test]
    fn neighbours_wrap_only_where_periodic() {
        let lattice = Lattice::new([6, 6], 2, [true, false]).unwrap();
        assert_eq!(lattice.neighbour([0, 0], [-1, 1]), Some([2, 1]));
        assert_eq!(lattice.neighbour([2, 2], [1, 0]), Some([0, 2]));
        assert_eq!(lattice.neighbour([0, 0], [0, -1]), None);
        assert_eq!(lattice.neighbour([0, 2], [0, 1]), None);
    }

    #[test]
    fn offsets_are_ordered_and_symmetric() {
        let flat = offsets::<2>();
        assert_eq!(&flat[..4], &[[-1, -1], [0, -1], [1, -1], [-1, 0]]);
        let solid = offsets::<3>();
        assert_eq!(solid.len(), 27);
        assert_eq!(solid[13], [0; 3]);
        for (forth, back) in solid.iter().zip(solid.iter().rev()) {
            assert_eq!(forth.map(|x| -x), *back);
        }
    }
}
