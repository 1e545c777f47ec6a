//! What a run left behind, read and checked: a report trusts nothing that it did not look at.

use std::path::{Path, PathBuf};

use scree_io::column::{Column, Values};
use scree_io::{frames, series};

use super::span::Span;
use super::told;
use crate::base::error::Error;
use crate::base::math;

/// A run, whether it has ended or not.
#[derive(Clone, Debug)]
pub struct Run {
    pub directory: PathBuf,
    pub name: String,
    pub method: String,
    /// Period in x, m.
    pub width: f64,
    /// Mean grain diameter D50, m.
    pub diameter: f64,
    /// The stress that the upper plate is held at, Pa.
    pub stress_normal: Option<f64>,
    pub scenario: toml::Table,
    /// `scenario.toml` as it stands.
    pub scenario_text: String,
    pub summary: serde_json::Map<String, serde_json::Value>,
    pub series: Series,
    /// Times of the frames, s.
    pub frame_times: Vec<f64>,
}

/// The columns of `series.csv`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Of the last row.
    pub step: f64,
    /// s.
    pub time: Vec<f64>,
    /// Displacement of the upper plate over the specimen's width.
    pub strain: Vec<f64>,
    /// Pa; mean over the interval since the last row, as are the other stresses.
    pub shear_stress: Vec<f64>,
    /// Pa, compression positive.
    pub normal_stress: Vec<f64>,
    pub volume_strain: Vec<f64>,
    pub grains: Vec<f64>,
    /// J.
    pub kinetic_grains: Vec<f64>,
    pub elastic_grains: Vec<f64>,
    pub kinetic_points: Vec<f64>,
    pub elastic_points: Vec<f64>,
}

impl Series {
    pub fn rows(&self) -> usize {
        self.time.len()
    }

    /// Horizontal strain at a time, s: linear between rows, held beyond them.
    pub fn strain_at(&self, time: f64) -> f64 {
        from_zero(&self.time, &self.strain, time)
    }
}

/// Values of rows at a time, s: linear between them, held beyond them; before the first they rise from zero at the start.
pub fn from_zero(times: &[f64], values: &[f64], time: f64) -> f64 {
    let first = times[0];
    linear(times, values, time).unwrap_or_else(|| match time < first {
        // Rows begin one interval after the start.
        true if first > 0.0 => values[0] * (time / first).max(0.0),
        true => values[0],
        false => values[values.len() - 1],
    })
}

/// Where a value lies among rising ones: the first row that is not below it, and its share of the way there from the row
/// before; none beyond the ends.
pub fn between(rising: &[f64], at: f64) -> Option<(usize, f64)> {
    let after = rising.partition_point(|&row| row < at);
    let to = *rising.get(after)?;
    if to == at {
        return Some((after, 1.0));
    }
    let from = rising[after.checked_sub(1)?];
    Some((after, (at - from) / (to - from)))
}

/// Values at rising places, linear between them; none beyond them.
pub fn linear(places: &[f64], values: &[f64], at: f64) -> Option<f64> {
    let (after, share) = between(places, at)?;
    match after.checked_sub(1).filter(|_| share < 1.0) {
        Some(before) => Some(values[before] + share * (values[after] - values[before])),
        None => Some(values[after]),
    }
}

/// What a row of a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Point,
    Grain,
    /// A grain glued to a plate.
    Glued,
}

impl Kind {
    /// Grains share their ids, glued or not.
    pub fn is_grain(self) -> bool {
        self != Self::Point
    }
}

/// A point or a grain at the time of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    pub kind: Kind,
    pub id: i64,
    /// m; x in [0, width).
    pub position: [f64; 2],
    /// m, not wrapped, since the body's origin.
    pub displacement: [f64; 2],
    /// m; of a point: of the disc of equal area.
    pub radius: f64,
    /// Below one in the rim.
    pub weight: f64,
    /// Cauchy stress xy, of a grain the mean of its contacts over its share of space, Pa.
    pub shear_stress: f64,
}

impl Body {
    /// Where it began, m; x in no particular period.
    pub fn origin(&self) -> [f64; 2] {
        [self.position[0] - self.displacement[0], self.position[1] - self.displacement[1]]
    }

    /// Area that it stands for, m2.
    pub fn area(&self) -> f64 {
        self.weight * math::PI * self.radius * self.radius
    }
}

/// A frame, its bodies in ascending order of (point or grain, id).
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// s.
    pub time: f64,
    pub bodies: Vec<Body>,
}

impl Run {
    /// Reads all but the frames of a run directory.
    pub fn read(directory: &Path) -> Result<Self, Error> {
        if !directory.is_dir() {
            return Err(Error::User(format!(
                "{} is not a directory; give the directory of a run, such as runs/NAME",
                directory.display()
            )));
        }
        let scenario_path = directory.join("scenario.toml");
        let scenario_text = text(&scenario_path)?;
        let scenario: toml::Table = toml::from_str(&scenario_text).map_err(|error| {
            broken(&scenario_path, &format!("is not TOML: {}", error.message()), "Copy it back from the run's job")
        })?;
        let frames_path = directory.join("frames.vtkhdf");
        present(&frames_path)?;
        let frame_times = frames::times(&frames_path).map_err(unreadable)?;
        if frame_times.is_empty() {
            return Err(torn_frames(&frames_path, "it holds no frame"));
        }

        let words = |path: &str| lookup(&scenario, path).and_then(toml::Value::as_str).map(str::to_owned);
        let figure = |path: &str| figure(&scenario, path);
        let needed = |path: &str| {
            figure(path).filter(|value| *value > 0.0).ok_or_else(|| {
                broken(&scenario_path, &format!("has no positive number `{path}`"), "Copy it back from the run's job")
            })
        };
        let fallback =
            directory.file_name().map_or_else(|| "run".to_owned(), |name| name.to_string_lossy().into_owned());
        let series = read_series(&directory.join("series.csv"))?;
        let summary = told::figures(directory, series.step)?;
        Ok(Self {
            directory: directory.to_owned(),
            name: words("name").unwrap_or(fallback),
            method: words("method").unwrap_or_default(),
            width: needed("specimen.width")?,
            diameter: needed("grains.diameter_mean")?,
            stress_normal: figure("loading.stress_normal").or_else(|| figure("loading.normal_stress")),
            series,
            scenario,
            scenario_text,
            summary,
            frame_times,
        })
    }

    /// A number of the summary.
    pub fn summary_figure(&self, key: &str) -> Option<f64> {
        self.summary.get(key).and_then(serde_json::Value::as_f64)
    }

    /// Horizontal strain of a frame.
    pub fn strain_of(&self, frame: usize) -> f64 {
        self.series.strain_at(self.frame_times[frame])
    }

    /// The frame nearest to a strain; of several at that strain the last.
    pub fn frame_at(&self, strain: f64) -> usize {
        let away = |frame: usize| (self.strain_of(frame) - strain).abs();
        let frames = 0..self.frame_times.len();
        frames.reduce(|best, frame| if away(frame) <= away(best) { frame } else { best }).unwrap_or(0)
    }

    /// Across what it is drawn and measured.
    pub fn span(&self) -> Span {
        Span { left: 0.0, width: self.width, is_periodic: true, diameter: self.diameter }
    }

    /// Reads one frame.
    pub fn snapshot(&self, index: usize) -> Result<Snapshot, Error> {
        Snapshot::read(&self.directory, index, self.width)
    }
}

impl Snapshot {
    /// Reads one frame of a run; where the `period` (m) is positive, x is brought into it. Vertices of membranes are no bodies.
    pub fn read(directory: &Path, index: usize, period: f64) -> Result<Self, Error> {
        let path = directory.join("frames.vtkhdf");
        let torn = |what: &str| torn_frames(&path, &format!("frame {index}: {what}"));
        let frame = frames::read_frame(&path, index).map_err(unreadable)?;
        let rows = frame.positions.len();
        let find = |name: &str, width: usize| -> Result<&Column, Error> {
            let column = frame.fields.iter().find(|column| column.name == name);
            let column = column.ok_or_else(|| torn(&format!("there is no field `{name}`")))?;
            if column.width != width || column.values.len() != rows * width {
                return Err(torn(&format!("field `{name}` does not hold {width} numbers a row")));
            }
            Ok(column)
        };
        let integers = |name: &str| match &find(name, 1)?.values {
            Values::I64(values) => Ok(values),
            _ => Err(torn(&format!("field `{name}` does not hold integers"))),
        };
        let reals = |name: &str, width: usize| match &find(name, width)?.values {
            Values::F64(values) if values.iter().all(|value| value.is_finite()) => Ok(values),
            Values::F64(_) => Err(torn(&format!("field `{name}` holds what is not a number"))),
            _ => Err(torn(&format!("field `{name}` does not hold reals"))),
        };
        let (kinds, ids) = (integers("kind")?, integers("id")?);
        let (radii, weights, displacements) = (reals("radius", 1)?, reals("weight", 1)?, reals("displacement", 3)?);
        let stresses = reals("stress", 3)?;
        let mut bodies = Vec::with_capacity(rows);
        for (row, place) in frame.positions.iter().enumerate() {
            let kind = match kinds[row] {
                0 => Kind::Point,
                1 => Kind::Grain,
                2 => Kind::Glued,
                3 => continue,
                other => return Err(torn(&format!("row {row} is of kind {other}; known are 0 to 3"))),
            };
            if !(place[0].is_finite() && place[1].is_finite()) {
                return Err(torn(&format!("row {row} has no place")));
            }
            bodies.push(Body {
                kind,
                id: ids[row],
                position: [if period > 0.0 { place[0].rem_euclid(period) } else { place[0] }, place[1]],
                displacement: [displacements[3 * row], displacements[3 * row + 1]],
                radius: radii[row],
                weight: weights[row],
                shear_stress: stresses[3 * row + 2],
            });
        }
        bodies.sort_by_key(|body| (body.kind.is_grain(), body.id));
        if let Some(twins) = bodies
            .windows(2)
            .find(|pair| (pair[0].kind.is_grain(), pair[0].id) == (pair[1].kind.is_grain(), pair[1].id))
        {
            let noun = if twins[0].kind.is_grain() { "grain" } else { "point" };
            return Err(torn(&format!("{noun} {} is there twice", twins[0].id)));
        }
        Ok(Self { time: frame.time, bodies })
    }
}

/// A value of the scenario by its dotted path.
pub fn lookup<'a>(table: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    let (head, rest) = path.split_once('.').map_or((path, None), |(head, rest)| (head, Some(rest)));
    let value = table.get(head)?;
    match rest {
        None => Some(value),
        Some(rest) => lookup(value.as_table()?, rest),
    }
}

/// A number of the scenario by its dotted path.
pub fn figure(table: &toml::Table, path: &str) -> Option<f64> {
    let value = lookup(table, path)?;
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

fn read_series(path: &Path) -> Result<Series, Error> {
    const REMEDY: &str = "Resume the run; it takes the file up where the checkpoint left it";
    present(path)?;
    let (header, rows) = series::read(path).map_err(unreadable)?;
    if rows.is_empty() {
        return Err(broken(path, "has no rows yet", "Let the run go on until it has written some: `scree resume`"));
    }
    let column = |name: &str| -> Result<Vec<f64>, Error> {
        let index = header.iter().position(|found| found == name);
        let index = index.ok_or_else(|| broken(path, &format!("has no column `{name}`"), REMEDY))?;
        rows.iter()
            .enumerate()
            .map(|(row, values)| {
                let value = values.get(index).copied().filter(|value| value.is_finite());
                value.ok_or_else(|| broken(path, &format!("has no number in line {}, `{name}`", row + 2), REMEDY))
            })
            .collect()
    };
    Ok(Series {
        step: column("step")?.last().copied().unwrap_or(0.0),
        time: column("time")?,
        strain: column("strain")?,
        shear_stress: column("shear_stress")?,
        normal_stress: column("normal_stress")?,
        volume_strain: column("volume_strain")?,
        grains: column("grains")?,
        kinetic_grains: column("kinetic_grains")?,
        elastic_grains: column("elastic_grains")?,
        kinetic_points: column("kinetic_points")?,
        elastic_points: column("elastic_points")?,
    })
}

pub fn text(path: &Path) -> Result<String, Error> {
    present(path)?;
    std::fs::read_to_string(path).map_err(|error| broken(path, &format!("cannot be read: {error}"), "Check the file"))
}

pub fn present(path: &Path) -> Result<(), Error> {
    if path.is_file() {
        return Ok(());
    }
    let directory = path.parent().unwrap_or(path).display();
    Err(broken(
        path,
        "is missing",
        &format!("A run writes it by its end: `scree resume {directory}` goes on with one that stopped early"),
    ))
}

/// The library of files names the file and says what to do by itself.
pub fn unreadable(error: scree_io::Error) -> Error {
    Error::User(error.to_string())
}

pub fn torn_frames(path: &Path, what: &str) -> Error {
    broken(
        path,
        &format!("cannot be drawn: {what}"),
        "Resume the run from its last checkpoint to write the frames anew",
    )
}

pub fn broken(path: &Path, what: &str, remedy: &str) -> Error {
    Error::User(format!("{} {what}. {remedy}.", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strain_runs_from_zero_between_rows_and_stays_at_the_end() {
        let series = Series { time: vec![0.1, 0.2, 0.4], strain: vec![0.01, 0.02, 0.06], ..Series::default() };
        let at = |time: f64| (series.strain_at(time) * 1e6).round() / 1e6;
        assert_eq!([at(0.0), at(0.05), at(0.1), at(0.3), at(0.4), at(9.0)], [0.0, 0.005, 0.01, 0.04, 0.06, 0.06]);
    }

    #[test]
    fn figures_are_found_by_their_path() {
        let table = toml::from_str("a = 2\n[b]\nc = 0.5\nd = \"x\"").unwrap();
        assert_eq!(figure(&table, "a"), Some(2.0));
        assert_eq!(figure(&table, "b.c"), Some(0.5));
        assert_eq!(figure(&table, "b.d"), None);
        assert_eq!(figure(&table, "b.c.e"), None);
    }

    #[test]
    fn a_missing_file_is_named_with_what_to_do() {
        let missing = Run::read(Path::new("/nowhere/at/all")).unwrap_err();
        assert!(missing.to_string().contains("/nowhere/at/all is not a directory"));
        let directory = std::env::temp_dir().join(format!("scree-report-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        let error = Run::read(&directory).unwrap_err();
        std::fs::remove_dir_all(&directory).unwrap();
        assert!(matches!(error, Error::User(_)));
        let message = error.to_string();
        assert!(message.contains("scenario.toml is missing") && message.contains("scree resume"), "{message}");
    }
}
