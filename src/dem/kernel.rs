//! The pass over pairs: packs of eight, from the records of their grains to their forces. Written once over [`Part`];
//! [`pair_pass`] picks the widest registers the processor has, and every width gives the same bits.

use rayon::prelude::*;

use crate::base::ids::Row;
use crate::base::lane::{Instructions, LANES, Pack, Packed, Part, Quad, Real, four};
use crate::base::numbers::{Lanes, Numbers};
use crate::base::space::{Lanewise, Space, Words};
use crate::dem::cell::Shifts;
use crate::dem::grains::Hot;
use crate::dem::law::Law;
use crate::dem::neighbours::Pair;
use crate::law::contact::{Answer, ContactLaw, FLAT, Touch};

/// Pairs that one task handles; a constant and a whole number of packs, so that nothing depends on threads.
const CHUNK: usize = 1024;

/// Words of one side in a pair's row: force and torque. In the plane a zero follows them, so that a row is a line of the cache.
pub const fn side_words<S: Space>() -> usize {
    if S::DIMENSION == 2 { 4 } else { 6 }
}

/// Words of a pair's row of forces: what it gives to `a`, then what it gives to `b`, so that a
/// term of a grain's sum is one load and one addition.
pub const fn row_words<S: Space>() -> usize {
    2 * side_words::<S>()
}

/// The most words of a grain's record that a contact reads: place, velocity and spin, radius, weight and mass.
const RECORD_WORDS_MAX: usize = 12;

/// Force and torque of a side's words.
#[inline(always)]
pub fn of_side<S: Space>(side: &[f64]) -> (S::VectorOf<f64>, S::SpinOf<f64>) {
    (Words::of_words(side), Words::of_words(&side[S::DIMENSION..]))
}

/// What all pairs of a pass share.
#[derive(Clone, Copy)]
pub struct Pass<'a, S: Space> {
    /// Records from row `first` on.
    pub hot: &'a [Hot<S>],
    /// The row that `hot` begins with; pairs name rows as if it began with row zero.
    pub first: Row,
    /// Of the images that pairs lie in; none where each lies in one image.
    pub shifts: Option<&'a Shifts<S>>,
    /// Time over which memories advance, s, and the step that twists are reckoned over.
    pub advance: f64,
    /// s.
    pub dt: f64,
    /// Registers that the pass runs with; the bits do not depend on them.
    pub instructions: Instructions,
}

/// Evaluates whole packs of `pairs` on all threads. `memory` holds `[pack][word][lane]`, `forces` `[pair][word]`.
pub fn pair_pass<S: Space>(law: &dyn Law<S>, pass: &Pass<S>, pairs: &[Pair], memory: &mut [f64], forces: &mut [f64]) {
    let (words, row) = (law.memory_words(), row_words::<S>());
    debug_assert!(pairs.len().is_multiple_of(LANES) && memory.len() == pairs.len() * words);
    (pairs.par_chunks(CHUNK), memory.par_chunks_mut(CHUNK * words), forces.par_chunks_mut(CHUNK * row))
        .into_par_iter()
        .for_each(|(pairs, memory, forces)| law.evaluate(pass, pairs, memory, forces));
}

/// The same on this thread.
pub fn evaluate<S: Space, C: ContactLaw<S>>(
    law: &C,
    pass: &Pass<S>,
    pairs: &[Pair],
    memory: &mut [f64],
    forces: &mut [f64],
) {
    match pass.shifts {
        Some(_) => pass.instructions.run(Packs::<S, C, true> { law, pass, pairs, memory, forces }),
        None => pass.instructions.run(Packs::<S, C, false> { law, pass, pairs, memory, forces }),
    }
}

/// `ACROSS` tells that pairs may lie in different images.
struct Packs<'a, S: Space, C, const ACROSS: bool> {
    law: &'a C,
    pass: &'a Pass<'a, S>,
    pairs: &'a [Pair],
    memory: &'a mut [f64],
    forces: &'a mut [f64],
}

impl<S: Space, C: ContactLaw<S>, const ACROSS: bool> Packed for Packs<'_, S, C, ACROSS> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        packs::<S, C, P, ACROSS>(self);
    }
}

#[inline(always)]
fn packs<S: Space, C: ContactLaw<S>, P: Pack, const ACROSS: bool>(packs: Packs<S, C, ACROSS>) {
    let Packs { law, pass, pairs, memory, forces } = packs;
    let memory_words = <C::Memory<f64> as Words<f64>>::COUNT;
    let (pairs, _) = pairs.as_chunks::<LANES>();
    let (memory, _) = memory.as_chunks_mut::<LANES>();
    for (pack, pairs) in pairs.iter().enumerate() {
        let memory = &mut memory[pack * memory_words..(pack + 1) * memory_words];
        let forces = &mut forces[pack * LANES * row_words::<S>()..(pack + 1) * LANES * row_words::<S>()];
        match S::DIMENSION {
            2 => of_pack::<S, C, P::Part, ACROSS>((law, pass), pairs, memory, forces),
            // A contact in space has more at work than registers hold, by whatever parts: two of them under way take longer than the pack (BENCHMARKS).
            _ => of_pack::<S, C, P, ACROSS>((law, pass), pairs, memory, forces),
        }
    }
}

/// A pack, two parts at a time: while the roots and quotients of one are under way, the other's grains are read.
#[inline(always)]
fn of_pack<S: Space, C: ContactLaw<S>, R: Part, const ACROSS: bool>(
    (law, pass): (&C, &Pass<S>),
    pairs: &[Pair; LANES],
    memory: &mut [[f64; LANES]],
    forces: &mut [f64],
) {
    for part in (0..LANES / R::COUNT).step_by(2) {
        let one = Met::<S, R>::of::<ACROSS>(pass, pairs, part);
        if R::COUNT == LANES {
            one.answer(law, part, memory, forces);
            continue;
        }
        let other = Met::<S, R>::of::<ACROSS>(pass, pairs, part + 1);
        one.answer(law, part, memory, forces);
        other.answer(law, part + 1, memory, forces);
    }
}

/// Pairs that one register holds, as the law sees them.
struct Met<S: Space, R: Part> {
    touch: Touch<S, R>,
    weight: R,
}

impl<S: Space, R: Part> Met<S, R> {
    #[inline(always)]
    fn of<const ACROSS: bool>(pass: &Pass<S>, pairs: &[Pair; LANES], part: usize) -> Self {
        let ([mut separation, mut relative], [a, b]) = read::<S, R>(pass, pairs, part);
        if let Some(shifts) = pass.shifts.filter(|_| ACROSS) {
            let (shift, rate) = shifts.picked::<R>(&std::array::from_fn(|lane| pairs[lane].code()), part);
            (separation, relative) = (separation + shift, relative + rate);
        }
        let moved = [R::splat(pass.advance), R::splat(pass.dt)];
        Self { touch: touch(&a, &b, separation, relative, moved), weight: pair_weight(a.weight, b.weight) }
    }

    #[inline(always)]
    fn answer<C: ContactLaw<S>>(&self, law: &C, part: usize, memory: &mut [[f64; LANES]], forces: &mut [f64]) {
        let mut recalled = C::Memory::<R>::zero();
        for (word, lanes) in memory.iter().enumerate() {
            recalled.set_word(word, R::load_part(lanes, part));
        }
        let Self { touch, weight } = self;
        let half = touch.overlap * R::splat(0.5);
        let given = give(law, touch, *weight, [touch.radius_a - half, touch.radius_b - half], &mut recalled);
        for (word, lanes) in memory.iter_mut().enumerate() {
            recalled.word(word).store_part(lanes, part);
        }
        write::<S, R>(&given, part, forces);
    }
}

/// Sides `a` and `b` of a part's pairs.
type Sides<S, R> = [Side<S, R>; 2];
/// x_a - x_b and v_a - v_b, without the image.
type Between<S, R> = [<S as Space>::VectorOf<R>; 2];

/// What lies between the sides of a part's pairs, and what each has of its own; place and velocity of each are left zero. Taking the differences before words are put
/// lane by lane spares a quarter of that.
#[inline(always)]
fn read<S: Space, R: Part>(pass: &Pass<S>, pairs: &[Pair; LANES], part: usize) -> (Between<S, R>, Sides<S, R>) {
    let (mut a, mut b): ([&[f64]; LANES], [&[f64]; LANES]) = ([&[]; LANES], [&[]; LANES]);
    for (lane, pair) in pairs[part * R::COUNT..(part + 1) * R::COUNT].iter().enumerate() {
        a[lane] = pass.hot[(pair.a - pass.first) as usize].numbers();
        b[lane] = pass.hot[(pair.b() - pass.first) as usize].numbers();
    }
    let own = 2 * S::DIMENSION;
    let mut between = [R::splat(0.0); RECORD_WORDS_MAX];
    let (mut words_a, mut words_b) = (between, between);
    for quad in 0..S::DIMENSION - 1 {
        let mut difference = [R::Quad::zero(); LANES];
        let (mut own_a, mut own_b) = (difference, difference);
        for lane in 0..R::COUNT {
            let (a, b) = (a[lane], b[lane]);
            difference[lane] = R::Quad::load(four(a, 2 * quad)) - R::Quad::load(four(b, 2 * quad));
            own_a[lane] = R::Quad::load(four(a, own + 2 * quad));
            own_b[lane] = R::Quad::load(four(b, own + 2 * quad));
        }
        between[2 * quad..2 * quad + 4].copy_from_slice(&R::of_quads(difference));
        words_a[own + 2 * quad..own + 2 * quad + 4].copy_from_slice(&R::of_quads(own_a));
        words_b[own + 2 * quad..own + 2 * quad + 4].copy_from_slice(&R::of_quads(own_b));
    }
    let between = [Words::of_words(&between), Words::of_words(&between[S::DIMENSION..])];
    (between, [Side::of(&words_a), Side::of(&words_b)])
}

/// From `[word][lane]` to `[pair][word]`, eight words at a time; the last eight overlap those before where a row is no multiple of eight.
#[inline(always)]
fn write<S: Space, R: Part>(given: &Given<S, R>, part: usize, forces: &mut [f64]) {
    let row = row_words::<S>();
    let forces = &mut forces[part * R::COUNT * row..(part + 1) * R::COUNT * row];
    for group in 0..row.div_ceil(LANES) {
        let first = (group * LANES).min(row - LANES);
        let mut words = [R::splat(0.0); LANES];
        for (offset, word) in words.iter_mut().enumerate() {
            *word = given.word(first + offset);
        }
        R::to_records(words, &mut forces[first..], row);
    }
}

/// A grain in lanes: one side of a contact, or by itself.
#[derive(Clone, Copy)]
pub struct Side<S: Space, R: Real> {
    /// Centre, m.
    pub position: S::VectorOf<R>,
    /// Of the centre, m/s.
    pub velocity: S::VectorOf<R>,
    /// rad/s.
    pub spin: S::SpinOf<R>,
    /// m.
    pub radius: R,
    /// Share in the coupled mixture, zero where a body moves the grain ([`Hot::weight`]).
    pub weight: R,
    /// kg, not weighted.
    pub mass: R,
}

impl<S: Space, R: Real> Side<S, R> {
    /// From the words of a record, in the order of [`Hot`].
    #[inline(always)]
    fn of(words: &[R]) -> Self {
        let spin = 2 * S::DIMENSION;
        let behind = spin + <S::SpinOf<R> as Words<R>>::COUNT;
        Self {
            position: Words::of_words(words),
            velocity: Words::of_words(&words[S::DIMENSION..]),
            spin: Words::of_words(&words[spin..]),
            radius: words[behind],
            weight: words[behind + 1],
            mass: words[behind + 2],
        }
    }

    /// Mass that a contact accelerates, kg: without bounds where a body moves the grain.
    #[inline(always)]
    fn mass_moved(&self) -> R {
        R::choose(self.weight.above(R::splat(0.0)), self.mass, R::splat(FLAT))
    }
}

impl<S: Space, P: Pack> Side<S, P> {
    /// Of eight records.
    #[inline(always)]
    pub fn of_record(record: &Lanes<P>) -> Self {
        Self::of(&record.0)
    }
}

impl<S: Space> Side<S, f64> {
    /// Of a single record.
    #[inline(always)]
    pub fn scalar(hot: &Hot<S>) -> Self {
        Self::of(hot.numbers())
    }
}

/// What a pair gives to its two grains.
#[derive(Clone, Copy)]
pub struct Given<S: Space, R: Real> {
    /// On `a`, N, weighted; `b` gets the opposite.
    pub force: S::VectorOf<R>,
    /// On `a` about its centre, N m, weighted.
    pub torque_a: S::SpinOf<R>,
    /// On `b` about its centre, N m, weighted; with a lever arm of zero the resistance to rolling alone.
    pub torque_b: S::SpinOf<R>,
}

impl<S: Space, R: Real> Given<S, R> {
    /// A word of the pair's row, as [`row_words`] orders them.
    #[inline(always)]
    fn word(&self, word: usize) -> R {
        let (is_b, word) = (word >= side_words::<S>(), word % side_words::<S>());
        let torque = if is_b { &self.torque_b } else { &self.torque_a };
        match word.checked_sub(S::DIMENSION) {
            None if is_b => -self.force.word(word),
            None => self.force.word(word),
            Some(axis) if axis < <S::SpinOf<R> as Words<R>>::COUNT => torque.word(axis),
            Some(_) => R::splat(0.0),
        }
    }
}

/// The two sides as the law sees them; `separation` is x_a - x_b in the pair's image, `relative` v_a - v_b.
#[inline(always)]
pub fn touch<S: Space, R: Real>(
    a: &Side<S, R>,
    b: &Side<S, R>,
    separation: S::VectorOf<R>,
    relative: S::VectorOf<R>,
    [advance, dt]: [R; 2],
) -> Touch<S, R> {
    let distance = separation.norm();
    let normal = separation * (R::splat(1.0) / distance);
    let velocity_centres = S::tangential(&normal, &relative);
    let spin_full = a.spin * a.radius + b.spin * b.radius;
    Touch {
        normal,
        overlap: a.radius + b.radius - distance,
        radius_a: a.radius,
        radius_b: b.radius,
        mass_a: a.mass_moved(),
        mass_b: b.mass_moved(),
        velocity_normal: relative.dot(&normal),
        velocity_centres,
        velocity_tangential: velocity_centres - S::surface(&normal, &spin_full),
        spin_relative: a.spin - b.spin,
        twist: S::twist(&normal, &(a.spin + b.spin)) * (R::splat(0.5) * dt),
        advance,
    }
}

/// Weight of a contact in the coupled mixture: the mean of its grains', or a grain's own against one that a body moves,
/// whose weight is zero.
#[inline(always)]
pub fn pair_weight<R: Real>(a: R, b: R) -> R {
    let sum = a + b;
    R::choose(R::min(a, b).above(R::splat(0.0)), sum * R::splat(0.5), sum)
}

/// Forces of a contact with `weight`, their torques by the lever arms of both sides, m; nothing where it does not hold.
#[inline(always)]
pub fn give<S: Space, C: ContactLaw<S>, R: Real>(
    law: &C,
    touch: &Touch<S, R>,
    weight: R,
    arms: [R; 2],
    memory: &mut C::Memory<R>,
) -> Given<S, R> {
    let holds = law.holds(touch, memory);
    let Answer { normal, tangential, moment } = law.force(touch, memory);
    let zero = R::splat(0.0);
    *memory = Words::choose(holds, memory, &Words::zero());
    let normal = R::choose(holds, normal * weight, zero);
    let tangential = Words::choose(holds, &(tangential * weight), &Words::zero());
    let moment: S::SpinOf<R> = Words::choose(holds, &(moment * weight), &Words::zero());
    let turn = S::torque(&touch.normal, &tangential);
    Given {
        force: touch.normal * normal + S::embed(&touch.normal, &tangential),
        torque_a: moment - turn * arms[0],
        torque_b: -moment - turn * arms[1],
    }
}
