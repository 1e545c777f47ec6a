//! A continuum of material points on a grid: what `[grid]` in a job means, in SI units.
//!
//! Vectors carry three components; in the plane those of z are zero. Tension is positive in stresses, pressure positive in
//! compression.

use super::Output;
use super::assembly::{Body, Shape};
use crate::base::math::{PI, sin};
use crate::couple::oracle::Oracle;
use crate::law::material::ConstitutiveLaw;
use crate::mpm::nonlocal::Nonlocal;
use crate::mpm::scheme::Scheme;

pub mod figures;
pub mod forecast;
mod granular;
mod keys;
mod mesh;
mod mesh_file;
mod region;
mod rves;
pub mod surface;

pub use granular::{Granular, KnownBands, Origin};
pub use mesh::Mesh;
pub use mesh_file::{COPY as MESH_COPY, Drawn, MeshFile};
pub use region::{Region, RegionShape, Wave, polygon_area};
pub use rves::Rves;

/// The checked job of a continuum.
#[derive(Clone, Debug, PartialEq)]
pub struct Mpm {
    /// Job name; the default run directory is `runs/<name>`.
    pub name: String,
    /// The domain; of elements the box that they fill.
    pub grid: Grid,
    /// Where the continuum is one of elements.
    pub mesh: Option<Mesh>,
    /// Shape functions, stress update and transfer, and points per cell.
    pub scheme: Scheme,
    /// One for all regions.
    pub material: Material,
    /// Where material is at the start; of regions that overlap the first one in the job has the point.
    pub regions: Vec<Region>,
    /// Under which points or elements begin.
    pub stress: InitialStress,
    /// Of all the material, with its ramp.
    pub gravity: Gravity,
    /// Per axis its lower and its upper face. Both are [`Boundary::Periodic`] where the grid is, and [`Boundary::Free`]
    /// beyond its axes.
    pub boundaries: [[Boundary; 2]; 3],
    /// On the surface of the material.
    pub loads: Vec<Load>,
    /// In the plane alone.
    pub membranes: Vec<Membrane>,
    /// Rigid, each with a name of its own.
    pub bodies: Vec<RigidBody>,
    /// Points that have columns of their own in the series.
    pub follow: Vec<Followed>,
    /// Looks for a shear band, where one is wanted.
    pub oracle: Option<Watch>,
    /// How strain is averaged, where it is.
    pub nonlocal: Option<Nonlocal>,
    /// Grains, where the material may be made of them.
    pub grains: Option<Box<Granular>>,
    /// Time step, s; of grains, where the job has some.
    pub step: f64,
    /// Steps of grains in one of the continuum; one without grains.
    pub grain_steps: u64,
    /// Simulated time at which the run ends, s.
    pub end: f64,
    /// Edge of a block in cells; divides the cells along every periodic axis.
    pub cells_per_block: usize,
    /// What is written and when.
    pub output: Output,
    /// An account of work and energy is kept, in columns of its own.
    pub ledger: bool,
}

/// The domain, between walls or periodic, and its cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// 2 (plane strain) or 3.
    pub dimension: usize,
    /// The walls, m. Cells of the job lie between them; what a method needs beyond is its own.
    pub lower: [f64; 3],
    /// m.
    pub upper: [f64; 3],
    /// Edge of a cell, m.
    pub cell: f64,
    /// Whole cells between the walls; 1 beyond the grid's axes.
    pub cells: [usize; 3],
    /// Whether each axis has a period, from `lower` to `upper`, and no walls.
    pub periodic: [bool; 3],
    /// Out-of-plane depth in two dimensions, m; 1 in three, where nothing looks at it.
    pub depth: f64,
}

/// What the points are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Density of the material with its pores at the start, kg/m3, whatever the solid volume fraction.
    pub density: f64,
    /// With its constants.
    pub law: ConstitutiveLaw,
}

/// Cauchy stress at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InitialStress {
    /// Zero.
    None,
    /// Pa.
    Isotropic {
        /// Pa, compression positive.
        pressure: f64,
    },
    /// Under gravity, which is along `axis`: `-(surcharge + density |g| depth)` along that axis, k0 times it across, with
    /// the depth below `surface`; no stress above it.
    Geostatic {
        /// 0, 1 or 2.
        axis: usize,
        /// 1 where gravity points to lower coordinates, -1 where to higher ones: the way up.
        up: f64,
        /// Coordinate of the surface along the axis, m.
        surface: f64,
        /// Stress across gravity over that along it.
        k0: f64,
        /// Pressure on the surface, Pa.
        surcharge: f64,
    },
}

/// Body force per mass, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity {
    /// m/s2.
    pub acceleration: [f64; 3],
    /// It rises linearly from zero over this time, s; 0: it is there from the start.
    pub ramp: f64,
}

/// What happens at a face of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Boundary {
    /// What leaves by it comes in by the face opposite.
    Periodic,
    /// No motion.
    Fixed,
    /// No motion along the normal.
    Roller,
    /// No motion into the wall; along it Coulomb friction against what presses.
    Friction {
        /// mu.
        coefficient: f64,
    },
    /// Dashpots `density c` along and across the normal (Lysmer & Kuhlemeyer 1969).
    Absorbing,
    /// Nothing: what leaves ends the run.
    Free,
}

/// A face of the domain, or the side of material that looks that way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// 0, 1 or 2: the normal's.
    pub axis: usize,
    /// True where the outward normal points to larger coordinates.
    pub upper: bool,
}

/// A load on the surface of the material.
///
/// A point bears it where at the start no point is one spacing beyond it across `face`, and its place lies in the window. It
/// bears the area of its side of that face (spacing, times spacing or depth).
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Side of the material that bears it, unless `group` does.
    pub face: Face,
    /// The physical group of sides of the mesh's file that bears it, in place of a face.
    pub group: Option<String>,
    /// Corners of the window, m.
    pub lower: [f64; 3],
    /// m.
    pub upper: [f64; 3],
    /// Traction or pressure, with its magnitude.
    pub kind: LoadKind,
    /// It rises linearly from zero over this time, s.
    pub ramp: f64,
    /// Whether it acts on the surface, wherever in a cell that is, or at the points behind it.
    pub on_surface: bool,
}

/// What acts per area, once its ramp is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadKind {
    /// Force per area of the start, Pa; neither turns nor grows with the surface.
    Traction([f64; 3]),
    /// Pa, against the surface's normal, on its area as it is (Nanson: `n a = J F^-T N A`).
    Pressure(f64),
}

/// An elastic membrane in the plane, pressed on from one side ([`crate::mpm::membrane`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Membrane {
    /// Its columns in the series begin with it.
    pub name: String,
    /// At the start.
    pub path: Path,
    /// The longest that a segment may be at the start, m; whole ones of one length make up the path.
    pub spacing: f64,
    /// kg/m2.
    pub mass_per_area: f64,
    /// Of a segment, N/m and N s/m.
    pub stiffness: f64,
    /// Of a segment, N s/m.
    pub damping: f64,
    /// What segments bear at the start, N.
    pub tension: f64,
    /// Pa, pushing to the left of the way along the path, and the time over which it rises from zero, s.
    pub pressure: f64,
    /// s; 0: all of the pressure from the start.
    pub ramp: f64,
}

/// Where a membrane is at the start, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// Straight, with ends; its left is seen going from one to the other.
    Line {
        /// m.
        from: [f64; 2],
        /// m.
        to: [f64; 2],
    },
    /// Closed, counter-clockwise: its left is inside.
    Circle {
        /// m.
        centre: [f64; 2],
        /// m.
        radius: f64,
    },
}

impl Path {
    /// m.
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => {
                let [x, y] = [to[0] - from[0], to[1] - from[1]];
                (x * x + y * y).sqrt()
            }
            Self::Circle { radius, .. } => 2.0 * PI * radius,
        }
    }
}

impl Membrane {
    /// Where it begins and ends along x or y, m.
    pub fn extent(&self, axis: usize) -> [f64; 2] {
        match self.path {
            Path::Line { from, to } => [from[axis].min(to[axis]), from[axis].max(to[axis])],
            Path::Circle { centre, radius } => [centre[axis] - radius, centre[axis] + radius],
        }
    }

    /// True of a circle, false of a line with ends.
    pub fn is_closed(&self) -> bool {
        matches!(self.path, Path::Circle { .. })
    }

    /// Whole segments: a ring has three at least.
    pub fn segments(&self) -> usize {
        // Rounding makes no segment more.
        let wanted = (self.path.length() / self.spacing * (1.0 - 1e-9)).ceil() as usize;
        wanted.max(if self.is_closed() { 3 } else { 1 })
    }

    /// Length of a segment at the start, m.
    pub fn segment(&self) -> f64 {
        let count = self.segments() as f64;
        match self.path {
            Path::Line { .. } => self.path.length() / count,
            Path::Circle { radius, .. } => 2.0 * radius * sin(PI / count),
        }
    }

    /// kg.
    pub fn mass_of_segment(&self, depth: f64) -> f64 {
        self.mass_per_area * self.segment() * depth
    }
}

/// Looks for a shear band that grains would replace (Chen et al. 2021, section 3); nothing is replaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watch {
    /// D50 of those grains, m.
    pub diameter: f64,
    /// How a band is detected, and how often it is looked for.
    pub oracle: Oracle,
}

/// A rigid body that the material touches. A plane's normal points towards the material; no body is a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Name, shape and motion.
    pub body: Body,
    /// How material moves along it.
    pub contact: BodyContact,
    /// Material may part from it; otherwise it is held along the normal in both senses.
    pub separates: bool,
    /// It meets material points at its own face ([`crate::mpm::faces`]); else it holds the nodes that lie in it.
    pub at_face: bool,
    /// The side of the mesh that is fastened to it, or the physical group of sides of its file.
    pub side: Option<Face>,
    /// In place of `side`; none where that says it, or nothing is fastened.
    pub group: Option<String>,
    /// Force that presses it on grains, along its first way, until they rest, before the run, N; zero: it stays where it is.
    pub seat: f64,
}

impl RigidBody {
    /// Whether its faces lie in line with the grid, so that it meets points there by itself.
    pub fn is_in_line(&self, periodic: [bool; 3]) -> bool {
        match &self.body.shape {
            Shape::Box { .. } => true,
            Shape::Plane { normal, .. } => (0..3).any(|axis| normal[axis].abs() == 1.0 && !periodic[axis]),
            Shape::Cylinder { .. } | Shape::Layer { .. } => false,
        }
    }
}

/// What a body does to the motion of material that touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyContact {
    /// Material moves with the body.
    Rough,
    /// Material slides freely.
    Smooth,
    /// mu.
    Coulomb {
        /// Friction coefficient.
        friction: f64,
    },
}

/// The point nearest to a place at the start (of several the one of lowest id) has columns of its own in the series.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Its columns in the series begin with it.
    pub name: String,
    /// m.
    pub place: [f64; 3],
    /// Whether its RVE is drawn with every frame.
    pub frames: bool,
}

impl Face {
    /// As it is written in a job.
    pub fn name(self) -> String {
        let axis = ["x", "y", "z"][self.axis];
        format!("{axis}_{}", if self.upper { "upper" } else { "lower" })
    }

    /// Every face of a domain of that many axes.
    pub fn all(axes: usize) -> impl Iterator<Item = Self> {
        (0..axes).flat_map(|axis| [false, true].map(|upper| Self { axis, upper }))
    }
}

impl Grid {
    /// Extent along an axis, m.
    pub fn extent(&self, axis: usize) -> f64 {
        self.upper[axis] - self.lower[axis]
    }
}

impl Mpm {
    /// Whether there are grains at some time.
    pub fn moves_grains(&self) -> bool {
        self.grains.as_ref().is_some_and(|grains| grains.method.has_grains())
    }

    /// Whether grains fill its regions before it begins: those that may move, or whose solid volume fractions points begin with.
    pub fn makes_specimen(&self) -> bool {
        let is_looked_at = |grains: &Granular| grains.method == super::Method::Mpm && grains.is_heterogeneous;
        self.moves_grains() || self.grains.as_deref().is_some_and(is_looked_at)
    }

    /// Whether there are points at some time.
    pub fn has_points(&self) -> bool {
        self.grains.as_ref().is_none_or(|grains| grains.method.has_points())
    }

    /// Whether stresses of single points are noise about the mean of their cell: of several points in a cell nodes feel the sum
    /// of the stresses alone, and a material that yields as it moves under its weight keeps the differences that its points come to,
    /// unless volume strain is averaged.
    pub fn has_noisy_stresses(&self) -> bool {
        let yields = self.material.law.yields() || self.rves().is_some();
        let weighs = self.gravity.acceleration != [0.0; 3];
        self.has_points() && self.scheme.points_per_cell > 1 && !self.scheme.averages_volume && yields && weighs
    }

    /// Whether volume strain of points is averaged over nodes where they flow.
    pub fn averages_volume(&self) -> bool {
        let flows = self.material.law.yields() || self.rves().is_some();
        self.has_points() && self.scheme.averages_volume && flows && self.nonlocal.is_none()
    }

    /// Whether the solid volume fraction of the start is that of the grains' packing, which is not made yet.
    pub fn is_told_by_packing(&self) -> bool {
        self.grains.is_some() && self.material.law.yields() && self.material.law.fraction().is_none()
    }

    /// Solid volume fraction that the points of a region start with, as far as it is known; 1 of a law that knows none.
    pub fn fraction_in(&self, region: &Region) -> f64 {
        let is_that_of_all = region.fraction == 1.0 && self.material.law.yields();
        if is_that_of_all { forecast::fraction_of_packing(self) } else { region.fraction }
    }

    /// Grains at every point, where the material is that.
    pub fn rves(&self) -> Option<(&Granular, &Rves)> {
        let granular = self.grains.as_deref()?;
        granular.method.has_rves().then_some((granular, &granular.rves))
    }

    /// Time step of the continuum, s.
    pub fn step_of_continuum(&self) -> f64 {
        self.grain_steps as f64 * self.step
    }

    /// Distance of neighbouring points at the start, m.
    pub fn spacing(&self) -> f64 {
        self.grid.cell / self.scheme.points_per_cell as f64
    }

    /// The same along an axis: elements have edges of their own along each.
    pub fn spacing_along(&self, axis: usize) -> f64 {
        self.edge(axis) / self.scheme.points_per_cell as f64
    }

    /// Places of the start along each axis: points may be in the middle of each; 1 beyond the grid's axes. Elements of a file are in a row.
    pub fn places(&self) -> [usize; 3] {
        if let Some(drawn) = self.drawn() {
            return [drawn.elements.len(), 1, 1];
        }
        std::array::from_fn(|axis| match axis < self.grid.dimension {
            true => self.grid.cells[axis] * self.scheme.points_per_cell,
            false => 1,
        })
    }

    /// The place with that index along each axis, m.
    pub fn place(&self, index: [usize; 3]) -> [f64; 3] {
        if let Some(drawn) = self.drawn() {
            return drawn.middles[index[0]];
        }
        let per_cell = self.scheme.points_per_cell as f64;
        std::array::from_fn(|axis| match axis < self.grid.dimension {
            true => self.grid.lower[axis] + self.edge(axis) * ((index[axis] as f64 + 0.5) / per_cell),
            false => 0.0,
        })
    }

    /// What the place at that index is called: ids of points count places, x fastest.
    pub fn number(&self, [x, y, z]: [usize; 3]) -> u64 {
        let places = self.places();
        ((z * places[1] + y) * places[0] + x) as u64
    }

    /// The index of the place that is called so.
    pub fn index(&self, number: u64) -> [usize; 3] {
        let (places, number) = (self.places(), number as usize);
        [number % places[0], number / places[0] % places[1], number / places[0] / places[1]]
    }

    /// How much more inertia the material has than mass.
    pub fn mass_scaling(&self) -> f64 {
        self.mesh.as_ref().map_or(1.0, |mesh| mesh.mass_scaling)
    }

    /// The density that resists acceleration, kg/m3.
    pub fn inertial_density(&self) -> f64 {
        self.material.density * self.mass_scaling()
    }

    /// Pressure along gravity of a geostatic stress at a coordinate along its axis, Pa; of other stresses zero.
    pub fn overburden(&self, at: f64) -> f64 {
        let InitialStress::Geostatic { up, surface, surcharge, .. } = self.stress else { return 0.0 };
        let gravity = self.gravity.acceleration.iter().map(|g| g * g).sum::<f64>().sqrt();
        let depth = up * (surface - at);
        if depth > 0.0 { surcharge + self.material.density * gravity * depth } else { 0.0 }
    }

    /// The region that has the material at a place of the start, if there is any.
    pub fn region_at(&self, place: &[f64; 3]) -> Option<usize> {
        self.regions.iter().position(|region| region.shape.contains(place))
    }

    /// The region that has the point at an index, if there is one.
    pub fn region_of(&self, index: [usize; 3]) -> Option<usize> {
        let (place, groups) = (self.place(index), self.drawn().map_or(0, |drawn| drawn.groups[index[0]]));
        self.regions.iter().position(|region| match &region.shape {
            RegionShape::Group { bits, .. } => groups & bits != 0,
            shape => shape.contains(&place),
        })
    }

    /// Volume of the point at an index at the start, m3.
    pub fn volume_at(&self, index: [usize; 3]) -> f64 {
        if self.mesh.is_some() { self.element_volume(index) } else { self.point_volume() }
    }

    /// Volume of a point at the start, m3; of elements of a file the mean.
    pub fn point_volume(&self) -> f64 {
        if let Some(drawn) = self.drawn() {
            return drawn.volumes.iter().sum::<f64>() / drawn.volumes.len() as f64;
        }
        let spacing = self.spacing();
        match self.grid.dimension {
            _ if self.mesh.is_some() => self.element_volume([0; 3]),
            2 => spacing * spacing * self.grid.depth,
            _ => spacing * spacing * spacing,
        }
    }

    /// Whether the point of the start at that index bears a load.
    pub fn bears(&self, load: &Load, index: [usize; 3]) -> bool {
        let place = self.place(index);
        let inside = (0..self.grid.dimension).all(|axis| (load.lower[axis]..=load.upper[axis]).contains(&place[axis]));
        inside && self.region_of(index).is_some() && !self.has_point_beyond(index, load.face)
    }

    /// Whether there is a point one spacing beyond that of an index, across the periods.
    pub fn has_point_beyond(&self, index: [usize; 3], face: Face) -> bool {
        let (axis, count) = (face.axis, self.places()[face.axis]);
        let at_end = index[axis] == if face.upper { count - 1 } else { 0 };
        (!at_end || self.grid.periodic[axis]) && self.region_of(self.beyond(index, face)).is_some()
    }

    /// The index of the place one spacing beyond that of another, across the periods.
    pub fn beyond(&self, mut index: [usize; 3], face: Face) -> [usize; 3] {
        let (axis, count) = (face.axis, self.places()[face.axis]);
        index[axis] = if face.upper { (index[axis] + 1) % count } else { (index[axis] + count - 1) % count };
        index
    }

    /// Area that a point bears at the start, m2.
    pub fn point_area(&self) -> f64 {
        self.point_volume() / self.spacing()
    }
}
