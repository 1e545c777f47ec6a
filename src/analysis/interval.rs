//! The 95 % interval of a mean by Student's t.

use crate::analysis::curve::mean;

/// Two-sided 95 % quantiles of Student's t of 1, 2, ... 30 degrees of freedom (tables of any handbook of statistics).
const OF_FEW: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
    2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];
/// Of the normal distribution, and the first terms of the quantile in one over the degrees of freedom (Fisher & Cornish 1960).
const NORMAL: f64 = 1.959_964;
const FIRST: f64 = (NORMAL * NORMAL * NORMAL + NORMAL) / 4.0;
const SECOND: f64 = NORMAL * (5.0 * NORMAL * NORMAL * NORMAL * NORMAL + 16.0 * NORMAL * NORMAL + 3.0) / 96.0;
/// Beyond so many packings nobody goes.
const MOST: usize = 100_000;

/// The two-sided 95 % quantile of Student's t, to 0.001.
pub fn student(degrees: usize) -> f64 {
    let n = degrees as f64;
    OF_FEW.get(degrees.wrapping_sub(1)).copied().unwrap_or(NORMAL + FIRST / n + SECOND / (n * n))
}

/// Standard deviation of what a sample is of, by n - 1.
pub fn deviation_of_sample(values: &[f64]) -> f64 {
    let middle = mean(values);
    (values.iter().map(|value| (value - middle) * (value - middle)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
}

/// Half of the 95 % interval of a mean of `count` values, at least two.
pub fn half_width(deviation: f64, count: usize) -> f64 {
    student(count - 1) * deviation / (count as f64).sqrt()
}

/// The fewest values of that deviation whose mean has an interval of at most `half_width` to either side; none where no number of
/// them that anybody makes has.
pub fn packings_for(deviation: f64, wanted: f64) -> Option<usize> {
    if deviation == 0.0 {
        return Some(2);
    }
    // The interval narrows with the number, so that halving finds it.
    let is_enough = |count: usize| half_width(deviation, count) <= wanted;
    let (mut few, mut enough) = (1, MOST);
    if !is_enough(enough) {
        return None;
    }
    while enough - few > 1 {
        let middle = few + (enough - few) / 2;
        if is_enough(middle) { enough = middle } else { few = middle }
    }
    Some(enough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (degrees, wanted) in [(1, 12.706), (19, 2.093), (31, 2.040), (40, 2.021), (60, 2.000), (120, 1.980)] {
            assert!((student(degrees) - wanted).abs() < 1e-3, "{degrees}: {}", student(degrees));
        }
    }

    /// With a deviation of a tenth of the mean 18 packings are known to 5 %, and 17 are not.
    #[test]
    fn the_fewest_packings_are_found() {
        assert_eq!(packings_for(0.1, 0.05), Some(18));
        assert!(half_width(0.1, 17) > 0.05 && half_width(0.1, 18) <= 0.05);
        assert_eq!((packings_for(0.0, 0.05), packings_for(1.0, 1e-6)), (Some(2), None));
        assert_eq!(deviation_of_sample(&[1.0, 3.0]), f64::sqrt(2.0));
    }
}
