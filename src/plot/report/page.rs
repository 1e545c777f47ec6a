//! The page that holds everything: one file, no script, nothing fetched.

use std::fmt::Write as _;

use super::Drawn;
use super::parts::{Part, Sheet};
use super::svg::{FONT, escape};
use super::words::{self, Table};
use crate::analysis::run::Run;

/// What a report says of its runs.
pub struct Report<'a> {
    pub runs: &'a [Run],
    /// What happened, run by run.
    pub paragraphs: Vec<String>,
    pub parts: Vec<Part>,
    /// Pictures, and curves of columns.
    pub figures: Vec<Drawn>,
    /// Somebody has asked for more than there may be: several runs, or an interval.
    pub tells_why: bool,
}

impl Report<'_> {
    /// The main findings of a comparison as a paragraph.
    pub fn findings(&self) -> String {
        self.parts.iter().flat_map(|part| part.sentences.iter().map(String::as_str)).collect::<Vec<_>>().join(" ")
    }

    /// The whole page.
    pub fn page(&self) -> String {
        let title = escape(&words::title(self.runs));
        let mut body = format!("<h1>{title}</h1>\n");
        let mut figures = 0;
        match self.paragraphs.as_slice() {
            [only] => {
                lead(&mut body, &escape(only));
                self.measured(&mut body, &mut figures);
            }
            several => {
                body.push_str("<h2>Compared</h2>\n");
                for part in self.parts.iter().filter(|part| !part.sentences.is_empty()) {
                    lead(&mut body, &escape(&part.sentences.join(" ")));
                }
                self.measured(&mut body, &mut figures);
                body.push_str("<p>All of these figures stand in <code>comparison.json</code> beside this page.</p>\n");
                body.push_str("<h2>Run by run</h2>\n");
                for (run, words) in self.runs.iter().zip(several) {
                    lead(&mut body, &format!("<b>{}.</b> {}", escape(&run.label()), escape(words)));
                }
            }
        }
        for drawn in &self.figures {
            figures += 1;
            figure(&mut body, figures, &drawn.drawing, &drawn.caption);
        }
        let names: Vec<String> = self.runs.iter().map(Run::label).collect();
        table(&mut body, "Scenario", &names, &words::scenario(self.runs));
        table(&mut body, "Summary of the run", &names, &words::summary(self.runs));
        self.made(&mut body);
        whole(&title, &body)
    }

    /// Figures, tables, and what is not there.
    fn measured(&self, body: &mut String, figures: &mut usize) {
        for part in &self.parts {
            for drawn in &part.figures {
                *figures += 1;
                figure(body, *figures, &drawn.drawing, &drawn.caption);
            }
            part.sheets.iter().for_each(|sheet| self.sheet(body, sheet));
            for why in part.left_out.iter().filter(|_| self.tells_why) {
                let _ = writeln!(body, "<p class=\"left-out\">{}</p>", escape(why));
            }
        }
    }

    /// A row for each run, or of a single run one for each column.
    fn sheet(&self, body: &mut String, sheet: &Sheet) {
        match (self.runs.len(), sheet.rows.as_slice()) {
            (1, [(_, cells)]) => {
                let row = |(name, cell): (&&str, &String)| ((*name).to_owned(), vec![cell.clone()]);
                let rows = sheet.columns.iter().zip(cells).map(row).collect();
                table(body, &sheet.title, &[""], &Table { rows });
            }
            _ => table(body, &sheet.title, &sheet.columns, &Table { rows: sheet.rows.clone() }),
        }
    }

    /// How to make it again.
    fn made(&self, body: &mut String) {
        body.push_str("<h2>How this was made</h2>\n");
        let directories: Vec<String> = self.runs.iter().map(|run| run.directory.display().to_string()).collect();
        let _ = writeln!(
            body,
            "<p>By {} with <code>scree report {}</code>, from each directory's <code>scenario.toml</code>, \
             <code>summary.json</code>, <code>series.csv</code> and <code>frames.vtkhdf</code>. The drawings lie beside \
             this page in <code>figures/</code>, as SVG.</p>",
            crate::base::program::name(),
            escape(&directories.join(" "))
        );
        for run in self.runs {
            let _ = writeln!(
                body,
                "<details><summary>The complete scenario of {}</summary>\n<pre>{}</pre>\n</details>",
                escape(&run.label()),
                escape(&run.scenario_text)
            );
        }
    }
}

fn lead(body: &mut String, words: &str) {
    let _ = writeln!(body, "<p class=\"lead\">{words}</p>");
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
