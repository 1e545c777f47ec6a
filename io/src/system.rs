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

/// A file in the making beside the name that it is to have. Whatever has that name stays as it is until [`Aside::name`];
/// dropped before, nothing is left of the new file: half a file is of no use to anyone, and its space may be what is
/// missing.
pub(crate) struct Aside {
    path: PathBuf,
    partial: PathBuf,
    is_named: bool,
}

impl Aside {
    pub(crate) fn of(path: &Path) -> Aside {
        let mut name = path.as_os_str().to_owned();
        name.push(PARTIAL);
        Aside { path: path.to_owned(), partial: PathBuf::from(name), is_named: false }
    }

    pub(crate) fn within(scratch: &Path, path: &Path) -> Aside {
        let partial = scratch.join(path.file_name().unwrap_or_default());
        Aside { path: path.to_owned(), partial, is_named: false }
    }

    /// Where the file is made.
    pub(crate) fn partial(&self) -> &Path {
        &self.partial
    }

    /// Gives the whole file its name, once it is on disk. The order makes all of it outlast a power cut: bytes first,
    /// then the name, then the folder's entry.
    pub(crate) fn name(mut self) -> Result<(), Error> {
        sync(&self.partial)?;
        fs::rename(&self.partial, &self.path).map_err(refused("name", &self.path))?;
        self.is_named = true;
        sync(folder(&self.path))
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        if !self.is_named {
            // It may well not exist.
            let _ = fs::remove_file(&self.partial);
        }
    }
}

/// Lets `write` make a file aside and, once it is whole and on disk, gives it its name. On an error whatever had that
/// name is as it was.
pub(crate) fn write_aside(path: &Path, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Error> {
    let aside = Aside::of(path);
    write(aside.partial())?;
    aside.name()
}
