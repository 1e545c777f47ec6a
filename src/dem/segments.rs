//! The passes of a step, segment by segment: a segment's pairs are evaluated, then its grains sum what they got and
//! move on, while all of it lies in a cache near the processor. Nothing depends on which thread runs what.

use std::time::Instant;

use crate::base::ids::Row;
use crate::base::lane::Instructions;
use crate::base::parallel::larger;
use crate::base::space::{Linear, Space};
use crate::dem::grains::{Cold, Grains, Hot, Mover};
use crate::dem::kernel::{Pass, side_of_row};
use crate::dem::law::Law;
use crate::dem::neighbours::{Neighbours, Pair, SEGMENT};

/// Which segments: those whose pairs need no copies of other ranks' grains, or the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Segments {
    Inner,
    Border,
}

/// What a grain does once all of its forces are summed.
pub trait Finish<S: Space>: Sync {
    /// Moves the grain, and returns the square of its way from home, m2.
    fn finish(&self, row: usize, hot: &mut Hot<S>, given: (&S::Vector, &S::Spin), resting: &Resting<S>) -> f64;
}

/// It waits for what else the step has to say.
pub struct Wait;

impl<S: Space> Finish<S> for Wait {
    #[inline(always)]
    fn finish(&self, _: usize, _: &mut Hot<S>, _: (&S::Vector, &S::Spin), _: &Resting<S>) -> f64 {
        0.0
    }
}

/// What a step reads of owned rows and does not change.
#[derive(Clone, Copy)]
pub struct Resting<'a, S: Space> {
    pub movers: &'a [Mover],
    pub waits: &'a [bool],
    pub homes: &'a [S::Vector],
    pub cold: &'a [Cold<S>],
}

/// The same for the grains that had to wait until everything which pushes them was known, one after the other: they are few.
pub fn finish_waiting<S: Space>(grains: &mut Grains<S>, finish: &impl Finish<S>) -> f64 {
    let Grains { hot, cold, movers, waits, homes, waiting, force, torque, .. } = grains;
    let resting = Resting { movers, waits, homes, cold };
    let rows = waiting.iter().map(|row| *row as usize);
    rows.fold(0.0, |most, row| larger(most, finish.finish(row, &mut hot[row], (&force[row], &torque[row]), &resting)))
}

/// What came out of a pass: the largest that its grains returned, and the seconds that its halves took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Passed {
    pub farthest: f64,
    pub pairs: f64,
    pub grains: f64,
}

impl Passed {
    /// With the seconds of all threads made those of the wall.
    pub fn within(self, wall: f64) -> Self {
        let share = wall / (self.pairs + self.grains).max(f64::MIN_POSITIVE);
        Self { pairs: self.pairs * share, grains: self.grains * share, ..self }
    }

    /// Of two passes over different grains.
    pub fn and(self, other: Self) -> Self {
        Self {
            farthest: larger(self.farthest, other.farthest),
            pairs: self.pairs + other.pairs,
            grains: self.grains + other.grains,
        }
    }
}

/// What all tasks of a pass share.
pub struct Shared<'a, S: Space, F> {
    pub law: &'a dyn Law<S>,
    /// Words of what a pair remembers.
    pub memory: usize,
    pub times: [f64; 2],
    pub instructions: Instructions,
    pub neighbours: &'a Neighbours,
    /// Forces of the pairs that no segment holds alone, and words of a row of them.
    pub outer: &'a [f64],
    pub row: usize,
    /// Numbers of the room in which a task puts the forces of one segment after the other; none where all are kept.
    pub room: Option<usize>,
    pub which: Segments,
    pub resting: Resting<'a, S>,
    pub finish: &'a F,
}

/// Segments that one task holds.
pub struct Stretch<'a, S: Space> {
    /// Number of the first segment.
    pub first: usize,
    /// Where each segment ends among all pairs.
    pub ends: &'a [u32],
    /// Where the first begins.
    pub start: usize,
    pub pairs: &'a [Pair],
    pub memory: &'a mut [f64],
    /// Of all pairs, or a room for each task.
    pub forces: &'a mut [f64],
    pub hot: &'a mut [Hot<S>],
    pub force: &'a mut [S::Vector],
    pub torque: &'a mut [S::Spin],
}

impl<S: Space, F: Finish<S>> Shared<'_, S, F> {
    /// Halves of halves until there are as many stretches as tasks.
    pub fn run(&self, stretch: Stretch<S>, tasks: usize) -> Passed {
        if tasks <= 1 || stretch.ends.len() <= 1 {
            return self.one_by_one(stretch);
        }
        let left = tasks / 2;
        let segments = (stretch.ends.len() * left).div_ceil(tasks);
        let (ends_left, ends_right) = stretch.ends.split_at(segments);
        let middle = ends_left[segments - 1] as usize;
        let pairs = middle - stretch.start;
        let (pairs_left, pairs_right) = stretch.pairs.split_at(pairs);
        let (memory_left, memory_right) = stretch.memory.split_at_mut(pairs * self.memory);
        let forces = self.room.map_or(pairs * self.row, |room| left * room);
        let (forces_left, forces_right) = stretch.forces.split_at_mut(forces);
        let rows = (segments * SEGMENT).min(stretch.hot.len());
        let (hot_left, hot_right) = stretch.hot.split_at_mut(rows);
        let (force_left, force_right) = stretch.force.split_at_mut(rows);
        let (torque_left, torque_right) = stretch.torque.split_at_mut(rows);
        let first_half = Stretch {
            ends: ends_left,
            pairs: pairs_left,
            memory: memory_left,
            forces: forces_left,
            hot: hot_left,
            force: force_left,
            torque: torque_left,
            ..stretch
        };
        let second_half = Stretch {
            first: stretch.first + segments,
            ends: ends_right,
            start: middle,
            pairs: pairs_right,
            memory: memory_right,
            forces: forces_right,
            hot: hot_right,
            force: force_right,
            torque: torque_right,
        };
        let (a, b) = rayon::join(|| self.run(first_half, left), || self.run(second_half, tasks - left));
        a.and(b)
    }

    fn one_by_one(&self, stretch: Stretch<S>) -> Passed {
        let mut passed = Passed::default();
        let mut start = stretch.start;
        for (number, end) in stretch.ends.iter().enumerate() {
            let segment = stretch.first + number;
            let pairs = start - stretch.start..*end as usize - stretch.start;
            let rows = number * SEGMENT..((number + 1) * SEGMENT).min(stretch.hot.len());
            if self.neighbours.on_border[segment] == (self.which == Segments::Border) {
                let begun = Instant::now();
                let room = if self.room.is_some() { 0..pairs.len() } else { pairs.clone() };
                let forces = &mut stretch.forces[room.start * self.row..room.end * self.row];
                let memory = &mut stretch.memory[pairs.start * self.memory..pairs.end * self.memory];
                let hot = &mut stretch.hot[rows.clone()];
                self.evaluate(segment, &stretch.pairs[pairs], memory, forces, hot);
                let evaluated = Instant::now();
                let moving = (hot, &mut stretch.force[rows.clone()], &mut stretch.torque[rows]);
                let farthest = self.sum_and_finish(segment, start, forces, moving);
                passed = passed.and(Passed {
                    farthest,
                    pairs: (evaluated - begun).as_secs_f64(),
                    grains: evaluated.elapsed().as_secs_f64(),
                });
            }
            start = *end as usize;
        }
        passed
    }

    fn evaluate(&self, segment: usize, pairs: &[Pair], memory: &mut [f64], forces: &mut [f64], hot: &[Hot<S>]) {
        let [advance, dt] = self.times;
        let first = (segment * SEGMENT) as Row;
        let pass = Pass { hot, first, shifts: None, advance, dt, instructions: self.instructions };
        self.law.evaluate(&pass, pairs, memory, forces);
    }

    /// `forces` are those of the pairs from `start` on.
    fn sum_and_finish(&self, segment: usize, start: usize, forces: &[f64], (hot, force, torque): Moving<S>) -> f64 {
        let within = self.neighbours.within();
        let mut farthest = 0.0;
        for (offset, ((hot, force), torque)) in hot.iter_mut().zip(force).zip(torque).enumerate() {
            let row = segment * SEGMENT + offset;
            let (mut sum, mut turn) = (S::Vector::zero(), S::Spin::zero());
            for term in self.neighbours.terms_of(row) {
                let (from, pair) = match term.pair() < within {
                    true => (forces, term.pair() - start),
                    false => (self.outer, term.pair() - within),
                };
                let (force, torque) = side_of_row::<S>(row_of::<S>(from, pair, self.row), term.is_b());
                sum += force;
                turn += torque;
            }
            (*force, *torque) = (sum, turn);
            if !self.resting.waits[row] {
                farthest = larger(farthest, self.finish.finish(row, hot, (force, torque), &self.resting));
            }
        }
        farthest
    }
}

/// Records of a segment's rows, with their forces and torques.
type Moving<'a, S> = (&'a mut [Hot<S>], &'a mut [<S as Space>::Vector], &'a mut [<S as Space>::Spin]);

/// A pair's row of forces.
#[inline(always)]
pub fn row_of<S: Space>(forces: &[f64], pair: usize, row: usize) -> &[f64] {
    let row = if S::DIMENSION == 2 { 4 } else { row };
    &forces[pair * row..(pair + 1) * row]
}
