//! The job as typed: every key known, and readers that take one key at a time. What is wrong is noted, so that a person learns of
//! all mistakes at once.

use super::renamed::{Renamed, moved, moved_from};
use super::schema::Kind;
use super::tree::{Entry, Node, Place, Value, short};
use crate::base::error::Error;
use crate::base::keys::{Table, Wants};
use crate::base::units::nearest;

mod mistakes;
mod reader;

use mistakes::Mistakes;
pub use reader::Reader;

/// Keys that do not exist which are compared with one that is missing.
const STRANGE_MAX: usize = 20;

/// A job whose values are not yet read.
#[derive(Debug)]
pub struct Typed {
    /// What its tables make of it.
    pub kind: Kind,
    root: Node,
    file: String,
    text: String,
    mistakes: Mistakes,
}

impl Typed {
    /// Reads the text of a job, lays the overrides over it and notes keys that do not exist.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<Self, Error> {
        let (root, kind) = Node::parse(text, file, sets)?;
        let (file, text) = (file.to_string(), text.to_string());
        let typed = Self { kind, root, file, text, mistakes: Mistakes::default() };
        typed.note_unknown();
        Ok(typed)
    }

    /// Notes a mistake within one key.
    pub(super) fn note(&self, place: Option<Place>, error: Error) {
        self.mistakes.note(place, error);
    }

    /// Notes a mistake of keys that are good by themselves and do not go together.
    pub fn note_together(&self, error: Error) {
        self.mistakes.note_together(error);
    }

    /// The same of a check that has failed.
    pub fn check(&self, outcome: Result<(), Error>) {
        if let Err(error) = outcome {
            self.note_together(error);
        }
    }

    /// Ends reading where something has been noted, before anything is done that trusts all of it.
    pub fn stop_if_wrong(&self) -> Result<(), Error> {
        self.settled(Ok(()))
    }

    /// What came of reading and checking, or all mistakes.
    pub fn settled<T>(&self, outcome: Result<T, Error>) -> Result<T, Error> {
        self.mistakes.settled(&self.file, outcome)
    }

    /// A reader of one table; `awake` says that the method cannot do without it.
    pub fn table(&self, name: &str, awake: bool, why: &str) -> Reader<'_> {
        let table = self.kind.table(name);
        let node = match name {
            "" => Some(&self.root),
            _ => self.root.get(name).map(|entry| &entry.node),
        };
        let node = node.filter(|node| matches!(node.value, Value::Table(_)));
        if node.is_none() && awake && self.root.get(name).is_none() && !self.is_misspelt(name) {
            let shown = match self.kind {
                Kind::Shear => "jobs/planar_shear.toml",
                Kind::Assembly => "jobs/element/uniaxial.toml",
                Kind::Mpm => "jobs/continuum/column_collapse.toml",
            };
            let missing = format!(
                "{}: {why} needs the table [{name}] ({}), and the job has none. Add it with the keys {}; {shown} shows one.",
                self.file,
                table.about,
                table.key_list()
            );
            self.note(None, Error::User(missing));
        }
        Reader::new(self, table, node, awake)
    }

    /// The same of a table that a job may do without: what is required in it is so where it was typed.
    pub fn table_if_typed(&self, name: &str) -> Reader<'_> {
        self.table(name, self.root.get(name).is_some(), "")
    }

    /// Whether a table that does not exist has been taken for this one.
    fn is_misspelt(&self, name: &str) -> bool {
        let names = || self.kind.tables().iter().map(|table| table.name.as_str()).filter(|name| !name.is_empty());
        let strange = self.root.entries().iter().filter(|entry| self.kind.table_if_known(&entry.key).is_none());
        strange.take(STRANGE_MAX).any(|entry| nearest(&entry.key, names()) == Some(name))
    }

    /// A place, and the error there with the line that it is on.
    fn told(&self, place: Option<Place>, message: &str) -> Error {
        let shown = mistakes::excerpt(&self.text, place).unwrap_or_default();
        Error::User(format!("{}: {message}{shown}", at(&self.file, place)))
    }

    /// An error at a key, wherever it was typed, or at the file if it was left to its default.
    pub fn refusal(&self, table: &str, key: &str, message: &str) -> Error {
        let entry = match table {
            "" => self.root.get(key),
            _ => self.root.get(table).and_then(|entry| entry.node.get(key).or(Some(entry))),
        };
        let path = self.kind.table(table).path(key);
        let shown = match entry {
            Some(entry) if entry.key == key => format!("{path} = {}", entry.node.typed),
            _ => format!("{path} (by default)"),
        };
        let place = entry.map(|entry| if entry.key == key { entry.node.place } else { entry.place });
        self.told(place, &format!("{shown} {message}"))
    }

    /// An error at the job as a whole.
    pub fn refusal_of_all(&self, message: &str) -> Error {
        Error::User(format!("{}: {message}", self.file))
    }

    /// Where a key of a table was typed, if it was.
    pub fn place_of(&self, table: &str, key: &str) -> Option<String> {
        let entry = self.root.get(table)?.node.get(key)?;
        Some(at(&self.file, Some(entry.place)))
    }

    /// Notes everything but these keys of one table, in what is no whole job; `what` names it.
    pub fn note_all_but(&self, table: &str, keys: &[&str], what: &str) {
        let foreign = |entry: &Entry, shown: &str| {
            let message = format!(
                "{shown} does not belong into {what}, which has one table [{table}] with {}. Move it to the job.",
                keys.join(", ")
            );
            self.note(Some(entry.place), self.told(Some(entry.place), &message));
        };
        for entry in self.root.entries() {
            if entry.node.entries().is_empty() {
                foreign(entry, &short(&entry.key));
            }
            for inner in entry.node.entries() {
                if entry.key != table || !keys.contains(&inner.key.as_str()) {
                    foreign(inner, &short(&format!("{}.{}", entry.key, inner.key)));
                }
            }
        }
    }

    fn note_unknown(&self) {
        for entry in self.root.entries() {
            if self.mistakes.are_enough() {
                return;
            }
            if let Some(key) = self.kind.top().key(&entry.key) {
                self.note_unknown_inside(&key.wants, &entry.node);
                continue;
            }
            let message = match self.kind.table_if_known(&entry.key) {
                Some(table) if !table.name.is_empty() => match entry.node.value {
                    Value::Table(_) => {
                        self.note_unknown_keys(table, &entry.node);
                        continue;
                    }
                    _ => format!(
                        "{0} = {1} is {2}, but {0} is a table ({3}). Write [{0}] on a line of its own and its keys below.",
                        entry.key,
                        entry.node.typed,
                        entry.node.value.words(),
                        table.about,
                    ),
                },
                _ => self.unknown_at_top(entry),
            };
            self.note(Some(entry.place), self.told(Some(entry.place), &message));
        }
    }

    fn note_unknown_keys(&self, table: &Table, node: &Node) {
        for entry in node.entries() {
            if self.mistakes.are_enough() {
                return;
            }
            match table.key(&entry.key) {
                Some(known) => self.note_unknown_inside(&known.wants, &entry.node),
                None => self.note(Some(entry.place), self.told(Some(entry.place), &self.unknown_key(table, entry))),
            }
        }
    }

    /// Tables within a key's value; what is no table there is noted when it is read.
    fn note_unknown_inside(&self, wants: &Wants, node: &Node) {
        match wants {
            Wants::Table(inner) => self.note_unknown_keys(inner, node),
            Wants::Tables(inner) => node.list().iter().for_each(|item| self.note_unknown_keys(inner, item)),
            _ => {}
        }
    }

    fn unknown_key(&self, table: &Table, entry: &Entry) -> String {
        let key = &entry.key;
        if let Some(renamed) = Renamed::of(self.kind, &table.name, key) {
            return format!("{} has no key {key}. {}", table.words(), renamed.advice(&entry.node));
        }
        if let Some([now, name]) = moved(self.kind, &[&table.name, key]) {
            let place = format!("It is {now}.{name} now, and that is there already. Remove one of the two.");
            return format!("{} has no key {key}. {place}", table.words());
        }
        let has = |kind: Kind| kind.table_if_known(&table.name).is_some_and(|twin| twin.key(key).is_some());
        let elsewhere = self.kind.belongs_elsewhere(has);
        let known = table.keys.iter().map(|known| known.name).chain(moved_from(self.kind, &table.name));
        let advice = match (elsewhere, nearest(key, known)) {
            (Some(elsewhere), _) => elsewhere,
            (None, Some(known)) => format!("Did you mean {known}?"),
            (None, None) => match (self.homes(key).as_slice(), table.keys_that_mean(key).next()) {
                ([], Some(meant)) => format!("Did you mean {}, {}?", meant.name, meant.about),
                ([], None) => format!("Remove the line, or use one of: {}.", table.key_list()),
                (homes, _) => format!("There is one in {}.", homes.join(" and in ")),
            },
        };
        format!("{} has no key {}. {advice}", table.words(), short(key))
    }

    fn unknown_at_top(&self, entry: &Entry) -> String {
        let key = &entry.key;
        let tables = self.kind.tables().iter().map(|table| table.name.as_str()).filter(|name| !name.is_empty());
        let marks = ["cell", "grid", "mesh"].into_iter().filter(|_| self.kind == Kind::Shear);
        let names = tables.clone().chain(marks);
        let elsewhere = self.kind.belongs_elsewhere(|kind| match entry.node.value {
            Value::Table(_) => kind.table_if_known(key).is_some(),
            _ => kind.top().key(key).is_some(),
        });
        if matches!(entry.node.value, Value::Table(_)) {
            if self.kind == Kind::Assembly && key == "gravity" && self.root.get("grid").is_none() {
                return "there is no table [gravity] in an assembly of grains. Here gravity is a key of [cell]: gravity = [0, \"-9.81 m/s2\"].".into();
            }
            let advice = match (elsewhere, nearest(key, names)) {
                (Some(elsewhere), _) => elsewhere,
                (None, Some(name)) => format!("Did you mean [{name}]?"),
                (None, None) => format!("The tables of a job are: {}.", tables.collect::<Vec<_>>().join(", ")),
            };
            return format!("there is no table [{}]. {advice}", short(key));
        }
        let advice = match (elsewhere, self.homes(key).as_slice()) {
            (Some(elsewhere), _) => elsewhere,
            (None, []) => {
                let known = self.kind.top().keys.iter().map(|known| known.name);
                match nearest(key, known.chain(names)) {
                    Some(name) => format!("Did you mean {name}?"),
                    None => format!("Above the first table a job has: {}.", self.kind.top().key_list()),
                }
            }
            (None, homes) => format!("It belongs in {}.", homes.join(" or in ")),
        };
        format!("the job's top level has no key {}. {advice}", short(key))
    }

    /// The tables that have a key of this name.
    fn homes(&self, key: &str) -> Vec<String> {
        let tables = self.kind.tables_of_all_depths();
        tables.iter().filter(|table| table.key(key).is_some()).map(|table| table.words()).collect()
    }
}

fn at(file: &str, place: Option<Place>) -> String {
    match place {
        Some(Place::File(spot)) => format!("{file}:{}", spot.line),
        Some(Place::Set) => "--set".to_string(),
        None => file.to_string(),
    }
}
