//! The specimen at the drawn moments, bodies in their true size, coloured by strain.

use std::fmt::Write as _;

use super::chart::{exponent, haloed, linear_ticks, pair, percent, power_of_ten, significant, tick_step};
use super::figures::label;
use super::load::{Kind, Run};
use super::scenes::{Scenes, Since, Valued, free, heights, square_edge};
use super::span::Span;
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, number, tenth};
use super::words::{D50, in_diameters};
use super::{colour, contour};
use crate::analysis::band::Band;

const MARGIN_LEFT: f64 = 22.0;
/// Room for the measure of the band beside the last panel.
const MARGIN_RIGHT: f64 = 92.0;
const GAP: f64 = 26.0;
const HEIGHT_MAX: f64 = 500.0;
const TITLES: f64 = 46.0;
const LEGEND: f64 = 92.0;
/// Columns of panels.
const COLUMNS: usize = 3;
/// Share of the bodies that may lie beyond the end of the colours.
const BEYOND: f64 = 0.01;
const RIM: &str = "#ff2fa0";
/// A band whose slope is below this lies level, rad.
const LEVEL: f64 = 0.1;

/// A run with its scenes.
pub struct Told<'a> {
    pub run: &'a Run,
    pub scenes: &'a Scenes,
}

/// Draws a row of panels for every run, and the colours below.
pub fn draw(told: &[Told], width: f64) -> String {
    let room = (width - MARGIN_LEFT - MARGIN_RIGHT - GAP * (COLUMNS - 1) as f64) / COLUMNS as f64;
    // One scale for all runs, so that sizes compare.
    let scale = told.iter().fold(f64::INFINITY, |scale, Told { run, scenes }| {
        scale.min(room / run.width).min(HEIGHT_MAX / (scenes.heights[1] - scenes.heights[0]))
    });
    let several = told.len() > 1;
    let title_height = if several { TITLES + 22.0 } else { TITLES };
    let row_height = |scenes: &Scenes| title_height + (scenes.heights[1] - scenes.heights[0]) * scale + 26.0;
    let height: f64 = told.iter().map(|told| row_height(told.scenes)).sum::<f64>() + LEGEND;

    let colours = Colours::of(told);
    let mut svg = Svg::new("specimen", width, height);
    let mut top = 0.0;
    for Told { run, scenes } in told {
        if several {
            svg.text([MARGIN_LEFT, top + 18.0], &label(run), Letters::new(14.0, Anchor::Start).bold());
        }
        for (column, scene) in scenes.scenes.iter().enumerate() {
            let panel = Panel {
                span: run.span(),
                scale,
                bottom: scenes.heights[0],
                frame: Frame {
                    left: MARGIN_LEFT + column as f64 * (room + GAP) + 0.5 * (room - run.width * scale),
                    top: top + title_height,
                    width: run.width * scale,
                    height: (scenes.heights[1] - scenes.heights[0]) * scale,
                },
            };
            let letter = ["a", "b", "c"][column.min(2)];
            let titles = [format!("({letter}) {}", scene.title), format!("strain {}", percent(scene.strain))];
            panel.titles(&mut svg, &titles);
            panel.bodies(&mut svg, &scene.bodies, colours.upper(scene.since));
            if let Some(band) = scenes.band.as_ref().filter(|_| column + 1 == scenes.scenes.len()) {
                panel.band(&mut svg, band);
            }
            if column == 0 {
                panel.length(&mut svg);
            }
        }
        top += row_height(scenes);
    }
    colours.draw(&mut svg, told, width, room, top);
    svg.finish("The specimen, bodies coloured by incremental deviatoric strain")
}

/// Where a scene is drawn.
pub struct Panel {
    pub span: Span,
    /// Pixels per metre.
    pub scale: f64,
    /// Height of the specimen's lower edge, m.
    pub bottom: f64,
    pub frame: Frame,
}

impl Panel {
    fn place(&self, position: [f64; 2]) -> [f64; 2] {
        [
            self.frame.left + (position[0] - self.span.left) * self.scale,
            self.frame.bottom() - (position[1] - self.bottom) * self.scale,
        ]
    }

    /// A line in bold letters above the frame and a plain one below it.
    pub fn titles(&self, svg: &mut Svg, [bold, plain]: &[String; 2]) {
        svg.text([self.frame.left, self.frame.top - 26.0], bold, Letters::new(13.0, Anchor::Start).bold());
        svg.text([self.frame.left, self.frame.top - 10.0], plain, Letters::new(12.0, Anchor::Start));
    }

    /// Points as squares, grains as discs over them, plates in grey, the rim with its outline.
    pub fn bodies(&self, svg: &mut Svg, bodies: &[Valued], upper: f64) {
        svg.clipped(self.frame, |svg| {
            svg.rectangle(self.frame, "#ffffff");
            let mut rows: Vec<(usize, &Valued)> = bodies.iter().map(|row| (shade(row, upper), row)).collect();
            rows.sort_by_key(|(shade, row)| (row.body.kind, *shade));
            for group in rows.chunk_by(|a, b| (a.1.body.kind, a.0) == (b.1.body.kind, b.0)) {
                let fill = match (group[0].1.body.kind, group[0].0) {
                    (Kind::Glued, _) => colour::PLATE.to_owned(),
                    (_, shade) if shade < colour::STEPS => colour::map(shade),
                    _ => colour::UNKNOWN.to_owned(),
                };
                svg.raw(&self.shapes(group, &fill));
            }
            self.rim(svg, bodies);
        });
        if !self.span.is_periodic {
            return;
        }
        if !bodies.iter().any(|row| row.body.kind == Kind::Glued) {
            let [lower, upper] = heights(bodies).map(|y| self.place([self.span.left, y])[1]);
            for top in [lower, upper - 5.0] {
                svg.rectangle(Frame { top, height: 5.0, ..self.frame }, colour::PLATE);
            }
        }
        for x in [self.frame.left, self.frame.right()] {
            svg.line([x, self.frame.top], [x, self.frame.bottom()], Stroke::new("#999999", 0.8).dash("3 3"));
        }
    }

    /// Bodies of one kind and colour; what crosses a side of the period shows on both.
    fn shapes(&self, group: &[(usize, &Valued)], fill: &str) -> String {
        let mut text = String::new();
        let point = group[0].1.body.kind == Kind::Point;
        let _ = write!(text, r#"<g fill="{fill}">"#);
        if point {
            text.push_str("<path shape-rendering=\"crispEdges\" d=\"");
        }
        for (_, Valued { body, .. }) in group {
            let reach = if point { 0.5 * square_edge(body.radius) } else { body.radius };
            let mut images = vec![0.0];
            let width = self.span.width;
            if self.span.is_periodic && body.position[0] < reach {
                images.push(width);
            }
            if self.span.is_periodic && body.position[0] > width - reach {
                images.push(-width);
            }
            for image in images {
                let place = self.place([body.position[0] + image, body.position[1]]);
                if point {
                    // A hair wider, so that neighbours leave no gap.
                    let edge = 2.0 * reach * self.scale + 0.3;
                    let (x, y) = (tenth(place[0] - 0.5 * edge), tenth(place[1] - 0.5 * edge));
                    let edge = tenth(edge);
                    let _ = write!(text, "M{x} {y}h{edge}v{edge}h-{edge}z");
                } else {
                    let (x, y) = (number(place[0]), number(place[1]));
                    let _ = write!(text, r#"<circle cx="{x}" cy="{y}" r="{}"/>"#, number(reach * self.scale));
                }
            }
        }
        text.push_str(if point { "\"/></g>\n" } else { "</g>\n" });
        text
    }

    /// The border of the reconciliation zone: of all bodies that carry less than their full weight.
    fn rim(&self, svg: &mut Svg, bodies: &[Valued]) {
        let rim: Vec<&Valued> = bodies.iter().filter(|row| row.body.weight < 1.0).collect();
        let places: Vec<[f64; 2]> = rim.iter().map(|row| row.body.position).collect();
        let reach = rim.iter().map(|row| row.body.radius).fold(0.0, f64::max) * 1.4;
        let mut path = String::new();
        for [from, to] in contour::outline(&places, reach, &self.span) {
            let _ = write!(path, "M{}L{}", pair(self.place(from)), pair(self.place(to)));
        }
        svg.path(&path, Stroke::new("#ffffff", 2.2));
        svg.path(&path, Stroke::new(RIM, 1.2));
    }

    /// The box of the band, and its thickness beside the panel.
    pub fn band(&self, svg: &mut Svg, band: &Band) {
        svg.clipped(self.frame, |svg| {
            for image in self.span.images() {
                let corners =
                    band.corners().map(|corner| pair(self.place([corner[0] + image * self.span.width, corner[1]])));
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
        let words = format!("{} {D50}", in_diameters(band.thickness / self.span.diameter));
        haloed(svg, [x + 8.0, middle + 4.5], &words, Letters::new(13.0, Anchor::Start));
    }

    /// A length to compare with, below the panel.
    pub fn length(&self, svg: &mut Svg) {
        let across = tick_step(self.span.width / self.span.diameter, 3).max(1.0);
        let length = across * self.span.diameter * self.scale;
        let (x, y) = (self.frame.left, self.frame.bottom() + 15.0);
        svg.line([x, y], [x + length, y], Stroke::new(INK, 2.0));
        let words =
            format!("{across:.0} D\u{2085}\u{2080} = {}\u{2009}mm", significant(across * self.span.diameter * 1e3, 2));
        svg.text([x + length + 8.0, y + 4.0], &words, Letters::new(12.0, Anchor::Start));
    }
}

/// The step of the colour map, or one beyond it where the strain is not known.
fn shade(row: &Valued, upper: f64) -> usize {
    if row.value.is_nan() { colour::STEPS } else { colour::step(row.value / upper) }
}

/// The strain at which the colours end, for both ways of counting it.
struct Colours {
    origin: f64,
    frame: f64,
}

impl Colours {
    fn of(told: &[Told]) -> Self {
        let upper = |origin: bool| {
            let mut most: f64 = 0.0;
            let scenes = told.iter().flat_map(|told| &told.scenes.scenes);
            for scene in scenes.filter(|scene| (scene.since == Since::Origin) == origin) {
                most = most.max(nearly_largest(&scene.bodies));
            }
            round_up(most)
        };
        Self { origin: upper(true), frame: upper(false) }
    }

    fn upper(&self, since: Since) -> f64 {
        match since {
            Since::Origin => self.origin,
            Since::Frame(_) => self.frame,
        }
    }

    fn draw(&self, svg: &mut Svg, told: &[Told], width: f64, room: f64, top: f64) {
        let scenes = || told.iter().flat_map(|told| &told.scenes.scenes);
        let bar = room.min(230.0);
        let last = told.iter().map(|told| told.scenes.scenes.len()).max().unwrap_or(1) - 1;
        let letters = ["(a)", "(a), (b)", "(a) to (c)"];
        let columns = scenes().filter(|scene| scene.since == Since::Origin).count().div_ceil(told.len());
        if columns > 0 {
            let span = columns as f64 * (room + GAP) - GAP;
            let words = format!("{}: strain since the start, |e\u{2032}|", letters[columns.min(3) - 1]);
            colour_bar(svg, [MARGIN_LEFT + 0.5 * (span - bar), top + 10.0], bar, self.origin, &words);
        }
        let from = scenes().find_map(|scene| if let Since::Frame(strain) = scene.since { Some(strain) } else { None });
        if let Some(from) = from {
            let left = MARGIN_LEFT + last as f64 * (room + GAP) + 0.5 * (room - bar);
            let letter = ["(a)", "(b)", "(c)"][last.min(2)];
            let words = format!("{letter}: strain since {}, |e\u{2032}|", percent(from));
            colour_bar(svg, [left.min(width - bar - 20.0), top + 10.0], bar, self.frame, &words);
        }
        let mut x = MARGIN_LEFT;
        let y = top + 82.0;
        let letters = Letters::new(12.0, Anchor::Start);
        let has = |test: &dyn Fn(&Valued) -> bool| scenes().any(|scene| scene.bodies.iter().any(test));
        if has(&|row| row.body.weight < 1.0) {
            svg.line([x, y - 4.0], [x + 24.0, y - 4.0], Stroke::new(RIM, 1.6));
            svg.text([x + 30.0, y], "rim: grains and points share the mass", letters);
            x += 270.0;
        }
        if told.iter().any(|told| told.scenes.band.is_some()) {
            svg.line([x, y - 4.0], [x + 24.0, y - 4.0], Stroke::new("#000000", 1.4).dash("5 4"));
            svg.text([x + 30.0, y], "band: 98th percentile", letters);
            x += 190.0;
        }
        svg.rectangle(Frame { left: x, top: y - 10.0, width: 12.0, height: 12.0 }, colour::PLATE);
        svg.text([x + 18.0, y], "plate", letters);
        x += 75.0;
        if has(&|row| row.value.is_nan() && row.body.kind != Kind::Glued) {
            svg.rectangle(Frame { left: x, top: y - 10.0, width: 12.0, height: 12.0 }, colour::UNKNOWN);
            svg.text([x + 18.0, y], "strain not known", letters);
        }
    }
}

/// The value that few bodies beside the plates exceed: where colours end. Zero where none has a value.
pub fn nearly_largest(bodies: &[Valued]) -> f64 {
    let mut values: Vec<f64> = free(bodies).map(|row| row.value).filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let beyond = (values.len() as f64 * BEYOND) as usize;
    values.len().checked_sub(1 + beyond).map_or(0.0, |index| values[index])
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten.
pub fn round_up(value: f64) -> f64 {
    if value <= 1e-12 {
        return 1e-3;
    }
    let decade = power_of_ten(exponent(value));
    let factor = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0].into_iter().find(|factor| factor * decade >= value);
    factor.unwrap_or(10.0) * decade
}

pub fn colour_bar(svg: &mut Svg, place: [f64; 2], width: f64, upper: f64, words: &str) {
    colour_bar_between(svg, place, width, [0.0, upper], words);
}

/// The same from a lower end on that is not zero.
pub fn colour_bar_between(svg: &mut Svg, place: [f64; 2], width: f64, [lower, upper]: [f64; 2], words: &str) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_end_at_a_round_strain() {
        for (value, round) in [(0.0, 1e-3), (0.13, 0.15), (0.2, 0.2), (0.21, 0.3), (9.0, 10.0), (0.0017, 0.002)] {
            assert!((round_up(value) - round).abs() < 1e-12, "{value}: {}", round_up(value));
        }
    }
}
