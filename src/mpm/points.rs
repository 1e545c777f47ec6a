//! Material points as rows: what a step reads and writes apart from what is needed now and then.

use crate::base::ids::{PointId, Row};
use crate::base::numbers::Numbers;
use crate::base::record::{Record, Visitor};
use crate::base::rows::Moved;
use crate::base::space::{Linear, Space, Words};
use crate::base::symmetric::Symmetric;
use crate::dem::cell::{Image, visit_image};
use crate::mpm::track::{Track, Window};
use crate::mpm::volumetric::Volumetric;
use crate::numbers;

/// The part of a point that every step reads and writes: numbers alone, so that eight of them go side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hot<S: Space> {
    /// m; wrapped into the period at rebuilds only.
    pub position: S::Vector,
    /// Velocity half a step behind the position, m/s.
    pub velocity: S::Vector,
    /// kg; full, never weighted.
    pub mass: f64,
    /// Volume at the start, m3; Kirchhoff stress is per this volume.
    pub volume: f64,
    /// Share of the point in the coupled mixture: 1, or about 1 - w in the reconciliation zone.
    pub weight: f64,
    /// Kirchhoff stress, Pa, tension positive.
    pub stress: S::Symmetric,
    /// Deformation gradient F since the start.
    pub deformation: S::Tensor,
    /// Memory of the material law, in words.
    pub memory: S::PointMemory,
    /// Energy dissipated since the start, J per initial volume, m3.
    pub plastic_work: f64,
}

numbers!(impl[S: Space] Hot[S] {
    position: S::Vector,
    velocity: S::Vector,
    mass: f64,
    volume: f64,
    weight: f64,
    stress: S::Symmetric,
    deformation: S::Tensor,
    memory: S::PointMemory,
    plastic_work: f64,
});

/// Where the fields of [`Hot`] begin among its numbers.
impl<S: Space> Hot<S> {
    /// m, as many numbers as there are axes.
    pub const POSITION: usize = 0;
    /// m/s, as many numbers as there are axes.
    pub const VELOCITY: usize = S::DIMENSION;
    /// kg, one number.
    pub const MASS: usize = 2 * S::DIMENSION;
    /// m3, one number.
    pub const VOLUME: usize = Self::MASS + 1;
    /// One number, 0 to 1.
    pub const WEIGHT: usize = Self::MASS + 2;
    /// Pa, as many numbers as a symmetric tensor has.
    pub const STRESS: usize = Self::MASS + 3;
    /// All components, column by column.
    pub const DEFORMATION: usize = Self::STRESS + S::Symmetric::COUNT;
    /// Words of the law's memory, with room for that of any law; plastic work is behind them.
    pub const MEMORY: usize = Self::DEFORMATION + S::Tensor::COMPONENTS;
}

/// What some schemes and steps need of a point besides, in a row of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside<S: Space> {
    /// Gradient of the affine velocity field about the point, 1/s; zero where the scheme has none.
    pub affine: S::Tensor,
    /// Way to the new place while the strain is still to be taken at the old one, m; of the step, not of the state.
    pub way: S::Vector,
}

impl<S: Space> Default for Beside<S> {
    fn default() -> Self {
        Self { affine: S::Tensor::zero(), way: S::Vector::zero() }
    }
}

/// The part of a point that is read at rebuilds and for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cold<S: Space> {
    /// The same for the whole run.
    pub id: PointId,
    /// Position at the last rebuild, m: the block follows from it.
    pub home: S::Vector,
    /// Place at the start of the run, m.
    pub origin: S::Vector,
    /// Periods crossed since then.
    pub image: Image,
    /// Loads that it bears: bit n is the job's n-th; behind them the sides on which the material ends with it ([`crate::mpm::load`]).
    pub loads: u64,
}

/// What is remembered of a point as long as a band is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past<S: Space> {
    /// Plastic strain at the oracle's recent looks.
    pub window: Window,
    /// Where it has been, for training.
    pub track: Track<S>,
}

impl<S: Space> Default for Past<S> {
    fn default() -> Self {
        Self { window: Window::default(), track: Track::default() }
    }
}

/// A whole material point, as it travels, rests on disk or is handed to a new world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<S: Space> {
    /// What every step reads and writes.
    pub hot: Hot<S>,
    /// What is read at rebuilds and for output.
    pub cold: Cold<S>,
    /// See [`Beside::affine`].
    pub affine: S::Tensor,
    /// Zero where volume strain is not averaged.
    pub volumetric: Volumetric,
    /// Blank where no band is looked for.
    pub past: Past<S>,
}

/// Points of this rank in block order, within a block by (cell, id) of the last rebuild: the order of every sum over
/// points.
#[derive(Clone, Debug)]
pub struct Points<S: Space> {
    /// By row.
    pub hot: Vec<Hot<S>>,
    /// By row.
    pub cold: Vec<Cold<S>>,
    /// By row, whether the scheme needs it or not.
    pub beside: Vec<Beside<S>>,
    /// By row; zero where volume strain is not averaged.
    pub volumetric: Vec<Volumetric>,
    /// One for every row, or none at all where nothing is remembered: as much memory as the rest.
    pub pasts: Vec<Past<S>>,
    /// Rows that loads act at, with their force, N; of the step, not of the state.
    pub loaded: Vec<(Row, S::Vector)>,
    /// Whether what the points bring to nodes lies on their tiles as they are now, by the tier of the tile. Whoever changes
    /// [`Self::hot`] between steps says here that it does not.
    pub scattered: [bool; 2],
}

impl<S: Space> Default for Points<S> {
    fn default() -> Self {
        Self {
            hot: Vec::new(),
            cold: Vec::new(),
            beside: Vec::new(),
            volumetric: Vec::new(),
            pasts: Vec::new(),
            loaded: Vec::new(),
            scattered: [false; 2],
        }
    }
}

impl<S: Space> Points<S> {
    /// Rows, that is points of this rank.
    pub fn len(&self) -> usize {
        self.hot.len()
    }

    /// Whether this rank has no points.
    pub fn is_empty(&self) -> bool {
        self.hot.is_empty()
    }

    /// Whole rows, in their order.
    pub fn rows(&self) -> impl Iterator<Item = Point<S>> {
        (0..self.len()).map(|row| self.row(row))
    }

    /// A whole row; its past is blank where nothing is remembered. Panics beyond the last.
    pub fn row(&self, row: usize) -> Point<S> {
        let past = self.pasts.get(row).copied().unwrap_or_default();
        let (affine, volumetric) = (self.beside[row].affine, self.volumetric[row]);
        Point { hot: self.hot[row], cold: self.cold[row], affine, volumetric, past }
    }

    /// From now on every row has a past, for who adds to it.
    pub fn keep_pasts(&mut self) -> &mut [Past<S>] {
        assert!(self.pasts.is_empty() || self.pasts.len() == self.hot.len(), "every point has a past, or none has");
        self.pasts.resize(self.hot.len(), Past::default());
        &mut self.pasts
    }

    /// No band is looked for any more.
    pub fn forget(&mut self) {
        self.pasts = Vec::new();
    }

    /// Only those that `stays` says of, which may change them, are left, in their order. The world must settle its rows next: which are
    /// whose block's is out of date.
    pub(crate) fn retain(&mut self, stays: impl FnMut(&mut Hot<S>) -> bool) {
        let stays: Vec<bool> = self.hot.iter_mut().map(stays).collect();
        retain(&mut self.hot, &stays);
        retain(&mut self.cold, &stays);
        retain(&mut self.beside, &stays);
        retain(&mut self.volumetric, &stays);
        retain(&mut self.pasts, &stays);
        self.scattered = [false; 2];
        self.loaded.clear();
    }

    /// Takes the rows of a rebuild in place of its own.
    pub(crate) fn take_order(&mut self, moved: &Moved<Point<S>>) {
        if !self.pasts.is_empty() || moved.brings(|point| point.past != Past::default()) {
            self.pasts = moved.ordered(self.keep_pasts(), |point| point.past);
        }
        self.hot = moved.ordered(&self.hot, |point| point.hot);
        self.cold = moved.ordered(&self.cold, |point| point.cold);
        let arrived = |point: &Point<S>| Beside { affine: point.affine, way: S::Vector::zero() };
        self.beside = moved.ordered(&self.beside, arrived);
        self.volumetric = moved.ordered(&self.volumetric, |point| point.volumetric);
        self.scattered = [false; 2];
        self.loaded.clear();
    }
}

/// Leaves the rows that stay.
fn retain<T>(rows: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    rows.retain(|_| stays.next() == Some(&true));
}

impl<S: Space> Hot<S> {
    /// The stress as a tensor, Pa.
    pub fn kirchhoff(&self) -> S::Tensor {
        self.stress.tensor()
    }

    /// det F since the start.
    pub fn volume_ratio(&self) -> f64 {
        S::determinant(&self.deformation)
    }
}

impl<S: Space> Point<S> {
    /// A point at rest at `position`, its first memory and stress to be given by its law.
    pub fn resting(id: PointId, position: S::Vector, mass: f64, volume: f64) -> Self {
        Self {
            hot: Hot {
                position,
                velocity: S::Vector::zero(),
                mass,
                volume,
                weight: 1.0,
                stress: S::Symmetric::zero(),
                deformation: S::identity(),
                memory: S::PointMemory::default(),
                plastic_work: 0.0,
            },
            cold: Cold { id, home: position, origin: position, image: [0; 3], loads: 0 },
            affine: S::Tensor::zero(),
            volumetric: Volumetric::default(),
            past: Past::default(),
        }
    }
}

/// What the memory of a law is called where nobody knows the law, and what comes after it.
pub const MEMORY: &str = "memory";
/// Column of [`Hot::plastic_work`], J/m3.
pub const PLASTIC_WORK: &str = "plastic_work";
/// What averaging of volume strain knows of a point.
pub const VOLUMETRIC: &str = "volumetric";

impl<S: Space> Record for Point<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        let Self { hot, cold, affine, volumetric, past } = self;
        visitor.u64("id", &mut cold.id.0);
        visitor.f64s("position", hot.position.as_mut_slice());
        visitor.f64s("velocity", hot.velocity.as_mut_slice());
        visitor.f64s("home", cold.home.as_mut_slice());
        visitor.f64s("origin", cold.origin.as_mut_slice());
        visit_image::<S>(&mut cold.image, visitor);
        visitor.u64("loads", &mut cold.loads);
        visitor.f64s("mass", std::slice::from_mut(&mut hot.mass));
        visitor.f64s("volume", std::slice::from_mut(&mut hot.volume));
        visitor.f64s("weight", std::slice::from_mut(&mut hot.weight));
        visitor.f64s("stress", hot.stress.as_mut_slice());
        visitor.f64s("deformation", hot.deformation.as_mut_slice());
        visitor.f64s(VOLUMETRIC, volumetric.numbers_mut());
        visitor.f64s("affine", affine.as_mut_slice());
        visitor.f64s(MEMORY, hot.memory.numbers_mut());
        visitor.f64s(PLASTIC_WORK, std::slice::from_mut(&mut hot.plastic_work));
        visitor.f64s("window", &mut past.window.samples);
        past.track.visit(visitor);
    }
}
