//! The passes of a step, segment by segment: a segment's pairs are evaluated, then its grains sum what they got and
//! move on, while all of it lies in a cache near the processor. Nothing depends on which thread runs what.

use std::time::Instant;

use crate::base::ids::Row;
use crate::base::lane::{Instructions, LANES, Pack, Packed, Quad, four};
use crate::base::parallel::larger;
use crate::base::space::{Linear, Space, Words};
use crate::dem::columns::Largest;
use crate::dem::grains::{Cold, Grains, Hot, Mover, PenaltySpring};
use crate::dem::kernel::{Pass, row_words};
use crate::dem::law::Law;
use crate::dem::neighbours::{Neighbours, Pair, Place, SEGMENT};

/// Which segments: those whose pairs need no copies of other ranks' grains, or the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Segments {
    /// No pair of theirs is with a copy: they need not wait for any.
    Inner,
    /// Some pair of theirs is with a copy.
    Border,
}

/// What a grain does once all of its forces are summed.
pub trait Finish<S: Space>: Sync {
    /// Moves the grain, and returns the square of its way from home, m2.
    fn finish(&self, row: usize, hot: &mut Hot<S>, given: (&S::Vector, &S::Spin), resting: &Resting<S>) -> f64;

    /// The same for eight side by side, to the bit, all of them free and none that waits; `beside` are their homes and, where they have any, their penalty springs.
    fn finish_eight<P: Pack>(
        &self,
        hot: &mut [Hot<S>; LANES],
        given: (S::VectorOf<P>, S::SpinOf<P>),
        beside: (&[S::Vector; LANES], &[PenaltySpring<S>]),
    ) -> P;
}

/// It waits for what else the step has to say.
pub struct Wait;

impl<S: Space> Finish<S> for Wait {
    #[inline(always)]
    fn finish(&self, _: usize, _: &mut Hot<S>, _: (&S::Vector, &S::Spin), _: &Resting<S>) -> f64 {
        0.0
    }

    #[inline(always)]
    fn finish_eight<P: Pack>(
        &self,
        _: &mut [Hot<S>; LANES],
        _: (S::VectorOf<P>, S::SpinOf<P>),
        _: (&[S::Vector; LANES], &[PenaltySpring<S>]),
    ) -> P {
        P::splat(0.0)
    }
}

/// What a step reads of owned rows and does not change.
#[derive(Clone, Copy)]
pub struct Resting<'a, S: Space> {
    /// By owned row.
    pub movers: &'a [Mover],
    /// By owned row, whether what pushes it is not known yet ([`Grains::waits`]).
    pub waits: &'a [bool],
    /// By eights of rows: see [`Grains::alike`].
    pub alike: &'a [bool],
    /// Positions at the last rebuild by owned row, m.
    pub homes: &'a [S::Vector],
    /// By owned row; none of the grains of an RVE.
    pub springs: &'a [PenaltySpring<S>],
    /// Read for the velocities of scripted rows.
    pub cold: &'a [Cold<S>],
}

/// The same for the grains that had to wait until everything which pushes them was known, one after the other: they are few.
pub fn finish_waiting<S: Space>(grains: &mut Grains<S>, finish: &impl Finish<S>) -> f64 {
    let Grains { hot, cold, movers, waits, alike, homes, springs, waiting, force, torque, .. } = grains;
    let resting = Resting { movers, waits, alike, homes, springs, cold };
    let rows = waiting.iter().map(|row| *row as usize);
    rows.fold(0.0, |most, row| larger(most, finish.finish(row, &mut hot[row], (&force[row], &torque[row]), &resting)))
}

/// What came out of a pass: the largest that its grains returned, and the seconds that its halves took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Passed {
    /// The largest square of a way from home, m2.
    pub farthest: f64,
    /// Evaluation of pairs, s.
    pub pairs: f64,
    /// Sums and motion of grains, s.
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
    /// Of contacts of grains with each other.
    pub law: &'a dyn Law<S>,
    /// Words of what a pair remembers.
    pub memory: usize,
    /// Time over which memories advance, and that over which twists are reckoned, s.
    pub times: [f64; 2],
    /// Registers that it runs with; the bits do not depend on them.
    pub instructions: Instructions,
    /// Segments, and the terms of their rows.
    pub neighbours: &'a Neighbours,
    /// Forces of the pairs that no segment holds alone.
    pub outer: &'a [f64],
    /// Numbers of the room in which a task puts the forces of one segment after the other; none where all are kept.
    pub room: Option<usize>,
    /// Which segments are done; the others are passed over.
    pub which: Segments,
    /// What motion reads of rows, of all that this rank owns.
    pub resting: Resting<'a, S>,
    /// What a row does once its forces are summed.
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
    /// Of these segments, one after the other.
    pub pairs: &'a [Pair],
    /// What these pairs remember, `[pack][word][lane]`.
    pub memory: &'a mut [f64],
    /// Of all pairs, or a room for each task.
    pub forces: &'a mut [f64],
    /// Rows of these segments.
    pub hot: &'a mut [Hot<S>],
    /// Sums of these rows, N.
    pub force: &'a mut [S::Vector],
    /// Sums of these rows, N m.
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
        let forces = self.room.map_or(pairs * row_words::<S>(), |room| left * room);
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
                let forces = &mut stretch.forces[room.start * row_words::<S>()..room.end * row_words::<S>()];
                let memory = &mut stretch.memory[pairs.start * self.memory..pairs.end * self.memory];
                let hot = &mut stretch.hot[rows.clone()];
                self.evaluate(segment, &stretch.pairs[pairs], memory, forces, hot);
                let evaluated = Instant::now();
                let moving = (hot, &mut stretch.force[rows.clone()], &mut stretch.torque[rows]);
                let sums = SumAndFinish { shared: self, first: segment * SEGMENT, forces, moving };
                let farthest = self.instructions.run(sums);
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
}

/// What the rows of a segment got from their pairs, summed in the order of their terms, and what they do by it.
struct SumAndFinish<'a, 'f, S: Space, F> {
    shared: &'a Shared<'a, S, F>,
    /// The first row of the segment.
    first: usize,
    /// Of its pairs.
    forces: &'f [f64],
    moving: Moving<'f, S>,
}

impl<S: Space, F: Finish<S>> Packed for SumAndFinish<'_, '_, S, F> {
    type Outcome = f64;

    #[inline(always)]
    fn run<P: Pack>(self) -> f64 {
        let Self { shared, first, forces, moving: (hot, force, torque) } = self;
        let Shared { resting, finish, .. } = shared;
        let mut farthest = 0.0;
        let mut farthest_of_eights = Largest::<P>::none();
        let eights = hot.chunks_mut(LANES).zip(force.chunks_mut(LANES)).zip(torque.chunks_mut(LANES));
        for (eight, ((hot, force), torque)) in eights.enumerate() {
            let first = first + eight * LANES;
            let given = sum_eight::<S, F, P>(shared, first / LANES, forces, (&mut *force, &mut *torque));
            let homes = &resting.homes[first..first + hot.len()];
            let springs = resting.springs.get(first..first + hot.len()).unwrap_or_default();
            match (hot.first_chunk_mut(), homes.first_chunk()) {
                (Some(hot), Some(homes)) if resting.alike[first / LANES] => {
                    farthest_of_eights.take(finish.finish_eight(hot, given, (homes, springs)));
                }
                _ => {
                    for (offset, hot) in hot.iter_mut().enumerate().filter(|(offset, _)| !resting.waits[first + offset])
                    {
                        let given = (&force[offset], &torque[offset]);
                        farthest = larger(farthest, finish.finish(first + offset, hot, given, resting));
                    }
                }
            }
        }
        farthest_of_eights.or(farthest)
    }
}

/// Sums of eight rows side by side, or of as many as there are, which are zero where there is no row. `forces` are those of the segment's pairs.
#[inline(always)]
fn sum_eight<S: Space, F, P: Pack>(
    shared: &Shared<S, F>,
    eight: usize,
    forces: &[f64],
    sums: (&mut [S::Vector], &mut [S::Spin]),
) -> (S::VectorOf<P>, S::SpinOf<P>) {
    let places = shared.neighbours.places_of_eight(eight);
    // Words of a side, the quads that hold them, each two words after the last, and as many rows side by side as registers hold.
    match S::DIMENSION {
        2 => sum_quads::<S, P, 4, 1, LANES>([forces, shared.outer], places, sums),
        _ => sum_quads::<S, P, 6, 2, { LANES / 2 }>([forces, shared.outer], places, sums),
    }
}

/// The same, with sides of `WIDTH` words in `QUADS` quads, `N` rows at a time.
#[inline(always)]
fn sum_quads<S: Space, P: Pack, const WIDTH: usize, const QUADS: usize, const N: usize>(
    [within, apart]: [&[f64]; 2],
    places: &[[Place; LANES]],
    (force, torque): (&mut [S::Vector], &mut [S::Spin]),
) -> (S::VectorOf<P>, S::SpinOf<P>) {
    // Nothing is a side of zeros, for a sum that begins with zero is what it was after it.
    let mut parts: [&[[f64; WIDTH]]; Place::PARTS] = [&[[0.0; WIDTH]]; Place::PARTS];
    (parts[Place::WITHIN], parts[Place::APART]) = (within.as_chunks().0, apart.as_chunks().0);
    let mut sums = [[P::Quad::zero(); LANES]; QUADS];
    for first in (0..LANES).step_by(N) {
        let mut some = [[P::Quad::zero(); N]; QUADS];
        for places in places {
            for row in 0..N {
                let place = places[first + row];
                let side = &parts[place.part()][place.side()];
                for (quad, some) in some.iter_mut().enumerate() {
                    some[row] = some[row] + P::Quad::load(four(side, 2 * quad));
                }
            }
        }
        for (sums, some) in sums.iter_mut().zip(&some) {
            sums[first..first + N].copy_from_slice(some);
        }
    }
    // A shorter last eight is stored whole and copied: sums whose number is not known here would have to lie in memory.
    match (force.first_chunk_mut::<LANES>(), torque.first_chunk_mut::<LANES>()) {
        (Some(force), Some(torque)) => store::<S, P, QUADS>(&sums, (force, torque)),
        _ => {
            let (mut whole, mut turns) = ([S::Vector::zero(); LANES], [S::Spin::zero(); LANES]);
            store::<S, P, QUADS>(&sums, (&mut whole, &mut turns));
            force.copy_from_slice(&whole[..force.len()]);
            torque.copy_from_slice(&turns[..torque.len()]);
        }
    }
    let (mut force, mut torque) = (S::VectorOf::<P>::zero(), S::SpinOf::<P>::zero());
    for (quad, sums) in sums.iter().enumerate() {
        for (word, lanes) in P::of_quads(*sums).into_iter().enumerate() {
            match (2 * quad + word).checked_sub(S::DIMENSION) {
                None => force.set_word(2 * quad + word, lanes),
                Some(axis) if axis < S::Spin::COMPONENTS => torque.set_word(axis, lanes),
                Some(_) => (),
            }
        }
    }
    (force, torque)
}

/// Sums to their rows.
#[inline(always)]
fn store<S: Space, P: Pack, const QUADS: usize>(
    sums: &[[P::Quad; LANES]; QUADS],
    (force, torque): (&mut [S::Vector; LANES], &mut [S::Spin; LANES]),
) {
    for row in 0..LANES {
        for (quad, sums) in sums.iter().enumerate() {
            for (word, number) in sums[row].words().into_iter().enumerate() {
                match (2 * quad + word).checked_sub(S::DIMENSION) {
                    None => force[row][2 * quad + word] = number,
                    Some(axis) if axis < S::Spin::COMPONENTS => torque[row][axis] = number,
                    Some(_) => (),
                }
            }
        }
    }
}

/// Records of a segment's rows, with their forces and torques.
type Moving<'a, S> = (&'a mut [Hot<S>], &'a mut [<S as Space>::Vector], &'a mut [<S as Space>::Spin]);

/// A pair's row of forces.
#[inline(always)]
pub fn row_of<S: Space>(forces: &[f64], pair: usize) -> &[f64] {
    &forces[pair * row_words::<S>()..(pair + 1) * row_words::<S>()]
}
