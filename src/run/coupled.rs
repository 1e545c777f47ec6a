//! Jobs on a grid whose material is grains from the start, points that grains replace where a band persists, or points alone:
//! one job, three methods (`[grid]` with `[grains]`).

use scree_io::column::State;
use scree_io::frames::Frame;
use scree_partition::{ExactSum, Transport};
use serde_json::{Value, json};

use crate::adapt::watch;
use crate::base::error::Error;
use crate::base::space::{Plane, Space};
use crate::dem::grains::Mover;
use crate::dem::law::memory_words;
use crate::domain::grid::REACTIONS;
use crate::domain::rebuild::Parts;
use crate::domain::transfer;
use crate::job::mpm::{Granular, Mpm, Origin, Watch, figures};
use crate::job::{Job, Method, Output};
use crate::law::material::CriticalDruckerPrager;
use crate::mpm::track::Instants;
use crate::observe::frame::frame;
use crate::prepare::reference::{Lies, StartState};
use crate::prepare::sheared::{self, PlanarWorld};
use crate::prepare::specimen::{self, Specimen};
use crate::prepare::{packed, point_world};
use crate::run::adaptive::{Adaptive, Finder};
use crate::run::continuum::columns;
use crate::run::folder::Folder;
use crate::run::planar_shear::TRACKS;
use crate::run::{self, Core, Experiment, Options, Outcome};
use crate::store::checkpoint::Snapshot;
use crate::store::checkpoint::{self, Progress};

/// The job.
pub struct Coupled<'s> {
    job: &'s Mpm,
    granular: &'s Granular,
}

type PlanarCore<'t> = Core<'t, Plane, CriticalDruckerPrager>;
type Vector = <Plane as Space>::Vector;

/// Columns of `series.csv` before those of extents, bodies and membranes.
const HEADER: [&str; 18] = [
    "step",
    "time",
    "grains",
    "points",
    "mass",
    "volume",
    "centre_x",
    "centre_y",
    "momentum_x",
    "momentum_y",
    "stress_xx",
    "stress_xy",
    "stress_yx",
    "stress_yy",
    "kinetic_grains",
    "elastic_grains",
    "kinetic_points",
    "elastic_points",
];

/// Runs a job from its start.
pub fn start(
    (job, granular): (&Mpm, &Granular),
    options: &Options,
    folder: &mut Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let mut made = specimen::specimen(job, granular, transport)?;
    if granular.method == Method::Hybrid {
        let write = |folder: &mut Folder| {
            folder.write_packing(&match &mut made.piece {
                Some(piece) => packed::state_of(piece, &granular.piece.contact),
                None => sheared::state_of(&mut made.grains, &granular.piece.contact, 0.0, &mut made.bodies),
            })
        };
        transfer::agree(transport, folder.as_mut().map_or(Ok(()), write))?;
    }
    let progress = Progress {
        fraction_start: made.fraction,
        instants: Instants { times: Vec::new(), every: (figures::steps(job) / TRACKS).max(1) },
        ..Progress::default()
    };
    let world = at_start(job, granular, made, transport)?;
    run::begin(Coupled { job, granular }, world, progress, options, folder)
}

/// The world at time zero: where grains begin, bodies and membranes are as these have been brought to rest.
fn at_start<'t>(
    job: &Mpm,
    granular: &Granular,
    made: Specimen,
    transport: &'t dyn Transport,
) -> Result<PlanarWorld<'t>, Error> {
    let Specimen { grains, bodies, vertices, fraction, .. } = made;
    let (grains, points, bodies, vertices) = match granular.method {
        Method::Dem => (grains, Vec::new(), bodies, vertices),
        Method::Hybrid | Method::Mpm => {
            let mut job = job.clone();
            job.material.density = granular.piece.matter.density * fraction;
            let points = point_world::points(&job, &CriticalDruckerPrager::of(specimen::law_of(&job)), transport);
            (Vec::new(), points, point_world::bodies(&job), point_world::vertices(&job))
        }
    };
    let cell = point_world::cell::<Plane>(&point_world::layout::<Plane>(job)?);
    let mut parts = Parts::fresh(grains, points, bodies, cell);
    parts.membranes = point_world::hung(job, vertices)?;
    world_of(job, granular, 0, parts, transport)
}

fn world_of<'t>(
    job: &Mpm,
    granular: &Granular,
    step: u64,
    parts: Parts<Plane, CriticalDruckerPrager>,
    transport: &'t dyn Transport,
) -> Result<PlanarWorld<'t>, Error> {
    let law = CriticalDruckerPrager::of(specimen::law_of(job));
    let settings = point_world::settings(job, law, Some(granular.piece.contact));
    let mut world = PlanarWorld::new(settings, point_world::layout::<Plane>(job)?, transport, step, parts)?;
    world.assembly.walls.laws = specimen::laws_of_bodies(job, granular);
    Ok(world)
}

/// Continues a run from a state that rank 0 holds.
pub fn resume(
    (job, granular): (&Mpm, &Granular),
    state: Option<State>,
    options: &Options,
    folder: Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let read = |state| Snapshot::from_state(state, memory_words::<Plane>(&granular.piece.contact));
    let snapshot = transfer::agree(transport, state.map(read).transpose())?;
    let draw = |_: &Progress, vertices| point_world::drawn(job, vertices);
    let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
    let mut world = world_of(job, granular, progress.step, parts, transport)?;
    world.resume_reactions(&progress.reactions)?;
    run::go_on_with(Coupled { job, granular }, world, progress, options, folder)
}

/// Where the material of a job begins, and under which share of the piece's mean `stress`, Pa.
struct Start<'s> {
    job: &'s Mpm,
    stress: f64,
}

impl StartState for Start<'_> {
    fn is_material(&self, place: &Vector) -> bool {
        self.job.region_at(&[place[0], place[1], 0.0]).is_some()
    }

    fn stress_share(&self, place: &Vector) -> f64 {
        let stress = point_world::stress_at::<Plane>(self.job, &[place[0], place[1], 0.0]);
        -0.5 * (stress[0] + stress[3]) / self.stress
    }
}

/// Sums over points and free grains: mass, mass times place, momentum, volume, and volume times stress of points.
const SUMS: usize = 10;

impl Coupled<'_> {
    /// Whether membranes joined end to end have an inside: one ring, or lines.
    fn is_enclosed(&self) -> bool {
        match &self.job.membranes[..] {
            [] => false,
            [_] => true,
            several => several.iter().all(|membrane| !membrane.is_closed()),
        }
    }

    /// Mass, kg, volume, m3, centre of mass, m, momentum, N s, and mean stress over the volume, Pa: of points as they are, of grains
    /// over their share of space at the packing fraction of the start. Collective.
    fn means(&self, core: &mut PlanarCore) -> Result<Vec<f64>, Error> {
        let (world, depth, fraction) = (&mut core.world, self.job.grid.depth, core.progress.fraction_start);
        let mut sums = ExactSum::<SUMS>::new();
        let mut add = |mass: f64, volume: f64, place: <Plane as Space>::Vector, velocity: <Plane as Space>::Vector| {
            sums.add(0, mass);
            sums.add(5, volume);
            for axis in 0..2 {
                sums.add(1 + axis, mass * place[axis]);
                sums.add(3 + axis, mass * velocity[axis]);
            }
        };
        for (hot, cold) in world.continuum.points.hot.iter().zip(&world.continuum.points.cold) {
            let place = hot.position + world.assembly.cell.shift(cold.image);
            add(hot.weight * hot.mass, hot.weight * hot.volume * hot.volume_ratio(), place, hot.velocity);
        }
        for (hot, cold) in
            world.assembly.grains.hot[..world.assembly.grains.owned].iter().zip(&world.assembly.grains.cold)
        {
            if cold.mover == Mover::Free {
                let volume = Plane::grain_volume(hot.radius, depth) / fraction;
                let place = hot.position + world.assembly.cell.shift(cold.image);
                add(hot.weight * hot.mass, hot.weight * volume, place, hot.velocity);
            }
        }
        for hot in &world.continuum.points.hot {
            let stress = hot.kirchhoff();
            (0..4).for_each(|component| sums.add(6 + component, hot.weight * hot.volume * stress[component]));
        }
        world.refresh_ghosts();
        let (law, grains) = (world.law(), &world.assembly.grains);
        let times = world.contact_times();
        let on_bodies = world.assembly.walls.bearings(law, grains, (&world.bodies, &world.assembly.cell), times);
        let on_grains = (0..grains.owned).flat_map(|row| world.assembly.contacts.bearings(law, grains, row, times));
        for bearing in on_grains.chain(on_bodies) {
            let moment = bearing.moment() * bearing.weight;
            (0..4).for_each(|component| sums.add(6 + component, moment[component]));
        }
        let of = world.reduce(sums)?;
        let [mass, volume] = [of[0], of[5]];
        let mut row = vec![mass, volume, of[1] / mass, of[2] / mass, of[3], of[4]];
        // Column by column in memory, row by row in the file.
        row.extend([0, 2, 1, 3].map(|component| of[6 + component] / volume));
        Ok(row)
    }
}

impl Experiment for Coupled<'_> {
    type Space = Plane;
    type Material = CriticalDruckerPrager;

    fn job(&self) -> String {
        Job::Mpm(self.job.clone()).to_toml()
    }

    fn output(&self) -> &Output {
        &self.job.output
    }

    fn steps(&self) -> u64 {
        figures::steps(self.job)
    }

    fn header(&self) -> Vec<String> {
        let mut names: Vec<String> = HEADER.map(String::from).into();
        names.extend(columns::OF_ORACLE.map(String::from));
        names.extend(columns::of_extents::<Plane>());
        names.extend(columns::of_bodies::<Plane>(self.job));
        names.extend(columns::of_membranes(self.job));
        if self.is_enclosed() {
            names.push("enclosed_volume".to_string());
        }
        names
    }

    /// Tracks, oracle, and in a hybrid its grains.
    fn watch(&mut self, core: &mut PlanarCore) -> Result<(), Error> {
        let Granular { method, enrichment, reference, known, .. } = self.granular;
        let finder = match (known, &self.job.oracle) {
            (Some(known), None) => Finder::Known(known),
            (_, Some(Watch { diameter, oracle })) => Finder::Oracle(oracle, *diameter),
            (None, None) => return Ok(()),
        };
        let start = Start { job: self.job, stress: specimen::stress_of(self.granular) };
        let lies = match reference {
            Origin::Specimen => Lies::Whole,
            Origin::Piece => Lies::Tiled(&start),
        };
        match (method, &finder) {
            (Method::Hybrid, _) => {
                let how = Adaptive { finder, enrichment, lies, depth: self.job.grid.depth };
                how.adapt(self, core, None).map(|_| ())
            }
            (Method::Mpm, Finder::Oracle(oracle, diameter)) => crate::run::adaptive::tell_band(core, oracle, *diameter),
            _ => Ok(()),
        }
    }

    fn row(&mut self, core: &mut PlanarCore) -> Result<Vec<f64>, Error> {
        let means = self.means(core)?;
        let energies = core.world.energies()?;
        let world = &mut core.world;
        let (grains, points) = (world.grains_total as f64, world.points_total as f64);
        let mut row = vec![world.step as f64, world.time(), grains, points];
        row.extend(means);
        row.extend([
            energies.kinetic_grains,
            energies.elastic_grains,
            energies.kinetic_points,
            energies.elastic_points,
        ]);
        row.extend([core.progress.oracle.flagged.len() as f64, f64::from(u8::from(core.progress.enriched_step > 0))]);
        row.extend(columns::row_of_extents(world));
        let reactions: [f64; REACTIONS] = world.take_reactions()?;
        core.progress.kept.take(&reactions);
        let duration = (world.step - core.progress.series_step) as f64 * self.job.step;
        row.extend(columns::row_of_bodies(world, &reactions, duration));
        row.extend(columns::row_of_membranes(world));
        if self.is_enclosed() {
            row.push(world.continuum.membranes.enclosed() * self.job.grid.depth);
        }
        Ok(row)
    }

    fn frame(&mut self, core: &mut PlanarCore) -> Result<Option<Frame>, Error> {
        let may_have_points = self.granular.method != Method::Dem;
        let mut frame = frame(&mut core.world, self.job.grid.depth, core.progress.fraction_start, may_have_points)?;
        if let (Some(frame), Some(_), true) = (&mut frame, &self.job.oracle, may_have_points) {
            frame.fields.push(watch::flagged_rows(&core.world, &core.progress.oracle, &frame.positions));
        }
        Ok(frame)
    }

    fn words(&self, core: &PlanarCore) -> String {
        let (grains, points) = (core.world.grains_total, core.world.points_total);
        format!("time {:.4e} s, {grains} grains and {points} points", core.world.time())
    }

    fn figures(&self, _: &PlanarCore) -> Value {
        json!({})
    }
}
