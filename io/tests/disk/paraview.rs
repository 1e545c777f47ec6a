//! VTK's own reader sees every frame. Needs `python3` with `vtk`; `SCREE_PYTHON` names another interpreter.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use scree_io::{Frame, FrameFile, Values};

use crate::sample;

/// Prints, for every step: time, points, vertices, other cells, then every number with all its digits.
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
print("steps", reader.GetNumberOfSteps())
for step in range(reader.GetNumberOfSteps()):
    reader.SetStep(step)
    reader.Update()
    data = reader.GetOutput()
    others = data.GetNumberOfLines() + data.GetNumberOfPolys() + data.GetNumberOfStrips()
    print("time", times[step], "points", data.GetNumberOfPoints(), "vertices", data.GetNumberOfVerts(), others)
    if data.GetNumberOfPoints() == 0:
        continue
    print("ids", *vtk_to_numpy(data.GetVerts().GetConnectivityArray()))
    print("positions", *map(repr, vtk_to_numpy(data.GetPoints().GetData()).ravel().tolist()))
    for name in sys.argv[2:]:
        array = data.GetPointData().GetArray(name)
        print(name, array.GetNumberOfComponents(), *map(repr, vtk_to_numpy(array).ravel().tolist()))
"#;

fn python(path: &Path) -> Option<String> {
    let interpreter = std::env::var("SCREE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let names = sample::frame(0).fields.into_iter().map(|field| field.name);
    let output = Command::new(interpreter).args(["-c", READER]).arg(path).args(names).output();
    let output = match output {
        Ok(output) => output,
        Err(error) => {
            println!("skipped: python3: {error}");
            return None;
        }
    };
    let text = String::from_utf8(output.stdout).unwrap();
    if text.starts_with("skipped:") {
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
        let points = frame.positions.len();
        writeln!(text, "time {:?} points {points} vertices {points} 0", frame.time).unwrap();
        if points == 0 {
            continue;
        }
        writeln!(text, "ids{}", (0..points).map(|id| format!(" {id}")).collect::<String>()).unwrap();
        writeln!(text, "positions{}", floats(frame.positions.as_flattened())).unwrap();
        for field in &frame.fields {
            let values = match &field.values {
                Values::F64(values) => floats(values),
                Values::I64(values) => values.iter().map(|value| format!(" {value}")).collect(),
                other => panic!("no field is {}", other.kind()),
            };
            writeln!(text, "{} {}{values}", field.name, field.width).unwrap();
        }
    }
    text
}

fn floats(values: &[f64]) -> String {
    values.iter().map(|value| format!(" {value:?}")).collect()
}

#[test]
fn reads_every_step_of_a_file_written_at_once_and_of_one_cut_and_continued() {
    let (_guard, folder) = sample::folder();
    let frames: Vec<Frame> = (0..9).map(sample::frame).collect();
    let path = folder.join("frames.vtkhdf");
    let mut file = FrameFile::create(&path, &frames[0]).unwrap();
    frames[1..].iter().for_each(|frame| file.append(frame).unwrap());
    let Some(found) = python(&path) else { return };
    assert!(found == expected(&frames), "{found}");

    let mut file = FrameFile::open_and_cut(&path, 4).unwrap();
    assert!(python(&path).unwrap() == expected(&frames[..4]));
    frames[4..].iter().for_each(|frame| file.append(frame).unwrap());
    assert!(python(&path).unwrap() == expected(&frames));
}
