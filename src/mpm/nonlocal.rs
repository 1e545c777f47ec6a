//! Nonlocal strain: what a point answers to is a mean over the material around it, which gives a continuum the length that a local one
//! lacks (Bazant & Jirasek 2002; Liu et al. 2016, appendix A, with volumes, which that leaves out):
//!
//! ```text
//! <G>_p = sum_q w_pq G_q        w_pq = k(|x_p - x_q|) V_q / sum_r k(|x_p - x_r|) V_r        k(r) = (1 - (r/R)^2)^2 within R
//! ```
//!
//! with G the increment of deformation F(n+1) F(n)^-1 - 1. Stress of the mean strain does work on that of every single point, so that a
//! power is the same on both sides only with the adjoint of it on the stress,
//!
//! ```text
//! tau*_q = sum_p w_pq V_p/V_q tau_p        sum_q V_q tau*_q:G_q = sum_p V_p tau_p:<G>_p
//! ```
//!
//! with V here those of the start, for which Kirchhoff stress is. Sums over points are in the order of their ids. Points near a border have their mean over what there is of material.
//!
//! Liu et al. compute what is around an element on the fly, of the present step where an element has had its turn and of the step before
//! where it has not, which depends on the order of elements. All of the present step is `lag` = 0; all but the point itself of the step
//! before, which needs no exchange between strain and stress, `lag` = 1:
//!
//! ```text
//! <G>_p = w_pp G_p(n) + sum_(q != p) w_pq G_q(n - 1)
//! ```
//!
//! Without the adjoint, which Liu et al. leave out, deformation finer than R is answered by stresses that do not resist it: a specimen in
//! biaxial compression blows up within 0.2 % of strain (VALIDATION.md).

use std::ops::{Add, Mul};

use crate::base::ids::{PointId, Row};
use crate::base::keys::{Form, LENGTH, POSITIVE, choose, count, flag, number, text};
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;

/// How strain is averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nonlocal {
    /// R, m.
    pub radius: f64,
    pub places: Places,
    /// Whether stress is averaged by the adjoint.
    pub adjoint: bool,
    /// Increments that neighbours count with: their own of now, or that of the step before.
    pub lag: u64,
}

/// Which places distances are between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// Those of the start: weights never change.
    Reference,
    /// Those of now.
    Current,
}

impl Nonlocal {
    pub const BLANK: Self = Self { radius: 0.0, places: Places::Reference, adjoint: true, lag: 0 };

    /// The keys of `[nonlocal]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let about = "the radius within which strain is averaged";
        form.number(&mut self.radius, number("radius", about, LENGTH, POSITIVE, "\"20 cm\""));
        let about = "which places of points distances are between: reference, those of the start, or current";
        let key = text("places", about, "\"reference\"").or("reference");
        choose(
            form,
            &mut self.places,
            "places",
            key,
            &[("reference", Places::Reference), ("current", Places::Current)],
        );
        let about = "whether stress is averaged by the adjoint, so that its power is that of the averaged strain";
        form.flag(&mut self.adjoint, flag("adjoint", about, "false").or("true"));
        let about = "steps by which the strain of neighbours is older than that of the point";
        form.count(&mut self.lag, count("lag", about, (0, 1), "1").or("0"));
    }

    /// k at a distance, m.
    pub fn kernel(&self, distance: f64) -> f64 {
        let share = distance / self.radius;
        let rest = (1.0 - share * share).max(0.0);
        rest * rest
    }
}

/// A point as others see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen<S: Space> {
    pub id: PointId,
    pub place: S::Vector,
    /// At the start, for which Kirchhoff stress is, and as weights count it, m3.
    pub volume_start: f64,
    pub volume: f64,
}

/// Weights of the points around each of some points.
#[derive(Clone, Debug, Default)]
pub struct Weights {
    /// Where the neighbours of each begin.
    firsts: Vec<usize>,
    /// Row of a neighbour, k V of it, and k.
    neighbours: Vec<(Row, f64, f64)>,
    /// sum k V of each.
    sums: Vec<f64>,
}

impl Weights {
    /// Of the first `owned` of these points among all of them, whose `periods` are those of a cell.
    pub fn of<S: Space>(how: &Nonlocal, seen: &[Seen<S>], owned: usize, cell: &Cell<S>) -> Self {
        let bins = Bins::of(how.radius, seen);
        let mut weights = Self { firsts: vec![0], ..Self::default() };
        let mut found: Vec<(PointId, Row, f64)> = Vec::new();
        for point in &seen[..owned] {
            found.clear();
            bins.for_each_near(seen, cell, point, |row, distance| found.push((seen[row].id, row as Row, distance)));
            found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.2.total_cmp(&b.2)));
            let mut sum = 0.0;
            for (_, row, distance) in &found {
                let kernel = how.kernel(*distance);
                let weight = kernel * seen[*row as usize].volume;
                weights.neighbours.push((*row, weight, kernel));
                sum += weight;
            }
            weights.firsts.push(weights.neighbours.len());
            weights.sums.push(sum);
        }
        weights
    }

    /// sum k V of each of the points.
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }

    /// Mean over the points around one, of what each row has.
    pub fn mean<T>(&self, point: usize, zero: T, of: impl Fn(usize) -> T) -> T
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        let sum = self.around(point).fold(zero, |sum, (row, weight, _)| sum + of(*row as usize) * *weight);
        sum * (1.0 / self.sums[point])
    }

    /// w_pp: what a point and its images have in its own mean.
    pub fn own(&self, point: usize) -> f64 {
        let own = self.around(point).filter(|(row, ..)| *row as usize == point);
        own.map(|(_, weight, _)| weight).sum::<f64>() / self.sums[point]
    }

    /// The adjoint of the mean, of V tau/sum of every row, V being that of the start; times V of now over that of the start where weights
    /// count volumes of now.
    pub fn adjoint<T>(&self, point: usize, zero: T, of: impl Fn(usize) -> T) -> T
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        self.around(point).fold(zero, |sum, (row, _, kernel)| sum + of(*row as usize) * *kernel)
    }

    fn around(&self, point: usize) -> impl Iterator<Item = &(Row, f64, f64)> {
        self.neighbours[self.firsts[point]..self.firsts[point + 1]].iter()
    }
}

/// Points sorted into boxes a little wider than the radius, so that rounding puts no neighbour two boxes away.
pub struct Bins {
    radius: f64,
    edge: f64,
    /// How far apart places are at most along each axis, m.
    spread: [f64; 3],
    /// Box and row, sorted.
    rows: Vec<([i64; 3], usize)>,
}

impl Bins {
    pub fn of<S: Space>(radius: f64, seen: &[Seen<S>]) -> Self {
        let edge = radius * (1.0 + 1e-9);
        let mut rows: Vec<([i64; 3], usize)> =
            seen.iter().enumerate().map(|(row, point)| (box_of::<S>(&point.place, edge), row)).collect();
        rows.sort_unstable();
        let along = |axis: usize, pick: fn(f64, f64) -> f64| {
            seen.iter().map(|point| point.place[axis]).reduce(pick).unwrap_or_default()
        };
        let spread = |axis: usize| match axis < S::DIMENSION {
            true => along(axis, f64::max) - along(axis, f64::min),
            false => 0.0,
        };
        Self { radius, edge, spread: [spread(0), spread(1), spread(2)], rows }
    }

    /// All points within the radius of one, with those of their images across periods of a cell that are: each with its distance, m, which is
    /// the same to the bit from either of two.
    pub fn for_each_near<S: Space>(
        &self,
        seen: &[Seen<S>],
        cell: &Cell<S>,
        point: &Seen<S>,
        mut found: impl FnMut(usize, f64),
    ) {
        // Periods may be shorter than the radius, and places many periods apart by now.
        let shifts = |axis: usize| {
            let period = |axis: usize| cell.shift(std::array::from_fn(|other| i32::from(other == axis)))[axis];
            let most = match axis < S::DIMENSION && cell.periodic[axis] {
                true => (self.reach(seen, point, axis) / period(axis)).floor() as i32,
                false => 0,
            };
            -most..=most
        };
        for z in shifts(2) {
            for y in shifts(1) {
                for x in shifts(0) {
                    let shift = cell.shift([x, y, z]);
                    self.for_each_box::<S>(&(point.place + shift), |row| {
                        let distance = ((seen[row].place - point.place) - shift).norm();
                        if distance < self.radius {
                            found(row, distance);
                        }
                    });
                }
            }
        }
    }

    /// How far an image within the radius of a point may have to be shifted along an axis, m.
    fn reach<S: Space>(&self, seen: &[Seen<S>], point: &Seen<S>, axis: usize) -> f64 {
        let apart = seen.first().map_or(0.0, |first| (first.place[axis] - point.place[axis]).abs());
        self.radius + self.spread[axis] + apart
    }

    fn for_each_box<S: Space>(&self, place: &S::Vector, mut found: impl FnMut(usize)) {
        let [x, y, z] = box_of::<S>(place, self.edge);
        let along = |axis: usize, at: i64| if axis < S::DIMENSION { at - 1..=at + 1 } else { at..=at };
        for i in along(0, x) {
            for j in along(1, y) {
                for k in along(2, z) {
                    let first = self.rows.partition_point(|(at, _)| *at < [i, j, k]);
                    self.rows[first..].iter().take_while(|(at, _)| *at == [i, j, k]).for_each(|(_, row)| found(*row));
                }
            }
        }
    }
}

fn box_of<S: Space>(place: &S::Vector, edge: f64) -> [i64; 3] {
    std::array::from_fn(|axis| if axis < S::DIMENSION { (place[axis] / edge).floor() as i64 } else { 0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;
    use crate::base::space::Plane;

    type Vector = <Plane as Space>::Vector;

    fn points(along: usize) -> Vec<Seen<Plane>> {
        let place = |id: usize| Vector::new((id % along) as f64 + 0.5, (id / along) as f64 + 0.5) * 0.1;
        (0..along * along)
            .map(|id| {
                let volume = 1.0 + 0.5 * ((id * 7) % 5) as f64;
                Seen { id: PointId(id as u64), place: place(id), volume_start: 1.0 + ((id * 3) % 4) as f64, volume }
            })
            .collect()
    }

    fn cell(periodic: bool) -> Cell<Plane> {
        Cell::cuboid(Vector::zeros(), Vector::new(1.0, 1.0), [periodic, periodic, false])
    }

    const HOW: Nonlocal = Nonlocal { radius: 0.25, ..Nonlocal::BLANK };

    #[test]
    fn constants_are_kept_and_inner_linear_fields_of_equal_points() {
        let mut seen = points(10);
        let weights = Weights::of(&HOW, &seen, 100, &cell(false));
        assert!((0..100).all(|point| (weights.mean(point, 0.0, |_| 3.0) - 3.0).abs() < 1e-14));
        seen.iter_mut().for_each(|point| point.volume = 1.0);
        let weights = Weights::of(&HOW, &seen, 100, &cell(false));
        for (row, point) in
            seen.iter().enumerate().filter(|(_, point)| (point.place - Vector::new(0.5, 0.5)).norm() < 0.25)
        {
            let mean = weights.mean(row, 0.0, |other| seen[other].place.x - 2.0 * seen[other].place.y);
            assert!((mean - point.place.x + 2.0 * point.place.y).abs() < 1e-12);
        }
    }

    #[test]
    fn a_point_has_its_share_in_its_own_mean() {
        let seen = points(10);
        let weights = Weights::of(&HOW, &seen, 100, &cell(false));
        for row in 0..100 {
            let of_own = weights.mean(row, 0.0, |other| f64::from(u8::from(other == row)));
            assert!((weights.own(row) - of_own).abs() < 1e-15 && of_own > 0.05, "{row}");
        }
    }

    /// What the mean of a parabola has too much is of second order in the radius.
    #[test]
    fn means_are_of_second_order_in_the_radius() {
        let along = 101;
        let mut seen = points(along);
        seen.iter_mut().for_each(|point| {
            point.place *= 10.0 / along as f64;
            point.volume = 1.0;
        });
        let middle = along * along / 2;
        let off = |radius: f64| {
            let weights = Weights::of(&Nonlocal { radius, ..HOW }, &seen, seen.len(), &cell(false));
            let place = seen[middle].place.x;
            weights.mean(middle, 0.0, |other| (seen[other].place.x - place).powi(2))
        };
        let order = math::ln(off(0.2) / off(0.1)) / math::ln(2.0);
        assert!((order - 2.0).abs() < 0.05, "{order}");
    }

    #[test]
    fn the_adjoint_keeps_power() {
        let seen = points(10);
        let weights = Weights::of(&HOW, &seen, 100, &cell(true));
        let strain = |row: usize| ((row * 37) % 11) as f64 - 5.0;
        let stress = |row: usize| ((row * 53) % 13) as f64 - 6.0;
        let scaled = |row: usize| stress(row) * seen[row].volume_start / weights.sums()[row];
        let nonlocal: f64 =
            (0..100).map(|row| seen[row].volume_start * stress(row) * weights.mean(row, 0.0, strain)).sum();
        let back = |row: usize| weights.adjoint(row, 0.0, scaled) * seen[row].volume / seen[row].volume_start;
        let local: f64 = (0..100).map(|row| seen[row].volume_start * back(row) * strain(row)).sum();
        assert!((nonlocal / local - 1.0).abs() < 1e-12, "{nonlocal} {local}");
    }

    /// Where a period is shorter than the radius, a mean is that of several periods laid side by side, and the adjoint keeps power.
    #[test]
    fn images_count_each() {
        let how = Nonlocal { radius: 0.42, ..HOW };
        let place = |id: usize| Vector::new((id % 2) as f64 + 0.5, (id / 2) as f64 + 0.5) * 0.1;
        let of = |id: usize, place: Vector| Seen {
            id: PointId(id as u64),
            place,
            volume_start: 1.0,
            volume: 1.0 + 0.1 * (id % 2) as f64,
        };
        let short: Vec<Seen<Plane>> = (0..20).map(|id| of(id, place(id))).collect();
        let narrow = Cell::cuboid(Vector::zeros(), Vector::new(0.2, 1.0), [true, false, false]);
        let weights = Weights::of(&how, &short, 20, &narrow);
        let long: Vec<Seen<Plane>> = (0..10)
            .flat_map(|copy| (0..20).map(move |id| (copy, id)))
            .map(|(copy, id)| of(20 * copy + id, place(id) + Vector::new(0.2 * copy as f64, 0.0)))
            .collect();
        let wide = Weights::of(&how, &long, 200, &cell(false));
        for row in 0..20 {
            let field = |row: usize| ((row % 20 * 37) % 11) as f64 - 5.0;
            let (found, wanted) = (weights.mean(row, 0.0, field), wide.mean(100 + row, 0.0, field));
            assert!((found - wanted).abs() < 1e-12, "{row}: {found} {wanted}");
            let of_own = weights.mean(row, 0.0, |other| f64::from(u8::from(other == row)));
            assert!((weights.own(row) - of_own).abs() < 1e-15);
        }
        let (strain, stress) = (|row: usize| (row as f64).sqrt(), |row: usize| ((row * 53) % 13) as f64 - 6.0);
        let nonlocal: f64 = (0..20).map(|row| stress(row) * weights.mean(row, 0.0, strain)).sum();
        let scaled = |row: usize| stress(row) / weights.sums()[row];
        let local: f64 = (0..20).map(|row| weights.adjoint(row, 0.0, scaled) * short[row].volume * strain(row)).sum();
        assert!((nonlocal / local - 1.0).abs() < 1e-12, "{nonlocal} {local}");
        // Places that have gone on by periods are the same points.
        let mut gone = short.clone();
        gone.iter_mut().step_by(3).for_each(|point| point.place.x += 0.6);
        let after = Weights::of(&how, &gone, 20, &narrow);
        assert!((0..20).all(|row| (after.sums()[row] / weights.sums()[row] - 1.0).abs() < 1e-12));
    }

    /// Means over a graded mesh: constants are kept, and the adjoint keeps power, whatever volumes are.
    #[test]
    fn graded_meshes_keep_constants_and_power() {
        let mut seen = Vec::new();
        let mut edge = 0.02;
        let mut at = 0.0;
        for column in 0..12_u64 {
            for row in 0..10_u64 {
                let volume = edge * 0.1;
                let place = Vector::new(at + 0.5 * edge, 0.1 * (row as f64 + 0.5));
                seen.push(Seen { id: PointId(10 * column + row), place, volume_start: volume, volume });
            }
            at += edge;
            edge *= 1.3;
        }
        let weights = Weights::of(&HOW, &seen, seen.len(), &cell(false));
        assert!((0..seen.len()).all(|point| (weights.mean(point, 0.0, |_| 3.0) - 3.0).abs() < 1e-14));
        let (strain, stress) = (|row: usize| ((row * 37) % 11) as f64, |row: usize| ((row * 53) % 13) as f64 - 6.0);
        let scaled = |row: usize| stress(row) * seen[row].volume_start / weights.sums()[row];
        let nonlocal: f64 =
            (0..seen.len()).map(|row| seen[row].volume_start * stress(row) * weights.mean(row, 0.0, strain)).sum();
        let local: f64 =
            (0..seen.len()).map(|row| seen[row].volume_start * weights.adjoint(row, 0.0, scaled) * strain(row)).sum();
        assert!((nonlocal / local - 1.0).abs() < 1e-12, "{nonlocal} {local}");
    }

    /// All rows of a periodic grid have the same neighbours.
    #[test]
    fn periods_are_closed() {
        let seen = points(10);
        let weights = Weights::of(&HOW, &seen, 100, &cell(true));
        let count = weights.around(44).count();
        assert!((0..100).all(|row| weights.around(row).count() == count) && count > 9, "{count}");
    }
}
