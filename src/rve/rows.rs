//! RVEs as rows beside material points: what a world of points needs of a material that is grains.

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;
use crate::rve::drive::{Drive, Frame};
use crate::rve::rest::{Packing, Resting, Template};
use crate::rve::volume_element::{Rve, State};

/// Those that RVEs begin from.
pub type Packings = Vec<Packing>;

/// Grains as the material of points.
#[derive(Clone, Debug)]
pub struct GrainMaterial<S: Space> {
    /// Steps of an increment and at rest after it.
    pub drive: Drive,
    /// What of an increment cells are driven by.
    pub frame: Frame,
    /// The packings that RVEs begin from, at all their levels of stress.
    pub templates: Vec<Template<S>>,
}

impl<S: Space> GrainMaterial<S> {
    /// The packings themselves.
    pub fn packings(&self) -> Packings {
        self.templates.iter().map(|template| template.packing.clone()).collect()
    }
}

/// The RVE of a point.
#[derive(Clone)]
pub struct PointRve<S: Space> {
    /// Its packing, by its number among the templates.
    pub packing: u64,
    /// The assembly that stands for the point.
    pub rve: Rve<S>,
    /// F of the point when it last followed; that of the RVE is another where strain is nonlocal.
    pub deformation: S::Tensor,
    /// F(n) F(n-1)^-1 - 1 of the point then, which neighbours count with in the next step where strain has a lag of one; else it is not kept.
    pub increment: S::Tensor,
    /// Steps of pairs in its last increment: what it costs, about, in the next one.
    pub cost: u64,
}

/// The same at rest, as it travels with its point and lies on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct RveRow<S: Space> {
    /// The point that it stands for.
    pub point: PointId,
    /// By its number among the templates.
    pub packing: u64,
    /// Steps of pairs in the last increment.
    pub cost: u64,
    /// F(n) F(n-1)^-1 - 1 of the point, where strain has a lag of one ([`PointRve::increment`]).
    pub increment: S::Tensor,
    /// Its grains, contacts and deformation.
    pub resting: Resting<S>,
}

impl<S: Space> PointRve<S> {
    /// At rest, as the row of this point.
    pub fn rest(&self, point: PointId) -> RveRow<S> {
        let Self { packing, cost, increment, .. } = *self;
        RveRow { point, packing, cost, increment, resting: self.rve.rest() }
    }
}

impl<S: Space> RveRow<S> {
    /// Before it is read.
    pub fn blank() -> Self {
        let cell = Cell::cuboid(S::Vector::zero(), S::Vector::zero(), [true; 3]);
        let resting = Resting {
            state: State::blank(),
            cells: [cell; 2],
            step: 0,
            motions: Vec::new(),
            contacts: Vec::new(),
            memories: Vec::new(),
        };
        Self { point: PointId(0), packing: 0, cost: 0, increment: S::Tensor::zero(), resting }
    }

    /// Beside a point whose deformation gradient is `deformation`.
    pub fn wake(&self, material: &GrainMaterial<S>, deformation: S::Tensor) -> Result<PointRve<S>, Error> {
        let template = material.templates.get(self.packing as usize).ok_or_else(|| {
            Error::User(format!(
                "the RVE of point {} is of packing {}, and the job has {}: the state is of another job",
                self.point.0,
                self.packing,
                material.templates.len()
            ))
        })?;
        let mut resting = self.resting.clone();
        resting.cells.iter_mut().for_each(|cell| {
            // What follows from its edges has not travelled.
            let moved = *cell;
            cell.take_motion_of(&moved);
        });
        let Self { packing, cost, increment, .. } = *self;
        Ok(PointRve { packing, rve: Rve::wake(template, &resting)?, deformation, increment, cost })
    }
}

impl<S: Space> Record for RveRow<S> {
    /// All but the rows of grains and contacts, of which it tells how many there are, so that they find room.
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        let Self { point, packing, cost, increment, resting } = self;
        visitor.u64("point", &mut point.0);
        visitor.u64("packing", packing);
        visitor.u64("cost", cost);
        visitor.later_f64s("increment", increment.as_mut_slice());
        visitor.u64("sample_step", &mut resting.step);
        resting.state.visit(visitor);
        let [cell, home] = &mut resting.cells;
        visitor.f64s("cell_corner", cell.corner.as_mut_slice());
        home.corner = cell.corner;
        cell.visit(visitor);
        visitor.f64s("home_edges", home.edges.as_mut_slice());
        visitor.f64s("home_gradient", home.gradient.as_mut_slice());
        visitor.f64s("home_rate", home.rate.as_mut_slice());
        visit_count("grain_words", &mut resting.motions, visitor);
        visit_count("contacts", &mut resting.contacts, visitor);
        visit_count("contact_words", &mut resting.memories, visitor);
    }
}

fn visit_count<T: Clone + Default>(name: &'static str, rows: &mut Vec<T>, visitor: &mut dyn Visitor) {
    let mut count = rows.len() as u64;
    visitor.u64(name, &mut count);
    rows.resize(count as usize, T::default());
}

/// Both grains of a contact in one number.
pub fn packed([lower, higher]: [u16; 2]) -> u64 {
    u64::from(lower) << 16 | u64::from(higher)
}

/// The reverse of [`packed`].
pub fn parted(pair: u64) -> [u16; 2] {
    [(pair >> 16) as u16, pair as u16]
}
