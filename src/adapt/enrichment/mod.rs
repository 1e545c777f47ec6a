//! Replacing a shear band by grains: the world's side of Chen et al. (2021), section 4.

use std::path::Path;

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Plane, Space};
use crate::bodies::body::{Body, Shape, Side};
use crate::couple::zone::{CellGrid, Enrichment, Label, Zone};
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
mod leaving;
mod motion;
mod patches;
mod points;
mod residents;
mod training;

pub use account::BeforeAndAfter;
pub use dissolution::{Dissolved, dissolve};
pub use motion::track;
pub use patches::strength_mobilised;

use account::Account;
use choose::{Sight, Stands, border, choose};
use motion::Motion;
use residents::{Resident, Residents};
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

/// Points that go and trained grains that take their places around flagged nodes; nothing has been changed yet.
pub struct Plan {
    zone: Zone,
    /// That points of the rim keep.
    point_weight: f64,
    /// Rows of this rank's blocks.
    trained: Trained,
    enriched: Enriched,
}

impl Plan {
    /// Points around the flagged nodes give way to grains of the packing in `packing_file`, which `lies` in the specimen; `depth` is that
    /// of the plane, m. Grains that are there already stay. Collective.
    pub fn of(
        world: &mut PlanarWorld,
        (settings, depth): (&Enrichment, f64),
        flagged: &[u64],
        instants: &Instants,
        (packing_file, lies): (&Path, Lies<'_>),
    ) -> Result<Result<Self, Refusal>, Error> {
        if world.has_grains() {
            // Lists that are made of them and of others begin where they are.
            world.rebuild()?;
        }
        let mut zone = Zone::around(&along_plates(world, flagged, settings), cell_grid(world), settings);
        let mut meets = |body: &Body<Plane>| match body.shape {
            Shape::Plate { side, .. } => zone.close_at(body.face(), side == Side::Above),
            _ => false,
        };
        let plates: Vec<usize> = (0..world.bodies.len()).filter(|number| meets(&world.bodies[*number])).collect();
        let near = zone.within(MARGIN);
        let is_near = |place: &Vector| zone.grid.at(place[0], place[1]).is_some_and(|cell| near[cell]);
        let points = world.continuum.points.rows().filter(|point| is_near(&point.hot.position)).collect();
        let mut points = transfer::gather_everywhere(world.transport, points)?;
        points.sort_unstable_by_key(|point| point.cold.id);
        // Points bear loads, and grains do not: they share the cells of those that do.
        let loaded =
            points.iter().filter(|point| loads_in(point.cold.loads).next().is_some()).map(|point| point.hot.position);
        loaded.for_each(|place| zone.share(place[0], place[1]));
        let (zone_of, points_of) = (&zone, &points);
        let of = |wanted: Label| points_of.iter().filter(move |point| becomes(zone_of, &point.hot) == wanted);
        let mass_of = |wanted: Label| of(wanted).map(|point| point.hot.weight * point.hot.mass).sum::<f64>();
        let (core, rim) = (mass_of(Label::Grains), mass_of(Label::Rim));
        if core == 0.0 || rim == 0.0 {
            return Ok(Err(Refusal(
                "the zone around the shear band has no core or no rim; `enrichment.distance` must exceed a cell, and the band must leave continuum beside it".into(),
            )));
        }
        let motion = Motion::of(world, &points, instants, settings.training);
        let mut residents = Residents::of(world)?;
        let [raised, ..] = raised(world, &zone)?;
        let sight = Sight::of(settings, &zone, &motion, &residents);
        let is_wanted = |id: GrainId, origin: &Vector| !matches!(sight.stands(id.0, origin), Stands::Away);
        let Reference { grains: packing, seats } =
            Reference::read(world, packing_file, (lies, zone.middle()), is_wanted)?;
        let of_packing = (&packing[..], lies, &plates[..]);
        let mut chosen = match choose(settings, &zone, &sight, of_packing, [core - raised, rim]) {
            Ok(chosen) => chosen,
            Err(refusal) => return Ok(Err(refusal)),
        };
        drop(packing);
        let mut enriched = Enriched {
            stress_points: mean_stress(of(Label::Grains)),
            points_rim: of(Label::Rim).count() as u64,
            grains: chosen.grains.len() as u64,
            grains_rim: chosen.rim.len() as u64,
            ..Enriched::default()
        };
        // Where they are to stand is known before training.
        let stand = |grain: &Grain| match grain.cold.mover {
            Mover::Body(plate) => {
                Some(Resident::glued(grain.cold.id.0, grain.cold.origin, &world.bodies[usize::from(plate)]))
            }
            Mover::Free | Mover::Script => None,
        };
        residents.extend(chosen.glued.iter().filter_map(stand));
        let border = border(&zone.grid, &points, &residents, &chosen);
        let held = Confinement { rim: &chosen.rim, border: &border, residents: &residents, lies, seats: &seats };
        let mut all = chosen.grains;
        all.extend(chosen.beside);
        all.extend(chosen.glued.iter().cloned());
        let mut trained = match train(world, (settings, depth), &motion, all, &held, &mut enriched) {
            Ok(trained) => trained,
            Err(Error::Run(why)) => return Ok(Err(Refusal(format!("training came to nothing: {why}")))),
            Err(other) => return Err(other),
        };
        chosen.glued.sort_unstable_by_key(|grain| grain.cold.id);
        trained.seat(&chosen.glued);
        for grain in &mut trained.grains {
            grain.cold.mover = Mover::Free;
            grain.cold.script = Vector::zero();
            let in_rim = chosen.rim.binary_search(&grain.cold.id.0).is_ok();
            grain.hot.weight = if in_rim { settings.weight } else { 1.0 };
            grain.hot.spin = <Plane as Space>::Spin::zero();
            grain.hot.velocity = motion.velocity(&grain.cold.origin);
        }
        Ok(Ok(Self { zone, point_weight: chosen.point_weight, trained, enriched }))
    }

    /// Puts the grains in. Collective.
    pub fn carry_out(self, world: &mut PlanarWorld) -> Result<Enriched, Error> {
        let Self { zone, point_weight, trained: Trained { mut grains, touched, glued }, mut enriched } = self;
        let account = Account::open(world)?;
        world.look_at_costs();
        let mut lost = ExactSum::<4>::new();
        world.continuum.points.retain(|point| {
            let label = becomes(&zone, point);
            let freed = match label {
                Label::Continuum => 0.0,
                Label::Grains => point.weight,
                Label::Rim => point.weight - point_weight,
            };
            lost.add(0, freed * point.mass);
            lost.add(1, freed * point.mass * point.velocity[0]);
            lost.add(2, freed * point.mass * point.velocity[1]);
            match label {
                Label::Continuum => {}
                Label::Grains => lost.add(3, 1.0),
                Label::Rim => point.weight = point_weight,
            }
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

/// The flagged nodes, and all beside those whose zone comes to a plate: a zone meets a plate along all of it or not at all.
fn along_plates(world: &PlanarWorld, flagged: &[u64], settings: &Enrichment) -> Vec<u64> {
    let grid = cell_grid(world);
    let reach = settings.distance + 1.5 * grid.cell;
    let is_plate = |body: &&Body<Plane>| matches!(body.shape, Shape::Plate { .. });
    let faces: Vec<f64> = world.bodies.iter().filter(is_plate).map(Body::face).collect();
    grid.with_rows(flagged, |height| faces.iter().any(|face| (height - face).abs() <= reach))
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
    world.refresh_ghosts();
    let mut sums = ExactSum::<4>::new();
    for (row, (hot, cold)) in
        world.assembly.grains.hot[..world.assembly.grains.owned].iter().zip(&world.assembly.grains.cold).enumerate()
    {
        if cold.mover == Mover::Free {
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
