//! Whose grains are tested: what a job of any method that has grains and a continuum says of them.

use crate::base::error::Error;
use crate::job::assembly::{Assembly, Matter, Packed, Preparation, Sizes, Source};
use crate::job::mpm::{Granular, Mpm};
use crate::job::{BLOCK_OF_DISCS, Job, Scenario, significant};
use crate::law::material::CriticalConstants;

/// The grains of a job and the material that it has for them.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// The job's.
    pub name: String,
    /// A periodic piece of packing; tests give it a cell and a way.
    pub piece: Assembly,
    /// Of the packings and of the tests, Pa.
    pub stress: f64,
    /// The job's continuum as it is, where it has one.
    pub now: Option<CriticalConstants>,
    /// Where the job shears its grains under another stress.
    pub other_stress: Option<String>,
    /// How a job takes what is found: its table and key.
    pub taken_by: [&'static str; 2],
    /// The job, written out.
    pub text: String,
}

impl Subject {
    /// Refuses a job whose grains are not those that would be tested; `file` is that of the job.
    pub fn of(job: &Job, file: &str) -> Result<Self, Error> {
        let text = job.to_toml();
        match job {
            Job::Shear(scenario) => Self::of_shear(scenario, file, text),
            Job::Mpm(Mpm { grains: Some(granular), .. }) => Ok(Self::of_grid(job.name(), granular, job, text)),
            Job::Mpm(_) => Err(Error::User(format!(
                "{file}: this continuum has no grains, so that there is nothing to calibrate it by. Add [grains], [packing], [contact] and method, or give a job of planar shear."
            ))),
            Job::Assembly(_) => Err(Error::User(format!(
                "{file}: this job has grains alone and no continuum to calibrate. Give a job of planar shear, or one with [grid] and [grains]."
            ))),
        }
    }

    fn of_shear(scenario: &Scenario, file: &str, text: String) -> Result<Self, Error> {
        refuse_other_grains(scenario, file)?;
        let (grains, packing) = (&scenario.grains, &scenario.packing);
        let [packed, loaded] = [packing.stress, scenario.loading.stress_normal].map(|stress| 1e-3 * stress);
        let other_stress = (packed != loaded).then(|| {
            format!(
                "Made and tested under packing.stress = {} kPa, these are not the figures at loading.stress_normal = {} kPa: stiffness and dilation hang on the stress.",
                significant(packed, 6),
                significant(loaded, 6)
            )
        });
        let mut piece = Assembly {
            seed: scenario.seed,
            matter: Matter { density: grains.density, diameter_mean: grains.diameter_mean },
            source: Source::Packed(Packed {
                sizes: Sizes::Normal { mean: grains.diameter_mean, deviation: grains.diameter_deviation },
                count: 1,
                preparation: Preparation::Compress { stress: packing.stress, fraction: None, unloaded: None },
                friction: packing.friction,
                fraction_start: packing.fraction_start,
                energy_ratio_max: packing.energy_ratio_max,
                cache: packing.cache.clone(),
            }),
            contact: scenario.contact,
            step: scenario.time.step,
            skin: scenario.decomposition.skin,
            block: BLOCK_OF_DISCS * grains.diameter_mean,
            output: scenario.output,
            ..Assembly::blank()
        };
        piece.cell.depth = scenario.specimen.depth;
        let now = scenario.method.has_points().then(|| scenario.continuum.constants());
        let (name, stress) = (scenario.name.clone(), packing.stress);
        Ok(Self { name, piece, stress, now, other_stress, taken_by: ["continuum", "material"], text })
    }

    fn of_grid(name: &str, granular: &Granular, job: &Job, text: String) -> Self {
        let stress = match &granular.piece.source {
            Source::Packed(Packed { preparation: Preparation::Compress { stress, .. }, .. }) => *stress,
            _ => unreachable!("a checked job has its piece compressed"),
        };
        let now = match job {
            Job::Mpm(Mpm { material, .. }) => material.law.critical().copied(),
            _ => None,
        };
        let piece = Assembly { output: *job.output(), ..granular.piece.clone() };
        Self { name: name.to_string(), piece, stress, now, other_stress: None, taken_by: ["material", "file"], text }
    }

    /// The piece with so many grains of that seed, at rest to that share of energy.
    pub fn packed(&self, grains: u64, seed: u64, energy_ratio_most: f64) -> Assembly {
        let mut piece = Assembly { seed, ..self.piece.clone() };
        if let Source::Packed(packed) = &mut piece.source {
            packed.count = grains;
            packed.energy_ratio_max = packed.energy_ratio_max.min(energy_ratio_most);
            packed.preparation = Preparation::Compress { stress: self.stress, fraction: None, unloaded: None };
        }
        piece
    }
}

/// Refuses a job whose grains are not those that would be tested; `file` is that of the job.
fn refuse_other_grains(scenario: &Scenario, file: &str) -> Result<(), Error> {
    if let Some(given) = &scenario.grains.file {
        return Err(Error::User(format!(
            "{file}: grains.file = \"{}\" gives the packing, and calibration makes packings of its own by grains.diameter_mean, grains.diameter_deviation and [packing]: what it finds would not be of these grains. Calibrate a copy of the job without grains.file whose [packing] makes grains like them.",
            given.display()
        )));
    }
    if !scenario.moves_grains() {
        return Err(Error::User(format!(
            "{file}: with method = \"mpm\" and continuum.fraction_start this job has no grains at any time, and its [contact] binds nothing. Remove continuum.fraction_start, so that the continuum starts from a packing of these grains; or, if [grains], [contact] and [packing] are those of the material, add --set method=dem."
        )));
    }
    Ok(())
}
