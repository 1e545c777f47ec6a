//! Bounds of numbers.

/// Bounds of a number; an open bound is not itself allowed.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// In the SI unit of the number; minus infinity where there is no bound.
    pub min: f64,
    /// In the SI unit of the number; infinity where there is no bound.
    pub max: f64,
    /// Whether `min` itself is refused.
    pub min_open: bool,
    /// Whether `max` itself is refused.
    pub max_open: bool,
}

impl Range {
    /// Finite and more than 0.
    pub const POSITIVE: Self = Self::new(0.0, f64::INFINITY, true, true);
    /// Finite, 0 or more.
    pub const NOT_NEGATIVE: Self = Self::new(0.0, f64::INFINITY, false, true);
    /// Any finite number.
    pub const ANY: Self = Self::new(f64::NEG_INFINITY, f64::INFINITY, true, true);

    const fn new(min: f64, max: f64, min_open: bool, max_open: bool) -> Self {
        Self { min, max, min_open, max_open }
    }

    /// Both bounds are allowed.
    pub const fn closed(min: f64, max: f64) -> Self {
        Self::new(min, max, false, false)
    }

    /// Neither bound is allowed.
    pub const fn open(min: f64, max: f64) -> Self {
        Self::new(min, max, true, true)
    }

    /// The lower bound is allowed, the upper one is not.
    pub const fn below(min: f64, max: f64) -> Self {
        Self::new(min, max, false, true)
    }

    /// The upper bound is allowed, the lower one is not.
    pub const fn above(min: f64, max: f64) -> Self {
        Self::new(min, max, true, false)
    }

    /// Never true of NaN.
    pub fn contains(&self, value: f64) -> bool {
        let above = if self.min_open { value > self.min } else { value >= self.min };
        let below = if self.max_open { value < self.max } else { value <= self.max };
        above && below
    }

    /// For a sentence: `must be ...`.
    pub fn words(&self, unit: &str) -> String {
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        if self.max == f64::INFINITY {
            return match self.min_open {
                _ if self.min == f64::NEG_INFINITY => "finite".to_string(),
                true => format!("finite and more than {}{unit}", self.min),
                false => format!("finite and {}{unit} or more", self.min),
            };
        }
        let (min, max) = (round(self.min), round(self.max));
        match (self.min_open, self.max_open) {
            (true, true) => format!("between {min} and {max}{unit}, both excluded"),
            (true, false) => format!("more than {min} and at most {max}{unit}"),
            (false, true) => format!("{min}{unit} or more and less than {max}{unit}"),
            (false, false) => format!("between {min} and {max}{unit}"),
        }
    }
}

/// Bounds such as pi/2 need not be printed to the last digit.
fn round(value: f64) -> String {
    match value.abs() < 1e-3 && value != 0.0 {
        true => format!("{value:e}"),
        false => format!("{}", (value * 1e4).round() / 1e4),
    }
}
