//! Small worlds and short jobs that the tests build theirs from.

use std::sync::OnceLock;

use std::sync::Arc;

use scree::base::ids::GrainId;
use scree::base::space::{Plane, Space};
use scree::dem::assembly::Constants;
use scree::dem::grains::Mover;
use scree::dem::law::law_of;
use scree::domain::grid::Grid;
use scree::domain::layout::Layout;
use scree::domain::parts::Parts;
use scree::domain::world::Settings;
use scree::job::Scenario;
use scree::law::contact::{LinearSpringDashpot, NormalForce};
use scree::law::material::{ConstitutiveLaw, CriticalDruckerPrager};
use scree::mpm::penalty::{Coupling, Penalty};
use scree::mpm::points::Point;
use scree::prepare::sheared::{self, cell_of};
use scree_partition::{Solo, Transport};

pub type Vector = <Plane as Space>::Vector;
pub type Tensor = <Plane as Space>::Tensor;
pub type PlanarWorld<'t> = sheared::PlanarWorld<'t>;
pub type PlanarPoint = Point<Plane>;
pub type Grain = sheared::Grain;

/// Table 1 of Chen et al. (2021), with a damping to choose.
pub fn contact(damping: f64) -> LinearSpringDashpot {
    LinearSpringDashpot {
        stiffness_normal: 1_772_093.8,
        stiffness_tangential: 886_046.9,
        damping_normal: damping,
        damping_tangential: damping,
        friction: 0.5,
        normal_force: NormalForce::TENSILE,
    }
}

/// The continuum of the quickstart.
pub fn material() -> CriticalDruckerPrager {
    CriticalDruckerPrager {
        bulk_modulus: 100e6,
        shear_modulus: 60e6,
        friction_critical: scree::base::math::tan(0.27),
        fraction_critical: 0.815,
        dilation_factor: 11.0,
        dilation: 0.0,
        softening_rate: 3.0,
        cohesion: 0.0,
    }
}

/// A free grain, at rest.
pub fn grain(id: u64, position: [f64; 2], radius: f64, mass: f64) -> Grain {
    Grain::resting(GrainId(id), Vector::new(position[0], position[1]), radius, mass, Mover::Free)
}

/// Penalty springs of grains in [`settings`] that exchange with nodes after every so many steps of `dt`, s.
pub fn exchanging(interval: u64, dt: f64) -> Penalty {
    Coupling { interval, ..Coupling::DEFAULT }.in_steps(contact(0.0).stiffness_normal, dt)
}

pub fn settings(dt: f64, contact: LinearSpringDashpot) -> Settings<Plane> {
    Settings {
        grid: Grid { penalty: Coupling::DEFAULT.in_steps(contact.stiffness_normal, dt), ..Grid::blend(0.95) },
        material: Arc::new(material()),
        ..Settings::of_grains(Constants::new(dt, 2e-4, law_of(&contact.into())))
    }
}

/// A world without plates, 16 by 16 cells of `cell` m in blocks of 2, with y = 0 in the middle.
pub fn open_world<'t>(
    transport: &'t dyn Transport,
    cell: f64,
    settings: Settings<Plane>,
    grains: Vec<Grain>,
    points: Vec<PlanarPoint>,
) -> PlanarWorld<'t> {
    let layout = Layout::plane([16, 16], 2, cell, [0.0, -8.0 * cell]).unwrap();
    let cell = cell_of(&layout);
    PlanarWorld::new(settings, layout, transport, 0, Parts::fresh(grains, points, Vec::new(), cell)).unwrap()
}

/// Row of a grain that this rank owns.
pub fn row_of(world: &PlanarWorld, id: u64) -> usize {
    world.assembly.grains.cold[..world.assembly.grains.owned]
        .iter()
        .position(|cold| cold.id == GrainId(id))
        .expect("the grain is here")
}

/// Numbers that look random and are the same in every run (SplitMix64).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((word ^ (word >> 31)) >> 11) as f64 * 0.5f64.powi(52) - 1.0
    }
}

/// The quickstart cut down to some five hundred grains, with overrides of its own.
pub fn job(sets: &[&str]) -> Scenario {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| tempfile::Builder::new().prefix("scree-packings-").tempdir().unwrap());
    let cache = format!("packing.cache={}", folder.path().display());
    let sets = REDUCED.iter().chain(sets).map(|set| (*set).to_string()).chain([cache]).collect::<Vec<String>>();
    Scenario::parse(include_str!("../jobs/quickstart.toml"), "jobs/quickstart.toml", &sets)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The same with its packing in the cache: made by whoever asks first, for all tests with grains.
pub fn packed_job(sets: &[&str]) -> Scenario {
    static MADE: OnceLock<()> = OnceLock::new();
    MADE.get_or_init(|| {
        sheared::prepare(&job(&[]), &Solo).unwrap_or_else(|error| panic!("{error}"));
    });
    job(sets)
}

/// A job of planar shear whose material is that of a file of another law, which mobilises its friction by plastic shear.
pub fn mobilised(sets: &[&str]) -> Scenario {
    let text = packed_job(sets).to_toml();
    let (head, rest) = text.split_once("\n[material]\n").unwrap();
    let (_, tail) = rest.split_once("\n[continuum]\n").unwrap();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/materials/planar_shear_mobilised.toml");
    let text = format!("{head}\n[material]\nfile = \"{file}\"\n\n[continuum]\n{tail}");
    let scenario = Scenario::parse(&text, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(scenario.material.law, ConstitutiveLaw::MobilisedFriction(_)));
    assert_eq!(scenario.material.law.fraction(), None);
    scenario
}

/// Everything that the outcome of these tests hangs on, so that the quickstart itself may change.
const REDUCED: [&str; 23] = [
    "specimen.width=12 mm",
    "specimen.height=36 mm",
    "continuum.cell=3 mm",
    "material.bulk_modulus=100 MPa",
    "material.shear_modulus=60 MPa",
    "material.dilation_factor=11",
    "material.softening_rate=3",
    "continuum.weak.0.lower=[0.0, 0.015]",
    "continuum.weak.0.upper=[0.012, 0.021]",
    "continuum.weak.0.fraction_deficit=0.018",
    "loading.speed=10 cm/s",
    "loading.speed_ramp=1 ms",
    "oracle.criterion=laplacian",
    "oracle.laplacian=0.05",
    "oracle.recent_strain=2e-3",
    "oracle.window=8e-3",
    "oracle.persistence=8e-3",
    "enrichment.distance=6 mm",
    "enrichment.weight=0.5",
    "enrichment.training=1",
    "enrichment.training_speed=1",
    "time.step=0.4 us",
    "packing.energy_ratio_max=1e-3",
];
