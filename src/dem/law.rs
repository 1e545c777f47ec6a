//! A contact law as those hold it who need not know which it is. What a law reckons is compiled for each; what calls it is
//! compiled once, and asks once for a whole stretch of pairs, or for one contact where a single one is looked at.

use std::fmt::Debug;
use std::sync::Arc;

use crate::base::compiled::of_space;
use crate::base::space::{Plane, Solid, Space, Words};
use crate::dem::kernel::{Given, Pass, evaluate, give};
use crate::dem::neighbours::Pair;
use crate::law::contact::{Absent, Answer, Contact, ContactLaw, ForAnyLaw, Memory, Springs, Touch};

/// [`ContactLaw`] with memories in words; every contact law is one of these.
pub trait Law<S: Space>: Debug + Send + Sync {
    /// Words of what a contact remembers.
    fn memory_words(&self) -> usize;
    /// How far apart surfaces may be and still hold on to each other, m.
    fn reach(&self) -> f64;
    /// Whole packs of pairs, on this thread. `memory` holds `[pack][word][lane]`, `forces` `[pair][word]`.
    fn evaluate(&self, pass: &Pass<S>, pairs: &[Pair], memory: &mut [f64], forces: &mut [f64]);
    /// Whether the contact exists, by what it remembers.
    fn holds(&self, touch: &Touch<S, f64>, memory: &Memory) -> bool;
    /// Forces of a contact with `weight`, their torques by the lever arms of both sides, m; nothing where it does not hold.
    fn give(&self, touch: &Touch<S, f64>, weight: f64, arms: [f64; 2], memory: &mut Memory) -> Given<S, f64>;
    /// Velocity at which the tangential spring stretches, m/s.
    fn sliding(&self, touch: &Touch<S, f64>) -> S::TangentOf<f64>;
    /// What the springs alone answer in a contact that holds, by its memory after the evaluation; not weighted.
    fn springs(&self, touch: &Touch<S, f64>, memory: &Memory) -> Answer<S, f64>;
    /// Springs and dashpots at an overlap (m). Radii in m, masses in kg as a touch has them.
    fn stiffness(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs;
    /// The most that spring and dashpot may carry along the surface together, N, at a normal force (N); not weighted.
    fn friction_limit(&self, touch: &Touch<S, f64>, normal: f64) -> f64;
    /// Of a contact that holds, J, not weighted; with a blank memory, that of the normal spring alone.
    fn elastic_energy(&self, touch: &Touch<S, f64>, memory: &Memory) -> f64;
}

impl<S: Space, C: ContactLaw<S>> Law<S> for C {
    fn memory_words(&self) -> usize {
        <C::Memory<f64> as Words<f64>>::COUNT
    }
    fn reach(&self) -> f64 {
        ContactLaw::<S>::reach(self)
    }
    fn evaluate(&self, pass: &Pass<S>, pairs: &[Pair], memory: &mut [f64], forces: &mut [f64]) {
        evaluate(self, pass, pairs, memory, forces);
    }
    fn holds(&self, touch: &Touch<S, f64>, memory: &Memory) -> bool {
        ContactLaw::holds(self, touch, &memory.to())
    }
    fn give(&self, touch: &Touch<S, f64>, weight: f64, arms: [f64; 2], memory: &mut Memory) -> Given<S, f64> {
        let mut advanced = memory.to();
        let given = give(self, touch, weight, arms, &mut advanced);
        *memory = Memory::of(&advanced);
        given
    }
    fn sliding(&self, touch: &Touch<S, f64>) -> S::TangentOf<f64> {
        ContactLaw::sliding(self, touch)
    }
    fn springs(&self, touch: &Touch<S, f64>, memory: &Memory) -> Answer<S, f64> {
        ContactLaw::springs(self, touch, &memory.to())
    }
    fn stiffness(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
        ContactLaw::<S>::stiffness(self, radii, masses, overlap)
    }
    fn friction_limit(&self, touch: &Touch<S, f64>, normal: f64) -> f64 {
        ContactLaw::friction_limit(self, touch, normal)
    }
    fn elastic_energy(&self, touch: &Touch<S, f64>, memory: &Memory) -> f64 {
        ContactLaw::elastic_energy(self, touch, &memory.to())
    }
}

/// A law with its constants, as worlds share it.
pub type SharedLaw<S> = Arc<dyn Law<S>>;

/// The law that a job names.
pub fn law_of<S: Space>(contact: &Contact) -> SharedLaw<S> {
    of_space::<Named<S>>([&NAMED.0, &NAMED.1])(contact)
}

type Named<S> = fn(&Contact) -> SharedLaw<S>;
static NAMED: (Named<Plane>, Named<Solid>) = (|contact| contact.apply(Unnamed), |contact| contact.apply(Unnamed));

/// That of worlds without grains.
pub fn no_law<S: Space>() -> SharedLaw<S> {
    Arc::new(Absent)
}

/// Words of what a contact remembers under that law.
pub fn memory_words<S: Space>(contact: &Contact) -> usize {
    law_of::<S>(contact).memory_words()
}

struct Unnamed;

impl<S: Space> ForAnyLaw<S> for Unnamed {
    type Outcome = SharedLaw<S>;

    fn with<C: ContactLaw<S>>(self, law: &C) -> Self::Outcome {
        Arc::new(*law)
    }
}
