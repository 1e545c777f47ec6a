//! Volume strain of the whole, where membranes enclose it, and of the band alone (Chen et al. 2021, figures 17 and 20).

use serde_json::{Value, json};

use super::Runs;
use super::bands::Bands;
use super::load_curve::{axis, legend, stroke};
use super::run::Run;
use super::space::Spaces;
use crate::cli::report::WIDTH;
use crate::cli::report::chart::{Axis, Chart, Curve, percent, side_by_side};
use crate::cli::report::compare::{Drawn, Part, Sheet, share};
use crate::cli::report::figures::{HEIGHT, places, start};
use crate::cli::report::load::linear;
use crate::error::Error;

/// Volume strain of the bodies in a run's band, at frames from the last enrichment on.
struct OfBand {
    strain: Vec<f64>,
    volume: Vec<f64>,
}

impl OfBand {
    fn of(run: &Run, bands: &Bands, index: usize, from: f64) -> Result<Option<Self>, Error> {
        let Some(measured) = &bands.of[index] else { return Ok(None) };
        let members = measured.members();
        let first = run.frame_at(from).max(run.enriched.unwrap_or(0));
        let start = run.snapshot(first)?;
        let start = Spaces::of(&start, &run.span);
        let mut curve = Self { strain: vec![run.strain_of(first)], volume: vec![0.0] };
        for frame in first + 1..run.frames() {
            if let Some(swelling) = Spaces::of(&run.snapshot(frame)?, &run.span).swelling(&start, &members) {
                curve.strain.push(run.strain_of(frame));
                curve.volume.push(swelling);
            }
        }
        Ok((!members.is_empty() && curve.strain.len() > 1).then_some(curve))
    }
}

pub fn part(runs: &Runs, bands: &Bands) -> Result<Part, Error> {
    let from = runs.all.iter().filter_map(Run::enriched_strain).fold(0.0, f64::max);
    let of_band = |(index, run): (usize, &Run)| OfBand::of(run, bands, index, from);
    let of_bands = runs.all.iter().enumerate().map(of_band).collect::<Result<Vec<_>, _>>()?;
    let is_enclosed = runs.all.iter().all(|run| run.volume.is_some());
    let mut left_out = Vec::new();
    if !is_enclosed {
        left_out.push("Volume strain of the whole is left out: no membranes enclose it.".to_owned());
    }
    if of_bands.iter().all(Option::is_none) {
        left_out.push("Volume strain of bands is left out: none was measured.".to_owned());
        if !is_enclosed {
            return Ok(Part { left_out, ..Part::default() });
        }
    }
    let end = runs.all.iter().map(Run::strain_end).fold(f64::INFINITY, f64::min);
    let [first, last] = bands.between.clone().unwrap_or([0.5 * end, end]);
    let strains = [first, last, end];
    let json = |(run, of_band): (&Run, &Option<OfBand>)| {
        json!({
            "run": run.label, "seed": run.seed, "strains": strains,
            "volume_strain": strains.map(|strain| whole_at(run, strain)),
            "band_since_strain": of_band.as_ref().map(|curve| curve.strain[0]),
            "volume_strain_band": of_band.as_ref().map(|curve| strains.map(|strain| at(curve, strain))),
        })
    };
    Ok(Part {
        sentences: Vec::new(),
        figures: vec![drawing(runs, &of_bands, is_enclosed, from)],
        sheets: vec![sheet(runs, &of_bands, strains)],
        left_out,
        json: Value::Array(runs.all.iter().zip(&of_bands).map(json).collect()),
    })
}

fn whole_at(run: &Run, strain: f64) -> Option<f64> {
    linear(&run.strain, run.volume.as_ref()?, strain)
}

/// Held beyond the last frame, which may come a little before the last row.
fn at(curve: &OfBand, strain: f64) -> Option<f64> {
    let last = curve.strain[curve.strain.len() - 1];
    linear(&curve.strain, &curve.volume, strain.min(last))
}

fn sheet(runs: &Runs, of_bands: &[Option<OfBand>], strains: [f64; 3]) -> Sheet {
    let mut sheet = Sheet::new(
        "Volume strain, of the whole and of the band since the last enrichment, at three strains",
        &["strains", "of the whole", "of the band"],
    );
    for (run, of_band) in runs.all.iter().zip(of_bands) {
        let told = |of: &dyn Fn(f64) -> Option<f64>| {
            let told: Option<Vec<String>> = strains.iter().map(|&strain| of(strain).map(share)).collect();
            told.map(|told| told.join(", "))
        };
        let (whole, band) = (told(&|strain| whole_at(run, strain)), told(&|strain| at(of_band.as_ref()?, strain)));
        let at = (whole.is_some() || band.is_some()).then(|| strains.map(percent).join(", "));
        sheet.row(&run.label, vec![at, whole, band]);
    }
    sheet
}

fn drawing(runs: &Runs, of_bands: &[Option<OfBand>], is_enclosed: bool, from: f64) -> Drawn {
    let (mut svg, top) = start("compare-volume", WIDTH, &legend(runs));
    let curve = |(index, run): (usize, &Run), strain: &[f64], volume: &[f64]| Curve {
        places: places(strain, volume, 0.01, None),
        stroke: stroke(&runs.groups, run.group, index),
    };
    let all = || runs.all.iter().enumerate();
    let whole = all().filter_map(|(index, run)| Some(curve((index, run), &run.strain, run.volume.as_ref()?)));
    let of_band = all().filter_map(|(index, run)| {
        let found = of_bands[index].as_ref()?;
        Some(curve((index, run), &found.strain, &found.volume))
    });
    let charts = [
        ("(a) of the whole", whole.collect::<Vec<_>>(), is_enclosed),
        ("(b) of the band", of_band.collect(), of_bands.iter().any(Option::is_some)),
    ];
    let charts: Vec<_> = charts.into_iter().filter(|(.., is_there)| *is_there).collect();
    let frames = side_by_side(charts.len(), WIDTH, top, HEIGHT);
    let several = charts.len() > 1;
    for ((title, curves, _), frame) in charts.into_iter().zip(frames) {
        let values = curves.iter().flat_map(|curve| &curve.places).map(|place| place[1]).collect::<Vec<f64>>();
        let chart = Chart {
            title: if several { title.to_owned() } else { title[4..].to_owned() },
            x: axis(runs),
            y: Axis::around("volume strain (%)", values.into_iter().chain([0.0])),
            curves,
            moments: Vec::new(),
            levels: Vec::new(),
        };
        chart.draw(&mut svg, frame);
    }
    Drawn {
        name: "compare_volume",
        drawing: svg.finish("Volume strain of the whole and of the band against the way of the body that presses"),
        caption: format!(
            "Volume strain, positive in dilation (Chen et al. 2021, figure 17): of what membranes enclose, since the first row, \
             and of the bodies that lie in the band of the figure before, since {} of strain, by the space that they fill: of \
             grains a third of every triangle between neighbours, of points their volume.",
            percent(from)
        ),
    }
}
