//! Grains as rows: what a contact reads every step apart from what is needed now and then.

use crate::base::ids::{GrainId, Row};
use crate::base::lane::LANES;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space, Words};
use crate::dem::cell::{Image, visit_image};
use crate::dem::memories::Carried;
use crate::law::contact::Memory;
use crate::numbers;

/// The part of a grain that a contact and its own motion read: whole vector registers of `f64` without a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Hot<S: Space> {
    /// Centre, m. Wrapped into the cell at rebuilds only.
    pub position: S::Vector,
    /// Velocity, half a step behind the position, m/s.
    pub velocity: S::Vector,
    /// Angular velocity, rad/s.
    pub spin: S::Spin,
    /// m.
    pub radius: f64,
    /// Share of the grain in the coupled mixture: 1, or w in the reconciliation zone. A grain that a body moves has no
    /// share of its own: 0.
    pub weight: f64,
    /// kg; full, never weighted.
    pub mass: f64,
    /// Fills the record up to whole registers; nothing reads it. Empty in the plane.
    pub spare: S::Spare,
}

numbers!(impl[S: Space] Hot[S] {
    position: S::Vector,
    velocity: S::Vector,
    spin: S::Spin,
    radius: f64,
    weight: f64,
    mass: f64,
    spare: S::Spare,
});

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

/// The part of a grain that is read at rebuilds and for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cold<S: Space> {
    /// The same on every rank and across restarts.
    pub id: GrainId,
    /// Whether its forces, a body or a script move it.
    pub mover: Mover,
    /// Place in the packing it came from, m.
    pub origin: S::Vector,
    /// Periods crossed since then.
    pub image: Image,
    /// Position at the last rebuild, m: block, lists and their age follow from it.
    pub home: S::Vector,
    /// Prescribed velocity of a scripted grain, m/s; of a free one a force beside those of contacts, N.
    pub script: S::Vector,
}

/// What holds a grain to the continuum that shares its place: a spring and a dashpot on the way that it slips, as changes of
/// its velocity from one exchange with nodes to the next, m/s ([`crate::mpm::penalty`]). Both are zero away from the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenaltySpring<S: Space> {
    /// Of the spring.
    pub spring: S::Vector,
    /// Of both until the next exchange.
    pub given: S::Vector,
}

impl<S: Space> PenaltySpring<S> {
    /// Of a grain that has not slipped.
    pub fn loose() -> Self {
        Self { spring: S::Vector::zero(), given: S::Vector::zero() }
    }
}

impl<S: Space> Record for PenaltySpring<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("spring", self.spring.as_mut_slice());
        visitor.f64s("given", self.given.as_mut_slice());
    }
}

/// Grains of this rank in block order, copies of other ranks' grains behind them.
#[derive(Clone, Debug)]
pub struct Grains<S: Space> {
    /// By row, owned ones and copies.
    pub hot: Vec<Hot<S>>,
    /// By row, owned ones and copies; empty after [`Self::drop_cold`].
    pub cold: Vec<Cold<S>>,
    /// Rows `0..owned` are ours; `cold` of a copy is as it was at the last rebuild.
    pub owned: usize,
    /// Of owned rows, what a step reads of `cold`, apart from the rest for the sake of the caches.
    pub movers: Vec<Mover>,
    /// [`Cold::home`] of each owned row, m.
    pub homes: Vec<S::Vector>,
    /// Owned rows that are glued to bodies.
    pub glued: Vec<Row>,
    /// Owned rows that go by a script.
    pub scripted: Vec<Row>,
    /// Free owned rows that a force of their own pushes, and that force, N.
    pub pushed: Vec<(Row, S::Vector)>,
    /// Free owned rows that bodies may touch, ascending.
    pub near_bodies: Vec<Row>,
    /// Both, ascending: what pushes them is not known yet when contacts with other grains are summed. And the same by row.
    pub waiting: Vec<Row>,
    /// By owned row, whether it is among those that wait.
    pub waits: Vec<bool>,
    /// Of every eight owned rows side by side, from the first on, whether all are free and wait for nothing: the same is done with each.
    pub alike: Vec<bool>,
    /// Ties of owned rows to the continuum.
    pub springs: Vec<PenaltySpring<S>>,
    /// Where owned rows that share nodes are at the next exchange, m, as the last one predicted; made anew at the beginning of a cycle, and empty where no step goes without an
    /// exchange.
    pub predicted: Vec<S::Vector>,
    /// Force and torque on owned rows, N and N m; weighted as the contacts are.
    pub force: Vec<S::Vector>,
    /// By owned row, N m.
    pub torque: Vec<S::Spin>,
}

impl<S: Space> Default for Grains<S> {
    fn default() -> Self {
        Self {
            hot: Vec::new(),
            cold: Vec::new(),
            owned: 0,
            movers: Vec::new(),
            homes: Vec::new(),
            glued: Vec::new(),
            scripted: Vec::new(),
            pushed: Vec::new(),
            near_bodies: Vec::new(),
            waiting: Vec::new(),
            waits: Vec::new(),
            alike: Vec::new(),
            springs: Vec::new(),
            predicted: Vec::new(),
            force: Vec::new(),
            torque: Vec::new(),
        }
    }
}

/// A whole grain with the memories of its contacts, as it travels, rests on disk or is handed to a new world.
#[derive(Clone, Debug, PartialEq)]
pub struct GrainRow<S: Space> {
    /// What contacts and motion read of it.
    pub hot: Hot<S>,
    /// What rebuilds and output read of it.
    pub cold: Cold<S>,
    /// Its tie to the continuum.
    pub spring: PenaltySpring<S>,
    /// Memories of touching contacts by the partner's id, in its order; in the orientation lower to higher id.
    pub contacts: Vec<Carried>,
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
    /// The reverse of [`Self::code`]; every number is a code.
    pub fn from_code(code: u8) -> Self {
        match code {
            0 => Mover::Free,
            255 => Mover::Script,
            body => Mover::Body(body - 1),
        }
    }
}

impl<S: Space> Grains<S> {
    /// Lays the arrays of a step after rows have changed.
    pub fn settle(&mut self) {
        let owned = &self.cold[..self.owned];
        self.movers = owned.iter().map(|cold| cold.mover).collect();
        self.homes = owned.iter().map(|cold| cold.home).collect();
        let rows = |is: fn(Mover) -> bool| {
            let row = move |(row, cold): (usize, &Cold<S>)| is(cold.mover).then_some(row as Row);
            owned.iter().enumerate().filter_map(row).collect()
        };
        self.glued = rows(|mover| matches!(mover, Mover::Body(_)));
        self.scripted = rows(|mover| mover == Mover::Script);
        self.near_bodies.clear();
        self.push_as_told();
        self.force.clear();
        self.force.reserve_exact(self.owned);
        self.force.resize(self.owned, S::Vector::zero());
        self.torque.clear();
        self.torque.reserve_exact(self.owned);
        self.torque.resize(self.owned, S::Spin::zero());
    }

    /// Lists what is pushed, after scripts have changed.
    pub fn push_as_told(&mut self) {
        let is_pushed = |cold: &Cold<S>| cold.mover == Mover::Free && cold.script != S::Vector::zero();
        let pushed = |(row, cold): (usize, &Cold<S>)| is_pushed(cold).then_some((row as Row, cold.script));
        self.pushed = self.cold[..self.owned].iter().enumerate().filter_map(pushed).collect();
        self.line_up();
    }

    /// Lists what bodies may touch: rows in ascending order, each perhaps several times.
    pub fn come_near_bodies(&mut self, rows: impl Iterator<Item = Row>) {
        self.near_bodies = rows.collect();
        self.near_bodies.dedup();
        self.line_up();
    }

    fn line_up(&mut self) {
        let pushed = self.pushed.iter().map(|(row, _)| *row);
        self.waiting = pushed.chain(self.near_bodies.iter().copied()).collect();
        self.waiting.sort_unstable();
        self.waiting.dedup();
        self.waits.clear();
        self.waits.resize(self.owned, false);
        self.waiting.iter().for_each(|row| self.waits[*row as usize] = true);
        let is_alike = |(movers, waits): (&[Mover; LANES], &[bool; LANES])| {
            movers.iter().all(|mover| *mover == Mover::Free) && !waits.contains(&true)
        };
        let (movers, waits) = (self.movers.as_chunks().0, self.waits.as_chunks().0);
        self.alike = movers.iter().zip(waits).map(is_alike).collect();
    }

    /// Gives up what only a rebuild reads of free grains in the order of their ids, from none on; [`Self::restore_cold`] tells it again.
    pub fn drop_cold(&mut self) {
        debug_assert!(self.cold.iter().enumerate().all(|(row, cold)| cold.id.0 == row as u64));
        (self.cold, self.springs) = (Vec::new(), Vec::new());
        // Nobody asks who moves grains that are all free.
        (self.movers, self.waits, self.alike) = (Vec::new(), Vec::new(), Vec::new());
    }

    /// The reverse.
    pub fn restore_cold(&mut self) {
        if self.cold.is_empty() {
            let cold = |(row, home): (usize, &S::Vector)| Cold {
                id: GrainId(row as u64),
                mover: Mover::Free,
                origin: S::Vector::zero(),
                image: [0; 3],
                home: *home,
                script: S::Vector::zero(),
            };
            self.cold = self.homes.iter().enumerate().map(cold).collect();
            self.springs = vec![PenaltySpring::loose(); self.owned];
            self.movers = vec![Mover::Free; self.owned];
            self.line_up();
        }
    }

    /// Bytes that the arrays hold.
    pub fn bytes(&self) -> usize {
        self.hot.capacity() * size_of::<Hot<S>>()
            + self.cold.capacity() * size_of::<Cold<S>>()
            + self.movers.capacity() * size_of::<Mover>()
            + (self.glued.capacity() + self.scripted.capacity()) * size_of::<Row>()
            + self.pushed.capacity() * size_of::<(Row, S::Vector)>()
            + (self.near_bodies.capacity() + self.waiting.capacity()) * size_of::<Row>()
            + (self.waits.capacity() + self.alike.capacity()) * size_of::<bool>()
            + self.springs.capacity() * size_of::<PenaltySpring<S>>()
            + self.predicted.capacity() * size_of::<S::Vector>()
            + self.homes.capacity() * size_of::<S::Vector>()
            + self.force.capacity() * size_of::<S::Vector>()
            + self.torque.capacity() * size_of::<S::Spin>()
    }
}

impl<S: Space> GrainRow<S> {
    /// A grain at rest at `position`, with nothing remembered.
    pub fn resting(id: GrainId, position: S::Vector, radius: f64, mass: f64, mover: Mover) -> Self {
        let zero = S::Vector::zero();
        let spare = S::Spare::default();
        let mut row = Self {
            hot: Hot { position, velocity: zero, spin: S::Spin::zero(), radius, weight: 1.0, mass, spare },
            cold: Cold { id, mover, origin: position, image: [0; 3], home: position, script: zero },
            spring: PenaltySpring::loose(),
            contacts: Vec::new(),
        };
        row.hand_to(mover);
        row
    }

    /// Who moves the grain from now on.
    pub fn hand_to(&mut self, mover: Mover) {
        self.cold.mover = mover;
        self.hot.weight = if matches!(mover, Mover::Body(_)) { 0.0 } else { 1.0 };
    }
}

/// The grain itself; its penalty spring and its contacts are records of their own.
impl<S: Space> Record for GrainRow<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        let (hot, cold) = (&mut self.hot, &mut self.cold);
        visitor.u64("id", &mut cold.id.0);
        visitor.f64s("position", hot.position.as_mut_slice());
        visitor.f64s("velocity", hot.velocity.as_mut_slice());
        visitor.f64s("spin", hot.spin.as_mut_slice());
        visitor.f64s("radius", std::slice::from_mut(&mut hot.radius));
        visitor.f64s("weight", std::slice::from_mut(&mut hot.weight));
        visitor.f64s("mass", std::slice::from_mut(&mut hot.mass));
        let mut mover = cold.mover.code();
        visitor.u8("mover", &mut mover);
        cold.mover = Mover::from_code(mover);
        visitor.f64s("origin", cold.origin.as_mut_slice());
        visit_image::<S>(&mut cold.image, visitor);
        visitor.f64s("home", cold.home.as_mut_slice());
        visitor.f64s("script", cold.script.as_mut_slice());
    }
}

/// Partners from here on are bodies: contacts of grains with them are kept beside those with grains.
const FIRST_BODY: u64 = u64::MAX - 255;

/// The name of body `body` as a partner; above every grain's, so that sums over partners end with the bodies.
pub fn body_partner(body: u8) -> GrainId {
    GrainId(FIRST_BODY + u64::from(body))
}

/// Whether a partner is a body.
pub fn is_body(partner: GrainId) -> bool {
    partner.0 >= FIRST_BODY
}

/// Which body a partner is.
pub fn body_of_partner(partner: GrainId) -> Option<usize> {
    partner.0.checked_sub(FIRST_BODY).map(|body| body as usize)
}

/// What a grain's penalty spring remembers as it rests on disk.
#[derive(Clone, Debug)]
pub struct PenaltySpringRow<S: Space> {
    /// Whose it is.
    pub grain: GrainId,
    /// Changes of velocity until the next exchange, m/s.
    pub spring: PenaltySpring<S>,
}

impl<S: Space> Record for PenaltySpringRow<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("grain", &mut self.grain.0);
        self.spring.visit(visitor);
    }
}

/// A touching contact as it rests on disk.
#[derive(Clone, Debug)]
pub struct ContactRow {
    /// The grain of the lower id.
    pub lower: GrainId,
    /// The other grain, or a body ([`body_partner`]), which is above all grains.
    pub higher: GrainId,
    /// Words of the law, in the orientation lower to higher id.
    pub memory: Memory,
}

impl Record for ContactRow {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("lower", &mut self.lower.0);
        visitor.u64("higher", &mut self.higher.0);
        visitor.f64s("memory", self.memory.words_mut());
    }
}

/// A number per axis as lanes of one.
#[inline(always)]
pub fn lanes<V: Linear, C: Words<f64>>(vector: &V) -> C {
    let mut components = C::zero();
    for index in 0..C::COUNT {
        components.set_word(index, vector[index]);
    }
    components
}

/// And back.
#[inline(always)]
pub fn vector<V: Linear, C: Words<f64>>(components: &C) -> V {
    let mut vector = V::zero();
    for index in 0..C::COUNT {
        vector[index] = components.word(index);
    }
    vector
}
