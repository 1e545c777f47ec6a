//! Faces that are round or askew to the grid ([`crate::mpm::askew`]), over all ranks: what points bring goes to the owners of nodes, and these
//! add their parts to the sums of columns, which are exact in fixed point and the same on every rank; each owner then moves its own nodes.
//! One body follows on the other.

use crate::base::parallel::{Held, over_blocks};
use crate::base::space::Space;
use crate::domain::grid::{Moment, Reactions};
use crate::domain::phases::Phase;
use crate::domain::subdomain::Subdomain;
use crate::domain::world::World;
use crate::mpm::askew::{Outline, Reached, SWEEPS, scatter};
use crate::mpm::continuum::Continuum;
use crate::mpm::face_rows::FaceRows;

/// Numbers of a node in a message, in the plane and in space: G, T, Vol and S.
pub(super) const OUTLINE: [usize; 2] = [7, 11];

/// Share of the heaviest node's mass below which a node is left out: its 1/m would leave the range of exact sums, and it has next to no momentum.
const LIGHTEST: f64 = 1e-9;

impl<S: Space> World<'_, S> {
    /// Bodies that have such faces.
    pub(crate) fn askew_bodies(&self) -> usize {
        self.continuum.tiles.faces.set.as_ref().map_or(0, |set| set.askew.len())
    }

    /// What points bring to nodes for them, and which nodes they reach.
    pub(crate) fn fill_askew(&mut self) {
        if self.askew_bodies() == 0 {
            return;
        }
        let timer = self.phases.start();
        let Self { subdomain, continuum, bodies, .. } = self;
        let mosaic = &subdomain.nodes.mosaic;
        let Continuum { tiles, frames, points, .. } = continuum;
        let FaceRows { set, near, askew, .. } = &mut tiles.faces;
        let (set, near) = (set.as_ref().expect("faces were placed before"), &*near);
        let brought = &mut askew.brought[..mosaic.rows()];
        let held = Held { rows: &mut points.hot[..], tiles: brought, tile_len: mosaic.nodes_per_tile };
        over_blocks(&subdomain.point_ranges, held, &|block, Held { rows, tiles, .. }| {
            if near[block] {
                scatter(set, bodies, &frames[block], rows, tiles);
            }
            0.0
        });
        self.phases.stop(Phase::Scatter, timer);
        match S::DIMENSION {
            2 => self.gather_outlines::<{ OUTLINE[0] }>(),
            _ => self.gather_outlines::<{ OUTLINE[1] }>(),
        }
        let timer = self.phases.start();
        let Self { subdomain, continuum, bodies, settings, transport, .. } = self;
        let Subdomain { nodes, layout, .. } = &*subdomain;
        let (mosaic, faces) = (&nodes.mosaic, &mut continuum.tiles.faces);
        faces.sum_askew(mosaic);
        let numbers = faces.owned(mosaic);
        let FaceRows { set, askew, .. } = faces;
        let set = set.as_ref().expect("faces were placed before");
        let cell = layout.cell;
        let unit = settings.grid.depth * (1..S::DIMENSION).map(|_| cell).product::<f64>();
        let place = |number: usize| {
            let at = mosaic.owned[number].place;
            (number, at, layout.node_at::<S::Vector>(at))
        };
        askew.reach(set, bodies, unit, numbers.map(place));
        if transport.size() > 1 {
            transport.sum(&mut askew.lines);
        }
        askew.number_columns();
        self.phases.stop(Phase::Nodes, timer);
    }

    fn gather_outlines<const W: usize>(&mut self) {
        // In the plane the third component of G and the last three of S are not there.
        let word = move |word: usize| if S::DIMENSION == 2 && word >= 2 { word + 1 } else { word };
        self.travel(
            |world| &mut world.subdomain.nodes.gathered,
            |world, row| -> [f64; W] {
                std::array::from_fn(|at| world.continuum.tiles.faces.askew.brought[row].0[word(at)])
            },
            |_| (),
            |world, row, words: [f64; W]| {
                let mut outline = Outline::ZERO;
                words.iter().enumerate().for_each(|(at, number)| outline.0[word(at)] = *number);
                world.continuum.tiles.faces.askew.brought[row] = outline;
            },
        );
    }

    /// They act on the nodes of [`FaceRows::met`].
    pub(crate) fn meet_askew(&mut self, moment: Moment) {
        if self.askew_bodies() == 0 {
            return;
        }
        let timer = self.phases.start();
        let FaceRows { met, askew, .. } = &mut self.continuum.tiles.faces;
        askew.begin();
        let mut heaviest = [askew.reached.iter().map(|node| met[node.number].mass).fold(0.0, f64::max)];
        self.transport.max(&mut heaviest);
        askew.heaviest = heaviest[0];
        for order in 0..self.askew_bodies() {
            for sweep in 0..SWEEPS {
                // Outlines are balanced by forces, once.
                self.sweep(order, moment, sweep == 0 && moment == Moment::Step);
            }
        }
        self.phases.stop(Phase::Nodes, timer);
    }

    fn sweep(&mut self, order: usize, moment: Moment, balances: bool) {
        let Self { continuum: Continuum { tiles, .. }, bodies, reactions, transport, column_sums, .. } = self;
        let FaceRows { set, met, askew, .. } = &mut tiles.faces;
        let body = set.as_ref().expect("faces were placed before they act").askew[order];
        let rigid = &bodies[body];
        let Some(how) = rigid.acts_on_points() else { return };
        let (nodes, columns) = (askew.ranges[order].clone(), askew.column_ranges[order].clone());
        let (parts, first) = (Reached::<S>::parts(), columns.start);
        let (heaviest, lightest) = (askew.heaviest, LIGHTEST * askew.heaviest);
        column_sums.clear(columns.len() * parts);
        for node in askew.reached[nodes.clone()].iter().filter(|node| met[node.number].mass > lightest) {
            let own = &met[node.number];
            let dt = if balances { own.dt } else { 0.0 };
            let words = node.shown(&own.velocities, &rigid.velocity_at(&node.place), [own.mass, heaviest], dt);
            for (column, share) in node.columns.iter().filter(|(_, share)| *share > 0.0) {
                for (part, word) in words.iter().enumerate().take(parts) {
                    column_sums.add((column - first) * parts + part, share * word);
                }
            }
        }
        column_sums.total(*transport);
        for (number, column) in askew.columns[columns].iter_mut().enumerate() {
            column.sweep::<S>(|part| column_sums.value(number * parts + part), heaviest, how, balances);
        }
        let mut booked = Reactions::default();
        for node in askew.reached[nodes].iter_mut() {
            let own = &mut met[node.number];
            if own.mass <= lightest {
                continue;
            }
            let given = node.taken(&askew.columns, if balances { own.dt } else { 0.0 });
            for (velocity, impulse) in own.velocities.iter_mut().zip(&given) {
                *velocity += *impulse * (1.0 / own.mass);
            }
            node.impulse += given[0];
            if moment == Moment::Step {
                let arm = node.place - rigid.origin();
                booked.on_body((body, rigid), &-given[0], &S::moment(&arm, &-given[0]));
            }
        }
        reactions.merge(&booked);
    }
}
