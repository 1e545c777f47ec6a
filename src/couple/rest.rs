//! Which cells of a zone have come to rest: those that have sheared by next to nothing while the busiest has sheared by a given strain.
//! Rate independent, as the oracle's clock is.

/// Strain of a cell of grains since the watch began: xx, yy, xy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellStrain {
    /// Index in [`crate::couple::zone::CellGrid`].
    pub cell: u64,
    /// The tensor's: xy is half of the engineering shear strain.
    pub strain: [f64; 3],
    /// Looks at which it held grains, one after the other until now.
    pub looks: u64,
}

impl CellStrain {
    /// The largest shear strain (engineering's) in any direction.
    pub fn shear(&self) -> f64 {
        let [xx, yy, xy] = self.strain;
        ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt()
    }
}

/// A look at a cell that holds grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Index in [`crate::couple::zone::CellGrid`].
    pub cell: u64,
    /// Rate of strain, xx, yy, xy, 1/s; none where too few grains are in it to tell.
    pub rate: Option<[f64; 3]>,
}

/// The cells that hold grains, rising; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RestWatch {
    /// Rising by index.
    pub cells: Vec<CellStrain>,
}

impl RestWatch {
    /// Takes in a look at all cells that hold grains now, rising, as they were for `time`, s. Cells that hold none any more are forgotten. One that does not tell is as it was,
    /// and one that has not told yet rests.
    pub fn take(&mut self, looks: &[Look], time: f64) {
        let most = self.cells.iter().map(|cell| cell.looks).max().unwrap_or(0);
        let mut before = self.cells.iter().peekable();
        let after = looks.iter().map(|look| {
            while before.next_if(|cell| cell.cell < look.cell).is_some() {}
            let known = before.next_if(|cell| cell.cell == look.cell).copied();
            let unknown = CellStrain { looks: if look.rate.is_some() { 0 } else { most }, ..CellStrain::default() };
            let (known, rate) = (known.unwrap_or(unknown), look.rate.unwrap_or_default());
            CellStrain {
                cell: look.cell,
                strain: std::array::from_fn(|part| known.strain[part] + rate[part] * time),
                looks: known.looks + 1,
            }
        });
        self.cells = after.collect();
    }

    /// Shear strain of the busiest cell.
    pub fn most(&self) -> f64 {
        self.cells.iter().map(CellStrain::shear).fold(0.0, f64::max)
    }

    /// Cells that have sheared by this `share` of what the busiest has, or more; and those that grains have come to since the watch
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
        Look { cell, rate: Some([0.0, 0.0, xy]) }
    }

    #[test]
    fn a_cell_that_does_not_tell_is_as_it_was() {
        let mut watch = RestWatch::default();
        let silent = |cell: u64| Look { cell, rate: None };
        watch.take(&[rate(2, 1.0), rate(4, 1.0)], 0.1);
        watch.take(&[rate(2, 1.0), silent(4), silent(7)], 0.1);
        watch.take(&[rate(2, 1.0), rate(4, 1.0), silent(7)], 0.1);
        let shears: Vec<f64> = watch.cells.iter().map(|cell| (10.0 * cell.shear()).round()).collect();
        assert_eq!(shears, [6.0, 4.0, 0.0]);
        // The one that came late and has never told is no reason for all around it to stay.
        assert_eq!(watch.busy(0.5).collect::<Vec<_>>(), [2, 4]);
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
    fn a_cell_that_has_lost_its_grains_is_forgotten_and_begins_anew() {
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
