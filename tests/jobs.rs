//! The jobs that come with the program.

use std::path::{Path, PathBuf};

use scree::scenario::{Method, Scenario};

fn jobs() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs");
    let mut jobs: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("jobs/ is part of the project")
        .map(|entry| entry.expect("jobs/ can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    jobs.sort();
    assert!(jobs.len() >= 2, "quickstart and planar shear at least: {jobs:?}");
    jobs
}

#[test]
fn every_job_is_read_and_its_resolved_form_means_the_same() {
    for path in jobs() {
        let scenario = Scenario::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let resolved = scenario.to_toml();
        let back = Scenario::parse(&resolved, "elsewhere/scenario.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back, scenario, "{}", path.display());
        assert_eq!(back.to_toml(), resolved, "{}", path.display());
    }
}

/// A hybrid is compared with grains alone and continuum alone, so its twins must be one override away.
#[test]
fn every_job_has_its_twins() {
    for path in jobs() {
        for method in [Method::Hybrid, Method::Dem, Method::Mpm] {
            let set = format!("method={}", method.name());
            let twin = Scenario::load(&path, &[set]).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(twin.method, method);
        }
    }
}

/// A job that the table of `jobs/README.md` does not name would not be found.
#[test]
fn every_job_is_in_the_readme_of_jobs() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/README.md"))
        .expect("jobs/ has a README");
    for path in jobs() {
        let name = path.file_name().expect("a job has a name").to_string_lossy();
        assert!(page.contains(&*name), "jobs/README.md does not name {name}");
    }
}
