//! Node rows of bodies that meet points at their own face: laid as [`crate::mpm::tile::Tiles`], worked on in the tiles near faces alone.

use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::mpm::askew::{AskewRows, Outline};
use crate::mpm::faces::{Brought, ColumnNode, FaceSet, SIDES};
use crate::mpm::tile::Mosaic;

/// A node that faces act on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met<S: Space> {
    /// See [`ColumnNode::velocities`], as faces have left them so far.
    pub velocities: [S::Vector; 2],
    /// Of what moves with it, kg; zero without points.
    pub mass: f64,
    /// Time over which forces have acted, s.
    pub dt: f64,
    /// Whether faces in line with the grid act on it, and such as are askew to it.
    pub by: [bool; 2],
    /// What the face on each side gave it in the last step, N s.
    pub impulses: [S::Vector; SIDES],
}

impl<S: Space> Met<S> {
    pub fn untouched(velocities: [S::Vector; 2], mass: f64, dt: f64) -> Self {
        Self { velocities, mass, dt, by: [false; 2], impulses: [S::Vector::zero(); SIDES] }
    }
}

/// Whether a body acts at its face on a node that is met so ([`Met::by`]), and does not hold it as well.
pub fn is_met_by<S: Space>(by: [bool; 2], body: &Body<S>) -> bool {
    body.meets_points && by[usize::from(body.is_askew())]
}

/// Impulses for the velocity to be held and for that by which parting is judged, N s.
pub type Impulses<S> = [<S as Space>::Vector; 2];

/// Empty where no body meets points.
#[derive(Clone, Debug)]
pub struct FaceRows<S: Space> {
    pub set: Option<FaceSet>,
    /// Sides that material is in front of, in the order in which they act; the same on every rank.
    pub sides: Vec<usize>,
    /// Tiles of this rank that may have points near faces.
    pub near: Vec<bool>,
    /// By tile row, and of owned nodes.
    pub brought: Vec<Brought>,
    pub sums: Vec<Brought>,
    /// By tile row.
    pub columns: Vec<ColumnNode<S>>,
    pub impulses: Vec<Impulses<S>>,
    /// Of owned nodes.
    pub met: Vec<Met<S>>,
    pub askew: AskewRows<S>,
}

impl<S: Space> Default for FaceRows<S> {
    fn default() -> Self {
        Self {
            set: None,
            sides: Vec::new(),
            near: Vec::new(),
            brought: Vec::new(),
            sums: Vec::new(),
            columns: Vec::new(),
            impulses: Vec::new(),
            met: Vec::new(),
            askew: AskewRows::default(),
        }
    }
}

impl<S: Space> FaceRows<S> {
    pub fn lay(mosaic: &Mosaic) -> Self {
        let (gathered, spread) = (mosaic.rows() + mosaic.rows_received, mosaic.rows() + mosaic.rows_spread);
        Self {
            set: None,
            sides: Vec::new(),
            near: vec![false; mosaic.tiles],
            brought: vec![Brought::ZERO; gathered],
            sums: vec![Brought::ZERO; mosaic.owned.len()],
            columns: vec![ColumnNode::zero(); spread],
            impulses: vec![[S::Vector::zero(); 2]; gathered],
            met: vec![Met::untouched([S::Vector::zero(); 2], 0.0, 0.0); mosaic.owned.len()],
            askew: AskewRows::default(),
        }
    }

    /// Faces as they are now, and which tiles they are near to. Rows of tiles that they have left, or have come to, are zero.
    pub fn place(&mut self, mosaic: &Mosaic, set: FaceSet, near: Vec<bool>) {
        let len = mosaic.nodes_per_tile;
        for tile in (0..mosaic.tiles).filter(|tile| self.near[*tile] || near[*tile]) {
            self.brought[tile * len..][..len].fill(Brought::ZERO);
            self.columns[tile * len..][..len].fill(ColumnNode::zero());
            self.impulses[tile * len..][..len].fill([S::Vector::zero(); 2]);
        }
        if !set.askew.is_empty() {
            self.askew.brought.resize(mosaic.rows() + mosaic.rows_received, Outline::ZERO);
            self.askew.sums.resize(mosaic.owned.len(), Outline::ZERO);
            for tile in (0..mosaic.tiles).filter(|tile| self.near[*tile] || near[*tile]) {
                self.askew.brought[tile * len..][..len].fill(Outline::ZERO);
            }
        }
        (self.set, self.near) = (Some(set), near);
    }

    /// Whether a tile of this rank may have points near faces.
    pub fn is_near(&self, tile: usize) -> bool {
        self.near.get(tile) == Some(&true)
    }

    /// Tiles near faces, and the nodes that they own.
    fn tiles(&self) -> Vec<usize> {
        (0..self.near.len()).filter(|tile| self.near[*tile]).collect()
    }

    pub fn owned(&self, mosaic: &Mosaic) -> impl Iterator<Item = usize> + use<S> {
        let per_tile = mosaic.owned_per_tile();
        self.tiles().into_iter().flat_map(move |tile| tile * per_tile..(tile + 1) * per_tile)
    }

    /// Sums of all tiles at the nodes that tiles near faces own, in the one order of neighbours.
    pub fn sum(&mut self, mosaic: &Mosaic) {
        for number in self.owned(mosaic) {
            let sum = &mut self.sums[number];
            *sum = Brought::ZERO;
            mosaic.sources_of(number).iter().for_each(|source| sum.add(&self.brought[*source as usize]));
        }
    }

    /// The same of what askew faces ask for.
    pub fn sum_askew(&mut self, mosaic: &Mosaic) {
        for number in self.owned(mosaic) {
            let sum = &mut self.askew.sums[number];
            *sum = Outline::ZERO;
            mosaic.sources_of(number).iter().for_each(|source| sum.add(&self.askew.brought[*source as usize]));
        }
    }

    /// A node that faces act on, by its number among the owned ones; none away from them, or where no material is in front of one.
    pub fn met_at(&self, mosaic: &Mosaic, number: usize) -> Option<&Met<S>> {
        self.met_by(mosaic, number).contains(&true).then(|| &self.met[number])
    }

    /// See [`Met::by`].
    pub fn met_by(&self, mosaic: &Mosaic, number: usize) -> [bool; 2] {
        match self.is_near(number / mosaic.owned_per_tile()) {
            true => [self.sums[number].has_area(), self.askew.sums.get(number).is_some_and(Outline::is_reached)],
            false => [false; 2],
        }
    }

    /// For each side whether any material is in front of it at the nodes that this rank owns: 1 or 0.
    pub fn sides_met(&self, mosaic: &Mosaic) -> [i64; SIDES] {
        let mut met = [0; SIDES];
        for number in self.owned(mosaic) {
            for (side, met) in met.iter_mut().enumerate() {
                *met |= i64::from(self.sums[number].area(side) != 0.0);
            }
        }
        met
    }

    /// What owned nodes show to the columns of a side.
    pub fn show(&mut self, mosaic: &Mosaic, side: usize) {
        for number in self.owned(mosaic) {
            let (brought, Met { velocities, mass, .. }) = (&self.sums[number], self.met[number]);
            let (area, touch) = (brought.area(side), brought.touch(side));
            self.columns[mosaic.owned[number].row as usize] = ColumnNode { mass, area, touch, velocities };
        }
    }

    /// Margins of tiles near faces from the owners' rows.
    pub fn copy_margins(&mut self, mosaic: &Mosaic) {
        for &(to, from) in mosaic.copies_of(|tile| self.near[tile]) {
            self.columns[to as usize] = self.columns[from as usize];
        }
    }

    /// No column has acted on the tiles near faces.
    pub fn clear_impulses(&mut self, mosaic: &Mosaic) {
        let len = mosaic.nodes_per_tile;
        for tile in self.tiles() {
            self.impulses[tile * len..][..len].fill([S::Vector::zero(); 2]);
        }
    }

    /// Nodes take what the columns of a side give them.
    pub fn take(&mut self, mosaic: &Mosaic, side: usize) {
        for number in self.owned(mosaic) {
            let mass = self.met[number].mass;
            if mass <= 0.0 {
                continue;
            }
            let mut sums = [S::Vector::zero(); 2];
            for source in mosaic.sources_of(number) {
                let impulses = &self.impulses[*source as usize];
                sums.iter_mut().zip(impulses).for_each(|(sum, impulse)| *sum += *impulse);
            }
            let met = &mut self.met[number];
            met.velocities.iter_mut().zip(&sums).for_each(|(velocity, impulse)| *velocity += *impulse * (1.0 / mass));
            met.impulses[side] = sums[0];
        }
    }
}
