//! The page of `scree bench scaling`: speed-up against ranks, and where the time of a step goes.

use super::chart::{self, Axis, Chart, Curve, Entry, MARGIN_LEFT, legend, linear_ticks};
use super::numbers::significant;
use super::page::{figure, table, whole};
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, escape};
use super::words::Table;
use super::{WIDTH, colour};
use crate::bench::scaling::{Point, Scaling};

/// Room above and below bars, pixels.
const HEAD: f64 = 74.0;
const FOOT: f64 = 52.0;
/// A bar of phases, and the distance of the next, pixels.
const BAR: f64 = 26.0;
const BAR_STEP: f64 = 38.0;
/// A dot on a curve, pixels.
const DOT: f64 = 7.0;
/// Phases with a smaller share of a step go with what is not named.
const SHARE_MIN: f64 = 0.005;

/// The drawings with their names, for files of their own.
pub fn drawings(scaling: &Scaling) -> Vec<(&'static str, String)> {
    let mut drawings = vec![("speed_up", curves(scaling))];
    let has_phases = |points: &[Point]| points.iter().any(|point| !point.median.phases.is_empty());
    if has_phases(&scaling.strong) {
        drawings.push(("phases", bars("phases", &scaling.strong)));
    }
    if has_phases(&scaling.weak) {
        drawings.push(("phases_weak", bars("phases_weak", &scaling.weak)));
    }
    drawings
}

/// The whole page around the drawings.
pub fn page(scaling: &Scaling, drawings: &[(&'static str, String)]) -> String {
    let title = escape(&format!("Scaling of {}", scaling.name));
    let mut body = format!("<h1>{title}</h1>\n<p class=\"lead\">{}</p>\n", escape(&lead(scaling)));
    for (index, (name, drawing)) in drawings.iter().enumerate() {
        figure(&mut body, index + 1, drawing, caption(name));
    }
    table(&mut body, "Strong scaling", &heads(&scaling.strong), &rows(&scaling.strong));
    if !scaling.weak.is_empty() {
        table(&mut body, "Weak scaling", &heads(&scaling.weak), &rows(&scaling.weak));
    }
    whole(&title, &body)
}

fn lead(scaling: &Scaling) -> String {
    let last = scaling.strong.last().expect("at least one number of ranks was measured");
    let mut words = format!(
        "{}, {} grains and points, {} steps{}, ranks of {} {} on a machine of {} cores. {} ranks are {} times as fast as {} \
         (efficiency {}).",
        scaling.job,
        last.median.rows,
        last.median.steps,
        if scaling.from > 0.0 { format!(" from {:.6} s on", scaling.from) } else { String::new() },
        scaling.threads,
        if scaling.threads == 1 { "thread" } else { "threads" },
        scaling.cores,
        last.ranks,
        significant(last.speed_up / scaling.strong[0].speed_up, 3),
        scaling.strong[0].ranks,
        significant(last.efficiency, 3),
    );
    if let Some(widest) = scaling.weak.last() {
        words += &format!(
            " With the job {} times as wide, a step on {} ranks has the efficiency {}.",
            widest.ranks,
            widest.ranks,
            significant(widest.efficiency, 3)
        );
    }
    words + " All runs of a job ended in the same state to the bit."
}

fn caption(name: &str) -> &'static str {
    match name {
        "speed_up" => {
            "(a) Strong scaling: speed-up n t(n)/t(N) with t(N) the wall time of a step on N ranks, output included, \
             median of the runs, and n the fewest ranks measured; faint dots: single runs. (b) Efficiency: of strong \
             scaling the speed-up over N, of weak scaling t(1)/t(N) of a job that is N times as wide. Dashed: ideal."
        }
        "phases_weak" => "The same of the jobs that grow with the ranks.",
        _ => {
            "Where the wall time of a step goes: time in each phase, mean over the ranks. The rest is not in a phase; \
             waiting for other ranks is in the phase that waits."
        }
    }
}

/// Speed-up and efficiency against ranks.
fn curves(scaling: &Scaling) -> String {
    let most = scaling.strong.iter().chain(&scaling.weak).map(|point| point.ranks).max().unwrap_or(1) as f64;
    let (strong, weak) = (colour::line(0), colour::line(1));
    let ideal = Stroke::new(INK, 1.0).dash("5 4");
    let dots = |places: &[[f64; 2]], colour: &'static str, opacity: f64| -> Vec<Curve<'static>> {
        let stroke = Stroke::new(colour, DOT).opacity(opacity);
        places.iter().map(|place| Curve { places: vec![*place], stroke }).collect()
    };
    let line = |points: &[Point], value: fn(&Point) -> f64, colour: &'static str| -> Vec<Curve<'static>> {
        let places: Vec<[f64; 2]> = points.iter().map(|point| [point.ranks as f64, value(point)]).collect();
        let mut drawn = vec![Curve { places: places.clone(), stroke: Stroke::new(colour, 1.6) }];
        drawn.extend(dots(&places, colour, 1.0));
        drawn
    };
    let single: Vec<[f64; 2]> = scaling
        .strong
        .iter()
        .flat_map(|point| {
            point.walls.iter().map(|wall| [point.ranks as f64, point.speed_up * point.median.wall / wall])
        })
        .collect();

    let mut speed_ups = vec![Curve { places: vec![[0.0, 0.0], [2.0 * most, 2.0 * most]], stroke: ideal }];
    speed_ups.extend(dots(&single, strong, 0.25));
    speed_ups.extend(line(&scaling.strong, |point| point.speed_up, strong));
    let highest = single.iter().map(|place| place[1]).fold(most, f64::max);
    let mut efficiencies = vec![Curve { places: vec![[0.0, 1.0], [2.0 * most, 1.0]], stroke: ideal }];
    efficiencies.extend(line(&scaling.strong, |point| point.efficiency, strong));
    efficiencies.extend(line(&scaling.weak, |point| point.efficiency, weak));
    let best = scaling.strong.iter().chain(&scaling.weak).map(|point| point.efficiency).fold(1.0, f64::max);

    let entry =
        |words: &str, colour: &'static str| Entry { words: words.to_string(), stroke: Stroke::new(colour, 1.6) };
    let mut entries = vec![entry("strong scaling", strong)];
    if !scaling.weak.is_empty() {
        entries.push(entry("weak scaling", weak));
    }
    entries.push(Entry { words: "ideal".to_string(), stroke: ideal });
    let chart = |(title, label, upper, curves): (&str, &str, f64, Vec<Curve<'static>>)| Chart {
        title: title.to_string(),
        x: Axis::exact("ranks", 0.0, 1.1 * most),
        y: Axis::exact(label, 0.0, upper),
        curves,
        ..Chart::default()
    };
    let charts =
        [("(a)", "speed-up", 1.1 * highest, speed_ups), ("(b)", "efficiency", 1.1 * best, efficiencies)].map(chart);
    chart::draw("speed_up", "Speed-up and efficiency against ranks", &entries, &charts, 2)
}

/// A stretch of a bar.
struct Piece {
    name: String,
    /// us a step.
    length: f64,
}

/// Phases of a step, and what of its wall time is in none of them.
fn pieces(point: &Point, names: &[String]) -> Vec<Piece> {
    let sample = &point.median;
    let of = |name: &String| {
        let found = sample.phases.iter().find(|phase| phase.name == *name);
        Piece { name: name.clone(), length: found.map_or(0.0, |phase| 1e6 * phase.mean / sample.steps) }
    };
    let mut pieces: Vec<Piece> = names.iter().map(of).collect();
    let named: f64 = pieces.iter().map(|piece| piece.length).sum();
    pieces.push(Piece { name: "rest".to_string(), length: (1e6 * sample.step() - named).max(0.0) });
    pieces
}

/// Where the time of a step goes, a bar for each number of ranks.
fn bars(name: &str, points: &[Point]) -> String {
    let mut names: Vec<String> = Vec::new();
    for point in points {
        let sample = &point.median;
        let large = sample.phases.iter().filter(|phase| phase.mean > SHARE_MIN * sample.wall);
        for phase in large {
            if !names.contains(&phase.name) {
                names.push(phase.name.clone());
            }
        }
    }
    let colours: Vec<String> = (0..names.len())
        .map(|index| colour::map(index * (colour::STEPS - 1) / names.len().max(2).saturating_sub(1).max(1)))
        .collect();
    let colour_of = |index: usize| colours.get(index).map_or(colour::UNKNOWN, String::as_str);
    let rows = points.len() as f64;
    let all: Vec<Vec<Piece>> = points.iter().map(|point| pieces(point, &names)).collect();
    let longest = all.iter().map(|pieces| pieces.iter().map(|piece| piece.length).sum::<f64>()).fold(0.0, f64::max);
    let upper = if longest > 0.0 { 1.05 * longest } else { 1.0 };

    let mut svg = Svg::new(name, WIDTH, HEAD + rows * BAR_STEP + FOOT);
    let frame =
        Frame { left: MARGIN_LEFT + 18.0, top: HEAD, width: WIDTH - MARGIN_LEFT - 40.0, height: rows * BAR_STEP };
    let entries: Vec<Entry> = all[0]
        .iter()
        .enumerate()
        .map(|(index, piece)| Entry { words: piece.name.clone(), stroke: Stroke::new(colour_of(index), 10.0) })
        .collect();
    legend(&mut svg, [frame.left, 18.0], frame.width, &entries);
    let letters = Letters::new(11.5, Anchor::Middle);
    for (value, words) in linear_ticks(0.0, upper, 8) {
        let x = frame.left + frame.width * value / upper;
        svg.line([x, frame.top], [x, frame.bottom()], Stroke::new("#efefef", 1.0));
        svg.line([x, frame.bottom()], [x, frame.bottom() + 5.0], Stroke::new(INK, 1.0));
        svg.text([x, frame.bottom() + 18.0], &words, letters);
    }
    for (row, (point, pieces)) in points.iter().zip(&all).enumerate() {
        let top = frame.top + row as f64 * BAR_STEP + 0.5 * (BAR_STEP - BAR);
        let words = format!("{} {}", point.ranks, if point.ranks == 1 { "rank" } else { "ranks" });
        svg.text([frame.left - 8.0, top + 0.5 * BAR + 4.0], &words, Letters::new(12.0, Anchor::End));
        let mut left = frame.left;
        for (index, piece) in pieces.iter().enumerate() {
            let width = frame.width * piece.length / upper;
            svg.rectangle(Frame { left, top, width, height: BAR }, colour_of(index));
            left += width;
        }
    }
    svg.outline(frame, Stroke::new(INK, 1.0));
    svg.text(
        [frame.left + 0.5 * frame.width, frame.bottom() + 37.0],
        "wall time of a step (\u{b5}s)",
        Letters::new(13.0, Anchor::Middle),
    );
    svg.finish("Wall time of a step by phases")
}

fn heads(points: &[Point]) -> Vec<String> {
    let words = |point: &Point| format!("{} {}", point.ranks, if point.ranks == 1 { "rank" } else { "ranks" });
    points.iter().map(words).collect()
}

/// Figures of each number of ranks, side by side.
fn rows(points: &[Point]) -> Table {
    let row = |name: &str, cell: &dyn Fn(&Point) -> String| (name.to_string(), points.iter().map(cell).collect());
    let figure = |value: Option<f64>| value.map_or("\u{2013}".to_string(), |value| significant(value, 4));
    let mut rows: Vec<(String, Vec<String>)> = vec![
        row("wall time of a step, \u{b5}s", &|point| figure(Some(1e6 * point.median.step()))),
        row("its range over the runs, \u{b5}s", &|point| {
            let [least, most] = point.range().map(|step| significant(1e6 * step, 4));
            format!("{least} to {most}")
        }),
        row("over grains and points, ns", &|point| figure(Some(point.median.nanoseconds_per_row()))),
        row("speed-up", &|point| figure(Some(point.speed_up))),
        row("efficiency", &|point| figure(Some(point.efficiency))),
        row("grains and points", &|point| format!("{:.0}", point.median.rows)),
        row("longest busy time of a rank over the mean", &|point| figure(point.median.imbalance)),
        row("messages a step, all ranks", &|point| figure(point.median.messages_per_step)),
        row("bytes a step, all ranks", &|point| figure(point.median.bytes_per_step)),
        row("times that the load was dealt anew", &|point| figure(point.median.rebalances)),
        row("rows moved then", &|point| figure(point.median.rows_moved)),
        row("digest", &|point| point.median.digest.chars().take(16).collect()),
    ];
    for phase in &points[0].median.phases {
        let of = |point: &Point| point.median.phases.iter().find(|other| other.name == phase.name).cloned();
        if points.iter().all(|point| of(point).is_none_or(|phase| phase.mean == 0.0)) {
            continue;
        }
        rows.push(row(&format!("phase {}, \u{b5}s a step (slowest rank over mean)", phase.name), &|point| {
            of(point).map_or("\u{2013}".to_string(), |phase| {
                let slowest = if phase.mean > 0.0 { phase.most / phase.mean } else { 1.0 };
                format!("{} ({slowest:.2})", significant(1e6 * phase.mean / point.median.steps, 3))
            })
        }));
    }
    Table { rows }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::scaling::examples::sample;
    use crate::bench::scaling::{strong, weak};

    fn scaling() -> Scaling {
        let strong = strong(&[sample(1, 10.0, "abc"), sample(2, 5.5, "abc")]);
        let weak = [strong[..1].to_vec(), weak(&strong[0].median, &[sample(2, 11.0, "def")])].concat();
        Scaling { name: "a <job>".into(), job: "j.toml".into(), threads: 1, cores: 2, from: 0.0, strong, weak }
    }

    #[test]
    fn the_page_has_curves_bars_and_figures() {
        let scaling = scaling();
        let drawings = drawings(&scaling);
        assert_eq!(drawings.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["speed_up", "phases", "phases_weak"]);
        let page = page(&scaling, &drawings);
        for wanted in [
            "Scaling of a &lt;job&gt;",
            "2 ranks are 1.82 times as fast as 1",
            "contacts",
            "halo",
            "rest",
            "ideal",
            "weak scaling",
        ] {
            assert!(page.contains(wanted), "{wanted}");
        }
        // 5.5 s over 1,000 steps, half of it in contacts.
        assert!(page.contains("2750 (1.20)") && page.contains("<td>5500</td>"), "{page}");
        assert!(!page.contains("NaN") && !page.contains("inf"));
    }

    #[test]
    fn a_summary_without_phases_has_no_bars() {
        let mut scaling = scaling();
        scaling.weak.clear();
        scaling.strong.iter_mut().for_each(|point| point.median.phases.clear());
        let drawings = drawings(&scaling);
        assert_eq!(drawings.len(), 1);
        assert!(!page(&scaling, &drawings).contains("<h2>Weak scaling</h2>"));
    }
}
