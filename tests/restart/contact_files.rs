//! A run that starts from the exported grains and contacts of another goes on as that one did.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use scree::export::grain_export::{self, Wanted};
use scree::job::assembly::Source;
use scree::job::{Assembly, Job};
use scree::prepare::grain_file;
use scree::run::{Options, start};
use scree_partition::Solo;

use crate::two_grains::state_after;
use crate::worlds::Random;

/// Grains that slide and roll on each other, across the period and on a floor.
const JOB: &str = r#"
name = "heap"
[cell]
space = "SPACE"
upper = UPPER
periodic = PERIODIC
gravity = GRAVITY
[grains]
density = "2530 kg/m3"
file = "grains.csv"
diameter_mean = "1 mm"
[contact]
friction = 0.5
LAW
[time]
step = "0.2 us"
end = "60 us"
[[body]]
name = "floor"
shape = "plane"
point = ZERO
normal = NORMAL
[output]
checkpoint_interval = "20 us"
checkpoints_kept = 10
"#;

const LAWS: [&str; 5] = [
    "stiffness_normal = 1e5\nstiffness_tangential = 5e4\nrestitution = 0.5",
    "law = \"linear_cohesive\"\nstiffness_normal = 1e5\nstiffness_tangential = 5e4\nrestitution = 0.5\ncohesion_normal = 0.2\ncohesion_tangential = 0.1",
    "law = \"elastic_rolling\"\nyoung_modulus = 2e8\nstiffness_ratio = 0.8\nrolling_stiffness = 0.5\nrolling_limit = 0.1",
    "law = \"hertz_mindlin\"\nshear_modulus = 3e8\npoisson_ratio = 0.2\nrestitution = 0.5\nnormal_force = \"repulsive\"",
    "stiffness_normal = 1e5\nstiffness_tangential = 5e4\nrestitution = 0.5\nnormal_force = \"repulsive\"",
];

/// The job in a space, and the grains that it starts from in a folder.
fn heap(folder: &Path, axes: usize, law: &str) -> String {
    let count: usize = if axes == 2 { 6 } else { 4 };
    let layers = if axes == 2 { 1 } else { count };
    let length = count as f64 * 0.99e-3;
    let mut random = Random(5);
    let mut text = String::from(["id,x,y,radius,vx,vy,spin\n", "id,x,y,z,radius,vx,vy,vz,wx,wy,wz\n"][axes - 2]);
    for number in 0..count * count * layers {
        let at = [number % count, number / count % count, number / (count * count)];
        write!(text, "{}", 2 * number).unwrap();
        for at in &at[..axes] {
            write!(text, ",{:e}", (*at as f64 + 0.5 + 0.004 * random.signed()) * 0.99e-3).unwrap();
        }
        write!(text, ",{:e}", 0.5e-3 * (1.0 + 0.005 * random.signed())).unwrap();
        let spins = if axes == 2 { 1 } else { 3 };
        (0..axes).for_each(|_| write!(text, ",{:e}", 0.2 * random.signed()).unwrap());
        (0..spins).for_each(|_| write!(text, ",{:e}", 200.0 * random.signed()).unwrap());
        text.push('\n');
    }
    fs::write(folder.join("grains.csv"), text).unwrap();
    let list = |of: &str, last: &str| format!("[{}{last}]", format!("{of}, ").repeat(axes - 1));
    JOB.replace("SPACE", ["plane", "solid"][axes - 2])
        .replace("UPPER", &list(&format!("{length:e}"), &format!("{:e}", 1.5 * length)))
        .replace("PERIODIC", &list("true", "false"))
        .replace("GRAVITY", &list("0", "-9.81"))
        .replace("ZERO", &list("0", "0"))
        .replace("NORMAL", &list("0", "1"))
        .replace("LAW", law)
}

fn job(folder: &Path, text: &str, sets: &[&str]) -> Result<Assembly, String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    match Job::parse(text, &folder.join("job.toml").display().to_string(), &sets) {
        Ok(Job::Assembly(job)) => Ok(job),
        Ok(other) => panic!("{other:?}"),
        Err(error) => Err(error.to_string()),
    }
}

/// Rows of numbers of an exported file after a step, without what names them.
fn exported(out: &Path, step: u64, forces: bool) -> Vec<Vec<f64>> {
    let (file, wanted) = (out.join("rows.csv"), Wanted { forces, velocities_now: false });
    grain_export::write(&state_after(out, step), out, &file, wanted).unwrap();
    let text = fs::read_to_string(file).unwrap();
    text.lines().skip(1).map(|line| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect()).collect()
}

fn run(job: &Assembly, out: PathBuf) -> PathBuf {
    start::start(&Job::Assembly(job.clone()), &Options::new(out.clone(), 1), &Solo).unwrap();
    out
}

const READ: [&str; 3] = ["grains.file=later.csv", "grains.contacts=contacts.csv", "time.velocities=half_step_before"];

/// Runs a heap, and exports it as it is after 200 steps of 300.
fn exported_heap(folder: &Path, axes: usize, law: &str) -> (String, PathBuf) {
    let text = heap(folder, axes, law);
    let first = run(&job(folder, &text, &[]).unwrap(), folder.join("first"));
    let state = state_after(&first, 200);
    grain_export::write(&state, &first, &folder.join("later.csv"), Wanted::default()).unwrap();
    grain_export::write_contacts(&state, &first, &folder.join("contacts.csv")).unwrap();
    (text, first)
}

/// The farthest that numbers are apart, as a share of the largest in their column.
fn apart(one: &[Vec<f64>], other: &[Vec<f64>], columns: std::ops::Range<usize>) -> f64 {
    assert_eq!(one.len(), other.len());
    let worst = columns.map(|column| {
        let scale = one.iter().map(|row| row[column].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let off = one.iter().zip(other).map(|(one, other)| (one[column] - other[column]).abs()).fold(0.0, f64::max);
        off / scale
    });
    worst.fold(0.0, f64::max)
}

#[test]
fn forces_of_a_start_from_files_are_those_of_the_run_that_wrote_them() {
    for axes in [2, 3] {
        for law in LAWS {
            let folder = tempfile::tempdir().unwrap();
            let folder = folder.path();
            let (text, first) = exported_heap(folder, axes, law);
            let second = job(folder, &text, &READ).unwrap();
            let Job::Assembly(again) = Job::parse(&Job::Assembly(second.clone()).to_toml(), "x.toml", &[]).unwrap()
            else {
                panic!("it is an assembly")
            };
            assert_eq!(again, second);
            let second = run(&second, folder.join("second"));
            let loads = |out: &Path, step| exported(out, step, true);
            // Behind place, radius, velocity and spin.
            let first_load = [6, 10][axes - 2];
            let (before, after) = (loads(&first, 200), loads(&second, 0));
            let width = before[0].len() - 1;
            let off = apart(&before, &after, first_load..width);
            println!("{axes} axes, forces of the start off by {off:.1e}: {law}");
            assert!(off < 1e-9, "{off:e} of the forces: {law}");
            // And on: as long as rounding does not tell.
            let off = apart(&loads(&first, 300), &loads(&second, 100), 0..width);
            println!("{axes} axes, after 100 more steps off by {off:.1e}");
            assert!(off < 1e-7, "{off:e} after 100 steps: {law}");
            // Without memories it is another start.
            let without = job(folder, &text, &[READ[0], READ[2]]).unwrap();
            let without = run(&without, folder.join("without"));
            assert!(apart(&before, &loads(&without, 0), first_load..width) > 1e-3, "nothing was remembered: {law}");
        }
    }
}

/// By line, with what is wrong and what to do.
#[test]
fn contacts_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (text, _) = exported_heap(folder, 2, LAWS[0]);
    let good = fs::read_to_string(folder.join("contacts.csv")).unwrap();
    let refused = |contacts: &str, law: &str| {
        fs::write(folder.join("contacts.csv"), contacts).unwrap();
        let job = job(folder, &text.replace(LAWS[0], law), &READ).unwrap();
        let Source::File(read) = &job.source else { panic!("it reads files") };
        match grain_file::refuse_bad(&job, read) {
            Ok(()) => String::new(),
            Err(error) => error.to_string().replace(&folder.join("contacts.csv").display().to_string(), ""),
        }
    };
    assert_eq!(refused(&good, LAWS[0]), "");
    // Without its time, and in another order of columns.
    assert_eq!(refused("memory_linear_0,higher,lower\n1e-8,2,0\n", LAWS[0]), "");
    let with = |line: &str| format!("lower,higher,memory_linear_0,time\n{line}\n");
    for (line, wanted) in [
        ("0,1,1e-8,0", ":2: there is no grain 1 in grains.file"),
        ("0,lid,1e-8,0", ":2: `lid` is neither the id of a grain nor a body of the job (floor)"),
        ("2,0,1e-8,0", ":2: grain 2 stands before grain 0; the lower id comes first"),
        (
            "0,28,1e-8,0",
            ":2: grain 0 and grain 28 do not touch: they are apart; export grains and contacts of one time",
        ),
        ("28,floor,1e-8,0", ":2: grain 28 and body `floor` do not touch: they are apart by 1.9"),
        ("0,2,1e-8,0\n0,2,1e-8,0", ":3: this contact stands in line 2 already; remove one of the two"),
        ("0,2,nan,0", ":2: `nan` is not a finite number, in column memory_linear_0"),
        ("0,2,1e-8", ":2: 3 values, 4 are wanted (lower,higher,memory_linear_0,time)"),
        ("x,2,1e-8,0", ":2: `x` is not an id; whole numbers from 0 on are"),
    ] {
        let found = refused(&with(line), LAWS[0]);
        assert!(found.starts_with(wanted), "{line}: {found}");
    }
    // Springs are lengths of one law and forces of another.
    let found = refused(&good, "law = \"hertz_mindlin\"\nshear_modulus = 3e8\npoisson_ratio = 0.2");
    let wanted = ":1: the first line must name the columns lower,higher,memory_hertz_mindlin_0, in any order, which are those of law = \"hertz_mindlin\"; it is `lower,higher,force_normal,force_tangential,memory_linear_0,time`.";
    assert!(found.starts_with(wanted), "{found}");
    fs::remove_file(folder.join("contacts.csv")).unwrap();
    let job = job(folder, &text, &READ).unwrap();
    let Source::File(read) = &job.source else { panic!("it reads files") };
    let found = grain_file::refuse_bad(&job, read).unwrap_err().to_string();
    assert!(found.contains("this file of contacts cannot be read") && found.contains("in grains.contacts."), "{found}");
}

/// Contacts of grains that are made are made with them.
#[test]
fn contacts_stand_beside_grains_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let text = heap(folder.path(), 2, LAWS[0]).replace("file = \"grains.csv\"\n", "count = 50\n");
    let found = job(folder.path(), &text, &["grains.contacts=contacts.csv"]).unwrap_err();
    assert!(found.contains("grains.contacts = \"contacts.csv\" is what contacts of grains from a file remember, and there is no grains.file. Add it, or remove the line."), "{found}");
}

/// The time of an export stands in it: in a column of its own, last, and in the title of a LAMMPS data file; grains are read
/// back with it, wherever it stands.
#[test]
fn exports_state_their_time() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (text, first) = exported_heap(folder, 2, LAWS[0]);
    let lines = |name: &str| -> Vec<String> {
        fs::read_to_string(folder.join(name)).unwrap().lines().map(String::from).collect()
    };
    for (name, header) in [
        ("later.csv", "id,x,y,radius,vx,vy,spin,time"),
        ("contacts.csv", "lower,higher,force_normal,force_tangential,memory_linear_0,time"),
    ] {
        let lines = lines(name);
        assert_eq!(lines[0], header);
        let times: Vec<f64> = lines[1..].iter().map(|line| line.rsplit_once(',').unwrap().1.parse().unwrap()).collect();
        assert!(times.len() > 30 && times.iter().all(|time| (time / 40e-6 - 1.0).abs() < 1e-12), "{times:?}");
    }
    grain_export::write(&state_after(&first, 200), &first, &folder.join("later.data"), Wanted::default()).unwrap();
    let title = lines("later.data").remove(0);
    let time: f64 = title.split_whitespace().nth(5).unwrap().parse().unwrap();
    assert!(title.starts_with("Grains of scree at time ") && (time / 40e-6 - 1.0).abs() < 1e-12, "{title}");
    let turned: Vec<String> =
        lines("later.csv").iter().map(|line| line.split(',').rev().collect::<Vec<_>>().join(",")).collect();
    fs::write(folder.join("turned.csv"), turned.join("\n")).unwrap();
    let read = |file: &str| {
        let job = job(folder, &text, &[&format!("grains.file={file}")]).unwrap();
        let Source::File(read) = &job.source else { panic!("it reads files") };
        grain_file::refuse_bad(&job, read).map_err(|error| error.to_string())
    };
    for file in ["later.csv", "turned.csv", "later.data"] {
        assert_eq!(read(file), Ok(()), "{file}");
    }
}
