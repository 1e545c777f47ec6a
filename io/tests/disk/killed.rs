//! A process that writes frames is killed at any moment, in the midst of an append too: every frame that it had said was
//! written can be read, and another process goes on from there.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use scree_io::{Frame, frames};

use crate::{paraview, sample};

const LIVES: u64 = 64;
const FOLDER: &str = "SCREE_IO_KILLED_FOLDER";

/// The process that is killed: appends frames for ever, and says how many there are after each.
#[test]
fn writes_until_it_is_killed() {
    let Ok(folder) = std::env::var(FOLDER) else { return };
    let path = Path::new(&folder).join("frames.vtkhdf");
    let counted: usize = std::env::var("SCREE_IO_KILLED_FRAMES").unwrap().parse().unwrap();
    let file = match counted {
        0 => sample::create(&path, &sample::frame(0)),
        steps => sample::open_and_cut(&path, steps).unwrap(),
    };
    let mut file = file.with_parts_of(40_000);
    loop {
        println!("frames {}", file.frames());
        std::io::stdout().flush().unwrap();
        file.append(&sample::frame(file.frames())).unwrap();
    }
}

fn life(folder: &Path, counted: usize) -> Child {
    let own = std::env::current_exe().unwrap();
    Command::new(own)
        .args(["killed::writes_until_it_is_killed", "--exact", "--nocapture"])
        .env(FOLDER, folder)
        .env("SCREE_IO_KILLED_FRAMES", counted.to_string())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Lets a process write some frames, kills it some time later and returns how many it had counted.
fn killed_after(mut child: Child, frames: usize, wait: Duration) -> usize {
    let mut told = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    let mut count = |line: String| line.split("frames ").nth(1)?.parse::<usize>().ok();
    let last = told.by_ref().filter_map(&mut count).nth(frames).expect("it writes until it is killed");
    std::thread::sleep(wait);
    child.kill().unwrap();
    child.wait().unwrap();
    told.filter_map(count).last().unwrap_or(last)
}

/// Whether it was killed while a file was in the making that is not whole.
fn is_half_a_file(scratch: &Path) -> bool {
    let mut files = std::fs::read_dir(scratch).unwrap().map(|entry| entry.unwrap().path());
    files.any(|file| frames::read_part(&file).is_err())
}

#[test]
fn no_frame_that_was_counted_is_lost() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("frames.vtkhdf");
    let mut counted = 0;
    let mut in_the_midst = 0;
    let mut read_by_vtk = 0;
    for number in 0..LIVES {
        let wait = Duration::from_micros(number * 977 % 19_000);
        counted = killed_after(life(&folder, counted), (number % 3) as usize, wait);
        in_the_midst += usize::from(is_half_a_file(&sample::scratch(&path)));
        let read = frames::read(&path).unwrap();
        assert!(read.len() == counted || read.len() == counted + 1, "{} frames, {counted} counted", read.len());
        let expected: Vec<Frame> = (0..read.len()).map(sample::frame).collect();
        assert!(read == expected, "life {number}: other frames");
        // VTK gives the time of one step among several only.
        let first_part = frames::read_part(&path).unwrap();
        if number % 16 == 0
            && first_part.len() > 1
            && let Some(found) = paraview::python(&path)
        {
            read_by_vtk += 1;
            paraview::assert_same(&found, &first_part);
        }
        // What a checkpoint counts lies before what is there.
        counted -= (number % 2) as usize;
    }
    println!("{LIVES} lives, {counted} frames, {in_the_midst} killed within an append, {read_by_vtk} read by VTK");
    assert!(folder.join("frames.2.vtkhdf").exists());
}
