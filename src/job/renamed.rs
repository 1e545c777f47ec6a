//! Keys that were called otherwise, keys that stood in another table, and keys that have come later. A person is told of a new name, and a
//! job that a run keeps is read under it; what stood in another table is read from there in any job. Both do what they did before.

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

/// The table of planar shear that held material and scheme, when there was one law, and where each of its keys stands now.
const OLD_TABLE: &str = "continuum";
const MOVED: [(&str, [&str; 2]); 12] = [
    ("bulk_modulus", ["material", "bulk_modulus"]),
    ("shear_modulus", ["material", "shear_modulus"]),
    ("friction_angle_critical", ["material", "friction_angle_critical"]),
    ("fraction_critical", ["material", "fraction_critical"]),
    ("dilation_factor", ["material", "dilation_factor"]),
    ("softening_rate", ["material", "softening_rate"]),
    ("cohesion", ["material", "cohesion"]),
    ("fraction_start", ["material", "fraction"]),
    ("material", ["material", "file"]),
    ("points_per_cell", ["scheme", "points_per_cell"]),
    ("flip", ["scheme", "flip"]),
    ("volume_averaging", ["scheme", "volume_averaging"]),
];
/// How many of these make the law, which was this one.
const OF_LAW: usize = 7;
const OLD_LAW: &str = "critical_drucker_prager";
/// The share of FLIP by default, there and then.
const OLD_FLIP: f64 = 0.95;

/// Where a key that stood in another table stands now.
pub fn moved(kind: Kind, parts: &[&str]) -> Option<[&'static str; 2]> {
    let [OLD_TABLE, key] = parts else { return None };
    MOVED.iter().find(|(old, _)| kind == Kind::Shear && old == key).map(|(_, place)| *place)
}

/// The names of keys that stood in a table.
pub fn moved_from(kind: Kind, table: &str) -> impl Iterator<Item = &'static str> {
    let is_old = kind == Kind::Shear && table == OLD_TABLE;
    MOVED.iter().filter(move |_| is_old).map(|(old, _)| *old)
}

/// Puts keys that stood in another table where they stand now, with what they stood for; one that stands there already stays.
pub fn lower(root: &mut Node, kind: Kind) {
    let Some(Entry { place, node: Node { value: Value::Table(old), .. }, .. }) = root.get_mut(OLD_TABLE) else {
        return;
    };
    let place = *place;
    let is_moved = |entry: &mut Entry| moved(kind, &[OLD_TABLE, &entry.key]).is_some();
    let entries: Vec<Entry> = old.extract_if(.., is_moved).collect();
    let has = |name: &str| entries.iter().any(|entry| entry.key == name);
    let has_law = MOVED[..OF_LAW].iter().any(|(name, _)| has(name));
    let (has_file, has_flip) = (has("material"), has("flip"));
    let is_job = root.get("method").is_some();
    let typed = |value: Value, typed: String| Node { value, place, typed };
    let mut more = Vec::new();
    if has_law && !has_file {
        more.push((["material", "law"], typed(Value::Text(OLD_LAW.into()), format!("\"{OLD_LAW}\""))));
    }
    // In a file of a material nothing is said of a scheme.
    if (has_law || has_file) && !has_flip && is_job {
        more.push((["scheme", "flip"], typed(Value::Float(OLD_FLIP), OLD_FLIP.to_string())));
    }
    for ([table, key], node) in more {
        let _ = root.put(table, Entry { key: key.into(), place, node });
    }
    for entry in entries {
        let [table, key] = moved(kind, &[OLD_TABLE, &entry.key]).expect("it has been found by that");
        let old = entry.key.clone();
        if let Some(entry) = root.put(table, Entry { key: key.into(), ..entry }) {
            let _ = root.put(OLD_TABLE, Entry { key: old, ..entry });
        }
    }
    // Of a file of a material nothing is left of it.
    if let (Value::Table(tables), false) = (&mut root.value, is_job) {
        tables.retain(|table| table.key != OLD_TABLE || !table.node.entries().is_empty());
    }
}

/// Keys whose default is not what programs did that had no such key, and that.
const LATER: [(Kind, &str, &str, Earlier); 6] = [
    (Kind::Mpm, "scheme", "volume_averaging", Earlier::Flag(false)),
    (Kind::Shear, "scheme", "volume_averaging", Earlier::Flag(false)),
    (Kind::Mpm, "body", "contact_at", Earlier::Text("nodes")),
    (Kind::Mpm, "load", "acts_at", Earlier::Text("points")),
    (Kind::Mpm, "follow", "frames", Earlier::Flag(false)),
    (Kind::Shear, "continuum", "contact_at", Earlier::Text("nodes")),
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
