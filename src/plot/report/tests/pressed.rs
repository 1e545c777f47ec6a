//! Comparisons of made-up runs whose differences are known: blocks of a column slide past each other along one straight band
//! that swells.

use std::fs;
use std::path::{Path, PathBuf};

use scree_io::series::Series;
use scree_io::{Frame, FrameFile};
use serde_json::Value;

use super::made_up::{Row, SPACING, frame_of};
use crate::base::error::Error;
use crate::base::math;
use crate::plot::report::write;

/// Bodies along either axis.
const BODIES: [i64; 2] = [40, 60];
const DEPTH: f64 = 0.01;
/// Strain at which points become grains near the band, and how far from its axis, m.
const ENRICHED: f64 = 0.02;
const ZONE: f64 = 0.012;
/// Strain of the last row.
const END: f64 = 0.1;

/// What a made-up run differs in from others.
#[derive(Clone, Copy, Debug)]
struct Made<'a> {
    method: &'a str,
    seed: i64,
    /// Stress on the plate from the first row on, Pa.
    stress: f64,
    /// What is added to it from a strain of 0.06 on, Pa.
    later: f64,
    /// Thickness of the band, m, its slope, degrees, and its volume strain at a strain of one.
    band: f64,
    slope: f64,
    swelling: f64,
    /// Volume strain of the whole at a strain of one; none without membranes.
    volume: Option<f64>,
    density: f64,
    /// The plate is a box so broad, m.
    breadth: Option<f64>,
    is_moving: bool,
    turns_back: bool,
}

impl<'a> Made<'a> {
    fn of(method: &'a str) -> Self {
        Self {
            method,
            seed: 1,
            stress: 200e3,
            later: 0.0,
            band: 8e-3,
            slope: 40.0,
            swelling: 0.5,
            volume: Some(-0.2),
            density: 2530.0,
            breadth: None,
            is_moving: true,
            turns_back: false,
        }
    }

    /// Distance from the band's axis, m, and displacement at a strain.
    fn moved(&self, [x, y]: [f64; 2], strain: f64) -> (f64, [f64; 2]) {
        let angle = self.slope * math::PI / 180.0;
        let along = [math::cos(angle), math::sin(angle)];
        let middle = BODIES.map(|count| 0.5 * count as f64 * SPACING);
        let off = (y - middle[1]) * along[0] - (x - middle[0]) * along[1];
        let share = (off / self.band + 0.5).clamp(0.0, 1.0);
        let [slide, open] = [-0.05 * strain, self.swelling * self.band * strain].map(|way| way * share);
        (off, [slide * along[0] - open * along[1], slide * along[1] + open * along[0]])
    }

    fn frame(&self, strain: f64) -> Frame {
        let body = |id: i64| {
            let [x, y] = [id % BODIES[0], id / BODIES[0]].map(|at| (at as f64 + 0.5) * SPACING);
            let (off, displacement) = self.moved([x, y], strain);
            let is_grain = match self.method {
                "dem" => true,
                "hybrid" => strain >= ENRICHED && off.abs() < ZONE,
                _ => false,
            };
            let position = [x + displacement[0], y + displacement[1]];
            let stress = [-1e5; 3];
            Row { kind: i64::from(is_grain), id, position, displacement, weight: 1.0, stress, deviatoric: strain }
        };
        // A vertex of a membrane, far outside and with the id of a grain.
        let vertex = Row { kind: 3, id: 7, position: [-0.7, 0.0], displacement: [0.3, 0.0], ..Row::default() };
        frame_of(strain, &(0..BODIES[0] * BODIES[1]).map(body).chain([vertex]).collect::<Vec<_>>())
    }

    fn scenario(&self) -> String {
        let Self { method, seed, density, .. } = *self;
        let [breadth, height] = BODIES.map(|count| count as f64 * SPACING);
        let shape = match self.breadth {
            None => format!("shape = \"plane\"\npoint = [0.0, {height}]\nnormal = [0.0, -1.0]\n"),
            Some(own) => format!("shape = \"box\"\nlower = [0.0, {height}]\nupper = [{own}, 1.0]\n"),
        };
        let path = "path = [{time = 0.0, velocity = [0.0, 0.0]}, {time = 1e-3, velocity = [0.0, -0.06]}]\n";
        format!(
            "name = \"press <{method}>\"\nmethod = \"{method}\"\nseed = {seed}\n[grid]\nspace = \"plane\"\nlower = [0.0, 0.0]\n\
             upper = [0.1, 0.1]\ncell = 4e-3\ndepth = {DEPTH}\n[material]\nlaw = \"critical_drucker_prager\"\n[grains]\n\
             density = {density:?}\ndiameter_mean = {SPACING}\n[enrichment]\ntraining = 1.0\ndistance = {ZONE}\n[[region]]\n\
             shape = \"box\"\nlower = [0.0, 0.0]\nupper = [{breadth}, {height}]\n[[body]]\nname = \"plate\"\n{shape}{}",
            if self.is_moving { path } else { "" }
        )
    }

    fn write(&self, directory: &Path) {
        fs::create_dir_all(directory).unwrap();
        fs::write(directory.join("scenario.toml"), self.scenario()).unwrap();
        let enriched = format!("{{\"outcome\": \"done\", \"enriched_at_time\": {ENRICHED}}}");
        let summary = if self.method == "hybrid" { enriched.as_str() } else { "{\"outcome\": \"done\"}" };
        fs::write(directory.join("summary.json"), summary).unwrap();
        let mut frames =
            FrameFile::create(&directory.join("frames.vtkhdf"), directory, &self.frame(0.0), 0, &[], &[]).unwrap();
        (1..=10).for_each(|frame| frames.append(&self.frame(0.01 * f64::from(frame))).unwrap());

        let mut header = "step,time,grains,points,volume,centre_x,centre_y,lower_x,upper_x,lower_y,upper_y,stress_xx,stress_yy,\
                          stress_xy,kinetic_grains,elastic_grains,kinetic_points,elastic_points,plate_force_x,plate_force_y,\
                          plate_displacement_x,plate_displacement_y"
            .split(',')
            .collect::<Vec<_>>();
        if self.volume.is_some() {
            header.push("enclosed_volume");
        }
        let mut series = Series::create(&directory.join("series.csv"), &header).unwrap();
        let [breadth, height] = BODIES.map(|count| count as f64 * SPACING);
        let (area, length) = self.breadth.map_or((breadth * DEPTH, height), |own| (own * DEPTH, own));
        for row in 1..=100 {
            let strain = END * f64::from(row) / 100.0;
            let grains = match self.method {
                "dem" => 2400.0,
                "hybrid" if strain >= ENRICHED => 900.0,
                _ => 0.0,
            };
            let force = (self.stress + if strain > 0.06 { self.later } else { 0.0 }) * area;
            let way = if self.turns_back { strain.min(END - strain) } else { strain };
            let mut of = vec![f64::from(row), strain, grains, 2400.0 - grains, 1.0, 0.02, 0.03, 0.0, 0.04, 0.0, 0.06];
            of.extend([-1e5, -2e5, 0.0, 1e-6, 1e-3, 1e-6, 1e-2, 0.0, force, 0.0, -way * length]);
            of.extend(self.volume.map(|swelling| 1e-5 * (1.0 + swelling * (strain - 0.01 * END))));
            series.push(&of).unwrap();
        }
    }
}

fn directories(folder: &Path, made: &[Made]) -> Vec<PathBuf> {
    let write = |(index, made): (usize, &Made)| {
        let directory = folder.join(format!("{}_{index}", made.method));
        made.write(&directory);
        directory
    };
    made.iter().enumerate().map(write).collect()
}

/// Writes runs and the comparison of them; its figures and its page.
fn compared(folder: &Path, made: &[Made], between: Option<[f64; 2]>) -> (Value, String) {
    let page = write(&directories(folder, made), Some(&folder.join("page.html")), between).unwrap();
    let json = fs::read_to_string(folder.join("comparison.json")).unwrap();
    (serde_json::from_str(&json).unwrap(), fs::read_to_string(page).unwrap())
}

fn refused(made: &[Made]) -> String {
    let folder = tempfile::tempdir().unwrap();
    match write(&directories(folder.path(), made), None, Some([0.0, 0.08])) {
        Err(Error::User(message)) => message,
        other => panic!("{other:?}"),
    }
}

fn near(value: &Value, wanted: f64, within: f64) {
    let number = value.as_f64().unwrap_or(f64::NAN);
    assert!((number - wanted).abs() <= within, "{value} instead of {wanted}");
}

#[test]
fn stress_is_held_against_grains_alone_of_the_same_packing_or_else_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Made { later: 20e3, ..Made::of("dem") };
    let made = [
        dem,
        Made { seed: 2, stress: 180e3, later: 0.0, ..dem },
        Made { stress: 210e3, later: 0.0, ..Made::of("hybrid") },
        Made { seed: 2, stress: 189e3, ..Made::of("hybrid") },
        Made { seed: 3, stress: 100e3, ..Made::of("mpm") },
    ];
    let (json, html) = compared(folder.path(), &made, Some([0.03, 0.05]));
    let differences = json["load_curve"]["differences"].as_array().unwrap();
    let told: Vec<&str> = differences.iter().map(|difference| difference["kind"].as_str().unwrap()).collect();
    assert_eq!(told, ["packing", "packing", "other_packing", "means", "spread"]);
    for (difference, wanted) in differences.iter().zip([0.05, 0.05, -0.5, 0.05, 200.0 / 180.0 - 1.0]) {
        near(&difference["mean_difference"], wanted, 1e-9);
        near(&difference["rms_difference"], f64::abs(wanted), 1e-9);
        near(&difference["from_strain"], 0.03, 1e-9);
        near(&difference["to_strain"], 0.05, 1e-9);
    }
    near(&json["load_curve"]["window_s"], 8e-3, 1e-12);
    near(&json["load_curve"]["peaks"][0]["peak_pa"], 220e3, 1e-6);
    near(&json["load_curve"]["metres_of_strain_one"], 0.06, 1e-15);
    near(&json["runs"][2]["enriched_at_strain"], ENRICHED, 1e-12);
    for words in [
        "Compared",
        "Stress on plate from 3\u{2009}% to 5\u{2009}% of axial strain: ",
        "axial strain (%)",
        "Run by run",
        "hybrid_2",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("NaN") && !html.contains("inf "));
    for name in ["load", "bands", "volume", "volume_of_bands", "specimen"] {
        let drawing = fs::read_to_string(folder.path().join(format!("figures/{name}.svg"))).unwrap();
        let (drawing, _) = drawing.split_once("<!--").unwrap();
        assert!(html.contains(drawing), "{name}");
    }
    // Without an interval from the enrichment on, of grains alone too: 40 of 81 rows, but for averages, are 9 % higher.
    let folder = tempfile::tempdir().unwrap();
    let (json, _) = compared(folder.path(), &[dem, Made::of("hybrid")], None);
    let difference = &json["load_curve"]["differences"][0];
    near(&difference["from_strain"], ENRICHED, 1e-9);
    near(&difference["mean_difference"], -10.0 / 210.0, 2e-3);
}

#[test]
fn a_band_has_its_thickness_slope_and_volume_strain_whatever_it_is_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let made = [Made::of("dem"), Made::of("hybrid"), Made { band: 5e-3, slope: -50.0, ..Made::of("mpm") }];
    let (json, html) = compared(folder.path(), &made, Some([0.04, 0.08]));
    let runs = json["bands"]["runs"].as_array().unwrap();
    for (run, (thickness, slope)) in runs.iter().zip([(8.0, 40.0), (8.0, 40.0), (5.0, -50.0)]) {
        near(&run["between_strains"][0], 0.04, 1e-9);
        near(&run["between_strains"][1], 0.08, 1e-9);
        // The fit over neighbours and the mean over two diameters widen an edge that is sharp.
        near(&run["thickness_d50"], thickness + 0.5, 1.2);
        near(&run["slope_deg"], slope, 2.0);
        // Strips begin at every fifth diameter.
        near(&run["centre_m"][0], 0.02, 4e-3);
        assert!(run["share_of_strain"].as_f64().unwrap() > 0.5, "{run}");
        assert_eq!(run["pieces"].as_array().unwrap().len(), 3);
    }
    assert!(runs[0]["thickness_cells"].is_null());
    near(&runs[1]["thickness_cells"], 0.25 * runs[1]["thickness_d50"].as_f64().unwrap(), 1e-12);
    // What swells is a little narrower than what is found; points have no volume but their own, which stays.
    for run in &runs[..2] {
        near(&run["volume_strain"], 0.5 * 0.04, 5e-3);
        near(&run["packing_fraction_end"], math::PI / 4.0 / 1.04, 0.02);
    }
    near(&runs[2]["volume_strain"], 0.0, 1e-12);
    near(&json["volume"][0]["volume_strain"][1], -0.2 * 0.079, 1e-9);
    near(&json["volume"][0]["band_since_strain"], ENRICHED, 1e-9);
    near(&json["volume"][0]["volume_strain_band"][1], 0.5 * 0.06, 6e-3);
    assert!(html.contains("volume strain (%)") && html.contains("(a) of the band") && html.contains("(b) of the zone"));
    assert_eq!(json["left_out"]["volume"].as_array().unwrap().len(), 0, "{json}");
}

#[test]
fn grains_of_a_zone_are_held_against_the_very_same_grains_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [dem, hybrid] = ["dem", "hybrid"].map(Made::of);
    let made = [dem, Made { swelling: 0.2, ..hybrid }, Made { seed: 2, ..hybrid }];
    let (json, html) = compared(folder.path(), &made, Some([0.04, 0.08]));
    let zone = &json["volume"][1];
    near(&zone["zone_since_strain"], ENRICHED, 1e-9);
    assert!(zone["zone_alone_in"].as_str().unwrap().contains("dem"), "{zone}");
    // The zone is three times as thick as the band that swells in its middle; its outermost grains share space with others where grains
    // are alone.
    near(&zone["volume_strain_zone"][1], 0.2 * 0.06 / 3.0, 1e-3);
    near(&zone["volume_strain_zone_alone"][1], 0.5 * 0.06 / 3.0, 2e-3);
    for other in [0, 2] {
        assert!(json["volume"][other]["volume_strain_zone"].is_null());
    }
    assert!(json["left_out"]["volume"].to_string().contains("no run of grains alone with its packing"), "{json}");
    assert!(html.contains("(b) of the zone"));
}

#[test]
fn a_box_presses_over_its_own_breadth_and_nothing_may_enclose_the_material() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Made { breadth: Some(0.01), volume: None, ..Made::of("dem") };
    let (json, html) = compared(folder.path(), &[dem, Made { method: "hybrid", stress: 180e3, ..dem }], None);
    near(&json["load_curve"]["metres_of_strain_one"], 0.01, 1e-15);
    near(&json["load_curve"]["peaks"][0]["peak_pa"], 200e3, 1e-6);
    near(&json["load_curve"]["differences"][0]["mean_difference"], -0.1, 1e-9);
    near(&json["runs"][0]["strain_end"], END, 1e-9);
    assert_eq!(json["runs"][0]["strain"], "displacement over breadth");
    assert!(json["left_out"]["volume"].to_string().contains("no membranes enclose it"), "{json}");
    assert!(html.contains("displacement over breadth (%)") && !folder.path().join("figures/volume.svg").exists());
    // By default the paper's share of what the runs have in common, to the nearest frames.
    near(&json["bands"]["between_strains"][0], 0.055 / 0.1061 * END, 1e-9);
    near(&json["bands"]["runs"][0]["between_strains"][1], 0.08, 1e-9);
}

#[test]
fn what_is_not_alike_is_refused_and_what_cannot_be_measured_is_left_out() {
    let dem = Made::of("dem");
    // Another specimen is drawn beside the first and not held against it.
    for (other, what) in [
        (Made { density: 2600.0, ..Made::of("hybrid") }, "`grains.density` is 2600.0 in it"),
        (Made { breadth: Some(0.01), ..Made::of("hybrid") }, "`body.plate."),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (json, _) = compared(folder.path(), &[dem, other], None);
        let why = json["left_out"]["load_curve"].to_string();
        assert!(what.contains("body") || why.contains("hybrid_1 is not held against") && why.contains(what), "{json}");
        assert!(!what.contains("body") || why.contains("against displacement over breadth"), "{json}");
    }
    let message = refused(&[dem, Made { turns_back: true, ..dem }]);
    assert!(message.contains("`plate` turns back on its way"), "{message}");

    // Where nobody asked for an interval the runs have a page all the same.
    let folder = tempfile::tempdir().unwrap();
    let (json, _) = compared(folder.path(), &[dem, Made { turns_back: true, ..dem }], None);
    assert!(json["left_out"]["load_curve"].to_string().contains("turns back on its way"), "{json}");

    let folder = tempfile::tempdir().unwrap();
    let still = Made { is_moving: false, ..dem };
    let (json, html) = compared(folder.path(), &[still, Made { seed: 2, ..still }], None);
    assert!(json["left_out"]["load_curve"].to_string().contains("moves along a path"), "{json}");
    assert!(html.contains("class=\"left-out\""));
    // No grains alone, and an interval that no run reaches.
    let folder = tempfile::tempdir().unwrap();
    let (json, _) = compared(folder.path(), &[Made::of("mpm"), Made::of("hybrid")], Some([0.05, 0.3]));
    assert!(json["left_out"]["load_curve"].to_string().contains("compared with nothing"), "{json}");
    assert!(json["left_out"]["bands"].to_string().contains("the longest run ends at 10"), "{json}");
    assert!(json["left_out"]["volume"].to_string().contains("none was measured"), "{json}");
    // One run is not compared.
    let folder = tempfile::tempdir().unwrap();
    let alone = directories(folder.path(), &[dem]);
    let page = fs::read_to_string(write(&alone, None, None).unwrap()).unwrap();
    assert!(!alone[0].join("comparison.json").exists() && !page.contains("Compared"));
}
