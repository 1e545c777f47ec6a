//! Which cells have come to rest: those that have sheared by next to nothing while the busiest has sheared by a given strain, whether they hold grains or continuum.
//! Rate independent, as the oracle's clock is.

use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

use crate::law::material::RELOADING_SHARE;

/// Strain of a cell since the watch began: xx, yy, xy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellStrain {
    /// Index in [`crate::couple::zone::CellGrid`].
    pub cell: u64,
    /// Of its grains, the tensor's: xy is half of the engineering shear strain.
    pub strain: [f64; 3],
    /// Mean plastic strain of its points as the watch began, or as they came, and now.
    pub plastic: [f64; 2],
    /// Looks at which it held anything, one after the other until now.
    pub looks: u64,
    /// The largest share of the strength of the law that its grains have borne since loading began: a share that falls below half of it begins another loading. Of the place, not
    /// of the grains: those that are carried along leave it to those that follow.
    pub mobilised: f64,
}

impl CellStrain {
    /// The largest shear strain (engineering's) in any direction, of its grains or of its points, which shear where they flow: by sqrt(2) |eps_p| where volume does not.
    pub fn shear(&self) -> f64 {
        let ([xx, yy, xy], [before, now]) = (self.strain, self.plastic);
        ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt().max(SQRT_2 * (now - before))
    }
}

/// A look at a cell that holds anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Index in [`crate::couple::zone::CellGrid`].
    pub cell: u64,
    /// Rate of strain of its grains, xx, yy, xy, 1/s; none where too few are in it to tell.
    pub rate: Option<[f64; 3]>,
    /// Mean plastic strain of its points; none where too few are in it.
    pub plastic: Option<f64>,
}

/// The cells that hold anything, rising; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RestWatch {
    /// Rising by index.
    pub cells: Vec<CellStrain>,
}

impl RestWatch {
    /// Takes in a look at all cells that hold anything now, rising, as they were for `time`, s. Cells that hold none any more are forgotten. One that does not tell is as it was,
    /// and one that has not told yet rests.
    pub fn take(&mut self, looks: &[Look], time: f64) {
        let most = self.cells.iter().map(|cell| cell.looks).max().unwrap_or(0);
        let mut before = self.cells.iter().peekable();
        let after = looks.iter().map(|look| {
            while before.next_if(|cell| cell.cell < look.cell).is_some() {}
            let known = before.next_if(|cell| cell.cell == look.cell).copied();
            let unknown = CellStrain { looks: if look.rate.is_some() { 0 } else { most }, ..CellStrain::default() };
            let (known, rate) = (known.unwrap_or(unknown), look.rate.unwrap_or_default());
            let [began, before] = known.plastic;
            CellStrain {
                cell: look.cell,
                strain: std::array::from_fn(|part| known.strain[part] + rate[part] * time),
                plastic: match look.plastic {
                    Some(now) if before > 0.0 => [began.min(now), now],
                    // The first points of a cell may have flowed elsewhere.
                    Some(now) => [now; 2],
                    None => known.plastic,
                },
                looks: known.looks + 1,
                mobilised: known.mobilised,
            }
        });
        self.cells = after.collect();
    }

    /// Begins anew, but for what cells have borne.
    pub fn begin(&mut self) {
        for cell in &mut self.cells {
            (cell.strain, cell.plastic, cell.looks) = ([0.0; 3], [cell.plastic[1]; 2], 0);
        }
    }

    /// Takes in what cells, rising, bear of the strength of the law.
    pub fn load(&mut self, borne: &BTreeMap<u64, f64>) {
        for cell in &mut self.cells {
            if let Some(now) = borne.get(&cell.cell) {
                // Without pressure nothing is borne, whatever share that is.
                let now = if now.is_finite() { *now } else { 0.0 };
                cell.mobilised = cell.mobilised.min(now / RELOADING_SHARE).max(now);
            }
        }
    }

    /// What a cell has borne, as a share of the strength of the law; 0 where none has told.
    pub fn mobilised(&self, cell: u64) -> f64 {
        self.cells.binary_search_by_key(&cell, |known| known.cell).map_or(0.0, |at| self.cells[at].mobilised)
    }

    /// Shear strain of the busiest cell.
    pub fn most(&self) -> f64 {
        self.cells.iter().map(CellStrain::shear).fold(0.0, f64::max)
    }

    /// The cell that has sheared most, the first of several.
    pub fn busiest(&self) -> Option<u64> {
        let most = self.most();
        self.cells.iter().find(|cell| cell.shear() >= most).map(|cell| cell.cell)
    }

    /// Cells that have sheared by this `share` of what the busiest has, or more; and those that were empty when the watch
    /// began, of which nothing is known.
    pub fn busy(&self, share: f64) -> impl Iterator<Item = u64> {
        let least = share * self.most();
        let looks = self.cells.iter().map(|cell| cell.looks).max().unwrap_or(0);
        self.cells.iter().filter(move |cell| cell.shear() >= least || cell.looks < looks).map(|cell| cell.cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(cell: u64, xy: f64) -> Look {
        Look { cell, rate: Some([0.0, 0.0, xy]), plastic: None }
    }

    #[test]
    fn a_cell_that_does_not_tell_is_as_it_was() {
        let mut watch = RestWatch::default();
        let silent = |cell: u64| Look { cell, rate: None, plastic: None };
        watch.take(&[rate(2, 1.0), rate(4, 1.0)], 0.1);
        watch.take(&[rate(2, 1.0), silent(4), silent(7)], 0.1);
        watch.take(&[rate(2, 1.0), rate(4, 1.0), silent(7)], 0.1);
        let shears: Vec<f64> = watch.cells.iter().map(|cell| (10.0 * cell.shear()).round()).collect();
        assert_eq!(shears, [6.0, 4.0, 0.0]);
        // The one that came late and has never told is no reason for all around it to stay.
        assert_eq!(watch.busy(0.5).collect::<Vec<_>>(), [2, 4]);
    }

    /// Continuum shears where it flows, which counts from when the watch began, whatever its points have been through.
    #[test]
    fn points_shear_by_as_much_as_they_flow() {
        let mut watch = RestWatch::default();
        let flowed = |cell: u64, plastic: f64| Look { cell, rate: None, plastic: Some(plastic) };
        watch.take(&[rate(2, 0.05), flowed(4, 0.3)], 0.1);
        watch.take(&[rate(2, 0.05), flowed(4, 0.4)], 0.1);
        assert!((watch.most() - 0.1 * SQRT_2).abs() < 1e-12, "{watch:?}");
        assert_eq!(watch.busiest(), Some(4));
        // What flowed before is nothing, and points that have flowed less are no shear.
        watch.begin();
        watch.take(&[rate(2, 0.05), flowed(4, 0.4), flowed(5, 0.1)], 0.1);
        watch.take(&[rate(2, 0.05), flowed(4, 0.2), flowed(5, 0.1)], 0.1);
        assert_eq!(watch.busiest(), Some(2), "{watch:?}");
        assert!((watch.most() - 0.02).abs() < 1e-12, "{watch:?}");
    }

    #[test]
    fn what_was_borne_counts_until_another_loading_begins() {
        let mut watch = RestWatch::default();
        let told = |watch: &mut RestWatch, share: f64| {
            watch.take(&[rate(2, 0.0), rate(3, 0.0)], 0.1);
            watch.load(&BTreeMap::from([(3, share)]));
            watch.mobilised(3)
        };
        assert_eq!([0.9, 0.6, 0.95].map(|share| told(&mut watch, share)), [0.9, 0.9, 0.95]);
        watch.begin();
        assert_eq!([0.5, 0.4, 0.1].map(|share| told(&mut watch, share)), [0.95, 0.8, 0.2]);
        // Out of pressure.
        assert_eq!([f64::INFINITY, 0.3].map(|share| told(&mut watch, share)), [0.0, 0.3]);
        assert_eq!((watch.mobilised(2), watch.mobilised(7)), (0.0, 0.0));
    }

    #[test]
    fn cells_that_shear_to_and_fro_rest_and_those_that_go_on_do_not() {
        let mut watch = RestWatch::default();
        for look in 0..10 {
            let to_and_fro = if look % 2 == 0 { 1.0 } else { -1.0 };
            watch.take(&[rate(2, 1.0), rate(3, to_and_fro), rate(7, 0.1)], 0.01);
        }
        assert!((watch.most() - 0.2).abs() < 1e-12);
        assert_eq!(watch.busy(0.05).collect::<Vec<_>>(), [2, 7]);
        assert_eq!(watch.busy(0.2).collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn a_cell_that_has_been_empty_is_forgotten_and_begins_anew() {
        let mut watch = RestWatch::default();
        watch.take(&[rate(2, 1.0), rate(5, 3.0)], 0.1);
        watch.take(&[rate(2, 1.0)], 0.1);
        watch.take(&[rate(1, 1.0), rate(2, 1.0), rate(5, 3.0)], 0.1);
        let shears: Vec<f64> = watch.cells.iter().map(|cell| (10.0 * cell.shear()).round()).collect();
        assert_eq!(shears, [2.0, 6.0, 6.0]);
        // The first and the last have come too late to be called at rest.
        assert_eq!(watch.busy(0.9).collect::<Vec<_>>(), [1, 2, 5]);
        assert_eq!(watch.cells.iter().map(|cell| cell.looks).collect::<Vec<_>>(), [1, 3, 1]);
    }
}
