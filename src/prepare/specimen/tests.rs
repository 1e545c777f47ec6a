//! A small specimen between plates and membranes.

use scree_partition::Solo;

use super::*;
use crate::base::space::Plane;
use crate::domain::stop::lives;
use crate::job::Job;

/// Its specimen takes two attempts until it fits.
const TRIAXIAL: &str = include_str!("../../../tests/gate/triaxial.toml");

/// The specimen of a job with a cache of its own, and in how many lives of so many steps it has been made.
fn made(steps: u64) -> (String, u64) {
    let folder = tempfile::tempdir().unwrap();
    let sets = ["method=dem".to_string(), format!("packing.cache={}", folder.path().display())];
    let Ok(Job::Mpm(job)) = Job::parse(TRIAXIAL, "job.toml", &sets) else { panic!("a job on a grid") };
    let granular = job.grains.as_deref().unwrap();
    let (made, lives) = lives::of(steps, || specimen::<Plane>((&job, granular), &Solo));
    let moved: Vec<_> = made.bodies.iter().map(|body| body.displacement).collect();
    (format!("{:?} {moved:?} {:?}", made.grains, made.vertices), lives)
}

/// Piece and specimen, with seats that take several attempts: whatever looks have set is saved with them.
#[test]
fn a_specimen_in_short_lives_is_that_of_one_life() {
    let (wanted, _) = made(u64::MAX);
    let (found, lives) = made(2003);
    assert!(lives > 10, "{lives} lives");
    assert!(found == wanted, "another specimen after {lives} lives");
}
