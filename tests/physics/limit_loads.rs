//! Limit loads of strip footings, by the jobs that come with the program on coarse cells; docs/validation/continuum_problems.md has the fine ones.

use std::path::Path;

use scree::base::math::{PI, exp, tan};

use crate::runs::Ran;

/// Load of a footing whose half is `half` wide, the job's own being `job_half`, over `exact` (N/m) in the second half of the settlement, least
/// and most, with cells of `cell`.
fn plateau(job: &str, cell: f64, [job_half, half]: [f64; 2], exact: f64) -> (f64, f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/continuum").join(job);
    let text = std::fs::read_to_string(&path).unwrap();
    let own = text.lines().find(|line| line.starts_with("cell = ")).unwrap();
    let text = text.replace(own, &format!("cell = {cell:?}"));
    // The footing's edge, and that of the load beside it.
    let [edge, beside] = [format!("upper = [\"{job_half} m\", "), "lower = [\"0.99 m\", ".to_string()];
    assert!(text.contains(&edge), "{job} has no such footing");
    let text = text.replace(&edge, &format!("upper = [\"{half} m\", "));
    let text = text.replace(&beside, &format!("lower = [\"{} m\", ", half - 0.01));
    let ran = Ran::of(&text);
    let settled = ran.series("footing_displacement_y");
    let last = settled[settled.len() - 1];
    let late = ran.series("footing_force_y").into_iter().zip(&settled).filter(|(_, y)| **y <= last / 2.0);
    late.fold((f64::INFINITY, 0.0), |(least, most), (force, _)| {
        (f64::min(least, force / (exact * half)), f64::max(most, force / (exact * half)))
    })
}

/// The load comes to Prandtl's and stays there, wherever in a cell the footing's edge is: the grid does not lock, and no line of nodes is let go
/// or acted on as a whole where the edge passes it. Both are from above, by the lines that the edge covers in part.
#[test]
fn footings_on_seven_cells_bear_prandtl_s_load_wherever_their_edge_is() {
    let phi = 28.1 * PI / 180.0;
    let half = tan(PI / 4.0 + phi / 2.0);
    let jobs = [
        ("prandtl_cohesive.toml", 0.5, (2.0 + PI) * 10e3, 0.01, 1.09),
        ("prandtl_surcharge.toml", 1.0, half * half * exp(PI * tan(phi)) * 20e3, 0.01, 1.15),
    ];
    for (job, own, exact, swing, bound) in jobs {
        let cell = 2.0 * own / 7.0;
        let mut means = Vec::new();
        for quarter in -2..2 {
            let (least, most) = plateau(job, cell, [own, own + 0.25 * f64::from(quarter) * cell], exact);
            println!("{job} {quarter:2} quarters of a cell: {least:.4} to {most:.4}");
            assert!(most - least < 0.01 + 1.5 * swing, "{job}: {least} to {most}");
            assert!(least > 0.99 && most < bound, "{job}: {least} to {most}");
            means.push(0.5 * (least + most));
        }
        let steps = means.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let most = steps.fold(0.0, f64::max);
        assert!(most < 0.07, "{job}: {means:?}");
    }
}
