//! Grains inserted one after the other to random places of a box, each where nothing is yet (random sequential insertion).
//!
//! The random numbers of a grain come from (seed, id) alone, its size first, its places after.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use crate::base::space::Space;
use crate::dem::cell::Cell;
use crate::job::assembly::Sizes;

/// Trials per grain before a box counts as full. Inserted one after the other discs jam at a solid volume fraction of 0.547,
/// spheres at 0.38.
const TRIALS_MAX: usize = 20_000;
/// Deviations at which normal sizes are cut.
const DEVIATIONS_MAX: f64 = 3.0;

/// Random numbers of one grain.
pub fn random_of(seed: u64, id: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(id);
    random
}

/// Uniform in [0, 1) from the upper 53 bits.
pub fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * (0.5f64).powi(53)
}

/// Mean zero, deviation one.
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

impl Sizes {
    /// A radius, m.
    pub fn draw(&self, random: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::Normal { mean, deviation } => loop {
                let deviate = normal(random);
                if deviate.abs() <= DEVIATIONS_MAX {
                    return 0.5 * (mean + deviate * deviation);
                }
            },
            Self::Uniform { min, max } => 0.5 * (min + (max - min) * uniform(random)),
            Self::List(list) => {
                let drawn = uniform(random);
                let mut sum = 0.0;
                let class = list.iter().find(|(_, share)| {
                    sum += share;
                    drawn < sum
                });
                // The shares may fall short of 1 by rounding.
                0.5 * class.or(list.last()).map_or(0.0, |(diameter, _)| *diameter)
            }
        }
    }
}

/// Radii of grains `0..count`, m.
pub fn radii(sizes: &Sizes, seed: u64, count: u64) -> Vec<f64> {
    (0..count).map(|id| sizes.draw(&mut random_of(seed, id))).collect()
}

/// The box has no room for this grain after as many trials as are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoRoom {
    /// Its number from 0, which is also its id.
    pub grain: u64,
}

/// Places for grains of the radii that [`radii`] drew, without overlap: anywhere along periodic axes of the box, inside it
/// along the others, and where `is_open` says that a grain of that radius may be.
pub fn places<S: Space>(
    cell: &Cell<S>,
    sizes: &Sizes,
    seed: u64,
    radii: &[f64],
    is_open: impl Fn(&S::Vector, f64) -> bool,
) -> Result<Vec<S::Vector>, NoRoom> {
    let mut taken = Taken::new(cell, 2.0 * radii.iter().copied().fold(0.0, f64::max));
    let mut places = Vec::with_capacity(radii.len());
    for (id, radius) in radii.iter().enumerate() {
        let mut random = random_of(seed, id as u64);
        sizes.draw(&mut random);
        let inserted = (0..TRIALS_MAX).map(|_| taken.insert(*radius, &mut random));
        let mut free = inserted.filter(|place| taken.is_free(place, *radius) && is_open(place, *radius));
        let place = free.next().ok_or(NoRoom { grain: id as u64 })?;
        taken.put(place, *radius);
        places.push(place);
    }
    Ok(places)
}

/// Places that are taken, in bins over a box with edges along the axes.
struct Taken<S: Space> {
    corner: S::Vector,
    lengths: [f64; 3],
    periodic: [bool; 3],
    counts: [usize; 3],
    bins: Vec<Vec<(S::Vector, f64)>>,
}

impl<S: Space> Taken<S> {
    /// Bins at least as wide as `reach`.
    fn new(cell: &Cell<S>, reach: f64) -> Self {
        let (mut lengths, mut counts) = ([0.0; 3], [1; 3]);
        for axis in 0..S::DIMENSION {
            lengths[axis] = cell.edges[axis * S::DIMENSION + axis];
            counts[axis] = ((lengths[axis] / reach) as usize).max(1);
        }
        let bins = vec![Vec::new(); counts.iter().product()];
        Self { corner: cell.corner, lengths, periodic: cell.periodic, counts, bins }
    }

    fn insert(&self, radius: f64, random: &mut ChaCha8Rng) -> S::Vector {
        let mut place = self.corner;
        for axis in 0..S::DIMENSION {
            let length = self.lengths[axis];
            place[axis] += match self.periodic[axis] {
                true => length * uniform(random),
                false => radius + (length - 2.0 * radius) * uniform(random),
            };
        }
        place
    }

    fn bin(&self, place: &S::Vector) -> [usize; 3] {
        let mut bin = [0; 3];
        for axis in 0..S::DIMENSION {
            let share = (place[axis] - self.corner[axis]) / self.lengths[axis];
            bin[axis] = ((share * self.counts[axis] as f64) as usize).min(self.counts[axis] - 1);
        }
        bin
    }

    fn index(&self, bin: [usize; 3]) -> usize {
        (bin[2] * self.counts[1] + bin[1]) * self.counts[0] + bin[0]
    }

    fn put(&mut self, place: S::Vector, radius: f64) {
        let index = self.index(self.bin(&place));
        self.bins[index].push((place, radius));
    }

    fn is_free(&self, place: &S::Vector, radius: f64) -> bool {
        let bin = self.bin(place);
        let beside = |axis: usize| {
            let count = self.counts[axis] as i64;
            let wraps = self.periodic[axis];
            let reach = i64::from(axis < S::DIMENSION);
            (-reach..=reach).map(move |step| bin[axis] as i64 + step).filter_map(move |at| match wraps {
                true => Some(at.rem_euclid(count) as usize),
                false => (0..count).contains(&at).then_some(at as usize),
            })
        };
        let clear = |(other, other_radius): &(S::Vector, f64)| {
            let reach = radius + other_radius;
            self.square_apart(place, other) >= reach * reach
        };
        beside(2).all(|z| beside(1).all(|y| beside(0).all(|x| self.bins[self.index([x, y, z])].iter().all(clear))))
    }

    /// Square of the distance to the nearest image, m2.
    fn square_apart(&self, a: &S::Vector, b: &S::Vector) -> f64 {
        let mut square = 0.0;
        for axis in 0..S::DIMENSION {
            let apart = (a[axis] - b[axis]).abs();
            let apart = if self.periodic[axis] { apart.min(self.lengths[axis] - apart) } else { apart };
            square += apart * apart;
        }
        square
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Linear, Plane, Solid};

    fn cell<S: Space>(edge: f64, periodic: [bool; 3]) -> Cell<S> {
        let (mut corner, mut lengths) = (S::Vector::zero(), S::Vector::zero());
        for axis in 0..S::DIMENSION {
            (corner[axis], lengths[axis]) = (-0.3, edge);
        }
        Cell::cuboid(corner, lengths, periodic)
    }

    /// No two overlap across the periods, none leaves a closed side, and a grain's numbers do not hang on the others'.
    fn inserted<S: Space>(edge: f64, count: u64) {
        let periodic = [true, false, true];
        let sizes = Sizes::Uniform { min: 0.8e-2, max: 1.2e-2 };
        let cell = cell::<S>(edge, periodic);
        let radii_all = radii(&sizes, 7, count);
        let corner = cell.corner;
        let ball = |place: &S::Vector, radius: f64| (*place - corner).norm() > 0.1 * edge + radius;
        let places_all = places(&cell, &sizes, 7, &radii_all, ball).unwrap();
        for (i, (a, radius)) in places_all.iter().zip(&radii_all).enumerate() {
            assert!(a[1] >= -0.3 + radius && a[1] <= -0.3 + edge - radius);
            assert!(ball(a, *radius));
            for (b, other) in places_all.iter().zip(&radii_all).skip(i + 1) {
                let mut square = 0.0;
                for axis in 0..S::DIMENSION {
                    let apart = a[axis] - b[axis];
                    let apart = if periodic[axis] { apart - edge * (apart / edge).round() } else { apart };
                    square += apart * apart;
                }
                assert!(square.sqrt() >= radius + other - 1e-12);
            }
        }
        let fewer = places(&cell, &sizes, 7, &radii_all[..40], ball).unwrap();
        assert_eq!(fewer[..], places_all[..40]);
        let others = places(&cell, &sizes, 8, &radii(&sizes, 8, count), |_, _| true).unwrap();
        assert!(others.iter().zip(&places_all).all(|(a, b)| a != b));
    }

    #[test]
    fn thrown_grains_do_not_overlap() {
        inserted::<Plane>(0.2, 200);
        inserted::<Solid>(0.1, 400);
    }

    #[test]
    fn a_full_box_says_which_grain_finds_no_room() {
        let sizes = Sizes::List(vec![(0.02, 1.0)]);
        let cell = cell::<Plane>(0.1, [true; 3]);
        let full = places(&cell, &sizes, 1, &radii(&sizes, 1, 25), |_, _| true).unwrap_err();
        assert!((10..20).contains(&full.grain), "{full:?}");
    }

    #[test]
    fn sizes_are_drawn_as_they_are_spread() {
        let moments = |sizes: &Sizes| {
            let drawn = radii(sizes, 3, 20_000);
            let mean = drawn.iter().sum::<f64>() / 20_000.0;
            let square = drawn.iter().map(|radius| (radius - mean) * (radius - mean)).sum::<f64>() / 20_000.0;
            (2.0 * mean, 2.0 * square.sqrt())
        };
        let near = |found: f64, wanted: f64| (found / wanted - 1.0).abs() < 0.02;
        let (mean, deviation) = moments(&Sizes::Normal { mean: 1.0, deviation: 0.1 });
        assert!(near(mean, 1.0) && near(deviation, 0.1 * 0.9733f64.sqrt()), "{mean} {deviation}");
        let (mean, deviation) = moments(&Sizes::Uniform { min: 0.5, max: 1.5 });
        assert!(near(mean, 1.0) && near(deviation, 1.0 / 12.0f64.sqrt()), "{mean} {deviation}");
        let (mean, _) = moments(&Sizes::List(vec![(1.0, 0.25), (2.0, 0.75)]));
        assert!(near(mean, 1.75), "{mean}");
    }
}
