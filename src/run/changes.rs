//! What may change of a job when a run of it goes on, and what would make it another run.

use toml::{Table, Value};

/// Keys that say when to end and what to write; no step of the run depends on them.
const FREE: [&str; 2] = ["time.end", "loading.strain_end"];
const FREE_TABLE: &str = "output.";
/// Of that table, what is kept from the start of a run on or not at all.
const BOUND: [&str; 2] = ["output.contact_frames", "output.energy_balance"];
/// Keys that the packing in a run's folder was made by, and how it lies: it goes along with every branch.
const KEPT: [&str; 2] = ["packing.height", "enrichment.reference"];
/// And the mesh and inertia that elements have from the start.
const KEPT_OF_MESH: [&str; 4] = ["mesh.file", "mesh.sha256", "mesh.unit", "mesh.mass_scaling"];
/// And of loads, which points know from the start.
const KEPT_OF_LOADS: [&str; 4] = [".face", ".lower", ".upper", ".acts_at"];

/// A key that two jobs do not share.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// `table.key`; entries of lists of tables have their number in brackets.
    pub key: String,
    /// As they would be typed; nothing where one has no such key.
    pub old: Option<String>,
    /// The same of the job that is gone on with.
    pub new: Option<String>,
}

impl Change {
    /// Whether a run may go on with it.
    pub fn is_free(&self) -> bool {
        let listed = |list: &[&str]| list.contains(&self.key.as_str());
        listed(&FREE) || self.key.starts_with(FREE_TABLE) && !listed(&BOUND)
    }

    /// Whether not even a branch may have it.
    pub fn is_kept(&self) -> bool {
        KEPT.contains(&self.key.as_str()) || self.is_of_kept_mesh() || self.is_of_kept_load()
    }

    fn is_of_kept_mesh(&self) -> bool {
        KEPT_OF_MESH.contains(&self.key.as_str())
    }

    fn is_of_kept_load(&self) -> bool {
        self.key.starts_with("load[") && KEPT_OF_LOADS.iter().any(|end| self.key.ends_with(end))
    }

    /// Why it is kept.
    pub fn why_kept(&self) -> &'static str {
        match (self.is_of_kept_load(), self.is_of_kept_mesh()) {
            (true, _) => "points know from the start of a run which loads they bear, and where",
            (_, true) => "elements have their volumes and their inertia from the start of a run",
            _ => "the grains of a zone are those of the packing that the run began with",
        }
    }

    /// Whether it asks for the paths of points, which a state with grains in it has kept only if its zone has been to grow.
    pub fn asks_for_paths(&self) -> bool {
        self.key == "zone.grows" && self.new.as_deref() == Some("true")
    }

    /// For a person: `contact.friction from 0.5 to 0.4`.
    pub fn words(&self) -> String {
        let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "nothing".into());
        format!("{} from {} to {}", self.key, shown(&self.old), shown(&self.new))
    }
}

/// What a run may go on with, for a person.
pub fn free_in_words() -> String {
    format!("{} and the keys of [output]", FREE.join(", "))
}

/// All changes from one resolved job to another, in the order of their keys.
pub fn between(old: &str, new: &str) -> Vec<Change> {
    let flat = |text: &str| {
        let mut found = Vec::new();
        flatten("", &Value::Table(text.parse::<Table>().unwrap_or_default()), &mut found);
        found
    };
    let (old, new) = (flat(old), flat(new));
    let value =
        |of: &[(String, String)], key: &str| of.iter().find(|(name, _)| name == key).map(|(_, value)| value.clone());
    let mut keys: Vec<&String> = old.iter().chain(&new).map(|(key, _)| key).collect();
    keys.sort();
    keys.dedup();
    let changes = keys.into_iter().map(|key| Change { key: key.clone(), old: value(&old, key), new: value(&new, key) });
    changes.filter(|change| change.old != change.new).collect()
}

fn flatten(path: &str, value: &Value, into: &mut Vec<(String, String)>) {
    let below = |name: &str| if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
    match value {
        Value::Table(table) => table.iter().for_each(|(name, value)| flatten(&below(name), value, into)),
        Value::Array(list) if list.iter().any(Value::is_table) => {
            list.iter().enumerate().for_each(|(at, value)| flatten(&format!("{path}[{at}]"), value, into));
        }
        value => into.push((path.to_string(), value.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_named_and_told_apart() {
        let old = "name = \"a\"\n[time]\nend = 1.0\n[contact]\nfriction = 0.5\n[[body]]\nname = \"lid\"\nvelocity = [0.0, 1.0]\n[output]\nenergy_balance = false\n";
        let new = "name = \"a\"\n[time]\nend = 2.0\n[contact]\nfriction = 0.4\n[[body]]\nname = \"lid\"\nvelocity = [0.0, 2.0]\n[output]\nenergy_balance = true\nframe_interval = 1.0\n";
        let changes = between(old, new);
        let words: Vec<String> = changes.iter().map(Change::words).collect();
        assert_eq!(
            words,
            [
                "body[0].velocity from [0.0, 1.0] to [0.0, 2.0]",
                "contact.friction from 0.5 to 0.4",
                "output.energy_balance from false to true",
                "output.frame_interval from nothing to 1.0",
                "time.end from 1.0 to 2.0"
            ]
        );
        let free: Vec<bool> = changes.iter().map(Change::is_free).collect();
        assert_eq!(free, [false, false, false, true, true]);
        assert!(between(old, old).is_empty());
        let kept = between("[packing]\nheight = 0.1\n", "[packing]\nheight = 0.2\nstress = 1.0\n");
        assert_eq!(kept.iter().map(Change::is_kept).collect::<Vec<bool>>(), [true, false]);
        let loads = between("[[load]]\nacts_at = \"points\"\n", "[[load]]\nacts_at = \"surface\"\n");
        assert!(loads[0].is_kept(), "{loads:?}");
        let lives = between("[zone]\ngrows = false\n", "[zone]\ngrows = true\ndissolves = true\n");
        assert_eq!(lives.iter().map(Change::asks_for_paths).collect::<Vec<bool>>(), [false, true]);
    }
}
