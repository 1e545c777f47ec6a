//! The element tests: what is done to a packing in a periodic cell, each written as a job of an assembly of grains, and what
//! is measured meanwhile.
//!
//! All are slow against t_p = d sqrt(rho/p), in which the stress moves a grain by its own size: a rate of strain times t_p is
//! the inertial number I (da Cruz et al. 2005), and below 1e-3 grains flow as if they had all the time there is.

use super::Subject;
use super::fit::Shear;
use crate::base::error::Error;
use crate::base::math::{self, PI};
use crate::base::space::Plane;
use crate::dem::sample::Sample;
use crate::domain::stop::{self, Wish};
use crate::job::assembly::{Assembly, Cell, CellServo};
use crate::job::{Job, Output, derived, figures};
use crate::law::contact::Contact;
use crate::prepare::grain_world;

/// Volume strain of the compressions, and its share that gives the moduli: from there on contacts slide.
pub const STRAIN_VOLUME: f64 = 1e-3;
pub const STRAIN_SMALL: f64 = 1e-4;
/// Strain between two rows.
const ROW_VOLUME: f64 = 1e-5;
pub const ROW_SHEAR: f64 = 5e-4;
/// Inertial numbers.
pub const INERTIAL_COMPRESSION: f64 = 1e-4;
pub const INERTIAL_SHEAR: f64 = 2.5e-4;
/// The cell may stretch so many times faster than it shears: no dense packing dilates as fast.
const STRETCH_MOST: f64 = 10.0;
/// Kinetic over elastic energy of a packing at rest, at most: small strains must be seen above what still moves.
const ENERGY_RATIO_MOST: f64 = 1e-5;
/// Deepest overlap that is still physics, as a share of the smaller radius.
const OVERLAP_MAX: f64 = 0.5;

/// What is done to the packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// Both edges shrink alike.
    Isotropic,
    /// The height shrinks, the width does not.
    Uniaxial,
    /// Shear along x to this strain; the normal stress along y is kept, the width too.
    Shear { strain: f64 },
}

/// One test of one packing.
#[derive(Clone, Copy, Debug)]
pub struct Element<'a> {
    /// Whose grains they are, made and tested under its packing's stress.
    pub subject: &'a Subject,
    /// The job's law, or the same without cohesion.
    pub contact: Contact,
    pub test: Test,
    pub grains: u64,
    /// Of the packing.
    pub seed: u64,
}

/// The state of the packing at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Volume strain of a compression (positive where the volume shrinks), shear strain of a shear test.
    pub strain: f64,
    /// Mean stress of the contacts: xx, xy, yy; Pa, tension positive.
    pub stress: [f64; 3],
    /// Solid volume fraction.
    pub fraction: f64,
}

impl Test {
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::Uniaxial => "uniaxial",
            Self::Shear { .. } => "shear",
        }
    }

    fn inertial(self) -> f64 {
        match self {
            Self::Isotropic | Self::Uniaxial => INERTIAL_COMPRESSION,
            Self::Shear { .. } => INERTIAL_SHEAR,
        }
    }

    fn strain_end(self) -> f64 {
        match self {
            Self::Isotropic | Self::Uniaxial => STRAIN_VOLUME,
            Self::Shear { strain } => strain,
        }
    }

    fn strain_of_row(self) -> f64 {
        match self {
            Self::Isotropic | Self::Uniaxial => ROW_VOLUME,
            Self::Shear { .. } => ROW_SHEAR,
        }
    }

    /// Velocity gradient at a rate of strain, 1/s.
    fn gradient(self, rate: f64) -> [[f64; 3]; 3] {
        let mut gradient = [[0.0; 3]; 3];
        match self {
            Self::Isotropic => (gradient[0][0], gradient[1][1]) = (-0.5 * rate, -0.5 * rate),
            Self::Uniaxial => gradient[1][1] = -rate,
            Self::Shear { .. } => gradient[0][1] = rate,
        }
        gradient
    }
}

impl Element<'_> {
    /// Of the test, and of its file.
    pub fn name(&self) -> String {
        let without = if self.contact == self.subject.piece.contact { "" } else { "_without_cohesion" };
        format!("{}{without}", self.test.name())
    }

    /// Of the packing, and of the shear; Pa.
    pub fn stress(&self) -> f64 {
        self.subject.stress
    }

    /// Rate of strain, 1/s.
    pub fn rate(&self) -> f64 {
        let grains = &self.subject.piece.matter;
        self.test.inertial() / (grains.diameter_mean * (grains.density / self.stress()).sqrt())
    }

    /// The test as a job that `scree run` takes, checked like any other.
    pub fn job(&self) -> Result<Assembly, Error> {
        let text = self.assembly().to_toml();
        let job = Job::parse(&text, &format!("the {} test of this job's grains", self.name()), &[])?;
        Ok(job.as_assembly().expect("an assembly is written as one").clone())
    }

    fn assembly(&self) -> Assembly {
        let stress = self.stress();
        let packed = self.subject.packed(self.grains, self.seed, ENERGY_RATIO_MOST);
        let square = figures::sizes(&packed).map_or(0.0, |sizes| sizes.power_mean(2));
        let side = (self.grains as f64 * (0.25 * PI * square) / derived::FRACTION_DENSE).sqrt();
        let rate = self.rate();
        let servo = match self.test {
            Test::Shear { .. } => {
                let stress = [None, Some(-stress), None];
                let (gain, interval) = (CellServo::GAIN, CellServo::INTERVAL);
                Some(CellServo { stress, rate_max: STRETCH_MOST * rate, gain, interval })
            }
            Test::Isotropic | Test::Uniaxial => None,
        };
        let end = self.test.strain_end() / rate;
        Assembly {
            name: format!("{}_{}_{}", self.subject.name, self.name(), self.seed),
            cell: Cell {
                upper: [side, side, 0.0],
                periodic: [true, true, false],
                gradient: self.test.gradient(rate),
                servo,
                ..packed.cell.clone()
            },
            contact: self.contact,
            end,
            output: Output {
                series_interval: self.test.strain_of_row() / rate,
                frame_interval: end,
                checkpoint_interval: end,
                ..packed.output
            },
            ..packed
        }
    }

    /// Does the test; the packing comes from the cache where it is there.
    pub fn measure(&self) -> Result<Vec<Row>, Error> {
        let job = &self.job()?;
        let (test, rate) = (self.test, self.rate());
        let mut sample = grain_world::sample::<Plane>(job)?;
        let solid = grain_world::solid_of(&sample.assembly.grains, job).value(0);
        let count = (test.strain_end() / test.strain_of_row()).round() as u64;
        let mut rows: Vec<Row> = Vec::with_capacity(count as usize + 1);
        for number in 0..=count {
            let due = (number as f64 * test.strain_of_row() / (rate * job.step)).round() as u64;
            let missing = due - sample.step;
            steps(&mut sample, missing)?;
            sample.refuse_deep_overlaps(OVERLAP_MAX)?;
            let row = row(&mut sample, job, solid);
            let strain = match test {
                Test::Shear { .. } => rate * sample.time(),
                Test::Isotropic | Test::Uniaxial => {
                    rows.first().map_or(0.0, |first| math::ln(row.fraction / first.fraction))
                }
            };
            rows.push(Row { strain, ..row });
        }
        Ok(rows)
    }

    /// Does it as a shear test.
    pub fn shear(&self) -> Result<Shear, Error> {
        Ok(Shear { stress: self.stress(), rows: self.measure()? })
    }
}

/// So many steps, unless a stop is asked for.
fn steps(sample: &mut Sample<Plane>, count: u64) -> Result<(), Error> {
    for _ in 0..count {
        sample.advance()?;
        if stop::wish() == Wish::Stop {
            return Err(Error::Stopped(sample.step));
        }
    }
    Ok(())
}

/// Stress and solid volume fraction of now; `solid` is the volume of all grains, m3.
fn row(sample: &mut Sample<Plane>, job: &Assembly, solid: f64) -> Row {
    let volume = grain_world::volume(&sample.assembly.cell, job);
    let moment = sample.contact_moment() * (1.0 / volume);
    let shear = 0.5 * (moment[(0, 1)] + moment[(1, 0)]);
    Row { strain: 0.0, stress: [moment[(0, 0)], shear, moment[(1, 1)]], fraction: solid / volume }
}
