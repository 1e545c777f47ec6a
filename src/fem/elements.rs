//! The elements and nodes of a rank: what a step does with them, row by row. An element stands beside the material point that it has.

use rayon::prelude::*;

use crate::base::lane::{Instructions, LANES, Pack, Packed};
use crate::base::numbers::Lanes;
use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::fem::element::{
    AXES_MAX, AtCorners, CORNERS_MAX, Element, Gradients, corners, deformation, force, matrix_of, product, pushed,
    tensor_of, widened,
};
use crate::fem::hourglass::{Hourglass, MODES_MAX, Modes, Resistance, Shape};
use crate::fem::node::Node;
use crate::fem::side::{FACE_CORNERS, Side};
use crate::mpm::load::{Kind, Load};
use crate::mpm::points::Hot;
use crate::mpm::scatter::eight_of;
use crate::mpm::strain::Rates;

/// Fewer rows are not worth a task of their own.
const ROWS_PER_TASK: usize = 256;
/// Octets that a task takes: what a step reads and writes of them stays near the core.
const OCTETS_PER_TASK: usize = 8;
const ELEMENTS_PER_TASK: usize = LANES * OCTETS_PER_TASK;

/// The rows of the nodes of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementRow {
    /// By corner; in the plane the first four count.
    pub nodes: [u32; CORNERS_MAX],
}

/// Places of the corners of an element at the start, m: of those across a period not that of the node.
pub type Places<S> = [<S as Space>::Vector; CORNERS_MAX];

/// Eight elements side by side; where there are fewer, the last is there several times.
#[derive(Clone, Debug, PartialEq)]
pub struct Octet {
    /// Index into [`Elements::shapes`].
    shape: u32,
    /// Of the corners at the start, m.
    middle: [[f64; LANES]; AXES_MAX],
}

/// The shapes of eight elements side by side, number by number.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    volume: [f64; LANES],
    gradients: AtCorners<[f64; LANES]>,
    gammas: [[[f64; LANES]; CORNERS_MAX]; MODES_MAX],
    frame: [[[f64; LANES]; AXES_MAX]; AXES_MAX],
    edges: [[f64; LANES]; AXES_MAX],
}

impl Shapes {
    fn of(shapes: &[(Element, Modes)]) -> Self {
        let shapes = eight_of(shapes);
        use std::array::from_fn;
        Self {
            volume: shapes.map(|(element, _)| element.volume),
            gradients: from_fn(|corner| from_fn(|axis| shapes.map(|(element, _)| element.gradients[corner][axis]))),
            gammas: from_fn(|mode| from_fn(|corner| shapes.map(|(_, modes)| modes.gammas[mode][corner]))),
            frame: from_fn(|row| from_fn(|column| shapes.map(|(_, modes)| modes.frame[row][column]))),
            edges: from_fn(|axis| shapes.map(|(_, modes)| modes.edges[axis])),
        }
    }
}

impl<P: Pack> Gradients<P> for Shapes {
    #[inline(always)]
    fn volume(&self) -> P {
        P::load(&self.volume)
    }
    #[inline(always)]
    fn gradient(&self, corner: usize, axis: usize) -> P {
        P::load(&self.gradients[corner][axis])
    }
}

impl<P: Pack> Shape<P> for Shapes {
    #[inline(always)]
    fn gamma(&self, mode: usize, corner: usize) -> P {
        P::load(&self.gammas[mode][corner])
    }
    #[inline(always)]
    fn frame(&self, row: usize, column: usize) -> P {
        P::load(&self.frame[row][column])
    }
    #[inline(always)]
    fn edge(&self, axis: usize) -> P {
        P::load(&self.edges[axis])
    }
}

/// A side of an element of the mesh that bears a load of the job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadedSide {
    /// Its number in the mesh.
    pub element: u32,
    /// Which of its sides.
    pub side: Side,
    /// Number of the load in the job.
    pub load: usize,
}

/// The same of an element here, by its row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loaded<S: Space> {
    /// Of the element among the points of this rank.
    pub row: u32,
    /// Which of its sides.
    pub side: Side,
    /// Number of the load in the job.
    pub load: usize,
    /// Of all corners of the element.
    pub places: Places<S>,
}

/// What a load puts on a node, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push<S: Space> {
    /// Its row.
    pub node: u32,
    /// N.
    pub force: S::Vector,
}

/// What holds a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Holder {
    /// The domain, where it ends.
    Face {
        /// That it is across, 0 to 2.
        axis: usize,
        /// Whether it is the one at the larger coordinate.
        upper: bool,
    },
    /// A rigid body, by its number.
    Body(usize),
}

/// What it took from a node to hold it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<S: Space> {
    /// Its row.
    pub node: u32,
    /// A face of the domain or a body.
    pub by: Holder,
    /// On the material, N s.
    pub impulse: S::Vector,
    /// Where it acts, beside the image of the body that does it, m.
    pub place: S::Vector,
}

/// Elements in the order of points, and the nodes that they have.
#[derive(Clone, Debug)]
pub struct Elements<S: Space> {
    /// By element the nodes at its corners.
    pub rows: Vec<ElementRow>,
    /// The same elements by eights.
    pub octets: Vec<Octet>,
    /// Octets whose elements are alike, as those of a box are, have one of them together.
    pub shapes: Vec<Shapes>,
    /// In the order of their ids.
    pub nodes: Vec<Node<S>>,
    /// kg.
    pub masses: Vec<f64>,
    /// What of the surface a node is on at the start, by the bits of [`crate::bodies::body::MeshSide`].
    pub sides: Vec<u64>,
    /// Which of them this rank answers for where each is to be counted once.
    pub owned: Vec<bool>,
    /// Sides of these elements that bear loads, in the order of elements, sides and loads.
    pub loaded: Vec<Loaded<S>>,
    /// Forces on corners, N: of each element here the first of its [`CORNERS_MAX`] places, and behind them those of other ranks' elements.
    pub corner_forces: Vec<S::Vector>,
    /// Which of these are at each node, in the order of elements: from one of the firsts to the next.
    pub firsts: Vec<u32>,
    /// Node after node, as indices into `corner_forces`.
    pub terms: Vec<u32>,
    /// Of the step, not of the state: forces on nodes, N; velocities before, m/s; what damping took, N s; what loads put on nodes, and what holds those that this rank
    /// answers for; and `sum Q q/2` of elements, J.
    pub forces: Vec<S::Vector>,
    /// By node, before the step's forces, m/s.
    pub before: Vec<S::Vector>,
    /// By node, what damping took in the step, N s.
    pub damped: Vec<S::Vector>,
    /// What loads put on nodes, by side and corner: of a node there may be several.
    pub pushes: Vec<Push<S>>,
    /// What it took to hold nodes that this rank answers for.
    pub held: Vec<Held<S>>,
    /// `sum Q q/2` by element, J.
    pub hourglass: Vec<f64>,
    /// Whether forces on corners and hourglass energies are those of the places and stresses of now. Whoever changes these between a drift and the next fill says
    /// here that they are not.
    pub filled: bool,
}

impl<S: Space> Default for Elements<S> {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            octets: Vec::new(),
            shapes: Vec::new(),
            nodes: Vec::new(),
            masses: Vec::new(),
            sides: Vec::new(),
            owned: Vec::new(),
            loaded: Vec::new(),
            corner_forces: Vec::new(),
            firsts: Vec::new(),
            terms: Vec::new(),
            forces: Vec::new(),
            before: Vec::new(),
            damped: Vec::new(),
            pushes: Vec::new(),
            held: Vec::new(),
            hourglass: Vec::new(),
            filled: false,
        }
    }
}

impl ElementRow {
    fn displacements<S: Space>(&self, nodes: &[Node<S>]) -> Places<S> {
        self.nodes.map(|node| nodes[node as usize].displacement)
    }
}

impl<S: Space> Elements<S> {
    /// Eight elements or, at the end, fewer: their middles at the start, and what they are.
    pub fn add_octet(&mut self, middles: &[S::Vector], shapes: &[(Element, Modes)]) {
        let shapes = Shapes::of(shapes);
        if self.shapes.last() != Some(&shapes) {
            self.shapes.push(shapes);
        }
        let middles = eight_of(middles).map(widened);
        let middle = std::array::from_fn(|axis| middles.map(|middle| middle[axis]));
        self.octets.push(Octet { shape: self.shapes.len() as u32 - 1, middle });
    }

    /// Forces of stresses and hourglass modes on corners, at the places of now, unless they are there.
    pub fn fill_corners(&mut self, points: &[Hot<S>], (how, instructions): (&Hourglass, Instructions)) {
        if std::mem::take(&mut self.filled) {
            return;
        }
        let Self { rows, octets, shapes, nodes, corner_forces, hourglass, .. } = self;
        let forces = corner_forces[..rows.len() * CORNERS_MAX].par_chunks_mut(CORNERS_MAX * ELEMENTS_PER_TASK);
        let of_rows = rows
            .par_chunks(ELEMENTS_PER_TASK)
            .zip(octets.par_chunks(OCTETS_PER_TASK))
            .zip(points.par_chunks(ELEMENTS_PER_TASK));
        let outcomes = forces.zip(hourglass.par_chunks_mut(ELEMENTS_PER_TASK));
        of_rows.zip(outcomes).for_each(|(((rows, octets), points), (forces, hourglass))| {
            instructions.run(Fill { how, rows, octets, shapes, points, nodes, forces, hourglass });
        });
    }

    /// Loads on sides as they are at a time: a pressure on the area of now, a traction on that of the start.
    pub fn push_loaded(&mut self, loads: &[Load<S>], time: f64, depth: f64) {
        let Self { rows, nodes, loaded, corner_forces, pushes, .. } = self;
        pushes.clear();
        for Loaded { row: number, side, load, places: begun } in loaded.iter() {
            let (row, load) = (&rows[*number as usize], &loads[*load]);
            let share = if time < load.ramp { time / load.ramp } else { 1.0 };
            let moved = row.displacements(nodes);
            let places = match load.kind {
                Kind::Pressure(_) => std::array::from_fn(|corner| begun[corner] + moved[corner]),
                Kind::Traction(_) => *begun,
            };
            let areas = side.areas::<S>(&places, depth);
            for (corner, area) in side.corners::<S>().iter().zip(&areas[..FACE_CORNERS[S::DIMENSION - 2]]) {
                let force = match load.kind {
                    Kind::Pressure(pressure) => *area * (-share * pressure),
                    Kind::Traction(traction) => traction * (share * area.norm()),
                };
                corner_forces[*number as usize * CORNERS_MAX + corner] += force;
                pushes.push(Push { node: row.nodes[*corner], force });
            }
        }
    }

    /// Forces on nodes, each the sum over the elements around it in their order.
    pub fn sum_corners(&mut self) {
        let Self { corner_forces, firsts, terms, forces, .. } = self;
        forces.par_iter_mut().enumerate().with_min_len(ROWS_PER_TASK).for_each(|(node, force)| {
            let around = &terms[firsts[node] as usize..firsts[node + 1] as usize];
            *force = around.iter().fold(S::Vector::zero(), |sum, term| sum + corner_forces[*term as usize]);
        });
    }

    /// Nodes drift with their velocities, and points with the elements that they are of: place, velocity, and F. `strained` is told of points, one stretch of
    /// them after another, with what laws are told, `(F' F^-1 - 1)/dt` from the old to the new F, 1/s. Where stresses are known right after it, the hourglass
    /// control is given in `then`, and forces on corners are filled while all of the stretch is at hand.
    pub fn drift(
        &mut self,
        points: &mut [Hot<S>],
        (dt, instructions): (f64, Instructions),
        strained: impl Fn(&[Rates], &mut [Hot<S>]) + Sync,
        then: Option<&Hourglass>,
    ) {
        let Self { rows, octets, shapes, nodes, corner_forces, hourglass, .. } = self;
        nodes.par_iter_mut().with_min_len(ROWS_PER_TASK).for_each(|node| node.displacement += node.velocity * dt);
        let (nodes, shapes) = (&*nodes, &shapes[..]);
        let forces = corner_forces[..rows.len() * CORNERS_MAX].par_chunks_mut(CORNERS_MAX * ELEMENTS_PER_TASK);
        let of_rows = rows.par_chunks(ELEMENTS_PER_TASK).zip(octets.par_chunks(OCTETS_PER_TASK));
        let of_rows = of_rows.zip(points.par_chunks_mut(ELEMENTS_PER_TASK));
        let outcomes = forces.zip(hourglass.par_chunks_mut(ELEMENTS_PER_TASK));
        of_rows.zip(outcomes).for_each(|(((rows, octets), points), (forces, hourglass))| {
            let mut rates = [Rates::default(); OCTETS_PER_TASK];
            let rates = &mut rates[..octets.len()];
            instructions.run(Follow { dt, rows, octets, shapes, nodes, points, rates });
            strained(rates, points);
            if let Some(how) = then {
                instructions.run(Fill { how, rows, octets, shapes, points, nodes, forces, hourglass });
            }
        });
        self.filled = then.is_some();
    }
}

/// What the nodes of eight elements have, corner by corner.
#[inline(always)]
fn at_corners<S: Space, P: Pack>(
    rows: &[&ElementRow; LANES],
    nodes: &[Node<S>],
    of: impl Fn(&Node<S>) -> &S::Vector,
) -> AtCorners<P> {
    let mut found = [[P::splat(0.0); AXES_MAX]; CORNERS_MAX];
    for (corner, found) in found.iter_mut().enumerate().take(corners::<S>()) {
        let mut lanes = [[0.0; LANES]; AXES_MAX];
        for (lane, row) in rows.iter().enumerate() {
            let vector = of(&nodes[row.nodes[corner] as usize]);
            for (axis, lanes) in lanes.iter_mut().enumerate().take(S::DIMENSION) {
                lanes[lane] = vector[axis];
            }
        }
        for (found, lanes) in found.iter_mut().zip(&lanes).take(S::DIMENSION) {
            *found = P::load(lanes);
        }
    }
    found
}

struct Fill<'a, S: Space> {
    how: &'a Hourglass,
    rows: &'a [ElementRow],
    octets: &'a [Octet],
    shapes: &'a [Shapes],
    points: &'a [Hot<S>],
    nodes: &'a [Node<S>],
    forces: &'a mut [S::Vector],
    hourglass: &'a mut [f64],
}

impl<S: Space> Packed for Fill<'_, S> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        let Self { how, rows, octets, shapes, points, nodes, forces, hourglass } = self;
        let (forces, _) = forces.as_chunks_mut::<CORNERS_MAX>();
        let (mut lanes, mut out) = (Lanes::<P>::zero(), Lanes::<P>::zero());
        for (number, octet) in octets.iter().enumerate() {
            let first = number * LANES;
            let held = first..(first + LANES).min(rows.len());
            let moved = at_corners::<S, P>(&eight_of(&rows[held.clone()]), nodes, |node| &node.displacement);
            lanes.load(&eight_of(&points[held.clone()]), Hot::<S>::DEFORMATION + S::Tensor::COMPONENTS);
            let stress = lanes.words::<S::SymmetricOf<P>>(Hot::<S>::STRESS).tensor();
            // One that is inside out is found by the guard.
            let inverse = S::inverse_of::<P>(&lanes.words(Hot::<S>::DEFORMATION));
            let (inverse, stress) = (matrix_of::<S, P>(&inverse), matrix_of::<S, P>(&stress));
            let shape = &shapes[octet.shape as usize];
            let pushed = pushed::<S, P>(shape, &stress, &inverse);
            let resistance = Resistance::of::<S>(shape, how, &moved, (&inverse, &stress));
            for (to, energy) in hourglass[held.clone()].iter_mut().zip(resistance.energy.numbers()) {
                *to = energy;
            }
            for corner in 0..corners::<S>() {
                let force = resistance.beside::<S>(shape, corner, force::<S, P>(shape, &pushed, corner));
                out.0[corner * S::DIMENSION..][..S::DIMENSION].copy_from_slice(&force[..S::DIMENSION]);
            }
            out.store(&mut forces[held]);
        }
    }
}

struct Follow<'a, S: Space> {
    dt: f64,
    rows: &'a [ElementRow],
    octets: &'a [Octet],
    shapes: &'a [Shapes],
    nodes: &'a [Node<S>],
    points: &'a mut [Hot<S>],
    rates: &'a mut [Rates],
}

impl<S: Space> Packed for Follow<'_, S> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        let Self { dt, rows, octets, shapes, nodes, points, rates } = self;
        let (per_step, share) = (P::splat(1.0 / dt), P::splat(1.0 / corners::<S>() as f64));
        let (mut lanes, kinematics) = (Lanes::<P>::zero(), Hot::<S>::DEFORMATION + S::Tensor::COMPONENTS);
        for ((number, octet), rates) in octets.iter().enumerate().zip(rates) {
            let first = number * LANES;
            let held = first..(first + LANES).min(rows.len());
            let rows = eight_of(&rows[held.clone()]);
            let moved = at_corners::<S, P>(&rows, nodes, |node| &node.displacement);
            let speeds = at_corners::<S, P>(&rows, nodes, |node| &node.velocity);
            let points = &mut points[held];
            lanes.load(&eight_of(points), kinematics);
            let before = S::inverse_of::<P>(&lanes.words(Hot::<S>::DEFORMATION));
            let deformation = deformation::<S, P>(&shapes[octet.shape as usize], &moved);
            let mut rate = product::<S, P>(&deformation, &matrix_of::<S, P>(&before));
            for (axis, row) in rate.iter_mut().enumerate() {
                row[axis] = row[axis] - P::splat(1.0);
                row.iter_mut().for_each(|entry| *entry = *entry * per_step);
            }
            rates.keep::<S, P>(&tensor_of::<S, P>(&rate));
            lanes.set_words(Hot::<S>::DEFORMATION, &tensor_of::<S, P>(&deformation));
            for axis in 0..S::DIMENSION {
                let (mut place, mut speed) = (moved[0][axis], speeds[0][axis]);
                for corner in 1..corners::<S>() {
                    place = place + moved[corner][axis];
                    speed = speed + speeds[corner][axis];
                }
                // Means of the corners, so that mass times velocity is the same over points and over nodes.
                lanes.0[Hot::<S>::POSITION + axis] = P::load(&octet.middle[axis]) + place * share;
                lanes.0[Hot::<S>::VELOCITY + axis] = speed * share;
            }
            lanes.store_first(points, kinematics);
        }
    }
}
