//! What tells that a run has left physics: overlaps that no contact law means, and energy that nobody has put in.

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::contacts::deeper;
use crate::dem::grains::body_of_partner;
use crate::domain::world::World;

/// Energy and work at the last look; part of a run's state, so that a run that is taken up is stopped where it would have been.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyGuard {
    last: Look,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Look {
    /// Nothing has been looked at before the first.
    step: u64,
    /// Kinetic and elastic energy of grains, J.
    energy: f64,
    /// Work done on the grains by bodies and gravity since the start, J, and its rate by the cell's deformation, W.
    work: f64,
    power: f64,
}

/// Energy may come to this multiple of what it was with the work done since, before the run counts as unstable. Energy
/// fluctuates within a step's error, an instability doubles it within some tens of steps.
const GROWTH_MAX: f64 = 2.0;

impl EnergyGuard {
    /// What a run of grains is told whose energy has grown by more than the work done on them explains.
    pub fn look<S: Space>(&mut self, world: &mut World<'_, S>) -> Result<Option<String>, Error> {
        if world.grains_total == 0 || world.points_total > 0 {
            *self = Self::default();
            return Ok(None);
        }
        let now = world.look()?;
        let before = std::mem::replace(&mut self.last, now);
        if before.step == 0 {
            return Ok(None);
        }
        let passed = (now.step - before.step) as f64 * world.settings.grains.dt;
        let put_in = (now.work - before.work).max(0.0) + now.power.abs().max(before.power.abs()) * passed;
        if now.energy <= GROWTH_MAX * (before.energy + put_in) {
            return Ok(None);
        }
        let pair = world.deepest_contact().filter(|contact| contact.share > 0.0).map_or_else(String::new, |contact| {
            format!(
                "; the deepest contact is that of {}, {:.0} % of {}",
                world.name(&contact),
                100.0 * contact.share,
                contact.share_of()
            )
        });
        Ok(Some(format!(
            "step {}, time {:.6e} s: the grains' energy has grown from {:.3e} to {:.3e} J since step {} while {put_in:.3e} J of work were done{pair}; the run is unstable: shorten `time.step` or lower the damping of contacts",
            now.step,
            world.time(),
            before.energy,
            now.energy,
            before.step,
        )))
    }
}

impl Record for EnergyGuard {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("guard_step", &mut self.last.step);
        visitor.f64s("guard_energy", std::slice::from_mut(&mut self.last.energy));
        visitor.f64s("guard_work", std::slice::from_mut(&mut self.last.work));
        visitor.f64s("guard_power", std::slice::from_mut(&mut self.last.power));
    }
}

/// A contact between two grains, or of a grain with a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deepest {
    /// Overlap as a share of the smaller radius.
    pub share: f64,
    /// The second may stand for a body.
    pub ids: [GrainId; 2],
}

impl Deepest {
    /// What the overlap is a share of.
    fn share_of(&self) -> &'static str {
        if body_of_partner(self.ids[1]).is_some() { "the grain's radius" } else { "the smaller radius" }
    }
}

impl<S: Space> World<'_, S> {
    fn look(&mut self) -> Result<Look, Error> {
        let energies = self.energies()?;
        let mut fallen = ExactSum::<1>::new();
        for (hot, cold) in self.assembly.grains.hot[..self.assembly.grains.owned].iter().zip(&self.assembly.grains.cold)
        {
            let place = hot.position + self.assembly.cell.shift(cold.image);
            fallen.add(0, hot.mass * place.dot(&self.settings.grains.field.gravity));
        }
        let [gravity] = self.reduce(fallen)?;
        let power = match self.assembly.cell.gradient == S::Tensor::zero() {
            true => 0.0,
            false => self.contact_moment()?.dot(&self.assembly.cell.gradient),
        };
        Ok(Look {
            step: self.step,
            energy: energies.kinetic_grains + energies.elastic_grains,
            work: gravity + self.bodies.iter().map(|body| body.work).sum::<f64>(),
            power,
        })
    }

    /// The deepest contact of the world, of equal ones that of the lowest ids.
    pub fn deepest_contact(&mut self) -> Option<Deepest> {
        self.refresh_ghosts();
        let of_walls = self.assembly.walls.deepest(&self.assembly.grains, (&self.bodies, &self.assembly.cell));
        let mine = self.assembly.contacts.deepest(&self.assembly.grains).into_iter().chain(of_walls);
        let words = mine.flat_map(|(share, [a, b])| [share.to_bits(), a.0, b.0]);
        let bytes: Vec<u8> = words.flat_map(u64::to_le_bytes).collect();
        let all = self.transport.all_gather(&bytes);
        let found = all.iter().flat_map(|bytes| bytes.as_chunks::<24>().0).map(|bytes| {
            let word = |at: usize| u64::from_le_bytes(*bytes[8 * at..].first_chunk().expect("three words"));
            (f64::from_bits(word(0)), [1, 2].map(|at| GrainId(word(at))))
        });
        found.max_by(deeper).map(|(share, ids)| Deepest { share, ids })
    }

    /// Stops the run where a grain overlaps another or a body by more than `share` of its radius.
    pub fn refuse_deep_overlaps(&mut self, share: f64) -> Result<(), Error> {
        match if self.grains_total > 0 { self.deepest_contact() } else { None } {
            Some(contact) if contact.share.is_nan() || contact.share > share => Err(Error::Run(format!(
                "step {}, time {:.6e} s: {} overlap by {:.0} % of {}, {:.0} % is the most that a contact law means; the run is unstable or far too loaded for its stiffness: shorten `time.step` or take stiffer contacts, and go on from an earlier checkpoint",
                self.step,
                self.time(),
                self.name(&contact),
                100.0 * contact.share,
                contact.share_of(),
                100.0 * share
            ))),
            _ => Ok(()),
        }
    }

    fn name(&self, contact: &Deepest) -> String {
        let [a, b] = contact.ids;
        match body_of_partner(b) {
            None => format!("grains {} and {}", a.0, b.0),
            Some(body) => format!("grain {} and body `{}`", a.0, self.bodies[body].name),
        }
    }

    /// Bytes of this rank's arrays of grains, contacts, lists and messages.
    pub fn bytes(&self) -> usize {
        let halo: usize = self.subdomain.ghosts.sends.iter().map(|(_, rows)| rows.capacity() * size_of::<u32>()).sum();
        self.assembly.grains.bytes()
            + self.assembly.contacts.bytes()
            + self.assembly.walls.bytes()
            + halo
            + self.subdomain.buffers.bytes()
    }

    /// Contacts of the whole world that hold now.
    pub fn contact_count(&mut self) -> u64 {
        self.refresh_ghosts();
        let mut counts = [self.assembly.contacts.count(self.law(), &self.assembly.grains) as i64];
        self.transport.sum(&mut counts);
        counts[0] as u64
    }
}
