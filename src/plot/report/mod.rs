//! `scree report DIR...`: one HTML file that opens without a network, and its drawings as SVG files beside it.
//!
//! Everything comes from what the runs left on disk ([`crate::analysis`] has the numbers). Several directories make a comparison:
//! curves over each other, specimens below each other at equal strains, whatever jobs they are of. The directory of a sweep stands for
//! its runs.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::analysis::calibrate::Calibration;
use crate::analysis::calibrate::Subject;
use crate::analysis::calibrate::mobilised::Calibration as CalibrationMobilised;
use crate::analysis::measures::Measures;
use crate::analysis::run::Run;
use crate::analysis::sweep;
use crate::base::error::Error;
use crate::bench::scaling::Scaling;
use crate::run::results::{Results, unwritable};

mod calibration;
mod calibration_mobilised;
mod chart;
mod colour;
mod contour;
mod followed;
mod mohr;
mod numbers;
mod page;
mod panels;
mod parts;
mod pictures;
mod profiles;
mod scaling;
mod scenes;
mod svg;
#[cfg(test)]
mod tests;
mod words;

/// Width of every drawing, pixels.
const WIDTH: f64 = 900.0;

/// A drawing with its caption; the name is that of its file.
pub struct Drawn {
    /// Without `.svg`.
    pub name: String,
    /// A whole SVG element.
    pub drawing: String,
    /// Plain text.
    pub caption: String,
}

/// Writes the report on the runs in `dirs` to `out`, or to `report.html` in the first of them; returns where it is.
/// The drawings go to `figures/` beside it, and the paragraph that says what happened to a text file of the same name.
/// Bands, and of bodies that press differences of stresses, are measured `between` two strains; what is measured of several runs
/// goes to `comparison.json` beside the page.
pub fn write(dirs: &[PathBuf], out: Option<&Path>, between: Option<[f64; 2]>) -> Result<PathBuf, Error> {
    let Some(first) = dirs.first() else {
        return Err(Error::User("A report needs the directory of a run: `scree report runs/NAME`.".to_owned()));
    };
    let mut runs =
        sweep::with_rows(dirs)?.iter().map(|directory| Run::read(directory)).collect::<Result<Vec<_>, _>>()?;
    tell_apart(&mut runs);
    let measures = Measures::of(&runs, between)?;
    if let (Err(why), Some(_)) = (&measures, between) {
        return Err(Error::User(format!("Nothing can be measured between strains: {why}. Leave --between away.")));
    }
    let (parts, json) = match &measures {
        Ok(measures) => (parts::all(measures)?, measures.json()),
        Err(why) => {
            let why = format!("Nothing is compared: {why}.");
            let json = json!({ "runs": [], "left_out": { "load_curve": [why] } });
            (vec![parts::Part { left_out: vec![why], ..parts::Part::default() }], json)
        }
    };
    let measures = measures.ok();
    let mut figures = Vec::new();
    for (number, set) in alike(&runs).into_iter().enumerate() {
        let number = if number > 0 { format!("_{}", number + 1) } else { String::new() };
        let own: Vec<&Run> = set.iter().map(|&index| &runs[index]).collect();
        figures.extend(scenes::figures(&own, &number)?);
        let colour = |index: usize| match &measures {
            Some(measures) if has_single_groups(measures) => parts::colour_of(measures, index),
            _ => colour::line(index),
        };
        let coloured: Vec<_> = set.iter().map(|&index| (&runs[index], colour(index))).collect();
        figures.extend(panels::figures(&coloured, &number));
        figures.extend(profiles::figures(&coloured, &number)?);
        figures.extend(followed::figures(&own, &number)?);
    }
    let paragraph = |(index, run): (usize, &Run)| words::paragraph(run, measures.as_ref(), index);
    let paragraphs = runs.iter().enumerate().map(paragraph).collect::<Result<Vec<_>, _>>()?;
    let tells_why = runs.len() > 1 || between.is_some();
    let report = page::Report { runs: &runs, paragraphs, parts, figures, tells_why };

    let mut sheaf = Sheaf::at(first, out);
    let drawings = report.parts.iter().flat_map(|part| &part.figures).chain(&report.figures);
    drawings.for_each(|drawn| sheaf.add_drawing(&format!("{}.svg", drawn.name), &drawn.drawing));
    let mut told: Vec<String> = match report.paragraphs.as_slice() {
        [only] => vec![only.clone()],
        several => runs.iter().zip(several).map(|(run, words)| format!("{}. {words}", run.label())).collect(),
    };
    if runs.len() > 1 {
        sheaf.add_numbers("comparison.json", json);
        told.insert(0, report.findings());
    }
    sheaf.finish(&report.page(), Some(&(numbers::plain_letters(&told.join("\n\n")) + "\n")))
}

/// Whether every group has one run, so that colours of groups tell runs apart.
fn has_single_groups(measures: &Measures) -> bool {
    measures.among.groups.iter().all(|group| group.members.len() == 1)
}

/// Runs whose curves stand against the same and whose pictures show the same, by their numbers.
fn alike(runs: &[Run]) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let is_alike = |other: &Run| other.drive.words == run.drive.words && other.dimension() == run.dimension();
        match sets.iter_mut().find(|set| is_alike(&runs[set[0]])) {
            Some(set) => set.push(index),
            None => sets.push(vec![index]),
        }
    }
    sets
}

/// Two rising strains, as `--between 0.37,0.57` has them.
pub fn strains(text: &str) -> Result<[f64; 2], String> {
    let read = |part: &str| part.trim().parse::<f64>().ok().filter(|strain| strain.is_finite() && *strain >= 0.0);
    match text.split_once(',').map(|(from, to)| (read(from), read(to))) {
        Some((Some(from), Some(to))) if from < to => Ok([from, to]),
        _ => Err("two rising strains are wanted, such as 0.37,0.57".to_owned()),
    }
}

/// Writes `scaling.html` with what `scree bench scaling` measured into a folder, its drawings to `figures/` beside it and all
/// figures to `scaling.json`; returns where the page is.
pub fn write_scaling(scaling: &Scaling, out: &Path) -> Result<PathBuf, Error> {
    let drawings = scaling::drawings(scaling);
    let mut sheaf = Sheaf::of(out.join("scaling.html"));
    sheaf.add_numbers("scaling.json", scaling.to_json());
    drawings.iter().for_each(|(name, drawing)| sheaf.add_drawing(&format!("{name}.svg"), drawing));
    sheaf.finish(&scaling::page(scaling, &drawings), None)
}

/// The page of a calibration.
pub const CALIBRATION: &str = "calibration.html";

/// Writes [`CALIBRATION`] with what `scree calibrate` found into a folder with other `results`, its drawings to `figures/`
/// beside it; returns where the page is.
pub fn write_calibration(
    calibration: &Calibration,
    (subject, command): (&Subject, &str),
    out: &Path,
    results: Results,
) -> Result<PathBuf, Error> {
    let drawings = calibration::drawings(calibration);
    let mut sheaf = Sheaf { results, ..Sheaf::of(out.join(CALIBRATION)) };
    drawings.iter().for_each(|(name, drawing)| sheaf.add_drawing(&format!("{name}.svg"), drawing));
    sheaf.finish(&calibration::page(calibration, subject, command, &drawings), None)
}

/// The same of the law with mobilised friction.
pub fn write_calibration_mobilised(
    calibration: &CalibrationMobilised,
    (subject, command): (&Subject, &str),
    out: &Path,
    results: Results,
) -> Result<PathBuf, Error> {
    let drawings = calibration_mobilised::drawings(calibration);
    let mut sheaf = Sheaf { results, ..Sheaf::of(out.join(CALIBRATION)) };
    drawings.iter().for_each(|(name, drawing, _)| sheaf.add_drawing(&format!("{name}.svg"), drawing));
    sheaf.finish(&calibration_mobilised::page(calibration, subject, command, &drawings), None)
}

/// A page with all that lies beside it.
struct Sheaf {
    page: PathBuf,
    /// Whether the program has chosen the place itself.
    is_own_place: bool,
    results: Results,
}

impl Sheaf {
    /// At a place that was asked for, or in the folder of a run.
    fn at(first: &Path, out: Option<&Path>) -> Self {
        match out {
            Some(out) => Self::of(out.to_owned()),
            None => Self { is_own_place: true, ..Self::of(first.join("report.html")) },
        }
    }

    fn of(page: PathBuf) -> Self {
        Self { page, is_own_place: false, results: Results::default() }
    }

    fn add_drawing(&mut self, name: &str, drawing: &str) {
        self.results.add(self.folder().join(name), drawing);
    }

    /// The folder of the drawings.
    fn folder(&self) -> PathBuf {
        self.page.parent().unwrap_or(Path::new("")).join("figures")
    }

    /// A file of numbers beside the page, which says what wrote it.
    fn add_numbers(&mut self, name: &str, mut json: Value) {
        json["program"] = crate::base::program::identity().into();
        self.results.add(self.page.with_file_name(name), &format!("{json:#}\n"));
    }

    /// Writes everything, the page last; returns where it is.
    fn finish(mut self, page: &str, text: Option<&str>) -> Result<PathBuf, Error> {
        let folder = self.folder();
        fs::create_dir_all(&folder).map_err(|error| unwritable(&folder, &error))?;
        if let Some(text) = text {
            self.results.add(self.page.with_extension("txt"), text);
        }
        self.results.add(self.page.clone(), page);
        self.results.write(self.is_own_place)?;
        Ok(self.page)
    }
}

/// Runs of the same name are told apart by their directories.
fn tell_apart(runs: &mut [Run]) {
    let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
    for run in runs {
        if names.iter().filter(|other| **other == run.name).count() > 1 {
            let last = run.directory.file_name().map(|last| last.to_string_lossy().into_owned());
            run.name = last.unwrap_or_else(|| run.directory.display().to_string());
        }
    }
}
