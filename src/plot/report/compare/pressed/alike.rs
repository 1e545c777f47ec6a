//! Whether runs are of one specimen and test: only those can be compared.

use toml::{Table, Value};

use super::press::material;
use crate::base::error::Error;
use crate::plot::report::load::lookup;
use crate::plot::report::records::Record;

/// What makes a specimen and its test, whatever it is simulated with. The grid is behind all of it, and material and regions'
/// fractions are the continuum's.
const SAME: [&str; 10] =
    ["grid.space", "grid.depth", "grains", "contact", "packing", "stress", "gravity", "load", "boundary", "body"];
/// What of that results do not depend on, or follows from the grid.
const ANY: [&str; 2] = ["cache", "spacing"];
/// Share of the specimen by which regions may differ, as whole cells make them.
const SLACK: f64 = 0.01;

/// Refuses runs that differ from the first in more than packing, method and grid.
pub fn check(records: &[&Record]) -> Result<(), Error> {
    let Some((first, others)) = records.split_first() else { return Ok(()) };
    for other in others {
        if let Some(what) = difference_of(&first.scenario, &other.scenario) {
            return Err(Error::User(format!(
                "{} cannot be compared with {}: {what}. Compare runs that differ in method, seed, grid or material alone, or make \
                 a report of each by itself.",
                other.directory.display(),
                first.directory.display()
            )));
        }
    }
    Ok(())
}

fn difference_of(first: &Table, other: &Table) -> Option<String> {
    let paths = SAME.into_iter().chain(["membrane"]);
    let told = paths.filter_map(|path| difference(path, lookup(first, path), lookup(other, path))).next();
    told.or_else(|| {
        let [ends, others] = [material(first)?, material(other)?];
        let slack = SLACK * ends.iter().map(|[lower, upper]| upper - lower).fold(0.0, f64::max);
        let off = |(a, b): (&f64, &f64)| (a - b).abs() > slack;
        let differ = ends.as_flattened().iter().zip(others.as_flattened()).any(off);
        let tell = |[x, y]: [[f64; 2]; 2]| format!("{} to {} and {} to {}", x[0], x[1], y[0], y[1]);
        differ.then(|| format!("its material reaches from {} m, that of the other from {} m", tell(others), tell(ends)))
    })
}

/// The first place below a path at which two values differ, and how.
fn difference(path: &str, first: Option<&Value>, other: Option<&Value>) -> Option<String> {
    match (first, other) {
        (Some(Value::Table(first)), Some(Value::Table(other))) => {
            let keys = first.keys().chain(other.keys().filter(|key| !first.contains_key(*key)));
            let mut keys = keys.filter(|key| !ANY.contains(&key.as_str()));
            keys.find_map(|key| difference(&format!("{path}.{key}"), first.get(key), other.get(key)))
        }
        (Some(Value::Array(first)), Some(Value::Array(other))) if has_tables(first) && first.len() == other.len() => {
            let name = |index: usize| {
                let name = first[index].get("name").and_then(Value::as_str);
                name.map_or_else(|| format!("{path}[{index}]"), |name| format!("{path}.{name}"))
            };
            let mut pairs = first.iter().zip(other).enumerate();
            pairs.find_map(|(index, (first, other))| difference(&name(index), Some(first), Some(other)))
        }
        (first, other) if first == other => None,
        (first, other) => {
            let tell = |value: Option<&Value>| match value {
                Some(Value::Array(list)) if has_tables(list) => format!("{} of them", list.len()),
                Some(Value::Table(_)) => "there".to_owned(),
                Some(value) => value.to_string(),
                None => "not there".to_owned(),
            };
            Some(format!("`{path}` is {} in it and {} in the other", tell(other), tell(first)))
        }
    }
}

fn has_tables(list: &[Value]) -> bool {
    list.first().is_some_and(Value::is_table)
}

#[cfg(test)]
mod tests {
    use super::*;

    const JOB: &str = "[grid]\ndepth = 0.01\ncell = 0.003\n[grains]\ndensity = 2530.0\n[packing]\ncache = \"a\"\n[[region]]\n\
                       lower = [0.0, 0.0]\nupper = [0.06, 0.09]\n[[body]]\nname = \"base\"\npoint = [0.0, 0.0]\n[[body]]\n\
                       name = \"plate\"\npoint = [0.0, 0.09]\n[[membrane]]\nname = \"left\"\npressure = 1e5\nspacing = 0.0015\n";

    fn told(from: &str, to: &str) -> Option<String> {
        assert!(JOB.contains(from));
        difference_of(&toml::from_str(JOB).unwrap(), &toml::from_str(&JOB.replace(from, to)).unwrap())
    }

    #[test]
    fn what_differs_is_named() {
        for (from, to) in
            [("0.003", "0.002"), ("\"a\"", "\"b\""), ("0.0015", "0.001"), ("[0.06, 0.09]", "[0.0605, 0.09]")]
        {
            assert_eq!(told(from, to), None, "{to}");
        }
        for (from, to, wanted) in [
            ("2530.0", "2600.0", "`grains.density` is 2600.0 in it and 2530.0 in the other"),
            ("point = [0.0, 0.09]", "point = [0.0, 0.1]", "`body.plate.point` is [0.0, 0.1] in it"),
            ("pressure = 1e5", "pressure = 2e5", "`membrane.left.pressure` is 200000.0"),
            ("density = 2530.0", "", "`grains.density` is not there in it"),
            ("[[body]]\nname = \"base\"\npoint = [0.0, 0.0]\n", "", "`body` is 1 of them in it and 2 of them"),
            (
                "upper = [0.06, 0.09]",
                "upper = [0.08, 0.09]",
                "reaches from 0 to 0.08 and 0 to 0.09 m, that of the other",
            ),
        ] {
            let told = told(from, to).unwrap_or_default();
            assert!(told.contains(wanted), "{told}");
        }
    }
}
