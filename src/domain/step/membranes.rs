//! Membranes in a step: their forces, their way to the nodes beside points and loads, and back.

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::mpm::continuum::Continuum;
use crate::mpm::look::for_each_node;
use crate::mpm::membrane::{Brought, Membranes, Vertex};
use crate::mpm::scheme::Transfer;
use crate::mpm::share::dyad;
use crate::mpm::tile::Tier;

impl<S: Space> World<'_, S> {
    /// Forces of membranes as they are now.
    pub(crate) fn push_membranes(&mut self) {
        if !self.continuum.membranes.is_empty() {
            let time = self.time() + 0.5 * self.dt_of_continuum();
            self.continuum.membranes.push(time);
        }
    }

    /// What membranes bring to the tiles of one tier, vertex by vertex, on top of what is there.
    pub(crate) fn scatter_membranes(&mut self, tier: Tier) {
        let (held, mosaic, shape) =
            (self.subdomain.deal.held(), &self.subdomain.nodes.mosaic, self.settings.grid.shape);
        let len = mosaic.nodes_per_tile;
        for (vertex, brought) in self.continuum.membranes.vertices.iter().zip(&self.continuum.membranes.brought) {
            let Some(number) = here(&held, brought).filter(|number| mosaic.tiers[*number] == tier) else { continue };
            let tile = &mut self.continuum.tiles.gathered[number * len..(number + 1) * len];
            let (momentum, along) = (vertex.velocity * brought.mass, dyad::<S>(brought.mass, &brought.along));
            for_each_node(&self.continuum.frames[number], shape, &brought.place, |node, value| {
                tile[node].bring(brought.mass * value, &(momentum * value), &(brought.force * value));
                tile[node].bring_along(&along, value);
            });
        }
    }

    /// What vertices take from the nodes as points do: velocities, and the way to where they will be. Each is taken by the
    /// rank that holds its block, and told to all. Collective.
    pub(crate) fn take_to_membranes(&mut self) {
        if self.continuum.membranes.is_empty() {
            return;
        }
        let timer = self.phases.start();
        let (held, len) = (self.subdomain.deal.held(), self.subdomain.nodes.mosaic.nodes_per_tile);
        let (dt, grid) = (self.dt_of_continuum(), &self.settings.grid);
        let Membranes { vertices, brought, words, .. } = &mut self.continuum.membranes;
        words.clear();
        words.resize(2 * S::DIMENSION * vertices.len(), 0);
        for ((vertex, brought), words) in vertices.iter().zip(&*brought).zip(words.chunks_exact_mut(2 * S::DIMENSION)) {
            let Some(number) = here(&held, brought) else { continue };
            let tile = &self.continuum.tiles.advanced[number * len..(number + 1) * len];
            let (mut value, mut change) = (S::Vector::zero(), S::Vector::zero());
            for_each_node(&self.continuum.frames[number], grid.shape, &brought.place, |node, share| {
                value += tile[node].velocity() * share;
                change += tile[node].change() * share;
            });
            let velocity = match grid.transfer {
                Transfer::Blend { flip } => (vertex.velocity + change) * flip + value * (1.0 - flip),
                Transfer::Affine => value,
            };
            let way = value * dt;
            for axis in 0..S::DIMENSION {
                words[axis] = velocity[axis].to_bits() as i64;
                words[S::DIMENSION + axis] = way[axis].to_bits() as i64;
            }
        }
        if self.transport.size() > 1 {
            self.transport.sum(words);
        }
        for ((vertex, brought), words) in vertices.iter_mut().zip(brought).zip(words.chunks_exact(2 * S::DIMENSION)) {
            for axis in 0..S::DIMENSION {
                vertex.velocity[axis] = f64::from_bits(words[axis] as u64);
                brought.way[axis] = f64::from_bits(words[S::DIMENSION + axis] as u64);
            }
        }
        self.phases.stop(Phase::Bodies, timer);
    }

    /// The way that was kept, but not into bodies that meet points at their face.
    pub(crate) fn move_membranes(&mut self) -> Result<(), Error> {
        if self.continuum.membranes.is_empty() {
            return Ok(());
        }
        let dt = self.dt_of_continuum();
        let Continuum { membranes, tiles, .. } = &mut self.continuum;
        for (vertex, brought) in membranes.vertices.iter_mut().zip(&membranes.brought) {
            vertex.position += brought.way;
            if let Some(set) = &tiles.faces.set {
                set.guard(&self.bodies, dt, &mut vertex.position);
            }
        }
        self.locate_vertices()
    }

    /// Finds the blocks that vertices lie in; one that has left the grid ends the run, on every rank alike.
    pub(crate) fn locate_vertices(&mut self) -> Result<(), Error> {
        for number in 0..self.continuum.membranes.vertices.len() {
            let vertex: &Vertex<S> = &self.continuum.membranes.vertices[number];
            let Some((block, place)) = self.block_of_vertex(&vertex.position) else {
                let membrane = self.continuum.membranes.of(vertex);
                let (name, within) = (&membrane.name, number - membrane.first);
                let at: Vec<String> = (0..S::DIMENSION).map(|axis| format!("{:.6e}", vertex.position[axis])).collect();
                return Err(Error::Run(format!(
                    "step {}: vertex {within} of the membrane {name} has left the grid, at ({}) m; give the grid more room there (grid.lower, grid.upper), or look at the last frames for what tore it away",
                    self.step,
                    at.join(", ")
                )));
            };
            let brought = &mut self.continuum.membranes.brought[number];
            (brought.block, brought.place) = (block, place);
        }
        Ok(())
    }

    /// The block of a position, which periods have not been taken off, and its place there.
    fn block_of_vertex(&self, position: &S::Vector) -> Option<(usize, S::Vector)> {
        let mut place = *position;
        self.assembly.cell.wrap(&mut place, &mut S::Vector::zero());
        let fraction = self.assembly.cell.fraction(&place);
        // Across periods a place beyond counting stays where it was.
        let inside = (0..S::DIMENSION).all(|axis| (-1e-9..=1.0 + 1e-9).contains(&fraction[axis]));
        let (block, _) = self.subdomain.layout.place::<S>(&fraction, 1).filter(|_| inside)?;
        Some((block, place))
    }

    /// Counts vertices in the blocks that they lay in at the last rebuild. All ranks have all of them.
    pub(crate) fn count_vertices(&self, counts: &mut [i64]) {
        let homes = self.continuum.membranes.vertices.iter().map(|vertex| self.block_of_vertex(&vertex.home));
        homes.flatten().for_each(|(block, _)| counts[block] += 1);
    }
}

/// Number of a vertex's block among those held here.
fn here<S: Space>(held: &std::ops::Range<usize>, brought: &Brought<S>) -> Option<usize> {
    held.contains(&brought.block).then(|| brought.block - held.start)
}
