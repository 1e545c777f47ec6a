//! Grains in a cell: element tests, collisions, pours and packings. What `[cell]` in a job means, in SI units.
//!
//! Vectors and tensors carry three components; in the plane those of z are zero, and z is not periodic.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::figures;
pub use super::motion::{BodyServo, Motion, Oscillation, PathPoint};
use super::output::Output;
use super::schema::{list, section};
use super::shear::{keys_of_step, rest_and_cache, skin};
use super::stable::step_default;
use super::write::Page;
use crate::base::keys::{
    DENSITY, Form, Key, LENGTH, NOT_NEGATIVE, POSITIVE, RATIO, Range, STRESS, TIME, Table, Wants, choose, count, flag,
    key, number, text, variant, vector,
};
use crate::base::units::Dimension;
use crate::dem::motion::Damping;
use crate::law::contact::Contact;

/// The checked job of an assembly of grains.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Job name; the default run directory is `runs/<name>`.
    pub name: String,
    /// Seed of every random number of the job.
    pub seed: u64,
    /// Where grains are.
    pub cell: Cell,
    /// Density and mean diameter of the grains.
    pub matter: Matter,
    /// A file, or a packing that is made.
    pub source: Source,
    /// Of grains with each other and with bodies.
    pub contact: Contact,
    /// Beside that of contacts.
    pub damping: Damping,
    /// m/s2.
    pub gravity: [f64; 3],
    /// In the order of the job, each with a name of its own.
    pub bodies: Vec<Body>,
    /// Time step, s.
    pub step: f64,
    /// Simulated time at which the run ends, s.
    pub end: f64,
    /// What time those of the start belong to.
    pub velocities: Velocities,
    /// The step may be longer than the stable one: a run known to be unstable is repeated on purpose.
    pub allow_unstable: bool,
    /// Reach of the neighbour list beyond contact, m.
    pub skin: f64,
    /// Edge that blocks aim at, m; they fill the cell exactly.
    pub block: f64,
    /// What is written and when.
    pub output: Output,
    /// An account of work and energy is kept, in columns of its own.
    pub ledger: bool,
}

impl Assembly {
    /// The job in SI numbers with nothing left to a default. It parses back to an equal assembly.
    pub fn to_toml(&self) -> String {
        let (mut job, mut page) = (self.clone(), Page::new(self.cell.dimension));
        job.head(&mut page);
        page.section("cell", |page| job.keys_of_cell(page));
        page.section("grains", |page| keys_of_grains(page, &mut job.matter, &mut job.source));
        if let Source::Packed(packed) = &mut job.source {
            page.section("packing", |page| packed.keys(page));
        }
        page.section("contact", |page| job.contact.keys(page, 0.0));
        page.section("damping", |page| job.damping.keys(page));
        page.section("time", |page| job.keys_of_time(page));
        page.section("decomposition", |page| job.keys_of_decomposition(page));
        page.section("output", |page| job.output.keys(page, &mut job.ledger));
        Body::list(&mut job.bodies, &mut page);
        page.text()
    }

    pub(super) fn head(&mut self, form: &mut dyn Form) {
        form.text(&mut self.name, text("name", "the job's name, also that of its run directory", "\"rve_shear\""));
        form.count(&mut self.seed, count("seed", "the seed of every random number", (0, i64::MAX as u64), "1").or("1"));
    }

    pub(super) fn keys_of_cell(&mut self, form: &mut dyn Form) {
        self.cell.keys(form);
        let gravity =
            vector("gravity", "the acceleration of every grain", Dimension::ACCELERATION, "[0, \"-9.81 m/s2\"]");
        form.vector(&mut self.gravity, gravity.follows("none"));
    }

    pub(super) fn keys_of_time(&mut self, form: &mut dyn Form) {
        keys_of_step(&mut self.step, form);
        form.number(
            &mut self.end,
            number("end", "the simulated time at which the run ends", TIME, POSITIVE, "\"0.5 s\""),
        );
        let about = "what time the velocities of the start belong to: now, or half_step_before";
        let names = [("now", Velocities::Now), ("half_step_before", Velocities::HalfStepBefore)];
        let key = text("velocities", about, "\"now\"").or("now");
        choose(form, &mut self.velocities, "time of velocities", key, &names);
        let about = "lets a step pass that is longer than the stable one";
        form.flag(&mut self.allow_unstable, flag("allow_unstable", about, "true").or("false"));
    }

    pub(super) fn keys_of_decomposition(&mut self, form: &mut dyn Form) {
        skin(form, &mut self.skin);
        let block = number("block", "the edge that blocks aim at", LENGTH, POSITIVE, "\"12 mm\"");
        form.number(&mut self.block, block.follows("twelve mean diameters of discs, six of spheres"));
    }

    /// The tables of a job, with all their keys.
    pub(super) fn tables() -> Vec<Table> {
        let mut job = Self::blank();
        let mut packed = Packed::blank(2);
        vec![
            section("", "the job itself", |form| {
                job.head(form);
                Body::list(&mut job.bodies, form);
            }),
            section("cell", "the domain of an assembly of grains", |form| job.keys_of_cell(form)),
            section("grains", "sizes and matter of the grains", |form| {
                keys_of_grains(form, &mut job.matter, &mut job.source);
            }),
            section("packing", "how grains that are not read from a file are made", |form| packed.keys(form)),
            section("contact", "forces between grains", |form| job.contact.keys(form, 0.0)),
            section("damping", "damping of grains beside that of their contacts", |form| job.damping.keys(form)),
            section("time", "the time step and the end", |form| job.keys_of_time(form)),
            section("decomposition", "how the domain is cut", |form| job.keys_of_decomposition(form)),
            section("output", "what is written and when", |form| job.output.keys(form, &mut job.ledger)),
        ]
    }

    /// The job of one copy of its packing, which is compressed in a cell with all periods, by the step that it would have by itself, whatever
    /// `time.step` is: other jobs have the same piece.
    pub fn of_one_copy(&self) -> Cow<'_, Self> {
        if self.cell.copies.is_none() {
            return Cow::Borrowed(self);
        }
        let periodic = std::array::from_fn(|axis| axis < self.cell.dimension);
        let cell = Cell { copies: None, periodic, ..self.cell.clone() };
        let free = Self { cell, bodies: Vec::new(), ..self.clone() };
        let step = step_default(&figures::bounds(&free));
        Cow::Owned(Self { bodies: self.bodies.clone(), step, ..free })
    }

    /// What a job is before it is read.
    pub(crate) fn blank() -> Self {
        Self {
            name: String::new(),
            seed: 1,
            cell: Cell {
                dimension: 2,
                lower: [0.0; 3],
                upper: [0.0; 3],
                copies: None,
                periodic: [false; 3],
                depth: 1.0,
                gradient: [[0.0; 3]; 3],
                servo: None,
            },
            matter: Matter { density: 0.0, diameter_mean: 0.0 },
            source: Source::Packed(Packed::blank(2)),
            contact: Contact::ASLEEP,
            damping: Damping::default(),
            gravity: [0.0; 3],
            bodies: Vec::new(),
            step: 0.0,
            end: 0.0,
            velocities: Velocities::Now,
            allow_unstable: false,
            skin: 0.0,
            block: 0.0,
            output: Output::default(),
            ledger: false,
        }
    }
}

/// The domain: a box, periodic along some axes, that may deform.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// 2 or 3.
    pub dimension: usize,
    /// Corners of one copy of the packing, m.
    pub lower: [f64; 3],
    /// m.
    pub upper: [f64; 3],
    /// Copies of the packing side by side along each axis, 1 beyond the cell's axes; none: the packing itself fills the cell.
    pub copies: Option<[u64; 3]>,
    /// Along an axis that is not periodic the cell only bounds where grains may go; walls are bodies.
    pub periodic: [bool; 3],
    /// Out-of-plane depth in two dimensions, m; 1 in three, where nothing looks at it.
    pub depth: f64,
    /// Velocity gradient L of a periodic cell, 1/s: the edges follow dh/dt = L h.
    pub gradient: [[f64; 3]; 3],
    /// Stress control of axes (normal components), in place of the diagonal of `gradient`.
    pub servo: Option<CellServo>,
}

/// The space of a domain.
pub(super) fn space(form: &mut dyn Form, dimension: &mut usize, about: &'static str) {
    choose(form, dimension, "space", text("space", about, "\"plane\""), &[("plane", 2), ("solid", 3)]);
    form.set_axes(*dimension);
}

/// The out-of-plane depth of a domain, which spheres and solids do not have.
pub(super) fn depth(form: &mut dyn Form, depth: &mut f64, whose: &str) {
    if form.axes() == 2 {
        let key = number("depth", "the out-of-plane depth in the plane", LENGTH, POSITIVE, "\"1 cm\"");
        return form.number(depth, key.or("\"1 cm\""));
    }
    *depth = 1.0;
    if form.has("depth") {
        form.note("depth", &format!("belongs to space = \"plane\"; {whose} no depth. Remove the line."));
    }
}

impl Cell {
    /// Along each axis.
    pub fn counts(&self) -> [u64; 3] {
        self.copies.unwrap_or([1; 3])
    }

    /// The upper corner of all copies, m; of one alone, that corner.
    pub fn end(&self) -> [f64; 3] {
        let counts = self.counts();
        let more = |axis: usize| (counts[axis] - 1) as f64 * (self.upper[axis] - self.lower[axis]);
        std::array::from_fn(|axis| self.upper[axis] + more(axis))
    }

    fn keys_of_copies(&mut self, form: &mut dyn Form) {
        let about =
            "copies of the packing side by side along each axis; lower, upper and grains.count are those of one copy";
        let mut copies = self.copies.map(|copies| copies.map(|count| count as f64));
        form.vector_if_given(&mut copies, vector("copies", about, RATIO, "2").optional());
        if !form.is_needed() {
            return;
        }
        let Some(copies) = copies else { return self.copies = None };
        let mut counts = [1; 3];
        for (axis, count) in copies.into_iter().enumerate().take(self.dimension) {
            if count.round() != count || !(1.0..=COPIES_MAX).contains(&count) {
                let problem =
                    format!("has {count}, and a whole number from 1 to {COPIES_MAX:e} is wanted along every axis.");
                return form.note("copies", &problem);
            }
            counts[axis] = count as u64;
        }
        self.copies = Some(counts);
    }

    fn keys(&mut self, form: &mut dyn Form) {
        space(form, &mut self.dimension, "plane for discs, solid for spheres");
        form.vector(&mut self.lower, vector("lower", "the lower corner", LENGTH, "\"0 cm\"").follows("the origin"));
        form.vector(&mut self.upper, vector("upper", "the upper corner", LENGTH, "\"9 cm\""));
        self.keys_of_copies(form);
        if form.is_needed() {
            self.periodic = std::array::from_fn(|axis| axis < self.dimension);
        }
        form.flags(&mut self.periodic, key("periodic", "which axes are periodic", Wants::Flags, "true").follows("all"));
        depth(form, &mut self.depth, "spheres have");
        let about = "L of dh/dt = L h for the cell's edges h";
        form.gradient(&mut self.gradient, key("velocity_gradient", about, Wants::Gradient, "0.0").follows("none"));
        CellServo::keys(&mut self.servo, form);
    }
}

/// Grains of a job at most, as they are packed and of all copies.
pub const GRAINS_MAX: u64 = 100_000_000;
/// Copies of a packing along an axis at most.
const COPIES_MAX: f64 = 1e4;

/// Axes whose rate of stretch is set so that the normal stress reaches a target.
#[derive(Clone, Debug, PartialEq)]
pub struct CellServo {
    /// Wanted normal stress per axis, Pa, tension positive; none: that axis follows `gradient`.
    pub stress: [Option<f64>; 3],
    /// Largest rate of stretch, 1/s.
    pub rate_max: f64,
    /// Share of the stress error that is made up by the next correction, where grains move with the cell.
    pub gain: f64,
    /// Steps between two corrections.
    pub interval: u64,
}

impl CellServo {
    /// Defaults: the cell answers within two steps, less than the period of a grain among its neighbours.
    pub const GAIN: f64 = 1.0;
    /// Steps between two corrections.
    pub const INTERVAL: u64 = 2;

    fn keys(servo: &mut Option<Self>, form: &mut dyn Form) {
        let about = "the normal stress that each axis is held at, compression positive, or \"free\"";
        // Jobs count compression positive, all else tension.
        let turned = |stress: [Option<f64>; 3]| stress.map(|stress| stress.map(|stress| 0.0 - stress));
        let mut stress = servo.as_ref().map(|servo| turned(servo.stress));
        let key_of_stress = key("stress_normal", about, Wants::Stresses, "\"100 kPa\"");
        form.stresses(&mut stress, key_of_stress.optional());
        if form.is_needed() && stress.is_none() {
            if let Some(key) = ["rate_max", "stress_gain", "stress_interval"].into_iter().find(|key| form.has(key)) {
                form.note(
                    key,
                    "is of axes held at a stress, and there is no cell.stress_normal. Add it, or remove the line.",
                );
            }
            *servo = None;
            return;
        }
        let blank = Self { stress: [None; 3], rate_max: 0.0, gain: Self::GAIN, interval: Self::INTERVAL };
        let mut held = servo.clone().unwrap_or(blank);
        // Written where there is one alone.
        if stress.is_none() && !form.describes() {
            return;
        }
        held.stress = turned(stress.unwrap_or_default());
        let rate = "the largest rate of stretch of axes held at a stress";
        let rate = number("rate_max", rate, Dimension::RATE, POSITIVE, "\"2 1/s\"");
        form.number(&mut held.rate_max, rate.required("where stress_normal is given"));
        let gain = "the share of the stress error that is made up by the next correction";
        form.number(&mut held.gain, number("stress_gain", gain, RATIO, Range::closed(1e-3, 1.0), "1.0").or("1.0"));
        let interval = "steps between two corrections of the stress";
        form.count(&mut held.interval, count("stress_interval", interval, (1, 1000), "2").or("2"));
        *servo = Some(held);
    }
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
    /// Read from files of the job.
    File(Read),
    /// Made by the program and kept in the cache.
    Packed(Packed),
}

/// The keys of `[grains]`: where grains come from, and of those that are made their sizes.
pub(super) fn keys_of_grains(form: &mut dyn Form, matter: &mut Matter, source: &mut Source) {
    form.number(
        &mut matter.density,
        number("density", "the density of the matter of a grain, without pores", DENSITY, POSITIVE, "\"2650 kg/m3\""),
    );
    let (mut file, mut contacts) = match source {
        Source::File(read) => (Some(read.grains.clone()), read.contacts.clone()),
        Source::Packed(_) => (None, None),
    };
    let about_file = "grains to start from, a CSV or a LAMMPS data file; in place of count, [packing] and all sizes but diameter_mean";
    form.path_if_given(&mut file, text("file", about_file, "\"grains.csv\"").optional());
    let about = "what the contacts of these grains remember at the start, as scree export --contacts writes it";
    form.path_if_given(&mut contacts, text("contacts", about, "\"contacts.csv\"").optional());
    if let Some(grains) = file {
        /// Keys that only grains to be made need.
        const OF_MADE: [&str; 6] =
            ["count", "distribution", "diameter_deviation", "diameter_min", "diameter_max", "diameters"];
        if let Some(key) = OF_MADE.into_iter().find(|key| form.has(key)) {
            form.note(key, "is for grains to be made, and grains.file says that they are read. Remove one of the two.");
        }
        form.number(
            &mut matter.diameter_mean,
            number("diameter_mean", "the mean diameter", LENGTH, POSITIVE, "\"1 mm\""),
        );
        *source = Source::File(Read { grains, contacts });
        return;
    }
    if contacts.is_some() {
        let problem =
            "is what contacts of grains from a file remember, and there is no grains.file. Add it, or remove the line.";
        form.note("contacts", problem);
    }
    let Source::Packed(packed) = source else { unreachable!("grains without a file are made") };
    if form.is_needed() && !form.has("count") {
        form.note_table(
            "says neither where grains are read from nor how many are made. Add file = \"grains.csv\", or count = 400.",
        );
    } else {
        let made = count("count", "grains to be made", (1, GRAINS_MAX), "400");
        form.count(&mut packed.count, made.required("unless file is given"));
    }
    packed.sizes.keys(form);
    matter.diameter_mean = packed.sizes.mean();
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

/// How grains are made: inserted loosely into the cell, then equilibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// What diameters are drawn from.
    pub sizes: Sizes,
    /// Grains; in a cell with copies those of one.
    pub count: u64,
    /// How they come to bear on each other.
    pub preparation: Preparation,
    /// Friction coefficient while the packing is made.
    pub friction: f64,
    /// Solid volume fraction of the loose start.
    pub fraction_start: f64,
    /// At rest when kinetic energy is below this share of elastic energy.
    pub energy_ratio_max: f64,
    /// Folder of finished packings.
    pub cache: PathBuf,
}

impl Packed {
    pub(super) fn blank(dimension: usize) -> Self {
        Self {
            sizes: Sizes::Normal { mean: 0.0, deviation: 0.0 },
            count: 1,
            preparation: Preparation::COMPRESS,
            friction: 0.0,
            // Inserted without overlap one after the other, discs jam at 0.547, spheres at 0.38.
            fraction_start: if dimension == 2 { 0.45 } else { 0.25 },
            energy_ratio_max: 0.0,
            cache: PathBuf::new(),
        }
    }

    /// The keys of `[packing]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        if form.is_needed() && !form.has("preparation") {
            form.note_table(
                "must say how the grains of grains.count are made. Add preparation = \"compress\" with a stress, or preparation = \"pour\".",
            );
        } else {
            self.preparation.keys(form);
        }
        let (friction, start) = ("friction while the packing is made", "the solid volume fraction of the loose start");
        form.number(
            &mut self.friction,
            number("friction", friction, RATIO, Range::closed(0.0, 5.0), "0.01").or("0.01"),
        );
        let start = number("fraction_start", start, RATIO, Range::closed(0.02, 0.5), "0.25");
        form.number(&mut self.fraction_start, start.follows("0.45 of discs, 0.25 of spheres"));
        rest_and_cache(form, &mut self.energy_ratio_max, &mut self.cache);
    }
}

/// What turns loose grains into a packing: "compress" or "pour".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Preparation {
    /// A cell periodic along every axis is compressed to this mean stress, Pa (compression positive). Frictionless and
    /// hot first where `fraction` asks for more than compression alone reaches. At rest it is let come to the lower stress
    /// `unloaded`, if there is one, Pa.
    Compress {
        /// Pa, compression positive.
        stress: f64,
        /// Solid volume fraction; none: what compression alone comes to.
        fraction: Option<f64>,
        /// Pa, compression positive, less than `stress`; none: it stays under that.
        unloaded: Option<f64>,
    },
    /// Grains fall under the job's gravity onto its bodies.
    Pour,
}

impl Preparation {
    const COMPRESS: Self = Self::Compress { stress: 0.0, fraction: None, unloaded: None };

    fn keys(&mut self, form: &mut dyn Form) {
        let about = "compress a periodic cell without cohesion, or pour onto bodies";
        let kinds = [("compress", Self::COMPRESS), ("pour", Self::Pour)];
        variant(form, self, "preparation", text("preparation", about, "\"compress\""), &kinds, |kind, form| {
            let Self::Compress { stress, fraction, unloaded } = kind else { return };
            let about = "the mean stress that the packing is compressed to, compression positive";
            form.number(stress, number("stress", about, STRESS, POSITIVE, "\"100 kPa\""));
            let about = "the solid volume fraction to be reached; where compression stops short, by a hot start: grains in random motion, without friction";
            form.number_if_given(
                fraction,
                number("fraction", about, RATIO, Range::closed(0.3, 0.92), "0.85").optional(),
            );
            let about = "a lower mean stress that the packing comes to once it is compressed";
            form.number_if_given(unloaded, number("unloaded", about, STRESS, POSITIVE, "\"2 kPa\"").optional());
        });
    }
}

/// Diameters, m.
#[derive(Clone, Debug, PartialEq)]
pub enum Sizes {
    /// Normal, cut at three deviations.
    Normal {
        /// m.
        mean: f64,
        /// Standard deviation, before the cut, m.
        deviation: f64,
    },
    /// All diameters between two are as likely, by number.
    Uniform {
        /// m.
        min: f64,
        /// m; no less than `min`.
        max: f64,
    },
    /// Diameters with their shares of the number of grains, which add up to 1.
    List(Vec<(f64, f64)>),
}

impl Sizes {
    /// Those of `[grains]` that tell diameters.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let kinds = [
            ("normal", Self::Normal { mean: 0.0, deviation: 0.0 }),
            ("uniform", Self::Uniform { min: 0.0, max: 0.0 }),
            ("list", Self::List(Vec::new())),
        ];
        let key = text("distribution", "how diameters are spread: normal, uniform or list", "\"normal\"").or("normal");
        variant(form, self, "distribution", key, &kinds, |sizes, form| match sizes {
            Self::Normal { mean, deviation } => {
                form.number(mean, number("diameter_mean", "the mean diameter", LENGTH, POSITIVE, "\"1 mm\""));
                let about = "the standard deviation of diameters";
                form.number(deviation, number("diameter_deviation", about, LENGTH, NOT_NEGATIVE, "\"0.08 mm\""));
            }
            Self::Uniform { min, max } => {
                form.number(min, number("diameter_min", "the smallest diameter", LENGTH, POSITIVE, "\"6 mm\""));
                form.number(max, number("diameter_max", "the largest diameter", LENGTH, POSITIVE, "\"14 mm\""));
            }
            Self::List(list) => {
                let about = "diameters with their shares of the number of grains";
                form.shares(list, key_of_shares("diameters", about));
            }
        });
    }
}

fn key_of_shares(name: &'static str, about: &'static str) -> Key {
    key(name, about, Wants::Shares, "[[\"1 mm\", 0.5], [\"2 mm\", 0.5]]")
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
    /// Its columns in the series begin with it.
    pub name: String,
    /// Form and place at the start.
    pub shape: Shape,
    /// Path, sine and servo.
    pub motion: Motion,
}

impl Body {
    pub(super) const BLANK: Self = Self {
        name: String::new(),
        shape: Shape::Box { lower: [0.0; 3], upper: [0.0; 3] },
        motion: Motion { path: Vec::new(), oscillation: None, servo: None },
    };

    /// The key of a job that has bodies.
    pub(super) fn list(bodies: &mut Vec<Self>, form: &mut dyn Form) {
        let key = key("body", "rigid bodies among the grains", Wants::Text, "[]").optional();
        list(form, bodies, key, "a rigid body", &Self::BLANK, |body, form| {
            body.keys(form, true);
            body.motion.keys(form);
        });
    }

    /// What it is called and its shape. A layer is made of grains.
    pub(super) fn keys(&mut self, form: &mut dyn Form, among_grains: bool) {
        form.text(&mut self.name, text("name", "the body's name", "\"lid\""));
        let kinds = Shape::kinds();
        let kinds = &kinds[..if among_grains { 4 } else { 3 }];
        variant(form, &mut self.shape, "shape", text("shape", "the body's shape", "\"plane\""), kinds, Shape::keys);
    }
}

/// Form and place of a body at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Half space below a plane: through `point`, with the unit `normal` towards the grains.
    Plane {
        /// Any of the plane, m.
        point: [f64; 3],
        /// Outward, of length 1.
        normal: [f64; 3],
    },
    /// A solid box with edges along the axes.
    Box {
        /// m.
        lower: [f64; 3],
        /// m.
        upper: [f64; 3],
    },
    /// A solid disc, or in three dimensions a cylinder without end along `axis`.
    Cylinder {
        /// Of the disc, or any point of the axis, m.
        centre: [f64; 3],
        /// m.
        radius: f64,
        /// Of length 1; z in the plane.
        axis: [f64; 3],
    },
    /// The grains of the start whose centres lie in this box, glued together: a rough layer.
    Layer {
        /// m.
        lower: [f64; 3],
        /// m.
        upper: [f64; 3],
    },
}

impl Shape {
    fn kinds() -> [(&'static str, Self); 4] {
        let [lower, upper, point, normal, centre, axis] = [[0.0; 3]; 6];
        [
            ("plane", Self::Plane { point, normal }),
            ("box", Self::Box { lower, upper }),
            ("cylinder", Self::Cylinder { centre, radius: 0.0, axis }),
            ("layer", Self::Layer { lower, upper }),
        ]
    }

    fn keys(&mut self, form: &mut dyn Form) {
        match self {
            Self::Plane { point, normal } => {
                form.vector(point, vector("point", "a point of the plane", LENGTH, "\"0 cm\""));
                form.vector(
                    normal,
                    vector("normal", "the direction from the plane towards what it holds", RATIO, "1.0"),
                );
            }
            Self::Box { lower, upper } | Self::Layer { lower, upper } => corners(form, lower, upper),
            Self::Cylinder { centre, radius, axis } => {
                form.vector(centre, vector("centre", "the centre, or a point of the axis", LENGTH, "\"1 cm\""));
                form.number(radius, number("radius", "the radius", LENGTH, POSITIVE, "\"5 mm\""));
                if form.axes() == 3 || form.describes() {
                    form.vector(axis, vector("axis", "the direction of the cylinder", RATIO, "1.0"));
                    return;
                }
                *axis = [0.0, 0.0, 1.0];
                if form.has("axis") {
                    form.note(
                        "axis",
                        "belongs to space = \"solid\"; in the plane a cylinder is a disc. Remove the line.",
                    );
                }
            }
        }
    }
}

/// Two corners of a box.
pub(super) fn corners(form: &mut dyn Form, lower: &mut [f64; 3], upper: &mut [f64; 3]) {
    form.vector(lower, vector("lower", "the lower corner", LENGTH, "\"1 cm\""));
    form.vector(upper, vector("upper", "the upper corner", LENGTH, "\"2 cm\""));
}
