//! What was measured of one or more runs ([`crate::analysis::measures`]), figure by figure of the paper: sentences, drawings, tables.

use super::chart::Entry;
use super::svg::Stroke;
use super::{Drawn, colour};
use crate::analysis::curve::{mean, range};
use crate::analysis::measures::among::{Group, Who};
use crate::analysis::measures::{Found, Measures};
use crate::analysis::run::Run;
use crate::base::error::Error;

pub mod bands;
mod coupling;
mod ensembles;
pub mod stress;
mod volume;

/// A table with a row for each run, or pair of them, and named columns.
pub struct Sheet {
    pub title: String,
    pub columns: Vec<&'static str>,
    pub rows: Vec<(String, Vec<String>)>,
}

/// What a column says of a row.
type Tell<'t, T> = &'t dyn Fn(&T) -> Option<String>;

impl Sheet {
    /// Columns that say nothing of any row are left away.
    fn of<T>(title: &str, rows: &[T], name: impl Fn(&T) -> String, columns: &[(&'static str, Tell<T>)]) -> Self {
        let told: Vec<_> = columns.iter().filter(|(_, tell)| rows.iter().any(|row| tell(row).is_some())).collect();
        let cells = |row: &T| told.iter().map(|(_, tell)| tell(row).unwrap_or("\u{2013}".to_owned())).collect();
        Self {
            title: title.to_owned(),
            columns: told.iter().map(|(name, _)| *name).collect(),
            rows: rows.iter().map(|row| (name(row), cells(row))).collect(),
        }
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
}

impl Part {
    /// Drawn of what was found, unless nothing was.
    fn of<T>(found: &Found<Vec<T>>, draw: impl FnOnce(&[T]) -> Result<Self, Error>) -> Result<Self, Error> {
        let part = if found.of.is_empty() { Self::default() } else { draw(&found.of)? };
        Ok(Self { left_out: found.left_out.clone(), ..part })
    }
}

/// All parts, as a page shows them.
pub fn all(measures: &Measures) -> Result<Vec<Part>, Error> {
    Ok(vec![
        stress::part(measures),
        Part::of(&measures.levels, |levels| Ok(stress::levels(measures, levels)))?,
        Part::of(&measures.ensembles, |found| Ok(ensembles::part(found)))?,
        bands::part(measures),
        Part::of(&measures.volume, |volumes| Ok(volume::part(measures, volumes)))?,
        Part::of(&measures.trained, |trained| coupling::trained(measures, trained))?,
        Part::of(&measures.disturbance, |found| Ok(coupling::disturbance(measures, found)))?,
        Part::of(&measures.inside, |inside| Ok(coupling::inside(measures, inside)))?,
        Part::of(&measures.speed, |speeds| Ok(coupling::speed(measures, speeds)))?,
    ])
}

/// Values of runs, told group by group: one value, or the mean, the least and the most of several packings.
fn by_group(groups: &[Group], values: &[(&Who, f64)], tell: impl Fn(f64) -> String) -> String {
    let told = |(number, group): (usize, &Group)| {
        let own: Vec<f64> = values.iter().filter(|(who, _)| who.number == number).map(|(_, value)| *value).collect();
        let [least, most] = range(own.iter().copied())?;
        Some(match own.len() {
            1 => format!("{} {}", group.name, tell(least)),
            count => {
                let [mean, least, most] = [mean(&own), least, most].map(&tell);
                format!("{} {mean} ({least} to {most}, {count} packings)", group.name)
            }
        })
    };
    groups.iter().enumerate().filter_map(told).collect::<Vec<_>>().join("; ")
}

/// The colour of a group, which its runs have everywhere.
pub fn colour_of(measures: &Measures, index: usize) -> &'static str {
    colour::line(measures.among.members[index].who.number)
}

/// The line of a group; colours that come again are dashed.
fn stroke_of(number: usize, width: f64) -> Stroke<'static> {
    Stroke::new(colour::line(number), width).dash(["", "7 4", "2 3"][number / colour::LINES.len() % 3])
}

/// The line of one run among those of its group, and what a legend calls it.
fn entry_of(measures: &Measures, index: usize, width: f64) -> Entry<'static> {
    let who = &measures.among.members[index].who;
    let own = &measures.among.groups[who.number].members;
    let number = own.iter().position(|&member| member == index).unwrap_or(0);
    let stroke = stroke_of(who.number, width);
    let dash = if own.len() > 1 { colour::DASHES[number % colour::DASHES.len()] } else { stroke.dash };
    let seed = who.seed.filter(|_| own.len() > 1).map_or_else(String::new, |seed| format!(", seed {seed}"));
    Entry { words: format!("{}{seed}", who.run), stroke: stroke.dash(dash) }
}

fn runs<'m>(measures: &'m Measures<'m>) -> Vec<(&'m Run, &'static str)> {
    measures.among.members.iter().map(|member| (member.run, colour_of(measures, member.index()))).collect()
}
