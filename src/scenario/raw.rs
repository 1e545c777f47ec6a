//! The job as typed: every key known, and readers that take one key at a time and refuse it in a sentence.

use super::schema::{Key, TABLES, Table, WEAK, Wants};
use super::tree::{Entry, Node, Place, Value};
use super::units::{Dimension, Refusal, nearest, quantity};
use crate::error::Error;

/// A job whose keys are all known; its values are not yet read.
#[derive(Debug)]
pub struct Job {
    root: Node,
    file: String,
}

impl Job {
    /// Reads the text of a job, lays the overrides over it and refuses keys that do not exist.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<Self, Error> {
        let root = Node::parse(text, file, sets)?;
        let job = Self { root, file: file.to_string() };
        job.refuse_unknown()?;
        Ok(job)
    }

    /// A reader of one table; `awake` says that the method cannot do without it.
    pub fn table(&self, name: &str, awake: bool, why: &str) -> Result<Reader<'_>, Error> {
        let table = Table::named(name);
        let node = match name {
            "" => Some(&self.root),
            _ => self.root.get(name).map(|entry| &entry.node),
        };
        if node.is_none() && awake {
            return Err(Error::User(format!(
                "{}: {why} needs the table [{name}] ({}), and the job has none. Add it with the keys {}; jobs/planar_shear.toml shows one.",
                self.file,
                table.about,
                table.key_list()
            )));
        }
        Ok(Reader { file: &self.file, table, node, awake })
    }

    /// An error at a key, wherever it was typed, or at the file if it was left to its default.
    pub fn refusal(&self, table: &str, key: &str, message: &str) -> Error {
        let entry = match table {
            "" => self.root.get(key),
            _ => self.root.get(table).and_then(|entry| entry.node.get(key).or(Some(entry))),
        };
        let place = entry.map(|entry| entry.place);
        let path = Table::named(table).path(key);
        let shown = match entry {
            Some(entry) if entry.key == key => format!("{path} = {}", entry.node.typed),
            _ => format!("{path} (by default)"),
        };
        Error::User(format!("{}: {shown} {message}", at(&self.file, place)))
    }

    fn refuse_unknown(&self) -> Result<(), Error> {
        let mut top = self.root.entries().to_vec();
        top.sort_by_key(|entry| order(entry.place));
        for entry in &top {
            let Some(table) = TABLES.iter().find(|table| table.name == entry.key) else {
                if TABLES[0].key(&entry.key).is_some() {
                    continue;
                }
                return Err(self.unknown_at_top(entry));
            };
            if table.name.is_empty() {
                return Err(self.unknown_at_top(entry));
            }
            self.refuse_unknown_in(table, entry)?;
        }
        Ok(())
    }

    fn refuse_unknown_in(&self, table: &'static Table, entry: &Entry) -> Result<(), Error> {
        let Value::Table(keys) = &entry.node.value else {
            return Err(Error::User(format!(
                "{}: {} = {} is {}, but {} is a table ({}). Write [{}] on a line of its own and its keys below.",
                at(&self.file, Some(entry.place)),
                entry.key,
                entry.node.typed,
                entry.node.value.words(),
                entry.key,
                table.about,
                entry.key
            )));
        };
        let mut keys = keys.clone();
        keys.sort_by_key(|key| order(key.place));
        for key in &keys {
            let Some(known) = table.key(&key.key) else {
                return Err(self.unknown_key(table, key));
            };
            if matches!(known.wants, Wants::Regions) {
                for region in key.node.list() {
                    let mut parts = region.entries().to_vec();
                    parts.sort_by_key(|part| order(part.place));
                    if let Some(part) = parts.iter().find(|part| WEAK.key(&part.key).is_none()) {
                        return Err(self.unknown_key(&WEAK, part));
                    }
                }
            }
        }
        Ok(())
    }

    fn unknown_key(&self, table: &Table, entry: &Entry) -> Error {
        let key = &entry.key;
        let advice = match nearest(key, table.keys.iter().map(|known| known.name)) {
            Some(known) => format!("Did you mean {known}?"),
            None => match homes(key).as_slice() {
                [] => format!("Remove the line, or use one of: {}.", table.key_list()),
                homes => format!("There is one in {}.", homes.join(" and in ")),
            },
        };
        Error::User(format!("{}: {} has no key {key}. {advice}", at(&self.file, Some(entry.place)), table.words()))
    }

    fn unknown_at_top(&self, entry: &Entry) -> Error {
        let key = &entry.key;
        let place = at(&self.file, Some(entry.place));
        let names = || {
            let tables = TABLES.iter().map(|table| table.name);
            tables.filter(|name| !name.is_empty())
        };
        if matches!(entry.node.value, Value::Table(_)) {
            let advice = match nearest(key, names()) {
                Some(name) => format!("Did you mean [{name}]?"),
                None => format!("The tables of a job are: {}.", names().collect::<Vec<_>>().join(", ")),
            };
            return Error::User(format!("{place}: there is no table [{key}]. {advice}"));
        }
        let advice = match homes(key).as_slice() {
            [] => {
                let known = TABLES[0].keys.iter().map(|known| known.name);
                match nearest(key, known.chain(names())) {
                    Some(name) => format!("Did you mean {name}?"),
                    None => format!("Above the first table a job has: {}.", TABLES[0].key_list()),
                }
            }
            homes => format!("It belongs in {}.", homes.join(" or in ")),
        };
        Error::User(format!("{place}: the job's top level has no key {key}. {advice}"))
    }
}

/// The tables that have a key of this name.
fn homes(key: &str) -> Vec<String> {
    TABLES.iter().chain([&WEAK]).filter(|table| table.key(key).is_some()).map(Table::words).collect()
}

/// One table of the job. Every getter names file, line, value and remedy when it refuses.
pub struct Reader<'a> {
    file: &'a str,
    table: &'static Table,
    node: Option<&'a Node>,
    awake: bool,
}

impl<'a> Reader<'a> {
    pub fn has(&self, key: &str) -> bool {
        self.find(key).is_some()
    }

    pub fn number(&self, key: &str) -> Result<f64, Error> {
        self.number_if_given(key)?.ok_or_else(|| self.missing(key))
    }

    pub fn number_or(&self, key: &str, default: f64) -> Result<f64, Error> {
        Ok(self.number_if_given(key)?.unwrap_or(default))
    }

    /// Required where the method needs the table; elsewhere a value that nothing will look at.
    pub fn number_awake(&self, key: &str, asleep: f64) -> Result<f64, Error> {
        match self.awake {
            true => self.number(key),
            false => self.number_or(key, asleep),
        }
    }

    pub fn number_if_given(&self, key: &str) -> Result<Option<f64>, Error> {
        let known = self.known(key);
        let Wants::Number(dimension, range) = known.wants else {
            panic!("{} is not a number in the schema", self.table.path(key));
        };
        let Some(entry) = self.find(key) else {
            return Ok(None);
        };
        let value = self.quantity(known, &entry.node, dimension)?;
        if !range.contains(value) {
            let allowed = range.words(&dimension.unit());
            return Err(self.refuse(known, &entry.node, &format!("is out of range: it must be {allowed}.")));
        }
        Ok(Some(value))
    }

    pub fn count_or(&self, key: &str, default: u64) -> Result<u64, Error> {
        Ok(self.count_if_given(key)?.unwrap_or(default))
    }

    pub fn count_if_given(&self, key: &str) -> Result<Option<u64>, Error> {
        let known = self.known(key);
        let Wants::Count(min, max) = known.wants else {
            panic!("{} is not a count in the schema", self.table.path(key));
        };
        let Some(entry) = self.find(key) else {
            return Ok(None);
        };
        let value = match entry.node.value {
            Value::Integer(value) => u64::try_from(value).ok(),
            _ => None,
        };
        match value {
            Some(value) if (min..=max).contains(&value) => Ok(Some(value)),
            _ => {
                let allowed = match max {
                    u64::MAX => format!("{min} or more"),
                    _ => format!("between {min} and {max}"),
                };
                let problem = format!("is refused: it must be a whole number {allowed}.");
                Err(self.refuse(known, &entry.node, &problem))
            }
        }
    }

    pub fn text(&self, key: &str) -> Result<&'a str, Error> {
        self.text_if_given(key)?.ok_or_else(|| self.missing(key))
    }

    pub fn text_if_given(&self, key: &str) -> Result<Option<&'a str>, Error> {
        let known = self.known(key);
        let Some(entry) = self.find(key) else {
            return Ok(None);
        };
        match &entry.node.value {
            Value::Text(text) if !text.is_empty() => Ok(Some(text)),
            Value::Text(_) => Err(self.refuse(known, &entry.node, "is empty.")),
            other => {
                let problem = format!("is {}, but text in quotes is wanted.", other.words());
                Err(self.refuse(known, &entry.node, &problem))
            }
        }
    }

    /// Readers of the tables of a list such as `[[continuum.weak]]`.
    pub fn regions(&self, key: &str) -> Result<Vec<Reader<'a>>, Error> {
        let Some(entry) = self.find(key) else {
            return Ok(Vec::new());
        };
        let refused = |node: &Node| {
            Error::User(format!(
                "{}: {} is {}, but a list of tables is wanted. Write [[{}]] on a line of its own, and {} below.",
                at(self.file, Some(node.place)),
                self.table.path(key),
                node.value.words(),
                self.table.path(key),
                WEAK.key_list()
            ))
        };
        let Value::List(nodes) = &entry.node.value else {
            return Err(refused(&entry.node));
        };
        nodes
            .iter()
            .map(|node| match node.value {
                Value::Table(_) => Ok(Reader { file: self.file, table: &WEAK, node: Some(node), awake: true }),
                _ => Err(refused(node)),
            })
            .collect()
    }

    /// Two lengths.
    pub fn corner(&self, key: &str) -> Result<[f64; 2], Error> {
        let known = self.known(key);
        let entry = self.find(key).ok_or_else(|| self.missing(key))?;
        match entry.node.list() {
            [x, y] => Ok([self.quantity(known, x, Dimension::LENGTH)?, self.quantity(known, y, Dimension::LENGTH)?]),
            _ => Err(self.refuse(known, &entry.node, "is refused: two lengths are wanted.")),
        }
    }

    /// An error at a key of this table; `problem` says what is wrong and what to do.
    pub fn refusal(&self, key: &str, problem: &str) -> Error {
        match self.find(key) {
            Some(entry) => self.found(self.known(key), &entry.node, problem),
            None => self.missing(key),
        }
    }

    /// The line of the table itself.
    pub fn place(&self) -> String {
        at(self.file, self.node.map(|node| node.place))
    }

    fn known(&self, key: &str) -> &'static Key {
        self.table.key(key).unwrap_or_else(|| panic!("the schema has no key {}", self.table.path(key)))
    }

    fn find(&self, key: &str) -> Option<&'a Entry> {
        self.node.and_then(|node| node.get(key))
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
        Error::User(format!(
            "{}: {} has no {key}, {}. Add for example {key} = {}.",
            self.place(),
            self.table.words(),
            known.about,
            known.example
        ))
    }

    /// An error at a value, with an example of what would be right.
    fn refuse(&self, known: &Key, node: &Node, problem: &str) -> Error {
        self.found(known, node, &format!("{problem} Write for example {} = {}.", known.name, known.example))
    }

    fn found(&self, known: &Key, node: &Node, problem: &str) -> Error {
        let path = self.table.path(known.name);
        Error::User(format!("{}: {path} = {} {problem}", at(self.file, Some(node.place)), node.typed))
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
            format!("has no known unit: there is no \"{symbol}\".")
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

fn at(file: &str, place: Option<Place>) -> String {
    match place {
        Some(Place::Line(line)) => format!("{file}:{line}"),
        Some(Place::Set) => "--set".to_string(),
        None => file.to_string(),
    }
}

/// File order, the command line last.
fn order(place: Place) -> usize {
    match place {
        Place::Line(line) => line,
        Place::Set => usize::MAX,
    }
}
