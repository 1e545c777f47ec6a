//! Hybrids whose grains are no specimen: `jobs/large` in small.

use crate::runs::{Ran, replaced};

/// A specimen of 24 by 30 cm: 77,000 grains if it were discrete.
fn triaxial() -> String {
    let whole = std::fs::read_to_string("jobs/large/triaxial.toml").unwrap();
    let (head, tail) = whole.split_once("[[band]]").unwrap();
    let (_, tail) = tail.split_once("[grains]").unwrap();
    let whole = format!("{head}[[band]]\nfrom = [0.12, 0.01]\nto = [0.36, 0.29]\n\n[grains]{tail}");
    let cache = format!("cache = \"{}\"", std::env::temp_dir().join("scree_test_packings").display());
    let changes = [
        (r#"upper = ["7.2 m", "12.24 m"]"#, r#"upper = ["48 cm", "36 cm"]"#),
        (r#"lower = ["0.6 m", 0]"#, r#"lower = ["12 cm", 0]"#),
        (r#"upper = ["6.6 m", "12 m"]"#, r#"upper = ["36 cm", "30 cm"]"#),
        (r#"point = [0, "12 m"]"#, r#"point = [0, "30 cm"]"#),
        (r#"from = ["0.6 m", "12 m"]"#, r#"from = ["12 cm", "30 cm"]"#),
        (r#"to = ["0.6 m", 0]"#, r#"to = ["12 cm", 0]"#),
        (r#"from = ["6.6 m", 0]"#, r#"from = ["36 cm", 0]"#),
        (r#"to = ["6.6 m", "12 m"]"#, r#"to = ["36 cm", "30 cm"]"#),
        ("count = 10000", "count = 1500"),
        (r#"cache = "../cache""#, &cache),
        (r#"end = "10 s""#, r#"end = "0.4 ms""#),
        (r#"series_interval = "10 ms""#, r#"series_interval = "0.02 ms""#),
    ];
    replaced(whole, &changes)
}

/// Pieces of packing side by side, cut at membranes and plates: they bear at once what the points bore whose places they take, and the
/// specimen goes on bearing it.
#[test]
fn grains_of_a_known_band_come_from_pieces_of_packing() {
    let ran = Ran::of(&triaxial());
    let figure = |name: &str| ran.summary[name].as_f64().unwrap_or_else(|| panic!("no {name}"));
    for part in ["lateral", "normal"] {
        let [points, grains] = ["points", "grains"].map(|of| figure(&format!("training_{part}_stress_{of}")));
        println!("{part}: {points:.0} Pa of points, {grains:.0} Pa of grains");
        assert!((grains / points - 1.0).abs() < 0.02, "{part}: {grains} for {points}");
    }
    let kept = &ran.summary["conservation"];
    assert!(kept["mass"]["error"].as_f64().unwrap().abs() < 1e-12, "{kept}");
    assert!(kept["momentum"]["error"].as_f64().unwrap() < 1e-10, "{kept}");

    // Within 1.25 cm and half a cell of a line of nodes one cell wide, 37 cm long: some 4.5 cells, and steps at their edges.
    let grains = ran.rows_of("grains", "position");
    let along = |place: &Vec<f64>| ((place[0] - 0.12) * 0.28 - (place[1] - 0.01) * 0.24).abs() / 0.3688;
    let farthest = grains.iter().map(along).fold(0.0, f64::max);
    println!("{} grains, up to {:.1} mm from the band", grains.len(), 1e3 * farthest);
    assert!((12_000..18_000).contains(&grains.len()) && farthest < 0.028, "{} grains", grains.len());
    let pushed = grains.iter().filter(|place| place[0] < 0.1175 || place[0] > 0.3625 || place[1] < 0.0).count();
    assert_eq!(pushed, 0, "grains beyond membranes and base");

    for name in ["stress_xx", "stress_yy"] {
        let stress = ran.series(name);
        let worst = stress.iter().map(|stress| (stress / -100e3 - 1.0).abs()).fold(0.0, f64::max);
        println!("{name}: {:.0} Pa at the end, {:.2} % off at most", stress[stress.len() - 1], 100.0 * worst);
        assert!(worst < 0.03, "{name}: {stress:?}");
    }
}
