//! The same assembly under several stresses: states along one path of compression, so that points at any depth start from what one packing
//! becomes there.

use crate::base::error::Error;
use crate::base::parallel::larger;
use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::rve::drive::Drive;
use crate::rve::step::Scratch;
use crate::rve::volume_element::Rve;

/// How an assembly is brought to a stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// All axes alike, and in the end a little along each and across them, until the stress is the same along all.
    Isotropic,
    /// Along one axis, the others kept (K0); the stress is that along it.
    Uniaxial {
        /// 0 to 2.
        axis: usize,
    },
}

/// Largest increment of strain.
const INCREMENT: f64 = 1e-5;
/// Share of what is missing that an increment aims at.
const SHARE: f64 = 0.8;
/// How near a level is come to.
const TOLERANCE: f64 = 1e-3;
/// Increments in which a level must be reached: strains of a fifth.
const INCREMENTS_MAX: u64 = 20_000;
/// Increments by which what is not isotropic is evened out, at most: loose grains rearrange for ever.
const EVENING_MAX: u64 = 400;

/// An assembly on its way.
pub(super) struct Compression<'a, S: Space> {
    pub rve: Rve<S>,
    deformation: S::Tensor,
    /// Cauchy, compression positive, Pa.
    pub stress: S::Tensor,
    drive: &'a Drive,
    scratch: &'a mut Scratch<S>,
}

impl<'a, S: Space> Compression<'a, S> {
    /// Of one that is where its F is I.
    pub fn of(rve: Rve<S>, drive: &'a Drive, scratch: &'a mut Scratch<S>) -> Result<Self, Error> {
        let mut state = Self { rve, deformation: S::identity(), stress: S::Tensor::zero(), drive, scratch };
        state.strain(&S::Tensor::zero())?;
        Ok(state)
    }

    /// A strain more, compression positive.
    fn strain(&mut self, more: &S::Tensor) -> Result<(), Error> {
        self.deformation = (S::identity() - *more) * self.deformation;
        let kirchhoff = self.rve.follow(&self.deformation, f64::NAN, self.drive, self.scratch)?.kirchhoff;
        self.stress = kirchhoff.tensor() * (-1.0 / S::determinant(&self.deformation));
        Ok(())
    }

    /// Along the path, Pa.
    fn borne(&self, path: Path) -> f64 {
        match path {
            Path::Isotropic => S::trace(&self.stress) / S::DIMENSION as f64,
            Path::Uniaxial { axis } => self.stress[axis * (S::DIMENSION + 1)],
        }
    }

    /// Until no component of the stress is farther than a tolerance, as a share of its mean, from the stress that is wanted.
    pub fn come_to(&mut self, wanted: &S::Tensor, tolerance: f64, increments_max: u64) -> Result<(), Error> {
        let pressure = S::trace(wanted) / S::DIMENSION as f64;
        let modulus = S::DIMENSION as f64 * self.rve.observe(self.scratch).modulus_most();
        for _ in 0..increments_max {
            let missing = *wanted - self.stress;
            let mut more = missing * (SHARE / modulus);
            let mut worst = 0.0_f64;
            for component in 0..S::Tensor::COMPONENTS {
                worst = larger(worst, missing[component].abs());
                more[component] = more[component].clamp(-INCREMENT, INCREMENT);
            }
            if worst <= tolerance * pressure {
                break;
            }
            self.strain(&more)?;
        }
        Ok(())
    }
}

/// One assembly for each of these stresses, Pa, ascending and none below that of the start; F = I in each.
pub fn levels<S: Space>(
    start: &Rve<S>,
    path: Path,
    stresses: &[f64],
    drive: &Drive,
    scratch: &mut Scratch<S>,
) -> Result<Vec<Rve<S>>, Error> {
    // Stiffer than it can be along any path, so that the first increment goes too far for none.
    let bound = S::DIMENSION as f64 * start.observe(scratch).modulus_most();
    let mut stiffness = Some(bound).filter(|bound| *bound > 0.0);
    let mut state = Compression::of(start.clone(), drive, scratch)?;
    let mut reached = Vec::with_capacity(stresses.len());
    for wanted in stresses {
        let mut increments = 0;
        while state.borne(path) < (1.0 - TOLERANCE) * wanted {
            let before = state.borne(path);
            let by_stiffness = stiffness.map_or(INCREMENT, |stiffness| SHARE * (wanted - before) / stiffness);
            let increment = by_stiffness.clamp(0.01 * INCREMENT, INCREMENT);
            state.strain(&compression::<S>(path, increment))?;
            let stress = state.borne(path);
            // One that rearranges may bear less for a moment.
            stiffness = Some((stress - before) / increment).filter(|stiffness| *stiffness > 0.0).or(stiffness);
            increments += 1;
            if increments > INCREMENTS_MAX {
                return Err(Error::Run(format!(
                    "a grain assembly bears {stress:.4e} Pa after a compression to {:.4} of its volume, and {wanted:.4e} Pa are wanted of it: its contacts are too soft, or its packing too loose",
                    S::determinant(&state.deformation)
                )));
            }
        }
        if path == Path::Isotropic && bound > 0.0 {
            state.come_to(&(S::identity() * *wanted), TOLERANCE, EVENING_MAX)?;
        }
        let mut level = state.rve.clone();
        level.begin_here();
        reached.push(level);
    }
    Ok(reached)
}

fn compression<S: Space>(path: Path, strain: f64) -> S::Tensor {
    let mut more = S::Tensor::zero();
    for along in 0..S::DIMENSION {
        if path == Path::Isotropic || path == (Path::Uniaxial { axis: along }) {
            more[along * (S::DIMENSION + 1)] = strain;
        }
    }
    more
}
