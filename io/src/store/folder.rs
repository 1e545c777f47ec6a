//! A folder of checkpoints, `step-<12 digits>.h5`.

use std::fs;
use std::path::{Path, PathBuf};

use super::read;
use crate::column::State;
use crate::error::Error;
use crate::system::{PARTIAL, folder, refused};

const DIGITS: usize = 12;
const ENDING: &str = ".h5";

/// The file name of the checkpoint taken at `step`. Panics beyond twelve digits.
pub fn file_name(step: u64) -> String {
    assert!(step < 10_u64.pow(DIGITS as u32), "step {step} has more than {DIGITS} digits");
    format!("step-{step:012}.h5")
}

/// Where checkpoints are kept for good, within their folder.
pub const FOR_GOOD: &str = "for_good";

/// Gives a checkpoint a second name where nothing is pruned.
pub fn keep_for_good(path: &Path) -> Result<(), Error> {
    let good = folder(path).join(FOR_GOOD);
    fs::create_dir_all(&good).map_err(refused("create", &good))?;
    let kept = good.join(path.file_name().unwrap_or_default());
    // Where a file cannot have two names it is copied; one that is there already is of the same step and run.
    match fs::hard_link(path, &kept) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            fs::copy(path, &kept).map(|_| ()).map_err(refused("keep", &kept))
        }
        _ => Ok(()),
    }
}

/// All checkpoints of a folder, those kept for good with the others, each step once, newest first.
pub fn all(dir: &Path) -> Result<Vec<(u64, PathBuf)>, Error> {
    let mut found = every_file(dir)?;
    found.dedup_by_key(|(step, _)| *step);
    Ok(found)
}

/// The same, with both files of a step that is kept for good: they are one only where a file can have two names.
fn every_file(dir: &Path) -> Result<Vec<(u64, PathBuf)>, Error> {
    let mut found = newest(dir)?;
    let good = dir.join(FOR_GOOD);
    if good.is_dir() {
        found.extend(newest(&good)?);
    }
    found.sort_by_key(|(step, _)| std::cmp::Reverse(*step));
    Ok(found)
}

/// The checkpoints of a folder with their steps, newest first. Other files are passed over.
pub fn newest(dir: &Path) -> Result<Vec<(u64, PathBuf)>, Error> {
    list(dir, |rest| rest == ENDING)
}

/// The newest checkpoint that can be read in whole, those kept for good among them, and the errors of the damaged newer
/// ones, which are to be reported.
///
/// Only damage sends the search to an older file: any other failure (no permission, another schema) is returned as it
/// is. [`Error::NoCheckpoint`] for a folder without any, [`Error::AllDamaged`] for one without a good one.
pub fn latest_good(dir: &Path) -> Result<(PathBuf, State, Vec<Error>), Error> {
    let mut damaged = Vec::new();
    for (_, path) in every_file(dir)? {
        match read(&path) {
            Ok(state) => return Ok((path, state, damaged)),
            Err(error) if error.is_damage() => damaged.push(error),
            Err(error) => return Err(error),
        }
    }
    let dir = dir.to_owned();
    Err(if damaged.is_empty() { Error::NoCheckpoint { dir } } else { Error::AllDamaged { dir, damaged } })
}

/// Removes all but the newest `keep` checkpoints, and what interrupted writes left behind; returns what was removed.
/// Those after `step`, the one just written, are neither counted nor removed: a run has them before it that had to go back
/// over damaged ones. Call it after a write, never during one. Panics if `keep` is 0.
pub fn prune(dir: &Path, step: u64, keep: usize) -> Result<Vec<PathBuf>, Error> {
    assert!(keep > 0, "pruning must leave a checkpoint");
    let old = newest(dir)?.into_iter().filter(|(other, _)| *other <= step).skip(keep);
    let mut removed = Vec::new();
    // They have had names of two kinds: `<name>.partial`, and `<name>.<process>-<number>.partial`.
    let leftovers = list(dir, |rest| rest.starts_with(ENDING) && rest.ends_with(PARTIAL))?;
    for (_, path) in old.chain(leftovers) {
        fs::remove_file(&path).map_err(refused("remove", &path))?;
        removed.push(path);
    }
    Ok(removed)
}

/// Files named `step-<12 digits>` and a rest that is `wanted`, highest step first.
fn list(dir: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<(u64, PathBuf)>, Error> {
    let refused = refused("list", dir);
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).map_err(&refused)? {
        let entry = entry.map_err(&refused)?;
        if let Some(step) = entry.file_name().to_str().and_then(|name| step_of(name, &wanted)) {
            found.push((step, entry.path()));
        }
    }
    found.sort_by(|left, right| right.cmp(left));
    Ok(found)
}

fn step_of(name: &str, wanted: impl Fn(&str) -> bool) -> Option<u64> {
    let (digits, rest) = name.strip_prefix("step-")?.split_at_checked(DIGITS)?;
    let is_one = digits.bytes().all(|byte| byte.is_ascii_digit()) && wanted(rest);
    is_one.then(|| digits.parse().ok()).flatten()
}
