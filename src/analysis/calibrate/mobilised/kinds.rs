//! The kinds of tests that every packing goes through, and what is fitted of them.

use crate::analysis::calibrate::element::{Course, STRAIN_VOLUME_CONSTANT};
use crate::analysis::calibrate::path::Kept;

/// A kind of test, of every packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// How the packing is sheared.
    pub course: Course,
    /// Of the packing stress.
    pub share: f64,
    /// Made with the friction of the contacts.
    pub loose: bool,
    /// The others show the law where it was not fitted.
    pub fitted: bool,
}

/// In the order that they are done in; those that are fitted come first.
pub const KINDS: [Kind; 9] = {
    const fn of(course: Course, share: f64, loose: bool, fitted: bool) -> Kind {
        Kind { course, share, loose, fitted }
    }
    [
        of(Course::Once, 1.0, false, true),
        of(Course::Once, 0.5, false, true),
        of(Course::Once, 1.0, true, true),
        of(Course::Once, 0.5, true, true),
        of(Course::Reversal, 1.0, false, true),
        of(Course::Cycles, 1.0, false, true),
        of(Course::ConstantVolume, 1.0, false, false),
        of(Course::Once, 0.25, false, false),
        of(Course::Biaxial, 1.0, false, false),
    ]
};

/// Of loose packings under the packing stress, sheared once.
pub const LOOSE: usize = 2;

impl Kind {
    /// For a table.
    pub fn words(&self) -> String {
        let made = if self.loose { "loose" } else { "dense" };
        let stress = match (4.0 * self.share) as u32 {
            4 => "packing stress",
            2 => "half of the stress",
            _ => "a quarter of the stress",
        };
        match self.course {
            Course::Once => format!("shear, {made}, {stress}"),
            Course::Reversal => "reversal".to_string(),
            Course::Cycles => "small cycles".to_string(),
            Course::ConstantVolume => "constant volume".to_string(),
            Course::Biaxial => "biaxial".to_string(),
        }
    }

    /// Strain at the end; of the shear tests that are fitted what is wanted, while what is shown beyond needs the beginning.
    pub fn strain(&self, wanted: f64) -> f64 {
        if self.fitted { wanted } else { wanted.min(STRAIN_VOLUME_CONSTANT) }
    }

    /// What stays on the way, for the law that is driven along it.
    pub fn kept(&self) -> Kept {
        match self.course {
            Course::ConstantVolume => Kept::Volume,
            Course::Biaxial => Kept::LateralStress,
            Course::Once | Course::Reversal | Course::Cycles => Kept::NormalStress,
        }
    }

    /// Whether only unloading is compared, from each turn on.
    pub fn unloads(&self) -> bool {
        matches!(self.course, Course::Reversal | Course::Cycles)
    }
}
