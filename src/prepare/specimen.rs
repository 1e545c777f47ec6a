//! The grains that a job on a grid begins with: pieces of a periodic packing laid side by side, cut to the job's regions, and
//! equilibrated between its bodies and membranes.
//!
//! A piece is under the stress of the start as the points are. Where it is cut, contacts are missing: grains there move by a part of
//! their overlaps until membranes bear them, and bodies with a `seat` come up to them. Where the grid is periodic it is joined to itself
//! ([`crate::prepare::join`]). All this happens before the run.

use scree_io::column::State;
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::record::{Cargo, to_table};
use crate::base::space::{Linear, Space};
use crate::bodies::body::{Body, Servo};
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::law::{SharedLaw, law_of, memory_words};
use crate::dem::motion::{Damping, DampingForm, Field};
use crate::dem::walls::place_beside;
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::domain::world::{Settings, World};
use crate::job::Method;
use crate::job::assembly::{Packed, Preparation, Source};
use crate::job::mpm::figures::bounding_box;
use crate::job::mpm::{BodyContact, Granular, Mpm, Origin, RigidBody};
use crate::law::contact::Contact;
use crate::mpm::membrane::Vertex;
use crate::mpm::stress::material_of;
use crate::prepare::cache::{Found, Place};
use crate::prepare::join::{Join, Laid, wrapped};
use crate::prepare::making::{Leg, Look, Making};
use crate::prepare::sheared::{on_root, settle, share};
use crate::prepare::{packed, point_world, recipe};
use crate::store::checkpoint::{self, Drawn, Progress};
use crate::store::tables;

/// What a run begins with.
pub struct Specimen<S: Space> {
    /// On rank 0 only, in the order of their ids; at rest, contacts with their memories.
    pub grains: Vec<GrainRow<S>>,
    /// Bodies where grains have stopped them, and vertices where grains have; on every rank.
    pub bodies: Vec<Body<S>>,
    /// Of membranes.
    pub vertices: Vec<Vertex<S>>,
    /// Solid volume fraction of the piece.
    pub fraction: f64,
    /// The piece itself, where zones are made of it.
    pub piece: Option<packed::Packing<S>>,
}

/// Damping of grains that equilibrate, against the ground per t_p = d sqrt(rho/p), and local.
const DAMPING_MASS: f64 = 0.2;
const DAMPING_LOCAL: f64 = 0.2;
/// Mass of a body that is seated, as a share of the grains', and its dashpot as a share of the critical one for that mass on
/// material of modulus M as wide as it is high.
const SEAT_MASS: f64 = 0.1;
const SEAT_DAMPING: f64 = 0.5;
/// Inertial number that a body which is seated keeps below, (v/H) d sqrt(rho/p).
const INERTIAL_NUMBER: f64 = 1e-3;
/// Steps between two looks at whether everything rests, looks in a row that must find it so, and way of a body between two, in
/// mean diameters, with which it does.
const LOOK_EVERY: u64 = 500;
const CALM_LOOKS: u32 = 3;
const CALM_WAY: f64 = 1e-4;
/// Elastic energy of grains under a stress, about, as a share of that stress times their volume.
const UNBORNE: f64 = 1e-3;
/// How often a specimen is equilibrated for its bodies to come where the job has them, and how near is near enough, in mean
/// diameters.
const SEATS_MAX: u64 = 4;
const SEAT_TOLERANCE: f64 = 0.05;
/// How far the fractions of packing and material may be apart before it is worth a word.
const FRACTION_OFF: f64 = 0.02;
/// Steps after which a specimen that has not equilibrated is given up.
const STEPS_MAX: u64 = 5_000_000;
/// Friction of rough bodies: grains roll on them, and do not slide.
const FRICTION_ROUGH: f64 = 1e3;

/// The specimen of a job: from the cache, or made now and cached. Collective.
pub fn specimen<S: Space>((job, granular): (&Mpm, &Granular), transport: &dyn Transport) -> Result<Specimen<S>, Error> {
    let packed = packed_of(granular);
    // The piece is no run and has no output of its own.
    let save_every = job.output.save_every();
    let piece = packed::make::<S>(&granular.piece, packed, save_every, transport)?;
    let depth = job.grid.depth;
    let solid: f64 = piece.grains.iter().map(|grain| S::grain_volume(grain.hot.radius, depth)).sum();
    let volume = piece.cell.volume() * if S::DIMENSION == 2 { depth } else { 1.0 };
    let fraction = share(transport, solid / volume);
    let off = job.material.law.fraction().filter(|stated| (fraction - stated).abs() > FRACTION_OFF);
    if let (Some(stated), 0) = (off, transport.rank()) {
        tracing::warn!(fraction, stated, "warning: the packing's fraction is not that of the material");
    }
    let is_tiled = granular.method == Method::Hybrid && granular.reference == Origin::Piece;
    if !job.makes_specimen() || is_tiled {
        let (bodies, vertices) = (point_world::bodies(job), point_world::vertices(job));
        return Ok(Specimen { grains: Vec::new(), bodies, vertices, fraction, piece: is_tiled.then_some(piece) });
    }
    let place = Place::new(&packed.cache, "specimen", &recipe::specimen(job, granular, way_of_seat));
    let (grains, bodies, vertices) =
        match place.find(transport, save_every, |state| of_state(state, &granular.piece.contact))? {
            Found::There(found) => found.unwrap_or_default(),
            Found::ToMake(mut making) => {
                if transport.rank() == 0 {
                    let file = place.file().display();
                    tracing::info!("making the specimen, which other runs of its kind will share: {file}");
                }
                let mut rested = rested((job, granular), &piece, &mut making)?;
                making.finish(|| state_of(&mut rested, &granular.piece.contact))?;
                rested
            }
        };
    let shifts = transfer::broadcast(transport, bodies)?;
    let mut bodies = point_world::bodies::<S>(job);
    bodies.iter_mut().zip(shifts).for_each(|(body, rested)| body.displacement = rested.displacement);
    Ok(Specimen { grains, bodies, vertices: transfer::broadcast(transport, vertices)?, fraction, piece: None })
}

/// Laws of contacts with the job's bodies.
pub fn laws_of_bodies<S: Space>(job: &Mpm, granular: &Granular) -> Vec<SharedLaw<S>> {
    let law = |friction: f64| law_of(&granular.piece.contact.without_cohesion().with_friction(friction));
    let of = |contact: BodyContact| match contact {
        BodyContact::Rough => law(FRICTION_ROUGH),
        BodyContact::Smooth => law(0.0),
        BodyContact::Coulomb { friction } => law(friction),
    };
    job.bodies.iter().map(|body| of(body.contact)).collect()
}

fn packed_of(granular: &Granular) -> &Packed {
    match &granular.piece.source {
        Source::Packed(packed) => packed,
        Source::File(_) => unreachable!("a checked job has its piece made"),
    }
}

/// Mean stress of the piece, Pa.
pub fn stress_of(granular: &Granular) -> f64 {
    match packed_of(granular).preparation {
        Preparation::Compress { stress, unloaded, .. } => unloaded.unwrap_or(stress),
        Preparation::Pour => unreachable!("a checked job has its piece compressed"),
    }
}

/// The direction in which a body that is seated first goes, along which it comes up to the grains.
fn way_of_seat(rigid: &RigidBody) -> Option<[f64; 3]> {
    let velocities = rigid.body.motion.path.iter().map(|at| at.velocity);
    let first = velocities.filter(|_| rigid.seat > 0.0).find(|velocity| *velocity != [0.0; 3])?;
    let speed = first.iter().map(|component| component * component).sum::<f64>().sqrt();
    Some(first.map(|component| component / speed))
}

/// Grains, bodies and vertices at rest. A body comes to rest on the few grains that stand out most: what lies below where the job
/// has it is filled up with more grains, and everything equilibrated again.
fn rested<S: Space>(
    (job, granular): (&Mpm, &Granular),
    piece: &packed::Packing<S>,
    making: &mut Making,
) -> Result<Rested<S>, Error> {
    let transport = making.transport();
    let mut raised: Vec<S::Vector> = vec![S::Vector::zero(); job.bodies.len()];
    let mut best: Option<(f64, Rested<S>)> = None;
    for attempt in 0..SEATS_MAX {
        let rested = match over(making, attempt, &granular.piece.contact)? {
            Some(rested) => rested,
            None => {
                making.begin(attempt);
                let mut rested = equilibrate((job, granular), (piece, &raised), making)?;
                transfer::agree(transport, making.keep(attempt, &state_of(&mut rested, &granular.piece.contact)))?;
                rested
            }
        };
        let off = rested.1.iter().map(|body| body.displacement.norm()).fold(0.0, f64::max);
        raised.iter_mut().zip(&rested.1).for_each(|(raised, body)| *raised -= body.displacement);
        if best.as_ref().is_none_or(|(least, _)| off < *least) {
            best = Some((off, rested));
        }
        if off <= SEAT_TOLERANCE * granular.piece.matter.diameter_mean {
            break;
        }
    }
    let (off, rested) = best.expect("one was made at least");
    if off > SEAT_TOLERANCE * granular.piece.matter.diameter_mean && transport.rank() == 0 {
        tracing::warn!(off, "warning: a body rests that far (m) from where the job has it");
    }
    Ok(rested)
}

/// What an attempt has come to that is over: grains on rank 0, the rest on every rank. Collective.
fn over<S: Space>(making: &Making, attempt: u64, contact: &Contact) -> Result<Option<Rested<S>>, Error> {
    let transport = making.transport();
    let kept = on_root(transport, || making.kept(attempt).map(|state| of_state(state, contact)).transpose());
    let kept = transfer::agree(transport, kept)?.flatten();
    if transport.broadcast(vec![u8::from(kept.is_some())])[0] == 0 {
        return Ok(None);
    }
    let (grains, bodies, vertices) = kept.unwrap_or_default();
    Ok(Some((grains, transfer::broadcast(transport, bodies)?, transfer::broadcast(transport, vertices)?)))
}

/// Copies of the piece over all regions, and of these the grains whose centres lie in one, or in what bodies that are `raised` by so
/// much (m) leave free, and that touch no body. Across the periods of the grid they are joined.
fn cut<S: Space>(job: &Mpm, piece: &packed::Packing<S>, raised: &[S::Vector]) -> Result<Vec<GrainRow<S>>, Error> {
    let cell = point_world::cell::<S>(job, &point_world::layout::<S>(job)?);
    let mut bodies = point_world::bodies::<S>(job);
    bodies.iter_mut().zip(raised).for_each(|(body, raised)| body.displacement = *raised);
    let is_inside = |place: &S::Vector| job.region_at(&components::<S>(place)).is_some();
    let is_material = |place: &S::Vector| {
        is_inside(place) || raised.iter().any(|raised| is_inside(&wrapped(&cell, &(*place - *raised))))
    };
    let is_free = |place: &S::Vector, radius: f64| {
        let mut near = bodies.iter().filter_map(|body| body.nearest(&place_beside(body, &cell, place)));
        near.all(|near| near.distance >= radius)
    };
    let is_periodic = cell.periodic.contains(&true);
    let join = is_periodic.then(|| Join::of((&cell, &bodies), &is_material, piece));
    let boxes: Vec<_> = job.regions.iter().map(|region| bounding_box(&region.shape)).collect();
    let (mut first, mut copies) = ([0.0; 3], [1; 3]);
    for axis in 0..S::DIMENSION {
        let edge = piece.cell.edges[axis * S::DIMENSION + axis];
        if let Some(join) = join.as_ref().filter(|_| cell.periodic[axis]) {
            (first[axis], copies[axis]) = join.pieces(axis, edge);
            continue;
        }
        let lower = boxes.iter().map(|corners| corners.0[axis]).fold(f64::INFINITY, f64::min);
        let upper = boxes.iter().map(|corners| corners.1[axis]).fold(f64::NEG_INFINITY, f64::max);
        let more = raised.iter().map(|raised| raised[axis].abs()).fold(0.0, f64::max);
        // Whole pieces before the corner, so that grains lie where they lie whatever has been raised.
        let before = (more / edge).ceil();
        copies[axis] = (before + ((upper - lower + more) / edge).ceil().max(1.0)) as u64;
        first[axis] = lower - before * edge;
    }
    let laid = piece.side_by_side(first, copies);
    let laid = laid.map(|(id, place, grain)| Laid { id, place, radius: grain.hot.radius, mass: grain.hot.mass });
    let is_taken = |laid: &Laid<S>| {
        let place = wrapped(&cell, &laid.place);
        is_free(&place, laid.radius) && is_material(&place)
    };
    let taken = match &join {
        Some(join) => join.joined(laid.filter(|laid| join.is_near(&laid.place)).filter(is_taken).collect()),
        None => laid.filter(is_taken).collect(),
    };
    let resting = |laid: &Laid<S>| GrainRow::resting(laid.id, laid.place, laid.radius, laid.mass, Mover::Free);
    match taken.is_empty() {
        true => Err(Error::User(
            "no grain of the packing has its centre in a [[region]]; make the regions larger than a grain".into(),
        )),
        false => Ok(taken.iter().map(resting).collect()),
    }
}

/// A place as jobs have it.
fn components<S: Space>(place: &S::Vector) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < S::DIMENSION { place[axis] } else { 0.0 })
}

type Rested<S> = (Vec<GrainRow<S>>, Vec<Body<S>>, Vec<Vertex<S>>);

/// Grains, bodies and vertices once everything rests; rows on rank 0.
fn equilibrate<S: Space>(
    (job, granular): (&Mpm, &Granular),
    (piece, raised): (&packed::Packing<S>, &[S::Vector]),
    making: &mut Making,
) -> Result<Rested<S>, Error> {
    let transport = making.transport();
    let grains = on_root(transport, || cut(job, piece, raised));
    let grains = transfer::agree(transport, grains)?.unwrap_or_default();
    let mass = share(transport, grains.iter().map(|grain| grain.hot.mass).sum());
    let bodies = seated_bodies(job, granular, mass, raised);
    let taken_up = making.taken_up::<S>(&granular.piece.contact)?;
    if taken_up.is_none() {
        tracing::info!(grains = grains.len(), "equilibrating the specimen");
    }
    let (parts, step) = match taken_up {
        Some(snapshot) => {
            let draw = |_: &Progress, vertices| Ok(Drawn { bodies, ..point_world::drawn(job, vertices)? });
            let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
            (parts, progress.step)
        }
        None => {
            let Drawn { cell, membranes, .. } = point_world::drawn(job, point_world::vertices(job))?;
            let mut parts = Parts::fresh(grains, Vec::new(), bodies, cell);
            parts.membranes = membranes;
            (parts, 0)
        }
    };
    let settings = settings_of_rest(job, granular);
    let mut world = World::new(settings, point_world::layout::<S>(job)?, transport, step, parts)?;
    world.assembly.walls.laws = laws_of_bodies(job, granular);

    let (goal, diameter) = (packed_of(granular).energy_ratio_max, granular.piece.matter.diameter_mean);
    let pressed = stress_of(granular) * mass / granular.piece.matter.density;
    let leg = Leg { name: "equilibrating", rebuilds: false, look_every: LOOK_EVERY, calm_looks: CALM_LOOKS, goal };
    making.equilibrate(&mut world, leg, |_, _| (), |world, notes| {
        let ratio = world.unrest()?;
        let ways = world.bodies.iter().zip(raised).enumerate().map(|(number, (body, raised))| {
            let mut way = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                let name = format!("displacement {number} {axis}");
                way[axis] = body.displacement[axis] - notes.get(&name).unwrap_or(raised[axis]);
                notes.set(&name, body.displacement[axis]);
            }
            way.norm()
        });
        let rests = ways.fold(0.0, f64::max) < CALM_WAY * diameter;
        if world.step > STEPS_MAX {
            return Err(Error::Run(format!(
                "the specimen has not equilibrated between its bodies and membranes after {} steps: kinetic/elastic energy {ratio:.1e} (wanted {goal:.1e}); raise packing.energy_ratio_max, or look whether anything holds the grains on every side",
                world.step,
            )));
        }
        // Grains that nothing presses bear nothing, and rest once next to none of what they would bear is left in their motion.
        let lies = ratio.is_infinite() && world.energies()?.kinetic_grains < goal * UNBORNE * pressed;
        let rests = rests && (ratio < goal || lies);
        Ok(Look { rests, ratio, words: format!("{} grains", world.grains_total) })
    })?;
    world.rebuild()?;
    let (rows, _) = world.rows();
    let mut rows = transfer::gather(transport, rows)?.unwrap_or_default();
    rows.sort_unstable_by_key(|row| row.cold.id);
    rows.iter_mut().for_each(settle);
    let still = |vertex: &Vertex<S>| {
        let at = vertex.position;
        Vertex { velocity: S::Vector::zero(), origin: at, home: at, ..*vertex }
    };
    let vertices = world.continuum.membranes.vertices.iter().map(still).collect();
    Ok((rows, world.bodies.clone(), vertices))
}

/// The bodies of a job at rest, or pressed on; `mass` is that of all grains, kg.
fn seated_bodies<S: Space>(job: &Mpm, granular: &Granular, mass: f64, raised: &[S::Vector]) -> Vec<Body<S>> {
    let boxes = job.regions.iter().map(|region| bounding_box(&region.shape));
    let up = S::DIMENSION - 1;
    let height = boxes.map(|(lower, upper)| upper[up] - lower[up]).fold(0.0, f64::max);
    // Across the plane, or in space as wide as it is high.
    let depth = if S::DIMENSION == 2 { job.grid.depth } else { height };
    let stiffness = job.material.law.modulus_longitudinal(S::DIMENSION) * depth;
    let mut bodies = point_world::bodies::<S>(job);
    for ((body, rigid), raised) in bodies.iter_mut().zip(&job.bodies).zip(raised) {
        body.displacement = *raised;
        let way = body.path.iter().map(|at| at.velocity).find(|velocity| velocity.norm() > 0.0);
        body.path.clear();
        if let (Some(way), true) = (way, rigid.seat > 0.0) {
            let mass = SEAT_MASS * mass;
            body.servo = Some(Servo {
                direction: way * (-1.0 / way.norm()),
                force: rigid.seat,
                mass,
                damping: SEAT_DAMPING * 2.0 * (stiffness * mass).sqrt(),
                speed_max: INERTIAL_NUMBER * height / time_of_grain(granular),
            });
        }
    }
    bodies
}

/// t_p = d sqrt(rho/p), s.
fn time_of_grain(granular: &Granular) -> f64 {
    let matter = &granular.piece.matter;
    matter.diameter_mean * (matter.density / stress_of(granular)).sqrt()
}

fn settings_of_rest<S: Space>(job: &Mpm, granular: &Granular) -> Settings<S> {
    let mut settings: Settings<S> =
        point_world::settings(job, material_of(&job.material.law), law_of(&granular.piece.contact));
    settings.grain_steps = 1;
    settings.grid.penalty = granular.penalty_of_every_step(job.step);
    let mass = DAMPING_MASS / time_of_grain(granular);
    let damping = Damping { local: DAMPING_LOCAL, form: DampingForm::Component, mass };
    let mut gravity = settings.grains.field.gravity;
    // Along a period nothing need hold grains back, and they would fall for ever.
    (0..S::DIMENSION).filter(|axis| job.grid.periodic[*axis]).for_each(|axis| gravity[axis] = 0.0);
    settings.grains.field = Field { damping, gravity };
    settings
}

fn state_of<S: Space>((grains, bodies, vertices): &mut Rested<S>, contact: &Contact) -> State {
    let mut tables = Vec::from(tables::of_grains(grains, memory_words::<S>(contact)));
    tables.push(to_table("bodies", bodies, &mut Body::blank()));
    tables.push(to_table("membranes", vertices, &mut Vertex::blank()));
    State { attributes: Default::default(), tables }
}

fn of_state<S: Space>(mut state: State, contact: &Contact) -> Result<Rested<S>, Error> {
    let bodies = tables::rows(&state, "bodies", &Body::blank())?;
    let vertices = tables::rows(&state, "membranes", &Vertex::blank())?;
    Ok((tables::to_grains(&mut state, memory_words::<S>(contact))?, bodies, vertices))
}

#[cfg(test)]
mod tests;
