//! Whether a continuum is as strong and as stiff as the grains that may take its place: both in simple shear, under the stress that the
//! grains are packed under, and from the solid volume fraction that the job gives the continuum, else that of the packings.
//!
//! A continuum that is stronger shears where its grains are and nowhere else, so that the place of a band is no result; around one
//! that is weaker grains stand still.

use rayon::prelude::*;

use crate::analysis::calibrate::Subject;
use crate::analysis::calibrate::element::{Course, Element, Packing, Row, Test};
use crate::analysis::calibrate::fit::friction;
use crate::analysis::calibrate::path::{Drive, response};
use crate::base::error::Error;
use crate::job::Job;

/// Packings, with the job's seed and those after it, and grains of each.
pub const PACKINGS: u64 = 8;
/// Grains of each packing.
pub const GRAINS: u64 = 400;
/// Shear strains that strength is a mean between, and at which stiffness is told.
pub const STRENGTH: [f64; 2] = [0.02, 0.05];
/// Shear strain at which stiffness is told.
pub const STIFFNESS: f64 = 1e-3;

/// Kinetic over elastic energy of the packings at rest, at most: they are not looked at below [`STIFFNESS`].
const ENERGY_RATIO_MOST: f64 = 1e-3;

/// What a shear test tells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheared {
    /// Mean of tau/sigma_n between the strains of [`STRENGTH`].
    pub strength: f64,
    /// tau over the shear strain at [`STIFFNESS`], Pa.
    pub stiffness: f64,
}

impl Sheared {
    /// None of rows that do not reach the strains.
    fn of(rows: &[Row]) -> Option<Self> {
        let plateau: Vec<f64> = rows.iter().filter(|row| in_plateau(row.strain)).map(friction).collect();
        let away = |row: &Row| (row.strain - STIFFNESS).abs();
        let early = rows.iter().min_by(|a, b| away(a).total_cmp(&away(b))).filter(|row| away(row) < 0.1 * STIFFNESS)?;
        (!plateau.is_empty()).then(|| Self {
            strength: plateau.iter().sum::<f64>() / plateau.len() as f64,
            stiffness: early.stress[1] / early.strain,
        })
    }
}

fn in_plateau(strain: f64) -> bool {
    (STRENGTH[0]..=STRENGTH[1] * (1.0 + 1e-6)).contains(&strain)
}

/// A continuum beside its grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthComparison {
    /// The law, on the path of the tests.
    pub continuum: Sheared,
    /// Mean of the packings, and the standard error of that mean.
    pub grains: Sheared,
    /// Standard error of the mean of the packings.
    pub error: Sheared,
}

/// Tests the grains of a hybrid, and its law on the same path; none of jobs without a continuum that yields beside grains, and why
/// grains cannot be tested where they cannot.
pub fn compared(job: &Job) -> Result<Option<StrengthComparison>, Error> {
    let Some(continuum) = job.continuum().filter(|continuum| continuum.material.law.yields()) else { return Ok(None) };
    let subject = Subject::of(job, job.name(), true)?;
    let test = |seed: u64| {
        let element = Element {
            subject: &subject,
            contact: subject.piece.contact,
            test: Test::Sheared { course: Course::Once, strain: STRENGTH[1] },
            grains: GRAINS,
            seed: subject.piece.seed + seed,
            packing: Packing { stress: subject.stress, friction: None, energy_ratio_most: ENERGY_RATIO_MOST },
        };
        element.measure()
    };
    let tests = (0..PACKINGS).into_par_iter().map(test).collect::<Result<Vec<_>, _>>()?;
    let count = tests.len() as f64;
    let law = &continuum.material.law;
    let of_packings = tests.iter().map(|rows| rows[0].fraction).sum::<f64>() / count;
    // Where the packing is to tell it, what a law has is an assumption.
    let told = law.fraction().filter(|_| !job.is_told_by_packing());
    let drive = Drive::shear(subject.axes(), subject.stress, told.unwrap_or(of_packings));
    let strains: Vec<f64> = tests[0].iter().map(|row| row.strain).collect();
    let Some(rows) = response(law, drive, &strains) else { return Ok(None) };
    let rows: Vec<Row> = rows.into_iter().map(|(row, _)| row).collect();
    let Some(continuum) = Sheared::of(&rows) else { return Ok(None) };
    let Some(grains) = tests.iter().map(|rows| Sheared::of(rows)).collect::<Option<Vec<_>>>() else { return Ok(None) };
    let told = |of: fn(&Sheared) -> f64| {
        let mean = grains.iter().map(of).sum::<f64>() / count;
        let square: f64 = grains.iter().map(|one| (of(one) - mean) * (of(one) - mean)).sum();
        [mean, (square / (count * (count - 1.0))).sqrt()]
    };
    let [strength, stiffness] = [told(|one| one.strength), told(|one| one.stiffness)];
    let [grains, error] = [0, 1].map(|which| Sheared { strength: strength[which], stiffness: stiffness[which] });
    Ok(Some(StrengthComparison { continuum, grains, error }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strength_is_a_mean_and_stiffness_a_secant() {
        let row = |strain: f64, shear: f64| Row { strain, stress: [-1.0, shear, -2.0], pressure: 1.5, fraction: 0.8 };
        // The row nearest to 0.1 %, whatever side it is on.
        let rows =
            [row(0.0, 0.0), row(9.9996e-4, 0.5), row(1.1e-3, 0.9), row(0.02, 1.0), row(0.05, 0.8), row(0.06, 9.0)];
        let found = Sheared::of(&rows).unwrap();
        assert!((found.strength - 0.45).abs() < 1e-12 && (found.stiffness / 500.02 - 1.0).abs() < 1e-6, "{found:?}");
        assert_eq!(Sheared::of(&rows[..3]), None);
        assert_eq!(Sheared::of(&[row(2e-3, 1.0), row(0.03, 1.0)]), None);
    }
}
