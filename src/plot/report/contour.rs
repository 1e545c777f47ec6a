//! The outline of a patch of scattered places: the border of all that lies within a reach of one of them.

use crate::analysis::strained::Span;

/// Cells of the grid per reach.
const CELLS_PER_REACH: f64 = 4.0;

/// Pieces of the border of the union of discs of radius `reach` (m) about the `places` (m), as pairs of ends; pieces may
/// lie up to a cell beyond the span.
pub fn outline(places: &[[f64; 2]], reach: f64, span: &Span) -> Vec<[[f64; 2]; 2]> {
    if places.is_empty() || reach.is_nan() || reach <= 0.0 {
        return Vec::new();
    }
    let grid = Grid::around(places, reach, span);
    let field = grid.distances(places, reach, span);
    let mut pieces = Vec::new();
    for row in 0..grid.rows - 1 {
        for column in 0..grid.columns - 1 {
            grid.cell_border(&field, column, row, reach, &mut pieces);
        }
    }
    pieces
}

struct Grid {
    cell: f64,
    lower: [f64; 2],
    columns: usize,
    rows: usize,
}

impl Grid {
    fn around(places: &[[f64; 2]], reach: f64, span: &Span) -> Self {
        let cell = reach / CELLS_PER_REACH;
        let (bottom, top) = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lower, upper), place| {
            (lower.min(place[1]), upper.max(place[1]))
        });
        let lower = [span.left - cell, bottom - reach - 2.0 * cell];
        let count = |length: f64| (length / cell).ceil() as usize + 1;
        Self { cell, lower, columns: count(span.width + 2.0 * cell), rows: count(top + reach + 2.0 * cell - lower[1]) }
    }

    fn node(&self, column: usize, row: usize) -> [f64; 2] {
        [self.lower[0] + column as f64 * self.cell, self.lower[1] + row as f64 * self.cell]
    }

    /// Distance of every node from the nearest place, cut a little beyond the reach.
    fn distances(&self, places: &[[f64; 2]], reach: f64, span: &Span) -> Vec<f64> {
        let far = reach + 2.0 * self.cell;
        let mut field = vec![far; self.columns * self.rows];
        let index = |coordinate: f64, axis: usize, count: usize| {
            (((coordinate - self.lower[axis]) / self.cell).max(0.0) as usize).min(count - 1)
        };
        for place in places {
            for image in span.images() {
                let x = place[0] + image * span.width;
                if x + far < self.lower[0] || x - far > span.left + span.width + self.cell {
                    continue;
                }
                for row in index(place[1] - far, 1, self.rows)..=index(place[1] + far, 1, self.rows) {
                    for column in index(x - far, 0, self.columns)..=index(x + far, 0, self.columns) {
                        let node = self.node(column, row);
                        let d = [node[0] - x, node[1] - place[1]];
                        let distance = (d[0] * d[0] + d[1] * d[1]).sqrt();
                        let stored = &mut field[row * self.columns + column];
                        *stored = stored.min(distance);
                    }
                }
            }
        }
        field
    }

    /// Marching squares (Lorensen and Cline 1987, in the plane) in one cell.
    fn cell_border(&self, field: &[f64], column: usize, row: usize, reach: f64, pieces: &mut Vec<[[f64; 2]; 2]>) {
        let corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)];
        let values = corners.map(|(column, row)| field[row * self.columns + column] - reach);
        let mut ends = Vec::with_capacity(4);
        for side in 0..4 {
            let next = (side + 1) % 4;
            if (values[side] < 0.0) != (values[next] < 0.0) {
                let share = values[side] / (values[side] - values[next]);
                let from = self.node(corners[side].0, corners[side].1);
                let to = self.node(corners[next].0, corners[next].1);
                ends.push([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]);
            }
        }
        for pair in ends.chunks_exact(2) {
            pieces.push([pair[0], pair[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math::PI;

    const ROUND: Span = Span { left: 0.0, width: 10.0, is_periodic: true, diameter: 1.0 };

    fn length(pieces: &[[[f64; 2]; 2]]) -> f64 {
        pieces.iter().map(|[a, b]| ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt()).sum()
    }

    #[test]
    fn one_place_has_a_circle() {
        let pieces = outline(&[[5.0, 5.0]], 1.0, &ROUND);
        assert!((length(&pieces) - 2.0 * PI).abs() < 0.2, "{}", length(&pieces));
        for end in pieces.iter().flatten() {
            let r = ((end[0] - 5.0) * (end[0] - 5.0) + (end[1] - 5.0) * (end[1] - 5.0)).sqrt();
            assert!((r - 1.0).abs() < 0.05, "{r}");
        }
    }

    #[test]
    fn a_row_round_the_period_has_two_lines() {
        let places: Vec<[f64; 2]> = (0..40).map(|index| [f64::from(index) * 0.25, 3.0]).collect();
        let pieces = outline(&places, 1.0, &ROUND);
        let inside: Vec<_> = pieces.into_iter().filter(|[a, _]| (0.0..10.0).contains(&a[0])).collect();
        assert!((length(&inside) - 20.0).abs() < 1.0, "{}", length(&inside));
        assert!(inside.iter().flatten().all(|end| ((end[1] - 3.0).abs() - 1.0).abs() < 0.1));
    }

    #[test]
    fn a_row_between_sides_that_are_apart_has_ends() {
        let places: Vec<[f64; 2]> = (0..33).map(|index| [21.0 + f64::from(index) * 0.25, 3.0]).collect();
        let span = Span { left: 20.0, is_periodic: false, ..ROUND };
        let pieces = outline(&places, 0.5, &span);
        assert!((length(&pieces) - (16.0 + PI)).abs() < 0.5, "{}", length(&pieces));
        assert!(pieces.iter().flatten().all(|end| (20.4..29.6).contains(&end[0])));
    }

    #[test]
    fn nothing_has_no_outline() {
        assert!(outline(&[], 1.0, &ROUND).is_empty());
    }
}
