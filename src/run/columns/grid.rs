//! Columns of jobs on a grid, of points, of grains, or of both.

use scree_partition::ExactSum;

use super::servo::Watch;
use super::{Columns, of_body, of_symmetric, of_tensor, of_vector, row_of_symmetric, row_of_tensor};
use crate::base::ids::PointId;
use crate::base::space::{AXES, Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::dem::grains::Mover;
use crate::domain::grid::{self, REACTIONS};
use crate::domain::world::World;
use crate::job::mpm::{Boundary, Mpm};
use crate::law::invariants::logarithmic_strain;
use crate::observe::point::{OBSERVED, OBSERVED_OF_RVES, observed, observed_of_rve};
use crate::prepare::rves::stable_step;
use crate::run::Core;
use crate::rve::Scratch;

const FACES: [&str; 2] = ["lower", "upper"];

/// Sums over points and free grains: mass, mass times place, momentum, volume, and volume times stress.
const SUMS: usize = 17;
const PLACE: usize = 1;
const MOMENTUM: usize = 4;
const VOLUME: usize = 7;
const STRESS: usize = 8;

/// Mass (kg), volume (m3), centre of mass (m), momentum (N s), and mean Cauchy stress over the volume (Pa): of points as they are, of
/// grains over their share of space at the solid volume fraction of the start.
pub fn means<S: Space>(depth: f64) -> Columns<'static, S> {
    let mut names: Vec<String> = ["mass", "volume"].map(String::from).into();
    names.extend(of_vector::<S>("centre"));
    names.extend(of_vector::<S>("momentum"));
    names.extend(of_tensor::<S>("stress"));
    Columns::new(names, move |core| {
        let mut sums = ExactSum::<SUMS>::new();
        add_points(&core.world, &mut sums);
        if core.world.grains_total > 0 {
            add_grains(&mut core.world, (depth, core.progress.fraction_start), &mut sums);
        }
        let of = core.world.reduce(sums)?;
        let (mass, volume) = (of[0], of[VOLUME]);
        let mut row = vec![mass, volume];
        row.extend((0..S::DIMENSION).map(|axis| of[PLACE + axis] / mass));
        row.extend((0..S::DIMENSION).map(|axis| of[MOMENTUM + axis]));
        row.extend(row_of_tensor::<S>(|component| of[STRESS + component] / volume));
        Ok(row)
    })
}

fn add_points<S: Space>(world: &World<S>, sums: &mut ExactSum<SUMS>) {
    for (hot, cold) in world.continuum.points.hot.iter().zip(&world.continuum.points.cold) {
        let place = hot.position + world.assembly.cell.shift(cold.image);
        let volume = hot.weight * hot.volume;
        add(sums, hot.weight * hot.mass, volume * hot.volume_ratio(), (&place, &hot.velocity));
        let stress = hot.kirchhoff();
        (0..S::Tensor::COMPONENTS).for_each(|component| sums.add(STRESS + component, volume * stress[component]));
    }
}

fn add_grains<S: Space>(world: &mut World<S>, (depth, fraction): (f64, f64), sums: &mut ExactSum<SUMS>) {
    let grains = &world.assembly.grains;
    for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold) {
        if cold.mover == Mover::Free {
            let volume = S::grain_volume(hot.radius, depth) / fraction;
            let place = hot.position + world.assembly.cell.shift(cold.image);
            add(sums, hot.weight * hot.mass, hot.weight * volume, (&place, &hot.velocity));
        }
    }
    world.refresh_ghosts();
    let (law, grains) = (world.law(), &world.assembly.grains);
    let times = world.contact_times();
    let on_bodies = world.assembly.walls.bearings(law, grains, (&world.bodies, &world.assembly.cell), times);
    let on_grains = (0..grains.owned).flat_map(|row| world.assembly.contacts.bearings(law, grains, row, times));
    for bearing in on_grains.chain(on_bodies) {
        let moment = bearing.moment() * bearing.weight;
        (0..S::Tensor::COMPONENTS).for_each(|component| sums.add(STRESS + component, moment[component]));
    }
}

fn add<V: Linear>(sums: &mut ExactSum<SUMS>, mass: f64, volume: f64, (place, velocity): (&V, &V)) {
    sums.add(0, mass);
    sums.add(VOLUME, volume);
    for axis in 0..V::COMPONENTS {
        sums.add(PLACE + axis, mass * place[axis]);
        sums.add(MOMENTUM + axis, mass * velocity[axis]);
    }
}

/// Energies of points at the last evaluation of forces, J.
pub fn energies_of_points<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["kinetic", "elastic", "potential", "dissipated"], |core| {
        let of = core.world.point_energies()?;
        Ok(vec![of.kinetic, of.elastic, of.potential, of.dissipated])
    })
}

/// Their account ([`crate::domain::accounts::ledger::points`]) at the same evaluation, J.
pub fn account_of_points<'s, S: Space>(averages: bool) -> Columns<'s, S> {
    let names = ["work_loads", "work_bodies", "work_ramp", "dissipated_holds", "energy_lost", "energy_lost_transfer"];
    Columns::new(names.into_iter().chain(averages.then_some(LOST_AVERAGING)), move |core| {
        let of = core.world.point_balance()?.unwrap_or_default();
        let spent = [of.work_loads, of.work_bodies, of.work_ramp, of.holds, of.lost, of.transfer];
        Ok(spent.into_iter().chain(averages.then_some(of.averaging)).collect())
    })
}

/// Energy of hourglass modes of elements, a part of the elastic energy, at the same evaluation, J.
pub fn hourglass<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["hourglass"], |core| Ok(vec![core.world.point_energies()?.beside]))
}

/// Share of the forces of elements that is not in balance at nodes, I_uf, at the same evaluation.
pub fn unbalanced<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["nodes_unbalanced"], |core| Ok(vec![core.world.unbalanced_of_nodes()?]))
}

/// Of what is lost, the part of averaging of volume strain.
const LOST_AVERAGING: &str = "energy_lost_averaging";

/// The same of points that grains may stand beside, under names that tell them from those of grains: work = stored + dissipated + lost.
pub fn account_beside_grains<'s, S: Space>(averages: bool) -> Columns<'s, S> {
    let work = ["work_loads", "work_bodies", "work_ramp", "work_grains"].into_iter();
    let spent = ["energy_stored", "dissipated", "dissipated_holds", "energy_lost", "energy_lost_transfer"];
    let names = work.chain(spent).chain(averages.then_some(LOST_AVERAGING));
    Columns::new(names.map(|name| format!("points_{name}")), move |core| {
        // None before the first step, nor right after grains have entered.
        let of = core.world.point_balance()?.unwrap_or_default();
        let work = [of.work_loads, of.work_bodies, of.work_ramp, of.work_grains];
        let spent = [of.stored, of.dissipated, of.holds, of.lost, of.transfer];
        Ok(work.into_iter().chain(spent).chain(averages.then_some(of.averaging)).collect())
    })
}

/// Nodes that the oracle flags now, and whether there has been a band that persists.
pub fn oracle<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["flagged_nodes", "band"], |core| {
        let progress = &core.progress;
        Ok(vec![progress.oracle.flagged.len() as f64, f64::from(u8::from(progress.enriched_step > 0))])
    })
}

/// Lowest and highest coordinate of points and grains along each axis, m.
pub fn extents<'s, S: Space>() -> Columns<'s, S> {
    let names = AXES[..S::DIMENSION].iter().flat_map(|axis| FACES.map(|end| format!("{end}_{axis}")));
    Columns::new(names, |core: &mut Core<S>| {
        let (world, mut extents) = (&core.world, [f64::NEG_INFINITY; 6]);
        let points = world.continuum.points.hot.iter().map(|hot| (&hot.position, 0.0));
        let grains = &world.assembly.grains;
        let grains = grains.hot[..grains.owned].iter().map(|hot| (&hot.position, hot.radius));
        for (position, radius) in points.chain(grains) {
            for axis in 0..S::DIMENSION {
                extents[2 * axis] = extents[2 * axis].max(radius - position[axis]);
                extents[2 * axis + 1] = extents[2 * axis + 1].max(position[axis] + radius);
            }
        }
        world.transport.max(&mut extents);
        Ok((0..S::DIMENSION).flat_map(|axis| [-extents[2 * axis], extents[2 * axis + 1]]).collect())
    })
}

/// What faces that hold nodes and bodies take of the material, and how far bodies have come: means since the last row, N and N m,
/// and m.
pub fn reactions<S: Space>(job: &Mpm) -> Columns<'_, S> {
    let axes = (0..S::DIMENSION).flat_map(|axis| [(axis, false), (axis, true)]);
    let faces: Vec<(usize, bool)> = axes
        .filter(|(axis, upper)| {
            !matches!(job.boundaries[*axis][usize::from(*upper)], Boundary::Periodic | Boundary::Free)
        })
        .collect();
    let of_face = |(axis, upper): &(usize, bool)| {
        of_vector::<S>(&format!("{}_{}_force", AXES[*axis], FACES[usize::from(*upper)]))
    };
    let of_bodies = job.bodies.iter().flat_map(|body| of_body::<S>(&body.body.name));
    let names: Vec<String> = faces.iter().flat_map(of_face).chain(of_bodies).collect();
    let mut watch = Watch::default();
    Columns::new(names, move |core: &mut Core<S>| {
        let world = &mut core.world;
        let speaker = (world.step, world.transport.rank() == 0);
        let reactions: [f64; REACTIONS] = world.take_reactions()?;
        core.progress.kept.take(&reactions);
        let duration = (world.step - core.progress.series_step) as f64 * world.settings.grains.dt;
        let mut row = Vec::new();
        for (axis, upper) in &faces {
            let impulse = grid::face_impulse(&reactions, *axis, *upper);
            row.extend((0..S::DIMENSION).map(|component| impulse[component] / duration));
        }
        for (number, body) in world.bodies.iter().enumerate() {
            let (impulse, turn) = grid::body_impulse(&reactions, number);
            let mut force = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| force[axis] = impulse[axis] / duration);
            watch.tell(number, body, &force, speaker);
            row.extend((0..S::DIMENSION).map(|axis| impulse[axis] / duration));
            row.extend((0..S::Spin::COMPONENTS).map(|axis| turn[axis] / duration));
            row.extend((0..S::DIMENSION).map(|axis| body.displacement[axis]));
        }
        Ok(row)
    })
}

/// Of each membrane its length, m, and the least and most that its segments bear, N.
pub fn membranes<S: Space>(job: &Mpm) -> Columns<'_, S> {
    let of = |name: &str| ["length", "tension_least", "tension_most"].map(|what| format!("{name}_{what}"));
    Columns::new(job.membranes.iter().flat_map(|membrane| of(&membrane.name)), |core| {
        let membranes = &core.world.continuum.membranes;
        Ok(membranes.made_of.iter().flat_map(|membrane| membranes.stretch(membrane)).collect())
    })
}

/// Volume to the left of all membranes joined end to end, m3; of the plane, with its depth.
pub fn enclosed_volume<'s, S: Space>(depth: f64) -> Columns<'s, S> {
    Columns::new(["enclosed_volume"], move |core| Ok(vec![core.world.continuum.membranes.enclosed() * depth]))
}

/// A point that is followed through time: place, displacement (m), velocity (m/s), what [`OBSERVED`] names, Cauchy stress (Pa) and logarithmic strain.
pub fn followed<'s, S: Space>(name: &str, id: PointId) -> Columns<'s, S> {
    let of = |what: &str| of_vector::<S>(&format!("{name}_{what}"));
    let mut names: Vec<String> = ["place", "displacement", "velocity"].into_iter().flat_map(of).collect();
    names.extend(OBSERVED.iter().map(|what| format!("{name}_{what}")));
    names.extend(["stress", "strain"].iter().flat_map(|what| of_symmetric::<S>(&format!("{name}_{what}"))));
    Columns::new(names, move |core| Ok(follow(&core.world, id)))
}

/// What is told of a point wherever it is; the same on every rank.
fn follow<S: Space>(world: &World<S>, id: PointId) -> Vec<f64> {
    let tensor = S::DIMENSION * (S::DIMENSION + 1) / 2;
    let mut told = vec![0.0; 3 * S::DIMENSION + OBSERVED.len() + 2 * tensor];
    if let Some(row) = world.continuum.points.cold.iter().position(|cold| cold.id == id) {
        let (hot, cold) = (&world.continuum.points.hot[row], &world.continuum.points.cold[row]);
        let place = hot.position + world.assembly.cell.shift(cold.image);
        for axis in 0..S::DIMENSION {
            told[axis] = place[axis];
            told[S::DIMENSION + axis] = place[axis] - cold.origin[axis];
            told[2 * S::DIMENSION + axis] = hot.velocity[axis];
        }
        let stress = hot.kirchhoff() * (1.0 / hot.volume_ratio());
        let strain = logarithmic_strain::<S>(&hot.deformation).tensor();
        let rest = observed(&*world.settings.material, hot).to_vec();
        let rest = [rest, row_of_symmetric::<S>(&stress), row_of_symmetric::<S>(&strain)].concat();
        told[3 * S::DIMENSION..].copy_from_slice(&rest);
    }
    everywhere(world, &told)
}

/// What one rank knows, and the others take for zeros, on every rank.
fn everywhere<S: Space>(world: &World<S>, told: &[f64]) -> Vec<f64> {
    let mut bits: Vec<i64> = told.iter().map(|number| number.to_bits() as i64).collect();
    world.transport.sum(&mut bits);
    bits.into_iter().map(|bits| f64::from_bits(bits as u64)).collect()
}

/// Of the RVEs of all points: steps of their grains since the start, and those of pairs; RVEs without contacts, and those that have been
/// replicated; the largest share of forces that is out of balance, I_uf (Liu et al. 2016, eq. 57); and the stiffest of them, the P-wave modulus
/// if all grains moved with the mean field, Pa, which says whether the step of the continuum is still stable; the void ratio of all together, and contacts
/// of a grain with and without such grains as have none or one (Liu et al. 2016, figures 12 and 13).
pub fn rves<S: Space>(job: &Mpm) -> Columns<'_, S> {
    let names = [
        "rve_steps",
        "rve_pair_steps",
        "rve_loose",
        "rve_replicated",
        "rve_unbalanced_max",
        "rve_modulus_max",
        "rve_void_ratio",
        "rve_coordination",
        "rve_mechanical_coordination",
    ];
    let mut is_told = false;
    Columns::new(names, move |core| {
        let of = core.world.rve_totals()?;
        let bound = stable_step::<S>(job, of.modulus_max);
        if job.step > bound && !is_told && core.world.transport.rank() == 0 {
            is_told = true;
            tracing::warn!(
                "warning: step {}: grains have become as stiff as {:.3e} Pa, all moving with the mean field, which bounds the step of the continuum by {bound:.3e} s, and time.step = {:.3e} s; if energy grows, begin anew with a shorter one",
                core.world.step,
                of.modulus_max,
                job.step
            );
        }
        let counts = [of.steps, of.pair_steps, of.loose, of.replicated].map(|count| count as f64);
        let seen = [of.unbalanced_max, of.modulus_max, of.void_ratio, of.coordination, of.mechanical_coordination];
        Ok(counts.into_iter().chain(seen).collect())
    })
}

/// Of the RVE of a point that is followed.
pub fn followed_rve<'s, S: Space>(name: &str, id: PointId) -> Columns<'s, S> {
    Columns::new(OBSERVED_OF_RVES.iter().map(|what| format!("{name}_{what}")), move |core| {
        let row = core.world.continuum.points.cold.iter().position(|cold| cold.id == id);
        let told = row.map(|row| observed_of_rve(&core.world.rves[row].rve, &mut Scratch::default()));
        Ok(everywhere(&core.world, &told.unwrap_or_default()))
    })
}

/// Whether membranes joined end to end have an inside: one ring, or lines.
pub fn is_enclosed(job: &Mpm) -> bool {
    match &job.membranes[..] {
        [] => false,
        [_] => true,
        several => several.iter().all(|membrane| !membrane.is_closed()),
    }
}
