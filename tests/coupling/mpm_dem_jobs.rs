//! The jobs of `jobs/mpm_dem/` and `jobs/methods/`, made small as their heads say: they run, and come to what RVEs of a hundred discs on coarse grids have found.
//! Figures of the jobs as they are stand in docs/validation/mpm_dem.md and methods.md.

use scree::job::Job;

use crate::runs::Ran;

/// What stands before the settings in the head of a job.
const SMALL: &str = "as the tests run it: --set ";

/// A job as its head has it for tests.
fn small(name: &str, text: &str) -> Ran {
    let head =
        text.lines().find_map(|line| line.split_once(SMALL)).expect("the head of a job says how it is made small").1;
    let cache = std::env::temp_dir().join("scree-test-mpm-dem");
    let mut sets: Vec<String> = head.split(" --set ").map(str::to_string).collect();
    sets.push(format!("packing.cache={}", cache.display()));
    Ran::of_job(&Job::parse(text, name, &sets).unwrap_or_else(|error| panic!("{error}")))
}

/// Largest mean of nine rows, and the row in their middle.
fn peak(values: &[f64]) -> (f64, usize) {
    let means = values.windows(9).map(|rows| rows.iter().sum::<f64>() / 9.0).enumerate();
    means.map(|(row, mean)| (mean, row + 4)).max_by(|a, b| a.0.total_cmp(&b.0)).expect("there are nine rows")
}

/// The load has a peak at the strain at which one of an RVE is, and falls from there on.
#[test]
fn the_biaxial_specimen_has_a_peak() {
    let ran = small("biaxial.toml", include_str!("../../jobs/mpm_dem/biaxial.toml"));
    let (load, way) = (ran.series("plate_force_y"), ran.series("plate_displacement_y"));
    let (peak, row) = peak(&load);
    let [stress, strain] = [peak / 0.1, -100.0 * way[row] / 2.0];
    let late = load[load.len() - 9..].iter().sum::<f64>() / 9.0;
    println!("biaxial: {:.0} kPa at {strain:.2} %, {:.2} of it at the end", 1e-3 * stress, late / peak);
    assert!((3.4e5..4.1e5).contains(&stress) && (1.5..2.1).contains(&strain), "{stress:.0} Pa at {strain:.2} %");
    assert!(late < 0.95 * peak, "{late:.0} of {peak:.0} N");
    assert_eq!(ran.series("rve_loose").last(), Some(&0.0));
}

/// The same specimen of elements whose strain is nonlocal peaks where it does, and its account of energy closes, with the work of the overlay.
#[test]
fn a_nonlocal_specimen_of_elements_has_a_peak() {
    let ran = small("biaxial_fem_dem.toml", include_str!("../../jobs/methods/biaxial_fem_dem.toml"));
    let load = ran.series("plate_force_y");
    let (peak, row) = peak(&load);
    let [stress, strain] = [peak / 0.1, -100.0 * ran.series("plate_displacement_y")[row] / 2.0];
    let late = load[load.len() - 9..].iter().sum::<f64>() / 9.0;
    let [lost, by_plate, by_loads] =
        ["energy_lost", "work_bodies", "work_loads"].map(|column| *ran.series(column).last().unwrap());
    println!(
        "nonlocal elements: {:.0} kPa at {strain:.2} %, {:.2} of it at the end, {:.1e} of the work lost",
        1e-3 * stress,
        late / peak,
        lost / (by_plate + by_loads)
    );
    assert!((3.4e5..4.1e5).contains(&stress) && (1.5..2.1).contains(&strain), "{stress:.0} Pa at {strain:.2} %");
    assert!(late < 0.85 * peak, "{late:.0} of {peak:.0} N");
    assert!((lost / (by_plate + by_loads)).abs() < 0.015, "{lost} of {by_plate} and {by_loads} J");
}

/// A footing bears many times the surcharge beside it.
#[test]
fn a_footing_bears_more_than_its_surcharge() {
    let ran = small("footing_dense.toml", include_str!("../../jobs/mpm_dem/footing_dense.toml"));
    let (peak, row) = peak(&ran.series("footing_force_y"));
    let over = peak / (20e3 * 0.1);
    let settled = -ran.series("footing_displacement_y")[row];
    println!("footing: {over:.1} times the surcharge at {settled:.3} m");
    assert!((27.0..35.0).contains(&over) && (0.12..0.17).contains(&settled), "{over:.1} at {settled:.3} m");
}

/// A pipe that is pushed into its bed is held up by it, and RVEs that open beside it end nothing.
#[test]
fn a_pipe_is_held_up() {
    let ran = small("pipe.toml", include_str!("../../jobs/mpm_dem/pipe.toml"));
    let (peak, _) = peak(&ran.series("pipe_force_y"));
    println!("pipe: {:.0} kN/m at most", 1e-3 * peak / 0.1);
    assert!((3.4e5..4.5e5).contains(&(peak / 0.1)), "{peak:.0} N");
}

/// A column falls: grains have the time of the continuum, and a tenth of its energy is in motion.
#[test]
fn a_column_falls() {
    let ran = small("column.toml", include_str!("../../jobs/mpm_dem/column.toml"));
    let start = ran.series("potential")[0];
    let (kinetic, times) = (ran.series("kinetic"), ran.series("time"));
    let (most, row) = peak(&kinetic);
    println!("column: kinetic energy {:.3} of the potential at {:.2} s", most / start, times[row]);
    assert!((0.078..0.095).contains(&(most / start)) && (0.35..0.48).contains(&times[row]), "{most} at {}", times[row]);
    assert!(ran.series("potential").last().unwrap() / start < 0.75);
}
