//! Indentation of a bed by a plate: `jobs/indentation.toml` in small.

use crate::runs::{Ran, replaced};

/// The job with a plate of 3 cm on a bed of 16 by 5 cm.
fn small() -> String {
    let whole = std::fs::read_to_string("jobs/indentation.toml").unwrap();
    let cache = format!("cache = \"{}\"", std::env::temp_dir().join("scree_test_packings").display());
    let changes = [
        (r#"upper = ["60 cm", "24 cm"]"#, r#"upper = ["16 cm", "7 cm"]"#),
        (r#"upper = ["60 cm", "20 cm"]"#, r#"upper = ["16 cm", "5 cm"]"#),
        (r#"point = ["60 cm", 0]"#, r#"point = ["16 cm", 0]"#),
        (r#"surface = "20 cm""#, r#"surface = "5 cm""#),
        (r#"lower = ["27.5 cm", "20 cm"]"#, r#"lower = ["6.5 cm", "5 cm"]"#),
        (r#"upper = ["32.5 cm", "22 cm"]"#, r#"upper = ["9.5 cm", "7 cm"]"#),
        ("count = 10000", "count = 1500"),
        (r#"cache = "cache""#, &cache),
        (r#"end = "0.3 s""#, r#"end = "24 ms""#),
        (r#"series_interval = "2 ms""#, r#"series_interval = "1 ms""#),
        (r#"frame_interval = "10 ms""#, r#"frame_interval = "1 s""#),
    ];
    replaced(whole, &changes)
}

/// Bands leave both edges of the plate and are enriched on both sides of it up to the ground; mass and momentum are kept, and what then
/// bears the plate are grains.
#[test]
fn bands_on_both_sides_of_a_plate_are_enriched() {
    let ran = Ran::of(&small());
    let entered = ran.summary["enriched_at_time"].as_f64().expect("no band was found");
    let places = ran.rows_of("grains", "position");
    let sides = [6.5e-2, 9.5e-2].map(|edge| {
        let beyond = |place: &&Vec<f64>| if edge < 8e-2 { place[0] < edge } else { place[0] > edge };
        let ours: Vec<&Vec<f64>> = places.iter().filter(beyond).collect();
        let farthest = ours.iter().map(|place| (place[0] - edge).abs()).fold(0.0, f64::max);
        let highest = ours.iter().map(|place| place[1]).fold(0.0, f64::max);
        println!("{} grains beyond the edge at {edge} m, up to {farthest:.4} m, as high as {highest:.4} m", ours.len());
        assert!(farthest > 1.5e-2 && highest > 4.9e-2);
        ours.len() as f64
    });
    assert!((sides[0] / sides[1] - 1.0).abs() < 0.25, "{sides:?}");
    // Some 10,200 grains would fill the bed; its lower part stays a continuum.
    let points = ran.series("points");
    let (left, first) = (points[points.len() - 1], points[0]);
    println!("{} grains, {left} of {first} points", places.len());
    assert!((3000..8000).contains(&places.len()) && left > 0.3 * first, "{} grains, {left} points", places.len());

    let kept = &ran.summary["conservation"];
    assert!(kept["mass"]["error"].as_f64().unwrap().abs() < 1e-12, "{kept}");
    assert!(kept["momentum"]["error"].as_f64().unwrap() < 1e-10, "{kept}");

    // Over 3 cm by 1 cm. Grains bear some 2 kPa below a plate of 5 cm, where the continuum would take 4 to 6 (docs/validation/hybrid_experiments.md).
    let (time, force) = (ran.series("time"), ran.series("plate_force_y"));
    let after = time.iter().zip(&force).filter(|(time, _)| **time > entered + 4e-3).map(|(_, force)| *force / 3e-4);
    let stresses: Vec<f64> = after.collect();
    let mean = stresses.iter().sum::<f64>() / stresses.len() as f64;
    println!("enriched after {:.1} ms, {mean:.0} Pa on the plate afterwards", 1e3 * entered);
    assert!((1.2e3..2.6e3).contains(&mean), "{mean} Pa: {stresses:?}");

    // Here, since both share a specimen that takes minutes.
    grains_alone_bear_the_plate();
}

/// The plate comes on faster than any grain at rest moves, in cycles of 20 steps: that was not foreseen, and the run stopped itself over
/// lists that were too old. What grains give to bodies is booked: it bears the plate, and momentum is kept.
fn grains_alone_bear_the_plate() {
    let alone = [("method = \"hybrid\"\nseed", "method = \"dem\"\nseed"), ("end = \"24 ms\"", "end = \"14 ms\"")];
    let ran = Ran::of(&replaced(small(), &alone));
    let force = ran.series("plate_force_y");
    assert!(force.iter().copied().fold(0.0, f64::max) > 0.05, "{force:?}");
    let kept = &ran.summary["conservation"];
    assert!(kept["momentum"]["error"].as_f64().unwrap() < 1e-10, "{kept}");
}
