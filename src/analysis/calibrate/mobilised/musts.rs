//! What the law must come to, and what it was found to: bounds written before any test was run.

use super::quality::quality;
use super::{Calibration, Shown};
use crate::analysis::calibrate::element::Course;
use crate::job::significant;

/// Of tests that are fitted: root mean square off in shear stress over normal stress to 5 % of strain, and volume strain.
const RATIO_FITTED: f64 = 0.012;
const VOLUME_FITTED: f64 = 1e-3;
/// Of tests, or packings, that are not: sine of the mobilised angle to 3 % of strain, and volume strain.
const SINE_HELD: f64 = 0.02;
const VOLUME_HELD: f64 = 1.5e-3;
/// Of constant volume, for each 400 kPa of packing stress: shear stress and mean stress, Pa.
const CONSTANT_VOLUME: [f64; 2] = [40e3, 60e3];
const STRESS_CONSTANT_VOLUME: f64 = 400e3;

/// One bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Must {
    /// The kind of test, for a table.
    pub test: String,
    /// What is bounded.
    pub words: &'static str,
    /// The bound with its unit: the most, or an interval.
    pub must: String,
    /// What the law came to, in the same unit.
    pub found: String,
    /// Whether that is no more than the bound, or inside of the interval.
    pub is_met: bool,
    /// Of packings held back: what the mean of those that are fitted is off their mean, which a law would find that follows the fitted ones
    /// without an error.
    pub of_packings: Option<String>,
}

/// Heads the column of what the fitted packings are off.
pub const FITTED_PACKINGS: &str = "fitted packings";

/// Whether one of them is of packings held back, and so has [`Must::of_packings`].
pub fn has_packings(musts: &[Must]) -> bool {
    musts.iter().any(|must| must.of_packings.is_some())
}

/// The mean of the packings that are fitted in the place of the law; none where one test is longer than the other.
fn packings_as_law(held: &Shown, fitted: &Shown) -> Option<Shown> {
    let rows = &fitted.curve.rows;
    (rows.len() == held.curve.rows.len()).then(|| {
        let law: Vec<_> = rows.iter().map(|row| (*row, rows[0].fraction / row.fraction)).collect();
        Shown { quality: quality(&held.curve, &law), law, ..held.clone() }
    })
}

/// Of the packings that are fitted, tests that are fitted and those that are not; then of the packings held back, all tests.
pub fn musts(calibration: &Calibration) -> Vec<(&'static str, Vec<Must>)> {
    let of = |is_fitted: bool| -> Vec<Must> {
        let shown = calibration.shown.iter().filter(|shown| shown.kind.fitted == is_fitted);
        shown.flat_map(|shown| of_test(shown, calibration.stress, is_fitted)).collect()
    };
    let (shown, held) = (&calibration.shown, &calibration.shown_held);
    let of_held = |held: &Shown| {
        let mut musts = of_test(held, calibration.stress, false);
        let fitted = shown.iter().find(|shown| shown.kind == held.kind);
        if let Some(packings) = fitted.and_then(|fitted| packings_as_law(held, fitted)) {
            let others = of_test(&packings, calibration.stress, false);
            musts.iter_mut().zip(others).for_each(|(must, other)| must.of_packings = Some(other.found));
        }
        musts
    };
    [
        ("Musts: tests that are fitted", of(true)),
        ("Musts: tests that are not fitted, of the same packings", of(false)),
        ("Musts: packings held back", held.iter().flat_map(of_held).collect()),
    ]
    .into_iter()
    .filter(|(_, musts)| !musts.is_empty())
    .collect()
}

fn of_test(shown: &Shown, stress: f64, is_fitted: bool) -> Vec<Must> {
    let (quality, kind) = (&shown.quality, &shown.kind);
    let test = kind.words();
    let at_most = |words, found: f64, most: f64, told: fn(f64) -> String| Must {
        test: test.clone(),
        words,
        must: told(most),
        found: told(found),
        is_met: found <= most,
        of_packings: None,
    };
    let plain = |value: f64| significant(value, 3);
    let percent = |value: f64| format!("{} %", significant(100.0 * value, 2));
    let pressure = |value: f64| format!("{} kPa", significant(1e-3 * value, 3));
    let volume_end = (quality.volume_end[0] - quality.volume_end[1]).abs();
    match kind.course {
        Course::ConstantVolume => {
            let [shear, mean] = CONSTANT_VOLUME.map(|most| most * stress / STRESS_CONSTANT_VOLUME);
            vec![
                at_most("shear stress, largest off", quality.ratio_largest_all * stress, shear, pressure),
                at_most("mean stress, largest off", quality.pressure_largest * stress, mean, pressure),
            ]
        }
        // What unloading is held to is shown, and no bound.
        Course::Reversal | Course::Cycles => Vec::new(),
        Course::Once | Course::Biaxial if !is_fitted => vec![
            at_most("sine of the mobilised angle to 3 %, largest off", quality.sine_largest, SINE_HELD, plain),
            at_most("volume strain to 3 %, largest off", quality.volume_largest_beginning, VOLUME_HELD, percent),
            at_most("volume strain at the end, off", volume_end, VOLUME_HELD, percent),
        ],
        Course::Once | Course::Biaxial => {
            let [from, to] = quality.plateau;
            let at = quality.peak[1][1];
            let peak = Must {
                test: test.clone(),
                words: "strain of the peak, inside the plateau",
                must: format!("{} to {}", percent(from), percent(to)),
                found: percent(at),
                is_met: (from..=to).contains(&at),
                of_packings: None,
            };
            let off = quality.ratio_off[0].unwrap_or(0.0);
            let mut musts = vec![at_most("rms off, to 5 %", off, RATIO_FITTED, plain)];
            // Loose packings have none.
            musts.extend((!kind.loose).then_some(peak));
            musts.push(at_most("volume strain to 5 %, largest off", quality.volume_largest[0], VOLUME_FITTED, percent));
            musts.push(at_most("volume strain at the end, off", volume_end, VOLUME_FITTED, percent));
            musts
        }
    }
}
