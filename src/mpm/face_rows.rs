//! Node rows of bodies that meet points at their own face: laid as [`crate::mpm::tile::Tiles`], worked on in the tiles near faces alone.

use std::ops::Range;
use std::sync::Arc;

use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::mpm::askew::{AskewRows, Outline};
use crate::mpm::faces::{Brought, ColumnNode, FaceSet, Link, SIDES};
use crate::mpm::tile::Mosaic;

/// A node that faces act on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met<S: Space> {
    /// See [`ColumnNode::velocities`], as faces have left them so far.
    pub velocities: [S::Vector; 2],
    /// Of what moves with it, kg; zero without points.
    pub mass: f64,
    /// Time over which forces have acted, s.
    pub dt: f64,
    /// Whether faces in line with the grid act on it, and such as are askew to it.
    pub by: [bool; 2],
    /// What the face on each side gave it in the last step, N s.
    pub impulses: [S::Vector; SIDES],
}

impl<S: Space> Met<S> {
    /// As it is before any face acts: m/s, kg, and s that forces have acted for.
    pub fn untouched(velocities: [S::Vector; 2], mass: f64, dt: f64) -> Self {
        Self { velocities, mass, dt, by: [false; 2], impulses: [S::Vector::zero(); SIDES] }
    }
}

/// Whether a body acts at its face on a node that is met so ([`Met::by`]), and does not hold it as well.
pub fn is_met_by<S: Space>(by: [bool; 2], body: &Body<S>) -> bool {
    body.meets_points && by[usize::from(body.is_askew())]
}

/// Impulses for the velocity to be held and for that by which parting is judged, N s.
pub type Impulses<S> = [<S as Space>::Vector; 2];

/// For each side, and behind them for all askew faces together, whether another acts on any node that it acts on, or itself; in the last row whether any of
/// these nodes has grains. Counts, to be added over ranks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Acting(pub [[i64; SIDES + 1]; SIDES + 2]);

impl Acting {
    fn with_grains(&self, side: usize) -> bool {
        self.0[SIDES + 1][side] > 0
    }

    fn together(&self, side: usize, other: usize) -> bool {
        self.0[side][other] > 0
    }
}

/// A column of a face ([`FaceSet::column`]).
#[derive(Clone, Debug)]
pub struct Column {
    /// Of the face: 2 axis, and one more where it is the upper of the axis.
    pub side: usize,
    /// Its face, by number.
    pub face: usize,
    /// Where its nodes lie among [`FaceRows::links`].
    links: Range<usize>,
}

/// Empty where no body meets points.
#[derive(Clone, Debug)]
pub struct FaceRows<S: Space> {
    /// None until faces have been placed.
    pub set: Option<FaceSet>,
    /// Sides that material is in front of, in the order in which they act; the same on every rank.
    pub sides: Vec<usize>,
    /// For each side, and for all askew faces together, whether grains share any of the nodes that they act on: they then act in every step of grains, else
    /// once in a cycle. The same on every rank.
    pub with_grains: [bool; SIDES + 1],
    /// Tiles of this rank that may have points near faces.
    pub near: Vec<bool>,
    /// The same by their numbers, and rows of their margins with those that these copy.
    tiles: Arc<[usize]>,
    copies: Vec<(u32, u32)>,
    /// Columns whose anchors this rank owns, of all sides that material is in front of; the nodes of all of them with their tile rows.
    pub in_line: Vec<Column>,
    /// Column behind column, with the tile row of each node.
    pub links: Vec<(Link<S>, usize)>,
    /// By tile row, and of owned nodes.
    pub brought: Vec<Brought>,
    /// Of owned nodes, over all tiles.
    pub sums: Vec<Brought>,
    /// By tile row.
    pub columns: Vec<ColumnNode<S>>,
    /// By tile row: what the columns of the side under way give, N s.
    pub impulses: Vec<Impulses<S>>,
    /// Of owned nodes.
    pub met: Vec<Met<S>>,
    /// Of faces that are round or askew to the grid.
    pub askew: AskewRows<S>,
}

impl<S: Space> Default for FaceRows<S> {
    fn default() -> Self {
        Self {
            set: None,
            sides: Vec::new(),
            with_grains: [false; SIDES + 1],
            near: Vec::new(),
            tiles: Arc::default(),
            copies: Vec::new(),
            in_line: Vec::new(),
            links: Vec::new(),
            brought: Vec::new(),
            sums: Vec::new(),
            columns: Vec::new(),
            impulses: Vec::new(),
            met: Vec::new(),
            askew: AskewRows::default(),
        }
    }
}

impl<S: Space> FaceRows<S> {
    /// Rows of zeros for these tiles; no face is placed yet.
    pub fn lay(mosaic: &Mosaic) -> Self {
        let (gathered, spread) = (mosaic.rows() + mosaic.rows_received, mosaic.rows() + mosaic.rows_spread);
        Self {
            set: None,
            sides: Vec::new(),
            with_grains: [false; SIDES + 1],
            near: vec![false; mosaic.tiles],
            tiles: Arc::default(),
            copies: Vec::new(),
            in_line: Vec::new(),
            links: Vec::new(),
            brought: vec![Brought::ZERO; gathered],
            sums: vec![Brought::ZERO; mosaic.owned.len()],
            columns: vec![ColumnNode::zero(); spread],
            impulses: vec![[S::Vector::zero(); 2]; gathered],
            met: vec![Met::untouched([S::Vector::zero(); 2], 0.0, 0.0); mosaic.owned.len()],
            askew: AskewRows::default(),
        }
    }

    /// Faces as they are now, and which tiles they are near to. Rows of tiles that they have left, or have come to, are zero.
    pub fn place(&mut self, mosaic: &Mosaic, set: FaceSet, near: Vec<bool>) {
        let len = mosaic.nodes_per_tile;
        for tile in (0..mosaic.tiles).filter(|tile| self.near[*tile] || near[*tile]) {
            self.brought[tile * len..][..len].fill(Brought::ZERO);
            self.columns[tile * len..][..len].fill(ColumnNode::zero());
            self.impulses[tile * len..][..len].fill([S::Vector::zero(); 2]);
        }
        if !set.askew.is_empty() {
            self.askew.brought.resize(mosaic.rows() + mosaic.rows_received, Outline::ZERO);
            self.askew.sums.resize(mosaic.owned.len(), Outline::ZERO);
            for tile in (0..mosaic.tiles).filter(|tile| self.near[*tile] || near[*tile]) {
                self.askew.brought[tile * len..][..len].fill(Outline::ZERO);
            }
        }
        if self.near != near {
            self.tiles = (0..near.len()).filter(|tile| near[*tile]).collect();
            self.copies = mosaic.copies_of(|tile| near[tile]).copied().collect();
            self.near = near;
        }
        self.set = Some(set);
    }

    /// Finds the columns of the sides that material is in front of, in tiles that have so many nodes along an edge.
    pub fn find_columns(&mut self, mosaic: &Mosaic, edge: usize) {
        self.in_line.clear();
        self.links.clear();
        let Some(set) = &self.set else { return };
        let (per_tile, edge, mut nodes) = (mosaic.owned_per_tile(), edge as i64, Vec::new());
        for &side in &self.sides {
            for anchor in self.tiles.iter().flat_map(|tile| &mosaic.owned[tile * per_tile..(tile + 1) * per_tile]) {
                for face in (0..set.faces.len()).filter(|number| set.faces[*number].side == side) {
                    nodes.clear();
                    set.column::<S>(face, anchor.place, &mut nodes);
                    if nodes.is_empty() {
                        continue;
                    }
                    let row = |link: &Link<S>| {
                        let [x, y, z] = link.steps.map(i64::from);
                        (i64::from(anchor.row) + (z * edge + y) * edge + x) as usize
                    };
                    let first = self.links.len();
                    self.links.extend(nodes.iter().map(|link| (*link, row(link))));
                    self.in_line.push(Column { side, face, links: first..self.links.len() });
                }
            }
        }
    }

    /// Columns of a side, by their faces: nodes of each with their tile rows.
    pub fn columns_on(&self, side: usize) -> impl Iterator<Item = (usize, &[(Link<S>, usize)])> {
        let columns = self.in_line.iter().filter(move |column| column.side == side);
        columns.map(|column| (column.face, &self.links[column.links.clone()]))
    }

    /// Whether a tile of this rank may have points near faces.
    pub fn is_near(&self, tile: usize) -> bool {
        self.near.get(tile) == Some(&true)
    }

    /// Nodes that tiles near faces own.
    pub fn owned(&self, mosaic: &Mosaic) -> impl Iterator<Item = usize> + use<S> {
        let (per_tile, tiles) = (mosaic.owned_per_tile(), Arc::clone(&self.tiles));
        (0..tiles.len()).flat_map(move |at| tiles[at] * per_tile..(tiles[at] + 1) * per_tile)
    }

    /// Sums of all tiles at the nodes that tiles near faces own, in the one order of neighbours.
    pub fn sum(&mut self, mosaic: &Mosaic) {
        for number in self.owned(mosaic) {
            let sum = &mut self.sums[number];
            *sum = Brought::ZERO;
            mosaic.sources_of(number).iter().for_each(|source| sum.add(&self.brought[*source as usize]));
        }
    }

    /// The same of what askew faces ask for.
    pub fn sum_askew(&mut self, mosaic: &Mosaic) {
        for number in self.owned(mosaic) {
            let sum = &mut self.askew.sums[number];
            *sum = Outline::ZERO;
            mosaic.sources_of(number).iter().for_each(|source| sum.add(&self.askew.brought[*source as usize]));
        }
    }

    /// A node that faces act on, by its number among the owned ones; none away from them, or where no material is in front of one.
    pub fn met_at(&self, mosaic: &Mosaic, number: usize) -> Option<&Met<S>> {
        self.met_by(mosaic, number).contains(&true).then(|| &self.met[number])
    }

    /// See [`Met::by`].
    pub fn met_by(&self, mosaic: &Mosaic, number: usize) -> [bool; 2] {
        match self.is_near(number / mosaic.owned_per_tile()) {
            true => [self.sums[number].has_area(), self.askew.sums.get(number).is_some_and(Outline::is_reached)],
            false => [false; 2],
        }
    }

    /// Which sides act on an owned node, and whether askew faces do.
    fn acting_on(&self, number: usize) -> [bool; SIDES + 1] {
        let askew = self.askew.sums.get(number).is_some_and(Outline::is_reached);
        std::array::from_fn(|side| if side < SIDES { self.sums[number].area(side) != 0.0 } else { askew })
    }

    /// What acts on the nodes that this rank owns, of which some have grains, by `has_grains`.
    pub fn acting(&self, mosaic: &Mosaic, has_grains: impl Fn(usize) -> bool) -> Acting {
        let mut acting = Acting::default();
        for number in self.owned(mosaic) {
            let on = self.acting_on(number);
            for side in (0..=SIDES).filter(|side| on[*side]) {
                acting.0[SIDES + 1][side] |= i64::from(has_grains(number));
                (0..=SIDES).filter(|other| on[*other]).for_each(|other| acting.0[side][other] = 1);
            }
        }
        acting
    }

    /// Takes what acts on the nodes of all ranks.
    pub fn act(&mut self, acting: &Acting) {
        self.sides.clear();
        self.sides.extend((0..SIDES).filter(|side| acting.together(*side, *side)));
        self.with_grains = std::array::from_fn(|side| acting.with_grains(side));
        // Those that act on one and the same node do so at once; a chain of them has at most as many links.
        for _ in 0..SIDES {
            let before = self.with_grains;
            let meets = |side: usize| (0..=SIDES).any(|other| before[other] && acting.together(side, other));
            self.with_grains = std::array::from_fn(|side| before[side] || meets(side));
        }
    }

    /// Whether faces act on an owned node, and if so, in every step of grains.
    pub fn acts_with_grains(&self, mosaic: &Mosaic, number: usize) -> Option<bool> {
        if !self.met_by(mosaic, number).contains(&true) {
            return None;
        }
        let on = self.acting_on(number);
        Some((0..=SIDES).any(|side| on[side] && self.with_grains[side]))
    }

    /// What owned nodes show to the columns of a side.
    pub fn show(&mut self, mosaic: &Mosaic, side: usize) {
        for number in self.owned(mosaic) {
            let (brought, Met { velocities, mass, .. }) = (&self.sums[number], self.met[number]);
            let (area, touch) = (brought.area(side), brought.touch(side));
            self.columns[mosaic.owned[number].row as usize] = ColumnNode { mass, area, touch, velocities };
        }
    }

    /// Margins of tiles near faces from the owners' rows.
    pub fn copy_margins(&mut self) {
        for &(to, from) in &self.copies {
            self.columns[to as usize] = self.columns[from as usize];
        }
    }

    /// No column has acted on the tiles near faces.
    pub fn clear_impulses(&mut self, mosaic: &Mosaic) {
        let len = mosaic.nodes_per_tile;
        for &tile in &*self.tiles {
            self.impulses[tile * len..][..len].fill([S::Vector::zero(); 2]);
        }
    }

    /// Nodes take what the columns of a side give them.
    pub fn take(&mut self, mosaic: &Mosaic, side: usize) {
        for number in self.owned(mosaic) {
            let mass = self.met[number].mass;
            // No column gives a node anything that has no area before it.
            if mass <= 0.0 || self.sums[number].area(side) == 0.0 {
                continue;
            }
            let mut sums = [S::Vector::zero(); 2];
            for source in mosaic.sources_of(number) {
                let impulses = &self.impulses[*source as usize];
                sums.iter_mut().zip(impulses).for_each(|(sum, impulse)| *sum += *impulse);
            }
            let met = &mut self.met[number];
            met.velocities.iter_mut().zip(&sums).for_each(|(velocity, impulse)| *velocity += *impulse * (1.0 / mass));
            met.impulses[side] = sums[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;

    /// Those that act on one node act at once, and so do all that hang together by such nodes.
    #[test]
    fn sides_that_share_nodes_go_with_grains_together() {
        let mut acting = Acting::default();
        let mut link =
            |a: usize, b: usize| [(a, b), (b, a), (a, a), (b, b)].into_iter().for_each(|(a, b)| acting.0[a][b] = 1);
        // Askew faces, and a chain from the one with grains over all but one side, which stands alone.
        link(0, 5);
        link(5, 1);
        link(1, 4);
        link(4, SIDES);
        link(2, 2);
        let mut faces = FaceRows::<Plane>::default();
        faces.act(&acting);
        assert_eq!(faces.sides, [0, 1, 2, 4, 5]);
        assert_eq!(faces.with_grains, [false; SIDES + 1]);
        acting.0[SIDES + 1][SIDES] = 3;
        faces.act(&acting);
        assert_eq!(faces.with_grains, [true, true, false, false, true, true, true]);
    }
}
