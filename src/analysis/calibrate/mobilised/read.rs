//! Tests of an earlier calibration, so that a law is fitted again without the grains.
//!
//! Its folder has the tests as jobs beside the data. Where these are not what the job at hand would test, the data are of other
//! tests and refused.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::{KINDS, Kind, Specimen, Tested, Tests, Wanted, elements};
use crate::analysis::calibrate::Subject;
use crate::analysis::calibrate::columns::Columns;
use crate::analysis::calibrate::layers::Profile;
use crate::base::error::Error;
use crate::job::Job;
use crate::job::assembly::{Assembly, Source};

/// The file of a calibration that has everything that was measured.
pub const DATA: &str = "calibration.json";

/// As [`Tests::to_json`] writes it.
#[derive(Deserialize)]
struct Data {
    grains: u64,
    strain: f64,
    packings: Vec<PackingData>,
    packings_held_back: Vec<PackingData>,
}

#[derive(Deserialize)]
struct PackingData {
    seed: u64,
    isotropic: Columns,
    uniaxial: Columns,
    tests: Vec<TestData>,
    tests_without_cohesion: Vec<TestData>,
}

#[derive(Deserialize)]
struct TestData {
    test: String,
    rows: Columns,
    /// Strain of a profile, and the share of each layer.
    layers: Vec<(f64, Vec<f64>)>,
}

impl Tests {
    /// Of the folder of a calibration of these grains.
    pub fn of(folder: &Path, subject: &Subject) -> Result<Self, Error> {
        let refused = |file: &str, problem: &str| {
            Error::User(format!(
                "{}: {problem} --tests takes the folder of a calibration with --law mobilised_friction of the same job and the same --set; leave it out to do the tests anew.",
                folder.join(file).display()
            ))
        };
        let read = |file: &str| {
            fs::read_to_string(folder.join(file)).map_err(|error| refused(file, &format!("cannot be read: {error}.")))
        };
        let data: Data = serde_json::from_str(&read(DATA)?)
            .map_err(|error| refused(DATA, &format!("is not what this version of scree writes: {error}.")))?;
        let wanted = Wanted {
            grains: data.grains,
            packings: data.packings.len() as u64,
            held: data.packings_held_back.len() as u64,
            strain: data.strain,
        };
        for element in elements(subject, wanted, subject.piece.seed) {
            let file = format!("{}.toml", element.name());
            let [then, now] = [told(&read(&file)?, &file)?, told(&element.job()?.to_toml(), &file)?];
            if let Some(unlike) = first_unlike(&then, &now) {
                return Err(refused(&file, &format!("is another test: {unlike}.")));
            }
        }
        let is_dry = subject.piece.contact.without_cohesion() != subject.piece.contact;
        let of = |packings: Vec<PackingData>| -> Option<Vec<Specimen>> {
            packings.into_iter().map(|packing| packing.specimen(subject.axes(), is_dry)).collect()
        };
        let specimens = of(data.packings).filter(|fitted| !fitted.is_empty()).zip(of(data.packings_held_back));
        let specimens = specimens.filter(|(fitted, held)| held.iter().all(|one| one.is_as_long_as(&fitted[0])));
        let specimens = specimens.filter(|(fitted, _)| fitted.iter().all(|one| one.is_as_long_as(&fitted[0])));
        let (fitted, held) = specimens.ok_or_else(|| refused(DATA, "lacks a test, or rows of one."))?;
        let seeds = fitted.iter().chain(&held).map(|specimen| specimen.seed);
        if !seeds.eq(subject.piece.seed..subject.piece.seed + wanted.packings + wanted.held) {
            return Err(refused(DATA, "has packings of other seeds."));
        }
        Ok(Self { wanted, fitted, held })
    }
}

/// A test with every default written out, but for what changes nothing of it: its name, and what is written where.
fn told(text: &str, file: &str) -> Result<String, Error> {
    let job = Job::parse(text, file, &[])?;
    let mut told: Assembly = job.as_assembly().expect("an element test is an assembly").clone();
    told.name = String::new();
    (told.output, told.ledger) = (Default::default(), false);
    if let Source::Packed(packed) = &mut told.source {
        packed.cache.clear();
    }
    Ok(told.to_toml())
}

/// The first line in which two jobs differ.
fn first_unlike(then: &str, now: &str) -> Option<String> {
    let (mut then, mut now) = (then.lines(), now.lines());
    loop {
        match (then.next(), now.next()) {
            (None, None) => return None,
            (a, b) if a == b => {}
            (a, b) => return Some(format!("it has `{}`, this job `{}`", a.unwrap_or(""), b.unwrap_or(""))),
        }
    }
}

impl Specimen {
    /// Whether means over both can be taken row by row.
    fn is_as_long_as(&self, other: &Self) -> bool {
        let lengths =
            |one: &Self| -> Vec<usize> { one.tests.iter().chain(&one.dry).map(|tested| tested.rows.len()).collect() };
        lengths(self) == lengths(other)
    }
}

impl PackingData {
    /// None where a test is missing.
    fn specimen(self, axes: usize, is_dry: bool) -> Option<Specimen> {
        let dry = if is_dry { KINDS.iter().filter(|kind| kind.fitted).count() } else { 0 };
        Some(Specimen {
            axes,
            seed: self.seed,
            isotropic: self.isotropic.rows()?,
            uniaxial: self.uniaxial.rows()?,
            tests: tested(self.tests, KINDS.len())?,
            dry: tested(self.tests_without_cohesion, dry)?,
        })
    }
}

/// The first so many of [`KINDS`].
fn tested(tests: Vec<TestData>, count: usize) -> Option<Vec<Tested>> {
    let is_of = |(test, kind): (&TestData, &Kind)| test.test == kind.words();
    if tests.len() != count || !tests.iter().zip(&KINDS).all(is_of) {
        return None;
    }
    let of = |test: TestData| {
        let profiles = test.layers.into_iter().map(|(strain, shares)| Profile { strain, shares }).collect();
        Some(Tested { rows: test.rows.rows()?, profiles })
    };
    tests.into_iter().map(of).collect()
}
