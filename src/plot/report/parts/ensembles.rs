//! What several packings tell of the mean of all: 95 % intervals, and how many packings a claim needs.

use super::{Part, Sheet};
use crate::analysis::measures::ensembles::Ensemble;
use crate::plot::report::numbers::{kilopascal, percent};

pub fn part(ensembles: &[Ensemble]) -> Part {
    let told = |of: &Ensemble, value: f64| if of.figure.ends_with("_pa") { kilopascal(value) } else { percent(value) };
    let sheet = Sheet::of(
        "Means of packings",
        ensembles,
        |of| format!("{}, {}", of.group, words(of.figure)),
        &[
            ("packings", &|of| Some(of.packings.to_string())),
            ("mean", &|of| Some(told(of, of.mean))),
            ("deviation of one", &|of| Some(told(of, of.deviation))),
            ("95 % interval of the mean, to either side", &|of| {
                Some(format!("{} ({})", told(of, of.half_width_95), percent(of.half_width_95 / of.mean.abs())))
            }),
            ("packings for 5 %", &|of| Some(needed(of))),
        ],
    );
    let sentence = |of: &Ensemble| {
        format!(
            "{}: the mean peak of {} packings is known to {} (95 %); to 5 % it takes {}",
            of.group,
            of.packings,
            percent(of.half_width_95 / of.mean.abs()),
            needed(of)
        )
    };
    let peaks: Vec<String> = ensembles.iter().filter(|of| of.figure == "peak_pa").map(sentence).collect();
    Part { sentences: vec![peaks.join("; ") + "."], sheets: vec![sheet], ..Part::default() }
}

fn needed(of: &Ensemble) -> String {
    of.packings_for_5_percent.map_or_else(|| "more than anybody makes".to_owned(), |count| count.to_string())
}

fn words(figure: &str) -> &'static str {
    match figure {
        "peak_pa" => "peak",
        "peak_strain" => "strain at the peak",
        _ => "mean of the last part",
    }
}
