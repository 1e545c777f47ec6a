//! Frames come back as written, also after a cut.

use std::fs;
use std::path::Path;

use scree_io::{Drawn, Error, Frame, FrameFile, Values, frames};

use crate::sample::{self, frame};

fn write(path: &Path, numbers: std::ops::Range<usize>) -> FrameFile {
    let mut file = sample::create(path, &frame(numbers.start));
    numbers.skip(1).for_each(|number| file.append(&frame(number)).unwrap());
    file
}

fn expected(numbers: std::ops::Range<usize>) -> Vec<Frame> {
    numbers.map(frame).collect()
}

#[test]
fn come_back_as_written() {
    let (_guard, folder) = sample::folder();
    for start in [0, 2] {
        let path = folder.join(format!("{start}.vtkhdf"));
        let file = write(&path, start..9);
        assert_eq!(file.frames(), 9 - start);
        assert_eq!(frames::read(&path).unwrap(), expected(start..9));
        assert_eq!(frames::read_frame(&path, 3).unwrap(), frame(start + 3));
        assert_eq!(frames::times(&path).unwrap(), (start..9).map(|n| 0.25 * n as f64).collect::<Vec<_>>());
    }
}

#[test]
fn can_be_read_after_every_append() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let mut file = sample::create(&path, &frame(0));
    for number in 1..8 {
        assert_eq!(frames::read(&path).unwrap(), expected(0..number));
        file.append(&frame(number)).unwrap();
    }
}

#[test]
fn cut_and_continued_equal_those_of_an_uninterrupted_run() {
    let (_guard, folder) = sample::folder();
    for steps in [0, 1, 4, 7] {
        let path = folder.join(format!("{steps}.vtkhdf"));
        write(&path, 0..7);
        let mut file = sample::open_and_cut(&path, steps).unwrap();
        assert_eq!(file.frames(), steps);
        assert_eq!(frames::read(&path).unwrap(), expected(0..steps));
        (steps..13).for_each(|number| file.append(&frame(number)).unwrap());
        assert_eq!(frames::read(&path).unwrap(), expected(0..13));
    }
}

#[test]
fn lines_come_back_as_written() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("contacts.vtkhdf");
    let lines: Vec<Frame> = (0..9).map(|number| sample::frame_of(Drawn::Lines, number)).collect();
    let mut file = sample::create(&path, &lines[0]);
    lines[1..].iter().for_each(|frame| file.append(frame).unwrap());
    assert_eq!(frames::read(&path).unwrap(), lines);
    let mut file = sample::open_and_cut(&path, 4).unwrap();
    let message = file.append(&frame(4)).unwrap_err().to_string();
    assert!(message.contains("depth: 1 x f64; of lines]"), "{message}");
    lines[4..].iter().for_each(|frame| file.append(frame).unwrap());
    assert_eq!(frames::read(&path).unwrap(), lines);
}

/// Nobody but the names of the files tells that there are several.
#[test]
fn parts_are_one_list() {
    const BYTES: u64 = 40_000;
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let mut file = sample::create(&path, &frame(0)).with_parts_of(BYTES);
    (1..30).for_each(|number| file.append(&frame(number)).unwrap());
    let parts = || sample::frame_files(&folder);
    let written = parts();
    assert!(written > 3 && folder.join("frames.2.vtkhdf").exists(), "{written}");
    assert_eq!(file.frames(), 30);
    assert_eq!(frames::read(&path).unwrap(), expected(0..30));
    assert_eq!(frames::times(&path).unwrap().len(), 30);
    for number in [0, 7, 29] {
        assert_eq!(frames::read_frame(&path, number).unwrap(), frame(number));
    }
    assert!(matches!(frames::read_frame(&path, 30), Err(Error::TooFewFrames { found: 30, .. })));
    assert!(matches!(sample::open_and_cut(&path, 31), Err(Error::TooFewFrames { found: 30, .. })));
    for steps in [30, 29, 23, 11, 1, 0] {
        let mut file = sample::open_and_cut(&path, steps).unwrap().with_parts_of(BYTES);
        assert_eq!(file.frames(), steps);
        assert_eq!(frames::read(&path).unwrap(), expected(0..steps));
        (steps..30).for_each(|number| file.append(&frame(number)).unwrap());
        assert_eq!(frames::read(&path).unwrap(), expected(0..30));
        assert_eq!(parts(), written);
        sample::open_and_cut(&path, steps).unwrap();
    }
    assert_eq!(parts(), 1);
    fs::remove_file(&path).unwrap();
    fs::write(folder.join("frames.2.vtkhdf"), "of another run").unwrap();
    let error = FrameFile::create(&path, &sample::scratch(&path), &frame(0), 0, &[], &[]).unwrap_err();
    assert!(error.to_string().contains("frames.2.vtkhdf"), "{error}");
}

#[test]
fn other_fields_are_refused_and_both_lists_named() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let mut file = write(&path, 0..2);
    let mut other = frame(2);
    other.fields.pop();
    let message = file.append(&other).unwrap_err().to_string();
    assert!(
        message.contains("frames.vtkhdf")
            && message.contains("stress: 9 x f64; of the whole edges: 9 x f64, depth: 1 x f64], "),
        "{message}"
    );
    assert!(
        message.contains("stress: 9 x f64, id: 1 x i64; of the whole edges: 9 x f64, depth: 1 x f64]"),
        "{message}"
    );
    let mut other = frame(0);
    other.fields[3].values = Values::F64(vec![0.0; 100]);
    assert!(matches!(file.append(&other), Err(Error::FrameFields { .. })));
    assert_eq!(frames::read(&path).unwrap(), expected(0..2));
}

#[test]
fn too_few_frames_are_counted_in_the_message() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    write(&path, 0..3);
    let error = sample::open_and_cut(&path, 4).unwrap_err();
    assert!(error.to_string().contains("frames.vtkhdf holds 3 frames, 4 are needed"), "{error}");
    assert!(matches!(frames::read_frame(&path, 3), Err(Error::TooFewFrames { found: 3, .. })));
    assert_eq!(frames::read(&path).unwrap().len(), 3);
}

#[test]
fn creating_never_overwrites_and_other_files_are_refused() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    write(&path, 0..1);
    let error = FrameFile::create(&path, &sample::scratch(&path), &frame(1), 0, &[], &[]).unwrap_err();
    assert!(error.to_string().contains("move it aside"), "{error}");

    let state = folder.join("state.h5");
    scree_io::store::write(&state, &sample::small_state()).unwrap();
    assert!(matches!(frames::read(&state), Err(Error::Foreign { .. })));
    let error = sample::open_and_cut(&folder.join("absent"), 0).unwrap_err();
    assert!(error.to_string().contains("absent: No such file"), "{error}");
}

#[test]
fn damage_names_the_file_and_the_field() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    write(&path, 3..4);
    let whole = fs::read(&path).unwrap();
    let mut named = 0;
    for offset in (0..whole.len()).step_by(97) {
        let mut bytes = whole.clone();
        bytes[offset] ^= 0x10;
        fs::write(&path, &bytes).unwrap();
        if let Err(error) = frames::read(&path) {
            assert!(error.to_string().contains("frames.vtkhdf"), "{error}");
            named += usize::from(error.to_string().contains("frame 0, field \"stress\""));
        }
    }
    assert!(named > 0);
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(matches!(frames::read(&path), Err(Error::Truncated { .. })));
}

#[test]
#[should_panic(expected = "field kind must be f64 or i64, not u8")]
fn a_field_of_bytes_is_a_bug() {
    let (_guard, folder) = sample::folder();
    let column = scree_io::Column { name: "kind".to_owned(), width: 1, values: Values::U8(vec![]) };
    let _ = sample::create(&folder.join("f"), &Frame { fields: vec![column], ..sample::frame(2) });
}
