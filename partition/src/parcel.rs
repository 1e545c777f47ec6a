//! Rows in flight: little-endian bytes, sealed against loss and damage.
//!
//! A sealed parcel is its content followed by six u64: rows, sender and receiver, number of the
//! exchange, length of the content in bytes, checksum of all that, and a magic word. The seal comes
//! last so that sealing moves nothing.

use crate::checksum::checksum;
use std::fmt::{self, Display, Formatter};
use thiserror::Error;

const MAGIC: u64 = u64::from_le_bytes(*b"scree/p2");
const SEAL_BYTES: usize = 6 * 8;
/// Bytes of the seal that the checksum covers.
const SUMMED_BYTES: usize = 4 * 8;

/// Where a parcel goes: both ranks, and the exchange it belongs to, which all ranks count alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Route {
    /// Rank that seals it.
    pub sender: u32,
    /// Rank that opens it.
    pub receiver: u32,
    /// Number of the exchange.
    pub number: u64,
}

impl Display for Route {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "number {} from rank {} to rank {}", self.number, self.sender, self.receiver)
    }
}

/// What is wrong with a parcel. Any of these means damage in flight or two ranks that disagree:
/// rows would be lost, so the run must stop.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ParcelError {
    /// There is not even room for a seal.
    #[error("{bytes} bytes are too few for a sealed parcel")]
    TooShort {
        /// Bytes that arrived.
        bytes: usize,
    },
    /// These bytes do not end as a parcel does.
    #[error("the bytes do not end with a parcel's seal")]
    Unsealed,
    /// Bytes were lost or added.
    #[error("the parcel holds {found} bytes, its seal says {sealed}")]
    Length {
        /// Bytes the seal promises.
        sealed: u64,
        /// Bytes before the seal.
        found: u64,
    },
    /// Bytes changed.
    #[error("the parcel's checksum is {found:016x}, its seal says {sealed:016x}")]
    Checksum {
        /// Checksum in the seal.
        sealed: u64,
        /// Checksum of what arrived.
        found: u64,
    },
    /// A sound parcel, but another one.
    #[error("this parcel is {found}, and {due} is due: parcels came out of order")]
    Misrouted {
        /// What the seal says.
        found: Route,
        /// What was expected.
        due: Route,
    },
    /// More was asked of the parcel than it holds.
    #[error("{wanted} bytes were read where {left} are left")]
    Exhausted {
        /// Bytes asked for.
        wanted: usize,
        /// Bytes left.
        left: usize,
    },
    /// Less was asked of the parcel than it holds.
    #[error("{bytes} bytes were left unread")]
    LeftOver {
        /// Bytes left.
        bytes: usize,
    },
    /// A parcel between two ranks is bad.
    #[error("parcel from rank {sender} to rank {receiver}: {error}")]
    Between {
        /// Rank that sealed it.
        sender: usize,
        /// Rank that opened it.
        receiver: usize,
        /// What is wrong.
        error: Box<ParcelError>,
    },
    /// Every parcel that arrived here is sound, but not everywhere.
    #[error("{parcels} parcels arrived damaged on other ranks, whose messages say more")]
    Elsewhere {
        /// Bad parcels of the whole run.
        parcels: u64,
    },
    /// Sound parcels, yet rows are missing or doubled.
    #[error("all ranks sent {sent} rows in all and received {received}")]
    Rows {
        /// Rows handed over for sending by all ranks.
        sent: i64,
        /// Rows that arrived on all ranks.
        received: i64,
    },
}

/// Packs numbers into bytes.
#[derive(Clone, Debug, Default)]
pub struct Writer {
    bytes: Vec<u8>,
}

/// Unpacks what a [`Writer`] packed, in the same order.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
}

macro_rules! numbers {
    ($($number:ident, $array:ident, $slice:ident;)*) => {
        impl Writer {
            $(
                #[doc = concat!("Packs one `", stringify!($number), "`.")]
                pub fn $number(&mut self, value: $number) {
                    self.bytes.extend_from_slice(&value.to_le_bytes());
                }

                #[doc = concat!("Packs `", stringify!($number), "`s whose number both sides know.")]
                pub fn $array<const N: usize>(&mut self, values: [$number; N]) {
                    for value in values {
                        self.$number(value);
                    }
                }

                #[doc = concat!("Packs `", stringify!($number), "`s after their number.")]
                pub fn $slice(&mut self, values: &[$number]) {
                    self.u64(values.len() as u64);
                    self.bytes.reserve(size_of_val(values));
                    for &value in values {
                        self.$number(value);
                    }
                }
            )*
        }

        impl Reader<'_> {
            $(
                #[doc = concat!("The next `", stringify!($number), "`.\n\n# Errors\nWhen the bytes run out.")]
                pub fn $number(&mut self) -> Result<$number, ParcelError> {
                    self.take().map($number::from_le_bytes)
                }

                #[doc = concat!("The next `N` `", stringify!($number), "`s.\n\n# Errors\nWhen the bytes run out.")]
                pub fn $array<const N: usize>(&mut self) -> Result<[$number; N], ParcelError> {
                    let mut values = [$number::default(); N];
                    for value in &mut values {
                        *value = self.$number()?;
                    }
                    Ok(values)
                }

                #[doc = concat!("The next counted run of `", stringify!($number), "`s.\n\n# Errors\nWhen the bytes run out.")]
                pub fn $slice(&mut self) -> Result<Vec<$number>, ParcelError> {
                    let bytes = self.counted(size_of::<$number>())?;
                    let (values, _) = bytes.as_chunks();
                    Ok(values.iter().map(|value| $number::from_le_bytes(*value)).collect())
                }
            )*
        }
    };
}

numbers! {
    u8, u8_array, u8_slice;
    u32, u32_array, u32_slice;
    u64, u64_array, u64_slice;
    i32, i32_array, i32_slice;
    i64, i64_array, i64_slice;
    f64, f64_array, f64_slice;
}

impl Writer {
    /// A writer that holds nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Bytes packed so far.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes without a seal, for messages whose shape both sides know.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Forgets what was packed and keeps the memory.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Seals the parcel as holding `rows` rows, for whoever opens it.
    pub fn finish(self, rows: u64) -> Vec<u8> {
        self.finish_for(rows, Route::default())
    }

    /// Seals the parcel as holding `rows` rows, for one receiver in one exchange.
    pub fn finish_for(mut self, rows: u64, route: Route) -> Vec<u8> {
        let ranks = u64::from(route.sender) << 32 | u64::from(route.receiver);
        self.u64_array([rows, ranks, route.number, self.bytes.len() as u64]);
        let sum = checksum(&self.bytes);
        self.u64_array([sum, MAGIC]);
        self.bytes
    }
}

impl<'a> Reader<'a> {
    /// Opens a sealed parcel: a reader of its content, and the number of rows it was sealed with.
    ///
    /// # Errors
    /// When the bytes are not a whole, undamaged parcel.
    pub fn open(bytes: &'a [u8]) -> Result<(Self, u64), ParcelError> {
        Self::open_any(bytes).map(|(reader, rows, _)| (reader, rows))
    }

    /// Opens a parcel that was sealed for this route.
    ///
    /// # Errors
    /// When the bytes are not a whole, undamaged parcel, or another one.
    pub fn open_on(bytes: &'a [u8], due: Route) -> Result<(Self, u64), ParcelError> {
        let (reader, rows, found) = Self::open_any(bytes)?;
        if found == due { Ok((reader, rows)) } else { Err(ParcelError::Misrouted { found, due }) }
    }

    fn open_any(bytes: &'a [u8]) -> Result<(Self, u64, Route), ParcelError> {
        let Some(content) = bytes.len().checked_sub(SEAL_BYTES) else {
            return Err(ParcelError::TooShort { bytes: bytes.len() });
        };
        let [rows, ranks, number, length, sum, magic] = Reader::plain(&bytes[content..]).u64_array()?;
        if magic != MAGIC {
            return Err(ParcelError::Unsealed);
        }
        if length != content as u64 {
            return Err(ParcelError::Length { sealed: length, found: content as u64 });
        }
        let found = checksum(&bytes[..content + SUMMED_BYTES]);
        if sum != found {
            return Err(ParcelError::Checksum { sealed: sum, found });
        }
        let route = Route { sender: (ranks >> 32) as u32, receiver: ranks as u32, number };
        Ok((Self::plain(&bytes[..content]), rows, route))
    }

    /// A reader of bytes that were not sealed.
    pub fn plain(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// Bytes not yet read.
    pub fn left(&self) -> usize {
        self.bytes.len()
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// When bytes are left, which means that the two sides disagree on what a row is.
    pub fn finish(self) -> Result<(), ParcelError> {
        match self.left() {
            0 => Ok(()),
            bytes => Err(ParcelError::LeftOver { bytes }),
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], ParcelError> {
        let (taken, rest) =
            self.bytes.split_first_chunk().ok_or(ParcelError::Exhausted { wanted: N, left: self.left() })?;
        self.bytes = rest;
        Ok(*taken)
    }

    /// The bytes of a counted run, checked before anything is allocated for it.
    fn counted(&mut self, item_bytes: usize) -> Result<&'a [u8], ParcelError> {
        let count = usize::try_from(self.u64()?).unwrap_or(usize::MAX);
        let wanted = count.saturating_mul(item_bytes);
        let (taken, rest) =
            self.bytes.split_at_checked(wanted).ok_or(ParcelError::Exhausted { wanted, left: self.left() })?;
        self.bytes = rest;
        Ok(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Vec<u8> {
        let mut writer = Writer::new();
        writer.u8(7);
        writer.u32(1 << 31);
        writer.u64(u64::MAX);
        writer.i32(-5);
        writer.i64(i64::MIN);
        writer.f64(-0.0);
        writer.f64_array([1.5, f64::INFINITY]);
        writer.u32_slice(&[3, 4, 5]);
        writer.f64_slice(&[]);
        writer.finish(3)
    }

    #[test]
    fn what_is_packed_is_unpacked() {
        let bytes = sample();
        let (mut reader, rows) = Reader::open(&bytes).unwrap();
        assert_eq!(rows, 3);
        assert_eq!(reader.u8(), Ok(7));
        assert_eq!(reader.u32(), Ok(1 << 31));
        assert_eq!(reader.u64(), Ok(u64::MAX));
        assert_eq!(reader.i32(), Ok(-5));
        assert_eq!(reader.i64(), Ok(i64::MIN));
        assert_eq!(reader.f64().map(f64::to_bits), Ok((-0.0_f64).to_bits()));
        assert_eq!(reader.f64_array(), Ok([1.5, f64::INFINITY]));
        assert_eq!(reader.u32_slice(), Ok(vec![3, 4, 5]));
        assert_eq!(reader.clone().finish(), Err(ParcelError::LeftOver { bytes: 8 }));
        assert_eq!(reader.f64_slice(), Ok(vec![]));
        assert_eq!(reader.u8(), Err(ParcelError::Exhausted { wanted: 1, left: 0 }));
        assert_eq!(reader.finish(), Ok(()));
    }

    #[test]
    fn any_flipped_bit_and_any_lost_byte_is_noticed() {
        let bytes = sample();
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Reader::open(&damaged).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(Reader::open(&bytes[..length]).is_err(), "the first {length} bytes");
            assert!(Reader::open(&bytes[bytes.len() - length..]).is_err(), "the last {length} bytes");
        }
    }

    #[test]
    fn an_impossible_count_is_refused_before_memory_is_asked_for() {
        let mut writer = Writer::new();
        writer.u64(u64::MAX);
        assert_eq!(
            Reader::plain(writer.as_bytes()).f64_slice(),
            Err(ParcelError::Exhausted { wanted: usize::MAX, left: 0 })
        );
    }

    #[test]
    fn another_exchange_s_parcel_is_not_taken_for_this_one_s() {
        let due = Route { sender: 1, receiver: 2, number: 7 };
        let parcel = |route: Route| Writer::new().finish_for(0, route);
        assert!(Reader::open_on(&parcel(due), due).is_ok());
        for found in [Route { number: 6, ..due }, Route { sender: 3, ..due }, Route { receiver: 0, ..due }] {
            let error = Reader::open_on(&parcel(found), due).unwrap_err();
            assert_eq!(error, ParcelError::Misrouted { found, due });
        }
        let words = Reader::open_on(&parcel(Route { number: 6, ..due }), due).unwrap_err().to_string();
        assert_eq!(
            words,
            "this parcel is number 6 from rank 1 to rank 2, and number 7 from rank 1 to rank 2 is due: parcels came out of order"
        );
    }
}
