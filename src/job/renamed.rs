//! Keys that were called otherwise, and keys that have come later. A job that a person wrote is told of the new name; one that a run keeps
//! is read under it, and does what it did before the key was there.

use super::schema::Kind;
use super::tree::{Entry, Node, Place, Value};

/// A key under its old name and its new one, in the same table.
pub struct Renamed {
    kind: Kind,
    table: &'static str,
    old: &'static str,
    pub new: &'static str,
    /// Its values have the opposite sign now, for this reason.
    turned: Option<&'static str>,
}

const RENAMED: [Renamed; 4] = [
    Renamed {
        kind: Kind::Assembly,
        table: "cell",
        old: "stress",
        new: "stress_normal",
        turned: Some("compression is positive in all that jobs call stress or pressure"),
    },
    balance(Kind::Shear),
    balance(Kind::Assembly),
    balance(Kind::Mpm),
];

const fn balance(kind: Kind) -> Renamed {
    Renamed { kind, table: "output", old: "ledger", new: "energy_balance", turned: None }
}

impl Renamed {
    pub fn of(kind: Kind, table: &str, key: &str) -> Option<&'static Self> {
        RENAMED.iter().find(|renamed| renamed.kind == kind && renamed.table == table && renamed.old == key)
    }

    /// What to write in the place of a value under the old name.
    pub fn advice(&self, value: &Node) -> String {
        let mut value = value.clone();
        if self.turned.is_some() {
            turn(&mut value);
        }
        let why = self.turned.map(|why| format!(", and {why}")).unwrap_or_default();
        format!("It is called {} now{why}. Write {} = {}.", self.new, self.new, value.typed)
    }
}

/// Keys whose default is not what programs did that had no such key, and that.
const LATER: [(Kind, &str, &str, Earlier); 3] = [
    (Kind::Mpm, "scheme", "volume_averaging", Earlier::Flag(false)),
    (Kind::Shear, "continuum", "volume_averaging", Earlier::Flag(false)),
    (Kind::Mpm, "body", "contact_at", Earlier::Text("nodes")),
];

/// What a program without a key did.
#[derive(Clone, Copy)]
enum Earlier {
    Flag(bool),
    Text(&'static str),
}

impl Earlier {
    fn value(self) -> (Value, String) {
        match self {
            Self::Flag(flag) => (Value::Flag(flag), flag.to_string()),
            Self::Text(text) => (Value::Text(text.to_string()), format!("\"{text}\"")),
        }
    }

    /// Stands in a table, or in every table of a list, that does not say.
    fn stand_in(self, node: &mut Node, (place, key): (Place, &str)) {
        match &mut node.value {
            Value::Table(entries) if entries.iter().all(|entry| entry.key != key) => {
                let (value, typed) = self.value();
                entries.push(Entry { key: key.to_string(), place, node: Node { value, place, typed } });
            }
            Value::List(tables) => tables.iter_mut().for_each(|table| self.stand_in(table, (place, key))),
            _ => {}
        }
    }
}

/// Brings a job that an earlier version has written out, with all its keys, to the names and keys of today.
pub fn translate(root: &mut Node, kind: Kind) {
    for (_, table, key, earlier) in LATER.iter().filter(|later| later.0 == kind) {
        if let Some(Entry { place, node, .. }) = root.get_mut(table) {
            let place = *place;
            earlier.stand_in(node, (place, key));
        }
    }
    for renamed in RENAMED.iter().filter(|renamed| renamed.kind == kind) {
        let Some(entry) = root.get_mut(renamed.table).and_then(|table| table.node.get_mut(renamed.old)) else {
            continue;
        };
        entry.key = renamed.new.to_string();
        if renamed.turned.is_some() {
            turn(&mut entry.node);
        }
    }
}

/// The opposite of numbers and quantities; words stay.
fn turn(node: &mut Node) {
    let turned = |typed: &str| match typed.strip_prefix('-') {
        Some(positive) => positive.to_string(),
        None => format!("-{typed}"),
    };
    match &mut node.value {
        Value::Float(value) => *value = 0.0 - *value,
        Value::Integer(value) => *value = value.saturating_neg(),
        Value::Text(text) if text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '.') => {
            *text = turned(text.trim());
            node.typed = format!("\"{text}\"");
            return;
        }
        Value::List(items) => {
            items.iter_mut().for_each(turn);
            let typed: Vec<&str> = items.iter().map(|item| item.typed.as_str()).collect();
            node.typed = format!("[{}]", typed.join(", "));
            return;
        }
        _ => return,
    }
    node.typed = turned(&node.typed);
}
