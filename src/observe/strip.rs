//! The strongest straight band: where several bands cross, branch or end inside, as in compression, the box of
//! [`crate::observe::band`] around the most strained 2 % holds them all and says nothing of any of them.
//!
//! 1. *Where.* Strips of 10 mean diameters, which is what bands of grains measure, in all directions and of all lengths from
//!    twice that on are laid over the specimen. Of those that are full of material the one is taken with the largest
//!
//!    ```text
//!    (s - S) sqrt(A)
//!    ```
//!
//!    s its mean strain, S that of the specimen, A the material's area in it: the excess in units of the scatter that a mean
//!    over that area has. Without the root the shortest strip would win, by one hot spot.
//! 2. *Thickness.* Along the strip strain is averaged at every distance from its axis, each row counting over its own diameter
//!    and each mean over two mean diameters. The thickness is that of the unbroken stretch around the largest mean in the strip
//!    in which the mean is at least half of it. No percentile and no box enters; what is averaged over adds next to nothing to
//!    bands of five diameters and more.
//!
//! The share of all strain that lies in the box so found tells whether there is one band: it is most of it where there is, and
//! little where many share the strain.

use crate::math;
use crate::observe::band::Band;

/// Mean diameters across a strip that is looked for, along pieces of strips, and the pieces of the lengths that are tried.
const WIDTH: usize = 10;
const PIECE: f64 = 5.0;
const PIECES: [usize; 9] = [4, 6, 8, 12, 16, 24, 32, 48, 64];
/// Degrees between the directions that are tried.
const TURN_DEG: usize = 1;
/// Share of a strip that is material; of a strip inside grains leave a fifth empty.
const FULL: f64 = 0.7;
/// Distance of the means across the band, and the length that each is taken over, mean diameters.
const STEP: f64 = 0.25;
const MEAN_OVER: f64 = 2.0;
/// A distance at which there is less than this share of the usual material lies outside.
const SPARSE: f64 = 0.3;
const ROUND_OFF: f64 = 1e-9;

/// What is measured: one entry per row.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// m.
    pub positions: &'a [[f64; 2]],
    /// Magnitude of strain; a row with NaN does not take part.
    pub strains: &'a [f64],
    /// Area that each row stands for, m2.
    pub areas: &'a [f64],
    /// Of the disc as large as the row, m.
    pub radii: &'a [f64],
    /// Mean diameter of a grain, m.
    pub diameter: f64,
}

/// A straight band.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Its box; members are the rows inside, the threshold is half of the largest mean strain.
    pub band: Band,
    /// Share of all strain, by area, that lies in the box.
    pub share: f64,
}

/// A strip in a direction: where it begins and how long it is along that, and where its axis is across, m.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Unit vector.
    along: [f64; 2],
    from: f64,
    length: f64,
    across: f64,
}

impl Place {
    /// Coordinates along and across, m.
    fn turned(along: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
        [x * along[0] + y * along[1], y * along[0] - x * along[1]]
    }

    fn back(along: [f64; 2], [a, b]: [f64; 2]) -> [f64; 2] {
        [a * along[0] - b * along[1], a * along[1] + b * along[0]]
    }
}

/// Measures the strongest straight band. None where no strip fits into the material, or strain is the same everywhere.
pub fn strongest(field: &Field) -> Option<Strip> {
    let Field { positions, strains, areas, radii, diameter } = *field;
    let rows = strains.len();
    assert!(positions.len() == rows && areas.len() == rows && radii.len() == rows, "one entry per row");
    let known: Vec<usize> = (0..rows).filter(|&row| strains[row].is_finite()).collect();
    let place = find(field, &known)?;
    let inside = |row: &&usize| {
        let along = Place::turned(place.along, positions[**row])[0] - place.from;
        (0.0..=place.length).contains(&along)
    };
    let strip: Vec<usize> = known.iter().filter(inside).copied().collect();
    let [lower, upper, peak] = across(field, &strip, &place)?;
    let holds = |row: &usize| (lower..=upper).contains(&Place::turned(place.along, positions[*row])[1]);
    let members: Vec<usize> = strip.into_iter().filter(holds).collect();
    let strain = |rows: &[usize]| rows.iter().map(|&row| areas[row] * strains[row]).sum::<f64>();
    let (within, total) = (strain(&members), strain(&known));
    let band = Band {
        thickness: upper - lower,
        length: place.length,
        centre: Place::back(place.along, [place.from + 0.5 * place.length, 0.5 * (lower + upper)]),
        angle: math::atan2(place.along[1], place.along[0]),
        closed: false,
        threshold: 0.5 * peak,
        members,
    };
    (total > 0.0 && diameter > 0.0).then(|| Strip { share: within / total, band })
}

/// Strain times area and area of pieces of strips in one direction: every entry has the sums of all before it in both ways.
struct Sums {
    columns: usize,
    of: Vec<[f64; 2]>,
}

impl Sums {
    fn at(&self, row: usize, column: usize) -> [f64; 2] {
        self.of[row * self.columns + column]
    }

    /// Of `rows` pieces along and `columns` across from there.
    fn within(&self, [row, column]: [usize; 2], [rows, columns]: [usize; 2]) -> [f64; 2] {
        let [a, b] = [self.at(row, column), self.at(row + rows, column + columns)];
        let [c, d] = [self.at(row + rows, column), self.at(row, column + columns)];
        [0, 1].map(|entry| a[entry] + b[entry] - c[entry] - d[entry])
    }
}

/// The strip with the largest excess of strain.
fn find(field: &Field, known: &[usize]) -> Option<Place> {
    let Field { positions, strains, areas, diameter, .. } = *field;
    let sums = |rows: &[usize]| {
        rows.iter().fold([0.0; 2], |[strain, area], &row| [strain + areas[row] * strains[row], area + areas[row]])
    };
    let [strain, area] = sums(known);
    let mean = strain / area;
    let mut best: Option<(f64, Place)> = None;
    for degrees in (0..180).step_by(TURN_DEG) {
        let angle = math::PI * (degrees as f64 / 180.0 - 0.5);
        let along = [math::cos(angle), math::sin(angle)];
        let places: Vec<[f64; 2]> = known.iter().map(|&row| Place::turned(along, positions[row])).collect();
        let least = |axis: usize| places.iter().map(|place| place[axis]).fold(f64::INFINITY, f64::min);
        let [from, below] = [least(0), least(1)];
        let piece = |[a, b]: [f64; 2]| [((a - from) / (PIECE * diameter)) as usize, ((b - below) / diameter) as usize];
        let most = |axis: usize| places.iter().map(|&place| piece(place)[axis] + 1).max().unwrap_or(0);
        let [rows, columns] = [most(0), most(1)];
        let mut sums = Sums { columns: columns + 1, of: vec![[0.0; 2]; (rows + 1) * (columns + 1)] };
        for (&row, &place) in known.iter().zip(&places) {
            let [i, j] = piece(place);
            let sum = &mut sums.of[(i + 1) * (columns + 1) + j + 1];
            *sum = [sum[0] + areas[row] * strains[row], sum[1] + areas[row]];
        }
        for i in 1..=rows {
            for j in 1..=columns {
                let [above, left, corner] = [sums.at(i - 1, j), sums.at(i, j - 1), sums.at(i - 1, j - 1)];
                let sum = &mut sums.of[i * (columns + 1) + j];
                *sum = [0, 1].map(|entry| sum[entry] + above[entry] + left[entry] - corner[entry]);
            }
        }
        for pieces in PIECES.into_iter().filter(|pieces| *pieces <= rows && WIDTH <= columns) {
            let length = pieces as f64 * PIECE * diameter;
            let full = FULL * length * WIDTH as f64 * diameter;
            for i in 0..=rows - pieces {
                for j in 0..=columns - WIDTH {
                    let [strain, area] = sums.within([i, j], [pieces, WIDTH]);
                    let off = if area >= full { strain / area - mean } else { 0.0 };
                    // The same everywhere is no band by its last digits.
                    let excess = if off > ROUND_OFF * mean { off * area.sqrt() } else { 0.0 };
                    if excess > best.map_or(0.0, |(most, _)| most) {
                        let from = from + i as f64 * PIECE * diameter;
                        let across = below + (j as f64 + 0.5 * WIDTH as f64) * diameter;
                        best = Some((excess, Place { along, from, length, across }));
                    }
                }
            }
        }
    }
    best.map(|(_, place)| place)
}

/// Where across the strip the mean strain is at least half of its largest, m, and that largest.
fn across(field: &Field, strip: &[usize], place: &Place) -> Option<[f64; 3]> {
    let Field { positions, strains, areas, radii, diameter } = *field;
    let step = STEP * diameter;
    let middle = |row: usize| Place::turned(place.along, positions[row])[1];
    let lower = strip.iter().map(|&row| middle(row) - radii[row]).fold(f64::INFINITY, f64::min);
    let upper = strip.iter().map(|&row| middle(row) + radii[row]).fold(f64::NEG_INFINITY, f64::max);
    let layers = if upper > lower { ((upper - lower) / step).ceil() as usize } else { return None };
    let mut sums = vec![[0.0; 2]; layers];
    for &row in strip {
        let (from, to) = (middle(row) - radii[row] - lower, middle(row) + radii[row] - lower);
        let inside = (from / step) as usize..((to / step).ceil() as usize).min(layers);
        for (layer, sum) in inside.clone().zip(&mut sums[inside]) {
            let within = to.min((layer + 1) as f64 * step) - from.max(layer as f64 * step);
            let area = areas[row] * (within / (to - from)).max(0.0);
            *sum = [sum[0] + area * strains[row], sum[1] + area];
        }
    }
    let reach = (0.5 * MEAN_OVER / STEP) as usize;
    let usual = {
        let mut areas: Vec<f64> = sums.iter().map(|sum| sum[1]).collect();
        areas.sort_by(f64::total_cmp);
        areas[layers / 2]
    };
    let mean = |layer: usize| {
        if sums[layer][1] < SPARSE * usual {
            return 0.0;
        }
        let around = &sums[layer.saturating_sub(reach)..(layer + reach + 1).min(layers)];
        let [strain, area] = around.iter().fold([0.0; 2], |sum, more| [sum[0] + more[0], sum[1] + more[1]]);
        strain / area
    };
    let means: Vec<f64> = (0..layers).map(mean).collect();
    let near = |layer: &usize| {
        let off = lower + (*layer as f64 + 0.5) * step - place.across;
        off.abs() <= 0.5 * WIDTH as f64 * diameter
    };
    let peak = (0..layers).filter(near).reduce(|best, layer| if means[layer] > means[best] { layer } else { best })?;
    let high = |mean: &&f64| **mean >= 0.5 * means[peak];
    let above = means[peak..].iter().take_while(high).count();
    let below = means[..peak].iter().rev().take_while(high).count();
    let edge = |layer: usize| lower + layer as f64 * step;
    (means[peak] > 0.0).then(|| [edge(peak - below), edge(peak + above), means[peak]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice of discs, 80 by 120, with strains by place.
    fn measured(strain: impl Fn([f64; 2]) -> f64) -> Option<Strip> {
        let positions: Vec<[f64; 2]> =
            (0..80 * 120).map(|row| [(row % 80) as f64 + 0.5, (row / 80) as f64 + 0.5]).collect();
        let strains: Vec<f64> = positions.iter().map(|&place| strain(place)).collect();
        let (areas, radii) = (vec![math::PI / 4.0; strains.len()], vec![0.5; strains.len()]);
        strongest(&Field { positions: &positions, strains: &strains, areas: &areas, radii: &radii, diameter: 1.0 })
    }

    /// Distance from a line through a place.
    fn off([x, y]: [f64; 2], [at_x, at_y]: [f64; 2], degrees: f64) -> f64 {
        let angle = degrees * math::PI / 180.0;
        ((y - at_y) * math::cos(angle) - (x - at_x) * math::sin(angle)).abs()
    }

    fn degrees(strip: &Strip) -> f64 {
        strip.band.angle * 180.0 / math::PI
    }

    #[test]
    fn a_diagonal_band_has_its_thickness_and_slope() {
        for (slope, half) in [(50.0, 5.0), (-50.0, 3.0), (0.0, 8.0), (90.0, 4.0)] {
            let strip = measured(|place| (1.0 - off(place, [40.0, 60.0], slope) / (2.0 * half)).max(0.0)).unwrap();
            let turned = (degrees(&strip) - slope).rem_euclid(180.0);
            assert!(turned.min(180.0 - turned) <= 2.0, "{} instead of {slope}", degrees(&strip));
            assert!((strip.band.thickness - 2.0 * half).abs() <= 1.5, "{} of {half}", strip.band.thickness);
            assert!(strip.share > 0.6, "{}", strip.share);
            let off = strip.band.members.iter().map(|row| ((row % 80) as f64 + 0.5, (row / 80) as f64 + 0.5));
            assert!(off.map(|(x, y)| self::off([x, y], [40.0, 60.0], slope)).fold(0.0, f64::max) < half + 2.0);
        }
    }

    /// The stronger one of two that cross is measured, not both.
    #[test]
    fn of_two_bands_that_cross_the_stronger_is_measured() {
        let strain = |place| {
            let bands = [(48.0, 1.0), (-48.0, 0.7)]
                .map(|(slope, height)| height * (1.0 - off(place, [40.0, 60.0], slope) / 8.0).max(0.0));
            bands[0] + bands[1]
        };
        let strip = measured(strain).unwrap();
        assert!((degrees(&strip) - 48.0).abs() <= 2.0, "{}", degrees(&strip));
        assert!((strip.band.thickness - 8.0).abs() <= 3.0, "{}", strip.band.thickness);
        assert!(strip.share < 0.7, "{}", strip.share);
    }

    /// A hot spot makes no band, and half of a specimen that shears is as thick as it is.
    #[test]
    fn a_band_outweighs_a_spot() {
        let strain = |place: [f64; 2]| {
            let spot =
                if off(place, [20.0, 100.0], 0.0) < 3.0 && off(place, [20.0, 100.0], 90.0) < 3.0 { 3.0 } else { 0.0 };
            spot + (1.0 - off(place, [40.0, 40.0], 30.0) / 10.0).max(0.0)
        };
        let strip = measured(strain).unwrap();
        assert!((degrees(&strip) - 30.0).abs() <= 2.0 && (strip.band.thickness - 10.0).abs() <= 1.5, "{strip:?}");
        assert_eq!(measured(|_| 0.1), None);
        assert_eq!(measured(|_| f64::NAN), None);
    }
}
