//! States and frames to write.

use std::fs;
use std::path::{Path, PathBuf};

use scree_io::{Column, Drawn, Error, Frame, FrameFile, Meaning, State, Table, Values};

/// A state with every kind of column, an empty table, a table without columns, and long, odd and empty texts.
pub fn state() -> State {
    let grains = Table::new("grains", 3)
        .with_f64("position", 2, vec![0.1, -0.0, 1e-300, f64::MAX, 3.5, f64::MIN_POSITIVE])
        .with_u64("id", 1, vec![7, u64::MAX, 0])
        .with_i64("image", 2, vec![-1, 0, i64::MIN, i64::MAX, 2, 3])
        .with_u8("kind", 1, vec![0, 255, 3]);
    let contacts = Table::new("contacts", 0).with_f64("spring", 3, vec![]).with_u64("partner", 1, vec![]);
    let bare = Table::new("bare", 5);
    let long = Table::new("a table that would come first by name", 70_000).with_f64(
        "long",
        3,
        (0..210_000).map(|value| (f64::from(value) * 0.37).sqrt()).collect(),
    );
    let attributes = [
        ("state.time", "0.125".to_owned()),
        ("state.scenario", "name = \"värld\"\n".repeat(1500)),
        ("state.empty", String::new()),
        ("state.nul", "a\0b\0".to_owned()),
        ("state.sixty_five", "x".repeat(65)),
        ("program", "1.2.3".to_owned()),
    ];
    State {
        attributes: attributes.into_iter().map(|(key, text)| (key.to_owned(), text)).collect(),
        tables: vec![grains, contacts, bare, long],
    }
}

/// A state small enough to try every one of its bytes.
pub fn small_state() -> State {
    let grains = Table::new("grains", 4)
        .with_f64("position", 2, vec![0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5])
        .with_u64("id", 1, vec![1, 2, 3, 4]);
    let attributes = [("state.time", "0.125"), ("program", "1.2.3")];
    State {
        attributes: attributes.into_iter().map(|(key, text)| (key.to_owned(), text.to_owned())).collect(),
        tables: vec![grains, Table::new("contacts", 0).with_u8("closed", 1, vec![])],
    }
}

/// Two tables of that many rows.
pub fn many_rows(rows: usize) -> State {
    let number = |row: usize| row as f64 / 7.0;
    let grains = Table::new("grains", rows).with_u64("id", 1, (0..rows as u64).rev().collect()).with_f64(
        "position",
        2,
        (0..2 * rows).map(number).collect(),
    );
    let contacts = Table::new("contacts", rows).with_u8("closed", 1, (0..rows).map(|row| row as u8 % 2).collect());
    State { attributes: [("state.time".to_owned(), "1".to_owned())].into(), tables: vec![grains, contacts] }
}

/// The frame of that number; every one has another number of points, and one has none.
pub fn frame(number: usize) -> Frame {
    frame_of(Drawn::Points, number)
}

/// The same of points or lines.
pub fn frame_of(drawn: Drawn, number: usize) -> Frame {
    let rows = [100, 3, 0, 731, 250, 1][number % 6];
    let value = |row: usize| number as f64 + row as f64 / 1024.0;
    Frame {
        time: 0.25 * number as f64,
        drawn,
        positions: (0..rows * drawn.positions()).map(|at| [value(at), -value(at), 0.5 * value(at)]).collect(),
        fields: vec![
            field("velocity", 3, Values::F64((0..3 * rows).map(value).collect())),
            field("radius", 1, Values::F64((0..rows).map(value).collect())),
            field("stress", 9, Values::F64((0..9 * rows).map(value).collect())),
            field("id", 1, Values::I64((0..rows).map(|row| (1000 * number + row) as i64).collect())),
        ],
        whole: vec![
            field("edges", 9, Values::F64((0..9).map(value).collect())),
            field("depth", 1, Values::F64(vec![value(7)])),
        ],
    }
}

fn field(name: &str, width: usize, values: Values) -> Column {
    Column { name: name.to_owned(), width, values }
}

/// What is told of fields of [`frame`].
pub const MEANINGS: &[Meaning] = &[
    Meaning { field: "stress", unit: "Pa", what: "Cauchy stress" },
    Meaning { field: "edges", unit: "m", what: "edges of the cell" },
    Meaning { field: "Points", unit: "m", what: "place" },
];

/// A frame file in the making beside which a folder has what is in the making, made if it is not there.
pub fn create(path: &Path, first: &Frame) -> FrameFile {
    FrameFile::create(path, &scratch(path), first, 100, &[("run", "of a test")], MEANINGS).unwrap()
}

/// The same, gone on with.
pub fn open_and_cut(path: &Path, steps: usize) -> Result<FrameFile, Error> {
    FrameFile::open_and_cut(path, &scratch(path), steps, MEANINGS)
}

pub fn scratch(path: &Path) -> PathBuf {
    let scratch = path.with_file_name("scratch");
    fs::create_dir_all(&scratch).unwrap();
    scratch
}

/// How many files of frames there are in a folder.
pub fn frame_files(folder: &Path) -> usize {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    names.filter(|path| path.extension().is_some_and(|extension| extension == "vtkhdf")).count()
}

/// A folder for one test, removed when the guard goes.
pub fn folder() -> (tempfile::TempDir, PathBuf) {
    let guard = tempfile::tempdir().expect("a temporary folder");
    let path = guard.path().to_owned();
    (guard, path)
}
