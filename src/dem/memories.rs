//! Memories of contacts apart from any list: how they get from the list of before a rebuild to that of after it.

use crate::base::ids::GrainId;
use crate::law::contact::Memory;

/// What a contact of a row remembers, and with whom it is.
pub type Carried = (GrainId, Memory);

/// What the contacts of many rows remember, row after row, in the order of partners.
#[derive(Clone, Debug)]
pub struct Memories {
    /// Words of each.
    width: usize,
    /// Those of row i are `starts[i]..starts[i + 1]`.
    starts: Vec<u32>,
    partners: Vec<GrainId>,
    words: Vec<f64>,
}

impl Memories {
    /// Of no rows yet; `width` is the number of words of each.
    pub fn new(width: usize) -> Self {
        Self { width, starts: vec![0], partners: Vec::new(), words: Vec::new() }
    }

    /// The next row, in the order of its partners. Panics where a memory has another width.
    pub fn push(&mut self, row: impl Iterator<Item = Carried>) {
        for (partner, memory) in row {
            assert_eq!(memory.words().len(), self.width, "memories of one law are equally long");
            self.partners.push(partner);
            self.words.extend_from_slice(memory.words());
        }
        self.starts.push(self.partners.len() as u32);
    }

    /// Of one row, by its number in the order in which rows came.
    pub fn of(&self, row: usize) -> impl Iterator<Item = Carried> + '_ {
        let entries = self.starts[row] as usize..self.starts[row + 1] as usize;
        entries.map(|at| (self.partners[at], Memory::of_words(&self.words[at * self.width..(at + 1) * self.width])))
    }
}
