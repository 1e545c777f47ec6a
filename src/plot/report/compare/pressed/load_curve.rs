//! Stress on the body that presses over its way (Chen et al. 2021, figures 17, 20 and 23): moving averages, and how far they are
//! from those of grains alone.

use serde_json::json;

use super::Runs;
use crate::plot::report::WIDTH;
use crate::plot::report::chart::{Axis, Chart, Curve, Entry, Moment, percent, side_by_side};
use crate::plot::report::compare::among::Group;
use crate::plot::report::compare::curves::{Averaged, Entrant, compared, windows};
use crate::plot::report::compare::{Drawn, Part, Sheet, by_group, difference};
use crate::plot::report::figures::{HEIGHT, start};
use crate::plot::report::svg::Stroke;
use crate::plot::report::words::{THIN, kilopascal, plain};

/// Dashes of the runs of a group.
const DASHES: [&str; 6] = ["", "7 3", "2 2", "8 2 2 2", "12 4", "8 2 2 2 2 2"];

/// The line of one run among those of its group.
pub fn stroke(groups: &[Group], group: usize, run: usize) -> Stroke<'static> {
    let number = groups[group].members.iter().position(|&member| member == run).unwrap_or(0);
    Stroke::new(groups[group].colour, 1.6).dash(DASHES[number % DASHES.len()])
}

pub fn part(runs: &Runs, between: Option<[f64; 2]>) -> Part {
    let times: Vec<&[f64]> = runs.all.iter().map(|run| run.time).collect();
    let (window, rows) = windows(&times);
    let averages: Vec<Averaged> =
        runs.all.iter().zip(rows).map(|(run, rows)| Averaged::of(&run.strain, &run.stress, run.cut, rows)).collect();
    let [from, to] = between.unwrap_or([0.0, f64::INFINITY]);
    let entrants: Vec<Entrant> = runs
        .all
        .iter()
        .zip(&averages)
        .map(|(run, curve)| Entrant {
            label: &run.label,
            curve,
            is_dem: run.is("dem"),
            seed: run.seed,
            case: 0,
            partner: runs.partner(run),
            between: [from.max(runs.compared_from(run)), to],
        })
        .collect();
    let found = compared(&entrants, &runs.groups);
    let mut left_out = Vec::new();
    if !runs.all.iter().any(|run| run.is("dem")) {
        left_out.push("No run is of grains alone: stresses are compared with nothing.".to_owned());
    } else if found.is_empty() {
        left_out.push(
            "No two of these runs have enough rows in common, after enrichment and between these strains.".to_owned(),
        );
    }
    let peaks: Vec<(f64, f64)> = averages.iter().map(peak).collect();
    let by: Vec<(usize, f64)> = runs.all.iter().zip(&peaks).map(|(run, peak)| (run.group, peak.1)).collect();
    let within = between.map_or_else(
        || "after enrichment".to_owned(),
        |between| format!("from {} of {}", between.map(percent).join(" to "), runs.press.strain_words()),
    );
    let mut sentences = difference::sentences(&format!("Stress on {} {within}", runs.press.name), &found);
    sentences.push(format!("The highest moving average of that stress: {}.", by_group(&runs.groups, &by, kilopascal)));
    let mut sheet = Sheet::new("Highest moving average of stress", &["stress", "at strain"]);
    for (run, peak) in runs.all.iter().zip(&peaks) {
        sheet.row(&run.label, vec![Some(kilopascal(peak.1)), Some(percent(peak.0))]);
    }
    let told = |(run, peak): (&super::Run, &(f64, f64))| json!({ "run": run.label, "seed": run.seed, "peak_pa": peak.1, "peak_strain": peak.0 });
    Part {
        sentences,
        figures: vec![Drawn {
            name: "compare_load",
            drawing: drawing(runs, &averages),
            caption: caption(runs, window),
        }],
        sheets: vec![difference::sheet("Stress against that of grains alone", &found), sheet],
        left_out,
        json: json!({
            "body": runs.press.name, "window_s": window, "metres_of_strain_one": runs.press.length,
            "differences": difference::json(&found),
            "peaks": runs.all.iter().zip(&peaks).map(told).collect::<Vec<_>>(),
        }),
    }
}

/// Strain and stress, Pa, of the highest moving average.
fn peak(averaged: &Averaged) -> (f64, f64) {
    let rows = averaged.strain.iter().copied().zip(averaged.stress.iter().copied());
    rows.reduce(|best, row| if row.1 > best.1 { row } else { best }).unwrap_or_default()
}

fn drawing(runs: &Runs, averages: &[Averaged]) -> String {
    let entries: Vec<Entry> = legend(runs);
    let (mut svg, top) = start("compare-load", WIDTH, &entries);
    let frame = side_by_side(1, WIDTH, top, HEIGHT)[0];
    let stresses = averages.iter().flat_map(|curve| curve.stress.iter().map(|stress| 1e-3 * stress));
    let curve = |(index, averaged): (usize, &Averaged)| Curve {
        places: averaged.places(),
        stroke: stroke(&runs.groups, runs.all[index].group, index),
    };
    let moment = |run: &super::Run| {
        let at = 100.0 * run.enriched_strain()?;
        Some(Moment { at, words: String::new(), stroke: Stroke::new(runs.groups[run.group].colour, 0.8).dash("5 3") })
    };
    let chart = Chart {
        title: String::new(),
        x: axis(runs),
        y: Axis::around(&format!("stress on {} (kPa)", runs.press.name), stresses.chain([0.0])),
        curves: averages.iter().enumerate().map(curve).collect(),
        moments: runs.all.iter().filter_map(moment).collect(),
        levels: Vec::new(),
    };
    chart.draw(&mut svg, frame);
    svg.finish("Stress on the body that presses, of all runs, against its way")
}

/// All runs, as their lines are.
pub fn legend(runs: &Runs) -> Vec<Entry<'static>> {
    let entry = |(index, run): (usize, &super::Run)| Entry {
        words: run.label.clone(),
        stroke: stroke(&runs.groups, run.group, index),
    };
    runs.all.iter().enumerate().map(entry).collect()
}

/// Strain from zero to the end of the longest run, in percent.
pub fn axis(runs: &Runs) -> Axis {
    let end = runs.all.iter().map(super::Run::strain_end).fold(0.0, f64::max);
    Axis::exact(&format!("{} (%)", runs.press.strain_words()), 0.0, 100.0 * end)
}

fn caption(runs: &Runs, window: f64) -> String {
    let of = if runs.press.is_plane { "the height of the material" } else { "its own breadth" };
    format!(
        "Moving average over {}{THIN}ms of the force on {} over {}, against its way over {of} (1{THIN}% is {}{THIN}mm); it does not \
         look across the enrichment, which is dashed (Chen et al. 2021, figures 17 and 23: 8 of 500 samples a second).",
        plain(1e3 * window, 3),
        runs.press.name,
        if runs.press.is_plane { "the breadth of the material at the start" } else { "its own breadth" },
        plain(10.0 * runs.press.length, 3),
    )
}
