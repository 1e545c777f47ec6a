//! All mistakes of a job, each with the line that it is on.

use std::cell::RefCell;

use super::super::tree::Place;
use crate::base::error::Error;

/// Mistakes that are told; of more there is only a count.
const TOLD_MAX: usize = 20;
/// Mistakes that are looked for.
const NOTED_MAX: usize = 100;
/// Characters of the longest line that is shown.
const LINE_MAX: usize = 160;

/// What has been found wrong so far.
#[derive(Debug, Default)]
pub struct Mistakes {
    /// With the line that they are on.
    of_keys: RefCell<Vec<(usize, String)>>,
    /// Of keys that are good by themselves and do not go together.
    of_all: RefCell<Vec<String>>,
}

impl Mistakes {
    /// Whether there are so many that nobody wants to know of more.
    pub fn are_enough(&self) -> bool {
        self.of_keys.borrow().len() >= NOTED_MAX
    }

    pub fn note(&self, place: Option<Place>, error: Error) {
        let (mut known, message) = (self.of_keys.borrow_mut(), error.to_string());
        // A key may be read more than once.
        if known.iter().all(|(_, other)| *other != message) {
            known.push((order(place), message));
        }
    }

    pub fn note_together(&self, error: Error) {
        let (mut known, message) = (self.of_all.borrow_mut(), error.to_string());
        if !known.contains(&message) {
            known.push(message);
        }
    }

    /// The outcome where nothing has been noted. What keys do together is told where each is good by itself: it may be wrong
    /// because one of them is. Afterwards nothing is noted any more.
    pub fn settled<T>(&self, file: &str, outcome: Result<T, Error>) -> Result<T, Error> {
        let (mut of_keys, mut of_all) = (self.of_keys.take(), self.of_all.take());
        if of_keys.is_empty() && of_all.is_empty() {
            return outcome;
        }
        of_keys.sort_by_key(|(order, _)| *order);
        let mut told: Vec<String> = of_keys.into_iter().map(|(_, message)| message).collect();
        if told.is_empty() {
            of_all.extend(outcome.err().map(|error| error.to_string()));
            told = of_all;
        }
        match told.as_mut_slice() {
            [only] => Err(Error::User(std::mem::take(only))),
            all => {
                let more = match all.len().saturating_sub(TOLD_MAX) {
                    0 => String::new(),
                    more => format!("\n\n{more} more are not shown."),
                };
                let shown = all[..all.len().min(TOLD_MAX)].join("\n\n");
                Err(Error::User(format!("{file}: {} mistakes.\n\n{shown}{more}", all.len())))
            }
        }
    }
}

/// In the order of the file, the command line after it, and what is missing last.
fn order(place: Option<Place>) -> usize {
    match place {
        Some(Place::File(spot)) => spot.line,
        Some(Place::Set) => usize::MAX - 2,
        None => usize::MAX - 1,
    }
}

/// The line of a place with marks below what is meant, to be put behind a message.
pub fn excerpt(text: &str, place: Option<Place>) -> Option<String> {
    let Some(Place::File(spot)) = place else { return None };
    let line = text.lines().nth(spot.line - 1).filter(|line| spot.length > 0 && line.chars().count() <= LINE_MAX)?;
    let seen: String = line
        .chars()
        .map(|c| {
            if c == '\t' {
                ' '
            } else if c.is_control() {
                '?'
            } else {
                c
            }
        })
        .collect();
    let number = spot.line.to_string();
    let (margin, before, marks) = (" ".repeat(number.len()), " ".repeat(spot.column), "^".repeat(spot.length));
    Some(format!("\n  {number} | {seen}\n  {margin} | {before}{marks}"))
}
