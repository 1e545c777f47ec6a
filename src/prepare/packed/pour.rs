//! Grains that fall from where they were inserted, under the job's gravity, onto its bodies, which stand still meanwhile.
//!
//! They rest when their kinetic energy is below `packing.energy_ratio_max` of m g d each in the mean, and the bodies carry
//! their weight to 1 %. Falling is damped at the rate 0.1 sqrt(g/d), which bounds the speed by 10 sqrt(g d) so that no grain
//! hits the others hard, and forces by local damping; neither carries weight once grains are at rest.

use scree_partition::ExactSum;

use super::{GrainWorld, Packing, gathered, inserted};
use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::dem::drive::CellDrive;
use crate::dem::law::law_of;
use crate::dem::motion::{Damping, DampingForm, Field};
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::job::assembly::{Assembly, Packed};
use crate::mpm::membrane::Membranes;
use crate::prepare::grain_world;
use crate::prepare::making::{Leg, Look, Making};
use crate::prepare::sheared::on_root;
use crate::store::checkpoint::{self, Drawn, Progress};

/// Damping of velocity in sqrt(g/d), and local damping.
const DAMPING_MASS: f64 = 0.1;
const DAMPING_LOCAL: f64 = 0.3;
/// How exactly the bodies must carry the weight.
const WEIGHT_TOLERANCE: f64 = 0.01;
/// Steps between two looks at whether the grains are at rest, and looks in a row that must find them so.
const LOOK_EVERY: u64 = 200;
const CALM_LOOKS: u32 = 2;
/// Time after which grains that have not equilibrated are given up, in falls through the whole cell.
const FALLS_MAX: f64 = 300.0;

/// Trials the grains into the cell and lets them fall.
pub fn make<S: Space>(job: &Assembly, packed: &Packed, making: &mut Making) -> Result<Packing<S>, Error> {
    let transport = making.transport();
    let cell = grain_world::cell_of::<S>(job);
    let bodies: Vec<Body<S>> = job.bodies.iter().map(|body| still(grain_world::body_of(body))).collect();
    let gravity = grain_world::vector::<S>(&job.gravity);
    let damping = Damping {
        local: DAMPING_LOCAL,
        form: DampingForm::Component,
        mass: DAMPING_MASS * (gravity.norm() / job.matter.diameter_mean).sqrt(),
    };
    let mut settings = grain_world::settings_in::<S>(job, CellDrive::default());
    settings.grains.law = law_of(&job.contact.with_friction(packed.friction));
    settings.grains.field = Field { gravity, damping };
    making.begin(0);
    let (parts, step) = match making.taken_up::<S>(&job.contact)? {
        Some(snapshot) => {
            let draw = |_: &Progress, _| Ok(Drawn { cell, bodies, membranes: Membranes::default() });
            let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
            (parts, progress.step)
        }
        None => {
            let grains = on_root(transport, || inserted::<S>(job, packed, &cell, &bodies));
            let grains = transfer::agree(transport, grains)?.unwrap_or_default();
            (Parts::fresh(grains, Vec::new(), bodies, cell), 0)
        }
    };
    let mut world: GrainWorld<S> = World::new(settings, grain_world::layout::<S>(job)?, transport, step, parts)?;
    settle(job, packed, &mut world, making)?;
    tracing::info!(steps = world.step, "the grains are at rest");
    Ok(Packing { grains: gathered(&mut world)?, cell })
}

/// The body where it is at the start of the run.
fn still<S: Space>(mut body: Body<S>) -> Body<S> {
    body.path.clear();
    body.servo = None;
    body
}

fn settle<S: Space>(
    job: &Assembly,
    packed: &Packed,
    world: &mut GrainWorld<S>,
    making: &mut Making,
) -> Result<(), Error> {
    let gravity = world.settings.grains.field.gravity;
    let weight = world.holdings()?.mass * gravity.norm();
    let (goal, energy) = (packed.energy_ratio_max, weight * job.matter.diameter_mean);
    let height = (0..S::DIMENSION).map(|axis| world.assembly.cell.height(axis)).fold(0.0, f64::max);
    // From rest, with what damping leaves of gravity.
    let fall = (2.0 * height / ((1.0 - DAMPING_LOCAL) * gravity.norm())).sqrt();
    let steps_max = (FALLS_MAX * fall / job.step) as u64;
    let leg = Leg { name: "pouring", rebuilds: false, look_every: LOOK_EVERY, calm_looks: CALM_LOOKS, goal };
    making.equilibrate(world, leg, |_, _| (), |world, _| {
        // Whoever still falls bears nothing yet: all grains count.
        let ratio = world.energies()?.kinetic_grains / energy;
        let carried = carried(world)? / weight;
        if world.step > steps_max {
            return Err(Error::Run(format!(
                "the poured grains have not equilibrated after {} steps: the bodies carry {carried:.3} of their weight, and their kinetic energy is {ratio:.1e} of m g d (wanted {goal:.1e}); see whether the bodies hold them from all sides, raise packing.energy_ratio_max, or check contact and time.step",
                world.step,
            )));
        }
        let rests = ratio < goal && (carried - 1.0).abs() < WEIGHT_TOLERANCE;
        Ok(Look { rests, ratio, words: format!("the bodies carry {carried:.3} of the weight") })
    })
}

/// Force of the bodies on the grains against gravity, N, of the last step.
fn carried<S: Space>(world: &GrainWorld<S>) -> Result<f64, Error> {
    let gravity = world.settings.grains.field.gravity;
    let mut sum = ExactSum::<1>::new();
    for wall in &world.assembly.walls.list {
        sum.add(0, -wall.force.dot(&gravity) / gravity.norm());
    }
    Ok(world.reduce(sum)?[0])
}
