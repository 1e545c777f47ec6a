//! The rows of a test as columns, as files of data have them.

use serde::{Deserialize, Serialize};

use super::element::Row;

/// Columns of equal length; stresses in Pa, tension positive, pressure compression positive.
#[derive(Serialize, Deserialize)]
pub struct Columns {
    strain: Vec<f64>,
    stress_xx: Vec<f64>,
    stress_xy: Vec<f64>,
    stress_yy: Vec<f64>,
    pressure: Vec<f64>,
    fraction: Vec<f64>,
}

impl Columns {
    pub fn of(rows: &[Row]) -> Self {
        let column = |of: fn(&Row) -> f64| rows.iter().map(of).collect();
        Self {
            strain: column(|row| row.strain),
            stress_xx: column(|row| row.stress[0]),
            stress_xy: column(|row| row.stress[1]),
            stress_yy: column(|row| row.stress[2]),
            pressure: column(|row| row.pressure),
            fraction: column(|row| row.fraction),
        }
    }

    /// None where columns are of different lengths, or empty.
    pub fn rows(&self) -> Option<Vec<Row>> {
        let count = self.strain.len();
        let others = [&self.stress_xx, &self.stress_xy, &self.stress_yy, &self.pressure, &self.fraction];
        if count == 0 || others.iter().any(|column| column.len() != count) {
            return None;
        }
        let row = |index: usize| Row {
            strain: self.strain[index],
            stress: [self.stress_xx[index], self.stress_xy[index], self.stress_yy[index]],
            pressure: self.pressure[index],
            fraction: self.fraction[index],
        };
        Some((0..count).map(row).collect())
    }
}
