//! The material of the continuum: in the job's table `[material]`, or in a file that it names, which holds such a table with the law
//! and its constants, and nothing else.

use std::sync::LazyLock;

use crate::base::error::Error;
use crate::base::keys::{Form, Key, text};
use crate::job::document::read;
use crate::job::raw::{Reader, Typed};
use crate::job::schema::Kind;

const TABLE: &str = "material";
/// What of this table is the job's own.
const OF_THE_JOB: [&str; 4] = ["file", "density", "fraction", "heterogeneity"];
const LAW: &str = "law";

/// What makes the material, and may stand in a file of its own: the keys of all laws.
static KEYS: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let keys = Kind::Mpm.table(TABLE).keys.iter().map(|key| key.name);
    keys.filter(|name| !OF_THE_JOB.contains(name)).collect()
});

/// A file of a material.
pub struct File(Typed);

/// The key that names such a file.
pub const FILE: Key = {
    let about = "a file with the law and its constants, in place of them; scree calibrate writes one";
    text("file", about, "\"calibrated.toml\"").optional()
};

impl File {
    /// The file that the job's table names, if it does.
    pub fn of(job: &Reader<'_>) -> Result<Option<Self>, Error> {
        let mut path = None;
        job.clone().path_if_given(&mut path, FILE);
        let Some(path) = path else { return Ok(None) };
        if !path.is_file() {
            let problem = format!(
                "names no file of a material: there is none at {}. Give a path that starts from the job's folder, for example file = \"materials/chen_table_2.toml\", or remove the key and write the material here.",
                path.display()
            );
            return Err(job.refusal("file", &problem));
        }
        let typed = Typed::parse(&read(&path)?, &path.display().to_string(), &[])?;
        typed.note_all_but(TABLE, &KEYS, "a file of a material");
        typed.stop_if_wrong()?;
        let file = Self(typed);
        file.refuse_twice(job)?;
        Ok(Some(file))
    }

    pub fn table(&self) -> Reader<'_> {
        self.0.table(TABLE, true, "a file of a material")
    }

    pub fn stop_if_wrong(&self) -> Result<(), Error> {
        self.0.stop_if_wrong()
    }

    /// Of a key that stands in both nobody could tell which is meant, unless it was given on the command line. The law may: what
    /// follows says more to people where it stands.
    fn refuse_twice(&self, job: &Reader<'_>) -> Result<(), Error> {
        let same_law = job.word(LAW) == self.table().word(LAW);
        for key in KEYS.iter().filter(|key| !(same_law && **key == LAW)) {
            match self.0.place_of(TABLE, key) {
                Some(place) if job.has(key) && !job.is_set(key) => {
                    let problem = format!(
                        "stands in {place} as well, the file that material.file names. Remove one of the two; to override the file once, use --set."
                    );
                    return Err(job.refusal(key, &problem));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A law that is added to the list has its keys here.
    #[test]
    fn files_hold_the_keys_of_every_law() {
        for key in ["law", "young_modulus", "softening_rate", "hardening_strain", "cohesion"] {
            assert!(KEYS.contains(&key), "{key}");
        }
        assert!(OF_THE_JOB.iter().all(|key| Kind::Mpm.table(TABLE).key(key).is_some() && !KEYS.contains(key)));
    }
}
