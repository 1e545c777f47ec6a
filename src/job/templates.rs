//! Jobs to begin with: small ones of each method that run as they are, with every key explained, and those that may be added or
//! stand in place of others.

use std::fmt::Write;

use super::Job;
use super::raw::Typed;
use crate::base::error::Error;
use crate::base::keys::{DefaultValue, Key, Table};

/// What there is to begin with, and what it shows.
pub const TEMPLATES: [(&str, &str, &str); 6] = [
    (
        "hybrid",
        "planar shear: a continuum in which grains take the place of a shear band. It is small and to be watched: slower than grains\n# alone, and up to 25 % off their shear stress",
        include_str!("templates/hybrid.toml"),
    ),
    ("dem", "planar shear of grains alone", include_str!("templates/dem.toml")),
    ("mpm", "planar shear of a continuum alone", include_str!("templates/mpm.toml")),
    ("element", "biaxial compression of a periodic cell of grains", include_str!("templates/element.toml")),
    ("pour", "spheres that are poured under gravity onto a floor", include_str!("templates/pour.toml")),
    ("continuum", "a column of sand that collapses", include_str!("templates/continuum.toml")),
];

/// Column that explanations begin at.
const MARGIN: usize = 44;

/// The job to begin a method with.
pub fn job(method: &str) -> Result<String, Error> {
    let Some((name, about, text)) = TEMPLATES.into_iter().find(|(name, ..)| *name == method) else {
        let names: Vec<&str> = TEMPLATES.iter().map(|(name, ..)| *name).collect();
        return Err(Error::User(format!("There is no job for {method}. Write one of: {}.", names.join(", "))));
    };
    let kind = Typed::parse(text, "template", &[])?.kind;
    let mut page = format!(
        "# {}{}.\n#\n#     scree check {name}.toml\n#     scree run {name}.toml\n#     scree report runs/{name}\n#\n# Numbers are in SI units; text in quotes carries its own unit. `scree keys TABLE` tells all about the keys of a table.\n\n",
        about[..1].to_uppercase(),
        &about[1..]
    );
    let mut table = kind.top();
    let mut typed: Vec<&str> = Vec::new();
    for (at, line) in text.lines().chain([""]).enumerate() {
        let name = line.trim_start_matches('[').trim_end_matches(']');
        if line.starts_with('[') {
            table =
                kind.tables_of_all_depths().into_iter().find(|table| table.name == name).expect("the template is good");
            writeln!(page, "{}", explained(line, table.about)).expect("a string takes every write");
        } else if let Some((key, _)) = line.split_once(" = ") {
            typed.push(line);
            let about = table.key(key).map(|key| key.about).unwrap_or_default();
            writeln!(page, "{}", explained(line, about)).expect("a string takes every write");
        } else {
            if !typed.is_empty() && !table.name.is_empty() {
                page += &more(table, &typed, (text, at));
            }
            typed.clear();
            page += "\n";
        }
    }
    Ok(page.trim_end().to_string() + "\n")
}

fn explained(line: &str, about: &str) -> String {
    format!("{line:<MARGIN$} # {about}")
}

/// What the explanation of a key says that is refused beside what is typed, or by itself.
const NAMED: [&str; 2] = ["in place of", "together with"];

/// Whether the template is good with one more line, ahead of its line `at`.
fn is_good_with(line: &str, (template, at): (&str, usize)) -> bool {
    let lines = template.lines();
    let job: Vec<&str> = lines.clone().take(at).chain([line]).chain(lines.skip(at)).collect();
    Job::parse(&job.join("\n"), "template", &[]).is_ok()
}

/// Keys that may be added to those that are typed, or stand in place of some of them.
fn more(table: &Table, typed: &[&str], template: (&str, usize)) -> String {
    let axes = if template.0.contains("space = \"solid\"") { 3 } else { 2 };
    let value = |name: &str| {
        let line = typed.iter().find(|line| line.split_once(" = ").is_some_and(|(key, _)| key == name))?;
        Some(line.split_once(" = ")?.1.trim_matches('"'))
    };
    // Of a choice that is left to its default its own keys as well.
    let chosen = |key: &Key| {
        key.owners.is_empty()
            || key.owners.iter().any(|owner| {
                let default = || match table.key(owner.selector).map(|key| key.default) {
                    Some(DefaultValue::Value(name)) => Some(name),
                    _ => None,
                };
                value(owner.selector).or_else(default) == Some(owner.choice)
            })
    };
    let added = table.keys.iter().filter(|key| !key.default.is_required() && key.inner().is_none());
    let mut text = String::new();
    for key in added.filter(|key| value(key.name).is_none() && chosen(key)) {
        let shown = match key.default {
            DefaultValue::Value(default) if matches!(key.wants, crate::base::keys::Wants::Choice(_)) => {
                format!("\"{default}\"")
            }
            DefaultValue::Value(default) => default.to_string(),
            _ => key.example(axes),
        };
        let line = format!("{} = {shown}", key.name);
        if !NAMED.iter().any(|words| key.about.contains(words)) && !is_good_with(&line, template) {
            continue;
        }
        let about = match key.default {
            DefaultValue::Follows(words) => format!("{}; default: {words}", key.about),
            _ => key.about.to_string(),
        };
        writeln!(text, "{}", explained(&format!("# {line}"), &about)).expect("a string takes every write");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_to_begin_with_is_good() {
        for (name, ..) in TEMPLATES {
            let text = job(name).unwrap();
            let read =
                Job::parse(&text, &format!("{name}.toml"), &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
            assert_eq!(read.name(), name);
            assert!(text.lines().all(|line| !line.ends_with("# ")), "{text}");
        }
        let wrong = job("sph").unwrap_err().to_string();
        assert_eq!(wrong, "There is no job for sph. Write one of: hybrid, dem, mpm, element, pour, continuum.");
    }

    /// Who takes the mark off a line that may be added has a good job, or is told on that line what it goes in place of or together with.
    #[test]
    fn every_line_may_be_added() {
        for (name, ..) in TEMPLATES {
            let text = job(name).unwrap();
            let is_key = |line: &str| line.strip_prefix("# ").is_some_and(|rest| rest[..MARGIN - 2].contains(" = "));
            let marked = text.lines().enumerate().filter(|(_, line)| line.len() > MARGIN && is_key(line));
            let marked: Vec<(usize, &str)> = marked.collect();
            assert!(marked.len() > 5, "{text}");
            for (at, line) in marked {
                let with: Vec<&str> = text
                    .lines()
                    .enumerate()
                    .map(|(number, line)| if number == at { &line[2..] } else { line })
                    .collect();
                let read = Job::parse(&with.join("\n"), &format!("{name}.toml"), &[]);
                let said = NAMED.iter().any(|words| line.contains(words));
                assert!(read.is_ok() || said, "{name}: {line}\n{}", read.unwrap_err());
            }
        }
    }
}
