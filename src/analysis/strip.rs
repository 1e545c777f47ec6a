//! The strongest straight band: where several bands cross, branch or end inside, as in compression, the box of
//! [`crate::analysis::band`] around the most strained 2 % holds them all and says nothing of any of them.
//!
//! 1. *Where.* Strips of 10 mean diameters, which is what bands of grains measure, in all directions and of nine lengths from
//!    twice that on are laid over the specimen. Of those that are full of material the one is taken with the largest
//!
//!    ```text
//!    (s - S) sqrt(A)
//!    ```
//!
//!    s its mean strain, S that of the specimen, A the material's area in it: the excess in units of the scatter that a mean
//!    over that area has. Without the root the shortest strip would win, by one hot spot.
//!    It is then turned about its middle, by a few degrees, to where strain across it has the largest mean square.
//! 2. *Thickness.* Along the strip strain is averaged at every distance from its axis, each row counting over its own diameter
//!    and each mean over two mean diameters. The thickness is that of the unbroken stretch around the largest mean in the strip
//!    in which the mean is at least half of it. No percentile and no box enters; what is averaged over adds next to nothing to
//!    bands of five diameters and more.
//!
//! The share of all strain that lies in the box so found tells whether there is one band: it is most of it where there is, and
//! little where many share the strain.

use crate::analysis::band::Band;
use crate::base::math;

/// Mean diameters across a strip that is looked for, along pieces of strips, and the pieces of the lengths that are tried.
const WIDTH: usize = 10;
const PIECE: f64 = 5.0;
const PIECES: [usize; 9] = [4, 6, 8, 12, 16, 24, 32, 48, 64];
/// Degrees between the directions that are tried, and by which a strip that was found may be askew.
const TURN_DEG: usize = 1;
const ASKEW_DEG: usize = 8;
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

/// A strip: its middle, m, the direction of its axis, degrees from the x axis, and its length, m.
#[derive(Clone, Copy, Debug)]
struct Place {
    centre: [f64; 2],
    degrees: f64,
    length: f64,
}

impl Place {
    /// Unit vector.
    fn along(&self) -> [f64; 2] {
        let angle = self.degrees * math::PI / 180.0;
        [math::cos(angle), math::sin(angle)]
    }
}

/// Coordinates along and across a direction, m.
fn turned(along: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [x * along[0] + y * along[1], y * along[0] - x * along[1]]
}

fn turned_back(along: [f64; 2], [a, b]: [f64; 2]) -> [f64; 2] {
    [a * along[0] - b * along[1], a * along[1] + b * along[0]]
}

/// Measures the strongest straight band. None where no strip fits into the material, or strain is the same everywhere.
pub fn strongest(field: &Field) -> Option<Strip> {
    let Field { positions, strains, areas, radii, .. } = *field;
    let rows = strains.len();
    assert!(positions.len() == rows && areas.len() == rows && radii.len() == rows, "one entry per row");
    let known: Vec<usize> = (0..rows).filter(|&row| strains[row].is_finite()).collect();
    let place = sharpest(field, &known, find(field, &known)?);
    let profile = Profile::of(field, &known, &place, f64::INFINITY)?;
    let [lower, upper, peak] = profile.high(field.diameter)?;
    let within = |row: &usize| (lower..=upper).contains(&profile.off(field, *row));
    let members: Vec<usize> = profile.rows.iter().copied().filter(within).collect();
    let strain = |rows: &[usize]| rows.iter().map(|&row| areas[row] * strains[row]).sum::<f64>();
    let share = strain(&members) / strain(&known);
    let [dx, dy] = turned_back(place.along(), [0.0, 0.5 * (lower + upper)]);
    let band = Band {
        thickness: upper - lower,
        length: place.length,
        centre: [place.centre[0] + dx, place.centre[1] + dy],
        angle: place.degrees * math::PI / 180.0,
        closed: false,
        threshold: 0.5 * peak,
        members,
    };
    Some(Strip { share, band })
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
        let mut place = Place { centre: [0.0; 2], degrees: degrees as f64 - 90.0, length: 0.0 };
        let along = place.along();
        let places: Vec<[f64; 2]> = known.iter().map(|&row| turned(along, positions[row])).collect();
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
                        let middle = from + (i as f64 + 0.5 * pieces as f64) * PIECE * diameter;
                        let across = below + (j as f64 + 0.5 * WIDTH as f64) * diameter;
                        place.centre = turned_back(along, [middle, across]);
                        place.length = length;
                        best = Some((excess, place));
                    }
                }
            }
        }
    }
    best.map(|(_, place)| place)
}

/// The strip turned about its middle such that the profile of strain across it is sharpest, the band least smeared: where its
/// mean square is largest. A strip broader than a band holds it when it is a little askew, too.
fn sharpest(field: &Field, known: &[usize], place: Place) -> Place {
    let sharpness = |place: &Place| {
        Profile::of(field, known, place, WIDTH as f64 * field.diameter).map_or(0.0, |profile| profile.sharpness())
    };
    let mut best = (sharpness(&place), place);
    for degrees in (1..=ASKEW_DEG).flat_map(|degrees| [degrees as f64, -(degrees as f64)]) {
        let turned = Place { degrees: place.degrees + degrees, ..place };
        let sharpness = sharpness(&turned);
        if sharpness > best.0 {
            best = (sharpness, turned);
        }
    }
    let degrees = best.1.degrees;
    Place {
        degrees: if degrees > 90.0 {
            degrees - 180.0
        } else if degrees <= -90.0 {
            degrees + 180.0
        } else {
            degrees
        },
        ..best.1
    }
}

/// Strain across a strip, in layers of [`STEP`].
struct Profile {
    place: Place,
    /// Rows in it, ascending.
    rows: Vec<usize>,
    /// Where the first layer begins, and how thick layers are, m.
    lower: f64,
    step: f64,
    /// Strain times area and area of every layer.
    sums: Vec<[f64; 2]>,
}

impl Profile {
    /// Of the rows within that distance from the axis, m.
    fn of(field: &Field, known: &[usize], place: &Place, reach: f64) -> Option<Self> {
        let Field { positions, strains, areas, radii, diameter } = *field;
        let along = place.along();
        let seen =
            |row: usize| turned(along, [positions[row][0] - place.centre[0], positions[row][1] - place.centre[1]]);
        let inside = |row: &usize| {
            let [a, b] = seen(*row);
            a.abs() <= 0.5 * place.length && b.abs() <= reach
        };
        let rows: Vec<usize> = known.iter().copied().filter(inside).collect();
        let lower = rows.iter().map(|&row| seen(row)[1] - radii[row]).fold(f64::INFINITY, f64::min);
        let upper = rows.iter().map(|&row| seen(row)[1] + radii[row]).fold(f64::NEG_INFINITY, f64::max);
        let step = STEP * diameter;
        let layers = if upper > lower { ((upper - lower) / step).ceil() as usize } else { return None };
        let mut sums = vec![[0.0; 2]; layers];
        for &row in &rows {
            let middle = seen(row)[1] - lower;
            let (from, to) = (middle - radii[row], middle + radii[row]);
            let inside = (from / step) as usize..((to / step).ceil() as usize).min(layers);
            for (layer, sum) in inside.clone().zip(&mut sums[inside]) {
                let within = to.min((layer + 1) as f64 * step) - from.max(layer as f64 * step);
                let area = areas[row] * (within / (to - from)).max(0.0);
                *sum = [sum[0] + area * strains[row], sum[1] + area];
            }
        }
        Some(Self { place: *place, rows, lower, step, sums })
    }

    /// Distance of a row from the axis, m.
    fn off(&self, field: &Field, row: usize) -> f64 {
        let [x, y] = field.positions[row];
        turned(self.place.along(), [x - self.place.centre[0], y - self.place.centre[1]])[1]
    }

    /// Mean square of the layers' mean strains over the square of their mean.
    fn sharpness(&self) -> f64 {
        let add = |[square, strain, area]: [f64; 3], &[own, over]: &[f64; 2]| {
            if over > 0.0 { [square + own * own / over, strain + own, area + over] } else { [square, strain, area] }
        };
        let [square, strain, area] = self.sums.iter().fold([0.0; 3], add);
        if strain > 0.0 { square * area / (strain * strain) } else { 0.0 }
    }

    /// Where the mean strain is at least half of its largest near the axis, m from that, and that largest.
    fn high(&self, diameter: f64) -> Option<[f64; 3]> {
        let layers = self.sums.len();
        let reach = (0.5 * MEAN_OVER / STEP) as usize;
        let usual = {
            let mut areas: Vec<f64> = self.sums.iter().map(|sum| sum[1]).collect();
            areas.sort_by(f64::total_cmp);
            areas[layers / 2]
        };
        let mean = |layer: usize| {
            if self.sums[layer][1] < SPARSE * usual {
                return 0.0;
            }
            let around = &self.sums[layer.saturating_sub(reach)..(layer + reach + 1).min(layers)];
            let [strain, area] = around.iter().fold([0.0; 2], |sum, more| [sum[0] + more[0], sum[1] + more[1]]);
            strain / area
        };
        let means: Vec<f64> = (0..layers).map(mean).collect();
        let edge = |layer: usize| self.lower + layer as f64 * self.step;
        let near = |layer: &usize| (edge(*layer) + 0.5 * self.step).abs() <= 0.5 * WIDTH as f64 * diameter;
        let most = |best: usize, layer: usize| if means[layer] > means[best] { layer } else { best };
        let peak = (0..layers).filter(near).reduce(most)?;
        let high = |mean: &&f64| **mean >= 0.5 * means[peak];
        let above = means[peak..].iter().take_while(high).count();
        let below = means[..peak].iter().rev().take_while(high).count();
        (means[peak] > 0.0).then(|| [edge(peak - below), edge(peak + above), means[peak]])
    }
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
