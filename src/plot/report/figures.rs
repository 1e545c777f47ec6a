//! The curves of a report: stress, volume, energy.

use super::chart::{Axis, Chart, Curve, Entry, Level, Moment, empty, legend, side_by_side, significant};
use super::colour;
use super::findings::{Enrichment, Findings, WINDOW};
use super::load::Run;
use super::svg::{Stroke, Svg};

/// Height of the axes of a chart, pixels.
pub const HEIGHT: f64 = 270.0;
/// Room above the axes for legend and title, pixels.
const HEAD: f64 = 30.0;
const FOOT: f64 = 50.0;
pub const STRAIN_LABEL: &str = "horizontal strain (%)";
/// Colour of marks that belong to the only run there is.
const QUIET: &str = "#444444";
pub const SHEAR_LABEL: &str = "shear stress (kPa)";
/// Decades of energy below the largest that are shown.
const DECADES: i32 = 9;
/// Strain before and after enrichment in the close view.
pub const CLOSE: [f64; 2] = [0.01, 0.03];

/// A run with what was found in it.
pub struct Found<'a> {
    pub run: &'a Run,
    pub findings: &'a Findings,
}

impl Found<'_> {
    /// A column against strain, in percent and in units of `unit`.
    fn against_strain(&self, values: &[f64], unit: f64) -> Vec<[f64; 2]> {
        places(&self.run.series.strain, values, unit, None)
    }

    /// Elastic energy of grains and points, kinetic energy of grains and points, J.
    fn energies(&self) -> [&[f64]; 4] {
        let series = &self.run.series;
        [&series.elastic_grains, &series.elastic_points, &series.kinetic_grains, &series.kinetic_points]
    }

    /// A smoothed column as one curve, or as two that do not touch at the enrichment.
    fn smooth(&self, values: &[f64], unit: f64) -> Vec<[f64; 2]> {
        let cut = self.findings.enrichment.as_ref().map(|enrichment| enrichment.row);
        places(&self.run.series.strain, values, unit, cut)
    }
}

/// Values in units of `unit` against strain in percent: one curve, or two that do not touch at row `cut`.
pub fn places(strain: &[f64], values: &[f64], unit: f64, cut: Option<usize>) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> =
        strain.iter().zip(values).map(|(strain, value)| [100.0 * strain, value / unit]).collect();
    if let Some(cut) = cut {
        places.insert(cut, [f64::NAN; 2]);
    }
    places
}

/// Shear stress against horizontal strain, whole and close to the enrichment.
pub fn shear_stress(found: &[Found], width: f64) -> String {
    let enriched: Vec<(usize, &Enrichment)> = found
        .iter()
        .enumerate()
        .filter_map(|(index, found)| found.findings.enrichment.as_ref().map(|enrichment| (index, enrichment)))
        .collect();
    let mut entries = averaged(found);
    let before = |&(index, enrichment): &(usize, &Enrichment)| Level {
        at: enrichment.before / 1e3,
        stroke: Stroke::new(if found.len() == 1 { QUIET } else { colour::line(index) }, 1.1).dash("2 3"),
    };
    let levels: Vec<Level> = enriched.iter().map(before).collect();
    if let ([(_, enrichment)], [level]) = (enriched.as_slice(), levels.as_slice()) {
        let words = format!("mean of {WINDOW} rows before: {} kPa", significant(enrichment.before / 1e3, 3));
        entries.push(Entry { words, stroke: level.stroke });
    }
    let (mut svg, top) = start("shear-stress", width, &entries);
    let frames = side_by_side(if enriched.is_empty() { 1 } else { 2 }, width, top, HEIGHT);

    // Single rows may leave the axes; averages may not.
    let averages = found.iter().flat_map(|found| found.findings.shear_smooth.iter().copied());
    let rows = found.iter().flat_map(|found| central(&found.run.series.shear_stress));
    let whole = Chart {
        title: if enriched.is_empty() { String::new() } else { "(a)".to_owned() },
        x: Axis::exact(STRAIN_LABEL, 0.0, strain_end(found)),
        y: Axis::around(SHEAR_LABEL, averages.chain(rows).chain([0.0]).map(|stress| stress / 1e3)),
        curves: raw_and_smooth(found, |found| (&found.run.series.shear_stress, &found.findings.shear_smooth)),
        moments: moments(found),
        levels: Vec::new(),
    };
    whole.draw(&mut svg, frames[0]);

    if let Some(close) = frames.get(1) {
        let strains = enriched.iter().map(|(_, enrichment)| enrichment.strain);
        let (first, last) = strains.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), s| (a.min(s), b.max(s)));
        let lower = (100.0 * (first - CLOSE[0])).max(0.0);
        let x = Axis::exact(STRAIN_LABEL, lower, (100.0 * (last + CLOSE[1])).min(strain_end(found)));
        let shown = found.iter().flat_map(|found| {
            let rows = found.run.series.strain.iter().zip(&found.run.series.shear_stress);
            rows.filter(|(strain, _)| (x.lower..=x.upper).contains(&(100.0 * **strain))).map(|(_, stress)| stress / 1e3)
        });
        let chart = Chart {
            title: "(b) about the enrichment".to_owned(),
            y: Axis::around(SHEAR_LABEL, shown),
            x: x.clone(),
            levels,
            moments: without_words(moments(found)),
            curves: whole.curves,
        };
        chart.draw(&mut svg, *close);
    }
    svg.finish("Shear stress on the upper plate against horizontal strain")
}

/// Volume strain and normal stress against horizontal strain.
pub fn volume(found: &[Found], width: f64) -> String {
    let mut targets: Vec<f64> = found.iter().filter_map(|found| found.run.stress_normal).collect();
    targets.sort_by(f64::total_cmp);
    targets.dedup();
    let mut entries = averaged(found);
    let stroke = Stroke::new("#000000", 1.2).dash("6 4");
    let levels: Vec<Level> = targets.iter().map(|target| Level { at: target / 1e3, stroke }).collect();
    if let [target] = targets.as_slice() {
        entries.push(Entry { words: format!("normal stress aimed at: {} kPa", significant(target / 1e3, 3)), stroke });
    }
    let (mut svg, top) = start("volume", width, &entries);
    let frames = side_by_side(2, width, top, HEIGHT);

    let curves = found.iter().enumerate().map(|(index, found)| Curve {
        places: found.against_strain(&found.run.series.volume_strain, 0.01),
        stroke: Stroke::new(colour::line(index), 1.8),
    });
    let values = found.iter().flat_map(|found| found.run.series.volume_strain.iter().map(|value| 100.0 * value));
    let chart = Chart {
        title: "(a)".to_owned(),
        x: Axis::exact(STRAIN_LABEL, 0.0, strain_end(found)),
        y: Axis::around("volume strain (%)", values.chain([0.0])),
        curves: curves.collect(),
        moments: moments(found),
        levels: Vec::new(),
    };
    chart.draw(&mut svg, frames[0]);

    let averages = found.iter().flat_map(|found| found.findings.normal_smooth.iter().copied());
    let rows = found.iter().flat_map(|found| central(&found.run.series.normal_stress));
    // No closer than 5 % of the target: a well-held stress shall look like one.
    let room = targets.iter().flat_map(|target| [0.95 * target, 1.05 * target]);
    let chart = Chart {
        title: "(b)".to_owned(),
        x: Axis::exact(STRAIN_LABEL, 0.0, strain_end(found)),
        y: Axis::around("normal stress (kPa)", averages.chain(rows).chain(room).map(|stress| stress / 1e3)),
        curves: raw_and_smooth(found, |found| (&found.run.series.normal_stress, &found.findings.normal_smooth)),
        moments: without_words(moments(found)),
        levels,
    };
    chart.draw(&mut svg, frames[1]);
    svg.finish("Volume strain and normal stress against horizontal strain")
}

/// Energies against horizontal strain, a chart for every run.
pub fn energies(found: &[Found], width: f64) -> String {
    const COLUMNS: usize = 2;
    let columns = found.len().min(COLUMNS);
    let rows = found.len().div_ceil(COLUMNS);
    let row_height = HEAD + HEIGHT + FOOT;
    let mut svg = Svg::new("energies", width, 24.0 + rows as f64 * row_height);
    let names = [
        ("elastic, grains", colour::LINES[0]),
        ("elastic, points", colour::LINES[4]),
        ("kinetic, grains", colour::LINES[1]),
        ("kinetic, points", colour::LINES[2]),
    ];
    let stroke = |(_, colour): (&str, &'static str)| Stroke::new(colour, 1.3);
    let shown = |index: usize| found.iter().any(|found| found.energies()[index].iter().any(|&energy| energy > 0.0));
    let entry = |index: usize| Entry { words: names[index].0.to_owned(), stroke: stroke(names[index]) };
    let entries: Vec<Entry> = (0..names.len()).filter(|&index| shown(index)).map(entry).collect();
    legend(&mut svg, [super::chart::MARGIN_LEFT, 18.0], width - super::chart::MARGIN_LEFT, &entries);
    let y = Axis::decades("energy (J)", found.iter().flat_map(|found| found.energies().concat()), DECADES);
    for (index, found) in found.iter().enumerate() {
        let top = 24.0 + (index / COLUMNS) as f64 * row_height + HEAD;
        let frame = side_by_side(columns, width, top, HEIGHT)[index % COLUMNS];
        let curves = found
            .energies()
            .into_iter()
            .zip(names)
            .map(|(values, name)| Curve { places: found.against_strain(values, 1.0), stroke: stroke(name) });
        let curves: Vec<Curve> = curves.collect();
        if curves.iter().flat_map(|curve| &curve.places).all(|place| place[1] <= 0.0) {
            empty(&mut svg, frame, "no energies in series.csv");
            continue;
        }
        let chart = Chart {
            title: label(found.run),
            x: Axis::exact(STRAIN_LABEL, 0.0, strain_end(std::slice::from_ref(found))),
            y: y.clone(),
            curves,
            moments: moments(std::slice::from_ref(found)),
            levels: Vec::new(),
        };
        chart.draw(&mut svg, frame);
    }
    svg.finish("Energies against horizontal strain")
}

/// A drawing with its legend, and where its axes may begin.
pub fn start(name: &str, width: f64, entries: &[Entry]) -> (Svg, f64) {
    // The legend decides the height: draw it once to know.
    let mut trial = Svg::new(name, width, 0.0);
    let place = [super::chart::MARGIN_LEFT, 18.0];
    let room = width - super::chart::MARGIN_LEFT - 16.0;
    let top = legend(&mut trial, place, room, entries) + HEAD;
    let mut svg = Svg::new(name, width, top + HEIGHT + FOOT);
    legend(&mut svg, place, room, entries);
    (svg, top)
}

/// The legend of averages over rows: one run needs no name, several need a grey example.
fn averaged(found: &[Found]) -> Vec<Entry<'static>> {
    let several = found.len() > 1;
    let names = found.iter().enumerate().filter(|_| several);
    let mut entries: Vec<Entry> = names
        .map(|(index, found)| Entry { words: label(found.run), stroke: Stroke::new(colour::line(index), 2.2) })
        .collect();
    let ink = if several { "#555555" } else { colour::line(0) };
    entries.push(Entry { words: format!("mean over {WINDOW} rows"), stroke: Stroke::new(ink, 1.8) });
    entries.push(Entry { words: "single rows".to_owned(), stroke: Stroke::new(ink, 0.8).opacity(0.4) });
    entries
}

/// Single rows of all runs, faint (Pa, in kPa), and their averages on top of them.
fn raw_and_smooth<'a>(
    found: &'a [Found],
    pick: impl Fn(&'a Found<'a>) -> (&'a [f64], &'a [f64]),
) -> Vec<Curve<'static>> {
    let columns = || found.iter().enumerate().map(|(index, found)| (colour::line(index), found, pick(found)));
    let raw = columns().map(|(colour, found, (raw, _))| Curve {
        places: found.against_strain(raw, 1e3),
        stroke: Stroke::new(colour, 0.8).opacity(0.3),
    });
    let smooth = columns().map(|(colour, found, (_, smooth))| Curve {
        places: found.smooth(smooth, 1e3),
        stroke: Stroke::new(colour, 1.8),
    });
    raw.chain(smooth).collect()
}

/// The largest strain of all runs, percent.
fn strain_end(found: &[Found]) -> f64 {
    found.iter().map(|found| 100.0 * found.findings.strain_end).fold(0.0, f64::max)
}

/// Name and method of a run; a name that says the method already is enough.
pub fn label(run: &Run) -> String {
    with_method(&run.name, &run.method)
}

/// A name and a method, unless the name says it.
pub fn with_method(name: &str, method: &str) -> String {
    let said = name.split(|letter: char| !letter.is_alphanumeric()).any(|word| word == method);
    if said || method.is_empty() { name.to_owned() } else { format!("{name} ({method})") }
}

/// When grains were inserted, for every run where they were.
fn moments(found: &[Found]) -> Vec<Moment<'static>> {
    let alone = found.len() == 1;
    let moment = |(index, found): (usize, &Found)| {
        let enrichment = found.findings.enrichment.as_ref()?;
        Some(Moment {
            at: 100.0 * enrichment.strain,
            words: "grains inserted".to_owned(),
            stroke: Stroke::new(if alone { QUIET } else { colour::line(index) }, 1.0).dash("5 3"),
        })
    };
    found.iter().enumerate().filter_map(moment).collect()
}

fn without_words(moments: Vec<Moment>) -> Vec<Moment> {
    moments.into_iter().map(|moment| Moment { words: String::new(), ..moment }).collect()
}

/// The values without the extreme half percent at either end.
fn central(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 200;
    sorted[cut..sorted.len() - cut].to_vec()
}
