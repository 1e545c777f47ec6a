//! The world: everything that is simulated, cut into blocks, some of which this rank holds. The only caller of the
//! partition; the physics below is called block by block and row by row.

use std::mem;

use scree_partition::{ExactSums, Halo, Transport};

use crate::base::compiled::of_space;
use crate::base::error::Error;
use crate::base::numbers::Numbers;
use crate::base::parallel::larger;
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::bodies::body::Body;
use crate::dem::assembly::{Assembly, Constants};
use crate::dem::law::Law;
use crate::dem::motion::{Damped, Falling, Moves};
use crate::dem::segments::{Finish, Segments, Wait};
use crate::domain::accounts::ledger::EnergyLedger;
use crate::domain::accounts::ledger::points::PointLedger;
use crate::domain::elements::Meshed;
use crate::domain::grid::{Grid, Reactions};
use crate::domain::load_balance::LoadBalance;
use crate::domain::nonlocal::Neighbourhood;
use crate::domain::phases::{Phase, Phases};
use crate::domain::step::rves::RveEvent;
use crate::domain::stop::Wish;
use crate::domain::subdomain::Subdomain;
use crate::fem::elements::Elements;
use crate::mpm::continuum::Continuum;
use crate::mpm::load::Load;
use crate::mpm::nonlocal::Nonlocal;
use crate::mpm::shape::DRIFT_MAX;
use crate::mpm::stress::{SharedMaterial, no_material};
use crate::rve::{GrainMaterial, PointRve, Scratches};

/// Constants of a world that no step changes, but for `grain_steps`, which are one until points come to grains alone.
#[derive(Clone, Debug)]
pub struct Settings<S: Space> {
    /// Time step, skin, law of contacts, and what moves grains beside these.
    pub grains: Constants<S>,
    /// Steps of grains in one of the continuum, m. Of grains alone those between two looks at lists, and at what bodies bear.
    pub grain_steps: u64,
    /// How nodes work, and what holds them at the faces of the domain.
    pub grid: Grid,
    /// Loads that points bear by their number.
    pub loads: Vec<Load<S>>,
    /// The law of points; [`no_material`] where there is none.
    pub material: SharedMaterial<S>,
    /// Where the material is grains at every point: how they follow it.
    pub rves: Option<GrainMaterial<S>>,
    /// How their strain is averaged, where it is.
    pub nonlocal: Option<Nonlocal>,
    /// Where the continuum is one of elements: its mesh.
    pub meshed: Option<Meshed<S>>,
    /// Whether points, if there are any, have been grains, whose velocities are half a step behind.
    pub begins_as_grains: bool,
}

impl<S: Space> Settings<S> {
    /// Of grains alone.
    pub fn of_grains(grains: Constants<S>) -> Self {
        Self {
            grains,
            grain_steps: 1,
            grid: Grid::blend(0.0),
            loads: Vec::new(),
            material: no_material(),
            rves: None,
            nonlocal: None,
            meshed: None,
            begins_as_grains: false,
        }
    }
}

/// The world as this rank holds it.
pub struct World<'t, S: Space> {
    /// To the other ranks.
    pub transport: &'t dyn Transport,
    /// The same on every rank.
    pub settings: Settings<S>,
    /// Steps done.
    pub step: u64,
    /// Steps of grains done in the cycle under way.
    pub(crate) step_of_cycle: u64,
    /// Those of this rank, and copies of others that these touch.
    pub assembly: Assembly<S>,
    /// Points of this rank, and all membranes.
    pub continuum: Continuum<S>,
    /// Those of points, row by row, and their nodes; none where nodes are those of a grid.
    pub elements: Elements<S>,
    /// Those of points, row by row; none where the material is a law.
    pub rves: Vec<PointRve<S>>,
    /// What threads step them with.
    pub(crate) scratches: Scratches<S>,
    /// What RVEs have come through since it was last taken: on rank 0, and empty on others that know of it.
    pub(crate) rve_events: Option<Vec<RveEvent>>,
    pub(crate) neighbourhood: Neighbourhood<S>,
    /// All of them, the same on every rank.
    pub bodies: Vec<Body<S>>,
    /// Displacement of each body at the last rebuild, m.
    pub(crate) bodies_home: Vec<S::Vector>,
    /// Blocks and rows of this rank, and what it tells its neighbours.
    pub subdomain: Subdomain,
    /// Grains and points in the whole world; whatever changes them on purpose says so here, everything else is a loss.
    pub grains_total: u64,
    /// Of elements, one each.
    pub points_total: u64,
    /// What this rank has been asked for, and the strongest wish of any rank: all learn it after the same step.
    pub wish: Wish,
    /// As of the last cycle.
    pub wish_agreed: Wish,
    /// Since this world was made; no state.
    pub rebuilds: u64,
    /// Who holds which block as the work moves.
    pub load_balance: LoadBalance,
    /// Wall time of this rank, s.
    pub phases: Phases,
    /// Where the work goes, if that is to be known.
    pub(crate) ledger: Option<Box<EnergyLedger<S>>>,
    /// The same of a continuum, and its energies.
    pub point_ledger: PointLedger<S>,
    /// Impulses on what holds nodes.
    pub reactions: Reactions,
    /// Sums of the columns of faces askew to the grid; made and used within a step.
    pub(crate) column_sums: ExactSums,
}

type Advance<S> = fn(&mut World<S>) -> Result<(), Error>;
static ADVANCE: (Advance<Plane>, Advance<Solid>) = (|world| world.take_cycle(), |world| world.take_cycle());

/// Numbers per row in the messages of a step: position, velocity and spin of a grain in the plane and in space.
pub(crate) const GRAIN_WORDS_PLANE: usize = 5;
pub(crate) const GRAIN_WORDS_SOLID: usize = 9;

impl<S: Space> World<'_, S> {
    /// Simulated time at the end of the steps done, s.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.settings.grains.dt
    }

    /// The law of contacts, of grains with each other.
    pub fn law(&self) -> &dyn Law<S> {
        self.settings.grains.law()
    }

    /// One step of the continuum, and as many of grains as belong to it.
    pub fn advance(&mut self) -> Result<(), Error> {
        of_space::<Advance<S>>([&ADVANCE.0, &ADVANCE.1])(self)
    }

    fn take_cycle(&mut self) -> Result<(), Error> {
        for step in 0..self.settings.grain_steps {
            self.step_of_cycle = step;
            self.take_step()?;
            self.step += 1;
        }
        self.rebuild_if_due()
    }

    /// The step itself: afterwards every row still lies where it lay, and forces are those of its start.
    pub(crate) fn take_step(&mut self) -> Result<(), Error> {
        match self.is_plain() {
            _ if self.has_elements() => self.step_of_elements(),
            true => self.step_of_grains_alone(),
            false => self.step_of_all(),
        }
    }

    /// Whether nothing stands between the kick of a grain and its drift: no exchange with nodes, no cell that deforms, no account of energy.
    fn is_plain(&self) -> bool {
        (!self.has_grid() || self.is_between_exchanges())
            && self.settings.grains.drive.is_at_rest()
            && self.ledger.is_none()
    }

    /// The same to the bit as the whole list, with every grain's record touched once.
    fn step_of_grains_alone(&mut self) -> Result<(), Error> {
        let dt = self.settings.grains.dt;
        let farthest = self.evaluate_and_kick::<true>();
        if self.begins_cycle() {
            self.accelerate_bodies()?;
        }
        self.book_grains();
        let timer = self.phases.start();
        self.assembly.drift_glued(farthest, &self.bodies, dt);
        for body in &mut self.bodies {
            body.drift(dt);
        }
        self.phases.stop(Phase::Motion, timer);
        Ok(())
    }

    /// The step of everything, in the one order that fixes every sum.
    fn step_of_all(&mut self) -> Result<(), Error> {
        self.open_page();
        let (begins, ends) = (self.begins_cycle(), self.ends_cycle());
        if begins {
            self.predict_places();
            self.strain_first()?;
        }
        self.evaluate_and_kick::<false>();
        match begins {
            true => {
                self.fill_grid();
                self.book_loads();
                self.accelerate_bodies()?;
            }
            false => self.fill_grid_by_grains(),
        }
        self.book_grains();
        match ends {
            true => {
                self.step_grid()?;
                self.move_membranes()?;
            }
            false => self.share_grid(),
        }
        self.drive_cell()?;
        self.close_page();
        self.drift();
        Ok(())
    }

    pub(crate) fn has_points(&self) -> bool {
        self.points_total > 0
    }

    /// Whether anything goes to nodes of a grid: points without elements, or the vertices of membranes.
    pub(crate) fn has_grid(&self) -> bool {
        (self.has_points() && !self.has_elements()) || !self.continuum.membranes.is_empty()
    }

    pub(crate) fn has_grains(&self) -> bool {
        self.grains_total > 0
    }

    /// Gives copies of other ranks' grains the state of now. Whatever looks at contacts between steps must call this
    /// first: since the last step's drift the copies lag behind.
    pub fn refresh_ghosts(&mut self) {
        if self.has_grains() {
            // Messages of steps alone are counted.
            let sent = self.subdomain.sent;
            self.renew_ghosts(|_| ());
            self.subdomain.sent = sent;
        }
    }

    /// Renews copies and images; `meanwhile` runs while the messages travel and may not look at copies.
    fn renew_ghosts(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        match S::DIMENSION {
            2 => self.renew::<GRAIN_WORDS_PLANE>(meanwhile),
            _ => self.renew::<GRAIN_WORDS_SOLID>(meanwhile),
        }
    }

    fn renew<const W: usize>(&mut self, meanwhile: impl FnOnce(&mut Self)) {
        let timer = self.phases.start();
        self.assembly.contacts.settle_images(&self.assembly.cell);
        self.phases.stop(Phase::Halo, timer);
        self.travel(
            |world| &mut world.subdomain.ghosts,
            // The words of a record begin with those that travel.
            |world, row| -> [f64; W] { std::array::from_fn(|word| world.assembly.grains.hot[row].numbers()[word]) },
            meanwhile,
            |world, row, words| {
                let hot = &mut world.assembly.grains.hot[row];
                for axis in 0..S::DIMENSION {
                    hot.position[axis] = words[axis];
                    hot.velocity[axis] = words[S::DIMENSION + axis];
                }
                for axis in 0..S::Spin::COMPONENTS {
                    hot.spin[axis] = words[2 * S::DIMENSION + axis];
                }
            },
        );
    }

    /// Renews the copies of a halo, one message to each neighbour; `meanwhile` runs while they travel.
    pub(crate) fn travel<const W: usize>(
        &mut self,
        halo: impl Fn(&mut Self) -> &mut Halo,
        pack: impl Fn(&Self, usize) -> [f64; W],
        meanwhile: impl FnOnce(&mut Self),
        mut unpack: impl FnMut(&mut Self, usize, [f64; W]),
    ) {
        let (timer, booked) = (self.phases.start(), self.phases.total());
        let (transport, mut meanwhile) = (self.transport, Some(meanwhile));
        // Out of the world for as long as it is worked on; nothing is copied.
        let (rows, mut buffers) = (mem::take(halo(self)), mem::take(&mut self.subdomain.buffers));
        rows.pack(&mut buffers, |row| pack(self, row as usize));
        rows.exchange::<W>(transport, &mut buffers, &mut || {
            if let Some(meanwhile) = meanwhile.take() {
                meanwhile(self);
            }
        });
        rows.unpack(&buffers, |row, words| unpack(self, row as usize, words));
        self.subdomain.sent += rows.counts::<W>();
        (*halo(self), self.subdomain.buffers) = (rows, buffers);
        self.phases.stop_around(Phase::Halo, timer, booked);
    }

    /// Time over which contacts advance until the coming evaluation, and that over which they turn.
    pub(crate) fn contact_times(&self) -> [f64; 2] {
        self.settings.grains.contact_times(self.step)
    }

    /// The passes over pairs and segments, those that need no copies while copies travel; `finish` is done for every grain that other
    /// grains alone push. Returns the largest that it returned.
    fn evaluate_pairs(&mut self, finish: &impl Finish<S>) -> f64 {
        if !self.has_grains() {
            return 0.0;
        }
        let keeps = self.assembly.keeps_forces(&self.settings.grains) || self.ledger.is_some();
        self.assembly.contacts.keep_forces(keeps);
        let mut farthest = 0.0;
        let mut pass = |world: &mut Self, which: Segments| {
            let timer = world.phases.start();
            let passed = world.assembly.evaluate_pairs(&world.settings.grains, world.step, which, finish);
            world.phases.split(timer.elapsed().as_secs_f64(), &passed);
            farthest = larger(farthest, passed.farthest);
        };
        self.renew_ghosts(|world| pass(world, Segments::Inner));
        pass(self, Segments::Border);
        farthest
    }

    /// Forces on all grains as they stand.
    pub(crate) fn evaluate_contacts(&mut self) {
        self.evaluate(&Wait);
    }

    /// The same, and their kicks; where nothing comes between these and their drift, that as well. Returns the square of the longest way
    /// that a grain has come from home by it, m2.
    fn evaluate_and_kick<const DRIFTS: bool>(&mut self) -> f64 {
        let (field, cell, dt) = (self.settings.grains.field, self.assembly.cell, self.settings.grains.dt);
        let dt_kick = self.kick_share() * dt;
        let spring_share = if self.is_coupled() { self.settings.grid.penalty.part() } else { 0.0 };
        match field.is_plain() && cell.gradient == S::Tensor::zero() {
            true => self.evaluate(&Moves::<_, DRIFTS> {
                kick: Falling { gravity: field.gravity },
                spring_share,
                dt_kick,
                dt,
            }),
            false => self.evaluate(&Moves::<_, DRIFTS> { kick: Damped { field, cell }, spring_share, dt_kick, dt }),
        }
    }

    /// Forces on all grains; `finish` is done for each once all that pushes it is known. Returns the largest that it returned.
    fn evaluate(&mut self, finish: &impl Finish<S>) -> f64 {
        let farthest = self.evaluate_pairs(finish);
        let timer = self.phases.start();
        let rest = self.assembly.evaluate_rest(&self.settings.grains, self.step, &self.bodies, finish);
        self.phases.stop(Phase::Contacts, timer);
        larger(farthest, rest)
    }

    /// Share of the step by which this step's kick moves velocities.
    pub(crate) fn kick_share(&self) -> f64 {
        self.settings.grains.kick_share(self.step)
    }

    /// Height of a node, m.
    pub(crate) fn node_height(&self, place: [i32; 3]) -> f64 {
        self.subdomain.layout.corner[1] + f64::from(place[1]) * self.subdomain.layout.cell
    }

    /// The cell's velocity gradient over the coming drift; grains follow a change of it.
    fn drive_cell(&mut self) -> Result<(), Error> {
        if self.settings.grains.drive.is_at_rest() {
            return Ok(());
        }
        let timer = self.phases.start();
        let drive = self.settings.grains.drive;
        let sums = if drive.looks_at(self.step) { Some(self.strained()?) } else { None };
        self.assembly.drive(&self.settings.grains, sums.as_ref());
        self.phases.stop(Phase::Motion, timer);
        Ok(())
    }

    fn drift(&mut self) {
        let timer = self.phases.start();
        self.assembly.drift(&self.settings.grains, &self.bodies);
        for body in &mut self.bodies {
            body.drift(self.settings.grains.dt);
        }
        self.phases.stop(Phase::Motion, timer);
    }

    /// How far grains and bodies of this rank have come since the last rebuild, how much farther they may come within the next
    /// cycle, and how far points and vertices have come, as shares of what their lists and blocks allow.
    fn drift_shares(&self) -> [f64; 3] {
        let touched =
            |(body, home): (&Body<S>, &S::Vector)| body.is_touched().then(|| (body.displacement - *home).norm());
        let bodies = self.bodies.iter().zip(&self.bodies_home).filter_map(touched).reduce(larger);
        // Points look for bodies at every step; lists are grains' alone.
        let closed =
            self.assembly.closed(&self.settings.grains, bodies.map(|way| if self.has_grains() { way } else { 0.0 }));
        let vertices = if self.is_coupled() { self.continuum.membranes.away_from_home() } else { 0.0 };
        let points = larger(larger(self.continuum.points_outside[0], self.continuum.points_outside[1]), vertices)
            / (DRIFT_MAX * self.subdomain.layout.cell);
        [closed, 2.0 * self.reach_of_cycle() / self.settings.grains.skin, points]
    }

    fn rebuild_if_due(&mut self) -> Result<(), Error> {
        let timer = self.phases.start();
        // Each by itself, for the farthest grain of a rank need not be its fastest.
        let [grains, reach, points] = self.drift_shares();
        let mut most = [grains, reach, points, self.wish.number()];
        self.transport.max(&mut most);
        let [grains, reach, points, wish] = most;
        self.wish_agreed = Wish::of_number(wish);
        self.phases.stop(Phase::Agree, timer);
        if grains >= 1.0 && self.settings.grain_steps > 1 {
            let (step, together) = (self.step, self.settings.grain_steps);
            return Err(Error::Run(format!(
                "step {step}: a grain went farther within {together} steps than lists of contacts reach, so that one may have been missed; take fewer than `time.grain_steps = {together}`"
            )));
        }
        if self.has_elements() {
            return self.deal_elements_if_due();
        }
        if larger(grains + reach, points) < 1.0 {
            return Ok(());
        }
        self.refuse_infinite_points()?;
        self.refuse_strays()?;
        self.rebuild()
    }
}
