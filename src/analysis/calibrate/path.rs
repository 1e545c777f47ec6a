//! A continuum's own law, driven along the path of a shear or biaxial test: what is fitted is what will run.

use crate::analysis::calibrate::element::{ROW_SHEAR, Row};
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::law::material::{ConstitutiveLaw, ForAnyMaterial, MaterialLaw, MaterialMemory};

/// How exactly the normal stress is kept, as a share of it.
const TOLERANCE: f64 = 1e-9;
/// Attempts to enclose the stretch that keeps the normal stress, each twice as wide as the last, and to find it.
const WIDENINGS: usize = 60;
const ATTEMPTS: usize = 100;

/// A law in the plane and in space.
pub trait LawOfAnySpace: MaterialLaw<Plane> + MaterialLaw<Solid> {}
impl<L: MaterialLaw<Plane> + MaterialLaw<Solid>> LawOfAnySpace for L {}

/// A material point in simple shear: L = [[0, g], [0, l]] with l such that the Cauchy stress along y stays, or with l = 0 at
/// constant volume; or in biaxial compression, L = [[l, 0], [0, -g]] with l such that the Cauchy stress along x stays. In space
/// nothing moves along z.
struct Point<'a, S: Space, L: MaterialLaw<S>> {
    law: &'a L,
    kept: Kept,
    /// Pa, compression positive.
    stress: f64,
    memory: L::Memory,
    /// det F since the start.
    volume: f64,
    /// Stretch of the last increment over its shear.
    dilation: f64,
}

/// What is kept while it is sheared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// The normal stress along y.
    NormalStress,
    /// The volume: nothing stretches.
    Volume,
    /// The normal stress along x, in biaxial compression along y.
    LateralStress,
}

/// The start of a shear, what is kept, and how finely the law is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// 2: in the plane; 3: in space.
    pub axes: usize,
    /// Isotropic stress of the start, Pa, compression positive.
    pub stress: f64,
    /// Solid volume fraction of the start.
    pub fraction: f64,
    /// Tells the path too: simple shear, or biaxial compression.
    pub kept: Kept,
    /// Largest increment of shear strain.
    pub increment: f64,
}

/// Memory, volume and Cauchy stress after an increment.
type Stepped<S, M> = (M, f64, <S as Space>::Tensor);

impl Drive {
    /// Simple shear at a constant normal stress (Pa, compression positive), from a solid volume fraction on.
    pub fn shear(axes: usize, stress: f64, fraction: f64) -> Self {
        Self { axes, stress, fraction, kept: Kept::NormalStress, increment: ROW_SHEAR }
    }
}

/// The law's response at shear strains that may rise and fall, with the volume over that of the start; none where the law
/// cannot keep the normal stress. `fraction` of a row is the law's own Phi.
pub fn sheared<L: LawOfAnySpace>(law: &L, drive: Drive, strains: impl Iterator<Item = f64>) -> Option<Vec<(Row, f64)>> {
    match drive.axes {
        2 => sheared_in::<Plane, L>(law, drive, strains),
        _ => sheared_in::<Solid, L>(law, drive, strains),
    }
}

/// The same of the law that a job names.
pub fn response(law: &ConstitutiveLaw, drive: Drive, strains: &[f64]) -> Option<Vec<(Row, f64)>> {
    match drive.axes {
        2 => law.apply::<Plane, _>(Along(drive, strains)),
        _ => law.apply::<Solid, _>(Along(drive, strains)),
    }
}

/// A path, and shear strains at which it is looked at.
struct Along<'a>(Drive, &'a [f64]);

impl<S: Space> ForAnyMaterial<S> for Along<'_> {
    type Outcome = Option<Vec<(Row, f64)>>;

    fn with<L: MaterialLaw<S>>(self, law: L) -> Self::Outcome {
        sheared_in::<S, L>(&law, self.0, self.1.iter().copied())
    }
}

fn sheared_in<S: Space, L: MaterialLaw<S>>(
    law: &L,
    drive: Drive,
    strains: impl Iterator<Item = f64>,
) -> Option<Vec<(Row, f64)>> {
    let memory = law.start(&(S::identity() * -drive.stress), drive.fraction);
    let mut point = Point { law, kept: drive.kept, stress: drive.stress, memory, volume: 1.0, dilation: 0.0 };
    let (mut rows, mut strain) = (Vec::new(), 0.0);
    let mut cauchy = law.stress(&point.memory);
    for wanted in strains {
        let change: f64 = wanted - strain;
        // Rows of one spacing differ by rounding.
        let pieces = (change.abs() / drive.increment - 1e-6).ceil().max(1.0);
        let increment = change / pieces;
        if increment != 0.0 {
            for _ in 0..pieces as usize {
                cauchy = point.shear(increment)?;
            }
        }
        strain = wanted;
        rows.push((Row::of::<S>(strain, &cauchy, point.memory.fraction()), point.volume));
    }
    Some(rows)
}

impl<S: Space, L: MaterialLaw<S>> Point<'_, S, L> {
    /// One increment, with the stretch that keeps the normal stress or the volume.
    fn shear(&mut self, increment: f64) -> Option<S::Tensor> {
        let stretch = match self.kept {
            Kept::NormalStress | Kept::LateralStress => self.stretch(increment)?,
            Kept::Volume => 0.0,
        };
        let (memory, volume, stress) = self.stepped(increment, stretch);
        (self.memory, self.volume, self.dilation) = (memory, volume, stretch / increment);
        stress.is_finite().then_some(stress)
    }

    fn stepped(&self, increment: f64, stretch: f64) -> Stepped<S, L::Memory> {
        let mut memory = self.memory;
        let mut gradient = S::Tensor::zero();
        // Column by column.
        let [xx, xy, yy] = [0, S::DIMENSION, S::DIMENSION + 1];
        let stretches = match self.kept {
            Kept::NormalStress | Kept::Volume => {
                (gradient[xy], gradient[yy]) = (increment, stretch);
                1.0 + stretch
            }
            Kept::LateralStress => {
                (gradient[xx], gradient[yy]) = (stretch, -increment);
                (1.0 + stretch) * (1.0 - increment)
            }
        };
        let kirchhoff = self.law.update(&gradient, 1.0, &mut memory);
        let volume = self.volume * stretches;
        (memory, volume, kirchhoff * (1.0 / volume))
    }

    /// The root of the missing normal stress by the Illinois form of the false position (Dowell & Jarratt 1971); the stress
    /// kept rises with the stretch.
    fn stretch(&self, increment: f64) -> Option<f64> {
        let kept = if self.kept == Kept::LateralStress { 0 } else { S::DIMENSION + 1 };
        let missing = |stretch: f64| self.stepped(increment, stretch).2[kept] / self.stress + 1.0;
        let middle = self.dilation * increment;
        let (mut lower, mut upper) = (middle, middle);
        let mut at = [missing(middle); 2];
        let mut width = 0.1 * increment.abs();
        for _ in 0..WIDENINGS {
            if at[0] > 0.0 {
                (upper, at[1]) = (lower, at[0]);
                lower -= width;
                at[0] = missing(lower);
            } else if at[1] < 0.0 {
                (lower, at[0]) = (upper, at[1]);
                upper += width;
                at[1] = missing(upper);
            } else {
                break;
            }
            width *= 2.0;
        }
        if !(at[0] <= 0.0 && at[1] >= 0.0) {
            return None;
        }
        let mut side = 0;
        for _ in 0..ATTEMPTS {
            if at[1] == at[0] {
                return Some(lower);
            }
            let guess = (lower * at[1] - upper * at[0]) / (at[1] - at[0]);
            let found = missing(guess);
            if found.abs() < TOLERANCE {
                return Some(guess);
            }
            if found < 0.0 {
                (lower, at[0]) = (guess, found);
                at[1] *= if side == -1 { 0.5 } else { 1.0 };
                side = -1;
            } else {
                (upper, at[1]) = (guess, found);
                at[0] *= if side == 1 { 0.5 } else { 1.0 };
                side = 1;
            }
        }
        Some(0.5 * (lower + upper))
    }
}
