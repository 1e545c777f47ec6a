//! A job that grows with the ranks, for weak scaling: as wide along x as that many of it side by side.

use crate::base::error::Error;
use crate::job::assembly::Source;
use crate::job::mpm::{InitialStress, RegionShape};
use crate::job::{Assembly, Job, Mpm, Scenario};

/// The `key.path=value` overrides that make a job that many times as wide, with as many times the rows. What cannot be
/// widened without becoming another experiment is refused.
pub fn overrides(job: &Job, times: usize) -> Result<Vec<String>, Error> {
    if times == 1 {
        return Ok(Vec::new());
    }
    match job {
        Job::Shear(job) => shear(job, times as f64),
        Job::Assembly(job) => assembly(job, times),
        Job::Mpm(job) => continuum(job, times as f64),
    }
    .map_err(|why| {
        Error::User(format!(
            "{} cannot be widened along x for weak scaling: {why}. Leave out --weak, or take a job without it.",
            job.name()
        ))
    })
}

/// The plate's mass and damping grow with its width, and the strain, which is displacement over width, shrinks, so that
/// the run lasts as long.
fn shear(job: &Scenario, times: f64) -> Result<Vec<String>, String> {
    if job.grains.file.is_some() {
        return Err("its grains are read from grains.file".to_string());
    }
    let width = job.specimen.width;
    let mut sets = vec![
        set("specimen.width", times * width),
        set("loading.strain_end", job.loading.strain_end / times),
        set("loading.plate_mass", times * job.loading.plate_mass),
        set("loading.plate_damping", times * job.loading.plate_damping),
    ];
    for (index, weak) in job.continuum.weak.iter().enumerate() {
        if !spans([weak.lower[0], weak.upper[0]], [0.0, width]) {
            return Err(format!("continuum.weak {index} (counted from 0) does not span the width"));
        }
        sets.push(format!("continuum.weak.{index}.upper=[{:?}, {:?}]", times * width, weak.upper[1]));
    }
    Ok(sets)
}

fn assembly(job: &Assembly, times: usize) -> Result<Vec<String>, String> {
    if let Some(body) = job.bodies.first() {
        return Err(format!("body `{}` stands in it", body.name));
    }
    let Source::Packed(packed) = &job.source else { return Err("its grains are read from grains.file".to_string()) };
    if (1..3).any(|row| job.cell.gradient[row][0] != 0.0) {
        return Err("its velocity_gradient makes speeds across x that grow with x".to_string());
    }
    if let Some(mut copies) = job.cell.copies {
        copies[0] *= times as u64;
        return Ok(vec![vector("cell.copies", &copies.map(|count| count as f64)[..job.cell.dimension])]);
    }
    let mut upper = job.cell.upper;
    upper[0] = wider([job.cell.lower[0], upper[0]], times as f64);
    Ok(vec![
        vector("cell.upper", &upper[..job.cell.dimension]),
        format!("grains.count={}", packed.count * times as u64),
    ])
}

fn continuum(job: &Mpm, times: f64) -> Result<Vec<String>, String> {
    let grid = &job.grid;
    let (axes, span) = (grid.dimension, [grid.lower[0], grid.upper[0]]);
    if job.mesh.is_some() {
        return Err("it is a mesh, whose elements are counted".to_string());
    }
    if let Some(body) = job.bodies.first() {
        return Err(format!("body `{}` stands in it", body.body.name));
    }
    if !job.loads.is_empty() {
        return Err("it has loads".to_string());
    }
    if let Some(membrane) = job.membranes.first() {
        return Err(format!("the membrane `{}` is part of it", membrane.name));
    }
    if let Some(followed) = job.follow.first() {
        return Err(format!(
            "it follows the point `{}`, whose place has neighbours of another size then",
            followed.name
        ));
    }
    if matches!(job.stress, InitialStress::Geostatic { axis: 0, .. }) {
        return Err("gravity points along x".to_string());
    }
    let mut upper = grid.upper;
    upper[0] = wider(span, times);
    let mut sets = vec![vector("grid.upper", &upper[..axes])];
    for (index, region) in job.regions.iter().enumerate() {
        let which = format!("region {index} (counted from 0)");
        let RegionShape::Box { lower, upper: corner } = &region.shape else {
            return Err(format!("{which} is no box"));
        };
        if !spans([lower[0], corner[0]], span) {
            return Err(format!("{which} does not span the grid along x"));
        }
        if region.spin != [0.0; 3] {
            return Err(format!("{which} spins"));
        }
        if region.waves.iter().any(|wave| wave.direction[0] != 0.0) {
            return Err(format!("a wave of {which} runs along x"));
        }
        let mut corner = *corner;
        corner[0] = upper[0];
        sets.push(vector(&format!("region.{index}.upper"), &corner[..axes]));
    }
    Ok(sets)
}

fn set(key: &str, value: f64) -> String {
    format!("{key}={value:?}")
}

fn vector(key: &str, values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("{key}=[{}]", values.join(", "))
}

fn wider([lower, upper]: [f64; 2], times: f64) -> f64 {
    lower + times * (upper - lower)
}

/// Whether a stretch covers another, but for round-off.
fn spans([lower, upper]: [f64; 2], [from, to]: [f64; 2]) -> bool {
    let slack = 1e-9 * (to - from);
    lower <= from + slack && upper >= to - slack
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;

    /// A row of weak cells.
    const WEAK: &str = "continuum.weak=[{lower=[0.0, 0.0525], upper=[0.06, 0.06], fraction_deficit=0.01}]";

    fn path(job: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs").join(job)
    }

    fn load(job: &str, sets: &[String]) -> Job {
        Job::load(&path(job), sets).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_wider_job_has_as_many_times_the_rows() {
        let weak = [WEAK.to_string()];
        let wider: Vec<String> =
            weak.iter().cloned().chain(overrides(&load("planar_shear.toml", &weak), 3).unwrap()).collect();
        let Job::Shear(wide) = load("planar_shear.toml", &wider) else { unreachable!() };
        let Job::Shear(plain) = load("planar_shear.toml", &[]) else { unreachable!() };
        assert!((wide.specimen.width - 0.18).abs() < 1e-12 && (wide.continuum.weak[0].upper[0] - 0.18).abs() < 1e-12);
        let steps = crate::job::derived::steps;
        assert!(steps(&wide).abs_diff(steps(&plain)) <= 1, "{} {}", steps(&wide), steps(&plain));
        // As the default of a plate of that width, and thrice what the job says itself.
        let only = load("planar_shear.toml", &["specimen.width=0.18".into()]);
        let Job::Shear(only) = only else { unreachable!() };
        assert!((wide.loading.plate_mass / only.loading.plate_mass - 1.0).abs() < 1e-12);
        assert!((wide.loading.plate_damping / (3.0 * only.loading.plate_damping) - 1.0).abs() < 1e-12);

        let uniaxial = load("element/uniaxial.toml", &[]);
        let Job::Assembly(wide) = load("element/uniaxial.toml", &overrides(&uniaxial, 2).unwrap()) else {
            unreachable!()
        };
        let Source::Packed(packed) = &wide.source else { unreachable!() };
        assert_eq!((wide.cell.upper[0], wide.cell.upper[1], packed.count), (0.04, 0.02, 800));
        assert!(overrides(&uniaxial, 1).unwrap().is_empty());
        let copies = load("element/uniaxial.toml", &["cell.copies=[3, 1]".into()]);
        let wider: Vec<String> =
            ["cell.copies=[3, 1]".into()].into_iter().chain(overrides(&copies, 2).unwrap()).collect();
        let Job::Assembly(wide) = load("element/uniaxial.toml", &wider) else { unreachable!() };
        assert_eq!((wide.cell.copies, wide.cell.upper[0]), (Some([6, 1, 1]), 0.02));
    }

    #[test]
    fn a_continuum_grows_with_its_regions() {
        let job = load("bench/mpm_200k.toml", &[]);
        let Job::Mpm(plain) = &job else { unreachable!() };
        let Job::Mpm(wide) = load("bench/mpm_200k.toml", &overrides(&job, 2).unwrap()) else { unreachable!() };
        assert_eq!(wide.grid.cells[0], 2 * plain.grid.cells[0]);
        let RegionShape::Box { upper, .. } = &wide.regions[0].shape else { unreachable!() };
        assert_eq!(upper[0], wide.grid.upper[0]);
        assert_eq!(wide.step, plain.step);
    }

    #[test]
    fn what_would_be_another_experiment_is_refused() {
        let refused = |job: &str, sets: &[&str]| {
            let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
            overrides(&load(job, &sets), 2).unwrap_err().to_string()
        };
        for (words, job, sets) in [
            ("column_collapse cannot be widened along x", "continuum/column_collapse.toml", &[][..]),
            ("follows the point `corner`", "continuum/column_collapse.toml", &[]),
            ("does not span the grid along x", "continuum/column_collapse.toml", &["follow=[]"]),
            ("body `floor` stands in it", "element/rough_shear.toml", &[]),
            ("read from grains.file", "element/rve_shear.toml", &[]),
            ("speeds across x", "element/uniaxial.toml", &["cell.velocity_gradient=[[0, 0], [1, 0]]"]),
            (
                "continuum.weak 0 (counted from 0) does not span",
                "planar_shear.toml",
                &[WEAK, "continuum.weak.0.lower=[0.01, 0.0525]"],
            ),
        ] {
            let error = refused(job, sets);
            assert!(error.contains(words) && error.contains("Leave out --weak"), "{words}: {error}");
        }
    }
}
