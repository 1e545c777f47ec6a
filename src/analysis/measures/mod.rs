//! What one or more runs show, in numbers: each by itself, and compared as Chen et al. (2021) compare theirs, figures 10 to 24. Planar
//! shear, a body that presses, a cell that is deformed: what counts is that the runs have a strain and what resists it.
//!
//! One file a figure of the paper: each measures, and says in one line why something is left out. Their fields are the keys of
//! `comparison.json`.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::run::Run;
use crate::base::error::Error;

pub mod among;
pub mod bands;
pub mod disturbance;
pub mod ensembles;
pub mod inside;
pub mod speed;
pub mod stress;
pub mod trained;
pub mod volume;

use among::{Among, Member};

/// What was measured, and why some of it is not there, a line each.
#[derive(Clone, Debug, Default)]
pub struct Found<T> {
    /// Empty, or none, where nothing was measured.
    pub of: T,
    /// Sentences for a reader.
    pub left_out: Vec<String>,
}

impl<T> Found<T> {
    fn of(of: T, left_out: Vec<String>) -> Self {
        Self { of, left_out }
    }
}

impl<T: Default> Found<T> {
    fn nothing(why: String) -> Self {
        Self { of: T::default(), left_out: vec![why] }
    }
}

/// All that is measured.
pub struct Measures<'a> {
    /// The runs, and who is compared with whom.
    pub among: Among<'a>,
    /// Moving averages, peaks, and differences from grains alone.
    pub stress: Found<stress::Stress>,
    /// Peak and softening of each run whose stress rises above zero.
    pub levels: Found<Vec<stress::Level>>,
    /// Of groups with two packings or more.
    pub ensembles: Found<Vec<ensembles::Ensemble>>,
    /// None in space and in a cell of grains, and where there is no interval of strain to measure between.
    pub bands: Found<Option<bands::Bands>>,
    /// Of runs with a volume strain of the whole, of a band or of a zone.
    pub volume: Found<Vec<volume::Volume>>,
    /// Of enriched hybrids in planar shear; else empty.
    pub trained: Found<Vec<trained::Trained>>,
    /// Of hybrids in which grains took the place of points.
    pub disturbance: Found<Vec<disturbance::Disturbed>>,
    /// Of enriched hybrids in planar shear, each with grains alone of its packing; else empty.
    pub inside: Found<Vec<inside::Inside>>,
    /// Of hybrids with grains and points, each with grains alone of its packing.
    pub speed: Found<Vec<speed::Speed>>,
}

impl<'a> Measures<'a> {
    /// Of runs in their order, incremental strains and differences of those that press `between` two strains; or why there are
    /// none.
    pub fn of(runs: &'a [Run], between: Option<[f64; 2]>) -> Result<Result<Self, String>, Error> {
        let among = Among::of(runs);
        if let Some(why) = among.unlike() {
            return Ok(Err(why));
        }
        let is_shear = runs[0].drive.is_shear();
        // The paper's differences of planar shear are from the enrichment on, whatever bands are measured between.
        let mut stress = stress::measured(&among, between.filter(|_| !is_shear));
        stress.left_out.extend(among.apart.iter().cloned());
        let averages = &stress.of.averages;
        let bands = bands::measured(&among, between)?;
        let levels = stress::levels(&among, averages);
        let of_shear = |wanted: bool| if wanted { Some(&among) } else { None };
        Ok(Ok(Self {
            ensembles: ensembles::measured(&among, &levels.of),
            levels,
            volume: volume::measured(&among, bands.of.as_ref())?,
            trained: of_shear(is_shear).map(trained::measured).transpose()?.unwrap_or_default(),
            inside: of_shear(is_shear).map(|among| inside::measured(among, averages)).transpose()?.unwrap_or_default(),
            disturbance: disturbance::measured(&among),
            speed: speed::measured(&among)?,
            stress,
            bands,
            among,
        }))
    }

    /// Peak and level of runs alone, for which no frame is read; or why there are none.
    pub fn of_curves(runs: &[Run]) -> Result<Found<Vec<stress::Level>>, String> {
        let among = Among::of(runs);
        match among.unlike() {
            Some(why) => Err(why),
            None => Ok(stress::levels(&among, &stress::averages(&among).1)),
        }
    }

    /// What was measured of one run around its enrichment.
    pub fn disturbed(&self, index: usize) -> Option<&disturbance::Disturbed> {
        self.disturbance.of.iter().find(|disturbed| disturbed.who.index == index)
    }

    /// Of one run, by its place among the runs; none where it has none.
    pub fn level(&self, index: usize) -> Option<&stress::Level> {
        self.levels.of.iter().find(|level| level.who.index == index)
    }

    /// For `comparison.json`; nothing where nothing was found.
    pub fn json(&self) -> Value {
        let drive = &self.among.members[0].run.drive;
        let describe = |member: &Member| {
            let (who, run) = (&member.who, member.run);
            json!({
                "label": who.run, "directory": run.directory, "method": run.method, "seed": who.seed, "group": who.group,
                "strain": drive.words, "strain_end": member.strain_end(),
                "enriched_at_strain": run.enrichment().map(|(_, strain)| strain),
            })
        };
        let mut all = Map::new();
        let mut left_out = Map::new();
        let mut add = |name: &str, (found, why): (Value, &[String])| {
            let is_empty = found.as_array().is_some_and(Vec::is_empty);
            all.insert(name.to_owned(), if is_empty { Value::Null } else { found });
            left_out.insert(name.to_owned(), json!(why));
        };
        add(drive.key, told(&self.stress));
        add("softening", told(&self.levels));
        add("ensembles", told(&self.ensembles));
        add("bands", told(&self.bands));
        add("volume", told(&self.volume));
        add("training", told(&self.trained));
        add("disturbance", told(&self.disturbance));
        add("inside_the_zone", told(&self.inside));
        add("speed_up", told(&self.speed));
        all.insert("runs".to_owned(), self.among.members.iter().map(describe).collect());
        all.insert("left_out".to_owned(), Value::Object(left_out));
        Value::Object(all)
    }
}

fn told<T: Serialize>(found: &Found<T>) -> (Value, &[String]) {
    (serde_json::to_value(&found.of).expect("numbers and words are JSON"), &found.left_out)
}
