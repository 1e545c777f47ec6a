//! From what was typed to what it means: defaults filled in, every number within its range, and the checks that need more
//! than one key.

use std::path::{Path, PathBuf};

use super::Output;
use super::raw::{Reader, Typed};
use super::stable::{Bound, governing};
use crate::base::error::Error;

mod assembly;
mod body;
mod checks;
mod contact;
mod granular;
mod limits;
mod material;
mod membrane;
mod mpm;
mod mpm_checks;
mod shear;

pub use assembly::assembly;
pub use checks::BYPASS;
pub(crate) use checks::margin_in_words;
pub use material::KEYS as MATERIAL_KEYS;
pub use mpm::mpm;
pub use shear::scenario;

const DEPTH_DEFAULT: f64 = 0.01;
/// The folder of finished packings, beside the job.
const CACHE_DEFAULT: &str = "cache";
/// Edge of a block in mean diameters of discs, where only grains ask for blocks.
pub const BLOCK_OF_DISCS: f64 = 12.0;
/// Cundall 1989.
const PACKING_FRICTION_DEFAULT: f64 = 0.01;
/// Thrown without overlap one after the other, discs jam at 0.547.
const PACKING_FRACTION_DEFAULT: f64 = 0.45;
const PACKING_ENERGY_RATIO_DEFAULT: f64 = 1e-4;
/// Skin of the neighbour list in mean diameters.
const SKIN_DEFAULT: f64 = 0.1;
/// Rows, frames and checkpoints of a run.
const ROWS_DEFAULT: f64 = 500.0;
const FRAMES_DEFAULT: f64 = 20.0;
const CHECKPOINTS_DEFAULT: f64 = 10.0;
/// What a node that dies may take along at most, s.
const CHECKPOINT_WALL_DEFAULT: f64 = 600.0;

/// The name becomes a folder, so it keeps to letters that every file system takes.
fn name(top: &Reader<'_>) -> Result<String, Error> {
    let name = top.text("name");
    if is_plain(&name) {
        return Ok(name);
    }
    Err(top.refusal(
        "name",
        "is refused: it names the run's folder, so write letters, digits, \"_\", \"-\" and \".\" only, a letter or digit first.",
    ))
}

fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    name.chars().all(plain) && name.starts_with(|c: char| c.is_ascii_alphanumeric()) && name.len() <= 100
}

/// The folder that relative paths of a job start from.
fn folder_of(file: &str) -> PathBuf {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf())
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

fn output(table: &Reader<'_>, duration: f64, step: f64) -> Result<Output, Error> {
    let interval = |key: &str, count: f64| -> Result<f64, Error> {
        let interval = table.number_or(key, (duration / count).max(step));
        if interval < step {
            let problem =
                format!("is shorter than one time step. Write at least time.step = {} s.", digits_above(step));
            return Err(table.refusal(key, &problem));
        }
        limits::refuse_rows(table, key, duration, interval)?;
        Ok(interval)
    };
    Ok(Output {
        series_interval: interval("series_interval", ROWS_DEFAULT)?,
        frame_interval: interval("frame_interval", FRAMES_DEFAULT)?,
        checkpoint_interval: interval("checkpoint_interval", CHECKPOINTS_DEFAULT)?,
        checkpoint_steps: table.count_or("checkpoint_steps", 0),
        checkpoint_wall_interval: table.number_or("checkpoint_wall_interval", CHECKPOINT_WALL_DEFAULT),
        checkpoints_kept: table.count_or("checkpoints_kept", 3) as usize,
        checkpoints_for_good: table.count_or("checkpoints_for_good", 0) as usize,
        contact_frames: false,
    })
}

/// The same of a job that has contacts.
fn output_with_contacts(table: &Reader<'_>, duration: f64, step: f64) -> Result<Output, Error> {
    Ok(Output { contact_frames: table.flag_or("contact_frames", false), ..output(table, duration, step)? })
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

/// A number for a sentence, without the noise of binary fractions.
fn digits(value: f64) -> String {
    significant(value, 10)
}

/// Ten digits, never less than the value, so that a least value copied from a message is enough.
fn digits_above(value: f64) -> String {
    let rounded = format!("{value:.9e}");
    if rounded.parse().is_ok_and(|rounded: f64| rounded >= value) {
        return digits(value);
    }
    let (_, exponent) = rounded.split_once('e').expect("scientific notation has an e");
    let last: f64 = format!("0.000000001e{exponent}").parse().expect("a power of ten parses");
    digits(value + last)
}

/// Three digits, cut and not rounded, so that a limit copied from a message is within the limit.
pub fn digits_below(value: f64) -> String {
    let exact = format!("{value:.16e}");
    let (mantissa, exponent) = exact.split_once('e').expect("scientific notation has an e");
    let cut: f64 = format!("{}e{exponent}", &mantissa[..4]).parse().expect("a shortened number parses");
    significant(cut, 3)
}

/// At most `count` digits, trailing zeros dropped.
pub fn significant(value: f64, count: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", count - 1).parse().expect("a formatted number parses");
    match (1e-3..1e7).contains(&rounded.abs()) || rounded == 0.0 {
        true => format!("{rounded}"),
        false => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Limits in messages are cut, so that they can be copied.
    #[test]
    fn a_limit_in_a_message_is_within_the_limit() {
        assert_eq!(digits_below(4.479_9e-7), "4.47e-7");
        assert_eq!(digits_below(0.999_99), "0.999");
        assert_eq!(digits(7.499_999_999_999_999), "7.5");
        assert_eq!(digits_above(4e-7), "4e-7");
        assert_eq!(digits_above(3.160_231_572_372_892_6e-5), "3.160231573e-5");
        assert_eq!(digits_above(9.999_999_999_4e-6), "1e-5");
    }
}
