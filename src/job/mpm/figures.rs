//! Figures that follow from a continuum: points, waves, stable steps, memory.

use std::ops::Range;

use super::forecast::fraction_of_packing;
use super::{Boundary, Granular, InitialStress, Load, Membrane, Mpm, Region, RegionShape, surface};
use crate::base::math::cbrt;
use crate::job::figures as of_grains;
use crate::job::stable::{Bound, oscillator_step_max};
use crate::mpm::shape::margins;

/// Bytes that one point takes with what is sorted beside it, in the plane and in space.
const BYTES_OF_POINT: [f64; 2] = [600.0, 860.0];
/// Bytes that one node takes.
const BYTES_OF_NODE: [f64; 2] = [80.0, 110.0];

/// Index of the plane or of space in the tables above.
fn space(job: &Mpm) -> usize {
    usize::from(job.grid.dimension == 3)
}

// Points

/// Ranges of places, along each axis, that can lie in a region.
pub fn places_of(job: &Mpm, region: &Region) -> [Range<usize>; 3] {
    let (lower, upper) = bounding_box(&region.shape);
    let places = job.places();
    if job.drawn().is_some() {
        return places.map(|count| 0..count);
    }
    std::array::from_fn(|axis| {
        if axis >= job.grid.dimension {
            return 0..1;
        }
        let spacing = job.spacing_along(axis);
        // One to each side, for rounding; the shape itself decides.
        let first = ((lower[axis] - job.grid.lower[axis]) / spacing).floor() - 1.0;
        let last = ((upper[axis] - job.grid.lower[axis]) / spacing).ceil() + 1.0;
        let within = |value: f64| (value.max(0.0) as usize).min(places[axis]);
        within(first)..within(last)
    })
}

/// Corners of the box around a region, m.
pub fn bounding_box(shape: &RegionShape) -> ([f64; 3], [f64; 3]) {
    match shape {
        RegionShape::Box { lower, upper } | RegionShape::Group { lower, upper, .. } => (*lower, *upper),
        RegionShape::Ball { centre, radius } => (centre.map(|x| x - radius), centre.map(|x| x + radius)),
        RegionShape::Polygon { vertices } => {
            let extreme = |axis: usize, pick: fn(f64, f64) -> f64| {
                vertices.iter().map(|vertex| vertex[axis]).reduce(pick).expect("a polygon has corners")
            };
            ([extreme(0, f64::min), extreme(1, f64::min), 0.0], [extreme(0, f64::max), extreme(1, f64::max), 0.0])
        }
    }
}

/// Indices of some ranges of places, x fastest.
pub fn indices([x, y, z]: [Range<usize>; 3]) -> impl Iterator<Item = [usize; 3]> {
    z.flat_map(move |z| {
        let x = x.clone();
        y.clone().flat_map(move |y| x.clone().map(move |x| [x, y, z]))
    })
}

/// All points.
pub fn points(job: &Mpm) -> u64 {
    points_of_regions(job).iter().sum()
}

/// Points of every region.
pub fn points_of_regions(job: &Mpm) -> Vec<u64> {
    let count = |(number, region): (usize, &Region)| {
        let inside = |index: &[usize; 3]| job.region_of(*index) == Some(number);
        indices(places_of(job, region)).filter(inside).count() as u64
    };
    job.regions.iter().enumerate().map(count).collect()
}

/// The most points that the regions can have, from their outlines alone.
pub fn points_max(job: &Mpm) -> f64 {
    let of = |region: &Region| places_of(job, region).iter().map(|range| range.len() as f64).product::<f64>();
    job.regions.iter().map(of).sum()
}

/// Points, or sides of elements, that bear each load, and their area at the start, m2.
pub fn bearing(job: &Mpm) -> Vec<(usize, f64)> {
    let of_points = |load: &Load| {
        let count = indices_loaded(job, load).count();
        (count, count as f64 * job.point_area())
    };
    match job.mesh {
        Some(_) => surface::bearing(job),
        None => job.loads.iter().map(of_points).collect(),
    }
}

fn indices_loaded(job: &Mpm, load: &Load) -> impl Iterator<Item = [usize; 3]> {
    let within = |region: &Region| {
        let ranges = places_of(job, region);
        std::array::from_fn(|axis| {
            if axis >= job.grid.dimension {
                return 0..1;
            }
            let at = |corner: f64| (corner - job.grid.lower[axis]) / job.spacing_along(axis);
            let first = (at(load.lower[axis]) - 1.0).max(0.0) as usize;
            let last = (at(load.upper[axis]) + 1.0).max(0.0) as usize;
            ranges[axis].start.max(first)..ranges[axis].end.min(last.saturating_add(1))
        })
    };
    job.regions.iter().enumerate().flat_map(move |(number, region)| {
        let bears = move |index: &[usize; 3]| job.region_of(*index) == Some(number) && job.bears(load, *index);
        indices(within(region)).filter(bears)
    })
}

/// The fewest rows of points behind the surface that a load acts on, the surface's own among them, and no more than `most`.
pub fn rows_behind(job: &Mpm, load: &Load, most: usize) -> usize {
    let behind = crate::job::mpm::Face { axis: load.face.axis, upper: !load.face.upper };
    let count = |mut index: [usize; 3]| {
        let mut rows = 1;
        while rows < most && job.has_point_beyond(index, behind) {
            index = job.beyond(index, behind);
            rows += 1;
        }
        rows
    };
    indices_loaded(job, load).map(count).min().unwrap_or(most)
}

/// Lowest and highest coordinate along an axis that the points of a region have, m.
pub fn span(job: &Mpm, number: usize, axis: usize) -> Option<[f64; 2]> {
    let indices = indices(places_of(job, &job.regions[number])).filter(|index| job.region_of(*index) == Some(number));
    let mut along = indices.map(|index| job.place(index)[axis]);
    let first = along.next()?;
    Some(along.fold([first; 2], |[lowest, highest], at| [lowest.min(at), highest.max(at)]))
}

/// Index of the point of the start that is nearest to a place, if it is within two cells; of several the one of lowest id.
pub fn nearest_point(job: &Mpm, place: &[f64; 3]) -> Option<[usize; 3]> {
    let reach = 2 * job.scheme.points_per_cell + 1;
    let places = job.places();
    let longest = (0..job.grid.dimension).map(|axis| job.edge(axis)).fold(0.0, f64::max);
    let around: [Range<usize>; 3] = std::array::from_fn(|axis| {
        if axis >= job.grid.dimension || job.drawn().is_some() {
            return 0..places[axis];
        }
        let at = ((place[axis] - job.grid.lower[axis]) / job.spacing_along(axis)).max(0.0) as usize;
        at.saturating_sub(reach)..(at + reach + 1).min(places[axis])
    });
    indices(around)
        .filter(|index| job.region_of(*index).is_some())
        .map(|index| (index, job.place(index)))
        .map(|(index, at)| {
            let away = |axis: usize| (at[axis] - place[axis]) * (at[axis] - place[axis]);
            (index, (0..job.grid.dimension).map(away).sum::<f64>())
        })
        .filter(|(_, square)| square.sqrt() <= 2.0 * longest)
        .min_by(|(_, one), (_, other)| one.total_cmp(other))
        .map(|(index, _)| index)
}

/// The different pressures that points begin under, ascending, Pa.
pub fn pressures_at_start(job: &Mpm) -> Vec<f64> {
    let mut pressures: Vec<f64> = match job.stress {
        InitialStress::None => Vec::new(),
        InitialStress::Isotropic { pressure } => vec![pressure],
        InitialStress::Geostatic { axis, .. } if job.drawn().is_some() => {
            let all = indices(job.places().map(|count| 0..count)).filter(|index| job.region_of(*index).is_some());
            all.map(|index| job.overburden(job.place(index)[axis])).collect()
        }
        InitialStress::Geostatic { axis, .. } => {
            let layers = |region: &Region| places_of(job, region)[axis].clone();
            let mut layers: Vec<usize> = job.regions.iter().flat_map(layers).collect();
            layers.sort_unstable();
            layers.dedup();
            let at = |layer: &usize| {
                let mut index = [0; 3];
                index[axis] = *layer;
                job.overburden(job.place(index)[axis])
            };
            let is_there = |layer: &usize| {
                let mut ranges = job.places().map(|count| 0..count);
                ranges[axis] = *layer..layer + 1;
                indices(ranges).any(|index| job.region_of(index).is_some())
            };
            layers.iter().filter(|layer| is_there(layer)).map(at).collect()
        }
    };
    pressures.sort_unstable_by(f64::total_cmp);
    pressures.dedup();
    pressures
}

// Grain assemblies at every point

/// Bytes that a grain of an RVE takes with its contacts, and in a checkpoint, in the plane and in space (BENCHMARKS.md).
const BYTES_IN_RVE: [[f64; 2]; 2] = [[173.0, 88.0], [316.0, 184.0]];

/// Edge of an RVE, about, m.
pub fn edge_of_rve(job: &Mpm) -> Option<f64> {
    let (granular, _) = job.rves()?;
    let sizes = of_grains::sizes(&granular.piece)?;
    let count = of_grains::grains(&granular.piece)? as f64;
    let measure = count * of_grains::grain_measure(sizes, job.grid.dimension) / fraction_of_packing(job);
    Some(if job.grid.dimension == 2 { measure.sqrt() } else { cbrt(measure) })
}

/// Bytes of all RVEs in memory and in a checkpoint, about.
pub fn rve_bytes(job: &Mpm) -> [f64; 2] {
    let grains = job.rves().and_then(|(granular, _)| of_grains::grains(&granular.piece)).unwrap_or_default();
    BYTES_IN_RVE[space(job)].map(|bytes| bytes * grains as f64 * points(job) as f64)
}

// Waves and steps

/// Speed of waves along and across their direction at the start, m/s.
pub fn wave_speeds(job: &Mpm) -> (f64, f64) {
    let law = &job.material.law;
    let along = law.modulus_longitudinal(job.grid.dimension);
    let density = job.inertial_density();
    ((along / density).sqrt(), (law.shear_modulus() / density).sqrt())
}

fn norm(vector: &[f64; 3]) -> f64 {
    (vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]).sqrt()
}

/// An upper bound of the speeds that the job itself gives to regions and bodies, m/s.
pub fn speed_max(job: &Mpm) -> f64 {
    let of_regions = job.regions.iter().map(|region| {
        let (lower, upper) = bounding_box(&region.shape);
        let reach = norm(&std::array::from_fn(|axis| {
            let centre = region.shape.centre()[axis];
            if axis < job.grid.dimension { (upper[axis] - centre).max(centre - lower[axis]) } else { 0.0 }
        }));
        let waves: f64 = region.waves.iter().map(|wave| norm(&wave.amplitude)).sum();
        norm(&region.velocity) + norm(&region.spin) * reach + waves
    });
    let of_bodies = job.bodies.iter().map(|body| {
        let motion = &body.body.motion;
        let radius = match body.body.shape {
            crate::job::assembly::Shape::Cylinder { radius, .. } => radius,
            _ => 0.0,
        };
        let path = motion.path.iter().map(|point| norm(&point.velocity) + norm(&point.spin) * radius);
        path.fold(0.0, f64::max)
            + motion.oscillation.map_or(0.0, |sine| sine.speed())
            + motion.servo.as_ref().map_or(0.0, |servo| servo.speed_max)
    });
    of_regions.chain(of_bodies).fold(0.0, f64::max)
}

/// The longest step that crosses no more than a cell by waves and motion, s.
pub fn step_through(cell: f64, wave: f64, speed: f64) -> f64 {
    cell / (wave + speed)
}

/// The longest step at which no node is thrown about by the points around it, however little of them it has, s.
///
/// A point of mass m gives node i the mass `m N_i` and the force `-V tau grad N_i`, and takes from it the strain
/// `grad N_i a_i dt^2`. The largest eigenvalue of that map is no more than the largest of a single point's (Irons & Treharne
/// 1971), `omega^2 = s M/(density cell^2)` with s of [`crate::mpm::scheme::ShapeFunction::steepness`] and M of a free point, in any arrangement of
/// points. Where points average the nodes' velocities between steps nothing swings and stress relaxes by `1 - (omega dt)^2` a
/// step, so `omega dt <= sqrt(2)`; where they do not, a leapfrog would bear 2.
fn step_of_free_nodes(job: &Mpm) -> f64 {
    let steepness = job.scheme.shape.steepness(job.scheme.points_per_cell);
    let wave_squared = job.material.law.modulus_free(job.grid.dimension) / job.material.density;
    job.grid.cell * (2.0 / (steepness * wave_squared)).sqrt()
}

/// What bounds the step of the continuum. Dashpots of servos are implicit in the new velocity of a body and bound nothing. Those of absorbing
/// faces act on what a node had ([`crate::bodies::boundary::absorbed`]): half a cell of material must have what they take, or they
/// are cut short and waves come back.
pub fn bounds(job: &Mpm) -> Vec<Bound> {
    if job.mesh.is_some() {
        let stiffest = job.element_stiffest();
        return vec![Bound {
            cause: "waves through an element",
            formula: "2/w, w^2 = 4 c^2 sum 1/h^2 over the edges h of an element (of n corners of any shape n c^2 sum B.B, B its mean gradients), c^2 = M/density",
            remedy: "Beyond it the mesh blows up; shorten the step, or take larger elements or a softer material.",
            step: 2.0 / (wave_speeds(job).0 * stiffest.sqrt()),
        }];
    }
    let (speed, cell) = (wave_speeds(job).0, job.grid.cell);
    let mut bounds = vec![Bound {
        cause: "waves and motion through a cell",
        formula: "cell/(c + v), c^2 = M/density, v of regions and bodies",
        remedy: "Beyond it the grid blows up; shorten the step, or take larger cells or a softer material.",
        step: step_through(cell, speed, speed_max(job)),
    }];
    if job.scheme.feels_nodes() {
        bounds.push(Bound {
            cause: "nodes with next to no mass",
            formula: "cell sqrt(2/s)/c, c^2 = (M + lambda of every other axis)/density, s = 6 (quadratic), 3.1 (cubic), 9.3 (uGIMP with two points)",
            remedy: "Beyond it points at the edge of material are thrown about; shorten the step, or take update = \"modified_last\" with transfer = \"blend\".",
            step: step_of_free_nodes(job),
        });
    }
    let of_membranes = job.membranes.iter().map(|membrane| step_of_membrane(membrane, job.grid.depth));
    if let Some(step) = of_membranes.reduce(f64::min) {
        bounds.push(Bound {
            cause: "membranes",
            formula: "2/(sqrt(w^2 + (r/2)^2) + r/2), w^2 = 4 k/m, r = 4 gamma/m, m of a segment",
            remedy: "Beyond it their vertices are thrown about; shorten the step, or take longer segments, more mass per area or a softer membrane.",
            step,
        });
    }
    if job.boundaries.iter().flatten().any(|boundary| *boundary == Boundary::Absorbing) {
        bounds.push(Bound {
            cause: "absorbing faces",
            formula: "cell/(2 c), c^2 = M/density",
            remedy: "Beyond it nodes at the face have less than its dashpots would take, and waves come back; shorten the step, or take larger cells or a softer material.",
            step: 0.5 * step_through(cell, speed, 0.0),
        });
    }
    bounds
}

/// Of a chain with all its vertices swinging against each other, s. Through nodes they swing more slowly: a sum that is shared
/// with others and taken back is no faster.
fn step_of_membrane(membrane: &Membrane, depth: f64) -> f64 {
    let mass = membrane.mass_of_segment(depth);
    oscillator_step_max(4.0 * membrane.stiffness / mass, 4.0 * membrane.damping / mass)
}

// The run

/// Blocks along each axis that cover the grid between its walls.
pub fn blocks(job: &Mpm) -> [usize; 3] {
    std::array::from_fn(|axis| match axis < job.grid.dimension {
        true => job.grid.cells[axis].div_ceil(job.cells_per_block),
        false => 1,
    })
}

/// Rows of cells that shear of a flat band, and cells beyond the distance on either side in which grains stay, where a zone has
/// begun everywhere.
const CELLS_LEFT: f64 = 2.0 + 2.0 * 1.5;

/// Height of the zone of grains around a flat band one cell thick, m; of one that has begun everywhere once all that can have turned into points.
pub fn zone_height(job: &Mpm, granular: &Granular) -> f64 {
    let cells = if granular.begins_as_grains() { CELLS_LEFT } else { 2.0 };
    (2.0 * granular.enrichment.distance + cells * job.grid.cell).min(job.grid.extent(1))
}

/// Mass of all points, kg.
pub fn mass(job: &Mpm, points: u64) -> f64 {
    if job.drawn().is_some() {
        let all = indices(job.places().map(|count| 0..count)).filter(|index| job.region_of(*index).is_some());
        return all.map(|index| job.volume_at(index)).sum::<f64>() * job.material.density;
    }
    points as f64 * job.point_volume() * job.material.density
}

/// An estimate of what all ranks together hold in memory, bytes.
pub fn memory(job: &Mpm, points: u64) -> f64 {
    BYTES_OF_POINT[space(job)] * points as f64 + BYTES_OF_NODE[space(job)] * nodes(job) + rve_bytes(job)[0]
}

/// Nodes of all tiles, with their margins.
pub fn nodes(job: &Mpm) -> f64 {
    let edge = job.cells_per_block + margins(job.scheme.shape).iter().sum::<usize>();
    let blocks: f64 = blocks(job).iter().map(|count| *count as f64).product();
    edge.pow(job.grid.dimension as u32) as f64 * blocks
}
