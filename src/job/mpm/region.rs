//! Where material is at the start of a job on a grid or mesh, and how it moves.

use crate::base::math::{PI, cos, sin};

/// Material at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Where its material is.
    pub shape: RegionShape,
    /// Solid volume fraction that its points start with; 1 where it has none of its own. Mass does not follow it.
    pub fraction: f64,
    /// m/s.
    pub velocity: [f64; 3],
    /// rad/s, about the centre of the region.
    pub spin: [f64; 3],
    /// Added to the velocity.
    pub waves: Vec<Wave>,
    /// Grains taken out of the packing that its RVEs begin from.
    pub grains_removed: u64,
}

/// A place on the lower or left border of a box belongs to it, one on the upper or right border does not.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionShape {
    /// Edges are along the axes.
    Box {
        /// m.
        lower: [f64; 3],
        /// m.
        upper: [f64; 3],
    },
    /// A disc in the plane.
    Ball {
        /// m.
        centre: [f64; 3],
        /// m.
        radius: f64,
    },
    /// A simple polygon in the plane, in either sense.
    Polygon {
        /// Corners one after the other, x and y, m; the last is joined to the first.
        vertices: Vec<[f64; 2]>,
    },
    /// Elements of a physical group of the mesh's file, by the bits of its name, and the box around their middles, m.
    Group {
        /// As the mesh's file has it.
        name: String,
        /// A bit for each group of that name, as in [`Drawn::groups`](super::Drawn::groups); 0 until it is looked up.
        bits: u32,
        /// m.
        lower: [f64; 3],
        /// m.
        upper: [f64; 3],
    },
}

/// `amplitude sin(2 pi direction.(x - origin)/length)` of the velocity at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Unit vector.
    pub direction: [f64; 3],
    /// m.
    pub length: f64,
    /// A place where it vanishes, m.
    pub origin: [f64; 3],
    /// m/s.
    pub amplitude: [f64; 3],
}

impl RegionShape {
    /// Whether a place lies in it; of a group none does by itself.
    pub fn contains(&self, place: &[f64; 3]) -> bool {
        match self {
            Self::Group { .. } => false,
            Self::Box { lower, upper } => (0..3).all(|axis| {
                // In the plane both corners are at z = 0.
                lower[axis] == upper[axis] || (lower[axis]..upper[axis]).contains(&place[axis])
            }),
            Self::Ball { centre, radius } => {
                let arm: [f64; 3] = std::array::from_fn(|axis| place[axis] - centre[axis]);
                arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2] <= radius * radius
            }
            Self::Polygon { vertices } => polygon_contains(vertices, place),
        }
    }

    /// Centre of the box or ball, centroid of the polygon, m.
    pub fn centre(&self) -> [f64; 3] {
        match self {
            Self::Box { lower, upper } | Self::Group { lower, upper, .. } => {
                std::array::from_fn(|axis| 0.5 * (lower[axis] + upper[axis]))
            }
            Self::Ball { centre, .. } => *centre,
            Self::Polygon { vertices } => polygon_centre(vertices),
        }
    }
}

/// Pairs of vertices one after the other, the last with the first.
fn edges(vertices: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    (0..vertices.len()).map(|at| (vertices[at], vertices[(at + 1) % vertices.len()]))
}

/// A ray to the right crosses the border an odd number of times.
fn polygon_contains(vertices: &[[f64; 2]], place: &[f64; 3]) -> bool {
    let crossed = edges(vertices).filter(|(from, to)| {
        (from[1] > place[1]) != (to[1] > place[1])
            && place[0] < from[0] + (to[0] - from[0]) * (place[1] - from[1]) / (to[1] - from[1])
    });
    crossed.count() % 2 == 1
}

/// Area with its sign: positive where the vertices go round against the clock, m2.
pub fn polygon_area(vertices: &[[f64; 2]]) -> f64 {
    edges(vertices).map(|(from, to)| 0.5 * (from[0] * to[1] - to[0] * from[1])).sum()
}

fn polygon_centre(vertices: &[[f64; 2]]) -> [f64; 3] {
    let area = polygon_area(vertices);
    let moment = |axis: usize| -> f64 {
        edges(vertices).map(|(from, to)| (from[axis] + to[axis]) * (from[0] * to[1] - to[0] * from[1]) / 6.0).sum()
    };
    [moment(0) / area, moment(1) / area, 0.0]
}

impl Region {
    /// Velocity at a place at the start, m/s.
    pub fn velocity_at(&self, place: &[f64; 3]) -> [f64; 3] {
        let centre = self.shape.centre();
        let arm: [f64; 3] = std::array::from_fn(|axis| place[axis] - centre[axis]);
        let turned = |axis: usize| {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            self.spin[next] * arm[last] - self.spin[last] * arm[next]
        };
        std::array::from_fn(|axis| {
            let waves = self.waves.iter().map(|wave| wave.share_at(place) * wave.amplitude[axis]);
            waves.fold(self.velocity[axis] + turned(axis), |sum, wave| sum + wave)
        })
    }

    /// Its gradient there, 1/s: row by row the change of a component along each axis.
    pub fn velocity_gradient_at(&self, place: &[f64; 3]) -> [[f64; 3]; 3] {
        let [x, y, z] = self.spin;
        let mut gradient = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        for wave in &self.waves {
            let slope = wave.slope_at(place);
            for (row, amplitude) in gradient.iter_mut().zip(wave.amplitude) {
                row.iter_mut().zip(wave.direction).for_each(|(change, along)| *change += amplitude * along * slope);
            }
        }
        gradient
    }
}

impl Wave {
    /// What the sine is taken of at a place.
    fn phase_at(&self, place: &[f64; 3]) -> f64 {
        let along = |axis: usize| self.direction[axis] * (place[axis] - self.origin[axis]);
        2.0 * PI * (along(0) + along(1) + along(2)) / self.length
    }

    /// The sine at a place.
    fn share_at(&self, place: &[f64; 3]) -> f64 {
        sin(self.phase_at(place))
    }

    /// Its change along the wave, 1/m.
    fn slope_at(&self, place: &[f64; 3]) -> f64 {
        2.0 * PI / self.length * cos(self.phase_at(place))
    }
}
