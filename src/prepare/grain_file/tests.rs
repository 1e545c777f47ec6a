//! Files that are refused, by line and in words, and grains that come back as they were written.

use std::path::PathBuf;

use super::*;
use crate::base::numbers::Numbers;
use crate::dem::cell::Cell;
use crate::dem::grains::body_partner;
use crate::domain::parts::Home;
use crate::export::grain_export::{self, Wanted};
use crate::job::Job;
use crate::law::contact::Memory;
use crate::prepare::grain_world;
use crate::store::checkpoint::{Progress, Snapshot};

const HEADER: &str = "id,x,y,radius,vx,vy,spin";

/// A cell of 4 mm about the origin.
const SPHERES: &str = r#"
name = "spheres"
[cell]
space = "solid"
lower = ["-2 mm", "-2 mm", "-2 mm"]
upper = ["2 mm", "2 mm", "2 mm"]
periodic = [true, true, false]
[grains]
density = "2500 kg/m3"
file = "grains.csv"
diameter_mean = "0.8 mm"
[contact]
law = "linear"
stiffness_normal = "100 kN/m"
stiffness_tangential = "50 kN/m"
restitution = 0.5
friction = 0.5
[time]
step = "0.2 us"
end = "1 ms"
[[body]]
name = "floor"
shape = "plane"
point = [0, 0, "-2 mm"]
normal = [0, 0, 1]
"#;

const DISCS: &str = r#"
name = "discs"
[cell]
space = "plane"
upper = ["4 mm", "5 mm"]
periodic = [true, true]
depth = "1 cm"
[grains]
density = "2500 kg/m3"
file = "grains.csv"
diameter_mean = "0.8 mm"
[contact]
law = "linear"
stiffness_normal = "1000 kN/m"
stiffness_tangential = "500 kN/m"
restitution = 0.5
friction = 0.5
[time]
step = "0.2 us"
end = "1 ms"
"#;

fn job(text: &str) -> Assembly {
    match Job::parse(text, "job.toml", &[]) {
        Ok(Job::Assembly(job)) => job,
        other => panic!("{other:?}"),
    }
}

/// What is said of a file of that name and text, without its name.
fn said<R>(name: &str, text: &str, read: impl FnOnce(&Path) -> Result<Vec<R>, Error>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, text).unwrap();
    let message = read(&file).map(|grains| format!("{} grains", grains.len())).unwrap_or_else(|error| {
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    });
    message.replace(&format!("{}:", file.display()), "")
}

fn check(cases: &[(&str, &str)], said: impl Fn(&str) -> String) {
    for (text, wanted) in cases {
        let found = said(text);
        assert!(found.starts_with(wanted), "{text:?}: {found}");
    }
}

#[test]
fn what_a_job_may_not_say_a_grain_file_may_not_either() {
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/quickstart.toml");
    let scenario = Scenario::load(&job, &["method=dem".into()]).unwrap();
    let refusal = |rows: &str| said("grains.csv", &format!("{HEADER}\n{rows}"), |file| read(&scenario, file));
    check(
        &[
            ("0,0.01,0.02,0.0005,0,0,0\n1,0.012,-0.001,0.0005,0,0,0\n", "2 grains"),
            ("", "1: there is no free grain"),
            ("0,0.01,0.02,0.0005,0,0\n", "2: 6 values, 7 are wanted"),
            ("0,0.01,nan,0.0005,0,0,0\n", "2: `nan` is not a finite number"),
            ("0,0.03,0.02,0.0005,0,0,0\n", "2: x = 0.03 m must be at least 0 and at most specimen.width = 0.024 m"),
            ("0,0.01,0.02,-1,0,0,0\n", "2: radius = -1 m must be positive"),
            ("7,0.01,0.02,0.0005,0,0,0\n7,0.02,0.02,0.0005,0,0,0\n", "3: id 7 stands in line 2 already"),
            ("0,0.01,0.02,0.0005,0,0,0\n1,0.01,5,0.0005,0,0,0\n", "3: y = 5 m lies outside the domain"),
            ("0,0.01,0.02,0.0055,0,0,0\n", "2: radius = 0.0055 m reaches"),
            ("0,0.01,0.02,0.00001,0,0,0\n", "2: a grain with radius = 0.00001 m is unstable"),
            (
                "1,0.0238,0.02,0.0005,0,0,0\n0,0.0001,0.02,0.0005,0,0,0\n",
                "2: this grain overlaps the one in line 3 by 140 %",
            ),
        ],
        refusal,
    );
}

/// Spreadsheets write a byte-order mark, blanks and an order of their own; what they mean is as plain as before.
#[test]
fn columns_are_known_by_their_names() {
    let spheres = job(SPHERES);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.csv");
    let rows = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let rows = read_assembly::<Solid>(&spheres, &file).map_err(|error| error.to_string())?;
        Ok::<_, String>(
            rows.into_iter().map(|row| (row.cold.id.0, row.hot.position, row.hot.radius)).collect::<Vec<_>>(),
        )
    };
    let plain = rows("id,x,y,z,radius\n3,1e-3,0,-1e-3,4e-4\n").unwrap();
    assert_eq!(rows("\u{feff}id,x,y,z,radius\r\n3,1e-3,0,-1e-3,4e-4\r\n").unwrap(), plain);
    assert_eq!(rows("id, x, y, z, radius\n3, 1e-3, 0, -1e-3, 4e-4\n").unwrap(), plain);
    assert_eq!(rows("radius,z,y,x,id\n4e-4,-1e-3,0,1e-3,3\n").unwrap(), plain);
    for other in ["id,x,y,y,radius", "id,x,y,radius", "id,x,y,z,diameter", ""] {
        let message = rows(&format!("{other}\n")).unwrap_err();
        assert!(message.contains("grains.csv:1: the first line must name the columns id,x,y,z,radius,vx"), "{message}");
        assert!(message.ends_with(&format!("; it is `{other}`")), "{message}");
    }
}

#[test]
fn grains_of_an_assembly_are_held_to_its_bounds() {
    let spheres = job(SPHERES);
    let places = |rows: &str| {
        let text = format!("id,x,y,z,radius\n{rows}");
        said("grains.csv", &text, |file| read_assembly::<Solid>(&spheres, file))
    };
    check(
        &[
            ("0,0,0,0,4e-4\n\n1,1e-3,0,0,4e-4\n", "2 grains"),
            ("", "1: there is no grain in this file"),
            ("0,0,0,0\n", "2: 4 values, 5 are wanted (id,x,y,z,radius)"),
            ("-1,0,0,0,4e-4\n", "2: `-1` is not an id"),
            ("0,0,3e-3,0,4e-4\n", "2: y = 0.003 m lies outside the cell, which reaches from cell.lower = -0.002 to"),
            ("0,0,0,0,0\n", "2: radius = 0 m must be positive"),
            ("0,0,0,0,4e-4\n1,0,1e-3,0,4e-4\n0,1e-3,0,0,4e-4\n", "4: id 0 stands in line 2 already"),
            ("0,0,0,0,4e-3\n", "2: radius = 0.004 m reaches"),
            ("0,0,0,0,2e-3\n", "2: radius = 0.002 m reaches 0.00408 m with its neighbours, and the period"),
            ("0,0,0,0,1e-5\n", "2: a grain with radius = 0.00001 m is unstable with time.step"),
            // Grains as small as these all: their dashpots, not those of the mean that the job states.
            ("0,0,0,0,2.5e-4\n", "2: a grain with radius = 0.00025 m is unstable with time.step"),
            ("0,0,0,0,6.5e-4\n", "2: the grains of this file have a mean diameter of 1.3000e-3 m, and the job's"),
            ("0,-1.9e-3,0,0,4e-4\n1,1.9e-3,0,0,4e-4\n", "3: this grain overlaps the one in line 2 by 150 %"),
            ("0,0,0,-1.9e-3,4e-4\n", "2: this grain overlaps body `floor` by 75 % of its radius"),
        ],
        places,
    );
    let other = said("grains.csv", "id,x,y,radius\n", |file| read_assembly::<Solid>(&spheres, file));
    assert!(
        other.starts_with("1: the first line must name the columns id,x,y,z,radius,vx,vy,vz,wx,wy,wz, or id,x,y,z,radius, in any order; it is `"),
        "{other}"
    );
}

const HEAD: &str = "two spheres
2 atoms
1 atom types

-2e-3 2e-3 xlo xhi
-0.002 0.002 ylo yhi # as drawn
-0.002 0.002000000000001 zlo zhi
";
const ATOMS: &str = "\nAtoms # sphere\n\n1 1 8e-4 2500 0 0 0 0 1 -1\n2 1 8e-4 2500 1e-3 0 0 # the other\n";

#[test]
fn lammps_files_are_read_or_refused_by_line() {
    let spheres = job(SPHERES);
    let refusal = |text: &str| said("grains.data", text, |file| read_assembly::<Solid>(&spheres, file));
    let whole = format!("{HEAD}{ATOMS}");
    assert_eq!(refusal(&whole), "2 grains");
    assert_eq!(refusal(&format!("{HEAD}\nMasses\n\n1 1.0\n{ATOMS}\nVelocities\n\n2 1 0 0 0 0 3\n")), "2 grains");
    for (from, to, wanted) in [
        ("2 atoms\n", "\n", "1: the head has no line `N atoms`"),
        ("2 atoms\n", "3 atoms\n", "9: 2 atoms, and the head promises 3"),
        ("2 atoms\n", "two atoms\n", "9: 2 atoms, and"),
        ("-2e-3 2e-3 xlo xhi", "", "1: the head has no line `xlo xhi`"),
        (
            "-2e-3 2e-3 xlo",
            "-2e-3 2.1e-3 xlo",
            "5: the box reaches from -0.002 to 0.0021 m along x, and the job's cell from -0.002 to 0.002 m",
        ),
        ("zlo zhi\n", "zlo zhi\n1e-4 0 0 xy xz yz\n", "2 grains"),
        (
            "zlo zhi\n",
            "zlo zhi\n0 1e-4 0 xy xz yz\n",
            "8: the box is tilted by [0.0, 0.0001, 0.0] m (xy xz yz), and a cell",
        ),
        ("zlo zhi\n", "zlo zhi\n1 0 0 avec\n", "8: a box of edges in any direction is not read"),
        ("zlo zhi\n", "zlo zhi\n1 0 0\n", "8: `1 0 0` is neither a line of the head nor a section"),
        ("# sphere", "# atomic", "9: atoms of style `atomic`; grains are of style sphere"),
        (" 1e-3 0 0 #", " 1e-3 0 #", "12: 6 values, 7 are wanted (id type diameter density x y z)"),
        ("2 1 8e-4", "0 1 8e-4", "12: `0` is not an atom; whole numbers from 1 on are"),
        ("2 1 8e-4", "1 1 8e-4", "12: id 0 stands in line 11 already"),
        ("2 1 8e-4", "2 1 inf", "12: `inf` is not a finite number"),
        ("8e-4 2500 1e-3", "8e-4 -1 1e-3", "12: density = -1 must be positive"),
        (
            "8e-4 2500 1e-3",
            "8e-4 2501 1e-3",
            "12: density = 2501 makes a sphere of 6.704745e-7 kg, and the job's grains.density one of 6.702064e-7 kg",
        ),
    ] {
        assert!(whole.contains(from), "{from}");
        let found = refusal(&if from == "2 atoms\n" && to == "two atoms\n" {
            whole.replace(from, "3 atoms\n")
        } else {
            whole.replace(from, to)
        });
        assert!(found.starts_with(wanted), "{to:?}: {found}");
    }
    for (motion, wanted) in [
        ("2 0 0 0 0 0", "16: 6 values, 7 are wanted (id vx vy vz wx wy wz)"),
        ("3 0 0 0 0 0 0", "16: there is no atom 3 in section Atoms"),
        ("2 0 0 0 0 0 0\n2 0 0 0 0 0 0", "17: atom 2 has its velocity in line 16 already"),
    ] {
        let found = refusal(&format!("{whole}\nVelocities\n\n{motion}\n"));
        assert!(found.starts_with(wanted), "{motion:?}: {found}");
    }
}

/// 2500 kg/m3 and a depth of 1 cm: 25 kg/m2, or as LAMMPS stores it 25/(4/3 r).
#[test]
fn masses_of_discs_stand_in_two_ways() {
    let discs = job(DISCS);
    let refusal = |densities: [f64; 2], z: &str| {
        let [a, b] = densities;
        let text = format!(
            "discs\n2 atoms\n0 4e-3 xlo xhi\n0 5e-3 ylo yhi\n-1 1 zlo zhi\nAtoms\n1 1 8e-4 {a} 1e-3 1e-3 {z}\n2 1 1e-3 {b} 2e-3 1e-3 0\n"
        );
        said("grains.lmp", &text, |file| read_assembly::<Plane>(&discs, file))
    };
    assert_eq!(refusal([25.0, 25.0], "0"), "2 grains");
    assert_eq!(refusal([25.0 / (4.0 / 3.0 * 4e-4), 25.0 / (4.0 / 3.0 * 5e-4)], "0"), "2 grains");
    let found = refusal([25.0, 25.3], "0");
    assert!(
        found.starts_with(
            "7: density = 25 makes a disc of 6.702064e-9 kg as LAMMPS stores it, or of 1.256637e-5 kg as kg/m2"
        ),
        "{found}"
    );
    let found = refusal([25.3, 25.3], "0");
    assert!(
        found.contains("1.271717e-5 kg as kg/m2, and the job's grains.density and the depth one of 1.256637e-5 kg"),
        "{found}"
    );
    assert!(refusal([25.0, 25.0], "1e-4").starts_with("7: z = 0.0001 m, and the job's grains are discs"));
}

/// A state of a few grains that move, two of them beyond a face, and a contact with a body.
fn state<S: Space>(job: &Assembly, cell: Cell<S>) -> (scree_io::column::State, Vec<GrainRow<S>>) {
    let mut rows: Vec<GrainRow<S>> = Vec::new();
    for id in 0..4u64 {
        let mut place = cell.corner;
        for axis in 0..S::DIMENSION {
            let share = 0.13 + 0.26 * id as f64 + if axis == 0 { 0.0 } else { 0.011 / 3.0 };
            place[axis] += share * cell.edges[axis * S::DIMENSION + axis];
        }
        let radius = 4e-4 + 1e-5 / (id as f64 + 3.0);
        let mass = job.matter.density * S::grain_volume(radius, job.cell.depth);
        let mut row: GrainRow<S> = GrainRow::resting(GrainId(id), place, radius, mass, Mover::Free);
        for axis in 0..S::DIMENSION {
            row.hot.velocity[axis] = 0.1 / (3.0 + id as f64) - axis as f64;
        }
        for axis in 0..S::Spin::COMPONENTS {
            row.hot.spin[axis] = 1e3 / (7.0 * axis as f64 - 3.0);
        }
        rows.push(row);
    }
    rows[0].contacts = vec![(GrainId(2), Memory::of_words(&[0.1])), (body_partner(0), Memory::of_words(&[0.7]))];
    let mut moved = rows.clone();
    moved[1].hot.position += cell.shift([1, -1, 0]);
    let snapshot = Snapshot::<S> {
        scenario: Job::Assembly(job.clone()).to_toml(),
        progress: Progress::default(),
        cell,
        home: Home { cell, bodies: Vec::new() },
        bodies: Vec::new(),
        grains: moved,
        memory_words: 1,
        points: Vec::new(),
        rves: Vec::new(),
        nodes: None,
        packings: Vec::new(),
        memory_columns: Vec::new(),
        vertices: Vec::new(),
    };
    (snapshot.to_state(), rows)
}

fn come_back<S: Space>(job: &Assembly) {
    let folder = tempfile::tempdir().unwrap();
    let (state, rows) = state(job, grain_world::cell_of::<S>(job));
    for name in ["grains.csv", "grains.data"] {
        let file = folder.path().join(name);
        grain_export::write(&state, folder.path(), &file, Wanted::default()).unwrap();
        let read = read_assembly::<S>(job, &file).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read.len(), rows.len());
        for (read, row) in read.iter().zip(&rows) {
            // Across the period a place may be rounded.
            let moved = row.cold.id == GrainId(1);
            assert!(moved || read.hot.numbers() == row.hot.numbers(), "{name}: {:?} {:?}", read.hot, row.hot);
            assert!((read.hot.position - row.hot.position).norm() < 1e-17, "{name}");
            assert_eq!((read.cold.id, read.hot.velocity), (row.cold.id, row.hot.velocity));
        }
    }
}

#[test]
fn written_grains_are_read_back_as_they_were() {
    come_back::<Plane>(&job(DISCS));
    come_back::<Solid>(&job(SPHERES));
}

#[test]
fn exports_say_what_they_cannot_write() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    let discs = job(DISCS);
    let mut cell = grain_world::cell_of::<Plane>(&discs);
    let (upright, _) = state(&discs, cell);
    let found =
        grain_export::write(&upright, folder.path(), &at("grains.txt"), Wanted::default()).unwrap_err().to_string();
    assert!(found.contains("End it in .csv"), "{found}");
    grain_export::write_contacts(&upright, folder.path(), &at("contacts.csv")).unwrap();
    let text = std::fs::read_to_string(at("contacts.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines,
        [
            "lower,higher,force_normal,force_tangential,memory_linear_0,time",
            "0,2,0.0000000000000000e0,0.0000000000000000e0,1.0000000000000001e-1,0.0000000000000000e0",
            "0,18446744073709551360,0.0000000000000000e0,0.0000000000000000e0,6.9999999999999996e-1,0.0000000000000000e0"
        ]
    );

    let mut sheared = cell;
    sheared.edges[2] = 0.3e-3;
    cell.take_motion_of(&sheared);
    let (leaning, _) = state(&discs, cell);
    grain_export::write(&leaning, folder.path(), &at("grains.data"), Wanted::default()).unwrap();
    let text = std::fs::read_to_string(at("grains.data")).unwrap();
    assert!(text.contains("2.9999999999999997e-4 0.0000000000000000e0 0.0000000000000000e0 xy xz yz\n"), "{text}");
    cell.edges[1] = 0.1e-3;
    let (turned, _) = state(&discs, cell);
    let found =
        grain_export::write(&turned, folder.path(), &at("grains.data"), Wanted::default()).unwrap_err().to_string();
    assert!(found.starts_with("the edges of this cell have turned"), "{found}");
}

/// A cell that was sheared starts as it ended: the box of a data file says how its edges lean.
#[test]
fn a_sheared_cell_is_read_back_leaning() {
    let folder = tempfile::tempdir().unwrap();
    let discs = job(DISCS);
    let mut sheared = grain_world::cell_of::<Plane>(&discs);
    sheared.edges[2] = 0.8e-3;
    let mut cell = grain_world::cell_of::<Plane>(&discs);
    cell.take_motion_of(&sheared);
    let mut rows = state(&discs, cell).1;
    // At the top of the cell, beyond the upright one's edge in x, and the same across the period.
    rows[3].hot.position = cell.corner + cell.edges * <Plane as Space>::Vector::new(0.95, 0.9);
    assert!(rows[3].hot.position[0] > discs.cell.upper[0]);
    let snapshot = Snapshot::<Plane> {
        scenario: Job::Assembly(discs.clone()).to_toml(),
        progress: Progress::default(),
        cell,
        home: Home { cell, bodies: Vec::new() },
        bodies: Vec::new(),
        grains: rows.clone(),
        memory_words: 1,
        points: Vec::new(),
        rves: Vec::new(),
        nodes: None,
        packings: Vec::new(),
        memory_columns: Vec::new(),
        vertices: Vec::new(),
    };
    let state = snapshot.to_state();
    let file = folder.path().join("grains.data");
    grain_export::write(&state, folder.path(), &file, Wanted::default()).unwrap();
    let (read, start) = read_with_cell::<Plane>(&discs, &file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(start.edges, cell.edges);
    for (read, row) in read.iter().zip(&rows) {
        assert!((read.hot.position - row.hot.position).norm() < 1e-15, "{:?} {:?}", read.hot, row.hot);
    }
    let file = folder.path().join("grains.csv");
    grain_export::write(&state, folder.path(), &file, Wanted::default()).unwrap();
    let found = read_assembly::<Plane>(&discs, &file).unwrap_err().to_string();
    assert!(
        found.ends_with("the grains of a cell that leans are read with its tilts from a LAMMPS data file"),
        "{found}"
    );

    // And the world that a run starts from leans.
    let mut job = discs.clone();
    job.source = crate::job::assembly::Source::File(Read { grains: folder.path().join("grains.data"), contacts: None });
    let world = grain_world::world::<Plane>(&job, &scree_partition::Solo).unwrap();
    assert_eq!(world.assembly.cell.edges, cell.edges);
}
