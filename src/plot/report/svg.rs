//! A drawing in SVG: text stays text, coordinates are rounded to a hundredth of a pixel, and nothing refers outside.

use std::fmt::Write as _;

/// Fonts that every system has one of.
pub const FONT: &str = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";
/// Colour of axes and text.
pub const INK: &str = "#222222";

/// A rectangle of the drawing, pixels, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    pub fn right(&self) -> f64 {
        self.left + self.width
    }
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke<'a> {
    pub colour: &'a str,
    /// Pixels.
    pub width: f64,
    pub opacity: f64,
    /// Lengths of dashes and gaps, pixels; empty for a full line.
    pub dash: &'a str,
}

impl<'a> Stroke<'a> {
    pub fn new(colour: &'a str, width: f64) -> Self {
        Self { colour, width, opacity: 1.0, dash: "" }
    }
    pub fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
    pub fn dash(self, dash: &'a str) -> Self {
        Self { dash, ..self }
    }
    fn attributes(&self) -> String {
        let mut text = format!(r#" fill="none" stroke="{}" stroke-width="{}""#, self.colour, number(self.width));
        if self.opacity < 1.0 {
            let _ = write!(text, r#" stroke-opacity="{}""#, number(self.opacity));
        }
        if !self.dash.is_empty() {
            let _ = write!(text, r#" stroke-dasharray="{}""#, self.dash);
        }
        text
    }
}

/// Where a text stands relative to its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Letters<'a> {
    /// Pixels.
    pub size: f64,
    pub anchor: Anchor,
    pub colour: &'a str,
    pub bold: bool,
    /// Reads from bottom to top.
    pub upright: bool,
}

impl<'a> Letters<'a> {
    pub fn new(size: f64, anchor: Anchor) -> Self {
        Self { size, anchor, colour: INK, bold: false, upright: false }
    }
    pub fn colour(self, colour: &'a str) -> Self {
        Self { colour, ..self }
    }
    pub fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
    pub fn upright(self) -> Self {
        Self { upright: true, ..self }
    }
}

/// A drawing under construction.
#[derive(Clone, Debug)]
pub struct Svg {
    /// Makes ids unique in a page that holds several drawings.
    name: String,
    width: f64,
    height: f64,
    body: String,
    clips: usize,
}

impl Svg {
    pub fn new(name: &str, width: f64, height: f64) -> Self {
        Self { name: name.to_owned(), width, height, body: String::new(), clips: 0 }
    }

    /// Elements as they are.
    pub fn raw(&mut self, elements: &str) {
        self.body.push_str(elements);
    }

    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        let _ = writeln!(
            self.body,
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}"{}/>"#,
            number(from[0]),
            number(from[1]),
            number(to[0]),
            number(to[1]),
            stroke.attributes()
        );
    }

    /// A line through the places, interrupted where one is not a number.
    pub fn curve(&mut self, places: &[[f64; 2]], stroke: Stroke) {
        let mut path = String::new();
        for piece in places.split(|place| !(place[0].is_finite() && place[1].is_finite())) {
            for (index, place) in piece.iter().enumerate() {
                path.push(if index == 0 { 'M' } else { 'L' });
                let _ = write!(path, "{} {}", tenth(place[0]), tenth(place[1]));
            }
            if let [lonely] = piece {
                let _ = write!(path, "L{} {}", tenth(lonely[0] + 0.1), tenth(lonely[1]));
            }
        }
        self.path(&path, stroke);
    }

    /// A line by SVG path commands.
    pub fn path(&mut self, commands: &str, stroke: Stroke) {
        if !commands.is_empty() {
            let _ = writeln!(
                self.body,
                r#"<path d="{commands}" stroke-linejoin="round" stroke-linecap="round"{}/>"#,
                stroke.attributes()
            );
        }
    }

    pub fn rectangle(&mut self, frame: Frame, fill: &str) {
        let _ = writeln!(
            self.body,
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{fill}"/>"#,
            number(frame.left),
            number(frame.top),
            number(frame.width),
            number(frame.height),
        );
    }

    pub fn outline(&mut self, frame: Frame, stroke: Stroke) {
        let _ = writeln!(
            self.body,
            r#"<rect x="{}" y="{}" width="{}" height="{}"{}/>"#,
            number(frame.left),
            number(frame.top),
            number(frame.width),
            number(frame.height),
            stroke.attributes()
        );
    }

    pub fn text(&mut self, place: [f64; 2], text: &str, letters: Letters) {
        let anchor = match letters.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = (number(place[0]), number(place[1]));
        let weight = if letters.bold { r#" font-weight="bold""# } else { "" };
        let turn = if letters.upright { format!(r#" transform="rotate(-90 {x} {y})""#) } else { String::new() };
        let _ = writeln!(
            self.body,
            r#"<text x="{x}" y="{y}" font-size="{}" text-anchor="{anchor}" fill="{}"{weight}{turn}>{}</text>"#,
            number(letters.size),
            letters.colour,
            escape(text)
        );
    }

    /// What `draw` adds shows only inside `frame`.
    pub fn clipped(&mut self, frame: Frame, draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let id = format!("{}-clip-{}", self.name, self.clips);
        let _ = writeln!(
            self.body,
            r#"<clipPath id="{id}"><rect x="{}" y="{}" width="{}" height="{}"/></clipPath><g clip-path="url(#{id})">"#,
            number(frame.left),
            number(frame.top),
            number(frame.width),
            number(frame.height),
        );
        draw(self);
        self.body.push_str("</g>\n");
    }

    /// The finished drawing, fit for a page and for a file of its own.
    pub fn finish(&self, description: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             role=\"img\" font-family=\"{FONT}\">\n<title>{}</title>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            escape(description),
            self.body,
            w = number(self.width),
            h = number(self.height),
        )
    }
}

/// A coordinate with two decimals at most.
pub fn number(value: f64) -> String {
    shortened(format!("{value:.2}"))
}

/// A coordinate with one decimal at most.
pub fn tenth(value: f64) -> String {
    shortened(format!("{value:.1}"))
}

/// Without trailing zeros, without a negative zero.
pub fn shortened(mut text: String) -> String {
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" { "0".to_owned() } else { text }
}

/// Text that is safe between tags and inside quotes.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            _ => safe.push(letter),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        assert_eq!(number(3.0), "3");
        assert_eq!(number(120.0), "120");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(2.346), "2.35");
        assert_eq!(tenth(2.346), "2.3");
    }

    #[test]
    fn a_curve_breaks_where_a_place_is_missing() {
        let mut svg = Svg::new("t", 10.0, 10.0);
        svg.curve(&[[0.0, 0.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 3.0], [4.0, 4.0]], Stroke::new(INK, 1.0));
        assert!(svg.finish("").contains(r#"d="M0 0L1 1M3 3L4 4""#));
    }

    #[test]
    fn names_cannot_break_out_of_the_markup() {
        assert_eq!(escape("<a & 'b'>"), "&lt;a &amp; &#39;b&#39;&gt;");
        let mut svg = Svg::new("t", 10.0, 10.0);
        svg.text([0.0, 0.0], "</text><script>", Letters::new(10.0, Anchor::Start));
        assert!(!svg.finish("x").contains("<script>"));
    }
}
