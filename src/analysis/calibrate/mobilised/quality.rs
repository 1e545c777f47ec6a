//! How the law follows a mean curve of grains.

use super::THIRDS;
use crate::analysis::calibrate::element::Row;
use crate::analysis::calibrate::fit::{pressure, sine};
use crate::analysis::calibrate::model::Curve;
use crate::base::math;

/// Strain over which the mean curve is averaged to see its peak.
pub const STRAIN_SMOOTH: f64 = 0.004;
/// The plateau is where the mean curve is nearer to its peak than this share of it.
const PLATEAU: f64 = 0.02;
/// Strain to which tests that are not fitted are held.
pub const BEGINNING: f64 = 0.03;

/// Differences of the law and a mean curve. Means are over the strain that is gone through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Root mean square of the difference of the shear stress, over the normal stress, in each third of the test; none where
    /// the test does not come to it.
    pub ratio_off: [Option<f64>; 3],
    /// The largest in the first third, and in all of the test.
    pub ratio_largest: f64,
    /// The largest such difference in all of the test.
    pub ratio_largest_all: f64,
    /// The largest difference of the sine of the mobilised friction angle, and of the volume strain, to `BEGINNING`; the sines
    /// are averaged as for the peak.
    pub sine_largest: f64,
    /// The largest difference of the volume strain to `BEGINNING`.
    pub volume_largest_beginning: f64,
    /// The same of the mean stress over that of the start, over all of the test: what constant volume is about.
    pub pressure_off: f64,
    /// The largest difference of the mean stress in all of the test, over the mean stress of the start.
    pub pressure_largest: f64,
    /// Largest shear stress over normal stress and its strain, of the averaged mean curve and of the law.
    pub peak: [[f64; 2]; 2],
    /// The strains between which the averaged mean curve is within `PLATEAU` of its peak.
    pub plateau: [f64; 2],
    /// Volume strain at the end, of grains and law, dilation positive.
    pub volume_end: [f64; 2],
    /// Largest difference of the volume strains, in the first third and in all of the test.
    pub volume_largest: [f64; 2],
}

/// The law's `rows` have their volumes over that of the start.
pub fn quality(curve: &Curve, law: &[(Row, f64)]) -> Quality {
    let rows = &curve.rows;
    let ways: Vec<f64> = ways(rows);
    let ratios = |index: usize| curve.ratio(&law[index].0) - curve.ratio(&rows[index]);
    let pressures = |index: usize| (pressure(&law[index].0) - pressure(&rows[index])) / curve.drive.stress;
    let volume = |index: usize| math::ln(rows[0].fraction / rows[index].fraction);
    let volumes = |index: usize| (math::ln(law[index].1) - volume(index)).abs();
    let third = |index: usize| THIRDS.iter().filter(|end| rows[index].strain > **end).count();
    let mean = |of: &dyn Fn(usize) -> f64, part: Option<usize>| {
        let indices = (0..rows.len()).filter(|index| part.is_none_or(|part| third(*index) == part));
        let (sum, way) = indices
            .fold((0.0, 0.0), |(sum, way), index| (sum + ways[index] * of(index) * of(index), way + ways[index]));
        (way > 0.0).then(|| f64::sqrt(sum / way))
    };
    let most = |of: &dyn Fn(usize) -> f64, part: Option<usize>| {
        let indices = (0..rows.len()).filter(|index| part.is_none_or(|part| third(*index) == part));
        indices.map(|index| of(index).abs()).fold(0.0, f64::max)
    };
    let smooth = averaged(rows, |index| curve.ratio(&rows[index]));
    let begins = |index: &usize| rows[*index].strain <= BEGINNING * (1.0 + 1e-9);
    let [of_grains, of_model] =
        [averaged(rows, |index| sine(&rows[index])), averaged(rows, |index| sine(&law[index].0))];
    let sines = |index: usize| of_model[index][1] - of_grains[index][1];
    let highest = |curve: &[[f64; 2]]| {
        let [strain, most] = curve.iter().fold([0.0; 2], |most, at| if at[1] > most[1] { *at } else { most });
        [most, strain]
    };
    let of_law: Vec<[f64; 2]> = rows.iter().zip(law).map(|(row, (own, _))| [row.strain, curve.ratio(own)]).collect();
    let peak = [highest(&smooth), highest(&of_law)];
    Quality {
        ratio_off: [0, 1, 2].map(|part| mean(&ratios, Some(part))),
        ratio_largest: most(&ratios, Some(0)),
        ratio_largest_all: most(&ratios, None),
        sine_largest: (0..rows.len()).filter(begins).map(|index| (sines(index)).abs()).fold(0.0, f64::max),
        volume_largest_beginning: (0..rows.len()).filter(begins).map(volumes).fold(0.0, f64::max),
        pressure_off: mean(&pressures, None).unwrap_or(0.0),
        pressure_largest: most(&pressures, None),
        peak,
        plateau: plateau(&smooth, peak[0]),
        volume_end: [volume(rows.len() - 1), math::ln(law[rows.len() - 1].1)],
        volume_largest: [most(&volumes, Some(0)), most(&volumes, None)],
    }
}

/// The strain that each row stands for.
fn ways(rows: &[Row]) -> Vec<f64> {
    let step = |a: usize, b: usize| (rows[b].strain - rows[a].strain).abs();
    let last = rows.len() - 1;
    (0..=last).map(|index| 0.5 * (step(index.saturating_sub(1), index) + step(index, (index + 1).min(last)))).collect()
}

/// Strain and a value of rows, averaged over a stretch of strain around each row; shorter towards the ends.
pub fn averaged(rows: &[Row], value: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    let ways = ways(rows);
    let around = |index: usize| {
        let strain = rows[index].strain;
        let room = (strain - rows[0].strain).min(rows[rows.len() - 1].strain - strain);
        let reach = (0.5 * STRAIN_SMOOTH).min(room) * (1.0 + 1e-9);
        let near = |other: &usize| (rows[*other].strain - strain).abs() <= reach;
        let (sum, way) = (0..rows.len())
            .filter(near)
            .fold((0.0, 0.0), |(sum, way), other| (sum + ways[other] * value(other), way + ways[other]));
        if way > 0.0 { sum / way } else { value(index) }
    };
    (0..rows.len()).map(|index| [rows[index].strain, around(index)]).collect()
}

/// From the peak outwards, as far as no row in between is lower.
fn plateau(smooth: &[[f64; 2]], [most, strain]: [f64; 2]) -> [f64; 2] {
    let is_near = |at: &&[f64; 2]| at[1] >= (1.0 - PLATEAU) * most;
    let after = smooth.iter().filter(|at| at[0] >= strain).take_while(is_near).last();
    let before = smooth.iter().rev().filter(|at| at[0] <= strain).take_while(is_near).last();
    [before, after].map(|at| at.map_or(strain, |at| at[0]))
}
