//! Files and folders: the calls this crate makes of the operating system, each with an error that names the path.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

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

/// Of a file in the making beside its name nobody knows whose it is; one to which nothing was written for that long is nobody's.
const FORGOTTEN: Duration = Duration::from_secs(24 * 3600);

/// What the names of files in the making begin with.
pub(crate) fn dotted(name: Option<&OsStr>) -> OsString {
    let mut name = name.unwrap_or_default().to_owned();
    name.push(".");
    name
}

/// Makes the file's bytes outlast a power cut.
pub(crate) fn sync(path: &Path) -> Result<(), Error> {
    File::open(path).and_then(|file| file.sync_all()).map_err(refused("write to disk", path))
}

/// A file in the making under another name than it is to have. Whatever has that name stays as it is until [`Aside::name`];
/// dropped before, nothing is left of the new file: half a file is of no use to anyone, and its space may be what is
/// missing.
///
/// No two files in the making have one name, whichever processes make them: two that wrote the same file at once would
/// otherwise spoil each other's.
#[derive(Debug)]
pub(crate) struct Aside {
    path: PathBuf,
    partial: PathBuf,
    is_named: bool,
}

impl Aside {
    /// A file beside the name that it is to have. What others left there of it who were killed is removed.
    pub(crate) fn of(path: &Path) -> Result<Aside, Error> {
        clear(folder(path), &dotted(path.file_name()), FORGOTTEN);
        Aside::within(folder(path), path)
    }

    /// A file in the folder `scratch`, which must be on the file system of `path`.
    pub(crate) fn within(scratch: &Path, path: &Path) -> Result<Aside, Error> {
        let create = |partial: &Path| File::options().write(true).create_new(true).open(partial).map(|_| ());
        Aside::made_by(create, scratch, path).map_err(|(partial, error)| refused("create", &partial)(error))
    }

    /// The file that `make` gives a name of its own; it must refuse a name that is taken.
    fn made_by(
        make: impl Fn(&Path) -> io::Result<()>,
        scratch: &Path,
        path: &Path,
    ) -> Result<Aside, (PathBuf, io::Error)> {
        static MADE: AtomicU64 = AtomicU64::new(0);
        loop {
            let mut name = dotted(path.file_name());
            name.push(format!("{}-{}{PARTIAL}", std::process::id(), MADE.fetch_add(1, Ordering::Relaxed)));
            let partial = scratch.join(name);
            match make(&partial) {
                Ok(()) => return Ok(Aside { path: path.to_owned(), partial, is_named: false }),
                // Another machine on this file system may have a process of the same number.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err((partial, error)),
            }
        }
    }

    /// One at a place of the caller's choice.
    #[cfg(test)]
    pub(crate) fn at(path: &Path, partial: &Path) -> Aside {
        Aside { path: path.to_owned(), partial: partial.to_owned(), is_named: false }
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

    /// Gives the file its name as [`Aside::name`] does, and returns the one that had it until then as one in the making;
    /// none where files cannot have two names. The name stands for a whole file throughout.
    pub(crate) fn exchange(self) -> Result<Option<Aside>, Error> {
        let link = |partial: &Path| fs::hard_link(&self.path, partial);
        let before = Aside::made_by(link, folder(&self.partial), &self.path).ok();
        self.name()?;
        Ok(before)
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

/// A file that nobody else has: by another name, as copies of links are, or open, as far as readers lock what they open.
/// This crate's do, and the HDF5 library does for others unless it is told not to. They are kept out for as long as this lives.
#[derive(Debug)]
pub(crate) struct Alone {
    /// None where the file system has no locks.
    _lock: Option<File>,
}

impl Alone {
    /// None if somebody else has the file.
    pub(crate) fn with(path: &Path) -> Result<Option<Alone>, Error> {
        let file = File::options().read(true).write(true).open(path).map_err(refused("open", path))?;
        if file.metadata().map_err(refused("look at", path))?.nlink() > 1 {
            return Ok(None);
        }
        Ok(match file.try_lock() {
            Ok(()) => Some(Alone { _lock: Some(file) }),
            Err(TryLockError::WouldBlock) => None,
            Err(TryLockError::Error(_)) => Some(Alone { _lock: None }),
        })
    }
}

/// Opens a file by `open`. As long as what is returned with it lives, no [`Alone`] writer changes the file.
pub(crate) fn shared<T>(path: &Path, open: impl Fn() -> Result<T, Error>) -> Result<(T, File), Error> {
    let inode = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    loop {
        let lock = File::open(path).map_err(refused("open", path))?;
        // Where there are no locks nothing can be done about it.
        let _ = lock.try_lock_shared();
        let opened = open();
        // Otherwise another file has taken the name meanwhile, and this one may be changed already.
        if lock.metadata().ok().map(inode) == fs::metadata(path).ok().map(inode) {
            return Ok((opened?, lock));
        }
    }
}

/// Lets `write` make a file aside and, once it is whole and on disk, gives it its name. On an error whatever had that
/// name is as it was.
pub(crate) fn write_aside(aside: Aside, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Error> {
    write(aside.partial())?;
    aside.name()
}

/// Removes files in the making whose names begin like this and to which nobody has written for so long: those who made them
/// are gone. What cannot be removed does no harm.
pub(crate) fn clear(scratch: &Path, beginning: &OsStr, untouched: Duration) {
    let is_one = |entry: &fs::DirEntry| -> Option<bool> {
        let name = entry.file_name();
        let is_named = name.to_str()?.starts_with(beginning.to_str()?) && name.to_str()?.ends_with(PARTIAL);
        Some(is_named && entry.metadata().ok()?.modified().ok()?.elapsed().unwrap_or_default() >= untouched)
    };
    for entry in fs::read_dir(scratch).into_iter().flatten().flatten() {
        if is_one(&entry) == Some(true) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
