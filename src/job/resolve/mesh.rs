//! A continuum of elements, and what it has no use for.

use super::digits;
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::job::Method;
use crate::job::mpm::{Boundary, Face, Grid, Mesh, Mpm, Region, RegionShape};
use crate::job::raw::{Reader, Typed};
use crate::mpm::scheme::{Scheme, ShapeFunction, Transfer};
use crate::rve::Frame;

/// Elements that a job may have along an axis.
const ELEMENTS_MAX: f64 = 1e6;

/// The box that elements fill, and these.
pub fn mesh(mut table: Reader<'_>) -> Result<(Grid, Mesh), Error> {
    let (mut grid, mut mesh) = (Mpm::blank().grid, Mesh::BLANK);
    mesh.keys(&mut grid, &mut table);
    if (0..grid.dimension).any(|axis| grid.upper[axis] <= grid.lower[axis]) {
        return Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis."));
    }
    for axis in 0..grid.dimension {
        let count = mesh.elements[axis];
        if count.round() != count || !(1.0..=ELEMENTS_MAX).contains(&count) {
            let problem = format!(
                "has {}, and a whole number from 1 to {ELEMENTS_MAX:e} is wanted along every axis.",
                digits(count)
            );
            return Err(table.refusal("elements", &problem));
        }
        grid.cells[axis] = count as usize;
    }
    let edges = (0..grid.dimension).map(|axis| grid.extent(axis) / mesh.elements[axis]);
    grid.cell = edges.fold(f64::INFINITY, f64::min);
    Ok((grid, mesh))
}

/// Elements have shape functions of their own, and nothing that is averaged or carried between points and nodes.
pub fn scheme(typed: &Typed) -> Scheme {
    let table = typed.table_if_typed("scheme");
    if table.is_typed() {
        table.add(table.refusal_of_table("is that of points on a grid, and this job has elements. Remove it."));
    }
    Scheme {
        shape: ShapeFunction::Linear,
        transfer: Transfer::Blend { flip: 1.0 },
        points_per_cell: 1,
        averages_volume: false,
        ..Scheme::DEFAULT
    }
}

/// Why the method is that of the other kind of continuum, where it is.
pub fn other_method(method: Method, is_meshed: bool) -> Option<&'static str> {
    match (method, is_meshed) {
        (Method::FemDem, true) | (Method::Hybrid | Method::Dem | Method::Mpm | Method::MpmDem, false) => None,
        (Method::Fem | Method::FemDem, false) => {
            Some("is of elements, and this job has none. Write [mesh] in place of [grid], or another method.")
        }
        (_, true) => Some(
            "is not of elements, and this job has a [mesh]: with grains it is method = \"fem_dem\", and without any there is no key method.",
        ),
    }
}

/// All of the box is material where the job does not say.
pub fn fill_domain(job: &mut Mpm, top: &Reader<'_>) {
    if job.mesh.is_some() && top.list("region").is_empty() {
        let shape = RegionShape::Box { lower: job.grid.lower, upper: job.grid.upper };
        let fraction = job.material.law.fraction().unwrap_or(1.0);
        job.regions.push(Region { shape, fraction, ..Region::BLANK });
    }
}

/// What is of points alone.
pub fn check(job: &mut Mpm, named: &[(Face, Boundary)], typed: &Typed, top: &Reader<'_>) {
    for (body, table) in job.bodies.iter_mut().zip(&top.list("body")) {
        match (job.mesh, body.side) {
            (None, Some(_)) => {
                table.add(table.refusal("side", "is a side of a mesh, and this job has none. Remove the line."));
            }
            (Some(_), Some(face)) if job.grid.periodic[face.axis] => {
                table.add(table.refusal("side", "is no side: the mesh is periodic there. Take another."));
            }
            (Some(_), _) => body.at_face = false,
            (None, None) => {}
        }
    }
    if job.mesh.is_none() {
        if job.rves().is_some_and(|(_, rves)| rves.frame == Frame::Corotational) {
            let problem = "is of elements alone: points on a grid hand their RVEs all of the deformation. Write \"full\", or remove the line.";
            typed.note_together(typed.refusal("rve", "frame", problem));
        }
        return;
    }
    for (load, table) in job.loads.iter_mut().zip(&top.list("load")) {
        if table.has("acts_at") && !load.on_surface {
            table.add(
                table.refusal(
                    "acts_at",
                    "is for points on a grid; on elements loads act on the surface. Remove the line.",
                ),
            );
        }
        load.on_surface = true;
    }
    if let Some(table) = top.list("membrane").first() {
        table.add(table.refusal_of_table("presses on points on a grid, and this job has elements. Write a [[load]] of kind \"pressure\", which follows the surface."));
    }
    let oracle = typed.table_if_typed("oracle");
    if oracle.is_typed() {
        oracle.add(oracle.refusal_of_table("looks at points on a grid, and this job has elements. Remove it."));
    }
    for ((_, kind), table) in named.iter().zip(&top.list("boundary")) {
        if *kind == Boundary::Absorbing {
            table.add(table.refusal(
                "kind",
                "is for grids: sides of a mesh do not absorb. Write fixed, roller, friction or free.",
            ));
        }
    }
}
