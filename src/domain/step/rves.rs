//! RVEs follow the deformation of their points, once the step of the continuum has given it.

use std::cmp::Reverse;

use rayon::prelude::*;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::numbers::Numbers;
use crate::base::space::Space;
use crate::base::symmetric::Symmetric;
use crate::domain::phases::Phase;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::law::material::{Followed, GrainMemory};
use crate::mpm::nonlocal::Places;
use crate::mpm::points::{Cold, Hot};
use crate::mpm::stress::StressModel;
use crate::mpm::volumetric::{STRAIN_FORGOTTEN, Volumetric};
use crate::rve::{Drive, Events, PointRve, Scratch};

/// A point with its RVE, and the deformation that this is to follow.
struct Pair<'a, S: Space> {
    id: PointId,
    hot: &'a mut Hot<S>,
    volumetric: &'a mut Volumetric,
    carried: &'a mut PointRve<S>,
    target: S::Tensor,
}

impl<S: Space> World<'_, S> {
    /// Every RVE to the deformation of its point, or of the material around it, whose stress is its own from then on. Collective.
    pub(crate) fn follow_by_grains(&mut self) -> Result<(), Error> {
        if self.settings.rves.is_none() {
            return Ok(());
        }
        let targets = self.targets_of_rves()?;
        let told = self.follow_to(targets);
        for told in transfer::agree(self.transport, told)? {
            told.tell(self.step);
        }
        if self.settings.nonlocal.is_some_and(|nonlocal| nonlocal.adjoint) {
            let own = self.continuum.points.hot.iter().map(Hot::kirchhoff).collect();
            let averaged = self.averaged_back(own);
            for (hot, stress) in self.continuum.points.hot.iter_mut().zip(&averaged) {
                hot.stress = S::Symmetric::of(stress);
            }
        }
        Ok(())
    }

    /// F of each point, or where strain is nonlocal that of its RVE after the mean increment of the points around it.
    fn targets_of_rves(&mut self) -> Result<Vec<S::Tensor>, Error> {
        let Some(nonlocal) = self.settings.nonlocal else {
            return Ok(self.continuum.points.hot.iter().map(|hot| hot.deformation).collect());
        };
        if nonlocal.places == Places::Current {
            self.find_neighbourhood()?;
        }
        let increment = |(hot, carried): (&Hot<S>, &PointRve<S>)| {
            let before = S::inverse(&carried.deformation).expect("what has been followed can be gone back");
            hot.deformation * before - S::identity()
        };
        let own = self.continuum.points.hot.iter().zip(&self.rves).map(increment).collect();
        let averaged = self.averaged_around(own);
        let target = |(mean, carried): (&S::Tensor, &PointRve<S>)| (S::identity() + *mean) * *carried.rve.deformation();
        Ok(averaged.iter().zip(&self.rves).map(target).collect())
    }

    /// What the run is told of, though it goes on. The costliest go first, so that no thread waits long for another; no RVE knows of
    /// another, and their order does not show.
    fn follow_to(&mut self, targets: Vec<S::Tensor>) -> Result<Vec<Told>, Error> {
        let timer = self.phases.start();
        let how = Following {
            drive: self.settings.rves.as_ref().expect("the material is grains").drive,
            duration: self.dt_of_continuum(),
            moduli: moduli_of(&*self.settings.material),
            averages: self.averages_volume(),
        };
        let points = &mut self.continuum.points;
        let rows = points.hot.iter_mut().zip(&mut points.volumetric).zip(&points.cold);
        let pair = |(((hot, volumetric), cold), (carried, target)): (((_, _), &Cold<S>), (_, _))| Pair {
            id: cold.id,
            hot,
            volumetric,
            carried,
            target,
        };
        let mut pairs: Vec<Pair<S>> = rows.zip(self.rves.iter_mut().zip(targets)).map(pair).collect();
        pairs.sort_unstable_by_key(|pair| (Reverse(pair.carried.cost), pair.id.0));
        let follow = |scratch: &mut Scratch<S>, pair: &mut Pair<S>| follow(pair, &how, scratch);
        let told: Result<Vec<Option<Told>>, Error> =
            pairs.par_iter_mut().with_max_len(1).map_init(Scratch::default, follow).collect();
        // What points bring to nodes is that of the stress before.
        points.scattered = [false; 2];
        self.phases.stop(Phase::Rves, timer);
        Ok(told?.into_iter().flatten().collect())
    }
}

/// How RVEs follow.
struct Following {
    drive: Drive,
    /// Of the step of the continuum, s.
    duration: f64,
    /// K and G of grains that all move with the mean field, Pa.
    moduli: [f64; 2],
    /// Whether volume strain is averaged over nodes.
    averages: bool,
}

fn moduli_of<S: Space>(material: &dyn StressModel<S>) -> [f64; 2] {
    let shear = material.shear_modulus();
    [material.p_wave_modulus() - 2.0 * (1.0 - 1.0 / S::DIMENSION as f64) * shear, shear]
}

/// The increment of one of them; what a run is told of, if there is something.
fn follow<S: Space>(
    Pair { id, hot, volumetric, carried, target }: &mut Pair<S>,
    how: &Following,
    scratch: &mut Scratch<S>,
) -> Result<Option<Told>, Error> {
    let steps = carried.rve.state().pair_steps;
    let place = std::array::from_fn(|axis| if axis < S::DIMENSION { hot.position[axis] } else { 0.0 });
    let answer = carried.rve.follow(target, how.duration, &how.drive, scratch).map_err(|error| {
        let [x, y, z]: [f64; 3] = place;
        Error::Run(format!("the RVE of point {} at ({x:.4e}, {y:.4e}, {z:.4e}) m: {error}", id.0))
    })?;
    carried.cost = carried.rve.state().pair_steps - steps;
    let words = &mut hot.memory.numbers_mut()[..GrainMemory::<S>::WIDTH];
    let mut memory = GrainMemory::<S>::default();
    memory.numbers_mut().copy_from_slice(words);
    let ([bulk, shear], way) = (how.moduli, [&carried.deformation, &hot.deformation]);
    let Followed { work, plastic_strain } = memory.follow(way, (answer.kirchhoff, carried.rve.opened()), shear);
    hot.plastic_work += work;
    if how.averages {
        // As laws say it of themselves within the pass that strains points.
        volumetric.strain = answer.kirchhoff.trace() / (S::DIMENSION as f64 * bulk) + memory.opened;
        volumetric.flowing = (plastic_strain / STRAIN_FORGOTTEN).min(1.0);
    }
    words.copy_from_slice(memory.numbers());
    carried.deformation = hot.deformation;
    hot.stress = answer.kirchhoff;
    let is_told = answer.events != Events::default();
    Ok(is_told.then_some(Told { point: *id, place, events: answer.events }))
}

/// What an RVE has come through, though the run goes on.
struct Told {
    point: PointId,
    place: [f64; 3],
    events: Events,
}

impl Told {
    fn tell(&self, step: u64) {
        let Self { point, place: [x, y, z], events } = self;
        let at = format!("step {step}: the RVE of point {} at ({x:.4e}, {y:.4e}, {z:.4e}) m", point.0);
        if events.loosened {
            tracing::info!("{at} has lost its last contact and bears nothing until it is as dense again");
        }
        if events.returned {
            tracing::info!("{at} is as dense again as when it lost its last contact");
        }
        if events.replicated > 0 {
            tracing::info!("{at} had become too thin for its contacts and was replicated, {} times", events.replicated);
        }
    }
}
