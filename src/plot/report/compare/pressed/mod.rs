//! Runs in which a body presses on grains or points that stand for them (`[grid]` with `[grains]`: triaxial compression,
//! indentation), compared as Chen et al. (2021) compare theirs, figures 17 to 24.
//!
//! Strain is the way of that body: over the height of the material where the body is a plane, over its own breadth where it is a
//! box or a disc.

use serde_json::{Value, json};

use super::among::{Group, Told, named, number_of, without};
use super::{Comparison, Part};
use crate::base::error::Error;
use crate::plot::report::chart::percent;
use crate::plot::report::load::figure;
use crate::plot::report::records::Record;
use crate::plot::report::words::{THIN, plain};

mod alike;
mod bands;
mod load_curve;
mod press;
mod run;
mod space;
mod strain;
#[cfg(test)]
mod tests;
mod volume;

use press::Press;
use run::Run;

/// What a group may differ in beside its packing.
const ANY: [&str; 6] = ["name", "seed", "output", "decomposition", "packing.cache", "time.end"];

/// All runs of a comparison.
struct Runs<'a> {
    /// Of every one of them.
    press: Press,
    all: Vec<Run<'a>>,
    groups: Vec<Group>,
}

/// Compares two or more runs; none of runs of other jobs. Where nobody has said over which strains, runs that cannot be compared
/// are not, with a line that says why.
pub fn comparison(records: &[&Record], between: Option<[f64; 2]>) -> Result<Option<Comparison>, Error> {
    match compared(records, between) {
        Err(Error::User(why)) if between.is_none() => Ok(Some(nothing(format!("Nothing is compared: {why}")))),
        done => done,
    }
}

fn nothing(why: String) -> Comparison {
    Comparison::made_of(Vec::new(), [("load_curve", Part::without(why))])
}

fn compared(records: &[&Record], between: Option<[f64; 2]>) -> Result<Option<Comparison>, Error> {
    let has_grains = |record: &&Record| ["grid", "grains"].iter().all(|table| record.scenario.contains_key(*table));
    if records.len() < 2 || !records.iter().all(has_grains) {
        return Ok(None);
    }
    alike::check(records)?;
    let Some(press) = Press::of(&records[0].scenario) else {
        return Ok(Some(nothing("Nothing is compared: no body of these jobs moves along a path.".to_owned())));
    };
    let runs = Runs::of(records, press)?;
    let measured = bands::measured(&runs, between)?;
    let parts = [
        ("load_curve", load_curve::part(&runs, between)),
        ("bands", bands::part(&runs, &measured)?),
        ("volume", volume::part(&runs, &measured)?),
        ("strain", strain::part(&runs)?),
    ];
    Ok(Some(Comparison::made_of(runs.described(), parts)))
}

impl<'a> Runs<'a> {
    fn of(records: &[&'a Record], press: Press) -> Result<Self, Error> {
        let mut kinds = Vec::new();
        let groups: Vec<usize> = records.iter().map(|record| number_of(kind_of(record), &mut kinds)).collect();
        let run = |(&record, &group): (&&'a Record, &usize)| Run::of(record, group, &press);
        let all = records.iter().zip(&groups).map(run).collect::<Result<Vec<_>, _>>()?;
        let first = |group: usize| all.iter().find(|run| run.group == group).map(told);
        let told: Vec<Told> = (0..kinds.len()).filter_map(first).collect();
        Ok(Self { press, groups: Group::list(named(&told), &groups), all })
    }

    /// The grains alone that a run is held against: those of its packing, or else the first.
    fn partner(&self, run: &Run) -> Option<usize> {
        let dem = || (0..self.all.len()).filter(|&other| self.all[other].is("dem"));
        dem().find(|&other| self.all[other].seed == run.seed).or_else(|| dem().next())
    }

    /// The strain from which a run is compared: that of its enrichment, or of the last of all; zero where there is none.
    fn compared_from(&self, run: &Run) -> f64 {
        let all = self.all.iter().filter_map(|run| run.enriched_strain());
        run.enriched_strain().unwrap_or_else(|| all.fold(0.0, f64::max))
    }

    fn described(&self) -> Vec<Value> {
        let describe = |run: &Run| {
            json!({
                "label": run.label, "directory": run.record.directory, "method": run.method, "seed": run.seed,
                "group": self.groups[run.group].name, "strain": self.press.strain_words(), "strain_end": run.strain_end(),
                "enriched_at_strain": run.enriched_strain(),
            })
        };
        self.all.iter().map(describe).collect()
    }
}

/// The scenario without the packing's seed, and without what its method does not use or results do not depend on; of grains
/// alone regions are only where they lie, which is the same for all runs.
fn kind_of(record: &Record) -> toml::Table {
    let unused: &[&str] = match record.word("method") {
        Some("dem") => &["material", "region", "scheme.points_per_cell", "oracle", "enrichment", "time.grain_steps"],
        Some("mpm") => &["oracle", "enrichment"],
        _ => &[],
    };
    without(&record.scenario, ANY.iter().chain(unused))
}

/// What a group can be named by.
fn told(run: &Run) -> Told {
    let number = |path: &str| figure(&run.record.scenario, path);
    let millimetres =
        |what: &str, length: Option<f64>| length.map(|length| format!("{what} {}{THIN}mm", plain(1e3 * length, 3)));
    let hybrid = run.is("hybrid");
    Told {
        method: run.method.clone(),
        run: run.record.name.clone(),
        of: vec![
            number("enrichment.training").filter(|_| hybrid).map(|share| format!("training {}", percent(share))),
            millimetres("distance", number("enrichment.distance").filter(|_| hybrid)),
            millimetres("cell", run.cell()),
        ],
    }
}
