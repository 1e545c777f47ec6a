//! Packings made ahead: inserted, compressed under low friction, kept in a file named by everything that shaped them.

use std::path::Path;

use scree_io::column::State;
use scree_io::store;
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::record::{Cargo, to_table};
use crate::base::space::{Linear, Plane, Space};
use crate::bodies::body::{Body, Servo, Shape, Side};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, PenaltySpring};
use crate::dem::law::{law_of, memory_words};
use crate::domain::layout::{Ground, Layout, RIM_CELLS};
use crate::domain::parts::Parts;
use crate::domain::rebuild::is_glued;
use crate::domain::stop::{self, Wish};
use crate::domain::transfer;
use crate::domain::world::{Settings, World};
use crate::job::{Scenario, derived};
use crate::law::contact::Contact;
use crate::mpm::membrane::Membranes;
use crate::mpm::stress::material_of;
use crate::prepare::cache::{Found, Place};
use crate::prepare::loose::{UPPER, glue_layers, glued_reach, insert};
use crate::prepare::making::{Leg, Look, Making};
use crate::prepare::{grain_file, point_world, recipe};
use crate::store::checkpoint::{self, Drawn};
use crate::store::tables;

/// The world of these jobs.
pub type PlanarWorld<'t> = World<'t, Plane>;
/// Its grains.
pub type Grain = GrainRow<Plane>;

type Vector = <Plane as Space>::Vector;

/// A finished packing: rows on rank 0 only, in canonical order; the rest everywhere.
pub struct Packing {
    /// Free ones and those glued to plates.
    pub grains: Vec<Grain>,
    /// Distance of the plates' faces, m.
    pub height: f64,
    /// Mass of the free grains, kg, and their solid volume fraction between the faces.
    pub mass: f64,
    /// Solid volume fraction of the free grains between the faces.
    pub fraction: f64,
}

/// Cells beyond the plates' faces on either side; a multiple of the block, and more than splines and glued rows reach.
fn margin_cells(scenario: &Scenario) -> usize {
    let block = scenario.decomposition.cells_per_block;
    // Two cells that nothing may enter, and room for the layers glued to the plates.
    let glued = (glued_reach(scenario) / scenario.continuum.cell).ceil() as usize;
    (2 + glued.max(2)).div_ceil(block) * block
}

/// The domain for material of `height` m between the faces: the lower face at y = 0 on a line of nodes, room for
/// dilation above.
pub fn layout_for(scenario: &Scenario, height: f64) -> Result<Layout, Error> {
    let cell = scenario.continuum.cell;
    let block = scenario.decomposition.cells_per_block;
    let margin = margin_cells(scenario);
    let columns = (scenario.specimen.width / cell).round() as usize;
    let rows = ((height / cell).ceil() as usize + 2 * margin + 2).div_ceil(block) * block;
    let corner = [0.0, -(margin as f64) * cell, 0.0];
    let ground = Ground {
        rim: [[RIM_CELLS; 2]; 3],
        shape: scenario.scheme.shape,
        point_half: 0.5 / scenario.scheme.points_per_cell as f64,
        ..Ground::open([columns, rows, 1], block, cell, corner, [true, false, false])
    };
    Layout::new::<Plane>(ground).map_err(Error::User)
}

/// Settings of a world of this job's grains alone, with constants of its own in their law.
pub fn settings_for(scenario: &Scenario, contact: &Contact) -> Settings<Plane> {
    let settings = point_world::settings(&scenario.on_grid(), material_of(&scenario.material.law), law_of(contact));
    Settings { grain_steps: 1, ..settings }
}

/// Settings of the run of this job.
pub fn settings_of_run(scenario: &Scenario) -> Settings<Plane> {
    let settings = settings_for(scenario, &scenario.contact);
    Settings { grain_steps: derived::grain_steps(scenario), ..settings }
}

/// The cell of a layout that does not deform.
pub fn cell_of(layout: &Layout) -> Cell<Plane> {
    let mut corner = Vector::zero();
    let mut lengths = Vector::zero();
    for axis in 0..Plane::DIMENSION {
        corner[axis] = layout.corner[axis];
        lengths[axis] = layout.cells[axis] as f64 * layout.cell;
    }
    Cell::cuboid(corner, lengths, layout.periodic)
}

/// The job's packing: read from its grain file, from the cache, or made now and cached.
pub fn prepare(scenario: &Scenario, transport: &dyn Transport) -> Result<Packing, Error> {
    if let Some(file) = &scenario.grains.file {
        let grains = transfer::agree(transport, on_root(transport, || grain_file::read(scenario, file)))?;
        return measured(scenario, transport, grains.unwrap_or_default(), scenario.specimen.height);
    }
    let place = Place::new(&scenario.packing.cache, "packing", &recipe::sheared(scenario));
    let memory_words = memory_words::<Plane>(&scenario.contact);
    let (grains, height) =
        match place.find(transport, scenario.output.save_every(), |state| of_state(state, memory_words))? {
            Found::There(found) => {
                let (grains, height) = found.unwrap_or_default();
                (grains, share(transport, height))
            }
            Found::ToMake(mut making) => {
                let (mut grains, height) = make(scenario, &mut making)?;
                making.finish(|| state_of(&mut grains, &scenario.contact, height, &mut []))?;
                (grains, height)
            }
        };
    measured(scenario, transport, grains, height)
}

/// That many steps of a packing in the making, unless any rank is asked to stop.
pub fn steps<S: Space>(world: &mut World<'_, S>, count: u64) -> Result<(), Error> {
    for _ in 0..count {
        world.wish = stop::wish();
        world.advance()?;
        if world.wish_agreed == Wish::Stop {
            return Err(Error::Stopped(world.step));
        }
    }
    Ok(())
}

/// Runs on rank 0 only.
pub fn on_root<T>(transport: &dyn Transport, work: impl FnOnce() -> Result<T, Error>) -> Result<Option<T>, Error> {
    if transport.rank() == 0 { work().map(Some) } else { Ok(None) }
}

/// Rank 0's number, on every rank.
pub(crate) fn share(transport: &dyn Transport, number: f64) -> f64 {
    let bytes = transport.broadcast(number.to_le_bytes().to_vec());
    f64::from_le_bytes(bytes.try_into().expect("eight bytes were sent"))
}

fn measured(scenario: &Scenario, transport: &dyn Transport, grains: Vec<Grain>, height: f64) -> Result<Packing, Error> {
    let mass = share(transport, grains.iter().filter(|grain| !is_glued(grain)).map(|grain| grain.hot.mass).sum());
    let volume = scenario.specimen.width * height * scenario.specimen.depth;
    Ok(Packing { grains, height, mass, fraction: mass / (scenario.grains.density * volume) })
}

/// Inertial number that the compressing plate keeps below, I = (v/H) d sqrt(rho/P).
const INERTIAL_NUMBER: f64 = 1e-3;
/// Steps between two looks at whether the packing is at rest.
const LOOK_EVERY: u64 = 1000;
/// Steps after which a packing that has not equilibrated is given up.
const STEPS_MAX: u64 = 20_000_000;

/// Inserts and compresses. Rows on rank 0.
fn make(scenario: &Scenario, making: &mut Making) -> Result<(Vec<Grain>, f64), Error> {
    let transport = making.transport();
    let inserted = insert(scenario)?;
    let stress = scenario.packing.stress;
    let load = stress * scenario.specimen.width * scenario.specimen.depth;
    let layout = layout_for(scenario, inserted.height)?;
    let settings = settings_for(scenario, &scenario.contact.while_compressed(scenario.packing.friction));
    let drawn = Drawn {
        cell: cell_of(&layout),
        bodies: pressing_plates(scenario, inserted.height, load),
        membranes: Membranes::default(),
    };
    making.begin(0);
    let (parts, step) = match making.taken_up::<Plane>(&scenario.contact)? {
        Some(snapshot) => {
            let (parts, progress) = checkpoint::restore(snapshot, |_, _| Ok(drawn), transport)?;
            (parts, progress.step)
        }
        None => {
            tracing::info!(grains = inserted.grains.len(), "making a packing");
            let grains = if transport.rank() == 0 { inserted.grains } else { Vec::new() };
            (Parts::fresh(grains, Vec::new(), drawn.bodies, drawn.cell), 0)
        }
    };
    let mut world = PlanarWorld::new(settings, layout, transport, step, parts)?;
    let goal = scenario.packing.energy_ratio_max;
    let leg = Leg { name: "compressing", rebuilds: false, look_every: LOOK_EVERY, calm_looks: 1, goal };
    making.equilibrate(&mut world, leg, |_, _| (), |world, _| {
        let ratio = world.unrest()?;
        let plate = &mut world.bodies[UPPER as usize];
        let force = plate.impulse[1] / (LOOK_EVERY as f64 * scenario.time.step) / load;
        plate.impulse = Vector::zero();
        if world.step > STEPS_MAX {
            return Err(Error::Run(format!(
                "the packing has not equilibrated after {} steps: kinetic/elastic energy {ratio:.1e} (wanted {goal:.1e}), load {force:.3} of the target; raise `packing.energy_ratio_max` or check `contact` and `time.step`",
                world.step,
            )));
        }
        let rests = (force - 1.0).abs() < 0.01 && ratio < goal;
        let words = format!("height {:.4e} m, load {force:.3} of the target", world.bodies[UPPER as usize].face());
        Ok(Look { rests, ratio, words })
    })?;
    world.rebuild()?;
    let height = world.bodies[UPPER as usize].face();
    let (rows, _) = world.rows();
    let mut rows = transfer::gather(transport, rows)?.unwrap_or_default();
    let height = glue_layers(scenario, height, &mut rows);
    rows.iter_mut().for_each(settle);
    Ok((rows, height))
}

/// A plate that rests, and one that presses on what is inserted below it.
fn pressing_plates(scenario: &Scenario, height: f64, load: f64) -> Vec<Body<Plane>> {
    let grains = &scenario.grains;
    let speed_max = INERTIAL_NUMBER * scenario.specimen.height / grains.diameter_mean
        * (scenario.packing.stress / grains.density).sqrt();
    let servo = Servo {
        direction: Vector::new(0.0, 1.0),
        force: load,
        mass: scenario.loading.plate_mass,
        damping: scenario.loading.plate_damping,
        speed_max,
    };
    let lower = Body::new("lower", Shape::Plate { side: Side::Below, face: 0.0 });
    let upper = Body::new("upper", Shape::Plate { side: Side::Above, face: height });
    vec![lower, Body { servo: Some(servo), ..upper }]
}

/// A grain of a finished packing is at rest, its origin is where it is, and nothing is left of what tied it to membranes: a file has no penalty springs,
/// and what comes out of one must be what went into it.
pub fn settle<S: Space>(grain: &mut GrainRow<S>) {
    grain.spring = PenaltySpring::loose();
    grain.hot.velocity = S::Vector::zero();
    grain.hot.spin = S::Spin::zero();
    grain.cold.origin = grain.hot.position;
    grain.cold.home = grain.hot.position;
    grain.cold.image = [0; 3];
}

/// A packing under a contact law as a state, with the bodies that its grains rest at.
pub fn state_of<S: Space>(grains: &mut [GrainRow<S>], contact: &Contact, height: f64, bodies: &mut [Body<S>]) -> State {
    let attributes = [(HEIGHT.to_string(), format!("{height:?}"))].into();
    let mut tables = Vec::from(tables::of_grains(grains, memory_words::<S>(contact)));
    if !bodies.is_empty() {
        tables.push(to_table("bodies", bodies, &mut Body::blank()));
    }
    State { attributes, tables }
}

const HEIGHT: &str = "state.height";

/// Where the bodies of a packing stood, as displacements, m; none of one between plates.
pub fn bodies_of(state: &State) -> Result<Vec<Body<Plane>>, Error> {
    match state.tables.iter().any(|table| table.name == "bodies") {
        true => tables::rows(state, "bodies", &Body::blank()),
        false => Ok(Vec::new()),
    }
}

/// Grains, under a law with so many words of memory, and height of what [`state_of`] made.
pub fn of_state(mut state: State, memory_words: usize) -> Result<(Vec<GrainRow<Plane>>, f64), Error> {
    let height = state.attributes.get(HEIGHT).and_then(|height| height.parse().ok());
    let height = height.ok_or_else(|| Error::User("the packing's height is missing".to_string()))?;
    Ok((tables::to_grains(&mut state, memory_words)?, height))
}

/// Reads the packing in a run's folder.
pub fn read_state(file: &Path) -> Result<State, Error> {
    store::read(file).map_err(|error| Error::User(error.to_string()))
}

#[cfg(test)]
mod tests {
    use scree_partition::Solo;

    use super::*;
    use crate::domain::stop::lives;
    use crate::job::Job;

    const QUICKSTART: &str = include_str!("../../jobs/quickstart.toml");

    /// The packing of a job with a cache of its own, and in how many lives of so many steps it has been made.
    fn made(steps: u64) -> (String, u64) {
        let folder = tempfile::tempdir().unwrap();
        let cache = format!("packing.cache={}", folder.path().display());
        let small = [
            "specimen.width=12 mm",
            "specimen.height=24 mm",
            "continuum.weak=[]",
            "enrichment.distance=6 mm",
            "packing.energy_ratio_max=1e-2",
        ];
        let sets: Vec<String> = small.map(String::from).into_iter().chain([cache]).collect();
        let scenario = match Job::parse(QUICKSTART, "job.toml", &sets) {
            Ok(Job::Shear(scenario)) => scenario,
            other => panic!("{other:?}"),
        };
        let (made, lives) = lives::of(steps, || prepare(&scenario, &Solo));
        (format!("{:?} {}", made.grains, made.height), lives)
    }

    /// What a look has set is saved with it.
    #[test]
    fn a_packing_in_short_lives_is_that_of_one_life() {
        let (wanted, _) = made(u64::MAX);
        let (found, lives) = made(1013);
        assert!(lives > 10, "{lives} lives");
        assert!(found == wanted, "another packing after {lives} lives");
    }
}
