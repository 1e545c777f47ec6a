//! Shear stress around the enrichment, by the amount of training (Chen et al. 2021, figure 14 and 15 left).

use serde_json::{Value, json};

use super::among::{Among, Member};
use super::{Drawn, Part, Sheet, by_group, share};
use crate::plot::report::WIDTH;
use crate::plot::report::chart::{Axis, Chart, Curve, Entry, Level, Moment, percent, side_by_side};
use crate::plot::report::figures::{CLOSE, HEIGHT, SHEAR_LABEL, STRAIN_LABEL, places, start};
use crate::plot::report::findings::{Enrichment, STRAIN_DISTURBED, WINDOW, smooth};
use crate::plot::report::svg::Stroke;
use crate::plot::report::words::kilopascal;

/// Averages are over [`WINDOW`] rows, but over no more strain than this: 8 ms of the paper's speed, width and sampling.
const STRAIN_AVERAGED: f64 = 0.0027;

/// Rows to average over.
fn window(member: &Member) -> usize {
    let spacing = member.strain_end() / member.run.series.rows() as f64;
    ((STRAIN_AVERAGED / spacing).round() as usize).clamp(1, WINDOW)
}

pub fn part(among: &Among) -> Part {
    let hybrids = || among.members.iter().filter(|member| member.is("hybrid"));
    let disturbed = |member: &'_ Member| Enrichment::averaged(member.run, window(member));
    let enriched: Vec<(&Member, Enrichment)> =
        hybrids().filter_map(|member| Some((member, disturbed(member)?))).collect();
    let silent = hybrids().filter(|member| member.enrichment().is_none());
    let left_out = silent.map(|member| format!("{} was not enriched: nothing was disturbed.", member.label)).collect();
    if enriched.is_empty() {
        return Part { left_out, ..Part::default() };
    }
    let members: Vec<&Member> = enriched.iter().map(|(member, _)| *member).collect();
    Part {
        sentences: vec![sentence(among, &enriched)],
        figures: vec![drawing(among, &members)],
        sheets: vec![sheet(&enriched)],
        left_out,
        json: Value::Array(enriched.iter().map(|(member, enrichment)| json(member, enrichment)).collect()),
    }
}

/// The single row within [`STRAIN_DISTURBED`] that is farthest from the level before, as a share of it, with its sign.
fn excursion(member: &Member, enrichment: &Enrichment) -> Option<f64> {
    let series = &member.run.series;
    let rows = enrichment.row..series.rows();
    let near = rows.filter(|&row| series.strain[row] <= enrichment.strain + STRAIN_DISTURBED);
    let away = near.map(|row| series.shear_stress[row] / enrichment.before - 1.0);
    away.reduce(|most, away| if away.abs() > most.abs() { away } else { most }).filter(|away| away.is_finite())
}

fn drop_of(enrichment: &Enrichment) -> f64 {
    enrichment.lowest / enrichment.before - 1.0
}

fn recovery(enrichment: &Enrichment) -> Option<String> {
    enrichment.settled?;
    Some(match enrichment.recovery {
        Some(0.0) => "never below".to_owned(),
        Some(strain) => percent(strain),
        None => "not reached".to_owned(),
    })
}

fn sentence(among: &Among, found: &[(&Member, Enrichment)]) -> String {
    let drops: Vec<(usize, f64)> =
        found.iter().map(|(member, enrichment)| (member.group, drop_of(enrichment))).collect();
    let recovered: Vec<(usize, f64)> =
        found.iter().filter_map(|(member, enrichment)| Some((member.group, enrichment.recovery?))).collect();
    let mut words = format!(
        "Within {} of strain after enrichment the moving average of shear stress changes by: {}.",
        percent(STRAIN_DISTURBED),
        by_group(&among.groups, &drops, share)
    );
    if !recovered.is_empty() {
        words += &format!(" It recovers after a strain of: {}.", by_group(&among.groups, &recovered, percent));
    }
    let never = found.iter().filter(|(_, enrichment)| enrichment.settled.is_some() && enrichment.recovery.is_none());
    for (member, _) in never {
        words += &format!(" That of {} does not recover.", member.label);
    }
    words
}

fn sheet(found: &[(&Member, Enrichment)]) -> Sheet {
    let mut sheet = Sheet::new(
        "Disturbance by the enrichment",
        &["training", "at strain", "before", "lowest average", "drop", "farthest row", "strain until recovered"],
    );
    for (member, enrichment) in found {
        sheet.row(
            &member.label,
            vec![
                Some(percent(member.training())),
                Some(percent(enrichment.strain)),
                Some(kilopascal(enrichment.before)),
                Some(kilopascal(enrichment.lowest)),
                Some(share(drop_of(enrichment))),
                excursion(member, enrichment).map(share),
                recovery(enrichment),
            ],
        );
    }
    sheet
}

fn json(member: &Member, enrichment: &Enrichment) -> Value {
    json!({
        "run": member.label, "seed": member.seed, "training": member.training(), "strain": enrichment.strain, "rows_averaged": window(member),
        "before_pa": enrichment.before, "lowest_average_pa": enrichment.lowest, "drop": drop_of(enrichment),
        "excursion": excursion(member, enrichment), "settled_pa": enrichment.settled,
        "strain_until_recovered": enrichment.recovery,
    })
}

/// The hybrids of one packing, the one with the most amounts of training.
fn of_one_packing<'m, 'a>(enriched: &[&'m Member<'a>]) -> Vec<&'m Member<'a>> {
    let same = |one: &Member| -> Vec<&'m Member<'a>> {
        enriched.iter().copied().filter(|other| other.case == one.case && other.seed == one.seed).collect()
    };
    let longer = |a: Vec<&'m Member<'a>>, b: Vec<&'m Member<'a>>| if b.len() > a.len() { b } else { a };
    enriched.iter().map(|one| same(one)).reduce(longer).unwrap_or_default()
}

fn drawing(among: &Among, enriched: &[&Member]) -> Drawn {
    let shown = of_one_packing(enriched);
    let strains: Vec<f64> = shown.iter().filter_map(|member| member.enrichment()).map(|found| found.strain).collect();
    let lower = (strains.iter().copied().fold(f64::INFINITY, f64::min) - CLOSE[0]).max(0.0);
    let end = shown.iter().map(|member| member.strain_end()).fold(0.0, f64::max);
    let upper = (strains.iter().copied().fold(0.0, f64::max) + CLOSE[1]).min(end);
    let partner = shown.first().and_then(|member| among.partner(member));
    let places = |member: &Member, stresses: &[f64]| places(&member.run.series.strain, stresses, 1e3, member.cut());
    let stroke = |member: &Member, width: f64| among.groups[member.group].stroke(width);
    let (mut curves, mut entries) = (Vec::new(), Vec::new());
    for member in partner.into_iter().chain(shown.iter().copied()) {
        let raw = stroke(member, 0.8).opacity(0.5);
        curves.push(Curve { places: places(member, &member.run.series.shear_stress), stroke: raw });
    }
    for member in partner.into_iter().chain(shown.iter().copied()) {
        let stroke = stroke(member, 1.9);
        let smooth = smooth(&member.run.series.shear_stress, member.cut(), window(member));
        curves.push(Curve { places: places(member, &smooth), stroke });
        let words = match member.is("hybrid") {
            true => format!("{}, training {}", member.label, percent(member.training())),
            false => member.label.clone(),
        };
        entries.push(Entry { words, stroke });
    }
    let (mut svg, top) = start("compare-disturbance", WIDTH, &entries);
    let seen = curves.iter().flat_map(|curve| &curve.places);
    let seen = seen.filter(|[strain, _]| (100.0 * lower..=100.0 * upper).contains(strain)).map(|place| place[1]);
    let first = strains.iter().copied().fold(f64::INFINITY, f64::min);
    let chart = Chart {
        title: String::new(),
        x: Axis::exact(STRAIN_LABEL, 100.0 * lower, 100.0 * upper),
        y: Axis::around(SHEAR_LABEL, seen),
        moments: vec![Moment {
            at: 100.0 * first,
            words: "grains inserted".to_owned(),
            stroke: Stroke::new("#444444", 1.0).dash("5 3"),
        }],
        levels: Vec::<Level>::new(),
        curves,
    };
    chart.draw(&mut svg, side_by_side(1, WIDTH, top, HEIGHT)[0]);
    Drawn {
        name: "compare_disturbance",
        drawing: svg.finish("Shear stress around the enrichment by the amount of training"),
        caption: format!(
            "Shear stress from {} of strain before the enrichment to {} after it, one curve for every amount of training of one \
             packing, with the grains alone of that packing (Chen et al. 2021, figures 14 and 15): single rows faint, their \
             average over {WINDOW} rows on top, but over no more than {} of strain.",
            percent(CLOSE[0]),
            percent(CLOSE[1]),
            percent(STRAIN_AVERAGED)
        ),
    }
}
