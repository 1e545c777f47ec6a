//! Strain of an assembly of rows (grains or points): Cundall's best fit over Delaunay neighbours.
//!
//! For a row and its neighbours, with dX and dx the deviations of their places from the centre of the group before and
//! after the deformation and du = dx - dX,
//!
//! ```text
//! min over grad u of  1/2 sum_i |du_i - grad u dX_i|^2     =>  grad u = (sum du dX^T) (sum dX dX^T)^-1
//! e   = 1/2 (grad u + grad u^T)                             small strain, tension positive
//! e_d = e - 1/2 tr(e) I                                     its deviatoric part in the plane
//! ```
//!
//! Magnitude: the Frobenius norm |e_d| = sqrt(e_d : e_d), so simple shear by gamma has |e_d| = gamma/sqrt(2).
//! A rigid rotation by theta is not free of small strain: e = (cos theta - 1) I. That is purely volumetric, so the
//! deviatoric magnitude stays zero; the volumetric part is not to be trusted where the material turns.
//!
//! Sources: Bagi (2006), Analysis of microstructural strain tensors for granular assemblies; Chen et al. (2021),
//! appendix A.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// A displacement gradient, `[row][column]`: `gradient[0][1]` is du_x/dX_y.
pub type Gradient = [[f64; 2]; 2];

/// A group is singular (its places lie on one line) where the determinant of its moment tensor is below this share of
/// its squared trace.
const SINGULAR: f64 = 1e-10;

/// How many of the longest admitted edges the strip of periodic images is wide: circumcircles of triangles without
/// longer edges stay well inside it.
const STRIP_IN_EDGES: f64 = 3.0;

/// The gradient that maps `d_reference` (dX, m) onto `d_displacement` (du, m) best in the sense of least squares. Both
/// are deviations from the centre of their group. None where the places do not span the plane.
pub fn best_fit_gradient(d_reference: &[[f64; 2]], d_displacement: &[[f64; 2]]) -> Option<Gradient> {
    assert_eq!(d_reference.len(), d_displacement.len(), "a displacement for every place");
    let mut moment = [0.0; 3];
    let mut mixed = [[0.0; 2]; 2];
    for (place, displacement) in d_reference.iter().zip(d_displacement) {
        moment[0] += place[0] * place[0];
        moment[1] += place[0] * place[1];
        moment[2] += place[1] * place[1];
        for (row, component) in mixed.iter_mut().zip(displacement) {
            row[0] += component * place[0];
            row[1] += component * place[1];
        }
    }
    let trace = moment[0] + moment[2];
    let determinant = moment[0] * moment[2] - moment[1] * moment[1];
    if determinant.is_nan() || determinant <= SINGULAR * trace * trace {
        return None;
    }
    Some(
        mixed.map(|[x, y]| {
            [(x * moment[2] - y * moment[1]) / determinant, (y * moment[0] - x * moment[1]) / determinant]
        }),
    )
}

/// |e_d| = sqrt(e_d : e_d) of the small strain of a displacement gradient, in the plane.
pub fn deviatoric_norm(gradient: &Gradient) -> f64 {
    let half_difference = 0.5 * (gradient[0][0] - gradient[1][1]);
    let shear = 0.5 * (gradient[0][1] + gradient[1][0]);
    (2.0 * (half_difference * half_difference + shear * shear)).sqrt()
}

/// Deviatoric magnitude |e_d| of the best-fit strain at every row.
///
/// `positions` (m) are places after the deformation, x in [0, `period`); `displacements` (m) are not wrapped and lead
/// to them, so the reference place is position - displacement. Neighbours are those of the Delaunay triangulation of
/// `positions`, joined across the seam where `period` (m) is positive; edges longer than `edge_max` (m) do not count,
/// so that nothing is fitted across a void. NaN where the neighbours do not span the plane.
///
/// The sum of a row runs over its neighbours in ascending order of row: give rows in an order that ids alone fix, and
/// every bit is fixed.
pub fn best_fit_strains(positions: &[[f64; 2]], displacements: &[[f64; 2]], period: f64, edge_max: f64) -> Vec<f64> {
    best_fit_gradients(positions, displacements, period, edge_max)
        .iter()
        .map(|gradient| gradient.as_ref().map_or(f64::NAN, deviatoric_norm))
        .collect()
}

/// The gradients behind [`best_fit_strains`]; None where the neighbours do not span the plane.
pub fn best_fit_gradients(
    positions: &[[f64; 2]],
    displacements: &[[f64; 2]],
    period: f64,
    edge_max: f64,
) -> Vec<Option<Gradient>> {
    assert_eq!(positions.len(), displacements.len(), "a displacement for every row");
    let mut places = Vec::new();
    let mut moves = Vec::new();
    neighbours(positions, period, edge_max)
        .iter()
        .enumerate()
        .map(|(row, around)| {
            places.clear();
            moves.clear();
            // Everything relative to the row itself: small numbers lose no digits.
            places.push([0.0; 2]);
            moves.push([0.0; 2]);
            for neighbour in around {
                let other = neighbour.row;
                let shift = f64::from(neighbour.image) * period;
                let du = [0, 1].map(|axis| displacements[other][axis] - displacements[row][axis]);
                let dx = [positions[other][0] + shift - positions[row][0], positions[other][1] - positions[row][1]];
                places.push([dx[0] - du[0], dx[1] - du[1]]);
                moves.push(du);
            }
            centre(&mut places);
            centre(&mut moves);
            best_fit_gradient(&places, &moves)
        })
        .collect()
}

/// Subtracts the mean.
fn centre(vectors: &mut [[f64; 2]]) {
    let mut sum = [0.0; 2];
    for vector in vectors.iter() {
        sum[0] += vector[0];
        sum[1] += vector[1];
    }
    let count = vectors.len() as f64;
    for vector in vectors.iter_mut() {
        vector[0] -= sum[0] / count;
        vector[1] -= sum[1] / count;
    }
}

/// A row next to another one, or its image `image` periods to the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Neighbour {
    row: usize,
    image: i8,
}

/// A row or one of its images, as a vertex of the triangulation.
struct Vertex {
    position: Point2<f64>,
    row: usize,
    image: i8,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// Delaunay neighbours of every row, ascending, without edges longer than `edge_max`.
///
/// Rows at exactly the same place are one vertex: the first of them is everyone's neighbour, and the others have the
/// first one's neighbours.
fn neighbours(positions: &[[f64; 2]], period: f64, edge_max: f64) -> Vec<Vec<Neighbour>> {
    let places: Vec<[f64; 2]> = positions.iter().map(|place| place.map(flush)).collect();
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| {
        places[a][0].total_cmp(&places[b][0]).then(places[a][1].total_cmp(&places[b][1])).then(a.cmp(&b))
    });
    let mut first_at_place = vec![0; places.len()];
    for (index, &row) in order.iter().enumerate() {
        let same = index > 0 && places[order[index - 1]] == places[row];
        first_at_place[row] = if same { first_at_place[order[index - 1]] } else { row };
    }

    let mut vertices = Vec::new();
    for (row, place) in places.iter().enumerate().filter(|&(row, _)| first_at_place[row] == row) {
        let mut add = |image: i8| {
            let position = Point2::new(place[0] + f64::from(image) * period, place[1]);
            vertices.push(Vertex { position, row, image });
        };
        add(0);
        if period > 0.0 {
            let strip = (STRIP_IN_EDGES * edge_max).min(period);
            if place[0] <= strip {
                add(1);
            }
            if place[0] >= period - strip {
                add(-1);
            }
        }
    }
    let triangulation: DelaunayTriangulation<Vertex> =
        DelaunayTriangulation::bulk_load(vertices).expect("places are finite");

    let mut around = vec![Vec::new(); places.len()];
    for edge in triangulation.undirected_edges() {
        let [a, b] = edge.vertices().map(|vertex| (vertex.data().row, vertex.data().image));
        if edge.length_2() > edge_max * edge_max {
            continue;
        }
        // An edge between two images is a copy of one that has an end in the specimen itself.
        if a.1 == 0 {
            around[a.0].push(Neighbour { row: b.0, image: b.1 });
        }
        if b.1 == 0 {
            around[b.0].push(Neighbour { row: a.0, image: a.1 });
        }
    }
    for list in &mut around {
        list.sort_unstable();
        list.dedup();
    }
    for row in 0..places.len() {
        if first_at_place[row] != row {
            around[row] = around[first_at_place[row]].clone();
        }
    }
    around
}

/// Zero for what is too small for the exact predicates of the triangulation.
fn flush(coordinate: f64) -> f64 {
    if coordinate.abs() < 1e-100 { 0.0 } else { coordinate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math;

    /// A disturbed lattice of `columns` by `rows` at spacing one; the disturbance repeats nowhere within it.
    fn lattice(columns: usize, rows: usize) -> Vec<[f64; 2]> {
        let mut places = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let phase = (row * columns + column) as f64;
                places.push([
                    column as f64 + 0.5 + 0.3 * math::sin(12.9898 * phase),
                    row as f64 + 0.5 + 0.3 * math::sin(78.233 * phase + 1.0),
                ]);
            }
        }
        places
    }

    /// Places after moving by `gradient`, wrapped, and the displacements that lead there.
    fn deformed(reference: &[[f64; 2]], gradient: Gradient, period: f64) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
        reference
            .iter()
            .map(|place| {
                let u = gradient.map(|row| row[0] * place[0] + row[1] * place[1]);
                let x = place[0] + u[0];
                let x = if period > 0.0 { x.rem_euclid(period) } else { x };
                ([x, place[1] + u[1]], u)
            })
            .unzip()
    }

    #[test]
    fn a_uniform_gradient_is_recovered_exactly() {
        let gradient = [[0.03, 0.2], [-0.05, -0.01]];
        let (positions, displacements) = deformed(&lattice(12, 9), gradient, 0.0);
        for fit in best_fit_gradients(&positions, &displacements, 0.0, 3.0) {
            let fit = fit.expect("every row of a lattice has neighbours");
            for (found, expected) in fit.iter().flatten().zip(gradient.iter().flatten()) {
                assert!((found - expected).abs() < 1e-13, "{found} instead of {expected}");
            }
        }
    }

    #[test]
    fn simple_shear_by_gamma_has_magnitude_gamma_over_root_two() {
        assert!((deviatoric_norm(&[[0.0, 0.4], [0.0, 0.0]]) - 0.4 / 2.0_f64.sqrt()).abs() < 1e-16);
        assert!((deviatoric_norm(&[[0.1, 0.0], [0.0, -0.1]]) - 0.1 * 2.0_f64.sqrt()).abs() < 1e-16);
        assert_eq!(deviatoric_norm(&[[0.1, 0.3], [-0.3, 0.1]]), 0.0);
    }

    #[test]
    fn a_rigid_rotation_shows_as_volumetric_strain_only() {
        let angle = 0.3;
        let gradient = [[math::cos(angle) - 1.0, -math::sin(angle)], [math::sin(angle), math::cos(angle) - 1.0]];
        let (positions, displacements) = deformed(&lattice(10, 10), gradient, 0.0);
        for fit in best_fit_gradients(&positions, &displacements, 0.0, 3.0) {
            let fit = fit.unwrap();
            assert!(deviatoric_norm(&fit) < 1e-13);
            assert!((fit[0][0] + fit[1][1] - 2.0 * (math::cos(angle) - 1.0)).abs() < 1e-13);
        }
    }

    #[test]
    fn the_seam_of_a_periodic_specimen_leaves_no_trace() {
        let period = 20.0;
        let reference = lattice(20, 15);
        // Sheared far enough for the upper rows to go round more than once.
        let (positions, displacements) = deformed(&reference, [[0.0, 1.7], [0.0, 0.0]], period);
        let strains = best_fit_strains(&positions, &displacements, period, 3.0);
        for (place, strain) in positions.iter().zip(strains) {
            assert!((strain - 1.7 / 2.0_f64.sqrt()).abs() < 1e-12, "{strain} at {place:?}");
        }
    }

    #[test]
    fn a_shift_along_the_period_changes_nothing() {
        let period = 16.0;
        let reference = lattice(16, 12);
        let u =
            |place: &[f64; 2]| [0.8 * math::atan(place[1] - 6.0), 0.1 * math::sin(2.0 * math::PI * place[0] / period)];
        let strains = |shift: f64| {
            let moved: Vec<_> = reference.iter().map(u).collect();
            let places: Vec<_> = reference
                .iter()
                .zip(&moved)
                .map(|(place, u)| [(place[0] + u[0] + shift).rem_euclid(period), place[1] + u[1]])
                .collect();
            best_fit_strains(&places, &moved, period, 3.0)
        };
        for (here, there) in strains(0.0).iter().zip(strains(5.37)) {
            assert!((here - there).abs() < 1e-9, "{here} and {there}");
        }
    }

    #[test]
    fn nothing_is_fitted_across_a_void() {
        // Two halves that each move rigidly; the void between them is wider than the longest edge.
        let mut positions = lattice(10, 5);
        let upper: Vec<_> = positions.iter().map(|place| [place[0], place[1] + 10.0]).collect();
        let mut displacements = vec![[0.0; 2]; positions.len()];
        displacements.extend(vec![[3.0, 0.0]; upper.len()]);
        positions.extend(upper);
        for strain in best_fit_strains(&positions, &displacements, 10.0, 3.0) {
            assert!(strain < 1e-13);
        }
    }

    #[test]
    fn a_lonely_row_has_no_strain_and_twins_share_one() {
        let strains = best_fit_strains(&[[1.0, 1.0], [9.0, 9.0]], &[[0.0; 2]; 2], 0.0, 2.0);
        assert!(strains.iter().all(|strain| strain.is_nan()));
        assert!(best_fit_strains(&[], &[], 1.0, 2.0).is_empty());

        let gradient = [[0.0, 0.1], [0.0, 0.0]];
        let mut reference = lattice(6, 6);
        reference.push(reference[14]);
        let (positions, displacements) = deformed(&reference, gradient, 0.0);
        for strain in best_fit_strains(&positions, &displacements, 0.0, 3.0) {
            assert!((strain - 0.1 / 2.0_f64.sqrt()).abs() < 1e-13);
        }
    }
}
