//! What every grain of a file is held to, whatever the format.

use super::lammps::Bounds;
use super::{Entry, Source};
use crate::base::error::Error;
use crate::base::math::PI;
use crate::base::space::{Linear, Plane, Space};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Grains};
use crate::dem::neighbours::Neighbours;
use crate::dem::walls;
use crate::job::figures::{self, Diameters};
use crate::job::stable::{self, governing};
use crate::job::{Assembly, BYPASS, Scenario, digits_below};
use crate::prepare::grain_world;
use crate::prepare::sheared::layout_for;

/// Deepest overlap that a start may have, as a share of the smaller radius.
const OVERLAP_MAX: f64 = 0.5;
/// How exactly the box of a file must be the job's, as a share of its length, and a mass.
const BOX_TOLERANCE: f64 = 1e-9;
const MASS_TOLERANCE: f64 = 1e-6;
/// Length of a periodic axis in contact reaches: a grain must not touch two images of another.
const PERIOD_IN_REACHES: f64 = 2.0;
/// Times that the mean diameter a job states may be off.
const MEAN_RATIO_MAX: f64 = 1.5;
/// Grains of one size are a class from a ring around one of them on, and where there are no more classes than these.
const CLASS_MIN: usize = 7;
const CLASSES_MAX: usize = 10;

const AXES: [&str; 3] = ["x", "y", "z"];

pub fn refuse_radius<S: Space>(source: &Source, entry: &Entry<S>) -> Result<(), Error> {
    match entry.radius > 0.0 {
        true => Ok(()),
        false => Err(source.bad(entry.line, &format!("radius = {} m must be positive", entry.radius))),
    }
}

/// What outruns its own radius or turns by more than a radian in a step passes through others unseen.
pub fn refuse_speed<S: Space>(source: &Source, entry: &Entry<S>, step: f64) -> Result<(), Error> {
    let (speed, spin) = (entry.velocity.norm(), entry.spin.norm());
    let refused = |what: &str| {
        let what = format!("this grain {what} in one step of time.step = {step} s; slow it down, or shorten the step");
        Err(source.bad(entry.line, &what))
    };
    match (speed * step <= entry.radius, spin * step <= 1.0) {
        (false, _) => refused(&format!("moves {:.2e} m, further than its radius,", speed * step)),
        (_, false) => refused(&format!("turns by {:.2e} rad, more than one,", spin * step)),
        _ => Ok(()),
    }
}

/// Ids in their order.
pub fn refuse_repeated_ids<S: Space>(source: &Source, entries: &[Entry<S>]) -> Result<(), Error> {
    match entries.windows(2).find(|pair| pair[0].id == pair[1].id) {
        Some([first, second]) => Err(source
            .bad(second.line, &format!("id {} stands in line {} already; ids must be unique", first.id, first.line))),
        _ => Ok(()),
    }
}

/// The box of a LAMMPS file against the cell, along some axes.
pub fn refuse_other_box<S: Space>(
    source: &Source,
    bounds: &Bounds,
    cell: &Cell<S>,
    axes: &[usize],
) -> Result<(), Error> {
    for &axis in axes {
        let name = AXES[axis];
        let lower = cell.corner[axis];
        let length = cell.edges[axis * S::DIMENSION + axis];
        let upper = lower + length;
        let Some(([found_lower, found_upper], line)) = bounds.ends[axis] else {
            return Err(source.bad(1, &format!("the head has no line `{name}lo {name}hi`")));
        };
        let apart = (found_lower - lower).abs().max((found_upper - upper).abs());
        if apart > BOX_TOLERANCE * length {
            return Err(source.bad(
                line,
                &format!(
                    "the box reaches from {found_lower} to {found_upper} m along {name}, and the job's cell from {lower} to {upper} m; make the two the same"
                ),
            ));
        }
    }
    Ok(())
}

/// A box that leans, where the domain cannot.
pub fn refuse_tilts(source: &Source, bounds: &Bounds) -> Result<(), Error> {
    match bounds.tilts {
        Some((tilts, line)) if tilts != [0.0; 3] => Err(source.bad(
            line,
            &format!("the box is tilted by {tilts:?} m (xy xz yz), and this job's domain is upright; take a file of an upright box"),
        )),
        _ => Ok(()),
    }
}

/// The job's cell with edges that lean as the box of a LAMMPS file does.
pub fn tilted<S: Space>(source: &Source, bounds: &Bounds, cell: &Cell<S>) -> Result<Cell<S>, Error> {
    let mut tilted = *cell;
    let Some((tilts, line)) = bounds.tilts else { return Ok(tilted) };
    for ((along, edge), tilt) in [(0, 1), (0, 2), (1, 2)].into_iter().zip(tilts) {
        if tilt == 0.0 {
            continue;
        }
        if edge >= S::DIMENSION || !cell.periodic[along] || !cell.periodic[edge] {
            return Err(source.bad(
                line,
                &format!(
                    "the box is tilted by {tilts:?} m (xy xz yz), and a cell leans only along axes that are both periodic; {} and {} are not",
                    AXES[along], AXES[edge]
                ),
            ));
        }
        tilted.edges[edge * S::DIMENSION + along] = tilt;
    }
    let mut leaning = *cell;
    leaning.take_motion_of(&tilted);
    Ok(leaning)
}

/// Masses of a LAMMPS file against the job's. LAMMPS stores rho = m/(4/3 pi r^3) also of discs (atom style sphere); files
/// by other hands have rho = m/(pi r^2) there, as `set density/disc` takes it.
pub fn refuse_other_masses<S: Space>(
    source: &Source,
    entries: &[Entry<S>],
    wanted: impl Fn(f64) -> f64,
) -> Result<(), Error> {
    let sphere = |entry: &Entry<S>, density: f64| density * 4.0 / 3.0 * PI * entry.radius * entry.radius * entry.radius;
    let disc = |entry: &Entry<S>, density: f64| density * PI * entry.radius * entry.radius;
    let agrees = |entry: &Entry<S>, mass: f64| (mass / wanted(entry.radius) - 1.0).abs() <= MASS_TOLERANCE;
    let dense = || entries.iter().filter_map(|entry| entry.density.map(|density| (entry, density)));
    let Some((other, density)) = dense().find(|(entry, density)| !agrees(entry, sphere(entry, *density))) else {
        return Ok(());
    };
    if S::DIMENSION == 2 && dense().all(|(entry, density)| agrees(entry, disc(entry, density))) {
        return Ok(());
    }
    let masses = match S::DIMENSION {
        2 => format!(
            "a disc of {:.6e} kg as LAMMPS stores it, or of {:.6e} kg as kg/m2",
            sphere(other, density),
            disc(other, density)
        ),
        _ => format!("a sphere of {:.6e} kg", sphere(other, density)),
    };
    let depth = if S::DIMENSION == 2 { " and the depth" } else { "" };
    Err(source.bad(
        other.line,
        &format!(
            "density = {density} makes {masses}, and the job's grains.density{depth} one of {:.6e} kg; make the two the same",
            wanted(other.radius)
        ),
    ))
}

/// Deep overlaps of rows in the order of `entries`.
pub fn refuse_overlaps<S: Space>(
    source: &Source,
    entries: &[Entry<S>],
    rows: &[GrainRow<S>],
    cell: &Cell<S>,
) -> Result<(), Error> {
    let all = Grains::<S> {
        hot: rows.iter().map(|grain| grain.hot).collect(),
        cold: rows.iter().map(|grain| grain.cold).collect(),
        owned: rows.len(),
        ..Grains::default()
    };
    let mut neighbours = Neighbours::default();
    neighbours.build(&all, cell, 0.0);
    for (_, pair) in neighbours.real_pairs() {
        let (a, b) = (&all.hot[pair.a as usize], &all.hot[pair.b() as usize]);
        let separation = a.position - b.position + cell.shift(pair.image().image());
        let overlap = a.radius + b.radius - separation.norm();
        let share = overlap / a.radius.min(b.radius);
        if share > OVERLAP_MAX {
            return Err(source.bad(
                entries[pair.b() as usize].line,
                &format!(
                    "this grain overlaps the one in line {} by {:.0} % of the smaller radius; at most {:.0} % can be started from",
                    entries[pair.a as usize].line,
                    100.0 * share,
                    100.0 * OVERLAP_MAX
                ),
            ));
        }
    }
    Ok(())
}

/// Sizes of a file's grains, whatever the job says of them.
struct Sizes<'e, S: Space> {
    smallest: &'e Entry<S>,
    largest: &'e Entry<S>,
    /// Mean diameter, m.
    mean: f64,
    /// Diameters that so many grains share that they can gather, m.
    classes: Vec<f64>,
}

impl<'e, S: Space> Sizes<'e, S> {
    /// None of no grains.
    fn of(entries: &'e [Entry<S>]) -> Option<Self> {
        let mut by_radius: Vec<&Entry<S>> = entries.iter().collect();
        by_radius.sort_by(|a, b| a.radius.total_cmp(&b.radius));
        let mean = 2.0 * by_radius.iter().map(|entry| entry.radius).sum::<f64>() / entries.len() as f64;
        let class = CLASS_MIN.max(entries.len() / CLASSES_MAX);
        let alike = by_radius.chunk_by(|a, b| a.radius == b.radius).filter(|alike| alike.len() >= class);
        let classes = alike.map(|alike| 2.0 * alike[0].radius).collect();
        Some(Self { smallest: by_radius.first()?, largest: by_radius.last()?, mean, classes })
    }

    /// Skin, blocks and dashpots given by a restitution follow from the stated mean.
    fn refuse_other_mean(&self, source: &Source, stated: f64) -> Result<(), Error> {
        if (stated / self.mean).max(self.mean / stated) <= MEAN_RATIO_MAX {
            return Ok(());
        }
        Err(source.bad(
            self.largest.line,
            &format!(
                "the grains of this file have a mean diameter of {:.4e} m, and the job's grains.diameter_mean = {stated} m; write theirs",
                self.mean
            ),
        ))
    }

    /// As the bounds of the step need them.
    fn diameters(&self) -> Diameters {
        Diameters { smallest: 2.0 * self.smallest.radius, mean: self.mean, classes: self.classes.clone() }
    }

    /// `bypass`: what else can be done where the job's kind allows it.
    fn refuse_step(&self, source: &Source, step: f64, bounds: &[stable::Bound], bypass: &str) -> Result<(), Error> {
        let bound = governing(bounds);
        match step <= bound.step {
            true => Ok(()),
            false => Err(source.bad(
                self.smallest.line,
                &format!(
                    "a grain with radius = {} m is unstable with time.step = {step} s: at most {} s is allowed ({}: {}). {}{bypass}",
                    self.smallest.radius,
                    digits_below(bound.step),
                    bound.cause,
                    bound.formula,
                    bound.remedy
                ),
            )),
        }
    }
}

// Between plates

pub fn refuse_heights(scenario: &Scenario, source: &Source, entries: &[Entry<Plane>]) -> Result<(), Error> {
    let [lower, upper] = layout_for(scenario, scenario.specimen.height)?.heights();
    match entries.iter().find(|entry| !(lower..=upper).contains(&entry.position[1])) {
        Some(entry) => Err(source.bad(
            entry.line,
            &format!(
                "y = {} m lies outside the domain, which reaches from {lower:.4e} to {upper:.4e} m about plates at 0 and specimen.height = {} m",
                entry.position[1], scenario.specimen.height
            ),
        )),
        None => Ok(()),
    }
}

/// Blocks must be wider than a contact reaches, and the step stable for the lightest grain.
pub fn refuse_sizes(scenario: &Scenario, source: &Source, entries: &[Entry<Plane>]) -> Result<(), Error> {
    let Some(sizes) = Sizes::of(entries) else { return Ok(()) };
    let largest = sizes.largest;
    let block = scenario.decomposition.cells_per_block as f64 * scenario.continuum.cell;
    let reach = 2.0 * largest.radius + scenario.decomposition.skin + scenario.contact.reach();
    if reach > block {
        return Err(source.bad(
            largest.line,
            &format!(
                "radius = {} m reaches {reach} m with its neighbours, but a block is {block} m wide; take larger continuum.cell or decomposition.cells_per_block",
                largest.radius
            ),
        ));
    }
    let bounds = figures::bounds_with(&scenario.grains_of_specimen(), &sizes.diameters());
    sizes.refuse_step(source, scenario.time.step, &bounds, "")?;
    sizes.refuse_other_mean(source, scenario.grains.diameter_mean)
}

// In a cell

/// What bounds the step of these grains; None of no grains.
pub fn bounds_in_cell<S: Space>(job: &Assembly, entries: &[Entry<S>]) -> Option<Vec<stable::Bound>> {
    Some(figures::bounds_with(job, &Sizes::of(entries)?.diameters()))
}

pub fn refuse_outside<S: Space>(source: &Source, cell: &Cell<S>, entry: &Entry<S>) -> Result<(), Error> {
    let fraction = cell.fraction(&entry.position);
    for (axis, name) in AXES.iter().enumerate().take(S::DIMENSION) {
        let length = cell.edges[axis * S::DIMENSION + axis];
        let lower = cell.corner[axis];
        let (upper, place) = (lower + length, entry.position[axis]);
        // Of an upright cell to the bit; along a leaning edge a place is as exact as the share of it.
        let leans = (0..S::DIMENSION).any(|edge| edge != axis && cell.edges[edge * S::DIMENSION + axis] != 0.0);
        let inside = match leans {
            true => (-BOX_TOLERANCE..=1.0 + BOX_TOLERANCE).contains(&fraction[axis]),
            false => (lower..=upper).contains(&place),
        };
        if !inside {
            return Err(source.bad(
                entry.line,
                &format!(
                    "{name} = {place} m lies outside the cell, which reaches from cell.lower = {lower} to cell.upper = {upper} m{}; the grains of a cell that leans are read with its tilts from a LAMMPS data file",
                    if leans { " and leans" } else { "" }
                ),
            ));
        }
    }
    Ok(())
}

/// Blocks and periods must be wider than contacts reach, and the step stable for the lightest grain.
pub fn refuse_sizes_of_assembly<S: Space>(job: &Assembly, source: &Source, entries: &[Entry<S>]) -> Result<(), Error> {
    let Some(sizes) = Sizes::of(entries) else { return Ok(()) };
    let largest = sizes.largest;
    let reach = 2.0 * largest.radius + figures::margin(job);
    let radius = largest.radius;
    if reach > job.block {
        return Err(source.bad(
            largest.line,
            &format!(
                "radius = {radius} m reaches {reach} m with its neighbours, but a block is {} m wide; take a larger decomposition.block",
                job.block
            ),
        ));
    }
    for axis in (0..S::DIMENSION).filter(|axis| job.cell.periodic[*axis]) {
        let length = job.cell.upper[axis] - job.cell.lower[axis];
        if PERIOD_IN_REACHES * reach > length {
            return Err(source.bad(
                largest.line,
                &format!(
                    "radius = {radius} m reaches {reach} m with its neighbours, and the period of {length} m along {} is shorter than two of that; take a larger cell",
                    AXES[axis]
                ),
            ));
        }
    }
    if !job.allow_unstable {
        sizes.refuse_step(source, job.step, &figures::bounds_with(job, &sizes.diameters()), BYPASS)?;
    }
    sizes.refuse_other_mean(source, job.matter.diameter_mean)
}

pub fn refuse_overlaps_with_bodies<S: Space>(
    job: &Assembly,
    source: &Source,
    entries: &[Entry<S>],
) -> Result<(), Error> {
    let cell = grain_world::cell_of::<S>(job);
    for body in &job.bodies {
        let made = grain_world::body_of::<S>(body);
        for entry in entries {
            let Some(nearest) = walls::nearest(&made, &cell, &entry.position) else { continue };
            let share = 1.0 - nearest.distance / entry.radius;
            if share > OVERLAP_MAX {
                return Err(source.bad(
                    entry.line,
                    &format!(
                        "this grain overlaps body `{}` by {:.0} % of its radius; at most {:.0} % can be started from",
                        body.name,
                        100.0 * share,
                        100.0 * OVERLAP_MAX
                    ),
                ));
            }
        }
    }
    Ok(())
}
