//! What somebody meets who has never used the program: a job to begin with, the example of the handbook, keys and mistakes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn scree(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scree"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program can be started")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn a_hybrid_runs_at_the_first_try() {
    let folder = tempfile::tempdir().unwrap();
    let made = scree(folder.path(), &["new", "hybrid"]);
    fs::write(folder.path().join("a.toml"), &made.stdout).unwrap();
    let ran = scree(folder.path(), &["run", "a.toml"]);
    assert!(ran.status.success(), "{}", told(&ran));
    let series = fs::read_to_string(folder.path().join("runs/hybrid/series.csv")).unwrap();
    let grains = series.lines().next().unwrap().split(',').position(|name| name == "grains").unwrap();
    let last = series.lines().last().unwrap().split(',').nth(grains).unwrap().parse::<f64>().unwrap();
    assert!(last > 100.0, "a band was found, and grains took its place: {last}");
}

/// The job on a grid that stands in comments below planar shear.
fn lowered(expanded: &str) -> String {
    let (_, lowered) = expanded.split_once("without these marks:\n#\n").unwrap_or_else(|| panic!("{expanded}"));
    lowered.lines().map(|line| line.strip_prefix('#').unwrap().trim_start().to_string() + "\n").collect()
}

/// An elastic material has no solid volume fraction; its expansion once had one, and was refused.
#[test]
fn elastic_planar_shear_expands_to_a_job_that_is_good() {
    let folder = tempfile::tempdir().unwrap();
    let made = told(&scree(folder.path(), &["new", "mpm"]));
    let from = made.find("[material]").unwrap();
    let to = from + 1 + made[from + 1..].find("\n[").unwrap();
    let elastic = "[material]\nlaw = \"hencky\"\nbulk_modulus = \"86 MPa\"\nshear_modulus = \"39 MPa\"\n";
    fs::write(folder.path().join("elastic.toml"), format!("{}{elastic}{}", &made[..from], &made[to..])).unwrap();
    let expanded = told(&scree(folder.path(), &["check", "--expand", "elastic.toml", "--set", "continuum.weak=[]"]));
    fs::write(folder.path().join("lowered.toml"), lowered(&expanded)).unwrap();
    let checked = told(&scree(folder.path(), &["check", "lowered.toml"]));
    assert!(checked.contains("The job is good"), "{checked}");
}

/// The tables that planar shear means run as a job on a grid, to its stress and its volume.
#[test]
fn planar_shear_is_what_its_expansion_says() {
    let folder = tempfile::tempdir().unwrap();
    let sets = ["--set", "material.fraction=0.843", "--set", "loading.strain_end=0.02"];
    fs::write(folder.path().join("preset.toml"), scree(folder.path(), &["new", "mpm"]).stdout).unwrap();
    let expanded = told(&scree(folder.path(), &[&["check", "--expand", "preset.toml"], &sets[..]].concat()));
    fs::write(folder.path().join("lowered.toml"), lowered(&expanded)).unwrap();
    let last = |job: &str, more: &[&str], wanted: &[&str]| -> Vec<f64> {
        let ran = scree(folder.path(), &[&["run", job, "--out", &job.replace(".toml", "")], more].concat());
        assert!(ran.status.success(), "{}", told(&ran));
        let series = fs::read_to_string(folder.path().join(job.replace(".toml", "/series.csv"))).unwrap();
        let names: Vec<&str> = series.lines().next().unwrap().split(',').collect();
        let row: Vec<f64> = series.lines().last().unwrap().split(',').map(|number| number.parse().unwrap()).collect();
        wanted.iter().map(|name| row[names.iter().position(|at| at == name).unwrap()]).collect()
    };
    let preset = last("preset.toml", &sets, &["shear_stress", "elastic_points"]);
    let lowered = last("lowered.toml", &[], &["upper_force_x", "elastic"]);
    let grid: toml::Table = toml::from_str(&fs::read_to_string(folder.path().join("lowered.toml")).unwrap()).unwrap();
    let grid = grid["grid"].as_table().unwrap();
    let [width, depth] = ["upper", "depth"].map(|key| {
        let value = &grid[key];
        value.as_float().or_else(|| value.as_array()?[0].as_float()).unwrap()
    });
    let lowered = [-lowered[0] / (width * depth), lowered[1]];
    for (of_preset, of_lowered) in preset.iter().zip(lowered) {
        assert!((of_lowered / of_preset - 1.0).abs() < 2e-3, "{preset:?} {lowered:?}");
    }
}

#[test]
fn the_example_of_the_handbook_runs_as_printed() {
    let page = include_str!("../../docs/planar_shear.md");
    let example = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.toml"), example).unwrap();
    let ran = scree(folder.path(), &["run", "mine.toml"]);
    assert!(ran.status.success(), "{}", told(&ran));
}

/// Of keys that are wrong by themselves each is told, with the line and marks below it; so are all checks of several keys.
#[test]
fn all_mistakes_are_told_at_once() {
    let page = include_str!("../../docs/planar_shear.md");
    let example = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let said = |text: &str| {
        fs::write(folder.path().join("mine.toml"), text).unwrap();
        let checked = scree(folder.path(), &["check", "mine.toml"]);
        assert_eq!(checked.status.code(), Some(2));
        String::from_utf8_lossy(&checked.stderr).into_owned()
    };
    let wrong = example
        .replace("\"24 mm\"", "\"2 cm/s\"")
        .replace("stiffness_normal = ", "stifness_normal = ")
        .replace("density = \"2530 kg/m3\"\n", "");
    let keys = said(&wrong);
    for part in [
        "mine.toml: 3 mistakes.",
        "mine.toml:5: specimen.width = \"2 cm/s\" is a speed, but a length (m) is wanted. Write for example width = \"6 cm\".\n  5 | width = \"2 cm/s\"\n    |         ^^^^^^^^\n",
        "[contact] has no key stifness_normal. Did you mean stiffness_normal?",
        "[grains] has no density, the density of the matter of a grain, without pores.",
    ] {
        assert!(keys.contains(part), "{part}\n{keys}");
    }
    let together = said(&(example.replace("\"400 kPa\"", "1e9") + "step = \"1 ms\"\n"));
    assert!(together.contains("loading.stress_normal = 1e9 squeezes"), "{together}");
    assert!(together.contains("time.step = \"1 ms\" is unstable"), "{together}");
}

#[test]
fn keys_schema_completions_and_manual() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, part) in [
        (vec!["keys"], "[contact]"),
        (vec!["keys", "contact"], "stiffness_normal = \"1772 kN/m\""),
        (vec!["keys", "body.servo"], "speed_max"),
        (vec!["keys", "contact.friction"], "friction = 0.5"),
        (vec!["schema"], "\"$schema\""),
        (vec!["completions", "bash"], "complete"),
        (vec!["man"], ".TH scree"),
        (vec!["new", "continuum"], "[grid]"),
    ] {
        let output = scree(folder.path(), &arguments);
        assert!(output.status.success() && told(&output).contains(part), "{arguments:?}: {}", told(&output));
    }
    let expanded = scree(folder.path(), &["new", "pour"]);
    fs::write(folder.path().join("pour.toml"), expanded.stdout).unwrap();
    let expanded = told(&scree(folder.path(), &["check", "--expand", "pour.toml"]));
    assert!(expanded.contains("checkpoints_kept = 3"), "{expanded}");
}

/// What grains in a cell have grains beside a continuum on a grid have too: export, dumps, contacts, frames of contacts, and a
/// file of the material; `check` once sent for another remedy.
#[test]
fn a_grid_with_grains_has_what_grains_have() {
    let folder = tempfile::tempdir().unwrap();
    let gate = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gate/triaxial.toml");
    let gate = gate.to_str().unwrap();
    let set = ["--set", "method=dem", "--set", "output.contact_frames=true", "--set", "packing.cache=cache"];
    let cache = format!("packing.cache={}", folder.path().join("cache").display());
    let set: Vec<&str> =
        set.into_iter().map(|word| if word == "packing.cache=cache" { &cache } else { word }).collect();
    let ran = scree(folder.path(), &[&["run", gate, "--out", "run"], &set[..]].concat());
    assert!(ran.status.success(), "{}", told(&ran));
    assert!(folder.path().join("run/contacts.vtkhdf").is_file());
    for files in [
        ["--grains", "grains.csv", "--contacts", "contacts.csv"],
        ["--grains", "grains.data", "--lammps-dump", "grains.dump"],
    ] {
        let exported = scree(folder.path(), &[&["export", "run"], &files[..]].concat());
        assert!(exported.status.success(), "{}", told(&exported));
    }
    let grains = fs::read_to_string(folder.path().join("grains.csv")).unwrap();
    let dump = fs::read_to_string(folder.path().join("grains.dump")).unwrap();
    let atoms = dump.lines().skip_while(|line| !line.contains("NUMBER OF ATOMS")).nth(1).unwrap();
    assert_eq!(atoms.parse::<usize>().unwrap(), grains.lines().count() - 1);
    let mass = dump.lines().last().unwrap().split(' ').nth(12).unwrap().parse::<f64>().unwrap();
    assert!(mass > 0.0, "grains have their mass: {mass}");
    let contacts = fs::read_to_string(folder.path().join("contacts.csv")).unwrap();
    assert!(
        contacts.starts_with("lower,higher,force_normal,force_tangential,memory_") && contacts.lines().count() > 100
    );
    let forces = scree(folder.path(), &["export", "run", "--grains", "forces.csv", "--forces"]);
    assert!(!forces.status.success() && told(&forces).contains("Leave --velocities now and --forces out"));

    let material = "[continuum]\nbulk_modulus = \"86.4 MPa\"\nshear_modulus = \"39.3 MPa\"\nfriction_angle_critical = 0.35\nfraction_critical = 0.815\ndilation_factor = 5\nsoftening_rate = 10\ncohesion = 0\n";
    fs::write(folder.path().join("material.toml"), material).unwrap();
    let text = fs::read_to_string(gate).unwrap();
    let (from, to) = (text.find("bulk_modulus").unwrap(), text.find("fraction = 0.842").unwrap());
    let of_file = format!("{}file = \"material.toml\"\n{}", &text[..from], &text[to..]);
    let rest = of_file.replace("softening_rate = 10\n", "").replace("dilation_factor = 5\n", "");
    fs::write(folder.path().join("of_file.toml"), rest).unwrap();
    let expanded =
        [gate, "of_file.toml"].map(|job| told(&scree(folder.path(), &["check", "--expand", job, "--set", &cache])));
    assert!(expanded[0] == expanded[1], "{}\n{}", expanded[0], expanded[1]);
}

/// A missing acceleration of gravity was once shown with its value along every axis.
#[test]
fn gravity_is_shown_along_one_axis() {
    let folder = tempfile::tempdir().unwrap();
    let job = told(&scree(folder.path(), &["new", "continuum"])).replace("acceleration =", "# acceleration =");
    fs::write(folder.path().join("job.toml"), job).unwrap();
    let checked = told(&scree(folder.path(), &["check", "job.toml"]));
    assert!(checked.contains("Add for example acceleration = [0, \"-9.81 m/s2\"]."), "{checked}");
}

/// `edge_xx` stands in the page as `edge_ij`, `floor_force_z` as `NAME_force_i`, and so on.
fn as_in_the_page(column: &str) -> Vec<String> {
    let is_axes = |end: &str| end.chars().all(|axis| "xyz".contains(axis));
    let general = |name: &str| match name.rsplit_once('_') {
        Some((of, end)) if is_axes(end) && end.len() == 1 => format!("{of}_i"),
        Some((of, end)) if is_axes(end) && end.len() == 2 => format!("{of}_ij"),
        _ => name.to_string(),
    };
    let mut names = vec![column.to_string(), general(column)];
    if let Some((_, rest)) = column.split_once('_') {
        names.extend([format!("NAME_{rest}"), format!("NAME_{}", general(rest))]);
    }
    names
}

#[test]
fn every_column_of_series_is_told() {
    let page = include_str!("../../docs/columns.md");
    let folder = tempfile::tempdir().unwrap();
    let triaxial = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/triaxial.toml");
    let column = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/continuum/column_collapse.toml");
    for (job, sets) in [
        ("element", vec!["time.end=1e-4"]),
        ("pour", vec!["time.end=1e-4"]),
        ("hybrid", vec!["loading.strain_end=1e-4"]),
        (column, vec!["time.end=2e-2"]),
        (triaxial, vec!["time.end=1e-4", "method=mpm"]),
    ] {
        let mut arguments = vec!["run", job, "--threads", "1", "--out", "run", "--set", "output.energy_balance=true"];
        if !job.ends_with(".toml") {
            fs::write(folder.path().join("job.toml"), scree(folder.path(), &["new", job]).stdout).unwrap();
            arguments[1] = "job.toml";
        }
        sets.iter().for_each(|set| arguments.extend(["--set", set]));
        let ran = scree(folder.path(), &arguments);
        assert!(ran.status.success(), "{job}: {}", told(&ran));
        let series = fs::read_to_string(folder.path().join("run/series.csv")).unwrap();
        for column in series.lines().next().unwrap().split(',') {
            let stands = as_in_the_page(column).iter().any(|name| page.contains(&format!("`{name}`")));
            assert!(stands, "docs/columns.md has no {column} of {job}");
        }
        fs::remove_dir_all(folder.path().join("run")).unwrap();
    }
}

/// What was asked by people who know other programs.
#[test]
fn mistakes_are_answered_by_what_was_meant() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.toml"), scree(folder.path(), &["new", "element"]).stdout).unwrap();
    for (set, part) in [
        ("contct.friction=0.2", "Did you mean contact.friction?"),
        ("contact.mu=0.2", "Did you mean contact.friction_angle, the angle whose tangent is mu, in place of friction?"),
        ("contact.viscosity=0.2", "[contact] has: law, stiffness_normal,"),
        ("contact.density=3", "Did you mean grains.density?"),
        ("friction=0.2", "Did you mean packing.friction or contact.friction?"),
    ] {
        let checked = scree(folder.path(), &["check", "job.toml", "--set", set]);
        assert_eq!(checked.status.code(), Some(2));
        assert!(told(&checked).contains(part), "{set}: {}", told(&checked));
    }
    for (word, part) in [("mu", "contact.friction "), ("rolling", "contact.rolling_limit "), ("damping", "[damping]")] {
        let keys = scree(folder.path(), &["keys", word]);
        assert!(keys.status.success() && told(&keys).contains(part), "{word}: {}", told(&keys));
    }
}
