//! Rows of a sweep: every combination of the values of its keys, each with a name that stays when values are added.

use std::path::Path;

use sha2::{Digest, Sha256};

use crate::base::error::Error;

/// More runs than anybody looks at; a slip in a range makes as many.
const ROWS_MAX: usize = 100_000;
/// Letters of a name before it is cut.
const NAME_MAX: usize = 100;

/// A run of the sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Row {
    /// Of its folder.
    pub name: String,
    /// Of the keys of [`Rows::keys`].
    pub values: Vec<String>,
}

/// What varies, and every row.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Rows {
    pub keys: Vec<String>,
    pub all: Vec<Row>,
}

impl Rows {
    /// From `--vary KEY=VALUES`, the last of which changes fastest, and a file whose lines are combined with them.
    pub fn of(varied: &[String], file: Option<&Path>) -> Result<Self, Error> {
        let (mut keys, mut lines) = match file {
            Some(file) => of_file(file)?,
            None => (Vec::new(), vec![Vec::new()]),
        };
        for text in varied {
            let (key, values) = split(text)?;
            refuse_twice(&keys, &key)?;
            if lines.len() * values.len() > ROWS_MAX {
                return Err(Error::User(format!(
                    "--vary {text}: that makes more than {ROWS_MAX} rows. Vary less, or in several sweeps."
                )));
            }
            keys.push(key);
            lines = lines
                .iter()
                .flat_map(|line| values.iter().map(|value| [line.as_slice(), std::slice::from_ref(value)].concat()))
                .collect();
        }
        if keys.is_empty() {
            return Err(Error::User(
                "A sweep needs something that varies. Write for example --vary seed=1..10, or --rows FILE.csv."
                    .to_string(),
            ));
        }
        let all = named(&keys, lines)?;
        Ok(Self { keys, all })
    }

    /// What `--set` would be given for a row.
    pub fn sets(&self, row: &Row) -> Vec<String> {
        self.keys.iter().zip(&row.values).map(|(key, value)| format!("{key}={value}")).collect()
    }
}

fn refuse_twice(keys: &[String], key: &str) -> Result<(), Error> {
    match keys.iter().any(|other| other == key) {
        true => Err(Error::User(format!(
            "{key} varies twice. Give all of its values at once, for example --vary {key}=1,2."
        ))),
        false => Ok(()),
    }
}

/// `KEY=VALUES`: `1..10` is every whole number from 1 to 10, otherwise values stand between commas outside of brackets and quotes.
fn split(text: &str) -> Result<(String, Vec<String>), Error> {
    let refused = |why: &str| {
        Err(Error::User(format!(
            "--vary {text}: {why}. Write KEY=VALUE,VALUE,... or KEY=FIRST..LAST, for example --vary contact.friction=0.3,0.5 or --vary seed=1..10."
        )))
    };
    let Some((key, values)) = text.split_once('=') else { return refused("there is no equals sign") };
    let (key, values) = (key.trim().to_string(), values.trim());
    if key.is_empty() {
        return refused("there is no key before the equals sign");
    }
    if let Some((first, last)) = values.split_once("..") {
        let whole = |text: &str| text.trim().parse::<i64>().ok();
        return match (whole(first), whole(last)) {
            (Some(first), Some(last)) if first <= last && last.abs_diff(first) < ROWS_MAX as u64 => {
                Ok((key, (first..=last).map(|value| value.to_string()).collect()))
            }
            _ => refused("a range runs from a whole number to one that is not less, through no more than 100,000"),
        };
    }
    let values = between_commas(values);
    if values.iter().any(String::is_empty) {
        return refused("a value is missing");
    }
    if let Some(twice) =
        values.iter().enumerate().find_map(|(index, value)| values[..index].contains(value).then_some(value))
    {
        return refused(&format!("{twice} stands there twice"));
    }
    Ok((key, values))
}

/// Parts between commas that stand in no brackets and no quotes.
fn between_commas(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0, false);
    for letter in text.chars() {
        match letter {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(letter);
        }
    }
    parts.iter().map(|part| part.trim().to_string()).collect()
}

/// Keys and lines of a CSV file.
fn of_file(path: &Path) -> Result<(Vec<String>, Vec<Vec<String>>), Error> {
    let shown = path.display();
    let refused = |why: &dyn std::fmt::Display| {
        Error::User(format!(
            "--rows {shown}: {why}. Give a CSV file: its first line has keys, such as seed,contact.friction, and every other line a value for each."
        ))
    };
    let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(|error| refused(&error))?;
    let header = csv.headers().map_err(|error| refused(&error))?;
    let mut keys: Vec<String> = Vec::new();
    for key in header {
        refuse_twice(&keys, key)?;
        keys.push(key.to_string());
    }
    let lines: Result<Vec<Vec<String>>, csv::Error> =
        csv.records().map(|line| Ok(line?.iter().map(str::to_string).collect())).collect();
    let lines = lines.map_err(|error| refused(&error))?;
    if let Some(line) = lines.iter().position(|line| line.iter().any(String::is_empty)) {
        return Err(refused(&format!("line {} lacks a value", line + 2)));
    }
    match (keys.iter().any(String::is_empty), lines.len()) {
        (true, _) => Err(refused(&"a column has no key")),
        (_, 0) => Err(refused(&"it has no line below its keys")),
        (_, rows) if rows > ROWS_MAX => Err(refused(&format!("it has more than {ROWS_MAX} lines"))),
        _ => Ok((keys, lines)),
    }
}

/// A name from keys and values, the same whatever other rows there are: `seed-1_friction-0.3`.
fn named(keys: &[String], lines: Vec<Vec<String>>) -> Result<Vec<Row>, Error> {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_string();
    // Where two keys end alike, whole paths tell them apart.
    let is_clear = |key: &str| keys.iter().filter(|other| last(other) == last(key)).count() == 1;
    let short: Vec<String> = keys.iter().map(|key| if is_clear(key) { last(key) } else { key.clone() }).collect();
    let mut seen = std::collections::BTreeMap::new();
    let mut rows = Vec::new();
    for values in lines {
        let plain: Vec<String> =
            short.iter().zip(&values).map(|(key, value)| format!("{key}-{}", letters(value))).collect();
        let mut name = plain.join("_");
        let is_told_by_name = values.iter().all(|value| letters(value) == value.replace([' ', '"'], ""));
        if name.len() > NAME_MAX || !is_told_by_name {
            let digest = Sha256::digest(format!("{keys:?}{values:?}").as_bytes());
            let ending: String = digest[..4].iter().map(|byte| format!("{byte:02x}")).collect();
            name.truncate(NAME_MAX);
            name = format!("{name}_{ending}");
        }
        if let Some(other) = seen.insert(name.clone(), values.clone()) {
            return Err(Error::User(format!(
                "Two rows of the sweep have the same values: {} and {}. Leave one of them away.",
                other.join(", "),
                values.join(", ")
            )));
        }
        rows.push(Row { name, values });
    }
    Ok(rows)
}

/// Of a value what a file name can have everywhere.
fn letters(value: &str) -> String {
    let kept = |letter: char| match letter {
        letter if letter.is_ascii_alphanumeric() || ".+-".contains(letter) => Some(letter),
        ' ' | '"' => None,
        _ => Some('_'),
    };
    value.chars().filter_map(kept).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(varied: &[&str]) -> Result<Vec<String>, String> {
        let varied: Vec<String> = varied.iter().map(|text| (*text).to_string()).collect();
        let rows = Rows::of(&varied, None).map_err(|error| error.to_string())?;
        Ok(rows.all.iter().map(|row| format!("{}: {}", row.name, rows.sets(row).join(" "))).collect())
    }

    #[test]
    fn every_combination_is_a_row_and_the_last_key_changes_fastest() {
        assert_eq!(
            rows(&["seed=1..2", "contact.friction = 0.3, 0.5"]).unwrap(),
            [
                "seed-1_friction-0.3: seed=1 contact.friction=0.3",
                "seed-1_friction-0.5: seed=1 contact.friction=0.5",
                "seed-2_friction-0.3: seed=2 contact.friction=0.3",
                "seed-2_friction-0.5: seed=2 contact.friction=0.5",
            ]
        );
    }

    /// Values with units, lists and texts are what `--set` takes; what a name cannot hold is told apart by a digest.
    #[test]
    fn values_stand_between_commas_outside_of_brackets_and_quotes() {
        let found = rows(&["cell.upper=[\"1 cm\", \"2 cm\"],[3, 4]"]).unwrap();
        assert_eq!(found.len(), 2);
        assert!(
            found[0].ends_with("cell.upper=[\"1 cm\", \"2 cm\"]") && found[1].ends_with("cell.upper=[3, 4]"),
            "{found:?}"
        );
        assert!(found[1].starts_with("upper-_3_4__"), "{found:?}");
        assert_eq!(rows(&["packing.stress=100 kPa,200 kPa"]).unwrap()[1], "stress-200kPa: packing.stress=200 kPa");
        let both = rows(&["packing.stress=1", "loading.stress=2"]).unwrap();
        assert_eq!(both, ["packing.stress-1_loading.stress-2: packing.stress=1 loading.stress=2"]);
    }

    #[test]
    fn what_makes_no_rows_is_refused() {
        for (varied, wanted) in [
            (vec![], "needs something that varies"),
            (vec!["seed"], "no equals sign"),
            (vec!["seed=1,,2"], "a value is missing"),
            (vec!["seed=3..1"], "a range runs"),
            (vec!["seed=0..100000000"], "a range runs"),
            (vec!["seed=1,2,1"], "1 stands there twice"),
            (vec!["seed=1", "seed=2"], "seed varies twice"),
            (vec!["seed=1..1000", "a.b=1..1000"], "more than 100000 rows"),
            (vec!["a.b=1.0,1.00"], ""),
        ] {
            match rows(&varied) {
                Err(told) => assert!(!wanted.is_empty() && told.contains(wanted), "{varied:?}: {told}"),
                Ok(_) => assert!(wanted.is_empty(), "{varied:?}"),
            }
        }
    }

    #[test]
    fn lines_of_a_file_are_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("rows.csv");
        std::fs::write(&file, "contact.friction, packing.stress\n0.3, 100 kPa\n0.4, 200 kPa\n").unwrap();
        let rows = Rows::of(&["seed=1,2".to_string()], Some(&file)).unwrap();
        let names: Vec<&str> = rows.all.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(
            names[..3],
            [
                "friction-0.3_stress-100kPa_seed-1",
                "friction-0.3_stress-100kPa_seed-2",
                "friction-0.4_stress-200kPa_seed-1"
            ]
        );
        for (text, wanted) in [
            ("a,b\n1\n", "record 1"),
            ("a,b\n1,\n", "line 2 lacks a value"),
            ("a,b\n", "no line below"),
            ("a,a\n1,2\n", "varies twice"),
        ] {
            std::fs::write(&file, text).unwrap();
            let told = Rows::of(&[], Some(&file)).unwrap_err().to_string();
            assert!(told.contains(wanted), "{told}");
        }
        assert!(Rows::of(&[], Some(&folder.path().join("none.csv"))).unwrap_err().to_string().contains("No such file"));
    }
}
