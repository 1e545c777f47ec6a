//! Jobs on a grid (`[grid]`): a continuum of points; or with `[grains]` grains from the start, points that grains replace where a band
//! persists, or points that stand for grains.

use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::{Plane, Space};
use crate::dem::law::{SharedLaw, law_of, no_law};
use crate::domain::accounts::ledger::Accounts;
use crate::domain::parts::Parts;
use crate::domain::step::rves::RveEvent;
use crate::domain::transfer;
use crate::domain::world::{Settings, World};
use crate::job::Method;
use crate::job::figures::steps;
use crate::job::mpm::{self, Granular, Mpm, Origin, Watch};
use crate::mpm::membrane::Vertex;
use crate::mpm::stress::{SharedMaterial, material_of};
use crate::mpm::track::Instants;
use crate::prepare::reference::{Lies, StartState};
use crate::prepare::rves::{self, Levels};
use crate::prepare::sheared;
use crate::prepare::specimen::{self, Specimen};
use crate::prepare::{packed, point_world};
use crate::run::Core;
use crate::run::adaptive::{Adaptive, Finder, tell_band};
use crate::run::columns::{self, Columns, Work, grid};
use crate::run::experiment::{Experiment, Picture, Setup};
use crate::run::folder::Folder;
use crate::run::planar_shear::TRACKS;
use crate::store::checkpoint::{Drawn, Progress};

/// A continuum alone, with its space and its law, which may be grains at every point.
pub struct Points<'s, S: Space> {
    job: &'s Mpm,
    law: SharedMaterial<S>,
}

impl<'s, S: Space> Points<'s, S> {
    /// With the law of `[material]`.
    pub fn new(job: &'s Mpm) -> Self {
        Self { job, law: material_of(&job.material.law) }
    }
}

impl<S: Space> Setup for Points<'_, S> {
    type Space = S;

    fn experiment(&self) -> Experiment<'_, S> {
        let job = self.job;
        let mut columns = vec![clock(), Columns::new(["points"], |core| Ok(vec![core.world.points_total as f64]))];
        columns.push(grid::means(job.grid.depth));
        columns.push(grid::energies_of_points());
        columns.extend(job.mesh.is_some().then(grid::hourglass));
        columns.extend(job.mesh.is_some().then(grid::unbalanced));
        columns.extend(job.ledger.then(|| grid::account_of_points(job.averages_volume())));
        columns.extend(job.oracle.is_some().then(grid::oracle));
        columns.extend([grid::extents(), grid::reactions(job), grid::membranes(job)]);
        columns.extend(job.rves().is_some().then(|| grid::rves(job)));
        columns.extend(job.follow.iter().map(|follow| grid::followed(&follow.name, nearest(job, &follow.place))));
        if job.rves().is_some() {
            let of = |follow: &mpm::Followed| grid::followed_rve(&follow.name, nearest(job, &follow.place));
            columns.extend(job.follow.iter().map(of));
        }
        let drawn = job.follow.iter().filter(|follow| follow.frames);
        Experiment {
            drawn_rves: drawn.map(|follow| (follow.name.clone(), nearest(job, &follow.place))).collect(),
            picture: Picture {
                depth: job.grid.depth,
                may_have_grains: false,
                may_have_points: true,
                has_elements: job.mesh.is_some(),
                flagged: job.oracle.is_some(),
            },
            // The first band that persists is told, and left alone.
            watch: Box::new(|core| {
                tell_rve_events(core)?;
                match &job.oracle {
                    Some(Watch { diameter, oracle }) => tell_band(core, oracle, *diameter),
                    None => Ok(()),
                }
            }),
            ..of_job(job, columns)
        }
    }

    /// Of the grains of RVEs, where there are some.
    fn law(&self) -> SharedLaw<S> {
        self.job.rves().map_or_else(no_law, |(granular, _)| law_of(&granular.piece.contact))
    }

    fn material(&self) -> SharedMaterial<S> {
        self.law.clone()
    }

    fn begin<'t>(
        &self,
        _: &mut Option<Folder>,
        transport: &'t dyn Transport,
    ) -> Result<(World<'t, S>, Progress), Error> {
        let progress = Progress::default();
        let Some(of_grains) = self.job.rves() else {
            return Ok((point_world::world(self.job, &self.law, transport)?, progress));
        };
        let levels = Levels::of(self.job, of_grains, transport)?;
        rves::refuse_stiff::<S>(self.job, levels.modulus_most())?;
        let mut job = self.job.clone();
        job.material.density = levels.density(of_grains.0);
        let mut parts = point_world::parts(&job, &self.law, transport)?;
        parts.rves = levels.give(&job, of_grains, &self.law, &mut parts.points);
        parts.packings = levels.packings();
        Ok((self.world_at(&progress, parts, transport)?, progress))
    }

    fn drawn(&self, _: &Progress, vertices: Vec<Vertex<S>>) -> Result<Drawn<S>, Error> {
        point_world::drawn(self.job, vertices)
    }

    fn world_at<'t>(
        &self,
        progress: &Progress,
        parts: Parts<S>,
        transport: &'t dyn Transport,
    ) -> Result<World<'t, S>, Error> {
        let rves = self.job.rves().map(|of_grains| rves::material(of_grains, &parts.packings));
        let layout = point_world::layout::<S>(self.job)?;
        let settings = Settings { rves, ..point_world::settings(self.job, self.law.clone(), Setup::law(self)) };
        let parts = point_world::laid_out(parts, self.job, &layout);
        World::new(settings, layout, transport, progress.step, parts)
    }
}

/// What RVEs have come through in the steps just done, in `log.jsonl`.
fn tell_rve_events<S: Space>(core: &mut Core<S>) -> Result<(), Error> {
    let Some(events) = core.world.take_rve_events() else { return Ok(()) };
    let step = core.world.step;
    core.on_root(|outputs| {
        for RveEvent { point, place, events, jump } in events {
            let counts = [
                ("rve_loosened", u32::from(events.loosened)),
                ("rve_returned", u32::from(events.returned)),
                ("rve_replicated", events.replicated),
            ];
            for (event, times) in counts.into_iter().filter(|(_, times)| *times > 0) {
                let place = &place[..S::DIMENSION];
                outputs.log(event, step, serde_json::json!({ "point": point.0, "place": place, "times": times }))?;
            }
            if events.renewed {
                let told =
                    serde_json::json!({ "point": point.0, "place": &place[..S::DIMENSION], "stress_jump": jump });
                outputs.log("rve_renewed", step, told)?;
            }
        }
        Ok(())
    })
}

/// What all jobs on a grid have, with these columns.
fn of_job<'s, S: Space>(job: &'s Mpm, columns: Vec<Columns<'s, S>>) -> Experiment<'s, S> {
    Experiment {
        job: job.to_toml(),
        output: &job.output,
        steps: steps(job.end, job.step),
        accounts: Accounts { grains: false, points: job.ledger },
        allows_unstable: false,
        picture: Picture {
            depth: job.grid.depth,
            may_have_grains: false,
            may_have_points: false,
            has_elements: false,
            flagged: false,
        },
        drawn_rves: Vec::new(),
        columns,
        watch: Box::new(|_| Ok(())),
        strain: None,
    }
}

fn clock<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["step", "time"], |core| Ok(vec![core.world.step as f64, core.world.time()]))
}

/// The point that is followed.
fn nearest(job: &Mpm, wanted: &[f64; 3]) -> PointId {
    let index = mpm::figures::nearest_point(job, wanted).expect("a checked job follows points that are there");
    PointId(job.number(index))
}

/// A material that grains are, or may take the place of, with its space and its law.
pub struct Grains<'s, S: Space> {
    job: &'s Mpm,
    granular: &'s Granular,
    law: SharedMaterial<S>,
    /// Puts grains where they are due, where the job wants that.
    adapt: Adapt<S>,
}

type Adapt<S> = fn(&Adaptive<'_>, &mut Core<'_, S>) -> Result<(), Error>;

/// Works of the account of the grains' energy.
const WORKS: [Work; 3] = [
    ("work_bodies", |balance| balance.work_bodies),
    ("work_gravity", |balance| balance.work_gravity),
    ("work_nodes", |balance| balance.work_nodes),
];

impl<'s> Grains<'s, Plane> {
    /// Grains that may take the place of points.
    pub fn hybrid(job: &'s Mpm, granular: &'s Granular) -> Self {
        Self { adapt: |how, core| how.adapt(core, None), ..Self::new(job, granular) }
    }
}

impl<'s, S: Space> Grains<'s, S> {
    /// Grains alone, or points alone.
    pub fn new(job: &'s Mpm, granular: &'s Granular) -> Self {
        Self { job, granular, law: material_of(&job.material.law), adapt: |_, _| Ok(()) }
    }

    /// Tracks, oracle, and in a hybrid its grains.
    fn watch(&self, core: &mut Core<S>) -> Result<(), Error> {
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
                (self.adapt)(&Adaptive { finder, enrichment, lies, depth: self.job.grid.depth }, core)
            }
            (Method::Mpm, Finder::Oracle(oracle, diameter)) => tell_band(core, oracle, *diameter),
            _ => Ok(()),
        }
    }

    /// Where grains begin, bodies and membranes are where these were in equilibrium.
    fn at_start(&self, made: Specimen<S>, transport: &dyn Transport) -> Result<Parts<S>, Error> {
        let Specimen { grains, bodies, vertices, fraction, .. } = made;
        let (job, granular) = (self.job, self.granular);
        let (grains, points, bodies, vertices) = if granular.begins_as_grains() {
            (grains, Vec::new(), bodies, vertices)
        } else {
            let mut job = job.clone();
            job.material.density = granular.piece.matter.density * fraction;
            if job.is_told_by_packing() {
                job.material.law = job.material.law.with_fraction(fraction);
            }
            let mut points = point_world::points(&job, &self.law, transport);
            if granular.is_heterogeneous {
                point_world::vary_as_grains_do(&mut points, (&job, &self.law), &grains, transport)?;
            }
            (Vec::new(), points, point_world::bodies(&job), point_world::vertices(&job))
        };
        let cell = point_world::cell::<S>(job, &point_world::layout::<S>(job)?);
        let mut parts = Parts::fresh(grains, points, bodies, cell);
        parts.membranes = point_world::hung(job, vertices)?;
        Ok(parts)
    }
}

impl<S: Space> Setup for Grains<'_, S> {
    type Space = S;

    fn experiment(&self) -> Experiment<'_, S> {
        let job = self.job;
        let mut columns = vec![clock(), columns::counts(), grid::means(job.grid.depth), columns::energies()];
        let may_have_points = self.granular.method != Method::Dem;
        if job.ledger {
            columns.push(columns::account_of_grains(&WORKS));
            columns.extend(may_have_points.then(|| grid::account_beside_grains(job.averages_volume())));
        }
        columns.extend([grid::oracle(), grid::extents(), grid::reactions(job), grid::membranes(job)]);
        columns.extend((self.granular.method == Method::Hybrid).then(columns::shear_in_zones));
        columns.extend(grid::is_enclosed(job).then(|| grid::enclosed_volume(job.grid.depth)));
        columns.extend(job.follow.iter().map(|follow| grid::followed(&follow.name, nearest(job, &follow.place))));
        Experiment {
            picture: Picture {
                depth: job.grid.depth,
                may_have_grains: true,
                may_have_points,
                has_elements: false,
                flagged: may_have_points && job.oracle.is_some(),
            },
            accounts: Accounts { grains: job.ledger, points: job.ledger && may_have_points },
            watch: Box::new(|core| self.watch(core)),
            ..of_job(job, columns)
        }
    }

    fn law(&self) -> SharedLaw<S> {
        law_of(&self.granular.piece.contact)
    }

    fn material(&self) -> SharedMaterial<S> {
        self.law.clone()
    }

    fn begin<'t>(
        &self,
        folder: &mut Option<Folder>,
        transport: &'t dyn Transport,
    ) -> Result<(World<'t, S>, Progress), Error> {
        let (job, granular) = (self.job, self.granular);
        let mut made = specimen::specimen((job, granular), transport)?;
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
            instants: Instants { times: Vec::new(), every: (steps(job.end, job.step) / TRACKS).max(1) },
            ..Progress::default()
        };
        let parts = self.at_start(made, transport)?;
        Ok((self.world_at(&progress, parts, transport)?, progress))
    }

    fn drawn(&self, _: &Progress, vertices: Vec<Vertex<S>>) -> Result<Drawn<S>, Error> {
        point_world::drawn(self.job, vertices)
    }

    fn world_at<'t>(
        &self,
        progress: &Progress,
        parts: Parts<S>,
        transport: &'t dyn Transport,
    ) -> Result<World<'t, S>, Error> {
        let (job, granular) = (self.job, self.granular);
        let settings = point_world::settings(job, self.law.clone(), law_of(&granular.piece.contact));
        let layout = point_world::layout::<S>(job)?;
        let parts = point_world::laid_out(parts, job, &layout);
        let mut world = World::new(settings, layout, transport, progress.step, parts)?;
        world.assembly.walls.laws = specimen::laws_of_bodies(job, granular);
        Ok(world)
    }
}

/// Where the material of a job begins, and under which share of the piece's mean `stress`, Pa.
struct Start<'s> {
    job: &'s Mpm,
    stress: f64,
}

type Vector = <Plane as Space>::Vector;

impl StartState for Start<'_> {
    fn is_material(&self, place: &Vector) -> bool {
        self.job.region_at(&[place[0], place[1], 0.0]).is_some()
    }

    fn stress_share(&self, place: &Vector) -> f64 {
        let stress = point_world::stress_at::<Plane>(self.job, &[place[0], place[1], 0.0]);
        -0.5 * (stress[0] + stress[3]) / self.stress
    }
}
