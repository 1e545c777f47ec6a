//! Compression of a periodic cell to a mean stress, straight or from a hot start.
//!
//! Time is measured in t_p = d sqrt(rho/p), in which the stress moves a grain by its own size; a rate of stretch times t_p
//! is the inertial number I (da Cruz et al. 2005). The cell shrinks at I = 1e-2 while grains hardly carry, and at no more
//! than I = 1e-3, where a packing is quasi-static, once they do. Fluctuations against the shrinking cell are damped at the
//! rate 0.2/t_p, which stops grains that drift without contacts, and by local damping of 0.2 for contact laws without
//! dashpots; neither carries stress once grains are at rest. More of either was slower or looser: 1,000 discs with
//! Table 1 of Chen et al. (2021) under 400 kPa equilibrate within 30,000 steps at solid volume fractions of 0.843 to 0.845, as damped
//! compressions with LAMMPS did.
//!
//! What is compressed like this jams early. Denser packings come from a gas: grains without friction and dashpots, with
//! random velocities of the energy p V_grain, are kept under the stress while mass-proportional damping cools them slowly,
//! and find better places before they jam. The slower the cooling, the denser: 0.851 to 0.856 at 0.02/t_p and 0.857 at
//! 0.005/t_p for 500 of those discs, where straight compression gives 0.841.
//!
//! The lower the stress, the longer t_p, and dashpots that stop grains at once make loose ones take longer still: 10,000 discs
//! of Table 1 had not jammed under 2 kPa after a million steps. A packing of that little stress is compressed by more, and
//! unloaded.

use scree_partition::Transport;

use super::{GrainWorld, Packing, gathered, inserted};
use crate::base::error::Error;
use crate::base::space::{AXES, Linear, Space};
use crate::dem::cell::Cell;
use crate::dem::drive::{CellDrive, Response, StressServo};
use crate::dem::grains::GrainRow;
use crate::dem::law::law_of;
use crate::dem::motion::{Damping, DampingForm, Field};
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::job::assembly::{Assembly, Packed};
use crate::job::raw::Typed;
use crate::job::{figures, margin_in_words};
use crate::mpm::membrane::Membranes;
use crate::prepare::grain_world;
use crate::prepare::insert::{normal, random_of};
use crate::prepare::making::{Leg, Look, Making, Notes};
use crate::prepare::sheared::on_root;
use crate::store::checkpoint::{self, Drawn, Progress, Snapshot};

/// Inertial numbers of the shrinking cell: grains that hardly touch, that carry, and of the gas.
const LOOSE: f64 = 1e-2;
const CARRYING: f64 = 1e-3;
const HOT: f64 = 1e-1;
/// Steps between two looks of the servo.
const SERVO_INTERVAL: u64 = 10;
/// Share of the stress from which on grains carry.
const CARRIES: f64 = 0.1;
/// Damping of fluctuations, per t_p and local.
const DAMPING_MASS: f64 = 0.2;
const DAMPING_LOCAL: f64 = 0.2;
/// Cooling of the first gas, per t_p, and the factor to the next.
const COOLING: f64 = 0.02;
const COOLING_FACTOR: f64 = 4.0;
/// Gases that are tried before a solid volume fraction is given up.
const GASES_MAX: u64 = 6;
/// A gas is cold when kinetic energy is below this share of elastic energy.
const COLD: f64 = 1e-2;
/// How exactly a solid volume fraction is to be met, and each normal stress.
const FRACTION_TOLERANCE: f64 = 2e-3;
const STRESS_TOLERANCE: f64 = 0.01;
/// Steps between two looks at whether the packing is at rest, and looks in a row that must find it so.
const LOOK_EVERY: u64 = 200;
const CALM_LOOKS: u32 = 2;
/// Steps after which the cell of loose grains answers half as fast, and again after each of so many more, down to a share of 2^-10: grains that bounce
/// shake the servo, and the cell that follows shakes them; most packings rest long before.
const PATIENCE: u64 = 1_000_000;
const PATIENCE_MORE: u64 = 200_000;
const HALVINGS_MAX: u64 = 10;
/// Steps after which a packing that has not equilibrated is given up.
const STEPS_MAX: u64 = 20_000_000;
/// Length of the cell in largest diameters, as of any periodic axis.
const PERIOD_IN_DIAMETERS: f64 = 4.0;
/// Random numbers of a grain beside those of its size and place: another stream.
const VELOCITIES: u64 = 1 << 63;

/// A compression to be done.
struct Press<'a> {
    job: &'a Assembly,
    packed: &'a Packed,
    /// Pa, compression positive.
    stress: f64,
    /// What it comes to at the end, Pa.
    unloaded: Option<f64>,
}

/// Grains equilibrate under more stress than they had, or under less.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Compressing,
    Unloading,
}

impl Stage {
    fn name(self) -> &'static str {
        match self {
            Self::Compressing => "compressing",
            Self::Unloading => "unloading",
        }
    }
}

/// How the cell answers to a missing stress between two looks: viscosity, Pa s, and largest rate, 1/s.
#[derive(Clone, Copy)]
struct Answer {
    viscosity: f64,
    rate_max: f64,
}

impl Answer {
    const VISCOSITY: &str = "viscosity";
    const RATE_MAX: &str = "largest rate";

    /// What the leg was left with.
    fn noted(notes: &Notes) -> Option<Self> {
        Some(Self { viscosity: notes.get(Self::VISCOSITY)?, rate_max: notes.get(Self::RATE_MAX)? })
    }

    fn note(self, notes: &mut Notes) -> Self {
        notes.set(Self::VISCOSITY, self.viscosity);
        notes.set(Self::RATE_MAX, self.rate_max);
        self
    }
}

/// The solid volume fraction under the stress, while a packing is unloaded from there.
const COMPRESSED: &str = "fraction compressed";

/// Trials and compresses to a stress, to a solid volume fraction if one is wanted, and unloads to a lower stress likewise.
pub fn make<S: Space>(
    job: &Assembly,
    packed: &Packed,
    (stress, wanted, unloaded): (f64, Option<f64>, Option<f64>),
    making: &mut Making,
) -> Result<Packing<S>, Error> {
    if let Some(Complaint { table, key, message }) = complaint::<S>(job, packed) {
        return Err(Error::User(format!("{table}.{key} {message}")));
    }
    let press = Press { job, packed, stress, unloaded };
    let Some(wanted) = wanted else { return Ok(press.attempt(making, 0, None)?.1) };
    let plain = match press.over(making, 0) {
        Some(fraction) => fraction,
        None => {
            let (fraction, packing) = press.attempt::<S>(making, 0, None)?;
            if (fraction - wanted).abs() <= FRACTION_TOLERANCE {
                return Ok(packing);
            }
            if fraction > wanted {
                return Err(Error::User(format!(
                    "packing.fraction = {wanted} is less than compression to {stress} Pa reaches without more ado, {fraction:.4}; take more packing.friction (now {}), which leaves packings looser, or remove packing.fraction",
                    packed.friction
                )));
            }
            fraction
        }
    };
    // Gases of slower or faster cooling, until one ends at the solid volume fraction.
    let (mut looser, mut denser) = (None, None);
    let mut cooling = COOLING;
    let mut nearest = plain;
    for gas in 1..=GASES_MAX {
        let fraction = match press.over(making, gas) {
            Some(fraction) => fraction,
            None => {
                let (fraction, packing) = press.attempt::<S>(making, gas, Some(cooling))?;
                if (fraction - wanted).abs() <= FRACTION_TOLERANCE {
                    return Ok(packing);
                }
                fraction
            }
        };
        if (fraction - wanted).abs() < (nearest - wanted).abs() {
            nearest = fraction;
        }
        if fraction < wanted {
            looser = Some(cooling);
        } else {
            denser = Some(cooling);
        }
        cooling = match (looser, denser) {
            (Some(fast), Some(slow)) => f64::sqrt(fast * slow),
            (_, None) => cooling / COOLING_FACTOR,
            (None, _) => cooling * COOLING_FACTOR,
        };
    }
    Err(Error::Run(format!(
        "packing.fraction = {wanted} was not reached: compression to {stress} Pa gave {plain:.4}, and {GASES_MAX} hot starts came no nearer than {nearest:.4}, which misses it by more than {FRACTION_TOLERANCE}; ask for {nearest:.3}, take another seed, or grains.count"
    )))
}

/// What is wrong at a key of the job, for a sentence that begins with the key.
struct Complaint {
    table: &'static str,
    key: &'static str,
    message: String,
}

/// Refuses, before anything is started, what [`make`] would refuse.
pub(super) fn refuse_bad<S: Space>(job: &Assembly, packed: &Packed, typed: &Typed) -> Result<(), Error> {
    complaint::<S>(job, packed)
        .map_or(Ok(()), |Complaint { table, key, message }| Err(typed.refusal(table, key, &message)))
}

fn complaint<S: Space>(job: &Assembly, packed: &Packed) -> Option<Complaint> {
    complaint_of_bodies::<S>(job).or_else(|| complaint_of_narrow::<S>(job, packed))
}

/// Bodies that grains touch would stand among grains that know nothing of them.
fn complaint_of_bodies<S: Space>(job: &Assembly) -> Option<Complaint> {
    let body = job.bodies.iter().find(|body| grain_world::body_of::<S>(body).is_touched())?;
    let message = format!(
        "fills the whole cell with grains, and body `{}` stands in it. Write \"pour\", remove the body, or read grains.file.",
        body.name
    );
    Some(Complaint { table: "packing", key: "preparation", message })
}

/// A grain must not reach its own image or two images of another. As dense as can be, the cell is smallest.
fn complaint_of_narrow<S: Space>(job: &Assembly, packed: &Packed) -> Option<Complaint> {
    let reach = PERIOD_IN_DIAMETERS * figures::diameter_max(job) + figures::margin(job);
    let cell = grain_world::densest_cell::<S>(job);
    let axis = (0..S::DIMENSION).find(|axis| cell.height(*axis) < reach)?;
    let message = format!(
        "makes {} grains, which fill a cell that is only {:.4e} m long along {}; four of the largest grains and {} need {reach:.4e} m. Take more grains, or give cell.upper another shape.",
        packed.count,
        cell.height(axis),
        AXES[axis],
        margin_in_words(&job.contact)
    );
    Some(Complaint { table: "grains", key: "count", message })
}

/// How fast the cell of loose grains answers after so many steps, as a share: a power of two, so that packings which rest before keep their bits.
pub(super) fn share_of_loose(step: u64) -> f64 {
    let halvings = step.checked_sub(PATIENCE).map_or(0, |late| 1 + late / PATIENCE_MORE).min(HALVINGS_MAX);
    1.0 / (1_u64 << halvings) as f64
}

impl Press<'_> {
    /// t_p, s.
    fn time(&self) -> f64 {
        self.job.matter.diameter_mean * (self.job.matter.density / self.stress).sqrt()
    }

    /// The solid volume fraction that an attempt has come to which is over.
    fn over(&self, making: &mut Making, attempt: u64) -> Option<f64> {
        making.notes().get(&format!("fraction of attempt {attempt}"))
    }

    /// One packing, and its fraction under the stress: from grains at rest, or from a gas with that cooling per t_p.
    fn attempt<S: Space>(
        &self,
        making: &mut Making,
        attempt: u64,
        cooling: Option<f64>,
    ) -> Result<(f64, Packing<S>), Error> {
        making.begin(attempt);
        let mut world = match making.taken_up::<S>(&self.job.contact)? {
            Some(snapshot) => self.taken_up(snapshot, making.transport())?,
            None => self.loose::<S>(cooling.is_some(), making.transport())?,
        };
        if let Some(cooling) = cooling {
            self.cool(&mut world, cooling, making)?;
        }
        self.equilibrate(&mut world, Stage::Compressing, making)?;
        let fraction = match self.unloaded {
            // A state taken up while it was unloaded is no longer the compressed one.
            Some(stress) => {
                let fraction = match making.notes().get(COMPRESSED) {
                    Some(fraction) => fraction,
                    None => grain_world::fraction(&world, self.job)?,
                };
                making.notes().set(COMPRESSED, fraction);
                Press { stress, ..*self }.equilibrate(&mut world, Stage::Unloading, making)?;
                making.notes().forget(COMPRESSED);
                fraction
            }
            None => grain_world::fraction(&world, self.job)?,
        };
        making.notes().set(&format!("fraction of attempt {attempt}"), fraction);
        let grains = gathered(&mut world)?;
        let mut cell = world.assembly.cell;
        (cell.gradient, cell.rate) = (S::Tensor::zero(), S::Tensor::zero());
        tracing::info!(steps = world.step, fraction, cooling, "a packing is at rest");
        Ok((fraction, Packing { grains, cell }))
    }

    /// The world of an attempt where it was left.
    fn taken_up<'t, S: Space>(
        &self,
        snapshot: Option<Snapshot<S>>,
        transport: &'t dyn Transport,
    ) -> Result<GrainWorld<'t, S>, Error> {
        let cell = grain_world::cell_of::<S>(self.job);
        let draw = |_: &Progress, _| Ok(Drawn { cell, bodies: Vec::new(), membranes: Membranes::default() });
        let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
        let settings = grain_world::settings_in(self.job, CellDrive::default());
        World::new(settings, grain_world::layout::<S>(self.job)?, transport, progress.step, parts)
    }

    /// Inserted grains in the cell that is to shrink.
    fn loose<'t, S: Space>(&self, hot: bool, transport: &'t dyn Transport) -> Result<GrainWorld<'t, S>, Error> {
        let share = figures::shrinkage(self.job, self.packed.fraction_start);
        let cell = grain_world::scaled_cell::<S>(self.job, share);
        let made = on_root(transport, || {
            let mut grains = inserted::<S>(self.job, self.packed, &cell, &[])?;
            if hot {
                self.heat(&mut grains);
            }
            Ok(grains)
        });
        let grains = transfer::agree(transport, made)?.unwrap_or_default();
        let settings = grain_world::settings_in(self.job, CellDrive::default());
        let parts = Parts::fresh(grains, Vec::new(), Vec::new(), cell);
        World::new(settings, grain_world::layout::<S>(self.job)?, transport, 0, parts)
    }

    /// Random velocities of the mean energy p V_grain per direction, without momentum.
    fn heat<S: Space>(&self, grains: &mut [GrainRow<S>]) {
        let volume = |grain: &GrainRow<S>| S::grain_volume(grain.hot.radius, self.job.cell.depth);
        let energy = self.stress * grains.iter().map(volume).sum::<f64>() / grains.len() as f64;
        let (mut momentum, mut mass) = (S::Vector::zero(), 0.0);
        for grain in grains.iter_mut() {
            let mut random = random_of(self.job.seed, grain.cold.id.0 | VELOCITIES);
            let speed = (energy / grain.hot.mass).sqrt();
            for axis in 0..S::DIMENSION {
                grain.hot.velocity[axis] = speed * normal(&mut random);
            }
            momentum += grain.hot.velocity * grain.hot.mass;
            mass += grain.hot.mass;
        }
        for grain in grains {
            grain.hot.velocity -= momentum * (1.0 / mass);
        }
    }

    /// How the cell answers to the stress, at an inertial number for grains of a modulus (Pa): the viscosity is the modulus times
    /// the time that a wave takes across the cell, so that stress follows no faster than it can spread.
    fn answer<S: Space>(&self, cell: &Cell<S>, inertial: f64, modulus: f64) -> Answer {
        let length = (0..S::DIMENSION).map(|axis| cell.height(axis)).fold(0.0, f64::max);
        let viscosity = length * (self.job.matter.density * modulus).sqrt();
        Answer { viscosity, rate_max: inertial / self.time() }
    }

    /// The stress on all axes.
    fn drive<S: Space>(&self, answer: Answer) -> CellDrive<S> {
        let servo = StressServo {
            stress: [Some(-self.stress); 3],
            response: Response::Viscosity(answer.viscosity),
            interval: SERVO_INTERVAL,
            rate_max: answer.rate_max,
            depth: grain_world::depth_of::<S>(self.job),
        };
        CellDrive { gradient: S::Tensor::zero(), servo: Some(servo) }
    }

    /// A gas under the stress, cooled until it is cold.
    fn cool<S: Space>(&self, world: &mut GrainWorld<S>, cooling: f64, making: &mut Making) -> Result<(), Error> {
        let leg = Leg { name: "cooling a gas", rebuilds: false, look_every: LOOK_EVERY, calm_looks: 1, goal: COLD };
        let set = |world: &mut GrainWorld<S>, notes: &mut Notes| {
            world.settings.grains.law = law_of(&self.job.contact.without_loss());
            let answer = Answer::noted(notes).unwrap_or_else(|| self.answer(&world.assembly.cell, HOT, self.stress));
            world.settings.grains.drive = self.drive(answer.note(notes));
            let damping = Damping { mass: cooling / self.time(), ..Damping::default() };
            world.settings.grains.field = Field { gravity: S::Vector::zero(), damping };
        };
        making.equilibrate(world, leg, set, |world, notes| {
            // A gas has no grains that bear, and no rattlers: all of it must be cold.
            let energies = world.energies()?;
            let ratio = energies.kinetic_grains / energies.elastic_grains;
            let rests = energies.kinetic_grains < COLD * energies.elastic_grains;
            if !rests {
                // Z = p V/(N kT) rises from about one to the modulus of the contacts over p.
                let energy = 2.0 * energies.kinetic_grains / S::DIMENSION as f64;
                let compressibility = self.stress * grain_world::volume(&world.assembly.cell, self.job) / energy;
                let modulus =
                    (self.stress * (1.0 + compressibility)).min(figures::modulus_under(self.job, self.stress));
                world.settings.grains.drive = self.drive(self.answer(&world.assembly.cell, HOT, modulus).note(notes));
                self.refuse_endless(world, ratio)?;
            }
            Ok(Look { rests, ratio, words: self.words(world)? })
        })
    }

    /// Compresses or unloads under friction and damping until everything rests under the stress.
    fn equilibrate<S: Space>(&self, world: &mut GrainWorld<S>, stage: Stage, making: &mut Making) -> Result<(), Error> {
        let goal = self.packed.energy_ratio_max;
        let leg = Leg { name: stage.name(), rebuilds: true, look_every: LOOK_EVERY, calm_looks: CALM_LOOKS, goal };
        let set = |world: &mut GrainWorld<S>, notes: &mut Notes| {
            world.settings.grains.law = law_of(&self.job.contact.while_compressed(self.packed.friction));
            let damping =
                Damping { local: DAMPING_LOCAL, form: DampingForm::Component, mass: DAMPING_MASS / self.time() };
            world.settings.grains.field = Field { gravity: S::Vector::zero(), damping };
            let first = || self.answer_of_grains(&world.assembly.cell, stage == Stage::Unloading, world.step);
            let answer = Answer::noted(notes).unwrap_or_else(first);
            world.settings.grains.drive = self.drive(answer.note(notes));
        };
        making.equilibrate(world, leg, set, |world, notes| {
            let ratio = world.unrest()?;
            let (stresses, carried) = self.stresses(world)?;
            world.settings.grains.drive =
                self.drive(self.answer_of_grains(&world.assembly.cell, carried >= CARRIES, world.step).note(notes));
            let at_stress = stresses.iter().all(|stress| (stress - 1.0).abs() < STRESS_TOLERANCE);
            self.refuse_endless(world, ratio)?;
            Ok(Look { rests: at_stress && ratio < goal, ratio, words: self.words(world)? })
        })
    }

    /// How the cell answers with grains that are loose or that carry, after so many steps.
    fn answer_of_grains<S: Space>(&self, cell: &Cell<S>, carries: bool, step: u64) -> Answer {
        if carries {
            return self.answer(cell, CARRYING, figures::modulus_under(self.job, self.stress));
        }
        let Answer { viscosity, rate_max } = self.answer(cell, LOOSE, self.stress);
        let share = share_of_loose(step);
        Answer { viscosity: viscosity / share, rate_max: rate_max * share }
    }

    /// Normal stresses of the contacts as shares of the wanted stress (one along axes that there are not), and their mean.
    fn stresses<S: Space>(&self, world: &mut GrainWorld<S>) -> Result<([f64; 3], f64), Error> {
        let moment = world.contact_moment()?;
        let volume = grain_world::volume(&world.assembly.cell, self.job);
        let mut stresses = [1.0; 3];
        for (axis, stress) in stresses.iter_mut().enumerate().take(S::DIMENSION) {
            *stress = -moment[axis * S::DIMENSION + axis] / (volume * self.stress);
        }
        Ok((stresses, stresses[..S::DIMENSION].iter().sum::<f64>() / S::DIMENSION as f64))
    }

    /// How far the packing is.
    fn words<S: Space>(&self, world: &mut GrainWorld<S>) -> Result<String, Error> {
        let (_, stress) = self.stresses(world)?;
        Ok(format!("{stress:.3} of the stress, solid volume fraction {:.4}", grain_world::fraction(world, self.job)?))
    }

    fn refuse_endless<S: Space>(&self, world: &GrainWorld<S>, ratio: f64) -> Result<(), Error> {
        if world.step <= STEPS_MAX {
            return Ok(());
        }
        Err(Error::Run(format!(
            "the packing has not equilibrated under {} Pa after {} steps: kinetic/elastic energy {ratio:.1e} (wanted {:.1e}), solid volume fraction {:.4}; raise packing.energy_ratio_max, or check contact and time.step",
            self.stress,
            world.step,
            self.packed.energy_ratio_max,
            grain_world::fraction(world, self.job)?,
        )))
    }
}
