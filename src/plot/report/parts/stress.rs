//! Stress over strain: averages, packings, what an enrichment does; the differences from grains alone; peak and end.

use super::{Part, Sheet, by_group, entry_of, runs, stroke_of};
use crate::analysis::curve::{Averaged, WINDOW, range, smooth};
use crate::analysis::measures::Measures;
use crate::analysis::measures::disturbance::{STRAIN_AVERAGED, STRAIN_DISTURBED, window};
use crate::analysis::measures::stress::{Compared, Kind, Level};
use crate::plot::report::Drawn;
use crate::plot::report::chart::{self, Area, Axis, Chart, Curve, Entry, Moment};
use crate::plot::report::numbers::{THIN, change, interval, kilopascal, percent, plain, significant};
use crate::plot::report::panels::{QUIET, axis_of, central, moments, places};
use crate::plot::report::svg::Stroke;

/// In percent and kPa.
const UNITS: [f64; 2] = [0.01, 1e3];
/// Strain before and after enrichment in the close view.
const CLOSE: [f64; 2] = [0.01, 0.03];

/// Places of an average, in two pieces that do not touch at the enrichment.
pub fn drawn(curve: &Averaged) -> Vec<[f64; 2]> {
    places(&curve.strain, &curve.stress, UNITS, curve.cut)
}

pub fn part(measures: &Measures) -> Part {
    let found = &measures.stress.of;
    let drive = &measures.among.members[0].run.drive;
    let words = drive.stress.as_ref().map_or("", |stress| &stress.words);
    let mut sheets = Vec::new();
    if !found.differences.is_empty() {
        sheets.push(Sheet::of(
            &format!("{} against that of grains alone", sentence_case(words)),
            &found.differences,
            |of| format!("{} \u{2013} {}", of.of, of.against),
            &[
                ("strain", &|of| Some(interval([of.difference.from_strain, of.difference.to_strain]))),
                ("its mean", &|of| Some(kilopascal(of.difference.mean_reference_pa))),
                ("mean difference", &|of| Some(change(of.difference.mean_difference))),
                ("root-mean-square", &|of| Some(percent(of.difference.rms_difference))),
            ],
        ));
    }
    Part {
        sentences: sentences(&sentence_case(words), &drive.words, &found.differences),
        figures: vec![Drawn {
            name: if drive.is_shear() { "shear_stress" } else { "load" }.to_owned(),
            drawing: drawing(measures, &format!("{words} (kPa)")),
            caption: caption(measures, &sentence_case(words)),
        }],
        sheets,
        left_out: measures.stress.left_out.clone(),
    }
}

pub fn sentence_case(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The main differences; of means where there are any.
fn sentences(of: &str, strain: &str, compared: &[Compared]) -> Vec<String> {
    let kinds = |kinds: &[Kind]| compared.iter().filter(|pair| kinds.contains(&pair.kind)).collect::<Vec<_>>();
    let (means, spread) = (kinds(&[Kind::Means]), kinds(&[Kind::Spread]));
    let chosen = if means.is_empty() { kinds(&[Kind::Packing, Kind::OtherPacking]) } else { means };
    let told = |pair: &&Compared| {
        let (mean, rms) = (change(pair.difference.mean_difference), percent(pair.difference.rms_difference));
        format!("{} is {mean} off {} in the mean and {rms} root-mean-square", pair.of, pair.against)
    };
    let mut all = Vec::new();
    if let Some(first) = chosen.first() {
        let told = chosen.iter().map(told).collect::<Vec<_>>().join("; ");
        let difference = &first.difference;
        all.push(format!(
            "{of} from {} of {strain}: {told}.",
            interval([difference.from_strain, difference.to_strain])
        ));
    }
    if !spread.is_empty() {
        let told = |pick: fn(&Compared) -> f64| {
            let [least, most] = range(spread.iter().map(|pair| pick(pair).abs())).unwrap_or_default();
            if spread.len() == 1 { percent(least) } else { interval([least, most]) }
        };
        all.push(format!(
            "Packings of grains alone differ from each other by {} in the mean and {} root-mean-square.",
            told(|pair| pair.difference.mean_difference),
            told(|pair| pair.difference.rms_difference)
        ));
    }
    all
}

fn caption(measures: &Measures, words: &str) -> String {
    let drive = &measures.among.members[0].run.drive;
    let end = &measures.among.members[0];
    let rate = end.strain_end() / end.run.column("time").last().copied().unwrap_or(1.0);
    let window = measures.stress.of.window_s;
    let mut caption = format!(
        "{words} ({}). Faint: rows of series.csv, each {}; full: their moving average over {}{THIN}ms, \
         {} of strain at the mean speed of {} (Chen et al. 2021, figures 10, 12, 17 and 23)",
        drive.how,
        if drive.is_of_instants { "of one instant" } else { "the mean over its interval" },
        plain(1e3 * window, 3),
        percent(window * rate),
        end.who.run
    );
    if let Some(metres) = drive.metres {
        caption += &format!("; 1{THIN}% of strain is {}{THIN}mm", plain(10.0 * metres, 3));
    }
    if measures.stress.of.spreads.iter().any(Option::is_some) {
        caption +=
            "; of several packings the mean, with the band between the least and the most, and thin lines for each";
    }
    if !measures.disturbance.of.is_empty() {
        caption += &format!(
            ". Averages do not look across the enrichment (dashed). (b) shows it closely, of one packing by the amount of training \
             beside the grains alone (figures 14 and 15), averages over {WINDOW} rows but no more than {} of strain; dotted: the mean \
             of the rows before it. Dip and spike are looked for within {} of strain after it",
            percent(STRAIN_AVERAGED),
            percent(STRAIN_DISTURBED)
        );
    }
    caption + "."
}

fn drawing(measures: &Measures, label: &str) -> String {
    let (found, among) = (&measures.stress.of, &measures.among);
    let runs = runs(measures);
    let (x, _) = axis_of(&runs);
    let faint = |index: usize, width: f64| entry_of(measures, index, width).stroke.opacity(0.3);
    let (mut raw, mut curves, mut areas, mut entries) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut shown = vec![0.0];
    for (number, (group, spread)) in among.groups.iter().zip(&found.spreads).enumerate() {
        let stroke = stroke_of(number, 1.8);
        if let Some(spread) = spread {
            let edge = |values: &[f64]| places(&spread.mean.strain, values, UNITS, None);
            areas.push(Area { lower: edge(&spread.least), upper: edge(&spread.most), colour: stroke.colour });
            curves.push(Curve { places: drawn(&spread.mean), stroke });
            entries.push(Entry { words: format!("{}, mean of {} packings", group.name, group.members.len()), stroke });
        }
        for &index in &group.members {
            let (member, average) = (&among.members[index], &found.averages[index]);
            let entry = entry_of(measures, index, if spread.is_some() { 0.8 } else { 1.8 });
            if spread.is_none() {
                let places = places(&average.strain, member.stress(), UNITS, None);
                raw.push(Curve { places, stroke: faint(index, 0.8) });
                shown.extend(central(member.stress()));
            }
            curves.push(Curve { places: drawn(average), stroke: entry.stroke });
            shown.extend(&average.stress);
            if among.members.len() > 1 {
                entries.push(entry);
            }
        }
    }
    let ink = if among.members.len() == 1 { runs[0].1 } else { "#555555" };
    entries.push(Entry { words: "moving average".to_owned(), stroke: Stroke::new(ink, 1.8) });
    entries.push(Entry { words: "single rows".to_owned(), stroke: Stroke::new(ink, 0.8).opacity(0.4) });
    raw.append(&mut curves);
    let mut charts = vec![Chart {
        x,
        y: Axis::around(label, shown.iter().map(|stress| stress / UNITS[1])),
        curves: raw,
        areas,
        moments: moments(&runs, UNITS[0], true),
        ..Chart::default()
    }];
    if let Some(close) = close(measures, label, &mut entries) {
        charts[0].title = "(a)".to_owned();
        charts.push(close);
    }
    let columns = charts.len();
    chart::draw("load", &format!("{label} against {}", charts[0].x.label), &entries, &charts, columns)
}

/// The enrichments of one packing, the one with the most amounts of training, beside the grains alone.
fn close(measures: &Measures, label: &str, entries: &mut Vec<Entry<'static>>) -> Option<Chart<'static>> {
    let among = &measures.among;
    let case = |index: usize| (among.members[index].case, among.members[index].who.seed);
    let all: Vec<usize> = measures.disturbance.of.iter().map(|found| found.who.index).collect();
    let same = |index: &usize| all.iter().copied().filter(|other| case(*other) == case(*index)).collect::<Vec<_>>();
    let shown = all.iter().map(same).reduce(|a, b| if b.len() > a.len() { b } else { a })?;
    let partner = among.partner(&among.members[shown[0]]).map(|partner| partner.index());
    let found = || shown.iter().filter_map(|&index| measures.disturbed(index));
    let [first, last] = range(found().map(|found| found.by.strain))?;
    let end = shown.iter().map(|&index| among.members[index].strain_end()).fold(0.0, f64::max);
    let [lower, upper] = [(first - CLOSE[0]).max(0.0), (last + CLOSE[1]).min(end)];
    let (mut raw, mut curves) = (Vec::new(), Vec::new());
    for index in partner.into_iter().chain(shown.iter().copied()) {
        let member = &among.members[index];
        let stroke = entry_of(measures, index, 1.9).stroke;
        let places = |stress: &[f64]| places(&member.run.drive.values, stress, UNITS, member.run.cut());
        let average = smooth(member.stress(), member.run.cut(), window(member));
        raw.push(Curve { places: places(member.stress()), stroke: Stroke { width: 0.8, opacity: 0.5, ..stroke } });
        curves.push(Curve { places: places(&average), stroke });
    }
    let level = |index: &usize| {
        let colour = if among.members.len() == 1 { QUIET } else { super::colour_of(measures, *index) };
        let before = measures.disturbed(*index)?.by.before_pa / UNITS[1];
        Some(chart::Level { at: before, stroke: Stroke::new(colour, 1.1).dash("2 3") })
    };
    let levels: Vec<_> = shown.iter().filter_map(level).collect();
    if let ([level], Some(found)) = (levels.as_slice(), found().next()) {
        let words = format!("mean of {} rows before: {} kPa", found.by.rows_averaged, significant(level.at, 3));
        entries.push(Entry { words, stroke: level.stroke });
    }
    raw.append(&mut curves);
    let seen = raw.iter().flat_map(|curve| &curve.places);
    let seen = seen.filter(|[strain, _]| (lower..=upper).contains(&(UNITS[0] * strain))).map(|place| place[1]);
    Some(Chart {
        title: "(b) about the enrichment".to_owned(),
        y: Axis::around(label, seen.collect::<Vec<_>>().into_iter()),
        x: Axis::exact(&axis_of(&runs(measures)).0.label, lower / UNITS[0], upper / UNITS[0]),
        moments: vec![Moment {
            at: first / UNITS[0],
            words: String::new(),
            stroke: Stroke::new(QUIET, 1.0).dash("5 3"),
        }],
        levels,
        curves: raw,
        ..Chart::default()
    })
}

/// Peaks, falls from them, and ends.
pub fn levels(measures: &Measures, levels: &[Level]) -> Part {
    let peak = |level: &Level| measures.stress.of.peaks.iter().find(|peak| peak.who.index == level.who.index).cloned();
    let sheet = Sheet::of(
        "What was measured",
        levels,
        |level| level.who.run.clone(),
        &[
            ("highest moving average", &|level| Some(kilopascal(peak(level)?.peak_pa))),
            ("at strain", &|level| Some(percent(peak(level)?.peak_strain))),
            ("to the common end", &|level| {
                let other = peak(level).filter(|peak| peak.peak_strain != level.peak_strain);
                other.map(|_| format!("{} at {}", kilopascal(level.peak_pa), percent(level.peak_strain)))
            }),
            ("mean of the last part", &|level| {
                Some(format!("{}, {}", kilopascal(level.residual_pa), interval(level.residual_between_strains)))
            }),
            ("fall from the peak", &|level| Some(percent(level.softening))),
            ("at the end", &|level| {
                Some(format!("{} at {}", kilopascal(level.stress_end_pa), percent(level.strain_end)))
            }),
            ("volume strain at the end", &|level| level.volume_strain_end.map(change)),
            ("normal stress, second half", &|level| spread(level)),
        ],
    );
    let of = |pick: fn(&Level) -> f64| levels.iter().map(|level| (&level.who, pick(level))).collect::<Vec<_>>();
    let groups = &measures.among.groups;
    let words = measures.among.members[0].run.drive.stress.as_ref().map_or("", |stress| &stress.words);
    let sentence = format!(
        "Peak of {words}: {}. Fall from it to the mean from {} of strain: {}.",
        by_group(groups, &of(|level| level.peak_pa), kilopascal),
        interval(levels[0].residual_between_strains),
        by_group(groups, &of(|level| level.softening), percent),
    );
    Part { sentences: vec![sentence], sheets: vec![sheet], ..Part::default() }
}

/// A stress with its standard deviation.
pub fn spread(level: &Level) -> Option<String> {
    let (mean, deviation) = level.normal_stress_pa.zip(level.normal_stress_deviation_pa)?;
    Some(format!("({} \u{b1} {}){THIN}kPa", significant(mean / 1e3, 3), plain(deviation / 1e3, 2)))
}
