//! Limit loads of strip footings, by the jobs that come with the program on coarse cells; VALIDATION.md has the fine ones.

use std::path::Path;

use scree::base::math::{PI, exp, tan};

use crate::runs::Ran;

/// Footing's load over `exact` (N) in the second half of the settlement, least and most, with cells of `cell`.
fn plateau(job: &str, cell: f64, exact: f64) -> (f64, f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/continuum").join(job);
    let text = std::fs::read_to_string(&path).unwrap();
    let own = text.lines().find(|line| line.starts_with("cell = ")).unwrap();
    let ran = Ran::of(&text.replace(own, &format!("cell = {cell:?}")));
    let settled = ran.series("footing_displacement_y");
    let last = settled[settled.len() - 1];
    let late = ran.series("footing_force_y").into_iter().zip(&settled).filter(|(_, y)| **y <= last / 2.0);
    late.fold((f64::INFINITY, 0.0), |(least, most), (force, _)| {
        (f64::min(least, force / exact), f64::max(most, force / exact))
    })
}

/// The load comes to Prandtl's from below and stays there: the grid does not lock.
#[test]
fn footings_on_seven_cells_bear_nine_tenths_of_prandtl_and_no_more() {
    let (least, most) = plateau("prandtl_cohesive.toml", 1.0 / 7.0, (2.0 + PI) * 10e3 * 0.5);
    println!("cohesive: {least:.4} to {most:.4}");
    assert!(least > 0.93 && most < 0.96, "{least} to {most}");
    let phi = 28.1 * PI / 180.0;
    let half = tan(PI / 4.0 + phi / 2.0);
    let (least, most) = plateau("prandtl_surcharge.toml", 2.0 / 7.0, half * half * exp(PI * tan(phi)) * 20e3);
    println!("surcharge: {least:.4} to {most:.4}");
    assert!(least > 0.87 && most < 0.93, "{least} to {most}");
}
