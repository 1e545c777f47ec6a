//! Points, the tiles of nodes that they meet on, and membranes among them.

use crate::base::space::Space;
use crate::mpm::membrane::Membranes;
use crate::mpm::points::Points;
use crate::mpm::scatter::TileFrame;
use crate::mpm::tile::Tiles;

/// A continuum of points.
pub struct Continuum<S: Space> {
    /// Of this rank.
    pub points: Points<S>,
    /// Nodes of this rank's blocks with their margins.
    pub tiles: Tiles<S>,
    /// Where each tile is.
    pub frames: Vec<TileFrame<S>>,
    /// Membranes, all of them on every rank.
    pub membranes: Membranes<S>,
    /// How far a point is out of its block along an axis, at most, by the tier of its tile, m.
    pub(crate) points_outside: [f64; 2],
}

impl<S: Space> Continuum<S> {
    /// Membranes without points.
    pub fn empty(membranes: Membranes<S>) -> Self {
        Self {
            points: Points::default(),
            tiles: Tiles::default(),
            frames: Vec::new(),
            membranes,
            points_outside: [0.0; 2],
        }
    }
}
