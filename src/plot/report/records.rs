//! What a run of grains in a cell or of a continuum left behind, and curves of its series against time.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use scree_io::{frames, series};

use super::chart::{Axis, Chart, Curve, Entry, legend, side_by_side, significant};
use super::load::{broken, lookup, present, text, torn_frames, unreadable};
use super::svg::{Stroke, Svg};
use super::{WIDTH, colour, told};
use crate::base::error::Error;

pub const AXES: [&str; 3] = ["x", "y", "z"];
/// Height of the axes of a chart, and room above and below them, pixels.
const HEIGHT: f64 = 220.0;
const HEAD: f64 = 74.0;
const FOOT: f64 = 52.0;
/// Decades of energy below the largest that are shown.
const DECADES: i32 = 9;

/// A run as it lies on disk, but for its frames.
pub struct Record {
    pub directory: PathBuf,
    pub name: String,
    pub scenario: toml::Table,
    pub scenario_text: String,
    pub summary: serde_json::Map<String, serde_json::Value>,
    columns: BTreeMap<String, Vec<f64>>,
    /// s.
    pub frame_times: Vec<f64>,
}

/// Whether a directory holds a run of a job with that table; what cannot be read is left to who reads it.
pub fn has_table(directory: &Path, table: &str) -> bool {
    let scenario = text(&directory.join("scenario.toml")).ok();
    scenario.and_then(|text| text.parse::<toml::Table>().ok()).is_some_and(|scenario| scenario.contains_key(table))
}

impl Record {
    pub fn read(directory: &Path) -> Result<Self, Error> {
        let [scenario_path, series_path, frames_path] =
            ["scenario.toml", "series.csv", "frames.vtkhdf"].map(|name| directory.join(name));
        let scenario_text = text(&scenario_path)?;
        let scenario: toml::Table = toml::from_str(&scenario_text).map_err(|error| {
            broken(&scenario_path, &format!("is not TOML: {}", error.message()), "Copy it back from the run's job")
        })?;
        present(&series_path)?;
        let (header, rows) = series::read(&series_path).map_err(unreadable)?;
        if rows.is_empty() {
            return Err(broken(&series_path, "has no rows yet", "Let the run go on: `scree resume`"));
        }
        let column = |index: usize| rows.iter().map(|row| row.get(index).copied().unwrap_or(f64::NAN)).collect();
        let step = rows.last().and_then(|row| row.first()).copied().unwrap_or(0.0);
        let summary = told::figures(directory, step)?;
        let columns = header.iter().enumerate().map(|(index, name)| (name.clone(), column(index))).collect();
        present(&frames_path)?;
        let frame_times = frames::times(&frames_path).map_err(unreadable)?;
        if frame_times.is_empty() {
            return Err(torn_frames(&frames_path, "it holds no frame"));
        }
        let name = lookup(&scenario, "name").and_then(toml::Value::as_str).unwrap_or("run").to_owned();
        Ok(Self { directory: directory.to_owned(), name, scenario, scenario_text, summary, columns, frame_times })
    }

    pub fn word(&self, path: &str) -> Option<&str> {
        lookup(&self.scenario, path).and_then(toml::Value::as_str)
    }

    /// Numbers of a list, or of none.
    pub fn numbers(&self, path: &str) -> Vec<f64> {
        numbers(lookup(&self.scenario, path))
    }

    /// The tables of a list.
    pub fn tables(&self, name: &str) -> impl Iterator<Item = &toml::Table> {
        self.scenario.get(name).and_then(toml::Value::as_array).into_iter().flatten().filter_map(toml::Value::as_table)
    }

    /// The names that the tables of a list have.
    pub fn names(&self, list: &str) -> Vec<String> {
        self.tables(list).filter_map(|table| Some(table.get("name")?.as_str()?.to_owned())).collect()
    }

    /// 2 or 3, by the `space` of a table.
    pub fn dimension(&self, table: &str) -> usize {
        if self.word(&format!("{table}.space")) == Some("solid") { 3 } else { 2 }
    }

    /// A column of the series; nothing where there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        self.columns.get(name).map_or(&[], Vec::as_slice)
    }

    pub fn last(&self, name: &str) -> f64 {
        self.column(name).last().copied().unwrap_or(f64::NAN)
    }

    /// A column against time, in units.
    pub fn curve(&self, name: &str, scale: f64) -> Vec<[f64; 2]> {
        self.column("time").iter().zip(self.column(name)).map(|(time, value)| [*time, value * scale]).collect()
    }

    /// The length of a vector against time, from its columns `name_x` and so on.
    pub fn length(&self, name: &str, axes: &[&str], scale: f64) -> Vec<[f64; 2]> {
        let parts: Vec<&[f64]> = axes.iter().map(|axis| self.column(&format!("{name}_{axis}"))).collect();
        let norm =
            |row: usize| parts.iter().filter_map(|part| part.get(row)).map(|part| part * part).sum::<f64>().sqrt();
        self.column("time").iter().enumerate().map(|(row, time)| [*time, scale * norm(row)]).collect()
    }

    /// The row of the series nearest to a time, s.
    pub fn row_at(&self, time: f64) -> usize {
        let times = self.column("time");
        let away = |row: &usize| (times[*row] - time).abs();
        (0..times.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
    }
}

/// The numbers of a list.
pub fn numbers(list: Option<&toml::Value>) -> Vec<f64> {
    let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    list.and_then(toml::Value::as_array).into_iter().flatten().filter_map(number).collect()
}

/// A time with the unit that makes it short.
pub fn time(seconds: f64) -> String {
    let (unit, length) = unit_of_time(seconds);
    format!("{}\u{2009}{unit}", significant(seconds / length, 3))
}

/// Curves over one pair of axes, each with its name in the legend, which may be empty.
pub struct Plot {
    pub label: &'static str,
    pub lines: Vec<Line>,
    pub is_logarithmic: bool,
}

/// A name and places.
pub type Line = (String, Vec<[f64; 2]>);

/// Plots side by side, legends above them.
pub fn draw(name: &str, plots: &[Plot]) -> String {
    let mut svg = Svg::new(name, WIDTH, HEAD + HEIGHT + FOOT);
    for (index, (plot, frame)) in plots.iter().zip(side_by_side(plots.len(), WIDTH, HEAD, HEIGHT)).enumerate() {
        let stroke = |index: usize| Stroke::new(colour::line(index), 1.4);
        let named = plot.lines.iter().enumerate().filter(|(_, (words, _))| !words.is_empty());
        let entries: Vec<Entry> =
            named.map(|(index, (words, _))| Entry { words: words.clone(), stroke: stroke(index) }).collect();
        legend(&mut svg, [frame.left, 18.0], frame.width, &entries);
        let values = plot.lines.iter().flat_map(|(_, places)| places).map(|place| place[1]);
        let end = plot.lines.iter().flat_map(|(_, places)| places.last()).map(|place| place[0]).fold(0.0, f64::max);
        let (unit, length) = unit_of_time(end);
        let chart = Chart {
            title: if plots.len() > 1 { format!("({})", ["a", "b", "c"][index.min(2)]) } else { String::new() },
            x: Axis::exact(&format!("time ({unit})"), 0.0, end / length),
            y: match plot.is_logarithmic {
                true => Axis::decades(plot.label, values, DECADES),
                false => Axis::around(plot.label, values),
            },
            curves: plot
                .lines
                .iter()
                .enumerate()
                .map(|(index, (_, places))| Curve {
                    places: places.iter().map(|[time, value]| [time / length, *value]).collect(),
                    stroke: stroke(index),
                })
                .collect(),
            moments: Vec::new(),
            levels: Vec::new(),
        };
        chart.draw(&mut svg, frame);
    }
    svg.finish("Curves against time")
}

/// A unit of time for what lasts so many seconds, and its length, s.
fn unit_of_time(seconds: f64) -> (&'static str, f64) {
    match seconds {
        seconds if seconds >= 0.1 || seconds == 0.0 => ("s", 1.0),
        seconds if seconds >= 1e-4 => ("ms", 1e-3),
        _ => ("\u{b5}s", 1e-6),
    }
}
