//! Which grains of the packing enter.

use std::collections::BTreeSet;

use super::motion::Motion;
use super::residents::Residents;
use super::{Refusal, Vector};
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
    pub carried: Carried,
    /// Of the kept grains those around them that stay points.
    pub around: Vec<Grain>,
}

/// What points carry so that no mass is made or lost.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// Weight that points of the new rim keep: what grains and points of the zone weigh differs by less than a grain.
    pub rim: f64,
    /// By which the weights of older rims around are multiplied: other than 1 where grains come back up to the end of the material, and there is no new rim.
    pub older: f64,
}

/// Weights of older rims are not changed by more than this share.
const CARRIED_MAX: f64 = 0.1;

/// A grain of the packing, seen from a zone.
pub(super) enum Stands {
    Away,
    /// It stands there already, m, as one of the residents, near enough to touch those that come.
    Beside([f64; 2]),
    /// The continuum's motion has brought it here, m, where it may enter.
    Near([f64; 2]),
}

/// What tells where a grain of the packing stands.
pub(super) struct Sight<'a> {
    zone: &'a Zone,
    motion: &'a Motion,
    residents: &'a Residents,
    /// Distance to what the zone is around up to which grains are looked at, m.
    reach: f64,
    /// For grains that come back instead: the zone's cells and those around them.
    near: Option<Vec<bool>>,
}

impl<'a> Sight<'a> {
    pub fn of(settings: &Enrichment, zone: &'a Zone, motion: &'a Motion, residents: &'a Residents) -> Self {
        Self { zone, motion, residents, reach: settings.distance + 1.5 * zone.grid.cell, near: None }
    }

    /// Of grains that are kept: the zone may have cells far from where it has grown.
    pub fn of_kept(settings: &Enrichment, zone: &'a Zone, motion: &'a Motion, residents: &'a Residents) -> Self {
        Self { near: Some(zone.within(1)), ..Self::of(settings, zone, motion, residents) }
    }

    /// Whether what comes there, or stands `beside` it, is looked at.
    fn is_near(&self, place: [f64; 2], beside: f64) -> bool {
        let Self { zone, reach, near, .. } = self;
        match near {
            Some(near) => zone.grid.at(place[0], place[1]).is_some_and(|cell| near[cell]),
            None => zone.distance(place) <= reach + beside,
        }
    }

    /// The grain of that number, which has its `origin` in the packing.
    pub fn stands(&self, id: u64, origin: &Vector) -> Stands {
        let Self { zone, motion, residents, .. } = self;
        let last = motion.times.len() - 1;
        if let Some(resident) = residents.get(id) {
            let place = *origin + resident.displacement;
            let place = [place[0], place[1]];
            // Of kept grains the core may have come here from where there is no continuum.
            let is_led = self.near.is_some() || motion.at(last, &resident.led_from).is_some();
            let is_beside = is_led && self.is_near(place, zone.grid.cell);
            return if is_beside { Stands::Beside(place) } else { Stands::Away };
        }
        let Some(way) = motion.at(last, origin) else { return Stands::Away };
        let place = *origin + way;
        let place = [place[0], place[1]];
        match zone.at(place[0], place[1]) == Label::Continuum && !self.is_near(place, 0.0) {
            true => Stands::Away,
            false => Stands::Near(place),
        }
    }
}

/// Those that are to enter where the zone meets these plates, by their numbers. They weigh what the zone's core and rim give up: all of the core's mass, kg, and w of the rim's;
/// points of older rims around have the third mass.
pub(super) fn choose(
    settings: &Enrichment,
    zone: &Zone,
    sight: &Sight<'_>,
    (packing, lies, plates): (&[Grain], Lies<'_>, &[usize]),
    [core, rim_mass, older]: [f64; 3],
) -> Result<Chosen, Refusal> {
    let (mut candidates, mut standing, mut glued) = (Vec::new(), Vec::new(), Vec::new());
    for (row, grain) in packing.iter().enumerate() {
        if let (Mover::Body(plate), None, Lies::Whole) = (grain.cold.mover, sight.residents.get(grain.cold.id.0), lies)
        {
            glued.extend(plates.contains(&usize::from(plate)).then(|| grain.clone()));
            continue;
        }
        let place = match sight.stands(grain.cold.id.0, &grain.cold.origin) {
            Stands::Near(place) => place,
            Stands::Beside(place) => {
                standing.push((row, place));
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
    let has_rim = rim_mass > 0.0;
    let of_core = |candidate: &&Candidate| zone.at(candidate.place[0], candidate.place[1]) == Label::Grains;
    let may_enter: Vec<Candidate> =
        candidates.iter().filter(|candidate| has_rim || of_core(candidate)).copied().collect();
    let selection = select(zone, &may_enter, core, rim_mass, settings.weight);
    let mut rim: Vec<u64> = Vec::new();
    let mut grains = Vec::with_capacity(selection.chosen.len());
    let enter: BTreeSet<usize> = selection.chosen.iter().map(|(row, _)| *row).collect();
    let others = candidates.iter().filter(|candidate| !enter.contains(&candidate.row));
    let (beside, around) = match lies {
        Lies::Kept(_) => {
            // All of the zone's grains are known here: those near others than newcomers have nothing to do with these.
            let entering = candidates.iter().filter(|candidate| enter.contains(&candidate.row));
            let near = cells_around(&zone.grid, entering.map(|candidate| candidate.place));
            let is_near = |place: &[f64; 2]| zone.grid.at(place[0], place[1]).is_some_and(|cell| near[cell]);
            standing.retain(|(_, place)| is_near(place));
            (standing, others.filter(|candidate| is_near(&candidate.place)).map(|candidate| candidate.row).collect())
        }
        Lies::Whole | Lies::Around | Lies::Tiled(_) => (standing, Vec::new()),
    };
    let beside = beside.into_iter().map(|(row, _)| packing[row].clone()).collect();
    let around = around.into_iter().map(|row: usize| packing[row].clone()).collect();
    for (row, in_rim) in selection.chosen {
        grains.push(packing[row].clone());
        if in_rim {
            rim.push(packing[row].cold.id.0);
        }
    }
    rim.sort_unstable();
    let heaviest = grains.iter().map(|grain| grain.hot.mass).fold(0.0, f64::max);
    let off = core + settings.weight * rim_mass - selection.mass;
    let carried = match has_rim {
        true => Carried { rim: selection.point_weight, older: 1.0 },
        false => Carried { rim: 1.0 - settings.weight, older: 1.0 + off / older },
    };
    let is_met = match has_rim {
        // The latter where a zone grows by next to no rim.
        true => off.abs() <= heaviest && (0.0..1.0).contains(&carried.rim),
        // A point that would be whole is of no rim any more.
        false => (carried.older - 1.0).abs() <= CARRIED_MAX && (1.0 - settings.weight) * carried.older < 1.0,
    };
    if !is_met && matches!(lies, Lies::Kept(_)) {
        return Err(Refusal(format!(
            "grains that come back do not weigh what the points in their places do: masses differ by {off:e} kg, a grain weighs {heaviest:e} kg"
        )));
    }
    if !is_met {
        return Err(Refusal(format!(
            "the grains of the packing cannot replace the points of the zone: masses differ by {off:e} kg, a grain weighs {heaviest:e} kg; the fraction of the material at the start (material.fraction) must be near the packing's own, and the zone must lie within the packing (packing.height)"
        )));
    }
    if grains.is_empty() || has_rim && rim.is_empty() {
        return Err(Refusal(
            "the packing has no grains for the zone around the shear band; its height or width differ from the specimen's".into(),
        ));
    }
    Ok(Chosen { grains, beside, glued, rim, carried, around })
}

/// Which cells have one of these places in them or beside them.
fn cells_around(grid: &CellGrid, places: impl Iterator<Item = [f64; 2]>) -> Vec<bool> {
    let mut near = vec![false; grid.counts[0] * grid.counts[1]];
    let cells: BTreeSet<usize> = places.filter_map(|[x, y]| grid.at(x, y)).collect();
    cells.into_iter().flat_map(|cell| grid.around(cell)).for_each(|(cell, _)| near[cell] = true);
    near
}

/// Ids, rising, of the grains within two cells of where the material ends. At a plate whose grains stand it does not. `began` is where points have come from, and `glued` where grains of
/// plates do.
pub(super) fn border(
    grid: &CellGrid,
    began: impl Iterator<Item = Vector>,
    residents: &Residents,
    (chosen, glued): (&[Grain], &[Vector]),
) -> Vec<u64> {
    let mut filled = vec![false; grid.counts[0] * grid.counts[1]];
    let cell_of = |origin: &Vector| grid.at(origin[0], origin[1]);
    let began = began.chain(residents.iter().map(|resident| resident.origin));
    began.filter_map(|place| cell_of(&place)).for_each(|cell| filled[cell] = true);
    // As far as the next two cells beyond the plate's face.
    for cell in glued.iter().filter_map(cell_of).collect::<BTreeSet<usize>>() {
        grid.around(cell).for_each(|(around, _)| filled[around] = true);
    }
    let is_inner = |cell: usize| filled[cell] && grid.beside(cell).filter(|beside| filled[*beside]).count() == 4;
    let inner: Vec<bool> = (0..filled.len()).map(is_inner).collect();
    let is_deep = |cell: usize| inner[cell] && grid.beside(cell).all(|beside| inner[beside]);
    let at_border = |grain: &&Grain| !cell_of(&grain.cold.origin).is_some_and(is_deep);
    let mut border: Vec<u64> = chosen.iter().filter(at_border).map(|grain| grain.cold.id.0).collect();
    border.sort_unstable();
    border
}
