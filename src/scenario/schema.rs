//! Every table and key of a job: what it means, what it may be, and an example to copy into an error message.

use super::Method;
use super::units::Dimension;

/// A `[table]` of the job, or the job's top level when `name` is empty.
pub struct Table {
    pub name: &'static str,
    pub about: &'static str,
    /// The methods that cannot run without it.
    pub needed_by: &'static [Method],
    pub keys: &'static [Key],
}

pub struct Key {
    pub name: &'static str,
    pub about: &'static str,
    /// As it would be typed right of the equals sign.
    pub example: &'static str,
    pub wants: Wants,
}

#[derive(Clone, Copy)]
pub enum Wants {
    Text,
    /// A whole number between two bounds, both allowed.
    Count(u64, u64),
    Number(Dimension, Range),
    /// Two lengths.
    Corner,
    /// Tables with the keys of [`WEAK`].
    Regions,
}

/// Bounds of a number; an open bound is not itself allowed.
#[derive(Clone, Copy)]
pub struct Range {
    min: f64,
    max: f64,
    min_open: bool,
    max_open: bool,
}

impl Range {
    const POSITIVE: Self = Self::new(0.0, f64::INFINITY, true, true);
    const NOT_NEGATIVE: Self = Self::new(0.0, f64::INFINITY, false, true);

    const fn new(min: f64, max: f64, min_open: bool, max_open: bool) -> Self {
        Self { min, max, min_open, max_open }
    }

    const fn closed(min: f64, max: f64) -> Self {
        Self::new(min, max, false, false)
    }

    const fn open(min: f64, max: f64) -> Self {
        Self::new(min, max, true, true)
    }

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
                true => format!("finite and more than {}{unit}", self.min),
                false => format!("finite and {}{unit} or more", self.min),
            };
        }
        let (min, max) = (self.min, round(self.max));
        match (self.min_open, self.max_open) {
            (true, true) => format!("between {min} and {max}{unit}, both excluded"),
            (true, false) => format!("more than {min} and at most {max}{unit}"),
            _ => format!("between {min} and {max}{unit}"),
        }
    }
}

/// Bounds such as pi/2 need not be printed to the last digit.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

const fn text(name: &'static str, about: &'static str, example: &'static str) -> Key {
    Key { name, about, example, wants: Wants::Text }
}

const fn count(name: &'static str, about: &'static str, (min, max): (u64, u64), example: &'static str) -> Key {
    Key { name, about, example, wants: Wants::Count(min, max) }
}

const fn number(
    name: &'static str,
    about: &'static str,
    dimension: Dimension,
    range: Range,
    example: &'static str,
) -> Key {
    Key { name, about, example, wants: Wants::Number(dimension, range) }
}

const ALL: &[Method] = &[Method::Hybrid, Method::Dem, Method::Mpm];
const WITH_GRAINS: &[Method] = &[Method::Hybrid, Method::Dem];
const WITH_POINTS: &[Method] = &[Method::Hybrid, Method::Mpm];
const HYBRID: &[Method] = &[Method::Hybrid];

const RATIO: Dimension = Dimension::RATIO;
const LENGTH: Dimension = Dimension::LENGTH;
const TIME: Dimension = Dimension::TIME;
const STRESS: Dimension = Dimension::STRESS;
const STIFFNESS: Dimension = Dimension::STIFFNESS;
const DAMPING: Dimension = Dimension::DAMPING;
const POSITIVE: Range = Range::POSITIVE;
const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;

/// The job's top level, then its tables in the order they are written in.
#[rustfmt::skip]
pub const TABLES: [Table; 12] = [
    Table { name: "", about: "the job itself", needed_by: ALL, keys: &[
        text("name", "the job's name, also that of its run directory", "\"planar_shear\""),
        text("method", "which parts of the program are awake", "\"hybrid\""),
        count("seed", "the seed of every random number", (0, i64::MAX as u64), "1"),
    ] },
    Table { name: "specimen", about: "the box of material", needed_by: ALL, keys: &[
        number("width", "the period in x", LENGTH, POSITIVE, "\"6 cm\""),
        number("height", "the distance of the plates", LENGTH, POSITIVE, "\"12 cm\""),
        number("depth", "the out-of-plane depth", LENGTH, POSITIVE, "\"1 cm\""),
    ] },
    Table { name: "grains", about: "sizes and matter of the grains", needed_by: ALL, keys: &[
        number("diameter_mean", "the mean diameter D50", LENGTH, POSITIVE, "\"1 mm\""),
        number("diameter_deviation", "the standard deviation of diameters", LENGTH, NOT_NEGATIVE, "\"0.08 mm\""),
        number("density", "the density of the solid", Dimension::DENSITY, POSITIVE, "\"2530 kg/m3\""),
        text("file", "grains to start from, as a CSV file", "\"grains.csv\""),
    ] },
    Table { name: "contact", about: "forces between grains", needed_by: WITH_GRAINS, keys: &[
        number("stiffness_normal", "k_n", STIFFNESS, POSITIVE, "\"1772 kN/m\""),
        number("stiffness_tangential", "k_t", STIFFNESS, NOT_NEGATIVE, "\"886 kN/m\""),
        number("damping_normal", "gamma_n", DAMPING, NOT_NEGATIVE, "\"3.5 N s/m\""),
        number("damping_tangential", "gamma_t", DAMPING, NOT_NEGATIVE, "\"3.5 N s/m\""),
        number("friction", "mu, the Coulomb coefficient", RATIO, Range::closed(0.0, 5.0), "0.5"),
    ] },
    Table { name: "packing", about: "how the packing is made", needed_by: &[], keys: &[
        number("friction", "friction while the packing is made", RATIO, Range::closed(0.0, 5.0), "0.01"),
        number("fraction_start", "the packing fraction of the loose start", RATIO, Range::closed(0.2, 0.5), "0.45"),
        number("stress", "the normal stress of the packing", STRESS, POSITIVE, "\"400 kPa\""),
        number("energy_ratio_max", "kinetic over elastic energy at rest", RATIO, Range::new(0.0, 0.1, true, false), "1e-4"),
        text("cache", "the folder of finished packings", "\"cache\""),
    ] },
    Table { name: "continuum", about: "the continuum and its grid", needed_by: WITH_POINTS, keys: &[
        number("bulk_modulus", "K", STRESS, POSITIVE, "\"630 MPa\""),
        number("shear_modulus", "G", STRESS, POSITIVE, "\"460 MPa\""),
        number("friction_angle_critical", "phi_cs", Dimension::ANGLE, Range::open(0.0, std::f64::consts::FRAC_PI_2), "\"15.5 deg\""),
        number("fraction_critical", "Phi_cs", RATIO, Range::closed(0.4, 0.95), "0.815"),
        number("dilation_factor", "chi", RATIO, Range::closed(0.0, 100.0), "7.0"),
        number("softening_rate", "xi", RATIO, Range::closed(0.0, 1000.0), "0.01"),
        number("cohesion", "c", STRESS, NOT_NEGATIVE, "0.0"),
        number("fraction_start", "the packing fraction at the start", RATIO, Range::closed(0.4, 0.95), "0.855"),
        number("cell", "the edge of a grid cell", LENGTH, POSITIVE, "\"7.5 mm\""),
        count("points_per_cell", "material points per cell and axis", (1, 8), "2"),
        number("flip", "the share of FLIP", RATIO, Range::closed(0.0, 1.0), "0.95"),
        Key { name: "weak", about: "regions that start looser", example: "[]", wants: Wants::Regions },
    ] },
    Table { name: "loading", about: "what is done to the specimen", needed_by: ALL, keys: &[
        number("stress_normal", "the normal stress on the upper plate", STRESS, POSITIVE, "\"400 kPa\""),
        number("speed", "the horizontal speed of the upper plate", Dimension::SPEED, POSITIVE, "\"2 cm/s\""),
        number("speed_ramp", "the time over which the speed rises", TIME, NOT_NEGATIVE, "\"1 ms\""),
        number("strain_end", "the horizontal strain that the run ends at", RATIO, Range::new(0.0, 100.0, true, false), "0.57"),
        number("plate_mass", "the mass of the upper plate", Dimension::MASS, POSITIVE, "\"15 g\""),
        number("plate_damping", "damping of the plate's vertical motion", DAMPING, NOT_NEGATIVE, "\"1000 N s/m\""),
    ] },
    Table { name: "oracle", about: "shear band detection", needed_by: HYBRID, keys: &[
        number("laplacian", "c_0", RATIO, POSITIVE, "1e-6"),
        number("recent_strain", "c_1", RATIO, NOT_NEGATIVE, "1e-4"),
        number("window", "c_l", RATIO, POSITIVE, "8e-4"),
        number("persistence", "c_g", RATIO, POSITIVE, "1.2e-3"),
        count("every", "steps between two looks", (1, 1_000_000_000), "50"),
    ] },
    Table { name: "enrichment", about: "grains for points", needed_by: HYBRID, keys: &[
        number("distance", "phi_0", LENGTH, POSITIVE, "\"2.2 cm\""),
        number("weight", "w, the grains' share in the rim", RATIO, Range::open(0.0, 1.0), "0.5"),
        number("training", "the share of the motion trained", RATIO, Range::closed(0.0, 1.0), "1.0"),
        number("training_speed", "how much faster training runs", RATIO, Range::new(0.0, 1e6, true, false), "10.0"),
        number("training_rest", "rest after training", RATIO, NOT_NEGATIVE, "0.5"),
    ] },
    Table { name: "time", about: "the time step", needed_by: ALL, keys: &[
        number("step", "the time step", TIME, POSITIVE, "\"0.4 us\""),
    ] },
    Table { name: "decomposition", about: "how the domain is cut", needed_by: &[], keys: &[
        count("cells_per_block", "the edge of a block in cells", (2, 64), "2"),
        number("skin", "the reach of the neighbour list beyond contact", LENGTH, POSITIVE, "\"0.1 mm\""),
    ] },
    Table { name: "output", about: "what is written and when", needed_by: &[], keys: &[
        number("series_interval", "time between rows of series.csv", TIME, POSITIVE, "\"3 ms\""),
        number("frame_interval", "time between frames", TIME, POSITIVE, "\"80 ms\""),
        number("checkpoint_interval", "time between checkpoints", TIME, POSITIVE, "\"0.2 s\""),
        count("checkpoints_kept", "checkpoints kept", (1, 1_000_000), "2"),
    ] },
];

/// One `[[continuum.weak]]`.
#[rustfmt::skip]
pub const WEAK: Table = Table { name: "continuum.weak", about: "a region that starts looser", needed_by: &[], keys: &[
    Key { name: "lower", about: "the lower left corner", example: "[\"0 cm\", \"5 cm\"]", wants: Wants::Corner },
    Key { name: "upper", about: "the upper right corner", example: "[\"6 cm\", \"6 cm\"]", wants: Wants::Corner },
    number("fraction_deficit", "subtracted from the packing fraction there", RATIO, Range::closed(0.0, 0.3), "0.02"),
] };

impl Table {
    /// The table of that name; asking for one that does not exist is a slip in this program.
    pub fn named(name: &str) -> &'static Self {
        TABLES.iter().find(|table| table.name == name).unwrap_or_else(|| panic!("the schema has no table {name}"))
    }

    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// `contact.friction`, or `name` at the top level.
    pub fn path(&self, key: &str) -> String {
        match self.name {
            "" => key.to_string(),
            name => format!("{name}.{key}"),
        }
    }

    /// For a sentence: `[contact]` or `the job`.
    pub fn words(&self) -> String {
        match self.name {
            "" => "the job's top level".to_string(),
            name if name == WEAK.name => format!("[[{name}]]"),
            name => format!("[{name}]"),
        }
    }

    pub fn key_list(&self) -> String {
        let names: Vec<&str> = self.keys.iter().map(|key| key.name).collect();
        names.join(", ")
    }
}
