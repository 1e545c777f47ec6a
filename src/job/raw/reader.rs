//! Reads the keys of one table. Every refusal names file, line, value and remedy, and is noted; reading goes on with the example of
//! the key in the place of its value.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::tree::{Entry, Node, Place, Value, short, typed_value};
use super::{STRANGE_MAX, Typed};
use crate::base::error::Error;
use crate::base::keys::{DefaultValue, Form, Key, Owner, Table, Wants};
use crate::base::units::{Dimension, Refusal, nearest, quantity};

/// Size of the largest and of the smallest number but 0, in SI units: far beyond all that is granular, and products of
/// several stay numbers.
const SIZE_MAX: f64 = 1e30;
const SIZE_MIN: f64 = 1e-30;
/// Entries that a list may have; times on the path of a body, which may have been recorded.
const ENTRIES_MAX: usize = 1000;
const TIMES_MAX: usize = 100_000;

/// One table of the job.
#[derive(Clone)]
pub struct Reader<'a> {
    typed: &'a Typed,
    table: &'a Table,
    node: Option<&'a Node>,
    awake: bool,
    axes: usize,
    /// The same table of another file, which has what this one has not.
    beneath: Option<Box<Reader<'a>>>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(typed: &'a Typed, table: &'a Table, node: Option<&'a Node>, awake: bool) -> Self {
        Self { typed, table, node, awake, axes: 2, beneath: None }
    }

    /// The same table, read in a space of that many axes.
    pub fn with_axes(mut self, axes: usize) -> Self {
        self.axes = axes;
        self
    }

    /// The same table with another one beneath it, whose keys count where this one has none.
    pub fn over(mut self, beneath: Reader<'a>) -> Self {
        self.beneath = Some(Box::new(beneath));
        self
    }

    /// The folder of the job, from which relative paths start.
    pub fn folder(&self) -> PathBuf {
        folder_of(&self.typed.file)
    }

    /// Whether the key was given on the command line.
    pub fn is_set(&self, key: &str) -> bool {
        self.find(key).is_some_and(|(_, entry)| entry.place == Place::Set)
    }

    /// Whether a key says something that is none of these names.
    pub fn is_none_of(&self, key: &str, names: &[&str]) -> bool {
        let typed = self.find(key).map(|(_, entry)| &entry.node.value);
        typed.is_some_and(|value| !matches!(value, Value::Text(text) if names.contains(&text.as_str())))
    }

    /// The word that a key says.
    pub fn word(&self, key: &str) -> Option<&str> {
        match &self.find(key)?.1.node.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Notes a key of this table that is missing where the job cannot do without.
    pub fn note_without(&self, key: &str) {
        if let (None, Some(known)) = (self.find(key), self.table.key(key)) {
            self.note_missing(known);
        }
    }

    /// Whether the table was typed at all.
    pub fn is_typed(&self) -> bool {
        self.node.is_some()
    }

    /// Notes a mistake of this table, which nothing that is read later depends on.
    pub fn add(&self, error: Error) {
        self.typed.note(self.node.map(|node| node.place), error);
    }

    /// What came of one of many tables; its mistakes are noted, and the others are read all the same.
    pub fn one_of_many<T>(&self, outcome: Result<T, Error>) -> Option<T> {
        outcome.map_err(|error| self.typed.note_together(error)).ok()
    }

    /// Readers of the tables of a list such as `[[body]]`.
    pub fn list(&self, name: &str) -> Vec<Reader<'a>> {
        let Some(Wants::Tables(table)) = self.table.key(name).map(|key| &key.wants) else {
            panic!("{} is not a list of tables", self.table.path(name));
        };
        let Some((_, entry)) = self.find(name) else { return Vec::new() };
        let tables = entry.node.list().iter().filter(|node| matches!(node.value, Value::Table(_)));
        tables.map(|node| self.reader_of(table, node)).collect()
    }

    /// An error at a key of this table; `problem` says what is wrong and what to do.
    pub fn refusal(&self, key: &str, problem: &str) -> Error {
        match (self.find(key), self.table.key(key)) {
            (Some((typed, entry)), _) => self.found(typed, key, &entry.node, problem),
            (None, Some(known)) => self.missing(known),
            (None, None) => panic!("{} is no key", self.table.path(key)),
        }
    }

    /// An error at the table as a whole.
    pub fn refusal_of_table(&self, problem: &str) -> Error {
        self.typed.told(self.place(), &format!("{} {problem}", self.table.words()))
    }

    /// The line of the table itself.
    fn place(&self) -> Option<Place> {
        self.node.map(|node| node.place)
    }

    fn find(&self, key: &str) -> Option<(&'a Typed, &'a Entry)> {
        let own = self.node.and_then(|node| node.get(key)).map(|entry| (self.typed, entry));
        own.or_else(|| self.beneath.as_ref()?.find(key))
    }

    fn reader_of(&self, table: &'a Table, node: &'a Node) -> Reader<'a> {
        Reader::new(self.typed, table, Some(node), true).with_axes(self.axes)
    }

    /// The value of a key as `how` reads it; none where it was not typed.
    fn given<T>(&self, key: &Key, how: impl Fn(&Key, &Node) -> Result<T, Error>) -> Option<T> {
        let (typed, entry) = self.find(key.name)?;
        let reader = if std::ptr::eq(typed, self.typed) { self } else { self.beneath.as_deref()? };
        debug_assert!(self.table.key(key.name).is_some(), "{} is described", self.table.path(key.name));
        Some(how(key, &entry.node).unwrap_or_else(|error| {
            reader.typed.note(Some(entry.place), error);
            self.example(key, how)
        }))
    }

    /// The value of a key that is typed, or has a default; elsewhere `value` is left as it is.
    fn read<T>(&self, value: &mut T, key: &Key, how: impl Fn(&Key, &Node) -> Result<T, Error>) {
        match (self.given(key, &how), key.default) {
            (Some(given), _) => *value = given,
            (None, DefaultValue::Value(typed)) => {
                let read = typed_value(typed).and_then(|node| how(key, &node).ok());
                *value = read.unwrap_or_else(|| panic!("the default of {} cannot be read", self.table.path(key.name)));
            }
            (None, default) if default.is_required() && self.awake => {
                self.note_missing(key);
                *value = self.example(key, how);
            }
            (None, _) => {}
        }
    }

    /// A table that is missing is noted as one, and a key that is misspelt as that.
    fn note_missing(&self, key: &Key) {
        let Some(node) = self.node else { return };
        let names = || self.table.keys.iter().map(|known| known.name);
        let mut strange = node.entries().iter().filter(|entry| self.table.key(&entry.key).is_none()).take(STRANGE_MAX);
        if !strange.any(|entry| nearest(&entry.key, names()) == Some(key.name)) {
            self.add(self.missing(key));
        }
    }

    /// What stands in for a value that cannot be had.
    fn example<T>(&self, key: &Key, how: impl Fn(&Key, &Node) -> Result<T, Error>) -> T {
        let node = typed_value(&key.example(self.axes));
        let read = node.and_then(|node| how(key, &node).ok());
        read.unwrap_or_else(|| panic!("the example of {} cannot be read", self.table.path(key.name)))
    }

    fn number_at(&self, key: &Key, node: &Node) -> Result<f64, Error> {
        let Wants::Number(dimension, range) = key.wants else {
            panic!("{} is not a number", self.table.path(key.name));
        };
        let value = self.quantity(key, node, dimension)?;
        if !range.contains(value) {
            let allowed = range.words(&dimension.unit());
            return Err(self.refuse(key, node, &format!("is out of range: it must be {allowed}.")));
        }
        self.refuse_size(key, node, value)?;
        Ok(value)
    }

    fn text_at(&self, key: &Key, node: &Node) -> Result<String, Error> {
        match &node.value {
            Value::Text(text) if !text.is_empty() => Ok(text.clone()),
            Value::Text(_) => Err(self.refuse(key, node, "is empty.")),
            other => {
                let problem = format!("is {}, but text in quotes is wanted.", other.words());
                Err(self.refuse(key, node, &problem))
            }
        }
    }

    fn path_at(&self, key: &Key, node: &Node) -> Result<PathBuf, Error> {
        Ok(folder_of(&self.typed.file).join(self.text_at(key, node)?))
    }

    fn vector_at(&self, key: &Key, node: &Node) -> Result<[f64; 3], Error> {
        let Wants::Vector(dimension) = key.wants else {
            panic!("{} is not a vector", self.table.path(key.name));
        };
        self.components(key, node, dimension)
    }

    fn spin_at(&self, key: &Key, node: &Node) -> Result<[f64; 3], Error> {
        match self.axes {
            2 => Ok([0.0, 0.0, self.finite(key, node, Dimension::SPIN)?]),
            _ => self.components(key, node, Dimension::SPIN),
        }
    }

    /// Notes keys that belong to another choice of `selector` than the chosen one.
    fn note_keys_of_others(&self, selector: &str, chosen: &str) {
        for known in &self.table.keys {
            let owners: Vec<&str> =
                known.owners.iter().filter(|owner| owner.selector == selector).map(|owner| owner.choice).collect();
            let Some((typed, entry)) = self.find(known.name).filter(|_| !owners.is_empty()) else { continue };
            if owners.contains(&chosen) {
                continue;
            }
            let default = if self.has(selector) { "" } else { ", by default" };
            let problem = format!(
                "belongs to {selector} = {}, and here {selector} is \"{chosen}\"{default}. Remove the line, or change {selector}.",
                either(&owners)
            );
            typed.note(Some(entry.place), self.refusal(known.name, &problem));
        }
    }

    /// The items of a list that has one for each axis.
    fn items<'n>(&self, key: &Key, node: &'n Node, each: &str) -> Result<&'n [Node], Error> {
        let items = node.list();
        if items.len() == self.axes {
            return Ok(items);
        }
        let count = if self.axes == 2 { "two" } else { "three" };
        Err(self.refuse(key, node, &format!("is refused: a list of {count} is wanted, each {each}.")))
    }

    fn components(&self, key: &Key, node: &Node, dimension: Dimension) -> Result<[f64; 3], Error> {
        let mut vector = [0.0; 3];
        for (component, node) in vector.iter_mut().zip(self.items(key, node, &with_unit(dimension))?) {
            *component = self.finite(key, node, dimension)?;
        }
        Ok(vector)
    }

    fn flag_at(&self, key: &Key, node: &Node) -> Result<bool, Error> {
        match node.value {
            Value::Flag(flag) => Ok(flag),
            ref other => Err(self.refuse(key, node, &format!("is {}, but true or false is wanted.", other.words()))),
        }
    }

    fn finite(&self, key: &Key, node: &Node, wanted: Dimension) -> Result<f64, Error> {
        match self.quantity(key, node, wanted)? {
            value if value.is_finite() => self.refuse_size(key, node, value).map(|()| value),
            _ => Err(self.refuse(key, node, "is out of range: it must be finite.")),
        }
    }

    /// What follows from a number beyond these sizes may be no number any more.
    fn refuse_size(&self, key: &Key, node: &Node, value: f64) -> Result<(), Error> {
        if value == 0.0 || (SIZE_MIN..=SIZE_MAX).contains(&value.abs()) {
            return Ok(());
        }
        let problem =
            format!("is out of range: in SI units, sizes from {SIZE_MIN:e} to {SIZE_MAX:e} are allowed, and 0.");
        Err(self.refuse(key, node, &problem))
    }

    fn refuse_entries(&self, key: &str, node: &Node, max: usize) -> Result<(), Error> {
        match node.list().len() {
            count if count > max => {
                let path = self.table.path(key);
                let message =
                    format!("{path} has {count} entries, and at most {max} are allowed. Join some, or remove them.");
                Err(self.typed.told(Some(node.place), &message))
            }
            _ => Ok(()),
        }
    }

    fn quantity(&self, key: &Key, node: &Node, wanted: Dimension) -> Result<f64, Error> {
        let problem = match &node.value {
            Value::Integer(value) => return Ok(*value as f64),
            Value::Float(value) => return Ok(*value),
            Value::Text(text) => match quantity(text, wanted) {
                Ok(value) => return Ok(value),
                Err(refusal) => describe(&refusal, wanted),
            },
            other => format!("is {}, but {} is wanted.", other.words(), wanted.words()),
        };
        Err(self.refuse(key, node, &problem))
    }

    fn missing(&self, key: &Key) -> Error {
        let message = format!(
            "{} has no {1}, {2}. Add for example {1} = {3}.",
            self.table.words(),
            key.name,
            key.about,
            key.example(self.axes)
        );
        self.typed.told(self.place(), &message)
    }

    /// An error at a value, with an example of what would be right.
    fn refuse(&self, key: &Key, node: &Node, problem: &str) -> Error {
        let typed = match self.find(key.name) {
            Some((typed, _)) => typed,
            None => self.typed,
        };
        let example = key.example(self.axes);
        self.found(typed, key.name, node, &format!("{problem} Write for example {} = {example}.", key.name))
    }

    fn found(&self, typed: &Typed, key: &str, node: &Node, problem: &str) -> Error {
        let path = self.table.path(key);
        typed.told(Some(node.place), &format!("{path} = {} {problem}", node.typed))
    }
}

impl Form for Reader<'_> {
    fn axes(&self) -> usize {
        self.axes
    }

    fn set_axes(&mut self, axes: usize) {
        self.axes = axes;
    }

    fn number(&mut self, value: &mut f64, key: Key) {
        self.read(value, &key, |key, node| self.number_at(key, node));
    }

    fn number_if_given(&mut self, value: &mut Option<f64>, key: Key) {
        *value = self.given(&key, |key, node| self.number_at(key, node));
    }

    fn count(&mut self, value: &mut u64, key: Key) {
        self.read(value, &key, |key, node| {
            let Wants::Count(min, max) = key.wants else {
                panic!("{} is not a count", self.table.path(key.name));
            };
            let value = match node.value {
                Value::Integer(value) => u64::try_from(value).ok(),
                _ => None,
            };
            value.filter(|value| (min..=max).contains(value)).ok_or_else(|| {
                let allowed = match max {
                    u64::MAX => format!("{min} or more"),
                    _ => format!("between {min} and {max}"),
                };
                self.refuse(key, node, &format!("is refused: it must be a whole number {allowed}."))
            })
        });
    }

    fn flag(&mut self, value: &mut bool, key: Key) {
        self.read(value, &key, |key, node| self.flag_at(key, node));
    }

    fn flags(&mut self, value: &mut [bool; 3], key: Key) {
        self.read(value, &key, |key, node| {
            let mut flags = [false; 3];
            for (flag, node) in flags.iter_mut().zip(self.items(key, node, "a truth value")?) {
                *flag = self.flag_at(key, node)?;
            }
            Ok(flags)
        });
    }

    fn text(&mut self, value: &mut String, key: Key) {
        self.read(value, &key, |key, node| self.text_at(key, node));
    }

    fn path(&mut self, value: &mut PathBuf, key: Key) {
        self.read(value, &key, |key, node| self.path_at(key, node));
    }

    fn path_if_given(&mut self, value: &mut Option<PathBuf>, key: Key) {
        *value = self.given(&key, |key, node| self.path_at(key, node));
    }

    fn vector(&mut self, value: &mut [f64; 3], key: Key) {
        self.read(value, &key, |key, node| self.vector_at(key, node));
    }

    fn vector_if_given(&mut self, value: &mut Option<[f64; 3]>, key: Key) {
        *value = self.given(&key, |key, node| self.vector_at(key, node));
    }

    fn spin(&mut self, value: &mut [f64; 3], key: Key) {
        self.read(value, &key, |key, node| self.spin_at(key, node));
    }

    fn spin_if_given(&mut self, value: &mut Option<[f64; 3]>, key: Key) {
        *value = self.given(&key, |key, node| self.spin_at(key, node));
    }

    fn gradient(&mut self, value: &mut [[f64; 3]; 3], key: Key) {
        self.read(value, &key, |key, node| {
            let mut gradient = [[0.0; 3]; 3];
            for (row, node) in gradient.iter_mut().zip(self.items(key, node, "a row of rates (1/s)")?) {
                *row = self.components(key, node, Dimension::RATE)?;
            }
            Ok(gradient)
        });
    }

    fn stresses(&mut self, value: &mut Option<[Option<f64>; 3]>, key: Key) {
        *value = self.given(&key, |key, node| {
            let mut stresses = [None; 3];
            for (stress, node) in stresses.iter_mut().zip(self.items(key, node, "a stress (Pa) or \"free\"")?) {
                *stress = match &node.value {
                    Value::Text(word) if word == "free" => None,
                    Value::Text(word) if word.starts_with(char::is_alphabetic) => {
                        return Err(self.refuse(key, node, "is neither a stress nor \"free\"."));
                    }
                    _ => Some(self.finite(key, node, Dimension::STRESS)?),
                };
            }
            Ok(stresses)
        });
    }

    fn shares(&mut self, value: &mut Vec<(f64, f64)>, key: Key) {
        self.read(value, &key, |key, node| {
            let wanted = "is refused: a list of pairs is wanted, each a length (m) and a share, both more than 0.";
            let refused = || self.refuse(key, node, wanted);
            self.refuse_entries(key.name, node, ENTRIES_MAX)?;
            if node.list().is_empty() {
                return Err(refused());
            }
            let pairs = node.list().iter().map(|pair| match pair.list() {
                [length, share] => {
                    let length = self.finite(key, length, Dimension::LENGTH)?;
                    let share = self.finite(key, share, Dimension::RATIO)?;
                    if length > 0.0 && share > 0.0 { Ok((length, share)) } else { Err(refused()) }
                }
                _ => Err(refused()),
            });
            pairs.collect()
        });
    }

    fn polygon(&mut self, value: &mut Vec<[f64; 2]>, key: Key) {
        self.read(value, &key, |key, node| {
            let wanted = "is refused: a list of three or more points is wanted, each two lengths (m).";
            let refused = || self.refuse(key, node, wanted);
            if node.list().len() < 3 {
                return Err(refused());
            }
            self.refuse_entries(key.name, node, ENTRIES_MAX)?;
            let corners = node.list().iter().map(|point| match point.list() {
                [x, y] => {
                    let length = |node| self.finite(key, node, Dimension::LENGTH);
                    Ok([length(x)?, length(y)?])
                }
                _ => Err(refused()),
            });
            corners.collect()
        });
    }

    fn choice(&mut self, chosen: usize, noun: &str, names: &[&'static str], key: Key) -> Range<usize> {
        let mut chosen = chosen;
        if let Some((typed, entry)) = self.find(key.name) {
            let found = self.text_at(&key, &entry.node).and_then(|word| {
                let found = names.iter().position(|name| *name == word);
                found.ok_or_else(|| self.refusal(key.name, &format!("is no {noun}: write {}.", either(names))))
            });
            match found {
                Ok(found) => chosen = found,
                // Which keys go with it nobody knows.
                Err(error) => {
                    typed.note(Some(entry.place), error);
                    return chosen..chosen + 1;
                }
            }
        } else if let DefaultValue::Value(default) = key.default {
            chosen = names.iter().position(|name| *name == default).expect("the default is a choice");
        } else if key.default.is_required() && self.awake {
            self.note_missing(&key);
            return chosen..chosen + 1;
        }
        self.note_keys_of_others(key.name, names[chosen]);
        chosen..chosen + 1
    }

    fn enter(&mut self, _: Owner) {}

    fn leave(&mut self) {}

    fn table(&mut self, _: bool, key: Key, _: &'static str, inside: &mut dyn FnMut(&mut dyn Form)) -> bool {
        let Some(Wants::Table(table)) = self.table.key(key.name).map(|key| &key.wants) else {
            panic!("{} is not a table", self.table.path(key.name));
        };
        let Some((typed, entry)) = self.find(key.name) else { return false };
        if matches!(entry.node.value, Value::Table(_)) {
            inside(&mut self.reader_of(table, &entry.node));
            return true;
        }
        let words = entry.node.value.words();
        let problem = format!("is {words}, but a table with the keys {} is wanted.", table.key_list());
        typed.note(Some(entry.place), self.refuse(&key, &entry.node, &problem));
        false
    }

    fn tables(&mut self, _: usize, key: Key, _: &'static str, each: &mut dyn FnMut(usize, &mut dyn Form)) {
        let Some(Wants::Tables(table)) = self.table.key(key.name).map(|key| &key.wants) else {
            panic!("{} is not a list of tables", self.table.path(key.name));
        };
        let Some((typed, entry)) = self.find(key.name) else { return };
        let refused = |node: &Node| {
            let path = self.table.path(key.name);
            let message = format!(
                "{path} is {}, but a list of tables is wanted. Write [[{path}]] on a line of its own, and {} below.",
                node.value.words(),
                table.key_list()
            );
            typed.note(Some(node.place), typed.told(Some(node.place), &message));
        };
        let Value::List(nodes) = &entry.node.value else { return refused(&entry.node) };
        let most = if key.name == "path" { TIMES_MAX } else { ENTRIES_MAX };
        if let Err(error) = self.refuse_entries(key.name, &entry.node, most) {
            return typed.note(Some(entry.place), error);
        }
        let mut number = 0;
        for node in nodes {
            match node.value {
                Value::Table(_) => {
                    each(number, &mut self.reader_of(table, node));
                    number += 1;
                }
                _ => refused(node),
            }
        }
    }

    fn has(&self, key: &str) -> bool {
        self.find(key).is_some()
    }

    fn is_needed(&self) -> bool {
        self.awake
    }

    fn note(&mut self, key: &str, problem: &str) {
        let place = self.find(key).map(|(_, entry)| entry.place);
        self.typed.note(place, self.refusal(key, problem));
    }

    fn note_table(&mut self, problem: &str) {
        // A table that is missing is noted as one.
        if self.is_typed() {
            self.add(self.refusal_of_table(problem));
        }
    }
}

/// The folder that relative paths of a job start from.
fn folder_of(file: &str) -> PathBuf {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf())
}

/// `"a", "b" or "c"`.
fn either(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    match quoted.as_slice() {
        [head @ .., last] if !head.is_empty() => format!("{} or {last}", head.join(", ")),
        _ => quoted.concat(),
    }
}

fn describe(refusal: &Refusal, wanted: Dimension) -> String {
    match refusal {
        Refusal::NoNumber => format!("is not a number with a unit, but {} is wanted.", wanted.words()),
        Refusal::NoUnit => format!(
            "has no unit: without quotes a number is taken in {}, in quotes it must say its unit.",
            wanted.unit()
        ),
        Refusal::UnknownUnit(symbol, Some(near)) => {
            format!("has no known unit: there is no \"{symbol}\"; did you mean \"{near}\"?")
        }
        Refusal::UnknownUnit(symbol, None) => {
            format!("has no known unit: there is no \"{}\".", short(symbol))
        }
        Refusal::Ambiguous => "can be read in two ways: write one unit behind a slash, as in \"N s/m\".".to_string(),
        Refusal::Other(found) => {
            format!("is {}, but {} is wanted.", found.words(), with_unit(wanted))
        }
    }
}

fn with_unit(dimension: Dimension) -> String {
    match dimension.unit().as_str() {
        "" => dimension.words(),
        unit => format!("{} ({unit})", dimension.words()),
    }
}
