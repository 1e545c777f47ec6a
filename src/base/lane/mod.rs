//! Numbers as the kernels of contacts and points see them: one `f64`, or eight side by side in whatever registers the processor has.
//! A law is written once over [`Real`]; every width rounds alike, lane by lane, so all of them give the same bits
//! (invariant 2). No fused products anywhere.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

mod eight;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "vector instructions, each used only where the processor has it")]
mod x86;

use eight::Eight;

// Nobody outside can name these two, so that they are met only in work that `Instructions::run` has entered for them.
#[cfg(target_arch = "x86_64")]
use x86::{Avx2, Avx512};

/// Lanes of a [`Pack`].
pub const LANES: usize = 8;

/// Numbers that [`Pack::picked`] picks from.
pub type Table = [f64; TABLE];
/// Four registers of eight numbers with AVX-512; the 27 images of a cell in space fit in.
pub const TABLE: usize = 32;

/// Work that is done with whatever registers the processor has.
pub trait Packed {
    /// What the work comes to.
    type Outcome;
    /// Does it in the registers of `P`.
    fn run<P: Pack>(self) -> Self::Outcome;
}

/// Work in registers that are chosen already, a function of its own: what does not ask which law or functions a job has is
/// compiled once and not for each of them. All that it calls must be inlined into it, or entered ([`Pack::enter`]).
pub trait Kernel<P> {
    /// What the work comes to.
    type Outcome;
    /// Does it; [`Pack::enter`] calls it where `P` has its registers.
    fn run(self) -> Self::Outcome;
}

struct Entry<W>(W);

impl<P: Pack, W: Packed> Kernel<P> for Entry<W> {
    type Outcome = W::Outcome;
    #[inline(always)]
    fn run(self) -> W::Outcome {
        self.0.run::<P>()
    }
}

/// A number, or several in step.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The outcome of a comparison, lane by lane.
    type Mask: Copy;
    /// Lanes.
    const COUNT: usize;
    /// `[f64; COUNT]`.
    type Numbers: Copy + AsRef<[f64]> + AsMut<[f64]>;

    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// Correctly rounded; NaN of a number below 0.
    fn sqrt(self) -> Self;
    /// Clears the sign, of -0.0 too.
    fn abs(self) -> Self;
    /// The largest whole number that is not above.
    fn floor(self) -> Self;
    /// The smaller of two ordered numbers; where one is no number, `other`.
    fn min(self, other: Self) -> Self;
    /// The larger of two ordered numbers; where one is no number, `other`.
    fn max(self, other: Self) -> Self;
    /// `self > other`.
    fn above(self, other: Self) -> Self::Mask;
    /// Where `a` and `b` hold.
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Where `a` or `b` holds, or both.
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Whether a mask holds in a lane, and in any.
    fn holds(mask: Self::Mask, lane: usize) -> bool;
    /// Whether it holds in one lane at least.
    fn any(mask: Self::Mask) -> bool;
    /// The lanes one by one, and back.
    fn numbers(self) -> Self::Numbers;
    /// Number `i` goes to lane `i`.
    fn of_numbers(numbers: &Self::Numbers) -> Self;
}

/// As many numbers of a pack as one register holds. What has more numbers at work than there are registers is evaluated part by part, so that none
/// of them has to wait in memory.
pub trait Part: Real {
    /// Four words of a record, in registers that the kernel of these has.
    type Quad: Quad;

    /// Of eight numbers those of a part.
    fn load_part(from: &[f64; LANES], part: usize) -> Self;
    /// The reverse.
    fn store_part(self, to: &mut [f64; LANES], part: usize);
    /// Four words of as many records as there are lanes, the first of these, word by word: result `w` holds word `w` of each.
    fn of_quads(records: [Self::Quad; LANES]) -> [Self; 4];
    /// Eight words of each, word by word, to the records: word `w` of record `i` goes to number `i * width + w`.
    fn to_records(words: [Self; LANES], records: &mut [f64], width: usize);

    /// Of a table's numbers those at the places of a part among eight, which count modulo its length.
    #[inline(always)]
    fn picked(table: &Table, places: &[u64; LANES], part: usize) -> Self {
        Self::load_part(&std::array::from_fn(|lane| table[places[lane] as usize % TABLE]), part)
    }
}

/// A pack is its own only part.
macro_rules! whole_part {
    ($pack:ty, $quad:ty, $of_quads:item $(, $picked:item)?) => {
        impl Part for $pack {
            type Quad = $quad;

            $of_quads
            #[inline(always)]
            fn load_part(from: &[f64; LANES], _: usize) -> Self {
                Self::load(from)
            }
            #[inline(always)]
            fn store_part(self, to: &mut [f64; LANES], _: usize) {
                self.store(to);
            }
            #[inline(always)]
            fn to_records(words: [Self; LANES], records: &mut [f64], width: usize) {
                for (record, numbers) in Self::transposed(words).into_iter().enumerate() {
                    numbers.store(eight_mut(records, record * width));
                }
            }
            $($picked)?
        }
    };
}
use whole_part;

/// Four words of one record side by side, for what is done with records that lie here and there before their words are put lane by lane.
pub trait Quad: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// Zero in each.
    fn zero() -> Self;
    /// As they lie there.
    fn load(from: &[f64; 4]) -> Self;
    /// The reverse.
    fn words(self) -> [f64; 4];
}

/// Eight numbers in step that can be brought from memory and back.
pub trait Pack: Real<Numbers = [f64; LANES]> + Part {
    /// What one register holds of them.
    type Part: Part;

    /// Number `i` goes to lane `i`; aligned as one `f64` is.
    fn load(from: &[f64; LANES]) -> Self;
    /// Lane `i` goes to number `i`; aligned as one `f64` is.
    fn store(self, to: &mut [f64; LANES]);
    /// Calls the kernel as a function that is compiled for these registers.
    fn enter<K: Kernel<Self>>(kernel: K) -> K::Outcome;
    /// Rows for columns: result `w` holds lane `w` of every row.
    fn transposed(rows: [Self; LANES]) -> [Self; LANES];

    /// Eight words of each of eight records, word by word: result `w` holds word `first + w` of every record.
    #[inline(always)]
    fn records(rows: &[&[f64]; LANES], first: usize) -> [Self; LANES] {
        let mut loaded = [Self::splat(0.0); LANES];
        for (loaded, row) in loaded.iter_mut().zip(rows) {
            *loaded = Self::load(eight(row, first));
        }
        Self::transposed(loaded)
    }
}

/// Each of these numbers in every lane. A loop: what `map` calls would be a function of its own, without the registers.
#[inline(always)]
pub fn splats<R: Real, const N: usize>(numbers: [f64; N]) -> [R; N] {
    let mut lanes = [R::splat(0.0); N];
    for (lanes, number) in lanes.iter_mut().zip(numbers) {
        *lanes = R::splat(number);
    }
    lanes
}

/// Eight words of a record from `first` on.
#[inline(always)]
pub fn eight(record: &[f64], first: usize) -> &[f64; LANES] {
    record[first..].first_chunk().expect("a record has the words that it is asked for")
}

/// Four words of a record from `first` on.
#[inline(always)]
pub fn four(record: &[f64], first: usize) -> &[f64; 4] {
    record[first..].first_chunk().expect("a record has the words that it is asked for")
}

/// The same as [`eight`], to be changed.
#[inline(always)]
pub fn eight_mut(record: &mut [f64], first: usize) -> &mut [f64; LANES] {
    record[first..].first_chunk_mut().expect("a record has the words that it is asked for")
}

impl Real for f64 {
    type Mask = bool;
    const COUNT: usize = 1;
    type Numbers = [f64; 1];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f64::floor(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn above(self, other: Self) -> bool {
        self > other
    }
    #[inline(always)]
    fn both(a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn either(a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn choose(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn holds(mask: bool, _: usize) -> bool {
        mask
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
    #[inline(always)]
    fn numbers(self) -> [f64; 1] {
        [self]
    }
    #[inline(always)]
    fn of_numbers(numbers: &[f64; 1]) -> Self {
        numbers[0]
    }
}

/// Instructions that this processor has. There is no other way to one than by looking, so that no kernel can run where the
/// processor lacks what it is compiled for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Instructions(Known);

/// What kernels are compiled for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Known {
    /// Those that every processor has.
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Known {
    /// From the narrowest on.
    const ALL: &[Self] = &[
        Self::Portable,
        #[cfg(target_arch = "x86_64")]
        Self::Avx2,
        #[cfg(target_arch = "x86_64")]
        Self::Avx512,
    ];

    /// Whether this processor has all of them.
    fn is_here(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
        }
    }
}

impl Instructions {
    /// All that this processor has, from the narrowest on.
    pub fn here() -> impl DoubleEndedIterator<Item = Self> {
        Known::ALL.iter().filter(|known| known.is_here()).map(|known| Self(*known))
    }

    /// The widest of them; `SCREE_INSTRUCTIONS` (`portable`, `avx2`, `avx512`) asks for one that is no wider.
    pub fn best() -> Self {
        let wanted = std::env::var("SCREE_INSTRUCTIONS").unwrap_or_default();
        let widest = Known::ALL.iter().position(|known| Self(*known).name() == wanted).unwrap_or(Known::ALL.len() - 1);
        let within = |found: &Self| Known::ALL[..=widest].contains(&found.0);
        Self::here().rfind(within).expect("every processor has the portable ones")
    }

    /// Does the work with these registers.
    #[inline]
    pub fn run<W: Packed>(self, work: W) -> W::Outcome {
        match self.0 {
            Known::Portable => Eight::enter(Entry(work)),
            #[cfg(target_arch = "x86_64")]
            Known::Avx2 => Avx2::enter(Entry(work)),
            #[cfg(target_arch = "x86_64")]
            Known::Avx512 => Avx512::enter(Entry(work)),
        }
    }

    /// `portable`, `avx2` or `avx512`, as `SCREE_INSTRUCTIONS` has it.
    pub fn name(self) -> &'static str {
        match self.0 {
            Known::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Known::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Known::Avx512 => "avx512",
        }
    }
}

impl Debug for Instructions {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What one may be of: zeros, halves, what has no bits left behind the point, and what is no number.
    const ODD: [f64; 26] = [
        0.0,
        -0.0,
        0.3,
        -0.3,
        0.5,
        -0.5,
        1.0,
        -1.0,
        1.5,
        -1.5,
        2.5,
        -2.5,
        1e-310,
        -1e-310,
        1e9 + 0.5,
        -1e9 - 0.5,
        2_251_799_813_685_247.5,
        -2_251_799_813_685_247.5,
        4_503_599_627_370_495.5,
        -4_503_599_627_370_495.5,
        1e300,
        -1e300,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
        7.0,
    ];

    struct AsOneByOne;

    fn bits_of(number: f64) -> u64 {
        // What is no number may have any sign.
        if number.is_nan() { u64::MAX } else { number.to_bits() }
    }

    fn bits(numbers: [f64; LANES]) -> [u64; LANES] {
        numbers.map(bits_of)
    }

    impl Packed for AsOneByOne {
        type Outcome = ();
        fn run<P: Pack>(self) {
            let eight = |first: usize| -> [f64; LANES] { std::array::from_fn(|lane| ODD[(first + lane) % ODD.len()]) };
            for (first, second) in (0..ODD.len()).flat_map(|first| (0..ODD.len()).map(move |second| (first, second))) {
                let (a, b) = (eight(first), eight(second));
                let (pa, pb) = (P::load(&a), P::load(&b));
                let one = |f: fn(f64) -> f64| bits(a.map(f));
                let two = |f: fn(f64, f64) -> f64| bits(std::array::from_fn(|lane| f(a[lane], b[lane])));
                assert_eq!(bits((pa + pb).numbers()), two(|a, b| a + b));
                assert_eq!(bits((pa - pb).numbers()), two(|a, b| a - b));
                assert_eq!(bits((pa * pb).numbers()), two(|a, b| a * b));
                assert_eq!(bits((pa / pb).numbers()), two(|a, b| a / b));
                assert_eq!(bits((-pa).numbers()), one(|a| -a));
                assert_eq!(bits(pa.sqrt().numbers()), one(f64::sqrt));
                assert_eq!(bits(pa.abs().numbers()), one(f64::abs));
                assert_eq!(bits(pa.floor().numbers()), one(f64::floor), "of {a:?}");
                assert_eq!(bits(pa.min(pb).numbers()), two(Real::min));
                assert_eq!(bits(pa.max(pb).numbers()), two(Real::max));
                let (above, below) = (pa.above(pb), pb.above(pa));
                for lane in 0..LANES {
                    assert_eq!(P::holds(above, lane), a[lane] > b[lane]);
                    assert_eq!(P::holds(P::either(above, below), lane), a[lane] > b[lane] || b[lane] > a[lane]);
                    assert!(!P::holds(P::both(above, below), lane));
                }
                assert_eq!(P::any(above), (0..LANES).any(|lane| a[lane] > b[lane]));
                assert_eq!(bits(P::choose(above, pa, pb).numbers()), two(|a, b| if a > b { a } else { b }));
            }
            let rows: [P; LANES] =
                std::array::from_fn(|row| P::load(&std::array::from_fn(|word| (8 * row + word) as f64)));
            for (word, column) in P::transposed(rows).into_iter().enumerate() {
                assert_eq!(column.numbers(), std::array::from_fn(|row| (8 * row + word) as f64));
            }
            let four = |first: usize| -> [f64; 4] { std::array::from_fn(|word| ODD[(first + word) % ODD.len()]) };
            for (first, second) in (0..ODD.len()).flat_map(|first| (0..ODD.len()).map(move |second| (first, second))) {
                let sum = P::Quad::load(&four(first)) + P::Quad::load(&four(second));
                let difference = P::Quad::load(&four(first)) - P::Quad::load(&four(second));
                for word in 0..4 {
                    let (a, b) = (four(first)[word], four(second)[word]);
                    assert_eq!(bits_of(sum.words()[word]), bits_of(a + b));
                    assert_eq!(bits_of(difference.words()[word]), bits_of(a - b));
                }
            }
            assert_eq!(P::Quad::zero().words().map(f64::to_bits), [0; 4]);
            let records: [P::Quad; LANES] =
                std::array::from_fn(|record| P::Quad::load(&std::array::from_fn(|word| (4 * record + word) as f64)));
            for (word, column) in P::of_quads(records).into_iter().enumerate() {
                assert_eq!(column.numbers(), std::array::from_fn(|record| (4 * record + word) as f64));
            }
        }
    }

    struct PartByPart;

    /// Records of eleven numbers, part by part, into their columns and back; numbers; places of a table.
    fn goes_and_comes_back<R: Part>() {
        const WIDTH: usize = 11;
        let record = |of: usize| -> [f64; WIDTH] { std::array::from_fn(|word| (100 * of + word) as f64 - 350.25) };
        let records: [[f64; WIDTH]; LANES] = std::array::from_fn(record);
        let table: Table = std::array::from_fn(|place| place as f64 + 0.5);
        let places: [u64; LANES] = std::array::from_fn(|lane| (7 * lane + 3) as u64 % TABLE as u64);
        let (mut numbers, mut written) = ([0.0; LANES], [0.0; LANES * WIDTH]);
        for part in 0..LANES / R::COUNT {
            let first = part * R::COUNT;
            let mut words = [R::splat(0.0); LANES];
            for quad in [0, 4] {
                let mut quads = [R::Quad::zero(); LANES];
                let these = quads.iter_mut().zip(&records[first..first + R::COUNT]);
                these.for_each(|(loaded, record)| *loaded = R::Quad::load(four(record, 3 + quad)));
                words[quad..quad + 4].copy_from_slice(&R::of_quads(quads));
            }
            for (word, column) in words.iter().enumerate() {
                let wanted: Vec<f64> = records[first..first + R::COUNT].iter().map(|record| record[3 + word]).collect();
                assert_eq!(column.numbers().as_ref(), wanted);
            }
            R::to_records(words, &mut written[first * WIDTH + 3..(first + R::COUNT) * WIDTH], WIDTH);
            R::load_part(&records[0][..LANES].try_into().expect("eight"), part).store_part(&mut numbers, part);
            let found = R::picked(&table, &places, part);
            let wanted: Vec<f64> = places[first..first + R::COUNT].iter().map(|place| table[*place as usize]).collect();
            assert_eq!(found.numbers().as_ref(), wanted);
        }
        assert_eq!(numbers, records[0][..LANES]);
        for (written, record) in written.chunks(WIDTH).zip(&records) {
            assert_eq!((&written[..3], &written[3..]), (&[0.0; 3][..], &record[3..]));
        }
    }

    impl Packed for PartByPart {
        type Outcome = ();
        fn run<P: Pack>(self) {
            goes_and_comes_back::<P::Part>();
            goes_and_comes_back::<P>();
        }
    }

    #[test]
    fn every_width_does_what_single_numbers_do() {
        Instructions::here().for_each(|instructions| instructions.run(AsOneByOne));
    }

    #[test]
    fn records_go_through_parts_and_come_back() {
        Instructions::here().for_each(|instructions| instructions.run(PartByPart));
    }
}
