//! Peak of shear stress and how far it falls afterwards (Chen et al. 2021, figure 12: cohesive material has a higher peak and
//! softens more).

use serde_json::{Value, json};

use super::among::{Among, Member};
use super::bands::PAPER;
use super::curves::{Averaged, Averages};
use super::{Part, Sheet, by_group};
use crate::plot::report::chart::percent;
use crate::plot::report::findings::mean;
use crate::plot::report::words::kilopascal;

/// A run's highest moving average, and its level over the last part of the strain that all runs have in common.
struct Level<'a> {
    member: &'a Member<'a>,
    /// Strain and stress, Pa.
    peak: (f64, f64),
    /// Pa.
    residual: f64,
}

impl Level<'_> {
    /// Fall from the peak as a share of it.
    fn softening(&self) -> f64 {
        1.0 - self.residual / self.peak.1
    }
}

pub fn part(among: &Among, averages: &Averages) -> Part {
    let end = among.members.iter().map(Member::strain_end).fold(f64::INFINITY, f64::min);
    // The same share of the strain as the paper's interval for bands.
    let from = PAPER[0] / PAPER[1] * end;
    let curves = among.members.iter().zip(&averages.of);
    let level = |(member, curve): (_, &Averaged)| {
        let rows =
            || curve.strain.iter().copied().zip(curve.stress.iter().copied()).filter(|(strain, _)| *strain <= end);
        let peak = rows().reduce(|best, row| if row.1 > best.1 { row } else { best })?;
        let late: Vec<f64> = rows().filter(|(strain, _)| *strain >= from).map(|(_, stress)| stress).collect();
        (!late.is_empty() && peak.1 > 0.0).then(|| Level { member, peak, residual: mean(&late) })
    };
    let levels: Vec<Level> = curves.filter_map(level).collect();
    if levels.is_empty() {
        return Part::without("Peak and softening are left out: no run has a shear stress above zero.".to_owned());
    }
    let mut sheet = Sheet::new("Peak and softening", &["peak", "at strain", "level at the end", "fall from the peak"]);
    for level in &levels {
        sheet.row(
            &level.member.label,
            vec![
                Some(kilopascal(level.peak.1)),
                Some(percent(level.peak.0)),
                Some(kilopascal(level.residual)),
                Some(percent(level.softening())),
            ],
        );
    }
    let of = |pick: fn(&Level) -> f64| -> Vec<(usize, f64)> {
        levels.iter().map(|level| (level.member.group, pick(level))).collect()
    };
    let sentence = format!(
        "Peak of shear stress: {}. Fall from it to the mean from {} to {} of strain: {}.",
        by_group(&among.groups, &of(|level| level.peak.1), kilopascal),
        percent(from),
        percent(end),
        by_group(&among.groups, &of(|level| level.softening()), percent),
    );
    let json = |level: &Level| {
        json!({
            "run": level.member.label, "group": among.groups[level.member.group].name, "seed": level.member.seed,
            "peak_pa": level.peak.1, "peak_strain": level.peak.0, "residual_pa": level.residual,
            "residual_between_strains": [from, end], "softening": level.softening(),
        })
    };
    let json = Value::Array(levels.iter().map(json).collect());
    Part { sentences: vec![sentence], sheets: vec![sheet], json, ..Part::default() }
}
