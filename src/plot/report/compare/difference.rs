//! How far curves of a stress are from each other: as numbers, a table and sentences.

use serde_json::{Value, json};

use super::curves::Averaged;
use super::{Sheet, range, share};
use crate::plot::report::chart::percent;
use crate::plot::report::findings::{WINDOW, mean};
use crate::plot::report::words::kilopascal;

/// Rows that two curves must share to be compared.
const ROWS_MIN: usize = WINDOW;

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
    /// Compares at the reference's rows between two strains, no farther than both go.
    pub fn of(curve: &Averaged, reference: &Averaged, [from, to]: [f64; 2]) -> Option<Self> {
        let rows = reference.strain.iter().zip(&reference.stress).filter(|(strain, _)| (from..=to).contains(*strain));
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

/// What two curves have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The packing: a hybrid or a continuum, and grains alone.
    Packing,
    /// Nothing: of a hybrid or a continuum there are no grains alone in the same packing.
    Other,
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
            Self::Other => "other_packing",
            Self::Means => "means",
            Self::Spread => "spread",
        }
    }
}

/// A comparison of two curves by name.
pub struct Compared {
    pub names: [String; 2],
    pub kind: Kind,
    pub difference: Difference,
}

/// All of them as a table.
pub fn sheet(title: &'static str, compared: &[Compared]) -> Sheet {
    let mut sheet = Sheet::new(title, &["strain", "its mean", "mean difference", "root-mean-square"]);
    for Compared { names, difference, .. } in compared {
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
    sheet
}

/// All of them for `comparison.json`.
pub fn json(compared: &[Compared]) -> Vec<Value> {
    let told = |Compared { names, kind, difference }: &Compared| {
        let mut value = difference.json();
        value["of"] = json!(names[0]);
        value["against"] = json!(names[1]);
        value["kind"] = json!(kind.name());
        value
    };
    compared.iter().map(told).collect()
}

/// The main differences, after words that say of what and where; of means where there are any.
pub fn sentences(of: &str, compared: &[Compared]) -> Vec<String> {
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
    let pairs: Vec<String> =
        compared.iter().filter(|pair| matches!(pair.kind, Kind::Packing | Kind::Other)).map(told).collect();
    let mut all = Vec::new();
    let chosen = if means.is_empty() { pairs } else { means };
    if !chosen.is_empty() {
        all.push(format!("{of}: {}.", chosen.join("; ")));
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
