//! What happened to a run, in sentences and in tables.

use serde_json::{Map, Value};

use super::numbers::{THIN, interval, kilopascal, percent, plain, relative, significant, time, with_unit};
use super::parts::{bands, stress};
use crate::analysis::drive::Measure;
use crate::analysis::measures::Measures;
use crate::analysis::measures::disturbance::{Disturbance, STRAIN_DISTURBED, STRAIN_SETTLED};
use crate::analysis::run::Run;
use crate::analysis::snapshot::Kind;
use crate::base::error::Error;

/// Runs that a title names.
const TITLE_NAMES: usize = 4;
const AXES: [&str; 3] = ["x", "y", "z"];

/// A table with a column for every run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    pub rows: Vec<(String, Vec<String>)>,
}

impl Table {
    /// Adds a row unless it is empty for every run.
    pub fn row(&mut self, name: &str, cells: Vec<Option<String>>) {
        if cells.iter().any(Option::is_some) {
            let cells = cells.into_iter().map(|cell| cell.unwrap_or_else(|| "\u{2013}".to_owned()));
            self.rows.push((name.to_owned(), cells.collect()));
        }
    }
}

/// What happened, in one paragraph: of every run what its columns and its measures tell.
pub fn paragraph(run: &Run, measures: Option<&Measures>, index: usize) -> Result<String, Error> {
    let mut words = beginning(run)?;
    let disturbed = measures.and_then(|measures| measures.disturbed(index));
    match disturbed {
        Some(found) => words += &enrichment(run, &found.by),
        None if run.begins_as_grains() => words += &rest(run),
        None if run.is("hybrid") && run.cut().is_none() => {
            words +=
                " No persistent shear band was found, so no grains were inserted: the specimen stayed a continuum.";
        }
        None => {}
    }
    if let Some(level) = measures.and_then(|measures| measures.level(index)) {
        let stress = run.drive.stress.as_ref().map_or("stress", |stress| &stress.words);
        words += &format!(
            " The moving average of {stress} peaked at {} at a strain of {}; the run ended at a strain of {} with {}",
            kilopascal(level.peak_pa),
            percent(level.peak_strain),
            percent(level.strain_end),
            kilopascal(level.stress_end_pa),
        );
        words += &match level.volume_strain_end {
            Some(volume) => format!(" and a volume strain of {}.", super::numbers::change(volume)),
            None => ".".to_owned(),
        };
        if let Some(told) = stress::spread(level) {
            words += &format!(
                " Over the second half of the run the normal stress was {told} (mean and standard deviation of the rows)."
            );
        }
    }
    words += &at_the_end(run)?;
    words += &measures.and_then(|measures| bands::told(measures, index)).unwrap_or_default();
    Ok(words)
}

/// Of a run that began as grains, what has become of those that rest.
fn rest(run: &Run) -> String {
    let Some(row) = run.rested() else {
        return " All of it was grains to the end: none beside a band rested for long enough and bore little enough to turn into points."
            .to_owned();
    };
    let time = run.column("time")[row];
    let at = match run.drive.measure {
        Measure::Strain if !run.drive.turns_back => format!("{} of {}", percent(run.at(time)), run.drive.words),
        _ => format!("t = {}{THIN}s", plain(time, 3)),
    };
    let end = |name: &str| run.column(name).last().copied().unwrap_or_default();
    format!(
        " All of it was grains to {at}, where the first that rested beside the band turned into points: {} grains and {} points at the end.",
        end("grains"),
        end("points"),
    )
}

fn beginning(run: &Run) -> Result<String, Error> {
    let bodies = run.snapshot(0)?.bodies;
    let count = |kind: Kind| bodies.iter().filter(|body| body.kind == kind).count();
    let (points, grains) = (count(Kind::Point), count(Kind::Grain));
    let is_plane = run.dimension() == 2;
    if run.scenario.contains_key("cell") {
        let kind = if is_plane { "discs" } else { "spheres" };
        let [grains, end] = ["grains", "time"].map(|column| run.last(column).unwrap_or(0.0));
        return Ok(format!("{grains:.0} {kind} in a cell for {}.", time(end)));
    }
    let material = match (points, grains) {
        (0, grains) => format!("{grains} grains"),
        (points, 0) => format!("a continuum of {points} points"),
        (points, grains) => format!("{points} points and {grains} grains"),
    };
    if run.period() > 0.0 {
        let speed = run.number("loading.speed").map(|speed| format!(" at {}{THIN}cm/s", plain(100.0 * speed, 3)));
        let stress = run.number("loading.stress_normal").or_else(|| run.number("loading.normal_stress"));
        let stress = stress.map(|stress| format!(" under a normal stress of {}", kilopascal(stress)));
        let [speed, stress] = [speed, stress].map(Option::unwrap_or_default);
        return Ok(format!("The specimen began as {material} between rough plates and was sheared{speed}{stress}."));
    }
    let kind = if is_plane { "in plane strain" } else { "in space" };
    let law = run.value("material.law").and_then(toml::Value::as_str).unwrap_or("its law").replace('_', " ");
    Ok(format!(
        "The material began as {material} {kind} ({law}); the run is of {}.",
        time(run.last("time").unwrap_or(0.0))
    ))
}

fn enrichment(run: &Run, by: &Disturbance) -> String {
    let rows = by.rows_averaged;
    let grains = run.column("grains");
    let grains = run.cut().map_or(0.0, |row| grains[row] - grains[0]);
    let mut words = format!(
        " At {} of {} (t = {}{THIN}s) a persistent shear band was found and {:.0} grains took the place of points in and around \
         it. The stress was {} in the {rows} rows before. Over the next {} of strain its moving average did not fall below {} ({}) \
         and no single row was above {} ({}).",
        percent(by.strain),
        run.drive.words,
        plain(by.time_s, 3),
        grains,
        kilopascal(by.before_pa),
        percent(STRAIN_DISTURBED),
        kilopascal(by.lowest_average_pa),
        relative(by.lowest_average_pa, by.before_pa),
        kilopascal(by.highest_row_pa),
        relative(by.highest_row_pa, by.before_pa),
    );
    if let Some(settled) = by.settled_pa {
        words += &format!(
            " From {} of strain after enrichment it averaged {} ({}).",
            interval([STRAIN_DISTURBED, STRAIN_SETTLED]),
            kilopascal(settled),
            relative(settled, by.before_pa),
        );
        words += &match by.strain_until_recovered {
            Some(0.0) => " The average never fell below 90\u{2009}% of that level.".to_owned(),
            Some(strain) => format!(
                " After its dip the average was back at 90\u{2009}% of that level {} of strain after enrichment.",
                percent(strain)
            ),
            None => " After its dip the average did not come back to 90\u{2009}% of that level.".to_owned(),
        };
    }
    words
}

/// What columns and the last frame tell of the end.
fn at_the_end(run: &Run) -> Result<String, Error> {
    let axes = &AXES[..run.dimension()];
    let last = |column: &str| run.last(column);
    if let (Some(fraction), Some(contacts)) = (last("fraction"), last("contacts_of_a_grain")) {
        let stress = |axis: &&str| significant(-1e-3 * last(&format!("stress_{axis}{axis}")).unwrap_or(f64::NAN), 3);
        return Ok(format!(
            " At the end the solid volume fraction is {}, a grain has {} contacts, and the normal stresses of the contacts are {} kPa \
             (compression positive) along {}.",
            significant(fraction, 4),
            significant(contacts, 3),
            axes.iter().map(stress).collect::<Vec<_>>().join(", "),
            axes.join(", "),
        ));
    }
    if run.column("lower_x").is_empty() {
        return Ok(String::new());
    }
    let moved = |axis: &&str| {
        let centre = run.column(&format!("centre_{axis}"));
        let way = last(&format!("centre_{axis}")).unwrap_or(f64::NAN) - centre.first().copied().unwrap_or(f64::NAN);
        way * way
    };
    let extent = |axis: &&str| {
        let end = |end: &str| significant(last(&format!("{end}_{axis}")).unwrap_or(f64::NAN), 3);
        format!("{} to {}\u{2009}m along {axis}", end("lower"), end("upper"))
    };
    let bodies = run.snapshot(run.frame_times.len() - 1)?.bodies;
    let what = if run.has_grains() { "deviatoric" } else { "plastic" };
    let strain = bodies.iter().map(|body| if run.has_grains() { body.deviatoric } else { body.plastic });
    let yielded = match strain.fold(0.0, f64::max) {
        strain if strain > 0.0 => format!("the largest {what} strain is {}", significant(strain, 3)),
        _ => "no point has yielded".to_owned(),
    };
    let grains = last("grains").map_or_else(String::new, |grains| format!("{grains:.0} grains and "));
    Ok(format!(
        " At the end there are {grains}{:.0} points, their centre of mass has moved by {}\u{2009}m since the first row of the series, \
         the material reaches from {}, and {yielded}.",
        last("points").unwrap_or(0.0),
        significant(axes.iter().map(moved).sum::<f64>().sqrt(), 3),
        axes.iter().map(extent).collect::<Vec<_>>().join(", "),
    ))
}

/// The scenario's main figures: path, name, factor from SI, unit.
const SCENARIO: [(&str, &str, f64, &str); 37] = [
    ("specimen.width", "Width (period)", 1e3, "mm"),
    ("specimen.height", "Height aimed at", 1e3, "mm"),
    ("specimen.depth", "Out-of-plane depth", 1e3, "mm"),
    ("grains.diameter_mean", "Mean grain diameter D\u{2085}\u{2080}", 1e3, "mm"),
    ("grains.diameter_deviation", "Standard deviation of diameters", 1e3, "mm"),
    ("grains.density", "Density of the solid", 1.0, "kg/m\u{b3}"),
    ("contact.stiffness_normal", "Normal stiffness k_n", 1.0, "N/m"),
    ("contact.stiffness_tangential", "Tangential stiffness k_t", 1.0, "N/m"),
    ("contact.damping_normal", "Normal damping \u{3b3}_n", 1.0, "N\u{2009}s/m"),
    ("contact.damping_tangential", "Tangential damping \u{3b3}_t", 1.0, "N\u{2009}s/m"),
    ("contact.friction", "Friction coefficient", 1.0, ""),
    ("continuum.cell", "Grid cell", 1e3, "mm"),
    ("grid.cell", "Grid cell", 1e3, "mm"),
    ("grid.depth", "Out-of-plane depth", 1e3, "mm"),
    ("scheme.points_per_cell", "Points along a cell", 1.0, ""),
    ("material.bulk_modulus", "Bulk modulus K", 1e-6, "MPa"),
    ("material.shear_modulus", "Shear modulus G", 1e-6, "MPa"),
    ("material.friction_angle_critical", "Critical friction angle", 180.0 / std::f64::consts::PI, "\u{b0}"),
    ("material.fraction_critical", "Critical solid volume fraction", 1.0, ""),
    ("material.dilation_factor", "Dilation factor \u{3c7}", 1.0, ""),
    ("material.softening_rate", "Softening rate \u{3be}", 1.0, ""),
    ("material.hardening_strain", "Hardening strain a", 1.0, ""),
    ("material.hardening_start", "Friction mobilised from the start \u{3ba}\u{2080}", 1.0, ""),
    ("material.cohesion", "Cohesion", 1e-3, "kPa"),
    ("packing.stress", "Stress of the packing", 1e-3, "kPa"),
    ("loading.stress_normal", "Normal stress", 1e-3, "kPa"),
    ("loading.speed", "Speed of the upper plate", 1e2, "cm/s"),
    ("loading.strain_end", "Horizontal strain at the end", 1e2, "%"),
    ("oracle.participation", "Oracle, participation P", 1.0, ""),
    ("oracle.contrast", "Oracle, contrast \u{3be}", 1.0, ""),
    ("oracle.laplacian", "Oracle, c\u{2080}", 1.0, ""),
    ("oracle.recent_strain", "Oracle, c\u{2081}", 1.0, ""),
    ("enrichment.distance", "Enrichment distance \u{3c6}\u{2080}", 1e3, "mm"),
    ("enrichment.weight", "Weight of grains in the rim", 1.0, ""),
    ("enrichment.training", "Share of training", 1.0, ""),
    ("time.end", "End", 1.0, "s"),
    ("time.step", "Time step", 1.0, "s"),
];

/// The main figures of the scenarios, a column for every run.
pub fn scenario(runs: &[Run]) -> Table {
    let mut table = Table::default();
    let method = |run: &Run| Some(run.method.clone()).filter(|method| !method.is_empty());
    table.row("Method", runs.iter().map(method).collect());
    for (path, name, factor, unit) in SCENARIO {
        let cell = |run: &Run| Some(with_unit(&plain(factor * run.number(path)?, 4), unit));
        table.row(name, runs.iter().map(cell).collect());
    }
    table
}

/// All of the summaries, a column for every run; what lies in tables of a summary has their names before its own.
pub fn summary(runs: &[Run]) -> Table {
    let summaries: Vec<Vec<(String, String)>> = runs.iter().map(|run| flat("", &run.summary)).collect();
    let mut keys: Vec<&String> = Vec::new();
    for (key, _) in summaries.iter().flatten() {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let mut table = Table::default();
    for key in keys {
        let cell = |of: &Vec<(String, String)>| of.iter().find(|(own, _)| own == key).map(|(_, told)| told.clone());
        table.row(key, summaries.iter().map(cell).collect());
    }
    table
}

fn flat(above: &str, of: &Map<String, Value>) -> Vec<(String, String)> {
    let told = |value: &Value| match value {
        Value::String(words) => words.clone(),
        Value::Number(number) if number.is_f64() => plain(number.as_f64().unwrap_or(f64::NAN), 5),
        Value::Bool(is_so) => if *is_so { "yes" } else { "no" }.to_owned(),
        Value::Null => "\u{2013}".to_owned(),
        other => other.to_string(),
    };
    let entry = |(key, value): (&String, &Value)| {
        let name = format!("{above}{}", key.replace('_', " "));
        match value {
            Value::Object(below) => flat(&format!("{name}: "), below),
            Value::Array(list) if list.iter().all(Value::is_object) => {
                let below = list.iter().zip(1..).filter_map(|(value, number)| Some((value.as_object()?, number)));
                below.flat_map(|(below, number)| flat(&format!("{name} {number}: "), below)).collect()
            }
            Value::Array(list) => vec![(name, list.iter().map(told).collect::<Vec<_>>().join(", "))],
            Value::Null => Vec::new(),
            value => vec![(name, told(value))],
        }
    };
    of.iter().flat_map(entry).collect()
}

/// The title of a report.
pub fn title(runs: &[Run]) -> String {
    let names: Vec<String> = runs.iter().map(Run::label).collect();
    match names.as_slice() {
        [name] => name.clone(),
        many if many.len() > TITLE_NAMES => format!("{} runs compared", many.len()),
        _ => format!("{} compared", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::columns::Column;

    /// A hybrid that was grains from the start was said to have stayed a continuum.
    #[test]
    fn a_run_that_begins_as_grains_says_what_has_become_of_them() {
        let mut run = Run::made("method = \"hybrid\"\n[zone]\nbegins = \"everywhere\"");
        run.drive.values = vec![0.0, 0.05, 0.1];
        let mut with = |points: [f64; 3]| {
            let column = |name: &str, values: [f64; 3]| Column { name: name.into(), values: values.to_vec() };
            run.columns = vec![
                column("time", [0.0, 1.0, 2.0]),
                column("points", points),
                column("grains", [500.0, 500.0 - points[1], 500.0 - points[2]]),
            ];
            (run.begins_as_grains(), rest(&run))
        };
        let (begins, told) = with([0.0, 0.0, 0.0]);
        assert!(begins && told.contains("grains to the end"), "{told}");
        let (begins, told) = with([0.0, 0.0, 40.0]);
        assert!(begins && told.contains("t = 2") && told.contains("460 grains and 40 points"), "{told}");
        assert!(!Run::made("method = \"hybrid\"\n[zone]\nbegins = \"band\"").begins_as_grains());
    }

    #[test]
    fn tables_leave_out_what_no_run_has_and_print_no_json() {
        let mut run = Run::made("method = \"dem\"\n[specimen]\nwidth = 0.06\n[time]\nstep = 4e-7");
        run.summary =
            serde_json::from_str(r#"{"ranks": 2, "mass": {"end": 0.25, "by": [1, 2.5]}, "none": null}"#).unwrap();
        let runs = [run];
        let rows = scenario(&runs).rows;
        assert_eq!(rows[1], ("Width (period)".to_owned(), vec!["60\u{2009}mm".to_owned()]));
        assert_eq!(rows[2].1[0], "4\u{2009}\u{d7}\u{2009}10\u{207b}\u{2077}\u{2009}s");
        let told: Vec<String> =
            summary(&runs).rows.iter().map(|(name, cells)| format!("{name} = {}", cells[0])).collect();
        assert_eq!(told, ["mass: by = 1, 2.5", "mass: end = 0.25", "ranks = 2"]);
    }
}
