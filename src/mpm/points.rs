//! Material points.

use crate::dem::cell::Image;
use crate::hybrid::oracle::Window;
use crate::hybrid::track::Track;
use crate::ids::PointId;
use crate::law::material::MaterialMemory;
use crate::record::{Record, Visitor};
use crate::space::{Linear, Space};

/// A material point. It stands in block order, within a block by (cell, id) of the last rebuild: the order of every
/// sum over points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<S: Space, M> {
    pub id: PointId,
    /// m; wrapped into the period at rebuilds only.
    pub position: S::Vector,
    /// Velocity half a step behind the position, m/s.
    pub velocity: S::Vector,
    /// Position at the last rebuild, m.
    pub home: S::Vector,
    /// Place at the start of the run, m.
    pub origin: S::Vector,
    /// Periods crossed since then.
    pub image: Image,
    /// kg; full, never weighted.
    pub mass: f64,
    /// Volume at the start, m3; Kirchhoff stress is per this volume.
    pub volume: f64,
    /// Share of the point in the coupled mixture: 1, or about 1 - w in the reconciliation zone.
    pub weight: f64,
    /// Kirchhoff stress, Pa, tension positive.
    pub stress: S::Tensor,
    /// Memory of the material law.
    pub memory: M,
    /// det F since the start.
    pub volume_ratio: f64,
    /// Plastic strain at the oracle's recent looks.
    pub window: Window,
    /// Where it has been, for training.
    pub track: Track<S>,
}

impl<S: Space, M: MaterialMemory> Point<S, M> {
    /// A point at rest at `position`, its first memory and stress to be given by its law.
    pub fn resting(id: PointId, position: S::Vector, mass: f64, volume: f64) -> Self {
        Self {
            id,
            position,
            velocity: S::Vector::zero(),
            home: position,
            origin: position,
            image: [0; 3],
            mass,
            volume,
            weight: 1.0,
            stress: S::Tensor::zero(),
            memory: M::default(),
            volume_ratio: 1.0,
            window: Window::default(),
            track: Track::default(),
        }
    }
}

impl<S: Space, M: MaterialMemory> Record for Point<S, M> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("id", &mut self.id.0);
        visitor.f64s("position", self.position.as_mut_slice());
        visitor.f64s("velocity", self.velocity.as_mut_slice());
        visitor.f64s("home", self.home.as_mut_slice());
        visitor.f64s("origin", self.origin.as_mut_slice());
        crate::dem::cell::visit_image::<S>(&mut self.image, visitor);
        visitor.f64s("mass", std::slice::from_mut(&mut self.mass));
        visitor.f64s("volume", std::slice::from_mut(&mut self.volume));
        visitor.f64s("weight", std::slice::from_mut(&mut self.weight));
        visitor.f64s("stress", self.stress.as_mut_slice());
        self.memory.visit(visitor);
        visitor.f64s("volume_ratio", std::slice::from_mut(&mut self.volume_ratio));
        visitor.f64s("window", &mut self.window.samples);
        self.track.visit(visitor);
    }
}
