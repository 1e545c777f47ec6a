//! Lines with aligned columns, and numbers short enough for them.

use std::fmt::Write;

use crate::base::keys::{Form, Wants};
use crate::base::math::PI;
use crate::base::units::Dimension;
use crate::job::listed;
use crate::job::stable::{Bound, governing};

/// Lines with aligned columns.
pub struct Page(pub String);

impl Page {
    pub fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    pub fn section(&mut self, title: &str) {
        self.line(&format!("\n{title}"));
    }

    pub fn row(&mut self, label: &str, value: &str, note: &str) {
        let mut line = String::new();
        write!(line, "  {label:<30} {value:<28}").expect("a string takes every write");
        if !note.is_empty() {
            line.push_str("  ");
            line.push_str(note);
        }
        self.line(line.trim_end());
    }

    /// What keys say, each in a row with what it means.
    pub fn keys(&mut self, axes: usize, visit: impl FnOnce(&mut dyn Form)) {
        for (key, value) in listed(axes, visit) {
            let shown = match (&key.wants, value.parse::<f64>()) {
                (Wants::Number(dimension, _), Ok(number)) => quantity(number, *dimension),
                _ => value.trim_matches('"').to_string(),
            };
            self.row(key.name, shown.trim_end(), key.about);
        }
    }

    /// The tightest bound first, then all of them with their causes.
    pub fn bounds(&mut self, label: &str, bounds: &[Bound]) {
        let governing = governing(bounds);
        self.row(label, &format!("{} s", figures(governing.step)), governing.cause);
        if bounds.len() == 1 {
            return;
        }
        for bound in bounds.iter().filter(|bound| bound.step.is_finite()) {
            let mark = if bound == governing { "governs: " } else { "" };
            self.row("", &format!("  {} s", figures(bound.step)), &format!("{mark}{}, {}", bound.cause, bound.formula));
        }
    }
}

pub fn megapascals(bulk: f64, shear: f64) -> String {
    format!("{} and {} MPa", figures(1e-6 * bulk), figures(1e-6 * shear))
}

/// `1 x 2 x 3`, of some axes.
pub fn times(axes: usize, of: impl Fn(usize) -> String) -> String {
    (0..axes).map(of).collect::<Vec<_>>().join(" x ")
}

/// `1, 2, 3`.
pub fn components(vector: &[f64]) -> String {
    vector.iter().map(|component| figures(*component)).collect::<Vec<_>>().join(", ")
}

/// A number with the unit that the page has for its like.
fn quantity(number: f64, dimension: Dimension) -> String {
    let (scale, unit) = match dimension {
        of if of == Dimension::LENGTH => (1e3, "mm".to_string()),
        of if of == Dimension::ANGLE => (180.0 / PI, "deg".to_string()),
        of if of == Dimension::STRESS && number.abs() >= 1e6 => (1e-6, "MPa".to_string()),
        of if of == Dimension::STRESS => (1e-3, "kPa".to_string()),
        of => (1.0, of.unit()),
    };
    format!("{} {unit}", figures(scale * number))
}

/// Three significant digits.
pub fn figures(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().expect("a formatted number parses");
    match rounded.abs() {
        0.0 => "0".to_string(),
        size if (1e4..1e12).contains(&size) => whole(rounded),
        size if (1e-2..1e4).contains(&size) => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// A whole number with its thousands apart.
pub fn whole(value: f64) -> String {
    let digits = format!("{value:.0}");
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) && !grouped.ends_with('-') {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(figures(0.012_345), "0.0123");
        assert_eq!(figures(1_772_093.8), "1,770,000");
        assert_eq!(figures(4.477e-7), "4.48e-7");
        assert_eq!(whole(4_281_250.0), "4,281,250");
        assert_eq!(whole(999.0), "999");
    }
}
