//! What the sections of the page are told of: the parts that a job of any kind may have, with what follows from them.

use std::borrow::Cow;

use crate::analysis::strength::{StrengthComparison, compared};
use crate::base::error::Error;
use crate::bench::gauge;
use crate::job::derived::{Moduli, moduli_affine};
use crate::job::mpm::forecast::{Forecast, UnitCosts, fraction_of_packing};
use crate::job::mpm::{Granular, Mpm};
use crate::job::stable::Bound;
use crate::job::{Assembly, Job, Method, figures};
use crate::prepare::grain_file;

pub struct Slots<'j> {
    pub job: &'j Job,
    pub grains: Option<Cow<'j, Assembly>>,
    pub continuum: Option<Cow<'j, Mpm>>,
    /// Of the job's step; none of grains that never move.
    pub bounds_of_grains: Vec<Bound>,
    /// Of the continuum's own step.
    pub bounds_of_continuum: Vec<Bound>,
    pub forecast: Option<Forecast>,
    /// Why nothing could be measured for it, if so.
    pub unmeasured: Option<String>,
    /// Of a hybrid, its continuum beside its grains, or why these cannot be tested.
    pub strength: Option<Result<StrengthComparison, String>>,
}

impl<'j> Slots<'j> {
    /// Reads the file of grains, if there is one, and measures what steps and outputs cost here; `tests_grains` of a hybrid as well.
    pub fn of(job: &'j Job, tests_grains: bool) -> Result<Self, Error> {
        let grains = job.grains();
        // Those of RVEs have steps of their own.
        let moving = grains.as_deref().filter(|_| job.moves_grains() && !job.method().has_rves());
        let bounds_of_grains = moving.map(grain_file::bounds).transpose()?.unwrap_or_default();
        // A forecast is no reason to refuse a job.
        let (costs, unmeasured) = match gauge::costs(job) {
            Ok(costs) => (costs, None),
            Err(error) => (UnitCosts::assumed(job), Some(error.to_string())),
        };
        let tested = (tests_grains && job.method() == Method::Hybrid).then(|| compared(job).transpose()).flatten();
        Ok(Self {
            job,
            strength: tested.map(|found| found.map_err(|error| error.to_string())),
            continuum: job.continuum(),
            bounds_of_grains,
            bounds_of_continuum: job.bounds_of_continuum(),
            forecast: Forecast::of(job, &costs),
            unmeasured,
            grains,
        })
    }

    /// The continuum whose material is looked at: between plates a method without points does not.
    pub fn material(&self) -> Option<&Mpm> {
        self.continuum.as_deref().filter(|_| self.job.has_material())
    }

    /// The grains that take the place of points.
    pub fn coupled(&self) -> Option<&Granular> {
        let granular = self.continuum.as_deref()?.grains.as_deref()?;
        (granular.method == Method::Hybrid).then_some(granular)
    }

    /// m/s2, and the time over which it rises, s.
    pub fn gravity(&self) -> ([f64; 3], f64) {
        match (&self.continuum, &self.grains) {
            (Some(on), _) => (on.gravity.acceleration, on.gravity.ramp),
            (None, grains) => (grains.as_ref().map_or([0.0; 3], |grains| grains.gravity), 0.0),
        }
    }

    /// What the contacts of grains give beside a continuum in the plane, at most.
    pub fn moduli_of_contacts(&self) -> Option<Moduli> {
        let (on, grains) = (self.continuum.as_deref()?, self.grains.as_deref()?);
        let springs = figures::springs_mean(grains);
        let is_wanted = on.grid.dimension == 2 && self.job.method().has_grains();
        is_wanted.then(|| moduli_affine(&springs, fraction_of_packing(on), on.grid.depth))
    }

    /// Inertial numbers, with what each one's rate is.
    pub fn inertial_numbers(&self) -> Vec<(f64, &'static str)> {
        let (Some(grains), Some(pressure)) = (self.grains.as_deref(), self.job.pressure()) else { return Vec::new() };
        let number = |(rate, of)| (figures::inertial_number(grains, rate, pressure), of);
        self.job.rates().into_iter().map(number).collect()
    }

    pub fn stiffness_number(&self) -> Option<f64> {
        let grains = self.grains.as_deref().filter(|_| self.job.method().has_grains())?;
        figures::stiffness_number(grains, self.job.pressure()?)
    }
}
