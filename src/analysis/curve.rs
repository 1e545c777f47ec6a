//! Curves of a series: values between rows, moving averages, their spread over packings, and how far two are from each other.

use serde::Serialize;

/// Rows in a moving average (the window of Chen et al. 2021, figures 12 and 23), and rows that two curves must share to be compared.
pub const WINDOW: usize = 8;

/// Not a number of no values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation.
pub fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values);
    (values.iter().map(|value| (value - middle) * (value - middle)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Least and most; none of nothing.
pub fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.map(|value| [value, value]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

/// Values of rows at a time, s: linear between them, held beyond them; before the first they rise from zero at the start, for rows
/// begin one interval after it.
pub fn from_zero(times: &[f64], values: &[f64], time: f64) -> f64 {
    let first = times[0];
    linear(times, values, time).unwrap_or_else(|| match time < first {
        true if first > 0.0 => values[0] * (time / first).max(0.0),
        true => values[0],
        false => values[values.len() - 1],
    })
}

/// Where a value lies among rising ones: the first row that is not below it, and its share of the way there from the row
/// before; none beyond the ends.
pub fn between(rising: &[f64], at: f64) -> Option<(usize, f64)> {
    let after = rising.partition_point(|&row| row < at);
    let to = *rising.get(after)?;
    if to == at {
        return Some((after, 1.0));
    }
    let from = rising[after.checked_sub(1)?];
    Some((after, (at - from) / (to - from)))
}

/// Values at rising places, linear between them; none beyond them.
pub fn linear(places: &[f64], values: &[f64], at: f64) -> Option<f64> {
    let (after, share) = between(places, at)?;
    match after.checked_sub(1).filter(|_| share < 1.0) {
        Some(before) => Some(values[before] + share * (values[after] - values[before])),
        None => Some(values[after]),
    }
}

/// Moving average over `window` rows, shorter at the ends and at row `cut`, which starts anew.
pub fn smooth(values: &[f64], cut: Option<usize>, window: usize) -> Vec<f64> {
    let (before, after) = values.split_at(cut.unwrap_or(values.len()));
    let of_piece = |piece: &[f64]| -> Vec<f64> {
        let over = |row: usize| row.saturating_sub(window / 2)..(row + window - window / 2).min(piece.len());
        (0..piece.len()).map(|row| mean(&piece[over(row)])).collect()
    };
    [of_piece(before), of_piece(after)].concat()
}

/// Row of the largest value.
pub fn highest(values: &[f64]) -> usize {
    (0..values.len()).reduce(|best, row| if values[row] > values[best] { row } else { best }).unwrap_or(0)
}

/// The time of [`WINDOW`] rows where rows are farthest apart, s, and how many rows it has in each run; of their rows' times.
pub fn windows(times: &[&[f64]]) -> (f64, Vec<usize>) {
    let interval = |time: &&[f64]| (time[time.len() - 1] - time[0]) / (time.len() - 1).max(1) as f64;
    let longest = times.iter().map(interval).fold(0.0, f64::max);
    let rows = |time: &&[f64]| match interval(time) {
        own if own > 0.0 => ((WINDOW as f64 * longest / own).round() as usize).max(1),
        _ => WINDOW,
    };
    (WINDOW as f64 * longest, times.iter().map(rows).collect())
}

/// Moving average of a stress against strain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Averaged {
    /// Row by row; rising where values between rows are asked for.
    pub strain: Vec<f64>,
    /// Pa.
    pub stress: Vec<f64>,
    /// First row after the enrichment, which the average does not look across.
    pub cut: Option<usize>,
}

impl Averaged {
    /// Over so many rows, which do not reach across the row `cut`.
    pub fn of(strain: &[f64], stress: &[f64], cut: Option<usize>, rows: usize) -> Self {
        Self { strain: strain.to_vec(), stress: smooth(stress, cut, rows), cut }
    }

    /// Linear between rows; none beyond them.
    pub fn at(&self, strain: f64) -> Option<f64> {
        linear(&self.strain, &self.stress, strain)
    }

    /// Of the last row; zero where there is none.
    pub fn strain_end(&self) -> f64 {
        self.strain.last().copied().unwrap_or(0.0)
    }
}

/// Mean, least and most of several curves, at the strains of the first as far as all of them reach.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spread {
    /// At the strains of the first curve, as far as all reach; it has no cut.
    pub mean: Averaged,
    /// Pa, row by row of the mean.
    pub least: Vec<f64>,
    /// Pa, row by row of the mean.
    pub most: Vec<f64>,
}

impl Spread {
    /// Panics where there are no curves.
    pub fn of(curves: &[&Averaged]) -> Self {
        let mut spread = Self::default();
        for &strain in &curves[0].strain {
            let values: Vec<f64> = curves.iter().filter_map(|curve| curve.at(strain)).collect();
            if values.len() == curves.len() {
                let [least, most] = range(values.iter().copied()).unwrap_or_default();
                spread.mean.strain.push(strain);
                spread.mean.stress.push(mean(&values));
                spread.least.push(least);
                spread.most.push(most);
            }
        }
        spread
    }
}

/// How far a curve is from another one over an interval of strain: mean of the other one, Pa, and as shares of that the mean and
/// the root-mean-square difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Of the first row compared.
    pub from_strain: f64,
    /// Of the last row compared.
    pub to_strain: f64,
    /// Pa, over the rows compared.
    pub mean_reference_pa: f64,
    /// Curve less reference, over `mean_reference_pa`.
    pub mean_difference: f64,
    /// The same in the root mean square, over its magnitude.
    pub rms_difference: f64,
}

impl Difference {
    /// Compares at the reference's rows between two strains, no farther than both go.
    pub fn of(curve: &Averaged, reference: &Averaged, [from, to]: [f64; 2]) -> Option<Self> {
        let rows = reference.strain.iter().zip(&reference.stress).filter(|(strain, _)| (from..=to).contains(*strain));
        let pairs: Vec<(f64, f64, f64)> =
            rows.filter_map(|(&strain, &other)| Some((strain, curve.at(strain)?, other))).collect();
        if pairs.len() < WINDOW {
            return None;
        }
        let of = |pick: fn(f64, f64) -> f64| -> f64 {
            mean(&pairs.iter().map(|&(_, own, other)| pick(own, other)).collect::<Vec<_>>())
        };
        let level = of(|_, other| other);
        let (difference, square) = (of(|own, other| own - other), of(|own, other| (own - other) * (own - other)));
        (level != 0.0).then(|| Self {
            from_strain: pairs[0].0,
            to_strain: pairs[pairs.len() - 1].0,
            mean_reference_pa: level,
            mean_difference: difference / level,
            rms_difference: square.sqrt() / level.abs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_run_from_zero_between_rows_and_stay_at_the_end() {
        let at = |time: f64| (from_zero(&[0.1, 0.2, 0.4], &[0.01, 0.02, 0.06], time) * 1e6).round() / 1e6;
        assert_eq!([at(0.0), at(0.05), at(0.1), at(0.3), at(0.4), at(9.0)], [0.0, 0.005, 0.01, 0.04, 0.06, 0.06]);
    }

    #[test]
    fn the_average_does_not_look_across_the_cut() {
        let values = [vec![1.0; 20], vec![5.0; 20]].concat();
        assert_eq!(smooth(&values, Some(20), WINDOW), values);
        let blurred = smooth(&values, None, WINDOW);
        assert!(blurred[20] > 1.0 && blurred[20] < 5.0);
        assert_eq!((blurred[0], blurred[39]), (1.0, 5.0));
    }
}
