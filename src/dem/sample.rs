//! A sample of grains that steps by itself: an assembly in a periodic cell, without ranks, bodies or anything else around it. Samples
//! are small and there may be many of them, each stepped by one thread; no step allocates but one that makes lists anew.

use std::ops::Range;
use std::sync::Arc;

use crate::base::compiled::of_space;
use crate::base::error::Error;
use crate::base::parallel::larger;
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::dem::assembly::{Assembly, Constants};
use crate::dem::cell::Cell;
use crate::dem::contacts::deeper;
use crate::dem::grains::{Cold, GrainRow, Hot, PenaltySpring};
use crate::dem::memories::Memories;
use crate::dem::motion::{Damped, Falling, Moves};
use crate::dem::segments::{Finish, Segments};
use crate::dem::strained::Strained;

/// Where a grain stands among the others, from its shares of the cell's edges: grains of one place stand together in the order of
/// their ids, and are summed together.
pub type Order<S> = Arc<dyn Fn(&<S as Space>::Vector) -> (usize, u32) + Send + Sync>;

/// Grains that nothing but their own cell moves.
#[derive(Clone)]
pub struct Sample<S: Space> {
    /// Its cell and grains, all of them owned.
    pub assembly: Assembly<S>,
    /// Time step, skin, law of contacts, field and drive.
    pub constants: Constants<S>,
    /// Steps done.
    pub step: u64,
    order: Order<S>,
    /// Rows of each place that has any.
    together: Vec<Range<usize>>,
}

type Advance<S> = fn(&mut Sample<S>) -> Result<(), Error>;
static ADVANCE: (Advance<Plane>, Advance<Solid>) = (|sample| sample.take_step(), |sample| sample.take_step());

impl<S: Space> Sample<S> {
    /// At step zero, from rows that are at home where they are.
    pub fn new(rows: &[GrainRow<S>], cell: Cell<S>, constants: Constants<S>, order: Order<S>) -> Result<Self, Error> {
        Self::of(Assembly::empty(cell), cell, rows, constants, order)
    }

    /// Of free grains which all stand together, and whose pairs are listed in the order of ids too: from rows that have come some way from
    /// home, in a cell that was the second when they were there.
    pub fn in_order(cells: [Cell<S>; 2], rows: &[GrainRow<S>], constants: Constants<S>) -> Result<Self, Error> {
        let mut assembly = Assembly::empty(cells[0]);
        assembly.contacts.neighbours.in_order = true;
        Self::of(assembly, cells[1], rows, constants, Arc::new(|_: &S::Vector| (0, 0)))
    }

    fn of(
        mut assembly: Assembly<S>,
        cell_home: Cell<S>,
        rows: &[GrainRow<S>],
        constants: Constants<S>,
        order: Order<S>,
    ) -> Result<Self, Error> {
        assembly.cell_home = cell_home;
        assembly.radius_max = rows.iter().map(|row| row.hot.radius).fold(0.0, f64::max);
        let mut sample = Self { assembly, constants, step: 0, order, together: Vec::new() };
        let mut memories = Memories::new(sample.constants.law().memory_words());
        rows.iter().for_each(|row| memories.push(row.contacts.iter().copied()));
        sample.arrange(&memories, |row| (rows[row].hot, rows[row].cold, rows[row].spring), rows.len())?;
        Ok(sample)
    }

    /// Simulated time at the end of the steps done, s.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.constants.dt
    }

    /// One step.
    pub fn advance(&mut self) -> Result<(), Error> {
        of_space::<Advance<S>>([&ADVANCE.0, &ADVANCE.1])(self)
    }

    fn take_step(&mut self) -> Result<(), Error> {
        self.assembly.contacts.settle_images(&self.assembly.cell);
        let keeps = self.assembly.keeps_forces(&self.constants);
        self.assembly.contacts.keep_forces(keeps);
        match self.constants.drive.is_at_rest() {
            // Nothing stands between the kick of a grain and its drift.
            true => {
                let farthest = self.evaluate_and_kick::<true>();
                self.assembly.drift_glued(farthest, &[], self.constants.dt);
            }
            false => {
                self.evaluate_and_kick::<false>();
                let looks = self.constants.drive.looks_at(self.step);
                let sums = looks.then(|| self.strained());
                self.assembly.drive(&self.constants, sums.as_ref());
                self.assembly.drift(&self.constants, &[]);
            }
        }
        self.step += 1;
        // What is not a number is not below one.
        let closed = self.assembly.closed(&self.constants, None);
        if closed < 1.0 { Ok(()) } else { self.rebuild(closed) }
    }

    fn evaluate_and_kick<const DRIFTS: bool>(&mut self) -> f64 {
        let Constants { field, dt, .. } = self.constants;
        let cell = self.assembly.cell;
        let dt_kick = self.constants.kick_share(self.step) * dt;
        match field.is_plain() && cell.gradient == S::Tensor::zero() {
            true => self.evaluate(&Moves::<_, DRIFTS> {
                kick: Falling { gravity: field.gravity },
                spring_share: 0.0,
                dt_kick,
                dt,
            }),
            false => {
                self.evaluate(&Moves::<_, DRIFTS> { kick: Damped { field, cell }, spring_share: 0.0, dt_kick, dt })
            }
        }
    }

    fn evaluate(&mut self, finish: &impl Finish<S>) -> f64 {
        let Self { assembly, constants, step, .. } = self;
        let passed = assembly.evaluate_pairs(constants, *step, Segments::Inner, finish);
        larger(passed.farthest, assembly.evaluate_rest(constants, *step, &[], finish))
    }

    fn strained(&self) -> Strained<S> {
        let sums = self.assembly.strained(&self.constants, &self.together);
        Strained::of_sums(&std::array::from_fn(|slot| sums.value(slot)))
    }

    /// Love-Weber sum over all contacts, J: minus force times branch, with the forces of the coming evaluation. Over the volume it is
    /// the mean stress, tension positive.
    pub fn contact_moment(&mut self) -> S::Tensor {
        self.assembly.contacts.settle_images(&self.assembly.cell);
        let sums = self.assembly.moments(&self.constants, self.step, &[], &self.together);
        let mut moment = S::Tensor::zero();
        (0..S::Tensor::COMPONENTS).for_each(|component| moment[component] = sums.value(component));
        moment
    }

    pub(crate) fn rebuild(&mut self, closed: f64) -> Result<(), Error> {
        if !closed.is_finite() {
            return Err(Error::Run(format!(
                "step {}: a grain has gone out of bounds; the sample is unstable: shorten the time step",
                self.step
            )));
        }
        self.assembly.go_home();
        self.assembly.cell_home = self.assembly.cell;
        self.refuse_narrow()?;
        let mut memories = Memories::new(self.constants.law().memory_words());
        (0..self.assembly.grains.owned).for_each(|row| memories.push(self.assembly.carried_by(row)));
        let grains = std::mem::take(&mut self.assembly.grains);
        self.arrange(&memories, |row| (grains.hot[row], grains.cold[row], grains.springs[row]), grains.owned)
    }

    /// Puts rows in order and makes their lists.
    pub(crate) fn arrange(
        &mut self,
        memories: &Memories,
        row_of: impl Fn(usize) -> (Hot<S>, Cold<S>, PenaltySpring<S>),
        count: usize,
    ) -> Result<(), Error> {
        self.refuse_narrow()?;
        let cell = &self.assembly.cell_home;
        let stands = |row: usize| {
            let (_, cold, _) = row_of(row);
            ((self.order)(&cell.fraction(&cold.home)), cold.id, row)
        };
        let mut order: Vec<_> = (0..count).map(stands).collect();
        order.sort_unstable();
        let together = order.chunk_by(|((a, _), ..), ((b, _), ..)| a == b).scan(0, |end, rows| {
            let start = *end;
            *end += rows.len();
            Some(start..*end)
        });
        self.together = together.collect();
        let grains = &mut self.assembly.grains;
        (grains.hot, grains.cold, grains.springs) = (Vec::new(), Vec::new(), Vec::new());
        for (_, _, row) in &order {
            let (hot, cold, spring) = row_of(*row);
            grains.hot.push(hot);
            grains.cold.push(cold);
            grains.springs.push(spring);
        }
        grains.owned = count;
        grains.settle();
        self.assembly.moved = 0.0;
        self.assembly.list(&self.constants, &[], |row| memories.of(order[row].2));
        Ok(())
    }

    /// The nearest image of a grain must be the only one in reach.
    fn refuse_narrow(&self) -> Result<(), Error> {
        let (assembly, reach) = (&self.assembly, 2.0 * self.assembly.radius_max + self.constants.margin());
        let narrow = |axis: &usize| assembly.cell.periodic[*axis] && 0.5 * assembly.cell_home.height(*axis) < reach;
        match (0..S::DIMENSION).find(narrow) {
            None => Ok(()),
            Some(axis) => Err(Error::Run(format!(
                "step {}: along axis {axis} the cell is {:.3e} m thick, and contacts reach {reach:.3e} m, which needs twice as much: take more grains",
                self.step,
                assembly.cell_home.height(axis)
            ))),
        }
    }

    /// Stops where a grain overlaps another by more than `share` of its radius.
    pub fn refuse_deep_overlaps(&mut self, share: f64) -> Result<(), Error> {
        self.assembly.contacts.settle_images(&self.assembly.cell);
        match self.assembly.contacts.deepest(&self.assembly.grains).into_iter().max_by(deeper) {
            Some((deepest, [a, b])) if deepest.is_nan() || deepest > share => Err(Error::Run(format!(
                "step {}: grains {} and {} overlap by {:.0} % of the smaller radius, {:.0} % is the most that a contact law means; the sample is unstable or far too loaded for its stiffness: shorten the time step or take stiffer contacts",
                self.step,
                a.0,
                b.0,
                100.0 * deepest,
                100.0 * share
            ))),
            _ => Ok(()),
        }
    }
}
