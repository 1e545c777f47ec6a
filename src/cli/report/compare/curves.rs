//! Shear stress over horizontal strain (Chen et al. 2021, figures 10 and 12): moving averages, how far they are from those of
//! grains alone, and the mean of several packings.

use serde_json::{Value, json};

use super::among::{Among, Group, Member};
use super::{Drawn, Part, Sheet, range, share};
use crate::cli::report::WIDTH;
use crate::cli::report::chart::{Axis, Chart, Curve, Entry, percent, side_by_side};
use crate::cli::report::figures::{HEIGHT, SHEAR_LABEL, STRAIN_LABEL, places, start};
use crate::cli::report::findings::{WINDOW, mean, smooth};
use crate::cli::report::load::linear;
use crate::cli::report::words::{THIN, kilopascal, plain};

/// Rows that two curves must share to be compared.
const ROWS_MIN: usize = WINDOW;

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
    fn of(member: &Member, rows: usize) -> Self {
        let series = &member.run.series;
        let cut = member.cut();
        Self { strain: series.strain.clone(), stress: smooth(&series.shear_stress, cut, rows), cut }
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
        let interval = |member: &Member| {
            let time = &member.run.series.time;
            (time[time.len() - 1] - time[0]) / (time.len() - 1).max(1) as f64
        };
        let longest = among.members.iter().map(interval).fold(0.0, f64::max);
        let rows = |member: &Member| match interval(member) {
            own if own > 0.0 => ((WINDOW as f64 * longest / own).round() as usize).max(1),
            _ => WINDOW,
        };
        let of = among.members.iter().map(|member| Averaged::of(member, rows(member))).collect();
        Self { window: WINDOW as f64 * longest, of }
    }
}

/// How far a curve is from another one over an interval of strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Strains.
    pub from: f64,
    pub to: f64,
    /// Mean of the other one, Pa.
    pub reference: f64,
    /// Mean difference as a share of it.
    pub mean: f64,
    /// Root-mean-square difference as a share of it.
    pub rms: f64,
}

impl Difference {
    /// Compares at the reference's rows from the strain `from` on, to the end of both.
    pub fn of(curve: &Averaged, reference: &Averaged, from: f64) -> Option<Self> {
        let rows = reference.strain.iter().zip(&reference.stress).filter(|(strain, _)| **strain >= from);
        let pairs: Vec<(f64, f64, f64)> =
            rows.filter_map(|(&strain, &other)| Some((strain, curve.at(strain)?, other))).collect();
        if pairs.len() < ROWS_MIN {
            return None;
        }
        let of = |pick: fn(f64, f64) -> f64| -> f64 {
            mean(&pairs.iter().map(|&(_, own, other)| pick(own, other)).collect::<Vec<_>>())
        };
        let level = of(|_, other| other);
        let (difference, square) = (of(|own, other| own - other), of(|own, other| (own - other) * (own - other)));
        (level != 0.0).then(|| Self {
            from: pairs[0].0,
            to: pairs[pairs.len() - 1].0,
            reference: level,
            mean: difference / level,
            rms: square.sqrt() / level.abs(),
        })
    }

    pub fn json(&self) -> Value {
        json!({
            "from_strain": self.from, "to_strain": self.to, "mean_reference_pa": self.reference,
            "mean_difference": self.mean, "rms_difference": self.rms,
        })
    }
}

/// Mean, least and most of several curves, at the strains of the first as far as all of them reach.
struct Spread {
    mean: Averaged,
    least: Vec<[f64; 2]>,
    most: Vec<[f64; 2]>,
}

fn spread(curves: &[&Averaged]) -> Spread {
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

/// What two curves have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// The packing: a hybrid or a continuum, and grains alone.
    Packing,
    /// They are means of packings.
    Means,
    /// The method: grains alone, in two packings.
    Spread,
}

impl Kind {
    /// In `comparison.json`.
    fn name(self) -> &'static str {
        match self {
            Self::Packing => "packing",
            Self::Means => "means",
            Self::Spread => "spread",
        }
    }
}

/// A comparison of two curves by name.
struct Compared {
    names: [String; 2],
    kind: Kind,
    difference: Difference,
}

/// Each hybrid and continuum against the grains of its packing, the means of several packings, and the packings of grains
/// alone against each other.
fn compared(among: &Among, averages: &Averages) -> Vec<Compared> {
    let curve = |member: &Member| &averages.of[member.index];
    let mut all = Vec::new();
    let mut add = |names: [&str; 2], kind: Kind, curves: [&Averaged; 2], from: f64| {
        if let Some(difference) = Difference::of(curves[0], curves[1], from) {
            all.push(Compared { names: names.map(str::to_owned), kind, difference });
        }
    };
    for member in among.members.iter().filter(|member| !member.is("dem")) {
        if let Some(partner) = among.partner(member) {
            let names = [&*member.label, &partner.label];
            add(names, Kind::Packing, [curve(member), curve(partner)], among.compared_from(member));
        }
    }
    for group in &among.groups {
        let members = among.of_group(group);
        let case = members[0].case;
        let other =
            among.groups.iter().find(|other| among.of_group(other).iter().all(|dem| dem.is("dem") && dem.case == case));
        let several = |group: &Group| group.members.len() > 1;
        if let Some(other) = other.filter(|other| !members[0].is("dem") && several(group) && several(other)) {
            let mean = |group: &Group| spread(&group.members.iter().map(|&i| &averages.of[i]).collect::<Vec<_>>()).mean;
            let from = members.iter().map(|member| among.compared_from(member)).fold(0.0, f64::max);
            let names = [group, other].map(|group| format!("{}, mean of {}", group.name, group.members.len()));
            add([&names[0], &names[1]], Kind::Means, [&mean(group), &mean(other)], from);
        }
    }
    for case in 0..among.cases() {
        let grains = among.of_method(case, "dem");
        for (index, one) in grains.iter().enumerate() {
            for other in grains[index + 1..].iter().filter(|other| other.seed != one.seed) {
                add([&*one.label, &other.label], Kind::Spread, [curve(one), curve(other)], among.compared_from(one));
            }
        }
    }
    all
}

pub fn part(among: &Among, averages: &Averages) -> Part {
    let compared = compared(among, averages);
    let mut sheet = Sheet::new(
        "Shear stress against that of grains alone",
        &["strain", "its mean", "mean difference", "root-mean-square"],
    );
    for Compared { names, difference, .. } in &compared {
        sheet.row(
            &names.join(" \u{2013} "),
            vec![
                Some(format!("{} to {}", percent(difference.from), percent(difference.to))),
                Some(kilopascal(difference.reference)),
                Some(share(difference.mean)),
                Some(percent(difference.rms)),
            ],
        );
    }
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
    let json: Vec<Value> = compared
        .iter()
        .map(|Compared { names, kind, difference }| {
            let mut value = difference.json();
            value["of"] = json!(names[0]);
            value["against"] = json!(names[1]);
            value["kind"] = json!(kind.name());
            value
        })
        .collect();
    Part {
        sentences: sentences(&compared),
        figures: vec![Drawn {
            name: "compare_shear_stress",
            drawing: drawing(among, averages),
            caption: caption(&window),
        }],
        sheets: vec![sheet],
        left_out,
        json: json!({ "window_s": averages.window, "differences": json }),
    }
}

fn sentences(compared: &[Compared]) -> Vec<String> {
    let spread: Vec<&Difference> =
        compared.iter().filter(|pair| pair.kind == Kind::Spread).map(|pair| &pair.difference).collect();
    let told = |Compared { names, difference, .. }: &Compared| {
        format!(
            "{} is {} off {} in the mean and {} root-mean-square",
            names[0],
            share(difference.mean),
            names[1],
            percent(difference.rms)
        )
    };
    let means: Vec<String> = compared.iter().filter(|pair| pair.kind == Kind::Means).map(told).collect();
    let pairs: Vec<String> = compared.iter().filter(|pair| pair.kind == Kind::Packing).map(told).collect();
    let mut all = Vec::new();
    let chosen = if means.is_empty() { pairs } else { means };
    if !chosen.is_empty() {
        all.push(format!("Shear stress after enrichment: {}.", chosen.join("; ")));
    }
    if !spread.is_empty() {
        let range = |pick: fn(&Difference) -> f64| {
            let found = range(spread.iter().map(|difference| pick(difference).abs())).unwrap_or_default();
            if spread.len() == 1 { percent(found[0]) } else { found.map(percent).join(" to ") }
        };
        all.push(format!(
            "Packings of grains alone differ from each other by {} in the mean and {} root-mean-square.",
            range(|difference| difference.mean),
            range(|difference| difference.rms)
        ));
    }
    all
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
