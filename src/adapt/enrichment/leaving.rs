//! Which cells of a zone give their grains up: those far from all that shear, where what comes in their place can bear what they do.
//!
//! ```text
//! near      a busy cell is within phi_0, its rim and a cell more
//! narrow    in no square of 3 x 3 filled cells that are not near
//! loaded    in a set of connected cells with sqrt(J2) > rest_strength times the law's peak shear strength at the set's mean stress and Phi
//! ```

use std::collections::BTreeMap;

use super::patches::mobilised;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::patch::Patch;
use crate::couple::zone::CellGrid;
use crate::mpm::stress::SharedMaterial;

type Vector = <Plane as Space>::Vector;

/// Grains do not turn into continuum that is narrower than so many cells: a softening layer of a row or two between a zone and a plate takes the band from the zone.
pub(super) const CELLS_WIDE: usize = 3;
/// Cells that are filled by less than this share, by grains or by points, are no part of what is so wide.
const FILLED_WIDE: f64 = 0.5;

/// What there is in the cells of the plane, as all ranks know it.
pub(super) struct Cells<'a> {
    pub grid: &'a CellGrid,
    /// Of the cells that hold grains.
    pub patches: &'a BTreeMap<u64, Patch>,
    /// How many points each cell holds.
    pub points: &'a [f64],
    /// Points along a full cell.
    pub parts: u64,
    /// Volume of a cell, m3.
    pub room: f64,
    /// Solid volume fraction at the start.
    pub fraction: f64,
}

impl Cells<'_> {
    /// The cells that are not `near` a busy one and give their grains up, or have points already; and of sets that stay because they bear more than the share `most` of the
    /// strength of `law`, what they bear. While a specimen is at its peak grains beside a band rest, but continuum in their place, which softens by itself, would take the band
    /// from them.
    pub fn leaving(&self, near: &[bool], (law, most): (&SharedMaterial<Plane>, f64)) -> (Vec<bool>, Vec<f64>) {
        let is_wide = |cell: usize| !near[cell] && self.is_filled(cell);
        let mut leaves = self.grid.wide(&(0..near.len()).map(is_wide).collect::<Vec<_>>(), CELLS_WIDE);
        let given: Vec<usize> = (0..near.len()).filter(|cell| leaves[*cell] && self.patch(*cell).is_some()).collect();
        let mut loaded = Vec::new();
        for set in self.grid.sets(&given) {
            let Some(mobilised) = self.mobilised(&set, law) else { continue };
            if mobilised > most {
                set.into_iter().for_each(|cell| leaves[cell] = false);
                loaded.push(mobilised);
            }
        }
        // What is hardly filled, at a plate or a membrane, and what holds no grains but points of a rim, goes with the cells beside it.
        let goes_along = |cell: usize| {
            let is_thin = !self.is_filled(cell) || self.patch(cell).is_none();
            is_thin && !near[cell] && self.grid.around(cell).any(|(beside, _)| leaves[beside])
        };
        let along: Vec<usize> = (0..near.len()).filter(|cell| goes_along(*cell)).collect();
        along.into_iter().for_each(|cell| leaves[cell] = true);
        (leaves, loaded)
    }

    fn patch(&self, cell: usize) -> Option<&Patch> {
        self.patches.get(&(cell as u64))
    }

    fn is_filled(&self, cell: usize) -> bool {
        let grains = self.patch(cell).map_or(0.0, |patch| patch.solid / (self.fraction * self.room));
        let points = self.points[cell] / (self.parts * self.parts) as f64;
        grains >= FILLED_WIDE || points >= FILLED_WIDE
    }

    /// What a set of cells bears of the strength of a law, by its full cells outside the rim; none of a set without.
    fn mobilised(&self, set: &[usize], law: &SharedMaterial<Plane>) -> Option<f64> {
        let is_full = |patch: &&Patch| patch.room_full > 0.0 && patch.is_core();
        let mut sum = Patch::default();
        set.iter()
            .filter_map(|cell| self.patch(*cell))
            .filter(is_full)
            .for_each(|patch| sum.add(patch, &Vector::zero()));
        mobilised(&sum, law, self.fraction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::material::{ConstitutiveLaw, MobilisedConstants};
    use crate::mpm::stress::material_of;

    type Tensor = <Plane as Space>::Tensor;

    /// A specimen four columns wide with a period, a row of cells after the other from below: `n` full of grains near a busy cell, `o` full of others, `O` of such as bear more
    /// than the law, `r` of grains of the rim with points, `s` a few grains, `.` points, `,` one point. `x` are those that leave.
    fn leaving(rows: &[&str]) -> (Vec<String>, usize) {
        let (room, fraction, parts) = (1e-6, 0.84, 2);
        let grid = CellGrid { counts: [4, rows.len()], cell: 1e-2, lower: [0.0; 2], periodic: true };
        let marks: Vec<char> = rows.concat().chars().collect();
        let patch = |mark: char| {
            let (share, core, shear) = match mark {
                'n' | 'o' => (1.0, 1.0, 30e3),
                'O' => (1.0, 1.0, 60e3),
                // A single grain of the core among them, without a contact.
                'r' => (1.0, 0.02, 0.0),
                's' => (0.1, 1.0, 60e3),
                _ => return None,
            };
            let mut patch = Patch::default();
            patch.solid = share * fraction * room;
            (patch.mass, patch.core) = (patch.solid, core * patch.solid);
            patch.solid_core = core * patch.solid;
            patch.moment = Tensor::new(-100e3, shear, shear, -100e3) * (share * core * room);
            if mark == 'r' {
                patch.moment = Tensor::zero();
            }
            if share == 1.0 {
                (patch.room_full, patch.solid_full) = (room, patch.solid);
            }
            Some(patch)
        };
        let patches = (0..).zip(&marks).filter_map(|(cell, mark)| Some((cell, patch(*mark)?))).collect();
        let points: Vec<f64> = marks
            .iter()
            .map(|mark| match mark {
                '.' | 'r' => 4.0,
                ',' => 1.0,
                _ => 0.0,
            })
            .collect();
        let near: Vec<bool> = marks.iter().map(|mark| *mark == 'n').collect();
        let cells = Cells { grid: &grid, patches: &patches, points: &points, parts, room, fraction };
        let law = material_of(&ConstitutiveLaw::MobilisedFriction(MobilisedConstants::DISCS));
        let (leaves, loaded) = cells.leaving(&near, (&law, 0.9));
        let mark = |(cell, mark): (usize, &char)| if leaves[cell] { 'x' } else { *mark };
        let told: Vec<char> = marks.iter().enumerate().map(mark).collect();
        (told.chunks(4).map(|row| row.iter().collect()).collect(), loaded.len())
    }

    #[test]
    fn rows_between_a_zone_and_a_plate_stay_grains_unless_they_are_three() {
        let (told, _) = leaving(&["oooo", "oooo", "nnnn", "oooo", "oooo", "oooo"]);
        assert_eq!(told, ["oooo", "oooo", "nnnn", "xxxx", "xxxx", "xxxx"]);
        // A sliver that a plate has left makes no row; beside three rows it goes with them.
        let (told, _) = leaving(&["ssss", "oooo", "oooo", "nnnn", "oooo", "oooo", "oooo", "s  s"]);
        assert_eq!(told, ["ssss", "oooo", "oooo", "nnnn", "xxxx", "xxxx", "xxxx", "xxxx"]);
        // Points that are there count.
        let (told, _) = leaving(&["nnnn", "oooo", "rrrr", "....", ",,,,"]);
        assert_eq!(told, ["nnnn", "xxxx", "xxxx", "xxxx", "xxxx"]);
    }

    #[test]
    fn a_set_that_bears_all_that_the_continuum_bears_stays() {
        let (told, loaded) = leaving(&["oooo", "oooo", "oooo", "nnnn", "OOOO", "OOOO", "OOOO"]);
        assert_eq!(
            (told, loaded),
            (["xxxx", "xxxx", "xxxx", "nnnn", "OOOO", "OOOO", "OOOO"].map(String::from).to_vec(), 1)
        );
    }

    /// A rim was judged by single grains of the core in it and never left.
    #[test]
    fn a_rim_is_not_judged_by_the_grains_that_strayed_into_it() {
        let (told, loaded) = leaving(&["nnnn", "rrrr", "....", "...."]);
        assert_eq!((told, loaded), (["nnnn", "xxxx", "xxxx", "xxxx"].map(String::from).to_vec(), 0));
    }
}
