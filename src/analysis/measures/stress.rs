//! What resists the drive over its strain (Chen et al. 2021, figures 10, 12, 17, 20 and 23): moving averages over equal times, how
//! far they are from those of grains alone, the mean of several packings, the peak and the fall from it.

use serde::Serialize;

use super::Found;
use super::among::{Among, Group, Member, Who};
use crate::analysis::curve::{Averaged, Difference, Spread, WINDOW, deviation, highest, mean, windows};

/// What two curves have in common.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The packing: a hybrid or a continuum, and grains alone.
    Packing,
    /// Nothing: of a hybrid or a continuum there are no grains alone in the same packing.
    OtherPacking,
    /// They are means of packings.
    Means,
    /// The method: grains alone, in two packings.
    Spread,
}

/// A comparison of two curves by name.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Name of a run, or of a group and its mean.
    pub of: String,
    /// The same of the reference.
    pub against: String,
    /// What the two have in common.
    pub kind: Kind,
    /// Of the one from the reference.
    #[serde(flatten)]
    pub difference: Difference,
}

/// Highest moving average of a whole run.
#[derive(Clone, Debug, Serialize)]
pub struct Peak {
    /// The run.
    #[serde(flatten)]
    pub who: Who,
    /// Pa.
    pub peak_pa: f64,
    /// Strain there.
    pub peak_strain: f64,
}

/// Curves of stress over strain, and how far they are apart.
#[derive(Clone, Debug, Serialize)]
pub struct Stress {
    /// The body that presses, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// That averages are over.
    pub window_s: f64,
    /// Way of the drive that is a strain of one, m; none of a cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metres_of_strain_one: Option<f64>,
    /// From grains alone, between means of packings, and between grains alone of several packings.
    pub differences: Vec<Compared>,
    /// One a run, in their order.
    pub peaks: Vec<Peak>,
    /// Of every run.
    #[serde(skip)]
    pub averages: Vec<Averaged>,
    /// Of every group of several packings.
    #[serde(skip)]
    pub spreads: Vec<Option<Spread>>,
}

/// Moving averages of every member over one time, s, which stands before them.
pub fn averages(among: &Among) -> (f64, Vec<Averaged>) {
    let times: Vec<&[f64]> = among.members.iter().map(|member| member.run.column("time")).collect();
    let (window, rows) = windows(&times);
    let averaged = |(member, rows): (&Member, usize)| {
        Averaged::of(&member.run.drive.values, member.stress(), member.run.cut(), rows)
    };
    (window, among.members.iter().zip(rows).map(averaged).collect())
}

/// Compares between strains that are wanted, or wherever both curves are; not before [`Among::compared_from`].
pub fn measured(among: &Among, wanted: Option<[f64; 2]>) -> Found<Stress> {
    let (window, averages) = averages(among);
    let spread = |group: &Group| {
        let of: Vec<&Averaged> = group.members.iter().map(|&index| &averages[index]).collect();
        (of.len() > 1).then(|| Spread::of(&of))
    };
    let spreads: Vec<Option<Spread>> = among.groups.iter().map(spread).collect();
    let differences = differences(among, &averages, &spreads, wanted.unwrap_or([0.0, f64::INFINITY]));
    let peak = |(member, curve): (&Member, &Averaged)| {
        let row = highest(&curve.stress);
        Peak { who: member.who.clone(), peak_pa: curve.stress[row], peak_strain: curve.strain[row] }
    };
    let peaks = among.members.iter().zip(&averages).map(peak).collect();
    let drive = &among.members[0].run.drive;
    let mut left_out = without_partner(among);
    if !among.members.iter().any(|member| member.is("dem")) {
        left_out.push("No run is of grains alone: stresses are compared with nothing.".to_owned());
    } else if differences.is_empty() {
        let why = "No two of these runs have enough rows in common, after enrichment and between these strains.";
        left_out.push(why.to_owned());
    }
    let (body, metres_of_strain_one) = (drive.body.clone(), drive.metres);
    Found::of(Stress { body, window_s: window, metres_of_strain_one, differences, peaks, averages, spreads }, left_out)
}

/// Why these members cannot be compared with grains alone of their packing, a line each.
fn without_partner(among: &Among) -> Vec<String> {
    let alone =
        |member: &&Member| ["hybrid", "mpm"].iter().any(|method| member.is(method)) && among.partner(member).is_none();
    let line = |member: &Member| {
        let seed = member.who.seed.map_or_else(String::new, |seed| format!(" with seed {seed}"));
        let run = &member.who.run;
        format!("{run} is compared with no run of grains alone of its packing: none of this specimen{seed} is given.")
    };
    among.members.iter().filter(alone).map(line).collect()
}

/// Each hybrid and continuum against the grains of its packing, the means of several packings, and the packings of grains
/// alone against each other.
fn differences(
    among: &Among,
    averages: &[Averaged],
    spreads: &[Option<Spread>],
    [from, to]: [f64; 2],
) -> Vec<Compared> {
    let mut all = Vec::new();
    let mut add = |names: [&str; 2], kind: Kind, curves: [&Averaged; 2], between: [f64; 2]| {
        if let Some(difference) = Difference::of(curves[0], curves[1], between) {
            let [of, against] = names.map(str::to_owned);
            all.push(Compared { of, against, kind, difference });
        }
    };
    let curve = |member: &Member| &averages[member.index()];
    let since = |member: &Member| [from.max(among.compared_from(member)), to];
    for one in among.members.iter().filter(|one| !one.is("dem")) {
        if let Some(other) = among.stand_in(one) {
            let kind = if one.who.seed == other.who.seed { Kind::Packing } else { Kind::OtherPacking };
            add([&one.who.run, &other.who.run], kind, [curve(one), curve(other)], since(one));
        }
    }
    let members = |group: &Group| group.members.iter().map(|&index| &among.members[index]).collect::<Vec<_>>();
    for (group, spread) in among.groups.iter().zip(spreads) {
        let own = members(group);
        let is_alone = |other: &Group| members(other).iter().all(|dem| dem.is("dem") && dem.case == own[0].case);
        let other = among.groups.iter().position(is_alone).filter(|_| !own[0].is("dem"));
        if let Some((other, (spread, of_other))) =
            other.and_then(|other| Some((&among.groups[other], spread.as_ref().zip(spreads[other].as_ref())?)))
        {
            let latest = own.iter().map(|one| since(one)[0]).fold(0.0, f64::max);
            let names = [group, other].map(|group| format!("{}, mean of {}", group.name, group.members.len()));
            add([&names[0], &names[1]], Kind::Means, [&spread.mean, &of_other.mean], [latest, to]);
        }
    }
    let grains: Vec<&Member> = among.members.iter().filter(|one| one.is("dem")).collect();
    for (index, one) in grains.iter().enumerate() {
        let others =
            grains[index + 1..].iter().filter(|other| other.case == one.case && other.who.seed != one.who.seed);
        for other in others {
            add([&one.who.run, &other.who.run], Kind::Spread, [curve(one), curve(other)], since(one));
        }
    }
    all
}

/// A run's peak and its level over the last part of the strain that all runs have in common, and how it ended.
#[derive(Clone, Debug, Serialize)]
pub struct Level {
    /// The run.
    #[serde(flatten)]
    pub who: Who,
    /// Highest moving average, Pa, up to the strain that all runs reach.
    pub peak_pa: f64,
    /// Strain there.
    pub peak_strain: f64,
    /// Mean of the moving average over the last part of that strain, Pa.
    pub residual_pa: f64,
    /// The last part; its share of the whole is that of the paper's interval for bands.
    pub residual_between_strains: [f64; 2],
    /// Fall from the peak as a share of it.
    pub softening: f64,
    /// Of the last rows.
    pub stress_end_pa: f64,
    /// Of the last row.
    pub strain_end: f64,
    /// Of the last row, dilation positive; none where the series has none.
    pub volume_strain_end: Option<f64>,
    /// Over the second half of the run, rows one by one.
    pub normal_stress_pa: Option<f64>,
    /// Standard deviation of the same, Pa.
    pub normal_stress_deviation_pa: Option<f64>,
}

/// `averages` are those of all members, in their order; runs without a stress above zero have no level.
pub fn levels(among: &Among, averages: &[Averaged]) -> Found<Vec<Level>> {
    let [end, _] = among.ends();
    let of_paper = among.members[0].run.drive.interval;
    // The same share of the strain as the paper's interval for bands.
    let from = of_paper[0] / of_paper[1] * end;
    let level = |(member, curve): (&Member, &Averaged)| {
        let rows: Vec<usize> = (0..curve.strain.len()).filter(|&row| curve.strain[row] <= end).collect();
        let late = rows.iter().filter(|&&row| curve.strain[row] >= from);
        let late: Vec<f64> = late.map(|&row| curve.stress[row]).collect();
        let peak = highest(&curve.stress[..rows.len()]);
        let (peak_pa, residual_pa) = (*curve.stress[..rows.len()].get(peak)?, mean(&late));
        let normal = member.run.column("normal_stress");
        let second_half = Some(&normal[normal.len().saturating_sub(1) / 2..]).filter(|half| !half.is_empty());
        let stress = member.stress();
        (!late.is_empty() && peak_pa > 0.0).then(|| Level {
            who: member.who.clone(),
            peak_pa,
            peak_strain: curve.strain[peak],
            residual_pa,
            residual_between_strains: [from, end],
            softening: 1.0 - residual_pa / peak_pa,
            stress_end_pa: mean(&stress[stress.len().saturating_sub(WINDOW)..]),
            strain_end: member.strain_end(),
            volume_strain_end: member.run.last("volume_strain"),
            normal_stress_pa: second_half.map(mean),
            normal_stress_deviation_pa: second_half.map(deviation),
        })
    };
    let levels: Vec<Level> = among.members.iter().zip(averages).filter_map(level).collect();
    match levels.is_empty() {
        true => Found::nothing("Peak and softening are left out: no run has a stress above zero.".to_owned()),
        false => Found::of(levels, Vec::new()),
    }
}
