//! Calibration: what the fit finds in data that the law itself made, and a small one from the job to the job again.

use std::path::Path;
use std::process::{Command, Output};

use scree::analysis::calibrate::element::{ROW_SHEAR, Row};
use scree::analysis::calibrate::fit::{Fit, Shear, axial, fit, friction, moduli, modulus, pressure};
use scree::analysis::calibrate::path::{Drive, Kept, sheared};
use scree::analysis::calibrate::{Subject, Wanted, elements, mobilised};
use scree::base::math;
use scree::base::space::{Plane, Solid, Space};
use scree::job::{Job, Scenario};
use scree::law::material::{ConstitutiveLaw, CriticalDruckerPrager, MaterialLaw};

use crate::mpirun::words;
use crate::worlds::{Random, material};

type Tensor = <Plane as Space>::Tensor;

/// A shear test to 60 % that the law itself makes.
fn made(law: &CriticalDruckerPrager, stress: f64, fraction: f64) -> Shear {
    let strains = (0..=1200).map(|row| f64::from(row) * ROW_SHEAR);
    let rows = sheared(law, Drive::shear(2, stress, fraction), strains).expect("the law bears it");
    Shear { axes: 2, stress, rows: rows.into_iter().map(|(row, _)| row).collect() }
}

fn off(found: f64, wanted: f64) -> f64 {
    (found / wanted - 1.0).abs()
}

/// In simple shear at constant normal stress the law first is elastic, then keeps to its cone, and in the end neither
/// dilates nor hardens: tau/sigma_n = sin(phi_cs).
#[test]
fn the_path_begins_elastic_and_ends_critical() {
    let law = CriticalDruckerPrager { softening_rate: 12.0, ..material() };
    let test = made(&law, 400e3, 0.84);
    let first: &Row = &test.rows[1];
    assert!(off(first.stress[1], law.shear_modulus * first.strain) < 1e-3, "{first:?}");
    let last = test.rows.last().unwrap();
    let tangent = law.friction_critical;
    let sine = tangent / (1.0 + tangent * tangent).sqrt();
    assert!(off(friction(last), sine) < 0.02, "{last:?} for {sine}");
    for row in &test.rows {
        assert!(off(-row.stress[2], 400e3) < 1e-8, "{row:?}");
    }
    let most = test.rows.iter().map(friction).fold(0.0, f64::max);
    assert!(most > 1.3 * sine, "a dense material has a peak: {most} above {sine}");
}

/// Two packings with the noise of some thousand grains on the stress, another start for each.
#[test]
fn the_fit_finds_the_law_that_made_the_data() {
    let wanted = CriticalDruckerPrager { dilation_factor: 9.0, softening_rate: 12.0, ..material() };
    let mut random = Random(7);
    let mut noisy = |stress, fraction| {
        let mut test = made(&wanted, stress, fraction);
        test.rows.iter_mut().for_each(|row| row.stress[1] *= 1.0 + 0.05 * random.signed());
        test
    };
    let tests = [noisy(400e3, 0.844), noisy(400e3, 0.838)];
    let Fit { law: found, at_bound } =
        fit(&tests.each_ref(), [wanted.bulk_modulus, wanted.shear_modulus], None).unwrap();
    println!("{found:?}");
    assert_eq!(at_bound, [""; 0]);
    assert!(off(found.friction_critical, wanted.friction_critical) < 0.01, "{found:?}");
    assert!((found.fraction_critical - wanted.fraction_critical).abs() < 3e-4, "{found:?}");
    assert!(off(found.dilation_factor, wanted.dilation_factor) < 0.03, "{found:?}");
    assert!(off(found.softening_rate, wanted.softening_rate) < 0.03, "{found:?}");
    assert_eq!(found.cohesion, 0.0);
}

/// Under one stress cohesion is what is left once the friction of the same grains without it is known.
#[test]
fn cohesion_is_found_beyond_the_friction_of_dry_grains() {
    let dry = CriticalDruckerPrager { dilation_factor: 9.0, softening_rate: 12.0, ..material() };
    let wanted = CriticalDruckerPrager { cohesion: 20e3, fraction_critical: 0.80, softening_rate: 6.0, ..dry };
    let moduli = [wanted.bulk_modulus, wanted.shear_modulus];
    let friction = fit(&[&made(&dry, 400e3, 0.844)], moduli, None).unwrap().law.friction_critical;
    let found = fit(&[&made(&wanted, 400e3, 0.83)], moduli, Some(friction)).unwrap().law;
    println!("{found:?}");
    assert!(off(found.cohesion, wanted.cohesion) < 0.02, "{found:?}");
    assert!(off(found.friction_critical, wanted.friction_critical) < 0.01, "{found:?}");
    assert!((found.fraction_critical - wanted.fraction_critical).abs() < 3e-4, "{found:?}");
    assert!(off(found.dilation_factor, wanted.dilation_factor) < 0.02, "{found:?}");
}

/// A material whose strength does not hang on its fraction has chi = 0, and less is not asked for.
#[test]
fn a_figure_that_stops_at_its_bound_is_marked() {
    let flat = CriticalDruckerPrager { dilation_factor: 0.0, softening_rate: 12.0, ..material() };
    let found = fit(&[&made(&flat, 400e3, 0.84)], [flat.bulk_modulus, flat.shear_modulus], None).unwrap();
    assert_eq!(found.at_bound, ["dilation_factor"], "{found:?}");
}

/// By the law itself: Kirchhoff stresses rise by K and by M from the pressure on, stresses by the pressure more.
#[test]
fn moduli_are_slopes_of_the_stress_by_the_volume_of_the_start() {
    let law = material();
    let pressed = |axes: [f64; 2]| -> Vec<Row> {
        let mut memory = MaterialLaw::<Plane>::start(&law, &(Tensor::identity() * -400e3), 0.84);
        let row = |number: u32| {
            let strain = 1e-5 * f64::from(number);
            // In one piece of [`ROW_VOLUME`] after another, of the size that it has then.
            if number > 0 {
                let shrunk = |axis: usize| math::exp(-1e-5 * axes[axis]) - 1.0;
                let gradient = Tensor::new(shrunk(0), 0.0, 0.0, shrunk(1));
                MaterialLaw::<Plane>::update(&law, &gradient, 1.0, &mut memory);
            }
            let stress = MaterialLaw::<Plane>::stress(&law, &memory) * math::exp(strain);
            Row::of::<Plane>(strain, &stress, 0.84 * math::exp(strain))
        };
        (0..=20).map(row).collect()
    };
    let bulk = modulus(&pressed([0.5, 0.5]), pressure);
    assert!(off(bulk, law.bulk_modulus) < 1e-6, "{bulk}");
    let p_wave = modulus(&pressed([0.0, 1.0]), axial);
    assert!(off(p_wave, law.bulk_modulus + law.shear_modulus) < 1e-6, "{p_wave}");
}

/// `scree calibrate` of the quickstart, with more of the line.
fn command(out: &Path, cache: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scree"))
        .args(["calibrate", "jobs/quickstart.toml", "--set", &format!("packing.cache={}", cache.display()), "--out"])
        .arg(out)
        .args(more)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program can be started")
}

fn calibrated(out: &Path, cache: &Path, threads: &str) -> String {
    let small = ["--grains", "200", "--packings", "2", "--strain", "0.3", "--threads", threads];
    let output = command(out, cache, &small);
    assert!(output.status.success(), "{}", words(&output));
    String::from_utf8(output.stdout).expect("it is text")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Few grains and little strain: the figures are rough, the way is whole. The same bits on one thread, from packings that
/// are made, and on two, from the cache; and the job takes what came.
#[test]
fn a_job_is_calibrated_and_takes_its_fragment() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    let cache = folder.path().join("cache");
    let told = calibrated(&first, &cache, "1");
    calibrated(&second, &cache, "2");
    for name in ["calibrated.toml", "calibration.json", "calibration.html", "shear.toml", "figures/shear.svg"] {
        assert_eq!(read(&first.join(name)), read(&second.join(name)), "{name}");
    }
    for wanted in ["bulk_modulus", "softening_rate", "630 MPa"] {
        assert!(told.contains(wanted), "{told}");
    }
    let page = read(&first.join("calibration.html"));
    assert!(!page.contains("NaN") && page.contains("Table 2"));

    let job = read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/quickstart.toml")));
    let (head, rest) = job.split_once("bulk_modulus").unwrap();
    let (_, tail) = rest.split_once("softening_rate = 3.0\n").unwrap();
    let file = first.join("job.toml");
    std::fs::write(&file, format!("{head}file = \"calibrated.toml\"\n{tail}")).unwrap();
    let scenario = Scenario::load(&file, &[]).unwrap_or_else(|error| panic!("{error}"));
    let law = scenario.material.law.critical().unwrap();
    let json: serde_json::Value = serde_json::from_str(&read(&first.join("calibration.json"))).unwrap();
    let found = |key: &str| json["material"][key]["value"].as_f64().unwrap();
    assert!(off(law.bulk_modulus, found("bulk_modulus")) < 1e-3);
    assert!(off(law.dilation_factor, found("dilation_factor")) < 1e-3);
    assert!(off(law.friction_angle_critical, found("friction_angle_critical")) < 1e-3);
    // Within what any packing of these discs has.
    assert!((50e6..120e6).contains(&law.bulk_modulus), "{told}");
    assert!((0.1..0.5).contains(&law.friction_angle_critical), "{told}");
    // What the run keeps has the numbers themselves, and --set overrides the file.
    assert!(!scenario.to_toml().contains("calibrated"));
    let set = Scenario::load(&file, &["material.bulk_modulus=70 MPa".to_string()]).unwrap();
    assert_eq!(set.material.law.bulk_modulus(2), 70e6);
}

/// Grains that cohere are sheared without cohesion, too, and that test has a file of its own. The job is loaded at half of the
/// stress of its packing, which is said, and without a continuum of its own.
#[test]
fn cohesive_grains_are_tested_without_cohesion_as_well() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let sets = [
        "contact.law=linear_cohesive",
        "contact.cohesion_normal=1 N",
        "contact.cohesion_tangential=1 N",
        "method=dem",
        "loading.stress_normal=200 kPa",
    ];
    let mut more = vec!["--packings", "1", "--grains", "200", "--strain", "0.15"];
    sets.iter().for_each(|set| more.extend(["--set", set]));
    let output = command(&out, &folder.path().join("cache"), &more);
    assert!(output.status.success(), "{}", words(&output));
    let told = words(&output);
    let line = |key: &str| told.lines().find(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{key}: {told}"));
    assert!(line("bulk_modulus").ends_with(" -"), "a job of grains alone has no continuum now: {told}");
    assert!(told.contains("packing.stress = 400 kPa") && told.contains("loading.stress_normal = 200 kPa"), "{told}");
    let [with, without] = ["shear", "shear_without_cohesion"].map(|name| read(&out.join(format!("{name}.toml"))));
    assert!(with.contains("cohesion_normal = 1.0") && without.contains("cohesion_normal = 0.0"), "{with}\n{without}");
    // Both are of one packing, which is made without cohesion.
    let cached = std::fs::read_dir(folder.path().join("cache")).unwrap().count();
    assert_eq!(cached, 1, "packings of one seed");
    assert!(without.contains("name = \"quickstart_shear_without_cohesion_1\""), "{without}");
    let json: serde_json::Value = serde_json::from_str(&read(&out.join("calibration.json"))).unwrap();
    assert!(json["packings"][0]["shear_without_cohesion"]["strain"].as_array().unwrap().len() > 100);
    // Whoever is at a bound is so in the table, in the fragment and in the data.
    let fragment = read(&out.join("calibrated.toml"));
    for (key, figure) in json["material"].as_object().unwrap() {
        let is_at_bound = figure["at_bound"].as_bool().unwrap();
        assert_eq!(line(key).contains("at its bound"), is_at_bound, "{told}");
        let (before, _) = fragment.split_once(&format!("\n{key} = ")).unwrap();
        assert_eq!(before.lines().last().unwrap().contains("at its bound"), is_at_bound, "{fragment}");
    }
}

/// What has no grains that calibration could make is refused, and leaves nothing behind.
#[test]
fn jobs_of_other_grains_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let refused = |more: &[&str], wanted: &[&str]| {
        let output = command(&out, &folder.path().join("cache"), more);
        let told = words(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        wanted.iter().for_each(|wanted| assert!(told.contains(wanted), "{wanted}: {told}"));
        assert!(!out.exists(), "a folder was left");
    };
    refused(&["--set", "grains.file=grains.csv"], &["jobs/quickstart.toml: grains.file = ", "Calibrate a copy"]);
    let alone = ["--set", "method=mpm", "--set", "material.fraction=0.84"];
    refused(&alone, &["jobs/quickstart.toml: ", "material.fraction", "--set method=dem"]);
}

/// Grains beside a continuum on a grid are tested as those of planar shear are; what has no grains, or no continuum, is told so.
#[test]
fn grains_of_a_job_on_a_grid_are_tested() {
    let load = |path: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        Subject::of(&Job::load(&path, &[]).unwrap(), "job.toml", false)
    };
    let subject = load("jobs/triaxial.toml").unwrap();
    assert_eq!(subject.stress, 100e3);
    assert!(subject.now.is_some());
    let wanted = Wanted { grains: 300, packings: 1, strain: 0.2 };
    let tests = elements(&subject, wanted, 7);
    assert_eq!(tests.len(), 3);
    for test in tests {
        let job = test.job().unwrap_or_else(|error| panic!("{}: {error}", test.name()));
        assert_eq!((job.contact, job.seed, job.cell.periodic), (subject.piece.contact, 7, [true, true, false]));
    }
    let told = |path: &str| load(path).unwrap_err().to_string();
    assert!(told("jobs/continuum/column_collapse.toml").contains("has no grains"));
    assert!(told("jobs/element/uniaxial.toml").contains("no continuum to calibrate"));
}

/// The law with mobilised friction goes the whole way, with the same bits on one thread and on two, and a job on a grid takes what
/// came; planar shear says that it does not. So few grains tell no parameter.
#[test]
fn mobilised_friction_is_calibrated_and_taken_by_a_grid() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    let cache = folder.path().join("cache");
    let calibrated = |out: &Path, threads: &str| {
        let mut more = vec!["--law", "mobilised_friction", "--grains", "120", "--packings", "2", "--held-back", "1"];
        more.extend(["--strain", "0.12", "--threads", threads]);
        let output = command(out, &cache, &more);
        assert!(output.status.success(), "{}", words(&output));
        String::from_utf8(output.stdout).expect("it is text")
    };
    let told = calibrated(&first, "1");
    calibrated(&second, "2");
    for name in ["calibrated.toml", "calibration.json", "calibration.html", "reversal.toml", "figures/shear.svg"] {
        assert_eq!(read(&first.join(name)), read(&second.join(name)), "{name}");
    }
    for wanted in [
        "hardening_strain",
        "hardening_fraction_width",
        "hardening_start",
        "packings held back",
        "shear, loose, half of the stress",
        "constant volume: mean stress, largest off",
        "shear, dense, a quarter of the stress: sine",
        "biaxial: volume strain",
        "small cycles: back from 0.02 % of strain",
        "reversal: back from the peak by 0.8 % of strain",
        "Musts: packings held back",
        "fitted packings",
    ] {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    // Its tests are fitted again to the same files, and those of other grains are not taken for these.
    let third = folder.path().join("third");
    let tests = first.display().to_string();
    let again = ["--law", "mobilised_friction", "--tests", tests.as_str()];
    let output = command(&third, &cache, &again);
    assert!(output.status.success(), "{}", words(&output));
    for name in ["calibrated.toml", "calibration.json", "calibration.html"] {
        assert_eq!(read(&first.join(name)), read(&third.join(name)), "{name}");
    }
    let refused = |more: &[&str], wanted: &str| {
        let output = command(&folder.path().join("none"), &cache, &[&again[..], more].concat());
        let told = words(&output);
        assert!(output.status.code() == Some(2) && told.contains(wanted), "{wanted}: {told}");
        assert!(!folder.path().join("none").exists(), "a folder was left");
    };
    refused(&["--set", "contact.friction=0.3"], "is another test: it has `friction = ");
    refused(&["--set", "seed=9"], "is another test: it has `seed = ");
    refused(&["--packings", "3"], "--packings");
    refused(&["--strain", "0.2"], "--strain");
    let broken = folder.path().join("broken");
    std::fs::create_dir(&broken).unwrap();
    std::fs::write(broken.join("calibration.json"), "{\"grains\": 120}").unwrap();
    let there = broken.display().to_string();
    let output = command(&folder.path().join("none"), &cache, &["--law", "mobilised_friction", "--tests", &there]);
    assert!(
        words(&output).contains("calibration.json: is not what this version of scree writes"),
        "{}",
        words(&output)
    );
    assert!(!read(&first.join("calibration.html")).contains("NaN"));
    let json: serde_json::Value = serde_json::from_str(&read(&first.join("calibration.json"))).unwrap();
    let found = |key: &str| json["material"][key]["value"].as_f64().unwrap();
    assert!((50e6..120e6).contains(&found("bulk_modulus")), "{told}");
    assert_eq!(json["packings"].as_array().unwrap().len(), 2);
    assert_eq!(json["packings_held_back"].as_array().unwrap().len(), 1);

    let jobs = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/jobs"));
    let job = read(&jobs.join("continuum/column_collapse.toml"));
    let (head, rest) = job.split_once("law = \"critical_drucker_prager\"\n").unwrap();
    let (_, tail) = rest.split_once("cohesion = 0\n").unwrap();
    let density = "density = \"2200 kg/m3\"\nfraction = 0.84\n";
    let file = first.join("job.toml");
    std::fs::write(&file, format!("{head}file = \"calibrated.toml\"\n{density}{tail}")).unwrap();
    let loaded = Job::load(&file, &[]).unwrap_or_else(|error| panic!("{error}"));
    let ConstitutiveLaw::MobilisedFriction(law) = loaded.as_mpm().unwrap().material.law else {
        panic!("another law was read");
    };
    assert!(off(law.hardening_strain, found("hardening_strain")) < 1e-3);
    assert!(off(law.hardening_fraction_width.unwrap(), found("hardening_fraction_width")) < 1e-3);
    assert!(off(law.hardening_start, found("hardening_start")) < 1e-3);
    assert!(off(law.shear_modulus, found("shear_modulus")) < 1e-3);
    // The law stands in the file, and in the job no second time.
    std::fs::write(&file, job.replace("[material]\n", "[material]\nfile = \"calibrated.toml\"\n")).unwrap();
    let refused = Job::load(&file, &[]).unwrap_err().to_string();
    assert!(refused.contains("material.law") && refused.contains("stands in"), "{refused}");
    let set = format!("material.file=\"{}\"", first.join("calibrated.toml").display());
    let sheared = Job::load(&jobs.join("planar_shear.toml"), &[set]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(sheared.continuum().unwrap().material.law.shear_modulus(), law.shear_modulus);
}

/// Any job that makes its grains is taken with the law; others are told why not, and leave nothing behind.
#[test]
fn jobs_of_grains_alone_are_taken_with_mobilised_friction() {
    let load = |path: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        Subject::of(&Job::load(&path, &[]).unwrap(), "job.toml", true)
    };
    let subject = load("jobs/element/uniaxial.toml").unwrap();
    let wanted = mobilised::Wanted { grains: 300, packings: 1, held: 0, strain: 0.4 };
    for test in mobilised::elements(&subject, wanted, 7) {
        let job = test.job().unwrap_or_else(|error| panic!("{}: {error}", test.name()));
        assert_eq!((job.contact, job.seed), (subject.piece.contact, 7), "{}", test.name());
    }
    let spheres = load("jobs/element/bulk_spheres.toml").unwrap();
    for test in mobilised::elements(&spheres, wanted, 7) {
        let job = test.job().unwrap_or_else(|error| panic!("{}: {error}", test.name()));
        assert_eq!((job.contact, job.cell.dimension, job.cell.periodic), (spheres.piece.contact, 3, [true; 3]));
    }
    assert!(load("jobs/element/two_discs.toml").unwrap_err().to_string().contains("grains.file"));
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = command(&out, &folder.path().join("cache"), &["--held-back", "2"]);
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    assert!(words(&output).contains("--law mobilised_friction") && !out.exists(), "{}", words(&output));
}

/// Spheres in a cell: K and G as their compressions have them in space, the pressure of a row that of three stresses.
#[test]
fn spheres_are_compressed_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        r#"
        name = "spheres"
        [cell]
        space = "solid"
        upper = ["7 mm", "7 mm", "7 mm"]
        [grains]
        density = "2500 kg/m3"
        count = 300
        distribution = "uniform"
        diameter_min = "0.9 mm"
        diameter_max = "1.1 mm"
        [packing]
        preparation = "compress"
        stress = "1 MPa"
        energy_ratio_max = 1e-3
        cache = {:?}
        [contact]
        law = "linear"
        stiffness_normal = "1000 kN/m"
        stiffness_tangential = "500 kN/m"
        restitution = 0.3
        friction = 0.5
        [time]
        step = "0.1 us"
        end = "1 ms"
        "#,
        folder.path()
    );
    let subject = Subject::of(&Job::parse(&text, "spheres", &[]).unwrap(), "spheres", true).unwrap();
    let wanted = mobilised::Wanted { grains: 300, packings: 1, held: 0, strain: 0.1 };
    let tests = mobilised::elements(&subject, wanted, 1);
    let [isotropic, uniaxial] = [0, 1].map(|test: usize| tests[test].measure().unwrap());
    let [bulk, shear] = moduli(3, &isotropic, &uniaxial);
    println!("K {:.1} MPa, G {:.1} MPa", 1e-6 * bulk, 1e-6 * shear);
    let first = &uniaxial[0];
    // At rest under the stress all three are it; pressed along y alone that one is the largest, and the third counts.
    assert!(off(first.pressure, 1e6) < 0.02 && off(-first.stress[2], 1e6) < 0.02, "{first:?}");
    let last = uniaxial.last().unwrap();
    assert!(-last.stress[2] > last.pressure && last.pressure > 1.2 * first.pressure, "{last:?}");
    // Walton (1987) for equal forces at Z contacts: affine, an upper bound that packings come near.
    let contacts = 6.0;
    let affine = contacts * isotropic[0].fraction * 1e6 / (3.0 * std::f64::consts::PI * 1e-3);
    assert!((0.7..1.05).contains(&(bulk / affine)), "K {bulk} for {affine}");
    // G is M - K times 3/4; affine 3/5 (1 + 3/2 k_t/k_n) K.
    assert!((0.7..1.05).contains(&(shear / bulk)), "G {shear} for K {bulk}");
}

/// By hand, in space: plane strain compression along y with the stress along x kept, of an elastic material.
#[test]
fn an_elastic_point_in_space_is_compressed_in_plane_strain() {
    let (bulk, shear) = (30e6, 20e6);
    let law = CriticalDruckerPrager { bulk_modulus: bulk, shear_modulus: shear, cohesion: 1e9, ..material() };
    let drive = Drive { kept: Kept::LateralStress, ..Drive::shear(3, 1e5, 0.6) };
    let rows = sheared(&law, drive, [0.0, 1e-4].into_iter()).unwrap();
    let (last, _) = rows[1];
    // sigma_x = lambda (ex + ey) + 2 G ex stays, with lambda = K - 2 G/3.
    let lambda = bulk - 2.0 * shear / 3.0;
    let [y, x] = [-1e-4, 1e-4 * lambda / (lambda + 2.0 * shear)];
    let change = [lambda * (x + y) + 2.0 * shear * x, lambda * (x + y) + 2.0 * shear * y, lambda * (x + y)];
    assert!(off(last.stress[0], -1e5) < 1e-8, "{last:?}");
    assert!(off(last.stress[2] + 1e5, change[1]) < 1e-2, "{last:?}, {change:?}");
    assert!(off(last.pressure - 1e5, -(change[0] + change[1] + change[2]) / 3.0) < 1e-2, "{last:?}, {change:?}");
    let nine = <Solid as Space>::Tensor::from_fn(|row, column| -((3 * row + column) as f64));
    let row = Row::of::<Solid>(0.1, &nine, 0.6);
    assert_eq!((row.stress, row.pressure), ([0.0, -2.0, -4.0], 4.0));
}
