//! What a run of grains shows of itself: frames and contacts as VTK's own reader and this program's have them, the same on
//! any ranks and after resume, and the dump of its grains.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use scree::export::grain_dump::{self, Moment};
use scree::export::vtu_export;
use scree::job::Job;
use scree::run::start;
use scree_io::frames::{self, Frame};
use scree_io::{Values, series};
use scree_partition::Solo;

use crate::runs::{done, options, parse, same};

const DEPTH: f64 = 0.01;

/// Grains that overlap on a lattice whose rows are a little uneven.
fn grains(folder: &Path, counts: [usize; 3]) -> PathBuf {
    let solid = counts[2] > 0;
    let mut text = String::from(if solid { "id,x,y,z,radius\n" } else { "id,x,y,radius\n" });
    for id in 0..counts[0] * counts[1] * counts[2].max(1) {
        let at = [id % counts[0], id / counts[0] % counts[1], id / counts[0] / counts[1]];
        let uneven = |axis: usize| 0.02 * ((id * (7 + 2 * axis)) % 11) as f64 / 11.0;
        let place: Vec<f64> = (0..3).map(|axis| 1e-3 * (at[axis] as f64 + 0.5 + uneven(axis))).collect();
        write!(text, "{id}").unwrap();
        place[..if solid { 3 } else { 2 }].iter().for_each(|x| write!(text, ",{x:e}").unwrap());
        writeln!(text, ",{:e}", 5.1e-4 + 1e-5 * ((id * 5) % 7) as f64 / 7.0).unwrap();
    }
    let file = folder.join(format!("grains{}.csv", counts[2]));
    std::fs::write(&file, text).unwrap();
    file
}

/// Discs that are sheared in a periodic cell, or spheres between planes; `cell` and `more` are what tells them apart.
fn job(file: &Path, space: &str, cell: &str, more: &str, stiffness: f64) -> Job {
    parse(&format!(
        r#"
        name = "frame_files"
        [cell]
        space = "{space}"
        {cell}
        [grains]
        density = 2600
        file = "{}"
        diameter_mean = "1 mm"
        [contact]
        stiffness_normal = {stiffness}
        stiffness_tangential = {stiffness}
        damping_normal = 0
        damping_tangential = 0
        friction = 0.5
        [damping]
        local = 0.7
        {more}
        [time]
        step = "1 us"
        end = "3 ms"
        [decomposition]
        skin = "0.1 mm"
        block = "3 mm"
        [output]
        series_interval = "1 ms"
        frame_interval = "1 ms"
        checkpoint_interval = "1 ms"
        checkpoints_kept = 3
        contact_frames = true
        "#,
        file.display()
    ))
}

fn discs(folder: &Path) -> Job {
    let cell = "upper = [0.012, 0.01]\nvelocity_gradient = [[0, 10], [0, 0]]";
    job(&grains(folder, [12, 10, 0]), "plane", cell, "", 4e5)
}

fn spheres(folder: &Path) -> Job {
    let cell = "upper = [0.004, 0.006, 0.004]\nperiodic = [true, false, true]\ngravity = [0, -9.81, 0]";
    let plane = |name: &str, at: &str, normal: &str| {
        format!("[[body]]\nname = \"{name}\"\nshape = \"plane\"\npoint = [0, {at}, 0]\nnormal = [0, {normal}, 0]\n")
    };
    let planes = plane("floor", "0", "1") + &plane("lid", "5e-3", "-1");
    job(&grains(folder, [4, 5, 4]), "solid", cell, &planes, 2e4)
}

fn numbers<'a>(frame: &'a Frame, name: &str) -> &'a [f64] {
    match &frame.fields.iter().chain(&frame.whole).find(|column| column.name == name).unwrap().values {
        Values::F64(values) => values,
        other => panic!("{name} is {}", other.kind()),
    }
}

fn counts<'a>(frame: &'a Frame, name: &str) -> &'a [i64] {
    match &frame.fields.iter().find(|column| column.name == name).unwrap().values {
        Values::I64(values) => values,
        other => panic!("{name} is {}", other.kind()),
    }
}

/// Sum of force times branch over the lines of a frame, J, row by row.
fn moment(contacts: &Frame) -> [f64; 9] {
    let (force, weight) = (numbers(contacts, "force"), numbers(contacts, "weight"));
    let mut sum = [0.0; 9];
    for line in 0..contacts.rows() {
        let [begin, end] = [contacts.positions[2 * line], contacts.positions[2 * line + 1]];
        for (at, sum) in sum.iter_mut().enumerate() {
            *sum += weight[line] * force[3 * line + at / 3] * (end[at % 3] - begin[at % 3]);
        }
    }
    sum
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest, number| number.abs().max(largest))
}

fn off(found: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(found.len(), wanted.len());
    let differences: Vec<f64> = found.iter().zip(wanted).map(|(found, wanted)| found - wanted).collect();
    largest(&differences) / largest(wanted)
}

/// Contacts, grains and the series tell of one stress: the first two to round-off, the series, whose forces are those with
/// which the last step began, to what one step changes.
fn one_stress(out: &Path, dimension: usize, tolerance: f64) {
    let (all, contacts) = (frames::read(&out.join("frames.vtkhdf")), frames::read(&out.join("contacts.vtkhdf")));
    let (all, contacts) = (all.unwrap(), contacts.unwrap());
    let (names, rows) = series::read(&out.join("series.csv")).unwrap();
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    assert!(all.len() == 4 && contacts.len() == 4);
    let volume = |radius: f64| match dimension {
        2 => std::f64::consts::PI * radius * radius * DEPTH,
        _ => 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius,
    };
    let solid: f64 = numbers(&all[0], "radius").iter().map(|radius| volume(*radius)).sum();
    let cell = numbers(&all[0], "cell_edges");
    // Neither cell changes its volume.
    let whole = cell[0] * cell[4] * cell[8];
    for (number, (frame, lines)) in all.iter().zip(&contacts).enumerate() {
        assert_eq!(frame.time, lines.time);
        let moment = moment(lines);
        let (stress, radius) = (numbers(frame, "stress"), numbers(frame, "radius"));
        let width = stress.len() / frame.rows();
        let mut of_grains = [0.0; 6];
        for row in 0..frame.rows() {
            for component in 0..width {
                of_grains[component] += stress[width * row + component] * volume(radius[row]) * whole / solid;
            }
        }
        let symmetric = |i: usize, j: usize| 0.5 * (moment[3 * i + j] + moment[3 * j + i]);
        let pairs = [(0, 0), (1, 1), (0, 1), (2, 2), (1, 2), (0, 2)];
        let of_lines: Vec<f64> = pairs[..width].iter().map(|(i, j)| symmetric(*i, *j)).collect();
        let among = off(&of_grains[..width], &of_lines);
        assert!(among < 1e-11, "frame {number}: grains and contacts are off by {among:e}");

        let [partners, across] = ["partner", "across"].map(|name| counts(lines, name));
        let ends: i64 = partners.iter().map(|partner| 2 - partner).sum();
        assert_eq!(counts(frame, "coordination").iter().sum::<i64>(), ends, "frame {number}");
        assert!(across.contains(&1) && lines.rows() > frame.rows(), "frame {number}");
        assert_eq!(partners.contains(&1), dimension == 3, "frame {number}");
        if number == 0 {
            continue;
        }
        let row = &rows[number - 1];
        assert_eq!(row[column("time")], frame.time);
        let axes = &["x", "y", "z"][..dimension];
        let names = axes.iter().flat_map(|i| axes.iter().map(move |j| format!("stress_{i}{j}")));
        let in_series: Vec<f64> = names.map(|name| row[column(&name)]).collect();
        let of_lines: Vec<f64> =
            (0..9).filter(|at| at / 3 < dimension && at % 3 < dimension).map(|at| moment[at] / whole).collect();
        let beside = off(&of_lines, &in_series);
        println!("frame {number}: {} contacts, grains off by {among:.1e}, series by {beside:.1e}", lines.rows());
        assert!(beside < tolerance, "frame {number}: off from the series by {beside:e}");
    }
}

#[test]
fn contacts_are_written_with_the_frames_and_tell_of_one_stress() {
    let folder = tempfile::tempdir().unwrap();
    for (job, dimension) in [(discs(folder.path()), 2), (spheres(folder.path()), 3)] {
        let out = folder.path().join(format!("run{dimension}"));
        done(start::start(&job, &options(&out), &Solo));
        one_stress(&out, dimension, 1e-4);
        if dimension == 2 {
            sheared(&out);
        }
        read_by_vtk(&out);
        dumped(&out, &job);
    }
}

/// A shear by 10/s for 3 ms is found in the strains of grains, whose places follow it.
fn sheared(out: &Path) {
    let last = frames::read_frame(&out.join("frames.vtkhdf"), 3).unwrap();
    let strain = numbers(&last, "deviatoric_strain");
    let mean = strain.iter().sum::<f64>() / strain.len() as f64;
    println!("deviatoric strain of grains: {mean:.4}");
    assert!((mean - 0.03).abs() < 0.006, "{mean}");
}

/// Prints of every step: time, cells, fields, and the sum of force times branch.
const READER: &str = r#"
import sys
try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as error:
    print("skipped:", error)
    sys.exit(0)
import xml.etree.ElementTree as xml

# The time, vertices, lines and ends of lines of every step.
def steps_of_hdf(name):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(f"{sys.argv[1]}/{name}.vtkhdf")
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert len(times) == reader.GetNumberOfSteps()
    for step, time in enumerate(times):
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutput()
        yield time, data, data.GetNumberOfVerts(), data.GetNumberOfLines(), data.GetLines()

def steps_of_xml(name):
    for entry in xml.parse(f"{sys.argv[1]}/{name}.pvd").iter("DataSet"):
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(f"{sys.argv[1]}/{entry.get('file')}")
        reader.Update()
        data = reader.GetOutput()
        time = data.GetFieldData().GetArray("TimeValue").GetValue(0)
        assert time == float(entry.get("timestep"))
        assert name != "frames" or data.GetFieldData().GetArray("cell_edges").GetNumberOfComponents() == 9
        kinds = [data.GetCellType(at) for at in range(data.GetNumberOfCells())]
        yield time, data, kinds.count(vtk.VTK_VERTEX), kinds.count(vtk.VTK_LINE), data.GetCells()

steps_of = steps_of_hdf if sys.argv[2] == "hdf" else steps_of_xml
for name in ("frames", "contacts"):
    steps = list(steps_of(name)) if sys.argv[2] == "xml" else steps_of(name)
    print(name)
    for time, data, vertices, count, cells in steps:
        lines = name == "contacts"
        fields = data.GetCellData() if lines else data.GetPointData()
        names = [fields.GetArrayName(at) for at in range(fields.GetNumberOfArrays())]
        print(repr(time), vertices, count, *sorted(names))
        if not lines:
            coordination = vtk_to_numpy(fields.GetArray("coordination"))
            radius = vtk_to_numpy(fields.GetArray("radius"))
            assert len(radius) == len(coordination) == vertices
            print(coordination.sum(), repr(float(radius.max())))
            continue
        places = vtk_to_numpy(data.GetPoints().GetData())
        ends = vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, 2)
        branch = places[ends[:, 1]] - places[ends[:, 0]]
        force = vtk_to_numpy(fields.GetArray("force"))
        along = -(force * branch).sum(1) / (branch * branch).sum(1) ** 0.5
        assert abs(along - vtk_to_numpy(fields.GetArray("force_normal"))).max() < 1e-9 * abs(along).max()
        moment = (force * vtk_to_numpy(fields.GetArray("weight"))[:, None]).T @ branch
        print(*map(repr, moment.ravel().tolist()))
"#;

/// VTK's own readers find the same in the run's files and in those that are made of them for older ones. Whoever names an interpreter promises that it has what is needed.
fn read_by_vtk(out: &Path) {
    let made = out.with_extension("vtu");
    let told = vtu_export::write(out, &made, Moment::All, false).unwrap();
    assert!(told.contains("frames of contacts are in"), "{told}");
    let again = vtu_export::write(out, &made, Moment::All, false).unwrap_err().to_string();
    assert!(again.contains("is there already"), "{again}");
    read_as(out, out, "hdf");
    read_as(out, &made, "xml");
}

fn read_as(out: &Path, files: &Path, kind: &str) {
    let named = std::env::var("SCREE_PYTHON").ok();
    let mut command = Command::new(named.as_deref().unwrap_or("python3"));
    let output = match command.args(["-c", READER]).arg(files).arg(kind).output() {
        Ok(output) => output,
        Err(error) if named.is_none() => return println!("skipped: python3: {error}"),
        Err(error) => panic!("SCREE_PYTHON: {error}"),
    };
    let text = String::from_utf8(output.stdout).unwrap();
    if text.starts_with("skipped:") {
        assert!(named.is_none(), "SCREE_PYTHON: {text}");
        return println!("{text}");
    }
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !complaints.contains("ERR"), "{complaints}");
    let mut lines = text.lines();
    for name in ["frames", "contacts"] {
        let all = frames::read(&out.join(format!("{name}.vtkhdf"))).unwrap();
        assert_eq!(lines.next(), Some(name));
        for frame in &all {
            let drawn = if name == "frames" { [frame.rows(), 0] } else { [0, frame.rows()] };
            let mut fields: Vec<&str> = frame.fields.iter().map(|column| column.name.as_str()).collect();
            fields.sort_unstable();
            let expected = format!("{:?} {} {} {}", frame.time, drawn[0], drawn[1], fields.join(" "));
            assert_eq!(lines.next(), Some(expected.as_str()));
            let found = lines.next().unwrap();
            if name == "frames" {
                let coordination: i64 = counts(frame, "coordination").iter().sum();
                let radius = largest(numbers(frame, "radius"));
                assert_eq!(found, format!("{coordination} {radius:?}"));
                continue;
            }
            let found: Vec<f64> = found.split(' ').map(|word| word.parse().unwrap()).collect();
            assert!(off(&found, &moment(frame)) < 1e-12);
        }
    }
    assert_eq!(lines.next(), None);
    println!("VTK reads the same from {kind}");
}

/// What a reader that knows nothing but the format finds in a dump.
#[derive(Debug, Default)]
struct Section {
    time: f64,
    step: u64,
    borders: String,
    bounds: Vec<Vec<f64>>,
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Section {
    fn column(&self, name: &str) -> Vec<f64> {
        let at = self.columns.iter().position(|other| other == name).unwrap_or_else(|| panic!("no {name}"));
        self.rows.iter().map(|row| row[at]).collect()
    }
}

fn read_dump(text: &str) -> Vec<Section> {
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').map(|word| word.parse().unwrap()).collect() };
    let (mut sections, mut section, mut lines) = (Vec::new(), Section::default(), text.lines());
    while let Some(item) = lines.next() {
        let mut next = || lines.next().unwrap();
        match item.strip_prefix("ITEM: ").unwrap_or_else(|| panic!("{item}")) {
            "UNITS" => assert!(sections.is_empty() && next() == "si"),
            "TIME" => section.time = next().parse().unwrap(),
            "TIMESTEP" => section.step = next().parse().unwrap(),
            "NUMBER OF ATOMS" => section.rows = vec![Vec::new(); next().parse().unwrap()],
            rest if rest.starts_with("BOX BOUNDS ") => {
                section.borders = rest["BOX BOUNDS ".len()..].to_string();
                section.bounds = (0..3).map(|_| numbers(next())).collect();
            }
            rest => {
                section.columns = rest.strip_prefix("ATOMS ").unwrap().split(' ').map(String::from).collect();
                section.rows.iter_mut().for_each(|row| *row = numbers(next()));
                sections.push(std::mem::take(&mut section));
            }
        }
    }
    sections
}

fn dumped(out: &Path, job: &Job) {
    let file = out.join("grains.dump");
    let told = grain_dump::write(out, &file, Moment::All).unwrap();
    assert!(told.contains("4 frames from 0 s to 0.003 s"), "{told}");
    let sections = read_dump(&std::fs::read_to_string(&file).unwrap());
    let all = frames::read(&out.join("frames.vtkhdf")).unwrap();
    assert_eq!(sections.len(), all.len());
    for (section, frame) in sections.iter().zip(&all) {
        assert_eq!((section.time, section.step), (frame.time, (frame.time / job.step()).round() as u64));
        let mut order: Vec<usize> = (0..frame.rows()).collect();
        order.sort_by_key(|row| counts(frame, "id")[*row]);
        let ids: Vec<f64> = order.iter().map(|row| counts(frame, "id")[*row] as f64 + 1.0).collect();
        assert_eq!(section.column("id"), ids);
        let places = ["x", "y", "z"].map(|name| section.column(name));
        let velocities = ["vx", "vy", "vz"].map(|name| section.column(name));
        let spins = ["omegax", "omegay", "omegaz"].map(|name| section.column(name));
        for (at, row) in order.into_iter().enumerate() {
            for axis in 0..3 {
                assert_eq!(places[axis][at], frame.positions[row][axis]);
                assert_eq!(velocities[axis][at], numbers(frame, "velocity")[3 * row + axis]);
                assert_eq!(spins[axis][at], numbers(frame, "spin")[3 * row + axis]);
            }
            let radius = numbers(frame, "radius")[row];
            assert_eq!(section.column("radius")[at], radius);
        }
        let edges = numbers(frame, "cell_edges");
        let is_plane = edges[8] == DEPTH;
        if is_plane && frame.time > 0.0 {
            assert_eq!(section.borders, "xy xz yz pp pp ff");
            let lean = 10.0 * frame.time * 0.01;
            let found =
                [section.bounds[0][2], section.bounds[0][1] - 0.012, section.bounds[2][1] - section.bounds[2][0]];
            assert!(off(&found, &[lean, lean, DEPTH]) < 1e-9, "{found:?}");
        } else {
            assert_eq!(section.borders, if is_plane { "pp pp ff" } else { "pp ff pp" });
        }
    }
    let file = out.join("one.dump");
    grain_dump::write(out, &file, Moment::At(0.002)).unwrap();
    assert_eq!(read_dump(&std::fs::read_to_string(&file).unwrap())[0].time, 0.002);
    let words = grain_dump::write(out, &out.join("none.dump"), Moment::At(0.004)).unwrap_err().to_string();
    assert!(words.contains("--at 0.004 s") && words.contains("There are 0, 0.001, 0.002, 0.003 s"), "{words}");
    assert!(!out.join("none.dump").exists());
}

#[test]
fn contacts_are_the_same_on_any_ranks_and_after_resume() {
    let folder = tempfile::tempdir().unwrap();
    for (job, name) in [(discs(folder.path()), "discs"), (spheres(folder.path()), "spheres")] {
        let runs = folder.path().join(name);
        same(&job, &runs, name);
        for file in ["frames.vtkhdf", "contacts.vtkhdf"] {
            let wanted = frames::read(&runs.join("alone").join(file)).unwrap();
            for other in ["threads", "2", "3", "4"] {
                assert!(frames::read(&runs.join(other).join(file)).unwrap() == wanted, "{name}, {other}: other {file}");
            }
        }
    }
}

/// The state of another time was once given for the one asked for.
#[test]
fn a_state_beside_those_kept_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    done(start::start(&discs(folder.path()), &options(&out), &Solo));
    let at = |time: f64| scree::store::checkpoint::state_at(&out, Some(time));
    for time in [0.0, 0.001, 0.002, 0.003] {
        assert!((at(time).unwrap().1 - time).abs() < 1e-9);
    }
    for time in [0.0006, 0.0011, 0.0036, 1.0] {
        let words = at(time).unwrap_err().to_string();
        assert!(
            words.contains(&format!("--at {time} s: ")) && words.contains("There are 0, 0.001, 0.002, 0.003 s"),
            "{words}"
        );
    }
}
