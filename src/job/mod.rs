//! What is to be simulated, checked once and trusted afterwards (invariant 5).
//!
//! Two stages: [`raw`] is what the operator typed, positions and units included; [`Job`] is what it means, in SI units,
//! with every default filled in: a [`Scenario`] of planar shear, an [`Assembly`] of grains in a cell, or a continuum on a grid ([`Mpm`]). Nothing after this
//! module sees a string, an option or a sentinel.

pub(crate) mod document;

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::base::error::Error;

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
pub(crate) use resolve::{BLOCK_OF_DISCS, BYPASS, MATERIAL_KEYS, digits_below, significant};

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

/// Sizes and matter of the grains (seed 000, Table 1).
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

/// The contact law with its constants; each law's file under `law/contact/` has its equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// `law = "linear"`.
    Linear(Linear),
    /// `law = "linear_cohesive"`.
    LinearCohesive(LinearCohesive),
    /// `law = "elastic_rolling"`.
    ElasticRolling(ElasticRolling),
    /// `law = "hertz_mindlin"`.
    HertzMindlin(HertzMindlin),
}

/// Linear spring-dashpot with tangential memory and Coulomb limit (Cundall & Strack 1979; seed 000, 2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// k_n, N/m.
    pub stiffness_normal: f64,
    /// k_t, N/m.
    pub stiffness_tangential: f64,
    /// gamma_n, N s/m; in a job either this or `restitution` of two mean grains.
    pub damping_normal: f64,
    /// gamma_t, N s/m.
    pub damping_tangential: f64,
    /// mu, the Coulomb coefficient.
    pub friction: f64,
    pub normal_force: NormalForce,
}

/// Which normal forces a spring and its dashpot may come to together. A dashpot slows a contact that opens and so may pull
/// at its end, which grains without cohesion do not (Schwager & Poeschel 2007); LAMMPS has the limit as `limit_damping`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalForce {
    /// N: a number in place of a name, so that laws limit forces without a branch.
    least: f64,
}

impl NormalForce {
    /// The force may turn tensile while a contact opens, as in the sources of the laws.
    pub const TENSILE: Self = Self { least: f64::NEG_INFINITY };
    /// The dashpot makes no tension: F_n = max(F_spring + F_dashpot, 0).
    pub const REPULSIVE: Self = Self { least: 0.0 };
    /// As jobs name them.
    pub const NAMES: [(&'static str, Self); 2] = [("tensile", Self::TENSILE), ("repulsive", Self::REPULSIVE)];

    /// The least normal force, N, repulsive positive: zero, or minus infinity.
    pub fn least(self) -> f64 {
        self.least
    }

    pub fn name(self) -> &'static str {
        let (name, _) = Self::NAMES.iter().find(|(_, of)| *of == self).expect("there are no others");
        name
    }
}

/// The same with cohesion (seed 000, 2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearCohesive {
    pub linear: Linear,
    /// e_n, N: a contact made once holds until k_n d < -e_n.
    pub cohesion_normal: f64,
    /// e_t, N: |F_t| <= mu |F_n| + e_t.
    pub cohesion_tangential: f64,
}

impl LinearCohesive {
    /// How far apart surfaces that have touched still hold on to each other, m: e_n/k_n.
    pub fn reach(&self) -> f64 {
        self.cohesion_normal / self.linear.stiffness_normal
    }
}

/// Stiffness from Young's modulus by harmonic means, rolling resistance (seed 002, eq. 20 to 28); no dashpot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticRolling {
    /// E, Pa.
    pub young_modulus: f64,
    /// Stiffness ratio k_t/k_n, which the paper calls nu.
    pub stiffness_ratio: f64,
    pub friction: f64,
    /// beta: k_r = beta k_t r_i r_j; zero: grains roll freely.
    pub rolling_stiffness: f64,
    /// eta: |M| <= eta min(r_i, r_j) F_n.
    pub rolling_limit: f64,
    /// What slides: the surfaces as they are, or with the translational part scaled by (r_i + r_j)/(r_i + r_j - d).
    pub sliding: Sliding,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sliding {
    #[default]
    Surface,
    Scaled,
}

/// Hertz normal force, incremental Mindlin tangential force (seed 001, eq. 53 to 56).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzMindlin {
    /// G_g, Pa.
    pub shear_modulus: f64,
    /// nu.
    pub poisson_ratio: f64,
    pub friction: f64,
    /// Viscosity of contacts, N s/m.
    pub damping_normal: f64,
    pub damping_tangential: f64,
    /// zeta: dashpots of 2 sqrt(5/6) zeta sqrt(m k_n) beside those, both ways, with the effective mass m. In a job either this or
    /// the `restitution` that it gives at every speed.
    pub damping_ratio: f64,
    pub normal_force: NormalForce,
}

impl Contact {
    /// The law as jobs name it.
    pub fn law(&self) -> &'static str {
        match self {
            Self::Linear(_) => "linear",
            Self::LinearCohesive(_) => "linear_cohesive",
            Self::ElasticRolling(_) => "elastic_rolling",
            Self::HertzMindlin(_) => "hertz_mindlin",
        }
    }

    /// How far apart surfaces may be and still hold on to each other, m.
    pub fn reach(&self) -> f64 {
        match self {
            Self::LinearCohesive(law) => law.reach(),
            Self::Linear(_) | Self::ElasticRolling(_) | Self::HertzMindlin(_) => 0.0,
        }
    }

    /// What lists reach beyond the grains themselves, as messages call it.
    pub fn margin_in_words(&self) -> &'static str {
        if self.reach() > 0.0 { "the skin with the reach of cohesion" } else { "the skin" }
    }

    /// Which normal forces its dashpot leaves; a law without one never pulls.
    pub fn normal_force(&self) -> NormalForce {
        match self {
            Self::Linear(law) => law.normal_force,
            Self::LinearCohesive(law) => law.linear.normal_force,
            Self::ElasticRolling(_) => NormalForce::REPULSIVE,
            Self::HertzMindlin(law) => law.normal_force,
        }
    }

    /// mu.
    pub fn friction(&self) -> f64 {
        match self {
            Self::Linear(law) => law.friction,
            Self::LinearCohesive(law) => law.linear.friction,
            Self::ElasticRolling(law) => law.friction,
            Self::HertzMindlin(law) => law.friction,
        }
    }

    /// The same law with another friction coefficient.
    pub fn with_friction(mut self, friction: f64) -> Self {
        match &mut self {
            Self::Linear(law) => law.friction = friction,
            Self::LinearCohesive(law) => law.linear.friction = friction,
            Self::ElasticRolling(law) => law.friction = friction,
            Self::HertzMindlin(law) => law.friction = friction,
        }
        self
    }

    /// The same law between grains that do not cohere.
    pub fn without_cohesion(mut self) -> Self {
        if let Self::LinearCohesive(law) = &mut self {
            (law.cohesion_normal, law.cohesion_tangential) = (0.0, 0.0);
        }
        self
    }

    /// The law while grains are compressed to a packing: with that packing's friction, and without cohesion, which would hold
    /// them where they were thrown. Whatever touches at the end coheres from the first step of the run on.
    pub fn while_compressed(self, friction: f64) -> Self {
        self.with_friction(friction).without_cohesion()
    }
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

/// Critical-state Drucker-Prager continuum on a background grid (seed 000, 2.2).
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
    /// Regions that start with another packing fraction, so that shear has a place to begin (seed 000, 6.1).
    pub weak: Vec<WeakRegion>,
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

/// Shear band detection (seed 000, section 3, Algorithm 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oracle {
    /// c_0: threshold of the Laplacian.
    pub laplacian: f64,
    /// c_1: plastic strain within the recent window.
    pub recent_strain: f64,
    /// c_l: length of the recent window in strain of the fastest point.
    pub window: f64,
    /// c_g: strain of the fastest point over which the flagged set must stay as it is.
    pub persistence: f64,
    /// Share of the flagged set that may have come and gone from one look to the next without its having changed; 0 in the seed.
    pub tolerance: f64,
    /// Steps between two looks.
    pub every: u64,
}

/// Grains for points (seed 000, section 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enrichment {
    /// phi_0, m.
    pub distance: f64,
    /// w of the reconciliation zone: the grains' share.
    pub weight: f64,
    /// Share of the continuum's motion that the packing is trained with, 0 to 1.
    pub training: f64,
    /// Training runs this many times faster than the motion it repeats.
    pub training_speed: f64,
    /// Rest after training with the rim held, in multiples of the training's own duration.
    pub training_rest: f64,
    pub life: ZoneLife,
}

/// What becomes of a zone once it is there; the seed's, which leave it as it is, are the defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneLife {
    /// Whether it grows where the oracle finds a band beyond it.
    pub grows: bool,
    /// Whether its grains turn back into points where they have come to rest.
    pub dissolves: bool,
    /// Shear strain of the cell that shears most over which rest is judged.
    pub rest_strain: f64,
    /// Share of that strain below which a cell rests.
    pub rest_share: f64,
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
