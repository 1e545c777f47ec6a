//! What must be kept: mass, momentum and energy of all that moves by its own forces, between the start of a run and its end.
//!
//! ```text
//! M(now) = M(0)
//! P(now) = P(0) + bodies + nodes + gravity + damping       P = sum m (v - L y), L the gradient of the cell
//! W = E(now) - E(0) + dissipated                            W: work of bodies, E: kinetic and elastic energy
//! ```
//!
//! bodies: what those that grains touch or are glued to have given, and those that hold nodes; nodes: faces, bodies among
//! points, loads, and pressure on membranes ([`crate::domain::grid::Reactions`]); gravity: M g t. Each is summed where it acts, so that what is
//! left is what contacts, transfers, sharing, migration, enrichment and restarts have made or lost. Damping that acts against
//! the ground is not summed: where there is some, it is what is left.
//!
//! Energy is told apart by accounts of its own where they are kept ([`crate::domain::accounts::ledger`]); without one, what bodies have
//! done and has not been stored is what friction, dashpots and plastic flow have taken, with the error of the step and what an
//! enrichment has made or lost.

use scree_partition::ExactSum;
use serde_json::{Value, json};

use crate::base::error::Error;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::grains::Mover;
use crate::domain::accounts::ledger::Balance;
use crate::domain::accounts::ledger::points::PointBalance;
use crate::domain::grid::{REACTIONS, impulse_on_material, impulse_sizes, plate_work};
use crate::domain::world::World;

/// At the start of a run, or of a branch of one, and what has been given since; the same on every rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kept {
    /// Steps done.
    pub step: u64,
    /// kg, N s.
    pub mass: f64,
    /// N s, against the mean field of the cell, of what moves freely.
    pub momentum: [f64; 3],
    /// Kinetic and elastic, J.
    pub energy: f64,
    /// What bodies had given until then, N s, and the work that they had done, J.
    pub by_bodies: [f64; 3],
    /// J, positive where bodies have put energy in.
    pub work: f64,
    /// Impulse of faces, bodies, loads and membranes on nodes since then, up to when it was last taken, N s; and the sizes of its parts
    /// together.
    pub through_nodes: [f64; 3],
    /// N s.
    pub through_nodes_sizes: f64,
}

impl Kept {
    /// Adds what was taken off the nodes.
    pub fn take(&mut self, reactions: &[f64; REACTIONS]) {
        let impulse = impulse_on_material(reactions);
        self.through_nodes.iter_mut().zip(impulse).for_each(|(sum, more)| *sum += more);
        self.through_nodes_sizes += impulse_sizes(reactions);
    }
}

impl Record for Kept {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("kept_step", &mut self.step);
        visitor.f64s("kept_mass", std::slice::from_mut(&mut self.mass));
        visitor.f64s("kept_momentum", &mut self.momentum);
        visitor.f64s("kept_energy", std::slice::from_mut(&mut self.energy));
        visitor.f64s("kept_by_bodies", &mut self.by_bodies);
        visitor.f64s("kept_work", std::slice::from_mut(&mut self.work));
        visitor.f64s("kept_through_nodes", &mut self.through_nodes);
        visitor.f64s("kept_through_nodes_sizes", std::slice::from_mut(&mut self.through_nodes_sizes));
    }
}

/// What there is at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Holdings {
    /// kg, N s, and the sum of all speeds times masses, to which errors of momentum are compared.
    pub mass: f64,
    /// N s, against the mean field of the cell, of what moves freely.
    pub momentum: [f64; 3],
    /// N s.
    pub motion: f64,
    /// Kinetic and elastic, J.
    pub energy: f64,
}

/// Of a run so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conservation {
    /// At the start of the run, or of a branch of it.
    pub start: Kept,
    /// At the end of the steps done.
    pub now: Holdings,
    /// Impulses on what moves freely, N s.
    pub by_bodies: [f64; 3],
    /// Of faces, bodies among points, loads and membranes.
    pub by_nodes: [f64; 3],
    /// M g t, t in times of the full strength of gravity.
    pub by_gravity: [f64; 3],
    /// Sizes of all of them together, body by body, N s: those of two plates may all but cancel.
    pub impulses: f64,
    /// Whether damping acts against the ground, and has what is left of momentum.
    pub is_damped: bool,
    /// Work of bodies, J; none where something else does work as well, or nothing does.
    pub work: Option<f64>,
    /// Energy told apart, where an account of it is kept.
    pub grains: Option<Balance>,
    /// The same of points or elements; none as well where energies of the last step were not wanted.
    pub points: Option<PointBalance>,
}

impl Conservation {
    /// Momentum that nobody has given, N s.
    pub fn momentum_left(&self) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let given = self.by_bodies[axis] + self.by_nodes[axis] + self.by_gravity[axis];
            self.now.momentum[axis] - self.start.momentum[axis] - given
        })
    }

    /// Mass that nothing accounts for, as a share of all.
    pub fn mass_error(&self) -> f64 {
        relative(self.now.mass - self.start.mass, self.start.mass)
    }

    /// The largest component of momentum that nothing accounts for, as a share of the impulses or of all motion; none where
    /// damping has it.
    pub fn momentum_error(&self) -> Option<f64> {
        let largest = self.momentum_left().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        (!self.is_damped).then(|| relative(largest, self.impulses.max(self.now.motion)))
    }

    /// For `summary.json`.
    pub fn figures(&self) -> Value {
        let mut figures = json!({
            "since_step": self.start.step,
            "mass": { "start": self.start.mass, "end": self.now.mass, "error": self.mass_error() },
            "momentum": {
                "start": self.start.momentum,
                "end": self.now.momentum,
                "by_bodies": self.by_bodies,
                "by_nodes": self.by_nodes,
                "by_gravity": self.by_gravity,
                "impulses": self.impulses,
                "left": self.momentum_left(),
                "error": self.momentum_error(),
            },
            "energy": { "start": self.start.energy, "end": self.now.energy, "work_of_bodies": self.work },
        });
        if let Some(of) = &self.grains {
            figures["energy"]["grains"] = json!({
                "work": of.work(), "by_nodes": of.work_nodes, "stored": of.stored(), "dissipated": of.dissipated(), "residual": of.residual(),
            });
        }
        if let Some(of) = &self.points {
            figures["energy"]["points"] = json!({
                "work": of.work(), "holds": of.holds, "lost": of.lost,
            });
        }
        figures
    }

    /// For a person.
    pub fn words(&self) -> String {
        let axes = if self.start.momentum[2] == 0.0 && self.now.momentum[2] == 0.0 { 2 } else { 3 };
        let vector = |of: &dyn Fn(usize) -> f64| {
            let parts: Vec<String> = (0..axes).map(|axis| format!("{:.4e}", of(axis))).collect();
            format!("({})", parts.join(", "))
        };
        let given = |axis: usize| self.by_bodies[axis] + self.by_nodes[axis] + self.by_gravity[axis];
        let momentum = format!(
            "momentum: {} N s at the start, {} given, {} now: ",
            vector(&|axis| self.start.momentum[axis]),
            vector(&given),
            vector(&|axis| self.now.momentum[axis])
        );
        let outcome = match self.momentum_error() {
            Some(error) => format!("off by {error:.1e}"),
            None => format!("damping has {}", vector(&|axis| self.momentum_left()[axis])),
        };
        let mass = format!("mass: {:.6e} kg, off by {:.1e}", self.now.mass, self.mass_error());
        [mass, momentum + &outcome, self.energy_in_words()].join("\n")
    }

    fn energy_in_words(&self) -> String {
        let mut words = format!("energy: {:.4e} J at the start", self.start.energy);
        if let Some(work) = self.work {
            let dissipated = work - (self.now.energy - self.start.energy);
            words += &format!(", {work:.4e} by bodies, {dissipated:.4e} dissipated");
        }
        words += &format!(", {:.4e} now", self.now.energy);
        if let Some(of) = &self.grains {
            words += &format!("; energy residual of grains {:.1e} of the work", of.residual());
        }
        if let Some(of) = &self.points {
            words += &format!("; of points the scheme has lost {:.3e}", of.lost);
        }
        words
    }
}

fn relative(error: f64, scale: f64) -> f64 {
    if scale > 0.0 { error / scale } else { error }
}

impl<S: Space> World<'_, S> {
    /// What there is now. Collective.
    pub fn holdings(&mut self) -> Result<Holdings, Error> {
        let energies = self.energies()?;
        let energy = energies.kinetic_grains
            + energies.elastic_grains
            + energies.kinetic_points
            + energies.elastic_points
            + self.continuum.membranes.energy();
        let mut sums = ExactSum::<5>::new();
        let mut add = |mass: f64, velocity: &S::Vector| {
            sums.add(0, mass);
            for axis in 0..S::DIMENSION {
                sums.add(1 + axis, mass * velocity[axis]);
            }
            sums.add(4, mass * velocity.norm());
        };
        // Velocities are of the drift that has led here: against the mean field at its beginning they have no image.
        let (cell, drift) = (&self.assembly.cell, if self.step == 0 { 0.0 } else { self.settings.grains.dt });
        for (hot, cold) in self.assembly.grains.hot[..self.assembly.grains.owned].iter().zip(&self.assembly.grains.cold)
        {
            if cold.mover == Mover::Free {
                let place = hot.position - hot.velocity * drift - cell.corner;
                add(hot.weight * hot.mass, &(hot.velocity - cell.gradient * place));
            }
        }
        for point in &self.continuum.points.hot {
            add(point.weight * point.mass, &point.velocity);
        }
        if self.transport.rank() == 0 {
            self.continuum.membranes.masses().for_each(|(mass, velocity)| add(mass, velocity));
        }
        let [mass, x, y, z, motion] = self.reduce(sums)?;
        Ok(Holdings { mass, momentum: [x, y, z], motion, energy })
    }

    /// What there is at the start of a run, or of a branch of one. Collective.
    pub fn kept_from_now(&mut self) -> Result<Kept, Error> {
        let Holdings { mass, momentum, energy, .. } = self.holdings()?;
        // Impulses on nodes that the next row will take belong to the run before.
        let pending = self.reactions_so_far()?;
        let through_nodes = impulse_on_material(&pending).map(|impulse| -impulse);
        let (by_bodies, _) = self.impulses_of_bodies();
        let work = self.work_of_bodies(&pending);
        Ok(Kept { step: self.step, mass, momentum, energy, by_bodies, work, through_nodes, through_nodes_sizes: 0.0 })
    }

    /// Impulse since the very start of bodies without a grip, N s, but for what plates took that were at a grid, which is in the account of
    /// nodes; and the sizes of them together.
    fn impulses_of_bodies(&self) -> ([f64; 3], f64) {
        let (mut impulse, mut sizes) = ([0.0; 3], 0.0);
        for body in self.bodies.iter().filter(|body| body.grip.is_none()) {
            (0..S::DIMENSION).for_each(|axis| impulse[axis] -= body.impulse_whole[axis]);
            sizes += body.impulse_whole.norm();
        }
        (impulse, sizes)
    }

    /// J; of plates with what has not been taken yet.
    fn work_of_bodies(&self, pending: &[f64; REACTIONS]) -> f64 {
        self.bodies.iter().enumerate().map(|(number, body)| body.work + plate_work(pending, number)).sum()
    }

    /// The account since `start`. Collective.
    pub fn conservation(&mut self, start: &Kept) -> Result<Conservation, Error> {
        let now = self.holdings()?;
        let mut since = *start;
        let pending = self.reactions_so_far()?;
        since.take(&pending);
        let by_nodes = since.through_nodes;
        let (whole, sizes) = self.impulses_of_bodies();
        let by_bodies = std::array::from_fn(|axis| whole[axis] - start.by_bodies[axis]);
        // Vertices of membranes go with nodes, whatever they enclose.
        let of_membranes: f64 = self.continuum.membranes.masses().map(|(mass, _)| mass).sum();
        let passed =
            |of_grains: bool| self.time_of_gravity(self.step, of_grains) - self.time_of_gravity(start.step, of_grains);
        let of_grains = !self.has_points() || self.settings.begins_as_grains;
        let impulse = (now.mass - of_membranes) * passed(of_grains) + of_membranes * passed(false);
        let given = self.settings.grains.field.gravity * impulse;
        let mut by_gravity = [0.0; 3];
        (0..S::DIMENSION).for_each(|axis| by_gravity[axis] = given[axis]);
        let impulses = sizes + since.through_nodes_sizes + given.norm();
        let bodies_alone = !self.bodies.is_empty()
            && self.bodies.iter().all(|body| body.grip.is_none())
            && self.settings.grains.drive.is_at_rest()
            && self.settings.grains.field.gravity == S::Vector::zero();
        Ok(Conservation {
            start: *start,
            now,
            by_bodies,
            by_nodes,
            by_gravity,
            impulses,
            is_damped: !self.settings.grains.field.is_plain(),
            work: bodies_alone.then(|| self.work_of_bodies(&pending) - start.work),
            grains: self.has_balance().then(|| self.balance()).transpose()?,
            points: if self.has_point_energies() { self.point_balance()? } else { None },
        })
    }

    /// How long gravity has acted on velocities after `step` steps, in times of its full strength, s: velocities of grains are half
    /// a step behind, and on nodes it may rise from nothing.
    fn time_of_gravity(&self, step: u64, of_grains: bool) -> f64 {
        if step == 0 {
            return 0.0;
        }
        if of_grains {
            return (step as f64 - 1.0 + self.settings.grains.first_kick) * self.settings.grains.dt;
        }
        let (dt, ramp) = (self.dt_of_continuum(), self.settings.grid.gravity_ramp);
        // What is missing of the first step, which begins with a part of a kick.
        let missing =
            (1.0 - self.settings.grains.first_kick) * dt * if 0.5 * dt < ramp { 0.5 * dt / ramp } else { 1.0 };
        let missing = if self.has_elements() { missing } else { 0.0 };
        let steps = (step / self.settings.grain_steps) as f64;
        // Steps whose middle is before the end of the ramp have the share of their middle.
        let rising = (ramp / dt - 0.5).ceil().clamp(0.0, steps);
        let risen = if rising > 0.0 { 0.5 * (rising * dt) * (rising * dt) / ramp } else { 0.0 };
        risen + (steps - rising) * dt - missing
    }
}
