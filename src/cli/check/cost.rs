//! What a run takes: time, memory, disk.

use super::super::cores::counted;
use super::Slots;
use super::page::{Page, figures, whole};
use crate::job::Method;
use crate::job::assembly::Source;
use crate::observe::contact_frame::BYTES_PER_LINE;
use crate::observe::frame::BYTES_PER_ROW;

pub fn section(page: &mut Page, slots: &Slots) {
    let job = slots.job;
    page.section("Cost");
    page.row("simulated time", &format!("{} s", figures(job.end())), "");
    page.row("steps", &whole(job.steps() as f64), "");
    let Some(forecast) = &slots.forecast else { return };
    let is_hybrid = job.method() == Method::Hybrid;
    let begins_as_grains = is_hybrid && job.begins_as_grains();
    if is_hybrid {
        let rows = format!("{} points, {} grains", whole(forecast.points), whole(forecast.grains));
        let note = format!("about, in zones of {} % of the material", figures(100.0 * forecast.zone));
        let since = if begins_as_grains { "once grains beside a band rest" } else { "after enrichment" };
        page.row(since, &rows, &note);
        let note =
            format!("about, of the steps {}", if begins_as_grains { "from then on" } else { "after enrichment" });
        page.row("speed-up over grains alone", &figures(forecast.speed_up), &note);
    }
    page.row("memory", &format!("{} MB", figures(1e-6 * forecast.memory)), "of all ranks together, about");
    for (label, seconds) in [("making the packing", forecast.piece), ("equilibrating the specimen", forecast.specimen)]
    {
        if seconds > 0.0 {
            page.row(label, &duration(seconds), "about; none where packing.cache has it");
        }
    }
    let costs = [(forecast.cost_of_grain, "a grain"), (forecast.cost_of_point, "a point")];
    let costs: Vec<String> = costs
        .iter()
        .filter(|(cost, _)| *cost > 0.0)
        .map(|(cost, whose)| format!("{} ns {whose}", whole(1e9 * cost)))
        .collect();
    let is_made = slots.grains.as_ref().is_some_and(|grains| matches!(grains.source, Source::Packed(_)));
    let packing = if forecast.piece == 0.0 && is_made { ", without the packing" } else { "" };
    let enriched = match (is_hybrid, begins_as_grains) {
        (true, false) => ", with its zone of grains from the start",
        (true, true) => ", from what grains beside a band that rest from the start would take to grains alone",
        _ => "",
    };
    let time = forecast.steps + forecast.outputs;
    let least = if job.method().has_rves() { ", and more as RVEs strain faster" } else { "" };
    let note = format!("about{packing}{enriched}{least}, at {} and step", costs.join(" and "));
    let alone = forecast.speed_up * forecast.steps + forecast.outputs;
    let told = match begins_as_grains && alone > time {
        true => format!("{} to {}", duration(time), duration(alone)),
        false => duration(time),
    };
    page.row("time to run", &told, &note);
    match &slots.unmeasured {
        None => {
            let threads = counted(rayon::current_num_threads(), "thread");
            let note = format!("measured on this machine now, one rank of {threads} with its cores to itself");
            let share = format!("{} % of it output", figures(100.0 * forecast.outputs / time));
            page.row("", &share, &note);
        }
        Some(why) => page.row("", "", &format!("taken from another machine and without output: {why}")),
    }
    frames(page, slots, [forecast.points + forecast.grains, forecast.grains]);
}

fn duration(seconds: f64) -> String {
    match seconds {
        short if short < 60.0 => format!("{} s", figures(short)),
        seconds if seconds < 3600.0 => format!("{} min ({} s)", figures(seconds / 60.0), figures(seconds)),
        seconds => format!("{} h ({} s)", figures(seconds / 3600.0), figures(seconds)),
    }
}

/// What frames and contacts will take on disk, of so many rows and, among them, grains.
fn frames(page: &mut Page, slots: &Slots, [rows, grains]: [f64; 2]) {
    let (output, axes) = (slots.job.output(), slots.job.dimension());
    let frames = 1.0 + (slots.job.end() / output.frame_interval).ceil();
    let size = |bytes: f64| format!("{} of {} MB", whole(frames), figures(1e-6 * bytes));
    page.row("frames", &size(rows * BYTES_PER_ROW as f64), "each at most; they are compressed");
    if output.contact_frames {
        // Frictional packings bear their load with about four contacts a disc and six a sphere, each of two grains.
        let lines = axes as f64 * grains;
        let note = format!("each, with {axes} contacts a grain; they are compressed");
        page.row("frames of contacts", &size(lines * BYTES_PER_LINE as f64), &note);
    }
}
