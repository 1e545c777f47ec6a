//! Wrong jobs and what the operator is told.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use scree::job::Scenario;

use crate::refusals::{Good, refused_text};

const GOOD: Good = Good(
    r#"name = "good"
method = "hybrid"

[specimen]
width = "24 mm"
height = "72 mm"

[grains]
diameter_mean = "1 mm"
diameter_deviation = "0.08 mm"
density = "2530 kg/m3"

[contact]
stiffness_normal = 1772093.8
stiffness_tangential = 886046.9
damping_normal = "3.5 N s/m"
damping_tangential = "3.5 N s/m"
friction = 0.5

[continuum]
bulk_modulus = "100 MPa"
shear_modulus = "60 MPa"
friction_angle_critical = "15.5 deg"
fraction_critical = 0.815
dilation_factor = 7
softening_rate = 1
cell = "3 mm"

[[continuum.weak]]
lower = ["0 mm", "33 mm"]
upper = ["24 mm", "39 mm"]
fraction_deficit = 0.01

[loading]
stress_normal = "400 kPa"
speed = "10 cm/s"
speed_ramp = "1 ms"
strain_end = 0.12

[oracle]
laplacian = 1e-6
recent_strain = 1e-4
window = 8e-4
persistence = 1.2e-3

[enrichment]
distance = "1.5 cm"

[time]
step = "0.4 us"
"#,
);

#[test]
fn the_good_job_is_good() {
    Scenario::parse(GOOD.0, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
}

/// The return to the cone is divided by what must not vanish, and a loose region comes by where it does.
#[test]
fn softening_that_has_no_return() {
    refused_text(
        &GOOD.0.replace("fraction_deficit = 0.01", "fraction_deficit = 0.06"),
        &["material.shear_modulus=1 MPa"],
        "job.toml:32: continuum.weak.fraction_deficit = 0.06 leaves a solid volume fraction of 0.79 there, which softens more than the shear modulus can bear: flow is divided by G + K eta etabar, which must be positive and is -886000 Pa at a solid volume fraction of 0.7952. Write a shear_modulus of more than 1886451 Pa, or bring the fraction nearer to fraction_critical, or lower dilation_factor.",
    );
    refused_text(
        &GOOD.0.replace("fraction_deficit = 0.01", "fraction_deficit = 0.3"),
        &[],
        "job.toml:32: continuum.weak.fraction_deficit = 0.3 leaves a solid volume fraction of 0.55 there, which makes the friction angle negative: tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs) is -1.5. Write a fraction of at least 0.7754.",
    );
}

/// The good job as jobs are written now: material and scheme have tables of their own, as on a grid.
fn in_tables() -> String {
    let (head, rest) = GOOD.0.split_once("[continuum]\n").unwrap();
    let (law, tail) = rest.split_once("cell = \"3 mm\"\n").unwrap();
    let material = format!("[material]\nlaw = \"critical_drucker_prager\"\n{law}");
    format!("{head}{material}[scheme]\nflip = 0.95\n[continuum]\ncell = \"3 mm\"\n{tail}")
}

/// Keys that stood in [continuum] mean what they meant, in files and on the command line; what is typed twice is told.
#[test]
fn old_keys_of_the_continuum_are_those_of_material_and_scheme() {
    let parsed = |text: &str, sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        Scenario::parse(text, "job.toml", &sets).unwrap_or_else(|error| panic!("{error}"))
    };
    let (old, new) = (GOOD.0, in_tables());
    assert_eq!(parsed(old, &[]), parsed(&new, &[]));
    let flip = ["continuum.flip=0.5", "continuum.cohesion=1 kPa", "continuum.fraction_start=0.84"];
    let now = ["scheme.flip=0.5", "material.cohesion=1 kPa", "material.fraction=0.84"];
    assert_eq!(parsed(old, &flip), parsed(&new, &now));
    assert_eq!(parsed(&new, &flip), parsed(old, &now));
    assert_ne!(parsed(&new, &flip), parsed(&new, &[]));
    // Where neither says, each has the default of its time.
    let left_out = new.replace("flip = 0.95", "");
    assert_eq!(parsed(&left_out, &["scheme.flip=0.99"]), parsed(&left_out, &[]));
    let twice = new.replace("cell = \"3 mm\"", "cell = \"3 mm\"\ndilation_factor = 7");
    refused_text(
        &twice,
        &[],
        "job.toml:32: [continuum] has no key dilation_factor. It is material.dilation_factor now, and that is there already. Remove one of the two.",
    );
}

/// What a law or a scheme cannot do is told in planar shear as on a grid.
#[test]
fn laws_and_schemes_that_do_not_go_with_plates() {
    let elastic = in_tables().replace("\"critical_drucker_prager\"", "\"hencky\"");
    let (head, rest) = elastic.split_once("friction_angle_critical").unwrap();
    let (_, tail) = rest.split_once("softening_rate = 1\n").unwrap();
    let elastic = format!("{head}{tail}");
    refused_text(
        &elastic,
        &[],
        "job.toml:32: continuum.weak.fraction_deficit = 0.01 is of no effect: an elastic material does not look at its solid volume fraction. Remove the region, or take another material.law.",
    );
    refused_text(
        &elastic,
        &["continuum.weak=[]"],
        "job.toml:21: material.law = \"hencky\" never yields, so that no oracle finds a band in it. Write \"critical_drucker_prager\" or \"mobilised_friction\".",
    );
    let wide = &["method=mpm", "scheme.shape=cubic"];
    refused_text(
        &in_tables(),
        wide,
        "job.toml: decomposition.cells_per_block (by default) is too few for the 3 nodes that scheme.shape = \"cubic\" reaches beyond a block. Write 3.",
    );
    refused_text(
        &in_tables(),
        &["scheme.shape=cubic", "decomposition.cells_per_block=4"],
        "--set: scheme.shape = \"cubic\" is not that of grains, which share nodes by quadratic splines. Write \"quadratic\".",
    );
}

#[test]
fn a_misspelt_key() {
    GOOD.refused(
        "stiffness_normal =",
        "stifness_normal =",
        "job.toml:14: [contact] has no key stifness_normal. Did you mean stiffness_normal?",
    );
}

#[test]
fn a_key_in_the_wrong_table() {
    GOOD.refused(
        "step = \"0.4 us\"",
        "step = \"0.4 us\"\nskin = \"0.1 mm\"",
        "job.toml:51: [time] has no key skin. There is one in [decomposition].",
    );
}

#[test]
fn a_misspelt_table() {
    GOOD.refused("[oracle]", "[oracel]", "job.toml:40: there is no table [oracel]. Did you mean [oracle]?");
}

#[test]
fn a_missing_key() {
    GOOD.refused(
        "height = \"72 mm\"\n",
        "",
        "job.toml:4: [specimen] has no height, the distance of the plates. Add for example height = \"12 cm\".",
    );
}

#[test]
fn a_missing_table() {
    GOOD.refused(
        "[enrichment]\ndistance = \"1.5 cm\"\n",
        "",
        "job.toml: method = \"hybrid\" needs the table [enrichment] (grains for points), and the job has none. Add it with the keys distance, weight, training, training_speed, training_rest; jobs/planar_shear.toml shows one.",
    );
}

#[test]
fn a_speed_for_a_length() {
    GOOD.refused(
        "width = \"24 mm\"",
        "width = \"2 cm/s\"",
        "job.toml:5: specimen.width = \"2 cm/s\" is a speed, but a length (m) is wanted. Write for example width = \"6 cm\".",
    );
}

#[test]
fn a_unit_that_does_not_exist() {
    GOOD.refused(
        "\"400 kPa\"",
        "\"400 kpa\"",
        "job.toml:35: loading.stress_normal = \"400 kpa\" has no known unit: there is no \"kpa\"; did you mean \"kPa\"? Write for example stress_normal = \"400 kPa\".",
    );
}

#[test]
fn a_quoted_number_without_its_unit() {
    GOOD.refused(
        "\"3 mm\"",
        "\"3\"",
        "job.toml:27: continuum.cell = \"3\" has no unit: without quotes a number is taken in m, in quotes it must say its unit. Write for example cell = \"7.5 mm\".",
    );
}

#[test]
fn a_unit_without_quotes() {
    GOOD.refused(
        "\"10 cm/s\"",
        "10 cm/s",
        "job.toml:36: this is not TOML: string values must be quoted, expected literal string, in `speed = 10 cm/s`. Text and quantities with a unit go in quotes, as in width = \"6 cm\".",
    );
}

#[test]
fn degrees_that_are_read_as_radians() {
    GOOD.refused(
        "\"15.5 deg\"",
        "15.5",
        "job.toml:23: material.friction_angle_critical = 15.5 is out of range: it must be 0 rad or more and less than 1.3734 rad. Write for example friction_angle_critical = \"30 deg\".",
    );
}

#[test]
fn a_method_that_does_not_exist() {
    GOOD.refused(
        "\"hybrid\"",
        "\"bem\"",
        "job.toml:2: method = \"bem\" is no method: write \"hybrid\", \"dem\", \"mpm\", \"mpm_dem\", \"fem\" or \"fem_dem\".",
    );
}

#[test]
fn a_number_that_is_not_positive() {
    GOOD.refused(
        "strain_end = 0.12",
        "strain_end = 0",
        "job.toml:38: loading.strain_end = 0 is out of range: it must be more than 0 and at most 100. Write for example strain_end = 0.57.",
    );
    GOOD.refused(
        "\"2530 kg/m3\"",
        "nan",
        "job.toml:11: grains.density = nan is out of range: it must be finite and more than 0 kg/m3. Write for example density = \"2530 kg/m3\".",
    );
}

#[test]
fn sizes_so_wide_that_some_would_vanish() {
    GOOD.refused(
        "\"0.08 mm\"",
        "\"0.3 mm\"",
        "job.toml:10: grains.diameter_deviation = \"0.3 mm\" is too wide: sizes are cut at three deviations, and the smallest must keep a quarter of the mean. Write at most \"0.25 mm\".",
    );
}

#[test]
fn cells_that_do_not_fill_the_width() {
    GOOD.refused(
        "\"3 mm\"",
        "\"3.2 mm\"",
        "job.toml:27: continuum.cell = \"3.2 mm\" does not fit: blocks of 2 cells (decomposition.cells_per_block) must fill specimen.width = 24 mm exactly, at least two of them. Write \"4 mm\" (6 cells) or \"3 mm\" (8 cells).",
    );
}

#[test]
fn blocks_smaller_than_two_grains() {
    GOOD.refused(
        "\"3 mm\"",
        "\"1 mm\"",
        "job.toml:27: continuum.cell = \"1 mm\" makes blocks of 2 mm, but two of the largest grains and the skin need 2.58 mm. Take larger cells, more decomposition.cells_per_block, or smaller grains.",
    );
}

#[test]
fn a_weak_region_outside_of_the_specimen() {
    GOOD.refused(
        "[\"24 mm\", \"39 mm\"]",
        "[\"24 mm\", \"39 cm\"]",
        "job.toml:31: continuum.weak.upper = [\"24 mm\", \"39 cm\"] lies outside of the specimen, whose upper right corner is [0.024, 0.072] in m. Move it inside.",
    );
}

#[test]
fn a_zone_that_leaves_no_continuum() {
    GOOD.refused(
        "\"1.5 cm\"",
        "\"4 cm\"",
        "job.toml:47: enrichment.distance = \"4 cm\" leaves no continuum: twice this distance and twice a cell must be less than specimen.height = 72 mm, so less than 33 mm is allowed. For grains everywhere write method = \"dem\".",
    );
}

#[test]
fn a_zone_that_begins_everywhere_and_stays() {
    GOOD.refused_set(
        "zone.begins=everywhere",
        "--set: zone.begins = \"everywhere\" leaves grains for good where they are, which is method = \"dem\". Write zone.dissolves = true, begins = \"band\", or that method.",
    );
    refused_text(
        GOOD.0,
        &["packing.height=60 mm", "zone.begins=everywhere", "zone.dissolves=true"],
        "--set: zone.begins = \"everywhere\" begins with all of the specimen as grains, and the packing is lower. Remove packing.height, or write begins = \"band\".",
    );
}

/// Table 1 of the paper as printed: its damping with its step loses friction (see `job/stable.rs`).
#[test]
fn the_papers_time_step_with_its_damping() {
    let printed = GOOD.0.replace("\"3.5 N s/m\"", "\"7.0 N s/m\"").replace("\"0.4 us\"", "5.0e-7");
    refused_text(
        &printed,
        &[],
        "job.toml:50: time.step = 5.0e-7 is unstable: at most 2.33e-7 s is allowed (tangential springs and dashpots, mean grain spinning: 2/(sqrt(w^2 + b^2) + b), b = 12 gamma_t/m). Beyond it rotations flip at every step and friction is lost; shorten the step, or lower contact.damping_tangential.",
    );
}

/// A continuum alone is bound by its waves.
#[test]
fn a_time_step_that_waves_outrun() {
    let text = GOOD.0.replace("\"hybrid\"", "\"mpm\"").replace("\"0.4 us\"", "\"6 us\"");
    let text = text.replace("cell = \"3 mm\"", "cell = \"3 mm\"\nfraction_start = 0.85");
    refused_text(
        &text,
        &[],
        "job.toml:51: time.step = \"6 us\" is unstable: at most 5.67e-6 s is allowed (nodes with next to no mass: cell sqrt(2/s)/c, c^2 = (M + lambda of every other axis)/density, s = 6 (quadratic), 3.1 (cubic), 9.3 (uGIMP with two points)). Beyond it points at the edge of material are thrown about; shorten the step, or take update = \"modified_last\" with transfer = \"blend\".",
    );
}

/// Every key of a law that the job does not have is named with its owner.
#[test]
fn a_key_of_another_contact_law() {
    GOOD.refused_among(
        "friction = 0.5",
        "friction = 0.5\npoisson_ratio = 0.2",
        "job.toml:19: contact.poisson_ratio = 0.2 belongs to law = \"hertz_mindlin\", and here law is \"linear\", by default. Remove the line, or change law.",
    );
    // A part of any law, of which there is a half.
    GOOD.refused_among(
        "friction = 0.5",
        "friction = 0.5\nrolling_limit = 0.05",
        "job.toml:19: contact.rolling_limit = 0.05 stands alone. Add contact.rolling_stiffness = 1.0, without which there is nothing to limit, or remove it.",
    );
    GOOD.refused_among(
        "friction = 0.5",
        "friction = 0.5\nlaw = \"elastic_rolling\"",
        "job.toml:14: contact.stiffness_normal = 1772093.8 belongs to law = \"linear\" or \"linear_cohesive\", and here law is \"elastic_rolling\". Remove the line, or change law.",
    );
    GOOD.refused_among(
        "friction = 0.5",
        "friction = 0.5\nlaw = \"hertz\"",
        "job.toml:19: contact.law = \"hertz\" is no contact law: write \"linear\", \"linear_cohesive\", \"elastic_rolling\" or \"hertz_mindlin\".",
    );
}

#[test]
fn damping_said_twice_or_not_at_all() {
    GOOD.refused(
        "friction = 0.5",
        "friction = 0.5\nrestitution = 0.1",
        "job.toml:19: contact.restitution = 0.1 stands beside contact.damping_normal, and each says how contacts are damped. Keep restitution, or damping_normal and damping_tangential.",
    );
    GOOD.refused(
        "damping_normal = \"3.5 N s/m\"\ndamping_tangential = \"3.5 N s/m\"\n",
        "",
        "job.toml:13: [contact] does not say how contacts are damped. Add restitution, for example restitution = 0.5, or both damping_normal and damping_tangential, for example \"3.5 N s/m\".",
    );
    GOOD.refused(
        "damping_normal = \"3.5 N s/m\"\ndamping_tangential = \"3.5 N s/m\"\n",
        "restitution = 1\n",
        "job.toml:16: contact.restitution = 1 is out of range: it must be between 0 and 1, both excluded. Write for example restitution = 0.1.",
    );
}

#[test]
fn friction_said_twice() {
    GOOD.refused(
        "friction = 0.5",
        "friction = 0.5\nfriction_angle = \"26 deg\"",
        "job.toml:19: contact.friction_angle = \"26 deg\" stands beside contact.friction, and each says how rough grains are. Keep one of them.",
    );
}

/// The table `[cell]` tells the two kinds of jobs apart.
#[test]
fn a_table_or_a_key_of_an_assembly() {
    GOOD.refused(
        "[time]",
        "[damping]\nlocal = 0.1\n\n[time]",
        "job.toml:49: there is no table [damping]. It belongs to assemblies of grains, jobs with a table [cell], and this job has none.",
    );
    GOOD.refused(
        "step = \"0.4 us\"",
        "step = \"0.4 us\"\nend = 1",
        "job.toml:51: [time] has no key end. It belongs to assemblies of grains, jobs with a table [cell], and this job has none.",
    );
    GOOD.refused_set(
        "cell.depth=1",
        "--set cell.depth=1: a job has no cell.depth. It belongs to assemblies of grains, jobs with a table [cell], and this job has none.",
    );
    GOOD.refused(
        "method = \"hybrid\"\n",
        "",
        "job.toml: the job does not say what it is. Add method = \"hybrid\", \"dem\" or \"mpm\" above the first table for planar shear, a table [cell] for an assembly of grains, or a table [grid] for a continuum.",
    );
}

#[test]
fn a_name_that_is_a_path() {
    GOOD.refused(
        "\"good\"",
        "\"../good\"",
        "job.toml:1: name = \"../good\" is refused: it names the run's folder, so write letters, digits, \"_\", \"-\" and \".\" only, a letter or digit first.",
    );
}

#[test]
fn an_override_of_what_does_not_exist() {
    GOOD.refused_set("loading.sped=1", "--set loading.sped=1: a job has no loading.sped. Did you mean loading.speed?");
    GOOD.refused_set("speed=1", "--set speed=1: a job has no speed. Did you mean loading.speed?");
}

#[test]
fn an_override_with_the_wrong_value() {
    GOOD.refused_set(
        "loading.speed=5 cm",
        "--set: loading.speed = \"5 cm\" is a length, but a speed (m/s) is wanted. Write for example speed = \"2 cm/s\".",
    );
}

fn scree(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scree"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program can be started")
}

/// Exit code 2, nothing on stdout, the message on stderr.
#[track_caller]
fn told(output: &Output, message: &str) {
    assert_eq!(String::from_utf8_lossy(&output.stderr).trim_end(), message);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
}

#[test]
fn a_job_that_is_not_there() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    told(
        &scree(&["run", "nowhere.toml"], folder.path()),
        "nowhere.toml: this job cannot be read: No such file or directory (os error 2). Give the path of a job, for example jobs/quickstart.toml.",
    );
}

/// A run that exists is never written over.
#[test]
fn a_run_that_exists() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let run = folder.path().join("runs/good");
    fs::create_dir_all(run.join("checkpoints")).expect("a run to stand in the way");
    fs::write(folder.path().join("job.toml"), GOOD.0).expect("the job is written");
    fs::write(run.join("scenario.toml"), GOOD.0).expect("the run has its scenario");
    told(
        &scree(&["run", "job.toml"], folder.path()),
        "runs/good holds a run that has no checkpoint yet. If it has ended, go on with it by `scree resume runs/good`; or start a new one elsewhere with --out DIR.",
    );
    fs::write(run.join("checkpoints/step-000000000100.h5"), "").expect("the run has a checkpoint");
    told(
        &scree(&["run", "job.toml"], folder.path()),
        "runs/good already holds a run, and a run is never overwritten. Go on with it by `scree resume runs/good`, or start a new one elsewhere with --out DIR.",
    );
    let untouched = fs::read_to_string(run.join("scenario.toml")).expect("the run is still there");
    assert_eq!(untouched, GOOD.0);
}

/// Two ranks that find the same mistake say so once, and mpirun ends with its code.
#[cfg(feature = "mpi")]
#[test]
fn ranks_speak_with_one_voice() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let output = Command::new("mpirun")
        .args(["--oversubscribe", "--bind-to", "none", "--timeout", "60", "-n", "2", env!("CARGO_BIN_EXE_scree")])
        .args(["run", "nowhere.toml"])
        .envs([
            ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
            ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
            ("OMPI_MCA_btl", "self,vader"),
        ])
        .current_dir(folder.path())
        .output()
        .expect("mpirun is installed; bash tests/run.sh sees to it");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(told.matches("nowhere.toml: this job cannot be read").count(), 1, "{told}");
    assert_eq!(output.status.code(), Some(2), "{told}");
}

#[test]
fn a_folder_that_is_no_run() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    told(
        &scree(&["resume", "."], folder.path()),
        ". holds no run: its scenario.toml is missing. Give the folder that `scree run` wrote, for example runs/quickstart.",
    );
}

/// What is no checkpoint is called so, by its name, and never read as an empty state.
#[test]
fn a_checkpoint_of_garbage() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    fs::write(folder.path().join("garbage.h5"), b"not HDF5 at all").expect("the garbage is written");
    let output = scree(&["digest", "garbage.h5"], folder.path());
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("garbage.h5"), "{message}");
    assert!(output.stdout.is_empty());
}

/// A wrong option is the operator's mistake as well.
#[test]
fn an_option_that_does_not_exist() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let output = scree(&["run", "job.toml", "--thread", "2"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--threads"));
}
