//! Forces: one pass over pairs that writes per pair, one pass over grains that sums its pairs. Apart, because then no
//! two threads write to one place and every sum has one order.

use rayon::prelude::*;

use crate::dem::grains::{GrainRow, Grains, Mover};
use crate::dem::neighbours::{Neighbours, Pair};
use crate::ids::GrainId;
use crate::law::contact::{ContactLaw, Touch};
use crate::space::{Linear, Space};

/// What a pair gives to its two grains. Force on `b` is the opposite of that on `a`; torques are per grain.
#[derive(Clone, Copy, Debug)]
pub struct PairForce<S: Space> {
    pub force: S::Vector,
    pub torque_a: S::Spin,
    pub torque_b: S::Spin,
}

impl<S: Space> PairForce<S> {
    fn none() -> Self {
        Self { force: S::Vector::zero(), torque_a: S::Spin::zero(), torque_b: S::Spin::zero() }
    }
}

/// Listed pairs with their memories and forces.
#[derive(Clone, Debug)]
pub struct Contacts<S: Space, C: ContactLaw<S>> {
    pub neighbours: Neighbours<S>,
    /// Blank where the pair does not touch.
    pub memory: Vec<C::Memory>,
    pub forces: Vec<PairForce<S>>,
}

impl<S: Space, C: ContactLaw<S>> Default for Contacts<S, C> {
    fn default() -> Self {
        Self { neighbours: Neighbours::default(), memory: Vec::new(), forces: Vec::new() }
    }
}

/// Rows of pairs or grains that one task handles; a constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1024;

/// Separation of a pair: unit normal from `b` to `a`, distance of centres and overlap.
fn geometry<S: Space>(grains: &Grains<S>, pair: &Pair<S>) -> Option<(S::Vector, f64)> {
    let (a, b) = (&grains.hot[pair.a as usize], &grains.hot[pair.b as usize]);
    let separation = a.position - b.position + pair.shift;
    let reach = a.radius + b.radius;
    let square = separation.dot(&separation);
    if square >= reach * reach {
        return None;
    }
    let distance = square.sqrt();
    Some((separation * (1.0 / distance), reach - distance))
}

impl<S: Space, C: ContactLaw<S>> Contacts<S, C> {
    /// New list for `grains`; the memories that owned rows carry find their pairs.
    pub fn rebuild(&mut self, grains: &Grains<S>, carried: &[Vec<(GrainId, C::Memory)>], period: f64, skin: f64) {
        self.neighbours = Neighbours::build(grains, period, skin);
        let pairs = &self.neighbours.pairs;
        self.memory.clear();
        self.memory.resize(pairs.len(), C::Memory::zero());
        self.forces.clear();
        self.forces.resize(pairs.len(), PairForce::none());
        for (row, memories) in carried.iter().enumerate() {
            let terms =
                &self.neighbours.terms[self.neighbours.starts[row] as usize..self.neighbours.starts[row + 1] as usize];
            // Both run in the order of partner ids: memories are moved along, not searched for.
            let mut carried = memories.iter().peekable();
            for term in terms {
                let pair = &pairs[term.pair as usize];
                let partner = grains.cold[if term.is_a { pair.b } else { pair.a } as usize].id;
                while carried.next_if(|(id, _)| *id < partner).is_some() {}
                if let Some((_, memory)) = carried.next_if(|(id, _)| *id == partner) {
                    self.memory[term.pair as usize] = *memory;
                }
            }
        }
    }

    /// Memories of the touching contacts of an owned row, in the order of partner ids.
    pub fn carried_by(&self, grains: &Grains<S>, row: usize) -> Vec<(GrainId, C::Memory)> {
        let neighbours = &self.neighbours;
        neighbours.terms[neighbours.starts[row] as usize..neighbours.starts[row + 1] as usize]
            .iter()
            .filter(|term| self.memory[term.pair as usize] != C::Memory::zero())
            .map(|term| {
                let pair = &neighbours.pairs[term.pair as usize];
                let partner = if term.is_a { pair.b } else { pair.a };
                (grains.cold[partner as usize].id, self.memory[term.pair as usize])
            })
            .collect()
    }

    /// Pair pass and grain pass. Memories advance by `advance` seconds (zero at the very first evaluation of a run).
    pub fn evaluate(&mut self, law: &C, grains: &mut Grains<S>, advance: f64) {
        self.pair_pass(law, grains, advance);
        self.grain_pass(grains);
    }

    fn pair_pass(&mut self, law: &C, grains: &Grains<S>, advance: f64) {
        let pairs = &self.neighbours.pairs;
        (pairs.par_chunks(CHUNK), self.memory.par_chunks_mut(CHUNK), self.forces.par_chunks_mut(CHUNK))
            .into_par_iter()
            .for_each(|(pairs, memories, forces)| {
                for ((pair, memory), force) in pairs.iter().zip(memories).zip(forces) {
                    *force = pair_force(law, grains, pair, memory, advance);
                }
            });
    }

    fn grain_pass(&self, grains: &mut Grains<S>) {
        let neighbours = &self.neighbours;
        (grains.force.par_chunks_mut(CHUNK), grains.torque.par_chunks_mut(CHUNK)).into_par_iter().enumerate().for_each(
            |(chunk, (forces, torques))| {
                for (offset, (force, torque)) in forces.iter_mut().zip(torques).enumerate() {
                    let row = chunk * CHUNK + offset;
                    let (mut sum, mut turn) = (S::Vector::zero(), S::Spin::zero());
                    for term in &neighbours.terms[neighbours.starts[row] as usize..neighbours.starts[row + 1] as usize]
                    {
                        let pair = &self.forces[term.pair as usize];
                        if term.is_a {
                            sum += pair.force;
                            turn += pair.torque_a;
                        } else {
                            sum -= pair.force;
                            turn += pair.torque_b;
                        }
                    }
                    (*force, *torque) = (sum, turn);
                }
            },
        );
    }

    /// Elastic energy of the contacts that this rank accounts for (those whose lower id it owns), weighted, J.
    pub fn elastic_energies<'a>(&'a self, law: &'a C, grains: &'a Grains<S>) -> impl Iterator<Item = f64> + 'a {
        self.neighbours.pairs.iter().zip(&self.memory).filter_map(move |(pair, memory)| {
            if pair.a as usize >= grains.owned {
                return None;
            }
            let (_, overlap) = geometry(grains, pair)?;
            Some(pair_weight(grains, pair) * law.elastic_energy(overlap, memory))
        })
    }

    /// Love-Weber sum over the contacts of an owned row, unweighted: force times half of the branch, J; divided by the
    /// grain's share of space it is its mean stress, tension positive. Forces are those of the positions and velocities
    /// of now, reckoned on copies of the memories: looking changes nothing.
    pub fn moment(&self, law: &C, grains: &Grains<S>, row: usize) -> S::Tensor {
        let neighbours = &self.neighbours;
        let mut sum = S::Tensor::zero();
        for term in &neighbours.terms[neighbours.starts[row] as usize..neighbours.starts[row + 1] as usize] {
            let pair = &neighbours.pairs[term.pair as usize];
            if let Some((normal, overlap)) = geometry(grains, pair) {
                let mut memory = self.memory[term.pair as usize];
                let force = pair_force(law, grains, pair, &mut memory, 0.0).force;
                let reach = grains.hot[pair.a as usize].radius + grains.hot[pair.b as usize].radius;
                let half_branch = normal * (0.5 * (reach - overlap));
                // Branch and force both change sign for `b`, so the product does not.
                sum -= S::outer(&force, &half_branch) * (1.0 / pair_weight(grains, pair));
            }
        }
        sum
    }
}

/// Weight of a contact in the coupled mixture: the mean of its grains', or the free grain's own against a wall.
fn pair_weight<S: Space>(grains: &Grains<S>, pair: &Pair<S>) -> f64 {
    let (a, b) = (pair.a as usize, pair.b as usize);
    match (grains.cold[a].mover, grains.cold[b].mover) {
        (Mover::Body(_), _) => grains.hot[b].weight,
        (_, Mover::Body(_)) => grains.hot[a].weight,
        _ => 0.5 * (grains.hot[a].weight + grains.hot[b].weight),
    }
}

#[inline(always)]
fn pair_force<S: Space, C: ContactLaw<S>>(
    law: &C,
    grains: &Grains<S>,
    pair: &Pair<S>,
    memory: &mut C::Memory,
    advance: f64,
) -> PairForce<S> {
    let Some((normal, overlap)) = geometry(grains, pair) else {
        *memory = C::Memory::zero();
        return PairForce::none();
    };
    let (a, b) = (&grains.hot[pair.a as usize], &grains.hot[pair.b as usize]);
    let relative = a.velocity - b.velocity;
    let spin = a.spin * a.radius + b.spin * b.radius;
    let touch = Touch {
        normal,
        overlap,
        velocity_normal: relative.dot(&normal),
        velocity_tangential: S::tangential(&normal, &relative) - S::surface(&normal, &spin),
        advance,
    };
    let answer = law.force(&touch, memory);

    let weight = if a.weight == 1.0 && b.weight == 1.0 { 1.0 } else { pair_weight(grains, pair) };
    let tangential = answer.tangential * weight;
    let turn = S::torque(&normal, &tangential);
    PairForce {
        force: normal * (answer.normal * weight) + S::embed(&normal, &tangential),
        torque_a: turn * -(a.radius - 0.5 * overlap),
        torque_b: turn * -(b.radius - 0.5 * overlap),
    }
}

/// A row with its contacts, ready to travel.
pub fn whole_row<S: Space, C: ContactLaw<S>>(
    grains: &Grains<S>,
    contacts: &Contacts<S, C>,
    row: usize,
) -> GrainRow<S, C::Memory> {
    GrainRow { hot: grains.hot[row], cold: grains.cold[row], contacts: contacts.carried_by(grains, row) }
}
