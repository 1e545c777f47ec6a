//! Thickness of a shear band: Chen et al. (2021), appendix A.
//!
//! 1. *Candidates*: the rows whose strain is beyond the 98th percentile. The paper counts grains of a fully discrete
//!    specimen; here rows count by the area they stand for, so that a specimen of points and grains, or of points
//!    alone, is measured by the same rule: the most strained 2 % of the material.
//! 2. *Outliers*: candidates farther from the centre line of the band than two standard deviations of that distance are
//!    dropped, once.
//! 3. *Thickness*: of the minimum-area box around the centres of what is left, the side across the band. Half a row on
//!    either side is not added.
//!
//! In a domain that is periodic in x the candidates are cut open at the widest gap between them along x. Where even
//! that gap is below a quarter of the period, the band closes on itself round the period: it can only lie along x, and
//! so do its centre line and its box, or both would depend on the place of the cut. Elsewhere the line follows the
//! principal axis of the candidates. "Across" is the side of the box nearer to the normal of that line, which need not
//! be the shorter one in a narrow specimen.

use crate::base::math;

/// Share of the material, by area, that counts as candidates (98th percentile).
pub const CANDIDATE_SHARE: f64 = 0.02;
/// Candidates farther from the centre line than this many standard deviations are outliers.
const OUTLIER_DEVIATIONS: f64 = 2.0;
/// Candidates on one line are not outliers by the last digits of their coordinates.
const ROUND_OFF: f64 = 1e-12;
/// Fewer members than this make no band.
const MEMBERS_MIN: usize = 6;
/// A band closes round the period where the widest gap between its candidates is below this share of the period.
const CLOSED_GAP_SHARE: f64 = 0.25;

/// What is measured: one entry per row.
#[derive(Clone, Copy, Debug)]
pub struct Strained<'a> {
    /// m; x in [0, period).
    pub positions: &'a [[f64; 2]],
    /// Magnitude of incremental strain; a row with NaN does not take part.
    pub strains: &'a [f64],
    /// Area that each row stands for, m2.
    pub areas: &'a [f64],
    /// Period in x, m; zero or less where the domain is not periodic.
    pub period: f64,
}

/// Which rows are candidates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Candidates {
    /// The most strained share of the material, by area.
    Share(f64),
    /// Rows of at least that strain: the threshold of another specimen that this one is compared with.
    Beyond(f64),
}

/// A measured band.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Side of the box across the band, m.
    pub thickness: f64,
    /// Side of the box along the band, m.
    pub length: f64,
    /// Centre of the box, m; x in [0, period) where there is one.
    pub centre: [f64; 2],
    /// From the x axis to the direction of the band, rad, in (-pi/2, pi/2].
    pub angle: f64,
    /// The band closes on itself round the period.
    pub closed: bool,
    /// The smallest strain of a candidate: the 98th percentile.
    pub threshold: f64,
    /// Rows inside the box, ascending.
    pub members: Vec<usize>,
}

impl Band {
    /// Corners of the box, counter-clockwise, m; x is not wrapped.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let along = [math::cos(self.angle), math::sin(self.angle)];
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(a, b)| {
            [
                self.centre[0] + a * self.length * along[0] - b * self.thickness * along[1],
                self.centre[1] + a * self.length * along[1] + b * self.thickness * along[0],
            ]
        })
    }
}

/// Measures the band. None where too few rows are strained to speak of one, or all are strained alike.
pub fn measure(strained: &Strained) -> Option<Band> {
    measure_by(strained, Candidates::Share(CANDIDATE_SHARE))
}

/// The same with another choice of candidates.
pub fn measure_by(strained: &Strained, wanted: Candidates) -> Option<Band> {
    let (candidates, threshold) = candidates(strained, wanted)?;
    let (places, closed) = unrolled(&candidates, strained);
    let centre = mean(&places);
    let along = if closed { [1.0, 0.0] } else { principal_axis(&places, centre) };
    let across = [-along[1], along[0]];

    let distances: Vec<f64> =
        places.iter().map(|place| (place[0] - centre[0]) * across[0] + (place[1] - centre[1]) * across[1]).collect();
    let variance = distances.iter().map(|distance| distance * distance).sum::<f64>() / distances.len() as f64;
    let size = places.iter().flatten().fold(0.0, |size: f64, coordinate| size.max(coordinate.abs()));
    let limit = OUTLIER_DEVIATIONS * variance.sqrt() + ROUND_OFF * size;
    let kept: Vec<usize> = (0..places.len()).filter(|&index| distances[index].abs() <= limit).collect();
    if kept.len() < MEMBERS_MIN {
        return None;
    }

    let kept_places: Vec<[f64; 2]> = kept.iter().map(|&index| places[index]).collect();
    let mut members: Vec<usize> = kept.iter().map(|&index| candidates[index]).collect();
    members.sort_unstable();
    let mut band = if closed { box_along(&kept_places, along) } else { smallest_box(&kept_places, along) };
    if closed {
        band.length = strained.period;
    }
    if strained.period > 0.0 {
        band.centre[0] = band.centre[0].rem_euclid(strained.period);
    }
    Some(Band { threshold, members, closed, ..band })
}

/// The candidates, most strained first, and the smallest strain among them.
fn candidates(strained: &Strained, wanted: Candidates) -> Option<(Vec<usize>, f64)> {
    let Strained { positions, strains, areas, .. } = *strained;
    assert!(positions.len() == strains.len() && positions.len() == areas.len(), "one entry per row");
    let mut rows: Vec<usize> = (0..strains.len()).filter(|&row| strains[row].is_finite()).collect();
    rows.sort_by(|&a, &b| strains[b].total_cmp(&strains[a]).then(a.cmp(&b)));
    let total: f64 = rows.iter().map(|&row| areas[row]).sum();
    let count = match wanted {
        Candidates::Share(share) => {
            let mut sum = 0.0;
            let within = |row: &&usize| {
                let fits = sum + 0.5 * areas[**row] <= share * total;
                sum += areas[**row];
                fits
            };
            rows.iter().take_while(within).count()
        }
        Candidates::Beyond(strain) => rows.partition_point(|&row| strains[row] >= strain),
    };
    if count < MEMBERS_MIN {
        return None;
    }
    let threshold = strains[rows[count - 1]];
    let weakest = strains[rows[rows.len() - 1]];
    rows.truncate(count);
    (threshold > weakest).then_some((rows, threshold))
}

/// Places of the candidates, cut open at their widest gap along x, and whether they close round the period.
fn unrolled(candidates: &[usize], strained: &Strained) -> (Vec<[f64; 2]>, bool) {
    let places: Vec<[f64; 2]> = candidates.iter().map(|&row| strained.positions[row]).collect();
    let period = strained.period;
    if period.is_nan() || period <= 0.0 {
        return (places, false);
    }
    let mut sorted: Vec<f64> = places.iter().map(|place| place[0]).collect();
    sorted.sort_by(f64::total_cmp);
    let mut start = sorted[0];
    let mut gap_max = sorted[0] + period - sorted[sorted.len() - 1];
    for pair in sorted.windows(2) {
        if pair[1] - pair[0] > gap_max {
            gap_max = pair[1] - pair[0];
            start = pair[1];
        }
    }
    let open = places.iter().map(|place| {
        let x = if place[0] < start { place[0] + period } else { place[0] };
        [x, place[1]]
    });
    (open.collect(), gap_max < CLOSED_GAP_SHARE * period)
}

fn mean(places: &[[f64; 2]]) -> [f64; 2] {
    let count = places.len() as f64;
    [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count)
}

/// Unit vector of the direction in which the places spread most.
fn principal_axis(places: &[[f64; 2]], centre: [f64; 2]) -> [f64; 2] {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for place in places {
        let d = [place[0] - centre[0], place[1] - centre[1]];
        xx += d[0] * d[0];
        xy += d[0] * d[1];
        yy += d[1] * d[1];
    }
    let angle = 0.5 * math::atan2(2.0 * xy, xx - yy);
    [math::cos(angle), math::sin(angle)]
}

/// The box of least area around the places: one of its sides lies on an edge of their convex hull (Freeman and Shapira
/// 1975). Thickness is the side nearer to the normal of `along`; places on one line have none.
fn smallest_box(places: &[[f64; 2]], along: [f64; 2]) -> Band {
    let hull = convex_hull(places);
    let boxes = hull.iter().enumerate().map(|(index, corner)| {
        let next = hull[(index + 1) % hull.len()];
        let edge = [next[0] - corner[0], next[1] - corner[1]];
        let length = (edge[0] * edge[0] + edge[1] * edge[1]).sqrt();
        let mut axis = edge.map(|component| component / length);
        // Of the two axes of the box, the one nearer to the band, and pointing to the right.
        if (axis[0] * along[0] + axis[1] * along[1]).abs() < (axis[1] * along[0] - axis[0] * along[1]).abs() {
            axis = [axis[1], -axis[0]];
        }
        if axis[0] < 0.0 || (axis[0] == 0.0 && axis[1] < 0.0) {
            axis = [-axis[0], -axis[1]];
        }
        box_along(&hull, axis)
    });
    let area = |band: &Band| band.thickness * band.length;
    let smallest = boxes.reduce(|best, band| if area(&band) < area(&best) { band } else { best });
    smallest.unwrap_or_else(|| box_along(places, along))
}

/// The box with sides along and across the unit vector `axis` around the places.
fn box_along(places: &[[f64; 2]], axis: [f64; 2]) -> Band {
    let (lower, upper) = extent(places, axis);
    let (bottom, top) = extent(places, [-axis[1], axis[0]]);
    let (a, b) = (0.5 * (lower + upper), 0.5 * (bottom + top));
    Band {
        thickness: top - bottom,
        length: upper - lower,
        centre: [a * axis[0] - b * axis[1], a * axis[1] + b * axis[0]],
        angle: math::atan2(axis[1], axis[0]),
        closed: false,
        threshold: 0.0,
        members: Vec::new(),
    }
}

fn extent(places: &[[f64; 2]], axis: [f64; 2]) -> (f64, f64) {
    places
        .iter()
        .map(|place| place[0] * axis[0] + place[1] * axis[1])
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lower, upper), along| (lower.min(along), upper.max(along)))
}

/// Corners of the convex hull, counter-clockwise (monotone chain, Andrew 1979); empty where the places lie on a line.
fn convex_hull(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = places.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    let half = |places: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for place in places {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], place) <= 0.0 {
                chain.pop();
            }
            chain.push(place);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    if hull.len() < 3 { Vec::new() } else { hull }
}

/// Positive where `a`, `b`, `c` turn left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: f64 = 60.0;
    const HEIGHT: f64 = 120.0;
    const SPACING: f64 = 0.5;

    /// A square lattice over the specimen with strains by place.
    fn specimen(strain: impl Fn([f64; 2]) -> f64) -> (Vec<[f64; 2]>, Vec<f64>) {
        let mut positions = Vec::new();
        for row in 0..(HEIGHT / SPACING) as usize {
            for column in 0..(WIDTH / SPACING) as usize {
                positions.push([(column as f64 + 0.5) * SPACING, (row as f64 + 0.5) * SPACING]);
            }
        }
        let strains = positions.iter().map(|&place| strain(place)).collect();
        (positions, strains)
    }

    fn measured(positions: &[[f64; 2]], strains: &[f64], period: f64) -> Option<Band> {
        let areas = vec![SPACING * SPACING; positions.len()];
        measure(&Strained { positions, strains, areas: &areas, period })
    }

    #[test]
    fn a_horizontal_band_holds_two_percent_of_the_height() {
        // Strain falls with the distance from a line, so the candidates are a strip of 2 % of the height.
        let (positions, strains) = specimen(|place| 1.0 / (1.0 + (place[1] - 70.0).abs()));
        let band = measured(&positions, &strains, WIDTH).unwrap();
        assert!((band.thickness - 0.02 * HEIGHT).abs() <= 2.0 * SPACING, "{}", band.thickness);
        assert!((band.length - WIDTH).abs() <= 2.0 * SPACING, "{}", band.length);
        assert!((band.centre[1] - 70.0).abs() <= SPACING);
        assert!(band.closed && band.angle == 0.0);
    }

    #[test]
    fn a_closed_band_does_not_depend_on_the_seam() {
        let wave = |shift: f64| {
            let (positions, strains) = specimen(|place| {
                let crest = 70.0 + 2.0 * math::sin(2.0 * math::PI * (place[0] - shift) / WIDTH);
                1.0 / (1.0 + (place[1] - crest).abs())
            });
            measured(&positions, &strains, WIDTH).unwrap()
        };
        let (here, there) = (wave(0.0), wave(17.0));
        assert!(here.closed && there.closed);
        assert!((here.thickness - (4.0 + 0.02 * HEIGHT)).abs() <= 2.0 * SPACING, "{}", here.thickness);
        assert!((here.thickness - there.thickness).abs() <= SPACING);
    }

    #[test]
    fn scattered_hot_spots_are_outliers() {
        let (positions, mut strains) = specimen(|place| 1.0 / (1.0 + (place[1] - 70.0).abs()));
        let clean = measured(&positions, &strains, WIDTH).unwrap();
        for row in [100, 9_000, 27_000, 28_700] {
            strains[row] = 2.0;
        }
        let band = measured(&positions, &strains, WIDTH).unwrap();
        assert!(!band.members.contains(&100));
        assert!((band.thickness - clean.thickness).abs() <= SPACING);
    }

    #[test]
    fn an_inclined_band_is_measured_across() {
        // A bar of 24 by 6 (2 % of the area) at 40 degrees.
        let angle: f64 = 0.7;
        let (c, s) = (math::cos(angle), math::sin(angle));
        let inside = |place: [f64; 2]| {
            let d = [place[0] - 30.0, place[1] - 55.0];
            let (a, b) = (d[0] * c + d[1] * s, d[1] * c - d[0] * s);
            (a / 12.0).abs().max((b / 3.0).abs())
        };
        let (positions, strains) = specimen(|place| 1.0 / (1.0 + inside(place)));
        let band = measured(&positions, &strains, 0.0).unwrap();
        assert!((band.thickness - 6.0).abs() < 2.0 * SPACING, "{}", band.thickness);
        assert!((band.length - 24.0).abs() < 2.0 * SPACING, "{}", band.length);
        assert!((band.angle - angle).abs() < 0.05, "{}", band.angle);
        assert!((band.centre[0] - 30.0).abs() < SPACING && (band.centre[1] - 55.0).abs() < SPACING);
        let corner = band.corners()[2];
        assert!((corner[0] - (30.0 + 12.0 * c - 3.0 * s)).abs() < 2.0 * SPACING);
        assert!((corner[1] - (55.0 + 12.0 * s + 3.0 * c)).abs() < 2.0 * SPACING);
    }

    #[test]
    fn a_patch_across_the_seam_is_whole() {
        let patch = |place: [f64; 2]| {
            let dx = (place[0] - 2.0 + 0.5 * WIDTH).rem_euclid(WIDTH) - 0.5 * WIDTH;
            1.0 / (1.0 + (dx / 12.0).abs().max(((place[1] - 40.0) / 3.0).abs()))
        };
        let (positions, strains) = specimen(patch);
        let band = measured(&positions, &strains, WIDTH).unwrap();
        assert!((band.length - 24.0).abs() < 2.0 * SPACING, "{}", band.length);
        assert!((band.thickness - 6.0).abs() < 2.0 * SPACING, "{}", band.thickness);
        assert!(!band.closed);
        assert!((band.centre[0] - 2.0).abs() < SPACING, "{}", band.centre[0]);
    }

    #[test]
    fn points_count_by_their_area() {
        // The strip y in [70, 72.4] in fine rows, everything else in coarse rows of nine times the area.
        let (fine, _) = specimen(|_| 0.0);
        let mut positions: Vec<[f64; 2]> = fine.into_iter().filter(|place| (60.0..80.0).contains(&place[1])).collect();
        let mut areas = vec![SPACING * SPACING; positions.len()];
        let coarse = 3.0 * SPACING;
        for row in 0..(HEIGHT / coarse) as usize {
            for column in 0..(WIDTH / coarse) as usize {
                let place = [(column as f64 + 0.5) * coarse, (row as f64 + 0.5) * coarse];
                if !(60.0..80.0).contains(&place[1]) {
                    positions.push(place);
                    areas.push(coarse * coarse);
                }
            }
        }
        let strains: Vec<f64> = positions.iter().map(|place| 1.0 / (1.0 + (place[1] - 70.0).abs())).collect();
        let band = measure(&Strained { positions: &positions, strains: &strains, areas: &areas, period: WIDTH });
        let thickness = band.unwrap().thickness;
        assert!((thickness - 0.02 * HEIGHT).abs() <= 2.0 * SPACING, "{thickness}");
    }

    #[test]
    fn candidates_may_be_chosen_otherwise() {
        let (positions, strains) = specimen(|place| 1.0 / (1.0 + (place[1] - 70.0).abs()));
        let areas = vec![SPACING * SPACING; positions.len()];
        let strained = Strained { positions: &positions, strains: &strains, areas: &areas, period: WIDTH };
        let thickness = |wanted: Candidates| measure_by(&strained, wanted).unwrap().thickness;
        assert_eq!(thickness(Candidates::Share(CANDIDATE_SHARE)), measure(&strained).unwrap().thickness);
        assert!((thickness(Candidates::Share(0.05)) - 0.05 * HEIGHT).abs() <= 2.0 * SPACING);
        // Strain falls to a fifth within 4 of the line.
        assert!((thickness(Candidates::Beyond(0.2)) - 8.0).abs() <= 2.0 * SPACING);
        assert_eq!(measure_by(&strained, Candidates::Beyond(2.0)), None);
    }

    #[test]
    fn a_piece_of_one_row_has_no_thickness() {
        let strain = |place: [f64; 2]| if (place[1] - 70.25).abs() < 0.1 && place[0] < 20.0 { 1.0 } else { 0.0 };
        let (positions, strains) = specimen(strain);
        let areas = vec![SPACING * SPACING; positions.len()];
        let strained = Strained { positions: &positions, strains: &strains, areas: &areas, period: WIDTH };
        let band = measure_by(&strained, Candidates::Beyond(0.5)).unwrap();
        assert!(band.thickness < 1e-9 && !band.closed, "{band:?}");
        assert!((band.length - 19.5).abs() < 1e-9, "{}", band.length);
    }

    #[test]
    fn uniform_strain_is_no_band() {
        let (positions, strains) = specimen(|_| 0.1);
        assert_eq!(measured(&positions, &strains, WIDTH), None);
        assert_eq!(measured(&[], &[], WIDTH), None);
        assert_eq!(measured(&positions, &vec![f64::NAN; positions.len()], WIDTH), None);
    }
}
