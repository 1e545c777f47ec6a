//! What can go wrong with a file, told to the operator: which file, what was found, what to do.

use std::io;
use std::path::PathBuf;

/// Every way in which this crate fails. A message stands alone: it names the file, the finding and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused; its own reason is given.
    #[error("cannot {action} {path}: {source}{}", remedy(source))]
    System {
        /// What was tried, as a verb: "open".
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system gave as the reason.
        source: io::Error,
    },

    /// The HDF5 library failed for a reason that is none of the others.
    #[error("cannot {action} {path}: the HDF5 library says: {reason}")]
    Library {
        /// What was tried, as a verb: "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The innermost message of the library.
        reason: String,
    },

    /// Not a file of this kind at all.
    #[error("{path} ({bytes} bytes) is not {expected}: {reason}; give a file that this program wrote")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Size of the file.
        bytes: u64,
        /// What it should be, with its article: "a checkpoint".
        expected: &'static str,
        /// What it lacks, or what the library says.
        reason: String,
    },

    /// The end of the file is missing.
    #[error(
        "{path} is cut short: {bytes} bytes are there ({reason}); copy it again from its origin or take an older file"
    )]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Size of the file.
        bytes: u64,
        /// What is missing, or what the library says.
        reason: String,
    },

    /// Written by another version of the program.
    #[error(
        "{path} has schema version {found}, this program reads versions {oldest} to {newest}; use the program version that wrote it"
    )]
    Schema {
        /// The file.
        path: PathBuf,
        /// Version in the file.
        found: u64,
        /// Oldest version that is read.
        oldest: u64,
        /// Version that is written.
        newest: u64,
    },

    /// A checksum or the file's structure is broken at a place that can be named.
    #[error("{path} is damaged in {part}: {reason}; copy it again from its origin or take an older file")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The place in words: a table, a column, an attribute.
        part: String,
        /// What is wrong there, or what the library says.
        reason: String,
    },

    /// Every part could be read, yet together they are not what was written.
    #[error(
        "{path} is damaged: {what} of what was read is {found}, stored is {stored}; copy it again from its origin or take an older file"
    )]
    Digest {
        /// The file.
        path: PathBuf,
        /// Which sum differs: "the digest" or "the seal".
        what: &'static str,
        /// The sum that the file carries.
        stored: String,
        /// The sum of what was read.
        found: String,
    },

    /// There is no checkpoint to go on from.
    #[error("{dir} has no checkpoint (step-<12 digits>.h5); check the folder, or start the run anew")]
    NoCheckpoint {
        /// The folder.
        dir: PathBuf,
    },

    /// There are checkpoints, none of them usable.
    #[error("{dir} has {} checkpoints and all are damaged; restore one from a backup:\n{}", damaged.len(), lines(damaged))]
    AllDamaged {
        /// The folder.
        dir: PathBuf,
        /// Why each is of no use, newest first.
        damaged: Vec<Error>,
    },

    /// A table was asked for that the state has not.
    #[error("the state has no table \"{table}\" (tables: {present}); it was written by another kind of run")]
    NoTable {
        /// The name asked for.
        table: String,
        /// Names that there are, parted by commas, or "none".
        present: String,
    },

    /// An attribute was asked for that the state has not.
    #[error(
        "the state has no attribute \"{attribute}\" (attributes: {present}); it was written by another kind of run"
    )]
    NoAttribute {
        /// The name asked for.
        attribute: String,
        /// Names that there are, parted by commas, or "none".
        present: String,
    },

    /// A column was asked for that its table has not.
    #[error("table \"{table}\" has no column \"{column}\" (columns: {present}); it was written by another kind of run")]
    NoColumn {
        /// The table looked in.
        table: String,
        /// The name asked for.
        column: String,
        /// Names that there are, parted by commas, or "none".
        present: String,
    },

    /// A column was asked for with another width or type than it has.
    #[error(
        "column \"{column}\" of table \"{table}\" has {found} per row, expected {expected}; it was written by another kind of run"
    )]
    ColumnShape {
        /// The table looked in.
        table: String,
        /// The name asked for.
        column: String,
        /// Width and type that it has: `3 x f64`.
        found: String,
        /// Width and type asked for: `3 x f64`.
        expected: String,
    },

    /// A frame whose fields are not those of the file's first frame.
    #[error(
        "cannot append to {path}: the frame has the fields [{found}], the file has [{expected}]; write to a new file"
    )]
    FrameFields {
        /// The file.
        path: PathBuf,
        /// Fields of the frame.
        found: String,
        /// Fields of the file.
        expected: String,
    },

    /// A frame was asked for that is not there.
    #[error("{path} holds {found} frames, {expected} are needed; resume from an older checkpoint, or move it aside")]
    TooFewFrames {
        /// The first part.
        path: PathBuf,
        /// Frames that there are, of all parts.
        found: usize,
        /// Frames that there must be at least.
        expected: usize,
    },

    /// A series with other columns.
    #[error(
        "{path} has the header \"{found}\", expected \"{expected}\"; resume with the scenario that wrote it, or move it aside"
    )]
    SeriesHeader {
        /// The file.
        path: PathBuf,
        /// The first line, empty where there is none.
        found: String,
        /// Names of the columns, parted by commas.
        expected: String,
    },

    /// A series whose rows are others than those that were written.
    #[error(
        "{path}: its first {rows} rows are not those that were written; put back a copy of the file, or remove the newest checkpoints to have the rows after an older one made again"
    )]
    SeriesChanged {
        /// The file.
        path: PathBuf,
        /// Rows that were compared.
        rows: usize,
    },

    /// A series that ends before the row where the run goes on.
    #[error(
        "{path} holds {found} whole rows, {expected} are needed; resume from an older checkpoint, or move it aside"
    )]
    TooFewRows {
        /// The file.
        path: PathBuf,
        /// Rows that there are and end their line.
        found: usize,
        /// Rows that there must be at least.
        expected: usize,
    },

    /// A line of a series that is not a row of numbers.
    #[error("{path}, line {line}: \"{found}\" is not {expected}; mend or remove the line")]
    SeriesRow {
        /// The file.
        path: PathBuf,
        /// Counted from 1, the header with it.
        line: usize,
        /// The line, its first 200 characters.
        found: String,
        /// What it should be: "a row of 3 numbers".
        expected: String,
    },

    /// A mesh that cannot be read, or is of elements that this program has not.
    #[error("{path}, line {line}: {what}")]
    Mesh {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong there and what to do.
        what: String,
    },
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
