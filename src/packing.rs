//! Packings made ahead: thrown, compressed under low friction, kept in a file named by everything that shaped them.

use std::path::Path;

use scree_io::column::State;
use scree_io::store;
use scree_partition::Transport;
use sha2::{Digest, Sha256};

use crate::body::{Body, Servo, Shape, Side};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Tie};
use crate::dem::motion::Field;
use crate::dem::packing::{UPPER, glue_layers, glued_reach, throw};
use crate::error::Error;
use crate::grid::Grid;
use crate::law::contact::ContactLaw;
use crate::law::material::{CriticalDruckerPrager, MaterialLaw};
use crate::layout::Layout;
use crate::rebuild::{self, Parts, is_glued};
use crate::record::to_table;
use crate::scenario::{Contact, Scenario, derived};
use crate::servo::CellDrive;
use crate::space::{Linear, Plane, Space, Words};
use crate::stop::{self, Wish};
use crate::transfer::Cargo;
use crate::world::{Settings, World};
use crate::{grain_file, tables, transfer};

/// The world that jobs between plates run in.
pub type PlanarWorld<'t, C> = World<'t, Plane, C, CriticalDruckerPrager>;
/// Its grains.
pub type Grain<C> = rebuild::Row<Plane, C>;

type Vector = <Plane as Space>::Vector;

/// A finished packing: rows on rank 0 only, in canonical order; the rest everywhere.
pub struct Packing<C: ContactLaw<Plane>> {
    pub grains: Vec<Grain<C>>,
    /// Distance of the plates' faces, m.
    pub height: f64,
    /// Mass of the free grains, kg, and their packing fraction between the faces.
    pub mass: f64,
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
    let corner = [0.0, -(margin as f64) * cell];
    let layout = Layout::plane([columns, rows], block, cell, corner).map_err(Error::User)?;
    Ok(layout.with_points(scenario.continuum.points_per_cell))
}

/// Settings of a world of this job's grains alone, with constants of its own in their law.
pub fn settings_for<C: ContactLaw<Plane>>(
    scenario: &Scenario,
    contact: &Contact,
) -> Settings<Plane, C, CriticalDruckerPrager> {
    Settings {
        dt: scenario.time.step,
        grain_steps: 1,
        skin: scenario.decomposition.skin,
        grid: Grid::blend(scenario.continuum.flip),
        loads: Vec::new(),
        contact: C::from_job(contact).expect("the run was given the job's law"),
        material: CriticalDruckerPrager::new(&scenario.continuum),
        field: Field::default(),
        drive: CellDrive::default(),
        first_kick: 0.5,
    }
}

/// Settings of the run of this job.
pub fn settings_of_run<C: ContactLaw<Plane>>(scenario: &Scenario) -> Settings<Plane, C, CriticalDruckerPrager> {
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
pub fn prepare<C: ContactLaw<Plane>>(scenario: &Scenario, transport: &dyn Transport) -> Result<Packing<C>, Error> {
    if let Some(file) = &scenario.grains.file {
        let grains = transfer::agree(transport, on_root(transport, || grain_file::read(scenario, file)))?;
        return measured(scenario, transport, grains.unwrap_or_default(), scenario.specimen.height);
    }
    let file = scenario.packing.cache.join(format!("packing-{}.h5", key(scenario)));
    let cached = on_root(transport, || if file.exists() { read(&file).map(Some) } else { Ok(None) });
    let cached = transfer::agree(transport, cached)?.flatten();
    let found = transport.broadcast(vec![u8::from(cached.is_some())])[0] == 1;
    let (grains, height) = if found {
        let (grains, height) = cached.unwrap_or_default();
        (grains, share(transport, height))
    } else {
        let (mut grains, height) = make::<C>(scenario, transport)?;
        let written = on_root(transport, || write(&file, &mut grains, height));
        transfer::agree(transport, written)?;
        (grains, height)
    };
    measured(scenario, transport, grains, height)
}

/// That many steps of a packing in the making, unless any rank is asked to stop.
pub fn steps<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>>(
    world: &mut World<'_, S, C, L>,
    count: u64,
) -> Result<(), Error> {
    for _ in 0..count {
        world.wish = stop::wish();
        world.advance()?;
        if world.wish_agreed == Wish::Stop {
            return Err(Error::Stopped(world.step));
        }
    }
    Ok(())
}

/// Grain-steps between two words on how far a packing is: some seconds of one core.
const TELL_EVERY: u64 = 50_000_000;

/// Whether a look after every so many steps of a packing is one of those that are told.
pub fn is_told(step: u64, look_every: u64, grains: u64) -> bool {
    let looks = TELL_EVERY / (look_every * grains).max(1);
    (step / look_every).is_multiple_of(looks.max(1))
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

fn measured<C: ContactLaw<Plane>>(
    scenario: &Scenario,
    transport: &dyn Transport,
    grains: Vec<Grain<C>>,
    height: f64,
) -> Result<Packing<C>, Error> {
    let mass = share(transport, grains.iter().filter(|grain| !is_glued(grain)).map(|grain| grain.hot.mass).sum());
    let volume = scenario.specimen.width * height * scenario.specimen.depth;
    Ok(Packing { grains, height, mass, fraction: mass / (scenario.grains.density * volume) })
}

/// Names everything that shapes a packing.
fn key(scenario: &Scenario) -> String {
    let specimen = &scenario.specimen;
    let text = format!(
        "packing 4 seed {} plate {:?} {:?} specimen {:?} {:?} {:?} grains {:?} {:?} {:?} contact {:?} friction {:?} start {:?} stress {:?} ratio {:?} step {:?} cell {:?} block {:?} skin {:?} glued {:?}",
        scenario.seed,
        scenario.loading.plate_mass,
        scenario.loading.plate_damping,
        specimen.width,
        specimen.height,
        specimen.depth,
        scenario.grains.diameter_mean,
        scenario.grains.diameter_deviation,
        scenario.grains.density,
        scenario.contact.without_cohesion(),
        scenario.packing.friction,
        scenario.packing.fraction_start,
        scenario.packing.stress,
        scenario.packing.energy_ratio_max,
        scenario.time.step,
        scenario.continuum.cell,
        scenario.decomposition.cells_per_block,
        scenario.decomposition.skin,
        glued_reach(scenario),
    );
    name_of(&text)
}

/// Inertial number that the compressing plate keeps below, I = (v/H) d sqrt(rho/P).
const INERTIAL_NUMBER: f64 = 1e-3;
/// Steps between two looks at whether the packing is at rest.
const LOOK_EVERY: u64 = 1000;
/// Steps after which a packing that has not come to rest is given up.
const STEPS_MAX: u64 = 20_000_000;

/// Throws and compresses. Rows on rank 0.
fn make<C: ContactLaw<Plane>>(scenario: &Scenario, transport: &dyn Transport) -> Result<(Vec<Grain<C>>, f64), Error> {
    let thrown = throw(scenario)?;
    tracing::info!(grains = thrown.grains.len(), "making a packing");
    let stress = scenario.packing.stress;
    let area = scenario.specimen.width * scenario.specimen.depth;
    let speed_max = INERTIAL_NUMBER * scenario.specimen.height / scenario.grains.diameter_mean
        * (stress / scenario.grains.density).sqrt();
    let servo = Servo {
        direction: Vector::new(0.0, 1.0),
        force: stress * area,
        mass: scenario.loading.plate_mass,
        damping: scenario.loading.plate_damping,
        speed_max,
    };
    let lower = Body::new("lower", Shape::Plate { side: Side::Below, face: 0.0 });
    let upper = Body::new("upper", Shape::Plate { side: Side::Above, face: thrown.height });
    let bodies = vec![lower, Body { servo: Some(servo), ..upper }];
    let layout = layout_for(scenario, thrown.height)?;
    let settings = settings_for(scenario, &scenario.contact.while_compressed(scenario.packing.friction));
    let grains = if transport.rank() == 0 { thrown.grains } else { Vec::new() };
    let cell = cell_of(&layout);
    let parts = Parts::fresh(grains, Vec::new(), bodies, cell);
    let mut world = PlanarWorld::<C>::new(settings, layout, transport, 0, parts)?;

    let load = stress * area;
    loop {
        steps(&mut world, LOOK_EVERY)?;
        let energies = world.energies()?;
        let plate = &mut world.bodies[UPPER as usize];
        let force = plate.impulse[1] / (LOOK_EVERY as f64 * scenario.time.step);
        plate.impulse = Vector::zero();
        let at_load = (force / load - 1.0).abs() < 0.01;
        let at_rest = energies.kinetic_grains < scenario.packing.energy_ratio_max * energies.elastic_grains;
        if at_load && at_rest {
            break;
        }
        if world.step > STEPS_MAX {
            return Err(Error::Run(format!(
                "the packing has not come to rest after {} steps: kinetic/elastic energy {:.1e} (wanted {:.1e}), load {:.3} of the target; raise `packing.energy_ratio_max` or check `contact` and `time.step`",
                world.step,
                energies.kinetic_grains / energies.elastic_grains,
                scenario.packing.energy_ratio_max,
                force / load
            )));
        }
        if is_told(world.step, LOOK_EVERY, world.grains_total) {
            tracing::info!(step = world.step, height = world.bodies[1].face(), load = force / load, "compressing");
        }
    }
    world.rebuild()?;
    let height = world.bodies[UPPER as usize].face();
    let (rows, _) = world.rows();
    let mut rows = transfer::gather(transport, rows)?.unwrap_or_default();
    let height = glue_layers(scenario, height, &mut rows);
    rows.iter_mut().for_each(settle);
    Ok((rows, height))
}

/// A grain of a finished packing is at rest, its origin is where it is, and nothing is left of what tied it to membranes: a file has no ties,
/// and what comes out of one must be what went into it.
pub fn settle<S: Space, M>(grain: &mut GrainRow<S, M>) {
    grain.tie = Tie::loose();
    grain.hot.velocity = S::Vector::zero();
    grain.hot.spin = S::Spin::zero();
    grain.cold.origin = grain.hot.position;
    grain.cold.home = grain.hot.position;
    grain.cold.image = [0; 3];
}

/// Writes a packing as a file of its own.
pub fn write<M: Words<f64>>(file: &Path, grains: &mut [GrainRow<Plane, M>], height: f64) -> Result<(), Error> {
    write_between(file, grains, height, &mut [])
}

/// The same with the bodies that its grains have come to rest at.
pub fn write_between<M: Words<f64>>(
    file: &Path,
    grains: &mut [GrainRow<Plane, M>],
    height: f64,
    bodies: &mut [Body<Plane>],
) -> Result<(), Error> {
    let attributes = [("state.height".to_string(), format!("{height:?}"))].into();
    let mut tables = Vec::from(tables::of_grains(grains));
    if !bodies.is_empty() {
        tables.push(to_table("bodies", bodies, &mut Body::blank()));
    }
    write_state(file, &State { attributes, tables })
}

/// Where the bodies of a packing stood, as displacements, m; none of one between plates.
pub fn read_bodies(file: &Path) -> Result<Vec<Body<Plane>>, Error> {
    let state = read_state(file)?;
    match state.tables.iter().any(|table| table.name == "bodies") {
        true => tables::rows(&state, "bodies", &Body::blank()),
        false => Ok(Vec::new()),
    }
}

/// Reads what [`write`] wrote: grains and height.
pub fn read<M: Words<f64>>(file: &Path) -> Result<(Vec<GrainRow<Plane, M>>, f64), Error> {
    let mut state = read_state(file)?;
    let height = state.attributes.get("state.height").and_then(|height| height.parse().ok());
    let height = height.ok_or_else(|| made_again(file, &"the packing's height is missing"))?;
    Ok((tables::to_grains(&mut state)?, height))
}

/// Writes the state of a packing, its folder with it.
pub fn write_state(file: &Path, state: &State) -> Result<(), Error> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder).map_err(|error| {
            Error::User(format!(
                "{}: cannot make the folder for packings: {error}; set `packing.cache`",
                folder.display()
            ))
        })?;
    }
    store::write(file, state).map_err(|error| Error::Run(error.to_string()))
}

/// Reads the state of a packing.
pub fn read_state(file: &Path) -> Result<State, Error> {
    store::read(file).map_err(|error| made_again(file, &error))
}

fn made_again(file: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::User(format!("{error}; delete {} and it is made again", file.display()))
}

/// The name of everything that shaped a packing, as it stands in a file's name.
pub fn name_of(text: &str) -> String {
    Sha256::digest(text.as_bytes())[..8].iter().map(|byte| format!("{byte:02x}")).collect()
}
