//! Which grains of the packing enter.

use std::collections::BTreeSet;

use super::motion::Motion;
use super::residents::Residents;
use super::{PlanarPoint, Refusal, Vector};
use crate::couple::select::{Candidate, select};
use crate::couple::zone::{CellGrid, Enrichment, Label, Zone};
use crate::dem::grains::Mover;
use crate::prepare::reference::Lies;
use crate::prepare::sheared::Grain;

pub(super) struct Chosen {
    pub grains: Vec<Grain>,
    /// Grains of the packing that stand beside them already.
    pub beside: Vec<Grain>,
    /// All grains of the plates that the zone meets, but for those that stand already.
    pub glued: Vec<Grain>,
    /// Ids of rim grains, rising.
    pub rim: Vec<u64>,
    /// Weight that points of the rim keep.
    pub point_weight: f64,
}

/// A grain of the packing, seen from a zone.
pub(super) enum Stands {
    Away,
    /// It stands there already, as one of the residents, near enough to touch those that come.
    Beside,
    /// The continuum's motion has brought it here, m, where it may enter.
    Near([f64; 2]),
}

/// What tells where a grain of the packing stands.
pub(super) struct Sight<'a> {
    zone: &'a Zone,
    motion: &'a Motion,
    residents: &'a Residents,
    /// Distance to the flagged nodes up to which grains are looked at, m.
    reach: f64,
}

impl<'a> Sight<'a> {
    pub fn of(settings: &Enrichment, zone: &'a Zone, motion: &'a Motion, residents: &'a Residents) -> Self {
        Self { zone, motion, residents, reach: settings.distance + 1.5 * zone.grid.cell }
    }

    /// The grain of that number, which has its `origin` in the packing.
    pub fn stands(&self, id: u64, origin: &Vector) -> Stands {
        let Self { zone, motion, residents, reach } = self;
        let last = motion.times.len() - 1;
        if let Some(resident) = residents.get(id) {
            let place = *origin + resident.displacement;
            let is_beside = zone.distance([place[0], place[1]]) <= reach + zone.grid.cell
                && motion.at(last, &resident.led_from).is_some();
            return if is_beside { Stands::Beside } else { Stands::Away };
        }
        let Some(way) = motion.at(last, origin) else { return Stands::Away };
        let place = *origin + way;
        let place = [place[0], place[1]];
        match zone.at(place[0], place[1]) == Label::Continuum && zone.distance(place) > *reach {
            true => Stands::Away,
            false => Stands::Near(place),
        }
    }
}

/// Those that are to enter where the zone meets these plates, by their numbers. They weigh what the zone's `[core, rim]` give up: all of the core's mass, kg, and w of the rim's.
pub(super) fn choose(
    settings: &Enrichment,
    zone: &Zone,
    sight: &Sight<'_>,
    (packing, lies, plates): (&[Grain], Lies<'_>, &[usize]),
    [core, rim_mass]: [f64; 2],
) -> Result<Chosen, Refusal> {
    let (mut candidates, mut beside, mut glued) = (Vec::new(), Vec::new(), Vec::new());
    for (row, grain) in packing.iter().enumerate() {
        if let (Mover::Body(plate), None, Lies::Whole) = (grain.cold.mover, sight.residents.get(grain.cold.id.0), lies)
        {
            glued.extend(plates.contains(&usize::from(plate)).then(|| grain.clone()));
            continue;
        }
        let place = match sight.stands(grain.cold.id.0, &grain.cold.origin) {
            Stands::Near(place) => place,
            Stands::Beside => {
                beside.push(grain.clone());
                continue;
            }
            Stands::Away => continue,
        };
        if grain.cold.mover != Mover::Free {
            return Err(Refusal(
                "the zone around the shear band reaches the end of a packing that is not as high as the specimen; lower `enrichment.distance`, or raise `packing.height`".into(),
            ));
        }
        candidates.push(Candidate { row, id: grain.cold.id.0, mass: grain.hot.mass, place });
    }
    let selection = select(zone, &candidates, core, rim_mass, settings.weight);
    let mut rim: Vec<u64> = Vec::new();
    let mut grains = Vec::with_capacity(selection.chosen.len());
    for (row, in_rim) in selection.chosen {
        grains.push(packing[row].clone());
        if in_rim {
            rim.push(packing[row].cold.id.0);
        }
    }
    rim.sort_unstable();
    let heaviest = grains.iter().map(|grain| grain.hot.mass).fold(0.0, f64::max);
    let off = (selection.point_weight - (1.0 - settings.weight)) * rim_mass;
    // The latter where a zone grows by next to no rim.
    if off.abs() > heaviest || !(0.0..1.0).contains(&selection.point_weight) {
        return Err(Refusal(format!(
            "the grains of the packing cannot replace the points of the zone: masses differ by {off:e} kg, a grain weighs {heaviest:e} kg; the fraction of the material at the start (material.fraction) must be near the packing's own, and the zone must lie within the packing (packing.height)"
        )));
    }
    if grains.is_empty() || rim.is_empty() {
        return Err(Refusal(
            "the packing has no grains for the zone around the shear band; its height or width differ from the specimen's".into(),
        ));
    }
    Ok(Chosen { grains, beside, glued, rim, point_weight: selection.point_weight })
}

/// Ids, rising, of the grains within two cells of where the material ends. At a plate whose grains stand it does not.
pub(super) fn border(grid: &CellGrid, points: &[PlanarPoint], residents: &Residents, chosen: &Chosen) -> Vec<u64> {
    let mut filled = vec![false; grid.counts[0] * grid.counts[1]];
    let cell_of = |origin: &Vector| grid.at(origin[0], origin[1]);
    let began = points.iter().map(|point| &point.cold.origin).chain(residents.iter().map(|resident| &resident.origin));
    began.filter_map(cell_of).for_each(|cell| filled[cell] = true);
    // As far as the next two cells beyond the plate's face.
    for cell in chosen.glued.iter().filter_map(|grain| cell_of(&grain.cold.origin)).collect::<BTreeSet<usize>>() {
        grid.around(cell).for_each(|(around, _)| filled[around] = true);
    }
    let is_inner = |cell: usize| filled[cell] && grid.beside(cell).filter(|beside| filled[*beside]).count() == 4;
    let inner: Vec<bool> = (0..filled.len()).map(is_inner).collect();
    let is_deep = |cell: usize| inner[cell] && grid.beside(cell).all(|beside| inner[beside]);
    let at_border = |grain: &&Grain| !cell_of(&grain.cold.origin).is_some_and(is_deep);
    let mut border: Vec<u64> = chosen.grains.iter().filter(at_border).map(|grain| grain.cold.id.0).collect();
    border.sort_unstable();
    border
}
