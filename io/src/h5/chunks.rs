//! Chunks as they lie in a file, compressed and with their sums, taken to another file as they are. To compress the same
//! numbers again would cost ten times as much.
//!
//! The `hdf5` crate has no such calls, so those of the library are made here. They are given handles of datasets that are
//! borrowed, hence open, and places of as many numbers as the dataset has axes; the library is not entered by two threads at
//! once, as the crate sees to for its own calls.

use hdf5::Dataset;
use hdf5_sys::h5::{herr_t, hsize_t};
use hdf5_sys::h5d::{H5Dread_chunk1, H5Dwrite_chunk};
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5p::H5P_DEFAULT;

unsafe extern "C" {
    /// Of the library since 1.10.2, as the two above; the bindings lack it.
    fn H5Dget_chunk_storage_size(dataset: hid_t, place: *const hsize_t, bytes: *mut hsize_t) -> herr_t;
}

/// Makes the chunk that begins with `row` what it is in another dataset of the same shape and type, where it was written.
pub(crate) fn copy_chunk(from: &Dataset, to: &Dataset, row: usize) -> hdf5::Result<()> {
    assert_eq!(from.ndim(), to.ndim(), "datasets of other axes");
    let mut place: Vec<hsize_t> = vec![0; from.ndim()];
    place[0] = row as hsize_t;
    hdf5::sync::sync(|| {
        let mut bytes: hsize_t = 0;
        // SAFETY: the handle is open, `place` has a number for each axis, and `bytes` outlives the call.
        check(unsafe { H5Dget_chunk_storage_size(from.id(), place.as_ptr(), &mut bytes) })?;
        let mut chunk = vec![0_u8; bytes as usize];
        let mut filters_skipped = 0;
        let buffer = chunk.as_mut_ptr().cast();
        // SAFETY: as above, and the buffer has room for the bytes that the library has just said the chunk takes.
        check(unsafe { H5Dread_chunk1(from.id(), H5P_DEFAULT, place.as_ptr(), &mut filters_skipped, buffer) })?;
        let buffer = chunk.as_ptr().cast();
        // SAFETY: as above, and the buffer has as many bytes as are to be written.
        check(unsafe { H5Dwrite_chunk(to.id(), H5P_DEFAULT, filters_skipped, place.as_ptr(), chunk.len(), buffer) })
    })
}

fn check(returned: herr_t) -> hdf5::Result<()> {
    if returned < 0 { Err(hdf5::Error::query()?) } else { Ok(()) }
}
