//! The grains of a continuum's material, and where they take its place.

use crate::couple::zone::Enrichment;
use crate::job::Method;
use crate::job::assembly::Assembly;
use crate::job::figures;
use crate::job::mpm::Rves;
use crate::mpm::penalty::{Coupling, Penalty};

/// The grains of a material: what it is made of from the start, or where a band persists, or what a continuum alone stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Granular {
    /// What of the material is grains, and when.
    pub method: Method,
    /// A periodic piece of packing under the stress of the start; laid side by side it fills the regions, or stands at every point.
    pub piece: Assembly,
    /// Penalty springs of grains that share nodes with points or membranes.
    pub coupling: Coupling,
    /// How grains take the place of points around a band.
    pub enrichment: Enrichment,
    /// Where the grains of zones come from.
    pub reference: Origin,
    /// Where the material is a grain assembly at every point.
    pub rves: Rves,
    /// Bands that need no oracle.
    pub known: Option<KnownBands>,
    /// Points begin with the solid volume fraction that the specimen has around them, and not everywhere with one.
    pub is_heterogeneous: bool,
}

impl Granular {
    /// Penalty springs in steps of grains of `dt`, s.
    pub fn penalty(&self, dt: f64) -> Penalty {
        self.coupling.in_steps(figures::springs_mean(&self.piece).normal, dt)
    }

    /// The same where every step has an exchange, as while a specimen comes to rest.
    pub fn penalty_of_every_step(&self, dt: f64) -> Penalty {
        Coupling { interval: 1, ..self.coupling }.in_steps(figures::springs_mean(&self.piece).normal, dt)
    }

    /// Whether all of the specimen is grains at the start.
    pub fn begins_as_grains(&self) -> bool {
        self.method.begins_as_grains(&self.enrichment.life)
    }
}

/// Where the grains of a hybrid come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// All of the material as grains, which have equilibrated between bodies and membranes.
    Specimen,
    /// Pieces of packing side by side where a zone is made, and nowhere else.
    Piece,
}

impl Origin {
    /// As it is written in a job.
    pub fn name(self) -> &'static str {
        match self {
            Self::Specimen => "specimen",
            Self::Piece => "piece",
        }
    }
}

/// Shear bands that the job names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnownBands {
    /// When grains take the places of points around them, s.
    pub at: f64,
    /// Ends of straight parts, m.
    pub parts: Vec<[[f64; 2]; 2]>,
}
