//! A frame costs what it costs, whatever came before it, and neither readers nor what happens to the second file spoil it.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use hdf5::types::FixedUnicode;
use ndarray::IxDyn;
use scree_io::{Column, Drawn, Frame, FrameFile, Values, frames};

use crate::sample::{self, frame};

const HELD: &str = "SCREE_IO_HELD";

fn expected(numbers: std::ops::Range<usize>) -> Vec<Frame> {
    numbers.map(frame).collect()
}

/// A frame of 25 fields of a number each.
fn wide(number: usize, rows: usize) -> Frame {
    let value = |at: usize| ((number * 7919 + at * 104_729) as f64).sqrt();
    let column = |field: usize| Column {
        name: format!("field_{field}"),
        width: 1,
        values: Values::F64((0..rows).map(|row| value(25 * row + field)).collect()),
    };
    Frame {
        time: number as f64,
        drawn: Drawn::Points,
        positions: (0..rows).map(|row| [value(row), 0.0, 1.0]).collect(),
        fields: (0..25).map(column).collect(),
        whole: Vec::new(),
    }
}

/// Bytes that this thread has handed to the system for writing.
fn written() -> Option<u64> {
    let text = fs::read_to_string("/proc/thread-self/io").ok()?;
    text.lines().find_map(|line| line.strip_prefix("wchar: "))?.parse().ok()
}

/// Files used to be copied for every frame: 400 frames of 300 grains wrote 206 times what they left.
#[test]
fn the_thousandth_frame_costs_what_the_first_does() {
    if written().is_none() {
        println!("skipped: the system does not tell what a thread writes");
        return;
    }
    for rows in [30, 300] {
        let (_guard, folder) = sample::folder();
        let path = folder.join("frames.vtkhdf");
        let mut file = FrameFile::create(&path, &sample::scratch(&path), &wide(0, rows), rows, &[], &[]).unwrap();
        let mut costs = Vec::new();
        for number in 1..=1000 {
            let frame = wide(number, rows);
            let before = written().unwrap();
            file.append(&frame).unwrap();
            costs.push((written().unwrap() - before) as f64);
        }
        let mean = |costs: &[f64]| costs.iter().sum::<f64>() / costs.len() as f64;
        let (first, last) = (mean(&costs[1..51]), mean(&costs[950..]));
        let length = fs::metadata(&path).unwrap().len() as f64;
        println!("{rows} rows: {first:.0} bytes each of the first frames, {last:.0} of the last, {length:.0} in all");
        // What grows is a block in which a dataset keeps where its chunks are: of 16 places at first and of 128 by then.
        let blocks = 2.0 * 28.0 * 15.0 * (128.0 - 16.0);
        assert!(last < first + 1.1 * blocks, "{rows} rows: {first} then {last}");
        // Both files, and of each dataset what tells where its chunks are and how long it is.
        assert!(last < 2.2 * length / 1000.0 + 2.0 * 45.0 * 2500.0, "{rows} rows: {last} of {length}");
    }
}

/// Were it lost, the next frame would go into a copy, and cost what all frames do that were before it.
#[test]
fn the_second_file_is_kept_and_one_frame_behind() {
    for drawn in [Drawn::Points, Drawn::Lines, Drawn::Quadrilaterals] {
        let (_guard, folder) = sample::folder();
        let path = folder.join("frames.vtkhdf");
        let scratch = sample::scratch(&path);
        let of = |number| sample::frame_of(drawn, number);
        let mut file = FrameFile::create(&path, &scratch, &of(0), 50, &[], &[]).unwrap();
        let mut waits: Option<fs::File> = None;
        let mut copies = 0;
        for number in 1..40 {
            file.append(&of(number)).unwrap();
            let wanted: Vec<Frame> = (0..=number).map(of).collect();
            assert!(frames::read(&path).unwrap() == wanted, "{drawn:?} {number}");
            let twin = only_file_in(&scratch);
            assert!(frames::read_part(&twin).unwrap() == wanted[..number], "{drawn:?} {number}");
            // The one that has the name now is the one that waited, not a copy.
            let inode = |metadata: fs::Metadata| metadata.ino();
            let waited = waits.replace(fs::File::open(&twin).unwrap()).map(|file| inode(file.metadata().unwrap()));
            copies += u32::from(waited.is_some_and(|waited| waited != inode(fs::metadata(&path).unwrap())));
        }
        // A process that another test starts holds for a moment whatever this one has open and locked.
        assert!(copies <= 3, "{drawn:?}: {copies} copies of 38");
    }
}

/// A chunk holds what a frame has: neither is it rewritten for the next one, nor are there more than are needed.
#[test]
fn chunks_are_sized_for_the_rows_they_hold() {
    let (_guard, folder) = sample::folder();
    let chunk = |hint: usize, rows: usize| {
        let path = folder.join(format!("{hint}-{rows}.vtkhdf"));
        FrameFile::create(&path, &sample::scratch(&path), &wide(0, rows), hint, &[], &[]).unwrap();
        let file = hdf5::File::open(&path).unwrap();
        file.dataset("VTKHDF/Points").unwrap().chunk().unwrap()[0]
    };
    assert_eq!(chunk(0, 0), 64);
    assert_eq!(chunk(300, 300), 300);
    // Whoever knew of less than there is.
    assert_eq!(chunk(0, 300), 300);
    // At first there may be none.
    assert_eq!(chunk(2000, 0), 2000);
    // In the fewest chunks of one size.
    assert_eq!(chunk(30_000, 0), 10_000);
}

#[test]
fn frames_larger_than_was_said_come_back() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let sizes = [0, 1, 63, 64, 65, 128, 0, 0, 129, 5000, 3];
    let mut file = FrameFile::create(&path, &sample::scratch(&path), &wide(0, 0), 0, &[], &[]).unwrap();
    (1..sizes.len()).for_each(|number| file.append(&wide(number, sizes[number])).unwrap());
    let all: Vec<Frame> = sizes.iter().enumerate().map(|(number, rows)| wide(number, *rows)).collect();
    assert_eq!(frames::read(&path).unwrap(), all);
}

/// And not what happened to be in memory.
#[test]
fn what_lies_between_frames_is_zero() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let mut file = sample::create(&path, &frame(0));
    (1..4).for_each(|number| file.append(&frame(number)).unwrap());
    let file = hdf5::File::open(&path).unwrap();
    let stress = file.dataset("VTKHDF/PointData/stress").unwrap();
    let chunk = stress.chunk().unwrap()[0];
    let values = stress.read_raw::<f64>().unwrap();
    let starts = file.dataset("VTKHDF/Steps/PointOffsets").unwrap().read_1d::<i64>().unwrap();
    assert_eq!(starts.to_vec(), [0, 1, 2, 3].map(|number| number * chunk as i64));
    let between = (100..chunk).chain(chunk + 3..3 * chunk);
    assert!(between.flat_map(|row| &values[9 * row..9 * row + 9]).all(|value| value.to_bits() == 0));
    assert_eq!(values[9 * 3 * chunk], 3.0);
}

#[test]
fn whoever_wrote_the_file_can_be_read() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let long = "x".repeat(1024);
    let given = [("run", "a1b2"), ("program", "scree 0.1.0 – ä"), ("none", ""), ("long", &long)];
    let file = FrameFile::create(&path, &sample::scratch(&path), &frame(0), 100, &given, &[]).unwrap();
    let told = |path: &Path| frames::attributes(path).unwrap();
    let wanted = given.map(|(key, text)| (key.to_owned(), text.to_owned())).into();
    assert_eq!(told(&path), wanted);
    // Other parts have it too, also of a run that was resumed.
    let mut file = file.with_parts_of(1);
    file.append(&frame(1)).unwrap();
    assert_eq!(told(&folder.join("frames.2.vtkhdf")), wanted);
    let mut file = sample::open_and_cut(&path, 1).unwrap().with_parts_of(1);
    file.append(&frame(1)).unwrap();
    assert_eq!(told(&folder.join("frames.2.vtkhdf")), wanted);
}

#[test]
fn fields_tell_their_units_in_every_part() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let mut file = sample::create(&path, &frame(0)).with_parts_of(1);
    file.append(&frame(1)).unwrap();
    let mut file = sample::open_and_cut(&path, 1).unwrap().with_parts_of(1);
    file.append(&frame(2)).unwrap();
    for path in [path, folder.join("frames.2.vtkhdf")] {
        let file = hdf5::File::open(&path).unwrap();
        for meaning in sample::MEANINGS {
            let dataset = ["PointData", "FieldData", "."]
                .iter()
                .find_map(|group| file.dataset(&format!("VTKHDF/{group}/{}", meaning.field)).ok());
            let dataset = dataset.unwrap();
            let told = |key: &str| dataset.attr(key).unwrap().read_scalar::<FixedUnicode<64>>().unwrap().to_string();
            assert_eq!([told("units"), told("long_name")], [meaning.unit, meaning.what]);
        }
        assert!(file.dataset("VTKHDF/NumberOfPoints").unwrap().attr("units").is_err());
    }
}

/// A file with the first frames, its second file, and the folder that has the latter.
fn begun(folder: &Path) -> (FrameFile, PathBuf, PathBuf) {
    let path = folder.join("frames.vtkhdf");
    let mut file = sample::create(&path, &frame(0));
    (1..4).for_each(|number| file.append(&frame(number)).unwrap());
    let scratch = sample::scratch(&path);
    (file, path, scratch)
}

fn only_file_in(folder: &Path) -> PathBuf {
    let files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

#[test]
fn a_second_file_that_is_lost_or_damaged_is_made_anew() {
    type Harm = fn(&Path);
    let harms: [Harm; 5] = [
        |twin| fs::remove_file(twin).unwrap(),
        |twin| fs::write(twin, "").unwrap(),
        |twin| fs::write(twin, "no file of frames").unwrap(),
        |twin| fs::write(twin, &fs::read(twin).unwrap()[..4000]).unwrap(),
        // One that is whole, but not of now.
        |twin| {
            let (_guard, elsewhere) = sample::folder();
            sample::create(&elsewhere.join("frames"), &frame(0));
            fs::copy(elsewhere.join("frames"), twin).unwrap();
        },
    ];
    for (number, harm) in harms.into_iter().enumerate() {
        let (_guard, folder) = sample::folder();
        let (mut file, path, scratch) = begun(&folder);
        let twin = only_file_in(&scratch);
        harm(&twin);
        (4..9).for_each(|number| file.append(&frame(number)).unwrap());
        assert_eq!(frames::read(&path).unwrap(), expected(0..9), "{number}");
        let twin = only_file_in(&scratch);
        assert_eq!(frames::read_part(&twin).unwrap(), expected(0..8), "{number}");
        drop(file);
        assert!(!twin.exists());
    }
}

#[test]
fn what_a_process_left_is_never_taken_up() {
    let (_guard, folder) = sample::folder();
    let (file, path, scratch) = begun(&folder);
    let of_another = scratch.join("contacts.vtkhdf.1-0.partial");
    fs::write(&of_another, "").unwrap();
    // Its process is killed here.
    std::mem::forget(file);
    fs::write(only_file_beside(&of_another), "damaged").unwrap();
    let mut file = sample::open_and_cut(&path, 4).unwrap();
    assert_eq!(only_file_in(&scratch), of_another);
    (4..9).for_each(|number| file.append(&frame(number)).unwrap());
    assert_eq!(frames::read(&path).unwrap(), expected(0..9));
    std::mem::forget(file);
    fs::remove_file(&path).unwrap();
    sample::create(&path, &frame(0));
    assert_eq!(only_file_in(&scratch), of_another);
}

fn only_file_beside(path: &Path) -> PathBuf {
    let others = fs::read_dir(path.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
    let others: Vec<PathBuf> = others.filter(|other| other != path).collect();
    assert_eq!(others.len(), 1, "{others:?}");
    others[0].clone()
}

/// A copy that is made of links, as backups are, shares the file.
#[test]
fn a_copy_made_of_links_keeps_what_it_had() {
    let (_guard, folder) = sample::folder();
    let (mut file, path, _) = begun(&folder);
    let copy = folder.join("of_yesterday");
    fs::hard_link(&path, &copy).unwrap();
    let bytes = fs::read(&copy).unwrap();
    (4..9).for_each(|number| file.append(&frame(number)).unwrap());
    assert!(fs::read(&copy).unwrap() == bytes);
    assert_eq!(frames::read(&path).unwrap(), expected(0..9));
}

/// The library opens a file once in a process, so one that is held cannot be added to: the frames go into another.
#[test]
fn a_file_held_open_by_the_process_itself_is_no_obstacle() {
    let (_guard, folder) = sample::folder();
    let (mut file, path, _) = begun(&folder);
    let held = hdf5::File::open(&path).unwrap();
    (4..9).for_each(|number| file.append(&frame(number)).unwrap());
    assert_eq!(frames::read(&path).unwrap(), expected(0..9));
    let counted = held.group("VTKHDF/Steps").unwrap().attr("NSteps").unwrap().read_scalar::<i64>().unwrap();
    assert_eq!(counted, 4);
}

/// The process that holds a file open: reads all frames that it had when it was opened, whenever it is told to.
#[test]
fn holds_a_file_open() {
    let Ok(path) = std::env::var(HELD) else { return };
    let file = hdf5::File::open(path).unwrap();
    let root = file.group("VTKHDF").unwrap();
    let frames = root.group("Steps").unwrap().attr("NSteps").unwrap().read_scalar::<i64>().unwrap() as usize;
    let stdin = std::io::stdin();
    println!("\nopen");
    for line in stdin.lock().lines() {
        drop(line.unwrap());
        let numbers = |name: &str| root.dataset(name).unwrap().read_1d::<i64>().unwrap().to_vec();
        let (starts, counts) = (numbers("Steps/PointOffsets"), numbers("NumberOfPoints"));
        let points = root.dataset("Points").unwrap();
        let radii = root.dataset("PointData/radius").unwrap();
        let mut same = frames > 0;
        for number in 0..frames {
            let (start, wanted) = (starts[number] as usize, frame(number));
            let rows = start..start + counts[number] as usize;
            let found = points.read_slice::<f64, _, IxDyn>((rows.clone(), ..)).unwrap();
            same &= found.iter().copied().eq(wanted.positions.as_flattened().iter().copied());
            let found = radii.read_slice_1d::<f64, _>(rows).unwrap();
            same &= Values::F64(found.to_vec()) == wanted.fields[1].values;
        }
        println!("{}", if same { "same" } else { "other" });
    }
}

/// Also one that sets no locks, as the library does not where it is told so: nothing of its frames is written again.
#[test]
fn a_reader_that_holds_the_file_open_keeps_what_it_had() {
    for locks in ["TRUE", "FALSE"] {
        held(locks);
    }
}

fn held(locks: &str) {
    let (_guard, folder) = sample::folder();
    let (mut file, path, _) = begun(&folder);
    (4..10).for_each(|number| file.append(&frame(number)).unwrap());
    let own = std::env::current_exe().unwrap();
    let mut reader = Command::new(own)
        .args(["appending::holds_a_file_open", "--exact", "--nocapture"])
        .env(HELD, &path)
        .env("HDF5_USE_FILE_LOCKING", locks)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut bytes = fs::File::open(&path).unwrap();
    let before = fs::read(&path).unwrap();
    let mut told = BufReader::new(reader.stdout.take().unwrap()).lines().map_while(Result::ok);
    assert!(told.any(|line| line == "open"));
    let mut asks = reader.stdin.take().unwrap();
    let mut keeps = |when: &str| {
        writeln!(asks, "read").unwrap();
        assert_eq!(told.next().as_deref(), Some("same"), "{when}");
    };
    keeps("at once");
    for number in 10..100 {
        file.append(&frame(number)).unwrap();
        keeps("after an append");
    }
    let mut file = sample::open_and_cut(&path, 3).unwrap();
    keeps("after a cut");
    (3..40).for_each(|number| file.append(&Frame { time: -1.0, ..frame(number + 1) }).unwrap());
    keeps("after other frames");
    let mut after = Vec::new();
    bytes.read_to_end(&mut after).unwrap();
    assert_eq!(after == before, locks == "TRUE", "the file that is held");
    drop(asks);
    assert!(reader.wait().unwrap().success());
}

/// Frames of this file begin where their predecessors end, and each has its own numbers of places.
fn of_before(folder: &Path) -> (PathBuf, Vec<Frame>) {
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames_of_before.vtkhdf");
    let path = folder.join("frames.vtkhdf");
    fs::copy(fixture, &path).unwrap();
    (path, [1, 2, 5, 7].map(frame).to_vec())
}

#[test]
fn a_file_of_an_earlier_version_can_be_read_and_gone_on_with() {
    for steps in 0..5 {
        let (_guard, folder) = sample::folder();
        let (path, mut wanted) = of_before(&folder);
        assert_eq!(frames::read(&path).unwrap(), wanted);
        assert_eq!(frames::read_frame(&path, 3).unwrap(), frame(7));
        assert!(frames::attributes(&path).unwrap().is_empty());
        let mut file = sample::open_and_cut(&path, steps).unwrap();
        wanted.truncate(steps);
        assert_eq!(frames::read(&path).unwrap(), wanted);
        for number in [9, 10, 8, 11] {
            file.append(&frame(number)).unwrap();
            wanted.push(frame(number));
            assert_eq!(frames::read(&path).unwrap(), wanted);
        }
        // What it was stays a part by itself, unless nothing is left of it.
        assert_eq!(folder.join("frames.2.vtkhdf").exists(), steps > 0);
        let mut file = sample::open_and_cut(&path, steps + 1).unwrap();
        wanted.truncate(steps + 1);
        file.append(&frame(3)).unwrap();
        wanted.push(frame(3));
        assert_eq!(frames::read(&path).unwrap(), wanted);
    }
}
