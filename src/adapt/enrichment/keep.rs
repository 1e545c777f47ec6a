//! Grains that turn into points are kept as they stand, so that they can come back.

use std::collections::BTreeSet;

use super::PlanarPoint;
use super::motion::Motion;
use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::kept::KeptGrains;
use crate::domain::transfer;
use crate::mpm::track::Instants;
use crate::prepare::sheared::{Grain, PlanarWorld};

/// Takes all of this rank's `grains` in, as they stand now, when some of them are to turn into points. Those that have done so before go on along the way of the points since then.
/// Contacts among these are as they were; others begin anew when they come back. Collective.
pub(super) fn keep(
    world: &PlanarWorld,
    grains: &[Grain],
    kept: &mut KeptGrains,
    instants: &Instants,
) -> Result<(), Error> {
    let points: Vec<PlanarPoint> = world.continuum.points.rows().collect();
    let points = transfer::gather(world.transport, points)?;
    let grains = transfer::gather(world.transport, grains.to_vec())?;
    let (Some(mut points), Some(mut grains)) = (points, grains) else { return Ok(()) };
    points.sort_unstable_by_key(|point| point.cold.id);
    let present: BTreeSet<GrainId> = grains.iter().map(|grain| grain.cold.id).collect();
    let mut before = std::mem::take(&mut kept.grains);
    before.retain(|grain| !present.contains(&grain.cold.id));
    if !before.is_empty() {
        let motion = Motion::since_kept(world, &points, instants);
        before.iter_mut().for_each(|grain| move_along(grain, (&motion, world), &present));
    }
    grains.extend(before);
    grains.sort_unstable_by_key(|grain| grain.cold.id);
    kept.grains = grains;
    kept.seats = world.bodies.iter().map(|body| body.displacement).collect();
    Ok(())
}

fn move_along(grain: &mut Grain, (motion, world): (&Motion, &PlanarWorld), present: &BTreeSet<GrainId>) {
    let mut velocity = <Plane as Space>::Vector::zero();
    grain.hot.position += motion.displacement(1, &grain.hot.position.clone());
    let crossed = world.assembly.cell.wrap(&mut grain.hot.position, &mut velocity);
    grain.cold.image.iter_mut().zip(crossed).for_each(|(image, crossed)| *image += crossed);
    grain.contacts.retain(|(partner, _)| !present.contains(partner));
}
