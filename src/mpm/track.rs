//! Where a point has been: its displacement at a few instants, thinned as time goes on, so that training can repeat the
//! continuum's path and not only its end.

use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};

/// Looks that a point remembers.
pub const LOOKS: usize = 10;

/// Plastic strain of a point at the last looks of an oracle; slot `look % LOOKS`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Window {
    /// Accumulated plastic strain, by slot; 0 where no look has been taken yet.
    pub samples: [f64; LOOKS],
}

/// Instants that a track keeps.
pub const INSTANTS: usize = 8;

/// Displacement since the start at the instants of [`Instants`], m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track<S: Space> {
    /// By instant, periods that were crossed counted; those beyond the instants taken count for nothing.
    pub displacements: [S::Vector; INSTANTS],
}

impl<S: Space> Default for Track<S> {
    fn default() -> Self {
        Self { displacements: [S::Vector::zero(); INSTANTS] }
    }
}

const NAMES: [&str; INSTANTS] =
    ["track_0", "track_1", "track_2", "track_3", "track_4", "track_5", "track_6", "track_7"];

impl<S: Space> Record for Track<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        for (name, displacement) in NAMES.into_iter().zip(&mut self.displacements) {
            visitor.f64s(name, displacement.as_mut_slice());
        }
    }
}

impl<S: Space> Track<S> {
    /// Drops every second instant, in step with [`Instants::thin`].
    pub fn thin(&mut self) {
        for kept in 0..INSTANTS / 2 {
            self.displacements[kept] = self.displacements[2 * kept + 1];
        }
    }
}

/// When the tracks were taken; the same on every rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instants {
    /// Seconds, rising.
    pub times: Vec<f64>,
    /// Steps between two instants.
    pub every: u64,
}

impl Instants {
    /// Drops every second instant and doubles the spacing.
    pub fn thin(&mut self) {
        self.times = self.times.iter().copied().skip(1).step_by(2).collect();
        self.every *= 2;
    }

    /// Whether all of [`INSTANTS`] are taken: they are thinned before the next.
    pub fn full(&self) -> bool {
        self.times.len() == INSTANTS
    }
}
