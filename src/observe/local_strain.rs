//! Deformation at every grain: the gradient that takes the places of a grain and its neighbours at the start best to those
//! of now, in the plane and in space, in cells that are periodic and may deform.
//!
//! With dX and dx the separations of a grain and its neighbours at the start and now,
//!
//! ```text
//! min over F of  sum_j |dx_j - F dX_j|^2     =>  F = (sum dx dX^T) (sum dX dX^T)^-1
//! ```
//!
//! which is Cundall's best fit ([`crate::observe::strain`]) about the grain's own centre. Neighbours are the grains that lie
//! now within 1.5 times the sum of the two radii: whether they touch, and what the lists hold, does not matter.
//!
//! Where a cell deforms, the place of an image at the start is not known, so that only neighbours count that began in the
//! image of the cell that the grain began in.

use rayon::prelude::*;

use crate::base::space::{Linear, Space};
use crate::dem::cell::{Cell, Image};

/// Between the first shell of neighbours and the second.
const REACH: f64 = 1.5;
/// Neighbours do not span the space where the determinant of their moment is below this share of the power of its trace.
const SINGULAR: f64 = 1e-6;

/// A grain inside the cell.
#[derive(Clone, Copy, Debug)]
pub struct Place<S: Space> {
    /// m.
    pub position: S::Vector,
    /// From the start to where the grain is without being wrapped, m.
    pub displacement: S::Vector,
    /// Periods that wrapping has taken it back by.
    pub image: Image,
    /// m.
    pub radius: f64,
}

/// A grain, or an image of one, among which neighbours are looked for.
struct Candidate<S: Space> {
    bin: usize,
    row: u32,
    image: Image,
    position: S::Vector,
}

/// Deformation gradients since the start; none where the neighbours do not span the space. Sums run in the order of
/// `places`, in the cell first: give them in an order that ids alone fix, and every bit is fixed.
pub fn best_fit_deformations<S: Space>(places: &[Place<S>], cell: &Cell<S>, deforms: bool) -> Vec<Option<S::Tensor>> {
    let radius_max = places.iter().map(|place| place.radius).fold(0.0, f64::max);
    if radius_max == 0.0 {
        return vec![None; places.len()];
    }
    let bins = Bins::new(places, cell, 2.0 * REACH * radius_max);
    places.par_iter().map(|place| fit(place, places, &bins, cell, deforms)).collect()
}

fn fit<S: Space>(
    grain: &Place<S>,
    places: &[Place<S>],
    bins: &Bins<S>,
    cell: &Cell<S>,
    deforms: bool,
) -> Option<S::Tensor> {
    let (mut mixed, mut moment) = (S::Tensor::zero(), S::Tensor::zero());
    bins.around(cell, &grain.position, |candidate| {
        let other = &places[candidate.row as usize];
        let now = candidate.position - grain.position;
        let reach = REACH * (grain.radius + other.radius);
        let apart = now.dot(&now);
        // The grain itself is at no distance.
        if apart > reach * reach || apart == 0.0 {
            return;
        }
        let began_here = (0..3).all(|axis| other.image[axis] + candidate.image[axis] == grain.image[axis]);
        if deforms && !began_here {
            return;
        }
        let before = now - (other.displacement - grain.displacement);
        mixed += S::outer(&now, &before);
        moment += S::outer(&before, &before);
    });
    let trace = S::trace(&moment);
    let power = (0..S::DIMENSION).fold(1.0, |power, _| power * trace);
    if S::determinant(&moment).is_nan() || S::determinant(&moment) <= SINGULAR * power {
        return None;
    }
    S::inverse(&moment).map(|inverse| mixed * inverse).filter(|gradient| S::determinant(gradient) > 0.0)
}

/// Grains and the images of those near a periodic border, in bins along the edges of the cell.
struct Bins<S: Space> {
    counts: [usize; 3],
    /// How far images stand out of the cell, as a share of each edge.
    margin: [f64; 3],
    /// By bins: there may be far more of these than grains.
    candidates: Vec<Candidate<S>>,
}

impl<S: Space> Bins<S> {
    fn new(places: &[Place<S>], cell: &Cell<S>, reach: f64) -> Self {
        let (mut counts, mut margin) = ([1; 3], [0.0; 3]);
        for axis in 0..S::DIMENSION {
            let height = cell.height(axis);
            if cell.periodic[axis] {
                margin[axis] = (reach / height).min(1.0);
            }
            // No more bins along an axis than grains, however large an open cell is.
            let most = places.len().max(1) as f64;
            counts[axis] = (height * (1.0 + 2.0 * margin[axis]) / reach).min(most).max(1.0) as usize;
        }
        let mut bins = Self { counts, margin, candidates: Vec::new() };
        let mut candidates = Vec::with_capacity(places.len());
        for (row, place) in places.iter().enumerate() {
            for image in images::<S>(cell.periodic) {
                let position = place.position + cell.shift(image);
                if image == [0; 3] || bins.holds(cell, &position) {
                    let bin = bins.index(bins.place(cell, &position));
                    candidates.push(Candidate { bin, row: row as u32, image, position });
                }
            }
        }
        // In place: there may be millions. Images of a row come in the order of [`images`].
        candidates.sort_unstable_by_key(|of| (of.bin, of.row, of.image[2], of.image[1], of.image[0]));
        bins.candidates = candidates;
        bins
    }

    fn holds(&self, cell: &Cell<S>, position: &S::Vector) -> bool {
        let at = cell.fraction(position);
        (0..S::DIMENSION)
            .all(|axis| !cell.periodic[axis] || (-self.margin[axis]..=1.0 + self.margin[axis]).contains(&at[axis]))
    }

    fn place(&self, cell: &Cell<S>, position: &S::Vector) -> [usize; 3] {
        let at = cell.fraction(position);
        let mut place = [0; 3];
        for axis in 0..S::DIMENSION {
            let share = (at[axis] + self.margin[axis]) / (1.0 + 2.0 * self.margin[axis]);
            place[axis] = ((share * self.counts[axis] as f64).max(0.0) as usize).min(self.counts[axis] - 1);
        }
        place
    }

    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.counts[1] + place[1]) * self.counts[0] + place[0]
    }

    /// Visits what lies in the bins around a position.
    fn around(&self, cell: &Cell<S>, position: &S::Vector, mut visit: impl FnMut(&Candidate<S>)) {
        let place = self.place(cell, position);
        let range = |axis: usize| place[axis].saturating_sub(1)..=(place[axis] + 1).min(self.counts[axis] - 1);
        for z in range(2) {
            for y in range(1) {
                // Bins along x follow on one another.
                let [first, last] = [range(0).start(), range(0).end()].map(|x| self.index([*x, y, z]));
                let start = self.candidates.partition_point(|candidate| candidate.bin < first);
                let held = self.candidates[start..].iter().take_while(|candidate| candidate.bin <= last);
                held.for_each(&mut visit);
            }
        }
    }
}

/// None, and one period either way along every periodic edge.
fn images<S: Space>(periodic: [bool; 3]) -> impl Iterator<Item = Image> {
    let range = |axis: usize| if axis < S::DIMENSION && periodic[axis] { -1..=1 } else { 0..=0 };
    let (xs, ys, zs) = (range(0), range(1), range(2));
    zs.flat_map(move |z| {
        let xs = xs.clone();
        ys.clone().flat_map(move |y| xs.clone().map(move |x| [x, y, z]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Plane, Solid};

    /// A lattice that has been deformed uniformly with its cell, and wrapped into it.
    fn deformed<S: Space>(count: usize, gradient: &S::Tensor) -> (Vec<Place<S>>, Cell<S>) {
        let mut lengths = S::Vector::zero();
        (0..S::DIMENSION).for_each(|axis| lengths[axis] = count as f64);
        let mut cell = Cell::<S>::cuboid(S::Vector::zero(), lengths, [true; 3]);
        cell.deform(*gradient, 1.0);
        let after = S::identity() + *gradient;
        let places = (0..count.pow(S::DIMENSION as u32)).map(|row| {
            let mut start = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                let ripple = 0.1 * ((row * (axis + 3)) % 7) as f64;
                start[axis] = (row / count.pow(axis as u32) % count) as f64 + ripple;
            }
            let mut position = after * start;
            let displacement = position - start;
            let image = cell.wrap(&mut position, &mut S::Vector::zero());
            Place { position, displacement, image, radius: 0.55 }
        });
        (places.collect(), cell)
    }

    fn check<S: Space>(count: usize, entries: &[f64]) {
        let mut gradient = S::Tensor::zero();
        gradient.as_mut_slice().copy_from_slice(entries);
        let (places, cell) = deformed::<S>(count, &gradient);
        let found = best_fit_deformations(&places, &cell, true);
        let whole = found.iter().flatten();
        let off = whole.clone().map(|found| (*found - S::identity() - gradient).norm()).fold(0.0, f64::max);
        println!("{}: {} of {} grains, off by {off:e}", S::NAME, whole.clone().count(), places.len());
        assert!(off < 1e-12 && whole.count() > places.len() * 9 / 10);
    }

    #[test]
    fn a_uniform_deformation_is_found_at_every_grain() {
        check::<Plane>(12, &[0.1, 0.05, 0.3, -0.2]);
        check::<Solid>(7, &[0.1, 0.0, 0.05, 0.3, -0.1, 0.0, 0.0, 0.2, 0.05]);
    }

    /// In a cell at rest images moved as their grains did.
    #[test]
    fn neighbours_across_a_cell_at_rest_count() {
        let (places, cell) = deformed::<Plane>(6, &Linear::zero());
        let found = best_fit_deformations(&places, &cell, false);
        assert!(found.iter().all(|found| found.is_some_and(|found| (found - Plane::identity()).norm() < 1e-12)));
    }

    #[test]
    fn neighbours_in_a_row_tell_nothing() {
        let (mut places, cell) = deformed::<Plane>(9, &Linear::zero());
        places.retain(|place| place.position[1] < 0.9);
        places.iter_mut().for_each(|place| place.position[1] = 0.5);
        assert!(best_fit_deformations(&places, &cell, false).iter().all(Option::is_none));
        assert!(best_fit_deformations::<Plane>(&[], &cell, false).is_empty());
    }
}
