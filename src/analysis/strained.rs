//! Strain of the bodies of a frame, and the bands that it gathers in.
//!
//! Width at half of the height is a measure of a level band that takes no percentile and no box: strain is averaged over the width of
//! the specimen, height by height, every body counting over its own extent; the width is that of the unbroken stretch around the
//! largest mean in which the mean is at least half of it.

use super::band::{self, Band, Candidates, Strained};
use super::curve::highest;
use super::run::Run;
use super::snapshot::{Body, Kind, Snapshot};
use super::strip::{self, Field, Strip};
use crate::base::error::Error;
use crate::observe::strain::best_fit_strains;

/// Neighbours farther apart than this many mean diameters do not share a strain of grains, nor the space between them.
pub const EDGE_MAX_DIAMETERS: f64 = 2.5;
/// The same for points, in edges of the square of a point's area.
const EDGE_MAX_POINTS: f64 = 3.0;
/// Heights at which the mean is taken, as a share of the mean diameter.
const STEP: f64 = 0.25;
/// Room beside the material, as a share of its breadth.
const ROOM: f64 = 0.03;

/// A piece of the x axis across which strain is measured, with the size of its grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// m.
    pub left: f64,
    /// m.
    pub width: f64,
    /// Its sides are joined.
    pub is_periodic: bool,
    /// Mean grain diameter D50, or a cell where there are no grains, m.
    pub diameter: f64,
}

impl Span {
    /// From 0 on along x; `width` is the period, m, `diameter` that of a grain, m.
    pub fn around_the_period(width: f64, diameter: f64) -> Self {
        Self { left: 0.0, width, is_periodic: true, diameter }
    }

    /// As wide as the bodies with a little room.
    pub fn around(bodies: &[Body], diameter: f64) -> Self {
        let ends = |ends: [f64; 2], body: &Body| {
            [ends[0].min(body.position[0] - body.radius), ends[1].max(body.position[0] + body.radius)]
        };
        let [left, right] = bodies.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        let [left, width] = if right > left { [left, right - left] } else { [0.0, diameter] };
        Self { left: left - ROOM * width, width: (1.0 + 2.0 * ROOM) * width, is_periodic: false, diameter }
    }

    /// m; zero where the sides are apart.
    pub fn period(&self) -> f64 {
        if self.is_periodic { self.width } else { 0.0 }
    }

    /// Whole spans by which what crosses a side may have to be moved to be seen.
    pub fn images(&self) -> &'static [f64] {
        if self.is_periodic { &[-1.0, 0.0, 1.0] } else { &[0.0] }
    }
}

/// A body with a number: its strain |e_d|, or what else colours it; not a number where nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valued {
    /// As it is in the frame.
    pub body: Body,
    /// In SI units.
    pub value: f64,
}

/// The bodies that a band is made of: all but the plates.
pub fn free(bodies: &[Valued]) -> impl Iterator<Item = &Valued> {
    bodies.iter().filter(|row| row.body.kind != Kind::Glued)
}

/// Strain of every body since its origin, or since it was in `earlier`; bodies that are not there have none.
///
/// Points and grains are fitted apart: in the rim, where both live, they share their motion only on the average.
pub fn strained(snapshot: &Snapshot, earlier: Option<&Snapshot>, span: &Span) -> Vec<Valued> {
    let mut result: Vec<Valued> = snapshot.bodies.iter().map(|&body| Valued { body, value: f64::NAN }).collect();
    for grains in [false, true] {
        let (mut rows, mut positions, mut displacements) = (Vec::new(), Vec::new(), Vec::new());
        for (row, body) in snapshot.bodies.iter().enumerate().filter(|(_, body)| body.kind.is_grain() == grains) {
            let Some(origin) = earlier
                .map_or(Some([0.0; 2]), |earlier| earlier.row_of(body).map(|row| earlier.bodies[row].displacement))
            else {
                continue;
            };
            rows.push(row);
            positions.push(body.position);
            displacements.push([body.displacement[0] - origin[0], body.displacement[1] - origin[1]]);
        }
        let largest = rows.iter().map(|&row| snapshot.bodies[row].edge(2)).fold(0.0, f64::max);
        let edge_max = if grains { EDGE_MAX_DIAMETERS * span.diameter } else { EDGE_MAX_POINTS * largest };
        let values = best_fit_strains(&positions, &displacements, span.period(), edge_max);
        for (row, value) in rows.into_iter().zip(values) {
            result[row].value = value;
        }
    }
    result
}

/// The same of two frames of a run, in the plane.
pub fn increment(run: &Run, span: &Span, [from, to]: [usize; 2]) -> Result<Vec<Valued>, Error> {
    Ok(strained(&run.snapshot(to)?, Some(&run.snapshot(from)?), span))
}

/// The box of appendix A around strained bodies, plates left out.
pub fn boxed(bodies: &[Valued], span: &Span, wanted: Candidates) -> Option<Band> {
    let of = |get: fn(&Valued) -> f64| free(bodies).map(get).collect::<Vec<f64>>();
    let positions: Vec<[f64; 2]> = free(bodies).map(|row| row.body.position).collect();
    let (strains, areas) = (of(|row| row.value), of(|row| row.body.area()));
    let strained = Strained { positions: &positions, strains: &strains, areas: &areas, period: span.period() };
    band::measure_by(&strained, wanted)
}

/// The strongest straight band of bodies whose sides are apart.
pub fn stripped(bodies: &[Valued], span: &Span) -> Option<Strip> {
    if span.is_periodic {
        return None;
    }
    let of = |get: fn(&Valued) -> f64| free(bodies).map(get).collect::<Vec<f64>>();
    let positions: Vec<[f64; 2]> = free(bodies).map(|row| row.body.position).collect();
    let (strains, areas, radii) = (of(|row| row.value), of(|row| row.body.area()), of(|row| row.body.radius));
    let field =
        Field { positions: &positions, strains: &strains, areas: &areas, radii: &radii, diameter: span.diameter };
    strip::strongest(&field)
}

/// Width at half of the largest mean strain of a band along x, m; `diameter` is the mean one, m.
pub fn width_at_half(bodies: &[Valued], diameter: f64) -> Option<f64> {
    let step = STEP * diameter;
    let known = || free(bodies).filter(|row| row.value.is_finite());
    let edge = |row: &Valued, side: f64| row.body.position[1] + side * 0.5 * row.body.extent();
    let lower = known().map(|row| edge(row, -1.0)).fold(f64::INFINITY, f64::min);
    let upper = known().map(|row| edge(row, 1.0)).fold(f64::NEG_INFINITY, f64::max);
    let layers = if upper > lower { ((upper - lower) / step).ceil() as usize } else { return None };
    let mut sums = vec![[0.0; 2]; layers];
    for row in known() {
        let (from, to) = (edge(row, -1.0) - lower, edge(row, 1.0) - lower);
        let inside = (from / step) as usize..((to / step).ceil() as usize).min(layers);
        for (layer, sum) in inside.clone().zip(&mut sums[inside]) {
            let within = to.min((layer + 1) as f64 * step) - from.max(layer as f64 * step);
            let area = row.body.area() * (within / (to - from)).max(0.0);
            sum[0] += area * row.value;
            sum[1] += area;
        }
    }
    let means: Vec<f64> = sums.iter().map(|[sum, area]| if *area > 0.0 { sum / area } else { 0.0 }).collect();
    let peak = highest(&means);
    let high = |mean: &&f64| **mean >= 0.5 * means[peak];
    let above = means[peak..].iter().take_while(high).count();
    let below = means[..peak].iter().rev().take_while(high).count();
    (means[peak] > 0.0).then(|| (above + below) as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;

    fn bodies(kind: Kind, spacing: f64, strain: impl Fn(f64) -> f64) -> Vec<Valued> {
        let radius = if kind == Kind::Point { spacing / math::PI.sqrt() } else { 0.5 * spacing };
        let position = |id: i64| [(id % 20) as f64 * spacing, ((id / 20) as f64 + 0.5) * spacing];
        let body = |id: i64| Body { kind, id, position: position(id), radius, weight: 1.0, ..Body::default() };
        (0..20 * 60).map(|id| Valued { body: body(id), value: strain(position(id)[1]) }).collect()
    }

    #[test]
    fn a_peak_has_its_width_and_a_row_of_points_its_own() {
        // Falls to a half 6 diameters from the line.
        let wide = bodies(Kind::Grain, 1.0, |y| (1.0 - (y - 30.0).abs() / 12.0).max(0.0));
        assert!((width_at_half(&wide, 1.0).unwrap() - 12.0).abs() <= 1.0);
        let row = bodies(Kind::Point, 4.0, |y| if (y - 122.0).abs() < 1.0 { 1.0 } else { 0.1 });
        assert!((width_at_half(&row, 1.0).unwrap() - 4.0).abs() <= 0.5);
    }

    #[test]
    fn nothing_known_has_no_width() {
        assert_eq!(width_at_half(&[], 1.0), None);
        assert_eq!(width_at_half(&bodies(Kind::Grain, 1.0, |_| f64::NAN), 1.0), None);
        assert_eq!(width_at_half(&bodies(Kind::Grain, 1.0, |_| 0.0), 1.0), None);
    }
}
