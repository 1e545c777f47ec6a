//! What moves in each cell of the plane, grains and points alike: by it shear is looked for wherever it goes on.

use std::collections::BTreeMap;

use super::cells::everywhere;
use super::enrichment::cell_grid;
use crate::base::error::Error;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::patch::Patch;
use crate::dem::grains::Mover;
use crate::domain::world::World;
use crate::numbers;

type Vector = <Plane as Space>::Vector;

/// Points that weigh less than this share of its grains do not make a cell one of the rim, where they weigh as much.
const CORE_POINTS: f64 = 0.25;

/// Of a cell, by weights. Volumes and displacements are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Flow {
    /// Of all, about the centre of the cell.
    pub patch: Patch,
    /// Of its grains alone, with all of their masses.
    pub grains: Patch,
    /// Mass of grains and of points that share their place with some, kg.
    pub inside: f64,
    /// Mass of all points, kg, and the sum of their plastic strains by mass.
    points: f64,
    plastic: f64,
}

numbers!(impl[] Flow[] { patch: Patch, grains: Patch, inside: f64, points: f64, plastic: f64 });

impl Flow {
    /// Whether most of the cell is of a zone, its rim counted.
    pub fn is_inside(&self) -> bool {
        self.inside > 0.5 * self.patch.mass
    }

    /// Whether next to all of the cell is of grains alone: single points may have strayed into it.
    pub fn is_core(&self) -> bool {
        self.inside > 0.5 * self.patch.mass && self.points < CORE_POINTS * self.grains.mass
    }

    /// Mean plastic strain of its points; none where these are less than `least`, kg.
    pub fn plastic(&self, least: f64) -> Option<f64> {
        (self.points > 0.0 && self.points >= least).then(|| self.plastic / self.points)
    }
}

/// Those of all cells that hold anything, on every rank; added up in the order of rows. Collective.
pub fn flows<S: Space>(world: &World<S>) -> Result<BTreeMap<u64, Flow>, Error> {
    let grid = cell_grid(world);
    let mut mine: BTreeMap<u64, Flow> = BTreeMap::new();
    let plane = |vector: &S::Vector| Vector::new(vector[0], vector[1]);
    let (grains, law) = (&world.assembly.grains, &world.settings.material);
    for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold).filter(|(_, cold)| cold.mover == Mover::Free)
    {
        let Some(cell) = world.cell_of_grain(cold) else { continue };
        let (flow, mass) = (mine.entry(cell as u64).or_default(), hot.weight * hot.mass);
        let (way, velocity) = (plane(&hot.position) - grid.centre(cell), plane(&hot.velocity));
        flow.patch.add_grain((mass, 0.0), &way, &velocity, &Vector::zero());
        flow.grains.add_grain((hot.mass, 0.0), &way, &velocity, &Vector::zero());
        flow.inside += mass;
    }
    for (hot, cold) in world.continuum.points.hot.iter().zip(&world.continuum.points.cold) {
        let Some(cell) = world.cell_of_point(cold) else { continue };
        let (flow, mass) = (mine.entry(cell as u64).or_default(), hot.weight * hot.mass);
        let (way, velocity) = (plane(&hot.position) - grid.centre(cell), plane(&hot.velocity));
        flow.patch.add_grain((mass, 0.0), &way, &velocity, &Vector::zero());
        flow.inside += if hot.weight < 1.0 { mass } else { 0.0 };
        flow.points += hot.mass;
        flow.plastic += hot.mass * law.plastic_strain(&hot.memory);
    }
    everywhere(world.transport, &mine)
}
