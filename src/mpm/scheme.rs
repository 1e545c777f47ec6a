//! How points and nodes exchange what they carry: the choices of a job.

/// How points and nodes exchange what they carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    pub shape: ShapeFunction,
    pub update: StressUpdate,
    pub transfer: Transfer,
    /// Points per cell and axis at the start.
    pub points_per_cell: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeFunction {
    /// Hats over one cell to each side.
    Linear,
    /// Hats averaged over a point's box, whose edges keep their length (uGIMP; Bardenhagen & Kober 2004).
    Generalised,
    /// Quadratic B-splines, changed beside walls so that their sum stays 1.
    Quadratic,
    /// Cubic B-splines, the same.
    Cubic,
}

impl ShapeFunction {
    /// The most that `sum (dN/dx)^2/N` along an axis comes to anywhere, in cells: `2/half + 1/(1 - half)` of uGIMP with points
    /// of half a length `half`. What a node with next to no mass makes of a stress is bounded by it; hats have no bound, for
    /// where one vanishes its slope does not.
    pub fn steepness(self, points_per_cell: usize) -> f64 {
        let half = 0.5 / points_per_cell as f64;
        match self {
            Self::Linear => f64::INFINITY,
            Self::Generalised => 2.0 / half + 1.0 / (1.0 - half),
            Self::Quadratic => 6.0,
            Self::Cubic => 3.136_82,
        }
    }

    /// Distance along an axis within which two points with edges of that length share a node, both in cells.
    pub fn reach(self, edge: f64) -> f64 {
        match self {
            Self::Linear => 2.0,
            Self::Generalised => 2.0 + edge,
            Self::Quadratic => 3.0,
            Self::Cubic => 4.0,
        }
    }
}

/// When in a step stresses follow the strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StressUpdate {
    /// Before the forces, from the velocities that points brought to the nodes (USF).
    First,
    /// After the nodes have moved, from their velocities (USL).
    Last,
    /// After them, from the new velocities of points brought to the nodes once more (MUSL).
    ModifiedLast,
}

/// What a point takes from the nodes' velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// The share `flip` (0 to 1) by increments (FLIP), the rest by values (PIC). Liang & Zhao (2019), eq. 17 to 19, call
    /// 1 - flip alpha_PIC.
    Blend { flip: f64 },
    /// Values with their affine field (APIC).
    Affine,
}

impl Scheme {
    /// Whether a node's own new velocity becomes strain, or the affine field of a point, before points have averaged it: then
    /// one with next to no mass must not gain too much of it within a step.
    pub fn feels_nodes(&self) -> bool {
        self.update == StressUpdate::Last || self.transfer == Transfer::Affine
    }
}
