//! Rows that change their owner.

use crate::parcel::{ParcelError, Reader, Route};
use crate::transport::Transport;

/// Hands `outgoing[r]`, a parcel sealed for rank `r` in exchange `number` or no bytes at all, to rank
/// `r`, and returns what came from each rank, every parcel checked. No bytes mean no rows; skip such entries when opening parcels.
///
/// Collective. Ranks agree on the outcome: either all return parcels, or all return an error, so
/// that none goes on alone with rows missing.
///
/// # Errors
/// When a parcel arrived damaged, here or elsewhere, or when the ranks together received more or
/// fewer rows than they sent.
pub fn exchange_rows(
    transport: &dyn Transport,
    number: u64,
    outgoing: Vec<Vec<u8>>,
) -> Result<Vec<Vec<u8>>, ParcelError> {
    let receiver = transport.rank();
    let mut tally = Tally { number, ..Tally::default() };
    for (to, parcel) in outgoing.iter().enumerate() {
        tally.sent += tally.opened(receiver, to, parcel);
    }
    let incoming = transport.all_to_all(outgoing);
    for (sender, parcel) in incoming.iter().enumerate() {
        tally.received += tally.opened(sender, receiver, parcel);
    }

    let mut totals = [tally.sent, tally.received, tally.bad];
    transport.sum(&mut totals);
    let [sent, received, bad] = totals;
    match tally.first {
        Some(error) => Err(error),
        None if bad > 0 => Err(ParcelError::Elsewhere { parcels: bad.unsigned_abs() }),
        None if sent != received => Err(ParcelError::Rows { sent, received }),
        None => Ok(incoming),
    }
}

#[derive(Default)]
struct Tally {
    number: u64,
    sent: i64,
    received: i64,
    bad: i64,
    first: Option<ParcelError>,
}

impl Tally {
    /// Rows of a parcel; a bad one is remembered and counts none.
    fn opened(&mut self, sender: usize, receiver: usize, parcel: &[u8]) -> i64 {
        if parcel.is_empty() {
            return 0;
        }
        let due = Route { sender: sender as u32, receiver: receiver as u32, number: self.number };
        match Reader::open_on(parcel, due) {
            Ok((_, rows)) => rows as i64,
            Err(error) => {
                self.bad += 1;
                self.first.get_or_insert(ParcelError::Between { sender, receiver, error: Box::new(error) });
                0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parcel::Writer;

    const NUMBER: u64 = 5;
    use crate::transport::{Threads, threads};

    fn parcel(ranks: &Threads, to: usize, rows: u64, number: u64) -> Vec<u8> {
        let mut writer = Writer::new();
        for row in 0..rows {
            writer.u64(row);
        }
        writer.finish_for(rows, Route { sender: ranks.rank() as u32, receiver: to as u32, number })
    }

    #[test]
    fn parcels_arrive_where_they_were_sent() {
        for size in 1..5 {
            threads::run(size, |ranks| {
                // Rank 1 sends nothing to anyone, not even an empty parcel.
                let rows = |from: usize, to: usize| {
                    if from == 1 { 0 } else { (10 * from + to) as u64 }
                };
                let pack = |to| {
                    if ranks.rank() == 1 { Vec::new() } else { parcel(&ranks, to, rows(ranks.rank(), to), NUMBER) }
                };
                let incoming = exchange_rows(&ranks, NUMBER, (0..size).map(pack).collect()).unwrap();
                for (from, bytes) in incoming.iter().enumerate() {
                    assert_eq!(bytes.is_empty(), from == 1);
                    if from != 1 {
                        assert_eq!(Reader::open(bytes).unwrap().1, rows(from, ranks.rank()));
                    }
                }
            });
        }
    }

    #[test]
    fn one_damaged_parcel_is_an_error_on_every_rank() {
        let outcomes = threads::run(3, |ranks| {
            let mut outgoing: Vec<Vec<u8>> = (0..3).map(|to| parcel(&ranks, to, 4, NUMBER)).collect();
            if ranks.rank() == 2 {
                outgoing[0][5] ^= 1;
            }
            exchange_rows(&ranks, NUMBER, outgoing).unwrap_err()
        });
        for rank in [0, 2] {
            assert!(matches!(outcomes[rank], ParcelError::Between { sender: 2, receiver: 0, .. }), "{outcomes:?}");
        }
        // Counted once where it left and once where it arrived.
        assert_eq!(outcomes[1], ParcelError::Elsewhere { parcels: 2 });
    }

    #[test]
    fn a_parcel_of_an_exchange_before_is_an_error_on_every_rank() {
        let outcomes = threads::run(2, |ranks| {
            // Rank 1 hands over what it sealed for the last exchange.
            let number = NUMBER - ranks.rank() as u64;
            let outgoing = (0..2).map(|to| parcel(&ranks, to, 1, number)).collect();
            exchange_rows(&ranks, NUMBER, outgoing).unwrap_err().to_string()
        });
        for words in &outcomes {
            assert!(words.starts_with("parcel from rank 1 to rank "), "{words}");
            assert!(words.ends_with("is due: parcels came out of order"), "{words}");
        }
    }

    #[test]
    fn a_parcel_cut_short_is_an_error_on_every_rank() {
        let outcomes = threads::run(2, |ranks| {
            let mut outgoing: Vec<Vec<u8>> = (0..2).map(|to| parcel(&ranks, to, 4, NUMBER)).collect();
            if ranks.rank() == 0 {
                outgoing[1].truncate(9);
            }
            exchange_rows(&ranks, NUMBER, outgoing).unwrap_err().to_string()
        });
        let cut = "parcel from rank 0 to rank 1: 9 bytes are too few for a sealed parcel";
        assert_eq!(outcomes, [cut, cut]);
    }
}
