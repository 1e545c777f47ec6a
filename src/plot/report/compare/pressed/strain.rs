//! Strain since the start at the end that all runs reach, side by side.

use serde_json::{Value, json};

use super::Runs;
use super::bands::chosen;
use super::run::Run;
use crate::base::error::Error;
use crate::plot::report::chart::percent;
use crate::plot::report::compare::pictures::{Colours, Picture, draw};
use crate::plot::report::compare::{Drawn, Part};
use crate::plot::report::panels::{nearly_largest, round_up};

pub fn part(runs: &Runs) -> Result<Part, Error> {
    let end = runs.all.iter().map(|run| run.strain_of(run.frames() - 1)).fold(f64::INFINITY, f64::min);
    let picture = |run: &Run| -> Result<Picture, Error> {
        let frame = run.frame_at(end);
        let titles = [run.label.clone(), format!("strain {}", percent(run.strain_of(frame)))];
        Ok(Picture { span: run.span, titles, bodies: run.strained(None, &run.snapshot(frame)?), band: None })
    };
    let pictures: Vec<Picture> =
        chosen(runs, |index| Some(picture(&runs.all[index]))).into_iter().collect::<Result<_, _>>()?;
    let upper = round_up(pictures.iter().map(|picture| nearly_largest(&picture.bodies)).fold(0.0, f64::max));
    let colours = Colours { upper, unit: 1.0, words: "deviatoric strain |e\u{2032}| since the start" };
    let json: Vec<Value> = runs.all.iter().map(|run| json!({ "run": run.label, "strain": end })).collect();
    Ok(Part {
        figures: vec![Drawn {
            name: "compare_strain",
            drawing: draw("compare-strain", &pictures, &colours, "Deviatoric strain of all runs since the start"),
            caption: format!(
                "The material at {} of {}, coloured by deviatoric strain since each body began (Chen et al. 2021, figure 16): \
                 Cundall's best fit over Delaunay neighbours, points and grains apart. Outlined: the rim, in which both live.",
                percent(end),
                runs.press.strain_words()
            ),
        }],
        json: Value::Array(json),
        ..Part::default()
    })
}
