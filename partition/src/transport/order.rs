//! Doubles as integers in the same order, so that a maximum over ranks is exact and settled for NaN
//! and signed zeros.

/// Above every number.
const NAN_KEY: i64 = i64::MAX;

/// Replaces `values` by their maximum over ranks, given the maximum of integers over ranks.
pub(super) fn max(values: &mut [f64], max_integer: impl FnOnce(&mut [i64])) {
    let mut keys: Vec<i64> = values.iter().map(|&value| to_key(value)).collect();
    max_integer(&mut keys);
    for (value, key) in values.iter_mut().zip(keys) {
        *value = from_key(key);
    }
}

fn to_key(value: f64) -> i64 {
    if value.is_nan() { NAN_KEY } else { flipped(value.to_bits() as i64) }
}

fn from_key(key: i64) -> f64 {
    if key == NAN_KEY { f64::NAN } else { f64::from_bits(flipped(key) as u64) }
}

/// The bits of a double order like integers but for the negative ones, whose magnitude counts
/// backwards. Its own inverse.
fn flipped(bits: i64) -> i64 {
    if bits < 0 { bits ^ i64::MAX } else { bits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_keep_the_order_and_the_bits() {
        let rising =
            [f64::NEG_INFINITY, f64::MIN, -1.0, -5e-324, -0.0, 0.0, 5e-324, 1.0, f64::MAX, f64::INFINITY, f64::NAN];
        assert!(rising.windows(2).all(|pair| to_key(pair[0]) < to_key(pair[1])));
        assert!(rising.iter().all(|value| from_key(to_key(*value)).to_bits() == value.to_bits()));
        assert_eq!(to_key(-f64::NAN), NAN_KEY);
    }
}
