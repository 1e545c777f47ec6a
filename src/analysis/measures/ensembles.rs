//! What several packings of one group tell of the mean of all packings: its 95 % interval, and how many packings would make it as
//! narrow as a claim needs.

use serde::Serialize;

use super::Found;
use super::among::Among;
use super::stress::Level;
use crate::analysis::interval::{deviation_of_sample, half_width, packings_for};

/// Share of the mean within which its interval is to be for [`Ensemble::packings_for_5_percent`].
pub const WANTED: f64 = 0.05;

/// One figure of a group of packings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ensemble {
    /// The place of the group among the groups.
    #[serde(skip)]
    pub number: usize,
    /// Its name.
    pub group: String,
    /// `peak_pa`, `peak_strain` or `residual_pa`, as of single runs.
    pub figure: &'static str,
    /// Those of different seeds.
    pub packings: usize,
    /// Over the packings, in the unit of the figure.
    pub mean: f64,
    /// Standard deviation of one packing, by n - 1.
    pub deviation: f64,
    /// The mean of all packings is within so much of this mean with 95 % confidence (Student's t).
    pub half_width_95: f64,
    /// As many packings of that deviation have a mean within 5 % of itself.
    pub packings_for_5_percent: Option<usize>,
}

type Figure = (&'static str, fn(&Level) -> f64);

/// Of groups with two packings or more; one that is there twice counts once.
pub fn measured(among: &Among, levels: &[Level]) -> Found<Vec<Ensemble>> {
    let figures: [Figure; 3] = [
        ("peak_pa", |level| level.peak_pa),
        ("peak_strain", |level| level.peak_strain),
        ("residual_pa", |level| level.residual_pa),
    ];
    let mut all = Vec::new();
    for (number, group) in among.groups.iter().enumerate() {
        // A packing that was given twice tells nothing twice.
        let mut seeds = Vec::new();
        let mut own: Vec<&Level> = levels.iter().filter(|level| level.who.number == number).collect();
        own.retain(|level| {
            !seeds.contains(&level.who.seed) && {
                seeds.push(level.who.seed);
                true
            }
        });
        if own.len() < 2 {
            continue;
        }
        for (figure, of) in figures {
            let values: Vec<f64> = own.iter().map(|level| of(level)).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let deviation = deviation_of_sample(&values);
            all.push(Ensemble {
                number,
                group: group.name.clone(),
                figure,
                packings: values.len(),
                mean,
                deviation,
                half_width_95: half_width(deviation, values.len()),
                packings_for_5_percent: packings_for(deviation, WANTED * mean.abs()),
            });
        }
    }
    Found::of(all, Vec::new())
}
