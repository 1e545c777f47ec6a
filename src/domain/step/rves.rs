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
use crate::law::material::GrainMemory;
use crate::mpm::nonlocal::Places;
use crate::mpm::points::{Cold, Hot};
use crate::rve::{Drive, Events, PointRve, Scratch};

/// A point with its RVE, and the deformation that this is to follow.
struct Pair<'a, S: Space> {
    id: PointId,
    hot: &'a mut Hot<S>,
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
        let duration = self.dt_of_continuum();
        let drive = self.settings.rves.as_ref().expect("the material is grains").drive;
        let points = &mut self.continuum.points;
        let rows = points.hot.iter_mut().zip(&points.cold).zip(self.rves.iter_mut().zip(targets));
        let pair =
            |((hot, cold), (carried, target)): ((_, &Cold<S>), (_, _))| Pair { id: cold.id, hot, carried, target };
        let mut pairs: Vec<Pair<S>> = rows.map(pair).collect();
        pairs.sort_unstable_by_key(|pair| (Reverse(pair.carried.cost), pair.id.0));
        let follow = |scratch: &mut Scratch<S>, pair: &mut Pair<S>| follow(pair, &drive, duration, scratch);
        let told: Result<Vec<Option<Told>>, Error> =
            pairs.par_iter_mut().with_max_len(1).map_init(Scratch::default, follow).collect();
        // What points bring to nodes is that of the stress before.
        points.scattered = [false; 2];
        self.phases.stop(Phase::Rves, timer);
        Ok(told?.into_iter().flatten().collect())
    }
}

/// The increment of one of them; what a run is told of, if there is something.
fn follow<S: Space>(
    Pair { id, hot, carried, target }: &mut Pair<S>,
    drive: &Drive,
    duration: f64,
    scratch: &mut Scratch<S>,
) -> Result<Option<Told>, Error> {
    let steps = carried.rve.state().pair_steps;
    let place = std::array::from_fn(|axis| if axis < S::DIMENSION { hot.position[axis] } else { 0.0 });
    let answer = carried.rve.follow(target, duration, drive, scratch).map_err(|error| {
        let [x, y, z]: [f64; 3] = place;
        Error::Run(format!("the RVE of point {} at ({x:.4e}, {y:.4e}, {z:.4e}) m: {error}", id.0))
    })?;
    carried.cost = carried.rve.state().pair_steps - steps;
    let words = &mut hot.memory.numbers_mut()[..GrainMemory::<S>::WIDTH];
    let mut memory = GrainMemory::<S>::default();
    memory.numbers_mut().copy_from_slice(words);
    hot.plastic_work += memory.follow([&carried.deformation, &hot.deformation], answer.kirchhoff);
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
