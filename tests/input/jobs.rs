//! The jobs that come with the program.

use std::path::{Path, PathBuf};

use scree::job::{Job, Method};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs")
}

fn jobs_in(folder: &Path) -> Vec<PathBuf> {
    let mut jobs: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("jobs/ is part of the project")
        .map(|entry| entry.expect("jobs/ can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    jobs.sort();
    jobs
}

/// Planar shear.
fn jobs_of_methods() -> Vec<PathBuf> {
    let jobs = jobs_in(&folder());
    assert!(jobs.len() >= 2, "quickstart and planar shear at least: {jobs:?}");
    jobs
}

/// Grains in a cell.
fn jobs_of_elements() -> Vec<PathBuf> {
    let jobs = jobs_in(&folder().join("element"));
    assert!(jobs.len() >= 7, "{jobs:?}");
    jobs
}

/// Continua on a grid.
fn jobs_of_continua() -> Vec<PathBuf> {
    let jobs = jobs_in(&folder().join("continuum"));
    assert!(jobs.len() >= 7, "{jobs:?}");
    jobs
}

/// Measurements.
fn jobs_of_benches() -> Vec<PathBuf> {
    let jobs = jobs_in(&folder().join("bench"));
    assert!(jobs.len() >= 3, "{jobs:?}");
    jobs
}

/// Hybrids that have no twin of grains alone.
fn large_jobs() -> Vec<PathBuf> {
    let jobs = jobs_in(&folder().join("large"));
    assert!(jobs.len() >= 3, "{jobs:?}");
    jobs
}

/// One problem by several methods.
fn jobs_of_one_problem() -> Vec<PathBuf> {
    let jobs = jobs_in(&folder().join("methods"));
    assert!(jobs.len() >= 2, "{jobs:?}");
    jobs
}

fn all_jobs() -> Vec<PathBuf> {
    [jobs_of_methods(), jobs_of_elements(), jobs_of_continua(), jobs_of_benches(), large_jobs(), jobs_of_one_problem()]
        .concat()
}

/// The specimen of the five methods is a hybrid, and by one override grains alone or the continuum that is calibrated to them.
#[test]
fn the_one_problem_is_a_hybrid_and_its_twins() {
    let path = folder().join("methods/biaxial.toml");
    for method in ["hybrid", "dem", "mpm"] {
        let job = Job::load(&path, &[format!("method={method}")]).unwrap_or_else(|error| panic!("{error}"));
        assert!(job.to_toml().contains(&format!("method = \"{method}\"")), "{method}");
    }
}

#[test]
fn every_job_is_read_and_its_resolved_form_means_the_same() {
    for path in all_jobs() {
        let job = Job::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let resolved = job.to_toml();
        let back = Job::parse(&resolved, "elsewhere/scenario.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back, job, "{}", path.display());
        assert_eq!(back.to_toml(), resolved, "{}", path.display());
        assert_eq!(job.name(), path.file_stem().expect("a job has a name").to_string_lossy());
    }
}

/// A hybrid is compared with grains alone and continuum alone, so its twins must be one override away.
#[test]
fn every_job_has_its_twins() {
    for path in jobs_of_methods() {
        for method in [Method::Hybrid, Method::Dem, Method::Mpm] {
            let set = format!("method={}", method.name());
            let twin = Job::load(&path, &[set]).unwrap_or_else(|error| panic!("{error}"));
            let found = match twin {
                Job::Shear(job) => Some(job.method),
                Job::Mpm(job) => job.grains.map(|grains| grains.method),
                Job::Assembly(_) => None,
            };
            assert_eq!(found, Some(method), "{}", path.display());
        }
    }
}

#[test]
fn elements_are_assemblies() {
    for path in jobs_of_elements() {
        let job = Job::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(matches!(job, Job::Assembly(_)), "{}", path.display());
    }
}

#[test]
fn continua_are_continua() {
    for path in jobs_of_continua() {
        let job = Job::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(matches!(job, Job::Mpm(_)), "{}", path.display());
    }
}

/// A job that the table of `jobs/README.md` does not name would not be found.
#[test]
fn every_job_is_in_the_readme_of_jobs() {
    let page = std::fs::read_to_string(folder().join("README.md")).expect("jobs/ has a README");
    for path in all_jobs() {
        let name = path.file_name().expect("a job has a name").to_string_lossy();
        assert!(page.contains(&*name), "jobs/README.md does not name {name}");
    }
}

/// Who looks for how something is written finds a job that has it.
#[test]
fn jobs_of_elements_have_one_of_each_kind() {
    let texts: Vec<String> =
        jobs_of_elements().iter().map(|path| std::fs::read_to_string(path).expect("it can be read")).collect();
    let has = |line: &str| texts.iter().any(|text| text.lines().any(|found| found.trim_start().starts_with(line)));
    let values = [
        ("law", &["linear", "linear_cohesive", "elastic_rolling", "hertz_mindlin"][..]),
        ("shape", &["plane", "box", "cylinder", "layer"]),
        ("distribution", &["normal", "uniform", "list"]),
        ("preparation", &["compress", "pour"]),
        ("space", &["plane", "solid"]),
    ];
    for (key, kinds) in values {
        for kind in kinds {
            assert!(has(&format!("{key} = \"{kind}\"")), "{key} = {kind:?}");
        }
    }
    for key in
        ["servo", "path", "ramp", "spin", "fraction", "energy_balance", "stress", "velocity_gradient", "local", "file"]
    {
        assert!(has(&format!("{key} = ")), "{key}");
    }
}
