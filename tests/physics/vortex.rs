//! The generalised vortex of Kamojjala, Brannon, Sadeghirad & Guilkey (2015), with Hencky's law in plane strain.
//!
//! A ring within a square turns by the angle alpha(R, t) = A sin(pi t) h(R), h = (1 - x^2)^3, x = (R - 1)/0.4, and nothing
//! else moves. In the basis that turns with it the material is in simple shear by gamma = R alpha', so that
//!
//! ```text
//! F = 1 + gamma e_t e_r,  ln(B)/2 = a dev(B),  a = asinh(gamma/2)/(gamma sqrt(1 + gamma^2/4)),  sigma = 2 G a dev(B)
//! b_r = -rho R (dalpha/dt)^2 - sigma_rr' - (sigma_rr - sigma_tt)/R
//! b_t =  rho R d2alpha/dt2   - sigma_rt' - 2 sigma_rt/R
//! ```

use scree::base::math::{PI, atan2, cos, ln, sin};
use scree::base::space::{Plane, Space};
use scree::law::material::Hencky;
use scree_partition::Solo;

use crate::runs::{orders, point_world, words};

type Vector = <Plane as Space>::Vector;

const DENSITY: f64 = 1000.0;
const SHEAR: f64 = 1000.0 / 2.6;
const BULK: f64 = 1000.0 / (3.0 * 0.4) + SHEAR / 3.0;
/// rad.
const AMPLITUDE: f64 = 0.3;

/// h and its slope, 1/m.
fn shape(radius: f64) -> [f64; 2] {
    let x = (radius - 1.0) / 0.4;
    let left = (1.0 - x * x).max(0.0);
    [left * left * left, -6.0 * x * left * left / 0.4]
}

/// rr, tt and rt, Pa.
fn stress(radius: f64, swing: f64) -> [f64; 3] {
    let gamma = radius * swing * shape(radius)[1];
    if gamma == 0.0 {
        return [0.0; 3];
    }
    let (half, root) = (0.5 * gamma, (1.0 + 0.25 * gamma * gamma).sqrt());
    let scale = 2.0 * SHEAR * ln(half + root) / (gamma * root);
    [-0.5 * scale * gamma * gamma, 0.5 * scale * gamma * gamma, scale * gamma]
}

/// Force per mass at a place of the start, along the axes, m/s2; and where it is now.
fn force_and_place(origin: &Vector, time: f64) -> (Vector, Vector) {
    let (radius, start) = (origin.norm(), atan2(origin[1], origin[0]));
    let swing = AMPLITUDE * sin(PI * time);
    let [height, _] = shape(radius);
    let (rate, turn) = (AMPLITUDE * PI * cos(PI * time) * height, -PI * PI * swing * height);
    let [rr, tt, rt] = stress(radius, swing);
    let apart = 1e-5;
    let (out, inward) = (stress(radius + apart, swing), stress(radius - apart, swing));
    let slope = |component: usize| (out[component] - inward[component]) / (2.0 * apart);
    let along = -radius * rate * rate - (slope(0) + (rr - tt) / radius) / DENSITY;
    let across = radius * turn - (slope(2) + 2.0 * rt / radius) / DENSITY;
    let angle = start + swing * height;
    let (radial, tangent) = (Vector::new(cos(angle), sin(angle)), Vector::new(-sin(angle), cos(angle)));
    (radial * along + tangent * across, radial * radius)
}

/// Root mean square over the points of what they are away from their places at half time, where the ring is turned the most,
/// and at the end, where it is back, m.
fn errors(scheme: &str, cells: usize) -> [f64; 2] {
    let cell = 3.2 / cells as f64;
    let step = 0.1 * cell;
    let text = format!(
        r#"
        name = "vortex"
        [grid]
        space = "plane"
        lower = [-1.6, -1.6]
        upper = [1.6, 1.6]
        cell = {cell}
        depth = 1
        [scheme]
        {scheme}
        points_per_cell = 2
        [material]
        law = "hencky"
        density = {DENSITY}
        bulk_modulus = {BULK}
        shear_modulus = {SHEAR}
        [[region]]
        shape = "box"
        lower = [-1.6, -1.6]
        upper = [1.6, 1.6]
        [time]
        step = {step}
        end = 1
        "#
    );
    let law = Hencky { bulk_modulus: BULK, shear_modulus: SHEAR };
    let mut world = point_world::<Plane>(&text, law, &Solo);
    for (hot, beside) in world.continuum.points.hot.iter_mut().zip(&mut world.continuum.points.beside) {
        // Half a step before the places of the start.
        let before = |place: &Vector| (force_and_place(place, 0.0).1 - force_and_place(place, -step).1) * (1.0 / step);
        hot.velocity = before(&hot.position);
        if scheme.contains("affine") {
            let apart = 1e-5;
            for column in 0..2 {
                let mut way = Vector::zeros();
                way[column] = apart;
                let slope = (before(&(hot.position + way)) - before(&(hot.position - way))) * (0.5 / apart);
                (beside.affine[2 * column], beside.affine[2 * column + 1]) = (slope[0], slope[1]);
            }
        }
    }
    let steps = (1.0 / step).round() as usize;
    [steps / 2, steps].map(|until| {
        while (world.step as usize) < until {
            let time = world.time();
            let points = &mut world.continuum.points;
            let rows = points.hot.iter().zip(&points.cold);
            let pushes = rows.map(|(hot, cold)| force_and_place(&cold.origin, time).0 * hot.mass);
            points.loaded = pushes.enumerate().map(|(row, push)| (row as u32, push)).collect();
            world.advance().unwrap();
        }
        let time = world.time();
        let points = &world.continuum.points;
        let squares = points.hot.iter().zip(&points.cold).map(|(hot, cold)| {
            let off = hot.position - force_and_place(&cold.origin, time).1;
            off.dot(&off)
        });
        (squares.sum::<f64>() / points.hot.len() as f64).sqrt()
    })
}

/// At three meshes for one scheme of each transfer, at two for the others; uGIMP is not held to the finest, where its points come
/// apart on the way back.
#[test]
fn a_vortex_is_met_with_second_order() {
    for (scheme, limits) in [
        ("shape = \"quadratic\"\nupdate = \"last\"\ntransfer = \"affine\"", [4e-4, 2e-3]),
        ("shape = \"quadratic\"\nupdate = \"modified_last\"\nflip = 1.0", [7e-4, 3e-3]),
        ("shape = \"quadratic\"\nupdate = \"last\"\nflip = 0.99", [7e-4, 3e-3]),
        ("shape = \"cubic\"\nupdate = \"modified_last\"\nflip = 1.0", [7e-4, 3e-3]),
        ("shape = \"generalised\"\nupdate = \"modified_last\"\nflip = 1.0", [2e-3, 1.0]),
    ] {
        let finest = if scheme.contains("affine") || scheme.contains("cubic") { 128 } else { 64 };
        let all = [finest / 4, finest / 2, finest].map(|cells| errors(scheme, cells));
        let [half, end] = [0, 1].map(|which| all.map(|errors| errors[which]));
        println!(
            "{:60} at half time {} orders {:.2?}, at the end {} orders {:.2?}",
            scheme.replace('\n', " "),
            words(&half),
            orders(&half),
            words(&end),
            orders(&end)
        );
        // Limits are those of 128 cells; twice as large ones are off by four times as much, and a fifth more where the order is not
        // reached yet.
        let share = if finest == 128 { 1.0 } else { 4.0 * 1.2 };
        assert!(half[2] < share * limits[0] && end[2] < share * limits[1], "{scheme}");
        let coarse = if finest == 128 { 0 } else { 1 };
        assert!(scheme.contains("generalised") || orders(&end)[coarse] > 1.9, "{scheme}");
    }
}
