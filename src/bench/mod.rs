//! Measurements of speed, for `scree bench`.

use std::time::Instant;

use scree_partition::{HaloCounts, Transport};

use crate::base::error::Error;
use crate::base::space::Space;
use crate::domain::world::World;

pub mod dem;
pub mod gauge;
pub mod mpm;
pub mod rve;
pub mod scaling;

/// What is timed: stretches of steps, the median of which counts.
#[derive(Clone, Copy, Debug)]
pub struct Stretches {
    /// Timed one after the other.
    pub count: usize,
    /// Of each stretch.
    pub steps: u64,
}

/// How fast a world of grains alone, or of points alone, goes on. Times are of the slowest rank where ranks differ.
#[derive(Clone, Debug)]
pub struct Speed {
    /// "plane" or "solid".
    pub space: &'static str,
    /// Vector registers that contacts are computed with: "portable", "avx2" or "avx512".
    pub instructions: &'static str,
    /// Grains or points.
    pub rows: u64,
    /// Of MPI; 1 where it is not used.
    pub ranks: usize,
    /// Of all stretches together.
    pub steps: u64,
    /// Wall time of a row's step, every stretch, ns.
    pub stretches: Vec<f64>,
    /// Rebuilds of the neighbour lists, with migration and ghosts, during these steps.
    pub rebuilds: u64,
    /// Resident memory of all ranks beyond what the program took before.
    pub bytes_resident_per_row: f64,
    /// Name, ns per row and step as the mean over ranks, and the slowest rank over that mean.
    pub phases: Vec<(&'static str, f64, f64)>,
    /// Most rows on a rank over their mean.
    pub imbalance: f64,
    /// Messages and bytes of a step, of all ranks together.
    pub messages: f64,
    /// Bytes of those messages, per step.
    pub bytes: f64,
}

impl Speed {
    /// Of a world that is warm, on all ranks; `resident` is what the program took before there was a world, bytes.
    fn of<S: Space>(
        world: &mut World<S>,
        wanted: Stretches,
        resident: i64,
        transport: &dyn Transport,
    ) -> Result<Self, Error> {
        let rebuilds = world.rebuilds;
        world.phases.seconds = Default::default();
        world.subdomain.sent = HaloCounts::default();
        let rows = world.grains_total + world.points_total;
        let mut stretches = Vec::with_capacity(wanted.count);
        for _ in 0..wanted.count {
            transport.barrier();
            let started = Instant::now();
            for _ in 0..wanted.steps {
                world.advance()?;
            }
            let mut seconds = [started.elapsed().as_secs_f64()];
            transport.max(&mut seconds);
            stretches.push(1e9 * seconds[0] / (wanted.steps * rows) as f64);
        }
        let steps = wanted.steps * wanted.count as u64;
        let scale = 1e9 / (steps * rows) as f64;
        let phases = world.phases.over_ranks(transport);
        let mut resident = [(resident_bytes() - resident).max(0)];
        transport.sum(&mut resident);
        let mut most = [(world.assembly.grains.owned + world.continuum.points.len()) as i64];
        transport.max_integer(&mut most);
        let mut sent = [world.subdomain.sent.messages as i64, world.subdomain.sent.bytes as i64];
        transport.sum(&mut sent);
        let [messages, bytes] = sent.map(|sum| sum as f64 / steps as f64);
        Ok(Self {
            messages,
            bytes,
            space: S::NAME,
            instructions: world.assembly.contacts.instructions().name(),
            rows,
            ranks: transport.size(),
            steps,
            stretches,
            rebuilds: world.rebuilds - rebuilds,
            bytes_resident_per_row: resident[0] as f64 / rows as f64,
            phases: phases.into_iter().map(|(name, [_, mean, most])| (name, mean * scale, most / mean)).collect(),
            imbalance: most[0] as f64 * transport.size() as f64 / rows as f64,
        })
    }

    /// Median stretch, ns per row and step.
    pub fn nanoseconds(&self) -> f64 {
        let mut sorted = self.stretches.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

/// Memory of this process that lies in the machine's, bytes; zero where the system does not tell.
fn resident_bytes() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|rest| rest.split_whitespace().next()?.parse::<i64>().ok());
    1024 * kilobytes.unwrap_or(0)
}
