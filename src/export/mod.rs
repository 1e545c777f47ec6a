//! Grains and frames for other programs.

use std::path::Path;

use crate::base::error::Error;
use crate::job::Job;

pub mod grain_dump;
pub mod grain_export;
pub mod rve_export;
pub mod vtu_export;

/// Refuses a run that never has grains.
fn refuse_points_alone(job: &Job, dir: &Path) -> Result<(), Error> {
    match job.method().has_grains() {
        true => Ok(()),
        false => Err(Error::User(format!(
            "{}: this run is a continuum alone and has no grains to export. Its points are in frames.vtkhdf.",
            dir.display()
        ))),
    }
}
