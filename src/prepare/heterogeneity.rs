//! The solid volume fraction of a packing from place to place, which the continuum that stands for it begins with: where a band forms, and how
//! many do, then follows from the grains and from no hint.
//!
//! Coarse-grained (Goldhirsch 2010) with the kernel of linear shape functions, W(x) W(y), W(s) = (1 - |s|/l)/l within a length l:
//!
//! ```text
//! Phi(x) = sum over grains i of A_i W(x - x_i) W(y - y_i) / integral of W(x - x') W(y - y') over what the packing fills
//! ```
//!
//! A_i is the area of a disc, spread over its height in slices: beside a plate grains lie in layers, and a cut that counted centres would tell where the cut lies between two of them.

use std::ops::Range;

use crate::base::math::PI;
use crate::base::space::{Plane, Space};
use crate::dem::grains::GrainRow;

/// Discs between two heights, periodic in x.
pub struct Packed<'a> {
    /// Solid volumes are added in this order.
    pub grains: &'a [GrainRow<Plane>],
    /// m.
    pub width: f64,
    /// What is looked at in y, m: of discs that reach beyond the part inside counts.
    pub fills: Range<f64>,
}

/// Slices of a disc.
const SLICES: usize = 8;

/// Middles of the slices of a disc of radius one, and their shares of its area.
fn slices() -> [[f64; 2]; SLICES] {
    let middle = |slice: usize| (2 * slice + 1) as f64 / SLICES as f64 - 1.0;
    let chord = |slice: usize| (1.0 - middle(slice) * middle(slice)).sqrt();
    let whole: f64 = (0..SLICES).map(chord).sum();
    std::array::from_fn(|slice| [middle(slice), chord(slice) / whole])
}

impl Packed<'_> {
    /// Solid volume fractions about the centres of `counts` equal cells, row by row in y, of a rectangle as wide as the packing and from y = 0 to `height`, m,
    /// by a kernel of `length`, m. Grains are added in their order.
    pub fn fractions(&self, counts: [usize; 2], height: f64, length: f64) -> Vec<f64> {
        let step = [self.width / counts[0] as f64, height / counts[1] as f64];
        let centre = |axis: usize, index: i64| (index as f64 + 0.5) * step[axis];
        // Cells whose centres may be within the kernel of a place.
        let near = |axis: usize, place: f64| {
            let index = |place: f64| (place / step[axis] - 0.5).floor() as i64;
            index(place - length)..index(place + length) + 2
        };
        let kernel = |away: f64| (1.0 - away.abs() / length).max(0.0) / length;
        let mut fractions = vec![0.0; counts[0] * counts[1]];
        let slices = slices();
        for grain in self.grains {
            let ([x, y], radius) = ([grain.hot.position[0], grain.hot.position[1]], grain.hot.radius);
            let area = PI * radius * radius;
            for [middle, share] in slices {
                let y = y + middle * radius;
                if !self.fills.contains(&y) {
                    continue;
                }
                for row in near(1, y).filter(|row| (0..counts[1] as i64).contains(row)) {
                    let of_row = share * area * kernel(centre(1, row) - y);
                    for column in near(0, x) {
                        let at = column.rem_euclid(counts[0] as i64) as usize;
                        fractions[row as usize * counts[0] + at] += of_row * kernel(centre(0, column) - x);
                    }
                }
            }
        }
        for (row, fractions) in fractions.chunks_mut(counts[0]).enumerate() {
            let y = centre(1, row as i64);
            let inside = integral((self.fills.end - y) / length) - integral((self.fills.start - y) / length);
            fractions.iter_mut().for_each(|fraction| *fraction /= inside);
        }
        fractions
    }
}

/// Places of points on a square lattice, of which those that are `filled` have one.
pub struct Places<'a> {
    /// Of the first place, m.
    pub first: [f64; 2],
    /// m.
    pub spacing: f64,
    /// Along x and y.
    pub counts: [usize; 2],
    /// Along x and y.
    pub periodic: [bool; 2],
    /// Row by row, x fastest; true where there is a point.
    pub filled: &'a [bool],
}

/// Share of its kernel that must lie within filled places for one to be told by the grains around it.
const WHOLE: f64 = 1.0 - 1e-6;

impl Places<'_> {
    /// How far the solid volume fraction about each place is from the mean of filled ones, by a kernel of `length`, m; 0 of those that are not
    /// filled. Beside a border, whose place says more than its grains do, a place has what the nearest one has whose kernel lies inside.
    /// None where no kernel lies inside, so that nothing is told.
    pub fn deviations<S: Space>(&self, grains: &[GrainRow<S>], length: f64) -> Option<Vec<f64>> {
        let [mut solid, mut room] = [0, 1].map(|_| vec![0.0; self.filled.len()]);
        let (slices, share) = (slices(), self.spacing * self.spacing);
        for grain in grains {
            let ([x, y], radius) = ([grain.hot.position[0], grain.hot.position[1]], grain.hot.radius);
            for [middle, share] in slices {
                self.spread(&mut solid, ([x, y + middle * radius], share * PI * radius * radius), length);
            }
        }
        for place in (0..self.filled.len()).filter(|place| self.filled[*place]) {
            // In four squares: one whose middle is at the end of a kernel reaches into it.
            let [x, y] = self.at(place);
            for [right, up] in [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]] {
                let at = [x + right * self.spacing, y + up * self.spacing];
                self.spread(&mut room, (at, 0.25 * share), length);
            }
        }
        let least = WHOLE * self.whole_room(length);
        let is_whole = |place: &usize| self.filled[*place] && room[*place] >= least;
        let whole: Vec<usize> = (0..self.filled.len()).filter(is_whole).collect();
        if whole.is_empty() {
            return None;
        }
        let away = |place: usize, other: usize| {
            let [at, other] = [place, other].map(|place| self.at(place));
            (0..2).map(|axis| self.apart(axis, at[axis] - other[axis]).powi(2)).sum::<f64>()
        };
        let value = |place: usize| {
            if is_whole(&place) {
                return solid[place] / room[place];
            }
            let nearest = whole.iter().min_by(|a, b| away(place, **a).total_cmp(&away(place, **b)));
            nearest.map_or(0.0, |nearest| solid[*nearest] / room[*nearest])
        };
        let filled: Vec<usize> = (0..self.filled.len()).filter(|place| self.filled[*place]).collect();
        let mut deviations = vec![0.0; self.filled.len()];
        filled.iter().for_each(|place| deviations[*place] = value(*place));
        let mean = filled.iter().map(|place| deviations[*place]).sum::<f64>() / filled.len().max(1) as f64;
        filled.iter().for_each(|place| deviations[*place] -= mean);
        Some(deviations)
    }

    /// The part of a kernel that lies within filled places where all around are.
    fn whole_room(&self, length: f64) -> f64 {
        let reach = (length / self.spacing).ceil() as i64 + 1;
        let along = |index: i64| {
            let away = |part: f64| ((index as f64 + part) * self.spacing).abs();
            let at = |part: f64| 0.5 * (1.0 - away(part) / length).max(0.0) / length;
            self.spacing * (at(-0.25) + at(0.25))
        };
        let sum: f64 = (-reach..=reach).map(along).sum();
        sum * sum
    }

    fn at(&self, place: usize) -> [f64; 2] {
        let index = [place % self.counts[0], place / self.counts[0]];
        std::array::from_fn(|axis| self.first[axis] + index[axis] as f64 * self.spacing)
    }

    /// A way along an axis, the shorter one of a period.
    fn apart(&self, axis: usize, way: f64) -> f64 {
        let period = self.counts[axis] as f64 * self.spacing;
        if self.periodic[axis] { way - (way / period).round() * period } else { way }
    }

    /// Spreads an amount at a point over the places around it.
    fn spread(&self, sums: &mut [f64], (at, amount): ([f64; 2], f64), length: f64) {
        let near = |axis: usize| {
            let index = |place: f64| ((place - self.first[axis]) / self.spacing).floor() as i64;
            let (count, periodic) = (self.counts[axis] as i64, self.periodic[axis]);
            let is_there = move |index: &i64| periodic || (0..count).contains(index);
            let weighed = move |index: i64| {
                let away = self.first[axis] + index as f64 * self.spacing - at[axis];
                (index.rem_euclid(count) as usize, (1.0 - away.abs() / length).max(0.0) / length)
            };
            (index(at[axis] - length)..index(at[axis] + length) + 2).filter(is_there).map(weighed)
        };
        for (row, of_row) in near(1) {
            for (column, of_column) in near(0) {
                sums[row * self.counts[0] + column] += amount * of_row * of_column;
            }
        }
    }
}

/// Of the kernel from the centre to `s` lengths away.
fn integral(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    s - 0.5 * s * s.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::ids::GrainId;
    use crate::dem::grains::Mover;

    /// Discs on a square lattice of this spacing, m, in a box.
    fn lattice(spacing: f64, [width, height]: [f64; 2]) -> Vec<GrainRow<Plane>> {
        let [columns, rows] = [width, height].map(|edge| (edge / spacing).round() as usize);
        let place = |index: usize| (index as f64 + 0.5) * spacing;
        let disc = |number: usize| {
            let at = nalgebra::Vector2::new(place(number % columns), place(number / columns));
            GrainRow::resting(GrainId(number as u64), at, 0.4 * spacing, 1.0, Mover::Free)
        };
        (0..columns * rows).map(disc).collect()
    }

    #[test]
    fn an_even_packing_has_one_fraction_up_to_where_it_ends() {
        let grains = lattice(0.01, [1.0, 1.0]);
        let packed = Packed { grains: &grains, width: 1.0, fills: 0.0..1.0 };
        // Cells of five lattice steps see the same at every centre; the kernel is cut at both ends.
        for fraction in packed.fractions([20, 20], 1.0, 0.1) {
            assert!((fraction / (PI * 0.16) - 1.0).abs() < 2e-3, "{fraction}");
        }
        assert!((integral(1.0) - integral(-1.0) - 1.0).abs() < 1e-15 && integral(0.0) == 0.0);
    }

    #[test]
    fn a_strip_that_lacks_grains_is_seen_by_points_and_borders_are_not_taken_for_one() {
        let mut grains = lattice(0.01, [1.0, 0.5]);
        // Every third column of grains of a strip 0.2 wide.
        grains.retain(|grain| {
            let x = grain.hot.position[0];
            !(0.4..0.6).contains(&x) || ((x / 0.01 - 0.5).round() as i64) % 3 != 0
        });
        let (counts, spacing) = ([48, 28], 0.025);
        let first = [-0.1 + 0.5 * spacing, -0.1 + 0.5 * spacing];
        let at = |place: usize| [0, 1].map(|axis| first[axis] + [place % 48, place / 48][axis] as f64 * spacing);
        let is_filled = |place: usize| (0.0..1.0).contains(&at(place)[0]) && (0.0..0.5).contains(&at(place)[1]);
        let filled: Vec<bool> = (0..counts[0] * counts[1]).map(is_filled).collect();
        let places = Places { first, spacing, counts, periodic: [false; 2], filled: &filled };
        let found = places.deviations(&grains, 0.05).unwrap();
        assert_eq!(places.deviations(&grains, 0.3), None);
        let (even, strip) = (PI * 0.16, 0.2 * (1.0 / 3.0));
        for (place, deviation) in found.iter().enumerate().filter(|(place, _)| filled[*place]) {
            let [x, _] = at(place);
            let wanted = if (0.45..0.55).contains(&x) {
                -even * (1.0 / 3.0 - strip)
            } else if !(0.35..=0.65).contains(&x) {
                even * strip
            } else {
                continue;
            };
            assert!((deviation - wanted).abs() < 0.012, "{x}: {deviation} for {wanted}");
        }
        assert!(found.iter().sum::<f64>().abs() < 1e-10);
        assert!(found.iter().zip(&filled).all(|(deviation, filled)| *filled || *deviation == 0.0));
        // Across a period.
        let round =
            Places { first: [0.0125; 2], counts: [40, 20], periodic: [true; 2], filled: &[true; 800], ..places };
        let moved: Vec<_> = grains
            .iter()
            .cloned()
            .map(|mut grain| {
                grain.hot.position[0] = (grain.hot.position[0] + 0.5) % 1.0;
                grain
            })
            .collect();
        let found = round.deviations(&moved, 0.05).unwrap();
        assert!((found[0] + even * (1.0 / 3.0 - strip)).abs() < 0.012, "{}", found[0]);
    }

    #[test]
    fn a_hole_is_seen_where_it_is_and_across_the_period() {
        let mut grains = lattice(0.01, [1.0, 1.0]);
        let is_in_hole = |grain: &GrainRow<Plane>| {
            let (x, y) = (grain.hot.position[0], grain.hot.position[1]);
            !(0.05..=0.95).contains(&x) && (0.45..0.55).contains(&y)
        };
        grains.retain(|grain| !is_in_hole(grain));
        let packed = Packed { grains: &grains, width: 1.0, fills: 0.0..1.0 };
        let fractions = packed.fractions([10, 10], 1.0, 0.1);
        let even = PI * 0.16;
        let lost = |column: usize, row: usize| 1.0 - fractions[row * 10 + column] / even;
        // Four cells are as near to its middle, at the period's end and half way up.
        for (column, row) in [(0, 4), (9, 4), (0, 5), (9, 5)] {
            assert!((lost(column, row) - 0.25).abs() < 0.01, "{column} {row}: {}", lost(column, row));
        }
        assert!(lost(5, 5).abs() < 2e-3 && lost(0, 9).abs() < 2e-3);
        // Nothing is lost but the hole: every disc counts once in all.
        let sum: f64 = fractions.iter().sum();
        assert!((sum / (100.0 * even) - 0.99).abs() < 1e-3, "{sum}");
    }
}
