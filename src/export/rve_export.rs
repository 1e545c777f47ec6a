//! An RVE of a point for pictures: two files of frames, its grains and its force chains.

use std::path::{Path, PathBuf};

use scree_io::column::State;
use scree_io::frames::{Frame, FrameFile};
use scree_partition::Solo;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::job::Job;
use crate::job::mpm::figures::nearest_point;
use crate::observe::fields::MEANINGS;
use crate::observe::rve_frame;
use crate::run::experiment::Setup;
use crate::run::folder::{Scratch, scenario_file};
use crate::run::start::{ForAnySetup, with_setup_of, world_of};
use crate::rve;
use crate::store::checkpoint::{progress_of, scenario_of};

/// Writes the RVE of a point of a state, which is named as in `[[follow]]` or by its id: its grains to `file`, and its contacts to a file
/// beside it, whose path is returned.
pub fn write(state: State, dir: &Path, point: &str, file: &Path) -> Result<PathBuf, Error> {
    let refused = |what: String| Error::User(format!("{}: {what}", dir.display()));
    if file.extension().is_none_or(|extension| extension != "vtkhdf") {
        return Err(Error::User(format!("{}: the name must end in .vtkhdf, which ParaView opens.", file.display())));
    }
    let job = Job::parse(&scenario_of(&state)?, &scenario_file(dir).display().to_string(), &[])?;
    let Some(continuum) = job.as_mpm().filter(|job| job.rves().is_some()) else {
        return Err(refused("this run has no RVEs; it is of another method than mpm_dem and fem_dem".into()));
    };
    let followed = continuum.follow.iter().find(|follow| follow.name == point);
    let nearest = followed.and_then(|follow| nearest_point(continuum, &follow.place));
    let id = nearest.map(|index| continuum.number(index)).or_else(|| point.parse().ok()).ok_or_else(|| {
        let names: Vec<&str> = continuum.follow.iter().map(|follow| follow.name.as_str()).collect();
        refused(format!(
            "--rve {point} is neither a point that is followed ({}) nor the id of one; frames.vtkhdf has the ids.",
            if names.is_empty() { "there is none".to_string() } else { names.join(", ") }
        ))
    })?;
    let time = progress_of(&state)?.step as f64 * job.step();
    let drawn = with_setup_of(&job, Draw { state, id: PointId(id), time })?;
    let [grains, contacts] = drawn.ok_or_else(|| refused(format!("there is no point {id}")))?;
    let beside = beside(file);
    // Both are whole before either takes its name.
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let making = Scratch(folder.join(format!(".scree-rve-{}", std::process::id())));
    let system = |error: std::io::Error| Error::Run(format!("{}: {error}", file.display()));
    std::fs::create_dir(&making.0).map_err(system)?;
    for (frame, name) in [(grains, "grains.vtkhdf"), (contacts, "contacts.vtkhdf")] {
        let made = FrameFile::create(&making.0.join(name), &making.0, &frame, frame.rows(), &[], MEANINGS);
        made.map_err(|error| Error::Run(error.to_string()))?;
    }
    std::fs::rename(making.0.join("grains.vtkhdf"), file).map_err(system)?;
    std::fs::rename(making.0.join("contacts.vtkhdf"), &beside).map_err(system)?;
    Ok(beside)
}

/// Where the force chains go.
pub fn beside(file: &Path) -> PathBuf {
    file.with_extension("contacts.vtkhdf")
}

struct Draw {
    state: State,
    id: PointId,
    time: f64,
}

impl ForAnySetup<Option<[Frame; 2]>> for Draw {
    fn with<J: Setup>(self, job: &J) -> Result<Option<[Frame; 2]>, Error> {
        let (world, _) = world_of(job, Some(self.state), &Solo)?;
        let row = world.continuum.points.cold.iter().position(|cold| cold.id == self.id);
        let scratch = &mut rve::Scratch::default();
        Ok(row.map(|row| {
            let rve = &world.rves[row].rve;
            [rve_frame::grains(rve, self.time, scratch), rve_frame::contacts(rve, self.time, scratch)]
        }))
    }
}
