//! A continuum of material points on a grid.

use std::f64::consts::FRAC_PI_4;

use super::super::units::Dimension;
use super::assembly::{KEYS_OF_BODY, KEYS_OF_GRAINS, KEYS_OF_PACKING, OUTPUT_WITH_LEDGER};
use super::shear::{KEYS_OF_ENRICHMENT, KEYS_OF_ZONE};
use super::{
    Key, LENGTH, NOT_NEGATIVE, POSITIVE, RATIO, Range, STRESS, TIME, Table, Wants, contact, count, key, number, table,
    text, vector,
};

const ANGLE: Dimension = Dimension::ANGLE;
const SPEED: Dimension = Dimension::SPEED;

#[rustfmt::skip]
pub static TABLES: [Table; 15] = [
    table("", "the job itself", &[
        text("name", "the job's name, also that of its run directory", "\"column_collapse\""),
        text("method", "what a job with grains is made of: mpm, dem or hybrid", "\"hybrid\""),
        count("seed", "the seed of every random number", (0, i64::MAX as u64), "1"),
        key("region", "where material is at the start", Wants::Tables(&REGION), "[{shape = \"box\", lower = [0, 0], upper = [1, 1]}]"),
        key("boundary", "what happens at the faces of the grid", Wants::Tables(&BOUNDARY), "[{face = \"y_lower\", kind = \"fixed\"}]"),
        key("load", "loads on the material's surface", Wants::Tables(&LOAD), "[{face = \"y_upper\", kind = \"pressure\", pressure = \"1 kPa\"}]"),
        key("membrane", "elastic membranes that press on the material", Wants::Tables(&MEMBRANE), "[]"),
        key("body", "rigid bodies that the material touches", Wants::Tables(&BODY), "[]"),
        key("band", "straight parts of shear bands that are known", Wants::Tables(&BAND), "[]"),
        key("follow", "points with columns of their own in the series", Wants::Tables(&FOLLOW), "[{name = \"tip\", place = [0, 0]}]"),
    ]),
    table("grid", "the domain of a continuum and its cells", &[
        text("space", "plane for plane strain, solid for three dimensions", "\"plane\""),
        vector("lower", "the lower corner", LENGTH, "\"0 m\""),
        vector("upper", "the upper corner", LENGTH, "\"4 m\""),
        number("cell", "the edge of a cell", LENGTH, POSITIVE, "\"10 cm\""),
        number("depth", "the out-of-plane depth", LENGTH, POSITIVE, "\"1 cm\""),
        key("periodic", "which axes are periodic", Wants::Flags, "false"),
    ]),
    table("scheme", "how points and nodes exchange what they carry", &[
        text("shape", "the shape functions: linear, generalised, quadratic or cubic", "\"quadratic\""),
        text("update", "when stresses follow the strain: first, last or modified_last", "\"last\""),
        text("transfer", "what points take from the nodes: blend or affine", "\"blend\""),
        number("flip", "the share of increments in the velocity update, 0 (PIC) to 1 (FLIP)", RATIO, Range::closed(0.0, 1.0), "0.99"),
        count("points_per_cell", "points per cell and axis", (1, 16), "2"),
    ]),
    table("material", "what the points are made of", &[
        text("law", "the material law: linear_elastic, hencky or critical_drucker_prager", "\"hencky\""),
        number("density", "the density of the material with its pores", Dimension::DENSITY, POSITIVE, "\"2000 kg/m3\""),
        number("young_modulus", "E", STRESS, POSITIVE, "\"10 MPa\""),
        number("poisson_ratio", "Poisson's ratio", RATIO, Range::open(-1.0, 0.5), "0.3"),
        number("bulk_modulus", "K", STRESS, POSITIVE, "\"630 MPa\""),
        number("shear_modulus", "G", STRESS, POSITIVE, "\"460 MPa\""),
        number("friction_angle_critical", "phi_cs", ANGLE, Range::below(0.0, 1.3734), "\"30 deg\""),
        number("fraction_critical", "Phi_cs", RATIO, Range::open(0.0, 1.0), "0.815"),
        number("fraction", "the packing fraction that points start with", RATIO, Range::open(0.0, 1.0), "0.83"),
        number("dilation_factor", "chi of tan(psi) = chi (Phi - Phi_cs)", RATIO, Range::closed(0.0, 100.0), "7"),
        number("softening_rate", "xi of dPhi/dt = -(Phi - Phi_cs) Phi xi |deps_p/dt|", RATIO, Range::closed(0.0, 1000.0), "7"),
        number("cohesion", "c", STRESS, NOT_NEGATIVE, "\"10 kPa\""),
        number("dilation_angle", "a constant psi in place of that of chi", ANGLE, Range::closed(-FRAC_PI_4, FRAC_PI_4), "\"0 deg\""),
    ]),
    table("stress", "the stress at the start", &[
        text("kind", "none, isotropic or geostatic", "\"geostatic\""),
        number("pressure", "the pressure everywhere", STRESS, POSITIVE, "\"100 kPa\""),
        number("surface", "the coordinate of the surface along gravity", LENGTH, Range::new(f64::NEG_INFINITY, f64::INFINITY, true, true), "\"1 m\""),
        number("k0", "the stress across over the stress along gravity", RATIO, Range::closed(0.0, 10.0), "0.5"),
        number("surcharge", "the pressure on the surface", STRESS, NOT_NEGATIVE, "\"20 kPa\""),
    ]),
    table("gravity", "the acceleration of all material", &[
        vector("acceleration", "the acceleration", Dimension::ACCELERATION, "\"-9.81 m/s2\""),
        number("ramp", "the time over which it rises from zero", TIME, NOT_NEGATIVE, "\"0.1 s\""),
    ]),
    table("time", "the time step and the end", &[
        number("step", "the time step", TIME, POSITIVE, "\"10 us\""),
        number("safety", "the time step over the stable one, in place of step", RATIO, Range::new(0.0, 1.0, true, false), "0.5"),
        count("grain_steps", "steps of grains in one of the continuum", (1, 1000), "8"),
        number("end", "the simulated time at which the run ends", TIME, POSITIVE, "\"1 s\""),
    ]),
    table("decomposition", "how the domain is cut", &[
        count("cells_per_block", "the edge of a block in cells", (2, 64), "8"),
        number("skin", "the reach of the neighbour list beyond contact", LENGTH, POSITIVE, "\"0.1 mm\""),
    ]),
    table("oracle", "where a shear band would be replaced by grains", &[
        number("diameter", "D50 of those grains", LENGTH, POSITIVE, "\"1 mm\""),
        number("laplacian", "c_0", RATIO, POSITIVE, "1e-6"),
        number("recent_strain", "c_1", RATIO, NOT_NEGATIVE, "8e-3"),
        number("window", "c_l", RATIO, POSITIVE, "2e-2"),
        number("persistence", "c_g", RATIO, POSITIVE, "9.6e-3"),
        number("tolerance", "the share of flagged nodes that may come and go from look to look", RATIO, Range::closed(0.0, 0.5), "0.1"),
        count("every", "steps between two looks", (1, 1_000_000_000), "50"),
    ]),
    table("grains", "sizes and matter of the grains", &KEYS_OF_GRAINS),
    table("packing", "how a piece of packing is made, which is laid side by side", &KEYS_OF_PACKING),
    table("contact", "forces between grains", contact::KEYS),
    table("enrichment", "grains for points", &KEYS_OF_ENRICHMENT_HERE),
    table("zone", "what becomes of the grains' zone", &KEYS_OF_ZONE),
    table("output", "what is written and when", &OUTPUT_WITH_LEDGER),
];

#[rustfmt::skip]
static REGION: Table = Table { name: "region", about: "material at the start", many: true, keys: &[
    text("shape", "box, ball or polygon", "\"box\""),
    vector("lower", "the lower corner", LENGTH, "\"0 m\""),
    vector("upper", "the upper corner", LENGTH, "\"1 m\""),
    vector("centre", "the centre", LENGTH, "\"1 m\""),
    number("radius", "the radius", LENGTH, POSITIVE, "\"10 cm\""),
    key("vertices", "the corners of a polygon in the plane", Wants::Polygon, "[[0, 0], [\"2 m\", 0], [0, \"1 m\"]]"),
    number("fraction", "the packing fraction that its points start with", RATIO, Range::open(0.0, 1.0), "0.83"),
    vector("velocity", "the velocity at the start", SPEED, "\"1 cm/s\""),
    key("spin", "the angular velocity about its centre at the start", Wants::Spin, "\"3 rad/s\""),
    key("wave", "sines added to its velocity at the start", Wants::Tables(&WAVE), "[{direction = [1, 0], length = \"2 m\", amplitude = [\"1 mm/s\", 0]}]"),
] };

#[rustfmt::skip]
static WAVE: Table = Table { name: "region.wave", about: "a sine of the velocity at the start", many: true, keys: &[
    vector("direction", "the direction that it changes along", RATIO, "1.0"),
    number("length", "the wave length", LENGTH, POSITIVE, "\"2 m\""),
    vector("origin", "a place where it vanishes", LENGTH, "\"0 m\""),
    vector("amplitude", "the velocity at its crest", SPEED, "\"1 mm/s\""),
] };

#[rustfmt::skip]
static BOUNDARY: Table = Table { name: "boundary", about: "what happens at a face of the grid", many: true, keys: &[
    text("face", "which face: x_lower, x_upper and so on", "\"y_lower\""),
    text("kind", "fixed, roller, friction, absorbing or free", "\"fixed\""),
    number("coefficient", "the Coulomb coefficient", RATIO, Range::closed(0.0, 5.0), "0.5"),
] };

#[rustfmt::skip]
static LOAD: Table = Table { name: "load", about: "a load on the material's surface", many: true, keys: &[
    text("face", "which side of the material: x_lower, x_upper and so on", "\"y_upper\""),
    vector("lower", "the lower corner of what is loaded", LENGTH, "\"0 m\""),
    vector("upper", "the upper corner of what is loaded", LENGTH, "\"1 m\""),
    text("kind", "traction or pressure", "\"pressure\""),
    vector("traction", "the force per area of the start", STRESS, "\"10 kPa\""),
    number("pressure", "the pressure against the surface's normal", STRESS, POSITIVE, "\"10 kPa\""),
    number("ramp", "the time over which it rises from zero", TIME, NOT_NEGATIVE, "\"0.1 s\""),
] };

#[rustfmt::skip]
static MEMBRANE: Table = Table { name: "membrane", about: "an elastic membrane under pressure, in the plane", many: true, keys: &[
    text("name", "the membrane's name", "\"left\""),
    text("shape", "line or circle", "\"line\""),
    vector("from", "where a line begins; pressure pushes to the left of the way from there", LENGTH, "\"0 m\""),
    vector("to", "where a line ends", LENGTH, "\"9 cm\""),
    vector("centre", "the centre of a circle; pressure pushes inwards", LENGTH, "\"5 cm\""),
    number("radius", "the radius of a circle", LENGTH, POSITIVE, "\"4 cm\""),
    number("spacing", "the length of its segments", LENGTH, POSITIVE, "\"2 mm\""),
    number("mass_per_area", "its mass per area", Dimension::MASS_PER_AREA, POSITIVE, "\"0.3 kg/m2\""),
    number("stiffness", "force on a segment per lengthening of it", Dimension::STIFFNESS, POSITIVE, "\"10 kN/m\""),
    number("damping", "force on a segment per speed of its lengthening", Dimension::DAMPING, NOT_NEGATIVE, "\"1 N s/m\""),
    number("tension", "the force on a segment at the start", Dimension::FORCE, NOT_NEGATIVE, "\"2 N\""),
    number("pressure", "the pressure, to the left of its way", STRESS, Range::new(f64::NEG_INFINITY, f64::INFINITY, true, true), "\"100 kPa\""),
    number("ramp", "the time over which the pressure rises from zero", TIME, NOT_NEGATIVE, "\"0.1 s\""),
] };

#[rustfmt::skip]
const KEYS_OF_ENRICHMENT_HERE: [Key; 7] = {
    let [distance, weight, training, training_speed, training_rest] = KEYS_OF_ENRICHMENT;
    [
        distance, weight, training, training_speed, training_rest,
        text("reference", "where grains come from: specimen or piece", "\"specimen\""),
        number("at", "when grains take the places of points around every [[band]]", TIME, POSITIVE, "\"0.1 s\""),
    ]
};

#[rustfmt::skip]
static BAND: Table = Table { name: "band", about: "a straight part of a shear band that is known", many: true, keys: &[
    vector("from", "where it begins", LENGTH, "\"0 m\""),
    vector("to", "where it ends", LENGTH, "\"9 cm\""),
] };

/// One `[[body]]`: that of assemblies, and how the material touches it.
static BODY: Table = Table { name: "body", about: "a rigid body", many: true, keys: &KEYS_OF_BODY_HERE };

#[rustfmt::skip]
const KEYS_OF_BODY_HERE: [Key; 18] = {
    let [name, shape, point, normal, lower, upper, centre, radius, axis, velocity, spin, ramp, path, servo] = KEYS_OF_BODY;
    [
        name, shape, point, normal, lower, upper, centre, radius, axis, velocity, spin, ramp, path, servo,
        text("contact", "how the material touches it: rough, smooth or coulomb", "\"rough\""),
        number("friction", "the Coulomb coefficient", RATIO, Range::closed(0.0, 5.0), "0.5"),
        key("separates", "whether material may part from it", Wants::Flag, "true"),
        number("seat", "the force that presses it along its first way on grains until they rest, before the run", Dimension::FORCE, POSITIVE, "\"60 N\""),
    ]
};

#[rustfmt::skip]
static FOLLOW: Table = Table { name: "follow", about: "a point with columns of its own in the series", many: true, keys: &[
    text("name", "the point's name", "\"tip\""),
    vector("place", "the place that it is nearest to at the start", LENGTH, "\"1 m\""),
] };
