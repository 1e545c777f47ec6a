//! Tiles: the nodes of each block with their margin, as rows. Behind the rows of this rank's tiles stand rows received from
//! other ranks, so that summing and spreading are the same for a neighbour here and a neighbour elsewhere.

use std::marker::PhantomData;

use rayon::prelude::*;

use crate::base::ids::Row;
use crate::base::space::{Linear, Space};
use crate::base::zeroed::Zeroed;
use crate::mpm::face_rows::FaceRows;
use crate::mpm::share::{Along, Share};
use crate::mpm::surface::SurfaceRows;
use crate::mpm::volumetric::VolumetricNode;
use crate::numbers;

/// Words of a node's row: a line of the cache, changed all in step.
pub const NODE_WORDS: usize = 8;

const NODES_PER_TASK: usize = 512;

/// What points and membranes bring to a node, weighted: mass (kg), momentum (N s), and internal and external force (N); in the
/// plane the mass of membranes along themselves, `sum m N t t` (kg), follows. In this order; the other words are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Gathered<S: Space>(pub [f64; NODE_WORDS], PhantomData<S>);

/// What grains bring to a node, weighted: mass, kg; momentum after their own kick and what their penalty springs have given them, N s;
/// and of this what penalty springs have given, which the continuum has to give back. In this order; the other words are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct GrainNode<S: Space>(pub [f64; NODE_WORDS], PhantomData<S>);

/// What a node gives back to points: its velocity after the step (m/s), the change of it, and the mean volume strain of what flows, in
/// this order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Advanced<S: Space>(pub [f64; NODE_WORDS], PhantomData<S>);

/// What a node gives back to grains: the continuum's share of the node's mass, by which penalty springs hold; change of their velocities,
/// m/s; the node's velocity times the share, m/s; and in the plane what the share is less by along membranes. In this order;
/// the other words are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct GrainChange<S: Space>(pub [f64; NODE_WORDS], PhantomData<S>);

numbers!(impl[S: Space] GrainNode[S] { 0: [f64; NODE_WORDS], 1: PhantomData<S> });
numbers!(impl[S: Space] GrainChange[S] { 0: [f64; NODE_WORDS], 1: PhantomData<S> });

fn vector_at<S: Space>(words: &[f64; NODE_WORDS], first: usize) -> S::Vector {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = words[first + axis];
    }
    vector
}

impl<S: Space> Gathered<S> {
    /// Of a node that nothing reaches.
    pub const fn zero() -> Self {
        Self([0.0; NODE_WORDS], PhantomData)
    }

    /// Words in the order of [`Gathered`].
    pub fn of(words: [f64; NODE_WORDS]) -> Self {
        Self(words, PhantomData)
    }

    /// Of points and membranes, kg.
    pub fn mass(&self) -> f64 {
        self.0[0]
    }

    /// N s.
    pub fn momentum(&self) -> S::Vector {
        vector_at::<S>(&self.0, 1)
    }

    /// Internal and external, N.
    pub fn force(&self) -> S::Vector {
        vector_at::<S>(&self.0, 1 + S::DIMENSION)
    }

    /// N.
    pub fn add_force(&mut self, force: &S::Vector) {
        for axis in 0..S::DIMENSION {
            self.0[1 + S::DIMENSION + axis] += force[axis];
        }
    }

    /// Adds a mass (kg), its momentum (N s) and a force (N).
    pub fn bring(&mut self, mass: f64, momentum: &S::Vector, force: &S::Vector) {
        self.0[0] += mass;
        for axis in 0..S::DIMENSION {
            self.0[1 + axis] += momentum[axis];
        }
        self.add_force(force);
    }

    /// Adds the mass of a membrane along itself, kg. There are membranes in the plane alone.
    pub fn bring_along(&mut self, mass: &Along, weight: f64) {
        debug_assert_eq!(S::DIMENSION, 2, "behind two vectors of space there is no room for a tensor");
        for (word, mass) in self.0[5..].iter_mut().zip(mass) {
            *word += mass * weight;
        }
    }

    /// Mass of membranes along themselves, kg.
    pub fn along(&self) -> Along {
        tensor_of::<S>(&self.0)
    }

    /// N s; mass and force stay.
    pub fn set_momentum(&mut self, momentum: &S::Vector) {
        for axis in 0..S::DIMENSION {
            self.0[1 + axis] = momentum[axis];
        }
    }

    fn add(&mut self, other: &Self) {
        add_words(&mut self.0, &other.0);
    }
}

/// The tensor behind a number and two vectors, in the plane.
fn tensor_of<S: Space>(words: &[f64; NODE_WORDS]) -> Along {
    match S::DIMENSION {
        2 => [words[5], words[6], words[7]],
        _ => [0.0; 3],
    }
}

fn add_words(words: &mut [f64; NODE_WORDS], more: &[f64; NODE_WORDS]) {
    for (word, more) in words.iter_mut().zip(more) {
        *word += more;
    }
}

/// Words of a record that begins with a number and has two vectors behind it.
fn led<S: Space>(first: f64, vectors: [&S::Vector; 2]) -> [f64; NODE_WORDS] {
    let mut words = [0.0; NODE_WORDS];
    words[0] = first;
    for axis in 0..S::DIMENSION {
        words[1 + axis] = vectors[0][axis];
        words[1 + S::DIMENSION + axis] = vectors[1][axis];
    }
    words
}

/// The words that a message has of a record.
fn received(message: &[f64]) -> [f64; NODE_WORDS] {
    let mut words = [0.0; NODE_WORDS];
    words[..message.len()].copy_from_slice(message);
    words
}

impl<S: Space> GrainNode<S> {
    /// Of a node without grains.
    pub const fn zero() -> Self {
        Self([0.0; NODE_WORDS], PhantomData)
    }

    /// Of a mass, kg, its momentum, N s, and what of this penalty springs have given, N s.
    pub fn new(mass: f64, momentum: &S::Vector, given: &S::Vector) -> Self {
        Self(led::<S>(mass, [momentum, given]), PhantomData)
    }

    /// Weighted, kg.
    pub fn mass(&self) -> f64 {
        self.0[0]
    }

    /// N s, with what penalty springs have given.
    pub fn momentum(&self) -> S::Vector {
        vector_at::<S>(&self.0, 1)
    }

    /// What penalty springs have given of the momentum, N s.
    pub fn given(&self) -> S::Vector {
        vector_at::<S>(&self.0, 1 + S::DIMENSION)
    }

    fn add(&mut self, other: &Self) {
        add_words(&mut self.0, &other.0);
    }

    /// Its first numbers, as many as the message has room for.
    pub fn write(&self, message: &mut [f64]) {
        message.copy_from_slice(&self.0[..message.len()]);
    }

    /// From a message, as [`Self::write`] fills it; words that it has no room for are zero.
    pub fn read(message: &[f64]) -> Self {
        Self(received(message), PhantomData)
    }
}

impl<S: Space> GrainChange<S> {
    /// Nothing changes, and nothing holds grains.
    pub const fn zero() -> Self {
        Self([0.0; NODE_WORDS], PhantomData)
    }

    /// Of a change (m/s) at a node that goes at `velocity` (m/s) and holds its grains by `share`.
    pub fn new(share: &Share<S>, change: &S::Vector, velocity: &S::Vector) -> Self {
        let mut words = led::<S>(share.all, [change, &share.of(velocity)]);
        if S::DIMENSION == 2 {
            words[5..].copy_from_slice(&share.along);
        }
        Self::of(words)
    }

    /// Words in the order of [`GrainChange`].
    pub fn of(words: [f64; NODE_WORDS]) -> Self {
        Self(words, PhantomData)
    }

    /// By which penalty springs hold.
    pub fn share(&self) -> Share<S> {
        Share::new(self.0[0], tensor_of::<S>(&self.0))
    }

    /// Change of the grains' velocities, m/s.
    pub fn velocity(&self) -> S::Vector {
        vector_at::<S>(&self.0, 1)
    }

    /// The node's velocity times the share, m/s.
    pub fn shared(&self) -> S::Vector {
        vector_at::<S>(&self.0, 1 + S::DIMENSION)
    }

    /// Its first numbers, as many as the message has room for.
    pub fn write(&self, message: &mut [f64]) {
        message.copy_from_slice(&self.0[..message.len()]);
    }

    /// From a message, as [`Self::write`] fills it; words that it has no room for are zero.
    pub fn read(message: &[f64]) -> Self {
        Self(received(message), PhantomData)
    }
}

impl<S: Space> Advanced<S> {
    /// Of a node without mass.
    pub const fn zero() -> Self {
        Self([0.0; NODE_WORDS], PhantomData)
    }

    /// Words in the order of [`Advanced`].
    pub fn of(words: [f64; NODE_WORDS]) -> Self {
        Self(words, PhantomData)
    }

    /// Where the mean volume strain stands among the words.
    pub const VOLUME: usize = 2 * S::DIMENSION;

    /// Of a velocity after the step and its change, m/s, and the mean volume strain of what flows.
    pub fn new(velocity: &S::Vector, change: &S::Vector, volume: f64) -> Self {
        let mut words = [0.0; NODE_WORDS];
        for axis in 0..S::DIMENSION {
            words[axis] = velocity[axis];
            words[S::DIMENSION + axis] = change[axis];
        }
        words[Self::VOLUME] = volume;
        Self::of(words)
    }

    /// After the step, m/s.
    pub fn velocity(&self) -> S::Vector {
        vector_at::<S>(&self.0, 0)
    }

    /// Of the velocity in the step, m/s.
    pub fn change(&self) -> S::Vector {
        vector_at::<S>(&self.0, S::DIMENSION)
    }
}

/// How far a node is in the continuum's step, where grains take several within it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride<S: Space> {
    /// Steps of grains that the node has taken with them.
    pub taken: u64,
    /// Velocity that points brought, m/s; of nodes that have taken any.
    pub brought: S::Vector,
}

impl<S: Space> Stride<S> {
    /// At the beginning of a step of the continuum.
    pub fn zero() -> Self {
        Self { taken: 0, brought: S::Vector::zero() }
    }
}

/// Tiles that share nodes with other ranks' tiles, or those that share none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// Some block around is another rank's: rows of these tiles travel.
    Border,
    /// All blocks around are this rank's: their turn comes while rows of the others travel.
    Inner,
}

/// Where the tiles of this rank lie and which rows make up which node. Laid once per deal of blocks to ranks.
#[derive(Clone, Debug, Default)]
pub struct Mosaic {
    /// Margins counted.
    pub nodes_per_tile: usize,
    /// Tiles of this rank.
    pub tiles: usize,
    /// By tile.
    pub tiers: Vec<Tier>,
    /// Rows received before summing, and before gathering.
    pub rows_received: usize,
    /// Rows received before gathering, behind those of tiles.
    pub rows_spread: usize,
    /// Rows of the nodes that this rank's blocks own, with their global node, in block order.
    pub owned: Vec<OwnedNode>,
    /// Sources of owned node i: `sources[source_starts[i]..source_starts[i + 1]]`, in neighbour order (invariant 2).
    pub source_starts: Vec<u32>,
    /// Rows of tiles; from [`Self::rows`] on received ones.
    pub sources: Vec<Row>,
    /// Margin rows of tiles and the row they copy after the nodes have advanced; those of tile t are
    /// `copies[copy_starts[t]..copy_starts[t + 1]]`.
    pub copies: Vec<(Row, Row)>,
    /// One for each tile, and the end.
    pub copy_starts: Vec<u32>,
}

/// A node and the row where its owner keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnedNode {
    /// Among those of this rank's tiles.
    pub row: Row,
    /// Lattice coordinates; the third is zero in the plane.
    pub place: [i32; 3],
}

impl Mosaic {
    /// Nodes that a block owns; those of a block follow on one another.
    pub fn owned_per_tile(&self) -> usize {
        (self.owned.len() / self.tiles.max(1)).max(1)
    }

    /// Tiles whose nodes together are worth a task.
    pub fn tiles_per_task(&self) -> usize {
        NODES_PER_TASK.div_ceil(self.owned_per_tile())
    }

    /// Rows of tiles and of what other ranks send before summing.
    pub fn rows(&self) -> usize {
        self.tiles * self.nodes_per_tile
    }

    /// Sum of `rows` (tiles first, received ones behind) at every owned node, in the one order of neighbours.
    pub fn sum<T: Copy + Send + Sync>(&self, rows: &[T], zero: T, add: impl Fn(&mut T, &T) + Sync) -> Vec<T> {
        let mut sums = vec![zero; self.owned.len()];
        self.sum_into(|_| true, rows, zero, &add, &mut sums);
        sums
    }

    /// [`Self::sum`] without allocation, at the nodes that the tiles which are wanted own.
    fn sum_into<T: Copy + Send + Sync>(
        &self,
        wanted: impl Fn(usize) -> bool + Sync,
        rows: &[T],
        zero: T,
        add: impl Fn(&mut T, &T) + Sync,
        sums: &mut [T],
    ) {
        let per_tile = self.owned_per_tile();
        let tiles = sums.par_chunks_mut(per_tile).with_min_len(self.tiles_per_task()).enumerate();
        tiles.filter(|(tile, _)| wanted(*tile)).for_each(|(tile, sums)| {
            for (sum, starts) in sums.iter_mut().zip(self.source_starts[tile * per_tile..].windows(2)) {
                *sum = zero;
                for &source in &self.sources[starts[0] as usize..starts[1] as usize] {
                    add(sum, &rows[source as usize]);
                }
            }
        });
    }

    /// Rows that make up an owned node, in the one order of neighbours.
    pub fn sources_of(&self, number: usize) -> &[Row] {
        &self.sources[self.source_starts[number] as usize..self.source_starts[number + 1] as usize]
    }

    /// Margin rows of the tiles that are wanted, and the rows that they copy.
    pub fn copies_of(&self, wanted: impl Fn(usize) -> bool) -> impl Iterator<Item = &(Row, Row)> {
        let starts = self.copy_starts.windows(2).enumerate().filter(move |(tile, _)| wanted(*tile));
        starts.flat_map(|(_, starts)| &self.copies[starts[0] as usize..starts[1] as usize])
    }
}

/// Node rows of this rank. Rows of grains are laid where grains and points share nodes.
#[derive(Clone, Debug)]
pub struct Tiles<S: Space> {
    /// By tile row, received ones behind.
    pub gathered: Vec<Gathered<S>>,
    /// Of owned nodes, over all tiles.
    pub sums: Vec<Gathered<S>>,
    /// By tile row, received ones behind.
    pub advanced: Vec<Advanced<S>>,
    /// Laid where volume strain is averaged.
    pub volumetric: Vec<VolumetricNode>,
    /// Of owned nodes, over all tiles; laid where volume strain is averaged.
    pub volumetric_sums: Vec<VolumetricNode>,
    /// Of grains, written in tiles that grains may come to alone: a zone is a small part of the domain.
    pub grains: Zeroed<GrainNode<S>>,
    /// Of owned nodes, over all tiles.
    pub grain_sums: Zeroed<GrainNode<S>>,
    /// By tile row, received ones behind.
    pub grain_changes: Zeroed<GrainChange<S>>,
    /// Of owned nodes.
    pub strides: Vec<Stride<S>>,
    /// Tiles that grains may come to: steps of grains pass all others by.
    pub shared: Vec<bool>,
    /// Of bodies that meet points at their own face.
    pub faces: FaceRows<S>,
    /// Of loads on the surface.
    pub surface: SurfaceRows<S>,
}

impl<S: Space> Default for Tiles<S> {
    fn default() -> Self {
        Self {
            gathered: Vec::new(),
            sums: Vec::new(),
            advanced: Vec::new(),
            volumetric: Vec::new(),
            volumetric_sums: Vec::new(),
            grains: Zeroed::new(0),
            grain_sums: Zeroed::new(0),
            grain_changes: Zeroed::new(0),
            strides: Vec::new(),
            shared: Vec::new(),
            faces: FaceRows::default(),
            surface: SurfaceRows::default(),
        }
    }
}

impl<S: Space> Tiles<S> {
    /// Rows of zeros: for grains where they are `coupled` to points, for volume strain where the scheme `averages` it.
    pub fn lay(mosaic: &Mosaic, coupled: bool, averages: bool) -> Self {
        let (gathered, advanced) = (mosaic.rows() + mosaic.rows_received, mosaic.rows() + mosaic.rows_spread);
        let of_grains = |rows: usize| if coupled { rows } else { 0 };
        let of_volume = |rows: usize| vec![VolumetricNode::ZERO; if averages { rows } else { 0 }];
        Self {
            gathered: vec![Gathered::zero(); gathered],
            sums: vec![Gathered::zero(); mosaic.owned.len()],
            advanced: vec![Advanced::zero(); advanced],
            volumetric: of_volume(gathered),
            volumetric_sums: of_volume(mosaic.owned.len()),
            grains: Zeroed::new(of_grains(gathered)),
            grain_sums: Zeroed::new(of_grains(mosaic.owned.len())),
            grain_changes: Zeroed::new(of_grains(advanced)),
            strides: vec![Stride::zero(); of_grains(mosaic.owned.len())],
            shared: vec![false; of_grains(mosaic.tiles)],
            faces: FaceRows::default(),
            surface: SurfaceRows::default(),
        }
    }

    /// Which tiles grains may come to from now on. Rows of those that they could come to are zero again, and so are those from
    /// other ranks.
    pub fn share(&mut self, mosaic: &Mosaic, shared: Vec<bool>) {
        let (len, per_tile, rows) = (mosaic.nodes_per_tile, mosaic.owned_per_tile(), mosaic.rows());
        for (tile, _) in self.shared.iter().enumerate().filter(|(_, shared)| **shared) {
            self.grains[tile * len..][..len].fill(GrainNode::zero());
            self.grain_sums[tile * per_tile..][..per_tile].fill(GrainNode::zero());
            self.grain_changes[tile * len..][..len].fill(GrainChange::zero());
        }
        self.grains[rows..].fill(GrainNode::zero());
        self.grain_changes[rows..].fill(GrainChange::zero());
        self.shared = shared;
    }

    /// Sums over all tiles at the nodes that those of a tier own: of points, of volume strain and of grains, where these are laid.
    pub fn sum(&mut self, mosaic: &Mosaic, tier: Tier) {
        let wanted = |tile: usize| mosaic.tiers[tile] == tier;
        mosaic.sum_into(wanted, &self.gathered, Gathered::zero(), Gathered::add, &mut self.sums);
        if !self.volumetric.is_empty() {
            let sums = &mut self.volumetric_sums;
            mosaic.sum_into(wanted, &self.volumetric, VolumetricNode::ZERO, VolumetricNode::add, sums);
        }
        if !self.grains.is_empty() {
            self.sum_grains(mosaic, tier);
        }
    }

    /// The same of grains alone, in tiles that they may come to.
    pub fn sum_grains(&mut self, mosaic: &Mosaic, tier: Tier) {
        let wanted = |tile: usize| mosaic.tiers[tile] == tier && self.shared[tile];
        mosaic.sum_into(wanted, &self.grains, GrainNode::zero(), GrainNode::add, &mut self.grain_sums);
    }

    /// Fills the margins of the tiles of one tier from the owners' rows.
    pub fn copy_margins(&mut self, mosaic: &Mosaic, tier: Tier) {
        for &(to, from) in mosaic.copies_of(|tile| mosaic.tiers[tile] == tier) {
            self.advanced[to as usize] = self.advanced[from as usize];
        }
        if !self.grain_changes.is_empty() {
            self.copy_margins_of_grains(mosaic, tier);
        }
    }

    /// The same of what grains take, in tiles that they may come to.
    pub fn copy_margins_of_grains(&mut self, mosaic: &Mosaic, tier: Tier) {
        for &(to, from) in mosaic.copies_of(|tile| mosaic.tiers[tile] == tier && self.shared[tile]) {
            self.grain_changes[to as usize] = self.grain_changes[from as usize];
        }
    }
}
