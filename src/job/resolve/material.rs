//! The material of the continuum: in the job's own table, or in a file that `[continuum] material` or `[material] file` names,
//! which holds these keys and nothing else.

use crate::base::error::Error;
use crate::base::keys::{Form, Key, text};
use crate::job::document::read;
use crate::job::raw::{Reader, Typed};

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

/// The key that names such a file.
pub const fn key(name: &'static str) -> Key {
    let about = "a file with the keys from bulk_modulus to cohesion, in place of them; scree calibrate writes one";
    text(name, about, "\"calibrated.toml\"").optional()
}

/// The file that a key of the job's table names, if it does.
pub fn file_of(job: &Reader<'_>, name: &'static str) -> Result<Option<Typed>, Error> {
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
    let file = Typed::parse(&read(&path)?, &path.display().to_string(), &[])?;
    file.note_all_but(TABLE, &KEYS, "a file of a material");
    file.stop_if_wrong()?;
    Ok(Some(file))
}

/// Of a key that stands in both nobody could tell which is meant, unless it was given on the command line.
pub fn refuse_twice(job: &Reader<'_>, file: &Typed, name: &str) -> Result<(), Error> {
    for key in KEYS {
        match file.place_of(TABLE, key) {
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
