//! Memories of contacts from a file beside that of the grains, in the columns that an export writes: a contact a line, the
//! two grains (the lower id first) or a grain and a body by its name, then the words of the law's memory.

use std::collections::BTreeMap;

use super::csv::{columns_of, words_of};
use super::{Source, id, number};
use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Grains, body_partner};
use crate::dem::law::memory_words;
use crate::dem::neighbours::{Neighbours, Pair};
use crate::dem::walls;
use crate::job::{Assembly, figures};
use crate::law::contact::Memory;
use crate::prepare::grain_file::csv::header_of_contacts;
use crate::prepare::grain_world;

/// How far apart two grains may be and still be in touch, as a share of the mean diameter: what rounding leaves.
const TOUCH_TOLERANCE: f64 = 1e-9;

/// Gives each grain what its contacts remember; `grains` stand in the order of their ids, as they do when a run starts.
pub fn read<S: Space>(
    job: &Assembly,
    source: &Source,
    grains: &mut [GrainRow<S>],
    cell: &Cell<S>,
) -> Result<(), Error> {
    let text = source.text("of contacts", "one of comma-separated values, as scree export --contacts writes it,")?;
    let law = job.contact.law();
    let memory_words = memory_words::<S>(&job.contact);
    let header = header_of_contacts(law, memory_words);
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let found = words_of(lines.next().map_or("", |(_, line)| line));
    let Some(columns) = columns_of(&found, &header) else {
        let message = format!(
            "the first line must name the columns {header}, in any order, which are those of law = \"{law}\"; it is `{}`. Export contacts of a run with this law, or remove grains.contacts.",
            found.join(",")
        );
        return Err(source.bad(1, &message));
    };
    let near = Near::of(job, grains, cell);
    let mut lines_of_pairs = BTreeMap::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let bad = |what: &str| source.bad(index + 1, what);
        let typed = words_of(line);
        if typed.len() != found.len() {
            let what = format!("{} values, {} are wanted ({})", typed.len(), found.len(), found.join(","));
            return Err(bad(&what));
        }
        let words: Vec<&str> = columns.iter().map(|column| typed[*column]).collect();
        let pair = near.pair(&words).map_err(|what| bad(&what))?;
        if let Some(first) = lines_of_pairs.insert(pair, index + 1) {
            return Err(bad(&format!("this contact stands in line {first} already; remove one of the two")));
        }
        let mut memory = Memory::blank(memory_words);
        for (at, (to, word)) in memory.words_mut().iter_mut().zip(&words[2..]).enumerate() {
            let named =
                |what: String| bad(&format!("{what}, in column {}", header.split(',').nth(2 + at).unwrap_or("")));
            *to = number(word).map_err(named)?;
        }
        let [lower, higher] = pair;
        // Both grains carry what they remember, each by the name of the other.
        for (one, other) in [(lower, higher), (higher, lower)] {
            if let Ok(row) = grains.binary_search_by_key(&one, |grain| grain.cold.id) {
                grains[row].contacts.push((other, memory));
            }
        }
    }
    for grain in grains {
        grain.contacts.sort_unstable_by_key(|(partner, _)| *partner);
    }
    Ok(())
}

/// Which grains and bodies may touch.
struct Near<'a, S: Space> {
    job: &'a Assembly,
    cell: &'a Cell<S>,
    grains: Grains<S>,
    /// Gaps between neighbours, m, with what may have opened since the contact was last seen.
    gaps: BTreeMap<[GrainId; 2], [f64; 2]>,
}

impl<'a, S: Space> Near<'a, S> {
    fn of(job: &'a Assembly, rows: &[GrainRow<S>], cell: &'a Cell<S>) -> Self {
        let grains = Grains::<S> {
            hot: rows.iter().map(|grain| grain.hot).collect(),
            cold: rows.iter().map(|grain| grain.cold).collect(),
            owned: rows.len(),
            ..Grains::default()
        };
        let mut neighbours = Neighbours::default();
        neighbours.build(&grains, cell, figures::margin(job));
        let held = job.cell.servo.as_ref().map_or(0.0, |servo| servo.rate_max);
        let rate = S::DIMENSION as f64 * figures::rate_max(job) + held;
        let gap = |pair: &Pair| {
            let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
            let shift = cell.shift(pair.image().image());
            let gap = (a.position - b.position + shift).norm() - a.radius - b.radius;
            (gap, (a.velocity - b.velocity).norm() + rate * shift.norm())
        };
        let of_pair = |pair: &Pair| {
            let (gap, speed) = gap(pair);
            ([pair.a, pair.b()].map(|row| grains.cold[row as usize].id), [gap, speed * job.step])
        };
        let gaps = neighbours.real_pairs().map(|(_, pair)| of_pair(pair)).collect();
        Self { job, cell, grains, gaps }
    }

    /// The two that a line names, if they touch.
    fn pair(&self, words: &[&str]) -> Result<[GrainId; 2], String> {
        let (lower, row) = self.grain(words[0])?;
        let bodies = &self.job.bodies;
        let (higher, what, [gap, opened]) = if words[1].starts_with(|first: char| first.is_ascii_digit()) {
            let (higher, _) = self.grain(words[1])?;
            if higher <= lower {
                return Err(format!("grain {} stands before grain {}; the lower id comes first", words[0], words[1]));
            }
            let gap = self.gaps.get(&[lower, higher]).copied().unwrap_or([f64::INFINITY, 0.0]);
            (higher, format!("grain {}", words[1]), gap)
        } else {
            let Some(body) = bodies.iter().position(|body| body.name == words[1]) else {
                let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
                let names = if names.is_empty() { "none".to_string() } else { names.join(", ") };
                return Err(format!("`{}` is neither the id of a grain nor a body of the job ({names})", words[1]));
            };
            (body_partner(body as u8), format!("body `{}`", words[1]), self.gap_to_body(row, body))
        };
        let tolerance = TOUCH_TOLERANCE * self.job.matter.diameter_mean;
        if gap - opened > self.job.contact.reach() + tolerance {
            let apart = if gap.is_finite() { format!(" by {gap:.3e} m") } else { String::new() };
            return Err(format!(
                "grain {} and {what} do not touch: they are apart{apart}; export grains and contacts of one time, or remove the line",
                words[0]
            ));
        }
        Ok([lower, higher])
    }

    fn grain(&self, word: &str) -> Result<(GrainId, usize), String> {
        let id = GrainId(id(word)?);
        let row = self.grains.cold.binary_search_by_key(&id, |cold| cold.id);
        row.map(|row| (id, row)).map_err(|_| format!("there is no grain {word} in grains.file"))
    }

    /// Gap between a grain and a body, and what may have opened since, m.
    fn gap_to_body(&self, row: usize, body: usize) -> [f64; 2] {
        let (hot, body) = (&self.grains.hot[row], grain_world::body_of::<S>(&self.job.bodies[body]));
        let fastest = body.path.iter().map(|at| at.velocity.norm()).fold(0.0, f64::max);
        let servo = body.servo.as_ref().map_or(0.0, |servo| servo.speed_max);
        let gap = walls::nearest(&body, self.cell, &hot.position).map(|nearest| nearest.distance - hot.radius);
        [gap.unwrap_or(f64::INFINITY), (hot.velocity.norm() + fastest + servo) * self.job.step]
    }
}
