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
use crate::base::space::Plane;
use crate::dem::grains::GrainRow;

/// Discs between two heights, periodic in x.
pub struct Packed<'a> {
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
