//! Rows as parcels: how grains and points travel between ranks, and how ranks agree on a failure.

use std::ops::Range;

use scree_partition::{ParcelError, Reader, Route, Transport, Writer, exchange_rows, in_turn};

use crate::base::error::Error;
use crate::base::ids::{GrainId, PointId};
use crate::base::record::{Cargo, FromParcel, Record, ToParcel};
use crate::base::space::{Linear, Space};
use crate::dem::grains::{GrainRow, Mover};
use crate::law::contact::Memory;
use crate::mpm::points::Point;

impl<S: Space> Cargo for GrainRow<S> {
    fn blank() -> Self {
        Self::resting(GrainId(0), S::Vector::zero(), 0.0, 0.0, Mover::Free)
    }
    fn pack_rest(&mut self, to: &mut Writer) {
        self.spring.visit(&mut ToParcel(to));
        to.u64(self.contacts.len() as u64);
        for (partner, memory) in &self.contacts {
            to.u64(partner.0);
            to.u64(memory.words().len() as u64);
            memory.words().iter().for_each(|word| to.f64(*word));
        }
    }
    fn unpack_rest(&mut self, from: &mut Reader) -> Result<(), ParcelError> {
        let mut spring = FromParcel { reader: from, failure: None };
        self.spring.visit(&mut spring);
        spring.failure.map_or(Ok(()), Err)?;
        for _ in 0..from.u64()? {
            let partner = GrainId(from.u64()?);
            let mut memory = Memory::blank(from.u64()? as usize);
            for word in memory.words_mut() {
                *word = from.f64()?;
            }
            self.contacts.push((partner, memory));
        }
        Ok(())
    }
}

impl<S: Space> Cargo for Point<S> {
    fn blank() -> Self {
        Self::resting(PointId(0), S::Vector::zero(), 0.0, 0.0)
    }
}

/// A sealed parcel of rows, for all who want it.
pub fn pack<T: Cargo>(rows: &mut [T]) -> Vec<u8> {
    pack_for(rows, Route::default())
}

fn pack_for<T: Cargo>(rows: &mut [T], route: Route) -> Vec<u8> {
    let mut writer = Writer::new();
    for row in rows.iter_mut() {
        row.visit(&mut ToParcel(&mut writer));
        row.pack_rest(&mut writer);
    }
    writer.finish_for(rows.len() as u64, route)
}

/// The rows of a sealed parcel; no bytes are no rows.
pub fn unpack<T: Cargo>(parcel: &[u8]) -> Result<Vec<T>, ParcelError> {
    if parcel.is_empty() {
        return Ok(Vec::new());
    }
    let (reader, count) = Reader::open(parcel)?;
    read_rows(reader, count)
}

fn read_rows<T: Cargo>(mut reader: Reader, count: u64) -> Result<Vec<T>, ParcelError> {
    let mut rows = Vec::with_capacity(count as usize);
    for _ in 0..count {
        let mut row = T::blank();
        let mut from = FromParcel { reader: &mut reader, failure: None };
        row.visit(&mut from);
        if let Some(failure) = from.failure {
            return Err(failure);
        }
        row.unpack_rest(&mut reader)?;
        rows.push(row);
    }
    reader.finish()?;
    Ok(rows)
}

/// Hands `outgoing[r]` to rank r and returns what came, by sender; all ranks count their exchanges by `number`.
pub fn exchange<T: Cargo>(transport: &dyn Transport, number: u64, outgoing: Vec<Vec<T>>) -> Result<Vec<Vec<T>>, Error> {
    let sender = transport.rank() as u32;
    let parcel = |(receiver, mut rows): (usize, Vec<T>)| match rows.is_empty() {
        true => Vec::new(),
        false => pack_for(&mut rows, Route { sender, receiver: receiver as u32, number }),
    };
    let parcels = outgoing.into_iter().enumerate().map(parcel).collect();
    let incoming = exchange_rows(transport, number, parcels).map_err(|error| Error::Run(error.to_string()))?;
    incoming.iter().map(|parcel| unpack(parcel).map_err(|error| Error::Run(error.to_string()))).collect()
}

/// Rows that are on their way at a time when they go to rank 0 in pieces: some megabytes.
pub const PIECE_ROWS: usize = 16 * 1024;

/// Hands all rows of all ranks in rank order to `take` on rank 0, never more than `together` at a time: `rows` makes
/// some of the `held` rows that are here when it is their turn. Where `take` fails, all ranks return its error.
pub fn stream<T: Cargo>(
    transport: &dyn Transport,
    together: usize,
    held: usize,
    rows: impl Fn(Range<usize>) -> Vec<T>,
    mut take: impl FnMut(Vec<T>) -> Result<(), Error>,
) -> Result<(), Error> {
    let sender = transport.rank() as u32;
    let mut pieces = (0..held).step_by(together).zip(0..);
    let next = || {
        let (start, number) = pieces.next()?;
        let mut piece = rows(start..held.min(start + together));
        Some(pack_for(&mut piece, Route { sender, receiver: 0, number }))
    };
    let mut due = Route::default();
    let outcome = in_turn(transport, next, |sender, parcel| {
        if due.sender != sender as u32 {
            due = Route { sender: sender as u32, ..Route::default() };
        }
        let piece = Reader::open_on(&parcel, due).and_then(|(reader, count)| read_rows(reader, count));
        due.number += 1;
        take(piece.map_err(|error| Error::Run(error.to_string()))?)
    });
    agree(transport, outcome)
}

/// All rows of all ranks in rank order, on rank 0.
pub fn gather<T: Cargo>(transport: &dyn Transport, mut rows: Vec<T>) -> Result<Option<Vec<T>>, Error> {
    // Those of rank 0 are where they are wanted.
    let sent = if transport.rank() == 0 { Vec::new() } else { pack(&mut rows) };
    let Some(parcels) = transport.gather(&sent) else { return Ok(None) };
    for parcel in parcels.iter().skip(1) {
        rows.extend(unpack(parcel).map_err(|error| Error::Run(error.to_string()))?);
    }
    Ok(Some(rows))
}

/// All rows of all ranks in rank order, on every rank.
pub fn gather_everywhere<T: Cargo>(transport: &dyn Transport, mut rows: Vec<T>) -> Result<Vec<T>, Error> {
    let mut all = Vec::new();
    for parcel in transport.all_gather(&pack(&mut rows)) {
        all.extend(unpack(&parcel).map_err(|error| Error::Run(error.to_string()))?);
    }
    Ok(all)
}

/// Rows that rank 0 holds, on every rank.
pub fn broadcast<T: Cargo>(transport: &dyn Transport, mut rows: Vec<T>) -> Result<Vec<T>, Error> {
    let bytes = if transport.rank() == 0 { pack(&mut rows) } else { Vec::new() };
    unpack(&transport.broadcast(bytes)).map_err(|error| Error::Run(error.to_string()))
}

/// Numbers of rank 0, on every rank.
pub fn broadcast_numbers(transport: &dyn Transport, numbers: &[f64]) -> Vec<f64> {
    let bytes = transport.broadcast(numbers.iter().flat_map(|number| number.to_le_bytes()).collect());
    bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().expect("eight bytes"))).collect()
}

/// Ranks agree on the outcome of something each did for itself: where any failed, all return the failure of the lowest.
/// Codes tell whose mistake it was.
pub fn agree<T>(transport: &dyn Transport, outcome: Result<T, Error>) -> Result<T, Error> {
    let mine = match &outcome {
        Ok(_) => Vec::new(),
        Err(error) => [&[error.exit_code()], error.to_string().as_bytes()].concat(),
    };
    let failures = transport.all_gather(&mine);
    let Some(first) = failures.into_iter().find(|failure| !failure.is_empty()) else { return outcome };
    let message = String::from_utf8_lossy(&first[1..]).into_owned();
    Err(if first[0] == 2 { Error::User(message) } else { Error::Run(message) })
}
