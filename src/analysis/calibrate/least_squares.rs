//! Nonlinear least squares by Levenberg and Marquardt, for few parameters within bounds. Sums run in the order of the
//! residuals, so that a fit has the same bits everywhere.
//!
//! ```text
//! minimise |r(x)|^2:  (J^T J + damping diag(J^T J)) dx = -J^T r,  J by differences
//! ```

use nalgebra::{SMatrix, SVector};

const ROUNDS_MAX: usize = 200;
/// Of the first step, and what a step that helps, or does not, changes it by.
const DAMPING_FIRST: f64 = 1e-3;
const DAMPING_LESS: f64 = 0.2;
const DAMPING_MORE: f64 = 5.0;
const DAMPING_MAX: f64 = 1e12;
/// Of the differences, as a share of a parameter's scale.
const DIFFERENCE: f64 = 1e-5;
/// The sum of squares must fall by this share for a round to be worth another.
const PROGRESS: f64 = 1e-10;

/// A parameter: where it starts, its bounds, and what is a little of it.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    pub start: f64,
    pub lower: f64,
    pub upper: f64,
    pub scale: f64,
}

/// The parameters of the least sum of squares near the start; none where the residuals of the start are no numbers.
/// `residuals` gives none where a model fails, and such places are not gone to.
pub fn least_squares<const N: usize>(
    parameters: &[Parameter; N],
    residuals: impl Fn(&[f64; N]) -> Option<Vec<f64>>,
) -> Option<[f64; N]> {
    let good = |at: &[f64; N]| residuals(at).filter(|found| found.iter().all(|residual| residual.is_finite()));
    let mut at = parameters.map(|parameter| parameter.start.clamp(parameter.lower, parameter.upper));
    let mut found = good(&at)?;
    let mut sum = square(&found);
    let mut damping = DAMPING_FIRST;
    for _ in 0..ROUNDS_MAX {
        let mut columns = Vec::with_capacity(N);
        for index in 0..N {
            columns.push(slope(parameters, &at, index, &found, &good));
        }
        let mut normal = SMatrix::<f64, N, N>::identity();
        let mut right = SVector::<f64, N>::zeros();
        let downhill: [f64; N] = std::array::from_fn(|i| -product(&columns[i], &found));
        // What is at a bound and would go beyond stays.
        let free = |i: usize| match downhill[i] > 0.0 {
            true => at[i] < parameters[i].upper,
            false => at[i] > parameters[i].lower,
        };
        for i in (0..N).filter(|i| free(*i)) {
            right[i] = downhill[i];
            for j in (0..N).filter(|j| free(*j)) {
                normal[(i, j)] = product(&columns[i], &columns[j]);
            }
        }
        let before = sum;
        while damping < DAMPING_MAX {
            let mut damped = normal;
            for i in 0..N {
                // A parameter that nothing hangs on stays where it is.
                damped[(i, i)] += damping * normal[(i, i)] + f64::MIN_POSITIVE;
            }
            let step = damped.cholesky().map_or_else(SVector::zeros, |factors| factors.solve(&right));
            let mut next = at;
            for i in 0..N {
                next[i] = (at[i] + parameters[i].scale * step[i]).clamp(parameters[i].lower, parameters[i].upper);
            }
            match good(&next) {
                Some(better) if square(&better) < sum => {
                    (at, sum) = (next, square(&better));
                    found = better;
                    damping *= DAMPING_LESS;
                    break;
                }
                _ => damping *= DAMPING_MORE,
            }
        }
        if before - sum <= PROGRESS * before {
            break;
        }
    }
    Some(at)
}

/// Derivatives of all residuals by one parameter, over its scale, from a side that lies within the bounds; zero where the model
/// fails on either, so that the parameter stays where it is.
fn slope<const N: usize>(
    parameters: &[Parameter; N],
    at: &[f64; N],
    index: usize,
    found: &[f64],
    good: &impl Fn(&[f64; N]) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let Parameter { lower, upper, scale, .. } = parameters[index];
    let side = |sign: f64| {
        let mut moved = *at;
        moved[index] += sign * DIFFERENCE * scale;
        let there = if (lower..=upper).contains(&moved[index]) { good(&moved)? } else { return None };
        Some(there.iter().zip(found).map(|(there, here)| (there - here) / (sign * DIFFERENCE)).collect())
    };
    [1.0, -1.0].into_iter().find_map(side).unwrap_or_else(|| vec![0.0; found.len()])
}

fn square(numbers: &[f64]) -> f64 {
    product(numbers, numbers)
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley, whose least is at (1, 1), and the same with a bound in the way.
    #[test]
    fn finds_the_end_of_a_curved_valley() {
        let parameter = |start, upper| Parameter { start, lower: -5.0, upper, scale: 1.0 };
        let valley = |at: &[f64; 2]| Some(vec![10.0 * (at[1] - at[0] * at[0]), 1.0 - at[0]]);
        let found = least_squares(&[parameter(-1.2, 5.0), parameter(1.0, 5.0)], valley).unwrap();
        assert!((found[0] - 1.0).abs() < 1e-6 && (found[1] - 1.0).abs() < 1e-6, "{found:?}");
        let found = least_squares(&[parameter(-1.2, 0.5), parameter(1.0, 5.0)], valley).unwrap();
        assert!((found[0] - 0.5).abs() < 1e-6 && (found[1] - 0.25).abs() < 1e-6, "{found:?}");
    }

    /// The second parameter cannot be moved at all; the first is found none the less.
    #[test]
    fn a_model_that_fails_around_a_parameter_keeps_it() {
        let parameter = |start| Parameter { start, lower: 0.0, upper: 5.0, scale: 1.0 };
        let narrow = |at: &[f64; 2]| (at[1] == 2.0).then(|| vec![at[0] - 3.0, at[1]]);
        let found = least_squares(&[parameter(1.0), parameter(2.0)], narrow).unwrap();
        assert!((found[0] - 3.0).abs() < 1e-6 && found[1] == 2.0, "{found:?}");
    }

    #[test]
    fn nothing_is_asked_beyond_the_bounds() {
        let parameter = |start| Parameter { start, lower: 0.0, upper: 1.0, scale: 1.0 };
        // Fails inside of the upper bound and at once above the lower one.
        let model = |at: &[f64; 2]| {
            assert!(at.iter().all(|at| (0.0..=1.0).contains(at)), "{at:?}");
            (at[0] == 0.0 && at[1] == 1.0).then(|| vec![at[0] - 0.5, at[1] - 0.5])
        };
        assert_eq!(least_squares(&[parameter(0.0), parameter(1.0)], model), Some([0.0, 1.0]));
    }

    #[test]
    fn a_model_that_fails_at_the_start_has_no_fit() {
        let parameter = Parameter { start: 1.0, lower: 0.0, upper: 2.0, scale: 1.0 };
        assert_eq!(least_squares(&[parameter], |_| None), None);
        assert_eq!(least_squares(&[parameter], |at| Some(vec![f64::NAN * at[0]])), None);
    }
}
