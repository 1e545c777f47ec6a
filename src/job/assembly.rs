//! Grains in a cell: element tests, collisions, pours and packings. What `[cell]` in a job means, in SI units.
//!
//! Vectors and tensors carry three components; in the plane those of z are zero, and z is not periodic.

use std::path::{Path, PathBuf};

use super::Output;
use crate::dem::motion::Damping;
use crate::law::contact::Contact;

/// The checked job of an assembly of grains.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Job name; the default run directory is `runs/<name>`.
    pub name: String,
    /// Seed of every random number of the job.
    pub seed: u64,
    pub cell: Cell,
    pub matter: Matter,
    pub source: Source,
    pub contact: Contact,
    pub damping: Damping,
    /// m/s2.
    pub gravity: [f64; 3],
    pub bodies: Vec<Body>,
    /// Time step, s.
    pub step: f64,
    /// Simulated time at which the run ends, s.
    pub end: f64,
    pub velocities: Velocities,
    /// The step may be longer than the stable one: a run known to be unstable is repeated on purpose.
    pub allow_unstable: bool,
    /// Reach of the neighbour list beyond contact, m.
    pub skin: f64,
    /// Edge that blocks aim at, m; they fill the cell exactly.
    pub block: f64,
    pub output: Output,
    /// An account of work and energy is kept, in columns of its own.
    pub ledger: bool,
}

/// The domain: a box, periodic along some axes, that may deform.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// 2 or 3.
    pub dimension: usize,
    /// m.
    pub lower: [f64; 3],
    pub upper: [f64; 3],
    /// Along an axis that is not periodic the cell only bounds where grains may go; walls are bodies.
    pub periodic: [bool; 3],
    /// Out-of-plane depth in two dimensions, m; 1 in three, where nothing looks at it.
    pub depth: f64,
    /// Velocity gradient L of a periodic cell, 1/s: the edges follow dh/dt = L h.
    pub gradient: [[f64; 3]; 3],
    /// Stress control of axes (normal components), in place of the diagonal of `gradient`.
    pub servo: Option<CellServo>,
}

/// Axes whose rate of stretch is set so that the normal stress reaches a target.
#[derive(Clone, Debug, PartialEq)]
pub struct CellServo {
    /// Wanted normal stress per axis, Pa, tension positive; none: that axis follows `gradient`.
    pub stress: [Option<f64>; 3],
    /// Largest rate of stretch, 1/s.
    pub rate_max: f64,
    /// Share of a missing stress that is made up between two looks, where grains move with the cell.
    pub gain: f64,
    /// Steps between two looks.
    pub interval: u64,
}

impl CellServo {
    /// Defaults: the cell answers within two steps, less than the period of a grain among its neighbours.
    pub const GAIN: f64 = 1.0;
    pub const INTERVAL: u64 = 2;
}

/// What grains are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matter {
    /// Density of the solid, kg/m3.
    pub density: f64,
    /// Mean diameter, m: of the sizes that grains are made with, or what the job says of those in its file.
    pub diameter_mean: f64,
}

/// Where the grains come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    File(Read),
    /// Made by the program and kept in the cache.
    Packed(Packed),
}

/// Files that a start is read from.
#[derive(Clone, Debug, PartialEq)]
pub struct Read {
    /// A CSV file, or a LAMMPS data file (extension `data` or `lmp`).
    pub grains: PathBuf,
    /// A CSV file of what contacts remember; none: nothing yet.
    pub contacts: Option<PathBuf>,
}

impl Source {
    /// The file that grains are read from, if they are.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(read) => Some(&read.grains),
            Self::Packed(_) => None,
        }
    }
}

/// How grains are made: thrown loosely into the cell, then brought to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    pub sizes: Sizes,
    pub count: u64,
    pub preparation: Preparation,
    /// Friction coefficient while the packing is made.
    pub friction: f64,
    /// Packing fraction of the loose start.
    pub fraction_start: f64,
    /// At rest when kinetic energy is below this share of elastic energy.
    pub energy_ratio_max: f64,
    pub cache: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Preparation {
    /// A cell periodic along every axis is compressed to this mean stress, Pa (compression positive). Frictionless and
    /// hot first where `fraction` asks for more than compression alone reaches. At rest it is let come to the lower stress
    /// `unloaded`, if there is one, Pa.
    Compress { stress: f64, fraction: Option<f64>, unloaded: Option<f64> },
    /// Grains fall under the job's gravity onto its bodies.
    Pour,
}

/// Diameters, m.
#[derive(Clone, Debug, PartialEq)]
pub enum Sizes {
    /// Normal, cut at three deviations.
    Normal {
        mean: f64,
        deviation: f64,
    },
    Uniform {
        min: f64,
        max: f64,
    },
    /// Diameters with their shares of the number of grains, which add up to 1.
    List(Vec<(f64, f64)>),
}

/// Leapfrog velocities stand half a step before positions; those of a start may be of either time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Velocities {
    /// Of the time of the positions: the first kick lasts half a step.
    #[default]
    Now,
    /// Half a step before already: the first kick is whole.
    HalfStepBefore,
}

/// A rigid body among the grains.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub name: String,
    pub shape: Shape,
    pub motion: Motion,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Half space below a plane: through `point`, with the unit `normal` towards the grains.
    Plane { point: [f64; 3], normal: [f64; 3] },
    /// A solid box with edges along the axes.
    Box { lower: [f64; 3], upper: [f64; 3] },
    /// A solid disc, or in three dimensions a cylinder without end along `axis`.
    Cylinder { centre: [f64; 3], radius: f64, axis: [f64; 3] },
    /// The grains of the start whose centres lie in this box, glued together: a rough layer.
    Layer { lower: [f64; 3], upper: [f64; 3] },
}

/// How a body moves: along a path, and under stress control in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Velocity (m/s) and spin (rad/s) at given times (s), linear in between, the last kept on; empty: at rest.
    pub path: Vec<PathPoint>,
    pub servo: Option<BodyServo>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    pub time: f64,
    pub velocity: [f64; 3],
    pub spin: [f64; 3],
}

/// M dv/dt = f.n - F - damping v, with v the speed along the unit `direction` and F the force that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyServo {
    /// Direction the grains push the body in.
    pub direction: [f64; 3],
    /// Force of the grains along `direction` that is to be kept, N.
    pub force: f64,
    /// kg, N s/m, m/s.
    pub mass: f64,
    pub damping: f64,
    pub speed_max: f64,
}
