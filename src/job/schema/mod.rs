//! Every table and key of a job: what it means, what it may be, and an example to copy into an error message.

use super::units::Dimension;

mod assembly;
mod contact;
mod mpm;
pub use contact::OF_LAW;
mod shear;

/// The kinds of jobs: a table `[cell]` makes an assembly, a table `[grid]` a continuum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Planar shear of a specimen between plates: grains, continuum, or both.
    Shear,
    /// Grains in a cell.
    Assembly,
    /// A continuum of material points on a grid.
    Mpm,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Shear, Self::Assembly, Self::Mpm];

    /// The job's top level, then its tables in the order they are written in.
    pub fn tables(self) -> &'static [Table] {
        match self {
            Self::Shear => &shear::TABLES,
            Self::Assembly => &assembly::TABLES,
            Self::Mpm => &mpm::TABLES,
        }
    }

    /// The table that makes a job one of this kind; without any it is of planar shear.
    pub fn mark(self) -> Option<&'static str> {
        match self {
            Self::Shear => None,
            Self::Assembly => Some("cell"),
            Self::Mpm => Some("grid"),
        }
    }

    /// What jobs of this kind are called, with an article for one.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Shear => ("jobs of planar shear", "a job of planar shear"),
            Self::Assembly => ("assemblies of grains", "an assembly of grains"),
            Self::Mpm => ("continua on a grid", "a continuum on a grid"),
        }
    }

    /// Of something that this kind of job does not have, and the first other kind for which `has` holds does.
    pub fn belongs_elsewhere(self, has: impl Fn(Self) -> bool) -> Option<String> {
        let owner = Self::ALL.into_iter().find(|kind| *kind != self && has(*kind))?;
        let owners = match owner.mark() {
            Some(table) if self == Self::Shear => format!("{}, jobs with a table [{table}]", owner.words().0),
            _ => owner.words().0.to_string(),
        };
        Some(match self.mark() {
            Some(mark) => format!(
                "It belongs to {owners}, and this job is {} because it has a table [{mark}]. Remove one of the two.",
                self.words().1
            ),
            None => format!("It belongs to {owners}, and this job has none."),
        })
    }

    /// The table of that name; asking for one that does not exist is a slip in this program.
    pub fn table(self, name: &str) -> &'static Table {
        self.table_if_known(name).unwrap_or_else(|| panic!("the schema has no table {name}"))
    }

    pub fn table_if_known(self, name: &str) -> Option<&'static Table> {
        self.tables().iter().find(|table| table.name == name)
    }

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
                Some(table) if !name.is_empty() => table.leads_to_a_key(inside),
                _ => self.top().leads_to_a_key(parts),
            },
            [] => false,
        }
    }

    /// Every path that `--set` takes, with 0 for the place in a list.
    pub fn paths(self) -> Vec<String> {
        let mut paths = Vec::new();
        for table in self.tables() {
            table.paths_below(table.name, &mut paths);
        }
        paths
    }
}

/// A `[table]` of the job, or the job's top level when `name` is empty.
pub struct Table {
    pub name: &'static str,
    pub about: &'static str,
    /// Written as `[[name]]`, any number of times.
    pub many: bool,
    pub keys: &'static [Key],
}

pub struct Key {
    pub name: &'static str,
    pub about: &'static str,
    /// As it would be typed right of the equals sign; of a vector, one component.
    pub example: &'static str,
    pub wants: Wants,
}

#[derive(Clone, Copy)]
pub enum Wants {
    Text,
    /// `true` or `false`.
    Flag,
    /// The same, one for each axis.
    Flags,
    /// A whole number between two bounds, both allowed.
    Count(u64, u64),
    Number(Dimension, Range),
    /// A number for each axis.
    Vector(Dimension),
    /// A number in the plane, a vector in space.
    Spin,
    /// A row of rates for each axis.
    Gradient,
    /// A stress or "free" for each axis.
    Stresses,
    /// Pairs of a length and a share.
    Shares,
    /// Three or more points of the plane.
    Polygon,
    /// One table with keys of its own.
    Table(&'static Table),
    /// Any number of them.
    Tables(&'static Table),
}

/// Bounds of a number; an open bound is not itself allowed.
#[derive(Clone, Copy)]
pub struct Range {
    min: f64,
    max: f64,
    min_open: bool,
    max_open: bool,
}

impl Range {
    const POSITIVE: Self = Self::new(0.0, f64::INFINITY, true, true);
    const NOT_NEGATIVE: Self = Self::new(0.0, f64::INFINITY, false, true);

    const fn new(min: f64, max: f64, min_open: bool, max_open: bool) -> Self {
        Self { min, max, min_open, max_open }
    }

    const fn closed(min: f64, max: f64) -> Self {
        Self::new(min, max, false, false)
    }

    const fn open(min: f64, max: f64) -> Self {
        Self::new(min, max, true, true)
    }

    /// The lower bound is allowed, the upper one is not.
    const fn below(min: f64, max: f64) -> Self {
        Self::new(min, max, false, true)
    }

    pub fn contains(&self, value: f64) -> bool {
        let above = if self.min_open { value > self.min } else { value >= self.min };
        let below = if self.max_open { value < self.max } else { value <= self.max };
        above && below
    }

    /// For a sentence: `must be ...`.
    pub fn words(&self, unit: &str) -> String {
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        if self.max == f64::INFINITY {
            return match self.min_open {
                _ if self.min == f64::NEG_INFINITY => "finite".to_string(),
                true => format!("finite and more than {}{unit}", self.min),
                false => format!("finite and {}{unit} or more", self.min),
            };
        }
        let (min, max) = (round(self.min), round(self.max));
        match (self.min_open, self.max_open) {
            (true, true) => format!("between {min} and {max}{unit}, both excluded"),
            (true, false) => format!("more than {min} and at most {max}{unit}"),
            (false, true) => format!("{min}{unit} or more and less than {max}{unit}"),
            (false, false) => format!("between {min} and {max}{unit}"),
        }
    }
}

/// Bounds such as pi/2 need not be printed to the last digit.
fn round(value: f64) -> String {
    match value.abs() < 1e-3 && value != 0.0 {
        true => format!("{value:e}"),
        false => format!("{}", (value * 1e4).round() / 1e4),
    }
}

const fn table(name: &'static str, about: &'static str, keys: &'static [Key]) -> Table {
    Table { name, about, many: false, keys }
}

const fn key(name: &'static str, about: &'static str, wants: Wants, example: &'static str) -> Key {
    Key { name, about, example, wants }
}

const fn text(name: &'static str, about: &'static str, example: &'static str) -> Key {
    key(name, about, Wants::Text, example)
}

const fn count(name: &'static str, about: &'static str, (min, max): (u64, u64), example: &'static str) -> Key {
    key(name, about, Wants::Count(min, max), example)
}

const fn number(
    name: &'static str,
    about: &'static str,
    dimension: Dimension,
    range: Range,
    example: &'static str,
) -> Key {
    key(name, about, Wants::Number(dimension, range), example)
}

const fn vector(name: &'static str, about: &'static str, dimension: Dimension, example: &'static str) -> Key {
    key(name, about, Wants::Vector(dimension), example)
}

const RATIO: Dimension = Dimension::RATIO;
const LENGTH: Dimension = Dimension::LENGTH;
const TIME: Dimension = Dimension::TIME;
const STRESS: Dimension = Dimension::STRESS;
const STIFFNESS: Dimension = Dimension::STIFFNESS;
const DAMPING: Dimension = Dimension::DAMPING;
const POSITIVE: Range = Range::POSITIVE;
const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;

/// `[output]` of every kind.
#[rustfmt::skip]
const OUTPUT: [Key; 7] = [
    number("series_interval", "time between rows of series.csv", TIME, POSITIVE, "\"3 ms\""),
    number("frame_interval", "time between frames", TIME, POSITIVE, "\"80 ms\""),
    number("checkpoint_interval", "time between checkpoints", TIME, POSITIVE, "\"0.2 s\""),
    count("checkpoint_steps", "steps between checkpoints, beside those at intervals, or 0 for none", (0, 1_000_000_000_000), "100000"),
    number("checkpoint_wall_interval", "time between checkpoints by the clock on the wall, at most", TIME, POSITIVE, "\"10 min\""),
    count("checkpoints_kept", "checkpoints kept", (1, 1_000_000), "3"),
    count("checkpoints_for_good", "checkpoints of which one is kept for good, or 0", (0, 1_000_000), "10"),
];

/// The same of what has contacts.
const OUTPUT_WITH_CONTACTS: [Key; 8] = {
    let [series, frames, checkpoints, steps, wall, kept, good] = OUTPUT;
    let about = "writes contacts as lines into contacts.vtkhdf with every frame";
    [series, frames, checkpoints, steps, wall, kept, good, key("contact_frames", about, Wants::Flag, "true")]
};

impl Key {
    /// The table that this key holds one or many of.
    pub fn inner(&self) -> Option<&'static Table> {
        match self.wants {
            Wants::Table(inner) | Wants::Tables(inner) => Some(inner),
            _ => None,
        }
    }

    /// As it would be typed in a space of that many axes.
    pub fn example(&self, axes: usize) -> String {
        let list = |of: &str, count: usize| format!("[{}]", vec![of; count].join(", "));
        match self.wants {
            Wants::Vector(_) | Wants::Flags | Wants::Stresses => list(self.example, axes),
            Wants::Spin if axes == 3 => list(self.example, 3),
            Wants::Gradient => list(&list(self.example, axes), axes),
            _ => self.example.to_string(),
        }
    }
}

impl Table {
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// `contact.friction`, or `name` at the top level.
    pub fn path(&self, key: &str) -> String {
        match self.name {
            "" => key.to_string(),
            name => format!("{name}.{key}"),
        }
    }

    /// For a sentence: `[contact]` or `the job`.
    pub fn words(&self) -> String {
        match (self.name, self.many) {
            ("", _) => "the job's top level".to_string(),
            (name, true) => format!("[[{name}]]"),
            (name, false) => format!("[{name}]"),
        }
    }

    pub fn key_list(&self) -> String {
        let names: Vec<&str> = self.keys.iter().map(|key| key.name).collect();
        names.join(", ")
    }

    fn leads_to_a_key(&self, parts: &[&str]) -> bool {
        let [first, inside @ ..] = parts else {
            return false;
        };
        match (self.key(first).map(|key| key.wants), inside) {
            (Some(_), []) => true,
            (Some(Wants::Table(inner)), inside) => inner.leads_to_a_key(inside),
            (Some(Wants::Tables(inner)), [index, inside @ ..]) => {
                index.parse::<usize>().is_ok() && inner.leads_to_a_key(inside)
            }
            _ => false,
        }
    }

    fn paths_below(&self, prefix: &str, paths: &mut Vec<String>) {
        for key in self.keys {
            let path = match prefix {
                "" => key.name.to_string(),
                prefix => format!("{prefix}.{}", key.name),
            };
            match key.wants {
                Wants::Table(inner) => inner.paths_below(&path, paths),
                Wants::Tables(inner) => inner.paths_below(&format!("{path}.0"), paths),
                _ => {}
            }
            paths.push(path);
        }
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
                for key in table.keys {
                    assert!(!key.about.is_empty() && !key.example.is_empty(), "{}", table.path(key.name));
                }
            }
        }
    }

    /// What a job may hold stands where people look for it. Whole sections: keys of other kinds do not count.
    #[test]
    fn every_key_stands_in_the_readme() {
        let readme = include_str!("../../../README.md");
        let headings = ["## Write a job", "## Grains in a cell", "## A continuum on a grid"];
        let section = |heading: &str| {
            let (_, rest) = readme.split_once(heading).expect("the heading is there");
            rest.split("\n## ").next().unwrap_or(rest)
        };
        for (kind, heading) in Kind::ALL.into_iter().zip(headings) {
            // Tables that are the same for all kinds stand with the first one that has them.
            let text = match kind {
                Kind::Shear => [section(headings[0]), section(headings[1])].concat(),
                _ => [section(headings[0]), section(headings[1]), section(heading)].concat(),
            };
            for table in kind.tables_of_all_depths() {
                for key in table.keys {
                    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                    assert!(words.into_iter().any(|word| word == key.name), "{}", table.path(key.name));
                }
            }
        }
    }
}
