//! Bodies that meet points at their own face ([`crate::mpm::faces`]), over all ranks: areas to the owners of nodes, nodes to the owners of
//! columns, impulses back. Faces of one side act at once, for no node is in two columns of theirs; one side follows on the other. Those askew
//! to the grid come last ([`crate::domain::step::askew`]).

use std::mem;

use scree_partition::ExactSum;

use crate::base::parallel::{Held, over_blocks};
use crate::base::space::{Linear, Space};
use crate::domain::grid::{BoundaryConditions, Moment, Reactions};
use crate::domain::phases::Phase;
use crate::domain::reaction::BODY_SLOTS;
use crate::domain::step::askew::OUTLINE;
use crate::domain::subdomain::Subdomain;
use crate::domain::world::World;
use crate::mpm::continuum::Continuum;
use crate::mpm::face_rows::{FaceRows, Met};
use crate::mpm::faces::{Brought, ColumnNode, ColumnSums, FaceSet, Link, SIDES};
use crate::mpm::nodes;
use crate::mpm::tile::GrainNode;

/// Numbers of a node in a message, in the plane and in space: areas and touches of all sides; mass, area, touch and both velocities; and
/// both impulses.
const BROUGHT: [usize; 2] = [8, 12];
const COLUMN: [usize; 2] = [7, 9];
const IMPULSES: [usize; 2] = [4, 6];

impl<S: Space> World<'_, S> {
    /// Whether any body meets points at its own face.
    pub(crate) fn meets_faces(&self) -> bool {
        self.has_grid() && self.has_points() && self.bodies.iter().any(|body| body.meets_points)
    }

    /// Exchanges of nodes in a step, and the numbers per row of all of them: to faces and back for each side, once more for servos.
    pub(crate) fn exchanges_of_faces(&self) -> [usize; 2] {
        if !self.meets_faces() {
            return [0; 2];
        }
        let faces = &self.continuum.tiles.faces;
        let (axes, passes, sides) = (S::DIMENSION - 2, self.passes(), faces.sides.len());
        let in_line = usize::from(faces.set.as_ref().is_none_or(FaceSet::has_in_line));
        let (askew, shown) = (usize::from(self.askew_bodies() > 0), passes + usize::from(self.asks_columns()));
        let brought = in_line * BROUGHT[axes] + askew * OUTLINE[axes];
        let numbers = passes * (brought + sides * IMPULSES[axes]) + shown * sides * COLUMN[axes];
        [passes * (in_line + askew + sides) + shown * sides, numbers]
    }

    /// Whether any body that meets points at its face moves by what it bears there.
    fn asks_columns(&self) -> bool {
        self.meets_faces() && self.bodies.iter().any(|body| body.meets_points && body.feels_nodes())
    }

    /// Where faces are now, and what points bring to them.
    pub(crate) fn fill_faces(&mut self) {
        if !self.meets_faces() {
            return;
        }
        let timer = self.phases.start();
        let Self { subdomain, continuum, bodies, .. } = self;
        let (Subdomain { nodes, layout, deal, .. }, mosaic) = (&*subdomain, &subdomain.nodes.mosaic);
        let tiles = &mut continuum.tiles;
        let set = FaceSet::new(layout.lattice(), bodies);
        let per_block = layout.cells_per_block;
        let near =
            |block: usize| set.is_near(bodies, layout.coordinates(block).map(|at| at * per_block as i32), per_block);
        let near: Vec<bool> = deal.held().map(near).collect();
        if tiles.faces.near.len() != near.len() {
            tiles.faces = FaceRows::lay(&nodes.mosaic);
        }
        let has_in_line = set.has_in_line();
        tiles.faces.place(mosaic, set, near);
        self.phases.stop(Phase::Scatter, timer);
        if has_in_line {
            self.fill_in_line();
        }
        self.fill_askew();
        self.find_sides();
    }

    /// Which sides have material in front of them, where their columns are, and whether grains share nodes there. Collective.
    fn find_sides(&mut self) {
        let timer = self.phases.start();
        let (mosaic, tiles) = (&self.subdomain.nodes.mosaic, &mut self.continuum.tiles);
        let has_grains = |number: usize| tiles.grain_sums.get(number).is_some_and(|grains| grains.mass() > 0.0);
        let mut acting = tiles.faces.acting(mosaic, has_grains);
        if self.transport.size() > 1 {
            self.transport.sum(acting.0.as_flattened_mut());
        }
        tiles.faces.act(&acting);
        tiles.faces.find_columns(mosaic, self.subdomain.layout.tile_edge());
        self.phases.stop(Phase::Nodes, timer);
    }

    fn fill_in_line(&mut self) {
        let timer = self.phases.start();
        let Self { subdomain, continuum, .. } = self;
        let mosaic = &subdomain.nodes.mosaic;
        let Continuum { tiles, frames, points, .. } = continuum;
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

    /// Velocities of nodes near faces before these act, and their masses: of grains and points together, as far as they go now in a cycle, or
    /// at its beginning over all of it.
    fn unmet(&mut self, moment: Moment, over_all: bool) {
        let (step, cycle) = (self.settings.grains.dt, self.dt_of_continuum());
        let (gravity, coupled, done) = (self.gravity_now(), self.is_coupled(), self.step_of_cycle + 1);
        let ends = over_all || self.ends_cycle();
        let Self { subdomain, assembly, continuum: Continuum { tiles, .. }, bodies, settings, .. } = self;
        let (Subdomain { nodes, layout, .. }, periods) = (&*subdomain, &assembly.cell);
        let conditions = BoundaryConditions { grid: &settings.grid, layout, bodies, periods, gravity, moment };
        let mosaic = &nodes.mosaic;
        for number in tiles.faces.owned(mosaic) {
            let sum = &tiles.sums[number];
            tiles.faces.met[number] = if sum.mass() > 0.0 {
                let grains = if coupled { tiles.grain_sums[number] } else { GrainNode::zero() };
                let taken = tiles.strides.get(number).map_or(0, |stride| stride.taken);
                let (dt, acts) = match moment {
                    Moment::Look => (cycle, 0.0),
                    Moment::Step => {
                        let left = if ends { cycle - taken as f64 * step } else { (done - taken) as f64 * step };
                        (left, left)
                    }
                };
                let free = nodes::free(sum, &grains, &gravity, acts);
                let velocities = conditions.unheld(free, &mosaic.owned[number], (sum, &grains), dt, None);
                let by = tiles.faces.met_by(mosaic, number);
                Met { by, ..Met::untouched(velocities, sum.mass() + grains.mass(), dt) }
            } else {
                Met::untouched([S::Vector::zero(); 2], 0.0, 0.0)
            };
        }
    }

    /// Nodes as they are, to the columns of a side.
    fn show_nodes(&mut self, side: usize) {
        let timer = self.phases.start();
        let (mosaic, tiles) = (&self.subdomain.nodes.mosaic, &mut self.continuum.tiles);
        tiles.faces.show(mosaic, side);
        self.phases.stop(Phase::Nodes, timer);
        match S::DIMENSION {
            2 => self.spread_columns::<{ COLUMN[0] }>(),
            _ => self.spread_columns::<{ COLUMN[1] }>(),
        }
        self.continuum.tiles.faces.copy_margins();
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

    /// Bodies act on the nodes before their faces, which then have gone as far as the grains; a cycle's last step takes them to its end. Where grains share
    /// none of the nodes of a side, that is all of it.
    pub(crate) fn meet_faces(&mut self, moment: Moment) {
        let within_cycle = moment == Moment::Step && !self.ends_cycle();
        if !self.meets_faces() || (within_cycle && !self.continuum.tiles.faces.with_grains.contains(&true)) {
            return;
        }
        self.unmet(moment, false);
        for at in 0..self.continuum.tiles.faces.sides.len() {
            let side = self.continuum.tiles.faces.sides[at];
            if within_cycle && !self.continuum.tiles.faces.with_grains[side] {
                continue;
            }
            self.show_nodes(side);
            self.push_columns(side, moment);
            match S::DIMENSION {
                2 => self.gather_impulses::<{ IMPULSES[0] }>(),
                _ => self.gather_impulses::<{ IMPULSES[1] }>(),
            }
            let (mosaic, tiles) = (&self.subdomain.nodes.mosaic, &mut self.continuum.tiles);
            tiles.faces.take(mosaic, side);
        }
        if !within_cycle || self.continuum.tiles.faces.with_grains[SIDES] {
            self.meet_askew(moment);
        }
    }

    /// Impulses of the columns of a side whose anchors this rank owns, booked where they act.
    fn push_columns(&mut self, side: usize, moment: Moment) {
        let timer = self.phases.start();
        let Self { subdomain, continuum: Continuum { tiles, .. }, bodies, reactions, .. } = self;
        tiles.faces.clear_impulses(&subdomain.nodes.mosaic);
        let mut impulses = mem::take(&mut tiles.faces.impulses);
        let faces = &tiles.faces;
        let set = faces.set.as_ref().expect("faces were placed before they act");
        let mut booked = Reactions::default();
        for (number, links) in faces.columns_on(side) {
            let (body, normal) = (set.faces[number].body, set.faces[number].normal::<S>());
            let (rigid, columns) = (&bodies[body], &faces.columns);
            let Some((grip, separates)) = rigid.acts_on_points() else { continue };
            let sums = ColumnSums::of(nodes_of(columns, links, |place| rigid.velocity_at(place)));
            if !sums.is_met(&normal, separates) {
                continue;
            }
            let pressures = sums.pressures(&normal, grip);
            let (mut taken, mut turn) = (S::Vector::zero(), S::Spin::zero());
            for (link, row) in links.iter().filter(|(_, row)| columns[*row].mass > 0.0) {
                let given = pressures.map(|pressure| pressure * columns[*row].area);
                impulses[*row] = given;
                taken -= given[0];
                turn -= S::moment(&(link.place - rigid.origin()), &given[0]);
            }
            if moment == Moment::Step {
                booked.on_body((body, rigid), &taken, &turn);
            }
        }
        tiles.faces.impulses = impulses;
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

    /// What plates, and bodies with servos, move with them of the material before their faces.
    pub(crate) fn add_columns<const SLOTS: usize>(&mut self, sums: &mut ExactSum<SLOTS>) {
        if !self.asks_columns() {
            return;
        }
        self.unmet(Moment::Step, true);
        for at in 0..self.continuum.tiles.faces.sides.len() {
            let side = self.continuum.tiles.faces.sides[at];
            self.show_nodes(side);
            let faces = &self.continuum.tiles.faces;
            let set = faces.set.as_ref().expect("faces were placed before servos ask");
            for (number, links) in faces.columns_on(side) {
                let (body, normal) = (set.faces[number].body, set.faces[number].normal::<S>());
                let rigid = &self.bodies[body];
                let Some((grip, separates)) = rigid.acts_on_points().filter(|_| rigid.feels_nodes()) else { continue };
                let columns = &faces.columns;
                let now = ColumnSums::of(nodes_of(columns, links, |place| rigid.velocity_at(place)));
                if !now.is_met(&normal, separates) {
                    continue;
                }
                // The servo's answer is the velocity of the body; what its spin adds is known.
                let spins = |place: &S::Vector| rigid.velocity_at(place) - rigid.velocity;
                let sums_of = ColumnSums::of(nodes_of(columns, links, spins));
                let direction = rigid.servo.as_ref().map_or(S::Vector::zero(), |servo| servo.direction);
                let (momentum, mass) = sums_of.carried(&normal, grip, &direction);
                for axis in 0..S::DIMENSION {
                    sums.add(BODY_SLOTS * body + 6 + axis, momentum[axis]);
                }
                sums.add(BODY_SLOTS * body + 9, mass);
            }
        }
    }
}

/// The nodes of a column with the body's velocity at each; those without mass bring nothing.
fn nodes_of<S: Space>(
    columns: &[ColumnNode<S>],
    links: &[(Link<S>, usize)],
    velocity: impl Fn(&S::Vector) -> S::Vector,
) -> impl Iterator<Item = (ColumnNode<S>, S::Vector)> {
    let nodes = links.iter().map(move |(link, row)| (columns[*row], velocity(&link.place)));
    nodes.filter(|(node, _)| node.mass > 0.0)
}
