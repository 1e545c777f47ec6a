//! From what was typed to what it means: defaults filled in, every number within its range, and the checks that need more
//! than one key.

use super::Output;
use super::raw::{Reader, Typed};
use super::stable::SAFETY_DEFAULT;
use super::stable::{Bound, governing};
use crate::base::digits::{digits, digits_above};
pub use crate::base::digits::{digits_below, significant};
use crate::base::error::Error;

mod assembly;
mod body;
mod checks;
mod granular;
mod limits;
mod material;
mod membrane;
mod mesh;
mod mpm;
mod mpm_checks;
mod shear;
#[cfg(test)]
mod tests;

pub use assembly::assembly;
pub use checks::BYPASS;
pub(crate) use checks::margin_in_words;
pub(super) use material::FILE;
pub use mpm::mpm;
pub use shear::scenario;

/// Edge of a block in mean diameters of discs, where only grains ask for blocks.
pub const BLOCK_OF_DISCS: f64 = 12.0;
pub const BLOCK_OF_SPHERES: f64 = 6.0;
/// Skin of the neighbour list in mean diameters.
const SKIN_DEFAULT: f64 = 0.1;

/// The name becomes a folder, so it keeps to letters that every file system takes.
fn check_name(top: &Reader<'_>, name: &str) {
    if !is_plain(name) {
        top.add(top.refusal(
            "name",
            "is refused: it names the run's folder, so write letters, digits, \"_\", \"-\" and \".\" only, a letter or digit first.",
        ));
    }
}

fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    name.chars().all(plain) && name.starts_with(|c: char| c.is_ascii_alphanumeric()) && name.len() <= 100
}

/// A normal distribution is cut at three deviations, which must leave something of a grain.
fn refuse_wide_sizes(grains: &Reader<'_>, mean: f64, deviation: f64) -> Result<(), Error> {
    if deviation <= 0.25 * mean {
        return Ok(());
    }
    Err(grains.refusal(
        "diameter_deviation",
        &format!(
            "is too wide: sizes are cut at three deviations, and the smallest must keep a quarter of the mean. Write at most \"{} mm\".",
            digits(250.0 * mean)
        ),
    ))
}

/// `[output]`, and whether an account of energy is kept.
fn output(table: &mut Reader<'_>, duration: f64, step: f64) -> Result<(Output, bool), Error> {
    let (mut output, mut ledger) = (Output::of_run(duration, step), false);
    output.keys(table, &mut ledger);
    let intervals = [
        ("series_interval", output.series_interval),
        ("frame_interval", output.frame_interval),
        ("checkpoint_interval", output.checkpoint_interval),
    ];
    for (key, interval) in intervals {
        if interval < step {
            let problem =
                format!("is shorter than one time step. Write at least time.step = {} s.", digits_above(step));
            return Err(table.refusal(key, &problem));
        }
        limits::refuse_rows(table, key, duration, interval)?;
    }
    Ok((output, ledger))
}

/// `bypass`: what else can be done where the job's kind allows it.
fn refuse_unstable(typed: &Typed, step: f64, bounds: &[Bound], bypass: &str) -> Result<(), Error> {
    let governing = governing(bounds);
    if step <= governing.step {
        return Ok(());
    }
    let message = format!(
        "is unstable: at most {} s is allowed ({}: {}). {}{bypass}",
        digits_below(governing.step),
        governing.cause,
        governing.formula,
        governing.remedy
    );
    Err(typed.refusal("time", "step", &message))
}
