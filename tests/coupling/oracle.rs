//! The oracle of Chen et al. (2021), section 3: where a persistent shear band is, and where there is none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use scree::adapt::watch;
use scree::base::ids::PointId;
use scree::base::math;
use scree::base::space::Plane;
use scree::couple::oracle::{Concentration, Criterion, Laplacian, Memory, NodeFields, Oracle};
use scree::domain::world::World;
use scree::job::{Job, Scenario, derived};
use scree::mpm::stress::material_of;
use scree::mpm::track::LOOKS;
use scree::prepare::plates;
use scree::prepare::point_world;
use scree_partition::Solo;

use crate::worlds::{PlanarPoint, PlanarWorld, Random, job, mobilised};

/// What the oracle said over a run.
struct Story {
    /// Strain, strain clock and looks when it fired.
    fired: Option<(f64, f64, u64)>,
    /// Flagged nodes when it fired, or at the end.
    flagged: Vec<u64>,
    /// Rows of nodes that were ever flagged.
    rows_ever: BTreeSet<u64>,
    /// Largest plastic strain of any point at the end.
    plastic_max: f64,
    /// Shares of the points in the weak region, and of all others, that simpler oracles flag in the end: those that shear
    /// plastically at more than a quarter of the mean rate, and those that have sheared plastically by more than a quarter of the mean
    /// strain.
    by_rate: [f64; 2],
    by_strain: [f64; 2],
}

/// Of the points in the weak region and of all others, the share of those that `is_flagged`.
fn shares(points: &[(f64, f64)], is_flagged: impl Fn(f64) -> bool) -> [f64; 2] {
    [true, false].map(|weak| {
        let among = points.iter().filter(|(height, _)| (15e-3..21e-3).contains(height) == weak);
        among.clone().filter(|(_, value)| is_flagged(*value)).count() as f64 / among.count() as f64
    })
}

/// A continuum alone, watched to the end of the run or until the oracle of the job fires.
fn watched(sets: &[&str]) -> Story {
    story_of(&job(&[&["method=mpm"], sets].concat()))
}

/// The same by how shear concentrates, with the numbers that every job has.
fn watched_for_concentration(sets: &[&str]) -> Story {
    let mut scenario = job(&[&["method=mpm"], sets].concat());
    scenario.oracle.criterion = Criterion::Concentration(BOX);
    story_of(&scenario)
}

fn story_of(scenario: &Scenario) -> Story {
    let start = plates::prepare(scenario, &Solo).unwrap();
    let mut world = plates::world(scenario, &Solo, start).unwrap();
    let mut memory = Memory::default();
    let mut story = Story {
        fired: None,
        flagged: Vec::new(),
        rows_ever: BTreeSet::new(),
        plastic_max: 0.0,
        by_rate: [0.0; 2],
        by_strain: [0.0; 2],
    };
    let plate = |world: &PlanarWorld| world.bodies[1].displacement[0];
    let (mut before, mut plate_before) = (BTreeMap::new(), 0.0);
    while story.fired.is_none() && world.step < derived::steps(scenario) {
        world.advance().unwrap();
        if !world.step.is_multiple_of(scenario.oracle.every) {
            continue;
        }
        let diameter = scenario.grains.diameter_mean;
        if watch::watch(&mut world, &mut memory, &scenario.oracle, diameter).unwrap() {
            let strain = world.bodies[1].displacement[0] / scenario.specimen.width;
            story.fired = Some((strain, memory.clock, memory.looks));
        }
        story.rows_ever.extend(memory.flagged.iter().map(|node| row_of(scenario, *node)));
        let law = world.settings.material.clone();
        let strain = |point: &PlanarPoint| (point.hot.position[1], law.plastic_strain(&point.hot.memory));
        let more = |point: &PlanarPoint| {
            let (height, now) = strain(point);
            (height, now - before.get(&point.cold.id).copied().unwrap_or(0.0))
        };
        let sheared: Vec<(f64, f64)> = world.continuum.points.rows().map(|point| strain(&point)).collect();
        let shearing: Vec<(f64, f64)> = world.continuum.points.rows().map(|point| more(&point)).collect();
        // Norms of strains, of which simple shear has 1/sqrt(2).
        let even = |way: f64| 0.25 * 0.5f64.sqrt() * way / scenario.specimen.height;
        story.by_strain = shares(&sheared, |strain| strain > even(plate(&world)));
        story.by_rate = shares(&shearing, |strain| strain > even(plate(&world) - plate_before));
        before =
            world.continuum.points.rows().map(|point| (point.cold.id, law.plastic_strain(&point.hot.memory))).collect();
        plate_before = plate(&world);
    }
    story.flagged = memory.flagged;
    story.plastic_max = world
        .continuum
        .points
        .rows()
        .map(|point| world.settings.material.plastic_strain(&point.hot.memory))
        .fold(0.0, f64::max);
    story
}

fn row_of(scenario: &Scenario, node: u64) -> u64 {
    node / derived::cells_x(scenario) as u64
}

/// Rows of nodes between two heights above the lower face; the face lies on row 4, below it is the domain's margin.
fn rows_between(lower: f64, upper: f64) -> BTreeSet<u64> {
    let row = |y: f64| 4 + (y / 3e-3).round() as u64;
    (row(lower)..=row(upper)).collect()
}

const DENSE: &str = "material.fraction=0.85";
const LOOSE: &str = "material.fraction=0.79";
const CRITICAL: &str = "material.fraction_critical=0.815";

/// Chen et al. (2021), figure 5, first row: the weak region between 15 and 21 mm becomes the band, and nothing else is flagged.
#[test]
fn an_over_consolidated_specimen_shows_its_band() {
    let story = watched(&[DENSE, CRITICAL, "loading.strain_end=0.1"]);
    let (strain, ..) = story.fired.expect("the oracle stayed silent");
    assert!((0.015..0.04).contains(&strain), "it fired at strain {strain}");
    let rows: BTreeSet<u64> = story.flagged.iter().map(|node| node / 4).collect();
    assert!(!rows.is_empty() && rows.is_subset(&rows_between(15e-3, 21e-3)), "flagged rows {rows:?}");
    assert_eq!(story.flagged.len(), 4 * rows.len(), "a band across the period has all nodes of its rows");
    assert_eq!(story.rows_ever, rows, "nothing else was flagged on the way");
}

/// Figure 5, second row: a loose specimen hardens where it flows, so all of it flows. Strained much, the oracle silent, and no
/// row beside the plates flagged, which slow the flow there.
#[test]
fn an_under_consolidated_specimen_keeps_the_oracle_silent() {
    let even = ["material.dilation_factor=7", "continuum.weak.0.fraction_deficit=0"];
    let story = watched(&[&[LOOSE, CRITICAL, "loading.strain_end=0.1"], &even[..]].concat());
    assert_eq!(story.fired, None);
    // One, two cells below the upper plate, is flagged and let go; without averaging of volume strain there is none.
    assert!(story.rows_ever.is_subset(&rows_between(30e-3, 30e-3)), "{:?}", story.rows_ever);
    assert!(story.plastic_max > 0.02, "it should have flowed: {}", story.plastic_max);
}

/// Figure 4: where shear is localised, its rate and its sum show it as well; where all of a specimen flows, both flag all of it.
#[test]
fn rate_and_sum_of_strain_call_even_flow_a_band() {
    let dense = watched(&[DENSE, CRITICAL, "loading.strain_end=0.1"]);
    println!("dense: {:?}, {:?}", dense.by_rate, dense.by_strain);
    assert!(dense.fired.is_some() && dense.by_rate[0] > 0.9 && dense.by_strain[0] > 0.9);
    assert!(dense.by_rate[1] < 0.2 && dense.by_strain[1] < 0.2, "{:?}, {:?}", dense.by_rate, dense.by_strain);
    let even = ["material.dilation_factor=7", "continuum.weak.0.fraction_deficit=0"];
    let loose = watched(&[&[LOOSE, CRITICAL, "loading.strain_end=0.1"], &even[..]].concat());
    println!("loose: {:?}, {:?}", loose.by_rate, loose.by_strain);
    assert!(loose.fired.is_none() && loose.by_rate[1] > 0.8 && loose.by_strain[1] > 0.8);
}

/// What the oracle and simpler ones say of triaxial compression in a membrane.
struct TriaxialStory {
    /// Axial strain when the oracle fired, and where nodes were flagged then, m.
    strain: f64,
    band: Vec<[f64; 2]>,
    /// Shares of the points within a cell and a half of the line through these, and of all others, that are flagged by the time the
    /// plate has come 2 mm: by any look of the oracle after it fired, by rate, by sum.
    by_oracle: [f64; 2],
    by_rate: [f64; 2],
    by_strain: [f64; 2],
    /// Inclination of the line, degrees.
    inclination: f64,
}

fn triaxial() -> TriaxialStory {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/continuum/triaxial.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let Job::Mpm(job) = Job::parse(&text, "triaxial.toml", &[]).unwrap() else { panic!("it has no grid") };
    let law = material_of(&job.material.law);
    let watch = job.oracle.unwrap();
    let mut world = point_world::world::<Plane>(&job, &law, &Solo).unwrap();
    let (mut memory, height) = (Memory::default(), 0.0942);
    let way = |world: &World<Plane>| -world.bodies[0].displacement[1];
    while !(world.is_due(watch.oracle.every)
        && watch::watch(&mut world, &mut memory, &watch.oracle, watch.diameter).unwrap())
    {
        assert!(way(&world) < 0.02 * height, "the oracle stayed silent");
        world.advance().unwrap();
    }
    let strain = way(&world) / height;
    let band: Vec<[f64; 2]> = memory.flagged.iter().map(|node| watch::place_of_node(&world, *node)).collect();

    // The line of least squares through the band, by its moments.
    let count = band.len() as f64;
    let centre = [0, 1].map(|axis| band.iter().map(|place| place[axis]).sum::<f64>() / count);
    let moment = |i: usize, j: usize| band.iter().map(|at| (at[i] - centre[i]) * (at[j] - centre[j])).sum::<f64>();
    let angle = 0.5 * math::atan2(2.0 * moment(0, 1), moment(0, 0) - moment(1, 1));
    let normal = [-math::sin(angle), math::cos(angle)];
    let is_near = |place: [f64; 2]| {
        ((place[0] - centre[0]) * normal[0] + (place[1] - centre[1]) * normal[1]).abs() < 1.5 * job.grid.cell
    };

    // The last quarter of the way is what the rate is taken over.
    let plastic = |world: &World<Plane>| -> BTreeMap<PointId, f64> {
        world.continuum.points.rows().map(|point| (point.cold.id, law.plastic_strain(&point.hot.memory))).collect()
    };
    let (mut ever, mut before) = (BTreeSet::new(), None);
    while way(&world) < 2e-3 {
        world.advance().unwrap();
        if world.is_due(watch.oracle.every) {
            watch::watch(&mut world, &mut memory, &watch.oracle, watch.diameter).unwrap();
            ever.extend(memory.flagged.iter().copied());
        }
        if before.is_none() && way(&world) > 1.5e-3 {
            before = Some((plastic(&world), way(&world)));
        }
    }
    let (before, way_before) = before.unwrap();
    let nodes: Vec<[f64; 2]> = ever.iter().map(|node| watch::place_of_node(&world, *node)).collect();
    let half = 0.5 * job.grid.cell + 1e-9;
    let mut shares = [[0.0; 2]; 3];
    let mut counts = [0.0; 2];
    for point in world.continuum.points.rows() {
        let (at, origin) = (&point.hot.position, &point.cold.origin);
        let side = usize::from(!is_near([origin[0], origin[1]]));
        counts[side] += 1.0;
        let strain = law.plastic_strain(&point.hot.memory);
        // A quarter of what compression by that way alone comes to.
        let even = |way: f64| 0.25 * way / height;
        let flagged = nodes.iter().any(|node| (at[0] - node[0]).abs() <= half && (at[1] - node[1]).abs() <= half);
        let says =
            [flagged, strain - before[&point.cold.id] > even(way(&world) - way_before), strain > even(way(&world))];
        for (share, says) in shares.iter_mut().zip(says) {
            share[side] += f64::from(u8::from(says));
        }
    }
    let [by_oracle, by_rate, by_strain] = shares.map(|share| [share[0] / counts[0], share[1] / counts[1]]);
    TriaxialStory { strain, band, by_oracle, by_rate, by_strain, inclination: angle * 180.0 / math::PI }
}

/// Figures 4 and 5, third column: the band that crosses the specimen from the weak place is flagged and nothing else is, while
/// the rate and the sum of strain call corners of the specimen a band as well.
#[test]
fn a_diagonal_band_in_a_membrane_is_all_that_is_flagged() {
    let story = triaxial();
    println!(
        "fired at {:.4}, {} nodes at {:.1} degrees; oracle {:?}, rate {:?}, strain {:?}",
        story.strain,
        story.band.len(),
        story.inclination,
        story.by_oracle,
        story.by_rate,
        story.by_strain
    );
    assert!((0.002..0.01).contains(&story.strain), "{}", story.strain);
    // Steeper than 45 degrees, by a half of the angle of friction or dilation at most.
    assert!((-65.0..-45.0).contains(&story.inclination), "{}", story.inclination);
    let across = |axis: usize| {
        let values = story.band.iter().map(|place| place[axis]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    assert!(across(0) > 0.85 * 0.0597 && across(1) > 0.05, "{} by {}", across(0), across(1));
    assert!(story.by_oracle[0] > 0.2 && story.by_oracle[1] < 0.01, "{:?}", story.by_oracle);
    // Of the nodes elsewhere the rate flags 0.03 and the sum 0.04; above 0.05 with plates that hold nodes.
    assert!(story.by_rate[0] > 0.8 && story.by_rate[1] > 0.02, "{:?}", story.by_rate);
    assert!(story.by_strain[0] > 0.8 && story.by_strain[1] > 0.03, "{:?}", story.by_strain);
}

/// With one and the same weak region the dense specimen softens into a band there, while in the loose one it hardens until
/// it is like the rest: what is flagged on the way does not persist.
#[test]
fn a_weak_region_makes_a_band_in_a_dense_specimen_and_heals_in_a_loose_one() {
    let weak = [CRITICAL, "material.dilation_factor=7", "continuum.weak.0.fraction_deficit=0.002"];
    let both = [&weak[..], &["material.softening_rate=20", "loading.strain_end=0.1"]].concat();
    let dense = watched(&[&[DENSE], &both[..]].concat());
    assert!(dense.fired.is_some());
    let rows: BTreeSet<u64> = dense.flagged.iter().map(|node| node / 4).collect();
    assert!(rows.is_subset(&rows_between(15e-3, 21e-3)), "flagged rows {rows:?}");
    let loose = watched(&[&[LOOSE], &both[..]].concat());
    assert_eq!((loose.fired, &loose.flagged[..]), (None, &[][..]));
    assert!(!loose.rows_ever.is_empty(), "the weak region should have shown for a while");
}

/// Both windows are measured in strain: at twice the speed the oracle fires at the same strain within one look.
#[test]
fn detection_does_not_depend_on_the_rate() {
    let at = |speed: &str, ramp: &str| {
        let story = watched(&[DENSE, CRITICAL, "loading.strain_end=0.05", speed, ramp]);
        (story.fired.expect("the oracle stayed silent"), story.flagged)
    };
    let ((strain, clock, looks), flagged) = at("loading.speed=5 cm/s", "loading.speed_ramp=2 ms");
    let ((strain_fast, clock_fast, looks_fast), flagged_fast) = at("loading.speed=10 cm/s", "loading.speed_ramp=1 ms");
    let look = [strain, clock].map(|whole| whole / looks as f64);
    assert!((strain_fast - strain).abs() < look[0], "strain {strain_fast} and {strain}, a look is {}", look[0]);
    assert!((clock_fast - clock).abs() < look[1], "clock {clock_fast} and {clock}, a look is {}", look[1]);
    assert!(looks_fast.abs_diff(looks) <= 1, "{looks_fast} and {looks} looks");
    assert_eq!(flagged_fast, flagged);
}

const CELL: f64 = 3e-3;
const DIAMETER: f64 = 1e-3;
const SETTINGS: Laplacian =
    Laplacian { laplacian: 0.08, recent_strain: 1e-3, window: 8e-3, persistence: 8e-3, tolerance: 0.0 };
const ORACLE: Oracle = Oracle { criterion: Criterion::Laplacian(SETTINGS), every: 1 };

/// A column of nodes, 3 wide and periodic, with a Gaussian rate of `width` cells about the middle row; the recent strain is
/// the rate times `recent`.
fn gaussian(width: f64, recent: f64) -> NodeFields {
    let mut fields = NodeFields::empty([3, 61]);
    for row in 0..61 {
        let place = (f64::from(row) - 30.0) / width;
        let rate = math::exp(-0.5 * place * place);
        for column in 0..3 {
            let node = row as usize * 3 + column;
            (fields.present[node], fields.rate[node], fields.recent[node]) = (true, rate, recent * rate);
        }
    }
    fields
}

fn flagged_rows(fields: &NodeFields, settings: &Laplacian, cell: f64) -> Vec<i64> {
    let nodes = fields.flagged(settings, cell, DIAMETER);
    let rows: Vec<i64> = nodes.iter().map(|node| (node / 3) as i64 - 30).collect();
    assert!(rows.chunks(3).all(|row| row.len() == 3 && row[0] == row[2]), "whole rows: {nodes:?}");
    rows.into_iter().step_by(3).collect()
}

/// Figure 3 in one dimension. For a Gaussian of s cells lap e/e = ((y/s)^2 - 1)/s^2, so the boundary of the band stands out:
/// between the threshold's reach on either flank nothing is flagged, and the tails drop out for want of recent strain.
#[test]
fn the_flanks_of_a_gaussian_band_are_flagged_and_nothing_else() {
    let width = 4.0;
    let fields = gaussian(width, 0.05);
    let rows = flagged_rows(&fields, &SETTINGS, CELL);
    let (inner, outer) = (rows.iter().map(|row| row.abs()).min(), rows.iter().map(|row| row.abs()).max());
    // |lap e|/max e around > 0.08 from y = 1.8 s on, recent strain > 1e-3 up to y = 2.8 s.
    assert_eq!((inner, outer), (Some(7), Some(11)), "{rows:?}");
    let mirrored: Vec<i64> = rows.iter().rev().map(|row| -row).collect();
    assert_eq!(rows, mirrored);
    let upper: Vec<i64> = rows.iter().copied().filter(|row| *row > 0).collect();
    assert_eq!(upper, (7..=11).collect::<Vec<i64>>());
    // At a lower threshold the core bends enough as well, and only the inflection at y = s stays out.
    let low = Laplacian { laplacian: 0.01, ..SETTINGS };
    let rows = flagged_rows(&fields, &low, CELL);
    assert!(rows.contains(&0) && !rows.contains(&4) && !rows.contains(&-4) && rows.contains(&8), "{rows:?}");
    // Twice the work flags more of the tail, none flags nothing.
    assert!(flagged_rows(&gaussian(width, 0.1), &SETTINGS, CELL).contains(&12));
    assert!(flagged_rows(&gaussian(width, 1e-4), &SETTINGS, CELL).is_empty());
}

/// Only the shape of the rate counts, not its magnitude.
#[test]
fn the_rate_has_no_scale() {
    let fields = gaussian(4.0, 0.05);
    let wanted = fields.flagged(&SETTINGS, CELL, DIAMETER);
    for scale in [1e-12, 3.0, 1e9] {
        let mut scaled = fields.clone();
        scaled.rate.iter_mut().for_each(|rate| *rate *= scale);
        assert_eq!(scaled.flagged(&SETTINGS, CELL, DIAMETER), wanted);
    }
    let mut still = fields;
    still.rate.fill(0.0);
    assert!(still.flagged(&SETTINGS, CELL, DIAMETER).is_empty());
}

/// The threshold is the lower of c0/D50^2 and c0/dX^2: cells larger than grains do not raise it, smaller ones lower what
/// is seen per cell.
#[test]
fn the_threshold_knows_grains_and_cells() {
    let fields = gaussian(4.0, 0.05);
    let coarse = flagged_rows(&fields, &SETTINGS, 2.0 * DIAMETER);
    assert_eq!(coarse, flagged_rows(&fields, &SETTINGS, 5.0 * DIAMETER));
    // Of a cell of half a grain a quarter of the bend per cell is asked.
    let quarter = Laplacian { laplacian: 0.25 * SETTINGS.laplacian, ..SETTINGS };
    assert_eq!(flagged_rows(&fields, &SETTINGS, 0.5 * DIAMETER), flagged_rows(&fields, &quarter, DIAMETER));
    assert_ne!(flagged_rows(&fields, &SETTINGS, 0.5 * DIAMETER), coarse);
}

/// Even flow bends nowhere, and neither does its edge: beyond the material the rate goes on level.
#[test]
fn even_flow_is_no_band() {
    let mut fields = NodeFields::empty([4, 9]);
    for node in 8..28 {
        (fields.present[node], fields.rate[node], fields.recent[node]) = (true, 0.7, 1.0);
    }
    let settings = Laplacian { laplacian: 1e-9, ..SETTINGS };
    assert!(fields.flagged(&settings, CELL, DIAMETER).is_empty());
    // A bend across the period is seen from both sides of it.
    fields.rate[16] = 1.4;
    let flagged = fields.flagged(&settings, CELL, DIAMETER);
    assert_eq!(flagged, [12, 16, 17, 19, 20]);
}

/// The clock is the sum of the fastest point's strain; a look's window begins at the last look at least a window ago.
#[test]
fn the_strain_clock_keeps_its_window() {
    let mut random = Random(5);
    let mut memory = Memory::default();
    let (mut clock, mut history): (f64, Vec<f64>) = (0.0, Vec::new());
    assert_eq!(memory.slot_last(), None);
    assert!(!memory.due(0.99 * SETTINGS.window / 8.0, &ORACLE) && memory.due(SETTINGS.window / 8.0, &ORACLE));
    for look in 0..200 {
        // From just due to beyond the whole window.
        let increment =
            SETTINGS.window / 8.0 * (1.0 + 4.0 * (random.signed() + 1.0) * f64::from(u8::from(look % 3 == 0)));
        let (slot, begin) = memory.look(increment, &ORACLE);
        clock += increment;
        assert_eq!((slot, memory.slot_last()), (look % LOOKS, Some(slot)));
        assert!((memory.clock - clock).abs() < 1e-12);
        let wanted = history.iter().rposition(|then| *then <= memory.clock - SETTINGS.window);
        assert_eq!(begin, wanted.map(|look| look % LOOKS), "look {look}");
        assert!(wanted.is_none_or(|wanted| look - wanted <= LOOKS), "the window reaches further than the memory");
        history.push(memory.clock);
    }
}

/// A share of the set may come and go from look to look; more of it begins anew, and so does a set that is gone.
#[test]
fn a_band_may_flicker_within_its_tolerance() {
    let settings = Laplacian { tolerance: 0.5, ..SETTINGS };
    let mut memory = Memory::default();
    let mut look = |flagged: &[u64]| {
        memory.look(settings.persistence / 2.0, &ORACLE);
        memory.persists(flagged.to_vec(), &settings)
    };
    assert!(!look(&[1, 2, 3, 4]));
    assert!(!look(&[1, 2, 3]), "half of the window");
    assert!(look(&[1, 2, 3, 9]), "one of four comes");
    assert!(look(&[1, 2, 9, 10]), "one goes and one comes: half, and no more");
    assert!(!look(&[1, 2]), "two of two have gone");
    assert!(!look(&[]));
    assert!(!look(&[1, 2]));
    assert!(!look(&[1, 2]));
    assert!(look(&[1, 2]));
}

/// A flagged set is a band once it has stayed as it is for c_g on the strain clock; any change begins anew.
#[test]
fn a_band_must_persist() {
    let mut memory = Memory::default();
    let mut look = |flagged: &[u64]| {
        memory.look(SETTINGS.persistence / 4.0, &ORACLE);
        memory.persists(flagged.to_vec(), &SETTINGS)
    };
    let said: Vec<bool> = [
        &[][..],
        &[],
        &[],
        &[],
        &[],
        &[], // never without a flagged node
        &[3, 4],
        &[3, 4],
        &[3, 4],
        &[3, 4], // not yet
        &[3, 4, 5],
        &[3, 4, 5],
        &[3, 4, 5],
        &[3, 4, 5], // one more node: from the beginning
        &[3, 4, 5],
        &[3, 4, 5], // a window after the change
        &[],
        &[3, 4, 5],
        &[3, 4, 5], // gone for one look
    ]
    .into_iter()
    .map(&mut look)
    .collect();
    let fired: Vec<usize> = said.iter().enumerate().filter(|(_, said)| **said).map(|(look, _)| look).collect();
    assert_eq!(fired, [14, 15]);
}

const BOX: Concentration = Concentration::DEFAULT;

/// Rows of nodes, 6 wide and periodic, that have grown by these within the window.
fn grown(rows: &[f64]) -> NodeFields {
    let mut fields = NodeFields::empty([6, rows.len()]);
    for (node, present) in fields.present.iter_mut().enumerate() {
        *present = true;
        fields.recent[node] = rows[node / 6];
        fields.rate[node] = 100.0 * rows[node / 6];
    }
    fields
}

/// Participation of a band w wide in a box L long is w/L, and of even flow 1.
#[test]
fn participation_is_the_share_of_a_box_that_a_band_takes() {
    let (flagged, participation) = grown(&[3e-3; 21]).concentrated(&BOX, 3, 0.0);
    assert!(flagged.is_empty() && (participation - 1.0).abs() < 1e-12, "{participation}");
    let mut rows = [0.0; 21];
    rows[10] = 2e-2;
    let (flagged, participation) = grown(&rows).concentrated(&BOX, 3, 0.0);
    assert!((participation - 1.0 / 7.0).abs() < 1e-12, "{participation}");
    assert_eq!(flagged, (60..66).collect::<Vec<u64>>());
    // At the end of the material boxes are cut: there it is a row of four.
    let mut rows = [0.0; 4];
    rows[0] = 2e-2;
    let (flagged, participation) = grown(&rows).concentrated(&BOX, 3, 0.0);
    assert!((participation - 0.25).abs() < 1e-12, "{participation}");
    assert_eq!(flagged, (0..6).collect::<Vec<u64>>());
}

/// What grows by less than the window is no band, however alone it does; nor is what shears more slowly than counts.
#[test]
fn a_band_grows_by_more_than_the_window() {
    let mut rows = [0.0; 21];
    rows[10] = 0.99 * BOX.window;
    assert!(grown(&rows).concentrated(&BOX, 3, 0.0).0.is_empty());
    rows[10] = 1.01 * BOX.window;
    assert_eq!(grown(&rows).concentrated(&BOX, 3, 0.0).0.len(), 6);
    assert_eq!(grown(&rows).concentrated(&BOX, 3, BOX.window), (Vec::new(), 0.0));
    // Contrast: twice the calmer half of the box does not do, where that may shear on.
    let by = Concentration { participation: 0.99, calm: 1.0, ..BOX };
    let rows: Vec<f64> = (0..21).map(|row| if row == 10 { 1.9e-2 } else { 1e-2 }).collect();
    assert!(grown(&rows).concentrated(&by, 3, 0.0).0.is_empty());
    let rows: Vec<f64> = (0..21).map(|row| if row == 10 { 2.1e-2 } else { 1e-2 }).collect();
    assert_eq!(grown(&rows).concentrated(&by, 3, 0.0).0.len(), 6);
}

/// While what is beside it shears on, the place of a band is not settled: the calmer half of the box, three rows of seven and half of another, has to stand still.
#[test]
fn what_is_beside_a_band_stands_still() {
    let rows = |beside: f64| -> Vec<f64> { (0..21).map(|row| if row == 10 { 2e-2 } else { beside }).collect() };
    // The mean of the box is (2e-2 + 6 b)/7, of which 5 % are b.
    let limit = 0.05 * 2e-2 / (7.0 - 6.0 * 0.05);
    assert_eq!(grown(&rows(0.99 * limit)).concentrated(&BOX, 3, 0.0).0, (60..66).collect::<Vec<u64>>());
    assert!(grown(&rows(1.01 * limit)).concentrated(&BOX, 3, 0.0).0.is_empty());
}

/// A band has softened by more than packings differ: it has sheared by so much more than the calmer half of its box.
#[test]
fn a_band_has_sheared_more_than_what_is_beside_it() {
    let mut rows = [0.0; 21];
    rows[10] = 2e-2;
    let mut fields = grown(&rows);
    let mut flagged = |beyond: f64| -> usize {
        (0..126).for_each(|node| fields.rate[node] = if node / 6 == 10 { 1e-2 + beyond } else { 1e-2 });
        fields.concentrated(&BOX, 3, 0.0).0.len()
    };
    assert_eq!([0.99, 1.01].map(|share| flagged(share * BOX.excess)), [0, 6]);
}

/// A box as wide as the period holds every node once; without a period it ends where the grid does.
#[test]
fn boxes_know_the_period() {
    let mut fields = grown(&[1.0; 9]);
    fields.rate = vec![0.0; 54];
    fields.rate[4 * 6] = 1.0;
    let mean = |fields: &NodeFields, reach| fields.fastest_box(&fields.rate, reach);
    assert_eq!(mean(&fields, 1), 1.0 / 9.0);
    assert_eq!(mean(&fields, 2), 1.0 / 25.0);
    // Cut by the end of the material: five rows of six.
    assert_eq!(mean(&fields, 3), 1.0 / 30.0);
    fields.is_periodic = false;
    assert_eq!(mean(&fields, 1), 1.0 / 6.0);
}

/// A dense specimen that hardens before it softens shears evenly, and then in a band at its weak row; a loose one hardens on, with a weak region or without, and the oracle
/// is silent. It is where a material is elastic up to its cone, too: such a band is there from the first plastic strain on, and nothing sharpens.
#[test]
fn concentration_tells_a_dense_specimen_from_a_loose_one() {
    let mut scenario = mobilised(&["method=mpm", "loading.strain_end=0.15"]);
    scenario.oracle.criterion = Criterion::Concentration(BOX);
    let dense = story_of(&scenario);
    let (strain, ..) = dense.fired.expect("the oracle stayed silent");
    println!("dense: fired at {strain}, rows {:?}", dense.rows_ever);
    let rows: BTreeSet<u64> = dense.flagged.iter().map(|node| node / 4).collect();
    assert!(!rows.is_empty() && rows.is_subset(&rows_between(12e-3, 24e-3)), "flagged rows {rows:?}");
    let elastic_first = watched_for_concentration(&[DENSE, CRITICAL, "loading.strain_end=0.1"]);
    assert_eq!(elastic_first.fired, None);
    for deficit in ["0", "0.002"] {
        let weak = format!("continuum.weak.0.fraction_deficit={deficit}");
        let loose = [LOOSE, CRITICAL, "material.dilation_factor=7", "loading.strain_end=0.1", &weak];
        let loose = watched_for_concentration(&loose);
        assert_eq!((loose.fired, loose.flagged), (None, Vec::new()), "deficit {deficit}");
        assert!(loose.plastic_max > 0.02, "it should have flowed: {}", loose.plastic_max);
    }
}

/// Shear that concentrates more and more is a band, as soon as what is beside it stands still; one that stays as it is, is none, unless it has been one before.
#[test]
fn a_band_sharpens() {
    let oracle = Oracle { criterion: Criterion::Concentration(BOX), every: 1 };
    let story = |participations: &[f64], settled: usize| -> Vec<usize> {
        let (mut memory, mut found) = (Memory::default(), Vec::new());
        for (look, participation) in participations.iter().enumerate() {
            let (slot, begin) = memory.look(BOX.window / 4.0, &oracle);
            memory.seen[slot].participation = *participation;
            let flagged = if look < settled { Vec::new() } else { vec![7] };
            if begin.is_some_and(|begin| memory.sharpens(flagged, begin, &BOX)) {
                found.push(look);
            }
        }
        found
    };
    // Slowly, as what is uneven from the start does, it may fall as far as it likes.
    let slowly: Vec<f64> = (0..60).map(|look| 0.98f64.powi(look)).collect();
    assert!(story(&slowly, 0).is_empty());
    let fast: Vec<f64> = (0..20).map(|look| if look < 10 { 0.9 } else { 0.9 * 0.93f64.powi(look - 10) }).collect();
    let found = story(&fast, 0);
    assert_eq!(found[0], 14, "0.93^4 is below 0.8: {found:?}");
    assert_eq!(found[1], 18, "a window later it stands: {found:?}");
    assert_eq!(story(&fast, 17)[0], 17, "it has sharpened before it settles");
}
