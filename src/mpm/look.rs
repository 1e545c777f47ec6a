//! The grid from one place, whatever its functions: for what looks at a step, not for the step itself.

use crate::base::space::Space;
use crate::mpm::scatter::TileFrame;
use crate::mpm::scheme::ShapeFunction;
use crate::mpm::shape::{Cubic, Generalised, LinearHat, Quadratic, Shape};

/// Calls `visit(node of the tile, N)` for every node that reaches `place` (m), in lexical order.
pub fn for_each_node<S: Space>(
    frame: &TileFrame<S>,
    shape: ShapeFunction,
    place: &S::Vector,
    visit: impl FnMut(usize, f64),
) {
    match shape {
        ShapeFunction::Linear => frame.stencil::<LinearHat, 3>(place).for_each(frame.edge, visit),
        ShapeFunction::Generalised => frame.stencil::<Generalised, 3>(place).for_each(frame.edge, visit),
        ShapeFunction::Quadratic => frame.stencil::<Quadratic, 3>(place).for_each(frame.edge, visit),
        ShapeFunction::Cubic => frame.stencil::<Cubic, 4>(place).for_each(frame.edge, visit),
    }
}

/// `D`, the second moments `sum N (x_i - x)^2` of the functions along each axis about `place`, m2.
pub fn moments<S: Space>(frame: &TileFrame<S>, shape: ShapeFunction, place: &S::Vector) -> [f64; 3] {
    match shape {
        ShapeFunction::Linear => moments_of::<S, LinearHat, 3>(frame, place),
        ShapeFunction::Generalised => moments_of::<S, Generalised, 3>(frame, place),
        ShapeFunction::Quadratic => moments_of::<S, Quadratic, 3>(frame, place),
        ShapeFunction::Cubic => moments_of::<S, Cubic, 4>(frame, place),
    }
}

fn moments_of<S: Space, F: Shape<N>, const N: usize>(frame: &TileFrame<S>, place: &S::Vector) -> [f64; 3] {
    let stencil = frame.stencil::<F, N>(place);
    let square = |axis: usize, node: usize| {
        let arm = frame.corner[axis] + (stencil.base[axis] + node as f64) * frame.cell - place[axis];
        stencil.values[axis][node] * arm * arm
    };
    std::array::from_fn(|axis| if axis < S::DIMENSION { (0..N).map(|node| square(axis, node)).sum() } else { 0.0 })
}
