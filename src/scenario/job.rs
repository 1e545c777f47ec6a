//! A job of any kind.

use std::path::Path;

use super::raw::Typed;
use super::schema::Kind;
use super::{Assembly, Mpm, Output, Scenario, resolve, write};
use crate::error::Error;

/// What a job asks for; the table `[cell]` makes it an assembly, `[grid]` a continuum.
#[derive(Clone, Debug, PartialEq)]
pub enum Job {
    /// Planar shear between rough plates: grains, continuum, or both.
    Shear(Scenario),
    /// Grains in a cell.
    Assembly(Assembly),
    /// A continuum of material points on a grid.
    Mpm(Mpm),
}

impl Job {
    /// Reads a job, lays the `key.path=value` overrides over it and checks the whole.
    pub fn load(path: &Path, sets: &[String]) -> Result<Self, Error> {
        Self::parse(&read(path)?, &path.display().to_string(), sets)
    }

    /// The same from text; `file` names it in messages, and relative paths in it start from its folder.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<Self, Error> {
        let typed = Typed::parse(text, file, sets)?;
        match typed.kind {
            Kind::Shear => resolve::scenario(&typed, file).map(Self::Shear),
            Kind::Assembly => resolve::assembly(&typed, file).map(Self::Assembly),
            Kind::Mpm => resolve::mpm(&typed).map(Self::Mpm),
        }
    }

    /// The job's name; the default run directory is `runs/<name>`.
    pub fn name(&self) -> &str {
        match self {
            Self::Shear(scenario) => &scenario.name,
            Self::Assembly(assembly) => &assembly.name,
            Self::Mpm(job) => &job.name,
        }
    }

    /// Time step, s.
    pub fn step(&self) -> f64 {
        match self {
            Self::Shear(scenario) => scenario.time.step,
            Self::Assembly(assembly) => assembly.step,
            Self::Mpm(job) => job.step,
        }
    }

    /// What is written and when.
    pub fn output(&self) -> &Output {
        match self {
            Self::Shear(scenario) => &scenario.output,
            Self::Assembly(assembly) => &assembly.output,
            Self::Mpm(job) => &job.output,
        }
    }

    /// The job in SI numbers with nothing left to a default. It parses back to an equal job.
    pub fn to_toml(&self) -> String {
        match self {
            Self::Shear(scenario) => scenario.to_toml(),
            Self::Assembly(assembly) => assembly.to_toml(),
            Self::Mpm(job) => job.to_toml(),
        }
    }
}

impl Assembly {
    /// The job in SI numbers with nothing left to a default. It parses back to an equal assembly.
    pub fn to_toml(&self) -> String {
        write::assembly(self)
    }
}

impl Mpm {
    /// The job in SI numbers with nothing left to a default. It parses back to an equal continuum.
    pub fn to_toml(&self) -> String {
        write::mpm(self)
    }
}

/// The text of a job file.
pub(super) fn read(path: &Path) -> Result<String, Error> {
    std::fs::read_to_string(path).map_err(|error| {
        Error::User(format!(
            "{}: this job cannot be read: {error}. Give the path of a job, for example jobs/quickstart.toml.",
            path.display()
        ))
    })
}
