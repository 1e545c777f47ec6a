//! A time series as CSV: one header line, then one row of numbers per push.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::error::Error;
use crate::system::{folder, refused, sync};

/// A CSV file that grows by rows of `f64`, each written in the fewest digits that give back the same number.
#[derive(Debug)]
pub struct Series {
    path: PathBuf,
    file: File,
    width: usize,
    rows: usize,
    /// Length of the file up to the end of the last whole row, and a hash of what stands there.
    bytes: u64,
    hash: Sha256,
}

impl Series {
    /// Creates the file with its header line. A file already there is refused: it may be a run's only record.
    /// Panics on a column name that CSV would have to quote.
    pub fn create(path: &Path, header: &[&str]) -> Result<Series, Error> {
        let line = header_line(header) + "\n";
        let mut file = OpenOptions::new().append(true).create_new(true).open(path).map_err(refused("create", path))?;
        file.write_all(line.as_bytes()).map_err(refused("write", path))?;
        sync(folder(path))?;
        let hash = Sha256::new_with_prefix(&line);
        Ok(Series { path: path.to_owned(), file, width: header.len(), rows: 0, bytes: line.len() as u64, hash })
    }

    /// Opens the file again and cuts it back to its first `rows` rows; what follows, torn or whole, is dropped.
    ///
    /// [`Error::SeriesHeader`] if it has other columns, [`Error::TooFewRows`] if it ends earlier, [`Error::SeriesRow`]
    /// if one of the rows kept is not `header.len()` numbers, [`Error::SeriesChanged`] if they are not those that
    /// [`digest`](Self::digest) stood for. The file is as it was then.
    pub fn resume(path: &Path, header: &[&str], rows: usize, digest: u64) -> Result<Series, Error> {
        let lines = Self::first(path, header, rows, digest)?;
        let file = OpenOptions::new().append(true).open(path).map_err(refused("open", path))?;
        file.set_len(lines.bytes).map_err(refused("cut", path))?;
        Ok(Series { path: path.to_owned(), file, width: header.len(), rows, bytes: lines.bytes, hash: lines.hash })
    }

    /// Reads the first `rows` rows; errors are those of [`resume`](Self::resume).
    pub fn check(path: &Path, header: &[&str], rows: usize, digest: u64) -> Result<(), Error> {
        Self::first(path, header, rows, digest).map(|_| ())
    }

    fn first<'a>(path: &'a Path, header: &[&str], rows: usize, digest: u64) -> Result<Lines<'a>, Error> {
        let mut lines = Lines::open(path)?;
        let expected = header_line(header);
        match lines.next()? {
            Some(found) if found == expected => {}
            found => {
                let found = found.unwrap_or_default();
                return Err(Error::SeriesHeader { path: path.to_owned(), found, expected });
            }
        }
        for found in 0..rows {
            let Some(line) = lines.next()? else {
                return Err(Error::TooFewRows { path: path.to_owned(), found, expected: rows });
            };
            parse_row(&line, header.len(), path, lines.count)?;
        }
        if short(&lines.hash) != digest {
            return Err(Error::SeriesChanged { path: path.to_owned(), rows });
        }
        Ok(lines)
    }

    /// Writes one row and hands it to the system, so that it outlasts this process. Panics unless there is a value per
    /// column. On an error the file is cut back to its whole rows, and the push may be tried again.
    pub fn push(&mut self, values: &[f64]) -> Result<(), Error> {
        assert_eq!(values.len(), self.width, "{}: one value per column", self.path.display());
        let line = row_line(values);
        if let Err(source) = self.file.write_all(line.as_bytes()) {
            // Should this fail too, the torn row is still cut at the next resume.
            let _ = self.file.set_len(self.bytes);
            return Err(refused("write", &self.path)(source));
        }
        self.rows += 1;
        self.bytes += line.len() as u64;
        self.hash.update(&line);
        Ok(())
    }

    /// Stands for the header and all rows: what is there when the series is taken up again must have the same.
    pub fn digest(&self) -> u64 {
        short(&self.hash)
    }

    /// Makes all rows outlast a power cut. To be called before a checkpoint that counts them is written.
    pub fn sync(&self) -> Result<(), Error> {
        self.file.sync_data().map_err(refused("write to disk", &self.path))
    }

    /// Rows in the file.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The names of the columns.
pub fn header(path: &Path) -> Result<Vec<String>, Error> {
    let line = Lines::open(path)?.next()?.unwrap_or_default();
    Ok(line.split(',').map(str::to_owned).collect())
}

/// The header and all whole rows. A last line without its end is passed over: a run may be writing it.
pub fn read(path: &Path) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let mut lines = Lines::open(path)?;
    let header = lines.next()?.ok_or_else(|| Error::Truncated {
        path: path.to_owned(),
        bytes: fs::metadata(path).map_or(0, |metadata| metadata.len()),
        reason: "it has no header line".to_owned(),
    })?;
    let header: Vec<String> = header.split(',').map(str::to_owned).collect();
    let mut rows = Vec::new();
    while let Some(line) = lines.next()? {
        rows.push(parse_row(&line, header.len(), path, lines.count)?);
    }
    Ok((header, rows))
}

/// The whole lines of a file, one at a time: a series may be long.
struct Lines<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    /// Lines and bytes read so far, line ends included.
    count: usize,
    bytes: u64,
    hash: Sha256,
}

/// The first eight bytes of what a hash has come to.
fn short(hash: &Sha256) -> u64 {
    let bytes = hash.clone().finalize();
    u64::from_le_bytes(std::array::from_fn(|at| bytes[at]))
}

impl<'a> Lines<'a> {
    fn open(path: &'a Path) -> Result<Lines<'a>, Error> {
        let file = File::open(path).map_err(refused("open", path))?;
        Ok(Lines { path, reader: BufReader::new(file), count: 0, bytes: 0, hash: Sha256::new() })
    }

    fn next(&mut self) -> Result<Option<String>, Error> {
        let mut line = Vec::new();
        self.reader.read_until(b'\n', &mut line).map_err(refused("read", self.path))?;
        if line.last() != Some(&b'\n') {
            return Ok(None);
        }
        self.hash.update(&line);
        line.pop();
        self.count += 1;
        self.bytes += line.len() as u64 + 1;
        Ok(Some(String::from_utf8_lossy(&line).into_owned()))
    }
}

fn header_line(header: &[&str]) -> String {
    assert!(!header.is_empty(), "a series needs a column");
    for name in header {
        assert!(!name.is_empty() && !name.contains([',', '"', '\n', '\r']), "{name:?} cannot name a CSV column");
    }
    header.join(",")
}

fn row_line(values: &[f64]) -> String {
    let mut line = String::new();
    for value in values {
        // Both forms give the same number back; far from 1 the plain one is hundreds of digits long.
        let plain = *value == 0.0 || (1e-5..1e16).contains(&value.abs()) || !value.is_finite();
        let comma = if line.is_empty() { "" } else { "," };
        let written = if plain { write!(line, "{comma}{value}") } else { write!(line, "{comma}{value:e}") };
        written.expect("writing to a string cannot fail");
    }
    line + "\n"
}

fn parse_row(line: &str, width: usize, path: &Path, number: usize) -> Result<Vec<f64>, Error> {
    let values: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
    values.ok().filter(|values| values.len() == width).ok_or_else(|| Error::SeriesRow {
        path: path.to_owned(),
        line: number,
        found: line.chars().take(200).collect(),
        expected: format!("a row of {width} numbers"),
    })
}
