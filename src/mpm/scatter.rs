//! Points and grains to the tile of their block.

use crate::dem::grains::{Cold as GrainCold, Hot as GrainHot, Mover};
use crate::lane::{Compiled, Instructions};
use crate::mpm::points::Hot;
use crate::mpm::shape::{Axis, Cubic, Generalised, LinearHat, Quadratic, Shape, Stencil};
use crate::mpm::tile::{Gathered, GrainNode, NODE_WORDS};
use crate::scenario::mpm::ShapeFunction;
use crate::space::Space;

/// One block's tile: where its first node lies, and how a place is measured in it.
#[derive(Clone, Copy, Debug)]
pub struct TileFrame<S: Space> {
    /// Place of the tile's first node, m.
    pub corner: S::Vector,
    /// Edge of a cell, m, and its inverse.
    pub cell: f64,
    pub cell_inverse: f64,
    /// Nodes per axis.
    pub edge: usize,
    pub axes: [Axis; 3],
}

impl<S: Space> TileFrame<S> {
    /// A place in cells from the tile's first node.
    #[inline(always)]
    pub fn place(&self, position: &S::Vector) -> S::Vector {
        (*position - self.corner) * self.cell_inverse
    }

    /// The functions of `F` at a place, m.
    #[inline(always)]
    pub fn stencil<F: Shape<N>, const N: usize>(&self, position: &S::Vector) -> Stencil<S, N> {
        Stencil::new::<F>(&self.place(position), &self.axes, self.cell_inverse)
    }

    /// Places of the functions in reach less the point's own, along each axis, m.
    #[inline(always)]
    pub fn arms<F: Shape<N>, const N: usize>(&self, position: &S::Vector, stencil: &Stencil<S, N>) -> [[f64; N]; 3] {
        let place = self.place(position);
        let mut arms = [[0.0; N]; 3];
        for axis in 0..S::DIMENSION {
            for (node, arm) in arms[axis].iter_mut().enumerate() {
                *arm = (F::stand(stencil.base[axis] + node, &self.axes[axis]) - place[axis]) * self.cell;
            }
        }
        arms
    }
}

/// What points bring to their nodes, weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brought {
    /// `m_i = sum w m N_i`, `p_i = sum w m v N_i`, with the affine field `p_i = sum w m (v + C (x_i - x)) N_i`, and
    /// `f_i = -sum w V0 tau grad N_i`.
    All,
    /// Mass and momentum alone.
    Motion,
}

/// Mass, momentum and internal force of the block's points, to a tile that has been cleared.
pub fn scatter_points<S: Space, M: Sync>(
    frame: &TileFrame<S>,
    (shape, affine, instructions): (ShapeFunction, bool, Instructions),
    brought: Brought,
    points: &[Hot<S, M>],
    tile: &mut [Gathered<S>],
) {
    macro_rules! with {
        ($shape:ty, $nodes:literal) => {
            match affine {
                true => instructions.run(Scatter::<S, M, $shape, $nodes, true>::new(frame, brought, points, tile)),
                false => instructions.run(Scatter::<S, M, $shape, $nodes, false>::new(frame, brought, points, tile)),
            }
        };
    }
    match shape {
        ShapeFunction::Linear => with!(LinearHat, 3),
        ShapeFunction::Generalised => with!(Generalised, 3),
        ShapeFunction::Quadratic => with!(Quadratic, 3),
        ShapeFunction::Cubic => with!(Cubic, 4),
    }
}

struct Scatter<'a, S: Space, M, F, const N: usize, const AFFINE: bool> {
    frame: &'a TileFrame<S>,
    brought: Brought,
    points: &'a [Hot<S, M>],
    tile: &'a mut [Gathered<S>],
    shape: std::marker::PhantomData<F>,
}

impl<'a, S: Space, M, F: Shape<N>, const N: usize, const AFFINE: bool> Scatter<'a, S, M, F, N, AFFINE> {
    fn new(frame: &'a TileFrame<S>, brought: Brought, points: &'a [Hot<S, M>], tile: &'a mut [Gathered<S>]) -> Self {
        Self { frame, brought, points, tile, shape: std::marker::PhantomData }
    }
}

/// Words of a node, all of them changed in step.
type Words = [f64; NODE_WORDS];

impl<S: Space, M, F: Shape<N>, const N: usize, const AFFINE: bool> Compiled for Scatter<'_, S, M, F, N, AFFINE> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { frame, brought, points, tile, .. } = self;
        let forces = if brought == Brought::All { 1.0 } else { 0.0 };
        for point in points {
            let stencil = frame.stencil::<F, N>(&point.position);
            let mass = point.weight * point.mass;
            // What a node gets per N, per component of grad N, and per component of N (x_i - x).
            let (mut value, mut slope, mut arm): (Words, [Words; 3], [Words; 3]) =
                ([0.0; NODE_WORDS], [[0.0; NODE_WORDS]; 3], [[0.0; NODE_WORDS]; 3]);
            value[0] = mass;
            let stress = point.stress * (point.weight * point.volume * forces);
            for axis in 0..S::DIMENSION {
                value[1 + axis] = point.velocity[axis] * mass;
                for along in 0..S::DIMENSION {
                    slope[along][1 + S::DIMENSION + axis] = -stress[along * S::DIMENSION + axis];
                    if AFFINE {
                        arm[along][1 + axis] = point.affine[along * S::DIMENSION + axis] * mass;
                    }
                }
            }
            let arms = if AFFINE { frame.arms::<F, N>(&point.position, &stencil) } else { [[0.0; N]; 3] };
            for k in 0..Stencil::<S, N>::LAYERS {
                for j in 0..N {
                    let first = stencil.row(frame.edge, j, k);
                    let row = &mut tile[first..first + N];
                    for i in 0..N {
                        let (n, [gx, gy, gz]) = stencil.at(i, j, k);
                        let node = &mut row[i].0;
                        for word in 0..NODE_WORDS {
                            let mut more = n * value[word] + gx * slope[0][word] + gy * slope[1][word];
                            if S::DIMENSION == 3 {
                                more += gz * slope[2][word];
                            }
                            if AFFINE {
                                more += (n * arms[0][i]) * arm[0][word] + (n * arms[1][j]) * arm[1][word];
                                if S::DIMENSION == 3 {
                                    more += (n * arms[2][k]) * arm[2][word];
                                }
                            }
                            node[word] += more;
                        }
                    }
                }
            }
        }
    }
}

/// Weighted mass and momentum of the block's free grains, at their positions before the step.
pub fn scatter_grains<S: Space>(
    frame: &TileFrame<S>,
    hot: &[GrainHot<S>],
    cold: &[GrainCold<S>],
    tile: &mut [GrainNode<S>],
) {
    for (hot, _) in hot.iter().zip(cold).filter(|(_, cold)| cold.mover == Mover::Free) {
        let mass = hot.weight * hot.mass;
        let momentum = hot.velocity * mass;
        frame.stencil::<Quadratic, 3>(&hot.position).for_each(frame.edge, |node, value| {
            let node = &mut tile[node];
            node.mass += mass * value;
            node.momentum += momentum * value;
        });
    }
}

/// Weighted mass of points with their weighted values of two fields, for fields on nodes: `sum w m N`, `sum w m N a`,
/// `sum w m N b`.
pub fn scatter_fields<S: Space, M>(
    frame: &TileFrame<S>,
    points: &[Hot<S, M>],
    fields: impl Fn(usize, &Hot<S, M>) -> [f64; 2],
    tile: &mut [[f64; 3]],
) {
    for (row, point) in points.iter().enumerate() {
        let mass = point.weight * point.mass;
        let [a, b] = fields(row, point);
        frame.stencil::<Quadratic, 3>(&point.position).for_each(frame.edge, |node, value| {
            let node = &mut tile[node];
            node[0] += mass * value;
            node[1] += mass * value * a;
            node[2] += mass * value * b;
        });
    }
}
