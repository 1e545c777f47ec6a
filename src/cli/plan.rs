//! `scree plan`: what a job would take on ranks that are not here.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use scree_partition::Solo;
use serde_json::{Value, json};

use super::cores::counted;
use super::run::{Wanted, prepare};
use super::start_threads;
use crate::base::error::Error;
use crate::base::units::{Dimension, quantity};
use crate::domain::plan::{Forecast, LoadMap, Network, forecast};
use crate::job::Method;
use crate::run::folder::Scratch;
use crate::run::output::load_file;
use crate::run::{Options, start};

#[derive(Args)]
pub(super) struct Plan {
    /// A job, of which some seconds are run here and thrown away, or the folder of a run that has ended or stopped.
    path: PathBuf,
    /// Numbers of ranks.
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,16,64,256,1024", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    ranks: Vec<u32>,
    /// Plan for so many copies of the world side by side along x.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    times: u32,
    /// Latency of a message.
    #[arg(long, default_value = "1.5 us")]
    latency: String,
    /// Bandwidth of each rank's messages, in GB/s.
    #[arg(long, default_value_t = 5.0)]
    bandwidth: f64,
    /// Seconds of steps that a job is run for.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    seconds: u64,
    /// Override one key of a job, for example --set method=dem. May be repeated.
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// End with one line of JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn command(plan: &Plan) -> Result<String, Error> {
    let network = network(plan)?;
    let map = if plan.path.is_dir() { map_of_run(&plan.path)? } else { measured(plan)? };
    let alone = forecast(&map, plan.times as usize, &network, 1)?;
    let mut foreseen = Vec::with_capacity(plan.ranks.len());
    for ranks in &plan.ranks {
        foreseen.push(forecast(&map, plan.times as usize, &network, *ranks as usize)?);
    }
    let mut page = page(plan, &map, &network, &alone, &foreseen);
    if plan.json {
        page += &format!("{}\n", as_json(&network, &alone, &foreseen));
    }
    Ok(page)
}

fn network(plan: &Plan) -> Result<Network, Error> {
    let latency = quantity(&plan.latency, Dimension::TIME).ok().filter(|latency| *latency >= 0.0);
    let Some(latency) = latency else {
        return Err(Error::User(format!(
            "--latency {} is no time. Write for example --latency \"1.5 us\".",
            plan.latency
        )));
    };
    if plan.bandwidth.is_nan() || plan.bandwidth <= 0.0 {
        return Err(Error::User(format!(
            "--bandwidth {} is no bandwidth in GB/s. Write for example --bandwidth 5.",
            plan.bandwidth
        )));
    }
    Ok(Network { latency, bandwidth: 1e9 * plan.bandwidth })
}

fn map_of_run(dir: &Path) -> Result<LoadMap, Error> {
    let path = load_file(dir);
    let text = fs::read_to_string(&path).map_err(|error| {
        Error::User(format!(
            "{}: {error}. A run writes it when it ends or is stopped; give the folder of such a run, or a job.",
            path.display()
        ))
    })?;
    serde_json::from_str(&text).map_err(|error| {
        Error::User(format!(
            "{}: {error}. It is not what this version of scree writes; run the job again.",
            path.display()
        ))
    })
}

/// Some seconds of a job on one rank of one thread, in a folder that is gone afterwards.
fn measured(plan: &Plan) -> Result<LoadMap, Error> {
    let folder = Scratch(std::env::temp_dir().join(format!("scree-plan-{}", std::process::id())));
    let wanted = Wanted { job: &plan.path, out: Some(folder.0.clone()), go_on: false, sets: &plan.set };
    let (job, options, _) = prepare(&wanted, 1, &Solo)?;
    start_threads(1)?;
    let options = Options { steps_for: Some(Duration::from_secs(plan.seconds)), ..options };
    start::start(&job, &options, &Solo)?;
    let map = map_of_run(&folder.0)?;
    if job.method() == Method::Hybrid && map.grains.iter().all(|rows| *rows == 0) {
        tracing::warn!(
            "warning: in {} s the hybrid found no band, so this is the plan of its continuum; measure for longer with --seconds, or plan from the folder of a run that has",
            plan.seconds
        );
    }
    Ok(map)
}

fn page(plan: &Plan, map: &LoadMap, network: &Network, alone: &Forecast, foreseen: &[Forecast]) -> String {
    let mut page = String::new();
    let mut line = |text: String| writeln!(page, "{text}").expect("a string takes every line");
    let total = |counts: &[u32]| counts.iter().map(|count| u64::from(*count)).sum::<u64>() * u64::from(plan.times);
    let blocks = map.grains.len() as u64 * u64::from(plan.times);
    let of = |count: u64, what: &str| counted(count as usize, what);
    line(format!(
        "{} and {} in {}",
        of(total(&map.grains), "grain"),
        of(total(&map.points), "point"),
        of(blocks, "block")
    ));
    let tiles = if map.shared.is_empty() { 0 } else { blocks };
    let kinds = [
        (total(&map.grains), "a grain"),
        (total(&map.coupled), "more for a grain that shares nodes with points"),
        (total(&map.points), "a point"),
        (tiles, "a tile"),
    ];
    let costs = kinds.iter().zip(map.costs).filter(|((rows, _), _)| *rows > 0);
    let mut costs: Vec<String> = costs.map(|((_, words), cost)| format!("{:.1} ns {words}", 1e9 * cost)).collect();
    if !map.pairs.is_empty() {
        costs.push(format!("{:.1} ns a step of a pair of grains in an RVE", 1e9 * map.pair_cost));
    }
    line(format!(
        "measured over {} on {} of {}: {}",
        of(map.steps, "step"),
        of(map.ranks as u64, "rank"),
        of(map.threads as u64, "thread"),
        costs.join(", ")
    ));
    line(match map.rebuilds > 0.0 {
        true => format!("a rebuild every {:.0} steps, {:.0} ns a row", 1.0 / map.rebuilds, 1e9 * map.rebuild_cost),
        false => "no rebuild has been seen: measure for longer, or plan from a run".to_string(),
    });
    line(format!(
        "network: {:.2} us a message, {:.1} GB/s a rank; messages are taken not to hide behind work",
        1e6 * network.latency,
        1e-9 * network.bandwidth
    ));
    line("   ranks    us a step   speed-up   efficiency   most/mean   messages    kB a step   GB a rank".to_string());
    for forecast in foreseen {
        let speed_up = alone.step / forecast.step;
        line(format!(
            "{:>8} {:>12.1} {:>10.2} {:>12.2} {:>11.2} {:>10} {:>12.1} {:>11.3}",
            forecast.ranks,
            1e6 * forecast.step,
            speed_up,
            speed_up / forecast.ranks as f64,
            forecast.imbalance,
            forecast.messages,
            1e-3 * forecast.bytes as f64,
            1e-9 * forecast.memory,
        ));
    }
    for forecast in foreseen.iter().filter(|forecast| forecast.ranks > 1) {
        let (loss, words) = forecast.bottleneck();
        let share = forecast.losses[loss as usize] / forecast.step;
        line(format!("{}: {:.0} % of a step goes to {words}", counted(forecast.ranks, "rank"), 100.0 * share));
    }
    page
}

fn as_json(network: &Network, alone: &Forecast, foreseen: &[Forecast]) -> Value {
    let of = |forecast: &Forecast| {
        json!({
            "ranks": forecast.ranks,
            "seconds_per_step": forecast.step,
            "efficiency": alone.step / (forecast.step * forecast.ranks as f64),
            "imbalance": forecast.imbalance,
            "messages_per_step": forecast.messages,
            "bytes_per_step": forecast.bytes,
            "bytes_per_rank": forecast.memory,
            "bottleneck": forecast.bottleneck().1,
        })
    };
    json!({
        "latency": network.latency,
        "bandwidth": network.bandwidth,
        "forecasts": foreseen.iter().map(of).collect::<Vec<_>>(),
    })
}
