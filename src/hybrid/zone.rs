//! Which cells become grains: seed 000 (Chen et al. 2021), section 4.

use crate::scenario::Enrichment;

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Label {
    Continuum,
    /// The reconciliation zone: grains and points at once.
    Rim,
    Grains,
}

/// The domain's cells, row by row in y. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellGrid {
    pub counts: [usize; 2],
    pub cell: f64,
    /// The lower corner.
    pub lower: [f64; 2],
    /// Whether the last column is beside the first.
    pub periodic: bool,
}

impl CellGrid {
    pub fn period(&self) -> f64 {
        self.counts[0] as f64 * self.cell
    }

    /// Index of the cell at a place, wrapped in x where the grid is periodic; none beyond the grid.
    pub fn at(&self, x: f64, y: f64) -> Option<usize> {
        self.cell_at(((x - self.lower[0]) / self.cell).floor() as i64, ((y - self.lower[1]) / self.cell).floor() as i64)
    }

    fn cell_at(&self, column: i64, row: i64) -> Option<usize> {
        let columns = self.counts[0] as i64;
        let column = if self.periodic { column.rem_euclid(columns) } else { column };
        let inside = (0..self.counts[1] as i64).contains(&row) && (0..columns).contains(&column);
        inside.then(|| row as usize * self.counts[0] + column as usize)
    }

    /// The cells beside one along either axis.
    pub fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (column, row) = ((cell % self.counts[0]) as i64, (cell / self.counts[0]) as i64);
        let sides = [[-1, 0], [1, 0], [0, -1], [0, 1]];
        sides.into_iter().filter_map(move |[x, y]| self.cell_at(column + x, row + y))
    }
}

/// Labels of all cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    pub grid: CellGrid,
    pub labels: Vec<Label>,
    /// Places of the flagged nodes, m.
    flagged: Vec<[f64; 2]>,
}

impl Zone {
    /// Cells within `phi_0 - t_h/2` of a flagged node are grains, those within `phi_0 + t_h/2` the rim; t_h is one cell.
    pub fn around(flagged: &[u64], grid: CellGrid, settings: &Enrichment) -> Self {
        let place = |node: &u64| {
            let (column, row) = (node % grid.counts[0] as u64, node / grid.counts[0] as u64);
            [grid.lower[0] + column as f64 * grid.cell, grid.lower[1] + row as f64 * grid.cell]
        };
        let mut zone = Self { grid, labels: Vec::new(), flagged: flagged.iter().map(place).collect() };
        let half = 0.5 * grid.cell;
        let label = |cell: usize| {
            let x = grid.lower[0] + ((cell % grid.counts[0]) as f64 + 0.5) * grid.cell;
            let y = grid.lower[1] + ((cell / grid.counts[0]) as f64 + 0.5) * grid.cell;
            let distance = zone.distance([x, y]);
            if distance <= settings.distance - half {
                Label::Grains
            } else if distance <= settings.distance + half {
                Label::Rim
            } else {
                Label::Continuum
            }
        };
        zone.labels = (0..grid.counts[0] * grid.counts[1]).map(label).collect();
        zone
    }

    /// Distance of a place to the nearest flagged node, across the period if there is one, m.
    pub fn distance(&self, place: [f64; 2]) -> f64 {
        let period = self.grid.period();
        self.flagged.iter().fold(f64::INFINITY, |least, node| {
            let x = if self.grid.periodic {
                let apart = (place[0] - node[0]).rem_euclid(period);
                apart.min(period - apart)
            } else {
                place[0] - node[0]
            };
            let y = place[1] - node[1];
            least.min((x * x + y * y).sqrt())
        })
    }

    /// Label of a place, continuum outside the grid.
    pub fn at(&self, x: f64, y: f64) -> Label {
        self.grid.at(x, y).map_or(Label::Continuum, |cell| self.labels[cell])
    }
}
