//! Stress around the enrichment, by the amount of training (Chen et al. 2021, figure 14 and 15 left).

use serde::Serialize;

use super::Found;
use super::among::{Among, Member, Who};
use crate::analysis::curve::{WINDOW, mean, smooth};

/// Strain after enrichment within which the disturbance is looked for.
pub const STRAIN_DISTURBED: f64 = 0.01;
/// Strain after enrichment up to which the level afterwards is averaged, from [`STRAIN_DISTURBED`] on.
pub const STRAIN_SETTLED: f64 = 0.03;
/// The stress has recovered when its moving average reaches this share of the level afterwards.
const RECOVERED: f64 = 0.9;
/// Averages are over [`WINDOW`] rows, but over no more strain than this: 8 ms of the paper's speed, width and sampling.
pub const STRAIN_AVERAGED: f64 = 0.0027;

/// Grains took the place of points, and what it did to the stress.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Disturbance {
    /// At the enrichment.
    pub strain: f64,
    /// s, at the enrichment.
    pub time_s: f64,
    /// Rows that a moving average is over.
    pub rows_averaged: usize,
    /// Mean of the last rows before, as many as are averaged over.
    pub before_pa: f64,
    /// Lowest moving average within [`STRAIN_DISTURBED`], and its fall as a share of the level before.
    pub lowest_average_pa: f64,
    /// Lowest average over the level before, less 1: negative of a fall.
    pub drop: f64,
    /// Highest row, not averaged, within [`STRAIN_DISTURBED`].
    pub highest_row_pa: f64,
    /// Of the rows within [`STRAIN_DISTURBED`] the one farthest from the level before, as a share of that with its sign.
    pub excursion: Option<f64>,
    /// Mean between [`STRAIN_DISTURBED`] and [`STRAIN_SETTLED`] after; none if the run ends before.
    pub settled_pa: Option<f64>,
    /// Strain from enrichment to recovery: from its lowest point on, the moving average first reaches `RECOVERED` of
    /// the settled level. Zero if it never was below.
    pub strain_until_recovered: Option<f64>,
}

impl Disturbance {
    /// Of strains and stresses row by row, of which that row is the first with the new grains, by averages over `window` rows.
    fn of(strains: &[f64], stresses: &[f64], row: usize, (time_s, strain): (f64, f64), window: usize) -> Self {
        let averages = smooth(stresses, Some(row), window);
        let within = |from: f64, to: f64| -> Vec<usize> {
            (row..strains.len()).filter(|&row| (strain + from..=strain + to).contains(&strains[row])).collect()
        };
        let near = within(0.0, STRAIN_DISTURBED);
        let lowest = near.iter().fold(row, |best, &row| if averages[row] < averages[best] { row } else { best });
        let later: Vec<f64> = within(STRAIN_DISTURBED, STRAIN_SETTLED).iter().map(|&row| stresses[row]).collect();
        let settled_pa = (later.len() >= window).then(|| mean(&later));
        let strain_until_recovered = settled_pa.and_then(|level| {
            if averages[lowest] >= RECOVERED * level {
                return Some(0.0);
            }
            let back = (lowest..strains.len()).find(|&row| averages[row] >= RECOVERED * level)?;
            Some(strains[back] - strain)
        });
        let before_pa = mean(&stresses[row.saturating_sub(window)..row]);
        let away = within(f64::NEG_INFINITY, STRAIN_DISTURBED).into_iter().map(|row| stresses[row] / before_pa - 1.0);
        let farthest = away.reduce(|most, away| if away.abs() > most.abs() { away } else { most });
        Self {
            strain,
            time_s,
            rows_averaged: window,
            before_pa,
            lowest_average_pa: averages[lowest],
            drop: averages[lowest] / before_pa - 1.0,
            highest_row_pa: near.iter().map(|&row| stresses[row]).fold(stresses[row], f64::max),
            excursion: farthest.filter(|away| away.is_finite()),
            settled_pa,
            strain_until_recovered,
        }
    }
}

/// Rows to average over.
pub fn window(member: &Member) -> usize {
    let spacing = member.strain_end() / member.run.drive.values.len() as f64;
    ((STRAIN_AVERAGED / spacing).round() as usize).clamp(1, WINDOW)
}

/// A hybrid whose grains took the place of points.
#[derive(Clone, Debug, Serialize)]
pub struct Disturbed {
    /// The hybrid.
    #[serde(flatten)]
    pub who: Who,
    /// What it did to the stress.
    #[serde(flatten)]
    pub by: Disturbance,
}

/// Of all hybrids that got more grains; those that were to be enriched and were not are named among what is left out.
pub fn measured(among: &Among) -> Found<Vec<Disturbed>> {
    let disturbed = |member: &Member| {
        let (row, at) = member.run.cut().zip(member.run.enrichment())?;
        let by = Disturbance::of(&member.run.drive.values, member.stress(), row, at, window(member));
        Some(Disturbed { who: member.who.clone(), by })
    };
    let silent = among.to_be_enriched().filter(|member| member.run.cut().is_none());
    let line = |member: &Member| format!("{} was not enriched: nothing was disturbed.", member.who.run);
    let left_out = silent.map(line).collect();
    Found::of(among.hybrids().filter_map(disturbed).collect(), left_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1,000 rows to 10 % strain that are enriched at 4 %: stress 100 before, a fall to `low` that is made good linearly over 0.5 %
    /// of strain, 90 after.
    fn rows(low: f64) -> (Vec<f64>, Vec<f64>) {
        let strains: Vec<f64> = (1..=1000).map(|row| f64::from(row) * 1e-4).collect();
        let stress = |strain: &f64| match strain - 0.04 {
            past if past < 0.0 => 100.0,
            past => (low + (90.0 - low) * past / 0.005).min(90.0),
        };
        let stresses = strains.iter().map(stress).collect();
        (strains, stresses)
    }

    fn found((strains, stresses): &(Vec<f64>, Vec<f64>)) -> Disturbance {
        let row = strains.iter().position(|strain| *strain >= 0.04).unwrap();
        Disturbance::of(strains, stresses, row, (0.4, strains[row]), WINDOW)
    }

    #[test]
    fn a_dip_after_enrichment_is_found_with_its_recovery() {
        let found = found(&rows(30.0));
        assert!((found.strain - 0.04).abs() < 1.5e-4, "{}", found.strain);
        assert_eq!((found.before_pa, found.highest_row_pa), (100.0, 90.0));
        assert!(found.lowest_average_pa > 30.0 && found.lowest_average_pa < 36.0, "{}", found.lowest_average_pa);
        assert!((found.settled_pa.unwrap() - 90.0).abs() < 1e-9);
        // 90 % of 90 is 81, reached after 0.85 of the way.
        assert!(
            (found.strain_until_recovered.unwrap() - 0.85 * 0.005).abs() < 3e-4,
            "{:?}",
            found.strain_until_recovered
        );
        assert!((found.excursion.unwrap() + 0.7).abs() < 0.02, "{:?}", found.excursion);
    }

    #[test]
    fn without_a_dip_recovery_is_at_once_and_a_spike_is_not_averaged_away() {
        assert_eq!(found(&rows(88.0)).strain_until_recovered, Some(0.0));
        let mut spiked = rows(90.0);
        spiked.1[420] = 140.0;
        assert_eq!(found(&spiked).highest_row_pa, 140.0);
    }

    #[test]
    fn a_run_that_ends_with_its_enrichment_claims_no_recovery() {
        let (mut strains, mut stresses) = rows(30.0);
        strains.truncate(405);
        stresses.truncate(405);
        let found = found(&(strains, stresses));
        assert_eq!((found.settled_pa, found.strain_until_recovered), (None, None));
    }
}
