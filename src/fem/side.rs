//! Sides of elements, and what presses on them.

use crate::base::space::{Linear, Space};
use crate::fem::element::{CORNERS_MAX, GAUSS, NATURAL};

/// Corners of a side, in the plane and in space.
pub const FACE_CORNERS: [usize; 2] = [2, 4];

/// A side of an element, by the natural axis that it is across.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// 0 to 2.
    pub axis: u8,
    /// Whether it is at +1 of that axis; else at -1.
    pub upper: bool,
}

/// Corners of the sides of a quadrilateral and a hexahedron, lower and upper of each axis, in the order in which the area vector points out
/// of the element.
const OF_QUADRILATERAL: [[usize; 2]; 4] = [[3, 0], [1, 2], [0, 1], [2, 3]];
const OF_HEXAHEDRON: [[usize; 4]; 6] =
    [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]];

impl Side {
    /// All of an element of so many axes: by axis, the lower side first.
    pub fn all(axes: usize) -> impl Iterator<Item = Self> {
        (0..axes as u8).flat_map(|axis| [false, true].map(|upper| Self { axis, upper }))
    }

    /// Two corners of the element in the plane, four in space, in the order in which the area vector points out.
    pub fn corners<S: Space>(self) -> &'static [usize] {
        let number = 2 * usize::from(self.axis) + usize::from(self.upper);
        match S::DIMENSION {
            2 => &OF_QUADRILATERAL[number],
            _ => &OF_HEXAHEDRON[number],
        }
    }

    /// What of the area vector of a side (m2, out of the element) belongs to each of its corners, `int N n dA`, which a uniform stress is in
    /// balance with to round-off; `places` are those of all corners of the element, m.
    pub fn areas<S: Space>(self, places: &[S::Vector; CORNERS_MAX], depth: f64) -> [S::Vector; 4] {
        let at = self.corners::<S>();
        let mut areas = [S::Vector::zero(); 4];
        if S::DIMENSION == 2 {
            let way = places[at[1]] - places[at[0]];
            let mut half = S::Vector::zero();
            (half[0], half[1]) = (0.5 * depth * way[1], -0.5 * depth * way[0]);
            areas[..2].fill(half);
            return areas;
        }
        // Products of bilinear functions: two points along each way are exact.
        for [r, s] in [[-GAUSS, -GAUSS], [GAUSS, -GAUSS], [GAUSS, GAUSS], [-GAUSS, GAUSS]] {
            let (mut along, mut across) = (S::Vector::zero(), S::Vector::zero());
            for (corner, place) in at.iter().zip(NATURAL) {
                along += places[*corner] * (0.25 * place[0] * (1.0 + s * place[1]));
                across += places[*corner] * (0.25 * place[1] * (1.0 + r * place[0]));
            }
            let mut normal = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                normal[axis] = along[next] * across[last] - along[last] * across[next];
            }
            for (area, place) in areas.iter_mut().zip(NATURAL) {
                *area += normal * (0.25 * (1.0 + r * place[0]) * (1.0 + s * place[1]));
            }
        }
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Plane, Solid};

    fn closed<S: Space>() {
        // A cube with its corners moved about.
        let places: [S::Vector; CORNERS_MAX] = std::array::from_fn(|corner| {
            let mut place = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                place[axis] = NATURAL[corner][axis] + 0.05 * ((7 * corner + 3 * axis) % 5) as f64;
            }
            place
        });
        let mut sum = S::Vector::zero();
        for side in Side::all(S::DIMENSION) {
            let areas = side.areas::<S>(&places, 2.0);
            let total = areas.iter().fold(S::Vector::zero(), |sum, area| sum + *area);
            let outward = total[usize::from(side.axis)] * if side.upper { 1.0 } else { -1.0 };
            assert!(outward > 0.5, "{side:?} {total:?}");
            sum += total;
        }
        assert!(sum.norm() < 1e-14, "{sum:?}");
    }

    #[test]
    fn sides_close_around_an_element_and_point_out_of_it() {
        closed::<Plane>();
        closed::<Solid>();
    }
}
