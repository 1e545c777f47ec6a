//! Checkpoints of more rows than travel at a time, from any number of ranks, and what becomes of them on a full disk.

use std::path::Path;
use std::process::Command;

use scree::base::error::Error;
use scree::base::ids::{GrainId, PointId};
use scree::base::space::Plane;
use scree::domain::transfer::{self, PIECE_ROWS};
use scree::law::contact::Memory;
use scree::run::start::{self, Continuation};
use scree::store::checkpoint::{self, Progress, Snapshot, Target};

use crate::runs::{done, elastic, options, parse};
use crate::worlds::PlanarPoint;
use scree_io::{digest, store};
use scree_partition::transport::threads;
use scree_partition::{Solo, Transport};

use crate::worlds::{Grain, PlanarWorld, Vector, contact, grain, open_world, settings};

const CELL: f64 = 3e-3;
/// Grains and points along an axis; of each there are more than a piece has.
const SIDE: u64 = 130;

/// A lattice of touching grains, each with a memory of its neighbour on either side, and of points.
fn world(transport: &dyn Transport) -> PlanarWorld<'_> {
    // Away from where the plates of other worlds are.
    let spacing = 12.0 * CELL / SIDE as f64;
    let place = |id: u64| [(id % SIDE) as f64 + 0.5, (id / SIDE) as f64 + 0.5 - 0.5 * SIDE as f64].map(|x| x * spacing);
    let ids = 0..if transport.rank() == 0 { SIDE * SIDE } else { 0 };
    let grains = ids.clone().map(|id| {
        let mut row: Grain = grain(id, place(id), 0.501 * spacing, 1e-6);
        let mut touch = |lower: u64, partner: u64| {
            let memory = Memory::of_words(&[1e-9 * (lower + 1) as f64]);
            row.contacts.push((GrainId(partner), memory));
        };
        if !id.is_multiple_of(SIDE) {
            touch(id - 1, id - 1);
        }
        if !(id + 1).is_multiple_of(SIDE) {
            touch(id, id + 1);
        }
        row
    });
    let points = ids.clone().map(|id| {
        let [x, y] = place(id);
        PlanarPoint::resting(PointId(id), Vector::new(x, y), 1e-6, 1e-9)
    });
    assert!(SIDE * (SIDE - 1) > PIECE_ROWS as u64);
    open_world(transport, CELL, settings(4e-7, contact(3.5)), grains.collect(), points.collect())
}

/// All of a world but its rows.
fn head(world: &PlanarWorld) -> Snapshot<Plane> {
    checkpoint::head(world, Progress::default(), "name = \"pieces\"".to_string())
}

/// Writes the world's state, made beside the name that it is to have.
fn write(path: &Path, world: &PlanarWorld) -> Result<(), Error> {
    let scratch = path.parent().unwrap().to_path_buf();
    let target = || Target { scratch, path: path.to_path_buf(), head: head(world).to_state() };
    checkpoint::write((world.transport.rank() == 0).then(target), world)
}

#[test]
fn pieces_of_any_number_of_ranks_are_the_whole_state() {
    let folder = tempfile::tempdir().unwrap();
    let alone = world(&Solo);
    let (grains, points) = alone.rows();
    let whole = Snapshot { grains, points, ..head(&alone) }.to_state();
    assert!(whole.table("contacts").unwrap().rows == (SIDE * (SIDE - 1)) as usize);
    for ranks in 1..5 {
        let path = folder.path().join(format!("{ranks}.h5"));
        threads::run(ranks, |rank| {
            let world = world(&rank);
            write(&path, &world).unwrap();
        });
        let read = store::read(&path).unwrap();
        assert!(read == whole, "{ranks} ranks");
        assert_eq!(digest(&read), digest(&whole));
    }
}

/// States of before points counted what they dissipate are gone on with, from nothing.
#[test]
fn points_that_counted_nothing_begin_at_nothing() {
    let alone = world(&Solo);
    let (_, points) = alone.rows();
    let mut state = Snapshot { points: points.clone(), ..head(&alone) }.to_state();
    for table in state.tables.iter_mut().filter(|table| table.name == "points") {
        table.columns.retain(|column| column.name != "plastic_work");
    }
    let read = Snapshot::<Plane>::from_state(state, 1).unwrap().points;
    assert_eq!(read.len(), points.len());
    assert!(read.iter().zip(&points).all(|(read, point)| read.hot == point.hot && read.cold.id == point.cold.id));
}

/// The other half of the next test: runs where no file may have more than some kilobytes.
#[test]
fn under_a_limit() {
    let Ok(folder) = std::env::var("SCREE_PIECES_LIMITED_FOLDER") else { return };
    let folder = Path::new(&folder);
    let path = folder.join("step.h5");
    store::write(&path, &scree_io::State::default()).unwrap();
    let errors = threads::run(3, |rank| {
        let world = world(&rank);
        write(&path, &world).unwrap_err().to_string()
    });
    assert!(errors[0].contains("step.h5.") && errors[0].contains(".partial: File too large"), "{errors:?}");
    assert!(errors.iter().all(|error| *error == errors[0]), "{errors:?}");
    assert_eq!(store::read(&path).unwrap(), scree_io::State::default());
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 1);
    println!("limited half done");
}

#[test]
fn a_full_disk_is_told_on_all_ranks_and_leaves_the_file_of_before() {
    let folder = tempfile::tempdir().unwrap();
    // The signal that would end the process is ignored, so that writes fail as they do on a full disk.
    let limited = "trap '' XFSZ; ulimit -f 100; exec \"$0\" pieces::under_a_limit --exact --nocapture";
    let mut command = Command::new("sh");
    command.args(["-c", limited]).arg(std::env::current_exe().unwrap());
    let output = command.env("SCREE_PIECES_LIMITED_FOLDER", folder.path()).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("limited half done"), "{out}\n{err}");
}

#[test]
fn a_failure_at_any_piece_is_the_outcome_of_all_ranks() {
    let point = |id: usize| PlanarPoint::resting(PointId(id as u64), Vector::zeros(), 1.0, 1.0);
    for last in 0..5 {
        let outcomes = threads::run(3, |rank| {
            let mut pieces = 0;
            transfer::stream(
                &rank,
                PIECE_ROWS,
                PIECE_ROWS + 1,
                |rows| rows.map(point).collect(),
                |rows: Vec<PlanarPoint>| {
                    assert_eq!(rows[0].cold.id.0 as usize, PIECE_ROWS * (pieces % 2));
                    pieces += 1;
                    if pieces > last { Err(Error::Run(format!("piece {last} is refused"))) } else { Ok(()) }
                },
            )
        });
        for outcome in outcomes {
            assert!(matches!(&outcome, Err(Error::Run(words)) if *words == format!("piece {last} is refused")));
        }
    }
}

/// A branch in blocks of another size than those of its state, where a point may be far from the block of its home.
#[test]
fn a_branch_goes_on_in_blocks_of_another_size() {
    let rest = "[[region]]\nshape = \"box\"\nlower = [0.2, 0.4]\nupper = [0.6, 0.8]\nvelocity = [2, 0.1]\n[time]\nend = \"0.3 s\"\n[decomposition]\ncells_per_block = 16\n[output]\nframe_interval = \"0.05 s\"\n";
    let grid = "space = \"plane\"\nupper = [1.6, 1.2]\ncell = 0.1";
    let text = elastic("strays", grid, "shape = \"generalised\"\ntransfer = \"affine\"", [1e5, 0.3], rest);
    let folder = tempfile::tempdir().unwrap();
    let (trunk, branch) = (folder.path().join("trunk"), folder.path().join("branch"));
    done(start::start(&parse(&text), &options(&trunk), &Solo));
    let sets = ["decomposition.cells_per_block=2", "time.end=0.35"].map(String::from);
    let continuation = Continuation { sets: &sets, branch: Some(&branch) };
    done(start::resume(&trunk, continuation, &options(&branch), &Solo));
    assert!(checkpoint::state_at(&branch, Some(0.35)).is_ok());
}
