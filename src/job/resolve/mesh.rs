//! A continuum of elements, and what it has no use for.

use super::digits;
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::base::units::nearest;
use crate::job::Method;
use crate::job::assembly::{Shape, Source};
use crate::job::mpm::surface;
use crate::job::mpm::{BodyContact, Boundary, Face, Grid, Mesh, Mpm, Region, RegionShape, RigidBody};
use crate::job::raw::{Reader, Typed};
use crate::mpm::scheme::{Scheme, ShapeFunction, Transfer};
use crate::rve::Frame;

/// Elements that a job may have along an axis.
const ELEMENTS_MAX: f64 = 1e6;

/// The box that elements fill, and these.
pub fn mesh(mut table: Reader<'_>) -> Result<(Grid, Mesh), Error> {
    let (mut grid, mut mesh) = (Mpm::blank().grid, Mesh::BLANK);
    mesh.keys(&mut grid, &mut table);
    if let Some(file) = &mut mesh.file {
        // Another file is another mesh, whatever the job was resolved with.
        if table.is_set("file") && !table.is_set("sha256") {
            file.digest.clear();
        }
        if let Err(problem) = file.read(&table.folder(), &grid) {
            return Err(table.refusal("file", &problem));
        }
        file.place(&mut grid);
        return Ok((grid, mesh));
    }
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

/// A group that the job names, by the bits of its name.
fn bits_of_group(job: &Mpm, name: &str, of_sides: bool, table: &Reader<'_>) -> Result<u32, Error> {
    let Some(drawn) = job.drawn() else {
        let problem = "is a physical group of a mesh that was read from a file, and this job has none. Write mesh.file, or remove the line.";
        return Err(table.refusal("group", problem));
    };
    let known = drawn.names_of(of_sides);
    if known.contains(&name) {
        return Ok(drawn.bits_of(name));
    }
    let what = if of_sides { "sides" } else { "elements" };
    let advice = match (nearest(name, known.iter().copied()), known.is_empty()) {
        (Some(near), _) => format!("Did you mean \"{near}\"?"),
        (None, true) => format!(
            "It has none: give it some in Gmsh, as Physical Curve or Physical Surface{}.",
            if of_sides { "" } else { " or Physical Volume" }
        ),
        (None, false) => format!("It has {}.", known.join(", ")),
    };
    Err(table.refusal("group", &format!("is no physical group of {what} of mesh.file. {advice}")))
}

/// Finds the groups that regions, loads and bodies name.
pub fn place_groups(job: &mut Mpm, top: &Reader<'_>) {
    let mut regions = std::mem::take(&mut job.regions);
    for (region, table) in regions.iter_mut().zip(&top.list("region")) {
        let RegionShape::Group { name, bits, lower, upper } = &mut region.shape else { continue };
        let found = match bits_of_group(job, name, false, table) {
            Ok(found) => found,
            Err(error) => {
                table.add(error);
                continue;
            }
        };
        let drawn = job.drawn().expect("a group is one of a file");
        let inside = drawn.middles.iter().zip(&drawn.groups).filter(|(_, groups)| *groups & found != 0);
        let middles: Vec<&[f64; 3]> = inside.map(|(middle, _)| middle).collect();
        let extreme = |axis: usize, pick: fn(f64, f64) -> f64| {
            middles.iter().map(|middle| middle[axis]).reduce(pick).expect("a group has elements")
        };
        (*bits, *lower, *upper) = (
            found,
            std::array::from_fn(|axis| extreme(axis, f64::min)),
            std::array::from_fn(|axis| extreme(axis, f64::max)),
        );
    }
    job.regions = regions;
    let named = |group: &Option<String>, table: &Reader<'_>| {
        if let Some(Err(error)) = group.as_ref().map(|name| bits_of_group(job, name, true, table)) {
            table.add(error);
        }
    };
    job.loads.iter().zip(&top.list("load")).for_each(|(load, table)| named(&load.group, table));
    for (body, table) in job.bodies.iter().zip(&top.list("body")) {
        named(&body.group, table);
        let bits = body.group.as_ref().zip(job.drawn()).map_or(0, |(name, drawn)| drawn.bits_of(name));
        let is_placed = !job.regions.iter().any(|region| matches!(region.shape, RegionShape::Group { bits: 0, .. }));
        if bits != 0 && is_placed && !surface::has_group(job, bits) {
            table.add(table.refusal(
                "group",
                "is of elements that no [[region]] gives material, so that nothing is fastened. Take another group, or give them material.",
            ));
        }
    }
}

/// A side that is fastened to a body is held by that alone.
fn free_fastened_sides(job: &mut Mpm, named: &[(Face, Boundary)], top: &Reader<'_>) {
    for face in job.bodies.iter().filter_map(|body| body.side) {
        let boundary = &mut job.boundaries[face.axis][usize::from(face.upper)];
        let typed = named
            .iter()
            .zip(&top.list("boundary"))
            .find(|((other, _), _)| *other == face)
            .map(|(_, table)| table.clone());
        match typed.filter(|_| *boundary != Boundary::Free) {
            Some(table) => table.add(table.refusal(
                "face",
                "is a side that a [[body]] is fastened to, which alone says how it moves. Write kind = \"free\", or remove this [[boundary]].",
            )),
            None => *boundary = Boundary::Free,
        }
    }
}

/// A packing without half of its grains bears nothing.
fn check_removed(job: &Mpm, top: &Reader<'_>) {
    let Some(Source::Packed(packed)) = job.grains.as_ref().map(|grains| &grains.piece.source) else { return };
    for (region, table) in job.regions.iter().zip(&top.list("region")) {
        if 2 * region.grains_removed > packed.count {
            let problem = format!(
                "is more than half of the {} grains of the packing, and what is left bears nothing. Write less.",
                packed.count
            );
            table.add(table.refusal("grains_removed", &problem));
        }
    }
}

/// What bodies of a mesh do not ask for.
fn check_fastened(body: &RigidBody, is_fastened: bool, table: &Reader<'_>) {
    if table.has("contact_at") && body.at_face {
        table.add(
            table.refusal("contact_at", "is for points on a grid: bodies hold the nodes of elements. Remove the line."),
        );
    }
    if is_fastened && table.has("separates") && body.separates {
        table.add(table.refusal(
            "separates",
            "is for what a body touches, and a side that is fastened to it does not part. Remove the line.",
        ));
    }
    if body.group.is_some() && body.contact == BodyContact::Smooth && !matches!(body.body.shape, Shape::Plane { .. }) {
        table.add(table.refusal(
            "contact",
            "holds a group across the body's own face, which only that of a plane is the same everywhere. Write shape = \"plane\", or contact = \"rough\".",
        ));
    }
    if is_fastened && matches!(body.contact, BodyContact::Coulomb { .. }) {
        table.add(table.refusal(
            "contact",
            "rubs, and a side that is fastened to a body moves with it. Write \"rough\" or \"smooth\".",
        ));
    }
}

/// What is of points alone.
pub fn check(job: &mut Mpm, named: &[(Face, Boundary)], typed: &Typed, top: &Reader<'_>) {
    for (body, table) in job.bodies.iter_mut().zip(&top.list("body")) {
        match (&job.mesh, body.side) {
            (None, Some(_)) => {
                table.add(table.refusal("side", "is a side of a mesh, and this job has none. Remove the line."));
            }
            (Some(_), Some(face)) if job.grid.periodic[face.axis] => {
                table.add(table.refusal("side", "is no side: the mesh is periodic there. Take another."));
            }
            (Some(_), side) => {
                let is_fastened = side.is_some() || body.group.is_some();
                check_fastened(body, is_fastened, table);
                body.at_face = false;
                body.separates &= !is_fastened;
            }
            (None, None) => {}
        }
    }
    free_fastened_sides(job, named, top);
    check_removed(job, top);
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
