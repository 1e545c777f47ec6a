//! Quadratic B-spline shape functions (Steffen, Kirby & Berzins 2008): smooth gradients, three nodes per axis.

use crate::space::{Linear, Space};

/// Nodes that reach beyond a block's own on its lower side, and on its upper side. A point or grain may drift half a cell
/// out of its block before it must move house ([`DRIFT_MAX`]); its spline then still lies within this margin.
pub const MARGIN_LOWER: usize = 1;
pub const MARGIN_UPPER: usize = 2;

/// Drift from home in cells and per axis at which a rebuild is due, below the half cell that the margin allows.
pub const DRIFT_MAX: f64 = 0.45;

/// The spline of one place in a tile: values and slopes per axis.
#[derive(Clone, Copy, Debug)]
pub struct Spline<S: Space> {
    base: [usize; 3],
    values: [[f64; 3]; 3],
    slopes: [[f64; 3]; 3],
    space: std::marker::PhantomData<S>,
}

impl<S: Space> Spline<S> {
    /// `place` is measured in cells from the tile's first node.
    #[inline(always)]
    pub fn new(place: S::Vector, cell_inverse: f64) -> Self {
        let mut spline =
            Self { base: [0; 3], values: [[1.0, 0.0, 0.0]; 3], slopes: [[0.0; 3]; 3], space: std::marker::PhantomData };
        for axis in 0..S::DIMENSION {
            let base = (place[axis] - 0.5).floor();
            let x = place[axis] - base;
            spline.base[axis] = base as usize;
            spline.values[axis] =
                [0.5 * (1.5 - x) * (1.5 - x), 0.75 - (x - 1.0) * (x - 1.0), 0.5 * (x - 0.5) * (x - 0.5)];
            spline.slopes[axis] = [(x - 1.5) * cell_inverse, -2.0 * (x - 1.0) * cell_inverse, (x - 0.5) * cell_inverse];
        }
        spline
    }

    /// Calls `visit(node, N, grad N)` for every node in reach, in lexical order; `edge` is the tile's nodes per axis.
    #[inline(always)]
    pub fn for_each(&self, edge: usize, mut visit: impl FnMut(usize, f64, S::Vector)) {
        let layers = if S::DIMENSION == 3 { 3 } else { 1 };
        for k in 0..layers {
            for j in 0..3 {
                for i in 0..3 {
                    let node = ((self.base[2] + k) * edge + self.base[1] + j) * edge + self.base[0] + i;
                    let (x, y, z) = (self.values[0][i], self.values[1][j], self.values[2][k]);
                    let mut gradient = S::Vector::zero();
                    gradient[0] = self.slopes[0][i] * y * z;
                    gradient[1] = x * self.slopes[1][j] * z;
                    if S::DIMENSION == 3 {
                        gradient[2] = x * y * self.slopes[2][k];
                    }
                    visit(node, x * y * z, gradient);
                }
            }
        }
    }
}
