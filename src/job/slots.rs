//! What jobs of all forms are made of, so that nobody outside asks for the form to get at it: grains, a continuum, bodies, plates, what
//! presses and how fast it goes.

use std::borrow::Cow;

use super::assembly::{Body, Read, Source};
use super::mpm::Region;
use super::stable::Bound;
use super::{Assembly, Job, Loading, Method, Mpm, Scenario, derived, figures, mpm};
use crate::base::keys::Form;

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
            Self::Mpm(job) => match (&job.grains, &job.mesh) {
                (Some(granular), _) => granular.method,
                (None, Some(_)) => Method::Fem,
                (None, None) => Method::Mpm,
            },
        }
    }

    /// Whether it has regions of a continuum that begin looser.
    pub fn has_weak_regions(&self) -> bool {
        matches!(self, Self::Shear(scenario) if !scenario.continuum.weak.is_empty())
    }

    /// Whether all of the material is grains at the start of the run.
    pub fn begins_as_grains(&self) -> bool {
        match self {
            Self::Shear(scenario) => scenario.begins_as_grains(),
            Self::Assembly(_) => true,
            Self::Mpm(job) => job.grains.as_ref().is_some_and(|granular| granular.begins_as_grains()),
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

    /// The mesh that the job reads.
    pub fn mesh_file(&self) -> Option<&mpm::MeshFile> {
        self.as_mpm()?.mesh.as_ref()?.file.as_ref()
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

    /// The key of a job that says that stress.
    pub fn key_of_pressure(&self) -> &'static str {
        match self {
            Self::Shear(_) => "loading.stress_normal",
            Self::Assembly(assembly) if assembly.cell.servo.is_some() => "cell.stress_normal",
            Self::Assembly(_) | Self::Mpm(_) => "packing.stress",
        }
    }

    /// Rates that the job strains its grains at, 1/s, and what each is of.
    pub fn rates(&self) -> Vec<(f64, &'static str)> {
        match self {
            Self::Shear(scenario) => vec![
                (derived::shear_rate_mean(scenario), "the whole height shearing alike"),
                (derived::shear_rate_band(scenario), "a band of ten diameters taking it all"),
            ],
            Self::Assembly(assembly) => Some(figures::rate_max(assembly))
                .filter(|rate| *rate > 0.0)
                .map(|rate| (rate, "the largest of the cell"))
                .into_iter()
                .collect(),
            Self::Mpm(_) => Vec::new(),
        }
    }

    /// What these are proportional to: its key, value and unit.
    pub fn speed(&self) -> Option<(&'static str, f64, &'static str)> {
        match self {
            Self::Shear(scenario) => Some(("loading.speed", scenario.loading.speed, "m/s")),
            Self::Assembly(assembly) => Some(("cell.velocity_gradient", figures::rate_max(assembly), "1/s")),
            Self::Mpm(_) => None,
        }
    }

    /// What plates do that the material lies between, in place of faces and bodies that the job names.
    pub fn plates(&self) -> Option<&Loading> {
        if let Self::Shear(scenario) = self { Some(&scenario.loading) } else { None }
    }

    /// Where the job says that material is; between plates it is everywhere.
    pub fn regions(&self) -> &[Region] {
        if let Self::Mpm(job) = self { &job.regions } else { &[] }
    }

    /// Whether the job says what its continuum is made of: between plates one that nothing moves is asleep.
    pub fn has_material(&self) -> bool {
        match self {
            Self::Shear(scenario) => scenario.method.has_points(),
            Self::Assembly(_) => false,
            Self::Mpm(_) => true,
        }
    }

    /// Whether the solid volume fraction of the start is that of a packing which is not made yet.
    pub fn is_told_by_packing(&self) -> bool {
        match self {
            Self::Shear(scenario) => scenario.material.law.fraction().is_none(),
            Self::Assembly(_) => false,
            Self::Mpm(job) => job.is_told_by_packing(),
        }
    }

    /// The keys of `[packing]`, where grains are made.
    pub fn keys_of_packing(&self, form: &mut dyn Form) {
        match (self, self.grains().map(|grains| grains.into_owned().source)) {
            (Self::Shear(scenario), _) => scenario.packing.clone().keys(form),
            (_, Some(Source::Packed(mut packed))) => packed.keys(form),
            _ => {}
        }
    }

    /// Whether an account of work and energy is kept.
    pub fn keeps_account(&self) -> bool {
        match self {
            Self::Shear(scenario) => scenario.ledger,
            Self::Assembly(assembly) => assembly.ledger,
            Self::Mpm(job) => job.ledger,
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
