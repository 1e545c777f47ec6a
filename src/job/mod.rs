//! What is to be simulated, checked once and trusted afterwards (invariant 5).
//!
//! Two stages: [`raw`] is what the operator typed, positions and units included; [`Job`] is what it means, in SI units,
//! with every default filled in: a [`Scenario`] of planar shear, an [`Assembly`] of grains in a cell, or a continuum on a grid ([`Mpm`]). Nothing after this
//! module sees a string, an option or a sentinel.

pub(crate) mod document;

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::base::error::Error;
use crate::couple::oracle::Oracle;
use crate::couple::zone::Enrichment;
use crate::law::contact::Contact;
use crate::law::material::CriticalConstants;

pub mod assembly;
pub mod derived;
pub mod figures;
pub mod mpm;
pub mod raw;
mod resolve;
pub mod schema;
pub mod stable;
mod tree;
pub mod units;
mod write;

pub use crate::job::document::Job;
pub use assembly::Assembly;
pub use mpm::Mpm;
pub(crate) use resolve::{BLOCK_OF_DISCS, BYPASS, MATERIAL_KEYS, digits_below, margin_in_words, significant};

/// Which parts of the program are awake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Continuum first; grains where the oracle finds a persistent shear band (Chen et al. 2021).
    Hybrid,
    /// Grains alone: the ground truth.
    Dem,
    /// Continuum alone: the mesh-dependent baseline.
    Mpm,
}

impl Method {
    /// As it is written in a job.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Dem => "dem",
            Self::Mpm => "mpm",
        }
    }

    pub fn has_grains(self) -> bool {
        matches!(self, Self::Hybrid | Self::Dem)
    }

    pub fn has_points(self) -> bool {
        matches!(self, Self::Hybrid | Self::Mpm)
    }
}

/// The checked job. All quantities in SI units, angles in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Job name; the default run directory is `runs/<name>`.
    pub name: String,
    pub method: Method,
    /// Seed of every random number of the job.
    pub seed: u64,
    pub specimen: Specimen,
    pub grains: Grains,
    pub contact: Contact,
    pub packing: Packing,
    pub continuum: Continuum,
    pub loading: Loading,
    pub oracle: Oracle,
    pub enrichment: Enrichment,
    pub time: Time,
    pub decomposition: Decomposition,
    pub output: Output,
    /// An account of work and energy of the grains is kept, in columns of its own.
    pub ledger: bool,
}

impl Scenario {
    /// Reads a job of planar shear, lays the `key.path=value` overrides over it and checks the whole.
    pub fn load(path: &Path, sets: &[String]) -> Result<Self, Error> {
        Self::parse(&document::read(path)?, &path.display().to_string(), sets)
    }

    /// The same from text; `file` names it in messages, and relative paths in it start from its folder.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<Self, Error> {
        match Job::parse(text, file, sets)? {
            Job::Shear(scenario) => Ok(scenario),
            Job::Assembly(_) => Err(Error::User(format!(
                "{file}: this job is an assembly of grains, because it has a table [cell], and a job of planar shear is wanted here."
            ))),
            Job::Mpm(_) => Err(Error::User(format!(
                "{file}: this job is a continuum on a grid, because it has a table [grid], and a job of planar shear is wanted here."
            ))),
        }
    }

    /// Whether grains are simulated at any time: in the run itself, or to make the packing that a continuum starts from.
    pub fn moves_grains(&self) -> bool {
        self.method.has_grains() || self.continuum.fraction_start.is_none()
    }

    /// The job in SI numbers with nothing left to a default. It parses back to an equal scenario.
    pub fn to_toml(&self) -> String {
        write::shear(self)
    }
}

/// The box of material: periodic in x, between a lower and an upper plate in y.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// Period in x, m.
    pub width: f64,
    /// Distance of the plates' faces that the packing aims at, m; the packing's own height is what is used.
    pub height: f64,
    /// Out-of-plane depth of the 2D material, m.
    pub depth: f64,
}

/// Sizes and matter of the grains (Chen et al. 2021, Table 1).
#[derive(Clone, Debug, PartialEq)]
pub struct Grains {
    /// Mean diameter D50, m.
    pub diameter_mean: f64,
    /// Standard deviation of the normal distribution of diameters, m; cut at three deviations.
    pub diameter_deviation: f64,
    /// Density of the solid, kg/m3.
    pub density: f64,
    /// Grains read from a CSV file (`id,x,y,radius,vx,vy,spin`) instead of a generated packing.
    pub file: Option<PathBuf>,
}

/// How the packing is made: thrown loosely, compressed by the upper plate under low friction and without cohesion, left to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    /// Friction coefficient while the packing is made (Cundall 1989: 0.01).
    pub friction: f64,
    /// Packing fraction of the loose start, 0.2 to 0.5.
    pub fraction_start: f64,
    /// Normal stress that the packing is brought to, Pa.
    pub stress: f64,
    /// Height that the packing is drawn with, m, where that is not the specimen's: of a tall hybrid only the zone is made of it.
    pub height: Option<f64>,
    /// Compression ends when kinetic energy is below this share of elastic energy.
    pub energy_ratio_max: f64,
    /// Folder of finished packings, reused by key.
    pub cache: PathBuf,
}

/// Critical-state Drucker-Prager continuum on a background grid (Chen et al. 2021, 2.2).
#[derive(Clone, Debug, PartialEq)]
pub struct Continuum {
    /// K, Pa.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
    /// phi_cs, rad.
    pub friction_angle_critical: f64,
    /// Phi_cs.
    pub fraction_critical: f64,
    /// chi of tan(psi) = chi (Phi - Phi_cs).
    pub dilation_factor: f64,
    /// xi of dPhi/dt = -(Phi - Phi_cs) Phi xi |deps_p/dt|.
    pub softening_rate: f64,
    /// c, Pa.
    pub cohesion: f64,
    /// Packing fraction the material starts with; none: that of the packing.
    pub fraction_start: Option<f64>,
    /// Edge of a grid cell, m.
    pub cell: f64,
    /// Material points per cell and axis.
    pub points_per_cell: usize,
    /// Share of FLIP in the velocity update, 0 (PIC) to 1 (FLIP).
    pub flip: f64,
    /// Regions that start with another packing fraction, so that shear has a place to begin (Chen et al. 2021, 6.1).
    pub weak: Vec<WeakRegion>,
}

impl Continuum {
    /// Those of its law, at the critical packing fraction where the job has none for the start.
    pub fn constants(&self) -> CriticalConstants {
        CriticalConstants {
            bulk_modulus: self.bulk_modulus,
            shear_modulus: self.shear_modulus,
            friction_angle_critical: self.friction_angle_critical,
            fraction_critical: self.fraction_critical,
            fraction: self.fraction_start.unwrap_or(self.fraction_critical),
            dilation_factor: self.dilation_factor,
            softening_rate: self.softening_rate,
            cohesion: self.cohesion,
            dilation_angle: None,
        }
    }
}

/// A rectangle of points whose law starts from a lower packing fraction; mass is not changed.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakRegion {
    /// Lower left corner, m from the left edge and above the face of the lower plate.
    pub lower: [f64; 2],
    /// Upper right corner, m.
    pub upper: [f64; 2],
    /// Subtracted from the packing fraction there.
    pub fraction_deficit: f64,
}

/// Planar shear between rough plates.
#[derive(Clone, Debug, PartialEq)]
pub struct Loading {
    /// Normal stress the upper plate is held at, Pa (compression positive here).
    pub stress_normal: f64,
    /// Horizontal speed of the upper plate, m/s.
    pub speed: f64,
    /// The speed rises linearly from zero over this time, s.
    pub speed_ramp: f64,
    /// The run ends at this horizontal strain (plate displacement over specimen width).
    pub strain_end: f64,
    /// Mass of the upper plate, kg.
    pub plate_mass: f64,
    /// Viscous damping of the plate's vertical motion, N s/m.
    pub plate_damping: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Time step of grains, s.
    pub step: f64,
    /// Steps of grains in one of the continuum.
    pub grain_steps: u64,
}

/// How the domain is cut; results do not depend on it (invariant 2), except through `cells_per_block`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decomposition {
    /// Edge of a block in cells.
    pub cells_per_block: usize,
    /// Reach of the neighbour list beyond contact, m.
    pub skin: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Simulated time between rows of `series.csv`, s.
    pub series_interval: f64,
    /// Simulated time between frames of `frames.vtkhdf`, s.
    pub frame_interval: f64,
    /// Simulated time between checkpoints, s.
    pub checkpoint_interval: f64,
    /// Steps between checkpoints beside those; none where it is 0.
    pub checkpoint_steps: u64,
    /// Wall time between checkpoints at most, s.
    pub checkpoint_wall_interval: f64,
    /// Checkpoints kept.
    pub checkpoints_kept: usize,
    /// Every so many checkpoints one is kept for good; none where it is 0.
    pub checkpoints_for_good: usize,
    /// Whether `contacts.vtkhdf` is written with the frames.
    pub contact_frames: bool,
}

impl Output {
    /// Wall time between states that are saved, of a run and of its packing in the making.
    pub fn save_every(&self) -> Duration {
        Duration::try_from_secs_f64(self.checkpoint_wall_interval).unwrap_or(Duration::MAX)
    }
}
