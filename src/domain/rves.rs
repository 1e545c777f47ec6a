//! RVEs beside the points of this rank: they come, stay and leave with them.

use std::collections::BTreeMap;

use rayon::prelude::*;
use scree_partition::{ExactSum, ParcelError, Reader, Writer};

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::record::Cargo;
use crate::base::rows::Moved;
use crate::base::space::Space;
use crate::domain::step::rves::RveEvent;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::mpm::points::{Hot, Point};
use crate::rve::rows::{packed, parted};
use crate::rve::{PointRve, Resting, RveRow, Scratch};

/// All RVEs together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RveTotals {
    /// Steps of grains so far, and those of pairs.
    pub steps: u64,
    /// A step counts once for each listed pair: what RVEs cost.
    pub pair_steps: u64,
    /// RVEs without contacts, and such as have been replicated.
    pub loose: u64,
    /// Such as have more grains than their packing.
    pub replicated: u64,
    /// The largest I_uf.
    pub unbalanced_max: f64,
    /// The stiffest bound on a P-wave modulus, Pa.
    pub modulus_max: f64,
    /// Void ratio of all together, and contacts of a grain with and without such grains as have none or one: means by the solid that points stand for.
    pub void_ratio: f64,
    /// All grains counted; 0 of an RVE without contacts.
    pub coordination: f64,
    /// As Thornton (2000) has it, without grains that have none or one.
    pub mechanical_coordination: f64,
}

impl<S: Space> Cargo for RveRow<S> {
    fn blank() -> Self {
        RveRow::blank()
    }

    fn pack_rest(&mut self, to: &mut Writer) {
        to.f64_slice(&self.resting.motions);
        to.f64_slice(&self.resting.memories);
        self.resting.contacts.iter().for_each(|pair| to.u64(packed(*pair)));
    }

    fn unpack_rest(&mut self, from: &mut Reader) -> Result<(), ParcelError> {
        let Resting { motions, contacts, memories, .. } = &mut self.resting;
        *motions = from.f64_slice()?;
        *memories = from.f64_slice()?;
        for pair in contacts {
            *pair = parted(from.u64()?);
        }
        Ok(())
    }
}

impl<S: Space> World<'_, S> {
    /// What leaves with points that do, these in the order of ranks, and of `fresh` ones what stays as well.
    pub(crate) fn rves_leaving(
        &self,
        points: &[Vec<Point<S>>],
        fresh: Vec<RveRow<S>>,
    ) -> Result<Vec<Vec<RveRow<S>>>, Error> {
        if self.settings.rves.is_none() {
            return Ok(Vec::new());
        }
        let here: BTreeMap<PointId, usize> =
            self.continuum.points.cold.iter().enumerate().map(|(row, cold)| (cold.id, row)).collect();
        let mut fresh: BTreeMap<PointId, RveRow<S>> = fresh.into_iter().map(|row| (row.point, row)).collect();
        let mut of = |id: PointId| match fresh.remove(&id) {
            Some(row) => Ok(row),
            None => here.get(&id).map(|row| self.rves[*row].rest(id)).ok_or_else(|| {
                Error::Run(format!("point {} has no RVE, which must not happen: please report this", id.0))
            }),
        };
        let row_of = |points: &Vec<Point<S>>| points.iter().map(|point| of(point.cold.id)).collect();
        points.iter().map(row_of).collect()
    }

    /// Puts RVEs in the order of their points, `moved`; those that have arrived wake. Collective.
    pub(crate) fn settle_rves(
        &mut self,
        number: u64,
        mut leaving: Vec<Vec<RveRow<S>>>,
        moved: &Moved<Point<S>>,
    ) -> Result<(), Error> {
        let Some(material) = &self.settings.rves else { return Ok(()) };
        // What stays on its rank is not packed.
        let mut come = std::mem::take(&mut leaving[self.transport.rank()]);
        come.extend(transfer::exchange(self.transport, number, leaving)?.into_iter().flatten());
        // F of those that have arrived, and of fresh ones, comes with their points.
        let of_points: BTreeMap<PointId, S::Tensor> =
            moved.arrived.iter().map(|point| (point.cold.id, point.hot.deformation)).collect();
        let wake = |row: &RveRow<S>| Ok((row.point, row.wake(material, of_points[&row.point])?));
        let woken: Result<Vec<(PointId, PointRve<S>)>, Error> = come.par_iter().map(wake).collect();
        let mut woken: BTreeMap<PointId, PointRve<S>> = transfer::agree(self.transport, woken)?.into_iter().collect();
        let mut here: Vec<Option<PointRve<S>>> = std::mem::take(&mut self.rves).into_iter().map(Some).collect();
        let mut of = |source: &u32| match (*source as usize).checked_sub(moved.held) {
            None => here[*source as usize].take(),
            Some(number) => woken.remove(&moved.arrived[number].cold.id),
        };
        self.rves = moved.sources.iter().map(|source| of(source).expect("every point has its RVE")).collect();
        Ok(())
    }

    /// What RVEs have come through since this was last asked, on rank 0; every rank knows whether there is something.
    pub fn take_rve_events(&mut self) -> Option<Vec<RveEvent>> {
        self.rve_events.take()
    }

    /// RVEs of some of the points of this rank, at rest.
    pub fn rve_rows(&self, rows: std::ops::Range<usize>) -> Vec<RveRow<S>> {
        rows.map(|row| self.rves[row].rest(self.continuum.points.cold[row].id)).collect()
    }

    /// Of all ranks together.
    pub fn rve_totals(&self) -> Result<RveTotals, Error> {
        let of = |scratch: &mut Scratch<S>, (carried, hot): (&PointRve<S>, &Hot<S>)| {
            let rve = &carried.rve;
            let is_replicated = rve.grains() > rve.template().packing.grains.len();
            let counts = [
                rve.state().steps as i64,
                rve.state().pair_steps as i64,
                i64::from(rve.is_loose()),
                i64::from(is_replicated),
            ];
            let seen = rve.observe(scratch);
            let solid = hot.mass;
            let means = [rve.void_ratio(), seen.fabric.coordination, seen.fabric.mechanical, 1.0].map(|of| of * solid);
            (counts, [seen.unbalanced.unwrap_or_default(), seen.modulus_most()], means)
        };
        let points = self.continuum.points.hot.par_iter();
        let rows: Vec<([i64; 4], [f64; 2], [f64; 4])> =
            self.rves.par_iter().zip(points).map_init(Scratch::default, of).collect();
        let mut counts = [0; 4];
        let mut most = [0.0; 2];
        let mut sums = ExactSum::<4>::new();
        for (row, sizes, means) in rows {
            counts.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
            most.iter_mut().zip(sizes).for_each(|(most, size)| *most = f64::max(*most, size));
            (0..).zip(means).for_each(|(slot, of)| sums.add(slot, of));
        }
        self.transport.sum(&mut counts);
        self.transport.max(&mut most);
        let [steps, pair_steps, loose, replicated] = counts.map(|count| count as u64);
        let [unbalanced_max, modulus_max] = most;
        let [voids, contacts, mechanical, solid] = self.reduce(sums)?;
        let [void_ratio, coordination, mechanical_coordination] = [voids, contacts, mechanical].map(|sum| sum / solid);
        Ok(RveTotals {
            steps,
            pair_steps,
            loose,
            replicated,
            unbalanced_max,
            modulus_max,
            void_ratio,
            coordination,
            mechanical_coordination,
        })
    }
}
