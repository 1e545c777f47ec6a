//! Grains as rows: what a contact reads every step apart from what is needed now and then.

use crate::ids::GrainId;
use crate::record::{Record, Visitor};
use crate::space::{Linear, Space};

/// The part of a grain that a contact reads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Hot<S: Space> {
    /// Centre, m. Wrapped into the period at rebuilds only.
    pub position: S::Vector,
    /// Velocity, half a step behind the position, m/s.
    pub velocity: S::Vector,
    /// Angular velocity, rad/s.
    pub spin: S::Spin,
    pub radius: f64,
    /// Share of the grain in the coupled mixture: 1, or w in the reconciliation zone.
    pub weight: f64,
}

/// Who decides a grain's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mover {
    /// Its own forces.
    Free,
    /// It is glued to this body.
    Body(u8),
    /// It follows a prescribed path (the rim of a packing in training).
    Script,
}

/// The part of a grain that is read at rebuilds, in its own motion and for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cold<S: Space> {
    pub id: GrainId,
    /// kg; full, never weighted.
    pub mass: f64,
    pub mover: Mover,
    /// Place in the packing it came from, m.
    pub origin: S::Vector,
    /// Periods crossed since then.
    pub image: i64,
    /// Position at the last rebuild, m: block, lists and their age follow from it.
    pub home: S::Vector,
    /// Prescribed velocity of a scripted grain, m/s.
    pub script: S::Vector,
}

/// Grains of this rank in block order, copies of other ranks' grains behind them.
#[derive(Clone, Debug)]
pub struct Grains<S: Space> {
    pub hot: Vec<Hot<S>>,
    pub cold: Vec<Cold<S>>,
    /// Rows `0..owned` are ours; `cold` of a copy is as it was at the last rebuild.
    pub owned: usize,
    /// Force and torque on owned rows, N and N m; weighted as the contacts are.
    pub force: Vec<S::Vector>,
    pub torque: Vec<S::Spin>,
}

impl<S: Space> Default for Grains<S> {
    fn default() -> Self {
        Self { hot: Vec::new(), cold: Vec::new(), owned: 0, force: Vec::new(), torque: Vec::new() }
    }
}

/// A whole grain with the memories of its contacts, as it travels, rests on disk or is handed to a new world.
#[derive(Clone, Debug, PartialEq)]
pub struct GrainRow<S: Space, M> {
    pub hot: Hot<S>,
    pub cold: Cold<S>,
    /// Memories of touching contacts by the partner's id, in its order; in the orientation lower to higher id.
    pub contacts: Vec<(GrainId, M)>,
}

impl Mover {
    /// Code on disk and in parcels: 0 free, 255 scripted, 1 + n glued to body n.
    pub fn code(self) -> u8 {
        match self {
            Mover::Free => 0,
            Mover::Body(body) => body + 1,
            Mover::Script => 255,
        }
    }
    pub fn from_code(code: u8) -> Self {
        match code {
            0 => Mover::Free,
            255 => Mover::Script,
            body => Mover::Body(body - 1),
        }
    }
}

impl<S: Space> Grains<S> {
    /// Sizes the force arrays after rows have changed.
    pub fn reset_forces(&mut self) {
        self.force.clear();
        self.force.resize(self.owned, S::Vector::zero());
        self.torque.clear();
        self.torque.resize(self.owned, S::Spin::zero());
    }
}

impl<S: Space, M: Linear> GrainRow<S, M> {
    /// A grain at rest at `position`, with nothing remembered.
    pub fn resting(id: GrainId, position: S::Vector, radius: f64, mass: f64, mover: Mover) -> Self {
        let zero = S::Vector::zero();
        Self {
            hot: Hot { position, velocity: zero, spin: S::Spin::zero(), radius, weight: 1.0 },
            cold: Cold { id, mass, mover, origin: position, image: 0, home: position, script: zero },
            contacts: Vec::new(),
        }
    }
}

/// The grain itself; its contacts are records of their own.
impl<S: Space, M> Record for GrainRow<S, M> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        let (hot, cold) = (&mut self.hot, &mut self.cold);
        visitor.u64("id", &mut cold.id.0);
        visitor.f64s("position", hot.position.as_mut_slice());
        visitor.f64s("velocity", hot.velocity.as_mut_slice());
        visitor.f64s("spin", hot.spin.as_mut_slice());
        visitor.f64s("radius", std::slice::from_mut(&mut hot.radius));
        visitor.f64s("weight", std::slice::from_mut(&mut hot.weight));
        visitor.f64s("mass", std::slice::from_mut(&mut cold.mass));
        let mut mover = cold.mover.code();
        visitor.u8("mover", &mut mover);
        cold.mover = Mover::from_code(mover);
        visitor.f64s("origin", cold.origin.as_mut_slice());
        visitor.i64("image", &mut cold.image);
        visitor.f64s("home", cold.home.as_mut_slice());
        visitor.f64s("script", cold.script.as_mut_slice());
    }
}

/// A touching contact as it rests on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRow<M> {
    pub lower: GrainId,
    pub higher: GrainId,
    pub memory: M,
}

impl<M: Linear> Record for ContactRow<M> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("lower", &mut self.lower.0);
        visitor.u64("higher", &mut self.higher.0);
        visitor.f64s("memory", self.memory.as_mut_slice());
    }
}
