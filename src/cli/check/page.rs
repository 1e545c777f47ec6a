//! Lines with aligned columns, and numbers short enough for them.

use std::fmt::Write;

use crate::base::keys::{Form, Wants};
use crate::job::stable::{Bound, governing};
use crate::job::{Output, listed};
use crate::observe::contact_frame::BYTES_PER_LINE;
use crate::observe::frame::BYTES_PER_ROW;

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
                (Wants::Number(dimension, _), Ok(number)) => format!("{} {}", figures(number), dimension.unit()),
                _ => value.trim_matches('"').to_string(),
            };
            self.row(key.name, shown.trim_end(), key.about);
        }
    }

    /// What frames and contacts will take on disk, of a run of so many seconds with so many rows and, among them, grains.
    pub fn pictures(&mut self, output: &Output, duration: f64, [rows, grains]: [f64; 2], axes: usize) {
        let frames = 1.0 + (duration / output.frame_interval).ceil();
        let size = |bytes: f64| format!("{} of {} MB", whole(frames), figures(1e-6 * bytes));
        self.row("frames", &size(rows * BYTES_PER_ROW as f64), "each at most; they are compressed");
        if output.contact_frames {
            // Frictional packings bear their load with about four contacts a disc and six a sphere, each of two grains.
            let lines = axes as f64 * grains;
            let note = format!("each, with {axes} contacts a grain; they are compressed");
            self.row("frames of contacts", &size(lines * BYTES_PER_LINE as f64), &note);
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
