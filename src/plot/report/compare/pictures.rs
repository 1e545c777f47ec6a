//! Specimens side by side, on one scale of length and of colour.

use crate::analysis::band::Band;
use crate::plot::report::WIDTH;
use crate::plot::report::chart::text_width;
use crate::plot::report::panels::{Panel, colour_bar};
use crate::plot::report::scenes::{Valued, heights};
use crate::plot::report::span::Span;
use crate::plot::report::svg::{Frame, Svg};

const MARGIN: f64 = 22.0;
/// Room beside a picture for the measure of its band.
const BESIDE: f64 = 74.0;
const TITLES: f64 = 46.0;
const HEIGHT_MAX: f64 = 420.0;
const COLUMNS_MAX: usize = 5;
/// Size of the larger letters of a title, pixels, with a little room: bold ones are wider.
const LETTERS: f64 = 13.5;
/// Below a row of pictures: the length to compare with.
const BELOW: f64 = 30.0;
const COLOURS: f64 = 66.0;

/// A specimen, coloured.
pub struct Picture {
    pub span: Span,
    pub titles: [String; 2],
    pub bodies: Vec<Valued>,
    pub band: Option<Band>,
}

/// What colours say: the value at their end, and words with its unit.
pub struct Colours<'a> {
    pub upper: f64,
    /// From the values' unit to that of the words.
    pub unit: f64,
    pub words: &'a str,
}

/// Draws pictures in rows, colours below.
pub fn draw(name: &str, pictures: &[Picture], colours: &Colours, description: &str) -> String {
    let widest = pictures.iter().flat_map(|picture| &picture.titles).map(|title| text_width(title, LETTERS));
    let fit = ((WIDTH - MARGIN) / (widest.fold(0.0, f64::max) + 12.0)) as usize;
    let columns = pictures.len().min(fit).clamp(1, COLUMNS_MAX);
    // Rows of one length: what fits into fewer columns is drawn larger.
    let columns = pictures.len().max(1).div_ceil(pictures.len().max(1).div_ceil(columns));
    let room = (WIDTH - MARGIN) / columns as f64 - BESIDE;
    // One scale and one height for all, so that sizes and places compare.
    let extents = pictures.iter().map(|picture| heights(&picture.bodies));
    let [lower, upper] = extents.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or([0.0, 1.0]);
    let most = HEIGHT_MAX / (upper - lower);
    let scale = pictures.iter().fold(most, |scale, picture| scale.min(room / picture.span.width));
    let height = (upper - lower) * scale;
    let row = TITLES + height + BELOW;
    let bottom = pictures.len().div_ceil(columns) as f64 * row;
    let mut svg = Svg::new(name, WIDTH, bottom + COLOURS);
    for (index, picture) in pictures.iter().enumerate() {
        let panel = Panel {
            span: picture.span,
            scale,
            bottom: lower,
            frame: Frame {
                left: MARGIN + (index % columns) as f64 * (room + BESIDE),
                top: (index / columns) as f64 * row + TITLES,
                width: picture.span.width * scale,
                height,
            },
        };
        panel.titles(&mut svg, &picture.titles);
        panel.bodies(&mut svg, &picture.bodies, colours.upper);
        if let Some(band) = &picture.band {
            panel.band(&mut svg, band);
        }
        if index == 0 {
            panel.length(&mut svg);
        }
    }
    const BAR: f64 = 230.0;
    colour_bar(&mut svg, [0.5 * (WIDTH - BAR), bottom + 8.0], BAR, colours.upper * colours.unit, colours.words);
    svg.finish(description)
}
