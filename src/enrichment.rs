//! Replacing a shear band by grains: the world's side of seed 000, section 4.

use std::path::Path;

use scree_partition::ExactSum;

use crate::body::{Body, Instant};
use crate::dem::cell::Cell;
use crate::dem::grains::Mover;
use crate::error::Error;
use crate::hybrid::motion::{MotionField, Moved};
use crate::hybrid::select::{Candidate, select};
use crate::hybrid::track::Instants;
use crate::hybrid::zone::{CellGrid, Label, Zone};
use crate::law::contact::ContactLaw;
use crate::mpm::points::{Cold, Point};
use crate::packing::{Grain, PlanarWorld};
use crate::rebuild::Parts;
use crate::reference::{Lies, Reference};
use crate::scenario::Enrichment;
use crate::space::{Linear, Plane, Space};
use crate::transfer;
use crate::world::Settings;

type Vector = <Plane as Space>::Vector;
type PlanarPoint = Point<Plane, crate::law::material::CriticalMemory<Plane>>;

/// What an enrichment did, for the log and the summary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Enriched {
    pub grains: u64,
    pub grains_rim: u64,
    pub points_removed: u64,
    pub points_rim: u64,
    /// kg, before and after.
    pub mass_before: f64,
    pub mass_after: f64,
    /// N s in x and y, before and after.
    pub momentum_before: [f64; 2],
    pub momentum_after: [f64; 2],
    /// Mean Cauchy stress (xx, yy, xy) of the points that were replaced and of the grains that replaced them, Pa.
    pub stress_points: [f64; 3],
    pub stress_grains: [f64; 3],
    /// Kinetic over elastic energy at the end of training.
    pub training_energy_ratio: f64,
    pub training_steps: u64,
}

/// The cells of the world's domain.
pub fn cell_grid<C: ContactLaw<Plane>>(world: &PlanarWorld<C>) -> CellGrid {
    let layout = &world.layout;
    CellGrid {
        counts: [layout.cells[0], layout.cells[1]],
        cell: layout.cell,
        lower: [layout.corner[0], layout.corner[1]],
        periodic: layout.periodic[0],
    }
}

/// Displacement of a point since the start, across periods, m.
fn displacement(position: &Vector, cold: &Cold<Plane>, cell: &Cell<Plane>) -> Vector {
    *position - cold.origin + cell.shift(cold.image)
}

/// Takes the tracks of all points at their instants; `instants` says which steps these are.
pub fn track<C: ContactLaw<Plane>>(world: &mut PlanarWorld<C>, instants: &mut Instants) {
    if instants.every == 0 || !world.is_due(instants.every) {
        return;
    }
    if instants.full() {
        instants.thin();
        world.points.cold.iter_mut().for_each(|cold| cold.track.thin());
        if !world.is_due(instants.every) {
            return;
        }
    }
    let slot = instants.times.len();
    instants.times.push(world.time());
    let cell = world.cell;
    for (hot, cold) in world.points.hot.iter().zip(&mut world.points.cold) {
        cold.track.displacements[slot] = displacement(&hot.position, cold, &cell);
    }
}

/// Cells around its rim within which a zone looks at points: training follows those whose motion grains of the zone take part in.
const MARGIN: usize = 6;

/// Replaces the points around the flagged nodes by trained grains of the packing in `packing_file`, which `lies` in the specimen;
/// `depth` is that of the plane, m.
pub fn enrich<C: ContactLaw<Plane>>(
    world: &mut PlanarWorld<C>,
    (settings, depth): (&Enrichment, f64),
    flagged: &[u64],
    instants: &Instants,
    (packing_file, lies): (&Path, Lies<'_>),
) -> Result<Enriched, Error> {
    let zone = Zone::around(flagged, cell_grid(world), settings);
    let near = zone.within(MARGIN);
    let is_near = |place: &Vector| zone.grid.at(place[0], place[1]).is_some_and(|cell| near[cell]);
    let points = world.points.rows().filter(|point| is_near(&point.hot.position)).collect();
    let mut points = transfer::gather_everywhere(world.transport, points)?;
    points.sort_unstable_by_key(|point| point.cold.id);
    let label = |point: &PlanarPoint| zone.at(point.hot.position[0], point.hot.position[1]);
    let mass_of = |wanted: Label| -> f64 {
        points.iter().filter(|point| label(point) == wanted).map(|point| point.hot.mass).sum()
    };
    let (core, rim) = (mass_of(Label::Grains), mass_of(Label::Rim));
    if core == 0.0 || rim == 0.0 {
        return Err(Error::Run(
            "the zone around the shear band has no core or no rim; `enrichment.distance` must exceed a cell, and the band must leave continuum beside it".into(),
        ));
    }

    let motion = Motion::of(world, &points, instants, settings.training);
    let now = motion.times.len() - 1;
    let comes_near = |origin: &Vector| motion.at(now, origin).is_some_and(|way| is_near(&(*origin + way)));
    let packing = Reference::read(world, packing_file, (lies, zone.middle()), comes_near)?;
    let chosen = choose::<C>(settings, &zone, &motion, &packing.grains, core, rim)?;
    let border = border(&zone.grid, &points, &chosen);
    let before = world.ledger()?;
    let before_of_all = world.holdings()?.motion;
    let mut enriched = Enriched {
        mass_before: before.mass,
        momentum_before: [before.momentum[0], before.momentum[1]],
        stress_points: mean_stress(points.iter().filter(|point| label(point) == Label::Grains)),
        grains_rim: chosen.rim.len() as u64,
        ..Enriched::default()
    };
    let held = Holders { rim: &chosen.rim, border: &border, lies, seats: &packing.seats };
    let mut grains = train(world, (settings, depth), &motion, chosen.grains, &held, &mut enriched)?;
    for grain in &mut grains {
        grain.cold.mover = Mover::Free;
        grain.cold.script = Vector::zero();
        let in_rim = chosen.rim.binary_search(&grain.cold.id.0).is_ok();
        grain.hot.weight = if in_rim { settings.weight } else { 1.0 };
        grain.hot.spin = <Plane as Space>::Spin::zero();
        grain.hot.velocity = motion.velocity(&grain.cold.origin);
    }

    let mut kept = Vec::with_capacity(world.points.len());
    let mut lost = ExactSum::<4>::new();
    for mut point in world.points.rows() {
        let freed = match label(&point) {
            Label::Continuum => 0.0,
            Label::Grains => point.hot.weight,
            Label::Rim => point.hot.weight - chosen.point_weight,
        };
        lost.add(0, freed * point.hot.mass);
        lost.add(1, freed * point.hot.mass * point.hot.velocity[0]);
        lost.add(2, freed * point.hot.mass * point.hot.velocity[1]);
        match label(&point) {
            Label::Continuum => kept.push(point),
            Label::Grains => lost.add(3, 1.0),
            Label::Rim => {
                point.hot.weight = chosen.point_weight;
                kept.push(point);
            }
        }
    }
    let [_, lost_x, lost_y, removed] = world.reduce(lost)?;
    correct_momentum(world, &mut grains, [lost_x, lost_y])?;
    enriched.points_removed = removed as u64;
    // Until now nobody asked how far bodies had come.
    world.be_home();
    world.replace(grains, kept)?;

    let after = world.ledger()?;
    enriched.mass_after = after.mass;
    enriched.momentum_after = [after.momentum[0], after.momentum[1]];
    enriched.grains = world.grains_total;
    let motion = before_of_all.max(world.holdings()?.motion);
    check_ledger(world, &enriched, motion)?;
    enriched.points_rim = points.iter().filter(|point| label(point) == Label::Rim).count() as u64;
    Ok(enriched)
}

/// Mass and momentum of the whole world must be what they were, to round-off.
fn check_ledger<C: ContactLaw<Plane>>(world: &PlanarWorld<C>, enriched: &Enriched, motion: f64) -> Result<(), Error> {
    const ROUND_OFF: f64 = 1e-10;
    let mass = (enriched.mass_after - enriched.mass_before).abs();
    // Momentum is measured against that of everything that moves, whichever way.
    let momentum =
        (0..2).map(|axis| (enriched.momentum_after[axis] - enriched.momentum_before[axis]).abs()).fold(0.0, f64::max);
    if mass <= ROUND_OFF * enriched.mass_before && momentum <= ROUND_OFF * motion {
        return Ok(());
    }
    Err(Error::Run(format!(
        "step {}: enrichment changed the mass from {:e} to {:e} kg or the momentum from {:?} to {:?} N s, which must not happen: please report this",
        world.step, enriched.mass_before, enriched.mass_after, enriched.momentum_before, enriched.momentum_after
    )))
}

/// One rigid correction gives the grains exactly the momentum that the points gave up.
fn correct_momentum<C: ContactLaw<Plane>>(
    world: &PlanarWorld<C>,
    grains: &mut [Grain<C>],
    wanted: [f64; 2],
) -> Result<(), Error> {
    let mut sums = ExactSum::<3>::new();
    for grain in grains.iter() {
        let mass = grain.hot.weight * grain.hot.mass;
        sums.add(0, mass);
        sums.add(1, mass * grain.hot.velocity[0]);
        sums.add(2, mass * grain.hot.velocity[1]);
    }
    let [mass, x, y] = world.reduce(sums)?;
    let correction = Vector::new((wanted[0] - x) / mass, (wanted[1] - y) / mass);
    for grain in grains {
        grain.hot.velocity += correction;
    }
    Ok(())
}

/// Volume mean of the Cauchy stress, Pa.
fn mean_stress<'a>(points: impl Iterator<Item = &'a PlanarPoint>) -> [f64; 3] {
    let (mut sum, mut volume) = ([0.0; 3], 0.0);
    for point in points {
        // tau V0 = sigma V
        for (sum, component) in sum.iter_mut().zip(point.hot.stress.0) {
            *sum += component * point.hot.volume;
        }
        volume += point.hot.volume * point.hot.volume_ratio();
    }
    sum.map(|sum| sum / volume)
}

/// The continuum's motion since the start, as training repeats it: displacements at rising times, and velocity now.
struct Motion {
    field: MotionField,
    /// Seconds, rising, the first being zero.
    times: Vec<f64>,
}

impl Motion {
    /// `points` in the order of their ids; `share` of the motion is kept.
    fn of<C: ContactLaw<Plane>>(
        world: &PlanarWorld<C>,
        points: &[PlanarPoint],
        instants: &Instants,
        share: f64,
    ) -> Self {
        let moved = |point: &PlanarPoint| {
            let mut path = vec![Vector::zero()];
            path.extend(&point.cold.track.displacements[..instants.times.len()]);
            path.push(displacement(&point.hot.position, &point.cold, &world.cell));
            let mut path: Vec<[f64; 2]> = path.iter().map(|moved| [share * moved[0], share * moved[1]]).collect();
            path.push([point.hot.velocity[0], point.hot.velocity[1]]);
            Moved { origin: [point.cold.origin[0], point.cold.origin[1]], mass: point.hot.mass, displacements: path }
        };
        let moved: Vec<Moved> = points.iter().map(moved).collect();
        let mut times = vec![0.0];
        times.extend(&instants.times);
        times.push(world.time());
        Self { field: MotionField::new(cell_grid(world), &moved), times }
    }

    /// Displacement at the i-th time; none where there was no material.
    fn at(&self, time: usize, origin: &Vector) -> Option<Vector> {
        self.field.at(time, [origin[0], origin[1]]).map(|[x, y]| Vector::new(x, y))
    }

    /// The same; zero where there was no material.
    fn displacement(&self, time: usize, origin: &Vector) -> Vector {
        self.at(time, origin).unwrap_or_else(Vector::zero)
    }

    fn velocity(&self, origin: &Vector) -> Vector {
        self.displacement(self.times.len(), origin)
    }
}

struct Chosen<C: ContactLaw<Plane>> {
    grains: Vec<Grain<C>>,
    /// Ids of rim grains, rising.
    rim: Vec<u64>,
    point_weight: f64,
}

/// Grains of the packing that the continuum's motion has brought into the zone.
fn choose<C: ContactLaw<Plane>>(
    settings: &Enrichment,
    zone: &Zone,
    motion: &Motion,
    packing: &[Grain<C>],
    core: f64,
    rim_mass: f64,
) -> Result<Chosen<C>, Error> {
    let now = motion.times.len() - 1;
    let reach = settings.distance + 1.5 * zone.grid.cell;
    let mut candidates = Vec::new();
    for (row, grain) in packing.iter().enumerate() {
        let Some(way) = motion.at(now, &grain.cold.origin) else { continue };
        let place = grain.cold.origin + way;
        let place = [place[0], place[1]];
        if zone.distance(place) > reach && zone.at(place[0], place[1]) == Label::Continuum {
            continue;
        }
        if grain.cold.mover != Mover::Free {
            return Err(Error::Run(
                "the zone around the shear band reaches a plate, or the end of a packing that is not as high as the specimen, and grains of a zone cannot touch these yet; lower `enrichment.distance`, move the weak region away from the plates, or raise `packing.height`".into(),
            ));
        }
        candidates.push(Candidate { row, id: grain.cold.id.0, mass: grain.hot.mass, place });
    }
    let selection = select(zone, &candidates, core, rim_mass, settings.weight);
    let mut rim: Vec<u64> = Vec::new();
    let mut grains = Vec::with_capacity(selection.chosen.len());
    for (row, in_rim) in selection.chosen {
        grains.push(packing[row].clone());
        if in_rim {
            rim.push(packing[row].cold.id.0);
        }
    }
    rim.sort_unstable();
    let heaviest = grains.iter().map(|grain| grain.hot.mass).fold(0.0, f64::max);
    let off = (selection.point_weight - (1.0 - settings.weight)) * rim_mass;
    if off.abs() > heaviest {
        return Err(Error::Run(format!(
            "the grains of the packing cannot replace the points of the zone: masses differ by {off:e} kg, a grain weighs {heaviest:e} kg; the fraction of the material at the start (continuum.fraction_start of planar shear, material.fraction on a grid) must be near the packing's own, and the zone must lie within the packing (packing.height)"
        )));
    }
    if grains.is_empty() || rim.is_empty() {
        return Err(Error::Run(
            "the packing has no grains for the zone around the shear band; its height or width differ from the specimen's".into(),
        ));
    }
    Ok(Chosen { grains, rim, point_weight: selection.point_weight })
}

/// Ids, rising, of the grains within two cells of where the material ends.
fn border<C: ContactLaw<Plane>>(grid: &CellGrid, points: &[PlanarPoint], chosen: &Chosen<C>) -> Vec<u64> {
    let mut filled = vec![false; grid.counts[0] * grid.counts[1]];
    let cell_of = |origin: &Vector| grid.at(origin[0], origin[1]);
    points.iter().filter_map(|point| cell_of(&point.cold.origin)).for_each(|cell| filled[cell] = true);
    let is_inner = |cell: usize| filled[cell] && grid.beside(cell).filter(|beside| filled[*beside]).count() == 4;
    let inner: Vec<bool> = (0..filled.len()).map(is_inner).collect();
    let is_deep = |cell: usize| inner[cell] && grid.beside(cell).all(|beside| inner[beside]);
    let at_border = |grain: &&Grain<C>| !cell_of(&grain.cold.origin).is_some_and(is_deep);
    let mut border: Vec<u64> = chosen.grains.iter().filter(at_border).map(|grain| grain.cold.id.0).collect();
    border.sort_unstable();
    border
}

/// Kinematic training (seed 000, 4.1.1): a world of the chosen grains alone, its rim moved along the continuum's path, everything
/// inside free. Where the material ends nothing moves with it: bodies come along as they have come, and what else held grains of the
/// packing there, a membrane, holds on with the force that it had. Rows of this rank's blocks come back.
fn train<C: ContactLaw<Plane>>(
    world: &mut PlanarWorld<C>,
    (training, depth): (&Enrichment, f64),
    motion: &Motion,
    mut grains: Vec<Grain<C>>,
    held: &Holders<'_>,
    enriched: &mut Enriched,
) -> Result<Vec<Grain<C>>, Error> {
    for grain in &mut grains {
        if held.rim.binary_search(&grain.cold.id.0).is_ok() {
            grain.cold.mover = Mover::Script;
        }
    }
    let grains = if world.transport.rank() == 0 { grains } else { Vec::new() };
    let settings = Settings { grain_steps: 1, loads: Vec::new(), first_kick: 0.5, ..world.settings.clone() };
    let touched = touched_bodies(world);
    let share = training.training;
    let seat = |number: usize| held.seats.get(number).copied().unwrap_or_else(Vector::zero);
    let at_start = |number: &usize| {
        let body = &world.bodies[*number];
        let rest = Linear::zero();
        let displacement = seat(*number);
        Body {
            path: Vec::new(),
            servo: None,
            grip: None,
            velocity: rest,
            spin: Linear::zero(),
            displacement,
            ..body.clone()
        }
    };
    // From where the packing's bodies stood to where those of the run do.
    let way = |number: usize, [from, to]: [f64; 2]| {
        let (body, now) = (&world.bodies[number], world.time());
        let along = way_of(body, [from, to], now);
        let rest = body.displacement - way_of(body, [0.0, now], now) - seat(number);
        (along + rest * ((to - from) / now)) * share
    };
    let parts = Parts::fresh(grains, Vec::new(), touched.iter().map(at_start).collect(), world.cell);
    let mut apart = PlanarWorld::<C>::new(settings, world.layout.clone(), world.transport, 0, parts)?;
    apart.walls.laws = touched.iter().filter_map(|number| world.walls.laws.get(*number).copied()).collect();
    hold_open(&mut apart, held);

    let dt = apart.settings.dt;
    for leg in 0..motion.times.len() - 1 {
        let ends = [motion.times[leg], motion.times[leg + 1]];
        let duration = (ends[1] - ends[0]) / training.training_speed;
        let steps = (duration / dt).round().max(1.0);
        follow(&mut apart, |origin| {
            let way = motion.displacement(leg + 1, origin) - motion.displacement(leg, origin);
            way * (1.0 / (steps * dt))
        });
        for (body, number) in apart.bodies.iter_mut().zip(&touched) {
            let velocity = way(*number, ends) * (1.0 / (steps * dt));
            body.path = vec![Instant { time: 0.0, velocity, spin: Linear::zero() }];
        }
        run_steps(&mut apart, steps as u64)?;
    }
    apart.bodies.iter_mut().for_each(|body| body.path.clear());
    let rest = (training.training_rest * apart.step as f64).round();
    follow(&mut apart, |_| Vector::zero());
    run_steps(&mut apart, rest as u64)?;
    release(&mut apart, held.rim)?;
    let energies = apart.energies()?;
    enriched.training_energy_ratio = energies.kinetic_grains / energies.elastic_grains;
    enriched.training_steps = apart.step;
    enriched.stress_grains = grain_stress(&mut apart, depth)?;
    apart.rebuild()?;
    world.balance.learn(&apart.balance);
    Ok(apart.rows().0)
}

/// Bodies that grains touch, by their numbers.
fn touched_bodies<C: ContactLaw<Plane>>(world: &PlanarWorld<C>) -> Vec<usize> {
    (0..world.bodies.len()).filter(|number| world.bodies[*number].is_touched()).collect()
}

/// How far a body has come between two times of a run that has lasted until `now`: along its path, or where a servo has moved it
/// evenly all the while.
fn way_of(body: &Body<Plane>, [from, to]: [f64; 2], now: f64) -> Vector {
    match body.servo {
        None => body.way_between(from, to),
        Some(_) => body.displacement * ((to - from) / now),
    }
}

/// Who holds grains that are trained, by their ids, rising: the continuum those of the rim, and whatever does so those where the
/// material ends.
struct Holders<'a> {
    rim: &'a [u64],
    border: &'a [u64],
    lies: Lies<'a>,
    /// Where the packing's bodies stood, as displacements, m.
    seats: &'a [Vector],
}

/// Grains at the border are pushed from now on by what their contacts leave open as they stand. A piece that is cut there is under one
/// stress throughout: they bear as much of it as the specimen does at its start, next to nothing at a free surface.
fn hold_open<C: ContactLaw<Plane>>(apart: &mut PlanarWorld<C>, held: &Holders<'_>) {
    if held.border.is_empty() {
        return;
    }
    apart.evaluate_contacts();
    let (grains, gravity) = (&mut apart.grains, apart.settings.field.gravity);
    for row in 0..grains.owned {
        let cold = &mut grains.cold[row];
        if cold.mover == Mover::Free && held.border.binary_search(&cold.id.0).is_ok() {
            cold.script = match held.lies {
                Lies::Whole | Lies::Around => -(grains.force[row] + gravity * grains.hot[row].mass),
                Lies::Tiled(start) => grains.force[row] * -start.stress_share(&cold.origin),
            };
        }
    }
    grains.settle();
}

/// Steps between two looks at grains of the rim that are let go, looks at most, and the damping of all grains in these steps, per step:
/// such that overlaps shrink by a few per cent in each.
const RELEASE_STEPS: u64 = 20;
const RELEASES_MAX: u64 = 20;
const RELEASE_DAMPING: f64 = 0.5;
/// How many times as hard as contacts among free grains in the mean one of the rim may press.
const PRESSED_MAX: f64 = 12.0;

/// Grains of the rim were moved each by itself, and overlap where the continuum strained much: they are let go against heavy damping,
/// before anything moves that could throw them, for as short a time as it takes.
fn release<C: ContactLaw<Plane>>(apart: &mut PlanarWorld<C>, rim: &[u64]) -> Result<(), Error> {
    let damping = apart.settings.field.damping;
    let mut looks = 0;
    while looks < RELEASES_MAX && is_squeezed(apart, rim)? {
        if looks == 0 {
            for cold in &mut apart.grains.cold {
                if cold.mover == Mover::Script {
                    (cold.mover, cold.script) = (Mover::Free, Vector::zero());
                }
            }
            apart.settings.field.damping.mass = RELEASE_DAMPING / apart.settings.dt;
            apart.rebuild()?;
        }
        run_steps(apart, RELEASE_STEPS)?;
        looks += 1;
    }
    apart.settings.field.damping = damping;
    Ok(())
}

/// Whether a grain of the rim presses on another, or on a body, far harder than free ones do on each other. Collective.
fn is_squeezed<C: ContactLaw<Plane>>(apart: &mut PlanarWorld<C>, rim: &[u64]) -> Result<bool, Error> {
    apart.refresh_ghosts();
    let in_rim = |id: u64| rim.binary_search(&id).is_ok();
    let (grains, law) = (&apart.grains, &apart.settings.contact);
    let on_bodies = apart.walls.bearings(law, grains, (&apart.bodies, &apart.cell));
    let on_grains = (0..grains.owned).flat_map(|row| apart.contacts.bearings(law, grains, row));
    let (mut of_free, mut hardest) = (ExactSum::<2>::new(), [0.0f64]);
    for bearing in on_grains.chain(on_bodies) {
        let force = bearing.force.norm();
        if in_rim(grains.cold[bearing.row as usize].id.0) || in_rim(bearing.partner.0) {
            hardest[0] = hardest[0].max(force);
        } else {
            of_free.add(0, 1.0);
            of_free.add(1, force);
        }
    }
    apart.transport.max(&mut hardest);
    let [count, sum] = apart.reduce(of_free)?;
    Ok(hardest[0] * count > PRESSED_MAX * sum)
}

fn follow<C: ContactLaw<Plane>>(training: &mut PlanarWorld<C>, velocity: impl Fn(&Vector) -> Vector) {
    for cold in &mut training.grains.cold {
        if cold.mover == Mover::Script {
            cold.script = velocity(&cold.origin);
        }
    }
}

fn run_steps<C: ContactLaw<Plane>>(world: &mut PlanarWorld<C>, steps: u64) -> Result<(), Error> {
    for _ in 0..steps {
        world.advance()?;
    }
    Ok(())
}

/// Packing fraction by which a grain's share of space follows from its own volume where no better is known.
const FRACTION_NOMINAL: f64 = 0.84;

/// Mean Love-Weber stress of the free grains, Pa: xx, yy, xy.
pub fn grain_stress<C: ContactLaw<Plane>>(world: &mut PlanarWorld<C>, depth: f64) -> Result<[f64; 3], Error> {
    world.refresh_ghosts();
    let mut sums = ExactSum::<4>::new();
    for (row, (hot, cold)) in world.grains.hot[..world.grains.owned].iter().zip(&world.grains.cold).enumerate() {
        if cold.mover == Mover::Free {
            let moment = world.contacts.moment(&world.settings.contact, &world.grains, row);
            sums.add(0, moment[0]);
            sums.add(1, moment[3]);
            sums.add(2, 0.5 * (moment[1] + moment[2]));
            sums.add(3, Plane::grain_volume(hot.radius, depth));
        }
    }
    let [xx, yy, xy, volume] = world.reduce(sums)?;
    let space = volume / FRACTION_NOMINAL;
    Ok([xx / space, yy / space, xy / space])
}
