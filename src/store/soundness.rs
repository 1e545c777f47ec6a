//! Whether a snapshot could be the state of a run. The digest tells that a file holds what was written; this, that what was
//! written can be gone on from, whoever wrote it.

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::record::{Record, Visitor};
use crate::base::space::Space;
use crate::dem::grains::{ContactRow, GrainRow, Mover, PenaltySpringRow, is_body};
use crate::dem::memories::Carried;
use crate::rve::Resting;
use crate::store::checkpoint::{Progress, Snapshot};
use crate::store::tables;

/// Steps that the twelve digits of a checkpoint's name count.
const STEP_MAX: u64 = 999_999_999_999;

/// The first field of a record that is no number.
#[derive(Default)]
struct NoNumber(Option<&'static str>);

impl Visitor for NoNumber {
    fn f64s(&mut self, name: &'static str, values: &mut [f64]) {
        if self.0.is_none() && values.iter().any(|value| value.is_nan()) {
            self.0 = Some(name);
        }
    }
    fn u64(&mut self, _: &'static str, _: &mut u64) {}
    fn i64(&mut self, _: &'static str, _: &mut i64) {}
    fn u8(&mut self, _: &'static str, _: &mut u8) {}
}

/// Refuses numbers that are none, grains that stand twice or are nothing, contacts that stand twice, and steps beyond
/// counting.
pub fn refuse_unsound<S: Space>(snapshot: &mut Snapshot<S>) -> Result<(), Error> {
    let progress = &mut snapshot.progress;
    for (name, step) in [("step", progress.step), ("series_step", progress.series_step)] {
        if step > STEP_MAX {
            return bad("run", 0, &format!("{name} = {step}, and at most {STEP_MAX} steps are counted"));
        }
    }
    if progress.series_step > progress.step {
        return bad("run", 0, &format!("series_step = {} comes after step = {}", progress.series_step, progress.step));
    }
    refuse_no_numbers("run", std::slice::from_mut(progress))?;
    refuse_no_numbers("cell", std::slice::from_mut(&mut snapshot.cell))?;
    refuse_no_numbers("cell_home", std::slice::from_mut(&mut snapshot.home.cell))?;
    refuse_no_numbers("bodies", &mut snapshot.bodies)?;
    refuse_no_numbers("points", &mut snapshot.points)?;
    refuse_no_numbers("membranes", &mut snapshot.vertices)?;
    refuse_no_numbers("nodes", snapshot.nodes.as_deref_mut().unwrap_or_default())?;
    refuse_unsound_grains(tables::GRAINS, &mut snapshot.grains)?;
    let springs = snapshot.grains.iter().map(|grain| PenaltySpringRow { grain: grain.cold.id, spring: grain.spring });
    refuse_no_numbers("ties", &mut springs.collect::<Vec<PenaltySpringRow<S>>>())?;
    refuse_unsound_kept(snapshot)?;
    refuse_unsound_rves(snapshot)
}

/// Grains that are kept are found by their ids, and stood with all bodies, which plates among them count on, at the only instant that points remember.
fn refuse_unsound_kept<S: Space>(snapshot: &mut Snapshot<S>) -> Result<(), Error> {
    let (table, bodies) = (tables::KEPT_GRAINS[0], snapshot.bodies.len());
    let Progress { kept_grains, instants, .. } = &mut snapshot.progress;
    if kept_grains.is_empty() {
        return Ok(());
    }
    refuse_unsound_grains(tables::KEPT_GRAINS, &mut kept_grains.grains)?;
    if let Some(row) = kept_grains.grains.windows(2).position(|pair| pair[0].cold.id >= pair[1].cold.id) {
        return bad(table, row + 1, "ids must rise");
    }
    let is_of_none = |mover: Mover| matches!(mover, Mover::Body(body) if usize::from(body) >= bodies);
    if let Some(row) = kept_grains.grains.iter().position(|grain| is_of_none(grain.cold.mover)) {
        return bad(table, row, "it is glued to a body that is not there");
    }
    let seats = &kept_grains.seats;
    if seats.len() != bodies || seats.iter().any(|seat| !seat.iter().all(|component| component.is_finite())) {
        return bad(
            "kept_bodies",
            0,
            &format!("{} displacements of {bodies} bodies, which must be numbers", seats.len()),
        );
    }
    match (instants.every, instants.times.len()) {
        (0, 1) => Ok(()),
        _ => bad("instants", 0, "grains are kept, and there must be one instant, that of this, and none to come"),
    }
}

/// Of the tables of these names, the second that of contacts.
fn refuse_unsound_grains<S: Space>([table, touching]: [&str; 2], grains: &mut [GrainRow<S>]) -> Result<(), Error> {
    refuse_no_numbers(table, grains)?;
    for (row, grain) in grains.iter().enumerate() {
        let (radius, mass) = (grain.hot.radius, grain.hot.mass);
        if !(radius > 0.0 && radius.is_finite() && mass > 0.0 && mass.is_finite()) {
            return bad(table, row, &format!("radius = {radius} and mass = {mass}, and both must be positive"));
        }
        if is_body(grain.cold.id) {
            return bad(table, row, &format!("id = {} stands for a body", grain.cold.id.0));
        }
        if let Some(pair) = grain.contacts.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return bad(table, row, &format!("its contact with {} stands twice", pair[0].0.0));
        }
        let touched =
            |(partner, memory): &Carried| ContactRow { lower: grain.cold.id, higher: *partner, memory: *memory };
        refuse_no_numbers(touching, &mut grain.contacts.iter().map(touched).collect::<Vec<ContactRow>>())?;
    }
    let mut ids: Vec<GrainId> = grains.iter().map(|grain| grain.cold.id).collect();
    ids.sort_unstable();
    match ids.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => bad(table, 0, &format!("id = {} stands twice", pair[0].0)),
        None => Ok(()),
    }
}

/// Every point has one, of the grains of its packing or whole copies of them, whose contacts are among them.
fn refuse_unsound_rves<S: Space>(snapshot: &mut Snapshot<S>) -> Result<(), Error> {
    if snapshot.packings.is_empty() {
        return Ok(());
    }
    refuse_no_numbers("rves", &mut snapshot.rves)?;
    for (row, of) in snapshot.rves.iter().enumerate() {
        let Resting { motions, contacts, memories, .. } = &of.resting;
        let Some(packing) = snapshot.packings.get(of.packing as usize) else {
            return bad("rves", row, &format!("packing = {}, and there are {}", of.packing, snapshot.packings.len()));
        };
        let grains = motions.len() / Resting::<S>::MOTION;
        if grains == 0
            || !motions.len().is_multiple_of(Resting::<S>::MOTION)
            || !grains.is_multiple_of(packing.grains.len())
        {
            return bad("rves", row, &format!("it has {grains} grains, and its packing {}", packing.grains.len()));
        }
        if contacts.iter().any(|[lower, higher]| lower >= higher || usize::from(*higher) >= grains) {
            return bad("rves", row, "a contact is not of two of its grains, the lower first");
        }
        if motions.iter().chain(memories).any(|number| number.is_nan()) {
            return bad("rves", row, "a grain or a contact has what is not a number");
        }
    }
    let mut points: Vec<u64> = snapshot.points.iter().map(|point| point.cold.id.0).collect();
    let mut carried: Vec<u64> = snapshot.rves.iter().map(|row| row.point.0).collect();
    points.sort_unstable();
    carried.sort_unstable();
    match points == carried {
        true => Ok(()),
        false => bad("rves", 0, "they are not those of the points"),
    }
}

fn refuse_no_numbers<R: Record>(table: &str, rows: &mut [R]) -> Result<(), Error> {
    for (row, record) in rows.iter_mut().enumerate() {
        let mut seen = NoNumber::default();
        record.visit(&mut seen);
        if let Some(field) = seen.0 {
            return bad(table, row, &format!("{field} is not a number"));
        }
    }
    Ok(())
}

fn bad(table: &str, row: usize, what: &str) -> Result<(), Error> {
    Err(Error::User(format!(
        "this checkpoint is no state to go on from: table `{table}`, row {row}: {what}. Take an older checkpoint."
    )))
}
