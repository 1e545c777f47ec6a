//! Pieces of packing where a period of the domain joins them to themselves. A piece's edge does not divide the period, so that grains from
//! two places of the piece stand face to face across the periodic boundary, some in each other, some with gaps between.
//!
//! What is cut has as much solid as the space that it is cut for: grains whose centres lie beside the boundary are taken in, or left out,
//! until those that are in stick out of the domain by as much as those that are not stick into it. Those near the boundary are then moved
//! apart until they overlap no more than grains of the piece do. Grains that face each other by chance do not fit as those of one packing
//! do: the boundary stays looser (docs/validation/hybrid_experiments.md). All of this is serial and goes by ids, and so is the same
//! whoever does it.

use crate::base::ids::GrainId;
use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::dem::cell::Cell;
use crate::dem::grains::GrainRow;
use crate::dem::walls::place_beside;
use crate::prepare::packed::Packing;

/// A grain of pieces side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laid<S: Space> {
    /// As [`Packing::side_by_side`] counts them.
    pub id: GrainId,
    /// Of its centre, m; as laid it may be beyond the domain's ends, joined it is not.
    pub place: S::Vector,
    /// m.
    pub radius: f64,
    /// kg.
    pub mass: f64,
}

/// A domain with periods, and what is there at the start.
pub struct Join<'a, S: Space> {
    cell: &'a Cell<S>,
    bodies: &'a [Body<S>],
    /// Whether there is material at a place of the domain.
    is_material: &'a dyn Fn(&S::Vector) -> bool,
    /// Of the largest grain, m.
    diameter: f64,
    /// Mean overlap of grains of the piece that touch, as a share of the sum of their radii.
    overlap: f64,
}

/// How far from a periodic boundary grains are moved, in diameters of the largest.
const BAND: f64 = 6.0;
/// What pairs are listed beside those that touch, in such diameters.
const SKIN: f64 = 0.3;
/// Overlap beyond the piece's own at which grains are apart, as a share of the sum of radii, and sweeps over all pairs at most.
const APART: f64 = 2e-4;
const SWEEPS_MAX: usize = 1000;
/// Of two grains that overlap by more than this share of the sum of their radii all the same the one of the higher id is left out.
const OVERLAP_MAX: f64 = 0.02;

impl<'a, S: Space> Join<'a, S> {
    /// Of a domain and its bodies, with the overlap that grains of `piece` have; `is_material` is asked for places of the domain.
    pub fn of(
        (cell, bodies): (&'a Cell<S>, &'a [Body<S>]),
        is_material: &'a dyn Fn(&S::Vector) -> bool,
        piece: &Packing<S>,
    ) -> Self {
        let diameter = 2.0 * piece.grains.iter().map(|grain| grain.hot.radius).fold(0.0, f64::max);
        Self { cell, bodies, is_material, diameter, overlap: overlap_of(piece, diameter) }
    }

    fn axes(&self) -> impl Iterator<Item = usize> + use<'_, 'a, S> {
        (0..S::DIMENSION).filter(|axis| self.cell.periodic[*axis])
    }

    /// Where the domain begins and ends along an axis, m.
    fn ends(&self, axis: usize) -> [f64; 2] {
        let lower = self.cell.corner[axis];
        [lower, lower + self.cell.edges[axis * S::DIMENSION + axis]]
    }

    /// Pieces of these edges along a periodic axis, that a grain beside the domain is one of theirs too: where the first of them begins, m,
    /// and their number.
    pub fn pieces(&self, axis: usize, edge: f64) -> (f64, u64) {
        let [lower, upper] = self.ends(axis);
        (lower - edge, 2 + ((upper - lower) / edge).ceil() as u64)
    }

    /// Whether a grain there may be one of the domain's, or touches one: what [`Self::joined`] must be told of.
    pub fn is_near(&self, place: &S::Vector) -> bool {
        self.axes().all(|axis| {
            let [lower, upper] = self.ends(axis);
            (lower - self.diameter..upper + self.diameter).contains(&place[axis])
        })
    }

    /// Whether a grain there is moved, or others are moved away from it.
    pub fn is_at_boundary(&self, place: &S::Vector) -> bool {
        self.is_within(place, (BAND + 1.0 + 2.0 * SKIN) * self.diameter)
    }

    fn is_within(&self, place: &S::Vector, reach: f64) -> bool {
        self.axes().any(|axis| self.ends(axis).iter().any(|end| (place[axis] - end).abs() < reach))
    }

    /// Those of the domain, at home in it; of grains in the order of their ids, images and all.
    pub fn joined(&self, mut laid: Vec<Laid<S>>) -> Vec<Laid<S>> {
        for axis in self.axes() {
            self.cut(axis, &mut laid);
        }
        laid.iter_mut().for_each(|grain| grain.place = wrapped(self.cell, &grain.place));
        let mut crowd = Crowd::of(self, laid);
        crowd.move_apart();
        crowd.left()
    }

    /// Leaves out what does not belong between the two ends of an axis.
    fn cut(&self, axis: usize, laid: &mut Vec<Laid<S>>) {
        let [lower, upper] = self.ends(axis);
        // Elsewhere what lies beyond another end would be counted twice.
        let is_counted = |grain: &&Laid<S>| {
            let others = self.axes().filter(|other| *other != axis);
            let mut inside = others.map(|other| (self.ends(other), grain.place[other]));
            inside.all(|([lower, upper], at)| (lower..upper).contains(&at)) && self.joins(axis, &grain.place)
        };
        let is_inside = |grain: &Laid<S>| (lower..upper).contains(&grain.place[axis]);
        let mut surplus = 0.0;
        for grain in laid.iter().filter(is_counted) {
            let beyond = |end: f64| share_beyond((grain.place[axis] - end) / grain.radius);
            let all = f64::from(u8::from(is_inside(grain)));
            surplus += grain.mass * (all - (beyond(lower) - beyond(upper)));
        }
        // From the end outwards, or inwards.
        let way = |grain: &Laid<S>| (grain.place[axis] - upper) * -f64::signum(surplus);
        let may_change = |grain: &&Laid<S>| (0.0..self.diameter).contains(&way(grain)) && is_counted(grain);
        let mut next: Vec<&Laid<S>> = laid.iter().filter(may_change).collect();
        next.sort_by(|one, other| way(one).total_cmp(&way(other)).then(one.id.cmp(&other.id)));
        let (mut changed, mut left) = (Vec::new(), surplus.abs());
        for grain in next {
            if (left - grain.mass).abs() >= left {
                break;
            }
            left -= grain.mass;
            changed.push(grain.id);
        }
        changed.sort_unstable();
        laid.retain(|grain| is_inside(grain) != changed.binary_search(&grain.id).is_ok());
    }

    /// Whether there is material on both sides of the end of an axis, beside a place.
    fn joins(&self, axis: usize, place: &S::Vector) -> bool {
        let [lower, upper] = self.ends(axis);
        [lower, upper].into_iter().zip([1.0, -1.0]).all(|(end, inwards)| {
            let mut beside = *place;
            beside[axis] = end + 1e-3 * inwards * self.diameter;
            (self.is_material)(&beside)
        })
    }

    fn between(&self, from: &S::Vector, to: &S::Vector) -> S::Vector {
        *to - *from - self.cell.shift(self.cell.image_towards(from, to))
    }
}

/// The image of a place that lies in the cell.
pub fn wrapped<S: Space>(cell: &Cell<S>, place: &S::Vector) -> S::Vector {
    let mut place = *place;
    cell.wrap(&mut place, &mut S::Vector::zero());
    place
}

/// Share of a sphere that lies beyond a plane from which its centre is so many radii away; of a disc about.
fn share_beyond(away: f64) -> f64 {
    let share = (0.5 * (1.0 + away)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Mean overlap of the pairs of a piece that touch, as a share of the sum of their radii.
fn overlap_of<S: Space>(piece: &Packing<S>, diameter: f64) -> f64 {
    let grain = |row: &GrainRow<S>| (row.hot.position, row.hot.radius);
    let grains: Vec<_> = piece.grains.iter().map(grain).collect();
    let (mut sum, mut count) = (0.0, 0u64);
    for (one, other) in pairs(&piece.cell, &grains, diameter, |_| true) {
        let [(from, radius), (to, other_radius)] = [grains[one], grains[other]];
        let way = to - from - piece.cell.shift(piece.cell.image_towards(&from, &to));
        let overlap = 1.0 - way.norm() / (radius + other_radius);
        if overlap > 0.0 {
            (sum, count) = (sum + overlap, count + 1);
        }
    }
    if count > 0 { sum / count as f64 } else { 0.0 }
}

/// Pairs of rows, each once and in their order, that are no farther apart than `reach`, m, and of which one `may_move`.
fn pairs<S: Space>(
    cell: &Cell<S>,
    grains: &[(S::Vector, f64)],
    reach: f64,
    may_move: impl Fn(usize) -> bool,
) -> Vec<(usize, usize)> {
    let mut bins = [1i64; 3];
    for (axis, bins) in bins.iter_mut().enumerate().take(S::DIMENSION) {
        *bins = ((cell.edges[axis * S::DIMENSION + axis] / reach) as i64).max(1);
    }
    // What lies beyond the ends of an axis without period is of a bin beyond.
    let bin_of = |place: &S::Vector| -> [i64; 3] {
        let at = cell.fraction(place);
        std::array::from_fn(|axis| if axis < S::DIMENSION { (at[axis] * bins[axis] as f64).floor() as i64 } else { 0 })
    };
    let wrap = |mut bin: [i64; 3]| {
        for axis in (0..S::DIMENSION).filter(|axis| cell.periodic[*axis]) {
            bin[axis] = bin[axis].rem_euclid(bins[axis]);
        }
        bin
    };
    let mut sorted: Vec<([i64; 3], usize)> =
        grains.iter().enumerate().map(|(row, (place, _))| (wrap(bin_of(place)), row)).collect();
    sorted.sort_unstable();
    let rows_in = |bin: [i64; 3]| {
        let first = sorted.partition_point(|(other, _)| *other < bin);
        sorted[first..].iter().take_while(move |(other, _)| *other == bin).map(|(_, row)| *row)
    };
    let mut found = Vec::new();
    let across = if S::DIMENSION == 2 { 0..=0 } else { -1..=1 };
    for (one, (place, _)) in grains.iter().enumerate().filter(|(row, _)| may_move(*row)) {
        let [x, y, z] = bin_of(place);
        for step in across.clone().flat_map(|z| (-1..=1).flat_map(move |y| (-1..=1).map(move |x| [x, y, z]))) {
            for other in rows_in(wrap([x + step[0], y + step[1], z + step[2]])) {
                let to = grains[other].0;
                let way = to - *place - cell.shift(cell.image_towards(place, &to));
                // Of two that may move each finds the other.
                if other != one && way.norm() < reach {
                    found.push((one.min(other), one.max(other)));
                }
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Grains that are moved apart.
struct Crowd<'a, S: Space> {
    join: &'a Join<'a, S>,
    laid: Vec<Laid<S>>,
    /// Rows of those at a boundary, their places and radii, and which of them move.
    rows: Vec<usize>,
    grains: Vec<(S::Vector, f64)>,
    moves: Vec<bool>,
}

impl<'a, S: Space> Crowd<'a, S> {
    fn of(join: &'a Join<'a, S>, laid: Vec<Laid<S>>) -> Self {
        let rows: Vec<usize> = (0..laid.len()).filter(|row| join.is_at_boundary(&laid[*row].place)).collect();
        let grains: Vec<_> = rows.iter().map(|row| (laid[*row].place, laid[*row].radius)).collect();
        let moves = grains.iter().map(|(place, _)| join.is_within(place, BAND * join.diameter)).collect();
        Self { join, laid, rows, grains, moves }
    }

    fn pairs(&self) -> Vec<(usize, usize)> {
        pairs(self.join.cell, &self.grains, (1.0 + SKIN) * self.join.diameter, |row| self.moves[row])
    }

    /// How deep two overlap beyond what grains of the piece do, as a share of the sum of their radii, and the way from one to the other.
    fn overlap(&self, one: usize, other: usize) -> (f64, S::Vector) {
        let [(from, radius), (to, other_radius)] = [self.grains[one], self.grains[other]];
        let way = self.join.between(&from, &to);
        (1.0 - self.join.overlap - way.norm() / (radius + other_radius), way)
    }

    fn move_apart(&mut self) {
        let (mut pairs, mut listed) = (self.pairs(), self.grains.clone());
        for _ in 0..SWEEPS_MAX {
            let mut deepest = 0.0f64;
            for &(one, other) in &pairs {
                let (overlap, way) = self.overlap(one, other);
                if overlap > 0.0 {
                    deepest = deepest.max(overlap);
                    self.part(one, other, (overlap, way));
                }
            }
            deepest = deepest.max(self.come_off_bodies());
            if deepest < APART {
                break;
            }
            let moved = self.grains.iter().zip(&listed).map(|((now, _), (then, _))| (*now - *then).norm());
            if moved.fold(0.0, f64::max) > 0.5 * SKIN * self.join.diameter {
                (pairs, listed) = (self.pairs(), self.grains.clone());
            }
        }
    }

    fn part(&mut self, one: usize, other: usize, (overlap, way): (f64, S::Vector)) {
        let (far, apart) = (way.norm(), overlap * (self.grains[one].1 + self.grains[other].1));
        let mut along = way;
        if far > 0.0 {
            along = way * (1.0 / far);
        } else {
            along[0] = 1.0;
        }
        let share = if self.moves[one] && self.moves[other] { 0.5 } else { 1.0 };
        if self.moves[one] {
            self.grains[one].0 -= along * (share * apart);
        }
        if self.moves[other] {
            self.grains[other].0 += along * (share * apart);
        }
    }

    /// Returns how deep one was in a body, as a share of the largest diameter.
    fn come_off_bodies(&mut self) -> f64 {
        let (mut deepest, join) = (0.0f64, self.join);
        for ((place, radius), _) in self.grains.iter_mut().zip(&self.moves).filter(|(_, moves)| **moves) {
            for body in join.bodies {
                let Some(near) = body.nearest(&place_beside(body, join.cell, place)) else { continue };
                if near.distance < *radius {
                    *place += near.normal * (*radius - near.distance);
                    deepest = deepest.max((*radius - near.distance) / join.diameter);
                }
            }
        }
        deepest
    }

    /// All grains where they have come to, but for those that had no room.
    fn left(mut self) -> Vec<Laid<S>> {
        let pairs = self.pairs().into_iter();
        let mut deep: Vec<_> = pairs.map(|(one, other)| (self.overlap(one, other).0, one, other)).collect();
        deep.retain(|(overlap, ..)| *overlap > OVERLAP_MAX);
        deep.sort_by(|one, other| other.0.total_cmp(&one.0).then((one.1, one.2).cmp(&(other.1, other.2))));
        let mut is_out = vec![false; self.laid.len()];
        for (_, one, other) in deep {
            let [one, other] = [self.rows[one], self.rows[other]];
            if !is_out[one] && !is_out[other] {
                is_out[if self.laid[one].id > self.laid[other].id { one } else { other }] = true;
            }
        }
        for (row, (place, _)) in self.rows.iter().zip(&self.grains) {
            self.laid[*row].place = wrapped(self.join.cell, place);
        }
        let mut row = 0..;
        self.laid.retain(|_| !is_out[row.next().expect("a row for each")]);
        self.laid
    }
}
