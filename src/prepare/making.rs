//! A packing in the making: worlds of grains that are stepped until they rest, saved now and then, stopped when that is asked
//! for, and gone on with by whoever wants the packing next, to the same bits.
//!
//! Whoever makes one tries once or several times, and an attempt has legs, each with settings of its own, of which each ends at
//! rest:
//!
//! ```text
//! making.begin(attempt)
//! world = making.taken_up()? or a fresh one
//! making.equilibrate(world, leg, settings, look)      as many as there are; those that are behind it are passed over
//! making.notes().set(...)                               what later attempts must know
//! making.finish(state)
//! ```

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use scree_io::column::State;
use scree_io::store;
use scree_partition::Transport;
use serde::{Deserialize, Serialize};

use super::cache::Held;
use crate::base::error::Error;
use crate::base::math;
use crate::base::space::Space;
use crate::dem::law::memory_words;
use crate::domain::meter::Meter;
use crate::domain::stop::{self, Wish};
use crate::domain::transfer;
use crate::domain::world::World;
use crate::law::contact::Contact;
use crate::prepare::sheared::on_root;
use crate::store::checkpoint::{self, Progress, Snapshot, Target};

/// Where a packing in the making is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Position {
    attempt: u64,
    leg: u64,
    /// Looks in a row that have found it at rest.
    calm: u32,
    /// Steps since the last look.
    since: u64,
    notes: Notes,
    /// What the looks of this leg remember.
    of_leg: Notes,
}

/// Numbers that whoever goes on must find as they were, and no table of the world holds: what attempts have come to, for those
/// after them, and what the looks of a leg have set. As bits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes(BTreeMap<String, u64>);

impl Notes {
    /// Takes the place of what has been set by that name.
    pub fn set(&mut self, name: &str, value: f64) {
        self.0.insert(name.to_string(), value.to_bits());
    }

    /// None where nothing of that name has been set, or it has been forgotten.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied().map(f64::from_bits)
    }

    /// Takes away what has been set by that name, if anything has.
    pub fn forget(&mut self, name: &str) {
        self.0.remove(name);
    }
}

/// The attribute of a saved state that tells its position.
const POSITION: &str = "making";

/// How a leg is equilibrated.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// For a person.
    pub name: &'static str,
    /// Whether lists must be made anew when it begins, since the reach of the law may be another.
    pub rebuilds: bool,
    /// Steps between two looks at whether everything rests, and looks in a row that must find it so.
    pub look_every: u64,
    /// Looks in a row that must find rest.
    pub calm_looks: u32,
    /// Kinetic energy of the grains that bear, over elastic energy or what the leg holds it against, at which it rests.
    pub goal: f64,
}

/// What a look sees.
pub struct Look {
    /// Whether everything rests now.
    pub rests: bool,
    /// Energy ratio, to be held against the goal.
    pub ratio: f64,
    /// What else a person wants to know.
    pub words: String,
}

/// The making of a packing, on every rank.
pub struct Making<'t> {
    transport: &'t dyn Transport,
    /// On rank 0.
    held: Option<Held>,
    at: Position,
    /// What a process before this one has left, and the state, which rank 0 holds until it is taken up.
    left: Option<(Position, Option<State>)>,
    save_every: Duration,
    saved: Instant,
    meter: Meter,
}

impl<'t> Making<'t> {
    /// Goes on from what is saved, if that is whole. Collective.
    pub(super) fn new(transport: &'t dyn Transport, held: Option<Held>, save_every: Duration) -> Result<Self, Error> {
        let left = transfer::agree(transport, on_root(transport, || Ok(held.as_ref().and_then(left_in))))?.flatten();
        let (position, state) = left.unzip();
        let text = position.map_or(String::new(), |position: Position| json(&position));
        let text = String::from_utf8_lossy(&transport.broadcast(text.into_bytes())).into_owned();
        let position: Option<Position> = serde_json::from_str(&text).ok();
        let at = Position {
            notes: position.as_ref().map(|left| left.notes.clone()).unwrap_or_default(),
            ..Position::default()
        };
        let left = position.map(|position| (position, state));
        Ok(Self { transport, held, at, left, save_every, saved: Instant::now(), meter: Meter::foreseen() })
    }

    /// Of the ranks that make it together.
    pub fn transport(&self) -> &'t dyn Transport {
        self.transport
    }

    /// An attempt begins, or is where it was left; what is left of another is of no use.
    pub fn begin(&mut self, attempt: u64) {
        (self.at.attempt, self.at.leg) = (attempt, 0);
        self.left.take_if(|(left, _)| left.attempt != attempt);
    }

    /// The state in which this attempt was left, under that law, where it was; rank 0 holds it. Collective.
    pub fn taken_up<S: Space>(&mut self, contact: &Contact) -> Result<Option<LeftOf<S>>, Error> {
        let Some((_, state)) = &mut self.left else { return Ok(None) };
        let read = |state| Snapshot::from_state(state, memory_words::<S>(contact));
        let snapshot = transfer::agree(self.transport, state.take().map(read).transpose())?;
        if let Some(snapshot) = &snapshot {
            tracing::info!(step = snapshot.progress.step, "going on with a packing in the making");
        }
        Ok(Some(snapshot))
    }

    /// What attempts have come to.
    pub fn notes(&mut self) -> &mut Notes {
        &mut self.at.notes
    }

    /// Steps a world under the settings of a leg until everything rests. One that a taken-up state has behind it is passed over.
    /// Settings that a look changes, or that depend on the world as the leg found it, must be in the notes of the leg: they are
    /// empty when it begins, and as they were when it is gone on with, which calls `set` again.
    pub fn equilibrate<S: Space>(
        &mut self,
        world: &mut World<'_, S>,
        leg: Leg,
        set: impl FnOnce(&mut World<'_, S>, &mut Notes),
        mut look: impl FnMut(&mut World<'_, S>, &mut Notes) -> Result<Look, Error>,
    ) -> Result<(), Error> {
        self.at.leg += 1;
        match self.left.take_if(|(left, _)| left.leg <= self.at.leg) {
            None if self.left.is_some() => return Ok(()),
            Some((left, _)) if left.leg == self.at.leg => {
                self.at = left;
                set(world, &mut self.at.of_leg);
            }
            _ => {
                (self.at.calm, self.at.since, self.at.of_leg) = (0, 0, Notes::default());
                set(world, &mut self.at.of_leg);
                if leg.rebuilds {
                    world.rebuild()?;
                }
            }
        }
        self.meter = Meter::foreseen();
        self.reserve(world, Duration::ZERO);
        let (started, first, mut farthest) = (Instant::now(), world.step, 0.0_f64);
        while self.at.calm < leg.calm_looks {
            self.step(world, leg.look_every)?;
            let seen = look(world, &mut self.at.of_leg)?;
            self.at.since = 0;
            self.at.calm = if seen.rests { self.at.calm + 1 } else { 0 };
            if self.transport.rank() == 0 {
                if seen.ratio.is_finite() {
                    farthest = farthest.max(seen.ratio);
                }
                let pace = 1e6 * started.elapsed().as_secs_f64() / (world.step - first).max(1) as f64;
                let head = || format!("{}: step {}, {pace:.1} us a step", leg.name, world.step);
                let words = || {
                    format!("kinetic over elastic energy {:.1e} (goal {:.1e}), {}", seen.ratio, leg.goal, seen.words)
                };
                self.meter.show(share(seen.ratio, leg.goal, farthest), head, words);
            }
        }
        self.meter.finish();
        Ok(())
    }

    /// The steps that are left until the next look; saves and stops on the way where that is wished.
    fn step<S: Space>(&mut self, world: &mut World<'_, S>, look_every: u64) -> Result<(), Error> {
        while self.at.since < look_every {
            world.wish = self.wish();
            world.advance()?;
            self.at.since += 1;
            if world.wish_agreed != Wish::None {
                self.save(world)?;
            }
            if world.wish_agreed == Wish::Stop {
                return Err(Error::Stopped(world.step));
            }
        }
        Ok(())
    }

    fn wish(&self) -> Wish {
        let asked = stop::wish();
        let is_due = self.held.is_some() && self.saved.elapsed() >= self.save_every;
        if is_due { asked.max(Wish::Save) } else { asked }
    }

    /// Writes the state as it is, and where in the making that is. Collective.
    fn save<S: Space>(&mut self, world: &World<'_, S>) -> Result<(), Error> {
        let started = Instant::now();
        let target = on_root(self.transport, || {
            let held = self.held.as_ref().expect("rank 0 holds the packing");
            let progress = Progress { step: world.step, ..Progress::default() };
            let mut head = checkpoint::head(world, progress, String::new()).to_state();
            head.attributes.insert(POSITION.to_string(), json(&self.at));
            Ok(Target { scratch: held.folder()?.to_path_buf(), path: held.progress(), head })
        });
        let target = transfer::agree(self.transport, target)?;
        checkpoint::write(target, world)?;
        self.saved = Instant::now();
        self.reserve(world, started.elapsed());
        stop::saved();
        Ok(())
    }

    /// Keeps time for the last save.
    fn reserve<S: Space>(&self, world: &World<'_, S>, took: Duration) {
        let rows = world.grains_total + world.points_total;
        stop::reserve(stop::RESERVE_LEAST + (2 * took).max(stop::ROW_SAVED * rows as u32));
    }

    /// Keeps what an attempt has come to beside its saved state; on rank 0.
    pub fn keep(&self, attempt: u64, state: &State) -> Result<(), Error> {
        let Some(held) = &self.held else { return Ok(()) };
        let folder = held.folder()?;
        store::write_in(folder, &folder.join(attempt_file(attempt)), state)
            .map_err(|error| Error::Run(error.to_string()))
    }

    /// What an attempt has come to, where that has been kept; on rank 0.
    pub fn kept(&self, attempt: u64) -> Option<State> {
        let held = self.held.as_ref()?;
        store::read(&held.folder().ok()?.join(attempt_file(attempt))).ok()
    }

    /// Gives the packing its name, and lets others have it; `state` is asked for on rank 0. Collective.
    pub fn finish(self, state: impl FnOnce() -> State) -> Result<(), Error> {
        let finished = match self.held {
            Some(held) => held.finish(&state()),
            None => Ok(()),
        };
        transfer::agree(self.transport, finished)
    }
}

/// A state that was left, on rank 0.
pub type LeftOf<S> = Option<Snapshot<S>>;

/// What a stopped process has left, if it can be read; what cannot is begun again.
fn left_in(held: &Held) -> Option<(Position, State)> {
    let path = held.progress();
    if !path.exists() {
        return None;
    }
    let read = store::read(&path).map_err(|error| error.to_string()).and_then(|state| {
        let position = state.attribute(POSITION).map_err(|error| error.to_string())?;
        let position = serde_json::from_str(position).map_err(|error| error.to_string())?;
        Ok((position, state))
    });
    read.inspect_err(|why| tracing::warn!("warning: {why}; the packing is made from its beginning")).ok()
}

fn json<T: Serialize>(value: &T) -> String {
    serde_json::to_string(value).expect("numbers and names are written")
}

fn attempt_file(attempt: u64) -> String {
    format!("attempt-{attempt}.h5")
}

/// How far a ratio that falls by the same factor in the same time is on its way from where it was largest to the goal.
fn share(ratio: f64, goal: f64, farthest: f64) -> f64 {
    match ratio > goal && farthest > goal {
        true if ratio.is_finite() => 1.0 - math::ln(ratio / goal) / math::ln(farthest / goal),
        true => 0.0,
        false => f64::from(u8::from(ratio <= goal)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_that_falls_evenly_is_half_way_at_its_geometric_mean() {
        assert_eq!(share(1e-4, 1e-4, 1.0), 1.0);
        assert!((share(1e-2, 1e-4, 1.0) - 0.5).abs() < 1e-12);
        assert_eq!(share(f64::INFINITY, 1e-4, 1.0), 0.0);
        assert_eq!(share(f64::NAN, 1e-4, 0.0), 0.0);
    }
}
