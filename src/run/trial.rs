//! What a run takes here and now: some steps of its world, and each kind of output, timed one by one by the loop of a run
//! itself.

use std::time::{Duration, Instant};

use crate::base::error::Error;
use crate::base::space::Space;
use crate::domain::world::World;
use crate::run::experiment::Experiment;
use crate::run::folder::Folder;
use crate::run::output::Outputs;
use crate::run::{Cadence, Core, Options, Run};
use crate::store::checkpoint::Progress;

/// Wall times of a world's steps and outputs, s, on cores that nobody else uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Of a pass of the loop: a step of the continuum, and as many of grains as belong to it.
    pub pass: f64,
    /// Of a row of the series, a frame and a checkpoint.
    pub row: f64,
    /// Added to files that are there.
    pub frame: f64,
    /// With the sync of the series before it.
    pub checkpoint: f64,
    /// Grains and points of the world.
    pub grains: u64,
    /// Of elements, one each.
    pub points: u64,
}

/// Stretches of passes, the median of which counts; and the share of their time that passes before the first of them.
const STRETCHES: u32 = 5;
const WARM_UP: u32 = 4;
/// Times that each kind of output is written.
const ROWS: u64 = 5;
const FILES: u32 = 2;

/// Passes for so long, then outputs into the folder, which is the caller's to remove. Nothing comes of them but their
/// times.
pub fn trial<S: Space>(
    experiment: Experiment<'_, S>,
    mut world: World<S>,
    progress: Progress,
    folder: Folder,
    time: Duration,
) -> Result<Trial, Error> {
    world.open_accounts(experiment.accounts);
    let options = Options::new(folder.dir().to_path_buf(), 1);
    let outputs = Outputs::create(folder, &experiment, 0)?;
    let core = Core::new(world, progress, &options, (Some(outputs), &experiment));
    let mut run = Run::new(experiment, core)?;
    // Nothing is due, and there is no last step. Short jobs are not gone beyond, for their grains may leave the domain there.
    let half_way = run.steps / 2;
    run.steps = u64::MAX;
    run.cadence = Cadence { series: u64::MAX, frame: u64::MAX, checkpoint: u64::MAX, checkpoint_steps: None };
    // Files are made by the first of each kind; the others are added to them.
    run.write_frame()?;

    run.passes_for(time / WARM_UP, half_way)?;
    let mut stretches = Vec::new();
    for _ in 0..STRETCHES {
        stretches.push(run.passes_for(time / STRETCHES, half_way)?);
    }
    stretches.sort_by(f64::total_cmp);
    let pass = stretches[stretches.len() / 2];

    run.cadence.series = 1;
    let row = timed(|| (0..ROWS).try_for_each(|_| run.pass()))? / ROWS as f64 - pass;
    let frame = timed(|| (0..FILES).try_for_each(|_| run.write_frame()))? / f64::from(FILES);
    let checkpoint = timed(|| (0..FILES).try_for_each(|_| run.save()))? / f64::from(FILES);
    let (grains, points) = (run.core.world.grains_total, run.core.world.points_total);
    Ok(Trial { pass, row: row.max(0.0), frame, checkpoint, grains, points })
}

/// Wall time of some work, s, without what it waited for a core that others had.
fn timed(work: impl FnOnce() -> Result<(), Error>) -> Result<f64, Error> {
    let (since, waited_before) = (Instant::now(), waited());
    work().map(|()| (since.elapsed().as_secs_f64() - (waited() - waited_before)).max(0.0))
}

/// Time that this thread has waited for a core so far, s; zero where the system does not tell.
fn waited() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = told.split_whitespace().nth(1).and_then(|word| word.parse::<u64>().ok());
    1e-9 * nanoseconds.unwrap_or(0) as f64
}

impl<S: Space> Run<'_, '_, S> {
    /// Passes until the time is over or that step is reached, at least one; what one of them took, s.
    fn passes_for(&mut self, time: Duration, last: u64) -> Result<f64, Error> {
        let (until, mut passes) = (Instant::now() + time, 0);
        let took = timed(|| {
            while passes == 0 || (Instant::now() < until && self.core.world.step < last) {
                self.pass()?;
                passes += 1;
            }
            Ok(())
        })?;
        Ok(took / f64::from(passes))
    }
}
