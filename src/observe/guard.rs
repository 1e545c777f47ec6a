//! What tells that a run has left physics: overlaps that no contact law means, and energy that nobody has put in.

use scree_partition::ExactSum;

use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::space::{Linear, Space};
use crate::world::World;

/// Energy and work at the last look.
#[derive(Clone, Copy, Debug, Default)]
pub struct EnergyGuard {
    last: Option<Look>,
}

#[derive(Clone, Copy, Debug)]
struct Look {
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
    /// Stops a run of grains whose energy has grown by more than the work done on them explains.
    pub fn look<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>>(
        &mut self,
        world: &mut World<'_, S, C, L>,
    ) -> Result<(), Error> {
        if world.grains_total == 0 || world.points_total > 0 {
            self.last = None;
            return Ok(());
        }
        let now = world.look()?;
        let before = self.last.replace(now);
        let Some(before) = before else { return Ok(()) };
        let passed = (now.step - before.step) as f64 * world.settings.dt;
        let put_in = (now.work - before.work).max(0.0) + now.power.abs().max(before.power.abs()) * passed;
        if now.energy <= GROWTH_MAX * (before.energy + put_in) {
            return Ok(());
        }
        let pair = world.deepest_pair().map_or_else(String::new, |(share, [a, b])| {
            format!("; the deepest contact is that of grains {a} and {b}, {:.0} % of the smaller radius", 100.0 * share)
        });
        Err(Error::Run(format!(
            "step {}, time {:.6e} s: the grains' energy has grown from {:.3e} to {:.3e} J since step {} while {put_in:.3e} J of work were done{pair}; the run is unstable: shorten `time.step` or lower the damping of contacts",
            now.step,
            world.time(),
            before.energy,
            now.energy,
            before.step,
        )))
    }
}

impl<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> World<'_, S, C, L> {
    fn look(&mut self) -> Result<Look, Error> {
        let energies = self.energies()?;
        let mut fallen = ExactSum::<1>::new();
        for (hot, cold) in self.grains.hot[..self.grains.owned].iter().zip(&self.grains.cold) {
            let place = hot.position + self.cell.shift(cold.image);
            fallen.add(0, hot.mass * place.dot(&self.settings.field.gravity));
        }
        let [gravity] = self.reduce(fallen)?;
        let power = match self.cell.gradient == S::Tensor::zero() {
            true => 0.0,
            false => self.contact_moment_now()?.dot(&self.cell.gradient),
        };
        Ok(Look {
            step: self.step,
            energy: energies.kinetic_grains + energies.elastic_grains,
            work: gravity + self.bodies.iter().map(|body| body.work).sum::<f64>(),
            power,
        })
    }

    /// The deepest contact of the world as a share of its smaller radius, with the ids of its grains; equal ones by the
    /// lowest ids.
    pub fn deepest_pair(&mut self) -> Option<(f64, [u64; 2])> {
        self.refresh_ghosts();
        let mine = self.contacts.deepest(&self.grains);
        let mut bytes = Vec::new();
        if let Some((share, [a, b])) = mine {
            bytes.extend([share.to_bits(), a.0, b.0].iter().flat_map(|word| word.to_le_bytes()));
        }
        let all = self.transport.all_gather(&bytes);
        let found = all.iter().filter_map(|bytes| {
            let [share, a, b] = *bytes.as_chunks::<8>().0 else { return None };
            Some((f64::from_le_bytes(share), [u64::from_le_bytes(a), u64::from_le_bytes(b)]))
        });
        found.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))
    }

    /// Stops the run where a pair overlaps by more than `share` of its smaller radius.
    pub fn refuse_deep_overlaps(&mut self, share: f64) -> Result<(), Error> {
        match if self.grains_total > 0 { self.deepest_pair() } else { None } {
            Some((deepest, [a, b])) if deepest.is_nan() || deepest > share => Err(Error::Run(format!(
                "step {}, time {:.6e} s: grains {a} and {b} overlap by {:.0} % of the smaller radius, {:.0} % is the most that a contact law means; the run is unstable or far too loaded for its stiffness: shorten `time.step` or take stiffer contacts, and go on from an earlier checkpoint",
                self.step,
                self.time(),
                100.0 * deepest,
                100.0 * share
            ))),
            _ => Ok(()),
        }
    }

    /// Bytes of this rank's arrays of grains, contacts, lists and messages.
    pub fn bytes(&self) -> usize {
        let halo: usize = self.ghosts.sends.iter().map(|(_, rows)| rows.capacity() * size_of::<u32>()).sum();
        self.grains.bytes() + self.contacts.bytes() + self.walls.bytes() + halo + self.buffers.bytes()
    }

    /// Contacts of the whole world that hold now.
    pub fn contact_count(&mut self) -> u64 {
        self.refresh_ghosts();
        let mut counts = [self.contacts.count(&self.settings.contact, &self.grains) as i64];
        self.transport.sum(&mut counts);
        counts[0] as u64
    }
}
