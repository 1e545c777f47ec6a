//! A job as TOML: SI numbers in their shortest exact form, no default left open.

use std::fmt::Write;
use std::ops::Range;
use std::path::PathBuf;

use crate::base::keys::{Form, Key, Owner};

/// What a job begins with that has been written out, and the rest of that line.
pub const RESOLVED: &str = "# Resolved by scree";
const HEAD: &str = ": SI units, angles in rad, every default written out.";

/// Writes what it visits.
pub struct Page {
    text: String,
    axes: usize,
    /// The table under way, as it is called in its head.
    path: String,
    /// Keys as they come, with what was written for them.
    keys: Vec<(Key, String)>,
}

/// The keys that `visit` declares, with what a job would say of them.
pub fn listed(axes: usize, visit: impl FnOnce(&mut dyn Form)) -> Vec<(Key, String)> {
    let mut page = Page::new(axes);
    visit(&mut page);
    page.keys
}

impl Page {
    pub fn new(axes: usize) -> Self {
        Self { text: format!("{RESOLVED}{HEAD}\n"), axes, path: String::new(), keys: Vec::new() }
    }

    pub fn text(self) -> String {
        self.text
    }

    /// A table of the job.
    pub fn section(&mut self, name: &str, visit: impl FnOnce(&mut Self)) {
        self.within(&format!("[{name}]"), name.to_string(), visit);
    }

    fn within(&mut self, head: &str, path: String, visit: impl FnOnce(&mut Self)) {
        let before = std::mem::replace(&mut self.path, path);
        self.line(&format!("\n{head}"));
        visit(self);
        self.path = before;
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn key(&mut self, key: &Key, value: &str) {
        self.line(&format!("{} = {value}", key.name));
        self.keys.push((key.clone(), value.to_string()));
    }

    fn below(&self, key: &Key) -> String {
        if self.path.is_empty() { key.name.to_string() } else { format!("{}.{}", self.path, key.name) }
    }
}

/// `[0.0, 1.5]`.
fn list(values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("[{}]", shown.join(", "))
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if c.is_control() => write!(quoted, "\\u{:04X}", c as u32).expect("a string takes every write"),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

impl Form for Page {
    fn axes(&self) -> usize {
        self.axes
    }

    fn set_axes(&mut self, axes: usize) {
        self.axes = axes;
    }

    fn number(&mut self, value: &mut f64, key: Key) {
        self.key(&key, &format!("{value:?}"));
    }

    fn number_if_given(&mut self, value: &mut Option<f64>, key: Key) {
        if let Some(value) = value {
            self.number(value, key);
        }
    }

    fn vector_if_given(&mut self, value: &mut Option<[f64; 3]>, key: Key) {
        if let Some(value) = value {
            self.vector(value, key);
        }
    }

    fn spin_if_given(&mut self, value: &mut Option<[f64; 3]>, key: Key) {
        if let Some(value) = value {
            self.spin(value, key);
        }
    }

    fn count(&mut self, value: &mut u64, key: Key) {
        self.key(&key, &value.to_string());
    }

    fn flag(&mut self, value: &mut bool, key: Key) {
        self.key(&key, &value.to_string());
    }

    fn flags(&mut self, value: &mut [bool; 3], key: Key) {
        self.key(&key, &format!("{:?}", &value[..self.axes]));
    }

    fn text(&mut self, value: &mut String, key: Key) {
        self.key(&key, &quoted(value));
    }

    fn path(&mut self, value: &mut PathBuf, key: Key) {
        self.key(&key, &quoted(&value.display().to_string()));
    }

    fn path_if_given(&mut self, value: &mut Option<PathBuf>, key: Key) {
        if let Some(value) = value {
            self.path(value, key);
        }
    }

    fn vector(&mut self, value: &mut [f64; 3], key: Key) {
        self.key(&key, &list(&value[..self.axes]));
    }

    fn spin(&mut self, value: &mut [f64; 3], key: Key) {
        match self.axes {
            2 => self.number(&mut value[2], key),
            _ => self.vector(value, key),
        }
    }

    fn gradient(&mut self, value: &mut [[f64; 3]; 3], key: Key) {
        let rows: Vec<String> = value[..self.axes].iter().map(|row| list(&row[..self.axes])).collect();
        self.key(&key, &format!("[{}]", rows.join(", ")));
    }

    fn stresses(&mut self, value: &mut Option<[Option<f64>; 3]>, key: Key) {
        let Some(stresses) = value else { return };
        let shown = |stress: &Option<f64>| stress.map_or("\"free\"".to_string(), |stress| format!("{stress:?}"));
        let held: Vec<String> = stresses[..self.axes].iter().map(shown).collect();
        self.key(&key, &format!("[{}]", held.join(", ")));
    }

    fn shares(&mut self, value: &mut Vec<(f64, f64)>, key: Key) {
        let pairs: Vec<String> = value.iter().map(|(length, share)| list(&[*length, *share])).collect();
        self.key(&key, &format!("[{}]", pairs.join(", ")));
    }

    fn polygon(&mut self, value: &mut Vec<[f64; 2]>, key: Key) {
        let corners: Vec<String> = value.iter().map(|corner| list(corner)).collect();
        self.key(&key, &format!("[{}]", corners.join(", ")));
    }

    fn choice(&mut self, chosen: usize, _: &str, names: &[&'static str], key: Key) -> Range<usize> {
        self.key(&key, &quoted(names[chosen]));
        chosen..chosen + 1
    }

    fn enter(&mut self, _: Owner) {}

    fn leave(&mut self) {}

    fn table(&mut self, is_there: bool, key: Key, _: &'static str, inside: &mut dyn FnMut(&mut dyn Form)) -> bool {
        if is_there {
            let path = self.below(&key);
            self.within(&format!("[{path}]"), path.clone(), |page| inside(page));
        }
        is_there
    }

    fn tables(&mut self, count: usize, key: Key, _: &'static str, each: &mut dyn FnMut(usize, &mut dyn Form)) {
        let path = self.below(&key);
        for number in 0..count {
            self.within(&format!("[[{path}]]"), path.clone(), |page| each(number, page));
        }
    }

    fn has(&self, _: &str) -> bool {
        false
    }

    fn is_needed(&self) -> bool {
        false
    }

    fn note(&mut self, _: &str, _: &str) {}

    fn note_table(&mut self, _: &str) {}
}
