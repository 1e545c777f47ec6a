//! The page that holds everything: one file, no script, nothing fetched.

use std::fmt::Write as _;
use std::path::Path;

use super::compare::Comparison;
use super::figures::label;
use super::findings::{STRAIN_DISTURBED, WINDOW};
use super::records::Record;
use super::svg::{FONT, escape};
use super::words::{self, Story, Table};

/// The drawings of a report, by the names of their files.
pub struct Drawings {
    pub shear_stress: String,
    pub volume: String,
    pub specimen: String,
    pub energies: String,
}

impl Drawings {
    /// Each drawing with the name of its file.
    pub fn files(&self) -> [(&'static str, &str); 4] {
        [
            ("shear_stress.svg", &self.shear_stress),
            ("volume.svg", &self.volume),
            ("specimen.svg", &self.specimen),
            ("energies.svg", &self.energies),
        ]
    }
}

/// The whole page.
pub fn page(stories: &[Story], drawings: &Drawings, comparison: Option<&Comparison>) -> String {
    let title = escape(&words::title(stories));
    let mut body = format!("<h1>{title}</h1>\n");
    let compared = comparison.map_or(0, |comparison| compared(&mut body, comparison));
    for story in stories {
        let _ = match stories {
            [_] => writeln!(body, "<p class=\"lead\">{}</p>", escape(&story.paragraph())),
            _ => {
                writeln!(
                    body,
                    "<p class=\"lead\"><b>{}.</b> {}</p>",
                    escape(&label(story.run)),
                    escape(&story.paragraph())
                )
            }
        };
    }
    figure(&mut body, compared + 1, &drawings.shear_stress, &stress_caption(stories));
    figure(
        &mut body,
        compared + 2,
        &drawings.volume,
        "(a) Volume strain, positive in dilation, and (b) normal stress on the upper plate, against horizontal \
         strain; single rows faint, their moving average on top.",
    );
    figure(&mut body, compared + 3, &drawings.specimen, &specimen_caption(stories));
    figure(
        &mut body,
        compared + 4,
        &drawings.energies,
        "Energies against horizontal strain: elastic energy of the contacts (grains) and of the continuum (points), \
         and kinetic energy. What is zero has no place on this scale.",
    );
    let names: Vec<String> = stories.iter().map(|story| label(story.run)).collect();
    table(&mut body, "What was measured", &names, &words::findings(stories));
    table(&mut body, "Scenario", &names, &words::scenario(stories));
    table(&mut body, "Summary of the run", &names, &words::summary(stories));
    let sources: Vec<Source> =
        stories.iter().map(|story| (label(story.run), &*story.run.directory, &*story.run.scenario_text)).collect();
    made(&mut body, &sources);
    whole(&title, &body)
}

/// The comparison: its findings, figures and tables, and what is not there; the number of figures.
fn compared(body: &mut String, comparison: &Comparison) -> usize {
    body.push_str("<h2>Compared</h2>\n");
    for part in comparison.parts.iter().filter(|part| !part.sentences.is_empty()) {
        let _ = writeln!(body, "<p class=\"lead\">{}</p>", escape(&part.sentences.join(" ")));
    }
    let mut figures = 0;
    for part in &comparison.parts {
        for drawn in &part.figures {
            figures += 1;
            figure(body, figures, &drawn.drawing, &drawn.caption);
        }
        for sheet in &part.sheets {
            table(body, sheet.title, &sheet.columns, &sheet.table);
        }
        for why in &part.left_out {
            let _ = writeln!(body, "<p class=\"left-out\">{}</p>", escape(why));
        }
    }
    body.push_str("<p>All of these figures stand in <code>comparison.json</code> beside this page.</p>\n");
    body.push_str("<h2>Run by run</h2>\n");
    figures
}

/// What the pictures of an assembly show.
pub const GRAINS_CAPTION: &str = "The grains in their true size, spheres seen along y, coloured by the mean stress of \
     their contacts, compression positive; grey: glued to a body; dashed: the cell.";

/// A run with what is said of it and its drawings.
pub struct Section<'a> {
    pub record: &'a Record,
    pub words: String,
    pub figures: Vec<Figure>,
}

/// A name, a drawing and a caption.
pub type Figure = (&'static str, String, &'static str);

/// The page of runs of grains in cells or of continua, one below the other, after what they are compared by.
pub fn sections(sections: &[Section], comparison: Option<&Comparison>) -> String {
    let names: Vec<&str> = sections.iter().map(|section| section.record.name.as_str()).collect();
    let title = escape(&names.join(", "));
    let mut body = format!("<h1>{title}</h1>\n");
    let mut figures = comparison.map_or(0, |comparison| compared(&mut body, comparison));
    for section in sections {
        let record = section.record;
        if sections.len() > 1 {
            let directory = record.directory.display().to_string();
            let _ = writeln!(body, "<h2>{} ({})</h2>", escape(&record.name), escape(&directory));
        }
        let _ = writeln!(body, "<p class=\"lead\">{}</p>", escape(&section.words));
        for (_, drawing, caption) in &section.figures {
            figures += 1;
            figure(&mut body, figures, drawing, caption);
        }
    }
    let summaries: Vec<_> = sections.iter().map(|section| &section.record.summary).collect();
    table(&mut body, "Summary of the run", &names, &words::summaries(&summaries));
    let sources: Vec<Source> = sections
        .iter()
        .map(|section| (section.record.name.clone(), &*section.record.directory, &*section.record.scenario_text))
        .collect();
    made(&mut body, &sources);
    whole(&title, &body)
}

/// A page around its body, with the style of all of them.
pub fn whole(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>{}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n",
        style()
    )
}

fn style() -> String {
    format!(
        "\n:root {{ color-scheme: light; }}\n\
         body {{ margin: 0; background: #fff; color: #222; font: 16px/1.5 {FONT}; }}\n\
         main {{ max-width: 920px; margin: 0 auto; padding: 28px 20px 60px; }}\n\
         h1 {{ font-size: 27px; line-height: 1.25; margin: 0 0 14px; }}\n\
         h2 {{ font-size: 19px; margin: 38px 0 8px; }}\n\
         .lead {{ margin: 0 0 14px; }}\n\
         figure {{ margin: 34px 0 0; }}\n\
         figure svg {{ display: block; width: 100%; height: auto; }}\n\
         figcaption {{ font-size: 14px; line-height: 1.45; color: #444; margin: 8px 0 0; max-width: 820px; }}\n\
         .scroll {{ overflow-x: auto; }}\n\
         .left-out {{ font-size: 14px; color: #444; margin: 8px 0 0; }}\n\
         table {{ border-collapse: collapse; font-size: 14px; }}\n\
         th, td {{ text-align: left; vertical-align: top; padding: 4px 22px 4px 0; }}\n\
         th, td {{ border-bottom: 1px solid #e4e4e4; }}\n\
         td {{ font-variant-numeric: tabular-nums; }}\n\
         th {{ font-weight: 600; }}\n\
         tbody th {{ font-weight: normal; color: #444; }}\n\
         pre {{ font-size: 13px; line-height: 1.4; background: #f6f6f6; padding: 12px; overflow-x: auto; }}\n\
         code {{ font-size: 14px; }}\n\
         summary {{ cursor: pointer; margin: 12px 0 0; }}\n\
         @media print {{ main {{ max-width: none; padding: 0; }} figure {{ break-inside: avoid; }} }}\n"
    )
}

/// A drawing with its number and caption.
pub fn figure(body: &mut String, number: usize, drawing: &str, caption: &str) {
    let _ = writeln!(
        body,
        "<figure>\n{drawing}<figcaption><b>Figure {number}.</b> {}</figcaption>\n</figure>",
        escape(caption)
    );
}

fn stress_caption(stories: &[Story]) -> String {
    let mut caption = format!(
        "Shear stress (tangential force on the upper plate over its area) against horizontal strain (displacement of \
         the upper plate over the specimen's width). Faint: rows of series.csv, each the mean over its interval; full: \
         their moving average over {WINDOW} rows"
    );
    if stories.iter().any(|story| story.findings.enrichment.is_some()) {
        let _ = write!(
            caption,
            ", which does not look across the enrichment (dashed). (b) shows the enrichment closely; dotted: the mean \
             of the {WINDOW} rows before it. Dip and spike are looked for within {:.0}\u{2009}% of strain after it",
            100.0 * STRAIN_DISTURBED
        );
    }
    caption + "."
}

fn specimen_caption(stories: &[Story]) -> String {
    let mut caption = "The specimen, periodic in the horizontal direction, at the strains given. Grains are discs in \
                       their true size, points are squares of their area"
        .to_owned();
    let rim =
        |story: &Story| story.scenes.scenes.iter().any(|scene| scene.bodies.iter().any(|row| row.body.weight < 1.0));
    if stories.iter().any(rim) {
        caption += "; in the outlined rim both live and share the mass";
    }
    caption += ". Colour: magnitude |e\u{2032}| = \u{221a}(e\u{2032}:e\u{2032}) of the deviatoric part of the best-fit \
                strain over Delaunay neighbours (simple shear by \u{3b3} has \u{3b3}/\u{221a}2), points and grains \
                fitted apart; in the last panel it counts from the strain given there, body by body, and bodies that \
                were not there yet are grey";
    if stories.iter().any(|story| story.scenes.band.is_some()) {
        caption += ". Dashed: the band, that is the smallest box around the most strained 2\u{2009}% of the material \
                    (98th percentile by area) without outliers beyond two standard deviations, level and without ends \
                    where it closes round the period; its thickness stands beside it";
    }
    caption + ". After Chen et al. (2021), figures 9 and 11 and appendix A."
}

/// A table with a column for each of `runs`; nothing where it has no rows.
pub fn table(body: &mut String, title: &str, runs: &[impl AsRef<str>], table: &Table) {
    if table.rows.is_empty() {
        return;
    }
    let _ = writeln!(body, "<h2>{}</h2>\n<div class=\"scroll\"><table>", escape(title));
    if runs.len() > 1 {
        body.push_str("<thead><tr><th></th>");
        for run in runs {
            let _ = write!(body, "<th>{}</th>", escape(run.as_ref()));
        }
        body.push_str("</tr></thead>\n");
    }
    body.push_str("<tbody>\n");
    for (name, cells) in &table.rows {
        // No line shall end between a number and its unit.
        let whole = |words: &str| escape(words).replace('\u{2009}', "\u{202f}");
        let _ = write!(body, "<tr><th>{}</th>", whole(name));
        for cell in cells {
            let _ = write!(body, "<td>{}</td>", whole(cell));
        }
        body.push_str("</tr>\n");
    }
    body.push_str("</tbody></table></div>\n");
}

/// Name, directory and scenario of a run.
type Source<'a> = (String, &'a Path, &'a str);

/// How to make it again.
fn made(body: &mut String, sources: &[Source]) {
    body.push_str("<h2>How this was made</h2>\n");
    let directories: Vec<String> = sources.iter().map(|(_, directory, _)| directory.display().to_string()).collect();
    let _ = writeln!(
        body,
        "<p>By {} with <code>scree report {}</code>, from each directory's <code>scenario.toml</code>, \
         <code>summary.json</code>, <code>series.csv</code> and <code>frames.vtkhdf</code>. The drawings lie beside \
         this page in <code>figures/</code>, as SVG.</p>",
        crate::base::program::name(),
        escape(&directories.join(" "))
    );
    for (name, _, scenario) in sources {
        let _ = writeln!(
            body,
            "<details><summary>The complete scenario of {}</summary>\n<pre>{}</pre>\n</details>",
            escape(name),
            escape(scenario)
        );
    }
}
