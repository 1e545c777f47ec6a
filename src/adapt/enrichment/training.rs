//! Kinematic training (Chen et al. 2021, 4.1.1): grains of the packing go through the motion of the points that they replace.

use scree_partition::ExactSum;

use super::motion::Motion;
use super::residents::Residents;
use super::{Enriched, Vector, pressure, stress_of};
use crate::base::error::Error;
use crate::base::space::{Linear, Plane};
use crate::bodies::body::{Body, Instant};
use crate::couple::zone::Enrichment;
use crate::dem::assembly::{Constants, PUSHED_DRAG};
use crate::dem::grains::{Cold, Mover, is_body};
use crate::domain::parts::Parts;
use crate::domain::world::Settings;
use crate::prepare::reference::Lies;
use crate::prepare::sheared::{Grain, PlanarWorld};

/// What training has made, rows of this rank's blocks.
pub(super) struct Trained {
    pub grains: Vec<Grain>,
    /// Residents that touch them, with the memories of these contacts alone.
    pub touched: Vec<Grain>,
    /// Grains of plates that come with them, with the same.
    pub glued: Vec<Grain>,
}

impl Trained {
    /// Of the residents those that come with the zone, `glued` in the order of their ids, are handed to their plates again.
    pub fn seat(&mut self, glued: &[Grain]) {
        let mover = |id| glued.binary_search_by_key(&id, |grain| grain.cold.id).ok().map(|at| glued[at].cold.mover);
        self.glued = self.touched.extract_if(.., |row| mover(row.cold.id).is_some()).collect();
        for row in &mut self.glued {
            row.cold.script = Vector::zero();
            row.hot.velocity = Vector::zero();
            row.hand_to(mover(row.cold.id).expect("it was found"));
        }
        self.touched.retain(|row| !row.contacts.is_empty());
    }
}

/// A world of the chosen grains alone, its rim moved along the continuum's path, everything inside free. Where the material ends nothing
/// moves with it: bodies come along as they have come, and what else held grains of the packing there, a membrane, holds on with the force
/// that it had, and drags them along with the continuum. Residents beside them go along the continuum's path as well, and at last to where they stand.
pub(super) fn train(
    world: &mut PlanarWorld,
    (training, depth): (&Enrichment, f64),
    motion: &Motion,
    mut grains: Vec<Grain>,
    held: &Confinement<'_>,
    enriched: &mut Enriched,
) -> Result<Trained, Error> {
    for grain in grains.iter_mut().filter(|grain| held.is_led(grain.cold.id.0)) {
        grain.cold.mover = Mover::Script;
    }
    let grains = if world.transport.rank() == 0 { grains } else { Vec::new() };
    let of = &world.settings;
    let constants = Constants { first_kick: 0.5, first_advance: 0.0, ..of.grains.clone() };
    let settings = Settings { grains: constants, grain_steps: 1, loads: Vec::new(), ..of.clone() };
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
        let (body, start, now) = (&world.bodies[number], motion.times[0], world.time());
        let along = way_of(body, [from, to], now);
        let rest = body.displacement - way_of(body, [start, now], now) - seat(number);
        (along + rest * ((to - from) / (now - start))) * share
    };
    let parts = Parts::fresh(grains, Vec::new(), touched.iter().map(at_start).collect(), world.assembly.cell);
    let mut apart = PlanarWorld::new(settings, world.subdomain.layout.clone(), world.transport, 0, parts)?;
    apart.assembly.walls.laws =
        touched.iter().filter_map(|number| world.assembly.walls.laws.get(*number).cloned()).collect();
    hold_open(&mut apart, held);

    let dt = apart.settings.grains.dt;
    let mut before: Lead = Box::new(|_| Vector::zero());
    for leg in 0..motion.times.len() - 1 {
        let ends = [motion.times[leg], motion.times[leg + 1]];
        let duration = (ends[1] - ends[0]) / training.training_speed;
        let steps = (duration / dt).round().max(1.0);
        let along: Lead = Box::new(move |cold| {
            let to = match held.residents.get(cold.id.0) {
                Some(resident) if leg + 2 == motion.times.len() => resident.displacement,
                Some(resident) => motion.displacement(leg + 1, &resident.led_from),
                None => motion.displacement(leg + 1, &cold.origin),
            };
            let led_from = held.residents.get(cold.id.0).map_or(cold.origin, |resident| resident.led_from);
            (to - motion.displacement(leg, &led_from)) * (1.0 / (steps * dt))
        });
        follow(&mut apart, held, [&before, &along]);
        before = along;
        for (body, number) in apart.bodies.iter_mut().zip(&touched) {
            let velocity = way(*number, ends) * (1.0 / (steps * dt));
            body.path = vec![Instant { time: 0.0, velocity, spin: Linear::zero() }];
        }
        run_steps(&mut apart, steps as u64)?;
    }
    apart.bodies.iter_mut().for_each(|body| body.path.clear());
    let rest = (training.training_rest * apart.step as f64).round();
    let still: Lead = Box::new(|_| Vector::zero());
    follow(&mut apart, held, [&before, &still]);
    run_steps(&mut apart, rest as u64)?;
    let is_squeezed = release(&mut apart, held, (depth, enriched.stress_points))?;
    if is_squeezed {
        return Err(Error::Run("a grain presses on another far harder than grains do in the mean".into()));
    }
    let energies = apart.energies()?;
    enriched.training_energy_ratio = energies.kinetic_grains / energies.elastic_grains;
    enriched.training_steps = apart.step;
    enriched.stress_grains = stress_of_new(&mut apart, held, depth)?;
    apart.rebuild()?;
    world.load_balance.learn(&apart.load_balance);
    let is_resident = |id: u64| held.residents.get(id).is_some();
    let mut grains = apart.rows().0;
    drop(apart);
    let mut touched: Vec<Grain> = grains.extract_if(.., |row| is_resident(row.cold.id.0)).collect();
    touched
        .iter_mut()
        .for_each(|row| row.contacts.retain(|(partner, _)| !is_body(*partner) && !is_resident(partner.0)));
    Ok(Trained { grains, touched, glued: Vec::new() })
}

/// Bodies that grains touch, by their numbers.
fn touched_bodies(world: &PlanarWorld) -> Vec<usize> {
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

/// Who holds grains that are trained, by their ids, rising: the continuum those of the rim, or around grains that come back those that stay points, and whatever does so those where the
/// material ends.
pub(super) struct Confinement<'a> {
    pub led: &'a [u64],
    pub border: &'a [u64],
    /// Grains beside them that stand already.
    pub residents: &'a Residents,
    pub lies: Lies<'a>,
    /// Where the packing's bodies stood, as displacements, m.
    pub seats: &'a [Vector],
}

impl Confinement<'_> {
    fn is_led_by_continuum(&self, id: u64) -> bool {
        self.led.binary_search(&id).is_ok()
    }

    /// Whether a grain moves as it is told to.
    fn is_led(&self, id: u64) -> bool {
        self.is_led_by_continuum(id) || self.residents.get(id).is_some()
    }
}

/// Grains at the border are pushed from now on by what their contacts leave open as they stand. A piece that is cut there is under one
/// stress throughout: they bear as much of it as the specimen does at its start, next to nothing at a free surface.
fn hold_open(apart: &mut PlanarWorld, held: &Confinement<'_>) {
    if held.border.is_empty() {
        return;
    }
    apart.evaluate_contacts();
    let (grains, gravity) = (&mut apart.assembly.grains, apart.settings.grains.field.gravity);
    for row in 0..grains.owned {
        let cold = &mut grains.cold[row];
        if cold.mover == Mover::Free && held.border.binary_search(&cold.id.0).is_ok() {
            cold.script = match held.lies {
                Lies::Whole | Lies::Around | Lies::Kept(_) => -(grains.force[row] + gravity * grains.hot[row].mass),
                Lies::Tiled(start) => grains.force[row] * -start.stress_share(&cold.origin),
            };
        }
    }
    grains.push_as_told();
}

/// How grains are let go between two looks at them: so many steps, in which all are damped by so much per step.
struct Release {
    steps: u64,
    damping: f64,
}

/// A few grains that are pressed together: their overlaps shrink by a few per cent in each step.
const RELEASE_OF_ONE: Release = Release { steps: 20, damping: 0.5 };
/// All of a zone some tens of grains deep, which comes apart within a thousand steps, a small zone within tens: seldom looks would let its
/// pressure fall far below what is wanted.
const RELEASE_OF_ALL: Release = Release { steps: 4, damping: 0.02 };
/// How many times as hard as contacts among free grains in the mean one of the rim may press, and looks at most for it not to.
const PRESSED_MAX: f64 = 12.0;
const LOOKS_FOR_ONE: u64 = 20;
/// How many times the pressure of the points that they replace grains may bear, and looks at most for them to bear no more than it. Grains
/// that shear dilate where points as yet do not, and what enters under more than its share swells and is the looser for it.
const PRESSURE_MAX: f64 = 1.1;
const LOOKS_FOR_ALL: u64 = 2500;

/// Grains of the rim were moved each by itself, and overlap where the continuum strained much; and where it bears next to nothing, as under a
/// free surface, a strain of a thousandth that grains and points do not share makes a hundred times its stress. They are let go against
/// heavy damping, before anything moves that could throw them, for as short a time as it takes. Whether grains that come back are pressed together
/// all the same, which keeps them away.
fn release(
    apart: &mut PlanarWorld,
    held: &Confinement<'_>,
    (depth, stress_points): (f64, [f64; 3]),
) -> Result<bool, Error> {
    let damping = apart.settings.grains.field.damping;
    let wanted = pressure(&stress_points);
    let is_loaded = wanted > 0.0 && pressure(&stress_of_new(apart, held, depth)?) > PRESSURE_MAX * wanted;
    let mut looks = 0;
    while looks < LOOKS_FOR_ONE && is_squeezed(apart, held)? {
        let_go(apart, held, &RELEASE_OF_ONE)?;
        looks += 1;
    }
    looks = 0;
    while is_loaded && looks < LOOKS_FOR_ALL && pressure(&stress_of_new(apart, held, depth)?) > wanted {
        let_go(apart, held, &RELEASE_OF_ALL)?;
        looks += 1;
    }
    apart.settings.grains.field.damping = damping;
    Ok(matches!(held.lies, Lies::Kept(_)) && is_squeezed(apart, held)?)
}

/// Of those that are free and do not stand already, Pa.
fn stress_of_new(apart: &mut PlanarWorld, held: &Confinement<'_>, depth: f64) -> Result<[f64; 3], Error> {
    stress_of(apart, depth, |id| held.residents.get(id.0).is_none())
}

/// Some steps in which grains of the rim move as they like, against damping.
fn let_go(apart: &mut PlanarWorld, held: &Confinement<'_>, release: &Release) -> Result<(), Error> {
    let is_led_by_continuum =
        |cold: &&mut Cold<Plane>| cold.mover == Mover::Script && held.is_led_by_continuum(cold.id.0);
    let mut freed = 0;
    for cold in apart.assembly.grains.cold.iter_mut().filter(is_led_by_continuum) {
        (cold.mover, cold.script) = (Mover::Free, Vector::zero());
        freed += 1;
    }
    apart.settings.grains.field.damping.mass = release.damping / apart.settings.grains.dt;
    let mut freed = [freed];
    apart.transport.sum(&mut freed);
    if freed[0] > 0 {
        apart.rebuild()?;
    }
    run_steps(apart, release.steps)
}

/// Whether a grain of the rim presses on another, or on a body, far harder than free ones do on each other. Collective.
fn is_squeezed(apart: &mut PlanarWorld, held: &Confinement<'_>) -> Result<bool, Error> {
    apart.refresh_ghosts();
    let (grains, law) = (&apart.assembly.grains, apart.law());
    let on_bodies = apart.assembly.walls.bearings(law, grains, (&apart.bodies, &apart.assembly.cell), [0.0; 2]);
    let on_grains = (0..grains.owned).flat_map(|row| apart.assembly.contacts.bearings(law, grains, row, [0.0; 2]));
    let (mut of_free, mut hardest) = (ExactSum::<2>::new(), [0.0f64]);
    for bearing in on_grains.chain(on_bodies) {
        let force = bearing.force.norm();
        let [one, other] = [grains.cold[bearing.row as usize].id.0, bearing.partner.0];
        if held.residents.get(one).is_some() && held.residents.get(other).is_some() {
            // As they press in the run, whatever is done here.
            continue;
        }
        if held.is_led(one) || held.is_led(other) {
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

/// The velocity at which the continuum leads a grain.
type Lead<'a> = Box<dyn Fn(&Cold<Plane>) -> Vector + 'a>;

/// Grains that are led go on with another velocity than before, and so does what drags those of the border along: a grain that comes off
/// its neighbours there goes with the continuum, and not away.
fn follow(apart: &mut PlanarWorld, held: &Confinement<'_>, [before, now]: [&Lead<'_>; 2]) {
    let (drag, grains) = (PUSHED_DRAG / apart.settings.grains.dt, &mut apart.assembly.grains);
    for (cold, hot) in grains.cold.iter_mut().zip(&grains.hot) {
        match cold.mover {
            Mover::Script => cold.script = now(cold),
            Mover::Free if held.border.binary_search(&cold.id.0).is_ok() => {
                cold.script += (now(cold) - before(cold)) * (drag * hot.weight * hot.mass);
            }
            _ => (),
        }
    }
    grains.push_as_told();
}

fn run_steps(world: &mut PlanarWorld, steps: u64) -> Result<(), Error> {
    for _ in 0..steps {
        world.advance()?;
    }
    Ok(())
}
