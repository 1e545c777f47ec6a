//! Numbers in words: digits, units, true minus signs, thin spaces.

use super::svg::shortened;

/// A thin space between number and unit.
pub const THIN: &str = "\u{2009}";
pub const D50: &str = "D\u{2085}\u{2080}";

/// The power of ten at or below a positive value.
pub fn exponent(value: f64) -> i32 {
    let text = format!("{value:e}");
    text.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

/// Ten to `power`, to the last bit.
pub fn power_of_ten(power: i32) -> f64 {
    format!("1e{power}").parse().expect("a power of ten is a number")
}

/// `10` with a raised exponent.
pub fn power_label(power: i32) -> String {
    let plain = power.to_string();
    let raised = plain.chars().map(|letter| match letter {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    });
    format!("10{}", raised.collect::<String>())
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten.
pub fn round_up(value: f64) -> f64 {
    if value <= 1e-12 {
        return 1e-3;
    }
    let decade = power_of_ten(exponent(value));
    let factor = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0].into_iter().find(|factor| factor * decade >= value);
    factor.unwrap_or(10.0) * decade
}

/// A number in words fit for a sentence: `digits` significant ones.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "\u{2013}".to_owned() };
    }
    let power = exponent(value.abs());
    if !(-4..6).contains(&power) {
        let text = format!("{value:.*e}", digits.saturating_sub(1));
        let (mantissa, _) = text.split_once('e').expect("scientific notation has an exponent");
        let power = exponent(text.parse::<f64>().expect("a number").abs());
        return minus(format!("{}\u{2009}\u{d7}\u{2009}{}", shortened(mantissa.to_owned()), power_label(power)));
    }
    let decimals = usize::try_from(digits as i32 - 1 - power).unwrap_or(0);
    minus(format!("{value:.decimals$}"))
}

/// With a true minus sign.
fn minus(text: String) -> String {
    text.replace('-', "\u{2212}")
}

/// A number with up to `digits` significant ones, zeros at the end left away.
pub fn plain(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    if text.contains('\u{d7}') { text } else { shortened(text) }
}

/// To a tenth: more is not known of a thickness.
pub fn tenths(value: f64) -> String {
    plain((10.0 * value).round() / 10.0, 3)
}

/// A share in percent with the decimals that three digits need; what would show as less than 0.001 % is nothing.
pub fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let text = if value.abs() < 5e-4 { "0".to_owned() } else { shortened(significant(value, 3)) };
    format!("{text}{THIN}%")
}

/// The same with the sign of what is more.
pub fn change(share: f64) -> String {
    format!("{}{}", if share > 0.0 { "+" } else { "" }, percent(share))
}

/// The change from `before` in whole percent.
pub fn relative(value: f64, before: f64) -> String {
    if before == 0.0 {
        return "from zero".to_owned();
    }
    let change = format!("{:+.0}", 100.0 * (value / before - 1.0));
    format!("{}{THIN}%", if change == "-0" { "+0".to_owned() } else { minus(change) })
}

pub fn interval([from, to]: [f64; 2]) -> String {
    format!("{} to {}", percent(from), percent(to))
}

pub fn kilopascal(stress: f64) -> String {
    format!("{}{THIN}kPa", significant(stress / 1e3, 3))
}

/// Whole degrees.
pub fn degrees(angle: f64) -> String {
    minus(format!("{angle:.0}\u{b0}"))
}

pub fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" => number.to_owned(),
        "\u{b0}" => format!("{number}{unit}"),
        _ => format!("{number}{THIN}{unit}"),
    }
}

/// A unit of time for what lasts so many seconds, and its length, s.
pub fn unit_of_time(seconds: f64) -> (&'static str, f64) {
    match seconds {
        seconds if seconds >= 0.1 || seconds == 0.0 => ("s", 1.0),
        seconds if seconds >= 1e-4 => ("ms", 1e-3),
        _ => ("\u{b5}s", 1e-6),
    }
}

/// A time with the unit that makes it short.
pub fn time(seconds: f64) -> String {
    let (unit, length) = unit_of_time(seconds);
    format!("{}{THIN}{unit}", significant(seconds / length, 3))
}

/// As terminals show it best: plain spaces and digits.
pub fn plain_letters(text: &str) -> String {
    text.replace(THIN, " ").replace(D50, "D50").replace('\u{2212}', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(significant(123.456, 3), "123");
        assert_eq!(significant(0.012345, 3), "0.0123");
        assert_eq!(significant(-2.0, 3), "\u{2212}2.00");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(3.2e-7, 2), "3.2\u{2009}\u{d7}\u{2009}10\u{207b}\u{2077}");
        assert_eq!([percent(0.1), percent(0.03499), percent(1e-9)], ["10\u{2009}%", "3.5\u{2009}%", "0\u{2009}%"]);
        assert_eq!(power_label(-13), "10\u{207b}\u{b9}\u{b3}");
    }

    #[test]
    fn changes_are_told_in_percent() {
        let told = [125.0, 85.0, 99.9].map(|value| relative(value, 100.0));
        assert_eq!(told, ["+25\u{2009}%", "\u{2212}15\u{2009}%", "+0\u{2009}%"]);
        assert_eq!(change(-0.0123), "\u{2212}1.23\u{2009}%");
    }

    #[test]
    fn colours_end_at_a_round_value() {
        for (value, round) in [(0.0, 1e-3), (0.13, 0.15), (0.2, 0.2), (0.21, 0.3), (9.0, 10.0), (0.0017, 0.002)] {
            assert!((round_up(value) - round).abs() < 1e-12, "{value}: {}", round_up(value));
        }
    }
}
