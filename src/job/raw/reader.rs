//! Readers of one table. Every getter names file, line, value and remedy of what it notes.

use super::super::schema::{Key, Table, Wants};
use super::super::tree::{Entry, Node, Place, Value, short, typed_value};
use super::super::units::{Dimension, Refusal, quantity};
use super::Typed;
use crate::base::error::Error;

/// Size of the largest and of the smallest number but 0, in SI units: far beyond all that is granular, and products of
/// several stay numbers.
const SIZE_MAX: f64 = 1e30;
const SIZE_MIN: f64 = 1e-30;
/// Entries that a list may have; times on the path of a body, which may have been recorded.
const ENTRIES_MAX: usize = 1000;
const TIMES_MAX: usize = 100_000;

/// One table of the job.
pub struct Reader<'a> {
    typed: &'a Typed,
    table: &'static Table,
    node: Option<&'a Node>,
    awake: bool,
    /// Components that a vector has: 2 in the plane, 3 in space.
    axes: usize,
}

/// Reading never stops: what is refused is noted, and the example of its key stands in for it.
impl<'a> Reader<'a> {
    pub(super) fn new(typed: &'a Typed, table: &'static Table, node: Option<&'a Node>, awake: bool) -> Self {
        Self { typed, table, node, awake, axes: 2 }
    }

    /// The same table, read in a space of that many axes.
    pub fn with_axes(mut self, axes: usize) -> Self {
        self.axes = axes;
        self
    }

    pub fn has(&self, key: &str) -> bool {
        self.find(key).is_some()
    }

    /// Whether the key was given on the command line.
    pub fn is_set(&self, key: &str) -> bool {
        self.find(key).is_some_and(|entry| entry.place == Place::Set)
    }

    /// Whether the table was typed at all.
    pub fn is_typed(&self) -> bool {
        self.node.is_some()
    }

    /// Whether the job cannot do without this table.
    pub fn is_awake(&self) -> bool {
        self.awake
    }

    /// Notes a mistake of this table, which nothing that is read later depends on.
    pub fn note(&self, error: Error) {
        self.typed.note(self.node.map(|node| node.place), error);
    }

    /// What came of one of many tables; its mistakes are noted, and the others are read all the same.
    pub fn one_of_many<T>(&self, outcome: Result<T, Error>) -> Option<T> {
        outcome.map_err(|error| self.typed.note_together(error)).ok()
    }

    /// The value of a key as `how` reads it; none where it was not typed.
    fn given<T>(&self, key: &str, how: impl Fn(&'static Key, &Node) -> Result<T, Error>) -> Option<T> {
        let (known, entry) = (self.known(key), self.find(key)?);
        Some(how(known, &entry.node).unwrap_or_else(|error| {
            self.typed.note(Some(entry.place), error);
            self.example(known, how)
        }))
    }

    /// The same of a key that must be there.
    fn required<T>(&self, key: &str, how: impl Fn(&'static Key, &Node) -> Result<T, Error>) -> T {
        self.given(key, &how).unwrap_or_else(|| {
            // A table that is missing is noted as one.
            if self.node.is_some() {
                self.note(self.missing(key));
            }
            self.example(self.known(key), how)
        })
    }

    /// What stands in for a value that cannot be had.
    fn example<T>(&self, known: &'static Key, how: impl Fn(&'static Key, &Node) -> Result<T, Error>) -> T {
        let node = typed_value(&known.example(self.axes));
        let read = node.and_then(|node| how(known, &node).ok());
        read.unwrap_or_else(|| panic!("the example of {} cannot be read", self.table.path(known.name)))
    }

    pub fn number(&self, key: &str) -> f64 {
        self.required(key, |known, node| self.number_at(known, node))
    }

    pub fn number_or(&self, key: &str, default: f64) -> f64 {
        self.number_if_given(key).unwrap_or(default)
    }

    /// Required where the method needs the table; elsewhere a value that nothing will look at.
    pub fn number_awake(&self, key: &str, asleep: f64) -> f64 {
        match self.awake {
            true => self.number(key),
            false => self.number_or(key, asleep),
        }
    }

    pub fn number_if_given(&self, key: &str) -> Option<f64> {
        self.given(key, |known, node| self.number_at(known, node))
    }

    fn number_at(&self, known: &'static Key, node: &Node) -> Result<f64, Error> {
        let Wants::Number(dimension, range) = known.wants else {
            panic!("{} is not a number in the schema", self.table.path(known.name));
        };
        let value = self.quantity(known, node, dimension)?;
        if !range.contains(value) {
            let allowed = range.words(&dimension.unit());
            return Err(self.refuse(known, node, &format!("is out of range: it must be {allowed}.")));
        }
        self.refuse_size(known, node, value)?;
        Ok(value)
    }

    pub fn count_or(&self, key: &str, default: u64) -> u64 {
        self.count_if_given(key).unwrap_or(default)
    }

    pub fn count_if_given(&self, key: &str) -> Option<u64> {
        self.given(key, |known, node| {
            let Wants::Count(min, max) = known.wants else {
                panic!("{} is not a count in the schema", self.table.path(known.name));
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
                self.refuse(known, node, &format!("is refused: it must be a whole number {allowed}."))
            })
        })
    }

    pub fn text(&self, key: &str) -> String {
        self.required(key, |known, node| self.text_at(known, node))
    }

    pub fn text_if_given(&self, key: &str) -> Option<String> {
        self.given(key, |known, node| self.text_at(known, node))
    }

    fn text_at(&self, known: &'static Key, node: &Node) -> Result<String, Error> {
        match &node.value {
            Value::Text(text) if !text.is_empty() => Ok(text.clone()),
            Value::Text(_) => Err(self.refuse(known, node, "is empty.")),
            other => {
                let problem = format!("is {}, but text in quotes is wanted.", other.words());
                Err(self.refuse(known, node, &problem))
            }
        }
    }

    /// One of some words; `noun` says what they are.
    pub fn choice<T: Copy>(&self, key: &str, noun: &str, choices: &[(&str, T)]) -> Option<T> {
        let entry = self.find(key)?;
        let known = self.known(key);
        let chosen = self.text_at(known, &entry.node).and_then(|word| {
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            let found = choices.iter().find(|(name, _)| *name == word).map(|(_, chosen)| *chosen);
            found.ok_or_else(|| self.refusal(key, &format!("is no {noun}: write {}.", either(&names))))
        });
        Some(chosen.unwrap_or_else(|error| {
            self.typed.note(Some(entry.place), error);
            choices[0].1
        }))
    }

    /// The same where there is no default.
    pub fn choose<T: Copy>(&self, key: &str, noun: &str, choices: &[(&str, T)]) -> T {
        self.choice(key, noun, choices).unwrap_or_else(|| {
            if self.node.is_some() {
                self.note(self.missing(key));
            }
            choices[0].1
        })
    }

    pub fn choice_or<T: Copy>(&self, key: &str, noun: &str, choices: &[(&str, T)], default: T) -> T {
        self.choice(key, noun, choices).unwrap_or(default)
    }

    /// Notes keys that belong to another choice of `selector` than the chosen one.
    pub fn note_keys_of_others(&self, selector: &str, chosen: &str, owners: &[(&str, &[&str])]) {
        let own = |key: &str| owners.iter().any(|(name, keys)| *name == chosen && keys.contains(&key));
        for known in self.table.keys.iter().filter(|known| !own(known.name)) {
            let others: Vec<&str> =
                owners.iter().filter(|(_, keys)| keys.contains(&known.name)).map(|(name, _)| *name).collect();
            let Some(entry) = self.find(known.name).filter(|_| !others.is_empty()) else { continue };
            let default = if self.has(selector) { "" } else { ", by default" };
            let problem = format!(
                "belongs to {selector} = {}, and here {selector} is \"{chosen}\"{default}. Remove the line, or change {selector}.",
                either(&others)
            );
            self.typed.note(Some(entry.place), self.refusal(known.name, &problem));
        }
    }

    pub fn flag_or(&self, key: &str, default: bool) -> bool {
        self.given(key, |known, node| self.flag(known, node)).unwrap_or(default)
    }

    /// A truth value for each axis; beyond them false.
    pub fn flags_or(&self, key: &str, default: bool) -> [bool; 3] {
        let each = |known: &'static Key, node: &Node| {
            let mut flags = [false; 3];
            for (flag, node) in flags.iter_mut().zip(self.items(known, node, "a truth value")?) {
                *flag = self.flag(known, node)?;
            }
            Ok(flags)
        };
        self.given(key, each).unwrap_or_else(|| std::array::from_fn(|axis| axis < self.axes && default))
    }

    /// A number for each axis; beyond them zero.
    pub fn vector(&self, key: &str) -> [f64; 3] {
        self.required(key, |known, node| self.vector_at(known, node))
    }

    pub fn vector_if_given(&self, key: &str) -> Option<[f64; 3]> {
        self.given(key, |known, node| self.vector_at(known, node))
    }

    fn vector_at(&self, known: &'static Key, node: &Node) -> Result<[f64; 3], Error> {
        let Wants::Vector(dimension) = known.wants else {
            panic!("{} is not a vector in the schema", self.table.path(known.name));
        };
        self.components(known, node, dimension)
    }

    /// In the plane a number, about the axis out of it; in space a vector.
    pub fn spin_if_given(&self, key: &str) -> Option<[f64; 3]> {
        self.given(key, |known, node| match self.axes {
            2 => Ok([0.0, 0.0, self.finite(known, node, Dimension::SPIN)?]),
            _ => self.components(known, node, Dimension::SPIN),
        })
    }

    /// A row of rates for each axis; by default zero.
    pub fn gradient(&self, key: &str) -> [[f64; 3]; 3] {
        let rows = |known: &'static Key, node: &Node| {
            let mut gradient = [[0.0; 3]; 3];
            for (row, node) in gradient.iter_mut().zip(self.items(known, node, "a row of rates (1/s)")?) {
                *row = self.components(known, node, Dimension::RATE)?;
            }
            Ok(gradient)
        };
        self.given(key, rows).unwrap_or_default()
    }

    /// For each axis a stress, or none where it is "free".
    pub fn stresses(&self, key: &str) -> Option<[Option<f64>; 3]> {
        self.given(key, |known, node| {
            let mut stresses = [None; 3];
            for (stress, node) in stresses.iter_mut().zip(self.items(known, node, "a stress (Pa) or \"free\"")?) {
                *stress = match &node.value {
                    Value::Text(word) if word == "free" => None,
                    Value::Text(word) if word.starts_with(char::is_alphabetic) => {
                        return Err(self.refuse(known, node, "is neither a stress nor \"free\"."));
                    }
                    _ => Some(self.finite(known, node, Dimension::STRESS)?),
                };
            }
            Ok(stresses)
        })
    }

    /// Pairs of a length and a share, all positive.
    pub fn shares(&self, key: &str) -> Vec<(f64, f64)> {
        self.required(key, |known, node| {
            let wanted = "is refused: a list of pairs is wanted, each a length (m) and a share, both more than 0.";
            let refused = || self.refuse(known, node, wanted);
            self.refuse_entries(known, node, ENTRIES_MAX)?;
            if node.list().is_empty() {
                return Err(refused());
            }
            let pairs = node.list().iter().map(|pair| match pair.list() {
                [length, share] => {
                    let length = self.finite(known, length, Dimension::LENGTH)?;
                    let share = self.finite(known, share, Dimension::RATIO)?;
                    if length > 0.0 && share > 0.0 { Ok((length, share)) } else { Err(refused()) }
                }
                _ => Err(refused()),
            });
            pairs.collect()
        })
    }

    /// Corners of a polygon in the plane.
    pub fn polygon(&self, key: &str) -> Vec<[f64; 2]> {
        self.required(key, |known, node| {
            let wanted = "is refused: a list of three or more points is wanted, each two lengths (m).";
            let refused = || self.refuse(known, node, wanted);
            if node.list().len() < 3 {
                return Err(refused());
            }
            self.refuse_entries(known, node, ENTRIES_MAX)?;
            let corners = node.list().iter().map(|point| match point.list() {
                [x, y] => {
                    let length = |node| self.finite(known, node, Dimension::LENGTH);
                    Ok([length(x)?, length(y)?])
                }
                _ => Err(refused()),
            });
            corners.collect()
        })
    }

    /// A reader of the table that a key holds, such as `servo = { ... }`.
    pub fn inner(&self, key: &str) -> Option<Reader<'a>> {
        let known = self.known(key);
        let Wants::Table(table) = known.wants else {
            panic!("{} is not a table in the schema", self.table.path(key));
        };
        let entry = self.find(key)?;
        if matches!(entry.node.value, Value::Table(_)) {
            return Some(self.reader_of(table, &entry.node));
        }
        let words = entry.node.value.words();
        let problem = format!("is {words}, but a table with the keys {} is wanted.", table.key_list());
        self.typed.note(Some(entry.place), self.refuse(known, &entry.node, &problem));
        None
    }

    /// Readers of the tables of a list such as `[[continuum.weak]]`.
    pub fn tables(&self, key: &str) -> Vec<Reader<'a>> {
        let Wants::Tables(table) = self.known(key).wants else {
            panic!("{} is not a list of tables in the schema", self.table.path(key));
        };
        let Some(entry) = self.find(key) else {
            return Vec::new();
        };
        let refused = |node: &Node| {
            let path = self.table.path(key);
            let message = format!(
                "{path} is {}, but a list of tables is wanted. Write [[{path}]] on a line of its own, and {} below.",
                node.value.words(),
                table.key_list()
            );
            self.typed.note(Some(node.place), self.typed.told(Some(node.place), &message));
        };
        let Value::List(nodes) = &entry.node.value else {
            refused(&entry.node);
            return Vec::new();
        };
        let most = if key == "path" { TIMES_MAX } else { ENTRIES_MAX };
        if let Err(error) = self.refuse_entries(self.known(key), &entry.node, most) {
            self.typed.note(Some(entry.place), error);
            return Vec::new();
        }
        nodes.iter().filter(|node| !matches!(node.value, Value::Table(_))).for_each(refused);
        let tables = nodes.iter().filter(|node| matches!(node.value, Value::Table(_)));
        tables.map(|node| self.reader_of(table, node)).collect()
    }

    /// An error at a key of this table; `problem` says what is wrong and what to do.
    pub fn refusal(&self, key: &str, problem: &str) -> Error {
        match self.find(key) {
            Some(entry) => self.found(self.known(key), &entry.node, problem),
            None => self.missing(key),
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

    fn known(&self, key: &str) -> &'static Key {
        self.table.key(key).unwrap_or_else(|| panic!("the schema has no key {}", self.table.path(key)))
    }

    fn find(&self, key: &str) -> Option<&'a Entry> {
        self.node.and_then(|node| node.get(key))
    }

    fn reader_of(&self, table: &'static Table, node: &'a Node) -> Reader<'a> {
        Reader::new(self.typed, table, Some(node), true).with_axes(self.axes)
    }

    /// The items of a list that has one for each axis.
    fn items<'n>(&self, known: &Key, node: &'n Node, each: &str) -> Result<&'n [Node], Error> {
        let items = node.list();
        if items.len() == self.axes {
            return Ok(items);
        }
        let count = if self.axes == 2 { "two" } else { "three" };
        Err(self.refuse(known, node, &format!("is refused: a list of {count} is wanted, each {each}.")))
    }

    fn components(&self, known: &Key, node: &Node, dimension: Dimension) -> Result<[f64; 3], Error> {
        let mut vector = [0.0; 3];
        for (component, node) in vector.iter_mut().zip(self.items(known, node, &with_unit(dimension))?) {
            *component = self.finite(known, node, dimension)?;
        }
        Ok(vector)
    }

    fn flag(&self, known: &Key, node: &Node) -> Result<bool, Error> {
        match node.value {
            Value::Flag(flag) => Ok(flag),
            ref other => Err(self.refuse(known, node, &format!("is {}, but true or false is wanted.", other.words()))),
        }
    }

    fn finite(&self, known: &Key, node: &Node, wanted: Dimension) -> Result<f64, Error> {
        match self.quantity(known, node, wanted)? {
            value if value.is_finite() => self.refuse_size(known, node, value).map(|()| value),
            _ => Err(self.refuse(known, node, "is out of range: it must be finite.")),
        }
    }

    /// What follows from a number beyond these sizes may be no number any more.
    fn refuse_size(&self, known: &Key, node: &Node, value: f64) -> Result<(), Error> {
        if value == 0.0 || (SIZE_MIN..=SIZE_MAX).contains(&value.abs()) {
            return Ok(());
        }
        let problem =
            format!("is out of range: in SI units, sizes from {SIZE_MIN:e} to {SIZE_MAX:e} are allowed, and 0.");
        Err(self.refuse(known, node, &problem))
    }

    fn refuse_entries(&self, known: &Key, node: &Node, max: usize) -> Result<(), Error> {
        match node.list().len() {
            count if count > max => {
                let path = self.table.path(known.name);
                let message = format!("{path} has {count} entries, and at most {max} are allowed. Join some, or remove them.");
                Err(self.typed.told(Some(node.place), &message))
            }
            _ => Ok(()),
        }
    }

    fn quantity(&self, known: &Key, node: &Node, wanted: Dimension) -> Result<f64, Error> {
        let problem = match &node.value {
            Value::Integer(value) => return Ok(*value as f64),
            Value::Float(value) => return Ok(*value),
            Value::Text(text) => match quantity(text, wanted) {
                Ok(value) => return Ok(value),
                Err(refusal) => describe(&refusal, wanted),
            },
            other => format!("is {}, but {} is wanted.", other.words(), wanted.words()),
        };
        Err(self.refuse(known, node, &problem))
    }

    fn missing(&self, key: &str) -> Error {
        let known = self.known(key);
        let message = format!(
            "{} has no {key}, {}. Add for example {key} = {}.",
            self.table.words(),
            known.about,
            known.example(self.axes)
        );
        self.typed.told(self.place(), &message)
    }

    /// An error at a value, with an example of what would be right.
    fn refuse(&self, known: &Key, node: &Node, problem: &str) -> Error {
        let example = known.example(self.axes);
        self.found(known, node, &format!("{problem} Write for example {} = {example}.", known.name))
    }

    fn found(&self, known: &Key, node: &Node, problem: &str) -> Error {
        let path = self.table.path(known.name);
        self.typed.told(Some(node.place), &format!("{path} = {} {problem}", node.typed))
    }
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
