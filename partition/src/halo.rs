//! The layer of ghosts round what a rank owns, renewed every step.

use crate::transport::Transport;
use std::mem;
use std::ops::{AddAssign, Range};

/// Which rows travel to whom, and where the rows that come in land. Fixed between rebuilds.
///
/// Rank `a` must list `b` under `sends` with as many rows as `b` lists for `a` under `receives`;
/// both know the order of the rows, so only their content travels. Each peer appears at most once
/// in either list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Halo {
    /// Peer, and my rows in the order sent.
    pub sends: Vec<(usize, Vec<u32>)>,
    /// Peer, and the rows where what it sends lands.
    pub receives: Vec<(usize, Range<u32>)>,
}

/// Memory for the messages of a halo, kept from step to step.
#[derive(Debug, Default)]
pub struct HaloBuffers {
    outgoing: Vec<Vec<u8>>,
    incoming: Vec<Vec<u8>>,
    /// Always empty between calls: kept for their capacity only.
    send_list: Vec<(usize, &'static [u8])>,
    receive_list: Vec<(usize, &'static mut [u8])>,
}

impl HaloBuffers {
    /// Memory that the messages take, bytes.
    pub fn bytes(&self) -> usize {
        self.outgoing.iter().chain(&self.incoming).map(Vec::capacity).sum()
    }
}

/// What one renewal of a halo sends from this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HaloCounts {
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
}

impl AddAssign for HaloCounts {
    fn add_assign(&mut self, more: Self) {
        self.messages += more.messages;
        self.bytes += more.bytes;
    }
}

impl Halo {
    /// Renews the ghosts with one message per peer: `pack` reads my row, `unpack` writes the ghost
    /// row, `meanwhile` runs once while the messages travel.
    ///
    /// Nothing is allocated once `buffers` have grown to the halo's size. When the three closures
    /// need the same rows, call [`pack`](Self::pack), [`exchange`](Self::exchange) and
    /// [`unpack`](Self::unpack) in turn instead.
    pub fn refresh<const W: usize>(
        &self,
        transport: &dyn Transport,
        buffers: &mut HaloBuffers,
        pack: impl Fn(u32) -> [f64; W],
        unpack: impl FnMut(u32, [f64; W]),
        meanwhile: &mut dyn FnMut(),
    ) {
        self.pack(buffers, pack);
        self.exchange::<W>(transport, buffers, meanwhile);
        self.unpack(buffers, unpack);
    }

    /// Writes the rows to be sent into `buffers`.
    pub fn pack<const W: usize>(&self, buffers: &mut HaloBuffers, pack: impl Fn(u32) -> [f64; W]) {
        buffers.outgoing.resize_with(self.sends.len(), Vec::new);
        for (bytes, (_, rows)) in buffers.outgoing.iter_mut().zip(&self.sends) {
            bytes.resize(rows.len() * row_bytes::<W>(), 0);
            let (values, _) = bytes.as_chunks_mut();
            let (values, _) = values.as_chunks_mut::<W>();
            for (values, &row) in values.iter_mut().zip(rows) {
                *values = pack(row).map(f64::to_le_bytes);
            }
        }
    }

    /// Sends what [`pack`](Self::pack) wrote and receives what the peers packed; `meanwhile` runs
    /// once in between.
    ///
    /// # Panics
    /// When `buffers` were not packed for this halo with rows of `W` numbers.
    pub fn exchange<const W: usize>(
        &self,
        transport: &dyn Transport,
        buffers: &mut HaloBuffers,
        meanwhile: &mut dyn FnMut(),
    ) {
        let HaloBuffers { outgoing, incoming, send_list, receive_list } = buffers;
        assert_eq!(outgoing.len(), self.sends.len(), "the halo was not packed");
        incoming.resize_with(self.receives.len(), Vec::new);

        let mut sends: Vec<(usize, &[u8])> = recycled(mem::take(send_list));
        for (bytes, (peer, rows)) in outgoing.iter().zip(&self.sends) {
            assert_eq!(bytes.len(), rows.len() * row_bytes::<W>(), "the halo was packed with rows of another width");
            sends.push((*peer, bytes));
        }
        let mut receives: Vec<(usize, &mut [u8])> = recycled(mem::take(receive_list));
        for (bytes, (peer, rows)) in incoming.iter_mut().zip(&self.receives) {
            bytes.resize(rows.len() * row_bytes::<W>(), 0);
            receives.push((*peer, bytes));
        }
        transport.exchange(&sends, &mut receives, meanwhile);
        *send_list = recycled(sends);
        *receive_list = recycled(receives);
    }

    /// Reads what came in, peer by peer in the order listed, row by row.
    ///
    /// # Panics
    /// When `buffers` were not exchanged for this halo with rows of `W` numbers.
    pub fn unpack<const W: usize>(&self, buffers: &HaloBuffers, mut unpack: impl FnMut(u32, [f64; W])) {
        assert_eq!(buffers.incoming.len(), self.receives.len(), "the halo was not exchanged");
        for (bytes, (_, rows)) in buffers.incoming.iter().zip(&self.receives) {
            assert_eq!(bytes.len(), rows.len() * row_bytes::<W>(), "the halo was exchanged with rows of another width");
            let (values, _) = bytes.as_chunks();
            let (values, _) = values.as_chunks::<W>();
            for (row, values) in rows.clone().zip(values) {
                unpack(row, values.map(f64::from_le_bytes));
            }
        }
    }

    /// Messages and bytes that one renewal with rows of `W` numbers sends from this rank.
    pub fn counts<const W: usize>(&self) -> HaloCounts {
        let rows: usize = self.sends.iter().map(|(_, rows)| rows.len()).sum();
        HaloCounts { messages: self.sends.len() as u64, bytes: (rows * row_bytes::<W>()) as u64 }
    }
}

const fn row_bytes<const W: usize>() -> usize {
    const { assert!(W > 0, "a row must hold a number") };
    W * size_of::<f64>()
}

/// An empty list with the memory of `list`. The two types differ in a lifetime only, so collecting
/// in place moves nothing and allocates nothing, and the borrows of one step do not outlive it.
fn recycled<From, To>(mut list: Vec<From>) -> Vec<To> {
    list.clear();
    list.into_iter().map(|_| unreachable!("the list was cleared")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::threads;

    /// Each rank owns rows 0..4 and keeps ghosts of its two neighbours' rows 3 and 0, in a ring,
    /// from row 4 on.
    fn ring(rank: usize, size: usize) -> Halo {
        let (before, after) = ((rank + size - 1) % size, (rank + 1) % size);
        Halo { sends: vec![(before, vec![0, 2]), (after, vec![3, 1])], receives: vec![(before, 4..6), (after, 6..8)] }
    }

    #[test]
    fn ghosts_take_the_owners_values_and_memory_is_kept() {
        for size in 3..5 {
            threads::run(size, |ranks| {
                let rank = ranks.rank();
                let halo = ring(rank, size);
                let mut buffers = HaloBuffers::default();
                let mut memory = None;
                for step in 0..3 {
                    let value = |rank: usize, row: u32| [rank as f64, f64::from(row) + 100.0 * f64::from(step)];
                    let mut ghosts = [[f64::NAN; 2]; 8];
                    let mut ran = 0;
                    let write = |row: u32, values| ghosts[row as usize] = values;
                    halo.refresh(&ranks, &mut buffers, |row| value(rank, row), write, &mut || ran += 1);
                    let (before, after) = ((rank + size - 1) % size, (rank + 1) % size);
                    let expected = [value(before, 3), value(before, 1), value(after, 0), value(after, 2)];
                    assert_eq!(ghosts[4..], expected);
                    assert_eq!(ran, 1);

                    let places = |buffers: &HaloBuffers| {
                        let bytes = buffers.outgoing.iter().chain(&buffers.incoming).map(|bytes| bytes.as_ptr());
                        (bytes.collect::<Vec<_>>(), buffers.send_list.as_ptr(), buffers.receive_list.as_ptr())
                    };
                    let now = places(&buffers);
                    assert_eq!(*memory.get_or_insert_with(|| now.clone()), now);
                }
                assert_eq!(halo.counts::<2>(), HaloCounts { messages: 2, bytes: 4 * 16 });
            });
        }
    }
}
