//! `scree export`: a state for other codes.

use std::path::Path;

use super::resume::refuse_no_run;
use crate::base::error::Error;
use crate::base::units::{Dimension, in_short, quantity};
use crate::export::grain_dump::{self, Moment};
use crate::export::grain_export::{self, Wanted};
use crate::export::rve_export;
use crate::export::vtu_export;
use crate::run::results::refuse_existing;
use crate::store::checkpoint;

/// The files to write.
pub(super) struct Files<'a> {
    pub grains: Option<&'a Path>,
    pub contacts: Option<&'a Path>,
    pub dump: Option<&'a Path>,
    /// The folder of frames for older ParaView.
    pub vtu: Option<&'a Path>,
    /// A point, and the file of its RVE.
    pub rve: Option<(&'a str, &'a Path)>,
    /// Whether they may take the place of others.
    pub overwrite: bool,
}

/// `all`: of all frames, and not of the one at a time.
pub(super) fn command(
    dir: &Path,
    files: &Files,
    (at, all): (Option<&str>, bool),
    wanted: Wanted,
) -> Result<String, Error> {
    let [grains, contacts, dump, vtu] =
        [files.grains, files.contacts, files.dump, files.vtu].map(|file| file.is_some());
    if !(grains || contacts || dump || vtu || files.rve.is_some()) {
        return Err(Error::User(
            "There is no file to write. Give --grains FILE.csv (or FILE.data), --contacts FILE.csv, --lammps-dump FILE, --vtu DIR, or --rve POINT and --rve-frame FILE.vtkhdf.".into(),
        ));
    }
    refuse_no_run(dir)?;
    let beside = files.rve.map(|(_, file)| rve_export::beside(file));
    let of_rve = [files.rve.map(|(_, file)| file), beside.as_deref()];
    for file in [files.grains, files.contacts, files.dump].into_iter().chain(of_rve).flatten() {
        refuse_existing(file, files.overwrite)?;
    }
    let at = at.map(time).transpose()?;
    let mut told = String::new();
    if let Some(file) = files.dump {
        let moment = if all { Moment::All } else { at.map_or(Moment::Last, Moment::At) };
        told += &grain_dump::write(dir, file, moment)?;
    }
    if let Some(to) = files.vtu {
        told += &vtu_export::write(dir, to, at.map_or(Moment::All, Moment::At), files.overwrite)?;
    }
    if let Some((point, file)) = files.rve {
        let (state, time) = checkpoint::state_at(dir, at)?;
        let beside = rve_export::write(state, dir, point, file)?;
        told += &format!(
            "The grains of the RVE of point {point} at {} s are in {}, its force chains in {}\n",
            in_short(time),
            file.display(),
            beside.display()
        );
    }
    let Files { grains, contacts, .. } = *files;
    if grains.is_none() && contacts.is_none() {
        return Ok(told);
    }
    let (state, time) = checkpoint::state_at(dir, at)?;
    let time = in_short(time);
    if let Some(file) = grains {
        grain_export::write(&state, dir, file, wanted)?;
        told += &format!("The grains at {time} s are in {}\n", file.display());
    }
    if let Some(file) = contacts {
        grain_export::write_contacts(&state, dir, file)?;
        told += &format!("The contacts at {time} s are in {}\n", file.display());
    }
    Ok(told)
}

/// Seconds, or a time with its unit.
fn time(text: &str) -> Result<f64, Error> {
    let plain = text.parse().ok();
    plain.or_else(|| quantity(text, Dimension::TIME).ok()).filter(|time: &f64| time.is_finite()).ok_or_else(|| {
        Error::User(format!(
            "--at {text} is not a time. Write seconds or a unit, for example --at 0.02 or --at \"20 ms\"."
        ))
    })
}
