//! The cache of packings: a file for each, named by everything that shaped it, which many runs may want at once.
//!
//! ```text
//! CACHE/packing-<key>.h5              a finished packing
//! CACHE/packing-<key>.making/         one in the making
//!                            lock         held by the process that makes it; others wait for the file
//!                            progress.h5  its last saved state, from which whoever comes next goes on
//! ```
//!
//! Where a file system knows no locks several processes may make the same packing at once. They get the same bits at every
//! step, so it is all the same whose state is saved and whose file gets the name.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use scree_io::column::State;
use scree_io::store;
use scree_partition::Transport;
use sha2::{Digest, Sha256};

use crate::base::error::Error;
use crate::base::program::{self, host, now};
use crate::domain::stop::{self, Wish};
use crate::domain::transfer;
use crate::prepare::making::Making;
use crate::prepare::sheared::on_root;

const LOCK: &str = "lock";
const PROGRESS: &str = "progress.h5";
/// Between two looks at what somebody else makes.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Where a packing is in the cache.
#[derive(Clone, Debug)]
pub struct Place {
    file: PathBuf,
    making: PathBuf,
}

/// A packing that is there, on rank 0, or that is to be made.
pub enum Found<'t, T> {
    /// Read from its file; none on ranks other than 0.
    There(Option<T>),
    /// To be made by this run, by the right that rank 0 holds.
    ToMake(Box<Making<'t>>),
}

fn to_make<T>(making: Making) -> Found<T> {
    Found::ToMake(Box::new(making))
}

/// What rank 0 sees when it looks, in the order of the numbers by which it tells the others.
enum Seen<T> {
    There(T),
    Mine(Held),
    Others,
}

/// The right to make a packing, until it is dropped.
#[derive(Debug)]
pub struct Held {
    place: Place,
    /// Locked, where the file system has locks.
    _lock: File,
}

impl Place {
    /// Of what `key` describes in full, of a `kind` that its file is named by.
    pub fn new(cache: &Path, kind: &str, key: &str) -> Self {
        let digest: String = Sha256::digest(key.as_bytes())[..8].iter().map(|byte| format!("{byte:02x}")).collect();
        let name = format!("{kind}-{digest}");
        Self { file: cache.join(format!("{name}.h5")), making: cache.join(format!("{name}.making")) }
    }

    /// Of the finished packing, whether it is there yet or not.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The packing as `read` makes it of the file, or the right to make it. Waits for another process that makes it. A cache that
    /// cannot be written to is refused here, before any work; a damaged file is told of and made again. Collective.
    pub fn find<'t, T>(
        &self,
        transport: &'t dyn Transport,
        save_every: Duration,
        read: impl Fn(State) -> Result<T, Error>,
    ) -> Result<Found<'t, T>, Error> {
        let mut has_told = false;
        loop {
            let seen = transfer::agree(transport, on_root(transport, || self.look(&read)))?;
            let number = match &seen {
                Some(Seen::There(_)) => 0,
                Some(Seen::Mine(_)) => 1,
                Some(Seen::Others) | None => 2,
            };
            match (transport.broadcast(vec![number])[0], seen) {
                (0, Some(Seen::There(found))) => return Ok(Found::There(Some(found))),
                (0, _) => return Ok(Found::There(None)),
                (1, Some(Seen::Mine(held))) => {
                    return Making::new(transport, Some(held), save_every).map(to_make);
                }
                (1, _) => return Making::new(transport, None, save_every).map(to_make),
                _ => self.wait(transport, &mut has_told)?,
            }
        }
    }

    /// Ranks sleep rather than wait in a message, so that whoever works has the cores.
    fn wait(&self, transport: &dyn Transport, has_told: &mut bool) -> Result<(), Error> {
        if !std::mem::replace(has_told, true) {
            let who = fs::read_to_string(self.making.join(LOCK)).unwrap_or_default();
            tracing::info!("waiting for a packing that {} is making, {}", who.trim(), self.file.display());
        }
        std::thread::sleep(LOOK_EVERY);
        let mut wish = [stop::wish().number()];
        transport.max(&mut wish);
        if Wish::of_number(wish[0]) == Wish::Stop { Err(Error::Stopped(0)) } else { Ok(()) }
    }

    fn look<T>(&self, read: &impl Fn(State) -> Result<T, Error>) -> Result<Seen<T>, Error> {
        if let Some(found) = self.read(read)? {
            // What another process has left behind when it was done.
            if self.making.exists()
                && let Ok(Some(held)) = self.hold()
            {
                held.tidy();
            }
            return Ok(Seen::There(found));
        }
        let Some(held) = self.hold()? else { return Ok(Seen::Others) };
        // It may have been finished meanwhile.
        match self.read(read)? {
            Some(found) => {
                held.tidy();
                Ok(Seen::There(found))
            }
            None => Ok(Seen::Mine(held)),
        }
    }

    /// The file, if it is there and whole.
    fn read<T>(&self, read: &impl Fn(State) -> Result<T, Error>) -> Result<Option<T>, Error> {
        let state = match store::read(&self.file) {
            Ok(state) => state,
            Err(scree_io::Error::System { source, .. }) if is_absent(&source) => return Ok(None),
            Err(error) if error.is_damage() || matches!(error, scree_io::Error::Schema { .. }) => {
                tracing::warn!("warning: {error}; it is made again");
                return Ok(None);
            }
            Err(error) => return Err(Error::User(error.to_string())),
        };
        match read(state) {
            Ok(found) => Ok(Some(found)),
            Err(error) => {
                tracing::warn!("warning: {}: {error}; it is made again", self.file.display());
                Ok(None)
            }
        }
    }

    /// The right to make it, unless another process has that.
    fn hold(&self) -> Result<Option<Held>, Error> {
        let refused = |error: std::io::Error| {
            Error::User(format!(
                "{}: packings cannot be kept there: {error}; set packing.cache to a folder that can be written to",
                self.making.display()
            ))
        };
        fs::create_dir_all(&self.making).map_err(refused)?;
        let path = self.making.join(LOCK);
        let opened = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
        let mut lock = match opened {
            // Whoever was done has just taken the folder away.
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(refused)?,
        };
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => return Ok(None),
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        // Of a file that has been taken away meanwhile a lock says nothing.
        if !is_at(&lock, &path) {
            return Ok(None);
        }
        let who = format!("{} on {}, process {}, since {}\n", program::name(), host(), std::process::id(), now());
        lock.set_len(0).and_then(|()| lock.write_all(who.as_bytes())).map_err(refused)?;
        Ok(Some(Held { place: self.clone(), _lock: lock }))
    }
}

/// The file is not there; whether one can be is found out when it is to be written.
fn is_absent(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

fn is_at(file: &File, path: &Path) -> bool {
    let id = |about: std::io::Result<fs::Metadata>| about.ok().map(|about| (about.dev(), about.ino()));
    id(file.metadata()) == id(fs::metadata(path))
}

impl Held {
    /// Where the state of a packing in the making is saved.
    pub fn progress(&self) -> PathBuf {
        self.place.making.join(PROGRESS)
    }

    /// A folder for files in the making and for what is kept of earlier attempts.
    pub fn folder(&self) -> Result<&Path, Error> {
        let folder = &self.place.making;
        fs::create_dir_all(folder).map_err(|error| Error::Run(format!("{}: {error}", folder.display())))?;
        Ok(folder)
    }

    /// Gives the finished packing its name.
    pub fn finish(self, state: &State) -> Result<(), Error> {
        let written = store::write_in(self.folder()?, &self.place.file, state);
        written.map_err(|error| Error::Run(error.to_string()))?;
        self.tidy();
        Ok(())
    }

    /// What served the making goes; what cannot be removed harms nobody.
    fn tidy(self) {
        let _ = fs::remove_dir_all(&self.place.making);
    }
}
