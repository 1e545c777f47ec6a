//! The log of a run: a line of JSON for everything worth knowing later, `{"event": ..., "step": ..., ...}`.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::base::error::Error;

const FILE: &str = "log.jsonl";

/// Open for adding lines; its folder belongs to whoever holds this.
#[derive(Debug)]
pub struct Log {
    file: File,
    path: PathBuf,
}

impl Log {
    /// Opens the log of a run's folder, and makes it where there is none.
    pub fn open(dir: &Path) -> Result<Self, Error> {
        let path = dir.join(FILE);
        let opened = OpenOptions::new().create(true).append(true).open(&path);
        let file = opened.map_err(|error| failed(&path, &error))?;
        Ok(Self { file, path })
    }

    /// The run that the first line is of; nothing where it tells none.
    pub fn run(&self) -> Option<String> {
        let mut line = String::new();
        BufReader::new(File::open(&self.path).ok()?).read_line(&mut line).ok()?;
        let told: Value = serde_json::from_str(&line).ok()?;
        told["run"].as_str().map(str::to_string)
    }

    /// Cuts off what a run that ended without notice has told of steps after `step`, which will be told again, and a line that
    /// it did not finish.
    pub fn cut_after(&mut self, step: u64) -> Result<(), Error> {
        let read = File::open(&self.path).map_err(|error| failed(&self.path, &error))?;
        let (mut reader, mut line, mut kept) = (BufReader::new(read), Vec::new(), 0);
        loop {
            line.clear();
            let bytes = reader.read_until(b'\n', &mut line).map_err(|error| failed(&self.path, &error))?;
            let told: Option<Value> = serde_json::from_slice(&line).ok();
            let is_later = told.and_then(|told| told["step"].as_u64()).is_some_and(|told| told > step);
            // A damaged line amid good ones says nothing of its step.
            if line.last() != Some(&b'\n') || is_later {
                break;
            }
            kept += bytes as u64;
        }
        self.file.set_len(kept).map_err(|error| failed(&self.path, &error))
    }

    /// One line.
    pub fn tell(&mut self, event: &str, step: u64, mut fields: Value) -> Result<(), Error> {
        fields["event"] = json!(event);
        fields["step"] = json!(step);
        // At once, so that a line is torn by nothing but a full disk or a lost machine.
        self.file.write_all(format!("{fields}\n").as_bytes()).map_err(|error| failed(&self.path, &error))
    }
}

/// What the log in a folder tells of an event, the first first; nothing where there is no log.
pub fn told(dir: &Path, event: &str) -> Vec<Value> {
    let Ok(file) = File::open(dir.join(FILE)) else { return Vec::new() };
    let lines = BufReader::new(file).lines().map_while(Result::ok);
    let told = lines.filter_map(|line| serde_json::from_str::<Value>(&line).ok());
    told.filter(|told| told["event"] == event).collect()
}

fn failed(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::Run(format!("{}: {error}; the run has stopped", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_cut_to_whole_lines_of_steps_done() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log.jsonl");
        let text = || std::fs::read_to_string(&path).unwrap();
        for torn in ["", "{\"event\":\"d\",\"st", "{\"event\":\"d\",\"step\":5}", "\0\0\0"] {
            let _ = std::fs::remove_file(&path);
            let mut log = Log::open(dir.path()).unwrap();
            for (event, step) in [("a", 0), ("b", 10), ("c", 20)] {
                log.tell(event, step, json!({ "x": 1 })).unwrap();
            }
            std::fs::write(&path, text() + torn).unwrap();
            log.cut_after(20).unwrap();
            assert_eq!(text().lines().count(), 3);
            log.cut_after(19).unwrap();
            log.tell("d", 15, json!({})).unwrap();
            let steps: Vec<Value> = text().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
            let steps: Vec<u64> = steps.iter().map(|line: &Value| line["step"].as_u64().unwrap()).collect();
            assert_eq!(steps, [0, 10, 15], "{torn}");
        }
    }
}
