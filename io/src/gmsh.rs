//! Meshes that Gmsh has made: a file of format MSH 4.1 in text (Gmsh reference manual, "MSH file format").
//!
//! ```text
//! $PhysicalNames   names of groups that the operator has made
//! $Entities        which groups each part of the geometry is in
//! $Nodes           places, by number
//! $Elements        corners, by those numbers, part by part
//! ```
//!
//! What is read: quadrilaterals with lines as their sides, or hexahedra with quadrilaterals as theirs, of four, two and eight corners. Numbers of
//! nodes may have gaps and any order.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::str::SplitWhitespace;

use crate::error::Error;

/// Groups that a mesh may have: each is a bit of a word.
pub const GROUPS_MAX: usize = 32;

/// A mesh of cells with as many axes as were asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Places of the nodes that cells have, in the unit of the file, in the order of their numbers.
    pub vertices: Vec<[f64; 3]>,
    /// In the order of the file.
    pub cells: Vec<Cell>,
    /// Those that the file lists, in its order.
    pub sides: Vec<Side>,
    /// Names of the physical groups of cells and of sides; one without a name is called by its number.
    pub groups: Vec<String>,
}

/// A cell by its vertices, in the order that Gmsh and VTK have them; a quadrilateral has four.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The number that the file calls it by.
    pub number: u64,
    /// Places in [`Mesh::vertices`]; the last four of a quadrilateral are 0.
    pub corners: [u32; 8],
    /// A bit for each group.
    pub groups: u32,
}

/// A side by its vertices; a line has two.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The number that the file calls it by.
    pub number: u64,
    /// Places in [`Mesh::vertices`]; the last two of a line are 0.
    pub corners: [u32; 4],
    /// A bit for each group, by its place in [`Mesh::groups`].
    pub groups: u32,
}

/// Kinds of elements by their number in the format: corners, axes.
const LINE: (u64, usize) = (1, 2);
const QUADRILATERAL: (u64, usize) = (3, 4);
const HEXAHEDRON: (u64, usize) = (5, 8);
/// What others are called.
const NAMES: [(u64, &str); 8] = [
    (2, "triangles"),
    (4, "tetrahedra"),
    (6, "prisms"),
    (7, "pyramids"),
    (8, "lines of second order"),
    (10, "quadrilaterals of second order"),
    (12, "hexahedra of second order"),
    (17, "hexahedra of second order"),
];

/// Reads a mesh of cells in the plane (`axes` 2) or in space (3).
pub fn read(path: &Path, bytes: &[u8], axes: usize) -> Result<Mesh, Error> {
    let failed = |line: usize, what: String| Error::Mesh { path: path.to_path_buf(), line, what };
    let text = std::str::from_utf8(bytes).map_err(|_| failed(1, not_text()))?;
    let mut lines = Lines { rest: text.lines(), line: 0 };
    Reading { axes, ..Reading::default() }.read(&mut lines).map_err(|what| failed(lines.line.max(1), what))
}

fn not_text() -> String {
    "this is no text; save the mesh by `gmsh IN.msh -save -format msh41 -setnumber Mesh.Binary 0 -o OUT.msh`".into()
}

/// Lines of a file, counted.
struct Lines<'a> {
    rest: std::str::Lines<'a>,
    line: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a str> {
        self.line += 1;
        self.rest.next().map(str::trim)
    }

    /// Words of the next line, which has to be there.
    fn words(&mut self) -> Result<Words<'a>, String> {
        let line = self.next().ok_or("the file ends in the middle of a section; copy or save it again")?;
        Ok(Words { words: line.split_whitespace() })
    }
}

struct Words<'a> {
    words: SplitWhitespace<'a>,
}

impl Words<'_> {
    fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, String> {
        let word = self.words.next().ok_or(format!("{what} is missing"))?;
        word.parse().map_err(|_| format!("`{word}` is not {what}"))
    }
}

/// What has been read so far.
#[derive(Default)]
struct Reading {
    axes: usize,
    names: BTreeMap<(usize, i64), String>,
    /// Groups of an entity by its axes and number.
    entities: HashMap<(usize, i64), Vec<i64>>,
    places: BTreeMap<u64, [f64; 3]>,
    elements: Option<Vec<Element>>,
}

/// An element that is a cell or a side of one.
struct Element {
    axes: usize,
    number: u64,
    entity: i64,
    corners: Vec<u64>,
    line: usize,
}

impl Reading {
    fn read(mut self, lines: &mut Lines<'_>) -> Result<Mesh, String> {
        let mut is_known = false;
        while let Some(line) = lines.next() {
            match line {
                "$MeshFormat" => {
                    format(lines)?;
                    is_known = true;
                }
                _ if !is_known => {
                    return Err("this is no mesh of Gmsh: it does not begin with $MeshFormat".into());
                }
                "$PhysicalNames" => self.names(lines).and_then(|()| end(lines, "$EndPhysicalNames"))?,
                "$Entities" => self.entities(lines).and_then(|()| end(lines, "$EndEntities"))?,
                "$Nodes" => self.nodes(lines).and_then(|()| end(lines, "$EndNodes"))?,
                "$Elements" => self.elements(lines).and_then(|()| end(lines, "$EndElements"))?,
                // Sections of other kinds.
                _ => {}
            }
        }
        let elements = self.elements.take().ok_or("there is no section $Elements; save the mesh again")?;
        self.put_together(elements, lines)
    }

    fn names(&mut self, lines: &mut Lines<'_>) -> Result<(), String> {
        let count: usize = lines.words()?.number("a count of names")?;
        for _ in 0..count {
            let line = lines.next().unwrap_or_default();
            let mut words = Words { words: line.split_whitespace() };
            let key = (words.number("a number of axes")?, words.number("the number of a group")?);
            let name = line.split('"').nth(1).ok_or("the name of a group stands in no quotation marks")?;
            self.names.insert(key, name.to_string());
        }
        Ok(())
    }

    fn entities(&mut self, lines: &mut Lines<'_>) -> Result<(), String> {
        let mut words = lines.words()?;
        let mut counts = [0usize; 4];
        for count in &mut counts {
            *count = words.number("a count of entities")?;
        }
        for (axes, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let mut words = lines.words()?;
                let number = words.number("the number of an entity")?;
                // A point has a place, others a box.
                for _ in 0..if axes == 0 { 3 } else { 6 } {
                    words.number::<f64>("a coordinate")?;
                }
                let groups: usize = words.number("a count of groups")?;
                let groups: Result<Vec<i64>, String> = (0..groups).map(|_| words.number("a group")).collect();
                // The sign is that of its orientation.
                self.entities.insert((axes, number), groups?.into_iter().map(i64::wrapping_abs).collect());
            }
        }
        Ok(())
    }

    fn nodes(&mut self, lines: &mut Lines<'_>) -> Result<(), String> {
        let blocks: usize = lines.words()?.number("a count of blocks")?;
        for _ in 0..blocks {
            let mut words = lines.words()?;
            let [_, _, _]: [i64; 3] = [words.number("axes")?, words.number("an entity")?, words.number("0 or 1")?];
            let count: usize = words.number("a count of nodes")?;
            let numbers: Result<Vec<u64>, String> =
                (0..count).map(|_| lines.words()?.number("the number of a node")).collect();
            for number in numbers? {
                let mut words = lines.words()?;
                let mut place = [0.0; 3];
                for coordinate in &mut place {
                    *coordinate = words.number("a coordinate")?;
                    if !f64::is_finite(*coordinate) {
                        return Err(format!("node {number} has a coordinate that is not finite"));
                    }
                }
                if self.places.insert(number, place).is_some() {
                    return Err(format!("node {number} is there twice"));
                }
            }
        }
        Ok(())
    }

    fn elements(&mut self, lines: &mut Lines<'_>) -> Result<(), String> {
        let blocks: usize = lines.words()?.number("a count of blocks")?;
        let (cell, side) = if self.axes == 2 { (QUADRILATERAL, LINE) } else { (HEXAHEDRON, QUADRILATERAL) };
        let mut found = Vec::new();
        for _ in 0..blocks {
            let mut words = lines.words()?;
            let (axes, entity) = (words.number::<usize>("axes")?, words.number("an entity")?);
            let (kind, count) = (words.number::<u64>("a kind of element")?, words.number::<usize>("a count")?);
            let wanted = if axes == self.axes { cell } else { side };
            if axes > self.axes {
                return Err(format!(
                    "here are elements with {axes} axes, and the job is of the plane; write space = \"solid\""
                ));
            }
            let is_of_use = axes + 1 >= self.axes && count > 0;
            if is_of_use && kind != wanted.0 {
                return Err(self.other_kind(kind, axes));
            }
            for _ in 0..count {
                let mut words = lines.words()?;
                if !is_of_use {
                    continue;
                }
                let number = words.number("the number of an element")?;
                let corners: Result<Vec<u64>, String> = (0..wanted.1).map(|_| words.number("a corner")).collect();
                found.push(Element { axes, number, entity, corners: corners?, line: lines.line });
            }
        }
        self.elements.get_or_insert_default().extend(found);
        Ok(())
    }

    fn other_kind(&self, kind: u64, axes: usize) -> String {
        let name =
            NAMES.iter().find(|(number, _)| *number == kind).map_or("elements of another kind", |(_, name)| name);
        let (what, wanted) = match (axes == self.axes, self.axes) {
            (true, 2) => ("cells", "quadrilaterals of four corners"),
            (true, _) => ("cells", "hexahedra of eight corners"),
            (false, 2) => ("sides", "lines of two ends"),
            (false, _) => ("sides", "quadrilaterals of four corners"),
        };
        format!(
            "here are {name} (kind {kind}), and {what} have to be {wanted}; make them by transfinite or recombined meshes (Mesh.RecombineAll = 1, Mesh.SubdivisionAlgorithm = 1, in space extruded layers with Recombine), of order 1"
        )
    }

    fn put_together(self, elements: Vec<Element>, lines: &mut Lines<'_>) -> Result<Mesh, String> {
        if !elements.iter().any(|of| of.axes == self.axes) {
            return Err(format!(
                "there is no cell with {} axes; where there are physical groups, Gmsh saves what is in one of them alone: put the material into one",
                self.axes
            ));
        }
        let mut used: Vec<u64> =
            elements.iter().filter(|of| of.axes == self.axes).flat_map(|of| of.corners.clone()).collect();
        used.sort_unstable();
        used.dedup();
        let mut mesh = Mesh::default();
        let mut groups: BTreeMap<(usize, i64), u32> = BTreeMap::new();
        for element in &elements {
            lines.line = element.line;
            if let Some(lost) = element.corners.iter().find(|number| !self.places.contains_key(number)) {
                return Err(format!("node {lost} is a corner of element {} and has no place", element.number));
            }
            let corner = |number: &u64| {
                used.binary_search(number)
                    .map(|at| at as u32)
                    .map_err(|_| format!("element {} is a side at node {number}, which no cell has", element.number))
            };
            let corners: Vec<u32> = element.corners.iter().map(corner).collect::<Result<_, String>>()?;
            let mut bits = 0;
            for group in self.entities.get(&(element.axes, element.entity)).into_iter().flatten() {
                let next = groups.len();
                if next >= GROUPS_MAX && !groups.contains_key(&(element.axes, *group)) {
                    return Err(format!(
                        "there are more than {GROUPS_MAX} physical groups of cells and sides; take fewer"
                    ));
                }
                bits |= 1u32 << *groups.entry((element.axes, *group)).or_insert(next as u32);
            }
            if element.axes == self.axes {
                let mut all = [0; 8];
                all[..corners.len()].copy_from_slice(&corners);
                mesh.cells.push(Cell { number: element.number, corners: all, groups: bits });
            } else {
                let mut all = [0; 4];
                all[..corners.len()].copy_from_slice(&corners);
                mesh.sides.push(Side { number: element.number, corners: all, groups: bits });
            }
        }
        for number in &used {
            mesh.vertices.push(self.places[number]);
        }
        mesh.groups = vec![String::new(); groups.len()];
        for ((axes, number), bit) in groups {
            mesh.groups[bit as usize] = self.names.get(&(axes, number)).cloned().unwrap_or_else(|| number.to_string());
        }
        Ok(mesh)
    }
}

/// The line that a section ends with: what is there in its place has not been counted.
fn end(lines: &mut Lines<'_>, wanted: &str) -> Result<(), String> {
    match lines.next() {
        Some(line) if line == wanted => Ok(()),
        Some(line) => Err(format!(
            "here is `{line}` where {wanted} has to be: there is more than the section says; save the mesh again"
        )),
        None => Err(format!("the file ends before {wanted}; copy or save it again")),
    }
}

fn format(lines: &mut Lines<'_>) -> Result<(), String> {
    let mut words = lines.words()?;
    let version: f64 = words.number("a version")?;
    let is_binary = words.number::<u8>("0 for text, 1 for binary")? != 0;
    match (version == 4.1, is_binary) {
        (_, true) => Err(not_text()),
        (false, _) => Err(format!(
            "this is MSH {version}, and MSH 4.1 is wanted; save the mesh by `gmsh IN.msh -save -format msh41 -o OUT.msh`"
        )),
        (true, false) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side, their nodes numbered with gaps and out of order, and the left end of them.
    const TWO: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"left end\"\n2 1 \"sand\"\n$EndPhysicalNames\n\
        $Entities\n0 1 1 0\n4 0 0 0 0 1 0 1 -7 0\n1 0 0 0 2 1 0 1 1 0\n$EndEntities\n\
        $Nodes\n2 6 3 90\n1 4 0 2\n9\n3\n0 0 0\n0 1 0\n2 1 0 4\n90\n5\n6\n4\n2 1 0\n1 0 0\n1 1 0\n2 0 0\n$EndNodes\n\
        $Elements\n3 4 1 11\n0 1 15 1\n1 9\n1 4 1 1\n2 3 9\n2 1 3 2\n10 9 5 6 3\n11 5 4 90 6\n$EndElements\n";

    fn of(text: &str, axes: usize) -> Result<Mesh, String> {
        read(Path::new("a.msh"), text.as_bytes(), axes).map_err(|error| error.to_string())
    }

    #[test]
    fn nodes_are_known_by_their_numbers() {
        let mesh = of(TWO, 2).unwrap();
        let place = |number: u32| mesh.vertices[number as usize];
        let corners: Vec<[f64; 3]> = mesh.cells[1].corners[..4].iter().map(|corner| place(*corner)).collect();
        assert_eq!(corners, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
        let side: Vec<[f64; 3]> = mesh.sides[0].corners[..2].iter().map(|corner| place(*corner)).collect();
        assert_eq!(side, [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]);
        assert_eq!(mesh.groups, ["left end", "sand"]);
        assert_eq!((mesh.sides[0].groups, mesh.cells[0].groups, mesh.cells[1].groups), (1, 2, 2));
        assert_eq!((mesh.cells[0].number, mesh.cells[1].number, mesh.vertices.len()), (10, 11, 6));
    }

    #[test]
    fn what_is_wrong_is_told_by_its_line() {
        for (from, to, wanted) in [
            ("4.1 0 8", "2.2 0 8", "a.msh, line 2: this is MSH 2.2"),
            ("4.1 0 8", "4.1 1 8", "line 2: this is no text"),
            ("2 1 3 2\n", "2 1 2 2\n", "line 37: here are triangles (kind 2), and cells have to be quadrilaterals"),
            ("11 5 4 90 6", "11 5 4 91 6", "node 91 is a corner of element 11 and has no place"),
            ("2 3 9", "2 3 8", "line 36: node 8 is a corner of element 2 and has no place"),
            ("0 1 0\n2 1 0 4", "0 x 0\n2 1 0 4", "line 20: `x` is not a coordinate"),
            ("11 5 4 90 6\n$EndElements\n", "", "the file ends in the middle of a section"),
            ("11 5 4 90 6\n$EndElements\n", "11 5 4 90 6\n", "the file ends before $EndElements"),
            ("2 1 3 2\n", "2 1 3 1\n", "here is `11 5 4 90 6` where $EndElements has to be"),
            ("2 1 3 2\n10 9 5 6 3\n11 5 4 90 6\n", "2 1 3 0\n", "there is no cell with 2 axes"),
        ] {
            let found = of(&TWO.replace(from, to), 2).unwrap_err();
            assert!(found.contains(wanted), "{from}: {found}");
        }
        assert!(of("solid\n", 2).unwrap_err().contains("line 1: this is no mesh of Gmsh"));
        assert!(of(TWO, 3).unwrap_err().contains("there is no cell with 3 axes"));
    }
}
