//! Forces: one pass over pairs that writes per pair, one pass over grains that sums its pairs. Apart, because then no
//! two threads write to one place and every sum has one order.

use std::cmp::Ordering;
use std::time::Instant;

use crate::base::ids::GrainId;
use crate::base::lane::{Instructions, LANES, Pack, Packed};
use crate::base::space::{Linear, Space};
use crate::dem::cell::{Cell, Shifts};
use crate::dem::grains::{Grains, lanes, vector};
use crate::dem::kernel::{Given, Pass, Side, of_side, pair_pass, pair_weight, row_words, side_words, touch};
use crate::dem::law::Law;
use crate::dem::memories::Carried;
use crate::dem::neighbours::{Neighbours, Pair};
use crate::dem::segments::{Finish, Passed, Resting, Segments, Shared, Stretch, row_of};
use crate::law::contact::{Memory, Touch};

/// Listed pairs with their memories and forces.
#[derive(Clone, Debug)]
pub struct Contacts<S: Space> {
    /// Pairs that may touch, and the terms that each row sums.
    pub neighbours: Neighbours,
    /// `[pack][word][lane]`; zero where the pair does not touch.
    memory: Vec<f64>,
    /// Words of what a pair remembers.
    words: usize,
    /// `[pair][word]` of pairs that no segment holds alone.
    outer: Lines,
    /// The same of the others, where they are kept; else a room for each task, in which one segment's follow another's.
    inner: Lines,
    /// Whether forces are looked at after the step that they move, and whether they have ever been.
    keeps: bool,
    kept: bool,
    /// Tasks of a pass over segments, and numbers of a room.
    tasks: usize,
    room: usize,
    shifts: Shifts<S>,
    instructions: Instructions,
}

/// Tasks that a thread finds in a pass over segments, so that none waits long for another.
const TASKS_PER_THREAD: usize = 4;

/// Pairs of a list in order whose forces are summed at a time: whole packs, and rows that fit a first-level cache.
const SUMMED: usize = 16 * LANES;

/// Numbers in a line of the cache.
const LINE: usize = 8;

/// Numbers that begin with a line of the cache: a pair's row in the plane is a line, one in space a line and a half.
#[derive(Clone, Debug, Default)]
struct Lines(Vec<f64>, usize);

impl Lines {
    fn new(count: usize) -> Self {
        let numbers = vec![0.0; count + LINE];
        let first = numbers.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        Self(numbers, first)
    }
    fn numbers(&self) -> &[f64] {
        &self.0[self.1..]
    }
    fn numbers_mut(&mut self) -> &mut [f64] {
        &mut self.0[self.1..]
    }
}

/// Room for the forces of pairs and the images of now, which a pass fills and nothing remembers: what is stepped now and then need not keep its own.
#[derive(Clone, Debug, Default)]
pub struct Rooms<S: Space> {
    outer: Lines,
    inner: Lines,
    shifts: Shifts<S>,
}

impl<S: Space> Contacts<S> {
    /// No pairs yet, the images of this cell, and the widest instructions that there are ([`Instructions::best`]).
    pub fn new(cell: &Cell<S>) -> Self {
        Self {
            neighbours: Neighbours::default(),
            memory: Vec::new(),
            words: 0,
            outer: Lines::default(),
            inner: Lines::default(),
            keeps: false,
            kept: false,
            tasks: 1,
            room: 0,
            shifts: Shifts::of(cell),
            instructions: Instructions::best(),
        }
    }

    /// Uses other instructions; the bits do not change.
    pub fn use_instructions(&mut self, instructions: Instructions) {
        self.instructions = instructions;
    }

    /// Those that passes run with.
    pub fn instructions(&self) -> Instructions {
        self.instructions
    }

    /// Gives its arrays back to the system: their memories have been taken, and others are about to be made.
    pub fn clear(&mut self) {
        self.neighbours = Neighbours::default();
        self.memory = Vec::new();
        (self.inner, self.outer) = (Lines::default(), Lines::default());
    }

    /// New list for `grains`; the memories that owned rows carry find their pairs.
    pub fn rebuild<I: Iterator<Item = Carried>>(
        &mut self,
        law: &dyn Law<S>,
        grains: &Grains<S>,
        cell: &Cell<S>,
        carried: impl Fn(usize) -> I,
        margin: f64,
    ) {
        self.neighbours.build(grains, cell, margin);
        self.words = law.memory_words();
        self.memory = vec![0.0; self.neighbours.pairs.len() * self.words];
        match self.neighbours.in_order {
            true => self.fit_rooms(),
            false => self.lay_forces(),
        }
        let Self { neighbours, memory, words, .. } = self;
        for row in 0..grains.owned {
            // Both run in the order of partner ids: memories are moved along, not searched for.
            let mut memories = carried(row).peekable();
            for term in neighbours.terms_of(row) {
                let partner = grains.cold[neighbours.partner(term) as usize].id;
                while memories.next_if(|(id, _)| *id < partner).is_some() {}
                if let Some((_, remembered)) = memories.next_if(|(id, _)| *id == partner) {
                    remember(memory, *words, term.pair, &remembered);
                }
            }
        }
    }

    fn lay_forces(&mut self) {
        self.outer = Lines::new((self.neighbours.pairs.len() - self.neighbours.within()) * row_words::<S>());
        self.tasks = match rayon::current_num_threads() {
            1 => 1,
            // No more than there is work for: each has a room.
            threads => (threads * TASKS_PER_THREAD).min(self.neighbours.segment_ends.len()).max(1),
        };
        self.room = (self.neighbours.segment_most() * row_words::<S>()).next_multiple_of(LINE);
        self.inner = Lines::default();
        self.lay_inner();
    }

    /// Room for the forces of a step. Where they have once been looked at they will be again: there is room for all from then
    /// on, so that steps with and without a look allocate nothing.
    fn lay_inner(&mut self) {
        let all = if self.kept { self.neighbours.within() * row_words::<S>() } else { 0 };
        let count = all.max(self.tasks * self.room);
        if self.inner.numbers().len() < count {
            self.inner = Lines::new(count);
        }
    }

    /// Takes these rooms for its own, and gives its own for them.
    pub fn swap_rooms(&mut self, rooms: &mut Rooms<S>) {
        std::mem::swap(&mut self.shifts, &mut rooms.shifts);
        std::mem::swap(&mut self.outer, &mut rooms.outer);
        std::mem::swap(&mut self.inner, &mut rooms.inner);
    }

    /// Makes rooms large enough that are not its own.
    pub fn fit_rooms(&mut self) {
        let outer = (self.neighbours.pairs.len() - self.neighbours.within()) * row_words::<S>();
        if self.outer.numbers().len() < outer {
            self.outer = Lines::new(outer);
        }
        self.lay_inner();
    }

    /// Whether the forces of all pairs can be asked for after the next evaluation.
    pub fn keep_forces(&mut self, keeps: bool) {
        self.keeps = keeps;
        if keeps && !self.kept {
            self.kept = true;
            self.lay_inner();
        }
    }

    /// What a pair remembers.
    pub fn recall(&self, pair: usize) -> Memory {
        self.recall_from(&self.memory, pair)
    }

    /// The same from memories of this list at another time.
    pub fn recall_from(&self, memories: &[f64], pair: usize) -> Memory {
        let mut memory = Memory::blank(self.words);
        for (word, value) in memory.words_mut().iter_mut().enumerate() {
            *value = memories[(pair / LANES * self.words + word) * LANES + pair % LANES];
        }
        memory
    }

    /// All memories, for [`Self::recall_from`].
    pub fn memories(&self) -> &[f64] {
        &self.memory
    }

    /// What the last evaluation gave to the two grains of a pair, weighted.
    pub fn given(&self, pair: usize) -> Given<S, f64> {
        let (a, b) = self.row_of(pair).split_at(side_words::<S>());
        let ((force, torque_a), (_, torque_b)) = (of_side::<S>(a), of_side::<S>(b));
        Given { force, torque_a, torque_b }
    }

    /// Forces of a pair, of the last evaluation; they must have been kept.
    fn row_of(&self, pair: usize) -> &[f64] {
        debug_assert!(self.keeps);
        let within = self.neighbours.within();
        match pair < within {
            true => row_of::<S>(self.inner.numbers(), pair),
            false => row_of::<S>(self.outer.numbers(), pair - within),
        }
    }

    /// What the images of a pair add to the separation of its grains (m) and to their relative velocity (m/s).
    pub fn shift(&self, pair: &Pair) -> (S::Vector, S::Vector) {
        self.shifts.at(pair.image())
    }

    /// Memories of the touching contacts of an owned row, in the order of partner ids.
    pub fn carried_by(&self, grains: &Grains<S>, row: usize) -> impl Iterator<Item = Carried> {
        self.neighbours.terms_of(row).filter_map(move |term| {
            let memory = self.recall(term.pair);
            let partner = grains.cold[self.neighbours.partner(term) as usize].id;
            (!memory.is_blank()).then_some((partner, memory))
        })
    }

    /// The images of now, before the passes of a step.
    pub fn settle_images(&mut self, cell: &Cell<S>) {
        self.shifts.settle(cell);
    }

    /// Pair pass over the part of the list that no segment holds alone: pairs of owned rows, which segments without copies share, or
    /// those with copies. Memories advance by `advance` seconds (zero at the
    /// very first evaluation).
    pub fn pair_pass(&mut self, law: &dyn Law<S>, grains: &Grains<S>, which: Segments, [advance, dt]: [f64; 2]) {
        let (hot, shifts, instructions) = (&grains.hot, Some(&self.shifts), self.instructions);
        let pass = Pass { hot, first: 0, shifts, advance, dt, instructions };
        let (within, border) = (self.neighbours.within(), self.neighbours.border);
        let pairs = match which {
            Segments::Inner => within..border,
            Segments::Border => border..self.neighbours.pairs.len(),
        };
        let memory = &mut self.memory[pairs.start * self.words..pairs.end * self.words];
        let forces = &mut self.outer.numbers_mut()
            [(pairs.start - within) * row_words::<S>()..(pairs.end - within) * row_words::<S>()];
        pair_pass(law, &pass, &self.neighbours.pairs[pairs], memory, forces);
    }

    /// All pairs of a list in order, and what each grain got from them. Forces are kept where they are looked at afterwards; else they are
    /// summed a few at a time, while they lie in the nearest cache.
    pub fn pass_in_order(&mut self, law: &dyn Law<S>, grains: &mut Grains<S>, [advance, dt]: [f64; 2], keeps: bool) {
        let Grains { hot, force, torque, .. } = grains;
        let pass = Pass { hot, first: 0, shifts: Some(&self.shifts), advance, dt, instructions: self.instructions };
        let Neighbours { pairs, listed, .. } = &self.neighbours;
        let (words, row) = (self.words, row_words::<S>());
        force.fill(S::Vector::zero());
        torque.fill(S::Spin::zero());
        for first in (0..pairs.len()).step_by(SUMMED) {
            let end = (first + SUMMED).min(pairs.len());
            let room = if keeps { first * row } else { 0 };
            let forces = &mut self.outer.numbers_mut()[room..room + (end - first) * row];
            law.evaluate(&pass, &pairs[first..end], &mut self.memory[first * words..end * words], forces);
            // Those behind fill the last pack up.
            let pairs = &pairs[first..end.min(*listed)];
            self.instructions.run(SumInOrder::<S> { pairs, forces, force, torque });
        }
    }

    /// The pairs of every segment, and what follows for its grains: those that need no copies, or the others. Pairs that
    /// such a segment shares must have been evaluated.
    pub fn segment_pass(
        &mut self,
        law: &dyn Law<S>,
        grains: &mut Grains<S>,
        which: Segments,
        times: [f64; 2],
        finish: &impl Finish<S>,
    ) -> Passed {
        let (neighbours, owned) = (&self.neighbours, grains.owned);
        let Grains { hot, cold, movers, waits, alike, homes, springs, force, torque, .. } = grains;
        let shared = Shared {
            law,
            memory: self.words,
            times,
            instructions: self.instructions,
            neighbours,
            outer: self.outer.numbers(),
            room: (!self.keeps).then_some(self.room),
            which,
            resting: Resting { movers, waits, alike, homes, springs, cold },
            finish,
        };
        let stretch = Stretch {
            first: 0,
            start: 0,
            ends: &neighbours.segment_ends,
            pairs: &neighbours.pairs[..neighbours.within()],
            memory: &mut self.memory[..neighbours.within() * self.words],
            forces: self.inner.numbers_mut(),
            hot: &mut hot[..owned],
            force,
            torque,
        };
        let begun = Instant::now();
        let passed = shared.run(stretch, self.tasks);
        passed.within(begun.elapsed().as_secs_f64())
    }

    /// The pairs of a list in order with the force that each gave to its first grain at the last evaluation, N.
    pub fn forces_in_order(&self) -> impl Iterator<Item = (&Pair, S::Vector)> {
        let rows = self.outer.numbers().chunks_exact(row_words::<S>());
        self.neighbours.pairs_in_order().iter().zip(rows).map(|(pair, row)| (pair, vector(&of_side::<S>(row).0)))
    }

    /// Force on the first grain of a pair at the last evaluation, weighted, N; zero where the two do not touch.
    pub(crate) fn force_of(&self, pair: usize) -> S::Vector {
        vector(&of_side::<S>(self.row_of(pair)).0)
    }

    /// The two grains of a pair as the law sees them, with velocities of now and no time passed.
    pub(super) fn touch_of(&self, grains: &Grains<S>, pair: &Pair) -> Touch<S, f64> {
        self.touch_after(grains, pair, [0.0, 0.0])
    }

    /// The same with the times over which memories advance and twists are reckoned, s: the step, where the two are to be seen
    /// as the coming evaluation sees them.
    pub fn touch_after(&self, grains: &Grains<S>, pair: &Pair, times: [f64; 2]) -> Touch<S, f64> {
        let (a, b) = (&grains.hot[pair.a as usize], &grains.hot[pair.b() as usize]);
        let (shift, rate) = self.shift(pair);
        let separation = lanes(&(a.position - b.position + shift));
        let relative = lanes(&(a.velocity - b.velocity + rate));
        touch(&Side::scalar(a), &Side::scalar(b), separation, relative, times)
    }

    /// Weight of a pair's contact in the mixture ([`pair_weight`]).
    pub fn weight_of(grains: &Grains<S>, pair: &Pair) -> f64 {
        pair_weight(grains.hot[pair.a as usize].weight, grains.hot[pair.b() as usize].weight)
    }

    /// Elastic energy of the contacts that this rank accounts for (those whose lower id it owns), weighted, J.
    pub fn elastic_energies<'a>(
        &'a self,
        law: &'a dyn Law<S>,
        grains: &'a Grains<S>,
    ) -> impl Iterator<Item = f64> + 'a {
        self.neighbours.real_pairs().filter_map(move |(index, pair)| {
            if pair.a as usize >= grains.owned {
                return None;
            }
            let touch = self.touch_of(grains, pair);
            let memory = self.recall(index);
            let holds = law.holds(&touch, &memory);
            holds.then(|| Self::weight_of(grains, pair) * law.elastic_energy(&touch, &memory))
        })
    }

    /// The deepest overlap of a pair that this rank holds, as a share of the smaller radius, with its ids.
    pub fn deepest(&self, grains: &Grains<S>) -> Option<(f64, [GrainId; 2])> {
        let share = |pair: &Pair| {
            let (a, b) = (&grains.hot[pair.a as usize], &grains.hot[pair.b() as usize]);
            let ids = [grains.cold[pair.a as usize].id, grains.cold[pair.b() as usize].id];
            (self.touch_of(grains, pair).overlap / a.radius.min(b.radius), ids)
        };
        self.neighbours.real_pairs().map(|(_, pair)| share(pair)).max_by(deeper)
    }

    /// Contacts of this rank's account that hold now.
    pub fn count(&self, law: &dyn Law<S>, grains: &Grains<S>) -> usize {
        let holds = |(index, pair): &(usize, &Pair)| {
            (pair.a as usize) < grains.owned && law.holds(&self.touch_of(grains, pair), &self.recall(*index))
        };
        self.neighbours.real_pairs().filter(holds).count()
    }

    /// Bytes that the arrays hold.
    pub fn bytes(&self) -> usize {
        self.neighbours.bytes()
            + (self.memory.capacity() + self.inner.0.capacity() + self.outer.0.capacity()) * size_of::<f64>()
    }
}

/// Adds what pairs of a list in order gave to their grains.
struct SumInOrder<'a, S: Space> {
    pairs: &'a [Pair],
    forces: &'a [f64],
    force: &'a mut [S::Vector],
    torque: &'a mut [S::Spin],
}

impl<S: Space> Packed for SumInOrder<'_, S> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        for (pair, given) in self.pairs.iter().zip(self.forces.chunks_exact(row_words::<S>())) {
            let (a, b) = given.split_at(side_words::<S>());
            for (row, side) in [(pair.a as usize, a), (pair.b() as usize, b)] {
                // Read, added to and written whole, so that a register holds several components.
                let (mut force, mut torque) = (self.force[row], self.torque[row]);
                for axis in 0..S::DIMENSION {
                    force[axis] += side[axis];
                }
                for axis in 0..S::Spin::COMPONENTS {
                    torque[axis] += side[S::DIMENSION + axis];
                }
                (self.force[row], self.torque[row]) = (force, torque);
            }
        }
    }
}

/// Keeps what a pair remembers, `words` of it, in memories by packs.
fn remember(memories: &mut [f64], words: usize, pair: usize, memory: &Memory) {
    for (word, value) in memory.words().iter().enumerate() {
        memories[(pair / LANES * words + word) * LANES + pair % LANES] = *value;
    }
}

/// Which of two overlaps is deeper; of equal ones that of lower ids, whoever finds it.
pub fn deeper(a: &(f64, [GrainId; 2]), b: &(f64, [GrainId; 2])) -> Ordering {
    a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))
}
