//! A run whose ranks wait for each other, or for a core, says so with the cause and what to do: nothing else would tell it from one
//! that has much to do.

use std::fs;
use std::time::Instant;

use scree_partition::Transport;
use serde_json::{Value, json};

use super::Run;
use crate::base::error::Error;
use crate::base::space::Space;
use crate::domain::phases::{Phase, Phases, everyones};

/// Time that is looked at together, s.
const WINDOW: f64 = 10.0;
/// Share of it that may be waited without a word.
const SHARE_QUIET: f64 = 0.3;
/// Share for which a rank is kept from its core by others before they are the cause of what all wait.
const SHARE_KEPT: f64 = 0.1;
/// Work of the busiest rank over the mean, above which blocks are the cause.
const UNEVEN: f64 = 1.3;
/// Phases that are waiting where messages are small.
const WAITS: [Phase; 3] = [Phase::Halo, Phase::Agree, Phase::Bodies];
const NANOSECOND: f64 = 1e-9;

/// Time of one rank so far, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spent {
    /// Of the clock.
    wall: f64,
    work: f64,
    waits: f64,
    /// Ready to run while the core did something else.
    kept: f64,
    steps: f64,
}

impl Spent {
    fn to_numbers(self) -> [f64; 5] {
        [self.wall, self.work, self.waits, self.kept, self.steps]
    }

    fn of_numbers(numbers: &[f64]) -> Self {
        let [wall, work, waits, kept, steps] = std::array::from_fn(|index| numbers.get(index).copied().unwrap_or(0.0));
        Self { wall, work, waits, kept, steps }
    }

    fn since(self, before: Self) -> Self {
        let (now, then) = (self.to_numbers(), before.to_numbers());
        Self::of_numbers(&std::array::from_fn::<f64, 5, _>(|index| now[index] - then[index]))
    }
}

/// What runs wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cause {
    Cores,
    Blocks,
    Size,
}

/// What is to be told, once for each cause.
#[derive(Debug)]
pub struct Waits {
    begun: Instant,
    before: Spent,
    told: Vec<Cause>,
}

impl Waits {
    pub fn new() -> Self {
        // The thread has waited before, while the packing was made.
        Self { begun: Instant::now(), before: Spent { kept: kept(), ..Spent::default() }, told: Vec::new() }
    }

    /// Looks at the time since it was last looked at, when that is long enough: words for a person and the same for the log, where
    /// there is something to tell. Collective.
    pub fn look(&mut self, phases: &Phases, steps: u64, transport: &dyn Transport) -> Option<(String, Value)> {
        let (wall, work) = (self.begun.elapsed().as_secs_f64(), phases.busy());
        let now = Spent {
            wall,
            work,
            // Bodies have messages within them, which are booked there.
            waits: WAITS.iter().map(|phase| phases.of(*phase)).sum::<f64>().min(wall - work),
            kept: kept(),
            steps: steps as f64,
        };
        let all = everyones(&now.since(self.before).to_numbers(), transport);
        let ranks: Vec<Spent> = all.iter().map(|numbers| Spent::of_numbers(numbers)).collect();
        // Every rank sees the same numbers.
        if ranks.iter().any(|rank| rank.wall < WINDOW) {
            return None;
        }
        self.before = now;
        let (cause, words, fields) = told(&ranks)?;
        (!self.told.contains(&cause)).then(|| self.told.push(cause))?;
        Some((words, fields))
    }
}

impl<S: Space> Run<'_, '_, S> {
    /// That ranks wait, for each other or for a core, and what to do about it.
    pub(super) fn tell_waits(&mut self) -> Result<(), Error> {
        let world = &self.core.world;
        let (step, steps) = (world.step, world.step - self.first_step);
        let Some((words, fields)) = self.waits.look(&world.phases, steps, world.transport) else { return Ok(()) };
        if self.core.outputs.is_some() {
            tracing::warn!("warning: {words}.");
        }
        self.core.on_root(|outputs| outputs.log("waits", step, fields))
    }
}

/// Time for which this thread could have run and did not, s; where the system does not tell, none.
fn kept() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').nth(1).and_then(|number| number.parse::<f64>().ok()).map_or(0.0, |number| number * NANOSECOND)
}

/// What a stretch of time of all ranks tells, if it tells anything.
fn told(ranks: &[Spent]) -> Option<(Cause, String, Value)> {
    let count = ranks.len() as f64;
    let mean = |of: fn(&Spent) -> f64| ranks.iter().map(of).sum::<f64>() / count;
    let most =
        |of: fn(&Spent) -> f64| (0..ranks.len()).max_by(|a, b| of(&ranks[*a]).total_cmp(&of(&ranks[*b]))).unwrap_or(0);
    // What one rank has of these phases is its own work.
    let waits = if ranks.len() == 1 { 0.0 } else { mean(|rank| rank.waits / rank.wall) };
    let (kept, busiest) = (most(|rank| rank.kept / rank.wall), most(|rank| rank.work));
    let share_kept = ranks[kept].kept / ranks[kept].wall;
    let uneven = ranks[busiest].work / mean(|rank| rank.work).max(f64::MIN_POSITIVE);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let (cause, words) = if share_kept > SHARE_QUIET || waits > SHARE_QUIET && share_kept > SHARE_KEPT {
        let who = if ranks.len() == 1 { "this run".to_owned() } else { format!("rank {kept}") };
        let others = if ranks.len() == 1 {
            String::new()
        } else {
            format!(", and ranks wait for each other {}", percent(waits))
        };
        let less = if ranks.len() == 1 { "wait until they have ended" } else { "take fewer ranks" };
        (
            Cause::Cores,
            format!(
                "other processes share its cores: {who} was kept from running {} of the last {:.0} s{others}. Give it cores of its own (an exclusive node, mpirun --bind-to core), or {less}",
                percent(share_kept),
                ranks[kept].wall
            ),
        )
    } else if waits <= SHARE_QUIET {
        return None;
    } else if uneven > UNEVEN {
        (
            Cause::Blocks,
            format!(
                "ranks wait for each other {} of the time: rank {busiest} has {uneven:.1} times the work of the mean, and no block can be dealt to level that. Make blocks smaller (decomposition.cells_per_block), or take fewer ranks",
                percent(waits)
            ),
        )
    } else {
        let work = 1e6 * mean(|rank| rank.work / rank.steps.max(1.0));
        (
            Cause::Size,
            format!(
                "ranks wait for each other {} of the time: a step has {work:.0} us of work for each of {}, which is little beside its messages. Take fewer ranks; `scree bench scaling` tells how many pay",
                percent(waits),
                ranks.len()
            ),
        )
    };
    let name = match cause {
        Cause::Cores => "cores",
        Cause::Blocks => "blocks",
        Cause::Size => "size",
    };
    let fields = json!({
        "cause": name, "seconds": ranks[0].wall, "waiting_share": waits, "kept_share_most": share_kept, "rank_kept_most": kept,
        "work_most_over_mean": uneven, "rank_busiest": busiest,
    });
    Some((cause, words, fields))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rank(work: f64, waits: f64, kept: f64) -> Spent {
        Spent { wall: 10.0, work, waits, kept, steps: 1e5 }
    }

    #[test]
    fn the_cause_is_told_with_its_remedy() {
        let cause = |ranks: &[Spent]| told(ranks).map(|(cause, words, _)| (cause, words));
        assert!(cause(&[rank(8.0, 1.5, 0.1), rank(7.0, 2.5, 0.1)]).is_none());
        assert!(cause(&[rank(9.0, 0.5, 2.0)]).is_none());
        for (ranks, wanted, words) in [
            (vec![rank(5.0, 4.0, 0.1), rank(4.0, 5.0, 3.0)], Cause::Cores, "rank 1 was kept from running 30 %"),
            (vec![rank(9.0, 0.5, 5.0)], Cause::Cores, "this run was kept from running 50 %"),
            (vec![rank(9.0, 0.5, 0.0), rank(1.0, 8.5, 0.0)], Cause::Blocks, "rank 0 has 1.8 times the work"),
            (vec![rank(5.0, 4.5, 0.0), rank(5.0, 4.5, 0.0)], Cause::Size, "50 us of work for each of 2"),
        ] {
            let (found, said) = cause(&ranks).unwrap();
            assert!(found == wanted && said.contains(words), "{said}");
        }
    }

    /// A cause is told once, of ten seconds at least; one rank waits for no other.
    #[test]
    fn short_stretches_say_nothing_and_a_cause_is_told_once() {
        let looks = |rank: &dyn Transport| {
            let (mut waits, mut phases, mut told) = (Waits::new(), Phases::default(), Vec::new());
            for (seconds, agree) in [(1, 0.8), (12, 9.0), (30, 25.0)] {
                phases.seconds[Phase::Agree as usize] = agree;
                waits.begun = Instant::now() - std::time::Duration::from_secs(seconds);
                told.push(waits.look(&phases, 1000 * seconds, rank));
            }
            told
        };
        let alone = looks(&scree_partition::transport::Solo);
        assert!(alone.iter().all(Option::is_none), "{alone:?}");
        let told = scree_partition::transport::threads::run(2, |rank| looks(&rank));
        for told in &told {
            let (words, fields) = told[1].as_ref().unwrap();
            assert!(words.contains("75 % of the time") && fields["cause"] == "size", "{words}");
            assert!(told[0].is_none() && told[2].is_none(), "{told:?}");
        }
    }
}
