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

/// The domain's cells: periodic in x, row by row in y. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellGrid {
    pub counts: [usize; 2],
    pub cell: f64,
    /// y of the lower edge; x starts at zero.
    pub lower: f64,
}

impl CellGrid {
    pub fn period(&self) -> f64 {
        self.counts[0] as f64 * self.cell
    }

    /// Index of the cell at a place, wrapped in x; none below or above the grid.
    pub fn at(&self, x: f64, y: f64) -> Option<usize> {
        let column = (x / self.cell).floor() as i64;
        let row = ((y - self.lower) / self.cell).floor() as i64;
        let inside = row >= 0 && row < self.counts[1] as i64;
        inside.then(|| row as usize * self.counts[0] + column.rem_euclid(self.counts[0] as i64) as usize)
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
            [column as f64 * grid.cell, grid.lower + row as f64 * grid.cell]
        };
        let mut zone = Self { grid, labels: Vec::new(), flagged: flagged.iter().map(place).collect() };
        let half = 0.5 * grid.cell;
        let label = |cell: usize| {
            let x = ((cell % grid.counts[0]) as f64 + 0.5) * grid.cell;
            let y = grid.lower + ((cell / grid.counts[0]) as f64 + 0.5) * grid.cell;
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

    /// Distance of a place to the nearest flagged node across the period, m.
    pub fn distance(&self, place: [f64; 2]) -> f64 {
        let period = self.grid.period();
        self.flagged.iter().fold(f64::INFINITY, |least, node| {
            let apart = (place[0] - node[0]).rem_euclid(period);
            let x = apart.min(period - apart);
            let y = place[1] - node[1];
            least.min((x * x + y * y).sqrt())
        })
    }

    /// Label of a place, continuum outside the grid.
    pub fn at(&self, x: f64, y: f64) -> Label {
        self.grid.at(x, y).map_or(Label::Continuum, |cell| self.labels[cell])
    }
}
