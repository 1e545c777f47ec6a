//! Jobs that no machine holds, no run ends, or that outrun themselves in one step: refused before anything is allocated.

use super::{digits, digits_above, significant};
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::job::assembly::{Assembly, Body, Packed, Preparation, Source};
use crate::job::mpm::forecast::memory;
use crate::job::raw::{Reader, Typed};
use crate::job::{Scenario, derived, figures};

/// Steps are counted in the twelve digits of a checkpoint's name.
const STEPS_MAX: f64 = 999_999_999_999.0;
/// Rows of a series and frames: more fill disks, and nobody looks at them.
const ROWS_MAX: f64 = 1e8;
const FRAMES_MAX: f64 = 1e6;
/// Bytes of all ranks together.
const MEMORY_MAX: f64 = 1e12;
/// Blocks, of which every rank keeps a list.
const BLOCKS_MAX: f64 = 1e7;
/// Mean grains that a cell has room for; the search for neighbours has a place for each.
const PLACES_MAX: f64 = 1e9;
/// Share of its length by which a cell may deform in a step.
const STRAIN_OF_STEP_MAX: f64 = 0.01;
/// Mean overlap in diameters from which on grains are squeezed through each other.
const OVERLAP_MAX: f64 = 0.25;
/// Steps in which grains cross their own size under the stress that compresses them: a packing takes hundreds of such
/// times, and is given up after twenty million steps.
const STEPS_OF_PACKING_MAX: f64 = 1e6;

/// A run to the end at `duration` s that `end` sets takes too many steps, or none.
pub fn refuse_steps(typed: &Typed, duration: f64, step: f64, end: &str) -> Result<(), Error> {
    let steps = duration / step;
    if steps <= STEPS_MAX {
        return Ok(());
    }
    let message = format!(
        "makes {} steps until the end at {} s ({end}), and at most {STEPS_MAX} are counted. Take a longer step or an earlier end.",
        significant(steps, 3),
        significant(duration, 3)
    );
    Err(typed.refusal("time", "step", &message))
}

/// An interval of output that writes without end.
pub fn refuse_rows(table: &Reader<'_>, key: &str, duration: f64, interval: f64) -> Result<(), Error> {
    let (max, what) = match key {
        "frame_interval" => (FRAMES_MAX, "frames"),
        "series_interval" => (ROWS_MAX, "rows of series.csv"),
        _ => return Ok(()),
    };
    if duration / interval <= max {
        return Ok(());
    }
    let message = format!(
        "makes {} {what} until the end at {} s, and at most {max:e} are allowed. Write at least {} s.",
        significant(duration / interval, 3),
        significant(duration, 3),
        digits_above(duration / max)
    );
    Err(table.refusal(key, &message))
}

/// What planar shear takes in memory, before anything of it is counted in whole numbers.
pub fn refuse_size_of_shear(job: &Scenario, typed: &Typed) -> Result<(), Error> {
    let block = derived::block_edge(job);
    let blocks = (job.specimen.width / block) * (job.specimen.height / block);
    if blocks > BLOCKS_MAX {
        let message = format!(
            "makes {} blocks of {} cells of {} mm, and at most {BLOCKS_MAX:e} are allowed. Take a smaller specimen, larger cells, or more decomposition.cells_per_block.",
            significant(blocks, 3),
            job.decomposition.cells_per_block,
            digits(1e3 * job.continuum.cell)
        );
        return Err(typed.refusal("specimen", "width", &message));
    }
    let points = derived::points(job) as f64;
    let grains = figures::grains(&job.grains_of_specimen()).unwrap_or_default() as f64;
    let of_method = if job.method.has_points() { points } else { 0.0 };
    let memory = memory(Some(&job.on_grid()), of_method, derived::share_of_grains(job) * grains);
    if memory > MEMORY_MAX {
        let message = format!(
            "makes a specimen of {} grains and {} points, which take about {} GB of memory, and at most {} GB are allowed. Take a smaller specimen, larger grains, or larger cells.",
            significant(grains, 3),
            significant(points, 3),
            significant(1e-9 * memory, 3),
            MEMORY_MAX / 1e9
        );
        return Err(typed.refusal("specimen", "width", &message));
    }
    Ok(())
}

/// What a grid takes in memory; `bytes`: with all of its points.
pub fn refuse_memory_of_grid(typed: &Typed, bytes: f64) -> Result<(), Error> {
    if bytes <= MEMORY_MAX {
        return Ok(());
    }
    let message = format!(
        "makes a grid that takes about {} GB of memory, and at most {} GB are allowed. Take larger cells.",
        significant(1e-9 * bytes, 3),
        MEMORY_MAX / 1e9
    );
    Err(typed.refusal("grid", "cell", &message))
}

/// A cell that is cut into too many blocks, or has room for too many grains. One that is compressed first is as large as its
/// grains.
pub fn refuse_size_of_cell(job: &Assembly, typed: &Typed) -> Result<(), Error> {
    if matches!(job.source, Source::Packed(Packed { preparation: Preparation::Compress { .. }, .. })) {
        return Ok(());
    }
    let pieces = |edge: f64| -> f64 {
        let along = |axis: usize| ((job.cell.upper[axis] - job.cell.lower[axis]) / edge).max(1.0);
        (0..job.cell.dimension).map(along).product()
    };
    let (blocks, places) = (pieces(job.block), pieces(job.matter.diameter_mean));
    if blocks > BLOCKS_MAX {
        let message = format!(
            "makes {} blocks of {} mm, and at most {BLOCKS_MAX:e} are allowed. Take a smaller cell, or a larger decomposition.block.",
            significant(blocks, 3),
            digits(1e3 * job.block)
        );
        return Err(typed.refusal("cell", "upper", &message));
    }
    if places > PLACES_MAX {
        let message = format!(
            "makes a cell with room for {} mean grains, and at most {PLACES_MAX:e} are searched for neighbours. Take a smaller cell.",
            significant(places, 3)
        );
        return Err(typed.refusal("cell", "upper", &message));
    }
    Ok(())
}

/// What moves so fast that a step carries it through grains.
pub fn refuse_speeds(job: &Assembly, typed: &Typed) -> Result<(), Error> {
    let strain = figures::rate_max(job) * job.step;
    if strain > STRAIN_OF_STEP_MAX {
        let message = format!(
            "deforms the cell by {} of its length in one step, and at most {STRAIN_OF_STEP_MAX} is allowed. Lower the rates, or take a shorter time.step.",
            significant(strain, 3)
        );
        return Err(typed.refusal("cell", "velocity_gradient", &message));
    }
    let fall = norm(job.gravity) * job.step * job.step;
    if fall > 0.5 * job.matter.diameter_mean {
        let message = format!(
            "moves a grain by {} mm in its first step, further than the mean radius. Lower it, or take a shorter time.step.",
            significant(1e3 * fall, 3)
        );
        return Err(typed.refusal("cell", "gravity", &message));
    }
    Ok(())
}

/// The same of a body among grains; `table` is the one it was typed in.
pub fn refuse_speed_of_body(body: &Body, table: &Reader<'_>, step: f64, diameter: f64) -> Result<(), Error> {
    let path = body.motion.path.iter().map(|point| norm(point.velocity)).fold(0.0, f64::max)
        + body.motion.oscillation.map_or(0.0, |sine| sine.speed());
    let servo = body.motion.servo.as_ref().map_or(0.0, |servo| servo.speed_max);
    let (key, speed) = match (path >= servo, table.has("path")) {
        (true, true) => ("path", path),
        (true, false) => ("velocity", path),
        (false, _) => ("servo", servo),
    };
    if speed * step <= 0.5 * diameter {
        return Ok(());
    }
    let message = format!(
        "moves the body by {} mm in one step, further than the mean radius of grains, which it would pass. Write at most {} m/s, or take a shorter time.step.",
        significant(1e3 * speed * step, 3),
        super::digits_below(0.5 * diameter / step)
    );
    Err(table.refusal(key, &message))
}

/// The same of the plates of planar shear.
pub fn refuse_speed_of_plates(job: &Scenario, typed: &Typed) -> Result<(), Error> {
    let length = if job.moves_grains() { 0.5 * job.grains.diameter_mean } else { 0.5 * job.continuum.cell };
    if job.loading.speed * job.time.step <= length {
        return Ok(());
    }
    let message = format!(
        "moves the plate by {} mm in one step, further than {}. Write at most {} m/s.",
        significant(1e3 * job.loading.speed * job.time.step, 3),
        if job.moves_grains() { "the mean radius of grains" } else { "half a cell" },
        super::digits_below(length / job.time.step)
    );
    Err(typed.refusal("loading", "speed", &message))
}

/// A stress that grains of this stiffness cannot bear. `number` is k_n/(p d) of it, the reciprocal of the mean overlap in
/// diameters.
pub fn refuse_squeeze(typed: &Typed, (table, key): (&str, &str), number: f64) -> Result<(), Error> {
    if number * OVERLAP_MAX >= 1.0 {
        return Ok(());
    }
    let message = format!(
        "squeezes mean grains into each other by {} of a diameter, and at most {OVERLAP_MAX} is allowed. Lower the stress, or take stiffer contacts.",
        significant(1.0 / number, 3)
    );
    Err(typed.refusal(table, key, &message))
}

/// A stress that hardly moves grains: their packing would not be finished. `time` is that in which it moves a grain by its
/// own size, s.
pub fn refuse_faint_packing(typed: &Typed, (table, key): (&str, &str), time: f64, step: f64) -> Result<(), Error> {
    if time / step <= STEPS_OF_PACKING_MAX {
        return Ok(());
    }
    let message = format!(
        "moves a grain by its own size in {} steps, and a packing is made within {STEPS_OF_PACKING_MAX:e} of such steps or not at all. Raise the stress, or take a longer time.step.",
        significant(time / step, 3)
    );
    Err(typed.refusal(table, key, &message))
}

fn norm(vector: [f64; 3]) -> f64 {
    super::body::norm(vector)
}
