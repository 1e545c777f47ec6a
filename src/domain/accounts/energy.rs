//! Energies of the whole world, exact sums over all ranks.

use scree_partition::{ExactSum, SumError};

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::dem::grains::Mover;
use crate::domain::world::World;

/// J; every grain, point and contact with its weight in the mixture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Translation and rotation of free grains.
    pub kinetic_grains: f64,
    /// Of these, rotation.
    pub kinetic_rotation: f64,
    /// Springs of contacts.
    pub elastic_grains: f64,
    /// Translation of points, without affine fields.
    pub kinetic_points: f64,
    /// Stored by the law of the material; that of hourglass modes is not in it.
    pub elastic_points: f64,
}

impl<S: Space> World<'_, S> {
    /// Energies at the positions of now.
    pub fn energies(&mut self) -> Result<Energies, Error> {
        self.refresh_ghosts();
        let mut sums = ExactSum::<5>::new();
        for (hot, cold) in self.assembly.grains.hot[..self.assembly.grains.owned].iter().zip(&self.assembly.grains.cold)
        {
            if cold.mover == Mover::Free {
                let mass = hot.weight * hot.mass;
                let inertia = S::grain_inertia(mass, hot.radius);
                let rotation = 0.5 * inertia * hot.spin.dot(&hot.spin);
                sums.add(0, 0.5 * mass * hot.velocity.dot(&hot.velocity) + rotation);
                sums.add(4, rotation);
            }
        }
        for energy in self.assembly.contacts.elastic_energies(self.law(), &self.assembly.grains) {
            sums.add(1, energy);
        }
        for energy in
            self.assembly.walls.elastic_energies(self.law(), &self.assembly.grains, (&self.bodies, &self.assembly.cell))
        {
            sums.add(1, energy);
        }
        for point in &self.continuum.points.hot {
            sums.add(2, 0.5 * point.weight * point.mass * point.velocity.dot(&point.velocity));
            sums.add(3, point.weight * point.volume * self.settings.material.elastic_energy(&point.memory));
        }
        let [kinetic_grains, elastic_grains, kinetic_points, elastic_points, kinetic_rotation] = self.reduce(sums)?;
        Ok(Energies { kinetic_grains, kinetic_rotation, elastic_grains, kinetic_points, elastic_points })
    }

    /// Kinetic energy of the free grains that are part of the packing, J: of those with more contacts that bear force than the space
    /// has dimensions. Others, rattlers, bear nothing, and fly to and fro between those that do long after these have come to rest.
    pub fn kinetic_of_bearing(&mut self) -> Result<f64, Error> {
        self.refresh_ghosts();
        let (law, grains, times) = (self.law(), &self.assembly.grains, self.contact_times());
        let bearing_on = |row: usize| self.assembly.contacts.bearings(law, grains, row, times).count() as u32;
        let mut contacts: Vec<u32> = (0..grains.owned).map(bearing_on).collect();
        for bearing in self.assembly.walls.bearings(law, grains, (&self.bodies, &self.assembly.cell), times) {
            contacts[bearing.row as usize] += 1;
        }
        let mut sum = ExactSum::<1>::new();
        let rows = grains.hot[..grains.owned].iter().zip(&grains.cold).zip(contacts);
        for ((hot, _), _) in rows.filter(|((_, cold), of)| cold.mover == Mover::Free && *of as usize > S::DIMENSION) {
            let inertia = S::grain_inertia(hot.mass, hot.radius);
            let rotation = inertia * hot.spin.dot(&hot.spin);
            sum.add(0, 0.5 * hot.weight * (hot.mass * hot.velocity.dot(&hot.velocity) + rotation));
        }
        Ok(self.reduce(sum)?[0])
    }

    /// How far a packing is from rest: [`Self::kinetic_of_bearing`] over the energy of all springs, infinite without any.
    pub fn unrest(&mut self) -> Result<f64, Error> {
        let (kinetic, elastic) = (self.kinetic_of_bearing()?, self.energies()?.elastic_grains);
        Ok(if elastic > 0.0 { kinetic / elastic } else { f64::INFINITY })
    }

    /// Exact sums over all ranks; what is not finite stops the run.
    pub fn reduce<const N: usize>(&self, sums: ExactSum<N>) -> Result<[f64; N], Error> {
        sums.reduce(self.transport).map_err(|error| self.out_of_range(&error))
    }

    pub(crate) fn out_of_range(&self, error: &SumError) -> Error {
        Error::Run(format!(
            "step {}: energy or momentum is not finite or beyond reason ({error}); the run is unstable: check `time.step` and the last frames",
            self.step
        ))
    }
}
