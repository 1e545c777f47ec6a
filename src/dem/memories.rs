//! Memories of contacts apart from any list: how they get from the list of before a rebuild to that of after it.

use crate::base::ids::GrainId;

/// What a row's contacts remember: partner and memory, in the order of partners.
pub type Carried<M> = Vec<(GrainId, M)>;

/// The memories of many rows, one after the other.
#[derive(Clone, Debug)]
pub struct Memories<M> {
    /// Those of row i are `entries[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    entries: Carried<M>,
}

impl<M> Default for Memories<M> {
    fn default() -> Self {
        Self { starts: vec![0], entries: Vec::new() }
    }
}

impl<M> Memories<M> {
    pub fn push(&mut self, row: impl Iterator<Item = (GrainId, M)>) {
        self.entries.extend(row);
        self.starts.push(self.entries.len() as u32);
    }

    pub fn of(&self, row: usize) -> &[(GrainId, M)] {
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}
