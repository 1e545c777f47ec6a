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

use crate::base::lane::{Real, splats};
use crate::base::space::{Space, Words};
use crate::mpm::scheme::ShapeFunction;

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

/// Functions at one place along an axis, or at several in step; the place and their slopes measured in cells.
#[derive(Clone, Copy, Debug)]
pub struct Along<R, const N: usize> {
    /// The first node in reach, a whole number.
    pub base: R,
    /// N of the nodes from `base` on.
    pub values: [R; N],
    /// dN/dx of the same, per cell.
    pub slopes: [R; N],
}

/// Shape functions along an axis; `N` of them reach a place.
pub trait Shape<const N: usize>: Copy + Send + Sync + 'static {
    /// Far from walls, at `place` in cells from the tile's first node; `half` of a point's edge in cells.
    fn unwalled<R: Real>(place: R, half: f64) -> Along<R, N>;

    /// At `place`, in cells from the tile's first node.
    #[inline(always)]
    fn along<R: Real>(place: R, axis: &Axis) -> Along<R, N> {
        let [lower, upper] = axis.walls;
        // No function behind a wall reaches further than a cell.
        let felt = R::either(R::splat(lower + 1.0).above(place), place.above(R::splat(upper - 1.0)));
        if !R::any(felt) {
            return Self::unwalled(place, axis.half);
        }
        let between = place.max(R::splat(lower)).min(R::splat(upper));
        Self::unwalled(between, axis.half).straightened(lower, 1.0).straightened(upper, -1.0)
    }
}

impl<R: Real, const N: usize> Along<R, N> {
    /// With what lies behind a wall given to the two nodes on this side of it; `inward` is the way there.
    #[inline(always)]
    fn straightened(mut self, wall: f64, inward: f64) -> Self {
        if wall.is_infinite() {
            return self;
        }
        let [zero, half, one] = splats::<R, _>([0.0, 0.5, 1.0]);
        // How far behind the wall each node is, a whole number.
        let mut behind = [zero; N];
        for (node, behind) in behind.iter_mut().enumerate() {
            *behind = R::splat(inward) * (R::splat(wall - node as f64) - self.base);
        }
        for field in [&mut self.values, &mut self.slopes] {
            let (mut on_wall, mut inside) = (zero, zero);
            for (share, behind) in field.iter_mut().zip(behind) {
                let given = R::choose(behind.above(half), *share, zero);
                (on_wall, inside) = (on_wall + (one + behind) * given, inside - behind * given);
                *share = *share - given;
            }
            for (share, behind) in field.iter_mut().zip(behind) {
                let is_on = half.above(behind.abs());
                let is_inside = half.above((behind + one).abs());
                *share = *share + R::choose(is_on, on_wall, R::choose(is_inside, inside, zero));
            }
        }
        self
    }
}

/// [`ShapeFunction::Linear`]: of three nodes one has zero.
#[derive(Clone, Copy, Debug)]
pub struct LinearHat;
/// [`ShapeFunction::Generalised`]: three nodes, as points are no longer than a cell.
#[derive(Clone, Copy, Debug)]
pub struct Generalised;
/// [`ShapeFunction::Quadratic`]: three nodes.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic;
/// [`ShapeFunction::Cubic`]: four nodes.
#[derive(Clone, Copy, Debug)]
pub struct Cubic;

impl Shape<3> for LinearHat {
    #[inline(always)]
    fn unwalled<R: Real>(place: R, _: f64) -> Along<R, 3> {
        let [zero, half, one] = splats::<R, _>([0.0, 0.5, 1.0]);
        let (cell, base) = (place.floor(), (place - half).floor());
        let x = place - cell;
        // The cell's two nodes are the last two of the three, or the first two.
        let last = cell.above(base);
        let choose = |last_two: R, first_two: R| R::choose(last, last_two, first_two);
        Along {
            base,
            values: [choose(zero, one - x), choose(one - x, x), choose(x, zero)],
            slopes: [choose(zero, -one), choose(-one, one), choose(one, zero)],
        }
    }
}

impl Shape<3> for Generalised {
    #[inline(always)]
    fn unwalled<R: Real>(place: R, half: f64) -> Along<R, 3> {
        let base = (place - R::splat(0.5)).floor();
        let mut along = Along { base, values: [base; 3], slopes: [base; 3] };
        for node in 0..3 {
            let apart = place - base - R::splat(node as f64);
            (along.values[node], along.slopes[node]) = generalised(apart, half);
        }
        along
    }
}

/// The hat of a node seen by a point of half length `half`, at `apart` cells from it, and its slope.
#[inline(always)]
fn generalised<R: Real>(apart: R, half: f64) -> (R, R) {
    let [zero, one, sharp, wide, within] = splats::<R, _>([0.0, 1.0, half, 1.0 + half, 1.0 - half]);
    let distance = apart.abs();
    let side = R::choose(zero.above(apart), -one, one);
    let left = wide - distance;
    let reached = wide.above(distance);
    let mut value = R::choose(reached, left * left / R::splat(4.0 * half), zero);
    let mut slope = R::choose(reached, -side * left / R::splat(2.0 * half), zero);
    let flank = within.above(distance);
    (value, slope) = (R::choose(flank, one - distance, value), R::choose(flank, -side, slope));
    let top = sharp.above(distance);
    value = R::choose(top, one - (distance * distance + sharp * sharp) / R::splat(2.0 * half), value);
    slope = R::choose(top, -apart / sharp, slope);
    (value, slope)
}

impl Shape<3> for Quadratic {
    #[inline(always)]
    fn unwalled<R: Real>(place: R, _: f64) -> Along<R, 3> {
        let [half, one, high, wide, two] = splats::<R, _>([0.5, 1.0, 0.75, 1.5, 2.0]);
        let base = (place - half).floor();
        let x = place - base;
        let (from_first, from_middle, from_last) = (wide - x, x - one, x - half);
        Along {
            base,
            values: [half * from_first * from_first, high - from_middle * from_middle, half * from_last * from_last],
            slopes: [-from_first, -two * from_middle, from_last],
        }
    }
}

impl Shape<4> for Cubic {
    #[inline(always)]
    fn unwalled<R: Real>(place: R, _: f64) -> Along<R, 4> {
        let [sixth, half, one, wide, two, three, four, six] =
            splats::<R, _>([1.0 / 6.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]);
        let base = place.floor() - one;
        let x = place - base - one;
        let y = one - x;
        Along {
            base,
            values: [
                sixth * y * y * y,
                sixth * (four - six * x * x + three * x * x * x),
                sixth * (four - six * y * y + three * y * y * y),
                sixth * x * x * x,
            ],
            slopes: [-half * y * y, x * (wide * x - two), -y * (wide * y - two), half * x * x],
        }
    }
}

/// The functions at one place of a tile, or at several in step, along all axes. Slopes are per m.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<S: Space, R, const N: usize> {
    /// First node in reach along each axis, from the tile's first; a whole number.
    pub base: [R; 3],
    /// N along each axis, of the nodes from `base` on; 1 for the first alone along an axis that is not there.
    pub values: [[R; N]; 3],
    /// dN/dx of the same, 1/m; zero along an axis that is not there.
    pub slopes: [[R; N]; 3],
    space: std::marker::PhantomData<S>,
}

impl<S: Space, R: Real, const N: usize> Stencil<S, R, N> {
    /// Nodes along the third axis.
    pub const LAYERS: usize = if S::DIMENSION == 3 { N } else { 1 };

    /// `place` is measured in cells from the tile's first node.
    #[inline(always)]
    pub fn new<F: Shape<N>>(place: &S::VectorOf<R>, axes: &[Axis; 3], cell_inverse: f64) -> Self {
        let zero = R::splat(0.0);
        let mut one = [zero; N];
        one[0] = R::splat(1.0);
        let mut stencil =
            Self { base: [zero; 3], values: [one; 3], slopes: [[zero; N]; 3], space: std::marker::PhantomData };
        for (axis, wall) in axes.iter().enumerate().take(S::DIMENSION) {
            let along = F::along(place.word(axis), wall);
            stencil.base[axis] = along.base;
            stencil.values[axis] = along.values;
            for node in 0..N {
                stencil.slopes[axis][node] = along.slopes[node] * R::splat(cell_inverse);
            }
        }
        stencil
    }

    /// The first node in reach, in a tile with `edge` nodes per axis; a whole number.
    #[inline(always)]
    pub fn first(&self, edge: usize) -> R {
        let edge = R::splat(edge as f64);
        (self.base[2] * edge + self.base[1]) * edge + self.base[0]
    }
}

/// First node of a row of the stencil along x, beyond the stencil's first.
#[inline(always)]
pub const fn row(edge: usize, j: usize, k: usize) -> usize {
    (k * edge + j) * edge
}

impl<S: Space, const N: usize> Stencil<S, f64, N> {
    /// Calls `visit(node, N)` for every node in reach, in lexical order.
    #[inline(always)]
    pub fn for_each(&self, edge: usize, mut visit: impl FnMut(usize, f64)) {
        let first = self.first(edge) as usize;
        for k in 0..Self::LAYERS {
            for j in 0..N {
                for i in 0..N {
                    visit(first + row(edge, j, k) + i, self.values[0][i] * self.values[1][j] * self.values[2][k]);
                }
            }
        }
    }

    /// Calls `visit(node, N, grad N)` for every node in reach, in lexical order; slopes per m.
    #[inline(always)]
    pub fn for_each_gradient(&self, edge: usize, mut visit: impl FnMut(usize, f64, [f64; 3])) {
        let first = self.first(edge) as usize;
        for k in 0..Self::LAYERS {
            for j in 0..N {
                for i in 0..N {
                    let at = [i, j, k];
                    let [x, y, z]: [f64; 3] = std::array::from_fn(|axis| self.values[axis][at[axis]]);
                    let slope = |axis: usize| self.slopes[axis][at[axis]];
                    let gradient = [slope(0) * y * z, x * slope(1) * z, x * y * slope(2)];
                    visit(first + row(edge, j, k) + i, x * y * z, gradient);
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
                let stand = |i: usize| at.base + i as f64;
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

    /// `sum N'^2/N` far from walls: the most that it comes to is what the bound of the step is made from.
    #[test]
    fn no_function_is_steeper_than_the_step_allows() {
        fn steepest<const N: usize, F: Shape<N>>(axis: &Axis) -> f64 {
            let at = |step: i32| {
                let along = F::along(8.0 + 1e-4 * (f64::from(step) + 0.5), axis);
                let share = |(value, slope): (&f64, &f64)| if *value > 0.0 { slope * slope / value } else { 0.0 };
                along.values.iter().zip(&along.slopes).map(share).sum::<f64>()
            };
            (0..10_000).map(at).fold(0.0, f64::max)
        }
        let is = |found: f64, shape: ShapeFunction, points_per_cell: usize| {
            let most = shape.steepness(points_per_cell);
            assert!(found <= most && found > 0.995 * most, "{shape:?}, {points_per_cell}: {found}, {most}");
        };
        for points_per_cell in [1, 2, 3, 4] {
            let axis = Axis { half: 0.5 / points_per_cell as f64, ..Axis::default() };
            is(steepest::<3, Generalised>(&axis), ShapeFunction::Generalised, points_per_cell);
        }
        is(steepest::<3, Quadratic>(&Axis::default()), ShapeFunction::Quadratic, 2);
        is(steepest::<4, Cubic>(&Axis::default()), ShapeFunction::Cubic, 2);
        assert!(steepest::<3, LinearHat>(&Axis::default()) > 1e4);
    }

    #[test]
    fn no_function_reaches_behind_a_wall_and_the_first_stands_on_it() {
        fn check<const N: usize, F: Shape<N>>() {
            for (wall, behind) in [(2, 0..2), (14, 15..20)] {
                let at = F::along(wall as f64, &WALLED);
                for node in 0..N {
                    let wanted = if at.base as usize + node == wall { 1.0 } else { 0.0 };
                    assert!((at.values[node] - wanted).abs() < 1e-15, "{at:?}");
                    assert!(!behind.contains(&(at.base as usize + node)) || at.slopes[node] == 0.0, "{at:?}");
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
                (0..N).for_each(|i| all[at.base as usize + i] = at.values[i]);
                all
            };
            for step in 1..1199 {
                let place = 2.0 + 0.01 * f64::from(step) + 0.0033;
                let (before, after) = (spread(place - 1e-6), spread(place + 1e-6));
                let at = F::along(place, &WALLED);
                for i in 0..N {
                    let wanted = (after[at.base as usize + i] - before[at.base as usize + i]) / 2e-6;
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
