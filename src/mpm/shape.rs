//! Shape functions of the background grid: linear, uGIMP, quadratic and cubic B-splines, axis by axis.
//!
//! B-splines that reach a wall are those of an open knot vector (Steffen, Kirby & Berzins 2008): none reaches behind the
//! wall, the one on it takes its value there alone, and they still sum to one.

use crate::lane::Real;
use crate::scenario::mpm::ShapeFunction;
use crate::space::{Space, Words};

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
    pub values: [R; N],
    pub slopes: [R; N],
}

/// Shape functions along an axis; `N` of them reach a place.
pub trait Shape<const N: usize>: Copy + Send + Sync + 'static {
    /// At `place`, in cells from the tile's first node.
    fn along<R: Real>(place: R, axis: &Axis) -> Along<R, N>;
    /// Where function `node` stands for a field that is linear, in cells: its node, or its Greville abscissa near a wall.
    #[inline(always)]
    fn stand<R: Real>(node: R, _axis: &Axis) -> R {
        node
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
    fn along<R: Real>(place: R, _: &Axis) -> Along<R, 3> {
        let [zero, half, one] = [0.0, 0.5, 1.0].map(R::splat);
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
    fn along<R: Real>(place: R, axis: &Axis) -> Along<R, 3> {
        let base = (place - R::splat(0.5)).floor();
        let mut along = Along { base, values: [base; 3], slopes: [base; 3] };
        for node in 0..3 {
            let apart = place - base - R::splat(node as f64);
            (along.values[node], along.slopes[node]) = generalised(apart, axis.half);
        }
        along
    }
}

/// The hat of a node seen by a point of half length `half`, at `apart` cells from it, and its slope.
#[inline(always)]
fn generalised<R: Real>(apart: R, half: f64) -> (R, R) {
    let [zero, one, sharp, wide, within] = [0.0, 1.0, half, 1.0 + half, 1.0 - half].map(R::splat);
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
    fn along<R: Real>(place: R, axis: &Axis) -> Along<R, 3> {
        let [half, one, high, wide, two] = [0.5, 1.0, 0.75, 1.5, 2.0].map(R::splat);
        let base = (place - half).floor();
        let x = place - base;
        let (from_first, from_middle, from_last) = (wide - x, x - one, x - half);
        let mut along = Along {
            base,
            values: [half * from_first * from_first, high - from_middle * from_middle, half * from_last * from_last],
            slopes: [-from_first, -two * from_middle, from_last],
        };
        Knots::<3>::mend(&mut along, place, axis);
        along
    }
    #[inline(always)]
    fn stand<R: Real>(node: R, axis: &Axis) -> R {
        Knots::<3>::stands(node, axis)
    }
}

impl Shape<4> for Cubic {
    #[inline(always)]
    fn along<R: Real>(place: R, axis: &Axis) -> Along<R, 4> {
        let [sixth, half, one, wide, two, three, four, six] =
            [1.0 / 6.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0].map(R::splat);
        let base = place.floor() - one;
        let x = place - base - one;
        let y = one - x;
        let mut along = Along {
            base,
            values: [
                sixth * y * y * y,
                sixth * (four - six * x * x + three * x * x * x),
                sixth * (four - six * y * y + three * y * y * y),
                sixth * x * x * x,
            ],
            slopes: [-half * y * y, x * (wide * x - two), -y * (wide * y - two), half * x * x],
        };
        Knots::<4>::mend(&mut along, place, axis);
        along
    }
    #[inline(always)]
    fn stand<R: Real>(node: R, axis: &Axis) -> R {
        Knots::<4>::stands(node, axis)
    }
}

/// The open knot vector of splines of degree N - 1 between two walls that are whole cells apart: as many functions as there
/// are nodes. Inner knots lie where those of the splines far from walls do.
struct Knots<const N: usize> {
    /// Place of the lower wall, and cells between the walls.
    wall: f64,
    cells: i64,
}

impl<const N: usize> Knots<N> {
    const DEGREE: i64 = N as i64 - 1;
    /// The first inner knot; within its reach and that of the splines that it belongs to nothing is as far from walls.
    const FIRST: f64 = 0.5 * N as f64;
    const FELT: f64 = match N {
        3 => 2.5,
        _ => 4.0,
    };
    /// Cells between walls of which one is not felt: far enough that the other's knots are not either.
    const FAR: i64 = 64;

    #[inline(always)]
    fn felt<R: Real>(place: R, axis: &Axis) -> R::Mask {
        let (lower, upper) = (R::splat(axis.walls[0] + Self::FELT), R::splat(axis.walls[1] - Self::FELT));
        R::either(lower.above(place), place.above(upper))
    }

    /// Gives places that feel a wall the functions of the open knot vector, one by one.
    #[inline(always)]
    fn mend<R: Real>(along: &mut Along<R, N>, place: R, axis: &Axis) {
        let felt = Self::felt(place, axis);
        if !R::any(felt) {
            return;
        }
        let (places, mut base) = (place.numbers(), along.base.numbers());
        let (mut values, mut slopes) = (along.values.map(R::numbers), along.slopes.map(R::numbers));
        for lane in 0..R::COUNT {
            if R::holds(felt, lane) {
                let at = Self::of(axis).along(places.as_ref()[lane]);
                base.as_mut()[lane] = at.base;
                for node in 0..N {
                    values[node].as_mut()[lane] = at.values[node];
                    slopes[node].as_mut()[lane] = at.slopes[node];
                }
            }
        }
        let back = |numbers: R::Numbers| R::of_numbers(&numbers);
        *along = Along { base: back(base), values: values.map(back), slopes: slopes.map(back) };
    }

    /// A wall that is not there is put far behind the other.
    fn of(axis: &Axis) -> Self {
        let [lower, upper] = axis.walls;
        match (lower.is_finite(), upper.is_finite()) {
            (true, true) => Self { wall: lower, cells: (upper - lower) as i64 },
            (true, false) => Self { wall: lower, cells: Self::FAR },
            _ => Self { wall: upper - Self::FAR as f64, cells: Self::FAR },
        }
    }

    fn knot(&self, index: i64) -> f64 {
        if index <= Self::DEGREE {
            0.0
        } else if index > self.cells {
            self.cells as f64
        } else {
            Self::FIRST + (index - Self::DEGREE - 1) as f64
        }
    }

    /// Cox and de Boor's recurrence.
    fn along(&self, place: f64) -> Along<f64, N> {
        let t = place - self.wall;
        let span = (Self::DEGREE + 1 + (t - Self::FIRST).floor() as i64).clamp(Self::DEGREE, self.cells);
        let (mut values, mut lower) = ([0.0; N], [0.0; N]);
        values[0] = 1.0;
        for degree in 1..N {
            lower = values;
            let mut saved = 0.0;
            for function in 0..degree {
                let right = self.knot(span + 1 + function as i64);
                let left = self.knot(span + 1 + function as i64 - degree as i64);
                let share = lower[function] / (right - left);
                values[function] = saved + (right - t) * share;
                saved = (t - left) * share;
            }
            values[degree] = saved;
        }
        let mut slopes = [0.0; N];
        for (function, slope) in slopes.iter_mut().enumerate() {
            let first = span - Self::DEGREE + function as i64;
            let per = |value: f64, from: i64| {
                value * Self::DEGREE as f64 / (self.knot(from + Self::DEGREE) - self.knot(from))
            };
            let rising = if function > 0 { per(lower[function - 1], first) } else { 0.0 };
            let falling = if function + 1 < N { per(lower[function], first + 1) } else { 0.0 };
            *slope = rising - falling;
        }
        Along { base: self.wall + (span - Self::DEGREE) as f64, values, slopes }
    }

    /// Greville's abscissa: the mean of a function's inner knots.
    fn stand(&self, node: f64) -> f64 {
        let first = (node - self.wall) as i64;
        let sum = (1..=Self::DEGREE).map(|inner| self.knot(first + inner)).sum::<f64>();
        self.wall + sum / Self::DEGREE as f64
    }

    #[inline(always)]
    fn stands<R: Real>(node: R, axis: &Axis) -> R {
        let felt = Self::felt(node, axis);
        if !R::any(felt) {
            return node;
        }
        let mut stands = node.numbers();
        for (lane, stand) in stands.as_mut().iter_mut().enumerate() {
            if R::holds(felt, lane) {
                *stand = Self::of(axis).stand(*stand);
            }
        }
        R::of_numbers(&stands)
    }
}

/// The functions at one place of a tile, or at several in step, along all axes. Slopes are per m.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<S: Space, R, const N: usize> {
    pub base: [R; 3],
    pub values: [[R; N]; 3],
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
        for axis in 0..S::DIMENSION {
            let along = F::along(place.word(axis), &axes[axis]);
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
                let stand = |i: usize| F::stand(at.base + i as f64, &axis);
                let field: f64 = (0..N).map(|i| at.values[i] * stand(i)).sum();
                let slope: f64 = (0..N).map(|i| at.slopes[i] * stand(i)).sum();
                // A linear field is met: by uGIMP where no point's edge reaches behind the wall.
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
    fn no_spline_reaches_behind_a_wall_and_the_first_stands_on_it() {
        let at = Quadratic::along(2.0, &WALLED);
        assert_eq!((at.base, at.values), (2.0, [1.0, 0.0, 0.0]));
        let at = Cubic::along(2.0, &WALLED);
        assert_eq!((at.base, at.values), (2.0, [1.0, 0.0, 0.0, 0.0]));
        let at = Quadratic::along(14.0, &WALLED);
        assert_eq!((at.base, at.values), (12.0, [0.0, 0.0, 1.0]));
        let at = Cubic::along(14.0, &WALLED);
        assert_eq!((at.base, at.values), (11.0, [0.0, 0.0, 0.0, 1.0]));
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
