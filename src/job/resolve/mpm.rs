//! A continuum of material points on a grid.

use super::body::{self, AXES, Domain};
use super::granular::{check as check_granular, granular};
use super::limits::refuse_steps;
use super::membrane::membranes;
use super::mpm_checks::{check, simple};
use super::{DEPTH_DEFAULT, digits, name, output};
use crate::base::error::Error;
use crate::couple::oracle::Oracle;
use crate::job::Output;
use crate::job::mpm::{
    BodyContact, Boundary, Elastic, Face, Followed, Granular, Gravity, Grid, InitialStress, LOADS_MAX, Load, LoadKind,
    Material, MaterialLaw, Mpm, Region, RegionShape, RigidBody, Watch, Wave, figures, polygon_area,
};
use crate::job::raw::{Reader, Typed};
use crate::job::stable::governing;
use crate::law::material::CriticalConstants;
use crate::mpm::scheme::{Scheme, ShapeFunction, StressUpdate, Transfer};
use crate::mpm::shape::margins;

const FLIP_DEFAULT: f64 = 0.99;
const POINTS_PER_CELL_DEFAULT: u64 = 2;
/// The step over the stable one.
const SAFETY_DEFAULT: f64 = 0.5;
/// Steps of the continuum between two looks of the oracle.
const LOOK_EVERY_DEFAULT: u64 = 20;
/// How far an extent may be from whole cells, in cells.
pub(super) const WHOLE_TOLERANCE: f64 = 1e-6;
/// Cells that a grid may have.
const CELLS_MAX: f64 = 1e9;
/// Edge of a block in cells, in the plane and in space.
const BLOCK_OF_PLANE: usize = 8;
const BLOCK_OF_SOLID: usize = 4;

const SHAPES: [(&str, ShapeFunction); 4] = [
    ("linear", ShapeFunction::Linear),
    ("generalised", ShapeFunction::Generalised),
    ("quadratic", ShapeFunction::Quadratic),
    ("cubic", ShapeFunction::Cubic),
];
const UPDATES: [(&str, StressUpdate); 3] =
    [("first", StressUpdate::First), ("last", StressUpdate::Last), ("modified_last", StressUpdate::ModifiedLast)];

/// Why hats go with some of the schemes only.
const NODES_THROWN: &str = "goes with transfer = \"blend\" and update = \"modified_last\" or \"first\" alone: where stress is updated last (which it is unless the job says so) or velocities are affine, a node that a point barely reaches is thrown about at any time step. Take one of those updates, or another shape.";

/// The keys that belong to each choice of a selector.
pub(super) type Owners<const N: usize> = [(&'static str, &'static [&'static str]); N];
const OF_TRANSFER: Owners<2> = [("blend", &["flip"]), ("affine", &[])];
const OF_ELASTIC: &[&str] = &["young_modulus", "poisson_ratio", "bulk_modulus", "shear_modulus"];
const OF_LAW: Owners<3> = [
    ("linear_elastic", OF_ELASTIC),
    ("hencky", OF_ELASTIC),
    (
        "critical_drucker_prager",
        &[
            "bulk_modulus",
            "shear_modulus",
            "friction_angle_critical",
            "fraction_critical",
            "fraction",
            "dilation_factor",
            "softening_rate",
            "cohesion",
            "dilation_angle",
        ],
    ),
];
const OF_REGION: Owners<3> =
    [("box", &["lower", "upper"]), ("ball", &["centre", "radius"]), ("polygon", &["vertices"])];
const OF_STRESS: Owners<3> =
    [("none", &[]), ("isotropic", &["pressure"]), ("geostatic", &["surface", "k0", "surcharge"])];
const OF_BOUNDARY: Owners<5> =
    [("fixed", &[]), ("roller", &[]), ("friction", &["coefficient"]), ("absorbing", &[]), ("free", &[])];
const OF_LOAD: Owners<2> = [("traction", &["traction"]), ("pressure", &["pressure"])];
const OF_CONTACT: Owners<3> = [("rough", &[]), ("smooth", &[]), ("coulomb", &["friction"])];

/// The choice of a selector, with the keys of other choices noted.
pub(super) fn chosen<const N: usize>(
    table: &Reader<'_>,
    selector: &str,
    noun: &str,
    owners: &Owners<N>,
    default: Option<&'static str>,
) -> &'static str {
    let names = owners.map(|(name, _)| (name, name));
    let chosen = match default {
        Some(default) => table.choice_or(selector, noun, &names, default),
        None => table.choose(selector, noun, &names),
    };
    table.note_keys_of_others(selector, chosen, owners);
    chosen
}

/// The checked continuum of a job.
pub fn mpm(typed: &Typed, file: &str) -> Result<Mpm, Error> {
    let why = "a continuum";
    let top = typed.table("", true, why);
    let name = name(&top)?;
    let grid = grid(typed.table("grid", true, why))?;
    let axes = grid.dimension;
    let top = top.with_axes(axes);
    let scheme = scheme(&typed.table("scheme", false, why))?;
    let time = typed.table("time", true, why);
    let grains = granular(typed, &top, &grid, &time, file)?;
    let material = material(&typed.table("material", true, why), grains.as_ref())?;
    let gravity = gravity(&typed.table("gravity", false, why).with_axes(axes));
    let stress = stress(&typed.table("stress", false, why), &grid, &gravity)?;
    let regions = regions(&top, &grid, &material.law)?;
    let (bodies, follow) = bodies_and_followed(&top, &grid)?;
    let grain_steps = if grains.is_some() { time.count_or("grain_steps", 1) } else { 1 };
    let of_grains = (grains.as_ref(), grain_steps);
    let oracle = oracle(&typed.table("oracle", false, why), &grid, &material.law, of_grains)?;
    let mut job = Mpm {
        name,
        scheme,
        material,
        regions,
        stress,
        gravity,
        boundaries: boundaries(&top, &grid)?,
        loads: loads(&top, &grid)?,
        membranes: membranes(&top, &grid)?,
        bodies,
        follow,
        oracle,
        grain_steps,
        grains: grains.map(Box::new),
        step: 0.0,
        end: 0.0,
        cells_per_block: cells_per_block(&typed.table("decomposition", false, why), &grid, scheme.shape)?,
        output: Output::default(),
        ledger: false,
        grid,
    };
    job.end = time.number("end");
    job.step = step(&time, &job)?;
    refuse_steps(typed, job.end, job.step, "time.end")?;
    let shown = typed.table("output", false, why);
    job.output = output(&shown, job.end, job.step)?;
    job.ledger = shown.flag_or("ledger", false);
    if job.ledger && !job.membranes.is_empty() {
        return Err(shown.refusal(
            "ledger",
            "keeps the account of what points, loads and bodies store and do, and does not know what membranes do. Remove it; summary.json tells what was kept of mass and momentum, membranes included.",
        ));
    }
    typed.stop_if_wrong()?;
    check(&job, typed, &top)?;
    check_granular(&job, typed, &top);
    Ok(job)
}

fn grid(table: Reader<'_>) -> Result<Grid, Error> {
    let dimension = table.choose("space", "space", &[("plane", 2), ("solid", 3)]);
    let table = table.with_axes(dimension);
    if dimension == 3 && table.has("depth") {
        return Err(table.refusal("depth", "belongs to space = \"plane\"; a solid has no depth. Remove the line."));
    }
    let mut grid = Grid {
        dimension,
        lower: table.vector_if_given("lower").unwrap_or_default(),
        upper: table.vector("upper"),
        cell: table.number("cell"),
        cells: [1; 3],
        periodic: table.flags_or("periodic", false),
        depth: table.number_or("depth", if dimension == 2 { DEPTH_DEFAULT } else { 1.0 }),
    };
    if (0..dimension).any(|axis| grid.upper[axis] <= grid.lower[axis]) {
        return Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis."));
    }
    for axis in 0..dimension {
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

fn scheme(table: &Reader<'_>) -> Result<Scheme, Error> {
    let transfer = match chosen(table, "transfer", "transfer", &OF_TRANSFER, Some("blend")) {
        "blend" => Transfer::Blend { flip: table.number_or("flip", FLIP_DEFAULT) },
        _ => Transfer::Affine,
    };
    let scheme = Scheme {
        shape: table.choice_or("shape", "shape function", &SHAPES, ShapeFunction::Quadratic),
        update: table.choice_or("update", "time to update stress", &UPDATES, StressUpdate::Last),
        transfer,
        points_per_cell: table.count_or("points_per_cell", POINTS_PER_CELL_DEFAULT) as usize,
    };
    if scheme.feels_nodes() && scheme.shape.steepness(scheme.points_per_cell).is_infinite() {
        return Err(table.refusal("shape", NODES_THROWN));
    }
    Ok(scheme)
}

fn material(table: &Reader<'_>, grains: Option<&Granular>) -> Result<Material, Error> {
    let law = match chosen(table, "law", "material law", &OF_LAW, None) {
        "linear_elastic" => MaterialLaw::LinearElastic(elastic(table)?),
        "hencky" => MaterialLaw::Hencky(elastic(table)?),
        _ => MaterialLaw::CriticalDruckerPrager(critical(table)?),
    };
    let density = match grains {
        None => table.number("density"),
        Some(_) if table.has("density") => {
            return Err(table.refusal(
                "density",
                "is that of the packing in a job with grains: grains.density times its packing fraction. Remove the line.",
            ));
        }
        // As far as it is known before the packing is made.
        Some(grains) => grains.piece.matter.density * law.fraction(),
    };
    Ok(Material { density, law })
}

/// E and nu, or K and G.
fn elastic(table: &Reader<'_>) -> Result<Elastic, Error> {
    let of_bulk = ["bulk_modulus", "shear_modulus"].into_iter().find(|key| table.has(key));
    let of_young = ["young_modulus", "poisson_ratio"].into_iter().find(|key| table.has(key));
    match (of_bulk, of_young) {
        (Some(key), Some(other)) => Err(table.refusal(
            key,
            &format!(
                "stands beside material.{other}, and two moduli are enough. Keep young_modulus and poisson_ratio, or bulk_modulus and shear_modulus."
            ),
        )),
        (Some(_), None) => Ok(Elastic {
            bulk_modulus: table.number("bulk_modulus"),
            shear_modulus: table.number("shear_modulus"),
        }),
        _ => {
            let (young, poisson) = (table.number("young_modulus"), table.number("poisson_ratio"));
            Ok(Elastic {
                bulk_modulus: young / (3.0 * (1.0 - 2.0 * poisson)),
                shear_modulus: young / (2.0 * (1.0 + poisson)),
            })
        }
    }
}

fn critical(table: &Reader<'_>) -> Result<CriticalConstants, Error> {
    let dilation_angle = table.number_if_given("dilation_angle");
    if dilation_angle.is_some() && table.number_or("dilation_factor", 0.0) != 0.0 {
        return Err(table.refusal(
            "dilation_angle",
            "stands beside material.dilation_factor, and each says how flow dilates. Drop dilation_factor for a constant angle of dilation and of friction, or dilation_angle for angles that follow the packing fraction.",
        ));
    }
    // With a constant psi nothing need follow the packing fraction.
    let or_still = |key: &str, still: f64| match dilation_angle {
        Some(_) => table.number_or(key, still),
        None => table.number(key),
    };
    let fraction_critical = or_still("fraction_critical", 0.8);
    Ok(CriticalConstants {
        bulk_modulus: table.number("bulk_modulus"),
        shear_modulus: table.number("shear_modulus"),
        friction_angle_critical: table.number("friction_angle_critical"),
        fraction_critical,
        fraction: or_still("fraction", fraction_critical),
        dilation_factor: or_still("dilation_factor", 0.0),
        softening_rate: or_still("softening_rate", 0.0),
        cohesion: table.number_or("cohesion", 0.0),
        dilation_angle,
    })
}

fn gravity(table: &Reader<'_>) -> Gravity {
    if !table.is_typed() {
        return Gravity { acceleration: [0.0; 3], ramp: 0.0 };
    }
    Gravity { acceleration: table.vector("acceleration"), ramp: table.number_or("ramp", 0.0) }
}

fn stress(table: &Reader<'_>, grid: &Grid, gravity: &Gravity) -> Result<InitialStress, Error> {
    match chosen(table, "kind", "kind of stress", &OF_STRESS, Some("none")) {
        "none" => Ok(InitialStress::None),
        "isotropic" => Ok(InitialStress::Isotropic { pressure: table.number("pressure") }),
        _ => geostatic(table, grid, gravity),
    }
}

fn geostatic(table: &Reader<'_>, grid: &Grid, gravity: &Gravity) -> Result<InitialStress, Error> {
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
    let surface = table.number("surface");
    if !(grid.lower[axis]..=grid.upper[axis]).contains(&surface) {
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
    Ok(InitialStress::Geostatic {
        axis,
        up: -gravity.acceleration[axis].signum(),
        surface,
        k0: table.number("k0"),
        surcharge: table.number_or("surcharge", 0.0),
    })
}

pub(super) fn domain(grid: &Grid) -> Domain {
    let Grid { dimension, lower, upper, periodic, .. } = *grid;
    Domain { name: "grid", dimension, lower, upper, periodic }
}

fn regions(top: &Reader<'_>, grid: &Grid, law: &MaterialLaw) -> Result<Vec<Region>, Error> {
    let tables = top.tables("region");
    if tables.is_empty() {
        return Err(top.refusal("region", "is empty, and a continuum has material somewhere. Add a [[region]]."));
    }
    Ok(tables.iter().filter_map(|table| table.one_of_many(region(table, grid, law))).collect())
}

fn region(table: &Reader<'_>, grid: &Grid, law: &MaterialLaw) -> Result<Region, Error> {
    let shape = region_shape(table, grid)?;
    if table.has("fraction") && !matches!(law, MaterialLaw::CriticalDruckerPrager(_)) {
        return Err(table.refusal(
            "fraction",
            "belongs to law = \"critical_drucker_prager\"; an elastic material has no packing fraction. Remove the line.",
        ));
    }
    Ok(Region {
        shape,
        fraction: table.number_or("fraction", law.fraction()),
        velocity: table.vector_if_given("velocity").unwrap_or_default(),
        spin: table.spin_if_given("spin").unwrap_or_default(),
        waves: table.tables("wave").iter().map(|wave| self::wave(wave, grid)).collect::<Result<_, _>>()?,
    })
}

fn region_shape(table: &Reader<'_>, grid: &Grid) -> Result<RegionShape, Error> {
    let domain = domain(grid);
    match chosen(table, "shape", "shape", &OF_REGION, None) {
        "box" => {
            let (lower, upper) = body::corners(table, &domain)?;
            Ok(RegionShape::Box { lower, upper })
        }
        "ball" => {
            let (centre, radius) = (body::inside(table, "centre", &domain)?, table.number("radius"));
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
                None => Ok(RegionShape::Ball { centre, radius }),
            }
        }
        _ => polygon(table, grid),
    }
}

fn polygon(table: &Reader<'_>, grid: &Grid) -> Result<RegionShape, Error> {
    if grid.dimension == 3 {
        return Err(table.refusal("shape", "belongs to space = \"plane\". In space write \"box\" or \"ball\"."));
    }
    let vertices = table.polygon("vertices");
    let outside = |vertex: &[f64; 2]| (0..2).any(|axis| !(grid.lower[axis]..=grid.upper[axis]).contains(&vertex[axis]));
    if let Some([x, y]) = vertices.iter().find(|vertex| outside(vertex)) {
        return Err(table.refusal(
            "vertices",
            &format!("has a corner outside of the grid, at {} and {} m. Move it inside.", digits(*x), digits(*y)),
        ));
    }
    if polygon_area(&vertices) == 0.0 || !simple(&vertices) {
        return Err(table.refusal(
            "vertices",
            "is no simple polygon: its border crosses or touches itself, or encloses nothing. List the corners in order around it.",
        ));
    }
    Ok(RegionShape::Polygon { vertices })
}

fn wave(table: &Reader<'_>, grid: &Grid) -> Result<Wave, Error> {
    Ok(Wave {
        direction: body::direction(table, "direction")?,
        length: table.number("length"),
        origin: table.vector_if_given("origin").unwrap_or(grid.lower),
        amplitude: table.vector("amplitude"),
    })
}

fn face(table: &Reader<'_>, grid: &Grid) -> Face {
    let faces: Vec<(String, Face)> = Face::all(grid.dimension).map(|face| (face.name(), face)).collect();
    let named: Vec<(&str, Face)> = faces.iter().map(|(name, face)| (name.as_str(), *face)).collect();
    table.choose("face", "face", &named)
}

fn boundaries(top: &Reader<'_>, grid: &Grid) -> Result<[[Boundary; 2]; 3], Error> {
    let mut boundaries: [[Option<Boundary>; 2]; 3] = Default::default();
    for table in top.tables("boundary") {
        let face = face(&table, grid);
        let kind = match chosen(&table, "kind", "kind of boundary", &OF_BOUNDARY, None) {
            "fixed" => Boundary::Fixed,
            "roller" => Boundary::Roller,
            "friction" => Boundary::Friction { coefficient: table.number("coefficient") },
            "absorbing" => Boundary::Absorbing,
            _ => Boundary::Free,
        };
        if grid.periodic[face.axis] {
            return Err(table.refusal(
                "face",
                &format!(
                    "is no boundary: the grid is periodic along {}. Remove this [[boundary]], or set grid.periodic to false there.",
                    AXES[face.axis]
                ),
            ));
        }
        let place = &mut boundaries[face.axis][usize::from(face.upper)];
        if place.is_some() {
            return Err(table.refusal("face", "has a boundary already. Keep one of them."));
        }
        *place = Some(kind);
    }
    Ok(std::array::from_fn(|axis| {
        let default = match axis {
            axis if axis >= grid.dimension => Boundary::Free,
            axis if grid.periodic[axis] => Boundary::Periodic,
            _ => Boundary::Roller,
        };
        boundaries[axis].map(|kind| kind.unwrap_or(default))
    }))
}

fn loads(top: &Reader<'_>, grid: &Grid) -> Result<Vec<Load>, Error> {
    let tables = top.tables("load");
    if let Some(table) = tables.get(LOADS_MAX) {
        return Err(table.refusal_of_table(&format!(
            "is one of {}, and at most {LOADS_MAX} are allowed. Join loads that are alike in one window, or remove some.",
            tables.len()
        )));
    }
    Ok(tables.iter().filter_map(|table| table.one_of_many(load(table, grid))).collect())
}

fn load(table: &Reader<'_>, grid: &Grid) -> Result<Load, Error> {
    let kind = chosen(table, "kind", "kind of load", &OF_LOAD, None);
    let (lower, upper) = (table.vector_if_given("lower"), table.vector_if_given("upper"));
    let load = Load {
        face: face(table, grid),
        lower: lower.unwrap_or(grid.lower),
        upper: upper.unwrap_or(grid.upper),
        kind: match kind {
            "traction" => LoadKind::Traction(table.vector("traction")),
            _ => LoadKind::Pressure(table.number("pressure")),
        },
        ramp: table.number_or("ramp", 0.0),
    };
    match (0..grid.dimension).all(|axis| load.lower[axis] < load.upper[axis]) {
        true => Ok(load),
        false => Err(table.refusal(
            if upper.is_some() { "upper" } else { "lower" },
            "leaves no window: its upper corner must be more than its lower one along every axis.",
        )),
    }
}

/// Defaults are those of Tables 6 and 9 of Chen et al. (2021), of the triaxial test and of indentation.
fn oracle(
    table: &Reader<'_>,
    grid: &Grid,
    law: &MaterialLaw,
    (grains, grain_steps): (Option<&Granular>, u64),
) -> Result<Option<Watch>, Error> {
    if !table.is_typed() {
        return Ok(None);
    }
    if grid.dimension != 2 {
        return Err(table.refusal_of_table("looks for bands in the plane, and this grid is in space. Remove it."));
    }
    if grid.periodic[1] {
        return Err(table.refusal_of_table(
            "looks across periods along x alone, and this grid is periodic along y. Turn the job by a quarter, or remove the table.",
        ));
    }
    if !matches!(law, MaterialLaw::CriticalDruckerPrager(_)) {
        return Err(table.refusal_of_table(
            "looks for plastic flow, and an elastic material has none. Remove it, or take law = \"critical_drucker_prager\".",
        ));
    }
    let oracle = Oracle {
        laplacian: table.number_or("laplacian", 1e-6),
        recent_strain: table.number_or("recent_strain", 8e-3),
        window: table.number_or("window", 2e-2),
        persistence: table.number_or("persistence", 9.6e-3),
        tolerance: table.number_or("tolerance", 0.0),
        every: table.count_or("every", LOOK_EVERY_DEFAULT * grain_steps),
    };
    let diameter = match grains {
        Some(grains) => table.number_or("diameter", grains.piece.matter.diameter_mean),
        None => table.number("diameter"),
    };
    Ok(Some(Watch { diameter, oracle }))
}

fn bodies_and_followed(top: &Reader<'_>, grid: &Grid) -> Result<(Vec<RigidBody>, Vec<Followed>), Error> {
    let domain = domain(grid);
    let mut bodies = Vec::new();
    for (body, table) in body::bodies(top, &domain) {
        let contact = match chosen(&table, "contact", "contact", &OF_CONTACT, None) {
            "rough" => BodyContact::Rough,
            "smooth" => BodyContact::Smooth,
            _ => BodyContact::Coulomb { friction: table.number("friction") },
        };
        let seat = table.number_if_given("seat").unwrap_or_default();
        bodies.push(RigidBody { body, contact, separates: table.flag_or("separates", true), seat });
    }
    let mut follow: Vec<Followed> = Vec::new();
    for table in top.tables("follow") {
        let name = body::name_of_columns(&table)?;
        let bodies = bodies.iter().map(|body: &RigidBody| body.body.name.as_str());
        if bodies.chain(follow.iter().map(|point| point.name.as_str())).any(|other| other == name) {
            return Err(table.refusal("name", "names another point or body already. Give each a name of its own."));
        }
        follow.push(Followed { name, place: body::inside(&table, "place", &domain)? });
    }
    Ok((bodies, follow))
}

/// As large as wanted, as long as blocks fill every periodic axis; larger where none of those does.
fn cells_per_block(table: &Reader<'_>, grid: &Grid, shape: ShapeFunction) -> Result<usize, Error> {
    let least = margins(shape).into_iter().fold(0, usize::max);
    let fits = |count: usize| (0..3).all(|axis| !grid.periodic[axis] || grid.cells[axis].is_multiple_of(count));
    let wanted = if grid.dimension == 2 { BLOCK_OF_PLANE } else { BLOCK_OF_SOLID };
    let best = (least..=wanted).rev().chain(wanted + 1..=BLOCK_OF_PLANE).find(|count| fits(*count));
    let advice = match best {
        Some(best) => format!("Write {best}."),
        None => "Change grid.upper.".to_string(),
    };
    let refused = |problem: &str| Err(table.refusal("cells_per_block", &format!("{problem} {advice}")));
    match (table.count_if_given("cells_per_block"), best) {
        (Some(count), _) if (count as usize) < least => refused(&format!(
            "is too few for the {least} nodes that scheme.shape = \"{}\" reaches beyond a block: a block and its neighbours must hold them, so at least {least} are needed.",
            name_of(shape)
        )),
        (Some(count), _) if fits(count as usize) => Ok(count as usize),
        (Some(_), _) => refused("does not fit: blocks must fill the grid along its periodic axes."),
        (None, Some(best)) => Ok(best),
        (None, None) => Err(table.refusal_of_table(&format!(
            "cannot be chosen: no number of cells from {least} (the least for scheme.shape = \"{}\") to {BLOCK_OF_PLANE} divides those along the periodic axes, {}. Change grid.upper or grid.cell.",
            name_of(shape),
            (0..grid.dimension)
                .filter(|axis| grid.periodic[*axis])
                .map(|axis| format!("{} along {}", grid.cells[axis], AXES[axis]))
                .collect::<Vec<_>>()
                .join(" and ")
        ))),
    }
}

/// As it is written in a job.
fn name_of(shape: ShapeFunction) -> &'static str {
    SHAPES.iter().find(|(_, other)| *other == shape).map(|(name, _)| *name).expect("every shape has a name")
}

/// Given, or a share of the stable one.
fn step(table: &Reader<'_>, job: &Mpm) -> Result<f64, Error> {
    match (table.number_if_given("step"), table.number_if_given("safety")) {
        (Some(_), Some(_)) => {
            Err(table.refusal("safety", "stands beside time.step, and each says how long a step is. Keep one of them."))
        }
        (Some(step), None) => Ok(step),
        (None, safety) => Ok(safety.unwrap_or(SAFETY_DEFAULT) * governing(&figures::bounds(job)).step),
    }
}
