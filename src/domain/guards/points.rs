//! What tells that a continuum has left physics: points that are inverted or torn, too fast for the step, or outside of the
//! grid. Of several the one of lowest id is named, whichever rank has it.

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::numbers::Numbers;
use crate::base::space::{Linear, Space};
use crate::domain::world::World;
use crate::job::mpm::figures::step_through;
use crate::mpm::points::Hot;
use crate::mpm::stress::StressModel;

/// Below this share of its volume at the start a point counts as inverted: no law here means so much compression, and from
/// there one more step turns it inside out.
const VOLUME_MIN: f64 = 0.1;

/// Numbers that are told of a point beside its id and place.
const TOLD: usize = 2;
/// Bytes of a point in the message in which ranks tell of theirs: id, place, numbers.
const BYTES: usize = 8 * (1 + 3 + TOLD);

/// A point that stops the run.
struct Culprit {
    id: PointId,
    /// m.
    place: [f64; 3],
    told: [f64; TOLD],
}

/// `det F`, and how far its edges have been stretched over how far they may be.
///
/// Neighbours stand one edge apart at the start. Where an edge is longer than the reach of the shape functions they share no
/// node any more, and what was one body is torn by the grid alone (numerical fracture). A point that has flowed has other
/// neighbours by now; its edges are those of a cube of its volume.
fn deformation_of<S: Space>(law: &dyn StressModel<S>, hot: &Hot<S>, reach: f64) -> [f64; TOLD] {
    let ratio = hot.volume_ratio();
    let share = match law.plastic_strain(&hot.memory) > 0.0 {
        true => ratio / (0..S::DIMENSION).fold(1.0, |volume, _| volume * reach),
        false => {
            let edge = |axis: usize| {
                let square = |row: usize| {
                    hot.deformation[axis * S::DIMENSION + row] * hot.deformation[axis * S::DIMENSION + row]
                };
                (0..S::DIMENSION).map(square).sum::<f64>().sqrt()
            };
            (0..S::DIMENSION).map(edge).fold(0.0, f64::max) / reach
        }
    };
    [ratio, share]
}

impl<S: Space> World<'_, S> {
    /// Stops a run whose points are no continuum any more, or are too fast for its step. Collective.
    pub fn refuse_spoilt_points(&self) -> Result<(), Error> {
        if !self.has_points() {
            return Ok(());
        }
        self.refuse_infinite_points()?;
        self.refuse_torn_points()?;
        self.refuse_fast_points()
    }

    pub(crate) fn refuse_infinite_points(&self) -> Result<(), Error> {
        let spoilt = |hot: &Hot<S>| (!hot.numbers().iter().all(|number| number.is_finite())).then_some([0.0; TOLD]);
        self.refuse_lowest(spoilt, |_| {
            "has a velocity, stress or deformation that is no finite number; the run is unstable: shorten `time.step`, check loads and moduli, and go on from an earlier checkpoint".to_string()
        })
    }

    fn refuse_torn_points(&self) -> Result<(), Error> {
        let reach_in_edges = |hot: &Hot<S>| {
            let edge = self.edge_of(hot) / self.subdomain.layout.cell;
            self.settings.grid.shape.reach(edge) / edge
        };
        let spoilt = |hot: &Hot<S>| {
            let [ratio, share] = deformation_of(&*self.settings.material, hot, reach_in_edges(hot));
            // Elements share their nodes however far they are stretched.
            (ratio <= VOLUME_MIN || (share > 1.0 && !self.has_elements())).then_some([ratio, share])
        };
        self.refuse_lowest(spoilt, |[ratio, share]| match ratio <= VOLUME_MIN {
            true => format!(
                "is inverted or crushed: det F = {ratio:.3e}, and below {VOLUME_MIN} no law means anything; the run is unstable or far too loaded for its stiffness: shorten `time.step`, take a stiffer material or smaller loads, and go on from an earlier checkpoint"
            ),
            false => format!(
                "is torn: det F = {ratio:.3e}, and it is stretched to {share:.3} times what its neighbours at the start can be away and still share a node with it; take larger cells, shape functions that reach farther, or smaller loads, and go on from an earlier checkpoint"
            ),
        })
    }

    /// Waves and motion cross no more than a cell in a step. Waves are those of the stiffness at the start with what stress
    /// adds to it, `c^2 = (M + |tau|)/density`.
    fn refuse_fast_points(&self) -> Result<(), Error> {
        let modulus = self.settings.material.p_wave_modulus();
        let wave_of = |hot: &Hot<S>| ((modulus + hot.kirchhoff().norm()) * hot.volume / hot.mass).sqrt();
        // Elements go along with their material: waves alone cross them.
        let stiffest = self.settings.meshed.as_ref().map(|meshed| meshed.stiffest.sqrt());
        let step_of = |hot: &Hot<S>| match stiffest {
            Some(stiffest) => 2.0 / (wave_of(hot) * stiffest),
            None => step_through(self.subdomain.layout.cell, wave_of(hot), hot.velocity.norm()),
        };
        let mut tightest =
            [self.continuum.points.hot.iter().map(step_of).fold(f64::INFINITY, f64::min)].map(|step| -step);
        self.transport.max(&mut tightest);
        let [wanted] = tightest.map(|step| -step);
        if self.dt_of_continuum() <= wanted {
            return Ok(());
        }
        let spoilt = |hot: &Hot<S>| (step_of(hot) <= wanted).then(|| [hot.velocity.norm(), wave_of(hot)]);
        self.refuse_lowest(spoilt, |[speed, wave]| match stiffest {
            Some(_) => format!(
                "has waves of {wave:.3e} m/s under its stress, for which a step of {:.6e} s is not stable in its elements: a `time.step` of at most {wanted:.3e} s is needed now, or larger elements; run the job again with a shorter step",
                self.dt_of_continuum()
            ),
            None => format!(
                "moves at {speed:.3e} m/s among waves of {wave:.3e} m/s and with them crosses more than a cell of {:.3e} m in a step of {:.6e} s: a `time.step` of at most {wanted:.3e} s is needed now, or larger cells; run the job again with a shorter step",
                self.subdomain.layout.cell,
                self.dt_of_continuum()
            ),
        })
    }

    /// Stops a run that a point has left through a face of the grid. Places are those before a rebuild wraps them.
    pub(crate) fn refuse_strays(&self) -> Result<(), Error> {
        if !self.has_points() {
            return Ok(());
        }
        let spoilt = |hot: &Hot<S>| {
            let (mut place, mut velocity) = (hot.position, hot.velocity);
            self.assembly.cell.wrap(&mut place, &mut velocity);
            self.subdomain.layout.place::<S>(&self.assembly.cell.fraction(&place), 1).is_none().then_some([0.0; TOLD])
        };
        let extents: Vec<String> = (0..S::DIMENSION)
            .map(|axis| self.subdomain.layout.extent(axis).map(|end| format!("{end:.6e}")).join(" to "))
            .collect();
        self.refuse_lowest(spoilt, |_| {
            format!(
                "is outside of the grid, which reaches from {} m; the run is unstable, or the grid too small: check `time.step` and the last frames, or move the edges of the grid outwards (grid.lower and grid.upper)",
                extents.join(" and from ")
            )
        })
    }

    /// Edge of a point's cube at the start, m.
    fn edge_of(&self, hot: &Hot<S>) -> f64 {
        match S::DIMENSION {
            2 => (hot.volume / self.settings.grid.depth).sqrt(),
            _ => crate::base::math::cbrt(hot.volume),
        }
    }

    /// Stops the run where `spoilt` tells something of a point, in words about the one of lowest id.
    fn refuse_lowest(
        &self,
        spoilt: impl Fn(&Hot<S>) -> Option<[f64; TOLD]>,
        words: impl FnOnce([f64; TOLD]) -> String,
    ) -> Result<(), Error> {
        let Some(Culprit { id, place, told }) = self.lowest(spoilt) else { return Ok(()) };
        let place: Vec<String> = place[..S::DIMENSION].iter().map(|x| format!("{x:.6e}")).collect();
        Err(Error::Run(format!(
            "step {}, time {:.6e} s: point {} at ({}) m {}",
            self.step,
            self.time(),
            id.0,
            place.join(", "),
            words(told)
        )))
    }

    fn lowest(&self, spoilt: impl Fn(&Hot<S>) -> Option<[f64; TOLD]>) -> Option<Culprit> {
        let rows = self.continuum.points.hot.iter().zip(&self.continuum.points.cold);
        let mine =
            rows.filter_map(|(hot, cold)| Some((cold.id, hot.position, spoilt(hot)?))).min_by_key(|found| found.0);
        let bytes: Vec<u8> = mine
            .into_iter()
            .flat_map(|(id, position, told)| {
                let place =
                    std::array::from_fn::<_, 3, _>(|axis| if axis < S::DIMENSION { position[axis] } else { 0.0 });
                let numbers = place.into_iter().chain(told).map(f64::to_bits);
                std::iter::once(id.0).chain(numbers).collect::<Vec<u64>>()
            })
            .flat_map(u64::to_le_bytes)
            .collect();
        let all = self.transport.all_gather(&bytes);
        let found = all.iter().flat_map(|bytes| bytes.as_chunks::<BYTES>().0).map(|bytes| {
            let word = |at: usize| u64::from_le_bytes(*bytes[8 * at..].first_chunk().expect("six words"));
            let number = |at: usize| f64::from_bits(word(at));
            Culprit { id: PointId(word(0)), place: [1, 2, 3].map(number), told: [4, 5].map(number) }
        });
        found.min_by_key(|culprit| culprit.id)
    }
}
