//! The page of `scree calibrate`: what the element tests of grains gave, and the law that follows them.

use super::chart::{self, Axis, Chart, Curve, Entry};
use super::colour;
use super::numbers::{percent, significant};
use super::page::{figure, table, whole};
use super::svg::{INK, Stroke, escape};
use super::words::Table;
use crate::analysis::calibrate::element::{INERTIAL_COMPRESSION, INERTIAL_SHEAR, Row, STRAIN_SMALL};
use crate::analysis::calibrate::fit::{Shear, axial, compression, friction, pressure, response, smoothed};
use crate::analysis::calibrate::fragment::in_unit;
use crate::analysis::calibrate::{Calibration, KEYS, Specimen, Subject};

/// Shear strain of the close view.
const STRAIN_CLOSE: f64 = 0.06;

/// The drawings with their names, for files of their own.
pub fn drawings(calibration: &Calibration) -> Vec<(&'static str, String)> {
    vec![
        ("compressions", compressions(calibration)),
        ("shear", shear(calibration)),
        ("fraction", fraction(calibration)),
    ]
}

/// The whole page around the drawings.
pub fn page(
    calibration: &Calibration,
    subject: &Subject,
    command: &str,
    drawings: &[(&'static str, String)],
) -> String {
    let title = escape(&format!("Calibration of {}", subject.name));
    let mut body = format!("<h1>{title}</h1>\n<p class=\"lead\">{}</p>\n", escape(&lead(calibration, subject)));
    for (index, (name, drawing)) in drawings.iter().enumerate() {
        figure(&mut body, index + 1, drawing, caption(name));
    }
    table(&mut body, "The material", &heads(calibration), &figures(calibration));
    table(&mut body, "How the law follows the shear tests", &["grains", "law"], &followed(calibration));
    body += &format!(
        "<h2>How this was made</h2>\n<p>By {} with <code>{}</code>. <code>calibrated.toml</code> has the material as \
         a job takes it, <code>calibration.json</code> every number, <code>isotropic.toml</code>, \
         <code>uniaxial.toml</code> and <code>shear.toml</code> (of grains that cohere <code>shear_without_cohesion.toml</code>, \
         too) the tests of the first packing for <code>scree run</code>, <code>figures/</code> the drawings.</p>\n\
         <details><summary>The complete scenario</summary>\n<pre>{}</pre>\n</details>\n",
        crate::base::program::name(),
        escape(command),
        escape(&subject.text)
    );
    whole(&title, &body)
}

fn lead(calibration: &Calibration, subject: &Subject) -> String {
    let quality = &calibration.quality;
    let [grains, law] = quality.peak;
    let mut words = format!(
        "{} packings of {} grains, made in a periodic cell under {} kPa with the job\u{2019}s packing.friction. K and \
         M = K + G are slopes of the stress by the volume of the start over the first {} of volume strain, at an inertial number \
         of {INERTIAL_COMPRESSION:e}. Then each is sheared to {} while the stress normal to the shear stays and the width too, \
         at an inertial number of {INERTIAL_SHEAR:e}. The other figures are those with which the continuum\u{2019}s law, driven \
         along the same path, follows \u{3c4}/\u{3c3} and the solid volume fraction with the least squares. The grains harden to {} at {} of strain; the law, which is elastic up to its cone, \
         reaches {} at {}.",
        calibration.specimens.len(),
        calibration.wanted.grains,
        significant(1e-3 * calibration.stress, 4),
        percent(STRAIN_SMALL),
        percent(calibration.wanted.strain),
        significant(grains[0], 3),
        percent(grains[1]),
        significant(law[0], 3),
        percent(law[1]),
    );
    if let Some(other) = &subject.other_stress {
        words += &format!(" {other}");
    }
    words
}

fn caption(name: &str) -> &'static str {
    match name {
        "compressions" => {
            "Stress by the volume of the start, above that of the packing, against volume strain: (a) isotropic compression, \
             mean of the normal stresses, (b) uniaxial compression, stress along its axis. Coloured: the packings; dashed: K and M, the slopes of the first \
             tenth of the range."
        }
        "shear" => {
            "Simple shear under a constant normal stress: shear stress over normal stress against shear strain, (b) its \
             beginning. Faint: rows of each packing; full: their average over a stretch of 1\u{2009}% of strain; dashed: the law \
             with the parameters fitted to all packings."
        }
        _ => {
            "Solid volume fraction in simple shear. Full: the grains; dashed: \u{3a6} of the law, by its equation (8); dotted: what the \
             dilation of the law makes of the fraction of the start. Dashed and dotted would be one if the law kept mass by itself."
        }
    }
}

fn fit_stroke() -> Stroke<'static> {
    Stroke::new(INK, 1.6).dash("6 4")
}

fn draw(name: &str, title: &str, charts: &[Chart], entries: &[Entry]) -> String {
    chart::draw(name, title, entries, charts, charts.len())
}

fn packing_entries(calibration: &Calibration) -> Vec<Entry<'static>> {
    let entry = |(index, specimen): (usize, &Specimen)| Entry {
        words: format!("packing of seed {}", specimen.seed),
        stroke: Stroke::new(colour::line(index), 1.6),
    };
    calibration.specimens.iter().enumerate().map(entry).collect()
}

fn compressions(calibration: &Calibration) -> String {
    type Of = (fn(&Specimen) -> &[Row], fn(&Row) -> f64);
    let mean: Of = (|specimen| &specimen.isotropic, pressure);
    let along: Of = (|specimen| &specimen.uniaxial, axial);
    let law = &calibration.fit.law;
    let chart = |title: &str, label: &str, (rows, stress): Of, modulus: f64| {
        let mut curves = Vec::new();
        for (index, specimen) in calibration.specimens.iter().enumerate() {
            let rows = compression(rows(specimen), stress);
            let places = rows.iter().map(|[strain, stress]| [1e3 * strain, 1e-3 * (stress - rows[0][1])]).collect();
            curves.push(Curve { places, stroke: Stroke::new(colour::line(index), 1.6) });
        }
        let end = curves.iter().flat_map(|curve| &curve.places).map(|place| place[0]).fold(0.0, f64::max);
        curves.push(Curve { places: vec![[0.0, 0.0], [end, 1e-6 * modulus * end]], stroke: fit_stroke() });
        chart_of(title, ("volume strain (\u{2030})", end), label, curves)
    };
    let charts = [
        chart("(a) isotropic", "rise of the mean stress (kPa)", mean, law.bulk_modulus),
        chart("(b) uniaxial", "rise of the axial stress (kPa)", along, law.bulk_modulus + law.shear_modulus),
    ];
    let mut entries = packing_entries(calibration);
    entries.push(Entry { words: "K and M".to_string(), stroke: fit_stroke() });
    draw("compressions", "Stress against volume strain in two compressions", &charts, &entries)
}

fn chart_of<'a>(title: &str, (x, end): (&str, f64), y: &str, curves: Vec<Curve<'a>>) -> Chart<'a> {
    let shown = |place: &&[f64; 2]| place[0] <= end;
    let values: Vec<f64> =
        curves.iter().flat_map(|curve| curve.places.iter().filter(shown)).map(|place| place[1]).collect();
    let around = Axis::around(y, values.into_iter());
    Chart {
        title: title.to_string(),
        x: Axis::exact(x, 0.0, end),
        // Nothing here is negative but by noise.
        y: Axis { lower: around.lower.max(0.0), ..around },
        curves,
        ..Chart::default()
    }
}

/// All shear tests with the number of their packing.
fn tests(calibration: &Calibration) -> Vec<(usize, &Shear)> {
    calibration.specimens.iter().map(|specimen| &specimen.shear).enumerate().collect()
}

fn shear(calibration: &Calibration) -> String {
    let mut curves = Vec::new();
    let in_percent = |places: Vec<[f64; 2]>| places.into_iter().map(|[x, y]| [100.0 * x, y]).collect();
    for (index, test) in tests(calibration) {
        let rows = test.rows.iter().map(|row| [row.strain, friction(row)]).collect();
        curves.push(Curve { places: in_percent(rows), stroke: Stroke::new(colour::line(index), 0.8).opacity(0.25) });
    }
    for (index, test) in tests(calibration) {
        let places = in_percent(smoothed(&test.rows));
        curves.push(Curve { places, stroke: Stroke::new(colour::line(index), 1.6) });
    }
    for (_, test) in tests(calibration) {
        let Some(model) = response(&calibration.fit.law, test) else { continue };
        let places = in_percent(model.rows.iter().map(|row| [row.strain, friction(row)]).collect());
        curves.push(Curve { places, stroke: fit_stroke() });
    }
    let (label, end) = ("shear stress over normal stress", calibration.wanted.strain);
    let charts = [
        chart_of("(a)", ("shear strain (%)", 100.0 * end), label, curves.clone()),
        chart_of("(b)", ("shear strain (%)", 100.0 * end.min(STRAIN_CLOSE)), label, curves),
    ];
    let mut entries = packing_entries(calibration);
    entries.push(Entry { words: "the law".to_string(), stroke: fit_stroke() });
    draw("shear", "Shear stress over normal stress against shear strain", &charts, &entries)
}

fn fraction(calibration: &Calibration) -> String {
    let mut curves = Vec::new();
    for (index, test) in tests(calibration) {
        let places = test.rows.iter().map(|row| [100.0 * row.strain, row.fraction]).collect();
        curves.push(Curve { places, stroke: Stroke::new(colour::line(index), 1.6) });
    }
    let dotted = fit_stroke().dash("1 4");
    for (_, test) in tests(calibration) {
        let Some(model) = response(&calibration.fit.law, test) else { continue };
        let first = test.rows[0].fraction;
        let places = model.rows.iter().map(|row| [100.0 * row.strain, row.fraction]).collect();
        curves.push(Curve { places, stroke: fit_stroke() });
        let places = model.rows.iter().zip(&model.volumes).map(|(row, volume)| [100.0 * row.strain, first / volume]);
        curves.push(Curve { places: places.collect(), stroke: dotted });
    }
    let end = 100.0 * calibration.wanted.strain;
    let charts = [chart_of("", ("shear strain (%)", end), "solid volume fraction", curves)];
    let mut entries = packing_entries(calibration);
    entries.push(Entry { words: "\u{3a6} of the law".to_string(), stroke: fit_stroke() });
    entries.push(Entry { words: "by its dilation".to_string(), stroke: dotted });
    draw("fraction", "Solid volume fraction against shear strain", &charts, &entries)
}

fn heads(calibration: &Calibration) -> Vec<String> {
    let mut heads = vec!["all packings".to_string(), "standard deviation".to_string()];
    heads.extend(calibration.specimens.iter().map(|specimen| format!("seed {}", specimen.seed)));
    heads.push("Table 2 of Chen et al. (2021)".to_string());
    heads
}

fn figures(calibration: &Calibration) -> Table {
    let row = |key: &crate::analysis::calibrate::Key| {
        let (_, spread) = calibration.figure(key);
        let mut cells = vec![calibration.fit.told(key)];
        cells.push(spread.map_or("\u{2013}".to_string(), |spread| in_unit(key, spread, 2)));
        cells.extend(calibration.specimens.iter().map(|specimen| specimen.fit.told(key)));
        cells.push(in_unit(key, key.table_2, 3));
        (format!("{} ({})", key.name, key.symbol), cells)
    };
    Table { rows: KEYS.iter().map(row).collect() }
}

fn followed(calibration: &Calibration) -> Table {
    let quality = &calibration.quality;
    let [grains, law] = quality.peak;
    let row = |name: &str, cells: [String; 2]| (name.to_string(), cells.to_vec());
    let off = |value: f64| [String::new(), significant(value, 3)];
    Table {
        rows: vec![
            row("peak of \u{3c4}/\u{3c3}", [significant(grains[0], 3), significant(law[0], 3)]),
            row("its shear strain", [percent(grains[1]), percent(law[1])]),
            row("secant G at half the peak, MPa", quality.secant.map(|secant| significant(1e-6 * secant, 3))),
            row("volume strain at the end", quality.volume_end.map(percent)),
            row("root mean square off in \u{3c4}/\u{3c3}", off(quality.friction_off)),
            row("root mean square off in \u{3a6}", off(quality.fraction_off)),
        ],
    }
}
