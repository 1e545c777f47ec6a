//! Curves over axes.

use super::WIDTH;
use super::numbers::{exponent, power_label, power_of_ten};
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, number};
use crate::base::math;

/// Room left of a chart's frame for its labels, pixels.
pub const MARGIN_LEFT: f64 = 62.0;

const TICK_LETTERS: f64 = 11.5;
const LABEL_LETTERS: f64 = 13.0;

/// How values are laid out along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    #[default]
    Linear,
    /// By powers of ten; values that are not positive have no place.
    Logarithmic,
}

/// An axis: a name with its unit, and the range of values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    pub label: String,
    pub lower: f64,
    pub upper: f64,
    pub scale: Scale,
}

impl Axis {
    /// From `lower` to `upper`, as they are.
    pub fn exact(label: &str, lower: f64, upper: f64) -> Self {
        let upper = if upper > lower { upper } else { lower + 1.0 };
        Self { label: label.to_owned(), lower, upper, scale: Scale::Linear }
    }

    /// Wide enough for all `values`, ends rounded outwards to a tick.
    pub fn around(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (lower, upper) = range(values);
        let spread = if upper > lower { upper - lower } else { upper.abs().max(1.0) * 0.1 };
        let step = tick_step(spread, 5);
        let lower = (lower / step).floor() * step;
        let upper = (upper / step).ceil() * step;
        Self::exact(label, lower, upper)
    }

    /// Powers of ten around all positive `values`, at most `decades` of them below the largest.
    pub fn decades(label: &str, values: impl Iterator<Item = f64>, decades: i32) -> Self {
        let (lower, upper) = range(values.filter(|&value| value > 0.0));
        let (lower, upper) = if upper > 0.0 && upper.is_finite() { (lower, upper) } else { (1.0, 10.0) };
        let top = exponent(upper) + 1;
        let bottom = exponent(lower).max(top - decades);
        Self {
            label: label.to_owned(),
            lower: power_of_ten(bottom),
            upper: power_of_ten(top.max(bottom + 1)),
            scale: Scale::Logarithmic,
        }
    }

    /// Share of the way from the lower end to the upper one; not a number where the value has no place.
    fn share(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.lower) / (self.upper - self.lower),
            Scale::Logarithmic if value > 0.0 => math::ln(value / self.lower) / math::ln(self.upper / self.lower),
            Scale::Logarithmic => f64::NAN,
        }
    }

    /// Values that get a number, and the numbers.
    fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => linear_ticks(self.lower, self.upper, count),
            Scale::Logarithmic => {
                let (first, last) = (exponent(self.lower), exponent(self.upper));
                let stride = ((last - first) as usize).div_ceil(count.max(1)).max(1);
                (first..=last).step_by(stride).map(|power| (power_of_ten(power), power_label(power))).collect()
            }
        }
    }
}

/// A curve through `places` (in units of the axes).
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    pub places: Vec<[f64; 2]>,
    pub stroke: Stroke<'a>,
}

/// A vertical line at a value of x, with a few words that may be none.
#[derive(Clone, Debug)]
pub struct Moment<'a> {
    pub at: f64,
    pub words: String,
    pub stroke: Stroke<'a>,
}

/// A horizontal line at a value of y; a legend tells what it is.
#[derive(Clone, Debug)]
pub struct Level<'a> {
    pub at: f64,
    pub stroke: Stroke<'a>,
}

/// What lies between two curves (in units of the axes), filled faintly.
#[derive(Clone, Debug)]
pub struct Area<'a> {
    pub lower: Vec<[f64; 2]>,
    pub upper: Vec<[f64; 2]>,
    pub colour: &'a str,
}

/// Curves over two axes.
#[derive(Clone, Debug, Default)]
pub struct Chart<'a> {
    /// Stands above the frame; may be empty.
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve<'a>>,
    pub moments: Vec<Moment<'a>>,
    pub levels: Vec<Level<'a>>,
    pub areas: Vec<Area<'a>>,
    /// Stand above the frame, below the title.
    pub entries: Vec<Entry<'a>>,
}

impl Chart<'_> {
    /// Draws the chart; `frame` is the rectangle of the axes, labels go outside of it.
    pub fn draw(&self, svg: &mut Svg, frame: Frame) {
        let place = |x: f64, y: f64| {
            [frame.left + self.x.share(x) * frame.width, frame.bottom() - self.y.share(y) * frame.height]
        };
        let x_ticks = self.x.ticks((frame.width / 70.0) as usize);
        let y_ticks = self.y.ticks((frame.height / 40.0) as usize);
        for (value, _) in &x_ticks {
            let x = place(*value, self.y.lower)[0];
            svg.line([x, frame.top], [x, frame.bottom()], Stroke::new("#efefef", 1.0));
        }
        for (value, _) in &y_ticks {
            let y = place(self.x.lower, *value)[1];
            svg.line([frame.left, y], [frame.right(), y], Stroke::new("#efefef", 1.0));
        }

        svg.clipped(frame, |svg| {
            for area in &self.areas {
                let around = area.lower.iter().chain(area.upper.iter().rev());
                let path = around.map(|[x, y]| pair(place(*x, *y))).collect::<Vec<_>>().join("L");
                let colour = area.colour;
                svg.raw(&format!("<path d=\"M{path}Z\" fill=\"{colour}\" fill-opacity=\"0.18\"/>\n"));
            }
            for level in &self.levels {
                let y = place(self.x.lower, level.at)[1];
                svg.line([frame.left, y], [frame.right(), y], level.stroke);
            }
            for moment in &self.moments {
                let x = place(moment.at, self.y.lower)[0];
                svg.line([x, frame.top], [x, frame.bottom()], moment.stroke);
            }
            for curve in &self.curves {
                let places: Vec<[f64; 2]> = curve.places.iter().map(|&[x, y]| place(x, y)).collect();
                svg.curve(&thinned(&places), curve.stroke);
            }
        });
        // Words last, on a white edge, so that no line crosses them.
        for moment in self.moments.iter().filter(|moment| !moment.words.is_empty()) {
            let x = place(moment.at, self.y.lower)[0];
            let room_right = frame.right() - x;
            let (anchor, dx) = if room_right > 110.0 { (Anchor::Start, 5.0) } else { (Anchor::End, -5.0) };
            let letters = Letters::new(TICK_LETTERS, anchor).colour(moment.stroke.colour);
            haloed(svg, [x + dx, frame.top + 15.0], &moment.words, letters);
        }

        svg.outline(frame, Stroke::new(INK, 1.0));
        for (value, words) in &x_ticks {
            let x = place(*value, self.y.lower)[0];
            svg.line([x, frame.bottom()], [x, frame.bottom() + 5.0], Stroke::new(INK, 1.0));
            svg.text([x, frame.bottom() + 18.0], words, Letters::new(TICK_LETTERS, Anchor::Middle));
        }
        for (value, words) in &y_ticks {
            let y = place(self.x.lower, *value)[1];
            svg.line([frame.left - 5.0, y], [frame.left, y], Stroke::new(INK, 1.0));
            svg.text([frame.left - 8.0, y + 4.0], words, Letters::new(TICK_LETTERS, Anchor::End));
        }
        let middle = [frame.left + 0.5 * frame.width, frame.top + 0.5 * frame.height];
        let letters = Letters::new(LABEL_LETTERS, Anchor::Middle);
        svg.text([middle[0], frame.bottom() + 37.0], &self.x.label, letters);
        svg.text([frame.left - 46.0, middle[1]], &self.y.label, letters.upright());
        if !self.title.is_empty() {
            let letters = Letters::new(LABEL_LETTERS, Anchor::Start).bold();
            svg.text([frame.left, frame.top - 9.0], &self.title, letters);
        }
    }
}

/// One line of a legend.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    pub words: String,
    pub stroke: Stroke<'a>,
}

/// A legend in one or more rows from `place` on, at most `width` pixels wide; returns its height.
pub fn legend(svg: &mut Svg, place: [f64; 2], width: f64, entries: &[Entry]) -> f64 {
    const ROW: f64 = 19.0;
    let (mut x, mut y) = (place[0], place[1]);
    for entry in entries {
        let needed = 34.0 + text_width(&entry.words, 12.0) + 22.0;
        if x > place[0] && x + needed > place[0] + width {
            x = place[0];
            y += ROW;
        }
        svg.line([x, y - 4.0], [x + 26.0, y - 4.0], entry.stroke);
        svg.text([x + 33.0, y], &entry.words, Letters::new(12.0, Anchor::Start));
        x += needed;
    }
    y - place[1] + ROW
}

/// Text over a white edge.
pub fn haloed(svg: &mut Svg, place: [f64; 2], words: &str, letters: Letters) {
    svg.raw(r##"<g stroke="#ffffff" stroke-width="4" stroke-linejoin="round" paint-order="stroke">"##);
    svg.text(place, words, letters);
    svg.raw("</g>\n");
}

/// Width of a text in pixels, roughly; a sans-serif letter is about half its size wide.
pub fn text_width(words: &str, size: f64) -> f64 {
    words.chars().count() as f64 * size * 0.5
}

/// Smallest and largest of the finite values; zero and one if there are none.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (lower, upper) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lower, upper), value| (lower.min(value), upper.max(value)));
    if lower <= upper { (lower, upper) } else { (0.0, 1.0) }
}

/// A round distance (1, 2 or 5 times a power of ten) that cuts `spread` into at most `count` pieces.
pub fn tick_step(spread: f64, count: usize) -> f64 {
    let least = spread / count.max(1) as f64;
    let decade = power_of_ten(exponent(least));
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| factor * decade >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * decade
}

/// Round values from `lower` to `upper` and their numbers, all with the same count of decimals.
pub fn linear_ticks(lower: f64, upper: f64, count: usize) -> Vec<(f64, String)> {
    let step = tick_step(upper - lower, count.max(2));
    let decimals = usize::try_from(-exponent(step)).unwrap_or(0);
    let first = (lower / step - 1e-6).ceil() as i64;
    let last = (upper / step + 1e-6).floor() as i64;
    (first..=last)
        .map(|index| {
            let value = index as f64 * step;
            let words = format!("{value:.decimals$}");
            (value, if words.starts_with('-') { words.replacen('-', "\u{2212}", 1) } else { words })
        })
        .collect()
}

/// Fewer places where many share a column of pixels: the lowest and the highest of each column stay, in their order.
fn thinned(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const KEEP_ALL: usize = 3000;
    if places.len() <= KEEP_ALL {
        return places.to_vec();
    }
    let mut thin = Vec::new();
    let mut start = 0;
    while start < places.len() {
        let column = places[start][0].floor();
        let length = places[start..].iter().take_while(|place| place[0].floor() == column).count().max(1);
        let group = &places[start..start + length];
        let extreme = |better: fn(f64, f64) -> bool| {
            (0..length).reduce(|best, index| if better(group[index][1], group[best][1]) { index } else { best })
        };
        let mut kept = [extreme(|a, b| a < b), extreme(|a, b| a > b)].map(|index| index.unwrap_or(0));
        kept.sort_unstable();
        thin.push(group[kept[0]]);
        if kept[1] != kept[0] {
            thin.push(group[kept[1]]);
        }
        start += length;
    }
    thin
}

/// Height of the axes of a chart, room below them, and between legend and axes for a title, pixels.
const HEIGHT: f64 = 250.0;
const FOOT: f64 = 50.0;
const TITLE: f64 = 28.0;
const GAP_RIGHT: f64 = 16.0;
const TOP: f64 = 18.0;

/// Charts in rows of so many, each with its legend, below a legend of all of them.
pub fn draw(name: &str, description: &str, shared: &[Entry], charts: &[Chart], columns: usize) -> String {
    let cell = WIDTH / columns.max(1) as f64;
    // The legend decides the height: draw it once to know.
    let height = |width: f64, entries: &[Entry]| match entries {
        [] => 0.0,
        entries => legend(&mut Svg::new(name, width, 0.0), [0.0, 0.0], width, entries),
    };
    let across = cell - MARGIN_LEFT - GAP_RIGHT;
    let rows: Vec<&[Chart]> = charts.chunks(columns.max(1)).collect();
    let legends = |row: &[Chart]| row.iter().map(|chart| height(across, &chart.entries)).fold(0.0, f64::max);
    let head = height(WIDTH - MARGIN_LEFT - GAP_RIGHT, shared);
    let total = rows.iter().map(|row| legends(row) + TITLE + HEIGHT + FOOT).sum::<f64>();
    let mut svg = Svg::new(name, WIDTH, TOP + head + total);
    legend(&mut svg, [MARGIN_LEFT, TOP], WIDTH - MARGIN_LEFT - GAP_RIGHT, shared);
    let mut top = if head > 0.0 { head } else { 0.0 } + 4.0;
    for row in rows {
        let room = legends(row);
        for (column, chart) in row.iter().enumerate() {
            let left = column as f64 * cell + MARGIN_LEFT;
            legend(&mut svg, [left, top + TOP - 4.0], across, &chart.entries);
            chart.draw(&mut svg, Frame { left, top: top + room + TITLE, width: across, height: HEIGHT });
        }
        top += room + TITLE + HEIGHT + FOOT;
    }
    svg.finish(description)
}

/// Of the frame of a chart among so many side by side.
pub fn height_over_width(columns: usize) -> f64 {
    HEIGHT / (WIDTH / columns as f64 - MARGIN_LEFT - GAP_RIGHT)
}

/// A place as `x y`, for paths.
pub fn pair(place: [f64; 2]) -> String {
    format!("{} {}", number(place[0]), number(place[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let ticks =
            |lower, upper| linear_ticks(lower, upper, 5).into_iter().map(|(_, words)| words).collect::<Vec<_>>();
        assert_eq!(ticks(0.0, 10.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(ticks(-0.2, 0.3), ["\u{2212}0.2", "\u{2212}0.1", "0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(ticks(0.0, 160.0), ["0", "50", "100", "150"]);
    }

    #[test]
    fn an_axis_holds_its_values() {
        let axis = Axis::around("y", [3.1, 17.2, f64::NAN].into_iter());
        assert_eq!((axis.lower, axis.upper), (0.0, 20.0));
        let flat = Axis::around("y", [5.0, 5.0].into_iter());
        assert!(flat.lower <= 5.0 && flat.upper >= 5.0 && flat.upper > flat.lower);
        let none = Axis::around("y", std::iter::empty());
        assert!(none.upper > none.lower);
    }

    #[test]
    fn decades_leave_out_what_is_not_positive() {
        let axis = Axis::decades("E", [0.0, 3e-9, 2e-4].into_iter(), 12);
        assert_eq!((axis.lower, axis.upper), (1e-9, 1e-3));
        assert!(axis.share(0.0).is_nan());
        assert!((axis.share(1e-6) - 0.5).abs() < 1e-12);
        let cut = Axis::decades("E", [1e-30, 2.0].into_iter(), 6);
        assert_eq!((cut.lower, cut.upper), (1e-5, 10.0));
    }

    #[test]
    fn thinning_keeps_the_extremes() {
        let mut places: Vec<[f64; 2]> = (0..20_000).map(|index| [f64::from(index) * 0.01, 5.0]).collect();
        places[7_001][1] = -40.0;
        places[12_345][1] = 90.0;
        let thin = thinned(&places);
        assert!(thin.len() <= 500);
        assert!(thin.iter().any(|place| place[1] == -40.0) && thin.iter().any(|place| place[1] == 90.0));
    }
}
