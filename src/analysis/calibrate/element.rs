//! The element tests: what is done to a packing in a periodic cell, each written as a job of an assembly of grains, and what
//! is measured meanwhile.
//!
//! All are slow against t_p = d sqrt(rho/p), in which the stress moves a grain by its own size: a rate of strain times t_p is
//! the inertial number I (da Cruz et al. 2005), and below 1e-3 grains flow as if they had all the time there is.

use super::Subject;
use super::fit::Shear;
use super::layers::{Layers, Profile};
use crate::base::error::Error;
use crate::base::math;
use crate::base::space::{Plane, Solid, Space};
use crate::dem::sample::Sample;
use crate::domain::stop::{self, Wish};
use crate::job::assembly::{Assembly, Cell, CellServo};
use crate::job::{Job, Output, derived, figures};
use crate::law::contact::Contact;
use crate::prepare::grain_world;

/// Volume strain of the compressions, and its share that gives the moduli: from there on contacts slide.
pub const STRAIN_VOLUME: f64 = 1e-3;
/// Volume strain up to which the slopes are taken that are moduli.
pub const STRAIN_SMALL: f64 = 1e-4;
/// Strain between two rows.
const ROW_VOLUME: f64 = 1e-5;
/// Shear strain between two rows, and the largest increment that the law is driven by along them.
pub const ROW_SHEAR: f64 = 5e-4;
/// Inertial numbers.
pub const INERTIAL_COMPRESSION: f64 = 1e-4;
/// Of shear and of biaxial compression; small cycles are slower.
pub const INERTIAL_SHEAR: f64 = 2.5e-4;
/// Of small cycles: a cell of some hundred grains must come to the end of its waves within 1e-4 of strain.
pub const INERTIAL_CYCLES: f64 = 2.5e-5;
/// The cell may stretch so many times faster than it shears: no dense packing dilates as fast.
const STRETCH_MOST: f64 = 10.0;
/// Kinetic over elastic energy of a packing at rest, at most: small strains must be seen above what still moves.
pub const ENERGY_RATIO_MOST: f64 = 1e-5;
/// Of the course with reversals: of a first small unloading, while friction is mobilised, by how much, and of the reversal, at
/// the peak of dense packings.
pub const STRAIN_FIRST: f64 = 0.0025;
/// Shear strain by which the first small unloading goes back.
pub const STRAIN_BACK: f64 = 5e-4;
/// Shear strain of the reversal, which ends at as much the other way.
pub const STRAIN_REVERSAL: f64 = 0.02;
/// Of small cycles: shear strains that are unloaded from, and by how much.
pub const CYCLES: [[f64; 2]; 3] = [[2e-4, 1e-4], [1e-3, 2e-4], [5e-3, 5e-4]];
/// Strain at the end of shear at constant volume, and of biaxial compression.
pub const STRAIN_VOLUME_CONSTANT: f64 = 0.1;
/// Strain along y, compression positive; less where the test is asked to end before.
pub const STRAIN_BIAXIAL: f64 = 0.05;
/// Solid volume fraction of spheres by which the cell is drawn; grains are put into a larger one, and come to rest at their own.
const FRACTION_DENSE_SPHERES: f64 = 0.6;
/// Deepest overlap that is still physics, as a share of the smaller radius.
const OVERLAP_MAX: f64 = 0.5;

/// What is done to the packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// All edges shrink alike.
    Isotropic,
    /// The height shrinks, nothing else does.
    Uniaxial,
    /// Shear along x to this strain; the normal stress along y is kept, the other edges too.
    Shear {
        /// At the end of the test.
        strain: f64,
    },
    /// Shear along x by a course; see [`Course`].
    Sheared {
        /// How it is sheared, or pressed.
        course: Course,
        /// At the end of [`Course::Once`], and the most at constant volume and in biaxial compression; others have their own.
        strain: f64,
    },
}

/// How a packing is sheared where hardening, unloading and volume are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// To the end at constant normal stress, with more rows where it begins.
    Once,
    /// To [`STRAIN_FIRST`], back a little, to [`STRAIN_REVERSAL`], and back to the same strain the other way.
    Reversal,
    /// Through [`CYCLES`], each an unloading: what is left of the first modulus on the way to the peak.
    Cycles,
    /// At constant volume.
    ConstantVolume,
    /// No shear: compressed along y while the normal stress along x is kept; in space plane strain, the edge along z is kept.
    Biaxial,
}

/// A stretch of a course: shear to a strain, with rows at this spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Strain at its end; below that of the leg before where the shear turns.
    pub to: f64,
    /// Strain between two rows.
    pub row: f64,
}

impl Course {
    /// From no strain on; `strain` is the end of a test that is sheared once.
    pub fn legs(self, strain: f64) -> Vec<Leg> {
        let leg = |to, row| Leg { to, row };
        let rising = |end: f64| {
            let ends = [(0.01, 1e-4), (0.05, 5e-4), (end, 1e-3)];
            let mut legs: Vec<Leg> = ends.iter().map(|(to, row)| leg(to.min(end), *row)).collect();
            legs.dedup_by(|next, last| next.to == last.to);
            legs
        };
        match self {
            Self::Once => rising(strain),
            Self::Reversal => vec![
                leg(STRAIN_FIRST, 1e-4),
                leg(STRAIN_FIRST - STRAIN_BACK, 2.5e-5),
                leg(STRAIN_REVERSAL, 1e-4),
                leg(-STRAIN_REVERSAL, 1e-4),
            ],
            Self::Cycles => CYCLES
                .iter()
                .flat_map(|&[to, back]| [leg(to, 0.05 * to.min(2e-3)), leg(to - back, 0.05 * back)])
                .collect(),
            Self::ConstantVolume => rising(STRAIN_VOLUME_CONSTANT.min(strain)),
            Self::Biaxial => rising(STRAIN_BIAXIAL.min(strain)),
        }
    }
}

/// One test of one packing.
#[derive(Clone, Copy, Debug)]
pub struct Element<'a> {
    /// Whose grains they are, made and tested under its packing's stress.
    pub subject: &'a Subject,
    /// The job's law, or the same without cohesion.
    pub contact: Contact,
    /// What is done to it.
    pub test: Test,
    /// How many the packing has.
    pub grains: u64,
    /// Of the packing.
    pub seed: u64,
    /// What the packing is made under and by.
    pub packing: Packing,
}

/// What a packing is made under and by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packing {
    /// Of the packing and of the test, Pa.
    pub stress: f64,
    /// Friction while it is made, in place of the job's: more of it leaves grains looser.
    pub friction: Option<f64>,
    /// Kinetic over elastic energy at rest, at most; no more than the job allows.
    pub energy_ratio_most: f64,
}

/// The state of the packing at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Volume strain of a compression (positive where the volume shrinks), shear strain of a shear test.
    pub strain: f64,
    /// Mean stress of the contacts: xx, xy, yy; Pa, tension positive.
    pub stress: [f64; 3],
    /// Mean of its normal stresses, of two in the plane and of three in space; Pa, compression positive.
    pub pressure: f64,
    /// Solid volume fraction.
    pub fraction: f64,
}

impl Row {
    /// `stress` in Pa, tension positive.
    pub fn of<S: Space>(strain: f64, stress: &S::Tensor, fraction: f64) -> Self {
        let axes = S::DIMENSION;
        let [xx, yx, xy, yy] = [0, 1, axes, axes + 1].map(|component| stress[component]);
        Self { strain, stress: [xx, 0.5 * (xy + yx), yy], pressure: -S::trace(stress) / axes as f64, fraction }
    }
}

impl Test {
    /// As names of jobs and files have it, without what tells packings and stresses apart.
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::Uniaxial => "uniaxial",
            Self::Shear { .. } | Self::Sheared { course: Course::Once, .. } => "shear",
            Self::Sheared { course: Course::Reversal, .. } => "reversal",
            Self::Sheared { course: Course::Cycles, .. } => "small_cycles",
            Self::Sheared { course: Course::ConstantVolume, .. } => "constant_volume",
            Self::Sheared { course: Course::Biaxial, .. } => "biaxial",
        }
    }

    fn inertial(self) -> f64 {
        match self {
            Self::Isotropic | Self::Uniaxial => INERTIAL_COMPRESSION,
            Self::Sheared { course: Course::Cycles, .. } => INERTIAL_CYCLES,
            Self::Shear { .. } | Self::Sheared { .. } => INERTIAL_SHEAR,
        }
    }

    /// The axis whose normal stress is kept, if there is one.
    fn axis_kept(self) -> Option<usize> {
        match self {
            Self::Isotropic | Self::Uniaxial | Self::Sheared { course: Course::ConstantVolume, .. } => None,
            Self::Sheared { course: Course::Biaxial, .. } => Some(0),
            Self::Shear { .. } | Self::Sheared { .. } => Some(1),
        }
    }

    /// Whether strain is time times rate, and not what the volume has become.
    fn is_led(self) -> bool {
        matches!(self, Self::Shear { .. } | Self::Sheared { .. })
    }

    /// Along x.
    fn is_sheared(self) -> bool {
        self.is_led() && self.axis_kept() != Some(0)
    }

    /// Of volume strain in a compression, else of shear strain.
    fn legs(self) -> Vec<Leg> {
        match self {
            Self::Isotropic | Self::Uniaxial => vec![Leg { to: STRAIN_VOLUME, row: ROW_VOLUME }],
            Self::Shear { strain } => vec![Leg { to: strain, row: ROW_SHEAR }],
            Self::Sheared { course, strain } => course.legs(strain),
        }
    }

    /// Velocity gradient at a rate of strain, 1/s.
    fn gradient(self, rate: f64, axes: usize) -> [[f64; 3]; 3] {
        let mut gradient = [[0.0; 3]; 3];
        match self {
            Self::Isotropic => (0..axes).for_each(|axis| gradient[axis][axis] = -rate / axes as f64),
            Self::Uniaxial | Self::Sheared { course: Course::Biaxial, .. } => gradient[1][1] = -rate,
            Self::Shear { .. } | Self::Sheared { .. } => gradient[0][1] = rate,
        }
        gradient
    }
}

impl Element<'_> {
    /// Of the test, and of its file.
    pub fn name(&self) -> String {
        let without = if self.contact == self.subject.piece.contact { "" } else { "_without_cohesion" };
        let loose = if self.packing.friction.is_some() { "_loose" } else { "" };
        let share = match (4.0 * self.packing.stress / self.subject.stress).round() as u32 {
            4 => "",
            2 => "_half_stress",
            _ => "_quarter_stress",
        };
        format!("{}{loose}{share}{without}", self.test.name())
    }

    /// Of the packing, and of the shear; Pa.
    pub fn stress(&self) -> f64 {
        self.packing.stress
    }

    /// Rate of strain, 1/s.
    pub fn rate(&self) -> f64 {
        let grains = &self.subject.piece.matter;
        self.test.inertial() / (grains.diameter_mean * (grains.density / self.stress()).sqrt())
    }

    /// The test as a job that `scree run` takes, checked like any other; of a course that turns its first leg.
    pub fn job(&self) -> Result<Assembly, Error> {
        let text = self.assembly().to_toml();
        let job = Job::parse(&text, &format!("the {} test of this job's grains", self.name()), &[])?;
        Ok(job.as_assembly().expect("an assembly is written as one").clone())
    }

    fn assembly(&self) -> Assembly {
        let stress = self.stress();
        let packed = self.subject.packed(self.grains, self.seed, self.packing);
        let axes = self.subject.axes();
        let solid =
            figures::sizes(&packed).map_or(0.0, |sizes| self.grains as f64 * figures::grain_measure(sizes, axes));
        let side = match axes {
            2 => (solid / derived::FRACTION_DENSE).sqrt(),
            _ => math::cbrt(solid / FRACTION_DENSE_SPHERES),
        };
        let rate = self.rate();
        let servo = self.test.axis_kept().map(|axis| {
            let stress = std::array::from_fn(|other| (other == axis).then_some(-stress));
            let (gain, interval) = (CellServo::GAIN, CellServo::INTERVAL);
            CellServo { stress, rate_max: STRETCH_MOST * rate, gain, interval }
        });
        // The last leg of those that go the first one's way.
        let legs = self.test.legs();
        let turns = legs.windows(2).position(|pair| pair[1].to < pair[0].to).unwrap_or(legs.len() - 1);
        let end = legs[turns].to / rate;
        Assembly {
            name: format!("{}_{}_{}", self.subject.name, self.name(), self.seed),
            cell: Cell {
                lower: [0.0; 3],
                upper: [side, side, if axes == 3 { side } else { 0.0 }],
                periodic: [true, true, axes == 3],
                gradient: self.test.gradient(rate, axes),
                servo,
                ..packed.cell.clone()
            },
            contact: self.contact,
            // A cell by itself, whatever the job has around its grains.
            gravity: [0.0; 3],
            bodies: Vec::new(),
            end,
            output: Output {
                series_interval: legs[turns].row / rate,
                frame_interval: end,
                checkpoint_interval: end,
                ..packed.output
            },
            ..packed
        }
    }

    /// Does the test; the packing comes from the cache where it is there.
    pub fn measure(&self) -> Result<Vec<Row>, Error> {
        Ok(self.measure_layers()?.0)
    }

    /// Does the test, and looks at how layers across the shear share it.
    pub fn measure_layers(&self) -> Result<(Vec<Row>, Vec<Profile>), Error> {
        match self.subject.axes() {
            2 => self.measured::<Plane>(),
            _ => self.measured::<Solid>(),
        }
    }

    fn measured<S: Space>(&self) -> Result<(Vec<Row>, Vec<Profile>), Error> {
        let job = &self.job()?;
        let rate = self.rate();
        let mut sample = grain_world::sample::<S>(job)?;
        let solid = grain_world::solid_of(&sample.assembly.grains, job).value(0);
        let mut rows = vec![row(&mut sample, job, solid)];
        let mut layers = self.test.is_sheared().then(|| Layers::of(&sample, job.matter.diameter_mean));
        let drive = sample.constants.drive.gradient;
        let (mut way, mut from) = (0.0, 0.0);
        for Leg { to, row: spacing } in self.test.legs() {
            let change: f64 = to - from;
            let (length, sign) = (change.abs(), change.signum());
            sample.constants.drive.gradient = drive * sign;
            for number in 1..=(length / spacing).round() as u64 {
                let along = number as f64 * spacing;
                let due = ((way + along) / (rate * job.step)).round() as u64;
                let missing = due - sample.step;
                steps(&mut sample, missing)?;
                sample.refuse_deep_overlaps(OVERLAP_MAX)?;
                let row = row(&mut sample, job, solid);
                let strain = match self.test.is_led() {
                    true => from + sign * (rate * sample.time() - way),
                    false => math::ln(row.fraction / rows[0].fraction),
                };
                layers.iter_mut().for_each(|layers| layers.look(&sample, strain));
                rows.push(Row { strain, ..row });
            }
            (way, from) = (way + length, to);
        }
        Ok((rows, layers.map_or(Vec::new(), |layers| layers.profiles)))
    }

    /// Does it as a shear test.
    pub fn shear(&self) -> Result<Shear, Error> {
        Ok(Shear { axes: self.subject.axes(), stress: self.stress(), rows: self.measure()? })
    }
}

/// So many steps, unless a stop is asked for.
fn steps<S: Space>(sample: &mut Sample<S>, count: u64) -> Result<(), Error> {
    for _ in 0..count {
        sample.advance()?;
        if stop::wish() == Wish::Stop {
            return Err(Error::Stopped(sample.step));
        }
    }
    Ok(())
}

/// Stress and solid volume fraction of now; `solid` is the volume of all grains, m3.
fn row<S: Space>(sample: &mut Sample<S>, job: &Assembly, solid: f64) -> Row {
    let volume = grain_world::volume(&sample.assembly.cell, job);
    Row::of::<S>(0.0, &(sample.contact_moment() * (1.0 / volume)), solid / volume)
}
