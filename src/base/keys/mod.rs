//! Keys of jobs. A type declares each of its keys once, in a function that is given a [`Form`]: one form reads them from what was
//! typed, one writes them, and one describes them for messages, help and schemas.

use std::path::PathBuf;

use crate::base::units::Dimension;

mod description;
mod range;

pub use description::Description;
pub use range::Range;

/// A pure number.
pub const RATIO: Dimension = Dimension::RATIO;
/// rad.
pub const ANGLE: Dimension = Dimension::ANGLE;
/// m.
pub const LENGTH: Dimension = Dimension::LENGTH;
/// m/s.
pub const SPEED: Dimension = Dimension::SPEED;
/// s.
pub const TIME: Dimension = Dimension::TIME;
/// kg.
pub const MASS: Dimension = Dimension::MASS;
/// N.
pub const FORCE: Dimension = Dimension::FORCE;
/// Pa.
pub const STRESS: Dimension = Dimension::STRESS;
/// kg/m3.
pub const DENSITY: Dimension = Dimension::DENSITY;
/// N/m.
pub const STIFFNESS: Dimension = Dimension::STIFFNESS;
/// N s/m.
pub const DAMPING: Dimension = Dimension::DAMPING;
/// Finite and more than 0.
pub const POSITIVE: Range = Range::POSITIVE;
/// Finite, 0 or more.
pub const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;

/// A key of a table.
#[derive(Clone, Debug)]
pub struct Key {
    /// As it is typed left of the equals sign, without its table.
    pub name: &'static str,
    /// What it means, as a part of a sentence.
    pub about: &'static str,
    /// As it would be typed right of the equals sign; of a vector one component, or all of those in the plane.
    pub example: &'static str,
    /// Kind of its value, with dimension and bounds.
    pub wants: Wants,
    /// Required where nothing else is said, as [`key`] makes it.
    pub default: DefaultValue,
    /// Which choices of which other keys it belongs to; to all where there are none.
    pub owners: Vec<Owner>,
}

/// A choice of a selector, such as `law` and `linear`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Name of the key that chooses, in the same table.
    pub selector: &'static str,
    /// One of the words that it may be given.
    pub choice: &'static str,
}

/// What a key is where it is not typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefaultValue {
    /// It must be typed, unless nothing looks at its table.
    Required,
    /// It must be typed in some jobs, said in words behind `required`: "unless count is given".
    RequiredIn(&'static str),
    /// This, as it would be typed.
    Value(&'static str),
    /// What follows from other keys, in words.
    Follows(&'static str),
    /// Nothing: what it stands for is not there.
    None,
}

impl DefaultValue {
    /// Whether it must be typed where a form asks for it.
    pub const fn is_required(self) -> bool {
        matches!(self, Self::Required | Self::RequiredIn(_))
    }
}

/// What is to be typed right of the equals sign.
#[derive(Clone, Debug)]
pub enum Wants {
    /// Words in quotes, not empty, or a path. Of a choice or of tables it stands in until [`Description`] has met them.
    Text,
    /// One of these words.
    Choice(Vec<&'static str>),
    /// `true` or `false`.
    Flag,
    /// The same, one for each axis.
    Flags,
    /// A whole number between two bounds, both allowed.
    Count(u64, u64),
    /// A quantity of that dimension, its bounds in SI units.
    Number(Dimension, Range),
    /// A number for each axis.
    Vector(Dimension),
    /// A number in the plane, a vector in space.
    Spin,
    /// A row of rates for each axis.
    Gradient,
    /// A stress or "free" for each axis.
    Stresses,
    /// Pairs of a length and a share.
    Shares,
    /// Three or more points of the plane.
    Polygon,
    /// One table with keys of its own.
    Table(Box<Table>),
    /// Any number of them.
    Tables(Box<Table>),
}

/// A `[table]` of the job, or the job's top level when `name` is empty.
#[derive(Clone, Debug)]
pub struct Table {
    /// `contact`, or `body.servo` of one within another.
    pub name: String,
    /// What it is for, as a part of a sentence.
    pub about: &'static str,
    /// Written as `[[name]]`, any number of times.
    pub many: bool,
    /// Each once, in the order in which they are declared.
    pub keys: Vec<Key>,
}

/// A key that must be typed and belongs to all choices.
pub const fn key(name: &'static str, about: &'static str, wants: Wants, example: &'static str) -> Key {
    Key { name, about, example, wants, default: DefaultValue::Required, owners: Vec::new() }
}

/// A required key of words in quotes.
pub const fn text(name: &'static str, about: &'static str, example: &'static str) -> Key {
    key(name, about, Wants::Text, example)
}

/// A required key that is `true` or `false`.
pub const fn flag(name: &'static str, about: &'static str, example: &'static str) -> Key {
    key(name, about, Wants::Flag, example)
}

/// A required key of a whole number from `min` to `max`, both allowed.
pub const fn count(name: &'static str, about: &'static str, (min, max): (u64, u64), example: &'static str) -> Key {
    key(name, about, Wants::Count(min, max), example)
}

/// A required key of a quantity, `range` in SI units.
pub const fn number(
    name: &'static str,
    about: &'static str,
    dimension: Dimension,
    range: Range,
    example: &'static str,
) -> Key {
    key(name, about, Wants::Number(dimension, range), example)
}

/// A required key of a finite quantity for each axis.
pub const fn vector(name: &'static str, about: &'static str, dimension: Dimension, example: &'static str) -> Key {
    key(name, about, Wants::Vector(dimension), example)
}

impl Key {
    /// By default this, as it would be typed.
    pub const fn or(mut self, value: &'static str) -> Self {
        self.default = DefaultValue::Value(value);
        self
    }

    /// By default what the value is before it is read, which follows from other keys.
    pub const fn follows(mut self, words: &'static str) -> Self {
        self.default = DefaultValue::Follows(words);
        self
    }

    /// It must be typed in some jobs alone: `required("unless friction_angle is given")`. Who reads it asks for it in these.
    pub const fn required(mut self, words: &'static str) -> Self {
        self.default = DefaultValue::RequiredIn(words);
        self
    }

    /// It may be left out, and then is not there.
    pub const fn optional(mut self) -> Self {
        self.default = DefaultValue::None;
        self
    }

    /// The table that this key holds one or many of.
    pub fn inner(&self) -> Option<&Table> {
        match &self.wants {
            Wants::Table(inner) | Wants::Tables(inner) => Some(inner),
            _ => None,
        }
    }

    /// As it would be typed in a space of that many axes.
    pub fn example(&self, axes: usize) -> String {
        let list = |of: &str, count: usize| format!("[{}]", vec![of; count].join(", "));
        match self.wants {
            // A list is of the plane; in space nothing comes first.
            Wants::Vector(_) if self.example.starts_with('[') => match axes {
                3 => self.example.replacen('[', "[0, ", 1),
                _ => self.example.to_string(),
            },
            Wants::Vector(_) | Wants::Flags | Wants::Stresses => list(self.example, axes),
            Wants::Spin if axes == 3 => list(self.example, 3),
            Wants::Gradient => list(&list(self.example, axes), axes),
            _ => self.example.to_string(),
        }
    }
}

impl Table {
    /// None where it has no key of that name.
    pub fn key(&self, name: &str) -> Option<&Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// `contact.friction`, or `name` at the top level.
    pub fn path(&self, key: &str) -> String {
        match self.name.as_str() {
            "" => key.to_string(),
            name => format!("{name}.{key}"),
        }
    }

    /// For a sentence: `[contact]` or `the job`.
    pub fn words(&self) -> String {
        match (self.name.as_str(), self.many) {
            ("", _) => "the job's top level".to_string(),
            (name, true) => format!("[[{name}]]"),
            (name, false) => format!("[{name}]"),
        }
    }

    /// Keys that have the word in their name or in what they mean: `friction`, "mu, the Coulomb coefficient", of `mu`.
    pub fn keys_that_mean<'a>(&'a self, word: &'a str) -> impl Iterator<Item = &'a Key> {
        // Of symbols the case counts: G is not g.
        let same = move |part: &str| part == word || word.len() > 2 && part.eq_ignore_ascii_case(word);
        self.keys.iter().filter(move |key| {
            let of_name = key.name.split('_').chain([key.name]);
            of_name.chain(key.about.split(|c: char| !c.is_alphanumeric() && c != '_')).any(same)
        })
    }

    /// Names of its keys for a message: `friction, stiffness`.
    pub fn key_list(&self) -> String {
        let names: Vec<&str> = self.keys.iter().map(|key| key.name).collect();
        names.join(", ")
    }
}

/// What keys are read from, written to or described by. On reading, a value is what the key is by default, where that follows
/// from others; afterwards it is what was typed, or where that was refused the example of the key.
pub trait Form {
    /// Components that a vector has: 2 in the plane, 3 in space.
    fn axes(&self) -> usize;
    /// 2 in the plane, 3 in space; for what is visited from here on.
    fn set_axes(&mut self, axes: usize);
    /// In SI units, within the range of the key.
    fn number(&mut self, value: &mut f64, key: Key);
    /// The same, none where it is not typed.
    fn number_if_given(&mut self, value: &mut Option<f64>, key: Key);
    /// As [`Form::vector`], none where it is not typed.
    fn vector_if_given(&mut self, value: &mut Option<[f64; 3]>, key: Key);
    /// As [`Form::spin`], none where it is not typed.
    fn spin_if_given(&mut self, value: &mut Option<[f64; 3]>, key: Key);
    /// A whole number within the bounds of the key.
    fn count(&mut self, value: &mut u64, key: Key);
    /// `true` or `false`.
    fn flag(&mut self, value: &mut bool, key: Key);
    /// A truth value for each axis; beyond them false.
    fn flags(&mut self, value: &mut [bool; 3], key: Key);
    /// Words in quotes, not empty.
    fn text(&mut self, value: &mut String, key: Key);
    /// Relative ones start from the folder of the job.
    fn path(&mut self, value: &mut PathBuf, key: Key);
    /// As [`Form::path`], none where it is not typed.
    fn path_if_given(&mut self, value: &mut Option<PathBuf>, key: Key);
    /// A number for each axis; beyond them zero.
    fn vector(&mut self, value: &mut [f64; 3], key: Key);
    /// In the plane a number, about the axis out of it; in space a vector.
    fn spin(&mut self, value: &mut [f64; 3], key: Key);
    /// A row of rates for each axis.
    fn gradient(&mut self, value: &mut [[f64; 3]; 3], key: Key);
    /// For each axis a stress, or none where it is "free".
    fn stresses(&mut self, value: &mut Option<[Option<f64>; 3]>, key: Key);
    /// Pairs of a length and a share, all positive.
    fn shares(&mut self, value: &mut Vec<(f64, f64)>, key: Key);
    /// Corners of a polygon in the plane.
    fn polygon(&mut self, value: &mut Vec<[f64; 2]>, key: Key);
    /// The place of one of some names; `noun` says what they are. What is yielded is which choices are to be visited.
    fn choice(&mut self, chosen: usize, noun: &str, names: &[&'static str], key: Key) -> std::ops::Range<usize>;
    /// Keys from here on belong to a choice, until [`Form::leave`].
    fn enter(&mut self, owner: Owner);
    /// Ends what the last [`Form::enter`] began.
    fn leave(&mut self);
    /// A table of its own, where there is one; whether it was visited. Tables come last among the keys of a table.
    fn table(&mut self, is_there: bool, key: Key, about: &'static str, inside: &mut dyn FnMut(&mut dyn Form)) -> bool;
    /// A table for each of `count` items; on reading, for each that was typed.
    fn tables(&mut self, count: usize, key: Key, about: &'static str, each: &mut dyn FnMut(usize, &mut dyn Form));
    /// Whether values are being read and the key was typed.
    fn has(&self, key: &str) -> bool;
    /// Whether every key is wanted, whatever the values are.
    fn describes(&self) -> bool {
        false
    }
    /// Whether values are being read of a table that the job cannot do without.
    fn is_needed(&self) -> bool;
    /// Notes a mistake at a key, or at the table as a whole.
    fn note(&mut self, key: &str, problem: &str);
    /// A mistake of the table as a whole; none is noted of one that was not typed.
    fn note_table(&mut self, problem: &str);
}

/// One of some names.
pub fn choose<T: Copy + PartialEq>(
    form: &mut dyn Form,
    value: &mut T,
    noun: &str,
    key: Key,
    names: &[(&'static str, T)],
) {
    let chosen = names.iter().position(|(_, of)| of == value).unwrap_or_default();
    let words: Vec<&'static str> = names.iter().map(|(name, _)| *name).collect();
    *value = names[form.choice(chosen, noun, &words, key).start].1;
}

/// One of some kinds with keys of their own, which `inside` visits.
pub fn variant<T: Clone>(
    form: &mut dyn Form,
    value: &mut T,
    noun: &str,
    key: Key,
    kinds: &[(&'static str, T)],
    mut inside: impl FnMut(&mut T, &mut dyn Form),
) {
    let is = |kind: &T, value: &T| std::mem::discriminant(kind) == std::mem::discriminant(value);
    let chosen = kinds.iter().position(|(_, kind)| is(kind, value)).unwrap_or_default();
    let (selector, words) = (key.name, kinds.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    for visited in form.choice(chosen, noun, &words, key) {
        let (choice, kind) = &kinds[visited];
        if !is(kind, value) {
            *value = kind.clone();
        }
        form.enter(Owner { selector, choice });
        inside(value, form);
        form.leave();
    }
}

/// A whole number that is kept as a size.
pub fn size(form: &mut dyn Form, value: &mut usize, key: Key) {
    let mut count = *value as u64;
    form.count(&mut count, key);
    *value = count as usize;
}
