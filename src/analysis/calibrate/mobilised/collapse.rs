//! Packings whose stress was lost while it was to be kept: loose ones that collapse contract faster than the cell follows, and their curves there are not those of
//! the stress that the law is driven at.

use super::{Calibration, KINDS, Specimen};
use crate::analysis::calibrate::element::Row;
use crate::analysis::calibrate::path::Kept;
use crate::job::significant;

/// A stress that is below this share of what is to be kept is lost.
const LOST: f64 = 0.9;

/// The worst row of a test that lost its stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collapse {
    pub seed: u64,
    /// Whether grains cohere as in the job; those that do are tested without cohesion too.
    pub coheres: bool,
    /// Which of [`KINDS`].
    pub kind: usize,
    /// Of the stress to be kept.
    pub share: f64,
    pub strain: f64,
}

impl Collapse {
    pub fn words(&self) -> String {
        let percent = |share: f64| significant(100.0 * share, 2);
        format!(
            "the packing of seed {}{} collapsed: {} % of the stress that is kept, at {} % of strain",
            self.seed,
            if self.coheres { "" } else { ", without cohesion," },
            percent(self.share),
            percent(self.strain)
        )
    }
}

impl Calibration {
    /// Of the packings that are fitted and of those that are held back, test by test.
    pub fn collapses(&self) -> Vec<Collapse> {
        let all = || self.fitted.iter().chain(&self.held);
        let of_tests = |one: &Specimen, kind: usize| {
            [(&one.tests, true), (&one.dry, false)].map(|(tests, coheres)| {
                let (share, strain) = lost(&tests.get(kind)?.rows, kind, self.stress)?;
                Some(Collapse { seed: one.seed, coheres, kind, share, strain })
            })
        };
        (0..KINDS.len()).flat_map(|kind| all().flat_map(move |one| of_tests(one, kind)).flatten()).collect()
    }
}

/// Share of the stress to be kept and strain where it is least, if it is lost.
fn lost(rows: &[Row], kind: usize, stress: f64) -> Option<(f64, f64)> {
    let component = match KINDS[kind].kept() {
        Kept::NormalStress => 2,
        Kept::LateralStress => 0,
        Kept::Volume => return None,
    };
    let share = |stress_kept: f64| -stress_kept / (KINDS[kind].share * stress);
    let rows = rows.iter().map(|row| (share(row.stress[component]), row.strain));
    rows.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share < LOST)
}
