//! Tiles back to points and grains.

use crate::base::lane::{Instructions, Kernel, LANES, Pack, Packed};
use crate::base::numbers::{Lanes, Numbers};
use crate::base::parallel::larger;
use crate::base::space::{Linear, Space, Words};
use crate::base::symmetric::Symmetric;
use crate::dem::grains::{Hot as GrainHot, PenaltySpring};
use crate::law::material::{Flow, MaterialLaw};
use crate::mpm::penalty::Penalty;
use crate::mpm::points::{Beside, Hot};
use crate::mpm::scatter::{Basis, TileFrame, eight_of};
use crate::mpm::scheme::{ShapeFunction, Transfer};
use crate::mpm::shape::{Stencil, row};
use crate::mpm::tile::{Advanced, GrainChange, NODE_WORDS};
use crate::mpm::volumetric::{Volumetric, flowing};

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
    /// Of the points.
    pub shape: ShapeFunction,
    /// How velocities come back.
    pub transfer: Transfer,
    /// Which part of it, in this pass over the nodes.
    pub taken: Taken,
    /// Step of the continuum, s.
    pub dt: f64,
    /// What the processor has for eight points in step.
    pub instructions: Instructions,
}

/// Velocity, place and stress of the block's points:
///
/// ```text
/// v <- alpha (v + sum N dv_i) + (1 - alpha) sum N v_i,   x += sum N v_i dt,   L = sum v_i grad N      blend
/// v <- sum N v_i,   C = (sum N v_i (x_i - x)^T) D^-1,   D = sum N (x_i - x)(x_i - x)^T                affine
/// F <- (1 + L dt) F                                     F <- (1 - L dt)^-1 F where stress is updated first
/// ```
///
/// and where volume strain is averaged, L with what [`crate::mpm::volumetric`] adds to it.
///
/// Returns how far out of the block a point is along an axis, at most, m; infinity where a place is no number.
pub fn gather_points<S: Space, L: MaterialLaw<S>>(law: &L, taking: Taking, block: Block<S>) -> f64 {
    taking.instructions.run(Gather { law, taking, block })
}

/// A block's points and the tile that they lie on; `beside` stands empty where the scheme needs nothing of it, and `volumetric` where
/// volume strain is not averaged.
pub struct Block<'a, S: Space> {
    /// Where the tile's nodes are.
    pub frame: &'a TileFrame<S>,
    /// Nodes after their step, margins filled.
    pub tile: &'a [Advanced<S>],
    /// In the order of rows; changed in place.
    pub points: &'a mut [Hot<S>],
    /// One for every point, or none: affine fields, and ways that are kept.
    pub beside: &'a mut [Beside<S>],
    /// One for every point, or none.
    pub volumetric: &'a mut [Volumetric],
}

struct Gather<'a, S: Space, L> {
    law: &'a L,
    taking: Taking,
    block: Block<'a, S>,
}

/// Second moments of the functions along an axis below this share of a squared cell are not divided by: on a node itself
/// linear functions know no field about them.
const MOMENT_LEAST: f64 = 1e-9;

/// Sums over the nodes in reach of a point, word by word of [`Advanced`].
#[derive(Clone, Copy)]
struct Sums<P> {
    /// Weighted with N, and with the components of grad N and of N (x_i - x).
    value: P,
    slope: [P; 3],
    arm: [P; 3],
}

impl<P: Pack> Sums<P> {
    #[inline(always)]
    fn zero() -> Self {
        let zero = P::splat(0.0);
        Self { value: zero, slope: [zero; 3], arm: [zero; 3] }
    }

    /// Adds sums over the axes before `axis`, taken at function `node` along it.
    #[inline(always)]
    fn add<const AFFINE: bool>(&mut self, sums: &Self, basis: &Basis, axis: usize, node: usize, lane: usize) {
        let value: P = basis.value(axis, node, lane);
        self.value = self.value + sums.value * value;
        self.slope[axis] = self.slope[axis] + sums.value * basis.slope(axis, node, lane);
        if AFFINE {
            self.arm[axis] = self.arm[axis] + sums.value * basis.moment(axis, node, lane);
        }
        for other in 0..axis {
            self.slope[other] = self.slope[other] + sums.slope[other] * value;
            if AFFINE {
                self.arm[other] = self.arm[other] + sums.arm[other] * value;
            }
        }
    }
}

/// Sums of eight points, point by point: row by row, layer by layer.
struct Sum<'a, S: Space, P, const N: usize, const AFFINE: bool> {
    basis: &'a Basis,
    edge: usize,
    tile: &'a [Advanced<S>],
    sums: &'a mut [Sums<P>; LANES],
}

impl<S: Space, P: Pack, const N: usize, const AFFINE: bool> Kernel<P> for Sum<'_, S, P, N, AFFINE> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { basis, edge, tile, sums } = self;
        for (lane, sums) in sums.iter_mut().enumerate() {
            let mut all = Sums::zero();
            for k in 0..Stencil::<S, P, N>::LAYERS {
                let mut layer = Sums::zero();
                for j in 0..N {
                    let first = basis.first[lane] + row(edge, j, k);
                    let mut along = Sums::zero();
                    for (i, node) in tile[first..first + N].iter().enumerate() {
                        let words = Sums { value: P::load(&node.0), ..Sums::zero() };
                        along.add::<AFFINE>(&words, basis, 0, i, lane);
                    }
                    layer.add::<AFFINE>(&along, basis, 1, j, lane);
                }
                match S::DIMENSION {
                    2 => all = layer,
                    _ => all.add::<AFFINE>(&layer, basis, 2, k, lane),
                }
            }
            *sums = all;
        }
    }
}

impl<S: Space, L: MaterialLaw<S>> Packed for Gather<'_, S, L> {
    type Outcome = f64;

    #[inline(always)]
    fn run<P: Pack>(self) -> f64 {
        let Self { law, taking, block: Block { frame, tile, points, beside, volumetric } } = self;
        let Taking { shape, taken, .. } = taking;
        let affine = taking.transfer == Transfer::Affine && taken.has_motion();
        let mut outside = P::splat(f64::NEG_INFINITY);
        let (mut lanes, mut basis) = (Lanes::<P>::zero(), Basis::zero());
        let mut sums = [Sums::<P>::zero(); LANES];
        for (group, points) in points.chunks_mut(LANES).enumerate() {
            let beside = if beside.is_empty() { &mut [] } else { &mut beside[group * LANES..][..points.len()] };
            let volumetric =
                if volumetric.is_empty() { &mut [] } else { &mut volumetric[group * LANES..][..points.len()] };
            lanes.load(&eight_of(points), Hot::<S>::WIDTH);
            basis.set::<S, P>(frame, (shape, affine), frame.place(&lanes.words(Hot::<S>::POSITION)));
            let (basis, edge, sums) = (&basis, frame.edge, &mut sums);
            match (shape, affine) {
                (ShapeFunction::Cubic, false) => P::enter(Sum::<S, P, 4, false> { basis, edge, tile, sums }),
                (ShapeFunction::Cubic, true) => P::enter(Sum::<S, P, 4, true> { basis, edge, tile, sums }),
                (_, false) => P::enter(Sum::<S, P, 3, false> { basis, edge, tile, sums }),
                (_, true) => P::enter(Sum::<S, P, 3, true> { basis, edge, tile, sums }),
            }
            let sums = by_words::<S, P>(sums, affine);
            if taken.has_motion() {
                move_points::<S, P>(&taking, &sums.value, &mut lanes, beside);
                if affine {
                    take_affine::<S, P>(frame, basis, &sums.arm, beside);
                }
            }
            if taken.has_strain() {
                let mean = sums.value[Advanced::<S>::VOLUME];
                strain_points::<S, L, P>(law, &taking, (&sums.slope, mean), &mut lanes, (beside, volumetric));
            }
            outside = farther(outside, outside_of::<S, P>(frame, &lanes));
            lanes.store(points);
        }
        outside.numbers().into_iter().fold(0.0, larger)
    }
}

/// [`Sums`] of eight points: word by word.
struct SumsByWord<P> {
    value: [P; NODE_WORDS],
    slope: [[P; NODE_WORDS]; 3],
    arm: [[P; NODE_WORDS]; 3],
}

#[inline(always)]
fn by_words<S: Space, P: Pack>(rows: &[Sums<P>; LANES], affine: bool) -> SumsByWord<P> {
    let zero = P::splat(0.0);
    let mut sums = SumsByWord { value: [zero; 8], slope: [[zero; 8]; 3], arm: [[zero; 8]; 3] };
    for (value, row) in sums.value.iter_mut().zip(rows) {
        *value = row.value;
    }
    sums.value = P::transposed(sums.value);
    for axis in 0..S::DIMENSION {
        for (slope, row) in sums.slope[axis].iter_mut().zip(rows) {
            *slope = row.slope[axis];
        }
        sums.slope[axis] = P::transposed(sums.slope[axis]);
        if affine {
            for (arm, row) in sums.arm[axis].iter_mut().zip(rows) {
                *arm = row.arm[axis];
            }
            sums.arm[axis] = P::transposed(sums.arm[axis]);
        }
    }
    sums
}

/// Velocity and place, or the way there.
#[inline(always)]
fn move_points<S: Space, P: Pack>(
    taking: &Taking,
    value: &[P; NODE_WORDS],
    lanes: &mut Lanes<P>,
    beside: &mut [Beside<S>],
) {
    let dt = P::splat(taking.dt);
    for axis in 0..S::DIMENSION {
        let (velocity, change) = (value[axis], value[S::DIMENSION + axis]);
        let own = &mut lanes.0[Hot::<S>::VELOCITY + axis];
        *own = match taking.transfer {
            Transfer::Blend { flip } => (*own + change) * P::splat(flip) + velocity * P::splat(1.0 - flip),
            Transfer::Affine => velocity,
        };
        if taking.taken == Taken::Velocity {
            let way = (velocity * dt).numbers();
            for (beside, way) in beside.iter_mut().zip(way) {
                beside.way[axis] = way;
            }
        } else {
            let place = &mut lanes.0[Hot::<S>::POSITION + axis];
            *place = *place + velocity * dt;
        }
    }
}

/// The affine field about each point, by the second moments of its functions.
#[inline(always)]
fn take_affine<S: Space, P: Pack>(
    frame: &TileFrame<S>,
    basis: &Basis,
    arm: &[[P; NODE_WORDS]; 3],
    beside: &mut [Beside<S>],
) {
    let least = P::splat(MOMENT_LEAST * frame.cell * frame.cell);
    for along in 0..S::DIMENSION {
        let mut second = P::splat(0.0);
        for (value, moment) in basis.values[along].iter().zip(&basis.moments[along]) {
            let (value, moment) = (P::load(value), P::load(moment));
            // N (x_i - x)^2, without dividing where N is zero.
            let square = moment * moment / P::choose(value.above(P::splat(0.0)), value, P::splat(1.0));
            second = second + square;
        }
        let inverse = P::splat(1.0) / second.max(least);
        for (axis, arm) in arm[along].iter().enumerate().take(S::DIMENSION) {
            for (beside, number) in beside.iter_mut().zip((*arm * inverse).numbers()) {
                beside.affine[along * S::DIMENSION + axis] = number;
            }
        }
    }
}

/// Strain and stress, then the way that was kept.
#[inline(always)]
fn strain_points<S: Space, L: MaterialLaw<S>, P: Pack>(
    law: &L,
    taking: &Taking,
    (slope, mean): (&[[P; NODE_WORDS]; 3], P),
    lanes: &mut Lanes<P>,
    (beside, volumetric): (&[Beside<S>], &mut [Volumetric]),
) {
    let dt = P::splat(taking.dt);
    let mut gradient = S::TensorOf::<P>::zero();
    for (along, slope) in slope.iter().enumerate().take(S::DIMENSION) {
        for (axis, rate) in slope.iter().enumerate().take(S::DIMENSION) {
            gradient.set_word(along * S::DIMENSION + axis, *rate);
        }
    }
    if taking.taken == Taken::Strain {
        gradient = before_the_way::<S, P>(&gradient, dt);
    }
    let averaged = Averaged::of(mean, volumetric);
    if !volumetric.is_empty() {
        let rate = averaged.change * P::splat(1.0 / (S::DIMENSION as f64 * taking.dt));
        for axis in 0..S::DIMENSION {
            let diagonal = axis * (S::DIMENSION + 1);
            gradient.set_word(diagonal, gradient.word(diagonal) + rate);
        }
    }
    let first = Hot::<S>::DEFORMATION;
    let deformation: S::TensorOf<P> = lanes.words(first);
    let more = product::<S, P>(&gradient, &deformation);
    for entry in 0..S::Tensor::COMPONENTS {
        lanes.0[first + entry] = deformation.word(entry) + more.word(entry) * dt;
    }
    let memory = Hot::<S>::MEMORY;
    let before = lanes.words::<S::SymmetricOf<P>>(Hot::<S>::STRESS);
    let (words, work) = lanes.0[memory..].split_at_mut(S::PointMemory::WIDTH);
    let words = &mut words[..L::Memory::WIDTH];
    let flow = if volumetric.is_empty() { None } else { law.flow(words, &before) };
    let stress = law.update_lanes(&gradient, taking.dt, words, &mut work[0]);
    if let Some((before_flow, flow)) = flow.zip(law.flow(words, &stress)) {
        let traces = (before.trace() + stress.trace()) * P::splat(0.5 / S::DIMENSION as f64);
        averaged.leave(&(before_flow, flow), traces, volumetric);
    }
    lanes.set_words(Hot::<S>::STRESS, &stress);
    if taking.taken == Taken::StrainThenPlace {
        for axis in 0..S::DIMENSION {
            let mut way = [0.0; LANES];
            for (way, beside) in way.iter_mut().zip(beside) {
                *way = beside.way[axis];
            }
            let place = &mut lanes.0[Hot::<S>::POSITION + axis];
            *place = *place + P::load(&way);
        }
    }
}

/// How volume strains of eight points are averaged in a step.
#[derive(Clone, Copy)]
struct Averaged<P> {
    /// dtheta.
    change: P,
    lost: P,
}

impl<P: Pack> Averaged<P> {
    /// With the means of the nodes in reach; nothing where nothing is averaged.
    #[inline(always)]
    fn of(mean: P, volumetric: &[Volumetric]) -> Self {
        let (mut strain, mut flowing, mut lost) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (lane, point) in volumetric.iter().enumerate() {
            (strain[lane], flowing[lane], lost[lane]) = (point.strain, point.flowing, point.lost);
        }
        Self { change: P::load(&flowing) * (mean - P::load(&strain)), lost: P::load(&lost) }
    }

    /// Notes what the law made of it, under a mean stress in the middle of the step, Pa.
    #[inline(always)]
    fn leave(self, (before, after): &(Flow<P>, Flow<P>), pressure: P, volumetric: &mut [Volumetric]) {
        let mut rows = [[0.0; LANES]; 3];
        let lost = self.lost - pressure * self.change;
        for (row, number) in rows.iter_mut().zip([after.volume, flowing(before, after), lost]) {
            number.store(row);
        }
        for (lane, point) in volumetric.iter_mut().enumerate() {
            *point = Volumetric { strain: rows[0][lane], flowing: rows[1][lane], lost: rows[2][lane] };
        }
    }
}

/// Velocity gradient over the places that points have come from, `L (1 - L dt)^-1` for L over those where they are.
///
/// Stress that is updated first is strained by the velocity that has just carried the points. With L itself a turning body
/// would seem to grow by `(omega dt)^2` a step more than it does, and the work of its stress against that would be energy
/// from nowhere.
#[inline(always)]
fn before_the_way<S: Space, P: Pack>(gradient: &S::TensorOf<P>, dt: P) -> S::TensorOf<P> {
    let mut back = gradient.scaled(-dt);
    for axis in 0..S::DIMENSION {
        let diagonal = axis * (S::DIMENSION + 1);
        back.set_word(diagonal, back.word(diagonal) + P::splat(1.0));
    }
    product::<S, P>(gradient, &S::inverse_of(&back))
}

/// `a b`, column by column.
#[inline(always)]
fn product<S: Space, P: Pack>(a: &S::TensorOf<P>, b: &S::TensorOf<P>) -> S::TensorOf<P> {
    let mut product = *b;
    for column in 0..S::DIMENSION {
        for row in 0..S::DIMENSION {
            let entry = |inner: usize| a.word(inner * S::DIMENSION + row) * b.word(column * S::DIMENSION + inner);
            let mut sum = entry(0);
            for inner in 1..S::DIMENSION {
                sum = sum + entry(inner);
            }
            product.set_word(column * S::DIMENSION + row, sum);
        }
    }
    product
}

/// The farther of two; infinity where the second is no number.
#[inline(always)]
fn farther<P: Pack>(so_far: P, another: P) -> P {
    let infinity = P::splat(f64::INFINITY);
    let another = P::choose(infinity.above(another), another, infinity);
    P::choose(another.above(so_far), another, so_far)
}

/// How far out of the block each point is, m; negative inside.
#[inline(always)]
fn outside_of<S: Space, P: Pack>(frame: &TileFrame<S>, lanes: &Lanes<P>) -> P {
    let place: S::VectorOf<P> = frame.place(&lanes.words(Hot::<S>::POSITION));
    let mut outside = P::splat(f64::NEG_INFINITY);
    for axis in 0..S::DIMENSION {
        let ([lower, upper], place) = (frame.inside[axis], place.word(axis));
        outside = farther(farther(outside, P::splat(lower) - place), place - P::splat(upper));
    }
    outside * P::splat(frame.cell)
}

/// Records of grains, what ties them, and where the last exchange predicted them to be now, m.
type Tied<'a, S> = (&'a mut [GrainHot<S>], &'a mut [PenaltySpring<S>], &'a mut [<S as Space>::Vector]);

/// Correction of those grains of the block that take part, by their `rows` there: `v += sum N lambda_i/m_i`, and what their penalty
/// springs do until the next exchange; `predicted` is where the last one expected grains to be now, where steps of `dt`, s, lie between. Spin is left alone.
pub fn correct_grains<S: Space>(
    (frame, instructions): (&TileFrame<S>, Instructions),
    (tile, penalty, dt): (&[GrainChange<S>], &Penalty, f64),
    rows: &[u32],
    (hot, springs, predicted): Tied<'_, S>,
) {
    instructions.run(Correct { frame, tile, penalty, dt, rows, hot, springs, predicted });
}

struct Correct<'a, S: Space> {
    frame: &'a TileFrame<S>,
    tile: &'a [GrainChange<S>],
    penalty: &'a Penalty,
    dt: f64,
    rows: &'a [u32],
    hot: &'a mut [GrainHot<S>],
    springs: &'a mut [PenaltySpring<S>],
    predicted: &'a mut [S::Vector],
}

impl<S: Space> Packed for Correct<'_, S> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        let Self { frame, tile, penalty, dt, rows, hot, springs, predicted } = self;
        let per_time = penalty.part() / dt;
        let (mut basis, mut changes) = (Basis::zero(), [[0.0; NODE_WORDS]; LANES]);
        for rows in rows.chunks(LANES) {
            basis.set_of_grains::<S, P>(frame, hot, rows);
            P::enter(SumChanges::<S, P> {
                basis: &basis,
                edge: frame.edge,
                tile,
                changes: &mut changes[..rows.len()],
                pack: std::marker::PhantomData,
            });
            for (row, change) in rows.iter().zip(&changes) {
                let (hot, spring) = (&mut hot[*row as usize], &mut springs[*row as usize]);
                let change = GrainChange::<S>::of(*change);
                hot.velocity += change.velocity();
                let (share, mut prediction_error) = (change.share(), S::Vector::zero());
                if let Some(predicted) = predicted.get_mut(*row as usize) {
                    prediction_error = share.of(&((hot.position - *predicted) * per_time));
                    *predicted = Penalty::predicted::<S>(&hot.position, &hot.velocity, penalty.interval, dt);
                }
                let slip = share.of(&hot.velocity) - change.shared();
                *spring = penalty.after(spring, hot.mass, (&slip, &prediction_error), &share);
            }
        }
    }
}

/// What the nodes in reach of up to eight grains give back to each.
struct SumChanges<'a, S: Space, P> {
    basis: &'a Basis,
    edge: usize,
    tile: &'a [GrainChange<S>],
    changes: &'a mut [[f64; NODE_WORDS]],
    pack: std::marker::PhantomData<P>,
}

impl<S: Space, P: Pack> Kernel<P> for SumChanges<'_, S, P> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { basis, edge, tile, changes, .. } = self;
        for (lane, change) in changes.iter_mut().enumerate() {
            let mut sum = P::splat(0.0);
            for k in 0..Stencil::<S, P, 3>::LAYERS {
                for j in 0..3 {
                    let first = basis.first[lane] + row(edge, j, k);
                    for (i, node) in tile[first..first + 3].iter().enumerate() {
                        sum = sum + P::load(&node.0) * P::splat(basis.product::<S>([i, j, k], lane));
                    }
                }
            }
            sum.store(change);
        }
    }
}
