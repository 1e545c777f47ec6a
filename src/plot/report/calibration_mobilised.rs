//! The page of `scree calibrate --law mobilised_friction`: element tests, the law that follows them, and what is left between.

use super::chart::{self, Axis, Chart, Curve, Entry};
use super::colour;
use super::mohr;
use super::numbers::{percent, significant};
use super::page::{figure, table, whole};
use super::svg::{INK, Stroke, escape};
use super::words::Table;
use crate::analysis::calibrate::Subject;
use crate::analysis::calibrate::element::{
    CYCLES, Course, INERTIAL_COMPRESSION, INERTIAL_SHEAR, Row, STRAIN_BACK, STRAIN_FIRST, STRAIN_REVERSAL, STRAIN_SMALL,
};
use crate::analysis::calibrate::fit::pressure;
use crate::analysis::calibrate::layers::STRETCH;
use crate::analysis::calibrate::mobilised::musts::{FITTED_PACKINGS, Must, has_packings, musts};
use crate::analysis::calibrate::mobilised::{BAND, Calibration, KINDS, Shown, Specimen};

/// Shear strain of the close view, in percent.
const CLOSE: f64 = 5.0;

/// Name, drawing and caption of a figure.
type Drawing = (&'static str, String, String);

/// The drawings with their names, for files of their own.
pub fn drawings(calibration: &Calibration) -> Vec<Drawing> {
    let once: Vec<&Shown> = of_course(calibration, Course::Once).collect();
    let mut drawings = vec![
        (
            "shear",
            shear(&once),
            "Simple shear at constant normal stress, shear stress over normal stress against shear strain: (a) all, (b) the \
             beginning. Faint: means over the packings; dashed: the law."
                .to_string(),
        ),
        (
            "residual",
            residual(&once),
            "What is left between: the law less the means. (a) Shear stress over normal stress; (b) volume strain in per mille."
                .to_string(),
        ),
        (
            "volume",
            volume(&once),
            "Volume strain, dilation positive. Full: means over the packings; dashed: the law, whose mass is kept.".to_string(),
        ),
    ];
    for shown in of_course(calibration, Course::Reversal) {
        let words = format!(
            "Shear to {}, back by {}, on to {} and back the other way. The law is fitted to the two unloadings alone, each from its turn \
             until half of the stress is left. What it does not have: grains soften on the way back long before their stress has turned, \
             and contract there, because contacts that carried the shear are lost, and those of the other way are made only as it goes \
             on. The law remembers no direction, is elastic until the stress has turned, and then yields.",
            percent(STRAIN_FIRST),
            percent(STRAIN_BACK),
            percent(STRAIN_REVERSAL)
        );
        drawings.push(("reversal", reversal(shown), words));
    }
    for shown in of_course(calibration, Course::Cycles) {
        let words = "Small cycles on the way to the peak, whose unloadings tell how the shear modulus falls: shear stress over normal \
             stress. Full: mean over the packings; dashed: the law."
            .to_string();
        drawings.push(("small_cycles", small_cycles(shown), words));
    }
    for shown in of_course(calibration, Course::Biaxial) {
        let words = "Biaxial compression, which is not fitted: (a) sine of the mobilised angle, (b) volume strain. Full: mean over the \
             packings; dashed: the law."
            .to_string();
        drawings.push(("biaxial", biaxial(shown), words));
    }
    let (drawing, words) = mohr::drawing(&calibration.shown, calibration.fit.constants.cohesion > 0.0);
    drawings.push(("mohr", drawing, words));
    for shown in of_course(calibration, Course::ConstantVolume) {
        let words = "Shear at constant volume, which is not fitted: (a) shear stress, (b) mean stress. Full: mean over the packings; \
             dashed: the law."
            .to_string();
        drawings.push(("constant_volume", constant_volume(shown), words));
    }
    drawings
}

fn of_course(calibration: &Calibration, course: Course) -> impl Iterator<Item = &Shown> {
    calibration.shown.iter().filter(move |shown| shown.kind.course == course)
}

/// The whole page around the drawings.
pub fn page(calibration: &Calibration, subject: &Subject, command: &str, drawings: &[Drawing]) -> String {
    let title = escape(&format!("Calibration of {}: mobilised friction", subject.name));
    let mut body = format!("<h1>{title}</h1>\n<p class=\"lead\">{}</p>\n", escape(&lead(calibration, subject)));
    for (index, (_, drawing, caption)) in drawings.iter().enumerate() {
        figure(&mut body, index + 1, drawing, caption);
    }
    let parameters = Table {
        rows: calibration
            .figures
            .iter()
            .map(|figure| {
                let is_at_bound = calibration.fit.at_bound.contains(&figure.key);
                let bound = if is_at_bound { ", at its bound" } else { "" };
                let cells = vec![format!("{}{bound}", figure.in_unit(figure.value, 4)), figure.interval()];
                (format!("{} ({})", figure.key, figure.symbol), cells)
            })
            .collect(),
    };
    table(&mut body, "The material", &["value", "95 % interval, +-"], &parameters);
    let left_out = calibration.half_left_out.as_deref().unwrap_or_default();
    for (title, shown) in [
        ("How the law follows the packings that it is fitted to", calibration.shown.as_slice()),
        ("On packings that were held back", calibration.shown_held.as_slice()),
        ("Under half of the stress, with a law fitted to the packing stress alone", left_out),
    ] {
        table(&mut body, title, &HEADS, &followed(shown));
    }
    for (title, musts) in musts(calibration) {
        let packings = has_packings(&musts).then_some(FITTED_PACKINGS);
        let columns: Vec<&str> = ["must", "found"].into_iter().chain(packings).chain([""]).collect();
        table(&mut body, title, &columns, &bounds(&musts));
    }
    table(&mut body, "Unloading", &[""], &unloading(calibration));
    table(
        &mut body,
        "Largest layer shear over the mean, mean and largest of the packings",
        &["", ""],
        &layers(calibration),
    );
    let collapsed = calibration.collapses().into_iter();
    let rows = collapsed.map(|one| (KINDS[one.kind].words(), vec![one.words()])).collect();
    table(&mut body, "Tests that lost the stress which they keep, as packings collapsed", &[""], &Table { rows });
    body += &format!(
        "<h2>How this was made</h2>\n<p>By {} with <code>{}</code>. <code>calibrated.toml</code> has the material as \
         a job takes it, <code>calibration.json</code> every number, the other TOML files the tests of the first packings for \
         <code>scree run</code> (of a reversal its first leg), <code>figures/</code> the drawings.</p>\n\
         <details><summary>The complete scenario</summary>\n<pre>{}</pre>\n</details>\n",
        crate::base::program::name(),
        escape(command),
        escape(&subject.text)
    );
    whole(&title, &body)
}

const HEADS: [&str; 11] = [
    "rms off, to 5 % of strain",
    "5 to 20 %",
    "beyond",
    "peak, at",
    "of the law",
    "volume strain at the end",
    "of the law",
    "plateau within 2 % of the peak",
    "scatter of a packing to 5 %",
    "largest volume off, to 5 %",
    "mean stress off, rms",
];

fn followed(shown: &[Shown]) -> Table {
    let row = |shown: &Shown| {
        let quality = &shown.quality;
        let mut cells = shown.cells().to_vec();
        cells.push(format!("{} to {}", percent(quality.plateau[0]), percent(quality.plateau[1])));
        cells.push(shown.scatter.map_or("\u{2013}".to_string(), |scatter| significant(scatter[0], 2)));
        cells.push(percent(quality.volume_largest[0]));
        cells.push(significant(quality.pressure_off, 2));
        (shown.kind.words(), cells)
    };
    Table { rows: shown.iter().map(row).collect() }
}

fn bounds(musts: &[Must]) -> Table {
    let has_packings = has_packings(musts);
    let row = |must: &Must| {
        let mut cells = vec![must.must.clone(), must.found.clone()];
        if has_packings {
            cells.push(must.of_packings.clone().unwrap_or_else(|| "\u{2013}".to_string()));
        }
        cells.push(if must.is_met { "" } else { "missed" }.to_string());
        (format!("{}: {}", must.test, must.words), cells)
    };
    Table { rows: musts.iter().map(row).collect() }
}

/// A line for each turn, of the packings that are fitted and of those that are not.
fn unloading(calibration: &Calibration) -> Table {
    let lines = |shown: &[Shown], mark: &str| -> Vec<(String, Vec<String>)> {
        let words = shown.iter().flat_map(Shown::unloaded);
        let row = |words: String| {
            let (what, told) = words.split_once(" of strain, ").expect("a turn is told at a strain");
            (format!("{what} of strain{mark}"), vec![told.to_string()])
        };
        words.map(row).collect()
    };
    let mut rows = lines(&calibration.shown, "");
    rows.extend(lines(&calibration.shown_held, ", held back"));
    Table { rows }
}

fn lead(calibration: &Calibration, subject: &Subject) -> String {
    let mut words = format!(
        "{} packings of {} grains in a periodic cell under {} kPa and as many under half of it, dense ones with the job\u{2019}s packing.friction \
         and loose ones with the friction of their contacts. K and G\u{2080} are slopes of isotropic and uniaxial compression over the first \
         {} of volume strain, at an inertial number of {INERTIAL_COMPRESSION:e}. All are sheared to {} at an inertial number of \
         {INERTIAL_SHEAR:e} while the normal stress and the other edges of the cell stay{}; dense ones also to the peak and back, and ten times more slowly in small cycles. The law, driven along the same \
         paths, follows the means over the packings with the least squares, each third of a test over the scatter of the packings there. \
         Behind the parameters stand 95 % confidence intervals, by fits that leave out one packing each.",
        calibration.fitted.len(),
        calibration.wanted.grains,
        significant(1e-3 * calibration.stress, 4),
        percent(STRAIN_SMALL),
        percent(calibration.wanted.strain),
        if subject.axes() == 3 { " (spheres, in plane strain)" } else { "" },
    );
    for (kind, end) in KINDS.iter().zip(&calibration.bands) {
        if let Some(end) = end {
            words += &format!(
                " {}: from {} of strain on the cell shears in a band in half of the packings, and nothing is fitted beyond.",
                kind.words(),
                percent(*end)
            );
        }
    }
    if let Some(other) = &subject.other_stress {
        words += &format!(" {other}");
    }
    words
}

/// A line for each kind and stretch of strain, of the packings that are fitted.
fn layers(calibration: &Calibration) -> Table {
    let mut rows = Vec::new();
    for (index, kind) in KINDS.iter().enumerate().filter(|(_, kind)| kind.course == Course::Once) {
        let of = |specimen: &Specimen| specimen.tests[index].profiles.clone();
        let Some(first) = calibration.fitted.first().map(of) else { continue };
        for (number, profile) in first.iter().enumerate() {
            let largest: Vec<f64> =
                calibration.fitted.iter().filter_map(|one| Some(of(one).get(number)?.largest())).collect();
            let mean = largest.iter().sum::<f64>() / largest.len() as f64;
            let most = largest.iter().copied().fold(0.0, f64::max);
            let from = percent((profile.strain - STRETCH).max(0.0));
            let mark = if mean > BAND { " (a band)" } else { "" };
            let cells = vec![format!("{}{mark}", significant(mean, 3)), significant(most, 3)];
            rows.push((format!("{}, {from} to {}", kind.words(), percent(profile.strain)), cells));
        }
    }
    Table { rows }
}

fn dashed(index: usize) -> Stroke<'static> {
    Stroke::new(colour::line(index), 1.8).dash("6 4")
}

fn faint(index: usize) -> Stroke<'static> {
    Stroke::new(colour::line(index), 1.2).opacity(0.55)
}

fn draw(name: &str, title: &str, charts: &[Chart], entries: &[Entry]) -> String {
    chart::draw(name, title, entries, charts, charts.len())
}

fn entries<'a>(shown: &[&Shown]) -> Vec<Entry<'a>> {
    let entry = |(index, shown): (usize, &&Shown)| Entry {
        words: shown.kind.words(),
        stroke: Stroke::new(colour::line(index), 1.6),
    };
    let mut entries: Vec<Entry> = shown.iter().enumerate().map(entry).collect();
    entries.push(Entry { words: "the law".to_string(), stroke: Stroke::new(INK, 1.6).dash("6 4") });
    entries
}

fn chart_of<'a>(title: &str, (start, end): (f64, f64), y: &str, curves: Vec<Curve<'a>>) -> Chart<'a> {
    let inside = |place: &&[f64; 2]| (start..=end).contains(&place[0]);
    let values: Vec<f64> =
        curves.iter().flat_map(|curve| curve.places.iter().filter(inside)).map(|place| place[1]).collect();
    Chart {
        title: title.to_string(),
        x: Axis::exact("shear strain (%)", start, end),
        y: Axis::around(y, values.into_iter()),
        curves,
        ..Chart::default()
    }
}

/// Values of the rows of means and of the law against strain in percent.
fn pairs<'a>(
    shown: &[&Shown],
    grains: impl Fn(&Shown, &Row) -> f64,
    law: impl Fn(&Shown, &(Row, f64)) -> f64,
) -> Vec<Curve<'a>> {
    let mut curves = Vec::new();
    for (index, shown) in shown.iter().enumerate() {
        let rows = &shown.curve.rows;
        let places = rows.iter().map(|row| [100.0 * row.strain, grains(shown, row)]).collect();
        curves.push(Curve { places, stroke: faint(index) });
        let places = rows.iter().zip(&shown.law).map(|(row, own)| [100.0 * row.strain, law(shown, own)]).collect();
        curves.push(Curve { places, stroke: dashed(index) });
    }
    curves
}

fn end_of(shown: &[&Shown]) -> f64 {
    let last = shown.iter().filter_map(|shown| shown.curve.rows.last());
    100.0 * last.map(|row| row.strain).fold(0.0, f64::max)
}

fn shear(shown: &[&Shown]) -> String {
    let curves = pairs(shown, |shown, row| shown.curve.ratio(row), |shown, (row, _)| shown.curve.ratio(row));
    let label = "shear stress over normal stress";
    let charts = [
        chart_of("(a)", (0.0, end_of(shown)), label, curves.clone()),
        chart_of("(b)", (0.0, end_of(shown).min(CLOSE)), label, curves),
    ];
    draw("shear", "Shear stress over normal stress against shear strain", &charts, &entries(shown))
}

/// Volume strain of grains against that of the start.
fn dilated(shown: &Shown, row: &Row) -> f64 {
    shown.curve.drive.fraction / row.fraction - 1.0
}

fn volume(shown: &[&Shown]) -> String {
    let curves = pairs(shown, |shown, row| 100.0 * dilated(shown, row), |_, (_, volume)| 100.0 * (volume - 1.0));
    let label = "volume strain (%)";
    let charts = [
        chart_of("(a)", (0.0, end_of(shown)), label, curves.clone()),
        chart_of("(b)", (0.0, end_of(shown).min(CLOSE)), label, curves),
    ];
    draw("volume", "Volume strain against shear strain", &charts, &entries(shown))
}

fn residual(shown: &[&Shown]) -> String {
    type Left<'a> = &'a dyn Fn(&Shown, &Row, &(Row, f64)) -> f64;
    let of = |value: Left| -> Vec<Curve> {
        let curve = |(index, shown): (usize, &&Shown)| {
            let rows = shown.curve.rows.iter().zip(&shown.law);
            let places = rows.map(|(row, law)| [100.0 * row.strain, value(shown, row, law)]).collect();
            Curve { places, stroke: Stroke::new(colour::line(index), 1.2) }
        };
        shown.iter().enumerate().map(curve).collect()
    };
    let ratios = of(&|shown, row, (law, _)| shown.curve.ratio(law) - shown.curve.ratio(row));
    let volumes = of(&|shown, row, (_, volume)| 1e3 * (volume - 1.0 - dilated(shown, row)));
    let end = end_of(shown);
    let charts = [
        chart_of("(a)", (0.0, end), "law less grains, of the normal stress", ratios),
        chart_of("(b)", (0.0, end), "law less grains (\u{2030})", volumes),
    ];
    let mut entries = entries(shown);
    entries.pop();
    draw("residual", "What is left between law and grains", &charts, &entries)
}

fn reversal(shown: &Shown) -> String {
    let all = [shown];
    let curves = pairs(&all, |shown, row| shown.curve.ratio(row), |shown, (row, _)| shown.curve.ratio(row));
    let volumes = pairs(&all, |shown, row| 100.0 * dilated(shown, row), |_, (_, volume)| 100.0 * (volume - 1.0));
    let ends = (-100.0 * STRAIN_REVERSAL, 100.0 * STRAIN_REVERSAL);
    let charts = [
        chart_of("(a)", ends, "shear stress over normal stress", curves),
        chart_of("(b)", ends, "volume strain (%)", volumes),
    ];
    draw("reversal", "Shear stress and volume strain under a reversal", &charts, &entries(&all))
}

fn small_cycles(shown: &Shown) -> String {
    let all = [shown];
    let curves = pairs(&all, |shown, row| shown.curve.ratio(row), |shown, (row, _)| shown.curve.ratio(row));
    let label = "shear stress over normal stress";
    let charts = [
        chart_of("(a)", (0.0, end_of(&all)), label, curves.clone()),
        chart_of("(b)", (0.0, 100.0 * CYCLES[1][0]), label, curves),
    ];
    draw("small_cycles", "Shear stress in small cycles", &charts, &entries(&all))
}

fn biaxial(shown: &Shown) -> String {
    let all = [shown];
    let sines = pairs(&all, |shown, row| shown.curve.ratio(row), |shown, (row, _)| shown.curve.ratio(row));
    let volumes = pairs(&all, |shown, row| 100.0 * dilated(shown, row), |_, (_, volume)| 100.0 * (volume - 1.0));
    let end = end_of(&all);
    let charts = [
        chart_of("(a)", (0.0, end), "sine of the mobilised angle", sines),
        chart_of("(b)", (0.0, end), "volume strain (%)", volumes),
    ];
    draw("biaxial", "Biaxial compression", &charts, &entries(&all))
}

fn constant_volume(shown: &Shown) -> String {
    let all = [shown];
    let shears = pairs(&all, |_, row| 1e-3 * row.stress[1], |_, (row, _)| 1e-3 * row.stress[1]);
    let means = pairs(&all, |_, row| 1e-3 * pressure(row), |_, (row, _)| 1e-3 * pressure(row));
    let end = end_of(&all);
    let charts = [
        chart_of("(a)", (0.0, end), "shear stress (kPa)", shears),
        chart_of("(b)", (0.0, end), "mean stress (kPa)", means),
    ];
    draw("constant_volume", "Shear and mean stress at constant volume", &charts, &entries(&all))
}
