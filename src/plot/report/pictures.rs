//! Specimens side by side, on one scale of length and of colour: points as squares of their size, grains as discs in their true size,
//! what holds them, membranes, the rim of a zone, and a band with its thickness beside it.

use std::fmt::Write as _;

use super::chart::{haloed, linear_ticks, pair, text_width, tick_step};
use super::numbers::{D50, plain, significant};
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, number, tenth};
use super::{WIDTH, colour, contour};
use crate::analysis::band::Band;
use crate::analysis::curve::range;
use crate::analysis::run::{Run, as_number, numbers};
use crate::analysis::snapshot::{Kind, Snapshot};
use crate::analysis::strained::{Span, Valued, free};

pub const MARGIN: f64 = 22.0;
/// Room beside a picture, and where a band has its measure there.
pub const GAP: f64 = 26.0;
const BESIDE: f64 = 74.0;
pub const TITLES: f64 = 46.0;
const HEAD: f64 = 22.0;
/// Largest heights of a picture, side by side and below each other, and from which width over height on they stand so.
const HEIGHT_MAX: [f64; 2] = [440.0, 260.0];
const WIDE: f64 = 1.8;
const COLUMNS_MAX: usize = 5;
/// Size of the larger letters of a title, pixels, with a little room: bold ones are wider.
const LETTERS: f64 = 13.5;
/// Below a row of pictures: the length to compare with. Below all: colours, and what lines mean.
const BELOW: f64 = 30.0;
const COLOURS: f64 = 66.0;
const MARKS: f64 = 24.0;
/// Share of the bodies that may lie beyond an end of the colours.
const BEYOND: f64 = 0.01;
const RIM: &str = "#ff2fa0";
/// A band whose slope is below this lies level, rad.
const LEVEL: f64 = 0.1;
/// Points of a picture that are drawn one by one; of more, and in space, squares of so many pixels have the mean, or
/// what is in front.
const SINGLE_MAX: usize = 12_000;
const PIXEL: f64 = 2.5;
/// Grains of a picture up to which each has an edge.
const EDGED_MAX: usize = 2_000;

/// A specimen, coloured.
pub struct Picture<'a> {
    pub run: &'a Run,
    /// s.
    pub time: f64,
    /// Above the first picture of a row; may be empty.
    pub head: String,
    pub titles: [String; 2],
    pub bodies: Vec<Valued>,
    pub vertices: Vec<[f64; 2]>,
    /// Of the cell, m.
    pub corner: Option<[f64; 2]>,
    pub band: Option<Band>,
}

impl<'a> Picture<'a> {
    pub fn of(run: &'a Run, snapshot: &Snapshot, bodies: Vec<Valued>, titles: [String; 2]) -> Self {
        let (vertices, corner) = (snapshot.vertices.clone(), snapshot.corner);
        Self { run, time: snapshot.time, head: String::new(), titles, bodies, vertices, corner, band: None }
    }
}

/// What colours say: the values at their ends, what a unit of the words is, and the words.
pub struct Colours<'a> {
    pub ends: [f64; 2],
    pub unit: f64,
    pub words: &'a str,
}

/// The values that few bodies beside the plates lie beyond.
pub fn nearly_all<'v>(bodies: impl Iterator<Item = &'v Valued>) -> [f64; 2] {
    let mut values: Vec<f64> = bodies.map(|row| row.value).filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let beyond = (values.len() as f64 * BEYOND) as usize;
    let last = values.len().checked_sub(1 + beyond);
    last.map_or([0.0; 2], |last| [values[beyond.min(last)], values[last]])
}

/// Draws pictures in rows of so many, or of as many as have room; colours below.
pub fn draw(name: &str, pictures: &[Picture], columns: Option<usize>, colours: &Colours, description: &str) -> String {
    let views: Vec<View> = pictures.iter().map(View::of).collect();
    let [lower, upper] = range(views.iter().flat_map(|view| view.up)).unwrap_or([0.0, 1.0]);
    let width = views.iter().map(View::width).fold(0.0, f64::max);
    let wide = width > WIDE * (upper - lower);
    let beside = if pictures.iter().any(|picture| picture.band.is_some()) { BESIDE } else { GAP };
    let columns = columns.filter(|_| !wide).unwrap_or_else(|| {
        let titles = pictures.iter().flat_map(|picture| &picture.titles).map(|title| text_width(title, LETTERS));
        let fit = ((WIDTH - MARGIN) / (titles.fold(0.0, f64::max) + 12.0)) as usize;
        let columns = if wide { 1 } else { pictures.len().min(fit).clamp(1, COLUMNS_MAX) };
        // Rows of one length: what fits into fewer columns is drawn larger.
        pictures.len().max(1).div_ceil(pictures.len().max(1).div_ceil(columns))
    });
    let room = (WIDTH - MARGIN) / columns as f64 - beside;
    let scale = (room / width).min(HEIGHT_MAX[usize::from(wide)] / (upper - lower));
    let height = (upper - lower) * scale;
    let titles = if pictures.iter().any(|picture| !picture.head.is_empty()) { TITLES + HEAD } else { TITLES };
    let row = titles + height + BELOW;
    // What has a head begins a row.
    let mut cells: Vec<[usize; 2]> = Vec::new();
    for picture in pictures {
        cells.push(match cells.last() {
            None => [0, 0],
            Some([down, across]) if !picture.head.is_empty() || across + 1 == columns => [down + 1, 0],
            Some([down, across]) => [*down, across + 1],
        });
    }
    let bottom = cells.last().map_or(0, |[down, _]| down + 1) as f64 * row;
    let mut svg = Svg::new(name, WIDTH, bottom + COLOURS + MARKS);
    for ((picture, view), [down, across]) in pictures.iter().zip(&views).zip(cells) {
        let left = MARGIN + across as f64 * (room + beside) + 0.5 * (room - view.width() * scale);
        let top = down as f64 * row + titles;
        let frame = Frame { left, top, width: view.width() * scale, height };
        let panel = Panel { picture, left: view.across[0], bottom: lower, scale, frame, colours };
        let above =
            |svg: &mut Svg, up: f64, words: &str, letters| svg.text([frame.left, frame.top - up], words, letters);
        above(&mut svg, 48.0, &picture.head, Letters::new(14.0, Anchor::Start).bold());
        above(&mut svg, 26.0, &picture.titles[0], Letters::new(13.0, Anchor::Start).bold());
        above(&mut svg, 10.0, &picture.titles[1], Letters::new(12.0, Anchor::Start));
        svg.clipped(frame, |svg| panel.draw(svg));
        if let Some(band) = &picture.band {
            panel.band(&mut svg, band);
        }
        if [down, across] == [0, 0] {
            panel.length(&mut svg);
        }
    }
    const BAR: f64 = 230.0;
    let place = [0.5 * (WIDTH - BAR), bottom + 8.0];
    colour_bar(&mut svg, place, BAR, colours.ends.map(|end| end / colours.unit), colours.words);
    marks(&mut svg, pictures, bottom + COLOURS + 12.0);
    svg.finish(description)
}

/// What is seen of space, m.
struct View {
    across: [f64; 2],
    up: [f64; 2],
}

impl View {
    /// The span of a measured specimen, or all bodies and the cell with a little room.
    fn of(picture: &Picture) -> Self {
        let around = |axis: usize| {
            let bodies = picture.bodies.iter();
            let ends = bodies.flat_map(|row| [-1.0, 1.0].map(|side| row.body.position[axis] + side * row.body.radius));
            range(ends.chain(cell(picture).into_iter().flatten().map(|corner| corner[axis])))
        };
        let roomy = |[lower, upper]: [f64; 2]| {
            let room = 0.03 * (upper - lower);
            [lower - room, upper + room]
        };
        let span = picture.run.span.map(|span| [span.left, span.left + span.width]);
        let up = around(1).unwrap_or([0.0, 1.0]);
        Self {
            across: span.or(around(0).map(roomy)).unwrap_or([0.0, 1.0]),
            up: if picture.run.period() > 0.0 { up } else { roomy(up) },
        }
    }

    fn width(&self) -> f64 {
        self.across[1] - self.across[0]
    }
}

/// Corners of the face of the cell that is seen, m.
fn cell(&Picture { run, time, corner, .. }: &Picture) -> Option<[[f64; 2]; 4]> {
    run.scenario.get("cell")?;
    let axes = ["x", "y", "z"];
    let (row, up) = (run.row_at(time), run.up());
    let lower = run.numbers("cell.lower");
    let lower = [0, up].map(|axis| lower.get(axis).copied().unwrap_or(0.0));
    // At the open ends of copies there is room that is nothing to be seen.
    let room = corner.map_or([0.0; 2], |corner| [lower[0] - corner[0], lower[1] - corner[1]]);
    let entry = |i: usize, j: usize| {
        let edge = run.column(&format!("edge_{}{}", axes[i], axes[j])).get(row).copied().unwrap_or(0.0);
        if i == j { edge - 2.0 * room[usize::from(i == up)] } else { edge }
    };
    Some([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[first, second]| {
        let place = |axis: usize| first * entry(axis, 0) + second * entry(axis, up);
        [lower[0] + place(0), lower[1] + place(up)]
    }))
}

/// Where a picture is drawn.
struct Panel<'a> {
    picture: &'a Picture<'a>,
    /// Of what is seen, m.
    left: f64,
    bottom: f64,
    /// Pixels per metre.
    scale: f64,
    frame: Frame,
    colours: &'a Colours<'a>,
}

impl Panel<'_> {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.frame.left + (x - self.left) * self.scale, self.frame.bottom() - (y - self.bottom) * self.scale]
    }

    /// The step of the colour map, or one beyond it where nothing is known.
    fn shade(&self, value: f64) -> usize {
        let [lower, upper] = self.colours.ends;
        if value.is_nan() { colour::STEPS } else { colour::step((value - lower) / (upper - lower)) }
    }

    fn fill(shade: usize) -> String {
        if shade < colour::STEPS { colour::map(shade) } else { colour::UNKNOWN.to_owned() }
    }

    fn draw(&self, svg: &mut Svg) {
        self.points(svg);
        self.grains(svg);
        let span = self.picture.run.span;
        if let Some(span) = &span {
            self.rim(svg, span);
        }
        self.outlines(svg);
        let vertices: Vec<[f64; 2]> = self.picture.vertices.iter().map(|&vertex| self.place(vertex)).collect();
        let dot = |[x, y]: &[f64; 2]| format!("<circle cx=\"{}\" cy=\"{}\" r=\"1.2\"/>", tenth(*x), tenth(*y));
        if !vertices.is_empty() {
            let dots: String = vertices.iter().map(dot).collect();
            svg.raw(&format!("<g fill=\"{}\">{dots}</g>\n", colour::PLATE));
        }
        if span.is_some_and(|span| span.is_periodic) {
            self.period(svg);
        }
    }

    /// Squares of one colour are one path.
    fn points(&self, svg: &mut Svg) {
        let dimension = self.picture.run.dimension();
        let points = || self.picture.bodies.iter().filter(|row| row.body.kind == Kind::Point);
        let mut paths = vec![String::new(); colour::STEPS + 1];
        let mut square = |[left, top]: [f64; 2], edge: f64, value: f64| {
            let [left, top, edge] = [left, top, edge].map(tenth);
            let _ = write!(paths[self.shade(value)], "M{left} {top}h{edge}v{edge}h-{edge}z");
        };
        if dimension == 2 && points().count() <= SINGLE_MAX {
            for row in points() {
                let edge = row.body.edge(2);
                for position in self.images(row.body.position, 0.5 * edge) {
                    let [x, y] = self.place(position);
                    // A little larger, so that no gaps show between squares that touch.
                    let edge = 1.06 * edge * self.scale;
                    square([x - 0.5 * edge, y - 0.5 * edge], edge, row.value);
                }
            }
        } else {
            let [columns, rows] =
                [self.frame.width, self.frame.height].map(|length| (length / PIXEL).ceil().max(1.0) as usize);
            // Sum and count in the plane; in space what is nearest along y.
            let mut pixels = vec![(0.0, 0.0, f64::INFINITY); columns * rows];
            for row in points() {
                let [x, y] = self.place(row.body.position);
                let half = 0.5 * row.body.edge(dimension) * self.scale;
                let reach = |middle: f64, start: f64, count: usize| {
                    let at = |value: f64| (((value - start) / PIXEL).floor().max(0.0) as usize).min(count - 1);
                    at(middle - half)..=at(middle + half - 1e-9)
                };
                for down in reach(y, self.frame.top, rows) {
                    for across in reach(x, self.frame.left, columns) {
                        let pixel = &mut pixels[down * columns + across];
                        if dimension == 2 {
                            *pixel = (pixel.0 + row.value, pixel.1 + 1.0, 0.0);
                        } else if row.body.depth < pixel.2 {
                            *pixel = (row.value, 1.0, row.body.depth);
                        }
                    }
                }
            }
            for (index, (sum, count, _)) in pixels.into_iter().enumerate().filter(|(_, pixel)| pixel.1 > 0.0) {
                let [across, down] = [index % columns, index / columns].map(|at| at as f64 * PIXEL);
                square([self.frame.left + across, self.frame.top + down], PIXEL + 0.2, sum / count);
            }
        }
        for (step, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
            svg.raw(&format!("<path shape-rendering=\"crispEdges\" d=\"{path}\" fill=\"{}\"/>\n", Self::fill(step)));
        }
    }

    /// Discs by colour; spheres the farthest first.
    fn grains(&self, svg: &mut Svg) {
        let glued = colour::STEPS + 1;
        let shade = |row: &Valued| if row.body.kind == Kind::Glued { glued } else { self.shade(row.value) };
        let mut grains: Vec<(usize, &Valued)> =
            self.picture.bodies.iter().filter(|row| row.body.kind.is_grain()).map(|row| (shade(row), row)).collect();
        match self.picture.run.dimension() {
            3 => grains.sort_by(|(_, a), (_, b)| b.body.depth.total_cmp(&a.body.depth)),
            _ => grains.sort_by_key(|(shade, _)| *shade),
        }
        let edge = if grains.len() <= EDGED_MAX { " stroke=\"#444444\" stroke-width=\"0.3\"" } else { "" };
        for group in grains.chunk_by(|a, b| a.0 == b.0) {
            let fill = if group[0].0 == glued { colour::PLATE.to_owned() } else { Self::fill(group[0].0) };
            let mut text = format!("<g fill=\"{fill}\"{edge}>");
            for (_, row) in group {
                for position in self.images(row.body.position, row.body.radius) {
                    let [x, y] = self.place(position).map(number);
                    let _ =
                        write!(text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\"/>", number(row.body.radius * self.scale));
                }
            }
            svg.raw(&(text + "</g>\n"));
        }
    }

    /// What crosses a side of the period shows on both.
    fn images(&self, [x, y]: [f64; 2], reach: f64) -> Vec<[f64; 2]> {
        let mut images = vec![[x, y]];
        if let Some(Span { width, .. }) = self.picture.run.span.filter(|span| span.is_periodic) {
            if x < reach {
                images.push([x + width, y]);
            }
            if x > width - reach {
                images.push([x - width, y]);
            }
        }
        images
    }

    /// The border of the reconciliation zone: of all bodies that carry less than their full weight.
    fn rim(&self, svg: &mut Svg, span: &Span) {
        let rim: Vec<&Valued> = self.picture.bodies.iter().filter(|row| row.body.weight < 1.0).collect();
        let places: Vec<[f64; 2]> = rim.iter().map(|row| row.body.position).collect();
        let reach = rim.iter().map(|row| row.body.radius).fold(0.0, f64::max) * 1.4;
        let mut path = String::new();
        for [from, to] in contour::outline(&places, reach, span) {
            let _ = write!(path, "M{}L{}", pair(self.place(from)), pair(self.place(to)));
        }
        svg.path(&path, Stroke::new("#ffffff", 2.2));
        svg.path(&path, Stroke::new(RIM, 1.2));
    }

    /// Sides that are joined, and plates without grains.
    fn period(&self, svg: &mut Svg) {
        let bodies = &self.picture.bodies;
        if !bodies.iter().any(|row| row.body.kind == Kind::Glued) {
            let edges =
                bodies.iter().flat_map(|row| [-1.0, 1.0].map(|side| row.body.position[1] + side * row.body.radius));
            let [lower, upper] = range(edges).unwrap_or_default().map(|y| self.place([self.left, y])[1]);
            for top in [lower, upper - 5.0] {
                svg.rectangle(Frame { top, height: 5.0, ..self.frame }, colour::PLATE);
            }
        }
        for x in [self.frame.left, self.frame.right()] {
            svg.line([x, self.frame.top], [x, self.frame.bottom()], Stroke::new("#999999", 0.8).dash("3 3"));
        }
    }

    fn polygon(&self, svg: &mut Svg, corners: [[f64; 2]; 4], stroke: Stroke) {
        let corners = corners.map(|corner| pair(self.place(corner)));
        svg.path(&format!("M{}Z", corners.join("L")), stroke);
    }

    /// The cell, the grid, and of plane strain the bodies where they are.
    fn outlines(&self, svg: &mut Svg) {
        let (run, time) = (self.picture.run, self.picture.time);
        let thin = Stroke::new(INK, 1.0).dash("4 3");
        let up = run.up();
        let [lower, upper] = ["grid.lower", "grid.upper"].map(|path| run.numbers(path));
        let grid =
            (lower.len() > up && upper.len() > up).then(|| corners([lower[0], lower[up]], [upper[0], upper[up]]));
        for outline in cell(self.picture).into_iter().chain(grid) {
            self.polygon(svg, outline, thin);
        }
        let row = run.row_at(time);
        for body in run.tables("body").filter(|_| run.dimension() == 2) {
            let name = body.get("name").and_then(toml::Value::as_str).unwrap_or_default();
            let way = |axis: &str| run.column(&format!("{name}_displacement_{axis}")).get(row).copied().unwrap_or(0.0);
            let moved = if time > 0.0 { ["x", "y"].map(way) } else { [0.0; 2] };
            let two = |key: &str| <[f64; 2]>::try_from(numbers(body.get(key))).ok();
            let shifted = |[x, y]: [f64; 2]| [x + moved[0], y + moved[1]];
            let stroke = Stroke::new(colour::PLATE, 2.0);
            if let (Some(lower), Some(upper)) = (two("lower"), two("upper")) {
                self.polygon(svg, corners(lower, upper).map(shifted), stroke);
            } else if let (Some(point), Some(normal)) = (two("point"), two("normal")) {
                // Far beyond the picture on either side.
                let end = |way: f64| [point[0] - way * normal[1], point[1] + way * normal[0]];
                let [from, to] = [-1e3, 1e3].map(|way| self.place(shifted(end(way))));
                svg.line(from, to, stroke);
            } else if let (Some(centre), Some(radius)) = (two("centre"), body.get("radius").and_then(as_number)) {
                let ([x, y], radius) = (self.place(shifted(centre)).map(tenth), tenth(self.scale * radius));
                svg.raw(&format!(
                    "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n",
                    colour::PLATE
                ));
            }
        }
    }

    /// The box of the band, and its thickness beside the picture.
    fn band(&self, svg: &mut Svg, band: &Band) {
        let Some(span) = self.picture.run.span else { return };
        svg.clipped(self.frame, |svg| {
            for image in span.images() {
                let corners =
                    band.corners().map(|corner| pair(self.place([corner[0] + image * span.width, corner[1]])));
                let path = match corners {
                    // A band that closes round the period has no ends.
                    [a, b, c, d] if band.closed => format!("M{a}L{b}M{c}L{d}"),
                    corners => format!("M{}Z", corners.join("L")),
                };
                svg.path(&path, Stroke::new("#ffffff", 3.0));
                svg.path(&path, Stroke::new("#000000", 1.4).dash("5 4"));
            }
        });
        let middle = self.place(band.centre)[1];
        let x = self.frame.right() + 10.0;
        if band.angle.abs() < LEVEL {
            let half = 0.5 * band.thickness * self.scale;
            let stroke = Stroke::new(INK, 1.2);
            svg.line([x, middle - half], [x, middle + half], stroke);
            for y in [middle - half, middle + half] {
                svg.line([x - 4.0, y], [x + 4.0, y], stroke);
            }
        }
        let thickness = band.thickness / span.diameter;
        // Of a single row of points there is none.
        let thickness = if thickness < 0.05 { "0".to_owned() } else { plain(thickness, 2) };
        let unit = if self.picture.run.has_grains() { D50 } else { "cells" };
        haloed(svg, [x + 8.0, middle + 4.5], &format!("{thickness} {unit}"), Letters::new(13.0, Anchor::Start));
    }

    /// A length to compare with, below the picture.
    fn length(&self, svg: &mut Svg) {
        let grain = self.picture.run.grain().ok();
        let one = grain.unwrap_or(1.0);
        let across = tick_step(self.frame.width / self.scale / one, 3);
        let (length, words) = match grain {
            Some(grain) => {
                let across = across.max(1.0);
                (across * grain, format!("{across:.0} {D50} = {}\u{2009}mm", significant(across * grain * 1e3, 2)))
            }
            None => (across, format!("{}\u{2009}m", plain(across, 2))),
        };
        let (x, y) = (self.frame.left, self.frame.bottom() + 15.0);
        svg.line([x, y], [x + length * self.scale, y], Stroke::new(INK, 2.0));
        svg.text([x + length * self.scale + 8.0, y + 4.0], &words, Letters::new(12.0, Anchor::Start));
    }
}

fn corners(lower: [f64; 2], upper: [f64; 2]) -> [[f64; 2]; 4] {
    [lower, [upper[0], lower[1]], upper, [lower[0], upper[1]]]
}

/// What lines and greys mean, of those that there are.
fn marks(svg: &mut Svg, pictures: &[Picture], y: f64) {
    let has = |test: &dyn Fn(&Valued) -> bool| pictures.iter().any(|picture| picture.bodies.iter().any(test));
    let mut x = MARGIN;
    let mut mark = |is_there: bool, words: &str, draw: &dyn Fn(&mut Svg, f64)| {
        if is_there {
            draw(svg, x);
            svg.text([x + 30.0, y], words, Letters::new(12.0, Anchor::Start));
            x += text_width(words, 12.0) + 60.0;
        }
    };
    let line =
        |stroke: Stroke<'static>| move |svg: &mut Svg, x: f64| svg.line([x, y - 4.0], [x + 24.0, y - 4.0], stroke);
    let patch = |fill: &'static str| {
        move |svg: &mut Svg, x: f64| {
            svg.rectangle(Frame { left: x + 12.0, top: y - 10.0, width: 12.0, height: 12.0 }, fill)
        }
    };
    let band = pictures.iter().any(|picture| picture.band.is_some());
    mark(has(&|row| row.body.weight < 1.0), "rim: grains and points share the mass", &line(Stroke::new(RIM, 1.6)));
    mark(band, "band", &line(Stroke::new("#000000", 1.4).dash("5 4")));
    mark(has(&|row| row.body.kind == Kind::Glued), "glued to a plate or body", &patch(colour::PLATE));
    let unknown = has(&|row| row.value.is_nan() && row.body.kind != Kind::Glued);
    mark(unknown, "not known, or not compared", &patch(colour::UNKNOWN));
}

fn colour_bar(svg: &mut Svg, place: [f64; 2], width: f64, [lower, upper]: [f64; 2], words: &str) {
    let step = width / colour::STEPS as f64;
    for index in 0..colour::STEPS {
        let left = place[0] + index as f64 * step;
        svg.rectangle(Frame { left, top: place[1], width: step + 0.5, height: 12.0 }, &colour::map(index));
    }
    svg.outline(Frame { left: place[0], top: place[1], width, height: 12.0 }, Stroke::new(INK, 0.8));
    let ticks = linear_ticks(lower, upper, 4);
    for (index, (value, text)) in ticks.iter().enumerate() {
        let x = place[0] + (value - lower) / (upper - lower) * width;
        svg.line([x, place[1] + 12.0], [x, place[1] + 16.0], Stroke::new(INK, 0.8));
        let reached = index + 1 == ticks.len() && *value > upper * (1.0 - 1e-9);
        let text = if reached { format!("\u{2265}\u{2009}{text}") } else { text.clone() };
        svg.text([x, place[1] + 28.0], &text, Letters::new(11.0, Anchor::Middle));
    }
    let middle = [place[0] + 0.5 * width, place[1] + 46.0];
    svg.text(middle, words, Letters::new(12.0, Anchor::Middle));
}

/// Where colours of a strain end: few bodies of all pictures beside the plates exceed it.
pub fn strain_end(pictures: &[Picture]) -> f64 {
    let of = |picture: &Picture| nearly_all(free(&picture.bodies))[1];
    super::numbers::round_up(pictures.iter().map(of).fold(0.0, f64::max))
}
