//! Quantities as an operator writes them: a number and a unit, such as `"400 kPa"` or `"2530 kg/m3"`.
//!
//! Decimal prefixes are applied to the digits, not by multiplication, so `"6 cm"` and `0.06` are the same double.

/// Exponents of metre, kilogram, second and radian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    metre: i8,
    kilogram: i8,
    second: i8,
    radian: i8,
}

impl Dimension {
    /// A pure number.
    pub const RATIO: Self = Self::new(0, 0, 0, 0);
    /// rad.
    pub const ANGLE: Self = Self::new(0, 0, 0, 1);
    /// m.
    pub const LENGTH: Self = Self::new(1, 0, 0, 0);
    /// s.
    pub const TIME: Self = Self::new(0, 0, 1, 0);
    /// kg.
    pub const MASS: Self = Self::new(0, 1, 0, 0);
    /// m/s.
    pub const SPEED: Self = Self::new(1, 0, -1, 0);
    /// Pa.
    pub const STRESS: Self = Self::new(-1, 1, -2, 0);
    /// kg/m3.
    pub const DENSITY: Self = Self::new(-3, 1, 0, 0);
    /// N/m.
    pub const STIFFNESS: Self = Self::new(0, 1, -2, 0);
    /// N s/m.
    pub const DAMPING: Self = Self::new(0, 1, -1, 0);
    /// N.
    pub const FORCE: Self = Self::new(1, 1, -2, 0);
    /// m2.
    pub const AREA: Self = Self::new(2, 0, 0, 0);
    /// kg/m2.
    pub const MASS_PER_AREA: Self = Self::new(-2, 1, 0, 0);
    /// m/s2.
    pub const ACCELERATION: Self = Self::new(1, 0, -2, 0);
    /// 1/s.
    pub const RATE: Self = Self::new(0, 0, -1, 0);
    /// rad/s.
    pub const SPIN: Self = Self::new(0, 0, -1, 1);

    const fn new(metre: i8, kilogram: i8, second: i8, radian: i8) -> Self {
        Self { metre, kilogram, second, radian }
    }

    /// The product of `self` and `factor` to the power `exponent`.
    fn times(self, factor: Self, exponent: i8) -> Self {
        Self {
            metre: self.metre.saturating_add(factor.metre * exponent),
            kilogram: self.kilogram.saturating_add(factor.kilogram * exponent),
            second: self.second.saturating_add(factor.second * exponent),
            radian: self.radian.saturating_add(factor.radian * exponent),
        }
    }

    /// With its article, for a sentence: `a speed`.
    pub fn words(self) -> String {
        match NAMED.iter().find(|named| named.0 == self) {
            Some((_, words, _)) => (*words).to_string(),
            None => format!("a quantity in {}", self.base_units()),
        }
    }

    /// The SI unit a bare number is taken in; empty for a pure number.
    pub fn unit(self) -> String {
        match NAMED.iter().find(|named| named.0 == self) {
            Some((_, _, unit)) => (*unit).to_string(),
            None => self.base_units(),
        }
    }

    fn base_units(self) -> String {
        let powers = [("kg", self.kilogram), ("m", self.metre), ("s", self.second), ("rad", self.radian)];
        let present: Vec<String> = powers
            .iter()
            .filter(|(_, exponent)| *exponent != 0)
            .map(|(unit, exponent)| match exponent {
                1 => (*unit).to_string(),
                _ => format!("{unit}{exponent}"),
            })
            .collect();
        present.join(" ")
    }
}

/// What a dimension is called and the unit it is kept in.
const NAMED: [(Dimension, &str, &str); 17] = [
    (Dimension::RATIO, "a pure number", ""),
    (Dimension::ANGLE, "an angle", "rad"),
    (Dimension::LENGTH, "a length", "m"),
    (Dimension::TIME, "a time", "s"),
    (Dimension::MASS, "a mass", "kg"),
    (Dimension::SPEED, "a speed", "m/s"),
    (Dimension::STRESS, "a stress", "Pa"),
    (Dimension::DENSITY, "a density", "kg/m3"),
    (Dimension::STIFFNESS, "a stiffness", "N/m"),
    (Dimension::DAMPING, "a damping", "N s/m"),
    (Dimension::FORCE, "a force", "N"),
    (Dimension::new(2, 1, -2, 0), "an energy", "J"),
    (Dimension::AREA, "an area", "m2"),
    (Dimension::MASS_PER_AREA, "a mass per area", "kg/m2"),
    (Dimension::ACCELERATION, "an acceleration", "m/s2"),
    (Dimension::RATE, "a rate", "1/s"),
    (Dimension::SPIN, "a spin", "rad/s"),
];

/// Symbol, power of ten, factor that is no power of ten, dimension.
const UNITS: [(&str, i32, f64, Dimension); 13] = [
    ("m", 0, 1.0, Dimension::LENGTH),
    ("g", -3, 1.0, Dimension::MASS),
    ("t", 3, 1.0, Dimension::MASS),
    ("s", 0, 1.0, Dimension::TIME),
    ("min", 0, 60.0, Dimension::TIME),
    ("h", 0, 3600.0, Dimension::TIME),
    ("N", 0, 1.0, Dimension::FORCE),
    ("Pa", 0, 1.0, Dimension::STRESS),
    ("bar", 5, 1.0, Dimension::STRESS),
    ("J", 0, 1.0, Dimension::new(2, 1, -2, 0)),
    ("rad", 0, 1.0, Dimension::ANGLE),
    ("deg", 0, std::f64::consts::PI / 180.0, Dimension::ANGLE),
    ("%", -2, 1.0, Dimension::RATIO),
];

const PREFIXES: [(&str, i32); 9] =
    [("G", 9), ("M", 6), ("k", 3), ("c", -2), ("m", -3), ("u", -6), ("µ", -6), ("μ", -6), ("n", -9)];

/// Units that a misspelling is compared with.
const COMMON: [&str; 21] = [
    "m", "cm", "mm", "um", "s", "ms", "us", "min", "h", "kg", "g", "N", "kN", "Pa", "kPa", "MPa", "GPa", "rad", "deg",
    "%", "J",
];

/// Why a text is no quantity of the wanted dimension.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// No number at the start.
    NoNumber,
    /// A bare number in quotes where a unit is wanted.
    NoUnit,
    /// A symbol that no unit has, and the nearest one that exists.
    UnknownUnit(String, Option<&'static str>),
    /// A product behind a division, which readers take in two ways.
    Ambiguous,
    /// A quantity, but of this other dimension.
    Other(Dimension),
}

/// The value of `text` in SI units.
pub fn quantity(text: &str, wanted: Dimension) -> Result<f64, Refusal> {
    let text = text.trim();
    let (digits, exponent, rest) = split_number(text).ok_or(Refusal::NoNumber)?;
    let rest = rest.trim();
    if rest.is_empty() && wanted != Dimension::RATIO {
        return Err(Refusal::NoUnit);
    }
    let unit = parse_unit(rest)?;
    if unit.dimension != wanted {
        return Err(Refusal::Other(unit.dimension));
    }
    let decimal: f64 =
        format!("{digits}e{}", exponent.saturating_add(unit.power_of_ten)).parse().map_err(|_| Refusal::NoNumber)?;
    Ok(decimal * unit.factor)
}

struct Unit {
    power_of_ten: i32,
    factor: f64,
    dimension: Dimension,
}

/// Mantissa, decimal exponent, and what follows them.
fn split_number(text: &str) -> Option<(String, i32, &str)> {
    let bytes = text.as_bytes();
    let mut at = usize::from(bytes.first().is_some_and(|b| matches!(b, b'+' | b'-')));
    let mantissa_start = at;
    while at < bytes.len() && (bytes[at].is_ascii_digit() || matches!(bytes[at], b'.' | b'_')) {
        at += 1;
    }
    let mantissa = text[..at].replace('_', "");
    mantissa.parse::<f64>().ok()?;
    if at == mantissa_start {
        return None;
    }
    let mut exponent = 0;
    if at < bytes.len() && matches!(bytes[at], b'e' | b'E') {
        let mut end = at + 1;
        if end < bytes.len() && matches!(bytes[end], b'+' | b'-') {
            end += 1;
        }
        while end < bytes.len() && bytes[end].is_ascii_digit() {
            end += 1;
        }
        exponent = text[at + 1..end].parse().ok()?;
        at = end;
    }
    Some((mantissa, exponent, &text[at..]))
}

/// `N s/m`, `kg/m3`, `m^2`, `1/s`: factors parted by spaces, `*`, `·` or `/`; a slash divides by the next factor alone.
fn parse_unit(text: &str) -> Result<Unit, Refusal> {
    let mut unit = Unit { power_of_ten: 0, factor: 1.0, dimension: Dimension::RATIO };
    let mut divided = false;
    for (index, quotient) in text.split('/').enumerate() {
        let separators = |c: char| c.is_whitespace() || c == '*' || c == '·';
        let factors: Vec<&str> = quotient.split(separators).filter(|part| !part.is_empty()).collect();
        divided |= index > 0;
        if divided && factors.len() > 1 {
            return Err(Refusal::Ambiguous);
        }
        if factors.is_empty() && !text.is_empty() && (divided || index > 0) {
            return Err(Refusal::UnknownUnit(text.to_string(), None));
        }
        for factor in factors {
            if factor == "1" && index == 0 {
                continue;
            }
            let (power_of_ten, scale, dimension, exponent) = parse_factor(factor)?;
            let signed = if index > 0 { -exponent } else { exponent };
            unit.power_of_ten += power_of_ten * i32::from(signed);
            for _ in 0..exponent.unsigned_abs() {
                if signed < 0 {
                    unit.factor /= scale;
                } else {
                    unit.factor *= scale;
                }
            }
            unit.dimension = unit.dimension.times(dimension, signed);
        }
    }
    Ok(unit)
}

/// One symbol with its prefix and exponent.
fn parse_factor(text: &str) -> Result<(i32, f64, Dimension, i8), Refusal> {
    let symbol = text.trim_end_matches(|c: char| c.is_ascii_digit() || c == '^' || c == '-');
    let exponent = match text[symbol.len()..].trim_start_matches('^') {
        "" => 1,
        digits => match digits.parse::<i8>() {
            Ok(exponent) if (-4..=4).contains(&exponent) && exponent != 0 => exponent,
            _ => return Err(Refusal::UnknownUnit(text.to_string(), None)),
        },
    };
    if let Some((_, power, scale, dimension)) = UNITS.iter().find(|unit| unit.0 == symbol) {
        return Ok((*power, *scale, *dimension, exponent));
    }
    for (prefix, prefix_power) in PREFIXES {
        let Some(bare) = symbol.strip_prefix(prefix) else {
            continue;
        };
        let prefixable = UNITS.iter().find(|unit| unit.0 == bare && !matches!(bare, "min" | "h" | "t" | "deg" | "%"));
        if let Some((_, power, scale, dimension)) = prefixable {
            return Ok((power + prefix_power, *scale, *dimension, exponent));
        }
    }
    let nearest = nearest(symbol, COMMON.iter().copied());
    Err(Refusal::UnknownUnit(symbol.to_string(), nearest))
}

/// The candidate that `word` was probably meant to be.
pub fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // No key or unit is nearly as long, and the time to compare grows with the length.
    if word.len() > 100 {
        return None;
    }
    let lower = word.to_lowercase();
    candidates
        .map(|candidate| {
            let distance = strsim::damerau_levenshtein(&lower, &candidate.to_lowercase());
            (distance, candidate)
        })
        .filter(|(distance, candidate)| *distance <= 1 + candidate.chars().count() / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// The number with ten digits, which is enough for a sentence and spares it the noise of binary fractions.
pub fn in_short(value: f64) -> f64 {
    format!("{value:.9e}").parse().expect("a formatted number parses")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prefix moves the decimal point and rounds once, so a unit never costs a bit.
    #[test]
    fn units_are_the_si_number_to_the_bit() {
        let cases = [
            ("6 cm", Dimension::LENGTH, 0.06),
            ("7.5 mm", Dimension::LENGTH, 0.0075),
            ("400 kPa", Dimension::STRESS, 400e3),
            ("630MPa", Dimension::STRESS, 630e6),
            ("2 cm/s", Dimension::SPEED, 0.02),
            ("3.5 N s/m", Dimension::DAMPING, 3.5),
            ("3.5 N*s/m", Dimension::DAMPING, 3.5),
            ("3.5 N·s/m", Dimension::DAMPING, 3.5),
            ("2530 kg/m3", Dimension::DENSITY, 2530.0),
            ("2.53 g/cm^3", Dimension::DENSITY, 2530.0),
            ("1772 kN/m", Dimension::STIFFNESS, 1772e3),
            ("4e-7 s", Dimension::TIME, 4e-7),
            ("0.4 us", Dimension::TIME, 4e-7),
            ("0.4 µs", Dimension::TIME, 4e-7),
            ("2 min", Dimension::TIME, 120.0),
            ("81.5 %", Dimension::RATIO, 0.815),
            ("0.5", Dimension::RATIO, 0.5),
            ("-1_000 m", Dimension::LENGTH, -1000.0),
            ("20 g", Dimension::MASS, 0.02),
            ("9.81 m/s2", Dimension::ACCELERATION, 9.81),
            ("0.02 1/s", Dimension::RATE, 0.02),
            ("4 cm2", Dimension::AREA, 4e-4),
            ("3 rad/s", Dimension::SPIN, 3.0),
        ];
        for (text, dimension, value) in cases {
            assert_eq!(quantity(text, dimension), Ok(value), "{text}");
        }
        let right_angle = quantity("90 deg", Dimension::ANGLE).unwrap();
        assert!((right_angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_quantity_is_refused_with_its_reason() {
        let length = |text| quantity(text, Dimension::LENGTH);
        assert_eq!(length("2 cm/s"), Err(Refusal::Other(Dimension::SPEED)));
        assert_eq!(length("6"), Err(Refusal::NoUnit));
        assert_eq!(length("six cm"), Err(Refusal::NoNumber));
        assert_eq!(length(""), Err(Refusal::NoNumber));
        assert_eq!(length("1.2.3 m"), Err(Refusal::NoNumber));
        assert_eq!(length("1e m"), Err(Refusal::NoNumber));
        assert_eq!(length("6 cmm"), Err(Refusal::UnknownUnit("cmm".into(), Some("cm"))));
        assert_eq!(length("6 parsec"), Err(Refusal::UnknownUnit("parsec".into(), None)));
        assert_eq!(length("6 m/"), Err(Refusal::UnknownUnit("m/".into(), None)));
        assert_eq!(quantity("3 N/m s", Dimension::DAMPING), Err(Refusal::Ambiguous));
        assert_eq!(Dimension::new(2, 0, -1, 0).words(), "a quantity in m2 s-1");
    }
}
