//! The same assembly under several stresses: states along one path of compression, so that points at any depth start from what one packing
//! becomes there.

use crate::base::error::Error;
use crate::base::space::Space;
use crate::base::symmetric::Symmetric;
use crate::rve::drive::Drive;
use crate::rve::step::Scratch;
use crate::rve::volume_element::Rve;

/// How an assembly is brought to a stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// All axes alike; the stress is the mean one.
    Isotropic,
    /// Along one axis, the others kept (K0); the stress is that along it.
    Uniaxial { axis: usize },
}

/// Largest increment of strain.
const INCREMENT: f64 = 1e-5;
/// Share of what is missing that an increment aims at.
const SHARE: f64 = 0.8;
/// How near a level is come to.
const TOLERANCE: f64 = 1e-3;
/// Increments in which a level must be reached: strains of a fifth.
const INCREMENTS_MAX: u64 = 20_000;

/// One assembly for each of these stresses, Pa, ascending and none below that of the start; F = I in each.
pub fn levels<S: Space>(
    start: &Rve<S>,
    path: Path,
    stresses: &[f64],
    drive: &Drive,
    scratch: &mut Scratch<S>,
) -> Result<Vec<Rve<S>>, Error> {
    let mut rve = start.clone();
    let borne = |rve: &mut Rve<S>, deformation: &S::Tensor, scratch: &mut Scratch<S>| -> Result<f64, Error> {
        let kirchhoff = rve.follow(deformation, f64::NAN, drive, scratch)?.kirchhoff;
        let stress = kirchhoff.tensor() * (-1.0 / S::determinant(deformation));
        Ok(match path {
            Path::Isotropic => S::trace(&stress) / S::DIMENSION as f64,
            Path::Uniaxial { axis } => stress[axis * S::DIMENSION + axis],
        })
    };
    // Stiffer than it can be along any path, so that the first increment goes too far for none.
    let bound = S::DIMENSION as f64 * start.observe(scratch).modulus_most();
    let (mut strain, mut stiffness) = (0.0, Some(bound).filter(|bound| *bound > 0.0));
    let mut deformation = S::identity();
    let mut stress = borne(&mut rve, &deformation, scratch)?;
    let mut reached = Vec::with_capacity(stresses.len());
    for wanted in stresses {
        let mut increments = 0;
        while stress < (1.0 - TOLERANCE) * wanted {
            let by_stiffness = stiffness.map_or(INCREMENT, |stiffness| SHARE * (wanted - stress) / stiffness);
            let increment = by_stiffness.clamp(0.01 * INCREMENT, INCREMENT);
            strain += increment;
            deformation = compressed::<S>(path, strain);
            let before = std::mem::replace(&mut stress, borne(&mut rve, &deformation, scratch)?);
            // One that rearranges may bear less for a moment.
            stiffness = Some((stress - before) / increment).filter(|stiffness| *stiffness > 0.0).or(stiffness);
            increments += 1;
            if increments > INCREMENTS_MAX {
                return Err(Error::Run(format!(
                    "a grain assembly bears {stress:.4e} Pa after a compression by {strain:.3}, and {wanted:.4e} Pa are wanted of it: its contacts are too soft, or its packing too loose"
                )));
            }
        }
        let mut level = rve.clone();
        level.begin_here();
        reached.push(level);
    }
    Ok(reached)
}

fn compressed<S: Space>(path: Path, strain: f64) -> S::Tensor {
    let mut deformation = S::identity();
    for along in 0..S::DIMENSION {
        if path == Path::Isotropic || path == (Path::Uniaxial { axis: along }) {
            deformation[along * S::DIMENSION + along] = 1.0 - strain;
        }
    }
    deformation
}
