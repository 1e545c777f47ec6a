//! What tells that a run has left physics: overlaps that no contact law means.

use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::space::Space;
use crate::transfer;
use crate::world::World;

impl<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> World<'_, S, C, L> {
    /// Stops the run where a pair overlaps by more than `share` of its smaller radius.
    pub fn refuse_deep_overlaps(&mut self, share: f64) -> Result<(), Error> {
        if self.grains_total == 0 {
            return Ok(());
        }
        self.refresh_ghosts();
        let outcome = match self.contacts.deepest(&self.grains) {
            Some((deepest, [a, b])) if !(deepest <= share) => Err(Error::Run(format!(
                "step {}, time {:.6e} s: grains {} and {} overlap by {:.0} % of the smaller radius, {:.0} % is the most that a contact law means; the run is unstable or far too loaded for its stiffness: shorten `time.step` or take stiffer contacts, and go on from an earlier checkpoint",
                self.step,
                self.time(),
                a.0,
                b.0,
                100.0 * deepest,
                100.0 * share
            ))),
            _ => Ok(()),
        };
        transfer::agree(self.transport, outcome)
    }

    /// Contacts of the whole world that hold now.
    pub fn contact_count(&mut self) -> u64 {
        self.refresh_ghosts();
        let mut counts = [self.contacts.count(&self.settings.contact, &self.grains) as i64];
        self.transport.sum(&mut counts);
        counts[0] as u64
    }
}
