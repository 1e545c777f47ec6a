//! An RVE between two increments, as it travels and lies on disk: what moves and what contacts remember. Radii, masses and constants are
//! those of a template that all RVEs of a material share, and lists are made again from where grains were when they were made, so that
//! every later bit is the same.

use std::sync::Arc;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Space};
use crate::dem::assembly::Constants;
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::sample::Sample;
use crate::law::contact::Memory;
use crate::rve::drive::Grain;
use crate::rve::volume_element::{Rve, State};

/// A packing that RVEs begin from.
#[derive(Clone, Debug)]
pub struct Packing {
    /// Radius, m, and mass, kg, of its grains by id.
    pub grains: Arc<[[f64; 2]]>,
    /// How they lie as it was made; former programs did not keep it.
    pub laid: Option<Arc<Arrangement>>,
}

/// Grains in their cell, in the plane with zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// From the corner of the cell, m.
    pub places: Vec<[f64; 3]>,
    /// One after the other, m.
    pub edges: [f64; 9],
}

impl Arrangement {
    fn of<S: Space>(sample: &Sample<S>) -> Self {
        let cell = &sample.assembly.cell;
        let place = |position: S::Vector| {
            let place = position - cell.corner;
            std::array::from_fn(|axis| if axis < S::DIMENSION { place[axis] } else { 0.0 })
        };
        let mut edges = [0.0; 9];
        for component in 0..S::Tensor::COMPONENTS {
            edges[3 * (component / S::DIMENSION) + component % S::DIMENSION] = cell.edges[component];
        }
        Self { places: sample.assembly.grains.hot.iter().map(|hot| place(hot.position)).collect(), edges }
    }

    /// Its cell.
    pub fn cell<S: Space>(&self) -> Cell<S> {
        let mut cell = Cell::cuboid(S::Vector::zero(), S::Vector::zero(), [true; 3]);
        let mut edges = S::Tensor::zero();
        for component in 0..S::Tensor::COMPONENTS {
            edges[component] = self.edges[3 * (component / S::DIMENSION) + component % S::DIMENSION];
        }
        cell.arrive(edges);
        cell
    }
}

/// What RVEs of one material have in common.
#[derive(Clone, Debug)]
pub struct Template<S: Space> {
    /// Radii and masses of its grains, and how they lay.
    pub packing: Packing,
    /// Their mean diameter, density and time step.
    pub grain: Grain,
    /// Law of contacts, field and time step of its grains.
    pub constants: Constants<S>,
    /// What the space's measure is multiplied with to give m3.
    pub depth: f64,
}

/// All that an RVE is beside its template.
#[derive(Clone, Debug, PartialEq)]
pub struct Resting<S: Space> {
    /// Its deformation and what it has come through.
    pub state: State<S>,
    /// Cells of now and of when lists were made.
    pub cells: [Cell<S>; 2],
    /// Steps of its grains.
    pub step: u64,
    /// Position and velocity, spin, and where the grain was when lists were made, by grain.
    pub motions: Vec<f64>,
    /// Grains of contacts that remember something, the lower first, and what they remember.
    pub contacts: Vec<[u16; 2]>,
    /// Contact after contact, as many words of each as the law has.
    pub memories: Vec<f64>,
}

impl<S: Space> Resting<S> {
    /// Numbers of a grain.
    pub const MOTION: usize = 3 * S::DIMENSION + <S::Spin as Linear>::COMPONENTS;

    /// Bytes that its grains and contacts take.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.motions) + size_of_val(&*self.contacts) + size_of_val(&*self.memories)
    }
}

impl<S: Space> Template<S> {
    /// Of an assembly as it was made.
    pub fn of(sample: &Sample<S>, depth: f64) -> Self {
        let Sample { assembly, constants, .. } = sample;
        let grains = assembly.grains.hot.iter().map(|hot| [hot.radius, hot.mass]).collect();
        Self::new(Packing { grains, laid: Some(Arc::new(Arrangement::of(sample))) }, constants.clone(), depth)
    }

    /// Of a packing.
    pub fn new(packing: Packing, constants: Constants<S>, depth: f64) -> Self {
        let grains = &packing.grains;
        let solid: f64 = grains.iter().map(|[radius, _]| S::grain_volume(*radius, depth)).sum();
        let mass: f64 = grains.iter().map(|[_, mass]| mass).sum();
        let diameter = 2.0 * grains.iter().map(|[radius, _]| radius).sum::<f64>() / grains.len() as f64;
        Self { grain: Grain { diameter, density: mass / solid, dt: constants.dt }, packing, constants, depth }
    }
}

impl<S: Space> Rve<S> {
    /// Contacts that remember something.
    pub fn remembered(&self) -> usize {
        let contacts = &self.sample().assembly.contacts;
        let pairs = 0..contacts.neighbours.pairs_in_order().len();
        pairs.filter(|pair| !contacts.recall(*pair).is_blank()).count()
    }

    /// What it is now.
    pub fn rest(&self) -> Resting<S> {
        let sample = self.sample();
        let (grains, contacts) = (&sample.assembly.grains, &sample.assembly.contacts);
        let mut motions = Vec::with_capacity(grains.owned * Resting::<S>::MOTION);
        for (hot, home) in grains.hot.iter().zip(&grains.homes) {
            motions.extend((0..S::DIMENSION).map(|axis| hot.position[axis]));
            motions.extend((0..S::DIMENSION).map(|axis| hot.velocity[axis]));
            motions.extend((0..S::Spin::COMPONENTS).map(|axis| hot.spin[axis]));
            motions.extend((0..S::DIMENSION).map(|axis| home[axis]));
        }
        let (mut pairs, mut memories) = (Vec::new(), Vec::new());
        for (index, pair) in contacts.neighbours.pairs_in_order().iter().enumerate() {
            let memory = contacts.recall(index);
            if !memory.is_blank() {
                pairs.push([pair.a, pair.b()].map(|row| row as u16));
                memories.extend_from_slice(memory.words());
            }
        }
        Resting {
            state: self.state().clone(),
            cells: [sample.assembly.cell, sample.assembly.cell_home],
            step: sample.step,
            motions,
            contacts: pairs,
            memories,
        }
    }

    /// The RVE that was [`Self::rest`]ing.
    pub fn wake(template: &Template<S>, resting: &Resting<S>) -> Result<Self, Error> {
        let count = resting.motions.len() / Resting::<S>::MOTION;
        // What was replicated has twice the grains, which stand together.
        let grains = &template.packing.grains;
        let copies = count / grains.len();
        let width = template.constants.law().memory_words();
        let mut rows: Vec<GrainRow<S>> = Vec::with_capacity(count);
        for (number, motion) in resting.motions.chunks_exact(Resting::<S>::MOTION).enumerate() {
            let [radius, mass] = grains[number / copies];
            let mut row = GrainRow::<S>::resting(GrainId(number as u64), S::Vector::zero(), radius, mass, Mover::Free);
            let (vectors, rest) = motion.split_at(2 * S::DIMENSION);
            let (spin, home) = rest.split_at(S::Spin::COMPONENTS);
            for axis in 0..S::DIMENSION {
                row.hot.position[axis] = vectors[axis];
                row.hot.velocity[axis] = vectors[S::DIMENSION + axis];
                row.cold.home[axis] = home[axis];
            }
            (0..S::Spin::COMPONENTS).for_each(|axis| row.hot.spin[axis] = spin[axis]);
            rows.push(row);
        }
        for (number, [lower, higher]) in resting.contacts.iter().enumerate() {
            let memory = Memory::of_words(&resting.memories[number * width..(number + 1) * width]);
            rows[*lower as usize].contacts.push((GrainId(u64::from(*higher)), memory));
            rows[*higher as usize].contacts.push((GrainId(u64::from(*lower)), memory));
        }
        for row in &mut rows {
            row.contacts.sort_unstable_by_key(|(partner, _)| *partner);
        }
        let mut sample = Sample::in_order(resting.cells, &rows, template.constants.clone())?;
        sample.step = resting.step;
        Ok(Self::of(sample, template.clone(), resting.state.clone()))
    }
}
