//! Tiles back to points and grains.

use crate::dem::grains::{Cold as GrainCold, Hot as GrainHot, Mover};
use crate::dem::segments::larger;
use crate::lane::{Compiled, Instructions};
use crate::law::material::MaterialLaw;
use crate::mpm::points::Hot;
use crate::mpm::scatter::TileFrame;
use crate::mpm::shape::{Cubic, Generalised, LinearHat, Quadratic, Shape, Stencil};
use crate::mpm::tile::{Advanced, GrainChange, NODE_WORDS};
use crate::scenario::mpm::{ShapeFunction, Transfer};
use crate::space::{Linear, Space};

/// What points take from the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// Velocity and place, then strain and stress.
    All,
    /// Velocity and place.
    Motion,
    /// Velocity; the way to the new place is kept until the strain has been taken at the old one.
    Velocity,
    /// Strain and stress.
    Strain,
    /// Strain and stress, then the way that was kept.
    StrainThenPlace,
}

impl Taken {
    const fn has_motion(self) -> bool {
        matches!(self, Self::All | Self::Motion | Self::Velocity)
    }
    const fn has_strain(self) -> bool {
        matches!(self, Self::All | Self::Strain | Self::StrainThenPlace)
    }
}

/// How points take it.
#[derive(Clone, Copy, Debug)]
pub struct Taking {
    pub shape: ShapeFunction,
    pub transfer: Transfer,
    pub taken: Taken,
    pub dt: f64,
    pub instructions: Instructions,
}

/// Velocity, place and stress of the block's points:
///
/// ```text
/// v <- alpha (v + sum N dv_i) + (1 - alpha) sum N v_i,   x += sum N v_i dt,   L = sum v_i grad N      blend
/// v <- sum N v_i,   C = (sum N v_i (x_i - x)^T) D^-1,   D = sum N (x_i - x)(x_i - x)^T                affine
/// F <- (1 + L dt) F
/// ```
///
/// `ways` holds the way of each point while its place waits. Returns the longest way that a point has come from home along
/// an axis, m.
pub fn gather_points<S: Space, L: MaterialLaw<S>>(
    frame: &TileFrame<S>,
    law: &L,
    taking: Taking,
    tile: &[Advanced<S>],
    points: &mut [Hot<S, L::Memory>],
    ways: &mut [S::Vector],
) -> f64 {
    let affine = taking.transfer == Transfer::Affine && taking.taken.has_motion();
    macro_rules! with {
        ($shape:ty, $nodes:literal) => {
            match affine {
                true => taking.instructions.run(Gather::<S, L, $shape, $nodes, true> {
                    frame,
                    law,
                    taking,
                    tile,
                    points,
                    ways,
                    shape: std::marker::PhantomData,
                }),
                false => taking.instructions.run(Gather::<S, L, $shape, $nodes, false> {
                    frame,
                    law,
                    taking,
                    tile,
                    points,
                    ways,
                    shape: std::marker::PhantomData,
                }),
            }
        };
    }
    match taking.shape {
        ShapeFunction::Linear => with!(LinearHat, 3),
        ShapeFunction::Generalised => with!(Generalised, 3),
        ShapeFunction::Quadratic => with!(Quadratic, 3),
        ShapeFunction::Cubic => with!(Cubic, 4),
    }
}

struct Gather<'a, S: Space, L: MaterialLaw<S>, F, const N: usize, const AFFINE: bool> {
    frame: &'a TileFrame<S>,
    law: &'a L,
    taking: Taking,
    tile: &'a [Advanced<S>],
    points: &'a mut [Hot<S, L::Memory>],
    ways: &'a mut [S::Vector],
    shape: std::marker::PhantomData<F>,
}

/// Words of a node, all of them read in step.
type Words = [f64; NODE_WORDS];

/// Second moments of the functions along an axis below this share of a squared cell are not divided by: on a node itself
/// linear functions know no field about them.
const MOMENT_LEAST: f64 = 1e-9;

impl<S: Space, L: MaterialLaw<S>, F: Shape<N>, const N: usize, const AFFINE: bool> Compiled
    for Gather<'_, S, L, F, N, AFFINE>
{
    type Outcome = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let mut farthest = 0.0;
        let Self { frame, law, taking, tile, points, ways, .. } = self;
        let Taking { transfer, taken, dt, .. } = taking;
        for (row, point) in points.iter_mut().enumerate() {
            let stencil = frame.stencil::<F, N>(&point.position);
            let arms = if AFFINE { frame.arms::<F, N>(&point.position, &stencil) } else { [[0.0; N]; 3] };
            let (mut value, mut slope, mut arm): (Words, [Words; 3], [Words; 3]) =
                ([0.0; NODE_WORDS], [[0.0; NODE_WORDS]; 3], [[0.0; NODE_WORDS]; 3]);
            for k in 0..Stencil::<S, N>::LAYERS {
                for j in 0..N {
                    let first = stencil.row(frame.edge, j, k);
                    let nodes = &tile[first..first + N];
                    for i in 0..N {
                        let (n, [gx, gy, gz]) = stencil.at(i, j, k);
                        let node = &nodes[i].0;
                        for word in 0..NODE_WORDS {
                            value[word] += n * node[word];
                            slope[0][word] += gx * node[word];
                            slope[1][word] += gy * node[word];
                            if S::DIMENSION == 3 {
                                slope[2][word] += gz * node[word];
                            }
                            if AFFINE {
                                arm[0][word] += (n * arms[0][i]) * node[word];
                                arm[1][word] += (n * arms[1][j]) * node[word];
                                if S::DIMENSION == 3 {
                                    arm[2][word] += (n * arms[2][k]) * node[word];
                                }
                            }
                        }
                    }
                }
            }
            if taken.has_motion() {
                let (mut velocity, mut change) = (S::Vector::zero(), S::Vector::zero());
                for axis in 0..S::DIMENSION {
                    velocity[axis] = value[axis];
                    change[axis] = value[S::DIMENSION + axis];
                }
                match transfer {
                    Transfer::Blend { flip } => {
                        point.velocity = (point.velocity + change) * flip + velocity * (1.0 - flip);
                    }
                    Transfer::Affine => point.velocity = velocity,
                }
                if AFFINE {
                    for along in 0..S::DIMENSION {
                        let mut moment = 0.0;
                        for (n, arm) in stencil.values[along].iter().zip(&arms[along]) {
                            moment += n * arm * arm;
                        }
                        let inverse = 1.0 / moment.max(MOMENT_LEAST * frame.cell * frame.cell);
                        for (axis, arm) in arm[along].iter().enumerate().take(S::DIMENSION) {
                            point.affine[along * S::DIMENSION + axis] = arm * inverse;
                        }
                    }
                }
                match taken {
                    Taken::Velocity => ways[row] = velocity * dt,
                    _ => point.position += velocity * dt,
                }
            }
            if taken.has_strain() {
                let mut gradient = S::Tensor::zero();
                for along in 0..S::DIMENSION {
                    for axis in 0..S::DIMENSION {
                        gradient[along * S::DIMENSION + axis] = slope[along][axis];
                    }
                }
                if taken == Taken::Strain {
                    gradient = before_the_way::<S>(&gradient, dt);
                }
                point.deformation = (S::identity() + gradient * dt) * point.deformation;
                point.stress = law.update(&gradient, dt, &mut point.memory);
                if taken == Taken::StrainThenPlace {
                    point.position += ways[row];
                }
            }
            let moved = point.position - point.home;
            for axis in 0..S::DIMENSION {
                farthest = larger(farthest, moved[axis].abs());
            }
        }
        farthest
    }
}

/// Velocity gradient over the places that points have come from, `L (1 - L dt)^-1` for L over those where they are.
///
/// Stress that is updated first is strained by the velocity that has just carried the points. With L itself a turning body
/// would seem to grow by `(omega dt)^2` a step more than it does, and the work of its stress against that would be energy
/// from nowhere.
fn before_the_way<S: Space>(gradient: &S::Tensor, dt: f64) -> S::Tensor {
    *gradient * S::inverse(&(S::identity() - *gradient * dt)).unwrap_or_else(S::identity)
}

/// Correction of the block's free grains: `v += sum N lambda_i/m_i`. Spin is left alone.
pub fn correct_grains<S: Space>(
    frame: &TileFrame<S>,
    tile: &[GrainChange<S>],
    hot: &mut [GrainHot<S>],
    cold: &[GrainCold<S>],
) {
    for (hot, _) in hot.iter_mut().zip(cold).filter(|(_, cold)| cold.mover == Mover::Free) {
        let mut change = S::Vector::zero();
        frame.stencil::<Quadratic, 3>(&hot.position).for_each(frame.edge, |node, value| {
            change += tile[node] * value;
        });
        hot.velocity += change;
    }
}
