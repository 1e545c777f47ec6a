//! What frames cost: bytes handed to the system and time, of the first frames and of the last.
//!
//! ```text
//! cargo run --release -p scree-io --example frame_cost -- ROWS FRAMES [FOLDER]
//! ```
//!
//! A frame has the fields of a run of grains and points in the plane, 22 of them; a third of the numbers of a vector are zero.

use std::path::Path;
use std::time::Instant;

use scree_io::{Column, Drawn, Frame, FrameFile, Values};

const SCALARS: [&str; 12] = ["radius", "weight", "p", "q", "s", "e", "g", "r", "f", "h", "t", "w"];

/// Numbers without any order, as digits that count are to a compressor.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn frame(number: usize, rows: usize) -> Frame {
    let mut noise = Noise(number as u64);
    let mut numbers = |width: usize, zero: usize| -> Values {
        let value = |at: usize| if zero > 0 && at % width >= zero { 0.0 } else { noise.next() };
        Values::F64((0..rows * width).map(value).collect())
    };
    let column = |name: &str, width, values| Column { name: name.to_owned(), width, values };
    let mut fields = vec![
        column("kind", 1, Values::I64(vec![1; rows])),
        column("id", 1, Values::I64((0..rows as i64).collect())),
        column("coordination", 1, Values::I64((0..rows as i64).map(|row| row * 7 % 5).collect())),
        column("displacement", 3, numbers(3, 2)),
        column("velocity", 3, numbers(3, 2)),
        column("spin", 3, numbers(3, 1)),
        column("stress", 3, numbers(3, 0)),
    ];
    fields.extend(SCALARS.into_iter().map(|name| column(name, 1, numbers(1, 0))));
    let Values::F64(flat) = numbers(3, 2) else { unreachable!() };
    let positions = flat.as_chunks::<3>().0.to_vec();
    let whole = vec![
        column("cell_corner", 3, Values::F64(vec![0.0; 3])),
        column("cell_edges", 9, Values::F64(vec![1.0; 9])),
        column("cell_periodic", 3, Values::F64(vec![1.0; 3])),
    ];
    Frame { time: number as f64, drawn: Drawn::Points, positions, fields, whole }
}

/// Bytes that this process handed to the system for writing, and those that the system is to bring to disk.
fn written() -> [u64; 2] {
    let text = std::fs::read_to_string("/proc/self/io").unwrap_or_default();
    let of = |key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key));
        line.and_then(|number| number.trim().parse().ok()).unwrap_or(0)
    };
    [of("wchar:"), of("write_bytes:")]
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, otherwise| arguments.get(at).map_or(otherwise, |word| word.parse().expect("a number"));
    let (rows, frames): (usize, usize) = (number(0, 300), number(1, 400));
    let given = arguments.get(2).map(|folder| Path::new(folder).to_owned());
    let folder = given.unwrap_or_else(std::env::temp_dir).join(format!("frame_cost-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("frames.vtkhdf");
    let scratch = folder.join("scratch");
    std::fs::create_dir(&scratch).unwrap();
    let mut file = FrameFile::create(&path, &scratch, &frame(0, rows), rows, &[], &[]).unwrap();
    let (begun, [mut seconds, mut calls, mut blocks]) = (written(), [0.0, 0.0, 0.0]);
    let every = (frames / 10).max(1);
    println!("{rows} rows; per frame:   kB written   kB to disk       ms");
    for number in 1..=frames {
        let frame = frame(number, rows);
        let (before, clock) = (written(), Instant::now());
        file.append(&frame).unwrap();
        seconds += clock.elapsed().as_secs_f64();
        let after = written();
        calls += (after[0] - before[0]) as f64;
        blocks += (after[1] - before[1]) as f64;
        if number % every == 0 {
            let per = every as f64;
            let (kb, disk, ms) = (calls / 1e3 / per, blocks / 1e3 / per, 1e3 * seconds / per);
            println!("frames {:>6}..{number:<6} {kb:>12.1} {disk:>12.1} {ms:>8.2}", number - every + 1);
            [seconds, calls, blocks] = [0.0; 3];
        }
    }
    let end = written();
    let parts = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().metadata().unwrap());
    let size: u64 = parts.filter(|data| data.is_file()).map(|data| data.len()).sum();
    let total = end[0] - begun[0];
    println!("{frames} frames: {:.1} MB written for {:.1} MB", total as f64 / 1e6, size as f64 / 1e6);
    std::fs::remove_dir_all(&folder).unwrap();
}
