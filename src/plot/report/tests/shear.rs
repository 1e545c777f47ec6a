//! Comparisons of made-up runs whose differences are known.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::made_up::{DIPPED, Made, ROW, SPACING};
use crate::plot::report::{strains, write};

/// Writes runs and the comparison of them; its figures and its page.
fn compared(folder: &Path, made: &[Made], between: Option<[f64; 2]>) -> (Value, String) {
    let named = |(index, made): (usize, &Made)| -> PathBuf {
        let directory = folder.join(format!("{}_{index}", made.method));
        made.write(&directory);
        directory
    };
    let directories: Vec<PathBuf> = made.iter().enumerate().map(named).collect();
    let page = write(&directories, Some(&folder.join("page.html")), between).unwrap();
    let json = fs::read_to_string(folder.join("comparison.json")).unwrap();
    (serde_json::from_str(&json).unwrap(), fs::read_to_string(page).unwrap())
}

fn near(value: &Value, wanted: f64, within: f64) {
    let number = value.as_f64().unwrap_or(f64::NAN);
    assert!((number - wanted).abs() <= within, "{value} instead of {wanted}");
}

fn left_out(json: &Value, part: &str) -> String {
    json["left_out"][part].to_string()
}

/// Four runs of one packing: the hybrid's stress is 5 % above that of the grains, its grains' 10 % above.
fn one_packing() -> [Made<'static>; 4] {
    [
        Made { wall: 3.0, ..Made::of("dem") },
        Made { stress: 1.05, stress_grains: 2.2e6, wall: 1.5, ..Made::of("hybrid") },
        Made { stress: 0.5, stress_grains: 1e5, training: 0.0, ..Made::of("hybrid") },
        Made { stress: 0.9, wall: 1.0, ..Made::of("mpm") },
    ]
}

#[test]
fn differences_of_stress_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let (json, html) = compared(folder.path(), &one_packing(), None);
    let differences = json["shear_stress"]["differences"].as_array().unwrap();
    assert_eq!(differences.len(), 3);
    for (difference, wanted) in differences.iter().zip([0.05, -0.5, -0.1]) {
        // The enrichment cuts the moving average of the hybrid alone: near it the two are not alike to the last digit.
        near(&difference["mean_difference"], wanted, 1e-3);
        near(&difference["rms_difference"], f64::abs(wanted), 1e-3);
        near(&difference["from_strain"], 0.0505, 1e-9);
        near(&difference["to_strain"], 0.1, 1e-9);
    }
    assert_eq!(differences[0]["kind"], "packing");
    // 150 kPa (1 - exp(-strain/0.01)) only rises: the peak is the end.
    let dem = &json["softening"][0];
    near(&dem["peak_strain"], 0.1, 1e-9);
    near(&dem["residual_between_strains"][0], 0.1 * 37.0 / 57.0, 1e-9);
    near(&json["softening"][2]["peak_pa"], 75e3, 10.0);
    for words in ["Compared", "hybrid (training 100\u{2009}%)", "comparison.json", "Disturbance by the enrichment"] {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("NaN") && !html.contains("inf "));
    for name in ["shear_stress", "bands", "training", "inside"] {
        let drawing = fs::read_to_string(folder.path().join(format!("figures/{name}.svg"))).unwrap();
        let (drawing, _) = drawing.split_once("<!--").unwrap();
        assert!(html.contains(drawing), "{name}");
    }
}

#[test]
fn the_trained_packing_is_held_against_the_same_grains() {
    let folder = tempfile::tempdir().unwrap();
    let (json, html) = compared(folder.path(), &one_packing(), None);
    let trained = &json["training"][0];
    // 2 MPa times the strain of the enrichment, between the frames at 5 % and 6 %.
    near(&trained["shear_stress_region_pa"], 2e6 * 0.0505, 1.0);
    near(&trained["off"], 0.1, 1e-4);
    near(&trained["grains_in_common"], 1.0, 0.0);
    near(&trained["interpolated_between_strains"][1], 0.06, 1e-6);
    near(&json["training"][1]["off"], -0.95, 1e-4);
    assert!(html.contains("between 5\u{202f}% and 6\u{202f}%"));
}

/// All but the first and the last two rows of a dip are averaged over rows of the dip alone.
#[test]
fn a_dip_after_enrichment_and_a_fall_from_the_peak_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Made { fall: 0.2, ..Made::of("dem") };
    let (json, _) = compared(folder.path(), &[dem, Made { dip: 0.3, training: 0.25, ..Made::of("hybrid") }], None);
    let disturbance = &json["disturbance"][0];
    near(&disturbance["training"], 0.25, 0.0);
    // Five rows are averaged; ten from 5.05 % on are low, and four of five must be back for 90 %.
    near(&disturbance["rows_averaged"], 5.0, 0.0);
    near(&disturbance["drop"], -0.3, 2e-3);
    near(&disturbance["strain_until_recovered"], DIPPED + ROW, 1e-9);
    // 0.2 of it are lost linearly from 5 to 10 %, so 13 % in the mean of the last 35 %; the peak is smoothed.
    near(&json["softening"][0]["peak_strain"], 0.05, 3.0 * ROW);
    near(&json["softening"][0]["softening"], 0.124, 4e-3);
}

#[test]
fn bands_are_measured_in_several_ways() {
    let folder = tempfile::tempdir().unwrap();
    let wide = Made { seed: 2, band: 3e-3, ..Made::of("dem") };
    let mut runs = one_packing().to_vec();
    runs.push(wide);
    let (json, html) = compared(folder.path(), &runs, Some([0.06, 0.1]));
    let runs = json["bands"]["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 5);
    for run in runs {
        near(&run["between_strains"][0], 0.06, 1e-6);
        near(&run["between_strains"][1], 0.1, 1e-6);
        assert_eq!(run["pieces"].as_array().unwrap().len(), 3);
    }
    // The same strain everywhere gives the same band, whatever it is made of.
    let thickness = |index: usize, key: &str| runs[index][key].as_f64().unwrap();
    assert_eq!(thickness(0, "thickness_d50"), thickness(1, "thickness_d50"));
    // 1/(1 + (y/b)^2) falls to a half at b: 3 D50 in all, and 6; the fit over neighbours widens it.
    assert!((3.0..=5.0).contains(&thickness(0, "width_at_half_d50")), "{}", thickness(0, "width_at_half_d50"));
    assert!((6.0..=8.0).contains(&thickness(4, "width_at_half_d50")), "{}", thickness(4, "width_at_half_d50"));
    assert_eq!(thickness(3, "width_at_half_cells"), 0.5 * thickness(3, "width_at_half_d50"));
    let grains = &json["bands"]["groups"][0];
    assert_eq!(grains["packings"], 2);
    let (thin, wide) = (thickness(0, "thickness_d50"), thickness(4, "thickness_d50"));
    near(&grains["most_d50"], thin.max(wide), 0.0);
    near(&grains["least_d50"], thin.min(wide), 0.0);
    near(&grains["mean_d50"], 0.5 * (thin + wide), 1e-12);
    assert!(html.contains("2 packings"));
}

/// Where the middle of the width moves most, a larger share of the material makes a thicker band, and so does the threshold of
/// grains alone that shear less in a wider one.
#[test]
fn shares_and_thresholds_make_the_thickness() {
    let folder = tempfile::tempdir().unwrap();
    let mpm = Made { band: 8e-3, bulge: 0.3, ..Made::of("mpm") };
    let dem = Made { band: 12e-3, bulge: 0.3, ..Made::of("dem") };
    let (json, _) = compared(folder.path(), &[dem, mpm], Some([0.06, 0.1]));
    let run = &json["bands"]["runs"][1];
    let thickness = |key: &str| run[key]["thickness_d50"].as_f64().unwrap();
    assert!(thickness("box_97th") > thickness("box_98th"), "{run}");
    assert!(thickness("box_98th") > thickness("box_99th"), "{run}");
    assert!(thickness("box_dem_threshold") > thickness("box_98th") + 2.0, "{run}");
}

#[test]
fn strain_inside_the_zone_and_speed_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let (json, _) = compared(folder.path(), &one_packing(), None);
    let inside = &json["inside_the_zone"][0];
    near(&inside["difference"]["mean_difference"], 0.05, 1e-3);
    // Inner grains only, rows in their middles.
    near(&inside["heights_m"][0], 14.5 * SPACING, 1e-9);
    near(&inside["heights_m"][1], 25.5 * SPACING, 1e-9);
    let speed = &json["speed_up"][0];
    near(&speed["whole_run"], 2.0, 1e-9);
    near(&speed["after_enrichment"], (0.9 * 3.0 / 0.1) / (0.4 * 1.5 / 0.0495), 1e-6);
    let formula = &speed["formula"];
    near(&formula["n_d"], 4.0, 1e-9);
    near(&formula["zone_share"], 320.0 / 760.0, 1e-12);
    // Of two cores each.
    near(&formula["c_d_s"], 2.0 * 0.9 * 3.0 / 800e3, 1e-15);
    near(&formula["c_c_s"], 2.0 * 0.9 * 1.0 / 200e3, 1e-15);
    near(&formula["speed_up"], 1.0 / (8.0 / 19.0 + 11.0 / 19.0 / 3.0), 1e-9);
    // Couple over steps alone: without output, which is a tenth of the time, and training, which is another.
    near(&speed["coupling_share"], 0.08 / 0.8, 1e-12);
}

/// Where the grains alone shear most is found, and how they bear it there.
#[test]
fn a_band_elsewhere_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Made { band_at: 28.0 * SPACING, fall: 0.5, ..Made::of("dem") };
    let (json, _) = compared(folder.path(), &[dem, Made { fall: 0.5, ..Made::of("hybrid") }], None);
    let inside = &json["inside_the_zone"][0];
    near(&inside["heights_sheared_most_m"][0], (28.0 - 5.5) * SPACING, 1.5 * SPACING);
    near(&inside["difference_sheared_most"]["mean_difference"], 0.0, 0.02);
    // The same material shears little, and the stress of the grains alone has fallen far by then.
    let same = inside["difference"]["mean_difference"].as_f64().unwrap();
    assert!(same > 0.1, "{inside}");
}

/// Rows of the hybrid lie twice as far apart: eight of them average a swing away, and so must sixteen of the other's.
#[test]
fn strain_inside_the_zone_is_compared_by_averages_over_equal_times() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Made { swing: 0.2, ..Made::of("dem") };
    let (json, _) = compared(folder.path(), &[dem, Made { rows_apart: 2, swing: 0.2, ..Made::of("hybrid") }], None);
    near(&json["inside_the_zone"][0]["difference"]["rms_difference"], 0.0, 0.02);
}

/// The continuum is advanced once in four steps of the hybrid; costs are those of a core, and of one step of grains.
#[test]
fn costs_are_those_of_a_core_and_of_a_step_of_grains() {
    let dem = Made { wall: 3.0, ..Made::of("dem") };
    let hybrid = Made { wall: 1.5, grain_steps: 4, ..Made::of("hybrid") };
    let cost = |more: &[Made]| {
        let folder = tempfile::tempdir().unwrap();
        let (json, _) = compared(folder.path(), &[&[dem, hybrid], more].concat(), None);
        let formula = json["speed_up"][0]["formula"].clone();
        near(&formula["c_d_s"], 2.0 * 0.9 * 3.0 / 800e3, 1e-15);
        let ratio = formula["c_c_s"].as_f64().unwrap() / (4.0 * formula["c_d_s"].as_f64().unwrap());
        near(&formula["speed_up"], 1.0 / (8.0 / 19.0 + 11.0 / 19.0 * ratio), 1e-9);
        formula["c_c_s"].clone()
    };
    // A thousand steps, by 200 elements.
    let once = |wall: f64, cores: f64, advances: f64| wall * cores / advances / 200.0;
    let mpm = Made { wall: 1.0, ..Made::of("mpm") };
    near(&cost(&[Made { ranks: 3, ..mpm }]), once(0.9, 3.0, 1000.0) / 4.0, 1e-15);
    near(&cost(&[Made { grain_steps: 2, ..mpm }]), once(0.9, 2.0, 500.0) / 4.0, 1e-15);
    near(&cost(&[]), once(0.2 * 1.5, 2.0, 250.0) / 4.0, 1e-15);
}

/// A hybrid that begins as grains is timed from its first points on, and nothing is missed of an enrichment.
#[test]
fn what_begins_as_grains_is_as_fast_as_its_steps_with_points() {
    let told = |resumed: i32| {
        let made = [Made::of("dem"), Made { everywhere: true, resumed, ..Made::of("hybrid") }];
        let folder = tempfile::tempdir().unwrap();
        compared(folder.path(), &made, None).0
    };
    let (json, dem) = (told(0), 0.9 * 1.5 / 0.1);
    near(&json["speed_up"][0]["after_enrichment"], dem / (0.5 * 1.5 / 0.0495), 1e-6);
    near(&json["speed_up"][0]["whole_run"], 1.0, 1e-9);
    for figure in ["disturbance", "training", "inside_the_zone"] {
        assert_eq!(left_out(&json, figure), "[]", "{figure}");
    }
    // Resumed right there: none of the stretch was before.
    near(&told(505)["speed_up"][0]["after_enrichment"], dem / (0.9 * 1.5 / 0.0495), 1e-6);
}

/// What a resumed run says of time is of its last stretch: no whole runs are compared, and an enrichment counts where it is in
/// that.
#[test]
fn resumed_runs_are_compared_by_their_last_stretch() {
    let told = |resumed: [i32; 3]| {
        let made = ["dem", "hybrid", "mpm"].map(Made::of);
        let made: Vec<Made> = made.iter().zip(resumed).map(|(made, resumed)| Made { resumed, ..*made }).collect();
        let folder = tempfile::tempdir().unwrap();
        let (json, _) = compared(folder.path(), &made, None);
        (json["speed_up"][0].clone(), left_out(&json, "speed_up"))
    };
    let dem = 0.9 * 1.5 / 0.1;
    let (speed, why) = told([0, 0, 0]);
    near(&speed["whole_run"], 1.0, 1e-9);
    assert_eq!(why, "[]");
    // Before its enrichment at 0.0505 s of 0.1 s: half of the time of its stretch is after it.
    let (speed, why) = told([0, 200, 0]);
    assert!(speed["whole_run"].is_null() && why.contains("hybrid>") && why.contains("was resumed"), "{speed} {why}");
    near(&speed["after_enrichment"], dem / (0.4 * 1.5 / 0.0495), 1e-6);
    near(&speed["coupling_share"], 0.08 / 0.8, 1e-12);
    // After it: all of the stretch counts, and no training is taken off.
    let (speed, _) = told([0, 600, 0]);
    near(&speed["after_enrichment"], dem / (0.9 * 1.5 / 0.04), 1e-6);
    near(&speed["coupling_share"], 0.08 / 0.9, 1e-12);
    let (speed, why) = told([500, 0, 0]);
    assert!(speed["whole_run"].is_null() && why.contains("dem>"), "{speed} {why}");
    let (speed, why) = told([0, 0, 500]);
    near(&speed["whole_run"], 1.0, 1e-9);
    assert!(why.contains("mpm>") && why.contains("was resumed"), "{why}");
}

#[test]
fn packings_have_a_spread_and_windows_are_of_equal_time() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Made::of("dem");
    let hybrid = Made { stress: 1.1, rows_apart: 2, ..Made::of("hybrid") };
    let runs = [dem, Made { seed: 2, stress: 1.2, ..dem }, hybrid, Made { seed: 2, stress: 1.3, ..hybrid }];
    let (json, html) = compared(folder.path(), &runs, None);
    // Eight rows of the run whose rows are farther apart.
    near(&json["shear_stress"]["window_s"], 8.0 * 1e-3, 1e-9);
    let of = |kind: &str| -> Vec<f64> {
        let differences = json["shear_stress"]["differences"].as_array().unwrap();
        let of_kind = differences.iter().filter(|difference| difference["kind"] == kind);
        of_kind.map(|difference| difference["mean_difference"].as_f64().unwrap()).collect()
    };
    let told = [of("packing"), of("means"), of("spread")].concat();
    for (found, wanted) in told.iter().zip([0.1, 1.3 / 1.2 - 1.0, 1.2 / 1.1 - 1.0, 1.0 / 1.2 - 1.0]) {
        assert!((found - wanted).abs() < 2e-3, "{found} instead of {wanted}");
    }
    assert_eq!(told.len(), 4);
    assert!(html.contains("fill-opacity") && html.contains("2 packings"));
}

#[test]
fn what_cannot_be_compared_is_left_out_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    // A hybrid of another packing, and a run that ends before the enrichment.
    let (json, html) =
        compared(folder.path(), &[Made { frames: 4, ..Made::of("dem") }, Made { seed: 7, ..Made::of("hybrid") }], None);
    assert!(left_out(&json, "shear_stress").contains("none of this specimen with seed 7 is given"), "{json}");
    assert!(left_out(&json, "bands").contains("the last enrichment is at 5"), "{json}");
    for part in ["training", "inside_the_zone"] {
        assert!(left_out(&json, part).contains("grains alone"), "{part}: {json}");
    }
    assert!(html.contains("class=\"left-out\""));
    // Only grains alone: their spread is all that there is.
    let folder = tempfile::tempdir().unwrap();
    let (json, _) = compared(folder.path(), &[Made::of("dem"), Made { seed: 2, ..Made::of("dem") }], None);
    assert_eq!(json["shear_stress"]["differences"][0]["kind"], "spread");
    assert!(json["training"].is_null() && json["speed_up"].is_null());
    // One run is not compared.
    let alone = folder.path().join("alone");
    Made::of("hybrid").write(&alone);
    let page = fs::read_to_string(write(std::slice::from_ref(&alone), None, None).unwrap()).unwrap();
    assert!(!alone.join("comparison.json").exists() && !page.contains("Compared"));
}

#[test]
fn an_interval_beyond_the_runs_is_refused_by_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let (json, _) = compared(folder.path(), &one_packing(), Some([0.37, 0.57]));
    assert!(left_out(&json, "bands").contains("the longest run ends at 10"), "{json}");
    // A run that does not reach it is left out by itself.
    let folder = tempfile::tempdir().unwrap();
    let short = Made { frames: 8, seed: 2, ..Made::of("dem") };
    let (json, _) = compared(folder.path(), &[Made::of("dem"), Made::of("mpm"), short], Some([0.05, 0.1]));
    assert_eq!(json["bands"]["runs"].as_array().unwrap().len(), 2);
    assert!(left_out(&json, "bands").contains("or ends before"), "{json}");
    assert_eq!(strains("0.37,0.57"), Ok([0.37, 0.57]));
    for wrong in ["0.5", "0.5,0.3", "a,b", "-0.1,0.2", "0.1,inf"] {
        assert!(strains(wrong).is_err(), "{wrong}");
    }
}
