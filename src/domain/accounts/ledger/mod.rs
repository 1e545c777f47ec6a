//! Where the work goes: an account of the energy of grains in which every term is reckoned by itself.
//!
//! Forces f(n) belong to positions x(n), velocities v(n-1/2) to the drift between x(n-1) and x(n). Velocities are taken
//! against the mean field of a cell with the gradient L, spins against its vorticity W: with y from the cell's corner,
//!
//! ```text
//! c(n-1/2) = v(n-1/2) - L(n-1/2) y(n-1),  s = w - W        no image of a grain differs in them
//! c(n+1/2) = c(n-1/2) + a(n) dt,  m a = f + m g + damping  the kicks L v dt and dL y belong to the field alone
//! T(n)     = sum m c(n-1/2).c(n+1/2)/2 + the same of spins kinetic energy at x(n)
//! T(n) - T(n-1) = sum dt/2 (m a(n-1) + m a(n)).c(n-1/2)    exactly
//! ```
//!
//! So every force works over the drifts on either side of its evaluation, half a step each, and the account closes at the
//! positions of an evaluation, where springs store what they store:
//!
//! ```text
//! W_bodies + W_gravity + W_cell + W_nodes = T(n) - T(0) + E(n) - E(0) + viscous + slip + damping + levers
//! ```
//!
//! with the powers, of contacts in the relative velocities of their sides: bodies: -f.v of whatever they hold, the
//! reaction of what they touch; gravity: m g.c; cell: -(f.L y + torque.W) of free grains and -F.L h k of contacts across
//! images, which is the stress times L times the volume; nodes: J.c/dt, J being the impulse of nodes that are shared with a
//! continuum, and of penalty springs to it, on a grain; viscous: dashpots; slip and levers: [`crate::dem::work`];
//! damping: that of [`crate::dem::motion`].
//!
//! What does not close is the error of the time step. Springs do work by the trapezoidal rule, which is off by
//! k d (D - d)/2 where a contact of stiffness k begins or ends with the overlap d in a drift that closes it by D; and the
//! plane in which laws let surfaces slide turns within a drift. Both are known contact by contact ([`Balance::made`]), and
//! both count as residual: they are what a shorter step mends. What is left without them is rounding.

use points::PointLedger;
use scree_partition::ExactSum;
use step::{Step, Sums};

use crate::base::error::Error;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::cell::Shifts;
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::law::contact::Memory;

mod elements;
pub mod points;
mod step;
#[cfg(test)]
mod tests;

/// What is booked, by slot.
#[derive(Clone, Copy)]
enum Item {
    Bodies,
    Gravity,
    Cell,
    Nodes,
    Viscous,
    Slip,
    Damping,
    Levers,
    Made,
}
const ITEMS: usize = 9;
/// Kinetic and elastic energy.
const STORES: usize = 2;

/// Work and energy since the ledger was opened, J; up to the last evaluation of forces, one step before the positions of
/// now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Work on the grains: of bodies, of gravity, of the cell's deformation, and of the nodes that they share with a continuum.
    pub work_bodies: f64,
    /// m g.c, c the velocity against the mean field.
    pub work_gravity: f64,
    /// Of stress by the velocity gradient of the cell, over its volume.
    pub work_cell: f64,
    /// With that of penalty springs to the continuum.
    pub work_nodes: f64,
    /// Kinetic energy against the mean field, and elastic energy, now and at the opening.
    pub kinetic: f64,
    /// Of the springs of contacts.
    pub elastic: f64,
    /// At the opening.
    pub kinetic_start: f64,
    /// At the opening.
    pub elastic_start: f64,
    /// Lost in dashpots of contacts, but for tangential ones of contacts that slide.
    pub viscous: f64,
    /// Lost by sliding and rolling beyond the limits of friction, with springs that were forgotten, and by contacts that
    /// broke in tension. Where a law's tangential stiffness depends on the overlap, what that costs or yields is in it.
    /// Where a dashpot pulls harder than friction allows, the linear laws load the spring against it, out of nothing that
    /// is then lost in the dashpot: of the two losses only the sum is never less than nothing.
    pub friction: f64,
    /// Lost to local and mass damping.
    pub damping: f64,
    /// Lost because laws let surfaces slide with full radii while their forces act where the surfaces meet.
    pub levers: f64,
    /// Known error of the time step: energy that springs gave and never had. It stands on neither side, so that it is
    /// what does not close.
    pub made: f64,
}

/// Columns of what has become of the work, as [`Balance::spent`] has them: residual in shares of the work done, the others in J.
pub const SPENT: [&str; 6] = [
    "energy_stored",
    "dissipated_viscous",
    "dissipated_friction",
    "dissipated_damping",
    "dissipated_levers",
    "ledger_residual",
];

impl Balance {
    /// Numbers for the columns of [`SPENT`].
    pub fn spent(&self) -> [f64; SPENT.len()] {
        [self.stored(), self.viscous, self.friction, self.damping, self.levers, self.residual()]
    }

    /// J, on the grains, of all four kinds.
    pub fn work(&self) -> f64 {
        self.work_bodies + self.work_gravity + self.work_cell + self.work_nodes
    }

    /// J; without the error of the time step ([`Self::made`]).
    pub fn dissipated(&self) -> f64 {
        self.viscous + self.friction + self.damping + self.levers
    }

    /// Kinetic and elastic energy gained.
    pub fn stored(&self) -> f64 {
        (self.kinetic - self.kinetic_start) + (self.elastic - self.elastic_start)
    }

    /// Energy residual: work that nothing accounts for.
    pub fn imbalance(&self) -> f64 {
        self.work() - self.stored() - self.dissipated()
    }

    /// The same as a share of the work done, or of the energy at the opening where that is more.
    pub fn residual(&self) -> f64 {
        let works = [self.work_bodies, self.work_gravity, self.work_cell, self.work_nodes];
        let work = works.into_iter().map(f64::abs).sum::<f64>();
        let scale = work.max(self.kinetic_start + self.elastic_start);
        if scale > 0.0 { self.imbalance() / scale } else { 0.0 }
    }
}

/// The account of this rank; sums of ranks are exact, so that nothing depends on who booked what.
#[derive(Clone, Debug)]
pub struct EnergyLedger<S: Space> {
    /// Up to the last evaluation.
    booked: ExactSum<ITEMS>,
    /// Of its forces over the half step behind it.
    ahead: ExactSum<ITEMS>,
    /// At the opening; none before the first evaluation.
    start: Option<ExactSum<STORES>>,
    /// At the last evaluation; none before the first one here.
    stored: Option<ExactSum<STORES>>,
    page: Page<S>,
}

/// What a step changes and the account needs.
#[derive(Clone, Debug)]
struct Page<S: Space> {
    /// Velocity (m/s) and spin (rad/s) of owned rows.
    motion: Vec<(S::Vector, S::Spin)>,
    memories: Vec<f64>,
    memories_of_walls: Vec<Memory>,
    bodies: Vec<(S::Vector, S::Spin)>,
    /// Velocity gradient of the cell, 1/s.
    gradient: S::Tensor,
}

/// A sum of the ledger as it rests on disk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    quanta_low: u64,
    quanta_high: i64,
    load: u64,
}

impl Record for Entry {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("quanta_low", &mut self.quanta_low);
        visitor.i64("quanta_high", &mut self.quanta_high);
        visitor.u64("load", &mut self.load);
    }
}

impl Entry {
    pub(crate) fn all_of<const N: usize>(sums: &ExactSum<N>) -> impl Iterator<Item = Self> + '_ {
        (0..N).map(|slot| {
            let (quanta, load) = sums.parts(slot);
            Self { quanta_low: quanta as u64, quanta_high: (quanta >> 64) as i64, load }
        })
    }

    /// Refuses an account of another size than this program keeps.
    pub(crate) fn expect(entries: &[Self], count: usize, what: &str) -> Result<(), Error> {
        if entries.len() == count {
            return Ok(());
        }
        Err(Error::Run(format!(
            "the checkpoint's account of {what} has {} entries where {count} are kept: it was written by another version of the program; resume with that one",
            entries.len()
        )))
    }

    pub(crate) fn take_all<const N: usize>(entries: &mut impl Iterator<Item = Self>) -> ExactSum<N> {
        let mut sums = ExactSum::new();
        for (slot, entry) in (0..N).zip(entries) {
            let quanta = i128::from(entry.quanta_high) << 64 | i128::from(entry.quanta_low);
            sums.set_parts(slot, (quanta, entry.load));
        }
        sums
    }
}

/// Entries of a ledger.
const ENTRIES: usize = 2 * ITEMS + STORES;

impl<S: Space> EnergyLedger<S> {
    fn new() -> Self {
        let page = Page {
            motion: Vec::new(),
            memories: Vec::new(),
            memories_of_walls: Vec::new(),
            bodies: Vec::new(),
            gradient: S::Tensor::zero(),
        };
        Self { booked: ExactSum::new(), ahead: ExactSum::new(), start: None, stored: None, page }
    }
}

/// Of whose energy an account is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Accounts {
    /// Whether a [`Balance`] is kept.
    pub grains: bool,
    /// Whether a [`points::PointBalance`] is kept, of points or elements.
    pub points: bool,
}

impl Accounts {
    /// Grains alone.
    pub const GRAINS: Self = Self { grains: true, points: false };
    /// Points or elements alone.
    pub const POINTS: Self = Self { grains: false, points: true };
}

impl<S: Space> World<'_, S> {
    /// Keeps account of energy from the next step on.
    pub fn open_accounts(&mut self, of: Accounts) {
        self.ledger = of.grains.then(|| Box::new(EnergyLedger::new()));
        self.point_ledger = PointLedger::default();
        if of.points {
            self.point_ledger.open();
        }
    }

    /// The account so far, the same on every rank. Collective.
    pub fn balance(&self) -> Result<Balance, Error> {
        let sums =
            self.ledger.as_ref().and_then(|ledger| Some((ledger, ledger.start.clone()?, ledger.stored.clone()?)));
        let Some((ledger, start, stored)) = sums else {
            return Err(Error::Run(format!("step {}: no step has been booked in a ledger of energy", self.step)));
        };
        let [kinetic_start, elastic_start] = self.reduce(start)?;
        let [kinetic, elastic] = self.reduce(stored)?;
        let [work_bodies, work_gravity, work_cell, work_nodes, viscous, friction, damping, levers, made] =
            self.reduce(ledger.booked.clone())?;
        Ok(Balance {
            work_bodies,
            work_gravity,
            work_cell,
            work_nodes,
            kinetic,
            elastic,
            kinetic_start,
            elastic_start,
            viscous,
            friction,
            damping,
            levers,
            made,
        })
    }

    /// Accounts as they are stored, that of grains first, the same on every rank; empty where none is kept, or nothing has been booked
    /// yet. Collective.
    pub fn ledger_entries(&self) -> Result<Vec<Entry>, Error> {
        let mut entries = self.entries_of_grains()?;
        entries.extend(self.point_ledger_entries()?);
        Ok(entries)
    }

    fn entries_of_grains(&self) -> Result<Vec<Entry>, Error> {
        let Some((ledger, start)) = self.ledger.as_ref().and_then(|ledger| Some((ledger, ledger.start.clone()?)))
        else {
            return Ok(Vec::new());
        };
        let booked = self.total(ledger.booked.clone())?;
        let ahead = self.total(ledger.ahead.clone())?;
        let start = self.total(start)?;
        Ok(Entry::all_of(&booked).chain(Entry::all_of(&ahead)).chain(Entry::all_of(&start)).collect())
    }

    /// Whether a step has been booked; the same on every rank.
    pub fn has_balance(&self) -> bool {
        self.ledger.as_ref().is_some_and(|ledger| ledger.start.is_some() && ledger.stored.is_some())
    }

    /// Goes on with accounts that were stored; none opens new ones. A branch that keeps none has no use for those of its run.
    pub fn resume_accounts(&mut self, of: Accounts, entries: &[Entry]) -> Result<(), Error> {
        self.open_accounts(of);
        if entries.is_empty() || of == Accounts::default() {
            return Ok(());
        }
        let sizes = [(of.grains, ENTRIES), (of.points, points::ENTRIES)];
        let kept = sizes.into_iter().filter(|(is_kept, _)| *is_kept).map(|(_, entries)| entries).sum();
        Entry::expect(entries, kept, "energies")?;
        // One rank keeps what all have booked so far.
        let ours = self.transport.rank() == 0;
        let mut entries = entries.iter().map(|entry| if ours { *entry } else { Entry::default() });
        if let Some(ledger) = &mut self.ledger {
            ledger.booked = Entry::take_all(&mut entries);
            ledger.ahead = Entry::take_all(&mut entries);
            ledger.start = Some(Entry::take_all(&mut entries));
        }
        self.point_ledger.go_on(&mut entries);
        Ok(())
    }

    pub(crate) fn total<const N: usize>(&self, sums: ExactSum<N>) -> Result<ExactSum<N>, Error> {
        sums.total(self.transport).map_err(|error| self.out_of_range(&error))
    }

    /// Before a step: what it is going to change.
    pub(crate) fn open_page(&mut self) {
        self.point_ledger.open_page(self.bodies.iter().map(|body| (body.velocity, body.spin)));
        let Some(ledger) = &mut self.ledger else { return };
        let page = &mut ledger.page;
        let owned = self.assembly.grains.hot[..self.assembly.grains.owned].iter();
        page.motion.clear();
        page.motion.extend(owned.map(|hot| (hot.velocity, hot.spin)));
        page.memories.clear();
        page.memories.extend_from_slice(self.assembly.contacts.memories());
        page.memories_of_walls.clear();
        page.memories_of_walls.extend(self.assembly.walls.list.iter().map(|wall| wall.memory));
        page.bodies.clear();
        page.bodies.extend(self.bodies.iter().map(|body| (body.velocity, body.spin)));
        page.gradient = self.assembly.cell.gradient;
    }

    /// After the kicks of a step, before its drift: books the work of its forces.
    pub(crate) fn close_page(&mut self) {
        let Some(mut ledger) = self.ledger.take() else { return };
        let timer = self.phases.start();
        let (mut cell_before, mut cell_after) = (self.assembly.cell, self.assembly.cell);
        cell_before.gradient = ledger.page.gradient;
        cell_after.rate = self.assembly.cell.gradient * self.assembly.cell.edges;
        let step = Step {
            law: self.law(),
            field: &self.settings.grains.field,
            dt: self.settings.grains.dt,
            share: self.kick_share(),
            passed: if self.step == 0 { 0.0 } else { self.settings.grains.dt },
            coupled: self.is_coupled(),
            grains: &self.assembly.grains,
            contacts: &self.assembly.contacts,
            bodies: &self.bodies,
            page: &ledger.page,
            cells: [&cell_before, &cell_after],
            shifts_after: Shifts::of(&cell_after),
        };
        let Sums { behind, ahead, stored } = step.sums(&self.assembly.walls);
        match &ledger.start {
            // Forces of the first evaluation work from then on.
            None => ledger.start = Some(stored.clone()),
            Some(_) => {
                ledger.booked.merge(&ledger.ahead);
                ledger.booked.merge(&behind);
            }
        }
        (ledger.ahead, ledger.stored) = (ahead, Some(stored));
        self.ledger = Some(ledger);
        self.phases.stop(Phase::Output, timer);
    }
}
