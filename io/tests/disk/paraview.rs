//! VTK's own reader sees every frame. Needs `python3` with `vtk`; `SCREE_PYTHON` names another interpreter.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use scree_io::{Column, Drawn, Frame, Values, frames};

use crate::sample;

/// Prints, for every step: time, points, vertices, lines, other cells, then every number with all its digits.
const READER: &str = r#"
import sys
try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as error:
    print("skipped:", error)
    sys.exit(0)
reader = vtk.vtkHDFReader()
reader.SetFileName(sys.argv[1])
reader.UpdateInformation()
times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
def show(name, array):
    print(name, array.GetNumberOfComponents(), *map(repr, vtk_to_numpy(array).ravel().tolist()))
print("steps", reader.GetNumberOfSteps())
for step in range(reader.GetNumberOfSteps()):
    reader.SetStep(step)
    reader.Update()
    data = reader.GetOutput()
    others = data.GetNumberOfPolys() + data.GetNumberOfStrips()
    print("time", times[step], "points", data.GetNumberOfPoints(), data.GetNumberOfVerts(), data.GetNumberOfLines(), others)
    for name in sys.argv[3].split(","):
        print(name, *map(repr, vtk_to_numpy(data.GetFieldData().GetArray(name)).ravel().tolist()))
    if data.GetNumberOfPoints() == 0:
        continue
    cells, fields = data.GetVerts(), data.GetPointData()
    if data.GetNumberOfVerts() == 0:
        cells, fields = data.GetLines() if data.GetNumberOfLines() > 0 else data.GetPolys(), data.GetCellData()
    print("ids", *vtk_to_numpy(cells.GetConnectivityArray()))
    print("offsets", *vtk_to_numpy(cells.GetOffsetsArray()))
    print("positions", *map(repr, vtk_to_numpy(data.GetPoints().GetData()).ravel().tolist()))
    for name in sys.argv[2].split(","):
        show(name, fields.GetArray(name))
"#;

/// Whoever names an interpreter promises that it has what is needed.
pub fn python(path: &Path) -> Option<String> {
    let named = std::env::var("SCREE_PYTHON").ok();
    let frame = sample::frame(0);
    let names = |fields: Vec<Column>| fields.into_iter().map(|field| field.name).collect::<Vec<_>>().join(",");
    let mut command = Command::new(named.as_deref().unwrap_or("python3"));
    let output = command.args(["-c", READER]).arg(path).args([names(frame.fields), names(frame.whole)]).output();
    let output = match output {
        Ok(output) => output,
        Err(error) => {
            assert!(named.is_none(), "SCREE_PYTHON: {error}");
            println!("skipped: python3: {error}");
            return None;
        }
    };
    let text = String::from_utf8(output.stdout).unwrap();
    if text.starts_with("skipped:") {
        assert!(named.is_none(), "SCREE_PYTHON: {text}");
        println!("{text}");
        return None;
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(!complaints.contains("ERR") && !complaints.contains("HDF5-DIAG"), "{complaints}");
    Some(text)
}

/// What the reader is to print.
fn expected(frames: &[Frame]) -> String {
    let mut text = format!("steps {}\n", frames.len());
    for frame in frames {
        let (points, rows, per_row) = (frame.positions.len(), frame.rows(), frame.drawn.positions());
        let [vertices, lines, polygons] = [Drawn::Points, Drawn::Lines, Drawn::Quadrilaterals]
            .map(|drawn| if frame.drawn == drawn { rows } else { 0 });
        writeln!(text, "time {:?} points {points} {vertices} {lines} {polygons}", frame.time).unwrap();
        // How many numbers they have, VTK tells only from 9.4 on.
        frame.whole.iter().for_each(|column| writeln!(text, "{}{}", column.name, numbers(column)).unwrap());
        if points == 0 {
            continue;
        }
        let whole_numbers = |numbers: &mut dyn Iterator<Item = usize>| -> String {
            numbers.map(|number| format!(" {number}")).collect()
        };
        writeln!(text, "ids{}", whole_numbers(&mut (0..points))).unwrap();
        writeln!(text, "offsets{}", whole_numbers(&mut (0..=rows).map(|row| row * per_row))).unwrap();
        writeln!(text, "positions{}", floats(frame.positions.as_flattened())).unwrap();
        frame.fields.iter().for_each(|column| show(&mut text, column));
    }
    text
}

fn show(text: &mut String, column: &Column) {
    writeln!(text, "{} {}{}", column.name, column.width, numbers(column)).unwrap();
}

fn numbers(column: &Column) -> String {
    match &column.values {
        Values::F64(values) => floats(values),
        Values::I64(values) => values.iter().map(|value| format!(" {value}")).collect(),
        other => panic!("no field is {}", other.kind()),
    }
}

fn floats(values: &[f64]) -> String {
    values.iter().map(|value| format!(" {value:?}")).collect()
}

pub fn assert_same(found: &str, frames: &[Frame]) {
    let expected = expected(frames);
    let differ = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    assert!(differ.is_none() && found.lines().count() == expected.lines().count(), "{differ:?}");
}

#[test]
fn reads_every_step_of_a_file_written_at_once_and_of_one_cut_and_continued() {
    for drawn in [Drawn::Points, Drawn::Lines, Drawn::Quadrilaterals] {
        let (_guard, folder) = sample::folder();
        let frames: Vec<Frame> = (0..9).map(|number| sample::frame_of(drawn, number)).collect();
        let path = folder.join("frames.vtkhdf");
        let mut file = sample::create(&path, &frames[0]);
        frames[1..].iter().for_each(|frame| file.append(frame).unwrap());
        let Some(found) = python(&path) else { return };
        assert_same(&found, &frames);

        let mut file = sample::open_and_cut(&path, 4).unwrap();
        assert_same(&python(&path).unwrap(), &frames[..4]);
        frames[4..].iter().for_each(|frame| file.append(frame).unwrap());
        assert_same(&python(&path).unwrap(), &frames);
    }
}

#[test]
fn reads_every_part_by_itself() {
    let (_guard, folder) = sample::folder();
    let mut file = sample::create(&folder.join("frames.vtkhdf"), &sample::frame(0)).with_parts_of(60_000);
    (1..24).for_each(|number| file.append(&sample::frame(number)).unwrap());
    for name in ["frames.vtkhdf", "frames.2.vtkhdf"] {
        let path = folder.join(name);
        let Some(found) = python(&path) else { return };
        let frames = frames::read_part(&path).unwrap();
        assert!((2..24).contains(&frames.len()), "{}", frames.len());
        assert_same(&found, &frames);
    }
}
