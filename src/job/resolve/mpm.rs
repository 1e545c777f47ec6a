//! A continuum of material points on a grid.

use super::body::{self, AXES, Domain, check_bodies, unit};
use super::granular::{check as check_granular, granular, place_bands, stand_in_for_faces};
use super::limits::refuse_steps;
use super::material::File;
use super::membrane::check_membranes;
use super::mpm_checks::{check, simple};
use super::{SAFETY_DEFAULT, check_name, digits, output};
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::job::derived::FRACTION_DENSE;
use crate::job::figures::moduli_affine;
use crate::job::mpm::forecast::fraction_of_packing;
use crate::job::mpm::{
    Boundary, Face, Followed, Gravity, Grid, InitialStress, Load, Mesh, Mpm, Region, RegionShape, Watch, figures,
    polygon_area,
};
use crate::job::raw::{Reader, Typed};
use crate::job::stable::governing;
use crate::law::material::ConstitutiveLaw;
use crate::mpm::load::LOADS_MAX;
use crate::mpm::nonlocal::Nonlocal;
use crate::mpm::scheme::{Scheme, StressUpdate};
use crate::mpm::shape::margins;

/// Steps of the continuum between two looks of the oracle.
const LOOK_EVERY_DEFAULT: u64 = 20;
/// How far an extent may be from whole cells, in cells.
pub(super) const WHOLE_TOLERANCE: f64 = 1e-6;
/// Cells that a grid may have.
const CELLS_MAX: f64 = 1e9;
/// Edge of a block in cells, in the plane and in space.
const BLOCK_OF_PLANE: usize = 8;
const BLOCK_OF_SOLID: usize = 4;

/// Why hats go with some of the schemes only.
const NODES_THROWN: &str = "goes with transfer = \"blend\" and update = \"modified_last\" or \"first\" alone: where stress is updated last (which it is unless the job says so) or velocities are affine, a node that a point barely reaches is thrown about at any time step. Take one of those updates, or another shape.";

/// The checked continuum of a job.
pub fn mpm(typed: &Typed) -> Result<Mpm, Error> {
    let why = "a continuum";
    let mut job = Mpm::blank();
    (job.grid, job.mesh) = domain_of(typed, why)?;
    let axes = job.grid.dimension;
    let mut top = typed.table("", true, why).with_axes(axes);
    let mut time = typed.table("time", true, why);
    let mut cut = typed.table("decomposition", false, why);
    job.scheme = match job.mesh {
        Some(_) => super::mesh::scheme(typed),
        None => scheme(&mut typed.table("scheme", false, why))?,
    };
    job.grains = granular(typed, &top, &job.grid, &time)?.map(Box::new);
    job.head(&mut top);
    check_name(&top, &job.name);
    let mut material = typed.table("material", true, why);
    let file = File::of(&material)?;
    if let Some(file) = &file {
        material = material.over(file.table());
    }
    job.material.keys(&mut material, job.grains.is_some());
    if let Some(granular) = job.grains.as_mut().filter(|granular| !granular.method.has_rves()) {
        granular.keys_of_start(&mut material);
    }
    file.as_ref().map_or(Ok(()), File::stop_if_wrong)?;
    let law = &mut job.material.law;
    if law.yields() && law.fraction().is_none() {
        *law = law.with_fraction(law.fraction_by_default());
        // Beside grains their packing tells it.
        if law.fraction().is_none() && job.grains.is_none() {
            material.note_without("fraction");
            *law = law.with_fraction(FRACTION_DENSE);
        }
    }
    typed.check(match_material(&job, &material));
    job.nonlocal = nonlocal(typed, &job);
    if let Some(grains) = &job.grains {
        // As far as it is known before the packing is made.
        job.material.density = grains.piece.matter.density * fraction_of_packing(&job);
    }
    let mut gravity = typed.table_if_typed("gravity").with_axes(axes);
    if gravity.is_typed() {
        job.gravity.keys(&mut gravity);
    }
    let mut stress = typed.table_if_typed("stress");
    job.stress.keys(&mut stress);
    typed.check(place_geostatic(&mut job.stress, &stress, &job.grid, &job.gravity));
    let (mut named, mut parts) = (Vec::new(), Vec::new());
    job.lists(&mut top, &mut named, &mut parts);
    if let Some(grains) = &mut job.grains {
        place_bands(grains, parts, &top, typed);
    }
    place_boundaries(&mut job, &named, &top);
    super::mesh::fill_domain(&mut job, &top);
    super::mesh::place_groups(&mut job, &top);
    check_lists(&mut job, &top, typed)?;
    super::mesh::check(&mut job, &named, typed, &top);
    stand_in_for_faces(&mut job);
    job.keys_of_time(&mut time);
    job.oracle = oracle(typed, &job)?;
    job.cells_per_block = 0;
    job.keys_of_decomposition(&mut cut);
    job.cells_per_block = cells_per_block(&cut, job.cells_per_block, &job)?;
    typed.stop_if_wrong()?;
    if let Some((granular, _)) = job.rves() {
        let stress = figures::pressures_at_start(&job).last().copied().unwrap_or_default();
        job.material.law = ConstitutiveLaw::Grains(moduli_affine(&granular.piece, fraction_of_packing(&job), stress));
    }
    job.step = step(&mut time, &job)?;
    if let Some(grains) = &mut job.grains {
        // Grains of RVEs have a step of their own.
        if !grains.method.has_rves() {
            grains.piece.step = job.step;
        }
        grains.piece.end = grains.piece.step;
    }
    refuse_steps(typed, job.end, job.step, "time.end")?;
    let mut shown = typed.table("output", false, why);
    (job.output, job.ledger) = output(&mut shown, job.end, job.step)?;
    if job.output.contact_frames && job.grains.is_none() {
        return Err(
            shown.refusal("contact_frames", "writes the contacts of grains, and this job has none. Remove the line.")
        );
    }
    check(&job, typed, &top)?;
    check_granular(&job, typed, &top);
    Ok(job)
}

/// How strain is averaged, if it is.
fn nonlocal(typed: &Typed, job: &Mpm) -> Option<Nonlocal> {
    let mut table = typed.table_if_typed("nonlocal");
    if !table.is_typed() {
        return None;
    }
    let mut nonlocal = Nonlocal::BLANK;
    nonlocal.keys(&mut table);
    check_nonlocal(&table, &nonlocal, job);
    Some(nonlocal)
}

/// What laws cannot do that RVEs can.
pub(super) fn check_nonlocal(table: &Reader<'_>, nonlocal: &Nonlocal, job: &Mpm) {
    if job.rves().is_some() {
        return;
    }
    if nonlocal.lag > 0 {
        table.add(table.refusal(
            "lag",
            "is refused: it is of RVEs, which keep the increment of the step before, and laws do not. Write lag = 0, or leave it out.",
        ));
    }
    if job.mesh.is_none() && job.scheme.update != StressUpdate::Last {
        table.add(table.refusal_of_table(
            "averages the strain of points with a law once they have moved, and scheme.update has it before that. Write update = \"last\" there, or remove the table.",
        ));
    }
}

/// A material that is grains is that of one method, and of no other.
fn match_material(job: &Mpm, table: &Reader<'_>) -> Result<(), Error> {
    let is_grains = matches!(job.material.law, ConstitutiveLaw::Grains(_));
    match (is_grains, job.rves().is_some()) {
        (true, false) => Err(table.refusal("law", "makes every point an assembly of the job's grains, which is method = \"mpm_dem\" (of elements \"fem_dem\") with [grains], [packing] and [contact]. Write these, or another law.")),
        (false, true) => Err(table.refusal("law", "is a closed form, and this method has grains at every point. Write law = \"grains\", or another method.")),
        _ => Ok(()),
    }
}

/// The domain, and where its cells are elements how.
fn domain_of(typed: &Typed, why: &str) -> Result<(Grid, Option<Mesh>), Error> {
    let meshed = typed.table("mesh", false, why);
    let on_grid = typed.table("grid", !meshed.is_typed(), why);
    match (meshed.is_typed(), on_grid.is_typed()) {
        (true, true) => Err(on_grid.refusal_of_table("stands beside [mesh], and each is the domain of the continuum. Remove one of the two: points are on a grid, elements in a mesh.")),
        (true, false) => super::mesh::mesh(meshed).map(|(grid, mesh)| (grid, Some(mesh))),
        (false, _) => grid(on_grid).map(|grid| (grid, None)),
    }
}

fn grid(mut table: Reader<'_>) -> Result<Grid, Error> {
    let mut grid = Mpm::blank().grid;
    grid.keys(&mut table);
    if (0..grid.dimension).any(|axis| grid.upper[axis] <= grid.lower[axis]) {
        return Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis."));
    }
    for axis in 0..grid.dimension {
        grid.cells[axis] = whole_cells(&table, &grid, axis)?;
    }
    let cells: f64 = grid.cells.iter().map(|count| *count as f64).product();
    if cells > CELLS_MAX {
        return Err(table.refusal(
            "cell",
            &format!("makes {cells:.1e} cells, and at most {CELLS_MAX:e} are allowed. Take larger cells."),
        ));
    }
    Ok(grid)
}

fn whole_cells(table: &Reader<'_>, grid: &Grid, axis: usize) -> Result<usize, Error> {
    let extent = grid.extent(axis);
    let count = (extent / grid.cell).round();
    if count >= 1.0 && (extent / grid.cell - count).abs() <= WHOLE_TOLERANCE {
        return Ok(count as usize);
    }
    let fewer = (extent / grid.cell).floor().max(1.0);
    Err(table.refusal(
        "cell",
        &format!(
            "does not fit: whole cells must fill the {} m of the grid along {}. Write \"{} m\" to have {} there, or \"{} m\" to have {}.",
            digits(extent),
            AXES[axis],
            digits(extent / fewer),
            fewer,
            digits(extent / (fewer + 1.0)),
            fewer + 1.0
        ),
    ))
}

pub(super) fn scheme(table: &mut Reader<'_>) -> Result<Scheme, Error> {
    let mut scheme = Scheme::DEFAULT;
    scheme.keys(table);
    if scheme.feels_nodes() && scheme.shape.steepness(scheme.points_per_cell).is_infinite() {
        return Err(table.refusal("shape", NODES_THROWN));
    }
    Ok(scheme)
}

/// Finds the axis of a geostatic stress, and refuses one that gravity does not go with.
fn place_geostatic(
    stress: &mut InitialStress,
    table: &Reader<'_>,
    grid: &Grid,
    gravity: &Gravity,
) -> Result<(), Error> {
    let InitialStress::Geostatic { axis: along_axis, up, surface, .. } = stress else { return Ok(()) };
    let along: Vec<usize> = (0..grid.dimension).filter(|axis| gravity.acceleration[*axis] != 0.0).collect();
    let [axis] = along[..] else {
        return Err(table.refusal(
            "kind",
            "is the stress under gravity along one axis, and gravity.acceleration is not. Write for example gravity.acceleration = [0, \"-9.81 m/s2\"].",
        ));
    };
    if gravity.ramp > 0.0 {
        return Err(table.refusal(
            "kind",
            "balances gravity from the start, and gravity.ramp raises it from zero. Remove gravity.ramp, or the stress.",
        ));
    }
    if grid.periodic[axis] {
        return Err(table.refusal(
            "kind",
            &format!(
                "grows along {}, and the grid is periodic there. Set grid.periodic to false along {0}.",
                AXES[axis]
            ),
        ));
    }
    if !(grid.lower[axis]..=grid.upper[axis]).contains(surface) {
        return Err(table.refusal(
            "surface",
            &format!(
                "lies outside of the grid, which reaches from {} to {} m along {}. Move it inside.",
                digits(grid.lower[axis]),
                digits(grid.upper[axis]),
                AXES[axis]
            ),
        ));
    }
    (*along_axis, *up) = (axis, -gravity.acceleration[axis].signum());
    Ok(())
}

pub(super) fn domain(grid: &Grid) -> Domain {
    let Grid { dimension, lower, upper, periodic, .. } = *grid;
    Domain { name: "grid", dimension, lower, upper, periodic, coheres: true }
}

/// What was typed in lists, held to the grid and to the material.
fn check_lists(job: &mut Mpm, top: &Reader<'_>, typed: &Typed) -> Result<(), Error> {
    let domain = domain(&job.grid);
    if job.regions.is_empty() {
        return Err(top.refusal("region", "is empty, and a continuum has material somewhere. Add a [[region]]."));
    }
    for (region, table) in job.regions.iter_mut().zip(&top.list("region")) {
        table.one_of_many(check_region(region, table, &job.grid, &job.material.law));
    }
    let loads = top.list("load");
    if let Some(table) = loads.get(LOADS_MAX) {
        return Err(table.refusal_of_table(&format!(
            "is one of {}, and at most {LOADS_MAX} are allowed. Join loads that are alike in one window, or remove some.",
            loads.len()
        )));
    }
    for (load, table) in job.loads.iter_mut().zip(&loads) {
        table.one_of_many(check_load(load, table, &job.grid));
    }
    typed.check(check_membranes(&mut job.membranes, top, &job.grid));
    check_bodies(job.bodies.iter_mut().map(|body| &mut body.body), top, &domain);
    typed.check(super::mpm_checks::check_faces(job, top));
    typed.check(super::mpm_checks::check_places_of_loads(job, top));
    for (number, table) in top.list("follow").iter().enumerate() {
        let Followed { name, place, frames } = &job.follow[number];
        typed.check(body::check_name_of_columns(table, name));
        let bodies = job.bodies.iter().map(|body| &body.body.name);
        if bodies.chain(job.follow[..number].iter().map(|point| &point.name)).any(|other| other == name) {
            table.add(table.refusal("name", "names another point or body already. Give each a name of its own."));
        }
        if name == "rve" && job.rves().is_some() {
            table.add(table.refusal("name", "is that of all RVEs in the series. Take another one."));
        }
        typed.check(body::check_inside(table, "place", place, &domain));
        if *frames && job.rves().is_none() {
            table.add(table.refusal("frames", "draws the grains of an RVE, and this job has none. Remove the line."));
        } else if *frames && name.contains('.') {
            let why =
                "is also that of files, whose parts have numbers behind a \".\". Write it without, or frames = false.";
            table.add(table.refusal("name", why));
        }
    }
    Ok(())
}

fn check_region(region: &mut Region, table: &Reader<'_>, grid: &Grid, law: &ConstitutiveLaw) -> Result<(), Error> {
    check_region_shape(&region.shape, table, grid)?;
    if table.has("fraction") && matches!(law, ConstitutiveLaw::Grains(_)) {
        return Err(table
            .refusal("fraction", "is that of the packing, where every point has grains of its own. Remove the line."));
    }
    if table.has("fraction") && !law.yields() {
        let problem = format!(
            "belongs to law = {}; an elastic material has no solid volume fraction. Remove the line.",
            ConstitutiveLaw::yielding()
        );
        return Err(table.refusal("fraction", &problem));
    }
    if table.has("grains_removed") && !matches!(law, ConstitutiveLaw::Grains(_)) {
        return Err(
            table.refusal("grains_removed", "takes grains out of RVEs, and this job has none. Remove the line.")
        );
    }
    if region.fraction.is_nan() {
        region.fraction = law.fraction().unwrap_or(1.0);
    }
    for (wave, table) in region.waves.iter_mut().zip(&table.list("wave")) {
        unit(&mut wave.direction, "direction", table)?;
        if wave.origin[0].is_nan() {
            wave.origin = grid.lower;
        }
    }
    Ok(())
}

fn check_region_shape(shape: &RegionShape, table: &Reader<'_>, grid: &Grid) -> Result<(), Error> {
    let domain = domain(grid);
    match shape {
        RegionShape::Box { lower, upper } => body::check_corners(table, lower, upper, &domain),
        RegionShape::Ball { centre, radius } => {
            body::check_inside(table, "centre", centre, &domain)?;
            let outside =
                |axis: &usize| centre[*axis] - radius < grid.lower[*axis] || centre[*axis] + radius > grid.upper[*axis];
            match (0..grid.dimension).find(outside) {
                Some(axis) => Err(table.refusal(
                    "radius",
                    &format!(
                        "reaches beyond the grid along {}. Make it smaller, or move its centre inwards.",
                        AXES[axis]
                    ),
                )),
                None => Ok(()),
            }
        }
        RegionShape::Polygon { vertices } => check_polygon(vertices, table, grid),
        // It has been found in the file.
        RegionShape::Group { .. } => Ok(()),
    }
}

fn check_polygon(vertices: &[[f64; 2]], table: &Reader<'_>, grid: &Grid) -> Result<(), Error> {
    if grid.dimension == 3 {
        return Err(table.refusal("shape", "belongs to space = \"plane\". In space write \"box\" or \"ball\"."));
    }
    let outside = |vertex: &[f64; 2]| (0..2).any(|axis| !(grid.lower[axis]..=grid.upper[axis]).contains(&vertex[axis]));
    if let Some([x, y]) = vertices.iter().find(|vertex| outside(vertex)) {
        return Err(table.refusal(
            "vertices",
            &format!("has a corner outside of the grid, at {} and {} m. Move it inside.", digits(*x), digits(*y)),
        ));
    }
    if polygon_area(vertices) == 0.0 || !simple(vertices) {
        return Err(table.refusal(
            "vertices",
            "is no simple polygon: its border crosses or touches itself, or encloses nothing. List the corners in order around it.",
        ));
    }
    Ok(())
}

/// Each face as it was typed; others have rollers, or are periodic with the grid, or lie beyond its axes.
fn place_boundaries(job: &mut Mpm, named: &[(Face, Boundary)], top: &Reader<'_>) {
    let grid = &job.grid;
    let mut boundaries: [[Option<Boundary>; 2]; 3] = Default::default();
    for (number, table) in top.list("boundary").iter().enumerate() {
        let (face, kind) = named[number];
        if grid.periodic[face.axis] {
            table.one_of_many::<()>(Err(table.refusal(
                "face",
                &format!(
                    "is no boundary: the grid is periodic along {}. Remove this [[boundary]], or set grid.periodic to false there.",
                    AXES[face.axis]
                ),
            )));
        }
        let place = &mut boundaries[face.axis][usize::from(face.upper)];
        if place.is_some() {
            table.one_of_many::<()>(Err(table.refusal("face", "has a boundary already. Keep one of them.")));
        }
        *place = Some(kind);
    }
    job.boundaries = std::array::from_fn(|axis| {
        let default = match axis {
            axis if axis >= grid.dimension => Boundary::Free,
            axis if grid.periodic[axis] => Boundary::Periodic,
            _ => Boundary::Roller,
        };
        boundaries[axis].map(|kind| kind.unwrap_or(default))
    });
}

fn check_load(load: &mut Load, table: &Reader<'_>, grid: &Grid) -> Result<(), Error> {
    for (corner, wall) in [(&mut load.lower, grid.lower), (&mut load.upper, grid.upper)] {
        if corner[0].is_nan() {
            *corner = wall;
        }
    }
    match (0..grid.dimension).all(|axis| load.lower[axis] < load.upper[axis]) {
        true => Ok(()),
        false => Err(table.refusal(
            if table.has("upper") { "upper" } else { "lower" },
            "leaves no window: its upper corner must be more than its lower one along every axis.",
        )),
    }
}

/// Whether a band is looked for.
fn oracle(typed: &Typed, job: &Mpm) -> Result<Option<Watch>, Error> {
    let mut table = typed.table_if_typed("oracle");
    if !table.is_typed() {
        return Ok(None);
    }
    if job.grid.dimension != 2 {
        return Err(table.refusal_of_table("looks for bands in the plane, and this grid is in space. Remove it."));
    }
    if job.grid.periodic[1] {
        return Err(table.refusal_of_table(
            "looks across periods along x alone, and this grid is periodic along y. Turn the job by a quarter, or remove the table.",
        ));
    }
    if !job.material.law.yields() {
        let problem = format!(
            "looks for plastic flow, and an elastic material has none. Remove it, or take law = {}.",
            ConstitutiveLaw::yielding()
        );
        return Err(table.refusal_of_table(&problem));
    }
    let mut watch = Watch::BLANK;
    if let Some(grains) = &job.grains {
        watch.diameter = grains.piece.matter.diameter_mean;
    }
    watch.oracle.every = LOOK_EVERY_DEFAULT * job.grain_steps;
    watch.keys(&mut table);
    Ok(Some(watch))
}

/// As large as wanted, as long as blocks fill every periodic axis; larger where none of those does.
/// `typed` is 0 where the job does not say.
fn cells_per_block(table: &Reader<'_>, typed: usize, job: &Mpm) -> Result<usize, Error> {
    let (grid, shape) = (&job.grid, job.scheme.shape);
    // Elements have no tiles.
    let least = if job.mesh.is_some() { 1 } else { margins(shape).into_iter().fold(0, usize::max) };
    let fits = |count: usize| (0..3).all(|axis| !grid.periodic[axis] || grid.cells[axis].is_multiple_of(count));
    let wanted = match (job.rves(), grid.dimension) {
        // What points cost is in their grains and differs from one to another: small blocks are dealt evenly.
        (Some(_), _) => least,
        (None, 2) => BLOCK_OF_PLANE,
        (None, _) => BLOCK_OF_SOLID,
    };
    let best = (least..=wanted).rev().chain(wanted + 1..=BLOCK_OF_PLANE).find(|count| fits(*count));
    let advice = match best {
        Some(best) => format!("Write {best}."),
        None => "Change grid.upper.".to_string(),
    };
    let refused = |problem: &str| Err(table.refusal("cells_per_block", &format!("{problem} {advice}")));
    match ((typed > 0).then_some(typed), best) {
        (Some(count), _) if count < least => refused(&format!(
            "is too few for the {least} nodes that scheme.shape = \"{}\" reaches beyond a block: a block and its neighbours must hold them, so at least {least} are needed.",
            shape.name()
        )),
        (Some(count), _) if fits(count) => Ok(count),
        (Some(_), _) => refused("does not fit: blocks must fill the grid along its periodic axes."),
        (None, Some(best)) => Ok(best),
        (None, None) => Err(table.refusal_of_table(&format!(
            "cannot be chosen: no number of cells from {least} (the least for scheme.shape = \"{}\") to {BLOCK_OF_PLANE} divides those along the periodic axes, {}. Change grid.upper or grid.cell.",
            shape.name(),
            (0..grid.dimension)
                .filter(|axis| grid.periodic[*axis])
                .map(|axis| format!("{} along {}", grid.cells[axis], AXES[axis]))
                .collect::<Vec<_>>()
                .join(" and ")
        ))),
    }
}

/// Given, or a share of the stable one.
fn step(table: &mut Reader<'_>, job: &Mpm) -> Result<f64, Error> {
    if table.has("step") && table.has("safety") {
        return Err(
            table.refusal("safety", "stands beside time.step, and each says how long a step is. Keep one of them.")
        );
    }
    if table.has("step") {
        return Ok(job.step);
    }
    let mut bounds = figures::bounds(job);
    if let Some(grains) = job.grains.as_ref().filter(|grains| !grains.method.has_rves()) {
        bounds.extend(crate::job::figures::bounds(&grains.piece));
    }
    Ok(Mpm::safety(table).unwrap_or(SAFETY_DEFAULT) * governing(&bounds).step)
}
