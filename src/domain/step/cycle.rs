//! Several steps of grains in one of the continuum, m of them.
//!
//! A cycle begins with points on their way to the grid, and ends with their way back over all of its time. In between the
//! nodes that they share with grains go in step with these, under the points' force of the beginning,
//!
//! ```text
//! P_c <- P_c + f dt - J,   lambda = (m_d P_c - m_c P_d)/(m_c + m_d),   P_c <- P_c - lambda,   P_d <- P_d + lambda
//! ```
//!
//! so that grains of the rim are held in every step of theirs, and each of them keeps momentum. With a coupling interval of k they do so in every k-th, and dt is that of
//! k steps of grains. A step in between is one of grains alone, in which penalty springs give their part ([`crate::mpm::penalty`]). Nodes without grains take
//! the whole cycle at once, at its end, and so do sides of bodies before which grains share none. With m = 1 this is the scheme of Yue et al. (2018).
//!
//! Bodies take the whole cycle at once, at its beginning, under the force that grains and nodes then put on them; what they take of both is
//! booked as it comes, and what a servo did not foresee of it is given to it in the next cycle. Nothing is looked at and no row moves within
//! a cycle, so that nodes in mid-cycle are no state.

use crate::base::space::{Linear, Space};
use crate::dem::grains::Grains;
use crate::domain::grid::{BoundaryConditions, Moment};
use crate::domain::phases::Phase;
use crate::domain::step::grid::{CHANGES, GRAINS};
use crate::domain::subdomain::Subdomain;
use crate::domain::world::World;
use crate::mpm::continuum::Continuum;
use crate::mpm::nodes::{self, Stepped};
use crate::mpm::penalty::Penalty;
use crate::mpm::tile::{GrainChange, GrainNode, Stride, Tier, Tiles};

/// How many times as fast as the fastest grain at the end of a cycle any grain may become within the next: twice that in
/// a collision with a heavier one, and as much again for what its contacts have stored.
const FASTER: f64 = 4.0;

impl<S: Space> World<'_, S> {
    /// Time step of the continuum, s.
    pub(crate) fn dt_of_continuum(&self) -> f64 {
        self.settings.grain_steps as f64 * self.settings.grains.dt
    }

    /// Whether something that happens every so many steps is due after those that are done.
    pub fn is_due(&self, every: u64) -> bool {
        is_due(self.step, every, self.settings.grain_steps)
    }

    pub(crate) fn begins_cycle(&self) -> bool {
        self.step_of_cycle == 0
    }

    pub(crate) fn ends_cycle(&self) -> bool {
        self.step_of_cycle + 1 == self.settings.grain_steps
    }

    /// Whether grains and the nodes that they share act on each other in this step: in every k-th of a cycle, the last among them.
    pub(crate) fn exchanges(&self) -> bool {
        self.ends_cycle() || (self.step_of_cycle + 1).is_multiple_of(self.settings.grid.penalty.interval)
    }

    /// Whether a step of a cycle is one of grains alone, between two exchanges with nodes.
    pub(crate) fn is_between_exchanges(&self) -> bool {
        !self.begins_cycle() && !self.exchanges()
    }

    /// Bound on the way of any grain of this rank, and of any body that grains touch, within the next cycle, m; none where lists are
    /// looked after at every step.
    pub(crate) fn reach_of_cycle(&self) -> f64 {
        if self.settings.grain_steps == 1 {
            return 0.0;
        }
        let grains = self.assembly.grains.hot[..self.assembly.grains.owned].iter().map(|hot| hot.velocity);
        // A body that comes on may be faster than all grains that are at rest yet.
        let touched = self.bodies.iter().filter(|body| body.is_touched() && self.has_grains());
        let squares = grains.chain(touched.map(|body| body.velocity)).map(|velocity| velocity.dot(&velocity));
        FASTER * squares.fold(0.0, f64::max).sqrt() * self.dt_of_continuum()
    }

    /// Before the first step of a cycle: where grains that take part will be at its first exchange, by the velocities that the last one left behind.
    pub(crate) fn predict_places(&mut self) {
        let (interval, dt) = (self.settings.grid.penalty.interval, self.settings.grains.dt);
        if !self.is_coupled() || interval == 1 {
            return;
        }
        let timer = self.phases.start();
        let Subdomain { participants, grain_ranges, .. } = &self.subdomain;
        let Grains { hot, predicted, owned, .. } = &mut self.assembly.grains;
        predicted.resize(*owned, S::Vector::zero());
        for (block, range) in grain_ranges.iter().enumerate() {
            for row in participants.in_block(block).iter().map(|row| range.start + *row as usize) {
                predicted[row] = Penalty::predicted::<S>(&hot[row].position, &hot[row].velocity, interval - 1, dt);
            }
        }
        self.phases.stop(Phase::Couple, timer);
    }

    /// No node has gone with grains yet.
    pub(crate) fn begin_cycle(&mut self) {
        if self.settings.grain_steps > 1 {
            self.continuum.tiles.strides.fill(Stride::zero());
        }
    }

    /// In the middle of a cycle: what grains bring to nodes anew.
    pub(crate) fn fill_grid_by_grains(&mut self) {
        if !self.is_coupled() || !self.exchanges() {
            return;
        }
        self.scatter_grains();
        match S::DIMENSION {
            2 => self.gather_grains::<{ GRAINS[0] }>(),
            _ => self.gather_grains::<{ GRAINS[1] }>(),
        }
    }

    fn gather_grains<const W: usize>(&mut self) {
        self.travel(
            |world| &mut world.subdomain.nodes.gathered,
            |world, row| {
                let mut words = [0.0; W];
                world.continuum.tiles.grains[row].write(&mut words);
                words
            },
            |world| world.sum_grains(Tier::Inner),
            |world, row, words| world.continuum.tiles.grains[row] = GrainNode::read(&words),
        );
        self.sum_grains(Tier::Border);
    }

    fn sum_grains(&mut self, tier: Tier) {
        let timer = self.phases.start();
        self.continuum.tiles.sum_grains(&self.subdomain.nodes.mosaic, tier);
        self.phases.stop(Phase::Nodes, timer);
    }

    /// Before the end of a cycle: shared nodes take a step of grains, and grains what it makes of them.
    pub(crate) fn share_grid(&mut self) {
        if !self.is_coupled() || !self.exchanges() {
            return;
        }
        self.meet_faces(Moment::Step);
        match S::DIMENSION {
            2 => self.spread_changes::<{ CHANGES[0] }>(),
            _ => self.spread_changes::<{ CHANGES[1] }>(),
        }
    }

    fn spread_changes<const W: usize>(&mut self) {
        self.share_nodes(Tier::Border);
        self.travel(
            |world| &mut world.subdomain.nodes.advanced,
            |world, row| {
                let mut words = [0.0; W];
                world.continuum.tiles.grain_changes[row].write(&mut words);
                words
            },
            |world| {
                world.share_nodes(Tier::Inner);
                world.take_changes(Tier::Inner);
            },
            |world, row, words| world.continuum.tiles.grain_changes[row] = GrainChange::read(&words),
        );
        self.take_changes(Tier::Border);
    }

    fn take_changes(&mut self, tier: Tier) {
        let timer = self.phases.start();
        self.continuum.tiles.copy_margins_of_grains(&self.subdomain.nodes.mosaic, tier);
        self.phases.stop(Phase::Nodes, timer);
        self.correct_grains(tier);
    }

    /// Nodes that grains and points share are few: one task has them all.
    fn share_nodes(&mut self, tier: Tier) {
        let timer = self.phases.start();
        let (gravity, dt, done) = (self.gravity_now(), self.settings.grains.dt, self.step_of_cycle + 1);
        let Self { subdomain, assembly, continuum: Continuum { tiles, .. }, bodies, settings, reactions, .. } = self;
        let (Subdomain { nodes, layout, .. }, periods) = (&*subdomain, &assembly.cell);
        let Tiles { sums, grain_sums, grain_changes, strides, shared, faces, .. } = tiles;
        let (mosaic, grid) = (&nodes.mosaic, &settings.grid);
        let conditions = BoundaryConditions { grid, layout, bodies, periods, gravity, moment: Moment::Step };
        let per_tile = mosaic.owned_per_tile();
        let meets_grains = faces.with_grains.contains(&true);
        let is_met = |tile: usize| meets_grains && faces.is_near(tile);
        let wanted = (0..mosaic.tiles).filter(|tile| mosaic.tiers[*tile] == tier && (shared[*tile] || is_met(*tile)));
        for number in wanted.flat_map(|tile| tile * per_tile..(tile + 1) * per_tile) {
            let (node, sum, grains) = (&mosaic.owned[number], &mut sums[number], &grain_sums[number]);
            let change = &mut grain_changes[node.row as usize];
            // Columns of faces go together, whether grains are among their nodes or not; a grain that has come to those that wait gets nothing of them
            // before the cycle ends.
            let meets = faces.acts_with_grains(mosaic, number);
            let waits = meets == Some(false) || (meets.is_none() && grains.mass() <= 0.0);
            if sum.mass() <= 0.0 || waits {
                *change = nodes::without_points(grains);
                continue;
            }
            let (met, stride) = (faces.met_at(mosaic, number), &mut strides[number]);
            if stride.taken == 0 {
                stride.brought = sum.momentum() * (1.0 / sum.mass());
            }
            let dt = (done - stride.taken) as f64 * dt;
            let hold = |free: S::Vector| conditions.on(free, (node, met), (sum, grains), dt, reactions);
            let Stepped { velocity, grains } = nodes::step(sum, grains, &gravity, dt, hold);
            *change = grains;
            stride.taken = done;
            sum.set_momentum(&(velocity * sum.mass()));
        }
        self.phases.stop(Phase::Nodes, timer);
    }
}

/// Whether one of every so many steps is among the last `together` of `step`.
pub fn is_due(step: u64, every: u64, together: u64) -> bool {
    step % every < together
}
