//! The nonlocal operator over ranks: which points of others are around those that are here, and what travels of them in a step.

use rayon::prelude::*;
use scree_partition::{Halo, HaloBuffers, Reader, Writer};

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::lane::LANES;
use crate::base::space::{Linear, Space};
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::mpm::nonlocal::{Averaging, Bins, Nonlocal, Places, Seen, Weights};
use crate::mpm::points::{Cold, Hot};

/// Points whose means are one task.
const ROWS_AT_ONCE: usize = 64;

/// Points around those of this rank.
pub struct Neighbourhood<S: Space> {
    pub(super) weights: Weights,
    halo: Halo,
    buffers: HaloBuffers,
    /// What is averaged, of all of them, and its means; made and used within a step.
    rows: Vec<[f64; LANES]>,
    means: Vec<[f64; LANES]>,
    /// What points bore for their deviations at the end of the last step, Pa; none where it has not been reckoned since rows were laid.
    pub(super) overlay: Option<Vec<S::Symmetric>>,
}

impl<S: Space> Default for Neighbourhood<S> {
    fn default() -> Self {
        Self {
            weights: Weights::default(),
            halo: Halo::default(),
            buffers: HaloBuffers::default(),
            rows: Vec::new(),
            means: Vec::new(),
            overlay: None,
        }
    }
}

impl<S: Space> Neighbourhood<S> {
    /// Lays out `W` words for each of the points of this rank and of those around them, which are `copies` more, and gives copies what their originals have.
    fn bring<const W: usize>(
        &mut self,
        transport: &dyn scree_partition::Transport,
        owned: usize,
        word: impl Fn(usize, usize) -> f64,
    ) {
        let Self { halo, buffers, rows, .. } = self;
        let (packs, copies) = (W.div_ceil(LANES), halo.receives.iter().map(|(_, rows)| rows.len()).sum::<usize>());
        rows.resize((owned + copies) * packs, [0.0; LANES]);
        for (row, packs) in rows[..owned * packs].chunks_exact_mut(packs).enumerate() {
            (0..W).for_each(|at| packs[at / LANES][at % LANES] = word(row, at));
        }
        halo.pack::<W>(buffers, |row| std::array::from_fn(|at| rows[row as usize * packs + at / LANES][at % LANES]));
        halo.exchange::<W>(transport, buffers, &mut || ());
        halo.unpack::<W>(buffers, |row, words| {
            (0..W).for_each(|at| rows[row as usize * packs + at / LANES][at % LANES] = words[at]);
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
        let mut around: Neighbourhood<S> = Neighbourhood { halo, ..Neighbourhood::default() };
        let transport = self.transport;
        let everyones = |mine: &[f64]| {
            around.bring::<1>(transport, owned, |row, _| mine[row]);
            around.rows.iter().map(|words| words[0]).collect()
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

    /// Means over the points around each of this rank, of as many tensors of every point as are given. Collective.
    pub(crate) fn averaged_around<const N: usize>(&mut self, own: [&[S::Tensor]; N]) -> [Vec<S::Tensor>; N] {
        const { assert!(N == 1 || N == 2, "one tensor or two at a time") };
        match (S::DIMENSION, N) {
            (2, 1) => self.averaged_words::<4, N>(own),
            (2, _) => self.averaged_words::<8, N>(own),
            (_, 1) => self.averaged_words::<9, N>(own),
            (_, _) => self.averaged_words::<18, N>(own),
        }
    }

    /// The same of tensors that are `W` words together.
    fn averaged_words<const W: usize, const N: usize>(&mut self, own: [&[S::Tensor]; N]) -> [Vec<S::Tensor>; N] {
        let (owned, packs, of_one) = (own[0].len(), W.div_ceil(LANES), W / N);
        let (transport, instructions) = (self.transport, self.assembly.contacts.instructions());
        let around = &mut self.neighbourhood;
        let timer = self.phases.start();
        around.bring::<W>(transport, owned, |row, at| own[at / of_one][row][at % of_one]);
        self.phases.stop(Phase::Halo, timer);
        let timer = self.phases.start();
        let Neighbourhood { weights, rows, means, .. } = around;
        means.resize(owned * packs, [0.0; LANES]);
        let tasks = means.par_chunks_mut(ROWS_AT_ONCE * packs).enumerate();
        tasks.for_each(|(task, means)| {
            instructions.run(Averaging { weights, first: task * ROWS_AT_ONCE, packs, rows, means });
        });
        let tensor = |number: usize, packs: &[[f64; LANES]]| {
            let mut tensor = S::Tensor::zero();
            (0..of_one).for_each(|at| tensor[at] = packs.as_flattened()[number * of_one + at]);
            tensor
        };
        let means =
            std::array::from_fn(|number| means.chunks_exact(packs).map(|packs| tensor(number, packs)).collect());
        self.phases.stop(Phase::Gather, timer);
        means
    }
}
