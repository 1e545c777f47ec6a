//! The job as a tree of values that remember where they were typed, and the `--set` overrides laid over it.

use std::ops::Range as Span;

use toml::de::{DeTable, DeValue};

use super::renamed::{Renamed, lower, moved, translate};
use super::schema::Kind;
use super::write::RESOLVED;
use crate::base::error::Error;
use crate::base::units::nearest;

/// Where a value was typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    File(Spot),
    /// On the command line, by `--set`.
    Set,
}

/// A piece of a line of the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot {
    /// Counted from 1.
    pub line: usize,
    /// Characters before it on the line, and how many it has there.
    pub column: usize,
    pub length: usize,
}

impl Spot {
    /// The job as a whole.
    const TOP: Self = Self { line: 1, column: 0, length: 0 };
}

#[derive(Clone, Debug)]
pub struct Node {
    pub value: Value,
    pub place: Place,
    /// The source text, for messages.
    pub typed: String,
}

#[derive(Clone, Debug)]
pub enum Value {
    Text(String),
    Integer(i64),
    Float(f64),
    Flag(bool),
    List(Vec<Node>),
    Table(Vec<Entry>),
    /// A TOML value that no key of a job takes; with its article.
    Other(&'static str),
}

#[derive(Clone, Debug)]
pub struct Entry {
    pub key: String,
    pub place: Place,
    pub node: Node,
}

impl Node {
    /// Reads TOML, sees which kind of job it is, and lays the overrides over it.
    pub fn parse(text: &str, file: &str, sets: &[String]) -> Result<(Self, Kind), Error> {
        let source = Source::new(text);
        let document = DeTable::parse(text).map_err(|error| {
            let (place, found) = match error.span() {
                Some(span) => {
                    let line = source.line_of(span.start);
                    (format!("{file}:{line}"), format!(", in `{}`", short(text.lines().nth(line - 1).unwrap_or_default())))
                }
                None => (file.to_string(), String::new()),
            };
            let message = error.message().trim().replace('\n', ", ");
            Error::User(format!(
                "{place}: this is not TOML: {message}{found}. Text and quantities with a unit go in quotes, as in width = \"6 cm\"."
            ))
        })?;
        let mut root = Self {
            value: entries(document.into_inner(), &source),
            place: Place::File(Spot::TOP),
            typed: String::new(),
        };
        // The file alone decides, so that no override can turn a job into one of the other kind.
        let has = |table: &str| root.get(table).is_some_and(|entry| matches!(entry.node.value, Value::Table(_)));
        let marked = [Kind::Assembly, Kind::Mpm].into_iter().find(|kind| kind.marks().iter().any(|mark| has(mark)));
        let kind = marked.unwrap_or(Kind::Shear);
        lower(&mut root, kind);
        // In a run's folder the line that names the run stands above.
        if text.lines().take(2).any(|line| line.starts_with(RESOLVED)) {
            translate(&mut root, kind);
        }
        for set in sets {
            apply_set(&mut root, kind, set)?;
        }
        Ok((root, kind))
    }

    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries().iter().find(|entry| entry.key == key)
    }

    pub fn get_mut(&mut self, key: &str) -> Option<&mut Entry> {
        match &mut self.value {
            Value::Table(entries) => entries.iter_mut().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// Puts an entry into one of its tables, which is made where there is none; gives back one whose key is there already.
    pub fn put(&mut self, table: &str, entry: Entry) -> Option<Entry> {
        let Value::Table(tables) = &mut self.value else { return Some(entry) };
        let at = tables.iter().position(|known| known.key == table).unwrap_or_else(|| {
            let node = Self { value: Value::Table(Vec::new()), place: entry.place, typed: String::new() };
            tables.push(Entry { key: table.to_string(), place: entry.place, node });
            tables.len() - 1
        });
        match &mut tables[at].node.value {
            Value::Table(entries) if entries.iter().all(|known| known.key != entry.key) => {
                entries.push(entry);
                None
            }
            _ => Some(entry),
        }
    }

    pub fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    pub fn list(&self) -> &[Node] {
        match &self.value {
            Value::List(nodes) => nodes,
            _ => &[],
        }
    }
}

impl Value {
    /// With its article, for a sentence.
    pub fn words(&self) -> &'static str {
        match self {
            Self::Text(_) => "text",
            Self::Integer(_) | Self::Float(_) => "a number",
            Self::Flag(_) => "a truth value",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
            Self::Other(words) => words,
        }
    }
}

/// A text and where its lines end.
struct Source<'a> {
    text: &'a str,
    ends: Vec<usize>,
}

impl<'a> Source<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, ends: text.match_indices('\n').map(|(at, _)| at).collect() }
    }

    fn line_of(&self, offset: usize) -> usize {
        1 + self.ends.partition_point(|end| *end < offset)
    }

    /// Where a stretch of the source begins, and what of it is on that line.
    fn place(&self, span: Span<usize>) -> Place {
        let line = self.line_of(span.start);
        let start = if line > 1 { self.ends[line - 2] + 1 } else { 0 };
        let end = self.ends.get(line - 1).copied().unwrap_or(self.text.len());
        let count = |from: usize, to: usize| self.text.get(from..to).map_or(0, |text| text.chars().count());
        let length = count(span.start, span.end.min(end));
        Place::File(Spot { line, column: count(start, span.start), length })
    }

    /// The source between two offsets as messages show it.
    fn typed(&self, span: Span<usize>) -> String {
        short(self.text.get(span).unwrap_or_default())
    }
}

/// On one line, cut where a message would grow long. What cannot be seen is shown as a question mark.
pub fn short(source: &str) -> String {
    let mut line = String::new();
    let shown = |c: char| if c.is_control() && !c.is_whitespace() { '?' } else { c };
    let seen: String = source.chars().take(1000).map(shown).collect();
    for word in seen.split_whitespace() {
        let gap = if line.is_empty() { "" } else { " " };
        line.extend([gap, word]);
    }
    if line.chars().count() <= 60 {
        return line;
    }
    let head: String = line.chars().take(57).collect();
    format!("{head}...")
}

fn entries(table: DeTable<'_>, source: &Source<'_>) -> Value {
    let entries = table
        .into_iter()
        .map(|(key, value)| Entry {
            place: source.place(key.span()),
            key: key.into_inner().into_owned(),
            node: node(value, source),
        })
        .collect();
    Value::Table(entries)
}

fn node(value: toml::Spanned<DeValue<'_>>, source: &Source<'_>) -> Node {
    let span = value.span();
    let (place, typed) = (source.place(span.clone()), source.typed(span));
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(digits) => match i64::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(value) => Value::Integer(value),
            Err(_) => Value::Other("a whole number beyond 64 bits"),
        },
        DeValue::Float(digits) => match digits.as_str().parse() {
            Ok(value) => Value::Float(value),
            Err(_) => Value::Other("a number that cannot be read"),
        },
        DeValue::Boolean(value) => Value::Flag(value),
        DeValue::Datetime(_) => Value::Other("a date"),
        DeValue::Array(items) => Value::List(items.into_iter().map(|item| node(item, source)).collect()),
        DeValue::Table(table) => entries(table, source),
    };
    Node { value, place, typed }
}

/// A value as it would be typed right of the equals sign; none where it is no TOML.
pub fn typed_value(text: &str) -> Option<Node> {
    DeValue::parse(text).ok().map(|value| node(value, &Source::new(text)))
}

/// Lays one `key.path=value` over the tree. The value is TOML where it parses as TOML, and text otherwise.
fn apply_set(root: &mut Node, kind: Kind, whole: &str) -> Result<(), Error> {
    let set = short(whole);
    let Some((path, text)) = whole.split_once('=') else {
        return Err(Error::User(format!(
            "--set {set}: there is no equals sign. Write for example --set loading.speed=\"5 cm/s\"."
        )));
    };
    let (path, text) = (path.trim(), text.trim());
    if text.is_empty() {
        return Err(Error::User(format!(
            "--set {set}: there is nothing behind the equals sign. Write for example --set loading.speed=\"5 cm/s\"."
        )));
    }
    let typed: Vec<&str> = path.split('.').collect();
    let moved = moved(kind, &typed);
    let parts = moved.as_ref().map_or(&typed[..], |place| &place[..]);
    refuse_unknown_path(&set, kind, parts)?;
    let mut value = match typed_value(text) {
        Some(value) => value,
        None => {
            let typed = format!("\"{}\"", short(text));
            Node { value: Value::Text(text.to_string()), place: Place::Set, typed }
        }
    };
    value.mark_as_set();
    insert(root, parts, value, &set)
}

impl Node {
    fn mark_as_set(&mut self) {
        self.place = Place::Set;
        match &mut self.value {
            Value::List(nodes) => nodes.iter_mut().for_each(Self::mark_as_set),
            Value::Table(entries) => {
                for entry in entries {
                    entry.place = Place::Set;
                    entry.node.mark_as_set();
                }
            }
            _ => {}
        }
    }
}

/// The parts must lead to a key of the schema; `continuum.weak.0.lower` reaches into the first region.
fn refuse_unknown_path(set: &str, kind: Kind, parts: &[&str]) -> Result<(), Error> {
    if kind.leads_to_a_key(parts) {
        return Ok(());
    }
    let typed = short(&parts.join("."));
    if let [table, key] = parts
        && let Some(renamed) = Renamed::of(kind, table, key)
    {
        let text = set.split_once('=').map_or("", |(_, text)| text.trim());
        let advice = typed_value(text).map(|value| renamed.advice(&value)).unwrap_or_default();
        return Err(Error::User(format!("--set {set}: a job has no {typed}. {advice}")));
    }
    if kind == Kind::Shear && parts == ["time", "end"] {
        return Err(Error::User(format!(
            "--set {set}: a job of planar shear has no {typed}; it ends at a strain. Set loading.strain_end, for example --set loading.strain_end=0.2."
        )));
    }
    if let Some(advice) = kind.belongs_elsewhere(|other| other.leads_to_a_key(parts)) {
        return Err(Error::User(format!("--set {set}: a job has no {typed}. {advice}")));
    }
    let advice = advice_on_path(kind, parts, &typed);
    Err(Error::User(format!("--set {set}: a job has no {typed}. {advice}")))
}

/// What was meant: in the table that was named a key of nearly this name, or else one that means the word; else the same key of the
/// table whose name is nearest, or the nearest path.
fn advice_on_path(kind: Kind, parts: &[&str], typed: &str) -> String {
    let (key, tables) = parts.split_last().unwrap_or((&"", &[]));
    let named: Vec<&str> = tables.iter().copied().filter(|part| part.parse::<usize>().is_err()).collect();
    let named = named.join(".");
    let table = kind.tables_of_all_depths().into_iter().find(|table| table.name == named && !named.is_empty());
    let paths = kind.paths();
    let has_key = |path: &&str| path.strip_suffix(key).is_some_and(|before| before.is_empty() || before.ends_with('.'));
    let same_key: Vec<&str> = paths.iter().map(String::as_str).filter(has_key).collect();
    let near_table = nearest(typed, same_key.iter().copied());
    let near_key = table.and_then(|table| nearest(key, table.keys.iter().map(|known| known.name)));
    let meant = table.and_then(|table| table.keys_that_mean(key).next());
    let inside = |key: &str| tables.iter().copied().chain([key]).collect::<Vec<_>>().join(".");
    match (table, near_key, near_table, same_key.as_slice(), meant) {
        (_, Some(key), ..) => format!("Did you mean {}?", inside(key)),
        (_, _, Some(path), ..) => format!("Did you mean {path}?"),
        (.., Some(key)) => format!("Did you mean {}, {}?", inside(key.name), key.about),
        (Some(table), .., [], None) => format!("{} has: {}.", table.words(), table.key_list()),
        (.., [], None) => match nearest(typed, paths.iter().map(String::as_str)) {
            Some(path) => format!("Did you mean {path}?"),
            None => "A path is table.key, for example loading.speed.".to_string(),
        },
        (.., several, None) => format!("Did you mean {}?", several.join(" or ")),
    }
}

fn insert(node: &mut Node, parts: &[&str], value: Node, set: &str) -> Result<(), Error> {
    let [first, rest @ ..] = parts else {
        *node = value;
        return Ok(());
    };
    match &mut node.value {
        Value::Table(entries) => {
            let at = match entries.iter().position(|entry| entry.key == *first) {
                Some(at) => at,
                None => {
                    entries.push(Entry {
                        key: (*first).to_string(),
                        place: Place::Set,
                        node: Node { value: Value::Table(Vec::new()), place: Place::Set, typed: String::new() },
                    });
                    entries.len() - 1
                }
            };
            if rest.is_empty() {
                entries[at].place = Place::Set;
            }
            insert(&mut entries[at].node, rest, value, set)
        }
        Value::List(nodes) => {
            let count = nodes.len();
            let index = first.parse::<usize>().unwrap_or(usize::MAX);
            match nodes.get_mut(index) {
                Some(node) => insert(node, rest, value, set),
                None => Err(Error::User(format!(
                    "--set {set}: lists are counted from 0, and this one in the job has {count}. Give the whole list to add one."
                ))),
            }
        }
        _ => Err(Error::User(format!(
            "--set {set}: {first} lies in something that is no table in the job. Mend the job first."
        ))),
    }
}
