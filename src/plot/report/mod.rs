//! `scree report DIR...`: one HTML file that opens without a network, and its drawings as SVG files beside it.
//!
//! Everything comes from what the runs left on disk. Several directories make a comparison: curves over each other, the
//! specimens below each other at equal strains.

use std::fs;
use std::path::{Path, PathBuf};

use crate::analysis::calibrate::Calibration;
use crate::analysis::calibrate::Subject;
use crate::base::error::Error;
use crate::bench::scaling::Scaling;
use crate::job::schema::Kind;
use crate::run::results::{Results, unwritable};

mod assembly;
mod calibration;
mod chart;
mod colour;
mod compare;
mod continuum;
mod contour;
mod figures;
mod findings;
mod load;
mod page;
mod panels;
mod records;
mod scaling;
mod scenes;
mod span;
mod svg;
#[cfg(test)]
mod tests;
mod told;
mod words;

use compare::Comparison;
use figures::Found;
use findings::Findings;
use load::Run;
use page::Drawings;
use panels::Told;
use records::Record;
use scenes::{Scenes, Timing, enriched_frame};
use words::Story;

/// Width of every drawing, pixels.
const WIDTH: f64 = 900.0;

/// Writes the report on the runs in `dirs` to `out`, or to `report.html` in the first of them; returns where it is.
/// The drawings go to `figures/` beside it, and the paragraph that says what happened to a text file of the same name.
/// Several runs of planar shear, or of a body that presses on grains and points, are compared, their incremental strains
/// `between` two strains, and what was measured goes to `comparison.json` beside the page.
pub fn write(dirs: &[PathBuf], out: Option<&Path>, between: Option<[f64; 2]>) -> Result<PathBuf, Error> {
    let Some(first) = dirs.first() else {
        return Err(Error::User("A report needs the directory of a run: `scree report runs/NAME`.".to_owned()));
    };
    for kind in [Kind::Assembly, Kind::Mpm] {
        if dirs.iter().any(|directory| is_of(directory, kind)) {
            return write_sections(dirs, first, (out, between), kind);
        }
    }
    let mut runs = dirs.iter().map(|directory| Run::read(directory)).collect::<Result<Vec<_>, _>>()?;
    tell_apart(runs.iter_mut().map(|run| (&mut run.name, &*run.directory)));
    let findings: Vec<Findings> = runs.iter().map(Findings::of).collect();
    let enriched = runs.iter().map(enriched_frame).collect::<Result<Vec<_>, _>>()?;
    let pairs: Vec<(&Run, Option<usize>)> = runs.iter().zip(enriched).collect();
    let timing = Timing::of(&pairs);
    let told: Vec<_> = pairs.iter().zip(&findings).map(|(&(run, frame), findings)| (run, findings, frame)).collect();
    let comparison = Comparison::of(&told, between)?;
    let scenes = pairs.iter().map(|&(run, frame)| Scenes::of(run, &timing, frame)).collect::<Result<Vec<_>, _>>()?;

    let found: Vec<Found> = runs.iter().zip(&findings).map(|(run, findings)| Found { run, findings }).collect();
    let told: Vec<Told> = runs.iter().zip(&scenes).map(|(run, scenes)| Told { run, scenes }).collect();
    let drawings = Drawings {
        shear_stress: figures::shear_stress(&found, WIDTH),
        volume: figures::volume(&found, WIDTH),
        specimen: panels::draw(&told, WIDTH),
        energies: figures::energies(&found, WIDTH),
    };
    let stories: Vec<Story> = runs
        .iter()
        .zip(&findings)
        .zip(&scenes)
        .map(|((run, findings), scenes)| Story { run, findings, scenes })
        .collect();

    let mut sheaf = Sheaf::at(first, out);
    for (name, drawing) in drawings.files() {
        sheaf.add_drawing(name, drawing);
    }
    let mut text = words::plain_text(&stories);
    if let Some(comparison) = &comparison {
        text = sheaf.add_comparison(comparison) + &text;
    }
    sheaf.finish(&page::page(&stories, &drawings, comparison.as_ref()), Some(&text))
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
    let mut json = scaling.to_json();
    json["program"] = crate::base::program::identity().into();
    sheaf.results.add(out.join("scaling.json"), &format!("{json:#}\n"));
    drawings.iter().for_each(|(name, drawing)| sheaf.add_drawing(&format!("{name}.svg"), drawing));
    sheaf.finish(&scaling::page(scaling, &drawings), None)
}

/// Writes `calibration.html` with what `scree calibrate` found into a folder with other `results`, its drawings to `figures/`
/// beside it; returns where the page is.
pub fn write_calibration(
    calibration: &Calibration,
    (subject, command): (&Subject, &str),
    out: &Path,
    results: Results,
) -> Result<PathBuf, Error> {
    let drawings = calibration::drawings(calibration);
    let mut sheaf = Sheaf { results, ..Sheaf::of(out.join("calibration.html")) };
    drawings.iter().for_each(|(name, drawing)| sheaf.add_drawing(&format!("{name}.svg"), drawing));
    sheaf.finish(&calibration::page(calibration, subject, command, &drawings), None)
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

    /// A comparison's drawings and its figures; returns its paragraph for the text file.
    fn add_comparison(&mut self, comparison: &Comparison) -> String {
        for drawn in comparison.parts.iter().flat_map(|part| &part.figures) {
            self.add_drawing(&format!("{}.svg", drawn.name), &drawn.drawing);
        }
        let mut json = comparison.json.clone();
        json["program"] = crate::base::program::identity().into();
        self.results.add(self.page.with_file_name("comparison.json"), &format!("{json:#}\n"));
        format!("{}\n\n", words::plain_letters(&comparison.paragraph()))
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

/// Whether a directory holds a run of that kind of job.
fn is_of(directory: &Path, kind: Kind) -> bool {
    kind.mark().is_some_and(|table| records::has_table(directory, table))
}

/// The same of grains in cells or of continua: every run has its own pictures and curves, below each other; those of one
/// specimen in which a body presses on grains are compared first.
fn write_sections(
    dirs: &[PathBuf],
    first: &Path,
    (out, between): (Option<&Path>, Option<[f64; 2]>),
    kind: Kind,
) -> Result<PathBuf, Error> {
    if let Some(other) = dirs.iter().find(|directory| !is_of(directory, kind)) {
        return Err(Error::User(format!(
            "{} is no run of {}, and another of these directories is; make a report of either kind by itself.",
            other.display(),
            if kind == Kind::Assembly { "grains in a cell" } else { "a continuum on a grid" }
        )));
    }
    let mut records = dirs.iter().map(|directory| Record::read(directory)).collect::<Result<Vec<_>, _>>()?;
    tell_apart(records.iter_mut().map(|record| (&mut record.name, &*record.directory)));
    let comparison = Comparison::of_pressed(&records.iter().collect::<Vec<_>>(), between)?;
    let told = |record: Record| -> Result<(Record, String, Vec<page::Figure>), Error> {
        match kind {
            Kind::Assembly => {
                let run = assembly::Run::new(record);
                let mut figures = vec![("grains", run.picture()?, page::GRAINS_CAPTION)];
                figures.extend(run.curves());
                let words = run.words();
                Ok((run.record, words, figures))
            }
            _ => {
                let run = continuum::Run::new(record);
                let (words, figures) = run.told()?;
                Ok((run.record, words, figures))
            }
        }
    };
    let told = records.into_iter().map(told).collect::<Result<Vec<_>, Error>>()?;
    let mut sheaf = Sheaf::at(first, out);
    let mut sections = Vec::new();
    for (index, (record, words, figures)) in told.iter().enumerate() {
        let number = if told.len() > 1 { format!("_{}", index + 1) } else { String::new() };
        for (name, drawing, _) in figures {
            sheaf.add_drawing(&format!("{name}{number}.svg"), drawing);
        }
        sections.push(page::Section { record, words: words.clone(), figures: figures.clone() });
    }
    let lines: Vec<String> = told.iter().map(|(record, words, _)| format!("{}: {words}", record.name)).collect();
    let mut text = lines.join("\n\n") + "\n";
    if let Some(comparison) = &comparison {
        text = sheaf.add_comparison(comparison) + &text;
    }
    sheaf.finish(&page::sections(&sections, comparison.as_ref()), Some(&text))
}

/// Runs of the same name are told apart by their directories.
fn tell_apart<'a>(runs: impl Iterator<Item = (&'a mut String, &'a Path)>) {
    let mut runs: Vec<_> = runs.collect();
    let names: Vec<String> = runs.iter().map(|(name, _)| (*name).clone()).collect();
    for (name, directory) in &mut runs {
        if names.iter().filter(|other| *other == *name).count() > 1 {
            let last = directory.file_name().map(|last| last.to_string_lossy().into_owned());
            **name = last.unwrap_or_else(|| directory.display().to_string());
        }
    }
}
