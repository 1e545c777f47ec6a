//! The frames of a run as `.vtu` files with a `.pvd` that lists them over time, for ParaView before 5.12 and VTK before 9.3: one list for each
//! file of frames that the run has, NAME.pvd and NAME_0000.vtu, NAME_0001.vtu and so on. Of two frames of one time, as at an enrichment, the list has the
//! later one, with which the run went on.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use scree_io::frames;

use super::grain_dump::{Moment, chosen};
use crate::base::error::Error;
use crate::job::Job;
use crate::observe::fields::MEANINGS;
use crate::run::results::{Aside, refuse_existing, unwritable};

const EXTENSION: &str = "vtkhdf";

/// Writes them into the folder `to` and says in words what is there.
pub fn write(dir: &Path, to: &Path, moment: Moment, overwrite: bool) -> Result<String, Error> {
    let job = Job::load(&dir.join("scenario.toml"), &[])?;
    let unreadable = |error: scree_io::Error| Error::User(error.to_string());
    let (mut lists, mut missing) = (Vec::new(), None);
    for path in files_of_frames(dir)? {
        let times = frames::times(&path).map_err(unreadable)?;
        match chosen(&times, moment, (&path, job.step())) {
            Ok(numbers) => lists.push((numbers, path)),
            // Another file may have that time.
            Err(error) => missing = missing.or(Some(error)),
        }
    }
    if lists.is_empty() {
        let nothing = || Error::User(format!("{}: there are no frames yet", dir.display()));
        return Err(missing.unwrap_or_else(nothing));
    }
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    for (numbers, path) in &lists {
        refuse_existing(&to.join(format!("{}.pvd", name(path))), overwrite)?;
        numbers.iter().try_for_each(|number| refuse_existing(&to.join(of_frame(&name(path), *number)), overwrite))?;
    }
    fs::create_dir_all(to).map_err(|error| unwritable(to, &error))?;
    let mut told = String::new();
    for (numbers, path) in lists {
        let attributes = frames::attributes(&path).map_err(unreadable)?;
        let (mut files, count) = (Vec::<(f64, String)>::new(), numbers.len());
        for number in numbers {
            let frame = frames::read_frame(&path, number).map_err(unreadable)?;
            let file = to.join(of_frame(&name(&path), number));
            put(&file, |to| frames::write_vtu(&frame, &attributes, MEANINGS, to))?;
            if files.last().is_some_and(|(time, _)| *time == frame.time) {
                files.pop();
            }
            files.push((frame.time, of_frame(&name(&path), number)));
        }
        let list = to.join(format!("{}.pvd", name(&path)));
        put(&list, |to| to.write_all(frames::pvd(&files).as_bytes()))?;
        told += &format!("{count} frames of {} are in {}\n", name(&path), list.display());
    }
    Ok(told)
}

fn of_frame(name: &str, number: usize) -> String {
    format!("{name}_{number:04}.vtu")
}

fn put(file: &Path, write: impl FnOnce(&mut BufWriter<fs::File>) -> std::io::Result<()>) -> Result<(), Error> {
    let aside = Aside::of(file);
    let made = fs::File::create(aside.partial()).and_then(|made| {
        let mut to = BufWriter::new(made);
        write(&mut to)?;
        to.flush()
    });
    made.map_err(|error| unwritable(file, &error))?;
    aside.name()
}

/// The first parts of all files of frames that the run has, by their names.
fn files_of_frames(dir: &Path) -> Result<Vec<PathBuf>, Error> {
    let unreadable = |error: std::io::Error| Error::User(format!("{}: {error}", dir.display()));
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        // The parts behind the first are frames.2.vtkhdf and so on.
        let is_first = path.file_stem().is_some_and(|stem| Path::new(stem).extension().is_none());
        if is_first && path.extension().is_some_and(|extension| extension == EXTENSION) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
