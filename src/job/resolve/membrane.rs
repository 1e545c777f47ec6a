//! Membranes of a job on a grid.

use super::body::{self, AXES};
use super::digits;
use super::mpm::{WHOLE_TOLERANCE, domain};
use crate::base::error::Error;
use crate::job::mpm::{Grid, Membrane, Path};
use crate::job::raw::Reader;

/// Of a segment, in cells.
const SPACING_DEFAULT: f64 = 0.5;
/// Vertices that all membranes may have, about: every rank has all of them, and ranks tell each other all of them at every step.
const VERTICES_MAX: f64 = 1e5;

pub fn check_membranes(membranes: &mut [Membrane], top: &Reader<'_>, grid: &Grid) -> Result<(), Error> {
    let mut vertices = 0.0;
    let tables = top.list("membrane");
    for number in 0..membranes.len() {
        let (membrane, table) = (&mut membranes[number], &tables[number]);
        if grid.dimension != 2 {
            return Err(table.refusal_of_table(
                "is a line, and this grid is in space, where a membrane would be a sheet. Remove it, and write a [[load]] with kind = \"pressure\" on the face of the material.",
            ));
        }
        if membrane.spacing.is_nan() {
            membrane.spacing = SPACING_DEFAULT * grid.cell;
        }
        table.one_of_many(check_membrane(membrane, table, grid));
        vertices += membrane.path.length() / membrane.spacing;
        if membranes[..number].iter().any(|other| other.name == membranes[number].name) {
            table.add(table.refusal("name", "names another membrane already. Give each a name of its own."));
        }
        if vertices > VERTICES_MAX {
            return Err(table.refusal(
                "spacing",
                &format!("makes more than {VERTICES_MAX:e} vertices of all membranes together. Take longer segments."),
            ));
        }
    }
    Ok(())
}

fn check_membrane(membrane: &Membrane, table: &Reader<'_>, grid: &Grid) -> Result<(), Error> {
    let domain = domain(grid);
    body::check_name_of_columns(table, &membrane.name)?;
    let within = |key: &str, [x, y]: [f64; 2]| body::check_inside(table, key, &[x, y, 0.0], &domain);
    match membrane.path {
        Path::Line { from, to } => {
            within("from", from)?;
            within("to", to)?;
        }
        Path::Circle { centre, radius } => {
            within("centre", centre)?;
            let outside = |axis: &usize| {
                !grid.periodic[*axis]
                    && !(grid.lower[*axis] + radius..=grid.upper[*axis] - radius).contains(&centre[*axis])
            };
            if let Some(axis) = (0..2).find(outside) {
                return Err(table.refusal(
                    "radius",
                    &format!("reaches out of the grid along {}. Lower it, or move the centre.", AXES[axis]),
                ));
            }
        }
    }
    if membrane.path.length() == 0.0 {
        return Err(table.refusal("to", "is where the line begins. Move one of the two ends."));
    }
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
    Ok(())
}
