//! A law as the fit sees it: parameters within bounds that make one. A further law needs a [`Model`] and no more.

use super::element::Row;
use super::fit::{friction, sine};
use super::least_squares::{Parameter, least_squares};
use super::path::{Drive, Kept, LawOfAnySpace, sheared};

/// Nearer to a bound than this share of its scale a figure is at it.
const AT_BOUND: f64 = 1e-3;

/// A law with `N` parameters that tests tell.
pub trait Model<const N: usize> {
    /// What the parameters make, and what is driven along the tests.
    type Law: LawOfAnySpace;
    /// The keys of its parameters, where they start, and their bounds.
    fn parameters(&self) -> [(&'static str, Parameter); N];
    /// None where they make no law that can run.
    fn law(&self, at: &[f64; N]) -> Option<Self::Law>;
    /// The solid volume fraction that is compared with that of grains: the law's own, or what its change of volume makes of
    /// that of the start.
    fn fraction(row: &Row, _volume: f64, _start: f64) -> f64 {
        row.fraction
    }
}

/// A test that a law shall follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The path of the test, and the state that it starts from.
    pub drive: Drive,
    /// Of the grains; the law is compared at their strains.
    pub rows: Vec<Row>,
    /// Of each row, for the shear stress over the normal one and for the solid volume fraction.
    pub weights: Vec<[f64; 2]>,
    /// The row from which on the shear stress of each row is compared: of an unloading the turn, so that it tells of the way back
    /// and not of the height that it began at.
    pub since: Vec<Option<usize>>,
}

impl Curve {
    /// The law's rows at the strains of this one, and its volumes over that of the start.
    pub fn response<L: LawOfAnySpace>(&self, law: &L) -> Option<Vec<(Row, f64)>> {
        sheared(law, self.drive, self.rows.iter().map(|row| row.strain))
    }

    /// Shear stress over the normal stress, at constant volume over that of the start; in biaxial compression the sine of the
    /// mobilised angle.
    pub fn ratio(&self, row: &Row) -> f64 {
        match self.drive.kept {
            Kept::NormalStress => friction(row),
            Kept::Volume => row.stress[1] / self.drive.stress,
            Kept::LateralStress => sine(row),
        }
    }
}

/// The parameters with which a model follows the curves with the least squares, and the keys of those at a bound; none where the
/// start makes no law, or one that does not bear the tests.
pub fn follow<const N: usize, M: Model<N>>(
    model: &M,
    curves: &[Curve],
    start: Option<&[f64; N]>,
) -> Option<([f64; N], Vec<&'static str>)> {
    let residuals = |at: &[f64; N]| -> Option<Vec<f64>> {
        let law = model.law(at)?;
        let mut residuals = Vec::new();
        for curve in curves {
            let response = curve.response(&law)?;
            let off = |index: usize| curve.ratio(&response[index].0) - curve.ratio(&curve.rows[index]);
            for (index, (row, weights)) in curve.rows.iter().zip(&curve.weights).enumerate() {
                let (own, volume) = &response[index];
                let fraction = M::fraction(own, *volume, curve.drive.fraction);
                residuals.push(weights[0] * (off(index) - curve.since[index].map_or(0.0, off)));
                residuals.push(weights[1] * (fraction - row.fraction));
            }
        }
        Some(residuals)
    };
    let named = model.parameters();
    let mut parameters = named.map(|(_, parameter)| parameter);
    if let Some(start) = start {
        parameters.iter_mut().zip(start).for_each(|(parameter, start)| parameter.start = *start);
    }
    let found = least_squares(&parameters, residuals)?;
    let is_at_bound = |at: f64, of: &Parameter| (at - of.lower).min(of.upper - at) <= AT_BOUND * of.scale;
    let at_bound = (0..N).filter(|&i| is_at_bound(found[i], &parameters[i])).map(|i| named[i].0).collect();
    Some((found, at_bound))
}
