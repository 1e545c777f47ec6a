//! Files and folders: the calls this crate makes of the operating system, each with an error that names the path.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// Turns a refusal into an error that says what was tried on which path.
pub(crate) fn refused(action: &'static str, path: &Path) -> impl Fn(io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::System { action, path: path.clone(), source }
}

/// The folder of a file; for a bare name the current one.
pub(crate) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// What a file's name ends in before it is whole.
pub(crate) const PARTIAL: &str = ".partial";

/// Makes the file's bytes outlast a power cut.
pub(crate) fn sync(path: &Path) -> Result<(), Error> {
    File::open(path).and_then(|file| file.sync_all()).map_err(refused("write to disk", path))
}

/// Lets `write` make a file aside and, once it is whole and on disk, gives it its name. On an error whatever had that
/// name is as it was. The order makes all of it outlast a power cut: bytes first, then the name, then the folder's
/// entry.
pub(crate) fn write_aside(path: &Path, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Error> {
    let mut name = path.as_os_str().to_owned();
    name.push(PARTIAL);
    let partial = PathBuf::from(name);
    let written = write(&partial)
        .and_then(|()| sync(&partial))
        .and_then(|()| fs::rename(&partial, path).map_err(refused("name", path)));
    if written.is_err() {
        // Half a file is of no use to anyone, and its space may be what is missing. It may well not exist.
        let _ = fs::remove_file(&partial);
    }
    written?;
    sync(folder(path))
}
