//! Pieces of all ranks, one after the other, for something that only rank 0 can do and that must not be held in whole.

use crate::transport::Transport;

/// What rank 0 says to a rank whose turn it is.
const GO_ON: u8 = 1;
const ENOUGH: u8 = 0;
/// In place of a length: there is no more. No piece is as long.
const NO_MORE: u64 = u64::MAX;

/// Hands what `next` makes on each rank, piece after piece, to `take` on rank 0, which is told the sender: all pieces of
/// rank 0 first, then those of rank 1, and so on. `take` runs on rank 0 alone.
///
/// A rank makes a piece when rank 0 asks for it, and rank 0 asks once it has taken the one before, so that neither ever
/// has more than one. When `take` fails nobody is asked any more: rank 0 returns the error, and the others end all the same.
///
/// Collective.
///
/// # Errors
/// On rank 0 that of `take`; none elsewhere.
pub fn in_turn<E>(
    transport: &dyn Transport,
    mut next: impl FnMut() -> Option<Vec<u8>>,
    mut take: impl FnMut(usize, Vec<u8>) -> Result<(), E>,
) -> Result<(), E> {
    if transport.rank() != 0 {
        answer(transport, next);
        return Ok(());
    }
    let mut outcome = Ok(());
    while outcome.is_ok()
        && let Some(piece) = next()
    {
        outcome = take(0, piece);
    }
    for sender in 1..transport.size() {
        loop {
            if outcome.is_err() {
                tell(transport, sender, &[ENOUGH]);
                break;
            }
            let Some(piece) = ask(transport, sender) else { break };
            outcome = take(sender, piece);
        }
    }
    outcome
}

/// The next piece of a rank, on rank 0.
fn ask(transport: &dyn Transport, sender: usize) -> Option<Vec<u8>> {
    tell(transport, sender, &[GO_ON]);
    let mut length = [0; 8];
    hear(transport, sender, &mut length);
    let length = u64::from_le_bytes(length);
    if length == NO_MORE {
        return None;
    }
    let mut piece = vec![0; length as usize];
    hear(transport, sender, &mut piece);
    Some(piece)
}

/// The other side of [`ask`], until rank 0 or this rank has no more to say.
fn answer(transport: &dyn Transport, mut next: impl FnMut() -> Option<Vec<u8>>) {
    loop {
        let mut word = [ENOUGH];
        hear(transport, 0, &mut word);
        if word == [ENOUGH] {
            return;
        }
        let Some(piece) = next() else {
            tell(transport, 0, &NO_MORE.to_le_bytes());
            return;
        };
        tell(transport, 0, &(piece.len() as u64).to_le_bytes());
        tell(transport, 0, &piece);
    }
}

fn tell(transport: &dyn Transport, receiver: usize, bytes: &[u8]) {
    transport.exchange(&[(receiver, bytes)], &mut [], &mut || {});
}

fn hear(transport: &dyn Transport, sender: usize, into: &mut [u8]) {
    transport.exchange(&[], &mut [(sender, into)], &mut || {});
}
