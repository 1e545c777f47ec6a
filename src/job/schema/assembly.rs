//! Grains in a cell.

use super::super::units::Dimension;
use super::{
    DAMPING, Key, LENGTH, NOT_NEGATIVE, OUTPUT, OUTPUT_WITH_CONTACTS, POSITIVE, RATIO, Range, STRESS, TIME, Table,
    Wants, contact, count, key, number, table, text, vector,
};

#[rustfmt::skip]
pub static TABLES: [Table; 9] = [
    table("", "the job itself", &[
        text("name", "the job's name, also that of its run directory", "\"rve_shear\""),
        count("seed", "the seed of every random number", (0, i64::MAX as u64), "1"),
        key("body", "rigid bodies among the grains", Wants::Tables(&BODY), "[]"),
    ]),
    table("cell", "the domain of an assembly of grains", &[
        text("space", "plane for discs, solid for spheres", "\"plane\""),
        vector("lower", "the lower corner", LENGTH, "\"0 cm\""),
        vector("upper", "the upper corner", LENGTH, "\"9 cm\""),
        key("periodic", "which axes are periodic", Wants::Flags, "true"),
        number("depth", "the out-of-plane depth of discs", LENGTH, POSITIVE, "\"1 cm\""),
        key("velocity_gradient", "L of dh/dt = L h for the cell's edges h", Wants::Gradient, "0.0"),
        key("stress", "the normal stress that each axis is held at, tension positive, or \"free\"", Wants::Stresses, "\"-100 kPa\""),
        number("rate_max", "the largest rate of stretch of axes held at a stress", Dimension::RATE, POSITIVE, "\"2 1/s\""),
        number("stress_gain", "the share of a missing stress that is made up between two looks at it", RATIO, Range::closed(1e-3, 1.0), "1.0"),
        count("stress_interval", "steps between two looks at the stress", (1, 1000), "2"),
        vector("gravity", "the acceleration of every grain", Dimension::ACCELERATION, "\"-9.81 m/s2\""),
    ]),
    table("grains", "sizes and matter of the grains", &KEYS_OF_GRAINS),
    table("packing", "how grains that are not read from a file are made", &KEYS_OF_PACKING),
    table("contact", "forces between grains", contact::KEYS),
    table("damping", "damping of grains beside that of their contacts", &[
        number("local", "local damping, a share of the force on a grain", RATIO, Range::below(0.0, 1.0), "0.1"),
        text("form", "the law of local damping: vector or component", "\"vector\""),
        number("mass", "c of the damping force -c m v", Dimension::RATE, NOT_NEGATIVE, "\"10 1/s\""),
    ]),
    table("time", "the time step and the end", &[
        number("step", "the time step", TIME, POSITIVE, "\"0.4 us\""),
        number("end", "the simulated time at which the run ends", TIME, POSITIVE, "\"0.5 s\""),
        text("velocities", "what time the velocities of the start belong to: now, or half_step_before", "\"now\""),
        key("allow_unstable", "lets a step pass that is longer than the stable one", Wants::Flag, "true"),
    ]),
    table("decomposition", "how the domain is cut", &[
        number("skin", "the reach of the neighbour list beyond contact", LENGTH, POSITIVE, "\"0.1 mm\""),
        number("block", "the edge that blocks aim at", LENGTH, POSITIVE, "\"12 mm\""),
    ]),
    table("output", "what is written and when", &OUTPUT_WITH_BOTH),
];

#[rustfmt::skip]
pub(super) const KEYS_OF_GRAINS: [Key; 10] = [
    number("density", "the density of the solid", Dimension::DENSITY, POSITIVE, "\"2650 kg/m3\""),
    text("file", "grains to start from, as a CSV or a LAMMPS data file", "\"grains.csv\""),
    text("contacts", "what the contacts of these grains remember at the start, as scree export --contacts writes it", "\"contacts.csv\""),
    count("count", "grains to be made", (1, 100_000_000), "400"),
    text("distribution", "how diameters are spread: normal, uniform or list", "\"normal\""),
    number("diameter_mean", "the mean diameter", LENGTH, POSITIVE, "\"1 mm\""),
    number("diameter_deviation", "the standard deviation of diameters", LENGTH, NOT_NEGATIVE, "\"0.08 mm\""),
    number("diameter_min", "the smallest diameter", LENGTH, POSITIVE, "\"6 mm\""),
    number("diameter_max", "the largest diameter", LENGTH, POSITIVE, "\"14 mm\""),
    key("diameters", "diameters with their shares of the number of grains", Wants::Shares, "[[\"1 mm\", 0.5], [\"2 mm\", 0.5]]"),
];

#[rustfmt::skip]
pub(super) const KEYS_OF_PACKING: [Key; 8] = [
    text("preparation", "compress a periodic cell without cohesion, or pour onto bodies", "\"compress\""),
    number("stress", "the mean stress that the packing is compressed to, compression positive", STRESS, POSITIVE, "\"100 kPa\""),
    number("fraction", "the packing fraction to be reached, by a hot start where compression alone stops short", RATIO, Range::closed(0.3, 0.92), "0.85"),
    number("unloaded", "a lower mean stress that the packing comes to once it is compressed", STRESS, POSITIVE, "\"2 kPa\""),
    number("friction", "friction while the packing is made", RATIO, Range::closed(0.0, 5.0), "0.01"),
    number("fraction_start", "the packing fraction of the loose start", RATIO, Range::closed(0.02, 0.5), "0.45"),
    number("energy_ratio_max", "kinetic over elastic energy at rest", RATIO, Range::closed(1e-12, 0.1), "1e-4"),
    text("cache", "the folder of finished packings", "\"cache\""),
];

/// `[output]` of all kinds, contacts, and the account of energy.
pub(super) const OUTPUT_WITH_BOTH: [Key; 9] = {
    let [series, frames, checkpoints, steps, wall, kept, good, contacts] = OUTPUT_WITH_CONTACTS;
    let [.., ledger] = OUTPUT_WITH_LEDGER;
    [series, frames, checkpoints, steps, wall, kept, good, contacts, ledger]
};

/// `[output]` of all kinds, and the account of energy.
pub(super) const OUTPUT_WITH_LEDGER: [Key; 8] = {
    let [series, frames, checkpoints, steps, wall, kept, good] = OUTPUT;
    let about = "adds columns of work done, energy stored and energy lost to series.csv";
    [series, frames, checkpoints, steps, wall, kept, good, key("ledger", about, Wants::Flag, "true")]
};

/// One `[[body]]`.
static BODY: Table = Table { name: "body", about: "a rigid body", many: true, keys: &KEYS_OF_BODY };

/// The keys that bodies have in every job.
#[rustfmt::skip]
pub const KEYS_OF_BODY: [Key; 14] = [
    text("name", "the body's name", "\"lid\""),
    text("shape", "the body's shape", "\"plane\""),
    vector("point", "a point of the plane", LENGTH, "\"0 cm\""),
    vector("normal", "the direction from the plane towards what it holds", RATIO, "1.0"),
    vector("lower", "the lower corner", LENGTH, "\"1 cm\""),
    vector("upper", "the upper corner", LENGTH, "\"2 cm\""),
    vector("centre", "the centre, or a point of the axis", LENGTH, "\"1 cm\""),
    number("radius", "the radius", LENGTH, POSITIVE, "\"5 mm\""),
    vector("axis", "the direction of the cylinder", RATIO, "1.0"),
    vector("velocity", "the velocity", Dimension::SPEED, "\"1 cm/s\""),
    key("spin", "the angular velocity", Wants::Spin, "\"3 rad/s\""),
    number("ramp", "the time over which velocity and spin rise from zero", TIME, NOT_NEGATIVE, "\"10 ms\""),
    key("path", "velocity and spin at given times, in place of velocity, spin and ramp", Wants::Tables(&PATH), "[{time = 0, velocity = [0, 0]}]"),
    key("servo", "the force or stress that the body is held at", Wants::Table(&SERVO), "{direction = [0, 1], force = \"5 N\", mass = \"10 g\", speed_max = \"1 cm/s\"}"),
];

#[rustfmt::skip]
static PATH: Table = Table { name: "body.path", about: "velocity and spin at a time", many: true, keys: &[
    number("time", "the time", TIME, NOT_NEGATIVE, "\"10 ms\""),
    vector("velocity", "the velocity", Dimension::SPEED, "\"1 cm/s\""),
    key("spin", "the angular velocity", Wants::Spin, "\"3 rad/s\""),
] };

#[rustfmt::skip]
static SERVO: Table = Table { name: "body.servo", about: "the force or stress that a body is held at", many: false, keys: &[
    vector("direction", "the direction that the body is pushed in", RATIO, "1.0"),
    number("force", "the force on the body along that direction", Dimension::FORCE, NOT_NEGATIVE, "\"5 N\""),
    number("stress", "the force over the area, in place of force", STRESS, NOT_NEGATIVE, "\"100 kPa\""),
    number("area", "the area of stress", Dimension::AREA, POSITIVE, "\"4 cm2\""),
    number("mass", "the mass that the servo moves", Dimension::MASS, POSITIVE, "\"10 g\""),
    number("damping", "damping of that motion", DAMPING, NOT_NEGATIVE, "\"10 N s/m\""),
    number("speed_max", "the largest speed along that direction", Dimension::SPEED, POSITIVE, "\"1 cm/s\""),
] };
