//! Material points as rows: what a step reads and writes apart from what is needed now and then.

use crate::dem::cell::{Image, visit_image};
use crate::hybrid::oracle::Window;
use crate::hybrid::track::Track;
use crate::ids::{PointId, Row};
use crate::law::material::MaterialMemory;
use crate::record::{Record, Visitor};
use crate::space::{Linear, Space};

/// The part of a point that every step reads and writes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hot<S: Space, M> {
    /// m; wrapped into the period at rebuilds only.
    pub position: S::Vector,
    /// Velocity half a step behind the position, m/s.
    pub velocity: S::Vector,
    /// Position at the last rebuild, m.
    pub home: S::Vector,
    /// kg; full, never weighted.
    pub mass: f64,
    /// Volume at the start, m3; Kirchhoff stress is per this volume.
    pub volume: f64,
    /// Share of the point in the coupled mixture: 1, or about 1 - w in the reconciliation zone.
    pub weight: f64,
    /// Kirchhoff stress, Pa, tension positive.
    pub stress: S::Tensor,
    /// Deformation gradient F since the start.
    pub deformation: S::Tensor,
    /// Gradient of the affine velocity field about the point, 1/s; zero where the scheme has none.
    pub affine: S::Tensor,
    /// Memory of the material law.
    pub memory: M,
    /// Force from without on a point that bears a load, N; of the step, not of the state.
    pub push: S::Vector,
}

/// The part of a point that is read at rebuilds and for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cold<S: Space> {
    pub id: PointId,
    /// Place at the start of the run, m.
    pub origin: S::Vector,
    /// Periods crossed since then.
    pub image: Image,
    /// Loads that it bears: bit n is the job's n-th.
    pub loads: u64,
    /// Plastic strain at the oracle's recent looks.
    pub window: Window,
    /// Where it has been, for training.
    pub track: Track<S>,
}

/// A whole material point, as it travels, rests on disk or is handed to a new world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<S: Space, M> {
    pub hot: Hot<S, M>,
    pub cold: Cold<S>,
}

/// Points of this rank in block order, within a block by (cell, id) of the last rebuild: the order of every sum over
/// points.
#[derive(Clone, Debug)]
pub struct Points<S: Space, M> {
    pub hot: Vec<Hot<S, M>>,
    pub cold: Vec<Cold<S>>,
    /// Rows that bear a load.
    pub loaded: Vec<Row>,
}

impl<S: Space, M> Default for Points<S, M> {
    fn default() -> Self {
        Self { hot: Vec::new(), cold: Vec::new(), loaded: Vec::new() }
    }
}

impl<S: Space, M: MaterialMemory> Points<S, M> {
    pub fn len(&self) -> usize {
        self.hot.len()
    }

    pub fn is_empty(&self) -> bool {
        self.hot.is_empty()
    }

    /// Whole rows, in their order.
    pub fn rows(&self) -> impl Iterator<Item = Point<S, M>> {
        self.hot.iter().zip(&self.cold).map(|(hot, cold)| Point { hot: *hot, cold: *cold })
    }
}

impl<S: Space, M> FromIterator<Point<S, M>> for Points<S, M> {
    fn from_iter<I: IntoIterator<Item = Point<S, M>>>(rows: I) -> Self {
        let (hot, cold): (_, Vec<Cold<S>>) = rows.into_iter().map(|point| (point.hot, point.cold)).unzip();
        let bears = |(row, cold): (usize, &Cold<S>)| (cold.loads != 0).then_some(row as Row);
        let loaded = cold.iter().enumerate().filter_map(bears).collect();
        Self { hot, cold, loaded }
    }
}

impl<S: Space, M> Hot<S, M> {
    /// det F since the start.
    pub fn volume_ratio(&self) -> f64 {
        S::determinant(&self.deformation)
    }
}

impl<S: Space, M: MaterialMemory> Point<S, M> {
    /// A point at rest at `position`, its first memory and stress to be given by its law.
    pub fn resting(id: PointId, position: S::Vector, mass: f64, volume: f64) -> Self {
        Self {
            hot: Hot {
                position,
                velocity: S::Vector::zero(),
                home: position,
                mass,
                volume,
                weight: 1.0,
                stress: S::Tensor::zero(),
                deformation: S::identity(),
                affine: S::Tensor::zero(),
                memory: M::default(),
                push: S::Vector::zero(),
            },
            cold: Cold {
                id,
                origin: position,
                image: [0; 3],
                loads: 0,
                window: Window::default(),
                track: Track::default(),
            },
        }
    }
}

impl<S: Space, M: MaterialMemory> Record for Point<S, M> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        let Self { hot, cold } = self;
        visitor.u64("id", &mut cold.id.0);
        visitor.f64s("position", hot.position.as_mut_slice());
        visitor.f64s("velocity", hot.velocity.as_mut_slice());
        visitor.f64s("home", hot.home.as_mut_slice());
        visitor.f64s("origin", cold.origin.as_mut_slice());
        visit_image::<S>(&mut cold.image, visitor);
        visitor.u64("loads", &mut cold.loads);
        visitor.f64s("mass", std::slice::from_mut(&mut hot.mass));
        visitor.f64s("volume", std::slice::from_mut(&mut hot.volume));
        visitor.f64s("weight", std::slice::from_mut(&mut hot.weight));
        visitor.f64s("stress", hot.stress.as_mut_slice());
        visitor.f64s("deformation", hot.deformation.as_mut_slice());
        visitor.f64s("affine", hot.affine.as_mut_slice());
        hot.memory.visit(visitor);
        visitor.f64s("window", &mut cold.window.samples);
        cold.track.visit(visitor);
    }
}
