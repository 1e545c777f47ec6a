//! What happened, in sentences and in tables.

use super::chart::{percent, significant};
use super::figures::label;
use super::findings::{Enrichment, Findings, STRAIN_DISTURBED, STRAIN_SETTLED, WINDOW};
use super::load::{Kind, Run, figure};
use super::scenes::{Scenes, Since};

/// A thin space between number and unit.
pub const THIN: &str = "\u{2009}";
pub const D50: &str = "D\u{2085}\u{2080}";
/// Runs that a title names.
const TITLE_NAMES: usize = 4;
/// A band thicker than this share of the specimen is none.
const LOCALISED: f64 = 0.5;
/// A box thinner than this share of a diameter holds one row.
const SINGLE_ROW: f64 = 1e-3;

/// A run with all that is said about it.
pub struct Story<'a> {
    pub run: &'a Run,
    pub findings: &'a Findings,
    pub scenes: &'a Scenes,
}

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

impl Story<'_> {
    /// What happened, in one paragraph.
    pub fn paragraph(&self) -> String {
        let mut words = self.beginning();
        match &self.findings.enrichment {
            Some(enrichment) => words += &self.enrichment(enrichment),
            None if self.run.method == "hybrid" => {
                words +=
                    " No persistent shear band was found, so no grains were inserted: the specimen stayed a continuum.";
            }
            None => {}
        }
        words += &format!(
            " The moving average of shear stress peaked at {} at a strain of {}; the run ended at a strain of {} \
             with {} and a volume strain of {}.",
            kilopascal(self.findings.peak.1),
            percent(self.findings.peak.0),
            percent(self.findings.strain_end),
            kilopascal(self.findings.shear_end),
            signed_percent(self.findings.volume_strain_end),
        );
        words += &self.normal();
        words += &self.band_words();
        words
    }

    fn beginning(&self) -> String {
        let first = self.scenes.scenes.first();
        let count =
            |kind: Kind| first.map_or(0, |scene| scene.bodies.iter().filter(|row| row.body.kind == kind).count());
        let material = match (count(Kind::Point), count(Kind::Grain)) {
            (0, grains) => format!("{grains} grains"),
            (points, 0) => format!("a continuum of {points} points"),
            (points, grains) => format!("{points} points and {grains} grains"),
        };
        let speed = figure(&self.run.scenario, "loading.speed")
            .map_or_else(String::new, |speed| format!(" at {}{THIN}cm/s", plain(100.0 * speed, 3)));
        let stress = self
            .run
            .stress_normal
            .map_or_else(String::new, |stress| format!(" under a normal stress of {}", kilopascal(stress)));
        format!("The specimen began as {material} between rough plates and was sheared{speed}{stress}.")
    }

    fn enrichment(&self, enrichment: &Enrichment) -> String {
        let series = &self.run.series;
        let grains = series.grains[enrichment.row] - series.grains[0];
        let mut words = format!(
            " At a horizontal strain of {} (t = {}{THIN}s) a persistent shear band was found and {grains:.0} grains \
             took the place of points in and around it. Shear stress was {} in the {WINDOW} rows before. Over the \
             next {} of strain its moving average did not fall below {} ({}) and no single row was above {} ({}).",
            percent(enrichment.strain),
            plain(enrichment.time, 3),
            kilopascal(enrichment.before),
            percent(STRAIN_DISTURBED),
            kilopascal(enrichment.lowest),
            relative(enrichment.lowest, enrichment.before),
            kilopascal(enrichment.highest),
            relative(enrichment.highest, enrichment.before),
        );
        if let Some(settled) = enrichment.settled {
            words += &format!(
                " From {} to {} of strain after enrichment it averaged {} ({}).",
                percent(STRAIN_DISTURBED),
                percent(STRAIN_SETTLED),
                kilopascal(settled),
                relative(settled, enrichment.before),
            );
            words += &match enrichment.recovery {
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

    fn normal(&self) -> String {
        let findings = self.findings;
        format!(
            " Over the second half of the run the normal stress was {} (mean and standard deviation of the rows).",
            spread(findings.normal_mean, findings.normal_deviation),
        )
    }

    fn band_words(&self) -> String {
        let Some(interval) = self.interval() else { return String::new() };
        let Some(band) = &self.scenes.band else {
            return format!(" {interval} strain did not gather in a band that could be measured.");
        };
        let height = self.scenes.heights[1] - self.scenes.heights[0];
        if band.thickness > LOCALISED * height {
            return format!(
                " {interval} the most strained 2\u{2009}% of the material were spread over {} {D50} of the specimen's \
                 {} {D50}: not a band.",
                plain(band.thickness / self.run.diameter, 2),
                plain(height / self.run.diameter, 2),
            );
        }
        let inside = self.scenes.inside.map_or_else(String::new, |share| {
            format!("; {} of its members lie between the lowest and the highest inserted grain", percent(share))
        });
        let above = plain((band.centre[1] - self.scenes.heights[0]) / self.run.diameter, 2);
        // The box holds places and not the points about them.
        if band.thickness < SINGLE_ROW * self.run.diameter {
            return format!(
                " {interval} strain gathered in a single row, {above} {D50} above the specimen's lower edge{inside}."
            );
        }
        format!(
            " {interval} strain gathered in a band {} {D50} ({}{THIN}mm) thick, centred {above} {D50} above the specimen's \
             lower edge{inside}.",
            in_diameters(band.thickness / self.run.diameter),
            plain(1e3 * band.thickness, 2),
        )
    }

    /// The interval of strain that the band is measured over.
    fn interval(&self) -> Option<String> {
        let scene = self.scenes.scenes.last()?;
        match scene.since {
            Since::Origin => None,
            Since::Frame(from) => Some(format!("From a strain of {} to {}", percent(from), percent(scene.strain))),
        }
    }
}

/// What was measured, a column for every run.
pub fn findings(stories: &[Story]) -> Table {
    let mut table = Table::default();
    let mut row = |name: &str, cell: &dyn Fn(&Story) -> Option<String>| {
        table.row(name, stories.iter().map(cell).collect());
    };
    let enriched = |tell: &dyn Fn(&Enrichment) -> Option<String>| {
        let tell = |story: &Story| story.findings.enrichment.as_ref().and_then(tell);
        stories.iter().map(tell).collect::<Vec<_>>()
    };
    row("Peak shear stress (moving average)", &|story| {
        Some(format!("{} at {}", kilopascal(story.findings.peak.1), percent(story.findings.peak.0)))
    });
    row("Shear stress at the end", &|story| {
        Some(format!("{} at {}", kilopascal(story.findings.shear_end), percent(story.findings.strain_end)))
    });
    row("Normal stress, second half", &|story| {
        let findings = story.findings;
        Some(spread(findings.normal_mean, findings.normal_deviation))
    });
    row("Volume strain at the end", &|story| Some(signed_percent(story.findings.volume_strain_end)));
    table.row(
        "Enriched at horizontal strain",
        enriched(&|e| Some(format!("{} (t = {}{THIN}s)", percent(e.strain), plain(e.time, 3)))),
    );
    table.row("Shear stress before enrichment", enriched(&|e| Some(kilopascal(e.before))));
    table.row(
        &format!("Lowest average within {}", percent(STRAIN_DISTURBED)),
        enriched(&|e| Some(format!("{} ({})", kilopascal(e.lowest), relative(e.lowest, e.before)))),
    );
    table.row(
        &format!("Highest row within {}", percent(STRAIN_DISTURBED)),
        enriched(&|e| Some(format!("{} ({})", kilopascal(e.highest), relative(e.highest, e.before)))),
    );
    table.row(
        &format!("Level from {} to {} after", percent(STRAIN_DISTURBED), percent(STRAIN_SETTLED)),
        enriched(&|e| e.settled.map(|level| format!("{} ({})", kilopascal(level), relative(level, e.before)))),
    );
    table.row(
        "Strain until 90\u{2009}% of that level",
        enriched(&|e| {
            e.settled?;
            Some(match e.recovery {
                Some(0.0) => "never below".to_owned(),
                Some(strain) => percent(strain),
                None => "not reached".to_owned(),
            })
        }),
    );
    let mut row = |name: &str, cell: &dyn Fn(&Story) -> Option<String>| {
        table.row(name, stories.iter().map(cell).collect());
    };
    row("Band measured over strain", &|story| {
        let scene = story.scenes.scenes.last()?;
        story.scenes.band.as_ref()?;
        match scene.since {
            Since::Origin => None,
            Since::Frame(from) => Some(format!("{} to {}", percent(from), percent(scene.strain))),
        }
    });
    row("Band thickness", &|story| {
        let thickness = story.scenes.band.as_ref()?.thickness;
        Some(format!("{} {D50} ({}{THIN}mm)", plain(thickness / story.run.diameter, 2), plain(1e3 * thickness, 2)))
    });
    row("Centre of the band above the lower edge", &|story| {
        let centre = story.scenes.band.as_ref()?.centre[1] - story.scenes.heights[0];
        Some(format!("{} {D50} ({}{THIN}mm)", plain(centre / story.run.diameter, 2), plain(1e3 * centre, 2)))
    });
    row("Inclination of the band", &|story| {
        let angle = story.scenes.band.as_ref()?.angle;
        Some(format!("{:.1}\u{b0}", angle * 180.0 / crate::base::math::PI).replace('-', "\u{2212}"))
    });
    row("Members of the band inside the zone", &|story| story.scenes.inside.map(percent));
    table
}

/// The scenario's main figures: path, name, factor from SI, unit.
const SCENARIO: [(&str, &str, f64, &str); 27] = [
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
    ("continuum.bulk_modulus", "Bulk modulus K", 1e-6, "MPa"),
    ("continuum.shear_modulus", "Shear modulus G", 1e-6, "MPa"),
    ("continuum.friction_angle_critical", "Critical friction angle", 180.0 / std::f64::consts::PI, "\u{b0}"),
    ("continuum.fraction_critical", "Critical packing fraction", 1.0, ""),
    ("continuum.dilation_factor", "Dilation factor \u{3c7}", 1.0, ""),
    ("continuum.softening_rate", "Softening rate \u{3be}", 1.0, ""),
    ("continuum.cell", "Grid cell", 1e3, "mm"),
    ("loading.stress_normal", "Normal stress", 1e-3, "kPa"),
    ("loading.speed", "Speed of the upper plate", 1e2, "cm/s"),
    ("loading.strain_end", "Horizontal strain at the end", 1e2, "%"),
    ("oracle.laplacian", "Oracle, c\u{2080}", 1.0, ""),
    ("oracle.recent_strain", "Oracle, c\u{2081}", 1.0, ""),
    ("enrichment.distance", "Enrichment distance \u{3c6}\u{2080}", 1e3, "mm"),
    ("enrichment.weight", "Weight of grains in the rim", 1.0, ""),
    ("enrichment.training", "Share of training", 1.0, ""),
    ("time.step", "Time step", 1.0, "s"),
];

/// The main figures of the scenarios, a column for every run.
pub fn scenario(stories: &[Story]) -> Table {
    let mut table = Table::default();
    table.row("Method", stories.iter().map(|story| Some(story.run.method.clone())).collect());
    for (path, name, factor, unit) in SCENARIO {
        let cells = stories.iter().map(|story| {
            let value = figure(&story.run.scenario, path)?;
            Some(with_unit(&plain(factor * value, 4), unit))
        });
        table.row(name, cells.collect());
    }
    table
}

/// All of the summaries, a column for every run.
pub fn summary(stories: &[Story]) -> Table {
    summaries(&stories.iter().map(|story| &story.run.summary).collect::<Vec<_>>())
}

/// The same of summaries by themselves.
pub fn summaries(summaries: &[&serde_json::Map<String, serde_json::Value>]) -> Table {
    let mut keys: Vec<&String> = Vec::new();
    for key in summaries.iter().flat_map(|summary| summary.keys()) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let mut table = Table::default();
    for key in keys {
        let cells = summaries.iter().map(|summary| match summary.get(key)? {
            serde_json::Value::String(words) => Some(words.clone()),
            serde_json::Value::Number(number) if number.is_f64() => Some(plain(number.as_f64()?, 5)),
            serde_json::Value::Null => None,
            other => Some(other.to_string()),
        });
        table.row(&key.replace('_', " "), cells.collect());
    }
    table
}

/// What happened, as text without any markup: a paragraph for every run.
pub fn plain_text(stories: &[Story]) -> String {
    let tell = |story: &Story| match stories {
        [_] => format!("{}\n", story.paragraph()),
        _ => format!("{}. {}\n", label(story.run), story.paragraph()),
    };
    plain_letters(&stories.iter().map(tell).collect::<Vec<_>>().join("\n"))
}

/// Terminals show plain spaces and digits best.
pub fn plain_letters(text: &str) -> String {
    text.replace(THIN, " ").replace(D50, "D50").replace('\u{2212}', "-")
}

/// The title of a report.
pub fn title(stories: &[Story]) -> String {
    let names: Vec<String> = stories.iter().map(|story| label(story.run)).collect();
    match names.as_slice() {
        [name] => format!("Planar shear: {name}"),
        many if many.len() > TITLE_NAMES => format!("Planar shear compared: {} runs", many.len()),
        _ => format!("Planar shear compared: {}", names.join(", ")),
    }
}

/// A thickness in mean diameters with two digits: nothing where it is less than a twentieth of one, as of a single row of
/// points.
pub fn in_diameters(thickness: f64) -> String {
    if thickness < 0.05 { "0".to_owned() } else { plain(thickness, 2) }
}

fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" => number.to_owned(),
        "\u{b0}" => format!("{number}{unit}"),
        _ => format!("{number}{THIN}{unit}"),
    }
}

/// A number with up to `digits` significant ones, zeros at the end left away.
pub fn plain(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    if text.contains('\u{d7}') { text } else { super::svg::shortened(text) }
}

pub fn kilopascal(stress: f64) -> String {
    format!("{}{THIN}kPa", significant(stress / 1e3, 3))
}

/// A stress with its standard deviation.
fn spread(mean: f64, deviation: f64) -> String {
    format!("({} \u{b1} {}){THIN}kPa", significant(mean / 1e3, 3), plain(deviation / 1e3, 2))
}

pub fn signed_percent(share: f64) -> String {
    let sign = if share > 0.0 { "+" } else { "" };
    format!("{sign}{}", percent(share))
}

/// The change from `before` in whole percent.
pub fn relative(value: f64, before: f64) -> String {
    if before == 0.0 {
        return "from zero".to_owned();
    }
    let change = format!("{:+.0}", 100.0 * (value / before - 1.0));
    let change = if change == "-0" { "+0".to_owned() } else { change.replace('-', "\u{2212}") };
    format!("{change}{THIN}%")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::report::findings::tests::hybrid;

    fn told(run: &Run) -> (Findings, Scenes) {
        let scenes = Scenes { scenes: Vec::new(), band: None, inside: None, heights: [0.0, 0.1] };
        (Findings::of(run), scenes)
    }

    #[test]
    fn the_paragraph_names_enrichment_and_recovery() {
        let mut run = hybrid(50e3);
        for stress in &mut run.series.shear_stress {
            *stress = if *stress == 100.0 { 100e3 } else { stress.max(50e3) };
        }
        let (findings, scenes) = told(&run);
        let words = Story { run: &run, findings: &findings, scenes: &scenes }.paragraph();
        assert!(words.contains("At a horizontal strain of 4\u{2009}%"), "{words}");
        assert!(words.contains("840 grains took the place"), "{words}");
        assert!(words.contains("Shear stress was 100\u{2009}kPa"), "{words}");
    }

    #[test]
    fn a_silent_oracle_is_said_so() {
        let mut run = hybrid(50e3);
        run.series.grains.fill(60.0);
        let (findings, scenes) = told(&run);
        let words = Story { run: &run, findings: &findings, scenes: &scenes }.paragraph();
        assert!(words.contains("No persistent shear band was found"), "{words}");
    }

    #[test]
    fn tables_leave_out_what_no_run_has() {
        let mut run = hybrid(50e3);
        run.method = "dem".into();
        run.scenario = toml::from_str("[specimen]\nwidth = 0.06\n[time]\nstep = 4e-7").unwrap();
        run.summary.insert("ranks".to_owned(), 2.into());
        let (findings_here, scenes) = told(&run);
        let stories = [Story { run: &run, findings: &findings_here, scenes: &scenes }];
        assert!(findings(&stories).rows.iter().all(|(name, _)| !name.contains("nrich")));
        let rows = scenario(&stories).rows;
        assert_eq!(rows[1], ("Width (period)".to_owned(), vec!["60\u{2009}mm".to_owned()]));
        assert_eq!(rows[2].1[0], "4\u{2009}\u{d7}\u{2009}10\u{207b}\u{2077}\u{2009}s");
        assert_eq!(summary(&stories).rows, [("ranks".to_owned(), vec!["2".to_owned()])]);
    }

    #[test]
    fn changes_are_told_in_percent() {
        assert_eq!(relative(125.0, 100.0), "+25\u{2009}%");
        assert_eq!(relative(85.0, 100.0), "\u{2212}15\u{2009}%");
        assert_eq!(relative(99.9, 100.0), "+0\u{2009}%");
        assert_eq!(signed_percent(-0.0123), "\u{2212}1.23\u{2009}%");
    }
}
