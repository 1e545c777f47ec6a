//! Bodies that meet material points at their own face: planes and boxes whose faces lie in line with the grid.
//!
//! A body that holds the nodes inside it holds them by whole cells: its load dips wherever it passes one. Here it acts where it is. Points
//! in front of a face say how much of its area every node near it stands for,
//!
//! ```text
//! w_i = -n . sum_p w_p J_p V_p grad N_i(x_p)          m2; sums to the area that material in front of the face covers
//! T_i = sum_p N_i(x_p) t_p                            whether points touch: t = 0.6 where d_p - r_p < 0.02 h, else -0.4 where d_p < 2 r_p
//! ```
//!
//! with n from the body into the material, d_p a point's distance, r_p half of its box along n, h the cell, and w_p times the share of the
//! box that is in front of the face: gradients of what is inside the material cancel (the divergence theorem), and its free side is out of
//! the face's reach or counted by the points in front of it alone. The nodes of one grid line across the face are a column s; lines less
//! than a cell within an edge of the face, and those beyond it, belong to the column of the next one, so that what the face covers of
//! them bears the pressure there, and no line is acted on or let go as a whole where an edge passes it. The material of a column goes with
//! the body on average, not node by node,
//!
//! ```text
//! c = sum w n.(v_i - V(x_i)),   u = sum w (v_i - V(x_i)) - c n,   K = sum w^2/m_i,   A = sum w
//! lambda = -c/K,   tau = -u/K                         rough; smooth: tau = 0; Coulomb: |tau| <= mu lambda
//! m_i v_i += w_i (lambda n + tau)                     and the body gets minus that at x_i
//! ```
//!
//! so that momentum and its moment are kept to round-off, and a uniform stress in front of the face stays uniform wherever in a cell the
//! face is. A face that lets go has no impulse where lambda would pull, or where no point touches (sum T <= 0). Weights of this kind are
//! those of an interface in the material point method (Huang et al. 2011; Nairn 2013); what is ours is their sum over a column.
//!
//! A face acts on nodes within the reach of the functions and a twentieth of a cell. Of faces of two bodies that look at each other the
//! nearer has a node, and so of faces that look the same way. Nodes that no point in front of a face reaches, which a membrane alone may
//! have, are held where they lie in the body, as by bodies without faces. Where material moves along a face integration may carry
//! a point close to it: a guard brings it back by at most 0.002 h a step, and out of a body at once. Faces that are round or askew to the
//! grid act after these: [`crate::mpm::askew`].

use crate::base::space::{Linear, Space};
use crate::bodies::body::{Body, Shape as Form, Side};
use crate::bodies::boundary::Grip;
use crate::mpm::askew;
use crate::mpm::points::Hot;
use crate::mpm::scatter::TileFrame;
use crate::mpm::scheme::ShapeFunction;
use crate::mpm::shape::{Cubic, DRIFT_MAX, Generalised, LinearHat, Quadratic, Shape};

/// Sides that faces have: the lower and the upper of each axis.
pub const SIDES: usize = 6;

/// Lines beyond an edge of a face that may belong to the column of the last line within it.
const BESIDE: i32 = 2;

/// Lengths in cells: what counts as touching, what is beside a face beyond the reach of functions, and what the guard keeps clear and moves
/// in a step.
pub const TOUCH: f64 = 0.02;
/// How far beyond the reach of functions a face acts on nodes, in cells.
pub const BEYOND: f64 = 0.05;
const CLEAR: f64 = 0.06;
const GUARD_SHARE: f64 = 0.1;
const GUARD_MAX: f64 = 0.002;
/// More than anything goes in a step, and less than a point may be beyond its tile.
const OUT_MAX: f64 = 0.05;

/// What points that touch a face and those of the row behind say.
const TOUCHES: f64 = 0.6;
const IS_NEAR: f64 = -0.4;

/// Areas below this share of their own parts are round-off.
pub const ROUND_OFF: f64 = 1e-9;

/// A body that spans the domain to within so many cells has no face there.
const SPANS: f64 = 1e-6;

/// The lattice of nodes that faces are placed in; lengths in cells from its first node, unless they say m.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Place of the first node, m, and the edge of a cell, m.
    pub corner: [f64; 3],
    /// Edge of a cell, m.
    pub cell: f64,
    /// 2 or 3.
    pub dimension: usize,
    /// Per axis; one along an axis that is not there.
    pub cells: [i32; 3],
    /// By axis; such an axis has no walls.
    pub periodic: [bool; 3],
    /// Where walls end the domain, along axes that are not periodic.
    pub extent: [[f64; 2]; 3],
    /// Of points; functions of the nodes reach as far as it says.
    pub shape: ShapeFunction,
    /// Half of a point's edge at the start.
    pub point_half: f64,
}

impl Lattice {
    /// How far functions reach.
    pub fn reach(&self) -> f64 {
        match self.shape {
            ShapeFunction::Linear => 1.0,
            ShapeFunction::Generalised => 1.0 + self.point_half,
            ShapeFunction::Quadratic => 1.5,
            ShapeFunction::Cubic => 2.0,
        }
    }

    /// How far from a face a point may be to bring anything to a node in the face's reach.
    fn felt(&self) -> f64 {
        2.0 * (self.reach() + BEYOND)
    }

    /// The whole number of periods to take from a coordinate for its image nearest to the middle between two.
    fn periods(&self, axis: usize, coordinate: f64, [lower, upper]: [f64; 2]) -> f64 {
        if !self.periodic[axis] || lower.is_infinite() || upper.is_infinite() {
            return 0.0;
        }
        ((coordinate - 0.5 * (lower + upper)) / f64::from(self.cells[axis])).round()
    }

    /// A coordinate's image there.
    fn image(&self, axis: usize, coordinate: f64, between: [f64; 2]) -> f64 {
        coordinate - f64::from(self.cells[axis]) * self.periods(axis, coordinate, between)
    }

    /// The image of a place, m, nearest to another.
    pub fn image_beside<S: Space>(&self, origin: &S::Vector, mut place: S::Vector) -> S::Vector {
        for axis in (0..self.dimension).filter(|axis| self.periodic[*axis]) {
            let length = f64::from(self.cells[axis]) * self.cell;
            place[axis] -= length * ((place[axis] - origin[axis]) / length).round();
        }
        place
    }

    /// A node within the domain.
    pub fn wrapped(&self, mut place: [i32; 3]) -> [i32; 3] {
        for axis in (0..self.dimension).filter(|axis| self.periodic[*axis]) {
            place[axis] = place[axis].rem_euclid(self.cells[axis]);
        }
        place
    }
}

/// A body as the lattice sees it: from `bounds[axis][0]` to `bounds[axis][1]`, infinite where it has no face.
#[derive(Clone, Copy, Debug)]
struct Solid {
    body: usize,
    bounds: [[f64; 2]; 3],
}

/// A face: of which body, on which side (2 axis, and one more where it is the upper of the axis), and where across that axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Its number among those of the world.
    pub body: usize,
    /// 0 to 2 d - 1 in d dimensions; odd where the normal is along the axis, even where it is against it.
    pub side: usize,
    at: f64,
    bounds: [[f64; 2]; 3],
    /// Across each other axis, the first and the last grid line that have a column of their own: those a cell or more from its edges, or
    /// one in the middle of a face that is narrower.
    lines: [[i32; 2]; 3],
}

impl Face {
    fn new(solid: &Solid, side: usize, at: f64) -> Self {
        let lines = solid.bounds.map(|[lower, upper]| {
            // Infinite bounds end in the least and the largest of integers.
            let [first, last] = [(lower + 1.0 - SPANS).ceil() as i32, (upper - 1.0 + SPANS).floor() as i32];
            if first <= last { [first, last] } else { [(0.5 * (lower + upper)).round() as i32; 2] }
        });
        Self { body: solid.body, side, at, bounds: solid.bounds, lines }
    }

    /// The axis along its normal.
    pub fn axis(&self) -> usize {
        self.side / 2
    }

    /// Unit, from the body into the material.
    pub fn normal<S: Space>(&self) -> S::Vector {
        let mut normal = S::Vector::zero();
        normal[self.axis()] = sign(self.side);
        normal
    }
}

/// Sense of the normal along its axis.
fn sign(side: usize) -> f64 {
    if side % 2 == 1 { 1.0 } else { -1.0 }
}

/// All faces at which bodies meet points now.
#[derive(Clone, Debug)]
pub struct FaceSet {
    /// Of the domain's nodes.
    pub lattice: Lattice,
    solids: Vec<Solid>,
    /// In line with the grid, body by body.
    pub faces: Vec<Face>,
    /// Bodies whose faces are round or askew to the grid ([`crate::mpm::askew`]).
    pub askew: Vec<usize>,
}

/// What points in front of faces bring to a node: for each side the area w, m2, then for each side T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brought(pub [f64; 2 * SIDES]);

impl Brought {
    /// Of a node that no point in front of a face reaches.
    pub const ZERO: Self = Self([0.0; 2 * SIDES]);

    /// w, m2.
    pub fn area(&self, side: usize) -> f64 {
        self.0[side]
    }

    /// T: above zero where points touch the face.
    pub fn touch(&self, side: usize) -> f64 {
        self.0[SIDES + side]
    }

    /// Whether there is an area on any side.
    pub fn has_area(&self) -> bool {
        self.0[..SIDES].iter().any(|area| *area != 0.0)
    }

    /// What another tile brings to the same node.
    pub fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(word, more)| *word += more);
    }
}

/// A node of a column as it is before the face acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnNode<S: Space> {
    /// m_i, kg: of all that moves with the node.
    pub mass: f64,
    /// w and T of the side under way.
    pub area: f64,
    /// T of that side.
    pub touch: f64,
    /// The velocity that is to be held, and that by which parting is judged, m/s; the same in a step.
    pub velocities: [S::Vector; 2],
}

impl<S: Space> ColumnNode<S> {
    /// A node without mass, on which no face acts.
    pub fn zero() -> Self {
        Self { mass: 0.0, area: 0.0, touch: 0.0, velocities: [S::Vector::zero(); 2] }
    }
}

/// One of its nodes by its steps from the anchor along each axis, and its place beside the body.
#[derive(Clone, Copy, Debug)]
pub struct Link<S: Space> {
    /// In nodes; zero along an axis that is not there.
    pub steps: [i32; 3],
    /// m; an image where the body is across a period.
    pub place: S::Vector,
}

impl FaceSet {
    /// Of the bodies that meet points.
    pub fn new<S: Space>(lattice: Lattice, bodies: &[Body<S>]) -> Self {
        let met = bodies.iter().enumerate().filter(|(_, body)| body.meets_points);
        let solids: Vec<Solid> = met.filter_map(|(number, body)| solid(&lattice, number, body)).collect();
        let mut faces = Vec::new();
        for solid in &solids {
            for side in 0..2 * lattice.dimension {
                let at = solid.bounds[side / 2][side % 2];
                if at.is_finite() {
                    faces.push(Face::new(solid, side, at));
                }
            }
        }
        let is_askew = |(_, body): &(usize, &Body<S>)| body.meets_points && body.is_askew();
        let askew = bodies.iter().enumerate().filter(is_askew).map(|(number, _)| number).collect();
        Self { lattice, solids, faces, askew }
    }

    /// Whether any body has faces in line with the grid.
    pub fn has_in_line(&self) -> bool {
        !self.solids.is_empty()
    }

    /// Whether points of a block may be near enough to count, the block's first node and its nodes per axis given.
    pub fn is_near<S: Space>(&self, bodies: &[Body<S>], first: [i32; 3], nodes: usize) -> bool {
        let half = 0.5 * nodes as f64;
        let is_near_askew = || {
            let mut middle = S::Vector::zero();
            for axis in 0..S::DIMENSION {
                middle[axis] = self.lattice.corner[axis] + (f64::from(first[axis]) + half) * self.lattice.cell;
            }
            let most = (half + DRIFT_MAX) * (S::DIMENSION as f64).sqrt() + askew::felt(&self.lattice);
            self.askew.iter().any(|body| {
                let nearest = askew::nearest(&self.lattice, &bodies[*body], middle);
                nearest.is_some_and(|(_, nearest)| nearest.distance.abs() < most * self.lattice.cell)
            })
        };
        let is_near_solid = self.solids.iter().any(|solid| {
            (0..self.lattice.dimension).all(|axis| {
                let bounds = solid.bounds[axis];
                let middle = self.lattice.image(axis, f64::from(first[axis]) + half, bounds);
                let most = half + DRIFT_MAX + self.lattice.felt();
                middle + most >= bounds[0] && middle - most <= bounds[1]
            })
        });
        is_near_solid || is_near_askew()
    }

    /// The sides of a body that a place is in front of, its distances, and the share of a box about it, given by its half edges, that is so
    /// too; of a place inside the body the nearest side.
    fn in_front<S: Space>(
        &self,
        solid: &Solid,
        position: &S::Vector,
        halves: [f64; 3],
    ) -> impl Iterator<Item = (usize, f64, f64)> {
        let (mut outside, mut inside) = ([None; 3], (0, f64::NEG_INFINITY));
        let mut covered = [1.0; 3];
        for axis in 0..self.lattice.dimension {
            let [lower, upper] = solid.bounds[axis];
            let coordinate = (position[axis] - self.lattice.corner[axis]) / self.lattice.cell;
            let coordinate = self.lattice.image(axis, coordinate, [lower, upper]);
            for (side, distance) in [(2 * axis, lower - coordinate), (2 * axis + 1, coordinate - upper)] {
                if distance > 0.0 {
                    outside[axis] = Some((side, distance));
                } else if distance > inside.1 {
                    inside = (side, distance);
                }
            }
            let half = halves[axis];
            let within = (coordinate + half).min(upper) - (coordinate - half).max(lower);
            covered[axis] = match half {
                0.0 => f64::from(u8::from(outside[axis].is_none())),
                half => (within / (2.0 * half)).clamp(0.0, 1.0),
            };
        }
        let is_outside = outside.iter().any(Option::is_some);
        let nearest = (!is_outside && inside.1.is_finite()).then_some((inside.0, inside.1, 1.0));
        let share =
            move |axis: usize| (0..3).filter(|other| *other != axis).map(|other| covered[other]).product::<f64>();
        let fronts = (0..3).filter_map(move |axis| outside[axis].map(|(side, distance)| (side, distance, share(axis))));
        fronts.filter(|(_, _, share)| *share > 0.0).chain(nearest)
    }

    /// The line whose column a grid line across a face belongs to, and how far it is beyond the face's edges, in cells; none where the
    /// face does not reach. Coordinates across the face alone are told.
    fn line_of(&self, face: &Face, place: [i32; 3]) -> Option<([i32; 3], f64)> {
        let (mut line, mut beyond) = ([0; 3], 0.0f64);
        for axis in (0..self.lattice.dimension).filter(|axis| *axis != face.axis()) {
            let [lower, upper] = face.bounds[axis];
            let at = self.lattice.image(axis, f64::from(place[axis]), [lower, upper]);
            let excess = (lower - at).max(at - upper);
            let [first, last] = face.lines[axis];
            line[axis] = (at.round() as i32).clamp(first, last);
            if excess > self.lattice.reach() || (at.round() as i32).abs_diff(line[axis]) > BESIDE as u32 {
                return None;
            }
            beyond = beyond.max(excess);
        }
        Some((line, beyond))
    }

    /// How far a node is from a face along its normal, in cells; none out of its reach.
    fn offset(&self, face: &Face, place: [i32; 3]) -> Option<f64> {
        let axis = face.axis();
        let (at, length) = (f64::from(place[axis]), f64::from(self.lattice.cells[axis]));
        let periods = if self.lattice.periodic[axis] { ((at - face.at) / length).round() } else { 0.0 };
        Some(at - length * periods - face.at).filter(|offset| offset.abs() < self.lattice.reach() + BEYOND)
    }

    /// The face on a side that has a node of the domain, by its number, and the line whose column that is.
    pub fn face_at(&self, place: [i32; 3], side: usize) -> Option<usize> {
        self.face_and_line(place, side).map(|(number, _)| number)
    }

    fn face_and_line(&self, place: [i32; 3], side: usize) -> Option<(usize, [i32; 3])> {
        let mut nearest: Option<([f64; 2], usize, [i32; 3])> = None;
        for (number, face) in self.faces.iter().enumerate().filter(|(_, face)| face.side == side) {
            let Some(offset) = self.offset(face, place) else { continue };
            let Some((line, beyond)) = self.line_of(face, place) else { continue };
            let far = [beyond, offset.abs()];
            if nearest.is_none_or(|(other, _, _)| far < other) {
                nearest = Some((far, number, line));
            }
        }
        let ([_, distance], number, line) = nearest?;
        let this = &self.faces[number];
        let opposite = self.faces.iter().filter(|face| face.side == side ^ 1 && face.body != this.body);
        for other in opposite {
            // Faces back to back have nothing between them.
            let between = sign(side) * (self.lattice.image(other.axis(), other.at, [this.at; 2]) - this.at);
            let Some(offset) = self.offset(other, place).filter(|_| self.line_of(other, place).is_some()) else {
                continue;
            };
            if between >= 0.0 && offset.abs() < distance {
                return None;
            }
        }
        Some((number, line))
    }

    /// Steps from the anchor of a column to its lowest node at most: with what lies above it is within a tile.
    fn below(&self) -> i32 {
        if self.lattice.shape == ShapeFunction::Cubic { 2 } else { 1 }
    }

    /// The line of a face whose column has its anchor on a grid line across the face, if any has: the line itself, but for the first one
    /// within an edge, of which those beyond must be within a tile too.
    fn line_of_anchor(&self, face: &Face, anchor: [i32; 3]) -> Option<[i32; 3]> {
        let mut line = [0; 3];
        for axis in (0..self.lattice.dimension).filter(|axis| *axis != face.axis()) {
            let at = self.lattice.image(axis, f64::from(anchor[axis]), face.bounds[axis]).round() as i32;
            let [first, last] = face.lines[axis];
            let has_before = self.lattice.periodic[axis] || f64::from(first - 1) >= self.lattice.extent[axis][0];
            let shifts = face.bounds[axis][0].is_finite() && has_before;
            line[axis] = if shifts && at <= first { at + 1 } else { at };
            if !(first..=last).contains(&line[axis]) {
                return None;
            }
        }
        Some(line)
    }

    /// The nodes of the column of a face that has its anchor at a node of the domain; none where there is no such column. Every column of a
    /// face has exactly one anchor.
    pub fn column<S: Space>(&self, number: usize, anchor: [i32; 3], nodes: &mut Vec<Link<S>>) {
        let (face, below, axis) = (self.faces[number], self.below(), self.faces[number].axis());
        let reach = self.lattice.reach() + BEYOND;
        let first = (face.at + f64::from(below + 1) - reach).floor() as i32;
        let mut along = anchor;
        along[axis] = first;
        if self.lattice.wrapped(along) != anchor {
            return;
        }
        let Some(mut line) = self.line_of_anchor(&face, anchor) else { return };
        let at_edge = |of: usize| (0..2).any(|end| face.bounds[of][end].is_finite() && line[of] == face.lines[of][end]);
        let steps = |of: usize| if of == axis || at_edge(of) { -below..below + 2 } else { 0..1 };
        let steps: [_; 3] = std::array::from_fn(steps);
        // Places of a line are those beside the face.
        line[axis] = first;
        let beside = |of: usize| match of {
            of if of == axis => first,
            of => self.lattice.image(of, f64::from(anchor[of]), face.bounds[of]).round() as i32,
        };
        let origin: [i32; 3] = std::array::from_fn(|of| if of < S::DIMENSION { beside(of) } else { 0 });
        for k in steps[2].clone() {
            for j in steps[1].clone() {
                for i in steps[0].clone() {
                    let steps = [i, j, k];
                    let place: [i32; 3] = std::array::from_fn(|of| origin[of] + steps[of]);
                    if (f64::from(place[axis]) - face.at).abs() >= reach {
                        continue;
                    }
                    let Some((has, mut of_line)) = self.face_and_line(self.lattice.wrapped(place), face.side) else {
                        continue;
                    };
                    of_line[axis] = first;
                    if has == number && of_line == line {
                        let mut lies = S::Vector::zero();
                        for along in 0..S::DIMENSION {
                            lies[along] = self.lattice.corner[along] + f64::from(place[along]) * self.lattice.cell;
                        }
                        nodes.push(Link { steps, place: lies });
                    }
                }
            }
        }
    }

    /// Where a node of a face is beside its body, m.
    pub fn place_beside<S: Space>(&self, number: usize, place: [i32; 3]) -> S::Vector {
        let (face, mut lies) = (&self.faces[number], S::Vector::zero());
        for along in 0..S::DIMENSION {
            let bounds = if along == face.axis() { [face.at; 2] } else { face.bounds[along] };
            let coordinate = self.lattice.image(along, f64::from(place[along]), bounds);
            lies[along] = self.lattice.corner[along] + coordinate * self.lattice.cell;
        }
        lies
    }

    /// What the points of a block bring to its tile for the faces that they are in front of; the tile has been cleared.
    pub fn scatter<S: Space>(&self, frame: &TileFrame<S>, points: &[Hot<S>], tile: &mut [Brought]) {
        for point in points {
            let sides = self.sides_of(point);
            if sides.iter().all(Option::is_none) {
                continue;
            }
            match self.lattice.shape {
                ShapeFunction::Linear => bring::<S, LinearHat, 3>(frame, point, &sides, tile),
                ShapeFunction::Generalised => bring::<S, Generalised, 3>(frame, point, &sides, tile),
                ShapeFunction::Quadratic => bring::<S, Quadratic, 3>(frame, point, &sides, tile),
                ShapeFunction::Cubic => bring::<S, Cubic, 4>(frame, point, &sides, tile),
            }
        }
    }

    /// Whether a place is farther than that from a body along an axis, or as deep within it.
    fn is_far<S: Space>(&self, solid: &Solid, position: &S::Vector, felt: f64) -> bool {
        let mut deepest = f64::NEG_INFINITY;
        for axis in 0..S::DIMENSION {
            let [lower, upper] = solid.bounds[axis];
            let coordinate = (position[axis] - self.lattice.corner[axis]) / self.lattice.cell;
            let coordinate = self.lattice.image(axis, coordinate, [lower, upper]);
            deepest = deepest.max((lower - coordinate).max(coordinate - upper));
        }
        deepest.abs() > felt
    }

    /// For each side that a point is in front of and near to, the share of its box that is so, and t.
    fn sides_of<S: Space>(&self, point: &Hot<S>) -> [Option<[f64; 2]>; SIDES] {
        let mut sides: [Option<[f64; 2]>; SIDES] = [None; SIDES];
        let felt = self.lattice.felt();
        if self.solids.iter().all(|solid| self.is_far::<S>(solid, &point.position, felt)) {
            return sides;
        }
        let mut halves = [0.0; 3];
        for (axis, half) in halves.iter_mut().enumerate().take(S::DIMENSION) {
            let stretch = |along: usize| point.deformation[along * S::DIMENSION + axis].abs();
            *half = self.lattice.point_half * (0..S::DIMENSION).map(stretch).sum::<f64>();
        }
        for solid in &self.solids {
            for (side, distance, share) in self.in_front::<S>(solid, &point.position, halves) {
                if distance.abs() > felt {
                    continue;
                }
                let half = halves[side / 2];
                let touch = match distance {
                    distance if distance - half < TOUCH => TOUCHES,
                    distance if distance < 2.0 * half => IS_NEAR,
                    _ => 0.0,
                };
                sides[side] = Some(match sides[side] {
                    None => [share, touch],
                    // Bodies side by side share a point; of bodies behind each other the nearer says whether it touches.
                    Some([other, told]) => {
                        let touch = if told == TOUCHES || (told == IS_NEAR && touch == 0.0) { told } else { touch };
                        [(other + share).min(1.0), touch]
                    }
                });
            }
        }
        sides
    }

    /// Moves a point or a vertex that has come too near to a face a little away from where that will be after a time `dt`, and one that
    /// the face would have passed by then to where it will be.
    pub fn guard<S: Space>(&self, bodies: &[Body<S>], dt: f64, position: &mut S::Vector) {
        for solid in &self.solids {
            let front = self.in_front::<S>(solid, position, [0.0; 3]).next();
            let Some((side, distance, _)) = front else { continue };
            let approach = sign(side) * bodies[solid.body].velocity[side / 2] * dt / self.lattice.cell;
            let gap = distance - approach;
            if gap < CLEAR {
                position[side / 2] += sign(side) * (way_back(gap) * self.lattice.cell);
            }
        }
        for body in &self.askew {
            let Some((_, nearest)) = askew::nearest(&self.lattice, &bodies[*body], *position) else { continue };
            let approach = bodies[*body].velocity.dot(&nearest.normal) * dt;
            let gap = (nearest.distance - approach) / self.lattice.cell;
            if gap < CLEAR {
                *position += nearest.normal * (way_back(gap) * self.lattice.cell);
            }
        }
    }
}

/// How far the guard moves a point that will be within a gap of a face, or as far behind it; in cells.
fn way_back(gap: f64) -> f64 {
    (GUARD_SHARE * (CLEAR - gap)).min(GUARD_MAX).max((-gap).min(OUT_MAX))
}

/// A body within the lattice; none of one without faces in line with it.
fn solid<S: Space>(lattice: &Lattice, body: usize, of: &Body<S>) -> Option<Solid> {
    let mut bounds = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
    let in_cells = |axis: usize, place: f64| (place + of.displacement[axis] - lattice.corner[axis]) / lattice.cell;
    match of.shape {
        Form::Box { lower, upper } => {
            for axis in 0..S::DIMENSION {
                let [from, to] = [in_cells(axis, lower[axis]), in_cells(axis, upper[axis])];
                if lattice.periodic[axis] {
                    if to - from < f64::from(lattice.cells[axis]) - SPANS {
                        bounds[axis] = [from, to];
                    }
                    continue;
                }
                let [first, last] = lattice.extent[axis];
                if from > first + SPANS {
                    bounds[axis][0] = from;
                }
                if to < last - SPANS {
                    bounds[axis][1] = to;
                }
            }
        }
        Form::Plane { point, normal } => {
            let axis = (0..S::DIMENSION).find(|axis| normal[*axis].abs() == 1.0)?;
            bounds[axis][usize::from(normal[axis] > 0.0)] = in_cells(axis, point[axis]);
        }
        Form::Plate { side, face } => bounds[1][usize::from(side == Side::Below)] = in_cells(1, face),
        Form::Layer | Form::Cylinder { .. } => return None,
    }
    Some(Solid { body, bounds })
}

/// What a point brings to every node in reach.
fn bring<S: Space, F: Shape<N>, const N: usize>(
    frame: &TileFrame<S>,
    point: &Hot<S>,
    sides: &[Option<[f64; 2]>; SIDES],
    tile: &mut [Brought],
) {
    let stencil = frame.stencil::<F, N>(&point.position);
    let volume = point.weight * point.volume * point.volume_ratio();
    // Of each side that it is in front of.
    let (mut fronts, mut count) = ([(0, 0.0, 0.0); SIDES], 0);
    for (side, front) in sides.iter().enumerate() {
        if let Some([share, touch]) = front {
            fronts[count] = (side, sign(side) * (share * volume), share * touch);
            count += 1;
        }
    }
    stencil.for_each_gradient(frame.edge, |node, value, gradient| {
        let node = &mut tile[node].0;
        for (side, area, touch) in &fronts[..count] {
            node[*side] -= area * gradient[side / 2];
            node[SIDES + side] += touch * value;
        }
    });
}

/// Sums over a column.
#[derive(Clone, Copy, Debug)]
pub struct ColumnSums<S: Space> {
    /// `sum w (v - V)` of the velocities to be held and of those by which parting is judged, m3/s.
    slips: [S::Vector; 2],
    /// K, m4/kg.
    softness: f64,
    /// A, m2.
    area: f64,
    touch: f64,
    /// Sum of sizes, of which A is what is left.
    size: f64,
}

impl<S: Space> ColumnSums<S> {
    /// Of nodes with the body's velocity at each.
    pub fn of(nodes: impl Iterator<Item = (ColumnNode<S>, S::Vector)>) -> Self {
        let mut sums = Self { slips: [S::Vector::zero(); 2], softness: 0.0, area: 0.0, touch: 0.0, size: 0.0 };
        for (node, velocity) in nodes {
            for (slip, own) in sums.slips.iter_mut().zip(&node.velocities) {
                *slip += (*own - velocity) * node.area;
            }
            sums.softness += node.area * node.area / node.mass;
            sums.area += node.area;
            sums.touch += node.touch;
            sums.size += node.area.abs();
        }
        sums
    }

    /// Whether there is anything for the face to act on.
    pub fn is_met(&self, normal: &S::Vector, separates: bool) -> bool {
        let parts = self.slips[1].dot(normal) > 0.0 || self.touch <= 0.0 || self.area <= ROUND_OFF * self.size;
        self.softness > 0.0 && !(separates && parts)
    }

    /// `lambda n + tau`, impulse per area (N s/m2), for each of the two velocities.
    pub fn pressures(&self, normal: &S::Vector, grip: Grip) -> [S::Vector; 2] {
        self.slips.map(|slip| {
            let opening = slip.dot(normal);
            let along = slip - *normal * opening;
            let stops = -1.0 / self.softness;
            let rubs = match grip {
                Grip::Rough => 1.0,
                Grip::Smooth => 0.0,
                Grip::Coulomb(friction) => {
                    let (speed, most) = (along.norm(), friction * (-opening).max(0.0));
                    if speed > most { most / speed } else { 1.0 }
                }
            };
            (*normal * opening + along * rubs) * stops
        })
    }

    /// Momentum (N s) and mass (kg) that a servo along `direction` moves with the body: of all of a rough column, else what its normal has
    /// along the servo; the slips are of velocities alone.
    pub fn carried(&self, normal: &S::Vector, grip: Grip, direction: &S::Vector) -> (S::Vector, f64) {
        let (momentum, mass) = (self.slips[0] * (self.area / self.softness), self.area * self.area / self.softness);
        match grip {
            Grip::Rough => (momentum, mass),
            Grip::Smooth | Grip::Coulomb(_) => {
                let along = normal.dot(direction);
                (*direction * (momentum.dot(normal) * along), mass * along * along)
            }
        }
    }
}
