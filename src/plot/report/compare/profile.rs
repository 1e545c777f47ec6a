//! Width of a band at half of its height: a second measure of thickness, which takes no percentile and no box.
//!
//! Strain is averaged over the width of the specimen, height by height, every body counting over its own extent; the width is
//! that of the unbroken stretch around the largest mean in which the mean is at least half of it. It lies along x, as the bands
//! of planar shear do.

use crate::plot::report::load::Body;
use crate::plot::report::scenes::{Valued, free, square_edge};

/// Heights at which the mean is taken, as a share of the mean diameter.
const STEP: f64 = 0.25;

/// Vertical extent of a body, m: of a grain its diameter, of a point the edge of its square.
pub fn extent(body: &Body) -> f64 {
    if body.kind.is_grain() { 2.0 * body.radius } else { square_edge(body.radius) }
}

/// Width at half of the largest mean strain, m; `diameter` is the mean one, m.
pub fn width_at_half(bodies: &[Valued], diameter: f64) -> Option<f64> {
    let step = STEP * diameter;
    let known = || free(bodies).filter(|row| row.value.is_finite());
    let edge = |row: &Valued, side: f64| row.body.position[1] + side * 0.5 * extent(&row.body);
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
    let peak = (0..layers).reduce(|best, layer| if means[layer] > means[best] { layer } else { best })?;
    let high = |mean: &&f64| **mean >= 0.5 * means[peak];
    let above = means[peak..].iter().take_while(high).count();
    let below = means[..peak].iter().rev().take_while(high).count();
    (means[peak] > 0.0).then(|| (above + below) as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;
    use crate::plot::report::load::Kind;

    fn bodies(kind: Kind, spacing: f64, strain: impl Fn(f64) -> f64) -> Vec<Valued> {
        let radius = if kind == Kind::Point { spacing / math::PI.sqrt() } else { 0.5 * spacing };
        let place = |index: i64| [(index % 20) as f64 * spacing, ((index / 20) as f64 + 0.5) * spacing];
        let body = |id: i64| Body {
            kind,
            id,
            position: place(id),
            displacement: [0.0; 2],
            radius,
            weight: 1.0,
            shear_stress: 0.0,
        };
        (0..20 * 60).map(|id| Valued { body: body(id), value: strain(place(id)[1]) }).collect()
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
