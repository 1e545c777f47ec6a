//! One rank, alone.

use super::{Transport, check_peers};

/// The transport of a run with one rank: every message would be to itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solo;

impl Transport for Solo {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn exchange(&self, sends: &[(usize, &[u8])], receives: &mut [(usize, &mut [u8])], meanwhile: &mut dyn FnMut()) {
        check_peers(self, sends, receives);
        assert!(sends.is_empty() && receives.is_empty(), "a single rank has no peers");
        meanwhile();
    }

    fn all_to_all(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        assert_eq!(outgoing.len(), 1, "one entry per rank");
        outgoing
    }

    fn all_gather(&self, mine: &[u8]) -> Vec<Vec<u8>> {
        vec![mine.to_vec()]
    }

    fn gather(&self, mine: &[u8]) -> Option<Vec<Vec<u8>>> {
        Some(self.all_gather(mine))
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        bytes
    }

    fn sum(&self, _values: &mut [i64]) {}

    fn max_integer(&self, _values: &mut [i64]) {}

    fn barrier(&self) {}

    fn abort(&self, code: i32) -> ! {
        std::process::exit(code)
    }
}
