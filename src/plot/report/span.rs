//! Across what a specimen is drawn and measured.

/// A piece of the x axis with the size of its grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// m.
    pub left: f64,
    /// m.
    pub width: f64,
    /// Its sides are joined.
    pub is_periodic: bool,
    /// Mean grain diameter D50, m.
    pub diameter: f64,
}

impl Span {
    /// m; zero where the sides are apart.
    pub fn period(&self) -> f64 {
        if self.is_periodic { self.width } else { 0.0 }
    }

    /// Whole spans by which what crosses a side may have to be moved to be seen.
    pub fn images(&self) -> &'static [f64] {
        if self.is_periodic { &[-1.0, 0.0, 1.0] } else { &[0.0] }
    }
}
