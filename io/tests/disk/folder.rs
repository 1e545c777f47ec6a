//! A folder of checkpoints: newest first, damaged ones reported and passed over, old ones removed.

use std::fs;

use scree_io::{Error, State, schema, store};

use crate::{sample, store::flip};

fn state(step: u64) -> State {
    let mut state = sample::small_state();
    state.attributes.insert("state.step".to_owned(), step.to_string());
    state
}

fn fill(folder: &std::path::Path, steps: &[u64]) {
    for step in steps {
        store::write(&folder.join(store::file_name(*step)), &state(*step)).unwrap();
    }
}

fn steps(folder: &std::path::Path) -> Vec<u64> {
    store::newest(folder).unwrap().into_iter().map(|(step, _)| step).collect()
}

#[test]
fn lists_checkpoints_newest_first_and_nothing_else() {
    let (_guard, folder) = sample::folder();
    fill(&folder, &[5, 12, 9]);
    for other in ["step-5.h5", "step-00000000000x.h5", "step-000000000007.h5.partial", "step-+00000000007.h5", "a"] {
        fs::write(folder.join(other), "").unwrap();
    }
    assert_eq!(steps(&folder), [12, 9, 5]);
    assert_eq!(store::file_name(12), "step-000000000012.h5");
}

#[test]
fn a_damaged_newest_is_reported_and_the_one_before_it_taken() {
    let (_guard, folder) = sample::folder();
    fill(&folder, &[1, 2, 3, 4]);
    let newest = folder.join(store::file_name(4));
    fs::write(&newest, &fs::read(&newest).unwrap()[..1000]).unwrap();
    let second = folder.join(store::file_name(3));
    let bytes = fs::read(&second).unwrap();
    // The first byte whose change matters.
    let flipped = (0..bytes.len() as u64).find(|offset| {
        flip(&second, *offset);
        let found = store::read(&second).is_err();
        if !found {
            flip(&second, *offset);
        }
        found
    });
    assert!(flipped.is_some());

    let (path, found, damaged) = store::latest_good(&folder).unwrap();
    assert_eq!(path, folder.join(store::file_name(2)));
    assert_eq!(found, state(2));
    assert_eq!(damaged.len(), 2);
    assert!(damaged[0].to_string().contains("step-000000000004.h5"), "{}", damaged[0]);
    assert!(damaged[1].to_string().contains("step-000000000003.h5"), "{}", damaged[1]);
}

#[test]
fn a_folder_without_a_good_one_is_never_a_fresh_start() {
    let (_guard, folder) = sample::folder();
    let error = store::latest_good(&folder).unwrap_err();
    assert!(matches!(error, Error::NoCheckpoint { .. }), "{error}");
    for step in [1, 2] {
        fs::write(folder.join(store::file_name(step)), "gone").unwrap();
    }
    let error = store::latest_good(&folder).unwrap_err();
    assert!(matches!(&error, Error::AllDamaged { damaged, .. } if damaged.len() == 2), "{error}");
    assert!(error.to_string().contains("step-000000000002.h5"), "{error}");
    let error = store::latest_good(&folder.join("absent")).unwrap_err();
    assert!(error.to_string().contains("absent"), "{error}");
}

#[test]
fn another_schema_stops_the_search() {
    let (_guard, folder) = sample::folder();
    fill(&folder, &[1, 2]);
    let file = hdf5::File::open_rw(folder.join(store::file_name(2))).unwrap();
    file.attr("schema_version").unwrap().write_scalar(&(schema::SCHEMA_VERSION + 1)).unwrap();
    file.close().unwrap();
    assert!(matches!(store::latest_good(&folder), Err(Error::Schema { .. })));
}

/// Damage to all of the newest ones used to end the run, though older ones were kept for good.
#[test]
fn those_kept_for_good_serve_where_all_newer_ones_are_damaged() {
    let (_guard, folder) = sample::folder();
    fill(&folder, &[1, 2, 3]);
    let kept = folder.join(store::file_name(2));
    store::keep_for_good(&kept).unwrap();
    fs::remove_file(&kept).unwrap();
    for step in [1, 3] {
        fs::write(folder.join(store::file_name(step)), "gone").unwrap();
    }
    let (path, found, damaged) = store::latest_good(&folder).unwrap();
    assert_eq!(path, folder.join("for_good").join(store::file_name(2)));
    assert_eq!((found, damaged.len()), (state(2), 1));

    // Where a file can have but one name, they are two of which one may be good.
    fs::write(&kept, "gone").unwrap();
    let (path, found, damaged) = store::latest_good(&folder).unwrap();
    assert_eq!(path, folder.join("for_good").join(store::file_name(2)));
    assert_eq!((found, damaged.len()), (state(2), 2));
    assert_eq!(store::all(&folder).unwrap().len(), 3);
}

#[test]
fn pruning_keeps_the_newest_and_removes_leftovers() {
    let (_guard, folder) = sample::folder();
    fill(&folder, &[10, 20, 30, 40]);
    for leftover in ["step-000000000050.h5.partial", "step-000000000050.h5.77-3.partial"] {
        fs::write(folder.join(leftover), "").unwrap();
    }
    fs::write(folder.join("notes"), "").unwrap();
    assert_eq!(store::prune(&folder, 40, 2).unwrap().len(), 4);
    assert_eq!(steps(&folder), [40, 30]);
    assert_eq!(store::prune(&folder, 40, 2).unwrap().len(), 0);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 3);
}

/// What a run writes that had to go back behind damaged ones would otherwise be removed at once, for being older than these.
#[test]
fn pruning_leaves_those_after_the_one_just_written() {
    let (_guard, folder) = sample::folder();
    fill(&folder, &[10, 20, 30, 80, 90]);
    assert_eq!(store::prune(&folder, 30, 2).unwrap(), [folder.join(store::file_name(10))]);
    assert_eq!(steps(&folder), [90, 80, 30, 20]);
}
