//! The report on grains in a cell: the grains at three moments, and the curves of `series.csv` against time.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use scree_io::{Values, frames, series};

use super::chart::{Axis, Chart, Curve, Entry, legend, side_by_side, significant};
use super::load::{Kind, broken, lookup, present, text, torn_frames, unreadable};
use super::panels::{colour_bar, round_up};
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, number};
use super::{WIDTH, colour};
use crate::error::Error;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Height of the axes of a chart, and room above and below them, pixels.
const HEIGHT: f64 = 220.0;
const HEAD: f64 = 74.0;
const FOOT: f64 = 52.0;
/// Decades of energy below the largest that are shown.
const DECADES: i32 = 9;
/// Panels side by side, the room between them, and the height that they may have, pixels.
const PANELS: usize = 3;
const GAP: f64 = 22.0;
const PANEL_HEIGHT_MAX: f64 = 420.0;
/// Share of the grains that may lie beyond the end of the colours.
const BEYOND: f64 = 0.01;

/// A run of an assembly.
pub struct Run {
    pub directory: PathBuf,
    pub name: String,
    pub scenario_text: String,
    pub summary: serde_json::Map<String, serde_json::Value>,
    dimension: usize,
    /// Lower corner of the cell, m.
    corner: Vec<f64>,
    bodies: Vec<String>,
    columns: BTreeMap<String, Vec<f64>>,
    /// s.
    frame_times: Vec<f64>,
}

/// A grain of a picture.
struct Grain {
    position: [f64; 3],
    radius: f64,
    glued: bool,
    /// Mean stress of its contacts, compression positive, Pa.
    pressure: f64,
}

/// Grains at the time of a frame, s.
struct Scene {
    time: f64,
    grains: Vec<Grain>,
}

/// Whether a directory holds a run of an assembly; what cannot be read is left to who reads it.
pub fn is_assembly(directory: &Path) -> bool {
    let scenario = text(&directory.join("scenario.toml")).ok();
    scenario.and_then(|text| text.parse::<toml::Table>().ok()).is_some_and(|scenario| scenario.contains_key("cell"))
}

impl Run {
    /// Reads all but the frames of a run directory.
    pub fn read(directory: &Path) -> Result<Self, Error> {
        let [scenario_path, summary_path, series_path, frames_path] =
            ["scenario.toml", "summary.json", "series.csv", "frames.vtkhdf"].map(|name| directory.join(name));
        let scenario_text = text(&scenario_path)?;
        let scenario: toml::Table = toml::from_str(&scenario_text).map_err(|error| {
            broken(&scenario_path, &format!("is not TOML: {}", error.message()), "Copy it back from the run's job")
        })?;
        let summary = serde_json::from_str(&text(&summary_path)?).map_err(|error| {
            broken(&summary_path, &format!("is not a JSON object: {error}"), "Resume the run; its end writes it anew")
        })?;
        present(&series_path)?;
        let (header, rows) = series::read(&series_path).map_err(unreadable)?;
        if rows.is_empty() {
            return Err(broken(&series_path, "has no rows yet", "Let the run go on: `scree resume`"));
        }
        let column = |index: usize| rows.iter().map(|row| row.get(index).copied().unwrap_or(f64::NAN)).collect();
        let columns = header.iter().enumerate().map(|(index, name)| (name.clone(), column(index))).collect();
        present(&frames_path)?;
        let frame_times = frames::times(&frames_path).map_err(unreadable)?;
        if frame_times.is_empty() {
            return Err(torn_frames(&frames_path, "it holds no frame"));
        }
        let word = |path: &str| lookup(&scenario, path).and_then(toml::Value::as_str).map(str::to_owned);
        let list = |path: &str| lookup(&scenario, path).and_then(toml::Value::as_array).cloned().unwrap_or_default();
        let named = |body: &toml::Value| body.get("name").and_then(toml::Value::as_str).map(str::to_owned);
        let dimension = if word("cell.space").as_deref() == Some("solid") { 3 } else { 2 };
        let mut corner: Vec<f64> = list("cell.lower").iter().filter_map(toml::Value::as_float).collect();
        corner.resize(dimension, 0.0);
        Ok(Self {
            directory: directory.to_owned(),
            name: word("name").unwrap_or_else(|| "run".to_owned()),
            dimension,
            corner,
            bodies: list("body").iter().filter_map(named).collect(),
            scenario_text,
            summary,
            columns,
            frame_times,
        })
    }

    /// A column of the series; nothing where there is none.
    fn column(&self, name: &str) -> &[f64] {
        self.columns.get(name).map_or(&[], Vec::as_slice)
    }

    fn last(&self, name: &str) -> f64 {
        self.column(name).last().copied().unwrap_or(f64::NAN)
    }

    /// A column against time, in units.
    fn curve(&self, name: &str, scale: f64) -> Vec<[f64; 2]> {
        self.column("time").iter().zip(self.column(name)).map(|(time, value)| [*time, value * scale]).collect()
    }

    /// A time with the unit that makes it short.
    fn time(seconds: f64) -> String {
        let (unit, length) = unit_of_time(seconds);
        format!("{}\u{2009}{unit}", significant(seconds / length, 3))
    }

    /// What happened, in a few sentences.
    pub fn words(&self) -> String {
        let kind = if self.dimension == 2 { "discs" } else { "spheres" };
        let stresses: Vec<String> = self.axes().iter().map(|axis| self.stress_at_end(axis)).collect();
        format!(
            "{:.0} {kind} in a cell for {}. At the end the packing fraction is {}, a grain has {} contacts, and the \
             normal stresses of the contacts are {} kPa (compression positive) along {}.",
            self.last("grains"),
            Self::time(self.last("time")),
            significant(self.last("fraction"), 4),
            significant(2.0 * self.last("contacts") / self.last("grains"), 3),
            stresses.join(", "),
            self.axes().join(", "),
        )
    }

    fn stress_at_end(&self, axis: &str) -> String {
        significant(-1e-3 * self.last(&format!("stress_{axis}{axis}")), 3)
    }

    fn axes(&self) -> &'static [&'static str] {
        &AXES[..self.dimension]
    }

    /// Edges of the cell in the row nearest to a time, m: as columns.
    fn edges(&self, time: f64) -> Vec<Vec<f64>> {
        let times = self.column("time");
        let nearest = (0..times.len()).min_by(|a, b| (times[*a] - time).abs().total_cmp(&(times[*b] - time).abs()));
        let entry = |i: &str, j: &str| self.column(&format!("edge_{i}{j}")).get(nearest.unwrap_or(0)).copied();
        let edge = |j: &&str| self.axes().iter().map(|i| entry(i, j).unwrap_or(0.0)).collect();
        self.axes().iter().map(edge).collect()
    }

    fn scene(&self, index: usize) -> Result<Scene, Error> {
        let path = self.directory.join("frames.vtkhdf");
        let frame = frames::read_frame(&path, index).map_err(unreadable)?;
        let rows = frame.positions.len();
        let find = |name: &str| frame.fields.iter().find(|column| column.name == name);
        let torn = |name: &str| torn_frames(&path, &format!("frame {index}: field `{name}` is not what it should be"));
        let reals = |name: &str| match find(name).map(|column| (&column.values, column.width)) {
            Some((Values::F64(values), width)) if values.len() == rows * width => Ok((values, width)),
            _ => Err(torn(name)),
        };
        let ((radii, _), (stresses, width)) = (reals("radius")?, reals("stress")?);
        let kinds = match find("kind").map(|column| &column.values) {
            Some(Values::I64(kinds)) if kinds.len() == rows => kinds,
            _ => return Err(torn("kind")),
        };
        let grain = |row: usize| {
            // xx, yy, xy and in space zz.
            let stress = &stresses[width * row..width * (row + 1)];
            let trace = stress[0] + stress[1] + if self.dimension == 3 { stress[3] } else { 0.0 };
            Grain {
                position: frame.positions[row],
                radius: radii[row],
                glued: kinds[row] == Kind::Glued as i64,
                pressure: -trace / self.dimension as f64,
            }
        };
        Ok(Scene { time: frame.time, grains: (0..rows).map(grain).collect() })
    }

    /// The grains at the start, in the middle and at the end.
    pub fn picture(&self) -> Result<String, Error> {
        let last = self.frame_times.len() - 1;
        let mut chosen = vec![0, last / 2, last];
        chosen.dedup();
        let scenes = chosen.into_iter().map(|index| self.scene(index)).collect::<Result<Vec<_>, _>>()?;
        let view = View::of(self, &scenes);
        let (room, size) = ((WIDTH - GAP * (PANELS + 1) as f64) / PANELS as f64, view.size());
        let scale = (room / size[0]).min(PANEL_HEIGHT_MAX / size[1]);
        let frame = |column: usize| Frame {
            left: GAP + column as f64 * (room + GAP) + 0.5 * (room - size[0] * scale),
            top: 34.0,
            width: size[0] * scale,
            height: size[1] * scale,
        };
        let upper = colours_end(&scenes);
        let mut svg = Svg::new("grains", WIDTH, 34.0 + size[1] * scale + 76.0);
        for (column, scene) in scenes.iter().enumerate() {
            let panel = Panel { view: &view, scale, frame: frame(column), upper };
            let title = format!("({}) {}", ["a", "b", "c"][column.min(2)], Self::time(scene.time));
            svg.text([panel.frame.left, 22.0], &title, Letters::new(13.0, Anchor::Start).bold());
            panel.draw(&mut svg, scene, &self.edges(scene.time));
        }
        let place = [0.5 * (WIDTH - 230.0), 34.0 + size[1] * scale + 16.0];
        if scenes.iter().flat_map(|scene| &scene.grains).any(|grain| grain.pressure > 0.0) {
            colour_bar(&mut svg, place, 230.0, 1e-3 * upper, "mean stress of a grain's contacts (kPa)");
        } else {
            let letters = Letters::new(12.0, Anchor::Middle);
            svg.text([0.5 * WIDTH, place[1] + 20.0], "no contact is under compression at these times", letters);
        }
        Ok(svg.finish("The grains, coloured by mean stress"))
    }

    /// The curves: stresses, packing fraction, energies, contacts, and forces on bodies.
    pub fn curves(&self) -> Vec<(&'static str, String, &'static str)> {
        let mut figures = vec![
            ("stress", self.stresses(), STRESS_WORDS),
            (
                "energies",
                self.energies(),
                "Energies of the grains against time. What is zero has no place on this scale.",
            ),
        ];
        if !self.bodies.is_empty() {
            figures.push((
                "bodies",
                self.forces(),
                "Force of the grains on every body, magnitude of the mean over a row of series.csv.",
            ));
        }
        figures
    }

    fn stresses(&self) -> String {
        let mut lines: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
        for axis in self.axes() {
            lines.push((format!("\u{2212}{axis}{axis}"), self.curve(&format!("stress_{axis}{axis}"), -1e-3)));
        }
        lines.push(("xy".to_owned(), self.curve("stress_xy", 1e-3)));
        let contacts = self.column("contacts").iter().zip(self.column("grains"));
        let contacts =
            self.column("time").iter().zip(contacts).map(|(time, (contacts, grains))| [*time, 2.0 * contacts / grains]);
        draw(
            "stress",
            &[
                Plot { label: "stress (kPa)", lines, is_logarithmic: false },
                Plot {
                    label: "packing fraction",
                    lines: vec![(String::new(), self.curve("fraction", 1.0))],
                    is_logarithmic: false,
                },
                Plot {
                    label: "contacts of a grain",
                    lines: vec![(String::new(), contacts.collect())],
                    is_logarithmic: false,
                },
            ],
        )
    }

    fn energies(&self) -> String {
        let names = [
            ("elastic", "elastic"),
            ("kinetic_translation", "kinetic, translation"),
            ("kinetic_rotation", "kinetic, rotation"),
        ];
        let lines = names.map(|(column, words)| (words.to_owned(), self.curve(column, 1.0)));
        draw("energies", &[Plot { label: "energy (J)", lines: lines.into(), is_logarithmic: true }])
    }

    fn forces(&self) -> String {
        let force = |body: &String| {
            let parts: Vec<&[f64]> =
                self.axes().iter().map(|axis| self.column(&format!("{body}_force_{axis}"))).collect();
            let norm =
                |row: usize| parts.iter().filter_map(|part| part.get(row)).map(|part| part * part).sum::<f64>().sqrt();
            let places = self.column("time").iter().enumerate().map(|(row, time)| [*time, norm(row)]).collect();
            (body.clone(), places)
        };
        let lines = self.bodies.iter().take(colour::LINES.len()).map(force).collect();
        draw("bodies", &[Plot { label: "force (N)", lines, is_logarithmic: false }])
    }
}

const STRESS_WORDS: &str = "(a) Mean stress of the contacts over the cell, normal stresses positive in compression; (b) \
     packing fraction of the cell; (c) contacts of a grain in the mean, against time.";

/// Curves over one pair of axes, each with its name in the legend, which may be empty.
struct Plot {
    label: &'static str,
    lines: Vec<(String, Vec<[f64; 2]>)>,
    is_logarithmic: bool,
}

/// Plots side by side, legends above them.
fn draw(name: &str, plots: &[Plot]) -> String {
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

/// The mean stress at which the colours end, Pa.
fn colours_end(scenes: &[Scene]) -> f64 {
    let mut values: Vec<f64> = scenes.iter().flat_map(|scene| &scene.grains).map(|grain| grain.pressure).collect();
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let beyond = (values.len() as f64 * BEYOND) as usize;
    round_up(values.len().checked_sub(1 + beyond).map_or(0.0, |index| values[index]))
}

/// What a picture shows of space: x to the right, and upwards y of discs, z of spheres, which are seen along y.
struct View {
    up: usize,
    corner: Vec<f64>,
    /// Lower and upper ends, m.
    across: [f64; 2],
    along: [f64; 2],
}

impl View {
    /// Wide enough for the cell and every grain of all scenes.
    fn of(run: &Run, scenes: &[Scene]) -> Self {
        let mut view = Self { up: run.dimension - 1, corner: run.corner.clone(), across: EMPTY, along: EMPTY };
        for scene in scenes {
            for place in view.outline(&run.edges(scene.time)) {
                view.widen(place, 0.0);
            }
            for grain in &scene.grains {
                view.widen(view.seen(&grain.position), grain.radius);
            }
        }
        view
    }

    fn widen(&mut self, [x, y]: [f64; 2], reach: f64) {
        for (ends, value) in [(&mut self.across, x), (&mut self.along, y)] {
            *ends = [ends[0].min(value - reach), ends[1].max(value + reach)];
        }
    }

    fn seen(&self, position: &[f64; 3]) -> [f64; 2] {
        [position[0], position[self.up]]
    }

    /// Corners of the face of the cell that is seen.
    fn outline(&self, edges: &[Vec<f64>]) -> [[f64; 2]; 4] {
        let corner = [self.corner[0], self.corner[self.up]];
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[first, second]| {
            let place = |axis: usize| first * edges[0][axis] + second * edges[self.up][axis];
            [corner[0] + place(0), corner[1] + place(self.up)]
        })
    }

    fn size(&self) -> [f64; 2] {
        [self.across, self.along].map(|[lower, upper]| if upper > lower { upper - lower } else { 1.0 })
    }
}

const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Where a scene is drawn.
struct Panel<'a> {
    view: &'a View,
    /// Pixels per metre.
    scale: f64,
    frame: Frame,
    /// The end of the colours, Pa.
    upper: f64,
}

impl Panel<'_> {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.frame.left + (x - self.view.across[0]) * self.scale,
            self.frame.bottom() - (y - self.view.along[0]) * self.scale,
        ]
    }

    /// Grains, the farthest first, and the cell over them.
    fn draw(&self, svg: &mut Svg, scene: &Scene, edges: &[Vec<f64>]) {
        let mut order: Vec<&Grain> = scene.grains.iter().collect();
        if self.view.up == 2 {
            order.sort_by(|a, b| b.position[1].total_cmp(&a.position[1]));
        }
        for grain in order {
            let [x, y] = self.place(self.view.seen(&grain.position));
            let fill = match grain.glued {
                true => colour::PLATE.to_owned(),
                false => colour::map(colour::step(grain.pressure / self.upper)),
            };
            svg.raw(&format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{fill}\" stroke=\"#444444\" stroke-width=\"0.3\"/>\n",
                number(x),
                number(y),
                number(grain.radius * self.scale)
            ));
        }
        let corners = self.view.outline(edges).map(|corner| self.place(corner));
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            svg.line(*from, *to, Stroke::new(INK, 1.0).dash("4 3"));
        }
    }
}
