//! The grains that a job on a grid begins with: pieces of a periodic packing laid side by side, cut to the job's regions, and
//! brought to rest between its bodies and membranes.
//!
//! A piece is under the stress of the start as the points are. Where it is cut, contacts are missing: grains there move by a part of
//! their overlaps until membranes bear them, and bodies with a `seat` come up to them. All this happens before the run.

use scree_io::column::State;
use scree_partition::Transport;

use crate::assembly::packed;
use crate::body::{Body, Servo};
use crate::continuum::setup;
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::motion::Field;
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::CriticalDruckerPrager;
use crate::mpm::membrane::Vertex;
use crate::packing::{Grain, PlanarWorld, is_told, name_of, on_root, read_state, settle, share, steps, write_state};
use crate::rebuild::Parts;
use crate::record::to_table;
use crate::scenario::Method;
use crate::scenario::assembly::{Damping, DampingForm, Packed, Preparation, Source};
use crate::scenario::mpm::figures::bounding_box;
use crate::scenario::mpm::{BodyContact, Granular, Mpm, Origin, RigidBody};
use crate::space::{Linear, Plane, Space};
use crate::transfer::Cargo;
use crate::{tables, transfer};

type Vector = <Plane as Space>::Vector;

/// What a run begins with.
pub struct Specimen<C: ContactLaw<Plane>> {
    /// On rank 0 only, in the order of their ids; at rest, contacts with their memories.
    pub grains: Vec<Grain<C>>,
    /// Bodies where grains have stopped them, and vertices where grains have; on every rank.
    pub bodies: Vec<Body<Plane>>,
    pub vertices: Vec<Vertex<Plane>>,
    /// Packing fraction of the piece.
    pub fraction: f64,
    /// The piece itself, where zones are made of it.
    pub piece: Option<packed::Packing<Plane, C>>,
}

/// Damping of grains that come to rest, against the ground per t_p = d sqrt(rho/p), and local.
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
/// How often a specimen is brought to rest for its bodies to come where the job has them, and how near is near enough, in mean
/// diameters.
const SEATS_MAX: usize = 4;
const SEAT_TOLERANCE: f64 = 0.05;
/// How far the fractions of packing and material may be apart before it is worth a word.
const FRACTION_OFF: f64 = 0.02;
/// Steps after which a specimen that has not come to rest is given up.
const STEPS_MAX: u64 = 5_000_000;
/// Friction of rough bodies: grains roll on them, and do not slide.
const FRICTION_ROUGH: f64 = 1e3;

/// The specimen of a job: from the cache, or made now and cached. Collective.
pub fn specimen<C: ContactLaw<Plane>>(
    job: &Mpm,
    granular: &Granular,
    transport: &dyn Transport,
) -> Result<Specimen<C>, Error> {
    let packed = packed_of(granular);
    let piece = packed::make::<Plane, C>(&granular.piece, packed, transport)?;
    let depth = job.grid.depth;
    let solid: f64 = piece.grains.iter().map(|grain| Plane::grain_volume(grain.hot.radius, depth)).sum();
    let fraction = share(transport, solid / (piece.cell.volume() * depth));
    if (fraction - job.material.law.fraction()).abs() > FRACTION_OFF && transport.rank() == 0 {
        let stated = job.material.law.fraction();
        tracing::warn!(fraction, stated, "warning: the packing's fraction is not that of the material");
    }
    let is_tiled = granular.method == Method::Hybrid && granular.reference == Origin::Piece;
    if granular.method == Method::Mpm || is_tiled {
        let (bodies, vertices) = (setup::bodies(job), setup::vertices(job));
        return Ok(Specimen { grains: Vec::new(), bodies, vertices, fraction, piece: is_tiled.then_some(piece) });
    }
    let file = packed.cache.join(format!("specimen-{}.h5", name_of(&key(job, granular))));
    let cached = on_root(transport, || if file.exists() { read::<C>(&file).map(Some) } else { Ok(None) });
    let cached = transfer::agree(transport, cached)?.flatten();
    let known = transport.broadcast(vec![u8::from(cached.is_some())])[0] == 1;
    let (grains, bodies, vertices) = match known {
        true => cached.unwrap_or_default(),
        false => {
            if transport.rank() == 0 {
                tracing::info!(file = %file.display(), "making the specimen, which other runs of its kind will share");
            }
            let mut rested = rested::<C>(job, granular, &piece, transport)?;
            let written = on_root(transport, || write::<C>(&file, &mut rested));
            transfer::agree(transport, written)?;
            rested
        }
    };
    let shifts = transfer::broadcast(transport, bodies)?;
    let mut bodies = setup::bodies::<Plane>(job);
    bodies.iter_mut().zip(shifts).for_each(|(body, rested)| body.displacement = rested.displacement);
    Ok(Specimen { grains, bodies, vertices: transfer::broadcast(transport, vertices)?, fraction, piece: None })
}

/// Laws of contacts with the job's bodies.
pub fn laws_of_bodies<C: ContactLaw<Plane>>(job: &Mpm, granular: &Granular) -> Vec<C> {
    let law = |friction: f64| {
        C::from_job(&granular.piece.contact.without_cohesion().with_friction(friction))
            .expect("the run was given the job's law")
    };
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

/// Everything that shapes a specimen; ways that bodies go in the run do not.
fn key(job: &Mpm, granular: &Granular) -> String {
    let piece = &granular.piece;
    let regions: Vec<_> = job.regions.iter().map(|region| &region.shape).collect();
    let bodies: Vec<_> = job
        .bodies
        .iter()
        .map(|body| {
            let (shape, motion) = (&body.body.shape, &body.body.motion);
            (shape, way_of_seat(body), &motion.servo, body.contact, body.separates, body.seat)
        })
        .collect();
    format!(
        "specimen 4 seed {} matter {:?} source {:?} contact {:?} step {:?} skin {:?} regions {regions:?} bodies {bodies:?} membranes {:?} gravity {:?} grid {:?} block {} scheme {:?} modulus {:?}",
        piece.seed,
        piece.matter,
        Source::Packed(Packed { cache: Default::default(), ..packed_of(granular).clone() }),
        piece.contact,
        piece.step,
        piece.skin,
        job.membranes,
        job.gravity,
        job.grid,
        job.cells_per_block,
        job.scheme,
        job.material.law.modulus_longitudinal(2),
    )
}

/// Grains, bodies and vertices at rest. A body comes to rest on the few grains that stand out most: what lies below where the job
/// has it is filled up with more grains, and everything brought to rest again.
fn rested<C: ContactLaw<Plane>>(
    job: &Mpm,
    granular: &Granular,
    piece: &packed::Packing<Plane, C>,
    transport: &dyn Transport,
) -> Result<Rested<C>, Error> {
    let mut raised: Vec<Vector> = vec![Vector::zero(); job.bodies.len()];
    let mut best: Option<(f64, Rested<C>)> = None;
    for _ in 0..SEATS_MAX {
        let grains = on_root(transport, || cut::<C>(job, piece, &raised));
        let grains = transfer::agree(transport, grains)?.unwrap_or_default();
        let rested = bring_to_rest::<C>(job, granular, (grains, &raised), transport)?;
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
        tracing::warn!(off, "warning: a body has come to rest that far (m) from where the job has it");
    }
    Ok(rested)
}

/// Copies of the piece over all regions, and of these the grains whose centres lie in one, or in what bodies that are `raised` by so
/// much (m) leave free, and that touch no body.
fn cut<C: ContactLaw<Plane>>(
    job: &Mpm,
    piece: &packed::Packing<Plane, C>,
    raised: &[Vector],
) -> Result<Vec<Grain<C>>, Error> {
    let boxes: Vec<_> = job.regions.iter().map(|region| bounding_box(&region.shape)).collect();
    let lower = [0, 1].map(|axis| boxes.iter().map(|corners| corners.0[axis]).fold(f64::INFINITY, f64::min));
    let upper = [0, 1].map(|axis| boxes.iter().map(|corners| corners.1[axis]).fold(f64::NEG_INFINITY, f64::max));
    let edges = [piece.cell.edges[0], piece.cell.edges[3]];
    let more = [0, 1].map(|axis| raised.iter().map(|raised| raised[axis].abs()).fold(0.0, f64::max));
    // Whole pieces before the corner, so that grains lie where they lie whatever has been raised.
    let before = [0, 1].map(|axis| (more[axis] / edges[axis]).ceil());
    let copies = [0, 1]
        .map(|axis| (before[axis] + ((upper[axis] - lower[axis] + more[axis]) / edges[axis]).ceil().max(1.0)) as u64);
    let mut bodies = setup::bodies::<Plane>(job);
    bodies.iter_mut().zip(raised).for_each(|(body, raised)| body.displacement = *raised);
    let is_inside = |place: &Vector| job.region_at(&[place[0], place[1], 0.0]).is_some();
    let mut grains = Vec::new();
    let first = [0, 1].map(|axis| lower[axis] - before[axis] * edges[axis]);
    for (id, place, grain) in piece.side_by_side(first, copies) {
        let is_free =
            bodies.iter().filter_map(|body| body.nearest(&place)).all(|near| near.distance >= grain.hot.radius);
        if is_free && (is_inside(&place) || raised.iter().any(|raised| is_inside(&(place - *raised)))) {
            grains.push(GrainRow::resting(id, place, grain.hot.radius, grain.hot.mass, Mover::Free));
        }
    }
    match grains.is_empty() {
        true => Err(Error::User(
            "no grain of the packing has its centre in a [[region]]; make the regions larger than a grain".into(),
        )),
        false => Ok(grains),
    }
}

type Rested<C> = (Vec<Grain<C>>, Vec<Body<Plane>>, Vec<Vertex<Plane>>);

/// Grains, bodies and vertices once everything rests; rows on rank 0.
fn bring_to_rest<C: ContactLaw<Plane>>(
    job: &Mpm,
    granular: &Granular,
    (grains, raised): (Vec<Grain<C>>, &[Vector]),
    transport: &dyn Transport,
) -> Result<Rested<C>, Error> {
    tracing::info!(grains = grains.len(), "bringing the specimen to rest");
    let mass = share(transport, grains.iter().map(|grain| grain.hot.mass).sum());
    let mut world = at_rest_between::<C>(job, granular, (grains, mass, raised), transport)?;
    let mut calm = 0;
    while calm < CALM_LOOKS {
        let before: Vec<Vector> = world.bodies.iter().map(|body| body.displacement).collect();
        steps(&mut world, LOOK_EVERY)?;
        let energies = world.energies()?;
        let ratio = energies.kinetic_grains / energies.elastic_grains;
        let moved = world.bodies.iter().zip(&before).map(|(body, before)| (body.displacement - *before).norm());
        let rests = moved.fold(0.0, f64::max) < CALM_WAY * granular.piece.matter.diameter_mean;
        calm = if rests && ratio < packed_of(granular).energy_ratio_max { calm + 1 } else { 0 };
        if is_told(world.step, LOOK_EVERY, world.grains_total) {
            tracing::info!(step = world.step, ratio, "kinetic over elastic energy");
        }
        if world.step > STEPS_MAX {
            return Err(Error::Run(format!(
                "the specimen has not come to rest between its bodies and membranes after {} steps: kinetic/elastic energy {ratio:.1e} (wanted {:.1e}); raise packing.energy_ratio_max, or look whether anything holds the grains on every side",
                world.step,
                packed_of(granular).energy_ratio_max
            )));
        }
    }
    world.rebuild()?;
    let (rows, _) = world.rows();
    let mut rows = transfer::gather(transport, rows)?.unwrap_or_default();
    rows.sort_unstable_by_key(|row| row.cold.id);
    rows.iter_mut().for_each(settle);
    let still = |vertex: &Vertex<Plane>| {
        let at = vertex.position;
        Vertex { velocity: Vector::zero(), origin: at, home: at, ..*vertex }
    };
    let vertices = world.membranes.vertices.iter().map(still).collect();
    Ok((rows, world.bodies.clone(), vertices))
}

/// A world of the grains with the job's membranes, and its bodies at rest or pressed on.
fn at_rest_between<'t, C: ContactLaw<Plane>>(
    job: &Mpm,
    granular: &Granular,
    (grains, mass, raised): (Vec<Grain<C>>, f64, &[Vector]),
    transport: &'t dyn Transport,
) -> Result<PlanarWorld<'t, C>, Error> {
    let (piece, stress) = (&granular.piece, stress_of(granular));
    let time = piece.matter.diameter_mean * (piece.matter.density / stress).sqrt();
    let boxes = job.regions.iter().map(|region| bounding_box(&region.shape));
    let height = boxes.map(|(lower, upper)| upper[1] - lower[1]).fold(0.0, f64::max);
    let stiffness = job.material.law.modulus_longitudinal(2) * job.grid.depth;
    let mut bodies = setup::bodies::<Plane>(job);
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
                speed_max: INERTIAL_NUMBER * height / time,
            });
        }
    }
    let law = CriticalDruckerPrager::of_job(law_of(job));
    let contact = C::from_job(&piece.contact).expect("the run was given the job's law");
    let mut settings = setup::settings::<Plane, C, _>(job, law, contact);
    settings.grain_steps = 1;
    let damping = Damping { local: DAMPING_LOCAL, form: DampingForm::Component, mass: DAMPING_MASS / time };
    settings.field = Field { damping, ..settings.field };
    let layout = setup::layout::<Plane>(job)?;
    let cell = setup::cell::<Plane>(&layout);
    let mut parts = Parts::fresh(grains, Vec::new(), bodies, cell);
    parts.membranes = setup::hung(job, setup::vertices(job))?;
    let mut world = PlanarWorld::new(settings, layout, transport, 0, parts)?;
    world.walls.laws = laws_of_bodies(job, granular);
    Ok(world)
}

/// The law of a checked job with grains.
pub fn law_of(job: &Mpm) -> &crate::scenario::mpm::CriticalDruckerPrager {
    match &job.material.law {
        crate::scenario::mpm::MaterialLaw::CriticalDruckerPrager(law) => law,
        _ => unreachable!("a checked job with grains has a law that softens"),
    }
}

fn write<C: ContactLaw<Plane>>(
    file: &std::path::Path,
    (grains, bodies, vertices): &mut Rested<C>,
) -> Result<(), Error> {
    let mut tables = Vec::from(tables::of_grains(grains));
    tables.push(to_table("bodies", bodies, &mut Body::blank()));
    tables.push(to_table("membranes", vertices, &mut Vertex::blank()));
    write_state(file, &State { attributes: Default::default(), tables })
}

fn read<C: ContactLaw<Plane>>(file: &std::path::Path) -> Result<Rested<C>, Error> {
    let mut state = read_state(file)?;
    let bodies = tables::rows(&state, "bodies", &Body::blank())?;
    Ok((tables::to_grains(&mut state)?, bodies, tables::rows(&state, "membranes", &Vertex::blank())?))
}
