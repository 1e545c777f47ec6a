//! Stress of points whose strain is nonlocal: what they answer to is a mean around them, and so is their stress, but for what they bear for deviating from it
//! ([`crate::mpm::nonlocal`]).

use rayon::prelude::*;

use crate::base::error::Error;
use crate::base::lane::LANES;
use crate::base::space::Space;
use crate::base::symmetric::Symmetric;
use crate::domain::phases::Phase;
use crate::domain::step::rves::{of_point, place_of};
use crate::domain::world::World;
use crate::law::material::increment_of;
use crate::mpm::nonlocal::Places;
use crate::mpm::points::{Cold, Hot};
use crate::mpm::strain::Rates;
use crate::rve::Frame;

/// Octets whose laws are followed in one task.
const OCTETS_PER_TASK: usize = 8;

/// F of each point, and the mean of that around it.
pub(super) type Deformations<S> = [Vec<<S as Space>::Tensor>; 2];

/// What points go through in a step, F(n+1) F(n)^-1 - 1 of each, and its mean around each.
pub(super) struct Increments<S: Space> {
    pub own: Vec<S::Tensor>,
    pub mean: Vec<S::Tensor>,
}

impl<S: Space> Increments<S> {
    /// Strain of a point beyond that of the mean around it.
    fn deviation(&self, row: usize) -> S::Symmetric {
        let strain = |more: &S::Tensor| increment_of::<S>([&S::identity(), &(S::identity() + *more)]);
        strain(&self.own[row]) - strain(&self.mean[row])
    }
}

impl<S: Space> World<'_, S> {
    /// Whether laws answer to a mean strain; RVEs see to it by themselves.
    pub(super) fn has_nonlocal_law(&self) -> bool {
        let has_law = self.has_elements() || self.has_points();
        has_law && self.settings.nonlocal.is_some() && self.settings.rves.is_none()
    }

    /// The points around each of where they are now, if these are asked for. Collective.
    pub(super) fn find_neighbourhood_of_now(&mut self) -> Result<(), Error> {
        match self.settings.nonlocal.is_some_and(|nonlocal| nonlocal.places == Places::Current) {
            true => self.find_neighbourhood(),
            false => Ok(()),
        }
    }

    /// What `moves` strains points by, and laws answer to the mean of that. Collective.
    pub(super) fn strain_by_means(&mut self, moves: impl FnOnce(&mut Self)) -> Result<(), Error> {
        let before = self.overlay_before()?;
        let from: Vec<S::Tensor> = self.continuum.points.hot.iter().map(|hot| hot.deformation).collect();
        moves(self);
        self.refuse_inside_out()?;
        self.find_neighbourhood_of_now()?;
        let increment = |(hot, from): (&Hot<S>, &S::Tensor)| {
            let back = S::inverse(from).expect("what has been followed can be gone back");
            hot.deformation * back - S::identity()
        };
        let own: Vec<S::Tensor> = self.continuum.points.hot.iter().zip(&from).map(increment).collect();
        let to: Vec<S::Tensor> = self.continuum.points.hot.iter().map(|hot| hot.deformation).collect();
        let (mean, reached) = match self.has_overlay() {
            true => {
                let [mean, of_to] = self.averaged_around([&own, &to]);
                (mean, Some([to, of_to]))
            }
            false => {
                let [mean] = self.averaged_around([&own]);
                (mean, None)
            }
        };
        self.follow_by_laws(&mean);
        self.average_stress(&before, &Increments { own, mean }, reached)
    }

    /// Whether points bear something for their deviation from the mean around them.
    fn has_overlay(&self) -> bool {
        self.settings.nonlocal.is_some_and(|nonlocal| nonlocal.adjoint)
    }

    fn follow_by_laws(&mut self, increments: &[S::Tensor]) {
        let timer = self.phases.start();
        let dt = self.dt_of_continuum();
        let (material, instructions) = (&self.settings.material, self.assembly.contacts.instructions());
        let together = LANES * OCTETS_PER_TASK;
        let points = self.continuum.points.hot.par_chunks_mut(together);
        points.zip(increments.par_chunks(together)).for_each(|(points, increments)| {
            let rates: Vec<Rates> =
                increments.chunks(LANES).map(|increments| Rates::of::<S>(increments, 1.0 / dt)).collect();
            material.strain((&rates, dt, instructions), points);
        });
        self.phases.stop(Phase::Gather, timer);
    }

    /// The overlay before an increment: that of the end of the last one, where it has been kept. Collective.
    pub(super) fn overlay_before(&mut self) -> Result<Vec<S::Symmetric>, Error> {
        match self.neighbourhood.overlay.take() {
            Some(kept) => Ok(kept),
            None if self.has_overlay() => {
                let reached = self.deformations();
                self.overlay(&reached)
            }
            None => Ok(Vec::new()),
        }
    }

    /// What each point has come to, and the mean around it. The mean has no memory of its own but that of an RVE which goes through all of it. Collective.
    fn deformations(&mut self) -> Deformations<S> {
        let own: Vec<S::Tensor> = match &self.settings.rves {
            Some(_) => self.rves.iter().map(|carried| carried.deformation).collect(),
            None => self.continuum.points.hot.iter().map(|hot| hot.deformation).collect(),
        };
        match &self.settings.rves {
            Some(material) if material.frame == Frame::Full => {
                [own, self.rves.iter().map(|carried| *carried.rve.deformation()).collect()]
            }
            _ => {
                let [mean] = self.averaged_around([&own]);
                [own, mean]
            }
        }
    }

    /// What each point bears for its deviation from the mean around it, Pa. Collective.
    fn overlay(&mut self, [own, mean]: &Deformations<S>) -> Result<Vec<S::Symmetric>, Error> {
        let how = self.settings.nonlocal.expect("a mean is asked for where strain is nonlocal");
        let timer = self.phases.start();
        let (material, points) = (&self.settings.material, &self.continuum.points);
        let borne = |(row, (hot, cold)): (usize, (&Hot<S>, &Cold<S>))| {
            let stress = S::Symmetric::of(&material.stress(&hot.memory));
            let overlay = how.overlay_stress::<S>([&own[row], &mean[row]], &stress, material.shear_modulus());
            overlay.ok_or_else(|| {
                let words = format!(
                    "{}: the mean of F around it has no inverse, for material within nonlocal.radius turns in too many ways; begin anew with a smaller one",
                    of_point(cold.id, &place_of(hot))
                );
                (cold.id, Error::Run(words))
            })
        };
        let rows = points.hot.iter().zip(&points.cold).enumerate();
        let mut failed = None;
        let mut all = Vec::with_capacity(points.hot.len());
        for outcome in rows.map(borne) {
            match outcome {
                Ok(stress) => all.push(stress),
                Err(failure) => failed = failed.into_iter().chain([failure]).min_by_key(|(id, _)| *id),
            }
        }
        self.phases.stop(Phase::Gather, timer);
        self.first_failure(failed.map_or(Ok(all), Err))
    }

    /// Stress of points from that of the means around them and from what they bear for deviations, which was `before` the increment; what deformation has
    /// `reached` where that is known already. Collective.
    pub(super) fn average_stress(
        &mut self,
        before: &[S::Symmetric],
        gone: &Increments<S>,
        reached: Option<Deformations<S>>,
    ) -> Result<(), Error> {
        if !self.has_overlay() {
            return Ok(());
        }
        let reached = reached.unwrap_or_else(|| self.deformations());
        let after = self.overlay(&reached)?;
        let hot = &mut self.continuum.points.hot;
        for (row, hot) in hot.iter_mut().enumerate() {
            hot.plastic_work += 0.5 * (before[row] + after[row]).contract(&gone.deviation(row));
        }
        let own: Vec<S::Tensor> =
            hot.iter().zip(&after).map(|(hot, overlay)| (hot.stress - *overlay).tensor()).collect();
        let [averaged] = self.averaged_around([&own]);
        for (hot, (stress, overlay)) in self.continuum.points.hot.iter_mut().zip(averaged.iter().zip(&after)) {
            hot.stress = S::Symmetric::of(stress) + *overlay;
        }
        self.neighbourhood.overlay = Some(after);
        Ok(())
    }
}
