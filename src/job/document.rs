//! A job of any kind.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::raw::Typed;
use super::schema::Kind;
use super::{Assembly, Mpm, Output, Scenario, derived, figures, resolve};
use crate::base::error::Error;

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
        Ok(Self::load_typed(path, sets)?.0)
    }

    /// The same with what was typed, for refusals by who sees more than the job itself, such as the files that it names.
    pub fn load_typed(path: &Path, sets: &[String]) -> Result<(Self, Typed), Error> {
        let file = path.display().to_string();
        let typed = Typed::parse(&read(path)?, &file, sets)?;
        Ok((Self::of_typed(&typed)?, typed))
    }

    /// The same from text; `file` names it in messages, and relative paths in it start from its folder.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<Self, Error> {
        Self::of_typed(&Typed::parse(text, file, sets)?)
    }

    fn of_typed(typed: &Typed) -> Result<Self, Error> {
        typed.settled(match typed.kind {
            Kind::Shear => resolve::scenario(typed).map(Self::Shear),
            Kind::Assembly => resolve::assembly(typed).map(Self::Assembly),
            Kind::Mpm => resolve::mpm(typed).map(Self::Mpm),
        })
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

    /// Steps of the whole run.
    pub fn steps(&self) -> u64 {
        match self {
            Self::Shear(scenario) => derived::steps(scenario),
            Self::Assembly(_) | Self::Mpm(_) => figures::steps(self.end(), self.step()),
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

    /// The same with what planar shear means in the tables of a job on a grid, in comments.
    pub fn expanded(&self) -> String {
        let mut text = self.to_toml();
        if let Some(shear) = self.as_shear().filter(|shear| shear.method.has_points()) {
            if self.is_told_by_packing() && shear.material.law.yields() {
                let assumed = derived::FRACTION_DENSE;
                text.push_str(&format!("\n# The packing tells the solid volume fraction; it is not made yet, and {assumed} stands for it below."));
            }
            text.push_str("\n# The continuum between its plates in the tables of a job on a grid, which runs as one without these marks:\n#\n");
            text.extend(
                shear.lowered().to_toml().lines().map(|line| format!("# {line}").trim_end().to_string() + "\n"),
            );
        }
        text
    }
}

/// Bytes of the longest job that is read: hundreds of times the longest that is written by hand.
const BYTES_MAX: u64 = 1 << 20;

/// The text of a job file, and no more of it than a job may have.
pub(super) fn read(path: &Path) -> Result<String, Error> {
    let shown = path.display();
    let unreadable = |error: &dyn std::fmt::Display| {
        Error::User(format!(
            "{shown}: this job cannot be read: {error}. Give the path of a job, for example jobs/quickstart.toml."
        ))
    };
    if path.is_dir() {
        return Err(unreadable(&"it is a folder"));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| unreadable(&error))?;
    file.take(BYTES_MAX + 1).read_to_end(&mut bytes).map_err(|error| unreadable(&error))?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(unreadable(&format!("it is longer than {BYTES_MAX} bytes, and no job is")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
        let byte = error.as_bytes()[good.len()];
        Error::User(format!(
            "{shown}:{line}: this is not text: byte 0x{byte:02x} is no UTF-8. Save the job as UTF-8, or give the path of a job, for example jobs/quickstart.toml."
        ))
    })
}
