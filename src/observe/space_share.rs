//! The share of space that each grain of an assembly in the plane has: a third of every Delaunay triangle that it is a corner of.
//!
//! Over a group of grains the shares sum up to the space that the group fills, so that their change is its volume strain. A
//! gradient that is fitted to motions does not tell that where grains mix: neighbours of now began farther apart than they are,
//! and neighbours of the start have drifted apart, so in a band that shears by a half the fit shrinks by a tenth by the former,
//! and swells by as much by the latter.

use spade::{DelaunayTriangulation, Point2, Triangulation};

/// Area of every row, m2; triangles with an edge longer than `edge_max` (m) lie outside, or across a void. Rows at exactly the
/// same place as an earlier one have none.
pub fn space_shares(positions: &[[f64; 2]], edge_max: f64) -> Vec<f64> {
    let mut shares = vec![0.0; positions.len()];
    // Too small for the exact predicates of the triangulation is zero.
    let flush = |coordinate: f64| if coordinate.abs() < 1e-100 { 0.0 } else { coordinate };
    let places: Vec<Point2<f64>> =
        positions.iter().map(|place| Point2::new(flush(place[0]), flush(place[1]))).collect();
    let mut rows: Vec<usize> = (0..places.len()).collect();
    let order = |&a: &usize, &b: &usize| {
        places[a].x.total_cmp(&places[b].x).then(places[a].y.total_cmp(&places[b].y)).then(a.cmp(&b))
    };
    rows.sort_by(order);
    rows.dedup_by(|later, first| places[*later] == places[*first]);
    rows.sort_unstable();
    let vertices = rows.iter().map(|&row| places[row]).collect();
    let triangulation: DelaunayTriangulation<Point2<f64>> =
        DelaunayTriangulation::bulk_load_stable(vertices).expect("places are finite");
    // Triangles in the order of their corners, so that every sum has one order.
    let mut triangles: Vec<([usize; 3], f64)> = triangulation
        .inner_faces()
        .filter(|face| face.adjacent_edges().iter().all(|edge| edge.length_2() <= edge_max * edge_max))
        .map(|face| {
            let mut corners = face.vertices().map(|vertex| rows[vertex.index()]);
            corners.sort_unstable();
            (corners, face.area())
        })
        .collect();
    triangles.sort_by_key(|(corners, _)| *corners);
    for (corners, area) in triangles {
        corners.iter().for_each(|&row| shares[row] += area / 3.0);
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;

    #[test]
    fn shares_fill_the_space_between_the_outermost() {
        let wave = |index: usize, way: f64| 0.2 * math::sin(way * index as f64);
        let mut places: Vec<[f64; 2]> = (0..12 * 9)
            .map(|row| {
                let inner = (1..11).contains(&(row % 12)) && (1..8).contains(&(row / 12));
                let [dx, dy] = if inner { [wave(row, 12.9), wave(row, 78.2)] } else { [0.0; 2] };
                [(row % 12) as f64 + dx, (row / 12) as f64 + dy]
            })
            .collect();
        let shares = space_shares(&places, 2.5);
        assert!((shares.iter().sum::<f64>() - 11.0 * 8.0).abs() < 1e-12);
        assert!(shares.iter().all(|share| *share > 0.0));
        // Half as far apart again in one direction.
        places.iter_mut().for_each(|place| place[0] *= 1.5);
        let wider = space_shares(&places, 4.0);
        assert!((wider.iter().sum::<f64>() - 1.5 * 88.0).abs() < 1e-12);
        // A twin has nothing of its own, and what is far away makes no triangle.
        places.extend([places[5], [400.0, 0.0]]);
        let shares = space_shares(&places, 4.0);
        assert_eq!((shares[108], shares[109]), (0.0, 0.0));
        assert!((shares.iter().sum::<f64>() - 132.0).abs() < 1e-12);
        assert!(space_shares(&[], 1.0).is_empty());
    }
}
