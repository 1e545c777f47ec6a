//! Every key of jobs for people and for editors, from what the types declare.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::schema::Kind;
use crate::base::error::Error;
use crate::base::keys::{DefaultValue, Key, Table, Wants};
use crate::base::units::nearest;

/// Columns of a page.
const WIDTH: usize = 100;

/// The tables of jobs, or all about one of them.
pub fn page(name: Option<&str>) -> Result<String, Error> {
    match name {
        None => Ok(overview()),
        Some(name) => of_table(name),
    }
}

/// Every table with its keys, as a page of the documentation.
pub fn markdown() -> String {
    let mut page = String::from(
        "# Keys of jobs\n\nWhat `scree keys` tells, table by table; made by `SCREE_ACCEPT=1 cargo test --release --lib reference`. Quantities are numbers in SI\nunits, or text with a unit. Compression is positive in all that is called stress or pressure.\n",
    );
    for name in names() {
        let shown = if name.is_empty() { "job" } else { &name };
        let text = of_table(shown).expect("every table has a page");
        write!(page, "\n## {shown}\n\n```\n{}\n```\n", text.trim_end()).expect("a string takes every write");
    }
    page
}

/// Kinds of jobs that have a table.
fn kinds_with(name: &str) -> Vec<Kind> {
    Kind::ALL.into_iter().filter(|kind| find(*kind, name).is_some()).collect()
}

/// A table of any depth.
fn find(kind: Kind, name: &str) -> Option<&'static Table> {
    kind.tables_of_all_depths().into_iter().find(|table| table.name == name)
}

fn names() -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for table in Kind::ALL.into_iter().flat_map(Kind::tables_of_all_depths) {
        if !names.contains(&table.name) {
            names.push(table.name.clone());
        }
    }
    names
}

fn overview() -> String {
    let mut page = String::from(
        "Tables of a job. `scree keys TABLE` tells the keys of one, `scree keys job` those above the first table, `scree keys friction` or\n`scree keys contact.friction` one key.\n\n",
    );
    for name in names() {
        let kinds = kinds_with(&name);
        let table = find(kinds[0], &name).expect("one of them has it");
        let shown = if name.is_empty() { "job".to_string() } else { table.words() };
        let of = if kinds.len() == Kind::ALL.len() { String::new() } else { format!(" ({})", list(&kinds)) };
        writeln!(page, "  {shown:<22} {}{of}", table.about).expect("a string takes every write");
    }
    page
}

fn list(kinds: &[Kind]) -> String {
    kinds.iter().map(|kind| kind.words().0).collect::<Vec<_>>().join(", ")
}

fn of_table(name: &str) -> Result<String, Error> {
    let bare = name.trim_matches(|c| c == '[' || c == ']');
    let bare = if bare == "job" { "" } else { bare };
    if kinds_with(bare).is_empty() {
        return of_one_key(bare);
    }
    Ok(told(bare, &|_| true))
}

/// A key by its name, or by its table and its name.
fn of_one_key(name: &str) -> Result<String, Error> {
    let names = names();
    let (of, key) = match name.rsplit_once('.') {
        Some((table, key)) => (Some(table), key),
        None => (None, name),
    };
    let wanted = names.iter().filter(|name| of.is_none_or(|table| *name == table));
    let page: String = wanted.map(|table| told(table, &|known| known.name == key)).collect();
    if !page.is_empty() {
        return Ok(page);
    }
    let alike = keys_that_mean(key);
    if !alike.is_empty() {
        return Ok(format!("A job has no table and no key {name}. These have the word, or mean it:\n\n{alike}"));
    }
    let keys = Kind::ALL.into_iter().flat_map(Kind::tables_of_all_depths).flat_map(|table| &table.keys);
    let known = names.iter().map(String::as_str).chain(keys.map(|key| key.name));
    let advice = match nearest(key, known) {
        Some(near) => format!("Did you mean {near}?"),
        None => {
            "scree keys lists the tables; docs/howto.md has answers, docs/columns.md what series.csv holds.".to_string()
        }
    };
    Err(Error::User(format!("A job has no table and no key {name}. {advice}")))
}

/// A line for each key that has the word in its name or in what it means.
fn keys_that_mean(word: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for table in Kind::ALL.into_iter().flat_map(Kind::tables_of_all_depths) {
        for key in table.keys_that_mean(word) {
            let line = format!("  {:<32} {}\n", table.path(key.name), key.about);
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
    }
    lines.concat()
}

/// The keys of a table that are wanted; nothing where it has none of them.
fn told(bare: &str, wanted: &dyn Fn(&Key) -> bool) -> String {
    // Kinds of jobs whose table is the same are told of together.
    let mut told: Vec<(Vec<Kind>, String)> = Vec::new();
    for kind in kinds_with(bare) {
        let table = find(kind, bare).expect("it has the table");
        let keys: String = table.keys.iter().filter(|key| wanted(key)).map(of_key).collect();
        if keys.is_empty() {
            continue;
        }
        match told.iter_mut().find(|(_, other)| *other == keys) {
            Some((same, _)) => same.push(kind),
            None => told.push((vec![kind], keys)),
        }
    }
    let mut page = String::new();
    for (kinds, keys) in told {
        let table = find(kinds[0], bare).expect("it has the table");
        let head = if bare.is_empty() { "Above the first table".to_string() } else { table.words() };
        write!(page, "{head}: {}; in {}\n\n{keys}\n", table.about, list(&kinds)).expect("a string takes every write");
    }
    page
}

fn of_key(key: &Key) -> String {
    let mut said = format!("{}. {}", capital(key.about), words(&key.wants));
    said += &match key.default {
        DefaultValue::Required => "; required".to_string(),
        DefaultValue::RequiredIn(words) => format!("; required {words}"),
        DefaultValue::Value(value) => format!("; default {value}"),
        DefaultValue::Follows(words) => format!("; default: {words}"),
        DefaultValue::None => "; may be left out".to_string(),
    };
    for selector in selectors(key) {
        let choices: Vec<&str> =
            key.owners.iter().filter(|owner| owner.selector == selector).map(|owner| owner.choice).collect();
        said += &format!("; with {selector} = \"{}\"", choices.join("\" or \""));
    }
    let mut text = format!("  {} = {}\n", key.name, key.example(2));
    let mut line = String::from("     ");
    for word in said.split(' ') {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            text += &(std::mem::replace(&mut line, String::from("     ")) + "\n");
        }
        line += &format!(" {word}");
    }
    text + &line + ".\n"
}

fn selectors(key: &Key) -> Vec<&'static str> {
    let mut selectors: Vec<&'static str> = key.owners.iter().map(|owner| owner.selector).collect();
    selectors.dedup();
    selectors
}

fn capital(text: &str) -> String {
    const GREEK: [&str; 7] = ["beta", "chi", "eta", "gamma", "mu", "xi", "zeta"];
    // Symbols such as k_n and phi_cs stay as they are.
    let is_symbol = |word: &str| word.contains('_') || word.len() == 1 && word != "a" || GREEK.contains(&word);
    match text.split([' ', ',']).next() {
        Some(word) if is_symbol(word) => text.to_string(),
        _ => text.chars().take(1).flat_map(char::to_uppercase).chain(text.chars().skip(1)).collect(),
    }
}

/// What a key may be.
fn words(wants: &Wants) -> String {
    match wants {
        Wants::Text => "Text".to_string(),
        Wants::Choice(names) => format!("One of \"{}\"", names.join("\", \"")),
        Wants::Flag => "Either true or false".to_string(),
        Wants::Flags => "Either true or false for each axis".to_string(),
        Wants::Count(min, max) => format!("A whole number between {min} and {max}"),
        Wants::Number(dimension, range) => {
            let unit = dimension.unit();
            let shown = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
            format!("{}{shown}, {}", capital(&dimension.words()), range.words(&unit))
        }
        Wants::Vector(dimension) => {
            let (unit, words) = (dimension.unit(), capital(&dimension.words()));
            if unit.is_empty() { format!("{words} for each axis") } else { format!("{words} for each axis, in {unit}") }
        }
        Wants::Spin => "A spin (rad/s); in space one for each axis".to_string(),
        Wants::Gradient => "A row of rates (1/s) for each axis".to_string(),
        Wants::Stresses => "A stress (Pa) or \"free\" for each axis".to_string(),
        Wants::Shares => "Pairs of a length and a share".to_string(),
        Wants::Polygon => "Three or more points".to_string(),
        Wants::Table(table) => format!("A table with {}", table.key_list()),
        Wants::Tables(table) => format!("Any number of tables [[{}]] with {}", table.name, table.key_list()),
    }
}

/// A JSON Schema of jobs, for editors that know TOML.
pub fn json_schema() -> Value {
    let mut properties = Map::new();
    for kind in Kind::ALL {
        for table in kind.tables() {
            if table.name.is_empty() {
                table.keys.iter().for_each(|key| merge(&mut properties, key.name, of_json(key)));
            } else {
                merge(&mut properties, &table.name, object(table));
            }
        }
    }
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A job of scree",
        "description": "Quantities are numbers in SI units, or text with a unit. Which keys go together `scree check` tells.",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "required": ["name"],
    })
}

/// Where kinds of jobs have a key in different forms, an editor takes either.
fn merge(properties: &mut Map<String, Value>, name: &str, new: Value) {
    match properties.get_mut(name) {
        None => drop(properties.insert(name.to_string(), new)),
        Some(old) if *old == new => {}
        Some(old) => {
            for place in ["/properties", "/items/properties"] {
                if let (Some(Value::Object(old)), Some(Value::Object(new))) =
                    (old.pointer_mut(place), new.pointer(place))
                {
                    new.iter().for_each(|(name, value)| merge(old, name, value.clone()));
                    return;
                }
            }
            match old.get_mut("anyOf") {
                Some(Value::Array(choices)) if !choices.contains(&new) => choices.push(new),
                Some(_) => {}
                None => *old = json!({ "anyOf": [old.clone(), new] }),
            }
        }
    }
}

fn object(table: &Table) -> Value {
    let mut properties = Map::new();
    table.keys.iter().for_each(|key| merge(&mut properties, key.name, of_json(key)));
    json!({ "type": "object", "description": table.about, "properties": properties, "additionalProperties": false })
}

fn of_json(key: &Key) -> Value {
    let quantity = json!({ "type": ["number", "string"] });
    let list = |item: Value| json!({ "type": "array", "items": item });
    let mut value = match &key.wants {
        Wants::Text => json!({ "type": "string" }),
        Wants::Choice(names) => json!({ "enum": names }),
        Wants::Flag => json!({ "type": "boolean" }),
        Wants::Flags => list(json!({ "type": "boolean" })),
        Wants::Count(min, max) => json!({ "type": "integer", "minimum": min, "maximum": max }),
        Wants::Number(dimension, range) => {
            let mut value = quantity;
            let bound = |open: bool, word: &str| match open {
                true => format!("exclusive{}", capital(word)),
                false => word.to_string(),
            };
            if range.min.is_finite() {
                value[bound(range.min_open, "minimum")] = json!(range.min);
            }
            if range.max.is_finite() {
                value[bound(range.max_open, "maximum")] = json!(range.max);
            }
            value["x-unit"] = json!(dimension.unit());
            value
        }
        Wants::Vector(dimension) => {
            let mut value = list(quantity);
            value["x-unit"] = json!(dimension.unit());
            value
        }
        Wants::Spin => json!({ "type": ["number", "string", "array"], "x-unit": "rad/s" }),
        Wants::Gradient => list(list(quantity)),
        Wants::Stresses => list(quantity),
        Wants::Shares | Wants::Polygon => list(list(quantity)),
        Wants::Table(table) => object(table),
        Wants::Tables(table) => list(object(table)),
    };
    value["description"] = json!(format!("{}. {}", capital(key.about), words(&key.wants)));
    value["examples"] = json!([key.example(2)]);
    if let DefaultValue::Value(default) = key.default {
        value["default"] = json!(default.trim_matches('"'));
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_has_a_page() {
        for name in names() {
            let shown = if name.is_empty() { "job".to_string() } else { name };
            let page = page(Some(&shown)).unwrap();
            assert!(page.lines().all(|line| line.chars().count() <= 160), "{page}");
        }
        let wrong = page(Some("contcat")).unwrap_err().to_string();
        assert_eq!(wrong, "A job has no table and no key contcat. Did you mean contact?");
        let wrong = page(Some("contact.fricton")).unwrap_err().to_string();
        assert_eq!(wrong, "A job has no table and no key contact.fricton. Did you mean friction?");
        let by_symbol = page(Some("mu")).unwrap();
        assert!(by_symbol.contains("contact.friction                 mu, the Coulomb coefficient\n"), "{by_symbol}");
        let by_word = page(Some("rolling")).unwrap();
        assert!(
            by_word.contains("contact.rolling_stiffness ") && by_word.contains("contact.rolling_limit "),
            "{by_word}"
        );
        let unknown = page(Some("porosity")).unwrap_err().to_string();
        assert!(unknown.contains("docs/howto.md"), "{unknown}");
        let contact = page(Some("[contact]")).unwrap();
        assert!(contact.contains("in jobs of planar shear, assemblies of grains, continua"), "{contact}");
        assert!(contact.contains("with law = \"hertz_mindlin\""), "{contact}");
        assert!(contact.contains("required unless friction_angle"), "{contact}");
        let friction = page(Some("contact.friction")).unwrap();
        assert!(friction.contains("friction = 0.5") && !friction.contains("stiffness"), "{friction}");
        let every = page(Some("friction")).unwrap();
        assert!(every.contains("[contact]") && every.contains("[packing]") && every.contains("[[body]]"), "{every}");
    }

    /// The page in the documentation is that of the program.
    #[test]
    fn the_documentation_has_every_key() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/keys.md");
        if std::env::var_os("SCREE_ACCEPT").is_some() {
            std::fs::write(path, markdown()).unwrap();
        }
        assert!(std::fs::read_to_string(path).unwrap_or_default() == markdown(), "docs/keys.md is old: see its head");
    }

    /// An editor that checks a job by it finds every key of every shipped job.
    #[test]
    fn the_schema_has_every_key() {
        let schema = json_schema();
        assert_eq!(schema["properties"]["contact"]["properties"]["friction"]["maximum"], 5.0);
        assert_eq!(schema["properties"]["grid"]["properties"]["cell"]["x-unit"], "m");
        let faces = &schema["properties"]["boundary"]["items"]["properties"]["face"]["enum"];
        assert!(faces.as_array().unwrap().contains(&json!("z_lower")), "{faces}");
        assert_eq!(schema["properties"]["body"]["items"]["properties"]["servo"]["type"], "object");
        for kind in Kind::ALL {
            for path in kind.paths() {
                let mut at = &schema;
                for part in path.split('.') {
                    at = if part == "0" { &at["items"] } else { &at["properties"][part] };
                    at = at["anyOf"].as_array().and_then(|choices| choices.last()).unwrap_or(at);
                }
                assert!(at["description"].is_string(), "{path}");
            }
        }
    }
}
