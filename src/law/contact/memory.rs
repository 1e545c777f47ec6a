//! What a contact remembers, where the law that reads it is not known.

use std::fmt::{Debug, Formatter, Result};

use crate::base::space::Words;

/// A law's memory in words: as many as the law has.
#[derive(Clone, Copy, PartialEq)]
pub struct Memory {
    words: [f64; Self::WORDS_MAX],
    count: usize,
}

impl Memory {
    /// No law remembers more: beside every grain's contacts at a rebuild there is room for so many.
    pub const WORDS_MAX: usize = 7;

    /// Nothing remembered.
    pub fn blank(count: usize) -> Self {
        assert!(
            count <= Self::WORDS_MAX,
            "a contact remembers {count} words, and there is room for {}",
            Self::WORDS_MAX
        );
        Self { words: [0.0; Self::WORDS_MAX], count }
    }

    /// Of what a law remembers.
    pub fn of<M: Words<f64>>(memory: &M) -> Self {
        const { assert!(M::COUNT <= Self::WORDS_MAX) };
        let mut words = [0.0; Self::WORDS_MAX];
        memory.to_words(&mut words);
        Self { words, count: M::COUNT }
    }

    /// Of as many words as the law has. Panics where there are more than [`Self::WORDS_MAX`].
    pub fn of_words(words: &[f64]) -> Self {
        let mut memory = Self::blank(words.len());
        memory.words_mut().copy_from_slice(words);
        memory
    }

    /// As its law has it.
    pub fn to<M: Words<f64>>(&self) -> M {
        debug_assert_eq!(self.count, M::COUNT, "a memory is read by the law that wrote it");
        M::of_words(&self.words)
    }

    /// As many as the law has.
    pub fn words(&self) -> &[f64] {
        &self.words[..self.count]
    }

    /// The same, to be written.
    pub fn words_mut(&mut self) -> &mut [f64] {
        &mut self.words[..self.count]
    }

    /// Whether nothing is remembered: all words are zero.
    pub fn is_blank(&self) -> bool {
        self.words().iter().all(|word| *word == 0.0)
    }
}

impl Debug for Memory {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        self.words().fmt(formatter)
    }
}
