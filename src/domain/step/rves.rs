//! RVEs follow the deformation of their points, once the step of the continuum has given it.

use std::cmp::Reverse;

use rayon::prelude::*;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::numbers::Numbers;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::Space;
use crate::base::symmetric::Symmetric;
use crate::domain::phases::Phase;
use crate::domain::step::nonlocal::Increments;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::law::material::{Followed, GrainMemory};
use crate::mpm::points::{Cold, Hot};
use crate::mpm::stress::StressModel;
use crate::mpm::volumetric::{STRAIN_FORGOTTEN, Volumetric};
use crate::rve::renew::{is_drawn_out, renewed};
use crate::rve::{Drive, Events, Frame, PointRve, Scratch};

/// What an RVE has come through, though the run goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RveEvent {
    /// Whose RVE it is.
    pub point: PointId,
    /// Of the point, m.
    pub place: [f64; 3],
    /// Within one step of the continuum; at least one of them has come about.
    pub events: Events,
    /// Of the stress of one that was renewed, as a share of it.
    pub jump: f64,
}

impl Record for RveEvent {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        let Self { point, place, events, jump } = self;
        visitor.u64("point", &mut point.0);
        visitor.f64s("place", place);
        visitor.f64s("jump", std::slice::from_mut(jump));
        let mut flags = [events.loosened, events.returned, events.renewed].map(u8::from);
        visitor.u8("loosened", &mut flags[0]);
        visitor.u8("returned", &mut flags[1]);
        visitor.u8("renewed", &mut flags[2]);
        [events.loosened, events.returned, events.renewed] = flags.map(|flag| flag > 0);
        let mut replicated = u64::from(events.replicated);
        visitor.u64("replicated", &mut replicated);
        events.replicated = replicated as u32;
    }
}

impl Cargo for RveEvent {
    fn blank() -> Self {
        Self::default()
    }
}

/// A point with its RVE, and the deformation that this is to follow.
struct Pair<'a, S: Space> {
    id: PointId,
    hot: &'a mut Hot<S>,
    volumetric: &'a mut Volumetric,
    carried: &'a mut PointRve<S>,
    target: S::Tensor,
}

/// A point whose RVE could not follow, and why.
type Failed = (PointId, Error);

impl<S: Space> World<'_, S> {
    /// Every RVE to the deformation of its point, or of the material around it, whose stress is its own from then on. Collective.
    pub(crate) fn follow_by_grains(&mut self) -> Result<(), Error> {
        if self.settings.rves.is_none() {
            return Ok(());
        }
        let before = self.overlay_before()?;
        let (targets, gone) = self.targets_of_rves()?;
        let told = self.follow_to(targets);
        let told = self.first_failure(told)?;
        self.gather_events(told)?;
        self.average_stress(&before, &gone, None)
    }

    /// Of failures on any ranks that of the point with the lowest id, whatever the ranks are.
    pub(super) fn first_failure<T>(&self, outcome: Result<T, Failed>) -> Result<T, Error> {
        let mine = outcome.as_ref().err().map_or(i64::MAX, |(id, _)| id.0 as i64);
        let mut first = [-mine];
        self.transport.max_integer(&mut first);
        let outcome = match outcome {
            Ok(told) => Ok(Some(told)),
            Err((_, error)) if -first[0] == mine => Err(error),
            Err(_) => Ok(None),
        };
        Ok(transfer::agree(self.transport, outcome)?.expect("a failure is the first one, or another rank's is"))
    }

    /// What all RVEs have come through in this step goes to rank 0, by point.
    fn gather_events(&mut self, told: Vec<RveEvent>) -> Result<(), Error> {
        let mut count = [told.len() as i64];
        self.transport.sum(&mut count);
        if count[0] > 0 {
            let mut all = transfer::gather(self.transport, told)?.unwrap_or_default();
            all.sort_unstable_by_key(|event| event.point);
            self.rve_events.get_or_insert_default().extend(all);
        }
        Ok(())
    }

    /// A mean over points hides one that is turned inside out. Collective.
    pub(super) fn refuse_inside_out(&self) -> Result<(), Error> {
        let points = &self.continuum.points;
        let bad = |(hot, _): &(&Hot<S>, &Cold<S>)| !matches!(hot.volume_ratio(), ratio if ratio > 0.0);
        let worst = points.hot.iter().zip(&points.cold).filter(bad).min_by_key(|(_, cold)| cold.id);
        let outcome = worst.map_or(Ok(()), |(hot, cold)| {
            let ratio = hot.volume_ratio();
            let words = format!(
                "{}: det F = {ratio:.3e}, the material is turned inside out there; take a shorter time.step or larger cells, and go on from an earlier checkpoint",
                of_point(cold.id, &place_of(hot))
            );
            Err((cold.id, Error::Run(words)))
        });
        self.first_failure(outcome)
    }

    /// F of each point, or where strain is nonlocal that of its RVE after the mean increment of the points around it; and what they go through, where it is asked
    /// for. Collective.
    fn targets_of_rves(&mut self) -> Result<(Vec<S::Tensor>, Increments<S>), Error> {
        let frame = self.settings.rves.as_ref().map_or(Frame::Full, |material| material.frame);
        if self.settings.nonlocal.is_none() && frame == Frame::Full {
            let targets = self.continuum.points.hot.iter().map(|hot| hot.deformation).collect();
            return Ok((targets, Increments { own: Vec::new(), mean: Vec::new() }));
        }
        self.refuse_inside_out()?;
        self.find_neighbourhood_of_now()?;
        let increment = |(hot, carried): (&Hot<S>, &PointRve<S>)| {
            let before = S::inverse(&carried.deformation).expect("what has been followed can be gone back");
            hot.deformation * before - S::identity()
        };
        let own: Vec<S::Tensor> = self.continuum.points.hot.iter().zip(&self.rves).map(increment).collect();
        let mean = match self.settings.nonlocal.map(|nonlocal| nonlocal.lag) {
            None => own.clone(),
            Some(0) => {
                let [mean] = self.averaged_around([&own]);
                mean
            }
            Some(_) => self.averaged_with_lag(&own),
        };
        let target = |(mean, (hot, carried)): (&S::Tensor, (&Hot<S>, &PointRve<S>))| {
            frame.target::<S>(mean, [&carried.deformation, &hot.deformation], carried.rve.deformation())
        };
        let targets = mean.iter().zip(self.continuum.points.hot.iter().zip(&self.rves)).map(target).collect();
        Ok((targets, Increments { own, mean }))
    }

    /// Means of the increments of the step before, but for the point's own.
    fn averaged_with_lag(&mut self, own: &[S::Tensor]) -> Vec<S::Tensor> {
        let before: Vec<S::Tensor> = self.rves.iter().map(|carried| carried.increment).collect();
        let [mut averaged] = self.averaged_around([&before]);
        for (row, (mean, carried)) in averaged.iter_mut().zip(&mut self.rves).enumerate() {
            *mean += (own[row] - carried.increment) * self.neighbourhood.weights.own(row);
            carried.increment = own[row];
        }
        averaged
    }

    /// What the run is told of, though it goes on. The costliest go first, so that no thread waits long for another; no RVE knows of
    /// another, and their order does not show.
    fn follow_to(&mut self, targets: Vec<S::Tensor>) -> Result<Vec<RveEvent>, Failed> {
        let timer = self.phases.start();
        let material = self.settings.rves.as_ref().expect("the material is grains");
        let how = Following {
            drive: material.drive,
            frame: material.frame,
            duration: self.dt_of_continuum(),
            moduli: moduli_of(&*self.settings.material),
            averages: self.averages_volume(),
        };
        let (points, scratches) = (&mut self.continuum.points, &self.scratches);
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
        let follow = |pair: &mut Pair<S>| scratches.with(|scratch| follow(pair, &how, scratch));
        let told: Vec<Result<Option<RveEvent>, Failed>> = pairs.par_iter_mut().with_max_len(1).map(follow).collect();
        // What points bring to nodes is that of the stress before.
        points.scattered = [false; 2];
        self.phases.stop(Phase::Rves, timer);
        let (told, failed): (Vec<_>, Vec<_>) = told.into_iter().partition(Result::is_ok);
        match failed.into_iter().filter_map(Result::err).min_by_key(|(id, _)| *id) {
            Some(first) => Err(first),
            None => Ok(told.into_iter().filter_map(Result::ok).flatten().collect()),
        }
    }
}

pub(super) fn place_of<S: Space>(hot: &Hot<S>) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < S::DIMENSION { hot.position[axis] } else { 0.0 })
}

pub(super) fn of_point(id: PointId, [x, y, z]: &[f64; 3]) -> String {
    format!("point {} at ({x:.4e}, {y:.4e}, {z:.4e}) m", id.0)
}

/// How RVEs follow.
struct Following {
    drive: Drive,
    frame: Frame,
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
) -> Result<Option<RveEvent>, Failed> {
    let (before, steps) = (*carried.rve.deformation(), carried.rve.state().pair_steps);
    let place = place_of(hot);
    let answer = carried.rve.follow(target, how.duration, &how.drive, scratch);
    let answer = answer.map_err(|error| (*id, Error::Run(format!("the RVE of {}: {error}", of_point(*id, &place)))))?;
    carried.cost = carried.rve.state().pair_steps - steps;
    let words = &mut hot.memory.numbers_mut()[..GrainMemory::<S>::WIDTH];
    let mut memory = GrainMemory::<S>::default();
    memory.numbers_mut().copy_from_slice(words);
    let ([bulk, shear], ways) = (how.moduli, [[&before, &*target], [&carried.deformation, &hot.deformation]]);
    let Followed { work, plastic_strain } = memory.follow(ways, (answer.kirchhoff, carried.rve.opened()), shear);
    hot.plastic_work += work;
    if how.averages {
        // As laws say it of themselves within the pass that strains points.
        volumetric.strain = answer.kirchhoff.trace() / (S::DIMENSION as f64 * bulk) + memory.opened;
        volumetric.flowing = (plastic_strain / STRAIN_FORGOTTEN).min(1.0);
    }
    words.copy_from_slice(memory.numbers());
    carried.deformation = hot.deformation;
    hot.stress = how.frame.stress::<S>(answer.kirchhoff, &hot.deformation);
    let (mut events, mut jump) = (answer.events, 0.0);
    if is_drawn_out(&carried.rve) {
        let fresh = renewed(&carried.rve, &how.drive, scratch);
        let fresh =
            fresh.map_err(|error| (*id, Error::Run(format!("the RVE of {}: {error}", of_point(*id, &place)))))?;
        if let Some((rve, by)) = fresh {
            (carried.rve, jump, events.renewed) = (rve, by, true);
        }
    }
    let is_told = events != Events::default();
    Ok(is_told.then_some(RveEvent { point: *id, place, events, jump }))
}
