//! What jobs of different kinds have in common, so that nobody outside asks for the kind to get at it.

use std::borrow::Cow;

use super::assembly::{Body, Read, Source};
use super::stable::Bound;
use super::{Assembly, Job, Method, Mpm, Scenario, derived, figures, mpm};

impl Job {
    /// The job of planar shear between plates, if it is one.
    pub fn as_shear(&self) -> Option<&Scenario> {
        if let Self::Shear(scenario) = self { Some(scenario) } else { None }
    }

    /// The assembly of grains in a cell, if it is one.
    pub fn as_assembly(&self) -> Option<&Assembly> {
        if let Self::Assembly(assembly) = self { Some(assembly) } else { None }
    }

    /// The job on a grid, if it is one.
    pub fn as_mpm(&self) -> Option<&Mpm> {
        if let Self::Mpm(job) = self { Some(job) } else { None }
    }

    /// What moves in the run.
    pub fn method(&self) -> Method {
        match self {
            Self::Shear(scenario) => scenario.method,
            Self::Assembly(_) => Method::Dem,
            Self::Mpm(job) => job.grains.as_ref().map_or(Method::Mpm, |granular| granular.method),
        }
    }

    /// Grains with their contacts and where they come from: those of the cell, of the specimen between plates, or of the piece of
    /// packing that a continuum stands for.
    pub fn grains(&self) -> Option<Cow<'_, Assembly>> {
        match self {
            Self::Shear(scenario) => {
                let mut grains = scenario.grains_of_specimen();
                if let Some(file) = &scenario.grains.file {
                    grains.source = Source::File(Read { grains: file.clone(), contacts: None });
                }
                Some(Cow::Owned(grains))
            }
            Self::Assembly(assembly) => Some(Cow::Borrowed(assembly)),
            Self::Mpm(job) => job.grains.as_ref().map(|granular| Cow::Borrowed(&granular.piece)),
        }
    }

    /// Whether grains move at any time: in the run, or to make the packing that a continuum starts from.
    pub fn moves_grains(&self) -> bool {
        self.as_shear().map_or(self.grains().is_some(), Scenario::moves_grains)
    }

    /// The continuum on its grid; that between plates as a job on a grid would have it.
    pub fn continuum(&self) -> Option<Cow<'_, Mpm>> {
        match self {
            Self::Shear(scenario) => Some(Cow::Owned(scenario.on_grid())),
            Self::Assembly(_) => None,
            Self::Mpm(job) => Some(Cow::Borrowed(job)),
        }
    }

    /// The rigid bodies that the job names.
    pub fn bodies(&self) -> Vec<&Body> {
        match self {
            Self::Shear(_) => Vec::new(),
            Self::Assembly(assembly) => assembly.bodies.iter().collect(),
            Self::Mpm(job) => job.bodies.iter().map(|rigid| &rigid.body).collect(),
        }
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            Self::Shear(_) => 2,
            Self::Assembly(assembly) => assembly.cell.dimension,
            Self::Mpm(job) => job.grid.dimension,
        }
    }

    /// Simulated time at which the run ends, s.
    pub fn end(&self) -> f64 {
        match self {
            Self::Shear(scenario) => derived::duration(scenario),
            Self::Assembly(assembly) => assembly.end,
            Self::Mpm(job) => job.end,
        }
    }

    /// Mean stress that grains are held at or made under, Pa, compression positive.
    pub fn pressure(&self) -> Option<f64> {
        match self {
            Self::Shear(scenario) => Some(scenario.loading.stress_normal),
            _ => figures::pressure(self.grains()?.as_ref()),
        }
    }

    /// What bounds the step of the continuum, of which [`Mpm::step_of_continuum`] is one.
    pub fn bounds_of_continuum(&self) -> Vec<Bound> {
        match self {
            Self::Shear(scenario) if scenario.method.has_points() => mpm::figures::bounds(&scenario.on_grid()),
            Self::Shear(_) | Self::Assembly(_) => Vec::new(),
            Self::Mpm(job) => mpm::figures::bounds(job),
        }
    }
}
