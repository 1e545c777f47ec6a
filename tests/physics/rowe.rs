//! Equal spheres on a face-centred cubic lattice, compressed along a cube axis while both lateral stresses are held, bear at most
//! sigma_1/sigma_3 = 2 (1 + mu)/(1 - mu): Thornton (1979), Rowe (1962).

use std::f64::consts::{PI, SQRT_2};
use std::fmt::Write;

use crate::runs::Ran;

/// Of a sphere, m.
const DIAMETER: f64 = 1e-3;
/// Lateral stress, Pa.
const PRESSURE: f64 = 1e4;
/// Of the springs, N/m: 1e5 times the stress across a sphere, so that the lattice fails before its contacts have turned.
const STIFFNESS: f64 = 1e5 * PRESSURE * DIAMETER;
/// Cubes of four spheres along each axis.
const CUBES: usize = 4;

/// The largest of sigma_zz over the mean of the others, and the strain at it.
fn peak(friction: f64) -> [f64; 2] {
    // Equal stress of all axes: every contact bears N = p D^2/(2 sqrt 2).
    let overlap = PRESSURE * DIAMETER * DIAMETER / (2.0 * SQRT_2) / STIFFNESS;
    let cube = SQRT_2 * (DIAMETER - overlap);
    let edge = CUBES as f64 * cube;
    let mut grains = String::from("id,x,y,z,radius\n");
    let sites = [[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]];
    for id in 0..4 * CUBES * CUBES * CUBES {
        let (site, place) = (sites[id % 4], id / 4);
        let at = [place % CUBES, place / CUBES % CUBES, place / CUBES / CUBES];
        let [x, y, z]: [f64; 3] = std::array::from_fn(|axis| (at[axis] as f64 + site[axis]) * cube);
        writeln!(grains, "{id},{x:e},{y:e},{z:e},{:e}", 0.5 * DIAMETER).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lattice.csv");
    std::fs::write(&file, grains).unwrap();
    let mass = 2650.0 * PI / 6.0 * DIAMETER * DIAMETER * DIAMETER;
    let step = 0.05 * (mass / STIFFNESS).sqrt();
    // An inertial number of 2e-5.
    let rate = 2e-5 / (DIAMETER * (2650.0 / PRESSURE).sqrt());
    let strain = 4e-5;
    let ran = Ran::of(&format!(
        r#"
        name = "lattice"
        [cell]
        space = "solid"
        upper = [{edge:e}, {edge:e}, {edge:e}]
        velocity_gradient = [[0, 0, 0], [0, 0, 0], [0, 0, -{rate:e}]]
        stress_normal = [{PRESSURE:e}, {PRESSURE:e}, "free"]
        rate_max = {:e}
        [grains]
        density = 2650
        file = "{}"
        diameter_mean = {DIAMETER:e}
        [contact]
        law = "linear"
        stiffness_normal = {STIFFNESS:e}
        stiffness_tangential = {STIFFNESS:e}
        damping_normal = {damping:e}
        damping_tangential = {damping:e}
        friction = {friction}
        [time]
        step = {step:e}
        end = {:e}
        [output]
        series_interval = {:e}
        "#,
        1e2 * rate,
        file.display(),
        strain / rate,
        strain / rate / 400.0,
        damping = 0.2 * (mass * STIFFNESS).sqrt(),
    ));
    let [lateral, across, axial] = ["stress_xx", "stress_yy", "stress_zz"].map(|name| ran.series(name));
    let rows = axial.len();
    let strains = ran.series("time").into_iter().map(|time| rate * time);
    let ratios = (0..rows).map(|row| 2.0 * axial[row] / (lateral[row] + across[row]));
    ratios.zip(strains).fold([0.0; 2], |best, (ratio, strain)| if ratio > best[0] { [ratio, strain] } else { best })
}

#[test]
fn a_cubic_array_of_spheres_bears_what_friction_allows() {
    for friction in [0.1, 0.3] {
        let wanted = 2.0 * (1.0 + friction) / (1.0 - friction);
        let [found, strain] = peak(friction);
        println!(
            "mu = {friction}: {found:.4} at {strain:.2e}, wanted {wanted:.4}, off by {:.2} %",
            100.0 * (found / wanted - 1.0)
        );
        assert!((found / wanted - 1.0).abs() < 5e-3, "mu = {friction}: {found} for {wanted}");
    }
}
