//! A full disk is an error with its reason; what was there before stays good, and the process can go on.

use std::fs;
use std::path::Path;
use std::process::Command;

use scree_io::{Series, frames, series, store};

use crate::{pieces, sample};

/// The other half of the next test: runs where no file may exceed some kilobytes.
#[test]
fn under_a_limit() {
    let Ok(folder) = std::env::var("SCREE_IO_LIMITED_FOLDER") else {
        return;
    };
    let folder = Path::new(&folder);
    let path = folder.join("state.h5");
    store::write(&path, &sample::small_state()).unwrap();
    for _ in 0..3 {
        let error = store::write(&path, &sample::state()).unwrap_err();
        assert!(error.to_string().contains("File too large"), "{error}");
        assert_eq!(store::read(&path).unwrap(), sample::small_state());
    }
    for rows in [1000, 20_000] {
        let error = pieces::write(&path, &sample::state(), |_| rows).unwrap_err();
        assert!(error.to_string().contains(".partial: File too large"), "{error}");
        assert_eq!(store::read(&path).unwrap(), sample::small_state());
        assert_eq!(fs::read_dir(folder).unwrap().count(), 1);
    }
    store::write(&path, &sample::small_state()).unwrap();

    let path = folder.join("energy.csv");
    let mut series = Series::create(&path, &["value"]).unwrap();
    let error = loop {
        if let Err(error) = series.push(&[0.123456789]) {
            break error;
        }
    };
    assert!(error.to_string().contains("energy.csv: File too large"), "{error}");
    assert_eq!(series::read(&path).unwrap().1.len(), series.rows());
    assert!(fs::read_to_string(&path).unwrap().ends_with('\n'));

    let path = folder.join("frames.vtkhdf");
    let mut file = sample::create(&path, &sample::frame(0));
    let error = (1..1000).find_map(|number| file.append(&sample::frame(number)).err()).unwrap();
    let text = error.to_string();
    assert!(text.contains("/scratch/frames.vtkhdf.") && text.contains(".partial: File too large"), "{text}");
    let whole: Vec<_> = (0..file.frames()).map(sample::frame).collect();
    assert!(whole.len() > 3);
    assert_eq!(frames::read(&path).unwrap(), whole);
    // It may be tried again, and every time nothing is left of it.
    for _ in 0..3 {
        assert!(file.append(&sample::frame(whole.len() / 6 * 6 + 3)).is_err());
        assert_eq!(frames::read(&path).unwrap(), whole);
        assert_eq!(fs::read_dir(sample::scratch(&path)).unwrap().count(), 0);
    }
    let mut empty = sample::frame(2);
    empty.time = 0.25 * whole.len() as f64;
    file.append(&empty).unwrap();
    assert_eq!(frames::read(&path).unwrap(), [whole.as_slice(), &[empty]].concat());
    let mut file = sample::open_and_cut(&path, 2).unwrap();
    file.append(&sample::frame(2)).unwrap();
    assert_eq!(frames::read(&path).unwrap(), whole[..3]);
    assert_eq!(fs::read_dir(folder).unwrap().count(), 4);
    println!("limited half done");
}

#[test]
fn a_limit_on_file_size_leaves_old_files_good() {
    let (_guard, folder) = sample::folder();
    let own = std::env::current_exe().unwrap();
    // The signal that would end the process is ignored, so that writes fail as they do on a full disk.
    let limited = "trap '' XFSZ; ulimit -f 400; exec \"$0\" full_disk::under_a_limit --exact --nocapture";
    let output =
        Command::new("sh").args(["-c", limited]).arg(own).env("SCREE_IO_LIMITED_FOLDER", &folder).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    println!("{out}");
    assert!(output.status.success() && out.contains("limited half done"), "{out}\n{err}");
    assert!(!err.contains("HDF5-DIAG"), "{err}");
}
