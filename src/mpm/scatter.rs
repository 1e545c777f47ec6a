//! Points and grains to the tile of their block.

use crate::base::ids::Row;
use crate::base::lane::{Instructions, Kernel, LANES, Pack, Packed, Real};
use crate::base::numbers::Lanes;
use crate::base::space::{Linear, Space, Words};
use crate::base::symmetric::Symmetric;
use crate::dem::grains::{Hot as GrainHot, PenaltySpring};
use crate::mpm::points::{Beside, Hot};
use crate::mpm::scheme::ShapeFunction;
use crate::mpm::shape::{Axis, Cubic, Generalised, LinearHat, Quadratic, Shape, Stencil, row};
use crate::mpm::tile::{Gathered, GrainNode, NODE_WORDS};
use crate::mpm::volumetric::{Volumetric, VolumetricNode};

/// One block's tile: where its first node lies, and how a place is measured in it.
#[derive(Clone, Copy, Debug)]
pub struct TileFrame<S: Space> {
    /// Place of the tile's first node, m.
    pub corner: S::Vector,
    /// Edge of a cell, m, and its inverse.
    pub cell: f64,
    /// 1/m.
    pub cell_inverse: f64,
    /// Nodes per axis.
    pub edge: usize,
    /// Where the block itself begins and ends along each axis, or a wall lets nothing through, in cells from the tile's first
    /// node; a point may come farther by [`crate::mpm::shape::DRIFT_MAX`].
    pub inside: [[f64; 2]; 3],
    /// Walls along each axis, and half of a point's edge.
    pub axes: [Axis; 3],
}

impl<S: Space> TileFrame<S> {
    /// Places in cells from the tile's first node.
    #[inline(always)]
    pub fn place<R: Real>(&self, position: &S::VectorOf<R>) -> S::VectorOf<R> {
        let mut place = *position;
        for axis in 0..S::DIMENSION {
            let from_corner = position.word(axis) - R::splat(self.corner[axis]);
            place.set_word(axis, from_corner * R::splat(self.cell_inverse));
        }
        place
    }

    /// The functions of `F` at a place, m.
    #[inline(always)]
    pub fn stencil<F: Shape<N>, const N: usize>(&self, position: &S::Vector) -> Stencil<S, f64, N> {
        let mut single = S::VectorOf::<f64>::zero();
        for axis in 0..S::DIMENSION {
            single.set_word(axis, position[axis]);
        }
        Stencil::new::<F>(&self.place(&single), &self.axes, self.cell_inverse)
    }
}

/// Most functions in reach along an axis.
const REACH_MAX: usize = 4;

/// Stencils of eight points, laid out so that a point's numbers can be spread over the words of a node. One stands ready
/// for all groups of a block. Eight numbers fill a line of the cache: across two of them they would be stored and read in
/// halves, wherever the stack happens to begin.
#[repr(align(64))]
pub struct Basis {
    /// First node in reach of each.
    pub first: [usize; LANES],
    /// Functions, their slopes (1/m), and where the field is affine their first moments about the point (m), along each
    /// axis.
    pub values: [[[f64; LANES]; REACH_MAX]; 3],
    /// dN/dx along each axis, 1/m.
    pub slopes: [[[f64; LANES]; REACH_MAX]; 3],
    /// N (x_i - x) along each axis, m; set where the field is affine alone.
    pub moments: [[[f64; LANES]; REACH_MAX]; 3],
}

impl Basis {
    /// To be filled by [`Self::set`].
    pub const fn zero() -> Self {
        let none = [[[0.0; LANES]; REACH_MAX]; 3];
        Self { first: [0; LANES], values: none, slopes: none, moments: none }
    }

    /// Takes the functions of a job at eight places, in cells from the tile's first node.
    #[inline(always)]
    pub fn set<S: Space, P: Pack>(
        &mut self,
        frame: &TileFrame<S>,
        (shape, affine): (ShapeFunction, bool),
        place: S::VectorOf<P>,
    ) {
        macro_rules! with {
            ($shape:ty, $nodes:literal) => {
                P::enter(SetBasis::<S, P, $shape, $nodes> {
                    basis: self,
                    frame,
                    affine,
                    place,
                    shape: std::marker::PhantomData,
                })
            };
        }
        match shape {
            ShapeFunction::Linear => with!(LinearHat, 3),
            ShapeFunction::Generalised => with!(Generalised, 3),
            ShapeFunction::Quadratic => with!(Quadratic, 3),
            ShapeFunction::Cubic => with!(Cubic, 4),
        }
    }

    /// Takes the functions that grains have at the places of up to eight of these rows.
    #[inline(always)]
    pub fn set_of_grains<S: Space, P: Pack>(&mut self, frame: &TileFrame<S>, hot: &[GrainHot<S>], rows: &[u32]) {
        let mut places = [[0.0; LANES]; 3];
        for (lane, row) in eight_of(rows).into_iter().enumerate() {
            let position = &hot[*row as usize].position;
            for (axis, places) in places.iter_mut().enumerate().take(S::DIMENSION) {
                places[lane] = position[axis];
            }
        }
        let mut place = S::VectorOf::<P>::zero();
        for (axis, places) in places.iter().enumerate().take(S::DIMENSION) {
            place.set_word(axis, P::load(places));
        }
        self.set::<S, P>(frame, (ShapeFunction::Quadratic, false), frame.place(&place));
    }

    /// The function of a node of the stencil at one of the places.
    #[inline(always)]
    pub fn product<S: Space>(&self, node: [usize; 3], lane: usize) -> f64 {
        let along = |axis: usize| self.values[axis][node[axis]][lane];
        let product = along(0) * along(1);
        if S::DIMENSION == 3 { product * along(2) } else { product }
    }

    /// A number of one of the points, in every lane.
    #[inline(always)]
    pub fn value<P: Pack>(&self, axis: usize, node: usize, lane: usize) -> P {
        P::splat(self.values[axis][node][lane])
    }
    /// The same of slopes, 1/m.
    #[inline(always)]
    pub fn slope<P: Pack>(&self, axis: usize, node: usize, lane: usize) -> P {
        P::splat(self.slopes[axis][node][lane])
    }
    /// The same of first moments, m; set where the field is affine.
    #[inline(always)]
    pub fn moment<P: Pack>(&self, axis: usize, node: usize, lane: usize) -> P {
        P::splat(self.moments[axis][node][lane])
    }
}

struct SetBasis<'a, S: Space, P: Pack, F, const N: usize> {
    basis: &'a mut Basis,
    frame: &'a TileFrame<S>,
    affine: bool,
    place: S::VectorOf<P>,
    shape: std::marker::PhantomData<F>,
}

impl<S: Space, P: Pack, F: Shape<N>, const N: usize> Kernel<P> for SetBasis<'_, S, P, F, N> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { basis, frame, affine, place, .. } = self;
        let stencil = Stencil::<S, P, N>::new::<F>(&place, &frame.axes, frame.cell_inverse);
        // A whole number below 2^32 beside 2^52 stands in the low bits, and needs no check of what it may be.
        let whole = (stencil.first(frame.edge) + P::splat(4_503_599_627_370_496.0)).numbers();
        for (first, whole) in basis.first.iter_mut().zip(whole) {
            *first = whole.to_bits() as u32 as usize;
        }
        for axis in 0..S::DIMENSION {
            for node in 0..N {
                stencil.values[axis][node].store(&mut basis.values[axis][node]);
                stencil.slopes[axis][node].store(&mut basis.slopes[axis][node]);
                if affine {
                    let arm = (stencil.base[axis] + P::splat(node as f64) - place.word(axis)) * P::splat(frame.cell);
                    (stencil.values[axis][node] * arm).store(&mut basis.moments[axis][node]);
                }
            }
        }
    }
}

/// The records of up to eight rows; behind the last of fewer it stands again, to be left unused.
#[inline(always)]
pub fn eight_of<T>(rows: &[T]) -> [&T; LANES] {
    std::array::from_fn(|lane| &rows[lane.min(rows.len() - 1)])
}

/// What the block's points bring, weighted, to a tile that has been cleared: `m_i = sum w m N_i`, `p_i = sum w m v N_i`, with
/// the affine field `p_i = sum w m (v + C (x_i - x)) N_i`, and `f_i = -sum w V0 tau grad N_i`; where volume strain is averaged, the sums
/// of [`crate::mpm::volumetric`] as well.
pub fn scatter_points<S: Space>(
    frame: &TileFrame<S>,
    (shape, affine, instructions): (ShapeFunction, bool, Instructions),
    points: Scattered<S>,
    (tile, volumetric): (&mut [Gathered<S>], &mut [VolumetricNode]),
) {
    instructions.run(Scatter { frame, shape, affine, points, tile, volumetric });
}

/// The points of a block. What is beside them stands empty where the scheme needs nothing of it.
#[derive(Clone, Copy)]
pub struct Scattered<'a, S: Space> {
    /// In the order of rows.
    pub points: &'a [Hot<S>],
    /// Affine fields: one for every point, or none.
    pub beside: &'a [Beside<S>],
    /// One for every point, or none where volume strain is not averaged.
    pub volumetric: &'a [Volumetric],
}

struct Scatter<'a, S: Space> {
    frame: &'a TileFrame<S>,
    shape: ShapeFunction,
    affine: bool,
    points: Scattered<'a, S>,
    tile: &'a mut [Gathered<S>],
    volumetric: &'a mut [VolumetricNode],
}

impl<S: Space> Packed for Scatter<'_, S> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        let Self { frame, shape, affine, points: Scattered { points, beside, volumetric }, tile, .. } = self;
        let (mut lanes, mut basis) = (Lanes::<P>::zero(), Basis::zero());
        let mut shares = [Share::<P>::zero(); LANES];
        for (group, points) in points.chunks(LANES).enumerate() {
            lanes.load(&eight_of(points), Hot::<S>::DEFORMATION);
            basis.set::<S, P>(frame, (shape, affine), frame.place(&lanes.words(Hot::<S>::POSITION)));
            set_shares::<S, P>(&lanes, &mut shares);
            if affine {
                set_arms::<S, P>(&lanes, &beside[group * LANES..][..points.len()], &mut shares);
            }
            let (basis, shares, edge) = (&basis, &shares[..points.len()], frame.edge);
            match (shape, affine) {
                (ShapeFunction::Cubic, false) => P::enter(Add::<S, P, 4, false> { basis, shares, edge, tile }),
                (ShapeFunction::Cubic, true) => P::enter(Add::<S, P, 4, true> { basis, shares, edge, tile }),
                (_, false) => P::enter(Add::<S, P, 3, false> { basis, shares, edge, tile }),
                (_, true) => P::enter(Add::<S, P, 3, true> { basis, shares, edge, tile }),
            }
            if volumetric.is_empty() {
                continue;
            }
            let volumetric = &volumetric[group * LANES..][..points.len()];
            if volumetric.iter().all(|point| point.flowing <= 0.0) {
                continue;
            }
            let shares = volumes(points, volumetric);
            let (shares, tile, pack) = (&shares[..points.len()], &mut *self.volumetric, std::marker::PhantomData);
            match shape {
                ShapeFunction::Cubic => P::enter(AddVolumes::<S, P, 4> { basis, shares, edge, tile, pack }),
                _ => P::enter(AddVolumes::<S, P, 3> { basis, shares, edge, tile, pack }),
            }
        }
    }
}

/// `q` and `q theta` of up to eight points.
#[inline(always)]
fn volumes<S: Space>(points: &[Hot<S>], volumetric: &[Volumetric]) -> [[f64; 2]; LANES] {
    let mut shares = [[0.0; 2]; LANES];
    for ((share, point), volumetric) in shares.iter_mut().zip(points).zip(volumetric) {
        let flowing = point.weight * point.mass * volumetric.flowing;
        *share = [flowing, flowing * volumetric.strain];
    }
    shares
}

/// [`VolumetricNode`]s of the nodes in reach of up to eight points.
struct AddVolumes<'a, S: Space, P, const N: usize> {
    basis: &'a Basis,
    shares: &'a [[f64; 2]],
    edge: usize,
    tile: &'a mut [VolumetricNode],
    pack: std::marker::PhantomData<(S, P)>,
}

impl<S: Space, P: Pack, const N: usize> Kernel<P> for AddVolumes<'_, S, P, N> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { basis, shares, edge, tile, .. } = self;
        for (lane, [flowing, volume]) in shares.iter().enumerate() {
            let along: [f64; N] = std::array::from_fn(|node| basis.values[0][node][lane]);
            for k in 0..Stencil::<S, P, N>::LAYERS {
                for j in 0..N {
                    let mut value = basis.values[1][j][lane];
                    if S::DIMENSION == 3 {
                        value *= basis.values[2][k][lane];
                    }
                    let (flowing, volume) = (flowing * value, volume * value);
                    let first = basis.first[lane] + row(edge, j, k);
                    for (node, along) in tile[first..first + N].iter_mut().zip(&along) {
                        node.0[0] += flowing * along;
                        node.0[1] += volume * along;
                    }
                }
            }
        }
    }
}

/// What a point brings to a node, word by word of [`Gathered`].
#[derive(Clone, Copy)]
struct Share<P> {
    /// Per N, and per component of grad N and of N (x_i - x).
    value: P,
    slope: [P; 3],
    arm: [P; 3],
}

/// The shares of eight points in step, without those of affine fields.
#[inline(always)]
fn set_shares<S: Space, P: Pack>(lanes: &Lanes<P>, shares: &mut [Share<P>; LANES]) {
    let zero = P::splat(0.0);
    let at = |number: usize| lanes.0[number];
    let weight = at(Hot::<S>::WEIGHT);
    let mass = weight * at(Hot::<S>::MASS);
    let (mut value, mut slope) = ([zero; NODE_WORDS], [[zero; NODE_WORDS]; 3]);
    value[0] = mass;
    for axis in 0..S::DIMENSION {
        value[1 + axis] = at(Hot::<S>::VELOCITY + axis) * mass;
    }
    let stress = lanes.words::<S::SymmetricOf<P>>(Hot::<S>::STRESS) * -(weight * at(Hot::<S>::VOLUME));
    let stress = stress.tensor();
    for (along, slope) in slope.iter_mut().enumerate().take(S::DIMENSION) {
        for axis in 0..S::DIMENSION {
            slope[1 + S::DIMENSION + axis] = stress.word(along * S::DIMENSION + axis);
        }
    }
    for (share, value) in shares.iter_mut().zip(P::transposed(value)) {
        share.value = value;
    }
    for axis in 0..S::DIMENSION {
        for (share, slope) in shares.iter_mut().zip(P::transposed(slope[axis])) {
            share.slope[axis] = slope;
        }
    }
}

#[inline(always)]
fn set_arms<S: Space, P: Pack>(lanes: &Lanes<P>, beside: &[Beside<S>], shares: &mut [Share<P>; LANES]) {
    let mass = lanes.0[Hot::<S>::WEIGHT] * lanes.0[Hot::<S>::MASS];
    for along in 0..S::DIMENSION {
        let mut arm = [P::splat(0.0); NODE_WORDS];
        for axis in 0..S::DIMENSION {
            let mut affine = [0.0; LANES];
            for (affine, beside) in affine.iter_mut().zip(beside) {
                *affine = beside.affine[along * S::DIMENSION + axis];
            }
            arm[1 + axis] = P::load(&affine) * mass;
        }
        for (share, arm) in shares.iter_mut().zip(P::transposed(arm)) {
            share.arm[along] = arm;
        }
    }
}

/// Shares of points to every node in reach, point by point: axis by axis, so that a node takes two products and not one
/// per axis.
struct Add<'a, S: Space, P, const N: usize, const AFFINE: bool> {
    basis: &'a Basis,
    shares: &'a [Share<P>],
    edge: usize,
    tile: &'a mut [Gathered<S>],
}

impl<S: Space, P: Pack, const N: usize, const AFFINE: bool> Kernel<P> for Add<'_, S, P, N, AFFINE> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { basis, shares, edge, tile } = self;
        for (lane, share) in shares.iter().enumerate() {
            for k in 0..Stencil::<S, P, N>::LAYERS {
                let layer = if S::DIMENSION == 3 { share.along::<AFFINE>(basis, 2, k, lane) } else { *share };
                for j in 0..N {
                    let along = layer.along::<AFFINE>(basis, 1, j, lane);
                    let first = basis.first[lane] + row(edge, j, k);
                    for (i, node) in tile[first..first + N].iter_mut().enumerate() {
                        let more = along.along::<AFFINE>(basis, 0, i, lane).value;
                        (P::load(&node.0) + more).store(&mut node.0);
                    }
                }
            }
        }
    }
}

impl<P: Pack> Share<P> {
    #[inline(always)]
    fn zero() -> Self {
        let zero = P::splat(0.0);
        Self { value: zero, slope: [zero; 3], arm: [zero; 3] }
    }

    /// What is left of a share with function `node` along an axis in hand.
    #[inline(always)]
    fn along<const AFFINE: bool>(&self, basis: &Basis, axis: usize, node: usize, lane: usize) -> Self {
        let value: P = basis.value(axis, node, lane);
        let mut left = *self;
        left.value = self.value * value + self.slope[axis] * basis.slope(axis, node, lane);
        if AFFINE {
            left.value = left.value + self.arm[axis] * basis.moment(axis, node, lane);
        }
        for other in 0..axis {
            left.slope[other] = self.slope[other] * value;
            if AFFINE {
                left.arm[other] = self.arm[other] * value;
            }
        }
        left
    }
}

/// Forces from without on the block's points to the nodes: `f_i += sum N_i t`. `first` is the block's first row.
pub fn scatter_loads<S: Space>(
    frame: &TileFrame<S>,
    shape: ShapeFunction,
    (points, first): (&[Hot<S>], usize),
    loaded: &[(Row, S::Vector)],
    tile: &mut [Gathered<S>],
) {
    for (row, push) in loaded {
        let position = &points[*row as usize - first].position;
        macro_rules! with {
            ($shape:ty, $nodes:literal) => {
                frame
                    .stencil::<$shape, $nodes>(position)
                    .for_each(frame.edge, |node, value| tile[node].add_force(&(*push * value)))
            };
        }
        match shape {
            ShapeFunction::Linear => with!(LinearHat, 3),
            ShapeFunction::Generalised => with!(Generalised, 3),
            ShapeFunction::Quadratic => with!(Quadratic, 3),
            ShapeFunction::Cubic => with!(Cubic, 4),
        }
    }
}

/// What those grains of the block that take part bring, by their `rows` there, rising, at their positions before the step, and with it what their
/// penalty springs have given them since the last exchange, where this is one and `springs` are there.
pub fn scatter_grains<S: Space>(
    (frame, instructions): (&TileFrame<S>, Instructions),
    rows: &[u32],
    (hot, springs): (&[GrainHot<S>], Option<&[PenaltySpring<S>]>),
    tile: &mut [GrainNode<S>],
) {
    instructions.run(ScatterGrains { frame, rows, hot, springs, tile });
}

struct ScatterGrains<'a, S: Space> {
    frame: &'a TileFrame<S>,
    rows: &'a [u32],
    hot: &'a [GrainHot<S>],
    springs: Option<&'a [PenaltySpring<S>]>,
    tile: &'a mut [GrainNode<S>],
}

impl<S: Space> Packed for ScatterGrains<'_, S> {
    type Outcome = ();

    #[inline(always)]
    fn run<P: Pack>(self) {
        let Self { frame, rows, hot, springs, tile } = self;
        let mut basis = Basis::zero();
        for rows in rows.chunks(LANES) {
            basis.set_of_grains::<S, P>(frame, hot, rows);
            P::enter(AddGrains::<S, P> {
                basis: &basis,
                edge: frame.edge,
                rows,
                hot,
                springs,
                tile,
                pack: std::marker::PhantomData,
            });
        }
    }
}

/// Up to eight grains to every node in reach, grain by grain.
struct AddGrains<'a, S: Space, P> {
    basis: &'a Basis,
    edge: usize,
    rows: &'a [u32],
    hot: &'a [GrainHot<S>],
    springs: Option<&'a [PenaltySpring<S>]>,
    tile: &'a mut [GrainNode<S>],
    pack: std::marker::PhantomData<P>,
}

impl<S: Space, P: Pack> Kernel<P> for AddGrains<'_, S, P> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { basis, edge, rows, hot, springs, tile, .. } = self;
        for (lane, row_of_grain) in rows.iter().enumerate() {
            let row_of_grain = *row_of_grain as usize;
            let hot = &hot[row_of_grain];
            let given = springs.map_or(S::Vector::zero(), |springs| springs[row_of_grain].given);
            let mass = hot.weight * hot.mass;
            let brought = GrainNode::<S>::new(mass, &(hot.velocity * mass), &(given * mass));
            let brought = P::load(&brought.0);
            for k in 0..Stencil::<S, P, 3>::LAYERS {
                for j in 0..3 {
                    let first = basis.first[lane] + row(edge, j, k);
                    for (i, node) in tile[first..first + 3].iter_mut().enumerate() {
                        let value = P::splat(basis.product::<S>([i, j, k], lane));
                        (P::load(&node.0) + brought * value).store(&mut node.0);
                    }
                }
            }
        }
    }
}
