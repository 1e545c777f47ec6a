//! Replacing a shear band by grains: the world's side of Chen et al. (2021), section 4.

use std::collections::BTreeSet;
use std::path::Path;

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Plane, Space};
use crate::couple::zone::{CellGrid, Enrichment, Label, Zone};
use crate::dem::cell::Image;
use crate::dem::grains::{Hot, Mover};
use crate::domain::transfer;
use crate::domain::world::World;
use crate::mpm::load::loads_in;
use crate::mpm::points::{Hot as PointHot, Point};
use crate::mpm::track::Instants;
use crate::prepare::reference::{Lies, Reference};
use crate::prepare::sheared::{Grain, PlanarWorld};

mod account;
mod choose;
mod dissolution;
mod keep;
mod leaving;
mod motion;
mod patches;
mod points;
mod residents;
mod training;
mod zones;

pub use account::BeforeAndAfter;
pub use dissolution::{Dissolved, dissolve};
pub use motion::track;
pub use patches::strength_mobilised;
pub use zones::{Wanted, around_band, around_shear};

use account::Account;
use choose::{Carried, Sight, Stands, border, choose};
use motion::{Motion, place_kept};
use residents::Residents;
use training::{Confinement, Trained, train};

type Vector = <Plane as Space>::Vector;
type PlanarHot = PointHot<Plane>;
type PlanarPoint = Point<Plane>;

/// What an enrichment did, for the log and the summary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Enriched {
    /// That came in, those of the rim among them.
    pub grains: u64,
    /// Of these, those that share their place with points.
    pub grains_rim: u64,
    /// All points of the core.
    pub points_removed: u64,
    /// Points that stay with a lower weight.
    pub points_rim: u64,
    /// Of the whole world.
    pub kept: BeforeAndAfter,
    /// Mean Cauchy stress (xx, yy, xy) of the points that were replaced and of the grains that replaced them, Pa.
    pub stress_points: [f64; 3],
    /// Pa, tension positive, in the same order; at the end of training.
    pub stress_grains: [f64; 3],
    /// Kinetic over elastic energy at the end of training.
    pub training_energy_ratio: f64,
    /// Steps of grains, rest and release at the end among them.
    pub training_steps: u64,
}

impl Enriched {
    /// Whether trained grains bear no more than half as much again as the points whose places they take, where these are pressed.
    fn bears_what_points_bore(&self) -> bool {
        let borne = pressure(&self.stress_points);
        borne <= 0.0 || pressure(&self.stress_grains) <= PRESSURE_BORNE * borne
    }
}

/// How many times the pressure of points grains that come back may bear: what fills room that others hold cannot give way.
const PRESSURE_BORNE: f64 = 1.5;

/// Mean of the normal stresses, positive where they press, Pa.
fn pressure([xx, yy, _]: &[f64; 3]) -> f64 {
    -0.5 * (xx + yy)
}

/// The cells of the world's domain.
pub fn cell_grid<S: Space>(world: &World<S>) -> CellGrid {
    let layout = &world.subdomain.layout;
    CellGrid {
        counts: [layout.cells[0], layout.cells[1]],
        cell: layout.cell,
        lower: [layout.corner[0], layout.corner[1]],
        periodic: layout.periodic[0],
    }
}

/// Cells around its rim within which a zone looks at points: training follows those whose motion grains of the zone take part in.
const MARGIN: usize = 6;

/// Why no zone can be there; the same on every rank, and nothing has been changed.
#[derive(Debug)]
pub struct Refusal(pub String);

/// Points that go and trained grains that take their places; nothing has been changed yet.
pub struct Plan {
    zone: Zone,
    carried: Carried,
    /// Rows of this rank's blocks.
    trained: Trained,
    enriched: Enriched,
}

impl Plan {
    /// Points of a zone give way to grains of the packing in `packing_file`, which `lies` in the specimen; `depth` is that
    /// of the plane, m. Grains that are there already stay. Collective.
    pub fn of(
        world: &mut PlanarWorld,
        (settings, depth): (&Enrichment, f64),
        Wanted { mut zone, plates }: Wanted,
        instants: &Instants,
        (packing_file, lies): (&Path, Lies<'_>),
    ) -> Result<Result<Self, Refusal>, Error> {
        if world.has_grains() {
            // Lists that are made of them and of others begin where they are.
            world.rebuild()?;
        }
        let near = zone.within(MARGIN);
        let points = points_within(world, &zone.grid, &near)?;
        // Points bear loads, and grains do not: they share the cells of those that do.
        let loaded =
            points.iter().filter(|point| loads_in(point.cold.loads).next().is_some()).map(|point| point.hot.position);
        loaded.for_each(|place| zone.share(place[0], place[1]));
        let (zone_of, points_of) = (&zone, &points);
        let of = |wanted: Label| points_of.iter().filter(move |point| becomes(zone_of, &point.hot) == wanted);
        let mass_of = |wanted: Label| of(wanted).map(|point| point.hot.weight * point.hot.mass).sum::<f64>();
        let (core, rim) = (mass_of(Label::Grains), mass_of(Label::Rim));
        let is_kept = matches!(lies, Lies::Kept(_));
        let is_older = |point: &&PlanarPoint| is_of_older_rim(zone_of, &near, &point.hot);
        let older: f64 = points.iter().filter(is_older).map(|point| point.hot.weight * point.hot.mass).sum();
        if core == 0.0 || rim == 0.0 && (older == 0.0 || !is_kept) {
            return Ok(Err(Refusal(
                "the zone around the shear band has no core or no rim; `enrichment.distance` must exceed a cell, and the band must leave continuum beside it".into(),
            )));
        }
        let motion = match is_kept {
            true => Motion::since_kept(world, &points, instants),
            false => Motion::of(world, &points, instants, settings.training),
        };
        let mut residents = Residents::of(world)?;
        let [raised, ..] = raised(world, &zone)?;
        let is_wanted = |id: GrainId, origin: &Vector| {
            !matches!(Sight::of(settings, &zone, &motion, &residents).stands(id.0, origin), Stands::Away)
        };
        let reference = Reference::read(world, packing_file, (lies, zone.middle()), is_wanted)?;
        if is_kept {
            residents.since_kept(&reference, &world.assembly.cell);
        }
        let Reference { grains: packing, seats, began } = reference;
        let sight = match is_kept {
            true => Sight::of_kept(settings, &zone, &motion, &residents),
            false => Sight::of(settings, &zone, &motion, &residents),
        };
        let of_packing = (&packing[..], lies, &plates[..]);
        let mut chosen = match choose(settings, &zone, &sight, of_packing, [core - raised, rim, older]) {
            Ok(chosen) => chosen,
            Err(refusal) => return Ok(Err(refusal)),
        };
        // Those of plates that come with the zone, and those that are kept with the grains that come back.
        let is_glued = |grain: &&Grain| is_kept && matches!(grain.cold.mover, Mover::Body(_));
        let glued = packing.iter().filter(is_glued).chain(&chosen.glued);
        let glued: Vec<Vector> = glued.map(|grain| grain.cold.origin).collect();
        drop(packing);
        let mut enriched = Enriched {
            stress_points: mean_stress(of(Label::Grains)),
            points_rim: of(Label::Rim).count() as u64,
            grains: chosen.grains.len() as u64,
            grains_rim: chosen.rim.len() as u64,
            ..Enriched::default()
        };
        let led = residents.with_those_of(&chosen, world, (&motion, is_kept));
        let from = |point: &PlanarPoint| if is_kept { place_kept(point) } else { point.cold.origin };
        let border = border(&zone.grid, points.iter().map(from), &residents, (&chosen.grains, &glued));
        let held = Confinement { led: &led, border: &border, residents: &residents, lies, seats: &seats };
        let around: BTreeSet<GrainId> = chosen.around.iter().map(|grain| grain.cold.id).collect();
        let mut all = chosen.grains;
        all.extend(chosen.beside);
        all.extend(chosen.glued.iter().cloned());
        all.extend(chosen.around);
        let mut trained = match train(world, (settings, depth), &motion, all, &held, &mut enriched) {
            Ok(trained) => trained,
            Err(Error::Run(why)) => return Ok(Err(Refusal(format!("training came to nothing: {why}")))),
            Err(other) => return Err(other),
        };
        if is_kept && !enriched.bears_what_points_bore() {
            let [grains, points] = [enriched.stress_grains, enriched.stress_points].map(|stress| pressure(&stress));
            return Ok(Err(Refusal(format!(
                "grains that come back bear {grains:.3e} Pa in the place of points that bear {points:.3e}"
            ))));
        }
        chosen.glued.sort_unstable_by_key(|grain| grain.cold.id);
        trained.seat(&chosen.glued);
        for grain in &mut trained.grains {
            let in_rim = chosen.rim.binary_search(&grain.cold.id.0).is_ok();
            grain.hot.weight = if in_rim { settings.weight } else { 1.0 };
            grain.contacts.retain(|(partner, _)| !around.contains(partner));
            let velocity = motion.velocity(&grain.cold.origin);
            enter(grain, velocity, began.get(&grain.cold.id));
        }
        Ok(Ok(Self { zone, carried: chosen.carried, trained, enriched }))
    }

    /// Puts the grains in. Collective.
    pub fn carry_out(self, world: &mut PlanarWorld) -> Result<Enriched, Error> {
        let Self { zone, carried, trained: Trained { mut grains, touched, glued }, mut enriched } = self;
        let account = Account::open(world)?;
        let near = zone.within(MARGIN);
        world.look_at_costs();
        let mut lost = ExactSum::<4>::new();
        world.continuum.points.retain(|point| {
            let label = becomes(&zone, point);
            let left = match label {
                Label::Continuum if is_of_older_rim(&zone, &near, point) => point.weight * carried.older,
                Label::Continuum => point.weight,
                Label::Grains => 0.0,
                Label::Rim => carried.rim,
            };
            let freed = point.weight - left;
            lost.add(0, freed * point.mass);
            lost.add(1, freed * point.mass * point.velocity[0]);
            lost.add(2, freed * point.mass * point.velocity[1]);
            lost.add(3, if label == Label::Grains { 1.0 } else { 0.0 });
            point.weight = left;
            label != Label::Grains
        });
        let [_, lost_x, lost_y, removed] = world.reduce(lost)?;
        let [_, raised_x, raised_y] = raised(world, &zone)?;
        correct_momentum(world, &mut grains, [lost_x - raised_x, lost_y - raised_y])?;
        enriched.points_removed = removed as u64;
        grains.extend(glued);
        grains.extend(stayed(world, &zone, touched)?);
        // Until now nobody asked how far bodies had come.
        world.be_home();
        world.replace_grains(grains)?;
        enriched.kept = account.close(world, "enrichment")?;
        Ok(enriched)
    }
}

/// Points in these cells, in the order of their ids, on every rank. Collective.
fn points_within(world: &PlanarWorld, grid: &CellGrid, cells: &[bool]) -> Result<Vec<PlanarPoint>, Error> {
    let is_near = |place: &Vector| grid.at(place[0], place[1]).is_some_and(|cell| cells[cell]);
    let points = world.continuum.points.rows().filter(|point| is_near(&point.hot.position)).collect();
    let mut points = transfer::gather_everywhere(world.transport, points)?;
    points.sort_unstable_by_key(|point| point.cold.id);
    Ok(points)
}

/// A trained grain is one of the run, and has come from where it `began` if it has been in it before.
fn enter(grain: &mut Grain, velocity: Vector, began: Option<&(Vector, Image)>) {
    grain.cold.mover = Mover::Free;
    grain.cold.script = Vector::zero();
    grain.hot.spin = <Plane as Space>::Spin::zero();
    grain.hot.velocity = velocity;
    if let Some((origin, image)) = began {
        grain.cold.origin = *origin;
        grain.cold.image.iter_mut().zip(image).for_each(|(crossed, before)| *crossed += before);
    }
}

/// What a point is to be: one of the rim of an older zone is left as it is, or replaced.
fn becomes(zone: &Zone, point: &PlanarHot) -> Label {
    match zone.at(point.position[0], point.position[1]) {
        Label::Rim if point.weight < 1.0 => Label::Continuum,
        label => label,
    }
}

/// Whether a grain of an older zone's rim is to be one of the core.
fn is_raised(zone: &Zone, hot: &Hot<Plane>) -> bool {
    hot.weight > 0.0 && hot.weight < 1.0 && zone.at(hot.position[0], hot.position[1]) == Label::Grains
}

/// Whether a point is one of an older rim, in the cells that are `near`, that stays as it is.
fn is_of_older_rim(zone: &Zone, near: &[bool], point: &PlanarHot) -> bool {
    let is_near = || zone.grid.at(point.position[0], point.position[1]).is_some_and(|cell| near[cell]);
    point.weight < 1.0 && becomes(zone, point) == Label::Continuum && is_near()
}

/// Mass, kg, and momentum along x and y, N s, that grains of an older zone's rim take over with their whole weight. Collective.
fn raised(world: &PlanarWorld, zone: &Zone) -> Result<[f64; 3], Error> {
    let mut sums = ExactSum::<3>::new();
    for hot in world.assembly.grains.hot[..world.assembly.grains.owned].iter().filter(|hot| is_raised(zone, hot)) {
        let mass = (1.0 - hot.weight) * hot.mass;
        sums.add(0, mass);
        sums.add(1, mass * hot.velocity[0]);
        sums.add(2, mass * hot.velocity[1]);
    }
    world.reduce(sums)
}

/// Grains of this rank that have been there, with the contacts that those who `touched` the new ones have got. Collective.
fn stayed(world: &PlanarWorld, zone: &Zone, touched: Vec<Grain>) -> Result<Vec<Grain>, Error> {
    let mut touched = transfer::gather_everywhere(world.transport, touched)?;
    touched.sort_unstable_by_key(|row| row.cold.id);
    let mut rows = world.grain_rows(0..world.assembly.grains.owned);
    for row in &mut rows {
        if is_raised(zone, &row.hot) {
            row.hot.weight = 1.0;
        }
        if let Ok(at) = touched.binary_search_by_key(&row.cold.id, |row| row.cold.id) {
            row.contacts.extend_from_slice(&touched[at].contacts);
            row.contacts.sort_unstable_by_key(|(partner, _)| *partner);
        }
    }
    Ok(rows)
}

/// One rigid correction gives the grains exactly the momentum that the points gave up.
fn correct_momentum(world: &PlanarWorld, grains: &mut [Grain], wanted: [f64; 2]) -> Result<(), Error> {
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

/// Solid volume fraction by which a grain's share of space follows from its own volume where no better is known.
const FRACTION_NOMINAL: f64 = 0.84;

/// Mean Love-Weber stress of the free grains, Pa: xx, yy, xy.
pub fn grain_stress(world: &mut PlanarWorld, depth: f64) -> Result<[f64; 3], Error> {
    stress_of(world, depth, |_| true)
}

/// The same of those that are wanted by their ids.
fn stress_of(world: &mut PlanarWorld, depth: f64, is_wanted: impl Fn(GrainId) -> bool) -> Result<[f64; 3], Error> {
    world.refresh_ghosts();
    let mut sums = ExactSum::<4>::new();
    for (row, (hot, cold)) in
        world.assembly.grains.hot[..world.assembly.grains.owned].iter().zip(&world.assembly.grains.cold).enumerate()
    {
        if cold.mover == Mover::Free && is_wanted(cold.id) {
            let moment = world.assembly.contacts.moment(world.law(), &world.assembly.grains, row, [0.0; 2]);
            sums.add(0, moment[0]);
            sums.add(1, moment[3]);
            sums.add(2, 0.5 * (moment[1] + moment[2]));
            sums.add(3, Plane::grain_volume(hot.radius, depth));
        }
    }
    let [xx, yy, xy, volume] = world.reduce(sums)?;
    if volume == 0.0 {
        // All of them are led.
        return Ok([0.0; 3]);
    }
    let space = volume / FRACTION_NOMINAL;
    Ok([xx / space, yy / space, xy / space])
}
