//! Shape functions of the background grid: linear, uGIMP, quadratic and cubic B-splines, axis by axis.
//!
//! At a wall they are those of a field that is straight there (Steffen, Kirby & Berzins 2008): what a function behind the wall
//! would stand for is the continuation of the line through the two nodes on this side,
//!
//! ```text
//! v(wall - d) = (1 + d) v(wall) - d v(wall + 1)
//! ```
//!
//! so that none reaches behind it, the one on it takes its value there alone, they sum to one and meet linear fields, and points
//! on any regular lattice integrate their slopes exactly: the midpoint rule errs by multiples of what the slopes' own slopes
//! are at the ends of a function's reach (Euler & Maclaurin), and at a straight end that is nothing.

use crate::scenario::mpm::ShapeFunction;
use crate::space::Space;

/// Drift from home in cells and per axis at which a rebuild is due, below the half cell that the margins allow.
pub const DRIFT_MAX: f64 = 0.45;

/// Nodes of a tile below the block's own first node and above its own last. A point or grain may drift half a cell out of
/// its block before it must move house ([`DRIFT_MAX`]); its functions still lie within these margins.
pub fn margins(shape: ShapeFunction) -> [usize; 2] {
    match shape {
        ShapeFunction::Linear | ShapeFunction::Generalised | ShapeFunction::Quadratic => [1, 2],
        ShapeFunction::Cubic => [2, 3],
    }
}

/// What a place along an axis needs to know beside itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Where the walls are, in cells from the tile's first node; infinitely far where there is none to be felt.
    pub walls: [f64; 2],
    /// Half of a point's edge in cells, for functions that ask.
    pub half: f64,
}

impl Default for Axis {
    fn default() -> Self {
        Self { walls: [f64::NEG_INFINITY, f64::INFINITY], half: 0.25 }
    }
}

/// Functions at one place along an axis, the place and their slopes measured in cells.
#[derive(Clone, Copy, Debug)]
pub struct Along<const N: usize> {
    pub base: usize,
    pub values: [f64; N],
    pub slopes: [f64; N],
}

/// Shape functions along an axis; `N` of them reach a place.
pub trait Shape<const N: usize>: Copy + Send + Sync + 'static {
    /// Far from walls, at `place` in cells from the tile's first node; `half` of a point's edge in cells.
    fn unwalled(place: f64, half: f64) -> Along<N>;

    /// At `place`, in cells from the tile's first node.
    #[inline(always)]
    fn along(place: f64, axis: &Axis) -> Along<N> {
        match axis.feels(place) {
            true => Self::unwalled(place.clamp(axis.walls[0], axis.walls[1]), axis.half).straightened(axis),
            false => Self::unwalled(place, axis.half),
        }
    }
    /// Where function `node` stands for a field that is linear, in cells.
    fn stand(node: usize, _axis: &Axis) -> f64 {
        node as f64
    }
}

impl Axis {
    /// Whether a function behind a wall reaches there: none reaches further than a cell.
    #[inline(always)]
    fn feels(&self, place: f64) -> bool {
        place < self.walls[0] + 1.0 || place > self.walls[1] - 1.0
    }
}

impl<const N: usize> Along<N> {
    /// With what lies behind walls given to the two nodes on this side of each.
    fn straightened(mut self, axis: &Axis) -> Self {
        for (wall, inward) in axis.walls.into_iter().zip([1.0, -1.0]) {
            for node in 0..N {
                let behind = inward * (wall - (self.base + node) as f64);
                if behind > 0.0 {
                    let on_wall = (wall - self.base as f64) as usize;
                    let inside = (wall + inward - self.base as f64) as usize;
                    for field in [&mut self.values, &mut self.slopes] {
                        let share = std::mem::replace(&mut field[node], 0.0);
                        field[on_wall] += (1.0 + behind) * share;
                        field[inside] -= behind * share;
                    }
                }
            }
        }
        self
    }
}

#[derive(Clone, Copy, Debug)]
pub struct LinearHat;
#[derive(Clone, Copy, Debug)]
pub struct Generalised;
#[derive(Clone, Copy, Debug)]
pub struct Quadratic;
#[derive(Clone, Copy, Debug)]
pub struct Cubic;

impl Shape<3> for LinearHat {
    #[inline(always)]
    fn unwalled(place: f64, _: f64) -> Along<3> {
        let (cell, base) = (place.floor(), (place - 0.5).floor());
        let x = place - cell;
        // The cell's two nodes are the first two of the three, or the last two.
        match cell == base {
            true => Along { base: base as usize, values: [1.0 - x, x, 0.0], slopes: [-1.0, 1.0, 0.0] },
            false => Along { base: base as usize, values: [0.0, 1.0 - x, x], slopes: [0.0, -1.0, 1.0] },
        }
    }
}

impl Shape<3> for Generalised {
    #[inline(always)]
    fn unwalled(place: f64, half: f64) -> Along<3> {
        let base = (place - 0.5).floor();
        let mut along = Along { base: base as usize, values: [0.0; 3], slopes: [0.0; 3] };
        for node in 0..3 {
            let apart = place - base - node as f64;
            (along.values[node], along.slopes[node]) = generalised(apart, half);
        }
        along
    }
}

/// The hat of a node seen by a point of half length `half`, at `apart` cells from it, and its slope.
#[inline(always)]
fn generalised(apart: f64, half: f64) -> (f64, f64) {
    let (distance, side) = (apart.abs(), if apart < 0.0 { -1.0 } else { 1.0 });
    if distance < half {
        (1.0 - (distance * distance + half * half) / (2.0 * half), -apart / half)
    } else if distance < 1.0 - half {
        (1.0 - distance, -side)
    } else if distance < 1.0 + half {
        let left = 1.0 + half - distance;
        (left * left / (4.0 * half), -side * left / (2.0 * half))
    } else {
        (0.0, 0.0)
    }
}

impl Shape<3> for Quadratic {
    #[inline(always)]
    fn unwalled(place: f64, _: f64) -> Along<3> {
        let base = (place - 0.5).floor();
        let x = place - base;
        Along {
            base: base as usize,
            values: [0.5 * (1.5 - x) * (1.5 - x), 0.75 - (x - 1.0) * (x - 1.0), 0.5 * (x - 0.5) * (x - 0.5)],
            slopes: [x - 1.5, -2.0 * (x - 1.0), x - 0.5],
        }
    }
}

impl Shape<4> for Cubic {
    #[inline(always)]
    fn unwalled(place: f64, _: f64) -> Along<4> {
        let base = place.floor() - 1.0;
        let x = place - base - 1.0;
        let y = 1.0 - x;
        const SIXTH: f64 = 1.0 / 6.0;
        Along {
            base: base as usize,
            values: [
                SIXTH * y * y * y,
                SIXTH * (4.0 - 6.0 * x * x + 3.0 * x * x * x),
                SIXTH * (4.0 - 6.0 * y * y + 3.0 * y * y * y),
                SIXTH * x * x * x,
            ],
            slopes: [-0.5 * y * y, x * (1.5 * x - 2.0), -y * (1.5 * y - 2.0), 0.5 * x * x],
        }
    }
}

/// The functions at one place of a tile, along all axes. Slopes are per m.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<S: Space, const N: usize> {
    pub base: [usize; 3],
    pub values: [[f64; N]; 3],
    pub slopes: [[f64; N]; 3],
    space: std::marker::PhantomData<S>,
}

impl<S: Space, const N: usize> Stencil<S, N> {
    /// Nodes along the third axis.
    pub const LAYERS: usize = if S::DIMENSION == 3 { N } else { 1 };

    /// `place` is measured in cells from the tile's first node.
    #[inline(always)]
    pub fn new<F: Shape<N>>(place: &S::Vector, axes: &[Axis; 3], cell_inverse: f64) -> Self {
        let mut one = [0.0; N];
        one[0] = 1.0;
        let mut stencil =
            Self { base: [0; 3], values: [one; 3], slopes: [[0.0; N]; 3], space: std::marker::PhantomData };
        for axis in 0..S::DIMENSION {
            let along = F::along(place[axis], &axes[axis]);
            stencil.base[axis] = along.base;
            stencil.values[axis] = along.values;
            stencil.slopes[axis] = along.slopes.map(|slope| slope * cell_inverse);
        }
        stencil
    }

    /// First node of a row of `N` along x, in a tile with `edge` nodes per axis.
    #[inline(always)]
    pub fn row(&self, edge: usize, j: usize, k: usize) -> usize {
        ((self.base[2] + k) * edge + self.base[1] + j) * edge + self.base[0]
    }

    /// Value and gradient at node (i, j, k) of the stencil.
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize, k: usize) -> (f64, [f64; 3]) {
        let (x, y, z) = (self.values[0][i], self.values[1][j], self.values[2][k]);
        let gradient = [self.slopes[0][i] * y * z, x * self.slopes[1][j] * z, x * y * self.slopes[2][k]];
        (x * y * z, gradient)
    }

    /// Calls `visit(node, N)` for every node in reach, in lexical order.
    #[inline(always)]
    pub fn for_each(&self, edge: usize, mut visit: impl FnMut(usize, f64)) {
        for k in 0..Self::LAYERS {
            for j in 0..N {
                let row = self.row(edge, j, k);
                for i in 0..N {
                    visit(row + i, self.at(i, j, k).0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALLED: Axis = Axis { walls: [2.0, 14.0], half: 0.25 };

    fn claims<const N: usize, F: Shape<N>>(name: &str) {
        let axes = [
            WALLED,
            Axis::default(),
            Axis { walls: [2.0, f64::INFINITY], half: 0.5 },
            Axis { walls: [f64::NEG_INFINITY, 14.0], half: 0.1 },
        ];
        for axis in axes {
            for step in 0..=1200 {
                let place = 2.0 + 0.01 * f64::from(step);
                let at = F::along(place, &axis);
                let sum: f64 = at.values.iter().sum();
                assert!((sum - 1.0).abs() < 1e-14, "{name} at {place}: sum {sum}");
                assert!(at.slopes.iter().sum::<f64>().abs() < 1e-13, "{name} at {place}: slopes");
                let stand = |i: usize| F::stand(at.base + i, &axis);
                let field: f64 = (0..N).map(|i| at.values[i] * stand(i)).sum();
                let slope: f64 = (0..N).map(|i| at.slopes[i] * stand(i)).sum();
                // A linear field is met.
                assert!((field - place).abs() < 1e-12, "{name} at {place}: {field} {axis:?}");
                assert!((slope - 1.0).abs() < 1e-12, "{name} at {place}: slope {slope}");
                assert!(at.values.iter().all(|value| *value >= -1e-15), "{name} at {place}: {:?}", at.values);
            }
        }
    }

    #[test]
    fn functions_sum_to_one_and_meet_linear_fields() {
        claims::<3, LinearHat>("linear");
        claims::<3, Generalised>("uGIMP");
        claims::<3, Quadratic>("quadratic");
        claims::<4, Cubic>("cubic");
    }

    #[test]
    fn no_function_reaches_behind_a_wall_and_the_first_stands_on_it() {
        fn check<const N: usize, F: Shape<N>>() {
            for (wall, behind) in [(2, 0..2), (14, 15..20)] {
                let at = F::along(wall as f64, &WALLED);
                for node in 0..N {
                    let wanted = if at.base + node == wall { 1.0 } else { 0.0 };
                    assert!((at.values[node] - wanted).abs() < 1e-15, "{at:?}");
                    assert!(!behind.contains(&(at.base + node)) || at.slopes[node] == 0.0, "{at:?}");
                }
            }
        }
        check::<3, LinearHat>();
        check::<3, Generalised>();
        check::<3, Quadratic>();
        check::<4, Cubic>();
    }

    #[test]
    fn slopes_are_those_of_the_values_and_continuous() {
        fn check<const N: usize, F: Shape<N>>(limit: f64) {
            let spread = |place: f64| -> [f64; 20] {
                let at = F::along(place, &WALLED);
                let mut all = [0.0; 20];
                (0..N).for_each(|i| all[at.base + i] = at.values[i]);
                all
            };
            for step in 1..1199 {
                let place = 2.0 + 0.01 * f64::from(step) + 0.0033;
                let (before, after) = (spread(place - 1e-6), spread(place + 1e-6));
                let at = F::along(place, &WALLED);
                for i in 0..N {
                    let wanted = (after[at.base + i] - before[at.base + i]) / 2e-6;
                    assert!((at.slopes[i] - wanted).abs() < limit, "{place} {i}: {} {wanted}", at.slopes[i]);
                }
            }
        }
        check::<3, LinearHat>(1e-9);
        check::<3, Generalised>(1e-5);
        check::<3, Quadratic>(1e-5);
        check::<4, Cubic>(1e-5);
    }
}
