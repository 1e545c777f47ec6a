//! Loads on the surface of the material, wherever in a cell that is.

use scree::job::Job;
use scree::job::mpm::figures;
use scree::mpm::load::DETACHED;

use crate::patches::departure;
use crate::runs::{Ran, elastic, list, parse, same, schemes};

/// A block with nothing around it, from `lower` to `upper` along every axis in cells of 0.1 m.
fn block(dimension: usize, scheme: &str, [lower, upper]: [f64; 2], rest: &str) -> String {
    let space = if dimension == 2 { "plane" } else { "solid" };
    let list = |value: f64| list(dimension, [value; 3]);
    let grid = format!("space = \"{space}\"\nupper = {}\ncell = 0.1", list(1.0));
    let region = format!("[[region]]\nshape = \"box\"\nlower = {}\nupper = {}\n", list(lower), list(upper));
    elastic("block", &grid, scheme, [1e5, 0.3], &format!("{region}{rest}\n[time]\nstep = 1e-3\nend = 0.05"))
}

/// A pressure of 1 kPa on all sides, and material that has its stress.
fn on_all_sides(dimension: usize, at: &str) -> String {
    let faces = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"];
    let load =
        |face: &str| format!("[[load]]\nface = \"{face}\"\nkind = \"pressure\"\npressure = 1000\nacts_at = \"{at}\"\n");
    let stress = "[stress]\nkind = \"isotropic\"\npressure = 1000\n";
    faces[..2 * dimension].iter().map(|face| load(face)).chain([stress.to_string()]).collect()
}

/// A pressure all around holds material that has its stress at rest, under every scheme and wherever in a cell its sides are; loads at
/// points do not.
#[test]
fn a_pressure_holds_its_own_stress() {
    // Of whole cells, within cells, of a single cell, and of a single row of points.
    for sides in [[0.3, 0.7], [0.35, 0.6], [0.35, 0.45], [0.45, 0.5]] {
        for dimension in [2, 3] {
            if dimension == 3 && sides != [0.35, 0.45] {
                continue;
            }
            for scheme in schemes() {
                let ran = Ran::of(&block(dimension, &scheme, sides, &on_all_sides(dimension, "surface")));
                let [stress, velocity] = departure(&ran, dimension, [0.0; 3]);
                assert!(
                    stress < 1e-12 && velocity < 1e-13,
                    "{dimension}D {sides:?} {scheme}: {stress:.1e} {velocity:.1e}"
                );
            }
        }
    }
    let at_points = Ran::of(&block(2, "shape = \"quadratic\"", [0.35, 0.75], &on_all_sides(2, "points")));
    assert!(departure(&at_points, 2, [0.0; 3])[0] > 0.05);
}

/// The same of a block that is thrown across cells and blocks, away from walls.
#[test]
fn a_pressure_goes_with_its_surface() {
    for scheme in schemes() {
        let moves = "velocity = [2.0, -1.5]\n[decomposition]\ncells_per_block = 3\n";
        let text = block(2, &scheme, [0.35, 0.65], &(moves.to_string() + &on_all_sides(2, "surface")));
        let ran = Ran::of(&text);
        let [stress, velocity] = departure(&ran, 2, [2.0, -1.5, 0.0]);
        assert!(stress < 1e-10 && velocity < 1e-11, "{scheme}: {stress:.1e} {velocity:.1e}");
    }
}

/// A pressure on one side of material of three cells is all there, and of two and one cells as far as both sides do not share nodes.
#[test]
fn thin_material_bears_what_its_nodes_tell_apart() {
    let load = "[[load]]\nface = \"y_upper\"\nkind = \"pressure\"\npressure = 500\n[output]\nseries_interval = 1e-3\n";
    for (cells, most) in [(3, 1e-12), (2, 0.16), (1, 0.32)] {
        for scheme in schemes() {
            let width = 0.1 * f64::from(cells);
            let text = block(2, &scheme, [0.4, 0.4 + width], load);
            let Job::Mpm(job) = parse(&text) else { panic!("it has no grid") };
            assert_eq!(figures::rows_behind(&job, &job.loads[0], 9), 2 * cells as usize);
            let ran = Ran::of(&text);
            let (times, down) = (ran.series("time"), ran.series("momentum_y"));
            let first = times.iter().position(|time| *time > 0.0).unwrap();
            let share = down[first] / (-500.0 * width * 0.01 * times[first]);
            let is_hat = ["linear", "generalised"].iter().any(|shape| scheme.contains(shape));
            let most = if is_hat { 1e-12 } else { most };
            assert!(share < 1.0 + 1e-12 && 1.0 - share < most, "{cells} cells, {scheme}: {share}");
        }
    }
}

/// A pressure that ends within a side is all there, and so is one on a side of which a corner is under another.
#[test]
fn a_load_is_neither_more_nor_less_than_its_area() {
    let load = |face: &str, rest: &str| format!("[[load]]\nface = \"{face}\"\nkind = \"pressure\"\n{rest}\n");
    let more = load("y_upper", "pressure = 500\nlower = [0.5, 0]")
        + &load("x_upper", "pressure = 200\nacts_at = \"surface\"")
        + "[output]\nseries_interval = 1e-3\n";
    for scheme in schemes() {
        let ran = Ran::of(&block(2, &scheme, [0.35, 0.75], &more));
        let (times, x, y) = (ran.series("time"), ran.series("momentum_x"), ran.series("momentum_y"));
        let first = times.iter().position(|time| *time > 0.0).unwrap();
        // Depth 0.01 m; of 0.4 m a length of 0.25 m is loaded.
        let [along, down] = [-200.0 * 0.4, -500.0 * 0.25].map(|force| force * 0.01 * times[first]);
        let [x, y] = [x[first] / along, y[first] / down];
        assert!((x - 1.0).abs() < 1e-12 && (y - 1.0).abs() < 1e-12, "{scheme}: {x} {y} at {}", times[first]);
    }
}

/// A point that has come off the material is pressed by nothing: what presses across one axis would crush it. It is a point of the
/// material again once it is back, on any ranks.
#[test]
fn what_has_come_off_bears_no_pressure() {
    let load = |face: &str| format!("[[load]]\nface = \"{face}\"\nkind = \"pressure\"\npressure = 1000\n");
    let single = |velocity: &str| {
        format!("[[region]]\nshape = \"box\"\nlower = [0.8, 0.45]\nupper = [0.85, 0.5]\nvelocity = {velocity}\n")
    };
    let text = |velocity: &str| {
        block(2, "shape = \"generalised\"", [0.3, 0.6], &(single(velocity) + &load("x_lower") + &load("x_upper")))
            .replace("end = 0.05", "end = 0.2")
    };
    let ran = Ran::of(&text("[0, 0]"));
    let (places, deformations) = (ran.points("position"), ran.points("deformation"));
    let lone = places.iter().position(|place| place[0] > 0.7).expect("it is there");
    let off = (places[lone][0] - 0.825).abs() + (places[lone][1] - 0.475).abs();
    assert!(off < 1e-15, "nothing moves it: {off:.1e}");
    assert_eq!(deformations[lone], [1.0, 0.0, 0.0, 1.0], "or strains it");
    let borne = |deformation: &Vec<f64>| deformation[0] < 0.999;
    assert!(deformations.iter().filter(|deformation| borne(deformation)).count() > 30, "the block is pressed");
    // Thrown at the block it has arrived by then, and bears what the side of it does.
    let ran = Ran::of(&text("[-2, 0]"));
    let loads = ran.wholes_of("points", "loads");
    assert!(loads.iter().all(|word| word & DETACHED == 0), "{loads:?}");
    let folder = tempfile::tempdir().unwrap();
    same(&parse(&text("[-2, 0]")), folder.path(), "a point that comes back");
}
