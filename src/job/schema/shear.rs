//! Planar shear between rough plates.

use super::super::units::Dimension;
use super::assembly::OUTPUT_WITH_BOTH;
use super::{
    DAMPING, Key, LENGTH, NOT_NEGATIVE, POSITIVE, RATIO, Range, STRESS, TIME, Table, Wants, contact, count, key,
    number, table, text, vector,
};

#[rustfmt::skip]
pub static TABLES: [Table; 13] = [
    table("", "the job itself", &[
        text("name", "the job's name, also that of its run directory", "\"planar_shear\""),
        text("method", "which parts of the program are awake", "\"hybrid\""),
        count("seed", "the seed of every random number", (0, i64::MAX as u64), "1"),
    ]),
    table("specimen", "the box of material", &[
        number("width", "the period in x", LENGTH, POSITIVE, "\"6 cm\""),
        number("height", "the distance of the plates", LENGTH, POSITIVE, "\"12 cm\""),
        number("depth", "the out-of-plane depth", LENGTH, POSITIVE, "\"1 cm\""),
    ]),
    table("grains", "sizes and matter of the grains", &[
        number("diameter_mean", "the mean diameter D50", LENGTH, POSITIVE, "\"1 mm\""),
        number("diameter_deviation", "the standard deviation of diameters", LENGTH, NOT_NEGATIVE, "\"0.08 mm\""),
        number("density", "the density of the solid", Dimension::DENSITY, POSITIVE, "\"2530 kg/m3\""),
        text("file", "grains to start from, as a CSV file", "\"grains.csv\""),
    ]),
    table("contact", "forces between grains", contact::KEYS),
    table("packing", "how the packing is made, without cohesion", &[
        number("friction", "friction while the packing is made", RATIO, Range::closed(0.0, 5.0), "0.01"),
        number("fraction_start", "the packing fraction of the loose start", RATIO, Range::closed(0.2, 0.5), "0.45"),
        number("stress", "the normal stress of the packing", STRESS, POSITIVE, "\"400 kPa\""),
        number("height", "the height of a packing that only the zone is made of", LENGTH, POSITIVE, "\"12 cm\""),
        number("energy_ratio_max", "kinetic over elastic energy at rest", RATIO, Range::closed(1e-12, 0.1), "1e-4"),
        text("cache", "the folder of finished packings", "\"cache\""),
    ]),
    table("continuum", "the continuum and its grid", &[
        text("material", "a file with the keys from bulk_modulus to cohesion", "\"materials/chen_table_2.toml\""),
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
        key("weak", "regions that start looser", Wants::Tables(&WEAK), "[]"),
    ]),
    table("loading", "what is done to the specimen", &[
        number("stress_normal", "the normal stress on the upper plate", STRESS, POSITIVE, "\"400 kPa\""),
        number("speed", "the horizontal speed of the upper plate", Dimension::SPEED, POSITIVE, "\"2 cm/s\""),
        number("speed_ramp", "the time over which the speed rises", TIME, NOT_NEGATIVE, "\"1 ms\""),
        number("strain_end", "the horizontal strain that the run ends at", RATIO, Range::new(0.0, 100.0, true, false), "0.57"),
        number("plate_mass", "the mass of the upper plate", Dimension::MASS, POSITIVE, "\"15 g\""),
        number("plate_damping", "damping of the plate's vertical motion", DAMPING, NOT_NEGATIVE, "\"1000 N s/m\""),
    ]),
    table("oracle", "shear band detection", &[
        number("laplacian", "c_0", RATIO, POSITIVE, "1e-6"),
        number("recent_strain", "c_1", RATIO, NOT_NEGATIVE, "1e-4"),
        number("window", "c_l", RATIO, POSITIVE, "8e-4"),
        number("persistence", "c_g", RATIO, POSITIVE, "1.2e-3"),
        number("tolerance", "the share of flagged nodes that may come and go from look to look", RATIO, Range::closed(0.0, 0.5), "0.1"),
        count("every", "steps between two looks", (1, 1_000_000_000), "50"),
    ]),
    table("enrichment", "grains for points", &KEYS_OF_ENRICHMENT),
    table("zone", "what becomes of the grains' zone", &KEYS_OF_ZONE),
    table("time", "the time step", &[
        number("step", "the time step", TIME, POSITIVE, "\"0.4 us\""),
        count("grain_steps", "steps of grains in one of the continuum", (1, 1000), "8"),
    ]),
    table("decomposition", "how the domain is cut", &[
        count("cells_per_block", "the edge of a block in cells", (2, 64), "2"),
        number("skin", "the reach of the neighbour list beyond contact", LENGTH, POSITIVE, "\"0.1 mm\""),
    ]),
    table("output", "what is written and when", &OUTPUT_WITH_BOTH),
];

/// One `[[continuum.weak]]`.
#[rustfmt::skip]
static WEAK: Table = Table { name: "continuum.weak", about: "a region that starts looser", many: true, keys: &[
    vector("lower", "the lower left corner", LENGTH, "\"5 cm\""),
    vector("upper", "the upper right corner", LENGTH, "\"6 cm\""),
    number("fraction_deficit", "subtracted from the packing fraction there", RATIO, Range::closed(0.0, 0.3), "0.02"),
] };

#[rustfmt::skip]
pub(super) const KEYS_OF_ZONE: [Key; 4] = [
    key("grows", "whether it follows the band where the oracle finds it beyond", Wants::Flag, "false"),
    key("dissolves", "whether grains at rest turn back into points", Wants::Flag, "false"),
    number("rest_strain", "the strain of the busiest cell over which rest is judged", RATIO, POSITIVE, "0.05"),
    number("rest_share", "the share of it below which a cell rests", RATIO, Range::open(0.0, 1.0), "0.02"),
];

#[rustfmt::skip]
pub(super) const KEYS_OF_ENRICHMENT: [Key; 5] = [
    number("distance", "phi_0", LENGTH, POSITIVE, "\"2.2 cm\""),
    number("weight", "w, the grains' share in the rim", RATIO, Range::open(0.0, 1.0), "0.5"),
    number("training", "the share of the motion trained", RATIO, Range::closed(0.0, 1.0), "1.0"),
    number("training_speed", "how much faster training runs", RATIO, Range::closed(0.01, 1e6), "10.0"),
    number("training_rest", "rest after training", RATIO, Range::closed(0.0, 1000.0), "0.5"),
];
