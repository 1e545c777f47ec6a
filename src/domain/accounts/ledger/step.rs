//! What one step books: the work of its forces over the drifts behind and ahead, row by row and wall by wall.

use rayon::prelude::*;
use scree_partition::ExactSum;

use super::{ITEMS, Item, Page, STORES};
use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::dem::cell::{Cell, ImageCode, Shifts};
use crate::dem::contacts::Contacts;
use crate::dem::grains::{Grains, Hot, Mover, lanes, vector};
use crate::dem::kernel::{Given, Side, pair_weight, touch};
use crate::dem::law::Law;
use crate::dem::motion::Field;
use crate::dem::neighbours::Term;
use crate::dem::walls::{Wall, Walls, beside, touch_of};
use crate::dem::work::{Parted, settle};
use crate::law::contact::{Memory, Touch};

/// Sums over rows and walls: work over the drift behind the evaluation and over that ahead, and energies.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    pub behind: ExactSum<ITEMS>,
    pub ahead: ExactSum<ITEMS>,
    pub stored: ExactSum<STORES>,
}

impl Sums {
    fn with(mut self, lines: &Lines) -> Self {
        for slot in 0..ITEMS {
            self.behind.add(slot, lines.work[BEHIND][slot]);
            self.ahead.add(slot, lines.work[AHEAD][slot]);
        }
        (0..STORES).for_each(|slot| self.stored.add(slot, lines.stored[slot]));
        self
    }

    fn merged(mut self, other: Self) -> Self {
        self.behind.merge(&other.behind);
        self.ahead.merge(&other.ahead);
        self.stored.merge(&other.stored);
        self
    }
}

/// The drifts on either side of an evaluation.
const BEHIND: usize = 0;
const AHEAD: usize = 1;

/// What one row or wall adds, J.
#[derive(Clone, Copy, Debug, Default)]
struct Lines {
    work: [[f64; ITEMS]; 2],
    /// Kinetic and elastic.
    stored: [f64; STORES],
}

impl Lines {
    fn add(&mut self, drift: usize, item: Item, work: f64) {
        self.work[drift][item as usize] += work;
    }
}

/// A step between its kicks and its drift.
pub struct Step<'a, S: Space> {
    pub law: &'a dyn Law<S>,
    pub field: &'a Field<S>,
    pub dt: f64,
    /// Share of it by which this step has kicked, and how long the drift behind took, s.
    pub share: f64,
    pub passed: f64,
    /// Grains share nodes with a continuum.
    pub coupled: bool,
    pub grains: &'a Grains<S>,
    pub contacts: &'a Contacts<S>,
    pub bodies: &'a [Body<S>],
    pub page: &'a Page<S>,
    /// With the gradients and rates of the drifts behind and ahead; edges of now.
    pub cells: [&'a Cell<S>; 2],
    pub shifts_after: Shifts<S>,
}

impl<S: Space> Step<'_, S> {
    /// What the rows and walls of this rank add.
    pub fn sums(&self, walls: &Walls<S>) -> Sums {
        let rows = (0..self.grains.owned).into_par_iter();
        let sums = rows.fold(Sums::default, |sums, row| sums.with(&self.row(row))).reduce(Sums::default, Sums::merged);
        let rows = walls.list.iter().zip(&self.page.memories_of_walls);
        rows.fold(sums, |sums, (wall, memory)| sums.with(&self.wall(wall, memory, walls.law_of(wall.body, self.law))))
    }

    /// A row as it moved over the drift behind; copies of other ranks' rows still do.
    fn before(&self, row: usize) -> Hot<S> {
        let mut hot = self.grains.hot[row];
        if let Some((velocity, spin)) = self.page.motion.get(row) {
            (hot.velocity, hot.spin) = (*velocity, *spin);
        }
        hot
    }

    /// An owned row as it will move over the drift ahead.
    fn after(&self, row: usize) -> Hot<S> {
        let mut hot = self.grains.hot[row];
        match self.grains.cold[row].mover {
            Mover::Free => {}
            Mover::Body(body) => {
                let body = &self.bodies[body as usize];
                (hot.velocity, hot.spin) = (body.velocity_at(&hot.position), body.spin);
            }
            Mover::Script => hot.velocity = self.grains.cold[row].script,
        }
        hot
    }

    /// What an owned row takes and holds, with its sides of its contacts and all of those in which it is `a`.
    fn row(&self, row: usize) -> Lines {
        let mut lines = Lines::default();
        let sides = [self.before(row), self.after(row)];
        let (force, torque) = (&self.grains.force[row], &self.grains.torque[row]);
        match self.grains.cold[row].mover {
            Mover::Free => self.free(&sides, (force, torque), &mut lines),
            _ => {
                for (drift, hot) in sides.iter().enumerate() {
                    let power = force.dot(&hot.velocity) + torque.dot(&hot.spin);
                    lines.add(drift, Item::Bodies, -0.5 * self.dt * power);
                }
            }
        }
        for term in self.contacts.neighbours.terms_of(row) {
            self.contact(term, &sides, &mut lines);
        }
        lines
    }

    /// The motion of a free grain.
    fn free(&self, sides: &[Hot<S>; 2], (force, torque): (&S::Vector, &S::Spin), lines: &mut Lines) {
        let before = &sides[BEHIND];
        let mass = before.weight * before.mass;
        let inertia = S::grain_inertia(mass, before.radius);
        let gravity = self.field.gravity;
        let undamped = (*force * (1.0 / mass) + gravity, *torque * (1.0 / inertia));
        let (linear, angular) = self.field.damping.of_grain::<S, f64>(
            &Side::scalar(before),
            (lanes(&undamped.0), lanes(&undamped.1)),
            self.cells[BEHIND],
            self.share * self.dt,
        );
        let (linear, angular): (S::Vector, S::Spin) = (vector(&linear), vector(&angular));
        let damping = ((linear - undamped.0) * mass, (angular - undamped.1) * inertia);

        let mut fluctuations = [(S::Vector::zero(), S::Spin::zero()); 2];
        for (drift, hot) in sides.iter().enumerate() {
            let gradient = self.cells[drift].gradient;
            let mut place = hot.position - self.cells[drift].corner;
            if drift == BEHIND {
                place -= hot.velocity * (self.share * self.dt);
            }
            let (mean, spin) = (gradient * place, S::vorticity(&gradient));
            let (velocity, turning) = (hot.velocity - mean, hot.spin - spin);
            fluctuations[drift] = (velocity, turning);
            let half = 0.5 * self.dt;
            lines.add(drift, Item::Gravity, half * mass * gravity.dot(&velocity));
            lines.add(drift, Item::Cell, -half * (force.dot(&mean) + torque.dot(&spin)));
            lines.add(drift, Item::Damping, -half * (damping.0.dot(&velocity) + damping.1.dot(&turning)));
        }
        let [(mut velocity, mut spin), (velocity_after, spin_after)] = fluctuations;
        if self.coupled {
            // All of the kick that is not the grain's own, as of a whole step.
            let impulse = (velocity_after - velocity) * (mass / self.share) - linear * (mass * self.dt);
            lines.add(BEHIND, Item::Nodes, 0.5 * impulse.dot(&velocity));
            lines.add(AHEAD, Item::Nodes, 0.5 * impulse.dot(&velocity_after));
        }
        if self.share != 1.0 {
            // As if the start had been half a step before: by the whole of the first kick.
            velocity = velocity_after - (velocity_after - velocity) * (1.0 / self.share);
            spin = spin_after - (spin_after - spin) * (1.0 / self.share);
        }
        lines.stored[0] += 0.5 * mass * velocity.dot(&velocity_after) + 0.5 * inertia * spin.dot(&spin_after);
    }

    /// A row's side of a contact over both drifts, `a` with the images; and what springs did, if the row is `a`.
    fn contact(&self, term: Term, sides: &[Hot<S>; 2], lines: &mut Lines) {
        let pair = self.contacts.neighbours.pairs[term.pair];
        let (row_a, row_b) = (pair.a as usize, pair.b() as usize);
        let (a, b) = (self.before(row_a), self.before(row_b));
        let (shift, rate) = self.contacts.shift(&pair);
        let separation = a.position - b.position + shift;
        let relative = a.velocity - b.velocity + rate;
        let now = of_sides::<S>([&a, &b], (separation, relative), [self.passed, self.dt]);
        let memory = self.contacts.recall(term.pair);
        let given = self.contacts.given(term.pair);
        let weight = pair_weight(a.weight, b.weight);

        if !term.is_b {
            let first = separation - relative * self.passed;
            let first = of_sides::<S>([&a, &b], (first, relative), [0.0, 0.0]);
            let memory_before = self.contacts.recall_from(&self.page.memories, term.pair);
            let settled = settle(self.law, [&first, &now], [&memory_before, &memory]);
            lines.add(BEHIND, Item::Slip, weight * settled.slipped);
            lines.add(BEHIND, Item::Made, weight * settled.made);
            lines.stored[1] += weight * settled.elastic;
        }
        let arm = a.radius - 0.5 * now.overlap;
        let Some(parted) = Parted::of(self.law, &now, &memory, &given, [weight, arm]) else { return };
        let rates = [rate, self.shifts_after.at(pair.image()).1];
        for drift in [BEHIND, AHEAD] {
            let mut still = a;
            (still.velocity, still.spin) = (S::Vector::zero(), S::Spin::zero());
            let moving = sides[drift];
            let (velocity, pair_of) = match term.is_b {
                false => (moving.velocity + rates[drift], [moving, Hot { radius: b.radius, ..still }]),
                true => (-moving.velocity, [still, moving]),
            };
            let alone = of_sides::<S>([&pair_of[0], &pair_of[1]], (separation, velocity), [0.0, 0.0]);
            lose(self.law, &parted, &alone, &moving.spin, (drift, lines), self.dt);
            if !term.is_b && pair.image() != ImageCode::NONE {
                let force: S::Vector = vector(&given.force);
                lines.add(drift, Item::Cell, -0.5 * self.dt * force.dot(&rates[drift]));
            }
        }
    }

    /// A contact with a body over both drifts.
    fn wall(&self, wall: &Wall<S>, memory_before: &Memory, law: &dyn Law<S>) -> Lines {
        let mut lines = Lines::default();
        let (row, number) = (wall.row as usize, wall.body as usize);
        let body = &self.bodies[number];
        let sides = [(BEHIND, self.before(row)), (AHEAD, self.after(row))];
        let sides = sides.map(|(drift, hot)| beside(body, self.cells[drift], &hot).0);
        let Some(nearest) = body.nearest(&sides[BEHIND].position) else { return lines };
        let motions = [self.page.bodies[number], (body.velocity, body.spin)];
        let now = touch_of(&sides[BEHIND], body, motions[BEHIND], &nearest, [self.passed, self.dt]);
        let weight = sides[BEHIND].weight;

        // Where the grain was against the body as it stands now.
        let mut hot = sides[BEHIND];
        hot.position -= (hot.velocity - motions[BEHIND].0) * self.passed;
        if let Some(first) = body.nearest(&hot.position) {
            let first = touch_of(&hot, body, motions[BEHIND], &first, [0.0, 0.0]);
            let settled = settle(law, [&first, &now], [memory_before, &wall.memory]);
            lines.add(BEHIND, Item::Slip, weight * settled.slipped);
            lines.add(BEHIND, Item::Made, weight * settled.made);
            lines.stored[1] += weight * settled.elastic;
        }
        let arm = now.radius_a - 0.5 * now.overlap;
        let turn = S::torque(&now.normal, &S::tangential(&now.normal, &lanes(&wall.force)));
        let moment: S::SpinOf<f64> = lanes(&wall.moment);
        let given = Given { force: lanes(&wall.force), torque_a: moment - turn * arm, torque_b: -moment };
        let parted = Parted::of(law, &now, &wall.memory, &given, [weight, arm]);
        let Some(parted) = parted else { return lines };
        for drift in [BEHIND, AHEAD] {
            let touch = touch_of(&sides[drift], body, motions[drift], &nearest, [0.0, 0.0]);
            // Both sides have the force in the middle of the overlap.
            lose(law, &parted, &touch, &(sides[drift].spin + motions[drift].1), (drift, &mut lines), self.dt);
            let velocity = body.velocity_in(&motions[drift], &wall.point);
            let power = wall.force.dot(&velocity) + wall.moment.dot(&motions[drift].1);
            lines.add(drift, Item::Bodies, 0.5 * self.dt * power);
        }
        lines
    }
}

fn lose<S: Space>(
    law: &dyn Law<S>,
    parted: &Parted<S>,
    touch: &Touch<S, f64>,
    turning: &S::Spin,
    (drift, lines): (usize, &mut Lines),
    dt: f64,
) {
    let lost = parted.losses(law, touch, &lanes(turning));
    lines.add(drift, Item::Viscous, 0.5 * dt * lost.viscous);
    lines.add(drift, Item::Slip, 0.5 * dt * lost.sliding);
    lines.add(drift, Item::Levers, 0.5 * dt * lost.levers);
}

/// Two grains as a law sees them, at a separation (m) and a relative velocity (m/s).
fn of_sides<S: Space>(
    [a, b]: [&Hot<S>; 2],
    (separation, relative): (S::Vector, S::Vector),
    moved: [f64; 2],
) -> Touch<S, f64> {
    touch(&Side::scalar(a), &Side::scalar(b), lanes(&separation), lanes(&relative), moved)
}
