//! Runs of planar shear compared as Chen et al. (2021) compare theirs, figures 10 to 15: hybrid and continuum against grains
//! alone, packing by packing; and runs in which a body presses on the material ([`pressed`]) as figures 17 to 24 compare theirs.
//!
//! One file a figure: each draws, measures, and says in one line why something is left out.

use serde_json::{Value, json};

use super::findings::Findings;
use super::load::Run;
use super::records::Record;
use super::words::{Table, signed_percent as share};
use crate::base::error::Error;

mod among;
mod bands;
mod curves;
mod difference;
mod disturbance;
mod inside;
mod pictures;
mod pressed;
mod profile;
mod softening;
mod speed;
#[cfg(test)]
mod tests;
mod trained;
mod zone;

use among::{Among, Group};
use curves::Averages;

/// A drawing with its caption; the name is that of its file.
pub struct Drawn {
    pub name: &'static str,
    pub drawing: String,
    pub caption: String,
}

/// A table with named columns.
pub struct Sheet {
    pub title: &'static str,
    pub columns: Vec<&'static str>,
    pub table: Table,
}

impl Sheet {
    fn new(title: &'static str, columns: &[&'static str]) -> Self {
        Self { title, columns: columns.to_vec(), table: Table::default() }
    }

    /// A row, unless all of its cells are empty.
    fn row(&mut self, name: &str, cells: Vec<Option<String>>) {
        assert_eq!(cells.len(), self.columns.len(), "a cell for every column of `{}`", self.title);
        self.table.row(name, cells);
    }
}

/// What one figure of the paper becomes.
#[derive(Default)]
pub struct Part {
    /// Findings, in numbers.
    pub sentences: Vec<String>,
    pub figures: Vec<Drawn>,
    pub sheets: Vec<Sheet>,
    /// Why something is not there, a line each.
    pub left_out: Vec<String>,
    pub json: Value,
}

impl Part {
    /// A part that cannot be made, and why.
    fn without(why: String) -> Self {
        Self { left_out: vec![why], ..Self::default() }
    }
}

/// Values of runs (by group), told group by group: one value, or the least and the most of several packings.
fn by_group(groups: &[Group], values: &[(usize, f64)], tell: impl Fn(f64) -> String) -> String {
    let told = |(index, group): (usize, &Group)| {
        let own: Vec<f64> = values.iter().filter(|(of, _)| *of == index).map(|(_, value)| *value).collect();
        let [least, most] = range(own.iter().copied())?;
        Some(match own.len() {
            1 => format!("{} {}", group.name, tell(least)),
            count => format!("{} {} to {} ({count} packings)", group.name, tell(least), tell(most)),
        })
    };
    groups.iter().enumerate().filter_map(told).collect::<Vec<_>>().join("; ")
}

/// Least and most; none of nothing.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.map(|value| [value, value]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

/// The whole comparison.
pub struct Comparison {
    pub parts: Vec<Part>,
    /// All figures.
    pub json: Value,
}

impl Comparison {
    /// Of two or more runs, with what was found in them and their first frames with grains of an enrichment; `between` are
    /// the horizontal strains that incremental strain is taken between.
    pub fn of(runs: &[(&Run, &Findings, Option<usize>)], between: Option<[f64; 2]>) -> Result<Option<Self>, Error> {
        if runs.len() < 2 {
            return Ok(None);
        }
        let among = Among::of(runs);
        let averages = Averages::of(&among);
        let named = [
            ("shear_stress", curves::part(&among, &averages)),
            ("softening", softening::part(&among, &averages)),
            ("bands", bands::part(&among, between)?),
            ("training", trained::part(&among)?),
            ("disturbance", disturbance::part(&among)),
            ("inside_the_zone", inside::part(&among, &averages)?),
            ("speed_up", speed::part(&among)?),
        ];
        Ok(Some(Self::made_of(described(&among), named)))
    }

    /// The same of jobs on a grid with grains, in which a body presses on the material; none of runs of other jobs. Runs that
    /// are not of one specimen and test are an error.
    pub fn of_pressed(records: &[&Record], between: Option<[f64; 2]>) -> Result<Option<Self>, Error> {
        pressed::comparison(records, between)
    }

    fn made_of(runs: Vec<Value>, named: impl IntoIterator<Item = (&'static str, Part)>) -> Self {
        let mut json = json!({ "runs": runs, "left_out": {} });
        let mut parts = Vec::new();
        for (name, mut part) in named {
            json[name] = part.json.take();
            json["left_out"][name] = json!(part.left_out);
            parts.push(part);
        }
        Self { parts, json }
    }

    /// The main findings as a paragraph.
    pub fn paragraph(&self) -> String {
        self.parts.iter().flat_map(|part| part.sentences.iter().map(String::as_str)).collect::<Vec<_>>().join(" ")
    }
}

fn described(among: &Among) -> Vec<Value> {
    let describe = |member: &among::Member| {
        json!({
            "label": member.label, "directory": member.run.directory, "method": member.run.method, "seed": member.seed,
            "group": among.groups[member.group].name, "strain_end": member.strain_end(),
        })
    };
    among.members.iter().map(describe).collect()
}
