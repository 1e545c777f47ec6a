//! The material of the continuum: in the job's own table, or in a file that `[continuum] material` or `[material] file` names,
//! which holds these keys and nothing else. A file of the critical-state law has a table `[continuum]`, one of the law with
//! mobilised friction a table `[material]` that says so, for jobs on a grid.

use crate::base::error::Error;
use crate::base::keys::{Form, Key, text};
use crate::job::document::read;
use crate::job::raw::{Reader, Typed};
use crate::job::schema::Kind;

/// What makes the material, and may stand in a file of its own.
pub const KEYS: [&str; 7] = [
    "bulk_modulus",
    "shear_modulus",
    "friction_angle_critical",
    "fraction_critical",
    "dilation_factor",
    "softening_rate",
    "cohesion",
];
const TABLE: &str = "continuum";
/// The same of the law with mobilised friction, in a table of a job on a grid.
const KEYS_MOBILISED: [&str; 12] = [
    "law",
    "bulk_modulus",
    "shear_modulus",
    "shear_modulus_degradation",
    "shear_degradation_strain",
    "friction_angle_critical",
    "fraction_critical",
    "dilation_factor",
    "hardening_strain",
    "hardening_fraction_width",
    "phase_transformation_factor",
    "cohesion",
];
const TABLE_ON_GRID: &str = "material";
/// The law that such a table must name.
const LAW: &str = "mobilised_friction";

/// A file of a material, and what it may hold.
pub struct File {
    typed: Typed,
    table: &'static str,
    keys: &'static [&'static str],
}

impl File {
    pub fn table(&self) -> Reader<'_> {
        self.typed.table(self.table, true, "a file of a material")
    }

    pub fn stop_if_wrong(&self) -> Result<(), Error> {
        self.typed.stop_if_wrong()
    }

    /// Planar shear has the critical-state law alone.
    pub fn refuse_other_law(&self, job: &Reader<'_>, name: &str) -> Result<(), Error> {
        if self.table == TABLE {
            return Ok(());
        }
        let problem = "is a file with a table [material], for jobs on a grid, and the continuum of planar shear has the critical-state law. Give a file with a table [continuum], as scree calibrate writes it without --law.";
        Err(job.refusal(name, problem))
    }
}

/// The key that names such a file.
pub const fn key(name: &'static str) -> Key {
    let about = "a file with the keys from bulk_modulus to cohesion, in place of them; scree calibrate writes one";
    text(name, about, "\"calibrated.toml\"").optional()
}

/// The file that a key of the job's table names, if it does.
pub fn file_of(job: &Reader<'_>, name: &'static str) -> Result<Option<File>, Error> {
    let mut path = None;
    job.clone().path_if_given(&mut path, key(name));
    let Some(path) = path else { return Ok(None) };
    if !path.is_file() {
        let problem = format!(
            "names no file of a material: there is none at {}. Give a path that starts from the job's folder, for example {name} = \"materials/chen_table_2.toml\", or remove the key and write the material here.",
            path.display()
        );
        return Err(job.refusal(name, &problem));
    }
    let typed = Typed::parse_part(&read(&path)?, &path.display().to_string(), TABLE_ON_GRID, Kind::Mpm)?;
    let (table, keys): (_, &[&str]) =
        if typed.kind == Kind::Mpm { (TABLE_ON_GRID, &KEYS_MOBILISED) } else { (TABLE, &KEYS) };
    typed.note_all_but(table, keys, "a file of a material");
    typed.stop_if_wrong()?;
    let file = File { typed, table, keys };
    if table == TABLE_ON_GRID && (!file.table().has("law") || file.table().is_none_of("law", &[LAW])) {
        return Err(file.typed.refusal(
            table,
            "law",
            "is not a law whose material stands in a file with a table [material]. Write law = \"mobilised_friction\"; a file of the critical-state law has a table [continuum] and no law.",
        ));
    }
    Ok(Some(file))
}

/// Of a key that stands in both nobody could tell which is meant, unless it was given on the command line.
pub fn refuse_twice(job: &Reader<'_>, file: &File, name: &str) -> Result<(), Error> {
    for key in file.keys {
        match file.typed.place_of(file.table, key) {
            Some(place) if job.has(key) && !job.is_set(key) => {
                let problem = format!(
                    "stands in {place} as well, the file that {name} names. Remove one of the two; to override the file once, use --set."
                );
                return Err(job.refusal(key, &problem));
            }
            _ => {}
        }
    }
    Ok(())
}
