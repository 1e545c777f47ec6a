//! The nonlocal operator over ranks: which points of others are around those that are here, and what travels of them in a step.

use rayon::prelude::*;
use scree_partition::{Halo, HaloBuffers, Reader, Writer};

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::{Linear, Space};
use crate::domain::world::World;
use crate::mpm::nonlocal::{Bins, Nonlocal, Places, Seen, Weights};
use crate::mpm::points::{Cold, Hot};

/// Means that a thread takes at a time, at least.
const ROWS_AT_ONCE: usize = 64;

/// Points around those of this rank.
pub struct Neighbourhood<S: Space> {
    pub(super) weights: Weights,
    halo: Halo,
    buffers: HaloBuffers,
    /// What is averaged, of all of them; made and used within a step.
    tensors: Vec<S::Tensor>,
    /// What points bore for their deviations at the end of the last step, Pa; none where it has not been reckoned since rows were laid.
    pub(super) overlay: Option<Vec<S::Symmetric>>,
}

impl<S: Space> Default for Neighbourhood<S> {
    fn default() -> Self {
        Self {
            weights: Weights::default(),
            halo: Halo::default(),
            buffers: HaloBuffers::default(),
            tensors: Vec::new(),
            overlay: None,
        }
    }
}

/// Words of a tensor in a message, in the plane and in space.
const PLANE: usize = 4;
const SOLID: usize = 9;

impl<S: Space> Neighbourhood<S> {
    /// Gives copies what their originals have.
    fn renew(&mut self, transport: &dyn scree_partition::Transport) {
        match S::DIMENSION {
            2 => self.renew_words::<PLANE>(transport),
            _ => self.renew_words::<SOLID>(transport),
        }
    }

    fn renew_words<const W: usize>(&mut self, transport: &dyn scree_partition::Transport) {
        let Self { halo, buffers, tensors, .. } = self;
        halo.pack::<W>(buffers, |row| std::array::from_fn(|word| tensors[row as usize][word]));
        halo.exchange::<W>(transport, buffers, &mut || ());
        halo.unpack::<W>(buffers, |row, words| {
            (0..W).for_each(|word| tensors[row as usize][word] = words[word]);
        });
    }
}

impl<S: Space> World<'_, S> {
    /// Finds the points around those of this rank, after rows have settled, or where places of now are asked for at every step. Collective.
    pub(crate) fn find_neighbourhood(&mut self) -> Result<(), Error> {
        let Some(how) = self.settings.nonlocal else { return Ok(()) };
        let mut seen = self.points_seen(&how);
        let owned = seen.len();
        let everyones = self.exchange_seen(&seen)?;
        let (bins, cell) = (Bins::of(how.radius, &seen), self.assembly.cell);
        let mut halo = Halo::default();
        for (peer, theirs) in everyones.iter().enumerate().filter(|(peer, _)| *peer != self.transport.rank()) {
            // Who is near whom is the same seen from either side, so that both know what travels.
            let mut sends: Vec<u32> = Vec::new();
            let first = seen.len();
            for point in theirs {
                let before = sends.len();
                bins.for_each_near(&seen[..owned], &cell, point, |row, _| sends.push(row as u32));
                if sends.len() > before {
                    seen.push(*point);
                }
            }
            sends.sort_unstable();
            sends.dedup();
            if seen.len() > first {
                halo.sends.push((peer, sends));
                halo.receives.push((peer, first as u32..seen.len() as u32));
            }
        }
        let mut around = Neighbourhood {
            weights: Weights::default(),
            tensors: vec![S::Tensor::zero(); seen.len()],
            halo,
            buffers: HaloBuffers::default(),
            overlay: None,
        };
        let transport = self.transport;
        let everyones = |mine: &[f64]| {
            around.tensors.iter_mut().zip(mine).for_each(|(tensor, sum): (&mut S::Tensor, _)| tensor[0] = *sum);
            around.renew(transport);
            around.tensors.iter().map(|tensor: &S::Tensor| tensor[0]).collect()
        };
        around.weights = Weights::of(&how, (&seen, owned), &cell, everyones);
        self.neighbourhood = around;
        Ok(())
    }

    fn points_seen(&self, how: &Nonlocal) -> Vec<Seen<S>> {
        let points = &self.continuum.points;
        let seen = |(hot, cold): (&Hot<S>, &Cold<S>)| {
            let place = match how.places {
                Places::Reference => cold.origin,
                Places::Current => hot.position,
            };
            // Where points share their place with grains they stand for a part of it.
            Seen { id: cold.id, place, volume: hot.weight * hot.volume }
        };
        points.hot.iter().zip(&points.cold).map(seen).collect()
    }

    /// What every rank sees of its own, by rank, in the order of rows.
    fn exchange_seen(&self, seen: &[Seen<S>]) -> Result<Vec<Vec<Seen<S>>>, Error> {
        let mut mine = Writer::new();
        for point in seen {
            mine.u64(point.id.0);
            (0..S::DIMENSION).for_each(|axis| mine.f64(point.place[axis]));
            mine.f64(point.volume);
        }
        let read = |bytes: Vec<u8>| -> Result<Vec<Seen<S>>, scree_partition::ParcelError> {
            let mut reader = Reader::plain(&bytes);
            let mut seen = Vec::new();
            while reader.left() > 0 {
                let id = PointId(reader.u64()?);
                let mut place = S::Vector::zero();
                for axis in 0..S::DIMENSION {
                    place[axis] = reader.f64()?;
                }
                seen.push(Seen { id, place, volume: reader.f64()? });
            }
            Ok(seen)
        };
        let all = self.transport.all_gather(mine.as_bytes());
        all.into_iter().map(|bytes| read(bytes).map_err(|error| Error::Run(error.to_string()))).collect()
    }

    /// Means of what the points of this rank have, over the points around each. Collective.
    pub(crate) fn averaged_around(&mut self, own: Vec<S::Tensor>) -> Vec<S::Tensor> {
        let (transport, around) = (self.transport, &mut self.neighbourhood);
        let owned = own.len();
        around.tensors[..owned].copy_from_slice(&own);
        around.renew(transport);
        let (weights, tensors) = (&around.weights, &around.tensors);
        let mean = |row| weights.mean(row, |other| tensors[other]);
        (0..owned).into_par_iter().with_min_len(ROWS_AT_ONCE).map(mean).collect()
    }
}
