//! The report on a continuum: its points at three moments, coloured by plastic strain and by mean stress, and the curves
//! of `series.csv` against time.

use scree_io::{Values, frames};

use super::chart::{exponent, power_of_ten, significant};
use super::load::{torn_frames, unreadable};
use super::page::Figure;
use super::panels::{colour_bar_between, round_up};
use super::records::{AXES, Line, Plot, Record, draw, numbers, time};
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, tenth};
use super::{WIDTH, colour};
use crate::base::error::Error;
use crate::base::math::PI;
use crate::job::Job;
use crate::observe::frame::Kind;

/// Room around panels, their largest height side by side and below each other, and room for their titles, pixels.
const GAP: f64 = 22.0;
const HEIGHT_MAX: [f64; 2] = [420.0, 260.0];
const TITLE: f64 = 26.0;
const BAR: f64 = 76.0;
/// From this width over height on panels stand below each other.
const WIDE: f64 = 1.8;
/// Share of the points that may lie beyond either end of the colours.
const BEYOND: f64 = 0.01;
/// Below this share of the compression, tension is left to the lower end of the colours.
const TENSION_SHARE_MIN: f64 = 0.05;
/// The kind of rows of a frame that are vertices of membranes.
const VERTEX: i64 = Kind::Membrane as i64;

/// Points of a picture that are drawn one by one; of more, and in space, squares of so many pixels have the mean, or
/// what is in front.
const SINGLE_MAX: usize = 12_000;
const PIXEL: f64 = 2.5;
/// Forces are shown in kN from here on, N.
const KILO_FROM: f64 = 1e4;

/// A run of a continuum.
pub struct Run {
    pub record: Record,
    dimension: usize,
}

/// A point of a picture.
struct Point {
    position: [f64; 3],
    /// Edge of the square or cube of its volume, m.
    edge: f64,
    /// Plastic strain; where there may be grains the deviatoric strain, which these have as well.
    strain: f64,
    /// Compression positive, Pa.
    pressure: f64,
}

/// Points at the time of a frame, s, and vertices of membranes, m.
struct Scene {
    time: f64,
    points: Vec<Point>,
    vertices: Vec<[f64; 2]>,
}

/// What a picture is coloured by.
struct Colours {
    name: &'static str,
    words: &'static str,
    of: fn(&Point) -> f64,
    /// Values of the ends, and what a unit of the bar is.
    ends: [f64; 2],
    unit: f64,
}

impl Run {
    pub fn new(record: Record) -> Self {
        Self { dimension: record.dimension("grid"), record }
    }

    /// Whether the job has grains, at any time.
    fn may_have_grains(&self) -> bool {
        !self.record.column("grains").is_empty()
    }

    /// As the job says; one of a former program may not be read any more.
    fn has_noisy_stresses(&self) -> bool {
        match Job::parse(&self.record.scenario_text, "scenario.toml", &[]) {
            Ok(Job::Mpm(job)) => job.has_noisy_stresses(),
            _ => false,
        }
    }

    fn axes(&self) -> &'static [&'static str] {
        &AXES[..self.dimension]
    }

    /// What happened in a few sentences, and all drawings.
    pub fn told(&self) -> Result<(String, Vec<Figure>), Error> {
        let last = self.record.frame_times.len() - 1;
        let mut chosen = vec![0, last / 2, last];
        chosen.dedup();
        let scenes = chosen.into_iter().map(|index| self.scene(index)).collect::<Result<Vec<_>, _>>()?;
        // Most points may have none, and what has yielded is what the colours are for.
        let strain = range(&scenes, |point| if point.strain > 0.0 { point.strain } else { f64::NAN });
        let mut figures = Vec::new();
        if strain[1] > 0.0 {
            let colours = Colours {
                name: if self.may_have_grains() { "deviatoric_strain" } else { "plastic_strain" },
                words: if self.may_have_grains() { "deviatoric strain" } else { "plastic strain" },
                of: |point| point.strain,
                ends: [0.0, round_up(strain[1])],
                unit: 1.0,
            };
            let words = if self.may_have_grains() { STRAIN_WORDS_OF_GRAINS } else { STRAIN_WORDS };
            figures.push((colours.name, self.picture(&scenes, &colours), words));
        }
        let pressure = range(&scenes, |point| point.pressure);
        let tension = pressure[0] < -TENSION_SHARE_MIN * pressure[1].abs();
        let end = round_end(pressure[1].max(if tension { -pressure[0] } else { 0.0 }));
        let colours = Colours {
            name: "mean_stress",
            words: "mean stress, compression positive (kPa)",
            of: |point| point.pressure,
            ends: [if tension { -end } else { 0.0 }, end],
            unit: 1e3,
        };
        let words = if self.has_noisy_stresses() { STRESS_WORDS_NOISY } else { STRESS_WORDS };
        figures.push((colours.name, self.picture(&scenes, &colours), words));
        match self.may_have_grains() {
            true => figures.push(("energies", self.energies_of_both(), BOTH_WORDS)),
            false => figures.push(("energies", self.energies(), ENERGY_WORDS)),
        }
        figures.push(("stress", self.stresses(), SERIES_WORDS));
        let reactions = self.reactions();
        if !reactions.is_empty() {
            let drawn = draw("reactions", &[in_fit_unit(reactions)]);
            figures.push(("reactions", drawn, REACTION_WORDS));
        }
        let followed = self.record.names("follow");
        if !followed.is_empty() {
            figures.push(("followed", self.followed(&followed), FOLLOWED_WORDS));
        }
        Ok((self.words(&scenes), figures))
    }

    fn words(&self, scenes: &[Scene]) -> String {
        let record = &self.record;
        let kind = if self.dimension == 2 { "in plane strain" } else { "in space" };
        let law = record.word("material.law").unwrap_or("its law").replace('_', " ");
        let moved: f64 = self.axes().iter().map(|axis| self.change(&format!("centre_{axis}"))).map(|by| by * by).sum();
        let extents: Vec<String> = self
            .axes()
            .iter()
            .map(|axis| {
                let end = |end: &str| significant(record.last(&format!("{end}_{axis}")), 3);
                format!("{} to {}\u{2009}m along {axis}", end("lower"), end("upper"))
            })
            .collect();
        let strain =
            scenes.last().map_or(0.0, |scene| scene.points.iter().map(|point| point.strain).fold(0.0, f64::max));
        let yielded = match strain > 0.0 {
            true if self.may_have_grains() => format!("the largest deviatoric strain is {}", significant(strain, 3)),
            true => format!("the largest plastic strain is {}", significant(strain, 3)),
            false => "no point has yielded".to_owned(),
        };
        let grains = match self.may_have_grains() {
            true => format!("{:.0} grains and ", record.last("grains")),
            false => String::new(),
        };
        format!(
            "{grains}{:.0} points {kind} ({law}) for {}. At the end their centre of mass has moved by {}\u{2009}m since the \
             first row of the series, the material reaches from {}, and {yielded}.",
            record.last("points"),
            time(record.last("time")),
            significant(moved.sqrt(), 3),
            extents.join(", "),
        )
    }

    /// Of a column from its first to its last row.
    fn change(&self, name: &str) -> f64 {
        self.record.last(name) - self.record.column(name).first().copied().unwrap_or(f64::NAN)
    }

    fn scene(&self, index: usize) -> Result<Scene, Error> {
        let path = self.record.directory.join("frames.vtkhdf");
        let frame = frames::read_frame(&path, index).map_err(unreadable)?;
        let rows = frame.positions.len();
        let reals = |name: &str| {
            let column = frame.fields.iter().find(|column| column.name == name);
            match column.map(|column| (&column.values, column.width)) {
                Some((Values::F64(values), width)) if values.len() == rows * width => Ok((values, width)),
                _ => Err(torn_frames(&path, &format!("frame {index}: field `{name}` is not what it should be"))),
            }
        };
        let strain = if self.may_have_grains() { "deviatoric_strain" } else { "plastic_strain" };
        let ((radii, _), (strains, _)) = (reals("radius")?, reals(strain)?);
        let (stresses, width) = reals("stress")?;
        let edge_of_radius = if self.dimension == 2 { PI.sqrt() } else { crate::base::math::cbrt(4.0 / 3.0 * PI) };
        let point = |row: usize| {
            // xx, yy, xy and in space zz.
            let stress = &stresses[width * row..width * (row + 1)];
            let trace = stress[0] + stress[1] + if self.dimension == 3 { stress[3] } else { 0.0 };
            Point {
                position: frame.positions[row],
                edge: edge_of_radius * radii[row],
                // Where a grain has lost its neighbours there is none.
                strain: if strains[row].is_finite() { strains[row] } else { 0.0 },
                pressure: -trace / self.dimension as f64,
            }
        };
        let kinds = frame.fields.iter().find(|column| column.name == "kind").map(|column| &column.values);
        let is_vertex = |row: &usize| matches!(kinds, Some(Values::I64(kinds)) if kinds.get(*row) == Some(&VERTEX));
        let (vertices, points): (Vec<usize>, Vec<usize>) = (0..rows).partition(is_vertex);
        let vertices = vertices.into_iter().map(|row| [frame.positions[row][0], frame.positions[row][1]]).collect();
        Ok(Scene { time: frame.time, points: points.into_iter().map(point).collect(), vertices })
    }

    /// The points at the moments of the scenes.
    fn picture(&self, scenes: &[Scene], colours: &Colours) -> String {
        let view = self.view(scenes);
        let size = [view[0][1] - view[0][0], view[1][1] - view[1][0]];
        let wide = size[0] > WIDE * size[1];
        let across = if wide { 1 } else { scenes.len().max(2) };
        let room = (WIDTH - GAP * (across + 1) as f64) / across as f64;
        let scale = (room / size[0]).min(HEIGHT_MAX[usize::from(wide)] / size[1]);
        let [width, height] = size.map(|length| length * scale);
        let down = if wide { scenes.len() } else { 1 };
        let bottom = down as f64 * (height + TITLE + 10.0);
        let mut svg = Svg::new(colours.name, WIDTH, bottom + BAR + 8.0);
        for (index, scene) in scenes.iter().enumerate() {
            let (column, row) = if wide { (0, index) } else { (index, 0) };
            let frame = Frame {
                left: GAP + column as f64 * (room + GAP) + 0.5 * (room - width),
                top: row as f64 * (height + TITLE + 10.0) + TITLE,
                width,
                height,
            };
            let title = format!("({}) {}", ["a", "b", "c"][index.min(2)], time(scene.time));
            svg.text([frame.left, frame.top - 8.0], &title, Letters::new(13.0, Anchor::Start).bold());
            let place =
                |[x, y]: [f64; 2]| [frame.left + (x - view[0][0]) * scale, frame.bottom() - (y - view[1][0]) * scale];
            svg.clipped(frame, |svg| {
                self.paint(svg, scene, colours, (frame, scale), place);
                self.outlines(svg, scene.time, scale, place);
                let dot = |vertex: &[f64; 2]| {
                    let [x, y] = place(*vertex).map(tenth);
                    format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"1.2\"/>")
                };
                let dots: String = scene.vertices.iter().map(dot).collect();
                if !dots.is_empty() {
                    svg.raw(&format!("<g fill=\"{}\">{dots}</g>\n", colour::PLATE));
                }
            });
        }
        let place = [0.5 * (WIDTH - 230.0), bottom + 16.0];
        colour_bar_between(&mut svg, place, 230.0, colours.ends.map(|end| end / colours.unit), colours.words);
        svg.finish(&format!("The points, coloured by {}", colours.words))
    }

    /// Squares of one colour are one path.
    fn paint(
        &self,
        svg: &mut Svg,
        scene: &Scene,
        colours: &Colours,
        (frame, scale): (Frame, f64),
        place: impl Fn([f64; 2]) -> [f64; 2],
    ) {
        let mut paths = vec![String::new(); colour::STEPS];
        let mut square = |[left, top]: [f64; 2], edge: f64, value: f64| {
            let share = (value - colours.ends[0]) / (colours.ends[1] - colours.ends[0]);
            let [left, top, edge] = [left, top, edge].map(tenth);
            paths[colour::step(share)].push_str(&format!("M{left} {top}h{edge}v{edge}h-{edge}z"));
        };
        let up = self.dimension - 1;
        if self.dimension == 2 && scene.points.len() <= SINGLE_MAX {
            for point in &scene.points {
                let [x, y] = place([point.position[0], point.position[1]]);
                // A little larger, so that no gaps show between squares that touch.
                let edge = 1.06 * point.edge * scale;
                square([x - 0.5 * edge, y - 0.5 * edge], edge, (colours.of)(point));
            }
        } else {
            let columns = (frame.width / PIXEL).ceil().max(1.0) as usize;
            let rows = (frame.height / PIXEL).ceil().max(1.0) as usize;
            // Sum and count in the plane; in space what is nearest along y.
            let mut pixels = vec![(0.0, 0.0, f64::INFINITY); columns * rows];
            for point in &scene.points {
                let [x, y] = place([point.position[0], point.position[up]]);
                let half = 0.5 * point.edge * scale;
                let reach = |middle: f64, start: f64, count: usize| {
                    let at = |value: f64| (((value - start) / PIXEL).floor().max(0.0) as usize).min(count - 1);
                    at(middle - half)..=at(middle + half - 1e-9)
                };
                for row in reach(y, frame.top, rows) {
                    for column in reach(x, frame.left, columns) {
                        let pixel = &mut pixels[row * columns + column];
                        let value = (colours.of)(point);
                        if up == 1 {
                            *pixel = (pixel.0 + value, pixel.1 + 1.0, 0.0);
                        } else if point.position[1] < pixel.2 {
                            *pixel = (value, 1.0, point.position[1]);
                        }
                    }
                }
            }
            for (index, (sum, count, _)) in pixels.into_iter().enumerate().filter(|(_, pixel)| pixel.1 > 0.0) {
                let corner = [index % columns, index / columns].map(|at| at as f64 * PIXEL);
                square([frame.left + corner[0], frame.top + corner[1]], PIXEL + 0.2, sum / count);
            }
        }
        for (step, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
            svg.raw(&format!("<path d=\"{path}\" fill=\"{}\"/>\n", colour::map(step)));
        }
    }

    /// The grid, and of plane strain the bodies where they are.
    fn outlines(&self, svg: &mut Svg, at: f64, scale: f64, place: impl Fn([f64; 2]) -> [f64; 2]) {
        let up = self.dimension - 1;
        let ends = ["lower", "upper"].map(|end| self.record.numbers(&format!("grid.{end}")));
        if let [lower, upper] = &ends
            && lower.len() > up
            && upper.len() > up
        {
            let outline = corners([lower[0], lower[up]], [upper[0], upper[up]]).map(&place);
            polygon(svg, &outline, Stroke::new(INK, 1.0).dash("4 3"));
        }
        if self.dimension == 3 {
            return;
        }
        let row = self.record.row_at(at);
        for body in self.record.tables("body") {
            let name = body.get("name").and_then(toml::Value::as_str).unwrap_or_default();
            let moved = [0, 1].map(|axis| {
                let column = self.record.column(&format!("{name}_displacement_{}", AXES[axis]));
                if at > 0.0 { column.get(row).copied().unwrap_or(0.0) } else { 0.0 }
            });
            let pair = |key: &str| <[f64; 2]>::try_from(numbers(body.get(key))).ok();
            let shifted = |[x, y]: [f64; 2]| place([x + moved[0], y + moved[1]]);
            let stroke = Stroke::new(colour::PLATE, 2.0);
            if let (Some(lower), Some(upper)) = (pair("lower"), pair("upper")) {
                polygon(svg, &corners(lower, upper).map(shifted), stroke);
            } else if let (Some(point), Some(normal)) = (pair("point"), pair("normal")) {
                // Far beyond the picture on either side.
                let along = [-1e3 * normal[1], 1e3 * normal[0]];
                let [from, to] = [-1.0, 1.0].map(|way| shifted([point[0] + way * along[0], point[1] + way * along[1]]));
                svg.line(from, to, stroke);
            } else if let (Some(centre), Some(radius)) = (pair("centre"), body.get("radius")) {
                let [x, y] = shifted(centre).map(tenth);
                let radius = tenth(scale * radius.as_float().unwrap_or(0.0));
                svg.raw(&format!(
                    "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n",
                    colour::PLATE
                ));
            }
        }
    }

    /// Ends of what is seen, across and upwards, m: all points of all scenes with a little room. In space it is seen
    /// along y.
    fn view(&self, scenes: &[Scene]) -> [[f64; 2]; 2] {
        [0, self.dimension - 1].map(|axis| {
            let ends = scenes.iter().flat_map(|scene| &scene.points).fold(
                [f64::INFINITY, f64::NEG_INFINITY],
                |[lower, upper], point| {
                    let (at, half) = (point.position[axis], 0.5 * point.edge);
                    [lower.min(at - half), upper.max(at + half)]
                },
            );
            let [lower, upper] = if ends[1] > ends[0] { ends } else { [0.0, 1.0] };
            let room = 0.03 * (upper - lower);
            [lower - room, upper + room]
        })
    }

    /// Of grains and points each.
    fn energies_of_both(&self) -> String {
        let lines = ["kinetic_grains", "elastic_grains", "kinetic_points", "elastic_points"];
        let lines = lines.map(|column| (column.replace('_', " of "), self.record.curve(column, 1.0)));
        draw("energies", &[Plot { label: "energy (J)", lines: lines.into(), is_logarithmic: true }])
    }

    fn energies(&self) -> String {
        let logarithmic = [("kinetic", "kinetic"), ("elastic", "elastic"), ("dissipated", "dissipated")]
            .map(|(column, words)| (words.to_owned(), self.record.curve(column, 1.0)));
        let start = |column: &str| self.record.column(column).first().copied().unwrap_or(0.0);
        let since = |column: &str| -> Vec<[f64; 2]> {
            self.record.curve(column, 1.0).iter().map(|[time, value]| [*time, value - start(column)]).collect()
        };
        let mut sum = since("potential");
        for column in ["kinetic", "elastic", "dissipated"] {
            sum.iter_mut().zip(since(column)).for_each(|(sum, more)| sum[1] += more[1]);
        }
        let mut changes = vec![("potential".to_owned(), since("potential")), ("sum of all".to_owned(), sum)];
        let accounts = [
            ("work_loads", "work of loads"),
            ("work_bodies", "work of bodies"),
            ("dissipated_holds", "lost at faces and bodies"),
            ("energy_lost", "lost by the scheme"),
        ];
        let kept = accounts.into_iter().filter(|(column, _)| !self.record.column(column).is_empty());
        changes.extend(kept.map(|(column, words)| (words.to_owned(), since(column))));
        draw(
            "energies",
            &[
                Plot { label: "energy (J)", lines: logarithmic.into(), is_logarithmic: true },
                Plot { label: "change since the first row (J)", lines: changes, is_logarithmic: false },
            ],
        )
    }

    fn stresses(&self) -> String {
        let mut lines: Vec<Line> = Vec::new();
        for axis in self.axes() {
            let column = format!("stress_{axis}{axis}");
            lines.push((format!("\u{2212}{axis}{axis}"), self.record.curve(&column, -1e-3)));
        }
        lines.push(("xy".to_owned(), self.record.curve("stress_xy", 1e-3)));
        let volume = self.record.column("volume").first().copied().unwrap_or(f64::NAN);
        let change = self.record.curve("volume", 1.0).into_iter().map(|[at, now]| [at, 100.0 * (now / volume - 1.0)]);
        draw(
            "stress",
            &[
                Plot { label: "stress (kPa)", lines, is_logarithmic: false },
                Plot {
                    label: "change of volume (%)",
                    lines: vec![(String::new(), change.collect())],
                    is_logarithmic: false,
                },
            ],
        )
    }

    /// Forces on faces that hold something, and on bodies.
    fn reactions(&self) -> Vec<Line> {
        let faces = self.axes().iter().flat_map(|axis| {
            ["lower", "upper"].map(|end| (format!("{axis}_{end}_force"), format!("face {axis}_{end}")))
        });
        let bodies = self.record.names("body").into_iter().map(|body| (format!("{body}_force"), body));
        let lines = faces.chain(bodies).filter(|(column, _)| !self.record.column(&format!("{column}_x")).is_empty());
        lines.map(|(column, words)| (words, self.record.length(&column, self.axes(), 1.0))).collect()
    }

    fn followed(&self, names: &[String]) -> String {
        let lines = |of: &dyn Fn(&str) -> Vec<[f64; 2]>| -> Vec<Line> {
            names.iter().map(|name| (name.clone(), of(name))).collect()
        };
        draw(
            "followed",
            &[
                Plot {
                    label: "displacement (m)",
                    lines: lines(&|name| self.record.length(&format!("{name}_displacement"), self.axes(), 1.0)),
                    is_logarithmic: false,
                },
                Plot {
                    label: "mean stress (kPa)",
                    lines: lines(&|name| self.record.curve(&format!("{name}_p"), -1e-3)),
                    is_logarithmic: false,
                },
                Plot {
                    label: "plastic strain",
                    lines: lines(&|name| self.record.curve(&format!("{name}_plastic_strain"), 1.0)),
                    is_logarithmic: false,
                },
            ],
        )
    }
}

const STRAIN_WORDS: &str = "The material points as squares of their area, in space what is in front of a look along y, \
     coloured by plastic strain. Dashed: the grid; grey: bodies, and vertices of membranes.";
const STRAIN_WORDS_OF_GRAINS: &str = "Grains and material points as squares of their area, coloured by deviatoric strain since they began: \
     of a grain that of the grains around it. Dashed: the grid; grey: bodies, and vertices of membranes.";
const BOTH_WORDS: &str = "Kinetic and elastic energy of grains and of points; what is zero has no place on this scale.";
const STRESS_WORDS: &str =
    "The same coloured by mean stress, compression positive; of plane strain the mean in the plane.";
const STRESS_WORDS_NOISY: &str = "The same coloured by mean stress, compression positive; of plane strain the mean in the plane. \
     With several points in a cell the stresses of single points under gravity, those that are followed too, are noise about the \
     mean of their cell: take scheme.points_per_cell = 1, which has far less of it.";
const ENERGY_WORDS: &str = "(a) Energies against time, at the last evaluation of forces; what is zero has no place on this \
     scale. (b) Potential energy, and the sum with those of (a), since the first row: the work of loads and bodies, less what \
     friction on faces and bodies and the scheme have taken. These are drawn where the run kept account ([output] ledger).";
const SERIES_WORDS: &str = "(a) Volume mean of the stress, normal stresses positive in compression; (b) change of volume \
     since the first row, against time.";
const REACTION_WORDS: &str = "Force of the material on every face that holds it and on every body, magnitude of the mean \
     over a row of series.csv.";
const FOLLOWED_WORDS: &str = "Points that are followed: (a) magnitude of displacement, (b) mean stress, compression \
     positive, (c) plastic strain, against time.";

/// Forces in N, or in kN where they are large.
fn in_fit_unit(mut lines: Vec<Line>) -> Plot {
    let values = lines.iter().flat_map(|(_, places)| places).map(|place| place[1]);
    let large = values.fold(0.0, f64::max) >= KILO_FROM;
    if large {
        lines.iter_mut().flat_map(|(_, places)| places).for_each(|place| place[1] *= 1e-3);
    }
    Plot { label: if large { "force (kN)" } else { "force (N)" }, lines, is_logarithmic: false }
}

fn corners(lower: [f64; 2], upper: [f64; 2]) -> [[f64; 2]; 4] {
    [lower, [upper[0], lower[1]], upper, [lower[0], upper[1]]]
}

fn polygon(svg: &mut Svg, places: &[[f64; 2]; 4], stroke: Stroke) {
    for (from, to) in places.iter().zip(places.iter().cycle().skip(1)) {
        svg.line(*from, *to, stroke);
    }
}

/// Values that all but a few points of all scenes lie between.
fn range(scenes: &[Scene], of: impl Fn(&Point) -> f64) -> [f64; 2] {
    let mut values: Vec<f64> = scenes.iter().flat_map(|scene| &scene.points).map(of).collect();
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let beyond = (values.len() as f64 * BEYOND) as usize;
    match values.len() > 2 * beyond {
        true => [values[beyond], values[values.len() - 1 - beyond]],
        false => [0.0, 0.0],
    }
}

/// A round value at or above a positive one; of none, one.
fn round_end(value: f64) -> f64 {
    if value <= 0.0 {
        return 1.0;
    }
    let decade = power_of_ten(exponent(value));
    decade * round_up(value / decade)
}
