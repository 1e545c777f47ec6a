//! The space that bodies fill, and by how much a group of them swells: of grains their shares of a triangulation, of points what
//! their volume has become.

use super::snapshot::{Body, Kind, Snapshot};
use super::strained::{EDGE_MAX_DIAMETERS, Span};
use crate::base::math::PI;
use crate::observe::space_share::space_shares;

/// Bodies of a snapshot with the area that each fills, m2, whatever its weight.
pub struct Spaces<'s> {
    snapshot: &'s Snapshot,
    areas: Vec<f64>,
}

impl<'s> Spaces<'s> {
    /// Grains have their shares of a triangulation, of edges up to [`EDGE_MAX_DIAMETERS`], points the disc of their size.
    pub fn of(snapshot: &'s Snapshot, span: &Span) -> Self {
        let bodies = &snapshot.bodies;
        let mut areas: Vec<f64> = bodies.iter().map(|body| PI * body.radius * body.radius).collect();
        let grains: Vec<usize> = (0..bodies.len()).filter(|&row| bodies[row].kind.is_grain()).collect();
        let places: Vec<[f64; 2]> = grains.iter().map(|&row| bodies[row].position).collect();
        for (row, share) in grains.into_iter().zip(space_shares(&places, EDGE_MAX_DIAMETERS * span.diameter)) {
            areas[row] = share;
        }
        Self { snapshot, areas }
    }

    fn area(&self, body: &Body) -> Option<f64> {
        Some(self.areas[self.snapshot.row_of(body)?])
    }

    /// Change of the area of these bodies since an earlier snapshot, as a share of it; of those that are in both. Each counts by the
    /// weight that it has among `bodies`: what a zone has grown over has lost some of its own since.
    pub fn swelling(&self, earlier: &Spaces, bodies: &[Body]) -> Option<f64> {
        let of = |body: &Body| Some([earlier.area(body)?, self.area(body)?].map(|area| body.weight * area));
        let pairs = bodies.iter().filter_map(of);
        let [before, now] = pairs.fold([0.0; 2], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
        (before > 0.0).then(|| now / before - 1.0)
    }

    /// Share of their space that the grains among these bodies fill.
    pub fn fraction(&self, bodies: &[Body]) -> Option<f64> {
        let grains = bodies.iter().filter(|body| body.kind == Kind::Grain);
        let pairs = grains.filter_map(|body| Some([body.area(), body.weight * self.area(body)?]));
        let [full, space] = pairs.fold([0.0; 2], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
        (space > 0.0).then(|| full / space)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band's points had half of their weight left when its zone had grown over them, and its volume strain was told as -44 %.
    #[test]
    fn points_that_a_zone_has_grown_over_do_not_shrink() {
        let span = Span { left: 0.0, width: 1.0, is_periodic: false, diameter: 1e-3 };
        let snapshot = |weight: f64, radius: f64| {
            let body = |id: i64| Body { id, position: [0.1, 1e-3 * id as f64], weight, radius, ..Body::default() };
            Snapshot { bodies: (0..9).map(body).collect(), ..Snapshot::default() }
        };
        let [before, now] = [snapshot(1.0, 1e-3), snapshot(0.5, 1.01e-3)];
        let swelling = Spaces::of(&now, &span).swelling(&Spaces::of(&before, &span), &now.bodies).unwrap();
        assert!((swelling - (1.01 * 1.01 - 1.0)).abs() < 1e-12, "{swelling}");
    }
}
