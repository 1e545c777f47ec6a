//! Mohr's circles of element tests, and the friction angle that they tell (Liang & Zhao 2019, figure 12).

use super::chart::{self, Axis, Chart, Curve, Entry};
use super::colour;
use super::numbers::significant;
use super::svg::{INK, Stroke};
use crate::analysis::calibrate::element::{Course, Row};
use crate::analysis::calibrate::fit::sine;
use crate::analysis::calibrate::mobilised::{SHARE_CRITICAL, STRAIN_SMOOTH, Shown, averaged};
use crate::base::math::{self, PI};

/// Pieces of half a circle.
const PIECES: u32 = 90;

/// Of stresses in a plane, Pa, compression positive.
#[derive(Clone, Debug, PartialEq)]
struct Circle {
    words: String,
    middle: f64,
    radius: f64,
}

/// `tau = (sigma + attraction) tan(phi)`, which touches all circles as nearly as it can.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Envelope {
    sine: f64,
    /// Pa.
    attraction: f64,
}

impl Circle {
    fn of(words: String, rows: &[Row]) -> Self {
        let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
        let middle = |row: &Row| -0.5 * (row.stress[0] + row.stress[2]);
        Self { words, middle: mean(&middle), radius: mean(&|row| sine(row) * middle(row)) }
    }

    fn curve<'a>(&self, index: usize) -> Curve<'a> {
        let place = |piece: u32| {
            let angle = PI * f64::from(piece) / f64::from(PIECES);
            let (across, along) = (math::sin(angle), math::cos(angle));
            [1e-3 * (self.middle - self.radius * along), 1e-3 * self.radius * across]
        };
        Curve { places: (0..=PIECES).map(place).collect(), stroke: Stroke::new(colour::line(index), 1.6) }
    }
}

impl Envelope {
    /// By least squares of radius on middle; through the origin where grains do not cohere.
    fn of(circles: &[Circle], coheres: bool) -> Self {
        let sum = |of: &dyn Fn(&Circle) -> f64| circles.iter().map(of).sum::<f64>();
        let count = circles.len() as f64;
        let [middle, radius] = if coheres {
            [sum(&|circle| circle.middle) / count, sum(&|circle| circle.radius) / count]
        } else {
            [0.0; 2]
        };
        let product = sum(&|circle| (circle.middle - middle) * (circle.radius - radius));
        let sine = product / sum(&|circle| (circle.middle - middle) * (circle.middle - middle));
        // Of a few circles that scatter.
        let sine = sine.clamp(1e-6, 1.0 - 1e-6);
        Self { sine, attraction: radius / sine - middle }
    }

    fn degrees(&self) -> f64 {
        math::atan(self.tangent()) * 180.0 / PI
    }

    fn tangent(&self) -> f64 {
        self.sine / (1.0 - self.sine * self.sine).sqrt()
    }
}

/// The drawing and its caption: dense tests under three stresses and biaxial compression where they are strongest, and the ends of loose ones.
pub fn drawing(shown: &[Shown], coheres: bool) -> (String, String) {
    let (mut dense, mut loose) = (Vec::new(), Vec::new());
    for one in shown {
        let rows = &one.curve.rows;
        match one.kind.course {
            Course::Once if one.kind.loose => {
                let last = &rows[((1.0 - SHARE_CRITICAL) * rows.len() as f64) as usize..];
                loose.push(Circle::of(one.kind.words(), last));
            }
            Course::Once | Course::Biaxial => {
                let mobilised = averaged(rows, |index| sine(&rows[index]));
                let strongest = (0..rows.len()).max_by(|a, b| mobilised[*a][1].total_cmp(&mobilised[*b][1]));
                let around = |index: usize| {
                    let near =
                        |row: &&Row| (row.strain - rows[index].strain).abs() <= 0.5 * STRAIN_SMOOTH * (1.0 + 1e-9);
                    rows.iter().filter(near).copied().collect::<Vec<Row>>()
                };
                dense.extend(strongest.map(|index| Circle::of(one.kind.words(), &around(index))));
            }
            Course::Reversal | Course::Cycles | Course::ConstantVolume => {}
        }
    }
    let sets = [("(a)", dense), ("(b)", loose)];
    let envelopes = sets.each_ref().map(|(_, circles)| Envelope::of(circles, coheres));
    let charts: Vec<Chart> =
        sets.iter().zip(&envelopes).map(|((title, circles), envelope)| chart_of(title, circles, envelope)).collect();
    let told = envelopes.map(|envelope| {
        let angle = format!("{}\u{b0}", significant(envelope.degrees(), 3));
        let cohesion = 1e-3 * envelope.attraction * envelope.tangent();
        if coheres { format!("{angle} and a cohesion of {} kPa", significant(cohesion, 3)) } else { angle }
    });
    let caption = format!(
        "Mohr\u{2019}s circles of the means over the packings: (a) dense ones where they have mobilised most, which tell a friction angle of {}; \
         (b) loose ones over the last {} % of their tests, {}.",
        told[0],
        100.0 * SHARE_CRITICAL,
        told[1]
    );
    (chart::draw("mohr", "Mohr's circles", &[], &charts, charts.len()), caption)
}

/// Circles are round: both axes have one scale.
fn chart_of<'a>(title: &str, circles: &[Circle], envelope: &Envelope) -> Chart<'a> {
    let largest = circles.iter().map(|circle| circle.middle + circle.radius).fold(0.0, f64::max);
    let least =
        circles.iter().map(|circle| circle.middle - circle.radius).fold(-envelope.attraction.max(0.0), f64::min);
    let (start, end) = (1e-3 * least, 1e-3 * 1.05 * largest);
    let shear = |normal: f64| (normal + 1e-3 * envelope.attraction) * envelope.tangent();
    let line = Stroke::new(INK, 1.4).dash("6 4");
    let mut curves: Vec<Curve> = circles.iter().enumerate().map(|(index, circle)| circle.curve(index)).collect();
    curves.push(Curve { places: [start, end].map(|normal| [normal, shear(normal)]).to_vec(), stroke: line });
    let entry = |(index, circle): (usize, &Circle)| Entry {
        words: circle.words.clone(),
        stroke: Stroke::new(colour::line(index), 1.6),
    };
    let mut entries: Vec<Entry> = circles.iter().enumerate().map(entry).collect();
    entries.push(Entry { words: format!("{}\u{b0}", significant(envelope.degrees(), 3)), stroke: line });
    Chart {
        title: title.to_string(),
        x: Axis::exact("normal stress (kPa)", start, end),
        y: Axis::exact("shear stress (kPa)", 0.0, (end - start) * chart::height_over_width(2)),
        curves,
        entries,
        ..Chart::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Circles that touch one line give it back, and a state of stress its circle.
    #[test]
    fn circles_tell_the_line_that_they_touch() {
        let sine = math::sin(0.4);
        let touching = |attraction: f64| {
            let circle = |middle: f64| Circle { words: String::new(), middle, radius: sine * (middle + attraction) };
            [1e5, 2e5, 4e5].map(circle)
        };
        for (attraction, coheres) in [(0.0, false), (0.0, true), (3e4, true)] {
            let found = Envelope::of(&touching(attraction), coheres);
            assert!((found.sine - sine).abs() < 1e-12 && (found.attraction - attraction).abs() < 1e-6, "{found:?}");
            assert!((found.degrees() - 0.4 * 180.0 / PI).abs() < 1e-9);
        }
        let row = Row { strain: 0.0, stress: [-3e5, 4e4, -1e5], pressure: 2e5, fraction: 0.8 };
        let circle = Circle::of(String::new(), &[row]);
        assert!((circle.middle - 2e5).abs() < 1e-9 && (circle.radius - 1.16e10_f64.sqrt()).abs() < 1e-6);
        assert!(
            circle
                .curve(0)
                .places
                .iter()
                .all(|[x, y]| (((x - 200.0) * (x - 200.0) + y * y).sqrt() - 1e-3 * circle.radius).abs() < 1e-9)
        );
    }
}
