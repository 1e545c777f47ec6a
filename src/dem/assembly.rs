//! Grains in a cell: what they are, what they touch, and how far they have come since their lists were made.

use crate::base::space::Space;
use crate::dem::cell::Cell;
use crate::dem::contacts::Contacts;
use crate::dem::grains::Grains;
use crate::dem::walls::Walls;

/// An assembly of grains with the contacts between them.
pub struct Assembly<S: Space> {
    pub cell: Cell<S>,
    /// The cell at the last rebuild of the lists.
    pub(crate) cell_home: Cell<S>,
    pub grains: Grains<S>,
    pub contacts: Contacts<S>,
    /// Contacts of grains with bodies.
    pub walls: Walls<S>,
    /// Largest radius of any grain, m; in a world that of all ranks.
    pub radius_max: f64,
    /// The longest way that a grain has come from home, m.
    pub(crate) moved: f64,
    /// Whether forces of contacts will be asked for after the coming step.
    pub forces_wanted: bool,
}

impl<S: Space> Assembly<S> {
    /// A cell without grains.
    pub fn empty(cell: Cell<S>) -> Self {
        Self {
            cell,
            cell_home: cell,
            grains: Grains::default(),
            contacts: Contacts::new(&cell),
            walls: Walls::default(),
            radius_max: 0.0,
            moved: 0.0,
            forces_wanted: false,
        }
    }
}
