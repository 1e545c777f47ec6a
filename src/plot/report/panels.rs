//! Curves of the named columns of series, whatever jobs wrote them: a chart says which columns it is of, the runs decide what of
//! that there is.

use super::Drawn;
use super::chart::{Axis, Chart, Curve, Entry, Level, Moment, draw};
use super::colour;
use super::numbers::{significant, unit_of_time};
use super::svg::Stroke;
use crate::analysis::columns::{Column, Description, Quantity, describe, is_meant};
use crate::analysis::curve::{WINDOW, range, smooth};
use crate::analysis::drive::Measure;
use crate::analysis::run::Run;

/// Columns up to which several runs share a chart, run by run in one colour; of more, each run has its own.
const OVERLAID: usize = 4;
/// Decades of energy below the largest that are shown.
const DECADES: i32 = 9;
/// Forces are shown in kN from here on, N.
const KILO_FROM: f64 = 1e4;
/// A stress that is held shows no closer than this share of what it is held at: a well-held one shall look like one.
const HELD_ROOM: f64 = 0.05;
/// Colour of marks that belong to the only run there is.
pub const QUIET: &str = "#444444";

/// What a chart is of.
struct Spec {
    columns: &'static [&'static str],
    label: &'static str,
    /// In the caption.
    words: &'static str,
    is_logarithmic: bool,
}

/// Charts side by side.
pub struct Panel {
    name: &'static str,
    charts: &'static [Spec],
}

const fn of(columns: &'static [&'static str], label: &'static str, words: &'static str) -> Spec {
    Spec { columns, label, words, is_logarithmic: false }
}

pub const PANELS: [Panel; 7] = [
    Panel {
        name: "volume",
        charts: &[
            of(&["volume_strain"], "volume strain", "volume strain of the whole, positive in dilation"),
            of(
                &["normal_stress"],
                "normal stress",
                "normal stress on the upper plate; single rows faint, their moving average on top, dashed what it is held at",
            ),
        ],
    },
    Panel {
        name: "stress",
        charts: &[
            of(
                &["stress_xx", "stress_yy", "stress_zz", "stress_xy"],
                "stress",
                "volume mean of the stress (of grains in a cell of that of their contacts), normal stresses positive in compression",
            ),
            of(&["fraction"], "solid volume fraction", "solid volume fraction of the cell"),
            of(&["contacts_of_a_grain"], "contacts of a grain", "contacts of a grain in the mean"),
            of(&["volume_change"], "change of volume", "change of volume since the first row"),
        ],
    },
    Panel {
        name: "energies",
        charts: &[
            Spec {
                columns: &["elastic*", "kinetic*", "dissipated"],
                label: "energy",
                words: "elastic energy of contacts and of the continuum, kinetic energy, what has been dissipated; what is zero has \
                        no place on this scale",
                is_logarithmic: true,
            },
            of(
                &["change_of_*"],
                "change since the first row",
                "potential energy and the sum with those of (a), or the account of energy, since the first row: the work of loads, \
                 bodies, gravity and the cell, and what has been taken, where the run kept account ([output] energy_balance)",
            ),
        ],
    },
    Panel {
        name: "reactions",
        charts: &[of(
            &["*_force"],
            "force",
            "force of the material on every face that holds it and on every body, magnitude of the mean over a row of series.csv",
        )],
    },
    Panel {
        name: "followed",
        charts: &[
            of(&["*_moved"], "displacement", "magnitude of the displacement of points that are followed"),
            of(&["*_p"], "mean stress", "their mean stress, compression positive"),
            of(&["*_plastic_strain"], "plastic strain", "their plastic strain"),
        ],
    },
    Panel {
        name: "followed_state",
        charts: &[
            of(&["*_deviatoric_strain"], "deviatoric strain", "deviatoric strain of the points that are followed"),
            of(&["*_q"], "deviatoric stress q", "their deviatoric stress, q = sqrt(s:s/2) in the plane"),
            of(&["*_void_ratio"], "void ratio", "void ratio of their RVEs, and of all RVEs together"),
            of(
                &["*_fabric_anisotropy"],
                "fabric anisotropy",
                "fabric anisotropy, sqrt(F_a:F_a/2) of F_a = 4 (phi \u{2212} I/2)",
            ),
            of(
                &["*_grains_turned", "*_turned"],
                "rotation (degrees)",
                "rotation of the point, of F = R U, and of its grains in the mean",
            ),
            of(
                &["*_mechanical_coordination"],
                "mechanical coordination",
                "contacts of a grain without grains that have none or one, of theirs and of all RVEs",
            ),
        ],
    },
    Panel {
        name: "rves",
        charts: &[
            of(&["rve_loose", "rve_replicated"], "RVEs", "RVEs without contacts, and replicated ones"),
            of(&["rve_unbalanced_max"], "I_uf", "the largest share of forces out of balance, I_uf, of all RVEs"),
        ],
    },
];

/// The runs with the colours of their curves.
pub type Runs<'a> = [(&'a Run, &'static str)];

/// A column of one of the runs.
struct Line<'a> {
    run: usize,
    /// Which of the chart's columns it is.
    number: usize,
    description: Description,
    column: &'a Column,
}

impl Line<'_> {
    fn values(&self) -> Vec<f64> {
        let scale = self.description.sign / self.description.quantity.shown().2;
        self.column.values.iter().map(|value| scale * value).collect()
    }
}

/// What curves stand against: an axis for all runs, and what one of its unit is.
pub fn axis_of(runs: &Runs) -> (Axis, f64) {
    let ends = runs.iter().filter_map(|(run, _)| range(run.drive.values.iter().copied()));
    let [lower, upper] = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or_default();
    let drive = &runs[0].0.drive;
    let (unit, length) = match drive.measure {
        Measure::Strain => ("%", 1e-2),
        Measure::Length => ("mm", 1e-3),
        Measure::Time => unit_of_time(upper),
    };
    (Axis::exact(&format!("{} ({unit})", drive.words), lower.min(0.0) / length, upper / length), length)
}

/// Places of values against strain or what else the run is driven by; in two pieces that do not touch at row `cut`.
pub fn places(along: &[f64], values: &[f64], units: [f64; 2], cut: Option<usize>) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> = along.iter().zip(values).map(|(x, y)| [x / units[0], y / units[1]]).collect();
    if let Some(cut) = cut {
        places.insert(cut, [f64::NAN; 2]);
    }
    places
}

/// The values without the extreme half percent at either end: single rows may leave the axes.
pub fn central(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 200;
    sorted[cut..sorted.len() - cut].to_vec()
}

/// Where hybrids came to have both grains and points; with words where there is one of them.
pub fn moments(runs: &Runs, unit: f64, with_words: bool) -> Vec<Moment<'static>> {
    let all: Vec<_> = runs.iter().filter_map(|(run, colour)| Some((run, colour, run.has_both_at()?))).collect();
    let alone = all.len() == 1;
    let moment = |(run, colour, strain): (&&Run, &&'static str, f64)| {
        let words = match run.begins_as_grains() {
            _ if !(alone && with_words) => "",
            true => "first points",
            false => "grains inserted",
        };
        let colour = if runs.len() == 1 { QUIET } else { colour };
        Moment { at: strain / unit, words: words.to_owned(), stroke: Stroke::new(colour, 1.0).dash("5 3") }
    };
    all.into_iter().map(moment).collect()
}

/// The figures of runs that stand against the same; names get the number of the set that the runs are, where there are several.
pub fn figures(runs: &Runs, number: &str) -> Vec<Drawn> {
    PANELS.iter().filter_map(|panel| figure(panel, runs, number)).collect()
}

fn figure(panel: &Panel, runs: &Runs, number: &str) -> Option<Drawn> {
    let (mut charts, mut words): (Vec<Chart>, Vec<&str>) = (Vec::new(), Vec::new());
    for spec in panel.charts {
        let lines = lines(spec, runs);
        if lines.is_empty() {
            continue;
        }
        words.push(spec.words);
        let columns = lines.iter().map(|line| line.number + 1).max().unwrap_or(0);
        if runs.len() == 1 || (columns <= OVERLAID && !spec.is_logarithmic) {
            charts.push(chart(spec, runs, &lines));
        } else {
            let (unit, all) = (lines.iter().flat_map(Line::values).collect::<Vec<_>>(), charts.len());
            for run in 0..runs.len() {
                let own: Vec<Line> = self::lines(spec, &runs[run..=run]);
                charts.push(Chart { title: runs[run].0.label(), ..chart(spec, &runs[run..=run], &own) });
            }
            // One scale for all of them.
            if spec.is_logarithmic {
                charts[all..].iter_mut().for_each(|chart| chart.y = vertical(spec, "energy (J)", unit.iter().copied()));
            }
        }
    }
    let several = charts.len() > 1;
    for (chart, letter) in charts.iter_mut().zip('a'..).filter(|_| several) {
        chart.title = format!("({letter}) {}", chart.title);
    }
    let is_lettered = several && words.len() == charts.len();
    let lettered = |(words, letter): (&&str, char)| {
        if is_lettered { format!("({letter}) {words}") } else { (*words).to_owned() }
    };
    let told: Vec<String> = words.iter().zip('a'..).map(lettered).collect();
    let mut caption = format!("{}, against {}.", told.join("; "), runs[0].0.drive.words);
    if let Some(first) = caption.get(..1).map(str::to_uppercase) {
        caption.replace_range(..1, &first);
    }
    let columns = columns_of(charts.len());
    let name = format!("{}{number}", panel.name);
    let drawing = draw(&name, &format!("Curves of {}", panel.name), &[], &charts, columns);
    (!charts.is_empty()).then_some(Drawn { name, drawing, caption })
}

/// Charts of a panel stand in so many columns.
fn columns_of(charts: usize) -> usize {
    if charts.is_multiple_of(3) { 3 } else { charts.min(2) }
}

fn lines<'a>(spec: &Spec, runs: &Runs<'a>) -> Vec<Line<'a>> {
    let mut names: Vec<&str> = Vec::new();
    let mut lines = Vec::new();
    for pattern in spec.columns {
        for (run, (of, _)) in runs.iter().enumerate() {
            for column in of.columns.iter().filter(|column| is_meant(&column.name, pattern)) {
                let number = names.iter().position(|name| *name == column.name).unwrap_or_else(|| {
                    names.push(&column.name);
                    names.len() - 1
                });
                // What another pattern has meant already stands there once.
                if !lines.iter().any(|line: &Line| line.run == run && line.number == number) {
                    lines.push(Line { run, number, description: describe(&column.name), column });
                }
            }
        }
    }
    lines.retain(|line| line.column.values.iter().any(|value| *value > 0.0) || !spec.is_logarithmic);
    lines
}

fn vertical(spec: &Spec, label: &str, values: impl Iterator<Item = f64>) -> Axis {
    if spec.is_logarithmic { Axis::decades(label, values, DECADES) } else { Axis::around(label, values) }
}

/// Of one run a colour for each column; of several a colour for each run, and dashes for columns.
fn chart(spec: &Spec, runs: &Runs, lines: &[Line]) -> Chart<'static> {
    let (x, unit) = axis_of(runs);
    let stroke = |line: &Line, width: f64| match runs.len() {
        1 => Stroke::new(colour::line(line.number), width).dash(colour::DASHES[line.number / colour::LINES.len() % 6]),
        _ => Stroke::new(runs[line.run].1, width).dash(colour::DASHES[line.number % colour::DASHES.len()]),
    };
    let quantity = lines.first().map_or(Quantity::Number, |line| line.description.quantity);
    let large = lines.iter().flat_map(Line::values).fold(0.0, f64::max) >= KILO_FROM && quantity == Quantity::Force;
    let (sign, thousand) = if large { ("kN", 1e3) } else { (quantity.shown().1, 1.0) };
    let label = if sign.is_empty() { spec.label.to_owned() } else { format!("{} ({sign})", spec.label) };
    let (mut curves, mut shown, mut entries): (Vec<Curve>, Vec<f64>, Vec<Entry>) = Default::default();
    let has_noise = lines.iter().any(|line| line.description.is_noisy);
    for line in lines {
        let (run, values) = (runs[line.run].0, line.values());
        let drawn = |values: &[f64], cut| places(&run.drive.values, values, [unit, thousand], cut);
        if line.description.is_noisy {
            let averages = smooth(&values, run.cut(), WINDOW);
            curves.insert(0, Curve { places: drawn(&values, None), stroke: stroke(line, 0.8).opacity(0.3) });
            curves.push(Curve { places: drawn(&averages, run.cut()), stroke: stroke(line, 1.8) });
            shown.extend(averages.into_iter().chain(central(&values)));
        } else {
            curves.push(Curve { places: drawn(&values, None), stroke: stroke(line, 1.5) });
            shown.extend(values.iter().map(|value| value / thousand));
        }
    }
    if runs.len() > 1 {
        let named =
            |(run, colour): &(&Run, &'static str)| Entry { words: run.label(), stroke: Stroke::new(colour, 2.2) };
        entries.extend(runs.iter().map(named));
    }
    let columns = lines.iter().map(|line| line.number + 1).max().unwrap_or(0);
    for number in (0..columns).filter(|_| columns > 1 || lines[0].description.words != spec.label) {
        let Some(line) = lines.iter().find(|line| line.number == number) else { continue };
        let stroke =
            if runs.len() == 1 { stroke(line, 1.5) } else { Stroke { colour: "#555555", ..stroke(line, 1.5) } };
        entries.push(Entry { words: line.description.words.clone(), stroke });
    }
    if has_noise {
        let ink = if runs.len() == 1 { colour::line(0) } else { "#555555" };
        entries.push(Entry { words: format!("mean over {WINDOW} rows"), stroke: Stroke::new(ink, 1.8) });
        entries.push(Entry { words: "single rows".to_owned(), stroke: Stroke::new(ink, 0.8).opacity(0.4) });
    }
    let held = lines.iter().filter(|line| line.column.name == "normal_stress");
    let mut held: Vec<f64> = held.filter_map(|line| runs[line.run].0.number("loading.stress_normal")).collect();
    held.sort_by(f64::total_cmp);
    held.dedup();
    let dashed = Stroke::new("#000000", 1.2).dash("6 4");
    if let [held] = held.as_slice() {
        let words = format!("held at {} kPa", significant(held / 1e3, 3));
        entries.push(Entry { words, stroke: dashed });
    }
    shown.extend(held.iter().flat_map(|held| [1.0 - HELD_ROOM, 1.0 + HELD_ROOM].map(|share| share * held / 1e3)));
    if quantity == Quantity::Strain {
        shown.push(0.0);
    }
    Chart {
        y: vertical(spec, &label, shown.into_iter()),
        x,
        curves,
        moments: moments(runs, unit, false),
        levels: held.iter().map(|held| Level { at: held / 1e3, stroke: dashed }).collect(),
        entries,
        ..Chart::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_have_the_columns_that_there_are() {
        let column = |name: &str| Column { name: name.to_owned(), values: vec![1.0, 2.0] };
        let mut run = Run::made("name = \"a\"");
        run.columns = ["time", "elastic", "kinetic_grains", "x_lower_force", "plate_force"].map(column).to_vec();
        (run.drive.words, run.drive.values) = ("time".to_owned(), vec![0.0, 2.0]);
        let drawn = figures(&[(&run, colour::line(0))], "_2");
        assert_eq!(drawn.iter().map(|drawn| drawn.name.as_str()).collect::<Vec<_>>(), ["energies_2", "reactions_2"]);
        assert!(drawn[1].drawing.contains(">face x_lower<") && drawn[1].drawing.contains(">plate<"));
        assert!(drawn[0].drawing.contains("time (s)") && drawn[0].drawing.contains(">elastic<"));
        let other = run.clone();
        let both = figures(&[(&run, colour::line(0)), (&other, colour::line(1))], "");
        // Energies run by run, forces over each other.
        assert!(both[0].drawing.contains("(b) a") && !both[1].drawing.contains("(b)"));
    }

    #[test]
    fn a_curve_breaks_where_grains_were_inserted() {
        let drawn = places(&[0.01, 0.02], &[1e3, 2e3], [0.01, 1e3], Some(1));
        assert!(drawn[1][0].is_nan() && drawn[2] == [2.0, 2.0] && drawn.len() == 3);
    }
}
