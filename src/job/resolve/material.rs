//! The material of the continuum: in the job's own `[continuum]`, or in a file that `[continuum] material` names, which
//! holds these keys and nothing else.

use std::path::Path;

use crate::base::error::Error;
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

/// A reader of the keys of the material, wherever they stand.
pub struct Material<'a> {
    job: &'a Reader<'a>,
    file: Option<Typed>,
}

impl<'a> Material<'a> {
    /// `folder` is that of the job, where relative paths start from.
    pub fn of(job: &'a Reader<'a>, folder: &Path) -> Result<Self, Error> {
        let Some(name) = job.text_if_given("material") else { return Ok(Self { job, file: None }) };
        let path = folder.join(name);
        if !path.is_file() {
            let problem = format!(
                "names no file of a material: there is none at {}. Give a path that starts from the job's folder, for example material = \"materials/chen_table_2.toml\", or remove the key and write the material here.",
                path.display()
            );
            return Err(job.refusal("material", &problem));
        }
        let file = Typed::parse(&read(&path)?, &path.display().to_string(), &[])?;
        file.note_all_but(TABLE, &KEYS, "a file of a material");
        let material = Self { job, file: Some(file) };
        KEYS.iter().try_for_each(|key| material.refuse_twice(key))?;
        Ok(material)
    }

    /// Required where the method needs the continuum; elsewhere a value that nothing will look at.
    pub fn number_awake(&self, key: &str, asleep: f64) -> f64 {
        self.in_file(key).unwrap_or_else(|| self.job.number_awake(key, asleep))
    }

    pub fn number_or(&self, key: &str, default: f64) -> f64 {
        self.in_file(key).unwrap_or_else(|| self.job.number_or(key, default))
    }

    /// The file's number, unless `--set` lays another over it.
    fn in_file(&self, key: &str) -> Option<f64> {
        match &self.file {
            Some(file) if !self.job.has(key) => file.table(TABLE, true, "a file of a material").number_if_given(key),
            _ => None,
        }
    }

    /// Mistakes in its file.
    pub fn stop_if_wrong(&self) -> Result<(), Error> {
        self.file.as_ref().map_or(Ok(()), Typed::stop_if_wrong)
    }

    /// Which of the two would be meant nobody could tell.
    fn refuse_twice(&self, key: &str) -> Result<(), Error> {
        let place = self.file.as_ref().and_then(|file| file.place_of(TABLE, key));
        match place {
            Some(place) if self.job.has(key) && !self.job.is_set(key) => Err(self.job.refusal(
                key,
                &format!(
                    "stands in {place} as well, the file that continuum.material names. Remove one of the two; to override the file once, use --set."
                ),
            )),
            _ => Ok(()),
        }
    }
}
