//! `scree check`: what a job means and what it will cost, before anything is started.

use std::path::Path;

use self::page::Page;
use self::slots::Slots;
use super::cores::Placement;
use crate::base::error::Error;
use crate::job::raw::Typed;
use crate::job::{Job, Method};
use crate::prepare::grain_file;

mod bodies;
mod contact;
mod continuum;
mod cost;
mod coupling;
mod domain;
mod doubts;
mod grains;
mod page;
mod rves;
mod slots;
mod steps;
mod warnings;

pub(super) use doubts::doubts;

/// The sections of the page; one is left out where a job has nothing of it.
const SECTIONS: [fn(&mut Page, &Slots); 16] = [
    domain::section,
    domain::faces,
    grains::section,
    contact::section,
    rves::section,
    rves::nonlocal_section,
    continuum::scheme,
    continuum::material,
    continuum::start,
    bodies::plates,
    bodies::bodies,
    bodies::membranes,
    coupling::section,
    steps::loading,
    steps::steps,
    cost::section,
];

/// `tests_grains`: of a hybrid, some packings of its grains are sheared, which takes seconds.
pub(super) fn command((job, sets): (&Path, &[String]), tests_grains: bool) -> Result<String, Error> {
    let (job, typed) = Job::load_typed(job, sets)?;
    refuse_bad_grains(&job, &typed)?;
    Ok(format!("{}\nThe job is good. No run was started.\n", page(&job, tests_grains)?))
}

fn page(job: &Job, tests_grains: bool) -> Result<String, Error> {
    let slots = Slots::of(job, tests_grains)?;
    let mut page = Page(String::new());
    let moving = match job.method() {
        Method::Hybrid => "continuum with grains where it localises",
        Method::Dem => "grains alone",
        Method::Mpm => "continuum alone",
        Method::MpmDem => "continuum with a grain assembly at every point",
        Method::Fem => "continuum of elements alone",
        Method::FemDem => "elements with a grain assembly each",
    };
    let space = match (job.dimension(), &slots.continuum) {
        (2, None) => "discs in the plane",
        (2, Some(_)) => "plane strain",
        (_, None) => "spheres in space",
        (_, Some(_)) => "in space",
    };
    page.line(&format!("{}: method {}, {moving}, {space}", job.name(), job.method().name()));
    SECTIONS.iter().for_each(|section| section(&mut page, &slots));
    for warning in warnings::warnings(&slots).into_iter().chain(doubts(job)) {
        page.line(&format!("\nwarning: {warning}"));
    }
    Ok(page.0)
}

/// Grains that cannot be read or made are found before anything is started.
pub(super) fn refuse_bad_grains(job: &Job, typed: &Typed) -> Result<(), Error> {
    let Some(grains) = job.grains() else { return Ok(()) };
    if let Some(file) = grains.source.file().filter(|file| !file.is_file()) {
        let message = format!(
            "names no file of grains: there is none at {}. Give a path that starts from the job's folder, for example file = \"grains.csv\", or remove the key to have grains made.",
            file.display()
        );
        return Err(typed.refusal("grains", "file", &message));
    }
    match (job.as_shear(), grains.source.file()) {
        (Some(scenario), Some(file)) => grain_file::read(scenario, file).map(|_| ()),
        (Some(_), None) => Ok(()),
        (None, _) => crate::run::assembly::refuse_bad(&grains, typed),
    }
}

/// Who would run where, had this command been `run`.
pub(super) fn placed(placement: &Placement) -> String {
    let warnings: Vec<String> = placement.warnings.iter().map(|warning| format!("\nwarning: {warning}\n")).collect();
    format!("Started as this check was, it runs as {}.\n{}", placement.words, warnings.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_threads_and_cores_are_told() {
        let warnings = vec!["they wait".to_string()];
        let placement = Placement { threads: 2, words: "4 ranks of 2 threads on 2 cores".into(), warnings };
        let told = placed(&placement);
        assert_eq!(
            told,
            "Started as this check was, it runs as 4 ranks of 2 threads on 2 cores.\n\nwarning: they wait\n"
        );
    }

    fn checked(job: &str, sets: &[&str]) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs").join(job);
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        page(&Job::load(&path, &sets).unwrap(), false).unwrap()
    }

    /// Table 2's K does not fit Table 1's contacts, and xi = 0.01 does not soften: both are said, neither is refused.
    #[test]
    fn the_papers_tables_are_run_with_their_warnings() {
        let page = checked("planar_shear.toml", &["material.file=materials/chen_table_2.toml"]);
        assert!(page.contains("K is 6.57 and G 6.4 times the affine estimate"), "{page}");
        assert!(page.contains("softening_rate = 0.01 hardly softens"), "{page}");
        assert!(page.contains("governs: tangential springs and dashpots"), "{page}");
    }

    /// Rows of what sleeps would only confuse.
    #[test]
    fn each_method_prints_its_own_figures() {
        let grains = checked("planar_shear.toml", &["method=dem"]);
        assert!(!grains.contains("material points") && grains.contains("stiffness number"), "{grains}");
        let points = checked("planar_shear.toml", &["method=mpm"]);
        assert!(points.contains("material points") && !points.contains("stiffness number"), "{points}");
        assert!(!grains.contains("speed-up") && !points.contains("speed-up"));
    }

    /// Points have them at the start, where there are none.
    #[test]
    fn weak_regions_of_a_specimen_that_begins_as_grains_are_told_to_do_nothing() {
        let sets = ["zone.begins=everywhere", "zone.dissolves=true", "enrichment.distance=5 mm"];
        let told = "[[continuum.weak]] does nothing";
        assert!(checked("planar_shear_weak_row.toml", &sets).contains(told));
        assert!(!checked("planar_shear_weak_row.toml", &[]).contains(told));
        assert!(!checked("planar_shear.toml", &sets).contains(told));
    }

    /// A key that the law does not have would be refused when it is written, and Hertz contacts have no one stiffness.
    #[test]
    fn soft_contacts_are_told_the_key_of_their_law() {
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/quickstart.toml")).unwrap();
        let (head, rest) = text.split_once("[contact]").unwrap();
        let (_, tail) = rest.split_once("[packing]").unwrap();
        let page = |law: &str| {
            let text = format!("{head}[contact]\nfriction = 0.5\n{law}\n[packing]{tail}");
            let job = Job::parse(&text, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
            super::page(&job, false).unwrap()
        };
        let linear = "stiffness_normal = 1e5\nstiffness_tangential = 5e4\ndamping_normal = 1\ndamping_tangential = 1";
        let elastic = "law = \"elastic_rolling\"\nyoung_modulus = 1e8\nstiffness_ratio = 0.5";
        let hertz = "law = \"hertz_mindlin\"\nshear_modulus = 1e9\npoisson_ratio = 0.2";
        for (law, key) in [(linear, "stiffness_normal"), (elastic, "young_modulus")] {
            let page = page(law);
            assert!(page.contains(&format!("Raise contact.{key} or")), "{page}");
        }
        let page = page(hertz);
        assert!(!page.contains("Raise contact."), "{page}");
    }

    /// What only the packing was refused for once, after a folder had been made for the run.
    #[test]
    fn a_packing_that_cannot_be_made_is_no_good_job() {
        let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/element/rve_ensemble.toml");
        let refused = |set: &str| command((&job, &[set.to_string()]), false).unwrap_err().to_string();
        let narrow = refused("grains.count=8");
        assert!(
            narrow.starts_with("--set: grains.count = 8 makes 8 grains, which fill a cell that is only "),
            "{narrow}"
        );
        let folder = tempfile::tempdir().unwrap();
        let text = std::fs::read_to_string(&job).unwrap();
        let file = folder.path().join("job.toml");
        std::fs::write(
            &file,
            format!("{text}\n[[body]]\nname = \"ball\"\nshape = \"cylinder\"\ncentre = [0.05, 0.05]\nradius = 1e-3\n"),
        )
        .unwrap();
        let body = command((&file, &[]), false).unwrap_err().to_string();
        assert!(body.contains("fills the whole cell with grains, and body `ball` stands in it"), "{body}");
    }

    /// What is known of an assembly: its law, cell, bodies, stable step and cost.
    #[test]
    fn assemblies_print_what_they_have() {
        let pour = checked("element/pour.toml", &[]);
        for wanted in [
            "spheres in space",
            "floor                          plane",
            "20,000 N/m",
            "10,000 N/m",
            "40,000",
            "preparation                    pour",
        ] {
            assert!(pour.contains(wanted), "{wanted}: {pour}");
        }
        let discs = checked("element/two_discs.toml", &[]);
        assert!(discs.contains("is 2.14 times the stable one, 2.33e-7 s"), "{discs}");
        assert!(discs.contains("steps                          40\n") && discs.contains("read from"), "{discs}");
        let uniaxial = checked("element/uniaxial.toml", &["cell.velocity_gradient=[[0, 0], [0, -100]]"]);
        assert!(uniaxial.contains("the inertial number is 0.0159"), "{uniaxial}");
        assert!(!uniaxial.contains("Bodies"), "{uniaxial}");
    }

    /// Where several points of a cell yield under gravity, and nowhere else.
    #[test]
    fn noise_of_stresses_is_told_with_its_remedy() {
        let column = checked("continuum/column_collapse.toml", &["scheme.volume_averaging=false"]);
        assert!(column.contains("warning: with scheme.points_per_cell = 2 the stresses of single points"), "{column}");
        assert!(column.contains("Leave scheme.volume_averaging at true"), "{column}");
        let averaged = checked("continuum/column_collapse.toml", &[]);
        let single =
            checked("continuum/column_collapse.toml", &["scheme.points_per_cell=1", "scheme.volume_averaging=false"]);
        let weightless = checked("continuum/prandtl_cohesive.toml", &[]);
        let elastic = checked("continuum/self_weight.toml", &[]);
        for page in [averaged, single, weightless, elastic] {
            assert!(!page.contains("noise"), "{page}");
        }
    }

    #[test]
    fn a_file_of_grains_must_be_there() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/element/rve_shear.toml");
        let error = command((&path, &["grains.file=/nowhere/t1_s12.csv".to_string()]), false).unwrap_err().to_string();
        assert!(error.contains("names no file of grains: there is none at /nowhere/t1_s12.csv."), "{error}");
    }
    /// The mean grain was taken, of whatever sizes the file had, and a step that `check` called stable was refused by `run`.
    #[test]
    fn the_stable_step_of_grains_in_a_file_is_that_of_these_grains() {
        let folder = tempfile::tempdir().unwrap();
        let rows = |diameters: &[f64]| -> String {
            let row = |(id, diameter): (usize, &f64)| {
                format!("{id},{:e},2e-3,{:e}\n", 1e-3 + 1.5e-3 * id as f64, 0.5 * diameter)
            };
            diameters.iter().enumerate().map(row).collect()
        };
        let wide = [0.7e-3, 1e-3, 1e-3, 1.1e-3, 1.2e-3];
        std::fs::write(folder.path().join("wide.csv"), format!("id,x,y,radius\n{}", rows(&wide))).unwrap();
        let text = "name = \"wide\"\n[cell]\nspace = \"plane\"\nupper = [0.01, 0.01]\n[grains]\ndensity = 2650\nfile = \"wide.csv\"\ndiameter_mean = \"1 mm\"\n[contact]\nstiffness_normal = 1e5\nstiffness_tangential = 5e4\ndamping_normal = 0\ndamping_tangential = 0\nfriction = 0.5\n[time]\nstep = 1e-7\nend = 1e-5\n";
        let file = folder.path().join("job.toml");
        std::fs::write(&file, text).unwrap();
        let page = command((&file, &[]), false).unwrap();
        // Of springs between equals: 2/w, w^2 = 6 (k_n + k_t)/m or 24 k_t/m.
        let mass = 2650.0 * std::f64::consts::PI * 0.35e-3 * 0.35e-3 * 0.01;
        let stable = 2.0 / (24.0 * 5e4 / mass).sqrt();
        assert!(page.contains(&format!("{} s", page::figures(stable))), "{stable}: {page}");
        // What is printed can be taken, and a little more is refused with the remedy.
        let [less, more] =
            [0.999, 1.001].map(|share| command((&file, &[format!("time.step={:e}", share * stable)]), false));
        less.unwrap();
        let refused = more.unwrap_err().to_string();
        assert!(
            refused.contains("wide.csv:2: a grain with radius = 0.00035 m is unstable with time.step"),
            "{refused}"
        );
        assert!(refused.contains("s is allowed (tangential springs, lightest grain spinning: 2/w, w^2 = 24 k_t/m). Beyond it contacts feed energy into the grains; shorten the step"), "{refused}");
        assert!(refused.contains("write time.allow_unstable = true"), "{refused}");
    }

    /// Warnings stand above the last line, whatever the kind of job.
    #[test]
    fn slips_are_told_by_check() {
        let page = checked("element/pour.toml", &["grains.density=\"2.5 kg/m3\"", "time.allow_unstable=true"]);
        let (above, last) = page.trim_end().rsplit_once("\n\n").unwrap();
        assert!(last.starts_with("warning: grains.density = 2.5 kg/m3 is less than any solid has."), "{above}{last}");
    }
}
