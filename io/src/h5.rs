//! The HDF5 library behind one door: how files are opened, how datasets are laid out, what its errors mean.

mod chunks;

use std::fs;
use std::io;
use std::path::Path;

use hdf5::file::FileCloseDegree;
use hdf5::plist::group_create::{LinkCreationOrder, LinkPhaseChange};
use hdf5::types::{FixedUnicode, FloatSize, IntSize, TypeDescriptor};
use hdf5::{Dataset, File, FileBuilder, Group, Location};

pub(crate) use chunks::copy_chunk;

use crate::column::Kind;
use crate::error::Error;
use crate::system::refused;

/// Bytes in a chunk at most: it is compressed and checked as a whole, and fits the library's cache.
const CHUNK_BYTES_MAX: usize = 1 << 20;

/// Bytes of the longest text that is kept as an attribute: HDF5 bounds attributes.
pub(crate) const TEXT_BYTES_MAX: usize = 1024;

/// Groups keep their links in their header however many there are. The library would move more than eight to a heap, and
/// when it finds that heap damaged it frees what it never had, and the program dies.
const COMPACT: LinkPhaseChange = LinkPhaseChange { max_compact: 65_535, min_dense: 65_535 };

/// The most that compression shrinks by: deflate writes at least one byte for 1,032.
const SHRINKS_MAX: u128 = 1040;

/// Options for every file. The format is the one whose metadata all carry checksums. Locks are off: cluster file
/// systems may have none, and a viewer that holds a frame file open must not stop a run.
fn options() -> FileBuilder {
    let mut builder = File::with_options();
    builder.with_fapl(|access| access.libver_v110().file_locking(false).fclose_degree(FileCloseDegree::Strong));
    // Times would make equal states unequal files; creation order keeps tables and columns in the caller's order.
    builder.with_fcpl(|create| create.obj_track_times(false).link_creation_order(LinkCreationOrder::Indexed));
    builder
}

/// Creates (or empties) a file. The system is asked first, because it gives the better reason.
pub(crate) fn create(path: &Path) -> Result<File, Error> {
    fs::File::create(path).map_err(refused("create", path))?;
    options().create(path).map_err(|error| explain("create", path, &error))
}

/// Opens a file for reading, or for writing as well.
pub(crate) fn open(path: &Path, write: bool) -> Result<File, Error> {
    fs::OpenOptions::new().read(true).write(write).open(path).map_err(refused("open", path))?;
    let builder = options();
    let opened = if write { builder.open_rw(path) } else { builder.open(path) };
    opened.map_err(|error| opening_error(path, &error))
}

/// Writes what the library still holds and closes the file. Without it a late failure would pass unseen.
pub(crate) fn close(file: File, path: &Path) -> Result<(), Error> {
    file.flush().map_err(|error| explain("write", path, &error))?;
    file.close().map_err(|error| explain("close", path, &error))
}

pub(crate) fn create_group(parent: &Group, name: &str) -> hdf5::Result<Group> {
    parent
        .create_group_builder()
        .obj_track_times(false)
        .with_gcpl(|create| create.link_creation_order(LinkCreationOrder::Indexed).link_phase_change(COMPACT))
        .create(name)
}

/// Names of a group's members in the order of their creation.
pub(crate) fn members(group: &Group) -> hdf5::Result<Vec<String>> {
    group.member_names_by(hdf5::IndexType::CreationOrder, hdf5::IterationOrder::Increasing)
}

/// Keeps a text as an attribute, of fixed length: the library keeps text of variable length without a checksum. It pads with
/// zeros, so the text must have none.
pub(crate) fn write_text(of: &Location, key: &str, text: &str) -> hdf5::Result<()> {
    match text.len() {
        0..=64 => write_text_of::<64>(of, key, text),
        // What fields are, in words: every file of frames has some twenty.
        65..=128 => write_text_of::<128>(of, key, text),
        _ => write_text_of::<TEXT_BYTES_MAX>(of, key, text),
    }
}

fn write_text_of<const N: usize>(of: &Location, key: &str, text: &str) -> hdf5::Result<()> {
    let text: FixedUnicode<N> = text.parse().map_err(|error| format!("attribute {key}: {error}"))?;
    of.new_attr::<FixedUnicode<N>>().create(key)?.write_scalar(&text)
}

/// The text that is an attribute.
pub(crate) fn read_text(of: &Location, key: &str, path: &Path) -> Result<String, Error> {
    let part = || format!("attribute \"{key}\"");
    let text = of.attr(key).and_then(|attribute| attribute.read_scalar::<FixedUnicode<TEXT_BYTES_MAX>>());
    let text = text.map_err(|error| damaged(path, part, &error))?;
    String::from_utf8(text.as_bytes().to_vec()).map_err(|error| {
        let (path, reason) = (path.to_owned(), error.to_string());
        Error::Damaged { path, part: part(), reason }
    })
}

/// Rows per chunk for rows of that many bytes, when about `rows` are to be held.
pub(crate) fn chunk_rows(rows: usize, row_bytes: usize) -> usize {
    rows.clamp(1, (CHUNK_BYTES_MAX / row_bytes).max(1))
}

/// The type of a dataset's values, if it is one of ours.
pub(crate) fn kind(dataset: &Dataset) -> hdf5::Result<Option<Kind>> {
    Ok(match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::Float(FloatSize::U8) => Some(Kind::F64),
        TypeDescriptor::Integer(IntSize::U8) => Some(Kind::I64),
        TypeDescriptor::Unsigned(IntSize::U8) => Some(Kind::U64),
        TypeDescriptor::Unsigned(IntSize::U1) => Some(Kind::U8),
        _ => None,
    })
}

/// Why the dataset cannot be what a file of so many bytes holds, before anything is made for its values.
pub(crate) fn too_large(dataset: &Dataset, file_bytes: u64) -> Option<String> {
    let shape = dataset.shape();
    let values = shape.iter().fold(1_u128, |product, &length| product.saturating_mul(length as u128));
    // Of bytes at least, and a scalar is in every file.
    (values > (u128::from(file_bytes) * SHRINKS_MAX).max(8))
        .then(|| format!("it claims {shape:?} values, more than a file of {file_bytes} bytes can hold"))
}

/// An error met while doing `action`: the operating system's own, if the library passes one on.
pub(crate) fn explain(action: &'static str, path: &Path, error: &hdf5::Error) -> Error {
    match system_error(error) {
        Some(source) => Error::System { action, path: path.to_owned(), source },
        None => Error::Library { action, path: path.to_owned(), reason: reason(error) },
    }
}

/// An error met while reading a part of the file that `part` names.
pub(crate) fn damaged(path: &Path, part: impl FnOnce() -> String, error: &hdf5::Error) -> Error {
    match system_error(error) {
        Some(source) => Error::System { action: "read", path: path.to_owned(), source },
        None => Error::Damaged { path: path.to_owned(), part: part(), reason: reason(error) },
    }
}

fn opening_error(path: &Path, error: &hdf5::Error) -> Error {
    if let Some(source) = system_error(error) {
        return Error::System { action: "open", path: path.to_owned(), source };
    }
    let path = path.to_owned();
    let bytes = fs::metadata(&path).map_or(0, |metadata| metadata.len());
    let reason = reason(error);
    if bytes == 0 {
        return Error::Truncated { path, bytes, reason: "the file is empty".to_owned() };
    }
    if reason.contains("truncated file") {
        return Error::Truncated { path, bytes, reason };
    }
    if error.contains_minor(hdf5::MinorErrorCode::NotHdf5) {
        return Error::Foreign { path, bytes, expected: "an HDF5 file", reason };
    }
    Error::Damaged { path, part: "its header".to_owned(), reason }
}

/// What the library was doing where it failed first: the innermost frame of its stack.
fn reason(error: &hdf5::Error) -> String {
    match error.stack() {
        Some(stack) => stack.last().map_or_else(|| "no reason".to_owned(), |frame| frame.desc().to_owned()),
        None => error.to_string(),
    }
}

/// The library passes the system's errors on only as text, "errno = 28".
fn system_error(error: &hdf5::Error) -> Option<io::Error> {
    let stack = error.stack()?;
    let number = stack.iter().find_map(|frame| {
        let (_, rest) = frame.desc().split_once("errno = ")?;
        rest.split(|character: char| !character.is_ascii_digit()).next()?.parse().ok()
    })?;
    (number != 0).then(|| io::Error::from_raw_os_error(number))
}
