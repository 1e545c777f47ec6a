//! Grains from a file, and what their contacts remember from another, held to the same bounds as grains of a job before any work is done (invariant 5).
//!
//! Comma-separated values, or where the name ends in `data` or `lmp` a LAMMPS data file.

use std::path::Path;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Mover};
use crate::job::assembly::Read;
use crate::job::stable::Bound;
use crate::job::{Assembly, Scenario, figures};
use crate::prepare::grain_world;
use crate::prepare::loose::{LOWER, UPPER, mass_of};
use crate::prepare::sheared::{cell_of, layout_for};

mod checks;
mod contacts;
pub(crate) mod csv;
mod lammps;
#[cfg(test)]
mod tests;

/// Whether a file's name says that it is a LAMMPS data file.
pub fn is_lammps(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension == "data" || extension == "lmp")
}

/// A file under examination.
#[derive(Clone, Copy)]
struct Source<'a> {
    file: &'a Path,
    /// The key of the job that names it.
    key: &'static str,
}

impl Source<'_> {
    fn bad(&self, line: usize, what: &str) -> Error {
        Error::User(format!("{}:{line}: {what}", self.file.display()))
    }

    /// `of`, `wanted`: what the file holds and what it may be, for the message.
    fn text(&self, of: &str, wanted: &str) -> Result<String, Error> {
        std::fs::read_to_string(self.file).map_err(|error| {
            Error::User(format!(
                "{}: this file {of} cannot be read: {error}. Name {wanted} in {}.",
                self.file.display(),
                self.key
            ))
        })
    }
}

/// A grain as a file gives it.
#[derive(Clone, Debug, PartialEq)]
struct Entry<S: Space> {
    line: usize,
    id: u64,
    position: S::Vector,
    radius: f64,
    velocity: S::Vector,
    spin: S::Spin,
    /// Of a LAMMPS file, in whatever unit.
    density: Option<f64>,
}

/// A whole file.
struct Listing<S: Space> {
    entries: Vec<Entry<S>>,
    /// Of a LAMMPS file.
    bounds: Option<lammps::Bounds>,
}

/// Grains and the cell they start in.
pub type Start<S> = (Vec<GrainRow<S>>, Cell<S>);

impl<S: Space> Listing<S> {
    fn read(source: &Source) -> Result<Self, Error> {
        let text =
            source.text("of grains", "one of comma-separated values (.csv) or a LAMMPS data file (.data, .lmp)")?;
        if is_lammps(source.file) {
            lammps::parse(source, &text)
        } else {
            Ok(Self { entries: csv::parse(source, &text)?, bounds: None })
        }
    }
}

/// Grains of a job between plates in the order of their ids. Centres below y = 0 are glued to the lower plate, centres
/// above `specimen.height` to the upper one.
pub fn read(scenario: &Scenario, file: &Path) -> Result<Vec<GrainRow<Plane>>, Error> {
    let source = Source { file, key: "grains.file" };
    let Listing { mut entries, bounds } = Listing::<Plane>::read(&source)?;
    let (width, height) = (scenario.specimen.width, scenario.specimen.height);
    let cell = cell_of(&layout_for(scenario, height)?);
    if let Some(bounds) = bounds {
        // In y the domain is the continuum's, and grains need only lie in it.
        checks::refuse_other_box(&source, &bounds, &cell, &[0])?;
        checks::refuse_tilts(&source, &bounds)?;
    }
    for entry in &entries {
        let x = entry.position[0];
        if !(0.0..=width).contains(&x) {
            let what = format!("x = {x} m must be at least 0 and at most specimen.width = {width} m");
            return Err(source.bad(entry.line, &what));
        }
        checks::refuse_radius(&source, entry)?;
        checks::refuse_speed(&source, entry, scenario.time.step)?;
    }
    checks::refuse_other_masses(&source, &entries, |radius| mass_of(scenario, radius))?;
    entries.sort_by_key(|entry| entry.id);
    let mover = |y: f64| match (y < 0.0, y > height) {
        (true, _) => Mover::Body(LOWER),
        (_, true) => Mover::Body(UPPER),
        _ => Mover::Free,
    };
    let row = |entry: &Entry<Plane>| row(entry, mass_of(scenario, entry.radius), mover(entry.position[1]));
    let grains: Vec<GrainRow<Plane>> = entries.iter().map(row).collect();
    if !grains.iter().any(|grain| grain.cold.mover == Mover::Free) {
        return Err(
            source.bad(1, "there is no free grain in this file; export one from a run, or remove `grains.file`")
        );
    }
    checks::refuse_repeated_ids(&source, &entries)?;
    checks::refuse_heights(scenario, &source, &entries)?;
    checks::refuse_sizes(scenario, &source, &entries)?;
    checks::refuse_overlaps(&source, &entries, &grains, &cell)?;
    Ok(grains)
}

/// Grains of an assembly in the order of their ids.
pub fn read_assembly<S: Space>(job: &Assembly, file: &Path) -> Result<Vec<GrainRow<S>>, Error> {
    Ok(read_with_cell(job, file)?.0)
}

/// The same, and the cell they start in: the job's, leaning as the box of a LAMMPS file may.
pub fn read_with_cell<S: Space>(job: &Assembly, file: &Path) -> Result<Start<S>, Error> {
    let source = Source { file, key: "grains.file" };
    let Listing { mut entries, bounds } = Listing::<S>::read(&source)?;
    let mut cell = grain_world::cell_of::<S>(job);
    if let Some(bounds) = bounds {
        checks::refuse_other_box(&source, &bounds, &cell, &[0, 1, 2][..S::DIMENSION])?;
        cell = checks::tilted(&source, &bounds, &cell)?;
    }
    let mass = |radius: f64| job.matter.density * S::grain_volume(radius, job.cell.depth);
    for entry in &entries {
        checks::refuse_outside(&source, &cell, entry)?;
        checks::refuse_radius(&source, entry)?;
        checks::refuse_speed(&source, entry, job.step)?;
    }
    if entries.is_empty() {
        return Err(
            source.bad(1, "there is no grain in this file; export one from a run, or make grains by grains.count")
        );
    }
    checks::refuse_other_masses(&source, &entries, mass)?;
    entries.sort_by_key(|entry| entry.id);
    checks::refuse_repeated_ids(&source, &entries)?;
    checks::refuse_sizes_of_assembly(job, &source, &entries)?;
    let grains: Vec<GrainRow<S>> = entries.iter().map(|entry| row(entry, mass(entry.radius), Mover::Free)).collect();
    checks::refuse_overlaps(&source, &entries, &grains, &cell)?;
    checks::refuse_overlaps_with_bodies(job, &source, &entries)?;
    Ok((grains, cell))
}

/// The start of a job whose grains are read, with what their contacts remember.
pub fn read_start<S: Space>(job: &Assembly, read: &Read) -> Result<Start<S>, Error> {
    let (mut grains, cell) = read_with_cell(job, &read.grains)?;
    if let Some(file) = &read.contacts {
        contacts::read(job, &Source { file, key: "grains.contacts" }, &mut grains, &cell)?;
    }
    Ok((grains, cell))
}

/// What bounds the step of grains: of those of their file, where they have one.
pub fn bounds(job: &Assembly) -> Result<Vec<Bound>, Error> {
    let of_file = match (job.source.file(), job.cell.dimension) {
        (None, _) => None,
        (Some(file), 2) => bounds_in::<Plane>(job, file)?,
        (Some(file), _) => bounds_in::<Solid>(job, file)?,
    };
    Ok(of_file.unwrap_or_else(|| figures::bounds(job)))
}

fn bounds_in<S: Space>(job: &Assembly, file: &Path) -> Result<Option<Vec<Bound>>, Error> {
    Ok(checks::bounds_in_cell(job, &Listing::<S>::read(&Source { file, key: "grains.file" })?.entries))
}

/// Refuses what [`read_start`] would refuse, before anything is started.
pub fn refuse_bad(job: &Assembly, read: &Read) -> Result<(), Error> {
    match job.cell.dimension {
        2 => read_start::<Plane>(job, read).map(|_| ()),
        _ => read_start::<Solid>(job, read).map(|_| ()),
    }
}

fn row<S: Space>(entry: &Entry<S>, mass: f64, mover: Mover) -> GrainRow<S> {
    let mut grain = GrainRow::resting(GrainId(entry.id), entry.position, entry.radius, mass, mover);
    grain.hot.velocity = entry.velocity;
    grain.hot.spin = entry.spin;
    grain
}

/// A whole number, as an id is.
fn id(word: &str) -> Result<u64, String> {
    // What comes after stands for bodies.
    const ID_MAX: u64 = u64::MAX / 2;
    let found = word.parse().ok().filter(|id| *id <= ID_MAX);
    found.ok_or_else(|| format!("`{word}` is not an id; whole numbers from 0 on are"))
}

fn number(word: &str) -> Result<f64, String> {
    let found = word.parse().ok().filter(|number: &f64| number.is_finite());
    found.ok_or_else(|| format!("`{word}` is not a finite number"))
}

/// The components that a space has of numbers in the order of the axes; spin components come last.
fn vector<V: Linear>(numbers: &[f64]) -> V {
    let mut vector = V::zero();
    for component in 0..V::COMPONENTS {
        vector[component] = numbers[numbers.len() - V::COMPONENTS + component];
    }
    vector
}
