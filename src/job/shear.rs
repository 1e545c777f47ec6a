//! Planar shear of a specimen between rough plates (Chen et al. 2021, section 6).

use std::path::{Path, PathBuf};

use super::document;
use super::mpm::Material;
use super::output::Output;
use super::schema::section;
use super::write::Page;
use super::{Job, Method};
use crate::base::error::Error;
use crate::base::keys::{
    DAMPING, DENSITY, Form, Key, LENGTH, MASS, NOT_NEGATIVE, POSITIVE, RATIO, Range, SPEED, STRESS, TIME, Table, Wants,
    choose, count, key, number, size, text, vector,
};
use crate::couple::oracle::{Laplacian, Oracle};
use crate::couple::zone::Enrichment;
use crate::law::contact::Contact;
use crate::law::material::{ConstitutiveLaw, CriticalConstants};
use crate::mpm::nonlocal::Nonlocal;
use crate::mpm::penalty::Coupling;
use crate::mpm::scheme::Scheme;

/// The checked job. All quantities in SI units, angles in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Job name; the default run directory is `runs/<name>`.
    pub name: String,
    /// Hybrid, grains alone or points alone.
    pub method: Method,
    /// Seed of every random number of the job.
    pub seed: u64,
    /// Box between the plates.
    pub specimen: Specimen,
    /// Sizes and density, or the file that they are read from.
    pub grains: Grains,
    /// Law between grains.
    pub contact: Contact,
    /// How the grains of the start are packed.
    pub packing: Packing,
    /// Of the continuum; its density is that of the grains at the solid volume fraction of the start, as far as that is known before
    /// the packing is made. The law has none of its own where the packing tells it.
    pub material: Material,
    /// Shape functions, stress update and transfer of points.
    pub scheme: Scheme,
    /// Grid, contact with plates, and the fractions that points begin with.
    pub continuum: Continuum,
    /// What the upper plate does.
    pub loading: Loading,
    /// How a shear band is detected.
    pub oracle: Oracle,
    /// Penalty springs of grains that share nodes with points.
    pub coupling: Coupling,
    /// How grains take the place of points around a band.
    pub enrichment: Enrichment,
    /// What the continuum's strain is averaged by, if it is.
    pub nonlocal: Option<Nonlocal>,
    /// Steps of grains and of the continuum.
    pub time: Time,
    /// Edge of blocks and reach of neighbour lists.
    pub decomposition: Decomposition,
    /// What is written and when.
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
                "{file}: this job is a continuum, because it has a table [grid] or [mesh], and a job of planar shear is wanted here."
            ))),
        }
    }

    /// Whether grains are simulated at any time: in the run itself, or to make the packing that a continuum starts from.
    pub fn moves_grains(&self) -> bool {
        self.method.has_grains() || self.material.law.fraction().is_none()
    }

    /// Whether all of the specimen is grains at the start.
    pub fn begins_as_grains(&self) -> bool {
        self.method.begins_as_grains(&self.enrichment.life)
    }

    /// The job in SI numbers with nothing left to a default. It parses back to an equal scenario.
    pub fn to_toml(&self) -> String {
        let (mut job, mut page) = (self.clone(), Page::new(2));
        job.head(&mut page);
        page.section("specimen", |page| job.specimen.keys(page));
        page.section("grains", |page| job.grains.keys(page));
        page.section("contact", |page| job.contact.keys(page, 0.0));
        page.section("packing", |page| job.packing.keys(page));
        page.section("loading", |page| job.loading.keys(page));
        page.section("oracle", |page| job.oracle.keys(page, Laplacian::OF_SHEAR));
        page.section("coupling", |page| job.coupling.keys(page));
        page.section("enrichment", |page| job.enrichment.keys(page));
        page.section("zone", |page| job.enrichment.life.keys(page));
        page.section("time", |page| job.time.keys(page));
        page.section("decomposition", |page| job.decomposition.keys(page));
        page.section("output", |page| job.output.keys(page, &mut job.ledger));
        page.section("scheme", |page| job.scheme.keys(page));
        page.section("material", |page| job.material.keys(page, true));
        page.section("continuum", |page| job.continuum.keys(page));
        if let Some(nonlocal) = &mut job.nonlocal {
            page.section("nonlocal", |page| nonlocal.keys(page));
        }
        page.text()
    }

    /// Keys above the first table.
    pub(super) fn head(&mut self, form: &mut dyn Form) {
        form.text(&mut self.name, text("name", "the job's name, also that of its run directory", "\"planar_shear\""));
        Method::keys(
            &mut self.method,
            form,
            "what the specimen is made of: hybrid (points, and grains where a band forms), dem (grains alone) or mpm (points alone); the others are of jobs with [grid] or [mesh]",
        );
        form.count(&mut self.seed, count("seed", "the seed of every random number", (0, i64::MAX as u64), "1").or("1"));
    }

    /// The tables of a job, with all their keys.
    pub(super) fn tables() -> Vec<Table> {
        let mut job = Self::asleep();
        vec![
            section("", "the job itself", |form| job.head(form)),
            section("specimen", "the box of material", |form| job.specimen.keys(form)),
            section("grains", "sizes and matter of the grains", |form| job.grains.keys(form)),
            section("contact", "forces between grains", |form| job.contact.keys(form, 0.0)),
            section("packing", "how the packing is made, without cohesion", |form| job.packing.keys(form)),
            Scheme::table(),
            Material::table(),
            section("continuum", "the grid of the continuum", |form| job.continuum.keys(form)),
            section("loading", "what is done to the specimen", |form| job.loading.keys(form)),
            section("oracle", "shear band detection", |form| job.oracle.keys(form, Laplacian::OF_SHEAR)),
            section("coupling", "how grains are held to nodes that they share with points", |form| {
                job.coupling.keys(form)
            }),
            section("enrichment", "grains for points", |form| job.enrichment.keys(form)),
            section("zone", "what becomes of the grains' zone", |form| job.enrichment.life.keys(form)),
            section("nonlocal", "a mean of strain around every point", |form| Nonlocal::BLANK.clone().keys(form)),
            section("time", "the time step", |form| job.time.keys(form)),
            section("decomposition", "how the domain is cut", |form| job.decomposition.keys(form)),
            section("output", "what is written and when", |form| job.output.keys(form, &mut job.ledger)),
        ]
    }

    /// What a job is before it is read: tables that its method leaves asleep keep the values of Chen et al. (2021).
    pub(super) fn asleep() -> Self {
        Self {
            name: String::new(),
            method: Method::Hybrid,
            seed: 1,
            specimen: Specimen { width: 0.0, height: 0.0, depth: 0.0 },
            grains: Grains { diameter_mean: 0.0, diameter_deviation: 0.0, density: 0.0, file: None },
            contact: Contact::ASLEEP,
            packing: Packing {
                friction: 0.0,
                fraction_start: 0.0,
                stress: 0.0,
                height: None,
                energy_ratio_max: 0.0,
                cache: PathBuf::new(),
            },
            material: Material {
                density: 0.0,
                law: ConstitutiveLaw::CriticalDruckerPrager(CriticalConstants {
                    bulk_modulus: 0.0,
                    shear_modulus: 0.0,
                    ..CriticalConstants::CHEN
                }),
            },
            scheme: Scheme::DEFAULT,
            continuum: Continuum { cell: 0.0, at_face: true, is_heterogeneous: false, weak: Vec::new() },
            loading: Loading {
                stress_normal: 0.0,
                speed: 0.0,
                speed_ramp: 0.0,
                strain_end: 0.0,
                plate_mass: 0.0,
                plate_damping: 0.0,
            },
            oracle: Oracle::DEFAULT,
            coupling: Coupling::DEFAULT,
            enrichment: Enrichment::around(0.0),
            nonlocal: None,
            time: Time { step: 0.0, grain_steps: 1 },
            decomposition: Decomposition { cells_per_block: 0, skin: 0.0 },
            output: Output::default(),
            ledger: false,
        }
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

impl Specimen {
    pub(super) fn keys(&mut self, form: &mut dyn Form) {
        form.number(&mut self.width, number("width", "the period in x", LENGTH, POSITIVE, "\"6 cm\""));
        form.number(&mut self.height, number("height", "the distance of the plates", LENGTH, POSITIVE, "\"12 cm\""));
        let depth = number("depth", "the out-of-plane depth", LENGTH, POSITIVE, "\"1 cm\"");
        form.number(&mut self.depth, depth.or("\"1 cm\""));
    }
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

impl Grains {
    pub(super) fn keys(&mut self, form: &mut dyn Form) {
        let deviation = "the standard deviation of diameters";
        form.number(
            &mut self.diameter_mean,
            number("diameter_mean", "the mean diameter by number, D50 here", LENGTH, POSITIVE, "\"1 mm\""),
        );
        form.number(
            &mut self.diameter_deviation,
            number("diameter_deviation", deviation, LENGTH, NOT_NEGATIVE, "\"0.08 mm\""),
        );
        form.number(
            &mut self.density,
            number(
                "density",
                "the density of the matter of a grain, without pores",
                DENSITY,
                POSITIVE,
                "\"2530 kg/m3\"",
            ),
        );
        form.path_if_given(
            &mut self.file,
            text(
                "file",
                "grains to start from, a CSV file; in place of a packing that the program makes",
                "\"grains.csv\"",
            )
            .optional(),
        );
    }
}

/// How the packing is made: inserted loosely, compressed by the upper plate under low friction and without cohesion, left to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    /// Friction coefficient while the packing is made (Cundall 1989: 0.01).
    pub friction: f64,
    /// Solid volume fraction of the loose start, 0.2 to 0.5.
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

impl Packing {
    /// The keys of `[packing]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let (friction, start) = ("friction while the packing is made", "the solid volume fraction of the loose start");
        form.number(
            &mut self.friction,
            number("friction", friction, RATIO, Range::closed(0.0, 5.0), "0.01").or("0.01"),
        );
        form.number(
            &mut self.fraction_start,
            number("fraction_start", start, RATIO, Range::closed(0.2, 0.5), "0.45").or("0.45"),
        );
        let stress = number("stress", "the normal stress of the packing", STRESS, POSITIVE, "\"400 kPa\"");
        form.number(&mut self.stress, stress.follows("loading.stress_normal"));
        let height = "the height of a packing that only the zone is made of";
        form.number_if_given(&mut self.height, number("height", height, LENGTH, POSITIVE, "\"12 cm\"").optional());
        rest_and_cache(form, &mut self.energy_ratio_max, &mut self.cache);
    }
}

/// When a packing is at rest, and where finished ones are kept.
pub(super) fn rest_and_cache(form: &mut dyn Form, energy_ratio_max: &mut f64, cache: &mut PathBuf) {
    let ratio = "kinetic over elastic energy at rest";
    form.number(
        energy_ratio_max,
        number("energy_ratio_max", ratio, RATIO, Range::closed(1e-12, 0.1), "1e-4").or("1e-4"),
    );
    form.path(cache, text("cache", "the folder of finished packings", "\"cache\"").or("\"cache\""));
}

/// The grid between the plates, and where material starts looser than elsewhere; law and scheme are in tables of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Continuum {
    /// Edge of a grid cell, m.
    pub cell: f64,
    /// Plates meet material points at their own face ([`crate::mpm::faces`]); else they hold the nodes from the one nearest to it on.
    pub at_face: bool,
    /// The solid volume fraction is the packing's from place to place, and not everywhere its mean.
    pub is_heterogeneous: bool,
    /// Regions that start with another solid volume fraction, so that shear has a place to begin (Chen et al. 2021, 6.1).
    pub weak: Vec<WeakRegion>,
}

impl Continuum {
    pub(super) fn keys(&mut self, form: &mut dyn Form) {
        form.number(&mut self.cell, number("cell", "the edge of a grid cell", LENGTH, POSITIVE, "\"7.5 mm\""));
        let about =
            "where points meet the plates: at the nodes that these hold, or at their face, wherever in a cell that is";
        let key_of_place = text("contact_at", about, "\"nodes\"").or("face");
        choose(form, &mut self.at_face, "place of contact", key_of_place, &[("nodes", false), ("face", true)]);
        let about = "whether the solid volume fraction varies from place to place as the packing's does";
        heterogeneity(form, &mut self.is_heterogeneous, about);
        let weak = key("weak", "regions that start looser", Wants::Text, "[]").optional();
        super::schema::list(
            form,
            &mut self.weak,
            weak,
            "a region that starts looser",
            &WeakRegion::BLANK,
            WeakRegion::keys,
        );
    }
}

/// Whether points begin with what the packing has around them.
pub(super) fn heterogeneity(form: &mut dyn Form, is_heterogeneous: &mut bool, about: &'static str) {
    let key = text("heterogeneity", about, "\"packing\"").or("none");
    choose(form, is_heterogeneous, "heterogeneity", key, &[("none", false), ("packing", true)]);
}

/// A rectangle of points whose law starts from a lower solid volume fraction; mass is not changed.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakRegion {
    /// Lower left corner, m from the left edge and above the face of the lower plate.
    pub lower: [f64; 2],
    /// Upper right corner, m.
    pub upper: [f64; 2],
    /// Subtracted from the solid volume fraction there.
    pub fraction_deficit: f64,
}

impl WeakRegion {
    const BLANK: Self = Self { lower: [0.0; 2], upper: [0.0; 2], fraction_deficit: 0.0 };

    fn keys(&mut self, form: &mut dyn Form) {
        plane(form, &mut self.lower, vector("lower", "the lower left corner", LENGTH, "\"5 cm\""));
        plane(form, &mut self.upper, vector("upper", "the upper right corner", LENGTH, "\"6 cm\""));
        let about = "subtracted from the solid volume fraction there";
        form.number(
            &mut self.fraction_deficit,
            number("fraction_deficit", about, RATIO, Range::closed(0.0, 0.3), "0.02"),
        );
    }
}

/// A place in the plane.
pub(super) fn plane(form: &mut dyn Form, value: &mut [f64; 2], key: Key) {
    let mut place = [value[0], value[1], 0.0];
    form.vector(&mut place, key);
    *value = [place[0], place[1]];
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

impl Loading {
    /// The keys of `[loading]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let stress = "the normal stress on the upper plate";
        form.number(&mut self.stress_normal, number("stress_normal", stress, STRESS, POSITIVE, "\"400 kPa\""));
        form.number(
            &mut self.speed,
            number("speed", "the horizontal speed of the upper plate", SPEED, POSITIVE, "\"2 cm/s\""),
        );
        let ramp = "the time over which the speed rises";
        form.number(&mut self.speed_ramp, number("speed_ramp", ramp, TIME, NOT_NEGATIVE, "\"1 ms\""));
        let end = "the horizontal strain that the run ends at";
        form.number(&mut self.strain_end, number("strain_end", end, RATIO, Range::above(0.0, 100.0), "0.57"));
        self.keys_of_plate(form);
    }

    /// Those that follow from the rest of the job by default.
    pub(super) fn keys_of_plate(&mut self, form: &mut dyn Form) {
        let mass = number("plate_mass", "the mass of the upper plate", MASS, POSITIVE, "\"15 g\"");
        form.number(&mut self.plate_mass, mass.follows("that of a layer of grains"));
        let damping = "damping of the plate's vertical motion";
        let damping = number("plate_damping", damping, DAMPING, NOT_NEGATIVE, "\"1000 N s/m\"");
        form.number(
            &mut self.plate_damping,
            damping.follows("a tenth of what is critical for the plate on the specimen"),
        );
    }
}

/// The time step, and how many of grains make one of the continuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Time step of grains, s.
    pub step: f64,
    /// Steps of grains in one of the continuum.
    pub grain_steps: u64,
}

impl Time {
    pub(super) fn keys(&mut self, form: &mut dyn Form) {
        keys_of_step(&mut self.step, form);
        keys_of_subcycling(&mut self.grain_steps, form);
    }
}

/// The time step of whatever moves.
pub(super) fn keys_of_step(step: &mut f64, form: &mut dyn Form) {
    form.number(step, number("step", "the time step", TIME, POSITIVE, "\"0.4 us\"").follows("half of the stable one"));
}

pub(super) fn keys_of_subcycling(grain_steps: &mut u64, form: &mut dyn Form) {
    form.count(grain_steps, count("grain_steps", "steps of grains in one of the continuum", (1, 1000), "8").or("1"));
}

/// How the domain is cut; results do not depend on it (invariant 2), except through `cells_per_block`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decomposition {
    /// Edge of a block in cells.
    pub cells_per_block: usize,
    /// Reach of the neighbour list beyond contact, m.
    pub skin: f64,
}

impl Decomposition {
    pub(super) fn keys(&mut self, form: &mut dyn Form) {
        size(
            form,
            &mut self.cells_per_block,
            count("cells_per_block", "the edge of a block in cells", (2, 64), "2").or("2"),
        );
        skin(form, &mut self.skin);
    }
}

pub(super) fn skin(form: &mut dyn Form, skin: &mut f64) {
    let about = "the reach of the neighbour list beyond contact";
    form.number(skin, number("skin", about, LENGTH, POSITIVE, "\"0.1 mm\"").follows("a tenth of the mean diameter"));
}
