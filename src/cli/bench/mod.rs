//! `scree bench`: what a step costs on this machine.

use std::fmt::Write;

use clap::{Args, Subcommand};
use scree_partition::transport::Transport;
use serde_json::{Map, Value, json};

use super::cores::Placement;
use super::launch::{Launcher, is_launched};
use super::{Ending, start_threads_of};
use crate::base::error::Error;
use crate::bench::{Speed, Stretches, dem, mpm, rve};
use crate::run::Outcome;

mod scaling;

#[derive(Subcommand)]
pub(super) enum Bench {
    /// A sheared dense packing of grains: the whole step with rebuilds, messages and servo.
    Dem {
        /// Grains, about: the packing is made of equal tiles.
        #[arg(long, default_value_t = 7640)]
        grains: u64,
        /// Discs of Chen et al. (2021), Table 1 (plane), or Hertz-Mindlin spheres (solid).
        #[arg(long, default_value = "plane", value_parser = ["plane", "solid"])]
        space: String,
        #[command(flatten)]
        how: How,
    },
    /// A yielding block of material points: the whole step with rebuilds and messages.
    Mpm {
        /// Points, about: whole blocks of cells are filled.
        #[arg(long, default_value_t = 100_000)]
        points: u64,
        /// Plane strain, or space.
        #[arg(long, default_value = "plane", value_parser = ["plane", "solid"])]
        space: String,
        #[arg(long, default_value = "critical_drucker_prager", value_parser = ["critical_drucker_prager", "mobilised_friction"])]
        law: String,
        #[arg(long, default_value = "quadratic", value_parser = ["linear", "generalised", "quadratic", "cubic"])]
        shape: String,
        #[arg(long, default_value = "last", value_parser = ["first", "last", "modified_last"])]
        update: String,
        #[arg(long, default_value = "blend", value_parser = ["blend", "affine"])]
        transfer: String,
        #[command(flatten)]
        how: How,
    },
    /// Representative volume elements of a hierarchical coupling: many periodic assemblies of grains, each of which follows a deformation
    /// gradient; in turns with the packing of `bench dem`. On one rank.
    Rve {
        /// RVEs.
        #[arg(long, default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        elements: u64,
        /// Grains of each.
        #[arg(long, default_value_t = 400, value_parser = clap::value_parser!(u64).range(50..=100_000))]
        grains: u64,
        /// Discs of Liang & Zhao (2019), Table 1 (plane), or Hertz-Mindlin spheres (solid).
        #[arg(long, default_value = "plane", value_parser = ["plane", "solid"])]
        space: String,
        /// Steps of grains in an increment of deformation.
        #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1000))]
        sub_steps: u64,
        #[command(flatten)]
        how: How,
    },
    /// A job on several numbers of ranks: speed-up, efficiency, time per phase, and that the results are the same.
    Scaling(scaling::Wanted),
}

#[derive(Args)]
pub(super) struct How {
    /// Ranks; more than one are started by mpirun.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    ranks: u16,
    /// Steps of each of the five stretches whose median counts. Default: about two seconds' worth.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    steps: Option<u64>,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// End with one line of JSON.
    #[arg(long)]
    json: bool,
}

/// Stretches whose median counts.
const STRETCHES: usize = 5;
/// Grain-steps of a stretch by default.
const WORK: u64 = 60_000_000;
const STEPS_MIN: u64 = 500;

/// Point-steps of a stretch by default.
const POINT_WORK: u64 = 15_000_000;
const POINT_STEPS_MIN: u64 = 20;

pub(super) fn command(what: &Bench, transport: &dyn Transport) -> Ending {
    let how = match what {
        Bench::Dem { how, .. } | Bench::Mpm { how, .. } | Bench::Rve { how, .. } => how,
        Bench::Scaling(wanted) => return Ending::Agreed(scaling::command(wanted)),
    };
    let (ranks, threads) = (usize::from(how.ranks), usize::from(how.threads));
    if ranks > 1 && transport.size() == 1 && !is_launched() {
        return Ending::Agreed(launch(ranks, threads));
    }
    if transport.size() != ranks && transport.size() > 1 && ranks > 1 {
        return Ending::Agreed(Err(Error::User(format!(
            "--ranks {ranks}, but mpirun started {} ranks. Leave out one of the two.",
            transport.size()
        ))));
    }
    if let (Bench::Rve { .. }, 2..) = (what, ranks) {
        return Ending::Agreed(Err(Error::User(
            "bench rve measures one rank. Leave out --ranks, and see --threads.".into(),
        )));
    }
    if let Bench::Dem { grains: ..500, .. } = what {
        return Ending::Agreed(Err(Error::User(
            "fewer than 500 grains cannot be sheared between rough layers. Take --grains 500 or more.".into(),
        )));
    }
    if let Err(error) = start_threads_of(&Placement::of(transport, Some(how.threads))) {
        return Ending::Failed(error);
    }
    let stretches = |work: u64, least: u64| Stretches { count: STRETCHES, steps: how.steps.unwrap_or(work.max(least)) };
    let page = match what {
        Bench::Dem { grains, space, .. } => {
            let stretches = stretches(WORK / grains, STEPS_MIN);
            let wanted = dem::Wanted { grains: *grains, solid: space == "solid", stretches };
            dem::measure(&wanted, transport).map(|measured| page_of_grains(&measured, how))
        }
        Bench::Mpm { points, space, law, shape, update, transfer, .. } => {
            let wanted = mpm::Wanted {
                points: *points,
                solid: space == "solid",
                law: law.clone(),
                shape: shape.clone(),
                update: update.clone(),
                transfer: transfer.clone(),
                stretches: stretches(POINT_WORK / points, POINT_STEPS_MIN),
            };
            mpm::measure(&wanted, transport).map(|measured| page_of_points(&wanted, &measured, how))
        }
        Bench::Rve { elements, grains, space, sub_steps, .. } => {
            let stretches = Stretches { count: STRETCHES, steps: how.steps.unwrap_or(WORK) };
            let (solid, sub_steps) = (space == "solid", *sub_steps);
            let wanted = rve::Wanted { elements: *elements, grains: *grains, solid, sub_steps, stretches };
            rve::measure(&wanted, transport).map(|measured| page_of_elements(&wanted, &measured, how))
        }
        Bench::Scaling(_) => unreachable!("it has been returned above"),
    };
    match page {
        Ok(page) => Ending::Agreed(Ok(Outcome::Done(page))),
        Err(error) => Ending::Failed(error),
    }
}

/// The same command on several ranks.
fn launch(ranks: usize, threads: usize) -> Result<Outcome, Error> {
    let program = std::env::current_exe().map_err(|error| Error::Run(format!("where is this program? {error}")))?;
    let launcher = Launcher::find()?;
    if ranks * threads > launcher.cores {
        tracing::warn!(
            "warning: {ranks} ranks of {threads} threads share {} cores, so times are not those of {} cores",
            launcher.cores,
            ranks * threads
        );
    }
    let status = launcher
        .command(ranks, threads, program)
        .args(std::env::args_os().skip(1))
        .status()
        .map_err(|error| Error::Run(format!("mpirun cannot be started any more: {error}")))?;
    match status.success() {
        true => Ok(Outcome::Done(String::new())),
        false => Err(Error::Run(format!("mpirun -n {ranks} ended with {status}; its words are above"))),
    }
}

fn page_of_grains(measured: &dem::Measured, how: &How) -> String {
    let speed = &measured.speed;
    let more = [
        format!(
            "{:.2} contacts and {:.2} listed pairs per grain; imbalance of grains {:.3}; tau/p {:.3}",
            measured.contacts_per_grain, measured.pairs_per_grain, speed.imbalance, measured.stress_ratio
        ),
        format!(
            "{:.0} bytes per grain in arrays, {:.0} resident",
            measured.bytes_per_grain, speed.bytes_resident_per_row
        ),
    ];
    let json = json!({
        "law": measured.law,
        "bytes_per_grain": measured.bytes_per_grain,
        "bytes_resident_per_grain": speed.bytes_resident_per_row,
        "contacts_per_grain": measured.contacts_per_grain,
        "pairs_per_grain": measured.pairs_per_grain,
        "stress_ratio": measured.stress_ratio,
    });
    page("grain", &format!("law {}", measured.law), speed, &more, json, how)
}

fn page_of_points(wanted: &mpm::Wanted, measured: &mpm::Measured, how: &How) -> String {
    let speed = &measured.speed;
    let law = wanted.law.replace('_', " ");
    let scheme = format!("{law}, {} functions, stress {}, {}", wanted.shape, wanted.update, wanted.transfer);
    let more = [format!(
        "imbalance of points {:.3}; mean plastic strain {:.4}; {:.0} bytes per point resident",
        speed.imbalance, measured.plastic_strain, speed.bytes_resident_per_row
    )];
    let json = json!({
        "law": wanted.law,
        "shape": wanted.shape,
        "update": wanted.update,
        "transfer": wanted.transfer,
        "bytes_per_point": speed.bytes_resident_per_row,
    });
    page("point", &scheme, speed, &more, json, how)
}

fn page_of_elements(wanted: &rve::Wanted, measured: &rve::Measured, how: &How) -> String {
    let told = |stretches: &[f64]| stretches.iter().map(|one| format!("{one:.1}")).collect::<Vec<_>>().join(" ");
    let mut page = format!(
        "{} RVEs of {} grains in the {}, {} threads\n{} ns per grain-step, increments of {} steps and all that goes with them\n{} ns per grain-step of the packing of bench dem, in turns\n{:.2} is the median of their ratios\n{:.2} contacts per grain; q/p {:.3}; {:.0} bytes per grain resident\n",
        measured.elements,
        measured.grains,
        measured.space,
        how.threads,
        told(&measured.rve),
        wanted.sub_steps,
        told(&measured.packing),
        measured.ratio(),
        measured.contacts_per_grain,
        measured.stress_ratio,
        measured.bytes_resident_per_grain,
    );
    if how.json {
        let json = json!({
            "elements": measured.elements,
            "grains": measured.grains,
            "space": measured.space,
            "threads": how.threads,
            "ns_per_grain_step": measured.rve,
            "ns_per_grain_step_of_packing": measured.packing,
            "ratio": measured.ratio(),
            "contacts_per_grain": measured.contacts_per_grain,
            "stress_ratio": measured.stress_ratio,
            "bytes_resident_per_grain": measured.bytes_resident_per_grain,
        });
        page += &format!("{json}\n");
    }
    page
}

/// What every measurement tells about its rows, grains or points, around what only this one does.
fn page(row: &str, physics: &str, speed: &Speed, more: &[String], mut json: Value, how: &How) -> String {
    let mut page = String::new();
    let mut line = |text: String| writeln!(page, "{text}").expect("a string takes every line");
    line(format!(
        "{} {row}s in the {}, {physics}, {} ranks of {} threads, {} instructions",
        speed.rows, speed.space, speed.ranks, how.threads, speed.instructions
    ));
    line(format!("{} steps in {} stretches, {} rebuilds", speed.steps, speed.stretches.len(), speed.rebuilds));
    let stretches: Vec<String> = speed.stretches.iter().map(|stretch| format!("{stretch:.1}")).collect();
    line(format!("{:.1} ns per {row}-step, the median of {}", speed.nanoseconds(), stretches.join(" ")));
    line(format!("phase      ns per {row}-step   slowest rank over mean"));
    for (name, mean, most) in &speed.phases {
        line(format!("  {name:<10} {mean:>10.2} {most:>17.2}"));
    }
    line(format!("{:.1} messages and {:.1} kB a step, of all ranks", speed.messages, 1e-3 * speed.bytes));
    more.iter().for_each(|text| line(text.clone()));
    if how.json {
        let phases: Map<String, Value> =
            speed.phases.iter().map(|(name, mean, _)| ((*name).to_string(), json!(mean))).collect();
        json[format!("{row}s")] = json!(speed.rows);
        json[format!("ns_per_{row}_step")] = json!(speed.nanoseconds());
        json["ranks"] = json!(speed.ranks);
        json["threads"] = json!(how.threads);
        json["space"] = json!(speed.space);
        json["instructions"] = json!(speed.instructions);
        json["steps"] = json!(speed.steps);
        json["rebuilds"] = json!(speed.rebuilds);
        json["stretches"] = json!(speed.stretches);
        json["imbalance"] = json!(speed.imbalance);
        json["phases"] = json!(phases);
        json["messages_per_step"] = json!(speed.messages);
        json["bytes_per_step"] = json!(speed.bytes);
        line(json.to_string());
    }
    page
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::{Arguments, with_newline};

    /// Ranks that were started have printed their JSON; what started them has nothing to add, not even an empty line.
    #[test]
    fn json_of_several_ranks_stays_the_last_line() {
        assert_eq!(with_newline(String::new()), "");
        assert_eq!(with_newline("Done".into()), "Done\n");
        assert_eq!(with_newline("Done\n".into()), "Done\n");
    }

    /// A time over no steps is no number.
    #[test]
    fn no_steps_are_refused() {
        let refused = Arguments::try_parse_from(["scree", "bench", "dem", "--steps", "0"]).err();
        let words = refused.expect("nothing can be measured").to_string();
        assert!(words.contains("'--steps <STEPS>'"), "{words}");
        for what in ["dem", "mpm"] {
            assert!(Arguments::try_parse_from(["scree", "bench", what, "--steps", "1"]).is_ok());
            assert!(Arguments::try_parse_from(["scree", "bench", what, "--steps", "0"]).is_err());
        }
    }
}
