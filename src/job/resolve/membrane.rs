//! Membranes of a job on a grid.

use super::body::{self, AXES};
use super::digits;
use super::mpm::{Owners, WHOLE_TOLERANCE, chosen, domain};
use crate::base::error::Error;
use crate::job::mpm::{Grid, Membrane, Path};
use crate::job::raw::Reader;

/// Of a membrane: latex of 0.3 mm, kg/m2, and segments of half a cell.
const MASS_PER_AREA_DEFAULT: f64 = 0.3;
const SPACING_DEFAULT: f64 = 0.5;
/// Vertices that all membranes may have, about: every rank has all of them, and ranks tell each other all of them at every step.
const VERTICES_MAX: f64 = 1e5;
const OF_MEMBRANE: Owners<2> = [("line", &["from", "to"]), ("circle", &["centre", "radius"])];

pub fn membranes(top: &Reader<'_>, grid: &Grid) -> Result<Vec<Membrane>, Error> {
    let mut membranes: Vec<Membrane> = Vec::new();
    for table in top.tables("membrane") {
        if grid.dimension != 2 {
            return Err(table.refusal_of_table(
                "is a line, and this grid is in space, where a membrane would be a sheet. Remove it, and write a [[load]] with kind = \"pressure\" on the face of the material.",
            ));
        }
        let Some(membrane) = table.one_of_many(membrane(&table, grid)) else { continue };
        if membranes.iter().any(|other| other.name == membrane.name) {
            return Err(table.refusal("name", "names another membrane already. Give each a name of its own."));
        }
        membranes.push(membrane);
        if membranes.iter().map(|membrane| membrane.path.length() / membrane.spacing).sum::<f64>() > VERTICES_MAX {
            return Err(table.refusal(
                "spacing",
                &format!("makes more than {VERTICES_MAX:e} vertices of all membranes together. Take longer segments."),
            ));
        }
    }
    Ok(membranes)
}

fn membrane(table: &Reader<'_>, grid: &Grid) -> Result<Membrane, Error> {
    let domain = domain(grid);
    let name = body::name_of_columns(table)?;
    let within = |key: &str| body::inside(table, key, &domain).map(|[x, y, _]| [x, y]);
    let path = match chosen(table, "shape", "shape", &OF_MEMBRANE, None) {
        "line" => Path::Line { from: within("from")?, to: within("to")? },
        _ => Path::Circle { centre: within("centre")?, radius: table.number("radius") },
    };
    if let Path::Circle { centre, radius } = path {
        let outside = |axis: &usize| {
            !grid.periodic[*axis] && !(grid.lower[*axis] + radius..=grid.upper[*axis] - radius).contains(&centre[*axis])
        };
        if let Some(axis) = (0..2).find(outside) {
            return Err(table.refusal(
                "radius",
                &format!("reaches out of the grid along {}. Lower it, or move the centre.", AXES[axis]),
            ));
        }
    }
    if path.length() == 0.0 {
        return Err(table.refusal("to", "is where the line begins. Move one of the two ends."));
    }
    let membrane = Membrane {
        name,
        path,
        spacing: table.number_or("spacing", SPACING_DEFAULT * grid.cell),
        mass_per_area: table.number_or("mass_per_area", MASS_PER_AREA_DEFAULT),
        stiffness: table.number("stiffness"),
        damping: table.number_or("damping", 0.0),
        tension: table.number_or("tension", 0.0),
        pressure: table.number("pressure"),
        ramp: table.number_or("ramp", 0.0),
    };
    let shortest = membrane.stiffness * membrane.segment();
    if membrane.spacing > grid.cell * (1.0 + WHOLE_TOLERANCE) {
        return Err(table.refusal(
            "spacing",
            &format!(
                "is longer than a cell, {} m, so that nodes between two vertices would feel nothing of the membrane and material would come through. Write half a cell.",
                digits(grid.cell)
            ),
        ));
    }
    if membrane.tension >= shortest {
        return Err(table.refusal(
            "tension",
            &format!(
                "would have its segments at rest at no length at all: stiffness times the length of a segment is {} N. Lower the tension, or take a stiffer membrane.",
                digits(shortest)
            ),
        ));
    }
    Ok(membrane)
}
