//! Keys for messages, help and schemas.

use std::path::PathBuf;

use super::{Form, Key, Owner, Table, Wants};

/// Visits every key of every choice and remembers what it is told.
pub struct Description {
    /// What the table is called.
    name: String,
    axes: usize,
    entered: Vec<Owner>,
    keys: Vec<Key>,
}

impl Description {
    /// The table whose keys `visit` declares.
    pub fn of(name: &str, about: &'static str, many: bool, visit: impl FnOnce(&mut dyn Form)) -> Table {
        let mut description = Self { name: name.to_string(), axes: 2, entered: Vec::new(), keys: Vec::new() };
        visit(&mut description);
        Table { name: description.name, about, many, keys: description.keys }
    }

    fn below(&self, key: &Key) -> String {
        if self.name.is_empty() { key.name.to_string() } else { format!("{}.{}", self.name, key.name) }
    }

    /// A key of several choices is described once; one that belongs to all of them belongs to none.
    fn add(&mut self, mut key: Key) {
        match self.keys.iter_mut().find(|known| known.name == key.name) {
            Some(known) => known.owners.extend(&self.entered),
            None => {
                key.owners.clone_from(&self.entered);
                self.keys.push(key);
            }
        }
    }
}

impl Form for Description {
    fn axes(&self) -> usize {
        self.axes
    }
    fn set_axes(&mut self, axes: usize) {
        self.axes = axes;
    }
    fn number(&mut self, _: &mut f64, key: Key) {
        self.add(key);
    }
    fn number_if_given(&mut self, _: &mut Option<f64>, key: Key) {
        self.add(key);
    }
    fn vector_if_given(&mut self, _: &mut Option<[f64; 3]>, key: Key) {
        self.add(key);
    }
    fn spin_if_given(&mut self, _: &mut Option<[f64; 3]>, key: Key) {
        self.add(key);
    }
    fn count(&mut self, _: &mut u64, key: Key) {
        self.add(key);
    }
    fn flag(&mut self, _: &mut bool, key: Key) {
        self.add(key);
    }
    fn flags(&mut self, _: &mut [bool; 3], key: Key) {
        self.add(key);
    }
    fn text(&mut self, _: &mut String, key: Key) {
        self.add(key);
    }
    fn path(&mut self, _: &mut PathBuf, key: Key) {
        self.add(key);
    }
    fn path_if_given(&mut self, _: &mut Option<PathBuf>, key: Key) {
        self.add(key);
    }
    fn vector(&mut self, _: &mut [f64; 3], key: Key) {
        self.add(key);
    }
    fn spin(&mut self, _: &mut [f64; 3], key: Key) {
        self.add(key);
    }
    fn gradient(&mut self, _: &mut [[f64; 3]; 3], key: Key) {
        self.add(key);
    }
    fn stresses(&mut self, _: &mut Option<[Option<f64>; 3]>, key: Key) {
        self.add(key);
    }
    fn shares(&mut self, _: &mut Vec<(f64, f64)>, key: Key) {
        self.add(key);
    }
    fn polygon(&mut self, _: &mut Vec<[f64; 2]>, key: Key) {
        self.add(key);
    }
    fn choice(&mut self, _: usize, _: &str, names: &[&'static str], mut key: Key) -> std::ops::Range<usize> {
        key.wants = Wants::Choice(names.to_vec());
        self.add(key);
        0..names.len()
    }
    fn enter(&mut self, owner: Owner) {
        self.entered.push(owner);
    }
    fn leave(&mut self) {
        self.entered.pop();
    }
    fn tables(&mut self, _: usize, mut key: Key, about: &'static str, each: &mut dyn FnMut(usize, &mut dyn Form)) {
        key.wants = Wants::Tables(Box::new(Self::of(&self.below(&key), about, true, |form| each(0, form))));
        self.add(key);
    }
    fn table(&mut self, _: bool, mut key: Key, about: &'static str, inside: &mut dyn FnMut(&mut dyn Form)) -> bool {
        key.wants = Wants::Table(Box::new(Self::of(&self.below(&key), about, false, |form| inside(form))));
        self.add(key);
        true
    }
    fn has(&self, _: &str) -> bool {
        false
    }
    fn describes(&self) -> bool {
        true
    }
    fn is_needed(&self) -> bool {
        false
    }
    fn note(&mut self, _: &str, _: &str) {}
    fn note_table(&mut self, _: &str) {}
}
