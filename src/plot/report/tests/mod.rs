//! A report from a small run on disk, and from runs that lack something.

use std::fs;
use std::path::Path;

use made_up::Made;

use super::write;

pub mod made_up;
mod pressed;
mod shear;

fn run(directory: &Path, method: &str) {
    Made::of(method).write(directory);
}

fn count(text: &str, part: &str) -> usize {
    text.matches(part).count()
}

#[test]
fn a_hybrid_run_becomes_one_page_with_its_drawings() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("a");
    run(&directory, "hybrid");
    let page = write(std::slice::from_ref(&directory), None, None).unwrap();
    assert_eq!(page, directory.join("report.html"));
    let html = fs::read_to_string(&page).unwrap();
    assert_eq!(count(&html, "<svg "), count(&html, "<figcaption>"));
    for name in ["shear_stress", "bands", "volume", "specimen", "energies"] {
        let drawing = fs::read_to_string(directory.join(format!("figures/{name}.svg"))).unwrap();
        let (drawing, mark) = drawing.split_once("</svg>\n").unwrap();
        assert!(drawing.starts_with("<svg xmlns=") && mark == "<!-- written by scree -->\n", "{mark}");
        assert!(html.contains(drawing), "{name} is not in the page");
    }
    // Nothing is fetched, nothing runs, and names stay text.
    for foreign in ["<script", "<link", "src=", "@import", "<small"] {
        assert_eq!(count(&html, foreign), 0, "{foreign}");
    }
    assert_eq!(count(&html, "http://"), count(&html, "http://www.w3.org/2000/svg"));
    assert!(!html.contains("NaN") && !html.contains("inf "));

    let words = fs::read_to_string(directory.join("report.txt")).unwrap();
    assert!(words.contains("At 5.05 % of horizontal strain"), "{words}");
    assert!(words.contains("320 grains took the place"), "{words}");
    assert!(words.contains("gathered in a single row, 20"), "{words}");
    assert!(words.contains("100 % of it is inside the zone"), "{words}");
}

#[test]
fn runs_are_compared_in_one_page() {
    let folder = tempfile::tempdir().unwrap();
    let directories = ["hybrid", "dem", "mpm"].map(|method| {
        let directory = folder.path().join(method);
        run(&directory, method);
        directory
    });
    let out = folder.path().join("compared/page.html");
    assert_eq!(write(&directories, Some(&out), None).unwrap(), out);
    let html = fs::read_to_string(&out).unwrap();
    assert!(html.contains("compared</h1>"));
    assert!(html.contains("<th>small &lt;dem&gt;</th>"));
    let specimen = fs::read_to_string(folder.path().join("compared/figures/specimen.svg")).unwrap();
    assert_eq!(count(&specimen, "(c) end"), 3);
    // All three are drawn at the same strains.
    for strain in ["strain 4\u{2009}%", "strain 5\u{2009}%", "strain 10\u{2009}%"] {
        assert_eq!(count(&specimen, strain), 3, "{strain}");
    }
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("a");
    run(&directory, "hybrid");
    let once = fs::read(write(std::slice::from_ref(&directory), None, None).unwrap()).unwrap();
    let again = fs::read(write(std::slice::from_ref(&directory), None, None).unwrap()).unwrap();
    assert!(once == again);
}

#[test]
fn what_is_missing_or_torn_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    run(&whole, "hybrid");
    let complaint = |name: &str, spoil: &dyn Fn(&Path)| {
        let directory = folder.path().join("spoilt");
        let _ = fs::remove_dir_all(&directory);
        fs::create_dir_all(&directory).unwrap();
        for file in ["scenario.toml", "summary.json", "series.csv", "frames.vtkhdf"] {
            fs::copy(whole.join(file), directory.join(file)).unwrap();
        }
        spoil(&directory.join(name));
        let error = write(std::slice::from_ref(&directory), None, None).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(error.to_string().contains(name), "{error}");
        assert!(!directory.join("report.html").exists());
        error.to_string()
    };
    let remove = |path: &Path| fs::remove_file(path).unwrap();
    let cut = |path: &Path| {
        let bytes = fs::read(path).unwrap();
        fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
    };
    for name in ["scenario.toml", "series.csv", "frames.vtkhdf"] {
        assert!(complaint(name, &remove).contains("is missing"));
    }
    complaint("summary.json", &cut);
    complaint("frames.vtkhdf", &cut);
    let emptied = |path: &Path| fs::write(path, "step,time\n").unwrap();
    assert!(complaint("series.csv", &emptied).contains("no rows"));
    let other = |path: &Path| fs::write(path, "step,time\n1,2\n").unwrap();
    assert!(complaint("series.csv", &other).contains("no column `strain`"));
    let narrow = |path: &Path| fs::write(path, "name = \"x\"\n").unwrap();
    assert!(complaint("scenario.toml", &narrow).contains("no table `specimen`"));
}

#[test]
fn a_report_on_nothing_is_refused() {
    assert_eq!(write(&[], None, None).unwrap_err().exit_code(), 2);
}

/// Runs three grains over a floor in a cell, one of them glued to a lid, and draws them.
fn assembly(folder: &Path, space: &str) -> (String, String) {
    const JOB: &str = r#"
name = "few"
[cell]
space = "SPACE"
lower = [0, 0, 0]
upper = ["3 mm", "3 mm", "6 mm"]
periodic = [true, true, false]
gravity = [0, 0, "-9.81 m/s2"]
[grains]
density = "2530 kg/m3"
file = "FILE"
diameter_mean = "1 mm"
[contact]
law = "linear"
stiffness_normal = 1e5
stiffness_tangential = 5e4
damping_normal = "0.1 N s/m"
damping_tangential = "0.1 N s/m"
friction = 0.5
[time]
step = "0.5 us"
end = "0.5 ms"
[[body]]
name = "floor"
shape = "plane"
point = [0, 0, "1 mm"]
normal = [0, 0, 1]
[[body]]
name = "lid"
shape = "layer"
lower = [0, 0, "4 mm"]
upper = ["3 mm", "3 mm", "5 mm"]
"#;
    let file = folder.join(format!("{space}.csv"));
    let (header, places) = match space {
        "plane" => ("id,x,y,radius", ["2.9e-3,1.49e-3", "0.89e-3,1.49e-3", "1e-3,4.5e-3"]),
        _ => ("id,x,y,z,radius", ["2.9e-3,1e-3,1.49e-3", "0.89e-3,1e-3,1.49e-3", "1e-3,1e-3,4.5e-3"]),
    };
    let rows: Vec<String> = places.iter().enumerate().map(|(id, place)| format!("{id},{place},5e-4\n")).collect();
    fs::write(&file, format!("{header}\n{}", rows.concat())).unwrap();
    let mut text = JOB.replace("SPACE", space).replace("FILE", &file.display().to_string());
    if space == "plane" {
        for axes in ["[0, 0, 0]", "[true, true, false]", "[0, 0, 1]"] {
            text = text.replace(axes, &axes.replacen(", 0", "", 1).replacen(", true", "", 1));
        }
        text = text.replace("\"3 mm\", \"3 mm\", ", "\"3 mm\", ").replace("[0, 0, ", "[0, ");
    }
    let job = crate::job::Job::parse(&text, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    let out = folder.join(format!("run_{space}"));
    let options = crate::run::Options::new(out.clone(), 1);
    crate::run::start::start(&job, &options, &scree_partition::Solo).unwrap();
    let page = write(std::slice::from_ref(&out), None, None).unwrap();
    (fs::read_to_string(page).unwrap(), fs::read_to_string(out.join("figures/reactions.svg")).unwrap())
}

#[test]
fn grains_in_a_cell_are_drawn_with_their_curves() {
    let folder = tempfile::tempdir().unwrap();
    for (space, kind, normal) in [("plane", "discs", "\u{2212}yy"), ("solid", "spheres", "\u{2212}zz")] {
        let (html, bodies) = assembly(folder.path(), space);
        assert_eq!((count(&html, "<svg "), count(&html, "<figcaption>")), (4, 4));
        assert!(html.contains(&format!("3 {kind} in a cell for 0.500\u{2009}ms. ")), "{html}");
        // Three grains at three moments, one of them glued.
        let circles = html.split("<svg ").find(|drawing| drawing.contains("mean stress, compression")).unwrap();
        assert_eq!(count(circles, "<circle "), 9);
        assert!(circles.contains("glued to a plate or body"));
        assert!(
            html.contains(normal) && html.contains("solid volume fraction") && html.contains("coloured by mean stress")
        );
        assert!(bodies.contains(">floor<") && bodies.contains(">lid<"));
        assert!(!html.contains("NaN") && !html.contains("inf "));
    }
    // What stands against other things, or is seen otherwise, has figures of its own.
    let shear = folder.path().join("shear");
    run(&shear, "dem");
    let all = [folder.path().join("run_plane"), folder.path().join("run_solid"), shear];
    let page = fs::read_to_string(write(&all, Some(&folder.path().join("all.html")), None).unwrap()).unwrap();
    assert!(page.contains("Nothing is compared: no body of run_plane"), "{page}");
    for name in ["mean_stress", "stress_2", "energies_3"] {
        assert!(folder.path().join(format!("figures/{name}.svg")).exists(), "{name}");
    }
}

const NOISE: &str = "leave scheme.volume_averaging at true, which ends it";

/// Runs a block of sand that slumps beside a body, in the plane or in space, and draws it.
fn continuum(folder: &Path, space: &str, points_per_cell: usize, averaging: bool) -> String {
    let solid = space == "solid";
    let vector = |x: f64, y: f64, z: f64| if solid { format!("[{x}, {y}, {z}]") } else { format!("[{x}, {z}]") };
    let gravity = if solid { "[0, 0, -9.81]" } else { "[0, -9.81]" };
    let text = format!(
        r#"
name = "slump"
[grid]
space = "{space}"
upper = {upper}
cell = 0.1
[scheme]
points_per_cell = {points_per_cell}
volume_averaging = {averaging}
[material]
law = "critical_drucker_prager"
density = 1500
bulk_modulus = 1e5
shear_modulus = 5e4
friction_angle_critical = "20 deg"
dilation_angle = "0 deg"
[gravity]
acceleration = {gravity}
[[region]]
shape = "box"
lower = {lower}
upper = {top}
[[body]]
name = "wall"
shape = "box"
lower = {wall_lower}
upper = {wall_upper}
contact = "rough"
[[follow]]
name = "corner"
place = {top}
[time]
step = 1e-3
end = 0.05
"#,
        upper = vector(1.0, 0.2, 0.6),
        lower = vector(0.0, 0.0, 0.0),
        top = vector(0.4, 0.2, 0.4),
        wall_lower = vector(0.7, 0.0, 0.0),
        wall_upper = vector(0.8, 0.2, 0.2),
    );
    let job = crate::job::Job::parse(&text, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    let out = folder.join(format!("continuum_{space}_{points_per_cell}_{averaging}"));
    let options = crate::run::Options::new(out.clone(), 1);
    crate::run::start::start(&job, &options, &scree_partition::Solo).unwrap();
    fs::read_to_string(write(&[out], None, None).unwrap()).unwrap()
}

#[test]
fn continua_are_drawn_with_their_curves() {
    let folder = tempfile::tempdir().unwrap();
    for (space, words) in [("plane", "in plane strain"), ("solid", "in space")] {
        let html = continuum(folder.path(), space, 2, false);
        // Plastic strain, mean stress, energies, stresses, reactions, the followed point, its state and its path.
        assert_eq!((count(&html, "<svg "), count(&html, "<figcaption>")), (8, 8));
        assert!(html.contains(&format!("points {words} (critical drucker prager); the run is of 5")), "{html}");
        for name in ["plastic strain", "mean stress, compression positive", ">wall<", ">corner<", "dissipated"] {
            assert!(html.contains(name), "{name}");
        }
        assert!(html.contains(if space == "plane" { ">face y_lower<" } else { ">face z_lower<" }));
        assert!(!html.contains("NaN") && !html.contains("inf "));
        assert_eq!(count(&html, NOISE), 1);
    }
    assert!(!continuum(folder.path(), "plane", 1, false).contains(NOISE));
    assert!(!continuum(folder.path(), "plane", 2, true).contains(NOISE));
}
