//! Bodies that meet points at their own face ([`crate::mpm::faces`]), over all ranks: areas to the owners of nodes, nodes to the owners of
//! columns, impulses back. Faces of one side act at once, for no node is in two columns of theirs; one side follows on the other.

use scree_partition::ExactSum;

use crate::base::parallel::{Held, over_blocks};
use crate::base::space::{Linear, Space};
use crate::domain::grid::{BoundaryConditions, Moment, Reactions};
use crate::domain::phases::Phase;
use crate::domain::reaction::BODY_SLOTS;
use crate::domain::subdomain::Subdomain;
use crate::domain::world::World;
use crate::mpm::continuum::Continuum;
use crate::mpm::face_rows::{FaceRows, Met};
use crate::mpm::faces::{Brought, COLUMN_MAX, ColumnNode, ColumnSums, FaceSet, Link, SIDES};
use crate::mpm::tile::{GrainNode, Mosaic};

/// Numbers of a node in a message, in the plane and in space: areas and touches of all sides; mass, area, touch and both velocities; and
/// both impulses.
const BROUGHT: [usize; 2] = [8, 12];
const COLUMN: [usize; 2] = [7, 9];
const IMPULSES: [usize; 2] = [4, 6];

impl<S: Space> World<'_, S> {
    /// Whether any body meets points at its own face.
    pub(crate) fn meets_faces(&self) -> bool {
        self.has_points() && self.bodies.iter().any(|body| body.meets_points)
    }

    /// The sides that have a face, in the order in which they act.
    fn sides(&self) -> Vec<usize> {
        let set = self.continuum.tiles.faces.set.as_ref();
        (0..2 * S::DIMENSION).filter(|side| set.is_some_and(|set| set.has_side(*side))).collect()
    }

    /// Where faces are now, and what points bring to them.
    pub(crate) fn fill_faces(&mut self) {
        if !self.meets_faces() {
            return;
        }
        let timer = self.phases.start();
        let Self { subdomain, continuum, bodies, .. } = self;
        let (Subdomain { nodes, layout, deal, .. }, mosaic) = (&*subdomain, &subdomain.nodes.mosaic);
        let Continuum { tiles, frames, points, .. } = continuum;
        let set = FaceSet::new(layout.lattice(), bodies);
        let per_block = layout.cells_per_block;
        let near = |block: usize| set.is_near(layout.coordinates(block).map(|at| at * per_block as i32), per_block);
        let near: Vec<bool> = deal.held().map(near).collect();
        if tiles.faces.near.len() != near.len() {
            tiles.faces = FaceRows::lay(&nodes.mosaic);
        }
        tiles.faces.place(mosaic, set, near);
        let FaceRows { set, near, brought, .. } = &mut tiles.faces;
        let (set, near) = (set.as_ref().expect("it has just been placed"), &*near);
        let brought = &mut brought[..mosaic.rows()];
        let held = Held { rows: &mut points.hot[..], tiles: brought, tile_len: mosaic.nodes_per_tile };
        over_blocks(&subdomain.point_ranges, held, &|block, Held { rows, tiles, .. }| {
            if near[block] {
                set.scatter(&frames[block], rows, tiles);
            }
            0.0
        });
        self.phases.stop(Phase::Scatter, timer);
        match S::DIMENSION {
            2 => self.gather_brought::<{ BROUGHT[0] }>(),
            _ => self.gather_brought::<{ BROUGHT[1] }>(),
        }
        let timer = self.phases.start();
        self.continuum.tiles.faces.sum(&self.subdomain.nodes.mosaic);
        self.phases.stop(Phase::Nodes, timer);
    }

    fn gather_brought<const W: usize>(&mut self) {
        let sides = 2 * S::DIMENSION;
        let word = move |word: usize| if word < sides { word } else { SIDES + word - sides };
        self.travel(
            |world| &mut world.subdomain.nodes.gathered,
            |world, row| -> [f64; W] { std::array::from_fn(|at| world.continuum.tiles.faces.brought[row].0[word(at)]) },
            |_| (),
            |world, row, words: [f64; W]| {
                let mut brought = Brought::ZERO;
                words.iter().enumerate().for_each(|(at, number)| brought.0[word(at)] = *number);
                world.continuum.tiles.faces.brought[row] = brought;
            },
        );
    }

    /// Velocities of nodes near faces before these act.
    fn unmet(&mut self, moment: Moment) {
        let (dt, gravity) = (self.dt_of_continuum(), self.gravity_now());
        let Self { subdomain, assembly, continuum: Continuum { tiles, .. }, bodies, settings, .. } = self;
        let (Subdomain { nodes, layout, .. }, periods) = (&*subdomain, &assembly.cell);
        let conditions = BoundaryConditions { grid: &settings.grid, layout, bodies, periods, gravity, moment };
        let mosaic = &nodes.mosaic;
        let acts = if moment == Moment::Look { 0.0 } else { dt };
        for number in tiles.faces.owned(mosaic) {
            let sum = &tiles.sums[number];
            let velocities = if sum.mass() > 0.0 {
                let momentum = sum.momentum() + sum.force() * acts + gravity * (sum.mass() * acts);
                let free = momentum * (1.0 / sum.mass());
                conditions.unheld(free, &mosaic.owned[number], (sum, &GrainNode::zero()), dt, None)
            } else {
                [S::Vector::zero(); 2]
            };
            tiles.faces.met[number] = Met::untouched(velocities);
        }
    }

    /// Nodes as they are, to the columns of a side.
    fn show_nodes(&mut self, side: usize) {
        let timer = self.phases.start();
        let (mosaic, tiles) = (&self.subdomain.nodes.mosaic, &mut self.continuum.tiles);
        let sums = &tiles.sums;
        tiles.faces.show(mosaic, side, |number| sums[number].mass());
        self.phases.stop(Phase::Nodes, timer);
        match S::DIMENSION {
            2 => self.spread_columns::<{ COLUMN[0] }>(),
            _ => self.spread_columns::<{ COLUMN[1] }>(),
        }
        self.continuum.tiles.faces.copy_margins(&self.subdomain.nodes.mosaic);
    }

    fn spread_columns<const W: usize>(&mut self) {
        self.travel(
            |world| &mut world.subdomain.nodes.advanced,
            |world, row| {
                let node = &world.continuum.tiles.faces.columns[row];
                let mut words = [0.0; W];
                words[..3].copy_from_slice(&[node.mass, node.area, node.touch]);
                for axis in 0..S::DIMENSION {
                    words[3 + axis] = node.velocities[0][axis];
                    words[3 + S::DIMENSION + axis] = node.velocities[1][axis];
                }
                words
            },
            |_| (),
            |world, row, words: [f64; W]| {
                let mut node: ColumnNode<S> =
                    ColumnNode { mass: words[0], area: words[1], touch: words[2], ..ColumnNode::zero() };
                for axis in 0..S::DIMENSION {
                    node.velocities[0][axis] = words[3 + axis];
                    node.velocities[1][axis] = words[3 + S::DIMENSION + axis];
                }
                world.continuum.tiles.faces.columns[row] = node;
            },
        );
    }

    /// Bodies act on the nodes before their faces.
    pub(crate) fn meet_faces(&mut self, moment: Moment) {
        if !self.meets_faces() {
            return;
        }
        self.unmet(moment);
        for side in self.sides() {
            self.show_nodes(side);
            self.push_columns(side, moment);
            match S::DIMENSION {
                2 => self.gather_impulses::<{ IMPULSES[0] }>(),
                _ => self.gather_impulses::<{ IMPULSES[1] }>(),
            }
            let (mosaic, tiles) = (&self.subdomain.nodes.mosaic, &mut self.continuum.tiles);
            let sums = &tiles.sums;
            tiles.faces.take(mosaic, side, |number| sums[number].mass());
        }
    }

    /// Impulses of the columns of a side whose anchors this rank owns, booked where they act.
    fn push_columns(&mut self, side: usize, moment: Moment) {
        let timer = self.phases.start();
        let Self { subdomain, continuum: Continuum { tiles, .. }, bodies, reactions, .. } = self;
        let (mosaic, edge) = (&subdomain.nodes.mosaic, subdomain.layout.tile_edge());
        tiles.faces.clear_impulses(mosaic);
        let FaceRows { set, near, columns, impulses, .. } = &mut tiles.faces;
        let set = set.as_ref().expect("faces were placed before they act");
        let mut booked = Reactions::default();
        for_each_column::<S>(set, near, mosaic, edge, side, |number, links| {
            let (body, normal) = (set.faces[number].body, set.faces[number].normal::<S>());
            let rigid = &bodies[body];
            let Some((grip, separates)) = rigid.grip else { return };
            let (nodes, count) = column_of(columns, links, |place| rigid.velocity_at(place));
            let sums = ColumnSums::of(&nodes[..count]);
            if !sums.is_met(&normal, separates) {
                return;
            }
            let pressures = sums.pressures(&normal, grip);
            for ((link, row), (node, _)) in links.iter().zip(&nodes) {
                let given = pressures.map(|pressure| pressure * node.area);
                impulses[*row] = given;
                if moment == Moment::Step {
                    let arm = link.place - rigid.origin();
                    booked.on_body::<S>(body, &-given[0], &S::moment(&arm, &-given[0]));
                }
            }
        });
        reactions.merge(&booked);
        self.phases.stop(Phase::Nodes, timer);
    }

    fn gather_impulses<const W: usize>(&mut self) {
        self.travel(
            |world| &mut world.subdomain.nodes.gathered,
            |world, row| {
                let impulses = &world.continuum.tiles.faces.impulses[row];
                std::array::from_fn(|at| impulses[at / S::DIMENSION][at % S::DIMENSION])
            },
            |_| (),
            |world, row, words: [f64; W]| {
                let impulses = &mut world.continuum.tiles.faces.impulses[row];
                words.iter().enumerate().for_each(|(at, word)| impulses[at / S::DIMENSION][at % S::DIMENSION] = *word);
            },
        );
    }

    /// What servos move with their bodies of the material before their faces.
    pub(crate) fn add_columns<const SLOTS: usize>(&mut self, sums: &mut ExactSum<SLOTS>) {
        if !self.meets_faces() || !self.bodies.iter().any(|body| body.meets_points && body.servo.is_some()) {
            return;
        }
        self.unmet(Moment::Step);
        for side in self.sides() {
            self.show_nodes(side);
            let tiles = &self.continuum.tiles;
            let (mosaic, edge) = (&self.subdomain.nodes.mosaic, self.subdomain.layout.tile_edge());
            let set = tiles.faces.set.as_ref().expect("faces were placed before servos ask");
            for_each_column::<S>(set, &tiles.faces.near, mosaic, edge, side, |number, links| {
                let (body, normal) = (set.faces[number].body, set.faces[number].normal::<S>());
                let rigid = &self.bodies[body];
                let (Some((grip, separates)), Some(servo)) = (rigid.grip, &rigid.servo) else { return };
                let (nodes, count) = column_of(&tiles.faces.columns, links, |place| rigid.velocity_at(place));
                if !ColumnSums::of(&nodes[..count]).is_met(&normal, separates) {
                    return;
                }
                // The servo's answer is the velocity of the body; what its spin adds is known.
                let spins = |place: &S::Vector| rigid.velocity_at(place) - rigid.velocity;
                let (nodes, count) = column_of(&tiles.faces.columns, links, spins);
                let (momentum, mass) = ColumnSums::of(&nodes[..count]).carried(&normal, grip, &servo.direction);
                for axis in 0..S::DIMENSION {
                    sums.add(BODY_SLOTS * body + 6 + axis, momentum[axis]);
                }
                sums.add(BODY_SLOTS * body + 9, mass);
            });
        }
    }
}

/// Calls `visit(face, nodes)` for every column of a side whose anchor a tile near faces owns, with the tile row of each node.
fn for_each_column<S: Space>(
    set: &FaceSet,
    near: &[bool],
    mosaic: &Mosaic,
    edge: usize,
    side: usize,
    mut visit: impl FnMut(usize, &[(Link<S>, usize)]),
) {
    let (per_tile, stride) = (mosaic.owned_per_tile(), edge.pow((side / 2) as u32) as i64);
    let faces: Vec<usize> = (0..set.faces.len()).filter(|number| set.faces[*number].side == side).collect();
    let mut links = Vec::with_capacity(COLUMN_MAX);
    for tile in (0..mosaic.tiles).filter(|tile| near[*tile]) {
        for anchor in &mosaic.owned[tile * per_tile..(tile + 1) * per_tile] {
            for number in &faces {
                links.clear();
                let row = |link: &Link<S>| (i64::from(anchor.row) + i64::from(link.steps) * stride) as usize;
                links.extend(set.column::<S>(*number, anchor.place).map(|link| (link, row(&link))));
                if !links.is_empty() {
                    visit(*number, &links);
                }
            }
        }
    }
}

/// A column at most: nodes, and the body's velocity at each.
type Nodes<S> = [(ColumnNode<S>, <S as Space>::Vector); COLUMN_MAX];

/// The nodes of a column with the body's velocity at each; those without mass bring nothing.
fn column_of<S: Space>(
    columns: &[ColumnNode<S>],
    links: &[(Link<S>, usize)],
    velocity: impl Fn(&S::Vector) -> S::Vector,
) -> (Nodes<S>, usize) {
    let mut nodes = [(ColumnNode { mass: 1.0, ..ColumnNode::zero() }, S::Vector::zero()); COLUMN_MAX];
    for ((link, row), node) in links.iter().zip(&mut nodes) {
        if columns[*row].mass > 0.0 {
            *node = (columns[*row], velocity(&link.place));
        }
    }
    (nodes, links.len())
}
