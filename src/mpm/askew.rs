//! Bodies whose faces are round or askew to the grid meet material points there: cylinders and planes of any normal.
//!
//! It is the form of [`crate::mpm::faces`] with a normal n_i and a distance d_i of each node. Points near such a body bring to every node in
//! reach
//!
//! ```text
//! G_i = sum_p w_p J_p V_p grad N_i(x_p),   S_i = sum_p w_p V_p N_i tau_p,   Vol_i = sum_p w_p J_p V_p N_i,   T_i
//! w_i = -n_i . G_i                                    over the face of a cell
//! ```
//!
//! and a face acts on nodes with `|d_i| < R sum_a |n_a| + h/20`, R being the reach of functions along an axis. Its columns are lines of the
//! grid along every axis a; a node belongs to one of each, by shares that are smooth in its normal,
//!
//! ```text
//! psi_a = s(n_a^2)/sum_b s(n_b^2),   s(x) = x^2 (3 - 2 x)
//! c = sum psi w n.(v_i - V),   u = sum psi w t.(v_i - V),   K = sum psi w^2/m_i,   A = sum psi w
//! m_i v_i += w_i sum_a psi_a (lambda n_i + tau t_i)   lambda = -c/K, tau = -u/K
//! ```
//!
//! twice over, as columns that cross know of each other by the second time alone; what a column has in all neither pulls nor leaves the cone
//! of friction where the body lets go. Points in rows askew to a face have a ragged outline: G_i is not along n_i node by node, and stress
//! along the face pushes nodes to and fro, which a straight face would not let it. The face takes that up,
//!
//! ```text
//! m_i v_i += phi P sigma_i P G_i dt,   sigma_i = S_i/Vol_i,   P = I - n n
//! ```
//!
//! with phi from 0 to 1 as a column's area goes from 0.7 to 0.8 of the exact one (the integral of the nodes' functions over what no other
//! body covers of the face), for ends of the material are no outline of a face; nodes of two faces that are not parallel, and those on
//! walls, have none
//! of it. On a wall, where the material ends as well, w is told by the other axes, `-sum n_a G_a/sum n_a^2`.
//!
//! A column parts where lambda would pull, or where its points do not touch,
//!
//! ```text
//! sum T_i <= 0,   T_i = sum_p N_i(x_p) t_p            t = 1 where d_p - r_p < 0.02 h, else -1/6 where d_p < 2 r_p
//! ```
//!
//! that is, where of the points in the row beside the face, weighted by the column's functions, no more than one in seven touches it. A row
//! along the face touches as a whole or not at all; one askew to it is ragged, its points at any distance up to 2 r_p, and a majority, as
//! faces in line with the grid ask for, would let go of columns that bear. Ragged rows are felt early, by less than half of a point's box.
//!
//! Columns are as long as they are: their sums are exact in fixed point over all ranks ([`crate::domain::step::askew`]). In the plane alone.

use std::ops::Range;

use crate::base::math;
use crate::base::space::{Linear, Space};
use crate::bodies::body::{Body, Nearest, Shape as Form};
use crate::bodies::boundary::Grip;
use crate::mpm::faces::{BEYOND, FaceSet, Lattice, ROUND_OFF, TOUCH};
use crate::mpm::points::Hot;
use crate::mpm::scatter::TileFrame;
use crate::mpm::scheme::ShapeFunction;
use crate::mpm::shape::{Cubic, Generalised, LinearHat, Quadratic, Shape};

/// Times that columns act one on the other.
pub const SWEEPS: usize = 2;

/// Of a column's exact area, what makes it an end of the material, and what a face.
const FULL: [f64; 2] = [0.7, 0.8];

/// What points that touch a face and others of the row beside it say: of such a row more than one in seven touches.
const TOUCHES: f64 = 1.0;
const IS_NEAR: f64 = -1.0 / 6.0;

/// Squared sine of the angle from which faces are not parallel.
const PARALLEL: f64 = 0.09;
/// Cosine of the angle from which faces look at each other.
const OPPOSITE: f64 = -0.3;
/// Share of a normal's square that must be left on a wall for an area to be told.
const TOLD: f64 = 0.1;

/// Places at which functions are taken along a face.
const PLACES: usize = 14;

/// What points bring to a node, in this order: G (m2), T, Vol (m3), S by its lower triangle, row by row (N m).
const GRADIENT: usize = 0;
const TOUCHED: usize = 3;
const VOLUME: usize = 4;
const LOAD: usize = 5;

/// What points near askew faces bring to a node: G (m2), T, Vol (m3), and of S the lower triangle, row by row (N m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline(pub [f64; LOAD + 6]);

impl Outline {
    /// Of a node that no point near an askew face reaches.
    pub const ZERO: Self = Self([0.0; LOAD + 6]);

    /// What another tile brings to the same node.
    pub fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(word, more)| *word += more);
    }

    /// Whether points near a face are in reach.
    pub fn is_reached(&self) -> bool {
        self.0[VOLUME] > 0.0
    }

    fn gradient<S: Space>(&self) -> S::Vector {
        let mut gradient = S::Vector::zero();
        for axis in 0..S::DIMENSION {
            gradient[axis] = self.0[GRADIENT + axis];
        }
        gradient
    }

    /// `P sigma P G`, N.
    fn balance<S: Space>(&self, normal: &S::Vector) -> S::Vector {
        let project = |vector: S::Vector| vector - *normal * normal.dot(&vector);
        let (along, mut pushed) = (project(self.gradient::<S>()), S::Vector::zero());
        for i in 0..S::DIMENSION {
            for j in 0..S::DIMENSION {
                let (most, least) = (i.max(j), i.min(j));
                pushed[i] += self.0[LOAD + most * (most + 1) / 2 + least] * along[j];
            }
        }
        project(pushed * (1.0 / self.0[VOLUME]))
    }
}

/// A node that a face acts on.
#[derive(Clone, Copy, Debug)]
pub struct Reached<S: Space> {
    /// Its number among the owned ones.
    pub number: usize,
    /// Beside the body, m.
    pub place: S::Vector,
    /// n_i, unit, from the body into the material.
    pub normal: S::Vector,
    /// w, as T is; and the exact one.
    area: f64,
    touch: f64,
    exact: f64,
    /// `P sigma P G`, N.
    balance: S::Vector,
    /// Along every axis the column that it belongs to, and its share; columns without a share are not there.
    pub columns: [(usize, f64); 3],
    /// What the body gave it in the last step, N s.
    pub impulse: S::Vector,
}

/// Numbers of a column's sums: c, of the velocities to be held and of those by which parting is judged, K, A, sum of sizes, T, the exact
/// area, then the balance, and u of both.
const PARTS: usize = 7;

/// Components of a vector along a face: one in the plane, along `(-n_y, n_x)`; in space a vector of space.
fn components<S: Space>() -> usize {
    if S::DIMENSION == 2 { 1 } else { 3 }
}

fn along<S: Space>(normal: &S::Vector, vector: &S::Vector) -> [f64; 3] {
    if S::DIMENSION == 2 {
        return [normal[0] * vector[1] - normal[1] * vector[0], 0.0, 0.0];
    }
    let along = *vector - *normal * normal.dot(vector);
    [along[0], along[1], along[2]]
}

fn embedded<S: Space>(normal: &S::Vector, words: &[f64; 3]) -> S::Vector {
    let mut vector = S::Vector::zero();
    if S::DIMENSION == 2 {
        vector[0] = -normal[1] * words[0];
        vector[1] = normal[0] * words[0];
        return vector;
    }
    (0..S::DIMENSION).for_each(|axis| vector[axis] = words[axis]);
    vector - *normal * normal.dot(&vector)
}

impl<S: Space> Reached<S> {
    /// Numbers that a column sums.
    pub fn parts() -> usize {
        PARTS + 3 * components::<S>()
    }

    /// Its parts of every column's sums, before shares: `velocities` of the node, `body` that of the body there, m/s; forces have acted for a
    /// time `dt`, zero where the outline has been balanced. K is shown over that of the heaviest node, kg: sums have a range.
    pub fn shown(
        &self,
        velocities: &[S::Vector; 2],
        body: &S::Vector,
        [mass, heaviest]: [f64; 2],
        dt: f64,
    ) -> [f64; PARTS + 9] {
        let mut words = [0.0; PARTS + 9];
        let count = components::<S>();
        for (which, velocity) in velocities.iter().enumerate() {
            let slip = *velocity - *body;
            words[which] = self.area * slip.dot(&self.normal);
            let tangential = along::<S>(&self.normal, &slip);
            for component in 0..count {
                words[PARTS + (1 + which) * count + component] = self.area * tangential[component];
            }
        }
        words[2] = self.area * self.area * (heaviest / mass);
        (words[3], words[4], words[5], words[6]) = (self.area, self.area.abs(), self.touch, self.exact);
        let balance = along::<S>(&self.normal, &self.balance);
        for component in 0..count {
            words[PARTS + component] = self.area * balance[component] * (dt / mass);
        }
        words
    }

    /// What its columns give it in a sweep, for the velocity to be held and for that by which parting is judged, N s.
    pub fn taken(&self, columns: &[Column], dt: f64) -> [S::Vector; 2] {
        let shares =
            || self.columns.iter().filter(|(_, share)| *share > 0.0).map(|(at, share)| (&columns[*at], *share));
        let full: f64 = shares().map(|(column, share)| share * column.full).sum();
        std::array::from_fn(|which| {
            let (mut pressure, mut tangential) = (0.0, [0.0; 3]);
            for (column, share) in shares() {
                pressure += share * column.pressure_change[which];
                tangential
                    .iter_mut()
                    .zip(&column.tangential_change[which])
                    .for_each(|(sum, more)| *sum += share * more);
            }
            (self.normal * pressure + embedded::<S>(&self.normal, &tangential)) * self.area + self.balance * (full * dt)
        })
    }
}

/// What a column gives its nodes, per w: in all, and in the sweep under way, N s; of the velocity to be held and of that by which parting is
/// judged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Column {
    pressure: [f64; 2],
    tangential: [[f64; 3]; 2],
    pressure_change: [f64; 2],
    tangential_change: [[f64; 3]; 2],
    /// phi; none after the first sweep.
    full: f64,
}

impl Column {
    /// One more sweep with a column's sums; `balances` where the outline is to be balanced.
    pub fn sweep<S: Space>(
        &mut self,
        sums: impl Fn(usize) -> f64,
        heaviest: f64,
        (grip, separates): (Grip, bool),
        balances: bool,
    ) {
        let (before, count) = (*self, components::<S>());
        let inverse_mass = sums(2) / heaviest;
        (self.full, self.pressure_change, self.tangential_change) = (0.0, [0.0; 2], [[0.0; 3]; 2]);
        if inverse_mass <= 0.0 || inverse_mass.is_nan() {
            return;
        }
        let asked = |which: usize| before.pressure[which] - sums(which) / inverse_mass;
        let is_void = sums(5) <= 0.0 || sums(3) <= ROUND_OFF * sums(4);
        let separates_now = separates && (is_void || asked(1) <= 0.0);
        if balances && !separates_now {
            let share = sums(3) / sums(6).max(ROUND_OFF);
            self.full = ((share - FULL[0]) / (FULL[1] - FULL[0])).clamp(0.0, 1.0);
        }
        for which in 0..2 {
            self.pressure[which] = if separates_now { 0.0 } else { asked(which) };
            let mut tangential = [0.0; 3];
            for (component, tangential) in tangential.iter_mut().enumerate().take(count) {
                let slip = sums(PARTS + (1 + which) * count + component) + self.full * sums(PARTS + component);
                *tangential = before.tangential[which][component] - slip / inverse_mass;
            }
            let size = tangential.iter().map(|tangential| tangential * tangential).sum::<f64>().sqrt();
            let kept = match grip {
                _ if separates_now => 0.0,
                Grip::Smooth => 0.0,
                Grip::Rough => 1.0,
                Grip::Coulomb(friction) => {
                    let most = friction * self.pressure[which].max(0.0);
                    if size > most { most / size } else { 1.0 }
                }
            };
            self.tangential[which] = tangential.map(|tangential| kept * tangential);
            self.pressure_change[which] = self.pressure[which] - before.pressure[which];
            self.tangential_change[which] =
                std::array::from_fn(|at| self.tangential[which][at] - before.tangential[which][at]);
        }
    }
}

/// How far from a face points may be to bring anything, in cells: nodes in its reach see all that reaches them.
pub fn felt(lattice: &Lattice) -> f64 {
    2.0 * lattice.reach() * (lattice.dimension as f64).sqrt() + 2.0 * BEYOND
}

/// The image of a place beside a body, and the nearest point of its surface; none of bodies without one.
pub fn nearest<S: Space>(lattice: &Lattice, body: &Body<S>, place: S::Vector) -> Option<(S::Vector, Nearest<S>)> {
    let beside = if body.is_bounded() { lattice.image_beside::<S>(&body.origin(), place) } else { place };
    Some((beside, body.nearest(&beside)?))
}

/// Rows and columns of askew faces. Empty where there are none.
#[derive(Clone, Debug)]
pub struct AskewRows<S: Space> {
    /// By tile row, and of owned nodes.
    pub brought: Vec<Outline>,
    /// Of owned nodes, over all tiles.
    pub sums: Vec<Outline>,
    /// Nodes that points near such faces reach, with their places; room that is kept.
    owned: Vec<(usize, [i32; 3], S::Vector)>,
    /// Nodes in reach, body by body in the order of [`FaceSet::askew`], and which those of each are; in the order of their numbers.
    pub reached: Vec<Reached<S>>,
    /// By body, rows of [`Self::reached`].
    pub ranges: Vec<Range<usize>>,
    /// By line of the grid whether any rank has nodes of it in reach, and then the number of its column.
    pub lines: Vec<i64>,
    /// Columns of all bodies, and which those of each are.
    pub columns: Vec<Column>,
    /// By body, rows of [`Self::columns`].
    pub column_ranges: Vec<Range<usize>>,
    /// Mass of the heaviest node in reach of any body, kg; the same on every rank.
    pub heaviest: f64,
}

impl<S: Space> Default for AskewRows<S> {
    fn default() -> Self {
        Self {
            brought: Vec::new(),
            sums: Vec::new(),
            owned: Vec::new(),
            reached: Vec::new(),
            ranges: Vec::new(),
            lines: Vec::new(),
            columns: Vec::new(),
            column_ranges: Vec::new(),
            heaviest: 0.0,
        }
    }
}

impl<S: Space> AskewRows<S> {
    /// Looks which nodes faces reach: `owned` with their places, m and in the lattice; `unit` is the face of a cell, m2. Columns are lines still.
    pub fn reach(
        &mut self,
        set: &FaceSet,
        bodies: &[Body<S>],
        unit: f64,
        owned: impl Iterator<Item = (usize, [i32; 3], S::Vector)>,
    ) {
        self.owned.clear();
        self.owned.extend(owned.filter(|(number, ..)| self.sums[*number].is_reached()));
        self.reached.clear();
        self.ranges.clear();
        self.lines.clear();
        self.lines.resize(set.askew.len() * lines_of_body(&set.lattice), 0);
        for (order, body) in set.askew.iter().enumerate() {
            let first = self.reached.len();
            for node in &self.owned {
                let outline = &self.sums[node.0];
                if let Some(reached) = reached(set, bodies, (order, *body), *node, outline, unit) {
                    for (line, share) in reached.columns {
                        self.lines[line] |= i64::from(share > 0.0);
                    }
                    self.reached.push(reached);
                }
            }
            self.ranges.push(first..self.reached.len());
        }
    }

    /// Numbers the columns of lines that have nodes on any rank.
    pub fn number_columns(&mut self) {
        let mut count = 0;
        self.column_ranges.clear();
        let of_body = (self.lines.len() / self.ranges.len().max(1)).max(1);
        for lines in self.lines.chunks_mut(of_body) {
            let first = count as usize;
            for line in lines {
                let is_used = *line > 0;
                *line = count;
                count += i64::from(is_used);
            }
            self.column_ranges.push(first..count as usize);
        }
        for reached in &mut self.reached {
            for (column, share) in &mut reached.columns {
                *column = if *share > 0.0 { self.lines[*column] as usize } else { 0 };
            }
        }
        self.columns.clear();
        self.columns.resize(count as usize, Column::default());
    }

    /// Nothing has acted in the step under way.
    pub fn begin(&mut self) {
        self.columns.fill(Column::default());
        self.reached.iter_mut().for_each(|reached| reached.impulse = S::Vector::zero());
    }

    /// What askew bodies gave a node in the last step, with each one's place in [`FaceSet::askew`].
    pub fn given_to(&self, number: usize) -> impl Iterator<Item = (usize, &Reached<S>)> {
        self.ranges.iter().enumerate().filter_map(move |(order, range)| {
            let of_body = &self.reached[range.clone()];
            let at = of_body.partition_point(|reached| reached.number < number);
            of_body.get(at).filter(|reached| reached.number == number).map(|reached| (order, reached))
        })
    }
}

/// Lines along an axis at most, and all of a body: along every axis, of faces that look up and down.
fn lines_along(lattice: &Lattice) -> usize {
    let nodes = lattice.cells.iter().take(lattice.dimension).map(|cells| *cells as usize + 1);
    nodes.clone().product::<usize>() / nodes.min().unwrap_or(1)
}

fn lines_of_body(lattice: &Lattice) -> usize {
    2 * lattice.dimension * lines_along(lattice)
}

/// A node in the reach of a body's face; none out of it, or where another body's face that looks at this one is nearer.
fn reached<S: Space>(
    set: &FaceSet,
    bodies: &[Body<S>],
    (order, body): (usize, usize),
    (number, at, place): (usize, [i32; 3], S::Vector),
    outline: &Outline,
    unit: f64,
) -> Option<Reached<S>> {
    let lattice = &set.lattice;
    let is_in_reach = |nearest: &Nearest<S>| {
        let slant: f64 = (0..S::DIMENSION).map(|axis| nearest.normal[axis].abs()).sum();
        nearest.distance.abs() < (lattice.reach() * slant + BEYOND) * lattice.cell
    };
    let (beside, nearest_here) = nearest(lattice, &bodies[body], place).filter(|(_, nearest)| is_in_reach(nearest))?;
    let normal = nearest_here.normal;
    let others = || bodies.iter().enumerate().filter(|(other, rigid)| *other != body && rigid.meets_points);
    let mut is_alone = true;
    for (_, other) in others() {
        let Some((_, nearest)) = nearest(lattice, other, place) else { continue };
        let cosine = nearest.normal.dot(&normal);
        if cosine < OPPOSITE && nearest.distance.abs() < nearest_here.distance.abs() {
            return None;
        }
        is_alone &= !is_in_reach(&nearest) || 1.0 - cosine * cosine <= PARALLEL;
    }
    let is_on_wall = |axis: usize| {
        let [lower, upper] = lattice.extent[axis];
        !lattice.periodic[axis] && (f64::from(at[axis]) <= lower || f64::from(at[axis]) >= upper)
    };
    let gradient = outline.gradient::<S>();
    let (mut along, mut told) = (0.0, 0.0);
    for axis in (0..S::DIMENSION).filter(|axis| !is_on_wall(*axis)) {
        along += normal[axis] * gradient[axis];
        told += normal[axis] * normal[axis];
    }
    let is_walled = (0..S::DIMENSION).any(is_on_wall);
    let area = match (is_walled, told) {
        (false, _) => -along / unit,
        (true, told) if told > TOLD => -along / (unit * told),
        _ => 0.0,
    };
    let smooth = |axis: usize| {
        let square = normal[axis] * normal[axis];
        square * square * (3.0 - 2.0 * square)
    };
    let all: f64 = (0..S::DIMENSION).map(smooth).sum();
    let columns = std::array::from_fn(|axis| {
        if axis >= S::DIMENSION {
            return (0, 0.0);
        }
        let side = 2 * axis + usize::from(normal[axis] > 0.0);
        let line = (order * 2 * S::DIMENSION + side) * lines_along(lattice) + line_of(lattice, axis, at);
        (line, smooth(axis) / all)
    });
    Some(Reached {
        number,
        place: beside,
        normal,
        area,
        touch: outline.0[TOUCHED],
        exact: exact::<S>(lattice, &bodies[body], &beside, &nearest_here, others().map(|(_, other)| other)),
        balance: if is_alone && !is_walled { outline.balance::<S>(&normal) } else { S::Vector::zero() },
        columns,
        impulse: S::Vector::zero(),
    })
}

/// Which of the lines along an axis a node lies on.
fn line_of(lattice: &Lattice, axis: usize, at: [i32; 3]) -> usize {
    let others = (0..lattice.dimension).filter(|other| *other != axis);
    others.fold(0, |line, other| {
        let nodes = lattice.cells[other] + 1;
        line * nodes as usize + at[other].rem_euclid(nodes) as usize
    })
}

/// The exact w of a node: the integral of its function over the face, in the plane, as far as that is not inside of another body.
fn exact<'a, S: Space>(
    lattice: &Lattice,
    body: &Body<S>,
    place: &S::Vector,
    nearest_here: &Nearest<S>,
    others: impl Iterator<Item = &'a Body<S>> + Clone,
) -> f64 {
    if S::DIMENSION != 2 {
        // Not known: no area is full.
        return f64::INFINITY;
    }
    let normal = nearest_here.normal;
    let [n, t] = [[normal[0], normal[1]], [-normal[1], normal[0]]];
    let (span, cell) = (lattice.reach() * std::f64::consts::SQRT_2 + 2.0 * BEYOND, lattice.cell);
    let origin = body.origin();
    let arm = [0, 1].map(|axis| (place[axis] - origin[axis]) / cell);
    let step = 2.0 / PLACES as f64;
    let mut sum = 0.0;
    let radius = match body.shape {
        Form::Cylinder { radius, .. } => Some(radius / cell),
        _ => None,
    };
    let half = radius.map_or(span, |radius| (span / radius).min(std::f64::consts::PI));
    // Of a face about each of its places, in cells.
    let width = half * step * radius.unwrap_or(1.0);
    for number in 0..PLACES {
        let way = half * ((number as f64 + 0.5) * step - 1.0);
        let from_node = match radius {
            Some(radius) => {
                let (sine, cosine) = (math::sin(way), math::cos(way));
                [0, 1].map(|axis| radius * (n[axis] * cosine + t[axis] * sine) - arm[axis])
            }
            None => [0, 1].map(|axis| t[axis] * way - n[axis] * nearest_here.distance / cell),
        };
        let value = value(lattice, from_node[0]) * value(lattice, from_node[1]);
        if value == 0.0 {
            continue;
        }
        let mut on_face = *place;
        (0..2).for_each(|axis| on_face[axis] += from_node[axis] * cell);
        let bare = others.clone().filter_map(|other| nearest(lattice, other, on_face));
        let bare = bare.map(|(_, other)| (0.5 + other.distance / (width * cell)).clamp(0.0, 1.0));
        sum += value * bare.product::<f64>();
    }
    sum * width
}

/// The function of a node at a distance along an axis, in cells, far from walls.
fn value(lattice: &Lattice, from_node: f64) -> f64 {
    fn of<F: Shape<N>, const N: usize>(from_node: f64, half: f64) -> f64 {
        let along = F::unwalled(from_node, half);
        let at = -along.base;
        if (0.0..N as f64).contains(&at) { along.values[at as usize] } else { 0.0 }
    }
    let half = lattice.point_half;
    match lattice.shape {
        ShapeFunction::Linear => of::<LinearHat, 3>(from_node, half),
        ShapeFunction::Generalised => of::<Generalised, 3>(from_node, half),
        ShapeFunction::Quadratic => of::<Quadratic, 3>(from_node, half),
        ShapeFunction::Cubic => of::<Cubic, 4>(from_node, half),
    }
}

/// What the points of a block bring to its tile for askew faces; the tile has been cleared.
pub fn scatter<S: Space>(
    set: &FaceSet,
    bodies: &[Body<S>],
    frame: &TileFrame<S>,
    points: &[Hot<S>],
    tile: &mut [Outline],
) {
    let lattice = &set.lattice;
    for point in points {
        let Some(touch) = touch_of(set, bodies, point) else { continue };
        match lattice.shape {
            ShapeFunction::Linear => bring::<S, LinearHat, 3>(frame, point, touch, tile),
            ShapeFunction::Generalised => bring::<S, Generalised, 3>(frame, point, touch, tile),
            ShapeFunction::Quadratic => bring::<S, Quadratic, 3>(frame, point, touch, tile),
            ShapeFunction::Cubic => bring::<S, Cubic, 4>(frame, point, touch, tile),
        }
    }
}

/// t of a point; none where no face is near enough.
fn touch_of<S: Space>(set: &FaceSet, bodies: &[Body<S>], point: &Hot<S>) -> Option<f64> {
    let lattice = &set.lattice;
    let (felt, mut touch) = (felt(lattice), None);
    for body in &set.askew {
        let Some((_, nearest)) = nearest(lattice, &bodies[*body], point.position) else { continue };
        let distance = nearest.distance / lattice.cell;
        if distance.abs() > felt {
            continue;
        }
        // Half of the point's box along the normal.
        let edge = |along: usize| {
            let components =
                (0..S::DIMENSION).map(|axis| point.deformation[along * S::DIMENSION + axis] * nearest.normal[axis]);
            components.sum::<f64>().abs()
        };
        let half = lattice.point_half * (0..S::DIMENSION).map(edge).sum::<f64>();
        let told = touch.unwrap_or(0.0);
        touch = Some(match distance {
            distance if distance - half < TOUCH => TOUCHES,
            distance if distance < 2.0 * half && told == 0.0 => IS_NEAR,
            _ => told,
        });
    }
    touch
}

fn bring<S: Space, F: Shape<N>, const N: usize>(
    frame: &TileFrame<S>,
    point: &Hot<S>,
    touch: f64,
    tile: &mut [Outline],
) {
    let initial = point.weight * point.volume;
    let (volume, kirchhoff) = (initial * point.volume_ratio(), point.kirchhoff());
    frame.stencil::<F, N>(&point.position).for_each_gradient(frame.edge, |node, value, gradient| {
        let node = &mut tile[node].0;
        for axis in 0..S::DIMENSION {
            node[GRADIENT + axis] += volume * gradient[axis];
            for other in 0..=axis {
                let stress = kirchhoff[axis * S::DIMENSION + other];
                node[LOAD + axis * (axis + 1) / 2 + other] += initial * value * stress;
            }
        }
        node[TOUCHED] += touch * value;
        node[VOLUME] += volume * value;
    });
}
