//! A frame as a VTK XML file (`.vtu`, UnstructuredGrid, raw appended data), which every ParaView and VTK reads, and a list of such files over time
//! (`.pvd`). VTKHDF wants ParaView 5.12 or VTK 9.3.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write};

use super::{Drawn, Frame, Meaning, meaning_of};
use crate::column::{Column, Values};

/// VTK's number of a cell.
fn cell_type(drawn: Drawn) -> u8 {
    match drawn {
        Drawn::Points => 1,
        Drawn::Lines => 3,
        Drawn::Quadrilaterals => 9,
    }
}

/// The head of the file while its arrays are named, and their bytes behind it.
struct Page {
    head: String,
    data: Vec<u8>,
    meanings: &'static [Meaning],
}

impl Page {
    fn line(&mut self, text: &str) {
        self.head.push_str(text);
        self.head.push('\n');
    }

    /// An array by its place in the data: its length in bytes, then the bytes.
    fn array(&mut self, (kind, name, width): (&str, &str, usize), tuples: Option<usize>, bytes: &[u8]) {
        let tuples = tuples.map_or_else(String::new, |count| format!(" NumberOfTuples=\"{count}\""));
        let offset = self.data.len();
        writeln!(
            self.head,
            "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{width}\"{tuples} format=\"appended\" offset=\"{offset}\"{}",
            escaped(name),
            meaning_of(self.meanings, name).map_or_else(|| "/>".to_string(), |meaning| unit_label(meaning.unit)),
        )
        .expect("a string takes every write");
        self.data.extend((bytes.len() as u64).to_le_bytes());
        self.data.extend(bytes);
    }

    fn column(&mut self, column: &Column, tuples: Option<usize>) {
        let (kind, bytes) = match &column.values {
            Values::F64(values) => ("Float64", values.iter().flat_map(|value| value.to_le_bytes()).collect()),
            Values::I64(values) => ("Int64", values.iter().flat_map(|value| value.to_le_bytes()).collect()),
            Values::U64(values) => ("UInt64", values.iter().flat_map(|value| value.to_le_bytes()).collect()),
            Values::U8(values) => ("UInt8", values.clone()),
        };
        self.array((kind, &column.name, column.width), tuples, &bytes);
    }

    fn integers(&mut self, name: &str, values: impl Iterator<Item = i64>) {
        let bytes: Vec<u8> = values.flat_map(i64::to_le_bytes).collect();
        self.array(("Int64", name, 1), None, &bytes);
    }
}

/// What stands in an array that has a unit, to its end, as VTK writes it.
fn unit_label(unit: &str) -> String {
    let key = "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">";
    format!(">\n{key}{}</InformationKey>\n</DataArray>", escaped(unit))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Writes a frame. `attributes` are words about where it is from, as in the head of VTKHDF files, `meanings` have the units of its fields.
pub fn write_vtu(
    frame: &Frame,
    attributes: &BTreeMap<String, String>,
    meanings: &'static [Meaning],
    to: &mut impl Write,
) -> io::Result<()> {
    let (rows, corners) = (frame.rows(), frame.drawn.positions());
    let mut page = Page { head: String::new(), data: Vec::new(), meanings };
    page.line("<?xml version=\"1.0\"?>");
    for (name, value) in attributes {
        // No comment has two hyphens in a row.
        page.line(&format!("<!-- {name}: {} -->", value.replace("--", "- -")));
    }
    page.line("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">");
    page.line("<UnstructuredGrid>\n<FieldData>");
    page.array(("Float64", "TimeValue", 1), Some(1), &frame.time.to_le_bytes());
    frame.whole.iter().for_each(|column| page.column(column, Some(1)));
    page.line(&format!("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{rows}\">", frame.positions.len()));
    // Of points their own, of what has several corners those of the cell.
    let [own, other] = if frame.drawn == Drawn::Points { ["PointData", "CellData"] } else { ["CellData", "PointData"] };
    page.line(&format!("<{other}/>\n<{own}>"));
    frame.fields.iter().for_each(|column| page.column(column, None));
    page.line(&format!("</{own}>\n<Points>"));
    let places: Vec<u8> = frame.positions.iter().flatten().flat_map(|place| place.to_le_bytes()).collect();
    page.array(("Float64", "Points", 3), None, &places);
    page.line("</Points>\n<Cells>");
    page.integers("connectivity", 0..frame.positions.len() as i64);
    page.integers("offsets", (1..=rows).map(|row| (row * corners) as i64));
    page.array(("UInt8", "types", 1), None, &vec![cell_type(frame.drawn); rows]);
    page.line("</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">");
    to.write_all(page.head.as_bytes())?;
    to.write_all(b"_")?;
    to.write_all(&page.data)?;
    to.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

/// The list of files by their times.
pub fn pvd(files: &[(f64, String)]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in files {
        writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{}\"/>", escaped(file))
            .expect("a string takes every write");
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_lie_where_the_head_says() {
        let column = |name: &str, width: usize, values: Values| Column { name: name.into(), width, values };
        let frame = Frame {
            time: 0.25,
            drawn: Drawn::Lines,
            positions: vec![[0.0; 3], [1.0, 2.0, 3.0]],
            fields: vec![column("force", 3, Values::F64(vec![4.0, 5.0, 6.0]))],
            whole: vec![column("cell_corner", 3, Values::F64(vec![7.0, 8.0, 9.0]))],
        };
        let mut bytes = Vec::new();
        const FORCE: &[Meaning] = &[Meaning { field: "force", unit: "N", what: "force" }];
        write_vtu(&frame, &BTreeMap::from([("program".into(), "scree".into())]), FORCE, &mut bytes).unwrap();
        let begin = bytes.windows(23).position(|part| part == b"<AppendedData encoding=").unwrap();
        let data = begin + bytes[begin..].iter().position(|byte| *byte == b'_').unwrap() + 1;
        let head = String::from_utf8(bytes[..begin].to_vec()).unwrap();
        assert!(head.contains("NumberOfPoints=\"2\" NumberOfCells=\"1\""), "{head}");
        let array = |name: &str| {
            let line = head.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
            let offset = line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
            let at = data + offset.parse::<usize>().unwrap();
            let length = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
            bytes[at + 8..at + 8 + length].to_vec()
        };
        let numbers = |name: &str| -> Vec<f64> {
            array(name).chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap())).collect()
        };
        assert_eq!(numbers("TimeValue"), [0.25]);
        assert_eq!(numbers("cell_corner"), [7.0, 8.0, 9.0]);
        assert_eq!(numbers("force"), [4.0, 5.0, 6.0]);
        assert_eq!(numbers("Points"), [0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(array("types"), [3]);
        assert!(head.find("<CellData>").unwrap() < head.find("\"force\"").unwrap());
        assert!(head.contains("<!-- program: scree -->"));
        let unit = head.lines().position(|line| line.contains("UNITS_LABEL")).unwrap();
        let lines: Vec<&str> = head.lines().collect();
        assert!(lines[unit - 1].contains("\"force\"") && lines[unit].contains(">N<"), "{head}");
        assert_eq!(lines[unit + 1], "</DataArray>");
        assert!(pvd(&[(0.25, "a<.vtu".into())]).contains("timestep=\"0.25\" part=\"0\" file=\"a&lt;.vtu\""));
    }
}
