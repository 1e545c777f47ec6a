//! The continuum's motion as a field over the place where things began, so that a packing can be moved along it.

use crate::couple::zone::CellGrid;

/// One point's contribution: where it began, its mass, and its displacements at the instants of the field, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// m.
    pub origin: [f64; 2],
    /// kg, without the point's weight.
    pub mass: f64,
    /// One per instant, in their order; training puts the velocity now, m/s, behind them.
    pub displacements: Vec<[f64; 2]>,
}

/// Displacement on the nodes of the background grid laid over the *initial* configuration, at several instants: the
/// mass-weighted mean of the points around, linear in between.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionField {
    grid: CellGrid,
    /// Of every node of the grid, which of those with material it is: in a wide domain these are few.
    numbers: Vec<u32>,
    /// Per instant and node with material.
    nodes: Vec<Vec<[f64; 2]>>,
}

/// A node without material.
const NOWHERE: u32 = u32::MAX;

impl MotionField {
    /// `points` in the order of their ids, which fixes the order of the sums.
    pub fn new(grid: CellGrid, points: &[Moved]) -> Self {
        let instants = points.first().map_or(0, |point| point.displacements.len());
        let mut numbers = vec![NOWHERE; grid.counts[0] * (grid.counts[1] + 1)];
        let mut mass = Vec::new();
        let mut sums = vec![Vec::new(); instants];
        for point in points {
            let around = corners(&grid, point.origin).into_iter().flatten();
            for (node, share) in around.filter(|(_, share)| share * point.mass > 0.0) {
                if numbers[node] == NOWHERE {
                    numbers[node] = mass.len() as u32;
                    mass.push(0.0);
                    sums.iter_mut().for_each(|sums| sums.push([0.0f64; 2]));
                }
                let node = numbers[node] as usize;
                mass[node] += share * point.mass;
                for (sum, displacement) in sums.iter_mut().zip(&point.displacements) {
                    for (sum, displacement) in sum[node].iter_mut().zip(displacement) {
                        *sum += share * point.mass * displacement;
                    }
                }
            }
        }
        let mean = |sums: Vec<[f64; 2]>| sums.iter().zip(&mass).map(|(sum, mass)| sum.map(|sum| sum / mass)).collect();
        Self { grid, numbers, nodes: sums.into_iter().map(mean).collect() }
    }

    /// Displacement at an instant of what began at `origin`; of the nearest material's where the corners carry none on
    /// one side, none where there is no material at all.
    pub fn at(&self, instant: usize, origin: [f64; 2]) -> Option<[f64; 2]> {
        let (mut sum, mut total) = ([0.0; 2], 0.0);
        for (node, share) in corners(&self.grid, origin).into_iter().flatten() {
            let number = self.numbers[node];
            if number != NOWHERE {
                let displacement = self.nodes[instant][number as usize];
                total += share;
                sum[0] += share * displacement[0];
                sum[1] += share * displacement[1];
            }
        }
        (total > 0.0).then(|| [sum[0] / total, sum[1] / total])
    }
}

/// The four nodes around a place with their linear shares. Beyond the sides of a grid without a period there is no material
/// whose motion nodes on the other side could take for theirs.
fn corners(grid: &CellGrid, place: [f64; 2]) -> [Option<(usize, f64)>; 4] {
    let [x, y] = [0, 1].map(|axis| (place[axis] - grid.lower[axis]) / grid.cell);
    let (column, row) = (x.floor(), y.floor());
    let (fx, fy) = (x - column, y - row);
    let node = |i: f64, j: f64, share: f64| {
        let row = row + j;
        let inside = row >= 0.0 && row <= grid.counts[1] as f64;
        let column = (column + i).rem_euclid(grid.counts[0] as f64);
        inside.then(|| (row as usize * grid.counts[0] + column as usize, share))
    };
    [
        node(0.0, 0.0, (1.0 - fx) * (1.0 - fy)),
        node(1.0, 0.0, fx * (1.0 - fy)),
        node(0.0, 1.0, (1.0 - fx) * fy),
        node(1.0, 1.0, fx * fy),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_motion_is_followed_exactly_inside() {
        let grid = CellGrid { counts: [4, 6], cell: 0.5, lower: [0.0, -1.0], periodic: true };
        let shear = |origin: [f64; 2]| [0.1 * origin[1] + 0.02, -0.05];
        let mut points = Vec::new();
        for j in 0..12 {
            for i in 0..8 {
                let origin = [0.125 + 0.25 * f64::from(i), -0.875 + 0.25 * f64::from(j)];
                points.push(Moved { origin, mass: 2.0, displacements: vec![[0.0; 2], shear(origin)] });
            }
        }
        let field = MotionField::new(grid, &points);
        for origin in [[0.3, 0.2], [1.9, 0.7], [0.01, 1.3]] {
            let found = field.at(1, origin).unwrap();
            let wanted = shear(origin);
            assert!(
                (found[0] - wanted[0]).abs() < 1e-14 && (found[1] - wanted[1]).abs() < 1e-14,
                "{found:?} {wanted:?}"
            );
        }
        assert_eq!(field.at(0, [0.3, 0.2]), Some([0.0, 0.0]));
    }
}
