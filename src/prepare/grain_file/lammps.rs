//! LAMMPS data files of `atom_style sphere` in `units si`: a head with the number of atoms and the box, then
//!
//! ```text
//! Atoms # sphere
//! id type diameter density x y z [ix iy iz]
//! Velocities
//! id vx vy vz wx wy wz
//! ```
//!
//! Other sections, types and image flags are passed over. Discs lie in the plane z = 0 (`enforce2d`). Atoms count from 1
//! and grains from 0: atom n is grain n - 1.

use std::collections::BTreeMap;

use super::{Entry, Listing, Source, number, vector};
use crate::base::error::Error;
use crate::base::space::{Linear, Space};

/// The box of a file and the lines it stands in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Lower and upper end per axis, m.
    pub ends: [Option<([f64; 2], usize)>; 3],
    /// xy, xz and yz, m.
    pub tilts: Option<([f64; 3], usize)>,
}

/// What a line belongs to.
#[derive(Clone, Copy, PartialEq)]
enum Section {
    Head,
    Atoms,
    Velocities,
    Other,
}

/// Line, velocity and spin by id.
type Motions = BTreeMap<u64, (usize, [f64; 3], [f64; 3])>;

/// What has been read of a file.
struct Reading<S: Space> {
    atoms: Option<usize>,
    atoms_line: usize,
    bounds: Bounds,
    entries: Vec<Entry<S>>,
    motions: Motions,
}

/// The grains of a file in its order, and its box.
pub fn parse<S: Space>(source: &Source, text: &str) -> Result<Listing<S>, Error> {
    let mut reading =
        Reading { atoms: None, atoms_line: 1, bounds: Bounds::default(), entries: Vec::new(), motions: Motions::new() };
    let mut section = Section::Head;
    // The first line is a title whatever it says.
    for (index, whole) in text.lines().enumerate().skip(1) {
        let (content, comment) = whole.split_once('#').unwrap_or((whole, ""));
        let words: Vec<&str> = content.split_whitespace().collect();
        let line = index + 1;
        let Some(first) = words.first() else { continue };
        let outcome = if first.starts_with(|letter: char| letter.is_ascii_alphabetic()) {
            reading.section(&words, comment, line).map(|found| section = found)
        } else {
            match section {
                Section::Head => reading.head(&words, line),
                Section::Atoms => reading.atom(&words, line),
                Section::Velocities => reading.motion(&words, line),
                Section::Other => Ok(()),
            }
        };
        outcome.map_err(|what| source.bad(line, &what))?;
    }
    reading.finish(source)
}

impl<S: Space> Reading<S> {
    fn section(&mut self, words: &[&str], comment: &str, line: usize) -> Result<Section, String> {
        match words {
            ["Atoms"] => {
                let style = comment.split_whitespace().next().unwrap_or("sphere");
                if style != "sphere" {
                    return Err(format!(
                        "atoms of style `{style}`; grains are of style sphere (id type diameter density x y z)"
                    ));
                }
                self.atoms_line = line;
                Ok(Section::Atoms)
            }
            ["Velocities"] => Ok(Section::Velocities),
            _ => Ok(Section::Other),
        }
    }

    /// Numbers, then what they are.
    fn head(&mut self, words: &[&str], line: usize) -> Result<(), String> {
        let values = words.iter().take_while(|word| number(word).is_ok()).count();
        let (values, names) = words.split_at(values);
        let numbers = values.iter().map(|word| number(word)).collect::<Result<Vec<f64>, String>>()?;
        match (names, &numbers[..]) {
            (["atoms"], [_]) => {
                let count = values[0].parse();
                self.atoms = Some(count.map_err(|_| format!("`{}` is not a number of atoms", values[0]))?);
            }
            (["xlo", "xhi"], [lower, upper]) => self.bounds.ends[0] = Some(([*lower, *upper], line)),
            (["ylo", "yhi"], [lower, upper]) => self.bounds.ends[1] = Some(([*lower, *upper], line)),
            (["zlo", "zhi"], [lower, upper]) => self.bounds.ends[2] = Some(([*lower, *upper], line)),
            (["xy", "xz", "yz"], [xy, xz, yz]) => self.bounds.tilts = Some(([*xy, *xz, *yz], line)),
            (["avec" | "bvec" | "cvec"] | ["abc", "origin"], _) => {
                return Err("a box of edges in any direction is not read; write xlo xhi and the like".into());
            }
            // Types, bonds and what else there is.
            ([_, ..], [_, ..]) => {}
            _ => return Err(format!("`{}` is neither a line of the head nor a section", words.join(" "))),
        }
        Ok(())
    }

    fn atom(&mut self, words: &[&str], line: usize) -> Result<(), String> {
        if words.len() != 7 && words.len() != 10 {
            let what = "7 are wanted (id type diameter density x y z), or 10 with image flags";
            return Err(format!("{} values, {what}", words.len()));
        }
        let id = grain(words[0])?;
        let mut numbers = [0.0; 5];
        for (number, word) in numbers.iter_mut().zip(&words[2..]) {
            *number = super::number(word)?;
        }
        let [diameter, density, place @ ..] = numbers;
        if density <= 0.0 {
            return Err(format!("density = {density} must be positive"));
        }
        refuse_off_plane::<S>("z", place[2], "m")?;
        self.entries.push(Entry {
            line,
            id,
            position: vector(&place[..S::DIMENSION]),
            radius: 0.5 * diameter,
            velocity: S::Vector::zero(),
            spin: S::Spin::zero(),
            density: Some(density),
        });
        Ok(())
    }

    fn motion(&mut self, words: &[&str], line: usize) -> Result<(), String> {
        if words.len() != 7 {
            return Err(format!("{} values, 7 are wanted (id vx vy vz wx wy wz)", words.len()));
        }
        let id = grain(words[0])?;
        let (mut velocity, mut spin) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            (velocity[axis], spin[axis]) = (number(words[1 + axis])?, number(words[4 + axis])?);
        }
        refuse_off_plane::<S>("vz", velocity[2], "m/s")?;
        refuse_off_plane::<S>("wx", spin[0], "rad/s")?;
        refuse_off_plane::<S>("wy", spin[1], "rad/s")?;
        match self.motions.insert(id, (line, velocity, spin)) {
            Some((before, ..)) => Err(format!("atom {} has its velocity in line {before} already", id + 1)),
            None => Ok(()),
        }
    }

    fn finish(mut self, source: &Source) -> Result<Listing<S>, Error> {
        let Some(atoms) = self.atoms else {
            return Err(source.bad(1, "the head has no line `N atoms`"));
        };
        if atoms != self.entries.len() {
            let what = format!("{} atoms, and the head promises {atoms}; the file is incomplete", self.entries.len());
            return Err(source.bad(self.atoms_line, &what));
        }
        for entry in &mut self.entries {
            if let Some((_, velocity, spin)) = self.motions.remove(&entry.id) {
                entry.velocity = vector(&velocity[..S::DIMENSION]);
                entry.spin = vector(&spin);
            }
        }
        match self.motions.first_key_value() {
            Some((id, (line, ..))) => Err(source.bad(*line, &format!("there is no atom {} in section Atoms", id + 1))),
            None => Ok(Listing { entries: self.entries, bounds: Some(self.bounds) }),
        }
    }
}

/// The grain of an atom.
fn grain(word: &str) -> Result<u64, String> {
    super::id(word)
        .ok()
        .and_then(|atom| atom.checked_sub(1))
        .ok_or_else(|| format!("`{word}` is not an atom; whole numbers from 1 on are"))
}

/// Discs stay in their plane.
fn refuse_off_plane<S: Space>(name: &str, value: f64, unit: &str) -> Result<(), String> {
    if S::DIMENSION == 2 && value != 0.0 {
        return Err(format!(
            "{name} = {value} {unit}, and the job's grains are discs in the plane z = 0; write 0, or cell.space = \"solid\""
        ));
    }
    Ok(())
}
