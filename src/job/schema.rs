//! Every table of a job of each kind: what its types declare.

use std::sync::LazyLock;

use super::{Assembly, Mpm, Scenario};
use crate::base::keys::{Description, Form, Key, Table, Wants};

/// A table of a job.
pub(super) fn section(name: &'static str, about: &'static str, visit: impl FnOnce(&mut dyn Form)) -> Table {
    Description::of(name, about, false, visit)
}

/// Tables of which there may be any number.
pub(super) fn list<T: Clone>(
    form: &mut dyn Form,
    items: &mut Vec<T>,
    key: Key,
    about: &'static str,
    blank: &T,
    mut keys: impl FnMut(&mut T, &mut dyn Form),
) {
    form.tables(items.len(), key, about, &mut |number, form| {
        if number == items.len() {
            items.push(blank.clone());
        }
        keys(&mut items[number], form);
    });
}

/// The kinds of jobs: a table `[cell]` makes an assembly, a table `[grid]` or `[mesh]` a continuum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Planar shear of a specimen between plates: grains, continuum, or both.
    Shear,
    /// Grains in a cell.
    Assembly,
    /// A continuum of material points on a grid, or of elements.
    Mpm,
}

impl Kind {
    /// As they are declared.
    pub const ALL: [Self; 3] = [Self::Shear, Self::Assembly, Self::Mpm];

    /// The job's top level, then its tables in the order they are written in.
    pub fn tables(self) -> &'static [Table] {
        static TABLES: LazyLock<[Vec<Table>; 3]> =
            LazyLock::new(|| [Scenario::tables(), Assembly::tables(), Mpm::tables()]);
        &TABLES[self as usize]
    }

    /// Tables that make a job one of this kind; without any it is of planar shear.
    pub fn marks(self) -> &'static [&'static str] {
        match self {
            Self::Shear => &[],
            Self::Assembly => &["cell"],
            Self::Mpm => &["grid", "mesh"],
        }
    }

    /// The same in words, none where there are none.
    fn mark(self) -> Option<String> {
        let marks: Vec<String> = self.marks().iter().map(|mark| format!("[{mark}]")).collect();
        (!marks.is_empty()).then(|| marks.join(" or "))
    }

    /// What jobs of this kind are called, with an article for one.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Shear => ("jobs of planar shear", "a job of planar shear"),
            Self::Assembly => ("assemblies of grains", "an assembly of grains"),
            Self::Mpm => ("continua", "a continuum"),
        }
    }

    /// Of something that this kind of job does not have, and the first other kind for which `has` holds does.
    pub fn belongs_elsewhere(self, has: impl Fn(Self) -> bool) -> Option<String> {
        let owner = [Self::Assembly, Self::Mpm, Self::Shear].into_iter().find(|kind| *kind != self && has(*kind))?;
        let owners = match owner.mark() {
            Some(table) if self == Self::Shear => format!("{}, jobs with a table {table}", owner.words().0),
            _ => owner.words().0.to_string(),
        };
        Some(match self.mark() {
            Some(mark) => format!(
                "It belongs to {owners}, and this job is {} because it has a table {mark}. Remove one of the two.",
                self.words().1
            ),
            None => format!("It belongs to {owners}, and this job has none."),
        })
    }

    /// The table of that name; asking for one that does not exist is a slip in this program.
    pub fn table(self, name: &str) -> &'static Table {
        self.table_if_known(name).unwrap_or_else(|| panic!("the schema has no table {name}"))
    }

    /// None where this kind has no table of that name.
    pub fn table_if_known(self, name: &str) -> Option<&'static Table> {
        self.tables().iter().find(|table| table.name == name)
    }

    /// Keys above the first table.
    pub fn top(self) -> &'static Table {
        self.table("")
    }

    /// Every table, those within others included.
    pub fn tables_of_all_depths(self) -> Vec<&'static Table> {
        let mut found: Vec<&'static Table> = self.tables().iter().collect();
        let mut at = 0;
        while at < found.len() {
            found.extend(found[at].keys.iter().filter_map(Key::inner));
            at += 1;
        }
        found
    }

    /// Whether the parts of `body.0.servo.force` lead to a key.
    pub fn leads_to_a_key(self, parts: &[&str]) -> bool {
        match parts {
            [key] => self.top().key(key).is_some(),
            [name, inside @ ..] => match self.table_if_known(name) {
                Some(table) if !name.is_empty() => leads_to_a_key(table, inside),
                _ => leads_to_a_key(self.top(), parts),
            },
            [] => false,
        }
    }

    /// Every path that `--set` takes, with 0 for the place in a list.
    pub fn paths(self) -> Vec<String> {
        let mut paths = Vec::new();
        for table in self.tables() {
            paths_below(table, &table.name, &mut paths);
        }
        paths
    }
}

fn leads_to_a_key(table: &Table, parts: &[&str]) -> bool {
    let [first, inside @ ..] = parts else {
        return false;
    };
    match (table.key(first).map(|key| &key.wants), inside) {
        (Some(_), []) => true,
        (Some(Wants::Table(inner)), inside) => leads_to_a_key(inner, inside),
        (Some(Wants::Tables(inner)), [index, inside @ ..]) => {
            index.parse::<usize>().is_ok() && leads_to_a_key(inner, inside)
        }
        _ => false,
    }
}

fn paths_below(table: &Table, prefix: &str, paths: &mut Vec<String>) {
    for key in &table.keys {
        let path = match prefix {
            "" => key.name.to_string(),
            prefix => format!("{prefix}.{}", key.name),
        };
        match &key.wants {
            Wants::Table(inner) => paths_below(inner, &path, paths),
            Wants::Tables(inner) => paths_below(inner, &format!("{path}.0"), paths),
            _ => {}
        }
        paths.push(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A list's tables are named by their place, a table within a table by its key.
    #[test]
    fn paths_of_overrides() {
        for path in ["contact.friction", "body", "body.0.servo.force", "body.3.path.1.velocity", "name"] {
            let parts: Vec<&str> = path.split('.').collect();
            assert!(Kind::Assembly.leads_to_a_key(&parts), "{path}");
        }
        for path in
            ["contact", "body.servo.force", "body.0.servo.0.force", "specimen.width", "body.0", "", "cell.lower.0"]
        {
            let parts: Vec<&str> = path.split('.').collect();
            assert!(!Kind::Assembly.leads_to_a_key(&parts), "{path}");
        }
        assert!(Kind::Shear.paths().contains(&"continuum.weak.0.lower".to_string()));
    }

    #[test]
    fn every_key_says_what_it_is() {
        for kind in Kind::ALL {
            for table in kind.tables_of_all_depths() {
                for key in &table.keys {
                    assert!(!key.about.is_empty() && !key.example.is_empty(), "{}", table.path(key.name));
                }
            }
        }
    }

    /// What a job may hold stands where people look for it. Whole pages: keys of other kinds do not count.
    #[test]
    fn every_key_stands_in_the_handbook() {
        let pages = [
            concat!(include_str!("../../docs/jobs.md"), include_str!("../../docs/planar_shear.md")),
            include_str!("../../docs/grains.md"),
            concat!(
                include_str!("../../docs/continuum.md"),
                include_str!("../../docs/hybrid.md"),
                include_str!("../../docs/rve.md"),
                include_str!("../../docs/elements.md")
            ),
        ];
        for (kind, page) in Kind::ALL.into_iter().zip(pages) {
            // Tables that are the same for several kinds stand with one that has them.
            let text = match kind {
                Kind::Shear => pages.concat(),
                _ => [pages[0], pages[1], page].concat(),
            };
            for table in kind.tables_of_all_depths() {
                for key in &table.keys {
                    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                    assert!(words.into_iter().any(|word| word == key.name), "{}", table.path(key.name));
                }
            }
        }
    }
}
