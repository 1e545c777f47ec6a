//! What a run tells of itself: its summary, and as long as it has none of its present stretch, since it is still running or was
//! killed, the events of its log.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::load::{broken, text};
use crate::base::error::Error;

/// The outcome of a run that has not told of one.
pub const UNDER_WAY: &str = "not told yet: still running, or killed";

/// The figures of a run whose last row is of `step`.
pub fn figures(directory: &Path, step: f64) -> Result<Map<String, Value>, Error> {
    let path = directory.join("summary.json");
    let mut figures: Map<String, Value> = match path.exists() {
        true => serde_json::from_str(&text(&path)?).map_err(|error| {
            broken(&path, &format!("is not a JSON object: {error}"), "Resume the run; its end writes the file anew")
        })?,
        false => Map::new(),
    };
    let is_of_now = figures.get("steps").and_then(Value::as_f64).is_some_and(|told| told >= step);
    if !is_of_now {
        figures.extend(events(directory));
        figures.insert("outcome".to_owned(), json!(UNDER_WAY));
        figures.insert("steps".to_owned(), json!(step));
    }
    Ok(figures)
}

/// What the log has told of an enrichment: these figures the summary has as well.
fn events(directory: &Path) -> Map<String, Value> {
    let log = std::fs::read_to_string(directory.join("log.jsonl")).unwrap_or_default();
    let mut lines = log.lines().filter_map(|line| serde_json::from_str::<Map<String, Value>>(line).ok());
    let enriched = lines.rfind(|line| line.get("event") == Some(&json!("enriched")));
    let mut figures = enriched.unwrap_or_default();
    ["event", "step", "run"].into_iter().for_each(|key| drop(figures.remove(key)));
    figures
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_a_summary_of_now_is_told_by_its_log() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write(
            "log.jsonl",
            "{\"event\":\"started\",\"step\":0}\n{\"event\":\"enriched\",\"step\":40,\"enriched_grains\":12}\n{\"eve",
        );
        let told = figures(folder.path(), 50.0).unwrap();
        assert_eq!((&told["enriched_grains"], &told["outcome"]), (&json!(12), &json!(UNDER_WAY)));
        // Of a stretch before this one.
        write("summary.json", "{\"outcome\":\"stopped\",\"steps\":30,\"ranks\":2}");
        let told = figures(folder.path(), 50.0).unwrap();
        assert_eq!((&told["ranks"], &told["outcome"], &told["steps"]), (&json!(2), &json!(UNDER_WAY), &json!(50.0)));
        assert_eq!(figures(folder.path(), 30.0).unwrap()["outcome"], "stopped");
    }
}
