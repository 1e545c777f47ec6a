//! How layers across a shear share it: whether a cell of grains is sheared as one, or along a band.
//!
//! What a grain moves along the shear beyond the cell's own field is gathered from row to row; over a stretch of strain the
//! difference of its mean between two layers, over their distance, is what the shear between them has beyond the mean. In a
//! cell that is periodic across the layers the last borders on the first.

use crate::base::space::{Linear, Space};
use crate::dem::sample::Sample;

/// Thickness of a layer in mean diameters, the fewest layers of a cell, and how thin they may be for that: thinner ones tell single
/// grains apart, and no bands.
const THICKNESS: f64 = 4.0;
const COUNT_LEAST: usize = 4;
const THICKNESS_LEAST: f64 = 2.5;
/// Shear strain over which layers are compared.
pub const STRETCH: f64 = 0.05;

/// Shear between neighbouring layers over the mean, over the stretch of strain that ends here.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Shear strain at the end of the stretch.
    pub strain: f64,
    /// From the lowest layer up, each with the one above, the last with the first across the period; 1 where all shear alike.
    pub shares: Vec<f64>,
}

impl Profile {
    /// Of the pair of layers that shears most; 0 where there are none.
    pub fn largest(&self) -> f64 {
        self.shares.iter().copied().fold(0.0, f64::max)
    }
}

/// Grains are told apart by their ids, since rows are put in order anew.
pub struct Layers<S: Space> {
    /// None in a cell too low to have some.
    count: usize,
    /// Strain at the last look, and where the stretch began.
    strain: f64,
    began: f64,
    grains: Vec<Followed<S>>,
    /// One for every stretch of strain that has ended.
    pub profiles: Vec<Profile>,
}

#[derive(Clone, Copy)]
struct Followed<S: Space> {
    position: S::Vector,
    /// Along the shear beyond the cell's field since the stretch began, m.
    drift: f64,
    layer: usize,
}

impl<S: Space> Layers<S> {
    /// From the packing before it is sheared; `diameter_mean` in m.
    pub fn of(sample: &Sample<S>, diameter_mean: f64) -> Self {
        let height = sample.assembly.cell.height(1) / diameter_mean;
        let count = ((height / THICKNESS).round() as usize).max(COUNT_LEAST);
        let count = if height < THICKNESS_LEAST * count as f64 { 0 } else { count };
        let grains = &sample.assembly.grains;
        let number = grains.cold[..grains.owned].iter().map(|cold| cold.id.0 as usize + 1).max().unwrap_or(0);
        let nowhere = Followed { position: S::Vector::zero(), drift: 0.0, layer: 0 };
        let mut layers = Self { count, strain: 0.0, began: 0.0, grains: vec![nowhere; number], profiles: Vec::new() };
        for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold) {
            layers.grains[cold.id.0 as usize].position = hot.position;
        }
        layers.begin(sample);
        layers
    }

    /// The coming stretch begins: every grain is of the layer that it is in.
    fn begin(&mut self, sample: &Sample<S>) {
        let (cell, grains) = (&sample.assembly.cell, &sample.assembly.grains);
        for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold) {
            let share = cell.fraction(&hot.position)[1];
            let layer = ((share - share.floor()) * self.count as f64) as usize;
            let grain = &mut self.grains[cold.id.0 as usize];
            (grain.drift, grain.layer) = (0.0, layer.min(self.count.saturating_sub(1)));
        }
        self.began = self.strain;
    }

    /// At a row of the test. Between two rows grains move by less than half of the cell.
    pub fn look(&mut self, sample: &Sample<S>, strain: f64) {
        if self.count == 0 {
            return;
        }
        let (cell, grains) = (&sample.assembly.cell, &sample.assembly.grains);
        let sheared = strain - self.strain;
        for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold) {
            let grain = &mut self.grains[cold.id.0 as usize];
            let mut expected = grain.position;
            expected[0] += sheared * (grain.position[1] - cell.corner[1]);
            let image = cell.image_towards(&expected, &hot.position);
            grain.drift += (hot.position - cell.shift(image) - expected)[0];
            grain.position = hot.position;
        }
        self.strain = strain;
        let stretch = strain - self.began;
        if stretch.abs() >= STRETCH * (1.0 - 1e-6) {
            let shares = self.shares(cell.height(1) / self.count as f64, stretch);
            self.profiles.push(Profile { strain, shares });
            self.begin(sample);
        }
    }

    fn shares(&self, thickness: f64, stretch: f64) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.count];
        for grain in &self.grains {
            sums[grain.layer].0 += grain.drift;
            sums[grain.layer].1 += 1.0;
        }
        let mean = |layer: usize| sums[layer].0 / f64::max(sums[layer].1, 1.0);
        let share = |layer: usize| 1.0 + (mean((layer + 1) % self.count) - mean(layer)) / (thickness * stretch);
        (0..self.count).map(share).collect()
    }
}
