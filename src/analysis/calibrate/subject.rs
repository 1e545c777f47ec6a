//! Whose grains are tested: what a job of any method that has grains and a continuum says of them.

use super::element::Packing;
use crate::base::error::Error;
use crate::job::assembly::{Assembly, Preparation, Source};
use crate::job::figures::stresses_of_packing;
use crate::job::{Job, significant};
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
    /// The job, written out.
    pub text: String,
}

impl Subject {
    /// 2 of discs, 3 of spheres.
    pub fn axes(&self) -> usize {
        self.piece.cell.dimension
    }

    /// Refuses a job whose grains are not those that would be tested; `file` is that of the job. With `alone` it need not have
    /// a continuum.
    pub fn of(job: &Job, file: &str, alone: bool) -> Result<Self, Error> {
        let continuum = job.continuum();
        let Some(grains) = job.grains().filter(|_| alone || continuum.is_some()) else {
            return Err(Error::User(match job.grains() {
                Some(_) => format!(
                    "{file}: this job has grains alone and no continuum to calibrate. Add --law mobilised_friction for a material of its grains, or give a job of planar shear, or one with [grid] and [grains]."
                ),
                None => format!(
                    "{file}: this continuum has no grains, so that there is nothing to calibrate it by. Add [grains], [packing], [contact] and method, or give a job of planar shear."
                ),
            }));
        };
        if alone {
            refuse_other_assembly(&grains, file)?;
        } else if grains.cell.dimension == 3 {
            return Err(Error::User(format!(
                "{file}: these grains are spheres, which critical_drucker_prager is not fitted to. Add --law mobilised_friction."
            )));
        }
        refuse_other_grains(job, &grains, file)?;
        let now = continuum.filter(|_| job.has_material());
        let stress = *stresses_of_packing(&grains).first().expect("these grains are compressed");
        Ok(Self {
            name: job.name().to_string(),
            other_stress: other_stress(job, stress),
            stress,
            piece: Assembly { output: *job.output(), ..grains.of_one_copy().into_owned() },
            now: now.and_then(|continuum| continuum.material.law.critical().copied()),
            text: job.to_toml(),
        })
    }

    /// The piece with so many grains of that seed.
    pub fn packed(&self, grains: u64, seed: u64, packing: Packing) -> Assembly {
        let mut piece = Assembly { seed, ..self.piece.clone() };
        if let Source::Packed(packed) = &mut piece.source {
            packed.count = grains;
            packed.energy_ratio_max = packed.energy_ratio_max.min(packing.energy_ratio_most);
            packed.preparation = Preparation::Compress { stress: packing.stress, fraction: None, unloaded: None };
            packed.friction = packing.friction.unwrap_or(packed.friction);
        }
        piece
    }
}

/// Where a packing is sheared under another stress than it is made under.
fn other_stress(job: &Job, packed: f64) -> Option<String> {
    let [packed, loaded] = [packed, job.plates()?.stress_normal].map(|stress| 1e-3 * stress);
    (packed != loaded).then(|| {
        format!(
            "Made and tested under packing.stress = {} kPa, these are not the figures at loading.stress_normal = {} kPa: stiffness and dilation hang on the stress.",
            significant(packed, 6),
            significant(loaded, 6)
        )
    })
}

/// Element tests make packings of their own, by compression.
fn refuse_other_assembly(grains: &Assembly, file: &str) -> Result<(), Error> {
    if let Some(given) = grains.source.file() {
        return Err(Error::User(format!(
            "{file}: grains.file = \"{}\" gives the grains, and calibration makes packings of its own by their sizes. Give a job whose [grains] and [packing] make grains like them.",
            given.display()
        )));
    }
    if stresses_of_packing(grains).is_empty() {
        return Err(Error::User(format!(
            "{file}: packing.preparation = \"pour\" has no stress that element tests could be done under. Write preparation = \"compress\" with a stress."
        )));
    }
    Ok(())
}

/// Refuses a job whose grains are not those that would be tested; `file` is that of the job.
fn refuse_other_grains(job: &Job, grains: &Assembly, file: &str) -> Result<(), Error> {
    if let (Some(given), true) = (grains.source.file(), job.plates().is_some()) {
        return Err(Error::User(format!(
            "{file}: grains.file = \"{}\" gives the packing, and calibration makes packings of its own by grains.diameter_mean, grains.diameter_deviation and [packing]: what it finds would not be of these grains. Calibrate a copy of the job without grains.file whose [packing] makes grains like them.",
            given.display()
        )));
    }
    if job.plates().is_some() && !job.moves_grains() {
        return Err(Error::User(format!(
            "{file}: with method = \"mpm\" and material.fraction this job has no grains at any time, and its [contact] binds nothing. Remove material.fraction, so that the continuum starts from a packing of these grains; or, if [grains], [contact] and [packing] are those of the material, add --set method=dem."
        )));
    }
    Ok(())
}
