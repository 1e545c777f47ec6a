//! Elements that a file gives, with the physical groups that its sides and elements are in.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use scree_io::gmsh;
use sha2::{Digest, Sha256};

use super::{Grid, Mpm};
use crate::base::math::cbrt;
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::fem::element::{Element, corners as corners_of};
use crate::fem::hourglass::Modes;
use crate::fem::mesh::{Corners, key_of_side};
use crate::fem::side::Side;

/// What a run calls its own copy of the file.
pub const COPY: &str = "run.msh";

/// Elements of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// As the job names it, joined to the job's folder.
    pub path: PathBuf,
    /// Where it was found: there, or the copy of a run.
    pub read_from: PathBuf,
    /// Length of its unit, m.
    pub unit: f64,
    /// SHA-256 of its bytes, as hex digits; none before it is read.
    pub digest: String,
    /// What it holds; empty before it is read.
    pub drawn: Arc<Drawn>,
}

/// Elements as they lie at the start, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawn {
    /// m.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each as indices of vertices, those of the plane in the first four.
    pub elements: Vec<Corners>,
    /// Groups that each element is in, a bit for each.
    pub groups: Vec<u32>,
    /// Groups of sides, by their vertices.
    pub sides: BTreeMap<[u64; 4], u32>,
    /// What groups are called.
    pub names: Vec<String>,
    /// Means of the corners of elements, m.
    pub middles: Vec<[f64; 3]>,
    /// m3; of the plane with its depth.
    pub volumes: Vec<f64>,
    /// What frequencies are bounded by, 1/m2 ([`Modes::stiffest`]).
    pub stiffest: f64,
}

impl MeshFile {
    /// What it is before a job names a file: no path, in metres.
    pub fn blank() -> Self {
        Self {
            path: PathBuf::new(),
            read_from: PathBuf::new(),
            unit: 1.0,
            digest: String::new(),
            drawn: Arc::default(),
        }
    }

    /// Reads it. Where it is not what its digest says, or is gone, the copy does that a run keeps beside its job: in `folder`, or one or two above it, as seen from
    /// a checkpoint.
    ///
    /// # Errors
    /// What is wrong with it, for an operator.
    pub fn read(&mut self, folder: &Path, grid: &Grid) -> Result<(), String> {
        let copies = [folder.join(COPY), folder.join("..").join(COPY), folder.join("../..").join(COPY)];
        // Without a digest nothing tells a copy from the mesh of somebody else.
        let copies = copies.into_iter().filter(|_| !self.digest.is_empty());
        let candidates: Vec<PathBuf> = std::iter::once(self.path.clone()).chain(copies).collect();
        let read = |path: &Path| std::fs::read(path).ok().map(|bytes| (digest_of(&bytes), bytes));
        let is_it = |digest: &String| self.digest.is_empty() || *digest == self.digest;
        let found = candidates.iter().find_map(|path| {
            let (digest, bytes) = read(path).filter(|(digest, _)| is_it(digest))?;
            Some((path.clone(), digest, bytes))
        });
        let Some((read_from, digest, bytes)) = found else {
            let shown = self.path.display();
            return Err(match read(&self.path) {
                Some((digest, _)) => format!(
                    "is another file than the one that the job is of: {shown} has the SHA-256 {digest}, and mesh.sha256 is {}. Put that file back, or remove sha256 to begin a run with this one.",
                    self.digest
                ),
                None => format!(
                    "names no file that can be read: there is none at {shown}. Give a path that starts from the job's folder, for example file = \"slope.msh\", or write lower, upper and elements for a box."
                ),
            });
        };
        let mesh = gmsh::read(&self.path, &bytes, grid.dimension).map_err(|error| format!("is of no use. {error}."))?;
        (self.read_from, self.digest) = (read_from, digest);
        let drawn = match grid.dimension {
            2 => Drawn::of::<Plane>(mesh, self.unit, grid.depth),
            _ => Drawn::of::<Solid>(mesh, self.unit, grid.depth),
        };
        self.drawn = Arc::new(drawn.map_err(|problem| format!("is of no use. {}: {problem}.", self.path.display()))?);
        Ok(())
    }

    /// The box around it, and cells of the mean size of its elements, by which it is cut into blocks.
    pub fn place(&self, grid: &mut Grid) {
        let drawn = &self.drawn;
        let along = |axis: usize, pick: fn(f64, f64) -> f64| {
            drawn.vertices.iter().map(|vertex| vertex[axis]).reduce(pick).unwrap_or_default()
        };
        let edge = |volume: f64| match grid.dimension {
            2 => (volume / grid.depth).sqrt(),
            _ => cbrt(volume),
        };
        let mean = edge(drawn.volumes.iter().sum::<f64>() / drawn.volumes.len() as f64);
        for axis in 0..grid.dimension {
            (grid.lower[axis], grid.upper[axis]) = (along(axis, f64::min), along(axis, f64::max));
            grid.cells[axis] = ((grid.upper[axis] - grid.lower[axis]) / mean).round().max(1.0) as usize;
        }
        grid.cell = edge(drawn.volumes.iter().copied().fold(f64::INFINITY, f64::min));
    }
}

fn digest_of(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Drawn {
    /// Elements that are wound the other way round, or lie mirrored, are turned; `unit` is the length of the file's, m.
    fn of<S: Space>(mesh: gmsh::Mesh, unit: f64, depth: f64) -> Result<Self, String> {
        let vertices: Vec<[f64; 3]> = mesh.vertices.iter().map(|place| place.map(|along| along * unit)).collect();
        if S::DIMENSION == 2 && vertices.iter().any(|vertex| vertex[2] != vertices[0][2]) {
            return Err("its nodes do not all have the same z, and a job of the plane has its elements across z".into());
        }
        let mut drawn = Self { vertices, names: mesh.groups, ..Self::default() };
        for cell in &mesh.cells {
            let place = |vertex: u32| -> S::Vector {
                let mut place = S::Vector::zero();
                (0..S::DIMENSION).for_each(|axis| place[axis] = drawn.vertices[vertex as usize][axis]);
                place
            };
            let mirrored: Corners = match S::DIMENSION {
                2 => std::array::from_fn(|at| cell.corners[[0, 3, 2, 1, 4, 5, 6, 7][at]]),
                _ => std::array::from_fn(|at| cell.corners[(at + 4) % 8]),
            };
            let laid = [cell.corners, mirrored].into_iter().find_map(|corners| {
                let places = corners.map(place);
                Some((corners, places, Element::of::<S>(&places, depth)?))
            });
            let Some((corners, places, element)) = laid else {
                return Err(format!(
                    "element {} is turned inside out: none of its angles may be 180 degrees or more",
                    cell.number
                ));
            };
            let modes = Modes::of::<S>(&element, &places, depth);
            drawn.stiffest = drawn.stiffest.max(modes.stiffest::<S>(&element));
            drawn.middles.push(middle::<S>(&places));
            drawn.volumes.push(element.volume);
            drawn.elements.push(corners);
            drawn.groups.push(cell.groups);
        }
        drawn.group_sides::<S>(&mesh.sides)?;
        Ok(drawn)
    }

    fn group_sides<S: Space>(&mut self, sides: &[gmsh::Side]) -> Result<(), String> {
        let of = |element: &Corners, side: Side| key_of_side::<S>(side, |corner| u64::from(element[corner]));
        let mut known: Vec<[u64; 4]> = self
            .elements
            .iter()
            .flat_map(|element| Side::all(S::DIMENSION).map(move |side| of(element, side)))
            .collect();
        known.sort_unstable();
        let mut alike: Vec<[u32; 8]> = self.elements.clone();
        alike.iter_mut().for_each(|corners| corners[..corners_of::<S>()].sort_unstable());
        alike.sort_unstable();
        if alike.windows(2).any(|pair| pair[0] == pair[1]) || known.windows(3).any(|three| three[0] == three[2]) {
            return Err(
                "two of its elements lie in each other: they have the same corners, or three have the same side".into(),
            );
        }
        for side in sides {
            let mut key = side.corners.map(u64::from);
            let count = 2 * (S::DIMENSION - 1);
            key[count..].fill(u64::MAX);
            key.sort_unstable();
            if known.binary_search(&key).is_err() {
                return Err(format!(
                    "element {} is the side of no element: its corners are those of several",
                    side.number
                ));
            }
            *self.sides.entry(key).or_default() |= side.groups;
        }
        Ok(())
    }

    /// Bits of the groups of that name; none where no group has it.
    pub fn bits_of(&self, name: &str) -> u32 {
        self.names.iter().zip(0..).filter(|(of, _)| *of == name).fold(0, |bits, (_, bit)| bits | 1 << bit)
    }

    /// Names of the groups that elements (or their sides) are in.
    pub fn names_of(&self, of_sides: bool) -> Vec<&str> {
        let used = match of_sides {
            true => self.sides.values().fold(0, |all, bits| all | bits),
            false => self.groups.iter().fold(0, |all, bits| all | bits),
        };
        self.names.iter().zip(0..).filter(|(_, bit)| used >> bit & 1 == 1).map(|(name, _)| name.as_str()).collect()
    }
}

fn middle<S: Space>(places: &[S::Vector]) -> [f64; 3] {
    let count = corners_of::<S>();
    let sum = |axis: usize| places[..count].iter().map(|place| place[axis]).sum::<f64>();
    std::array::from_fn(|axis| if axis < S::DIMENSION { sum(axis) / count as f64 } else { 0.0 })
}

impl Mpm {
    /// Elements as a file gives them.
    pub fn drawn(&self) -> Option<&Drawn> {
        self.mesh.as_ref()?.file.as_ref().map(|file| &*file.drawn)
    }
}
