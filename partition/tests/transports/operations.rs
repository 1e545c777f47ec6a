//! What each operation must do, for any transport and any number of ranks.

use scree_partition::{ExactSum, Halo, HaloBuffers, Reader, Route, Transport, Writer, exchange_rows, in_turn};

/// Runs every operation, twice, so that whatever one leaves behind would disturb the next. All
/// ranks call it.
pub fn check_all(ranks: &dyn Transport) {
    assert!(ranks.rank() < ranks.size());
    for round in 0..2 {
        exchange(ranks, round);
        exchange_of_long_and_empty_messages(ranks);
        all_to_all(ranks);
        all_gather(ranks);
        gather(ranks);
        broadcast(ranks);
        sum(ranks);
        max(ranks);
        ranks.barrier();
        halo(ranks);
        migration(ranks);
        turns(ranks);
        turns_that_end_early(ranks);
        exact_sum(ranks);
    }
}

fn message(from: usize, to: usize, length: usize) -> Vec<u8> {
    (0..length).map(|k| (k * (from + 1) + 7 * to) as u8).collect()
}

fn others(ranks: &dyn Transport) -> Vec<usize> {
    (0..ranks.size()).filter(|&other| other != ranks.rank()).collect()
}

fn exchange_of_length(ranks: &dyn Transport, length: impl Fn(usize, usize) -> usize) {
    let me = ranks.rank();
    let others = others(ranks);
    let outgoing: Vec<_> = others.iter().map(|&to| message(me, to, length(me, to))).collect();
    let mut incoming: Vec<_> = others.iter().map(|&from| vec![0; length(from, me)]).collect();
    let sends: Vec<(usize, &[u8])> = others.iter().copied().zip(outgoing.iter().map(Vec::as_slice)).collect();
    let mut receives: Vec<(usize, &mut [u8])> =
        others.iter().copied().zip(incoming.iter_mut().map(Vec::as_mut_slice)).collect();
    let mut ran = 0;
    ranks.exchange(&sends, &mut receives, &mut || ran += 1);
    assert_eq!(ran, 1);
    for (&from, bytes) in others.iter().zip(&incoming) {
        assert_eq!(*bytes, message(from, me, length(from, me)));
    }
}

fn exchange(ranks: &dyn Transport, round: usize) {
    exchange_of_length(ranks, |from, to| 10 + 3 * from + to + round);
}

fn exchange_of_long_and_empty_messages(ranks: &dyn Transport) {
    exchange_of_length(ranks, |from, to| if from < to { 0 } else { 1 << 20 });
}

fn all_to_all(ranks: &dyn Transport) {
    let me = ranks.rank();
    let length = |from: usize, to: usize| {
        if (from + to) % 3 == 1 { 0 } else { 100_000 * from + to }
    };
    let incoming = ranks.all_to_all((0..ranks.size()).map(|to| message(me, to, length(me, to))).collect());
    let expected: Vec<_> = (0..ranks.size()).map(|from| message(from, me, length(from, me))).collect();
    assert_eq!(incoming, expected);
}

fn everyones(ranks: &dyn Transport) -> Vec<Vec<u8>> {
    // Rank 0 has nothing, every other rank a different length.
    (0..ranks.size()).map(|from| message(from, 0, 1000 * from)).collect()
}

fn all_gather(ranks: &dyn Transport) {
    let expected = everyones(ranks);
    assert_eq!(ranks.all_gather(&expected[ranks.rank()]), expected);
}

fn gather(ranks: &dyn Transport) {
    let expected = everyones(ranks);
    let gathered = ranks.gather(&expected[ranks.rank()]);
    assert_eq!(gathered, (ranks.rank() == 0).then_some(expected));
}

fn broadcast(ranks: &dyn Transport) {
    for length in [0, 1, 100_000] {
        let bytes = if ranks.rank() == 0 { message(0, 0, length) } else { vec![9; 5] };
        assert_eq!(ranks.broadcast(bytes), message(0, 0, length));
    }
}

fn sum(ranks: &dyn Transport) {
    let (me, size) = (ranks.rank() as i64, ranks.size() as i64);
    let mut values = [me, -1, i64::MAX / size, 0];
    ranks.sum(&mut values);
    assert_eq!(values, [size * (size - 1) / 2, -size, i64::MAX / size * size, 0]);
    ranks.sum(&mut []);
}

fn max(ranks: &dyn Transport) {
    let (me, last) = (ranks.rank() as f64, ranks.size() as f64 - 1.0);
    let only_first = |value: f64, other: f64| if ranks.rank() == 0 { value } else { other };
    // -me is -0 on rank 0, the largest of all.
    let mut values = [me, -me, only_first(-f64::NAN, f64::INFINITY), only_first(0.0, -0.0), f64::NEG_INFINITY];
    ranks.max(&mut values);
    let expected = [last, -0.0, f64::NAN, 0.0, f64::NEG_INFINITY];
    assert_eq!(values.map(f64::to_bits), expected.map(f64::to_bits));

    let mut integers = [ranks.rank() as i64, i64::MIN];
    ranks.max_integer(&mut integers);
    assert_eq!(integers, [ranks.size() as i64 - 1, i64::MIN]);
}

/// Every rank sends its one row to every other.
fn halo(ranks: &dyn Transport) {
    let others = others(ranks);
    let halo = Halo {
        sends: others.iter().map(|&to| (to, vec![0])).collect(),
        receives: (1..).zip(&others).map(|(row, &from)| (from, row..row + 1)).collect(),
    };
    let mut rows = vec![[f64::NAN; 3]; ranks.size()];
    let mine = |rank: usize| [rank as f64, -0.0, 1e-300];
    let mut ran = 0;
    halo.refresh(
        ranks,
        &mut HaloBuffers::default(),
        |_| mine(ranks.rank()),
        |row, values| rows[row as usize] = values,
        &mut || ran += 1,
    );
    assert_eq!(ran, 1);
    for (row, &from) in rows[1..].iter().zip(&others) {
        assert_eq!(row.map(f64::to_bits), mine(from).map(f64::to_bits));
    }
}

fn migration(ranks: &dyn Transport) {
    let parcel = |from: usize, to: usize| {
        let mut writer = Writer::new();
        writer.u64_array([from as u64, to as u64]);
        writer.finish_for(1, Route { sender: from as u32, receiver: to as u32, number: 3 })
    };
    let outgoing = (0..ranks.size()).map(|to| parcel(ranks.rank(), to)).collect();
    for (from, bytes) in exchange_rows(ranks, 3, outgoing).unwrap().iter().enumerate() {
        let (mut reader, rows) = Reader::open(bytes).unwrap();
        assert_eq!(rows, 1);
        assert_eq!(reader.u64_array().unwrap(), [from as u64, ranks.rank() as u64]);
        reader.finish().unwrap();
    }
}

/// Harmonic numbers, dealt round, have the bits of one rank's sum.
/// Pieces of rank `from`: none of rank 1, the first of every other one empty.
fn pieces(from: usize) -> impl Iterator<Item = Vec<u8>> {
    let count = if from == 1 { 0 } else { 3 + from };
    (0..count).map(move |number| message(from, 0, 70_000 * number))
}

fn turns(ranks: &dyn Transport) {
    let mut mine = pieces(ranks.rank());
    let mut taken = Vec::new();
    let outcome: Result<(), ()> = in_turn(
        ranks,
        || mine.next(),
        |from, piece| {
            taken.push((from, piece));
            Ok(())
        },
    );
    assert_eq!(outcome, Ok(()));
    assert_eq!(mine.next(), None);
    let all = (0..ranks.size()).flat_map(|from| pieces(from).map(move |piece| (from, piece)));
    assert!(if ranks.rank() == 0 { taken.into_iter().eq(all) } else { taken.is_empty() });
}

/// A failure at any piece is known to rank 0, and nobody waits.
fn turns_that_end_early(ranks: &dyn Transport) {
    let all = (0..ranks.size()).map(|from| pieces(from).count()).sum();
    for last in 0..all {
        let mut mine = pieces(ranks.rank());
        let mut taken = 0;
        let outcome = in_turn(
            ranks,
            || mine.next(),
            |from, _| {
                taken += 1;
                if taken > last { Err(from) } else { Ok(()) }
            },
        );
        let owner = (0..ranks.size()).flat_map(|from| pieces(from).map(move |_| from)).nth(last).unwrap();
        assert_eq!(outcome, if ranks.rank() == 0 { Err(owner) } else { Ok(()) });
        assert!(ranks.rank() <= owner || mine.count() == pieces(ranks.rank()).count(), "later ranks are not asked");
    }
}

fn exact_sum(ranks: &dyn Transport) {
    let term = |k: usize| 1.0 / (k + 1) as f64;
    let (mut here, mut alone) = (ExactSum::<1>::new(), ExactSum::<1>::new());
    for k in 0..1000 {
        alone.add(0, term(k));
        if k % ranks.size() == ranks.rank() {
            here.add(0, term(k));
        }
    }
    assert_eq!(here.reduce(ranks).unwrap()[0].to_bits(), alone.value(0).to_bits());
}
