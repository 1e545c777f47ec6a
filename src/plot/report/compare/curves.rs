//! Shear stress over horizontal strain (Chen et al. 2021, figures 10 and 12): moving averages, how far they are from those of
//! grains alone, and the mean of several packings.

use serde_json::json;

use super::among::{Among, Group, Member};
use super::difference::{self, Compared, Difference, Kind};
use super::{Drawn, Part, range};
use crate::plot::report::WIDTH;
use crate::plot::report::chart::{Axis, Chart, Curve, Entry, percent, side_by_side};
use crate::plot::report::figures::{HEIGHT, SHEAR_LABEL, STRAIN_LABEL, places, start};
use crate::plot::report::findings::{WINDOW, mean, smooth};
use crate::plot::report::load::linear;
use crate::plot::report::words::{THIN, plain};

/// Moving average of shear stress against strain.
#[derive(Clone, Debug, PartialEq)]
pub struct Averaged {
    pub strain: Vec<f64>,
    /// Pa.
    pub stress: Vec<f64>,
    /// First row after the enrichment, which the average does not look across.
    pub cut: Option<usize>,
}

impl Averaged {
    /// Over so many rows, which do not reach across the row `cut`.
    pub fn of(strain: &[f64], stress: &[f64], cut: Option<usize>, rows: usize) -> Self {
        Self { strain: strain.to_vec(), stress: smooth(stress, cut, rows), cut }
    }

    /// Linear between rows; none beyond them.
    pub fn at(&self, strain: f64) -> Option<f64> {
        linear(&self.strain, &self.stress, strain)
    }

    /// Places in percent and kPa, in two pieces that do not touch at the enrichment.
    pub fn places(&self) -> Vec<[f64; 2]> {
        places(&self.strain, &self.stress, 1e3, self.cut)
    }
}

/// Moving averages of all runs over the same time: [`WINDOW`] rows of the run whose rows are farthest apart.
pub struct Averages {
    /// s.
    pub window: f64,
    pub of: Vec<Averaged>,
}

impl Averages {
    pub fn of(among: &Among) -> Self {
        let times: Vec<&[f64]> = among.members.iter().map(|member| member.run.series.time.as_slice()).collect();
        let (window, rows) = windows(&times);
        let averaged = |(member, rows): (&Member, usize)| {
            let series = &member.run.series;
            Averaged::of(&series.strain, &series.shear_stress, member.cut(), rows)
        };
        Self { window, of: among.members.iter().zip(rows).map(averaged).collect() }
    }
}

/// The time of [`WINDOW`] rows where rows are farthest apart, s, and how many rows it has in each run; of their rows' times.
pub fn windows(times: &[&[f64]]) -> (f64, Vec<usize>) {
    let interval = |time: &&[f64]| (time[time.len() - 1] - time[0]) / (time.len() - 1).max(1) as f64;
    let longest = times.iter().map(interval).fold(0.0, f64::max);
    let rows = |time: &&[f64]| match interval(time) {
        own if own > 0.0 => ((WINDOW as f64 * longest / own).round() as usize).max(1),
        _ => WINDOW,
    };
    (WINDOW as f64 * longest, times.iter().map(rows).collect())
}

/// Mean, least and most of several curves, at the strains of the first as far as all of them reach.
pub struct Spread {
    pub mean: Averaged,
    least: Vec<[f64; 2]>,
    most: Vec<[f64; 2]>,
}

pub fn spread(curves: &[&Averaged]) -> Spread {
    let first = curves[0];
    let mut spread =
        Spread { mean: Averaged { strain: Vec::new(), stress: Vec::new(), cut: None }, least: vec![], most: vec![] };
    for &strain in &first.strain {
        let values: Vec<f64> = curves.iter().filter_map(|curve| curve.at(strain)).collect();
        if values.len() < curves.len() {
            continue;
        }
        spread.mean.strain.push(strain);
        spread.mean.stress.push(mean(&values));
        let place = |stress: f64| [100.0 * strain, 1e-3 * stress];
        let [least, most] = range(values.iter().copied()).unwrap_or_default();
        spread.least.push(place(least));
        spread.most.push(place(most));
    }
    spread
}

/// A run with its curve and what decides what that is compared with.
pub struct Entrant<'a> {
    pub label: &'a str,
    pub curve: &'a Averaged,
    pub is_dem: bool,
    pub seed: Option<i64>,
    /// Entrants of the same number are of the same specimen and test.
    pub case: usize,
    /// The grains alone that it is held against.
    pub partner: Option<usize>,
    /// The strains that it is compared between.
    pub between: [f64; 2],
}

/// Each hybrid and continuum against the grains of its packing, the means of several packings, and the packings of grains
/// alone against each other.
pub fn compared(entrants: &[Entrant], groups: &[Group]) -> Vec<Compared> {
    let mut all = Vec::new();
    let mut add = |names: [&str; 2], kind: Kind, curves: [&Averaged; 2], between: [f64; 2]| {
        if let Some(difference) = Difference::of(curves[0], curves[1], between) {
            all.push(Compared { names: names.map(str::to_owned), kind, difference });
        }
    };
    for one in entrants.iter().filter(|one| !one.is_dem) {
        if let Some(partner) = one.partner.map(|partner| &entrants[partner]) {
            let kind = if one.seed == partner.seed { Kind::Packing } else { Kind::Other };
            add([one.label, partner.label], kind, [one.curve, partner.curve], one.between);
        }
    }
    for group in groups {
        let of_group = |group: &Group| group.members.iter().map(|&index| &entrants[index]).collect::<Vec<_>>();
        let members = of_group(group);
        let case = members[0].case;
        let other = groups.iter().find(|other| of_group(other).iter().all(|dem| dem.is_dem && dem.case == case));
        let several = |group: &Group| group.members.len() > 1;
        if let Some(other) = other.filter(|other| !members[0].is_dem && several(group) && several(other)) {
            let mean = |group| spread(&of_group(group).iter().map(|one| one.curve).collect::<Vec<_>>()).mean;
            let between = members.iter().map(|one| one.between);
            let between = between.reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])]).unwrap_or_default();
            let names = [group, other].map(|group| format!("{}, mean of {}", group.name, group.members.len()));
            add([&names[0], &names[1]], Kind::Means, [&mean(group), &mean(other)], between);
        }
    }
    let grains: Vec<&Entrant> = entrants.iter().filter(|one| one.is_dem).collect();
    for (index, one) in grains.iter().enumerate() {
        for other in grains[index + 1..].iter().filter(|other| other.case == one.case && other.seed != one.seed) {
            add([one.label, other.label], Kind::Spread, [one.curve, other.curve], one.between);
        }
    }
    all
}

fn entrants<'a>(among: &'a Among, averages: &'a Averages) -> Vec<Entrant<'a>> {
    let entrant = |member: &'a Member| Entrant {
        label: &member.label,
        curve: &averages.of[member.index],
        is_dem: member.is("dem"),
        seed: member.seed,
        case: member.case,
        partner: among.partner(member).map(|partner| partner.index),
        between: [among.compared_from(member), f64::INFINITY],
    };
    among.members.iter().map(entrant).collect()
}

pub fn part(among: &Among, averages: &Averages) -> Part {
    let compared = compared(&entrants(among, averages), &among.groups);
    let first = &among.members[0];
    let rate = first.strain_end() / first.run.series.time[first.run.series.rows() - 1];
    let window = format!(
        "{}{THIN}ms, {} of strain at the mean speed of {}",
        plain(1e3 * averages.window, 3),
        percent(averages.window * rate),
        first.label
    );
    let mut left_out = among.without_partner();
    if compared.is_empty() {
        left_out
            .push("No two of these runs of shear stress can be compared over enough rows after enrichment.".to_owned());
    }
    Part {
        sentences: difference::sentences("Shear stress after enrichment", &compared),
        figures: vec![Drawn {
            name: "compare_shear_stress",
            drawing: drawing(among, averages),
            caption: caption(&window),
        }],
        sheets: vec![difference::sheet("Shear stress against that of grains alone", &compared)],
        left_out,
        json: json!({ "window_s": averages.window, "differences": difference::json(&compared) }),
    }
}

fn drawing(among: &Among, averages: &Averages) -> String {
    let mut entries = Vec::new();
    let (mut curves, mut areas) = (Vec::new(), Vec::new());
    for group in &among.groups {
        let stroke = group.stroke(1.8);
        let of_group: Vec<&Averaged> = group.members.iter().map(|&index| &averages.of[index]).collect();
        let mut words = group.name.clone();
        if let [alone] = of_group.as_slice() {
            curves.push(Curve { places: alone.places(), stroke });
        } else {
            let spread = spread(&of_group);
            areas.push((spread.least, spread.most, group.colour));
            curves.push(Curve { places: spread.mean.places(), stroke });
            words += &format!(", {} packings", of_group.len());
        }
        entries.push(Entry { words, stroke });
    }
    let (mut svg, top) = start("compare-shear-stress", WIDTH, &entries);
    let frame = side_by_side(1, WIDTH, top, HEIGHT)[0];
    let stresses = averages.of.iter().flat_map(|curve| curve.stress.iter().map(|stress| 1e-3 * stress));
    let end = among.members.iter().map(Member::strain_end).fold(0.0, f64::max);
    let chart = Chart {
        title: String::new(),
        x: Axis::exact(STRAIN_LABEL, 0.0, 100.0 * end),
        y: Axis::around(SHEAR_LABEL, stresses.chain([0.0])),
        curves,
        moments: Vec::new(),
        levels: Vec::new(),
    };
    for (least, most, colour) in &areas {
        chart.fill_between(&mut svg, frame, least, most, colour);
    }
    chart.draw(&mut svg, frame);
    svg.finish("Shear stress of all runs against horizontal strain")
}

fn caption(window: &str) -> String {
    format!(
        "Moving average of shear stress over {window} (Chen et al. 2021, figures 10 and 12: 8 of 1000 samples a second); it \
         does not look across the enrichment. Of several packings: their mean, with the band between the least and the most."
    )
}
