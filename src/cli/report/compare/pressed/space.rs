//! The space that bodies fill, and by how much a group of them swells: of grains their shares of a triangulation, of points what
//! their volume has become.

use crate::cli::report::load::{Body, Kind, Snapshot};
use crate::cli::report::scenes::EDGE_MAX_DIAMETERS;
use crate::cli::report::span::Span;
use crate::math::PI;
use crate::observe::space_share::space_shares;

/// Bodies of a snapshot with the area that each fills, m2, its weight counted.
pub struct Spaces<'s> {
    bodies: &'s [Body],
    areas: Vec<f64>,
}

impl<'s> Spaces<'s> {
    pub fn of(snapshot: &'s Snapshot, span: &Span) -> Self {
        let bodies = &snapshot.bodies;
        let mut areas: Vec<f64> = bodies.iter().map(Body::area).collect();
        let grains: Vec<usize> = (0..bodies.len()).filter(|&row| bodies[row].kind.is_grain()).collect();
        let places: Vec<[f64; 2]> = grains.iter().map(|&row| bodies[row].position).collect();
        for (row, share) in grains.into_iter().zip(space_shares(&places, EDGE_MAX_DIAMETERS * span.diameter)) {
            areas[row] = bodies[row].weight * share;
        }
        Self { bodies, areas }
    }

    fn area(&self, body: &Body) -> Option<f64> {
        let key = |body: &Body| (body.kind.is_grain(), body.id);
        let row = self.bodies.binary_search_by_key(&key(body), key).ok()?;
        Some(self.areas[row])
    }

    /// Change of the area of these bodies since an earlier snapshot, as a share of it; of those that are in both.
    pub fn swelling(&self, earlier: &Spaces, bodies: &[Body]) -> Option<f64> {
        let pairs = bodies.iter().filter_map(|body| Some([earlier.area(body)?, self.area(body)?]));
        let [before, now] = pairs.fold([0.0; 2], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
        (before > 0.0).then(|| now / before - 1.0)
    }

    /// Share of their space that the grains among these bodies fill.
    pub fn fraction(&self, bodies: &[Body]) -> Option<f64> {
        let grains = bodies.iter().filter(|body| body.kind == Kind::Grain);
        let pairs = grains.filter_map(|body| Some([body.weight * PI * body.radius * body.radius, self.area(body)?]));
        let [full, space] = pairs.fold([0.0; 2], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
        (space > 0.0).then(|| full / space)
    }
}
