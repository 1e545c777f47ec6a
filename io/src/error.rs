//! What can go wrong with a file, told to the operator: which file, what was found, what to do.

use std::io;
use std::path::PathBuf;

/// Every way in which this crate fails. A message stands alone: it names the file, the finding and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused; its own reason is given.
    #[error("cannot {action} {path}: {source}{}", remedy(source))]
    System { action: &'static str, path: PathBuf, source: io::Error },

    /// The HDF5 library failed for a reason that is none of the others.
    #[error("cannot {action} {path}: the HDF5 library says: {reason}")]
    Library { action: &'static str, path: PathBuf, reason: String },

    /// Not a file of this kind at all.
    #[error("{path} ({bytes} bytes) is not {expected}: {reason}; give a file that this program wrote")]
    Foreign { path: PathBuf, bytes: u64, expected: &'static str, reason: String },

    /// The end of the file is missing.
    #[error(
        "{path} is cut short: {bytes} bytes are there ({reason}); copy it again from its origin or take an older file"
    )]
    Truncated { path: PathBuf, bytes: u64, reason: String },

    /// Written by another version of the program.
    #[error(
        "{path} has schema version {found}, this program reads versions {oldest} to {newest}; use the program version that wrote it"
    )]
    Schema { path: PathBuf, found: u64, oldest: u64, newest: u64 },

    /// A checksum or the file's structure is broken at a place that can be named.
    #[error("{path} is damaged in {part}: {reason}; copy it again from its origin or take an older file")]
    Damaged { path: PathBuf, part: String, reason: String },

    /// Every part could be read, yet together they are not what was written.
    #[error(
        "{path} is damaged: {what} of what was read is {found}, stored is {stored}; copy it again from its origin or take an older file"
    )]
    Digest { path: PathBuf, what: &'static str, stored: String, found: String },

    /// There is no checkpoint to go on from.
    #[error("{dir} has no checkpoint (step-<12 digits>.h5); check the folder, or start the run anew")]
    NoCheckpoint { dir: PathBuf },

    /// There are checkpoints, none of them usable.
    #[error("{dir} has {} checkpoints and all are damaged; restore one from a backup:\n{}", damaged.len(), lines(damaged))]
    AllDamaged { dir: PathBuf, damaged: Vec<Error> },

    /// A table was asked for that the state has not.
    #[error("the state has no table \"{table}\" (tables: {present}); it was written by another kind of run")]
    NoTable { table: String, present: String },

    /// An attribute was asked for that the state has not.
    #[error(
        "the state has no attribute \"{attribute}\" (attributes: {present}); it was written by another kind of run"
    )]
    NoAttribute { attribute: String, present: String },

    /// A column was asked for that its table has not.
    #[error("table \"{table}\" has no column \"{column}\" (columns: {present}); it was written by another kind of run")]
    NoColumn { table: String, column: String, present: String },

    /// A column was asked for with another width or type than it has.
    #[error(
        "column \"{column}\" of table \"{table}\" has {found} per row, expected {expected}; it was written by another kind of run"
    )]
    ColumnShape { table: String, column: String, found: String, expected: String },

    /// A frame whose fields are not those of the file's first frame.
    #[error(
        "cannot append to {path}: the frame has the fields [{found}], the file has [{expected}]; write to a new file"
    )]
    FrameFields { path: PathBuf, found: String, expected: String },

    /// A frame was asked for that is not there.
    #[error("{path} holds {found} frames, {expected} are needed; resume from an older checkpoint, or move it aside")]
    TooFewFrames { path: PathBuf, found: usize, expected: usize },

    /// A series with other columns.
    #[error(
        "{path} has the header \"{found}\", expected \"{expected}\"; resume with the scenario that wrote it, or move it aside"
    )]
    SeriesHeader { path: PathBuf, found: String, expected: String },

    /// A series whose rows are others than those that were written.
    #[error(
        "{path}: its first {rows} rows are not those that were written; put back a copy of the file, or remove the newest checkpoints to have the rows after an older one made again"
    )]
    SeriesChanged { path: PathBuf, rows: usize },

    /// A series that ends before the row where the run goes on.
    #[error(
        "{path} holds {found} whole rows, {expected} are needed; resume from an older checkpoint, or move it aside"
    )]
    TooFewRows { path: PathBuf, found: usize, expected: usize },

    /// A line of a series that is not a row of numbers.
    #[error("{path}, line {line}: \"{found}\" is not {expected}; mend or remove the line")]
    SeriesRow { path: PathBuf, line: usize, found: String, expected: String },

    /// A mesh that cannot be read, or is of elements that this program has not.
    #[error("{path}, line {line}: {what}")]
    Mesh { path: PathBuf, line: usize, what: String },
}

impl Error {
    /// Whether the file itself is broken, so that an older one may serve in its place. Refused access and a foreign
    /// schema are not damage: an operator can mend them, and going back unasked would lose work.
    pub fn is_damage(&self) -> bool {
        if let Error::System { source, .. } = self {
            return source.raw_os_error() == Some(MEDIUM_FAILED);
        }
        matches!(self, Error::Foreign { .. } | Error::Truncated { .. } | Error::Damaged { .. } | Error::Digest { .. })
    }
}

/// EIO: the disk itself could not read or write.
const MEDIUM_FAILED: i32 = 5;

/// What to do about a refusal of the operating system, where that can be said.
fn remedy(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; free some space there, then resume from the last good checkpoint"
        }
        io::ErrorKind::PermissionDenied => "; check the owner and the mode of the file and of its folder",
        io::ErrorKind::ReadOnlyFilesystem => "; choose a folder that can be written to",
        io::ErrorKind::NotFound => "; check the path",
        io::ErrorKind::CrossesDevices => "; what is in the making must be on the same file system",
        io::ErrorKind::AlreadyExists => "; move it aside or choose another name",
        _ if source.raw_os_error() == Some(MEDIUM_FAILED) => "; the disk is failing, use another one",
        _ => "",
    }
}

fn lines(errors: &[Error]) -> String {
    errors.iter().map(|error| format!("  {error}")).collect::<Vec<_>>().join("\n")
}
