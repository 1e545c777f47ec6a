//! Comma-separated values: a header, then a grain a line, in SI units.

use super::{Entry, Source, id, number, vector};
use crate::error::Error;
use crate::grain_export::{header, header_of_places};
use crate::space::{Linear, Space};

/// The grains of a file, in its order. Without columns of velocities they are at rest.
pub fn parse<S: Space>(source: &Source, text: &str) -> Result<Vec<Entry<S>>, Error> {
    let mut lines = text.lines().enumerate();
    let found = lines.next().map_or("", |(_, line)| line.trim());
    let (full, places) = (header::<S>(), header_of_places::<S>());
    if found != full && found != places {
        return Err(source.bad(1, &format!("the first line must be `{full}` or `{places}`")));
    }
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(index, line)| entry(index + 1, line, found).map_err(|what| source.bad(index + 1, &what)))
        .collect()
}

fn entry<S: Space>(line: usize, text: &str, header: &str) -> Result<Entry<S>, String> {
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let wanted = header.split(',').count();
    if words.len() != wanted {
        return Err(format!("{} values, {wanted} are wanted ({header})", words.len()));
    }
    let id = id(words[0])?;
    let numbers = words[1..].iter().map(|word| number(word)).collect::<Result<Vec<f64>, String>>()?;
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
