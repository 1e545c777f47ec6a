//! What a run shows, in numbers.

use super::load::Run;

/// Rows of `series.csv` in the moving average of stresses (the window of Chen et al. 2021, figures 12 and 23).
pub const WINDOW: usize = 8;
/// Strain after enrichment within which the disturbance is looked for.
pub const STRAIN_DISTURBED: f64 = 0.01;
/// Strain after enrichment up to which the level afterwards is averaged, from [`STRAIN_DISTURBED`] on.
pub const STRAIN_SETTLED: f64 = 0.03;
/// The stress has recovered when its moving average reaches this share of the level afterwards.
pub const RECOVERED: f64 = 0.9;

/// The curves and figures of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Moving average of shear stress, Pa, one a row; it does not look across the enrichment.
    pub shear_smooth: Vec<f64>,
    /// Moving average of normal stress, Pa.
    pub normal_smooth: Vec<f64>,
    /// Strain and stress (Pa) of the highest moving average of shear stress.
    pub peak: (f64, f64),
    /// Mean shear stress of the last rows, Pa.
    pub shear_end: f64,
    pub strain_end: f64,
    pub volume_strain_end: f64,
    /// Mean normal stress over the last half of the run, Pa.
    pub normal_mean: f64,
    /// Standard deviation of the rows' normal stress over the last half of the run, Pa.
    pub normal_deviation: f64,
    pub enrichment: Option<Enrichment>,
}

/// Grains took the place of points, and what it did to the stress on the plate.
#[derive(Clone, Debug, PartialEq)]
pub struct Enrichment {
    /// First row with the new grains.
    pub row: usize,
    pub strain: f64,
    /// s.
    pub time: f64,
    /// Mean of the last rows before, as many as are averaged over, Pa.
    pub before: f64,
    /// Lowest moving average within [`STRAIN_DISTURBED`], Pa.
    pub lowest: f64,
    /// Highest row, not averaged, within [`STRAIN_DISTURBED`], Pa.
    pub highest: f64,
    /// Mean between [`STRAIN_DISTURBED`] and [`STRAIN_SETTLED`] after, Pa; none if the run ends before.
    pub settled: Option<f64>,
    /// Strain from enrichment to recovery: from its lowest point on, the moving average first reaches [`RECOVERED`] of
    /// the settled level. Zero if it never was below.
    pub recovery: Option<f64>,
}

impl Findings {
    pub fn of(run: &Run) -> Self {
        let series = &run.series;
        let row = enrichment_row(run);
        let shear_smooth = smooth(&series.shear_stress, row, WINDOW);
        let normal_smooth = smooth(&series.normal_stress, row, WINDOW);
        let last = series.rows() - 1;
        let peak = (0..=last).reduce(|best, row| if shear_smooth[row] > shear_smooth[best] { row } else { best });
        let peak = peak.expect("a series has rows");
        let half = &series.normal_stress[last / 2..];
        let normal_mean = mean(half);
        let variance = half.iter().map(|value| (value - normal_mean) * (value - normal_mean)).sum::<f64>();
        Self {
            peak: (series.strain[peak], shear_smooth[peak]),
            shear_end: mean(&series.shear_stress[(last + 1).saturating_sub(WINDOW)..]),
            strain_end: series.strain[last],
            volume_strain_end: series.volume_strain[last],
            normal_mean,
            normal_deviation: (variance / half.len() as f64).sqrt(),
            enrichment: row.map(|row| Enrichment::at(run, &shear_smooth, row, WINDOW)),
            shear_smooth,
            normal_smooth,
        }
    }
}

impl Enrichment {
    /// The same by averages over `rows` rows, for a series of which [`WINDOW`] rows span too much strain.
    pub fn averaged(run: &Run, rows: usize) -> Option<Self> {
        let row = enrichment_row(run)?;
        Some(Self::at(run, &smooth(&run.series.shear_stress, Some(row), rows), row, rows))
    }

    fn at(run: &Run, shear_smooth: &[f64], row: usize, window: usize) -> Self {
        let series = &run.series;
        let time = run.summary_figure("enriched_at_time").unwrap_or(series.time[row]);
        let strain = run.summary_figure("enriched_at_strain").unwrap_or_else(|| series.strain_at(time));
        let within = |from: f64, to: f64| {
            (row..series.rows())
                .filter(move |&row| series.strain[row] >= strain + from && series.strain[row] <= strain + to)
        };
        let lowest_row = within(0.0, STRAIN_DISTURBED)
            .chain([row])
            .fold(row, |best, row| if shear_smooth[row] < shear_smooth[best] { row } else { best });
        let highest =
            within(0.0, STRAIN_DISTURBED).map(|row| series.shear_stress[row]).fold(series.shear_stress[row], f64::max);
        let later: Vec<f64> = within(STRAIN_DISTURBED, STRAIN_SETTLED).map(|row| series.shear_stress[row]).collect();
        let settled = (later.len() >= window).then(|| mean(&later));
        let recovery = settled.and_then(|level| {
            if shear_smooth[lowest_row] >= RECOVERED * level {
                return Some(0.0);
            }
            let back = (lowest_row..series.rows()).find(|&row| shear_smooth[row] >= RECOVERED * level)?;
            Some(series.strain[back] - strain)
        });
        Self {
            row,
            strain,
            time,
            before: mean(&series.shear_stress[row.saturating_sub(window)..row]),
            lowest: shear_smooth[lowest_row],
            highest,
            settled,
            recovery,
        }
    }
}

/// The first row with more grains than the plates have; only a hybrid run can have one.
fn enrichment_row(run: &Run) -> Option<usize> {
    let grains = &run.series.grains;
    if run.method != "hybrid" {
        return None;
    }
    (1..grains.len()).find(|&row| grains[row] > grains[0])
}

/// Moving average over `window` rows, shorter at the ends and at row `cut`, which starts anew.
pub fn smooth(values: &[f64], cut: Option<usize>, window: usize) -> Vec<f64> {
    let (before, after) = values.split_at(cut.unwrap_or(values.len()));
    [before, after]
        .into_iter()
        .flat_map(|piece| {
            (0..piece.len()).map(move |row| {
                let from = row.saturating_sub(window / 2);
                let to = (row + window - window / 2).min(piece.len());
                mean(&piece[from..to])
            })
        })
        .collect()
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::plot::report::load::Series;

    /// A run of 1,000 rows to 10 % strain that is enriched at 4 %: stress 100 before, a fall to `low` that is made good
    /// linearly over 0.5 % strain, 90 after.
    pub fn hybrid(low: f64) -> Run {
        let strain: Vec<f64> = (1..=1000).map(|row| f64::from(row) * 1e-4).collect();
        let stress = |strain: f64| match strain - 0.04 {
            past if past < 0.0 => 100.0,
            past => (low + (90.0 - low) * past / 0.005).min(90.0),
        };
        let series = Series {
            time: strain.iter().map(|strain| strain * 10.0).collect(),
            shear_stress: strain.iter().map(|&strain| stress(strain)).collect(),
            normal_stress: vec![400.0; 1000],
            volume_strain: strain.iter().map(|strain| 0.1 * strain).collect(),
            grains: strain.iter().map(|&strain| if strain < 0.04 { 60.0 } else { 900.0 }).collect(),
            strain,
            ..Series::default()
        };
        Run {
            directory: "runs/t".into(),
            name: "t".into(),
            method: "hybrid".into(),
            width: 0.06,
            diameter: 1e-3,
            stress_normal: Some(400.0),
            scenario: toml::Table::new(),
            scenario_text: String::new(),
            summary: serde_json::Map::new(),
            series,
            frame_times: vec![0.0],
        }
    }

    #[test]
    fn the_average_does_not_look_across_the_enrichment() {
        let values = [vec![1.0; 20], vec![5.0; 20]].concat();
        assert_eq!(smooth(&values, Some(20), WINDOW), values);
        let blurred = smooth(&values, None, WINDOW);
        assert!(blurred[20] > 1.0 && blurred[20] < 5.0);
        assert_eq!((blurred[0], blurred[39]), (1.0, 5.0));
    }

    #[test]
    fn a_dip_after_enrichment_is_found_with_its_recovery() {
        let findings = Findings::of(&hybrid(30.0));
        let enrichment = findings.enrichment.unwrap();
        assert!((enrichment.strain - 0.04).abs() < 1.5e-4, "{}", enrichment.strain);
        assert_eq!(enrichment.before, 100.0);
        assert!(enrichment.lowest > 30.0 && enrichment.lowest < 36.0, "{}", enrichment.lowest);
        assert_eq!(enrichment.highest, 90.0);
        assert!((enrichment.settled.unwrap() - 90.0).abs() < 1e-9);
        // 90 % of 90 is 81, reached after 0.85 of the way.
        assert!((enrichment.recovery.unwrap() - 0.85 * 0.005).abs() < 3e-4, "{:?}", enrichment.recovery);
        assert_eq!(findings.peak.1, 100.0);
        assert_eq!((findings.normal_mean, findings.normal_deviation), (400.0, 0.0));
    }

    #[test]
    fn without_a_dip_recovery_is_at_once() {
        let enrichment = Findings::of(&hybrid(88.0)).enrichment.unwrap();
        assert_eq!(enrichment.recovery, Some(0.0));
    }

    #[test]
    fn a_spike_is_not_averaged_away() {
        let mut run = hybrid(90.0);
        run.series.shear_stress[420] = 140.0;
        assert_eq!(Findings::of(&run).enrichment.unwrap().highest, 140.0);
    }

    #[test]
    fn grains_alone_are_not_an_enrichment() {
        let mut run = hybrid(30.0);
        run.method = "dem".into();
        assert_eq!(Findings::of(&run).enrichment, None);
    }

    #[test]
    fn a_run_that_ends_with_its_enrichment_claims_no_recovery() {
        let mut run = hybrid(30.0);
        let series = &mut run.series;
        for column in [
            &mut series.time,
            &mut series.strain,
            &mut series.shear_stress,
            &mut series.normal_stress,
            &mut series.volume_strain,
            &mut series.grains,
        ] {
            column.truncate(405);
        }
        let enrichment = Findings::of(&run).enrichment.unwrap();
        assert_eq!((enrichment.settled, enrichment.recovery), (None, None));
    }
}
