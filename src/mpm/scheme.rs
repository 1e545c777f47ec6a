//! How points and nodes exchange what they carry: the choices of a job.

use crate::base::keys::{Description, Form, RATIO, Range, Table, choose, count, flag, number, size, text, variant};

/// How points and nodes exchange what they carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Of points and vertices of membranes; grains have quadratic B-splines whatever it is.
    pub shape: ShapeFunction,
    /// The key `update`.
    pub update: StressUpdate,
    /// Of velocities from nodes to points, and to vertices of membranes.
    pub transfer: Transfer,
    /// Points per cell and axis at the start.
    pub points_per_cell: usize,
    /// Whether volume strain is averaged over nodes where material flows, see [`crate::mpm::volumetric`].
    pub averages_volume: bool,
}

/// Functions of the nodes: a product of one along each axis ([`crate::mpm::shape`]).
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
    Blend {
        /// Share of increments, 0 (PIC) to 1 (FLIP).
        flip: f64,
    },
    /// Values with their affine field (APIC).
    Affine,
}

impl ShapeFunction {
    /// As they are written in a job.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("linear", Self::Linear),
        ("generalised", Self::Generalised),
        ("quadratic", Self::Quadratic),
        ("cubic", Self::Cubic),
    ];

    /// As it is written in a job.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, of)| *of == self).map(|(name, _)| *name).expect("every shape has a name")
    }
}

/// Share of FLIP by default.
const FLIP: &str = "0.99";

impl Scheme {
    /// Of `[scheme]` where a job says nothing else.
    pub const DEFAULT: Self = Self {
        shape: ShapeFunction::Quadratic,
        update: StressUpdate::Last,
        transfer: Transfer::Blend { flip: 0.99 },
        points_per_cell: 2,
        averages_volume: true,
    };

    /// `[scheme]`.
    pub fn table() -> Table {
        let about = "how points and nodes exchange what they carry";
        Description::of("scheme", about, false, |form| Self::DEFAULT.clone().keys(form))
    }

    /// The keys of `[scheme]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let shapes = "the shape functions: linear, generalised, quadratic or cubic";
        let key = text("shape", shapes, "\"quadratic\"").or("quadratic");
        choose(form, &mut self.shape, "shape function", key, &ShapeFunction::NAMES);
        let key =
            text("update", "when stresses follow the strain: first, last or modified_last", "\"last\"").or("last");
        let updates = [
            ("first", StressUpdate::First),
            ("last", StressUpdate::Last),
            ("modified_last", StressUpdate::ModifiedLast),
        ];
        choose(form, &mut self.update, "time to update stress", key, &updates);
        let key = text("transfer", "what points take from the nodes: blend or affine", "\"blend\"").or("blend");
        let kinds = [("blend", Transfer::Blend { flip: 0.99 }), ("affine", Transfer::Affine)];
        variant(form, &mut self.transfer, "transfer", key, &kinds, |transfer, form| {
            let Transfer::Blend { flip } = transfer else { return };
            let about = "the share of increments in the velocity update, 0 (PIC) to 1 (FLIP)";
            form.number(flip, number("flip", about, RATIO, Range::closed(0.0, 1.0), "0.99").or(FLIP));
        });
        let key = count("points_per_cell", "points per cell and axis", (1, 16), "2").or("2");
        size(form, &mut self.points_per_cell, key);
        let about = "whether volume strain is averaged over nodes where material flows, so that stresses of single points are no noise";
        form.flag(&mut self.averages_volume, flag("volume_averaging", about, "false").or("true"));
    }

    /// Whether a node's own new velocity becomes strain, or the affine field of a point, before points have averaged it: then
    /// one with next to no mass must not gain too much of it within a step.
    pub fn feels_nodes(&self) -> bool {
        self.update == StressUpdate::Last || self.transfer == Transfer::Affine
    }
}
