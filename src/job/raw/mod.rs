//! The job as typed: every key known, and readers that take one key at a time and refuse it in a sentence.

use super::schema::{Kind, Table, Wants};
use super::tree::{Entry, Node, Place, Value, short};
use super::units::nearest;
use crate::base::error::Error;

mod reader;
pub use reader::Reader;

/// A job whose keys are all known; its values are not yet read.
#[derive(Debug)]
pub struct Typed {
    pub kind: Kind,
    root: Node,
    file: String,
}

impl Typed {
    /// Reads the text of a job, lays the overrides over it and refuses keys that do not exist.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<Self, Error> {
        let (root, kind) = Node::parse(text, file, sets)?;
        let typed = Self { kind, root, file: file.to_string() };
        typed.refuse_unknown()?;
        Ok(typed)
    }

    /// A reader of one table; `awake` says that the method cannot do without it.
    pub fn table(&self, name: &str, awake: bool, why: &str) -> Result<Reader<'_>, Error> {
        let table = self.kind.table(name);
        let node = match name {
            "" => Some(&self.root),
            _ => self.root.get(name).map(|entry| &entry.node),
        };
        if node.is_none() && awake {
            let shown = match self.kind {
                Kind::Shear => "jobs/planar_shear.toml",
                Kind::Assembly => "jobs/element/uniaxial.toml",
                Kind::Mpm => "jobs/continuum/column_collapse.toml",
            };
            return Err(Error::User(format!(
                "{}: {why} needs the table [{name}] ({}), and the job has none. Add it with the keys {}; {shown} shows one.",
                self.file,
                table.about,
                table.key_list()
            )));
        }
        Ok(Reader::new(&self.file, table, node, awake))
    }

    /// An error at a key, wherever it was typed, or at the file if it was left to its default.
    pub fn refusal(&self, table: &str, key: &str, message: &str) -> Error {
        let entry = match table {
            "" => self.root.get(key),
            _ => self.root.get(table).and_then(|entry| entry.node.get(key).or(Some(entry))),
        };
        let place = entry.map(|entry| entry.place);
        let path = self.kind.table(table).path(key);
        let shown = match entry {
            Some(entry) if entry.key == key => format!("{path} = {}", entry.node.typed),
            _ => format!("{path} (by default)"),
        };
        Error::User(format!("{}: {shown} {message}", at(&self.file, place)))
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

    /// Refuses everything but these keys of one table, in what is no whole job; `what` names it.
    pub fn refuse_all_but(&self, table: &str, keys: &[&str], what: &str) -> Result<(), Error> {
        let foreign = |entry: &Entry, shown: String| {
            Error::User(format!(
                "{}: {shown} does not belong into {what}, which has one table [{table}] with {}. Move it to the job.",
                at(&self.file, Some(entry.place)),
                keys.join(", ")
            ))
        };
        for entry in self.root.entries() {
            if entry.key != table {
                return Err(foreign(entry, short(&entry.key)));
            }
            let mut inside = entry.node.entries().iter();
            if let Some(other) = inside.find(|inner| !keys.contains(&inner.key.as_str())) {
                return Err(foreign(other, format!("{table}.{}", other.key)));
            }
        }
        Ok(())
    }

    fn refuse_unknown(&self) -> Result<(), Error> {
        let mut top = self.root.entries().to_vec();
        top.sort_by_key(|entry| order(entry.place));
        for entry in &top {
            if let Some(key) = self.kind.top().key(&entry.key) {
                self.refuse_unknown_inside(key.wants, &entry.node)?;
                continue;
            }
            match self.kind.table_if_known(&entry.key) {
                Some(table) if !table.name.is_empty() => self.refuse_unknown_in(table, entry)?,
                _ => return Err(self.unknown_at_top(entry)),
            }
        }
        Ok(())
    }

    fn refuse_unknown_in(&self, table: &'static Table, entry: &Entry) -> Result<(), Error> {
        if !matches!(entry.node.value, Value::Table(_)) {
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
        }
        self.refuse_unknown_keys(table, &entry.node)
    }

    fn refuse_unknown_keys(&self, table: &'static Table, node: &Node) -> Result<(), Error> {
        let mut keys = node.entries().to_vec();
        keys.sort_by_key(|key| order(key.place));
        for key in &keys {
            let Some(known) = table.key(&key.key) else {
                return Err(self.unknown_key(table, key));
            };
            self.refuse_unknown_inside(known.wants, &key.node)?;
        }
        Ok(())
    }

    /// Tables within a key's value; what is no table there is refused when it is read.
    fn refuse_unknown_inside(&self, wants: Wants, node: &Node) -> Result<(), Error> {
        match wants {
            Wants::Table(inner) => self.refuse_unknown_keys(inner, node),
            Wants::Tables(inner) => node.list().iter().try_for_each(|item| self.refuse_unknown_keys(inner, item)),
            _ => Ok(()),
        }
    }

    fn unknown_key(&self, table: &Table, entry: &Entry) -> Error {
        let key = &entry.key;
        let has = |kind: Kind| kind.table_if_known(table.name).is_some_and(|twin| twin.key(key).is_some());
        let elsewhere = self.kind.belongs_elsewhere(has);
        let advice = match (elsewhere, nearest(key, table.keys.iter().map(|known| known.name))) {
            (Some(elsewhere), _) => elsewhere,
            (None, Some(known)) => format!("Did you mean {known}?"),
            (None, None) => match self.homes(key).as_slice() {
                [] => format!("Remove the line, or use one of: {}.", table.key_list()),
                homes => format!("There is one in {}.", homes.join(" and in ")),
            },
        };
        Error::User(format!(
            "{}: {} has no key {}. {advice}",
            at(&self.file, Some(entry.place)),
            table.words(),
            short(key)
        ))
    }

    fn unknown_at_top(&self, entry: &Entry) -> Error {
        let key = &entry.key;
        let place = at(&self.file, Some(entry.place));
        let tables = self.kind.tables().iter().map(|table| table.name).filter(|name| !name.is_empty());
        let marks = ["cell", "grid"].into_iter().filter(|_| self.kind == Kind::Shear);
        let names = tables.clone().chain(marks);
        let elsewhere = self.kind.belongs_elsewhere(|kind| match entry.node.value {
            Value::Table(_) => kind.table_if_known(key).is_some(),
            _ => kind.top().key(key).is_some(),
        });
        if matches!(entry.node.value, Value::Table(_)) {
            let advice = match (elsewhere, nearest(key, names)) {
                (Some(elsewhere), _) => elsewhere,
                (None, Some(name)) => format!("Did you mean [{name}]?"),
                (None, None) => format!("The tables of a job are: {}.", tables.collect::<Vec<_>>().join(", ")),
            };
            return Error::User(format!("{place}: there is no table [{}]. {advice}", short(key)));
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
        Error::User(format!("{place}: the job's top level has no key {}. {advice}", short(key)))
    }

    /// The tables that have a key of this name.
    fn homes(&self, key: &str) -> Vec<String> {
        let tables = self.kind.tables_of_all_depths();
        tables.iter().filter(|table| table.key(key).is_some()).map(|table| table.words()).collect()
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
