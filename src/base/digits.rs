//! Numbers as sentences have them.

/// A number for a sentence, without the noise of binary fractions.
pub fn digits(value: f64) -> String {
    significant(value, 10)
}

/// Ten digits, never less than the value, so that a least value copied from a message is enough.
pub fn digits_above(value: f64) -> String {
    let rounded = format!("{value:.9e}");
    if rounded.parse().is_ok_and(|rounded: f64| rounded >= value) {
        return digits(value);
    }
    let (_, exponent) = rounded.split_once('e').expect("scientific notation has an e");
    let last: f64 = format!("0.000000001e{exponent}").parse().expect("a power of ten parses");
    digits(value + last)
}

/// Three digits, cut and not rounded, so that a limit copied from a message is within the limit.
pub fn digits_below(value: f64) -> String {
    let exact = format!("{value:.16e}");
    let (mantissa, exponent) = exact.split_once('e').expect("scientific notation has an e");
    let cut: f64 = format!("{}e{exponent}", &mantissa[..4]).parse().expect("a shortened number parses");
    significant(cut, 3)
}

/// At most `count` digits, trailing zeros dropped.
pub fn significant(value: f64, count: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", count - 1).parse().expect("a formatted number parses");
    match (1e-3..1e7).contains(&rounded.abs()) || rounded == 0.0 {
        true => format!("{rounded}"),
        false => format!("{rounded:e}"),
    }
}
