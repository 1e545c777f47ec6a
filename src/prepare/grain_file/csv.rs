//! Comma-separated values: a header, then a grain a line, in SI units.

use super::{Entry, Source, id, number, vector};
use crate::base::error::Error;
use crate::base::space::{Linear, Space};

/// Last column of exported files: the time of the state, s.
pub const TIME: &str = "time";

/// Columns of exported contacts that nothing is read from: forces follow from places and memories, N.
pub const FORCES: [&str; 2] = ["force_normal", "force_tangential"];

/// First line of a CSV file of contacts without its time: words of the memory go by their law, which alone can read them.
pub fn header_of_contacts(law: &str, words: usize) -> String {
    let memory: String = (0..words).map(|word| format!(",memory_{law}_{word}")).collect();
    format!("lower,higher{memory}")
}

/// First line of a CSV file of grains.
pub fn header<S: Space>() -> &'static str {
    match S::DIMENSION {
        2 => "id,x,y,radius,vx,vy,spin",
        _ => "id,x,y,z,radius,vx,vy,vz,wx,wy,wz",
    }
}

/// The same without velocities.
pub fn header_of_places<S: Space>() -> &'static str {
    match S::DIMENSION {
        2 => "id,x,y,radius",
        _ => "id,x,y,z,radius",
    }
}

/// The grains of a file, in its order. Columns stand in any order; without those of velocities grains are at rest.
pub(super) fn parse<S: Space>(source: &Source, text: &str) -> Result<Vec<Entry<S>>, Error> {
    // Spreadsheets begin a file with a byte-order mark.
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let found = words_of(lines.next().map_or("", |(_, line)| line));
    let (full, places) = (header::<S>(), header_of_places::<S>());
    let Some(columns) = columns_of(&found, full).or_else(|| columns_of(&found, places)) else {
        let message = format!(
            "the first line must name the columns {full}, or {places}, in any order; it is `{}`",
            found.join(",")
        );
        return Err(source.bad(1, &message));
    };
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(index, line)| {
            let words = words_of(line);
            match words.len() == found.len() {
                true => entry(index + 1, &columns.iter().map(|column| words[*column]).collect::<Vec<&str>>()),
                false => Err(format!("{} values, {} are wanted ({})", words.len(), found.len(), found.join(","))),
            }
            .map_err(|what| source.bad(index + 1, &what))
        })
        .collect()
}

/// The values of a line.
pub fn words_of(line: &str) -> Vec<&str> {
    line.split(',').map(str::trim).collect()
}

/// Where each column of a header stands among those found, if they are the same ones. The time and the forces of contacts that
/// exports state may stand beside them: a run starts at time zero, whatever its grains come from.
pub fn columns_of(found: &[&str], header: &str) -> Option<Vec<usize>> {
    let wanted: Vec<&str> = header.split(',').collect();
    let told = [TIME, FORCES[0], FORCES[1]];
    let others = found.iter().filter(|name| !told.contains(name)).count();
    let is_once = |name: &&str| found.iter().filter(|other| *other == name).count() <= 1;
    match others == wanted.len() && told.iter().all(is_once) {
        true => wanted.iter().map(|name| found.iter().position(|other| other == name)).collect(),
        false => None,
    }
}

/// A grain from its values in the order of the header.
fn entry<S: Space>(line: usize, words: &[&str]) -> Result<Entry<S>, String> {
    let id = id(words[0])?;
    let value = |(word, name): (&&str, &str)| number(word).map_err(|what| format!("{what}, in column {name}"));
    let names = header::<S>().split(',').skip(1);
    let numbers = words[1..].iter().zip(names).map(value).collect::<Result<Vec<f64>, String>>()?;
    let (place, rest) = numbers.split_at(S::DIMENSION);
    let (radius, motion) = (rest[0], &rest[1..]);
    let still = motion.is_empty();
    Ok(Entry {
        line,
        id,
        position: vector(place),
        radius,
        velocity: if still { S::Vector::zero() } else { vector(&motion[..S::DIMENSION]) },
        spin: if still { S::Spin::zero() } else { vector(&motion[S::DIMENSION..]) },
        density: None,
    })
}
